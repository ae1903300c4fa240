//! Runs over the pilot interval, sampled at the times of the reference.

use crate::error::Error;
use crate::motion::stir;
use crate::number::vector::larger_or_nan;
use crate::run::price::candidate::Candidate;
use crate::run::price::clock::Clock;
use crate::run::price::moving::{Movable, Moving, Rung};
use std::iter::zip;

/// Repeats of which the median time counts, where the budget allows; two that are alike to so much are enough.
const REPEATS: usize = 5;
const ALIKE: f64 = 0.01;
/// A repeat takes so many seconds at least, by running several times.
const SAMPLE: f64 = 1e-4;
/// Between two instants, the energy is asked for so often.
const GLANCES: u64 = 4;

/// The pilot interval, and how it is looked at.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pilot {
    /// How long it is.
    pub(super) length: f64,
    /// How many looks.
    pub(super) looks: u64,
    /// Equal parts from look to look, at whose ends the reference is known: an even number, or 1.
    pub(super) instants: u64,
    /// The longest step of RATTLE that was found to pass.
    pub(super) longest: f64,
    /// The largest coordinate at the start and on the way of some of these: of this size tolerances are.
    pub(super) size: f64,
    /// At how many of the looks positions are compared: at those before chaos makes them unknown.
    pub(super) told: usize,
}

impl Pilot {
    /// The time between two looks.
    pub(super) fn stretch(&self) -> f64 {
        self.length / self.looks as f64
    }

    /// The part of these numbers, as many for each look, at which positions are compared.
    pub(super) fn told<'a>(&self, numbers: &'a [f64]) -> &'a [f64] {
        let each = numbers.len() / (self.looks as usize).max(1);
        &numbers[..(self.told * each).min(numbers.len())]
    }

    /// Steps from look to look for steps of at most this size, as [`at_instants`](Self::at_instants); at least one.
    pub(super) fn steps(&self, h: f64) -> u64 {
        self.at_instants((self.stretch() / h).ceil().max(1.0) as u64)
    }

    /// At least so many steps from look to look, of which all end at instants; where there are more steps than
    /// instants, so many that a step ends at every second instant, or at every one.
    pub(super) fn at_instants(&self, least: u64) -> u64 {
        if least <= self.instants {
            return (least.max(1)..self.instants)
                .find(|n| self.instants.is_multiple_of(*n))
                .unwrap_or(self.instants);
        }
        least.checked_next_multiple_of(self.instants.div_ceil(2)).unwrap_or(least)
    }
}

/// Why a run was not made to its end.
#[derive(Debug)]
pub(super) enum Stop {
    /// The method failed.
    Failed(Error),
    /// There was no time left.
    Late,
}

impl From<Error> for Stop {
    fn from(error: Error) -> Self {
        Self::Failed(error)
    }
}

/// What was seen of a run.
#[derive(Debug, Clone, Default)]
pub(super) struct Path {
    /// Sights from look to look: at the ends of steps that are instants.
    pub(super) per_look: u64,
    /// Positions at each sight.
    pub(super) positions: Vec<Vec<f64>>,
    /// The largest change of the energy beside the work done, up to each sight.
    pub(super) energy: Vec<f64>,
    /// The energy at each sight, where something does [work](Movable::works).
    pub(super) energies: Vec<f64>,
    /// What is observed, at the start, and at each sight.
    pub(super) first: Vec<f64>,
    pub(super) observed: Vec<Vec<f64>>,
    /// Averages of what is observed, over all steps, by the trapezoidal rule.
    pub(super) averages: Vec<f64>,
    pub(super) largest_momentum: f64,
    pub(super) kinetic: f64,
    /// The energy at the end, or the largest kinetic one if that is more: energies are rounded by parts of it.
    pub(super) size: f64,
    pub(super) iterations: Option<u64>,
    /// Seconds that it took, looks included.
    pub(super) seconds: f64,
}

/// Who runs, and until when.
pub(super) struct Runner<'a> {
    pub(super) scene: &'a dyn Movable,
    pub(super) clock: &'a Clock,
    pub(super) deadline: f64,
}

impl Runner<'_> {
    /// Trajectories that a run of this method moves.
    pub(super) fn trajectories(&self, method: Candidate) -> usize {
        if method.is_in_lanes() { self.scene.trajectories() } else { 1 }
    }

    /// The order of a method in this scene.
    pub(super) fn order(&self, method: Candidate) -> u32 {
        if self.scene.flows() { method.order().min(stir::ORDER) } else { method.order() }
    }

    pub(super) fn left(&self) -> f64 {
        self.deadline - self.clock.now()
    }

    fn look_at_clock(&self) -> Result<(), Stop> {
        if self.left() > 0.0 { Ok(()) } else { Err(Stop::Late) }
    }

    /// Goes through the pilot interval with so many steps from look to look.
    pub(super) fn path(&self, pilot: &Pilot, steps: u64, rung: Rung) -> Result<Path, Stop> {
        self.go(pilot, steps, self.scene.begin(rung)?)
    }

    pub(super) fn go(
        &self,
        pilot: &Pilot,
        steps: u64,
        mut moving: Box<dyn Moving + '_>,
    ) -> Result<Path, Stop> {
        let per_look = gcd(steps, pilot.instants);
        let mut path = Path { kinetic: moving.kinetic_energy(), per_look, ..Path::default() };
        let (mut energy, first) = (0.0_f64, moving.observed());
        let between = steps / per_look;
        let at_once = if first.is_empty() { between.div_ceil(GLANCES) } else { 1 };
        let mut sums: Vec<f64> = first.iter().map(|x| 0.5 * x).collect();
        path.first = first;
        let begun = self.clock.now();
        for _ in 0..pilot.looks * per_look {
            let mut left = between;
            while left > 0 {
                let part = left.min(at_once);
                moving.run(part)?;
                left -= part;
                energy = larger_or_nan(energy, moving.energy_error().abs());
                zip(&mut sums, moving.observed()).for_each(|(sum, x)| *sum += x);
                self.look_at_clock()?;
            }
            path.energy.push(energy);
            path.energies.extend(self.scene.works().then(|| moving.energy()));
            path.positions.push(moving.positions());
            path.observed.push(moving.observed());
            path.largest_momentum = path.largest_momentum.max(moving.largest_momentum());
            path.kinetic = path.kinetic.max(moving.kinetic_energy());
        }
        path.seconds = self.clock.now() - begun;
        path.iterations = moving.iterations();
        path.size = moving.energy().abs().max(path.kinetic);
        let (last, number) = (moving.observed(), (pilot.looks * steps) as f64);
        path.averages = zip(sums, last).map(|(sum, last)| (sum - 0.5 * last) / number).collect();
        Ok(path)
    }

    /// Seconds that the steps of the interval take, and by what part repeats differ: the median, and half of what lies
    /// between the quartiles. As often as there is time, and none where there is no time for one.
    pub(super) fn time(
        &self,
        pilot: &Pilot,
        steps: u64,
        rung: Rung,
        about: f64,
    ) -> Result<Option<(f64, f64)>, Stop> {
        let fresh = self.scene.begin(rung)?;
        let at_once = (SAMPLE / about.max(1e-9)).ceil().clamp(1.0, 64.0) as usize;
        let mut times = Vec::new();
        while times.len() < REPEATS && self.left() > 1.5 * about * at_once as f64 {
            let mut copies: Vec<_> = (0..at_once).map(|_| fresh.again()).collect::<Result<_, _>>()?;
            let begun = self.clock.now();
            for copy in &mut copies {
                copy.run(pilot.looks * steps)?;
            }
            times.push((self.clock.now() - begun) / at_once as f64);
            if let [first, second] = times[..]
                && (first - second).abs() <= ALIKE * first
            {
                break;
            }
        }
        times.sort_by(f64::total_cmp);
        let n = times.len();
        let quarter = |k: usize| times[(k * (n - 1) + 2) / 4];
        Ok((n > 0).then(|| (quarter(2), 0.5 * (quarter(3) - quarter(1)) / quarter(2).max(f64::MIN_POSITIVE))))
    }
}

/// The greatest common divisor of two numbers, one of them positive.
fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// The sights that both paths have, by their numbers on the one and on the other.
fn in_common(a: &Path, b: &Path) -> impl Iterator<Item = (usize, usize)> {
    let common = gcd(a.per_look, b.per_look);
    let every = |path: &'_ Path| (path.per_look / common).max(1) as usize;
    let (mine, theirs) = (every(a), every(b));
    let all = |path: &'_ Path, every: usize| (every - 1..path.positions.len()).step_by(every);
    zip(all(a, mine), all(b, theirs))
}

/// At each sight that both paths have, how far the body is that is farthest from where it is on the other path.
pub(super) fn distances(a: &Path, b: &Path, dimension: usize) -> Vec<f64> {
    let at = |(i, j): (usize, usize)| {
        let bodies = zip(a.positions[i].chunks(dimension), b.positions[j].chunks(dimension));
        bodies.fold(0.0, |most, (a, b)| {
            let square: f64 = zip(a, b).map(|(a, b)| (a - b) * (a - b)).sum();
            larger_or_nan(square.sqrt(), most)
        })
    };
    in_common(a, b).map(at).collect()
}

/// At each sight that both paths have, by how much the energy differs; nothing where nothing does work.
pub(super) fn energies_apart(a: &Path, b: &Path) -> Vec<f64> {
    let at = |(i, j): (usize, usize)| Some((a.energies.get(i)? - b.energies.get(j)?).abs());
    in_common(a, b).filter_map(at).collect()
}

/// At each sight that both paths have, by how much the average until then of this number of those observed differs: a
/// sum over the same instants on both, so by what the states are off alone.
pub(super) fn averages_apart(a: &Path, b: &Path, number: usize) -> Vec<f64> {
    let mut sum = 0.0;
    let at = |(count, (i, j)): (usize, (usize, usize))| {
        sum += a.observed[i][number] - b.observed[j][number];
        (sum / (count + 1) as f64).abs()
    };
    in_common(a, b).enumerate().map(at).collect()
}
