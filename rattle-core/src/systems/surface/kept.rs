//! The system of bodies on surfaces, and the quantities kept from step to step.

use crate::effect::list::Forces;
use crate::kernel::functions::ConstraintKernel;
use crate::motion::bodies::{Bodies, Count};
use crate::number::lanes::Fused;
use crate::number::real::Scalar;
use crate::solve::aim::{Aim, Pace};
use crate::systems::surface::crowd::Crowd;
use crate::systems::surface::in_lanes::TileInLanes;
use crate::systems::surface::normal::Normal;
use crate::systems::surface::room::{SeriesRoom, Stages};
use std::fmt;

/// The system of bodies, each on its own copy of a surface, with forces.
#[derive(Debug, Clone)]
pub struct OnSurface<K, F, N, L> {
    /// g, one equation per body.
    pub constraint: K,
    /// The same function for several bodies at a time (SIMD lanes), or [`OneByOne`].
    pub in_lanes: L,
    /// All effects.
    pub effects: F,
    /// The number of bodies.
    pub count: N,
}

impl<K, F, N, L> OnSurface<K, F, N, L> {
    /// `count` bodies on this surface with these effects, computed `in_lanes` or [`OneByOne`].
    pub fn new(constraint: K, in_lanes: L, effects: F, count: N) -> Self {
        Self { constraint, in_lanes, effects, count }
    }
}

impl<K, F, N: Count, L> OnSurface<K, F, N, L> {
    /// Lets time pass, if anything looks at it.
    #[inline(always)]
    pub(super) fn pass<T: Scalar, const D: usize>(&self, h: f64, bodies: &mut BodiesOf<N, T, F, D>)
    where
        F: Forces<T, D>,
    {
        if self.effects.changes_with_time() {
            bodies.time += h;
        }
    }
}

/// Stands for a kernel in lanes where bodies are computed one by one.
#[derive(Debug, Clone, Copy)]
pub struct OneByOne;

const NAN: Fused<f64> = Fused(f64::NAN);

impl<const D: usize> ConstraintKernel<Fused<f64>, D, 1> for OneByOne {
    fn value(&self, _: &[Fused<f64>; D]) -> [Fused<f64>; 1] {
        [NAN]
    }
    fn value_and_jacobian(&self, _: &[Fused<f64>; D]) -> ([Fused<f64>; 1], [[Fused<f64>; D]; 1]) {
        ([NAN], [[NAN; D]])
    }
    fn hessian_vector(&self, _: &[Fused<f64>; D], _: &[Fused<f64>; D]) -> [[Fused<f64>; D]; 1] {
        [[NAN; D]]
    }
    fn jet(
        &self,
        _: &[Fused<f64>; D],
        _: &[Fused<f64>; D],
    ) -> ([Fused<f64>; 1], [Fused<f64>; 1], [Fused<f64>; 1]) {
        ([NAN], [NAN], [NAN])
    }
}

/// The quantities kept from step to step.
#[derive(Clone)]
pub struct Kept<N: Count, T: Scalar, F: Forces<T, D>, const D: usize> {
    /// Normals at the positions.
    pub normal: N::Of<Normal<T, D>>,
    /// The last forces; of size zero where no effect acts.
    pub force: N::Of<F::Force>,
    /// How far first guesses were off.
    pub(crate) aim: N::Of<Aim<T>>,
    /// In steps of what length.
    pub(crate) pace: Pace,
    /// Who is near other sheets, where bodies go in tiles.
    pub(crate) crowd: Crowd,
    /// Room for a step of a tile, where bodies go in tiles.
    pub(super) lanes: Option<Box<TileInLanes<D>>>,
    /// Room of the effects.
    pub(super) of_effects: F::Room,
    /// Room for a method with inner stages.
    pub(super) stages: Option<Box<Stages<T, F, D>>>,
    /// Room for power series.
    pub(super) series: Option<Box<SeriesRoom<T, D>>>,
}

pub(crate) type BodiesOf<N, T, F, const D: usize> = Bodies<N, T, Kept<N, T, F, D>, D>;

impl<N: Count, T: Scalar, F: Forces<T, D>, const D: usize> fmt::Debug for Kept<N, T, F, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut debug = f.debug_struct("Kept");
        debug.field("normal", &self.normal).field("force", &self.force).finish_non_exhaustive()
    }
}
