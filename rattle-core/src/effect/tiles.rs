//! Forces and energies of all pairs of bodies, several pairs at a time, and on several threads where bodies are many.
//!
//! Bodies are processed in tiles, coordinate by coordinate. Pairs within a tile are formed in a ring: body l with body
//! l + k, for all l at once, k = 1, 2, … up to half of the tile. A body of a later tile is paired with all bodies of
//! the tile at once. Each pair is evaluated once: the force on one body is the opposite of that on the other.
//!
//! Distances, slopes of the potential, and forces have a loop each, which compilers vectorise. In a single loop, with
//! its long chain from the distance to the force, a processor would have too few pairs in flight.
//!
//! Tiles are halved again and again (Frigo, Leiserson, Strumpen; [`Pairing`]): first the pairs within each half, then
//! those between the halves, of which two quarters at a time have no body in common. So two threads never add to one
//! force, and need no room of their own.
//!
//! Sums use fused multiply-adds in an order that depends on the number of bodies alone: every instruction set with
//! fused multiply-add and any number of threads give the same forces, and the same energies.

use crate::kernel::functions::PairKernel;
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::number::vector::dot;
use crate::number::vectors::{Chunks, LANES};
use std::array::from_fn;
use std::ops::Range;

/// Shifts of a ring that go together: there is room for as many pairs.
const SHIFTS: usize = 8;

/// From so many bodies on it pays.
pub(crate) const MANY: usize = 8;

/// From so many bodies on several threads pay: below, a step takes less than half a millisecond.
const FOR_THREADS: usize = 1000;

/// So many sums of forces on one body go on side by side: two registers wait for each other's results less than one.
const SUMS: usize = LANES / 4;

/// So many bodies and so many others are one piece of work, some twenty microseconds.
const PIECE: usize = 2 * LANES;

type Number = Fused<f64>;
/// D coordinates of bodies; whole cache lines, so that no register is stored across two of them.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Vectors<const D: usize, const L: usize>([[Number; L]; D]);

/// Numbers of pairs: L for each shift.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Pairs<const L: usize>([[Number; L]; SHIFTS]);

impl<const D: usize, const L: usize> Vectors<D, L> {
    const ZERO: Self = Self([[Fused(0.0); L]; D]);
}

impl<const L: usize> Pairs<L> {
    const ZERO: Self = Self([[Fused(0.0); L]; SHIFTS]);

    /// Replaces each |qₗ − qₗ₊ₖ|² of these shifts by a function of it.
    #[inline(always)]
    fn evaluate<const D: usize, const TWICE: usize>(
        &mut self,
        places: &Vectors<D, TWICE>,
        shifts: Range<usize>,
        function: impl Fn(&mut [Number; LANES]),
    ) {
        let chunks = (shifts.len() * L).div_ceil(LANES);
        for (shift, squares) in shifts.zip(&mut self.0) {
            squares_of_shift(places, shift, squares);
        }
        for squares in &mut self.0.as_flattened_mut().as_chunks_mut::<LANES>().0[..chunks] {
            function(squares);
        }
    }
}

/// Adds the forces between all pairs, if there is an instruction set for it; says whether there was. On the threads of
/// the [rayon](https://docs.rs/rayon) pool that it is called in, where that pays.
#[inline]
pub(crate) fn add_forces<K: PairKernel<Number>, const D: usize>(
    kernel: &K,
    positions: &[[f64; D]],
    forces: &mut [[f64; D]],
) -> bool {
    let set = Fusing::widest();
    if let Some(set) = set {
        // Not from outside: whoever hands work to a pool allocates now and then.
        let threads = positions.len() >= FOR_THREADS && rayon::current_thread_index().is_some();
        Pairing { kernel, set, threads }.among(positions, forces);
    }
    set.is_some()
}

/// The energy of all pairs, if there is an instruction set for it.
pub(crate) fn energy<K: PairKernel<Number>, const D: usize>(
    kernel: &K,
    positions: &[[f64; D]],
) -> Option<f64> {
    let chunks = [Chunks::of(LANES), Chunks::of((positions.len() - 1) % LANES + 1)];
    Fusing::widest().map(|set| set.run(Energies { kernel, positions, chunks }))
}

/// Halves of so many bodies, the first of whole tiles.
fn half(bodies: usize) -> usize {
    bodies.min(bodies.div_ceil(LANES).div_ceil(2) * LANES)
}

/// Forces between pairs, in halves.
struct Pairing<'a, K> {
    kernel: &'a K,
    set: Fusing,
    threads: bool,
}

impl<K: PairKernel<Number>> Pairing<'_, K> {
    /// Two pieces of work on forces of different bodies.
    fn both(&self, one: impl FnOnce() + Send, other: impl FnOnce() + Send) {
        if self.threads {
            rayon::join(one, other);
        } else {
            one();
            other();
        }
    }

    /// Pairs of some bodies.
    fn among<const D: usize>(&self, q: &[[f64; D]], forces: &mut [[f64; D]]) {
        if q.len() <= LANES {
            let chunks = Chunks::of(q.len());
            return self.set.run(Piece { kernel: self.kernel, q, forces, others: None, chunks });
        }
        let half = half(q.len());
        let ((a, b), (on_a, on_b)) = (q.split_at(half), forces.split_at_mut(half));
        self.both(|| self.among(a, on_a), || self.among(b, on_b));
        self.between(a, on_a, b, on_b);
    }

    /// Pairs of bodies `a`, in whole tiles, and others, `b`.
    fn between<const D: usize>(
        &self,
        a: &[[f64; D]],
        on_a: &mut [[f64; D]],
        b: &[[f64; D]],
        on_b: &mut [[f64; D]],
    ) {
        if a.len() <= PIECE && b.len() <= PIECE {
            let (others, chunks) = (Some((b, on_b)), Chunks::of(LANES));
            return self.set.run(Piece { kernel: self.kernel, q: a, forces: on_a, others, chunks });
        }
        let ((a1, a2), (b1, b2)) = (a.split_at(half(a.len())), b.split_at(half(b.len())));
        let ((on_a1, on_a2), (on_b1, on_b2)) = (on_a.split_at_mut(a1.len()), on_b.split_at_mut(b1.len()));
        self.both(|| self.between(a1, on_a1, b1, on_b1), || self.between(a2, on_a2, b2, on_b2));
        self.both(|| self.between(a1, on_a1, b2, on_b2), || self.between(a2, on_a2, b1, on_b1));
    }
}

/// The pairs of a tile, or those of some whole tiles with other bodies.
struct Piece<'a, K, const D: usize> {
    kernel: &'a K,
    q: &'a [[f64; D]],
    forces: &'a mut [[f64; D]],
    #[allow(clippy::type_complexity, reason = "places, and the forces there")]
    others: Option<(&'a [[f64; D]], &'a mut [[f64; D]])>,
    /// Of a tile.
    chunks: Chunks,
}

impl<K: PairKernel<Number>, const D: usize> Work for Piece<'_, K, D> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { q, forces, others, chunks, .. } = self;
        let kernel = self.kernel.clone(); // out of reach of what the loops write
        let Some((others, on_others)) = others else {
            return match q.len() {
                0..=24 => ring::<K, D, 24, 48>(&kernel, q, forces, chunks),
                25..=32 => ring::<K, D, 32, 64>(&kernel, q, forces, chunks),
                33..=48 => ring::<K, D, 48, 96>(&kernel, q, forces, chunks),
                _ => ring::<K, D, LANES, { 2 * LANES }>(&kernel, q, forces, chunks),
            };
        };
        for (tile, on_tile) in q.chunks(LANES).zip(forces.chunks_mut(LANES)) {
            let (mut places, mut pushes) = (Vectors::ZERO, Vectors::ZERO);
            chunks.put_into(tile, &mut places.0, 0, |q| q.map(Fused));
            for (q, force) in others.iter().zip(on_others.iter_mut()) {
                add(force, meet(&kernel, &q.map(Fused), &places, &mut pushes));
            }
            for (l, force) in on_tile.iter_mut().enumerate().take(LANES) {
                add(force, from_fn(|d| pushes.0[d][l]));
            }
        }
    }
}

/// Energies of all pairs, tile by tile, each with all later bodies.
struct Energies<'a, K, const D: usize> {
    kernel: &'a K,
    positions: &'a [[f64; D]],
    /// Of whole tiles, and of the last one.
    chunks: [Chunks; 2],
}

impl<K: PairKernel<Number>, const D: usize> Work for Energies<'_, K, D> {
    type Done = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let Self { positions, chunks: [whole, last], .. } = self;
        let kernel = self.kernel.clone(); // out of reach of what the loops write
        let mut sums = Vectors::<1, LANES>::ZERO;
        for (number, tile) in positions.chunks(LANES).enumerate() {
            let later = &positions[positions.len().min((number + 1) * LANES)..];
            let chunks = if later.is_empty() { last } else { whole };
            ring_energies::<K, D>(&kernel, tile, &mut sums.0[0], chunks);
            let mut places = Vectors::<D, LANES>::ZERO;
            chunks.put_into(tile, &mut places.0, 0, |q| q.map(Fused));
            for q in later {
                let mut values = squares(&q.map(Fused), &places);
                values_of(&kernel, &mut values);
                for l in 0..LANES {
                    sums.0[0][l] = sums.0[0][l] + values[l];
                }
            }
        }
        total(&sums.0[0]).0
    }
}

/// Replaces each r² by U.
#[inline(always)]
fn values_of<K: PairKernel<Number>>(kernel: &K, squares: &mut [Number; LANES]) {
    for l in 0..LANES {
        squares[l] = kernel.value(squares[l]);
    }
}

/// Adds the energies between the bodies of a tile.
#[inline(always)]
fn ring_energies<K: PairKernel<Number>, const D: usize>(
    kernel: &K,
    positions: &[[f64; D]],
    sums: &mut [Number; LANES],
    chunks: Chunks,
) {
    let number = positions.len().min(LANES);
    let mut places = Vectors::<D, { 2 * LANES }>::ZERO; // twice around
    chunks.put_into(positions, &mut places.0, 0, |q| q.map(Fused));
    chunks.put_into(positions, &mut places.0, number, |q| q.map(Fused));
    let mut values = Pairs::<LANES>::ZERO;
    for first in (1..=number / 2).step_by(SHIFTS) {
        let shifts = first..(number / 2 + 1).min(first + SHIFTS);
        values.evaluate(
            &places,
            shifts.clone(),
            #[inline(always)] // else compiled without the instruction set where it is long
            |squares| values_of(kernel, squares),
        );
        for (shift, values) in shifts.zip(&values.0) {
            let pairs = if 2 * shift == number { shift } else { number };
            for l in 0..LANES {
                sums[l] = sums[l] + Real::select(l < pairs, values[l], Fused(0.0));
            }
        }
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
fn ring<K: PairKernel<Number>, const D: usize, const L: usize, const TWICE: usize>(
    kernel: &K,
    positions: &[[f64; D]],
    forces: &mut [[f64; D]],
    chunks: Chunks,
) {
    let number = positions.len().min(L);
    let mut places = Vectors::<D, TWICE>::ZERO; // twice around
    chunks.put_into(positions, &mut places.0, 0, |q| q.map(Fused));
    chunks.put_into(positions, &mut places.0, number, |q| q.map(Fused));
    let (mut own, mut others) = (Vectors::<D, L>::ZERO, Vectors::<D, TWICE>::ZERO);
    let mut slopes = Pairs::<L>::ZERO;
    for first in (1..=number / 2).step_by(SHIFTS) {
        let shifts = first..(number / 2 + 1).min(first + SHIFTS);
        slopes.evaluate(
            &places,
            shifts.clone(),
            #[inline(always)] // else compiled without the instruction set where it is long
            |squares| kernel.slope_block(squares),
        );
        for (shift, slopes) in shifts.zip(&slopes.0) {
            let pairs = if 2 * shift == number { shift } else { number };
            push_of_shift(&places, shift, pairs, slopes, &mut own, &mut others);
        }
    }
    let mut sums = Vectors::<D, L>::ZERO;
    chunks.put_into(forces, &mut sums.0, 0, |force| force.map(Fused));
    for d in 0..D {
        let around = &others.0[d][number..][..L];
        for l in 0..L {
            let more = own.0[d][l] + (others.0[d][l] + around[l]);
            sums.0[d][l] = sums.0[d][l] + Fused(-2.0) * more;
        }
    }
    chunks.take_out(&sums.0, forces, |force| force.map(|f| f.0));
}

/// |qₗ − qₗ₊ₖ|².
#[inline(always)]
fn squares_of_shift<const D: usize, const L: usize, const TWICE: usize>(
    places: &Vectors<D, TWICE>,
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
fn push_of_shift<const D: usize, const L: usize, const TWICE: usize>(
    places: &Vectors<D, TWICE>,
    shift: usize,
    pairs: usize,
    slopes: &[Number; L],
    own: &mut Vectors<D, L>,
    others: &mut Vectors<D, TWICE>,
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
) -> [Number; D] {
    let mut slopes = squares(q, places);
    kernel.slope_block(&mut slopes);
    let mut sums = [[Fused(0.0); SUMS]; D];
    for first in (0..LANES).step_by(SUMS) {
        for l in 0..SUMS {
            let slope = slopes[first + l];
            for d in 0..D {
                let apart = q[d] - places.0[d][first + l];
                sums[d][l] = slope.multiply_add(apart, sums[d][l]);
                pushes.0[d][first + l] = (-slope).multiply_add(apart, pushes.0[d][first + l]);
            }
        }
    }
    sums.map(total_of_few)
}

/// |q − qₗ|².
#[inline(always)]
fn squares<const D: usize>(q: &[Number; D], places: &Vectors<D, LANES>) -> [Number; LANES] {
    let mut squares = [Fused(0.0); LANES];
    for l in 0..LANES {
        let apart: [Number; D] = from_fn(|d| q[d] - places.0[d][l]);
        squares[l] = dot(&apart, &apart);
    }
    squares
}

/// The sum.
#[inline(always)]
fn total(parts: &[Number; LANES]) -> Number {
    let mut sums = [Fused(0.0); SUMS];
    for l in 0..SUMS {
        sums[l] = (parts[l] + parts[2 * SUMS + l]) + (parts[SUMS + l] + parts[3 * SUMS + l]);
    }
    total_of_few(sums)
}

/// The sum.
#[inline(always)]
fn total_of_few(parts: [Number; SUMS]) -> Number {
    let mut sums = [Fused(0.0); SUMS / 2];
    for l in 0..SUMS / 2 {
        sums[l] = parts[l] + parts[SUMS / 2 + l];
    }
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
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
    fn every_instruction_set_gives_the_same_sums() {
        for n in [2, 9, 17, 33, 64, 65, 150] {
            let place = |i: usize, d: usize| (1.7 * (3 * i + d) as f64 + 0.1 * i as f64).sin();
            let q: Vec<[f64; 3]> = (0..n + PIECE).map(|i| from_fn(|d| place(i, d))).collect();
            let of = |set: InstructionSet| {
                let mut forces = vec![[0.0; 3]; n + PIECE];
                let (a, b) = q.split_at(PIECE);
                let (on_a, on_b) = forces.split_at_mut(PIECE);
                let others = Some((b, &mut *on_b));
                set.run(Piece { kernel: &Bell, q: a, forces: on_a, others, chunks: Chunks::of(LANES) });
                for (q, forces) in b.chunks(LANES).zip(on_b.chunks_mut(LANES)) {
                    set.run(Piece { kernel: &Bell, q, forces, others: None, chunks: Chunks::of(q.len()) });
                }
                let chunks = [Chunks::of(LANES), Chunks::of((n - 1) % LANES + 1)];
                let energy = set.run(Energies { kernel: &Bell, positions: b, chunks });
                forces.iter().flatten().chain([&energy]).map(|x| x.to_bits()).collect::<Vec<_>>()
            };
            // The portable one does multiply-add by a function.
            let portable = of(InstructionSet::Portable);
            for set in [InstructionSet::Avx2, InstructionSet::Avx512] {
                assert_eq!(of(set), portable, "{n} bodies, {set}");
            }
        }
    }
}
