//! The end of a drift: the root of the [position equation](crate::systems::surface::position) that continues the
//! motion.
//!
//! A root that is not trusted is followed from h = 0, see [`crate::solve::root`]: always for h·κ·|v| > ½. Beyond 1
//! there may be no root.

use crate::kernel::rounding::NOISY;
use crate::motion::course::STEADY;
use crate::motion::failure::Failure;
use crate::motion::iteration::{Iteration, Kind, Newton};
use crate::number::real::Scalar;
use crate::number::vector::{add_scaled, dot, largest, scaled};
use crate::solve::aim::{Aim, GROWTH, INSIDE, INSIDE_PARTS, LITTLE, ROUNDINGS, grows_to};
use crate::solve::root::{
    Course, FAR_EXTRAPOLATION, FAR_GUESS, SHORT_PATH, alike, follow, is_the_root, is_upright,
};
use crate::systems::surface::diagnosis::FailureAt;
use crate::systems::surface::equation::{Equation, rounding_of};
use crate::systems::surface::position::{Departure, Landing};

/// A surface is taken to be no larger than so many paths of a step where its rounding is asked for.
const LARGE: f64 = 1e6;

/// A way of which less than this part leads along the surface is that of a body at rest, back onto it.
const ACROSS: f64 = 1e-3;

/// Slopes that differ by more than this factor are asked to be followed in shorter parts.
const STEADY_SLOPE: f64 = 2.0;

/// A landing that may be the right one.
#[derive(Clone, Copy)]
pub(crate) struct Attempt<T: Scalar, const D: usize> {
    pub(crate) landing: Landing<T, D>,
    /// The first guess of Λ, and pᵀ∇²g p.
    pub(crate) guess: T,
    pub(crate) bend: T,
    /// Whether nothing in the two ends of the step speaks against it.
    pub(crate) trusted: bool,
    /// Whether it is the right one.
    pub(crate) certain: bool,
}

impl<T: Scalar, const D: usize> Departure<'_, T, D> {
    /// The square of the way of a step, as far as it is not the constraint's.
    #[inline(always)]
    fn path_square(&self) -> T {
        let step = T::from_f64(self.h);
        step * step * dot(self.p, self.p) + self.push_square
    }

    /// Whether h·κ·|v| ≤ 1 / `times`.
    #[inline(always)]
    fn turns_little(&self, times: f64) -> bool {
        let step = T::from_f64(times * self.h);
        (step * step * self.bend * self.bend * self.normal.inverse_square).le(dot(self.p, self.p))
    }

    /// Where the body lands by this iteration; and whether that is good enough to tell that the root is the right
    /// one.
    #[inline(always)]
    pub(crate) fn attempt<X: Iteration>(
        &self,
        equation: &(impl Equation<T, D> + ?Sized),
        aim: &Aim<T>,
        weights: [f64; 2],
    ) -> Attempt<T, D> {
        let landing = match X::KIND {
            Kind::Newton => self.solve(equation, |_| ()),
            _ => self.chords::<X>(equation),
        };
        let trusted = match X::KIND {
            Kind::Newton | Kind::Symmetric => self.trusts(&landing, self.path_square(), FAR_GUESS),
            Kind::Simplified | Kind::Broyden => {
                self.trusts_without_slope(&landing, self.path_square(), FAR_GUESS)
            }
        };
        let trusted = self.turns_little(2.0) & trusted;
        let off = landing.multiplier - self.guess;
        let usual = match X::KIND {
            Kind::Newton | Kind::Symmetric => aim.is_usual(off, weights),
            Kind::Simplified | Kind::Broyden => {
                let angle_square = self.turned_square(&landing) * self.normal.inverse_square;
                aim.is_usual_after_turn(off, weights, angle_square)
            }
        };
        let rounding = landing.first_correction.le(T::from_f64(ROUNDINGS) * landing.floor);
        let certain = trusted & (usual | rounding);
        Attempt { landing, guess: self.guess, bend: self.bend, trusted, certain }
    }

    /// Where the body lands after an attempt from the same guess, by Newton's method, that may have found another
    /// root; and whether the root had to be followed.
    #[inline(never)]
    pub(crate) fn look_again(
        &self,
        equation: &dyn Equation<T, D>,
        attempt: &Attempt<T, D>,
    ) -> Result<(Landing<T, D>, bool), Failure> {
        let Attempt { landing, trusted, certain, .. } = *attempt;
        if certain {
            return Ok((landing, false));
        }
        if !self.turns_little(1.0) {
            return Err(FailureAt::of(self.body).too_long(self));
        }
        let steady = trusted && is_steady(landing.slopes[1], self.square());
        let look =
            |rounding| steady && self.confirms(equation, landing.multiplier, landing.slopes[0], rounding);
        let mut rounding = self.rounding();
        if look(rounding) {
            return self.steadily(equation, landing, false);
        }
        rounding = self.with_noise(rounding, equation, landing.multiplier);
        if look(rounding) {
            return self.steadily(equation, landing, false);
        }
        match self.follow(equation, rounding) {
            Some(found) if trusted && is_same(&found, landing.multiplier, rounding) => {
                self.steadily(equation, landing, false)
            }
            Some(found) => self.steadily(equation, found, true),
            None => Err(FailureAt::of(self.body).lost(equation, self)),
        }
    }

    /// This landing, unless it makes the speed jump: the way has more, or less, of its length along the surface at its
    /// end than where it began, which without a force is the ratio of speeds. A kink on the way is told after the step.
    fn steadily(
        &self,
        equation: &dyn Equation<T, D>,
        landing: Landing<T, D>,
        followed: bool,
    ) -> Result<(Landing<T, D>, bool), Failure> {
        let (way, from, to) = (&landing.increment, &self.normal.gradient, &landing.gradient);
        let along = |n: &[T; D]| {
            let across = dot(way, n);
            dot(way, way) - across * across / dot(n, n)
        };
        let (before, after, most) = (along(from), along(to), T::from_f64(STEADY));
        let rounding = T::from_f64(ACROSS * ACROSS) * dot(way, way);
        let jumps = (most * after + rounding).lt(before) | (most * before + rounding).lt(after);
        if jumps && !equation.kinks(self.q, &self.point(landing.multiplier)) {
            return Err(FailureAt::of(self.body).jumped(self.h, after / before, alike(from, to)));
        }
        Ok((landing, followed))
    }

    /// Where the body lands, with nothing known of the steps before.
    #[cold]
    #[inline(never)]
    pub(crate) fn land(&self, equation: &dyn Equation<T, D>) -> Result<Landing<T, D>, Failure> {
        let attempt = self.attempt::<Newton>(equation, &Aim::unknown(), [f64::NAN; 2]);
        self.look_again(equation, &attempt).map(|(landing, _)| landing)
    }

    /// Where the body lands after an attempt from another guess or by another iteration, with the slope at the guess
    /// or not, that may have found another root; and whether it had.
    #[inline(never)]
    pub(crate) fn land_instead(
        &self,
        equation: &dyn Equation<T, D>,
        attempt: &Attempt<T, D>,
        with_slope: bool,
    ) -> Result<(Landing<T, D>, bool), Failure> {
        let Attempt { landing, trusted, certain, .. } = *attempt;
        if certain {
            return Ok((landing, false));
        }
        // Without the slope at the guess too little is known of g there: another sheet would be trusted as often as
        // not.
        if with_slope {
            let [slope, _] = landing.slopes;
            if trusted
                && is_steady(landing.slopes[1], self.square())
                && self.confirms(equation, landing.multiplier, slope, self.rounding())
            {
                return Ok((landing, false));
            }
        }
        let found = self.land(equation)?;
        let rounding = self.with_noise(self.rounding(), equation, landing.multiplier);
        let is_found = trusted && is_same(&found, landing.multiplier, rounding);
        Ok(if is_found { (landing, false) } else { (found, true) })
    }

    /// The square of ∇g(q′) − ∇g(q).
    #[inline(always)]
    fn turned_square(&self, landing: &Landing<T, D>) -> T {
        let turned = add_scaled(&landing.gradient, T::from_f64(-1.0), &self.normal.gradient);
        dot(&turned, &turned)
    }

    /// The slope of g along its normal where the step begins.
    #[inline(always)]
    fn square(&self) -> T {
        dot(&self.normal.gradient, &self.normal.gradient)
    }

    /// The rounding of Λ by that of positions, or of a surface of the size of its radius of curvature.
    fn rounding(&self) -> T {
        let (square, speed_square) = (dot(&self.normal.gradient, &self.normal.gradient), dot(self.p, self.p));
        let (length, path) = (square.sqrt(), dot(&self.free, &self.free).sqrt());
        let radius = length * speed_square / self.bend.abs(); // of the path; none where it is straight
        let most = T::from_f64(LARGE) * path;
        let radius = T::select(radius.le(most), radius, most);
        let size = largest(self.q).max(largest(&self.free)).max(radius);
        T::from_f64(ROUNDINGS * T::EPSILON) * size / length
    }

    /// This rounding and some times that of g itself, if it matters: if the guess for this Λ was off by little. The
    /// rounding of g is by
    /// how much it is no straight line across the surface at the start.
    fn with_noise(&self, rounding: T, equation: &dyn Equation<T, D>, multiplier: T) -> T {
        if (T::from_f64(LITTLE) * rounding).le((multiplier - self.guess).abs()) {
            return rounding;
        }
        let size = largest(self.q).max(largest(&self.free));
        rounding + T::from_f64(NOISY) * rounding_of(equation, self.q, &self.normal.gradient, size)
    }

    /// What the guess is off by after the share `s` of the step, if Λ is guessed to be this there.
    fn off_inside(&self, equation: &dyn Equation<T, D>, s: T, guess: T, slope: T) -> T {
        let free = add_scaled(&scaled(s, &self.path), s * s, &self.push);
        let inside = Self { free, ..*self };
        -equation.value(&inside.point(guess)) / slope
    }

    /// Whether guesses inside the step, of this Λ at its end and s² times the first guess on the way, are off by
    /// what they should be.
    fn confirms(&self, equation: &dyn Equation<T, D>, multiplier: T, slope: T, rounding: T) -> bool {
        let end = multiplier - self.guess;
        let look = |s: f64| {
            let share = T::from_f64(s);
            let inside = self.off_inside(equation, share, share * share * self.guess, slope);
            grows_to(inside, end, s, GROWTH, rounding)
        };
        let [first, second] = INSIDE;
        look(first) && look(second)
    }

    /// The landing that is reached from h = 0 without leaving the root, of the position equation with `path` s and
    /// `push` s² for s = 0 … 1.
    fn follow(&self, equation: &dyn Equation<T, D>, rounding: T) -> Option<Landing<T, D>> {
        let (path, push) = (&self.path, &self.push);
        let path_and_push = dot(path, path) + dot(push, push);
        let mut course = Course::start();
        let (mut arrived, mut slope_before) = (None, self.square());
        let reached = follow(|part| {
            let (s, length) = (part.end, part.length);
            let free = add_scaled(&scaled(s, path), s * s, push);
            let on_the_way = Self { free, guess: course.ahead(self.guess, part), ..*self };
            let landing = on_the_way.solve(equation, |_| ());
            let path_square = length * length * path_and_push;
            let mut trusted = on_the_way.trusts(&landing, path_square, FAR_EXTRAPOLATION);
            let (end, [slope, last]) = (landing.multiplier - on_the_way.guess, landing.slopes);
            trusted &= is_steady(last, slope_before);
            for (share, powers) in INSIDE_PARTS {
                let inner = part.until(share);
                let guess = course.ahead(self.guess, &inner);
                let inside = self.off_inside(equation, inner.end, guess, slope);
                trusted &= grows_to(inside, end, share, powers, rounding);
            }
            if trusted {
                course.note(self.guess, part, landing.multiplier);
                slope_before = last;
                arrived = Some(landing);
            }
            trusted
        });
        arrived.filter(|_| reached)
    }

    /// Whether the root found is taken for the one that the motion continues on, after a path of this length, if a
    /// guess that was off by `far` of it is too far.
    #[inline(always)]
    fn trusts(&self, landing: &Landing<T, D>, path_square: T, far: f64) -> bool {
        let [first, slope] = landing.slopes;
        let off_square = landing.first_correction * landing.first_correction;
        let slopes = [self.square(), first, slope];
        landing.converged & is_the_root(off_square, slopes, path_square, far)
    }

    /// The same for a landing by [`chords`](Self::chords) with the slope of the start, where that at the guess is
    /// not known.
    #[inline(always)]
    fn trusts_without_slope(&self, landing: &Landing<T, D>, path_square: T, far: f64) -> bool {
        let square = self.square();
        let off_square = landing.first_correction * landing.first_correction;
        let near_guess = off_square.le(T::from_f64(far * far) * path_square);
        let short_path = self.turned_square(landing).le(T::from_f64(SHORT_PATH * SHORT_PATH) * square);
        let upright = is_upright(landing.slopes[1], square);
        landing.converged & upright & near_guess & short_path
    }
}

/// Whether a slope differs by less than a factor from that where a way began: on its way to the next root it turns
/// over.
fn is_steady<T: Scalar>(slope: T, before: T) -> bool {
    let most = T::from_f64(STEADY_SLOPE);
    slope.le(most * before) & before.le(most * slope)
}

/// Whether another solve found the same root, but for rounding.
fn is_same<T: Scalar, const D: usize>(landing: &Landing<T, D>, multiplier: T, rounding: T) -> bool {
    (landing.multiplier - multiplier).abs().le(rounding)
}
