//! Value, gradient and Hessian · v against 40-digit references.
//!
//! Each number is the sum of a few dozen terms, each rounded; the bound is 8 half-ulps of the largest
//! number in the row. Run with `--nocapture` for how the errors are distributed.

use nalgebra::vector;
use rattle::prelude::*;
use rattle::surfaces::*;

constraint! {
    /// Functions that no surface of the catalogue has.
    pub struct Functions {}
    |x, y, z| erf(x * y) + ln(1 + z^2) * atan(y) - asinh(x) * tanh(z) + x^2 * sqrt(1 + x * x)
}

fn numbers(line: &str) -> Vec<f64> {
    line.split(',').skip(1).map(|text| text.parse().expect("a number")).collect()
}

/// The results for a row, in its order.
fn results(g: impl Constraint<3, 1>, row: &[f64]) -> Vec<f64> {
    let (q, v) = (vector![row[0], row[1], row[2]], vector![row[3], row[4], row[5]]);
    let (value, jacobian) = g.value_and_jacobian(&q);
    let products = g.hessian_vector(&q, &v);
    value.iter().chain(jacobian.iter()).chain(products.iter()).copied().collect()
}

#[test]
fn forty_digits() {
    let table = include_str!("data/derivative_references.csv");
    let mut histogram = [0; 5];
    let mut rows = 0;
    for line in table.lines().filter(|line| !line.starts_with(['#', 's'])) {
        let row = numbers(line);
        let name = line.split(',').next().unwrap_or_default();
        let found = match name {
            "Lemniscate" => results(Lemniscate { a: 1.0, r: 0.125 }, &row),
            "Torus" => results(Torus { major: 1.5, minor: 0.5 }, &row),
            "TorusByDistance" => results(TorusByDistance { major: 1.5, minor: 0.5 }, &row),
            "Ellipsoid" => results(Ellipsoid { a: 1.0, b: 1.5, c: 0.5 }, &row),
            "Gyroid" => results(Gyroid { k: 1.0, epsilon: 0.0 }, &row),
            "Diamond" => results(Diamond { k: 1.0, epsilon: 0.0 }, &row),
            "BarthSextic" => results(BarthSextic { w: 1.0 }, &row),
            "Clebsch" => results(Clebsch {}, &row),
            "Heart" => results(Heart {}, &row),
            "Metaballs" => results(Metaballs { c: 1.0, level: 2.0 }, &row),
            "Catenoid" => results(Catenoid { a: 0.5 }, &row),
            "Helicoid" => results(Helicoid { c: 0.5 }, &row),
            "Scherk" => results(Scherk {}, &row),
            "Supersphere" => results(Supersphere { r: 1.0, q: 3.5 }, &row),
            "Functions" => results(Functions {}, &row),
            other => panic!("{other} has references, but no row here"),
        };
        rows += 1;
        let size = row[6..].iter().fold(1.0_f64, |size, x| size.max(x.abs()));
        assert_eq!(found.len(), 7);
        for (found, expected) in found.iter().zip(&row[6..]) {
            let ulps = (found - expected).abs() / (0.5 * f64::EPSILON * size);
            assert!(ulps <= 8.0, "{name} at {:?}: {found} is not {expected}, {ulps} half-ulps", &row[..3]);
            histogram[(ulps.max(0.5).log2() + 1.0).floor() as usize] += 1;
        }
    }
    assert_eq!(rows, 120);
    println!("half-ulps of the largest number, up to 1, 2, 4, 8: {histogram:?}");
}
