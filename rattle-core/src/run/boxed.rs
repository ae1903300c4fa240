//! A simulation with a short type.

use crate::error::Error;
use crate::motion::method::Method;
use crate::motion::record::Record;
use crate::motion::state::State;
use crate::motion::system::System;
use crate::run::bill::Bill;
use crate::run::simulation::Simulation;
use crate::run::watch::observer::Observer;
use nalgebra::SVector;
use std::fmt;

/// A simulation of any scene with D coordinates per body, moved by any method: made by
/// [`Simulation::boxed`].
///
/// The type of a [`Simulation`] contains the scene and the method, which makes it fast, and long to write. This type is
/// short: for fields of structures, for functions that return simulations, and for simulations of different scenes in
/// one `Vec`. Results are the same, bit for bit. Each call costs some nanoseconds more; a call of [`run`](Self::run)
/// only once, whatever the number of steps.
///
/// ```
/// use rattle::prelude::*;
/// use rattle::{potentials::Gravity, surfaces::{Sphere, Torus}};
///
/// struct Experiment {
///     title: String,
///     simulation: BoxedSimulation<3>,
/// }
///
/// let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 0.5, 0.5]);
/// let ball = Scene::on(Sphere { r: 1.0 }).with(Gravity { g: 1.0 });
/// let ring = Scene::on(Torus { major: 0.7, minor: 0.3 });
/// let mut experiments = vec![
///     Experiment { title: "ball".into(), simulation: ball.simulate(start.clone(), Rattle::new(0.01))?.boxed() },
///     Experiment { title: "ring".into(), simulation: ring.simulate(start, Lobatto::<4>::new(0.02))?.boxed() },
/// ];
/// for Experiment { title, simulation } in &mut experiments {
///     simulation.run_until(2.0)?;
///     println!("{title}: {} steps, energy error {:e}", simulation.steps(), simulation.energy_error());
/// }
/// assert_eq!(experiments[0].simulation.steps(), 200);
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "dyn")]
#[doc(alias = "type erasure")]
#[derive(Clone)]
pub struct BoxedSimulation<const D: usize>(Box<dyn AnySimulation<D>>);

/// What [`BoxedSimulation`] asks of a simulation, whatever its scene and method.
trait AnySimulation<const D: usize>: Questions<D> + Send + Sync + fmt::Debug {
    fn cloned(&self) -> Box<dyn AnySimulation<D>>;
    fn run(&mut self, steps: u64) -> Result<(), Error>;
    fn run_until(&mut self, time: f64) -> Result<(), Error>;
    fn observe(&mut self, steps: u64, every: u64, observer: &mut dyn Observer<D>) -> Result<(), Error>;
    fn resume(&mut self, checkpoint: &Record) -> Result<(), Error>;
    /// Time, time of momenta, step size.
    fn times(&self) -> [f64; 3];
    /// Position, momentum, velocity.
    fn body(&self, body: usize) -> [SVector<f64, D>; 3];
    fn bill(&self) -> Result<Bill, Error>;
}

impl<Y: System<f64, D>, S: Method, const D: usize> Simulation<Y, S, D> {
    /// The same simulation as a [`BoxedSimulation`].
    pub fn boxed(self) -> BoxedSimulation<D> {
        BoxedSimulation(Box::new(self))
    }
}

impl<Y: System<f64, D>, S: Method, const D: usize> AnySimulation<D> for Simulation<Y, S, D> {
    fn cloned(&self) -> Box<dyn AnySimulation<D>> {
        Box::new(self.clone())
    }
    fn run(&mut self, steps: u64) -> Result<(), Error> {
        self.run(steps)
    }
    fn run_until(&mut self, time: f64) -> Result<(), Error> {
        self.run_until(time)
    }
    fn observe(&mut self, steps: u64, every: u64, observer: &mut dyn Observer<D>) -> Result<(), Error> {
        self.observe(steps, every, observer)
    }
    fn resume(&mut self, checkpoint: &Record) -> Result<(), Error> {
        self.resume(checkpoint)
    }
    fn times(&self) -> [f64; 3] {
        [self.time(), self.momentum_time(), self.method().step_size()]
    }
    fn body(&self, body: usize) -> [SVector<f64, D>; 3] {
        let velocity = self.system().velocity(&self.bodies, body);
        [self.bodies.q.as_ref()[body], self.bodies.p.as_ref()[body], velocity].map(Into::into)
    }
    fn bill(&self) -> Result<Bill, Error> {
        self.bill()
    }
}

impl<const D: usize> BoxedSimulation<D> {
    /// Takes one step.
    ///
    /// # Errors
    /// As [`Simulation::step`].
    pub fn step(&mut self) -> Result<(), Error> {
        self.run(1)
    }

    /// Takes `steps` steps.
    ///
    /// # Errors
    /// As [`Simulation::run`].
    pub fn run(&mut self, steps: u64) -> Result<(), Error> {
        self.0.run(steps)
    }

    /// Takes whole steps until this time is reached, see [`Simulation::run_until`].
    ///
    /// # Errors
    /// As there.
    pub fn run_until(&mut self, time: f64) -> Result<(), Error> {
        self.0.run_until(time)
    }

    /// Takes `steps` steps and shows the simulation to `see` after each.
    ///
    /// # Errors
    /// As [`Simulation::run_with`].
    pub fn run_with(&mut self, steps: u64, mut see: impl FnMut(&Self)) -> Result<(), Error> {
        (0..steps).try_for_each(|_| {
            self.step()?;
            see(self);
            Ok(())
        })
    }

    /// Takes steps as long as `go_on` returns true, at most `steps`; see [`Simulation::run_while`].
    ///
    /// # Errors
    /// As there.
    pub fn run_while(&mut self, steps: u64, mut go_on: impl FnMut(&Self) -> bool) -> Result<u64, Error> {
        let begun = self.steps();
        while self.steps() - begun < steps && go_on(self) {
            self.step()?;
        }
        Ok(self.steps() - begun)
    }

    /// Takes `steps` steps and shows the simulation to `observer` after every `every` of them, see
    /// [`Simulation::observe`].
    ///
    /// # Errors
    /// As there.
    pub fn observe<O: Observer<D>>(&mut self, steps: u64, every: u64, observer: &mut O) -> Result<(), Error> {
        self.0.observe(steps, every, observer)
    }

    /// Continues from a checkpoint, see [`Simulation::resume`].
    ///
    /// # Errors
    /// As there.
    pub fn resume(&mut self, checkpoint: &Record) -> Result<(), Error> {
        self.0.resume(checkpoint)
    }

    /// The time.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.0.times()[0]
    }

    /// The time of the momenta, see [`Simulation::momentum_time`].
    #[must_use]
    pub fn momentum_time(&self) -> f64 {
        self.0.times()[1]
    }

    /// The step size of the method.
    #[must_use]
    pub fn step_size(&self) -> f64 {
        self.0.times()[2]
    }

    /// Positions of the bodies in order. That of the first, or only, body is `.positions().next()`.
    pub fn positions(&self) -> impl ExactSizeIterator<Item = SVector<f64, D>> + '_ {
        (0..self.bodies()).map(|body| self.0.body(body)[0])
    }

    /// Momenta p of the bodies in order.
    pub fn momenta(&self) -> impl ExactSizeIterator<Item = SVector<f64, D>> + '_ {
        (0..self.bodies()).map(|body| self.0.body(body)[1])
    }

    /// Velocities q̇ = M⁻¹p of the bodies in order; for a rigid body the nine entries of Q̇ = Q Ω̂, row by row.
    pub fn velocities(&self) -> impl ExactSizeIterator<Item = SVector<f64, D>> + '_ {
        (0..self.bodies()).map(|body| self.0.body(body)[2])
    }

    /// Energy H = K + U.
    #[must_use]
    pub fn energy(&self) -> f64 {
        self.kinetic_energy() + self.potential_energy()
    }

    /// What a step costs at the present state, item by item; see [`Simulation::bill`].
    ///
    /// # Errors
    /// As there.
    pub fn bill(&self) -> Result<Bill, Error> {
        self.0.bill()
    }
}

/// Questions without arguments: methods of [`BoxedSimulation`], answered by those of [`Simulation`] with the same name.
macro_rules! questions {
    ($($(#[$doc:meta])* fn $name:ident(&self) -> $answer:ty;)*) => {
        trait Questions<const D: usize> {
            $(fn $name(&self) -> $answer;)*
        }

        impl<Y: System<f64, D>, S: Method, const D: usize> Questions<D> for Simulation<Y, S, D> {
            $(fn $name(&self) -> $answer {
                self.$name()
            })*
        }

        impl<const D: usize> BoxedSimulation<D> {
            $($(#[$doc])*
            #[must_use]
            pub fn $name(&self) -> $answer {
                self.0.$name()
            })*
        }
    };
}

questions! {
    /// A record of everything needed to continue from here, see [`Simulation::checkpoint`].
    fn checkpoint(&self) -> Record;

    /// Steps taken so far.
    fn steps(&self) -> u64;

    /// The number of bodies.
    fn bodies(&self) -> usize;

    /// The present state, see [`Simulation::state`].
    fn state(&self) -> State<D>;

    /// Kinetic energy K = pᵀM⁻¹p/2, summed over the bodies; in phase space all of the energy H(q, p).
    fn kinetic_energy(&self) -> f64;

    /// The number of independent momenta, see [`Simulation::freedom`].
    fn freedom(&self) -> usize;

    /// The temperature kT of the present momenta, an energy; see [`Simulation::temperature`].
    fn temperature(&self) -> f64;

    /// Potential energy U of all effects.
    fn potential_energy(&self) -> f64;

    /// U of each effect in the order of the scene, see [`Simulation::effect_energies`].
    fn effect_energies(&self) -> Vec<f64>;

    /// Energy now minus energy at the start, minus the [work](Self::work) done; see [`Simulation::energy_error`].
    fn energy_error(&self) -> f64;

    /// Work done on the bodies since the start, see [`Simulation::work`].
    fn work(&self) -> f64;

    /// Number of impacts and of crossings of edges since the start, see [`Simulation::events`].
    fn events(&self) -> u64;

    /// Number of corrections in the solution of position equations since the start, see [`Simulation::corrections`].
    fn corrections(&self) -> Option<u64>;

    /// g(q, t) of each equation, in the unit of g.
    fn residuals(&self) -> Vec<f64>;

    /// The largest |g(q, t)| of all equations, in the unit of g.
    fn constraint_residual(&self) -> f64;

    /// The largest |G(q)v + ∂g/∂t| of all equations, with v = M⁻¹p; in phase space |{g, H}|.
    fn cotangent_residual(&self) -> f64;

    /// Multipliers λ of the equations in order, see [`Simulation::multipliers`].
    fn multipliers(&self) -> Vec<f64>;

    /// The force Gᵀλ of all constraints on each body, see [`Simulation::constraint_forces`].
    fn constraint_forces(&self) -> Vec<SVector<f64, D>>;
}

impl<const D: usize> Clone for Box<dyn AnySimulation<D>> {
    fn clone(&self) -> Self {
        (**self).cloned()
    }
}

impl<const D: usize> fmt::Debug for BoxedSimulation<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}
