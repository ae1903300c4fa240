//! A component: equations coupled by the bodies that they share. Each component is solved by itself.

use crate::number::vector::add_scaled;
use crate::solve::stop::Terms;
use crate::systems::network::group::LinkGroup;
use crate::systems::network::line::Line;
use crate::systems::network::mass::Root;
use std::ops::Range;
use std::sync::Arc;

/// Members of one group that lie in one component, side by side.
#[derive(Debug, Clone)]
pub(crate) struct Run {
    pub(crate) group: usize,
    pub(crate) members: Range<usize>,
    /// Where its rows begin among those of the component.
    pub(crate) row: usize,
    /// Where its blocks begin.
    pub(crate) block: usize,
}

/// Which blocks belong to which equation and body of a component.
#[derive(Debug, Clone)]
pub(crate) struct Rows {
    pub(crate) runs: Vec<Run>,
    /// Bodies that can move, by their number in the scene.
    pub(crate) bodies: Vec<usize>,
    /// Blocks of row i are those from `start[i]` to `start[i + 1]`.
    start: Vec<usize>,
    /// For each block its place in `bodies`, or [`PINNED`].
    body: Vec<usize>,
    /// For each block its body's number in the scene.
    touched: Vec<usize>,
    /// For each block 1, or 0 if its body is pinned.
    free: Vec<f64>,
    /// The number of each row among the scene's equations, in the order of naming.
    equation: Vec<usize>,
    /// Whether a multiplier acts on chosen coordinates only.
    pub(crate) acting: bool,
    pub(crate) moving: bool,
    width: usize,
    pub(crate) line: Option<Line>,
}

const PINNED: usize = usize::MAX;

impl Rows {
    pub(crate) fn equations(&self) -> usize {
        self.start.len() - 1
    }

    pub(crate) fn blocks(&self) -> usize {
        self.body.len()
    }

    /// The number of a row among the scene's equations.
    pub(crate) fn equation(&self, row: usize) -> usize {
        self.equation[row]
    }

    /// The blocks of an equation, each with its body's place in `bodies`; not those of bodies that are pinned.
    #[inline]
    pub(crate) fn blocks_of(&self, row: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        let blocks = self.start[row]..self.start[row + 1];
        blocks.map(|block| (block, self.body[block])).filter(|&(_, body)| body != PINNED)
    }

    /// The blocks of an equation, each with its body's number in the scene, pinned or not.
    #[inline]
    pub(crate) fn touched_by(&self, row: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        let blocks = self.start[row]..self.start[row + 1];
        blocks.map(|block| (block, self.touched[block]))
    }

    /// The same of all equations, one after the other.
    pub(crate) fn touched(&self) -> &[usize] {
        &self.touched
    }

    /// What g of an equation is made of, by its normal and at these places.
    pub(crate) fn terms<const D: usize>(&self, row: usize, blocks: &[[f64; D]], q: &[[f64; D]]) -> Terms {
        Terms::of(self.touched_by(row).map(|(block, body)| (&blocks[block], q[body], [0.0; D])))
    }

    /// For each block 1, or 0 if its body is pinned.
    pub(crate) fn free(&self) -> &[f64] {
        &self.free
    }

    /// How many blocks each equation has, if all have as many; else 0.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// The numbers of the blocks of an equation, pinned or not; `A` is [`Self::width`], or 0.
    #[inline(always)]
    pub(crate) fn range<const A: usize>(&self, row: usize) -> Range<usize> {
        if A > 0 { A * row..A * (row + 1) } else { self.start[row]..self.start[row + 1] }
    }

    /// The run that a row belongs to, its member, and its number among the member's equations.
    pub(crate) fn find<const D: usize>(
        &self,
        groups: &[Arc<dyn LinkGroup<D>>],
        row: usize,
    ) -> (usize, usize, usize) {
        let run = &self.runs[self.runs.partition_point(|run| run.row <= row) - 1];
        let equations = groups[run.group].equations();
        (run.group, run.members.start + (row - run.row) / equations, (row - run.row) % equations)
    }
}

/// The components of all groups; bodies that are pinned tie nothing together.
///
/// Also members between pinned bodies alone, as group and member: they hold or they do not, and nothing moves them.
pub(crate) fn components<const D: usize>(
    groups: &[Arc<dyn LinkGroup<D>>],
    roots: &[Root<D>],
) -> (Vec<Rows>, Vec<(usize, usize)>) {
    let free = |body: usize| !matches!(roots[body], Root::Pinned);
    let shapes: Vec<_> = groups.iter().map(|group| group.bodies()).collect();

    // Union–find over the bodies.
    let mut parent: Vec<usize> = (0..roots.len()).collect();
    fn root(parent: &mut [usize], mut i: usize) -> usize {
        while parent[i] != i {
            parent[i] = parent[parent[i]];
            i = parent[i];
        }
        i
    }
    for (touched, arity) in &shapes {
        for member in touched.chunks_exact(*arity) {
            let mut free_bodies = member.iter().copied().filter(|&body| free(body));
            if let Some(first) = free_bodies.next() {
                for body in free_bodies {
                    let (a, b) = (root(&mut parent, first), root(&mut parent, body));
                    parent[a.max(b)] = a.min(b);
                }
            }
        }
    }

    let mut number = vec![PINNED; roots.len()]; // of the component, by the root of its bodies
    let mut place = vec![PINNED; roots.len()]; // of a body in its component
    let mut components: Vec<Rows> = Vec::new();
    let mut fixed = Vec::new();
    let mut equation = 0;
    for (group, (touched, arity)) in shapes.iter().enumerate() {
        let rows = groups[group].equations();
        for (member, bodies) in touched.chunks_exact(*arity).enumerate() {
            let Some(first) = bodies.iter().copied().find(|&body| free(body)) else {
                fixed.push((group, member));
                equation += rows;
                continue;
            };
            let key = root(&mut parent, first);
            if number[key] == PINNED {
                number[key] = components.len();
                components.push(Rows {
                    runs: Vec::new(),
                    bodies: Vec::new(),
                    start: vec![0],
                    body: Vec::new(),
                    touched: Vec::new(),
                    free: Vec::new(),
                    equation: Vec::new(),
                    acting: false,
                    moving: false,
                    width: *arity,
                    line: None,
                });
            }
            let component = &mut components[number[key]];
            component.acting |= groups[group].acting().is_some();
            component.moving |= groups[group].moving();
            component.width = if component.width == *arity { *arity } else { 0 };
            let (row, block) = (component.equations(), component.blocks());
            match component.runs.last_mut() {
                Some(run) if run.group == group && run.members.end == member => run.members.end += 1,
                _ => component.runs.push(Run { group, members: member..member + 1, row, block }),
            }
            for &body in bodies {
                if free(body) && place[body] == PINNED {
                    place[body] = component.bodies.len();
                    component.bodies.push(body);
                }
            }
            for i in 0..rows {
                component.equation.push(equation + i);
                component.body.extend(bodies.iter().map(|&body| place[body]));
                component.touched.extend(bodies);
                component.free.extend(bodies.iter().map(|&body| f64::from(u8::from(free(body)))));
                component.start.push(component.body.len());
            }
            equation += rows;
        }
    }
    for rows in &mut components {
        rows.line = Line::new(&rows.touched, &rows.free, rows.width);
    }
    (components, fixed)
}

/// The rows and blocks of a body, and an x.
#[derive(Clone, Copy)]
pub(super) struct Blocks<'a, const D: usize> {
    pub(super) own: &'a [(usize, usize)],
    pub(super) blocks: &'a [[f64; D]],
    pub(super) x: &'a [f64],
}

impl<const D: usize> Blocks<'_, D> {
    /// A place and what they add up to, times `scale`, in the order of the rows.
    #[inline(always)]
    pub(super) fn add_to(&self, start: [f64; D], scale: f64) -> [f64; D] {
        let add =
            |sum, &(row, block): &(usize, usize)| add_scaled(&sum, scale * self.x[row], &self.blocks[block]);
        self.own.iter().fold(start, add)
    }
}
