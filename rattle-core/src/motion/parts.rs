//! What a system is made of: its bodies, their masses, what is kept for each state, and the effects of its scene.

use crate::effect::interval::{Inertia, Interval, Normals, UnitMasses};
use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::effect::noise::Noise;
use crate::error::Error;
use crate::motion::bodies::{Bodies, Body, Count};
use crate::motion::record::{Reading, Record};
use crate::number::real::Scalar;
use std::fmt::Debug;

/// The bodies of a system, with the quantities that it keeps for them.
pub type BodiesOf<Y, T, const D: usize> = Bodies<<Y as Parts<T, D>>::Count, T, <Y as Parts<T, D>>::Kept, D>;

/// The working memory of the effects of a system.
pub type RoomOf<Y, T, const D: usize> = <<Y as Parts<T, D>>::Effects as Forces<T, D>>::Room;

/// The force that the effects of a system store for each body.
pub type ForceOf<Y, T, const D: usize> = <<Y as Parts<T, D>>::Effects as Forces<T, D>>::Force;

/// What a [`System`](crate::motion::system::System) is made of.
pub trait Parts<T: Scalar, const D: usize>: Clone + Send + Sync + 'static {
    /// How many bodies there are: one, or many.
    type Count: Count;
    /// The quantities kept from step to step: normals and matrix factors at the positions, and the last forces.
    type Kept: Clone + Debug + Send + Sync;
    /// The effects of the scene; `()` where a system can have none.
    type Effects: Forces<T, D>;

    /// The first so many components of a momentum are in use; the others are 0, and no effect changes them.
    const MOMENTA: usize = D;

    /// The kind of system in words, for error messages: "a rigid body".
    fn kind(&self) -> &'static str;
    /// The number of equations g = 0, and of multipliers.
    fn equations(&self) -> usize;
    /// Whether constraints change with time, so that they move bodies.
    #[inline(always)]
    fn constraints_move(&self) -> bool {
        false
    }

    /// The effects of the scene.
    fn effects(&self) -> &Self::Effects;
    /// The working memory of the effects.
    fn room_of(kept: &mut Self::Kept) -> &mut RoomOf<Self, T, D>;
    /// The last forces, one for each body; none where a system can have no effects.
    fn forces_of(kept: &Self::Kept) -> &[ForceOf<Self, T, D>];

    /// Bodies at these positions and momenta at this time, with all kept quantities evaluated there.
    fn bodies(&self, places: &[Body<T, D>], time: f64) -> BodiesOf<Self, T, D>;
    /// Evaluates the kept quantities again, after positions were restored.
    fn refresh(&self, bodies: &mut BodiesOf<Self, T, D>);
    /// The same for positions inside of a step, which may be off the constraints.
    #[inline(always)]
    fn refresh_off(&self, bodies: &mut BodiesOf<Self, T, D>) {
        self.refresh(bodies);
    }

    /// Writes those kept quantities that cannot be evaluated again from positions, and counters.
    fn record(&self, _bodies: &BodiesOf<Self, T, D>, _to: &mut Record) {}

    /// Reads what [`record`](Self::record) wrote.
    ///
    /// # Errors
    /// [`Error::Record`] if another system wrote it.
    fn recall(&self, _bodies: &mut BodiesOf<Self, T, D>, _from: &mut Reading<'_>) -> Result<(), Error> {
        Ok(())
    }

    /// q̇ of a body: M⁻¹p; of a rigid body the rate of its attitude, in phase space that of H with its constraint.
    fn velocity<X>(&self, bodies: &Bodies<Self::Count, T, X, D>, body: usize) -> [T; D];
    /// Masses, in the coordinates of the momenta; by default unit masses.
    fn inertia(&self) -> &dyn Inertia<T, D> {
        &UnitMasses
    }
    /// The number of independent momenta: coordinates of bodies that are not pinned, minus independent equations.
    fn freedom(&self, bodies: &BodiesOf<Self, T, D>) -> usize {
        (bodies.q.as_ref().len() * D).saturating_sub(self.equations())
    }

    /// Shows the present bodies to the effects, together with their working memory. Bodies count as tied to each other
    /// where there are equations; a system whose equations tie each body to a surface shows its normals instead.
    fn show<R>(
        &self,
        given: Given<'_, T, D>,
        bodies: &mut BodiesOf<Self, T, D>,
        look: impl FnOnce(&Self::Effects, &Interval<'_, T, D>, &mut RoomOf<Self, T, D>) -> R,
    ) -> R {
        let coupling = (self.equations() > 0, self.freedom(bodies));
        let at = Moment { time: bodies.time, positions: bodies.q.as_ref() };
        let seen = (at, bodies.p.as_ref(), &*bodies.marks);
        let during = given.interval(seen, self.inertia(), None, coupling);
        look(self.effects(), &during, Self::room_of(&mut bodies.kept))
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
    /// The momenta that they impose; none where no constraint moves.
    pub led: &'a [[T; D]],
    /// Random numbers.
    pub noise: Noise,
}

impl<'a, T: Scalar, const D: usize> Given<'a, T, D> {
    /// For so long, before a step or after it, with nothing laid beside.
    pub(crate) fn of(h: f64, before: bool, noise: Noise) -> Self {
        let imposed = T::from_f64(0.0);
        Self { h, before, velocities: &[], rates: &[], holding: &[], coming: &[], imposed, led: &[], noise }
    }

    /// With the rest of an [`Interval`]: what bodies are asked for, their masses, surfaces, and how they are coupled.
    pub(crate) fn interval(
        self,
        (at, momenta, marks): (Moment<'a, T, D>, &'a [[T; D]], &'a [T]),
        inertia: &'a dyn Inertia<T, D>,
        surface: Option<&'a dyn Normals<T, D>>,
        (tied, freedom): (bool, usize),
    ) -> Interval<'a, T, D> {
        let Self { h, before, velocities, rates, holding, coming, imposed, led, noise } = self;
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
            led,
            inertia,
            surface,
            marks,
            tied,
            freedom,
            noise,
        }
    }
}
