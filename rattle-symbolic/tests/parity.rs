//! Random functions of a distance r: value and slope in s = r², against the function itself over dual numbers in r.

use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle_symbolic::functions::{Binary, Function};
use rattle_symbolic::graph::Graph;
use rattle_symbolic::node::{Comparison, Id, Input, Node};
use rattle_symbolic::operation::Number;
use rattle_symbolic::routine::pair;

/// a + b ε with ε² = 0, and the largest number that an operation met.
#[derive(Clone, Copy, Debug)]
struct Dual {
    a: f64,
    b: f64,
    size: f64,
}

impl Dual {
    fn new(a: f64, b: f64, before: f64) -> Dual {
        let own = a.abs() + b.abs();
        Dual { a, b, size: if own.is_finite() { own.max(before) } else { f64::INFINITY } }
    }
}

impl Number for Dual {
    fn from_f64(x: f64) -> Dual {
        Dual::new(x, 0.0, 0.0)
    }
    fn neg(self) -> Dual {
        Dual::new(-self.a, -self.b, self.size)
    }
    fn add(self, o: Dual) -> Dual {
        Dual::new(self.a + o.a, self.b + o.b, self.size.max(o.size))
    }
    fn sub(self, o: Dual) -> Dual {
        self.add(o.neg())
    }
    fn mul(self, o: Dual) -> Dual {
        Dual::new(self.a * o.a, self.a * o.b + self.b * o.a, self.size.max(o.size))
    }
    fn div(self, o: Dual) -> Dual {
        let quotient = self.a / o.a;
        let reciprocal = Dual::new(1.0 / o.a, 0.0, 0.0).size;
        Dual::new(quotient, (self.b - quotient * o.b) / o.a, self.size.max(o.size).max(reciprocal))
    }
    fn call(self, function: Function) -> Dual {
        let (x, f) = (self.a, function.evaluate(self.a));
        let slope = match function {
            Function::Sqrt => 0.5 / f,
            Function::Exp => f,
            Function::Cos => -x.sin(),
            Function::Sin => x.cos(),
            Function::Abs => x.signum(),
            other => panic!("{other:?} is not among these"),
        };
        Dual::new(f, slope * self.b, self.size)
    }
    fn call2(self, function: Binary, o: Dual) -> Dual {
        assert_eq!(function, Binary::Hypot);
        let f = self.a.hypot(o.a);
        Dual::new(f, (self.a * self.b + o.a * o.b) / f, self.size.max(o.size))
    }
    fn compare(self, comparison: Comparison, o: Dual) -> bool {
        self.a.compare(comparison, o.a)
    }
}

/// A random function of r and a parameter, and whether it is even, odd or neither by its making.
fn function(random: &mut StdRng) -> (Graph, Id) {
    let mut g = Graph::new();
    let r = g.input(Input::Variable(0));
    let k = g.input(Input::Parameter(0));
    let mut pool = vec![r, k, r, g.constant(1.5), r];
    for _ in 0..random.random_range(2..12) {
        let mut any = || pool[random.random_range(0..pool.len())];
        let (a, b, c) = (any(), any(), any());
        let next = match random.random_range(0..14) {
            0 => g.neg(a),
            1 | 2 => g.add(a, b),
            3 => g.sub(a, b),
            4..=6 => g.mul(a, b),
            7 | 8 => g.div(a, b),
            9 => g.power(a, 2 * random.random_range(-5..6)),
            10 => g.power(a, [-3, -1, 3, 5][random.random_range(0..4)]),
            11 => {
                let all = [Function::Exp, Function::Cos, Function::Sin, Function::Abs, Function::Sqrt];
                g.call(all[random.random_range(0..all.len())], a)
            }
            12 => g.call2(Binary::Hypot, a, b),
            _ => g.select(Comparison::Less, a, b, c, a),
        };
        pool.push(next);
    }
    (g, pool[pool.len() - 1])
}

#[test]
fn random_functions() {
    let (mut checked, mut rootless, mut rooted) = (0, 0, 0);
    for seed in 0..6000 {
        let random = &mut StdRng::seed_from_u64(seed);
        let (g, root) = function(random);
        if !g.moving(root) {
            continue;
        }
        let all = g.reachable(&[root]);
        let routines = pair(g.clone(), root).expect("small");
        let [value, slope] = ["value", "slope"].map(|name| routines.named(name).expect("written").roots[0]);
        let target = &routines.graph;
        let has_root = target
            .reachable(&[value])
            .iter()
            .any(|&id| matches!(target.node(id), Node::Call(Function::Sqrt, _)));
        for r in [0.25_f64, 0.7, 1.0, 1.9] {
            let k = random.random_range(0.5..2.0);
            let over = g.evaluate(&all, |input| match input {
                Input::Variable(_) => Dual::new(r, 1.0, 1.0),
                _ => Dual::new(k, 0.0, 1.0),
            });
            let expected = over[over.len() - 1];
            let size = over.iter().fold(1.0, |size: f64, own| size.max(own.size));
            let edge = all.iter().any(|&id| match *g.node(id) {
                // At its edge, what a branch chooses depends on the rounding of s.
                Node::Select(_, a, b, ..) => {
                    let of = |id| over[all.iter().position(|&own| own == id).expect("reachable")].a;
                    (of(a) - of(b)).abs() <= 1e-9 * size
                }
                Node::Call(Function::Abs, a) => {
                    over[all.iter().position(|&own| own == a).expect("reachable")].a.abs() <= 1e-9 * size
                }
                _ => false,
            });
            if size > 1e4 || edge {
                continue;
            }
            let at = |root| {
                target.evaluate(&[root], |input| match input {
                    Input::Variable(_) => r * r,
                    _ => k,
                })[0]
            };
            // 1e-16 times a few dozen operations, and the numbers on the way squared: roots, quotients.
            let bound = 1e-13 * size * size;
            assert!(
                (at(value) - expected.a).abs() <= bound,
                "seed {seed}: U({r}) is {}, not {}",
                expected.a,
                at(value)
            );
            let (found, exact) = (2.0 * at(slope) * r, expected.b);
            assert!((found - exact).abs() <= bound, "seed {seed}: U'({r}) is {exact}, not {found}");
            checked += 1;
            rootless += usize::from(!has_root);
            rooted += usize::from(has_root);
        }
    }
    assert!(
        checked > 10_000 && rootless > 2000 && rooted > 2000,
        "{checked}: {rootless} without a root, {rooted} with"
    );
}

/// In units of metres neither (σ/r²)³⁶ nor r³⁶ is a number.
#[test]
fn powers_of_a_quotient_stay_in_range() {
    let (sigma, apart) = (3.4e-10_f64, 4e-10_f64);
    for whole in [6, 9, 12, 36, 40, -36] {
        let mut g = Graph::new();
        let (r, k) = (g.input(Input::Variable(0)), g.input(Input::Parameter(0)));
        let ratio = g.div(k, r);
        let root = g.power(ratio, 2 * whole);
        let routines = pair(g, root).expect("small");
        let [value, slope] = ["value", "slope"].map(|name| {
            let root = routines.named(name).expect("written").roots[0];
            routines.graph.evaluate(&[root], |input| match input {
                Input::Variable(_) => apart * apart,
                _ => sigma,
            })[0]
        });
        let expected = (sigma / apart).powi(whole);
        assert!((value / expected - 1.0).abs() < 1e-14, "{whole}: {value:e} {expected:e}");
        let expected = -0.5 * f64::from(whole) * expected / (apart * apart); // by r²
        assert!((slope / expected - 1.0).abs() < 1e-14, "{whole}: {slope:e} {expected:e}");
    }
}
