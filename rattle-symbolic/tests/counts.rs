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
use rattle_symbolic::graph::{Graph, Id, Input, Node};
use rattle_symbolic::schedule::schedule;

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
