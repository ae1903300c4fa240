//! Collocation in lanes.

use crate::effect::list::Forces;
use crate::error::Error;
use crate::kernel::functions::ConstraintKernel;
use crate::motion::affected::Affected;
use crate::motion::bodies::{Body, One, Saved};
use crate::motion::capability::Collocation;
use crate::motion::course::check_energy;
use crate::motion::failure::Failure;
use crate::motion::guarded::Guarded;
use crate::motion::parts::Parts;
use crate::motion::record::{Hallmark, Reading, Record};
use crate::motion::table::Table;
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::Lane;
use crate::number::vector::add_scaled;
use crate::number::vectors::at;
use crate::run::ensemble::around::{ask_around, look_as_far};
use crate::run::ensemble::asked::{Kicking, answered_by_laws, forces, hallmarks};
use crate::run::ensemble::crossing::crossings;
use crate::run::ensemble::engine::{Engine, Leg, Moved, OwnSteps, Stuck, Tour};
use crate::run::ensemble::lane_record::InRows;
use crate::run::ensemble::laws::{Laws, system_of};
use crate::run::ensemble::row::{End, LOOKING, Row, Scratch, Tableau};
use crate::run::ensemble::splitting_lanes::compare_lane;
use crate::run::ensemble::stages::advance;
use crate::run::fingerprint::Looks;
use crate::run::trouble::Trouble;
use crate::solve::crowd::{Asked, EVERY};
use crate::systems::surface::kept::{BodiesOf, OnSurface, OneByOne};
use std::any::Any;
use std::hint::black_box;

/// How often forces are evaluated at a stage of a step, about: for the bill.
const EVALUATIONS: u32 = 5;

/// A row of trajectories, what its lanes obey, and the method.
#[derive(Clone)]
pub(crate) struct CollocationLanes<S, X, const L: usize, const D: usize, const SUMS: usize, const N: usize> {
    row: Row<S, L, D, SUMS, N>,
    laws: X,
    table: &'static Table<N>,
    tableau: Tableau<S, N>,
    h: f64,
    set: Fusing,
}

impl<S: Lane, X: Laws<S, D>, const L: usize, const D: usize, const SUMS: usize, const N: usize>
    CollocationLanes<S, X, L, D, SUMS, N>
{
    /// Lanes, none of them set, that obey these laws by the method with this table and steps of h.
    pub(crate) fn new(laws: X, table: &'static Table<N>, h: f64, set: Fusing) -> Self {
        Self { row: Row::new(), laws, table, tableau: Tableau::of(table, h), h, set }
    }
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize, const N: usize> Engine<D>
    for CollocationLanes<S, X, L, D, SUMS, N>
where
    S: Lane + 'static,
    X: Laws<S, D> + 'static,
{
    fn width(&self) -> usize {
        L
    }

    fn go(&self, tour: &mut dyn Tour<D>) -> Result<Box<dyn Engine<D>>, Vec<Stuck>> {
        let going = Going { lanes: self, tour };
        let row = self.set.run_lanes::<L, _>(going)?;
        let (laws, tableau) = (self.laws.clone(), self.tableau.clone());
        Ok(Box::new(Self { row, laws, tableau, ..*self }))
    }

    fn set(&mut self, lane: usize, bodies: &[Body<f64, D>]) -> bool {
        let holds = self.row.set(lane, &self.laws, &bodies[0].map(S::from_f64));
        holds && self.row.body(lane).p.iter().all(|p| p.to_f64().is_finite())
    }

    fn copy(&mut self, from: usize, to: usize) {
        self.row.copy(from, to);
    }

    fn obey(&mut self, from: usize, to: usize) {
        self.laws.copy(from, to);
    }

    fn obey_as_in(&mut self, engine: &dyn Engine<D>) {
        if let Some(engine) = (engine as &dyn Any).downcast_ref::<Self>() {
            self.laws = engine.laws.clone();
        }
    }

    fn bodies(&self, lane: usize) -> Vec<Body<f64, D>> {
        vec![self.row.body(lane).map(S::to_f64)]
    }

    fn by_itself(
        &self,
        lane: usize,
        bodies: &[Body<f64, D>],
        OwnSteps { number, parts, checked, .. }: OwnSteps,
        _: &mut u64,
    ) -> Result<Moved<D>, Trouble> {
        let Self { laws, table, h, .. } = self;
        let system = system_of(laws, lane);
        let mut bodies = system.bodies(&[bodies[0].map(S::from_f64)], 0.0);
        for _ in 0..number {
            let start = apart(&system, table, *h, parts, &mut bodies, &mut [])?;
            if parts == 1 {
                system.check_sheets(*h, &start, &mut bodies)?;
            }
            if let Some(tolerance) = checked {
                let (end, back) = (bodies.saved(), -h / f64::from(parts));
                system.put_back(&mut bodies, &end); // the way back begins anew
                let mut step =
                    |_| Collocation::collocate(&system, table, back, &mut bodies, &mut [], &mut ());
                let led = (0..parts).try_for_each(&mut step).is_ok();
                compare_lane(&start, &bodies, led, tolerance)?;
                system.put_back(&mut bodies, &end);
            }
        }
        Ok((vec![bodies.body(0).map(S::to_f64)], 0.0))
    }

    fn kick_alone(&self, steps: u32) {
        let kicks = steps * (N as u32 - 1) * EVALUATIONS;
        let kicking = Kicking { q: &self.row.q, way: self.row.p, laws: &self.laws, kicks };
        black_box(self.set.run_lanes::<L, _>(kicking));
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
        Hallmark::of_parameters("method", "a collocation", vec![N as f64, self.h])
    }
}

answered_by_laws!(CollocationLanes, N: usize);

/// Takes a step in so many parts and by itself, with the memory of the last part, if there is room for it. Returns
/// where it began.
#[cold]
#[inline(never)]
fn apart<S, K, F, const D: usize, const N: usize>(
    system: &OnSurface<K, F, One, OneByOne>,
    table: &Table<N>,
    h: f64,
    parts: u32,
    bodies: &mut BodiesOf<One, S, F, D>,
    memory: &mut [S],
) -> Result<Saved<One, S, D>, Failure>
where
    S: Lane,
    K: ConstraintKernel<S, D, 1>,
    F: Forces<S, D>,
{
    let (start, part) = (bodies.saved(), h / f64::from(parts));
    let mut step = |_| {
        let before = bodies.saved();
        Collocation::collocate(system, table, part, bodies, memory, &mut ())?;
        if parts > 1 {
            system.check_kinks(&before, bodies)?;
            system.check_sheets(part, &before, bodies)?;
        }
        check_energy(part, system, &before, bodies)
    };
    if let Err(failure) = (0..parts).try_for_each(&mut step) {
        bodies.q[0] = add_scaled(&start.q[0], S::from_f64(h), &start.p[0]);
        return Err(system.check_kinks(&start, bodies).err().unwrap_or(failure)); // that, if there is one ahead
    }
    system.check_kinks(&start, bodies)?;
    Ok(start)
}

/// A row on a tour.
struct Going<'a, S, X, const L: usize, const D: usize, const SUMS: usize, const N: usize> {
    lanes: &'a CollocationLanes<S, X, L, D, SUMS, N>,
    tour: &'a mut dyn Tour<D>,
}

/// What a thread works on, at a place of the same kind each time.
#[repr(C, align(4096))]
struct Desk<S, const L: usize, const D: usize, const SUMS: usize, const N: usize> {
    row: Row<S, L, D, SUMS, N>,
    scratch: Scratch<S, L, D, N>,
}

impl<S: Lane, X: Laws<S, D>, const L: usize, const D: usize, const SUMS: usize, const N: usize> Work
    for Going<'_, S, X, L, D, SUMS, N>
{
    type Done = Result<Row<S, L, D, SUMS, N>, Stuck>;

    #[inline(always)]
    fn run(self) -> Self::Done {
        let Self { lanes: CollocationLanes { row, laws, table, tableau, h, .. }, tour } = self;
        let (laws, tableau) = (laws.clone(), tableau.clone()); // out of reach of what the loops write
        let mut desk = Desk { row: row.clone(), scratch: Scratch::new() };
        let Desk { row, scratch } = &mut desk;
        while let Some(Leg { from, steps, written, shown }) = tour.next() {
            let end = from + steps;
            for now in from + 1..=end {
                if !advance(row, &laws, &tableau, scratch) {
                    let Scratch { going, end: there, .. } = &mut *scratch;
                    for (lane, &going) in
                        going.iter().enumerate().filter(|&(_, &going)| going != S::default())
                    {
                        if going != S::from_f64(LOOKING) {
                            move_apart(row, lane, &laws, table, *h, now, there)?;
                        }
                        let place = [&there.q, &there.p, &there.normal, &there.total];
                        ask_around(&laws, lane, place, there.strays[lane], &mut row.asked[lane])?;
                    }
                }
                if const { !X::Constraint::KINKS.is_empty() } {
                    crossings(&laws, &row.q, &scratch.end.q)?;
                }
                row.take(&scratch.end);
                if now % EVERY == 0 || (shown && now == end) {
                    let Row { q, p, normal, total, asked, astray, .. } = &mut *row;
                    look_as_far(&laws, now, [q, p, normal, &total[N - 1]], asked, astray)?;
                }
            }
            if let Some(written) = written {
                let (q, p) = (&row.q, &row.p);
                written.fill(L, |lane| at(q, lane).map(S::to_f64), |lane| at(p, lane).map(S::to_f64));
            }
        }
        Ok(desk.row)
    }
}

/// Finds where the step leads a lane that cannot go with the others.
#[cold]
#[inline(never)]
fn move_apart<S: Lane, const L: usize, const D: usize, const SUMS: usize, const N: usize>(
    row: &mut Row<S, L, D, SUMS, N>,
    lane: usize,
    laws: &impl Laws<S, D>,
    table: &Table<N>,
    h: f64,
    number: u64,
    end: &mut End<S, L, D>,
) -> Result<(), Stuck> {
    let system = system_of(laws, lane);
    let mut memory = vec![S::default(); 1 + N * (D + 1)];
    let mut bodies = system.bodies(&[row.body(lane)], 0.0);
    bodies.kept.crowd.asked = Asked { steps: number, reach: row.asked[lane].to_f64(), near: false };
    let stuck = |failure| Stuck { lane, failure: Some(failure) };
    let start = apart(&system, table, h, 1, &mut bodies, &mut memory).map_err(stuck)?;
    if !row.land(lane, laws, S::from_f64(h), &bodies.body(0), &memory, end) {
        system.check_sheets(h, &start, &mut bodies).map_err(stuck)?;
    }
    if bodies.kept.crowd.asked.near { Err(Stuck { lane, failure: None }) } else { Ok(()) }
}
