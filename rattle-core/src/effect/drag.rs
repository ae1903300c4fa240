//! Drag in proportion to the velocity, or to its square.

use crate::effect::flow::Flow;
use crate::effect::interval::{Inertia, Interval, diagonal, has_scalar_mass, inverse_mass};
use crate::error::EffectMistake;
use crate::number::linear::axes;
use crate::number::real::{Real, each_lane};
use crate::number::vector::{add_scaled, dot, scaled};
use std::array::from_fn;

/// Drag in proportion to velocity (G. Stokes 1851).
///
/// ```text
/// ṗ = −C v,  C = diag(c₁ … c_D)      in the unit of force over velocity, mass over time
/// ```
///
/// The flow by itself is exact, whatever the masses. Coefficients that differ by direction are of second order on
/// surfaces and links, where what drag takes and what constraints do alternate: they want h c/m below 1. One that is
/// far above leaves (sin²θ/(1 + cos²θ))² of a momentum along a line at the angle θ to its axis in a step: 1/9 at 45°,
/// and nearly all across.
///
/// **Under forces** a step is of second order in h c/m, too. The terminal velocity is x coth x times f/c, with x = h
/// c/(2m): 1.08 times at h c/m = 1, and 5 times at 10. Where drag is far stronger than inertia,
/// [`Brownian`](crate::methods::brownian::Brownian) motion has none: with a temperature of 0 it follows v = f/c.
///
/// For a rigid body, the coefficients c₁, c₂, c₃ are those of rotation about its principal axes.
///
/// ```
/// use rattle::effect::LinearDrag;
/// use rattle::prelude::*;
///
/// let scene = Scene::point().mass(2.0).with(LinearDrag::new(0.5)); // v = exp(−t/4)
/// let mut simulation = scene.simulate(State::at([0.0]).moving([2.0]), Rattle::new(0.1))?;
/// simulation.run(40)?;
/// assert!((simulation.velocity().x - (-1.0_f64).exp()).abs() < 1e-15);
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "Stokes")]
#[doc(alias = "viscous")]
#[doc(alias = "friction")]
#[doc(alias = "damping")]
#[derive(Debug, Clone, PartialEq)]
pub struct LinearDrag<const D: usize> {
    along: [f64; D],
    /// A factor for each body; without, 1.
    of_bodies: Option<Vec<f64>>,
}

impl<const D: usize> LinearDrag<D> {
    /// The same coefficient c in all directions, for all bodies.
    #[must_use]
    pub fn new(coefficient: f64) -> Self {
        Self::along([coefficient; D])
    }

    /// A coefficient for each coordinate.
    ///
    /// ```
    /// use rattle::effect::LinearDrag;
    /// use rattle::prelude::*;
    ///
    /// let scene = Scene::point().with(LinearDrag::along([1.0, 0.0])); // no drag along y
    /// let start = State::at([0.0, 0.0]).moving([1.0, 1.0]);
    /// let mut simulation = scene.simulate(start, Rattle::new(0.1))?;
    /// simulation.run(10)?;
    /// let v = simulation.velocity();
    /// assert!((v.x - (-1.0_f64).exp()).abs() < 1e-15 && v.y == 1.0);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    #[must_use]
    pub fn along(coefficients: [f64; D]) -> Self {
        Self { along: coefficients, of_bodies: None }
    }

    /// The same drag, times a factor for each body.
    #[must_use]
    pub fn times(mut self, factors: impl IntoIterator<Item = f64>) -> Self {
        self.of_bodies = Some(factors.into_iter().collect());
        self
    }

    /// The coefficients of a body.
    fn of(&self, body: usize) -> [f64; D] {
        let factor = self.of_bodies.as_ref().map_or(1.0, |factors| factors[body]);
        self.along.map(|c| c * factor)
    }
}

impl<const D: usize> Flow<D> for LinearDrag<D> {
    fn flow<T: Real>(&self, during: &Interval<'_, T, D>, changes: &mut [[T; D]]) {
        for (body, (change, p)) in changes.iter_mut().zip(during.momenta).enumerate() {
            let c = self.of(body);
            *change = match diagonal(during.inertia, body) {
                Some(inverse) => from_fn(|i| {
                    each_lane(T::from_f64(c[i]) * inverse[i], |rate| (-during.h * rate).exp_m1()) * p[i]
                }),
                None => lane_by_lane(&inverse_mass(during.inertia, body), p, |inverse, p| {
                    slowed_in_proportion(during.h, &c, inverse, p)
                }),
            };
        }
    }

    fn linear(&self, h: f64, body: usize, inertia: &dyn Inertia<f64, D>) -> Option<[[f64; D]; D]> {
        let (c, inverse) = (self.of(body), diagonal(inertia, body)?);
        let lost = |i: usize| (-h * (c[i] * inverse[i])).exp_m1();
        Some(from_fn(|i| from_fn(|k| if i == k { lost(i) } else { 0.0 })))
    }

    fn check(&self, bodies: usize) -> Result<(), EffectMistake> {
        EffectMistake::unless_for_each(self.of_bodies.as_deref(), bodies)?;
        let numbers = self.along.iter().chain(self.of_bodies.iter().flatten());
        numbers.copied().try_for_each(|c| EffectMistake::unless_positive_or_zero("a coefficient of drag", c))
    }
}

/// Drag in proportion to the square of the velocity (I. Newton 1687).
///
/// ```text
/// ṗ = −c |v| v        c in the unit of mass over length
/// ```
///
/// The flow is exact where the mass of a body is a number. Where it is a matrix or one for each coordinate, the way of
/// the velocity is exact, and the speed along it of second order. There a half step that leaves less than a tenth of a
/// component along an axis of the masses can be the end of two ways, and a step back then leads to the start of the
/// other. Backwards in time a velocity was infinite at t = −m/(c |v|): steps that reach as
/// far fail.
///
/// ```
/// use rattle::effect::QuadraticDrag;
/// use rattle::prelude::*;
///
/// let scene = Scene::point().with(QuadraticDrag { coefficient: 2.0 }); // v = 1/(1 + 2t)
/// let mut simulation = scene.simulate(State::at([0.0]).moving([1.0]), Rattle::new(0.1))?;
/// simulation.run(20)?;
/// assert!((simulation.velocity().x - 0.2).abs() < 1e-15);
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "air resistance")]
#[doc(alias = "drag")]
#[doc(alias = "friction")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuadraticDrag {
    /// c, in the unit of mass over length: ½ρAC_D of a body of cross section A in a fluid of density ρ.
    pub coefficient: f64,
}

impl<const D: usize> Flow<D> for QuadraticDrag {
    #[inline(always)] // into the loop over lanes
    fn flow<T: Real>(&self, during: &Interval<'_, T, D>, changes: &mut [[T; D]]) {
        let (zero, one, hc) = (T::from_f64(0.0), T::from_f64(1.0), during.h * self.coefficient);
        for (body, (change, p)) in changes.iter_mut().zip(during.momenta).enumerate() {
            *change = if has_scalar_mass(during.inertia, body) {
                let v = during.inertia.velocity(body, p);
                let x = T::from_f64(hc) * dot(&v, &v).sqrt() * inverse_mass(during.inertia, body)[0][0];
                // v/(1 + x): infinite backwards in time at x = −1, and NaN beyond.
                let share = T::select(zero.lt(one + x), x / (one + x), T::from_f64(f64::NAN));
                let share = T::select(T::from_f64(ALL).lt(x), one, share); // also where x is infinite
                scaled(-share, p)
            } else {
                lane_by_lane(&inverse_mass(during.inertia, body), p, |inverse, p| {
                    slowed_by_the_square(hc, inverse, p)
                })
            };
        }
    }

    fn check(&self, _: usize) -> Result<(), EffectMistake> {
        EffectMistake::unless_positive_or_zero("coefficient", self.coefficient)
    }
}

/// What a momentum changes by, lane by lane in double precision: for masses that are no numbers, which bodies in SIMD
/// lanes of a surface do not have.
#[inline(never)]
fn lane_by_lane<T: Real, const D: usize>(
    inverse: &[[T; D]; D],
    p: &[T; D],
    change: impl Fn(&[[f64; D]; D], &[f64; D]) -> [f64; D],
) -> [T; D] {
    let mut changes = [T::from_f64(0.0); D];
    for lane in 0..p[0].lanes().count() {
        let number = |x: T, lane: usize| x.lanes().nth(lane).unwrap_or(f64::NAN);
        let here = change(&inverse.map(|line| line.map(|x| number(x, lane))), &p.map(|x| number(x, lane)));
        for (all, here) in changes.iter_mut().zip(here) {
            let others = *all;
            *all = T::from_lanes(|other| if other == lane { here } else { number(others, other) });
        }
    }
    changes
}

/// What a momentum changes by in a time h under ṗ = −C M⁻¹p, C diagonal: exact, by the eigenvectors of √C M⁻¹√C.
///
/// ```text
/// exp(−h C M⁻¹) = 1 − √C φ(√C M⁻¹√C) √C M⁻¹       φ(λ) = (1 − e^{−hλ})/λ
/// ```
fn slowed_in_proportion<const D: usize>(
    h: f64,
    c: &[f64; D],
    inverse: &[[f64; D]; D],
    p: &[f64; D],
) -> [f64; D] {
    let root = c.map(f64::sqrt);
    let (rates, axes) = axes(from_fn(|i| from_fn(|k| root[i] * inverse[i][k] * root[k])));
    let push: [f64; D] = from_fn(|i| root[i] * dot(&inverse[i], p));
    let mut taken = [0.0; D];
    for (rate, axis) in rates.iter().zip(&axes) {
        let time = if *rate == 0.0 { h } else { -(-h * rate).exp_m1() / rate };
        taken = add_scaled(&taken, time * dot(axis, &push), axis);
    }
    from_fn(|i| -root[i] * taken[i])
}

/// What a momentum changes by under ṗ = −c |v| v, v = M⁻¹p, in a time h, hc being the product of h and c: p moves along
/// exp(−τM⁻¹)p, whatever |v| is, so that no component ever turns round.
///
/// ```text
/// h c = ∫₀^τ ds/|v(s)| ≈ τ (1/|v(τ)| − 1/|v(0)|)/ln(|v(0)|/|v(τ)|)
/// ```
///
/// This mean is the same from both ends, exact where velocities fade exponentially, as for a mass that is a number, and
/// of second order else.
fn slowed_by_the_square<const D: usize>(hc: f64, inverse: &[[f64; D]; D], p: &[f64; D]) -> [f64; D] {
    let v: [f64; D] = from_fn(|i| dot(&inverse[i], p));
    let reach = hc * dot(&v, &v).sqrt();
    if reach == 0.0 {
        return [0.0; D];
    }
    let (rates, axes) = axes(*inverse);
    let parts = axes.map(|axis| dot(&axis, p));
    let squares: [f64; D] = from_fn(|i| (rates[i] * parts[i]).powi(2));
    let whole = squares.iter().sum::<f64>();
    let course = course(reach, &rates, &squares.map(|square| square / whole));
    let mut change = [0.0; D];
    for ((rate, part), axis) in rates.iter().zip(parts).zip(&axes) {
        if part != 0.0 {
            change = add_scaled(&change, (-course * rate).exp_m1() * part, axis);
        }
    }
    change
}

/// Of numbers above this one, x/(1 + x) is 1.
const ALL: f64 = 1e18;

/// Rounds in which the course of drag by the square is found; it takes 2 to 5 where steps resolve the drag, and 12 at
/// most of 300 000 tries with masses that differ by up to 10⁸.
const ROUNDS: usize = 64;

/// τ with h c |v(0)| = `reach`, for parts of v² that fade with the rates 2λ of τ; NaN where time runs back and
/// velocities were infinite.
///
/// With l = ln(|v(0)|/|v(τ)|) it is where τ = ln(1 + `reach` l/τ) τ/l, found by Newton's method in ln τ between bounds.
/// Steps that are not halved do not count on the way forwards: of three rates two places may lead to each other.
fn course<const D: usize>(reach: f64, rates: &[f64; D], weights: &[f64; D]) -> f64 {
    // Where nothing moves no rate is asked: backwards it may be infinite.
    let rates: &[f64; D] = &from_fn(|i| if weights[i] > 0.0 { rates[i] } else { 0.0 });
    // l, and its derivative.
    let faded = |course: f64| {
        let left: [f64; D] = from_fn(|i| weights[i] * (-2.0 * rates[i] * course).exp());
        let gone = (0..D).map(|i| weights[i] * (-2.0 * rates[i] * course).exp_m1()).sum::<f64>();
        let whole = left.iter().sum::<f64>();
        let l = if gone > -0.5 { gone.ln_1p() } else { whole.ln() };
        [-0.5 * l, dot(&left, rates) / whole]
    };
    if (reach * rates.iter().sum::<f64>()).abs() < f64::EPSILON * f64::EPSILON {
        return reach;
    }
    // What the course would be with a single rate, which falls on the way forwards.
    let alone = |rate: f64| (reach * rate).ln_1p() / rate;
    let mut course = alone(dot(weights, rates));
    let there = rates.iter().zip(weights).filter(|(_, weight)| **weight > 0.0);
    let slowest = there.fold(f64::INFINITY, |least, (rate, _)| least.min(*rate));
    let mut bounds = [course, if reach > 0.0 { alone(slowest) } else { f64::NEG_INFINITY }];
    let mut last = f64::INFINITY;
    for _ in 0..ROUNDS {
        let [l, slope] = faded(course);
        let (rate, next) = (l / course, alone(l / course));
        let x = reach * rate;
        let bend = (x / ((1.0 + x) * x.ln_1p()) - 1.0) * (slope / rate - 1.0); // d ln next/d ln τ
        let newton = course * (next / course).powf(1.0 / (1.0 - bend));
        // Newton's method squares what is left: of 1e-10, nothing.
        let off = (newton - course).abs();
        if off.is_nan() || off <= 1e-10 * course.abs() {
            return newton;
        }
        bounds[usize::from(next.abs() <= course.abs())] = course;
        let [from, to] = bounds.map(f64::abs);
        let inside = from <= newton.abs() && newton.abs() <= to;
        let middle = || if reach > 0.0 { from.sqrt() * to.sqrt() } else { 0.5 * (bounds[0] + bounds[1]) };
        let nearer = reach < 0.0 || off <= 0.5 * last;
        let to = if inside && nearer { newton } else { middle() };
        (last, course) = ((to - course).abs(), to);
    }
    f64::NAN
}
