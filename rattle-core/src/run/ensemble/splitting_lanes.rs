//! Splittings in lanes.

use crate::effect::force::Force;
use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::error::Error;
use crate::kernel::functions::ConstraintKernel;
use crate::kernel::kinks::{first_kink, sign_changes};
use crate::motion::bodies::{Body, One};
use crate::motion::failure::Failure;
use crate::motion::method::Stage;
use crate::motion::record::{Hallmark, Reading, Record, short_name};
use crate::motion::system::System;
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::Lane;
use crate::number::vector::add_scaled;
use crate::number::vectors::{Vectors, at, put};
use crate::run::ensemble::block::{Block, Part, Scratch};
use crate::run::ensemble::engine::{Engine, Leg, Stuck, Tour};
use crate::run::ensemble::laws::Laws;
use crate::run::ensemble::loops::step;
use crate::run::fingerprint::beside;
use crate::run::watch::sight::Sight;
use crate::solve::crowd::EVERY;
use crate::systems::surface::kept::{OnSurface, OneByOne};
use crate::systems::surface::normal::{Normal, multiplier_from_curvature};
use nalgebra::SVector;
use std::borrow::Borrow;
use std::hint::black_box;

/// A block, what its lanes obey, and the parts of a step.
#[derive(Clone)]
pub(crate) struct SplittingLanes<S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool> {
    block: Block<S, L, D, SUMS, EQUAL>,
    laws: X,
    stages: Vec<Stage>,
    parts: Vec<Part>,
    set: Fusing,
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>
    SplittingLanes<S, X, L, D, SUMS, EQUAL>
where
    S: Lane,
    X: Laws<S, D>,
{
    /// Lanes, none of them set, that obey these laws in stages like these.
    pub(crate) fn new(laws: X, stages: &[Stage], set: Fusing) -> Self {
        Self { block: Block::new(), laws, stages: stages.to_vec(), parts: Part::of::<EQUAL>(stages), set }
    }
}

/// What a thread works on. All in one place, at a place of the same kind each time: processors take numbers for the
/// same whose addresses differ by a multiple of the alignment, and wait for one when they need the other.
#[repr(C, align(4096))]
struct Desk<S, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool> {
    block: Block<S, L, D, SUMS, EQUAL>,
    scratch: Scratch<S, L, D>,
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool> Engine<D>
    for SplittingLanes<S, X, L, D, SUMS, EQUAL>
where
    S: Lane,
    X: Laws<S, D>,
{
    const WIDTH: usize = L;
    type Lanes = Block<S, L, D, SUMS, EQUAL>;
    type Laws = X;

    fn go(&self, tour: &mut dyn Tour<D>) -> Result<Self::Lanes, Stuck> {
        let going = Going { block: &self.block, laws: &self.laws, parts: &self.parts, tour };
        if const { L == 1 } { self.set.run_narrow(going) } else { self.set.run(going) }
    }

    fn lanes(&self) -> Self::Lanes {
        self.block.clone()
    }

    fn keep(&mut self, lanes: Self::Lanes) {
        self.block = lanes;
    }

    fn set(&mut self, lane: usize, body: &Body<f64, D>) -> bool {
        let Body { q, q_low, p, p_low } = body.map(S::from_f64);
        self.block.set(lane, &self.laws, &self.parts, [q, q_low], [p, p_low])
    }

    fn copy(&mut self, from: usize, to: usize) {
        self.block.copy(from, to);
        self.laws.copy(from, to);
    }

    fn laws(&mut self) -> &mut X {
        &mut self.laws
    }

    fn body(&self, lane: usize) -> Body<f64, D> {
        let ([q, q_low], [p, p_low]) =
            (self.block.position(lane), self.block.momentum(lane, &self.laws, &self.parts));
        Body { q, q_low, p, p_low }.map(Lane::to_f64)
    }

    fn by_itself(
        &self,
        lane: usize,
        body: &Body<f64, D>,
        steps: u64,
        parts: u32,
    ) -> Result<Body<f64, D>, Failure> {
        let (constraint, effects) = (self.laws.constraint(lane), self.laws.effects(lane));
        let system = OnSurface::new(constraint.borrow().clone(), OneByOne, effects.borrow().clone(), One);
        let share = |x: f64| x / f64::from(parts);
        let stage = |&Stage { before, h, after }: &Stage| Stage {
            before: share(before),
            h: share(h),
            after: share(after),
        };
        let stages = self.stages.iter().map(stage).collect::<Vec<_>>();
        by_itself::<S, _, D>(&system, &stages, steps, parts, body)
    }

    fn kick_alone(&self, steps: u32) {
        let kicks = steps * self.parts.len() as u32;
        let kicking = Kicking { q: &self.block.q, way: self.block.way, laws: &self.laws, kicks };
        black_box(if const { L == 1 } { self.set.run_narrow(kicking) } else { self.set.run(kicking) });
    }

    fn forces(&self) -> Vec<&'static str> {
        let (effects, mut force) = (self.laws.effects(0), [[S::from_f64(0.0); D]]);
        let (effects, q) = (effects.borrow(), [at(&self.block.q, 0)]);
        let at = Moment { time: 0.0, positions: &q };
        let name = |number| effects.contribute_alone(number, at, &mut effects.room(1), &mut force);
        (0..<X::Forces as Forces<S, D>>::EFFECTS).filter_map(name).collect()
    }

    fn record(&self, to: &mut Record) {
        self.block.record(to);
    }

    fn recalled(&self, from: &mut Reading<'_>, copy_of: &[usize]) -> Result<Self, Error> {
        let (block, mut laws) = (Block::recalled(from, self.parts.len())?, self.laws.clone());
        for (to, &from) in copy_of.iter().enumerate().take(L).filter(|&(to, &from)| to != from) {
            laws.copy(from, to);
        }
        Ok(Self { block, laws, stages: self.stages.clone(), parts: self.parts.clone(), set: self.set })
    }

    fn hallmarks(&self, lane: usize, body: &Body<f64, D>) -> Vec<Hallmark> {
        let (constraint, effects) = (self.laws.constraint(lane), self.laws.effects(lane));
        let place = Body { p: [0.0; D], ..*body }; // momenta are what laws make of them
        let (effects, q) = (effects.borrow(), beside(&[place])[0].q.map(S::from_f64));
        let numbers = |x: &[S]| x.iter().map(|x| x.to_f64()).collect::<Vec<_>>();
        let ([g], [gradient]) = constraint.borrow().value_and_jacobian(&q);
        let constraints = [numbers(&[g]), numbers(&gradient)].concat();
        let mut marks = vec![Hallmark::new("constraints", "a surface", constraints)];
        let (at, mut room) = (Moment { time: 0.0, positions: &[q] }, effects.room(1));
        for number in 0..X::Forces::EFFECTS {
            let mut force = [[S::default(); D]];
            let name = effects.contribute_alone(number, at, &mut room, &mut force);
            let name = short_name(name.unwrap_or("no potential"));
            marks.push(Hallmark::new(format!("effect {number}"), name, numbers(force.as_flattened())));
        }
        marks.push(Hallmark::new("potential energy", "a function", numbers(&[effects.energy(at)])));
        let stages = self.stages.iter().flat_map(|stage| [stage.before, stage.h, stage.after]);
        marks.push(Hallmark::new("method", "a splitting", stages.collect()));
        marks
    }

    fn potential(&self, lane: usize, sight: &Sight<'_, D>) -> f64 {
        let place: [f64; D] = sight.position().into();
        let at = Moment { time: sight.time, positions: &[place.map(S::from_f64)] };
        self.laws.effects(lane).borrow().energy(at).to_f64()
    }

    fn effect_energies(&self, lane: usize, sight: &Sight<'_, D>) -> Vec<f64> {
        let place: [f64; D] = sight.position().into();
        let mut energies = Vec::new();
        let at = Moment { time: sight.time, positions: &[place.map(S::from_f64)] };
        self.laws.effects(lane).borrow().energies(at, &mut energies);
        energies.into_iter().map(S::to_f64).collect()
    }

    fn residual(&self, lane: usize, sight: &Sight<'_, D>) -> f64 {
        let place: [f64; D] = sight.position().into();
        let [g] = self.laws.constraint(lane).borrow().value(&place.map(S::from_f64));
        g.to_f64()
    }

    fn constraints(&self, lane: usize, sight: &Sight<'_, D>) -> (Vec<f64>, Vec<SVector<f64, D>>) {
        let (constraint, effects) = (self.laws.constraint(lane), self.laws.effects(lane));
        let own = |x: SVector<f64, D>| <[f64; D]>::from(x).map(S::from_f64);
        let (q, p) = (own(sight.position()), own(sight.momentum()));
        let ([gradient], [bend]) = (constraint.borrow().jacobian(&q), constraint.borrow().jet(&q, &p).2);
        let (normal, mut force) = (Normal::new(gradient), [Force::zero()]);
        let (at, effects) = (Moment { time: sight.time, positions: &[q] }, effects.borrow());
        effects.evaluate(at, &mut effects.room(1), &mut force);
        let lambda = multiplier_from_curvature(bend, force[0].dot(&gradient, S::from_f64(1.0)), &normal);
        (vec![lambda.to_f64()], vec![gradient.map(|n| (lambda * n).to_f64()).into()])
    }
}

/// Where a body is after so many steps, each of which consists of these stages, taken so many times in turn.
#[cold]
#[inline(never)]
fn by_itself<S: Lane, Y: System<S, D>, const D: usize>(
    system: &Y,
    stages: &[Stage],
    steps: u64,
    parts: u32,
    body: &Body<f64, D>,
) -> Result<Body<f64, D>, Failure> {
    let mut bodies = system.bodies(&[body.map(S::from_f64)], 0.0);
    for _ in 0..steps {
        let start = bodies.saved();
        for _ in 0..parts {
            for (i, &Stage { before, h, after }) in stages.iter().enumerate() {
                system.drift(before, h, &mut bodies, &mut ())?;
                if after != 0.0 || stages[(i + 1) % stages.len()].before != 0.0 {
                    system.evaluate_forces(&mut bodies);
                }
                system.settle(after, h, &mut bodies, &mut ())?;
            }
        }
        system.check_kinks(&start, &bodies)?;
    }
    Ok(bodies.body(0).map(Lane::to_f64))
}

/// Kicks of all lanes where they are.
struct Kicking<'a, S, X, const L: usize, const D: usize> {
    q: &'a Vectors<S, L, D>,
    way: Vectors<S, L, D>,
    laws: &'a X,
    kicks: u32,
}

impl<S: Lane, X: Laws<S, D>, const L: usize, const D: usize> Work for Kicking<'_, S, X, L, D> {
    type Done = Vectors<S, L, D>;

    #[inline(always)]
    fn run(self) -> Vectors<S, L, D> {
        let Self { q, mut way, laws, kicks } = self;
        let laws = laws.clone();
        for _ in 0..kicks {
            let q = *black_box(q);
            for lane in 0..L {
                let kicked = laws.kick(lane, &at(&q, lane), S::from_f64(1e-9), at(&way, lane));
                put(&mut way, lane, kicked);
            }
        }
        way
    }
}

/// A block on a tour.
struct Going<'a, S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool> {
    block: &'a Block<S, L, D, SUMS, EQUAL>,
    laws: &'a X,
    parts: &'a [Part],
    tour: &'a mut dyn Tour<D>,
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool> Work
    for Going<'_, S, X, L, D, SUMS, EQUAL>
where
    S: Lane,
    X: Laws<S, D>,
{
    type Done = Result<Block<S, L, D, SUMS, EQUAL>, Stuck>;

    #[inline(always)]
    fn run(self) -> Self::Done {
        let Self { block, laws, parts, tour } = self;
        let laws = laws.clone(); // out of reach of what the loops write
        let mut desk = Desk { block: block.clone(), scratch: Scratch::new() };
        while let Some(Leg { from, steps, written }) = tour.next() {
            let (mut now, end) = (from, from + steps);
            if now == 0 && end > 0 {
                desk.block.look_around(now, &laws, parts)?;
            }
            while now < end {
                let stop = end.min((now / EVERY + 1) * EVERY);
                for _ in now..stop {
                    stride(&mut desk, &laws, parts)?;
                }
                now = stop;
                if now % EVERY == 0 || (now == end && written.is_some()) {
                    desk.block.look_around(now, &laws, parts)?;
                }
            }
            desk.block.check(&laws, parts)?;
            if let Some(written) = written {
                let (q, p) = desk.block.all(&laws, parts);
                written
                    .fill::<L>(|lane| at(&q, lane).map(Lane::to_f64), |lane| at(&p, lane).map(Lane::to_f64));
            }
        }
        Ok(desk.block)
    }
}

/// A step of the method.
#[inline(always)]
fn whole_step<S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>(
    desk: &mut Desk<S, L, D, SUMS, EQUAL>,
    laws: &X,
    parts: &[Part],
) -> Result<(), Stuck>
where
    S: Lane,
    X: Laws<S, D>,
{
    for _ in 0..if EQUAL { 1 } else { parts.len() } {
        step(&mut desk.block, laws, parts, &mut desk.scratch)?;
    }
    Ok(())
}

/// The same, which leads no lane across a kink.
#[inline(always)]
fn stride<S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>(
    desk: &mut Desk<S, L, D, SUMS, EQUAL>,
    laws: &X,
    parts: &[Part],
) -> Result<(), Stuck>
where
    S: Lane,
    X: Laws<S, D>,
{
    if const { X::Constraint::KINKS.is_empty() } {
        return whole_step(desk, laws, parts);
    }
    let (from, way) = (desk.block.q, desk.block.way);
    let stepped = whole_step(desk, laws, parts);
    if let Err(Stuck { lane, failure }) = stepped {
        let ahead = S::from_f64(parts.iter().map(|part| part.h).sum::<f64>() / parts[0].unit);
        let from = at(&from, lane);
        let to = add_scaled(&from, ahead, &at(&way, lane));
        return kink(laws, lane, from, to, Err(Stuck { lane, failure }));
    }
    let (mut changes, mut any) = ([false; L], false);
    for lane in 0..L {
        let (from, to) = (at(&from, lane), at(&desk.block.q, lane));
        changes[lane] = sign_changes(laws.constraint(lane).borrow(), &from, &to);
    }
    changes.iter().for_each(|&changed| any |= changed);
    if any {
        for lane in (0..L).filter(|&lane| changes[lane]) {
            kink(laws, lane, at(&from, lane), at(&desk.block.q, lane), Ok(()))?;
        }
    }
    Ok(())
}

/// What became of a lane: where there is a kink on its way, that, also if it could not be moved.
#[cold]
#[inline(never)]
fn kink<S: Lane, const D: usize>(
    laws: &impl Laws<S, D>,
    lane: usize,
    from: [S; D],
    to: [S; D],
    otherwise: Result<(), Stuck>,
) -> Result<(), Stuck> {
    let [from, to] = [from, to].map(|q| q.map(Lane::to_f64));
    match first_kink::<S, _, D, 1>(laws.constraint(lane).borrow(), 0, &from, &to) {
        Some(kink) => Err(Stuck { lane, failure: Some(Failure::of_kink(kink, 0, None)) }),
        None => otherwise,
    }
}
