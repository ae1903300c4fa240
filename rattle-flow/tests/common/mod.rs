//! A method with something of the test's own around each step.

use rattle_flow::{Conservative, Flow, Method, StepInfo, Trouble};

/// The conservative method, whose steps are made by `around`: it is told the length of the step, the guess, and what
/// makes the step from a guess.
pub(crate) struct Around<F> {
    inner: Conservative,
    around: F,
}

/// What makes a step from a guess.
pub(crate) type Step<'a> = dyn FnMut(&mut [f64]) -> Result<StepInfo, Trouble> + 'a;

pub(crate) fn around<F>(flow: &Flow, around: F) -> Around<F>
where
    F: FnMut(f64, &mut [f64], &mut Step<'_>) -> Result<StepInfo, Trouble> + Send,
{
    Around { inner: Conservative::of(flow), around }
}

impl<F> Method for Around<F>
where
    F: FnMut(f64, &mut [f64], &mut Step<'_>) -> Result<StepInfo, Trouble> + Send,
{
    fn step(
        &mut self,
        flow: &Flow,
        depth: &[f64],
        guess: &mut [f64],
        step: f64,
        sources: (&[f64], &[f64]),
    ) -> Result<StepInfo, Trouble> {
        let Self { inner, around } = self;
        around(step, guess, &mut |guess| inner.step(flow, depth, guess, step, sources))
    }
    fn undo(&mut self) {
        self.inner.undo();
    }
    fn mean_flux(&self, flow: &Flow, depth: &[f64]) -> f64 {
        self.inner.mean_flux(flow, depth)
    }
    fn flux(&self, flow: &Flow, depth: &[f64]) -> Vec<[f64; 2]> {
        self.inner.flux(flow, depth)
    }
}
