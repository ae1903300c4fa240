//! Recorders: what is kept of a run, and only that.

/// Sees a simulation, of type `S`, after every step, and hears the multipliers during it.
///
/// For what can be read off the simulation itself a closure is enough, see
/// [`Simulation::run_with`](crate::run::simulation::Simulation::run_with); a pair of recorders is one too.
///
/// ```
/// # use rattle::Recorder;
/// /// The largest multiplier of the run.
/// struct Largest(f64);
///
/// impl<S> Recorder<S> for Largest {
///     fn record(&mut self, _now: &S) {}
///     fn position_multiplier(&mut self, _equation: usize, lambda: f64) {
///         self.0 = self.0.max(lambda.abs());
///     }
/// }
/// ```
pub trait Recorder<S> {
    /// Is shown the simulation after a step.
    fn record(&mut self, simulation: &S);
    /// Is told λ of the position equation of the step under way.
    fn position_multiplier(&mut self, _equation: usize, _lambda: f64) {}
    /// Is told μ of the momentum equation of the step under way.
    fn momentum_multiplier(&mut self, _equation: usize, _mu: f64) {}
}

impl<S, A: Recorder<S>, B: Recorder<S>> Recorder<S> for (A, B) {
    fn record(&mut self, simulation: &S) {
        self.0.record(simulation);
        self.1.record(simulation);
    }
    fn position_multiplier(&mut self, equation: usize, lambda: f64) {
        self.0.position_multiplier(equation, lambda);
        self.1.position_multiplier(equation, lambda);
    }
    fn momentum_multiplier(&mut self, equation: usize, mu: f64) {
        self.0.momentum_multiplier(equation, mu);
        self.1.momentum_multiplier(equation, mu);
    }
}

impl<S, R: Recorder<S>> Recorder<S> for &mut R {
    fn record(&mut self, simulation: &S) {
        (**self).record(simulation);
    }
    fn position_multiplier(&mut self, equation: usize, lambda: f64) {
        (**self).position_multiplier(equation, lambda);
    }
    fn momentum_multiplier(&mut self, equation: usize, mu: f64) {
        (**self).momentum_multiplier(equation, mu);
    }
}
