//! Random programs of the language: the generated text, interpreted, against the program evaluated as a tree.
//!
//! The tree is written out for the macro and evaluated here by itself, over dual numbers, with Rust's own loops and
//! conditions. The tokens that come out are read back by `syn` and evaluated by a small interpreter. Values agree
//! bit for bit; slopes within 1e-9 of the largest number on the way, 2⁻⁵² times the few thousand operations
//! there are at most, with room.

use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle_symbolic::functions::Function;
use rattle_symbolic::{Macro, expand};
use std::cell::Cell;
use std::collections::HashMap;

#[path = "programs/interpreter.rs"]
mod interpreter;
use interpreter::Generated;

/// a + b ε with ε² = 0.
#[derive(Clone, Copy, Debug)]
struct Dual(f64, f64);

/// An index: a number, or a name with an offset.
#[derive(Clone, Debug)]
enum Place {
    Fixed(i64),
    Named(usize, i64),
}

#[derive(Clone, Debug)]
enum Tree {
    Number(f64),
    /// `a`, of the parameters `a, n: [f64; 2]`.
    Parameter,
    Normal(Place),
    /// `y`, of the variables `x: [f64; 3], y`.
    Last,
    Component(Place),
    Let(usize),
    Negative(Box<Tree>),
    Two(char, Box<Tree>, Box<Tree>),
    /// base^(halves/2)
    Power(Box<Tree>, i32),
    One(Function, Box<Tree>),
    Call(&'static str, Box<Tree>, Box<Tree>),
    If(Box<Condition>, Box<Tree>, Box<Tree>),
    Sum(usize, i64, Box<Tree>),
    Block(Vec<(usize, Tree)>, Box<Tree>),
}

#[derive(Clone, Debug)]
enum Condition {
    Indices(Place, &'static str, i64),
    Numbers(Tree, &'static str, Tree),
    All(Vec<Condition>),
    Any(Vec<Condition>),
}

fn place(place: &Place) -> String {
    match place {
        Place::Fixed(i) => i.to_string(),
        Place::Named(k, 0) => format!("_i{k}"),
        Place::Named(k, offset) => format!("_i{k} + {offset}").replace("+ -", "- "),
    }
}

fn written(tree: &Tree) -> String {
    match tree {
        Tree::Number(x) => format!("{x}"),
        Tree::Parameter => "a".to_owned(),
        Tree::Normal(i) => format!("n[{}]", place(i)),
        Tree::Last => "y".to_owned(),
        Tree::Component(i) => format!("x[{}]", place(i)),
        Tree::Let(k) => format!("_f{k}"),
        Tree::Negative(a) => format!("(-{})", written(a)),
        Tree::Two(operator, a, b) => format!("({} {operator} {})", written(a), written(b)),
        Tree::Power(a, halves) => format!("({})^({halves}/2)", written(a)),
        Tree::One(function, a) => format!("{}({})", function.name(), written(a)),
        Tree::Call(name, a, b) => format!("{name}({}, {})", written(a), written(b)),
        Tree::If(c, a, b) => format!("(if {} {{ {} }} else {{ {} }})", condition(c), written(a), written(b)),
        Tree::Sum(k, to, body) => format!("sum(_i{k} in 0..{to}, {})", written(body)),
        Tree::Block(lets, result) => {
            let lets: String =
                lets.iter().map(|(k, value)| format!("let _f{k} = {}; ", written(value))).collect();
            format!("{{ {lets}{} }}", written(result))
        }
    }
}

fn condition(all: &Condition) -> String {
    let list = |parts: &[Condition], symbol| {
        parts.iter().map(|part| format!("({})", condition(part))).collect::<Vec<_>>().join(symbol)
    };
    match all {
        Condition::Indices(i, symbol, to) => format!("{} {symbol} {to}", place(i)),
        Condition::Numbers(a, symbol, b) => format!("{} {symbol} {}", written(a), written(b)),
        Condition::All(parts) => list(parts, " && "),
        Condition::Any(parts) => list(parts, " || "),
    }
}

/// The numbers at hand, and the largest on the way.
struct Given {
    a: f64,
    n: [f64; 2],
    x: [Dual; 3],
    y: Dual,
    lets: HashMap<usize, Dual>,
    indices: HashMap<usize, i64>,
    size: Cell<f64>,
}

impl Given {
    fn place(&self, place: &Place) -> i64 {
        match place {
            Place::Fixed(i) => *i,
            Place::Named(k, offset) => self.indices[k] + offset,
        }
    }

    fn value(&mut self, tree: &Tree) -> Dual {
        let result = self.of(tree);
        let size = result.0.abs() + result.1.abs();
        self.size.set(if size.is_finite() { self.size.get().max(size) } else { f64::INFINITY });
        result
    }

    fn of(&mut self, tree: &Tree) -> Dual {
        match tree {
            Tree::Number(x) => Dual(*x, 0.0),
            Tree::Parameter => Dual(self.a, 0.0),
            Tree::Normal(i) => Dual(self.n[self.place(i) as usize], 0.0),
            Tree::Last => self.y,
            Tree::Component(i) => self.x[self.place(i) as usize],
            Tree::Let(k) => self.lets[k],
            Tree::Negative(a) => {
                let a = self.value(a);
                Dual(-a.0, -a.1)
            }
            Tree::Two(operator, a, b) => {
                let (a, b) = (self.value(a), self.value(b));
                match operator {
                    '+' => Dual(a.0 + b.0, a.1 + b.1),
                    '-' => Dual(a.0 - b.0, a.1 - b.1),
                    '*' => Dual(a.0 * b.0, a.0 * b.1 + a.1 * b.0),
                    _ => Dual(a.0 / b.0, (a.1 - a.0 / b.0 * b.1) / b.0),
                }
            }
            Tree::Power(a, halves) => {
                let a = self.value(a);
                let slope = f64::from(*halves) / 2.0 * a.0.powf(f64::from(*halves) / 2.0 - 1.0) * a.1;
                Dual(power(a.0, *halves), if *halves == 0 { 0.0 } else { slope })
            }
            Tree::One(function, a) => {
                let Dual(x, d) = self.value(a);
                let slope = match function {
                    Function::Sin => x.cos(),
                    Function::Cos => -x.sin(),
                    Function::Exp => x.exp(),
                    Function::Tanh => 1.0 / (x.cosh() * x.cosh()),
                    Function::Atan => 1.0 / (1.0 + x * x),
                    Function::Abs => {
                        if x < 0.0 {
                            -1.0
                        } else {
                            1.0
                        }
                    }
                    other => panic!("{other:?} is not among the functions of these programs"),
                };
                Dual(function.evaluate(x), slope * d)
            }
            Tree::Call(name, a, b) => {
                let (a, b) = (self.value(a), self.value(b));
                match *name {
                    "min" => {
                        if b.0 < a.0 {
                            b
                        } else {
                            a
                        }
                    }
                    "max" => {
                        if a.0 < b.0 {
                            b
                        } else {
                            a
                        }
                    }
                    "norm" => {
                        let root = (a.0 * a.0 + b.0 * b.0).sqrt();
                        Dual(root, if root > 0.0 { (a.0 * a.1 + b.0 * b.1) / root } else { 0.0 })
                    }
                    _ => {
                        let squares = a.0 * a.0 + b.0 * b.0;
                        let slope = (b.0 * a.1 - a.0 * b.1) / squares;
                        Dual(a.0.atan2(b.0), if squares > 0.0 { slope } else { 0.0 })
                    }
                }
            }
            Tree::If(c, a, b) => {
                if self.holds(c) {
                    self.value(a)
                } else {
                    self.value(b)
                }
            }
            Tree::Sum(k, to, body) => {
                let mut total: Option<Dual> = None;
                for i in 0..*to {
                    self.indices.insert(*k, i);
                    let Dual(x, d) = self.value(body);
                    total = Some(total.map_or(Dual(x, d), |sum| Dual(sum.0 + x, sum.1 + d)));
                }
                total.unwrap_or(Dual(0.0, 0.0))
            }
            Tree::Block(lets, result) => {
                for (k, tree) in lets {
                    let value = self.value(tree);
                    self.lets.insert(*k, value);
                }
                self.value(result)
            }
        }
    }

    fn holds(&mut self, all: &Condition) -> bool {
        match all {
            Condition::Indices(i, symbol, to) => {
                let i = self.place(i);
                match *symbol {
                    "<" => i < *to,
                    "<=" => i <= *to,
                    ">" => i > *to,
                    ">=" => i >= *to,
                    _ => i == *to,
                }
            }
            Condition::Numbers(a, symbol, b) => {
                let (a, b) = (self.value(a).0, self.value(b).0);
                match *symbol {
                    "<" => a < b,
                    "<=" => a <= b,
                    ">" => a > b,
                    _ => a >= b,
                }
            }
            Condition::All(parts) => parts.iter().all(|part| self.holds(part)),
            Condition::Any(parts) => parts.iter().any(|part| self.holds(part)),
        }
    }
}

/// x^(halves/2) as the language defines it.
fn power(x: f64, halves: i32) -> f64 {
    fn whole(x: f64, n: i32) -> f64 {
        match n {
            1 => x,
            n if n % 2 == 1 => whole(x, n - 1) * x,
            n => whole(x, n / 2) * whole(x, n / 2),
        }
    }
    match halves {
        0 => 1.0,
        1 => x.sqrt(),
        n if n < 0 => 1.0 / power(x, -n),
        n if n % 2 == 1 => whole(x, n / 2) * x.sqrt(),
        n => whole(x, n / 2),
    }
}

/// Makes trees; names of `let`s and indices are given once.
struct Maker<'a> {
    random: &'a mut StdRng,
    lets: Vec<usize>,
    /// Each with the number of values it has.
    indices: Vec<(usize, i64)>,
    names: usize,
}

impl Maker<'_> {
    fn pick<T: Clone>(&mut self, list: &[T]) -> T {
        list[self.random.random_range(0..list.len())].clone()
    }
    fn place(&mut self, length: i64) -> Place {
        let fitting: Vec<Place> = self
            .indices
            .iter()
            .filter(|index| index.1 <= length)
            .map(|index| Place::Named(index.0, 0))
            .collect();
        match fitting.is_empty() || self.random.random_bool(0.3) {
            true => Place::Fixed(self.random.random_range(0..length)),
            false => self.pick(&fitting),
        }
    }
    fn name(&mut self) -> usize {
        self.names += 1;
        self.names
    }
    fn leaf(&mut self) -> Tree {
        match self.random.random_range(0..8) {
            0 => Tree::Number(self.random.random_range(1..8) as f64 / 2.0),
            1 => Tree::Parameter,
            2 => Tree::Normal(self.place(2)),
            3 => Tree::Last,
            4 if !self.lets.is_empty() => {
                let lets = self.lets.clone();
                Tree::Let(self.pick(&lets))
            }
            _ => Tree::Component(self.place(3)),
        }
    }
    fn tree(&mut self, depth: u32) -> Tree {
        if depth == 0 {
            return self.leaf();
        }
        let next = |maker: &mut Self| Box::new(maker.tree(depth - 1));
        match self.random.random_range(0..16) {
            0 => Tree::Negative(next(self)),
            1..=6 => Tree::Two(self.pick(&['+', '-', '*', '*', '/']), next(self), next(self)),
            7 => Tree::Power(next(self), self.random.random_range(-5..9)),
            8 => {
                let all = [
                    Function::Sin,
                    Function::Cos,
                    Function::Exp,
                    Function::Tanh,
                    Function::Atan,
                    Function::Abs,
                ];
                Tree::One(self.pick(&all), next(self))
            }
            9 => Tree::Call(self.pick(&["min", "max", "norm", "atan2"]), next(self), next(self)),
            10 | 11 => Tree::If(Box::new(self.condition(depth)), next(self), next(self)),
            12 | 13 => {
                let (k, to) = (self.name(), self.random.random_range(1..4));
                self.indices.push((k, to));
                let body = next(self);
                self.indices.pop();
                Tree::Sum(k, to, body)
            }
            14 => {
                let before = self.lets.len();
                let mut lets = Vec::new();
                for _ in 0..self.random.random_range(1..3) {
                    let (value, k) = (self.tree(depth - 1), self.name());
                    self.lets.push(k);
                    lets.push((k, value));
                }
                let result = next(self);
                self.lets.truncate(before);
                Tree::Block(lets, result)
            }
            _ => self.leaf(),
        }
    }
    fn condition(&mut self, depth: u32) -> Condition {
        let symbol = self.pick(&["<", "<=", ">", ">="]);
        let indices = self.indices.clone();
        match self.random.random_range(0..6) {
            0 if depth > 1 => Condition::All(vec![self.condition(depth - 1), self.condition(depth - 1)]),
            1 if depth > 1 => {
                Condition::Any(vec![self.condition(depth - 1), self.condition(depth - 1), self.condition(1)])
            }
            2 if !indices.is_empty() => {
                let symbol = self.pick(&["<", "<=", ">", ">=", "=="]);
                Condition::Indices(
                    Place::Named(self.pick(&indices).0, 0),
                    symbol,
                    self.random.random_range(0..3),
                )
            }
            // Neither looks at the component before the first.
            3 if !indices.is_empty() => {
                let k = self.pick(&indices).0;
                let before = Condition::Numbers(Tree::Component(Place::Named(k, -1)), symbol, self.leaf());
                match self.random.random_bool(0.5) {
                    true => Condition::All(vec![Condition::Indices(Place::Named(k, 0), ">", 0), before]),
                    false => Condition::Any(vec![Condition::Indices(Place::Named(k, 0), "==", 0), before]),
                }
            }
            _ => Condition::Numbers(self.leaf(), symbol, self.tree(depth - 1)),
        }
    }
}

/// The equation for each i of a family of three, and a last one in which all names occur.
fn item(body: &Tree) -> String {
    format!(
        "struct A {{ a, n: [f64; 2] }} |x: [f64; 3], y| [for _i0 in 0..3 {{ ({}) * y + x[0] }}, x[0] + x[1] + x[2] + a * n[0] - n[1]]",
        written(body)
    )
}

/// How many points could be checked; none where the macro finds that a number is not real.
fn try_one(body: &Tree, random: &mut StdRng) -> usize {
    let mut number = || random.random_range(-2.0..2.0_f64);
    let (a, n) = (number(), [number(), number()]);
    let input = item(body);
    let generated = match Generated::new(&input, a, n) {
        Ok(generated) => generated,
        Err(message) => {
            let known = ["division by zero", "is not a real", "is infinite", "is not real"];
            assert!(known.iter().any(|known| message.contains(known)), "{input}\n{message}");
            return 0;
        }
    };
    let mut checked = 0;
    for _ in 0..2 {
        let (q, v) = ([0; 4].map(|_| number()), [0; 4].map(|_| number()));
        let [q0, q1, q2, q3] = [0, 1, 2, 3].map(|k| Dual(q[k], v[k]));
        let mut given = Given {
            a,
            n,
            x: [q0, q1, q2],
            y: q3,
            lets: HashMap::new(),
            indices: HashMap::new(),
            size: Cell::new(1.0),
        };
        let expected = [0, 1, 2].map(|i| {
            given.indices.insert(0, i);
            let body = given.value(body);
            Dual(body.0 * q[3] + q[0], body.0 * v[3] + body.1 * q[3] + v[0])
        });
        let value = generated.call("value", &[("q", &q)]);
        let jet = generated.call("jet", &[("q", &q), ("v", &v)]);
        let both = generated.call("value_and_jacobian", &[("q", &q)]);
        let products = generated.call("hessian_vector", &[("q", &q), ("v", &v)]);
        let size = given.size.get();
        for (i, Dual(x, slope)) in expected.into_iter().enumerate() {
            for found in [value[i], jet[i], both[i]] {
                let same = found.to_bits() == x.to_bits() || (found.is_nan() && x.is_nan());
                assert!(same, "{input}\nequation {i} at {q:?}: {found} is not {x}");
            }
            if size > 1e4 {
                continue; // infinite or too far from order one for the bound
            }
            let along = |row: &[f64]| row.iter().zip(&v).map(|(entry, v)| entry * v).sum::<f64>();
            let found = [jet[4 + i], along(&both[4 + 4 * i..8 + 4 * i])];
            for found in found {
                assert!(
                    (found - slope).abs() <= 1e-9 * (1.0 + size * size),
                    "{input}\nslope {i} at {q:?}, {v:?}: {found} is not {slope}"
                );
            }
            let (bend, product) = (jet[8 + i], along(&products[4 * i..4 * i + 4]));
            let close = (bend - product).abs() <= 1e-6 * (1.0 + bend.abs() + size.powi(3));
            assert!(close || !bend.is_finite(), "{input}\nbend {i} at {q:?}, {v:?}: {bend} is not {product}");
            checked += 1;
        }
    }
    checked
}

#[test]
fn random_programs() {
    let mut checked = 0;
    for seed in 0..500 {
        let random = &mut StdRng::seed_from_u64(seed);
        let depth = random.random_range(2..4);
        let mut maker = Maker { random, lets: vec![], indices: vec![(0, 3)], names: 0 };
        let body = maker.tree(depth);
        checked += try_one(&body, random);
    }
    assert!(checked > 1500, "most programs can be checked: {checked}");
}

/// So long that blocks, and so long that chapters are made of it.
#[test]
fn long_programs() {
    for lets in [20, 120] {
        let random = &mut StdRng::seed_from_u64(lets);
        let maker = Maker { random, lets: vec![], indices: vec![(0, 3)], names: 0 };
        let two = |operator, a: Tree, b: Tree| Tree::Two(operator, Box::new(a), Box::new(b));
        let mut list: Vec<(usize, Tree)> = vec![(1, Tree::Last), (2, Tree::Component(Place::Named(0, 0)))];
        for k in 3..lets as usize {
            let (p, q) = (Tree::Let(k - 1), Tree::Let(maker.random.random_range(k / 2..k)));
            let next = match k % 4 {
                0 => two('*', p, two('+', q, Tree::Parameter)),
                1 => Tree::One(Function::Sin, Box::new(two('-', p, q))),
                2 => two('/', p, two('+', Tree::Number(2.0), Tree::Power(Box::new(q), 4))),
                _ => Tree::One(Function::Cos, Box::new(two('+', two('*', p, q), Tree::Last))),
            };
            list.push((k, next));
        }
        let last = Tree::Let(lets as usize - 1);
        let body = Tree::Block(list, Box::new(last));
        let text = expand(Macro::Constraint, item(&body).parse().expect("tokens")).to_string();
        assert_eq!(text.contains("fn chapter"), lets == 120, "{lets}");
        assert_eq!(try_one(&body, random), 6);
    }
}
