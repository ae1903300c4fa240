//! Long vectors in pieces, which several threads work on at a time.
//!
//! Pieces are always the same, and sums of them are added in the same order, so that results have the same bits for any
//! number of threads. Threads are those of the [rayon](https://docs.rs/rayon) pool that a simulation is run in.

use rayon::prelude::*;

/// So many numbers are a piece, where nothing else is asked for.
pub(crate) const PIECE: usize = 8192;

/// Whether a vector of this length has several pieces, and threads are there that could take them.
pub(crate) fn on_threads(length: usize, piece: usize) -> bool {
    length > piece && rayon::current_thread_index().is_some()
}

/// Calls with the number of the first entry of each piece, and the piece.
pub(crate) fn each(piece: usize, x: &mut [f64], of_piece: impl Fn(usize, &mut [f64]) + Sync) {
    let of_piece = |(number, x): (usize, &mut [f64])| of_piece(piece * number, x);
    if on_threads(x.len(), piece) {
        x.par_chunks_mut(piece).enumerate().for_each(of_piece);
    } else {
        x.chunks_mut(piece).enumerate().for_each(of_piece);
    }
}

/// The same with pieces of two vectors of the same length.
pub(crate) fn each_of_two(
    piece: usize,
    x: &mut [f64],
    y: &mut [f64],
    of_piece: impl Fn(usize, &mut [f64], &mut [f64]) + Sync,
) {
    let of_piece = |(number, (x, y)): (usize, (&mut [f64], &mut [f64]))| of_piece(piece * number, x, y);
    if on_threads(x.len(), piece) {
        x.par_chunks_mut(piece).zip(y.par_chunks_mut(piece)).enumerate().for_each(of_piece);
    } else {
        x.chunks_mut(piece).zip(y.chunks_mut(piece)).enumerate().for_each(of_piece);
    }
}

/// The sums of what each piece of so long a vector gives, piece by piece the same.
pub(crate) fn sums<const N: usize>(
    length: usize,
    of_piece: impl Fn(std::ops::Range<usize>) -> [f64; N] + Sync,
) -> [f64; N] {
    fn halves<const N: usize>(
        pieces: std::ops::Range<usize>,
        threads: bool,
        of_piece: &(impl Fn(usize) -> [f64; N] + Sync),
    ) -> [f64; N] {
        if pieces.len() <= 1 {
            return of_piece(pieces.start);
        }
        let middle = pieces.start + pieces.len() / 2;
        let (first, second) = (pieces.start..middle, middle..pieces.end);
        let (a, b) = if threads {
            rayon::join(|| halves(first, threads, of_piece), || halves(second, threads, of_piece))
        } else {
            (halves(first, threads, of_piece), halves(second, threads, of_piece))
        };
        std::array::from_fn(|k| a[k] + b[k])
    }
    let of_piece = |piece: usize| of_piece(PIECE * piece..length.min(PIECE * (piece + 1)));
    halves(0..length.div_ceil(PIECE), on_threads(length, PIECE), &of_piece)
}

/// a·b.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let [dot] = sums(a.len(), |piece| [dot_of_piece(&a[piece.clone()], &b[piece])]);
    dot
}

pub(crate) fn dot_of_piece(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    let mut sums = [0.0; 8];
    a.zip(b).for_each(|(a, b)| (0..8).for_each(|k| sums[k] += a[k] * b[k]));
    sums.iter().sum::<f64>() + rest
}

/// x − part·y.
pub(crate) fn subtract(part: f64, y: &[f64], x: &mut [f64]) {
    each(PIECE, x, |from, x| x.iter_mut().zip(&y[from..]).for_each(|(x, y)| *x -= part * y));
}
