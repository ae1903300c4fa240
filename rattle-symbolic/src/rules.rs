//! Derivatives of functions: that column of the table in [`functions`](crate::functions), and its pieces.
//!
//! At the edge of its domain a derivative follows these rules:
//!
//! ```text
//! abs′(0) = +1     sign′ = floor′ = 0      sqrt′(0) = cbrt′(0) = 0      norm′(0) = hypot′(0, 0) = atan2′(0, 0) = 0
//! (xʸ)′(0) = 0 for 0 ≤ y < 1
//! ```
//!
//! Powers of roots and distances that are smooth again have their own slopes: √x², ∛x³, hypot(x, y)².
//! Everywhere else it is what IEEE 754 makes of the formula: `ln′(0) = ∞`, and `asin′(1)` is infinite, of either sign.

use crate::algebra::Scaled;
use crate::functions::{Binary, Function, functions_of_one, functions_of_two};
use crate::graph::Graph;
use crate::node::{Comparison, Id, Node};
use std::f64::consts::{FRAC_2_SQRT_PI, LOG2_E, LOG10_E};

const THIRD: f64 = 1.0 / 3.0;

macro_rules! derivatives {
    ($($variant:ident $name:literal, $value:expr, $products:literal, $derivative:expr;)*) => {
        /// f′(x), where f(x) is known.
        pub(crate) fn derivative(function: Function, graph: &mut Graph, x: Id, f: Id) -> Scaled {
            let rule: fn(&mut Graph, Id, Id) -> Scaled = match function { $(Function::$variant => $derivative),* };
            rule(graph, x, f)
        }
    };
}
functions_of_one!(derivatives);

macro_rules! derivatives_of_two {
    ($($variant:ident $name:literal, $value:expr, $products:literal, $derivatives:expr, $meaning:literal;)*) => {
        /// (∂f/∂a, ∂f/∂b), where f(a, b) is known.
        pub(crate) fn derivatives(function: Binary, graph: &mut Graph, a: Id, b: Id, f: Id) -> [Scaled; 2] {
            let rules: fn(&mut Graph, Id, Id, Id) -> [Scaled; 2] =
                match function { $(Binary::$variant => $derivatives),* };
            rules(graph, a, b, f)
        }
    };
}
functions_of_two!(derivatives_of_two);

/// The pieces that derivatives are made of.
impl Graph {
    /// 1/x, and 0 where x ≤ 0: for roots, whose slope at the tip is set to 0.
    fn guarded_reciprocal(&mut self, x: Id) -> Scaled {
        let zero = self.constant(0.0);
        let reciprocal = self.power(x, -2);
        let guarded = self.select(Comparison::LessOrEqual, x, zero, zero, reciprocal);
        self.finite(guarded);
        self.tip(guarded).into()
    }
    fn reciprocal_of(&mut self, x: Scaled) -> Scaled {
        let x = self.node_of(x);
        self.reciprocal(x)
    }
    /// `slope`, and no number where x < 0 and the function is none: its slope is, and would hide that.
    pub(crate) fn unless_negative(&mut self, x: Id, slope: Scaled) -> Scaled {
        if self.never_negative(x) {
            return slope;
        }
        let (slope, zero, none) = (self.node_of(slope), self.constant(0.0), self.constant(f64::NAN));
        self.select(Comparison::Less, x, zero, none, slope).into()
    }
    /// 1/x where the logarithm is a number.
    fn slope_of_logarithm(&mut self, x: Id) -> Scaled {
        let slope = self.reciprocal(x);
        self.unless_negative(x, slope)
    }
    /// 1/(1 − x²), and no number where x² > 1.
    fn reciprocal_within_one(&mut self, x: Id) -> Scaled {
        let inside = self.one_minus_square(x);
        let inside = self.node_of(inside);
        let slope = self.reciprocal(inside);
        self.unless_negative(inside, slope)
    }
    /// 1/√(of x)
    fn reciprocal_root(&mut self, of: fn(&mut Graph, Id) -> Scaled, x: Id) -> Scaled {
        let inside = of(self, x);
        let inside = self.node_of(inside);
        self.power(inside, -1).into()
    }
    /// shift + scale·x²
    fn shifted_square(&mut self, shift: f64, x: Id, scale: f64) -> Scaled {
        let square = self.product(&[x.into(), x.into()]).times(scale);
        self.sum(&[Scaled::number(shift), square])
    }
    /// 1 − x², as (1 − x)(1 + x): exact near ±1, where it matters.
    fn one_minus_square(&mut self, x: Id) -> Scaled {
        let one = Scaled::number(1.0);
        let (less, more) = (self.sum(&[one, Scaled::from(x).times(-1.0)]), self.sum(&[one, x.into()]));
        self.product(&[less, more])
    }
    /// x² − 1, as (x − 1)(x + 1).
    fn square_minus_one(&mut self, x: Id) -> Scaled {
        self.one_minus_square(x).times(-1.0)
    }
    fn sum_of_squares(&mut self, a: Id, b: Id) -> Scaled {
        let (a, b) = (self.product(&[a.into(), a.into()]), self.product(&[b.into(), b.into()]));
        self.sum(&[a, b])
    }
    /// ±1 by the sign of x, +1 at zero.
    fn signum(&mut self, x: Id) -> Scaled {
        let (zero, one, minus) = (self.constant(0.0), self.constant(1.0), self.constant(-1.0));
        self.select(Comparison::Less, x, zero, minus, one).into()
    }
    /// exp(−x²)
    fn bell(&mut self, x: Id) -> Scaled {
        let square = self.product(&[x.into(), x.into()]).times(-1.0);
        let square = self.node_of(square);
        self.call(Function::Exp, square).into()
    }
    /// ∂(xʸ)/∂y = f ln x, and 0 where x is. Where x < 0 it is 0 as well while f is a number, as that of `x^max(y, 2)`
    /// may be, and no number where f is none.
    fn growth(&mut self, x: Id, f: Id) -> Scaled {
        let logarithm = self.call(Function::Ln, x);
        let product = self.product(&[f.into(), logarithm.into()]);
        let (product, zero) = (self.node_of(product), self.constant(0.0));
        let slope = self.select(Comparison::LessOrEqual, x, zero, zero, product);
        if self.never_negative(x) {
            return slope.into();
        }
        let none_or_zero = self.sub(f, f);
        self.select(Comparison::Less, x, zero, none_or_zero, slope).into()
    }

    /// ∂(aᵇ)/∂a and ∂(aᵇ)/∂b
    fn slopes_of_power(&mut self, a: Id, b: Id, f: Id) -> [Scaled; 2] {
        let (zero, one) = (self.constant(0.0), self.constant(1.0));
        let root = self.is_written(f);
        let power = match self.number(b) {
            // f/a: b − 1 is rounded, where that of larger b is not. But their f may be 0 where this is not.
            Some(exponent) if root && exponent < 1.0 => self.div(f, a),
            _ => {
                let less = self.sub(b, one);
                self.call2(Binary::Powf, a, less)
            }
        };
        let slope = self.product(&[b.into(), power.into()]);
        let slope = self.node_of(slope);
        // At the tip of a root the slope is set to 0, and it is 0 where the exponent is, though 0·0⁻¹ is NaN. Roots
        // that derivatives are made of have their infinite slopes: those of x^(6/5) bend it without end.
        let at_zero = match self.number(b) {
            Some(exponent) if exponent == 0.0 || (root && 0.0 < exponent && exponent < 1.0) => zero,
            Some(_) => slope,
            None => {
                let (comparison, most) =
                    if root { (Comparison::Less, one) } else { (Comparison::LessOrEqual, zero) };
                let flat = self.select(comparison, b, most, zero, slope);
                self.select(Comparison::Less, b, zero, slope, flat)
            }
        };
        let not_below = self.select(Comparison::LessOrEqual, zero, a, at_zero, slope);
        let by_base = self.select(Comparison::LessOrEqual, a, zero, not_below, slope);
        let by_exponent = if self.moving(b) { self.growth(a, f) } else { Scaled::ZERO };
        [self.tip(by_base).into(), by_exponent]
    }
    /// a and b, where the node is aᵇ or one such power divided by a, and b is a number.
    pub(crate) fn power_of(&self, mut node: Id) -> Option<(Id, f64)> {
        let (mut divided, mut by) = (0.0, None);
        while let Node::Div(above, below) = *self.node(node) {
            (node, divided, by) =
                (above, divided + 1.0, Some(*by.get_or_insert(below)).filter(|&a| a == below));
            by?;
        }
        match *self.node(node) {
            Node::Call2(Binary::Powf, a, b) if by.is_none_or(|by| by == a) => {
                Some((a, self.number(b)? - divided))
            }
            _ => None,
        }
    }
    /// ∂f/∂u of f = c/bᵉ, where b is u or powers and roots of it: −n f/u, f ∝ u⁻ⁿ. Powers of u that are too large or
    /// too small for numbers are not met on the way.
    pub(crate) fn slope_of_reciprocal(&mut self, b: Id, f: Id, exponent: f64) -> (Id, Scaled) {
        let (mut u, mut n) = (b, exponent);
        loop {
            (u, n) = match *self.node(u) {
                Node::Power(inside, halves) => (inside, n * f64::from(halves) / 2.0),
                Node::Call(Function::Sqrt, inside) => (inside, n / 2.0),
                _ => break,
            };
        }
        let reciprocal = self.reciprocal(u);
        (u, self.product(&[Scaled::number(-n), f.into(), reciprocal]))
    }
    /// The slopes of `atan2(a, b)`: b/(a² + b²) and −a/(a² + b²).
    fn slopes_of_angle(&mut self, a: Id, b: Id) -> [Scaled; 2] {
        let (squares, a, b) = (self.sum_of_squares(a, b), Scaled::from(a), Scaled::from(b));
        let squares = self.node_of(squares);
        let q = self.guarded_reciprocal(squares);
        [self.product(&[b, q]), self.product(&[a, q]).times(-1.0)]
    }
    /// The slopes of `hypot(a, b)`: a/f and b/f.
    fn slopes_of_distance(&mut self, a: Id, b: Id, f: Id) -> [Scaled; 2] {
        let q = self.guarded_reciprocal(f);
        [self.product(&[a.into(), q]), self.product(&[b.into(), q])]
    }
}
