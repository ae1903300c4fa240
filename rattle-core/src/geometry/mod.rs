//! Curvature of constraints, and integrals over closed ones.

pub mod curvature;
pub mod integral;

pub use curvature::Curvature;
pub use integral::{IntegralError, Measure, integrate, measure};
