//! The operations of a [`System`] in phase space.

use crate::effect::force::Absent;
use crate::error::{Error, PhaseFailure};
use crate::kernel::functions::{HamiltonianKernel, PhaseConstraintKernel};
use crate::kernel::kinks::{first_kink, sign_changes};
use crate::motion::bodies::{Bodies, Body, Count, Saved};
use crate::motion::capability::Never;
use crate::motion::failure::Failure;
use crate::motion::guarded::Guarded;
use crate::motion::iteration::Iteration;
use crate::motion::measured::Measured;
use crate::motion::parts::Parts;
use crate::motion::record::{Reading, Record};
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::vector::dot;
use crate::solve::aim::{Aim, Pace};
use crate::systems::phase::kept::{BodiesOf, IN_PHASE_SPACE, InPhaseSpace, Kept, OfBody};
use crate::systems::phase::landing::Departure;
use crate::systems::phase::point::Point;
use crate::systems::phase::step::{TURN, move_by, turn_both_ways};

impl<K, H, N, const D: usize, const M: usize> Parts<f64, D> for InPhaseSpace<K, H, N, M>
where
    K: PhaseConstraintKernel<f64, D, M>,
    H: HamiltonianKernel<f64, D>,
    N: Count,
{
    type Count = N;
    type Kept = Kept<N, M>;
    type Effects = ();

    fn kind(&self) -> &'static str {
        IN_PHASE_SPACE
    }

    fn equations(&self) -> usize {
        self.count.number() * M
    }

    fn effects(&self) -> &() {
        &()
    }

    fn room_of(kept: &mut Kept<N, M>) -> &mut () {
        &mut kept.room
    }

    fn forces_of(_: &Kept<N, M>) -> &[Absent] {
        &[]
    }

    fn bodies(&self, places: &[Body<f64, D>], time: f64) -> BodiesOf<N, D, M> {
        let mut bodies = Bodies::new(self.count, Kept::unknown(self.count), places, time);
        self.refresh(&mut bodies);
        bodies
    }

    fn refresh(&self, bodies: &mut BodiesOf<N, D, M>) {
        bodies.kept.pace = Pace::unknown();
        for number in 0..self.count.number() {
            let slopes = self.functions().hidden(&Point::high(&bodies.body(number))).slopes;
            bodies.kept.bodies.as_mut()[number] = OfBody { slopes, aims: [Aim::unknown(); M] };
        }
    }

    fn record(&self, bodies: &BodiesOf<N, D, M>, to: &mut Record) {
        let Kept { bodies, pace, .. } = &bodies.kept;
        let aims = &mut bodies.as_ref().iter().flat_map(|kept| &kept.aims);
        pace.record(self.count.number() * M, aims, to);
    }

    fn recall(&self, bodies: &mut BodiesOf<N, D, M>, from: &mut Reading<'_>) -> Result<(), Error> {
        let aims = &mut bodies.kept.bodies.as_mut().iter_mut().flat_map(|kept| &mut kept.aims);
        bodies.kept.pace = Pace::recall(self.count.number() * M, aims, from)?;
        Ok(())
    }

    /// q̇ = ∂H/∂p − (∂g/∂p)ᵀλ.
    fn velocity<X>(&self, bodies: &Bodies<N, f64, X, D>, body: usize) -> [f64; D] {
        self.functions().flow(&Point::high(&bodies.body(body))).q
    }
}

impl<K, H, N, const D: usize, const M: usize> Guarded<f64, D> for InPhaseSpace<K, H, N, M>
where
    K: PhaseConstraintKernel<f64, D, M>,
    H: HamiltonianKernel<f64, D>,
    N: Count,
{
    #[inline(always)]
    fn check_kinks(&self, before: &Saved<N, f64, D>, now: &BodiesOf<N, D, M>) -> Result<(), Failure> {
        if const { K::KINKS.is_empty() } {
            return Ok(());
        }
        for number in 0..self.count.number() {
            let [from, to] = [before.body(number), now.body(number)].map(|body| [body.q, body.p]);
            if sign_changes(&self.constraint, &from, &to)
                && let Some(kink) = first_kink(&self.constraint, &from, &to)
            {
                return Err(Failure::of_kink(kink, number, None));
            }
        }
        Ok(())
    }

    fn coast(&self, h: f64, bodies: &mut BodiesOf<N, D, M>) {
        for number in 0..self.count.number() {
            let flow = self.functions().flow(&Point::high(&bodies.body(number)));
            move_by(bodies, number, &flow.times(h));
        }
        bodies.time += h;
    }
}

impl<K, H, N, const D: usize, const M: usize> Measured<f64, D> for InPhaseSpace<K, H, N, M>
where
    K: PhaseConstraintKernel<f64, D, M>,
    H: HamiltonianKernel<f64, D>,
    N: Count,
{
    /// H: what of it is kinetic is not told.
    fn kinetic_energy<X>(&self, bodies: &Bodies<N, f64, X, D>) -> f64 {
        let energy = |body: Body<f64, D>| {
            let (by_q, by_p) = self.energy.gradients(&body.q, &body.p);
            self.energy.value(&body.q, &body.p) + (dot(&by_q, &body.q_low) + dot(&by_p, &body.p_low))
        };
        (0..self.count.number()).map(|number| energy(bodies.body(number))).sum()
    }

    fn residuals(&self, bodies: &BodiesOf<N, D, M>, g: &mut [f64]) {
        for (g, number) in g.chunks_exact_mut(M.max(1)).zip(0..) {
            let body = bodies.body(number);
            g.copy_from_slice(&self.constraint.value(&body.q, &body.p));
        }
    }

    /// The hidden constraint {g, H}.
    fn drift_rates(&self, bodies: &BodiesOf<N, D, M>, rates: &mut [f64]) {
        for (rates, number) in rates.chunks_exact_mut(M.max(1)).zip(0..) {
            rates.copy_from_slice(&self.functions().hidden(&Point::high(&bodies.body(number))).value);
        }
    }

    /// The part (∂g/∂q)ᵀλ that acts on momenta.
    fn constraint_forces(&self, bodies: &BodiesOf<N, D, M>, forces: &mut [[f64; D]]) {
        for (number, force) in forces.iter_mut().enumerate() {
            let at = Point::high(&bodies.body(number));
            *force = self.functions().pull(&at).p;
        }
    }
}

impl<K, H, N, const D: usize, const M: usize> System<f64, D> for InPhaseSpace<K, H, N, M>
where
    K: PhaseConstraintKernel<f64, D, M>,
    H: HamiltonianKernel<f64, D>,
    N: Count,
{
    /// Forces and momenta are not apart.
    type Rates = Never;
    type Collocation = Never;
    type Series = Never;

    fn is_cartesian(&self) -> bool {
        false
    }

    fn drift_by<X: Iteration, W: Witness<f64>>(
        &self,
        _: f64,
        h: f64,
        _: &[f64],
        bodies: &mut BodiesOf<N, D, M>,
        witness: &mut W,
    ) -> Result<(), Failure> {
        let weights = bodies.kept.pace.weights(h);
        for number in 0..self.count.number() {
            let body = bodies.body(number);
            let fail = |cause| Failure { body: number, cause };
            let guess = self.functions().hidden(&Point::high(&body)).multipliers();
            let guess =
                guess.ok_or_else(|| fail(PhaseFailure::Undetermined { change: f64::INFINITY, h }.into()))?;
            let departure = Departure {
                functions: self.functions(),
                h,
                start: Point::high(&body),
                low: Point::low(&body),
                guess: guess.map(|lambda| 0.5 * h * lambda),
            };
            let landing = departure.land(&mut bodies.kept.bodies.as_mut()[number], weights).map_err(fail)?;
            for (i, sigma) in landing.sigma.into_iter().enumerate() {
                witness.position_multiplier(number * M + i, sigma / (0.5 * h));
            }
            move_by(bodies, number, &landing.change);
        }
        bodies.kept.pace.note(h);
        bodies.time += h;
        Ok(())
    }

    fn evaluate_forces(&self, _: &mut BodiesOf<N, D, M>) {}

    fn settle<W: Witness<f64>>(
        &self,
        _: f64,
        h: f64,
        bodies: &mut BodiesOf<N, D, M>,
        witness: &mut W,
    ) -> Result<(), Failure> {
        for number in 0..self.count.number() {
            let fail = |cause| Failure { body: number, cause };
            let (sigma, change, slopes) =
                self.functions().slide_to_hidden(h, &bodies.body(number)).map_err(fail)?;
            let turned = turn_both_ways(&bodies.kept.bodies.as_ref()[number].slopes, &slopes);
            if turned > TURN {
                return Err(fail(PhaseFailure::Undetermined { change: turned, h }.into()));
            }
            for (i, sigma) in sigma.into_iter().enumerate() {
                witness.momentum_multiplier(number * M + i, sigma / (0.5 * h));
            }
            move_by(bodies, number, &change);
            bodies.kept.bodies.as_mut()[number].slopes = slopes;
        }
        Ok(())
    }

    fn pushes(&self, bodies: &BodiesOf<N, D, M>, pushes: &mut [[f64; D]]) -> Result<(), &'static str> {
        for (number, push) in pushes.iter_mut().enumerate() {
            *push = self.functions().flow(&Point::high(&bodies.body(number))).p;
        }
        Ok(())
    }

    fn multipliers(&self, bodies: &BodiesOf<N, D, M>, multipliers: &mut [f64]) {
        for (multipliers, number) in multipliers.chunks_exact_mut(M.max(1)).zip(0..) {
            let found = self.functions().hidden(&Point::high(&bodies.body(number))).multipliers();
            multipliers.copy_from_slice(&found.unwrap_or([f64::NAN; M]));
        }
    }
}
