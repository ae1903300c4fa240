//! What a method moves: bodies, what holds them and what acts on them, behind three verbs.
//!
//! ```text
//! drift    p½ = p  + c (f(q)  + G(q)ᵀ λ),   q′ = q + h M⁻¹ p½      λ such that g(q′) = 0
//! evaluate f(q′)
//! settle   p′ = p½ + c (f(q′) + G(q′)ᵀμ)                           μ such that G(q′) M⁻¹ p′ = −∂g/∂t
//! ```
//!
//! With c = h/2 the three in turn are a step of RATTLE; other orders and other c make the other methods. [`OnSurface`](crate::systems::surface::kept::OnSurface) holds each body on a
//! surface of its own, in lanes if wanted; [`Linked`](crate::systems::linked::Linked) is for everything else.

use crate::error::StepFailure;
use crate::motion::bodies::{Bodies, Body, Count};
use crate::motion::failure::Failure;
use crate::motion::iteration::{Iteration, Newton};
use crate::motion::need::Need;
use crate::motion::table::Table;
use crate::motion::witness::Witness;
use crate::number::real::{Mask, Real};
use crate::number::vector::{sum, two_sum};
use std::array::from_fn;
use std::fmt::Debug;

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

    /// The bodies in these places at this time, with all evaluated there that is kept.
    fn bodies(&self, place: impl Fn(usize) -> Body<T, D>, time: f64)
    -> Bodies<Self::Count, T, Self::Kept, D>;
    /// Evaluates anew what is kept, after positions were put back.
    fn refresh(&self, bodies: &mut Bodies<Self::Count, T, Self::Kept, D>);

    /// Whether anything looks at the time.
    #[inline(always)]
    fn moves_with_time(&self) -> bool {
        false
    }

    /// Sets the time at the end of a step, which the sum of its stages may miss by rounding.
    #[inline(always)]
    fn set_time(&self, bodies: &mut Bodies<Self::Count, T, Self::Kept, D>, time: f64) {
        bodies.time = time;
    }

    /// Kicks for a time `kick`, then moves for a time `h`, to where the constraints hold. Normals are then those of the
    /// new positions, forces still the old ones. Momenta must be along the constraints. With `kick` 0 forces are not
    /// looked at. `witness` is told λ as an impulse over h/2. Neither allocates nor panics.
    ///
    /// The position equation is solved by `X`, begun with `guess`, on the scale of what `witness` is told, or if that is
    /// empty from g̈ = 0; where that is no help, as by [`drift`](Self::drift). The result is the same but in the last bits. A
    /// system that solves another equation takes no notice.
    ///
    /// # Errors
    /// Says which body cannot be moved and why; the bodies are then left half way.
    fn drift_by<X: Iteration, W: Witness<T>>(
        &self,
        kick: f64,
        h: f64,
        guess: &[T],
        bodies: &mut Bodies<Self::Count, T, Self::Kept, D>,
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
        bodies: &mut Bodies<Self::Count, T, Self::Kept, D>,
        witness: &mut W,
    ) -> Result<(), Failure> {
        self.drift_by::<Newton, W>(kick, h, &[], bodies, witness)
    }

    /// Evaluates the forces at the present positions.
    fn evaluate_forces(&self, bodies: &mut Bodies<Self::Count, T, Self::Kept, D>);

    /// Kicks for a time `kick` and makes the momenta those of motion along the constraints. `witness` is told μ as an
    /// impulse over h/2.
    ///
    /// # Errors
    /// As [`drift`](Self::drift).
    fn settle<W: Witness<T>>(
        &self,
        kick: f64,
        h: f64,
        bodies: &mut Bodies<Self::Count, T, Self::Kept, D>,
        witness: &mut W,
    ) -> Result<(), Failure>;

    /// How many of the effects are [flows](crate::effect::Flow) of momenta.
    #[inline(always)]
    fn flows(&self) -> usize {
        0
    }
    /// Writes what the momenta change by in a time h by the flow of this number, at the present places and time.
    fn flow(
        &self,
        _number: usize,
        _h: f64,
        _bodies: &mut Bodies<Self::Count, T, Self::Kept, D>,
        _velocities: &[[T; D]],
        changes: &mut [[T; D]],
    ) {
        changes.fill([T::from_f64(0.0); D]);
    }

    /// Has a flow change the momenta for a time h, and makes them those of motion along the constraints again. Positions, and what is
    /// kept there, stay. The change of kinetic energy counts as work. Allocates only where [`Bodies::room`] has not
    /// two vectors per body.
    ///
    /// # Errors
    /// As [`settle`](Self::settle).
    fn stir(
        &self,
        number: usize,
        h: f64,
        bodies: &mut Bodies<Self::Count, T, Self::Kept, D>,
    ) -> Result<(), Failure> {
        let (before, work) = (self.kinetic_energy(bodies), bodies.work);
        bodies.with_room(2, |bodies, room| {
            let n = bodies.q.as_ref().len();
            let (velocities, changes) = room.split_at_mut(n);
            for (body, velocity) in velocities.iter_mut().enumerate() {
                *velocity = self.velocity(bodies, body);
            }
            self.flow(number, h, bodies, velocities, changes);
            for (body, change) in changes.iter().enumerate() {
                let ones = [T::from_f64(1.0); D];
                let pinned = self.mass_product(body, &ones, &ones).le(T::from_f64(0.0)).all();
                let (p, p_low) = (&mut bodies.p.as_mut()[body], &mut bodies.p_low.as_mut()[body]);
                if !pinned {
                    (*p, *p_low) = two_sum(p, &sum(p_low, change));
                }
            }
        });
        self.settle(0.0, h, bodies, &mut ())?;
        // Links that move book what they do to make momenta fit; that is in the change of energy too.
        bodies.work = work + (self.kinetic_energy(bodies) - before);
        Ok(())
    }

    /// Writes ṗ = f + Gᵀλ of each body, with λ such that g̈ = 0, at the present places and from what is kept there. Places
    /// and momenta may be a little off the constraints. Returns the power of moving constraints, −λᵀ ∂g/∂t. `witness` is
    /// told λ as that of the start of a step. Neither allocates nor panics.
    fn rates<W: Witness<T>>(
        &self,
        bodies: &mut Bodies<Self::Count, T, Self::Kept, D>,
        rates: &mut [[T; D]],
        witness: &mut W,
    ) -> T;

    /// Moves positions that a time `h` has brought a little off the constraints back to them, the least way as masses
    /// measure it, to rounding; evaluates there what is kept. Momenta stay; [`settle`](Self::settle) with kick 0 moves them.
    /// Neither allocates nor panics.
    ///
    /// # Errors
    /// As [`drift`](Self::drift); where the iteration does not come nearer to the constraints.
    fn project(&self, h: f64, bodies: &mut Bodies<Self::Count, T, Self::Kept, D>) -> Result<(), Failure>;

    /// Makes room for a method of so many inner stages, so that its steps need not allocate.
    fn reserve(&self, _bodies: &mut Bodies<Self::Count, T, Self::Kept, D>, _stages: usize) {}

    /// What keeps the system from being moved by methods with this need, if anything does.
    fn refuses(&self, _need: Need) -> Option<&'static str> {
        None
    }

    /// Takes one step of the collocation method with this table. `memory` is empty, or has room for a number and, for each
    /// stage, f + Gᵀλ of each body and λ of each equation: the iteration then begins with what the last step left there.
    ///
    /// # Errors
    /// As [`drift`](Self::drift); and where the system has no collocation.
    fn collocate<W: Witness<T>, const S: usize>(
        &self,
        table: &Table<S>,
        h: f64,
        bodies: &mut Bodies<Self::Count, T, Self::Kept, D>,
        memory: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure>;

    /// Makes room for power series of so many coefficients.
    fn reserve_series(&self, _bodies: &mut Bodies<Self::Count, T, Self::Kept, D>, _orders: usize) {}

    /// Writes the power series of the motion in time from the present state on, into as many coefficients as there is
    /// room for: q₀ of all bodies, q₁ of all, … `witness` is told λ at the start. Neither allocates nor panics.
    ///
    /// # Errors
    /// Where the system has none.
    fn expand<W: Witness<T>>(
        &self,
        _bodies: &mut Bodies<Self::Count, T, Self::Kept, D>,
        _series: &mut [[T; D]],
        _witness: &mut W,
    ) -> Result<(), Failure> {
        Err(Failure { body: 0, cause: StepFailure::NoSeries })
    }

    /// The change of a body's momentum in a time h from where the motion was expanded last, from that of its velocity.
    #[inline(always)]
    fn expanded_impulse(
        &self,
        _bodies: &Bodies<Self::Count, T, Self::Kept, D>,
        body: usize,
        change: &[T; D],
        _h: f64,
    ) -> [T; D] {
        self.momentum(body, change)
    }

    /// The work that moving constraints do in a time h from where the motion was expanded last.
    #[inline(always)]
    fn expanded_work(&self, _bodies: &Bodies<Self::Count, T, Self::Kept, D>, _h: f64) -> T {
        T::from_f64(0.0)
    }

    /// The number of equations g = 0, that is of multipliers.
    fn equations(&self) -> usize;
    /// M⁻¹p of a body.
    fn velocity(&self, bodies: &Bodies<Self::Count, T, Self::Kept, D>, body: usize) -> [T; D];
    /// aᵀM b, for changes of position of a body; 0 for one that is pinned.
    fn mass_product(&self, body: usize, a: &[T; D], b: &[T; D]) -> T;
    /// M v of a body; 0 for one that is pinned.
    fn momentum(&self, body: usize, v: &[T; D]) -> [T; D] {
        from_fn(|i| {
            let unit = from_fn(|k| T::from_f64(if k == i { 1.0 } else { 0.0 }));
            self.mass_product(body, &unit, v)
        })
    }
    /// Writes q̈ = M⁻¹(f + Gᵀλ) of each body, from the present state alone.
    fn accelerations(&self, bodies: &Bodies<Self::Count, T, Self::Kept, D>, accelerations: &mut [[T; D]]);
    /// Writes Gᵀλ of each body, with λ of [`multipliers`](Self::multipliers); zeros where there are no equations.
    fn constraint_forces(&self, bodies: &Bodies<Self::Count, T, Self::Kept, D>, forces: &mut [[T; D]]);
    /// pᵀM⁻¹p/2, summed over the bodies, from places and momenta alone.
    fn kinetic_energy<X>(&self, bodies: &Bodies<Self::Count, T, X, D>) -> T;
    /// U, from places alone.
    fn potential_energy<X>(&self, bodies: &Bodies<Self::Count, T, X, D>) -> T;
    /// Writes g(q, t) of each equation.
    fn residuals(&self, bodies: &Bodies<Self::Count, T, Self::Kept, D>, g: &mut [T]);
    /// Writes G M⁻¹p + ∂g/∂t of each equation.
    fn drift_rates(&self, bodies: &Bodies<Self::Count, T, Self::Kept, D>, rates: &mut [T]);
    /// Writes λ of each equation from the present state alone: such that g̈ = 0.
    fn multipliers(&self, bodies: &Bodies<Self::Count, T, Self::Kept, D>, multipliers: &mut [T]);
}
