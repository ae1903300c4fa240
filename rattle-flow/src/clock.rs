//! The time of a simulation: the sum of its steps, rounded once.

/// A time, and what is lost by rounding it.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Clock {
    time: f64,
    rest: f64,
}

impl Clock {
    pub(crate) fn at(time: f64) -> Self {
        Clock { time, rest: 0.0 }
    }

    pub(crate) fn time(&self) -> f64 {
        self.time
    }

    /// Knuth's sum, whose rounding error is exact: n steps of length h lead to n·h, rounded once.
    pub(crate) fn advance(&mut self, step: f64) {
        let (sum, lost) = both(self.time, step);
        (self.time, self.rest) = both(sum, lost + self.rest);
    }
}

/// a + b, and by how much that is rounded.
fn both(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}
