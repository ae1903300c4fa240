//! What falls and what enters in a step.
//!
//! ```text
//! S = Δt Σ wₖ s(t + cₖ Δt),    c = ½ − √(3/20), ½, ½ + √(3/20),    w = 5/18, 8/18, 5/18
//! ```
//!
//! Gauss's rule is exact for polynomials in time up to degree 5. Its instants lie inside of the step: a rate that jumps
//! at an end of the step counts in the right step, be it by `t < end` or `t <= end`.
//!
//! Where a rate jumps between two instants, the rule may be off by the jump times the farthest that the jump can be
//! from where the rule has it. The sum of these over the differences of neighbouring rates, less a straight line,
//! bounds what the rule is off by; the ends of the step, almost, are looked at too. What begins and ends between two
//! instants is not seen.

use crate::error::FlowError;
use crate::flow::Flow;

/// Beside the ends of a step, so that jumps at them are not in it.
const EDGE: f64 = 1.0 / 1024.0;
/// ½ − √(3/20).
const EARLY: f64 = 0.112_701_665_379_258_31;
/// Instants, in parts of a step, with their weights.
const INSTANTS: [(f64, f64); 5] =
    [(EDGE, 0.0), (EARLY, 5.0 / 18.0), (0.5, 8.0 / 18.0), (1.0 - EARLY, 5.0 / 18.0), (1.0 - EDGE, 0.0)];
/// A jump between two instants is so far from where the rule has it, at most, in parts of the step.
const FARTHEST: [f64; 4] = [EARLY, 0.5 - 5.0 / 18.0, 0.5 - 5.0 / 18.0, EARLY];

/// Rain and inflow of a step.
pub(crate) struct Sources {
    /// Means over the step at each vertex, volume per time.
    pub(crate) rain: Vec<f64>,
    pub(crate) inflow: Vec<f64>,
    /// At most so much volume per time the means are off, as far as it is seen; 0 where it is not asked for.
    pub(crate) unsure: f64,
    now: [Vec<f64>; 2],
    /// At each vertex, both together at the instants.
    rates: Vec<[f64; INSTANTS.len()]>,
}

impl Sources {
    pub(crate) fn of(vertices: usize) -> Self {
        let none = || vec![0.0; vertices];
        let (now, rates) = ([none(), none()], vec![[0.0; INSTANTS.len()]; vertices]);
        Sources { rain: none(), inflow: none(), unsure: 0.0, now, rates }
    }

    /// Those of the step from this time on; how unsure they are where that is asked for.
    pub(crate) fn take(&mut self, flow: &Flow, time: f64, step: f64, unsure: bool) -> Result<(), FlowError> {
        self.unsure = 0.0;
        if !flow.has_sources() {
            return Ok(());
        }
        self.rain.fill(0.0);
        self.inflow.fill(0.0);
        for (k, (instant, weight)) in INSTANTS.into_iter().enumerate() {
            if weight > 0.0 || unsure {
                let [rain, inflow] = &mut self.now;
                flow.sources(time + instant * step, rain, inflow)?;
                for i in 0..rain.len() {
                    self.rain[i] += weight * rain[i];
                    self.inflow[i] += weight * inflow[i];
                    self.rates[i][k] = rain[i] + inflow[i];
                }
            }
        }
        if unsure {
            self.unsure = self.rates.iter().map(bent).sum();
        }
        Ok(())
    }

    /// Volume per time at a vertex.
    pub(crate) fn at(&self, vertex: usize) -> f64 {
        self.rain[vertex] + self.inflow[vertex]
    }

    /// Volume per time altogether.
    pub(crate) fn sum(&self) -> f64 {
        self.rain.iter().sum::<f64>() + self.inflow.iter().sum::<f64>()
    }
}

/// By how much the mean of these rates is off at most, if they jump where they differ from a straight line.
fn bent(rates: &[f64; INSTANTS.len()]) -> f64 {
    let slope = (rates[4] - rates[0]) / (INSTANTS[4].0 - INSTANTS[0].0);
    let jump = |k: usize| rates[k + 1] - rates[k] - slope * (INSTANTS[k + 1].0 - INSTANTS[k].0);
    (0..FARTHEST.len()).map(|k| FARTHEST[k] * jump(k).abs()).sum()
}
