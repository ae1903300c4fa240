//! Every ready-made surface: derivatives against differences, a known point, and that it is a surface.

use crate::common::lanes::Four;
use nalgebra::{SMatrix, SVector, vector};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::constraint;
use rattle::kernel::*;
use rattle::real::Real;
use rattle::surfaces::*;
use std::array::from_fn;

type Point = SVector<f64, 3>;

/// (4 D(h/2) − D(h)) / 3 of central differences: h⁴/480 times a fifth derivative, and rounding eps/h.
fn difference(f: impl Fn(&Point) -> f64, q: &Point, k: usize) -> f64 {
    let central = |h: f64| {
        let (mut ahead, mut behind) = (*q, *q);
        ahead[k] += h;
        behind[k] -= h;
        (f(&ahead) - f(&behind)) / (2.0 * h)
    };
    (4.0 * central(1.0 / 4096.0) - central(1.0 / 2048.0)) / 3.0
}

#[track_caller]
fn check(name: &str, g: impl Constraint<3, 1>, known: Option<[f64; 3]>) {
    if let Some(point) = known {
        let value = g.value(&point.into())[0];
        assert!(value.abs() <= 4.0 * f64::EPSILON, "{name} passes through {point:?}: {value}");
    }
    let mut generator = StdRng::seed_from_u64(11);
    let (mut reached, mut agreed) = (0, 0);
    for _ in 0..200 {
        // A random point, then Newton's method along the gradient: the surface is there.
        let mut q = Point::from_fn(|_, _| generator.random_range(-1.5..1.5));
        let v = Point::from_fn(|_, _| generator.random_range(-1.0..1.0));
        let (jacobian, products) = (g.jacobian(&q), g.hessian_vector(&q, &v));
        let size = 1.0 + g.value(&q)[0].abs() + jacobian.amax() + products.amax();
        let smooth = (0..3).all(|k| {
            let slope = difference(|q| g.value(q)[0], &q, k);
            let second: f64 = (0..3).map(|j| v[j] * difference(|q| g.jacobian(q)[k], &q, j)).sum();
            (slope - jacobian[k]).abs() <= 1e-7 * size && (second - products[k]).abs() <= 1e-6 * size
        });
        agreed += usize::from(smooth);
        for _ in 0..60 {
            let (value, jacobian) = g.value_and_jacobian(&q);
            q -= jacobian.transpose() * (value[0] / jacobian.norm_squared());
        }
        let (value, jacobian) = g.value_and_jacobian(&q);
        reached += usize::from(value[0].abs() <= 1e-9 && jacobian.norm() > 1e-6);
    }
    // A few points may lie at a kink or a pole, or leave along an asymptote.
    assert!(agreed >= 190, "{name}: derivatives agree with differences at {agreed} of 200 points");
    assert!(reached >= 100, "{name}: Newton's method finds the surface from {reached} of 200 points");
}

#[test]
fn catalogue() {
    catalogue!(check);
}

/// Over `f32`: as good as single precision allows.
///
/// The error is at most 16 eps·s (8 are exceeded), where s is the largest of g, G and the terms that cancel in
/// them, which 8 covers.
#[test]
fn single_precision() {
    catalogue!(check_single);
}

#[track_caller]
fn check_single(name: &str, g: impl Constraint<3, 1>, _known: Option<[f64; 3]>) {
    let (single, double) = (g.kernel::<f32>(), g.kernel::<f64>());
    let mut generator = StdRng::seed_from_u64(12);
    let mut differing = 0;
    for _ in 0..500 {
        let q: [f32; 3] = from_fn(|_| generator.random_range(-1.5..1.5));
        let (value, [row]) = single.value_and_jacobian(&q);
        let (exact, [slope]) = double.value_and_jacobian(&q.map(f64::from));
        assert_eq!(value, single.value(&q), "{name}: one value");
        assert_eq!([row], single.jacobian(&q), "{name}: one jacobian");
        let found = [value[0], row[0], row[1], row[2]].map(f64::from);
        let expected = [exact[0], slope[0], slope[1], slope[2]];
        let size = expected.iter().fold(8.0, |size: f64, x| size.max(x.abs()));
        for (found, expected) in found.into_iter().zip(expected) {
            let error = (found - expected).abs();
            assert!(
                error <= 16.0 * f64::from(f32::EPSILON) * size,
                "{name} at {q:?}: {found}, expected {expected}"
            );
            differing += usize::from(error > 0.0);
        }
    }
    assert!(name == "Plane" || differing > 0, "{name}: these are other numbers");
}

/// Over four lanes: each is bit for bit the result over `f64`.
#[test]
fn lanes() {
    catalogue!(check_lanes);
    check_lanes("Kinked", Kinked { r: 1.0 }, None);
}

constraint! {
    /// Everything that is not smooth, tied on purpose.
    struct Kinked { r }
    |x, y, z| {
        let branch = if x < y && y <= z || z > r { x * y } else if x >= 0 { sqrt(x^2) } else { -z };
        let root = if y >= 0 { sqrt(y) * y } else { cbrt(z) };
        min(x, y, z) * max(x, r) + abs(z - x) + sign(y) * z + branch + root + norm(x, y, z) + atan2(y, x) + hypot(y, z)
    }
}

#[track_caller]
fn check_lanes(name: &str, g: impl Constraint<3, 1>, _known: Option<[f64; 3]>) {
    // Zeros of both signs, ties between coordinates, and where the branches change.
    const SPECIAL: [f64; 8] = [0.0, -0.0, 1.0, -1.0, 0.5, 1.5, 1e-300, f64::NAN];
    let (alone, together) = (g.kernel::<f64>(), g.kernel::<Four>());
    let mut generator = StdRng::seed_from_u64(13);
    let mut number = |point: usize| match point % 2 {
        0 => generator.random_range(-2.0..2.0),
        _ => SPECIAL[generator.random_range(0..SPECIAL.len())],
    };
    let (mut finite, mut different) = (0, 0);
    for point in 0..400 {
        let q: [[f64; 3]; 4] = from_fn(|lane| from_fn(|_| number(point + lane)));
        let v: [[f64; 3]; 4] = from_fn(|_| from_fn(|_| number(0)));
        let across = |rows: &[[f64; 3]; 4]| from_fn(|k| Four(from_fn(|lane| rows[lane][k])));
        let (lanes_q, lanes_v) = (across(&q), across(&v));
        let found = everything(&together, &lanes_q, &lanes_v);
        let expected = q.iter().zip(&v).map(|(q, v)| everything(&alone, q, v));
        for (lane, expected) in expected.enumerate() {
            for (found, expected) in found.iter().zip(expected) {
                let same = found.0[lane].to_bits() == expected.to_bits()
                    || (found.0[lane].is_nan() && expected.is_nan());
                assert!(same, "{name}, lane {lane} of {q:?}: {}, alone {expected}", found.0[lane]);
                finite += usize::from(expected.is_finite());
            }
        }
        different += usize::from(found[0].0[0].to_bits() != found[0].0[2].to_bits());
    }
    assert!(finite > 10_000 && different > 100, "{name}: {finite} {different}");
}

/// All results of a kernel, in a row.
fn everything<T: Real>(g: &impl ConstraintKernel<T, 3, 1>, q: &[T; 3], v: &[T; 3]) -> Vec<T> {
    let [value] = g.value(q);
    let ([shared], [row]) = g.value_and_jacobian(q);
    let ([product], [jacobian]) = (g.hessian_vector(q, v), g.jacobian(q));
    let ([g0], [g1], [g2]) = g.jet(q, v);
    let weighted = g.weighted_hessian_vector(q, &[v[0]], v);
    let [hessian] = g.hessian(q);
    let numbers = [value, shared, g0, g1, g2];
    numbers.into_iter().chain([row, product, jacobian, weighted].concat()).chain(hessian.concat()).collect()
}

/// The pieces of a surface that is put together meet with their slopes.
#[test]
fn pieces_meet() {
    let bump = GaussianBump { a: 0.5, l: 0.5, inner: 1.0, outer: 1.5 };
    for radius in [1.0_f64, 1.5] {
        let at = |x: f64| bump.value_and_jacobian(&vector![x, 0.0, 0.0]);
        let ((below, slope_below), (above, slope_above)) = (at(radius.next_down()), at(radius.next_up()));
        assert!((below[0] - above[0]).abs() <= 1e-15, "{below} {above}");
        assert!((slope_below - slope_above).amax() <= 1e-14, "{slope_below} {slope_above}");
    }
}

/// The parts of the thylakoid as LAMMPS has them, each along its seam: bridge, flare, face, edge, side, back.
#[test]
fn parts_of_the_thylakoid_meet() {
    let thylakoid = Thylakoid { width: 3.0, length: 10.0, flare: 3.0 };
    let on = [
        // A point on the surface, and its outward normal.
        ([0.0, 1.5, 0.0], [0.0, 1.0, 0.0]),                 // bridge
        ([5.0, 0.0, -1.5], [0.0, 0.0, -1.0]),               // where the flare begins
        ([6.8, 4.5 - 2.4, 0.0], [-0.6, 0.8, 0.0]),          // on it, 3, 4, 5
        ([8.0, 4.5, 0.0], [-1.0, 0.0, 0.0]),                // where it ends in the face
        ([8.0, 7.5, 20.0], [-1.0, 0.0, 0.0]),               // where an edge begins
        ([11.0 - 1.8, -7.5 - 2.4, 3.0], [-0.6, -0.8, 0.0]), // on it
        ([11.0, -10.5, 3.0], [0.0, -1.0, 0.0]),             // where it ends in a side
        ([26.0, 10.5, 3.0], [0.0, 1.0, 0.0]),               // the side's other end
        ([26.0 + 1.8, 7.5 + 2.4, 3.0], [0.6, 0.8, 0.0]),    // an edge of the back
        ([29.0, 0.0, 0.0], [1.0, 0.0, 0.0]),                // the back, behind the mouth
        ([29.0, 7.5, 0.0], [1.0, 0.0, 0.0]),
    ];
    for (point, normal) in on {
        for mirror in [1.0, -1.0] {
            let [x, y, z] = point;
            let (q, n) = (vector![mirror * x, y, z], vector![mirror * normal[0], normal[1], normal[2]]);
            // On all sides of the seam; curvature is at most 1/1.5, so the normal turns by less than 1e-8.
            for offset in
                [[0.0; 3], [1e-9, 1e-9, 1e-9], [-1e-9, 1e-9, -1e-9], [1e-9, -1e-9, -1e-9], [-1e-9; 3]]
            {
                let offset = vector![offset[0], offset[1], offset[2]];
                let (value, slope) = thylakoid.value_and_jacobian(&(q + offset));
                assert!((value[0] - n.dot(&offset)).abs() <= 2e-14, "{q}: {value}");
                assert!((slope.transpose() - n).amax() <= 1e-8, "{q}: {slope}");
            }
        }
    }
    // No other surface and no jump hides inside the stacks or between them: g is a continuous function.
    let mut generator = StdRng::seed_from_u64(5);
    for _ in 0..20_000 {
        let q =
            Point::from_fn(|_, _| generator.random_range(-32.0..32.0)).component_mul(&vector![1.0, 0.4, 0.4]);
        let step = Point::from_fn(|_, _| generator.random_range(-0.2..0.2));
        let change = thylakoid.value(&(q + step))[0] - thylakoid.value(&q)[0];
        assert!(change.abs() <= step.norm() * (1.0 + 1e-12), "{q} {step}: {change}");
    }
}

/// Poles and axes, where a piece of the formula has no derivative but the surface does.
#[test]
fn second_derivatives_at_poles() {
    let bump = GaussianBump { a: 1.0, l: 1.0, inner: 1.0, outer: 2.0 };
    let [hessian] = bump.hessian(&vector![0.0, 0.0, 1.0]);
    assert!((hessian - SMatrix::from_diagonal(&vector![1.0, 1.0, 0.0])).amax() < 1e-15, "{hessian}");

    let sphere = Superellipsoid { a: 1.0, b: 1.0, c: 1.0, n: 2.0, m: 2.0 };
    for pole in
        [vector![0.0, 0.0, 1.0], vector![1e-200, 0.0, 1.0], vector![1.0, 0.0, 0.0], vector![0.6, 0.8, 0.0]]
    {
        let [hessian] = sphere.hessian(&pole);
        assert!((hessian - SMatrix::identity() * 2.0).amax() < 1e-14, "{pole} {hessian}");
        let bend = sphere.jet(&pole, &vector![0.3, 0.4, 0.5]).2[0];
        assert!((bend - 1.0).abs() < 1e-14, "{pole} {bend}");
    }
}

rattle::constraint! {
    /// Even powers of a norm are smooth at the origin.
    struct Norms { n }
    |x, y| 3 * norm(x, y)^2 + exp(-norm(x, y)^2) + (x^2 + y^2)^(n / 2)
}

#[test]
fn even_powers_of_a_norm_are_smooth() {
    let [hessian] = Norms { n: 2.0 }.hessian(&vector![0.0, 0.0]);
    assert!((hessian - SMatrix::<f64, 2, 2>::identity() * 6.0).amax() < 1e-15, "{hessian}");
}
