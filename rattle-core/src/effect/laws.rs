//! The pair potential between two bodies: the same for all, or one by their kinds.

use crate::kernel::functions::PairKernel;
use crate::number::real::Real;
use crate::number::vectors::LANES;
use std::marker::PhantomData;
use std::sync::Arc;

/// The pair potentials between bodies, over a scalar.
pub trait Laws<T: Real>: Clone + Send + Sync + 'static {
    /// The type of a potential.
    type Law: PairKernel<T>;
    /// The potential between two bodies.
    fn between(&self, i: usize, j: usize) -> &Self::Law;
    /// Replaces each s by dU/ds; pair k has the bodies `pairs[k]`. Entries beyond the last pair are undefined.
    fn slopes(&self, pairs: &[[u32; 2]], s: &mut [[T; LANES]]);
}

/// The same potential for all pairs.
#[derive(Debug, Clone)]
pub struct Alike<X>(pub(crate) X);

impl<T: Real, X: PairKernel<T>> Laws<T> for Alike<X> {
    type Law = X;

    #[inline(always)]
    fn between(&self, _: usize, _: usize) -> &X {
        &self.0
    }
    #[inline(always)]
    fn slopes(&self, pairs: &[[u32; 2]], s: &mut [[T; LANES]]) {
        for s in &mut s[..pairs.len().div_ceil(LANES)] {
            self.0.slope_block(s);
        }
    }
}

/// A potential for every two kinds.
#[derive(Debug, Clone)]
pub struct ByKind<T, X> {
    of: Arc<[u32]>,
    kinds: usize,
    /// Of all ordered pairs of kinds, row by row.
    laws: Arc<[X]>,
    number: PhantomData<T>,
}

impl<T, X> ByKind<T, X> {
    pub(crate) fn new(of: &[usize], laws: Vec<X>) -> Self {
        let kinds = laws.len().isqrt();
        Self {
            of: of.iter().map(|&kind| kind as u32).collect(),
            kinds,
            laws: laws.into(),
            number: PhantomData,
        }
    }
}

impl<T: Real, X: PairKernel<T>> Laws<T> for ByKind<T, X> {
    type Law = X;

    #[inline(always)]
    fn between(&self, i: usize, j: usize) -> &X {
        &self.laws[self.of[i] as usize * self.kinds + self.of[j] as usize]
    }
    #[inline(always)]
    fn slopes(&self, pairs: &[[u32; 2]], s: &mut [[T; LANES]]) {
        for (s, &[i, j]) in s.as_flattened_mut().iter_mut().zip(pairs) {
            *s = self.between(i as usize, j as usize).slope(*s);
        }
    }
}
