//! A run kept whole: times, positions and momenta, row by row.

use crate::motion::method::Method;
use crate::motion::system::System;
use crate::run::recorder::Recorder;
use crate::run::simulation::Simulation;

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
    pub fn of<Y: System<f64, D>, S: Method, const D: usize>(simulation: &Simulation<Y, S, D>) -> Self {
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
    pub fn with_multipliers<Y: System<f64, D>, S: Method, const D: usize>(
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

impl<Y: System<f64, D>, S: Method, const D: usize> Recorder<Simulation<Y, S, D>> for Trajectory {
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
