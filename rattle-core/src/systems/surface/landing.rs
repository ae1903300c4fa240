//! Where a body lands: on the root of the [position equation](crate::systems::surface::position) that its motion leads to.
//!
//! A root that is not trusted is followed, see [`crate::solve::root`]; where h·κ·|v| > ½ it always is, beyond 1 there may be none.

use crate::motion::failure::Failure;
use crate::motion::iteration::{Iteration, Kind};
use crate::number::real::{Mask, Real};
use crate::number::vector::{add_scaled, dot, scaled};
use crate::solve::root::{Course, FAR_EXTRAPOLATION, FAR_GUESS, SHORT_PATH, follow, is_the_root};
use crate::systems::surface::diagnosis::FailureAt;
use crate::systems::surface::equation::Equation;
use crate::systems::surface::position::{Departure, Landing};

impl<T: Real, const D: usize> Departure<'_, T, D> {
    /// The square of the way of a step, as far as it is not the constraint's.
    #[inline(always)]
    fn path_square(&self) -> T {
        let step = T::from_f64(self.h);
        step * step * dot(self.p, self.p) + self.push_square
    }

    /// Whether h·κ·|v| ≤ 1 / `times`.
    #[inline(always)]
    fn turns_little(&self, times: f64) -> T::Mask {
        let step = T::from_f64(times * self.h);
        (step * step * self.bend * self.bend * self.normal.inverse_square).le(dot(self.p, self.p))
    }

    /// Where the body lands: on the root that its motion leads to. By Newton's method from `guess`.
    #[inline(always)]
    pub(crate) fn land(&self, equation: &impl Equation<T, D>) -> Result<Landing<T, D>, Failure> {
        let within_reach = self.turns_little(1.0);
        if !within_reach.all() {
            let copy = *self; // what rare code reads by reference would else be kept in memory by all steps
            return Err(FailureAt::of(self.body, within_reach).too_long(&copy));
        }
        let mut landing = self.solve(equation, |_| ());
        let trusted = self.turns_little(2.0).and(self.trusts(&landing, self.path_square(), FAR_GUESS));
        if !trusted.all() {
            let copy = *self;
            landing = landing.or(trusted, copy.follow(equation));
            if !landing.converged.all() {
                return Err(FailureAt::of(self.body, landing.converged).lost(equation, &copy));
            }
        }
        Ok(landing)
    }

    /// Where the body lands by any iteration; and in which lanes that is good enough to tell that the root is the right one.
    #[inline(always)]
    pub(crate) fn try_to_land<X: Iteration>(
        &self,
        equation: &impl Equation<T, D>,
    ) -> (Landing<T, D>, T::Mask) {
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
        (landing, self.turns_little(2.0).and(trusted))
    }

    /// The same as [`land`](Self::land), where a step is as rare as that; after an attempt that can be trusted in some lanes.
    #[cold]
    #[inline(never)]
    pub(crate) fn land_rarely(
        &self,
        equation: &dyn Equation<T, D>,
        attempt: Option<(Landing<T, D>, T::Mask)>,
    ) -> Result<Landing<T, D>, Failure> {
        let zero = T::from_f64(0.0);
        let done = attempt.as_ref().map_or(zero.lt(zero), |&(_, done)| done);
        let within_reach = self.turns_little(1.0).or(done);
        if !within_reach.all() {
            return Err(FailureAt::of(self.body, within_reach).too_long(self));
        }
        let mut landing = self.solve(equation, |_| ());
        if let Some((attempt, done)) = attempt {
            landing = attempt.or(done, landing);
        }
        let trusted =
            self.turns_little(2.0).and(self.trusts(&landing, self.path_square(), FAR_GUESS)).or(done);
        if !trusted.all() {
            landing = landing.or(trusted, self.follow(equation));
            if !landing.converged.all() {
                return Err(FailureAt::of(self.body, landing.converged).lost(equation, self));
            }
        }
        Ok(landing)
    }

    /// The landing that is reached from h = 0 without leaving the root, of the position equation with `path` s and
    /// `push` s² for s = 0 … 1. Not converged where there is none.
    #[cold]
    #[inline(never)]
    fn follow(&self, equation: &dyn Equation<T, D>) -> Landing<T, D> {
        let (path, push) = (&self.path, &self.push);
        let path_and_push = dot(path, path) + dot(push, push);
        let mut course = Course::start();
        let mut arrived: Option<Landing<T, D>> = None;
        let reached = follow(|part| {
            let (s, length) = (part.end, part.length);
            let free = add_scaled(&scaled(s, path), s * s, push);
            let on_the_way = Self { free, guess: course.ahead(self.guess, part), ..*self };
            let landing = on_the_way.solve(equation, |_| ());
            let path_square = length * length * path_and_push;
            let trusted = part.going.and(on_the_way.trusts(&landing, path_square, FAR_EXTRAPOLATION));
            course.note(trusted, self.guess, part, landing.multiplier);
            arrived = Some(match arrived.take() {
                Some(before) => landing.or(trusted, before),
                None => landing,
            });
            trusted
        });
        let mut landing = arrived.unwrap_or_else(|| self.solve(equation, |_| ()));
        landing.converged = reached;
        landing
    }

    /// Whether the root found is taken for the one that the motion continues on, after a path of this length, if a
    /// guess that was off by `far` of it is too far.
    #[inline(always)]
    fn trusts(&self, landing: &Landing<T, D>, path_square: T, far: f64) -> T::Mask {
        let [first, slope] = landing.slopes;
        let off_square = landing.first_correction * landing.first_correction;
        landing.converged.and(is_the_root(off_square, first, slope, path_square, far))
    }

    /// The same for a landing by [`chords`](Self::chords) with the slope of the start, where that at the guess is not known.
    #[inline(always)]
    fn trusts_without_slope(&self, landing: &Landing<T, D>, path_square: T, far: f64) -> T::Mask {
        let n = &self.normal.gradient;
        let (square, turned) = (dot(n, n), add_scaled(&landing.gradient, T::from_f64(-1.0), n));
        let off_square = landing.first_correction * landing.first_correction;
        let near_guess = off_square.le(T::from_f64(far * far) * path_square);
        let short_path = dot(&turned, &turned).le(T::from_f64(SHORT_PATH * SHORT_PATH) * square);
        let upright = T::from_f64(0.0).lt(landing.slopes[1]);
        landing.converged.and(upright).and(near_guess).and(short_path)
    }
}
