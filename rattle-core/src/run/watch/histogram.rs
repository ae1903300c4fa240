//! Histograms of a quantity along runs.

use crate::error::Error;
use crate::run::watch::observer::Observer;
use crate::run::watch::sight::Sight;

/// How often a quantity fell into each of a number of equal bins.
#[doc(alias = "distribution")]
#[doc(alias = "density")]
#[derive(Debug, Clone)]
pub struct Histogram<Q> {
    quantity: Q,
    from: f64,
    to: f64,
    /// Bins per unit.
    density: f64,
    counts: Vec<u64>,
    outside: u64,
}

/// Of a gibibyte.
const MOST_BINS: usize = 1 << 27;

impl<Q> Histogram<Q> {
    /// A histogram of this quantity, in `bins` equal bins between `from` and `to`. For an ensemble make one, and give
    /// each group of trajectories a clone while it is empty:
    ///
    /// ```
    /// # use rattle::{Scene, State, Rattle, watch::{Histogram, Sight}};
    /// # let starts = (0..100).map(|i| State::at([0.0]).moving([f64::from(i)]));
    /// # let mut ensemble = Scene::points::<1>(1).ensemble(starts, Rattle::new(0.5))?;
    /// let speeds = Histogram::of(|now: &Sight<'_, 1>| now.momentum().norm(), 0.0, 80.0, 4)?;
    /// let speeds = ensemble.observe(10, 1, || speeds.clone());
    /// assert_eq!((speeds.counts(), speeds.outside()), (&[200, 200, 200, 200][..], 200));
    /// # Ok::<(), rattle::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Bins`] for no bins, more than 2²⁷ or than there is memory for, and unless `from` and `to` are finite
    /// with `from` < `to`.
    #[allow(clippy::cast_precision_loss, reason = "a number of bins")]
    pub fn of<const D: usize>(quantity: Q, from: f64, to: f64, bins: usize) -> Result<Self, Error>
    where
        Q: Fn(&Sight<'_, D>) -> f64,
    {
        let density = bins as f64 / (to - from);
        if !(bins > 0 && from < to && from.is_finite() && to.is_finite() && density.is_normal()) {
            return Err(Error::Bins { from, to, bins });
        }
        if bins > MOST_BINS {
            return Err(Error::Bins { from, to, bins }); // a system may promise memory that it has not got
        }
        let mut counts = Vec::new();
        counts.try_reserve_exact(bins).map_err(|_| Error::Bins { from, to, bins })?;
        counts.resize(bins, 0);
        Ok(Self { quantity, from, to, density, counts, outside: 0 })
    }

    /// Counts by bin: bin i holds from + i w ≤ x < from + (i + 1) w, with w = (to − from)/bins, to rounding of x −
    /// from.
    pub fn counts(&self) -> &[u64] {
        &self.counts
    }

    /// How often the quantity was outside of all bins, or NaN.
    pub fn outside(&self) -> u64 {
        self.outside
    }
}

impl<Q: Fn(&Sight<'_, D>) -> f64, const D: usize> Observer<D> for Histogram<Q> {
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a bin, after it was seen to be one"
    )]
    #[inline(always)]
    fn see(&mut self, _: &Sight<'_, D>, now: &Sight<'_, D>) {
        let x = (self.quantity)(now);
        let last = self.counts.len() - 1;
        let count = if x >= self.from && x < self.to {
            &mut self.counts[(((x - self.from) * self.density) as usize).min(last)]
        } else {
            &mut self.outside
        };
        *count += 1;
    }

    fn join(&mut self, next: Self) {
        self.outside += next.outside;
        for (count, more) in self.counts.iter_mut().zip(next.counts) {
            *count += more;
        }
    }
}
