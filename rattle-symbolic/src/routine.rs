//! The functions that each macro generates, scheduled into one graph.
//!
//! All functions of a kernel share one target graph, so that operations on parameters alone are found once for all of
//! them. The Jacobian alone has the same operations as in value-and-Jacobian, so the two agree bit for bit.

use crate::algebra::Scaled;
use crate::differentiate::Calculus;
use crate::graph::Graph;
use crate::kinks::{Kink, kinks};
use crate::limits::{MOST, TooLarge};
use crate::node::{Id, Input};
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

/// Beyond so many operations and entries of value and Jacobian, what the trait can make of the other functions
/// is left to it, and functions this long are not inlined at every call, but cut into chapters: the
/// compiler's time goes with the length of the text, used or not, and faster than that with the length of
/// one function.
///
/// ```text
///                              in one function    in chapters of 256
/// release  (5 000 operations)        25 s                11 s       of which expansion 2.3 s, LLVM 16 s → 4 s
/// debug                              10 s                11 s                              LLVM 4 s → 1.5 s
/// ```
///
/// on one core, by the commands in `examples/tangled.rs`; there value, Jacobian, Hessian·vector and jet come to
/// 60 000 operations. Long sums of plain products take half of that or less.
pub(crate) const LARGE: usize = 2000;

/// An operation on parameters alone counts so many times: all of them are in one function, and each makes a field.
/// 27 000 of them, 9000 sines, took the compiler 15 s.
const STILL: usize = 4;

/// The functions of a kernel.
#[derive(Clone, Debug)]
pub struct Routines {
    /// Binary operations only.
    pub graph: Graph,
    /// The functions.
    pub list: Vec<Routine>,
    /// Operations of all of them, and a sixteenth of their results.
    size: usize,
    /// The gradient of each equation, for the documentation: in a graph of sums and products.
    pub(crate) gradients: (Graph, Vec<Scaled>),
    /// What changes sign where equations are not smooth, in the same graph.
    pub(crate) kinks: Vec<Id>,
    /// Whether a force depends on velocities.
    pub(crate) on_velocity: bool,
}

impl Routines {
    /// No function at all.
    pub(crate) fn empty() -> Self {
        let gradients = (Graph::new(), Vec::new());
        let (graph, list, kinks) = (Graph::new(), Vec::new(), Vec::new());
        Routines { graph, list, size: 0, gradients, kinks, on_velocity: false }
    }

    pub(crate) fn add(
        &mut self,
        name: &'static str,
        source: &Graph,
        roots: &[Scaled],
    ) -> Result<(), TooLarge> {
        self.add_beside(name, source, &[], roots)
    }

    /// Where equations are not smooth: a function, and what users are told.
    fn add_kinks(&mut self, source: &Graph, kinks: &[Kink]) -> Result<(), TooLarge> {
        let changes: Vec<Id> = kinks.iter().map(|kink| kink.changes).collect();
        self.kinks = kinks.iter().map(|kink| kink.shown).collect();
        self.add("kinks", source, &scaled(&changes))
    }

    /// A function that shares what it can with `others`, as if one function had the results of both.
    fn add_beside(
        &mut self,
        name: &'static str,
        source: &Graph,
        others: &[Scaled],
        roots: &[Scaled],
    ) -> Result<(), TooLarge> {
        let both = schedule(source, &[others, roots].concat(), &mut self.graph);
        let roots = both[others.len()..].to_vec();
        self.size += self.operations(&roots) + roots.len() / 16;
        self.list.push(Routine { name, roots });
        self.room(0)
    }

    /// Whether there is room for so many results.
    fn room(&self, results: usize) -> Result<(), TooLarge> {
        let still = self.graph.still_operations();
        let found = self.size + STILL * still + results / 16;
        let written = self.list.first().map(|value| still + self.operations(&value.roots));
        if found > MOST { Err(TooLarge { written, found }) } else { Ok(()) }
    }

    /// The last function again, with the results from `skip` on.
    fn rest(&mut self, name: &'static str, skip: usize) {
        if let Some(last) = self.list.last() {
            let roots = last.roots[skip..].to_vec();
            self.list.push(Routine { name, roots });
        }
    }

    /// The function of this name.
    pub fn named(&self, name: &str) -> Option<&Routine> {
        self.list.iter().find(|routine| routine.name == name)
    }

    /// The work of differentiating and scheduling, in steps; see [`Graph::steps`].
    pub fn steps(&self) -> usize {
        self.graph.steps() + self.gradients.0.steps()
    }

    /// The number of operations of the roots per call: without inputs, and without operations on parameters alone.
    pub fn operations(&self, roots: &[Id]) -> usize {
        self.graph.operations(roots)
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

/// Moves one variable alone.
fn unit(k: u32) -> impl Fn(&mut Graph, Input) -> Scaled {
    move |_, input| if input == Input::Variable(k) { Scaled::ONE } else { Scaled::ZERO }
}

/// The functions of a constraint, for equations in `variables` variables.
pub fn constraint(mut source: Graph, roots: &[Id], variables: u32) -> Result<Routines, TooLarge> {
    let mut routines = Routines::empty();
    let values = scaled(roots);
    let kinks = kinks(&mut source, roots);
    let (d, m) = (variables as usize, roots.len());
    routines.add("value", &source, &values)?;
    routines.room(d * m)?;
    let mut calculus = Calculus::new(&mut source);
    let jacobian: Vec<Scaled> =
        roots.iter().flat_map(|&root| calculus.gradient(&[(Scaled::ONE, root)], variables)).collect();
    routines.add("value_and_jacobian", calculus.graph, &[&values[..], &jacobian].concat())?;
    let products = calculus.tangents(&jacobian, along);
    let speed = calculus.tangents(&values, along);
    let acceleration = calculus.tangents(&speed, along);
    let both = routines.list.last().map_or(0, |last| routines.operations(&last.roots));
    let large = both + m * d > LARGE;
    if !large {
        routines.rest("jacobian", m);
    }
    routines.add("hessian_vector", &source, &products)?;
    routines.add("jet", &source, &[values, speed, acceleration].concat())?;
    // One sweep over all operations for each column, and as many entries.
    if d * both + m * d * d <= 4 * LARGE {
        let hessian = hessian(&mut Calculus::new(&mut source), &jacobian, variables);
        routines.add("hessian", &source, &hessian)?;
    }
    if !large {
        let mut calculus = Calculus::new(&mut source);
        let weights: Vec<(Scaled, Id)> =
            (0..).zip(roots).map(|(i, &root)| (weight(&mut calculus, i), root)).collect();
        let weighted = calculus.gradient(&weights, variables);
        let weighted = calculus.tangents(&weighted, along);
        routines.add("weighted_hessian_vector", &source, &weighted)?;
    }
    routines.add_kinks(&source, &kinks)?;
    routines.gradients = (source, jacobian);
    Ok(routines)
}

fn weight(calculus: &mut Calculus, i: u32) -> Scaled {
    calculus.graph.input(Input::Weight(i)).into()
}

/// All second derivatives, row by row for each equation; what is below the diagonal is what is above.
fn hessian(calculus: &mut Calculus, jacobian: &[Scaled], variables: u32) -> Vec<Scaled> {
    let columns: Vec<Vec<Scaled>> = (0..variables).map(|k| calculus.tangents(jacobian, unit(k))).collect();
    let d = variables as usize;
    let mut list = Vec::with_capacity(jacobian.len() * d);
    for row in 0..jacobian.len() {
        let (equation, i) = (row / d, row % d);
        list.extend((0..d).map(|j| columns[i.max(j)][equation * d + i.min(j)]));
    }
    list
}

/// U and ∇U.
pub fn potential(mut source: Graph, root: Id, variables: u32) -> Result<Routines, TooLarge> {
    let mut routines = Routines::empty();
    routines.add("value", &source, &[root.into()])?;
    let gradient = Calculus::new(&mut source).gradient(&[(Scaled::ONE, root)], variables);
    routines.add_beside("gradient", &source, &[root.into()], &gradient)?;
    routines.gradients = (source, gradient);
    Ok(routines)
}

/// U(q, t), ∂U/∂q and ∂U/∂t; the time is the last variable.
pub fn driven_potential(mut source: Graph, root: Id, variables: u32) -> Result<Routines, TooLarge> {
    let mut routines = Routines::empty();
    routines.add("value", &source, &[root.into()])?;
    let all = Calculus::new(&mut source).gradient(&[(Scaled::ONE, root)], variables);
    let (gradient, rate) = all.split_at(variables as usize - 1);
    routines.add_beside("gradient", &source, &[root.into()], gradient)?;
    routines.add("rate", &source, rate)?;
    routines.gradients = (source, all);
    Ok(routines)
}

/// f(q, v, t), and, where it depends on v, ∂f/∂v: row i belongs to fᵢ. The variables are as many coordinates as there
/// are components, then as many velocities or none, then perhaps the time.
pub fn force(
    mut source: Graph,
    roots: &[Id],
    variables: u32,
    has_velocities: bool,
) -> Result<Routines, TooLarge> {
    let mut routines = Routines::empty();
    let (values, k) = (scaled(roots), roots.len());
    routines.add("value", &source, &values)?;
    routines.room(variables as usize * k)?;
    let mut calculus = Calculus::new(&mut source);
    let rows: Vec<Vec<Scaled>> =
        roots.iter().map(|&root| calculus.gradient(&[(Scaled::ONE, root)], variables)).collect();
    let slopes: Vec<Scaled> = rows.iter().filter_map(|row| row.get(k..2 * k)).flatten().copied().collect();
    let sloped = slopes.iter().any(|slope| slope.factor != 0.0);
    let velocities = k as u32..2 * k as u32;
    routines.on_velocity = has_velocities && (sloped || calculus.choose_by(roots, velocities));
    if has_velocities && sloped {
        routines.add("value_and_slopes", &source, &[&values[..], &slopes].concat())?;
    }
    routines.gradients = (source, rows.concat());
    Ok(routines)
}

/// H, ∂H/∂q and ∂H/∂p, and ∇²H v.
pub fn hamiltonian(mut source: Graph, root: Id, variables: u32) -> Result<Routines, TooLarge> {
    let mut routines = Routines::empty();
    routines.add("value", &source, &[root.into()])?;
    let mut calculus = Calculus::new(&mut source);
    let gradient = calculus.gradient(&[(Scaled::ONE, root)], variables);
    routines.add("gradients", calculus.graph, &gradient)?;
    let product = calculus.tangents(&gradient, along);
    routines.add("hessian_vector", &source, &product)?;
    routines.gradients = (source, gradient);
    Ok(routines)
}

/// g(q, p), ∂g/∂q and ∂g/∂p, and ∇²g v: first all rows by q, then all by p.
pub fn phase_constraint(mut source: Graph, roots: &[Id], variables: u32) -> Result<Routines, TooLarge> {
    let mut routines = Routines::empty();
    let values = scaled(roots);
    let kinks = kinks(&mut source, roots);
    routines.add("value", &source, &values)?;
    routines.room(variables as usize * roots.len())?;
    let mut calculus = Calculus::new(&mut source);
    let rows: Vec<Vec<Scaled>> =
        roots.iter().map(|&root| calculus.gradient(&[(Scaled::ONE, root)], variables)).collect();
    let half = variables as usize / 2;
    let halves = [0..half, half..2 * half];
    let jacobians: Vec<Scaled> = halves
        .into_iter()
        .flat_map(|part| rows.iter().flat_map(move |row| row[part.clone()].to_vec()))
        .collect();
    routines.add("value_and_jacobians", calculus.graph, &[&values[..], &jacobians].concat())?;
    routines.rest("jacobians", roots.len());
    let products = calculus.tangents(&jacobians, along);
    routines.add("hessian_vector", &source, &products)?;
    routines.add_kinks(&source, &kinks)?;
    routines.gradients = (source, rows.concat());
    Ok(routines)
}

/// U and dU/ds at s = r².
pub fn pair(mut source: Graph, root: Id) -> Result<Routines, TooLarge> {
    let mut routines = Routines::empty();
    let square = of_square(&mut source, root);
    routines.add("value", &square.graph, &[square.value.into()])?;
    routines.add("slope", &square.graph, &[square.slope])?;
    Ok(routines)
}
