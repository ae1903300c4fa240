//! Linked bodies in lanes.

use crate::effect::list::Forces;
use crate::error::Error;
use crate::motion::bodies::{Body, Many};
use crate::motion::parts::Parts;
use crate::motion::record::{Hallmark, Reading, Record};
use crate::motion::system::System;
use crate::motion::witness::Whoever;
use crate::number::lanes::Fused;
use crate::run::answers::{Obeying, forces};
use crate::run::ensemble::block::Part;
use crate::run::ensemble::by_itself::{placed, split};
use crate::run::ensemble::engine::{Draws, Engine, Leg, Moved, OwnSteps, Stuck, Tour};
use crate::run::ensemble::forces_in_lanes::Pulling;
use crate::run::ensemble::lane_record::{read_all, write_all};
use crate::run::ensemble::linked_going::{Steps, Velocities, Wide, Width};
use crate::run::ensemble::linked_law::{Heard, Law, LinkedLaws, Narrow, answer, gradients};
use crate::run::ensemble::linked_plan::{LinkedPlan, Places};
use crate::run::ensemble::linked_row::{Course, LinkedRow, at_rest};
use crate::run::ensemble::linked_stirred::StirredSteps;
use crate::run::ensemble::linked_stirring::RowStirring;
use crate::run::ensemble::splits::Splits;
use crate::run::ensemble::stirred::LARGER;
use crate::run::fingerprint::{Looks, of_lane};
use crate::run::trouble::Trouble;
use crate::systems::linked::Linked;
use crate::systems::linked::kept::BodiesOf;
use crate::systems::network::in_lanes::{Numbers, zeros};
use std::any::Any;
use std::array::from_fn;
use std::hint::black_box;
use std::sync::Arc;

/// What all rows of an ensemble have in common.
pub(super) struct Common {
    plan: LinkedPlan,
    method: Splits,
}

/// By so many roundings of places a step leads off where bodies rest: g of a start is zero to a few.
const ROUNDINGS: f64 = 16.0;

/// A row of trajectories of linked bodies, moved by a splitting.
#[derive(Clone)]
pub(super) struct LinkedLanes<F, const D: usize, const W: usize> {
    common: Arc<Common>,
    obeyed: Arc<LinkedLaws<F, D, W>>,
    /// Number by number, as the [`LinkedPlan`] lays them out.
    numbers: Vec<Numbers<W>>,
    /// The part of the method's step that comes next.
    part: usize,
    account: Account,
    /// By lane what answers for bodies that go by themselves since links nearly depend on each other.
    narrow: Vec<Narrow<F, D>>,
}

/// What is kept of each lane where flows act, or momenta are drawn anew; empty otherwise.
#[derive(Clone, Default)]
struct Account {
    /// The work of flows; empty without flows.
    work: Vec<f64>,
    /// The speed beyond which it is asked at once whether other sheets are near.
    limits: Vec<f64>,
}

impl<F: Forces<f64, D>, const D: usize, const W: usize> LinkedLanes<F, D, W> {
    /// Lanes, none of them set, of what is obeyed there.
    pub(super) fn new((plan, mut obeyed): (LinkedPlan, LinkedLaws<F, D, W>), method: Splits) -> Self {
        obeyed.stirring = RowStirring::of(|lane| obeyed.law(lane).shown(), &method);
        let (numbers, mut account) = (vec![zeros(); plan.places.kept], Account::default());
        if obeyed.stirring.is_some() {
            account.limits = vec![0.0; W];
        }
        if const { F::FLOWS > 0 } {
            account.work = vec![0.0; W];
        }
        Self {
            common: Arc::new(Common { plan, method }),
            obeyed: Arc::new(obeyed),
            numbers,
            part: 0,
            account,
            narrow: vec![None; W],
        }
    }
}

impl<F: Forces<f64, D>, const D: usize, const W: usize> LinkedLanes<F, D, W>
where
    Width: Wide<W>,
{
    /// All numbers, with room for those of one step.
    fn with_room(&self) -> Vec<Numbers<W>> {
        let mut numbers = self.numbers.clone();
        numbers.resize(self.common.plan.places.end, zeros());
        numbers
    }

    /// Bodies of a lane, with these places of the numbers of velocities, times the unit of a part.
    fn bodies_of(&self, numbers: &[Numbers<W>], lane: usize, [way, low]: [usize; 2]) -> Vec<Body<f64, D>> {
        let unit = self.common.method.parts[self.part].unit;
        bodies_of(&self.common, &self.law(lane).masses, numbers, lane, [way, low], unit)
    }

    /// Writes velocities and what rounding took from them; returns where.
    fn velocities(&self, numbers: &mut [Numbers<W>], part: usize) -> [usize; 2] {
        let mut pulling = self.obeyed.pulls.as_ref().map(|pulls| pulls.begin());
        let pulling = pulling.as_deref_mut().map(|pulling| pulling as &mut dyn Pulling<LinkedRow, W>);
        let course = self.course();
        Width::look(Velocities { course: &course, pulling, numbers, part });
        let Places { free, change, .. } = self.common.plan.places;
        [free, change]
    }
}

impl<F, const D: usize, const W: usize> LinkedLanes<F, D, W> {
    /// What a lane obeys.
    fn law(&self, lane: usize) -> &Law<F, D> {
        self.obeyed.law(lane)
    }

    fn course(&self) -> Course<'_, W> {
        let Common { plan, method: Splits { parts, equal, sums, set, .. } } = &*self.common;
        let LinkedLaws { links, over, .. } = &*self.obeyed;
        Course { plan, links, over: over.as_deref(), parts, equal: *equal, sums: *sums, set: *set }
    }
}

/// Bodies of a lane; low digits of momenta only where sums are compensated.
#[inline(never)]
pub(super) fn bodies_of<const D: usize, const W: usize>(
    Common { plan, method: Splits { sums, .. } }: &Common,
    masses: &[[f64; 2]],
    numbers: &[Numbers<W>],
    lane: usize,
    [way, low]: [usize; 2],
    unit: f64,
) -> Vec<Body<f64, D>> {
    let Places { q, q_low, .. } = plan.places;
    let vector = |from: usize, body: usize| from_fn(|d| numbers[from + body * D + d].0[lane].0);
    let momentum = |from: usize, body: usize| -> [f64; D] {
        let way: [f64; D] = vector(from, body);
        from_fn(|d| masses[body * D + d][0] * (way[d] / unit))
    };
    let body = |body| Body {
        q: vector(q, body),
        q_low: if *sums { vector(q_low, body) } else { [0.0; D] },
        p: momentum(way, body),
        p_low: if *sums { momentum(low, body) } else { [0.0; D] },
    };
    (0..plan.coordinates / D).map(body).collect()
}

/// Λ of a part of a step that a lane takes by itself.
#[cold]
#[inline(never)]
fn go_apart<F: Forces<f64, D>, const D: usize, const W: usize>(
    common: &Common,
    law: &Law<F, D>,
    lane: usize,
    part: &Part,
    numbers: &[Numbers<W>],
    room: &mut Option<BodiesOf<F, Many, D>>,
) -> Result<Vec<f64>, Stuck> {
    let (plan, Law { system, masses, .. }) = (&common.plan, law);
    let Places { way, way_low, .. } = plan.places;
    let places = bodies_of(common, masses, numbers, lane, [way, way_low], part.unit);
    let bodies = placed(&*law.system, &places, room);
    let mut heard = Heard::of(&**system);
    let stuck = |failure| Stuck { lane, failure: Some(failure) };
    system.settle(0.0, part.h, bodies, &mut Whoever(&mut heard)).map_err(stuck)?;
    system.drift(0.0, part.h, bodies, &mut Whoever(&mut heard)).map_err(stuck)?;
    // What the way leads off the constraints Λ puts back.
    let [drift, settle] = &heard.multipliers;
    let multiplier = |&i: &usize| 0.5 * part.h * part.h * (drift[i] + settle[i]);
    Ok(plan.equation.iter().map(multiplier).collect())
}

impl<F: Forces<f64, D>, const D: usize, const W: usize> Engine<D> for LinkedLanes<F, D, W>
where
    Width: Wide<W>,
{
    fn width(&self) -> usize {
        W
    }

    fn divides(&self) -> bool {
        self.common.method.renewal.is_none()
    }

    fn bodies_of_each(&self) -> usize {
        self.common.plan.coordinates / D
    }

    fn go(&self, tour: &mut dyn Tour<D>) -> Result<Box<dyn Engine<D>>, Vec<Stuck>> {
        let common = &*self.common;
        let mut numbers = self.with_room();
        let mut part = self.part;
        let mut room = self.obeyed.pulls.as_ref().map(|pulls| pulls.begin());
        let course = self.course();
        let mut bodies: Vec<_> = self.obeyed.laws.iter().map(|_| None).collect();
        let mut apart = |lane: usize, part: &Part, numbers: &[Numbers<W>]| {
            let law = self.obeyed.number_of_law(lane);
            go_apart(common, &self.obeyed.laws[law], lane, part, numbers, &mut bodies[law])
        };
        let (n, mut account) = (self.bodies_of_each(), self.account.clone());
        let freedom = common.plan.moving.len().saturating_sub(common.plan.equations);
        while let Some(Leg { from, steps, written, shown }) = tour.next() {
            let pulling = room.as_deref_mut().map(|pulling| pulling as &mut dyn Pulling<LinkedRow, W>);
            if let Some(stirring) = &self.obeyed.stirring {
                Width::stir(StirredSteps {
                    course: &course,
                    stirring,
                    kick: common.method.stirred_kick,
                    pulling,
                    apart: &mut apart,
                    answer: &mut |question, changes| {
                        if const { F::FLOWS > 0 } {
                            answer(|lane| self.law(lane), freedom, stirring, question, changes);
                        }
                    },
                    numbers: &mut numbers,
                    work: &mut account.work,
                    limits: &mut account.limits,
                    from,
                    steps,
                    looks: shown,
                })?;
            } else {
                Width::go(Steps {
                    course: &course,
                    pulling,
                    apart: &mut apart,
                    numbers: &mut numbers,
                    part: &mut part,
                    from,
                    steps,
                    looks: shown,
                })?;
            }
            if let Some(written) = written {
                let mut now = numbers.clone();
                let way = self.velocities(&mut now, part);
                let bodies = (0..W).flat_map(|lane| self.bodies_of(&now, lane, way)).collect::<Vec<_>>();
                written.fill(W * n, |i| bodies[i].q, |i| bodies[i].p);
            }
        }
        numbers.truncate(common.plan.places.kept);
        Ok(Box::new(Self {
            common: self.common.clone(),
            obeyed: self.obeyed.clone(),
            numbers,
            part,
            account,
            narrow: self.narrow.clone(),
        }))
    }

    fn set(&mut self, lane: usize, bodies: &[Body<f64, D>]) -> bool {
        let law = self.law(lane).clone();
        let (system, common) = (&*law.system, self.common.clone());
        let Common { plan, method: Splits { parts, equal, sums, h, renewal, .. } } = &*common;
        let Places { q, q_low, way, way_low, lifted, guess, last, earlier, square, rest, .. } = plan.places;
        let part = &parts[self.part];
        let mut ahead = system.bodies(bodies, 0.0);
        // Momenta of a start are nothing to a step that draws others.
        let still = |body: &Body<f64, D>| Body { p: [0.0; D], p_low: [0.0; D], ..*body };
        let resting: Vec<_> = bodies.iter().filter(|_| renewal.is_some()).map(still).collect();
        let bodies = if renewal.is_some() { &resting } else { bodies };
        let (plain, narrow) = law.is_plain(plan, (&ahead, bodies), *h);
        self.narrow[lane] = narrow;
        let mut heard = Heard::of(system);
        let settled = system.settle(part.lead, part.h, &mut ahead, &mut ());
        let places = ahead.all();
        let entries = gradients(system, &ahead.q);
        let drifted = settled.and_then(|()| system.drift(0.0, part.h, &mut ahead, &mut Whoever(&mut heard)));
        let multipliers = plan.equation.iter().map(|&i| 0.5 * part.h * part.h * heard.multipliers[0][i]);
        let multipliers: Vec<_> = multipliers.collect();

        let mut put = |place: usize, x: f64| self.numbers[place].0[lane] = Fused(x);
        let share = Part::longest(parts);
        let coordinates = places.iter().flat_map(|body| (0..D).map(move |d| (body, d)));
        let (mut path, mut longest, mut off, mut sizes) =
            (0.0_f64, 0.0_f64, 0.0_f64, vec![0.0; plan.coordinates]);
        let mut back = vec![0.0; plan.coordinates];
        let (mut squares, mut lengths, mut reaches) =
            (vec![0.0; plan.equations], vec![0.0_f64; plan.equations], vec![0.0_f64; plan.equations]);
        for (entry, (&[c, i], &x)) in plan.of_entry.iter().zip(&entries).enumerate() {
            let over = law.masses[c][1];
            put(lifted + entry, over * x);
            back[c] += over * x * multipliers[i];
            squares[i] += over * x * x;
            lengths[i] = lengths[i].max(x.abs());
        }
        for (c, (body, d)) in coordinates.enumerate() {
            let over = law.masses[c][1];
            let h = part.unit * over;
            // Equal steps: as if one had led here, which would have left half of Λ in the way.
            let left = if *equal { back[c] } else { 0.0 };
            put(q + c, body.q[d]);
            put(way + c, h * body.p[d] - left);
            if *sums {
                put(q_low + c, body.q_low[d]);
                put(way_low + c, h * body.p_low[d]);
            }
            path = path.max((part.h * over * body.p[d]).abs());
            off = off.max(back[c].abs());
            let way = share * (h * body.p[d] - left).abs();
            (longest, sizes[c]) = (longest.max(way), body.q[d].abs().max(way));
        }
        let mut along = vec![0.0; plan.equations];
        for (&[c, i], x) in plan.of_entry.iter().zip(&entries) {
            reaches[i] = reaches[i].max(sizes[c]);
            along[i] += x.abs() * sizes[c];
        }
        for i in 0..plan.equations {
            let first = if *equal { 2.0 * multipliers[i] } else { multipliers[i] };
            put(guess + i, first);
            put(last + i, part.before * first);
            put(earlier + i, part.before * first);
            put(square + i, squares[i]);
            put(rest + i, at_rest(Fused(along[i]), Fused(longest), Fused(lengths[i]), Fused(reaches[i])).0);
        }
        if const { F::FLOWS > 0 } {
            self.book(lane, self.account.work[lane]);
        } else if let Some(limit) = self.account.limits.get_mut(lane) {
            *limit = 0.0;
        }
        // Farther off than twice the path is another root, unless at rest, where rounding alone leads off.
        let largest = sizes.iter().fold(0.0_f64, |most, &x| most.max(x));
        let near = off <= 2.0 * path + ROUNDINGS * f64::EPSILON * largest;
        let goes = renewal.is_some() || (drifted.is_ok() && path.is_finite() && near);
        goes && plain
    }

    fn copy(&mut self, from: usize, to: usize) {
        self.numbers.iter_mut().for_each(|numbers| numbers.0[to] = numbers.0[from]);
        self.narrow[to] = self.narrow[from].clone();
        let Account { work, limits } = &mut self.account;
        [work, limits].into_iter().filter(|of| !of.is_empty()).for_each(|of| of[to] = of[from]);
    }

    fn obey(&mut self, from: usize, to: usize) {
        if !self.obeyed.alike() {
            Arc::make_mut(&mut self.obeyed).copy(from, to);
        }
    }

    fn obey_as_in(&mut self, engine: &dyn Engine<D>) {
        if let Some(Self { obeyed, .. }) = (engine as &dyn Any).downcast_ref() {
            self.obeyed = obeyed.clone();
        }
    }

    fn draw_as(&mut self, lane: usize, draws: Draws) {
        if self.obeyed.stirring.is_some()
            && let Some(stirring) = &mut Arc::make_mut(&mut self.obeyed).stirring
        {
            stirring.rhythm.draw_as(lane, draws);
        }
    }

    fn work(&self, lane: usize) -> Option<f64> {
        self.account.work.get(lane).copied()
    }

    fn book(&mut self, lane: usize, work: f64) {
        if const { F::FLOWS > 0 } {
            let LinkedPlan { places: Places { way, .. }, coordinates, .. } = self.common.plan;
            let ways = self.numbers[way..way + coordinates].iter();
            let fastest = ways.map(|x| x.0[lane].0.abs()).fold(0.0, f64::max);
            (self.account.work[lane], self.account.limits[lane]) = (work, LARGER * fastest);
        }
    }

    fn bodies(&self, lane: usize) -> Vec<Body<f64, D>> {
        let mut now = self.with_room();
        let way = self.velocities(&mut now, self.part);
        self.bodies_of(&now, lane, way)
    }

    fn by_itself(
        &self,
        lane: usize,
        bodies: &[Body<f64, D>],
        steps: OwnSteps,
        place: &mut u64,
    ) -> Result<Moved<D>, Trouble> {
        let law = self.law(lane);
        let ready = law.ready(bodies, self.common.method.h);
        let system = ready.as_ref().unwrap_or(&law.system);
        let rhythm = self.obeyed.stirring.as_ref().map(|stirring| &stirring.rhythm);
        let lane = (lane, self.work(lane));
        split(system, &self.common.method, rhythm, lane, bodies, steps, place)
    }

    fn kick_alone(&self, steps: u32) {
        let Some(pulls) = &self.obeyed.pulls else { return };
        let Common { plan, method: Splits { parts, set, .. } } = &*self.common;
        let (mut pulling, n) = (pulls.begin(), plan.coordinates);
        let mut kicked = vec![zeros(); n];
        for _ in 0..steps * parts.len() as u32 {
            let q = &self.numbers[plan.places.q..plan.places.q + n];
            pulling.pull(*set, 1e-9, (black_box(q), &plan.masses, &mut kicked));
        }
        black_box(kicked);
    }

    fn forces(&self) -> Vec<&'static str> {
        forces(self.system(0), &self.bodies(0))
    }

    fn record(&self, to: &mut Record) {
        write_all(&mut self.numbers.iter(), to);
        to.counts("part", [self.part as u64]);
        if const { F::FLOWS > 0 } {
            to.list("work", &self.account.work);
        }
        if self.obeyed.stirring.is_some() {
            to.list("speed to ask at", &self.account.limits);
        }
    }

    fn recalled(&self, from: &mut Reading<'_>) -> Result<Box<dyn Engine<D>>, Error> {
        let mut again = self.clone();
        read_all(&mut again.numbers.iter_mut(), from)?;
        let [part] = from.counted("part")?;
        again.part = part as usize % self.common.method.parts.len();
        if const { F::FLOWS > 0 } {
            again.account.work = from.numbers("work", &[W])?.to_vec();
        }
        if self.obeyed.stirring.is_some() {
            again.account.limits = from.numbers("speed to ask at", &[W])?.to_vec();
        }
        Ok(Box::new(again))
    }

    fn hallmarks(&self, lane: usize, looks: &Looks<D>) -> Vec<Hallmark> {
        of_lane(self.system(lane), looks, self.step_size())
    }

    fn method(&self) -> Hallmark {
        self.common.method.hallmark()
    }
}

impl<F: Forces<f64, D>, const D: usize, const W: usize> Obeying<D> for LinkedLanes<F, D, W> {
    type System = Linked<F, Many, D>;

    fn system(&self, lane: usize) -> &Self::System {
        self.narrow[lane].as_ref().unwrap_or(&self.law(lane).system)
    }

    fn step_size(&self) -> f64 {
        self.common.method.h
    }
}
