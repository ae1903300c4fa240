//! Overland flow: water running over land against friction, with an exact water budget and no negative depth.
//!
//! ```text
//! ∂h/∂t + ∇·q = rain − infiltration,    q = −c hᵅ ∇(b + h) / √|∇(b + h)|
//!
//! Darcy and Weisbach    α = 3/2, c = √(g/k)            Gauckler and Manning    α = 5/3, c = 1/n
//! ```
//!
//! This is the diffusive wave approximation: the shallow-water equations without inertia. The depth h(x, t) over the
//! ground b(x) has a front that moves with finite speed, since the flux vanishes with h. A [`Flow`] has the terrain,
//! friction and sources, a [`Simulation`] computes it in time, and a [`Budget`] adds up the volumes. There are two
//! methods:
//!
//! * [`Conservative`], the default: upwinded control volumes. Volume is conserved to rounding, depths are never
//!   negative without being clamped, and lakes stay at rest.
//! * [`Notebook`], for comparison: the finite elements and the active set of a published notebook. Its volume grows.
//!
//! ```
//! use rattle_flow::{Flow, Mesh, Resistance};
//!
//! let basin = [[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [0.0, 1.0]];
//! let mesh = Mesh::polygon(&basin, 0.25)?;
//! let dry = vec![0.0; mesh.points().len()];
//! let flow = Flow::over(mesh, Resistance::Manning)
//!     .terrain(|[x, _]| 0.05 * x)
//!     .friction(|_| 0.1)
//!     .rain(|_, t| if t <= 60.0 { 1e-4 } else { 0.0 })
//!     .outlet(0.05, |[x, _]| x < 1e-9);
//! let mut simulation = flow.simulate(dry, 1.0)?;
//! simulation.run(120)?;
//! let budget = simulation.budget();
//! assert!((budget.rain - 4.0 * 60.0 * 1e-4).abs() < 1e-12);
//! assert!(budget.outflow > 0.5 * budget.rain && budget.remainder().abs() < 1e-14);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The elements are written as formulas with [`residual!`]: see [`law`].

mod blocks;
mod budget;
mod clock;
mod conservative;
pub mod dam_break;
mod error;
mod flow;
#[cfg(feature = "geotiff")]
mod geotiff;
mod gmsh;
mod krylov;
pub mod law;
mod mesh;
mod method;
mod multigrid;
mod notebook;
mod outline;
mod overlap;
mod page;
mod pieces;
mod plane;
mod polygon;
mod project;
mod raster;
mod read;
mod rows;
mod simulation;
mod sources;
mod sparse;
pub mod vtu;

pub use budget::Budget;
pub use conservative::{Conservative, Settings};
pub use error::{FlowError, MeshError};
pub use flow::{Flow, Resistance};
pub use mesh::Mesh;
pub use method::{Method, StepInfo, Trouble};
pub use notebook::Notebook;
pub use page::Page;
pub use raster::Raster;
pub use rattle_macros::residual;
pub use read::ReadError;
pub use simulation::Simulation;
