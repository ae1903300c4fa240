//! Power series of the macros' functions along curves: every function against Cauchy's integral, polynomials exactly.

use crate::common::lanes::Four;
use crate::complex::{Complex, cauchy};
use rattle::bodies::Body;
use rattle::capability::Series;
use rattle::kernel::{Constraint, ConstraintKernel, PairKernel, PairPotential, Potential, PotentialKernel};
use rattle::prelude::*;
use rattle::series::{Order, Products};
use rattle::surfaces::{Lemniscate, Sphere, TorusByDistance};
use rattle::system::Parts;
use rattle::system::System;

/// Coefficients that are compared.
const ORDERS: usize = 14;
/// Where Cauchy's integral is taken: every function below is smooth for three times that.
const RADIUS: f64 = 0.15;

/// A curve with all coefficients other than zero.
fn curve<const D: usize>(start: [f64; D]) -> Vec<[f64; D]> {
    let coefficient = |k: usize, d: usize| 0.6_f64.powi(k as i32) * (1.3 * k as f64 + 2.1 * d as f64).sin();
    (0..ORDERS).map(|k| if k == 0 { start } else { std::array::from_fn(|d| coefficient(k, d)) }).collect()
}

/// The curve at t.
fn at<const D: usize>(curve: &[[f64; D]], t: Complex) -> [Complex; D] {
    curve.iter().rev().fold([Complex(0.0, 0.0); D], |sum, coefficient| {
        std::array::from_fn(|d| sum[d] * t + Complex(coefficient[d], 0.0))
    })
}

/// A function's coefficients, from those of the curve.
trait Step<const D: usize, const E: usize> {
    fn step<const FIRST: bool>(&self, q: &[f64; D], order: &mut Order<'_, f64, FIRST>) -> [f64; E];
}

fn coefficients<const D: usize, const E: usize>(
    blocks: usize,
    curve: &[[f64; D]],
    function: &impl Step<D, E>,
) -> Vec<[f64; E]> {
    let mut products = Products::new(blocks, curve.len());
    let mut found = vec![function.step(&curve[0], &mut products.first())];
    found.extend((1..curve.len()).map(|k| function.step(&curve[k], &mut products.next(k))));
    found
}

struct Gradient<K>(K);
impl<K: PotentialKernel<f64, D>, const D: usize> Step<D, D> for Gradient<K> {
    fn step<const FIRST: bool>(&self, q: &[f64; D], order: &mut Order<'_, f64, FIRST>) -> [f64; D] {
        self.0.gradient_series(q, order)
    }
}

struct Row<K>(K);
impl<K: ConstraintKernel<f64, D, 1>, const D: usize> Step<D, D> for Row<K> {
    fn step<const FIRST: bool>(&self, q: &[f64; D], order: &mut Order<'_, f64, FIRST>) -> [f64; D] {
        let [row] = self.0.jacobian_series(q, order);
        row
    }
}

struct Slope<K>(K);
impl<K: PairKernel<f64>> Step<1, 1> for Slope<K> {
    fn step<const FIRST: bool>(&self, [s]: &[f64; 1], order: &mut Order<'_, f64, FIRST>) -> [f64; 1] {
        [self.0.slope_series(*s, order)]
    }
}

/// The largest difference, each coefficient times RADIUSᵏ, over the largest value on the circle; and how many of the
/// coefficients beyond the first are seen at all.
fn compare<const E: usize>(found: &[[f64; E]], expected: &[[f64; E]], size: f64) -> (f64, usize) {
    let (mut worst, mut seen) = (0.0_f64, 0);
    for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
        for (found, expected) in found.iter().zip(expected) {
            let off = (found * RADIUS.powi(k as i32) - expected).abs() / size;
            worst = if off.is_nan() { f64::INFINITY } else { worst.max(off) };
            seen += usize::from(k > 0 && expected.abs() > 1e-13 * size);
        }
    }
    (worst, seen)
}

fn size<const E: usize>(values: impl Fn(Complex) -> [Complex; E]) -> f64 {
    let sizes = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.7, 0.7)].map(|(x, y)| {
        let values = values(Complex(RADIUS * x, RADIUS * y));
        values.iter().map(|value| value.0.hypot(value.1)).fold(0.0, f64::max)
    });
    sizes.into_iter().fold(0.0, f64::max)
}

fn of_potential<P: Potential<D>, const D: usize>(potential: &P, start: [f64; D]) -> (f64, usize) {
    let (plain, complex) = (potential.kernel::<f64>(), potential.kernel::<Complex>());
    let blocks = plain.series().unwrap();
    let curve = curve(start);
    let values = |t| complex.gradient(&at(&curve, t));
    let found = coefficients(blocks, &curve, &Gradient(plain));
    compare(&found, &cauchy(ORDERS, RADIUS, values), size(values))
}

/// Each function in a potential of three variables: its derivatives are in the gradient.
macro_rules! functions {
    ($($name:ident: $expression:expr;)*) => {
        $(mod $name {
            rattle::potential! {
                pub(super) struct Hill { c }
                |x, y, z| $expression + 0 * y * z * c
            }
        })*

        #[test]
        fn every_function_of_the_language() {
            let mut wrong = Vec::new();
            $({
                let (off, seen) = of_potential(&$name::Hill { c: 0.7 }, [0.6, 0.9, 0.4]);
                println!("{:20} {off:.1e} {seen}", stringify!($name));
                assert!(seen > 9, "{} has coefficients: {seen}", stringify!($name));
                // Some ten roundings of the values on the circle.
                if off > 2e-15 {
                    wrong.push((stringify!($name), off));
                }
            })*
            assert!(wrong.is_empty(), "{wrong:?}");
        }
    };
}
functions! {
    product: x * (x + 1) * z * y;
    quotient: x / (y + 3) + 2 / (x + z);
    by_a_number: x^2 * z / c - (c - x)^3 + c / (z + 2);
    root: sqrt(x + z + 1);
    root_of_cubes: (x + 2)^(5/2);
    cube: cbrt(x + 2) * z;
    cube_of_negative: cbrt(x - 4) * z;
    exponential: exp(x / 2) + exp(-z * y);
    natural: ln(x + 2) * z;
    decimal: x * log10(x + z + 2);
    binary: log2(x + 2) * y;
    sine: sin(2 * x);
    cosine: cos(x + y);
    both: sin(x) * cos(x) + cos(z);
    tangent: tan(x / 3) * z;
    arcsine: asin(x / 4) * z;
    arccosine: acos(x / 4 + z / 9) * y;
    arctangent: atan(x) * z;
    hyperbolic_sine: sinh(x);
    hyperbolic_cosine: cosh(x * z);
    hyperbolic_tangent: x * tanh(x) * z;
    area_sine: asinh(x) * z;
    area_cosine: acosh(x + 3) * z;
    area_tangent: atanh(x / 4) * y;
    error: erf(x) * z;
    power: (x + 2)^1.7 * z;
    power_of_a_parameter: (x + 2)^c * z;
    variable_power: (x + 2)^(y / 3);
    variable_base: 2^(z / 3 + x) + c^x;
    integer_power: x^5 - (x + 2)^(-3) / 100;
    angle: atan2(x, y + 3) * z;
    angle_to_a_number: atan2(x, c) * z;
    length: hypot(x, y + 1) * z;
    length_to_a_number: hypot(c, y) * z;
    absolute: abs(x) * x * abs(y - 5) * z^2;
    smaller: min(x^2, y + 9) * z + max(x, -5) * x * z;
    choice: if x < c * 9 { x^2 * z * y } else { x };
    other_choice: if x * z >= 5 { x^2 } else { x * z^2 * y };
    sign_of: sign(x) * x^3 * sign(y - 5) * z^2;
    whole: (floor(x / 9 + 1/2) + x) * y + (z - 9 * floor(z / 9 - 1/2)) * z^2;
}

pair_potential! {
    /// Even and odd in r.
    struct Bond { depth, width }
    |r| depth * exp(-(r / width)^2) - depth / r
}

#[test]
fn slopes_and_jacobians() {
    let (bond, start) = (Bond { depth: 0.7, width: 1.3 }, curve([1.2]));
    let (plain, complex) = (bond.kernel::<f64>(), bond.kernel::<Complex>());
    let blocks = plain.series().unwrap();
    let values = |t| [complex.slope(at(&start, t)[0])];
    let found = coefficients(blocks, &start, &Slope(plain));
    let (off, seen) = compare(&found, &cauchy(ORDERS, RADIUS, values), size(values));
    assert!(off < 2e-15 && seen > 9, "{off:e}, {seen}");

    let (torus, start) = (TorusByDistance { major: 1.0, minor: 0.3 }, curve([0.7, 0.9, 0.2]));
    let (plain, complex) = (torus.kernel::<f64>(), torus.kernel::<Complex>());
    let blocks = plain.series().unwrap();
    let values = |t| complex.jacobian(&at(&start, t))[0];
    let found = coefficients(blocks, &start, &Row(plain));
    let (off, seen) = compare(&found, &cauchy(ORDERS, RADIUS, values), size(values));
    assert!(off < 2e-15 && seen > 30, "{off:e}, {seen}");
}

/// Products of polynomials of t, up to the orders that are looked at.
fn times(a: &[i64], b: &[i64]) -> Vec<i64> {
    (0..a.len()).map(|k| (0..=k).map(|j| a[j] * b[k - j]).sum()).collect()
}

fn plus(a: &[i64], factor: i64, b: &[i64]) -> Vec<i64> {
    a.iter().zip(b).map(|(a, b)| a + factor * b).collect()
}

/// Along a curve of whole numbers all coefficients are whole numbers, and below 2⁵³ nothing is rounded.
#[test]
fn polynomials_are_exact() {
    let curve: [[i64; 3]; 8] =
        [[2, -1, 3], [1, 4, -2], [-3, 1, 5], [0, 2, 1], [5, -1, 0], [-2, 3, -4], [1, 1, 1], [-1, 2, 7]];
    let [x, y, z] = std::array::from_fn(|d| curve.map(|q| q[d]).to_vec());
    let (xx, yy) = (times(&x, &x), times(&y, &y));
    let (sum, difference) = (plus(&xx, 1, &yy), plus(&xx, -1, &yy));
    let f = plus(&times(&sum, &sum), -9, &difference); // a = 3
    let one = [1, 0, 0, 0, 0, 0, 0, 0];
    let by_x = times(&times(&f, &x), &plus(&sum.iter().map(|s| 8 * s).collect::<Vec<_>>(), -36, &one));
    let by_y = times(&times(&f, &y), &plus(&sum.iter().map(|s| 8 * s).collect::<Vec<_>>(), 36, &one));
    let expected: Vec<[f64; 3]> =
        (0..8).map(|k| [by_x[k] as f64, by_y[k] as f64, 2.0 * z[k] as f64]).collect();
    assert!(by_x.iter().all(|c| c.abs() < 1 << 48 && *c != 0), "all seen, none rounded");

    let lemniscate = Lemniscate { a: 3.0, r: 0.1 };
    let kernel = lemniscate.kernel::<f64>();
    let blocks = kernel.series().unwrap();
    let curve: Vec<[f64; 3]> = curve.iter().map(|q| q.map(|q| q as f64)).collect();
    assert_eq!(coefficients(blocks, &curve, &Row(kernel)), expected);
}

/// Where a function has no series, that is never a wrong number.
#[test]
fn where_there_is_no_series_coefficients_are_none() {
    potential! { struct Kinked {} |x| x * abs(x)^3 }
    potential! { struct Rooted {} |x| x * sqrt(x) }
    potential! { struct Cubed {} |x| x^2 * cbrt(x) }
    potential! { struct Raised {} |x| x^2.5001 }
    potential! { struct Logged {} |x| x * ln(x) }
    potential! { struct Chosen {} |x| if x < 1 { x^2 } else { x } }
    fn gradient<P: Potential<1>>(potential: &P, curve: &[[f64; 1]]) -> Vec<[f64; 1]> {
        let kernel = potential.kernel::<f64>();
        coefficients(kernel.series().unwrap(), curve, &Gradient(kernel))
    }
    let through = [[0.0], [1.0], [0.0], [0.0]];
    let broken = |found: Vec<[f64; 1]>| found.iter().any(|[c]| !c.is_finite());
    assert!(broken(gradient(&Kinked {}, &through)));
    assert!(broken(gradient(&Rooted {}, &through)));
    assert!(broken(gradient(&Cubed {}, &through)));
    assert!(broken(gradient(&Raised {}, &through)));
    assert!(broken(gradient(&Logged {}, &through)));
    assert!(broken(gradient(&Chosen {}, &[[1.0], [0.5], [0.0], [0.0]])));
    // Not where the choice stays as it is, and on either side.
    assert_eq!(gradient(&Kinked {}, &[[0.0]; 4]), [[0.0]; 4]);
    assert_eq!(gradient(&Chosen {}, &[[0.9], [0.5], [0.0], [0.0]]), [[1.8], [1.0], [0.0], [0.0]]);
    assert_eq!(gradient(&Chosen {}, &[[1.1], [0.5], [0.0], [0.0]]), [[1.0], [0.0], [0.0], [0.0]]);
    assert_eq!(gradient(&Kinked {}, &[[-1.0], [1.0], [0.0], [0.0]]), [[4.0], [-12.0], [12.0], [-4.0]]);
}

/// The motion on a unit sphere is q₀ cos t + v₀ sin t, and λ = −½ there; its coefficients are known.
#[test]
fn great_circles() {
    const LAST: usize = 20;
    let scene = Scene::on(Sphere { r: 1.0 });
    let (q, v) = ([0.6, 0.0, 0.8], [0.0, 1.0, 0.0]);
    let system = scene.system::<f64>();
    let start = Body { q, q_low: [0.0; 3], p: v, p_low: [0.0; 3] };
    let mut bodies = system.bodies(&[start], 0.0);
    system.reserve_series(&mut bodies, LAST + 1, 1.0);
    let mut series = vec![[0.0; 3]; LAST + 1];
    system.expand(&mut bodies, &mut series, &mut ());
    let (mut factorial, mut sign) = (1.0, 1.0);
    for (k, found) in series.iter().enumerate() {
        let of = if k % 2 == 0 { q } else { v };
        for (found, of) in found.iter().zip(of) {
            // λ is a sum of products of three (n·v, with v from λ n), which cancel: Σ 1/(i! j! l!) = 3ᵏ/k! together.
            let rounding = f64::EPSILON * 3_f64.powi(k as i32) / factorial;
            let expected = sign * of / factorial;
            assert!((found - expected).abs() <= rounding, "{k}: {found:e}, {expected:e}");
        }
        factorial *= (k + 1) as f64;
        sign = if k % 2 == 0 { sign } else { -sign };
    }
}

/// Lanes go their own ways, also where choices differ.
#[test]
fn lanes_have_series_of_their_own() {
    potential! { struct Hill {} |x, y, z| if x < 1 { exp(x * y) } else { sin(x) / z } }
    let starts = [[0.6, 0.9, 0.4], [1.6, 0.9, 0.4], [-0.6, 0.2, 0.1], [2.0, 0.0, 1.0]];
    let blocks = Hill {}.kernel::<f64>().series().unwrap();
    let curves = starts.map(curve);
    let alone = curves.each_ref().map(|curve| coefficients(blocks, curve, &Gradient(Hill {}.kernel())));
    let kernel = Hill {}.kernel::<Four>();
    let mut products = Products::new(blocks, ORDERS);
    for k in 0..ORDERS {
        let q = std::array::from_fn(|d| Four(std::array::from_fn(|lane| curves[lane][k][d])));
        let found: [Four; 3] = match k {
            0 => kernel.gradient_series(&q, &mut products.first()),
            _ => kernel.gradient_series(&q, &mut products.next(k)),
        };
        for (lane, alone) in alone.iter().enumerate() {
            assert_eq!(found.map(|x| x.0[lane]), alone[k], "order {k}, lane {lane}");
        }
    }
}
