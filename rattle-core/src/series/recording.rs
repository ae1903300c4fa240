//! A scalar that notes its operations.
//!
//! Numbers that depend on constants alone are computed at once.

use super::{Function, Function2, Operation, Program};
use crate::real::{Mask, Real};
use std::cell::RefCell;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// An operation of the recording under way on this thread, by its number.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Recorded(u32);

/// A comparison, recorded.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RecordedMask(Recorded);

#[derive(Default)]
struct Recording {
    operations: Vec<Operation>,
    /// Whether a program asked which way to go; it can then not be recorded.
    branched: bool,
}

thread_local! {
    static RECORDING: RefCell<Recording> = RefCell::default();
}

/// The operations by which `function` gets its outputs from so many inputs; none if it goes different ways by their values.
pub(crate) fn record(inputs: usize, function: impl FnOnce(&[Recorded]) -> Vec<Recorded>) -> Option<Program> {
    RECORDING.take();
    let inputs: Vec<Recorded> = (0..inputs).map(|i| note(Operation::Input(i))).collect();
    let outputs = function(&inputs);
    let Recording { operations, branched } = RECORDING.take();
    let outputs = outputs.into_iter().map(|output| output.0 as usize).collect();
    (!branched).then(|| needed(&operations, outputs))
}

fn note(operation: Operation) -> Recorded {
    RECORDING.with_borrow_mut(|recording| {
        recording.operations.push(operation);
        let number = recording.operations.len() - 1;
        Recorded(u32::try_from(number).expect("a recording of less than 2³² operations"))
    })
}

/// The operations without those that no output needs.
fn needed(operations: &[Operation], outputs: Vec<usize>) -> Program {
    let mut place = vec![usize::MAX; operations.len()];
    let mut open = outputs.clone();
    while let Some(number) = open.pop() {
        if place[number] == usize::MAX {
            place[number] = 0;
            renumbered(operations[number], |operand| {
                open.push(operand);
                operand
            });
        }
    }
    for (kept, place) in place.iter_mut().filter(|place| **place == 0).enumerate() {
        *place = kept;
    }
    let kept = operations.iter().enumerate().filter(|&(number, _)| place[number] != usize::MAX);
    let operations = kept.map(|(_, &operation)| renumbered(operation, |operand| place[operand])).collect();
    Program { operations, outputs: outputs.into_iter().map(|output| place[output]).collect() }
}

/// The same operation on other operands.
fn renumbered(operation: Operation, mut to: impl FnMut(usize) -> usize) -> Operation {
    match operation {
        Operation::Constant(_) | Operation::Input(_) => operation,
        Operation::Shift(a, x) => Operation::Shift(to(a), x),
        Operation::Scale(a, x) => Operation::Scale(to(a), x),
        Operation::Ratio(a, x) => Operation::Ratio(to(a), x),
        Operation::Add(a, b) => Operation::Add(to(a), to(b)),
        Operation::Subtract(a, b) => Operation::Subtract(to(a), to(b)),
        Operation::Negate(a) => Operation::Negate(to(a)),
        Operation::Multiply(a, b) => Operation::Multiply(to(a), to(b)),
        Operation::Divide(a, b) => Operation::Divide(to(a), to(b)),
        Operation::Root(a) => Operation::Root(to(a)),
        Operation::Function(f, a, slope) => Operation::Function(f, to(a), to(slope)),
        Operation::Function2(f, of, slopes) => {
            let of = of.map(&mut to);
            Operation::Function2(f, of, slopes.map(to))
        }
        Operation::Sign(a) => Operation::Sign(to(a)),
        Operation::Less(a, b) => Operation::Less(to(a), to(b)),
        Operation::AtMost(a, b) => Operation::AtMost(to(a), to(b)),
        Operation::And(a, b) => Operation::And(to(a), to(b)),
        Operation::Or(a, b) => Operation::Or(to(a), to(b)),
        Operation::Not(a) => Operation::Not(to(a)),
        Operation::Select(a, b, c) => Operation::Select(to(a), to(b), to(c)),
    }
}

impl Recorded {
    fn number(self) -> usize {
        self.0 as usize
    }

    /// Its value, if it depends on constants alone.
    fn constant(self) -> Option<f64> {
        RECORDING.with_borrow(|recording| match recording.operations[self.number()] {
            Operation::Constant(x) => Some(x),
            _ => None,
        })
    }

    /// The function, with a derivative made from its argument and value.
    fn function(self, function: Function, derivative: impl FnOnce(Self, Self) -> Self) -> Self {
        if let Some(x) = self.constant() {
            return Self::from_f64(function.value(x));
        }
        let value = note(Operation::Function(function, self.number(), usize::MAX));
        let slope = derivative(self, value);
        set(value, Operation::Function(function, self.number(), slope.number()));
        value
    }

    fn function2(
        self,
        other: Self,
        function: Function2,
        constant: impl FnOnce(f64, f64) -> f64,
        derivatives: impl FnOnce(Self) -> [Self; 2],
    ) -> Self {
        if let (Some(x), Some(y)) = (self.constant(), other.constant()) {
            return Self::from_f64(constant(x, y));
        }
        let of = [self.number(), other.number()];
        let value = note(Operation::Function2(function, of, of));
        let slopes = derivatives(value).map(Self::number);
        set(value, Operation::Function2(function, of, slopes));
        value
    }

    fn compare(self, other: Self, operation: fn(usize, usize) -> Operation) -> RecordedMask {
        RecordedMask(note(operation(self.number(), other.number())))
    }
}

fn set(number: Recorded, operation: Operation) {
    RECORDING.with_borrow_mut(|recording| recording.operations[number.number()] = operation);
}

impl Add for Recorded {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        match (self.constant(), other.constant()) {
            (Some(x), Some(y)) => Self::from_f64(x + y),
            (Some(x), None) => note(Operation::Shift(other.number(), x)),
            (None, Some(y)) => note(Operation::Shift(self.number(), y)),
            (None, None) => note(Operation::Add(self.number(), other.number())),
        }
    }
}

impl Sub for Recorded {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        match (self.constant(), other.constant()) {
            (Some(x), Some(y)) => Self::from_f64(x - y),
            (Some(x), None) => note(Operation::Shift((-other).number(), x)),
            (None, Some(y)) => note(Operation::Shift(self.number(), -y)),
            (None, None) => note(Operation::Subtract(self.number(), other.number())),
        }
    }
}

impl Mul for Recorded {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        match (self.constant(), other.constant()) {
            (Some(x), Some(y)) => Self::from_f64(x * y),
            (Some(x), None) => note(Operation::Scale(other.number(), x)),
            (None, Some(y)) => note(Operation::Scale(self.number(), y)),
            (None, None) => note(Operation::Multiply(self.number(), other.number())),
        }
    }
}

impl Div for Recorded {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        match (self.constant(), other.constant()) {
            (Some(x), Some(y)) => Self::from_f64(x / y),
            (None, Some(y)) => note(Operation::Ratio(self.number(), y)),
            _ => note(Operation::Divide(self.number(), other.number())),
        }
    }
}

impl Neg for Recorded {
    type Output = Self;
    fn neg(self) -> Self {
        match self.constant() {
            Some(x) => Self::from_f64(-x),
            None => note(Operation::Negate(self.number())),
        }
    }
}

impl Mask for RecordedMask {
    fn all(self) -> bool {
        RECORDING.with_borrow_mut(|recording| recording.branched = true);
        false
    }
    fn and(self, other: Self) -> Self {
        self.0.compare(other.0, Operation::And)
    }
    fn or(self, other: Self) -> Self {
        self.0.compare(other.0, Operation::Or)
    }
    fn not(self) -> Self {
        Self(note(Operation::Not(self.0.number())))
    }
    fn lanes(self) -> impl Iterator<Item = bool> {
        std::iter::once(self.all())
    }
}

impl Real for Recorded {
    type Mask = RecordedMask;

    fn from_f64(x: f64) -> Self {
        note(Operation::Constant(x))
    }
    fn lanes(self) -> impl Iterator<Item = f64> {
        RECORDING.with_borrow_mut(|recording| recording.branched = true);
        std::iter::once(f64::NAN)
    }
    fn lt(self, other: Self) -> RecordedMask {
        self.compare(other, Operation::Less)
    }
    fn le(self, other: Self) -> RecordedMask {
        self.compare(other, Operation::AtMost)
    }
    fn select(mask: RecordedMask, a: Self, b: Self) -> Self {
        note(Operation::Select(mask.0.number(), a.number(), b.number()))
    }
    fn abs(self) -> Self {
        match self.constant() {
            Some(x) => Self::from_f64(x.abs()),
            None => self.sign() * self,
        }
    }
    fn sign(self) -> Self {
        match self.constant() {
            Some(x) => Self::from_f64(Real::sign(x)),
            None => note(Operation::Sign(self.number())),
        }
    }
    fn sqrt(self) -> Self {
        match self.constant() {
            Some(x) => Self::from_f64(x.sqrt()),
            None => note(Operation::Root(self.number())),
        }
    }
    fn cbrt(self) -> Self {
        self.function(Function::Cbrt, |_, y| Self::from_f64(1.0 / 3.0) / (y * y))
    }
    fn exp(self) -> Self {
        self.function(Function::Exp, |_, y| y)
    }
    fn ln(self) -> Self {
        self.function(Function::Ln, |x, _| Self::from_f64(1.0) / x)
    }
    fn log10(self) -> Self {
        self.function(Function::Log10, |x, _| Self::from_f64(std::f64::consts::LOG10_E) / x)
    }
    fn log2(self) -> Self {
        self.function(Function::Log2, |x, _| Self::from_f64(std::f64::consts::LOG2_E) / x)
    }
    fn sin(self) -> Self {
        self.sin_cos().0
    }
    fn cos(self) -> Self {
        self.sin_cos().1
    }
    fn sin_cos(self) -> (Self, Self) {
        let mut cos = Self(0);
        let sin = self.function(Function::Sin, |x, sin| {
            cos = x.function(Function::Cos, |_, _| -sin);
            cos
        });
        if let Some(x) = self.constant() {
            cos = Self::from_f64(x.cos());
        }
        (sin, cos)
    }
    fn tan(self) -> Self {
        self.function(Function::Tan, |_, y| y * y + Self::from_f64(1.0))
    }
    fn asin(self) -> Self {
        let one = Self::from_f64(1.0);
        self.function(Function::Asin, |x, _| one / (one - x * x).sqrt())
    }
    fn acos(self) -> Self {
        let one = Self::from_f64(1.0);
        self.function(Function::Acos, |x, _| -one / (one - x * x).sqrt())
    }
    fn atan(self) -> Self {
        let one = Self::from_f64(1.0);
        self.function(Function::Atan, |x, _| one / (one + x * x))
    }
    fn sinh(self) -> Self {
        self.function(Function::Sinh, |x, sinh| x.function(Function::Cosh, |_, _| sinh))
    }
    fn cosh(self) -> Self {
        self.function(Function::Cosh, |x, cosh| x.function(Function::Sinh, |_, _| cosh))
    }
    fn tanh(self) -> Self {
        self.function(Function::Tanh, |_, y| Self::from_f64(1.0) - y * y)
    }
    fn asinh(self) -> Self {
        let one = Self::from_f64(1.0);
        self.function(Function::Asinh, |x, _| one / (one + x * x).sqrt())
    }
    fn acosh(self) -> Self {
        let one = Self::from_f64(1.0);
        self.function(Function::Acosh, |x, _| one / (x * x - one).sqrt())
    }
    fn atanh(self) -> Self {
        let one = Self::from_f64(1.0);
        self.function(Function::Atanh, |x, _| one / (one - x * x))
    }
    fn erf(self) -> Self {
        let factor = Self::from_f64(std::f64::consts::FRAC_2_SQRT_PI);
        self.function(Function::Erf, |x, _| factor * (-(x * x)).exp())
    }
    fn powf(self, exponent: Self) -> Self {
        self.function2(exponent, Function2::Power, f64::powf, |y| {
            let by_exponent = if exponent.constant().is_some() { Self::from_f64(0.0) } else { y * self.ln() };
            [exponent * y / self, by_exponent]
        })
    }
    fn atan2(self, x: Self) -> Self {
        self.function2(x, Function2::Angle, f64::atan2, |_| {
            let square = x * x + self * self;
            [x / square, -self / square]
        })
    }
    fn hypot(self, y: Self) -> Self {
        self.function2(y, Function2::Length, f64::hypot, |r| [self / r, y / r])
    }
}
