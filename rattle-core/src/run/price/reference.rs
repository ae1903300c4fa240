//! The pilot interval, and the reference motion on it, as exact as possible.

use crate::error::Error;
use crate::methods::composition::{KAHAN_LI_1997_ORDER_8, SOFRONIOU_SPALETTA_2005_ORDER_10};
use crate::number::vector::larger_or_nan;
use crate::run::price::candidate::{Candidate, HALVINGS};
use crate::run::price::ladder::{Path, Pilot, Runner, Stop, distances, energies_apart};
use crate::run::price::moving::Rung;
use std::iter::zip;

/// RATTLE's longest step keeps the energy to this part of the kinetic one.
const KEEPS: f64 = 0.1;
/// And to this part of all energy, which is rounding: all energy has any zero.
const ROUNDING: f64 = 8.0 * f64::EPSILON;
/// Steps of a probe.
const PROBE: u64 = 32;
/// The shortest step that is tried, as part of the whole time.
const SHORTEST: i32 = 44;
/// Bounds of the number of looks.
const LOOKS: (f64, f64) = (4.0, 64.0);
/// Equal parts from look to look, and how many of them in RATTLE's longest step are fine enough: an error that goes to
/// and fro with the motion is then seen to some percent.
const INSTANTS: [u64; 13] = [1, 2, 4, 8, 12, 16, 24, 36, 48, 60, 72, 96, 120];
const IN_LONGEST: f64 = 3.0;
/// Instants on the pilot interval, and coordinates kept of a path, at most.
const MOST_INSTANTS: u64 = 4096;
const MOST_NUMBERS: u64 = 1 << 21;
/// Averages are known to this part of the largest value, or better.
const AVERAGES: f64 = 1e-13;
/// Methods of which two make a reference, the most exact first.
const EXACT: [Candidate; 6] = [
    Candidate::Taylor,
    Candidate::Lobatto8,
    Candidate::Dop853,
    Candidate::Composition(SOFRONIOU_SPALETTA_2005_ORDER_10),
    Candidate::Composition(KAHAN_LI_1997_ORDER_8),
    Candidate::Rattle,
];

/// The motion, as exactly as can be had.
#[derive(Debug, Clone)]
pub(super) struct Reference {
    pub(super) candidate: Candidate,
    pub(super) second: Candidate,
    pub(super) path: Path,
    /// Steps from look to look, and their size.
    steps: u64,
    rung: Rung,
    /// The largest difference of the two, of a position and, where something does work, of the energy. Where flows act,
    /// which put both off alike, at least what they put the motion off by.
    pub(super) error: f64,
    pub(super) energy_error: f64,
    /// Averages over the time of the pilot, and to what they are known.
    pub(super) averages: Vec<f64>,
    pub(super) averages_off: Vec<f64>,
    /// The farthest that a body comes from where it starts.
    pub(super) way: f64,
}

/// The pilot interval of a run of so long: on which RATTLE takes so many seconds with its longest step.
pub(super) fn pilot(runner: &Runner<'_>, duration: f64, seconds: f64) -> Result<Pilot, Stop> {
    let mut longest = passing(runner, duration)?;
    let shortest = duration * 0.5_f64.powi(SHORTEST);
    let size = loop {
        match probe(runner, longest) {
            Ok((true, size)) => break size,
            Ok((false, size)) if longest <= shortest => break size, // at rest, or of an energy that is mostly rounding
            Err(Stop::Late) => return Err(Stop::Late),
            Err(stop @ Stop::Failed(_)) if longest <= shortest => return Err(stop),
            Ok(_) | Err(Stop::Failed(_)) => longest *= 0.5,
        }
    };
    let size = if size > 0.0 { size } else { 1.0 }; // at rest in the origin
    let rung = Rung { candidate: Candidate::Rattle, h: longest, tolerance: 0.0 };
    let mut moving = runner.scene.begin(rung)?;
    let begun = runner.clock.now();
    let steps = PROBE.min((duration / longest) as u64).max(1);
    moving.run(steps)?;
    let a_step = ((runner.clock.now() - begun) / steps as f64).max(1e-12);
    let affordable = seconds / a_step * longest;
    let length = duration / (duration / affordable).ceil().clamp(1.0, 1e15);
    let looks = (length / (16.0 * longest)).clamp(LOOKS.0, LOOKS.1).log2().floor().exp2() as u64;
    let coordinates = moving.positions().len() as u64;
    let room = MOST_INSTANTS.min(MOST_NUMBERS / coordinates.max(1)) / looks;
    let wanted = IN_LONGEST * length / (looks as f64 * longest);
    let fitting = || INSTANTS.into_iter().filter(|&n| n <= room.max(1));
    let instants = fitting().find(|&n| n as f64 >= wanted).or_else(|| fitting().next_back()).unwrap_or(1);
    Ok(Pilot { length, looks, instants, longest, size, told: looks as usize })
}

/// A step of RATTLE near which longer ones fail, from below: what fails is dear, as it says why. Near the origin a
/// start may be off its constraints by a part of a step's way, and is refused with shorter steps.
fn passing(runner: &Runner<'_>, duration: f64) -> Result<f64, Stop> {
    let mut h = duration * 0.5_f64.powi(SHORTEST);
    loop {
        let begun = runner.scene.begin(Rung { candidate: Candidate::Rattle, h, tolerance: 0.0 });
        if runner.left() <= 0.0 {
            return Err(Stop::Late);
        }
        if matches!(begun, Err(Error::Start { .. })) && h < 0.25 * duration {
            h *= 4.0;
            continue;
        }
        let mut moving = begun?;
        if moving.run(2).is_err() || h >= 0.25 * duration {
            return Ok(h);
        }
        h *= 4.0;
    }
}

/// Whether some steps of RATTLE of this length keep the energy, and the largest coordinate on their way.
fn probe(runner: &Runner<'_>, h: f64) -> Result<(bool, f64), Stop> {
    let mut moving = runner.scene.begin(Rung { candidate: Candidate::Rattle, h, tolerance: 0.0 })?;
    let extent = |positions: &[f64]| positions.iter().fold(0.0, |most: f64, q| most.max(q.abs()));
    let mut size = extent(&moving.positions());
    let (mut kinetic, mut error) = (moving.kinetic_energy(), 0.0_f64);
    for _ in 0..PROBE {
        moving.run(1)?;
        size = size.max(extent(&moving.positions()));
        kinetic = kinetic.max(moving.kinetic_energy());
        error = error.max(moving.energy_error().abs());
        if runner.left() <= 0.0 {
            return Err(Stop::Late);
        }
    }
    Ok((error <= KEEPS * kinetic + ROUNDING * moving.energy().abs(), size))
}

impl Reference {
    /// Two methods at their most exact, and two close runs.
    pub(super) fn find(runner: &Runner<'_>, pilot: &Pilot) -> Result<Self, Stop> {
        let dimension = runner.scene.dimension();
        let mut found: Vec<Finest> = Vec::new();
        let (mut failed, mut late) = (None, false);
        for (number, candidate) in EXACT.into_iter().enumerate() {
            let share = runner.left() / (EXACT.len() - number).min(3) as f64;
            let deadline = runner.clock.now() + share;
            let own = Runner { deadline, ..*runner };
            match finest(&own, pilot, candidate, found.first().map(|first| &first.path)) {
                Ok(run) => found.push(run),
                Err(Stop::Late) => late = true,
                Err(Stop::Failed(error)) => {
                    if !matches!(failed, Some(Error::Step { .. })) {
                        failed = Some(error);
                    }
                }
            }
            if let [first, .., last] = &found[..]
                && (agree(&first.path, &last.path, pilot, dimension) || found.len() == 3)
            {
                break;
            }
        }
        let pairs = (0..found.len()).flat_map(|i| (0..i).map(move |j| (j, i)));
        let apart = |&(j, i): &(usize, usize)| {
            most(pilot.told(&distances(&found[j].path, &found[i].path, dimension)))
        };
        let Some((j, i)) = pairs.min_by(|a, b| apart(a).total_cmp(&apart(b))) else {
            return Err(failed.filter(|_| !late).map_or(Stop::Late, Stop::Failed));
        };
        let mut error = apart(&(j, i));
        let energies = |a: &Path, b: &Path| most(pilot.told(&energies_apart(a, b)));
        let mut energy_error = energies(&found[j].path, &found[i].path);
        let second = found[i].rung.candidate;
        if runner.scene.flows() {
            let (other, part) = other(runner, pilot, &found[j])?;
            error =
                larger_or_nan(error, part * most(pilot.told(&distances(&found[j].path, &other, dimension))));
            energy_error = larger_or_nan(energy_error, part * energies(&found[j].path, &other));
        }
        let Finest { path, steps, rung } = found.swap_remove(j);
        let at_start = vec![start(runner, pilot)?; path.positions.len()];
        let start = Path { positions: at_start, per_look: path.per_look, ..Path::default() };
        let way = most(&distances(&path, &start, dimension));
        let (averages, averages_off) = (path.averages.clone(), vec![0.0; path.averages.len()]);
        Ok(Self {
            candidate: rung.candidate,
            second,
            path,
            steps,
            rung,
            error,
            energy_error,
            averages,
            averages_off,
            way,
        })
    }

    /// Finds the averages with ever shorter steps, until they change by `enough` or by rounding alone, or there is no
    /// time. They are those of Simpson's rule, from trapezoidal ones with n and with m steps,
    ///
    /// ```text
    /// A = (n² Tₙ − m² Tₘ)/(n² − m²)
    /// ```
    ///
    /// Where positions are lost, runs with other steps are other runs, and the first one decides.
    pub(super) fn refine_averages(&mut self, runner: &Runner<'_>, pilot: &Pilot, enough: f64) {
        let largest: Vec<f64> = (0..self.averages.len())
            .map(|i| self.path.observed.iter().fold(0.0, |most, all| all[i].abs().max(most)))
            .collect();
        let [few, some, mut many] = [4, 2, 1].map(|every| sampled(&self.path, every));
        self.better(&few, &some);
        self.better(&some, &many);
        let (mut steps, mut rung, mut seconds) = (self.steps, self.rung, self.path.seconds);
        if steps > self.path.per_look {
            let all = (steps as f64, self.path.averages.clone());
            self.better(&many, &all);
            many = all;
        }
        loop {
            let known = |(off, largest): (&f64, &f64)| *off <= enough.max(AVERAGES * largest);
            let known = zip(&self.averages_off, &largest).all(known);
            if known || pilot.told < pilot.looks as usize || 2.5 * seconds > runner.left() {
                return;
            }
            (steps, rung.h) = (2 * steps, 0.5 * rung.h);
            let Ok(next) = runner.path(pilot, steps, rung) else { return };
            let more = (steps as f64, next.averages);
            self.better(&many, &more);
            (many, seconds) = (more, next.seconds);
        }
    }

    /// Takes the averages that follow from those with fewer steps and with more.
    fn better(&mut self, (m, fewer): &(f64, Vec<f64>), (n, more): &(f64, Vec<f64>)) {
        for (i, (a, b)) in zip(more, fewer).enumerate() {
            let better = a + (a - b) * (m * m / (n * n - m * m));
            (self.averages_off[i], self.averages[i]) = ((better - self.averages[i]).abs(), better);
        }
    }
}

fn start(runner: &Runner<'_>, pilot: &Pilot) -> Result<Vec<f64>, Stop> {
    let rung = Rung { candidate: Candidate::Rattle, h: pilot.longest, tolerance: 0.0 };
    Ok(runner.scene.begin(rung)?.positions())
}

/// Steps from look to look, and what is set, of a method with a tolerance near rounding; of others with steps a
/// sixteenth of RATTLE's longest.
fn most_exact(pilot: &Pilot, candidate: Candidate) -> (u64, Rung) {
    let adaptive = candidate.is_adaptive();
    let steps = pilot.steps(if adaptive { candidate.reach() } else { 1.0 / 16.0 } * pilot.longest);
    let steps = steps.checked_next_multiple_of(pilot.instants).unwrap_or(steps);
    let tolerance = pilot.size * if candidate == Candidate::Taylor { 1e-17 } else { 1e-15 };
    (steps, Rung { candidate, h: pilot.stretch() / steps as f64, tolerance })
}

/// A path with its steps from look to look.
struct Finest {
    path: Path,
    steps: u64,
    rung: Rung,
}

/// The path of a method at its most exact: with steps halved for as long as that makes the path come nearer to the
/// other, or to the one before; and first until none of them fails.
fn finest(
    runner: &Runner<'_>,
    pilot: &Pilot,
    candidate: Candidate,
    other: Option<&Path>,
) -> Result<Finest, Stop> {
    let (mut steps, mut rung) = most_exact(pilot, candidate);
    if candidate.is_adaptive() {
        return Ok(Finest { path: runner.path(pilot, steps, rung)?, steps, rung });
    }
    let dimension = runner.scene.dimension();
    let mut best: Option<Finest> = None;
    let (mut before, mut halvings) = (f64::INFINITY, 0);
    let mut failed = None;
    loop {
        let path = match runner.path(pilot, steps, rung) {
            Ok(path) => path,
            Err(Stop::Failed(error @ Error::Step { .. })) if best.is_none() && halvings < HALVINGS => {
                (failed, halvings) = (Some(error), halvings + 1);
                (steps, rung.h) = (2 * steps, 0.5 * rung.h);
                continue;
            }
            // What failed tells more than that there was no time for shorter steps.
            Err(stop) => return best.ok_or(failed.map_or(stop, Stop::Failed)),
        };
        let Some(last) = &best else {
            best = Some(Finest { path, steps, rung });
            (steps, rung.h) = (2 * steps, 0.5 * rung.h);
            continue;
        };
        let apart = most(pilot.told(&distances(other.unwrap_or(&last.path), &path, dimension)));
        let near = apart > 0.5 * before || apart == 0.0;
        let late = 2.5 * path.seconds > runner.left();
        if !near || apart < before {
            best = Some(Finest { path, steps, rung });
        }
        if near || late {
            return best.ok_or(Stop::Late);
        }
        before = apart;
        (steps, rung.h) = (2 * steps, 0.5 * rung.h);
    }
}

/// A path with steps of another size, and the part of its distance that the errors of the second order make of the path
/// itself: a third with steps twice as long. An odd number of steps, and one of which half as many fail, is compared
/// with twice as many.
fn other(runner: &Runner<'_>, pilot: &Pilot, of: &Finest) -> Result<(Path, f64), Stop> {
    // However little time is left: what nobody knows the error of is no reference.
    let path = |steps: u64, times: f64| {
        let deadline = runner.deadline.max(runner.clock.now() + 4.0 * of.path.seconds);
        let runner = Runner { deadline, ..*runner };
        runner.path(pilot, steps, Rung { h: times * of.rung.h, ..of.rung })
    };
    let longer = of.steps.is_multiple_of(2).then(|| path(of.steps / 2, 2.0));
    match longer {
        Some(Ok(path)) => Ok((path, 1.0 / 3.0)),
        Some(Err(Stop::Late)) => Err(Stop::Late),
        Some(Err(Stop::Failed(_))) | None => Ok((path(2 * of.steps, 0.5)?, 4.0 / 3.0)),
    }
}

/// Whether two paths differ by rounding alone, or by little more.
fn agree(a: &Path, b: &Path, pilot: &Pilot, dimension: usize) -> bool {
    let size = a.positions.iter().flatten().fold(0.0, |most: f64, q| most.max(q.abs()));
    most(pilot.told(&distances(a, b, dimension))) <= 1e-13 * size
}

/// The largest; NaN if one is.
pub(super) fn most(numbers: &[f64]) -> f64 {
    numbers.iter().copied().fold(0.0, larger_or_nan)
}

/// Averages from every second, third, … sight of a path alone, with the number of those from look to look.
fn sampled(path: &Path, every: usize) -> (f64, Vec<f64>) {
    let mean = |i: usize| {
        let seen = path.observed.iter().skip(every - 1).step_by(every).map(|all| all[i]);
        let ends = path.observed.last().map_or(0.0, |last| 0.5 * (path.first[i] - last[i]));
        (seen.sum::<f64>() + ends) / (path.observed.len() / every) as f64
    };
    (path.per_look as f64 / every as f64, (0..path.averages.len()).map(mean).collect())
}
