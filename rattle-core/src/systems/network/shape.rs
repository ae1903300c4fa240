//! A network prepared for a number of bodies: its components, and the evaluation of their equations.

use crate::effect::interval::Inertia;
use crate::systems::network::alike::Alike;
use crate::systems::network::group::LinkGroup;
use crate::systems::network::mass::Root;
use crate::systems::network::rows::Rows;
use crate::systems::network::solver::Solver;
use std::fmt;
use std::sync::Arc;

/// The components of a network for so many bodies.
pub(crate) struct Shape<const D: usize> {
    pub(crate) groups: Vec<Arc<dyn LinkGroup<D>>>,
    /// Which of the groups have kinks.
    pub(crate) kinked: Vec<usize>,
    /// Whether a constraint moves.
    pub(crate) moving: bool,
    pub(crate) roots: Vec<Root<D>>,
    /// 1/m along each coordinate, 0 where pinned; none where a mass is a matrix.
    pub(crate) over_masses: Option<Vec<[f64; D]>>,
    pub(crate) pins: Vec<(usize, [f64; D])>,
    pub(crate) components: Vec<Component<D>>,
    /// Those that go side by side, and the others.
    pub(crate) alike: Vec<Alike>,
    pub(crate) alone: Vec<usize>,
    /// Members between pinned bodies alone, as group and member.
    pub(crate) fixed: Vec<(usize, usize)>,
    /// Bodies that are in none, and not pinned.
    pub(crate) loose: Vec<usize>,
    pub(crate) equations: usize,
    pub(crate) blocks: usize,
    /// Rows and blocks of the largest component.
    pub(crate) widest: (usize, usize),
}

impl<const D: usize> fmt::Debug for Shape<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut debug = f.debug_struct("Shape");
        debug.field("equations", &self.equations).field("components", &self.components.len());
        debug.finish_non_exhaustive()
    }
}

pub(crate) struct Component<const D: usize> {
    pub(crate) rows: Rows,
    pub(crate) solver: Solver<D>,
    /// Where its rows and blocks begin among those of all components.
    pub(crate) first: (usize, usize),
}

impl<const D: usize> Shape<D> {
    /// h² M⁻¹f: how far a force alone would move a body in a step of h, twice.
    #[inline]
    pub(crate) fn pushed(&self, body: usize, h: f64, force: &[f64; D]) -> [f64; D] {
        self.roots[body].velocity(force).map(|a| h * h * a)
    }

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
            self.groups[run.group].bends(run.members.clone(), (time, q), (1.0, v), bends, turns);
        }
    }

    /// Of each component that chose its linear algebra at the start: which, and how many equations were independent.
    pub(crate) fn chosen(&self) -> impl Iterator<Item = u64> + '_ {
        let choosing = self.components.iter().filter(|component| !matches!(component.solver, Solver::Few(_)));
        choosing.map(|Component { solver, rows, .. }| {
            2 * solver.rank(rows) as u64 + u64::from(solver.is_orthogonal())
        })
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

impl<const D: usize> Inertia<f64, D> for Shape<D> {
    fn velocity(&self, body: usize, p: &[f64; D]) -> [f64; D] {
        self.roots[body].velocity(p)
    }
    fn root(&self, body: usize, u: &[f64; D]) -> [f64; D] {
        if self.is_pinned(body) { [0.0; D] } else { self.roots[body].restore(u) }
    }
    fn is_pinned(&self, body: usize) -> bool {
        matches!(self.roots[body], Root::Pinned)
    }
}
