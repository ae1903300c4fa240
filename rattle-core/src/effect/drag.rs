//! Drag in proportion to the velocity, or to its square.

use crate::effect::flow::Flow;
use crate::effect::interval::{Inertia, Interval, diagonal, inverse_mass};
use crate::error::EffectMistake;
use crate::number::linear::solve_definite;
use crate::number::real::{Real, each_lane};
use crate::number::vector::{add_scaled, dot, scaled};
use std::array::from_fn;

/// Drag in proportion to velocity (G. Stokes 1851).
///
/// ```text
/// ṗ = −C v,  C = diag(c₁ … c_D)      in the unit of force over velocity, mass over time
/// ```
///
/// The flow by itself is exact where masses are numbers, also one for each coordinate, and of second order where they
/// are matrices. Coefficients that differ by direction are of second order on surfaces and links, where what drag takes
/// and what constraints do alternate: they want h c/m below 1. One that is far above leaves (sin²θ/(1 + cos²θ))² of a
/// momentum along a line at the angle θ to its axis in a step: 1/9 at 45°, and nearly all across.
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
    of_bodies: Vec<f64>,
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
        Self { along: coefficients, of_bodies: Vec::new() }
    }

    /// The same drag, times a factor for each body.
    #[must_use]
    pub fn times(mut self, factors: impl IntoIterator<Item = f64>) -> Self {
        self.of_bodies = factors.into_iter().collect();
        self
    }
}

impl<const D: usize> Flow<D> for LinearDrag<D> {
    fn flow<T: Real>(&self, during: &Interval<'_, T, D>, changes: &mut [[T; D]]) {
        for (body, (change, p)) in changes.iter_mut().zip(during.momenta).enumerate() {
            let factor = self.of_bodies.get(body).copied().unwrap_or(1.0);
            let c = self.along.map(|c| T::from_f64(c * factor));
            *change = match diagonal(during.inertia, body) {
                Some(inverse) => {
                    from_fn(|i| each_lane(c[i] * inverse[i], |rate| (-during.h * rate).exp_m1()) * p[i])
                }
                None => slowed(during, body, p, |_| c),
            };
        }
    }

    fn linear(&self, h: f64, body: usize, inertia: &dyn Inertia<f64, D>) -> Option<[[f64; D]; D]> {
        let factor = self.of_bodies.get(body).copied().unwrap_or(1.0);
        let inverse = diagonal(inertia, body)?;
        let lost = |i: usize| (-h * (self.along[i] * factor * inverse[i])).exp_m1();
        Some(from_fn(|i| from_fn(|k| if i == k { lost(i) } else { 0.0 })))
    }

    fn check(&self, bodies: usize) -> Result<(), EffectMistake> {
        EffectMistake::unless_listed(self.of_bodies.len(), bodies)?;
        let numbers = self.along.iter().chain(&self.of_bodies);
        numbers.copied().try_for_each(|c| EffectMistake::unless_positive_or_zero("a coefficient of drag", c))
    }
}

/// Drag in proportion to the square of the velocity (I. Newton 1687).
///
/// ```text
/// ṗ = −c |v| v        c in the unit of mass over length
/// ```
///
/// The flow is exact where the mass of a body is a number, of second order where it is a matrix or one for each
/// coordinate. Backwards in time a velocity was infinite at t = −m/(c |v|): steps that reach as far fail.
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
        let c = T::from_f64(self.coefficient);
        for (body, (change, p)) in changes.iter_mut().zip(during.momenta).enumerate() {
            *change = slowed(during, body, p, |v| [c * dot(v, v).sqrt(); D]);
        }
    }

    fn check(&self, _: usize) -> Result<(), EffectMistake> {
        EffectMistake::unless_positive_or_zero("coefficient", self.coefficient)
    }
}

/// What a momentum changes by in a time h under ṗ = −C(v) v, C diagonal: the implicit step p′ = p − h C(v) M⁻¹p′, whose
/// error of first order goes by extrapolation, 2 X_{h/2}X_{h/2} − X_h. It is exact for C = c |v| and a mass that is a
/// number.
#[inline(always)]
fn slowed<T: Real, const D: usize>(
    during: &Interval<'_, T, D>,
    body: usize,
    p: &[T; D],
    drag: impl Fn(&[T; D]) -> [T; D],
) -> [T; D] {
    let step = |h: f64, p: &[T; D]| -> [T; D] {
        let c = drag(&during.inertia.velocity(body, p)).map(|c| T::from_f64(h) * c);
        let columns = inverse_mass(during.inertia, body);
        // (1 + h C M⁻¹) p′ = p: with M⁻¹ positive definite all pivots are positive; backwards in time, too, until p
        // was infinite, and beyond that p′ is NaN.
        let rows = from_fn(|i| {
            from_fn(|k| c[i].multiply_add(columns[k][i], T::from_f64(f64::from(u8::from(i == k)))))
        });
        solve_definite(rows, *p)
    };
    let twice = step(0.5 * during.h, &step(0.5 * during.h, p));
    let once = step(during.h, p);
    let corrected = add_scaled(&scaled(T::from_f64(2.0), &twice), T::from_f64(-1.0), &once);
    add_scaled(&corrected, T::from_f64(-1.0), p)
}
