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
//! [`OnSurface`](crate::systems::surface::kept::OnSurface) holds each body on a surface of its own;
//! [`Linked`](crate::systems::linked::Linked) is for links between bodies and everything else.

use crate::effect::interval::{Inertia, Interval, Manner, Normals, Rule, UnitMasses};
use crate::effect::moment::Moment;
use crate::effect::noise::Noise;
use crate::error::{EffectMistake, Error};
use crate::motion::bodies::{Bodies, Body, Count, Saved};
use crate::motion::capability::{Collocation, Rates, Series};
use crate::motion::failure::Failure;
use crate::motion::iteration::{Iteration, Newton};
use crate::motion::record::{Reading, Record};
use crate::motion::witness::Witness;
use crate::number::real::Scalar;
use crate::number::vector::{add_scaled, dot};
use std::fmt::Debug;

/// The bodies of a system, with the quantities that it keeps for them.
pub type BodiesOf<Y, T, const D: usize> = Bodies<<Y as System<T, D>>::Count, T, <Y as System<T, D>>::Kept, D>;

/// A mechanical system with D coordinates per body, made ready for the scalar `T`.
///
/// ```text
/// M q̈ = f(q) + G(q, t)ᵀ λ,   g(q, t) = 0,   f = −∇U,   G = ∂g/∂q
/// ```
///
/// **Effects.** A system keeps the [forces](crate::effect::Forces) of its scene and answers for them. The defaults of
/// this trait are those of a system without effects. A system with effects takes [`EFFECTS`](Self::EFFECTS),
/// [`FLOWS`](Self::FLOWS), [`REMEMBERS`](Self::REMEMBERS) and [`PUSHES`](Self::PUSHES) from its forces, and a
/// simulation does not compile where it does not. It also implements [`moves_with_time`](Self::moves_with_time),
/// [`set_time`](Self::set_time), [`check_forces`](Self::check_forces), [`force`](Self::force), [`flow`](Self::flow),
/// [`flow_manner`](Self::flow_manner), [`first_marks`](Self::first_marks), [`take_note`](Self::take_note),
/// [`add_force_alone`](Self::add_force_alone) and [`effect_energies`](Self::effect_energies), and adds kick · ∂U/∂t to
/// the work in each kick. Nothing tells where one of these is missing.
pub trait System<T: Scalar, const D: usize>: Clone + Send + Sync + 'static {
    /// How many bodies there are: one, or many.
    type Count: Count;
    /// The quantities kept from step to step: normals and matrix factors at the positions, and the last forces.
    type Kept: Clone + Debug + Send + Sync;
    /// `Self`, or [`Never`](crate::motion::capability::Never) where kinetic energy and forces are not separate.
    type Rates: Rates<Self::Count, Self::Kept, T, D>;
    /// `Self`, or [`Never`](crate::motion::capability::Never) where there are no inner stages.
    type Collocation: Collocation<Self::Count, Self::Kept, T, D>;
    /// `Self`, or [`Never`](crate::motion::capability::Never) where there are no power series.
    type Series: Series<Self::Count, Self::Kept, T, D>;

    /// The number of effects that are [flows](crate::effect::Flow) of momenta.
    const FLOWS: usize = 0;

    /// The number of effects.
    const EFFECTS: usize = 0;

    /// Whether one of the effects has a [memory](crate::effect::Acting::REMEMBERS).
    const REMEMBERS: bool = false;

    /// Whether all flows are [pushes](crate::effect::Acting::PUSHES).
    const PUSHES: bool = true;

    /// The kind of system in words, for error messages: "a rigid body".
    fn kind(&self) -> &'static str;

    /// Bodies at these positions and momenta at this time, with all kept quantities evaluated there.
    fn bodies(&self, places: &[Body<T, D>], time: f64) -> BodiesOf<Self, T, D>;
    /// Evaluates the kept quantities again, after positions were restored.
    fn refresh(&self, bodies: &mut BodiesOf<Self, T, D>);

    /// Writes those kept quantities that cannot be evaluated again from positions, and counters.
    fn record(&self, _bodies: &BodiesOf<Self, T, D>, _to: &mut Record) {}

    /// Reads what [`record`](Self::record) wrote.
    ///
    /// # Errors
    /// [`Error::Record`] if another system wrote it.
    fn recall(&self, _bodies: &mut BodiesOf<Self, T, D>, _from: &mut Reading<'_>) -> Result<(), Error> {
        Ok(())
    }

    /// Restores everything that [`put_aside`](Self::put_aside) saved.
    #[inline(always)]
    fn put_back(&self, bodies: &mut BodiesOf<Self, T, D>, saved: &Saved<Self::Count, T, D>) {
        bodies.restore(saved);
        if const { Self::REMEMBERS } {
            bodies.marks.copy_from_slice(&saved.marks);
        }
        self.refresh(bodies);
    }

    /// Saves positions, momenta, time, work and the memory of effects, without allocating.
    #[inline(always)]
    fn put_aside<X>(&self, bodies: &Bodies<Self::Count, T, X, D>, to: &mut Saved<Self::Count, T, D>) {
        bodies.save(to);
        if const { Self::REMEMBERS } {
            to.marks.copy_from_slice(&bodies.marks);
        }
    }

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
    /// the kept normals. Iterations other than Newton's, and `Bdf2`, are only for such systems.
    #[inline(always)]
    fn is_cartesian(&self) -> bool {
        true
    }

    /// Whether constraints or forces depend on time.
    #[inline(always)]
    fn moves_with_time(&self) -> bool {
        false
    }

    /// Whether the energy changes by the work that is booked alone: no flows, and constraints that do none.
    #[inline(always)]
    fn keeps_energy(&self) -> bool {
        Self::FLOWS == 0 && !self.moves_with_time()
    }

    /// Sets the time at the end of a step, from which the sum of its stages may differ by rounding.
    #[inline(always)]
    fn set_time(&self, bodies: &mut BodiesOf<Self, T, D>, time: f64) {
        bodies.time = time;
    }

    /// Kicks for a time `kick`, then moves for a time `h`, to positions that satisfy the constraints. Afterwards
    /// normals are those of the new positions, and forces still the old ones. Momenta must be tangent to the
    /// constraints. With `kick` 0 forces are not used. `witness` gets λ, the impulse divided by h/2. Neither allocates
    /// nor panics.
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

    /// Evaluates the forces at the present positions.
    fn evaluate_forces(&self, bodies: &mut BodiesOf<Self, T, D>);

    /// Checks that the last forces are finite, for methods whose steps end before the kick that would show it. A system
    /// without forces does nothing.
    ///
    /// # Errors
    /// [`EffectFailure::ForceNotFinite`](crate::error::EffectFailure::ForceNotFinite).
    fn check_forces(&self, _bodies: &BodiesOf<Self, T, D>) -> Result<(), Failure> {
        Ok(())
    }

    /// Kicks for a time `kick`, and makes the momenta tangent to the constraints. `witness` gets μ, the impulse divided
    /// by h/2.
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

    /// Writes the changes of the momenta by flow number `number`, at the present positions and time, without
    /// constraints. Neither allocates nor panics.
    fn flow(
        &self,
        _number: usize,
        _given: Given<'_, T, D>,
        _bodies: &mut BodiesOf<Self, T, D>,
        changes: &mut [[T; D]],
    ) {
        changes.fill([T::from_f64(0.0); D]);
    }

    /// The memory of the effects at the start of a run, at the present positions and random numbers.
    ///
    /// # Errors
    /// The name of the type of an effect that cannot act here, and why.
    fn first_marks(&self, _bodies: &BodiesOf<Self, T, D>) -> Result<Vec<T>, (&'static str, EffectMistake)> {
        Ok(Vec::new())
    }

    /// Lets flow number `number` update its memory for the present positions and the time that passes. Neither
    /// allocates nor panics.
    fn take_note(&self, _number: usize, _given: Given<'_, T, D>, _bodies: &mut BodiesOf<Self, T, D>) {}

    /// Adds the force of effect number `number` alone, and returns the name of its type; `None` for a flow, and past
    /// the last effect.
    fn add_force_alone(
        &self,
        _number: usize,
        _bodies: &mut BodiesOf<Self, T, D>,
        _forces: &mut [[T; D]],
    ) -> Option<&'static str> {
        None
    }

    /// The properties of flow number `number`, and the name of its type.
    fn flow_manner(&self, _number: usize) -> (Manner, &'static str) {
        (Manner { rule: Rule::Symmetric, feels: false, pushes: false }, "")
    }

    /// Whether constraints change with time, so that they move bodies.
    fn constraints_move(&self) -> bool {
        false
    }

    /// Masses, in the coordinates of the momenta; by default unit masses.
    fn inertia(&self) -> &dyn Inertia<T, D> {
        &UnitMasses
    }

    /// Writes ṗ = f + Gᵀλ of each body at the present state, and the constraint force Gᵀλ by itself. Zeros where there
    /// are no [rates](Self::rates). Neither allocates nor panics.
    fn feel(&self, bodies: &mut BodiesOf<Self, T, D>, rates: &mut [[T; D]], holding: &mut [[T; D]]) {
        rates.fill([T::from_f64(0.0); D]);
        if let Ok(capability) = self.rates() {
            capability.evaluate_rates(bodies, rates, &mut ());
        }
        for (body, (held, rate)) in holding.iter_mut().zip(&*rates).enumerate() {
            *held = add_scaled(rate, T::from_f64(-1.0), &self.force(bodies, body));
        }
    }

    /// The last force on a body, for a system with [rates](Self::rates).
    fn force(&self, _bodies: &BodiesOf<Self, T, D>, _body: usize) -> [T; D] {
        [T::from_f64(0.0); D]
    }

    /// The number of independent momenta: coordinates of bodies that are not pinned, minus independent equations.
    fn freedom(&self, bodies: &BodiesOf<Self, T, D>) -> usize {
        (bodies.q.as_ref().len() * D).saturating_sub(self.equations())
    }

    /// Checks whether the normal of a constraint jumps between the saved and the present positions. Does nothing where
    /// constraints have no kinks.
    ///
    /// # Errors
    /// [`StepFailure::Kink`](crate::error::StepFailure::Kink).
    #[inline(always)]
    fn check_kinks(
        &self,
        _before: &Saved<Self::Count, T, D>,
        _now: &BodiesOf<Self, T, D>,
    ) -> Result<(), Failure> {
        Ok(())
    }

    /// Writes ∇g for every body at the present positions, of the equation whose normal jumps according to
    /// [`check_kinks`](Self::check_kinks). Systems that report kinks must implement this.
    fn kinked_normal(&self, _bodies: &BodiesOf<Self, T, D>, _kink: &Failure, normal: &mut [[T; D]]) {
        normal.fill([T::from_f64(0.0); D]);
    }

    /// Checks whether a step of length h has passed a singular point. Does nothing where there are none.
    ///
    /// # Errors
    /// [`StepFailure::NoNormal`](crate::error::StepFailure::NoNormal).
    #[inline(always)]
    fn check_normals(
        &self,
        _h: f64,
        _before: &Saved<Self::Count, T, D>,
        _now: &BodiesOf<Self, T, D>,
    ) -> Result<(), Failure> {
        Ok(())
    }

    /// Checks whether a step of length h, by a method that does not follow the root of its constraints, has ended on
    /// another sheet. Does nothing where the system cannot tell.
    ///
    /// # Errors
    /// [`StepFailure::OtherSheet`](crate::error::StepFailure::OtherSheet).
    #[inline(always)]
    fn check_sheets(
        &self,
        _h: f64,
        _before: &Saved<Self::Count, T, D>,
        _now: &mut BodiesOf<Self, T, D>,
    ) -> Result<(), Failure> {
        Ok(())
    }

    /// The number of corrections in the solution of position equations since the start; `None` where they are not
    /// counted.
    fn corrections(&self, _bodies: &BodiesOf<Self, T, D>) -> Option<u64> {
        None
    }

    /// The number of equations g = 0, and of multipliers.
    fn equations(&self) -> usize;
    /// M⁻¹p of a body.
    fn velocity<X>(&self, bodies: &Bodies<Self::Count, T, X, D>, body: usize) -> [T; D];
    /// Moves bodies on for a time h as they go now, roughly: where a step that failed may have led.
    fn coast(&self, h: f64, bodies: &mut BodiesOf<Self, T, D>) {
        for body in 0..bodies.q.as_ref().len() {
            let v = self.velocity(bodies, body);
            let q = &mut bodies.q.as_mut()[body];
            *q = add_scaled(q, T::from_f64(h), &v);
        }
        bodies.time += h;
    }
    /// U, from positions alone.
    fn potential_energy<X>(&self, bodies: &Bodies<Self::Count, T, X, D>) -> T;
    /// Appends U of each effect that is not a flow, in the order of the scene.
    fn effect_energies<X>(&self, _bodies: &Bodies<Self::Count, T, X, D>, _to: &mut Vec<T>) {}

    /// pᵀM⁻¹p/2, summed over the bodies, from positions and momenta alone.
    fn kinetic_energy<X>(&self, bodies: &Bodies<Self::Count, T, X, D>) -> T {
        let parts = bodies.p.as_ref().iter().zip(bodies.p_low.as_ref()).enumerate();
        let energy = parts.map(|(body, (p, low))| {
            let v = self.velocity(bodies, body);
            T::from_f64(0.5) * dot(p, &v) + dot(low, &v)
        });
        energy.fold(T::from_f64(0.0), |sum, part| sum + part)
    }

    /// Writes g(q, t) of each equation. A system with equations must implement this.
    fn residuals(&self, _bodies: &BodiesOf<Self, T, D>, _g: &mut [T]) {
        debug_assert_eq!(self.equations(), 0, "{} has equations", self.kind());
    }
    /// Writes G M⁻¹p + ∂g/∂t of each equation. A system with equations must implement this.
    fn drift_rates(&self, _bodies: &BodiesOf<Self, T, D>, _rates: &mut [T]) {
        debug_assert_eq!(self.equations(), 0, "{} has equations", self.kind());
    }
    /// Writes Gᵀλ of each body, with λ of [`multipliers`](Self::multipliers); zeros where there are no equations. A
    /// system with equations must implement this.
    fn constraint_forces(&self, _bodies: &BodiesOf<Self, T, D>, forces: &mut [[T; D]]) {
        debug_assert_eq!(self.equations(), 0, "{} has equations", self.kind());
        forces.fill([T::from_f64(0.0); D]);
    }

    /// Writes λ of each equation such that g̈ = 0 at the present state, by default from the [rates](Self::rates). A
    /// system with equations and without rates must implement this.
    fn multipliers(&self, bodies: &BodiesOf<Self, T, D>, multipliers: &mut [T]) {
        let mut rates = vec![[T::from_f64(0.0); D]; bodies.q.as_ref().len()];
        let told = rates_at(self, bodies, &mut rates, &mut Told(multipliers));
        debug_assert!(told.is_ok() || self.equations() == 0, "{} has equations", self.kind());
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

/// The input of a flow besides positions and momenta.
#[derive(Debug, Clone, Copy)]
pub struct Given<'a, T, const D: usize> {
    /// The time for which the flow acts.
    pub h: f64,
    /// Whether the flow acts before a step.
    pub before: bool,
    /// M⁻¹p of all bodies.
    pub velocities: &'a [[T; D]],
    /// ṗ of all bodies, for a flow that depends on it.
    pub rates: &'a [[T; D]],
    /// Gᵀλ of all bodies, for a flow that depends on it.
    pub holding: &'a [[T; D]],
    /// The part of ṗ h that is not yet in the momenta, for a flow that depends on it.
    pub coming: &'a [[T; D]],
    /// The kinetic energy imposed by moving constraints.
    pub imposed: T,
    /// Random numbers.
    pub noise: Noise,
}

impl<'a, T: Scalar, const D: usize> Given<'a, T, D> {
    /// For so long, before a step or after it, with nothing laid beside.
    pub(crate) fn of(h: f64, before: bool, noise: Noise) -> Self {
        let imposed = T::from_f64(0.0);
        Self { h, before, velocities: &[], rates: &[], holding: &[], coming: &[], imposed, noise }
    }

    /// With the rest of an [`Interval`]: what bodies are asked for, their masses, surfaces, and how they are coupled.
    pub(crate) fn interval(
        self,
        (at, momenta, marks): (Moment<'a, T, D>, &'a [[T; D]], &'a [T]),
        inertia: &'a dyn Inertia<T, D>,
        surface: Option<&'a dyn Normals<T, D>>,
        (tied, freedom): (bool, usize),
    ) -> Interval<'a, T, D> {
        let Self { h, before, velocities, rates, holding, coming, imposed, noise } = self;
        Interval {
            h,
            before,
            at,
            momenta,
            velocities,
            rates,
            holding,
            coming,
            imposed,
            inertia,
            surface,
            marks,
            tied,
            freedom,
            noise,
        }
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
