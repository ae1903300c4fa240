//! Components that are alike: copies of one small network, such as the molecules of a gas, that go side by side.

use crate::number::instructions::Fusing;
use crate::number::lanes::Fused;
use crate::systems::network::dense::sizes_are_compiled;
use crate::systems::network::group::LinkGroup;
use crate::systems::network::in_lanes::{Number, Numbers, ROW, RowLinks};
use crate::systems::network::mass::Root;
use crate::systems::network::rows::{Rows, Run};
use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// From so many on it pays: a row that is not full costs as much as one that is, 16 dumbbells or 21 triangles alone.
const MANY: usize = 24;

/// Components with the same links between as many bodies, none of them pinned. Their bodies and masses are their own.
pub(crate) struct Alike {
    /// Equations, and coordinates.
    pub(crate) sizes: (usize, usize),
    pub(crate) links: AlikeLinks,
    /// The components, by their number; [`ROW`] at a time are a row.
    pub(crate) components: Vec<usize>,
    /// The bodies of each in turn.
    pub(crate) bodies: Vec<usize>,
    /// 1 over the masses along their coordinates.
    pub(crate) over_masses: Vec<Number>,
    /// Where the rows and the blocks of each begin among those of all.
    pub(crate) first: Vec<(usize, usize)>,
}

/// The links of one component, in terms of its own bodies.
pub(crate) struct AlikeLinks {
    kinds: Vec<OfKind>,
    /// The equation and the coordinate of each entry of the gradients, in the order of blocks.
    pub(crate) entries: Vec<[usize; 2]>,
}

/// Links of one kind, their members, and their equations.
struct OfKind {
    links: Box<dyn RowLinks<ROW>>,
    members: Range<usize>,
    rows: Range<usize>,
    /// How many entries their gradients have.
    entries: usize,
}

impl AlikeLinks {
    /// g at these coordinates, and the entries of its gradients.
    #[inline(always)]
    pub(crate) fn gradients(
        &self,
        set: Fusing,
        q: &[Numbers<ROW>],
        g: &mut [Numbers<ROW>],
        mut gradients: &mut [Numbers<ROW>],
    ) {
        for OfKind { links, members, rows, entries } in &self.kinds {
            let (own, rest) = gradients.split_at_mut(*entries); // kinds follow each other
            links.gradients(set, members.clone(), q, &mut g[rows.clone()], own);
            gradients = rest;
        }
    }

    /// d²g/dt² along constant velocities, and |∇²g v|².
    #[inline(always)]
    pub(crate) fn bends(
        &self,
        set: Fusing,
        q: [&[Numbers<ROW>]; 2],
        bends: &mut [Numbers<ROW>],
        turns: &mut [Numbers<ROW>],
    ) {
        for OfKind { links, members, rows, .. } in &self.kinds {
            let (bends, turns) = (&mut bends[rows.clone()], &mut turns[rows.clone()]);
            links.bends(set, members.clone(), q, bends, turns);
        }
    }
}

impl fmt::Debug for Alike {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} alike", self.components.len())
    }
}

impl Alike {
    /// Those of a network's components, each with where its rows and blocks begin.
    pub(crate) fn of<const D: usize>(
        components: &[(&Rows, (usize, usize))],
        groups: &[Arc<dyn LinkGroup<D>>],
        roots: &[Root<D>],
    ) -> Vec<Self> {
        let mut by_kind: BTreeMap<Vec<usize>, Vec<usize>> = BTreeMap::new();
        for (c, (rows, _)) in components.iter().enumerate() {
            if let Some(kind) = kind_of(rows) {
                by_kind.entry(kind).or_default().push(c);
            }
        }
        let rows = by_kind.into_values().filter_map(|mut alike| {
            let beyond = alike.len() % ROW; // who are too few for a row of their own
            alike.truncate(alike.len() - if beyond < MANY { beyond } else { 0 });
            if alike.is_empty() { None } else { Self::with(alike, components, groups, roots) }
        });
        rows.collect()
    }

    fn with<const D: usize>(
        alike: Vec<usize>,
        components: &[(&Rows, (usize, usize))],
        groups: &[Arc<dyn LinkGroup<D>>],
        roots: &[Root<D>],
    ) -> Option<Self> {
        let rows = components[alike[0]].0;
        let place = |body: usize| rows.bodies.iter().position(|&other| other == body).unwrap_or(0);
        let kind = |run: &Run| {
            let group = &groups[run.group];
            let links = group.alike(run.members.clone(), &place)?;
            let equations = run.members.len() * group.equations();
            let (members, own) = (0..run.members.len(), run.row..run.row + equations);
            let entries = own.clone().map(|row| D * rows.blocks_of(row).count()).sum();
            Some(OfKind { links, members, rows: own, entries })
        };
        let kinds = rows.runs.iter().map(kind).collect::<Option<Vec<_>>>()?;
        let mut entries = Vec::new();
        for row in 0..rows.equations() {
            for (_, body) in rows.blocks_of(row) {
                entries.extend((0..D).map(|d| [row, body * D + d]));
            }
        }
        let mut over_masses = Vec::new();
        let bodies: Vec<usize> = alike.iter().flat_map(|&c| components[c].0.bodies.iter().copied()).collect();
        for &body in &bodies {
            over_masses.extend(roots[body].over_masses()?.map(Fused));
        }
        Some(Self {
            sizes: (rows.equations(), rows.bodies.len() * D),
            links: AlikeLinks { kinds, entries },
            bodies,
            over_masses,
            first: alike.iter().map(|&c| components[c].1).collect(),
            components: alike,
        })
    }

    /// The components of the row that begins with this one, and their bodies in turn.
    pub(crate) fn row(&self, number: usize) -> [&[usize]; 2] {
        let end = self.components.len().min(number + ROW);
        let each = self.bodies.len() / self.components.len();
        [&self.components[number..end], &self.bodies[number * each..end * each]]
    }

    /// How many rows they are.
    pub(crate) fn rows(&self) -> usize {
        self.components.len().div_ceil(ROW)
    }
}

/// The components that are in none of these.
pub(crate) fn alone(components: usize, alike: &[Alike]) -> Vec<usize> {
    let mut alone = vec![true; components];
    alike.iter().flat_map(|alike| &alike.components).for_each(|&c| alone[c] = false);
    (0..components).filter(|&c| alone[c]).collect()
}

/// A list that is the same for components that are alike; none for those that go by themselves.
fn kind_of(rows: &Rows) -> Option<Vec<usize>> {
    if rows.acting || rows.moving || !sizes_are_compiled(rows.equations(), rows.bodies.len()) {
        return None;
    }
    let mut kind = vec![rows.equations(), rows.bodies.len()];
    for run in &rows.runs {
        kind.extend([run.group, run.row, run.members.len()]);
    }
    for row in 0..rows.equations() {
        let (free, touched) = (rows.blocks_of(row), rows.touched_by(row).count());
        let bodies: Vec<usize> = free.map(|(_, body)| body).collect();
        if bodies.len() != touched {
            return None; // a pinned one
        }
        kind.push(touched);
        kind.extend(bodies);
    }
    Some(kind)
}
