//! The methods: maps that take bodies one step on. A method knows no system.

pub(crate) mod able;
pub mod baoab;
pub mod bdf2;
pub mod brownian;
mod coefficients;
pub mod composition;
pub mod dop853;
pub mod dop853_table;
pub mod fixed;
pub mod geodesic;
pub mod leapfrog;
pub mod lobatto;
pub mod nose_hoover;
pub mod position_verlet;
pub mod rattle;
pub mod shake;
pub mod symplectic_euler;
pub mod taylor;
pub mod variable;
