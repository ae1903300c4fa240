//! The system of rigid bodies, and the quantities kept from step to step.

use crate::effect::list::Forces;
use crate::motion::bodies::{Bodies, Count};
use crate::number::vector::{scaled, sum, two_sum};
use crate::systems::rigid::body::Rigid;
use crate::systems::rigid::room::SeriesRoom;
use crate::systems::rigid::rotation::{Moments, product};
use std::array::from_fn;
use std::fmt;

/// One body: attitude and angular momentum as compensated sums, and the torque on it.
pub(super) struct Place<'a> {
    pub(super) q: &'a mut [f64; 9],
    q_low: &'a mut [f64; 9],
    p: &'a mut [f64; 9],
    p_low: &'a mut [f64; 9],
    pub(super) torque: [f64; 3],
}

impl<'a> Place<'a> {
    #[inline(always)]
    pub(super) fn of<N: Count, F: Forces<f64, 9>>(bodies: &'a mut BodiesOf<F, N>, number: usize) -> Self {
        let torque = bodies.kept.torque[number];
        let (q, q_low) = (&mut bodies.q.as_mut()[number], &mut bodies.q_low.as_mut()[number]);
        let (p, p_low) = (&mut bodies.p.as_mut()[number], &mut bodies.p_low.as_mut()[number]);
        Self { q, q_low, p, p_low, torque }
    }

    /// The angular momentum, rounded.
    #[inline(always)]
    pub(super) fn m(&self) -> [f64; 3] {
        from_fn(|i| self.p[i])
    }

    #[inline(always)]
    pub(super) fn turn_by(&mut self, turn: &[f64; 9]) {
        (*self.q, *self.q_low) = two_sum(self.q, &sum(self.q_low, turn));
    }

    /// Adds a change of the momentum, and what rounding took from it.
    #[inline(always)]
    pub(super) fn push_by(&mut self, change: &[f64; 3], rest: &[f64; 3]) {
        let (high, low) = two_sum(&self.m(), change);
        let low = from_fn(|i| low[i] + (self.p_low[i] + rest[i]));
        let (high, low) = two_sum(&high, &low);
        self.p[..3].copy_from_slice(&high);
        self.p_low[..3].copy_from_slice(&low);
    }

    /// Q(3 − QᵀQ)/2 (Å. Björck, C. Bowie 1971), from 1 − QᵀQ.
    #[cold]
    pub(super) fn straighten(&mut self, deviation: &[f64; 9]) {
        self.turn_by(&scaled(0.5, &product(self.q, deviation)));
    }
}

/// The system of rigid bodies with forces.
#[derive(Debug, Clone)]
pub struct Turning<F, N> {
    pub(super) body: Rigid,
    pub(super) moments: Moments<f64>,
    pub(super) effects: F,
    pub(super) count: N,
}

/// The quantities kept from step to step.
#[derive(Clone)]
pub struct Kept<F: Forces<f64, 9>> {
    /// Forces last evaluated.
    pub(super) force: Vec<F::Force>,
    /// Their torques about the centres of mass, in the frames of the bodies.
    pub(super) torque: Vec<[f64; 3]>,
    /// Room of the effects.
    pub(super) of_effects: F::Room,
    /// Room for power series.
    pub(super) series: Option<Box<SeriesRoom>>,
}

pub(crate) type BodiesOf<F, N> = Bodies<N, f64, Kept<F>, 9>;

impl<F: Forces<f64, 9>> fmt::Debug for Kept<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Kept").field("force", &self.force).finish_non_exhaustive()
    }
}
