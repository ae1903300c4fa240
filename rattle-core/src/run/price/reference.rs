//! The pilot interval, and the reference motion on it, as exact as possible.

use crate::error::Error;
use crate::methods::composition::{KAHAN_LI_1997_ORDER_8, SOFRONIOU_SPALETTA_2005_ORDER_10};
use crate::run::price::candidate::Candidate;
use crate::run::price::ladder::{Path, Pilot, Runner, Stop, distances};
use crate::run::price::moving::Rung;

/// RATTLE's longest step keeps the energy to this part of the kinetic one.
const KEEPS: f64 = 0.1;
/// Steps of a probe.
const PROBE: u64 = 32;
/// The shortest step that is tried, as part of the whole time.
const SHORTEST: i32 = 44;
/// Bounds of the number of looks.
const LOOKS: (f64, f64) = (4.0, 64.0);
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
    /// The largest difference of the two, of a position and of an average.
    pub(super) error: f64,
    pub(super) averages: Vec<f64>,
    /// The farthest that a body comes from where it starts.
    pub(super) way: f64,
}

/// The pilot interval of a run of so long: on which RATTLE takes so many seconds with its longest step.
pub(super) fn pilot(runner: &Runner<'_>, duration: f64, seconds: f64) -> Result<Pilot, Stop> {
    let mut longest = passing(runner, duration)?;
    let shortest = duration * 0.5_f64.powi(SHORTEST);
    loop {
        match probe(runner, longest) {
            Ok(true) => break,
            Ok(false) if longest <= shortest => break, // at rest, or of an energy that is mostly rounding
            Err(Stop::Late) => return Err(Stop::Late),
            Err(stop @ Stop::Failed(_)) if longest <= shortest => return Err(stop),
            Ok(false) | Err(Stop::Failed(_)) => longest *= 0.5,
        }
    }
    let rung = Rung { candidate: Candidate::Rattle, h: longest, tolerance: 0.0 };
    let mut moving = runner.scene.begin(rung)?;
    let begun = runner.clock.now();
    moving.run(PROBE.min((duration / longest) as u64))?;
    let a_step = ((runner.clock.now() - begun) / PROBE as f64).max(1e-12);
    let affordable = seconds / a_step * longest;
    let length = duration / (duration / affordable).ceil().clamp(1.0, 1e15);
    let looks = (length / (16.0 * longest)).clamp(LOOKS.0, LOOKS.1).log2().floor().exp2() as u64;
    Ok(Pilot { length, looks, longest, told: looks as usize })
}

/// A step of RATTLE near which longer ones fail, from below: what fails is dear, as it says why.
fn passing(runner: &Runner<'_>, duration: f64) -> Result<f64, Stop> {
    let mut h = duration * 0.5_f64.powi(SHORTEST);
    loop {
        let mut moving = runner.scene.begin(Rung { candidate: Candidate::Rattle, h, tolerance: 0.0 })?;
        if runner.left() <= 0.0 {
            return Err(Stop::Late);
        }
        if moving.run(2).is_err() || h >= 0.25 * duration {
            return Ok(h);
        }
        h *= 4.0;
    }
}

/// Whether some steps of RATTLE of this length keep the energy.
fn probe(runner: &Runner<'_>, h: f64) -> Result<bool, Stop> {
    let mut moving = runner.scene.begin(Rung { candidate: Candidate::Rattle, h, tolerance: 0.0 })?;
    let (mut kinetic, mut error) = (moving.kinetic_energy().abs(), 0.0_f64); // in phase space all of H, of either sign
    for _ in 0..PROBE {
        moving.run(1)?;
        kinetic = kinetic.max(moving.kinetic_energy().abs());
        error = error.max(moving.energy_error().abs());
        if runner.left() <= 0.0 {
            return Err(Stop::Late);
        }
    }
    Ok(error <= KEEPS * kinetic)
}

impl Reference {
    /// Two methods at their most exact, and two close runs.
    pub(super) fn find(runner: &Runner<'_>, pilot: &Pilot) -> Result<Self, Stop> {
        let dimension = runner.scene.dimension();
        let mut found: Vec<(Candidate, Path)> = Vec::new();
        let (mut failed, mut late) = (None, false);
        for (number, candidate) in EXACT.into_iter().enumerate() {
            let share = runner.left() / (EXACT.len() - number).min(3) as f64;
            let deadline = runner.clock.now() + share;
            let own = Runner { deadline, ..*runner };
            match finest(&own, pilot, candidate, found.first().map(|(_, path)| path)) {
                Ok(path) => found.push((candidate, path)),
                Err(Stop::Late) => late = true,
                Err(Stop::Failed(error)) => {
                    if !matches!(failed, Some(Error::Step { .. })) {
                        failed = Some(error);
                    }
                }
            }
            if let [(_, first), .., (_, last)] = &found[..]
                && (agree(first, last, pilot, dimension) || found.len() == 3)
            {
                break;
            }
        }
        let pairs = (0..found.len()).flat_map(|i| (0..i).map(move |j| (j, i)));
        let apart =
            |&(j, i): &(usize, usize)| most(pilot.told(&distances(&found[j].1, &found[i].1, dimension)));
        let Some((j, i)) = pairs.min_by(|a, b| apart(a).total_cmp(&apart(b))) else {
            return Err(failed.filter(|_| !late).map_or(Stop::Late, Stop::Failed));
        };
        let error = apart(&(j, i));
        let (candidate, second) = (found[j].0, found[i].0);
        let path = found.swap_remove(j).1;
        let averages = averages(&path);
        let start = Path { positions: vec![start(runner, pilot)?; path.positions.len()], ..Path::default() };
        let way = most(&distances(&path, &start, dimension));
        Ok(Self { candidate, second, path, error, averages, way })
    }
}

fn start(runner: &Runner<'_>, pilot: &Pilot) -> Result<Vec<f64>, Stop> {
    let rung = Rung { candidate: Candidate::Rattle, h: pilot.longest, tolerance: 0.0 };
    Ok(runner.scene.begin(rung)?.positions())
}

/// The largest coordinate at the start, or 1.
pub(super) fn runner_size(runner: &Runner<'_>, pilot: &Pilot) -> f64 {
    let largest = start(runner, pilot).map_or(0.0, |q| q.iter().fold(0.0, |most: f64, q| most.max(q.abs())));
    if largest > 0.0 { largest } else { 1.0 }
}

/// Steps from look to look, and what is set, of a method with a tolerance near rounding; of others with steps a
/// sixteenth of RATTLE's longest.
fn most_exact(pilot: &Pilot, candidate: Candidate, size: f64) -> (u64, Rung) {
    let adaptive = candidate.is_adaptive();
    let steps = pilot.steps(if adaptive { candidate.reach() } else { 1.0 / 16.0 } * pilot.longest);
    let tolerance = size * if candidate == Candidate::Taylor { 1e-17 } else { 1e-15 };
    (steps, Rung { candidate, h: pilot.stretch() / steps as f64, tolerance })
}

/// The path of a method at its most exact: with steps halved for as long as that makes the path come nearer to the
/// other, or to the one before.
fn finest(
    runner: &Runner<'_>,
    pilot: &Pilot,
    candidate: Candidate,
    other: Option<&Path>,
) -> Result<Path, Stop> {
    let (mut steps, mut rung) = most_exact(pilot, candidate, runner_size(runner, pilot));
    if candidate.is_adaptive() {
        return runner.path(pilot, steps, rung);
    }
    let dimension = runner.scene.dimension();
    let mut best: Option<Path> = None;
    let mut before = f64::INFINITY;
    loop {
        let path = match runner.path(pilot, steps, rung) {
            Ok(path) => path,
            Err(stop) => return best.ok_or(stop),
        };
        let Some(last) = &best else {
            best = Some(path);
            (steps, rung.h) = (2 * steps, 0.5 * rung.h);
            continue;
        };
        let apart = most(pilot.told(&distances(other.unwrap_or(last), &path, dimension)));
        let near = apart > 0.5 * before || apart == 0.0;
        let late = 2.5 * path.seconds > runner.left();
        if !near || apart < before {
            best = Some(path);
        }
        if near || late {
            return best.ok_or(Stop::Late);
        }
        before = apart;
        (steps, rung.h) = (2 * steps, 0.5 * rung.h);
    }
}

/// Whether two paths differ by rounding alone, or by little more.
fn agree(a: &Path, b: &Path, pilot: &Pilot, dimension: usize) -> bool {
    let size = a.positions.iter().flatten().fold(0.0, |most: f64, q| most.max(q.abs()));
    most(pilot.told(&distances(a, b, dimension))) <= 1e-13 * size
}

/// The largest; NaN if one is.
pub(super) fn most(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |most, &x| if x.is_nan() || x > most { x } else { most })
}

/// Means over the looks.
pub(super) fn averages(path: &Path) -> Vec<f64> {
    let n = path.observed.len().max(1) as f64;
    let number = path.observed.first().map_or(0, Vec::len);
    (0..number).map(|i| path.observed.iter().map(|values| values[i]).sum::<f64>() / n).collect()
}
