//! Methods whose steps are [projected](crate::run::ensemble::projected) onto the constraint, in lanes.

use crate::error::Error;
use crate::motion::bodies::Body;
use crate::motion::failure::Failure;
use crate::motion::guarded::Guarded;
use crate::motion::method::Method;
use crate::motion::parts::Parts;
use crate::motion::record::{Hallmark, Reading, Record};
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::Lane;
use crate::number::vector::{add_scaled, largest, sum};
use crate::number::vectors::at;
use crate::run::ensemble::around::{ask_around, look_as_far};
use crate::run::ensemble::asked::{Kicking, answered_by_laws, forces, hallmarks};
use crate::run::ensemble::engine::{Engine, Leg, Moved, OwnSteps, Stuck, Tour};
use crate::run::ensemble::lane_record::{InRows, of_projected};
use crate::run::ensemble::laws::{Laws, system_of};
use crate::run::ensemble::projected::{Projects, advance};
use crate::run::ensemble::projected_row::{Row, Scratch};
use crate::run::ensemble::row::LOOKING;
use crate::run::fingerprint::Looks;
use crate::run::trouble::Trouble;
use crate::solve::crowd::{Asked, EVERY};
use std::any::Any;
use std::hint::black_box;

/// A row of trajectories, what its lanes obey, and the method.
#[derive(Clone)]
pub(crate) struct ProjectedLanes<S, X, const L: usize, const D: usize, const SUMS: usize, M> {
    row: Row<S, L, D>,
    laws: X,
    method: M,
    h: f64,
    set: Fusing,
}

impl<S: Lane, X, const L: usize, const D: usize, const SUMS: usize, M: Projects<S, L, D>>
    ProjectedLanes<S, X, L, D, SUMS, M>
{
    /// Lanes, none of them set, that obey these laws by this method.
    pub(crate) fn new(laws: X, method: M, set: Fusing) -> Self {
        let h = method.method().step_size();
        Self { row: Row::new(), laws, method, h, set }
    }
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize, M> ProjectedLanes<S, X, L, D, SUMS, M>
where
    S: Lane,
    X: Laws<S, D>,
    M: Projects<S, L, D>,
{
    /// Where a body that obeys what a lane does is after steps in so many parts, each of them looked at as in a
    /// simulation; how far around it was looked before and after. Other sheets may be near.
    #[cold]
    #[inline(never)]
    fn alone(
        &self,
        laws: &X,
        lane: usize,
        body: &Body<S, D>,
        [from, steps]: [u64; 2],
        parts: u32,
        reach: f64,
    ) -> Result<(Body<S, D>, bool), Failure> {
        let system = system_of(laws, lane);
        let mut bodies = system.bodies(&[*body], 0.0);
        bodies.kept.crowd.asked = Asked { steps: from, reach, near: false };
        for _ in 0..steps {
            let start = bodies.saved();
            if let Err(failure) = self.method.by_itself(&system, parts, &mut bodies) {
                bodies.q[0] = add_scaled(&start.q[0], S::from_f64(self.h), &start.p[0]);
                return Err(system.check_kinks(&start, &bodies).err().unwrap_or(failure)); // that, if there is one ahead
            }
        }
        Ok((bodies.body(0), bodies.kept.crowd.asked.near))
    }
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize, M> Engine<D>
    for ProjectedLanes<S, X, L, D, SUMS, M>
where
    S: Lane + 'static,
    X: Laws<S, D> + 'static,
    M: Projects<S, L, D>,
{
    fn width(&self) -> usize {
        L
    }

    fn go(&self, tour: &mut dyn Tour<D>) -> Result<Box<dyn Engine<D>>, Vec<Stuck>> {
        let row = self.set.run(Going { lanes: self, tour })?;
        Ok(Box::new(Self { row, laws: self.laws.clone(), method: self.method.clone(), ..*self }))
    }

    fn set(&mut self, lane: usize, bodies: &[Body<f64, D>]) -> bool {
        let Row { place, asked, astray } = &mut self.row;
        (asked[lane], astray[lane]) = (S::default(), S::default());
        place.set::<SUMS>(lane, &self.laws, &bodies[0].map(S::from_f64))
    }

    fn copy(&mut self, from: usize, to: usize) {
        self.row.copy(from, to);
    }

    fn obey(&mut self, from: usize, to: usize) {
        self.laws.copy(from, to);
        self.method.obey(from, to);
    }

    fn obey_as_in(&mut self, engine: &dyn Engine<D>) {
        if let Some(engine) = (engine as &dyn Any).downcast_ref::<Self>() {
            (self.laws, self.method) = (engine.laws.clone(), engine.method.clone());
        }
    }

    fn bodies(&self, lane: usize) -> Vec<Body<f64, D>> {
        vec![self.row.place.body(lane).map(S::to_f64)]
    }

    fn by_itself(
        &self,
        lane: usize,
        bodies: &[Body<f64, D>],
        OwnSteps { number, parts, .. }: OwnSteps,
        _: &mut u64,
    ) -> Result<Moved<D>, Trouble> {
        let body = bodies[0].map(S::from_f64);
        let (body, _) = self.alone(&self.laws, lane, &body, [0, number], parts, 0.0)?;
        Ok((vec![body.map(S::to_f64)], 0.0))
    }

    fn kick_alone(&self, steps: u32) {
        let (q, way) = (&self.row.place.q, self.row.place.p);
        let kicks = steps * self.method.evaluations();
        black_box(self.set.run(Kicking { q, way, laws: &self.laws, kicks }));
    }

    fn forces(&self) -> Vec<&'static str> {
        forces(&self.laws)
    }

    fn record(&self, to: &mut Record) {
        self.row.record(to);
    }

    fn recalled(&self, from: &mut Reading<'_>) -> Result<Box<dyn Engine<D>>, Error> {
        Ok(Box::new(Self { row: Row::new().recalled(from)?, ..self.clone() }))
    }

    fn hallmarks(&self, lane: usize, looks: &Looks<D>) -> Vec<Hallmark> {
        hallmarks::<S, X, D, SUMS>(&self.laws, lane, looks)
    }

    fn method(&self) -> Hallmark {
        of_projected(self.method.method())
    }
}

answered_by_laws!(ProjectedLanes, type M);

/// A row on a tour.
struct Going<'a, S, X, const L: usize, const D: usize, const SUMS: usize, M> {
    lanes: &'a ProjectedLanes<S, X, L, D, SUMS, M>,
    tour: &'a mut dyn Tour<D>,
}

/// What a thread works on, at a place of the same kind each time.
#[repr(C, align(4096))]
struct Desk<S, R, const L: usize, const D: usize> {
    row: Row<S, L, D>,
    scratch: Scratch<S, R, L, D>,
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize, M> Work for Going<'_, S, X, L, D, SUMS, M>
where
    S: Lane,
    X: Laws<S, D>,
    M: Projects<S, L, D>,
{
    type Done = Result<Row<S, L, D>, Vec<Stuck>>;

    #[inline(always)]
    fn run(self) -> Self::Done {
        let Self { lanes, tour } = self;
        let mut copy_of = [0; L];
        copy_of.iter_mut().enumerate().for_each(|(lane, of)| *of = tour.copy_of(lane));
        let (laws, h) = (lanes.laws.clone(), S::from_f64(lanes.h)); // out of reach of what the loops write
        let mut desk = Desk { row: lanes.row.clone(), scratch: Scratch::new(lanes.method.room()) };
        let Desk { row, scratch } = &mut desk;
        while let Some(Leg { from, steps, written, shown }) = tour.next() {
            let end = from + steps;
            for now in from + 1..=end {
                if !advance::<S, M, L, D, SUMS>(row, &laws, &lanes.method, h, scratch) {
                    all_apart(lanes, &laws, now, &copy_of, row, scratch)?;
                }
                row.place = scratch.now;
                for l in 0..L {
                    row.astray[l] = row.astray[l].max(scratch.strays[l]);
                }
                if now % EVERY == 0 || (shown && now == end) {
                    let Row { place, asked, astray } = &mut *row;
                    look_as_far(&laws, now, place.vectors(), asked, astray)?;
                }
            }
            if let Some(written) = written {
                let (q, p) = (&row.place.q, &row.place.p);
                written.fill(L, |lane| at(q, lane).map(S::to_f64), |lane| at(p, lane).map(S::to_f64));
            }
        }
        Ok(desk.row)
    }
}

/// Finds where the step leads lanes that cannot go with the others; copies are where those are that they are copies of.
/// All that cannot are told of at once: each is left out before this is tried again.
#[cold]
#[inline(never)]
fn all_apart<S, X, const L: usize, const D: usize, const SUMS: usize, M>(
    lanes: &ProjectedLanes<S, X, L, D, SUMS, M>,
    laws: &X,
    number: u64,
    copy_of: &[usize; L],
    row: &mut Row<S, L, D>,
    scratch: &mut Scratch<S, M::Room, L, D>,
) -> Result<(), Vec<Stuck>>
where
    S: Lane,
    X: Laws<S, D>,
    M: Projects<S, L, D>,
{
    let mut stuck = Vec::new();
    for of in (0..L).filter(|&of| copy_of[of] == of) {
        match apart(lanes, laws, number, of, row, scratch) {
            Ok(()) => (0..L).filter(|&lane| copy_of[lane] == of).for_each(|lane| {
                scratch.now.copy(of, lane);
                (scratch.strays[lane], row.asked[lane]) = (scratch.strays[of], row.asked[of]);
            }),
            Err(why) => stuck.push(why),
        }
    }
    if stuck.is_empty() { Ok(()) } else { Err(stuck) }
}

/// Finds where the step leads a lane that cannot go with the others, or has to look around first; nothing else.
fn apart<S, X, const L: usize, const D: usize, const SUMS: usize, M>(
    lanes: &ProjectedLanes<S, X, L, D, SUMS, M>,
    laws: &X,
    number: u64,
    lane: usize,
    row: &mut Row<S, L, D>,
    scratch: &mut Scratch<S, M::Room, L, D>,
) -> Result<(), Stuck>
where
    S: Lane,
    X: Laws<S, D>,
    M: Projects<S, L, D>,
{
    let Scratch { now, strays, going, .. } = scratch;
    if S::default().le(going[lane]) {
        return Ok(());
    }
    if going[lane] != S::from_f64(LOOKING) {
        let (body, reach) = (row.place.body(lane), row.asked[lane].to_f64());
        let stuck = |failure| Stuck { lane, failure };
        let alone = lanes.alone(laws, lane, &body, [number, 1], 1, reach);
        let (body, near) = alone.map_err(|failure| stuck(Some(failure)))?;
        if near || !now.set::<SUMS>(lane, laws, &body) {
            return Err(stuck(None));
        }
        let start = row.place.body(lane);
        let way = add_scaled(&body.q, S::from_f64(-1.0), &start.q);
        let path = sum(&start.p, &body.p);
        strays[lane] = largest(&add_scaled(&way, S::from_f64(-0.5 * lanes.h), &path));
    }
    ask_around(laws, lane, now.vectors(), strays[lane], &mut row.asked[lane])
}
