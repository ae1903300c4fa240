//! What was measured.

use crate::error::Error;
use crate::run::price::candidate::Candidate;

/// What accuracy costs in time in one scene, by each method that can move it. Made by
/// [`Scene::price`](crate::scene::Scene::price); `Display` shows tables, [`csv`](Self::csv) all numbers.
#[derive(Debug, Clone)]
pub struct Prices {
    /// The time that was asked about, in the unit of time.
    pub duration: f64,
    /// The pilot interval from the start on which everything was measured: the whole time if the budget allowed.
    pub pilot: f64,
    /// The method that the errors are told against, and the one that repeated it.
    pub reference: [Candidate; 2],
    /// The largest distance between the two, a length: smaller errors of position are not known.
    pub reference_error: f64,
    /// What an error of rounding in the start alone grows to on the pilot interval, a length.
    pub rounding: f64,
    /// The farthest that a body came from where it started, a length.
    pub way: f64,
    /// The Lyapunov time: the time in which the distance of close motions grows by e, if it grows exponentially.
    pub lyapunov_time: Option<f64>,
    /// How long positions can be told before rounding has grown to a hundredth of the way, if not for ever.
    pub predictable: Option<f64>,
    /// Until when, counted from the start, errors of position are told: on all of the pilot interval, or for as long as
    /// chaos lets them be known.
    pub positions_until: f64,
    /// Averages by the reference.
    pub averages: Vec<Average>,
    /// A row for each method and step, methods in turn, coarse steps first.
    pub rows: Vec<Price>,
    /// Methods that have no row, and why.
    pub refused: Vec<Refused>,
    /// Seconds that measuring took.
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
}

impl Longer {
    /// By what factor an error on the pilot interval is larger at the end of the whole run, at most.
    pub(super) fn grown(self, price: &Price, what: Quantity) -> f64 {
        let times = self.duration / self.pilot;
        if times <= 1.0 {
            return 1.0;
        }
        let [position, energy] = price.growth;
        UNSTEADY
            * match (what, self.lyapunov_time) {
                (Quantity::Position, Some(time)) => ((self.duration - self.pilot) / time).exp(),
                (Quantity::Position, None) => times.powf(position.clamp(1.0, 2.0)),
                (Quantity::Energy, _) => times.powf(energy.clamp(0.0, 1.0)),
                (Quantity::Average(_), _) => 1.0,
            }
    }
}

/// The mean of an observable over the looks of the pilot interval.
#[derive(Debug, Clone, PartialEq)]
pub struct Average {
    /// The name that was given.
    pub name: String,
    /// By the reference.
    pub mean: f64,
    /// What a mean over so short a time is uncertain by, from means over eighths of it: where motion is chaotic no
    /// method is nearer.
    pub uncertainty: f64,
}

/// One method with one step: what it costs and what it gives.
#[derive(Debug, Clone)]
pub struct Price {
    /// The method.
    pub method: Candidate,
    /// The step size.
    pub h: f64,
    /// The tolerance, of methods that have one.
    pub tolerance: Option<f64>,
    /// The largest distance of a body from where it should be, at any look until
    /// [`positions_until`](Prices::positions_until); none if that is before the first look.
    pub position: Option<f64>,
    /// The largest error of the energy, in its unit.
    pub energy: f64,
    /// Errors of the averages, each in the unit of the observable.
    pub averages: Vec<f64>,
    /// The exponent a with which the error of position grew with time, tᵃ, and that of energy.
    pub growth: [f64; 2],
    /// Seconds for each unit of simulated time, of one trajectory: the median of repeats.
    pub seconds: f64,
    /// By what part of it repeats differ.
    pub spread: f64,
    /// Steps in the pilot interval.
    pub steps: u64,
    /// Corrections of position equations in it, of linked bodies.
    pub corrections: Option<u64>,
    /// The order observed between this step and the longer one before it, in the position or, if that cannot be told,
    /// the energy.
    pub order: Option<f64>,
    /// Whether rounding decides here: a shorter step gives nothing.
    pub rounding: bool,
    /// Whether nothing that is cheaper is as exact; among rows in lanes, for those.
    pub front: bool,
}

/// A method that did not get far enough for a row.
#[derive(Debug, Clone)]
pub struct Refused {
    /// The method.
    pub method: Candidate,
    /// Why; none if the budget left no time.
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
    /// The front: rows than which nothing that is cheaper is as exact, the cheapest first; not those in lanes.
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

    /// Nanoseconds for each unit of simulated time at which errors of position (of energy, where positions cannot be
    /// told) reach 10⁻ᵈ, with the method: for d = 1 … 15 those that were reached. Between two rows errors and times are
    /// powers of the step.
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

    /// Where rounding takes over: the least error of position (of energy, where positions cannot be told) of a method
    /// whose shorter steps gave nothing.
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

    /// What errors are compared by.
    pub(super) fn quantity(&self) -> Quantity {
        if self.tells_positions() { Quantity::Position } else { Quantity::Energy }
    }

    /// Whether positions can be told on all of the pilot interval; else methods are compared by energy.
    #[must_use]
    pub fn tells_positions(&self) -> bool {
        self.positions_until > 0.999_999 * self.pilot
    }

    /// By what factor an error on the pilot interval is larger at the end of the whole run, at most.
    pub(super) fn grown(&self, price: &Price, what: Quantity) -> f64 {
        let Self { duration, pilot, lyapunov_time, .. } = *self;
        Longer { duration, pilot, lyapunov_time }.grown(price, what)
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
