//! The results of a measurement.

use crate::error::Error;
use crate::run::price::candidate::Candidate;

/// What accuracy costs in computing time in one scene, for each method that can move it. Made by
/// [`Scene::price`](crate::scene::Scene::price); `{}` shows the rows of the front, `{:#}` all of them, and
/// [`csv`](Self::csv) gives all numbers.
#[derive(Debug, Clone)]
pub struct Prices {
    /// The length of the run that was asked about, in the unit of time.
    pub duration: f64,
    /// The length of the pilot interval, from the start, on which everything was measured: all of `duration` if the
    /// budget allowed.
    pub pilot: f64,
    /// The method of the reference motion, and the method that repeated it.
    pub reference: [Candidate; 2],
    /// The largest distance between the two reference motions, a length: smaller errors of position cannot be measured.
    pub reference_error: f64,
    /// The largest difference of energy between the two reference motions, where forces or constraints change with time
    /// or flows do work: smaller errors of the energy cannot be measured. `None` where the exact motion keeps
    /// the energy.
    pub reference_energy_error: Option<f64>,
    /// The size to which a rounding error in the start grows on the pilot interval, a length.
    pub rounding: f64,
    /// The largest distance of a body from its start, a length.
    pub way: f64,
    /// The Lyapunov time, in which the distance of close motions grows by the factor e; `None` if it does not grow
    /// exponentially.
    pub lyapunov_time: Option<f64>,
    /// The time after which rounding errors have grown to a hundredth of `way`, so that positions are no longer
    /// predictable; `None` if that never happens.
    pub predictable: Option<f64>,
    /// The time, from the start, up to which errors of position are measured: the end of the pilot interval, or earlier
    /// where chaos makes positions unpredictable.
    pub positions_until: f64,
    /// Averages of the observables, by the reference.
    pub averages: Vec<Average>,
    /// A row for each method and step size: method by method, long steps first.
    pub rows: Vec<Price>,
    /// Methods without a row, and why.
    pub refused: Vec<Refused>,
    /// Seconds that the measurement took.
    pub seconds: f64,
}

/// Growth of errors from some parts of the pilot to others is not steady: they may be so many times as large as it lets
/// expect.
const UNSTEADY: f64 = 2.0;

/// A run that may be longer than the pilot.
#[derive(Debug, Clone, Copy)]
pub(super) struct Longer {
    pub(super) duration: f64,
    pub(super) pilot: f64,
    pub(super) lyapunov_time: Option<f64>,
    /// Whether positions can be told on all of the pilot.
    pub(super) told: bool,
    /// Whether something does [work](crate::run::price::moving::Movable::works).
    pub(super) works: bool,
}

impl Longer {
    /// By what factor an error on the pilot interval is larger at the end of the whole run, at most.
    pub(super) fn grown(self, price: &Price, what: Quantity) -> f64 {
        let times = self.duration / self.pilot;
        if times <= 1.0 {
            return 1.0;
        }
        let [position, energy] = price.growth;
        // The energy of what works is as exact as the motion is.
        let of_motion = |exponent: f64| match self.lyapunov_time {
            Some(time) => ((self.duration - self.pilot) / time).exp(),
            None => times.powf(astray(price, exponent)),
        };
        UNSTEADY
            * match what {
                Quantity::Position => of_motion(position),
                Quantity::Energy if self.works => of_motion(energy),
                // By methods that are not symplectic it drifts.
                Quantity::Energy => times.powf(energy.clamp(least(price) - 1.0, 1.0)),
                // Of chaotic motion, averages are what statistics make them.
                Quantity::Average(_) if !self.told || self.lyapunov_time.is_some() => 1.0,
                // Of an error that is exactly 0 no factor tells what it grows to.
                Quantity::Average(number) => match price.error(what) {
                    Some(error) if error > 0.0 => 1.0 + self.strays(price, number) / error,
                    _ => 1.0,
                },
            }
    }

    /// The error of a row at the end of the whole run, at most, if it can be told.
    pub(super) fn at_end(self, price: &Price, what: Quantity) -> Option<f64> {
        match (what, price.error(what)?) {
            (Quantity::Average(number), 0.0) => Some(UNSTEADY * self.strays(price, number)),
            (_, error) => Some(error * self.grown(price, what)),
        }
    }

    /// What an average is off by at the end of the whole run beyond what it is on the pilot: nothing by the rule that
    /// takes it, and as much as states that are off go [astray](astray). Nothing where motion is chaotic: averages are
    /// what statistics make them then.
    fn strays(self, price: &Price, number: usize) -> f64 {
        let times = self.duration / self.pilot;
        match price.drifts.get(number) {
            Some(&[off, exponent]) if times > 1.0 && self.told && self.lyapunov_time.is_none() => {
                (off * (times.powf(astray(price, exponent)) - 1.0)).max(0.0)
            }
            _ => 0.0,
        }
    }
}

/// The exponent with which states go astray beyond the pilot, with this one on it: no slower than time, since a short
/// pilot does not tell a trend from a swing; by methods that are not symplectic no slower than its square, as the
/// energy drifts.
fn astray(price: &Price, exponent: f64) -> f64 {
    exponent.clamp(least(price), 2.0)
}

fn least(price: &Price) -> f64 {
    if price.method.is_adaptive() { 2.0 } else { 1.0 }
}

/// The time average of an observable over the pilot interval.
#[derive(Debug, Clone, PartialEq)]
pub struct Average {
    /// The name of the observable.
    pub name: String,
    /// The average, by the reference with steps so short that shorter ones do not change it, as far as the budget
    /// allowed.
    pub mean: f64,
    /// The uncertainty of an average over so short a time, from means over eighths of it. Where motion is chaotic, no
    /// method is more exact.
    pub uncertainty: f64,
}

/// One method with one step size: its cost and its errors.
#[derive(Debug, Clone)]
pub struct Price {
    /// The method.
    pub method: Candidate,
    /// The step size.
    pub h: f64,
    /// The tolerance, of adaptive methods.
    pub tolerance: Option<f64>,
    /// The largest error of position of any body at the end of any step up to
    /// [`positions_until`](Prices::positions_until), or at the end of every n-th where steps are much shorter than the
    /// longest that RATTLE can take; `None` if that is before the first sampled time.
    pub position: Option<f64>,
    /// The largest error of the energy after any step, or after every n-th where steps are much shorter than
    /// the longest that RATTLE can take; in its unit. It is the change of the energy or, where forces or constraints
    /// change with time or flows do work, how far the energy is off that of the reference. Beyond
    /// [`positions_until`](Prices::positions_until) the latter cannot be told, and the change beside the work done
    /// counts.
    pub energy: f64,
    /// Errors of the averages over the steps of the run, by the trapezoidal rule, each in the unit of the observable;
    /// never less than what the averages of the reference are uncertain by.
    pub averages: Vec<f64>,
    /// For each average, by how much states that are off put it off, whatever the rule that takes it, and the exponent
    /// a with which that grew with time, like tᵃ.
    pub drifts: Vec<[f64; 2]>,
    /// The exponents a with which the errors of position and of energy grew with time, like tᵃ.
    pub growth: [f64; 2],
    /// Seconds for each unit of simulated time, of one trajectory: the median of repeats.
    pub seconds: f64,
    /// The relative difference of the repeats.
    pub spread: f64,
    /// Steps in the pilot interval.
    pub steps: u64,
    /// Corrections in the solution of position equations on the pilot interval, for linked bodies.
    pub corrections: Option<u64>,
    /// The observed order between this step size and the next longer one: of the error of position or, where positions
    /// are unpredictable, of the energy.
    pub order: Option<f64>,
    /// Whether rounding errors dominate here, so that a shorter step is no more exact.
    pub rounding: bool,
    /// Whether no cheaper row is as exact (the Pareto front); a row in lanes is compared with those in lanes.
    pub front: bool,
}

/// A method that did not get far enough for a row.
#[derive(Debug, Clone)]
pub struct Refused {
    /// The method.
    pub method: Candidate,
    /// Why; `None` if the budget left no time.
    pub why: Option<Error>,
}

/// Which error a wish is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Position,
    Energy,
    /// The average of this number.
    Average(usize),
}

impl Quantity {
    pub(super) fn is_average(self) -> bool {
        matches!(self, Self::Average(_))
    }
}

impl Price {
    /// The error of this, if it can be told.
    pub(super) fn error(&self, of: Quantity) -> Option<f64> {
        match of {
            Quantity::Position => self.position,
            Quantity::Energy => Some(self.energy),
            Quantity::Average(number) => self.averages.get(number).copied(),
        }
    }

    /// Step size or tolerance: what decides on the error.
    pub(super) fn fineness(&self) -> f64 {
        self.tolerance.unwrap_or(self.h)
    }
}

impl Prices {
    /// The Pareto front: the rows for which no cheaper row is as exact, cheapest first, without those in lanes.
    pub fn front(&self) -> impl Iterator<Item = &Price> {
        let mut front: Vec<_> =
            self.rows.iter().filter(|row| row.front && !row.method.is_in_lanes()).collect();
        front.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        front.into_iter()
    }

    /// The methods that have rows, in their order.
    #[must_use]
    pub fn methods(&self) -> Vec<Candidate> {
        let mut methods: Vec<_> = self.rows.iter().map(|row| row.method).collect();
        methods.dedup();
        methods
    }

    /// The least cost for each number of digits: (d, nanoseconds per unit of simulated time, method) such that the
    /// error of position (of energy, where positions are unpredictable) is 10⁻ᵈ, for those d = 1 … 15 that were
    /// reached. Between two rows, errors and times are interpolated as powers of the step size.
    #[must_use]
    pub fn digits(&self) -> Vec<(u32, f64, Candidate)> {
        self.digits_of(|method| !method.is_in_lanes())
    }

    /// The same of one of many trajectories [side by side](crate::run::price::Pricing::side_by_side).
    #[must_use]
    pub fn digits_in_lanes(&self) -> Vec<(u32, f64, Candidate)> {
        self.digits_of(Candidate::is_in_lanes)
    }

    fn digits_of(&self, which: fn(Candidate) -> bool) -> Vec<(u32, f64, Candidate)> {
        let (of, mut methods) = (self.quantity(), self.methods());
        methods.retain(|&method| which(method));
        let cheapest = |digits: u32| {
            let error = 10_f64.powi(-(digits as i32));
            let offers = methods.iter().filter_map(|&method| {
                let offer = interpolate(&self.of(method), of, error)?;
                Some((digits, 1e9 * offer.seconds, method))
            });
            offers.min_by(|a, b| a.1.total_cmp(&b.1))
        };
        let mut list: Vec<_> = (1..=15).filter_map(cheapest).collect();
        // What is more exact for less serves fewer digits too.
        for i in (1..list.len()).rev() {
            if list[i].1 < list[i - 1].1 {
                (list[i - 1].1, list[i - 1].2) = (list[i].1, list[i].2);
            }
        }
        list
    }

    /// The rounding floor of a method: its least error of position (of energy, where positions are unpredictable), if
    /// shorter steps were no more exact.
    #[must_use]
    pub fn floor(&self, method: Candidate) -> Option<f64> {
        let rows = self.of(method);
        let rounded = rows.iter().filter(|row| row.rounding);
        rounded.filter_map(|row| row.error(self.quantity())).min_by(f64::total_cmp)
    }

    /// Rows of a method, coarse steps first.
    pub(super) fn of(&self, method: Candidate) -> Vec<&Price> {
        self.rows.iter().filter(|row| row.method == method).collect()
    }

    /// Whether the error of this can be told no longer than positions can.
    pub(super) fn needs_positions(&self, what: Quantity) -> bool {
        match what {
            Quantity::Position => true,
            Quantity::Energy => self.reference_energy_error.is_some(),
            Quantity::Average(_) => false,
        }
    }

    /// What errors are compared by.
    pub(super) fn quantity(&self) -> Quantity {
        if self.tells_positions() { Quantity::Position } else { Quantity::Energy }
    }

    /// Whether positions are predictable on all of the pilot interval; otherwise methods are compared by their errors
    /// of energy.
    #[must_use]
    pub fn tells_positions(&self) -> bool {
        self.positions_until > 0.999_999 * self.pilot
    }

    /// The run that was asked about.
    pub(super) fn longer(&self) -> Longer {
        let Self { duration, pilot, lyapunov_time, reference_energy_error: off, .. } = *self;
        Longer { duration, pilot, lyapunov_time, told: self.tells_positions(), works: off.is_some() }
    }

    /// Marks the rows that nothing cheaper is as exact as: one by one, and in lanes.
    pub(super) fn mark_front(&mut self) {
        let of = self.quantity();
        let known =
            |row: &Price| (row.method.is_in_lanes(), row.seconds, row.error(of).unwrap_or(f64::INFINITY));
        let known: Vec<_> = self.rows.iter().map(known).collect();
        for (row, &(lanes, seconds, error)) in self.rows.iter_mut().zip(&known) {
            let beaten = |&(l, s, e): &(bool, f64, f64)| {
                l == lanes && (s < seconds && e <= error || s <= seconds && e < error)
            };
            row.front = error.is_finite() && !known.iter().any(beaten);
        }
    }
}

/// A step or tolerance, and what it costs, for an error.
#[derive(Debug, Clone, Copy)]
pub(super) struct Offer {
    pub(super) fineness: f64,
    pub(super) seconds: f64,
    /// The row that is known to have a smaller error.
    pub(super) row: usize,
}

/// Where these rows of one method reach an error for good, between two of them as powers of the step.
pub(super) fn interpolate(rows: &[&Price], of: Quantity, error: f64) -> Option<Offer> {
    let above = rows.iter().rposition(|row| row.error(of).is_none_or(|e| e.is_nan() || e > error));
    let first = above.map_or(0, |above| above + 1);
    // At the floor of rounding errors go up and down: any row that is below will do.
    let first = if first < rows.len() {
        first
    } else {
        rows.iter().position(|row| row.error(of).is_some_and(|e| e <= error))?
    };
    let fine = rows[first];
    let whole = Offer { fineness: fine.fineness(), seconds: fine.seconds, row: first };
    let (Some(coarse), Some(low)) = (first.checked_sub(1).map(|i| rows[i]), fine.error(of)) else {
        return Some(whole);
    };
    let Some(high) = coarse.error(of).filter(|&high| high > error && low > 0.0) else { return Some(whole) };
    let part = (high / error).ln() / (high / low).ln();
    let between = |a: f64, b: f64| a * (b / a).powf(part);
    let fineness = between(coarse.fineness(), fine.fineness());
    Some(Offer { fineness, seconds: between(coarse.seconds, fine.seconds), row: first })
}
