//! Multipliers on their way to an observer.

use crate::motion::witness::Witness;
use crate::run::watch::observer::Observer;

/// Multipliers of a step that may still be made in another way: of its start or not, by equation.
#[derive(Debug, Default)]
pub(in crate::run) struct Held {
    told: Vec<(bool, usize, f64)>,
    /// How many of them stand.
    kept: usize,
}

/// Passes a step's multipliers on to an observer: at once, or, with `held`, when the step is taken.
pub(in crate::run) struct Listening<'a, O: ?Sized, const D: usize> {
    pub(in crate::run) observer: &'a mut O,
    pub(in crate::run) held: Option<&'a mut Held>,
}

impl<O: Observer<D> + ?Sized, const D: usize> Listening<'_, O, D> {
    #[inline(always)]
    fn hear(&mut self, at_start: bool, equation: usize, multiplier: f64) {
        if let Some(held) = &mut self.held {
            held.told.push((at_start, equation, multiplier));
        } else {
            self.pass_on(at_start, equation, multiplier);
        }
    }

    #[inline(always)]
    fn pass_on(&mut self, at_start: bool, equation: usize, multiplier: f64) {
        if at_start {
            self.observer.position_multiplier(equation, multiplier);
        } else {
            self.observer.momentum_multiplier(equation, multiplier);
        }
    }
}

impl<O: Observer<D> + ?Sized, const D: usize> Witness<f64> for Listening<'_, O, D> {
    #[inline(always)]
    fn position_multiplier(&mut self, equation: usize, lambda: f64) {
        self.hear(true, equation, lambda);
    }
    #[inline(always)]
    fn momentum_multiplier(&mut self, equation: usize, mu: f64) {
        self.hear(false, equation, mu);
    }
    fn forget(&mut self) {
        if let Some(held) = &mut self.held {
            held.told.truncate(held.kept);
        }
    }
    fn keep(&mut self) {
        if let Some(held) = &mut self.held {
            held.kept = held.told.len();
        }
    }
    #[inline(always)]
    fn taken(&mut self) {
        let Some(held) = self.held.take() else { return };
        held.kept = 0;
        for (at_start, equation, multiplier) in held.told.drain(..) {
            self.pass_on(at_start, equation, multiplier);
        }
        self.held = Some(held);
    }
}
