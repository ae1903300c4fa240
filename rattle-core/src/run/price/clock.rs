//! The clock for measurements.

use std::fmt;
use std::sync::Arc;
use std::time::Instant;

/// A source of seconds since some instant: the machine's clock, or a function, such as a count of evaluations.
#[derive(Clone)]
pub struct Clock(Arc<dyn Fn() -> f64 + Send + Sync>);

impl Clock {
    /// A clock by this function, whose values must not decrease.
    ///
    /// ```
    /// # use rattle::{Counted, price::Clock, surfaces::Sphere};
    /// let surface = Counted::new(Sphere { r: 1.0 });
    /// let counts = surface.counts();
    /// let microsecond_an_evaluation = Clock::of(move || 1e-6 * counts.all() as f64);
    /// assert_eq!(microsecond_an_evaluation.now(), 0.0);
    /// ```
    pub fn of(seconds: impl Fn() -> f64 + Send + Sync + 'static) -> Self {
        Self(Arc::new(seconds))
    }

    /// Seconds since some instant.
    #[must_use]
    pub fn now(&self) -> f64 {
        (self.0)()
    }
}

impl Default for Clock {
    fn default() -> Self {
        let begun = Instant::now();
        Self::of(move || begun.elapsed().as_secs_f64())
    }
}

impl fmt::Debug for Clock {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Clock").field(&self.now()).finish()
    }
}
