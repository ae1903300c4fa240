//! Rows of trajectories in lanes whose steps are [projected](crate::run::ensemble::projected) onto the constraint: the
//! numbers kept from step to step, and working memory for one step.

use crate::kernel::functions::ConstraintKernel;
use crate::motion::bodies::Body;
use crate::number::lanes::Lane;
use crate::number::vector::dot;
use crate::number::vectors::{Vectors, at, put};
use crate::run::ensemble::lane_record::{InRows, Rows};
use crate::run::ensemble::laws::Laws;
use crate::run::ensemble::row::pull;
use std::borrow::Borrow;

/// Where all lanes are on their way.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Place<S, const L: usize, const D: usize> {
    pub(super) q: Vectors<S, L, D>,
    pub(super) p: Vectors<S, L, D>,
    /// What rounding took from both; 0 where sums are not compensated.
    pub(super) q_low: Vectors<S, L, D>,
    pub(super) p_low: Vectors<S, L, D>,
    /// ∇g(q).
    pub(super) normal: Vectors<S, L, D>,
    /// f + ∇g λ, with λ from g̈ = 0.
    pub(super) pull: Vectors<S, L, D>,
}

/// Trajectories side by side.
#[derive(Clone)]
#[repr(C, align(64))]
pub(crate) struct Row<S, const L: usize, const D: usize> {
    pub(super) place: Place<S, L, D>,
    /// How far steps may lead astray: how far it was asked for other sheets; and how far they have since.
    pub(super) asked: [S; L],
    pub(super) astray: [S; L],
}

/// Numbers of one step, which need no keeping.
#[repr(C, align(64))]
pub(super) struct Scratch<S, R, const L: usize, const D: usize> {
    /// Where inner steps have led, and where the next ones end.
    pub(super) now: Place<S, L, D>,
    pub(super) trial: Place<S, L, D>,
    /// What an inner step changes places and momenta by, before it is projected.
    pub(super) way: Vectors<S, L, D>,
    pub(super) change: Vectors<S, L, D>,
    /// How much of the step is left, and what rounding took from that; the lengths of the inner step and of the next
    /// one. All with the sign of h.
    pub(super) left: [S; L],
    pub(super) left_low: [S; L],
    pub(super) inner: [S; L],
    pub(super) next: [S; L],
    /// Whether an inner step is taken.
    pub(super) taken: [bool; L],
    /// How far inner steps may have led astray.
    pub(super) strays: [S; L],
    /// 1 while a lane is moved, 0 where it has arrived, [`BY_ITSELF`](crate::run::ensemble::row::BY_ITSELF), or
    /// [`LOOKING`](crate::run::ensemble::row::LOOKING).
    pub(super) going: [S; L],
    /// The same for the search for the constraint; and the distance that it began its last Newton step at.
    pub(super) seeking: [S; L],
    pub(super) distance: [S; L],
    /// What rounding takes from places.
    pub(super) rounding: [S; L],
    /// Room of the method.
    pub(super) room: R,
}

impl<S: Lane, const L: usize, const D: usize> Place<S, L, D> {
    pub(super) fn new() -> Self {
        let zero = [[S::default(); L]; D];
        Self { q: zero, p: zero, q_low: zero, p_low: zero, normal: zero, pull: zero }
    }

    /// The vectors, without what rounding took from them.
    #[inline(always)]
    pub(super) fn vectors(&self) -> [&Vectors<S, L, D>; 4] {
        [&self.q, &self.p, &self.normal, &self.pull]
    }

    /// Puts a body into a lane. False where normals or forces are no numbers there.
    pub(super) fn set<const SUMS: usize>(
        &mut self,
        lane: usize,
        laws: &impl Laws<S, D>,
        &Body { q, q_low, p, p_low }: &Body<S, D>,
    ) -> bool {
        let [gradient] = laws.constraint(lane).borrow().jacobian(&q);
        let (_, total) = pull(laws, lane, &q, &p, &gradient);
        let Self { q: places, p: momenta, normal, pull, .. } = self;
        for (vectors, x) in [(places, q), (momenta, p), (normal, gradient), (pull, total)] {
            put(vectors, lane, x);
        }
        if const { SUMS > 0 } {
            put(&mut self.q_low, lane, q_low);
            put(&mut self.p_low, lane, p_low);
        }
        (dot(&total, &total) + dot(&p, &p)).le(S::from_f64(f64::MAX))
    }

    /// Has lane `to` be where lane `from` is.
    pub(super) fn copy(&mut self, from: usize, to: usize) {
        let Self { q, p, q_low, p_low, normal, pull } = self;
        [q, p, q_low, p_low, normal, pull].into_iter().for_each(|of| put(of, to, at(of, from)));
    }

    /// The body of a lane.
    pub(super) fn body(&self, lane: usize) -> Body<S, D> {
        let Self { q, p, q_low, p_low, .. } = self;
        let [q, q_low, p, p_low] = [q, q_low, p, p_low].map(|x| at(x, lane));
        Body { q, q_low, p, p_low }
    }
}

impl<S: Lane, R, const L: usize, const D: usize> Scratch<S, R, L, D> {
    pub(super) fn new(room: R) -> Self {
        let zero = [S::default(); L];
        let (now, trial, vectors) = (Place::new(), Place::new(), [zero; D]);
        Self {
            now,
            trial,
            way: vectors,
            change: vectors,
            left: zero,
            left_low: zero,
            inner: zero,
            next: zero,
            taken: [false; L],
            strays: zero,
            going: zero,
            seeking: zero,
            distance: zero,
            rounding: zero,
            room,
        }
    }
}

impl<S: Lane, const L: usize, const D: usize> Row<S, L, D> {
    /// A row in which no lane is set.
    pub(super) fn new() -> Self {
        let zero = [S::default(); L];
        Self { place: Place::new(), asked: zero, astray: zero }
    }
}

impl<S: Lane, const L: usize, const D: usize> InRows<S> for Row<S, L, D> {
    fn rows(&mut self) -> Rows<'_, S> {
        let Self { place: Place { q, p, q_low, p_low, normal, pull }, asked, astray } = self;
        let mut rows: Rows<'_, S> = Vec::new();
        for (name, vectors) in [
            ("q", q),
            ("p", p),
            ("q rounding", q_low),
            ("p rounding", p_low),
            ("normal", normal),
            ("pull", pull),
        ] {
            vectors.iter_mut().for_each(|numbers| rows.push((name, numbers)));
        }
        rows.extend([("asked", &mut asked[..]), ("astray", astray)]);
        rows
    }
}
