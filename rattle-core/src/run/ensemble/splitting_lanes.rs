//! Splittings in lanes.

use crate::effect::list::Forces;
use crate::effect::noise::Noise;
use crate::error::Error;
use crate::kernel::functions::ConstraintKernel;
use crate::motion::bodies::{Body, One};
use crate::motion::failure::Failure;
use crate::motion::method::Stage;
use crate::motion::record::{Hallmark, Reading, Record};
use crate::motion::stir;
use crate::motion::system::System;
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::Lane;
use crate::number::vector::add_scaled;
use crate::number::vectors::at;
use crate::run::ensemble::asked::{Kicking, answered_by_laws, forces, hallmarks};
use crate::run::ensemble::block::{Block, Part, Scratch};
use crate::run::ensemble::crossing::{crossings, kink};
use crate::run::ensemble::engine::{Engine, Leg, Stuck, Tour};
use crate::run::ensemble::laws::Laws;
use crate::run::ensemble::loops::step;
use crate::run::ensemble::stirring::Stirring;
use crate::solve::crowd::EVERY;
use crate::systems::surface::kept::{OnSurface, OneByOne};
use std::any::Any;
use std::borrow::Borrow;
use std::hint::black_box;

/// A block, what its lanes obey, and the parts of a step.
#[derive(Clone)]
pub(crate) struct SplittingLanes<S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool> {
    block: Block<S, L, D, SUMS, EQUAL>,
    laws: X,
    stages: Vec<Stage>,
    parts: Vec<Part>,
    stirring: Option<Box<Stirring<L>>>,
    h: f64,
    set: Fusing,
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>
    SplittingLanes<S, X, L, D, SUMS, EQUAL>
where
    S: Lane,
    X: Laws<S, D>,
{
    /// Lanes, none of them set, that obey these laws in steps of h of stages like these; flows act after so many of
    /// them.
    pub(crate) fn new(laws: X, stages: &[Stage], stirs_after: usize, h: f64, set: Fusing) -> Self {
        let stirring = Stirring::of(&laws, stirs_after, h);
        let (block, stages, parts) = (Block::new(), stages.to_vec(), Part::of::<EQUAL>(stages));
        Self { block, laws, stages, parts, stirring, h, set }
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
    S: Lane + 'static,
    X: Laws<S, D> + 'static,
{
    fn width(&self) -> usize {
        L
    }

    fn bodies_of_each(&self) -> usize {
        1
    }

    fn boxed(&self) -> Box<dyn Engine<D>> {
        Box::new(self.clone())
    }

    fn go(&self, tour: &mut dyn Tour<D>) -> Result<Box<dyn Engine<D>>, Stuck> {
        let block = self.set.run_lanes::<L, _>(Going { lanes: self, tour })?;
        let (laws, stages, parts) = (self.laws.clone(), self.stages.clone(), self.parts.clone());
        Ok(Box::new(Self { block, laws, stages, parts, stirring: self.stirring.clone(), ..*self }))
    }

    fn set(&mut self, lane: usize, bodies: &[Body<f64, D>]) -> bool {
        let Body { q, q_low, p, p_low } = bodies[0].map(S::from_f64);
        let holds = self.block.set(lane, &self.laws, &self.parts, [q, q_low], [p, p_low]);
        holds && self.block.momentum(lane, &self.laws, &self.parts)[0].iter().all(|p| p.to_f64().is_finite())
    }

    fn copy(&mut self, from: usize, to: usize) {
        self.block.copy(from, to);
    }

    fn obey(&mut self, from: usize, to: usize) {
        self.laws.copy(from, to);
        if let Some(stirring) = &mut self.stirring {
            stirring.copy(from, to);
        }
    }

    fn obey_as_in(&mut self, engine: &dyn Engine<D>) {
        if let Some(engine) = (engine as &dyn Any).downcast_ref::<Self>() {
            (self.laws, self.stirring) = (engine.laws.clone(), engine.stirring.clone());
        }
    }

    fn draw_as(&mut self, lane: usize, trajectory: u64, steps: u64) {
        if let Some(stirring) = &mut self.stirring {
            stirring.draw_as(lane, trajectory, steps);
        }
    }

    fn bodies(&self, lane: usize) -> Vec<Body<f64, D>> {
        let ([q, q_low], [p, p_low]) =
            (self.block.position(lane), self.block.momentum(lane, &self.laws, &self.parts));
        vec![Body { q, q_low, p, p_low }.map(S::to_f64)]
    }

    fn by_itself(
        &self,
        lane: usize,
        bodies: &[Body<f64, D>],
        from: u64,
        steps: u64,
        parts: u32,
    ) -> Result<Vec<Body<f64, D>>, Failure> {
        let (constraint, effects) = (self.laws.constraint(lane), self.laws.effects(lane));
        let system = OnSurface::new(constraint.borrow().clone(), OneByOne, effects.borrow().clone(), One);
        let stirs = self.stirring.as_ref().map(|stirring| (stirring.after, stirring.noise(lane, from)));
        by_itself::<S, _, D>(&system, &self.stages, stirs, steps, parts, bodies)
    }

    fn kick_alone(&self, steps: u32) {
        let kicks = steps * self.parts.len() as u32;
        let kicking = Kicking { q: &self.block.q, way: self.block.way, laws: &self.laws, kicks };
        black_box(self.set.run_lanes::<L, _>(kicking));
    }

    fn forces(&self) -> Vec<&'static str> {
        forces(&self.laws)
    }

    fn record(&self, to: &mut Record) {
        self.block.record(to);
    }

    fn recalled(&self, from: &mut Reading<'_>) -> Result<Box<dyn Engine<D>>, Error> {
        Ok(Box::new(Self { block: Block::recalled(from, self.parts.len())?, ..self.clone() }))
    }

    fn hallmarks(&self, lane: usize, bodies: &[Body<f64, D>]) -> Vec<Hallmark> {
        let mut marks = hallmarks(&self.laws, lane, &bodies[0]);
        let stirring = self.stirring.as_ref();
        marks.extend(stirring.map(|of| Hallmark::new("flow 0", "friction and noise", of.numbers(lane))));
        marks
    }

    fn method(&self) -> Hallmark {
        Hallmark::new("method", "a splitting", Stage::numbers(&self.stages))
    }
}

answered_by_laws!(SplittingLanes, EQUAL: bool);

/// A splitting, as it moves rows of linked and of rigid bodies.
pub(super) struct Splits {
    pub(super) stages: Vec<Stage>,
    pub(super) parts: Vec<Part>,
    pub(super) h: f64,
    /// Whether all steps are equal: a step of the method is one stage.
    pub(super) equal: bool,
    /// Whether sums are compensated.
    pub(super) sums: bool,
    pub(super) set: Fusing,
}

impl Splits {
    pub(super) fn new(stages: &[Stage], h: f64, equal: bool, sums: bool, set: Fusing) -> Self {
        let parts = if equal { Part::of::<true>(stages) } else { Part::of::<false>(stages) };
        Self { stages: stages.to_vec(), parts, h, equal, sums, set }
    }

    pub(super) fn hallmark(&self) -> Hallmark {
        Hallmark::new("method", "a splitting", Stage::numbers(&self.stages))
    }
}

/// Where bodies are after so many steps of these stages, each in so many equal parts; with flows that act after so many
/// stages, and draw these random numbers in the first step.
#[cold]
#[inline(never)]
pub(super) fn by_itself<S: Lane, Y: System<S, D>, const D: usize>(
    system: &Y,
    stages: &[Stage],
    stirs: Option<(usize, Noise)>,
    steps: u64,
    parts: u32,
    places: &[Body<f64, D>],
) -> Result<Vec<Body<f64, D>>, Failure> {
    let (stages, whole) = Stage::parts(stages, parts);
    let mut bodies = system.bodies(&in_lanes(places), 0.0);
    for step in 0..steps {
        if step > 0 {
            system.refresh(&mut bodies); // as where a run is divided: bits depend on no division
        }
        if let Some((_, first)) = stirs {
            bodies.noise = Noise { step: first.step + step, ..first };
        }
        let start = bodies.saved();
        for _ in 0..parts {
            for (i, &Stage { before, h, after }) in stages.iter().enumerate() {
                system.drift(before, h, &mut bodies, &mut ())?;
                if after != 0.0 || stages[(i + 1) % stages.len()].before != 0.0 {
                    system.evaluate_forces(&mut bodies);
                }
                system.settle(after, h, &mut bodies, &mut ())?;
                if const { Y::FLOWS > 0 }
                    && let Some((after, _)) = stirs
                    && i + 1 == after
                {
                    stir::in_the_middle(whole, system, &mut bodies)?;
                }
            }
        }
        system.check_kinks(&start, &bodies)?;
    }
    Ok(out_of_lanes(&bodies.all()))
}

/// Bodies in a lane's numbers.
#[inline(never)]
pub(super) fn in_lanes<S: Lane, const D: usize>(bodies: &[Body<f64, D>]) -> Vec<Body<S, D>> {
    bodies.iter().map(|body| body.map(S::from_f64)).collect()
}

/// And back.
#[inline(never)]
pub(super) fn out_of_lanes<S: Lane, const D: usize>(bodies: &[Body<S, D>]) -> Vec<Body<f64, D>> {
    bodies.iter().map(|body| body.map(S::to_f64)).collect()
}

/// A block on a tour.
struct Going<'a, S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool> {
    lanes: &'a SplittingLanes<S, X, L, D, SUMS, EQUAL>,
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
        let Self { lanes: SplittingLanes { block, laws, parts, stirring, .. }, tour } = self;
        let laws = laws.clone(); // out of reach of what the loops write
        let stirring = stirring.as_deref().filter(|_| const { X::Forces::FLOWS > 0 });
        let least = |lane| stirring.map_or(0.0, |stirring| stirring.momentum(lane));
        let mut desk = Desk { block: block.clone(), scratch: Scratch::new() };
        while let Some(Leg { from, steps, written, shown }) = tour.next() {
            let (mut now, end) = (from, from + steps);
            if now == 0 && end > 0 {
                desk.block.look_around(now, &laws, parts, least)?;
            }
            while now < end {
                let stop = end.min((now / EVERY + 1) * EVERY);
                for now in now..stop {
                    stride(&mut desk, &laws, parts, stirring, now)?;
                }
                now = stop;
                if now % EVERY == 0 || (now == end && shown) {
                    desk.block.look_around(now, &laws, parts, least)?;
                }
            }
            if shown || written.is_none() {
                desk.block.check(&laws, parts)?;
            }
            if let Some(written) = written {
                let (q, p) = desk.block.all(&laws, parts);
                written.fill(L, |lane| at(&q, lane).map(S::to_f64), |lane| at(&p, lane).map(S::to_f64));
            }
        }
        Ok(desk.block)
    }
}

/// A step of the method, after so many.
#[inline(always)]
fn whole_step<S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>(
    desk: &mut Desk<S, L, D, SUMS, EQUAL>,
    laws: &X,
    parts: &[Part],
    stirring: Option<&Stirring<L>>,
    steps: u64,
) -> Result<(), Stuck>
where
    S: Lane,
    X: Laws<S, D>,
{
    for done in 1..=if EQUAL { 1 } else { parts.len() } {
        step(&mut desk.block, laws, parts, &mut desk.scratch)?;
        if const { X::Forces::FLOWS > 0 }
            && let Some(stirring) = stirring
            && done == stirring.after
        {
            stirring.act(steps, &mut desk.block, laws, &parts[done % parts.len()]);
        }
    }
    Ok(())
}

/// The same, which leads no lane across a kink.
#[inline(always)]
fn stride<S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>(
    desk: &mut Desk<S, L, D, SUMS, EQUAL>,
    laws: &X,
    parts: &[Part],
    stirring: Option<&Stirring<L>>,
    steps: u64,
) -> Result<(), Stuck>
where
    S: Lane,
    X: Laws<S, D>,
{
    if const { X::Constraint::KINKS.is_empty() } {
        return whole_step(desk, laws, parts, stirring, steps);
    }
    let (from, way) = (desk.block.q, desk.block.way);
    let stepped = whole_step(desk, laws, parts, stirring, steps);
    if let Err(Stuck { lane, failure }) = stepped {
        let ahead = S::from_f64(parts.iter().map(|part| part.h).sum::<f64>() / parts[0].unit);
        let from = at(&from, lane);
        let to = add_scaled(&from, ahead, &at(&way, lane));
        return kink(laws, lane, from, to, Err(Stuck { lane, failure }));
    }
    crossings(laws, &from, &desk.block.q)
}
