//! What the macros make, against the expression written by hand and against differences.
//!
//! ```text
//! value             the same bits as the hand-written Rust, at random and at special points
//! jacobian          Richardson's extrapolation of central differences of the value
//! hessian_vector    the same of the jacobian
//! jet               (g, G v, vᵀ∇²g v) from the other functions
//! ```
//!
//! Central differences with step h err by h²g‴/6 + eps·|g|/h; one extrapolation leaves h⁴g⁽⁵⁾/480 and
//! 3 eps·|g|/h. At h = 2⁻¹⁰ both are near 1e-12 for functions whose scales are of order one, as here;
//! the bound of 1e-8, relative to the largest number in sight, leaves room for the steeper ones, and
//! is far below the error of any wrong rule.

use nalgebra::{SMatrix, SVector, vector};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::prelude::*;
use rattle::real::Real;
use std::ops::Range;

const POINTS: usize = 2000;
const BOUND: f64 = 1e-8;
const H: f64 = 1.0 / 1024.0;

/// Zeros, ones, ties, powers of two, the smallest and the largest, and no numbers at all.
const SPECIAL: [f64; 14] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    -2.0,
    3.0,
    1e-300,
    -5e-324,
    1e150,
    1e308,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
];

fn random<const D: usize>(generator: &mut StdRng, range: &Range<f64>) -> SVector<f64, D> {
    SVector::from_fn(|_, _| generator.random_range(range.clone()))
}

fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

/// (4 D(h/2) − D(h)) / 3 with D the central difference of f along coordinate k.
fn difference<const D: usize, const N: usize>(
    f: impl Fn(&SVector<f64, D>) -> SVector<f64, N>,
    q: &SVector<f64, D>,
    k: usize,
) -> SVector<f64, N> {
    let central = |h: f64| {
        let (mut ahead, mut behind) = (*q, *q);
        ahead[k] += h;
        behind[k] -= h;
        (f(&ahead) - f(&behind)) / (2.0 * h)
    };
    (central(0.5 * H) * 4.0 - central(H)) / 3.0
}

#[track_caller]
fn close(name: &str, what: &str, found: f64, expected: f64, size: f64) {
    let error = (found - expected).abs();
    assert!(error <= BOUND * size, "{name}: {what} is {found:e}, expected {expected:e} ± {:e}", BOUND * size);
}

/// All laws for one constraint. `range` is where it is smooth.
#[track_caller]
fn check<const D: usize, const M: usize>(
    name: &str,
    g: impl Constraint<D, M>,
    by_hand: impl Fn(&[f64; D]) -> [f64; M],
    range: Range<f64>,
) {
    let mut generator = StdRng::seed_from_u64(2);
    let mut moved = 0;
    for point in 0..POINTS {
        let wide = point % 2 == 1;
        let mut q: SVector<f64, D> = random(&mut generator, if wide { &(-4.0..4.0) } else { &range });
        if point % 5 == 4 {
            q[generator.random_range(0..D)] = SPECIAL[generator.random_range(0..SPECIAL.len())];
        }
        let (value, expected) = (g.value(&q), by_hand(&q.into()));
        for i in 0..M {
            assert!(
                same(value[i], expected[i]),
                "{name}: value {i} at {q:?} is {}, by hand {}",
                value[i],
                expected[i]
            );
        }
        let (shared, jacobian) = g.value_and_jacobian(&q);
        for i in 0..M {
            assert!(same(shared[i], value[i]), "{name}: value_and_jacobian has another value at {q:?}");
        }
        let alone = g.jacobian(&q);
        assert!(
            alone.iter().zip(&jacobian).all(|(a, b)| same(*a, *b)),
            "{name}: value_and_jacobian has another jacobian at {q:?}"
        );
        if wide || point % 5 == 4 || point % 20 != 0 {
            continue; // differences are for smooth places, and slow
        }
        moved += 1;
        let v: SVector<f64, D> = random(&mut generator, &(-1.0..1.0));
        derivatives(name, &g, &q, &v);
    }
    assert!(moved >= POINTS / 40, "{name}: the differences were checked");
}

#[track_caller]
fn derivatives<const D: usize, const M: usize>(
    name: &str,
    g: &impl Constraint<D, M>,
    q: &SVector<f64, D>,
    v: &SVector<f64, D>,
) {
    let (value, jacobian) = g.value_and_jacobian(q);
    let products = g.hessian_vector(q, v);
    let size = 1.0 + value.amax() + jacobian.amax() + products.amax();
    for k in 0..D {
        let column = difference(|q| g.value(q), q, k);
        for i in 0..M {
            close(name, &format!("∂g{i}/∂q{k} at {q:?}"), jacobian[(i, k)], column[i], size);
        }
    }
    let mut along = SMatrix::<f64, M, D>::zeros();
    for k in 0..D {
        for i in 0..M {
            let row = difference(|q| g.jacobian(q).row(i).transpose(), q, k);
            for j in 0..D {
                along[(i, j)] += row[j] * v[k];
            }
        }
    }
    for i in 0..M {
        for j in 0..D {
            close(name, &format!("(∇²g{i} v){j} at {q:?}"), products[(i, j)], along[(i, j)], size);
        }
    }
    let (g0, g1, g2) = g.jet(q, v);
    for i in 0..M {
        assert!(same(g0[i], value[i]), "{name}: the jet has another value at {q:?}");
        let (speed, bend) = (jacobian.row(i) * v, products.row(i) * v);
        close(name, "ġ", g1[i], speed[0], size);
        close(name, "g̈", g2[i], bend[0], size);
    }
}

/// All laws for one potential.
#[track_caller]
fn check_potential<const D: usize>(
    name: &str,
    u: impl Potential<D>,
    by_hand: impl Fn(&[f64; D]) -> f64,
    range: Range<f64>,
) {
    let mut generator = StdRng::seed_from_u64(3);
    for point in 0..POINTS {
        let mut q: SVector<f64, D> = random(&mut generator, &range);
        if point % 5 == 4 {
            q[generator.random_range(0..D)] = SPECIAL[generator.random_range(0..SPECIAL.len())];
        }
        let (value, expected) = (u.value(&q), by_hand(&q.into()));
        assert!(same(value, expected), "{name}: value at {q:?} is {value}, by hand {expected}");
        if point % 20 == 0 {
            let gradient = u.gradient(&q);
            let size = 1.0 + value.abs() + gradient.amax();
            for k in 0..D {
                let slope = difference(|q| vector![u.value(q)], &q, k)[0];
                close(name, &format!("∂U/∂q{k} at {q:?}"), gradient[k], slope, size);
            }
        }
    }
}

/// All laws for one pair potential; the value is a function of r², so not the same bits.
#[track_caller]
fn check_pair(name: &str, u: impl PairPotential, by_hand: impl Fn(f64) -> f64, range: Range<f64>) {
    let mut generator = StdRng::seed_from_u64(4);
    for _ in 0..POINTS {
        let r: f64 = generator.random_range(range.clone());
        let slope = u.slope_over_distance(r) * r;
        let size = 1.0 + u.value(r).abs() + slope.abs();
        close(name, &format!("U({r})"), u.value(r), by_hand(r), 1e-4 * size); // a few ulp
        let expected = difference(|r| vector![by_hand(r[0])], &vector![r], 0)[0];
        close(name, &format!("U′({r})"), slope, expected, size);
    }
}

mod catalogue {
    //! The rows, each with its expression by hand.
    use super::*;

    constraint! {
        /// The Bernoulli lemniscate, inflated.
        pub(super) struct Lemniscate { a, r }
        |x, y, z| {
            let f = (x^2 + y^2)^2 - a^2 * (x^2 - y^2);
            f^2 + z^2 - r^2
        }
    }
    constraint! {
        /// A torus, as a polynomial: smooth everywhere.
        pub(super) struct Torus { major, minor }
        |x, y, z| (x^2 + y^2 + z^2 + major^2 - minor^2)^2 - 4 * major^2 * (x^2 + y^2)
    }
    constraint! {
        /// The same torus with a root.
        pub(super) struct TorusByDistance { major, minor }
        |x, y, z| (sqrt(x^2 + y^2) - major)^2 + z^2 - minor^2
    }
    constraint! {
        /// A sphere.
        pub(super) struct Sphere { r }
        |x, y, z| x^2 + y^2 + z^2 - r^2
    }
    constraint! {
        /// An ellipsoid: divisions, one per component.
        pub(super) struct Ellipsoid { a, b, c }
        |x, y, z| (x / a)^2 + y^2 / b^2 + z * z / (c * c) - 1
    }
    constraint! {
        /// The gyroid.
        pub(super) struct Gyroid { k }
        |x, y, z| sin(k * x) * cos(k * y) + sin(k * y) * cos(k * z) + (k * z).sin() * (k * x).cos()
    }
    constraint! {
        /// Schwarz' P surface in a box of side one.
        pub(super) struct Primitive {}
        |x, y, z| cos(2 * pi * x) + cos(2 * pi * y) + cos(2 * pi * z)
    }
    constraint! {
        /// Goursat's tangle cube.
        pub(super) struct Tanglecube {}
        |x, y, z| x^4 - 5 * x^2 + y^4 - 5 * y^2 + z^4 - 5 * z^2 + 11.8
    }
    constraint! {
        /// Taubin's heart.
        pub(super) struct Heart {}
        |x, y, z| (x^2 + 9/4 * y^2 + z^2 - 1)^3 - x^2 * z^3 - 9/80 * y^2 * z^3
    }
    constraint! {
        /// Clebsch's cubic: 27 lines.
        pub(super) struct Clebsch {}
        |x, y, z| 81 * (x^3 + y^3 + z^3) - 189 * (x^2 * (y + z) + y^2 * (x + z) + z^2 * (x + y)) + 54 * x * y * z
            + 126 * (x * y + x * z + y * z) - 9 * (x^2 + y^2 + z^2) - 9 * (x + y + z) + 1
    }
    constraint! {
        /// A cylinder: nothing depends on z.
        pub(super) struct Cylinder { r }
        |x, y, _z| x^2 + y^2 - r^2
    }
    constraint! {
        /// Two metaballs.
        pub(super) struct Metaballs { c }
        |x, y, z| 1 / ((x - c)^2 + y^2 + z^2) + 1 / ((x + c)^2 + y^2 + z^2) - 2
    }
    constraint! {
        /// Powers: odd, large, negative, by halves and thirds, by parameters.
        pub(super) struct Powers { n }
        |x, y, z| x^7 - y^-3 + z^(3/2) + x^(-1/2) * y^0.5 - z^(2/3) + x^n + 2^y + (x * y)^2.5 + x^1.1
    }
    constraint! {
        /// Precedence: −x² = −(x²), right-associative powers, division from the left.
        pub(super) struct Precedence {}
        |x, y, z| -x^2 + y^2^2 - 3 / 2 / x * z - -z * -(y - 1) + 2 * -x^3
    }
    constraint! {
        /// Constants, blocks in blocks, numbers in all notations.
        pub(super) struct Notation { a }
        |x, y, z| {
            let s = { let t = x * y; t + e };
            let c = 0x10 + 1_000 + 1e-2 + 2.5;
            pi * s - c * z + (a / e).exp() * z
        }
    }

    /// One constraint for each function f: f(x y + shift) + z².
    macro_rules! functions {
        ($($name:ident $f:ident $shift:literal;)*) => {
            $(constraint! {
                /// One function.
                pub(super) struct $name {}
                |x, y, z| $f(x * y + $shift) + z^2
            })*
            pub(super) fn functions() {
                $(check(
                    stringify!($f),
                    $name {},
                    |&[x, y, z]| [Real::$f(x * y + $shift as f64) + z * z],
                    0.2..0.7,
                );)*
            }
        };
    }
    functions! {
        Sqrt sqrt 0.1; Cbrt cbrt 0.1; Exp exp 0.0; Ln ln 0.3; Log10 log10 0.3; Log2 log2 0.3;
        Sin sin 1; Cos cos 1; Tan tan 0.0; Asin asin 0.0; Acos acos 0.1; Atan atan 0.5;
        Sinh sinh 0.5; Cosh cosh 0.5; Tanh tanh 0.5; Asinh asinh 0.5; Acosh acosh 1.5; Atanh atanh 0.1;
        Abs abs 0.1; Sign sign 0.1; Floor floor 0.1; Erf erf 0.2;
    }

    potential! {
        /// Uniform gravity.
        pub(super) struct Gravity { g }
        |x, y, z| g * z
    }
    potential! {
        /// Kepler's potential.
        pub(super) struct Kepler { k }
        |x, y, z| -k / sqrt(x^2 + y^2 + z^2)
    }
    potential! {
        /// The potential of Hénon and Heiles.
        pub(super) struct HenonHeiles {}
        |x, y| (x^2 + y^2) / 2 + x^2 * y - y^3 / 3
    }

    pair_potential! {
        /// Ricker's wavelet.
        pub(super) struct Ricker { depth, radius }
        |r| { let rho = r / radius; depth / 2 * (1 - 3 * rho^2) * exp(3/2 * (1 - rho^2)) }
    }
    pair_potential! {
        /// Lennard and Jones.
        pub(super) struct LennardJones { epsilon, sigma }
        |r| 4 * epsilon * ((sigma / r)^12 - (sigma / r)^6)
    }
    pair_potential! {
        /// Morse: not even in r.
        pub(super) struct Morse { depth, width, radius }
        |r| depth * (1 - exp(-width * (r - radius)))^2
    }
    pair_potential! {
        /// Coulomb: odd in r.
        pub(super) struct Coulomb { k }
        |r| k / r
    }
    pair_potential! {
        /// Even, but not without a root.
        pub(super) struct Wave { k }
        |r| cos(k * r)
    }
    pair_potential! {
        /// Even with an odd part inside: |r| r³ / √(1 + r²)
        pub(super) struct Mixed { k }
        |r| abs(k * r) * r^3 / sqrt(1 + r^2) - r * -r
    }
}
use catalogue::*;

#[test]
fn constraints() {
    let f = |a: f64, [x, y, _]: [f64; 3]| {
        let s = x * x + y * y;
        s * s - a * a * (x * x - y * y)
    };
    let (a, r) = (1.0, 1.0 / 6.0);
    check("lemniscate", Lemniscate { a, r }, |&q| [f(a, q) * f(a, q) + q[2] * q[2] - r * r], -1.2..1.2);
    let (major, minor) = (1.3, 0.4);
    check(
        "torus",
        Torus { major, minor },
        |&[x, y, z]| {
            let s = x * x + y * y + z * z + major * major - minor * minor;
            [s * s - 4.0 * (major * major) * (x * x + y * y)]
        },
        -2.0..2.0,
    );
    check(
        "torus by distance",
        TorusByDistance { major, minor },
        |&[x, y, z]| {
            let d = (x * x + y * y).sqrt() - major;
            [d * d + z * z - minor * minor]
        },
        0.2..2.0,
    );
    check("sphere", Sphere { r }, |&[x, y, z]| [x * x + y * y + z * z - r * r], -2.0..2.0);
    let (b, c) = (1.7, 0.6);
    check(
        "ellipsoid",
        Ellipsoid { a, b, c },
        |&[x, y, z]| [(x / a) * (x / a) + y * y / (b * b) + z * z / (c * c) - 1.0],
        -2.0..2.0,
    );
    let k = 1.1;
    check(
        "gyroid",
        Gyroid { k },
        |&[x, y, z]| {
            let ((a, d), (b, e), (c, f)) = ((k * x).sin_cos(), (k * y).sin_cos(), (k * z).sin_cos());
            [a * e + b * f + c * d]
        },
        -2.0..2.0,
    );
    let turn = |x: f64| (2.0 * std::f64::consts::PI * x).cos();
    check("primitive", Primitive {}, |&[x, y, z]| [turn(x) + turn(y) + turn(z)], -0.2..0.2);
    check(
        "tanglecube",
        Tanglecube {},
        |&q| {
            let ([x, y, z], [x4, y4, z4]) = (q.map(|x| x * x), q.map(|x| (x * x) * (x * x)));
            [x4 - 5.0 * x + y4 - 5.0 * y + z4 - 5.0 * z + 11.8]
        },
        -2.0..2.0,
    );
    check(
        "heart",
        Heart {},
        |&[x, y, z]| {
            let s = x * x + 9.0 / 4.0 * (y * y) + z * z - 1.0;
            let z3 = z * z * z;
            [s * s * s - x * x * z3 - 9.0 / 80.0 * (y * y) * z3]
        },
        -1.2..1.2,
    );
    check(
        "clebsch",
        Clebsch {},
        |&[x, y, z]| {
            let cubes = x * x * x + y * y * y + z * z * z;
            let mixed = x * x * (y + z) + y * y * (x + z) + z * z * (x + y);
            [81.0 * cubes - 189.0 * mixed + 54.0 * x * y * z + 126.0 * (x * y + x * z + y * z)
                - 9.0 * (x * x + y * y + z * z)
                - 9.0 * (x + y + z)
                + 1.0]
        },
        -1.0..1.0,
    );
    check("cylinder", Cylinder { r }, |&[x, y, _]| [x * x + y * y - r * r], -2.0..2.0);
    check(
        "metaballs",
        Metaballs { c },
        |&[x, y, z]| {
            let ball = |x: f64| 1.0 / (x * x + y * y + z * z);
            [ball(x - c) + ball(x + c) - 2.0]
        },
        0.9..2.0,
    );
    let n = 1.3;
    check(
        "powers",
        Powers { n },
        |&[x, y, z]| {
            let (x3, w, c) = (x * x * x, x * y, z.cbrt());
            [x3 * x3 * x - 1.0 / (y * y * y) + z * z.sqrt() + 1.0 / x.sqrt() * y.sqrt() - c * c
                + x.powf(n)
                + 2.0_f64.powf(y)
                + w * w * w.sqrt()
                + x.powf(1.1)]
        },
        0.5..1.5,
    );
    check(
        "precedence",
        Precedence {},
        |&[x, y, z]| {
            let y4 = (y * y) * (y * y);
            [-(x * x) + y4 - 3.0 / 2.0 / x * z - -z * -(y - 1.0) + 2.0 * -(x * x * x)]
        },
        0.5..1.5,
    );
    let (pi, e) = (std::f64::consts::PI, std::f64::consts::E);
    check(
        "notation",
        Notation { a },
        |&[x, y, z]| {
            let constant = 16.0 + 1000.0 + 1e-2 + 2.5;
            [pi * (x * y + e) - constant * z + (a / e).exp() * z]
        },
        -2.0..2.0,
    );
}

#[test]
fn functions_of_one_argument() {
    catalogue::functions();
}

#[test]
fn potentials() {
    check_potential("gravity", Gravity { g: 9.81 }, |q: &[f64; 3]| 9.81 * q[2], -2.0..2.0);
    let distance = |&[x, y, z]: &[f64; 3]| (x * x + y * y + z * z).sqrt();
    check_potential("kepler", Kepler { k: 1.5 }, |q| -1.5 / distance(q), 0.5..2.0);
    check_potential(
        "hénon–heiles",
        HenonHeiles {},
        |&[x, y]| (x * x + y * y) / 2.0 + x * x * y - y * y * y / 3.0,
        -2.0..2.0,
    );
}

#[test]
fn pair_potentials() {
    let (depth, radius) = (0.5, 1.0 / 6.0);
    let ricker = Ricker { depth, radius };
    let rho = |r: f64| (r / radius) * (r / radius);
    check_pair(
        "ricker",
        ricker,
        |r| depth / 2.0 * (1.0 - 3.0 * rho(r)) * (1.5 * (1.0 - rho(r))).exp(),
        0.1..0.5,
    );
    // By 40-digit arithmetic: U(0) = e^{3/2}/4 and U′(r)/r = −(9/2) U_e e^{3/2}/r_e² at r = 0.
    close("ricker", "U(0)", ricker.value(0.0), 1.120_422_267_584_516, 1e-6);
    close("ricker", "U′/r at 0", ricker.slope_over_distance(0.0), -363.016_814_697_383_2, 1e-4);
    assert_eq!(ricker.value(radius), -0.5);
    let sixth = |r: f64| (0.9 / r).powi(6);
    let lennard_jones = LennardJones { epsilon: 0.7, sigma: 0.9 };
    check_pair("lennard-jones", lennard_jones, |r| 2.8 * (sixth(r) * sixth(r) - sixth(r)), 0.9..2.0);
    let stretch = |r: f64| 1.0 - (-1.2 * (r - 1.0)).exp();
    check_pair(
        "morse",
        Morse { depth: 0.8, width: 1.2, radius: 1.0 },
        |r| 0.8 * stretch(r) * stretch(r),
        0.5..2.0,
    );
    check_pair("coulomb", Coulomb { k: 1.4 }, |r| 1.4 / r, 0.5..2.0);
    check_pair("wave", Wave { k: 2.0 }, |r| (2.0 * r).cos(), 0.1..2.0);
    let (mixed, k) = (Mixed { k: 1.5 }, 1.5);
    check_pair("mixed", mixed, |r| k * r * r * r * r / (1.0 + r * r).sqrt() + r * r, 0.1..2.0);
    // At contact the slope is that of the smooth continuation, U″(0).
    close("wave", "U′/r at 0", Wave { k: 2.0 }.slope_over_distance(0.0), -4.0, 1e-6);
    assert_eq!(mixed.slope_over_distance(0.0), 2.0);
}
