//! Bodies each on a surface of its own, g(q) = 0: one equation per body, solved in closed form up to one number.
//!
//! Generic over the scalar, so that several trajectories can go side by side in lanes. Masses are 1.

mod collocation;
mod series;
mod side_by_side;

use crate::bodies::{Bodies, Body, Count};
use crate::effect::{Field, Force};
use crate::iteration::{Iteration, Kind};
use crate::kernel::ConstraintKernel;
use crate::lanes::Fused;
use crate::lobatto::Table;
use crate::real::{Mask, Real};
use crate::series::NO_SERIES;
use crate::solver::{Departure, FAR_GUESS, Landing, multiplier_from_curvature};
use crate::start::MAX_PROJECTION_STEPS;
use crate::stepper::{Failure, Need, Witness};
use crate::system::System;
use crate::vector::{dot, largest, scaled, sum, two_sum};
use collocation::Stages;
use series::Room;

/// Each body on its own copy of a surface, in a field of force.
#[derive(Debug, Clone)]
pub struct OnSurface<K, F, N, L> {
    /// g, one equation per body.
    pub constraint: K,
    /// The same function for several bodies at a time; or [`OneByOne`].
    pub in_lanes: L,
    /// U, from all effects.
    pub field: F,
    /// How many bodies there are.
    pub count: N,
}

impl<K, F, N, L> OnSurface<K, F, N, L> {
    /// So many bodies on this surface in this field, `in_lanes` or [`OneByOne`].
    pub fn new(constraint: K, in_lanes: L, field: F, count: N) -> Self {
        Self { constraint, in_lanes, field, count }
    }
}

/// Stands for a kernel in lanes where bodies go one by one.
#[derive(Debug, Clone, Copy)]
pub struct OneByOne;

const NAN: Fused<f64> = Fused(f64::NAN);

impl<const D: usize> ConstraintKernel<Fused<f64>, D, 1> for OneByOne {
    fn value(&self, _: &[Fused<f64>; D]) -> [Fused<f64>; 1] {
        [NAN]
    }
    fn value_and_jacobian(&self, _: &[Fused<f64>; D]) -> ([Fused<f64>; 1], [[Fused<f64>; D]; 1]) {
        ([NAN], [[NAN; D]])
    }
    fn hessian_vector(&self, _: &[Fused<f64>; D], _: &[Fused<f64>; D]) -> [[Fused<f64>; D]; 1] {
        [[NAN; D]]
    }
    fn jet(
        &self,
        _: &[Fused<f64>; D],
        _: &[Fused<f64>; D],
    ) -> ([Fused<f64>; 1], [Fused<f64>; 1], [Fused<f64>; 1]) {
        ([NAN], [NAN], [NAN])
    }
}

/// ∇g and 1/|∇g|² at a body's position.
#[derive(Debug, Clone, Copy)]
pub struct Normal<T, const D: usize> {
    /// ∇g(q).
    pub gradient: [T; D],
    /// 1/(∇g·∇g).
    pub inverse_square: T,
}

/// What is kept from one step to the next.
#[derive(Debug, Clone)]
pub struct Kept<N: Count, T: Real, F: Force<T, D>, const D: usize> {
    /// Normals at the positions.
    pub normal: N::Of<Normal<T, D>>,
    /// Forces −∇U last evaluated; of size zero where no effect acts.
    pub force: N::Of<F>,
    /// Room for a method with inner stages.
    stages: Option<Box<Stages<T, F, D>>>,
    /// Room for power series.
    series: Option<Box<Room<T, D>>>,
}

type BodiesOf<N, T, F, const D: usize> = Bodies<N, T, Kept<N, T, <F as Field<T, D>>::Force, D>, D>;

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
        for (normal, q) in bodies.kept.normal.as_mut().iter_mut().zip(bodies.q.as_ref()) {
            let [gradient] = self.constraint.jacobian(q);
            *normal = Normal::new(gradient);
        }
        self.fuse_normals(bodies);
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
        if X::KIND == Kind::Newton
            && let Some(set) = side_by_side::entry::<T, L, N, D>(self.count)
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
        if let Some(set) = side_by_side::entry::<T, L, N, D>(self.count) {
            return self.settle_in_tiles(set, kick, h, bodies, witness);
        }
        for body in 0..bodies.q.as_ref().len() {
            let finite = settle(kick, h, bodies, body, witness);
            if !finite.all() {
                let (q, kept) = (bodies.q.as_ref(), &bodies.kept);
                return Err(Failure::at(body, finite).not_finite(&self.field, q, kept.normal.as_ref()));
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
        let without = self.constraint.series().and(self.field.series_blocks(self.count.number())).is_none();
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

/// First half: kick, drift, and the position multiplier. Lanes that have landed already stay there.
#[inline(always)]
fn drift<T, K, F, N, W, const D: usize>(
    kick: f64,
    h: f64,
    constraint: &K,
    bodies: &mut Bodies<N, T, Kept<N, T, F, D>, D>,
    body: usize,
    landed: Option<(Landing<T, D>, T::Mask)>,
    witness: &mut W,
) -> Result<(), Failure>
where
    T: Real,
    K: ConstraintKernel<T, D, 1>,
    F: Force<T, D>,
    N: Count,
    W: Witness<T>,
{
    let step = T::from_f64(h);
    let (pushed, half_square) = (T::from_f64(h * kick), T::from_f64(0.5 * h * h));
    let share = T::from_f64(2.0 * kick / h); // of the force in the motion: 1 for RATTLE
    let (q, q_low) = (&bodies.q.as_ref()[body], &bodies.q_low.as_ref()[body]);
    let (p, p_low) = (&bodies.p.as_ref()[body], &bodies.p_low.as_ref()[body]);
    let normal = &bodies.kept.normal.as_ref()[body];
    let force = bodies.kept.force.as_ref()[body];

    let (_, _, [bend]) = constraint.jet(q, p); // pᵀ∇²g p = ∓κ |∇g| |p|²
    let path = sum(&scaled(step, p), &scaled(step, p_low));
    let departure = Departure {
        q,
        q_low,
        normal,
        free: force.add_to(path, pushed),
        guess: half_square * multiplier_from_curvature(bend, force.dot(&normal.gradient, share), normal),
    };
    let landing = land(constraint, h, body, &departure, p, bend, &path, &force, pushed, landed)?;

    arrive(kick, h, bodies, body, &landing, witness);
    Ok(())
}

/// Where a body lands by any iteration and from any guess of λ, which also tells h·κ·|v|; and in which lanes that is good enough
/// to tell that the root is the right one.
#[inline(always)]
fn try_to_land<X, T, K, F, N, const D: usize>(
    kick: f64,
    h: f64,
    lambda: Option<T>,
    constraint: &K,
    bodies: &Bodies<N, T, Kept<N, T, F, D>, D>,
    body: usize,
) -> (Landing<T, D>, T::Mask)
where
    X: Iteration,
    T: Real,
    K: ConstraintKernel<T, D, 1>,
    F: Force<T, D>,
    N: Count,
{
    let (step, pushed) = (T::from_f64(h), T::from_f64(h * kick));
    let (q, q_low) = (&bodies.q.as_ref()[body], &bodies.q_low.as_ref()[body]);
    let (p, p_low) = (&bodies.p.as_ref()[body], &bodies.p_low.as_ref()[body]);
    let (normal, force) = (&bodies.kept.normal.as_ref()[body], bodies.kept.force.as_ref()[body]);
    let along = force.dot(&normal.gradient, T::from_f64(2.0 * kick / h));
    let (lambda, bend) = if let Some(lambda) = lambda {
        (lambda, lambda * dot(&normal.gradient, &normal.gradient) + along)
    } else {
        let [bend] = constraint.jet(q, p).2;
        (multiplier_from_curvature(bend, along, normal), bend)
    };
    let speed_square = dot(p, p);
    let gentle = (T::from_f64(4.0) * step * step * bend * bend * normal.inverse_square).le(speed_square);
    let departure = Departure {
        q,
        q_low,
        normal,
        free: force.add_to(sum(&scaled(step, p), &scaled(step, p_low)), pushed),
        guess: T::from_f64(0.5 * h * h) * lambda,
    };
    let path_square = step * step * speed_square + force.square(pushed);
    let (landing, trusted) = departure.try_to_land::<X, K>(constraint, path_square);
    (landing, gentle.and(trusted))
}

/// [`drift`], out of the way of what is hoped for.
#[cold]
#[inline(never)]
fn drift_again<T, K, F, N, W, const D: usize>(
    kick: f64,
    h: f64,
    constraint: &K,
    bodies: &mut Bodies<N, T, Kept<N, T, F, D>, D>,
    body: usize,
    landed: (Landing<T, D>, T::Mask),
    witness: &mut W,
) -> Result<(), Failure>
where
    T: Real,
    K: ConstraintKernel<T, D, 1>,
    F: Force<T, D>,
    N: Count,
    W: Witness<T>,
{
    drift(kick, h, constraint, bodies, body, Some(landed), witness)
}

/// Takes a body to where it lands.
#[inline(always)]
fn arrive<T, F, N, W, const D: usize>(
    kick: f64,
    h: f64,
    bodies: &mut Bodies<N, T, Kept<N, T, F, D>, D>,
    body: usize,
    landing: &Landing<T, D>,
    witness: &mut W,
) where
    T: Real,
    F: Force<T, D>,
    N: Count,
    W: Witness<T>,
{
    let (q, q_low) = (&mut bodies.q.as_mut()[body], &mut bodies.q_low.as_mut()[body]);
    let (p, p_low) = (&mut bodies.p.as_mut()[body], &mut bodies.p_low.as_mut()[body]);
    let (normal, force) = (&mut bodies.kept.normal.as_mut()[body], bodies.kept.force.as_ref()[body]);
    let per_step = landing.multiplier / T::from_f64(h);
    witness.position_multiplier(body, per_step / T::from_f64(0.5 * h));
    let change = force.add_to(sum(p_low, &scaled(per_step, &normal.gradient)), T::from_f64(kick));
    (*p, *p_low) = two_sum(p, &change);
    (*q, *q_low) = two_sum(q, &sum(q_low, &landing.increment));
    *normal = Normal::new(landing.gradient);
}

/// Where the departing body lands: on the root that its motion, by `path` and under `pushed` times the force, leads to. Lanes
/// that have landed already stay there.
#[allow(clippy::too_many_arguments, reason = "what a step knows when it departs")]
#[inline(always)]
pub(crate) fn land<T: Real, K: ConstraintKernel<T, D, 1>, F: Force<T, D>, const D: usize>(
    constraint: &K,
    h: f64,
    body: usize,
    departure: &Departure<'_, T, D>,
    p: &[T; D],
    bend: T,
    path: &[T; D],
    force: &F,
    pushed: T,
    landed: Option<(Landing<T, D>, T::Mask)>,
) -> Result<Landing<T, D>, Failure> {
    let step = T::from_f64(h);
    let (speed_square, bent_square) =
        (dot(p, p), step * step * bend * bend * departure.normal.inverse_square);
    let within_reach = bent_square.le(speed_square); // (h·κ·|v|)² ≤ 1, times |v|²
    let zero = T::from_f64(0.0);
    let done = landed.as_ref().map_or(zero.lt(zero), |&(_, done)| done);
    if !within_reach.or(done).all() {
        return Err(Failure::at(body, within_reach.or(done)).too_long(h, departure, p, bend));
    }
    let mut landing = departure.land(constraint, |_| ());
    if let Some((before, done)) = landed {
        landing = before.or(done, landing);
    }
    let path_square = step * step * speed_square + force.square(pushed);
    let gentle = (T::from_f64(4.0) * bent_square).le(speed_square); // h·κ·|v| ≤ ½
    let trusted = done.or(gentle.and(departure.trusts(&landing, path_square, FAR_GUESS)));
    if !trusted.all() {
        let push = scaled(pushed, &force.components());
        landing = landing.or(trusted, departure.follow(constraint, path, &push));
        if !landing.converged.all() {
            return Err(Failure::at(body, landing.converged).lost(h, constraint, departure, p, bend));
        }
    }
    Ok(landing)
}

/// Second half: kick with the new force, and the momentum multiplier. False where p is not finite.
#[inline(always)]
fn settle<T, F, N, W, const D: usize>(
    kick: f64,
    h: f64,
    bodies: &mut Bodies<N, T, Kept<N, T, F, D>, D>,
    body: usize,
    witness: &mut W,
) -> T::Mask
where
    T: Real,
    F: Force<T, D>,
    N: Count,
    W: Witness<T>,
{
    let kicked = T::from_f64(kick);
    let (p, p_low) = (&mut bodies.p.as_mut()[body], &mut bodies.p_low.as_mut()[body]);
    let change = bodies.kept.force.as_ref()[body].add_to(*p_low, kicked);
    let (eta, normal_part) = bodies.kept.normal.as_ref()[body].projection(&sum(p, &change));
    witness.momentum_multiplier(body, eta / T::from_f64(0.5 * h));
    (*p, *p_low) = two_sum(p, &sum(&change, &normal_part));
    is_finite(p)
}

/// Whether a momentum, and what is made of its square, is a number.
#[inline(always)]
fn is_finite<T: Real, const D: usize>(p: &[T; D]) -> T::Mask {
    dot(p, p).le(T::from_f64(f64::MAX))
}

/// λ at a body's place, and the sum of force and constraint.
#[inline(always)]
fn pull<T, K, F, N, const D: usize>(
    constraint: &K,
    bodies: &Bodies<N, T, Kept<N, T, F, D>, D>,
    body: usize,
) -> (T, [T; D])
where
    T: Real,
    K: ConstraintKernel<T, D, 1>,
    F: Force<T, D>,
    N: Count,
{
    let (q, p) = (&bodies.q.as_ref()[body], &bodies.p.as_ref()[body]);
    let (normal, force) = (&bodies.kept.normal.as_ref()[body], bodies.kept.force.as_ref()[body]);
    let [bend] = constraint.jet(q, p).2;
    let along = force.dot(&normal.gradient, T::from_f64(1.0));
    let lambda = multiplier_from_curvature(bend, along, normal);
    (lambda, force.add_to(normal.gradient.map(|n| lambda * n), T::from_f64(1.0)))
}

/// Newton's iteration q ← q − ∇g g/|∇g|² until it no longer gets nearer; lanes that are there wait for the others.
#[inline(always)]
fn project<T, K, F, N, const D: usize>(
    h: f64,
    constraint: &K,
    bodies: &mut Bodies<N, T, Kept<N, T, F, D>, D>,
    body: usize,
) -> Result<(), Failure>
where
    T: Real,
    K: ConstraintKernel<T, D, 1>,
    F: Force<T, D>,
    N: Count,
{
    let (q, q_low) = (&mut bodies.q.as_mut()[body], &mut bodies.q_low.as_mut()[body]);
    let zero = T::from_f64(0.0);
    let path = scaled(T::from_f64(h), &bodies.p.as_ref()[body]);
    let rounding = T::from_f64(f64::EPSILON) * largest(q).max(largest(&path));
    let mut nearest = T::from_f64(f64::INFINITY);
    for _ in 0..MAX_PROJECTION_STEPS {
        let ([g], [gradient]) = constraint.value_and_jacobian(q);
        let normal = Normal::new(gradient);
        let shift = scaled(-g * normal.inverse_square, &gradient);
        let distance = dot(&shift, &shift).sqrt();
        // At the rounding of q, or at that of g, where steps no longer shrink.
        let stalled = nearest.le(distance + distance).and(distance.le(T::from_f64(64.0) * rounding));
        let arrived = distance.le(rounding).or(stalled);
        if arrived.all() {
            bodies.kept.normal.as_mut()[body] = normal;
            return Ok(());
        }
        let nearer = distance.lt(nearest);
        if !arrived.or(nearer).all() {
            return Err(Failure::at(body, arrived.or(nearer)).not_projected(distance, &path, q));
        }
        let shift = shift.map(|shift| T::select(arrived, zero, shift));
        (*q, *q_low) = two_sum(q, &sum(q_low, &shift));
        nearest = distance;
    }
    Err(Failure::at(body, false).not_projected(nearest, &path, q))
}

impl<T: Real, const D: usize> Normal<T, D> {
    /// The normal with gradient ∇g.
    #[inline(always)]
    pub(crate) fn new(gradient: [T; D]) -> Self {
        Self { gradient, inverse_square: T::from_f64(1.0) / dot(&gradient, &gradient) }
    }

    /// η and ∇g η such that p + ∇g η is tangent.
    #[inline(always)]
    pub(crate) fn projection(&self, p: &[T; D]) -> (T, [T; D]) {
        let eta = -dot(&self.gradient, p) * self.inverse_square;
        (eta, scaled(eta, &self.gradient))
    }
}
