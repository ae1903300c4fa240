//! The halves of a step in phase space: along fibres to g = 0 and to {g, H} = 0.

use crate::error::{History, PhaseFailure, PhaseMistake, StartFailure, StepFailure};
use crate::kernel::functions::{HamiltonianKernel, PhaseConstraintKernel};
use crate::motion::bodies::{Bodies, Body, Count};
use crate::motion::start::{MAX_PROJECTION_STEPS, START_TOLERANCE, finite};
use crate::number::linear::solve;
use crate::number::vector::{sum, two_sum};
use crate::systems::phase::fibre::Slides;
use crate::systems::phase::kept::InPhaseSpace;
use crate::systems::phase::noise::{NOISE, beyond};
use crate::systems::phase::point::{Hidden, Level, Point};
use std::array::from_fn;

/// Corrections of a slide after which it is given up; four suffice where there is one.
const MAX_CORRECTIONS: usize = 20;
/// Halvings of one correction of a start: from σ on the straight part of an energy full ones lead some σ³ away.
const MAX_HALVINGS: i32 = 60;
/// A correction by a part of itself must take this share of that part from the largest value.
const FALL: f64 = 0.25;
/// N at one end of a step may differ from that at the other by as much as that other: it may double, or halve.
pub(crate) const TURN: f64 = 1.0;

/// Somewhere along a fibre: how the point changes until there, and the numbers that shall vanish.
pub(super) struct Look<X, const D: usize, const M: usize> {
    pub(super) change: Point<D>,
    pub(super) value: [f64; M],
    /// The sizes of their terms.
    pub(super) size: [f64; M],
    /// The same if all coordinates were as large as the largest: what is below its rounding, and shrinks no more, is
    /// nothing, also where a coordinate is zero.
    pub(super) extent: [f64; M],
    /// What their slopes are made of.
    pub(super) rest: X,
}

/// The σ for which what is looked at vanishes, to its rounding, and what is seen there. Where the largest value no
/// longer falls, and is more than some roundings, `noise` tells what each value may be by rounding.
pub(super) fn solve_along<X, const D: usize, const M: usize>(
    h: f64,
    mut sigma: [f64; M],
    mut look: impl FnMut(&[f64; M]) -> Result<Look<X, D, M>, StepFailure>,
    mut slopes: impl FnMut(&Look<X, D, M>) -> Option<[[f64; M]; M]>,
    noise: impl Fn(&Look<X, D, M>) -> [f64; M],
) -> Result<([f64; M], Look<X, D, M>), StepFailure> {
    let mut residuals = [0.0; MAX_CORRECTIONS];
    let mut last = f64::INFINITY;
    for k in 0..MAX_CORRECTIONS {
        let seen = look(&sigma)?;
        let (equation, roundings) = worst(&seen.value, &seen.size);
        residuals[k] = roundings;
        let is_noise = || {
            roundings <= NOISE
                || worst(&seen.value, &seen.extent).1 <= 1.0
                || worst(&beyond(&seen.value, &noise(&seen)), &seen.size).1 <= 1.0
        };
        if roundings <= 1.0 || (roundings >= last && is_noise()) {
            return Ok((sigma, seen));
        }
        let correction = slopes(&seen).and_then(|slopes| solve(slopes, seen.value));
        let Some(correction) = correction.filter(|_| k + 1 < MAX_CORRECTIONS) else {
            let residuals = residuals[..=k].iter().copied().collect();
            return Err(PhaseFailure::NoSlide { equation, residuals, h }.into());
        };
        sigma = from_fn(|i| sigma[i] - correction[i]);
        last = roundings;
    }
    unreachable!("the last correction is never made")
}

/// As [`solve_along`], from far away, for a start: a correction is halved until the largest value falls, in units of
/// the sizes where the correction begins, since sizes change on a long way. Without a place where it falls, or after
/// too many corrections: which value, and what the largest were.
fn solve_from_afar<X, const D: usize, const M: usize>(
    mut look: impl FnMut(&[f64; M]) -> Option<Look<X, D, M>>,
    slopes: impl Fn(&Look<X, D, M>) -> [[f64; M]; M],
) -> Result<Look<X, D, M>, PhaseMistake> {
    let (mut sigma, mut residuals, mut equation) = ([0.0; M], Vec::new(), 0);
    let mut next = look(&sigma);
    while let Some(seen) = next {
        let last = residuals.last().copied().unwrap_or(f64::INFINITY);
        let roundings;
        (equation, roundings) = worst(&seen.value, &seen.size);
        residuals.push(roundings);
        if roundings <= 1.0 || (roundings >= last && roundings <= NOISE) {
            return Ok(seen);
        }
        let correction = solve(slopes(&seen), seen.value).filter(|_| residuals.len() < MAX_PROJECTION_STEPS);
        let Some(correction) = correction else { break };
        next = (0..=MAX_HALVINGS).find_map(|halvings| {
            let part = 0.5_f64.powi(halvings);
            let there = from_fn(|i| sigma[i] - part * correction[i]);
            let found = look(&there)?;
            let falls = worst(&found.value, &seen.size).1 <= (1.0 - FALL * part) * roundings;
            let stays = roundings <= NOISE && worst(&found.value, &found.size).1 <= NOISE;
            (falls || stays).then(|| {
                sigma = there;
                found
            })
        });
    }
    Err(PhaseMistake::NoSlide { equation, residuals: residuals.into_iter().collect() })
}

/// The largest |xᵢ|/(ε sizeᵢ), and which; NaN counts as largest.
pub(super) fn worst<const M: usize>(x: &[f64; M], sizes: &[f64; M]) -> (usize, f64) {
    let mut worst = (0, 0.0);
    for i in 0..M {
        let roundings = if x[i] == 0.0 { 0.0 } else { x[i].abs() / (f64::EPSILON * sizes[i]) };
        if roundings.is_nan() || roundings > worst.1 {
            worst = (i, roundings);
        }
    }
    worst
}

/// The value that is off zero by more than a start may be, and by more than rounding; and by how many roundings.
fn off_zero<const M: usize>(
    value: &[f64; M],
    size: &[f64; M],
    extent: &[f64; M],
    noise: impl FnOnce() -> [f64; M],
) -> Option<(usize, f64)> {
    let holds = |value: &[f64; M]| {
        worst(value, size).1 * f64::EPSILON <= START_TOLERANCE || worst(value, extent).1 <= NOISE
    };
    if holds(value) {
        return None;
    }
    let rest = beyond(value, &noise());
    (!holds(&rest)).then(|| worst(&rest, size))
}

/// Two equations whose bracket is not zero, and what part of its terms it is.
struct Clash {
    first: usize,
    second: usize,
    bracket: f64,
    share: f64,
}

impl Clash {
    #[cold]
    fn at<const D: usize>(self, at: &Point<D>, h: f64) -> StepFailure {
        let Self { first, second, bracket, share } = self;
        let (position, momentum) = (at.q.to_vec(), at.p.to_vec());
        PhaseFailure::NotCoisotropic { first, second, bracket, share, position, momentum, h }.into()
    }
}

impl From<Clash> for PhaseMistake {
    fn from(Clash { first, second, bracket, share }: Clash) -> Self {
        Self::NotCoisotropic { first, second, bracket, share }
    }
}

/// Whether the brackets of all equations are zero: against their terms, or where these are nothing themselves, at the
/// rounding of coordinates that were as large as those of `reach`, which is asked only then.
#[inline(always)]
fn commute<K, const D: usize, const M: usize>(
    constraint: &K,
    level: &Level<D, M>,
    at: &Point<D>,
    reach: impl Fn() -> Point<D>,
) -> Result<(), Clash>
where
    K: PhaseConstraintKernel<f64, D, M>,
{
    for second in 1..M {
        for first in 0..second {
            let (bracket, size) = level.bracket(first, second);
            let rounding = || {
                let slopes = level.slopes_of_bracket(constraint, at, first, second);
                NOISE * f64::EPSILON * slopes.size_along(&reach().most())
            };
            let vanishes = bracket.abs() <= START_TOLERANCE * size || bracket.abs() <= rounding();
            if !vanishes {
                return Err(Clash { first, second, bracket, share: bracket.abs() / size });
            }
        }
    }
    Ok(())
}

/// g and H of one body.
pub(super) struct Functions<'a, K, H, const D: usize, const M: usize> {
    pub(super) constraint: &'a K,
    pub(super) energy: &'a H,
}

impl<K, H, N, const M: usize> InPhaseSpace<K, H, N, M> {
    #[inline(always)]
    pub(super) fn functions<const D: usize>(&self) -> Functions<'_, K, H, D, M> {
        Functions { constraint: &self.constraint, energy: &self.energy }
    }
}

impl<K, H, const D: usize, const M: usize> Functions<'_, K, H, D, M>
where
    K: PhaseConstraintKernel<f64, D, M>,
    H: HamiltonianKernel<f64, D>,
{
    pub(super) fn hidden(&self, at: &Point<D>) -> Hidden<D, M> {
        Hidden::of(self.constraint, self.energy, at, at)
    }

    /// From the body's point along its fibre to where the hidden constraint holds; with the slide and N there. Fibres
    /// of equations that do not commute there have led off g = 0.
    #[allow(clippy::type_complexity, reason = "three numbers of one slide")]
    pub(super) fn slide_to_hidden(
        &self,
        h: f64,
        body: &Body<f64, D>,
    ) -> Result<([f64; M], Point<D>, [[f64; M]; M]), StepFailure> {
        let (start, low) = (Point::high(body), Point::low(body));
        let mut slides = Slides::new();
        let look =
            |sigma: &[f64; M]| self.look_along(&start, &low, sigma, &mut slides).ok_or_else(|| too_far(h));
        let noise = |Look { change, rest, .. }: &Look<Hidden<D, M>, D, M>| {
            let at = start.plus(&low.plus(change));
            let reach = self.reach_of_step(&start.reach(change), &at, h);
            rest.noise(self.constraint, self.energy, &at, &reach)
        };
        let (sigma, Look { change, rest: Hidden { level, slopes, .. }, .. }) =
            solve_along(h, [0.0; M], look, |seen| Some(seen.rest.slopes), noise)?;
        if const { M > 1 } {
            let at = start.plus(&low.plus(&change));
            // A body that comes to rest has momenta of the rounding of what the step gave and took.
            commute(self.constraint, &level, &at, || self.reach_of_step(&start.reach(&change), &at, h))
                .map_err(|clash| clash.at(&at, h))?;
        }
        Ok((sigma, change, slopes))
    }

    /// The hidden constraint after a slide, and what goes with it; none if that leads too far.
    #[inline(always)]
    fn look_along(
        &self,
        start: &Point<D>,
        low: &Point<D>,
        sigma: &[f64; M],
        slides: &mut Slides<D, M>,
    ) -> Option<Look<Hidden<D, M>, D, M>> {
        let change = slides.slide(self.constraint, start, sigma)?;
        let at = start.plus(&low.plus(&change));
        let hidden = Hidden::of(self.constraint, self.energy, &at, &start.reach(&change));
        let Hidden { value, size, extent, .. } = hidden;
        Some(Look { change, value, size, extent, rest: hidden })
    }

    /// Whether a body can start here, in steps of h.
    pub(super) fn check(&self, h: f64, body: &Body<f64, D>) -> Result<(), StartFailure> {
        finite("position", &body.q)?;
        finite("momentum", &body.p)?;
        let at = Point::high(body);
        self.check_energy(&at)?;
        let hidden = self.hidden(&at);
        let level = &hidden.level;
        let mistake = |mistake| Err(StartFailure::Phase(mistake));
        // A body at rest has momenta of the rounding of what a step gives and takes.
        let reach = self.reach_of_step(&at, &at, h);
        // Where all terms are nothing, as those of q·p at q = 0, g is what rounding leaves of larger coordinates.
        let extent = level.extent_of(&reach);
        let noise = || level.noise(self.constraint, &at, &reach);
        if let Some((equation, off)) = off_zero(&level.value, &level.size, &extent, noise) {
            let (value, share) = (level.value[equation], off * f64::EPSILON);
            return mistake(PhaseMistake::Off { equation, value, share, tolerance: START_TOLERANCE });
        }
        commute(self.constraint, level, &at, || reach).map_err(|clash| StartFailure::Phase(clash.into()))?;
        if hidden.is_undetermined(&at) {
            let slopes = hidden.slopes.concat();
            return mistake(level.dependent(&at).unwrap_or(PhaseMistake::Undetermined { slopes }));
        }
        let extent = hidden.extent_of(&reach);
        let noise = || hidden.noise(self.constraint, self.energy, &at, &reach);
        if let Some((equation, off)) = off_zero(&hidden.value, &hidden.size, &extent, noise) {
            let (rate, share) = (hidden.value[equation], off * f64::EPSILON);
            return mistake(PhaseMistake::Hidden { equation, rate, share, tolerance: START_TOLERANCE });
        }
        Ok(())
    }

    fn check_energy(&self, at: &Point<D>) -> Result<(), StartFailure> {
        let (value, (by_q, by_p)) = (self.energy.value(&at.q, &at.p), self.energy.gradients(&at.q, &at.p));
        let gradient = [by_q, by_p].concat();
        if value.is_finite() && gradient.iter().all(|x| x.is_finite()) {
            return Ok(());
        }
        Err(StartFailure::Phase(PhaseMistake::HamiltonianNotFinite { value, gradient }))
    }

    /// The nearest point of g = 0, to first order, slid to the hidden constraint.
    pub(super) fn project(&self, body: &Body<f64, D>) -> Result<Point<D>, StartFailure> {
        finite("position", &body.q)?;
        finite("momentum", &body.p)?;
        let start = Point::high(body);
        self.check_energy(&start)?;
        let (mut at, mut distances, mut last) = (start, Vec::new(), f64::INFINITY);
        let mut failure = None;
        for _ in 0..MAX_PROJECTION_STEPS {
            let level = Level::of(self.constraint, &at, &at);
            let Level { value, gradients, size, .. } = level;
            let (_, roundings) = worst(&value, &size);
            let is_noise = || {
                let noise = || level.noise(self.constraint, &at, &at);
                roundings <= NOISE || worst(&beyond(&value, &noise()), &size).1 <= 1.0
            };
            if roundings <= 1.0 || (last <= 2.0 * roundings && is_noise()) {
                // Else fibres lead off g = 0.
                match self.slide_start(&level, &at) {
                    Ok(there) => return Ok(there),
                    Err(mistake) => failure = Some(mistake),
                }
                break;
            }
            last = roundings;
            let products = from_fn(|i| from_fn(|j| gradients[i].along(&gradients[j])));
            let Some(weights) = solve(products, value) else { break };
            let step = (0..M).fold(Point::ZERO, |sum, i| sum.plus(&gradients[i].times(-weights[i])));
            distances.push(step.along(&step).sqrt());
            at = at.plus(&step);
        }
        // Where gradients depend on each other, corrections may have led anywhere.
        let places = if failure.is_some() { vec![at] } else { vec![at, start] };
        let dependent = places.iter().find_map(|at| Level::of(self.constraint, at, at).dependent(at));
        Err(match dependent.or(failure) {
            Some(mistake) => StartFailure::Phase(mistake),
            None => StartFailure::NoProjection { distances: distances.into_iter().collect() },
        })
    }

    /// A point of g = 0 slid to the hidden constraint: once, which leaves the rounding of the way there, and from there
    /// again.
    fn slide_start(&self, level: &Level<D, M>, at: &Point<D>) -> Result<Point<D>, PhaseMistake> {
        commute(self.constraint, level, at, || *at)?;
        let change = self.slide_from_afar(at)?;
        let there = at.plus(&change);
        let next = Level::of(self.constraint, &there, &there);
        commute(self.constraint, &next, &there, || at.reach(&change))?;
        Ok(self.slide_from_afar(&there).map_or(there, |change| there.plus(&change)))
    }

    /// The change along the fibre to the hidden constraint, from however far: the largest {g, H} falls with each
    /// correction, or where it cannot, full corrections are tried.
    fn slide_from_afar(&self, start: &Point<D>) -> Result<Point<D>, PhaseMistake> {
        // Where H overflows, {g, H} may be zero by that alone.
        let finite = |change: &Point<D>| {
            let at = start.plus(change);
            self.energy.value(&at.q, &at.p).is_finite()
        };
        let mut slides = Slides::new();
        let look = |sigma: &[f64; M]| {
            let seen = self.look_along(start, &Point::ZERO, sigma, &mut slides);
            seen.filter(|seen| finite(&seen.change))
        };
        solve_from_afar(look, |seen| seen.rest.slopes).map(|seen| seen.change).or_else(|mistake| {
            let body = Body { q: start.q, q_low: [0.0; D], p: start.p, p_low: [0.0; D] };
            match self.slide_to_hidden(0.0, &body) {
                Ok((_, change, _)) if finite(&change) => Ok(change),
                Err(StepFailure::Phase(PhaseFailure::NotCoisotropic {
                    first,
                    second,
                    bracket,
                    share,
                    ..
                })) => Err(Clash { first, second, bracket, share }.into()),
                _ => Err(mistake),
            }
        })
    }

    /// Σ λᵢ (−∂gᵢ/∂p, ∂gᵢ/∂q).
    pub(super) fn pull(&self, at: &Point<D>) -> Point<D> {
        let level = Level::of(self.constraint, at, at);
        let multipliers = self.hidden(at).multipliers().unwrap_or([f64::NAN; M]);
        (0..M).fold(Point::ZERO, |sum, i| sum.plus(&level.fibre(i).times(multipliers[i])))
    }

    /// (q̇, ṗ) without constraint.
    fn free(&self, at: &Point<D>) -> Point<D> {
        let (by_q, by_p) = self.energy.gradients(&at.q, &at.p);
        Point { q: by_p, p: by_q.map(|x| -x) }
    }

    /// This reach, or what a step of h from a point gives and takes, whichever is larger.
    pub(super) fn reach_of_step(&self, reach: &Point<D>, at: &Point<D>, h: f64) -> Point<D> {
        reach.reach(&self.free(at).times(h))
    }

    /// (q̇, ṗ).
    pub(super) fn flow(&self, at: &Point<D>) -> Point<D> {
        self.free(at).plus(&self.pull(at))
    }
}

/// A slide that leads out of the domain of g, or many times around.
#[cold]
pub(super) fn too_far(h: f64) -> StepFailure {
    PhaseFailure::NoSlide { equation: 0, residuals: History::default(), h }.into()
}

#[cold]
pub(super) fn not_finite<const D: usize>(start: &Point<D>, change: &Point<D>) -> StepFailure {
    let (position, momentum) = (start.q.to_vec(), start.p.to_vec());
    if change.q.iter().chain(&change.p).all(|x| x.is_finite()) {
        StepFailure::ConstraintNotFinite { position }
    } else {
        PhaseFailure::HamiltonianNotFinite { position, momentum }.into()
    }
}

pub(super) fn move_by<N: Count, X, const D: usize>(
    bodies: &mut Bodies<N, f64, X, D>,
    number: usize,
    change: &Point<D>,
) {
    let (q, q_low) = (&mut bodies.q.as_mut()[number], &mut bodies.q_low.as_mut()[number]);
    (*q, *q_low) = two_sum(q, &sum(q_low, &change.q));
    let (p, p_low) = (&mut bodies.p.as_mut()[number], &mut bodies.p_low.as_mut()[number]);
    (*p, *p_low) = two_sum(p, &sum(p_low, &change.p));
}

/// The largest entry of N⁻¹N′ − 1 and of N′⁻¹N − 1: the same for a step and its way back.
pub(super) fn turn_both_ways<const M: usize>(one: &[[f64; M]; M], other: &[[f64; M]; M]) -> f64 {
    turn(one, other).max(turn(other, one))
}

/// The largest entry of N⁻¹N′ − 1; with equations in their own units or in those of their diagonal entries, whichever
/// is less: these may be far apart, and a diagonal entry may pass zero.
pub(super) fn turn<const M: usize>(before: &[[f64; M]; M], after: &[[f64; M]; M]) -> f64 {
    let units: [f64; M] = from_fn(|i| if before[i][i] == 0.0 { 1.0 } else { before[i][i].abs().sqrt() });
    let mut largest = [0.0_f64; 2];
    for j in 0..M {
        let Some(column) = solve(*before, from_fn(|i| after[i][j])) else { return f64::INFINITY };
        for (i, x) in column.into_iter().enumerate() {
            let off = (x - f64::from(u8::from(i == j))).abs();
            largest = [largest[0].max(off), largest[1].max(off * (units[i] / units[j]))];
        }
    }
    largest[0].min(largest[1])
}
