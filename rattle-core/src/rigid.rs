//! Free attitude of rigid bodies: RATTLE on QᵀQ = 1, reduced to three unknowns.
//!
//! A body with centre of mass at rest turns with attitude Q (body → space). In the nine entries of Q its kinetic energy is
//! that of a point with masses d₁, d₂, d₃ in the columns, I₁ = d₂ + d₃ and so on, and RATTLE under the six equations
//! QᵀQ = 1 is the map of J. Moser and A. Veselov (Comm. Math. Phys. 139, 1991). In the angular momentum m of the body frame:
//!
//! ```text
//! m½ = m + c τ(Q)              τ̂ = QᵀF − FᵀQ,  F = −∂U/∂Q       c = h/2
//! e₀ J e + e × J e = h/2 m½    e₀ = √(1 − |e|²),  J = diag(I₁, I₂, I₃)
//! m½′ = m½ − 4/h e × J e       Q′ = Q R(e₀, e),  the rotation of this unit quaternion
//! m′ = m½′ + c τ(Q′)
//! ```
//!
//! (R. McLachlan, A. Zanna, Found. Comput. Math. 5, 2005.) Energy and angular momentum of a free body are kept to rounding.

mod series;

use crate::bodies::{Bodies, Body, Count};
use crate::effect::{Effects, Field, Force};
use crate::error::{Error, NetworkMistake, Passing, StartFailure, StepFailure};
use crate::iteration::Iteration;
use crate::lobatto::Table;
use crate::scene::Hold;
use crate::series::NO_SERIES;
use crate::solver::START_TOLERANCE;
use crate::start::finite;
use crate::state::State;
use crate::stepper::{Failure, Need, Stepper, Witness};
use crate::system::System;
use crate::vector::{sum, two_sum};
use nalgebra::{Matrix3, Vector3};

/// Newton steps after which the rotation of a step is given up; five suffice where there is one.
const MAX_ROTATION_STEPS: usize = 30;
/// What messages call such a system.
const REDUCED: &str = "a rigid body reduced to three unknowns";
/// QᵀQ off from 1 by more than this is brought back: well above the rounding of the product.
const CROOKED: f64 = 1e-14;
/// Halvings of a failed step that are tried, to say which would pass.
const HALVINGS: i32 = 40;

/// Rigid bodies with these moments of inertia, turning about their centres of mass: one, or with
/// [`particles`](crate::scene::Scene::particles) several alike, with effects on each or [over](crate::effect::Over) several.
/// Their centres do not move, and they take no links; a body under QᵀQ = 1 in a network does.
///
/// Coordinates are the nine entries of the attitude Q, row by row. Momenta are the angular momentum m in the body's frame,
/// in the first of nine places.
///
/// ```
/// use rattle_core::{rattle::Rattle, rigid::Rigid, scene::Scene};
/// use nalgebra::{Matrix3, Vector3};
///
/// let body = Rigid::new([0.6, 0.8, 1.0]);
/// let start = Rigid::start(&Matrix3::identity(), &Vector3::new(1.8, 0.4, -0.9));
/// let mut simulation = Scene::rigid(body).simulate(start, Rattle::new(0.05))?;
/// simulation.run(1000)?;
/// assert!(simulation.energy_error().abs() < 1e-13);
/// # Ok::<(), rattle_core::error::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rigid {
    inertia: Vector3<f64>,
}

impl Rigid {
    /// A body with principal moments of inertia I₁, I₂, I₃ about its first, second and third axis.
    #[must_use]
    pub fn new(moments: [f64; 3]) -> Self {
        Self { inertia: moments.into() }
    }

    /// d₁, d₂, d₃ with I₁ = d₂ + d₃, I₂ = d₃ + d₁, I₃ = d₁ + d₂: the masses of the columns of Q.
    #[must_use]
    pub fn column_masses(&self) -> [f64; 3] {
        let half_sum = 0.5 * self.inertia.sum();
        self.inertia.map(|moment| half_sum - moment).into()
    }

    /// The nine entries of an attitude, row by row.
    #[must_use]
    pub fn coordinates(attitude: &Matrix3<f64>) -> [f64; 9] {
        std::array::from_fn(|k| attitude[(k / 3, k % 3)])
    }

    /// The attitude with these nine entries.
    #[must_use]
    pub fn attitude(coordinates: &[f64; 9]) -> Matrix3<f64> {
        Matrix3::from_row_slice(coordinates)
    }

    /// A start with this attitude and angular momentum in the body's frame.
    #[must_use]
    pub fn start(attitude: &Matrix3<f64>, angular_momentum: &Vector3<f64>) -> State<9> {
        State::at(Self::coordinates(attitude)).moving(spread(angular_momentum))
    }

    /// The momenta P = Q Ω̂ D under QᵀQ = 1 with masses D, of a body with this attitude and angular momentum m = J Ω.
    #[must_use]
    pub fn momenta(&self, attitude: &Matrix3<f64>, angular_momentum: &Vector3<f64>) -> [f64; 9] {
        let rate = angular_momentum.component_div(&self.inertia).cross_matrix();
        Self::coordinates(&(attitude * rate * Matrix3::from_diagonal(&self.column_masses().into())))
    }

    /// The angular momentum m = (QᵀP − PᵀQ)ˇ in the body's frame, from attitude and momenta under QᵀQ = 1.
    #[must_use]
    pub fn angular_momentum(attitude: &Matrix3<f64>, momenta: &[f64; 9]) -> Vector3<f64> {
        turning_part(attitude, &Self::attitude(momenta))
    }

    /// The rotation of a step, as the vector e of its quaternion, with e₀. None if the body turns too far in it.
    fn rotation(&self, h: f64, m: &Vector3<f64>) -> Option<(f64, Vector3<f64>)> {
        let inertia = Matrix3::from_diagonal(&self.inertia);
        let target = m * (0.5 * h);
        let mut e = target.component_div(&self.inertia);
        let mut last = f64::INFINITY;
        for _ in 0..MAX_ROTATION_STEPS {
            let e0 = (1.0 - e.norm_squared()).sqrt(); // NaN where there is no such rotation
            let je = inertia * e;
            let residual = je * e0 + e.cross(&je) - target;
            let derivative =
                inertia * e0 - je * e.transpose() / e0 + e.cross_matrix() * inertia - je.cross_matrix();
            let correction = derivative.lu().solve(&residual)?;
            e -= correction;
            let size = correction.amax();
            if !size.is_finite() {
                return None;
            }
            if size <= f64::EPSILON * e.amax() || (size >= 0.5 * last && size <= 1e-12 * e.amax()) {
                let e0 = 1.0 - e.norm_squared();
                return (e0 > 0.0).then(|| (e0.sqrt(), e));
            }
            last = size;
        }
        None
    }
}

/// An angular momentum in the first of nine places.
fn spread(m: &Vector3<f64>) -> [f64; 9] {
    std::array::from_fn(|k| if k < 3 { m[k] } else { 0.0 })
}

/// One body: attitude and angular momentum as compensated sums.
struct Place {
    attitude: Matrix3<f64>,
    m: Vector3<f64>,
    torque: Vector3<f64>,
    body: Body<f64, 9>,
}

impl Place {
    fn of<N: Count, X: Force<f64, 9>>(bodies: &Bodies<N, f64, Kept<X>, 9>, number: usize) -> Self {
        let body = bodies.body(number);
        let attitude = Rigid::attitude(&body.q);
        let torque = turning_part(&attitude, &Rigid::attitude(&bodies.kept.force[number].components()));
        Self { attitude, m: Vector3::from_row_slice(&body.p[..3]), torque, body }
    }

    fn move_by(&mut self, turn: &Matrix3<f64>, change: &Vector3<f64>) {
        let Body { q, q_low, p, p_low } = &mut self.body;
        (*q, *q_low) = two_sum(q, &sum(q_low, &Rigid::coordinates(turn)));
        (*p, *p_low) = two_sum(p, &sum(p_low, &spread(change)));
        self.attitude = Rigid::attitude(q);
    }

    /// Q(3 − QᵀQ)/2 (Å. Björck, C. Bowie 1971), from 1 − QᵀQ.
    fn straighten(&mut self, deviation: &Matrix3<f64>) {
        self.move_by(&(self.attitude * deviation * 0.5), &Vector3::zeros());
    }

    fn put<N: Count, X>(self, bodies: &mut Bodies<N, f64, X, 9>, number: usize) {
        (bodies.q.as_mut()[number], bodies.q_low.as_mut()[number]) = (self.body.q, self.body.q_low);
        (bodies.p.as_mut()[number], bodies.p_low.as_mut()[number]) = (self.body.p, self.body.p_low);
    }
}

/// The vector of the antisymmetric matrix QᵀX − XᵀQ.
fn turning_part(attitude: &Matrix3<f64>, x: &Matrix3<f64>) -> Vector3<f64> {
    let a = attitude.transpose() * x;
    Vector3::new(a[(2, 1)] - a[(1, 2)], a[(0, 2)] - a[(2, 0)], a[(1, 0)] - a[(0, 1)])
}

/// Rigid bodies in a field of force.
#[derive(Debug, Clone)]
pub struct Turning<F, N> {
    body: Rigid,
    field: F,
    count: N,
}

/// What is kept from one step to the next.
#[derive(Debug, Clone)]
pub struct Kept<X> {
    /// Forces last evaluated.
    force: Vec<X>,
    /// Room for power series.
    series: Option<Box<series::Room>>,
}

type BodiesOf<F, N> = Bodies<N, f64, Kept<<F as Field<f64, 9>>::Force>, 9>;

impl Hold<9> for Rigid {
    type System<E: Effects<9>, N: Count> = Turning<E::Field<f64>, N>;

    fn system<E: Effects<9>, N: Count>(
        &self,
        effects: &E,
        count: N,
        start: &State<9>,
        _: &impl Stepper,
    ) -> Result<Self::System<E, N>, Error> {
        let fine = |moment: &f64| *moment > 0.0 && moment.is_finite();
        let triangle = self.column_masses().iter().all(|d| *d >= -4.0 * f64::EPSILON * self.inertia.amax());
        if !(self.inertia.iter().all(fine) && triangle) {
            return Err(Error::Network(NetworkMistake::Inertia { moments: self.inertia.into() }));
        }
        for (body, state) in start.bodies.iter().enumerate() {
            check(state).map_err(|cause| Error::Start { body, cause })?;
        }
        Ok(Turning { body: *self, field: effects.field(), count })
    }

    fn pull(&self, q: &[f64; 9], force: &[f64; 9]) -> [f64; 9] {
        spread(&turning_part(&Self::attitude(q), &Self::attitude(force)))
    }

    fn particles(self, _: usize) -> Self {
        self
    }

    fn project(&self, state: &State<9>) -> Result<State<9>, Error> {
        let mut state = State { remembered: None, ..state.clone() };
        for (number, body) in state.bodies.iter_mut().enumerate() {
            let nowhere = |cause| Error::Start { body: number, cause };
            finite("position", &body.q).and_then(|()| finite("momentum", &body.p)).map_err(nowhere)?;
            let svd = Self::attitude(&body.q).svd(true, true);
            let (Some(u), Some(v)) = (svd.u, svd.v_t) else {
                return Err(nowhere(StartFailure::NoAttitude { determinant: f64::NAN, deviation: f64::NAN }));
            };
            let attitude = u * v;
            let determinant = attitude.determinant();
            if determinant < 0.0 || svd.singular_values.min() <= 1e-3 * svd.singular_values.max() {
                let deviation = (svd.singular_values - Vector3::repeat(1.0)).amax();
                let determinant = Self::attitude(&body.q).determinant();
                return Err(nowhere(StartFailure::NoAttitude { determinant, deviation }));
            }
            body.q = Self::coordinates(&attitude);
            body.p[3..].fill(0.0);
            (body.q_low, body.p_low) = ([0.0; 9], [0.0; 9]);
        }
        Ok(state)
    }
}

fn check(state: &Body<f64, 9>) -> Result<(), StartFailure> {
    finite("position", &state.q)?;
    finite("momentum", &state.p)?;
    let attitude = Rigid::attitude(&state.q);
    let deviation = (attitude.transpose() * attitude - Matrix3::identity()).amax();
    let determinant = attitude.determinant();
    if deviation > START_TOLERANCE || determinant < 0.0 {
        return Err(StartFailure::NoAttitude { determinant, deviation });
    }
    if state.p[3..] != [0.0; 6] {
        return Err(StartFailure::NoAngularMomentum);
    }
    Ok(())
}

impl<F: Field<f64, 9>, N: Count> System<f64, 9> for Turning<F, N> {
    type Count = N;
    type Kept = Kept<F::Force>;

    fn bodies(&self, place: impl Fn(usize) -> Body<f64, 9>, time: f64) -> BodiesOf<F, N> {
        let kept = Kept { force: vec![F::Force::zero(); self.count.number()], series: None };
        let mut bodies = Bodies::new(self.count, kept, place, time);
        self.refresh(&mut bodies);
        bodies
    }

    fn refresh(&self, bodies: &mut BodiesOf<F, N>) {
        self.evaluate_forces(bodies);
    }

    fn drift_by<X: Iteration, W: Witness<f64>>(
        &self,
        kick: f64,
        h: f64,
        _: &[f64],
        bodies: &mut BodiesOf<F, N>,
        _: &mut W,
    ) -> Result<(), Failure> {
        for number in 0..self.count.number() {
            let mut place = Place::of(bodies, number);
            let kicked = place.torque * kick;
            let m = place.m + kicked;
            let Some((e0, e)) = self.body.rotation(h, &m) else {
                return Err(Failure { body: number, cause: self.too_fast(h, &m) });
            };
            let cross = e.cross_matrix();
            let turn = place.attitude * (cross * e0 + cross * cross) * 2.0; // Q(R − 1)
            let change = kicked - e.cross(&e.component_mul(&self.body.inertia)) * (4.0 / h);
            place.move_by(&turn, &change);
            let deviation = Matrix3::identity() - place.attitude.transpose() * place.attitude;
            if deviation.amax() > CROOKED {
                place.straighten(&deviation);
            }
            place.put(bodies, number);
        }
        bodies.time += h;
        Ok(())
    }

    fn evaluate_forces(&self, bodies: &mut BodiesOf<F, N>) {
        self.field.evaluate(bodies.q.as_ref(), &mut bodies.kept.force);
    }

    fn settle<W: Witness<f64>>(
        &self,
        kick: f64,
        _: f64,
        bodies: &mut BodiesOf<F, N>,
        _: &mut W,
    ) -> Result<(), Failure> {
        for number in 0..self.count.number() {
            let mut place = Place::of(bodies, number);
            let kicked = place.torque * kick;
            place.move_by(&Matrix3::zeros(), &kicked);
            place.put(bodies, number);
            let (q, p) = (bodies.q.as_ref(), &bodies.p.as_ref()[number]);
            if !p.iter().all(|p| p.is_finite()) {
                let position = q[number].to_vec();
                let cause = match self.field.culprit(q, number) {
                    Some((effect, force)) => {
                        StepFailure::ForceNotFinite { effect, force: force.to_vec(), position }
                    }
                    None => StepFailure::MomentumNotFinite { position },
                };
                return Err(Failure { body: number, cause });
            }
        }
        Ok(())
    }

    fn rates<W: Witness<f64>>(&self, bodies: &mut BodiesOf<F, N>, rates: &mut [[f64; 9]], _: &mut W) -> f64 {
        for (number, rate) in rates.iter_mut().enumerate() {
            let Place { m, torque, .. } = Place::of(bodies, number);
            *rate = spread(&(m.cross(&m.component_div(&self.body.inertia)) + torque));
        }
        0.0
    }

    fn project(&self, h: f64, bodies: &mut BodiesOf<F, N>) -> Result<(), Failure> {
        for number in 0..self.count.number() {
            let mut place = Place::of(bodies, number);
            let path = h.abs() * place.m.component_div(&self.body.inertia).norm();
            let mut nearest = f64::INFINITY;
            loop {
                let deviation = Matrix3::identity() - place.attitude.transpose() * place.attitude;
                let distance = deviation.amax();
                if distance <= CROOKED {
                    break;
                }
                let nearer = distance < nearest; // false for NaN
                if !nearer {
                    let cause = StepFailure::NotProjected { distance, path };
                    return Err(Failure { body: number, cause });
                }
                nearest = distance;
                place.straighten(&deviation);
            }
            place.put(bodies, number);
        }
        self.evaluate_forces(bodies);
        Ok(())
    }

    fn collocate<W: Witness<f64>, const S: usize>(
        &self,
        _: &Table<S>,
        _: f64,
        _: &mut BodiesOf<F, N>,
        _: &mut [f64],
        _: &mut W,
    ) -> Result<(), Failure> {
        Err(Failure { body: 0, cause: StepFailure::NoCollocation { system: REDUCED } })
    }

    fn reserve_series(&self, bodies: &mut BodiesOf<F, N>, orders: usize) {
        bodies.kept.series = self.room_for_series(orders);
    }

    fn expand<W: Witness<f64>>(
        &self,
        bodies: &mut BodiesOf<F, N>,
        series: &mut [[f64; 9]],
        _: &mut W,
    ) -> Result<(), Failure> {
        self.expand_motion(bodies, series)
    }

    fn expanded_impulse(&self, bodies: &BodiesOf<F, N>, body: usize, _: &[f64; 9], h: f64) -> [f64; 9] {
        let impulse = bodies.kept.series.as_ref().map_or([0.0; 3], |room| room.impulse(body, h));
        spread(&impulse.into())
    }

    fn refuses(&self, need: Need) -> Option<&'static str> {
        match need {
            Need::Verbs => None,
            Need::Series => self.field.series_blocks(self.count.number()).is_none().then_some(NO_SERIES),
            _ => Some(REDUCED),
        }
    }

    fn equations(&self) -> usize {
        0
    }

    fn velocity(&self, bodies: &BodiesOf<F, N>, body: usize) -> [f64; 9] {
        let attitude = Rigid::attitude(&bodies.q.as_ref()[body]);
        let m = Vector3::from_row_slice(&bodies.p.as_ref()[body][..3]);
        Rigid::coordinates(&(attitude * m.component_div(&self.body.inertia).cross_matrix()))
    }

    fn mass_product(&self, _: usize, a: &[f64; 9], b: &[f64; 9]) -> f64 {
        let masses = self.body.column_masses();
        (0..9).map(|k| masses[k % 3] * a[k] * b[k]).sum()
    }

    /// Q̈ = Q (Ω̂² + Ω̇̂) with J Ω̇ = m × Ω + torque.
    fn accelerations(&self, bodies: &BodiesOf<F, N>, accelerations: &mut [[f64; 9]]) {
        let mut forces = vec![F::Force::zero(); accelerations.len()];
        self.field.evaluate(bodies.q.as_ref(), &mut forces);
        for (number, (a, force)) in accelerations.iter_mut().zip(&forces).enumerate() {
            let place = Place::of(bodies, number);
            let torque = turning_part(&place.attitude, &Rigid::attitude(&force.components()));
            let rate = place.m.component_div(&self.body.inertia);
            let change = (place.m.cross(&rate) + torque).component_div(&self.body.inertia);
            let cross = rate.cross_matrix();
            *a = Rigid::coordinates(&(place.attitude * (cross * cross + change.cross_matrix())));
        }
    }

    fn constraint_forces(&self, _: &BodiesOf<F, N>, forces: &mut [[f64; 9]]) {
        forces.fill([0.0; 9]);
    }

    fn kinetic_energy<X>(&self, bodies: &Bodies<N, f64, X, 9>) -> f64 {
        let energy = bodies.p.as_ref().iter().zip(bodies.p_low.as_ref()).map(|(p, low)| {
            let rate = Vector3::from_row_slice(&p[..3]).component_div(&self.body.inertia);
            (0..3).map(|i| (0.5 * p[i] + low[i]) * rate[i]).sum::<f64>()
        });
        energy.sum()
    }

    fn potential_energy<X>(&self, bodies: &Bodies<N, f64, X, 9>) -> f64 {
        self.field.energy(bodies.q.as_ref())
    }

    fn residuals(&self, _: &BodiesOf<F, N>, _: &mut [f64]) {}
    fn drift_rates(&self, _: &BodiesOf<F, N>, _: &mut [f64]) {}
    fn multipliers(&self, _: &BodiesOf<F, N>, _: &mut [f64]) {}
}

impl<F, N> Turning<F, N> {
    #[cold]
    fn too_fast(&self, h: f64, m: &Vector3<f64>) -> StepFailure {
        let turn = h.abs() * m.component_div(&self.body.inertia).norm();
        let mut shorter = (1..HALVINGS).map(|k| h * 0.5_f64.powi(k));
        let passing = shorter.find(|&h| self.body.rotation(h, m).is_some());
        StepFailure::TurnsTooFar { turn, h, passing: Passing(passing) }
    }
}
