//! Power series of recorded functions: what a macro wrote, run once over a scalar that notes its operations, then any
//! number of coefficients of it along a curve, each from those before.
//!
//! ```text
//! (a b)ₖ = Σⱼ aⱼ bₖ₋ⱼ      (a/b)ₖ = (aₖ − Σⱼ≥₁ bⱼ (a/b)ₖ₋ⱼ)/b₀      y = f(a):  yₖ = (1/k) Σⱼ≥₁ j aⱼ wₖ₋ⱼ,  w = f′(a)
//! ```
//!
//! xₖ is the coefficient of tᵏ. w is recorded too: √ has ½/y, exp itself, sin has cos. One coefficient of one operation
//! costs k products: N of them N²/2, where a scalar of whole series in the same code would cost N³/3 in a differential
//! equation, all N coefficients for each new one. Signs and choices are those at t = 0; where one turns just there, there is
//! no series, and coefficients are NaN.
//!
//! Source: E. Hairer, S. P. Nørsett, G. Wanner, *Solving Ordinary Differential Equations I*, I.8.

mod recording;

use crate::real::{Mask, Real};
pub(crate) use recording::{Recorded, record};

/// An operation, on earlier ones by their number; a slope may also be a later one, and is then known one order behind.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Operation {
    Constant(f64),
    Input(usize),
    Shift(usize, f64),
    Scale(usize, f64),
    /// a divided by a number.
    Ratio(usize, f64),
    Add(usize, usize),
    Subtract(usize, usize),
    Negate(usize),
    Multiply(usize, usize),
    Divide(usize, usize),
    Root(usize),
    /// f of a, with its derivative.
    Function(Function, usize, usize),
    /// f of a and b, with both derivatives.
    Function2(Function2, [usize; 2], [usize; 2]),
    Sign(usize),
    /// 1 or 0 by the values at t = 0.
    Less(usize, usize),
    AtMost(usize, usize),
    And(usize, usize),
    Or(usize, usize),
    Not(usize),
    /// b or c, as a is 1 or 0.
    Select(usize, usize, usize),
}

macro_rules! functions {
    ($($name:ident $method:ident)*) => {
        /// Functions of one number; other than those of `Operation` only in their first coefficient.
        #[derive(Debug, Clone, Copy, PartialEq)]
        enum Function { $($name),* }

        impl Function {
            fn value<T: Real>(self, x: T) -> T {
                match self { $(Self::$name => x.$method()),* }
            }
        }
    };
}
functions! {
    Cbrt cbrt Exp exp Ln ln Log10 log10 Log2 log2 Sin sin Cos cos Tan tan Asin asin Acos acos Atan atan
    Sinh sinh Cosh cosh Tanh tanh Asinh asinh Acosh acosh Atanh atanh Erf erf
}

/// Functions of two numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Function2 {
    Power,
    Angle,
    Length,
}

/// A recorded function of some inputs.
#[derive(Debug, Clone)]
pub(crate) struct Program {
    operations: Vec<Operation>,
    outputs: Vec<usize>,
}

impl Program {
    /// How many numbers the coefficients of all operations need, up to those of so many orders.
    pub(crate) fn room(&self, orders: usize) -> usize {
        self.operations.len() * orders
    }

    /// The coefficients of an output that are known.
    pub(crate) fn output<'a, T>(&self, output: usize, orders: usize, tape: &'a [T]) -> &'a [T] {
        &tape[self.outputs[output] * orders..][..orders]
    }

    /// Adds the coefficients of order `k` to the lower ones on the tape; `input` has those of the inputs.
    pub(crate) fn extend<T: Real>(
        &self,
        k: usize,
        orders: usize,
        tape: &mut [T],
        input: impl Fn(usize) -> T,
    ) {
        for (number, &operation) in self.operations.iter().enumerate() {
            let of = |a: usize| &tape[a * orders..][..=k];
            let at = |a: usize| tape[a * orders + k];
            let first = |a: usize| tape[a * orders];
            let constant = |x: f64| T::from_f64(if k == 0 { x } else { 0.0 });
            let holds = |mask: T::Mask| T::select(mask, T::from_f64(1.0), T::from_f64(0.0));
            let is = |a: usize| T::from_f64(0.5).lt(first(a));
            // A choice that turns just here has no series: 0 if a = b stays so, else NaN.
            let tie = |a: T, b: T, change: T| {
                let (zero, nan) = (T::from_f64(0.0), T::from_f64(f64::NAN));
                T::select(a.lt(b).or(b.lt(a)).or(change.le(zero).and(zero.le(change))), zero, nan)
            };
            let new = match operation {
                Operation::Constant(x) => constant(x),
                Operation::Input(i) => input(i),
                Operation::Shift(a, x) if k == 0 => at(a) + T::from_f64(x),
                Operation::Shift(a, _) => at(a),
                Operation::Scale(a, x) => at(a) * T::from_f64(x),
                Operation::Ratio(a, x) => at(a) / T::from_f64(x),
                Operation::Add(a, b) => at(a) + at(b),
                Operation::Subtract(a, b) => at(a) - at(b),
                Operation::Negate(a) => -at(a),
                Operation::Multiply(a, b) => convolution(of(a), of(b)),
                Operation::Divide(a, b) if k == 0 => at(a) / at(b),
                Operation::Divide(a, b) => (at(a) - convolution(&of(b)[1..], &of(number)[..k])) / first(b),
                Operation::Root(a) if k == 0 => at(a).sqrt(),
                Operation::Root(a) => {
                    let y = &of(number)[1..k];
                    (at(a) - convolution(y, y)) / (first(number) + first(number))
                }
                Operation::Function(function, a, _) if k == 0 => function.value(at(a)),
                Operation::Function(_, a, slope) => integral(of(a), &of(slope)[..k]),
                Operation::Function2(function, [a, b], _) if k == 0 => match function {
                    Function2::Power => at(a).powf(at(b)),
                    Function2::Angle => at(a).atan2(at(b)),
                    Function2::Length => at(a).hypot(at(b)),
                },
                Operation::Function2(_, [a, b], [slope_a, slope_b]) => {
                    integral(of(a), &of(slope_a)[..k]) + integral(of(b), &of(slope_b)[..k])
                }
                Operation::Select(a, b, c) if k == 0 => T::select(is(a), at(b), at(c)),
                Operation::Select(a, b, c) => T::select(is(a), at(b), at(c)) + at(a),
                // What follows is locally constant.
                Operation::Sign(a) if k == 0 => at(a).sign(),
                Operation::Sign(a) => tie(first(a), T::from_f64(0.0), at(a)),
                Operation::Less(a, b) if k == 0 => holds(at(a).lt(at(b))),
                Operation::AtMost(a, b) if k == 0 => holds(at(a).le(at(b))),
                Operation::Less(a, b) | Operation::AtMost(a, b) => tie(first(a), first(b), at(a) - at(b)),
                Operation::And(a, b) if k == 0 => at(a) * at(b),
                Operation::Or(a, b) if k == 0 => at(a).max(at(b)),
                Operation::And(a, b) | Operation::Or(a, b) => at(a) + at(b),
                Operation::Not(a) if k == 0 => T::from_f64(1.0) - at(a),
                Operation::Not(a) => at(a),
            };
            tape[number * orders + k] = new;
        }
    }
}

/// Σ aᵢ bⱼ over i + j = the last index of both.
fn convolution<T: Real>(a: &[T], b: &[T]) -> T {
    let products = a.iter().zip(b.iter().rev());
    products.fold(T::from_f64(0.0), |sum, (&a, &b)| sum + a * b)
}

/// The coefficient k ≥ 1 of ∫ a′ w dt, from a₀ … aₖ and w₀ … wₖ₋₁.
fn integral<T: Real>(a: &[T], slope: &[T]) -> T {
    let (mut sum, mut j) = (T::from_f64(0.0), 0.0);
    for (&a, &w) in a[1..].iter().zip(slope.iter().rev()) {
        j += 1.0;
        sum = sum + T::from_f64(j) * a * w;
    }
    sum / T::from_f64(j)
}
