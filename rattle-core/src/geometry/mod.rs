//! Curvature of constraints, integrals over closed ones, and points on them.

pub mod curvature;
pub mod integral;
pub mod points;

pub use curvature::Curvature;
pub use integral::{IntegralError, Measure, integrate, measure};
