//! Lanes that cross a kink of their surface.

use crate::kernel::kinks::{first_kink, sign_changes};
use crate::motion::failure::Failure;
use crate::number::lanes::Lane;
use crate::number::vectors::{Vectors, at};
use crate::run::ensemble::engine::Stuck;
use crate::run::ensemble::laws::Laws;
use std::borrow::Borrow;

/// The first lane that has come across a kink on its way from one place to another, if one has.
#[inline(always)]
pub(super) fn crossings<S: Lane, const L: usize, const D: usize>(
    laws: &impl Laws<S, D>,
    from: &Vectors<S, L, D>,
    to: &Vectors<S, L, D>,
) -> Result<(), Stuck> {
    let (mut changes, mut any) = ([false; L], false);
    for lane in 0..L {
        changes[lane] = sign_changes(laws.constraint(lane).borrow(), &[at(from, lane)], &[at(to, lane)]);
    }
    changes.iter().for_each(|&changed| any |= changed);
    if any {
        for lane in (0..L).filter(|&lane| changes[lane]) {
            kink(laws, lane, at(from, lane), at(to, lane), Ok(()))?;
        }
    }
    Ok(())
}

/// What became of a lane: where there is a kink on its way, that, also if it could not be moved.
#[cold]
#[inline(never)]
pub(super) fn kink<S: Lane, const D: usize>(
    laws: &impl Laws<S, D>,
    lane: usize,
    from: [S; D],
    to: [S; D],
    otherwise: Result<(), Stuck>,
) -> Result<(), Stuck> {
    let [from, to] = [from, to].map(|q| q.map(S::to_f64));
    match first_kink::<S, _, D, 1, 1>(laws.constraint(lane).borrow(), &[from], &[to]) {
        Some(kink) => Err(Stuck { lane, failure: Some(Failure::of_kink(kink, 0, None)) }),
        None => otherwise,
    }
}
