//! Calls and powers: which functions there are, and what they make of the values of their arguments.

use crate::arithmetic::{Arithmetic, named};
use crate::functions::{Binary, Function};
use crate::graph::Graph;
use crate::node::Id;
use crate::problems::{Extent, nearest, rounded};
use crate::ratio::Ratio;
use crate::value::{Value, described};
use proc_macro2::Ident;

/// What a name calls.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Callee {
    One(Function),
    Two(Binary),
    Min,
    Max,
    /// What is left of a division with a whole quotient.
    Mod,
    /// The operator `^` as a function.
    Pow,
    Dot,
    Norm,
    /// Of two indices.
    Delta,
}

/// Beside the functions of one argument: name, what it is, fewest and most arguments, how it is written.
const SPECIAL: [(&str, Callee, usize, usize, &str); 9] = [
    ("min", Callee::Min, 2, 16, "min(a, b)"),
    ("max", Callee::Max, 2, 16, "max(a, b)"),
    ("mod", Callee::Mod, 2, 2, "mod(x, y)"),
    ("atan2", Callee::Two(Binary::Atan2), 2, 2, "atan2(y, x)"),
    ("hypot", Callee::Two(Binary::Hypot), 2, 2, "hypot(x, y)"),
    ("pow", Callee::Pow, 2, 2, "pow(x, 2)"),
    ("dot", Callee::Dot, 2, 2, "dot(a, b)"),
    ("norm", Callee::Norm, 1, 16, "norm(a)"),
    ("delta", Callee::Delta, 2, 2, "delta(i, j)"),
];

/// What other languages say, and what is said here.
const ALIASES: [(&str, &str); 33] = [
    ("log", "`ln(x)` or `log10(x)`"),
    ("lg", "`log10(x)` or `log2(x)`"),
    ("arctan", "`atan(x)`"),
    ("arcsin", "`asin(x)`"),
    ("arccos", "`acos(x)`"),
    ("arctan2", "`atan2(y, x)`"),
    ("arsinh", "`asinh(x)`"),
    ("arcosh", "`acosh(x)`"),
    ("artanh", "`atanh(x)`"),
    ("arcsinh", "`asinh(x)`"),
    ("arccosh", "`acosh(x)`"),
    ("arctanh", "`atanh(x)`"),
    ("cot", "`1 / tan(x)`"),
    ("sec", "`1 / cos(x)`"),
    ("csc", "`1 / sin(x)`"),
    ("sqr", "`x^2`"),
    ("square", "`x^2`"),
    ("powi", "`x^2`"),
    ("powf", "`x^2`"),
    ("recip", "`1 / x`"),
    ("fabs", "`abs(x)`"),
    ("signum", "`sign(x)`"),
    ("sgn", "`sign(x)`"),
    ("length", "`norm(a)`"),
    ("len", "the number itself: lengths are known, as in `sum(i in 0..3, a[i])`"),
    ("cross", "its components: `a[1] * b[2] - a[2] * b[1]` is the first of three"),
    ("fmod", "`mod(x, y)`, which has the sign of y"),
    ("rem", "`mod(x, y)`, which has the sign of y"),
    ("rem_euclid", "`mod(x, y)`, which has the sign of y"),
    ("fract", "`mod(x, 1)`"),
    ("ceil", "`-floor(-x)`"),
    ("round", "`floor(x + 1/2)`"),
    ("heaviside", "`if x < 0 { 0 } else { 1 }`"),
];

/// The largest whole exponent.
const STEEPEST: i64 = 1024;

/// An exponent: an exact fraction where it is made of numbers and indices alone.
pub(crate) enum Exponent {
    Exact(Ratio),
    Value(Value),
}

impl Callee {
    /// What is called so here.
    pub(crate) fn named(name: &str) -> Option<Callee> {
        let special = || SPECIAL.iter().find(|row| row.0 == name).map(|row| row.1);
        Function::named(name).map(Callee::One).or_else(special)
    }

    /// What to write for a name that nothing has here, but something has elsewhere.
    pub(crate) fn instead_of(name: &str) -> Option<&'static str> {
        ALIASES.iter().find(|(alias, _)| *alias == name).map(|&(_, instead)| instead)
    }

    /// The message for a name that nothing has.
    pub(crate) fn unknown(name: &str) -> String {
        let names = Function::ALL.iter().map(|function| function.name());
        let names: Vec<&str> =
            names.chain(SPECIAL.iter().map(|row| row.0)).chain(["sum", "product"]).collect();
        match nearest(name, names.iter().copied()) {
            Some(near) => format!("unknown function `{name}`; did you mean `{near}`?"),
            None => format!("unknown function `{name}`, expected one of {}", names.join(", ")),
        }
    }

    /// Fewest and most arguments, and how it is written.
    fn arity(self, name: &Ident) -> (usize, usize, String) {
        match SPECIAL.iter().find(|row| row.1 == self) {
            Some(&(_, _, fewest, most, written)) => (fewest, most, written.to_owned()),
            None => (1, 1, format!("{name}(x)")),
        }
    }
}

impl Arithmetic<'_> {
    /// A function of values, each with where it is written.
    pub(crate) fn call(
        &mut self,
        callee: Callee,
        name: &Ident,
        arguments: &[(Value, Extent)],
        at: Extent,
    ) -> Value {
        let (fewest, most, written) = callee.arity(name);
        if !(fewest..=most).contains(&arguments.len()) {
            let expected = match (fewest, most) {
                (1, 1) => "1 argument".to_owned(),
                (a, b) if a == b => format!("{a} arguments"),
                (a, b) => format!("{a} to {b} arguments"),
            };
            let at = self.problems.extent_of(name);
            let found = arguments.len();
            return self.wrong(at, format!("`{name}` takes {expected}, found {found}; write `{written}`"));
        }
        if arguments.iter().any(|(value, _)| matches!(value, Value::Unknown)) {
            return Value::Unknown;
        }
        match (callee, arguments) {
            (Callee::One(function), [(x, inside)]) => self.one(function, x, *inside, at),
            (Callee::Dot, [(a, _), (b, _)]) => self.dot(a, b, at),
            (Callee::Norm, _) => self.norm(arguments),
            _ => self.reduced(callee, arguments, at),
        }
    }

    fn one(&mut self, function: Function, argument: &Value, inside: Extent, at: Extent) -> Value {
        let Value::Number(x) = *argument else {
            if let Some(shape) = argument.shape() {
                let name = function.name();
                let shape = described(&shape);
                self.wrong(
                    inside,
                    format!("`{name}` takes a number, found {shape}; apply it to the components"),
                );
            }
            return Value::Unknown;
        };
        if let Some(number) = self.graph.number(x)
            && !function.evaluate(number).is_finite()
        {
            let result = function.evaluate(number);
            let advice = if function == Function::Sqrt {
                "; an even root needs a number that is not negative"
            } else {
                ""
            };
            return self.wrong(at, format!("`{}({number})` is {}{advice}", function.name(), named(result)));
        }
        Value::Number(self.graph.call(function, x))
    }

    fn dot(&mut self, a: &Value, b: &Value, at: Extent) -> Value {
        if a.shape() != b.shape() || a.shape().is_none_or(|shape| shape.is_empty()) {
            let of = |value: &Value| described(&value.shape().unwrap_or_default());
            let (a, b) = (of(a), of(b));
            return self.wrong(at, format!("`dot` takes two arrays of one shape, found {a} and {b}"));
        }
        let (mut left, mut right) = (Vec::new(), Vec::new());
        a.numbers(&mut left);
        b.numbers(&mut right);
        let products = left.into_iter().zip(right).map(|(a, b)| self.graph.mul(a, b)).collect();
        self.total(products)
    }

    fn norm(&mut self, arguments: &[(Value, Extent)]) -> Value {
        let mut numbers = Vec::new();
        for (value, _) in arguments {
            value.numbers(&mut numbers);
        }
        let squares = numbers.into_iter().map(|x| self.graph.power(x, 4)).collect();
        match self.total(squares) {
            Value::Number(sum) => Value::Number(self.graph.call(Function::Sqrt, sum)),
            other => other,
        }
    }

    fn total(&mut self, terms: Vec<Id>) -> Value {
        match terms.into_iter().reduce(|a, b| self.graph.add(a, b)) {
            Some(sum) => Value::Number(sum),
            None => Value::Unknown,
        }
    }

    /// A function of two numbers, of several by taking one after the other.
    fn reduced(&mut self, callee: Callee, arguments: &[(Value, Extent)], at: Extent) -> Value {
        let mut numbers = Vec::new();
        for (value, _) in arguments {
            match value {
                Value::Number(id) => numbers.push(*id),
                _ => {
                    let message = "these arguments must be numbers, found an array; use its components";
                    return self.wrong(at, message);
                }
            }
        }
        if let (Callee::Mod, [_, (_, divisor)]) = (callee, arguments)
            && self.graph.number(numbers[1]) == Some(0.0)
        {
            return self.wrong(*divisor, "division by zero: `mod(x, 0)` is not a number");
        }
        let combine = |graph: &mut Graph, a: Id, b: Id| match callee {
            Callee::Mod => {
                let quotient = graph.div(a, b);
                let floor = graph.call(Function::Floor, quotient);
                let whole = graph.mul(b, floor);
                graph.sub(a, whole)
            }
            Callee::Min => graph.min(a, b),
            Callee::Max => graph.max(a, b),
            Callee::Two(binary) => graph.call2(binary, a, b),
            _ => a,
        };
        match numbers.into_iter().reduce(|a, b| combine(self.graph, a, b)) {
            Some(result) => Value::Number(result),
            None => Value::Unknown,
        }
    }

    /// base ^ exponent: a chain of multiplications and roots where the exponent is a multiple of ½ or ⅓.
    pub(crate) fn power(
        &mut self,
        (base, base_at): (Value, Extent),
        (exponent, exponent_at): (Exponent, Extent),
    ) -> Value {
        let x = match base {
            Value::Number(x) => x,
            Value::Unknown => return Value::Unknown,
            Value::Array(_) => {
                let message = "found an array, expected a number; a square is written `dot(a, a)`";
                return self.wrong(base_at, message);
            }
        };
        let known = self.graph.number(x);
        if let (Some(base), Exponent::Value(Value::Number(y))) = (known, &exponent)
            && base <= 0.0
            && self.graph.moving(*y)
        {
            let message =
                format!("the base is {base}; an exponent that depends on variables needs a positive one");
            return self.wrong(base_at, message);
        }
        let (y, real) = match exponent {
            Exponent::Exact(ratio) if ratio.value().abs() > STEEPEST as f64 => {
                let message = format!("the exponent is {ratio}, expected at most {STEEPEST}");
                return self.wrong(exponent_at, message);
            }
            Exponent::Exact(ratio) => {
                if known == Some(0.0) && ratio.value() < 0.0 {
                    return self.wrong(base_at, "division by zero: this is 0 and the exponent negative");
                }
                if known.is_some_and(|x| x < 0.0) && ratio.whole().is_none() && ratio.parts(3).is_none() {
                    return self.wrong(
                        base_at,
                        format!("the power {ratio} of the negative {} is not real", known.unwrap_or(0.0)),
                    );
                }
                if let Some(halves) = ratio.parts(2).and_then(|halves| i32::try_from(halves).ok()) {
                    let power = self.graph.power(x, halves);
                    return self.sized(power, &[x], base_at.to(exponent_at));
                }
                if let Some(thirds) = ratio.parts(3).and_then(|thirds| i32::try_from(thirds).ok()) {
                    let root = self.graph.call(Function::Cbrt, x);
                    let power = self.graph.power(root, 2 * thirds);
                    return self.sized(power, &[x], base_at.to(exponent_at));
                }
                (self.graph.constant(ratio.value()), ratio.value())
            }
            Exponent::Value(Value::Number(y)) => (y, self.graph.number(y).unwrap_or(f64::NAN)),
            Exponent::Value(Value::Array(_)) => {
                return self.wrong(exponent_at, "found an array, expected a number as the exponent");
            }
            Exponent::Value(Value::Unknown) => return Value::Unknown,
        };
        if real.abs() > STEEPEST as f64 {
            let message = format!("the exponent is {}, expected at most {STEEPEST}", rounded(real));
            return self.wrong(exponent_at, message);
        }
        if let Some(x) = known
            && real.is_finite()
            && !x.powf(real).is_finite()
        {
            let at = base_at.to(exponent_at);
            return self.wrong(at, format!("`{x}^{real}` is {}", named(x.powf(real))));
        }
        let power = self.graph.call2(Binary::Powf, x, y);
        self.sized(power, &[x], base_at.to(exponent_at))
    }
}
