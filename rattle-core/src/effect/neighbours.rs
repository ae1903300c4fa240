//! Neighbour lists: which bodies are near each other, valid for some steps.
//!
//! ```text
//! |qᵢ − qⱼ| ≤ reach + skin        where bodies were when the list was made
//! ```
//!
//! As long as no body has moved by more than half of the skin since then, all pairs within reach are in the list (L.
//! Verlet 1967). The list is made again in time, from cells, in a number of operations proportional to the number of
//! near pairs.
//!
//! The row of body i holds its partners j < i in the order of their numbers. A loop over all rows, and over the
//! partners within reach in each, goes through the same pairs in the same order for every valid list. So sums do not
//! depend on the list, not even in the last bit.

use crate::effect::cells::{BLOCK, Cells, STRETCHES};
use crate::kernel::space::Space;
use crate::number::instructions::{InstructionSet, Work};
use std::array::from_fn;

/// So few bodies need no list.
const FEW: usize = 32;
/// Of so many parts of all pairs a list is made at most: where more are near, all are partners.
const MOST: usize = 4;

/// The list of near pairs, with the memory needed to make it.
#[doc(alias = "cell list")]
#[doc(alias = "Verlet list")]
#[derive(Debug, Clone)]
pub struct Neighbours<const D: usize> {
    /// Where bodies were when the list was made; NaN where there is none.
    made_at: Vec<[f64; D]>,
    /// Row i goes from `starts[i]` to `starts[i + 1]`.
    starts: Vec<usize>,
    /// As long as is allocated.
    partners: Vec<u32>,
    /// Whether all are partners, so that the row of i is the numbers below i …
    all: bool,
    /// … which are these.
    numbers: Vec<u32>,
    cells: Cells<D>,
    /// Near bodies with higher numbers, of each body in the order of cells; as long as is allocated.
    found: Vec<u32>,
    /// Where those of each body begin and end.
    found_of: Vec<(usize, usize)>,
}

impl<const D: usize> Neighbours<D> {
    /// No list yet, with room for so many bodies. Lists take the room that they need when the first one is made, and
    /// half as much more; who crowd later have it grow, by half each time.
    pub(crate) fn new(bodies: usize) -> Self {
        Self {
            made_at: vec![[f64::NAN; D]; bodies],
            starts: vec![0; bodies + 1],
            partners: Vec::new(),
            all: false,
            numbers: (0..bodies as u32).collect(),
            cells: Cells::new(bodies),
            found: vec![0; 16 * bodies],
            found_of: vec![(0, 0); bodies],
        }
    }

    /// Partners of a body with lower numbers, in their order.
    #[inline(always)]
    pub(crate) fn row(&self, body: usize) -> &[u32] {
        if self.all {
            &self.numbers[..body]
        } else {
            &self.partners[self.starts[body]..self.starts[body + 1]]
        }
    }

    /// All bodies are partners, wherever they are.
    pub(crate) fn take_all(&mut self) {
        self.made_at.fill([f64::NAN; D]);
        self.all = true;
    }

    /// The number of pairs in the list.
    #[must_use]
    pub fn pairs(&self) -> usize {
        (0..self.made_at.len()).map(|body| self.row(body).len()).sum()
    }

    /// Makes the list anew if it does not serve at these positions; says whether it does now: not where a position is
    /// not finite.
    #[inline]
    pub(crate) fn renew<B: Space<D>>(
        &mut self,
        positions: &[[f64; D]],
        space: &B,
        reach: f64,
        skin: f64,
    ) -> bool {
        let set = InstructionSet::widest();
        let stay = Stay { positions, were: &self.made_at, limit: 0.25 * skin * skin };
        if set.run(stay) {
            return true;
        }
        if !positions.iter().flatten().all(|x| x.is_finite()) {
            self.made_at.fill([f64::NAN; D]);
            return false;
        }
        self.made_at.copy_from_slice(positions);
        let bodies = positions.len();
        self.all = bodies <= FEW;
        if self.all {
            return true;
        }
        // Distances round by some parts of themselves, and across periods by parts of the largest coordinate too.
        let closed = space.periods().map(f64::is_finite);
        let largest = |d: usize| positions.iter().fold(0.0_f64, |largest, q| largest.max(q[d].abs()));
        let largest = (0..D).filter(|&d| closed[d]).map(largest).fold(0.0, f64::max);
        let far = (reach + skin) * (1.0 + 1e-12) + 4096.0 * f64::EPSILON * largest;
        self.cells.sort(positions, space, far);
        let find = Find {
            cells: &self.cells,
            space: *space,
            far: far * far,
            most: bodies * (bodies - 1) / (2 * MOST),
            found: &mut self.found,
            found_of: &mut self.found_of,
        };
        let Some(pairs) = set.run(find) else {
            self.all = true;
            return true;
        };
        self.transpose(pairs);
        true
    }

    /// Rows of lower partners from those of higher ones: bodies are entered in turn, so that rows are in their order.
    fn transpose(&mut self, pairs: usize) {
        enlarge(&mut self.found, pairs);
        enlarge(&mut self.partners, pairs);
        let (starts, found) = (&mut self.starts, &self.found[..pairs]);
        starts.fill(0);
        for &partner in found {
            starts[partner as usize] += 1;
        }
        let mut sum = 0;
        for start in starts.iter_mut() {
            sum += *start;
            *start = sum - *start;
        }
        for (number, &(from, to)) in (0..).zip(&self.found_of) {
            for &partner in &found[from..to] {
                let place = &mut starts[partner as usize];
                self.partners[*place] = number;
                *place += 1;
            }
        }
        // Each is now where the next one begins.
        starts.rotate_right(1);
        starts[0] = 0;
    }
}

/// Has room for so many and half as many more, if there is not room for so many and an eighth more.
fn enlarge(list: &mut Vec<u32>, size: usize) {
    if list.len() < size + size / 8 {
        list.resize(size + size / 2, 0);
    }
}

/// Whether no body has moved farther than the root of the limit; not so for NaN.
struct Stay<'a, const D: usize> {
    positions: &'a [[f64; D]],
    were: &'a [[f64; D]],
    limit: f64,
}

impl<const D: usize> Work for Stay<'_, D> {
    type Done = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let mut all = true;
        for (q, was) in self.positions.iter().zip(self.were) {
            let moved: [f64; D] = from_fn(|d| q[d] - was[d]);
            all &= moved.iter().map(|x| x * x).sum::<f64>() <= self.limit;
        }
        all
    }
}

/// Finds near bodies with higher numbers, and says how many pairs there are; nothing if they are more than `most`.
struct Find<'a, B, const D: usize> {
    cells: &'a Cells<D>,
    space: B,
    /// The square of how far is near.
    far: f64,
    most: usize,
    found: &'a mut Vec<u32>,
    found_of: &'a mut [(usize, usize)],
}

impl<B: Space<D>, const D: usize> Work for Find<'_, B, D> {
    type Done = Option<usize>;

    #[inline(always)]
    fn run(self) -> Option<usize> {
        let Self { cells, space, far, most, found, found_of } = self;
        let (places, numbers) = (cells.places.each_ref().map(|x| &x[..]), &cells.numbers[..]);
        let (mut near, mut pairs, mut hints) = ([0; BLOCK], 0, [0; STRETCHES]);
        for cell in 0..cells.number() {
            let (stretches, count) = cells.beside(cell, &mut hints);
            for at in cells.of(cell) {
                let (q, number, begin) = (places.map(|x| x[at]), numbers[at], pairs);
                for stretch in &stretches[..count] {
                    for from in stretch.clone().step_by(BLOCK) {
                        let places = places.map(|x| &x[from..][..BLOCK]);
                        let (numbers, inside) = (&numbers[from..][..BLOCK], stretch.end - from);
                        mark(&space, &q, number, far, inside, &places, numbers, &mut near);
                        if found.len() < pairs + BLOCK {
                            found.resize(2 * found.len() + BLOCK, 0);
                        }
                        for (first, eight) in (0..).step_by(8).zip(near.as_chunks().0) {
                            let mut bits = u64::from_le_bytes(*eight);
                            while bits != 0 {
                                found[pairs] = numbers[first + bits.trailing_zeros() as usize / 8];
                                pairs += 1;
                                bits &= bits - 1;
                            }
                        }
                    }
                }
                found_of[number as usize] = (begin, pairs);
                if pairs > most {
                    return None;
                }
            }
        }
        Some(pairs)
    }
}

/// Marks with 1 who of the first so many of these bodies has a higher number and is near; with 0 who is not.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "what a loop reads is an argument of its own")]
fn mark<B: Space<D>, const D: usize>(
    space: &B,
    q: &[f64; D],
    number: u32,
    far: f64,
    inside: usize,
    places: &[&[f64]; D],
    numbers: &[u32],
    near: &mut [u8; BLOCK],
) {
    let (places, numbers) = (places.map(|x| &x[..BLOCK]), &numbers[..BLOCK]);
    let mut squares = [0.0; BLOCK];
    for l in 0..BLOCK {
        let apart: [f64; D] = space.apart(q, &from_fn(|d| places[d][l]));
        squares[l] = apart.iter().map(|x| x * x).sum();
    }
    for l in 0..BLOCK {
        near[l] = u8::from((squares[l] <= far) & (numbers[l] > number) & (l < inside));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::space::{Open, Periodic};

    /// Rows against distances between all bodies: none within reach is missing wherever bodies are, none is listed
    /// without need.
    fn check<B: Space<D>, const D: usize>(space: B, size: f64) {
        let (bodies, reach, skin) = (400, 0.2, 0.05);
        let mut list = Neighbours::<D>::new(bodies);
        let part = |i: usize, d: usize| (1e4 * (1.7 * (D * i + d) as f64).sin()).rem_euclid(1.0) - 0.5;
        for offset in [0.0, 1e3, -1e9] {
            let mut places: Vec<[f64; D]> =
                (0..bodies).map(|i| from_fn(|d| size * part(i, d) + offset)).collect();
            places[7][D - 1] = 1e300;
            places[8] = [offset - 1e8; D];
            assert!(list.renew(&places, &space, reach, skin));
            let mut near = 0;
            for i in 0..bodies {
                let row = list.row(i);
                assert!(row.is_sorted_by(|a, b| a < b), "{D} coordinates, body {i}: {row:?}");
                for j in 0..i {
                    let apart = space.apart(&places[i], &places[j]).iter().map(|x| x * x).sum::<f64>().sqrt();
                    let listed = row.contains(&(j as u32));
                    assert!(listed || apart > reach + skin, "{D} coordinates, {i} and {j}, {apart} apart");
                    let far = apart > reach + skin + 1e-4; // some thousand roundings of a coordinate of 10⁸
                    assert!(!(listed && far) || list.all || offset != 0.0, "{i} and {j}, {apart} apart");
                    near += usize::from(!far);
                }
            }
            assert!(near > bodies && (!list.all || B::periods(&space)[0].is_finite()), "{near} pairs");
        }
    }

    #[test]
    fn lists_hold_all_near_pairs_in_any_dimension() {
        check::<_, 1>(Open, 20.0);
        check::<_, 2>(Open, 3.0);
        check::<_, 3>(Open, 1.5);
        check::<_, 4>(Open, 1.0);
        check::<_, 6>(Open, 0.6);
        for period in [0.5, 0.6, 0.9, 2.0] {
            check(Periodic::new([period]), 40.0);
            check(Periodic::new([period, f64::INFINITY]), 6.0);
            check(Periodic::new([2.0 * period, 1.0, f64::INFINITY]), 2.0);
        }
    }
}
