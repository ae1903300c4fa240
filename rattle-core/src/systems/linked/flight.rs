//! The position equation of one component, solved along the motion.
//!
//! Each component is solved by itself. With W = M⁻¹G(q)ᵀ, or an orthonormal basis of its columns, the position equation
//! is
//!
//! ```text
//! r(x) = g(q + free + W x) = 0
//! ```
//!
//! and is solved by Newton's method with the derivative G(q′)W of the first guess, evaluated again where a correction
//! is not a fourth of the one before. The first guess has λ from g̈ = 0, so a step is a pure function of the state.
//!
//! **Stopping.** Residuals are measured as lengths, |gᵢ|/|∇gᵢ|, relative to the rounding ε·ℓ of the coordinates in
//! equation i, so neither the scale of g nor the rest of a long chain matters. Two residuals give the contraction, and
//! the solve ends without a further evaluation once the next residual is expected to be negligible
//! ([`crate::solve::stop`]). It also ends where a newly evaluated derivative does not reduce the residuals: then they
//! are the rounding of g itself.
//!
//! **Which root**: see [`crate::solve::root`]. Here "upright" means that pivots remain positive, or where multipliers
//! act on chosen coordinates that the determinant keeps its sign, and a path is short if normals change by less than
//! half of themselves.

use crate::motion::failure::Failure;
use crate::number::vector::{add_scaled, dot, larger, largest, size, sum};
use crate::solve::aim::Aim;
use crate::solve::root::{Course, FAR_EXTRAPOLATION, FAR_GUESS, SHORT_PATH, follow, straight};
use crate::solve::stop::{SPARE, Shrinking, Terms, over_rounding};
use crate::systems::linked::kept::{Counts, Room};
use crate::systems::network::line::Line;
use crate::systems::network::rows::Rows;
use crate::systems::network::shape::Shape;
use crate::systems::network::solver::Solver;
use std::array::from_fn;

/// Residuals that shrink by less ask for a new derivative.
pub(super) const CONTRACTION: f64 = 0.25;
/// Corrections after which a solve is given up.
pub(crate) const MAX_CORRECTIONS: usize = 40;
/// Halvings of a failed step that are tried, to say which would pass.
pub(crate) const HALVINGS: i32 = 24;
/// Steps in which normals change by less are short enough to be accurate: where one fails, the reason is another.
pub(crate) const SHORT: f64 = 0.2;
/// A normal with a smaller sine to the others is lost; see `orthogonal.rs` for the other case.
pub(crate) const LOST: f64 = 1e-7;
/// A normal with more than this sine to the others is clearly independent of them.
pub(crate) const CLEAR: f64 = 0.1;
/// A normal is lost ahead where its sine, by a straight line through a shorter step, is zero within so many steps.
pub(crate) const SOON: f64 = 1.5;
/// Where only a step shorter by this would pass, a normal with a sine of
/// [`BRANCHING`](crate::systems::network::orthogonal::BRANCHING) to the others is what stopped it.
pub(crate) const MUCH_SHORTER: f64 = 1e-3;
/// A multiplier that acts along less than this part of ∇g is what stopped a step.
pub(crate) const LITTLE_SHARE: f64 = 0.25;

/// What is tried: first another iteration or guess, if one was asked for, then Newton's from g̈ = 0.
pub(crate) const FIRST: usize = 0;
const SECOND: usize = 1;

/// One component on its way: everything that the position equation needs.
pub(crate) struct Flight<'a, const D: usize> {
    pub(super) shape: &'a Shape<D>,
    pub(super) component: usize,
    pub(super) q: &'a [[f64; D]],
    pub(super) q_low: &'a [[f64; D]],
    /// The gradients there.
    pub(super) blocks: &'a [[f64; D]],
    /// What guesses were off by in the steps before, by row, and how much those steps count.
    pub(super) aims: &'a [Aim<f64>],
    pub(super) weights: [f64; 2],
    pub(super) time: f64,
    pub(super) h: f64,
}

/// How a solve ended.
#[derive(Clone, Copy)]
pub(crate) struct Landing {
    pub(super) converged: bool,
    /// Whether pivots stayed positive, or of links that act on chosen coordinates the sign of the determinant.
    pub(super) upright: bool,
    /// The largest displacement by the first correction.
    pub(super) first: f64,
    /// Whether dependent equations ask for different things.
    pub(super) contradictory: bool,
    /// Whether one derivative did for all corrections.
    pub(super) one_derivative: bool,
    /// Whether it was reached from the first guess, and `room.off` is what that was off by.
    pub(super) aimed: bool,
}

impl<const D: usize> Flight<'_, D> {
    pub(crate) fn rows(&self) -> &Rows {
        &self.shape.components[self.component].rows
    }

    /// Writes the x with g̈ = 0 into `room.guess`. Returns the largest relative change of a normal in the step.
    pub(crate) fn guess(&self, solver: &mut Solver<D>, room: &mut Room<D>) -> f64 {
        let rows = self.rows();
        let m = rows.equations();
        let (bends, turns) = (&mut room.g[..m], &mut room.dx[..m]);
        self.shape.bends(self.component, self.time, self.q, &room.velocity, bends, turns);
        let square = match (&rows.line, rows.width()) {
            (Some(line), _) => self.right_side_of_line(line, &room.push, bends, turns),
            (None, 2) => self.right_side::<2>(&room.push, bends, turns),
            _ => self.right_side::<0>(&room.push, bends, turns),
        };
        solver.respond(rows, self.blocks, &self.shape.roots, bends, &mut room.guess[..m]);
        if rows.acting {
            room.orientation = solver.orientation();
        }
        self.h.abs() * square.sqrt()
    }

    /// Whether the derivative that the solver has just taken, with this smallest pivot, is that of normals that have
    /// not turned over.
    pub(super) fn is_upright(&self, pivot: f64, solver: &Solver<D>, room: &Room<D>) -> bool {
        if self.rows().acting { solver.orientation() * room.orientation > 0.0 } else { pivot > 0.0 }
    }

    /// What x is to move g by, from d²g/dt² along the velocities. Returns the largest (|∇²g v|/|∇g|)²; NaN if one is.
    #[inline(always)]
    fn right_side<const A: usize>(&self, push: &[[f64; D]], bends: &mut [f64], turns: &[f64]) -> f64 {
        let (rows, blocks) = (self.rows(), self.blocks);
        let mut largest = 0.0_f64;
        for (i, (bend, turn)) in bends.iter_mut().zip(turns).enumerate() {
            let range = rows.range::<A>(i);
            let (mut square, mut along) = (0.0, 0.0);
            let of_bodies = rows.touched()[range.clone()].iter().zip(&rows.free()[range.clone()]);
            for (block, (&body, free)) in blocks[range].iter().zip(of_bodies) {
                square += free * dot(block, block);
                along += dot(block, &push[body]);
            }
            let ratio = turn / square;
            if ratio > largest || ratio.is_nan() {
                largest = ratio;
            }
            *bend = -0.5 * self.h * self.h * *bend - along;
        }
        largest
    }

    /// The same for rows in a line.
    fn right_side_of_line(&self, line: &Line, push: &[[f64; D]], bends: &mut [f64], turns: &[f64]) -> f64 {
        let mut pushes = push[line.first..line.first + bends.len() + 1].iter();
        let Some(mut before) = pushes.next() else { return 0.0 };
        let (pairs, free) = (self.blocks.as_chunks::<2>().0, self.rows().free().as_chunks::<2>().0);
        let (mut most, mut total) = (0.0, 0.0);
        for ((((bend, &turn), pair), free), after) in
            bends.iter_mut().zip(turns).zip(pairs).zip(free).zip(pushes)
        {
            let square = free[0] * dot(&pair[0], &pair[0]) + free[1] * dot(&pair[1], &pair[1]);
            let along = dot(&pair[0], before) + dot(&pair[1], after);
            most = larger(most, turn / square);
            total += turn; // NaN if one is
            *bend = -0.5 * self.h * self.h * *bend - along;
            before = after;
        }
        if f64::is_nan(total) { total } else { most }
    }

    /// Solves for x into `room.y` by Newton's method from g̈ = 0.
    pub(crate) fn find(
        &self,
        solver: &mut Solver<D>,
        room: &mut Room<D>,
        counts: &mut Counts,
    ) -> Result<Landing, Failure> {
        let turn = self.guess(solver, room);
        let landing = self.solve(solver, turn, room, counts);
        self.at_end(landing, solver, turn, room)
    }

    /// Goes on from this landing on the root of the whole step, found from `room.guess`.
    pub(super) fn find_from(
        &self,
        landing: Landing,
        turn: f64,
        solver: &mut Solver<D>,
        room: &mut Room<D>,
        counts: &mut Counts,
    ) -> Result<Landing, Failure> {
        let landing = self.go_on(landing, turn, solver, room, counts);
        self.at_end(landing, solver, turn, room)
    }

    fn at_end(
        &self,
        landing: Landing,
        solver: &mut Solver<D>,
        turn: f64,
        room: &mut Room<D>,
    ) -> Result<Landing, Failure> {
        if landing.converged { Ok(landing) } else { Err(self.failure(solver, turn, room, landing)) }
    }

    /// Solves for x into `room.y`, from `room.guess`, on the root that the motion leads to.
    pub(crate) fn solve(
        &self,
        solver: &mut Solver<D>,
        turn: f64,
        room: &mut Room<D>,
        counts: &mut Counts,
    ) -> Landing {
        let m = self.rows().equations();
        room.y[..m].copy_from_slice(&room.guess[..m]);
        let landing = self.land(solver, 1.0, room, counts, |_| ());
        self.go_on(landing, turn, solver, room, counts)
    }

    /// The landing itself if it is trusted, or else that on the root followed from h = 0.
    fn go_on(
        &self,
        landing: Landing,
        turn: f64,
        solver: &mut Solver<D>,
        room: &mut Room<D>,
        counts: &mut Counts,
    ) -> Landing {
        let m = self.rows().equations();
        let path = self.path_to(&landing, solver, room);
        let trusted = self.trusts_all(&landing, turn, path, solver, room);
        if trusted && self.is_the_one(&landing, turn, path, solver, room, counts) {
            return landing;
        }
        if !trusted {
            self.suspect_all(room);
        }
        counts.followed += 1;
        room.set_aside(SECOND, m);
        let followed = self.follow(solver, path, room, counts);
        let aimed = trusted && followed.converged && self.is_same(SECOND, solver, room);
        if aimed {
            room.go_back(SECOND, m);
        }
        Landing { aimed, ..followed }
    }

    /// Whether the root found for the whole step, after this path and where normals turn so much, is trusted.
    pub(crate) fn trusts_all(
        &self,
        landing: &Landing,
        turn: f64,
        path: f64,
        solver: &Solver<D>,
        room: &mut Room<D>,
    ) -> bool {
        turn <= SHORT_PATH && self.trusts(landing, FAR_GUESS * path, solver, 1.0, room)
    }

    /// Whether the root found for the part `s` of the step is trusted: the guess was off by no more than `far`, or the
    /// normals there are those of the start (as at rest, where `far` is 0).
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
        self.change(room, self.blocks) <= straight::<f64>()
    }

    /// The longest way of a body without the constraints, or with those that move.
    pub(crate) fn path_to(&self, landing: &Landing, solver: &Solver<D>, room: &mut Room<D>) -> f64 {
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
    pub(crate) fn path(&self, room: &Room<D>) -> f64 {
        let way = |&body: &usize| size(&room.drift[body]) + size(&room.push[body]);
        self.rows().bodies.iter().map(way).fold(0.0, larger)
    }

    /// Puts the component's bodies to where they are after the part `s` of the step with normal part `y`.
    pub(crate) fn place(&self, solver: &Solver<D>, s: f64, room: &mut Room<D>) {
        let (rows, n) = (self.rows(), self.q.len());
        let Room { drift, push, lift, trial, y, .. } = room;
        let (drift, push, lift, trial) = (&drift[..n], &push[..n], &mut lift[..n], &mut trial[..n]);
        let q_low = &self.q_low[..n];
        if let (Some(line), Some(lifted)) = (&rows.line, solver.lifted()) {
            let bodies = line.bodies(rows.equations());
            let places =
                trial[bodies.clone()].iter_mut().zip(&self.q[bodies.clone()]).zip(&q_low[bodies.clone()]);
            let ways = lift[bodies.clone()].iter_mut().zip(&drift[bodies.clone()]).zip(&push[bodies]);
            let mut bodies = places.zip(ways);
            return line.combine(lifted, &y[..rows.equations()], |way| {
                if let Some((((trial, q), q_low), ((lift, drift), push))) = bodies.next() {
                    *lift = std::array::from_fn(|i| s * drift[i] + s * s * push[i] + way[i]);
                    *trial = sum(q, &sum(q_low, lift));
                }
            });
        }
        solver.displacements(rows, &self.shape.roots, &y[..rows.equations()], |body, way| {
            let (drift, push) = (&drift[body], &push[body]);
            lift[body] = std::array::from_fn(|i| s * drift[i] + s * s * push[i] + way[i]);
            trial[body] = sum(&self.q[body], &sum(&q_low[body], &lift[body]));
        });
    }

    /// Moves them on by `room.dx`. Returns the largest displacement.
    fn advance(&self, solver: &Solver<D>, room: &mut Room<D>) -> f64 {
        let (rows, n) = (self.rows(), self.q.len());
        let Room { lift, trial, dx, .. } = room;
        let (lift, trial, q_low) = (&mut lift[..n], &mut trial[..n], &self.q_low[..n]);
        let mut longest = 0.0_f64;
        if let (Some(line), Some(lifted)) = (&rows.line, solver.lifted()) {
            let bodies = line.bodies(rows.equations());
            let places =
                trial[bodies.clone()].iter_mut().zip(&self.q[bodies.clone()]).zip(&q_low[bodies.clone()]);
            let mut bodies = places.zip(&mut lift[bodies]);
            line.combine(lifted, &dx[..rows.equations()], |way| {
                if let Some((((trial, q), q_low), lift)) = bodies.next() {
                    longest = larger(longest, size(&way));
                    *lift = sum(lift, &way);
                    *trial = sum(q, &sum(q_low, lift));
                }
            });
            return longest;
        }
        solver.displacements(rows, &self.shape.roots, &dx[..rows.equations()], |body, way| {
            longest = longest.max(largest(&way));
            lift[body] = sum(&lift[body], &way);
            trial[body] = sum(&self.q[body], &sum(&q_low[body], &lift[body]));
        });
        longest
    }

    /// Solves the position equation for the part `s` of the step, from and into `room.y`. `note` is told every
    /// residual, as a length.
    pub(crate) fn land(
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
        room.note_off(m);
        let mut landing = Landing::from(self.is_upright(pivot, solver, room));
        let (mut shrinking, mut residual) = (Shrinking::start(), room.residual(m));
        for correction in 0..MAX_CORRECTIONS {
            note(room);
            if !residual.is_finite() {
                return landing;
            }
            solver.correct(&room.g[..m], &mut room.dx[..m]);
            room.y[..m].iter_mut().zip(&room.dx).for_each(|(y, dx)| *y += dx);
            counts.corrections += 1;
            let length = self.advance(solver, room);
            if correction == 0 {
                landing.first = length;
            }
            let (_, left) = shrinking.note(residual);
            if residual <= 1.0 || left <= SPARE {
                landing.converged = true;
                return landing;
            }
            self.shape.values(self.component, time, &room.trial, &mut room.g[..m]);
            counts.values += 1;
            let last = residual;
            residual = room.residual(m);
            if residual > CONTRACTION * last {
                room.before[..blocks].copy_from_slice(&room.blocks[..blocks]);
                let (g, blocks) = (&mut room.g[..m], &mut room.blocks[..blocks]);
                self.shape.gradients(self.component, time, &room.trial, g, blocks, &mut room.rates[..m]);
                counts.gradients += 1;
                landing.one_derivative = false;
                if self.change(room, &room.before) <= straight::<f64>() {
                    // The rounding of g itself, or dependent equations that cannot all hold.
                    solver.correct(&room.g[..m], &mut room.dx[..m]);
                    let vain = self.length_of_correction(solver, room) < 1e-3 * room.longest(m);
                    let off = vain && residual > 64.0;
                    landing.contradictory = off && solver.rank(rows) < m;
                    landing.converged = !off;
                    return landing;
                }
                let pivot = solver.chord::<false>(rows, &room.blocks, &self.shape.roots);
                landing.upright &= self.is_upright(pivot, solver, room);
                shrinking = Shrinking::start();
            }
        }
        landing
    }

    /// The landing that is reached from h = 0 without leaving the root.
    #[cold]
    #[inline(never)]
    fn follow(&self, solver: &mut Solver<D>, path: f64, room: &mut Room<D>, counts: &mut Counts) -> Landing {
        let m = self.rows().equations();
        room.course[..m].fill(Course::start());
        let mut landing = Landing::from(false);
        let reached = follow(|part| {
            for i in 0..m {
                room.y[i] = room.course[i].ahead(room.guess[i], part);
            }
            landing = self.land(solver, part.end, room, counts, |_| ());
            let far = FAR_EXTRAPOLATION * part.length * path;
            let trusted = self.trusts(&landing, far, solver, part.end, room)
                && (!room.suspects_any(m)
                    || self.part_looks_right(part, &landing, path, solver, room, counts));
            if trusted {
                for i in 0..m {
                    room.course[i].note(room.guess[i], part, room.y[i]);
                }
            }
            trusted
        });
        Landing { converged: reached, ..landing }
    }

    /// Rounding of each residual, as that of the coordinates it depends on, or of the way to go, with constraints or
    /// without, if that is longer. By these gradients, or those at the trial.
    pub(crate) fn measure_rounding(&self, blocks: Option<&[[f64; D]]>, room: &mut Room<D>) {
        match (&self.rows().line, self.rows().width()) {
            (Some(line), _) => self.measure_line(line, blocks, room),
            (None, 2) => self.measure_in::<2>(blocks, room),
            _ => self.measure_in::<0>(blocks, room),
        }
    }

    /// The same for rows in a line: each body's size is found once.
    fn measure_line(&self, line: &Line, blocks: Option<&[[f64; D]]>, room: &mut Room<D>) {
        let m = self.rows().equations();
        let Room { blocks: at_trial, trial, drift, push, lengths, scale, g, .. } = room;
        let pairs = blocks.unwrap_or(at_trial).as_chunks::<2>().0;
        let bodies = line.first..line.first + m + 1;
        let places = self.q[bodies.clone()].iter().zip(&trial[bodies.clone()]);
        let ways = drift[bodies.clone()].iter().zip(&push[bodies]);
        let mut places =
            places.zip(ways).map(|((q, trial), (drift, push))| (largest_of([q, trial, push]), *drift));
        let mut before = places.next().unwrap_or(([0.0; D], [0.0; D]));
        let rows = lengths[..m].iter_mut().zip(scale).zip(pairs).zip(&*g);
        for ((((length, scale), pair), g), after) in rows.zip(places) {
            let terms = Terms::of([(&pair[0], before.0, before.1), (&pair[1], after.0, after.1)].into_iter());
            *length = terms.length();
            let size = larger(terms.size(*length), g.abs());
            *scale = if *length > 0.0 { over_rounding(size) } else { f64::NAN };
            before = after;
        }
    }

    #[inline(always)]
    fn measure_in<const A: usize>(&self, blocks: Option<&[[f64; D]]>, room: &mut Room<D>) {
        let (rows, m, n) = (self.rows(), self.rows().equations(), self.q.len());
        let Room { blocks: at_trial, trial, drift, push, lengths, scale, g, .. } = room;
        let blocks = blocks.unwrap_or(at_trial);
        let (trial, drift, push, g) = (&trial[..n], &drift[..n], &push[..n], &g[..m]);
        for (row, (length, scale)) in lengths[..m].iter_mut().zip(scale).enumerate() {
            let range = rows.range::<A>(row);
            let touched = blocks[range.clone()].iter().zip(&rows.touched()[range]);
            let terms = Terms::of(touched.map(|(block, &body)| {
                (block, largest_of([&self.q[body], &trial[body], &push[body]]), drift[body])
            }));
            *length = terms.length();
            let size = larger(terms.size(*length), g[row].abs());
            *scale = if *length > 0.0 { over_rounding(size) } else { f64::NAN };
        }
    }

    /// The largest displacement that `room.dx` makes.
    pub(crate) fn length_of_correction(&self, solver: &Solver<D>, room: &Room<D>) -> f64 {
        let (rows, mut longest) = (self.rows(), 0.0_f64);
        solver.displacements(rows, &self.shape.roots, &room.dx[..rows.equations()], |_, way| {
            longest = longest.max(largest(&way));
        });
        longest
    }

    /// The largest relative change of a gradient from `before`.
    pub(crate) fn change(&self, room: &Room<D>, before: &[[f64; D]]) -> f64 {
        (0..self.rows().equations()).map(|row| self.turn(row, room, before)).fold(0.0, f64::max)
    }

    /// The relative change of the gradient of an equation from `before`.
    pub(crate) fn turn(&self, row: usize, room: &Room<D>, before: &[[f64; D]]) -> f64 {
        let apart = self.rows().blocks_of(row).map(|(block, _)| {
            let difference = add_scaled(&room.blocks[block], -1.0, &before[block]);
            dot(&difference, &difference)
        });
        apart.sum::<f64>().sqrt() / room.lengths[row]
    }
}

impl Landing {
    /// Nothing solved yet, from a guess with or without positive pivots.
    pub(super) fn from(upright: bool) -> Self {
        Self {
            converged: false,
            upright,
            first: 0.0,
            contradictory: false,
            one_derivative: true,
            aimed: true,
        }
    }
}

impl<const D: usize> Room<D> {
    /// Notes what the guess is off by: the residuals there, as lengths.
    pub(super) fn note_off(&mut self, equations: usize) {
        let residuals = self.g[..equations].iter().zip(&self.lengths);
        self.off.iter_mut().zip(residuals).for_each(|(off, (g, length))| *off = g / length);
    }

    /// Sets aside what was tried first, or second.
    pub(super) fn set_aside(&mut self, attempt: usize, equations: usize) {
        let [y, off] = &mut self.tried[attempt];
        y[..equations].copy_from_slice(&self.y[..equations]);
        off[..equations].copy_from_slice(&self.off[..equations]);
    }

    /// Goes back to it.
    pub(super) fn go_back(&mut self, attempt: usize, equations: usize) {
        let [y, off] = &self.tried[attempt];
        self.y[..equations].copy_from_slice(&y[..equations]);
        self.off[..equations].copy_from_slice(&off[..equations]);
    }

    /// The largest residual in units of its rounding; NaN if one is.
    #[inline(always)]
    pub(crate) fn residual(&self, equations: usize) -> f64 {
        let ratio = |g: f64, scale: f64| if g == 0.0 { 0.0 } else { g.abs() * scale };
        let ((g, rest), (scale, of_rest)) =
            (self.g[..equations].as_chunks::<4>(), self.scale[..equations].as_chunks::<4>());
        // Four at a time, which do not wait for each other.
        let (mut worst, mut total) = ([0.0; 4], [0.0; 4]);
        for (g, scale) in g.iter().zip(scale) {
            for i in 0..4 {
                let ratio = ratio(g[i], scale[i]);
                worst[i] = larger(worst[i], ratio);
                total[i] += ratio; // NaN if one is
            }
        }
        for (&g, &scale) in rest.iter().zip(of_rest) {
            let ratio = ratio(g, scale);
            worst[0] = larger(worst[0], ratio);
            total[0] += ratio;
        }
        if total.iter().sum::<f64>().is_nan() { f64::NAN } else { size(&worst) }
    }

    /// The equation with the largest residual.
    pub(crate) fn worst(&self, equations: usize) -> usize {
        let ratio = |i: usize| self.g[i].abs() * self.scale[i];
        (0..equations)
            .fold(0, |worst, i| if ratio(i) > ratio(worst) || ratio(i).is_nan() { i } else { worst })
    }

    /// Its residual as a length.
    pub(crate) fn longest(&self, equations: usize) -> f64 {
        let worst = self.worst(equations);
        self.g[worst].abs() / self.lengths[worst]
    }
}

/// The largest of each coordinate.
#[inline(always)]
fn largest_of<const D: usize>([a, b, c]: [&[f64; D]; 3]) -> [f64; D] {
    from_fn(|d| larger(larger(a[d].abs(), b[d].abs()), c[d].abs()))
}
