//! A component of few equations in one go: what [`Flight`] and [`Linked`](crate::systems::linked::kept::Linked) do verb
//! by verb in vectors, with [sizes known when this is compiled](crate::systems::network::dense).
//!
//! Only the plain case is here: Newton's method from g̈ = 0 that ends with one derivative, at a root that nothing
//! speaks against. Whatever else happens, [`Flight`] goes on from here, or begins again.

use crate::effect::force::Force;
use crate::kernel::rounding::size_of_terms;
use crate::motion::failure::Failure;
use crate::number::vector::{add_scaled, dot, larger, size as largest, sum, two_sum};
use crate::solve::aim::{Aim, ROUNDINGS, SMOOTH};
use crate::solve::root::FAR_GUESS;
use crate::solve::stop::{SPARE, Shrinking, over_rounding};
use crate::systems::linked::flight::{CONTRACTION, Flight, Landing, MAX_CORRECTIONS};
use crate::systems::linked::kept::{Counts, Room};
use crate::systems::linked::moving::Moving;
use crate::systems::network::dense::{Column, Dense, MOST, combined, invert, products, sized, times};
use crate::systems::network::rows::Rows;
use crate::systems::network::shape::Shape;
use crate::systems::network::solver::{CLEARLY, Solver};
use std::array::from_fn;

/// One component on its way, and the numbers that its step changes.
pub(super) struct Few<'a, 'b, Fo, const D: usize> {
    pub(super) shape: &'a Shape<D>,
    pub(super) component: usize,
    pub(super) moving: &'a mut Moving<'b, D>,
    pub(super) force: &'a [Fo],
    /// ∂g/∂q of the component at the positions, in blocks.
    pub(super) blocks: &'a mut [[f64; D]],
    pub(super) aims: &'a mut [Aim<f64>],
    pub(super) weights: [f64; 2],
    pub(super) kick: f64,
    pub(super) h: f64,
    pub(super) time: f64,
}

/// What was found.
struct Found<const M: usize, const N: usize, const D: usize> {
    landing: Landing,
    corrections: u64,
    /// Whether nothing speaks against it.
    plain: bool,
    /// |∇²g v|² and |∇g|² of each equation.
    turns: [(f64, f64); M],
    guess: Column<M>,
    x: Column<M>,
    off: Column<M>,
    lengths: Column<M>,
    scale: Column<M>,
    /// How far each body goes without the constraints.
    free: [[f64; D]; N],
}

/// The bodies' places, or what else there is of them.
#[inline(always)]
fn gather<X: Copy, const N: usize>(bodies: &[usize; N], of_all: &[X]) -> [X; N] {
    bodies.map(|body| of_all[body])
}

impl<Fo: Force<f64, D>, const D: usize> Few<'_, '_, Fo, D> {
    /// Kicks and moves the bodies, and takes the normals over.
    pub(super) fn drift(
        &mut self,
        solver: &mut Solver<D>,
        room: &mut Room<D>,
        counts: &mut Counts,
    ) -> Result<(), Failure> {
        let sizes = solver.dense().map_or((0, 0), |dense| dense.sizes());
        sized!(sizes, M, N, self.drift_in::<M, N>(solver, room, counts), Ok(()))
    }

    #[inline(never)]
    fn drift_in<const M: usize, const N: usize>(
        &mut self,
        solver: &mut Solver<D>,
        room: &mut Room<D>,
        counts: &mut Counts,
    ) -> Result<(), Failure> {
        let rows = &self.shape.components[self.component].rows;
        let (Some(dense), Ok(bodies)) = (solver.dense(), <&[usize; N]>::try_from(&rows.bodies[..])) else {
            return Ok(());
        };
        let found = self.find::<M, N>(bodies, dense);
        let mut x = found.x;
        if found.plain {
            counts.corrections += found.corrections;
            counts.values += found.corrections;
            counts.gradients += 1;
            self.aims.iter_mut().zip(found.off).for_each(|(aim, off)| aim.note(off));
        } else {
            self.look_again(&found, solver, room, counts)?;
            x.copy_from_slice(&room.y[..M]);
        }
        let row = self.shape.components[self.component].first.0;
        room.x[row..row + M].copy_from_slice(&x);

        let Some(dense) = solver.dense() else { return Ok(()) };
        let (impulses, lifted) = (x.map(|x| x / self.h), dense.lifted::<M, N>());
        for b in 0..N {
            let body = bodies[b];
            let lift = sum(&found.free[b], &combined(&lifted, &x, b));
            let Moving { q, q_low, p, p_low } = &mut *self.moving;
            let change = self.force[body].add_to(p_low[body], self.kick);
            let change = sum(&change, &dense.pull(&impulses, b));
            (q[body], q_low[body]) = two_sum(&q[body], &sum(&q_low[body], &lift));
            (p[body], p_low[body]) = two_sum(&p[body], &change);
            dense.places[b] = q[body];
        }
        dense.gradients::<true>(self.time + self.h);
        dense.write_blocks(self.blocks);
        let ([pivots, diagonal], mut clear) = (dense.take::<M, N>(), true);
        for i in 0..M {
            clear &= pivots[i] > CLEARLY * CLEARLY * diagonal[i] && pivots[i] < f64::INFINITY;
        }
        if !clear {
            self.normals(rows, solver);
        }
        Ok(())
    }

    #[cold]
    #[inline(never)]
    fn normals(&self, rows: &Rows, solver: &mut Solver<D>) {
        solver.normals(rows, self.blocks, &self.shape.roots);
    }

    /// Solves the position equation.
    #[inline(always)]
    fn find<const M: usize, const N: usize>(
        &self,
        bodies: &[usize; N],
        dense: &mut Dense<D>,
    ) -> Found<M, N, D> {
        let h = self.h;
        let (q, q_low) = (gather(bodies, self.moving.q), gather(bodies, self.moving.q_low));
        let (p, p_low, force) =
            (gather(bodies, self.moving.p), gather(bodies, self.moving.p_low), gather(bodies, self.force));
        let lifted = dense.lifted::<M, N>();
        let (mut push, mut free, mut sizes) = ([[0.0; D]; N], [[0.0; D]; N], [[0.0; D]; N]);
        let mut path = 0.0;
        for b in 0..N {
            let (over, force) = (&dense.over_masses[b], force[b].add_to([0.0; D], h * self.kick));
            let (mut v, mut drift) = (p[b], p_low[b]);
            for d in 0..D {
                v[d] *= over[d];
                drift[d] = h * v[d] + h * (over[d] * drift[d]);
                push[b][d] = over[d] * force[d];
            }
            free[b] = sum(&drift, &push[b]);
            sizes[b] = from_fn(|d| larger(q[b][d].abs(), larger(drift[d].abs(), push[b][d].abs())));
            path = larger(path, largest(&drift) + largest(&push[b]));
            (dense.places[b], dense.velocities[b]) = (q[b], v);
        }

        // The first guess, from g̈ = 0.
        dense.bends(self.time);
        let (mut bends, mut turns, mut smooth) = ([0.0; M], [(0.0, 0.0); M], true);
        for i in 0..M {
            let (mut square, mut along) = (0.0, 0.0);
            for b in 0..N {
                let normal = &dense.start[i].blocks[b];
                square += dot(normal, normal);
                along += dot(normal, &push[b]);
            }
            bends[i] = -0.5 * h * h * dense.trial[i].value - along;
            turns[i] = (dense.trial[i].turn, square);
            smooth &= h * h * dense.trial[i].turn <= SMOOTH * SMOOTH * square;
        }
        let guess = times(&dense.at_start, &bends);

        let (mut lift, time) = (free, self.time + h);
        for b in 0..N {
            lift[b] = sum(&free[b], &combined(&lifted, &guess, b));
            dense.places[b] = sum(&q[b], &sum(&q_low[b], &lift[b]));
            sizes[b] = from_fn(|d| larger(sizes[b][d], dense.places[b][d].abs()));
        }
        dense.gradients::<false>(time);
        let mut inverse = [[0.0; MOST]; MOST];
        let pivots = invert(&products(&dense.trial, &lifted), &mut inverse);
        let mut upright = true;
        for pivot in pivots {
            upright &= pivot > 0.0;
        }
        let (mut g, mut lengths, mut scale, mut off) = ([0.0; M], [0.0; M], [0.0; M], [0.0; M]);
        for i in 0..M {
            let (mut along, mut most) = (dense.along_pins::<N>(i), dense.pinned[i]);
            for b in 0..N {
                for d in 0..D {
                    along += dense.trial[i].blocks[b][d].abs() * sizes[b][d];
                    most = larger(most, dense.touches[i][b] * sizes[b][d]);
                }
            }
            g[i] = dense.trial[i].value;
            lengths[i] = dense.square::<N>(i).sqrt();
            let size = size_of_terms(along, path * lengths[i], most * lengths[i]);
            scale[i] = over_rounding(larger(size, g[i].abs()));
            off[i] = g[i] / lengths[i];
        }

        let mut landing = Landing::from(upright);
        let (mut shrinking, mut residual) = (Shrinking::start(), worst(&g, &scale));
        let (mut x, mut corrections) = (guess, 0);
        while corrections < MAX_CORRECTIONS as u64 && residual.is_finite() {
            let (dx, mut longest) = (times(&inverse, &g), 0.0);
            for i in 0..M {
                x[i] -= dx[i];
            }
            for b in 0..N {
                let way = combined(&lifted, &dx, b);
                longest = larger(longest, largest(&way));
                lift[b] = add_scaled(&lift[b], -1.0, &way);
            }
            corrections += 1;
            if corrections == 1 {
                landing.first = longest;
            }
            let (_, left) = shrinking.note(residual);
            if residual <= 1.0 || left <= SPARE {
                landing.converged = true;
                break;
            }
            for b in 0..N {
                dense.places[b] = sum(&q[b], &sum(&q_low[b], &lift[b]));
            }
            dense.values(time);
            for i in 0..M {
                g[i] = dense.trial[i].value;
            }
            let last = residual;
            residual = worst(&g, &scale);
            if residual > CONTRACTION * last {
                break;
            }
        }
        let mut plain = landing.converged && upright && smooth && landing.first <= FAR_GUESS * path;
        for (i, aim) in self.aims.iter().take(M).enumerate() {
            let is_rounding = off[i].abs() * (scale[i] * lengths[i]) <= ROUNDINGS;
            plain &= aim.is_usual(off[i], self.weights) | is_rounding;
        }
        Found { landing, corrections, plain, turns, guess, x, off, lengths, scale, free }
    }

    /// Where the plain case does not hold: looks inside the step, or solves again as a [`Flight`].
    #[cold]
    #[inline(never)]
    fn look_again<const M: usize, const N: usize>(
        &mut self,
        found: &Found<M, N, D>,
        solver: &mut Solver<D>,
        room: &mut Room<D>,
        counts: &mut Counts,
    ) -> Result<(), Failure> {
        let Self { shape, component, ref moving, ref blocks, ref aims, weights, time, h, .. } = *self;
        let (q, q_low) = (&*moving.q, &*moving.q_low);
        for &body in &shape.components[component].rows.bodies {
            let (root, p, p_low) = (&shape.roots[body], &moving.p[body], &moving.p_low[body]);
            room.set_out(body, [h, self.kick], root, [p, p_low], &self.force[body]);
        }
        let flight = Flight { shape, component, q, q_low, blocks, aims, weights, time, h };
        let ratio = |largest: f64, &(turn, square): &(f64, f64)| {
            let ratio = turn / square;
            if ratio > largest || ratio.is_nan() { ratio } else { largest }
        };
        let turn = h.abs() * found.turns.iter().fold(0.0, ratio).sqrt();
        let landing = if found.landing.converged {
            room.guess[..M].copy_from_slice(&found.guess);
            room.y[..M].copy_from_slice(&found.x);
            room.off[..M].copy_from_slice(&found.off);
            room.lengths[..M].copy_from_slice(&found.lengths);
            room.scale[..M].copy_from_slice(&found.scale);
            counts.corrections += found.corrections;
            counts.values += found.corrections;
            counts.gradients += 1;
            flight.find_from(found.landing, turn, solver, room, counts)?
        } else {
            flight.find(solver, room, counts)?
        };
        for (aim, &off) in self.aims.iter_mut().zip(&room.off) {
            aim.note(if landing.aimed { off } else { f64::NAN });
        }
        Ok(())
    }
}

/// The momenta of a component.
pub(super) struct Momenta<'a, Fo, const D: usize> {
    pub(super) bodies: &'a [usize],
    pub(super) q: &'a [[f64; D]],
    pub(super) p: &'a mut [[f64; D]],
    pub(super) p_low: &'a mut [[f64; D]],
    pub(super) force: &'a [Fo],
    pub(super) kick: f64,
}

impl<Fo: Force<f64, D>, const D: usize> Momenta<'_, Fo, D> {
    /// Kicks them and makes them tangent; writes the multipliers. Returns the sum of the squares of places and momenta.
    pub(super) fn settle(&mut self, dense: &Dense<D>, multipliers: &mut [f64]) -> f64 {
        sized!(dense.sizes(), M, N, self.settle_in::<M, N>(dense, multipliers), 0.0)
    }

    #[inline(never)]
    fn settle_in<const M: usize, const N: usize>(
        &mut self,
        dense: &Dense<D>,
        multipliers: &mut [f64],
    ) -> f64 {
        let Ok(bodies) = <&[usize; N]>::try_from(self.bodies) else { return 0.0 };
        let (q, p) = (gather(bodies, self.q), gather(bodies, self.p));
        let (low, force) = (gather(bodies, self.p_low), gather(bodies, self.force));
        let lifted = dense.lifted::<M, N>();
        let (mut changes, mut total) = (low, [0.0; M]);
        for b in 0..N {
            changes[b] = force[b].add_to(low[b], self.kick);
        }
        for round in 0..2 {
            let (mut needed, mut small) = ([0.0; M], round == 1);
            for i in 0..M {
                let (mut rates, mut sizes) = ([0.0; D], [0.0; D]);
                for b in 0..N {
                    for d in 0..D {
                        let product = lifted[i][b][d] * (p[b][d] + changes[b][d]);
                        (rates[d], sizes[d]) = (rates[d] + product, sizes[d] + product.abs());
                    }
                }
                let (mut rate, mut size) = (rates[0], sizes[0]);
                for d in 1..D {
                    (rate, size) = (rate + rates[d], size + sizes[d]);
                }
                needed[i] = -rate;
                small &= rate.abs() <= 2.0 * f64::EPSILON * size;
            }
            // The second time takes what rounding left, if it left more than comes from forming the rates.
            if small {
                break;
            }
            let x = times(&dense.at_start, &needed);
            for i in 0..M {
                total[i] += x[i];
            }
            for b in 0..N {
                changes[b] = sum(&changes[b], &dense.pull(&x, b));
            }
        }
        let mut size = 0.0;
        for b in 0..N {
            let (high, low) = two_sum(&p[b], &changes[b]);
            (self.p[bodies[b]], self.p_low[bodies[b]]) = (high, low);
            size += dot(&high, &high) + dot(&q[b], &q[b]);
        }
        multipliers.copy_from_slice(&total);
        size
    }
}

/// The largest residual in units of its rounding; NaN if one is.
#[inline(always)]
fn worst<const M: usize>(g: &Column<M>, scale: &Column<M>) -> f64 {
    let (mut worst, mut total) = (0.0_f64, 0.0);
    for i in 0..M {
        let ratio = if g[i] == 0.0 { 0.0 } else { g[i].abs() * scale[i] };
        worst = if worst < ratio { ratio } else { worst };
        total += ratio; // NaN if one is
    }
    if total.is_nan() { f64::NAN } else { worst }
}
