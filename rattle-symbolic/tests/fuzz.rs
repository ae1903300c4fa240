//! Random expressions: generated derivatives against hyper-dual numbers, and planted faults.
//!
//! A hyper-dual number a + b ε₁ + c ε₂ + d ε₁ε₂ with ε₁² = ε₂² = 0 carries exact first and second
//! derivatives through an evaluation of the *value*; its rules are written here, independently of
//! the derivative table. Expressions and points are seeded. The bound is relative to the largest
//! number that occurs on the way, 2⁻⁵² times the few hundred operations there are at most, with room.

use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle_symbolic::algebra::Scaled;
use rattle_symbolic::differentiate::{Calculus, Fault, Rule};
use rattle_symbolic::functions::{Binary, Function};
use rattle_symbolic::graph::Graph;
use rattle_symbolic::node::{Comparison, Id, Input};
use rattle_symbolic::operation::Number;
use rattle_symbolic::schedule::schedule;

const VARIABLES: u32 = 3;
const BOUND: f64 = 1e-9;

#[derive(Clone, Copy, Debug)]
struct Hyper {
    a: f64,
    b: f64,
    c: f64,
    d: f64,
}

impl Hyper {
    /// f(x) from f, f′ and f″ at x.
    fn lift(self, [f, f1, f2]: [f64; 3]) -> Hyper {
        Hyper { a: f, b: f1 * self.b, c: f1 * self.c, d: f1 * self.d + f2 * self.b * self.c }
    }
    fn size(self) -> f64 {
        self.a.abs() + self.b.abs() + self.c.abs() + self.d.abs()
    }
    fn map(self, f: impl Fn(f64) -> f64) -> Hyper {
        Hyper { a: f(self.a), b: f(self.b), c: f(self.c), d: f(self.d) }
    }
}

impl Number for Hyper {
    fn from_f64(x: f64) -> Hyper {
        Hyper { a: x, b: 0.0, c: 0.0, d: 0.0 }
    }
    fn neg(self) -> Hyper {
        self.map(|x| -x)
    }
    fn add(self, o: Hyper) -> Hyper {
        Hyper { a: self.a + o.a, b: self.b + o.b, c: self.c + o.c, d: self.d + o.d }
    }
    fn sub(self, o: Hyper) -> Hyper {
        self.add(o.neg())
    }
    fn mul(self, o: Hyper) -> Hyper {
        Hyper {
            a: self.a * o.a,
            b: self.a * o.b + self.b * o.a,
            c: self.a * o.c + self.c * o.a,
            d: self.a * o.d + self.d * o.a + self.b * o.c + self.c * o.b,
        }
    }
    fn div(self, o: Hyper) -> Hyper {
        let r = 1.0 / o.a;
        let mut quotient = self.mul(o.lift([r, -r * r, 2.0 * r * r * r]));
        quotient.a = self.a / o.a;
        quotient
    }
    fn call(self, function: Function) -> Hyper {
        let x = self.a;
        let f = function.evaluate(x);
        let r = 1.0 / x;
        let (s, c) = x.sin_cos();
        let up = 1.0 + x * x;
        let down = 1.0 - x * x;
        let bell = std::f64::consts::FRAC_2_SQRT_PI * (-x * x).exp();
        let guarded = |slope: f64| if x == 0.0 { 0.0 } else { slope };
        let [f1, f2] = match function {
            Function::Sqrt => [guarded(0.5 / f), guarded(-0.25 / (f * f * f))],
            Function::Cbrt => [guarded(1.0 / (3.0 * f * f)), guarded(-2.0 / (9.0 * f * f * f * f * f))],
            Function::Exp => [f, f],
            Function::Ln => [r, -r * r],
            Function::Log10 => [r / 10_f64.ln(), -r * r / 10_f64.ln()],
            Function::Log2 => [r / 2_f64.ln(), -r * r / 2_f64.ln()],
            Function::Sin => [c, -s],
            Function::Cos => [-s, -c],
            Function::Tan => [1.0 / (c * c), 2.0 * s / (c * c * c)],
            Function::Asin => [1.0 / down.sqrt(), x / down.powf(1.5)],
            Function::Acos => [-1.0 / down.sqrt(), -x / down.powf(1.5)],
            Function::Atan => [1.0 / up, -2.0 * x / (up * up)],
            Function::Sinh => [x.cosh(), x.sinh()],
            Function::Cosh => [x.sinh(), x.cosh()],
            Function::Tanh => [1.0 / (x.cosh() * x.cosh()), -2.0 * f / (x.cosh() * x.cosh())],
            Function::Asinh => [1.0 / up.sqrt(), -x / up.powf(1.5)],
            Function::Acosh => [1.0 / (x * x - 1.0).sqrt(), -x / (x * x - 1.0).powf(1.5)],
            Function::Atanh => [1.0 / down, 2.0 * x / (down * down)],
            Function::Abs => [if x < 0.0 { -1.0 } else { 1.0 }, 0.0],
            Function::Sign | Function::Floor => [0.0, 0.0],
            Function::Erf => [bell, -2.0 * x * bell],
        };
        self.lift([f, f1, f2])
    }
    fn call2(self, function: Binary, o: Hyper) -> Hyper {
        let (x, y) = (self.a, o.a);
        let f = function.evaluate(x, y);
        let s = x * x + y * y;
        // f, ∂₁, ∂₂, ∂₁₁, ∂₁₂, ∂₂₂
        let [f1, f2, f11, f12, f22] = match function {
            Binary::Powf => {
                // A power whose exponent moves is for positive bases only: NaN skips the others.
                let l = if x == 0.0 && o.b == 0.0 && o.c == 0.0 { 0.0 } else { x.ln() };
                let l = if o.b == 0.0 && o.c == 0.0 && l.is_nan() { 0.0 } else { l };
                let (p1, p2) = (x.powf(y - 1.0), x.powf(y - 2.0));
                [y * p1, f * l, y * (y - 1.0) * p2, p1 * (1.0 + y * l), f * l * l]
            }
            Binary::Atan2 if s == 0.0 => [0.0; 5],
            Binary::Atan2 => {
                let q = 1.0 / s; // f = atan2(x, y)
                [y * q, -x * q, -2.0 * x * y * q * q, (x * x - y * y) * q * q, 2.0 * x * y * q * q]
            }
            Binary::Hypot if s == 0.0 => [0.0; 5],
            Binary::Hypot => {
                let q = 1.0 / (f * f * f);
                [x / f, y / f, y * y * q, -x * y * q, x * x * q]
            }
        };
        Hyper {
            a: f,
            b: f1 * self.b + f2 * o.b,
            c: f1 * self.c + f2 * o.c,
            d: f1 * self.d
                + f2 * o.d
                + f11 * self.b * self.c
                + f12 * (self.b * o.c + self.c * o.b)
                + f22 * o.b * o.c,
        }
    }
    fn compare(self, comparison: Comparison, o: Hyper) -> bool {
        self.a.compare(comparison, o.a)
    }
}

/// A random expression. Half of the arguments are brought into the domain of their function.
fn expression(random: &mut StdRng) -> (Graph, Id) {
    let mut g = Graph::new();
    let mut pool: Vec<Id> = (0..VARIABLES).map(|i| g.input(Input::Variable(i))).collect();
    pool.extend((0..2).map(|i| g.input(Input::Parameter(i))));
    pool.extend([0.5, 1.0, 2.0, 3.0, -1.0, std::f64::consts::PI].map(|x| g.constant(x)));
    let steps = random.random_range(3..14);
    for _ in 0..steps {
        let any = |random: &mut StdRng| {
            let recent = pool.len().saturating_sub(3);
            let from = if random.random_bool(0.5) { recent } else { 0 };
            pool[random.random_range(from..pool.len())]
        };
        let (a, b) = (any(random), any(random));
        let next = match random.random_range(0..16) {
            0 => g.add(a, b),
            1 => g.sub(a, b),
            2 | 3 => g.mul(a, b),
            4 => g.div(a, b),
            5 => g.neg(a),
            6 => g.power(a, 2 * random.random_range(2..6)),
            7 => g.power(a, random.random_range(-7..8)),
            8 => {
                let (c, d) = (any(random), any(random));
                let comparison =
                    if random.random_bool(0.5) { Comparison::Less } else { Comparison::LessOrEqual };
                g.select(comparison, a, b, c, d)
            }
            9 => g.min(a, b),
            10 => {
                let binary = Binary::ALL[random.random_range(0..Binary::ALL.len())];
                g.call2(binary, a, b)
            }
            _ => {
                let function = Function::ALL[random.random_range(0..Function::ALL.len())];
                let square = g.power(a, 4);
                let (one, two) = (g.constant(1.0), g.constant(2.0));
                let above = g.add(square, one);
                let x = match function {
                    _ if random.random_bool(0.5) => a,
                    Function::Asin | Function::Acos | Function::Atanh => g.div(a, above),
                    Function::Ln | Function::Log2 | Function::Log10 | Function::Sqrt => above,
                    Function::Acosh => g.add(square, two),
                    _ => a,
                };
                g.call(function, x)
            }
        };
        pool.push(next);
    }
    (g, pool[pool.len() - 1])
}

/// Long products of negated factors: signs that are taken out of a product and back into it.
fn signed_product(random: &mut StdRng) -> (Graph, Id) {
    let mut g = Graph::new();
    let mut pool: Vec<Id> = (0..VARIABLES).map(|i| g.input(Input::Variable(i))).collect();
    pool.extend((0..2).map(|i| g.input(Input::Parameter(i))));
    pool.push(g.constant(2.0));
    for _ in 0..random.random_range(3..12) {
        let any = |random: &mut StdRng| pool[random.random_range(0..pool.len())];
        let (a, b) = (any(random), any(random));
        let next = match random.random_range(0..8) {
            0 => g.add(a, b),
            1 => g.power(a, 2 * random.random_range(2..12)),
            2 => g.call(Function::Sin, a),
            3..=5 => g.neg(a),
            _ => {
                let a = g.neg(a);
                g.mul(a, b)
            }
        };
        pool.push(next);
    }
    (g, pool[pool.len() - 1])
}

fn point(random: &mut StdRng) -> [f64; 5] {
    let special = [0.0, -0.0, 1.0, -1.0, 0.5, 2.0];
    let mut q = [0.0; 5].map(|_| random.random_range(-2.0..2.0));
    match random.random_range(0..4) {
        0 => q[random.random_range(0..5)] = special[random.random_range(0..special.len())],
        1 => q[1] = q[0], // ties
        _ => {}
    }
    q
}

fn along(g: &mut Graph, input: Input) -> Scaled {
    match input {
        Input::Variable(k) => g.input(Input::Direction(k)).into(),
        _ => Scaled::ZERO,
    }
}

/// What one random expression shows: how many points could be checked, or where it is wrong.
fn try_one(
    seed: u64,
    expression: fn(&mut StdRng) -> (Graph, Id),
    fault: Option<Fault>,
) -> Result<usize, String> {
    let random = &mut StdRng::seed_from_u64(seed);
    let (source, root) = expression(random);
    let mut graph = source.clone();
    let mut calculus = match fault {
        Some(fault) => Calculus::with_fault(&mut graph, fault),
        None => Calculus::new(&mut graph),
    };
    let gradient = calculus.gradient(&[(Scaled::ONE, root)], VARIABLES);
    let product = calculus.tangents(&gradient, along);
    let speed = calculus.tangents(&[root.into()], along);
    let bend = calculus.tangents(&speed, along);
    let unit = |_: &mut Graph, i| if i == Input::Variable(1) { Scaled::ONE } else { Scaled::ZERO };
    let column = calculus.tangents(&gradient, unit);
    let roots = [vec![root.into()], gradient, product, speed, bend, column].concat();
    let mut target = Graph::new();
    let scheduled = schedule(&graph, &roots, &mut target);
    let mut again = Graph::new();
    assert_eq!(schedule(&graph, &roots, &mut again), scheduled, "the same input gives the same program");
    let all = source.reachable(&[root]);
    let mut checked = 0;
    for _ in 0..6 {
        let q = point(random);
        let v = [0.0; 3].map(|_| random.random_range(-1.0..1.0));
        let input = |input| match input {
            Input::Variable(k) => q[k as usize],
            Input::Parameter(k) => q[3 + k as usize],
            Input::Direction(k) => v[k as usize],
            Input::Weight(_) => f64::NAN,
        };
        let found = target.evaluate(&scheduled, input);
        let value = source.evaluate(&[root], input)[0];
        if value.to_bits() != found[0].to_bits() && !(value.is_nan() && found[0].is_nan()) {
            return Err(format!("value at {q:?}: {} is not {value}", found[0]));
        }
        let mut expected = vec![value];
        let mut size = 0.0_f64;
        let mut hyper = |one: [f64; 3], two: [f64; 3]| {
            let values = source.evaluate(&all, |i| match i {
                Input::Variable(k) => {
                    let k = k as usize;
                    Hyper { a: q[k], b: one[k], c: two[k], d: 0.0 }
                }
                other => Hyper::from_f64(input(other)),
            });
            size = values.iter().fold(size, |size, value| {
                let own = value.size();
                if own.is_finite() { size.max(own) } else { f64::INFINITY }
            });
            values[values.len() - 1] // the root has the highest number
        };
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let by_axis = axes.map(|axis| hyper(axis, v));
        let twice = hyper(v, v);
        let columns = axes.map(|axis| hyper(axis, axes[1]).d);
        expected.extend(by_axis.map(|hyper| hyper.b));
        expected.extend(by_axis.map(|hyper| hyper.d));
        expected.extend([twice.b, twice.d]);
        expected.extend(columns);
        if size > 1e5 {
            continue; // infinite on the way, or too far from order one for the bound
        }
        checked += 1;
        for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
            let error = (found - expected).abs();
            if error.is_nan() || error > BOUND * (1.0 + size) {
                return Err(format!("seed {seed}, result {i} at {q:?}, {v:?}: {found} is not {expected}"));
            }
        }
    }
    Ok(checked)
}

#[test]
fn random_expressions() {
    for expression in [expression, signed_product] {
        let tried = (0..4000).map(|seed| try_one(seed, expression, None));
        let checked: usize = tried.map(|tried| tried.unwrap_or_else(|message| panic!("{message}"))).sum();
        assert!(checked > 8000, "most points can be checked: {checked}");
    }
}

/// Every entry of the derivative table, made wrong by a sign, by two, by a part in a thousand, or missing.
#[test]
fn planted_faults_are_caught() {
    let structural = [
        Rule::Negation,
        Rule::Sum,
        Rule::MinuendOf,
        Rule::SubtrahendOf,
        Rule::Product,
        Rule::Numerator,
        Rule::Denominator,
        Rule::Power,
        Rule::Branch,
    ];
    let flat = [Function::Sign, Function::Floor]; // 0 times anything
    let functions = Function::ALL.iter().filter(|function| !flat.contains(function));
    let binaries = Binary::ALL.iter().flat_map(|&function| [0, 1].map(|by| Rule::Call2(function, by)));
    let calls = functions.map(|&function| Rule::Call(function)).chain(binaries);
    let rules: Vec<Rule> = structural.into_iter().chain(calls).collect();
    for rule in rules {
        for factor in [-1.0, 2.0, 1.001, 0.0] {
            let caught =
                (0..4000).find(|&seed| try_one(seed, expression, Some(Fault { rule, factor })).is_err());
            assert!(caught.is_some(), "nobody noticed {rule:?} times {factor}");
        }
    }
}
