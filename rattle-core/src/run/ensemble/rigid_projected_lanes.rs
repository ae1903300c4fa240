//! Rigid bodies in lanes, by steps that are [projected](crate::run::ensemble::rigid_projected).

use crate::error::Error;
use crate::methods::dop853::Dop853;
use crate::methods::dop853_table::STAGES;
use crate::methods::taylor::Taylor;
use crate::motion::bodies::Body;
use crate::motion::method::{Method, View};
use crate::motion::need::Need;
use crate::motion::parts::BodiesOf;
use crate::motion::record::{Hallmark, Reading, Record};
use crate::motion::system::System;
use crate::number::instructions::Fusing;
use crate::number::lanes::Fused;
use crate::run::answers::{Obeying, forces};
use crate::run::ensemble::by_itself::{self, prepared};
use crate::run::ensemble::dop853_row::Stages;
use crate::run::ensemble::engine::{Engine, Leg, Moved, OwnSteps, Stuck, Tour};
use crate::run::ensemble::forces_in_lanes::Pulling;
use crate::run::ensemble::lane_record::{of_projected, read_all, write_all};
use crate::run::ensemble::rigid_going::project;
use crate::run::ensemble::rigid_law::RigidLaws;
use crate::run::ensemble::rigid_projected::{Desk, ProjectedSteps};
use crate::run::ensemble::rigid_row::{Nine, RigidRow};
use crate::run::ensemble::rigid_series::Few;
use crate::run::ensemble::rigid_stand::{COORDINATES, Departs, ROW, Stand};
use crate::run::ensemble::series_in_lanes::PullsInSeries;
use crate::run::ensemble::taylor_row::Expansion;
use crate::run::ensemble::track::State;
use crate::run::fingerprint::{Looks, of_lane};
use crate::run::trouble::Trouble;
use crate::systems::network::in_lanes::{Numbers, zeros};
use std::any::Any;
use std::array::from_fn;
use std::hint::black_box;

/// A method whose steps are projected, for rows of rigid bodies.
pub(super) trait ProjectsRigid: Clone + Send + Sync + 'static {
    /// The method itself.
    type Method: Method;

    /// The method, as simulations have it.
    fn method(&self) -> &Self::Method;
    /// How often an inner step evaluates forces.
    fn evaluations(&self) -> u32;
    /// What finds where inner steps lead, of so many bodies.
    fn departs(&self, bodies: usize) -> Box<dyn Departs + '_>;
    /// Has lane `to` obey what lane `from` does, where the method keeps what lanes obey.
    fn obey(&mut self, _from: usize, _to: usize) {}
}

impl ProjectsRigid for Dop853 {
    type Method = Self;

    fn method(&self) -> &Self {
        self
    }
    fn evaluations(&self) -> u32 {
        STAGES as u32
    }
    fn departs(&self, bodies: usize) -> Box<dyn Departs + '_> {
        Box::new(Stages::<ROW>::new(COORDINATES.map(|own| own * bodies)))
    }
}

/// The method, and effects as power series.
#[derive(Clone)]
pub(super) struct TaylorOfRigid {
    pub(super) method: Taylor,
    pub(super) pulls: Option<Box<dyn PullsInSeries>>,
}

impl ProjectsRigid for TaylorOfRigid {
    type Method = Taylor;

    fn method(&self) -> &Taylor {
        &self.method
    }
    fn evaluations(&self) -> u32 {
        self.method.order()
    }
    fn departs(&self, bodies: usize) -> Box<dyn Departs + '_> {
        let few = Few::new(&self.method, self.pulls.as_deref(), bodies);
        Box::new(Expansion::new(self.method, few, [9 * bodies, 3 * bodies, 3 * bodies]))
    }
    fn obey(&mut self, from: usize, to: usize) {
        if let Some(pulls) = &mut self.pulls {
            pulls.copy(from, to);
        }
    }
}

/// A row of trajectories of rigid bodies. D is 9.
#[derive(Clone)]
pub(super) struct RigidProjected<M, Y, const D: usize> {
    laws: RigidLaws<Y, Nine<ROW>, ROW>,
    /// Attitudes and momenta.
    kept: State<ROW>,
    method: M,
    set: Fusing,
}

/// What the method sees of a system.
type Seen<'a, M, Y, const D: usize> = View<'a, <M as ProjectsRigid>::Method, f64, Y, D>;

impl<M: ProjectsRigid, Y: System<f64, D>, const D: usize> RigidProjected<M, Y, D> {
    /// Lanes, none of them set, for so many bodies.
    pub(super) fn new(laws: RigidLaws<Y, Nine<ROW>, ROW>, bodies: usize, method: M, set: Fusing) -> Self {
        let kept = from_fn(|i| vec![zeros(); COORDINATES[i % 2] * bodies]);
        Self { laws, kept, method, set }
    }

    /// What the method sees of a system; none where it cannot move it, which was asked.
    fn view(system: &Y) -> Option<Seen<'_, M, Y, D>> {
        <M::Method as Method>::Need::of(system).ok()
    }

    /// The bodies of a lane.
    fn bodies_of(kept: &State<ROW>, lane: usize) -> Vec<Body<f64, D>> {
        let own = |of: &[Numbers<ROW>], number: usize| -> [f64; D] {
            from_fn(|k| of.get(k).filter(|_| k < number).map_or(0.0, |x| x.0[lane].0))
        };
        let body = |i: usize| {
            let [q, p, q_low, p_low] = from_fn(|kind| {
                let number = COORDINATES[kind % 2];
                own(&kept[kind][number * i..], number)
            });
            Body { q, q_low, p, p_low }
        };
        (0..kept[1].len() / COORDINATES[1]).map(body).collect()
    }

    /// Finds where a step leads a lane by itself, in this room.
    #[cold]
    #[inline(never)]
    fn step_alone(
        &self,
        lane: usize,
        kept: &State<ROW>,
        room: &mut Option<BodiesOf<Y, f64, D>>,
    ) -> Result<[Vec<f64>; 4], Stuck> {
        let system = self.laws.system(lane);
        let (view, method) = (Self::view(system).ok_or(Stuck { lane, failure: None })?, self.method.method());
        let bodies = prepared(method, (system, view), &Self::bodies_of(kept, lane), room);
        let done = method.step::<f64, Y, _, D>(view, bodies, &mut [], &mut ());
        done.map_err(|failure| Stuck { lane, failure: Some(failure) })?;
        Ok(numbers(&bodies.all()))
    }
}

/// The numbers of bodies, as a [`State`].
fn numbers<const D: usize>(bodies: &[Body<f64, D>]) -> [Vec<f64>; 4] {
    from_fn(|kind| {
        let of = |body: &Body<f64, D>| [body.q, body.p, body.q_low, body.p_low][kind];
        bodies.iter().flat_map(|body| of(body).into_iter().take(COORDINATES[kind % 2])).collect()
    })
}

impl<M: ProjectsRigid, Y: System<f64, D>, const D: usize> Engine<D> for RigidProjected<M, Y, D> {
    fn width(&self) -> usize {
        ROW
    }

    fn bodies_of_each(&self) -> usize {
        self.kept[1].len() / COORDINATES[1]
    }

    fn go(&self, tour: &mut dyn Tour<D>) -> Result<Box<dyn Engine<D>>, Vec<Stuck>> {
        let (mut kept, n) = (self.kept.clone(), self.bodies_of_each());
        let mut room = self.laws.pulls.as_ref().map(|pulls| pulls.begin());
        let copy_of = from_fn(|lane| tour.copy_of(lane));
        let mut rooms: Vec<_> = (0..self.laws.number_of_system(0)[0]).map(|_| None).collect();
        let mut apart = |lane: usize, kept: &State<ROW>| {
            self.step_alone(lane, kept, &mut rooms[self.laws.number_of_system(lane)[1]])
        };
        let stand = Stand::new(&self.laws.inertia, n, self.method.method(), self.set);
        let mut desk = Desk::new(stand, self.method.departs(n));
        while let Some(Leg { steps, written, .. }) = tour.next() {
            project(ProjectedSteps {
                pulling: room
                    .as_deref_mut()
                    .map(|pulling| pulling as &mut dyn Pulling<RigidRow<Nine<ROW>>, ROW>),
                apart: &mut apart,
                copy_of: &copy_of,
                desk: &mut desk,
                kept: &mut kept,
                steps,
            })?;
            if let Some(written) = written {
                let bodies = (0..ROW).flat_map(|lane| Self::bodies_of(&kept, lane)).collect::<Vec<_>>();
                written.fill(ROW * n, |i| bodies[i].q, |i| bodies[i].p);
            }
        }
        Ok(Box::new(Self { kept, ..self.clone() }))
    }

    fn set(&mut self, lane: usize, bodies: &[Body<f64, D>]) -> bool {
        let numbers = numbers(bodies);
        for (to, from) in self.kept.iter_mut().flatten().zip(numbers.iter().flatten()) {
            to.0[lane] = Fused(*from);
        }
        numbers.iter().flatten().all(|x| x.is_finite())
    }

    fn copy(&mut self, from: usize, to: usize) {
        self.kept.iter_mut().flatten().for_each(|numbers| numbers.0[to] = numbers.0[from]);
    }

    fn obey(&mut self, from: usize, to: usize) {
        self.laws.copy(from, to);
        self.method.obey(from, to);
    }

    fn obey_as_in(&mut self, engine: &dyn Engine<D>) {
        if let Some(Self { laws, method, .. }) = (engine as &dyn Any).downcast_ref() {
            (self.laws, self.method) = (laws.clone(), method.clone());
        }
    }

    fn bodies(&self, lane: usize) -> Vec<Body<f64, D>> {
        Self::bodies_of(&self.kept, lane)
    }

    fn by_itself(
        &self,
        lane: usize,
        bodies: &[Body<f64, D>],
        steps: OwnSteps,
        _: &mut u64,
    ) -> Result<Moved<D>, Trouble> {
        let system = self.laws.system(lane);
        let Some(view) = Self::view(system) else { return Ok((bodies.to_vec(), 0.0)) }; // never
        by_itself::steps(self.method.method(), (system, view), bodies, steps)
    }

    fn kick_alone(&self, steps: u32) {
        let Some(pulls) = &self.laws.pulls else { return };
        let mut pulling = pulls.begin();
        let mut torques = vec![[zeros(); 3]; self.bodies_of_each()];
        for _ in 0..steps * self.method.evaluations() {
            pulling.pull(self.set, 1e-9, (black_box(self.kept[0].as_chunks().0), &mut torques));
        }
        black_box(torques);
    }

    fn forces(&self) -> Vec<&'static str> {
        forces(self.system(0), &self.bodies(0))
    }

    fn record(&self, to: &mut Record) {
        write_all(&mut self.kept.iter().flatten(), to);
    }

    fn recalled(&self, from: &mut Reading<'_>) -> Result<Box<dyn Engine<D>>, Error> {
        let mut again = self.clone();
        read_all(&mut again.kept.iter_mut().flatten(), from)?;
        Ok(Box::new(again))
    }

    fn hallmarks(&self, lane: usize, looks: &Looks<D>) -> Vec<Hallmark> {
        of_lane(self.system(lane), looks, self.step_size())
    }

    fn method(&self) -> Hallmark {
        of_projected(self.method.method())
    }
}

impl<M: ProjectsRigid, Y: System<f64, D>, const D: usize> Obeying<D> for RigidProjected<M, Y, D> {
    type System = Y;

    fn system(&self, lane: usize) -> &Y {
        self.laws.system(lane)
    }

    fn step_size(&self) -> f64 {
        self.method.method().step_size()
    }
}
