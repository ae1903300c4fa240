//! Linked bodies in lanes, by steps that are [projected](crate::run::ensemble::linked_projected) onto their
//! constraints.

use crate::effect::list::Forces;
use crate::error::Error;
use crate::methods::dop853::Dop853;
use crate::methods::dop853_table::STAGES;
use crate::methods::lobatto::Lobatto;
use crate::methods::taylor::Taylor;
use crate::motion::bodies::{Body, Many};
use crate::motion::method::{Method, View};
use crate::motion::need::Need;
use crate::motion::parts::Parts;
use crate::motion::record::{Hallmark, Reading, Record};
use crate::motion::table::{Table, Tabulated};
use crate::number::instructions::Fusing;
use crate::number::lanes::Fused;
use crate::run::answers::{Obeying, forces};
use crate::run::ensemble::by_itself::{self, prepared};
use crate::run::ensemble::dop853_row::Stages;
use crate::run::ensemble::engine::{Engine, Leg, Moved, OwnSteps, Stuck, Tour};
use crate::run::ensemble::forces_in_lanes::Pulling;
use crate::run::ensemble::lane_record::{of_projected, read_all, write_all};
use crate::run::ensemble::linked_collocation::{self as collocation, Coefficients, Collocation};
use crate::run::ensemble::linked_going::{Wide, Width};
use crate::run::ensemble::linked_law::{Law, LinkedLaws, Narrow};
use crate::run::ensemble::linked_plan::LinkedPlan;
use crate::run::ensemble::linked_projected::{Desk, ProjectedSteps};
use crate::run::ensemble::linked_projected_row::{Kept, Landed, forget};
use crate::run::ensemble::linked_row::{Course, LinkedRow};
use crate::run::ensemble::linked_series::Few;
use crate::run::ensemble::linked_series_law::SeriesLaws;
use crate::run::ensemble::linked_stand::{Departs, Stand};
use crate::run::ensemble::taylor_row::Expansion;
use crate::run::fingerprint::{Looks, of_lane};
use crate::run::trouble::Trouble;
use crate::solve::crowd::Asked;
use crate::systems::linked::Linked;
use crate::systems::linked::kept::BodiesOf;
use crate::systems::network::in_lanes::{Numbers, zeros};
use std::any::Any;
use std::array::from_fn;
use std::hint::black_box;
use std::sync::Arc;

/// A method whose steps are projected, for rows of linked bodies.
pub(super) trait ProjectsLinks: Clone + Send + Sync + 'static {
    /// The method itself.
    type Method: Method;

    /// The method, as simulations have it.
    fn method(&self) -> &Self::Method;
    /// How often an inner step evaluates forces.
    fn evaluations(&self) -> u32;
    /// How many numbers of a lane it remembers from step to step.
    fn remembers(&self, _: &LinkedPlan) -> usize {
        0
    }
    /// What finds where inner steps lead, of bodies of so many coordinates.
    fn departs<'a, const W: usize>(&'a self, plan: &LinkedPlan, dimension: usize)
    -> Box<dyn Departs<W> + 'a>;
    /// Has lane `to` obey what lane `from` does, as these laws have it already, where the method keeps what lanes obey.
    fn obey<F, const D: usize, const W: usize>(&mut self, _: &LinkedLaws<F, D, W>, _from: usize, _to: usize) {
    }
}

impl ProjectsLinks for Dop853 {
    type Method = Self;

    fn method(&self) -> &Self {
        self
    }
    fn evaluations(&self) -> u32 {
        STAGES as u32
    }
    fn departs<'a, const W: usize>(&'a self, plan: &LinkedPlan, _: usize) -> Box<dyn Departs<W> + 'a> {
        Box::new(Stages::new([plan.coordinates; 2]))
    }
}

impl<const S: usize> ProjectsLinks for Lobatto<S>
where
    Table<S>: Tabulated,
{
    type Method = Self;

    fn method(&self) -> &Self {
        self
    }
    fn evaluations(&self) -> u32 {
        collocation::evaluations(S as u32)
    }
    fn remembers(&self, plan: &LinkedPlan) -> usize {
        collocation::remembered(S, plan)
    }
    fn departs<'a, const W: usize>(
        &'a self,
        plan: &LinkedPlan,
        dimension: usize,
    ) -> Box<dyn Departs<W> + 'a> {
        let with = Coefficients::of(&Table::<S>::TABLE, self.step_size());
        Box::new(Collocation::new(with, plan, dimension))
    }
}

/// The method, and what lanes obey as power series.
#[derive(Clone)]
pub(super) struct TaylorOfLinks {
    pub(super) method: Taylor,
    pub(super) laws: Arc<SeriesLaws>,
}

impl ProjectsLinks for TaylorOfLinks {
    type Method = Taylor;

    fn method(&self) -> &Taylor {
        &self.method
    }
    fn evaluations(&self) -> u32 {
        self.method.order()
    }
    fn departs<'a, const W: usize>(
        &'a self,
        plan: &LinkedPlan,
        dimension: usize,
    ) -> Box<dyn Departs<W> + 'a> {
        let (few, n) = (Few::new(&self.method, &self.laws, plan), plan.coordinates);
        Box::new(Expansion::new(self.method, few, [n, n, n / dimension]))
    }
    fn obey<F, const D: usize, const W: usize>(
        &mut self,
        laws: &LinkedLaws<F, D, W>,
        from: usize,
        to: usize,
    ) {
        Arc::make_mut(&mut self.laws).copy(laws, from, to);
    }
}

/// What the method sees of linked bodies.
type Seen<'a, M, F, const D: usize> = View<'a, <M as ProjectsLinks>::Method, f64, Linked<F, Many, D>, D>;

/// A row of trajectories of linked bodies.
#[derive(Clone)]
pub(super) struct LinkedProjected<M, F, const D: usize, const W: usize> {
    plan: Arc<LinkedPlan>,
    laws: Arc<LinkedLaws<F, D, W>>,
    kept: Kept<W>,
    method: M,
    set: Fusing,
    /// By lane what answers for bodies that go by themselves since links nearly depend on each other.
    narrow: Vec<Narrow<F, D>>,
}

impl<M: ProjectsLinks, F: Forces<f64, D>, const D: usize, const W: usize> LinkedProjected<M, F, D, W> {
    /// Lanes, none of them set, of what is obeyed there.
    pub(super) fn new((plan, laws): (LinkedPlan, LinkedLaws<F, D, W>), method: M, set: Fusing) -> Self {
        let kept = Kept::new(plan.coordinates, method.remembers(&plan));
        Self { plan: Arc::new(plan), laws: Arc::new(laws), kept, method, set, narrow: vec![None; W] }
    }

    /// What the method sees of a system; none where it cannot move it, which was asked.
    fn view(system: &Linked<F, Many, D>) -> Option<Seen<'_, M, F, D>> {
        <M::Method as Method>::Need::of(system).ok()
    }

    /// The bodies of a lane.
    fn bodies_of(&self, kept: &Kept<W>, lane: usize) -> Vec<Body<f64, D>> {
        let (masses, [q, v, q_low, v_low]) = (&self.laws.law(lane).masses, &kept.state);
        let vector = |of: &[Numbers<W>], body: usize| -> [f64; D] { from_fn(|d| of[body * D + d].0[lane].0) };
        let momentum = |of: &[Numbers<W>], body: usize| -> [f64; D] {
            from_fn(|d| masses[body * D + d][0] * of[body * D + d].0[lane].0)
        };
        let body = |body| Body {
            q: vector(q, body),
            q_low: vector(q_low, body),
            p: momentum(v, body),
            p_low: momentum(v_low, body),
        };
        (0..self.plan.coordinates / D).map(body).collect()
    }

    /// Finds where a step leads a lane by itself, in this room.
    #[cold]
    #[inline(never)]
    fn step_alone(
        &self,
        lane: usize,
        number: u64,
        kept: &Kept<W>,
        room: &mut Option<BodiesOf<F, Many, D>>,
    ) -> Result<Landed, Stuck> {
        let (law, start) = (self.laws.law(lane), self.bodies_of(kept, lane));
        let Law { system, masses, .. } = law;
        let stuck = |failure| Stuck { lane, failure };
        let (method, view) = (self.method.method(), Self::view(system).ok_or_else(|| stuck(None))?);
        let bodies = prepared(method, (&**system, view), &start, room);
        *bodies.kept.asked() = Asked { steps: number, reach: kept.asked.0[lane].0, near: false };
        let moved = by_itself::step(method, (&**system, view), bodies);
        moved.map_err(|failure| stuck(Some(failure)))?;
        if bodies.kept.asked().near {
            return Err(stuck(None));
        }
        let (mut strays, mut path, half) = (0.0_f64, 0.0_f64, 0.5 * method.step_size());
        let mut state: [Vec<f64>; 4] = from_fn(|_| Vec::with_capacity(masses.len()));
        for (c, [_, over]) in masses.iter().enumerate() {
            let (from, i, d) = (&start[c / D], c / D, c % D);
            let [q, q_low, p, p_low] =
                [bodies.q[i], bodies.q_low[i], bodies.p[i], bodies.p_low[i]].map(|x| x[d]);
            let way = q - from.q[d];
            (strays, path) = (strays.max((way - half * over * (from.p[d] + p)).abs()), path.max(way.abs()));
            state.iter_mut().zip([q, over * p, q_low, over * p_low]).for_each(|(to, x)| to.push(x));
        }
        Ok(Landed { state, strays, path })
    }
}

/// Puts bodies of these masses into a lane.
fn put<const D: usize, const W: usize>(
    masses: &[[f64; 2]],
    kept: &mut Kept<W>,
    lane: usize,
    bodies: &[Body<f64, D>],
) {
    let [q, v, q_low, v_low] = &mut kept.state;
    for (c, [_, over]) in masses.iter().enumerate() {
        let (body, d) = (&bodies[c / D], c % D);
        q[c].0[lane] = Fused(body.q[d]);
        q_low[c].0[lane] = Fused(body.q_low[d]);
        v[c].0[lane] = Fused(over * body.p[d]);
        v_low[c].0[lane] = Fused(over * body.p_low[d]);
    }
}

impl<M: ProjectsLinks, F: Forces<f64, D>, const D: usize, const W: usize> Engine<D>
    for LinkedProjected<M, F, D, W>
where
    Width: Wide<W>,
{
    fn width(&self) -> usize {
        W
    }

    fn bodies_of_each(&self) -> usize {
        self.plan.coordinates / D
    }

    fn go(&self, tour: &mut dyn Tour<D>) -> Result<Box<dyn Engine<D>>, Vec<Stuck>> {
        let LinkedLaws { links, over, pulls, .. } = &*self.laws;
        let (plan, over) = (&*self.plan, over.as_deref());
        let course = Course { plan, links, over, parts: &[], equal: false, sums: true, set: self.set };
        let (mut kept, n) = (self.kept.clone(), self.bodies_of_each());
        let mut room = pulls.as_ref().map(|pulls| pulls.begin());
        let copy_of = from_fn(|lane| tour.copy_of(lane));
        let mut rooms: Vec<_> = self.laws.laws.iter().map(|_| None).collect();
        let mut apart = |lane: usize, number: u64, kept: &Kept<W>| {
            self.step_alone(lane, number, kept, &mut rooms[self.laws.number_of_law(lane)])
        };
        let stand = Stand::new(course, self.method.method(), D, kept.past.len());
        let mut desk = Desk::new(stand, self.method.departs(plan, D));
        while let Some(Leg { from, steps, written, shown }) = tour.next() {
            Width::project(ProjectedSteps {
                pulling: room.as_deref_mut().map(|pulling| pulling as &mut dyn Pulling<LinkedRow, W>),
                apart: &mut apart,
                copy_of: &copy_of,
                desk: &mut desk,
                kept: &mut kept,
                from,
                steps,
                looks: shown,
            })?;
            if let Some(written) = written {
                let bodies = (0..W).flat_map(|lane| self.bodies_of(&kept, lane)).collect::<Vec<_>>();
                written.fill(W * n, |i| bodies[i].q, |i| bodies[i].p);
            }
        }
        Ok(Box::new(Self { kept, ..self.clone() }))
    }

    fn set(&mut self, lane: usize, bodies: &[Body<f64, D>]) -> bool {
        let (law, kept) = (self.laws.law(lane), &mut self.kept);
        put(&law.masses, kept, lane, bodies);
        forget(&mut kept.past, lane);
        (kept.asked.0[lane], kept.astray.0[lane]) = (Fused(0.0), Fused(0.0));
        let finite = bodies.iter().all(|body| body.q.iter().chain(&body.p).all(|x| x.is_finite()));
        self.narrow[lane] = None;
        if !finite {
            return false;
        }
        let placed = law.system.bodies(bodies, 0.0);
        let (plain, narrow) = law.is_plain(&self.plan, (&placed, bodies), self.step_size());
        self.narrow[lane] = narrow;
        plain
    }

    fn copy(&mut self, from: usize, to: usize) {
        self.kept.all().for_each(|numbers| numbers.0[to] = numbers.0[from]);
        self.narrow[to] = self.narrow[from].clone();
    }

    fn obey(&mut self, from: usize, to: usize) {
        if !self.laws.alike() {
            Arc::make_mut(&mut self.laws).copy(from, to);
            self.method.obey(&self.laws, from, to);
        }
    }

    fn obey_as_in(&mut self, engine: &dyn Engine<D>) {
        if let Some(Self { laws, method, .. }) = (engine as &dyn Any).downcast_ref() {
            (self.laws, self.method) = (laws.clone(), method.clone());
        }
    }

    fn bodies(&self, lane: usize) -> Vec<Body<f64, D>> {
        self.bodies_of(&self.kept, lane)
    }

    fn by_itself(
        &self,
        lane: usize,
        bodies: &[Body<f64, D>],
        steps: OwnSteps,
        _: &mut u64,
    ) -> Result<Moved<D>, Trouble> {
        let law = self.laws.law(lane);
        let ready = law.ready(bodies, self.step_size());
        let system = ready.as_ref().unwrap_or(&law.system);
        let Some(view) = Self::view(system) else { return Ok((bodies.to_vec(), 0.0)) }; // never
        by_itself::steps(self.method.method(), (system, view), bodies, steps)
    }

    fn kick_alone(&self, steps: u32) {
        let Some(pulls) = &self.laws.pulls else { return };
        let (mut pulling, plan) = (pulls.begin(), &*self.plan);
        let mut kicked = vec![zeros(); plan.coordinates];
        for _ in 0..steps * self.method.evaluations() {
            pulling.pull(self.set, 1e-9, (black_box(&self.kept.state[0]), &plan.masses, &mut kicked));
        }
        black_box(kicked);
    }

    fn forces(&self) -> Vec<&'static str> {
        forces(self.system(0), &self.bodies(0))
    }

    fn record(&self, to: &mut Record) {
        write_all(&mut self.kept.clone().all().map(|row| &*row), to);
    }

    fn recalled(&self, from: &mut Reading<'_>) -> Result<Box<dyn Engine<D>>, Error> {
        let mut again = self.clone();
        read_all(&mut again.kept.all(), from)?;
        Ok(Box::new(again))
    }

    fn hallmarks(&self, lane: usize, looks: &Looks<D>) -> Vec<Hallmark> {
        of_lane(self.system(lane), looks, self.step_size())
    }

    fn method(&self) -> Hallmark {
        of_projected(self.method.method())
    }
}

impl<M: ProjectsLinks, F: Forces<f64, D>, const D: usize, const W: usize> Obeying<D>
    for LinkedProjected<M, F, D, W>
{
    type System = Linked<F, Many, D>;

    fn system(&self, lane: usize) -> &Self::System {
        self.narrow[lane].as_ref().unwrap_or(&self.laws.law(lane).system)
    }

    fn step_size(&self) -> f64 {
        self.method.method().step_size()
    }
}
