//! A block of trajectories side by side, and the RATTLE step that moves all of them on.
//!
//! ```text
//! q′ = q + h p + Λ ∇g(q)                          Λ such that g(q′) = 0
//! p′ = p + Λ/h ∇g(q) − k ∇U(q′) + ∇g(q′) η        η such that ∇g(q′)·p′ = 0
//! ```
//!
//! Momenta are kept *ahead*: after the first kick of the step to come, and made tangent again. The second kick of a step
//! and the first of the next are then one, of length k. What the projection takes away Λ puts back, so positions are those
//! of RATTLE; [`Block::momentum`] takes the kick back. And they are kept times the length of a step, as the *way* that they
//! lead in it: in a method of equal steps no product is left of h p and Λ/h.
//!
//! **Equal steps need no projection.** The way that is left of a step, h p + Λ ∇g(q), leads along the surface to second
//! order as it is, and what it leads off Λ puts back at once: η is 0, a Λ twice as large. This is how Störmer's and Verlet's
//! method is written with constraints (SHAKE: Ryckaert, Ciccotti, Berendsen 1977); places are those of RATTLE to rounding.
//!
//! **The step in four loops**, plain enough that a compiler vectorises them, and each short: what a processor has in flight
//! at a time is some two hundred instructions, so that a loop takes a time of (its instructions) × (the latency of its longest
//! chain), until its arithmetic alone takes longer. [`guess`] evaluates g and ∇g at Λ₀, extrapolated from the last steps;
//! [`improve`] evaluates g₁ after the Newton step Λ₁ = Λ₀ − g₀/s, s = ∇g(q′)·∇g(q), and goes on to the root of the parabola
//! through g₀, s and g₁,
//!
//! ```text
//! Λ₂ = Λ₁ − (g₁/s) (1 + 2t + 5t² + …),   t = g₁/g₀         (the coefficients: binomials of Catalan's numbers)
//! ```
//!
//! [`examine`] evaluates g and ∇g at Λ₂, and makes the last small correction −g₂/s; [`finish`] makes the new way. Without the
//! third term of the series three times as many steps need a further correction.
//!
//! **Extrapolation** is of Λ|∇g(q)|², a second derivative of g along the path, since Λ itself varies with |∇g| too: with it
//! a third as many steps need a further correction. The last Λ are kept in units of the step to come. What |∇g|² changes by is
//! not waited for: it is (|∇g(q)|²/s)², but for a factor near 1 that is taken from the step before.
//!
//! **Stopping.** A displacement |g|/|∇g| of at most 256 ε|q|∞ is left to the last correction, which leaves what chord steps
//! leave of it, less than rounding does. Where it is larger, the lane is corrected again by itself. The normal is then that
//! of a point less than 256 ε|q|∞ away.
//!
//! **Which root.** |∇g(q)|²/s must be between 2/3 and 2. Lanes where it is not, or that three corrections do not bring to
//! rest, are solved as a [`Simulation`](crate::run::simulation::Simulation) does. Sheets of a surface that lie closer to each
//! other than guesses are off, some part of κ(h|p|)², can still be taken for one another.
//!
//! Every lane is a function of its own past alone.

use crate::kernel::functions::ConstraintKernel;
use crate::number::lanes::Lane;
use crate::number::vector::{add_scaled, dot, scaled, sum, two_sum};
use crate::run::ensemble::laws::Laws;
use crate::run::ensemble::loops::advance;
use crate::run::ensemble::scratch::{
    Part, Scratch, Stuck, Vectors, at, at_rest, is_finite, not_finite, put, total,
};
use crate::systems::surface::normal::Normal;
use std::borrow::Borrow;

/// Trajectories side by side. `SUMS` is 1 if positions and momenta are compensated sums, else 0.
#[derive(Clone)]
#[repr(C, align(64))]
pub(crate) struct Block<S, const L: usize, const D: usize, const SUMS: usize> {
    q: Vectors<S, L, D>,
    /// Momenta, ahead by the first kick of the step to come, times [`Part::unit`].
    way: Vectors<S, L, D>,
    /// ∇g(q): the one of the two that `even` says.
    normal: [Vectors<S, L, D>; 2],
    /// |∇g(q)|².
    square: [S; L],
    /// |∇g(q)|²/|∇g(q′)|² of the last step, by (|∇g(q)|²/s)².
    bias: [S; L],
    /// What |g| may be at rest.
    rest: [S; L],
    /// Λ₀ of the step to come.
    guess: [S; L],
    /// Λ of the last two steps, the last one first, in units of the step to come.
    past: [[S; L]; 2],
    q_low: [Vectors<S, L, D>; SUMS],
    way_low: [Vectors<S, L, D>; SUMS],
    even: bool,
    /// The part of the method's step that comes next.
    part: usize,
}

impl<S: Lane, const L: usize, const D: usize, const SUMS: usize> Block<S, L, D, SUMS> {
    /// A block in which no lane is set.
    pub(crate) fn new() -> Self {
        let zero = [S::default(); L];
        let vectors = [zero; D];
        Self {
            q: vectors,
            way: vectors,
            normal: [vectors; 2],
            square: zero,
            bias: zero,
            rest: zero,
            guess: zero,
            past: [zero; 2],
            q_low: [vectors; SUMS],
            way_low: [vectors; SUMS],
            even: true,
            part: 0,
        }
    }

    /// Puts a trajectory at q with momentum p, which are along the constraint, into a lane; `parts` are those of the
    /// method, of which the block's is to come.
    pub(crate) fn set(
        &mut self,
        lane: usize,
        laws: &impl Laws<S, D>,
        parts: &[Part],
        q: [[S; D]; 2],
        p: [[S; D]; 2],
    ) {
        let (part, constraint) = (&parts[self.part], laws.constraint(lane));
        let (h, unit) = (S::from_f64(part.h), S::from_f64(part.unit));
        let [gradient] = constraint.borrow().jacobian(&q[0]);
        let normal = Normal::new(gradient);
        let pushed = laws.kick(lane, &q[0], S::from_f64(0.5) * h, p[1]);
        let (_, back) = normal.projection(&sum(&p[0], &pushed));
        let (ahead, ahead_low) = two_sum(&p[0], &sum(&pushed, &back));
        let [bend] = constraint.borrow().jet(&q[0], &ahead).2;
        let guess = S::from_f64(-0.5) * h * h * bend * normal.inverse_square;
        // Equal steps: as if one had led here, which would have left half of Λ in the way.
        let equal = Part::are_equal(parts);
        let ahead = if equal { add_scaled(&ahead, -guess / h, &gradient) } else { ahead };
        let guess = if equal { guess + guess } else { guess };
        put(&mut self.q, lane, q[0]);
        put(&mut self.way, lane, scaled(unit, &ahead));
        let way_low = scaled(unit, &ahead_low);
        for (low, x) in self.q_low.iter_mut().zip([q[1]]).chain(self.way_low.iter_mut().zip([way_low])) {
            put(low, lane, x);
        }
        put(&mut self.normal[usize::from(!self.even)], lane, gradient);
        self.square[lane] = dot(&gradient, &gradient);
        self.bias[lane] = S::from_f64(1.0);
        self.rest[lane] = at_rest(&gradient, &q[0]);
        self.guess[lane] = guess;
        for past in &mut self.past {
            past[lane] = S::from_f64(part.before) * guess;
        }
    }

    /// Copies a lane.
    pub(crate) fn copy(&mut self, from: usize, to: usize) {
        let vectors = [&mut self.q, &mut self.way].into_iter().chain(&mut self.normal);
        let vectors = vectors.chain(&mut self.q_low).chain(&mut self.way_low).flatten();
        for numbers in vectors
            .chain([&mut self.square, &mut self.bias, &mut self.rest, &mut self.guess])
            .chain(&mut self.past)
        {
            numbers[to] = numbers[from];
        }
    }

    /// Position of a lane, and what rounding took from it.
    #[inline(always)]
    pub(crate) fn position(&self, lane: usize) -> [[S; D]; 2] {
        [at(&self.q, lane), self.q_low.first().map_or([S::default(); D], |low| at(low, lane))]
    }

    /// Momentum of a lane, and what rounding took from it: with the kick of the step to come taken back, and along the
    /// surface where the trajectory is, not where it was before the last correction.
    #[inline(always)]
    pub(crate) fn momentum(&self, lane: usize, laws: &impl Laws<S, D>, parts: &[Part]) -> [[S; D]; 2] {
        let part = &parts[self.part];
        let over = S::from_f64(1.0 / part.unit);
        let ahead = scaled(over, &at(&self.way, lane));
        let low = self.way_low.first().map_or([S::default(); D], |low| scaled(over, &at(low, lane)));
        let q = at(&self.q, lane);
        let [gradient] = laws.constraint(lane).borrow().jacobian(&q);
        let normal = Normal::new(gradient);
        let kick = S::from_f64(-0.5 * part.h);
        let change = laws.kick(lane, &q, kick, low);
        let (_, back) = normal.projection(&sum(&ahead, &change));
        let (p, low) = two_sum(&ahead, &sum(&change, &back));
        [p, low.map(|x| if SUMS == 0 { S::default() } else { x })]
    }

    /// Positions and momenta of all lanes, see [`momentum`](Self::momentum).
    #[inline(always)]
    pub(crate) fn all(&self, laws: &impl Laws<S, D>, parts: &[Part]) -> (Vectors<S, L, D>, Vectors<S, L, D>) {
        let mut momenta = [[S::default(); L]; D];
        for lane in 0..L {
            let [p, _] = self.momentum(lane, laws, parts);
            put(&mut momenta, lane, p);
        }
        (self.q, momenta)
    }

    /// Whether all momenta are numbers.
    #[inline(always)]
    pub(crate) fn check(&self, laws: &impl Laws<S, D>) -> Result<(), Stuck> {
        for lane in 0..L {
            if !is_finite(total(&at(&self.way, lane))) {
                return Err(Stuck { lane, failure: not_finite(laws, lane, at(&self.q, lane)) });
            }
        }
        Ok(())
    }

    /// Moves all lanes through the next part of a step; `EQUAL` says that all parts are of one length. Where one cannot be
    /// moved the block is left half way.
    #[inline(always)]
    pub(crate) fn advance<const EQUAL: bool>(
        &mut self,
        laws: &impl Laws<S, D>,
        parts: &[Part],
        scratch: &mut Scratch<S, L, D>,
    ) -> Result<(), Stuck> {
        let part = &parts[self.part];
        let [even, odd] = &mut self.normal;
        let (q, way, low) = (&mut self.q, &mut self.way, (&mut self.q_low, &mut self.way_low));
        let (square, bias, rest) = (&mut self.square, &mut self.bias, &mut self.rest);
        let (guess, past) = (&mut self.guess, &mut self.past);
        // Written out twice, since compilers must see which of the two is read and which is written.
        if self.even {
            let normal = (&*even, odd);
            advance::<S, L, D, SUMS, EQUAL>(
                laws, part, q, way, low, normal, square, bias, rest, guess, past, scratch,
            )?;
        } else {
            let normal = (&*odd, even);
            advance::<S, L, D, SUMS, EQUAL>(
                laws, part, q, way, low, normal, square, bias, rest, guess, past, scratch,
            )?;
        }
        self.even = !self.even;
        self.part = if self.part + 1 == parts.len() { 0 } else { self.part + 1 };
        Ok(())
    }
}
