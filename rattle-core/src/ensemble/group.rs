//! Trajectories that are moved on together: those of a block side by side, or one by itself.

use crate::bodies::Body;
use crate::ensemble::block::{Block, Part, Scratch, Stuck};
use crate::ensemble::instruction_set::{InstructionSet, Work};
use crate::ensemble::laws::Laws;
use crate::ensemble::observe::Sight;
use crate::error::Error;
use crate::lanes::Lane;
use crate::simulation::{Simulation, after_steps};
use crate::state::State;
use crate::stepper::{Failure, Stepper};
use crate::system::System;
use nalgebra::SVector;
use std::array::from_fn;

/// Some trajectories of an ensemble.
#[allow(clippy::len_without_is_empty, reason = "there is one at least")]
pub trait Group<const D: usize>: Send + Sync {
    /// How many there are.
    fn len(&self) -> usize;
    /// Takes so many steps; trajectories that fail rest where they were before the step.
    fn run(&mut self, steps: u64, set: InstructionSet);
    /// The state of one.
    fn state(&self, trajectory: usize) -> State<D>;
    /// Writes times, and positions and momenta of all bodies, of all trajectories in turn.
    fn look(&self, seen: &mut Seen<D>, set: InstructionSet);
    /// Why one goes on no more.
    fn failure(&self, trajectory: usize) -> Option<&Error>;
}

/// Times, positions and momenta of a group's trajectories in turn.
#[derive(Debug, Clone, Default)]
pub struct Seen<const D: usize> {
    pub(crate) times: Vec<f64>,
    pub(crate) positions: Vec<SVector<f64, D>>,
    pub(crate) momenta: Vec<SVector<f64, D>>,
}

impl<const D: usize> Seen<D> {
    pub(crate) fn clear(&mut self) {
        self.times.clear();
        self.positions.clear();
        self.momenta.clear();
    }

    /// One of the trajectories, which all have as many bodies.
    pub(crate) fn sight(&self, first: usize, own: usize) -> Sight<'_, D> {
        let bodies = self.positions.len() / self.times.len();
        let bodies = own * bodies..(own + 1) * bodies;
        let (positions, momenta) = (&self.positions[bodies.clone()], &self.momenta[bodies]);
        Sight { trajectory: first + own, time: self.times[own], positions, momenta }
    }
}

/// A simulation by itself.
pub(crate) struct Alone<Y: System<f64, D>, S: Stepper, const D: usize> {
    simulation: Simulation<Y, S, D>,
    failure: Option<Error>,
}

impl<Y: System<f64, D>, S: Stepper, const D: usize> Alone<Y, S, D> {
    pub(crate) fn new(simulation: Simulation<Y, S, D>) -> Self {
        Self { simulation, failure: None }
    }
}

impl<Y: System<f64, D>, S: Stepper, const D: usize> Group<D> for Alone<Y, S, D> {
    fn len(&self) -> usize {
        1
    }
    fn run(&mut self, steps: u64, _: InstructionSet) {
        if self.failure.is_none() {
            self.failure = self.simulation.run(steps).err();
        }
    }
    fn state(&self, _: usize) -> State<D> {
        self.simulation.state()
    }
    fn look(&self, seen: &mut Seen<D>, _: InstructionSet) {
        seen.times.push(self.simulation.time());
        seen.positions.extend(self.simulation.positions());
        seen.momenta.extend(self.simulation.momenta());
    }
    fn failure(&self, _: usize) -> Option<&Error> {
        self.failure.as_ref()
    }
}

/// Steps after which a block is put back: what is gone through again when a lane fails.
const STRETCH: u64 = 1024;

/// Trajectories in the lanes of a block.
pub(crate) struct SideBySide<S, X, const L: usize, const D: usize, const SUMS: usize> {
    block: Block<S, L, D, SUMS>,
    laws: X,
    parts: Vec<Part>,
    h: f64,
    steps: u64,
    /// Times of the starts, and what rounding took from them.
    start_time: Vec<(f64, f64)>,
    /// By lane: whether a trajectory moves in it, else the lane that it is a copy of.
    moving: [bool; L],
    copy_of: [usize; L],
    ended: Vec<Ended<S, D>>,
}

/// A trajectory that goes on no more.
struct Ended<S, const D: usize> {
    lane: usize,
    steps: u64,
    q: [[S; D]; 2],
    p: [[S; D]; 2],
    failure: Error,
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize> SideBySide<S, X, L, D, SUMS>
where
    S: Lane,
    X: Laws<S, D>,
{
    /// The trajectories that start so, one per lane, at most L; by a method that takes RATTLE steps of these lengths.
    pub(crate) fn new(starts: &[State<D>], laws: X, lengths: &[f64], h: f64) -> Self {
        let parts = Part::of(lengths);
        let mut block = Block::new();
        let mut moving = [false; L];
        for (lane, start) in starts.iter().enumerate().take(L) {
            let body = &start.bodies[0];
            let own = |x: [f64; D]| x.map(S::from_f64);
            let both = |x: [f64; D], low: [f64; D]| {
                if SUMS == 1 { [own(x), own(low)] } else { [own(x), own([0.0; D])] }
            };
            block.set(lane, &laws, &parts, both(body.q, body.q_low), both(body.p, body.p_low));
            moving[lane] = true;
        }
        let copy_of = from_fn(|lane| if lane < starts.len() { lane } else { 0 });
        for lane in starts.len()..L {
            block.copy(0, lane);
        }
        let start_time = starts.iter().map(|start| (start.time, start.time_low)).collect();
        Self { block, laws, parts, h, steps: 0, start_time, moving, copy_of, ended: Vec::new() }
    }

    /// Takes so many steps, or none if a lane fails on the way.
    fn attempt(&mut self, steps: u64, set: InstructionSet) -> Result<(), Stuck> {
        S::run(set, Stretch { group: self, steps })?;
        self.steps += steps;
        Ok(())
    }

    /// Takes one step with all lanes that can be moved.
    fn step(&mut self, set: InstructionSet) {
        while self.moving.contains(&true) {
            match self.attempt(1, set) {
                Ok(()) => return,
                Err(Stuck { lane, failure }) => self.end(lane, failure),
            }
        }
        self.steps += 1;
    }

    /// Takes the trajectory that is in a lane, itself or as a copy, and cannot be moved on, out of the block.
    fn end(&mut self, lane: usize, Failure { body, cause }: Failure) {
        let stuck = self.copy_of[lane];
        if std::mem::replace(&mut self.moving[stuck], false) {
            let (q, p) = (self.block.position(stuck), self.momentum(stuck));
            let (time, _) = self.time(stuck);
            let failure = Error::Step { step: self.steps + 1, time, body, cause };
            self.ended.push(Ended { lane: stuck, steps: self.steps, q, p, failure });
        }
        let Some(other) = self.moving.iter().position(|&moves| moves) else { return };
        for copy in (0..L).filter(|&copy| self.copy_of[copy] == stuck) {
            self.block.copy(other, copy);
            self.laws.copy(other, copy);
        }
        self.copy_of = self.copy_of.map(|of| if of == stuck { other } else { of });
    }

    #[inline(always)]
    fn momentum(&self, lane: usize) -> [[S; D]; 2] {
        self.block.momentum(lane, &self.laws, &self.parts)
    }

    /// The time of a trajectory, and what rounding took from it.
    fn time(&self, lane: usize) -> (f64, f64) {
        let steps = self.ended(lane).map_or(self.steps, |ended| ended.steps);
        after_steps(self.start_time[lane], steps, self.h)
    }

    fn ended(&self, lane: usize) -> Option<&Ended<S, D>> {
        self.ended.iter().find(|ended| ended.lane == lane)
    }

    #[inline(always)]
    fn numbers(&self, lane: usize) -> ([[S; D]; 2], [[S; D]; 2]) {
        self.ended(lane)
            .map_or_else(|| (self.block.position(lane), self.momentum(lane)), |ended| (ended.q, ended.p))
    }
}

/// What a thread works on. All in one place, at a place of the same kind each time: processors take numbers for the same
/// whose addresses differ by a multiple of the alignment, and wait for one when they need the other.
#[repr(C, align(4096))]
struct Desk<S, const L: usize, const D: usize, const SUMS: usize> {
    block: Block<S, L, D, SUMS>,
    scratch: Scratch<S, L, D>,
}

/// Steps of a block, without looking up. If a lane fails, the block is as before.
struct Stretch<'a, G> {
    group: &'a mut G,
    steps: u64,
}

/// Looks up.
struct Look<'a, G, const D: usize> {
    group: &'a G,
    seen: &'a mut Seen<D>,
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize> Work
    for Look<'_, SideBySide<S, X, L, D, SUMS>, D>
where
    S: Lane,
    X: Laws<S, D>,
{
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { group, seen } = self;
        for lane in 0..group.start_time.len() {
            let (q, p) = group.numbers(lane);
            seen.times.push(group.time(lane).0);
            seen.positions.push(q[0].map(Lane::to_f64).into());
            seen.momenta.push(p[0].map(Lane::to_f64).into());
        }
    }
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize> Work
    for Stretch<'_, SideBySide<S, X, L, D, SUMS>>
where
    S: Lane,
    X: Laws<S, D>,
{
    type Done = Result<(), Stuck>;

    #[inline(always)]
    fn run(self) -> Self::Done {
        let SideBySide { block, laws, parts, .. } = self.group;
        let laws = laws.clone();
        let mut desk = Desk { block: block.clone(), scratch: Scratch::new() };
        for _ in 0..self.steps {
            if Part::are_equal(parts) {
                desk.block.advance::<true>(&laws, parts, &mut desk.scratch)?;
                continue;
            }
            for _ in 0..parts.len() {
                desk.block.advance::<false>(&laws, parts, &mut desk.scratch)?;
            }
        }
        desk.block.check(&laws)?;
        *block = desk.block;
        Ok(())
    }
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize> Group<D> for SideBySide<S, X, L, D, SUMS>
where
    S: Lane,
    X: Laws<S, D>,
{
    fn len(&self) -> usize {
        self.start_time.len()
    }

    fn run(&mut self, steps: u64, set: InstructionSet) {
        let end = self.steps.saturating_add(steps);
        while self.steps < end && self.moving.contains(&true) {
            let stretch = STRETCH.min(end - self.steps);
            if self.attempt(stretch, set).is_err() {
                (0..stretch).for_each(|_| self.step(set)); // to see which, and where
            }
        }
        self.steps = end;
    }

    fn state(&self, trajectory: usize) -> State<D> {
        let (q, p) = self.numbers(trajectory);
        let [q, q_low, p, p_low] = [q[0], q[1], p[0], p[1]].map(|x| x.map(Lane::to_f64));
        let mut state = State::at(q);
        (state.time, state.time_low) = self.time(trajectory);
        state.bodies[0] = Body { q, q_low, p, p_low };
        state
    }

    fn look(&self, seen: &mut Seen<D>, set: InstructionSet) {
        S::run(set, Look { group: self, seen });
    }

    fn failure(&self, trajectory: usize) -> Option<&Error> {
        self.ended(trajectory).map(|ended| &ended.failure)
    }
}
