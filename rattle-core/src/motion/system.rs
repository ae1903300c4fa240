//! A system: bodies, constraints and forces, as a method sees them. Every method uses three operations:
//!
//! ```text
//! drift    p½ = p  + c (f(q)  + G(q)ᵀ λ),   q′ = q + h M⁻¹ p½      λ such that g(q′) = 0
//! evaluate f(q′)
//! settle   p′ = p½ + c (f(q′) + G(q′)ᵀμ)                           μ such that G(q′) M⁻¹ p′ = −∂g/∂t
//! ```
//!
//! With c = h/2 the three in this order are a step of RATTLE; other orders and other c make the other methods. Some
//! methods need further [capabilities](crate::motion::capability), which not every system has.
//!
//! [`OnSurface`](crate::systems::surface::kept::OnSurface) holds each body on a surface of its own,
//! [`Linked`](crate::systems::linked::Linked) links between bodies,
//! [`Turning`](crate::systems::rigid::Turning) rigid bodies, and
//! [`InPhaseSpace`](crate::systems::phase::InPhaseSpace) constraints on phase space.

use crate::motion::affected::Affected;
use crate::motion::capability::{Collocation, Rates, Series};
use crate::motion::failure::Failure;
use crate::motion::guarded::Guarded;
use crate::motion::iteration::{Iteration, Newton};
use crate::motion::measured::Measured;
use crate::motion::parts::BodiesOf;
use crate::motion::witness::Witness;
use crate::number::real::Scalar;
use crate::number::vector::add_scaled;

/// A mechanical system with D coordinates per body, made ready for the scalar `T`.
///
/// ```text
/// M q̈ = f(q) + G(q, t)ᵀ λ,   g(q, t) = 0,   f = −∇U,   G = ∂g/∂q
/// ```
///
/// Its [`Parts`](crate::motion::parts::Parts) say what it is made of, [`Affected`] what the effects of the scene do to
/// it, [`Guarded`] what is checked about a step, and [`Measured`] what can be read off. This trait moves it.
pub trait System<T: Scalar, const D: usize>: Affected<T, D> + Guarded<T, D> + Measured<T, D> {
    /// `Self`, or [`Never`](crate::motion::capability::Never) where kinetic energy and forces are not separate.
    type Rates: Rates<Self::Count, Self::Kept, T, D>;
    /// `Self`, or [`Never`](crate::motion::capability::Never) where there are no inner stages.
    type Collocation: Collocation<Self::Count, Self::Kept, T, D>;
    /// `Self`, or [`Never`](crate::motion::capability::Never) where there are no power series.
    type Series: Series<Self::Count, Self::Kept, T, D>;

    /// Rates of change.
    ///
    /// # Errors
    /// Where the system lacks them: the kind of system, in words for the error message.
    #[inline(always)]
    fn rates(&self) -> Result<&Self::Rates, &'static str> {
        Err(self.kind())
    }

    /// Inner stages.
    ///
    /// # Errors
    /// As [`rates`](Self::rates).
    #[inline(always)]
    fn collocation(&self) -> Result<&Self::Collocation, &'static str> {
        Err(self.kind())
    }

    /// Power series.
    ///
    /// # Errors
    /// As [`rates`](Self::rates).
    #[inline(always)]
    fn series(&self) -> Result<&Self::Series, &'static str> {
        Err(self.kind())
    }

    /// Whether momenta are M v in the coordinates of the positions, and [`drift`](Self::drift) solves g(q′) = 0 along
    /// the kept normals; and differences of positions are displacements. Iterations other than Newton's, contacts and
    /// `Bdf2` are only for such systems.
    #[inline(always)]
    fn is_cartesian(&self) -> bool {
        true
    }

    /// Kicks for a time `kick`, then moves for a time `h`, to positions that satisfy the constraints. Afterwards
    /// normals are those of the new positions, and forces still the old ones. Momenta must be tangent to the
    /// constraints. With `kick` 0 forces are not used. `witness` gets λ, the impulse divided by h/2. Neither allocates
    /// nor panics. Time passes by `h`, at least where constraints or forces change with it, and the work of the kick is
    /// [booked](Affected::book).
    ///
    /// The position equation is solved by iteration `X` from `guess`, which has the scale of λ above; an empty `guess`
    /// means λ from g̈ = 0. Where that fails, the equation is solved as by [`drift`](Self::drift). The result differs
    /// only in its last bits. A system that solves another equation ignores both.
    ///
    /// # Errors
    /// Which body cannot be moved, and why; the bodies are then left unfinished.
    fn drift_by<X: Iteration, W: Witness<T>>(
        &self,
        kick: f64,
        h: f64,
        guess: &[T],
        bodies: &mut BodiesOf<Self, T, D>,
        witness: &mut W,
    ) -> Result<(), Failure>;

    /// [`drift_by`](Self::drift_by) with Newton's method, from g̈ = 0.
    ///
    /// # Errors
    /// As [`drift_by`](Self::drift_by).
    #[inline(always)]
    fn drift<W: Witness<T>>(
        &self,
        kick: f64,
        h: f64,
        bodies: &mut BodiesOf<Self, T, D>,
        witness: &mut W,
    ) -> Result<(), Failure> {
        self.drift_by::<Newton, W>(kick, h, &[], bodies, witness)
    }

    /// Evaluates the forces at the present positions and time, and [their power](Affected::evaluate_power).
    fn evaluate_forces(&self, bodies: &mut BodiesOf<Self, T, D>);

    /// Kicks for a time `kick`, whose work is [booked](Affected::book), and makes the momenta tangent to the
    /// constraints. `witness` gets μ, the impulse divided by h/2.
    ///
    /// # Errors
    /// As [`drift`](Self::drift).
    fn settle<W: Witness<T>>(
        &self,
        kick: f64,
        h: f64,
        bodies: &mut BodiesOf<Self, T, D>,
        witness: &mut W,
    ) -> Result<(), Failure>;

    /// Sets the time at the end of a step, from which the sum of its stages may differ by rounding.
    #[inline(always)]
    fn set_time(&self, bodies: &mut BodiesOf<Self, T, D>, time: f64) {
        if bodies.time != time {
            bodies.time = time;
            self.evaluate_forces(bodies);
        }
    }

    /// Writes ṗ = f + Gᵀλ of each body at the present state, and the constraint force Gᵀλ by itself, which is 0 where
    /// there are no equations: the momenta of a rigid body turn with it. Zeros where there are no
    /// [rates](Self::rates). Neither allocates nor panics.
    fn feel(&self, bodies: &mut BodiesOf<Self, T, D>, rates: &mut [[T; D]], holding: &mut [[T; D]]) {
        rates.fill([T::from_f64(0.0); D]);
        if let Ok(capability) = self.rates() {
            capability.evaluate_rates(bodies, rates, &mut ());
        }
        holding.fill([T::from_f64(0.0); D]);
        let held_bodies = if self.equations() > 0 { holding } else { &mut [] };
        for (body, (held, rate)) in held_bodies.iter_mut().zip(&*rates).enumerate() {
            *held = add_scaled(rate, T::from_f64(-1.0), &self.force(bodies, body));
        }
    }

    /// Writes λ of each equation such that g̈ = 0 at the present state, by default from the [rates](Self::rates). A
    /// system with equations and without rates must implement this.
    fn multipliers(&self, bodies: &BodiesOf<Self, T, D>, multipliers: &mut [T]) {
        let mut rates = vec![[T::from_f64(0.0); D]; bodies.q.as_ref().len()];
        let told = rates_at(self, bodies, &mut rates, &mut Told(multipliers));
        debug_assert!(told.is_ok() || self.equations() == 0, "{} has equations", self.kind());
    }

    /// Writes ṗ of each body, from the present state alone; without [flows](crate::effect::Flow).
    ///
    /// # Errors
    /// Where it is not known: the kind of system, as messages call it.
    fn pushes(&self, bodies: &BodiesOf<Self, T, D>, pushes: &mut [[T; D]]) -> Result<(), &'static str> {
        rates_at(self, bodies, pushes, &mut ()).map(drop)
    }

    /// Writes q̈ = M⁻¹ṗ of each body, from the present state alone.
    ///
    /// # Errors
    /// Where [rates](Self::rates) are not known: the kind of system, as messages call it.
    fn accelerations(
        &self,
        bodies: &BodiesOf<Self, T, D>,
        accelerations: &mut [[T; D]],
    ) -> Result<(), &'static str> {
        let mut here = rates_at(self, bodies, accelerations, &mut ())?;
        here.p.as_mut().copy_from_slice(accelerations);
        for (body, a) in accelerations.iter_mut().enumerate() {
            *a = self.velocity(&here, body);
        }
        Ok(())
    }
}

/// Writes ṗ of each body from the present state alone; returns the bodies with the forces there.
fn rates_at<T: Scalar, Y: System<T, D>, const D: usize>(
    system: &Y,
    bodies: &BodiesOf<Y, T, D>,
    rates: &mut [[T; D]],
    witness: &mut impl Witness<T>,
) -> Result<BodiesOf<Y, T, D>, &'static str> {
    let capability = system.rates()?;
    let mut here = bodies.clone();
    system.evaluate_forces(&mut here);
    capability.evaluate_rates(&mut here, rates, witness);
    Ok(here)
}

/// Writes down the multipliers that it is told.
struct Told<'a, T>(&'a mut [T]);

impl<T: Scalar> Witness<T> for Told<'_, T> {
    fn position_multiplier(&mut self, equation: usize, lambda: T) {
        self.0[equation] = lambda;
    }
    fn momentum_multiplier(&mut self, _: usize, _: T) {}
}
