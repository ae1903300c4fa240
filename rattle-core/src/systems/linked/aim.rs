//! Whether the errors of guesses are as expected, equation by equation, to detect a step onto another sheet, see
//! [`crate::solve::aim`].
//!
//! The error of a guess in equation i is its residual gᵢ/|∇gᵢ|, which is known anyway, and does not depend on the
//! distance of sheets of other equations. In a long chain some residual is always near a change of sign. So only
//! equations with an unexpected residual are examined inside the step; and where the root is followed, only those that
//! failed there.

use crate::kernel::rounding::{NOISY, SHIFTS};
use crate::number::vector::{dot, largest};
use crate::solve::aim::{GROWTH, INSIDE, INSIDE_PARTS, LITTLE, LITTLE_OFF, ROUNDINGS, SMOOTH, grows_to};
use crate::solve::root::{Part, SHORT_PATH, straight};
use crate::systems::linked::flight::{Flight, Landing};
use crate::systems::linked::kept::{Counts, Room};
use crate::systems::network::solver::Solver;
use std::array::from_fn;
use std::mem::swap;

impl<const D: usize> Flight<'_, D> {
    /// Whether a landing that nothing speaks against at the two ends of the step is the right one: where guesses were
    /// off as usual, or else inside. If not, `room.suspect` says which equations look wrong.
    pub(crate) fn is_the_one(
        &self,
        landing: &Landing,
        turn: f64,
        path: f64,
        solver: &Solver<D>,
        room: &mut Room<D>,
        counts: &mut Counts,
    ) -> bool {
        // Where one derivative did not do, slopes differ between the guess and the landing.
        let smooth = landing.one_derivative && turn <= SMOOTH;
        let mut all = true;
        for (row, (aim, &off)) in self.aims.iter().zip(&room.off).enumerate() {
            let usual = (smooth && aim.is_usual(off, self.weights)) || off.abs() <= room.rounding(row);
            room.suspect[row] = !usual;
            all &= usual;
        }
        all || self.looks_right(landing, path, solver, room, counts)
    }

    /// Suspects every equation, by the last guess for the whole step. What is off by little against that is taken for
    /// right: or somewhere in a long chain something would look wrong.
    #[cold]
    pub(crate) fn suspect_all(&self, room: &mut Room<D>) {
        let m = self.rows().equations();
        room.suspect[..m].fill(true);
        room.measure_noise(m);
        self.add_noise(room);
        for row in 0..m {
            // By the normal at the start: that at the guess may be none, and the guess out of where g is a number.
            let off = room.off[row].abs() * (room.lengths[row] / self.steepness(row)).min(1.0);
            room.noise[row] += if off.is_finite() { LITTLE_OFF * off } else { 0.0 };
        }
    }

    /// Strikes off the list what looks right inside the step. True where nothing is left.
    #[cold]
    #[inline(never)]
    fn looks_right(
        &self,
        landing: &Landing,
        path: f64,
        solver: &Solver<D>,
        room: &mut Room<D>,
        counts: &mut Counts,
    ) -> bool {
        let m = self.rows().equations();
        room.measure_noise(m);
        self.strike_off(landing, path, solver, room, counts);
        if (0..m).any(|row| room.suspect[row] && room.off[row].abs() < LITTLE * room.noise[row]) {
            self.add_noise(room);
            self.strike_off(landing, path, solver, room, counts);
        }
        !room.suspects_any(m)
    }

    fn strike_off(
        &self,
        landing: &Landing,
        path: f64,
        solver: &Solver<D>,
        room: &mut Room<D>,
        counts: &mut Counts,
    ) {
        let m = self.rows().equations();
        room.wrong[..m].fill(false);
        room.inner[..m].copy_from_slice(&room.guess[..m]);
        self.turns(1.0, landing, path, solver, room, counts);
        for s in INSIDE {
            room.inner[..m].iter_mut().zip(&room.guess).for_each(|(inner, guess)| *inner = s * s * guess);
            self.look(solver, s, room, counts);
            for row in 0..m {
                room.wrong[row] |= !room.grows(row, s, GROWTH);
            }
        }
        for row in 0..m {
            room.suspect[row] &= room.wrong[row];
        }
    }

    /// Whether what is still on the list looks right inside this part of the step, at whose end the guess was off by
    /// `room.off`.
    pub(crate) fn part_looks_right(
        &self,
        part: &Part<f64>,
        landing: &Landing,
        path: f64,
        solver: &Solver<D>,
        room: &mut Room<D>,
        counts: &mut Counts,
    ) -> bool {
        let m = self.rows().equations();
        room.wrong[..m].fill(false);
        room.go_ahead(part, m);
        self.turns(part.end, landing, part.length * path, solver, room, counts);
        if (0..m).any(|row| room.suspect[row] && room.wrong[row]) {
            return false;
        }
        INSIDE_PARTS.into_iter().all(|(share, powers)| {
            let inner = part.until(share);
            room.go_ahead(&inner, m);
            self.look(solver, inner.end, room, counts);
            (0..m).all(|row| !room.suspect[row] || room.grows(row, share, powers))
        })
    }

    /// Whether `room.y` leads to the place that was found by an attempt that is set aside, but for rounding.
    pub(crate) fn is_same(&self, attempt: usize, solver: &Solver<D>, room: &mut Room<D>) -> bool {
        let (rows, m) = (self.rows(), self.rows().equations());
        for i in 0..m {
            room.dx[i] = room.y[i] - room.tried[attempt][0][i];
        }
        let size = |&body: &usize| f64::max(largest(&self.q[body]), largest(&room.drift[body]));
        let size = rows.bodies.iter().map(size).fold(0.0, f64::max);
        self.length_of_correction(solver, room) <= ROUNDINGS * (m as f64).sqrt() * f64::EPSILON * size
    }

    /// Notes as wrong those whose normals turn so much from the guess `room.inner` to the landing, after the
    /// share s of the step, that a way as long as the path is not short for them.
    fn turns(
        &self,
        s: f64,
        landing: &Landing,
        path: f64,
        solver: &Solver<D>,
        room: &mut Room<D>,
        counts: &mut Counts,
    ) {
        let (rows, m, time) = (self.rows(), self.rows().equations(), self.time + s * self.h);
        for at_landing in [false, true] {
            if !at_landing {
                swap(&mut room.y, &mut room.inner);
            }
            self.place(solver, s, room);
            if !at_landing {
                swap(&mut room.y, &mut room.inner);
            }
            let there = if at_landing { &mut room.blocks } else { &mut room.before };
            let (g, there) = (&mut room.g[..m], &mut there[..rows.blocks()]);
            self.shape.gradients(self.component, time, &room.trial, g, there, &mut room.rates[..m]);
            counts.gradients += 1;
        }
        let most = f64::max(SHORT_PATH * landing.first / path, straight::<f64>());
        for row in 0..m {
            room.wrong[row] |= self.turn(row, room, &room.before) > most;
        }
    }

    /// Evaluates g after the share s of the step, where x is `room.inner`.
    fn look(&self, solver: &Solver<D>, s: f64, room: &mut Room<D>, counts: &mut Counts) {
        swap(&mut room.y, &mut room.inner);
        self.place(solver, s, room);
        swap(&mut room.y, &mut room.inner);
        let m = self.rows().equations();
        self.shape.values(self.component, self.time + s * self.h, &room.trial, &mut room.g[..m]);
        counts.values += 1;
    }

    /// Adds some times the rounding of each g itself: by how much it is no straight line where bodies are moved by some
    /// roundings.
    fn add_noise(&self, room: &mut Room<D>) {
        let (rows, m) = (self.rows(), self.rows().equations());
        let unit = rows.bodies.iter().map(|&body| largest(&self.q[body])).fold(0.0, f64::max) * f64::EPSILON;
        for (n, share) in [0.0].into_iter().chain(SHIFTS).enumerate() {
            for (i, &body) in rows.bodies.iter().enumerate() {
                let shift = if i.is_multiple_of(2) { share * unit } else { -share * unit };
                room.trial[body] = self.q[body].map(|x| x + shift);
                room.lift[body] = from_fn(|d| room.trial[body][d] - self.q[body][d]); // as rounded
            }
            self.shape.values(self.component, self.time, &room.trial, &mut room.g[..m]);
            for row in 0..m {
                let blocks = rows.blocks_of(row);
                let straight: f64 =
                    blocks.map(|(b, body)| dot(&self.blocks[b], &room.lift[rows.bodies[body]])).sum();
                let bent = room.g[row] - straight;
                if n == 0 {
                    (room.inner[row], room.dx[row]) = (bent, 0.0);
                } else {
                    room.dx[row] = f64::max(room.dx[row], (bent - room.inner[row]).abs());
                }
            }
        }
        for row in 0..m {
            room.noise[row] += NOISY * room.dx[row] / self.steepness(row);
        }
    }

    /// |∇gᵢ| where the step begins.
    fn steepness(&self, row: usize) -> f64 {
        let blocks = self.rows().blocks_of(row);
        blocks.map(|(block, _)| dot(&self.blocks[block], &self.blocks[block])).sum::<f64>().sqrt()
    }
}

impl<const D: usize> Room<D> {
    /// The rounding of g of an equation, by that of its coordinates, as a length; some times that.
    fn rounding(&self, row: usize) -> f64 {
        ROUNDINGS / (self.scale[row] * self.lengths[row])
    }

    /// Whether an equation is on the list of suspects.
    pub(crate) fn suspects_any(&self, equations: usize) -> bool {
        self.suspect[..equations].contains(&true)
    }

    /// Sets the noise to the largest rounding of all: where bodies are linked, it reaches an equation whose own
    /// coordinates are zero.
    fn measure_noise(&mut self, equations: usize) {
        let roundings = (0..equations).map(|row| self.rounding(row));
        let largest = roundings.filter(|rounding| rounding.is_finite()).fold(0.0, f64::max);
        self.noise[..equations].fill(largest);
    }

    /// What is to be expected of x at the end of a part.
    fn go_ahead(&mut self, part: &Part<f64>, equations: usize) {
        for i in 0..equations {
            self.inner[i] = self.course[i].ahead(self.guess[i], part);
        }
    }

    /// Whether g of an equation, just evaluated at a share of the way, is what lets expect what the guess was off by at
    /// the end.
    fn grows(&self, row: usize, share: f64, powers: [u32; 2]) -> bool {
        grows_to(self.g[row] / self.lengths[row], self.off[row], share, powers, self.noise[row])
    }
}
