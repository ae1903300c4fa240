//! Rigid bodies in a field of force, and what is kept from one step to the next.

use crate::effect::force::Force;
use crate::effect::list::Forces;
use crate::motion::bodies::{Bodies, Body, Count};
use crate::number::vector::{sum, two_sum};
use crate::systems::rigid::body::Rigid;
use crate::systems::rigid::body::spread;
use crate::systems::rigid::body::turning_part;
use crate::systems::rigid::room::SeriesRoom;
use nalgebra::{Matrix3, Vector3};
use std::fmt;

/// One body: attitude and angular momentum as compensated sums.
pub(super) struct Place {
    pub(super) attitude: Matrix3<f64>,
    pub(super) m: Vector3<f64>,
    pub(super) torque: Vector3<f64>,
    pub(super) body: Body<f64, 9>,
}

impl Place {
    pub(super) fn of<N: Count, F: Forces<f64, 9>>(bodies: &BodiesOf<F, N>, number: usize) -> Self {
        let body = bodies.body(number);
        let attitude = Rigid::attitude(&body.q);
        let torque = turning_part(&attitude, &Rigid::attitude(&bodies.kept.force[number].components()));
        Self { attitude, m: Vector3::from_row_slice(&body.p[..3]), torque, body }
    }

    pub(super) fn move_by(&mut self, turn: &Matrix3<f64>, change: &Vector3<f64>) {
        let Body { q, q_low, p, p_low } = &mut self.body;
        (*q, *q_low) = two_sum(q, &sum(q_low, &Rigid::coordinates(turn)));
        (*p, *p_low) = two_sum(p, &sum(p_low, &spread(change)));
        self.attitude = Rigid::attitude(q);
    }

    /// Q(3 − QᵀQ)/2 (Å. Björck, C. Bowie 1971), from 1 − QᵀQ.
    pub(super) fn straighten(&mut self, deviation: &Matrix3<f64>) {
        self.move_by(&(self.attitude * deviation * 0.5), &Vector3::zeros());
    }

    pub(super) fn put<N: Count, X>(self, bodies: &mut Bodies<N, f64, X, 9>, number: usize) {
        (bodies.q.as_mut()[number], bodies.q_low.as_mut()[number]) = (self.body.q, self.body.q_low);
        (bodies.p.as_mut()[number], bodies.p_low.as_mut()[number]) = (self.body.p, self.body.p_low);
    }
}

/// Rigid bodies in a field of force.
#[derive(Debug, Clone)]
pub struct Turning<F, N> {
    pub(super) body: Rigid,
    pub(super) effects: F,
    pub(super) count: N,
}

/// What is kept from one step to the next.
#[derive(Clone)]
pub struct Kept<F: Forces<f64, 9>> {
    /// Forces last evaluated.
    pub(super) force: Vec<F::Force>,
    /// ∂U/∂t with them, where forces change with time.
    pub(super) power: f64,
    /// Room of the effects.
    pub(super) of_effects: F::Room,
    /// Room for power series.
    pub(super) series: Option<Box<SeriesRoom>>,
}

impl<F: Forces<f64, 9>, N: Count> Turning<F, N> {
    /// Books the work of a kick by potentials that change with time.
    pub(super) fn book(&self, kick: f64, bodies: &mut BodiesOf<F, N>) {
        if self.effects.changes_with_time() && kick != 0.0 {
            bodies.work += kick * bodies.kept.power;
        }
    }
}

pub(crate) type BodiesOf<F, N> = Bodies<N, f64, Kept<F>, 9>;

impl<F: Forces<f64, 9>> fmt::Debug for Kept<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Kept").field("force", &self.force).finish_non_exhaustive()
    }
}
