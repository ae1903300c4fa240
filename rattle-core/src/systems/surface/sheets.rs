//! Whether a step that did not follow its root has ended on the sheet that it began on.
//!
//! Power series, explicit methods and collocation come to a place on *a* sheet. Where others are near
//! ([`crate::solve::crowd`]) it is asked whether one can walk there: with short ways along the sheet, straight towards the
//! place, each of which lands as a step of RATTLE does and is looked at inside. On another sheet one arrives beside
//! it, and only a way across is left.

use crate::effect::force::Force;
use crate::effect::list::Forces;
use crate::error::StepFailure;
use crate::kernel::functions::ConstraintKernel;
use crate::motion::bodies::{Count, Saved};
use crate::motion::failure::Failure;
use crate::number::real::{Mask, Real};
use crate::number::vector::{add_scaled, dot, largest, scaled, sum};
use crate::solve::crowd::{EVERY as SHARES_EVERY, PATH, REACH, rises, shares};
use crate::systems::surface::crowd::EVERY;
use crate::systems::surface::equation::Equation;
use crate::systems::surface::kept::{BodiesOf, OnSurface};
use crate::systems::surface::normal::Normal;
use crate::systems::surface::position::Departure;

/// Ways that are walked at most.
const MOST_WAYS: usize = 256;

/// The smallest part of what is left to walk that is tried at once.
const SMALLEST_SHARE: f64 = 1.0 / 1024.0;

/// One is there within so many roundings of the size of places, or of the way: the rounding of g may be some thousand of
/// that of places.
const THERE: f64 = 65536.0;

/// A way of which less than this part leads along the sheet leads across.
const ACROSS: f64 = 1e-3;

/// No farther is looked than this part of the radius in which the path is bent, where any surface turns.
const OF_RADIUS: f64 = 0.1;

impl<K, F, N: Count, L> OnSurface<K, F, N, L> {
    /// Now and then looks around each body; and while one is near other sheets, whether all are still on their own.
    #[inline(always)]
    pub(super) fn check_each<T, const D: usize>(
        &self,
        steps: u64,
        h: f64,
        before: &Saved<N, T, D>,
        now: &mut BodiesOf<N, T, F, D>,
    ) -> Result<(), Failure>
    where
        T: Real,
        K: ConstraintKernel<T, D, 1>,
        F: Forces<T, D>,
    {
        if steps.is_multiple_of(EVERY) {
            let from = before.q.as_ref().iter().enumerate(); // the sheet that is the right one
            now.kept.crowd.near =
                from.fold(false, |near, (body, q)| near || self.is_near_others(steps, h, q, now, body));
        }
        if now.kept.crowd.near {
            for (body, (from, to)) in before.q.as_ref().iter().zip(now.q.as_ref()).enumerate() {
                check_walk(&self.constraint, body, h, from, to)?;
            }
        }
        Ok(())
    }

    /// Whether other sheets are near a place of a body, a step before now.
    fn is_near_others<T, const D: usize>(
        &self,
        steps: u64,
        h: f64,
        q: &[T; D],
        now: &BodiesOf<N, T, F, D>,
        body: usize,
    ) -> bool
    where
        T: Real,
        K: ConstraintKernel<T, D, 1>,
        F: Forces<T, D>,
    {
        let p = &now.p.as_ref()[body];
        let Normal { gradient, inverse_square } = Normal::new(Equation::gradient(&self.constraint, q));
        let force = now.kept.force.as_ref()[body].components();
        let [bend] = self.constraint.jet(q, p).2;
        let [pushed, path] = [0.5 * REACH * h * h, REACH * PATH * h].map(T::from_f64);
        let free = path * path * dot(p, p) + pushed * pushed * dot(&force, &force);
        let reach = pushed * bend.abs() * inverse_square + (free * inverse_square).sqrt();
        let most = T::from_f64(OF_RADIUS) * dot(p, p) / bend.abs(); // infinite where the path is straight
        let reach = T::select(most.le(reach), most, reach);
        let square = dot(&gradient, &gradient);
        let plain = |share: f64| {
            let rises = rises(&self.constraint, q, &gradient, square, T::from_f64(share) * reach);
            T::from_f64(0.0).le(rises).all()
        };
        !shares(steps / EVERY * SHARES_EVERY).all(plain)
    }
}

/// Walks from one place towards another. An error where that is not reached.
#[cold]
#[inline(never)]
fn check_walk<T: Real, const D: usize>(
    equation: &dyn Equation<T, D>,
    body: usize,
    h: f64,
    from: &[T; D],
    to: &[T; D],
) -> Result<(), Failure> {
    let (mut q, mut share, zero) = (*from, 1.0_f64, T::from_f64(0.0));
    let left = |q: &[T; D]| add_scaled(to, T::from_f64(-1.0), q);
    let size = largest(from).max(largest(to)).max(largest(&left(from)));
    let there = T::from_f64(THERE * T::EPSILON) * size;
    let (mut off, mut trouble) = (zero, None);
    for _ in 0..MOST_WAYS {
        let way = left(&q);
        off = dot(&way, &way).sqrt();
        if off.le(there).all() {
            return Ok(());
        }
        let normal = Normal::new(equation.gradient(&q));
        let (_, back) = normal.projection(&way);
        let along = sum(&way, &back);
        if !(T::from_f64(ACROSS * ACROSS) * off * off).le(dot(&along, &along)).all() {
            break;
        }
        let path = scaled(T::from_f64(share), &along);
        let bend = equation.bend(&q, &path);
        let departure = Departure {
            h: 1.0,
            body,
            q: &q,
            q_low: &[zero; D],
            p: &path,
            normal: &normal,
            bend,
            path,
            push: [zero; D],
            push_square: zero,
            free: path,
            guess: T::from_f64(-0.5) * bend * normal.inverse_square,
        };
        match departure.land(equation) {
            Ok(landing) => {
                q = sum(&q, &landing.increment);
                share = (2.0 * share).min(1.0);
            }
            Err(failure) => {
                share *= 0.5;
                if share < SMALLEST_SHARE {
                    trouble = Some(failure);
                    break;
                }
            }
        }
    }
    if let Some(failure) = trouble {
        return Err(failure);
    }
    let number = |x: T| x.lanes().next().unwrap_or(f64::NAN);
    Err(Failure {
        body,
        cause: StepFailure::OtherSheet { h, off: number(off), position: to.map(number).to_vec() },
    })
}
