//! Forces of effects on all bodies of a row of trajectories as power series, a few lanes at a time.
//!
//! Effects of one scene are series of that many numbers at once. In a sweep effects that act on each body by itself are
//! so too, with the parameters of each lane; any others are evaluated lane by lane. Few, since the products of all
//! orders are to stay in the nearer cache.

use crate::effect::list::{Effects, Forces};
use crate::effect::swept::Swept;
use crate::kernel::series::{Order, Products};
use crate::number::instructions::{Fusing, Work};
use crate::systems::network::in_lanes::{FEW, Number, Numbers, zeros};

/// Effects as power series.
pub(super) trait PullsInSeries: Send + Sync {
    /// A copy.
    fn boxed(&self) -> Box<dyn PullsInSeries>;
    /// Room for so many coefficients.
    fn begin(&self, orders: usize) -> Box<dyn PullingInSeries + '_>;
    /// Has lane `to` of the row obey what lane `from` does.
    fn copy(&mut self, from: usize, to: usize);
}

impl Clone for Box<dyn PullsInSeries> {
    fn clone(&self) -> Self {
        (**self).boxed()
    }
}

/// Effects and their room.
pub(super) trait PullingInSeries {
    /// Writes coefficient k of the forces in the few lanes of this number, from that of the coordinates of all bodies.
    /// The lower ones of these lanes were asked for before, and of no others since.
    fn pull(&mut self, set: Fusing, few: usize, k: usize, q: &[Numbers<FEW>], forces: &mut [Numbers<FEW>]);
}

/// Those of a scene of so many bodies, the same on all lanes: none where one has no series, and no object where there
/// are no forces.
#[allow(clippy::option_option, reason = "there are none, or none that have a series")]
pub(super) fn of_all<E: Effects<D>, const D: usize>(
    effects: &E,
    bodies: usize,
) -> Option<Option<Box<dyn PullsInSeries>>> {
    if const { E::Forces::<f64>::EFFECTS == 0 } {
        return Some(None);
    }
    let effects = vec![effects.forces::<Numbers<FEW>>()];
    let blocks = effects[0].series_blocks(bodies)?;
    Some(Some(Box::new(Any { effects, blocks, bodies })))
}

/// Those of scenes of so many bodies, one for each of W lanes.
#[allow(clippy::option_option, reason = "there are none, or none that have a series")]
pub(super) fn of_each<'a, E: Effects<D> + 'static, const D: usize, const W: usize>(
    effects: impl Fn(usize) -> &'a E,
    bodies: usize,
) -> Option<Option<Box<dyn PullsInSeries>>> {
    if const { E::Forces::<f64>::EFFECTS == 0 } {
        Some(None)
    } else if const { E::Forces::<f64>::ON_EACH } {
        let few = |few: usize| E::swept::<Number, FEW>(|lane| effects(few * FEW + lane));
        let effects: Vec<_> = (0..W / FEW).map(few).collect();
        let blocks = effects[0].series_blocks()? * bodies;
        Some(Some(Box::new(OnEach { effects, blocks })))
    } else {
        let effects: Vec<_> = (0..W).map(|lane| effects(lane).forces::<Numbers<1>>()).collect();
        // Effects of one type may act among more bodies in some lanes than in others.
        let blocks = effects.iter().map(|effects| effects.series_blocks(bodies));
        let blocks = blocks.collect::<Option<Vec<_>>>()?.into_iter().fold(0, usize::max);
        Some(Some(Box::new(Any { effects, blocks, bodies })))
    }
}

/// Effects of a sweep that act on each body by itself, for a few lanes each.
#[derive(Clone)]
struct OnEach<G, const D: usize> {
    effects: Vec<G>,
    blocks: usize,
}

impl<G: Swept<Number, FEW, D> + 'static, const D: usize> PullsInSeries for OnEach<G, D> {
    fn boxed(&self) -> Box<dyn PullsInSeries> {
        Box::new(self.clone())
    }
    fn begin(&self, orders: usize) -> Box<dyn PullingInSeries + '_> {
        Box::new(RoomOnEach { effects: &self.effects[..], products: Products::new(self.blocks, orders) })
    }
    fn copy(&mut self, from: usize, to: usize) {
        let others = self.effects[from / FEW].clone();
        self.effects[to / FEW].take_over(to % FEW, &others, from % FEW);
    }
}

/// These effects and their products.
struct RoomOnEach<'a, G, const D: usize> {
    effects: &'a [G],
    products: Products<Numbers<FEW>>,
}

impl<G: Swept<Number, FEW, D>, const D: usize> PullingInSeries for RoomOnEach<'_, G, D> {
    fn pull(&mut self, set: Fusing, few: usize, k: usize, q: &[Numbers<FEW>], forces: &mut [Numbers<FEW>]) {
        let Self { effects, products } = self;
        set.run(PullEach::<G, D> { effects: &effects[few], products, k, q, forces });
    }
}

struct PullEach<'a, G, const D: usize> {
    effects: &'a G,
    products: &'a mut Products<Numbers<FEW>>,
    k: usize,
    q: &'a [Numbers<FEW>],
    forces: &'a mut [Numbers<FEW>],
}

impl<G: Swept<Number, FEW, D>, const D: usize> PullEach<'_, G, D> {
    #[inline(always)]
    fn add<const FIRST: bool>(
        effects: &G,
        q: &[Numbers<FEW>],
        forces: &mut [Numbers<FEW>],
        order: &mut Order<'_, Numbers<FEW>, FIRST>,
    ) {
        for (q, force) in q.as_chunks().0.iter().zip(forces.as_chunks_mut().0) {
            effects.add_series(q, force, order);
        }
    }
}

impl<G: Swept<Number, FEW, D>, const D: usize> Work for PullEach<'_, G, D> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { effects, products, k, q, forces } = self;
        forces.fill(zeros());
        if k == 0 {
            Self::add(effects, q, forces, &mut products.first());
        } else {
            Self::add(effects, q, forces, &mut products.next_within(k));
        }
    }
}

/// Any effects, for N lanes at a time: the same on all lanes, or for each lane its own where N is 1.
#[derive(Clone)]
struct Any<G, const D: usize, const N: usize> {
    effects: Vec<G>,
    blocks: usize,
    bodies: usize,
}

impl<G: Forces<Numbers<N>, D>, const D: usize, const N: usize> PullsInSeries for Any<G, D, N> {
    fn boxed(&self) -> Box<dyn PullsInSeries> {
        Box::new(self.clone())
    }
    fn begin(&self, orders: usize) -> Box<dyn PullingInSeries + '_> {
        Box::new(Room {
            effects: &self.effects[..],
            products: (0..FEW / N).map(|_| Products::new(self.blocks, orders)).collect(),
            positions: vec![[zeros(); D]; self.bodies],
            forces: vec![[zeros(); D]; self.bodies],
        })
    }
    fn copy(&mut self, from: usize, to: usize) {
        if self.effects.len() > 1 {
            self.effects[to] = self.effects[from].clone();
        }
    }
}

/// Effects, products for each N lanes, and what is evaluated for them.
struct Room<'a, G, const D: usize, const N: usize> {
    effects: &'a [G],
    products: Vec<Products<Numbers<N>>>,
    positions: Vec<[Numbers<N>; D]>,
    forces: Vec<[Numbers<N>; D]>,
}

impl<G: Forces<Numbers<N>, D>, const D: usize, const N: usize> PullingInSeries for Room<'_, G, D, N> {
    fn pull(&mut self, set: Fusing, few: usize, k: usize, q: &[Numbers<FEW>], forces: &mut [Numbers<FEW>]) {
        set.run(PullAll { room: self, few, k, q, to: forces });
    }
}

struct PullAll<'a, 'b, G, const D: usize, const N: usize> {
    room: &'a mut Room<'b, G, D, N>,
    few: usize,
    k: usize,
    q: &'a [Numbers<FEW>],
    to: &'a mut [Numbers<FEW>],
}

impl<G: Forces<Numbers<N>, D>, const D: usize, const N: usize> Work for PullAll<'_, '_, G, D, N> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { room: Room { effects, products, positions, forces }, few, k, q, to } = self;
        let last = effects.len() - 1;
        for (piece, products) in products.iter_mut().enumerate() {
            for (position, q) in positions.iter_mut().zip(q.as_chunks().0) {
                gather(q, piece * N, position);
            }
            forces.fill([zeros(); D]);
            let effects = &effects[(few * (FEW / N) + piece).min(last)];
            if k == 0 {
                effects.contribute_series(positions, forces, &mut products.first());
            } else {
                effects.contribute_series(positions, forces, &mut products.next_within(k));
            }
            for (force, to) in forces.iter().zip(to.as_chunks_mut().0) {
                scatter(force, piece * N, to);
            }
        }
    }
}

/// N lanes of these, from this one on.
#[inline(always)]
fn gather<const D: usize, const N: usize>(from: &[Numbers<FEW>; D], first: usize, to: &mut [Numbers<N>; D]) {
    for d in 0..D {
        for l in 0..N {
            to[d].0[l] = from[d].0[first + l];
        }
    }
}

/// Writes them back.
#[inline(always)]
fn scatter<const D: usize, const N: usize>(from: &[Numbers<N>; D], first: usize, to: &mut [Numbers<FEW>; D]) {
    for d in 0..D {
        for l in 0..N {
            to[d].0[first + l] = from[d].0[l];
        }
    }
}
