//! The language beyond scalars: arrays, loops, branches, and the macros of phase space.

use nalgebra::{SMatrix, SVector, matrix, vector};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::kernel::*;
use rattle::prelude::*;

constraint! {
    /// Six equations: QᵀQ = 1.
    pub struct Orthogonal {}
    |m: [[f64; 3]; 3]| for i in 0..3, j in i..3 { sum(k in 0..3, m[k][i] * m[k][j]) - delta(i, j) }
}
constraint! {
    /// A rigid rod.
    pub struct Rod { length }
    |a: [f64; 3], b: [f64; 3]| sum(i in 0..3, (a[i] - b[i])^2) - length^2
}
constraint! {
    /// Two equations from arrays as a whole, and array parameters.
    pub struct Plane { normal: [f64; 3], offset }
    |q: [f64; 3]| [dot(normal, q) - offset, norm(2 * q - normal / 2) - norm(q[0], q[1])]
}
constraint! {
    /// Branches, nested and joined.
    pub struct Branches { c }
    |x, y| [
        if x < 0 { sqrt(-x) + y } else if x <= c && y > 0 || y < -1 { x^2 * y } else { ln(x) },
        min(x, y, c) * max(x * y, x),
        abs(x - y) * hypot(x, y) + atan2(y, x) + pow(x^2 + 1, y),
    ]
}
constraint! {
    /// An index decides at compile time; `..=` includes its end; a constant `let` is an index.
    pub struct Chain {}
    |x: [f64; 4]| {
        let n = 3;
        for i in 0..=n { if i == 0 || i > 100 { x[0] } else { x[i] - x[i - 1] } + product(j in 0..i, x[j]) }
    }
}
constraint! {
    /// Parameters may be called as functions are; a sum over nothing is 0, also of arrays.
    pub struct Triangular { cos, floor }
    |q: [[f64; 2]; 3]| for i in 0..3 {
        let a = q[i] - sum(j in 0..i, q[j]);
        let b = sum(j in i + 1..3, q[j]) - q[i];
        dot(a, a) * (cos - 1) + dot(b, b) - (floor - 0.5)
    }
}
hamiltonian! {
    /// A pendulum in Cartesian coordinates.
    pub struct Pendulum { g }
    |q: [f64; 2], p: [f64; 2]| dot(p, p) / 2 + g * q[1]
}
hamiltonian! {
    /// A charge in a magnetic field: not separable.
    pub struct Charge { b }
    |q: [f64; 2], p: [f64; 2]| ((p[0] + b * q[1])^2 + (p[1] - b * q[0])^2) / 2 + cos(q[0]) * p[1]
}
phase_constraint! {
    /// The sphere of the Hopf fibration.
    pub struct Sphere3 {}
    |q: [f64; 2], p: [f64; 2]| [dot(q, q) + dot(p, p) - 1, q[0] * p[1] - q[1] * p[0]]
}

#[test]
fn sums_over_nothing() {
    let q = [0.3, -0.7, 1.1, 0.2, -0.4, 0.9];
    let g = Triangular { cos: 3.0, floor: 2.5 }.value(&SVector::from(q));
    let at = |i: usize| [q[2 * i], q[2 * i + 1]];
    for i in 0..3 {
        let (mut a, mut b) = (at(i), [0.0; 2]);
        let before = (0..i).fold([0.0; 2], |sum, j| [sum[0] + at(j)[0], sum[1] + at(j)[1]]);
        let after = (i + 1..3).fold([0.0; 2], |sum, j| [sum[0] + at(j)[0], sum[1] + at(j)[1]]);
        for d in 0..2 {
            (a[d], b[d]) = (a[d] - before[d], after[d] - at(i)[d]);
        }
        let by_hand = (a[0] * a[0] + a[1] * a[1]) * 2.0 + (b[0] * b[0] + b[1] * b[1]) - 2.0;
        assert!((g[i] - by_hand).abs() < 1e-15 * 8.0, "{i}: {} {by_hand}", g[i]);
    }
}

#[test]
fn families_of_equations() {
    let mut generator = StdRng::seed_from_u64(5);
    for _ in 0..100 {
        let m = SMatrix::<f64, 3, 3>::from_fn(|_, _| generator.random_range(-1.0..1.0));
        let q = SVector::<f64, 9>::from_iterator(m.transpose().iter().copied()); // row by row
        let (g, jacobian) = Orthogonal {}.value_and_jacobian(&q);
        let mut equation = 0;
        for i in 0..3 {
            for j in i..3 {
                let delta = if i == j { 1.0 } else { 0.0 };
                let by_hand = m[(0, i)] * m[(0, j)] + m[(1, i)] * m[(1, j)] + m[(2, i)] * m[(2, j)] - delta;
                assert_eq!(g[equation], by_hand);
                for (row, k) in (0..9).map(|n| (n / 3, n % 3)) {
                    let mut slope = 0.0;
                    slope += if k == i { m[(row, j)] } else { 0.0 };
                    slope += if k == j { m[(row, i)] } else { 0.0 };
                    assert_eq!(jacobian[(equation, 3 * row + k)], slope);
                }
                equation += 1;
            }
        }
        assert_eq!(equation, 6);
    }
}

#[test]
fn arrays_as_a_whole() {
    let rod = Rod { length: 2.0 };
    let q = vector![1.0, 2.0, 3.0, 0.5, 0.25, 0.125];
    assert_eq!(rod.value(&q)[0], 0.25 + 1.75 * 1.75 + 2.875 * 2.875 - 4.0);
    assert_eq!(rod.jacobian(&q), matrix![1.0, 3.5, 5.75, -1.0, -3.5, -5.75]);
    let plane = Plane { normal: [1.0, 2.0, 2.0], offset: 3.0 };
    let g = plane.value(&vector![0.75, 1.5, 4.0]);
    assert_eq!(g[0], 0.75 + 3.0 + 8.0 - 3.0);
    assert_eq!(g[1], (1.0_f64 + 4.0 + 49.0).sqrt() - (0.75_f64 * 0.75 + 1.5 * 1.5).sqrt());
    assert_eq!(plane.jacobian(&vector![0.75, 1.5, 4.0]).row(0), matrix![1.0, 2.0, 2.0]);
}

fn branches(x: f64, y: f64, c: f64) -> [f64; 3] {
    let smaller = |a: f64, b: f64| if b < a { b } else { a };
    let larger = |a: f64, b: f64| if a < b { b } else { a };
    let first = if x < 0.0 {
        (-x).sqrt() + y
    } else if x <= c && y > 0.0 || y < -1.0 {
        x * x * y
    } else {
        x.ln()
    };
    [
        first,
        smaller(smaller(x, y), c) * larger(x * y, x),
        (x - y).abs() * x.hypot(y) + y.atan2(x) + (x * x + 1.0).powf(y),
    ]
}

constraint! {
    /// What repeats, and what counts.
    struct Periodic { period }
    |x, y| [mod(x, period) * y, floor(x + y), (x * y).mod(-2)]
}

/// `mod` is x − y ⌊x/y⌋, bit for bit, with the sign of y; slopes are those of x where y stays.
#[test]
fn whole_numbers() {
    let (g, mut generator) = (Periodic { period: 0.7 }, StdRng::seed_from_u64(8));
    for _ in 0..200 {
        let (x, y) = (generator.random_range(-5.0..5.0), generator.random_range(-5.0..5.0));
        let q = SVector::<f64, 2>::from([x, y]);
        let of = |a: f64, b: f64| a - b * (a / b).floor();
        assert_eq!(g.value(&q), SVector::from([of(x, 0.7) * y, (x + y).floor(), of(x * y, -2.0)]));
        assert!((0.0..0.7).contains(&of(x, 0.7)) && (-2.0..=0.0).contains(&of(x * y, -2.0)));
        let slopes = g.jacobian(&q);
        assert_eq!(slopes.row(0), SMatrix::<f64, 1, 2>::new(y, of(x, 0.7)));
        assert_eq!(slopes.row(1), SMatrix::<f64, 1, 2>::zeros());
        assert_eq!(slopes.row(2), SMatrix::<f64, 1, 2>::new(y, x));
    }
}

/// Branches: values by hand, derivatives by differences inside each, and no NaN from the arm not taken.
#[test]
fn branches_select() {
    let c = 0.8;
    let g = Branches { c };
    let mut generator = StdRng::seed_from_u64(6);
    let mut checked = 0;
    for _ in 0..2000 {
        let q = SVector::<f64, 2>::from_fn(|_, _| generator.random_range(-2.0..2.0));
        let value = g.value(&q);
        for (found, expected) in value.iter().zip(branches(q[0], q[1], c)) {
            assert_eq!(found.to_bits(), expected.to_bits(), "at {q:?}");
        }
        let (jacobian, h) = (g.jacobian(&q), 1.0 / (1 << 16) as f64);
        assert!(jacobian.iter().all(|entry| entry.is_finite()), "no NaN leaks at {q:?}");
        // x, −x < 0, x − c, y, y + 1, x − y and so on: away from all of them the function is smooth.
        if [q[0], q[0] - c, q[1], q[1] + 1.0, q[0] - q[1], q[1] - c, q[0] * (q[1] - 1.0)]
            .iter()
            .any(|k| k.abs() < 0.05)
        {
            continue;
        }
        checked += 1;
        for k in 0..2 {
            let at = |step: f64| {
                let mut q = q;
                q[k] += step;
                g.value(&q)
            };
            let difference = (at(h) - at(-h)) / (2.0 * h);
            for i in 0..3 {
                let (found, expected) = (jacobian[(i, k)], difference[i]);
                // h²g‴/6 with g‴ ≤ 2e4 this near to the kinks
                assert!(
                    (found - expected).abs() <= 1e-6 * (1.0 + expected.abs()),
                    "∂g{i}/∂q{k} at {q:?}: {found} {expected}"
                );
            }
        }
    }
    assert!(checked > 500);
}

#[test]
fn ties_and_edges() {
    let g = Branches { c: 0.8 };
    // min and max: the first argument on a tie; abs′(0) = +1; hypot and atan2 have slope 0 at the origin.
    let at_tie = g.jacobian(&vector![0.5, 0.5]);
    assert_eq!(at_tie[(1, 1)], 0.0, "min(x, x) follows x");
    let origin = g.jacobian(&vector![0.0, 0.0]);
    assert!(origin.iter().skip(1).all(|entry| !entry.is_nan()), "{origin}");
    assert_eq!(origin[(2, 0)], 0.0);
    // In the first branch x = 0 is not below 0, nor is y above 0: ln′(0) = ∞ is the honest slope.
    assert_eq!(origin[(0, 0)], f64::INFINITY);
    // `<=` holds on the edge, `<` and `>` do not.
    assert_eq!(g.value(&vector![0.8, 0.5])[0], 0.8 * 0.8 * 0.5);
    assert_eq!(g.value(&vector![0.8, 0.0])[0], 0.8_f64.ln());
    let kinks = <Branches as Constraint<2, 3>>::Kernel::<f64>::KINKS;
    for listed in ["x", "x - c", "y", "y + 1", "y - x"] {
        assert!(kinks.contains(&listed), "{listed}: {kinks:?}");
    }
}

/// Indices are compared when the macro runs: what is not equal to one.
#[test]
fn indices_that_differ() {
    constraint! { struct Others {} |q: [f64; 4]| sum(i in 0..4, if i != 1 { q[i] } else { 0 }) }
    assert_eq!(Others {}.jacobian(&vector![1.0, 1.0, 1.0, 1.0]), vector![1.0, 0.0, 1.0, 1.0].transpose());
}

/// Names that the generated code uses itself are free for users.
#[test]
fn no_name_is_taken() {
    mod names {
        use rattle::constraint;
        constraint! {
            /// Named as the trait of scalars.
            pub(super) struct Real { q, v, s, t0, p0 }
            |t1, scalar, T| q * t1 + v * scalar + s * T + t0 * p0
        }
        constraint! {
            /// Named as the type parameter.
            pub(super) struct T { weights, }
            |x| weights * x
        }
    }
    let real = names::Real { q: 1.0, v: 2.0, s: 3.0, t0: 4.0, p0: 5.0 };
    assert_eq!(real.value(&vector![1.0, 1.0, 1.0])[0], 26.0);
    assert_eq!(names::T { weights: 2.0 }.jacobian(&vector![1.0])[0], 2.0);
}

/// Constants around the macro are no patterns in it.
#[test]
fn no_constant_is_in_the_way() {
    #![allow(non_upper_case_globals, dead_code)]
    const q: f64 = 1.0;
    const v: f64 = 1.0;
    const p: f64 = 1.0;
    const s: f64 = 1.0;
    const i: f64 = 1.0;
    const dq: f64 = 1.0;
    const dp: f64 = 1.0;
    const lane: f64 = 1.0;
    const found: f64 = 1.0;
    const count: f64 = 1.0;
    const values: f64 = 1.0;
    const weights: f64 = 1.0;
    const kernel: f64 = 1.0;
    const memory: f64 = 1.0;
    constraint! { struct Surface { r } |x, y| abs(x) * y - r }
    constraint! { struct Long {} |x, y| sum(k in 1..300, sin(k * x) * cos(k * y) / k) }
    potential! { struct Energy { g } |x, y| g * x * y }
    pair_potential! { struct Pair { k } |r| k / r }
    hamiltonian! { struct Motion {} |x: [f64; 1], w: [f64; 1]| x[0]^2 + w[0]^2 }
    phase_constraint! { struct Both {} |x: [f64; 1], w: [f64; 1]| x[0] * w[0] - 1 }
    assert_eq!(Surface { r: 1.0 }.value(&vector![-2.0, 3.0])[0], 5.0);
    assert_eq!(Energy { g: 2.0 }.value(&vector![2.0, 3.0]), 12.0);
    assert_eq!(PairPotential::value(&Pair { k: 2.0 }, 4.0), 0.5);
    assert_eq!(Motion {}.value(&vector![1.0], &vector![2.0]), 5.0);
    assert_eq!(Both {}.value(&vector![1.0], &vector![2.0])[0], 1.0);
    assert!(Long {}.value(&vector![0.1, 0.2])[0].is_finite());
}

#[test]
fn indices_decide() {
    let x = [2.0, 3.0, 5.0, 7.0];
    let g = Chain {}.value(&x.into());
    assert_eq!(g, vector![2.0 + 1.0, 1.0 + 2.0, 2.0 + 6.0, 2.0 + 30.0]);
}

constraint! {
    /// Conditions on indices and coordinates at once; what the index rules out is not looked at.
    pub struct Neighbours {}
    |x: [f64; 3]| for i in 0..3 {
        if i > 0 && x[i - 1] > 0 || i == 0 && x[0] < 2 { x[i]^2 } else { sum(k in 0..3, if k == i || x[k] > 4 { x[k] } else { 0 }) }
    }
}

#[test]
fn indices_and_coordinates_in_one_condition() {
    let expected = |x: [f64; 3]| {
        let others = |i: usize| (0..3).map(|k| if k == i || x[k] > 4.0 { x[k] } else { 0.0 }).sum::<f64>();
        [0, 1, 2].map(|i| {
            let squared = if i == 0 { x[0] < 2.0 } else { x[i - 1] > 0.0 };
            if squared { x[i] * x[i] } else { others(i) }
        })
    };
    for x in [[1.0, -2.0, 3.0], [-1.0, 5.0, 6.0], [3.0, 5.0, 0.5], [2.0, 0.0, 7.0], [4.5, -1.0, -3.0]] {
        assert_eq!(Neighbours {}.value(&x.into()), SVector::from(expected(x)), "at {x:?}");
    }
}

#[test]
fn phase_space() {
    let (q, p) = (vector![0.3, -0.4], vector![0.5, 0.7]);
    let pendulum = Pendulum { g: 9.0 };
    assert_eq!(pendulum.value(&q, &p), (0.25 + 0.7 * 0.7) / 2.0 + 9.0 * -0.4);
    assert_eq!(pendulum.gradients(&q, &p), (vector![0.0, 9.0], p));
    let charge = Charge { b: 1.5 };
    let kernel = charge.kernel::<f64>();
    let (dq, dp) = ([0.2, -0.1], [0.4, 0.3]);
    let (hq, hp) = kernel.hessian_vector(&q.into(), &p.into(), &dq, &dp);
    let h = 1.0 / 1024.0;
    let at = |s: f64| charge.gradients(&(q + s * SVector::from(dq)), &(p + s * SVector::from(dp)));
    let ((q1, p1), (q0, p0)) = (at(h), at(-h));
    let (fq, fp) = ((q1 - q0) / (2.0 * h), (p1 - p0) / (2.0 * h));
    for k in 0..2 {
        assert!((hq[k] - fq[k]).abs() < 1e-6 && (hp[k] - fp[k]).abs() < 1e-6); // h²/6 times third derivatives below one
    }
    let (by_q, by_p) = Sphere3 {}.jacobians(&q, &p);
    assert_eq!(by_q, matrix![0.6, -0.8; 0.7, -0.5]);
    assert_eq!(by_p, matrix![1.0, 1.4; 0.4, 0.3]);
}

#[test]
fn second_derivatives_agree() {
    let mut generator = StdRng::seed_from_u64(7);
    for _ in 0..200 {
        let q = SVector::<f64, 6>::from_fn(|_, _| generator.random_range(-1.0..1.0));
        let v = SVector::<f64, 6>::from_fn(|_, _| generator.random_range(-1.0..1.0));
        let weights = vector![generator.random_range(-1.0..1.0)];
        let rod = Rod { length: 1.0 };
        let [hessian] = rod.hessian(&q);
        assert_eq!(hessian, hessian.transpose());
        let product = rod.hessian_vector(&q, &v).transpose();
        let weighted = rod.weighted_hessian_vector(&q, &weights, &v);
        assert!((hessian * v - product).amax() <= 1e-14); // six products of order one
        assert!((product * weights[0] - weighted).amax() <= 1e-14);
    }
}

constraint! {
    /// So many operations that the functions are written in blocks, and the rarer ones left to the trait.
    pub struct Series {}
    |x, y| sum(i in 1..300, sin(i * x) * cos(i * y) / i)
}

#[test]
fn long_functions() {
    let q = vector![0.3, -0.2];
    let (x, y) = (q[0], q[1]);
    let term = |i: f64| (i * x).sin() * (i * y).cos() / i;
    let value = (2..300).fold(term(1.0), |sum, i| sum + term(f64::from(i)));
    assert_eq!(Series {}.value(&q)[0].to_bits(), value.to_bits());
    let (shared, jacobian) = Series {}.value_and_jacobian(&q);
    assert_eq!(shared[0].to_bits(), value.to_bits());
    let sum = |f: &dyn Fn(f64) -> f64| (1..300).map(|i| f(f64::from(i))).sum::<f64>();
    let slopes = [sum(&|i| (i * x).cos() * (i * y).cos()), sum(&|i| -(i * x).sin() * (i * y).sin())];
    let mixed = sum(&|i| -i * (i * x).cos() * (i * y).sin());
    let [hessian] = Series {}.hessian(&q);
    for k in 0..2 {
        assert!((jacobian[k] - slopes[k]).abs() <= 1e-12, "300 terms of order one"); // 300 · 300 eps, with room
    }
    assert!((hessian[(0, 1)] - mixed).abs() <= 1e-10 && (hessian[(1, 0)] - mixed).abs() <= 1e-10);
    assert_eq!(Series {}.jacobian(&q), jacobian);
}

/// What the macro derives may be asked for again, and more with it.
#[test]
fn derives() {
    constraint! {
        #[derive(Debug, Default, Clone, Copy, PartialEq, PartialOrd)]
        #[derive(std::clone::Clone)]
        struct Derived { r, n: [f64; 2] }
        |x, y| n[0] * x + n[1] * y - r
    }
    let derived = Derived { r: 1.0, n: [0.0, 1.0] };
    let copy = derived;
    assert_eq!(copy.clone(), derived);
    assert!(Derived::default() < derived);
    assert_eq!(format!("{derived:?}"), "Derived { r: 1.0, n: [0.0, 1.0] }");
}

/// Each comparison below, on and above its edge.
#[test]
fn comparisons() {
    constraint! {
        struct Edges {}
        |x| [if x < 1 { x } else { 2 * x }, if x <= 1 { x } else { 2 * x }, if x > 1 { x } else { 2 * x }, if x >= 1 { x } else { 2 * x }]
    }
    let holds = |x: f64| Edges {}.jacobian(&vector![x]).map(|slope| slope == 1.0);
    assert_eq!(holds(1.0_f64.next_down()), vector![true, true, false, false]);
    assert_eq!(holds(1.0), vector![false, true, false, true]);
    assert_eq!(holds(1.0_f64.next_up()), vector![false, false, true, true]);
}

/// What another macro was given as an expression is one operand, as in Rust, sign and sums and all.
#[test]
fn fragments_are_operands() {
    macro_rules! formulas {
        ($e:expr) => {
            constraint! { struct Power {} |x| x + $e^2 }
            constraint! { struct Difference {} |x| x - $e }
            constraint! { struct Product {} |x| $e * x }
            constraint! { struct Negative {} |x| x + -$e }
            constraint! { struct Exponent {} |x| x^$e + 2^-$e }
            constraint! { struct First {} |x| $e - x }
        };
    }
    {
        formulas!(-3.0);
        let at = vector![2.0];
        let found = [Power {}.value(&at).x, Difference {}.value(&at).x, Product {}.value(&at).x];
        assert_eq!(found, [11.0, 5.0, -6.0]);
        let found = [Negative {}.value(&at).x, Exponent {}.value(&at).x, First {}.value(&at).x];
        assert_eq!(found, [5.0, 8.125, -5.0]);
    }
    formulas!(-2.0 + 1.0);
    let at = vector![2.0];
    let found = [Power {}.value(&at).x, Difference {}.value(&at).x, Product {}.value(&at).x];
    assert_eq!(found, [3.0, 3.0, -2.0]);
    let found = [Negative {}.value(&at).x, Exponent {}.value(&at).x, First {}.value(&at).x];
    assert_eq!(found, [3.0, 2.5, -3.0]);
}
