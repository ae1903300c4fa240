//! Systems and reference data that several tests use.
#![allow(dead_code, unused_imports, unreachable_pub, reason = "each test uses its part")]

pub mod lanes;
pub mod linked;
pub mod outcome;
pub mod statistics;
pub mod symplectic;

use rattle::composition::{ALL, Coefficients};
pub use rattle::potentials::planar::Gravity as PlanarGravity;
pub use rattle::potentials::{Gravity, Ricker};
use rattle::prelude::*;
pub use rattle::surfaces::{Lemniscate, Sphere, Torus, TorusByDistance};
use std::collections::HashMap;
use std::f64::consts::FRAC_1_SQRT_2;
use std::io::Write;
use std::path::Path;

constraint! {
    /// A rod of this length about the origin, in the plane.
    pub struct Pendulum { length }
    |x, y| x^2 + y^2 - length^2
}

constraint! {
    /// Two planes at a right angle, with a ridge of this radius between them.
    #[derive(Clone, Copy)]
    pub struct Ridge { s }
    |x, _y, z| z + sqrt(x^2 + s^2)
}

potential! {
    /// Weight in a trough along the x axis.
    pub struct Trough { g }
    |_x, y, z| g * z + y^2 / 4
}

/// The notebook's surface, r = a/6.
pub const SURFACE: Lemniscate = Lemniscate { a: 1.0, r: 1.0 / 6.0 };

/// The notebook's start in the direction θ, in radians.
pub fn billiard(theta: f64) -> State<3> {
    State::at([0.0, 0.0, SURFACE.r]).moving([theta.cos(), theta.sin(), 0.0])
}

/// The start of the `f64` rows at θ = 45°: cos and sin of the rounded angle, rounded.
pub fn billiard_45() -> State<3> {
    State::at([0.0, 0.0, SURFACE.r]).moving([FRAC_1_SQRT_2, FRAC_1_SQRT_2.next_down(), 0.0])
}

/// θ of the notebook's 25 directions, 2π·linspace(0, 1, 25).
pub fn directions() -> impl Iterator<Item = f64> {
    (0..25).map(|i| std::f64::consts::TAU * (f64::from(i) / 24.0))
}

/// A row of a reference table: text by column name.
pub struct Row(HashMap<String, String>);

impl Row {
    pub fn text(&self, column: &str) -> &str {
        &self.0[column]
    }
    pub fn number(&self, column: &str) -> f64 {
        self.text(column).parse().unwrap()
    }
    pub fn numbers<const D: usize>(&self, columns: [&str; D]) -> [f64; D] {
        columns.map(|column| self.number(column))
    }
}

/// The rows of a table in `tests/data`.
pub fn table(name: &str) -> Vec<Row> {
    let file = format!("tests/data/{name}.csv");
    // The package is the workspace's first, or a folder of it.
    let mut above = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().map(|folder| folder.join(&file));
    let path = above.find(|path| path.exists()).unwrap_or_else(|| panic!("no {file}"));
    let rows: Vec<_> =
        csv::Reader::from_path(path).unwrap().deserialize().map(|row| Row(row.unwrap())).collect();
    assert!(!rows.is_empty());
    rows
}

/// Says it to the terminal, also where a test passes, whose prints are kept back.
pub fn say(text: &str) {
    std::io::stderr().write_all(format!("{text}\n").as_bytes()).unwrap();
}

/// The larger number; NaN where one is, which `f64::max` leaves out.
pub fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b <= a { a } else { b }
}

/// maxᵢ |aᵢ − bᵢ|; NaN where a number is.
pub fn distance<const D: usize>(a: impl Into<[f64; D]>, b: impl Into<[f64; D]>) -> f64 {
    a.into().iter().zip(b.into()).map(|(a, b)| (a - b).abs()).fold(0.0, larger)
}

/// Slope of log₂ error under halved steps, by least squares over all of them.
pub fn order(errors: &[f64]) -> f64 {
    let n = errors.len() as f64;
    let mean = (n - 1.0) / 2.0;
    let spread: f64 = (0..errors.len()).map(|i| (i as f64 - mean).powi(2)).sum();
    let slope: f64 = errors.iter().enumerate().map(|(i, error)| (i as f64 - mean) * error.log2()).sum();
    -slope / spread
}

/// The bits of a state, low parts included.
pub fn bits<const D: usize>(state: &State<D>) -> String {
    format!("{state:?}")
}

/// The coefficients with this name of their constant.
pub fn constant(name: &str) -> Coefficients {
    let key = |coefficients: &Coefficients| {
        let plain = coefficients.name.replace(", order ", " order ").replace(['–', ' '], "_");
        plain.to_uppercase()
    };
    *ALL.iter().find(|coefficients| key(coefficients) == name).unwrap_or_else(|| panic!("no constant {name}"))
}
