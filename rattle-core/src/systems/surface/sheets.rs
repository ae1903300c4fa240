//! Whether a step that did not follow its root has ended on the sheet on which it began.
//!
//! Power series, explicit methods and collocation end on *some* sheet. Two signs show that it may be a wrong one: g
//! rises and falls along the normal, as it does where other sheets are near ([`crate::solve::crowd`]); or g *inside*
//! the step, on a curve through its two ends, is not as small as it is along one sheet. In either case, and where a
//! step leads so far from what its momenta say that neither sign would tell, the end is tested by a walk: with short
//! steps of RATTLE along the curve, each of them examined inside. If the end lies on another sheet, the walk arrives at
//! a point beside it.
//!
//! The curve is Hermite's cubic, and where g is not small on it, the quartic that also matches the acceleration at the
//! end. On the lemniscate at h = 0.02 and 0.05 a fifth and a half of all steps need the quartic, and 0.03 % and 2 % a
//! walk. Neither sign is sufficient: of a million random scenes the first one alone misses a sheet in 100 of those that
//! Lobatto methods and power series move, and the second one, where sheets lie close, in one of 200.

use crate::effect::list::Forces;
use crate::error::StepFailure;
use crate::kernel::functions::ConstraintKernel;
use crate::kernel::rounding::size_along;
use crate::motion::bodies::{Body, Count, Saved};
use crate::motion::failure::{Failure, numbers};
use crate::number::real::Scalar;
use crate::number::vector::{add_scaled, dot, largest, scaled, sum};
use crate::solve::aim::{BOLD, INSIDE, OFF_INSIDE, ROUNDINGS};
use crate::solve::crowd::{FARTHER, is_alone, shift, there};
use crate::solve::curve::{cubic, quartic};
use crate::systems::surface::equation::{Equation, is_rounding};
use crate::systems::surface::kept::{BodiesOf, OnSurface};
use crate::systems::surface::normal::Normal;
use crate::systems::surface::position::Departure;
use std::array::from_fn;

/// Ways that are walked at most.
const MOST_WAYS: usize = 256;

/// The smallest part of what is left to walk that is tried at once.
const SMALLEST_SHARE: f64 = 1.0 / 1024.0;

/// Parts of the step that a walk goes by way of.
const BENDS: u32 = 8;

/// A way of which less than this part leads along the sheet leads across.
const ACROSS: f64 = 1e-3;

impl<K, F, N: Count, L> OnSurface<K, F, N, L> {
    /// Now and then, and after a step that may have led farther astray than was asked for, looks around each body; and
    /// while one is near other sheets, whether all are still on their own.
    #[inline(always)]
    pub(super) fn check_each<T, const D: usize>(
        &self,
        h: f64,
        before: &Saved<N, T, D>,
        now: &mut BodiesOf<N, T, F, D>,
    ) -> Result<(), Failure>
    where
        T: Scalar,
        K: ConstraintKernel<T, D, 1>,
        F: Forces<T, D>,
    {
        let bodies = 0..self.count.number();
        let astray = bodies.map(|body| astray(h, &before.body(body), &now.body(body))).fold(0.0, f64::max);
        if let Some(turn) = now.kept.crowd.asked.turn(astray, FARTHER) {
            self.ask(turn, before, now);
        }
        let near = now.kept.crowd.asked.near;
        for body in 0..self.count.number() {
            let (from, to) = (before.body(body), now.body(body));
            if near || is_bold(h, &from, &to) || self.is_off_inside(h, body, &from, &to, now) {
                check_walk(&self.constraint, body, h, &from, &to)?;
            }
        }
        Ok(())
    }

    /// Whether g on a curve through both ends of a step is not as small as it is along one sheet. First on a curve that
    /// knows places and momenta, then on one that knows the acceleration at the end too.
    #[inline(always)]
    fn is_off_inside<T, const D: usize>(
        &self,
        h: f64,
        body: usize,
        from: &Body<T, D>,
        to: &Body<T, D>,
        now: &BodiesOf<N, T, F, D>,
    ) -> bool
    where
        T: Scalar,
        K: ConstraintKernel<T, D, 1>,
        F: Forces<T, D>,
    {
        let n = &now.kept.normal.as_ref()[body].gradient;
        let most = astray(h, from, to) * OFF_INSIDE;
        let length = dot(n, n).sqrt();
        let size = size_along(n, length, &from.q).max(size_along(n, length, &to.q));
        let rounding = T::from_f64(ROUNDINGS * T::EPSILON) * size;
        let most = (T::from_f64(most) + rounding) * length;
        let half = T::from_f64(0.5);
        let is_off = |lift: &[T; D]| {
            !INSIDE.iter().all(|&s| {
                let [g] = self.constraint.value(&quartic(h, s, [&from.q, &to.q], [&from.p, &to.p], lift));
                g.abs().le(most)
            })
        };
        is_off(&[T::from_f64(0.0); D]) && {
            let (_, acceleration) = now.pull(&self.constraint, body);
            let [square, rates] = [h * h, 2.0 * h].map(T::from_f64);
            is_off(&from_fn(|i| {
                let of_cubic =
                    T::from_f64(6.0) * (from.q[i] - to.q[i]) + rates * (from.p[i] + to.p[i] + to.p[i]);
                half * (square * acceleration[i] - of_cubic)
            }))
        }
    }

    /// Notes whether other sheets are as near to a body where the step began as it is to be asked.
    #[cold]
    #[inline(never)]
    fn ask<T, const D: usize>(&self, turn: u64, before: &Saved<N, T, D>, now: &mut BodiesOf<N, T, F, D>)
    where
        T: Scalar,
        K: ConstraintKernel<T, D, 1>,
        F: Forces<T, D>,
    {
        let reach = T::from_f64(now.kept.crowd.asked.reach);
        let is_near = |(q, p): (&[T; D], &[T; D])| {
            let ([_], [n]) = self.constraint.value_and_jacobian(q);
            let [bend] = self.constraint.jet(q, p).2;
            let square = dot(&n, &n);
            !is_alone(&self.constraint, turn, [q, &n], square, shift(reach, square, dot(p, p), bend))
        };
        now.kept.crowd.asked.near = before.q.as_ref().iter().zip(before.p.as_ref()).any(is_near);
    }
}

/// How far a step of length h may have led astray: by how much more than its momenta say, and the path that these do
/// say. Of a right step the first is some part of h³; a sheet that was passed over makes it as large as the sheets are
/// apart.
#[inline(always)]
fn off_path<T: Scalar, const D: usize>(h: f64, before: &Body<T, D>, now: &Body<T, D>) -> [[T; D]; 2] {
    let path = scaled(T::from_f64(0.5 * h), &sum(&before.p, &now.p));
    let way = add_scaled(&now.q, T::from_f64(-1.0), &before.q);
    [add_scaled(&way, T::from_f64(-1.0), &path), path]
}

/// The largest coordinate of that.
#[inline(always)]
fn astray<T: Scalar, const D: usize>(h: f64, before: &Body<T, D>, now: &Body<T, D>) -> f64 {
    let [off, _] = off_path(h, before, now);
    off.iter().map(|x| x.to_f64().abs()).fold(0.0, |most, x| if x <= most { most } else { x })
}

/// Whether a step led astray by more than [`BOLD`] of its path: farther than any sign reaches.
#[inline(always)]
fn is_bold<T: Scalar, const D: usize>(h: f64, from: &Body<T, D>, to: &Body<T, D>) -> bool {
    let [off, path] = off_path(h, from, to);
    !dot(&off, &off).le(T::from_f64(BOLD * BOLD) * dot(&path, &path))
}

/// Walks from one place towards another, by way of what places and momenta at both say. An error where that is not
/// reached.
#[cold]
#[inline(never)]
pub(super) fn check_walk<T: Scalar, const D: usize>(
    equation: &dyn Equation<T, D>,
    body: usize,
    h: f64,
    from: &Body<T, D>,
    to: &Body<T, D>,
) -> Result<(), Failure> {
    let place = |s: f64| cubic(h, s, [&from.q, &to.q], [&from.p, &to.p]);
    // Places on the way count, too: a step may end at the origin.
    let way = |p: &[T; D], i: usize| T::from_f64(h.abs()) * p[i].abs();
    let sizes: [T; D] =
        from_fn(|i| way(&from.p, i).max(way(&to.p, i)).max(from.q[i].abs()).max(to.q[i].abs()));
    let (mut q, to) = (from.q, &to.q);
    for part in 1..BENDS {
        let towards = place(f64::from(part) / f64::from(BENDS));
        let _near_enough = walk(equation, body, &mut q, &towards);
    }
    let off = walk(equation, body, &mut q, to);
    // Another sheet lies along the normal, in which a coordinate may have no part, however large it is.
    let (there, ends) = (T::from_f64(there::<T>()), [equation.gradient(&from.q), equation.gradient(to)]);
    let along_normal = ends.map(|n| size_along(&n, dot(&n, &n).sqrt(), &sizes));
    let (n, size) = (&ends[1], along_normal[0].max(along_normal[1]));
    // Where all coordinates are small, terms of g may be larger.
    let known =
        from_fn(|i| if ends.iter().all(|n| n[i].to_f64() == 0.0) { T::from_f64(0.0) } else { sizes[i] });
    let way = add_scaled(to, T::from_f64(-1.0), &q);
    let normals = dot(n, &way) / dot(n, n);
    let along = add_scaled(&way, -normals, n);
    let is_there = (normals.abs() * dot(n, n).sqrt()).le(there * size)
        || is_rounding(equation, to, n, largest::<_, D>(&known), normals);
    if is_there && largest(&along).le(there * largest(&sizes)) {
        return Ok(());
    }
    Err(Failure { body, cause: StepFailure::OtherSheet { h, off: off.to_f64(), position: numbers(to) } })
}

/// Walks as near to a place as a surface leads. Returns how far off that is.
fn walk<T: Scalar, const D: usize>(
    equation: &dyn Equation<T, D>,
    body: usize,
    q: &mut [T; D],
    to: &[T; D],
) -> T {
    let (mut share, mut off, zero) = (1.0_f64, T::from_f64(0.0), T::from_f64(0.0));
    for _ in 0..MOST_WAYS {
        let way = add_scaled(to, T::from_f64(-1.0), q);
        off = dot(&way, &way).sqrt();
        let normal = Normal::new(equation.gradient(q));
        let (_, back) = normal.projection(&way);
        let along = sum(&way, &back);
        if !(T::from_f64(ACROSS * ACROSS) * off * off).lt(dot(&along, &along)) {
            break;
        }
        let path = scaled(T::from_f64(share), &along);
        let exact = [zero; D];
        let departure = Departure::coasting(equation, 1.0, body, [q, &exact, &path], &normal);
        match departure.land(equation) {
            Ok(landing) => {
                *q = sum(q, &landing.increment);
                share = (2.0 * share).min(1.0);
            }
            Err(_) => {
                share *= 0.5;
                if share < SMALLEST_SHARE {
                    break;
                }
            }
        }
    }
    off
}
