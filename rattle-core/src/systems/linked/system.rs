//! The operations of a [`System`] for bodies linked by a [network](crate::systems::network) of any number of
//! constraints, with any masses.

use crate::effect::force::Force;
use crate::effect::interval::{Inertia, Interval, Manner};
use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::error::{EffectMistake, Error, StepFailure};
use crate::kernel::series::NO_SERIES;
use crate::motion::bodies::{Bodies, Body, Count, Saved};
use crate::motion::capability::{Collocation, Series};
use crate::motion::failure::Failure;
use crate::motion::iteration::{Iteration, Kind};
use crate::motion::record::{Reading, Record};
use crate::motion::system::{Given, System};
use crate::motion::table::Table;
use crate::motion::witness::Witness;
use crate::number::vector::{add_scaled, dot, sum, two_sum};
use crate::solve::aim::{Aim, Pace};
use crate::solve::root::Course;
use crate::systems::linked::diagnosis::{gradient, kinked};
use crate::systems::linked::few::{Few, Momenta};
use crate::systems::linked::flight::Flight;
use crate::systems::linked::flight::LEARNED;
use crate::systems::linked::in_rows::{InRows, Sides};
use crate::systems::linked::kept::BodiesOf;
use crate::systems::linked::kept::Counts;
use crate::systems::linked::kept::Crowd;
use crate::systems::linked::kept::Kept;
use crate::systems::linked::kept::Linked;
use crate::systems::linked::kept::Room;
use crate::systems::linked::kept::along;
use crate::systems::linked::kept::fall_short;
use crate::systems::linked::room::Stages;
use crate::systems::linked::strip::{self, Strip};

impl<F: Forces<f64, D>, N: Count, const D: usize> System<f64, D> for Linked<F, N, D> {
    type Count = N;
    type Kept = Kept<F, D>;
    type Rates = Self;
    type Collocation = Self;
    type Series = Self;
    const FLOWS: usize = F::FLOWS;
    const REMEMBERS: bool = F::REMEMBERS;
    const PUSHES: bool = F::PUSHES;
    const EFFECTS: usize = F::EFFECTS;

    fn kind(&self) -> &'static str {
        "linked bodies"
    }

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

    fn bodies(&self, places: &[Body<f64, D>], time: f64) -> BodiesOf<F, N, D> {
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
            course: vec![Course::start(); rows],
            dx: vec![0.0; rows],
            lengths: vec![0.0; rows],
            scale: vec![0.0; rows],
            learned: vec![0.0; LEARNED * rows],
            off: vec![0.0; rows],
            tried: [0, 1].map(|_| [vec![0.0; rows], vec![0.0; rows]]),
            inner: vec![0.0; rows],
            noise: vec![0.0; rows],
            wrong: vec![false; rows],
            suspect: vec![false; rows],
        };
        let kept = Kept {
            force: vec![F::Force::zero(); n],
            power: 0.0,
            of_effects: self.effects.room(n),
            blocks: vec![[0.0; D]; shape.blocks],
            rates: vec![0.0; shape.equations],
            solvers: shape.components.iter().map(|component| component.solver.clone()).collect(),
            counts: Counts::default(),
            aims: vec![Aim::unknown(); shape.equations],
            pace: Pace::unknown(),
            crowd: Crowd::default(),
            in_rows: InRows::new(shape),
            room,
            stages: None,
            series: None,
        };
        let mut bodies = Bodies::new(self.count, kept, places, time);
        self.refresh(&mut bodies);
        bodies
    }

    fn refresh(&self, bodies: &mut BodiesOf<F, N, D>) {
        bodies.kept.aims.fill(Aim::unknown());
        for c in 0..self.shape.components.len() {
            let (q, time) = (bodies.q.as_ref(), bodies.time);
            bodies.kept.normals(&self.shape, c, time, q);
        }
        bodies.kept.in_rows.forget();
        self.evaluate_forces(bodies);
    }

    fn record(&self, bodies: &BodiesOf<F, N, D>, to: &mut Record) {
        let Kept { aims, pace, counts, crowd, .. } = &bodies.kept;
        let Counts { solves, corrections, values, gradients, followed } = *counts;
        to.counts("counts", [solves, corrections, values, gradients, followed]);
        pace.record(aims.len(), &mut aims.iter(), to);
        to.numbers("crowd looked at", &[1], [crowd.asked]);
        to.counts("crowd", [u64::from(crowd.near)]);
    }

    fn recall(&self, bodies: &mut BodiesOf<F, N, D>, from: &mut Reading<'_>) -> Result<(), Error> {
        let [solves, corrections, values, gradients, followed] = from.counted("counts")?;
        bodies.kept.counts = Counts { solves, corrections, values, gradients, followed };
        let aims = &mut bodies.kept.aims;
        bodies.kept.pace = Pace::recall(aims.len(), &mut aims.iter_mut(), from)?;
        let ([asked], [near]) = (from.array("crowd looked at")?, from.counted("crowd")?);
        bodies.kept.crowd = Crowd { asked, near: near != 0 };
        Ok(())
    }

    fn moves_with_time(&self) -> bool {
        self.constraints_move() || self.effects.changes_with_time()
    }

    fn constraints_move(&self) -> bool {
        self.shape.moving
    }

    fn set_time(&self, bodies: &mut BodiesOf<F, N, D>, time: f64) {
        if bodies.time != time {
            bodies.time = time;
            for c in (0..self.shape.components.len()).filter(|&c| self.component(c).moving) {
                bodies.kept.normals(&self.shape, c, time, bodies.q.as_ref());
            }
            if self.effects.changes_with_time() {
                self.evaluate_forces(bodies);
            }
        }
    }

    fn flow(
        &self,
        number: usize,
        given: Given<'_, f64, D>,
        bodies: &mut BodiesOf<F, N, D>,
        changes: &mut [[f64; D]],
    ) {
        self.shown(given, bodies, |effects, during, room| effects.flow(number, during, room, changes));
    }

    fn first_marks(&self, bodies: &BodiesOf<F, N, D>) -> Result<Vec<f64>, (&'static str, EffectMistake)> {
        let n = bodies.q.as_ref().len();
        let mut marks = vec![0.0; self.effects.marks(n)];
        let given = Given::of(0.0, true, bodies.noise);
        self.shown(given, &mut bodies.clone(), |effects, during, _| effects.first_marks(during, &mut marks))?;
        Ok(marks)
    }

    fn take_note(&self, number: usize, given: Given<'_, f64, D>, bodies: &mut BodiesOf<F, N, D>) {
        let mut marks = std::mem::take(&mut bodies.marks);
        self.shown(given, bodies, |effects, during, _| effects.take_note(number, during, &mut marks));
        bodies.marks = marks;
    }

    fn add_force_alone(
        &self,
        number: usize,
        bodies: &mut BodiesOf<F, N, D>,
        forces: &mut [[f64; D]],
    ) -> Option<&'static str> {
        let at = Moment { time: bodies.time, positions: bodies.q.as_ref() };
        self.effects.contribute_alone(number, at, &mut bodies.kept.of_effects, forces)
    }

    fn flow_manner(&self, number: usize) -> (Manner, &'static str) {
        self.effects.manner(number)
    }

    fn inertia(&self) -> &dyn Inertia<f64, D> {
        &*self.shape
    }

    fn force(&self, bodies: &BodiesOf<F, N, D>, body: usize) -> [f64; D] {
        bodies.kept.force[body].components()
    }

    fn freedom(&self, bodies: &BodiesOf<F, N, D>) -> usize {
        let components = self.shape.components.iter().zip(&bodies.kept.solvers);
        let equations: usize = components.map(|(component, solver)| solver.rank(&component.rows)).sum();
        (D * self.free().count()).saturating_sub(equations)
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
        let shape = &*self.shape;
        let by_default = X::KIND == Kind::Newton && guess.is_empty();
        if !by_default {
            bodies.kept.leave_rows(shape, bodies.time, bodies.q.as_ref());
        }
        let (q, q_low) = (bodies.q.as_mut(), bodies.q_low.as_mut());
        let (p, p_low) = (bodies.p.as_mut(), bodies.p_low.as_mut());
        let Kept { force, blocks, rates, solvers, counts, room, aims, pace, in_rows, .. } = &mut bodies.kept;
        let weights = pace.weights(h);
        pace.note(h);
        shape.pins.iter().for_each(|&(body, _)| room.trial[body] = q[body]);
        for &body in &shape.loose {
            room.set_out(body, [h, kick], &shape.roots[body], [&p[body], &p_low[body]], &force[body]);
            let lift = sum(&room.drift[body], &room.push[body]);
            (q[body], q_low[body]) = two_sum(&q[body], &sum(&q_low[body], &lift));
            (p[body], p_low[body]) = two_sum(&p[body], &force[body].add_to(p_low[body], kick));
        }
        if by_default {
            let mut sides = Sides { q, q_low, p, p_low, force, blocks };
            let [solves, corrections] =
                in_rows.drift(shape, [h, kick], weights, &mut sides, solvers, aims, witness);
            counts.take_rows(solves, corrections);
        }
        for &c in in_rows.left() {
            let component = &shape.components[c];
            let (rows, solver) = (&component.rows, &mut solvers[c]);
            let ((row, block), m, time) = (component.first, rows.equations(), bodies.time);
            let (all, own) = (block..block + rows.blocks(), row..row + m);
            let (blocks, rates, aims) = (&mut blocks[all], &mut rates[own.clone()], &mut aims[own.clone()]);
            counts.solves += 1;
            if by_default && solver.dense().is_some() {
                let (q, q_low, p, p_low, force) = (&mut *q, &mut *q_low, &mut *p, &mut *p_low, &force[..]);
                Few { shape, component: c, q, q_low, p, p_low, force, blocks, aims, weights, kick, h, time }
                    .drift(solver, room, counts)?;
            } else {
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
                    let bodies = [&mut *q, &mut *q_low, &mut *p, &mut *p_low];
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
                solver.multipliers(&room.x[own], &mut room.dx[..m]);
                for (row, displacement) in room.dx[..m].iter().enumerate() {
                    bodies.work -= displacement / h * rates[row];
                    let multiplier = displacement / (h * (0.5 * h));
                    witness.position_multiplier(rows.equation(row), multiplier);
                }
            }
        }
        bodies.time += h;
        for c in 0..shape.components.len() {
            if by_default && bodies.kept.solvers[c].dense().is_some() {
                continue; // its normals are taken over
            }
            let (q, time) = (bodies.q.as_ref(), bodies.time);
            let (sine, row) = bodies.kept.normals(shape, c, time, q);
            self.check_rank(c, bodies, sine, row)?;
        }
        if by_default {
            let Kept { in_rows, solvers, .. } = &mut bodies.kept;
            in_rows.take_back(shape, solvers, bodies.q.as_ref());
        }
        Ok(())
    }

    fn evaluate_forces(&self, bodies: &mut BodiesOf<F, N, D>) {
        let at = Moment { time: bodies.time, positions: bodies.q.as_ref() };
        let Kept { of_effects, force, power, .. } = &mut bodies.kept;
        self.forces(at, of_effects, force);
        if self.effects.changes_with_time() {
            *power = self.effects.power(at);
        }
    }

    fn check_forces(&self, bodies: &BodiesOf<F, N, D>) -> Result<(), Failure> {
        let at = Moment { time: bodies.time, positions: bodies.q.as_ref() };
        Failure::unless_finite(&self.effects, at, &bodies.kept.force, self.free())
    }

    fn settle<W: Witness<f64>>(
        &self,
        kick: f64,
        h: f64,
        bodies: &mut BodiesOf<F, N, D>,
        witness: &mut W,
    ) -> Result<(), Failure> {
        self.book(kick, bodies);
        let shape = &*self.shape;
        let (p, p_low) = (bodies.p.as_mut(), bodies.p_low.as_mut());
        let Kept { force, blocks, rates, solvers, room, in_rows, .. } = &mut bodies.kept;
        let (q, roots) = (bodies.q.as_ref(), &shape.roots);
        // Also of places: free bodies have no constraint that would miss them.
        let size = |p: &[f64; D], q: &[f64; D]| dot(p, p) + dot(q, q);
        let mut total_size = 0.0;
        for &body in &shape.loose {
            (p[body], p_low[body]) = two_sum(&p[body], &force[body].add_to(p_low[body], kick));
            total_size += size(&p[body], &q[body]);
        }
        total_size += in_rows.settle(shape, [h, kick], [p, p_low], force, (solvers, q), witness);
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
                for round in 0..2 {
                    // The second time takes what rounding left, if it left more than comes from forming the rates.
                    let settled = match (round, rows.width()) {
                        (0, 2) => fall_short::<false, 2, D>(rows, blocks, rates, velocity, needed),
                        (0, _) => fall_short::<false, 0, D>(rows, blocks, rates, velocity, needed),
                        (_, 2) => fall_short::<true, 2, D>(rows, blocks, rates, velocity, needed),
                        _ => fall_short::<true, 0, D>(rows, blocks, rates, velocity, needed),
                    };
                    if settled {
                        break;
                    }
                    solver.respond(rows, blocks, roots, needed, x);
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
                    bodies.work -= impulse * rates[i];
                    witness.momentum_multiplier(rows.equation(i), impulse / (0.5 * h));
                }
            }
        }
        if !total_size.is_finite()
            && let Some(body) = (0..p.len()).find(|&body| !size(&p[body], &q[body]).is_finite())
        {
            return Err(self.not_finite(bodies, body));
        }
        Ok(())
    }

    fn check_kinks(&self, before: &Saved<N, f64, D>, now: &BodiesOf<F, N, D>) -> Result<(), Failure> {
        let (time, q) = ([before.time, now.time], [before.q.as_ref(), now.q.as_ref()]);
        for group in &self.shape.kinked {
            if let Some((member, kink)) = group.kink(time, q) {
                return Err(kinked(&**group, member, kink));
            }
        }
        Ok(())
    }

    fn check_sheets(
        &self,
        steps: u64,
        h: f64,
        before: &Saved<N, f64, D>,
        now: &mut BodiesOf<F, N, D>,
    ) -> Result<(), Failure> {
        if self.shape.equations == 0 { Ok(()) } else { self.look_inside(steps, h, before, now) }
    }

    fn kinked_normal(&self, bodies: &BodiesOf<F, N, D>, kink: &Failure, normal: &mut [[f64; D]]) {
        normal.fill([0.0; D]);
        let StepFailure::Kink { equation: Some(equation), .. } = &kink.cause else { return };
        for group in &self.shape.groups {
            gradient(&**group, equation, bodies.time, bodies.q.as_ref(), normal);
        }
    }

    fn corrections(&self, bodies: &BodiesOf<F, N, D>) -> Option<u64> {
        Some(self.counts(bodies).corrections)
    }

    fn equations(&self) -> usize {
        self.shape.equations
    }

    fn velocity<X>(&self, bodies: &Bodies<N, f64, X, D>, body: usize) -> [f64; D] {
        self.shape.roots[body].velocity(&bodies.p.as_ref()[body])
    }

    fn constraint_forces(&self, bodies: &BodiesOf<F, N, D>, forces: &mut [[f64; D]]) {
        let mut multipliers = vec![0.0; self.shape.equations];
        self.multipliers(bodies, &mut multipliers);
        forces.fill([0.0; D]);
        for (c, component) in self.shape.components.iter().enumerate() {
            let rows = &component.rows;
            let mut blocks = bodies.kept.blocks_of(&self.shape, c, bodies.time, bodies.q.as_ref());
            self.shape.mask(c, &mut blocks);
            for row in 0..rows.equations() {
                for (block, body) in rows.touched_by(row) {
                    let multiplier = multipliers[rows.equation(row)];
                    forces[body] = add_scaled(&forces[body], multiplier, &blocks[block]);
                }
            }
        }
    }

    fn potential_energy<X>(&self, bodies: &Bodies<N, f64, X, D>) -> f64 {
        self.effects.energy(Moment { time: bodies.time, positions: bodies.q.as_ref() })
    }

    fn effect_energies<X>(&self, bodies: &Bodies<N, f64, X, D>, to: &mut Vec<f64>) {
        self.effects.energies(Moment { time: bodies.time, positions: bodies.q.as_ref() }, to);
    }

    fn residuals(&self, bodies: &BodiesOf<F, N, D>, g: &mut [f64]) {
        self.for_rows(g, |c, out| self.shape.values(c, bodies.time, bodies.q.as_ref(), out));
    }

    fn drift_rates(&self, bodies: &BodiesOf<F, N, D>, rates: &mut [f64]) {
        let velocity = self.velocities(bodies);
        self.for_rows(rates, |c, out| {
            let (rows, (row, _)) = (self.component(c), self.shape.components[c].first);
            let blocks = bodies.kept.blocks_of(&self.shape, c, bodies.time, bodies.q.as_ref());
            for (i, rate) in out.iter_mut().enumerate() {
                *rate = along(rows, i, &blocks, &velocity) + bodies.kept.rates[row + i];
            }
        });
    }
}

impl<F: Forces<f64, D>, N: Count, const D: usize> Collocation<N, Kept<F, D>, f64, D> for Linked<F, N, D> {
    fn reserve(&self, bodies: &mut BodiesOf<F, N, D>, stages: usize) {
        let room = || Box::new(Stages::new(stages, self.count.number(), &self.shape, &self.effects));
        bodies.kept.stages = (stages > 0).then(room);
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
}

impl<F: Forces<f64, D>, N: Count, const D: usize> Series<N, Kept<F, D>, f64, D> for Linked<F, N, D> {
    fn reserve_series(&self, bodies: &mut BodiesOf<F, N, D>, orders: usize) {
        bodies.kept.series = Some(self.room_for_series(orders));
    }

    fn expand<W: Witness<f64>>(
        &self,
        bodies: &mut BodiesOf<F, N, D>,
        series: &mut [[f64; D]],
        witness: &mut W,
    ) {
        self.expand_motion(bodies, series, witness);
    }

    fn expanded_work(&self, bodies: &BodiesOf<F, N, D>, h: f64) -> f64 {
        let work = bodies.kept.series.iter().flat_map(|room| room.work.iter().rev());
        work.fold(0.0, |sum, coefficient| coefficient + h * sum)
    }
}

impl<F: Forces<f64, D>, N: Count, const D: usize> Linked<F, N, D> {
    /// Has the effects look at the bodies: at what they remember, and their room.
    fn shown<R>(
        &self,
        given: Given<'_, f64, D>,
        bodies: &mut BodiesOf<F, N, D>,
        look: impl FnOnce(&F, &Interval<'_, f64, D>, &mut F::Room) -> R,
    ) -> R {
        let Given { h, before, velocities, rates, holding, coming, imposed, noise } = given;
        let (freedom, tied) = (self.freedom(bodies), self.equations() > 0);
        let at = Moment { time: bodies.time, positions: bodies.q.as_ref() };
        let (momenta, inertia, marks) = (bodies.p.as_ref(), &*self.shape, &*bodies.marks);
        let surface = None;
        let during = Interval {
            h,
            before,
            at,
            momenta,
            velocities,
            rates,
            holding,
            coming,
            imposed,
            inertia,
            surface,
            marks,
            tied,
            freedom,
            noise,
        };
        look(&self.effects, &during, &mut bodies.kept.of_effects)
    }
}
