//! Trajectories in phase space in lanes.

use crate::error::Error;
use crate::kernel::functions::{Hamiltonian, PhaseConstraint};
use crate::motion::bodies::{Body, Count};
use crate::motion::failure::Failure;
use crate::motion::method::Stage;
use crate::motion::record::{Hallmark, Reading, Record};
use crate::number::instructions::{Fusing, Work};
use crate::number::vectors::MOST_COORDINATES;
use crate::run::answers::Obeying;
use crate::run::ensemble::engine::{Engine, Leg, Moved, OwnSteps, Stuck, Tour};
use crate::run::ensemble::lane_record::InRows;
use crate::run::ensemble::phase_row::{Laws, ROW, Row, Swept};
use crate::run::ensemble::phase_step::{Scratch, step};
use crate::run::ensemble::splits::hallmark;
use crate::run::ensemble::splitting_lanes::by_itself;
use crate::run::fingerprint::{IN_MOTION, Looks, of_lane, tell};
use crate::run::trouble::Trouble;
use crate::solve::aim::Pace;
use crate::systems::phase::InPhaseSpace;
use std::any::Any;
use std::array::from_fn;
use std::sync::Arc;

/// The system of a trajectory by itself.
type Alone<G, H, N, const D: usize, const M: usize> =
    InPhaseSpace<<G as PhaseConstraint<D, M>>::Kernel<f64>, <H as Hamiltonian<D>>::Kernel<f64>, N, M>;

/// A step works on no more than that: more is far from the processor, and more than stacks hold.
const MOST_BYTES: usize = 1 << 18;

/// Whether bodies of D coordinates under M equations go in lanes.
pub(super) const fn fits_lanes<const D: usize, const M: usize>() -> bool {
    D <= MOST_COORDINATES && size_of::<Scratch<D, M>>() <= MOST_BYTES
}

/// A row of trajectories of bodies in phase space, each body by itself.
pub(super) struct PhaseLanes<G, H, N, const D: usize, const M: usize>
where
    G: PhaseConstraint<D, M>,
    H: Hamiltonian<D>,
{
    /// One for all lanes, or one for each.
    systems: Arc<[Alone<G, H, N, D, M>]>,
    /// Which of them each lane obeys, and what that is in lanes.
    system: [usize; ROW],
    laws: Swept<G, H, D, M>,
    /// A row for each body of a trajectory.
    bodies: Vec<Row<D, M>>,
    /// The lengths of the last steps.
    pace: Pace,
    stages: Arc<[Stage]>,
    h: f64,
    set: Fusing,
}

impl<G, H, N, const D: usize, const M: usize> Clone for PhaseLanes<G, H, N, D, M>
where
    G: PhaseConstraint<D, M>,
    H: Hamiltonian<D>,
{
    fn clone(&self) -> Self {
        Self {
            systems: self.systems.clone(),
            laws: self.laws.clone(),
            bodies: self.bodies.clone(),
            stages: self.stages.clone(),
            ..*self
        }
    }
}

impl<G, H, N: Count, const D: usize, const M: usize> PhaseLanes<G, H, N, D, M>
where
    G: PhaseConstraint<D, M>,
    H: Hamiltonian<D>,
{
    /// Lanes, none of them set, of so many bodies that obey these constraints and Hamiltonians, one for all lanes or
    /// one for each; by these stages, of a step of h.
    pub(super) fn new(spaces: &[(&G, &H)], count: N, stages: &[Stage], h: f64, set: Fusing) -> Self {
        let of = |lane: usize| if lane < spaces.len() { lane } else { 0 };
        let system =
            |(constraint, energy): &(&G, &H)| InPhaseSpace::new(constraint.kernel(), energy.kernel(), count);
        Self {
            systems: spaces.iter().map(system).collect(),
            system: from_fn(of),
            laws: Swept::new(|lane| spaces[of(lane)]),
            bodies: vec![Row::new(); count.number()],
            pace: Pace::unknown(),
            stages: stages.into(),
            h,
            set,
        }
    }
}

impl<G, H, N, const D: usize, const M: usize> Engine<D> for PhaseLanes<G, H, N, D, M>
where
    G: PhaseConstraint<D, M> + 'static,
    H: Hamiltonian<D> + 'static,
    N: Count,
{
    fn width(&self) -> usize {
        ROW
    }

    fn bodies_of_each(&self) -> usize {
        self.bodies.len()
    }

    fn go(&self, tour: &mut dyn Tour<D>) -> Result<Box<dyn Engine<D>>, Vec<Stuck>> {
        let (bodies, pace) = self.set.run_lanes::<ROW, _>(Going { lanes: self, tour })?;
        Ok(Box::new(Self { bodies, pace, ..self.clone() }))
    }

    fn set(&mut self, lane: usize, bodies: &[Body<f64, D>]) -> bool {
        let system = &self.systems[self.system[lane]];
        for (row, body) in self.bodies.iter_mut().zip(bodies) {
            row.put(lane, &system.lone(body));
        }
        true
    }

    fn copy(&mut self, from: usize, to: usize) {
        self.bodies.iter_mut().for_each(|row| row.copy(from, to));
    }

    fn obey(&mut self, from: usize, to: usize) {
        self.system[to] = self.system[from];
        self.laws.copy(from, to);
    }

    fn obey_as_in(&mut self, engine: &dyn Engine<D>) {
        if let Some(Self { system, laws, .. }) = (engine as &dyn Any).downcast_ref() {
            (self.system, self.laws) = (*system, laws.clone());
        }
    }

    fn bodies(&self, lane: usize) -> Vec<Body<f64, D>> {
        self.bodies.iter().map(|row| row.body(lane)).collect()
    }

    fn by_itself(
        &self,
        lane: usize,
        bodies: &[Body<f64, D>],
        steps: OwnSteps,
        _: &mut u64,
    ) -> Result<Moved<D>, Trouble> {
        by_itself::<f64, _, D>(self.system(lane), &self.stages, None, steps, bodies)
    }

    /// Forces are not apart from the rest.
    fn kick_alone(&self, _: u32) {}

    fn forces(&self) -> Vec<&'static str> {
        Vec::new()
    }

    fn record(&self, to: &mut Record) {
        to.list("lengths of the last steps", &self.pace.steps);
        self.bodies.iter().for_each(|row| row.record(to));
    }

    fn recalled(&self, from: &mut Reading<'_>) -> Result<Box<dyn Engine<D>>, Error> {
        let pace = Pace { steps: from.array("lengths of the last steps")? };
        let bodies = self.bodies.iter().map(|_| Row::new().recalled(from)).collect::<Result<_, _>>()?;
        Ok(Box::new(Self { bodies, pace, ..self.clone() }))
    }

    fn hallmarks(&self, lane: usize, looks: &Looks<D>) -> Vec<Hallmark> {
        // Momenta decide what constraints and energies are here, and none runs ahead.
        let mut marks = of_lane(self.system(lane), looks, self.h);
        tell(of_lane(self.system(lane), &looks.in_motion(), self.h), IN_MOTION, &mut marks);
        marks
    }

    fn method(&self) -> Hallmark {
        hallmark(&self.stages, 0)
    }
}

impl<G, H, N, const D: usize, const M: usize> Obeying<D> for PhaseLanes<G, H, N, D, M>
where
    G: PhaseConstraint<D, M>,
    H: Hamiltonian<D>,
    N: Count,
{
    type System = Alone<G, H, N, D, M>;

    fn system(&self, lane: usize) -> &Self::System {
        &self.systems[self.system[lane]]
    }

    fn step_size(&self) -> f64 {
        self.h
    }
}

/// Rows on a tour.
struct Going<'a, G, H, N, const D: usize, const M: usize>
where
    G: PhaseConstraint<D, M>,
    H: Hamiltonian<D>,
{
    lanes: &'a PhaseLanes<G, H, N, D, M>,
    tour: &'a mut dyn Tour<D>,
}

impl<G, H, N, const D: usize, const M: usize> Work for Going<'_, G, H, N, D, M>
where
    G: PhaseConstraint<D, M> + 'static,
    H: Hamiltonian<D> + 'static,
    N: Count,
{
    type Done = Result<(Vec<Row<D, M>>, Pace), Stuck>;

    #[inline(always)]
    fn run(self) -> Self::Done {
        let Self { lanes, tour } = self;
        let laws = lanes.laws.clone(); // out of reach of what the loops write
        let (mut bodies, mut pace) = (lanes.bodies.clone(), lanes.pace);
        let mut scratch = Box::new(Scratch::new());
        while let Some(Leg { steps, written, .. }) = tour.next() {
            for _ in 0..steps {
                for &Stage { h, .. } in &*lanes.stages {
                    for (number, row) in bodies.iter_mut().enumerate() {
                        if !step(row, &laws, h, pace.weights(h), &mut scratch) {
                            move_apart(lanes, number, row, h, pace, &mut scratch)?;
                        }
                        row.clone_from(&scratch.end);
                    }
                    pace.note(h);
                }
            }
            if let Some(written) = written {
                let n = bodies.len();
                let now = |i: usize| bodies[i % n].body(i / n);
                written.fill(ROW * n, |i| now(i).q, |i| now(i).p);
            }
        }
        Ok((bodies, pace))
    }
}

/// Finds where a step leads lanes that cannot go with the others.
#[cold]
#[inline(never)]
fn move_apart<G, H, N, const D: usize, const M: usize>(
    lanes: &PhaseLanes<G, H, N, D, M>,
    number: usize,
    row: &Row<D, M>,
    h: f64,
    pace: Pace,
    scratch: &mut Scratch<D, M>,
) -> Result<(), Stuck>
where
    G: PhaseConstraint<D, M>,
    H: Hamiltonian<D>,
    N: Count,
{
    for lane in (0..ROW).filter(|&lane| scratch.going[lane].0 < 0.0) {
        let system = &lanes.systems[lanes.system[lane]];
        let moved = system.step_alone(h, pace, row.lone(lane));
        let stuck = |failure| Stuck { lane, failure: Some(Failure { body: number, ..failure }) };
        scratch.end.put(lane, &moved.map_err(stuck)?);
    }
    Ok(())
}
