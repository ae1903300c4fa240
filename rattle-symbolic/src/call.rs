//! Calls and powers: which functions there are, and what they take.

use crate::functions::{Binary, Function};
use crate::graph::Id;
use crate::lower::{Lowering, Value, described};
use crate::problems::{Extent, nearest};
use crate::syntax::Expr;
use proc_macro2::Ident;

/// A function that the table of one-argument functions does not hold.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Special {
    Min,
    Max,
    Two(Binary),
    Pow,
    Dot,
    Norm,
    Delta,
}

/// Name, what it is, fewest and most arguments, how it is written.
const SPECIAL: [(&str, Special, usize, usize, &str); 8] = [
    ("min", Special::Min, 2, 16, "min(a, b)"),
    ("max", Special::Max, 2, 16, "max(a, b)"),
    ("atan2", Special::Two(Binary::Atan2), 2, 2, "atan2(y, x)"),
    ("hypot", Special::Two(Binary::Hypot), 2, 2, "hypot(x, y)"),
    ("pow", Special::Pow, 2, 2, "pow(x, 2)"),
    ("dot", Special::Dot, 2, 2, "dot(a, b)"),
    ("norm", Special::Norm, 1, 16, "norm(a)"),
    ("delta", Special::Delta, 2, 2, "delta(i, j)"),
];

/// What other languages say, and what is said here.
const ALIASES: [(&str, &str); 24] = [
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
];

/// The largest whole exponent.
const STEEPEST: i64 = 1024;

impl Lowering<'_> {
    pub(crate) fn is_function(&self, name: &str) -> bool {
        Function::named(name).is_some() || SPECIAL.iter().any(|row| row.0 == name)
    }

    pub(crate) fn call(&mut self, name: &Ident, arguments: &[Expr], at: Extent) -> Value {
        let text = name.to_string();
        if let Some(function) = Function::named(&text) {
            return match self.arguments(name, arguments, (1, 1), &format!("{text}(x)")) {
                Some(values) => self.one(function, &values[0], arguments[0].extent, at),
                None => Value::Unknown,
            };
        }
        if let Some(&(_, special, fewest, most, written)) = SPECIAL.iter().find(|row| row.0 == text) {
            if special == Special::Pow && arguments.len() == 2 {
                return self.power(&arguments[0], &arguments[1]);
            }
            if special == Special::Delta && arguments.len() == 2 {
                return self.delta(&arguments[0], &arguments[1]);
            }
            return match self.arguments(name, arguments, (fewest, most), written) {
                Some(values) => self.special(special, &values, at),
                None => Value::Unknown,
            };
        }
        for argument in arguments {
            self.expression(argument);
        }
        let at = self.problems.extent(name.span());
        if let Some((_, instead)) = ALIASES.iter().find(|(alias, _)| *alias == text) {
            return self.wrong(at, format!("unknown function `{text}`; write {instead}"));
        }
        if self.is_known(&text) {
            let message = format!("`{text}` is no function; a product is written `{text} * (…)`");
            return self.wrong(at, message);
        }
        let names = Function::ALL.iter().map(|function| function.name());
        let names: Vec<&str> =
            names.chain(SPECIAL.iter().map(|row| row.0)).chain(["sum", "product"]).collect();
        self.unreadable = true; // whatever seems unused may have been meant
        match nearest(&text, names.iter().copied()) {
            Some(near) => self.wrong(at, format!("unknown function `{text}`; did you mean `{near}`?")),
            None => {
                self.wrong(at, format!("unknown function `{text}`, expected one of {}", names.join(", ")))
            }
        }
    }

    /// The values of the arguments, if their number is right and all are known.
    fn arguments(
        &mut self,
        name: &Ident,
        arguments: &[Expr],
        (fewest, most): (usize, usize),
        written: &str,
    ) -> Option<Vec<Value>> {
        let values: Vec<Value> = arguments.iter().map(|argument| self.expression(argument)).collect();
        if (fewest..=most).contains(&values.len()) {
            return values.iter().all(|value| !matches!(value, Value::Unknown)).then_some(values);
        }
        let expected = match (fewest, most) {
            (1, 1) => "1 argument".to_owned(),
            (a, b) if a == b => format!("{a} arguments"),
            (a, _) => format!("at least {a} arguments"),
        };
        let at = self.problems.extent(name.span());
        self.wrong(at, format!("`{name}` takes {expected}, found {}; write `{written}`", values.len()));
        None
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

    fn special(&mut self, special: Special, values: &[Value], at: Extent) -> Value {
        let mut numbers = Vec::new();
        match (special, values) {
            (Special::Dot, [a, b]) => {
                let mut others = Vec::new();
                if a.shape() != b.shape() || a.shape().is_none_or(|shape| shape.is_empty()) {
                    let of = |value: &Value| described(&value.shape().unwrap_or_default());
                    let (a, b) = (of(a), of(b));
                    return self.wrong(at, format!("`dot` takes two arrays of one shape, found {a} and {b}"));
                }
                a.numbers(&mut numbers);
                b.numbers(&mut others);
                let products = numbers.into_iter().zip(others).map(|(a, b)| self.graph.mul(a, b)).collect();
                self.total(products)
            }
            (Special::Norm, _) => {
                for value in values {
                    value.numbers(&mut numbers);
                }
                let squares = numbers.into_iter().map(|x| self.graph.power(x, 4)).collect();
                match self.total(squares) {
                    Value::Number(sum) => Value::Number(self.graph.call(Function::Sqrt, sum)),
                    other => other,
                }
            }
            _ => {
                for value in values {
                    match value {
                        Value::Number(id) => numbers.push(*id),
                        _ => {
                            return self.wrong(
                                at,
                                "these arguments must be numbers, found an array; use its components",
                            );
                        }
                    }
                }
                let combine = |lowering: &mut Self, a: Id, b: Id| match special {
                    Special::Min => lowering.graph.min(a, b),
                    Special::Max => lowering.graph.max(a, b),
                    Special::Two(binary) => lowering.graph.call2(binary, a, b),
                    _ => a,
                };
                match numbers.into_iter().reduce(|a, b| combine(self, a, b)) {
                    Some(result) => Value::Number(result),
                    None => Value::Unknown,
                }
            }
        }
    }

    fn total(&mut self, terms: Vec<Id>) -> Value {
        match terms.into_iter().reduce(|a, b| self.graph.add(a, b)) {
            Some(sum) => Value::Number(sum),
            None => Value::Unknown,
        }
    }

    fn delta(&mut self, i: &Expr, j: &Expr) -> Value {
        let (i, j) = (self.whole(i), self.whole(j));
        match (i, j) {
            (Some(i), Some(j)) => Value::Number(self.graph.constant(if i == j { 1.0 } else { 0.0 })),
            _ => Value::Unknown,
        }
    }

    /// base ^ exponent: a chain of multiplications and roots where the exponent is a multiple of ½ or ⅓.
    pub(crate) fn power(&mut self, base: &Expr, exponent: &Expr) -> Value {
        let base_value = self.expression(base);
        let ratio = self.ratio(exponent);
        let exponent_value = match ratio {
            Some(_) => None,
            None => Some(self.expression(exponent)),
        };
        let x = match base_value {
            Value::Number(x) => x,
            Value::Unknown => return Value::Unknown,
            Value::Array(_) => {
                return self.wrong(
                    base.extent,
                    "found an array, expected a number; a square is written `dot(a, a)`",
                );
            }
        };
        let known = self.graph.number(x);
        let (y, real) = match (ratio, exponent_value) {
            (Some(ratio), _) => {
                if ratio.value().abs() > STEEPEST as f64 {
                    let message = format!("the exponent is {ratio}, expected at most {STEEPEST}");
                    return self.wrong(exponent.extent, message);
                }
                if known == Some(0.0) && ratio.value() < 0.0 {
                    return self.wrong(base.extent, "division by zero: this is 0 and the exponent negative");
                }
                if known.is_some_and(|x| x < 0.0) && ratio.whole().is_none() && ratio.parts(3).is_none() {
                    return self.wrong(
                        base.extent,
                        format!("the power {ratio} of the negative {} is not real", known.unwrap_or(0.0)),
                    );
                }
                if let Some(halves) = ratio.parts(2).and_then(|halves| i32::try_from(halves).ok()) {
                    return Value::Number(self.graph.power(x, halves));
                }
                if let Some(thirds) = ratio.parts(3).and_then(|thirds| i32::try_from(thirds).ok()) {
                    let root = self.graph.call(Function::Cbrt, x);
                    return Value::Number(self.graph.power(root, 2 * thirds));
                }
                (self.graph.constant(ratio.value()), ratio.value())
            }
            (None, Some(Value::Number(y))) => (y, self.graph.number(y).unwrap_or(f64::NAN)),
            (None, Some(Value::Array(_))) => {
                return self.wrong(exponent.extent, "found an array, expected a number as the exponent");
            }
            _ => return Value::Unknown,
        };
        if let Some(x) = known
            && real.is_finite()
            && !x.powf(real).is_finite()
        {
            let at = base.extent.to(exponent.extent);
            return self.wrong(at, format!("`{x}^{real}` is {}", named(x.powf(real))));
        }
        Value::Number(self.graph.call2(Binary::Powf, x, y))
    }
}

/// What a result is, in words.
fn named(result: f64) -> &'static str {
    if result.is_nan() { "not a real number" } else { "infinite" }
}
