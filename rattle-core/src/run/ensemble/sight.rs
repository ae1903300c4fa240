//! A trajectory at a time, as who watches is shown it.

use nalgebra::SVector;
use std::fmt;

/// Who knows the energies of trajectories.
pub trait Energies<const D: usize> {
    /// Kinetic and potential energy that this trajectory, which goes on, would have there.
    fn energies(
        &self,
        trajectory: usize,
        positions: &[SVector<f64, D>],
        momenta: &[SVector<f64, D>],
    ) -> [f64; 2];
}

/// A trajectory at a time: its bodies' positions and momenta.
#[derive(Clone, Copy)]
pub struct Sight<'a, const D: usize> {
    /// Which trajectory, counted from 0.
    pub trajectory: usize,
    /// The time.
    pub time: f64,
    /// Positions of its bodies.
    pub positions: &'a [SVector<f64, D>],
    /// Momenta of its bodies.
    pub momenta: &'a [SVector<f64, D>],
    /// What knows its energy, and under which number.
    pub(crate) scene: (&'a dyn Energies<D>, usize),
}

impl<const D: usize> Sight<'_, D> {
    /// The position of the first body, which in lanes is the only one.
    #[must_use]
    pub fn position(&self) -> SVector<f64, D> {
        self.positions[0]
    }

    /// The momentum of the first body.
    #[must_use]
    pub fn momentum(&self) -> SVector<f64, D> {
        self.momenta[0]
    }

    /// Kinetic energy K = pᵀM⁻¹p/2, summed over the bodies; in phase space all of the energy H(q, p). As that of a
    /// [`Simulation`](crate::run::simulation::Simulation::kinetic_energy) but for rounding; evaluated when it is asked for.
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

    fn energies(&self) -> [f64; 2] {
        let (group, trajectory) = self.scene;
        group.energies(trajectory, self.positions, self.momenta)
    }
}

impl<const D: usize> fmt::Debug for Sight<'_, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut debug = f.debug_struct("Sight");
        debug.field("trajectory", &self.trajectory).field("time", &self.time);
        debug.field("positions", &self.positions).field("momenta", &self.momenta).finish_non_exhaustive()
    }
}
