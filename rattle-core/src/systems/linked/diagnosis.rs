//! The reason why a step of linked bodies failed, determined afterwards, so that successful steps do not pay for it.

use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::error::{EquationAt, LinkedFailure, Passing, StepFailure};
use crate::kernel::kinks::Kink;
use crate::motion::bodies::Count;
use crate::motion::failure::Failure;
use crate::number::vector::dot;
use crate::systems::linked::flight::{
    CLEAR, Flight, HALVINGS, LITTLE_SHARE, LOST, Landing, MUCH_SHORTER, SHORT, SOON,
};
use crate::systems::linked::kept::{BodiesOf, Counts, Linked, Room, Tied};
use crate::systems::network::mass::Root;
use crate::systems::network::orthogonal::BRANCHING;
use crate::systems::network::shape::Shape;
use crate::systems::network::solver::Solver;

impl<const D: usize> Flight<'_, D> {
    /// Why the step failed, and what would pass.
    #[cold]
    #[inline(never)]
    pub(crate) fn failure(
        &self,
        solver: &mut Solver<D>,
        turn: f64,
        room: &mut Room<D>,
        landing: Landing,
    ) -> Failure {
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
            return because(LinkedFailure::CannotAct { equation, share }.into());
        }
        let square: f64 = rows.touched_by(row).map(|(block, _)| dot(&blocks[block], &blocks[block])).sum();
        let first = residuals.first().copied().unwrap_or(f64::NAN);
        if !(first.is_finite() && square.is_finite()) && residuals.len() < 2 {
            return because(StepFailure::ConstraintNotFinite { position: self.q[body].to_vec() });
        }
        let path = self.path(room);
        let (mut passing, mut sine_there) = (None, 0.0);
        let mut parts = (self.h, turn);
        for _ in 0..HALVINGS {
            parts = (0.5 * parts.0, 0.5 * parts.1);
            for &body in &rows.bodies {
                room.drift[body] = room.drift[body].map(|x| 0.5 * x);
                room.push[body] = room.push[body].map(|x| 0.25 * x);
            }
            room.guess[..m].iter_mut().for_each(|x| *x *= 0.25);
            let shorter = Flight { h: parts.0, weights: [f64::NAN; 2], ..*self };
            if shorter.solve(solver, parts.1, room, &mut Counts::default()).converged {
                passing = Some(parts.0);
                sine_there = shorter.sine_at_end(solver, room);
                break;
            }
        }
        let much_shorter = passing.is_none_or(|h: f64| h.abs() <= MUCH_SHORTER * self.h.abs());
        let (sine, weakest) = solver.normals(rows, blocks, &self.shape.roots);
        let independent = solver.rank(rows) == m;
        // A solution is near, but within a few such steps normals fall together: it may lie on another branch. Masses
        // of different size make sines small too, which then do not fall.
        let falls = passing.is_none_or(|h| sine <= SOON * self.h / h * (sine - sine_there));
        let ahead = direct.converged && turn < SHORT && sine < f64::min(4.0 * turn, CLEAR) && falls;
        let here = much_shorter && sine < BRANCHING;
        if independent && !rows.acting && (ahead || here) {
            let equation = self.shape.equation_at(self.component, weakest);
            let (body, orthogonal) = (equation.bodies[0], solver.is_orthogonal());
            let cause = LinkedFailure::RankLost { equation, sine, passing, orthogonal };
            return Failure { body, cause: cause.into() };
        }
        let residuals = residuals.into_iter().collect();
        because(if landing.contradictory {
            LinkedFailure::Contradictory { equation, residuals }.into()
        } else {
            let gradient = square.sqrt();
            LinkedFailure::NotSolved {
                equation,
                path,
                residuals,
                gradient,
                turn,
                h: self.h,
                passing: Passing(passing),
            }
            .into()
        })
    }
}

impl<const D: usize> Flight<'_, D> {
    /// The sine of the least independent normal where a solve has ended.
    fn sine_at_end(&self, solver: &mut Solver<D>, room: &mut Room<D>) -> f64 {
        let (rows, m, blocks) = (self.rows(), self.rows().equations(), self.rows().blocks());
        self.place(solver, 1.0, room);
        let (g, there) = (&mut room.g[..m], &mut room.blocks[..blocks]);
        let rates = &mut room.rates[..m];
        self.shape.gradients(self.component, self.time + self.h, &room.trial, g, there, rates);
        solver.normals(rows, there, &self.shape.roots).0
    }
}

impl<Fo, const D: usize> Tied<Fo, D> {
    /// Whether the normals at the new positions are as independent as they were at the start.
    pub(crate) fn check_rank(
        &self,
        shape: &Shape<D>,
        c: usize,
        q: &[[f64; D]],
        (sine, row): (f64, usize),
    ) -> Result<(), Failure> {
        let component = &shape.components[c];
        let lost = match &self.solvers[c] {
            Solver::Elimination(_) => sine < LOST || sine.is_nan(),
            solver => solver.rank(&component.rows) < component.solver.rank(&component.rows),
        };
        if !lost {
            return Ok(());
        }
        let equation = shape.equation_at(c, row);
        let body = equation.bodies[0];
        let first = component.first;
        let blocks = &self.blocks[first.1..first.1 + component.rows.blocks()];
        let square: f64 =
            component.rows.touched_by(row).map(|(block, _)| dot(&blocks[block], &blocks[block])).sum();
        let share = acting_share(shape, c, row, blocks);
        let cause = if !square.is_finite() {
            StepFailure::ConstraintNotFinite { position: q[body].to_vec() }
        } else if component.rows.acting && share < LITTLE_SHARE {
            LinkedFailure::CannotAct { equation, share }.into()
        } else {
            let orthogonal = self.solvers[c].is_orthogonal();
            LinkedFailure::RankLost { equation, sine, passing: None, orthogonal }.into()
        };
        Err(Failure { body, cause })
    }
}

impl<F: Forces<f64, D>, N: Count, const D: usize> Linked<F, N, D> {
    #[cold]
    pub(crate) fn not_finite(&self, bodies: &BodiesOf<F, N, D>, body: usize) -> Failure {
        let q = bodies.q.as_ref();
        let at = Moment { time: bodies.time, positions: q };
        // Links hand a force that is none on to other bodies.
        if let Some(failure) = Failure::of_force(&self.effects, at, self.free()) {
            return failure;
        }
        let (p, position) = (&bodies.p.as_ref()[body], q[body].to_vec());
        let cause = if dot(p, p).is_finite() {
            StepFailure::RanAway { position }
        } else {
            StepFailure::MomentumNotFinite { position }
        };
        Failure { body, cause }
    }

    /// The bodies that are not pinned.
    pub(super) fn free(&self) -> impl Iterator<Item = usize> + '_ {
        let roots = self.shape.roots.iter().enumerate();
        roots.filter(|(_, root)| !matches!(root, Root::Pinned)).map(|(body, _)| body)
    }
}

impl<const D: usize> Shape<D> {
    /// Names an equation.
    pub(crate) fn equation_at(&self, component: usize, row: usize) -> Box<EquationAt> {
        let rows = &self.components[component].rows;
        let (group, member, equation) = rows.find(&self.groups, row);
        Box::new(EquationAt {
            link: self.groups[group].name(),
            group,
            member,
            equation,
            of: self.groups[group].equations(),
            bodies: rows.touched_by(row).map(|(_, body)| body).collect(),
        })
    }
}

/// The normal of a member's equation jumps.
#[cold]
pub(crate) fn kinked<const D: usize>(shape: &Shape<D>, group: usize, member: usize, kink: Kink) -> Failure {
    let links = &shape.groups[group];
    let (touched, arity) = links.bodies();
    let bodies = touched[member * arity..][..arity].to_vec();
    let (link, equation, of, body) = (links.name(), kink.equation, links.equations(), bodies[0]);
    Failure::of_kink(kink, body, Some(Box::new(EquationAt { link, group, member, equation, of, bodies })))
}

/// Writes ∇g of an equation for its bodies.
pub(crate) fn gradient<const D: usize>(
    shape: &Shape<D>,
    &EquationAt { group, member, equation, of, ref bodies, .. }: &EquationAt,
    time: f64,
    q: &[[f64; D]],
    normal: &mut [[f64; D]],
) {
    let arity = bodies.len();
    let (mut g, mut blocks, mut rates) = (vec![0.0; of], vec![[0.0; D]; of * arity], vec![0.0; of]);
    shape.groups[group].gradients(member..member + 1, time, q, &mut g, &mut blocks, &mut rates);
    for (body, block) in bodies.iter().zip(&blocks[equation * arity..]) {
        normal[*body] = *block;
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
