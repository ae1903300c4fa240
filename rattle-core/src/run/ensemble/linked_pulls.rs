//! Forces on linked bodies in lanes.

use crate::effect::force::Force;
use crate::effect::list::{Effects, Forces};
use crate::effect::moment::Moment;
use crate::effect::swept::Swept;
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::{Fused, Lanes};
use crate::number::real::Real;
use crate::run::ensemble::laws::Alike;
use crate::systems::network::in_lanes::{FEW, Number, Numbers, zeros};
use std::array::from_fn;

/// Forces on all bodies of all lanes.
pub(super) trait Pulls<const W: usize>: Send + Sync {
    /// A copy.
    fn boxed(&self) -> Box<dyn Pulls<W>>;
    /// Room to evaluate them in.
    fn begin(&self) -> Box<dyn Pulling<W> + '_>;
    /// Has lane `to` obey what lane `from` does.
    fn copy(&mut self, _from: usize, _to: usize) {}
}

/// Forces and their room.
pub(super) trait Pulling<const W: usize> {
    /// Adds so many times M⁻¹f, with the forces at these coordinates, and for each the mass and 1 over it.
    fn pull(&mut self, set: Fusing, times: f64, q: &[Numbers<W>], masses: &[[f64; 2]], to: &mut [Numbers<W>]);
}

/// Those of effects on so many bodies, the same on all lanes.
pub(super) fn of_all<E: Effects<D>, const D: usize, const W: usize>(
    effects: &E,
    bodies: usize,
) -> Option<Box<dyn Pulls<W>>> {
    if const { E::Forces::<f64>::EFFECTS == 0 } {
        None
    } else if const { E::Forces::<f64>::ON_EACH } {
        Some(Box::new(OnEach(Alike(effects.forces::<Number>()))))
    } else {
        Some(Box::new(Any { effects: vec![effects.forces::<Numbers<FEW>>()], bodies }))
    }
}

/// Those of effects on so many bodies, with parameters of its own for each lane.
pub(super) fn of_each<'a, E: Effects<D> + 'static, const D: usize, const W: usize>(
    effects: impl Fn(usize) -> &'a E,
    bodies: usize,
) -> Option<Box<dyn Pulls<W>>> {
    if const { E::Forces::<f64>::EFFECTS == 0 } {
        None
    } else if const { E::Forces::<f64>::ON_EACH } {
        Some(Box::new(OnEach(E::swept::<Number, W>(effects))))
    } else {
        let effects = (0..W).map(|lane| effects(lane).forces::<Numbers<1>>()).collect();
        Some(Box::new(Any { effects, bodies }))
    }
}

/// Effects that act on each body by itself.
#[derive(Clone)]
struct OnEach<G, const D: usize>(G);

impl<G: Swept<Number, D> + 'static, const D: usize, const W: usize> Pulls<W> for OnEach<G, D> {
    fn boxed(&self) -> Box<dyn Pulls<W>> {
        Box::new(self.clone())
    }
    fn begin(&self) -> Box<dyn Pulling<W> + '_> {
        Box::new(self)
    }
    fn copy(&mut self, from: usize, to: usize) {
        self.0.copy(from, to);
    }
}

impl<G: Swept<Number, D>, const D: usize, const W: usize> Pulling<W> for &OnEach<G, D> {
    fn pull(
        &mut self,
        set: Fusing,
        times: f64,
        q: &[Numbers<W>],
        masses: &[[f64; 2]],
        to: &mut [Numbers<W>],
    ) {
        set.run(PullEach { effects: &self.0, times, q, masses, to });
    }
}

struct PullEach<'a, G, const D: usize, const W: usize> {
    effects: &'a G,
    times: f64,
    q: &'a [Numbers<W>],
    masses: &'a [[f64; 2]],
    to: &'a mut [Numbers<W>],
}

impl<G: Swept<Number, D>, const D: usize, const W: usize> Work for PullEach<'_, G, D, W> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { effects, times, q, masses, to } = self;
        let effects = effects.clone(); // out of reach of what the loops write
        let bodies = q.as_chunks::<D>().0.iter().zip(masses.as_chunks::<D>().0);
        for ((q, masses), to) in bodies.zip(to.as_chunks_mut::<D>().0) {
            if masses[0][1] != 0.0 {
                pull_one(&effects, masses.map(|[_, over]| Fused(times * over)), q, to);
            }
        }
    }
}

/// One body. Arguments of a function are known not to overlap, so that the loop becomes one over vectors.
#[inline(always)]
fn pull_one<G: Swept<Number, D>, const D: usize, const W: usize>(
    effects: &G,
    times: [Number; D],
    q: &[Numbers<W>; D],
    to: &mut [Numbers<W>; D],
) {
    let (zero, one) = ([Fused(-0.0); D], Fused(1.0));
    for l in 0..W {
        let force = effects.kick(l, &from_fn(|d| q[d].0[l]), one, zero);
        for d in 0..D {
            to[d].0[l] = times[d].multiply_add(force[d], to[d].0[l]);
        }
    }
}

/// Any effects, evaluated for N lanes at a time: the same on all lanes, or for each lane its own where N is 1.
#[derive(Clone)]
struct Any<G, const D: usize, const N: usize> {
    effects: Vec<G>,
    bodies: usize,
}

impl<G: Forces<Numbers<N>, D>, const D: usize, const N: usize, const W: usize> Pulls<W> for Any<G, D, N> {
    fn boxed(&self) -> Box<dyn Pulls<W>> {
        Box::new(self.clone())
    }
    fn begin(&self) -> Box<dyn Pulling<W> + '_> {
        let zero = zeros::<N>();
        Box::new(Room {
            effects: self.effects.iter().map(|effects| (effects, effects.room(self.bodies))).collect(),
            positions: vec![[zero; D]; self.bodies],
            forces: vec![Force::zero(); self.bodies],
        })
    }
    fn copy(&mut self, from: usize, to: usize) {
        if self.effects.len() > 1 {
            self.effects[to] = self.effects[from].clone();
        }
    }
}

/// Effects, each with its room, and what is evaluated for N lanes.
struct Room<'a, G: Forces<Numbers<N>, D>, const D: usize, const N: usize> {
    effects: Vec<(&'a G, G::Room)>,
    positions: Vec<[Numbers<N>; D]>,
    forces: Vec<G::Force>,
}

impl<G: Forces<Numbers<N>, D>, const D: usize, const N: usize, const W: usize> Pulling<W>
    for Room<'_, G, D, N>
{
    fn pull(
        &mut self,
        set: Fusing,
        times: f64,
        q: &[Numbers<W>],
        masses: &[[f64; 2]],
        to: &mut [Numbers<W>],
    ) {
        set.run(PullAll { room: self, times, q, masses, to });
    }
}

struct PullAll<'a, 'b, G: Forces<Numbers<N>, D>, const D: usize, const N: usize, const W: usize> {
    room: &'a mut Room<'b, G, D, N>,
    times: f64,
    q: &'a [Numbers<W>],
    masses: &'a [[f64; 2]],
    to: &'a mut [Numbers<W>],
}

impl<G: Forces<Numbers<N>, D>, const D: usize, const N: usize, const W: usize> Work
    for PullAll<'_, '_, G, D, N, W>
{
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { room: Room { effects, positions, forces }, times, q, masses, to } = self;
        let last = effects.len() - 1;
        for (chunk, first) in (0..W).step_by(N).enumerate() {
            for (position, q) in positions.iter_mut().zip(q.as_chunks::<D>().0) {
                *position = from_fn(|d| Lanes(from_fn(|l| q[d].0[first + l])));
            }
            let (effects, room) = &mut effects[chunk.min(last)];
            effects.evaluate(Moment { time: 0.0, positions }, room, forces);
            let bodies = forces.iter().zip(masses.as_chunks::<D>().0).zip(to.as_chunks_mut::<D>().0);
            for ((force, masses), to) in bodies {
                let force = force.components();
                for d in 0..D {
                    let times = Fused(times * masses[d][1]);
                    for l in 0..N {
                        to[d].0[first + l] = times.multiply_add(force[d].0[l], to[d].0[first + l]);
                    }
                }
            }
        }
    }
}
