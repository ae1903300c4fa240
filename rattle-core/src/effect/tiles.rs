//! Forces between all pairs of bodies, several pairs at a time.
//!
//! Bodies are processed in tiles, coordinate by coordinate. Pairs within a tile are formed in a ring: body l with body
//! l + k, for all l at once, k = 1, 2, … up to half of the tile. Every later body is paired with all bodies of the tile
//! at once. Each pair is evaluated once: the force on one body is the opposite of that on the other.
//!
//! Distances, slopes of the potential, and forces have a loop each, which compilers vectorise. In a single loop, with
//! its long chain from the distance to the force, a processor would have too few pairs in flight.
//!
//! Sums use fused multiply-adds in an order that depends on the number of bodies alone, so every instruction set with
//! fused multiply-add gives the same forces.

use crate::kernel::functions::PairKernel;
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::number::vector::dot;
use crate::number::vectors::LANES;
use std::array::from_fn;

/// Shifts of a ring that go together: there is room for as many pairs.
const SHIFTS: usize = 8;

/// From so many bodies on it pays.
pub(crate) const MANY: usize = 8;

type Number = Fused<f64>;
/// D coordinates of bodies; whole cache lines, so that no register is stored across two of them.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Vectors<const D: usize, const L: usize>([[Number; L]; D]);

/// Numbers of pairs.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Pairs([Number; SHIFTS * LANES]);

impl<const D: usize, const L: usize> Vectors<D, L> {
    const ZERO: Self = Self([[Fused(0.0); L]; D]);
}

/// Adds the forces between all pairs, if there is an instruction set for it; says whether there was.
#[inline]
pub(crate) fn add_forces<K: PairKernel<Number>, const D: usize>(
    kernel: &K,
    positions: &[[f64; D]],
    forces: &mut [[f64; D]],
) -> bool {
    let set = Fusing::widest();
    if let Some(set) = set {
        set.run(AllPairs { kernel, positions, forces });
    }
    set.is_some()
}

struct AllPairs<'a, K, const D: usize> {
    kernel: &'a K,
    positions: &'a [[f64; D]],
    forces: &'a mut [[f64; D]],
}

impl<K: PairKernel<Number>, const D: usize> Work for AllPairs<'_, K, D> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { positions, forces, .. } = self;
        let kernel = self.kernel.clone(); // out of reach of what the loops write
        let (mut parts, mut pairs) = (Vectors::ZERO, Pairs([Fused(0.0); SHIFTS * LANES]));
        for first in (0..positions.len()).step_by(LANES) {
            let beyond = positions.len().min(first + LANES);
            let (tile, on_tile) = (&positions[first..beyond], &mut forces[first..beyond]);
            match tile.len() {
                0..=24 => ring::<K, D, 24>(&kernel, tile, on_tile, &mut pairs),
                25..=32 => ring::<K, D, 32>(&kernel, tile, on_tile, &mut pairs),
                33..=48 => ring::<K, D, 48>(&kernel, tile, on_tile, &mut pairs),
                _ => ring::<K, D, LANES>(&kernel, tile, on_tile, &mut pairs),
            }
            if beyond == positions.len() {
                return;
            }
            let (mut places, mut pushes) = (Vectors::ZERO, Vectors::ZERO);
            for (l, q) in tile.iter().enumerate() {
                put(&mut places, l, q);
            }
            for (q, force) in positions[beyond..].iter().zip(&mut forces[beyond..]) {
                add(force, meet(&kernel, &q.map(Fused), &places, &mut pushes, &mut parts));
            }
            for (l, force) in forces[first..beyond].iter_mut().enumerate() {
                add(force, from_fn(|d| pushes.0[d][l]));
            }
        }
    }
}

#[inline(always)]
fn put<const D: usize, const L: usize>(vectors: &mut Vectors<D, L>, l: usize, x: &[f64; D]) {
    for d in 0..D {
        vectors.0[d][l] = Fused(x[d]);
    }
}

/// Adds −2 times `more`.
#[inline(always)]
fn add<const D: usize>(force: &mut [f64; D], more: [Number; D]) {
    for d in 0..D {
        force[d] += -2.0 * more[d].0;
    }
}

/// Adds the forces between the bodies of a tile, at most L. (Fewer than 24 lanes would be unrolled before loops are
/// vectorised.)
#[inline(always)]
fn ring<K: PairKernel<Number>, const D: usize, const L: usize>(
    kernel: &K,
    positions: &[[f64; D]],
    forces: &mut [[f64; D]],
    pairs: &mut Pairs,
) {
    let number = positions.len();
    let mut places = Vectors::<D, { 2 * LANES }>::ZERO; // twice around
    for (l, q) in positions.iter().chain(positions).take(2 * LANES).enumerate() {
        put(&mut places, l, q);
    }
    let (mut own, mut others) = (Vectors::<D, L>::ZERO, Vectors::<D, { 2 * LANES }>::ZERO);
    for first in (1..=number / 2).step_by(SHIFTS) {
        let shifts = first..(number / 2 + 1).min(first + SHIFTS);
        let rows = pairs.0.as_chunks_mut::<L>().0;
        for (shift, squares) in shifts.clone().zip(rows) {
            squares_of_shift(&places, shift, squares);
        }
        let chunks = (shifts.len() * L).div_ceil(LANES);
        for squares in &mut pairs.0.as_chunks_mut::<LANES>().0[..chunks] {
            kernel.slope_block(squares);
        }
        let rows = pairs.0.as_chunks::<L>().0;
        for (shift, slopes) in shifts.zip(rows) {
            let pairs = if 2 * shift == number { shift } else { number };
            push_of_shift(&places, shift, pairs, slopes, &mut own, &mut others);
        }
    }
    for (l, force) in forces.iter_mut().enumerate().take(L) {
        add(force, from_fn(|d| own.0[d][l] + (others.0[d][l] + others.0[d][l + number])));
    }
}

/// |qₗ − qₗ₊ₖ|².
#[inline(always)]
fn squares_of_shift<const D: usize, const L: usize>(
    places: &Vectors<D, { 2 * LANES }>,
    shift: usize,
    squares: &mut [Number; L],
) {
    let shifted = places.0.each_ref().map(|x| &x[shift..][..L]);
    for l in 0..L {
        let apart: [Number; D] = from_fn(|d| places.0[d][l] - shifted[d][l]);
        squares[l] = dot(&apart, &apart);
    }
}

/// Adds −½ of the forces of the first so many pairs, on the first body of each and on the second.
#[inline(always)]
fn push_of_shift<const D: usize, const L: usize>(
    places: &Vectors<D, { 2 * LANES }>,
    shift: usize,
    pairs: usize,
    slopes: &[Number; L],
    own: &mut Vectors<D, L>,
    others: &mut Vectors<D, { 2 * LANES }>,
) {
    let shifted = places.0.each_ref().map(|x| &x[shift..][..L]);
    let others = others.0.each_mut().map(|x| &mut x[shift..][..L]);
    for l in 0..L {
        let slope = Real::select(l < pairs, slopes[l], Fused(0.0));
        for d in 0..D {
            let apart = places.0[d][l] - shifted[d][l];
            own.0[d][l] = slope.multiply_add(apart, own.0[d][l]);
            others[d][l] = (-slope).multiply_add(apart, others[d][l]);
        }
    }
}

/// Adds to `pushes` −½ of the forces of a body at q on the bodies of a tile, and gives −½ of that on the body.
#[inline(always)]
fn meet<K: PairKernel<Number>, const D: usize>(
    kernel: &K,
    q: &[Number; D],
    places: &Vectors<D, LANES>,
    pushes: &mut Vectors<D, LANES>,
    parts: &mut Vectors<D, LANES>,
) -> [Number; D] {
    let mut slope = [Fused(0.0); LANES]; // at first |q − qₗ|²
    for l in 0..LANES {
        let apart: [Number; D] = from_fn(|d| q[d] - places.0[d][l]);
        slope[l] = dot(&apart, &apart);
    }
    kernel.slope_block(&mut slope);
    for l in 0..LANES {
        for d in 0..D {
            let apart = q[d] - places.0[d][l];
            parts.0[d][l] = slope[l] * apart;
            pushes.0[d][l] = (-slope[l]).multiply_add(apart, pushes.0[d][l]);
        }
    }
    let mut sums = [Fused(0.0); D];
    for d in 0..D {
        let parts = &mut parts.0[d];
        fold::<32>(parts);
        fold::<16>(parts);
        fold::<8>(parts);
        let [a, b, c, d_, e, f, g, h, ..] = *parts;
        sums[d] = ((a + e) + (c + g)) + ((b + f) + (d_ + h));
    }
    sums
}

/// Adds the second so many to the first.
#[inline(always)]
fn fold<const HALF: usize>(parts: &mut [Number; LANES]) {
    for l in 0..HALF {
        parts[l] = parts[l] + parts[HALF + l];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::instructions::InstructionSet;

    /// U = exp(−s) + √s.
    #[derive(Clone)]
    struct Bell;

    impl PairKernel<Number> for Bell {
        #[inline(always)]
        fn value(&self, s: Number) -> Number {
            (-s).exp() + s.sqrt()
        }
        #[inline(always)]
        fn slope(&self, s: Number) -> Number {
            Fused(0.5) / s.sqrt() - (-s).exp()
        }
    }

    #[test]
    fn every_instruction_set_gives_the_same_forces() {
        for n in [2, 9, 17, 33, 64, 65, 150] {
            let place = |i: usize, d: usize| (1.7 * (3 * i + d) as f64 + 0.1 * i as f64).sin();
            let positions: Vec<[f64; 3]> = (0..n).map(|i| from_fn(|d| place(i, d))).collect();
            let of = |set: InstructionSet| {
                let mut forces = vec![[0.0; 3]; n];
                set.run(AllPairs { kernel: &Bell, positions: &positions, forces: &mut forces });
                forces.iter().flatten().map(|f| f.to_bits()).collect::<Vec<_>>()
            };
            // The portable one does multiply-add by a function.
            let portable = of(InstructionSet::Portable);
            for set in [InstructionSet::Avx2, InstructionSet::Avx512] {
                assert_eq!(of(set), portable, "{n} bodies, {set}");
            }
        }
    }
}
