//! For how long positions are predictable, from two close runs.
//!
//! ```text
//! d(t) ~ d(0) exp(λt)   chaos: λ from the second half of the time in which d grows to a hundredth of the way
//! d(t) ~ d(0) tⁿ        else
//! ```
//!
//! Both runs use RATTLE with a moderate step: their separation grows like that of neighbouring exact motions.
//!
//! Source: G. Benettin, L. Galgani, J.-M. Strelcyn, Phys. Rev. A 14 (1976) 2338.

use crate::error::Error;
use crate::run::price::candidate::{Candidate, HALVINGS};
use crate::run::price::ladder::{Path, Pilot, Runner, Stop, distances};
use crate::run::price::moving::Rung;

/// How far aside the second run starts, relative to the largest momentum.
const ASIDE: f64 = 1e-8;
/// Positions are lost where they are off by this part of the way.
const LOST: f64 = 1e-2;
/// Looks at both runs, where there are as many steps.
const LOOKS: f64 = 256.0;
/// This part of the looks is to fall before positions are lost; else a part of the time is looked at more closely.
const FEWEST: f64 = 0.125;
/// Chaos may show later than on the pilot: so many times as long is looked at, if the run is to be as long.
const FURTHER: f64 = 10.0;
/// Steps of both runs, as part of the longest.
const STEP: f64 = 0.25;
/// The part of the time that is left which both runs of a length may take; else they are shorter.
const SHARE: f64 = 0.5;
/// Growth like a power of time is at most of this power.
const POWER: f64 = 3.0;
/// Where positions are lost within the pilot, they are compared for this part of the time until then: the reference is
/// still exact.
const TOLD: f64 = 0.5;

/// How neighbours part.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Chaos {
    /// What rounding of the start alone grows to on the part of the pilot interval on which positions are compared.
    pub(super) floor: f64,
    /// 1/λ, where neighbours part exponentially.
    pub(super) lyapunov_time: Option<f64>,
    /// Until when positions can be told, counted from the start, if not for ever.
    pub(super) predictable: Option<f64>,
}

impl Chaos {
    /// Two close runs, or only their beginning if they part early. Nothing is known where they cannot be made.
    pub(super) fn look_for(runner: &Runner<'_>, pilot: &Pilot, duration: f64) -> Self {
        let mut length = duration.min(FURTHER * pilot.length);
        loop {
            let looks = (length / (STEP * pilot.longest)).clamp(8.0, LOOKS) as u64;
            let part = Pilot { length, looks, instants: 1, ..*pilot };
            // What passes where the body starts may be too long later.
            let shares = (0..=HALVINGS).map(|halvings| STEP * 0.5_f64.powi(halvings.cast_signed()));
            let own = Runner { deadline: runner.clock.now() + SHARE * runner.left(), ..*runner };
            let mut parted = shares.map(|share| part_ways(&own, &part, share * pilot.longest));
            let parted = parted.find(|parted| !matches!(parted, Err(Stop::Failed(Error::Step { .. }))));
            let (apart, way) = match parted {
                Some(Ok(parted)) => parted,
                None | Some(Err(Stop::Late)) if length > 8.0 * pilot.longest => {
                    length *= 0.125;
                    continue;
                }
                _ => return Self::default(),
            };
            let lost = apart.iter().position(|&d| d >= LOST * way).unwrap_or(apart.len());
            if (lost as f64) < FEWEST * looks as f64 && length > 8.0 * pilot.longest {
                length *= 0.125;
                continue;
            }
            return Self::of(&apart, lost, way, &part, pilot);
        }
    }

    /// From distances at each look, of which the first ones are before positions are lost.
    fn of(apart: &[f64], lost: usize, way: f64, part: &Pilot, pilot: &Pilot) -> Self {
        let amplified = f64::EPSILON / ASIDE;
        let Some(last) = lost.checked_sub(1).filter(|&last| last >= 2) else { return Self::default() };
        let half = last / 2;
        let time = |k: usize| (k + 1) as f64 * part.stretch();
        let end = (0..last).find(|&k| time(k) >= pilot.length).unwrap_or(last);
        let floor = amplified * apart[end];
        let growth = (apart[last] / apart[half]).ln();
        if apart[half] <= 0.0 || growth <= POWER * (time(last) / time(half)).ln() {
            return Self { floor, ..Self::default() };
        }
        let rate = growth / (time(last) - time(half));
        let to_go = (LOST * way / (amplified * apart[last])).ln().max(0.0);
        Self { floor, lyapunov_time: Some(1.0 / rate), predictable: Some(time(last) + to_go / rate) }
    }

    /// At how many looks of the pilot interval positions are to be compared.
    pub(super) fn told(&self, pilot: &Pilot) -> usize {
        match self.predictable {
            Some(time) if time < pilot.length => (TOLD * time / pilot.stretch()) as usize,
            _ => pilot.looks as usize,
        }
    }
}

/// The largest distance up to each look, and the way, with steps of at most this length.
fn part_ways(runner: &Runner<'_>, part: &Pilot, h: f64) -> Result<(Vec<f64>, f64), Stop> {
    let steps = part.steps(h);
    let rung = Rung { candidate: Candidate::Rattle, h: part.stretch() / steps as f64, tolerance: 0.0 };
    let first = runner.scene.begin(rung)?;
    let start =
        Path { positions: vec![first.positions(); part.looks as usize], per_look: 1, ..Path::default() };
    let path = runner.go(part, steps, first)?;
    let beside = runner.scene.begin_beside(rung, ASIDE * path.largest_momentum)?;
    let beside = runner.go(part, steps, beside)?;
    let dimension = runner.scene.dimension();
    let way = distances(&path, &start, dimension).into_iter().fold(0.0, f64::max);
    let mut apart = distances(&path, &beside, dimension);
    (1..apart.len()).for_each(|k| apart[k] = apart[k].max(apart[k - 1]));
    Ok((apart, way))
}
