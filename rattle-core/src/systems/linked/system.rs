//! The operations of a [`System`] for bodies linked by a [network](crate::systems::network) of any number of
//! constraints, with any masses.

use crate::effect::interval::Inertia;
use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::error::{Error, RecordMistake, StepFailure};
use crate::kernel::series::NO_SERIES;
use crate::motion::affected::Affected;
use crate::motion::bodies::{Bodies, Body, Count, Saved};
use crate::motion::failure::Failure;
use crate::motion::guarded::Guarded;
use crate::motion::iteration::Iteration;
use crate::motion::measured::Measured;
use crate::motion::parts::Parts;
use crate::motion::record::{Reading, Record};
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::vector::add_scaled;
use crate::solve::aim::{Aim, Pace};
use crate::solve::crowd::Asked;
use crate::systems::linked::diagnosis::{gradient, kinked};
use crate::systems::linked::kept::{BodiesOf, Counts, Kept, Linked, Tied, along};
use crate::systems::linked::moving::Moving;
use crate::systems::network::shape::Shape;

/// The error of a checkpoint whose run had another linear algebra.
#[cold]
fn chosen_otherwise() -> Error {
    let part = "linear algebra, which links choose at the start".into();
    let [file, here] = ["a run from another start", "a start where normals are more, or less, independent"];
    Error::Record(RecordMistake::Another { part, file: file.into(), here: here.into() })
}

impl<F: Forces<f64, D>, N: Count, const D: usize> Linked<F, N, D> {
    /// Takes the normals of all components over where bodies are, by one of the ways to do so.
    #[inline(always)]
    fn take_normals<R>(
        &self,
        bodies: &mut BodiesOf<F, N, D>,
        normals: impl Fn(&mut Tied<F::Force, D>, &Shape<D>, usize, f64, &[[f64; D]]) -> R,
    ) {
        let Bodies { q, time, kept: Kept { tied, .. }, .. } = bodies;
        tied.aims.fill(Aim::unknown());
        for c in 0..self.shape.components.len() {
            normals(tied, &self.shape, c, *time, q.as_ref());
        }
        tied.in_rows.forget();
    }
}

impl<F: Forces<f64, D>, N: Count, const D: usize> Parts<f64, D> for Linked<F, N, D> {
    type Count = N;
    type Kept = Kept<F, D>;
    type Effects = F;

    fn kind(&self) -> &'static str {
        "linked bodies"
    }

    fn equations(&self) -> usize {
        self.shape.equations
    }

    fn constraints_move(&self) -> bool {
        self.shape.moving
    }

    fn effects(&self) -> &F {
        &self.effects
    }

    fn room_of(kept: &mut Kept<F, D>) -> &mut F::Room {
        &mut kept.of_effects
    }

    fn forces_of(kept: &Kept<F, D>) -> &[F::Force] {
        &kept.tied.force
    }

    fn bodies(&self, places: &[Body<f64, D>], time: f64) -> BodiesOf<F, N, D> {
        let (shape, n) = (&self.shape, self.count.number());
        let of_effects = self.effects.room(n);
        let kept = Kept { tied: Tied::new(shape, n), of_effects, stages: None, series: None };
        let mut bodies = Bodies::new(self.count, kept, places, time);
        for &(body, at) in &shape.pins {
            (bodies.q.as_mut()[body], bodies.q_low.as_mut()[body]) = (at, [0.0; D]);
        }
        self.refresh(&mut bodies);
        bodies
    }

    fn refresh(&self, bodies: &mut BodiesOf<F, N, D>) {
        self.take_normals(bodies, Tied::normals);
        self.evaluate_forces(bodies);
    }

    fn refresh_off(&self, bodies: &mut BodiesOf<F, N, D>) {
        self.take_normals(bodies, Tied::normals_off);
        self.evaluate_forces(bodies);
    }

    fn record(&self, bodies: &BodiesOf<F, N, D>, to: &mut Record) {
        let Tied { aims, pace, counts, asked, .. } = &bodies.kept.tied;
        let Counts { solves, corrections, values, gradients, followed } = *counts;
        to.counts("counts", [solves, corrections, values, gradients, followed]);
        pace.record(aims.len(), &mut aims.iter(), to);
        to.numbers("crowd looked at", &[1], [asked.reach]);
        to.counts("crowd", [asked.in_one()]);
        to.counts("linear algebra", self.shape.chosen());
    }

    fn recall(&self, bodies: &mut BodiesOf<F, N, D>, from: &mut Reading<'_>) -> Result<(), Error> {
        let [solves, corrections, values, gradients, followed] = from.counted("counts")?;
        bodies.kept.tied.counts = Counts { solves, corrections, values, gradients, followed };
        let aims = &mut bodies.kept.tied.aims;
        bodies.kept.tied.pace = Pace::recall(aims.len(), &mut aims.iter_mut(), from)?;
        let ([reach], [asked]) = (from.array("crowd looked at")?, from.counted("crowd")?);
        bodies.kept.tied.asked = Asked::of(asked, reach);
        let there = from.counts("linear algebra")?;
        if self.shape.chosen().eq(there.iter().copied()) { Ok(()) } else { Err(chosen_otherwise()) }
    }

    fn velocity<X>(&self, bodies: &Bodies<N, f64, X, D>, body: usize) -> [f64; D] {
        self.shape.roots[body].velocity(&bodies.p.as_ref()[body])
    }

    fn inertia(&self) -> &dyn Inertia<f64, D> {
        &*self.shape
    }

    fn freedom(&self, bodies: &BodiesOf<F, N, D>) -> usize {
        let components = self.shape.components.iter().zip(&bodies.kept.tied.solvers);
        let equations: usize = components.map(|(component, solver)| solver.rank(&component.rows)).sum();
        (D * self.free().count()).saturating_sub(equations)
    }
}

impl<F: Forces<f64, D>, N: Count, const D: usize> Guarded<f64, D> for Linked<F, N, D> {
    fn pulls_along_normals(&self) -> bool {
        !self.shape.components.iter().any(|component| component.rows.acting)
    }

    fn check_kinks(&self, before: &Saved<N, f64, D>, now: &BodiesOf<F, N, D>) -> Result<(), Failure> {
        let (time, q) = ([before.time, now.time], [before.q.as_ref(), now.q.as_ref()]);
        for &group in &self.shape.kinked {
            if let Some((member, kink)) = self.shape.groups[group].kink(time, q) {
                return Err(kinked(&self.shape, group, member, kink));
            }
        }
        Ok(())
    }

    fn changes_sides(&self, before: &Saved<N, f64, D>, now: &BodiesOf<F, N, D>) -> bool {
        let (time, q) = ([before.time, now.time], [before.q.as_ref(), now.q.as_ref()]);
        self.shape.kinked.iter().any(|&group| self.shape.groups[group].changes_sides(time, q))
    }

    fn kinked_normal(&self, bodies: &BodiesOf<F, N, D>, kink: &Failure, normal: &mut [[f64; D]]) {
        normal.fill([0.0; D]);
        let StepFailure::Kink { equation: Some(equation), .. } = &kink.cause else { return };
        gradient(&self.shape, equation, bodies.time, bodies.q.as_ref(), normal);
    }

    fn check_sheets(
        &self,
        h: f64,
        before: &Saved<N, f64, D>,
        now: &mut BodiesOf<F, N, D>,
    ) -> Result<(), Failure> {
        if self.shape.equations == 0 { Ok(()) } else { self.look_inside(h, before, now) }
    }
}

impl<F: Forces<f64, D>, N: Count, const D: usize> Measured<f64, D> for Linked<F, N, D> {
    fn residuals(&self, bodies: &BodiesOf<F, N, D>, g: &mut [f64]) {
        self.for_rows(g, |c, out| self.shape.values(c, bodies.time, bodies.q.as_ref(), out));
    }

    fn drift_rates(&self, bodies: &BodiesOf<F, N, D>, rates: &mut [f64]) {
        let velocity = self.velocities(bodies);
        self.for_rows(rates, |c, out| {
            let (rows, (row, _)) = (self.component(c), self.shape.components[c].first);
            let blocks = bodies.kept.tied.blocks_of(&self.shape, c, bodies.time, bodies.q.as_ref());
            for (i, rate) in out.iter_mut().enumerate() {
                *rate = along(rows, i, &blocks, &velocity) + bodies.kept.tied.rates[row + i];
            }
        });
    }

    fn constraint_forces(&self, bodies: &BodiesOf<F, N, D>, forces: &mut [[f64; D]]) {
        let mut multipliers = vec![0.0; self.shape.equations];
        self.multipliers(bodies, &mut multipliers);
        forces.fill([0.0; D]);
        for (c, component) in self.shape.components.iter().enumerate() {
            let rows = &component.rows;
            let mut blocks = bodies.kept.tied.blocks_of(&self.shape, c, bodies.time, bodies.q.as_ref());
            self.shape.mask(c, &mut blocks);
            for row in 0..rows.equations() {
                for (block, body) in rows.touched_by(row) {
                    let multiplier = multipliers[rows.equation(row)];
                    forces[body] = add_scaled(&forces[body], multiplier, &blocks[block]);
                }
            }
        }
    }

    fn corrections(&self, bodies: &BodiesOf<F, N, D>) -> Option<u64> {
        Some(self.counts(bodies).corrections)
    }
}

impl<F: Forces<f64, D>, N: Count, const D: usize> System<f64, D> for Linked<F, N, D> {
    type Rates = Self;
    type Collocation = Self;
    type Series = Self;

    fn rates(&self) -> Result<&Self, &'static str> {
        Ok(self)
    }

    fn collocation(&self) -> Result<&Self, &'static str> {
        let acting = self.shape.components.iter().any(|component| component.rows.acting);
        if acting { Err("a network whose multipliers act on chosen coordinates") } else { Ok(self) }
    }

    fn series(&self) -> Result<&Self, &'static str> {
        self.series_blocks().map(|_| self).ok_or(NO_SERIES)
    }

    fn drift_by<X: Iteration, W: Witness<f64>>(
        &self,
        kick: f64,
        h: f64,
        guess: &[f64],
        bodies: &mut BodiesOf<F, N, D>,
        witness: &mut W,
    ) -> Result<(), Failure> {
        self.book(kick, bodies);
        let Bodies { q, q_low, p, p_low, kept, time, work, .. } = bodies;
        let (q, q_low, p, p_low) = (q.as_mut(), q_low.as_mut(), p.as_mut(), p_low.as_mut());
        let moving = &mut Moving { q, q_low, p, p_low };
        kept.tied.drift::<X, W>(&self.shape, [h, kick], guess, moving, [time, work], witness)
    }

    fn evaluate_forces(&self, bodies: &mut BodiesOf<F, N, D>) {
        let at = Moment { time: bodies.time, positions: bodies.q.as_ref() };
        self.forces(at, &mut bodies.kept.of_effects, &mut bodies.kept.tied.force);
        self.evaluate_power(bodies);
    }

    fn settle<W: Witness<f64>>(
        &self,
        kick: f64,
        h: f64,
        bodies: &mut BodiesOf<F, N, D>,
        witness: &mut W,
    ) -> Result<(), Failure> {
        self.book(kick, bodies);
        let momenta = [&mut bodies.p, &mut bodies.p_low].map(AsMut::as_mut);
        let (q, work) = (bodies.q.as_ref(), &mut bodies.work);
        let settled = bodies.kept.tied.settle(&self.shape, [h, kick], q, momenta, work, witness);
        settled.map_err(|body| self.not_finite(bodies, body))
    }

    fn set_time(&self, bodies: &mut BodiesOf<F, N, D>, time: f64) {
        if bodies.time != time {
            bodies.time = time;
            for c in (0..self.shape.components.len()).filter(|&c| self.component(c).moving) {
                bodies.kept.tied.normals(&self.shape, c, time, bodies.q.as_ref());
            }
            if self.effects.changes_with_time() {
                self.evaluate_forces(bodies);
            }
        }
    }
}
