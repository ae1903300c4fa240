//! Derivatives where a function is smooth though a part of it is not, where it is flat, and where parts overflow.
//!
//! Expected numbers are known by hand: derivatives of the same function in another form.

use rattle::nalgebra::vector;
use rattle::prelude::*;

constraint! {
    /// A unit sphere, whose distance from the axis is written as one.
    struct Round {}
    |x, y, z| hypot(x, y)^2 + z^2 - 1
}
constraint! {
    /// The same of the distance from a point.
    struct Ball {}
    |x, y, z| hypot(hypot(x, y), z)^2 + sqrt(sqrt(x))^4 - 1
}
constraint! { struct Powers { k } |x, y, z| cbrt(x)^3 + hypot(y, z)^4 + sqrt(x)^4 - k }
constraint! { struct Growing {} |x, y, z| z - x^y }
constraint! { struct Written {} |x, y, z| z - exp(y * ln(x)) }
potential! { struct Roots { n } |x, y| (x^2 + y^2)^0.7 + (x^2 + y^2)^n }
potential! { struct Flat { n } |x, y| max(x, 0)^0.7 + max(y, 0)^1.25 + max(x, 0)^n }
potential! { struct Negated { k } |x, y| (-k * x)^10 + (2 + -x * y)^9 }
potential! { struct PöschlTeller { v, w } |x| -v / cosh(x / w)^2 }
potential! { struct Steep {} |x, y| 1 / sqrt(x^2 + y^2)^12 }
potential! { struct Exponential { a } |x| a^x }
potential! { struct Unrooted { k } |x| k * sqrt(1 - x)^2 + cbrt(sqrt(x + 3))^6 }
constraint! { struct Big {} |x, y| 1e308 * x^2 + x * y - 1 }

#[test]
fn powers_of_a_distance_are_smooth() {
    let pole = vector![0.0, 0.0, 1.0];
    let curved = Round {}.hessian_vector(&pole, &vector![1.0, 2.0, 3.0]);
    assert_eq!(curved, vector![2.0, 4.0, 6.0].transpose());
    let curved = Ball {}.hessian_vector(&pole, &vector![1.0, 2.0, 3.0]);
    assert_eq!(curved, vector![2.0, 4.0, 6.0].transpose());
    assert_eq!(Ball {}.jacobian(&pole), vector![1.0, 0.0, 2.0].transpose());
    // hypot(y, z)⁴ = (y² + z²)², whose second derivatives vanish with its first; ∛x³ = x and √x⁴ = x².
    let at = vector![0.0, 0.0, 0.0];
    let g = Powers { k: 1.0 };
    assert_eq!(g.jacobian(&at), vector![1.0, 0.0, 0.0].transpose());
    assert_eq!(g.hessian_vector(&at, &vector![1.0, 1.0, 1.0]), vector![2.0, 0.0, 0.0].transpose());

    let start = || State::at([0.0, 0.0, 1.0]).moving([1.0, 0.0, 0.0]);
    let mut simulation = Scene::on(Round {}).simulate(start(), Dop853::new(0.1)).unwrap();
    simulation.run(10).unwrap();
    let off = (simulation.position() - vector![1.0_f64.sin(), 0.0, 1.0_f64.cos()]).norm();
    assert!(off < 1e-14, "{off:e}"); // 5.6e-16 where the square is written out
}

constraint! { struct Softened { b } |x, y| x * y * (if hypot(x, 0.1) <= b { 1 / b } else { 1 / hypot(x, 0.1) }) - 1 }
constraint! { struct Guarded {} |x, y| x * y * (if hypot(x, 0.1) <= 0 { 5 } else { 1 / hypot(x, 0.1) }) - 1 }
constraint! { struct Unguarded {} |x, y| x * y / hypot(x, 0.1) - 1 }

/// A reciprocal that a user guards is not that which derivatives guard.
#[test]
fn reciprocals_of_distances_with_another_arm() {
    let (at, along) =
        (vector![0.3, 2.0], |i: usize| vector![f64::from(u8::from(i == 0)), f64::from(u8::from(i == 1))]);
    let inside = Softened { b: 0.5 };
    assert_eq!(inside.jacobian(&at), vector![4.0, 0.6].transpose()); // 2xy
    for i in 0..2 {
        assert_eq!(inside.hessian_vector(&at, &along(i))[1 - i], 2.0);
    }
    let (beyond, expected) = (Softened { b: 0.2 }, Unguarded {});
    for i in 0..2 {
        let off = (beyond.hessian_vector(&at, &along(i)) - expected.hessian_vector(&at, &along(i))).amax();
        assert!(off < 1e-14, "{off:e}");
        let off =
            (Guarded {}.hessian_vector(&at, &along(i)) - expected.hessian_vector(&at, &along(i))).amax();
        assert!(off < 1e-14, "{off:e}");
    }
}

potential! { struct RootedTwice {} |x, y| sqrt(norm(x, y))^2 + sqrt(sqrt(x))^2 + cbrt(sqrt(y))^3 }

/// √f² = f, where f is a root itself: the slopes of roots are 0 at their tips.
#[test]
fn roots_of_roots_keep_their_tips() {
    assert_eq!(RootedTwice {}.gradient(&vector![0.0, 0.0]), vector![0.0, 0.0]);
    let at = vector![0.36, 0.25];
    let length = at.norm();
    let expected = at / length + vector![0.5 / 0.6, 0.5 / 0.5];
    assert!((RootedTwice {}.gradient(&at) - expected).amax() < 1e-15);
}

#[test]
fn exponents_that_are_zero() {
    let (at, v) = (vector![2.0, 0.0, 1.0], vector![1.0, 1.0, 1.0]);
    let (found, expected) = (Growing {}.hessian_vector(&at, &v), Written {}.hessian_vector(&at, &v));
    assert!((found - expected).amax() < 1e-15, "{found} {expected}");
    // −∂²(xʸ)/∂x∂y = −1/x there
    let column = Growing {}.hessian_vector(&at, &vector![1.0, 0.0, 0.0]);
    assert_eq!(column, vector![0.0, -0.5, 0.0].transpose());
}

#[test]
fn roots_are_flat_at_their_tip_and_below() {
    assert_eq!(Roots { n: 0.7 }.gradient(&vector![0.0, 0.0]), vector![0.0, 0.0]);
    assert_eq!(Roots { n: 0.0 }.gradient(&vector![0.0, 0.0]), vector![0.0, 0.0]);
    assert_eq!(Roots { n: 2.0 }.gradient(&vector![0.0, 0.0]), vector![0.0, 0.0]);
    let flat = Flat { n: 0.7 };
    assert_eq!(flat.gradient(&vector![-1.0, -1.0]), vector![0.0, 0.0]);
    let at = vector![4.0, 1.0];
    let (slope, found) = (2.0 * 0.7 * 4.0_f64.powf(-0.3), flat.gradient(&at));
    assert!((found - vector![slope, 1.25]).amax() < 1e-15, "{found}");
}

#[test]
fn signs_of_negated_factors() {
    let (x, y) = (0.9_f64, 0.5_f64);
    let inside = (2.0 - x * y).powi(8);
    let found = Negated { k: 1.0 }.gradient(&vector![x, y]);
    let expected = vector![10.0 * x.powi(9) - 9.0 * y * inside, -9.0 * x * inside];
    assert!((found - expected).amax() < 1e-13 * inside, "{found} {expected}");
}

#[test]
fn divisors_that_overflow() {
    let well = PöschlTeller { v: 2.0, w: 1.0 };
    assert_eq!(well.gradient(&vector![500.0]), vector![0.0]); // 8 exp(−1000)
    let slope = Steep {}.gradient(&vector![1e-20, 0.0])[0];
    assert!((slope / -1.2e261 - 1.0).abs() < 1e-14, "{slope:e}");
    assert_eq!(Steep {}.gradient(&vector![1e80, 0.0])[0], 0.0);
}

/// Where there is no value there is no slope, and no step.
#[test]
fn powers_of_no_value_have_no_slope() {
    let rises = Exponential { a: 2.0 }.gradient(&vector![0.5])[0];
    assert!((rises - 0.5_f64.exp2() * 2.0_f64.ln()).abs() < 1e-15, "{rises}");
    assert_eq!(Exponential { a: 0.0 }.gradient(&vector![0.5])[0], 0.0);
    let negative = Exponential { a: -2.0 };
    assert!(negative.gradient(&vector![0.5])[0].is_nan());
    let start = State::at([0.5]).moving([0.1]);
    let run =
        Scene::point().with(negative).simulate(start, Rattle::new(0.01)).and_then(|mut run| run.run(10));
    assert!(run.is_err(), "a run under a potential that is no number");

    // √(1 − x)² + ∛√(x + 3)⁶ = 4
    let rooted = Unrooted { k: 1.0 };
    assert_eq!(rooted.gradient(&vector![0.5])[0], 0.0);
    for beyond in [2.0, -4.0] {
        assert!(rooted.gradient(&vector![beyond])[0].is_nan(), "{beyond}");
    }
}

/// A coefficient that overflows in a derivative is infinite there alone.
#[test]
fn coefficients_that_overflow() {
    let slopes = Big {}.jacobian(&vector![0.25, 3.0]);
    assert_eq!(slopes, vector![f64::INFINITY, 0.25].transpose()); // of 2·10³⁰⁸ x + y
    let bent = Big {}.hessian_vector(&vector![0.25, 3.0], &vector![1.0, 0.0]);
    assert_eq!(bent, vector![f64::INFINITY, 1.0].transpose());
}

constraint! { struct Curved {} |a, b, c, d, x| tanh(a) + acos(b) + asin(c) + atanh(d) + hypot(x, 1) }

/// Second derivatives near an inflection, and of a hyperbola far out: nothing cancels.
#[test]
fn second_derivatives_keep_their_digits() {
    let along = |at: [f64; 5], way: usize| {
        let direction = std::array::from_fn(|i| f64::from(u8::from(i == way)));
        Curved {}.hessian_vector(&at.into(), &direction.into())[way]
    };
    let mut asked = 0;
    for x in [1e-2, 1e-4, 1e-8, 1e-12, 1e-16, -1e-8] {
        let cube = |c: f64| c * x * x; // the next term of each series
        for (way, expected) in [
            (0, -2.0 * x * (1.0 + cube(-4.0 / 3.0))),
            (1, -x * (1.0 + cube(1.5))),
            (2, x * (1.0 + cube(1.5))),
            (3, 2.0 * x * (1.0 + cube(2.0))),
        ] {
            let found = along([x; 5], way);
            let bound = 8.0 * f64::EPSILON + 4.0 * x.powi(4);
            assert!(
                (found - expected).abs() <= bound * expected.abs(),
                "{way} at {x:e}: {found:e}, {expected:e}"
            );
            asked += 1;
        }
    }
    assert_eq!(asked, 24);
    for x in [1e2, 1e4, 1e6, 1e8, 1e10, -1e10_f64] {
        let (found, expected) = (along([0.0, 0.0, 0.0, 0.0, x], 4), x.hypot(1.0).powi(-3));
        assert!((found - expected).abs() <= 16.0 * f64::EPSILON * expected, "{x:e}: {found:e}, {expected:e}");
    }
}

constraint! { struct Logarithm {} |x, y| ln(x) + asin(y) }

/// What is no number has no second derivative either.
#[test]
fn no_number_has_no_curvature() {
    let curved = |at: [f64; 2], way: [f64; 2]| Logarithm {}.hessian_vector(&at.into(), &way.into());
    assert!(curved([-1.0, 0.5], [1.0, 0.0])[0].is_nan());
    assert!(curved([1.0, 2.0], [0.0, 1.0])[1].is_nan());
    assert_eq!(curved([0.5, 0.0], [1.0, 1.0]), vector![-4.0, 0.0].transpose());
}

potential! { struct Held {} |x, y| acosh(max(x, 1)) + asin(min(y, 1)) }
potential! { struct Between {} |x| acos(max(-1, min(1, x))) }
potential! { struct Beyond {} |x| ln(min(x, -1)) }
constraint! { struct Slope {} |x, y, z| z - max(x, 0)^1.25 + 0 * y }

/// Where a function is held at the end of another's domain, it does not change, though the other's slope is infinite
/// there; and what is no number has no slope however it is held.
#[test]
fn what_is_held_has_no_slope() {
    assert_eq!(Held {}.gradient(&vector![0.5, 1.5]), vector![0.0, 0.0]);
    assert_eq!(Held {}.gradient(&vector![1.25, 0.6]), vector![1.0 / 0.75, 1.25]);
    for (x, slope) in [(1.0 + f64::EPSILON, 0.0), (-1.5, 0.0), (2.0, 0.0), (0.6, -1.25), (-0.6, -1.25)] {
        assert_eq!(Between {}.gradient(&vector![x])[0], slope, "{x}");
    }
    assert!(Beyond {}.value(&vector![0.5]).is_nan() && Beyond {}.gradient(&vector![0.5])[0].is_nan());
    for (x, curvature) in [(-1.0, 0.0), (16.0, -1.25 * 0.25 / 8.0)] {
        let curved = Slope {}.hessian_vector(&vector![x, 0.0, 0.0], &vector![1.0, 0.0, 0.0])[0];
        assert!((curved - curvature).abs() <= 2.0 * f64::EPSILON, "{x}: {curved}");
    }
    let start = || State::at([-0.5, 0.0, 0.0]).moving([0.1, 0.2, 0.0]);
    let mut simulation = Scene::on(Slope {}).simulate(start(), Rattle::new(0.1)).unwrap();
    simulation.run(10).unwrap();
    assert!((simulation.position() - vector![-0.4, 0.2, 0.0]).norm() < 1e-15);
}

potential! {
    /// Three bodies that want to be in a line.
    struct Bend { k }
    |a: [f64; 3], b: [f64; 3], c: [f64; 3]| {
        let u = a - b;
        let v = c - b;
        k * (acos(max(-1, min(1, dot(u, v) / (norm(u) * norm(v))))) - pi)^2
    }
}
potential! { struct FlatThere { k } |x, y| k / 2 * acos(max(-1, min(1, x)))^2 + acosh(max(y, 1))^2 }
potential! { struct Threefold {} |x| cos(3 * acos(min(1, x))) }
potential! { struct Cubed {} |x| acos(min(1, x))^3 + 0 * acos(min(1, x)) }
potential! { struct BeyondTwice { k } |x, y| k * y * ln(min(x, -1))^2 }

/// Where the function that holds a value is flat there: 0 · ∞ on the way.
#[test]
fn what_is_held_where_it_is_flat_has_no_slope() {
    let straight = vector![1.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0];
    assert_eq!(Bend { k: 3.0 }.value(&straight), 0.0);
    assert_eq!(Bend { k: 3.0 }.gradient(&straight), straight * 0.0);
    for x in [1.0 + f64::EPSILON, 1.5, 2.0] {
        assert_eq!(FlatThere { k: 3.0 }.gradient(&vector![x, 0.5]), vector![0.0, 0.0], "{x}");
        assert_eq!(Threefold {}.gradient(&vector![x])[0], 0.0, "{x}");
        assert_eq!(Cubed {}.gradient(&vector![x])[0], 0.0, "{x}");
    }
    let slopes = FlatThere { k: 3.0 }.gradient(&vector![0.6, 1.25]);
    assert!((slopes - vector![-3.75 * 0.6_f64.acos(), 2.0 * 1.25_f64.acosh() / 0.75]).amax() < 1e-14);
    // And what is no number has none.
    assert!(BeyondTwice { k: 2.0 }.gradient(&vector![0.5, 1.0]).iter().all(|slope| slope.is_nan()));
}

constraint! {
    /// Slopes of roots and powers of what is held, behind products and sums of it.
    struct Behind { w, k }
    |x, y, z| {
        y - (2 * max(x, 0))^1.4 - (max(x, 0) / w)^1.25 - (max(0, x) * w)^k - (max(x, 0) + max(z, 0))^1.4
            - (z^2 * max(x, 0)^2 / 3)^0.7
    }
}
constraint! { struct Rooted {} |x, y| y - asin(sqrt(min(x, 1))) }
potential! { struct Chosen { k } |x, y| if y < 0 { 0 } else { acos(k * min(1, x)) + acos(min(1, x)^2) } }

/// The slope of a branch is 0 in one of its arms, also where it is multiplied and added to others before a slope that
/// is infinite.
#[test]
fn what_is_held_stays_so_behind_products_and_sums() {
    let g = Behind { w: 2.0, k: 1.5 };
    let (held, along) = (vector![-1.0, 0.5, -2.0], vector![1.0, 1.0, 1.0]);
    assert_eq!(g.hessian_vector(&held, &along), vector![0.0, 0.0, 0.0].transpose());
    assert_eq!(g.jet(&held, &along), (vector![0.5], vector![1.0], vector![0.0]));
    let at = vector![4.0, 0.5, -2.0];
    let found = g.hessian_vector(&at, &vector![1.0, 0.0, 0.0])[0];
    let (x, scale) = (4.0_f64, (4.0_f64 / 3.0).powf(0.7));
    let power = |c: f64, n: f64| c.powf(n) * n * (n - 1.0) * x.powf(n - 2.0);
    let expected =
        power(2.0, 1.4) + power(0.5, 1.25) + power(2.0, 1.5) + power(1.0, 1.4) + scale * power(1.0, 1.4);
    assert!((found + expected).abs() < 1e-14, "{found} {expected}");

    let held = vector![2.0, 1.0];
    let (_, speed, bend) = Rooted {}.jet(&held, &vector![1.0, 1.0]);
    assert_eq!((speed, bend), (vector![1.0], vector![0.0]));
    assert_eq!(Chosen { k: 1.0 }.gradient(&held), vector![0.0, 0.0]);
}

constraint! { struct Hyperbolas { c } |x, y, z| z - sqrt(x^2 + 1) - hypot(c, y) }
constraint! { struct Sines { c } |x, y| y - x / sqrt(x^2 + c) - x / hypot(x, 1) }
constraint! { struct Distances {} |x, y, z, w| hypot(x, y) + norm(z, w) - 1 }
constraint! { struct Inner { c } |x, y| y - sqrt(x^2 - c) }

/// Slopes of x / √(x² + c) far out, and of x / √(x² + y²) where y is small: nothing cancels.
#[test]
fn slopes_of_roots_of_squares_keep_their_digits() {
    let close = |found: f64, expected: f64| (found - expected).abs() <= 8.0 * f64::EPSILON * expected.abs();
    for x in [0.75_f64, 1e2, 1e5, 1e10, -1e10] {
        let cube = x.hypot(1.0).powi(-3);
        let at = vector![x, x, 0.0];
        let bent = Hyperbolas { c: 1.0 }.hessian_vector(&at, &vector![1.0, -1.0, 0.0]);
        assert!(close(bent[0], -cube) && close(bent[1], cube), "{x:e}: {bent}");
        let (_, _, along) = Hyperbolas { c: 1.0 }.jet(&at, &vector![1.0, 0.0, 0.0]);
        assert!(close(along[0], -cube), "{x:e}: {along}");
        let slope = Sines { c: 1.0 }.jacobian(&vector![x, 0.0])[0];
        assert!(close(slope, -2.0 * cube), "{x:e}: {slope:e}");
        let curved = Sines { c: 1.0 }.hessian_vector(&vector![x, 0.0], &vector![1.0, 0.0])[0];
        assert!(close(curved, 6.0 * x * x.hypot(1.0).powi(-5)), "{x:e}: {curved:e}");
    }
    for y in [1e-8, -1e-4, 0.75_f64] {
        let cube = y.hypot(1.0).powi(-3);
        let at = vector![1.0, y, y, 1.0];
        for (way, by_x, by_y) in [(0, y * y * cube, -y * cube), (1, -y * cube, cube)] {
            let direction: [f64; 4] = std::array::from_fn(|i| f64::from(u8::from(i == way || i == 3 - way)));
            let bent = Distances {}.hessian_vector(&at, &direction.into());
            let expected = [by_x, by_y, by_y, by_x];
            assert!((0..4).all(|i| close(bent[i], expected[i])), "{y:e}: {bent}, {expected:?}");
        }
    }
    // ∂²√(x² − 9) = −9 / √(x² − 9)³
    let bent = Inner { c: 9.0 }.hessian_vector(&vector![5.0, 0.0], &vector![1.0, 0.0])[0];
    assert!(close(bent, 9.0 / 64.0), "{bent}");
    assert_eq!(
        Distances {}.hessian_vector(&vector![0.0, 0.0, 0.0, 0.0], &vector![1.0, 1.0, 1.0, 1.0]).amax(),
        0.0
    );
}

potential! { struct SmallPower {} |x, y| x^0.3 + y^-0.7 }
constraint! { struct SmallPowers {} |x, y, z| z - x^0.3 - y^-0.7 }

const SLOPES_BY_X: [(f64, f64); 5] = [
    (1e-300, 3.000000000000023e209),
    (1e-20, 30000000000000.016),
    (0.5, 0.4873514378137413),
    (3.0, 0.13903891703159094),
    (1e300, 2.999999999999977e-211),
];
const SLOPES_BY_Y: [(f64, f64, f64); 4] = [
    (1e-100, -6.999999999999928e169, 1.1899999999999877e270),
    (1e-20, -6.999999999999986e33, 1.1899999999999977e54),
    (3.0, -0.10814137991345961, 0.06128011528429378),
    (1e100, -7.000000000000071e-171, 1.190000000000012e-270),
];

/// An exponent from which 1 is taken with a rounding. Expected numbers are of 60 digits.
#[test]
fn slopes_of_small_powers_keep_their_digits() {
    let close = |found: f64, expected: f64| (found / expected - 1.0).abs() <= 4.0 * f64::EPSILON;
    for (x, expected) in SLOPES_BY_X {
        let found = SmallPower {}.gradient(&vector![x, 1.0])[0];
        assert!(close(found, expected), "{x:e}: {found:e}");
    }
    for (y, slope, bend) in SLOPES_BY_Y {
        let found = SmallPower {}.gradient(&vector![1.0, y])[1];
        assert!(close(found, slope), "{y:e}: {found:e}");
        let found = SmallPowers {}.hessian_vector(&vector![1.0, y, 0.0], &vector![0.0, 1.0, 0.0])[1];
        assert!(close(-found, bend), "{y:e}: {found:e}");
    }
}

constraint! { struct Entropy {} |x, y| y - x * ln(x) }

/// x · ln′(x) is 1, also where x² is no number, and none where ln(x) is none.
#[test]
fn slopes_of_logarithms_cancel() {
    let bend = |x: f64| Entropy {}.hessian_vector(&vector![x, 0.0], &vector![1.0, 0.0])[0];
    for x in [0.5_f64, 1.0, 3.0, 1e160, 1e200] {
        assert!((bend(x) * x + 1.0).abs() <= 2.0 * f64::EPSILON, "{x:e}: {:e}", bend(x));
    }
    assert!(Entropy {}.jacobian(&vector![-1.0, 0.0])[0].is_nan() && bend(-1.0).is_nan());
}
