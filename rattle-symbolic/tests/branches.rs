//! Random expressions with branches: derivatives of the whole, against those of the arms that are taken at a point.
//!
//! Functions are often held at the end of the domain of another there, where its slope is infinite.

use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle_symbolic::algebra::Scaled;
use rattle_symbolic::differentiate::Calculus;
use rattle_symbolic::functions::{Binary, Function};
use rattle_symbolic::graph::Graph;
use rattle_symbolic::node::{Comparison, Id, Input, Node};
use rattle_symbolic::schedule::schedule;

const BOUND: f64 = 1e-9;

/// An expression of two variables and two parameters.
fn expression(random: &mut StdRng, g: &mut Graph, depth: u32) -> Id {
    if depth == 0 {
        return match random.random_range(0..9) {
            0..=2 => g.input(Input::Variable(0)),
            3..=5 => g.input(Input::Variable(1)),
            6 => g.input(Input::Parameter(0)),
            number => g.constant([1.0, 2.0][number - 7]),
        };
    }
    let a = expression(random, g, depth - 1);
    let kind = random.random_range(0..100);
    let b = match kind {
        0..36 if random.random_bool(0.75) => g.constant(f64::from(random.random_range(-1..2))),
        _ => expression(random, g, depth - 1),
    };
    match kind {
        0..20 => g.max(a, b),
        20..36 => g.min(a, b),
        36..46 => {
            let (c, d) = (expression(random, g, depth - 1), expression(random, g, depth - 1));
            let comparison = [Comparison::Less, Comparison::LessOrEqual][random.random_range(0..2)];
            g.select(comparison, a, b, c, d)
        }
        46..53 => g.add(a, b), // a difference might vanish in the arms alone, where its parts cancel
        53..57 => g.div(a, b),
        57..63 => g.mul(a, b),
        63..69 => g.power(a, [-2, 1, 3, 4, 6][random.random_range(0..5)]),
        69..75 => {
            let exponents =
                [g.constant(1.4), g.constant(1.25), g.constant(0.7), g.input(Input::Parameter(1))];
            g.call2(Binary::Powf, a, exponents[random.random_range(0..4)])
        }
        75..80 => g.call2(Binary::Hypot, a, b),
        80..82 => g.call2(Binary::Atan2, a, b),
        _ => {
            use Function::{Abs, Acos, Acosh, Asin, Atanh, Cbrt, Exp, Ln, Sin, Sqrt};
            let all = [Acos, Asin, Acos, Asin, Sqrt, Ln, Acosh, Abs, Exp, Cbrt, Atanh, Sin];
            g.call(all[random.random_range(0..all.len())], a)
        }
    }
}

/// The expression with the arms that are taken alone.
fn resolved(g: &Graph, root: Id, input: impl Fn(Input) -> f64) -> (Graph, Id) {
    let all = g.reachable(&[root]);
    let values = g.evaluate(&all, input);
    let place = |id: Id| all.binary_search(&id).expect("reachable");
    let (mut target, mut copies): (Graph, Vec<Id>) = (Graph::new(), Vec::new());
    for &id in &all {
        let at = |id: Id| copies[place(id)];
        let copy = match *g.node(id) {
            Node::Constant(bits) => target.constant(f64::from_bits(bits)),
            Node::Input(input) => target.input(input),
            Node::Neg(a) => target.neg(at(a)),
            Node::Add(a, b) => target.add(at(a), at(b)),
            Node::Sub(a, b) => target.sub(at(a), at(b)),
            Node::Mul(a, b) => target.mul(at(a), at(b)),
            Node::Div(a, b) => target.div(at(a), at(b)),
            Node::Power(a, halves) => target.power(at(a), halves),
            Node::Call(function, a) => target.call(function, at(a)),
            Node::Call2(function, a, b) => target.call2(function, at(a), at(b)),
            Node::Select(comparison, a, b, then, other) => {
                let [a, b] = [a, b].map(|id| values[place(id)]);
                let holds = if comparison == Comparison::Less { a < b } else { a <= b };
                at(if holds { then } else { other })
            }
            Node::Sum(_) | Node::Product(_) => unreachable!("only in derivatives"),
        };
        copies.push(copy);
    }
    (target, copies[copies.len() - 1])
}

/// The value, the gradient, Hessian · v, v · gradient and v · Hessian · v.
fn derivatives(mut g: Graph, root: Id, input: impl Fn(Input) -> f64) -> Vec<f64> {
    let along = |g: &mut Graph, input| match input {
        Input::Variable(k) => g.input(Input::Direction(k)).into(),
        _ => Scaled::ZERO,
    };
    let mut calculus = Calculus::new(&mut g);
    let gradient = calculus.gradient(&[(Scaled::ONE, root)], 2);
    let product = calculus.tangents(&gradient, along);
    let speed = calculus.tangents(&[root.into()], along);
    let bend = calculus.tangents(&speed, along);
    let roots = [vec![root.into()], gradient, product, speed, bend].concat();
    let mut target = Graph::new();
    let roots = schedule(&g, &roots, &mut target);
    target.evaluate(&roots, input)
}

#[test]
fn arms_that_are_not_taken_change_nothing() {
    let (mut compared, mut wrong) = (0, Vec::new());
    for seed in 0..6000 {
        let random = &mut StdRng::seed_from_u64(seed);
        let mut g = Graph::new();
        let depth = random.random_range(2..5);
        let root = expression(random, &mut g, depth);
        if !g.moving(root) || g.len() > 40 {
            continue;
        }
        for q in [[-1.0, -0.75], [2.0, 1.5], [-0.3, 1.7], [0.4, -2.0]] {
            let p = [[1.0, 2.0, 0.6][random.random_range(0..3)], [1.4, 2.3, 0.7][random.random_range(0..3)]];
            let input = |input| match input {
                Input::Variable(k) => q[k as usize],
                Input::Parameter(k) => p[k as usize],
                Input::Direction(k) => [0.7, -0.4][k as usize],
                Input::Weight(_) => f64::NAN,
            };
            let (taken, of) = resolved(&g, root, input);
            let parts = taken.evaluate(&taken.reachable(&[of]), input);
            let expected = if taken.moving(of) { derivatives(taken, of, input) } else { vec![parts[0]] };
            if !parts.iter().chain(&expected).all(|number| number.is_finite()) {
                continue;
            }
            compared += 1;
            let found = derivatives(g.clone(), root, input);
            let size = expected.iter().fold(1.0, |size: f64, number| size.max(number.abs()));
            let close = |i: usize| (found[i] - expected.get(i).unwrap_or(&0.0)).abs() <= BOUND * size;
            if !(1..found.len()).all(close) {
                wrong.push(format!("seed {seed} at {q:?}, {p:?}: {found:?}, {expected:?}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {compared}\n{}", wrong.len(), wrong[..wrong.len().min(40)].join("\n"));
    assert!(compared > 10_000, "{compared}");
}
