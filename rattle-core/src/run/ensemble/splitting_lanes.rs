//! Splittings in lanes.

use crate::effect::interval::Half;
use crate::effect::list::Forces;
use crate::effect::noise::Noise;
use crate::error::Error;
use crate::kernel::functions::ConstraintKernel;
use crate::motion::bodies::{Bodies, Body, Count, Saved};
use crate::motion::course::kink_ahead;
use crate::motion::failure::Failure;
use crate::motion::method::Stage;
use crate::motion::parts::{BodiesOf, Parts};
use crate::motion::record::{Hallmark, Reading, Record};
use crate::motion::stir::{Chosen, draws, in_the_middle, stir};
use crate::motion::system::System;
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::Lane;
use crate::number::vector::add_scaled;
use crate::number::vectors::at;
use crate::run::ensemble::asked::{Kicking, answered_by_laws, forces, hallmarks};
use crate::run::ensemble::block::{Block, Desk, OfLane, Part};
use crate::run::ensemble::crossing::{crossings, kink};
use crate::run::ensemble::engine::{Draws, Engine, Leg, Moved, OwnSteps, Stuck, Tour};
use crate::run::ensemble::laws::{Laws, system_of};
use crate::run::ensemble::loops::step;
use crate::run::ensemble::splits::{backwards, hallmark, without_first_kick};
use crate::run::ensemble::stirred::{Stepping, Stirs, limit, look_around};
use crate::run::ensemble::stirring::Stirring;
use crate::run::fingerprint::Looks;
use crate::run::reversal::compare;
use crate::run::trouble::Trouble;
use crate::solve::crowd::EVERY;
use std::any::Any;
use std::hint::black_box;

/// A block, what its lanes obey, and the parts of a step.
///
/// Where flows act half before each step and half after it, momenta are ahead by no kick: that before a step is made
/// once flows have acted.
#[derive(Clone)]
pub(crate) struct SplittingLanes<S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool> {
    block: Block<S, L, D, SUMS, EQUAL>,
    laws: X,
    stages: Vec<Stage>,
    parts: Vec<Part>,
    stirring: Option<Box<Stirring<S, L, D>>>,
    account: Account,
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
    /// them, or after none half before each step and half after it.
    pub(crate) fn new(laws: X, stages: &[Stage], stirs_after: usize, h: f64, set: Fusing) -> Self {
        let (block, stirring) = (Block::new(), Stirring::of(&laws, stirs_after, h));
        let (mut parts, mut account) = (Part::of::<EQUAL>(stages), Account::default());
        if const { X::Forces::FLOWS > 0 } {
            account = Account { work: vec![0.0; L], limits: vec![0.0; L] };
            if stirs_after == 0 {
                parts = Part::of::<EQUAL>(&without_first_kick(stages));
            }
        }
        Self { block, laws, stages: stages.to_vec(), parts, stirring, account, h, set }
    }
}

/// What is kept of each lane where flows act; empty without flows.
#[derive(Clone, Default)]
struct Account {
    /// The work of flows.
    work: Vec<f64>,
    /// The work after which it is asked at once whether other sheets are near.
    limits: Vec<f64>,
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

    fn go(&self, tour: &mut dyn Tour<D>) -> Result<Box<dyn Engine<D>>, Vec<Stuck>> {
        let (block, account) = self.set.run_lanes::<L, _>(Going { lanes: self, tour })?;
        let (laws, stages, parts) = (self.laws.clone(), self.stages.clone(), self.parts.clone());
        Ok(Box::new(Self { block, laws, stages, parts, stirring: self.stirring.clone(), account, ..*self }))
    }

    fn set(&mut self, lane: usize, bodies: &[Body<f64, D>]) -> bool {
        let of = OfLane { block: &mut self.block, lane, laws: &self.laws, parts: &self.parts };
        let fits = self.set.run_narrow((of, bodies[0].map(S::from_f64))) == [true; 2];
        if const { X::Forces::FLOWS > 0 } {
            self.book(lane, self.account.work[lane]);
        }
        fits
    }

    fn copy(&mut self, from: usize, to: usize) {
        self.block.copy(from, to);
        if const { X::Forces::FLOWS > 0 } {
            let Account { work, limits } = &mut self.account;
            (work[to], limits[to]) = (work[from], limits[from]);
        }
    }

    fn obey(&mut self, from: usize, to: usize) {
        self.laws.copy(from, to);
        if const { X::Forces::FLOWS > 0 }
            && let Some(stirring) = &mut self.stirring
        {
            stirring.copy(from, to);
        }
    }

    fn obey_as_in(&mut self, engine: &dyn Engine<D>) {
        if let Some(engine) = (engine as &dyn Any).downcast_ref::<Self>() {
            (self.laws, self.stirring) = (engine.laws.clone(), engine.stirring.clone());
        }
    }

    fn draw_as(&mut self, lane: usize, draws: Draws) {
        if const { X::Forces::FLOWS > 0 }
            && let Some(stirring) = &mut self.stirring
        {
            stirring.rhythm.draw_as(lane, draws);
        }
    }

    fn work(&self, lane: usize) -> Option<f64> {
        self.account.work.get(lane).copied()
    }

    fn book(&mut self, lane: usize, work: f64) {
        if const { X::Forces::FLOWS > 0 } {
            let limit = limit(work, &at(&self.block.way, lane), 0.0);
            (self.account.work[lane], self.account.limits[lane]) = (work, limit);
        }
    }

    fn bodies(&self, lane: usize) -> Vec<Body<f64, D>> {
        let of = OfLane { block: &self.block, lane, laws: &self.laws, parts: &self.parts };
        vec![self.set.run_narrow(of)]
    }

    fn by_itself(
        &self,
        lane: usize,
        bodies: &[Body<f64, D>],
        steps: OwnSteps,
        place: &mut u64,
    ) -> Result<Moved<D>, Trouble> {
        let (system, stages) = (system_of(&self.laws, lane), &self.stages[..]);
        let bodies = system.bodies(&in_lanes(bodies), 0.0);
        if const { X::Forces::FLOWS > 0 }
            && let Some(stirring) = &self.stirring
        {
            let rhythm = &stirring.rhythm;
            let at = |step| (rhythm.noise(lane, steps.from + step), rhythm.now(lane, steps.from + step));
            let (after, work) = (rhythm.after, self.account.work[lane]);
            let stirred = StirredAlone { after, at: &at, place, work };
            let stirred = Some(stirred);
            return self.set.run_narrow(ByItself { system: &system, stages, stirred, steps, bodies });
        }
        self.set.run_narrow(ByItself { system: &system, stages, stirred: None, steps, bodies })
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
        if const { X::Forces::FLOWS > 0 } {
            to.list("work", &self.account.work);
            to.list("work to ask at", &self.account.limits);
        }
    }

    fn recalled(&self, from: &mut Reading<'_>) -> Result<Box<dyn Engine<D>>, Error> {
        let block = Block::recalled(from, self.parts.len())?;
        if const { X::Forces::FLOWS > 0 } {
            let work = from.numbers("work", &[L])?.to_vec();
            let limits = from.numbers("work to ask at", &[L])?.to_vec();
            return Ok(Box::new(Self { block, account: Account { work, limits }, ..self.clone() }));
        }
        Ok(Box::new(Self { block, ..self.clone() }))
    }

    fn hallmarks(&self, lane: usize, looks: &Looks<D>) -> Vec<Hallmark> {
        let mut marks = hallmarks::<S, X, D, SUMS>(&self.laws, lane, looks);
        if const { X::Forces::FLOWS > 0 }
            && let Some(stirring) = &self.stirring
        {
            let body = [looks.first()[0], looks.first_momentum()];
            marks.extend(stirring.hallmarks(&self.laws, lane, body.map(|x| x.map(S::from_f64))));
        }
        marks
    }

    fn method(&self) -> Hallmark {
        hallmark(&self.stages, self.stirring.as_ref().map_or(0, |stirring| stirring.rhythm.after))
    }
}

answered_by_laws!(SplittingLanes, EQUAL: bool);

/// How flows stir bodies that go by themselves.
pub(super) struct StirredAlone<'a> {
    /// After how many stages; after none half before each part of a step and half after it.
    pub(super) after: usize,
    /// Where in the random numbers a trajectory is after so many steps, and when that is.
    pub(super) at: &'a dyn Fn(u64) -> (Noise, f64),
    /// Flows that acted in the first step where it was tried before; and now.
    pub(super) place: &'a mut u64,
    /// The work on them since the start; bodies have that of a step, whose digits in single precision are too few.
    pub(super) work: f64,
}

impl StirredAlone<'_> {
    /// Makes bodies ready for the next step, after so many; with the random numbers of the first try where parts of
    /// steps have those.
    fn begin<S: Lane, Y: System<S, D>, const D: usize>(
        &self,
        step: u64,
        again: bool,
        system: &Y,
        bodies: &mut BodiesOf<Y, S, D>,
    ) {
        let (noise, time) = (self.at)(step);
        bodies.work = S::default();
        if step == 0 {
            let place = if again { noise.place } else { *self.place };
            (bodies.noise, bodies.time) = (Noise { place, ..noise }, time);
            return;
        }
        bodies.noise = noise;
        if system.moves_with_time() {
            system.set_time(bodies, time);
        }
    }

    /// Has flows act for a time h in the middle of a step, or some of them for half of it.
    fn act<S: Lane, Y: System<S, D>, const D: usize>(
        &mut self,
        half: Option<(Chosen, Half)>,
        h: f64,
        system: &Y,
        bodies: &mut BodiesOf<Y, S, D>,
    ) -> Result<(), Failure> {
        let acted = match half {
            Some((chosen, half)) => stir(chosen, half, 0.5 * h, system, bodies),
            None => in_the_middle(h, system, bodies),
        };
        *self.place = bodies.noise.place;
        acted
    }
}

/// Where bodies are after these steps of these stages.
#[cold]
#[inline(never)]
pub(super) fn by_itself<S: Lane, Y: System<S, D>, const D: usize>(
    system: &Y,
    stages: &[Stage],
    stirred: Option<StirredAlone<'_>>,
    steps: OwnSteps,
    places: &[Body<f64, D>],
) -> Result<Moved<D>, Trouble> {
    ByItself { system, stages, stirred, steps, bodies: system.bodies(&in_lanes(places), 0.0) }.run()
}

/// Bodies on these steps of these stages. Work, since lanes have numbers that fuse.
struct ByItself<'a, Y: Parts<S, D>, S: Lane, const D: usize> {
    system: &'a Y,
    stages: &'a [Stage],
    stirred: Option<StirredAlone<'a>>,
    steps: OwnSteps,
    bodies: BodiesOf<Y, S, D>,
}

impl<S: Lane, Y: System<S, D>, const D: usize> Work for ByItself<'_, Y, S, D> {
    type Done = Result<Moved<D>, Trouble>;

    #[inline(always)]
    fn run(self) -> Self::Done {
        let Self { system, stages, mut stirred, steps, mut bodies } = self;
        let OwnSteps { number, parts, checked, .. } = steps;
        let of_whole = stages.len();
        // With random numbers flows act on the whole step, and motion alone is divided.
        let around = parts > 1 && stirred.is_some() && draws(system);
        let inside = stirred.as_ref().is_some_and(|of| of.after > 0);
        let ((stages, time), parts) = match around && inside {
            true => (Stage::parts(&Stage::finer(stages, parts), 1), 1),
            false => (Stage::parts(stages, parts), parts),
        };
        if let Some(of) = &mut stirred
            && around
        {
            of.after *= stages.len() / of_whole;
        }
        let mut step = InParts { system, stages: &stages, parts, around, time, stirred };
        let back = backwards(&stages);
        for taken in 0..number {
            if taken > 0 {
                system.refresh(&mut bodies); // as where a run is divided: bits depend on no division
            }
            if const { Y::FLOWS > 0 }
                && let Some(stirred) = &step.stirred
            {
                stirred.begin(taken, around, system, &mut bodies);
            }
            let start = bodies.saved();
            let mut end = None;
            // The way forth, and the way back if it is checked: in one loop, so that `go` is inlined once.
            loop {
                let led = step.go(&mut bodies);
                if let (Some(end), Some(tolerance)) = (&end, checked) {
                    compare_lane(&start, &bodies, led.is_ok(), tolerance)?;
                    system.put_back(&mut bodies, end);
                    break;
                }
                if let Err(failure) = led {
                    let h = time * f64::from(parts);
                    let coast = |bodies: &mut _| system.coast(h, bodies);
                    return Err(of_a_kink_ahead(system, &start, &mut bodies, failure, coast).into());
                }
                system.check_kinks(&start, &bodies)?;
                if checked.is_none() {
                    break;
                }
                let ended = bodies.saved();
                system.put_back(&mut bodies, &ended); // the way back begins anew
                end = Some(ended);
                (step.stages, step.time) = (&back, -time);
            }
            (step.stages, step.time) = (&stages, time);
            if let Some(stirred) = &mut step.stirred {
                stirred.work += bodies.work.to_f64();
            }
        }
        let work = step.stirred.map_or(bodies.work.to_f64(), |stirred| stirred.work);
        Ok((out_of_lanes(&bodies.all()), work))
    }
}

/// A step of so many parts of these stages; with flows around each, or those that draw around all of them.
struct InParts<'a, Y> {
    system: &'a Y,
    stages: &'a [Stage],
    parts: u32,
    around: bool,
    /// For how long flows act in each part.
    time: f64,
    stirred: Option<StirredAlone<'a>>,
}

impl<'a, Y> InParts<'a, Y> {
    #[inline(always)]
    fn go<S: Lane, const D: usize>(&mut self, bodies: &mut BodiesOf<Y, S, D>) -> Result<(), Failure>
    where
        Y: System<S, D>,
    {
        let Self { system, stages, parts, around, time, .. } = *self;
        let whole = f64::from(parts) * time;
        let inside = if around { Chosen::inside(system) } else { Chosen::All };
        for part in 0..parts {
            let before = (parts > 1).then(|| bodies.saved());
            if around && part == 0 {
                self.act(0, Some((Chosen::Drawing, Half::Before)), whole, bodies)?;
            }
            self.act(0, Some((inside, Half::Before)), time, bodies)?;
            for (i, &Stage { before, h, after }) in stages.iter().enumerate() {
                system.drift(before, h, bodies, &mut ())?;
                if after != 0.0 || stages[(i + 1) % stages.len()].before != 0.0 {
                    system.evaluate_forces(bodies);
                }
                system.settle(after, h, bodies, &mut ())?;
                self.act(i + 1, None, time, bodies)?;
            }
            self.act(0, Some((inside, Half::After)), time, bodies)?;
            if around && part + 1 == parts {
                self.act(0, Some((Chosen::Drawing, Half::After)), whole, bodies)?;
            }
            if let Some(before) = before {
                system.check_kinks(&before, bodies)?;
            }
        }
        Ok(())
    }

    fn act<S: Lane, const D: usize>(
        &mut self,
        of: usize,
        half: Option<(Chosen, Half)>,
        h: f64,
        bodies: &mut BodiesOf<Y, S, D>,
    ) -> Result<(), Failure>
    where
        Y: System<S, D>,
    {
        if const { Y::FLOWS > 0 }
            && let Some(stirred) = self.stirred.as_mut().filter(|stirred| stirred.after == of)
        {
            return stirred.act(half, h, self.system, bodies);
        }
        Ok(())
    }
}

/// Compares bodies in a lane's numbers as they were with what the way back led to.
pub(super) fn compare_lane<N: Count, S: Lane, K, const D: usize>(
    was: &Saved<N, S, D>,
    is: &Bodies<N, S, K, D>,
    led: bool,
    tolerance: f64,
) -> Result<(), Trouble> {
    compare(is.q.as_ref().len(), &|i| [was.body(i).map(S::to_f64), is.body(i).map(S::to_f64)], led, tolerance)
}

/// Why bodies could not be moved from their start: a kink where they would coast, if there is one.
pub(super) fn of_a_kink_ahead<S: Lane, Y: System<S, D>, const D: usize>(
    system: &Y,
    start: &Saved<Y::Count, S, D>,
    bodies: &mut BodiesOf<Y, S, D>,
    failure: Failure,
    coast: impl FnOnce(&mut BodiesOf<Y, S, D>),
) -> Failure {
    if !failure.may_be_of_a_kink() {
        return failure;
    }
    system.put_back(bodies, start);
    coast(bodies);
    kink_ahead(system, start, bodies).unwrap_or(failure)
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
    type Done = Result<(Block<S, L, D, SUMS, EQUAL>, Account), Stuck>;

    #[inline(always)]
    fn run(self) -> Self::Done {
        let Self { lanes: SplittingLanes { block, laws, stages, parts, stirring, account, set, .. }, tour } =
            self;
        let laws = laws.clone(); // out of reach of what the loops write
        let mut desk = Desk::of(block.clone());
        let (mut stirs, mut kept, mut every) = (None, account.clone(), EVERY);
        if const { X::Forces::FLOWS > 0 }
            && let Some(stirring) = stirring
            && let Ok(work) = <&mut [f64; L]>::try_from(&mut kept.work[..])
            && let Ok(limits) = <&mut [f64; L]>::try_from(&mut kept.limits[..])
        {
            stirs = Some(Stirs { stirring, kick: stages[0].before, set: *set, work, limits });
            every = if stirring.is_abrupt() { 1 } else { EVERY };
        }
        let mut striding = Striding { desk: &mut desk, laws: &laws, parts, stirs };
        while let Some(Leg { from, steps, written, shown }) = tour.next() {
            let (mut now, end) = (from, from + steps);
            let mut looks = now == 0 && end > 0;
            // One place where it looks around, since all of that is inlined.
            loop {
                if looks {
                    look_around(&striding.desk.block, &laws, parts, striding.stirs.as_mut(), now)?;
                }
                if now == end {
                    break;
                }
                let stop = end.min((now / every + 1) * every);
                for now in now..stop {
                    striding.stride(now)?;
                }
                now = stop;
                looks = now % every == 0 || (now == end && shown);
            }
            if steps > 0 && (shown || written.is_none()) {
                striding.desk.block.check(&laws, parts)?;
            }
            if let Some(written) = written {
                let (q, p) = striding.desk.block.all(&laws, parts);
                written.fill(L, |lane| at(&q, lane).map(S::to_f64), |lane| at(&p, lane).map(S::to_f64));
            }
        }
        Ok((desk.block, kept))
    }
}

/// A block on its way.
struct Striding<'a, S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool> {
    desk: &'a mut Desk<S, L, D, SUMS, EQUAL>,
    laws: &'a X,
    parts: &'a [Part],
    stirs: Option<Stirs<'a, S, L, D>>,
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>
    Striding<'_, S, X, L, D, SUMS, EQUAL>
where
    S: Lane,
    X: Laws<S, D>,
{
    /// A step of the method, after so many.
    #[inline(always)]
    fn step(&mut self, steps: u64) -> Result<(), Stuck> {
        let Self { desk: Desk { block, scratch, .. }, laws, parts, stirs } = self;
        block.measure_after(steps);
        if const { X::Forces::FLOWS > 0 }
            && let Some(stirs) = stirs
        {
            let rhythm = &stirs.stirring.rhythm;
            return rhythm.step(
                &mut Stepping { block, scratch, laws: *laws, parts, stirs },
                steps,
                parts.len(),
            );
        }
        for _ in 0..if EQUAL { 1 } else { parts.len() } {
            step(block, *laws, parts, scratch)?;
        }
        Ok(())
    }

    /// The same, which leads no lane across a kink.
    #[inline(always)]
    fn stride(&mut self, steps: u64) -> Result<(), Stuck> {
        if const { X::Constraint::KINKS.is_empty() } {
            return self.step(steps);
        }
        let (from, way) = (self.desk.block.q, self.desk.block.way);
        let stepped = self.step(steps);
        let Self { desk, laws, parts, .. } = self;
        if let Err(Stuck { lane, failure }) = stepped {
            let ahead = S::from_f64(parts.iter().map(|part| part.h).sum::<f64>() / parts[0].unit);
            let from = at(&from, lane);
            let to = add_scaled(&from, ahead, &at(&way, lane));
            return kink(*laws, lane, from, to, Err(Stuck { lane, failure }));
        }
        crossings(*laws, &from, &desk.block.q)
    }
}
