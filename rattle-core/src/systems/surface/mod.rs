//! Bodies each on a surface of its own, g(q) = 0: one equation per body, solved in closed form up to one number.
//!
//! Generic over the scalar, so that several trajectories can go side by side in lanes. Only
//! [`Scene::lanes`](crate::scene::Scene::lanes) the tests, and lanes that are moved by themselves make use of that: an
//! ensemble's lanes have [a step of their own](crate::run::ensemble), and so have bodies in tiles. Masses are 1.

mod around;
pub(crate) mod collocation;
mod crowd;
pub(crate) mod diagnosis;
pub(crate) mod equation;
mod hold;
pub(crate) mod kept;
mod landing;
pub(crate) mod normal;
mod passage;
pub(crate) mod position;
mod room;
mod series;
mod sheets;
mod start;
pub(crate) mod step;
mod system;
mod tile;
pub(crate) mod tiles;

pub use kept::{Kept, OnSurface, OneByOne};
pub use normal::Normal;
