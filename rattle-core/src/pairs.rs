//! Forces between all pairs of bodies, several pairs at a time.
//!
//! Bodies j are taken in tiles, coordinate by coordinate; every body i beyond a tile, and each in it, meets those of the tile before
//! it in one loop that a compiler vectorises. Each pair is evaluated once: the force on j is the opposite of that on i.
//!
//! Sums are taken in an order that depends on the number of bodies alone, of products that are not rounded, so that every
//! instruction set that fuses gives the same forces.

use crate::ensemble::{InstructionSet, Work};
use crate::kernel::PairKernel;
use crate::lanes::Fused;
use crate::real::Real;
use crate::vector::dot;
use std::array::from_fn;

/// Bodies of a tile.
const TILE: usize = 64;

/// Bodies that meet a tile together: the way through one takes longer than the work.
const AT_ONCE: usize = 2;

/// From so many bodies on it pays.
pub(crate) const MANY: usize = 8;

type Number = Fused<f64>;
/// D coordinates of a tile's bodies; whole cache lines, so that no register is stored across two of them.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Tile<const D: usize>([[Number; TILE]; D]);

/// Adds the forces between all pairs, if there is an instruction set for it; says whether there was.
#[inline]
pub(crate) fn add_forces<K: PairKernel<Number>, const D: usize>(
    kernel: &K,
    positions: &[[f64; D]],
    forces: &mut [[f64; D]],
) -> bool {
    let set = InstructionSet::widest();
    if set.fuses() {
        set.run(AllPairs { kernel, positions, forces });
    }
    set.fuses()
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
        let zero = Tile([[Fused(0.0); TILE]; D]);
        let mut parts = [zero; AT_ONCE];
        for first in (0..positions.len()).step_by(TILE) {
            let (mut places, mut pushes) = (zero, zero);
            for (l, q) in positions[first..].iter().take(TILE).enumerate() {
                for d in 0..D {
                    places.0[d][l] = Fused(q[d]);
                }
            }
            let beyond = positions.len().min(first + TILE);
            for i in first + 1..beyond {
                let (q, number) = ([positions[i].map(Fused)], i - first);
                let [on_i] = match number {
                    0..=8 => meet::<K, D, 8, 1>(&kernel, number, &q, &places, &mut pushes, &mut parts),
                    9..=16 => meet::<K, D, 16, 1>(&kernel, number, &q, &places, &mut pushes, &mut parts),
                    17..=32 => meet::<K, D, 32, 1>(&kernel, number, &q, &places, &mut pushes, &mut parts),
                    _ => meet::<K, D, TILE, 1>(&kernel, number, &q, &places, &mut pushes, &mut parts),
                };
                add(&mut forces[i], on_i);
            }
            let (together, rest) = positions[beyond..].as_chunks::<AT_ONCE>();
            let (on_them, on_rest) = forces[beyond..].as_chunks_mut::<AT_ONCE>();
            for (q, forces) in together.iter().zip(on_them) {
                let q = q.map(|q| q.map(Fused));
                let on = meet::<K, D, TILE, AT_ONCE>(&kernel, TILE, &q, &places, &mut pushes, &mut parts);
                for r in 0..AT_ONCE {
                    add(&mut forces[r], on[r]);
                }
            }
            for (q, force) in rest.iter().zip(on_rest) {
                let q = [q.map(Fused)];
                let [on_i] = meet::<K, D, TILE, 1>(&kernel, TILE, &q, &places, &mut pushes, &mut parts);
                add(force, on_i);
            }
            for (l, force) in forces[first..].iter_mut().take(TILE).enumerate() {
                for d in 0..D {
                    force[d] += pushes.0[d][l].0;
                }
            }
        }
    }
}

#[inline(always)]
fn add<const D: usize>(force: &mut [f64; D], more: [Number; D]) {
    for d in 0..D {
        force[d] += more[d].0;
    }
}

/// Adds to `pushes` the forces of R bodies, at q, on so many bodies of a tile, and gives those on the R bodies. The lanes gone
/// through, beyond those bodies with no force, are a power of two.
#[inline(always)]
fn meet<K: PairKernel<Number>, const D: usize, const LANES: usize, const R: usize>(
    kernel: &K,
    number: usize,
    q: &[[Number; D]; R],
    places: &Tile<D>,
    pushes: &mut Tile<D>,
    parts: &mut [Tile<D>; AT_ONCE],
) -> [[Number; D]; R] {
    for l in 0..LANES {
        for r in 0..R {
            let apart: [Number; D] = from_fn(|d| q[r][d] - places.0[d][l]);
            let pull = Fused(-2.0) * kernel.slope(dot(&apart, &apart)); // −U′(r)/r
            let pull = Real::select(l < number, pull, Fused(0.0));
            for d in 0..D {
                parts[r].0[d][l] = pull * apart[d];
                pushes.0[d][l] = (-pull).multiply_add(apart[d], pushes.0[d][l]);
            }
        }
    }
    from_fn(|r| {
        from_fn(|d| {
            let parts = &mut parts[r].0[d];
            if LANES > 32 {
                fold::<32>(parts);
            }
            if LANES > 16 {
                fold::<16>(parts);
            }
            if LANES > 8 {
                fold::<8>(parts);
            }
            let [a, b, c, d, e, f, g, h, ..] = *parts;
            ((a + e) + (c + g)) + ((b + f) + (d + h))
        })
    })
}

/// Adds the second so many to the first.
#[inline(always)]
fn fold<const HALF: usize>(parts: &mut [Number; TILE]) {
    for l in 0..HALF {
        parts[l] = parts[l] + parts[l + HALF];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
