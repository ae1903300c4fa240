//! When flows act on trajectories side by side, and what their lanes draw: the same for bodies on surfaces, linked and
//! rigid ones.

use crate::effect::interval::Half;
use crate::effect::noise::Noise;
use crate::effect::ornstein_uhlenbeck::OrnsteinUhlenbeck;
use crate::motion::parts::Given;
use crate::number::clock::after_steps;
use crate::number::lanes::{Fused, Lanes};
use crate::number::philox::unit;
use crate::number::real::{Real, Scalar};
use crate::run::ensemble::engine::{Draws, Stuck};
use crate::systems::network::in_lanes::{Number, Numbers};
use std::array::from_fn;
use std::f64::consts::TAU;

/// When flows act: before a step or after it, after so many.
#[derive(Clone, Copy)]
pub(super) struct When {
    pub(super) half: Half,
    pub(super) steps: u64,
}

/// The turn of a flow: which one acts, before which so many acted in this step, and when.
#[derive(Clone, Copy)]
pub(super) struct Turn {
    pub(super) number: usize,
    pub(super) place: u64,
    pub(super) when: When,
}

/// What moves in the rhythm of flows.
pub(super) trait InRhythm {
    /// Has all flows act in all lanes.
    fn act(&mut self, when: When) -> Result<(), Stuck>;
    /// Kicks all lanes before a step, after flows have acted, and makes its first guesses: what flows have changed is
    /// not extrapolated.
    fn lead(&mut self) -> Result<(), Stuck>;
    /// Moves all lanes through this part of the step after so many.
    fn advance(&mut self, part: usize, steps: u64) -> Result<(), Stuck>;
    /// Makes first guesses for this part, before which flows have acted; else those from the steps before stand.
    #[inline(always)]
    fn guess(&mut self, _part: usize) -> Result<(), Stuck> {
        Ok(())
    }
    /// Forgets momenta, and what was guessed from them, where momenta are drawn anew.
    #[inline(always)]
    fn forget(&mut self) {}
}

/// When flows act in a step, and the random numbers of the lanes.
#[derive(Clone)]
pub(super) struct Rhythm<const W: usize> {
    /// After how many parts of a step flows act; 0 where half of them act before the step and half after it.
    pub(super) after: usize,
    /// Whether they act once in a step, not in two halves.
    at_once: bool,
    /// Whether they draw momenta anew, which are forgotten after each step.
    pub(super) renews: bool,
    /// The step, and the time for which flows act each time.
    h: f64,
    pub(super) time: f64,
    /// Whether a flow changes with time.
    changes: bool,
    draws: [Draws; W],
}

impl<const W: usize> Rhythm<W> {
    /// Of steps of h, after so many parts of each; whether flows can act once in a step, and change with time.
    pub(super) fn of(after: usize, h: f64, once: bool, changes: bool) -> Self {
        let at_once = after > 0 && once;
        let time = if at_once { h } else { 0.5 * h };
        Self { after, at_once, renews: false, h, time, changes, draws: [Draws::default(); W] }
    }

    /// Of momenta that are drawn anew before each step of h.
    pub(super) fn renewing(h: f64) -> Self {
        Self { renews: true, ..Self::of(0, h, false, false) }
    }

    /// Moves lanes through the step after so many, which has so many parts.
    #[inline(always)]
    pub(super) fn step(&self, lanes: &mut impl InRhythm, steps: u64, parts: usize) -> Result<(), Stuck> {
        let [before, after] = [Half::Before, Half::After].map(|half| When { half, steps });
        if self.after == 0 {
            lanes.act(before)?;
            lanes.lead()?;
        }
        for part in 0..parts {
            lanes.advance(part, steps)?;
            if part + 1 == self.after {
                if !self.at_once {
                    lanes.act(after)?;
                }
                lanes.act(before)?;
                lanes.guess((part + 1) % parts)?;
            }
        }
        if self.renews {
            lanes.forget();
        } else if self.after == 0 {
            lanes.act(after)?;
        }
        Ok(())
    }

    /// Has lane `to` draw what lane `from` does.
    pub(super) fn copy(&mut self, from: usize, to: usize) {
        self.draws[to] = self.draws[from];
    }

    /// Says where a lane starts.
    pub(super) fn draw_as(&mut self, lane: usize, draws: Draws) {
        self.draws[lane] = draws;
    }

    /// Where the random numbers of a lane are after so many steps.
    #[inline(always)]
    pub(super) fn noise(&self, lane: usize, steps: u64) -> Noise {
        let Draws { trajectory, steps: before, .. } = self.draws[lane];
        Noise { trajectory, step: before.wrapping_add(steps), ..Noise::default() }
    }

    /// The time of a lane after so many steps, as flows are told it.
    pub(super) fn now(&self, lane: usize, steps: u64) -> f64 {
        let start = self.draws[lane].time;
        if self.changes { after_steps(start, steps, self.h).0 } else { start.0 }
    }

    /// The time of a lane at this turn, as flows are told it.
    #[inline(always)]
    pub(super) fn time_of(&self, lane: usize, Turn { when: When { half, steps }, .. }: Turn) -> f64 {
        let passed = match (self.changes, half) {
            (false, _) => 0.0,
            (true, _) if self.after > 0 => 0.5 * self.h,
            (true, Half::Before) => 0.0,
            (true, Half::After) => self.h,
        };
        self.now(lane, steps) + passed
    }

    /// What a flow is given in a lane at this turn, with nothing laid beside.
    #[inline(always)]
    pub(super) fn given<T: Scalar, const D: usize>(
        &self,
        lane: usize,
        Turn { number, place, when: When { half, steps } }: Turn,
    ) -> Given<'_, T, D> {
        let noise = Noise { effect: number as u64, place, ..self.noise(lane, steps) };
        Given::of(self.time, half == Half::Before, noise)
    }

    /// The turns of so many flows.
    #[inline(always)]
    pub(super) fn turns(&self, flows: usize, when: When) -> impl Iterator<Item = Turn> + use<W> {
        let second = !self.at_once && (when.half == Half::After) == (self.after == 0);
        (0..flows).map(move |i| {
            let number = if when.half == Half::Before { i } else { flows - 1 - i };
            Turn { number, place: (if second { flows + i } else { i }) as u64, when }
        })
    }

    /// Draws normal numbers of each lane, those of [`Noise::normal`] for one body: with these seeds by the flow whose
    /// turn it is, or by the method.
    #[inline(always)]
    pub(super) fn draw_all(&self, seed: &[u64; W], turn: Turn, numbers: &mut [[Number; W]]) {
        for (draw, four) in (0..).zip(numbers.chunks_mut(4)) {
            self.draw(seed, turn, draw, four);
        }
    }

    /// Draws up to four of them, by draw number `draw`.
    #[inline(always)]
    pub(super) fn draw(
        &self,
        seed: &[u64; W],
        Turn { number, place, when }: Turn,
        draw: u64,
        numbers: &mut [[Number; W]],
    ) {
        let mut words = [[0; W]; 4];
        let effect = if self.renews { Noise::METHOD } else { number as u64 };
        for l in 0..W {
            let noise = Noise { effect, place, ..self.noise(l, when.steps) };
            for (words, drawn) in words.iter_mut().zip(noise.words(seed[l], draw)) {
                words[l] = drawn;
            }
        }
        for (two, words) in numbers.chunks_mut(2).zip(words.as_chunks().0) {
            normal(words, two);
        }
    }
}

/// An Ornstein–Uhlenbeck process.
#[derive(Clone)]
pub(super) struct Bath<const W: usize> {
    pub(super) lost: Numbers<W>,
    /// Whether there is noise; √variance, and the seeds.
    pub(super) draws: bool,
    pub(super) deviation: Numbers<W>,
    pub(super) seed: [u64; W],
}

impl<const W: usize> Bath<W> {
    /// Those of W lanes.
    pub(super) fn of(lanes: &[OrnsteinUhlenbeck]) -> Self {
        Self {
            lost: Lanes(from_fn(|l| Fused(lanes[l].lost))),
            draws: lanes.iter().any(|of| of.variance != 0.0),
            deviation: Lanes(from_fn(|l| Fused(lanes[l].variance.sqrt()))),
            seed: from_fn(|l| lanes[l].seed),
        }
    }

    pub(super) fn copy(&mut self, from: usize, to: usize) {
        (self.lost.0[to], self.deviation.0[to]) = (self.lost.0[from], self.deviation.0[from]);
        self.seed[to] = self.seed[from];
    }
}

/// A normal number, or two, for each lane, of two words (G. Box, M. Muller).
#[inline(always)]
fn normal<const L: usize>([a, b]: &[[u64; L]; 2], numbers: &mut [[Fused<f64>; L]]) {
    let (mut cosines, mut sines) = ([Fused(0.0); L], [Fused(0.0); L]);
    for l in 0..L {
        let radius = (Fused(-2.0) * Fused(unit(a[l])).ln()).sqrt();
        let (sin, cos) = (Fused(TAU) * Fused(unit(b[l]))).sin_cos();
        (cosines[l], sines[l]) = (radius * cos, radius * sin);
    }
    for (numbers, drawn) in numbers.iter_mut().zip([cosines, sines]) {
        *numbers = drawn;
    }
}
