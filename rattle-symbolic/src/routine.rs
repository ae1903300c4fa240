//! What is computed: for each macro its functions, scheduled into one graph.
//!
//! All functions of a kernel share one target graph, so that what depends on parameters alone is
//! found once for all of them. The Jacobian alone is the part of value-and-Jacobian that it needs,
//! operation by operation, so the two agree bit for bit.

use crate::algebra::Scaled;
use crate::differentiate::Calculus;
use crate::graph::{Graph, Id, Input, Node};
use crate::parity::of_square;
use crate::schedule::schedule;

/// A function to generate: its results, in the order in which it returns them.
#[derive(Clone, Debug)]
pub struct Routine {
    /// The method of the kernel.
    pub name: &'static str,
    /// The results, in [`Routines::graph`].
    pub roots: Vec<Id>,
}

/// The functions of a kernel.
#[derive(Clone, Debug)]
pub struct Routines {
    /// Binary operations only.
    pub graph: Graph,
    /// The functions.
    pub list: Vec<Routine>,
}

impl Routines {
    /// No function at all.
    pub(crate) fn empty() -> Self {
        Routines { graph: Graph::new(), list: Vec::new() }
    }

    fn add(&mut self, name: &'static str, source: &Graph, roots: &[Scaled]) {
        let roots = schedule(source, roots, &mut self.graph);
        self.list.push(Routine { name, roots });
    }

    /// The last function again, with the results from `skip` on.
    fn rest(&mut self, name: &'static str, skip: usize) {
        if let Some(last) = self.list.last() {
            let roots = last.roots[skip..].to_vec();
            self.list.push(Routine { name, roots });
        }
    }

    /// The function of that name.
    pub fn named(&self, name: &str) -> Option<&Routine> {
        self.list.iter().find(|routine| routine.name == name)
    }

    /// How many operations the roots take per call: all but inputs and what parameters settle.
    pub fn operations(&self, roots: &[Id]) -> usize {
        let graph = &self.graph;
        let counts = |id: &Id| graph.moving(*id) && !matches!(graph.node(*id), Node::Input(_));
        graph.reachable(roots).iter().filter(|id| counts(id)).count()
    }
}

/// Moves every variable along the direction v.
fn along(graph: &mut Graph, input: Input) -> Scaled {
    match input {
        Input::Variable(k) => graph.input(Input::Direction(k)).into(),
        _ => Scaled::ZERO,
    }
}

fn scaled(roots: &[Id]) -> Vec<Scaled> {
    roots.iter().map(|&root| root.into()).collect()
}

/// g, G, G v̇ and the jet of equations in so many variables.
pub fn constraint(mut source: Graph, roots: &[Id], variables: u32) -> Routines {
    let mut routines = Routines::empty();
    let values = scaled(roots);
    let mut calculus = Calculus::new(&mut source);
    let jacobian: Vec<Scaled> =
        roots.iter().flat_map(|&root| calculus.gradient(&[(Scaled::ONE, root)], variables)).collect();
    let products = calculus.tangents(&jacobian, along);
    let speed = calculus.tangents(&values, along);
    let acceleration = calculus.tangents(&speed, along);
    routines.add("value", &source, &values);
    routines.add("value_and_jacobian", &source, &[&values[..], &jacobian].concat());
    routines.rest("jacobian", roots.len());
    routines.add("hessian_vector", &source, &products);
    routines.add("jet", &source, &[values, speed, acceleration].concat());
    routines
}

/// U and ∇U.
pub fn potential(mut source: Graph, root: Id, variables: u32) -> Routines {
    let mut routines = Routines::empty();
    let gradient = Calculus::new(&mut source).gradient(&[(Scaled::ONE, root)], variables);
    routines.add("value", &source, &[root.into()]);
    routines.add("gradient", &source, &gradient);
    routines
}

/// U and dU/ds at s = r².
pub fn pair(mut source: Graph, root: Id) -> Routines {
    let mut routines = Routines::empty();
    let square = of_square(&mut source, root);
    routines.add("value", &square.graph, &[square.value.into()]);
    routines.add("slope", &square.graph, &[square.slope]);
    routines
}
