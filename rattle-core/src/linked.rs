//! Bodies tied together by a [network](crate::network): RATTLE's verbs for any number of constraints and any masses.
//!
//! Each component is solved by itself. With W = M⁻¹G(q)ᵀ, or an orthonormal basis of its columns, the position equation is
//!
//! ```text
//! r(x) = g(q + free + W x) = 0
//! ```
//!
//! and is solved by Newton's method with the derivative G(q′)W of the first guess, taken anew where that contracts less
//! than fourfold. The first guess is the one with g̈ = 0, so that a step is a pure function of the state.
//!
//! **Stopping.** Residuals are measured as lengths, |gᵢ|/|∇gᵢ|, against the rounding ε·ℓ of the coordinates that
//! equation i touches; neither the scale of g nor the rest of a long chain matters. From two residuals the
//! contraction is known, and the solve ends without an evaluation once the next one would be below 1/16 of that rounding.
//! It also ends where a fresh derivative, equal to the one before, does not make residuals smaller: then they are the
//! rounding of g itself.
//!
//! **Which root.** As on surfaces: if the guess was off by a small part of the path (or the normals do not change), pivots
//! stayed positive and the normals turn by less than a half within the step, the root is the one that the motion leads to. Otherwise it is
//! followed from h = 0 in parts of the step that are halved until that holds.

mod chords;
mod collocation;
mod series;

use crate::bodies::{Bodies, Body, Count};
use crate::effect::{Field, Force};
use crate::error::{EquationAt, Passing, StepFailure};
use crate::iteration::{Iteration, Kind};
use crate::lobatto::Table;
use crate::network::{Report, Root, Rows, Shape, Solver};
use crate::series::NO_SERIES;
use crate::stepper::{Failure, Need, Witness};
use crate::system::System;
use crate::vector::{add_scaled, dot, largest, sum, two_sum};
use collocation::Stages;
use std::sync::Arc;

/// A first correction longer than this part of the path asks for following, as on surfaces; while it is followed, …
const FAR_GUESS: f64 = 0.02;
/// … than this part.
const FAR_EXTRAPOLATION: f64 = 0.1;
/// Normals that change by more than this part of their length within the step ask for following.
const LARGE_TURN: f64 = 0.5;
/// A smaller relative change of the normals is none.
const STRAIGHT: f64 = 1e-7;
/// Residuals that shrink by less ask for a new derivative.
const CONTRACTION: f64 = 0.25;
/// Corrections that Broyden's method keeps; one that needs more of them is given up.
const LEARNED: usize = 6;
/// Corrections after which a solve is given up.
const MAX_CORRECTIONS: usize = 40;
/// The smallest part of a step in which a root is followed, and how many parts are tried.
const SMALLEST_PART: f64 = 1.0 / 4096.0;
const MAX_PARTS: usize = 200;
/// Halvings of a failed step that are tried, to say which would pass.
const HALVINGS: i32 = 24;
/// Steps in which normals change by less are short enough to be accurate: where one fails, the reason is another.
const SHORT: f64 = 0.2;
/// A normal with a smaller sine to the others is lost; see `orthogonal.rs` for the other case.
pub(crate) const LOST: f64 = 1e-7;
/// Where only a step shorter by `MUCH_SHORTER` would pass, a normal with this sine to the others is what stopped it: where
/// a mechanism branches, places are known to √ε.
const BRANCHING: f64 = 1e-6;
const MUCH_SHORTER: f64 = 1e-3;
/// A multiplier that acts along less than this part of ∇g is what stopped a step.
const LITTLE_SHARE: f64 = 0.25;

/// A network of constraints on bodies in a field of force.
#[derive(Debug, Clone)]
pub struct Linked<F, N, const D: usize> {
    shape: Arc<Shape<D>>,
    field: F,
    count: N,
}

/// What is kept at the positions, and room to work in.
#[derive(Debug, Clone)]
pub struct Kept<F, const D: usize> {
    force: Vec<F>,
    /// ∂g/∂q in blocks, and ∂g/∂t, at the positions.
    blocks: Vec<[f64; D]>,
    rates: Vec<f64>,
    solvers: Vec<Solver<D>>,
    /// Corrections and evaluations of g, since the start.
    counts: Counts,
    room: Room<D>,
    /// Room for a method with inner stages.
    stages: Option<Box<Stages<F, D>>>,
    /// Room for power series.
    series: Option<Box<series::Room<D>>>,
}

/// What the position equations have cost since the start of a simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Solves: one per component and step, or stage of a step.
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

#[derive(Debug, Clone)]
struct Room<const D: usize> {
    velocity: Vec<[f64; D]>,
    /// h v, and h·kick·M⁻¹f.
    drift: Vec<[f64; D]>,
    push: Vec<[f64; D]>,
    /// W x, then the whole increment.
    lift: Vec<[f64; D]>,
    /// Positions that g is tried at.
    trial: Vec<[f64; D]>,
    blocks: Vec<[f64; D]>,
    /// The gradients before a new derivative.
    before: Vec<[f64; D]>,
    rates: Vec<f64>,
    g: Vec<f64>,
    /// x of every component.
    x: Vec<f64>,
    guess: Vec<f64>,
    /// x of the component under way.
    y: Vec<f64>,
    excess: Vec<f64>,
    slope: Vec<f64>,
    dx: Vec<f64>,
    /// |∇gᵢ|, and 1/|∇gᵢ| over the rounding of the coordinates that equation i depends on.
    lengths: Vec<f64>,
    scale: Vec<f64>,
    /// The corrections of a solve by Broyden's method, one after another.
    learned: Vec<f64>,
}

type BodiesOf<F, N, const D: usize> = Bodies<N, f64, Kept<<F as Field<f64, D>>::Force, D>, D>;

/// One component on its way: everything that the position equation needs.
struct Flight<'a, const D: usize> {
    shape: &'a Shape<D>,
    component: usize,
    q: &'a [[f64; D]],
    q_low: &'a [[f64; D]],
    /// The gradients there.
    blocks: &'a [[f64; D]],
    time: f64,
    h: f64,
}

/// How a solve ended.
#[derive(Clone, Copy)]
struct Landing {
    converged: bool,
    /// Whether pivots stayed positive.
    upright: bool,
    /// The largest displacement by the first correction.
    first: f64,
    /// Whether dependent equations ask for different things.
    contradictory: bool,
}

impl<F, N, const D: usize> Linked<F, N, D> {
    pub(crate) fn new(shape: Shape<D>, field: F, count: N) -> Self {
        Self { shape: Arc::new(shape), field, count }
    }

    /// The components, and how the multipliers of each are found.
    pub fn components(&self) -> impl ExactSizeIterator<Item = Report> + '_ {
        self.shape.components.iter().map(|component| Report::of(&component.rows, &component.solver))
    }

    fn component(&self, c: usize) -> &Rows {
        &self.shape.components[c].rows
    }
}

impl<F: Field<f64, D>, N: Count, const D: usize> System<f64, D> for Linked<F, N, D> {
    type Count = N;
    type Kept = Kept<F::Force, D>;

    fn bodies(&self, place: impl Fn(usize) -> Body<f64, D>, time: f64) -> BodiesOf<F, N, D> {
        let (shape, n) = (&self.shape, self.count.number());
        let (rows, blocks) = shape.widest;
        let room = Room {
            velocity: vec![[0.0; D]; n],
            drift: vec![[0.0; D]; n],
            push: vec![[0.0; D]; n],
            lift: vec![[0.0; D]; n],
            trial: vec![[0.0; D]; n],
            blocks: vec![[0.0; D]; blocks],
            before: vec![[0.0; D]; blocks],
            rates: vec![0.0; rows],
            g: vec![0.0; rows],
            x: vec![0.0; shape.equations],
            guess: vec![0.0; rows],
            y: vec![0.0; rows],
            excess: vec![0.0; rows],
            slope: vec![0.0; rows],
            dx: vec![0.0; rows],
            lengths: vec![0.0; rows],
            scale: vec![0.0; rows],
            learned: vec![0.0; LEARNED * rows],
        };
        let kept = Kept {
            force: vec![F::Force::zero(); n],
            blocks: vec![[0.0; D]; shape.blocks],
            rates: vec![0.0; shape.equations],
            solvers: shape.components.iter().map(|component| component.solver.clone()).collect(),
            counts: Counts::default(),
            room,
            stages: None,
            series: None,
        };
        let mut bodies = Bodies::new(self.count, kept, place, time);
        self.refresh(&mut bodies);
        bodies
    }

    fn refresh(&self, bodies: &mut BodiesOf<F, N, D>) {
        for c in 0..self.shape.components.len() {
            let (q, time) = (bodies.q.as_ref(), bodies.time);
            bodies.kept.normals(&self.shape, c, time, q);
        }
        self.evaluate_forces(bodies);
    }

    fn refuses(&self, need: Need) -> Option<&'static str> {
        let acting = self.shape.components.iter().any(|component| component.rows.acting);
        match need {
            Need::Stages => acting.then_some("a network whose multipliers act on chosen coordinates"),
            Need::Differences => self.moves_with_time().then_some("a network whose links move"),
            Need::Series => self.series_blocks().is_none().then_some(NO_SERIES),
            Need::Verbs | Need::PositionEquation => None,
        }
    }

    fn moves_with_time(&self) -> bool {
        self.shape.components.iter().any(|component| component.rows.moving)
    }

    fn set_time(&self, bodies: &mut BodiesOf<F, N, D>, time: f64) {
        if bodies.time != time {
            bodies.time = time;
            for c in (0..self.shape.components.len()).filter(|&c| self.component(c).moving) {
                bodies.kept.normals(&self.shape, c, time, bodies.q.as_ref());
            }
        }
    }

    fn drift_by<X: Iteration, W: Witness<f64>>(
        &self,
        kick: f64,
        h: f64,
        guess: &[f64],
        bodies: &mut BodiesOf<F, N, D>,
        witness: &mut W,
    ) -> Result<(), Failure> {
        let shape = &*self.shape;
        let (q, q_low) = (bodies.q.as_mut(), bodies.q_low.as_mut());
        let (p, p_low) = (bodies.p.as_mut(), bodies.p_low.as_mut());
        let Kept { force, blocks, rates, solvers, counts, room, .. } = &mut bodies.kept;
        for (body, root) in shape.roots.iter().enumerate() {
            let v = root.velocity(&p[body]);
            let v_low = root.velocity(&p_low[body]);
            let f = root.velocity(&force[body].add_to([0.0; D], h * kick));
            room.velocity[body] = v;
            room.drift[body] = std::array::from_fn(|i| h * v[i] + h * v_low[i]);
            room.push[body] = f;
            room.trial[body] = q[body];
        }
        for (c, component) in shape.components.iter().enumerate() {
            let (rows, solver) = (&component.rows, &mut solvers[c]);
            let (first, m) = (component.first, rows.equations());
            let blocks = &blocks[first.1..first.1 + rows.blocks()];
            let flight = Flight { shape, component: c, q, q_low, blocks, time: bodies.time, h };
            counts.solves += 1;
            let by_default = X::KIND == Kind::Newton && guess.is_empty();
            if by_default || !flight.try_to_solve::<X>(guess, solver, room, counts) {
                let turn = flight.guess(solver, room);
                let solved = flight.solve(solver, turn, room, counts);
                if !solved.converged {
                    return Err(flight.failure(solver, turn, room, solved));
                }
            }
            room.x[first.0..first.0 + m].copy_from_slice(&room.y[..m]);
        }

        for body in 0..q.len() {
            room.lift[body] = sum(&room.drift[body], &room.push[body]);
            room.trial[body] = force[body].add_to(p_low[body], kick);
        }
        for (c, component) in shape.components.iter().enumerate() {
            let (rows, solver) = (&component.rows, &mut solvers[c]);
            let x = &room.x[component.first.0..component.first.0 + rows.equations()];
            solver.displace(rows, &shape.roots, x, &mut room.lift);
            solver.push(rows, &shape.roots, 1.0 / h, x, &mut room.trial);
            if W::LISTENS || rows.moving {
                solver.multipliers(x, &mut room.dx[..x.len()]);
                let rates = &rates[component.first.0..];
                for (row, displacement) in room.dx[..x.len()].iter().enumerate() {
                    bodies.work -= displacement / h * rates[row];
                    let multiplier = displacement / (h * (0.5 * h));
                    witness.position_multiplier(rows.equation(row), multiplier);
                }
            }
        }
        for body in 0..q.len() {
            (q[body], q_low[body]) = two_sum(&q[body], &sum(&q_low[body], &room.lift[body]));
            (p[body], p_low[body]) = two_sum(&p[body], &room.trial[body]);
        }
        bodies.time += h;
        for c in 0..shape.components.len() {
            let (q, time) = (bodies.q.as_ref(), bodies.time);
            let (sine, row) = bodies.kept.normals(shape, c, time, q);
            self.check_rank(c, bodies, sine, row)?;
        }
        Ok(())
    }

    fn evaluate_forces(&self, bodies: &mut BodiesOf<F, N, D>) {
        self.forces(bodies.q.as_ref(), &mut bodies.kept.force);
    }

    fn settle<W: Witness<f64>>(
        &self,
        kick: f64,
        h: f64,
        bodies: &mut BodiesOf<F, N, D>,
        witness: &mut W,
    ) -> Result<(), Failure> {
        let shape = &*self.shape;
        let (p, p_low) = (bodies.p.as_mut(), bodies.p_low.as_mut());
        let Kept { force, blocks, rates, solvers, room, .. } = &mut bodies.kept;
        let change = &mut room.trial;
        for body in 0..p.len() {
            change[body] = force[body].add_to(p_low[body], kick);
        }
        for (c, component) in shape.components.iter().enumerate() {
            let (rows, solver) = (&component.rows, &mut solvers[c]);
            let ((row, block), m) = (component.first, rows.equations());
            let (blocks, rates) = (&blocks[block..block + rows.blocks()], &rates[row..row + m]);
            let (needed, x, total) = (&mut room.g[..m], &mut room.dx[..m], &mut room.x[row..row + m]);
            total.fill(0.0);
            for round in 0..2 {
                for &body in &rows.bodies {
                    room.velocity[body] = shape.roots[body].velocity(&sum(&p[body], &change[body]));
                }
                // The second time takes what rounding left, if it left more than comes from forming the rates.
                let mut settled = round > 0;
                for (i, needed) in needed.iter_mut().enumerate() {
                    let (rate, size) = along_and_size(rows, i, blocks, &room.velocity);
                    *needed = -rate - rates[i];
                    settled &= needed.abs() <= 2.0 * f64::EPSILON * (size + rates[i].abs());
                }
                if settled {
                    break;
                }
                solver.respond(rows, blocks, &shape.roots, needed, x);
                solver.push(rows, &shape.roots, 1.0, x, change);
                total.iter_mut().zip(x.iter()).for_each(|(total, x)| *total += x);
            }
            if W::LISTENS || rows.moving {
                solver.multipliers(total, x);
                for (i, impulse) in x.iter().enumerate() {
                    bodies.work -= impulse * rates[i];
                    witness.momentum_multiplier(rows.equation(i), impulse / (0.5 * h));
                }
            }
        }
        for body in 0..p.len() {
            (p[body], p_low[body]) = two_sum(&p[body], &change[body]);
            if !dot(&p[body], &p[body]).is_finite() {
                return Err(self.not_finite(bodies, body));
            }
        }
        Ok(())
    }

    fn rates<W: Witness<f64>>(
        &self,
        bodies: &mut BodiesOf<F, N, D>,
        rates: &mut [[f64; D]],
        witness: &mut W,
    ) -> f64 {
        let shape = &*self.shape;
        let Kept { force, blocks, rates: moving, solvers, room, .. } = &mut bodies.kept;
        for (body, root) in shape.roots.iter().enumerate() {
            rates[body] = force[body].components();
            room.velocity[body] = root.velocity(&bodies.p.as_ref()[body]);
            room.push[body] = root.velocity(&rates[body]);
        }
        let mut power = 0.0;
        for (c, component) in shape.components.iter().enumerate() {
            let (rows, solver, (row, block)) = (&component.rows, &mut solvers[c], component.first);
            let m = rows.equations();
            let (blocks, x) = (&blocks[block..block + rows.blocks()], &mut room.x[row..row + m]);
            let (bends, turns) = (&mut room.g[..m], &mut room.dx);
            shape.bends(c, bodies.time, bodies.q.as_ref(), &room.velocity, bends, turns);
            for (i, bend) in bends.iter_mut().enumerate() {
                *bend = -*bend - along(rows, i, blocks, &room.push);
            }
            solver.respond(rows, blocks, &shape.roots, bends, x);
            solver.push(rows, &shape.roots, 1.0, x, rates);
            if W::LISTENS || rows.moving {
                solver.multipliers(x, &mut room.dx[..m]);
                for (i, lambda) in room.dx[..m].iter().enumerate() {
                    power -= lambda * moving[row + i];
                    witness.position_multiplier(rows.equation(i), *lambda);
                }
            }
        }
        power
    }

    fn project(&self, h: f64, bodies: &mut BodiesOf<F, N, D>) -> Result<(), Failure> {
        let shape = &*self.shape;
        for (body, root) in shape.roots.iter().enumerate() {
            bodies.kept.room.velocity[body] = root.velocity(&bodies.p.as_ref()[body]);
        }
        for (c, component) in shape.components.iter().enumerate() {
            let rows = &component.rows;
            let moves = rows.bodies.iter().map(|&body| largest(&bodies.kept.room.velocity[body]));
            let path = h.abs() * moves.fold(0.0, f64::max);
            let long = 64.0 * (rows.equations() as f64).sqrt(); // roundings of a chain add up along it
            let mut nearest = f64::INFINITY;
            loop {
                let (q, time) = (bodies.q.as_ref(), bodies.time);
                let (sine, row) = bodies.kept.normals(shape, c, time, q);
                // In roundings of the places alone: a velocity that has run away must not make up for the distance.
                let (distance, roundings, worst) = self.furthest(c, 0.0, bodies);
                let rounding = roundings <= long;
                // Newton's method near its root leaves less; from afar it goes half of the way each time. False for NaN.
                let nearer = distance < if rounding { 0.5 } else { 0.25 } * nearest;
                if roundings <= 1.0 || rounding && !nearer {
                    self.check_rank(c, bodies, sine, row)?;
                    break;
                }
                if !nearer {
                    let body = shape.equation_at(c, worst).bodies[0];
                    return Err(if distance.is_finite() {
                        Failure { body, cause: StepFailure::NotProjected { distance, path } }
                    } else {
                        let position = bodies.q.as_ref()[body].to_vec();
                        Failure { body, cause: StepFailure::ConstraintNotFinite { position } }
                    });
                }
                nearest = distance;
                let (m, (_, block)) = (rows.equations(), component.first);
                let Kept { blocks, solvers, room, .. } = &mut bodies.kept;
                let blocks = &blocks[block..block + rows.blocks()];
                room.g[..m].iter_mut().for_each(|g| *g = -*g);
                solvers[c].respond(rows, blocks, &shape.roots, &mut room.g[..m], &mut room.x[..m]);
                rows.bodies.iter().for_each(|&body| room.lift[body] = [0.0; D]);
                solvers[c].displace(rows, &shape.roots, &room.x[..m], &mut room.lift);
                let (q, q_low) = (bodies.q.as_mut(), bodies.q_low.as_mut());
                for &body in &rows.bodies {
                    (q[body], q_low[body]) = two_sum(&q[body], &sum(&q_low[body], &room.lift[body]));
                }
            }
        }
        self.evaluate_forces(bodies);
        Ok(())
    }

    fn reserve(&self, bodies: &mut BodiesOf<F, N, D>, stages: usize) {
        let (n, m, blocks) = (self.count.number(), self.shape.equations, self.shape.blocks);
        bodies.kept.stages = (stages > 0).then(|| Box::new(Stages::new(stages, n, m, blocks)));
    }

    fn collocate<W: Witness<f64>, const S: usize>(
        &self,
        table: &Table<S>,
        h: f64,
        bodies: &mut BodiesOf<F, N, D>,
        memory: &mut [f64],
        witness: &mut W,
    ) -> Result<(), Failure> {
        self.collocate(table, h, bodies, memory, witness)
    }

    fn reserve_series(&self, bodies: &mut BodiesOf<F, N, D>, orders: usize) {
        bodies.kept.series = self.room_for_series(orders);
    }

    fn expand<W: Witness<f64>>(
        &self,
        bodies: &mut BodiesOf<F, N, D>,
        series: &mut [[f64; D]],
        witness: &mut W,
    ) -> Result<(), Failure> {
        self.expand_motion(bodies, series, witness)
    }

    fn expanded_work(&self, bodies: &BodiesOf<F, N, D>, h: f64) -> f64 {
        let work = bodies.kept.series.iter().flat_map(|room| room.work.iter().rev());
        work.fold(0.0, |sum, coefficient| coefficient + h * sum)
    }

    fn equations(&self) -> usize {
        self.shape.equations
    }

    fn velocity(&self, bodies: &BodiesOf<F, N, D>, body: usize) -> [f64; D] {
        self.shape.roots[body].velocity(&bodies.p.as_ref()[body])
    }

    fn mass_product(&self, body: usize, a: &[f64; D], b: &[f64; D]) -> f64 {
        self.shape.roots[body].product(a, b)
    }

    fn accelerations(&self, bodies: &BodiesOf<F, N, D>, accelerations: &mut [[f64; D]]) {
        let mut forces = vec![F::Force::zero(); accelerations.len()];
        self.forces(bodies.q.as_ref(), &mut forces);
        let mut pulls = vec![[0.0; D]; bodies.q.as_ref().len()];
        self.constraint_forces(bodies, &mut pulls);
        for (body, a) in accelerations.iter_mut().enumerate() {
            *a = self.shape.roots[body].velocity(&forces[body].add_to(pulls[body], 1.0));
        }
    }

    fn constraint_forces(&self, bodies: &BodiesOf<F, N, D>, forces: &mut [[f64; D]]) {
        let mut multipliers = vec![0.0; self.shape.equations];
        self.multipliers(bodies, &mut multipliers);
        forces.fill([0.0; D]);
        for (c, component) in self.shape.components.iter().enumerate() {
            let rows = &component.rows;
            let mut blocks =
                bodies.kept.blocks[component.first.1..component.first.1 + rows.blocks()].to_vec();
            self.shape.mask(c, &mut blocks);
            for row in 0..rows.equations() {
                for (block, body) in rows.touched_by(row) {
                    let multiplier = multipliers[rows.equation(row)];
                    forces[body] = add_scaled(&forces[body], multiplier, &blocks[block]);
                }
            }
        }
    }

    fn kinetic_energy<X>(&self, bodies: &Bodies<N, f64, X, D>) -> f64 {
        let parts = bodies.p.as_ref().iter().zip(bodies.p_low.as_ref()).zip(&self.shape.roots);
        let energy = parts.map(|((p, low), root)| {
            let v = root.velocity(p);
            0.5 * dot(p, &v) + dot(low, &v)
        });
        energy.sum()
    }

    fn potential_energy<X>(&self, bodies: &Bodies<N, f64, X, D>) -> f64 {
        self.field.energy(bodies.q.as_ref())
    }

    fn residuals(&self, bodies: &BodiesOf<F, N, D>, g: &mut [f64]) {
        self.for_rows(g, |c, out| self.shape.values(c, bodies.time, bodies.q.as_ref(), out));
    }

    fn drift_rates(&self, bodies: &BodiesOf<F, N, D>, rates: &mut [f64]) {
        let velocity = self.velocities(bodies);
        self.for_rows(rates, |c, out| {
            let (rows, (row, block)) = (self.component(c), self.shape.components[c].first);
            let blocks = &bodies.kept.blocks[block..block + rows.blocks()];
            for (i, rate) in out.iter_mut().enumerate() {
                *rate = along(rows, i, blocks, &velocity) + bodies.kept.rates[row + i];
            }
        });
    }

    fn multipliers(&self, bodies: &BodiesOf<F, N, D>, multipliers: &mut [f64]) {
        let velocity = self.velocities(bodies);
        let mut forces = vec![F::Force::zero(); velocity.len()];
        self.forces(bodies.q.as_ref(), &mut forces);
        let pulls: Vec<_> =
            forces.iter().zip(&self.shape.roots).map(|(f, root)| root.velocity(&f.components())).collect();
        self.for_rows(multipliers, |c, out| {
            let (rows, (_, block)) = (self.component(c), self.shape.components[c].first);
            let blocks = &bodies.kept.blocks[block..block + rows.blocks()];
            let (mut bends, mut turns) = (vec![0.0; out.len()], vec![0.0; out.len()]);
            self.shape.bends(c, bodies.time, bodies.q.as_ref(), &velocity, &mut bends, &mut turns);
            for (i, bend) in bends.iter_mut().enumerate() {
                *bend = -*bend - along(rows, i, blocks, &pulls);
            }
            let mut solver = bodies.kept.solvers[c].clone();
            let mut x = vec![0.0; out.len()];
            solver.respond(rows, blocks, &self.shape.roots, &mut bends, &mut x);
            solver.multipliers(&x, out);
        });
    }
}

impl<F: Field<f64, D>, N: Count, const D: usize> Linked<F, N, D> {
    /// Forces at these positions; none on what is pinned.
    fn forces(&self, q: &[[f64; D]], forces: &mut [F::Force]) {
        self.field.evaluate(q, forces);
        for &(body, _) in &self.shape.pins {
            forces[body] = F::Force::zero();
        }
    }

    fn velocities(&self, bodies: &BodiesOf<F, N, D>) -> Vec<[f64; D]> {
        bodies.p.as_ref().iter().zip(&self.shape.roots).map(|(p, root)| root.velocity(p)).collect()
    }

    /// Has `write` fill in the rows of each component, and puts them in the order in which equations were named.
    fn for_rows(&self, out: &mut [f64], write: impl Fn(usize, &mut [f64])) {
        for (c, component) in self.shape.components.iter().enumerate() {
            let mut numbers = vec![0.0; component.rows.equations()];
            write(c, &mut numbers);
            for (row, number) in numbers.into_iter().enumerate() {
                out[component.rows.equation(row)] = number;
            }
        }
    }

    /// The largest residual of a component, just evaluated with its gradients: as a length, in roundings of the coordinates
    /// it depends on or of their way in the time h, and its row. NaN if one is.
    fn furthest(&self, c: usize, h: f64, bodies: &BodiesOf<F, N, D>) -> (f64, f64, usize) {
        let component = &self.shape.components[c];
        let (rows, (_, block)) = (&component.rows, component.first);
        let blocks = &bodies.kept.blocks[block..block + rows.blocks()];
        let room = &bodies.kept.room;
        let mut furthest = (0.0, 0.0, 0);
        for row in 0..rows.equations() {
            let (mut square, mut size) = (0.0, 0.0_f64);
            for (block, body) in rows.touched_by(row) {
                square += dot(&blocks[block], &blocks[block]);
                size = size.max(largest(&bodies.q.as_ref()[body]));
                size = size.max(h.abs() * largest(&room.velocity[body]));
            }
            let distance = if room.g[row] == 0.0 { 0.0 } else { room.g[row].abs() / square.sqrt() };
            let roundings = if distance == 0.0 { 0.0 } else { distance / (f64::EPSILON * size) };
            if roundings > furthest.1 || roundings.is_nan() {
                furthest = (distance, roundings, row);
            }
        }
        furthest
    }

    /// Whether the normals at the new positions are as independent as they were at the start.
    fn check_rank(&self, c: usize, bodies: &BodiesOf<F, N, D>, sine: f64, row: usize) -> Result<(), Failure> {
        let component = &self.shape.components[c];
        let lost = match &bodies.kept.solvers[c] {
            Solver::Orthogonal(basis) => basis.rank < component.solver.rank(&component.rows),
            Solver::Elimination(_) => sine < LOST || sine.is_nan(),
        };
        if !lost {
            return Ok(());
        }
        let equation = self.shape.equation_at(c, row);
        let q = bodies.q.as_ref();
        let body = equation.bodies[0];
        let first = component.first;
        let blocks = &bodies.kept.blocks[first.1..first.1 + component.rows.blocks()];
        let square: f64 =
            component.rows.touched_by(row).map(|(block, _)| dot(&blocks[block], &blocks[block])).sum();
        let cause = if !square.is_finite() {
            StepFailure::ConstraintNotFinite { position: q[body].to_vec() }
        } else if component.rows.acting {
            StepFailure::CannotAct { equation, share: acting_share(&self.shape, c, row, blocks) }
        } else {
            StepFailure::RankLost { equation, sine }
        };
        Err(Failure { body, cause })
    }

    #[cold]
    fn not_finite(&self, bodies: &BodiesOf<F, N, D>, body: usize) -> Failure {
        let q = bodies.q.as_ref();
        // Links hand a force that is none on to other bodies.
        let culprits = (0..q.len()).filter(|&body| !matches!(self.shape.roots[body], Root::Pinned));
        let mut culprits = culprits.filter_map(|body| Some((body, self.field.culprit(q, body)?)));
        if let Some((body, (effect, force))) = culprits.next() {
            let (force, position) = (force.to_vec(), q[body].to_vec());
            return Failure { body, cause: StepFailure::ForceNotFinite { effect, force, position } };
        }
        Failure { body, cause: StepFailure::MomentumNotFinite { position: q[body].to_vec() } }
    }

    pub(crate) fn counts(&self, bodies: &BodiesOf<F, N, D>) -> Counts {
        bodies.kept.counts
    }
}

impl<F, const D: usize> Kept<F, D> {
    /// Evaluates gradients at q and takes the normals over. Returns the sine of the least independent one, and its row.
    fn normals(&mut self, shape: &Shape<D>, c: usize, time: f64, q: &[[f64; D]]) -> (f64, usize) {
        let component = &shape.components[c];
        let (rows, (row, block)) = (&component.rows, component.first);
        let blocks = &mut self.blocks[block..block + rows.blocks()];
        let rates = &mut self.rates[row..row + rows.equations()];
        shape.gradients(c, time, q, &mut self.room.g, blocks, rates);
        if !rows.acting {
            return self.solvers[c].normals(rows, blocks, &shape.roots);
        }
        let acting = &mut self.room.blocks[..rows.blocks()];
        acting.copy_from_slice(blocks);
        shape.mask(c, acting);
        self.solvers[c].normals(rows, acting, &shape.roots)
    }
}

impl<const D: usize> Flight<'_, D> {
    fn rows(&self) -> &Rows {
        &self.shape.components[self.component].rows
    }

    /// Writes the x with g̈ = 0 into `room.guess`. Returns the largest relative change of a normal in the step.
    fn guess(&self, solver: &mut Solver<D>, room: &mut Room<D>) -> f64 {
        let (rows, blocks) = (self.rows(), self.blocks);
        let m = rows.equations();
        let (bends, turns) = (&mut room.g[..m], &mut room.dx[..m]);
        self.shape.bends(self.component, self.time, self.q, &room.velocity, bends, turns);
        let mut largest_turn = 0.0_f64;
        for (i, bend) in bends.iter_mut().enumerate() {
            let square: f64 = rows.blocks_of(i).map(|(block, _)| dot(&blocks[block], &blocks[block])).sum();
            let turn = self.h.abs() * (turns[i] / square).sqrt();
            if turn > largest_turn || turn.is_nan() {
                largest_turn = turn;
            }
            *bend = -0.5 * self.h * self.h * *bend - along(rows, i, blocks, &room.push);
        }
        solver.respond(rows, blocks, &self.shape.roots, bends, &mut room.guess[..m]);
        largest_turn
    }

    /// Solves for x into `room.y`, from `room.guess`, on the root that the motion leads to.
    fn solve(&self, solver: &mut Solver<D>, turn: f64, room: &mut Room<D>, counts: &mut Counts) -> Landing {
        let m = self.rows().equations();
        room.y[..m].copy_from_slice(&room.guess[..m]);
        let landing = self.land(solver, 1.0, room, counts, |_| ());
        let path = self.path_to(&landing, solver, room);
        if turn <= LARGE_TURN && self.trusts(&landing, FAR_GUESS * path, solver, 1.0, room) {
            return landing;
        }
        counts.followed += 1;
        self.follow(solver, path, room, counts)
    }

    /// Whether the root found for the part `s` of the step is taken for the one that the motion leads to: the guess was off
    /// by no more than `far`, or the normals there are those of the start (as at rest, where `far` is 0).
    fn trusts(&self, landing: &Landing, far: f64, solver: &Solver<D>, s: f64, room: &mut Room<D>) -> bool {
        landing.converged && landing.upright && (landing.first <= far || self.straight(solver, s, room))
    }

    #[cold]
    fn straight(&self, solver: &Solver<D>, s: f64, room: &mut Room<D>) -> bool {
        let (m, blocks) = (self.rows().equations(), self.rows().blocks());
        self.place(solver, s, room);
        let (g, there) = (&mut room.g[..m], &mut room.blocks[..blocks]);
        let time = self.time + s * self.h;
        self.shape.gradients(self.component, time, &room.trial, g, there, &mut room.rates[..m]);
        self.change(room, self.blocks) <= STRAIGHT
    }

    /// The longest way of a body without the constraints, or with those that move.
    fn path_to(&self, landing: &Landing, solver: &Solver<D>, room: &mut Room<D>) -> f64 {
        let path = self.path(room);
        if !self.rows().moving {
            return path;
        }
        // A constraint that begins to move takes bodies along that had no way of their own.
        let m = self.rows().equations();
        room.dx[..m].copy_from_slice(&room.guess[..m]);
        path + self.length_of_correction(solver, room) + landing.first
    }

    /// The longest way of a body without the constraints.
    fn path(&self, room: &Room<D>) -> f64 {
        let ways =
            self.rows().bodies.iter().map(|&body| largest(&room.drift[body]) + largest(&room.push[body]));
        ways.fold(0.0, f64::max)
    }

    /// Puts the component's bodies to where they are after the part `s` of the step with normal part `y`.
    fn place(&self, solver: &Solver<D>, s: f64, room: &mut Room<D>) {
        let rows = self.rows();
        for &body in &rows.bodies {
            let (drift, push) = (&room.drift[body], &room.push[body]);
            room.lift[body] = std::array::from_fn(|i| s * drift[i] + s * s * push[i]);
        }
        solver.displace(rows, &self.shape.roots, &room.y[..rows.equations()], &mut room.lift);
        for &body in &rows.bodies {
            room.trial[body] = sum(&self.q[body], &sum(&self.q_low[body], &room.lift[body]));
        }
    }

    /// Solves the position equation for the part `s` of the step, from and into `room.y`. `note` is told every residual,
    /// as a length.
    fn land(
        &self,
        solver: &mut Solver<D>,
        s: f64,
        room: &mut Room<D>,
        counts: &mut Counts,
        mut note: impl FnMut(&Room<D>),
    ) -> Landing {
        let (rows, time) = (self.rows(), self.time + s * self.h);
        let (m, blocks) = (rows.equations(), rows.blocks());
        self.place(solver, s, room);
        self.shape.gradients(
            self.component,
            time,
            &room.trial,
            &mut room.g[..m],
            &mut room.blocks[..blocks],
            &mut room.rates[..m],
        );
        self.measure_rounding(None, room);
        let pivot = solver.chord::<false>(rows, &room.blocks, &self.shape.roots);
        counts.values += 1;
        counts.gradients += 1;
        let mut landing =
            Landing { converged: false, upright: pivot > 0.0, first: 0.0, contradictory: false };
        let (mut last, mut residual) = (f64::INFINITY, room.residual(m));
        for correction in 0..MAX_CORRECTIONS {
            note(room);
            if !residual.is_finite() {
                return landing;
            }
            solver.correct(&room.g[..m], &mut room.dx[..m]);
            room.y[..m].iter_mut().zip(&room.dx).for_each(|(y, dx)| *y += dx);
            counts.corrections += 1;
            if correction == 0 {
                landing.first = self.length_of_correction(solver, room);
            }
            let contraction = residual / last;
            let known = last.is_finite() && contraction <= CONTRACTION;
            if residual <= 1.0 || (known && contraction * residual <= 1.0 / 16.0) {
                landing.converged = true;
                return landing;
            }
            self.place(solver, s, room);
            self.shape.values(self.component, time, &room.trial, &mut room.g[..m]);
            counts.values += 1;
            (last, residual) = (residual, room.residual(m));
            if residual > CONTRACTION * last {
                room.before[..blocks].copy_from_slice(&room.blocks[..blocks]);
                let (g, blocks) = (&mut room.g[..m], &mut room.blocks[..blocks]);
                self.shape.gradients(self.component, time, &room.trial, g, blocks, &mut room.rates[..m]);
                counts.gradients += 1;
                if self.change(room, &room.before) <= STRAIGHT {
                    // The rounding of g itself, or dependent equations that cannot all hold.
                    solver.correct(&room.g[..m], &mut room.dx[..m]);
                    let vain = self.length_of_correction(solver, room) < 1e-3 * room.longest(m);
                    landing.contradictory = vain && solver.rank(rows) < m && residual > 64.0;
                    landing.converged = !landing.contradictory;
                    return landing;
                }
                let pivot = solver.chord::<false>(rows, &room.blocks, &self.shape.roots);
                landing.upright &= pivot > 0.0;
                last = f64::INFINITY;
            }
        }
        landing
    }

    /// The landing that is reached from h = 0 without leaving the root, in parts that are halved until each is trusted.
    #[cold]
    #[inline(never)]
    fn follow(&self, solver: &mut Solver<D>, path: f64, room: &mut Room<D>, counts: &mut Counts) -> Landing {
        let m = self.rows().equations();
        room.excess[..m].fill(0.0);
        room.slope[..m].fill(0.0);
        let (mut s, mut part) = (0.0, 0.5);
        let mut landing = Landing { converged: false, upright: false, first: 0.0, contradictory: false };
        for _ in 0..MAX_PARTS {
            let end = f64::min(s + part, 1.0);
            let length = end - s;
            for i in 0..m {
                room.y[i] = room.guess[i] * end * end + room.excess[i] + room.slope[i] * length;
            }
            landing = self.land(solver, end, room, counts, |_| ());
            if self.trusts(&landing, FAR_EXTRAPOLATION * length * path, solver, end, room) {
                for i in 0..m {
                    let excess = room.y[i] - room.guess[i] * end * end;
                    room.slope[i] = (excess - room.excess[i]) / length;
                    room.excess[i] = excess;
                }
                s = end;
                part *= 2.0;
                if s >= 1.0 {
                    return landing;
                }
            } else {
                part *= 0.5;
                if part < SMALLEST_PART {
                    break;
                }
            }
        }
        Landing { converged: false, ..landing }
    }

    /// Rounding of each residual, as that of the coordinates it depends on, or of the way to go if that is longer. By these
    /// gradients, or those at the trial.
    fn measure_rounding(&self, blocks: Option<&[[f64; D]]>, room: &mut Room<D>) {
        let rows = self.rows();
        let blocks = blocks.unwrap_or(&room.blocks);
        for row in 0..rows.equations() {
            let (mut square, mut size) = (0.0, 0.0);
            for (block, body) in rows.touched_by(row) {
                square += dot(&blocks[block], &blocks[block]);
                size = f64::max(size, f64::max(largest(&self.q[body]), largest(&room.trial[body])));
                size = f64::max(size, largest(&room.drift[body]));
            }
            room.lengths[row] = square.sqrt();
            size = f64::max(size, room.g[row].abs() / room.lengths[row]);
            room.scale[row] = 1.0 / (f64::EPSILON * size * room.lengths[row]);
        }
    }

    /// The largest displacement that `room.dx` makes.
    fn length_of_correction(&self, solver: &Solver<D>, room: &mut Room<D>) -> f64 {
        let rows = self.rows();
        rows.bodies.iter().for_each(|&body| room.lift[body] = [0.0; D]);
        solver.displace(rows, &self.shape.roots, &room.dx[..rows.equations()], &mut room.lift);
        rows.bodies.iter().map(|&body| largest(&room.lift[body])).fold(0.0, f64::max)
    }

    /// The largest relative change of a gradient from `before`.
    fn change(&self, room: &Room<D>, before: &[[f64; D]]) -> f64 {
        let rows = self.rows();
        let change = |row: usize| {
            let apart = rows.blocks_of(row).map(|(block, _)| {
                let difference = add_scaled(&room.blocks[block], -1.0, &before[block]);
                dot(&difference, &difference)
            });
            apart.sum::<f64>().sqrt() / room.lengths[row]
        };
        (0..rows.equations()).map(change).fold(0.0, f64::max)
    }

    /// Why the step failed, and what would pass.
    #[cold]
    #[inline(never)]
    fn failure(&self, solver: &mut Solver<D>, turn: f64, room: &mut Room<D>, landing: Landing) -> Failure {
        let (rows, m, blocks) = (self.rows(), self.rows().equations(), self.blocks);
        let mut residuals = Vec::new();
        room.y[..m].copy_from_slice(&room.guess[..m]);
        let direct =
            self.land(solver, 1.0, room, &mut Counts::default(), |room| residuals.push(room.longest(m)));
        let row = room.worst(m);
        let equation = self.shape.equation_at(self.component, row);
        let body = equation.bodies[0];
        let because = |cause| Failure { body, cause };
        let share = acting_share(self.shape, self.component, row, blocks);
        if rows.acting && share < LITTLE_SHARE {
            return because(StepFailure::CannotAct { equation, share });
        }
        let square: f64 = rows.touched_by(row).map(|(block, _)| dot(&blocks[block], &blocks[block])).sum();
        let first = residuals.first().copied().unwrap_or(f64::NAN);
        if !(first.is_finite() && square.is_finite()) && residuals.len() < 2 {
            return because(StepFailure::ConstraintNotFinite { position: self.q[body].to_vec() });
        }
        let path = self.path(room);
        let mut passing = None;
        let mut parts = (self.h, turn);
        for _ in 0..HALVINGS {
            parts = (0.5 * parts.0, 0.5 * parts.1);
            for &body in &rows.bodies {
                room.drift[body] = room.drift[body].map(|x| 0.5 * x);
                room.push[body] = room.push[body].map(|x| 0.25 * x);
            }
            room.guess[..m].iter_mut().for_each(|x| *x *= 0.25);
            let shorter = Flight { h: parts.0, ..*self };
            if shorter.solve(solver, parts.1, room, &mut Counts::default()).converged {
                passing = Some(parts.0);
                break;
            }
        }
        let much_shorter = passing.is_none_or(|h: f64| h.abs() <= MUCH_SHORTER * self.h.abs());
        let independent = solver.rank(rows) == m;
        let (sine, weakest) = solver.normals(rows, blocks, &self.shape.roots);
        // A solution is near, but within a few such steps normals may fall together: it may lie on another branch.
        let ahead = direct.converged && turn < SHORT && sine < 4.0 * turn;
        let here = much_shorter && sine < BRANCHING;
        if independent && !rows.acting && (ahead || here) {
            let equation = self.shape.equation_at(self.component, weakest);
            let body = equation.bodies[0];
            return Failure { body, cause: StepFailure::RankLost { equation, sine } };
        }
        let residuals = residuals.into_iter().collect();
        because(if landing.contradictory {
            StepFailure::Contradictory { equation, residuals }
        } else {
            let gradient = square.sqrt();
            StepFailure::NotSolved {
                equation,
                path,
                residuals,
                gradient,
                turn,
                h: self.h,
                passing: Passing(passing),
            }
        })
    }
}

impl<const D: usize> Room<D> {
    /// The largest residual in units of its rounding; NaN if one is.
    fn residual(&self, equations: usize) -> f64 {
        let mut worst = 0.0;
        for (g, scale) in self.g[..equations].iter().zip(&self.scale) {
            let ratio = if *g == 0.0 { 0.0 } else { g.abs() * scale };
            if ratio > worst || ratio.is_nan() {
                worst = ratio;
            }
        }
        worst
    }

    /// The equation with the largest residual.
    fn worst(&self, equations: usize) -> usize {
        let ratio = |i: usize| self.g[i].abs() * self.scale[i];
        (0..equations)
            .fold(0, |worst, i| if ratio(i) > ratio(worst) || ratio(i).is_nan() { i } else { worst })
    }

    /// Its residual as a length.
    fn longest(&self, equations: usize) -> f64 {
        let worst = self.worst(equations);
        self.g[worst].abs() / self.lengths[worst]
    }
}

impl<const D: usize> Shape<D> {
    /// Names an equation.
    pub(crate) fn equation_at(&self, component: usize, row: usize) -> Box<EquationAt> {
        let rows = &self.components[component].rows;
        let (group, member, equation) = rows.find(&self.groups, row);
        Box::new(EquationAt {
            link: self.groups[group].name(),
            member,
            equation,
            of: self.groups[group].equations(),
            bodies: rows.touched_by(row).map(|(_, body)| body).collect(),
        })
    }
}

/// How much of ∇g the multiplier of an equation acts along: 1 if on all coordinates.
fn acting_share<const D: usize>(shape: &Shape<D>, c: usize, row: usize, blocks: &[[f64; D]]) -> f64 {
    let rows = &shape.components[c].rows;
    let mut acting = blocks.to_vec();
    shape.mask(c, &mut acting);
    let square =
        |blocks: &[[f64; D]]| rows.blocks_of(row).map(|(b, _)| dot(&blocks[b], &blocks[b])).sum::<f64>();
    (square(&acting) / square(blocks)).sqrt()
}

/// ∇gᵢ·v.
#[inline]
fn along<const D: usize>(rows: &Rows, row: usize, blocks: &[[f64; D]], v: &[[f64; D]]) -> f64 {
    let mut sum = 0.0;
    for (block, body) in rows.blocks_of(row) {
        sum += dot(&blocks[block], &v[rows.bodies[body]]);
    }
    sum
}

/// ∇gᵢ·v, and the same with all products positive.
#[inline]
fn along_and_size<const D: usize>(
    rows: &Rows,
    row: usize,
    blocks: &[[f64; D]],
    v: &[[f64; D]],
) -> (f64, f64) {
    let (mut sum, mut size) = (0.0, 0.0);
    for (block, body) in rows.blocks_of(row) {
        for (g, v) in blocks[block].iter().zip(&v[rows.bodies[body]]) {
            sum += g * v;
            size += (g * v).abs();
        }
    }
    (sum, size)
}
