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
//! from where the rule has it, Fₖ in the gap k of length gₖ. The sum of these over the differences of neighbouring
//! rates, less a straight line, is how unsure the mean is. The ends of the step, almost, are looked at too.
//!
//! **One jump** J is off by no more: Σ Fⱼ |δⱼₖ − gⱼ| J = (Fₖ + Σ Fⱼ gⱼ − 2 Fₖ gₖ) J ≥ Fₖ J, as
//! Σ Fⱼ gⱼ = 0.197 ≥ 2 Fₖ gₖ. **Of several jumps it is an estimate**: a staircase along a straight line is taken for
//! the line. What begins and ends between two instants is not seen.

use crate::error::FlowError;
use crate::flow::Flow;

/// Beside the ends of a step, so that jumps at them are not in it: this part of the step …
const EDGE: f64 = 1.0 / (1_u64 << 30) as f64;
/// … and so many roundings of the time, as jumps that are meant to be at an end are rounded.
const ROUNDINGS: f64 = 8.0;
/// ½ − √(3/20).
const EARLY: f64 = 0.112_701_665_379_258_31;
const WEIGHTS: [f64; 5] = [0.0, 5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0, 0.0];
/// A jump between two instants is so far from where the rule has it, at most, in parts of the step.
const FARTHEST: [f64; 4] = [EARLY, 0.5 - 5.0 / 18.0, 0.5 - 5.0 / 18.0, EARLY];

/// In parts of the step from this time on.
fn instants(time: f64, step: f64) -> [f64; WEIGHTS.len()] {
    let rounding = ROUNDINGS * f64::EPSILON * time.abs().max((time + step).abs()) / step;
    let edge = rounding.clamp(EDGE, 0.5 * EARLY);
    [edge, EARLY, 0.5, 1.0 - EARLY, 1.0 - edge]
}

/// Rain and inflow of a step.
pub(crate) struct Sources {
    /// Means over the step at each vertex, volume per time.
    pub(crate) rain: Vec<f64>,
    pub(crate) inflow: Vec<f64>,
    /// How much volume per time the means may be off; 0 where it is not asked for.
    pub(crate) unsure: f64,
    now: [Vec<f64>; 2],
    /// At each vertex, both together at the instants.
    rates: Vec<[f64; WEIGHTS.len()]>,
}

impl Sources {
    pub(crate) fn of(vertices: usize) -> Self {
        let none = || vec![0.0; vertices];
        let (now, rates) = ([none(), none()], vec![[0.0; WEIGHTS.len()]; vertices]);
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
        let instants = instants(time, step);
        for (k, (instant, weight)) in instants.into_iter().zip(WEIGHTS).enumerate() {
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
            self.unsure = self.rates.iter().map(|rates| bent(&instants, rates)).sum();
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

/// How unsure the mean of these rates is: they may jump where they differ from a straight line.
fn bent(instants: &[f64; WEIGHTS.len()], rates: &[f64; WEIGHTS.len()]) -> f64 {
    let slope = (rates[4] - rates[0]) / (instants[4] - instants[0]);
    let jump = |k: usize| rates[k + 1] - rates[k] - slope * (instants[k + 1] - instants[k]);
    (0..FARTHEST.len()).map(|k| FARTHEST[k] * jump(k).abs()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of one jump, anywhere, the mean by Gauss's rule is off by no more than is said, which is not much too much: at
    /// most 0.31 of the jump, where the rule may be off by 0.22.
    #[test]
    fn one_jump_is_off_by_no_more_than_is_said() {
        let (instants, mut near, mut places) = (instants(0.0, 1.0), 0.0_f64, 0);
        for place in (1..40_000).map(|i| f64::from(i) / 40_000.0).chain([1e-8, 1.0 - 1e-8]) {
            for (from, to) in [(0.0, 1.0), (1.0, 0.0), (3.0, 5.0)] {
                let rates = instants.map(|instant| if instant < place { from } else { to });
                let mean: f64 = WEIGHTS.iter().zip(rates).map(|(weight, rate)| weight * rate).sum();
                let (off, jump) = ((mean - from * place - to * (1.0 - place)).abs(), f64::abs(to - from));
                let said = bent(&instants, &rates);
                assert!(off <= said + 1e-15 && said < 0.31 * jump, "{place}: {off} {said}");
                near = near.max(off / said);
                places += 1;
            }
        }
        assert!(places > 100_000 && near > 0.8, "{near}");
    }

    /// Of several jumps it is an estimate: a staircase along a straight line is taken for the line.
    #[test]
    fn a_staircase_may_be_taken_for_a_line() {
        // Up to each instant, just before, where the line is there.
        let line = instants(0.0, 1.0);
        let stairs = |t: f64| line.into_iter().rfind(|&stair| stair <= t + 1e-9).unwrap_or(line[0]);
        assert!(bent(&line, &line.map(stairs)) < 1e-15);
        let mean = line.windows(2).map(|pair| pair[0] * (pair[1] - pair[0])).sum::<f64>();
        let by_rule: f64 = line.map(stairs).iter().zip(WEIGHTS).map(|(rate, weight)| weight * rate).sum();
        assert!((by_rule - mean).abs() > 0.1, "{by_rule} {mean}");
    }
}
