//! Splittings in lanes.

use crate::effect::force::Force;
use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::kernel::functions::ConstraintKernel;
use crate::motion::bodies::{Body, One};
use crate::motion::failure::Failure;
use crate::motion::method::Stage;
use crate::motion::system::System;
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::Lane;
use crate::number::vectors::at;
use crate::run::ensemble::block::{Block, Part, Scratch};
use crate::run::ensemble::engine::{Engine, Kept, Stuck, Tour, Written};
use crate::run::ensemble::laws::Laws;
use crate::run::ensemble::loops::step;
use crate::run::watch::sight::Sight;
use crate::systems::surface::kept::{OnSurface, OneByOne};
use crate::systems::surface::normal::{Normal, multiplier_from_curvature};
use nalgebra::SVector;
use std::borrow::Borrow;

/// A block, what its lanes obey, and the parts of a step.
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

    /// Where the lanes are after a tour.
    fn after(&self, tour: &mut dyn Tour<D>) -> Result<Block<S, L, D, SUMS, EQUAL>, Stuck> {
        let going = Going { block: &self.block, laws: &self.laws, parts: &self.parts, tour };
        if const { L == 1 } { self.set.run_narrow(going) } else { self.set.run(going) }
    }
}

/// No step at all.
struct Look<'a, const D: usize>(Option<Written<'a, D>>);

impl<const D: usize> Tour<D> for Look<'_, D> {
    fn next(&mut self) -> Option<(u64, Option<Written<'_, D>>)> {
        self.0.take().map(|written| (0, Some(written)))
    }
}

/// What a thread works on. All in one place, at a place of the same kind each time: processors take numbers for the same
/// whose addresses differ by a multiple of the alignment, and wait for one when they need the other.
#[repr(C, align(4096))]
struct Desk<S, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool> {
    block: Block<S, L, D, SUMS, EQUAL>,
    scratch: Scratch<S, L, D>,
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool> Engine<D>
    for SplittingLanes<S, X, L, D, SUMS, EQUAL>
where
    S: Lane,
    X: Laws<S, D> + 'static,
{
    fn width(&self) -> usize {
        L
    }

    fn room(&self) -> Kept {
        Box::new(self.block.clone())
    }

    fn go(&self, tour: &mut dyn Tour<D>, after: &mut Kept) -> Result<(), Stuck> {
        let lanes = self.after(tour)?;
        if let Some(after) = after.downcast_mut() {
            *after = lanes;
        }
        Ok(())
    }

    fn keep(&mut self, after: &Kept) {
        if let Some(after) = after.downcast_ref() {
            self.block.clone_from(after);
        }
    }

    fn look(&self, written: Written<'_, D>) {
        let stayed = self.after(&mut Look(Some(written)));
        debug_assert!(stayed.is_ok(), "no step is taken that could fail");
    }

    fn set(&mut self, lane: usize, body: &Body<f64, D>) {
        let Body { q, q_low, p, p_low } = body.map(S::from_f64);
        self.block.set(lane, &self.laws, &self.parts, [q, q_low], [p, p_low]);
    }

    fn copy(&mut self, from: usize, to: usize) {
        self.block.copy(from, to);
        self.laws.copy(from, to);
    }

    fn laws(&self) -> Kept {
        Box::new(self.laws.clone())
    }

    fn obey(&mut self, laws: &Kept) {
        if let Some(laws) = laws.downcast_ref() {
            self.laws.clone_from(laws);
        }
    }

    fn body(&self, lane: usize) -> Body<f64, D> {
        let ([q, q_low], [p, p_low]) =
            (self.block.position(lane), self.block.momentum(lane, &self.laws, &self.parts));
        Body { q, q_low, p, p_low }.map(Lane::to_f64)
    }

    fn in_parts(&self, lane: usize, number: u32) -> Result<Body<f64, D>, Failure> {
        let (constraint, effects) = (self.laws.constraint(lane), self.laws.effects(lane));
        in_parts::<S, _, _, D>(constraint.borrow(), effects.borrow(), &self.stages, number, &self.body(lane))
    }

    fn potential(&self, lane: usize, sight: &Sight<'_, D>) -> f64 {
        let place: [f64; D] = sight.position().into();
        let at = Moment { time: sight.time, positions: &[place.map(S::from_f64)] };
        self.laws.effects(lane).borrow().energy(at).to_f64()
    }

    fn constraints(&self, lane: usize, sight: &Sight<'_, D>) -> (Vec<f64>, Vec<SVector<f64, D>>) {
        let (constraint, effects) = (self.laws.constraint(lane), self.laws.effects(lane));
        constraints::<S, _, _, D>(constraint.borrow(), effects.borrow(), sight)
    }
}

/// The multiplier and the constraint force of a body that this sight shows.
#[inline(never)]
fn constraints<S: Lane, K: ConstraintKernel<S, D, 1>, F: Forces<S, D>, const D: usize>(
    constraint: &K,
    effects: &F,
    sight: &Sight<'_, D>,
) -> (Vec<f64>, Vec<SVector<f64, D>>) {
    let own = |x: SVector<f64, D>| <[f64; D]>::from(x).map(S::from_f64);
    let (q, p) = (own(sight.position()), own(sight.momentum()));
    let ([gradient], [bend]) = (constraint.jacobian(&q), constraint.jet(&q, &p).2);
    let (normal, mut force) = (Normal::new(gradient), [Force::zero()]);
    let at = Moment { time: sight.time, positions: &[q] };
    effects.evaluate(at, &mut effects.room(1), &mut force);
    let lambda = multiplier_from_curvature(bend, force[0].dot(&gradient, S::from_f64(1.0)), &normal);
    (vec![lambda.to_f64()], vec![gradient.map(|n| (lambda * n).to_f64()).into()])
}

/// Where a body is after these stages, each in so many equal parts.
#[cold]
#[inline(never)]
fn in_parts<S: Lane, K: ConstraintKernel<S, D, 1>, F: Forces<S, D>, const D: usize>(
    constraint: &K,
    effects: &F,
    stages: &[Stage],
    number: u32,
    body: &Body<f64, D>,
) -> Result<Body<f64, D>, Failure> {
    let system = OnSurface::new(constraint.clone(), OneByOne, effects.clone(), One);
    let mut bodies = system.bodies(&[body.map(S::from_f64)], 0.0);
    let share = |x: f64| x / f64::from(number);
    for _ in 0..number {
        for (i, stage) in stages.iter().enumerate() {
            let [before, h, after] = [stage.before, stage.h, stage.after].map(share);
            system.drift(before, h, &mut bodies, &mut ())?;
            if after != 0.0 || stages[(i + 1) % stages.len()].before != 0.0 {
                system.evaluate_forces(&mut bodies);
            }
            system.settle(after, h, &mut bodies, &mut ())?;
        }
    }
    Ok(bodies.body(0).map(Lane::to_f64))
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
        while let Some((steps, written)) = tour.next() {
            for _ in 0..steps {
                for _ in 0..if EQUAL { 1 } else { parts.len() } {
                    step(&mut desk.block, &laws, parts, &mut desk.scratch)?;
                }
            }
            desk.block.check(&laws)?;
            if let Some(written) = written {
                let (q, p) = desk.block.all(&laws, parts);
                written
                    .fill::<L>(|lane| at(&q, lane).map(Lane::to_f64), |lane| at(&p, lane).map(Lane::to_f64));
            }
        }
        Ok(desk.block)
    }
}
