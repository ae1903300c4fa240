//! A system: bodies, constraints and forces, as a method sees them. Every method uses three verbs:
//!
//! ```text
//! drift    p½ = p  + c (f(q)  + G(q)ᵀ λ),   q′ = q + h M⁻¹ p½      λ such that g(q′) = 0
//! evaluate f(q′)
//! settle   p′ = p½ + c (f(q′) + G(q′)ᵀμ)                           μ such that G(q′) M⁻¹ p′ = −∂g/∂t
//! ```
//!
//! With c = h/2 the three in turn are a step of RATTLE; other orders and other c make the other methods. Some methods
//! need more, which a system has or has not: its [capabilities](crate::motion::capability).
//!
//! [`OnSurface`](crate::systems::surface::kept::OnSurface) holds each body on a surface of its own, in lanes if wanted;
//! [`Linked`](crate::systems::linked::Linked) is for everything else.

use crate::effect::interval::{Inertia, Manner, Rule, UnitMasses};
use crate::effect::noise::Noise;
use crate::error::{EffectMistake, Error};
use crate::motion::bodies::{Bodies, Body, Count, Saved};
use crate::motion::capability::{Collocation, Rates, Series};
use crate::motion::failure::Failure;
use crate::motion::iteration::{Iteration, Newton};
use crate::motion::record::{Reading, Record};
use crate::motion::witness::Witness;
use crate::number::real::Real;
use crate::number::vector::{add_scaled, dot};
use std::fmt::Debug;

/// The bodies of a system, with what it keeps at them.
pub type BodiesOf<Y, T, const D: usize> = Bodies<<Y as System<T, D>>::Count, T, <Y as System<T, D>>::Kept, D>;

/// A mechanical system with D coordinates per body, made ready for the scalar `T`.
///
/// ```text
/// M q̈ = f(q) + G(q, t)ᵀ λ,   g(q, t) = 0,   f = −∇U,   G = ∂g/∂q
/// ```
pub trait System<T: Real, const D: usize>: Clone + Send + Sync + 'static {
    /// How many bodies there are: one, or many.
    type Count: Count;
    /// What is kept from one step to the next: normals and factors at the positions, and the forces last evaluated.
    type Kept: Clone + Debug + Send + Sync;
    /// `Self`, or [`Never`](crate::motion::capability::Never) where forces and momenta are not apart.
    type Rates: Rates<Self::Count, Self::Kept, T, D>;
    /// `Self`, or [`Never`](crate::motion::capability::Never) where there are no inner stages.
    type Collocation: Collocation<Self::Count, Self::Kept, T, D>;
    /// `Self`, or [`Never`](crate::motion::capability::Never) where there are no power series.
    type Series: Series<Self::Count, Self::Kept, T, D>;

    /// How many of the effects are [flows](crate::effect::Flow) of momenta.
    const FLOWS: usize = 0;

    /// How many effects there are.
    const EFFECTS: usize = 0;

    /// Whether one of the effects [remembers](crate::effect::Acting::REMEMBERS) anything.
    const REMEMBERS: bool = false;

    /// Whether all flows are [pushes](crate::effect::Acting::PUSHES).
    const PUSHES: bool = true;

    /// What messages call such a system: "a rigid body".
    fn kind(&self) -> &'static str;

    /// The bodies in these places, one for each, at this time, with all evaluated there that is kept.
    fn bodies(&self, places: &[Body<T, D>], time: f64) -> BodiesOf<Self, T, D>;
    /// Evaluates anew what is kept, after positions were put back.
    fn refresh(&self, bodies: &mut BodiesOf<Self, T, D>);

    /// Writes what is kept that no evaluation at the places brings back and a step looks at, or that was counted.
    fn record(&self, _bodies: &BodiesOf<Self, T, D>, _to: &mut Record) {}

    /// Takes back what [`record`](Self::record) wrote.
    ///
    /// # Errors
    /// [`Error::Record`] for what another system wrote.
    fn recall(&self, _bodies: &mut BodiesOf<Self, T, D>, _from: &mut Reading<'_>) -> Result<(), Error> {
        Ok(())
    }

    /// Everything as it was when it was saved.
    #[inline(always)]
    fn put_back(&self, bodies: &mut BodiesOf<Self, T, D>, saved: &Saved<Self::Count, T, D>) {
        bodies.restore(saved);
        if const { Self::REMEMBERS } {
            bodies.marks.copy_from_slice(&saved.marks);
        }
        self.refresh(bodies);
    }

    /// Puts everything aside, without allocating.
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
    /// Where they are not known: the kind of system, as messages call it.
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

    /// Whether momenta are M v in the coordinates of the places, and [`drift`](Self::drift) solves g(q′) = 0 along
    /// normals that are kept. Other ways to solve it than Newton's, and `Bdf2`, are for such systems alone.
    #[inline(always)]
    fn is_cartesian(&self) -> bool {
        true
    }

    /// Whether anything looks at the time.
    #[inline(always)]
    fn moves_with_time(&self) -> bool {
        false
    }

    /// Sets the time at the end of a step, which the sum of its stages may miss by rounding.
    #[inline(always)]
    fn set_time(&self, bodies: &mut BodiesOf<Self, T, D>, time: f64) {
        bodies.time = time;
    }

    /// Kicks for a time `kick`, then moves for a time `h`, to where the constraints hold. Normals are then those of the
    /// new positions, forces still the old ones. Momenta must be along the constraints. With `kick` 0 forces are not
    /// looked at. `witness` is told λ as an impulse over h/2. Neither allocates nor panics.
    ///
    /// The position equation is solved by `X`, begun with `guess`, on the scale of what `witness` is told, or if that
    /// is empty from g̈ = 0; where that is no help, as by [`drift`](Self::drift). The result is the same but in the
    /// last bits. A system that solves another equation takes no notice.
    ///
    /// # Errors
    /// Says which body cannot be moved and why; the bodies are then left half way.
    fn drift_by<X: Iteration, W: Witness<T>>(
        &self,
        kick: f64,
        h: f64,
        guess: &[T],
        bodies: &mut BodiesOf<Self, T, D>,
        witness: &mut W,
    ) -> Result<(), Failure>;

    /// [`drift_by`](Self::drift_by) Newton's method, from g̈ = 0.
    ///
    /// # Errors
    /// As there.
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

    /// Looks whether the forces last evaluated are numbers: for methods whose steps end before the kick that would
    /// tell. A system without forces says nothing.
    ///
    /// # Errors
    /// [`StepFailure::ForceNotFinite`](crate::error::StepFailure::ForceNotFinite).
    fn check_forces(&self, _bodies: &BodiesOf<Self, T, D>) -> Result<(), Failure> {
        Ok(())
    }

    /// Kicks for a time `kick` and makes the momenta those of motion along the constraints. `witness` is told μ as an
    /// impulse over h/2.
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

    /// Writes what the momenta change by by the flow of this number, at the present places and time, constraints aside.
    /// Neither allocates nor panics.
    fn flow(
        &self,
        _number: usize,
        _given: Given<'_, T, D>,
        _bodies: &mut BodiesOf<Self, T, D>,
        changes: &mut [[T; D]],
    ) {
        changes.fill([T::from_f64(0.0); D]);
    }

    /// What effects remember at the start of a run, at the present places and with the random numbers of now.
    ///
    /// # Errors
    /// Of an effect that cannot act here, by the name of its type.
    fn first_marks(&self, _bodies: &BodiesOf<Self, T, D>) -> Result<Vec<T>, (&'static str, EffectMistake)> {
        Ok(Vec::new())
    }

    /// Has the flow of this number take note of the present places, and of a time that passes. Neither allocates nor
    /// panics.
    fn take_note(&self, _number: usize, _given: Given<'_, T, D>, _bodies: &mut BodiesOf<Self, T, D>) {}

    /// Adds the force of the effect of this number alone, and tells the name of its type; none of a flow, or where
    /// there are no more.
    fn add_force_alone(
        &self,
        _number: usize,
        _bodies: &mut BodiesOf<Self, T, D>,
        _forces: &mut [[T; D]],
    ) -> Option<&'static str> {
        None
    }

    /// What the flow of this number is like, and the name of its type.
    fn flow_manner(&self, _number: usize) -> (Manner, &'static str) {
        (Manner { rule: Rule::Symmetric, feels: false, pushes: false }, "")
    }

    /// Whether constraints change with time, so that they move bodies.
    fn constraints_move(&self) -> bool {
        false
    }

    /// Masses, in the coordinates of the momenta; unit masses if nothing else is said.
    fn inertia(&self) -> &dyn Inertia<T, D> {
        &UnitMasses
    }

    /// Writes ṗ of each body by forces and constraints at the present state, and the part Gᵀλ of it that holds the
    /// bodies on their constraints. Zeros where [rates](Self::rates) are not known. Neither allocates nor panics.
    fn feel(&self, bodies: &mut BodiesOf<Self, T, D>, rates: &mut [[T; D]], holding: &mut [[T; D]]) {
        rates.fill([T::from_f64(0.0); D]);
        if let Ok(capability) = self.rates() {
            capability.evaluate_rates(bodies, rates, &mut ());
        }
        for (body, (held, rate)) in holding.iter_mut().zip(&*rates).enumerate() {
            *held = add_scaled(rate, T::from_f64(-1.0), &self.force(bodies, body));
        }
    }

    /// The force on a body that was last evaluated, of a system with [rates](Self::rates).
    fn force(&self, _bodies: &BodiesOf<Self, T, D>, _body: usize) -> [T; D] {
        [T::from_f64(0.0); D]
    }

    /// The number of independent momenta: coordinates that are free to move less independent equations.
    fn freedom(&self, bodies: &BodiesOf<Self, T, D>) -> usize {
        (bodies.q.as_ref().len() * D).saturating_sub(self.equations())
    }

    /// Looks whether the normal of a constraint jumps between the places put aside and those of now. Nothing where
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

    /// Writes ∇g of the equation of which [`check_kinks`](Self::check_kinks) said that its normal jumps, at the present
    /// places, of every body; a system that says so says this too.
    fn kinked_normal(&self, _bodies: &BodiesOf<Self, T, D>, _kink: &Failure, normal: &mut [[T; D]]) {
        normal.fill([T::from_f64(0.0); D]);
    }

    /// Looks whether a step of length h has passed a singular point. A system that has none says nothing.
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

    /// Looks whether a step of length h, after so many, that did not follow the root of its constraint has ended on
    /// another sheet. A system that cannot tell says nothing.
    ///
    /// # Errors
    /// [`StepFailure::OtherSheet`](crate::error::StepFailure::OtherSheet).
    #[inline(always)]
    fn check_sheets(
        &self,
        _steps: u64,
        _h: f64,
        _before: &Saved<Self::Count, T, D>,
        _now: &mut BodiesOf<Self, T, D>,
    ) -> Result<(), Failure> {
        Ok(())
    }

    /// Corrections of position equations that were made since the start, where they are counted.
    fn corrections(&self, _bodies: &BodiesOf<Self, T, D>) -> Option<u64> {
        None
    }

    /// The number of equations g = 0, that is of multipliers.
    fn equations(&self) -> usize;
    /// M⁻¹p of a body.
    fn velocity<X>(&self, bodies: &Bodies<Self::Count, T, X, D>, body: usize) -> [T; D];
    /// U, from places alone.
    fn potential_energy<X>(&self, bodies: &Bodies<Self::Count, T, X, D>) -> T;
    /// Appends U of each effect that is no flow, in the order in which the scene names them.
    fn effect_energies<X>(&self, _bodies: &Bodies<Self::Count, T, X, D>, _to: &mut Vec<T>) {}

    /// pᵀM⁻¹p/2, summed over the bodies, from places and momenta alone.
    fn kinetic_energy<X>(&self, bodies: &Bodies<Self::Count, T, X, D>) -> T {
        let parts = bodies.p.as_ref().iter().zip(bodies.p_low.as_ref()).enumerate();
        let energy = parts.map(|(body, (p, low))| {
            let v = self.velocity(bodies, body);
            T::from_f64(0.5) * dot(p, &v) + dot(low, &v)
        });
        energy.fold(T::from_f64(0.0), |sum, part| sum + part)
    }

    /// Writes g(q, t) of each equation; a system with equations says how.
    fn residuals(&self, _bodies: &BodiesOf<Self, T, D>, _g: &mut [T]) {
        debug_assert_eq!(self.equations(), 0, "{} has equations", self.kind());
    }
    /// Writes G M⁻¹p + ∂g/∂t of each equation; a system with equations says how.
    fn drift_rates(&self, _bodies: &BodiesOf<Self, T, D>, _rates: &mut [T]) {
        debug_assert_eq!(self.equations(), 0, "{} has equations", self.kind());
    }
    /// Writes Gᵀλ of each body, with λ of [`multipliers`](Self::multipliers): zeros where there are no equations; a
    /// system with equations says how.
    fn constraint_forces(&self, _bodies: &BodiesOf<Self, T, D>, forces: &mut [[T; D]]) {
        debug_assert_eq!(self.equations(), 0, "{} has equations", self.kind());
        forces.fill([T::from_f64(0.0); D]);
    }

    /// Writes λ of each equation from the present state alone: such that g̈ = 0. That of the [rates](Self::rates); a
    /// system with equations and without rates says how.
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

/// What a system is given of a flow: for how long, and what it lays beside positions and momenta.
#[derive(Debug, Clone, Copy)]
pub struct Given<'a, T, const D: usize> {
    /// For how long.
    pub h: f64,
    /// Whether before a step.
    pub before: bool,
    /// M⁻¹p of all bodies.
    pub velocities: &'a [[T; D]],
    /// ṗ of all bodies, for a flow that feels it.
    pub rates: &'a [[T; D]],
    /// Gᵀλ of all bodies, likewise.
    pub holding: &'a [[T; D]],
    /// What of ṗ h is still to come, likewise.
    pub coming: &'a [[T; D]],
    /// The kinetic energy that constraints which move impose.
    pub imposed: T,
    /// Random numbers.
    pub noise: Noise,
}

impl<T: Real, const D: usize> Given<'_, T, D> {
    /// For so long, before a step or after it, with nothing laid beside.
    pub(crate) fn of(h: f64, before: bool, noise: Noise) -> Self {
        let imposed = T::from_f64(0.0);
        Self { h, before, velocities: &[], rates: &[], holding: &[], coming: &[], imposed, noise }
    }
}

/// Writes ṗ of each body from the present state alone; returns the bodies with the forces there.
fn rates_at<T: Real, Y: System<T, D>, const D: usize>(
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

impl<T: Real> Witness<T> for Told<'_, T> {
    fn position_multiplier(&mut self, equation: usize, lambda: T) {
        self.0[equation] = lambda;
    }
    fn momentum_multiplier(&mut self, _: usize, _: T) {}
}
