//! Sights: a trajectory at one time, as an observer is shown it.

use nalgebra::SVector;
use std::fmt;

/// Provides energies, multipliers and forces to a [`Sight`], evaluated when an observer asks for them.
pub trait Source<const D: usize> {
    /// Kinetic and potential energy of this trajectory, which has not failed, at a sight that may lie between two
    /// steps.
    fn energies(&self, trajectory: usize, sight: &Sight<'_, D>) -> [f64; 2];
    /// λ of each equation, and Gᵀλ on each body.
    fn constraints(&self, trajectory: usize, sight: &Sight<'_, D>) -> (Vec<f64>, Vec<SVector<f64, D>>);
    /// q̇ and ṗ of each body, without flows.
    fn rates(&self, trajectory: usize, sight: &Sight<'_, D>) -> [Vec<SVector<f64, D>>; 2];
    /// U of each effect that is not a flow, in the order of the scene.
    fn effect_energies(&self, trajectory: usize, sight: &Sight<'_, D>) -> Vec<f64>;
    /// g of each equation.
    fn residuals(&self, trajectory: usize, sight: &Sight<'_, D>) -> Vec<f64>;
    /// kT: twice the kinetic energy, without that imposed by moving constraints, divided by the number of independent
    /// momenta.
    fn temperature(&self, trajectory: usize, sight: &Sight<'_, D>) -> f64;
    /// The number of corrections in the solution of position equations since the start, now; `None` where they are not
    /// counted.
    fn corrections(&self) -> Option<u64> {
        None
    }
    /// aᵀM b, for changes a and b of the position of a body.
    fn mass_product(&self, trajectory: usize, body: usize, a: &[f64; D], b: &[f64; D]) -> f64;
    /// The step size of the method.
    fn step_size(&self) -> f64;
}

/// A trajectory at one time: number, steps, time, positions and momenta. Energies and multipliers are evaluated on
/// request.
#[doc(alias = "snapshot")]
#[doc(alias = "frame")]
#[doc(alias = "sample")]
#[derive(Clone, Copy)]
pub struct Sight<'a, const D: usize> {
    /// The number of the trajectory in the ensemble, counted from 0; 0 in a simulation.
    pub trajectory: usize,
    /// Steps taken since the simulation or the ensemble was made.
    pub step: u64,
    /// The time.
    pub time: f64,
    /// Positions of the bodies.
    pub positions: &'a [SVector<f64, D>],
    /// Momenta of the bodies.
    pub momenta: &'a [SVector<f64, D>],
    /// Corrections in position equations by then, where they are counted.
    pub(crate) corrections: Option<u64>,
    /// What answers further questions, and under which number it knows the trajectory.
    pub(crate) source: (&'a dyn Source<D>, usize),
}

impl<const D: usize> Sight<'_, D> {
    /// The position of the first body.
    #[must_use]
    pub fn position(&self) -> SVector<f64, D> {
        self.positions[0]
    }

    /// The momentum of the first body.
    #[must_use]
    pub fn momentum(&self) -> SVector<f64, D> {
        self.momenta[0]
    }

    /// Kinetic energy K = pᵀM⁻¹p/2, summed over the bodies; in phase space all of the energy H(q, p). Agrees to
    /// rounding with that of a [`Simulation`](crate::run::simulation::Simulation::kinetic_energy); evaluated at each
    /// call.
    #[must_use]
    pub fn kinetic_energy(&self) -> f64 {
        self.energies()[0]
    }

    /// Potential energy U of all effects, of the trajectory's own scene in a sweep.
    #[must_use]
    pub fn potential_energy(&self) -> f64 {
        self.energies()[1]
    }

    /// Energy H = K + U.
    #[must_use]
    pub fn energy(&self) -> f64 {
        let [kinetic, potential] = self.energies();
        kinetic + potential
    }

    /// The velocity q̇ of each body: M⁻¹p; of a rigid body the rate of its attitude, in phase space that of H with its
    /// multipliers. Where momenta are [half a step
    /// apart](crate::run::simulation::Simulation::momentum_time) from positions, it is the velocity at the time of the
    /// positions; [`Simulation::velocity`](crate::run::simulation::Simulation::velocity) is M⁻¹p of the momenta as they
    /// are shown. A call allocates.
    #[must_use]
    pub fn velocities(&self) -> Vec<SVector<f64, D>> {
        let [velocities, _] = self.rates();
        velocities
    }

    /// U of each effect in the order of the scene, without [flows](crate::effect::Flow), which have none. A call
    /// allocates.
    #[must_use]
    pub fn effect_energies(&self) -> Vec<f64> {
        let (source, trajectory) = self.source;
        source.effect_energies(trajectory, self)
    }

    /// g(q, t) of each equation, in the unit of g. A call allocates.
    #[must_use]
    pub fn residuals(&self) -> Vec<f64> {
        let (source, trajectory) = self.source;
        source.residuals(trajectory, self)
    }

    /// The temperature kT of the momenta, an energy; as
    /// [`Simulation::temperature`](crate::run::simulation::Simulation::temperature).
    #[must_use]
    pub fn temperature(&self) -> f64 {
        let (source, trajectory) = self.source;
        source.temperature(trajectory, self)
    }

    /// Multipliers λ of all equations, from g̈ = 0, as
    /// [`Simulation::multipliers`](crate::run::simulation::Simulation::multipliers). A call allocates. For the previous
    /// sight it also evaluates the constraints there.
    #[must_use]
    pub fn multipliers(&self) -> Vec<f64> {
        let (source, trajectory) = self.source;
        source.constraints(trajectory, self).0
    }

    /// The force Gᵀλ of all constraints on each body, in the unit of force; evaluated at each call.
    #[must_use]
    pub fn constraint_forces(&self) -> Vec<SVector<f64, D>> {
        let (source, trajectory) = self.source;
        source.constraints(trajectory, self).1
    }

    /// The number of corrections in the solution of position equations since the start of a simulation, as
    /// [`Simulation::corrections`](crate::run::simulation::Simulation::corrections).
    #[must_use]
    pub fn corrections(&self) -> Option<u64> {
        self.corrections
    }

    /// The step size of the method.
    #[must_use]
    pub fn step_size(&self) -> f64 {
        self.source.0.step_size()
    }

    pub(crate) fn mass_product(&self, body: usize, a: &[f64; D], b: &[f64; D]) -> f64 {
        let (source, trajectory) = self.source;
        source.mass_product(trajectory, body, a, b)
    }

    pub(crate) fn rates(&self) -> [Vec<SVector<f64, D>>; 2] {
        let (source, trajectory) = self.source;
        source.rates(trajectory, self)
    }

    fn energies(&self) -> [f64; 2] {
        let (source, trajectory) = self.source;
        source.energies(trajectory, self)
    }
}

impl<const D: usize> fmt::Debug for Sight<'_, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut debug = f.debug_struct("Sight");
        debug.field("trajectory", &self.trajectory).field("step", &self.step).field("time", &self.time);
        debug.field("positions", &self.positions).field("momenta", &self.momenta).finish_non_exhaustive()
    }
}
