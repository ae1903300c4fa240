//! Shadow energies: what RATTLE keeps to a higher order than the energy, and so sees faults that the energy does not show.
//!
//! A symplectic method follows a nearby mechanical system almost exactly; its energy differs from H by O(h²) and is kept
//! to rounding, or to exp(−c/h). Two approximations, for constraints at rest:
//!
//! ```text
//! H₂ = H + h² ( aᵀM a/24 + Ü/12 ),   a = M⁻¹(f + Gᵀλ),   Ü = d²U/dt² along the motion      from one state, to h⁴
//!
//! E  = U + Σₖ 2h²ᵏ⁻²/(2k)! ( Σⱼ₌₁ᵏ⁻¹ (−1)ʲ⁻¹ ⟨x⁽ʲ⁾, M x⁽²ᵏ⁻ʲ⁾⟩ + (−1)ᵏ⁻¹ ⟨x⁽ᵏ⁾, M x⁽ᵏ⁾⟩/2 ),   k = 1 … K   from positions
//! ```
//!
//! x is the smooth curve through the positions, its derivatives differences of 2K + 1 of them: E is kept to h²ᴷ.
//! It is the energy of (2M/h²)(cosh hD − 1) x = f + Gᵀλ, the equation of the positions of RATTLE, SHAKE and, without
//! constraints, of the leapfrog; momenta do not enter. H₂ is that of momenta along the constraints, of RATTLE alone.
//! A composition's inner steps are not even, and neither holds for it.

use crate::motion::capability::Rates;
use crate::motion::method::Method;
use crate::motion::system::System;
use crate::number::vector::{add_scaled, scaled, sum};
use crate::run::recorder::Recorder;
use crate::run::simulation::Simulation;
use std::collections::VecDeque;

impl<Y: System<f64, D>, S: Method, const D: usize> Simulation<Y, S, D> {
    /// The shadow energy H₂ of the present state: kept by RATTLE to h⁴ where the energy is kept to h². NaN in phase space, where no
    /// masses are known.
    ///
    /// ```
    /// # use rattle::{Rattle, Scene, State};
    /// let mut simulation = Scene::point().simulate(State::at([0.0]).moving([1.0]), Rattle::new(0.1))?;
    /// assert_eq!(simulation.shadow_energy(), simulation.energy()); // nothing acts
    /// # Ok::<(), rattle::Error>(())
    /// ```
    pub fn shadow_energy(&self) -> f64 {
        let (system, h) = (self.system(), self.method().step_size());
        let mut accelerations = vec![[0.0; D]; self.len()];
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

/// Records the shadow energy E of a run, from positions alone.
///
/// ```
/// # use rattle::{Rattle, Scene, shadow::ShadowEnergy, State};
/// let mut simulation = Scene::point().simulate(State::at([0.0]).moving([1.0]), Rattle::new(0.1))?;
/// let mut shadow = ShadowEnergy::of(&simulation, 4);
/// simulation.run_recording(10, &mut shadow)?;
/// assert_eq!(shadow.values().len(), 10 + 1 - 4);
/// assert!(shadow.values().iter().all(|e| (e - 0.5).abs() < 1e-13));
/// # Ok::<(), rattle::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct ShadowEnergy<const D: usize> {
    form: Vec<Vec<f64>>,
    /// Positions and potential energies of the last 2K + 1 steps.
    window: VecDeque<(Vec<[f64; D]>, f64)>,
    values: Vec<f64>,
}

impl<const D: usize> ShadowEnergy<D> {
    /// A recorder of E that is kept to h to the power of `order`, 2K, from the present state on.
    ///
    /// # Panics
    /// If the order is not one of 2, 4, … 12: higher ones drown in the rounding of positions.
    #[track_caller]
    pub fn of<Y: System<f64, D>, S: Method>(simulation: &Simulation<Y, S, D>, order: usize) -> Self {
        let mut shadow = Self { form: quadratic_form(order), window: VecDeque::new(), values: Vec::new() };
        shadow.record(simulation);
        shadow
    }

    /// E at the steps that have K steps before and K after them.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }
}

impl<Y: System<f64, D>, S: Method, const D: usize> Recorder<Simulation<Y, S, D>> for ShadowEnergy<D> {
    fn record(&mut self, simulation: &Simulation<Y, S, D>) {
        let width = self.form.len();
        if self.window.len() == width {
            self.window.pop_front();
        }
        let positions = simulation.positions().map(Into::into).collect();
        self.window.push_back((positions, simulation.potential_energy()));
        if self.window.len() < width {
            return;
        }
        let (middle, potential) = &self.window[width / 2];
        let h = simulation.method().step_size();
        let masses = simulation.system().rates();
        let product = |body, a: &[f64; D], b: &[f64; D]| {
            masses.as_ref().map_or(f64::NAN, |masses| masses.mass_product(body, a, b))
        };
        let mut kinetic = 0.0;
        for (body, origin) in middle.iter().enumerate() {
            let away: Vec<_> = self
                .window
                .iter()
                .map(|(q, _)| scaled(1.0 / h, &add_scaled(&q[body], -1.0, origin)))
                .collect();
            for (row, a) in self.form.iter().zip(&away) {
                for (c, b) in row.iter().zip(&away) {
                    kinetic += c * product(body, a, b);
                }
            }
        }
        self.values.push(potential + kinetic);
    }
}

/// C in E = U(qₙ) + h⁻² Σᵢⱼ Cᵢⱼ ⟨qₙ₊ᵢ − qₙ, M (qₙ₊ⱼ − qₙ)⟩ for the order 2K, i and j = −K … K.
///
/// # Panics
/// If the order is not one of 2, 4, … 12.
#[must_use]
#[track_caller]
pub fn quadratic_form(order: usize) -> Vec<Vec<f64>> {
    assert!(order.is_multiple_of(2) && (2..=12).contains(&order), "orders are 2, 4, … 12, not {order}");
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
    form
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
