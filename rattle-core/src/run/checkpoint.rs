//! Checkpoints: everything that a run needs to continue as if it had never stopped, bit for bit.
//!
//! ```
//! # use rattle::{Rattle, Scene, State};
//! let scene = Scene::point();
//! let begin = || scene.simulate(State::at([0.0]).moving([1.0]), Rattle::new(0.1));
//! let mut simulation = begin()?;
//! simulation.run(3)?;
//! let checkpoint = simulation.checkpoint();
//!
//! let mut later = begin()?; // in another program, say
//! later.resume(&checkpoint)?;
//! later.run(4)?;
//! simulation.run(4)?;
//! assert_eq!((later.steps(), later.state()), (7, simulation.state()));
//! # Ok::<(), rattle::Error>(())
//! ```
//!
//! To continue, first make the run as before: the same scene, any start (of links, one where they choose the same
//! [linear algebra](crate::systems::network::LinearAlgebra)), the same method, and the same calls of `retry`, `collide`
//! and the like. These are code and not in the checkpoint. But the checkpoint holds values that they give, and is
//! refused, with the part that differs, where the values are others now. Everything that changes in a run comes from
//! the checkpoint: positions and momenta with their rounding errors, the memory of method and effects, time, steps,
//! random numbers, work, energy at the start, events, and the errors of the last guesses.

use crate::error::Error;
use crate::motion::bodies::{Body, gathered};
use crate::motion::method::Method;
use crate::motion::record::{Hallmark, Reading, Record};
use crate::motion::system::System;
use crate::run::boxed::BoxedSimulation;
use crate::run::ensemble::{Ensemble, STRETCH};
use crate::run::fingerprint::{Looks, allowing, of_method, of_options, of_system};
use crate::run::simulation::Simulation;

/// A run that can be stopped and continued: a simulation of any type, or an ensemble.
#[doc(alias = "restart")]
#[doc(alias = "dump")]
pub trait Checkpoint {
    /// A record of everything needed to continue from here.
    fn checkpoint(&self) -> Record;
    /// Continues from a checkpoint. Where it is refused, the run is unchanged.
    ///
    /// # Errors
    /// [`Error::Record`] for a checkpoint of another scene, method, or number of bodies or trajectories, and for an
    /// incomplete one.
    fn resume(&mut self, checkpoint: &Record) -> Result<(), Error>;
    /// Takes `steps` steps.
    ///
    /// # Errors
    /// As [`Simulation::run`]; an ensemble has none.
    fn take_steps(&mut self, steps: u64) -> Result<(), Error>;
    /// Steps taken since the start.
    fn steps_taken(&self) -> u64;
    /// The number of steps that run as one piece internally. A run may be stopped after any step; stopping after a
    /// multiple of this number costs nothing.
    fn at_a_time(&self) -> u64 {
        1
    }
}

impl<Y: System<f64, D>, S: Method, const D: usize> Checkpoint for Simulation<Y, S, D> {
    fn checkpoint(&self) -> Record {
        self.checkpoint()
    }
    fn resume(&mut self, checkpoint: &Record) -> Result<(), Error> {
        self.resume(checkpoint)
    }
    fn take_steps(&mut self, steps: u64) -> Result<(), Error> {
        self.run(steps)
    }
    fn steps_taken(&self) -> u64 {
        self.steps()
    }
}

impl<const D: usize> Checkpoint for BoxedSimulation<D> {
    fn checkpoint(&self) -> Record {
        self.checkpoint()
    }
    fn resume(&mut self, checkpoint: &Record) -> Result<(), Error> {
        self.resume(checkpoint)
    }
    fn take_steps(&mut self, steps: u64) -> Result<(), Error> {
        self.run(steps)
    }
    fn steps_taken(&self) -> u64 {
        self.steps()
    }
}

impl<const D: usize> Checkpoint for Ensemble<D> {
    fn checkpoint(&self) -> Record {
        self.checkpoint()
    }
    fn resume(&mut self, checkpoint: &Record) -> Result<(), Error> {
        self.resume(checkpoint)
    }
    fn take_steps(&mut self, steps: u64) -> Result<(), Error> {
        self.run(steps);
        Ok(())
    }
    fn at_a_time(&self) -> u64 {
        STRETCH
    }
    fn steps_taken(&self) -> u64 {
        self.steps()
    }
}

impl<Y: System<f64, D>, S: Method, const D: usize> Simulation<Y, S, D> {
    /// A record of everything needed to continue from here bit for bit, see [`checkpoint`](crate::run::checkpoint).
    #[doc(alias = "dump")]
    #[doc(alias = "save")]
    pub fn checkpoint(&self) -> Record {
        let mut record = Record::default();
        record.text("what", "a simulation");
        self.record(&mut record);
        record
    }

    /// Continues from a checkpoint of the same scene and method, see [`checkpoint`](crate::run::checkpoint). Where it
    /// is refused, the simulation is unchanged.
    ///
    /// # Errors
    /// [`Error::Record`] for a checkpoint of another run, with the first part that differs.
    #[doc(alias = "restart")]
    pub fn resume(&mut self, checkpoint: &Record) -> Result<(), Error> {
        let mut reading = checkpoint.read();
        reading.expect("a simulation")?;
        *self = self.recalled(&mut reading)?;
        Ok(())
    }

    pub(in crate::run) fn record(&self, to: &mut Record) {
        let bodies = &self.bodies;
        write_places(to, bodies.lists(), bodies.time);
        to.within("run", |to| {
            for mark in self.hallmarks(&Looks::of(&bodies.all()), bodies.time) {
                mark.write(to);
            }
        });
        let account = Account {
            steps: self.steps,
            clock: self.clock,
            work: bodies.work,
            start_energy: self.start_energy,
            events: self.events(),
            first: [self.first.trajectory, self.first.step],
            number: self.number,
        };
        account.write(to);
        to.list("memory of the method", self.memory.as_ref());
        to.list("memory of the effects", &bodies.marks);
        to.within("kept", |to| self.system.record(bodies, to));
    }

    /// A copy of this simulation in the state that a record holds.
    pub(in crate::run) fn recalled(&self, from: &mut Reading<'_>) -> Result<Self, Error> {
        let (places, time) = read_places(from, self.bodies())?;
        let looks = Looks::of(&places);
        let marks = allowing(self.hallmarks(&looks, time), &self.hallmarks(&looks.rounded(), time));
        from.within("run", |from| from.same(&marks))?;
        let mut again = self.clone();
        let Account { steps, clock, work, start_energy, events, first, number } = Account::read(from)?;
        (again.steps, again.clock, again.start_energy, again.number) = (steps, clock, start_energy, number);
        if let Some(told) = again.events.as_deref_mut() {
            told.number = events;
        }
        [again.first.trajectory, again.first.step] = first;
        again.before.put(&places);
        (again.before.time, again.before.work) = (time, work);
        from.copy("memory of the method", again.memory.as_mut())?;
        from.copy("memory of the effects", &mut again.before.marks)?;
        again.memory_before.as_mut().copy_from_slice(again.memory.as_ref());
        again.system.put_back(&mut again.bodies, &again.before);
        from.within("kept", |from| again.system.recall(&mut again.bodies, from))?;
        Ok(again)
    }

    /// What was asked for beside scene and method, each with a number.
    fn options(&self) -> Vec<(&'static str, f64)> {
        let mut options = Vec::new();
        if let Some(halving) = &self.halving {
            options.push(("retry", f64::from(halving.most)));
        }
        if let Some(reversal) = &self.reversal {
            options.push(("check_reversal", reversal.tolerance));
        }
        if let Some(events) = &self.events {
            for contact in &events.search.meetings.kinds {
                options.push((contact.name(), contact.restitution()));
                for parameter in contact.parameters() {
                    options.push((contact.name(), parameter));
                }
            }
            if events.search.over_kinks {
                options.push(("over_kinks", 1.0));
            }
        }
        options
    }

    /// What tells this run from another.
    fn hallmarks(&self, looks: &Looks<D>, time: f64) -> Vec<Hallmark> {
        let mut marks = vec![of_method(&self.method), of_options(&self.options())];
        marks.extend(of_system(&self.system, looks, time, self.method.step_size()));
        marks
    }
}

/// Writes bodies, and their time.
#[inline(never)]
pub(in crate::run) fn write_places<const D: usize>(
    to: &mut Record,
    [q, q_low, p, p_low]: [&[[f64; D]]; 4],
    time: f64,
) {
    to.vectors("q", q);
    to.vectors("q rounding", q_low);
    to.vectors("p", p);
    to.vectors("p rounding", p_low);
    to.list("time of the bodies", &[time]);
}

/// Reads so many bodies, and their time.
#[inline(never)]
pub(in crate::run) fn read_places<const D: usize>(
    from: &mut Reading<'_>,
    n: usize,
) -> Result<(Vec<Body<f64, D>>, f64), Error> {
    let (q, q_low) = (from.vectors("q", n)?, from.vectors("q rounding", n)?);
    let (p, p_low) = (from.vectors("p", n)?, from.vectors("p rounding", n)?);
    let [time] = from.array("time of the bodies")?;
    Ok((gathered([q, q_low, p, p_low]), time))
}

/// What a simulation counts from its start.
struct Account {
    steps: u64,
    clock: (f64, f64),
    work: f64,
    start_energy: f64,
    events: u64,
    /// The trajectory, and steps before the start.
    first: [u64; 2],
    number: Option<u64>,
}

impl Account {
    fn write(&self, to: &mut Record) {
        to.counts("steps", [self.steps]);
        to.list("clock", &[self.clock.0, self.clock.1]);
        to.list("work", &[self.work]);
        to.list("energy at the start", &[self.start_energy]);
        to.counts("events", [self.events]);
        to.counts("trajectory and steps before the start", self.first);
        to.counts("number of the trajectory", self.number);
    }

    fn read(from: &mut Reading<'_>) -> Result<Self, Error> {
        let [steps] = from.counted("steps")?;
        let clock = from.array("clock")?.into();
        let [work] = from.array("work")?;
        let [start_energy] = from.array("energy at the start")?;
        let [events] = from.counted("events")?;
        let first = from.counted("trajectory and steps before the start")?;
        let number = from.counts("number of the trajectory")?.first().copied();
        Ok(Self { steps, clock, work, start_energy, events, first, number })
    }
}
