//! Pictures in space: the surface as a mesh, and a web page on which bodies move on it.
//!
//! ```
//! use rattle::view::{Mesh, Page, Scene3};
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("sphere.html");
//! let sphere = |[x, y, z]: [f64; 3]| (x * x + y * y + z * z - 1.0, [2.0 * x, 2.0 * y, 2.0 * z]);
//! let mesh = Mesh::of(sphere, [-1.2; 3], [1.2; 3], 24)?;
//!
//! let times: Vec<f64> = (0..=100).map(|i| 0.1 * f64::from(i)).collect();
//! let equator: Vec<[f64; 3]> = times.iter().map(|t| [t.cos(), t.sin(), 0.0]).collect();
//! let scene = Scene3::new("Equator").surface(&mesh).bodies(&times, &[equator]).trail(50).caption("One free body.");
//! Page::new("Motion on a sphere").scene(scene).write(&path)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod around;
mod density;
mod encode;
mod error;
mod mesh;
mod page;
mod parts;
mod scene;
mod shapes;

pub use error::PageError;
pub use mesh::{Mesh, MeshError, surface};
pub use page::Page;
pub use parts::End;
pub use scene::{Place, Scene3};
