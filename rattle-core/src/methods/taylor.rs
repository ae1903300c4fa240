//! Taylor's method: the power series of the motion, summed, and projected onto the constraints.
//!
//! ```text
//! q̂ = Σ qₖ hᵏ,   p̂ = M Σ (k + 1) qₖ₊₁ hᵏ        k ≤ N + 1 and k ≤ N
//! q′ nearest to q̂ with g(q′) = 0,   p′ nearest to p̂ with G(q′) M⁻¹p′ = 0, as masses measure it
//! ```
//!
//! The coefficients come order by order from recurrences written by the macros ([`series`](crate::kernel::series)),
//! with N²/2 products for each operation. The method has any order, is accurate to rounding if the tolerance asks for
//! it, and is neither symplectic nor reversible: a reference for tests, and for short runs of high accuracy. Functions
//! must be smooth: otherwise coefficients are not finite, and the step is an error. With a tolerance it is the fastest
//! method on a double pendulum for errors below 1e-8, and faster than DOP853 on surfaces for errors below 1e-10
//! (`examples/accuracy.rs`).
//!
//! With a tolerance each step is divided so that the last two terms of every inner step stay below it. No inner step is
//! repeated, and a step is a function of the state alone.
//!
//! Source: À. Jorba, M. Zou, Exp. Math. 14 (2005) 99.

use crate::error::{Error, MethodFailure};
use crate::motion::bodies::{Bodies, Count, Saved};
use crate::motion::capability::{Rates, Series};
use crate::motion::course::look_inside;
use crate::motion::failure::Failure;
use crate::motion::method::{Method, Projecting, View, check_step_size, check_tolerance};
use crate::motion::need::{Kicks, WithRates, WithSeries};
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::motion::witness::{AtEnd, Witness};
use crate::number::real::Scalar;
use crate::number::vector::{add_scaled, dot, largest, scaled, sum, two_sum};

/// The smallest part of a step that is tried.
pub(crate) const SMALLEST_PART: f64 = 1e-6;

/// Taylor's method, with fixed steps or with a tolerance.
///
/// ```
/// use rattle::{Method, Taylor};
/// assert_eq!(Taylor::adaptive(18, 0.5, 1e-15).order(), 18);
/// ```
#[doc(alias = "ode")]
#[doc(alias = "adaptive")]
#[doc(alias = "power series")]
#[doc(alias = "reference solution")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Taylor {
    order: u32,
    h: f64,
    tolerance: Option<f64>,
}

impl Taylor {
    /// The method of this order, 2 to 64, with fixed steps of size `h`, in the unit of time.
    #[must_use]
    pub fn new(order: u32, h: f64) -> Self {
        Self { order, h, tolerance: None }
    }

    /// The method with steps of size `h`, each divided into as many inner steps as needed to keep the last terms of
    /// positions, and of velocities times h, below the tolerance, a length.
    #[doc(alias = "dt")]
    #[doc(alias = "tolerance")]
    #[must_use]
    pub fn adaptive(order: u32, h: f64, tolerance: f64) -> Self {
        Self { order, h, tolerance: Some(tolerance) }
    }
}

impl Method for Taylor {
    type Memory<T: Scalar> = [T; 0];
    type Need = (Kicks, WithRates, WithSeries);
    const HAS_STRUCTURE: bool = false;
    const CHECKS: bool = true;
    const PROJECTS: Projecting = Projecting::Taylor;

    fn step_size(&self) -> f64 {
        self.h
    }
    fn order(&self) -> u32 {
        self.order
    }
    fn name(&self) -> &'static str {
        if self.tolerance.is_some() { "Taylor, adaptive" } else { "Taylor" }
    }
    fn with_step(&self, h: f64) -> Self {
        Self { h, ..*self }
    }
    fn tolerance(&self) -> Option<f64> {
        self.tolerance
    }
    fn with_tolerance_times(&self, factor: f64) -> Option<Self> {
        self.tolerance.map(|tolerance| Self { tolerance: Some(tolerance * factor), ..*self })
    }
    fn is_symmetric(&self) -> bool {
        false
    }
    fn check(&self, _: usize) -> Result<(), Error> {
        if !(2..=64).contains(&self.order) {
            return Err(Error::Order(self.order));
        }
        check_tolerance(self.tolerance)?;
        check_step_size(self.h)
    }

    fn prepare<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        (_, _, series): View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
    ) {
        series.reserve_series(bodies, self.coefficients(), self.h);
        bodies.make_room(self.coefficients());
    }

    fn step<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        _: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        let n = bodies.q.as_ref().len();
        bodies.with_room(self.coefficients(), |bodies, saved, room| {
            self.steps(system, bodies, saved, room, witness)?;
            if W::LISTENS {
                let (_, rates, _) = system;
                rates.evaluate_rates(bodies, &mut room[..n], &mut AtEnd(witness));
            }
            Ok(())
        })
    }
}

impl Taylor {
    /// q₀ to the one that the last of v is made from.
    pub(crate) fn coefficients(&self) -> usize {
        self.order as usize + 2
    }

    /// One step, or inner ones that make it up.
    fn steps<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        start: &mut Saved<Y::Count, T, D>,
        series: &mut [[T; D]],
        witness: &mut W,
    ) -> Result<(), Failure> {
        let (_, _, motion) = system;
        bodies.save(start);
        motion.expand(bodies, series, witness);
        let Some(tolerance) = self.tolerance else {
            self.arrive(system, bodies, series, self.h)?;
            return look_inside(self, self.h, self.h, system.0, start, bodies);
        };
        let mut left = self.h;
        loop {
            let (longest, body) = self.longest(bodies, series, tolerance, motion.unit(bodies));
            let collapsed = longest < SMALLEST_PART * self.h.abs();
            if longest.is_nan() {
                return Err(Failure { body, cause: MethodFailure::StageNotFinite { h: self.h }.into() });
            }
            if collapsed {
                let inner = longest.copysign(self.h);
                let cause =
                    MethodFailure::StepsCollapse { inner, h: self.h, error: tolerance, tolerance }.into();
                return Err(Failure { body, cause });
            }
            let last = longest >= left.abs();
            let inner = if last { left } else { longest.copysign(left) };
            self.arrive(system, bodies, series, inner)?;
            look_inside(self, left, inner, system.0, start, bodies)?;
            if last {
                return Ok(());
            }
            left -= inner;
            bodies.save(start);
            motion.expand(bodies, series, &mut ());
        }
    }

    /// The longest inner step whose last two terms keep the tolerance, and the body that limits it; NaN if a term is.
    fn longest<T: Scalar, N: Count, X, const D: usize>(
        &self,
        bodies: &Bodies<N, T, X, D>,
        series: &[[T; D]],
        tolerance: f64,
        unit: f64,
    ) -> (f64, usize) {
        let n = bodies.q.as_ref().len();
        let mut longest = (f64::INFINITY, 0);
        for order in [self.order as usize - 1, self.order as usize] {
            for body in 0..n {
                let q = largest(&series[order * n + body]).to_f64();
                let v = largest(&series[(order + 1) * n + body]).to_f64();
                let size = q.max((order + 1) as f64 * v * (self.h / unit).abs()) + 0.0 * (q + v); // NaN if one is
                let fits = unit * (tolerance / size).powf(1.0 / order as f64);
                if fits < longest.0 || fits.is_nan() {
                    longest = (fits, body);
                }
            }
        }
        longest
    }

    /// Sums the series by Horner's rule and takes the bodies onto the constraints.
    fn arrive<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        (system, rates, motion): View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        series: &[[T; D]],
        h: f64,
    ) -> Result<(), Failure> {
        let n = bodies.q.as_ref().len();
        let orders = series.len().checked_div(n).unwrap_or(0);
        let unit = motion.unit(bodies);
        let (step, over_unit, zero) = (T::from_f64(h / unit), T::from_f64(1.0 / unit), [T::from_f64(0.0); D]);
        for body in 0..n {
            let (mut way, mut change) = (zero, zero);
            for k in (1..orders).rev() {
                let coefficient = &series[k * n + body];
                way = scaled(step, &sum(coefficient, &way));
                if k > 1 {
                    change = scaled(step, &add_scaled(&change, T::from_f64(k as f64), coefficient));
                }
            }
            let finite =
                [dot(&way, &way), dot(&change, &change)].iter().all(|square| square.to_f64().is_finite());
            if !finite {
                return Err(Failure { body, cause: MethodFailure::StageNotFinite { h }.into() });
            }
            change = scaled(over_unit, &change);
            let impulse = motion.expanded_impulse(bodies, body, h);
            let impulse = impulse.unwrap_or_else(|| rates.momentum(body, &change));
            let (q, q_low) = (&mut bodies.q.as_mut()[body], &mut bodies.q_low.as_mut()[body]);
            (*q, *q_low) = two_sum(q, &sum(q_low, &way));
            let (p, p_low) = (&mut bodies.p.as_mut()[body], &mut bodies.p_low.as_mut()[body]);
            (*p, *p_low) = two_sum(p, &sum(p_low, &impulse));
        }
        bodies.work = bodies.work + motion.expanded_work(bodies, h);
        bodies.time += h;
        rates.project(h, bodies)?;
        system.settle(0.0, h, bodies, &mut ())
    }
}
