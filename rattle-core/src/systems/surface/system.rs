//! The operations of a [`System`] for bodies each on a surface of its own, g(q) = 0: one equation for one number per
//! body.
//!
//! Masses are 1.

use crate::effect::force::Force;
use crate::effect::interval::{Interval, UnitMasses};
use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::error::Error;
use crate::kernel::functions::ConstraintKernel;
use crate::kernel::kinks::{first_kink, sign_changes};
use crate::kernel::series::NO_SERIES;
use crate::motion::affected::Affected;
use crate::motion::bodies::{Bodies, Body, Count, Saved};
use crate::motion::capability::Rates;
use crate::motion::failure::Failure;
use crate::motion::guarded::Guarded;
use crate::motion::iteration::{Iteration, Kind};
use crate::motion::measured::Measured;
use crate::motion::parts::{Given, Parts};
use crate::motion::record::{Reading, Record};
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::lanes::Fused;
use crate::number::real::Scalar;
use crate::number::vector::{add_scaled, dot, scaled, sum};
use crate::solve::aim::{Aim, Pace};
use crate::systems::surface::crowd::Crowd;
use crate::systems::surface::diagnosis::FailureAt;
use crate::systems::surface::in_lanes::TileInLanes;
use crate::systems::surface::kept::{BodiesOf, Kept, OnSurface};
use crate::systems::surface::normal::Normal;
use crate::systems::surface::passage;
use crate::systems::surface::tiles::tiles_of;

impl<T, K, F, N, L, const D: usize> Parts<T, D> for OnSurface<K, F, N, L>
where
    T: Scalar,
    K: ConstraintKernel<T, D, 1>,
    F: Forces<T, D>,
    N: Count,
    L: ConstraintKernel<Fused<f64>, D, 1>,
{
    type Count = N;
    type Kept = Kept<N, T, F, D>;
    type Effects = F;

    fn kind(&self) -> &'static str {
        "bodies on surfaces"
    }

    fn equations(&self) -> usize {
        self.count.number()
    }

    #[inline(always)]
    fn effects(&self) -> &F {
        &self.effects
    }

    #[inline(always)]
    fn room_of(kept: &mut Kept<N, T, F, D>) -> &mut F::Room {
        &mut kept.of_effects
    }

    #[inline(always)]
    fn forces_of(kept: &Kept<N, T, F, D>) -> &[F::Force] {
        kept.force.as_ref()
    }

    fn bodies(&self, places: &[Body<T, D>], time: f64) -> BodiesOf<N, T, F, D> {
        let normal = self.count.each(Normal::new([T::from_f64(0.0); D]));
        let (force, of_effects) = (self.count.each(Force::zero()), self.effects.room(self.count.number()));
        let aim = self.count.each(Aim::unknown());
        let (pace, crowd) = (Pace::unknown(), Crowd::of(tiles_of(self.count.number())));
        let lanes = self.instructions::<T, D>().map(|_| Box::new(TileInLanes::new()));
        let (stages, series) = (None, None);
        let kept = Kept { normal, force, aim, pace, crowd, lanes, of_effects, stages, series };
        let mut bodies = Bodies::new(self.count, kept, places, time);
        self.refresh(&mut bodies);
        bodies
    }

    fn refresh(&self, bodies: &mut BodiesOf<N, T, F, D>) {
        bodies.kept.aim.as_mut().fill(Aim::unknown());
        if !self.fuse_normals(bodies) {
            for (normal, q) in bodies.kept.normal.as_mut().iter_mut().zip(bodies.q.as_ref()) {
                let [gradient] = self.constraint.jacobian(q);
                *normal = Normal::new(gradient);
            }
        }
        self.evaluate_forces(bodies);
    }

    fn record(&self, bodies: &BodiesOf<N, T, F, D>, to: &mut Record) {
        let Kept { aim, pace, crowd, .. } = &bodies.kept;
        pace.record(aim.as_ref().len(), &mut aim.as_ref().iter(), to);
        crowd.record(to);
    }

    fn recall(&self, bodies: &mut BodiesOf<N, T, F, D>, from: &mut Reading<'_>) -> Result<(), Error> {
        let n = self.count.number();
        bodies.kept.pace = Pace::recall(n, &mut bodies.kept.aim.as_mut().iter_mut(), from)?;
        bodies.kept.crowd = Crowd::recalled(from, tiles_of(n))?;
        Ok(())
    }

    #[inline(always)]
    fn velocity<X>(&self, bodies: &Bodies<N, T, X, D>, body: usize) -> [T; D] {
        bodies.p.as_ref()[body]
    }

    fn show<R>(
        &self,
        given: Given<'_, T, D>,
        bodies: &mut BodiesOf<N, T, F, D>,
        look: impl FnOnce(&F, &Interval<'_, T, D>, &mut F::Room) -> R,
    ) -> R {
        let coupling = (false, self.freedom(bodies));
        let at = Moment { time: bodies.time, positions: bodies.q.as_ref() };
        let seen = (at, bodies.p.as_ref(), &*bodies.marks);
        let normals = bodies.kept.normal.as_ref();
        let during = given.interval(seen, &UnitMasses, Some(&normals), coupling);
        look(&self.effects, &during, &mut bodies.kept.of_effects)
    }
}

impl<T, K, F, N, L, const D: usize> Guarded<T, D> for OnSurface<K, F, N, L>
where
    T: Scalar,
    K: ConstraintKernel<T, D, 1>,
    F: Forces<T, D>,
    N: Count,
    L: ConstraintKernel<Fused<f64>, D, 1>,
{
    #[inline(always)]
    fn check_kinks(&self, before: &Saved<N, T, D>, now: &BodiesOf<N, T, F, D>) -> Result<(), Failure> {
        if const { K::KINKS.is_empty() } {
            return Ok(());
        }
        for (body, (from, to)) in before.q.as_ref().iter().zip(now.q.as_ref()).enumerate() {
            if sign_changes(&self.constraint, &[*from], &[*to])
                && let Some(kink) = first_kink(&self.constraint, &[from.map(T::to_f64)], &[to.map(T::to_f64)])
            {
                return Err(Failure::of_kink(kink, body, None));
            }
        }
        Ok(())
    }

    #[inline(always)]
    fn changes_sides(&self, before: &Saved<N, T, D>, now: &BodiesOf<N, T, F, D>) -> bool {
        if const { K::KINKS.is_empty() } {
            return false;
        }
        let mut ways = before.q.as_ref().iter().zip(now.q.as_ref());
        ways.any(|(from, to)| sign_changes(&self.constraint, &[*from], &[*to]))
    }

    fn lean(&self, before: &Saved<N, T, D>, bodies: &mut BodiesOf<N, T, F, D>) {
        let normals = bodies.kept.normal.as_ref();
        for ((q, from), normal) in bodies.q.as_mut().iter_mut().zip(before.q.as_ref()).zip(normals) {
            let [g] = self.constraint.value(q);
            let (shift, way) = (
                scaled(-g * normal.inverse_square, &normal.gradient),
                add_scaled(q, T::from_f64(-1.0), from),
            );
            // A constraint that takes a body farther than it went tells nothing.
            if dot(&shift, &shift).le(dot(&way, &way)) {
                *q = sum(q, &shift);
            }
        }
    }

    fn kinked_normal(&self, bodies: &BodiesOf<N, T, F, D>, kink: &Failure, normal: &mut [[T; D]]) {
        normal.fill([T::from_f64(0.0); D]);
        normal[kink.body] = bodies.kept.normal.as_ref()[kink.body].gradient;
    }

    #[inline(always)]
    fn check_normals(
        &self,
        h: f64,
        before: &Saved<N, T, D>,
        now: &BodiesOf<N, T, F, D>,
    ) -> Result<(), Failure> {
        let zero = T::from_f64(0.0);
        for body in 0..self.count.number() {
            let (from, to) = (before.body(body), now.body(body));
            let [gradient] = self.constraint.jacobian(&from.q);
            let along = dot(&gradient, &now.kept.normal.as_ref()[body].gradient);
            if along.lt(zero) & zero.lt(dot(&from.p, &to.p)) {
                passage::check(&self.constraint, h, body, [from, to])?;
            }
        }
        Ok(())
    }

    fn check_sheets(
        &self,
        h: f64,
        before: &Saved<N, T, D>,
        now: &mut BodiesOf<N, T, F, D>,
    ) -> Result<(), Failure> {
        self.check_each(h, before, now)
    }
}

impl<T, K, F, N, L, const D: usize> Measured<T, D> for OnSurface<K, F, N, L>
where
    T: Scalar,
    K: ConstraintKernel<T, D, 1>,
    F: Forces<T, D>,
    N: Count,
    L: ConstraintKernel<Fused<f64>, D, 1>,
{
    fn residuals(&self, bodies: &BodiesOf<N, T, F, D>, g: &mut [T]) {
        for (g, q) in g.iter_mut().zip(bodies.q.as_ref()) {
            [*g] = self.constraint.value(q);
        }
    }

    fn drift_rates(&self, bodies: &BodiesOf<N, T, F, D>, rates: &mut [T]) {
        let pairs = bodies.kept.normal.as_ref().iter().zip(bodies.p.as_ref());
        for (rate, (normal, p)) in rates.iter_mut().zip(pairs) {
            *rate = dot(&normal.gradient, p);
        }
    }

    fn constraint_forces(&self, bodies: &BodiesOf<N, T, F, D>, forces: &mut [[T; D]]) {
        let mut multipliers = vec![T::from_f64(0.0); forces.len()];
        System::multipliers(self, bodies, &mut multipliers);
        let normals = bodies.kept.normal.as_ref();
        for ((force, multiplier), normal) in forces.iter_mut().zip(multipliers).zip(normals) {
            *force = scaled(multiplier, &normal.gradient);
        }
    }
}

impl<T, K, F, N, L, const D: usize> System<T, D> for OnSurface<K, F, N, L>
where
    T: Scalar,
    K: ConstraintKernel<T, D, 1>,
    F: Forces<T, D>,
    N: Count,
    L: ConstraintKernel<Fused<f64>, D, 1>,
{
    type Rates = Self;
    type Collocation = Self;
    type Series = Self;

    #[inline(always)]
    fn rates(&self) -> Result<&Self, &'static str> {
        Ok(self)
    }

    #[inline(always)]
    fn collocation(&self) -> Result<&Self, &'static str> {
        Ok(self)
    }

    #[inline(always)]
    fn series(&self) -> Result<&Self, &'static str> {
        let blocks = self.constraint.series().and(self.effects.series_blocks(self.count.number()));
        blocks.map(|_| self).ok_or(NO_SERIES)
    }

    #[inline(always)]
    fn drift_by<X: Iteration, W: Witness<T>>(
        &self,
        kick: f64,
        h: f64,
        guess: &[T],
        bodies: &mut BodiesOf<N, T, F, D>,
        witness: &mut W,
    ) -> Result<(), Failure> {
        self.book(kick, bodies);
        if X::KIND == Kind::Newton
            && let Some(drift) = const { Self::drifts::<T, W, D>() }
            && let Some(set) = self.instructions::<T, D>()
        {
            drift(self, set, kick, h, guess, bodies, witness)?;
            self.pass(h, bodies);
            return Ok(());
        }
        let weights = bodies.kept.pace.weights(h);
        bodies.kept.pace.note(h);
        for body in 0..bodies.q.as_ref().len() {
            let lambda = guess.get(body).copied();
            bodies.drift::<X, _, _>(kick, h, lambda, weights, &self.constraint, body, witness)?;
        }
        self.fuse_normals(bodies);
        self.pass(h, bodies);
        Ok(())
    }

    #[inline(always)]
    fn evaluate_forces(&self, bodies: &mut BodiesOf<N, T, F, D>) {
        let at = Moment { time: bodies.time, positions: bodies.q.as_ref() };
        self.effects.evaluate(at, &mut bodies.kept.of_effects, bodies.kept.force.as_mut());
        self.evaluate_power(bodies);
    }

    #[inline(always)]
    fn settle<W: Witness<T>>(
        &self,
        kick: f64,
        h: f64,
        bodies: &mut BodiesOf<N, T, F, D>,
        witness: &mut W,
    ) -> Result<(), Failure> {
        self.book(kick, bodies);
        if let Some(settle) = const { Self::settles::<T, W, D>() }
            && let Some(set) = self.instructions::<T, D>()
        {
            return settle(self, set, kick, h, bodies, witness);
        }
        for body in 0..bodies.q.as_ref().len() {
            let finite = bodies.settle(kick, h, body, witness);
            if !finite {
                let at = Moment { time: bodies.time, positions: bodies.q.as_ref() };
                let normals = bodies.kept.normal.as_ref();
                return Err(FailureAt::of(body).not_finite(&self.effects, at, normals));
            }
        }
        Ok(())
    }
}

impl<T, K, F, N, L, const D: usize> Rates<N, Kept<N, T, F, D>, T, D> for OnSurface<K, F, N, L>
where
    T: Scalar,
    K: ConstraintKernel<T, D, 1>,
    F: Forces<T, D>,
    N: Count,
    L: ConstraintKernel<Fused<f64>, D, 1>,
{
    #[inline(always)]
    fn evaluate_rates<W: Witness<T>>(
        &self,
        bodies: &mut BodiesOf<N, T, F, D>,
        rates: &mut [[T; D]],
        witness: &mut W,
    ) -> T {
        for (body, rate) in rates.iter_mut().enumerate() {
            let (lambda, pull) = bodies.pull(&self.constraint, body);
            witness.position_multiplier(body, lambda);
            *rate = pull;
        }
        bodies.power
    }

    #[inline(always)]
    fn project(&self, h: f64, bodies: &mut BodiesOf<N, T, F, D>) -> Result<(), Failure> {
        for body in 0..bodies.q.as_ref().len() {
            bodies.project(h, &self.constraint, body)?;
        }
        self.fuse_normals(bodies);
        self.evaluate_forces(bodies);
        Ok(())
    }

    fn mass_product(&self, _: usize, a: &[T; D], b: &[T; D]) -> T {
        dot(a, b)
    }
}
