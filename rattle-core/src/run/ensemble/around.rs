//! Lanes near other sheets of their surface.

use crate::number::lanes::Lane;
use crate::number::vectors::{Vectors, at};
use crate::run::ensemble::engine::Stuck;
use crate::run::ensemble::laws::Laws;
use crate::solve::crowd::{rises, shares};
use std::borrow::Borrow;

/// An error for the first lane that has another sheet near, after so many steps: where g does not rise along the
/// normal, of this square, at some share of this factor of the normal to both sides; see [`crate::solve::crowd`].
#[inline(always)]
pub(super) fn look_around<S: Lane, const L: usize, const D: usize>(
    laws: &impl Laws<S, D>,
    steps: u64,
    q: &Vectors<S, L, D>,
    normal: &Vectors<S, L, D>,
    square: &[S; L],
    furthest: &[S; L],
) -> Result<(), Stuck> {
    let mut least = *square;
    for share in shares(steps) {
        let share = S::from_f64(share);
        for i in 0..L {
            let shift = share * furthest[i];
            let rises = rises(laws.constraint(i).borrow(), &at(q, i), &at(normal, i), square[i], shift);
            least[i] = S::select(rises.le(least[i]), rises, least[i]);
        }
    }
    let crowded = least.iter().position(|&least| !S::default().le(least));
    crowded.map_or(Ok(()), |lane| Err(Stuck { lane, failure: None }))
}
