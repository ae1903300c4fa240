//! The first half of a step, which must end on the sheet of g = 0 that continues the motion.
//!
//! Newton's iteration finds a point of g = 0 along the fibre. Where sheets of g are near each other it may be on a
//! wrong one. That is detected as on surfaces ([`crate::solve::aim`], [`crate::solve::root`]), equation by equation, by
//! the value of g at the guess relative to the size of its terms. If this error is as expected from earlier steps, the
//! result is accepted. If not, g is examined inside the step, and where that fails the root is followed from h = 0.
//!
//! The unknown that is followed is Λ = s σ after the fraction s of a step: like the displacement by a constraint on a
//! surface it is proportional to s², and the error of its guess to s³.

use crate::error::{PhaseFailure, StepFailure};
use crate::kernel::functions::{HamiltonianKernel, PhaseConstraintKernel};
use crate::solve::aim::{GROWTH, INSIDE, INSIDE_PARTS, LITTLE_OFF, ROUNDINGS, grows_to};
use crate::solve::root::{Course, FAR_EXTRAPOLATION, FAR_GUESS, Part, SHORT_PATH, follow, straight};
use crate::systems::phase::fibre::Slides;
use crate::systems::phase::kept::OfBody;
use crate::systems::phase::noise::NOISE;
use crate::systems::phase::point::{Level, Point, Verlet};
use crate::systems::phase::step::{Functions, Look, not_finite, solve_along, too_far, turn};
use std::array::from_fn;

/// Slopes at a guess and where it leads differ by at most this part: that far from another sheet they differ by more in
/// six of seven cases.
pub(crate) const STEADY: f64 = 0.05;

/// Slopes where a slide leads may differ by this part from those at its start.
pub(crate) const TILT: f64 = 0.5;

/// A step, as it departs.
pub(super) struct Departure<'a, K, H, const D: usize, const M: usize> {
    pub(super) functions: Functions<'a, K, H, D, M>,
    pub(super) h: f64,
    pub(super) start: Point<D>,
    pub(super) low: Point<D>,
    /// σ of the whole step, if the hidden constraint is to stay.
    pub(super) guess: [f64; M],
}

/// After some share of a step and a slide.
struct There<const D: usize, const M: usize> {
    change: Point<D>,
    kicked: Point<D>,
    step: Verlet<D>,
    level: Level<D, M>,
}

/// Where a slide was found that satisfies g = 0.
#[derive(Clone, Copy)]
pub(super) struct Landing<const D: usize, const M: usize> {
    pub(super) sigma: [f64; M],
    pub(super) change: Point<D>,
    /// g at the guess, as a part of what it is made of.
    off: [f64; M],
    /// The way from the start, and the slide from the guess, as parts of the largest coordinates.
    path: f64,
    slid: f64,
    /// ∂g/∂σ at the guess and at the last correction; none if none was made.
    slopes: Option<[[[f64; M]; M]; 2]>,
}

impl<K, H, const D: usize, const M: usize> Departure<'_, K, H, D, M>
where
    K: PhaseConstraintKernel<f64, D, M>,
    H: HamiltonianKernel<f64, D>,
{
    /// The landing that the motion leads to; notes in what is kept by how much the guess was off. The weights are those
    /// of what it was off by in the last two steps.
    pub(super) fn land(&self, kept: &mut OfBody<M>, weights: [f64; 2]) -> Result<Landing<D, M>, StepFailure> {
        let attempt = self.land_after(1.0, self.guess);
        let landing = match attempt {
            Ok(landing) if self.is_certain(&landing, kept, weights) => landing,
            attempt => self.look_again(attempt, kept, weights)?,
        };
        kept.aims.iter_mut().zip(landing.off).for_each(|(aim, off)| aim.note(off));
        Ok(landing)
    }

    /// After the share s of the step and a slide by σ.
    fn after(&self, s: f64, sigma: &[f64; M], slides: &mut Slides<D, M>) -> Result<There<D, M>, StepFailure> {
        let (h, start) = (s * self.h, &self.start);
        let slid = slides.slide(self.functions.constraint, start, sigma).ok_or_else(|| too_far(h))?;
        let kicked = start.plus(&self.low.plus(&slid));
        let step = Verlet::of(self.functions.energy, h, &kicked);
        let step = step.ok_or_else(|| PhaseFailure::ImplicitStep { h, position: start.q.to_vec() })?;
        let change = slid.plus(&step.change);
        let at = start.plus(&self.low.plus(&change));
        let level = Level::of(self.functions.constraint, &at, &start.reach(&change));
        // H may have no value in coordinates that g does not depend on.
        let Point { q, p } = &step.change;
        if !level.value.iter().chain(q).chain(p).all(|x| x.is_finite()) {
            return Err(not_finite(start, &step.change));
        }
        Ok(There { change, kicked, step, level })
    }

    /// What is taken for rounding of g after this change by a step, or the part of it, of h.
    fn noise(&self, h: f64, change: &Point<D>, level: &Level<D, M>) -> [f64; M] {
        let at = self.start.plus(&self.low.plus(change));
        let reach = self.functions.reach_of_step(&self.start.reach(change), &at, h);
        level.noise(self.functions.constraint, &at, &reach)
    }

    /// Where g = 0 after the share s of the step, by Newton's iteration from this guess.
    fn land_after(&self, s: f64, guess: [f64; M]) -> Result<Landing<D, M>, StepFailure> {
        let h = s * self.h;
        let (mut off, mut slopes, mut slides) = (None, None, Slides::new());
        let (sigma, seen) = solve_along(
            h,
            guess,
            |sigma| {
                let there = self.after(s, sigma, &mut slides)?;
                off.get_or_insert_with(|| there.level.shares());
                let Level { value, size, extent, .. } = there.level;
                Ok(Look { change: there.change, value, size, extent, rest: there })
            },
            |Look { rest: There { kicked, step, level, .. }, .. }| {
                let mut there = [[0.0; M]; M];
                let before = Level::of(self.functions.constraint, kicked, kicked);
                for j in 0..M {
                    let v = step.tangent(self.functions.energy, h, &before.fibre(j))?;
                    for i in 0..M {
                        there[i][j] = level.gradients[i].along(&v);
                    }
                }
                slopes = Some([slopes.map_or(there, |[first, _]: [_; 2]| first), there]);
                Some(there)
            },
            |Look { change, rest, .. }| self.noise(h, change, &rest.level),
        )?;
        let Look { change, rest: There { level, .. }, .. } = seen;
        let slid = (0..M).fold(Point::ZERO, |sum, j| sum.plus(&level.fibre(j).times(sigma[j] - guess[j])));
        let reach = self.start.reach(&change);
        let [path, slid] = [change, slid].map(|way| way.over(&reach));
        Ok(Landing { sigma, change, off: off.unwrap_or([f64::NAN; M]), path, slid, slopes })
    }

    /// Whether nothing speaks against a landing after the share s of the step, at the end of a part of this length;
    /// `before` are the slopes, by the share and h, where the part began.
    fn is_trusted(
        &self,
        landing: &Landing<D, M>,
        before: &[[f64; M]; M],
        Part { end: s, length, .. }: &Part<f64>,
        far: f64,
    ) -> bool {
        let Some([first, last]) = landing.slopes else { return true };
        let path = length / s * landing.path;
        let near_guess = landing.off.iter().all(|off| off.abs() <= far * path);
        let change = turn(&first, &last);
        let is_short = change <= STEADY && change * path <= SHORT_PATH * landing.slid;
        turn(&before.map(|row| row.map(|x| x * (s * self.h))), &last) <= TILT
            && (change <= straight::<f64>() || (near_guess && is_short))
    }

    fn is_certain(&self, landing: &Landing<D, M>, kept: &OfBody<M>, weights: [f64; 2]) -> bool {
        let usual = |j: usize| {
            let off = landing.off[j];
            off.abs() <= ROUNDINGS * f64::EPSILON || kept.aims[j].is_usual(off, weights)
        };
        self.is_trusted(landing, &kept.slopes, &WHOLE, FAR_GUESS) && (0..M).all(usual)
    }

    /// The landing that is right, where guesses were not off as usual.
    #[cold]
    #[inline(never)]
    fn look_again(
        &self,
        attempt: Result<Landing<D, M>, StepFailure>,
        kept: &OfBody<M>,
        weights: [f64; 2],
    ) -> Result<Landing<D, M>, StepFailure> {
        if let Ok(landing) = &attempt {
            let suspect = from_fn(|j| !kept.aims[j].is_usual(landing.off[j], weights));
            let guess = |s: f64| self.guess.map(|sigma| s * sigma);
            let looks_right = |s: f64| self.grows(s, &guess(s), &suspect, &landing.off, s, GROWTH, &[0.0; M]);
            if self.is_trusted(landing, &kept.slopes, &WHOLE, FAR_GUESS)
                && INSIDE.into_iter().all(looks_right)
            {
                return Ok(*landing);
            }
        }
        match (self.follow(attempt.as_ref().ok(), &kept.slopes), attempt) {
            (Ok(followed), Ok(landing)) if self.are_the_same(&followed, &landing) => Ok(landing),
            (Ok(followed), _) => Ok(Landing { off: [f64::NAN; M], ..followed }),
            (Err(share), Ok(_)) => Err(PhaseFailure::SheetLost { share, h: self.h }.into()),
            (Err(_), Err(cause)) => Err(cause),
        }
    }

    /// Whether two landings are one, but for rounding.
    fn are_the_same(&self, one: &Landing<D, M>, other: &Landing<D, M>) -> bool {
        let reach = self.start.reach(&other.change);
        one.change.minus(&other.change).over(&reach) <= NOISE * f64::EPSILON
    }

    /// Whether g of the suspects, after the share s of the step and this slide, lets expect what it was off by at the
    /// end of a way of which that is the share `share`.
    #[allow(clippy::too_many_arguments, reason = "where, and what is expected there")]
    fn grows(
        &self,
        s: f64,
        sigma: &[f64; M],
        suspect: &[bool; M],
        off: &[f64; M],
        share: f64,
        powers: [u32; 2],
        noise: &[f64; M],
    ) -> bool {
        let Ok(there) = self.after(s, sigma, &mut Slides::new()) else { return false };
        let (inside, extent) = (there.level.shares(), there.level.extent);
        let grows = |own: [f64; M]| {
            let rounding = |j: usize| NOISE * f64::EPSILON + noise[j] + own[j] / extent[j];
            (0..M).all(|j| !suspect[j] || grows_to(inside[j], off[j], share, powers, rounding(j)))
        };
        grows([0.0; M]) || grows(self.noise(s * self.h, &there.change, &there.level))
    }

    /// The landing that is reached from h = 0 without leaving the root; or the share of the step that is.
    fn follow(&self, attempt: Option<&Landing<D, M>>, slopes: &[[f64; M]; M]) -> Result<Landing<D, M>, f64> {
        let mut course = [Course::start(); M];
        let (mut arrived, mut share, mut before) = (None, 0.0, *slopes);
        let noise = attempt.map_or([0.0; M], |landing| landing.off.map(|off| LITTLE_OFF * off.abs()));
        let reached = follow(|part: &Part<f64>| {
            let sigma = |course: &[Course<f64>; M], part: &Part<f64>| {
                from_fn(|j| course[j].ahead(self.guess[j], part) / part.end)
            };
            let Ok(landing) = self.land_after(part.end, sigma(&course, part)) else { return false };
            let mut trusted = self.is_trusted(&landing, &before, part, FAR_EXTRAPOLATION);
            for (share, powers) in INSIDE_PARTS {
                let inner = part.until(share);
                let sigma = sigma(&course, &inner);
                trusted =
                    trusted && self.grows(inner.end, &sigma, &[true; M], &landing.off, share, powers, &noise);
            }
            if trusted {
                for j in 0..M {
                    course[j].note(self.guess[j], part, part.end * landing.sigma[j]);
                }
                if let Some([_, last]) = landing.slopes {
                    before = last.map(|row| row.map(|x| x / (part.end * self.h)));
                }
                (arrived, share) = (Some(landing), part.end);
            }
            trusted
        });
        arrived.filter(|_| reached).ok_or(share)
    }
}

/// All of a step.
const WHOLE: Part<f64> = Part { end: 1.0, length: 1.0 };
