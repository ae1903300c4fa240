//! Geometry of constraint surfaces: curvatures, distances along them, integrals over closed ones, and random points.

mod conjugate;
pub mod curvature;
mod detour;
pub mod geodesic;
pub mod integral;
pub mod points;

pub use curvature::Curvature;
pub use geodesic::{Geodesic, GeodesicError, geodesic_distance};
pub use integral::{IntegralError, Measure, integrate, measure};
