//! Position equations of linked bodies with one fixed matrix, that of the guess or that of the start: see
//! [`crate::motion::iteration`]. Where residuals do not shrink, or the root is not trusted, Newton's method repeats the
//! step.

use crate::motion::failure::Failure;
use crate::motion::iteration::{Iteration, Kind};
use crate::solve::stop::{SPARE, Shrinking};
use crate::systems::linked::flight::{FIRST, Flight, Landing, MAX_CORRECTIONS};
use crate::systems::linked::kept::{Counts, LEARNED, Room};
use crate::systems::network::solver::Solver;

/// Residuals of a matrix that is kept must shrink at least like this.
const SLOWEST: f64 = 0.5;

impl<const D: usize> Flight<'_, D> {
    /// Solves for x into `room.y` by any iteration and from any guess of λ, or if that is empty from g̈ = 0. Where that
    /// is not good enough to tell that the root is the right one, by Newton's method from g̈ = 0; what was tried is
    /// kept if that finds the same.
    pub(super) fn try_to_solve<X: Iteration>(
        &self,
        guess: &[f64],
        solver: &mut Solver<D>,
        room: &mut Room<D>,
        counts: &mut Counts,
    ) -> Result<Landing, Failure> {
        let m = self.rows().equations();
        let (landing, turn, trusted) = self.attempt::<X>(guess, solver, room, counts);
        let path = self.path_to(&landing, solver, room);
        if trusted && self.is_the_one(&landing, turn, path, solver, room, counts) {
            return Ok(landing);
        }
        room.set_aside(FIRST, m);
        // Another guess is off by something else: nothing is known of what is usual for that one.
        let afresh = Flight { weights: [f64::NAN; 2], ..*self };
        let mut found = afresh.find(solver, room, counts)?;
        found.aimed = trusted && self.is_same(FIRST, solver, room);
        if found.aimed {
            room.go_back(FIRST, m);
        }
        Ok(found)
    }

    /// Solves once; says how much normals turn, and whether nothing at the two ends of the step speaks against what was
    /// found.
    fn attempt<X: Iteration>(
        &self,
        guess: &[f64],
        solver: &mut Solver<D>,
        room: &mut Room<D>,
        counts: &mut Counts,
    ) -> (Landing, f64, bool) {
        let (rows, m, guessed) = (self.rows(), self.rows().equations(), !guess.is_empty());
        let mut turn = 0.0;
        if guessed {
            let half_square = 0.5 * self.h * self.h;
            (0..m).for_each(|row| room.dx[row] = half_square * guess[rows.equation(row)]);
            solver.coefficients(&room.dx[..m], &mut room.guess[..m]);
            if rows.acting {
                solver.chord::<false>(rows, self.blocks, &self.shape.roots);
                room.orientation = solver.orientation();
            }
        } else {
            turn = self.guess(solver, room);
        }
        room.y[..m].copy_from_slice(&room.guess[..m]);
        let landing = match X::KIND {
            Kind::Newton => self.land(solver, 1.0, room, counts, |_| ()),
            _ => self.chords::<X>(solver, guessed, room, counts),
        };
        if guessed && landing.converged {
            turn = self.change(room, self.blocks); // until the guess, which is near the end
        }
        let path = self.path_to(&landing, solver, room);
        (landing, turn, self.trusts_all(&landing, turn, path, solver, room))
    }

    /// Solves the position equation from and into `room.y` with one matrix, that of the guess or that of the start, as
    /// it is or corrected by each residual. Not converged where residuals are not halved. With `look`, `room.blocks`
    /// are the gradients at the guess.
    fn chords<X: Iteration>(
        &self,
        solver: &mut Solver<D>,
        look: bool,
        room: &mut Room<D>,
        counts: &mut Counts,
    ) -> Landing {
        let (rows, time, m) = (self.rows(), self.time + self.h, self.rows().equations());
        let symmetric = X::KIND == Kind::Symmetric;
        self.place(solver, 1.0, room);
        let mut upright = true;
        if look || symmetric {
            let (g, blocks) = (&mut room.g[..m], &mut room.blocks[..rows.blocks()]);
            self.shape.gradients(self.component, time, &room.trial, g, blocks, &mut room.rates[..m]);
            counts.gradients += 1;
        } else {
            self.shape.values(self.component, time, &room.trial, &mut room.g[..m]);
        }
        counts.values += 1;
        if symmetric {
            let pivot = solver.chord::<true>(rows, &room.blocks, &self.shape.roots);
            upright = self.is_upright(pivot, solver, room);
        } else if rows.acting {
            let pivot = solver.chord::<false>(rows, self.blocks, &self.shape.roots);
            upright = self.is_upright(pivot, solver, room);
        }
        self.measure_rounding((!(look || symmetric)).then_some(self.blocks), room);
        room.note_off(m);
        let mut landing = Landing::from(upright);
        let (mut shrinking, mut residual) = (Shrinking::start(), room.residual(m));
        for correction in 0..MAX_CORRECTIONS {
            if !residual.is_finite() {
                break;
            }
            if symmetric || rows.acting {
                solver.correct(&room.g[..m], &mut room.dx[..m]);
            } else {
                solver.solve(&room.g[..m], &mut room.dx[..m]);
                room.dx[..m].iter_mut().for_each(|x| *x = -*x);
            }
            if X::KIND == Kind::Broyden && !room.learn(solver, correction, m) {
                break;
            }
            room.y[..m].iter_mut().zip(&room.dx).for_each(|(y, dx)| *y += dx);
            counts.corrections += 1;
            if correction == 0 {
                landing.first = self.length_of_correction(solver, room);
            }
            let (_, left) = shrinking.note(residual);
            if residual <= 1.0 || left <= SPARE {
                landing.converged = true;
                break;
            }
            self.place(solver, 1.0, room);
            self.shape.values(self.component, time, &room.trial, &mut room.g[..m]);
            counts.values += 1;
            let last = residual;
            residual = room.residual(m);
            if residual > SLOWEST * last {
                break;
            }
        }
        landing
    }
}

impl<const D: usize> Room<D> {
    /// Broyden's update: `dx`, the correction by the matrix of the start, becomes that by the matrix that agrees with
    /// all residuals of this solve so far, of which it is the n-th. False where there is no room for more.
    ///
    /// ```text
    /// A₊ = A + g₊ sᵀ/|s|²        s the last correction, g₊ the residual that it left
    /// ```
    fn learn(&mut self, solver: &Solver<D>, n: usize, m: usize) -> bool {
        if n >= LEARNED {
            return false;
        }
        let (past, present) = self.learned.split_at_mut(n * m);
        let along = |a: &[f64], b: &[f64]| solver.product(&self.lengths, a, b);
        let past = past.chunks_exact(m);
        for (s, next) in past.clone().zip(past.clone().skip(1)) {
            let share = along(s, &self.dx[..m]) / along(s, s);
            self.dx[..m].iter_mut().zip(next).for_each(|(x, next)| *x += share * next);
        }
        if let Some(s) = past.last() {
            let scale = 1.0 / (1.0 - along(s, &self.dx[..m]) / along(s, s));
            self.dx[..m].iter_mut().for_each(|x| *x *= scale);
        }
        present[..m].copy_from_slice(&self.dx[..m]);
        true
    }
}
