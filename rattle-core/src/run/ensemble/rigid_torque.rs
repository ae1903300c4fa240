//! Torques on rigid bodies in lanes.

use crate::effect::force::Force;
use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::effect::swept::Swept;
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::{Fused, Lanes};
use crate::run::ensemble::laws::Alike;
use crate::run::ensemble::rigid_row::{Nine, Rotor, Three, Torquing};
use crate::systems::network::in_lanes::{FEW, Number, Numbers, at, put, zeros};
use crate::systems::rigid::rotation::turning;
use std::array::from_fn;

/// Effects on the rigid bodies of W lanes. D is 9.
pub(super) trait Torques<const W: usize>: Send + Sync {
    /// A copy.
    fn boxed(&self) -> Box<dyn Torques<W>>;
    /// Room to evaluate them in.
    fn begin(&self, bodies: usize) -> Box<dyn Torquing<W> + '_>;
    /// Has lane `to` obey what lane `from` does.
    fn copy(&mut self, _from: usize, _to: usize) {}
}

/// The same effects on all lanes.
pub(super) fn of_all<G, H, const D: usize, const W: usize>(one: G, few: H) -> Option<Box<dyn Torques<W>>>
where
    G: Forces<Number, D>,
    H: Forces<Vector, D>,
{
    if const { G::EFFECTS == 0 } {
        None
    } else if const { G::ON_EACH } {
        Some(Box::new(OnEach(Alike(one))))
    } else {
        Some(Box::new(Any(few)))
    }
}

/// Effects that act on each body by itself, with parameters of its own for each lane.
pub(super) fn of_each<G, const D: usize, const W: usize>(swept: G) -> Box<dyn Torques<W>>
where
    G: Swept<Number, D> + 'static,
{
    Box::new(OnEach(swept))
}

/// Effects that act on each body by itself.
#[derive(Clone)]
struct OnEach<G, const D: usize>(G);

impl<G: Swept<Number, D> + 'static, const D: usize, const W: usize> Torques<W> for OnEach<G, D> {
    fn boxed(&self) -> Box<dyn Torques<W>> {
        Box::new(Self(self.0.clone()))
    }
    fn begin(&self, _: usize) -> Box<dyn Torquing<W> + '_> {
        Box::new(self)
    }
    fn copy(&mut self, from: usize, to: usize) {
        self.0.copy(from, to);
    }
}

impl<G: Swept<Number, D>, const D: usize, const W: usize> Torquing<W> for &OnEach<G, D> {
    fn torques(&mut self, set: Fusing, times: f64, bodies: &[Rotor<W>], to: &mut [Three<W>]) {
        set.run(Each { effects: &self.0, times, bodies, to });
    }
}

struct Each<'a, G, const D: usize, const W: usize> {
    effects: &'a G,
    times: f64,
    bodies: &'a [Rotor<W>],
    to: &'a mut [Three<W>],
}

impl<G: Swept<Number, D>, const D: usize, const W: usize> Work for Each<'_, G, D, W> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { effects, times, bodies, to } = self;
        let effects = effects.clone(); // out of reach of what the loops write
        for (rotor, to) in bodies.iter().zip(to) {
            torque_on_one(&effects, Fused(times), &rotor.q, to);
        }
    }
}

/// One body. Arguments of a function are known not to overlap, so that the loop becomes one over vectors.
#[inline(always)]
fn torque_on_one<G: Swept<Number, D>, const D: usize, const W: usize>(
    effects: &G,
    times: Number,
    q: &Nine<W>,
    to: &mut Three<W>,
) {
    let (zero, one) = ([Fused(-0.0); D], Fused(1.0));
    for l in 0..W {
        let q = at(q, l);
        let force = effects.kick(l, &from_fn(|d| q[d]), one, zero);
        put(to, l, turning(&q, &from_fn(|k| force[k])).map(|torque| times * torque));
    }
}

/// Numbers of the lanes for which effects between bodies are evaluated at once.
pub(super) type Vector = Numbers<FEW>;

/// Any effects.
#[derive(Clone)]
struct Any<H, const D: usize>(H);

impl<H: Forces<Vector, D>, const D: usize, const W: usize> Torques<W> for Any<H, D> {
    fn boxed(&self) -> Box<dyn Torques<W>> {
        Box::new(self.clone())
    }
    fn begin(&self, bodies: usize) -> Box<dyn Torquing<W> + '_> {
        Box::new(Room {
            effects: &self.0,
            positions: vec![[zeros(); D]; bodies],
            forces: vec![Force::zero(); bodies],
            room: self.0.room(bodies),
        })
    }
}

/// Effects, and room for some lanes.
struct Room<'a, H: Forces<Vector, D>, const D: usize> {
    effects: &'a H,
    positions: Vec<[Vector; D]>,
    forces: Vec<H::Force>,
    room: H::Room,
}

impl<H: Forces<Vector, D>, const D: usize, const W: usize> Torquing<W> for Room<'_, H, D> {
    fn torques(&mut self, set: Fusing, times: f64, bodies: &[Rotor<W>], to: &mut [Three<W>]) {
        set.run(All { room: self, times, bodies, to });
    }
}

struct All<'a, 'b, H: Forces<Vector, D>, const D: usize, const W: usize> {
    room: &'a mut Room<'b, H, D>,
    times: f64,
    bodies: &'a [Rotor<W>],
    to: &'a mut [Three<W>],
}

impl<H: Forces<Vector, D>, const D: usize, const W: usize> Work for All<'_, '_, H, D, W> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { room: Room { effects, positions, forces, room }, times, bodies, to } = self;
        for first in (0..W).step_by(FEW) {
            for (position, rotor) in positions.iter_mut().zip(bodies) {
                *position = from_fn(|d| Lanes(from_fn(|l| rotor.q[d].0[first + l])));
            }
            effects.evaluate(Moment { time: 0.0, positions }, room, forces);
            for ((position, force), to) in positions.iter().zip(&*forces).zip(&mut *to) {
                let force = force.components();
                for l in 0..FEW {
                    let [q, force] = [position, &force].map(|of| from_fn(|k| of[k].0[l]));
                    put(to, first + l, turning(&q, &force).map(|torque| Fused(times) * torque));
                }
            }
        }
    }
}
