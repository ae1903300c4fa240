//! Recorders: what is kept of a run, and only that.

use crate::bodies::Count;
use crate::effect::Effects;
use crate::kernel::Constraint;
use crate::simulation::Simulation;
use crate::stepper::Stepper;

/// Sees a simulation after every step, and hears the multipliers during it.
///
/// For what can be read off the simulation itself a closure is enough:
/// [`Simulation::run_with`](crate::simulation::Simulation::run_with).
pub trait Recorder<S> {
    /// Is shown the simulation after a step.
    fn record(&mut self, simulation: &S);
    /// Is told λ of the position equation of the step under way.
    fn position_multiplier(&mut self, _body: usize, _lambda: f64) {}
    /// Is told μ of the momentum equation of the step under way.
    fn momentum_multiplier(&mut self, _body: usize, _mu: f64) {}
}

/// Times, positions and momenta of a run, row by row from its start; multipliers on request.
///
/// A row holds the bodies in turn, a body its D coordinates.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Trajectory {
    times: Vec<f64>,
    positions: Vec<f64>,
    momenta: Vec<f64>,
    multipliers: Option<Multipliers>,
}

/// λ and μ of a run, one of each per body and row, on the scale of q̈ = −∇U + ∇g λ.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Multipliers {
    /// λ of the step that led to the row; in the first row λ(t₀) of the exact motion.
    pub position: Vec<f64>,
    /// μ of the step that led to the row; in the first row λ(t₀) of the exact motion.
    pub momentum: Vec<f64>,
}

impl Trajectory {
    /// A recorder whose first row is the present state.
    pub fn of<C, E, N, S, const D: usize>(simulation: &Simulation<C, E, N, S, D>) -> Self
    where
        C: Constraint<D, 1>,
        E: Effects<D>,
        N: Count,
        S: Stepper,
    {
        let mut trajectory = Self::default();
        trajectory.record(simulation);
        trajectory
    }

    /// The same, keeping the multipliers λ and μ of every step as well.
    pub fn with_multipliers<C, E, N, S, const D: usize>(simulation: &Simulation<C, E, N, S, D>) -> Self
    where
        C: Constraint<D, 1>,
        E: Effects<D>,
        N: Count,
        S: Stepper,
    {
        let position: Vec<f64> = simulation.multipliers().collect();
        let multipliers = Some(Multipliers { momentum: position.clone(), position });
        Self { multipliers, ..Self::of(simulation) }
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

    /// The multipliers, shape [rows, bodies] each, if they were asked for.
    #[must_use]
    pub fn multipliers(&self) -> Option<&Multipliers> {
        self.multipliers.as_ref()
    }
}

impl<C, E, N, S, const D: usize> Recorder<Simulation<C, E, N, S, D>> for Trajectory
where
    C: Constraint<D, 1>,
    E: Effects<D>,
    N: Count,
    S: Stepper,
{
    fn record(&mut self, simulation: &Simulation<C, E, N, S, D>) {
        self.times.push(simulation.time());
        for (q, p) in simulation.positions().zip(simulation.momenta()) {
            self.positions.extend(q.iter());
            self.momenta.extend(p.iter());
        }
    }

    fn position_multiplier(&mut self, _body: usize, lambda: f64) {
        if let Some(multipliers) = &mut self.multipliers {
            multipliers.position.push(lambda);
        }
    }

    fn momentum_multiplier(&mut self, _body: usize, mu: f64) {
        if let Some(multipliers) = &mut self.multipliers {
            multipliers.momentum.push(mu);
        }
    }
}
