//! Curvature of constraints, distances along them, integrals over closed ones, and points on them.

pub mod curvature;
pub mod geodesic;
pub mod integral;
pub mod points;

pub use curvature::Curvature;
pub use geodesic::{Geodesic, GeodesicError, geodesic_distance};
pub use integral::{IntegralError, Measure, integrate, measure};
