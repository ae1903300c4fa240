//! A network of bodies, and the quantities kept from step to step.

use crate::effect::force::Force;
use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::motion::bodies::{Bodies, Count};
use crate::number::vector::{dot, larger, sum};
use crate::solve::aim::{Aim, Pace};
use crate::solve::crowd::Asked;
use crate::solve::root::Course;
use crate::solve::stop::Terms;
use crate::systems::linked::in_rows::InRows;
use crate::systems::linked::room::{SeriesRoom, Stages};
use crate::systems::network::mass::Root;
use crate::systems::network::rows::Rows;
use crate::systems::network::shape::{Component, Shape};
use crate::systems::network::solver::{Report, Solver};
use std::array::from_fn;
use std::fmt;
use std::sync::Arc;

/// Corrections that Broyden's method keeps; one that needs more of them is given up.
pub(super) const LEARNED: usize = 6;

/// The system of a [network](crate::systems::network) of constraints on bodies, with forces.
#[derive(Debug, Clone)]
pub struct Linked<F, N, const D: usize> {
    pub(crate) shape: Arc<Shape<D>>,
    pub(crate) effects: F,
    pub(super) count: N,
}

/// Quantities kept at the positions, and working memory.
#[derive(Clone)]
pub struct Kept<F: Forces<f64, D>, const D: usize> {
    pub(super) tied: Tied<F::Force, D>,
    /// Room of the effects.
    pub(super) of_effects: F::Room,
    /// Room for a method with inner stages.
    pub(super) stages: Option<Box<Stages<F, D>>>,
    /// Room for power series.
    pub(super) series: Option<Box<SeriesRoom<D>>>,
}

/// What steps need, whatever the effects are.
#[derive(Clone)]
pub(crate) struct Tied<Fo, const D: usize> {
    /// At the positions.
    pub(super) force: Vec<Fo>,
    /// ∂g/∂q in blocks, and ∂g/∂t, at the positions.
    pub(super) blocks: Vec<[f64; D]>,
    pub(super) rates: Vec<f64>,
    pub(super) solvers: Vec<Solver<D>>,
    /// Corrections and evaluations of g, since the start.
    pub(super) counts: Counts,
    /// What guesses were off by in the last steps, by row of all components.
    pub(super) aims: Vec<Aim<f64>>,
    pub(super) pace: Pace,
    pub(super) asked: Asked,
    pub(super) in_rows: InRows,
    pub(super) room: Room<D>,
}

/// The cost of the position equations since the start of a simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Solves: one for each component and step, or stage of a step.
    pub solves: u64,
    /// Newton corrections.
    pub corrections: u64,
    /// Evaluations of g, alone or with its gradient.
    pub values: u64,
    /// Evaluations of the gradient.
    pub gradients: u64,
    /// Solves in which the root was followed in parts of the step.
    pub followed: u64,
}

impl Counts {
    /// Counts what was done in rows: in each correction, and at the end, values come with gradients.
    pub(super) fn take_rows(&mut self, solves: u64, corrections: u64) {
        self.solves += solves;
        self.corrections += corrections;
        self.values += corrections + solves;
        self.gradients += corrections + solves;
    }
}

#[derive(Debug, Clone)]
pub(crate) struct Room<const D: usize> {
    pub(super) velocity: Vec<[f64; D]>,
    /// h v, and h·kick·M⁻¹f.
    pub(super) drift: Vec<[f64; D]>,
    pub(super) push: Vec<[f64; D]>,
    /// The increment under way.
    pub(super) lift: Vec<[f64; D]>,
    /// Forces at the end of a step, those of constraints too.
    pub(super) forces: Vec<[f64; D]>,
    /// Positions that g is tried at.
    pub(super) trial: Vec<[f64; D]>,
    pub(super) blocks: Vec<[f64; D]>,
    /// The gradients before a new derivative.
    pub(super) before: Vec<[f64; D]>,
    pub(super) rates: Vec<f64>,
    pub(super) g: Vec<f64>,
    /// x of every component.
    pub(super) x: Vec<f64>,
    pub(super) guess: Vec<f64>,
    /// x of the component under way.
    pub(super) y: Vec<f64>,
    /// How x goes on while its root is followed.
    pub(super) course: Vec<Course<f64>>,
    pub(super) dx: Vec<f64>,
    /// The sign of the determinant of G M⁻¹ times what multipliers act along where the step starts, if they act on
    /// chosen coordinates.
    pub(super) orientation: f64,
    /// |∇gᵢ|, and 1/|∇gᵢ| over the rounding of the coordinates that equation i depends on.
    pub(super) lengths: Vec<f64>,
    pub(super) scale: Vec<f64>,
    /// The corrections of a solve by Broyden's method, one after another.
    pub(super) learned: Vec<f64>,
    /// gᵢ/|∇gᵢ| at the guess of a solve.
    pub(super) off: Vec<f64>,
    /// `y` and `off` of attempts that are set aside.
    pub(super) tried: [[Vec<f64>; 2]; 2],
    /// x inside the step.
    pub(super) inner: Vec<f64>,
    /// The rounding of each g, as a length.
    pub(super) noise: Vec<f64>,
    /// Which rows' guess was not off as usual, and which look wrong.
    pub(super) suspect: Vec<bool>,
    pub(super) wrong: Vec<bool>,
}

/// The largest residuals of a component; NaN if one is.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Furthest {
    /// As a length, and of which row.
    pub(crate) distance: f64,
    pub(crate) row: usize,
    /// That in roundings of all coordinates of the component: they reach an equation whose own coordinates are zero.
    pub(crate) of_all: f64,
    /// The largest in roundings of the coordinates that an equation depends on, which may be another's.
    pub(crate) roundings: f64,
}

pub(crate) type BodiesOf<F, N, const D: usize> = Bodies<N, f64, Kept<F, D>, D>;

impl<F, N, const D: usize> Linked<F, N, D> {
    pub(crate) fn new(shape: Shape<D>, effects: F, count: N) -> Self {
        Self { shape: Arc::new(shape), effects, count }
    }

    /// The components (groups of coupled equations), and how the multipliers of each are found.
    pub fn components(&self) -> impl ExactSizeIterator<Item = Report> + '_ {
        self.shape.components.iter().map(|component| Report::of(&component.rows, &component.solver))
    }

    pub(crate) fn component(&self, c: usize) -> &Rows {
        &self.shape.components[c].rows
    }
}

impl<F: Forces<f64, D>, N: Count, const D: usize> Linked<F, N, D> {
    /// Forces at this moment; none on what is pinned.
    pub(crate) fn forces(&self, at: Moment<'_, f64, D>, room: &mut F::Room, forces: &mut [F::Force]) {
        self.effects.evaluate(at, room, forces);
        for &(body, _) in &self.shape.pins {
            forces[body] = F::Force::zero();
        }
    }

    pub(crate) fn velocities(&self, bodies: &BodiesOf<F, N, D>) -> Vec<[f64; D]> {
        bodies.p.as_ref().iter().zip(&self.shape.roots).map(|(p, root)| root.velocity(p)).collect()
    }

    /// Has `write` fill in the rows of each component, and puts them in the order in which equations were named.
    pub(crate) fn for_rows(&self, out: &mut [f64], write: impl Fn(usize, &mut [f64])) {
        for (c, component) in self.shape.components.iter().enumerate() {
            let mut numbers = vec![0.0; component.rows.equations()];
            write(c, &mut numbers);
            for (row, number) in numbers.into_iter().enumerate() {
                out[component.rows.equation(row)] = number;
            }
        }
    }

    /// The largest residual of a component, just evaluated with its gradients. Sizes are those of the coordinates, or
    /// of their way in the time h, also of that which forces alone would add.
    pub(crate) fn furthest(&self, c: usize, h: f64, bodies: &BodiesOf<F, N, D>) -> Furthest {
        let component = &self.shape.components[c];
        let (rows, (_, block)) = (&component.rows, component.first);
        let blocks = &bodies.kept.tied.blocks[block..block + rows.blocks()];
        let Tied { room, force, .. } = &bodies.kept.tied;
        let (mut furthest, mut size_of_all) = (Furthest::default(), 0.0_f64);
        for row in 0..rows.equations() {
            let terms = Terms::of(rows.touched_by(row).map(|(block, body)| {
                let (q, v) = (&bodies.q.as_ref()[body], &room.velocity[body]);
                let pushed = self.shape.pushed(body, h, &force[body].components());
                (&blocks[block], *q, from_fn(|i| larger((h * v[i]).abs(), pushed[i].abs())))
            }));
            let (g, length) = (room.g[row].abs(), terms.length());
            let (distance, size) = (if g == 0.0 { 0.0 } else { g / length }, terms.size(length));
            let roundings = if g == 0.0 { 0.0 } else { g / (f64::EPSILON * size) };
            size_of_all = size_of_all.max(size / length);
            if roundings > furthest.roundings || roundings.is_nan() {
                furthest.roundings = roundings;
            }
            if distance > furthest.distance || distance.is_nan() {
                (furthest.distance, furthest.row) = (distance, row);
            }
        }
        let off = furthest.distance;
        furthest.of_all = if off == 0.0 { 0.0 } else { off / (f64::EPSILON * size_of_all) };
        furthest
    }

    pub(crate) fn counts(&self, bodies: &BodiesOf<F, N, D>) -> Counts {
        bodies.kept.tied.counts
    }
}

impl<F: Forces<f64, D>, const D: usize> Kept<F, D> {
    /// How far other sheets were looked for, and whether there were some.
    pub(crate) fn asked(&mut self) -> &mut Asked {
        &mut self.tied.asked
    }
}

impl<F: Forces<f64, D>, const D: usize> fmt::Debug for Kept<F, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut debug = f.debug_struct("Kept");
        debug.field("force", &self.tied.force).field("blocks", &self.tied.blocks).finish_non_exhaustive()
    }
}

impl<Fo: Force<f64, D>, const D: usize> Tied<Fo, D> {
    /// For so many bodies; nothing is evaluated yet.
    #[inline(never)]
    pub(super) fn new(shape: &Shape<D>, n: usize) -> Self {
        Self {
            force: vec![Fo::zero(); n],
            blocks: vec![[0.0; D]; shape.blocks],
            rates: vec![0.0; shape.equations],
            solvers: shape.components.iter().map(|component| component.solver.clone()).collect(),
            counts: Counts::default(),
            aims: vec![Aim::unknown(); shape.equations],
            pace: Pace::unknown(),
            asked: Asked::default(),
            in_rows: InRows::new(shape),
            room: Room::new(shape, n),
        }
    }

    /// Has all solvers and blocks hold the normals of these positions, also of what goes in rows.
    pub(super) fn lend_normals(&mut self, shape: &Shape<D>, time: f64, q: &[[f64; D]]) {
        if self.in_rows.solvers_hold() {
            return;
        }
        for c in 0..shape.components.len() {
            if self.in_rows.alone_holds(c) {
                self.normals(shape, c, time, q);
            }
        }
        self.in_rows.have_lent();
    }

    /// The same, before positions change in another way than in rows.
    pub(super) fn leave_rows(&mut self, shape: &Shape<D>, time: f64, q: &[[f64; D]]) {
        self.lend_normals(shape, time, q);
        self.in_rows.leave_all();
    }

    /// The normals of a component at these positions, in blocks.
    pub(super) fn blocks_of(&self, shape: &Shape<D>, c: usize, time: f64, q: &[[f64; D]]) -> Vec<[f64; D]> {
        let Component { rows, first, .. } = &shape.components[c];
        let mut blocks = self.blocks[first.1..first.1 + rows.blocks()].to_vec();
        if self.in_rows.alone_holds(c) {
            let (mut g, mut rates) = (vec![0.0; rows.equations()], vec![0.0; rows.equations()]);
            shape.gradients(c, time, q, &mut g, &mut blocks, &mut rates);
        }
        blocks
    }

    /// Evaluates gradients at q and takes the normals over. Returns the sine of the least independent one, and its row.
    #[inline(never)]
    pub(crate) fn normals(&mut self, shape: &Shape<D>, c: usize, time: f64, q: &[[f64; D]]) -> (f64, usize) {
        self.take(shape, c, (time, q), Solver::normals)
    }

    /// The same at a stage, which may be far off the constraints: those equations count that did at the place before.
    #[inline(never)]
    pub(super) fn normals_off(
        &mut self,
        shape: &Shape<D>,
        c: usize,
        time: f64,
        q: &[[f64; D]],
    ) -> (f64, usize) {
        self.take(shape, c, (time, q), Solver::normals_off)
    }

    #[inline(always)]
    fn take(
        &mut self,
        shape: &Shape<D>,
        c: usize,
        (time, q): (f64, &[[f64; D]]),
        normals: impl Fn(&mut Solver<D>, &Rows, &[[f64; D]], &[Root<D>]) -> (f64, usize),
    ) -> (f64, usize) {
        let component = &shape.components[c];
        let (rows, (row, block)) = (&component.rows, component.first);
        let blocks = &mut self.blocks[block..block + rows.blocks()];
        let rates = &mut self.rates[row..row + rows.equations()];
        shape.gradients(c, time, q, &mut self.room.g, blocks, rates);
        if !rows.acting {
            return normals(&mut self.solvers[c], rows, blocks, &shape.roots);
        }
        let acting = &mut self.room.blocks[..rows.blocks()];
        acting.copy_from_slice(blocks);
        shape.mask(c, acting);
        normals(&mut self.solvers[c], rows, acting, &shape.roots)
    }
}

impl<const D: usize> Room<D> {
    fn new(shape: &Shape<D>, n: usize) -> Self {
        let (rows, blocks) = shape.widest;
        Self {
            velocity: vec![[0.0; D]; n],
            drift: vec![[0.0; D]; n],
            push: vec![[0.0; D]; n],
            lift: vec![[0.0; D]; n],
            forces: vec![[0.0; D]; n],
            trial: vec![[0.0; D]; n],
            blocks: vec![[0.0; D]; blocks],
            before: vec![[0.0; D]; blocks],
            rates: vec![0.0; rows],
            g: vec![0.0; rows],
            x: vec![0.0; shape.equations],
            guess: vec![0.0; rows],
            y: vec![0.0; rows],
            course: vec![Course::start(); rows],
            dx: vec![0.0; rows],
            orientation: f64::NAN,
            lengths: vec![0.0; rows],
            scale: vec![0.0; rows],
            learned: vec![0.0; LEARNED * rows],
            off: vec![0.0; rows],
            tried: [0, 1].map(|_| [vec![0.0; rows], vec![0.0; rows]]),
            inner: vec![0.0; rows],
            noise: vec![0.0; rows],
            wrong: vec![false; rows],
            suspect: vec![false; rows],
        }
    }

    /// Notes how a body sets out: its velocity, and its way without the constraints.
    #[inline(always)]
    pub(super) fn set_out(
        &mut self,
        body: usize,
        [h, kick]: [f64; 2],
        root: &Root<D>,
        [p, p_low]: [&[f64; D]; 2],
        force: &impl Force<f64, D>,
    ) {
        let (v, v_low) = (root.velocity(p), root.velocity(p_low));
        self.velocity[body] = v;
        self.drift[body] = from_fn(|i| h * v[i] + h * v_low[i]);
        self.push[body] = root.velocity(&force.add_to([0.0; D], h * kick));
    }
}

/// ∇gᵢ·v.
#[inline]
pub(crate) fn along<const D: usize>(rows: &Rows, row: usize, blocks: &[[f64; D]], v: &[[f64; D]]) -> f64 {
    let mut sum = 0.0;
    for (block, body) in rows.blocks_of(row) {
        sum += dot(&blocks[block], &v[rows.bodies[body]]);
    }
    sum
}

/// Writes by how much ∇gᵢ·v falls short of −∂g/∂t. With `SMALL`, whether that is no more than comes from forming it.
/// Bodies that are pinned have no velocity; `A` is how many blocks each equation has, or 0.
#[inline(always)]
pub(crate) fn fall_short<const SMALL: bool, const A: usize, const D: usize>(
    rows: &Rows,
    blocks: &[[f64; D]],
    rates: &[f64],
    v: &[[f64; D]],
    needed: &mut [f64],
) -> bool {
    let mut small = true;
    for (row, (needed, rate)) in needed.iter_mut().zip(rates).enumerate() {
        let range = rows.range::<A>(row);
        let (mut sums, mut sizes) = ([0.0; D], [0.0; D]);
        for (block, &body) in blocks[range.clone()].iter().zip(&rows.touched()[range]) {
            let products: [f64; D] = from_fn(|i| block[i] * v[body][i]);
            sums = sum(&sums, &products);
            if SMALL {
                sizes = from_fn(|i| sizes[i] + products[i].abs());
            }
        }
        *needed = -sums.iter().sum::<f64>() - rate;
        if SMALL {
            small &= needed.abs() <= 2.0 * f64::EPSILON * (sizes.iter().sum::<f64>() + rate.abs());
        }
    }
    SMALL && small
}
