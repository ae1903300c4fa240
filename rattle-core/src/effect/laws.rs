//! Which law is between two bodies: the same for all, or one by their kinds.

use crate::kernel::functions::PairKernel;
use crate::number::real::Real;
use crate::number::vectors::LANES;
use std::marker::PhantomData;
use std::sync::Arc;

/// The laws between bodies, over a scalar.
pub trait Laws<T: Real>: Clone + Send + Sync + 'static {
    /// One of them.
    type Law: PairKernel<T>;
    /// The law between two bodies.
    fn between(&self, i: usize, j: usize) -> &Self::Law;
    /// dU/ds in place of each s; pair k is of the bodies `pairs[k]`. What is beyond the last pair is anything.
    fn slopes(&self, pairs: &[[u32; 2]], s: &mut [[T; LANES]]);
}

/// The same law for all.
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

/// A law for every two kinds.
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
