//! What the effects of a scene do to a system.

use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::effect::noise::Noise;
use crate::error::EffectMistake;
use crate::motion::bodies::{Bodies, Saved};
use crate::motion::failure::Failure;
use crate::motion::parts::{BodiesOf, Given, Parts};
use crate::number::real::Scalar;

/// What the effects of a scene do to a system. The same for every system with its [`Parts`]: nobody implements this.
pub trait Affected<T: Scalar, const D: usize>: Parts<T, D> {
    /// The number of effects that are [flows](crate::effect::Flow) of momenta.
    const FLOWS: usize = <Self::Effects as Forces<T, D>>::FLOWS;
    /// The number of effects.
    const EFFECTS: usize = <Self::Effects as Forces<T, D>>::EFFECTS;
    /// Whether one of the effects has a [memory](crate::effect::Acting::REMEMBERS).
    const REMEMBERS: bool = <Self::Effects as Forces<T, D>>::REMEMBERS;
    /// Whether all flows are [pushes](crate::effect::Acting::PUSHES).
    const PUSHES: bool = <Self::Effects as Forces<T, D>>::PUSHES;

    /// Whether constraints or forces depend on time.
    #[inline(always)]
    fn moves_with_time(&self) -> bool {
        self.constraints_move() || self.effects().changes_with_time()
    }

    /// Checks that the last forces are finite, for methods whose steps end before the kick that would show it. A system
    /// without forces does nothing.
    ///
    /// # Errors
    /// [`EffectFailure::ForceNotFinite`](crate::error::EffectFailure::ForceNotFinite).
    fn check_forces(&self, bodies: &BodiesOf<Self, T, D>) -> Result<(), Failure> {
        let at = Moment { time: bodies.time, positions: bodies.q.as_ref() };
        let (forces, inertia) = (Self::forces_of(&bodies.kept), self.inertia());
        let moved = (0..forces.len()).filter(|&body| !inertia.is_pinned(body));
        Failure::unless_finite(self.effects(), at, forces, moved)
    }

    /// Books the work of a kick by potentials that change with time.
    #[inline(always)]
    fn book<X>(&self, kick: f64, bodies: &mut Bodies<Self::Count, T, X, D>) {
        if self.effects().changes_with_time() && kick != 0.0 {
            bodies.work = bodies.work + T::from_f64(kick) * bodies.power;
        }
    }

    /// Evaluates ∂U/∂t where the forces were, for [`book`](Self::book).
    #[inline(always)]
    fn evaluate_power<X>(&self, bodies: &mut Bodies<Self::Count, T, X, D>) {
        if self.effects().changes_with_time() {
            bodies.power = self.effects().power(Moment { time: bodies.time, positions: bodies.q.as_ref() });
        }
    }

    /// Writes the changes of the momenta by flow number `number`, at the present positions and time, without
    /// constraints. Neither allocates nor panics.
    fn flow(
        &self,
        number: usize,
        given: Given<'_, T, D>,
        bodies: &mut BodiesOf<Self, T, D>,
        changes: &mut [[T; D]],
    ) {
        self.show(given, bodies, |effects, during, room| effects.flow(number, during, room, changes));
        if const { Self::MOMENTA < D } {
            changes.iter_mut().for_each(|change| change[Self::MOMENTA..].fill(T::from_f64(0.0)));
        }
    }

    /// Checks that flows change momenta of the [kind of this system](Parts::MOMENTA) at the start of a run, by steps of
    /// about this size. Flows that feel forces are not asked: there are none yet.
    ///
    /// # Errors
    /// The name of the type of a flow that changes others, and by what force.
    fn check_flows(
        &self,
        h: f64,
        bodies: &BodiesOf<Self, T, D>,
    ) -> Result<(), (&'static str, EffectMistake)> {
        if const { Self::FLOWS == 0 || Self::MOMENTA == D } {
            return Ok(());
        }
        let h = 2.0_f64.powi(h.abs().log2().floor() as i32).copysign(h); // forces are told as they are
        let mut bodies = bodies.clone();
        if const { Self::REMEMBERS } {
            bodies.marks = self.first_marks(&bodies)?;
        }
        let (n, inertia) = (bodies.q.as_ref().len(), self.inertia());
        let velocities: Vec<_> =
            (0..n).map(|body| inertia.velocity(body, &bodies.p.as_ref()[body])).collect();
        let mut changes = vec![[T::from_f64(0.0); D]; n];
        for number in 0..Self::FLOWS {
            let (manner, effect) = self.effects().manner(number);
            if manner.feels {
                continue;
            }
            let noise = Noise { effect: number as u64, ..bodies.noise };
            let given = Given { velocities: &velocities, ..Given::of(h, true, noise) };
            self.show(given, &mut bodies, |effects, during, room| {
                effects.flow(number, during, room, &mut changes);
            });
            for (body, change) in changes.iter().enumerate() {
                let force = change.map(|change| change.to_f64() / h);
                let (turning, others) = force.split_at(Self::MOMENTA);
                // One that is not finite at all is found in the step.
                if turning.iter().all(|x| x.is_finite()) && others.iter().any(|&x| x != 0.0) {
                    return Err((effect, EffectMistake::NoTorque { body, force: force.to_vec() }));
                }
            }
        }
        Ok(())
    }

    /// Checks that effects can act on these bodies, at the start of a run.
    ///
    /// # Errors
    /// The name of the type of an effect that cannot, and why.
    fn fits(&self, bodies: &mut BodiesOf<Self, T, D>) -> Result<(), (&'static str, EffectMistake)> {
        let given = Given::of(0.0, true, bodies.noise);
        self.show(given, bodies, |effects, during, _| effects.fits(during))
    }

    /// The memory of the effects at the start of a run, at the present positions and random numbers.
    ///
    /// # Errors
    /// The name of the type of an effect that cannot act here, and why.
    fn first_marks(&self, bodies: &BodiesOf<Self, T, D>) -> Result<Vec<T>, (&'static str, EffectMistake)> {
        let mut marks = vec![T::from_f64(0.0); self.effects().marks(bodies.q.as_ref().len())];
        let given = Given::of(0.0, true, bodies.noise);
        self.show(given, &mut bodies.clone(), |effects, during, _| effects.first_marks(during, &mut marks))?;
        Ok(marks)
    }

    /// Lets flow number `number` update its memory for the present positions and the time that passes. Neither
    /// allocates nor panics.
    fn take_note(&self, number: usize, given: Given<'_, T, D>, bodies: &mut BodiesOf<Self, T, D>) {
        let mut marks = std::mem::take(&mut bodies.marks);
        self.show(given, bodies, |effects, during, _| effects.take_note(number, during, &mut marks));
        bodies.marks = marks;
    }

    /// Adds the force of effect number `number` alone, and returns the name of its type; `None` for a flow. There
    /// are [`EFFECTS`](Self::EFFECTS) of them.
    fn add_force_alone(
        &self,
        number: usize,
        bodies: &mut BodiesOf<Self, T, D>,
        forces: &mut [[T; D]],
    ) -> Option<&'static str> {
        let at = Moment { time: bodies.time, positions: bodies.q.as_ref() };
        self.effects().contribute_alone(number, at, Self::room_of(&mut bodies.kept), forces)
    }

    /// U, from positions alone.
    fn potential_energy<X>(&self, bodies: &Bodies<Self::Count, T, X, D>) -> T {
        self.effects().energy(Moment { time: bodies.time, positions: bodies.q.as_ref() })
    }

    /// Appends U of each effect that is not a flow, in the order of the scene.
    fn effect_energies<X>(&self, bodies: &Bodies<Self::Count, T, X, D>, to: &mut Vec<T>) {
        self.effects().energies(Moment { time: bodies.time, positions: bodies.q.as_ref() }, to);
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
}

impl<T: Scalar, Y: Parts<T, D>, const D: usize> Affected<T, D> for Y {}
