//! Shadow energies: quantities that RATTLE conserves to a higher order than the energy. They show faults that the
//! energy does not.
//!
//! A symplectic method follows a nearby mechanical system almost exactly. The energy of that system differs from H by
//! O(h²) and is conserved to rounding, or to exp(−c/h). Two approximations of it, for constraints that do not move:
//!
//! ```text
//! H₂ = H + h² ( aᵀM a/24 + Ü/12 ),   a = M⁻¹(f + Gᵀλ),   Ü = d²U/dt² along the motion      from one state, to h⁴
//!
//! E  = U + Σₖ 2h²ᵏ⁻²/(2k)! ( Σⱼ₌₁ᵏ⁻¹ (−1)ʲ⁻¹ ⟨x⁽ʲ⁾, M x⁽²ᵏ⁻ʲ⁾⟩ + (−1)ᵏ⁻¹ ⟨x⁽ᵏ⁾, M x⁽ᵏ⁾⟩/2 ),   k = 1 … K   from positions
//! ```
//!
//! Here x is the smooth curve through the positions, with its derivatives from differences of 2K + 1 positions; E is
//! conserved to h²ᴷ. E is the energy of (2M/h²)(cosh hD − 1) x = f + Gᵀλ, D = d/dt, the equation for the positions of
//! RATTLE, SHAKE and, without constraints, the leapfrog method; momenta do not enter. H₂ needs momenta tangent to the
//! constraints, and is for RATTLE alone. Neither holds for a composition, whose inner steps differ in length.

use crate::error::Error;
use crate::motion::capability::Rates;
use crate::motion::method::Method;
use crate::motion::system::System;
use crate::number::vector::{add_scaled, scaled, sum};
use crate::run::simulation::Simulation;
use crate::run::watch::observer::Observer;
use crate::run::watch::sight::Sight;
use nalgebra::SVector;
use std::collections::VecDeque;

impl<Y: System<f64, D>, S: Method, const D: usize> Simulation<Y, S, D> {
    /// The shadow energy H₂ of the present state, which RATTLE conserves to h⁴, and the energy only to h². NaN in phase
    /// space, which has no masses.
    ///
    /// ```
    /// # use rattle::{Rattle, Scene, State};
    /// let mut simulation = Scene::point().simulate(State::at([0.0]).moving([1.0]), Rattle::new(0.1))?;
    /// assert_eq!(simulation.shadow_energy(), simulation.energy()); // nothing acts
    /// # Ok::<(), rattle::Error>(())
    /// ```
    #[doc(alias = "modified Hamiltonian")]
    pub fn shadow_energy(&self) -> f64 {
        let (system, h) = (self.system(), self.method().step_size());
        let mut accelerations = vec![[0.0; D]; self.bodies()];
        let (Ok(masses), Ok(())) = (system.rates(), system.accelerations(&self.bodies, &mut accelerations))
        else {
            return f64::NAN;
        };
        let square = |(body, a)| masses.mass_product(body, a, a);
        let acceleration_square: f64 = accelerations.iter().enumerate().map(square).sum();

        // Ü by differences of fourth order along q + v s + a s²/2.
        let s = 0.5 * h;
        let potential_at = |s: f64| {
            let mut displaced = self.bodies.clone();
            for (body, (q, a)) in displaced.q.as_mut().iter_mut().zip(&accelerations).enumerate() {
                let v = system.velocity(&self.bodies, body);
                *q = sum(q, &add_scaled(&scaled(s, &v), 0.5 * s * s, a));
            }
            system.potential_energy(&displaced)
        };
        let here = self.potential_energy();
        let near = potential_at(s) + potential_at(-s) - 2.0 * here;
        let far = potential_at(2.0 * s) + potential_at(-2.0 * s) - 2.0 * here;
        let bend = (16.0 * near - far) / (12.0 * s * s);
        self.energy() + h * h * (acceleration_square / 24.0 + bend / 12.0)
    }
}

/// Records the shadow energy E of a run, from positions alone. It must see every step: where steps are missing between
/// two sights, the trajectory changes, or momenta [jump](Observer::jump), at impacts and edges, it begins again. (For
/// an ensemble use one for each trajectory: [`Each`](crate::run::watch::Each).)
///
/// ```
/// # use rattle::{Rattle, Scene, watch::{Each, ShadowEnergy}, State};
/// # let scene = Scene::points(1);
/// # let start = State::at([0.0]).moving([1.0]);
/// let mut simulation = scene.simulate(start.clone(), Rattle::new(0.1))?;
/// let mut shadow = ShadowEnergy::new(4)?;
/// simulation.observe(10, 1, &mut shadow)?;
/// assert_eq!(shadow.values().len(), 10 + 1 - 4);
/// assert!(shadow.values().iter().all(|e| (e - 0.5).abs() < 1e-13));
///
/// let mut ensemble = scene.ensemble([start.clone(), start], Rattle::new(0.1))?;
/// let new = ShadowEnergy::new(4)?;
/// let shadows = ensemble.observe(10, 1, || Each::of(|| new.clone()));
/// assert!((shadows.get(1).unwrap().values()[6] - 0.5).abs() < 1e-13);
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "modified Hamiltonian")]
#[derive(Debug, Clone)]
pub struct ShadowEnergy<const D: usize> {
    form: Vec<Vec<f64>>,
    /// The last 2K + 1 steps.
    window: VecDeque<Place<D>>,
    /// Whether momenta have jumped since the last sight.
    jumped: bool,
    values: Vec<f64>,
}

/// Where a trajectory was after a step.
#[derive(Debug, Clone)]
struct Place<const D: usize> {
    trajectory: usize,
    step: u64,
    positions: Vec<SVector<f64, D>>,
    potential: f64,
}

impl<const D: usize> ShadowEnergy<D> {
    /// An observer of E with 2K = `order`, one of 2, 4, … 12, which is conserved to h to this power.
    ///
    /// # Errors
    /// [`Error::ShadowOrder`] for any other order.
    pub fn new(order: usize) -> Result<Self, Error> {
        let form = quadratic_form(order)?;
        Ok(Self { form, window: VecDeque::new(), jumped: false, values: Vec::new() })
    }

    /// E at the steps that have K steps before and K after them.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }
}

impl<const D: usize> ShadowEnergy<D> {
    fn place(&mut self, sight: &Sight<'_, D>) {
        // The oldest step's memory is used again.
        let mut positions = match self.window.len() == self.form.len() {
            true => self.window.pop_front().map_or_else(Vec::new, |oldest| oldest.positions),
            false => Vec::new(),
        };
        positions.clear();
        positions.extend_from_slice(sight.positions);
        let (trajectory, step, potential) = (sight.trajectory, sight.step, sight.potential_energy());
        self.window.push_back(Place { trajectory, step, positions, potential });
    }
}

impl<const D: usize> Observer<D> for ShadowEnergy<D> {
    fn see(&mut self, before: &Sight<'_, D>, now: &Sight<'_, D>) {
        let follows =
            |last: &Place<D>| last.trajectory == now.trajectory && last.step.checked_add(1) == Some(now.step);
        let smooth = !std::mem::take(&mut self.jumped);
        if !(smooth && self.window.back().is_some_and(follows)) {
            self.window.clear();
            if smooth && before.step.checked_add(1) == Some(now.step) {
                self.place(before);
            }
        }
        self.place(now);
        let width = self.form.len();
        if self.window.len() < width {
            return;
        }
        let Place { positions: middle, potential, .. } = &self.window[width / 2];
        let h = now.step_size();
        let mut kinetic = 0.0;
        for (body, origin) in middle.iter().enumerate() {
            let away: Vec<[f64; D]> =
                self.window.iter().map(|place| ((place.positions[body] - origin) / h).into()).collect();
            for (row, a) in self.form.iter().zip(&away) {
                for (c, b) in row.iter().zip(&away) {
                    kinetic += c * now.mass_product(body, a, b);
                }
            }
        }
        self.values.push(potential + kinetic);
    }

    fn sees_jumps(&self) -> bool {
        true
    }

    fn jump(&mut self, _from: &Sight<'_, D>, _before: &Sight<'_, D>, _after: &Sight<'_, D>) {
        self.jumped = true;
    }

    fn join(&mut self, next: Self) {
        self.window.clear();
        self.values.extend(next.values);
    }
}

/// C in E = U(qₙ) + h⁻² Σᵢⱼ Cᵢⱼ ⟨qₙ₊ᵢ − qₙ, M (qₙ₊ⱼ − qₙ)⟩ for the order 2K, i and j = −K … K.
///
/// # Errors
/// [`Error::ShadowOrder`] if the order is not one of 2, 4, … 12.
pub fn quadratic_form(order: usize) -> Result<Vec<Vec<f64>>, Error> {
    if !(order.is_multiple_of(2) && (2..=12).contains(&order)) {
        return Err(Error::ShadowOrder(order));
    }
    let (half, width) = (order / 2, order + 1);
    let derivative = central_differences(half);
    let mut form = vec![vec![0.0; width]; width];
    let mut share = 2.0; // 2/(2k)!
    for k in 1..=half {
        share /= ((2 * k - 1) * (2 * k)) as f64;
        for j in 1..=k {
            let sign = if j % 2 == 1 { 1.0 } else { -1.0 };
            let (a, b) = (&derivative[j], &derivative[2 * k - j]);
            for (row, (a_i, b_i)) in form.iter_mut().zip(a.iter().zip(b)) {
                for (entry, (a_j, b_j)) in row.iter_mut().zip(a.iter().zip(b)) {
                    let product = 0.5 * (a_i * b_j + b_i * a_j);
                    *entry += sign * share * if j == k { 0.5 * product } else { product };
                }
            }
        }
    }
    Ok(form)
}

/// Weights of all derivatives at 0 from values at −K … K (B. Fornberg, Math. Comp. 51 (1988) 699).
fn central_differences(half: usize) -> Vec<Vec<f64>> {
    let points: Vec<f64> = (0..=2 * half).map(|i| i as f64 - half as f64).collect();
    let n = points.len();
    let mut weights = vec![vec![0.0; n]; n];
    weights[0][0] = 1.0;
    let mut before = 1.0; // Π (xᵢ₋₁ − xⱼ)
    for i in 1..n {
        let mut product = 1.0;
        for j in 0..i {
            product *= points[i] - points[j];
        }
        for k in (0..=i).rev() {
            let lower = if k > 0 { k as f64 * weights[k - 1][i - 1] } else { 0.0 };
            weights[k][i] = before / product * (lower - points[i - 1] * weights[k][i - 1]);
        }
        for j in 0..i {
            for k in (0..=i).rev() {
                let lower = if k > 0 { k as f64 * weights[k - 1][j] } else { 0.0 };
                weights[k][j] = (points[i] * weights[k][j] - lower) / (points[i] - points[j]);
            }
        }
        before = product;
    }
    weights
}
