//! How far the lanes of a row have come in a step whose inner steps each lane has for itself, as many as its trajectory
//! needs. What is moved, and by which method, is another.

use crate::methods::dop853::SMALLEST_PART;
use crate::motion::method::Method;
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::number::vector::two_sum;
use crate::run::ensemble::engine::Stuck;
use crate::systems::network::in_lanes::{Number, Numbers, Which, zeros};

/// Inner steps, those that are repeated among them, after which a lane goes by itself.
pub(super) const MOST_PASSES: usize = 1024;

/// Newton steps onto the constraints after which a lane goes by itself.
pub(super) const MOST_NEWTON_STEPS: usize = 12;

/// A lane is moved, has arrived, or has to take the step by itself.
pub(super) const MOVES: u64 = 1;
pub(super) const ARRIVED: u64 = 0;
pub(super) const BY_ITSELF: u64 = 2;

/// How far all lanes have come in a step.
pub(super) struct Pace<const W: usize> {
    h: f64,
    tolerance: Option<f64>,
    /// How much of the step is left, and what rounding took from that; the lengths of the inner step and of the next
    /// one.
    pub(super) left: Numbers<W>,
    left_low: Numbers<W>,
    pub(super) inner: Numbers<W>,
    pub(super) next: Numbers<W>,
    /// Whether the inner step is within the tolerance.
    pub(super) taken: [bool; W],
    /// Whether a lane [moves](MOVES).
    pub(super) going: Which<W>,
}

impl<const W: usize> Pace<W> {
    /// For steps of this method.
    pub(super) fn new(method: &impl Method) -> Self {
        let ([left, left_low, inner, next], h) = ([zeros(); 4], method.step_size());
        let tolerance = method.tolerance();
        Self { h, tolerance, left, left_low, inner, next, taken: [true; W], going: [ARRIVED; W] }
    }

    /// The whole step.
    pub(super) fn h(&self) -> Number {
        Fused(self.h)
    }

    /// Begins a step.
    #[inline(always)]
    pub(super) fn begin(&mut self) {
        let h = self.h();
        (self.left.0, self.inner.0, self.going) = ([h; W], [h; W], [MOVES; W]);
        self.left_low = zeros();
    }

    /// Begins an inner step, which goes no farther than the step.
    #[inline(always)]
    pub(super) fn begin_inner(&mut self) {
        for l in 0..W {
            let [left, inner] = [self.left.0[l], self.inner.0[l]];
            self.inner.0[l] = Real::select(left.0.abs() <= inner.0.abs(), left, inner);
        }
    }

    /// What errors of inner steps may be, if they are not as long as the step.
    #[inline(always)]
    pub(super) fn tolerance(&self) -> Option<f64> {
        self.tolerance
    }

    /// Whether a lane goes where its inner step leads, if that can be believed.
    #[inline(always)]
    pub(super) fn takes(&self, l: usize) -> bool {
        (self.going[l] == MOVES) & self.taken[l]
    }

    /// Has a lane go by itself that goes where its inner step leads, if that cannot be believed.
    #[inline(always)]
    pub(super) fn doubt(&mut self, l: usize, believed: bool) {
        self.going[l] = if self.takes(l) & !believed { BY_ITSELF } else { self.going[l] };
    }

    /// Goes on after this many inner steps. Returns which lanes are where theirs led, and whether a lane has still some
    /// way to go.
    #[inline(always)]
    pub(super) fn advance(&mut self, passes: usize) -> (Which<W>, bool) {
        let (shortest, end) = (SMALLEST_PART * self.h().0.abs(), passes == MOST_PASSES);
        let (mut moves, mut any) = ([0; W], false);
        for l in 0..W {
            let (goes, takes, left) = (self.going[l] == MOVES, self.takes(l), self.left.0[l]);
            moves[l] = u64::from(takes);
            let ([less], [lost]) = two_sum(&[left], &[-self.inner.0[l]]);
            let low = self.left_low.0[l];
            let (left, low) = if takes { (less, low + lost) } else { (left, low) };
            let collapsed = !self.taken[l] & (self.next.0[l].0.abs() < shortest);
            let arrived = left.0 == 0.0;
            let on = if arrived { ARRIVED } else { MOVES };
            let on = if collapsed | (end & !arrived) { BY_ITSELF } else { on };
            let ([left], [low]) = two_sum(&[left], &[if arrived { Fused(0.0) } else { low }]);
            (self.left.0[l], self.left_low.0[l], self.inner.0[l]) = (left, low, self.next.0[l]);
            self.going[l] = if goes { on } else { self.going[l] };
            any |= self.going[l] == MOVES;
        }
        (moves, any)
    }
}

/// Has lanes that go [by themselves](BY_ITSELF) moved one by one, and put copies with what they are copies of. All that
/// cannot are told of at once: each is left out before the row is tried again.
#[cold]
#[inline(never)]
pub(super) fn one_by_one<X, const W: usize>(
    going: &Which<W>,
    copy_of: &[usize; W],
    moved: &mut dyn FnMut(usize) -> Result<X, Stuck>,
    put: &mut dyn FnMut(usize, &X),
) -> Result<(), Vec<Stuck>> {
    let mut stuck = Vec::new();
    for of in (0..W).filter(|&of| copy_of[of] == of && going[of] == BY_ITSELF) {
        match moved(of) {
            Ok(landed) => (0..W).filter(|&lane| copy_of[lane] == of).for_each(|lane| put(lane, &landed)),
            Err(why) => stuck.push(why),
        }
    }
    if stuck.is_empty() { Ok(()) } else { Err(stuck) }
}
