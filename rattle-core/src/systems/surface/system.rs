//! Bodies each on a surface of its own, g(q) = 0: one equation per body, solved in closed form up to one number.
//!
//! Generic over the scalar, so that several trajectories can go side by side in lanes. Masses are 1.

use crate::effect::force::Force;
use crate::effect::list::Field;
use crate::kernel::functions::ConstraintKernel;
use crate::kernel::series::NO_SERIES;
use crate::motion::bodies::{Bodies, Body, Count};
use crate::motion::failure::Failure;
use crate::motion::iteration::{Iteration, Kind};
use crate::motion::need::Need;
use crate::motion::system::System;
use crate::motion::table::Table;
use crate::motion::witness::Witness;
use crate::number::lanes::Fused;
use crate::number::real::{Mask, Real};
use crate::number::vector::{dot, scaled};
use crate::systems::surface::diagnosis::FailureAt;
use crate::systems::surface::kept::BodiesOf;
use crate::systems::surface::kept::Kept;
use crate::systems::surface::kept::OnSurface;
use crate::systems::surface::normal::Normal;
use crate::systems::surface::normal::multiplier_from_curvature;
use crate::systems::surface::room::Stages;
use crate::systems::surface::step::arrive;
use crate::systems::surface::step::drift;
use crate::systems::surface::step::drift_again;
use crate::systems::surface::step::project;
use crate::systems::surface::step::pull;
use crate::systems::surface::step::settle;
use crate::systems::surface::step::try_to_land;
use crate::systems::surface::tiles::{entry, may_go_in_tiles};

impl<T, K, F, N, L, const D: usize> System<T, D> for OnSurface<K, F, N, L>
where
    T: Real,
    K: ConstraintKernel<T, D, 1>,
    F: Field<T, D>,
    N: Count,
    L: ConstraintKernel<Fused<f64>, D, 1>,
{
    type Count = N;
    type Kept = Kept<N, T, F::Force, D>;

    fn bodies(&self, place: impl Fn(usize) -> Body<T, D>, _: f64) -> BodiesOf<N, T, F, D> {
        let normal = self.count.each(Normal::new([T::from_f64(0.0); D]));
        let kept = Kept { normal, force: self.count.each(Force::zero()), stages: None, series: None };
        let mut bodies = Bodies::new(self.count, kept, place, 0.0);
        self.refresh(&mut bodies);
        bodies
    }

    fn refresh(&self, bodies: &mut BodiesOf<N, T, F, D>) {
        if !self.fuse_normals(bodies) {
            for (normal, q) in bodies.kept.normal.as_mut().iter_mut().zip(bodies.q.as_ref()) {
                let [gradient] = self.constraint.jacobian(q);
                *normal = Normal::new(gradient);
            }
        }
        self.evaluate_forces(bodies);
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
        if const { may_go_in_tiles::<N, D>() }
            && X::KIND == Kind::Newton
            && let Some(set) = entry::<T, L, N, D>(self.count)
        {
            return self.drift_in_tiles(set, kick, h, guess, bodies, witness);
        }
        let by_default = X::KIND == Kind::Newton && guess.is_empty();
        for body in 0..bodies.q.as_ref().len() {
            let constraint = &self.constraint;
            if by_default {
                drift(kick, h, constraint, bodies, body, None, witness)?;
            } else {
                let lambda = guess.get(body).copied();
                let (landing, trusted) =
                    try_to_land::<X, _, _, _, _, D>(kick, h, lambda, constraint, bodies, body);
                if trusted.all() {
                    arrive(kick, h, bodies, body, &landing, witness);
                } else {
                    drift_again(kick, h, constraint, bodies, body, (landing, trusted), witness)?;
                }
            }
        }
        self.fuse_normals(bodies);
        Ok(())
    }

    #[inline(always)]
    fn evaluate_forces(&self, bodies: &mut BodiesOf<N, T, F, D>) {
        self.field.evaluate(bodies.q.as_ref(), bodies.kept.force.as_mut());
    }

    #[inline(always)]
    fn settle<W: Witness<T>>(
        &self,
        kick: f64,
        h: f64,
        bodies: &mut BodiesOf<N, T, F, D>,
        witness: &mut W,
    ) -> Result<(), Failure> {
        if const { may_go_in_tiles::<N, D>() }
            && let Some(set) = entry::<T, L, N, D>(self.count)
        {
            return self.settle_in_tiles(set, kick, h, bodies, witness);
        }
        for body in 0..bodies.q.as_ref().len() {
            let finite = settle(kick, h, bodies, body, witness);
            if !finite.all() {
                let (q, kept) = (bodies.q.as_ref(), &bodies.kept);
                return Err(FailureAt::of(body, finite).not_finite(&self.field, q, kept.normal.as_ref()));
            }
        }
        Ok(())
    }

    #[inline(always)]
    fn rates<W: Witness<T>>(
        &self,
        bodies: &mut BodiesOf<N, T, F, D>,
        rates: &mut [[T; D]],
        witness: &mut W,
    ) -> T {
        for (body, rate) in rates.iter_mut().enumerate() {
            let (lambda, pull) = pull(&self.constraint, bodies, body);
            witness.position_multiplier(body, lambda);
            *rate = pull;
        }
        T::from_f64(0.0)
    }

    #[inline(always)]
    fn project(&self, h: f64, bodies: &mut BodiesOf<N, T, F, D>) -> Result<(), Failure> {
        for body in 0..bodies.q.as_ref().len() {
            project(h, &self.constraint, bodies, body)?;
        }
        self.fuse_normals(bodies);
        self.evaluate_forces(bodies);
        Ok(())
    }

    fn reserve(&self, bodies: &mut BodiesOf<N, T, F, D>, stages: usize) {
        bodies.kept.stages = (stages > 0).then(|| Box::new(Stages::new(stages, self.count.number())));
    }

    fn reserve_series(&self, bodies: &mut BodiesOf<N, T, F, D>, orders: usize) {
        bodies.kept.series = self.room_for_series(orders);
    }

    fn expand<W: Witness<T>>(
        &self,
        bodies: &mut BodiesOf<N, T, F, D>,
        series: &mut [[T; D]],
        witness: &mut W,
    ) -> Result<(), Failure> {
        self.expand_motion(bodies, series, witness)
    }

    fn refuses(&self, need: Need) -> Option<&'static str> {
        let without = K::SERIES.and(self.field.series_blocks(self.count.number())).is_none();
        (need == Need::Series && without).then_some(NO_SERIES)
    }

    fn collocate<W: Witness<T>, const S: usize>(
        &self,
        table: &Table<S>,
        h: f64,
        bodies: &mut BodiesOf<N, T, F, D>,
        memory: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        self.collocate(table, h, bodies, memory, witness)
    }

    fn equations(&self) -> usize {
        self.count.number()
    }

    #[inline(always)]
    fn velocity(&self, bodies: &BodiesOf<N, T, F, D>, body: usize) -> [T; D] {
        bodies.p.as_ref()[body]
    }

    fn mass_product(&self, _: usize, a: &[T; D], b: &[T; D]) -> T {
        dot(a, b)
    }

    fn accelerations(&self, bodies: &BodiesOf<N, T, F, D>, accelerations: &mut [[T; D]]) {
        let mut multipliers = vec![T::from_f64(0.0); self.count.number()];
        <Self as System<T, D>>::multipliers(self, bodies, &mut multipliers);
        let mut forces = self.count.each(F::Force::zero());
        self.field.evaluate(bodies.q.as_ref(), forces.as_mut());
        for (i, a) in accelerations.iter_mut().enumerate() {
            let pull = scaled(multipliers[i], &bodies.kept.normal.as_ref()[i].gradient);
            *a = forces.as_ref()[i].add_to(pull, T::from_f64(1.0));
        }
    }

    fn constraint_forces(&self, bodies: &BodiesOf<N, T, F, D>, forces: &mut [[T; D]]) {
        let mut multipliers = vec![T::from_f64(0.0); forces.len()];
        self.multipliers(bodies, &mut multipliers);
        let normals = bodies.kept.normal.as_ref();
        for ((force, multiplier), normal) in forces.iter_mut().zip(multipliers).zip(normals) {
            *force = scaled(multiplier, &normal.gradient);
        }
    }

    fn kinetic_energy<X>(&self, bodies: &Bodies<N, T, X, D>) -> T {
        let parts = bodies.p.as_ref().iter().zip(bodies.p_low.as_ref());
        let energy = parts.map(|(p, low)| T::from_f64(0.5) * dot(p, p) + dot(p, low));
        energy.fold(T::from_f64(0.0), |sum, part| sum + part)
    }

    fn potential_energy<X>(&self, bodies: &Bodies<N, T, X, D>) -> T {
        self.field.energy(bodies.q.as_ref())
    }

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

    fn multipliers(&self, bodies: &BodiesOf<N, T, F, D>, multipliers: &mut [T]) {
        let (q, p) = (bodies.q.as_ref(), bodies.p.as_ref());
        let mut forces = self.count.each(F::Force::zero());
        self.field.evaluate(q, forces.as_mut());
        for (i, multiplier) in multipliers.iter_mut().enumerate() {
            let normal = &bodies.kept.normal.as_ref()[i];
            let [bend] = self.constraint.jet(&q[i], &p[i]).2;
            let force = forces.as_ref()[i].dot(&normal.gradient, T::from_f64(1.0));
            *multiplier = multiplier_from_curvature(bend, force, normal);
        }
    }
}
