//! Methods with a constant step size and without memory: to write one, implement [`Map`].

use crate::error::Error;
use crate::motion::failure::Failure;
use crate::motion::method::{Method, Splitting, Stage, check_step_size};
use crate::motion::need::Kicks;
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::real::Scalar;
use std::fmt::Debug;

/// A map of the bodies over a time h, made of the operations of a [`System`]. [`Fixed`] turns it into a method.
///
/// Example: the symplectic Euler method that drifts first.
///
/// ```
/// use rattle::method::{Failure, Fixed, Map, Witness};
/// use rattle::real::Scalar;
/// use rattle::system::{BodiesOf, System};
/// use rattle::{Scene, State};
///
/// #[derive(Debug, Clone, Copy, PartialEq, Default)]
/// struct DriftKick;
///
/// impl Map for DriftKick {
///     const NAME: &'static str = "drift, then kick";
///     const ORDER: u32 = 1;
///     const SYMMETRIC: bool = false;
///
///     fn map<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
///         &self,
///         h: f64,
///         system: &Y,
///         bodies: &mut BodiesOf<Y, T, D>,
///         witness: &mut W,
///     ) -> Result<(), Failure> {
///         system.drift(0.0, h, bodies, witness)?;
///         system.evaluate_forces(bodies);
///         system.settle(h, h, bodies, witness)
///     }
/// }
///
/// let start = State::at([0.0]).moving([1.0]);
/// let mut simulation = Scene::point().simulate(start, Fixed::<DriftKick>::new(0.5))?;
/// simulation.run(4)?;
/// assert_eq!(simulation.position().x, 2.0);
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "custom integrator")]
#[doc(alias = "splitting")]
pub trait Map: Clone + Debug + PartialEq + Send + Sync + 'static {
    /// The method's name, as in the literature.
    const NAME: &'static str;
    /// The order p: errors fall like hᵖ.
    const ORDER: u32;
    /// Whether the map of −h undoes that of h.
    const SYMMETRIC: bool;
    /// The time of the momenta minus the time of the positions, in steps; 0 except for staggered methods.
    const DELAY: f64 = 0.0;

    /// Whether the map applies the [flows](crate::effect::Flow) of momenta inside its step.
    const STIRS: bool = false;

    /// As [`Method::KEEPS_FORCES`].
    const KEEPS_FORCES: bool = false;

    /// After how many of its [stages](Self::stages) the map applies the flows, where it [does so](Self::STIRS) and is a
    /// splitting.
    fn stirs_after(&self) -> usize {
        0
    }

    /// Whether the map is a splitting into [stages](Self::stages), which ensembles compute in SIMD lanes.
    const SPLITTING: Splitting = Splitting::Not;
    /// How often a step evaluates the forces, where that is not once for each stage.
    const EVALUATIONS: Option<usize> = None;
    /// The stages of a step of this size in order, as many as [`SPLITTING`](Self::SPLITTING) says.
    fn stages(&self, _h: f64) -> Vec<Stage> {
        Vec::new()
    }

    /// As [`Method::parameters`], beside what the [stages](Self::stages) say.
    fn parameters(&self) -> Vec<f64> {
        Vec::new()
    }

    /// As [`Method::finer`].
    fn finer(&self, _times: u32) -> Option<Self> {
        None
    }

    /// Checks that the map makes sense for a system with this number of equations.
    ///
    /// # Errors
    /// The reason why it does not.
    fn check(&self, _equations: usize) -> Result<(), Error> {
        Ok(())
    }

    /// Takes `bodies` on by a time `h`. Neither allocates nor panics.
    ///
    /// # Errors
    /// Which body cannot be moved, and why; `bodies` are then left unfinished.
    fn map<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        h: f64,
        system: &Y,
        bodies: &mut BodiesOf<Y, T, D>,
        witness: &mut W,
    ) -> Result<(), Failure>;
}

/// A step has no more inner steps; a list of them fits into a megabyte or two.
pub(crate) const MOST_INNER: u32 = 65_536;

/// Checks how many inner steps a step of a method has.
///
/// # Errors
/// [`Error::InnerSteps`].
pub(crate) fn check_inner_steps(method: &'static str, inner: u32) -> Result<(), Error> {
    if (1..=MOST_INNER).contains(&inner) { Ok(()) } else { Err(Error::InnerSteps { method, inner }) }
}

/// The method whose steps are the map `M` with a constant step size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fixed<M> {
    map: M,
    h: f64,
}

impl<M: Map + Default> Fixed<M> {
    /// The method with step size `h`, in the unit of time.
    #[doc(alias = "dt")]
    #[doc(alias = "timestep")]
    #[must_use]
    pub fn new(h: f64) -> Self {
        Self::of(M::default(), h)
    }
}

impl<M: Map> Fixed<M> {
    /// The method of this map with step size `h`, in the unit of time.
    #[must_use]
    pub fn of(map: M, h: f64) -> Self {
        Self { map, h }
    }
}

impl<M: Map> Method for Fixed<M> {
    type Memory<T: Scalar> = [T; 0];
    type Need = Kicks;

    fn step_size(&self) -> f64 {
        self.h
    }
    fn order(&self) -> u32 {
        M::ORDER
    }
    fn name(&self) -> &'static str {
        M::NAME
    }
    fn with_step(&self, h: f64) -> Self {
        Self { map: self.map.clone(), h }
    }
    fn finer(&self, times: u32) -> Option<Self> {
        Some(Self { map: self.map.finer(times)?, h: self.h })
    }
    fn is_symmetric(&self) -> bool {
        M::SYMMETRIC
    }
    fn momentum_delay(&self) -> f64 {
        M::DELAY * self.h
    }
    fn evaluations(&self) -> Option<usize> {
        let stages = (M::SPLITTING != Splitting::Not).then(|| self.stages().len());
        M::EVALUATIONS.or(stages)
    }
    const STIRS: bool = M::STIRS;
    const KEEPS_FORCES: bool = M::KEEPS_FORCES;
    fn stirs_after(&self) -> usize {
        self.map.stirs_after()
    }
    const SPLITTING: Splitting = M::SPLITTING;
    fn stages(&self) -> Vec<Stage> {
        self.map.stages(self.h)
    }
    fn parameters(&self) -> Vec<f64> {
        self.map.parameters()
    }
    fn check(&self, equations: usize) -> Result<(), Error> {
        self.map.check(equations)?;
        check_step_size(self.h)
    }

    #[inline(always)]
    fn step<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: &Y,
        bodies: &mut BodiesOf<Y, T, D>,
        _: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        self.map.map(self.h, system, bodies, witness)
    }
}
