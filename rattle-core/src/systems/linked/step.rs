//! One step of linked bodies, whatever the effects are.

use crate::effect::force::Force;
use crate::motion::failure::Failure;
use crate::motion::iteration::{Iteration, Kind};
use crate::motion::witness::Witness;
use crate::number::vector::{dot, sum, two_sum};
use crate::systems::linked::few::{Few, Momenta};
use crate::systems::linked::flight::Flight;
use crate::systems::linked::kept::{Room, Tied, fall_short};
use crate::systems::linked::moving::Moving;
use crate::systems::linked::pull::Rounds;
use crate::systems::linked::strip::{self, Strip};
use crate::systems::network::shape::Shape;

impl<Fo: Force<f64, D>, const D: usize> Tied<Fo, D> {
    /// Kicks and moves the bodies by a step of h: by any iteration from any guess of λ, or if that is empty from g̈ =
    /// 0. Adds to the time, and to the work of constraints that move.
    #[inline(never)]
    pub(super) fn drift<X: Iteration, W: Witness<f64>>(
        &mut self,
        shape: &Shape<D>,
        [h, kick]: [f64; 2],
        guess: &[f64],
        moving: &mut Moving<'_, D>,
        [time, work]: [&mut f64; 2],
        witness: &mut W,
    ) -> Result<(), Failure> {
        let by_default = X::KIND == Kind::Newton && guess.is_empty();
        if !by_default {
            self.leave_rows(shape, *time, moving.q);
        }
        let Self { force, blocks, rates, solvers, counts, room, aims, pace, in_rows, .. } = &mut *self;
        let weights = pace.weights(h);
        pace.note(h);
        shape.pins.iter().for_each(|&(body, _)| room.trial[body] = moving.q[body]);
        for &body in &shape.loose {
            let Moving { q, q_low, p, p_low } = &mut *moving;
            room.set_out(body, [h, kick], &shape.roots[body], [&p[body], &p_low[body]], &force[body]);
            let lift = sum(&room.drift[body], &room.push[body]);
            (q[body], q_low[body]) = two_sum(&q[body], &sum(&q_low[body], &lift));
            (p[body], p_low[body]) = two_sum(&p[body], &force[body].add_to(p_low[body], kick));
        }
        if by_default && in_rows.any() {
            let [solves, corrections] =
                in_rows.drift(shape, [h, kick], weights, moving, (force, blocks), solvers, aims, witness);
            counts.take_rows(solves, corrections);
        }
        for &c in in_rows.left() {
            let component = &shape.components[c];
            let (rows, solver) = (&component.rows, &mut solvers[c]);
            let ((row, block), m, time) = (component.first, rows.equations(), *time);
            let (all, own) = (block..block + rows.blocks(), row..row + m);
            let (blocks, rates, aims) = (&mut blocks[all], &mut rates[own.clone()], &mut aims[own.clone()]);
            counts.solves += 1;
            let few = by_default && solver.dense().is_some();
            if few {
                Few { shape, component: c, moving, force, blocks, aims, weights, kick, h, time }
                    .drift(solver, room, counts)?;
            } else {
                let Moving { q, q_low, p, p_low } = &mut *moving;
                if let (Some(line), Some(over)) = (&rows.line, &shape.over_masses) {
                    strip::set_out(line.bodies(m), [h, kick], over, [p, p_low], force, room);
                } else {
                    for &body in &rows.bodies {
                        room.set_out(
                            body,
                            [h, kick],
                            &shape.roots[body],
                            [&p[body], &p_low[body]],
                            &force[body],
                        );
                    }
                }
                let flight = Flight { shape, component: c, q, q_low, blocks, aims, weights, time, h };
                let landing = if by_default {
                    flight.find(solver, room, counts)?
                } else {
                    flight.try_to_solve::<X>(guess, solver, room, counts)?
                };
                for (aim, &off) in aims.iter_mut().zip(&room.off) {
                    aim.note(if landing.aimed { off } else { f64::NAN });
                }
                room.x[own.clone()].copy_from_slice(&room.y[..m]);
                if let (Some(line), Some(elimination)) = (&rows.line, solver.elimination_mut()) {
                    let bodies = [&mut **q, &mut **q_low, &mut **p, &mut **p_low];
                    strip::advance(line, elimination, [h, kick], bodies, force, room, own.clone());
                } else {
                    let Room { drift, push, x, dx, .. } = &mut *room;
                    let (x, dx) = (&x[own.clone()], &mut dx[..m]);
                    solver.moves(rows, &shape.roots, h, x, dx, |body, way, impulse| {
                        let lift = sum(&sum(&drift[body], &push[body]), way);
                        let change = sum(&force[body].add_to(p_low[body], kick), impulse);
                        (q[body], q_low[body]) = two_sum(&q[body], &sum(&q_low[body], &lift));
                        (p[body], p_low[body]) = two_sum(&p[body], &change);
                    });
                }
            }
            if W::LISTENS || rows.moving {
                if few {
                    // Its normals, and so its basis, are those of the end already.
                    room.dx[..m].copy_from_slice(&room.x[own]);
                } else {
                    solver.multipliers(&room.x[own], &mut room.dx[..m]);
                }
                for (row, displacement) in room.dx[..m].iter().enumerate() {
                    *work -= displacement / h * rates[row];
                    let multiplier = displacement / (h * (0.5 * h));
                    witness.position_multiplier(rows.equation(row), multiplier);
                }
            }
        }
        *time += h;
        for c in 0..shape.components.len() {
            if by_default && self.solvers[c].dense().is_some() {
                continue; // its normals are taken over
            }
            let found = self.normals(shape, c, *time, moving.q);
            self.check_rank(shape, c, moving.q, found)?;
        }
        if by_default && self.in_rows.any() {
            self.in_rows.take_back(shape, &mut self.solvers, moving.q);
        }
        Ok(())
    }

    /// Kicks the bodies at q and makes momenta tangent, after a step of h. Where one is no number then, or none was,
    /// its body is told.
    #[inline(never)]
    pub(super) fn settle<W: Witness<f64>>(
        &mut self,
        shape: &Shape<D>,
        [h, kick]: [f64; 2],
        q: &[[f64; D]],
        [p, p_low]: [&mut [[f64; D]]; 2],
        work: &mut f64,
        witness: &mut W,
    ) -> Result<(), usize> {
        let Self { force, blocks, rates, solvers, room, in_rows, .. } = self;
        let roots = &shape.roots;
        // Also of places: free bodies have no constraint that would miss them.
        let size = |p: &[f64; D], q: &[f64; D]| dot(p, p) + dot(q, q);
        let mut total_size = 0.0;
        for &body in &shape.loose {
            (p[body], p_low[body]) = two_sum(&p[body], &force[body].add_to(p_low[body], kick));
            total_size += size(&p[body], &q[body]);
        }
        if in_rows.any() {
            total_size += in_rows.settle(shape, [h, kick], [p, p_low], force, (solvers, q), witness);
        }
        for &c in in_rows.left() {
            let component = &shape.components[c];
            let (rows, solver) = (&component.rows, &mut solvers[c]);
            let ((row, block), m) = (component.first, rows.equations());
            let (needed, x, total) = (&mut room.g[..m], &mut room.dx[..m], &mut room.x[row..row + m]);
            if let Some(dense) = solver.dense() {
                let mut momenta = Momenta { bodies: &rows.bodies, q, p, p_low, force, kick };
                total_size += momenta.settle(dense, total);
            } else if let (Some(line), Some(elimination), false) =
                (&rows.line, solver.elimination_mut(), rows.acting || rows.moving)
            {
                let change = &mut room.trial;
                let mut strip = Strip { line, q, p, p_low, force, change, kick };
                total_size += strip.settle(elimination, needed, x, total);
            } else {
                let (change, velocity) = (&mut room.trial, &mut room.velocity);
                let (blocks, rates) = (&blocks[block..block + rows.blocks()], &rates[row..row + m]);
                for &body in &rows.bodies {
                    change[body] = force[body].add_to(p_low[body], kick);
                    velocity[body] = roots[body].velocity(&sum(&p[body], &change[body]));
                }
                total.fill(0.0);
                let mut rounds = Rounds::begin();
                while rounds.has_another(solver.is_lossy()) {
                    // The second time takes what rounding left, if it left more than comes from forming the rates.
                    let settled = match (rounds.is_first(), rows.width()) {
                        (true, 2) => fall_short::<false, 2, D>(rows, blocks, rates, velocity, needed),
                        (true, _) => fall_short::<false, 0, D>(rows, blocks, rates, velocity, needed),
                        (_, 2) => fall_short::<true, 2, D>(rows, blocks, rates, velocity, needed),
                        _ => fall_short::<true, 0, D>(rows, blocks, rates, velocity, needed),
                    };
                    if settled {
                        break;
                    }
                    solver.respond(rows, blocks, roots, needed, x);
                    if !rounds.takes(x, needed) {
                        break;
                    }
                    solver.pushes(rows, roots, 1.0, x, |body, impulse| {
                        change[body] = sum(&change[body], &impulse);
                        velocity[body] = roots[body].velocity(&sum(&p[body], &change[body]));
                    });
                    total.iter_mut().zip(x.iter()).for_each(|(total, x)| *total += x);
                }
                for &body in &rows.bodies {
                    (p[body], p_low[body]) = two_sum(&p[body], &change[body]);
                    total_size += size(&p[body], &q[body]);
                }
            }
            if W::LISTENS || rows.moving {
                let rates = &rates[row..row + m];
                solver.multipliers(total, x);
                for (i, impulse) in x.iter().enumerate() {
                    *work -= impulse * rates[i];
                    witness.momentum_multiplier(rows.equation(i), impulse / (0.5 * h));
                }
            }
        }
        if !total_size.is_finite()
            && let Some(body) = (0..p.len()).find(|&body| !size(&p[body], &q[body]).is_finite())
        {
            return Err(body);
        }
        Ok(())
    }
}
