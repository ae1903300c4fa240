//! Power series of the macros' functions along a curve q(t) = Σ qₖ tᵏ, one coefficient at a time.
//!
//! ```text
//! (a b)ₖ = a₀ bₖ + aₖ b₀ + Σ aⱼ bₖ₋ⱼ,   0 < j < k
//! ```
//!
//! Every nonlinear operation reduces to such a product of two series, one of which may be the result itself
//! ([`Recurrences`]). The sum needs only lower coefficients. So the [`Products`] of all functions of a system are
//! stored together, in blocks of eight: first all sums are formed, in full SIMD registers; then each function goes
//! through its operations once, with two multiplications for each product.
//!
//! N coefficients of one operation cost N²/2 multiplications. Computing with whole series as scalars would cost N³/3 in
//! a differential equation, since each new coefficient would compute all N again.
//!
//! Source: E. Hairer, S. P. Nørsett, G. Wanner, *Solving Ordinary Differential Equations I*, I.8.

use crate::kernel::block::{Block, WIDTH};
use crate::kernel::recurrences::Recurrences;
use crate::number::instructions::{InstructionSet, Work};
use crate::number::real::Real;

/// What messages call functions without series.
pub(crate) const NO_SERIES: &str = "functions without power series (potentials that depend on time, more than 2000 \
     operations, or not written by a macro; pair potentials with a cut-off, by kinds or along a surface)";

/// How many blocks so many products take.
pub(crate) const fn blocks(products: usize) -> usize {
    products.div_ceil(WIDTH)
}

/// The factors of all products of a system, with all known coefficients.
///
/// ```
/// use rattle::series::Products;
///
/// // 1/(1 − t)² from 1/(1 − t) = 1 + t + t² + …
/// let mut products = Products::new(1, 4);
/// let mut found = vec![products.first().take(1).square(0, 1.0)];
/// found.extend((1..4).map(|k| products.next(k).take(1).square(0, 1.0)));
/// assert_eq!(found, [1.0, 2.0, 3.0, 4.0]);
/// ```
#[derive(Debug, Clone)]
pub struct Products<T> {
    /// Blocks of one coefficient.
    blocks: usize,
    /// Coefficient by coefficient.
    left: Vec<Block<T>>,
    right: Vec<Block<T>>,
    /// Σ aⱼ bₖ₋ⱼ over 0 < j < k, of the order under way.
    sums: Vec<Block<T>>,
}

impl<T: Real> Products<T> {
    /// Memory for `blocks` blocks of [`WIDTH`] products, with `orders` coefficients each.
    #[must_use]
    pub fn new(blocks: usize, orders: usize) -> Self {
        let zeros = |n| vec![Block([T::from_f64(0.0); WIDTH]); n];
        Self { blocks, left: zeros(blocks * orders), right: zeros(blocks * orders), sums: zeros(blocks) }
    }

    /// Begins with the coefficients 0: values.
    #[inline(always)]
    pub fn first(&mut self) -> Order<'_, T, true> {
        let n = self.blocks;
        let (left, right) = (&mut self.left[..n], &mut self.right[..n]);
        let unknown = &self.sums[..n];
        Order { k: 0, first: [unknown; 2], sums: unknown, now: [left, right] }
    }

    /// Continues with the coefficients k ≥ 1; lower ones are known.
    #[inline(always)]
    pub fn next(&mut self, k: usize) -> Order<'_, T, false> {
        InstructionSet::Avx2.run(self.sums_of(k));
        self.order(k)
    }

    /// The same within [work](Work): with the instructions that it is compiled for.
    #[inline(always)]
    pub(crate) fn next_within(&mut self, k: usize) -> Order<'_, T, false> {
        self.sums_of(k).run();
        self.order(k)
    }

    #[inline(always)]
    fn sums_of(&mut self, k: usize) -> Sums<'_, T> {
        let known = ..k * self.blocks;
        Sums { left: &self.left[known], right: &self.right[known], sums: &mut self.sums }
    }

    #[inline(always)]
    fn order(&mut self, k: usize) -> Order<'_, T, false> {
        let n = self.blocks;
        let (known_left, left) = self.left.split_at_mut(k * n);
        let (known_right, right) = self.right.split_at_mut(k * n);
        let first = [&known_left[..n], &known_right[..n]];
        Order { k, first, sums: &self.sums, now: [&mut left[..n], &mut right[..n]] }
    }
}

/// Forms the sums of a new order, the same bits with any instructions.
struct Sums<'a, T> {
    left: &'a [Block<T>],
    right: &'a [Block<T>],
    sums: &'a mut [Block<T>],
}

impl<T: Real> Work for Sums<'_, T> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let n = self.sums.len();
        for b in 0..n {
            let mut total = [T::from_f64(0.0); WIDTH];
            let (mut i, mut j) = (n + b, self.right.len() - n + b);
            while i < self.left.len() {
                let (a, b) = (&self.left[i].0, &self.right[j].0);
                for lane in 0..WIDTH {
                    total[lane] = a[lane].multiply_add(b[lane], total[lane]);
                }
                (i, j) = (i + n, j - n);
            }
            self.sums[b] = Block(total);
        }
    }
}

/// The binary logarithm of the longest unit of time, and less that of the shortest: their squares are numbers also in
/// single precision.
const LONGEST_UNIT: f64 = 50.0;

/// The unit in which the series of steps of about `h` count time: a power of two, so that no bit depends on it, near h,
/// so that high coefficients neither overflow nor vanish.
pub(crate) fn unit_near(h: f64) -> f64 {
    h.abs().log2().round().clamp(-LONGEST_UNIT, LONGEST_UNIT).exp2()
}

/// The coefficients k of the products that no function has taken yet. Functions take theirs one after the other, in the
/// same order for each k. `FIRST` where k = 0.
#[derive(Debug)]
pub struct Order<'a, T, const FIRST: bool> {
    k: usize,
    /// The coefficients 0 of both factors; nothing where these are the first.
    first: [&'a [Block<T>]; 2],
    sums: &'a [Block<T>],
    now: [&'a mut [Block<T>]; 2],
}

impl<'a, T: Real, const FIRST: bool> Order<'a, T, FIRST> {
    /// Takes the next `blocks` blocks.
    #[inline(always)]
    pub fn take(&mut self, blocks: usize) -> Recurrences<'a, T, FIRST> {
        let [left, right] = &mut self.now;
        let (left, right) = (first_mut(left, blocks), first_mut(right, blocks));
        let [first_left, first_right] = &mut self.first;
        let first = [first_of(first_left, blocks), first_of(first_right, blocks)];
        Recurrences::new(self.k, first, first_of(&mut self.sums, blocks), [left, right])
    }
}

/// Either, where a type cannot depend on which.
pub(crate) enum AnyOrder<'o, 'a, T> {
    First(&'o mut Order<'a, T, true>),
    Next(&'o mut Order<'a, T, false>),
}

/// Takes the first `n` off.
#[inline(always)]
fn first_of<'a, B>(all: &mut &'a [B], n: usize) -> &'a [B] {
    let (first, rest) = all.split_at(n);
    *all = rest;
    first
}

#[inline(always)]
fn first_mut<'a, B>(all: &mut &'a mut [B], n: usize) -> &'a mut [B] {
    let (first, rest) = std::mem::take(all).split_at_mut(n);
    *all = rest;
    first
}
