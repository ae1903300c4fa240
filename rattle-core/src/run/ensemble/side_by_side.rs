//! Trajectories of a block side by side in lanes: which fail, which stand in, and what is shown.

use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::error::Error;
use crate::methods::rattle::Rattle;
use crate::motion::bodies::{Body, One};
use crate::motion::failure::Failure;
use crate::motion::method::Method;
use crate::motion::state::State;
use crate::motion::system::System;
use crate::number::clock::{after_steps, later, passed};
use crate::number::instructions::{InstructionSet, Work};
use crate::number::lanes::Lane;
use crate::run::ensemble::block::Block;
use crate::run::ensemble::group::Group;
use crate::run::ensemble::laws::Laws;
use crate::run::ensemble::look::{Onlooker, Watched};
use crate::run::ensemble::scratch::{Part, Scratch, Stuck};
use crate::run::simulation::MOST_HALVINGS;
use crate::run::watch::seen::Page;
use crate::run::watch::sight::{Sight, Source};
use crate::systems::surface::kept::{OnSurface, OneByOne};
use nalgebra::SVector;
use std::array::from_fn;
use std::borrow::Borrow;

/// Trajectories of a full group.
pub(crate) const GROUP: usize = 64;

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
    /// How often a step that cannot be taken is halved.
    halvings: u32,
}

/// Position and momentum, and what rounding took from them.
type Place<S, const D: usize> = ([[S; D]; 2], [[S; D]; 2]);

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
        Self { block, laws, parts, h, steps: 0, start_time, moving, copy_of, ended: Vec::new(), halvings: 0 }
    }

    /// Takes so many steps, or none if a lane fails on the way; but what was shown on the way was shown.
    fn attempt(
        &mut self,
        steps: u64,
        set: InstructionSet,
        onlooker: Option<&mut Onlooker<'_, D>>,
    ) -> Result<(), Stuck> {
        S::run(set, Stretch { group: self, steps, onlooker })?;
        self.steps += steps;
        Ok(())
    }

    /// Takes one step with all lanes that can be moved, be it in parts.
    fn step(&mut self, set: InstructionSet, onlooker: Option<&mut Onlooker<'_, D>>) {
        let (end, mut together) = (self.steps + 1, self.moving);
        let (mut divided, mut laws) = (Vec::new(), None);
        while together.contains(&true) {
            let Err(Stuck { lane, failure }) = self.attempt(1, set, None) else { break };
            let stuck = self.copy_of[lane];
            match self.in_parts(stuck, failure) {
                Ok(place) => {
                    laws.get_or_insert_with(|| self.laws.clone());
                    divided.push((stuck, place));
                }
                Err(failure) => self.end(stuck, failure),
            }
            together[stuck] = false;
            self.stand_in(&together);
        }
        if let Some(laws) = laws {
            self.laws = laws;
            for (lane, (q, p)) in divided {
                self.block.set(lane, &self.laws, &self.parts, q, p);
            }
            self.stand_in(&self.moving.clone());
        }
        self.steps = end;
        if let Some(onlooker) = onlooker
            && onlooker.next == end
        {
            self.look(onlooker.now.page(), set);
            onlooker.show(self);
        }
    }

    /// Fills the lanes that are not among these with copies of one that is.
    fn stand_in(&mut self, among: &[bool; L]) {
        let Some(other) = among.iter().position(|&is| is) else { return };
        self.copy_of = from_fn(|lane| if among[lane] { lane } else { other });
        for lane in (0..L).filter(|&lane| !among[lane]) {
            self.block.copy(other, lane);
            self.laws.copy(other, lane);
        }
    }

    /// Has a trajectory rest where it is.
    fn end(&mut self, lane: usize, failure: Error) {
        let (q, p) = (self.block.position(lane), self.momentum(lane));
        self.ended.push(Ended { lane, steps: self.steps, q, p, failure });
        self.moving[lane] = false;
    }

    /// Where a trajectory is after a step in parts, as often halved as is allowed, by itself: with sums that are
    /// compensated until it is back in its lane.
    #[cold]
    fn in_parts(&self, lane: usize, mut failure: Failure) -> Result<Place<S, D>, Error> {
        let ([q, q_low], [p, p_low]) = (self.block.position(lane), self.momentum(lane));
        let (constraint, effects) = (self.laws.constraint(lane), self.laws.effects(lane));
        let system = OnSurface::new(constraint.borrow().clone(), OneByOne, effects.borrow().clone(), One);
        for halved in 1..=self.halvings {
            let number = 1_u32 << halved;
            let mut bodies = system.bodies(|_| Body { q, q_low, p, p_low }, 0.0);
            let lengths = self.parts.iter().map(|part| part.length() / f64::from(number));
            let mut steps = (0..number).flat_map(|_| lengths.clone());
            match steps.try_for_each(|h| Rattle::new(h).step(&system, &mut bodies, &mut [], &mut ())) {
                Ok(()) => {
                    let Body { q, q_low, p, p_low } = bodies.body(0);
                    return Ok(([q, q_low], [p, p_low]));
                }
                Err(again) => failure = again,
            }
        }
        let (step, time, halvings) = (self.steps + 1, self.time(lane).0, self.halvings);
        let Failure { body, cause } = failure;
        Err(match halvings {
            0 => Error::Step { step, time, body, cause },
            _ => Error::Retried { step, time, body, halvings, cause },
        })
    }

    #[inline(always)]
    fn momentum(&self, lane: usize) -> [[S; D]; 2] {
        self.block.momentum(lane, &self.laws, &self.parts)
    }

    /// Writes all trajectories, which after so many steps are in this block.
    #[inline(always)]
    fn write(&self, block: &Block<S, L, D, SUMS>, laws: &X, steps: u64, page: Page<'_, D>) {
        let (q, p) = block.all(laws, &self.parts);
        let Page { times, positions, momenta } = page;
        for (lane, place) in positions.iter_mut().enumerate().take(L) {
            *place = from_fn::<_, D, _>(|d| q[d][lane].to_f64()).into();
        }
        for (lane, way) in momenta.iter_mut().enumerate().take(L) {
            *way = from_fn::<_, D, _>(|d| p[d][lane].to_f64()).into();
        }
        let passed = passed(steps, self.h);
        times.iter_mut().zip(&self.start_time).for_each(|(time, &start)| *time = later(start, passed).0);
        for &Ended { lane, ref q, ref p, .. } in &self.ended {
            times[lane] = self.time(lane).0;
            positions[lane] = q[0].map(Lane::to_f64).into();
            momenta[lane] = p[0].map(Lane::to_f64).into();
        }
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
    fn numbers(&self, lane: usize) -> Place<S, D> {
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

/// Steps of a block. If a lane fails, the block is as before.
struct Stretch<'a, 'b, G, const D: usize> {
    group: &'a mut G,
    steps: u64,
    onlooker: Option<&'a mut Onlooker<'b, D>>,
}

/// Writes all trajectories.
struct Look<'a, G, const D: usize> {
    group: &'a G,
    page: Page<'a, D>,
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
        let Self { group, page } = self;
        let laws = group.laws.clone();
        group.write(&group.block, &laws, group.steps, page);
    }
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize> Work
    for Stretch<'_, '_, SideBySide<S, X, L, D, SUMS>, D>
where
    S: Lane,
    X: Laws<S, D>,
{
    type Done = Result<(), Stuck>;

    #[inline(always)]
    fn run(self) -> Self::Done {
        let Self { group, steps, mut onlooker } = self;
        let (laws, parts) = (group.laws.clone(), &group.parts);
        let mut desk = Desk { block: group.block.clone(), scratch: Scratch::new() };
        let (mut now, end) = (group.steps, group.steps + steps);
        loop {
            let stop = onlooker.as_ref().map_or(end, |onlooker| onlooker.next.min(end));
            for _ in now..stop {
                if Part::are_equal(parts) {
                    desk.block.advance::<true>(&laws, parts, &mut desk.scratch)?;
                    continue;
                }
                for _ in 0..parts.len() {
                    desk.block.advance::<false>(&laws, parts, &mut desk.scratch)?;
                }
            }
            desk.block.check(&laws)?;
            now = stop;
            if let Some(onlooker) = &mut onlooker
                && onlooker.next == now
            {
                group.write(&desk.block, &laws, now, onlooker.now.page());
                onlooker.show(group);
            }
            if now == end {
                break;
            }
        }
        group.block = desk.block;
        Ok(())
    }
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize> Group<D> for SideBySide<S, X, L, D, SUMS>
where
    S: Lane,
    X: Laws<S, D>,
{
    fn run(&mut self, steps: u64, set: InstructionSet, mut onlooker: Option<&mut Onlooker<'_, D>>) {
        let end = self.steps.saturating_add(steps);
        while self.steps < end && self.moving.contains(&true) {
            let stretch = STRETCH.min(end - self.steps);
            if self.attempt(stretch, set, onlooker.as_deref_mut()).is_err() {
                (0..stretch).for_each(|_| self.step(set, onlooker.as_deref_mut())); // to see which, and where
            }
        }
        self.steps = end;
    }

    fn retry(&mut self, halvings: u32) {
        self.halvings = halvings.min(MOST_HALVINGS);
    }

    fn state(&self, trajectory: usize) -> State<D> {
        let (q, p) = self.numbers(trajectory);
        let [q, q_low, p, p_low] = [q[0], q[1], p[0], p[1]].map(|x| x.map(Lane::to_f64));
        let mut state = State::at(q);
        (state.time, state.time_low) = self.time(trajectory);
        state.bodies[0] = Body { q, q_low, p, p_low };
        state
    }

    fn failure(&self, trajectory: usize) -> Option<&Error> {
        self.ended(trajectory).map(|ended| &ended.failure)
    }
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize> Watched<D> for SideBySide<S, X, L, D, SUMS>
where
    S: Lane,
    X: Laws<S, D>,
{
    fn len(&self) -> usize {
        self.start_time.len()
    }

    fn bodies(&self) -> usize {
        1
    }

    fn look(&self, page: Page<'_, D>, set: InstructionSet) {
        S::run(set, Look { group: self, page });
    }

    fn moving(&self) -> &[bool] {
        &self.moving
    }
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize> Source<D> for SideBySide<S, X, L, D, SUMS>
where
    S: Lane,
    X: Laws<S, D>,
{
    fn energies(&self, lane: usize, positions: &[SVector<f64, D>], momenta: &[SVector<f64, D>]) -> [f64; 2] {
        let place: [f64; D] = positions[0].into();
        let at = Moment { time: 0.0, positions: &[place.map(S::from_f64)] };
        let potential = self.laws.effects(lane).borrow().energy(at);
        [0.5 * momenta[0].norm_squared(), potential.to_f64()]
    }

    fn constraints(&self, lane: usize, sight: &Sight<'_, D>) -> (Vec<f64>, Vec<SVector<f64, D>>) {
        let (constraint, effects) = (self.laws.constraint(lane), self.laws.effects(lane));
        let system = OnSurface::new(constraint.borrow().clone(), OneByOne, effects.borrow().clone(), One);
        let own = |x: SVector<f64, D>| <[f64; D]>::from(x).map(S::from_f64);
        let (q, p, low) = (own(sight.position()), own(sight.momentum()), own(SVector::zeros()));
        let bodies = system.bodies(|_| Body { q, q_low: low, p, p_low: low }, sight.time);
        let (mut multiplier, mut force) = ([S::from_f64(0.0)], [low]);
        system.multipliers(&bodies, &mut multiplier);
        system.constraint_forces(&bodies, &mut force);
        (multiplier.map(Lane::to_f64).to_vec(), vec![force[0].map(Lane::to_f64).into()])
    }

    fn mass_product(&self, _: usize, _: usize, a: &[f64; D], b: &[f64; D]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    fn step_size(&self) -> f64 {
        self.h
    }
}
