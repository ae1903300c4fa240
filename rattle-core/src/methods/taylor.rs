//! Taylor's method: the power series of the motion, summed, and projected onto the constraints.
//!
//! ```text
//! q̂ = Σ qₖ hᵏ,   p̂ = M Σ (k + 1) qₖ₊₁ hᵏ        k ≤ N + 1 and k ≤ N
//! q′ nearest to q̂ with g(q′) = 0,   p′ nearest to p̂ with G(q′) M⁻¹p′ = 0, as masses measure it
//! ```
//!
//! The coefficients come order by order from recurrences written by the macros ([`series`](crate::kernel::series)),
//! with N²/2 products for each operation. The method has any order, is accurate to rounding if the tolerance asks for
//! it, and is neither symplectic nor reversible: a reference for tests, and for short runs of high accuracy. With a
//! tolerance it is the fastest method on a double pendulum for errors below 1e-8, and faster than DOP853 on surfaces
//! for errors below 1e-10 (the example `accuracy`).
//!
//! With a tolerance each step is divided so that the last two terms of every inner step stay below it. A step is a
//! function of the state alone.
//!
//! **Where a potential changes branch** (`if`, `abs`, `max`, a cut-off) its series is still that of the branch where it
//! began, and where a force is local, such as that of a narrow bump, nothing in a series from afar tells of it. So
//! accelerations are compared with those of the series at the end of each inner step and at three times inside of it.
//! Where they differ by more than the last terms of the series, which tell what it
//! leaves out, the change is sought by bisection, and the inner step ends right behind it: the series may be wrong for
//! as long as this leads the body off, with velocities times h, by no more than the tolerance. What is entered and left
//! within 0.27 of one inner step may not be seen: h bounds the inner steps, and must be no longer than what acts is
//! met for. Where an inner step begins on the edge of a branch itself, there is no series, and bodies go a little way
//! by their rates alone, as long as that leads them off by no more than the tolerance. Without a tolerance nothing is
//! compared.
//!
//! Source: À. Jorba, M. Zou, Exp. Math. 14 (2005) 99.

use crate::error::{Error, MethodFailure};
use crate::motion::bodies::{Bodies, Count, Saved};
use crate::motion::capability::{Rates, Series};
use crate::motion::course::{ASTRAY, land, look_inside, moved, velocity_of};
use crate::motion::failure::Failure;
use crate::motion::method::{Method, Projecting, View, check_step_size, check_tolerance};
use crate::motion::need::{Kicks, WithRates, WithSeries};
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::motion::witness::{AtEnd, Witness};
use crate::number::clock::Parts;
use crate::number::real::Scalar;
use crate::number::vector::{add_scaled, dot, extent, largest, scaled, sum, two_sum};

/// The smallest part of a step that is tried.
pub(crate) const SMALLEST_PART: f64 = 1e-6;

/// Inner steps up to a change of branch that may be shorter, in a step and for each body: one that rests on such a
/// change takes no others.
const MOST_SHORT: usize = 64;

/// An inner step that is moved onto the constraints too far is made shorter by this factor.
const SHORTER: f64 = 1.0 / 3.0;

/// The part of what is left of a step that bodies go by their rates alone where there is no series; and by what factor
/// longer they go if there is none then, at most so often: a place that is large beside the way may not change.
const NUDGE: f64 = 1e-10;
const LONGER: f64 = 32.0;
const MOST_NUDGES: i32 = 5;

/// Rates of momenta, with which those of the series are compared.
const PUSHED: usize = 1;

/// Where inside of an inner step its acceleration is compared with that of the series: nowhere alike, so that what
/// comes again and again is not always between them.
pub(crate) const INSIDE: [f64; 3] = [0.24, 0.49, 0.76];

/// Where an inner step led regardless of the constraints: a place and a momentum.
const LED: usize = 2;

/// By so many roundings of places, and of what the series is made of, accelerations may differ.
pub(crate) const ROUNDINGS_OF_SERIES: f64 = 64.0;

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

    /// The method with steps of size `h`, each divided into as many inner steps as needed, at most 10⁶, to keep the
    /// last terms of positions, and of velocities times h, below the tolerance, a length. A force that is met for less
    /// than 0.27 `h` may not be seen. Of low orders inner steps are short beyond use: terms of v t are below
    /// the tolerance where the order is 2; take 8 or more.
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
    fn parameters(&self) -> Vec<f64> {
        std::iter::once(f64::from(self.order)).chain(self.tolerance).collect()
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
        bodies.make_room(self.coefficients() + PUSHED + LED);
    }

    fn step<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        _: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        let n = bodies.q.as_ref().len();
        let inner_steps = bodies.with_room(self.coefficients() + PUSHED + LED, |bodies, saved, room| {
            let inner_steps = self.steps(system, bodies, saved, room, witness)?;
            if W::LISTENS {
                let (_, rates, _) = system;
                rates.evaluate_rates(bodies, &mut room[..n], &mut AtEnd(witness));
            }
            Ok(inner_steps)
        })?;
        bodies.note_inner_steps(inner_steps);
        Ok(())
    }
}

impl Taylor {
    /// q₀ to the one that the last of v is made from.
    pub(crate) fn coefficients(&self) -> usize {
        self.order as usize + 2
    }

    /// One step, or inner ones that make it up; returns how many.
    fn steps<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        start: &mut Saved<Y::Count, T, D>,
        room: &mut [[T; D]],
        witness: &mut W,
    ) -> Result<u32, Failure> {
        let (_, _, motion) = system;
        let n = bodies.q.as_ref().len();
        let (series, rest) = room.split_at_mut(self.coefficients() * n);
        let (pushed, led) = rest.split_at_mut(PUSHED * n);
        bodies.save(start);
        motion.expand(bodies, series, witness);
        let Some(tolerance) = self.tolerance else {
            let landed = self.arrive(system, bodies, start, (series, led), self.h)?;
            return look_inside(self, [self.h; 2], system.0, start, bodies, landed).map(|()| 1);
        };
        let mut number = 0_u32;
        let mut parts = Parts::of(self.h, bodies.time);
        let (mut short, mut most) = (0, (f64::INFINITY, 0, tolerance));
        let (mut made, mut nudges) = (0.0_f64, 0);
        loop {
            let (mut longest, mut body) = self.longest(bodies, series, tolerance, motion.unit(bodies));
            // Where it is short, too: right behind the edge of a branch whose high rates jump.
            let short_there = nudges > 0 && longest < SMALLEST_PART * self.h.abs();
            if nudges < MOST_NUDGES && (longest.is_nan() || short_there) {
                let time = NUDGE * parts.left() * LONGER.powi(nudges);
                if self.nudge(system, bodies, start, (series, pushed), time)? {
                    (nudges, number) = (nudges + 1, number.saturating_add(1));
                    parts.go(time);
                    bodies.time = parts.time();
                    bodies.save(start);
                    motion.expand(bodies, series, &mut ());
                    continue;
                }
            }
            if longest.is_nan() {
                return Err(Failure { body, cause: MethodFailure::StageNotFinite { h: self.h }.into() });
            }
            nudges = 0;
            let mut error = tolerance;
            if most.0 < longest {
                (longest, body, error) = most;
            }
            if longest < SMALLEST_PART * self.h.abs() {
                let inner = longest.copysign(self.h);
                let cause = MethodFailure::of_short_steps([inner; 2], made, error, [self.h, tolerance]);
                return Err(Failure { body, cause: cause.into() });
            }
            let left = parts.left();
            let last = longest >= left.abs();
            let whole = if last { left } else { longest.copysign(left) };
            let bent = self.bent_inside(system, bodies, start, (&*series, &mut *pushed), whole, tolerance);
            let reached = bent.map_or(whole, |(time, _)| time);
            let mut landed = self.arrive(system, bodies, start, (&*series, &mut *led), reached)?;
            let terms = [&mut *series, &mut *pushed, &mut *led];
            let (inner, off) =
                self.in_one_branch(system, bodies, start, terms, (whole, bent), tolerance, &mut landed)?;
            if landed.is_ok() {
                let (places, momenta) = led.split_at(bodies.q.as_ref().len());
                let (off, body) = moved(self.h, system.0, bodies, [places, momenta]);
                if off > ASTRAY * tolerance {
                    most = (SHORTER * inner.abs(), body, off);
                    system.0.put_back(bodies, start);
                    motion.expand(bodies, series, &mut ());
                    continue;
                }
            }
            most = (f64::INFINITY, 0, tolerance);
            look_inside(self, [left, inner], system.0, start, bodies, landed)?;
            short += usize::from(inner.abs() < SMALLEST_PART * self.h.abs());
            if short > MOST_SHORT * bodies.q.as_ref().len() {
                let cause = MethodFailure::StepsCollapse { inner, h: self.h, error: off, tolerance };
                return Err(Failure { body: 0, cause: cause.into() });
            }
            number = number.saturating_add(1);
            parts.go(inner);
            bodies.time = parts.time();
            if last && inner == whole {
                return Ok(number);
            }
            made = made.max(inner.abs());
            bodies.save(start);
            motion.expand(bodies, series, &mut ());
        }
    }

    /// Takes bodies a little way by their rates alone, from the edge of a branch, where there is no series. Whether
    /// that leads them off by no more than the tolerance, as it does where only rates of forces jump; `there` is room
    /// for rates of each body.
    #[cold]
    fn nudge<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        (system, rates, _): View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        start: &Saved<Y::Count, T, D>,
        (there, pushed): (&mut [[T; D]], &mut [[T; D]]),
        time: f64,
    ) -> Result<bool, Failure> {
        let (n, step) = (bodies.q.as_ref().len(), T::from_f64(time));
        let power = rates.evaluate_rates(bodies, pushed, &mut ());
        for body in 0..n {
            let impulse = scaled(step, &pushed[body]);
            // With half of the impulse: a body at rest is moved as well.
            let middle = add_scaled(&bodies.p.as_ref()[body], T::from_f64(0.5), &impulse);
            let way = scaled(step, &velocity_of(system, bodies, body, middle));
            let (q, q_low) = (&mut bodies.q.as_mut()[body], &mut bodies.q_low.as_mut()[body]);
            (*q, *q_low) = two_sum(q, &sum(q_low, &way));
            let (p, p_low) = (&mut bodies.p.as_mut()[body], &mut bodies.p_low.as_mut()[body]);
            (*p, *p_low) = two_sum(p, &sum(p_low, &impulse));
        }
        bodies.time += time;
        land(time, (system, rates), start, bodies)??;
        let later = rates.evaluate_rates(bodies, &mut there[..n], &mut ());
        bodies.work = bodies.work + T::from_f64(0.5) * step * (power + later);
        let mut jump = 0.0_f64;
        for body in 0..n {
            let change = add_scaled(&there[body], T::from_f64(-1.0), &pushed[body]);
            let off = extent(&velocity_of(system, bodies, body, change));
            jump = if off.is_nan() { f64::INFINITY } else { jump.max(off) };
        }
        Ok(self.led_off(jump, time) <= self.tolerance.unwrap_or(0.0))
    }

    /// The first of some times [inside](INSIDE) of an inner step of this length at which the series is not that of the
    /// motion, and by how much its acceleration is off there. The bodies are left at the start, with what is kept of
    /// another place.
    fn bent_inside<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        (system, rates, motion): View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        start: &Saved<Y::Count, T, D>,
        (series, pushed): (&[[T; D]], &mut [[T; D]]),
        inner: f64,
        tolerance: f64,
    ) -> Option<(f64, f64)> {
        let n = bodies.q.as_ref().len();
        let unit = motion.unit(bodies);
        let mut bent = None;
        for time in INSIDE.map(|part| part * inner) {
            let step = T::from_f64(time / unit);
            for body in 0..n {
                let (way, change) = summed(series, n, body, step);
                let impulse = motion.expanded_impulse(bodies, body, time);
                let impulse = impulse
                    .unwrap_or_else(|| rates.momentum(body, &scaled(T::from_f64(1.0 / unit), &change)));
                let from = start.body(body);
                bodies.q.as_mut()[body] = sum(&from.q, &way);
                bodies.p.as_mut()[body] = sum(&from.p, &impulse);
            }
            bodies.time = start.time + time;
            system.refresh_off(bodies);
            let bend = self.bend((system, rates, motion), bodies, series, pushed, time);
            if self.led_off(bend, time) > tolerance {
                bent = Some((time, bend));
                break;
            }
        }
        bodies.restore(start);
        bent
    }

    /// How far off it leads, with velocities times h, to go by an acceleration that is off by `bend` for so long.
    fn led_off(&self, bend: f64, time: f64) -> f64 {
        bend * (time * self.h).abs()
    }

    /// The inner step of this length, if the series is that of the motion until its end, where the bodies are; else a
    /// shorter one, with the bodies at its end, which is right behind where it is not, and how they landed there. And
    /// how far off it would have led. Where it was found to be [bent](Self::bent_inside) the bodies are there.
    #[allow(clippy::too_many_arguments, reason = "what an inner step knows at its end")]
    fn in_one_branch<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        system: View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        start: &Saved<Y::Count, T, D>,
        [series, pushed, led]: [&mut [[T; D]]; 3],
        (inner, bent): (f64, Option<(f64, f64)>),
        tolerance: f64,
        landed: &mut Result<(), Failure>,
    ) -> Result<(f64, f64), Failure> {
        let off = |bend, time| self.led_off(bend, time);
        let (behind, mut end) =
            bent.unwrap_or_else(|| (inner, self.bend(system, bodies, series, pushed, inner)));
        if bent.is_none() && end.is_infinite() {
            return Ok((inner, 0.0)); // the next inner step tells why
        }
        let whole = off(end, behind);
        if whole <= tolerance {
            return Ok((inner, whole));
        }
        let (mut before, mut behind, mut at) = (0.0, behind, behind);
        let shortest = 4.0 * f64::EPSILON * inner.abs();
        while off(end, behind - before) > tolerance && (behind - before).abs() > shortest {
            let middle = 0.5 * (before + behind);
            *landed = self.go_again(system, bodies, start, (series, led), middle)?;
            let there = self.bend(system, bodies, series, pushed, middle);
            at = middle;
            if off(there, middle) <= tolerance {
                before = middle;
            } else {
                (behind, end) = (middle, there);
            }
        }
        if at != behind {
            *landed = self.go_again(system, bodies, start, (series, led), behind)?;
        }
        Ok((behind, whole))
    }

    /// Goes from the start again, as far as that.
    fn go_again<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        system: View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        start: &Saved<Y::Count, T, D>,
        (series, led): (&mut [[T; D]], &mut [[T; D]]),
        inner: f64,
    ) -> Result<Result<(), Failure>, Failure> {
        system.0.put_back(bodies, start);
        system.2.expand(bodies, series, &mut ());
        self.arrive(system, bodies, start, (series, led), inner)
    }

    /// By how much the acceleration of a body is off that of the series at most, after a time `inner` that led the
    /// bodies where they are, beyond the last two terms of the series and what may be rounding; infinite where it is no
    /// number.
    fn bend<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        (system, rates, motion): View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        series: &[[T; D]],
        there: &mut [[T; D]],
        inner: f64,
    ) -> f64 {
        let (n, unit) = (bodies.q.as_ref().len(), motion.unit(bodies));
        let (step, orders) = (T::from_f64(inner / unit), self.coefficients());
        let [rounding, square] = [ROUNDINGS_OF_SERIES * T::EPSILON, unit * unit].map(T::from_f64);
        rates.evaluate_rates(bodies, there, &mut ());
        let mut bend = 0.0_f64;
        for body in 0..n {
            let (mut sum, mut terms, mut last) = ([T::from_f64(0.0); D], T::from_f64(0.0), T::from_f64(0.0));
            for k in (2..orders).rev() {
                let number = T::from_f64((k * (k - 1)) as f64);
                let term = number * largest(&series[k * n + body]);
                sum = add_scaled(&scaled(step, &sum), number, &series[k * n + body]);
                terms = terms * step.abs() + term;
                last = last * step.abs() + if k + 2 >= orders { term } else { T::from_f64(0.0) };
            }
            // Where momenta are not masses times velocities, by what theirs have that the series has not.
            if let Some(rate) = motion.expanded_rate(bodies, body, inner) {
                (there[body], sum) =
                    (add_scaled(&there[body], T::from_f64(-1.0), &rate), [T::from_f64(0.0); D]);
            }
            let pull = velocity_of(system, bodies, body, there[body]);
            let off = extent(&add_scaled(&sum, -square, &pull));
            let size = terms + largest(&bodies.q.as_ref()[body]) / (step * step);
            let off = off - (last + rounding * size).to_f64();
            bend = if off.is_nan() { f64::INFINITY } else { bend.max(off) };
        }
        bend / (unit * unit)
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
                let [q, v] = [order, order + 1].map(|order| extent(&series[order * n + body]));
                let size = q.max((order + 1) as f64 * v * (self.h / unit).abs()) + 0.0 * (q + v); // NaN if one is
                let fits = unit * (tolerance / size).powf(1.0 / order as f64);
                if fits < longest.0 || fits.is_nan() {
                    longest = (fits, body);
                }
            }
        }
        longest
    }

    /// Sums the series by Horner's rule and takes the bodies onto the constraints, as [`land`] does; `led` is where
    /// they were before, all places and all momenta.
    fn arrive<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        (system, rates, motion): View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        start: &Saved<Y::Count, T, D>,
        (series, led): (&[[T; D]], &mut [[T; D]]),
        h: f64,
    ) -> Result<Result<(), Failure>, Failure> {
        let n = bodies.q.as_ref().len();
        let unit = motion.unit(bodies);
        let (step, over_unit) = (T::from_f64(h / unit), T::from_f64(1.0 / unit));
        for body in 0..n {
            let (way, mut change) = summed(series, n, body, step);
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
            (led[body], led[n + body]) = (*q, *p);
        }
        bodies.work = bodies.work + motion.expanded_work(bodies, h);
        bodies.time += h;
        land(h, (system, rates), start, bodies)
    }
}

/// The way and the change of velocity of one of `n` bodies after this time, in the unit of the series, by Horner's
/// rule.
#[inline(always)]
fn summed<T: Scalar, const D: usize>(series: &[[T; D]], n: usize, body: usize, step: T) -> ([T; D], [T; D]) {
    let (mut way, mut change) = ([T::from_f64(0.0); D], [T::from_f64(0.0); D]);
    for k in (1..series.len() / n).rev() {
        let coefficient = &series[k * n + body];
        way = scaled(step, &sum(coefficient, &way));
        if k > 1 {
            change = scaled(step, &add_scaled(&change, T::from_f64(k as f64), coefficient));
        }
    }
    (way, change)
}
