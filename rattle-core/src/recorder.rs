//! Recorders: what is kept of a run, and only that.

use crate::simulation::Simulation;
use crate::stepper::Stepper;
use crate::system::System;

/// Sees a simulation, of type `S`, after every step, and hears the multipliers during it.
///
/// For what can be read off the simulation itself a closure is enough, see
/// [`Simulation::run_with`](crate::simulation::Simulation::run_with); a pair of recorders is one too.
///
/// ```
/// # use rattle_core::recorder::Recorder;
/// /// The largest multiplier of the run.
/// struct Largest(f64);
///
/// impl<S> Recorder<S> for Largest {
///     fn record(&mut self, _now: &S) {}
///     fn position_multiplier(&mut self, _equation: usize, lambda: f64) {
///         self.0 = self.0.max(lambda.abs());
///     }
/// }
/// ```
pub trait Recorder<S> {
    /// Is shown the simulation after a step.
    fn record(&mut self, simulation: &S);
    /// Is told λ of the position equation of the step under way.
    fn position_multiplier(&mut self, _equation: usize, _lambda: f64) {}
    /// Is told μ of the momentum equation of the step under way.
    fn momentum_multiplier(&mut self, _equation: usize, _mu: f64) {}
}

impl<S, A: Recorder<S>, B: Recorder<S>> Recorder<S> for (A, B) {
    fn record(&mut self, simulation: &S) {
        self.0.record(simulation);
        self.1.record(simulation);
    }
    fn position_multiplier(&mut self, equation: usize, lambda: f64) {
        self.0.position_multiplier(equation, lambda);
        self.1.position_multiplier(equation, lambda);
    }
    fn momentum_multiplier(&mut self, equation: usize, mu: f64) {
        self.0.momentum_multiplier(equation, mu);
        self.1.momentum_multiplier(equation, mu);
    }
}

impl<S, R: Recorder<S>> Recorder<S> for &mut R {
    fn record(&mut self, simulation: &S) {
        (**self).record(simulation);
    }
    fn position_multiplier(&mut self, equation: usize, lambda: f64) {
        (**self).position_multiplier(equation, lambda);
    }
    fn momentum_multiplier(&mut self, equation: usize, mu: f64) {
        (**self).momentum_multiplier(equation, mu);
    }
}

/// Times, positions and momenta of a run, row by row from its start; multipliers on request.
///
/// A row holds the bodies in turn, a body its D coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    bodies: usize,
    coordinates: usize,
    times: Vec<f64>,
    positions: Vec<f64>,
    momenta: Vec<f64>,
    multipliers: Option<Multipliers>,
    /// λ and μ of the step under way, one of each per equation; in a method of stages those of the last stage.
    under_way: Multipliers,
}

/// λ and μ of a run, one of each per equation and row, on the scale of M q̈ = −∇U + Gᵀλ.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Multipliers {
    /// λ of the step that led to the row; in the first row λ(t₀) of the exact motion. NaN where the trajectory was only
    /// shown the simulation after the step, not run with it.
    pub position: Vec<f64>,
    /// μ of the step that led to the row; in the first row λ(t₀) of the exact motion.
    pub momentum: Vec<f64>,
}

impl Trajectory {
    /// A recorder whose first row is the present state.
    pub fn of<Y: System<f64, D>, S: Stepper, const D: usize>(simulation: &Simulation<Y, S, D>) -> Self {
        let mut trajectory = Self {
            bodies: simulation.len(),
            coordinates: D,
            times: Vec::new(),
            positions: Vec::new(),
            momenta: Vec::new(),
            multipliers: None,
            under_way: Multipliers::default(),
        };
        trajectory.record(simulation);
        trajectory
    }

    /// The same, keeping the multipliers λ and μ of every step as well.
    pub fn with_multipliers<Y: System<f64, D>, S: Stepper, const D: usize>(
        simulation: &Simulation<Y, S, D>,
    ) -> Self {
        let position: Vec<f64> = simulation.multipliers();
        let at_start = Multipliers { momentum: position.clone(), position };
        Self { multipliers: Some(at_start.clone()), under_way: at_start, ..Self::of(simulation) }
    }

    /// Rows, bodies, and coordinates of a body: the shape of positions and momenta.
    #[must_use]
    pub fn shape(&self) -> [usize; 3] {
        [self.times.len(), self.bodies, self.coordinates]
    }

    /// Time of each row.
    #[must_use]
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Positions, shape [rows, bodies, D].
    #[must_use]
    pub fn positions(&self) -> &[f64] {
        &self.positions
    }

    /// Momenta, shape [rows, bodies, D].
    #[must_use]
    pub fn momenta(&self) -> &[f64] {
        &self.momenta
    }

    /// The multipliers, shape [rows, equations] each, if they were asked for; on surfaces a body has one equation.
    #[must_use]
    pub fn multipliers(&self) -> Option<&Multipliers> {
        self.multipliers.as_ref()
    }
}

impl<Y: System<f64, D>, S: Stepper, const D: usize> Recorder<Simulation<Y, S, D>> for Trajectory {
    fn record(&mut self, simulation: &Simulation<Y, S, D>) {
        self.times.push(simulation.time());
        for (q, p) in simulation.positions().zip(simulation.momenta()) {
            self.positions.extend(q.iter());
            self.momenta.extend(p.iter());
        }
        if let Some(rows) = &mut self.multipliers {
            for (rows, under_way) in [
                (&mut rows.position, &mut self.under_way.position),
                (&mut rows.momentum, &mut self.under_way.momentum),
            ] {
                rows.extend(under_way.iter());
                under_way.fill(f64::NAN);
            }
        }
    }

    fn position_multiplier(&mut self, equation: usize, lambda: f64) {
        if let Some(under_way) = self.under_way.position.get_mut(equation) {
            *under_way = lambda;
        }
    }

    fn momentum_multiplier(&mut self, equation: usize, mu: f64) {
        if let Some(under_way) = self.under_way.momentum.get_mut(equation) {
            *under_way = mu;
        }
    }
}
