//! Forces of effects on all bodies of a row of trajectories, in lanes.
//!
//! Effects that act on each body by itself are evaluated lane by lane, in a sweep with the parameters of each lane. Any
//! others are evaluated for some lanes at a time, in a sweep for one. What a force does to a body, the kind of
//! [rows](Rows) says.

use crate::effect::force::Force;
use crate::effect::list::{Effects, Forces};
use crate::effect::moment::Moment;
use crate::effect::swept::Swept;
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::{Fused, Lanes};
use crate::run::ensemble::laws::Alike;
use crate::systems::network::in_lanes::{FEW, Number, Numbers, zeros};
use std::array::from_fn;

/// A kind of rows of W trajectories, by its bodies. Their number of coordinates is not in its type, so that the steps
/// of rows are compiled once.
pub(super) trait Rows<const W: usize>: 'static {
    /// All bodies: where they are, and what forces change.
    type Bodies<'a>;
}

/// What forces do to bodies of D coordinates in a row.
pub(super) trait Pulled<const D: usize, const W: usize>: Rows<W> {
    /// By what a force on a body is multiplied.
    type Times: Copy;
    /// What it changes.
    type To;

    /// Body by body: these times what a force is multiplied by for a body, where the body is, and what is changed.
    fn each<'a>(
        times: f64,
        bodies: &'a mut Self::Bodies<'_>,
    ) -> impl Iterator<Item = (Self::Times, &'a [Numbers<W>; D], &'a mut Self::To)>;

    /// Whether no force changes anything.
    fn stays(_times: Self::Times) -> bool {
        false
    }

    /// Changes it by the forces on a body at these places, in N lanes from this one on.
    fn pull<const N: usize>(
        times: Self::Times,
        q: &[Numbers<N>; D],
        force: &[Numbers<N>; D],
        first: usize,
        to: &mut Self::To,
    );
}

/// Effects on the bodies of such rows.
pub(super) trait Pulls<R: Rows<W>, const W: usize>: Send + Sync {
    /// A copy.
    fn boxed(&self) -> Box<dyn Pulls<R, W>>;
    /// Room to evaluate them in.
    fn begin(&self) -> Box<dyn Pulling<R, W> + '_>;
    /// Has lane `to` obey what lane `from` does.
    fn copy(&mut self, from: usize, to: usize);
}

impl<R: Rows<W>, const W: usize> Clone for Box<dyn Pulls<R, W>> {
    fn clone(&self) -> Self {
        (**self).boxed()
    }
}

/// Effects and their room.
pub(super) trait Pulling<R: Rows<W>, const W: usize> {
    /// Has so many times their forces pull these bodies.
    fn pull(&mut self, set: Fusing, times: f64, bodies: R::Bodies<'_>);
}

/// Those of a scene of so many bodies, the same on all lanes.
pub(super) fn of_all<E: Effects<D>, R: Pulled<D, W>, const D: usize, const W: usize>(
    effects: &E,
    bodies: usize,
) -> Option<Box<dyn Pulls<R, W>>> {
    if const { E::Forces::<f64>::EFFECTS == E::Forces::<f64>::FLOWS } {
        None
    } else if const { E::Forces::<f64>::ON_EACH } {
        Some(Box::new(OnEach(Alike(effects.forces::<Number>()))))
    } else {
        Some(Box::new(Any { effects: vec![effects.forces::<Numbers<FEW>>()], bodies }))
    }
}

/// Those of scenes of so many bodies, one for each lane.
pub(super) fn of_each<'a, E: Effects<D> + 'static, R: Pulled<D, W>, const D: usize, const W: usize>(
    effects: impl Fn(usize) -> &'a E,
    bodies: usize,
) -> Option<Box<dyn Pulls<R, W>>> {
    if const { E::Forces::<f64>::EFFECTS == E::Forces::<f64>::FLOWS } {
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

impl<G: Swept<Number, W, D> + 'static, R: Pulled<D, W>, const D: usize, const W: usize> Pulls<R, W>
    for OnEach<G, D>
{
    fn boxed(&self) -> Box<dyn Pulls<R, W>> {
        Box::new(self.clone())
    }
    fn begin(&self) -> Box<dyn Pulling<R, W> + '_> {
        Box::new(self)
    }
    fn copy(&mut self, from: usize, to: usize) {
        self.0.copy(from, to);
    }
}

impl<G: Swept<Number, W, D>, R: Pulled<D, W>, const D: usize, const W: usize> Pulling<R, W>
    for &OnEach<G, D>
{
    fn pull(&mut self, set: Fusing, times: f64, bodies: R::Bodies<'_>) {
        set.run(PullEach::<_, R, D, W> { effects: &self.0, times, bodies });
    }
}

struct PullEach<'a, 'b, G, R: Rows<W>, const D: usize, const W: usize> {
    effects: &'a G,
    times: f64,
    bodies: R::Bodies<'b>,
}

impl<G: Swept<Number, W, D>, R: Pulled<D, W>, const D: usize, const W: usize> Work
    for PullEach<'_, '_, G, R, D, W>
{
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { effects, times, mut bodies } = self;
        let effects = effects.clone(); // out of reach of what the loops write
        for (times, q, to) in R::each(times, &mut bodies) {
            if !R::stays(times) {
                pull_one::<G, R, D, W>(&effects, times, q, to);
            }
        }
    }
}

/// One body. Arguments of a function are known not to overlap, so that the loop becomes one over vectors.
#[inline(always)]
fn pull_one<G: Swept<Number, W, D>, R: Pulled<D, W>, const D: usize, const W: usize>(
    effects: &G,
    times: R::Times,
    q: &[Numbers<W>; D],
    to: &mut R::To,
) {
    let (zero, one) = ([Fused(-0.0); D], Fused(1.0));
    for l in 0..W {
        let q = from_fn(|d| q[d].0[l]);
        let force = effects.kick(l, &q, one, zero);
        R::pull(times, &q.map(|x| Lanes([x])), &force.map(|f| Lanes([f])), l, to);
    }
}

/// Any effects, evaluated for N lanes at a time: the same on all lanes, or for each lane its own where N is 1.
#[derive(Clone)]
struct Any<G, const D: usize, const N: usize> {
    effects: Vec<G>,
    bodies: usize,
}

impl<G: Forces<Numbers<N>, D>, R: Pulled<D, W>, const D: usize, const N: usize, const W: usize> Pulls<R, W>
    for Any<G, D, N>
{
    fn boxed(&self) -> Box<dyn Pulls<R, W>> {
        Box::new(self.clone())
    }
    fn begin(&self) -> Box<dyn Pulling<R, W> + '_> {
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

impl<G: Forces<Numbers<N>, D>, R: Pulled<D, W>, const D: usize, const N: usize, const W: usize> Pulling<R, W>
    for Room<'_, G, D, N>
{
    fn pull(&mut self, set: Fusing, times: f64, bodies: R::Bodies<'_>) {
        set.run(PullAll::<_, R, D, N, W> { room: self, times, bodies });
    }
}

struct PullAll<'a, 'b, 'c, G, R, const D: usize, const N: usize, const W: usize>
where
    G: Forces<Numbers<N>, D>,
    R: Rows<W>,
{
    room: &'a mut Room<'b, G, D, N>,
    times: f64,
    bodies: R::Bodies<'c>,
}

impl<G, R, const D: usize, const N: usize, const W: usize> Work for PullAll<'_, '_, '_, G, R, D, N, W>
where
    G: Forces<Numbers<N>, D>,
    R: Pulled<D, W>,
{
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { room: Room { effects, positions, forces }, times, mut bodies } = self;
        let last = effects.len() - 1;
        for (chunk, first) in (0..W).step_by(N).enumerate() {
            for (position, (_, q, _)) in positions.iter_mut().zip(R::each(times, &mut bodies)) {
                *position = from_fn(|d| Lanes(from_fn(|l| q[d].0[first + l])));
            }
            let (effects, room) = &mut effects[chunk.min(last)];
            effects.evaluate(Moment { time: 0.0, positions }, room, forces);
            let each = positions.iter().zip(&*forces).zip(R::each(times, &mut bodies));
            for ((position, force), (times, _, to)) in each {
                if R::stays(times) {
                    continue;
                }
                R::pull(times, position, &force.components(), first, to);
            }
        }
    }
}
