//! The operations of a [`System`] for rigid bodies.

use crate::effect::force::Force;
use crate::effect::interval::Inertia;
use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::error::{MethodFailure, StepFailure};
use crate::kernel::series::NO_SERIES;
use crate::motion::affected::Affected;
use crate::motion::bodies::{Bodies, Body, Count};
use crate::motion::capability::{Never, Rates};
use crate::motion::failure::Failure;
use crate::motion::guarded::Guarded;
use crate::motion::iteration::Iteration;
use crate::motion::measured::Measured;
use crate::motion::parts::Parts;
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::vector::{add_scaled, largest, scaled, sum};
use crate::solve::nearing::Nearing;
use crate::systems::rigid::body::{REDUCED, Rigid, spread, turning_part};
use crate::systems::rigid::kept::{BodiesOf, Kept, Place, Turning};
use crate::systems::rigid::rotation::{
    CROOKED, Moments, deviation, has_rotation, one_over, product, share, too_fast, turn, turning,
};
use nalgebra::Vector3;
use std::array::from_fn;

impl<F: Forces<f64, 9>, N: Count> Parts<f64, 9> for Turning<F, N> {
    type Count = N;
    type Kept = Kept<F>;
    type Effects = F;

    const MOMENTA: usize = 3;

    fn kind(&self) -> &'static str {
        REDUCED
    }

    fn equations(&self) -> usize {
        0
    }

    fn effects(&self) -> &F {
        &self.effects
    }

    fn room_of(kept: &mut Kept<F>) -> &mut F::Room {
        &mut kept.of_effects
    }

    fn forces_of(kept: &Kept<F>) -> &[F::Force] {
        &kept.force
    }

    fn bodies(&self, places: &[Body<f64, 9>], time: f64) -> BodiesOf<F, N> {
        let n = self.count.number();
        let (force, of_effects) = (vec![F::Force::zero(); n], self.effects.room(n));
        let kept = Kept { force, torque: vec![[0.0; 3]; n], of_effects, series: None };
        let mut bodies = Bodies::new(self.count, kept, places, time);
        self.refresh(&mut bodies);
        bodies
    }

    fn refresh(&self, bodies: &mut BodiesOf<F, N>) {
        self.evaluate_forces(bodies);
    }

    fn velocity<X>(&self, bodies: &Bodies<N, f64, X, 9>, body: usize) -> [f64; 9] {
        let attitude = Rigid::attitude(&bodies.q.as_ref()[body]);
        let m = Vector3::from_row_slice(&bodies.p.as_ref()[body][..3]);
        Rigid::coordinates(&(attitude * m.component_div(&self.body.inertia).cross_matrix()))
    }

    fn inertia(&self) -> &dyn Inertia<f64, 9> {
        &self.body
    }

    fn freedom(&self, _: &BodiesOf<F, N>) -> usize {
        3 * self.count.number()
    }
}

impl<F: Forces<f64, 9>, N: Count> Guarded<f64, 9> for Turning<F, N> {}

impl<F: Forces<f64, 9>, N: Count> Measured<f64, 9> for Turning<F, N> {
    fn kinetic_energy<X>(&self, bodies: &Bodies<N, f64, X, 9>) -> f64 {
        let energy = bodies.p.as_ref().iter().zip(bodies.p_low.as_ref()).map(|(p, low)| {
            let rate = Vector3::from_row_slice(&p[..3]).component_div(&self.body.inertia);
            (0..3).map(|i| (0.5 * p[i] + low[i]) * rate[i]).sum::<f64>()
        });
        energy.sum()
    }

    fn force(&self, bodies: &BodiesOf<F, N>, body: usize) -> [f64; 9] {
        spread(&bodies.kept.torque[body].into())
    }
}

impl<F: Forces<f64, 9>, N: Count> System<f64, 9> for Turning<F, N> {
    type Rates = Self;
    type Collocation = Never;
    type Series = Self;

    fn rates(&self) -> Result<&Self, &'static str> {
        Ok(self)
    }

    fn series(&self) -> Result<&Self, &'static str> {
        self.effects.series_blocks(self.count.number()).map(|_| self).ok_or(NO_SERIES)
    }

    fn is_cartesian(&self) -> bool {
        false
    }

    fn drift_by<X: Iteration, W: Witness<f64>>(
        &self,
        kick: f64,
        h: f64,
        _: &[f64],
        bodies: &mut BodiesOf<F, N>,
        _: &mut W,
    ) -> Result<(), Failure> {
        self.book(kick, bodies);
        let [over, low] = one_over(h);
        for number in 0..self.count.number() {
            let mut place = Place::of(bodies, number);
            let kicked = scaled(kick, &place.torque);
            let m = sum(&place.m(), &kicked);
            let Some(x) = self.moments.rotation(&self.moments.ahead(&scaled(h, &m))) else {
                return Err(Failure { body: number, cause: too_fast(&self.moments, h, &m) });
            };
            let s = share(&x);
            place.turn_by(&product(place.q, &turn(&x, s)));
            let along = Moments::along(&x, s);
            let [taken, rest]: [[f64; 3]; 2] = self.moments.push.map(|push| from_fn(|i| push[i] * along[i]));
            let rest = add_scaled(&scaled(-low, &taken), -over, &rest);
            place.push_by(&add_scaled(&kicked, -over, &taken), &rest);
            let deviation = deviation(place.q);
            if largest(&deviation) > CROOKED {
                place.straighten(&deviation);
            }
        }
        bodies.time += h;
        Ok(())
    }

    fn evaluate_forces(&self, bodies: &mut BodiesOf<F, N>) {
        let at = Moment { time: bodies.time, positions: bodies.q.as_ref() };
        let Kept { of_effects, force, torque, .. } = &mut bodies.kept;
        self.effects.evaluate(at, of_effects, force);
        if const { <F::Force as Force<f64, 9>>::ACTS } {
            for ((torque, force), q) in torque.iter_mut().zip(force).zip(at.positions) {
                *torque = turning(q, &force.components());
            }
        }
        self.evaluate_power(bodies);
    }

    fn settle<W: Witness<f64>>(
        &self,
        kick: f64,
        _: f64,
        bodies: &mut BodiesOf<F, N>,
        _: &mut W,
    ) -> Result<(), Failure> {
        self.book(kick, bodies);
        for number in 0..self.count.number() {
            let mut place = Place::of(bodies, number);
            place.push_by(&scaled(kick, &place.torque), &[0.0; 3]);
            let (q, p) = (bodies.q.as_ref(), &bodies.p.as_ref()[number]);
            if !(p[0] + p[1] + p[2]).is_finite() && !p.iter().all(|p| p.is_finite()) {
                let cause = StepFailure::MomentumNotFinite { position: q[number].to_vec() };
                let momentum = Failure { body: number, cause };
                let at = Moment { time: bodies.time, positions: q };
                return Err(Failure::of_force(&self.effects, at, [number]).unwrap_or(momentum));
            }
        }
        Ok(())
    }

    /// Q̈ = Q (Ω̂² + Ω̇̂) with J Ω̇ = m × Ω + torque.
    fn accelerations(
        &self,
        bodies: &BodiesOf<F, N>,
        accelerations: &mut [[f64; 9]],
    ) -> Result<(), &'static str> {
        let mut forces = vec![F::Force::zero(); accelerations.len()];
        let at = Moment { time: bodies.time, positions: bodies.q.as_ref() };
        self.effects.evaluate(at, &mut bodies.kept.of_effects.clone(), &mut forces);
        for (number, (a, force)) in accelerations.iter_mut().zip(&forces).enumerate() {
            let attitude = Rigid::attitude(&at.positions[number]);
            let torque = turning_part(&attitude, &Rigid::attitude(&force.components()));
            let m = &bodies.p.as_ref()[number];
            let rate = self.moments.rate(&[m[0], m[1], m[2]]);
            let pushed = Vector3::from(self.moments.gyration(&Moments::others(&rate))) + torque;
            let (cross, change) =
                (Vector3::from(rate).cross_matrix(), pushed.component_div(&self.body.inertia));
            *a = Rigid::coordinates(&(attitude * (cross * cross + change.cross_matrix())));
        }
        Ok(())
    }
}

impl<F: Forces<f64, 9>, N: Count> Rates<N, Kept<F>, f64, 9> for Turning<F, N> {
    fn evaluate_rates<W: Witness<f64>>(
        &self,
        bodies: &mut BodiesOf<F, N>,
        rates: &mut [[f64; 9]],
        _: &mut W,
    ) -> f64 {
        for (number, rate) in rates.iter_mut().enumerate() {
            let m = &bodies.p.as_ref()[number];
            let spin = self.moments.rate(&[m[0], m[1], m[2]]);
            let change = self.moments.gyration(&Moments::others(&spin));
            *rate = spread(&sum(&change, &bodies.kept.torque[number]).into());
        }
        bodies.power
    }

    fn project(&self, h: f64, bodies: &mut BodiesOf<F, N>) -> Result<(), Failure> {
        for number in 0..self.count.number() {
            let mut place = Place::of(bodies, number);
            let path = h.abs() * Vector3::from(place.m()).component_div(&self.body.inertia).norm();
            let (mut nearing, mut off) = (Nearing::leaving(1.0), deviation(place.q));
            let leads = has_rotation(place.q, &off);
            loop {
                let distance = largest(&off);
                let (arrived, lost) = nearing.look(distance, distance <= CROOKED, false);
                if lost || !leads {
                    let cause = MethodFailure::NotProjected { distance, path }.into();
                    return Err(Failure { body: number, cause });
                }
                if arrived {
                    break;
                }
                place.straighten(&off);
                off = deviation(place.q);
            }
        }
        self.evaluate_forces(bodies);
        Ok(())
    }

    fn mass_product(&self, _: usize, a: &[f64; 9], b: &[f64; 9]) -> f64 {
        let masses = self.body.column_masses();
        (0..9).map(|k| masses[k % 3] * a[k] * b[k]).sum()
    }
}
