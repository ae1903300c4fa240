//! DOP853: the explicit Runge–Kutta method of order 8 of Dormand and Prince, projected onto the constraints.
//!
//! ```text
//! q̇ = M⁻¹p,   ṗ = f(q) + G(q)ᵀλ,   λ such that g̈ = 0
//! q̂ = q + h Σ bᵢ q̇ᵢ,   p̂ = p + h Σ bᵢ ṗᵢ,   the rates at q + h Σⱼ aᵢⱼ q̇ⱼ and p + h Σⱼ aᵢⱼ ṗⱼ
//! q′ nearest to q̂ with g(q′) = 0,   p′ nearest to p̂ with G(q′) M⁻¹p′ = 0, as masses measure it
//! ```
//!
//! The work of potentials that change with time is booked as W = ∫ ∂U/∂t dt = ΔU + ∫ f·q̇ dt, the integral by the same
//! sum: ∂U/∂t itself may change much faster than the motion that the tolerance is about. U is that of all effects of
//! such a scene, so `energy_error()` compares kinetic energy with the work of forces there: what a force lacks of the
//! slope of its potential does not show. Potentials with a reach find their pairs anew for U, which allocates.
//!
//! Neither symplectic nor reversible: energy drifts. For comparison and for short runs: with a tolerance it is the
//! cheapest method of one body on many surfaces for errors from some 1e-5 to 1e-8 (the example `accuracy`). Each step
//! is then divided into inner steps that keep the tolerance; a step is still a function of the state alone.
//!
//! Source: E. Hairer, S. P. Nørsett, G. Wanner, *Solving Ordinary Differential Equations I*, II.5 and II.10;
//! coefficients as published with their program.

use crate::effect::force::Force;
use crate::effect::list::Forces;
use crate::error::{Error, MethodFailure};
use crate::methods::dop853_table::{ERROR_3, ERROR_5, NODES, STAGES, STEPS, WEIGHTS};
use crate::motion::bodies::{Count, Saved};
use crate::motion::capability::Rates;
use crate::motion::course::{ASTRAY, land, look_inside, moved};
use crate::motion::failure::Failure;
use crate::motion::method::{Method, Projecting, View, check_step_size, check_tolerance};
use crate::motion::need::{Kicks, WithRates};
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::motion::witness::{AtEnd, Witness};
use crate::number::clock::Parts;
use crate::number::real::Scalar;
use crate::number::vector::{add_scaled, dot, scaled, sum, two_sum};

/// Errors are measured by their squares, which for smaller ones are 0.
const LEAST: f64 = 1e-150;
/// Inner steps are made for this part of the error that just passes.
pub(crate) const SAFETY: f64 = 0.9;
/// An inner step is at least and at most so many times as long as the one before.
pub(crate) const CHANGE: (f64, f64) = (1.0 / 3.0, 6.0);
/// The smallest part of a step that is tried.
pub(crate) const SMALLEST_PART: f64 = 1e-6;

/// A step has no more inner steps.
const MOST_INNER: u32 = 1_000_000;
/// The stage in whose place is kept where an inner step led regardless of the constraints: no sum needs it at the end.
const LED: usize = 1;
/// Vectors per body: the rates at the stages.
const ROOM: usize = 2 * STAGES;

/// DOP853 with projection, with fixed steps or with a tolerance.
///
/// ```
/// use rattle::{Dop853, Scene, State};
///
/// let start = State::at([0.0]).moving([1.0]);
/// let mut simulation = Scene::point().simulate(start, Dop853::adaptive(0.5, 1e-12))?;
/// simulation.run(4)?;
/// assert!((simulation.position().x - 2.0).abs() < 1e-12);
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "Runge-Kutta")]
#[doc(alias = "ode")]
#[doc(alias = "RK")]
#[doc(alias = "adaptive")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dop853 {
    h: f64,
    tolerance: Option<f64>,
}

impl Dop853 {
    /// The method with fixed steps of size `h`, in the unit of time. A step that is too long is an error where its end
    /// cannot be projected onto the constraint, where it may lie on another sheet or beyond a kink, where normals turn
    /// over or the energy jumps, and where stages are no numbers. Elsewhere it is inaccurate without a word.
    #[must_use]
    pub fn new(h: f64) -> Self {
        Self { h, tolerance: None }
    }

    /// The method with steps of size `h`, each divided into as many inner steps, at most 10⁶, as the tolerance, a
    /// length, needs: for each body the estimated error |δq| + |h| |δv| of an inner step stays below it.
    ///
    /// The estimate knows of what its twelve stages meet. So `h`, which bounds the inner steps, must not be longer than
    /// what acts is met for: a narrow bump of a potential, or a short pulse, is else passed in silence. Where forces
    /// jump, at branches of potentials (`if`, `abs`, a cut-off), inner steps become as short as 10⁻⁶ h, and what is
    /// left may exceed the tolerance or end the run: [`Taylor`](crate::methods::taylor::Taylor) finds branches.
    #[doc(alias = "dt")]
    #[doc(alias = "tolerance")]
    #[must_use]
    pub fn adaptive(h: f64, tolerance: f64) -> Self {
        Self { h, tolerance: Some(tolerance) }
    }
}

impl Method for Dop853 {
    type Memory<T: Scalar> = [T; 0];
    type Need = (Kicks, WithRates);
    const HAS_STRUCTURE: bool = false;
    const CHECKS: bool = true;
    const PROJECTS: Projecting = Projecting::Dop853;

    fn step_size(&self) -> f64 {
        self.h
    }
    fn order(&self) -> u32 {
        8
    }
    fn name(&self) -> &'static str {
        if self.tolerance.is_some() { "DOP853, adaptive" } else { "DOP853" }
    }
    fn with_step(&self, h: f64) -> Self {
        Self { h, ..*self }
    }
    fn tolerance(&self) -> Option<f64> {
        self.tolerance
    }
    fn parameters(&self) -> Vec<f64> {
        self.tolerance.into_iter().collect()
    }
    fn with_tolerance_times(&self, factor: f64) -> Option<Self> {
        self.tolerance.map(|tolerance| Self { tolerance: Some(tolerance * factor), ..*self })
    }
    fn is_symmetric(&self) -> bool {
        false
    }
    fn check(&self, _: usize) -> Result<(), Error> {
        check_tolerance(self.tolerance)?;
        if let Some(tolerance) = self.tolerance.filter(|&tolerance| tolerance < LEAST) {
            return Err(Error::Tolerance(tolerance));
        }
        check_step_size(self.h)
    }

    fn prepare<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        _: View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
    ) {
        bodies.make_room(ROOM);
    }

    fn step<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        _: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        let n = bodies.q.as_ref().len();
        let inner_steps = bodies.with_room(ROOM, |bodies, saved, room| {
            let inner_steps = self.steps(system, bodies, saved, room, witness)?;
            if W::LISTENS {
                let (_, rates) = system;
                rates.evaluate_rates(bodies, &mut room[..n], &mut AtEnd(witness));
            }
            Ok(inner_steps)
        })?;
        bodies.note_inner_steps(inner_steps);
        Ok(())
    }
}

impl Dop853 {
    /// One step, or inner ones that make it up; returns how many.
    fn steps<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        saved: &mut Saved<Y::Count, T, D>,
        room: &mut [[T; D]],
        witness: &mut W,
    ) -> Result<u32, Failure> {
        let energy = Stages::energy_of(system, bodies);
        let mut stages = Stages::begin(system, bodies, energy, saved, room, witness);
        let Some(tolerance) = self.tolerance else {
            stages.evaluate::<true, _>(system, bodies, self.h)?;
            let landed = stages.arrive(system, bodies, self.h)?;
            return look_inside(self, [self.h; 2], system.0, stages.start, bodies, landed).map(|()| 1);
        };
        let mut parts = Parts::of(self.h, bodies.time);
        let (mut inner, mut made, mut number) = (self.h, 0.0_f64, 0_u32);
        loop {
            let left = parts.left();
            let last = inner.abs() >= left.abs();
            if last {
                inner = left;
            }
            stages.evaluate::<false, _>(system, bodies, inner)?;
            let (error, body) = stages.error(system, bodies, inner, self.h);
            let fitting = SAFETY * (tolerance / error).powf(0.125); // NaN is the smallest
            let fitting = fitting.max(CHANGE.0).min(CHANGE.1);
            if error <= tolerance {
                let landed = stages.arrive(system, bodies, inner)?;
                let (moved, body) =
                    if landed.is_ok() { stages.moved(system, bodies, self.h) } else { (0.0, 0) };
                if moved > ASTRAY * tolerance {
                    system.0.put_back(bodies, stages.start);
                    inner = self.shorter(inner, CHANGE.0, (body, moved), made)?;
                    continue;
                }
                look_inside(self, [left, inner], system.0, stages.start, bodies, landed)?;
                number += 1;
                parts.go(inner);
                bodies.time = parts.time();
                if last {
                    return Ok(number);
                }
                if number >= MOST_INNER {
                    let [h, inner] = [self.h, inner * fitting];
                    let cause = MethodFailure::TooManyInnerSteps { inner, h, tolerance }.into();
                    return Err(Failure { body, cause });
                }
                made = made.max(inner.abs());
                inner *= fitting;
                let energy = stages.energy_at_end;
                stages = Stages::begin(system, bodies, energy, saved, room, &mut ());
            } else {
                inner = self.shorter(inner, fitting, (body, error), made)?;
            }
        }
    }

    /// The inner step that is tried instead of one of a body with such an error, after others of at most `made`.
    fn shorter(
        &self,
        inner: f64,
        fitting: f64,
        (body, error): (usize, f64),
        made: f64,
    ) -> Result<f64, Failure> {
        if inner.abs() * fitting < SMALLEST_PART * self.h.abs() {
            let limits = [self.h, self.tolerance.unwrap_or(f64::NAN)];
            let cause = MethodFailure::of_short_steps([inner, inner * fitting], made, error, limits).into();
            return Err(Failure { body, cause });
        }
        Ok(inner * fitting.min(SAFETY))
    }
}

/// Where an inner step begins, and its rates q̇ and ṗ, stage by stage.
struct Stages<'a, N: Count, T: Scalar, const D: usize> {
    n: usize,
    start: &'a Saved<N, T, D>,
    v: &'a mut [[T; D]],
    f: &'a mut [[T; D]],
    /// What does work at the stages, beside the change of U.
    power: [T; STAGES],
    /// U at the start of the inner step, and at its end once it has arrived there, where U changes with time.
    energy: Option<T>,
    energy_at_end: Option<T>,
}

impl<'a, N: Count, T: Scalar, const D: usize> Stages<'a, N, T, D> {
    /// U where the bodies are, if it changes with time.
    fn energy_of<Y: System<T, D, Count = N>>(
        (system, _): View<'_, Dop853, T, Y, D>,
        bodies: &BodiesOf<Y, T, D>,
    ) -> Option<T> {
        system.effects().changes_with_time().then(|| system.potential_energy(bodies))
    }

    /// Begins where the bodies are, with this energy U if it changes with time, and with the first stage.
    fn begin<Y: System<T, D, Count = N>, W: Witness<T>>(
        system: View<'_, Dop853, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        energy: Option<T>,
        saved: &'a mut Saved<N, T, D>,
        room: &'a mut [[T; D]],
        witness: &mut W,
    ) -> Self {
        let n = bodies.q.as_ref().len();
        let (v, f) = room.split_at_mut(STAGES * n);
        bodies.save(saved);
        let power = [T::from_f64(0.0); STAGES];
        let mut stages = Self { n, start: saved, v, f, power, energy, energy_at_end: None };
        stages.rates(system, bodies, 0, witness);
        stages
    }

    /// The rates at the bodies' places and momenta.
    fn rates<Y: System<T, D, Count = N>, W: Witness<T>>(
        &mut self,
        (system, rates): View<'_, Dop853, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        stage: usize,
        witness: &mut W,
    ) {
        let mut power = rates.evaluate_rates(bodies, &mut self.f[stage * self.n..][..self.n], witness);
        for body in 0..self.n {
            self.v[stage * self.n + body] = system.velocity(bodies, body);
        }
        if self.energy.is_some() {
            // dU/dt = ∂U/∂t − f·q̇: the first is booked as a difference.
            power = power - bodies.power;
            for (force, v) in Y::forces_of(&bodies.kept).iter().zip(&self.v[stage * self.n..]) {
                power = power + dot(&force.components(), v);
            }
        }
        self.power[stage] = power;
    }

    /// Σ cⱼ of the rates of a body, q̇ and ṗ.
    fn combined(&self, weights: &[(usize, f64)], body: usize) -> ([T; D], [T; D]) {
        let zero = [T::from_f64(0.0); D];
        weights.iter().fold((zero, zero), |(v, f), &(stage, weight)| {
            let (at, weight) = (stage * self.n + body, T::from_f64(weight));
            (add_scaled(&v, weight, &self.v[at]), add_scaled(&f, weight, &self.f[at]))
        })
    }

    /// The stages of an inner step h, from the second one on. A stage beyond a kink, whose rates are those of another
    /// side, is an error where it is looked for: without a tolerance, which would tell whether it matters. Where only
    /// the curvature jumps, later stages may be far off the constraints, and are not looked at.
    fn evaluate<const LOOKS: bool, Y: System<T, D, Count = N>>(
        &mut self,
        system: View<'_, Dop853, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        h: f64,
    ) -> Result<(), Failure> {
        let (step, mut looks) = (T::from_f64(h), LOOKS);
        for stage in 1..STAGES {
            for body in 0..self.n {
                let (v, f) = self.combined(STEPS[stage], body);
                let start = self.start.body(body);
                bodies.q.as_mut()[body] = sum(&start.q, &add_scaled(&start.q_low, step, &v));
                bodies.p.as_mut()[body] = sum(&start.p, &add_scaled(&start.p_low, step, &f));
            }
            bodies.time = self.start.time + h * NODES[stage];
            if looks && system.0.changes_sides(self.start, bodies) {
                looks = false;
                let looked = system.0.check_kinks(self.start, bodies);
                looked.map_err(|kink| kink.of_part(0.0, NODES[stage]))?;
            }
            system.0.refresh_off(bodies);
            self.rates(system, bodies, stage, &mut ());
        }
        Ok(())
    }

    /// The estimated error of an inner step, the largest of all bodies, and of which body; NaN if it is none. The
    /// places and momenta of `bodies` are used up.
    fn error<Y: System<T, D, Count = N>>(
        &self,
        system: View<'_, Dop853, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        h: f64,
        whole: f64,
    ) -> (f64, usize) {
        let mut worst = (0.0, 0);
        for body in 0..self.n {
            bodies.q.as_mut()[body] = self.start.body(body).q; // where an attitude is a rotation
            let mut length = |weights| {
                let (v, f) = self.combined(weights, body);
                bodies.p.as_mut()[body] = f;
                let change = system.0.velocity(bodies, body);
                T::from_f64(h.abs())
                    * (dot(&v, &v).sqrt() + T::from_f64(whole.abs()) * dot(&change, &change).sqrt())
            };
            let (fifth, third) = (length(ERROR_5).to_f64(), length(ERROR_3).to_f64());
            // Of eighth order in h, as the method.
            let error = if fifth == 0.0 { 0.0 } else { fifth * fifth / fifth.hypot(0.1 * third) };
            if error > worst.0 || error.is_nan() {
                worst = (error, body);
            }
        }
        worst
    }

    /// By how much the bodies were [moved](moved) onto the constraints.
    fn moved<Y: System<T, D, Count = N>>(
        &self,
        (system, _): View<'_, Dop853, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        whole: f64,
    ) -> (f64, usize) {
        let led = [&*self.v, &*self.f].map(|rates| &rates[LED * self.n..][..self.n]);
        moved(whole, system, bodies, led)
    }

    /// Takes the bodies to the end of the inner step and onto the constraints, as [`land`] does.
    fn arrive<Y: System<T, D, Count = N>>(
        &mut self,
        system: View<'_, Dop853, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        h: f64,
    ) -> Result<Result<(), Failure>, Failure> {
        let step = T::from_f64(h);
        for body in 0..self.n {
            let (v, f) = self.combined(WEIGHTS, body);
            let finite = [dot(&v, &v), dot(&f, &f)].iter().all(|square| square.to_f64().is_finite());
            if !finite {
                return Err(Failure { body, cause: MethodFailure::StageNotFinite { h }.into() });
            }
            let (start, increment, impulse) = (self.start.body(body), scaled(step, &v), scaled(step, &f));
            (bodies.q.as_mut()[body], bodies.q_low.as_mut()[body]) =
                two_sum(&start.q, &sum(&start.q_low, &increment));
            (bodies.p.as_mut()[body], bodies.p_low.as_mut()[body]) =
                two_sum(&start.p, &sum(&start.p_low, &impulse));
            let led = LED * self.n + body;
            (self.v[led], self.f[led]) = (bodies.q.as_ref()[body], bodies.p.as_ref()[body]);
        }
        for &(stage, weight) in WEIGHTS {
            bodies.work = bodies.work + T::from_f64(h * weight) * self.power[stage];
        }
        bodies.time = self.start.time + h;
        let landed = land(h, system, self.start, bodies)?;
        if let Some(before) = self.energy {
            let energy = system.0.potential_energy(bodies);
            bodies.work = bodies.work + (energy - before);
            self.energy_at_end = Some(energy);
        }
        Ok(landed)
    }
}
