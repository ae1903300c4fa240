//! Random expressions through the macro: the value has the bits of the same expression in Rust, and the
//! generated functions agree with each other. What they compute is held against truth elsewhere.
#![allow(clippy::all, unused_parens, reason = "expressions nobody would write")]

#[rustfmt::skip]
mod rows;

use nalgebra::SVector;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::prelude::*;
use std::f64::consts::PI;

const A: f64 = 1.25;

/// The documented order of multiplications.
fn power(x: f64, n: i32) -> f64 {
    match n {
        _ if n < 0 => 1.0 / power(x, -n),
        1 => x,
        _ if n % 2 == 1 => power(x, n - 1) * x,
        _ => power(x, n / 2) * power(x, n / 2),
    }
}
fn half(x: f64, n: i32) -> f64 {
    if n == 0 { x.sqrt() } else { power(x, n) * x.sqrt() }
}
fn smaller(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}
fn larger(a: f64, b: f64) -> f64 {
    if a < b { b } else { a }
}

fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

fn check(name: &str, g: impl Constraint<3, 1>, by_hand: fn(f64, f64, f64) -> f64) -> usize {
    let mut random = StdRng::seed_from_u64(12);
    let special = [0.0, -0.0, 1.0, -1.0, 1e-310, 1e300, f64::INFINITY, f64::NAN];
    let mut agreed = 0;
    for round in 0..200 {
        let mut q = SVector::<f64, 3>::from_fn(|_, _| random.random_range(-2.0..2.0));
        if round % 4 == 0 {
            q[random.random_range(0..3)] = special[random.random_range(0..special.len())];
        }
        let v = SVector::<f64, 3>::from_fn(|_, _| random.random_range(-1.0..1.0));
        let (value, expected) = (g.value(&q)[0], by_hand(q[0], q[1], q[2]));
        assert!(same(value, expected), "{name} at {q:?}: {value} is not {expected}");
        let (shared, jacobian) = g.value_and_jacobian(&q);
        assert!(same(shared[0], value), "{name}: value_and_jacobian at {q:?}");
        let (products, [hessian], (start, speed, bend)) =
            (g.hessian_vector(&q, &v), g.hessian(&q), g.jet(&q, &v));
        assert!(same(start[0], value), "{name}: jet at {q:?}");
        let size = 1.0 + jacobian.amax() + hessian.amax();
        let finite = jacobian.iter().chain(hessian.iter()).all(|entry| entry.is_finite());
        if round % 4 == 0 || !finite || size > 1e6 {
            continue; // at an edge or a pole, or outside the domain
        }
        agreed += 1;
        let bound = 1e-9 * size * size; // sums of up to a hundred terms below size², and room
        assert!(((jacobian * v)[0] - speed[0]).abs() <= bound, "{name}: ġ at {q:?}");
        assert!(((products * v)[0] - bend[0]).abs() <= bound, "{name}: g̈ at {q:?}");
        assert!((hessian * v - products.transpose()).amax() <= bound, "{name}: ∇²g v at {q:?}");
    }
    agreed
}

#[test]
fn random_expressions() {
    let agreed = rows::check_all();
    assert!(agreed > 60 * 50, "enough of the points are inside the domains: {agreed}");
}
