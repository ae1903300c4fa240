//! BDF2: the implicit two-step backward differentiation formula, for the equations of motion with g = 0 (index 3).
//!
//! ```text
//! (3q′ − 4q + q₋)/(2h) = v′,   M (3v′ − 4v + v₋)/(2h) = f(q′) + G(q′)ᵀλ′,   g(q′) = 0
//! ```
//!
//! Second order, with the first step by RATTLE. The method is dissipative: energy falls, more slowly with shorter
//! steps. Constraints hold to rounding, their derivative G(q′) v′ = 0 only to second order. General solvers of
//! differential-algebraic equations use such methods; this one is for comparison.
//!
//! With the increments d = q − q₋, d′ = q′ − q, and β = 2h/3,
//!
//! ```text
//! d′ = d/3 + β (4v − v₋)/3 + β² M⁻¹(f(q′) + G(q′)ᵀλ′)
//! ```
//!
//! is solved by iteration: forces and normals are evaluated at the last q′, the residual tangent to the constraint is
//! corrected, and q′ is projected onto the constraint. This contracts like (h·κ·|v|)². The memory holds the increment
//! of the last step and the momentum before it.
//!
//! Source: E. Hairer, G. Wanner, *Solving Ordinary Differential Equations II*, VII.3.

use crate::error::MethodFailure;
use crate::methods::rattle;
use crate::motion::bodies::{Bodies, Count, Saved};
use crate::motion::capability::Rates;
use crate::motion::failure::Failure;
use crate::motion::iteration::Newton;
use crate::motion::method::{Method, View};
use crate::motion::need::{Differences, WithRates};
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::real::Scalar;
use crate::number::vector::{add_scaled, largest, scaled, sum, two_sum};
use crate::solve::stop::{NOISE, SPARE};
use std::array::from_fn;

/// Iterations after which a step is given up; four to eight suffice where it is accurate.
const MAX_ITERATIONS: usize = 100;
/// Vectors per body: the increment sought, and what it is without the new forces.
const ROOM: usize = 2;

/// BDF2 with a constant step size.
///
/// ```
/// use rattle::{Bdf2, Scene, State};
///
/// let mut simulation = Scene::point().simulate(State::at([0.0]).moving([1.0]), Bdf2::new(0.5))?;
/// simulation.run(4)?;
/// assert!((simulation.position().x - 2.0).abs() < 1e-15);
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "Gear")]
#[doc(alias = "DAE")]
#[doc(alias = "multistep")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bdf2 {
    h: f64,
}

impl Bdf2 {
    /// BDF2 with step size `h`, in the unit of time.
    #[must_use]
    pub fn new(h: f64) -> Self {
        Self { h }
    }
}

impl Method for Bdf2 {
    /// Whether there was a step before, its increment d and the momentum before it, body by body.
    type Memory<T: Scalar> = Vec<T>;
    type Need = (Differences, WithRates);
    const HAS_STRUCTURE: bool = false;

    fn step_size(&self) -> f64 {
        self.h
    }
    fn order(&self) -> u32 {
        2
    }
    fn name(&self) -> &'static str {
        "BDF2"
    }
    fn with_step(&self, h: f64) -> Self {
        Self::new(h)
    }
    fn is_symmetric(&self) -> bool {
        false
    }

    fn prepare<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        _: View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
    ) {
        bodies.make_room(ROOM);
    }
    fn memory<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        _: View<'_, Self, T, Y, D>,
        bodies: &BodiesOf<Y, T, D>,
    ) -> Vec<T> {
        vec![T::from_f64(0.0); 1 + 2 * D * bodies.q.as_ref().len()]
    }

    fn step<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        memory: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        let (begun, before) = memory.split_at_mut(1);
        bodies.with_room(ROOM, |bodies, start, room| {
            bodies.save(start);
            self.advance(system, bodies, start, room, &mut begun[0], before, witness)
        })
    }
}

impl Bdf2 {
    #[allow(clippy::too_many_arguments, reason = "what a step knows of the two before it")]
    fn advance<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        start: &Saved<Y::Count, T, D>,
        room: &mut [[T; D]],
        begun: &mut T,
        before: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        let n = bodies.q.as_ref().len();
        let (increment, free) = room.split_at_mut(n);
        let (q, q_low, p) = (start.q.as_ref(), start.q_low.as_ref(), start.p.as_ref());
        let (all, (system, rates)) = (system, system);

        let first = begun.to_f64() == 0.0;
        if first {
            rattle::step::<Newton, _, _, _, D>(self.h, &[], system, bodies, witness)?;
            *begun = T::from_f64(1.0);
        } else {
            let beta = T::from_f64(2.0 * self.h / 3.0);
            let (third, four_thirds) = (T::from_f64(1.0 / 3.0), T::from_f64(4.0 / 3.0));
            // The first guess has the forces and normals of the start.
            rates.evaluate_rates(bodies, increment, &mut ());
            for body in 0..n {
                let [d, p_before] = remembered(before, body);
                let carried = add_scaled(&scaled(four_thirds, &p[body]), -third, &p_before);
                bodies.p.as_mut()[body] = carried;
                bodies.p_low.as_mut()[body] = [T::from_f64(0.0); D];
                let drift = system.velocity(bodies, body);
                free[body] = add_scaled(&scaled(third, &d), beta, &drift);
                bodies.p.as_mut()[body] = increment[body];
                let push = system.velocity(bodies, body);
                increment[body] = add_scaled(&free[body], beta, &scaled(beta, &push)); // β² may be ∞
            }
            self.solve(all, bodies, [q, q_low], [increment, free], &mut Once(witness))?;
            let (ahead, behind) = (T::from_f64(1.5 / self.h), T::from_f64(0.5 / self.h));
            for body in 0..n {
                let [d, _] = remembered(before, body);
                let velocity = add_scaled(&scaled(ahead, &increment[body]), -behind, &d);
                bodies.p.as_mut()[body] = rates.momentum(body, &velocity);
                bodies.p_low.as_mut()[body] = [T::from_f64(0.0); D];
            }
        }
        for (body, before) in before.chunks_exact_mut(2 * D).enumerate() {
            let increment = moved(bodies, body, &q[body], &q_low[body]);
            before[..D].copy_from_slice(&increment);
            before[D..].copy_from_slice(&p[body]);
        }
        Ok(())
    }

    /// Iterates until positions no longer move; `increment` is then d′, and momenta are used up.
    fn solve<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        (system, rates): View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        [q, q_low]: [&[[T; D]]; 2],
        [increment, free]: [&mut [[T; D]]; 2],
        witness: &mut W,
    ) -> Result<(), Failure> {
        let beta = 2.0 * self.h / 3.0;
        let (step, inverse) = (T::from_f64(beta), T::from_f64(1.0 / beta));
        let miss = |bodies: &mut BodiesOf<Y, T, D>, increment: &[[T; D]]| {
            for body in 0..increment.len() {
                let missing = scaled(inverse, &add_scaled(&free[body], T::from_f64(-1.0), &increment[body]));
                bodies.p.as_mut()[body] = rates.momentum(body, &missing);
                bodies.p_low.as_mut()[body] = [T::from_f64(0.0); D];
            }
        };
        let mut last = f64::INFINITY;
        for iteration in 1..=MAX_ITERATIONS {
            for body in 0..q.len() {
                // A momentum that tells how far a body goes, for what is too far.
                let way = scaled(T::from_f64(1.0 / self.h), &increment[body]);
                bodies.p.as_mut()[body] = rates.momentum(body, &way);
                (bodies.q.as_mut()[body], bodies.q_low.as_mut()[body]) =
                    two_sum(&q[body], &sum(&q_low[body], &increment[body]));
            }
            rates.project(self.h, bodies)?;
            for body in 0..q.len() {
                increment[body] = moved(bodies, body, &q[body], &q_low[body]);
            }
            // Forces that constraints cancel leave the rounding of what they alone would do.
            let mut pushed = 0.0_f64;
            for body in 0..q.len() {
                bodies.p.as_mut()[body] = system.force(bodies, body);
                pushed = pushed.max(beta * beta * largest(&system.velocity(bodies, body)).to_f64());
            }
            miss(bodies, increment);
            system.settle(beta, 2.0 * beta, bodies, &mut ())?;
            // Bodies may be linked: one that hardly moves has roundings of the others' ways.
            let way = increment.iter().map(|way| largest(way).to_f64()).fold(pushed, f64::max);
            let (mut worst, mut slowest) = (0.0, 0);
            for body in 0..q.len() {
                let shift = scaled(step, &system.velocity(bodies, body));
                increment[body] = sum(&increment[body], &shift);
                let size = largest(&q[body]).max(largest(&increment[body])).to_f64().max(way);
                let shift = largest(&shift).to_f64();
                let roundings = if shift == 0.0 { 0.0 } else { shift / (f64::EPSILON * size) };
                if roundings > worst || roundings.is_nan() {
                    (worst, slowest) = (roundings, body);
                }
            }
            let contraction = worst / last;
            let stalled = contraction >= 0.5 && worst <= NOISE;
            if worst <= SPARE || stalled {
                for body in 0..q.len() {
                    increment[body] = moved(bodies, body, &q[body], &q_low[body]);
                }
                if const { W::LISTENS } {
                    // What was missing, once more, for those who want to know what settled it.
                    miss(bodies, increment);
                    system.settle(beta, 2.0 * beta, bodies, witness)?;
                }
                return Ok(());
            }
            let hopeless = !worst.is_finite() || (iteration > 10 && contraction > 0.95);
            if hopeless || iteration == MAX_ITERATIONS {
                let cause =
                    MethodFailure::ImplicitNotSolved { h: self.h, iterations: iteration, left: worst }.into();
                return Err(Failure { body: slowest, cause });
            }
            last = worst;
        }
        Ok(()) // not reached: the last iteration returns
    }
}

/// The increment of a body's last step, and its momentum before it.
fn remembered<T: Scalar, const D: usize>(before: &[T], body: usize) -> [[T; D]; 2] {
    let numbers = &before[2 * D * body..][..2 * D];
    [from_fn(|i| numbers[i]), from_fn(|i| numbers[D + i])]
}

/// How far a body is from a place, with what rounding took from both.
fn moved<T: Scalar, N: Count, X, const D: usize>(
    bodies: &Bodies<N, T, X, D>,
    body: usize,
    q: &[T; D],
    q_low: &[T; D],
) -> [T; D] {
    let high = add_scaled(&bodies.q.as_ref()[body], T::from_f64(-1.0), q);
    sum(&high, &add_scaled(&bodies.q_low.as_ref()[body], T::from_f64(-1.0), q_low))
}

/// Hands on each multiplier for both ends of the step: there is one.
struct Once<'a, W>(&'a mut W);

impl<T: Copy, W: Witness<T>> Witness<T> for Once<'_, W> {
    const LISTENS: bool = W::LISTENS;

    fn position_multiplier(&mut self, _: usize, _: T) {}
    fn momentum_multiplier(&mut self, equation: usize, mu: T) {
        self.0.position_multiplier(equation, mu);
        self.0.momentum_multiplier(equation, mu);
    }
}
