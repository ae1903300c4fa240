//! Bodies tied together: any number of constraints between any bodies, with masses, pins and motion in time.
//!
//! A **kernel**, what `constraint!` writes, is a small local function. A **topology** says which bodies each copy of it
//! ties together. From the two, components that share no body are found; each is solved by itself, with the linear algebra
//! that suits it.
//!
//! ```text
//! M q̈ = f(q) + G(q, t)ᵀ λ,    g(q, t) = 0,    one block of M for each body
//! ```

mod elimination;
mod factor;
mod group;
mod mass;
mod order;
mod orthogonal;
mod pattern;
mod rows;
mod solver;
mod start;
#[cfg(feature = "faer")]
mod supernodal;
#[cfg(test)]
mod tests;

pub use mass::Mass;
pub use solver::{LinearAlgebra, Report};

pub(crate) use group::{Group, Links};
pub(crate) use mass::Root;
pub(crate) use rows::{Rows, components};
pub(crate) use solver::Solver;

use crate::bodies::Count;
use crate::effect::Effects;
use crate::error::{Error, NetworkMistake};
use crate::linked::Linked;
use crate::scene::{Hold, Tie};
use crate::state::State;
use crate::stepper::Stepper;
use std::sync::Arc;

/// Constraints between bodies, and their masses; made by [`Scene`](crate::scene::Scene)'s methods.
#[derive(Debug, Clone)]
pub struct Network<const D: usize> {
    pub(crate) groups: Vec<Arc<dyn Group<D>>>,
    pub(crate) masses: Masses<D>,
    pub(crate) pins: Vec<(usize, [f64; D])>,
    pub(crate) algebra: LinearAlgebra,
}

/// Whose masses.
#[derive(Debug, Clone)]
pub(crate) enum Masses<const D: usize> {
    /// The same for every body.
    Each(Mass<D>),
    /// Those of the bodies in turn.
    Listed(Vec<Mass<D>>),
}

impl<const D: usize> Default for Network<D> {
    fn default() -> Self {
        Self {
            groups: Vec::new(),
            masses: Masses::Each(Mass::Unit),
            pins: Vec::new(),
            algebra: LinearAlgebra::Automatic,
        }
    }
}

/// The components of a network for so many bodies.
#[derive(Debug)]
pub(crate) struct Shape<const D: usize> {
    pub(crate) groups: Vec<Arc<dyn Group<D>>>,
    pub(crate) roots: Vec<Root<D>>,
    pub(crate) pins: Vec<(usize, [f64; D])>,
    pub(crate) components: Vec<Component<D>>,
    /// Members between pinned bodies alone, as group and member.
    pub(crate) fixed: Vec<(usize, usize)>,
    /// Bodies that are in none, and not pinned.
    pub(crate) loose: Vec<usize>,
    pub(crate) equations: usize,
    pub(crate) blocks: usize,
    /// Rows and blocks of the largest component.
    pub(crate) widest: (usize, usize),
}

#[derive(Debug)]
pub(crate) struct Component<const D: usize> {
    pub(crate) rows: Rows,
    pub(crate) solver: Solver<D>,
    /// Where its rows and blocks begin among those of all components.
    pub(crate) first: (usize, usize),
}

/// Up to so many equations an orthonormal basis is as fast as elimination.
const FEW: usize = 6;

impl<const D: usize> Network<D> {
    pub(crate) fn with(mut self, links: impl Group<D> + 'static) -> Self {
        self.groups.push(Arc::new(links));
        self
    }

    /// For so many bodies.
    pub(crate) fn shape(&self, bodies: usize) -> Result<Shape<D>, Error> {
        let mistake = |what| Err(Error::Network(what));
        let mut roots = Vec::with_capacity(bodies);
        match &self.masses {
            Masses::Listed(list) if list.len() != bodies => {
                return mistake(NetworkMistake::MassCount { masses: list.len(), bodies });
            }
            masses => {
                for body in 0..bodies {
                    let mass = match masses {
                        Masses::Each(mass) => mass,
                        Masses::Listed(list) => &list[body],
                    };
                    let Some(root) = Root::new(mass) else {
                        return mistake(NetworkMistake::Mass { body });
                    };
                    roots.push(root);
                }
            }
        }
        for &(body, _) in &self.pins {
            if body >= bodies {
                return mistake(NetworkMistake::NoSuchBody { what: "pin", member: 0, body, bodies });
            }
            roots[body] = Root::Pinned;
        }
        for group in &self.groups {
            let (touched, arity) = group.bodies();
            for (member, ends) in touched.chunks_exact(arity).enumerate() {
                if let Some(&body) = ends.iter().find(|&&body| body >= bodies) {
                    return mistake(NetworkMistake::NoSuchBody { what: group.name(), member, body, bodies });
                }
                if let Some(&body) =
                    ends.iter().enumerate().find_map(|(i, b)| ends[..i].contains(b).then_some(b))
                {
                    return mistake(NetworkMistake::Repeated { what: group.name(), member, body });
                }
                if group.acting().is_some() && ends.iter().any(|&body| !roots[body].is_diagonal()) {
                    return mistake(NetworkMistake::ActingNeedsDiagonalMass { what: group.name() });
                }
            }
        }
        let (mut rows_so_far, mut blocks_so_far, mut widest) = (0, 0, (0, 0));
        let (components, fixed) = components(&self.groups, &roots);
        let components: Vec<_> = components
            .into_iter()
            .map(|rows| {
                let first = (rows_so_far, blocks_so_far);
                let (equations, blocks) = (rows.equations(), rows.blocks());
                rows_so_far += equations;
                blocks_so_far += blocks;
                widest = (widest.0.max(equations), widest.1.max(blocks));
                let few = equations <= FEW;
                let solver = match self.algebra {
                    LinearAlgebra::Orthogonal => Solver::orthogonal(&rows),
                    LinearAlgebra::Automatic if few => Solver::orthogonal(&rows),
                    #[cfg(feature = "faer")]
                    LinearAlgebra::Supernodal => Solver::supernodal(&rows),
                    LinearAlgebra::Automatic | LinearAlgebra::Elimination => Solver::elimination(&rows),
                };
                Component { rows, solver, first }
            })
            .collect();
        let mut held = vec![false; bodies];
        components.iter().flat_map(|component| &component.rows.bodies).for_each(|&body| held[body] = true);
        self.pins.iter().for_each(|&(body, _)| held[body] = true);
        let loose = (0..bodies).filter(|&body| !held[body]).collect();
        Ok(Shape {
            groups: self.groups.clone(),
            roots,
            pins: self.pins.clone(),
            components,
            loose,
            fixed,
            equations: self
                .groups
                .iter()
                .map(|group| group.bodies().0.len() / group.bodies().1 * group.equations())
                .sum(),
            blocks: blocks_so_far,
            widest,
        })
    }
}

impl<const D: usize> Tie<D> for Network<D> {
    fn network(self, _: usize) -> Self {
        self
    }
}

impl<const D: usize> Hold<D> for Network<D> {
    type System<E: Effects<D>, N: Count> = Linked<E::Field<f64>, N, D>;

    fn system<E: Effects<D>, N: Count>(
        &self,
        effects: &E,
        count: N,
        start: &State<D>,
        method: &impl Stepper,
    ) -> Result<Self::System<E, N>, Error> {
        let mut shape = self.shape(count.number())?;
        start::check(&mut shape, self.algebra, start, method)?;
        Ok(Linked::new(shape, effects.field(), count))
    }

    fn pinned(&self, body: usize) -> bool {
        self.pins.iter().any(|&(pinned, _)| pinned == body)
    }

    fn particles(self, number: usize) -> Self {
        let each = |group: Arc<dyn Group<D>>| group.for_each(number).map_or(group, Arc::from);
        Self { groups: self.groups.into_iter().map(each).collect(), ..self }
    }

    fn project(&self, state: &State<D>) -> Result<State<D>, Error> {
        start::project(&mut self.shape(state.len())?, self.algebra, state)
    }
}

impl<const D: usize> Shape<D> {
    /// g, ∂g/∂q without what is pinned, and ∂g/∂t of a component.
    pub(crate) fn gradients(
        &self,
        component: usize,
        time: f64,
        q: &[[f64; D]],
        g: &mut [f64],
        blocks: &mut [[f64; D]],
        rates: &mut [f64],
    ) {
        for run in &self.components[component].rows.runs {
            let (rows, blocks) = (run.row, &mut blocks[run.block..]);
            let group = &self.groups[run.group];
            group.gradients(run.members.clone(), time, q, &mut g[rows..], blocks, &mut rates[rows..]);
        }
    }

    /// g of a component.
    pub(crate) fn values(&self, component: usize, time: f64, q: &[[f64; D]], g: &mut [f64]) {
        for run in &self.components[component].rows.runs {
            self.groups[run.group].values(run.members.clone(), time, q, &mut g[run.row..]);
        }
    }

    /// g̈ along constant velocities, and |∇²g v|², of a component.
    pub(crate) fn bends(
        &self,
        component: usize,
        time: f64,
        q: &[[f64; D]],
        v: &[[f64; D]],
        bends: &mut [f64],
        turns: &mut [f64],
    ) {
        for run in &self.components[component].rows.runs {
            let (bends, turns) = (&mut bends[run.row..], &mut turns[run.row..]);
            self.groups[run.group].bends(run.members.clone(), time, q, v, bends, turns);
        }
    }

    /// What the multipliers act along: the gradients, without the coordinates that they are kept from.
    pub(crate) fn mask(&self, component: usize, blocks: &mut [[f64; D]]) {
        for run in &self.components[component].rows.runs {
            if let Some(acting) = self.groups[run.group].acting() {
                let rows = run.members.len() * self.groups[run.group].equations();
                for blocks in blocks[run.block..].chunks_exact_mut(acting.len()).take(rows) {
                    for (block, acts) in blocks.iter_mut().zip(acting) {
                        for (entry, acts) in block.iter_mut().zip(acts) {
                            *entry = if *acts { *entry } else { 0.0 };
                        }
                    }
                }
            }
        }
    }
}
