//! How many operations come out: what peers and a careful hand need, as an upper bound.
//!
//! ```text
//!                        here   by hand   SymPy cse   SymForce   CasADi   (a², r² given)
//! g                        11        11          11                    11
//! g, ∇g                    19     19–20          23         21         24
//! g, ∇g, upper Hessian     39        37          47         43         51
//! g, ∇g, Hessian · v       43        41                                54
//! g, ġ, g̈                  41        41                                59
//! ```

use rattle_symbolic::algebra::Scaled;
use rattle_symbolic::differentiate::Calculus;
use rattle_symbolic::graph::Graph;
use rattle_symbolic::node::{Id, Input, Node};
use rattle_symbolic::schedule::schedule;
use rattle_symbolic::{Macro, expand};

fn lemniscate(g: &mut Graph) -> Id {
    let [x, y, z] = [0, 1, 2].map(|i| g.input(Input::Variable(i)));
    let [a, r] = [0, 1].map(|i| g.input(Input::Parameter(i)));
    let [x2, y2, z2, a2, r2] = [x, y, z, a, r].map(|v| g.power(v, 4));
    let s = g.add(x2, y2);
    let s2 = g.power(s, 4);
    let d = g.sub(x2, y2);
    let ad = g.mul(a2, d);
    let f = g.sub(s2, ad);
    let f2 = g.power(f, 4);
    let t = g.add(f2, z2);
    g.sub(t, r2)
}

fn count(g: &Graph, roots: &[Scaled]) -> usize {
    let mut target = Graph::new();
    let roots = schedule(g, roots, &mut target);
    let operation = |id: &Id| target.moving(*id) && !matches!(target.node(*id), Node::Input(_));
    target.reachable(&roots).iter().filter(|id| operation(id)).count()
}

fn along(g: &mut Graph, input: Input) -> Scaled {
    match input {
        Input::Variable(k) => g.input(Input::Direction(k)).into(),
        _ => Scaled::ZERO,
    }
}

#[test]
fn lemniscate_counts() {
    let mut g = Graph::new();
    let root = lemniscate(&mut g);
    let mut calculus = Calculus::new(&mut g);
    let gradient = calculus.gradient(&[(Scaled::ONE, root)], 3);
    let product = calculus.tangents(&gradient, along);
    let mut upper = vec![];
    for j in 0..3 {
        let unit = |_: &mut Graph, i| if i == Input::Variable(j) { Scaled::ONE } else { Scaled::ZERO };
        upper.extend(&calculus.tangents(&gradient, unit)[..=j as usize]);
    }
    let speed = calculus.tangents(&[root.into()], along);
    let bend = calculus.tangents(&speed, along);
    let value = vec![Scaled::from(root)];
    let rows = [
        ("g", 11, vec![]),
        ("g, ∇g", 19, gradient.clone()),
        ("g, ∇g, upper Hessian", 39, [gradient.clone(), upper].concat()),
        ("g, ∇g, Hessian · v", 43, [gradient, product].concat()),
        ("g, ġ, g̈", 41, [speed, bend].concat()),
    ];
    for (name, expected, more) in rows {
        assert_eq!(count(&g, &[value.clone(), more].concat()), expected, "{name}");
    }
}

/// A factor is taken out of a sum where it divides all numbers to the last bit: 0.2/5 would be rounded.
#[test]
fn a_factor_divides_a_sum_exactly() {
    let mut g = Graph::new();
    let [x, y] = [0, 1].map(|i| g.input(Input::Variable(i)));
    for (coefficient, number, factor) in
        [(5.0, 10.0, 5.0), (5.0, 0.2, 1.0), (3.0, 0.75, 3.0), (3.0, 0.1, 1.0)]
    {
        let [x, y] = [x, y].map(|node| Scaled { factor: coefficient, node: Some(node) });
        let sum = g.sum(&[x, y, Scaled::number(number)]);
        assert_eq!(sum.factor, factor, "{coefficient} x + {coefficient} y + {number}");
    }
}

/// Operations per call, from the generated documentation: value, value and Jacobian, Jacobian, Hessian·vector, jet,
/// Hessian, weighted Hessian·vector, and kinks where there are some; then how many numbers the parameters settle.
fn operations(expression: &str) -> String {
    let input = format!("struct A {expression}");
    let output = expand(Macro::Constraint, input.parse().expect("tokens")).to_string();
    assert!(!output.contains("compile_error"), "{expression}");
    let line = output.split_once("Operations per call: ").expect("a line").1;
    let line = line.split_once('.').expect("its end").0;
    let calls = line.split(' ').filter(|word| word.parse::<u32>().is_ok()).collect::<Vec<_>>().join(" ");
    let once = output.split_once("fn kernel_of_lanes").and_then(|(_, rest)| rest.split_once("Kernel {"));
    format!("{calls}; {}", once.expect("a constructor").0.matches(" let ").count())
}

/// Exact counts: a rewrite that shares less, or more, shows here.
#[test]
fn exact_counts() {
    let rows = [
        (
            "twelve sums of adjoints",
            "{} |x, y, z| sum(i in 1..13, (x + i * y) * z + (x + i * y)^2)",
            "70 138 91 83 202 0 85; 0",
        ),
        (
            "two subtracted parameters",
            "{ a, b } |x, y, z| x^4 - a * x^2 - b * x^2 + y^2 * z",
            "9 14 7 12 28 6 14; 8",
        ),
        (
            "reciprocals that cancel",
            "{} |x, y, z| (x^2 + y^2)^3 / (x^2 + y^2) + ln(x * z) * x",
            "10 23 21 58 55 44 61; 0",
        ),
        (
            "ten uses of one",
            "{} |x, y, z| { let u = x + y; sum(i in 1..11, { let w = u + i * z; w^3 + w * y }) }",
            "69 126 87 107 202 98 110; 0",
        ),
        (
            "parameters apart and together",
            "{ a, b } |x, y, z| (x^2 - a - b)^2 * y + (y^2 - b - a * x)^2 * (z - a - b) + a^2 * x * y - b^2 * x",
            "19 33 26 40 63 30 42; 11",
        ),
        (
            "lemniscate",
            "{ a, b } |x, y, z| ((x^2 + y^2)^2 - a^2 * (x^2 - y^2))^2 + z^2 - b^2",
            "11 19 15 35 41 31 37; 6",
        ),
        (
            "torus",
            "{ a, b } |x, y, z| (x^2 + y^2 + z^2 + a^2 - b^2)^2 - 4 * a^2 * (x^2 + y^2)",
            "10 16 13 26 34 22 27; 8",
        ),
        (
            "gyroid",
            "{} |x, y, z| sin(x) * cos(y) + sin(y) * cos(z) + sin(z) * cos(x)",
            "11 21 16 36 51 21 39; 0",
        ),
        (
            "Clebsch",
            "{} |x, y, z| 81 * (x^3 + y^3 + z^3) - 189 * (x^2 * (y + z) + y^2 * (x + z) + z^2 * (x + y)) + 54 * x * y * z + 126 * (x * y + x * z + y * z) - 9 * (x^2 + y^2 + z^2) - 9 * (x + y + z) + 1",
            "38 78 45 76 129 32 83; 0",
        ),
        ("a shared reciprocal", "{} |x, y, z| x / (x + y + z) + y^2 / (x + y + z)", "6 16 16 32 24 30 33; 0"),
        (
            "reciprocals of squares",
            "{ a } |x, y, z| 1 / ((x - a)^2 + y^2 + z^2) + 1 / ((x + a)^2 + y^2 + z^2)",
            "13 26 25 49 45 46 50; 1",
        ),
        (
            "a long sum",
            "{} |x, y, z| sum(i in 1..9, x * y^i) + sum(i in 1..9, z * x^i)",
            "45 104 59 114 182 92 131; 0",
        ),
        (
            "a longer sum",
            "{} |x, y, z| sum(i in 1..90, sin(i * x) * y) + z",
            "355 797 619 1063 894 708 1153; 0",
        ),
        (
            "a long product",
            "{} |x, y, z| product(i in 1..12, (x + i * y)) * z",
            "32 89 88 262 118 310 259; 0",
        ),
        (
            "sign flips",
            "{ a, b } |x, y, z| (a - x) * (b - y) * (x - a) - z * (-x - y) * (y - x)^3",
            "13 28 24 48 48 31 51; 2",
        ),
        (
            "subtracted constants",
            "{ a, b } |x, y, z| (x - a - b)^2 * (y - a - b) + (x * y - a * b - a) * z^2",
            "12 20 17 32 39 15 34; 3",
        ),
        (
            "powers",
            "{} |x, y, z| x^7 * y^5 + sqrt(x^2 + y^2 + z^2)^3 - (x * y)^-3",
            "20 38 30 68 79 55 70; 0",
        ),
        (
            "exponentials",
            "{ a } |x, y, z| exp(-(x^2 + y^2) / (2 * a^2)) * cos(x * z) - y",
            "10 25 24 48 43 43 49; 8",
        ),
        // What is under these roots is never negative, and nobody asks.
        ("a square of a root", "{} |x, y, z| sqrt(x^2 + y^2)^2 * z", "6 9 8 12 25 3 21; 0"),
        (
            "squares of roots",
            "{} |x, y, z| sqrt(max(0, x) + exp(y) * abs(x) + hypot(x, y))^2 + sqrt(sqrt(z) / cosh(z))^4",
            "16 34 25 52 74 53 55 0; 0",
        ),
        (
            "branches",
            "{} |x, y, z| if x < y { x^2 * z } else { y^3 } + max(x, z) * abs(y)",
            "9 24 19 22 34 11 25 2; 0",
        ),
    ];
    let mut wrong = Vec::new();
    for (name, expression, expected) in rows {
        let found = operations(expression);
        if found != expected {
            wrong.push(format!("{name}: {found}"));
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}
