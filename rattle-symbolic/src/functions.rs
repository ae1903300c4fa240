//! The functions of the language, one row each.
//!
//! A row holds the name (which is also the method of `Real` that evaluates it), how many arguments
//! it takes, its value for `f64`, and its derivative as an expression in the argument `x` and the
//! result `f`, which is already known. At the edge of its domain a derivative follows these rules:
//!
//! ```text
//! abs′(0) = +1     sign′ = 0      sqrt′(0) = cbrt′(0) = 0      norm′(0) = hypot′(0, 0) = atan2′(0, 0) = 0
//! ```
//!
//! Everywhere else it is what IEEE 754 makes of the formula: `ln′(0) = ∞`, `asin′(1) = ∞`.

use crate::algebra::Scaled;
use crate::graph::{Comparison, Graph, Id, Node};
use std::f64::consts::{FRAC_2_SQRT_PI, LOG2_E, LOG10_E};

macro_rules! table {
    ($($variant:ident $name:literal $evaluate:expr, $derivative:expr;)*) => {
        /// A function of one argument.
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
        #[allow(missing_docs, reason = "the name says it")]
        pub enum Function { $($variant),* }

        impl Function {
            /// All of them, in the order of the table.
            pub const ALL: &[Function] = &[$(Function::$variant),*];

            /// How the user writes it, and the method of `Real` that evaluates it.
            pub fn name(self) -> &'static str {
                match self { $(Function::$variant => $name),* }
            }
            /// f(x)
            pub fn evaluate(self, x: f64) -> f64 {
                let evaluate: fn(f64) -> f64 = match self { $(Function::$variant => $evaluate),* };
                evaluate(x)
            }
            pub(crate) fn derivative(self, graph: &mut Graph, x: Id, f: Id) -> Scaled {
                let rule: fn(&mut Graph, Id, Id) -> Scaled = match self { $(Function::$variant => $derivative),* };
                rule(graph, x, f)
            }
        }
    };
}

table! {
//  variant name    value       derivative
    Sqrt  "sqrt"  f64::sqrt,  |g, _, f| g.guarded_reciprocal(f).times(0.5);
    Cbrt  "cbrt"  f64::cbrt,  |g, _, f| { let square = g.power(f, 4); g.guarded_reciprocal(square).times(1.0 / 3.0) };
    Exp   "exp"   f64::exp,   |_, _, f| f.into();
    Ln    "ln"    f64::ln,    |g, x, _| g.reciprocal(x);
    Log10 "log10" f64::log10, |g, x, _| g.reciprocal(x).times(LOG10_E);
    Log2  "log2"  f64::log2,  |g, x, _| g.reciprocal(x).times(LOG2_E);
    Sin   "sin"   f64::sin,   |g, x, _| g.call(Function::Cos, x).into();
    Cos   "cos"   f64::cos,   |g, x, _| Scaled::from(g.call(Function::Sin, x)).times(-1.0);
    Tan   "tan"   f64::tan,   |g, _, f| g.shifted_square(1.0, f, 1.0);
    Asin  "asin"  f64::asin,  |g, x, _| g.reciprocal_root(Graph::one_minus_square, x);
    Acos  "acos"  f64::acos,  |g, x, _| g.reciprocal_root(Graph::one_minus_square, x).times(-1.0);
    Atan  "atan"  f64::atan,  |g, x, _| { let d = g.shifted_square(1.0, x, 1.0); g.reciprocal_of(d) };
    Sinh  "sinh"  f64::sinh,  |g, x, _| g.call(Function::Cosh, x).into();
    Cosh  "cosh"  f64::cosh,  |g, x, _| g.call(Function::Sinh, x).into();
    Tanh  "tanh"  f64::tanh,  |g, _, f| g.one_minus_square(f);
    Asinh "asinh" f64::asinh, |g, x, _| g.reciprocal_root(|g, x| g.shifted_square(1.0, x, 1.0), x);
    Acosh "acosh" f64::acosh, |g, x, _| g.reciprocal_root(Graph::square_minus_one, x);
    Atanh "atanh" f64::atanh, |g, x, _| { let d = g.one_minus_square(x); g.reciprocal_of(d) };
    Abs   "abs"   f64::abs,   |g, x, _| g.signum(x);
    Sign  "sign"  sign,       |_, _, _| Scaled::ZERO;
    Erf   "erf"   libm::erf,  |g, x, _| g.bell(x).times(FRAC_2_SQRT_PI);
}

impl Function {
    /// The function of that name.
    pub fn named(name: &str) -> Option<Function> {
        Function::ALL.iter().copied().find(|function| function.name() == name)
    }
}

/// A function of two arguments that is one operation of the scalar.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Binary {
    /// xʸ for an exponent that is no constant multiple of ½ or ⅓.
    Powf,
    /// The angle of the point (x, y), written `atan2(y, x)`.
    Atan2,
    /// √(x² + y²) without overflow on the way.
    Hypot,
}

impl Binary {
    /// All of them.
    pub const ALL: &[Binary] = &[Binary::Powf, Binary::Atan2, Binary::Hypot];

    /// The method of `Real` that evaluates it.
    pub fn name(self) -> &'static str {
        match self {
            Binary::Powf => "powf",
            Binary::Atan2 => "atan2",
            Binary::Hypot => "hypot",
        }
    }
    /// f(a, b)
    pub fn evaluate(self, a: f64, b: f64) -> f64 {
        match self {
            Binary::Powf => a.powf(b),
            Binary::Atan2 => a.atan2(b),
            Binary::Hypot => a.hypot(b),
        }
    }
    /// (∂f/∂a, ∂f/∂b)
    pub(crate) fn derivatives(self, g: &mut Graph, a: Id, b: Id, f: Id) -> [Scaled; 2] {
        match self {
            Binary::Powf => {
                let one = g.constant(1.0);
                let less = g.sub(b, one);
                let power = g.call2(Binary::Powf, a, less);
                let by_base = g.product(&[b.into(), power.into()]);
                let by_base = g.unless_zero(b, by_base);
                let by_exponent = if g.moving(b) { g.growth(a, f) } else { Scaled::ZERO };
                [by_base, by_exponent]
            }
            Binary::Atan2 => {
                let (squares, a, b) = (g.sum_of_squares(a, b), Scaled::from(a), Scaled::from(b));
                let squares = g.node_of(squares);
                let q = g.guarded_reciprocal(squares);
                [g.product(&[b, q]), g.product(&[a, q]).times(-1.0)]
            }
            Binary::Hypot => {
                let q = g.guarded_reciprocal(f);
                [g.product(&[a.into(), q]), g.product(&[b.into(), q])]
            }
        }
    }
}

/// −1, 0 or 1; NaN for NaN, as `Real::sign`.
fn sign(x: f64) -> f64 {
    if x > 0.0 {
        1.0
    } else if x < 0.0 {
        -1.0
    } else {
        x * 0.0
    }
}

/// The pieces that derivatives are made of.
impl Graph {
    /// 1/x, and 0 where x ≤ 0: for roots, whose slope at the tip is set to 0.
    pub(crate) fn guarded_reciprocal(&mut self, x: Id) -> Scaled {
        let zero = self.constant(0.0);
        let reciprocal = self.power(x, -2);
        self.select(Comparison::LessOrEqual, x, zero, zero, reciprocal).into()
    }
    pub(crate) fn reciprocal(&mut self, x: Id) -> Scaled {
        self.power(x, -2).into()
    }
    pub(crate) fn reciprocal_of(&mut self, x: Scaled) -> Scaled {
        let x = self.node_of(x);
        self.reciprocal(x)
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
    /// `slope`, and 0 where the exponent is 0: the power is constant there, though 0·0⁻¹ is NaN.
    fn unless_zero(&mut self, exponent: Id, slope: Scaled) -> Scaled {
        if matches!(self.node(exponent), Node::Constant(_)) {
            return slope;
        }
        let square = self.product(&[exponent.into(), exponent.into()]);
        let (square, slope, zero) = (self.node_of(square), self.node_of(slope), self.constant(0.0));
        self.select(Comparison::LessOrEqual, square, zero, zero, slope).into()
    }
    /// ∂(xʸ)/∂y = f ln x, and 0 where x ≤ 0.
    fn growth(&mut self, x: Id, f: Id) -> Scaled {
        let logarithm = self.call(Function::Ln, x);
        let product = self.product(&[f.into(), logarithm.into()]);
        let (product, zero) = (self.node_of(product), self.constant(0.0));
        self.select(Comparison::LessOrEqual, x, zero, zero, product).into()
    }
}
