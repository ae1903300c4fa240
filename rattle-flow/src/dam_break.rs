//! The idealised dam break with vegetation of Santillana and Dawson (2010), with the geometry and numbers of a notebook
//! by Shapero: an upper basin, a ramp, a lower basin, and three round patches of plants.
//!
//! ```
//! use rattle_flow::dam_break;
//! let mesh = dam_break::mesh(0.5)?;
//! let depth = dam_break::depth(&mesh);
//! let mut simulation = dam_break::flow(mesh).simulate(depth, 1.0 / 32.0)?;
//! simulation.run(32)?;
//! assert!(simulation.budget().remainder().abs() < 1e-13);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! In the end the water rests at the level √15 − 3 = 0.873, which it approaches like 1/t.

use crate::error::MeshError;
use crate::flow::{Flow, Resistance};
use crate::mesh::Mesh;

/// The corners of the two basins and the channel between them.
pub const CORNERS: [[f64; 2]; 12] = [
    [0.0, 0.0],
    [3.0, 0.0],
    [3.0, 2.0],
    [2.0, 2.0],
    [2.0, 4.0],
    [3.0, 4.0],
    [3.0, 6.0],
    [0.0, 6.0],
    [0.0, 4.0],
    [1.0, 4.0],
    [1.0, 2.0],
    [0.0, 2.0],
];

/// The centres of the patches of plants, of radius ½.
pub const PLANTS: [[f64; 2]; 3] = [[1.5, 1.0], [1.0, 3.5], [2.0, 2.5]];

/// A mesh with edges of about this length; the notebook's are 0.125.
///
/// # Errors
/// [`MeshError::Polygon`] for a spacing that is not positive, or too small.
pub fn mesh(spacing: f64) -> Result<Mesh, MeshError> {
    Mesh::polygon(&CORNERS, spacing)
}

/// Water of depth 1 in the upper basin, y ≥ 4: its least-squares projection onto linear functions, clamped to 0 … 1.
pub fn depth(mesh: &Mesh) -> Vec<f64> {
    let nearest = mesh.projected(|[_, y]| if y >= 4.0 { 1.0 } else { 0.0 });
    nearest.into_iter().map(|h| h.clamp(0.0, 1.0)).collect()
}

/// The flow: a ramp from height 0 to 1, and friction k = 1 + 4 ψ with ψ = max(0, 1 − 4r²) at the distance r from the
/// centre of a patch of plants.
pub fn flow(mesh: Mesh) -> Flow {
    Flow::over(mesh, Resistance::DarcyWeisbach { gravity: 1.0 })
        .terrain(|[_, y]| ((y - 2.0) / 2.0).clamp(0.0, 1.0))
        .friction(|[x, y]| {
            let plant = |[a, b]: [f64; 2]| (1.0 - 4.0 * ((x - a).powi(2) + (y - b).powi(2))).max(0.0);
            1.0 + 4.0 * PLANTS.into_iter().map(plant).sum::<f64>()
        })
}
