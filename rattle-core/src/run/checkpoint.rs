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
//! To continue, first make the run as before: the same scene, any start, the same method, and the same calls of
//! `retry`, `collide` and the like. These are code and not in the checkpoint. But the checkpoint holds values that they
//! give, and is refused, with the part that differs, where the values are others now. Everything that changes in a run
//! comes from the checkpoint: positions and momenta with their rounding errors, the memory of method and effects, time,
//! steps, random numbers, work, energy at the start, events, and the errors of the last guesses.

use crate::error::Error;
use crate::motion::bodies::Body;
use crate::motion::method::Method;
use crate::motion::record::{Hallmark, Reading, Record};
use crate::motion::system::System;
use crate::run::boxed::BoxedSimulation;
use crate::run::ensemble::{Ensemble, STRETCH};
use crate::run::fingerprint::{of_method, of_system};
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
        to.vectors("q", bodies.q.as_ref());
        to.vectors("q rounding", bodies.q_low.as_ref());
        to.vectors("p", bodies.p.as_ref());
        to.vectors("p rounding", bodies.p_low.as_ref());
        to.numbers("time of the bodies", &[1], [bodies.time]);
        let places: Vec<_> = (0..self.bodies()).map(|body| bodies.body(body)).collect();
        to.within("run", |to| {
            self.hallmarks(&places, bodies.time).iter().for_each(|mark| mark.write(to));
        });
        to.counts("steps", [self.steps]);
        to.numbers("clock", &[2], [self.clock.0, self.clock.1]);
        to.numbers("work", &[1], [bodies.work]);
        to.numbers("energy at the start", &[1], [self.start_energy]);
        to.counts("events", [self.events()]);
        to.counts("trajectory and steps before the start", [self.first.trajectory, self.first.step]);
        to.counts("number of the trajectory", self.number);
        let memory = self.memory.as_ref();
        to.numbers("memory of the method", &[memory.len()], memory.iter().copied());
        to.numbers("memory of the effects", &[bodies.marks.len()], bodies.marks.iter().copied());
        to.within("kept", |to| self.system.record(bodies, to));
    }

    /// The same simulation where another was.
    pub(in crate::run) fn recalled(&self, from: &mut Reading<'_>) -> Result<Self, Error> {
        let n = self.bodies();
        let mut again = self.clone();
        let before = &mut again.before;
        before.q.as_mut().copy_from_slice(from.vectors("q", n)?);
        before.q_low.as_mut().copy_from_slice(from.vectors("q rounding", n)?);
        before.p.as_mut().copy_from_slice(from.vectors("p", n)?);
        before.p_low.as_mut().copy_from_slice(from.vectors("p rounding", n)?);
        [before.time] = from.array("time of the bodies")?;
        let places: Vec<_> = (0..n).map(|body| before.body(body)).collect();
        from.within("run", |from| from.same(&self.hallmarks(&places, before.time)))?;
        [again.steps] = from.counted("steps")?;
        again.clock = from.array("clock")?.into();
        [before.work] = from.array("work")?;
        [again.start_energy] = from.array("energy at the start")?;
        let [events] = from.counted("events")?;
        if let Some(told) = again.events.as_deref_mut() {
            told.number = events;
        }
        [again.first.trajectory, again.first.step] = from.counted("trajectory and steps before the start")?;
        again.number = from.counts("number of the trajectory")?.first().copied();
        let memory = again.memory.as_mut();
        memory.copy_from_slice(from.numbers("memory of the method", &[memory.len()])?);
        let marks = &mut again.before.marks;
        let found = from.numbers("memory of the effects", &[marks.len()])?;
        marks.copy_from_slice(found);
        again.memory_before.as_mut().copy_from_slice(again.memory.as_ref());
        again.system.put_back(&mut again.bodies, &again.before);
        from.within("kept", |from| again.system.recall(&mut again.bodies, from))?;
        Ok(again)
    }

    /// What tells this run from another.
    fn hallmarks(&self, places: &[Body<f64, D>], time: f64) -> Vec<Hallmark> {
        let (names, numbers): (Vec<_>, _) = self.options().into_iter().unzip();
        let names = if names.is_empty() { "none".into() } else { names.join(", ") };
        let mut marks = vec![of_method(&self.method), Hallmark::new("options", names, numbers)];
        marks.extend(of_system(&self.system, places, time));
        marks
    }
}
