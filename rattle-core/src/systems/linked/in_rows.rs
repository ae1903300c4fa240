//! Components that are alike, put into rows and written back.
//!
//! After a step in rows these hold the normals of their components, and solvers and blocks do not: who needs them has
//! them evaluated first ([`Tied::lend_normals`](crate::systems::linked::kept::Tied::lend_normals)). Both hold functions
//! of the positions, to the bit; rows evaluate with fused products. Momenta are always made tangent in rows.

use crate::effect::force::Force;
use crate::motion::witness::Witness;
use crate::number::instructions::Fusing;
use crate::number::lanes::Fused;
use crate::solve::aim::{Aim, ROUNDINGS};
use crate::systems::linked::abreast::{Coordinates, KeptRow, Lanes, RowUnderWay, are_rows};
use crate::systems::linked::moving::Moving;
use crate::systems::network::alike::Alike;
use crate::systems::network::in_lanes::ROW;
use crate::systems::network::shape::Shape;
use crate::systems::network::solver::Solver;

/// Rows of components.
#[derive(Clone)]
pub(super) struct InRows {
    set: Option<Fusing>,
    rows: Vec<KeptRow>,
    lanes: Option<Box<Lanes>>,
    /// Whether rows hold the normals, and whether solvers and blocks do.
    hold: bool,
    solvers_hold: bool,
    /// Components that go by themselves: others than those alike, and those whose normals are not clearly independent.
    by_itself: Vec<bool>,
    /// The row and the lane of a component.
    places: Vec<Option<[usize; 2]>>,
    /// Components that are still to be moved.
    left: List,
}

/// Components, with room for all, also in a clone: none is made in a step.
struct List(Vec<usize>);

impl Clone for List {
    fn clone(&self) -> Self {
        let mut list = Vec::with_capacity(self.0.capacity());
        list.extend_from_slice(&self.0);
        Self(list)
    }
}

impl InRows {
    /// Those of a network, none of them filled in.
    pub(super) fn new<const D: usize>(shape: &Shape<D>) -> Self {
        let set = Fusing::widest().filter(|_| are_rows(D) && !shape.alike.is_empty());
        let components = shape.components.len();
        let mut all = Self {
            set,
            rows: Vec::new(),
            lanes: set.map(|_| Lanes::new()),
            hold: false,
            solvers_hold: true,
            by_itself: vec![true; components],
            places: vec![None; components],
            left: List((0..components).collect()),
        };
        for alike in shape.alike.iter().filter(|_| set.is_some()) {
            let masses = alike.over_masses.chunks(ROW * alike.sizes.1);
            for (components, masses) in alike.components.chunks(ROW).zip(masses) {
                let mut row = KeptRow::new(alike.sizes, alike.links.entries.len());
                for (lane, &c) in components.iter().enumerate() {
                    all.places[c] = Some([all.rows.len(), lane]);
                    let own = &masses[lane * alike.sizes.1..];
                    // Lanes that no component is in have the masses of the last one.
                    row.over.iter_mut().zip(own).for_each(|(over, &of)| over.0[lane..].fill(of));
                }
                all.rows.push(row);
            }
        }
        all
    }

    /// Has rows hold the normals, if solvers and blocks do. Evaluates them: they are to be functions of the positions,
    /// to the bit.
    fn take<const D: usize>(
        &mut self,
        set: Fusing,
        shape: &Shape<D>,
        solvers: &mut [Solver<D>],
        q: &[[f64; D]],
    ) {
        if std::mem::replace(&mut self.hold, true) {
            return;
        }
        let Self { rows, lanes: Some(lanes), by_itself, .. } = self else { return };
        for (alike, number, kept) in each_row(shape, rows) {
            for &c in alike.row(number)[0] {
                by_itself[c] = solvers[c].dense().is_none();
            }
            evaluate(set, alike, number, q, kept, lanes);
        }
    }

    /// Whether solvers hold all normals.
    pub(super) fn solvers_hold(&self) -> bool {
        self.solvers_hold
    }

    /// Whether a row holds the normals of a component, and its solver does not.
    pub(super) fn alone_holds(&self, c: usize) -> bool {
        !self.solvers_hold && self.places[c].is_some() && !self.by_itself[c]
    }

    /// Solvers have taken the normals over, too.
    pub(super) fn have_lent(&mut self) {
        self.solvers_hold = true;
    }

    /// Solvers alone have the normals, or are to have them.
    pub(super) fn forget(&mut self) {
        (self.hold, self.solvers_hold) = (false, true);
    }

    /// The same, and all components are to be moved one by one.
    pub(super) fn leave_all(&mut self) {
        if self.set.is_some() {
            self.left.0.clear();
            self.left.0.extend(0..self.places.len());
        }
        self.forget();
    }

    /// Whether any go in rows.
    #[inline(always)]
    pub(super) fn any(&self) -> bool {
        self.set.is_some()
    }

    /// Components that are still to be moved.
    pub(super) fn left(&self) -> &[usize] {
        &self.left.0
    }

    /// Moves all that can go in rows, and tells how many, and in how many corrections; what is left is to be moved one
    /// by one.
    #[allow(clippy::too_many_arguments, reason = "what a step knows when it departs")]
    pub(super) fn drift<Fo: Force<f64, D>, W: Witness<f64>, const D: usize>(
        &mut self,
        shape: &Shape<D>,
        [h, kick]: [f64; 2],
        weights: [f64; 2],
        moving: &mut Moving<'_, D>,
        (force, blocks): (&[Fo], &mut [[f64; D]]),
        solvers: &mut [Solver<D>],
        aims: &mut [Aim<f64>],
        witness: &mut W,
    ) -> [u64; 2] {
        let mut counts = [0; 2];
        let Some(set) = self.set else { return counts };
        self.take(set, shape, solvers, moving.q);
        self.solvers_hold = false;
        let Self { rows, lanes, by_itself, left: List(left), .. } = self;
        let Some(lanes) = lanes else { return counts };
        left.clear();
        left.extend(&shape.alone);
        for (alike, number, kept) in each_row(shape, rows) {
            let [components, bodies] = alike.row(number);
            if components.iter().all(|&c| by_itself[c]) {
                left.extend(components);
                continue;
            }
            let (m, n) = (alike.sizes.0, alike.sizes.1 / D);
            put(bodies, n, moving.q, &mut lanes.q);
            put(bodies, n, moving.q_low, &mut lanes.q_low);
            put(bodies, n, moving.p, &mut lanes.p);
            put(bodies, n, moving.p_low, &mut lanes.p_low);
            put_forces(bodies, n, force, &mut lanes.force);
            let mut row = RowUnderWay { sizes: alike.sizes, links: &alike.links, set, kept, lanes };
            row.find(h, kick);
            for (lane, &c) in components.iter().enumerate() {
                let (own, mut plain) =
                    (alike.first[number + lane].0, row.lanes.plain[lane] != 0 && !by_itself[c]);
                for (i, aim) in aims[own..own + m].iter().enumerate() {
                    let (off, roundings) = (row.lanes.off[i].0[lane].0, row.lanes.roundings[i].0[lane].0);
                    plain &= aim.is_usual(off, weights) | (roundings <= ROUNDINGS);
                }
                row.lanes.plain[lane] = u64::from(plain);
                if plain {
                    for (i, aim) in aims[own..own + m].iter_mut().enumerate() {
                        aim.note(row.lanes.off[i].0[lane].0);
                    }
                    counts = [counts[0] + 1, counts[1] + row.lanes.corrections[lane]];
                } else {
                    left.push(c);
                }
            }
            row.move_on(h, kick);
            take_out(bodies, n, &row.lanes.q, moving.q);
            take_out(bodies, n, &row.lanes.q_low, moving.q_low);
            take_out(bodies, n, &row.lanes.p, moving.p);
            take_out(bodies, n, &row.lanes.p_low, moving.p_low);
            for (lane, &c) in components.iter().enumerate() {
                let (plain, clear) = (row.lanes.plain[lane] != 0, row.lanes.clear[lane] != 0);
                if !(plain & clear) && !by_itself[c] {
                    write_normals(row.kept, lane, &mut blocks[alike.first[number + lane].1..]);
                    normals(shape, c, solvers, blocks);
                    by_itself[c] = plain && solvers[c].dense().is_none();
                }
                for i in (0..m).filter(|_| W::LISTENS && plain) {
                    let multiplier = row.lanes.x[i].0[lane].0 / (h * (0.5 * h));
                    witness.position_multiplier(shape.components[c].rows.equation(i), multiplier);
                }
            }
        }
        counts
    }

    /// Takes over the normals of components that were moved one by one.
    pub(super) fn take_back<const D: usize>(
        &mut self,
        shape: &Shape<D>,
        solvers: &mut [Solver<D>],
        q: &[[f64; D]],
    ) {
        let Self { set: Some(set), rows, lanes: Some(lanes), by_itself, places, left: List(left), .. } = self
        else {
            return;
        };
        let mut left = left.iter().skip(shape.alone.len()).peekable();
        for (row, (alike, number, kept)) in each_row(shape, rows).enumerate() {
            let mut any = false;
            // In the order of rows.
            while let Some(&c) = left.next_if(|&&c| places[c].is_some_and(|[own, _]| own == row)) {
                by_itself[c] = solvers[c].dense().is_none();
                any |= !by_itself[c];
            }
            if any {
                evaluate(*set, alike, number, q, kept, lanes);
            }
        }
    }

    /// Kicks momenta, and makes them tangent, of all that go in rows; what is left is to be done one by one. Returns
    /// the sum of their squares.
    pub(super) fn settle<Fo: Force<f64, D>, W: Witness<f64>, const D: usize>(
        &mut self,
        shape: &Shape<D>,
        [h, kick]: [f64; 2],
        [p, p_low]: [&mut [[f64; D]]; 2],
        force: &[Fo],
        (solvers, q): (&mut [Solver<D>], &[[f64; D]]),
        witness: &mut W,
    ) -> f64 {
        let Some(set) = self.set else { return 0.0 };
        self.take(set, shape, solvers, q);
        let Self { rows, lanes: Some(lanes), by_itself, left: List(left), .. } = self else { return 0.0 };
        left.clear();
        left.extend(&shape.alone);
        // Also of places: bodies may be free where no constraint would miss them.
        let mut size = square(q.as_flattened());
        for (alike, number, kept) in each_row(shape, rows) {
            let [components, bodies] = alike.row(number);
            if components.iter().all(|&c| by_itself[c]) {
                left.extend(components);
                continue;
            }
            let n = alike.sizes.1 / D;
            for (lane, &c) in components.iter().enumerate() {
                lanes.plain[lane] = u64::from(!by_itself[c]);
            }
            put(bodies, n, p, &mut lanes.p);
            put(bodies, n, p_low, &mut lanes.p_low);
            put_forces(bodies, n, force, &mut lanes.force);
            RowUnderWay { sizes: alike.sizes, links: &alike.links, set, kept, lanes }.settle(kick);
            take_out(bodies, n, &lanes.p, p);
            take_out(bodies, n, &lanes.p_low, p_low);
            for (lane, &c) in components.iter().enumerate() {
                if by_itself[c] {
                    left.push(c);
                } else if W::LISTENS {
                    for i in 0..alike.sizes.0 {
                        let multiplier = lanes.x[i].0[lane].0 / (0.5 * h);
                        witness.momentum_multiplier(shape.components[c].rows.equation(i), multiplier);
                    }
                }
            }
            size += lanes.path.0[..components.len()].iter().map(|square| square.0).sum::<f64>();
        }
        size
    }
}

/// All rows, each with the number of its first component among those that are alike.
fn each_row<'a, const D: usize>(
    shape: &'a Shape<D>,
    rows: &'a mut [KeptRow],
) -> impl Iterator<Item = (&'a Alike, usize, &'a mut KeptRow)> {
    let kinds = shape.alike.iter().flat_map(|alike| (0..alike.rows()).map(move |row| (alike, row * ROW)));
    kinds.zip(rows).map(|((alike, number), row)| (alike, number, row))
}

/// Has a solver hold normals.
#[cold]
#[inline(never)]
fn normals<const D: usize>(shape: &Shape<D>, c: usize, solvers: &mut [Solver<D>], blocks: &[[f64; D]]) {
    let component = &shape.components[c];
    let (rows, first) = (&component.rows, component.first.1);
    solvers[c].normals(rows, &blocks[first..first + rows.blocks()], &shape.roots);
}

/// The sum of the squares.
fn square(numbers: &[f64]) -> f64 {
    let (chunks, rest) = numbers.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for chunk in chunks {
        for i in 0..8 {
            sums[i] += chunk[i] * chunk[i];
        }
    }
    sums.iter().sum::<f64>() + rest.iter().map(|x| x * x).sum::<f64>()
}

/// Writes the normals of a component in blocks, which begin here.
fn write_normals<const D: usize>(row: &KeptRow, lane: usize, blocks: &mut [[f64; D]]) {
    for (entry, normal) in blocks.as_flattened_mut().iter_mut().zip(&row.normals) {
        *entry = normal.0[lane].0;
    }
}

/// Evaluates the normals of a row.
fn evaluate<const D: usize>(
    set: Fusing,
    alike: &Alike,
    number: usize,
    q: &[[f64; D]],
    kept: &mut KeptRow,
    lanes: &mut Lanes,
) {
    put(alike.row(number)[1], alike.sizes.1 / D, q, &mut lanes.q);
    RowUnderWay { sizes: alike.sizes, links: &alike.links, set, kept, lanes }.evaluate();
}

/// Puts vectors of bodies into lanes, n of them for each; lanes beyond have those of the last.
fn put<const D: usize>(bodies: &[usize], n: usize, of: &[[f64; D]], to: &mut Coordinates) {
    put_each(bodies, n, |body| of[body], to);
}

/// The same of forces, where there are any.
fn put_forces<Fo: Force<f64, D>, const D: usize>(
    bodies: &[usize],
    n: usize,
    of: &[Fo],
    to: &mut Coordinates,
) {
    if Fo::ACTS {
        put_each(bodies, n, |body| of[body].components(), to);
    }
}

/// See [`put`]. (There are no more lanes than in a row, which `lane % ROW` tells the compiler.)
#[inline(always)]
fn put_each<const D: usize>(
    bodies: &[usize],
    n: usize,
    of: impl Fn(usize) -> [f64; D],
    to: &mut Coordinates,
) {
    for (lane, bodies) in bodies.chunks_exact(n).enumerate() {
        for (rows, &body) in to.as_chunks_mut::<D>().0.iter_mut().zip(bodies) {
            let vector = of(body);
            for d in 0..D {
                rows[d].0[lane % ROW] = Fused(vector[d]);
            }
        }
    }
    let lanes = bodies.len() / n;
    for row in to.iter_mut().take(n * D).filter(|_| lanes < ROW) {
        let last = row.0[lanes - 1];
        row.0[lanes..].fill(last);
    }
}

/// Writes vectors of bodies.
fn take_out<const D: usize>(bodies: &[usize], n: usize, from: &Coordinates, to: &mut [[f64; D]]) {
    for (lane, bodies) in bodies.chunks_exact(n).enumerate() {
        for (rows, &body) in from.as_chunks::<D>().0.iter().zip(bodies) {
            for d in 0..D {
                to[body][d] = rows[d].0[lane % ROW].0;
            }
        }
    }
}
