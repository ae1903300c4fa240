//! Forces between near pairs, several at a time.
//!
//! Pairs within reach are gathered from the rows of a list, in order, until a batch is full. Then the slopes of the
//! potential are computed for the batch, and forces are added pair by pair in the same order. So the force on a body is
//! the sum over partners in the order of their numbers, with fused multiply-adds: that of a loop over all pairs.

use crate::effect::laws::Laws;
use crate::effect::neighbours::Neighbours;
use crate::kernel::functions::PairKernel;
use crate::kernel::space::Space;
use crate::number::instructions::Work;
use crate::number::real::{Mask, Real};
use crate::number::vector::{add_scaled, dot};
use crate::number::vectors::LANES;
use std::array::from_fn;
use std::marker::PhantomData;

/// Pairs that go together.
const PAIRS: usize = 8 * LANES;

/// Adds the forces between listed pairs within reach, in the numbers `T`.
pub(crate) struct Push<'a, T, L, B, const D: usize> {
    pub(crate) laws: &'a L,
    pub(crate) space: B,
    pub(crate) reach_square: f64,
    pub(crate) list: &'a Neighbours<D>,
    pub(crate) positions: &'a [[f64; D]],
    pub(crate) forces: &'a mut [[f64; D]],
    pub(crate) number: PhantomData<T>,
}

/// Pairs within reach, and |qᵢ − qⱼ|² of each, which slopes take the place of.
struct Batch<T> {
    pairs: [[u32; 2]; PAIRS],
    squares: [[T; LANES]; PAIRS / LANES],
    size: usize,
}

impl<T: Real, L: Laws<T>, B: Space<D>, const D: usize> Work for Push<'_, T, L, B, D> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { laws, space, list, positions, forces, .. } = self;
        let laws = laws.clone(); // out of reach of what the loops write
        let mut batch =
            Batch { pairs: [[0; 2]; PAIRS], squares: [[T::from_f64(1.0); LANES]; PAIRS / LANES], size: 0 };
        for i in 1..positions.len() {
            let mut row = list.row(i);
            while !row.is_empty() {
                if PAIRS - batch.size < row.len().min(LANES) {
                    push(&laws, &space, &mut batch, positions, forces);
                }
                let (now, later) = row.split_at(row.len().min(PAIRS - batch.size));
                batch.gather(&space, self.reach_square, i, now, positions);
                row = later;
            }
        }
        push(&laws, &space, &mut batch, positions, forces);
    }
}

impl<T: Real> Batch<T> {
    /// Takes in those of these pairs that are within reach, or whose distance is no number.
    #[inline(always)]
    fn gather<B: Space<D>, const D: usize>(
        &mut self,
        space: &B,
        reach_square: f64,
        i: usize,
        row: &[u32],
        positions: &[[f64; D]],
    ) {
        let (q, reach_square) = (positions[i].map(T::from_f64), T::from_f64(reach_square));
        let squares = self.squares.as_flattened_mut();
        for &j in row {
            let apart = space.apart(&q, &positions[j as usize].map(T::from_f64));
            let square = dot(&apart, &apart);
            let place = self.size % PAIRS;
            (self.pairs[place], squares[place]) = ([i as u32, j], square);
            self.size += usize::from(!reach_square.le(square).all());
        }
    }
}

/// Adds the forces of gathered pairs.
#[inline(always)]
fn push<T: Real, L: Laws<T>, B: Space<D>, const D: usize>(
    laws: &L,
    space: &B,
    batch: &mut Batch<T>,
    positions: &[[f64; D]],
    forces: &mut [[f64; D]],
) {
    let pairs = &batch.pairs[..batch.size];
    laws.slopes(pairs, &mut batch.squares);
    let slopes = batch.squares.as_flattened();
    let number = |x: [f64; D]| x.map(T::from_f64);
    let mut rest = pairs.iter().zip(slopes).peekable();
    while let Some(&(&[i, _], _)) = rest.peek() {
        let q = number(positions[i as usize]);
        let mut on_i = number(forces[i as usize]);
        while let Some((&[_, j], &slope)) = rest.next_if(|&(&[of, _], _)| of == i) {
            let apart = space.apart(&q, &number(positions[j as usize]));
            let pull = T::from_f64(-2.0) * slope; // −U′(r)/r
            on_i = add_scaled(&on_i, pull, &apart);
            let on_j = &mut forces[j as usize];
            *on_j = double(add_scaled(&number(*on_j), -pull, &apart));
        }
        forces[i as usize] = double(on_i);
    }
    batch.size = 0;
}

/// A vector of numbers that are one double each.
#[inline(always)]
fn double<T: Real, const D: usize>(x: [T; D]) -> [f64; D] {
    x.map(|x| x.lanes().next().unwrap_or(f64::NAN))
}

/// U of listed pairs.
pub(crate) fn energy<T: Real, L: Laws<T>, B: Space<D>, const D: usize>(
    laws: &L,
    space: &B,
    list: &Neighbours<D>,
    positions: &[[T; D]],
) -> T {
    let row = |i: usize| {
        let of = |&j: &u32| {
            let apart = space.apart(&positions[i], &positions[j as usize]);
            laws.between(i, j as usize).value(dot(&apart, &apart))
        };
        list.row(i).iter().map(of).fold(T::from_f64(0.0), |sum, energy| sum + energy)
    };
    (1..positions.len()).map(row).fold(T::from_f64(-0.0), |sum, energy| sum + energy)
}

/// Adds the forces between all pairs, in any numbers.
pub(crate) fn push_all<T: Real, L: Laws<T>, B: Space<D>, const D: usize>(
    laws: &L,
    space: &B,
    positions: &[[T; D]],
    forces: &mut [[T; D]],
) {
    for i in 1..positions.len() {
        for j in 0..i {
            let apart = space.apart(&positions[i], &positions[j]);
            let pull = T::from_f64(-2.0) * laws.between(i, j).slope(dot(&apart, &apart)); // −U′(r)/r
            forces[i] = add_scaled(&forces[i], pull, &apart);
            forces[j] = from_fn(|d| (-pull).multiply_add(apart[d], forces[j][d]));
        }
    }
}

/// U of all pairs.
pub(crate) fn energy_of_all<T: Real, L: Laws<T>, B: Space<D>, const D: usize>(
    laws: &L,
    space: &B,
    positions: &[[T; D]],
) -> T {
    let of = |i: usize, j: usize| {
        let apart = space.apart(&positions[i], &positions[j]);
        laws.between(i, j).value(dot(&apart, &apart))
    };
    let row = |i| (0..i).map(|j| of(i, j)).fold(T::from_f64(0.0), |sum, energy| sum + energy);
    (1..positions.len()).map(row).fold(T::from_f64(-0.0), |sum, energy| sum + energy)
}
