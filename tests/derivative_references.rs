//! Value, gradient and Hessian · v of every ready-made surface against 40-digit references.
//!
//! Each number is the sum of a few dozen terms, each rounded. An error counts in half-ulps of the largest
//! number in the row, at least of 1: near a surface the value is nearly nothing, and what its terms
//! were before they cancelled shows in the slopes. Run with `--nocapture` for how the errors are distributed.

use nalgebra::vector;
use rattle::prelude::*;
use rattle::surfaces::*;

constraint! {
    /// Functions that no surface of the catalogue has.
    pub struct Functions {}
    |x, y, z| erf(x * y) + ln(1 + z^2) * atan(y) - asinh(x) * tanh(z) + x^2 * sqrt(1 + x * x)
}

const TABLE: &str = include_str!("data/derivative_references.csv");

/// In half-ulps of the largest number in the row: terms are a few times as large as that, and a few of their
/// roundings do not average out.
const BOUND: f64 = 8.0;

/// How many errors are up to 1, 2, 4 and 8 half-ulps.
type Histogram = [usize; 4];

fn rows(name: &str) -> Vec<[f64; 13]> {
    let lines = TABLE.lines().filter_map(|line| line.split_once(',')).filter(|(own, _)| *own == name);
    let numbers =
        |rest: &str| rest.split(',').map(|text| text.parse().expect("a number")).collect::<Vec<f64>>();
    lines.map(|(_, rest)| numbers(rest).try_into().expect("a row of 13")).collect()
}

#[track_caller]
fn check(
    name: &'static str,
    g: impl Constraint<3, 1>,
    _known: Option<[f64; 3]>,
) -> (&'static str, Histogram) {
    let mut histogram = Histogram::default();
    let (mut near, mut all) = (0, 0);
    for row in rows(name) {
        let (q, v) = (vector![row[0], row[1], row[2]], vector![row[3], row[4], row[5]]);
        let (value, jacobian) = g.value_and_jacobian(&q);
        let products = g.hessian_vector(&q, &v);
        let found = value.iter().chain(jacobian.iter()).chain(products.iter());
        let size = row[6..].iter().fold(1.0_f64, |size, x| size.max(x.abs()));
        for (found, expected) in found.zip(&row[6..]) {
            let ulps = (found - expected).abs() / (0.5 * f64::EPSILON * size);
            assert!(ulps <= BOUND, "{name} at {:?}: {found} is not {expected}, {ulps} half-ulps", &row[..3]);
            histogram[ulps.max(1.0).log2().ceil() as usize] += 1;
        }
        near += usize::from(row[6].abs() <= 1e-14 * size);
        all += 1;
    }
    assert!(all >= 12 && near >= 4, "{name} has {all} rows, {near} of them next to the surface");
    (name, histogram)
}

#[test]
fn forty_digits() {
    let mut found = catalogue!(check).to_vec();
    found.push(check("SupersphereOfSevenHalves", Supersphere { r: 1.0, q: 3.5 }, None));
    found.push(check("Functions", Functions {}, None));
    let total =
        found.iter().fold(Histogram::default(), |sum, (_, own)| std::array::from_fn(|k| sum[k] + own[k]));
    assert_eq!(
        total.iter().sum::<usize>(),
        7 * (TABLE.lines().count() - 2),
        "every row belongs to a surface"
    );
    println!("half-ulps of the largest number, up to 1, 2, 4, 8: {total:?}");
    assert!(total[0] * 10 >= total.iter().sum::<usize>() * 9, "most are as good as rounded once: {total:?}");
}

/// A surface that is new has to be named here: in the catalogue of the tests, and so in the table.
#[test]
fn no_surface_is_left_out() {
    let text = include_str!("../src/surfaces.rs");
    let structs = text.lines().filter_map(|line| line.trim().strip_prefix("pub struct "));
    let written: Vec<&str> = structs.filter_map(|rest| rest.split(' ').next()).collect();
    let checked = catalogue!(check).map(|(name, _)| name);
    assert_eq!(written, checked, "in the order of the source");
    assert!(written.len() >= 40);
}
