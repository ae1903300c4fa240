//! The meaning of each operation, over any kind of number.
//!
//! A graph uses this one definition to fold constants and to evaluate roots.

use crate::functions::{Binary, Function};
use crate::node::{Comparison, Id, Input, Node};

/// A number over which a graph can be evaluated.
pub trait Number: Copy {
    /// A constant.
    fn from_f64(x: f64) -> Self;
    /// −a
    fn neg(self) -> Self;
    /// a + b
    fn add(self, b: Self) -> Self;
    /// a − b
    fn sub(self, b: Self) -> Self;
    /// a · b
    fn mul(self, b: Self) -> Self;
    /// a / b
    fn div(self, b: Self) -> Self;
    /// f(a)
    fn call(self, function: Function) -> Self;
    /// f(a, b)
    fn call2(self, function: Binary, b: Self) -> Self;
    /// Whether the comparison of a with b holds.
    fn compare(self, comparison: Comparison, b: Self) -> bool;
}

impl Number for f64 {
    fn from_f64(x: f64) -> f64 {
        x
    }
    fn neg(self) -> f64 {
        -self
    }
    fn add(self, b: f64) -> f64 {
        self + b
    }
    fn sub(self, b: f64) -> f64 {
        self - b
    }
    fn mul(self, b: f64) -> f64 {
        self * b
    }
    fn div(self, b: f64) -> f64 {
        self / b
    }
    fn call(self, function: Function) -> f64 {
        function.evaluate(self)
    }
    fn call2(self, function: Binary, b: f64) -> f64 {
        function.evaluate(self, b)
    }
    fn compare(self, comparison: Comparison, b: f64) -> bool {
        match comparison {
            Comparison::Less => self < b,
            Comparison::LessOrEqual => self <= b,
        }
    }
}

/// The value of one node from those of its children.
pub(crate) fn operation<N: Number>(node: &Node, at: impl Fn(Id) -> N, input: impl Fn(Input) -> N) -> N {
    match *node {
        Node::Constant(bits) => N::from_f64(f64::from_bits(bits)),
        Node::Input(which) => input(which),
        Node::Neg(a) => at(a).neg(),
        Node::Add(a, b) => at(a).add(at(b)),
        Node::Sub(a, b) => at(a).sub(at(b)),
        Node::Mul(a, b) => at(a).mul(at(b)),
        Node::Div(a, b) => at(a).div(at(b)),
        Node::Power(a, halves) => power(at(a), halves),
        Node::Call(function, a) => at(a).call(function),
        Node::Call2(function, a, b) => at(a).call2(function, at(b)),
        Node::Select(comparison, a, b, then, other) => {
            at(if at(a).compare(comparison, at(b)) { then } else { other })
        }
        Node::Sum(ref terms) => terms
            .iter()
            .map(|&(bits, a)| N::from_f64(f64::from_bits(bits)).mul(at(a)))
            .reduce(N::add)
            .unwrap_or(N::from_f64(0.0)),
        Node::Product(ref factors) => factors
            .iter()
            .map(|&(a, exponent)| power(at(a), 2 * exponent as i32))
            .reduce(N::mul)
            .unwrap_or(N::from_f64(1.0)),
    }
}

/// Whether a node is 0 or more, or no number, by its form alone, where it is known of its children.
pub(crate) fn never_negative(
    node: &Node,
    of: impl Fn(Id) -> bool,
    number: impl Fn(Id) -> Option<f64>,
) -> bool {
    match *node {
        Node::Constant(bits) => f64::from_bits(bits) >= 0.0,
        Node::Input(_) | Node::Neg(_) | Node::Sub(..) => false,
        Node::Add(a, b) | Node::Mul(a, b) | Node::Div(a, b) => of(a) && of(b),
        Node::Power(a, halves) => halves % 4 == 0 || halves % 2 != 0 || of(a),
        Node::Call(Function::Sqrt | Function::Exp | Function::Cosh | Function::Acosh | Function::Abs, _) => {
            true
        }
        Node::Call(Function::Cbrt | Function::Floor | Function::Sign | Function::Erf, a) => of(a),
        Node::Call(..) => false,
        Node::Call2(Binary::Hypot, ..) => true,
        Node::Call2(Binary::Powf, a, _) => of(a),
        Node::Call2(Binary::Atan2, ..) => false,
        // The larger of two numbers: the first where the second is none. And a choice between any.
        Node::Select(_, a, b, then, other) if (then, other) == (b, a) => {
            of(a) || number(b).is_some_and(|b| b >= 0.0)
        }
        Node::Select(_, _, _, then, other) => of(then) && of(other),
        Node::Sum(ref terms) => terms.iter().all(|&(bits, a)| f64::from_bits(bits) >= 0.0 && of(a)),
        Node::Product(ref factors) => factors.iter().all(|&(a, exponent)| exponent % 2 == 0 || of(a)),
    }
}

fn power<N: Number>(a: N, halves: i32) -> N {
    chain(halves, &mut (), a, &mut |(), a, b| a.mul(b), &mut |(), a| a.call(Function::Sqrt), &mut |(), a| {
        N::from_f64(1.0).div(a)
    })
}

/// a^(halves/2) by multiplications in a fixed order, the definition of `^` for such exponents.
///
/// ```text
/// xⁿ = xⁿ⁻¹ · x (n odd)     xⁿ = xⁿᐟ² · xⁿᐟ² (n even)     xⁿ⁺½ = xⁿ · √x     x⁻ⁿ = 1 / xⁿ
/// ```
pub(crate) fn chain<C, T: Copy>(
    halves: i32,
    context: &mut C,
    a: T,
    mul: &mut impl FnMut(&mut C, T, T) -> T,
    sqrt: &mut impl FnMut(&mut C, T) -> T,
    reciprocal: &mut impl FnMut(&mut C, T) -> T,
) -> T {
    if halves < 0 {
        let positive = chain(-halves, context, a, mul, sqrt, reciprocal);
        return reciprocal(context, positive);
    }
    let (whole, half) = (halves / 2, halves % 2 == 1);
    let root = if half { Some(sqrt(context, a)) } else { None };
    let mut result: Option<T> = None;
    for bit in (0..32 - whole.leading_zeros()).rev() {
        result = result.map(|result| mul(context, result, result));
        if (whole >> bit) & 1 == 1 {
            result = Some(match result {
                Some(result) => mul(context, result, a),
                None => a,
            });
        }
    }
    match (result, root) {
        (Some(result), Some(root)) => mul(context, result, root),
        (Some(result), None) => result,
        (None, Some(root)) => root,
        (None, None) => a, // the exponent zero never becomes a power
    }
}
