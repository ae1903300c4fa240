//! Vectors side by side: a coordinate of all, then the next, as loops over lanes read them.

use std::array::from_fn;

/// Lanes of a full block of trajectories or tile of bodies.
pub(crate) const LANES: usize = 64;

/// Coordinates beyond which as many vectors in lanes would no longer fit the nearest cache, or the stack.
pub(crate) const MOST_COORDINATES: usize = 16;

/// D coordinates in each of L lanes.
pub(crate) type Vectors<S, const L: usize, const D: usize> = [[S; L]; D];

/// The vector in a lane.
#[inline(always)]
pub(crate) fn at<S: Copy, const L: usize, const D: usize>(vectors: &Vectors<S, L, D>, lane: usize) -> [S; D] {
    // A loop: of many components `array::from_fn` may become a call, compiled for no instruction set.
    let mut all = [vectors[0][lane]; D];
    for d in 1..D {
        all[d] = vectors[d][lane];
    }
    all
}

/// Puts a vector into a lane.
#[inline(always)]
pub(crate) fn put<S: Copy, const L: usize, const D: usize>(
    vectors: &mut Vectors<S, L, D>,
    lane: usize,
    x: [S; D],
) {
    for d in 0..D {
        vectors[d][lane] = x[d];
    }
}

/// Vectors that are put into lanes at a time, and taken out of them.
pub(crate) const CHUNK: usize = 8;

/// So many vectors, [`CHUNK`] by [`CHUNK`], or one by one where there are fewer. The last chunk ends with the last
/// vector, so that some are in two chunks: where vectors are left over, to be copied one by one, registers that are
/// read just after wait for all their parts.
///
/// To be made before code for an instruction set is entered. A loop of a length that is known when compiling is
/// unrolled; of one that is not, compilers make whole registers and permutations.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chunks {
    length: usize,
    number: usize,
    last: usize,
}

impl Chunks {
    pub(crate) fn of(number: usize) -> Self {
        let (length, chunks) = if number < CHUNK { (1, number) } else { (CHUNK, number.div_ceil(CHUNK)) };
        Self { length, number: chunks, last: number.saturating_sub(length) }
    }

    /// Where chunks begin, each of [`length`](Self::length).
    #[inline(always)]
    pub(crate) fn begins(self) -> impl Iterator<Item = usize> {
        let Self { length, number, last } = self;
        (0..number).map(move |chunk| (length * chunk).min(last))
    }

    /// The vectors in each chunk.
    #[inline(always)]
    pub(crate) fn length(self) -> usize {
        self.length
    }

    /// Puts numbers of each into lanes, the first into lane `offset`.
    #[inline(always)]
    pub(crate) fn put_into<S: Copy, X, const L: usize, const C: usize>(
        self,
        each: &[X],
        lanes: &mut Vectors<S, L, C>,
        offset: usize,
        numbers: impl Fn(&X) -> [S; C],
    ) {
        for begin in self.begins() {
            let each = &each[begin..][..self.length];
            let rows = lanes.each_mut().map(|row| &mut row[offset + begin..][..self.length]);
            for l in 0..self.length {
                let numbers = numbers(&each[l]);
                for c in 0..C {
                    rows[c][l] = numbers[c];
                }
            }
        }
    }

    /// Makes each of what is in its lane.
    #[inline(always)]
    pub(crate) fn take_out<S: Copy, X, const L: usize, const C: usize>(
        self,
        lanes: &Vectors<S, L, C>,
        each: &mut [X],
        made: impl Fn([S; C]) -> X,
    ) {
        for begin in self.begins() {
            let each = &mut each[begin..][..self.length];
            let rows = lanes.each_ref().map(|row| &row[begin..][..self.length]);
            for l in 0..self.length {
                each[l] = made(from_fn(|c| rows[c][l]));
            }
        }
    }
}
