//! Constraints on phase space, g(q, p) = 0, with any energy H(q, p): geometric RATTLE.
//!
//! ```text
//! q̇ =  ∂H/∂p − (∂g/∂p)ᵀ λ
//! ṗ = −∂H/∂q + (∂g/∂q)ᵀ λ        g(q, p) = 0
//! ```
//!
//! with the sign of λ as everywhere in this library. Constraints must be *coisotropic*: {gᵢ, gⱼ} = 0 where g = 0, with
//! {a, b} = ∂a/∂q·∂b/∂p − ∂a/∂p·∂b/∂q; one equation always is, and equations of positions alone are. The flows of the gᵢ
//! then make *fibres* within g = 0, and λ moves along them. The motion is where hᵢ = {gᵢ, H} = 0, the hidden constraint,
//! which a start must satisfy too; it is determined where Nᵢⱼ = ∂hᵢ/∂σⱼ, along the fibre, has an inverse. A step is
//!
//! ```text
//! z̃  = z slid along its fibre by h/2 λ
//! z* = Φₕ(z̃)                               λ such that g(z*) = 0
//! z′ = z* slid along its fibre by h/2 μ    μ such that {g, H}(z′) = 0
//! ```
//!
//! with the Störmer–Verlet step Φₕ of H as if it were free. It is symplectic on the hidden constraint, symmetric and of
//! second order, and for g(q) and H = |p|²/2 + U(q) it is [RATTLE](crate::rattle). What z* is does not depend on where on
//! its fibre z was: SHAKE, which leaves the last slide out, is the same map of fibres, and no method of its own.
//!
//! Where N loses its inverse the motion ends; for one equation |N| falls like √(t* − t). A step within which N changes by
//! half of itself is refused.
//!
//! H is told as kinetic energy, and no shadow energy is known (NaN).
//!
//! Source: R. McLachlan, K. Modin, O. Verdier, M. Wilkins, *Geometric generalisations of SHAKE and RATTLE*, Found. Comput.
//! Math. 14 (2014) 339.

mod fibre;
mod point;

use crate::bodies::{Bodies, Body, Count};
use crate::effect::{Effects, Field};
use crate::error::{Error, History, PhaseMistake, StartFailure, StepFailure};
use crate::iteration::Iteration;
use crate::kernel::{Hamiltonian, HamiltonianKernel, PhaseConstraint, PhaseConstraintKernel};
use crate::lobatto::Table;
use crate::scene::Hold;
use crate::solver::START_TOLERANCE;
use crate::start::{MAX_PROJECTION_STEPS, finite};
use crate::state::State;
use crate::stepper::{Failure, Need, Stepper, Witness};
use crate::system::System;
use crate::vector::{dot, sum, two_sum};
use fibre::slide;
use point::{Hidden, Level, Point, Verlet, solve};
use std::array::from_fn;

/// What messages call such a system.
const IN_PHASE_SPACE: &str = "a system in phase space";
/// Corrections of a slide after which it is given up; four suffice where there is one.
const MAX_CORRECTIONS: usize = 20;
/// A residual below this many roundings may be the rounding of g itself, once it no longer shrinks.
const NOISE: f64 = 1e3;
/// N may change by this part of itself within a step.
const TURN: f64 = 0.5;

/// M equations g(q, p) = 0 and an energy H(q, p), of a scene made by
/// [`Scene::in_phase_space`](crate::scene::Scene::in_phase_space).
#[derive(Debug, Clone, Copy)]
pub struct PhaseSpace<G, H, const M: usize> {
    /// g.
    pub constraint: G,
    /// H.
    pub hamiltonian: H,
}

/// Bodies in phase space, each under its own g and H.
#[derive(Debug, Clone)]
pub struct InPhaseSpace<K, H, N, const M: usize> {
    constraint: K,
    energy: H,
    count: N,
}

type BodiesOf<N, const D: usize, const M: usize> = Bodies<N, f64, <N as Count>::Of<[[f64; M]; M]>, D>;

impl<const D: usize> Point<D> {
    fn high(body: &Body<f64, D>) -> Self {
        Self { q: body.q, p: body.p }
    }
    fn low(body: &Body<f64, D>) -> Self {
        Self { q: body.q_low, p: body.p_low }
    }
}

impl<G, H, const M: usize> PhaseSpace<G, H, M> {
    fn in_phase_space<N: Count, const D: usize>(
        &self,
        count: N,
    ) -> InPhaseSpace<G::Kernel<f64>, H::Kernel<f64>, N, M>
    where
        G: PhaseConstraint<D, M>,
        H: Hamiltonian<D>,
    {
        InPhaseSpace { constraint: self.constraint.kernel(), energy: self.hamiltonian.kernel(), count }
    }
}

impl<G: PhaseConstraint<D, M>, H: Hamiltonian<D>, const D: usize, const M: usize> Hold<D>
    for PhaseSpace<G, H, M>
{
    type System<E: Effects<D>, N: Count> = InPhaseSpace<G::Kernel<f64>, H::Kernel<f64>, N, M>;

    fn system<E: Effects<D>, N: Count>(
        &self,
        _: &E,
        count: N,
        start: &State<D>,
        method: &impl Stepper,
    ) -> Result<Self::System<E, N>, Error> {
        const {
            assert!(
                size_of::<<E::Field<f64> as Field<f64, D>>::Force>() == 0,
                "in phase space the Hamiltonian is the whole energy: write potentials into it"
            )
        };
        if method.rattle_steps().is_none() {
            return Err(Error::NeedsRattle { method: method.name(), system: IN_PHASE_SPACE });
        }
        let system = self.in_phase_space(count);
        for (body, state) in start.bodies.iter().enumerate() {
            system.check(state).map_err(|cause| Error::Start { body, cause })?;
        }
        Ok(system)
    }

    fn particles(self, _: usize) -> Self {
        self
    }

    fn project(&self, state: &State<D>) -> Result<State<D>, Error> {
        let (system, mut state) = (self.in_phase_space(crate::bodies::One), state.clone());
        for (number, body) in state.bodies.iter_mut().enumerate() {
            let cause = |cause| Error::Start { body: number, cause };
            let Point { q, p } = system.project(body).map_err(cause)?;
            *body = Body { q, p, q_low: [0.0; D], p_low: [0.0; D] };
        }
        Ok(state)
    }
}

/// Somewhere along a fibre: how the point changes until there, and the numbers that shall vanish.
struct Look<X, const D: usize, const M: usize> {
    change: Point<D>,
    value: [f64; M],
    /// The sizes of their terms.
    size: [f64; M],
    /// What their slopes are made of.
    rest: X,
}

impl<K, H, N, const M: usize> InPhaseSpace<K, H, N, M> {
    /// The σ for which what is looked at vanishes, to its rounding, and what is seen there.
    fn solve<X, const D: usize>(
        h: f64,
        mut sigma: [f64; M],
        look: impl Fn(&[f64; M]) -> Result<Look<X, D, M>, StepFailure>,
        slopes: impl Fn(&Look<X, D, M>) -> Option<[[f64; M]; M]>,
    ) -> Result<([f64; M], Look<X, D, M>), StepFailure> {
        let mut residuals = [0.0; MAX_CORRECTIONS];
        let mut last = f64::INFINITY;
        for k in 0..MAX_CORRECTIONS {
            let seen = look(&sigma)?;
            let (equation, roundings) = worst(&seen.value, &seen.size);
            residuals[k] = roundings;
            if roundings <= 1.0 || (roundings >= last && roundings <= NOISE) {
                return Ok((sigma, seen));
            }
            let correction = slopes(&seen).and_then(|slopes| solve(slopes, seen.value));
            let Some(correction) = correction.filter(|_| k + 1 < MAX_CORRECTIONS) else {
                let residuals = residuals[..=k].iter().copied().collect();
                return Err(StepFailure::NoSlide { equation, residuals, h });
            };
            sigma = from_fn(|i| sigma[i] - correction[i]);
            last = roundings;
        }
        unreachable!("the last correction is never made")
    }
}

/// The largest |xᵢ|/(ε sizeᵢ), and which; NaN counts as largest.
fn worst<const M: usize>(x: &[f64; M], sizes: &[f64; M]) -> (usize, f64) {
    let mut worst = (0, 0.0);
    for i in 0..M {
        let roundings = if x[i] == 0.0 { 0.0 } else { x[i].abs() / (f64::EPSILON * sizes[i]) };
        if roundings.is_nan() || roundings > worst.1 {
            worst = (i, roundings);
        }
    }
    worst
}

impl<K, H, N, const M: usize> InPhaseSpace<K, H, N, M> {
    fn hidden<const D: usize>(&self, at: &Point<D>) -> Hidden<D, M>
    where
        K: PhaseConstraintKernel<f64, D, M>,
        H: HamiltonianKernel<f64, D>,
    {
        Hidden::of(&self.constraint, &self.energy, at, at)
    }

    /// From the body's point by h/2 λ along its fibre and by Φₕ to g = 0; with the slide.
    fn land<const D: usize>(
        &self,
        h: f64,
        body: &Body<f64, D>,
        guess: [f64; M],
    ) -> Result<([f64; M], Point<D>), StepFailure>
    where
        K: PhaseConstraintKernel<f64, D, M>,
        H: HamiltonianKernel<f64, D>,
    {
        let (start, low) = (Point::high(body), Point::low(body));
        let (sigma, seen) = Self::solve(
            h,
            guess,
            |sigma| {
                let slid = slide(&self.constraint, &start, sigma).ok_or_else(|| too_far(h))?;
                let kicked = start.plus(&low.plus(&slid));
                let step = Verlet::of(&self.energy, h, &kicked);
                let unsolved = || StepFailure::ImplicitStep { h, position: start.q.to_vec() };
                let step = step.ok_or_else(unsolved)?;
                let change = slid.plus(&step.change);
                let level =
                    Level::of(&self.constraint, &start.plus(&low.plus(&change)), &start.reach(&change));
                if !level.value.iter().all(|g| g.is_finite()) {
                    return Err(not_finite(&start));
                }
                Ok(Look { change, value: level.value, size: level.size, rest: (kicked, step, level) })
            },
            |Look { rest: (kicked, step, level), .. }| {
                let mut slopes = [[0.0; M]; M];
                let there = Level::of(&self.constraint, kicked, kicked);
                for j in 0..M {
                    let v = step.tangent(&self.energy, h, &there.fibre(j))?;
                    for i in 0..M {
                        let gradient = &level.gradients[i];
                        slopes[i][j] = dot(&gradient.q, &v.q) + dot(&gradient.p, &v.p);
                    }
                }
                Some(slopes)
            },
        )?;
        Ok((sigma, seen.change))
    }

    /// From the body's point along its fibre to where the hidden constraint holds; with the slide and N there.
    #[allow(clippy::type_complexity, reason = "three numbers of one slide")]
    fn slide_to_hidden<const D: usize>(
        &self,
        h: f64,
        body: &Body<f64, D>,
    ) -> Result<([f64; M], Point<D>, [[f64; M]; M]), StepFailure>
    where
        K: PhaseConstraintKernel<f64, D, M>,
        H: HamiltonianKernel<f64, D>,
    {
        let (start, low) = (Point::high(body), Point::low(body));
        let look = |sigma: &[f64; M]| {
            let change = slide(&self.constraint, &start, sigma).ok_or_else(|| too_far(h))?;
            let at = start.plus(&low.plus(&change));
            let hidden = Hidden::of(&self.constraint, &self.energy, &at, &start.reach(&change));
            Ok(Look { change, value: hidden.value, size: hidden.size, rest: hidden.slopes })
        };
        let (sigma, seen) = Self::solve(h, [0.0; M], look, |seen| Some(seen.rest))?;
        Ok((sigma, seen.change, seen.rest))
    }

    fn check<const D: usize>(&self, body: &Body<f64, D>) -> Result<(), StartFailure>
    where
        K: PhaseConstraintKernel<f64, D, M>,
        H: HamiltonianKernel<f64, D>,
    {
        finite("position", &body.q)?;
        finite("momentum", &body.p)?;
        let at = Point::high(body);
        let (level, hidden) = (Level::of(&self.constraint, &at, &at), self.hidden(&at));
        let mistake = |mistake| Err(StartFailure::Phase(mistake));
        let tolerance = START_TOLERANCE / f64::EPSILON;
        let (equation, off) = worst(&level.value, &level.size);
        if off.is_nan() || off > tolerance {
            let (value, share) = (level.value[equation], off * f64::EPSILON);
            return mistake(PhaseMistake::Off { equation, value, share, tolerance: START_TOLERANCE });
        }
        for second in 1..M {
            for first in 0..second {
                let (bracket, size) = level.bracket(first, second);
                if bracket.is_nan() || bracket.abs() > START_TOLERANCE * size {
                    let share = bracket.abs() / size;
                    return mistake(PhaseMistake::NotCoisotropic { first, second, bracket, share });
                }
            }
        }
        if hidden.is_undetermined() {
            return mistake(PhaseMistake::Undetermined { slopes: hidden.slopes.concat() });
        }
        let (equation, off) = worst(&hidden.value, &hidden.size);
        if off.is_nan() || off > tolerance {
            let (rate, share) = (hidden.value[equation], off * f64::EPSILON);
            return mistake(PhaseMistake::Hidden { equation, rate, share, tolerance: START_TOLERANCE });
        }
        Ok(())
    }

    /// The nearest point of g = 0, to first order, slid to the hidden constraint.
    fn project<const D: usize>(&self, body: &Body<f64, D>) -> Result<Point<D>, StartFailure>
    where
        K: PhaseConstraintKernel<f64, D, M>,
        H: HamiltonianKernel<f64, D>,
    {
        finite("position", &body.q)?;
        finite("momentum", &body.p)?;
        let mut at = Point::high(body);
        let (mut distances, mut last) = (Vec::new(), f64::INFINITY);
        for _ in 0..MAX_PROJECTION_STEPS {
            let Level { value, gradients, size } = Level::of(&self.constraint, &at, &at);
            let (_, roundings) = worst(&value, &size);
            if roundings <= 1.0 || (roundings >= 0.5 * last && roundings <= NOISE) {
                let body = Body { q: at.q, q_low: [0.0; D], p: at.p, p_low: [0.0; D] };
                let slid = self.slide_to_hidden(0.0, &body);
                return match slid {
                    Ok((_, change, _)) => Ok(at.plus(&change)),
                    Err(StepFailure::NoSlide { equation, residuals, .. }) => {
                        Err(StartFailure::Phase(PhaseMistake::NoSlide { equation, residuals }))
                    }
                    Err(_) => Err(StartFailure::NoProjection { distances: distances.into_iter().collect() }),
                };
            }
            let product = |a: &Point<D>, b: &Point<D>| dot(&a.q, &b.q) + dot(&a.p, &b.p);
            let products = from_fn(|i| from_fn(|j| product(&gradients[i], &gradients[j])));
            let Some(weights) = solve(products, value) else { break };
            let step = (0..M).fold(Point::ZERO, |sum, i| sum.plus(&gradients[i].times(-weights[i])));
            distances.push(product(&step, &step).sqrt());
            at = at.plus(&step);
            last = roundings;
        }
        Err(StartFailure::NoProjection { distances: distances.into_iter().collect() })
    }
}

/// A slide that leads out of the domain of g, or many times around.
#[cold]
fn too_far(h: f64) -> StepFailure {
    StepFailure::NoSlide { equation: 0, residuals: History::default(), h }
}

#[cold]
fn not_finite<const D: usize>(start: &Point<D>) -> StepFailure {
    StepFailure::ConstraintNotFinite { position: start.q.to_vec() }
}

impl<K, H, N, const D: usize, const M: usize> System<f64, D> for InPhaseSpace<K, H, N, M>
where
    K: PhaseConstraintKernel<f64, D, M>,
    H: HamiltonianKernel<f64, D>,
    N: Count,
{
    type Count = N;
    /// N at the points.
    type Kept = N::Of<[[f64; M]; M]>;

    fn bodies(&self, place: impl Fn(usize) -> Body<f64, D>, time: f64) -> BodiesOf<N, D, M> {
        let mut bodies = Bodies::new(self.count, self.count.each([[0.0; M]; M]), place, time);
        self.refresh(&mut bodies);
        bodies
    }

    fn refresh(&self, bodies: &mut BodiesOf<N, D, M>) {
        for number in 0..self.count.number() {
            let at = Point::high(&bodies.body(number));
            bodies.kept.as_mut()[number] = self.hidden(&at).slopes;
        }
    }

    fn drift_by<X: Iteration, W: Witness<f64>>(
        &self,
        _: f64,
        h: f64,
        _: &[f64],
        bodies: &mut BodiesOf<N, D, M>,
        witness: &mut W,
    ) -> Result<(), Failure> {
        for number in 0..self.count.number() {
            let body = bodies.body(number);
            let fail = |cause| Failure { body: number, cause };
            let guess = self.hidden(&Point::high(&body)).multipliers();
            let guess = guess.ok_or_else(|| fail(StepFailure::Undetermined { change: f64::INFINITY, h }))?;
            let landed = self.land(h, &body, guess.map(|lambda| 0.5 * h * lambda));
            let (sigma, change) = landed.map_err(fail)?;
            for (i, sigma) in sigma.into_iter().enumerate() {
                witness.position_multiplier(number * M + i, sigma / (0.5 * h));
            }
            move_by(bodies, number, &change);
        }
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
            let (sigma, change, slopes) = self.slide_to_hidden(h, &bodies.body(number)).map_err(fail)?;
            let turned = turn(&bodies.kept.as_ref()[number], &slopes);
            if turned > TURN {
                return Err(fail(StepFailure::Undetermined { change: turned, h }));
            }
            for (i, sigma) in sigma.into_iter().enumerate() {
                witness.momentum_multiplier(number * M + i, sigma / (0.5 * h));
            }
            move_by(bodies, number, &change);
            bodies.kept.as_mut()[number] = slopes;
        }
        Ok(())
    }

    fn collocate<W: Witness<f64>, const S: usize>(
        &self,
        _: &Table<S>,
        _: f64,
        _: &mut BodiesOf<N, D, M>,
        _: &mut [f64],
        _: &mut W,
    ) -> Result<(), Failure> {
        Err(Failure { body: 0, cause: StepFailure::NoCollocation { system: IN_PHASE_SPACE } })
    }

    /// Not known here: forces and momenta are not apart. Methods that ask are refused before a run.
    fn rates<W: Witness<f64>>(&self, _: &mut BodiesOf<N, D, M>, rates: &mut [[f64; D]], _: &mut W) -> f64 {
        rates.fill([f64::NAN; D]);
        f64::NAN
    }

    fn project(&self, _: f64, _: &mut BodiesOf<N, D, M>) -> Result<(), Failure> {
        Err(Failure { body: 0, cause: StepFailure::NoCollocation { system: IN_PHASE_SPACE } })
    }

    fn refuses(&self, need: Need) -> Option<&'static str> {
        (need != Need::Verbs).then_some(IN_PHASE_SPACE)
    }

    fn equations(&self) -> usize {
        self.count.number() * M
    }

    /// q̇ = ∂H/∂p − (∂g/∂p)ᵀλ.
    fn velocity(&self, bodies: &BodiesOf<N, D, M>, body: usize) -> [f64; D] {
        self.flow(&Point::high(&bodies.body(body))).q
    }

    /// No metric is known here: NaN, and so is a shadow energy.
    fn mass_product(&self, _: usize, _: &[f64; D], _: &[f64; D]) -> f64 {
        f64::NAN
    }

    /// NaN: q̈ has third derivatives in it.
    fn accelerations(&self, _: &BodiesOf<N, D, M>, accelerations: &mut [[f64; D]]) {
        accelerations.fill([f64::NAN; D]);
    }

    /// The part (∂g/∂q)ᵀλ that acts on momenta.
    fn constraint_forces(&self, bodies: &BodiesOf<N, D, M>, forces: &mut [[f64; D]]) {
        for (number, force) in forces.iter_mut().enumerate() {
            let at = Point::high(&bodies.body(number));
            *force = self.pull(&at).p;
        }
    }

    /// H: what of it is kinetic is not told.
    fn kinetic_energy<X>(&self, bodies: &Bodies<N, f64, X, D>) -> f64 {
        let energy = |body: Body<f64, D>| {
            let (by_q, by_p) = self.energy.gradients(&body.q, &body.p);
            self.energy.value(&body.q, &body.p) + (dot(&by_q, &body.q_low) + dot(&by_p, &body.p_low))
        };
        (0..self.count.number()).map(|number| energy(bodies.body(number))).sum()
    }

    fn potential_energy<X>(&self, _: &Bodies<N, f64, X, D>) -> f64 {
        0.0
    }

    fn residuals(&self, bodies: &BodiesOf<N, D, M>, g: &mut [f64]) {
        for (g, number) in g.chunks_exact_mut(M).zip(0..) {
            let body = bodies.body(number);
            g.copy_from_slice(&self.constraint.value(&body.q, &body.p));
        }
    }

    /// The hidden constraint {g, H}.
    fn drift_rates(&self, bodies: &BodiesOf<N, D, M>, rates: &mut [f64]) {
        for (rates, number) in rates.chunks_exact_mut(M).zip(0..) {
            rates.copy_from_slice(&self.hidden(&Point::high(&bodies.body(number))).value);
        }
    }

    fn multipliers(&self, bodies: &BodiesOf<N, D, M>, multipliers: &mut [f64]) {
        for (multipliers, number) in multipliers.chunks_exact_mut(M).zip(0..) {
            let found = self.hidden(&Point::high(&bodies.body(number))).multipliers();
            multipliers.copy_from_slice(&found.unwrap_or([f64::NAN; M]));
        }
    }
}

impl<K, H, N, const M: usize> InPhaseSpace<K, H, N, M> {
    /// Σ λᵢ (−∂gᵢ/∂p, ∂gᵢ/∂q).
    fn pull<const D: usize>(&self, at: &Point<D>) -> Point<D>
    where
        K: PhaseConstraintKernel<f64, D, M>,
        H: HamiltonianKernel<f64, D>,
    {
        let level = Level::of(&self.constraint, at, at);
        let multipliers = self.hidden(at).multipliers().unwrap_or([f64::NAN; M]);
        (0..M).fold(Point::ZERO, |sum, i| sum.plus(&level.fibre(i).times(multipliers[i])))
    }

    /// (q̇, ṗ).
    fn flow<const D: usize>(&self, at: &Point<D>) -> Point<D>
    where
        K: PhaseConstraintKernel<f64, D, M>,
        H: HamiltonianKernel<f64, D>,
    {
        let (by_q, by_p) = self.energy.gradients(&at.q, &at.p);
        Point { q: by_p, p: by_q.map(|x| -x) }.plus(&self.pull(at))
    }
}

fn move_by<N: Count, X, const D: usize>(bodies: &mut Bodies<N, f64, X, D>, number: usize, change: &Point<D>) {
    let (q, q_low) = (&mut bodies.q.as_mut()[number], &mut bodies.q_low.as_mut()[number]);
    (*q, *q_low) = two_sum(q, &sum(q_low, &change.q));
    let (p, p_low) = (&mut bodies.p.as_mut()[number], &mut bodies.p_low.as_mut()[number]);
    (*p, *p_low) = two_sum(p, &sum(p_low, &change.p));
}

/// The largest entry of N⁻¹N′ − 1.
fn turn<const M: usize>(before: &[[f64; M]; M], after: &[[f64; M]; M]) -> f64 {
    let mut largest = 0.0_f64;
    for j in 0..M {
        let Some(column) = solve(*before, from_fn(|i| after[i][j])) else { return f64::INFINITY };
        for (i, x) in column.into_iter().enumerate() {
            largest = largest.max((x - f64::from(u8::from(i == j))).abs());
        }
    }
    largest
}
