//! Newton's iteration onto constraints: when it has converged, and when it has failed.
//!
//! It projects starts, and ends of steps of methods that ignore constraints inside a step. Each Newton step evaluates
//! the constraints at its end, which gives a distance. The iteration has converged where the distance is at the
//! rounding of the coordinates, or where a small distance is no longer halved: then it is the rounding of g itself. It
//! has failed where a distance that is not small shrinks by too little.

use crate::number::real::Scalar;

/// The distance that the last Newton step began at.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Nearing<T> {
    last: T,
    part: T,
}

impl<T: Scalar> Nearing<T> {
    /// An iteration whose steps must leave less than this part of the distance: infinite where they only are counted.
    #[inline(always)]
    pub(crate) fn leaving(part: f64) -> Self {
        Self { last: T::from_f64(f64::INFINITY), part: T::from_f64(part) }
    }

    /// Whether the iteration has arrived, and whether it is lost. `there` says that the distance is at the rounding of
    /// the coordinates, `near` that it may be the rounding of g.
    #[inline(always)]
    pub(crate) fn look(&mut self, distance: T, there: bool, near: bool) -> (bool, bool) {
        let arrived = there | (near & self.last.le(distance + distance));
        let nearer = near | distance.lt(self.part * self.last); // false for NaN
        self.last = distance;
        (arrived, !(arrived | nearer))
    }
}
