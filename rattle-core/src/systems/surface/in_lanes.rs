//! What lanes of a tile of bodies hold in a step.

use crate::number::lanes::Fused;
use crate::number::vectors::{LANES, Vectors};

/// A number of a lane.
pub(super) type Number = Fused<f64>;

/// A number in each lane.
pub(super) type Numbers = [Number; LANES];

/// A vector in each lane.
pub(super) type InEach<const D: usize> = Vectors<Number, LANES, D>;

/// A tile in lanes, and room for a step of it: made once, for all tiles of a simulation.
#[derive(Debug, Clone)]
#[repr(C, align(64))] // cache lines, and the widest registers
pub(crate) struct TileInLanes<const D: usize> {
    pub(super) q: InEach<D>,
    pub(super) q_low: InEach<D>,
    pub(super) p: InEach<D>,
    pub(super) p_low: InEach<D>,
    pub(super) normal: InEach<D>,
    pub(super) force: InEach<D>,
    /// What the constraint adds to: the way without it.
    pub(super) free: InEach<D>,
    /// ∇g where a body lands.
    pub(super) next: InEach<D>,
    /// 1/|∇g|².
    pub(super) inverse_square: Numbers,
    /// |∇g|².
    pub(super) square: Numbers,
    /// λ as a displacement over ∇g, a guess or 0 at first.
    pub(super) multiplier: Numbers,
    /// pᵀ∇²g p.
    pub(super) bend: Numbers,
    /// The square of the rounding of the place.
    pub(super) floor_square: Numbers,
    pub(super) path_square: Numbers,
    /// The first correction, and g, ∇g·∇g(q), and one over that, where it was made.
    pub(super) first: Numbers,
    pub(super) g: Numbers,
    pub(super) slope: Numbers,
    pub(super) over_slope: Numbers,
    /// 1 where h·κ·|v| ≤ ½; where the root is found; and where it is trusted.
    pub(super) gentle: Numbers,
    pub(super) rests: Numbers,
    pub(super) arrives: Numbers,
}

impl<const D: usize> TileInLanes<D> {
    pub(super) fn new() -> Self {
        let (vectors, numbers) = ([[Fused(0.0); LANES]; D], [Fused(0.0); LANES]);
        Self {
            q: vectors,
            q_low: vectors,
            p: vectors,
            p_low: vectors,
            normal: vectors,
            force: vectors,
            free: vectors,
            next: vectors,
            inverse_square: numbers,
            square: numbers,
            multiplier: numbers,
            bend: numbers,
            floor_square: numbers,
            path_square: numbers,
            first: numbers,
            g: numbers,
            slope: numbers,
            over_slope: numbers,
            gentle: numbers,
            rests: numbers,
            arrives: numbers,
        }
    }
}
