//! Pair potentials are evaluated in s = r²: value and slope against the potential written by hand in r, for even and
//! odd functions, powers of either sign, and branches.

use rattle::prelude::*;

macro_rules! pairs {
    ($($name:ident, $expression:expr_2021, $value:expr_2021, $slope:expr_2021;)*) => {
        $(pair_potential! { struct $name { k } |r| $expression })*

        /// U(r) and U′(r)/r at distances on both sides of the branches.
        #[test]
        fn values_and_slopes() {
            $(for k in [0.7_f64, -1.3] {
                for r in [0.3_f64, 0.999, 1.001, 2.5] {
                    let potential = $name { k };
                    let (value, slope): (fn(f64, f64) -> f64, fn(f64, f64) -> f64) = ($value, $slope);
                    let (found, exact) = (PairPotential::value(&potential, r), value(k, r));
                    assert!((found - exact).abs() <= 1e-14 * (1.0 + exact.abs()), "{} at {r}: {found} {exact}", stringify!($name));
                    let (found, exact) = (potential.slope_over_distance(r), slope(k, r) / r);
                    assert!((found - exact).abs() <= 1e-13 * (1.0 + exact.abs()), "{}′ at {r}: {found} {exact}", stringify!($name));
                }
            })*
        }
    };
}

pairs! {
    Inverse, k * r^(-1), |k, r| k / r, |k, r| -k / (r * r);
    InverseCube, k * r^(-3), |k, r| k / r.powi(3), |k, r| -3.0 * k / r.powi(4);
    InverseSquare, k * r^(-2), |k, r| k / r.powi(2), |k, r| -2.0 * k / r.powi(3);
    OneOver, k + 1 / r, |k, r| k + 1.0 / r, |_, r| -1.0 / (r * r);
    MinusThree, k + r^-3, |k, r| k + r.powi(-3), |_, r| -3.0 * r.powi(-4);
    MinusOneOfRatio, (r / k)^-1, |k, r| k / r, |k, r| -k / (r * r);
    MinusFiveOfRatio, (k * r)^-5, |k, r| (k * r).powi(-5), |k, r| -5.0 * k * (k * r).powi(-6);
    OddTogetherEven, k * r^-3 * r, |k, r| k / (r * r), |k, r| -2.0 * k / r.powi(3);
    InverseTimesCube, r^-1 * (k * r)^3, |k, r| k.powi(3) * r * r, |k, r| 2.0 * k.powi(3) * r;
    TwoInverses, (1 / r) * r^-1 + k, |k, r| k + 1.0 / (r * r), |_, r| -2.0 / r.powi(3);
    Quotient, k / r, |k, r| k / r, |k, r| -k / (r * r);
    Twelve, (k / r)^12, |k, r| (k / r).powi(12), |k, r| -12.0 * (k / r).powi(12) / r;
    OddByOdd, (r^3 + k * r) / r, |k, r| r * r + k, |_, r| 2.0 * r;
    OddTimesOdd, sin(k) * r * r^3, |k, r| k.sin() * r.powi(4), |k, r| 4.0 * k.sin() * r.powi(3);
    Wave, sin(k * r) / r, |k, r| (k * r).sin() / r, |k, r| (k * (k * r).cos() - (k * r).sin() / r) / r;
    Yukawa, exp(-k * r) / r, |k, r| (-k * r).exp() / r, |k, r| -(-k * r).exp() * (k + 1.0 / r) / r;
    Branch, if r < 1 { k * r^2 } else { r },
        |k, r| if r < 1.0 { k * r * r } else { r }, |k, r| if r < 1.0 { 2.0 * k * r } else { 1.0 };
    Smaller, min(k * r^2, r), |k, r| (k * r * r).min(r), |k, r| if k * r * r <= r { 2.0 * k * r } else { 1.0 };
    Root, k * sqrt(1 + r^2), |k, r| k * (1.0 + r * r).sqrt(), |k, r| k * r / (1.0 + r * r).sqrt();
}
