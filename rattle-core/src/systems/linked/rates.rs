//! Rates of change of linked bodies, and projection onto their constraints.

use crate::effect::force::Force;
use crate::effect::list::Forces;
use crate::error::{MethodFailure, StepFailure};
use crate::motion::bodies::Count;
use crate::motion::capability::Rates;
use crate::motion::failure::Failure;
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::vector::{largest, sum, two_sum};
use crate::solve::nearing::Nearing;
use crate::solve::stop::NOISE;
use crate::systems::linked::kept::{BodiesOf, Furthest, Kept, Linked, Tied};
use crate::systems::linked::pull::Pull;

impl<F: Forces<f64, D>, N: Count, const D: usize> Rates<N, Kept<F, D>, f64, D> for Linked<F, N, D> {
    fn evaluate_rates<W: Witness<f64>>(
        &self,
        bodies: &mut BodiesOf<F, N, D>,
        rates: &mut [[f64; D]],
        witness: &mut W,
    ) -> f64 {
        let shape = &*self.shape;
        bodies.kept.tied.lend_normals(shape, bodies.time, bodies.q.as_ref());
        let Kept { tied, .. } = &mut bodies.kept;
        let Tied { force, blocks, rates: moving, solvers, room, .. } = tied;
        for (body, root) in shape.roots.iter().enumerate() {
            rates[body] = force[body].components();
            room.velocity[body] = root.velocity(&bodies.p.as_ref()[body]);
            room.push[body] = root.velocity(&rates[body]);
        }
        let mut power = bodies.power;
        for (c, component) in shape.components.iter().enumerate() {
            let (rows, solver, (row, block)) = (&component.rows, &mut solvers[c], component.first);
            let m = rows.equations();
            let blocks = &blocks[block..block + rows.blocks()];
            let (bends, turns) = (&mut room.g[..m], &mut room.dx);
            shape.bends(c, bodies.time, bodies.q.as_ref(), &room.velocity, bends, turns);
            bends.iter_mut().for_each(|bend| *bend = -*bend);
            let x = &mut room.x[row..row + m];
            let pull = Pull { rows, roots: &shape.roots, blocks, changes: bends };
            let of_rows = [x, &mut room.guess[..m], &mut room.dx[..m]];
            pull.add(solver, rates, &mut room.push, of_rows);
            let x = &room.x[row..row + m];
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
        bodies.kept.tied.leave_rows(shape, bodies.time, bodies.q.as_ref());
        for (body, root) in shape.roots.iter().enumerate() {
            bodies.kept.tied.room.velocity[body] = root.velocity(&bodies.p.as_ref()[body]);
        }
        for (c, component) in shape.components.iter().enumerate() {
            let rows = &component.rows;
            let moves = rows.bodies.iter().map(|&body| largest(&bodies.kept.tied.room.velocity[body]));
            let path = h.abs() * moves.fold(0.0, f64::max);
            let long = NOISE * (rows.equations() as f64).sqrt(); // roundings of a chain add up along it
            let mut nearing = Nearing::leaving(0.25); // from afar Newton's method goes half of the way each time
            loop {
                let (q, time) = (bodies.q.as_ref(), bodies.time);
                let found = bodies.kept.tied.normals(shape, c, time, q);
                // In roundings of the places alone: a velocity that has run away must not make up for the distance.
                let Furthest { distance, roundings, of_all, row: worst } = self.furthest(c, 0.0, bodies);
                let (arrived, lost) = nearing.look(distance, roundings <= 1.0, of_all <= long);
                let arrived = arrived || (lost && self.is_rounding(c, worst, distance, bodies));
                if arrived {
                    bodies.kept.tied.check_rank(shape, c, bodies.q.as_ref(), found)?;
                    break;
                }
                if lost {
                    let body = shape.equation_at(c, worst).bodies[0];
                    return Err(if distance.is_finite() {
                        Failure { body, cause: MethodFailure::NotProjected { distance, path }.into() }
                    } else {
                        let position = bodies.q.as_ref()[body].to_vec();
                        Failure { body, cause: StepFailure::ConstraintNotFinite { position } }
                    });
                }
                let (m, (_, block)) = (rows.equations(), component.first);
                let Tied { blocks, solvers, room, .. } = &mut bodies.kept.tied;
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

    fn mass_product(&self, body: usize, a: &[f64; D], b: &[f64; D]) -> f64 {
        self.shape.roots[body].product(a, b)
    }
}
