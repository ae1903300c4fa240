//! The trait of observers.

use crate::error::Error;
use crate::run::watch::sight::Sight;

/// Watches the trajectory of a [simulation](crate::run::simulation::Simulation::observe), or those of an
/// [ensemble](crate::run::ensemble::Ensemble::observe), as they are computed. A pair and an array of observers are
/// observers too.
///
/// In an ensemble each group of trajectories has its own observer. At the end these observers are joined in the order
/// of the trajectories, so the result is the same, bit for bit, for any number of threads.
///
/// ```
/// # use rattle::{Rattle, Scene, State, watch::{Observer, Sight}};
/// /// The largest height and the largest multiplier of a run.
/// #[derive(Default)]
/// struct Largest { height: f64, multiplier: f64 }
///
/// impl Observer<3> for Largest {
///     fn see(&mut self, _before: &Sight<'_, 3>, now: &Sight<'_, 3>) {
///         self.height = self.height.max(now.position().z);
///     }
///     fn join(&mut self, next: Self) {
///         self.height = self.height.max(next.height);
///         self.multiplier = self.multiplier.max(next.multiplier);
///     }
///     fn position_multiplier(&mut self, _equation: usize, lambda: f64) {
///         self.multiplier = self.multiplier.max(lambda.abs());
///     }
/// }
///
/// let sphere = Scene::on(rattle::surfaces::Sphere { r: 1.0 });
/// let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 0.6, 0.8]);
/// let mut simulation = sphere.simulate(start, Rattle::new(0.01))?;
/// let mut largest = Largest::default();
/// simulation.observe(1000, 1, &mut largest)?;
/// assert!((largest.height - 0.8).abs() < 1e-4);
/// assert!((largest.multiplier - 0.5).abs() < 1e-4); // |v|²/|∇g|, and ∇g has length 2
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "callback")]
#[doc(alias = "hook")]
pub trait Observer<const D: usize> {
    /// Called with a trajectory as it is now, and as it was at the previous sight; at the first sight, as it was at the
    /// start.
    fn see(&mut self, before: &Sight<'_, D>, now: &Sight<'_, D>);
    /// Whether [`jump`](Self::jump) is to be called. An observer that hands sights on to others must hand on this
    /// question and jumps too.
    fn sees_jumps(&self) -> bool {
        false
    }
    /// Called in a simulation at each instant of the steps up to its last sight at which momenta jump: at
    /// [impacts](crate::run::simulation::Simulation::collide) and at
    /// [edges](crate::run::simulation::Simulation::over_kinks). It is shown the trajectory right before and right after
    /// the jump. `from` is the last sight, or right after the jump before, if that was later; in between momenta do not
    /// jump. Jumps come in their order, before the sight that follows them. The number of steps is that before the step
    /// in which they happen. Ensembles have no jumps.
    fn jump(&mut self, _from: &Sight<'_, D>, _before: &Sight<'_, D>, _after: &Sight<'_, D>) {}
    /// Adds the data of the observer of the next trajectories. Not called in a simulation, which is one trajectory.
    fn join(&mut self, next: Self)
    where
        Self: Sized;
    /// Why the observer has failed, if it has: a simulation then ends its run with this error at the last sight, and an
    /// ensemble ends its run some steps later.
    #[inline(always)]
    fn failure(&self) -> Option<Error> {
        None
    }
    /// Called with λ of a position equation, in every step of a simulation, also in one that fails at its end unless
    /// steps may be divided. A step that is divided, at [impacts](crate::run::simulation::Simulation::collide) say,
    /// tells of its parts in turn. Not called in ensembles; see [`Sight::multipliers`].
    #[inline(always)]
    fn position_multiplier(&mut self, _equation: usize, _lambda: f64) {}
    /// Called with μ of a momentum equation, likewise.
    #[inline(always)]
    fn momentum_multiplier(&mut self, _equation: usize, _mu: f64) {}
}

impl<A: Observer<D>, B: Observer<D>, const D: usize> Observer<D> for (A, B) {
    #[inline(always)]
    fn see(&mut self, before: &Sight<'_, D>, now: &Sight<'_, D>) {
        self.0.see(before, now);
        self.1.see(before, now);
    }
    fn sees_jumps(&self) -> bool {
        self.0.sees_jumps() || self.1.sees_jumps()
    }
    fn jump(&mut self, from: &Sight<'_, D>, before: &Sight<'_, D>, after: &Sight<'_, D>) {
        self.0.jump(from, before, after);
        self.1.jump(from, before, after);
    }
    fn join(&mut self, next: Self) {
        self.0.join(next.0);
        self.1.join(next.1);
    }
    fn failure(&self) -> Option<Error> {
        self.0.failure().or_else(|| self.1.failure())
    }
    #[inline(always)]
    fn position_multiplier(&mut self, equation: usize, lambda: f64) {
        self.0.position_multiplier(equation, lambda);
        self.1.position_multiplier(equation, lambda);
    }
    #[inline(always)]
    fn momentum_multiplier(&mut self, equation: usize, mu: f64) {
        self.0.momentum_multiplier(equation, mu);
        self.1.momentum_multiplier(equation, mu);
    }
}

impl<A: Observer<D>, const N: usize, const D: usize> Observer<D> for [A; N] {
    #[inline(always)]
    fn see(&mut self, before: &Sight<'_, D>, now: &Sight<'_, D>) {
        self.iter_mut().for_each(|member| member.see(before, now));
    }
    fn sees_jumps(&self) -> bool {
        self.iter().any(Observer::sees_jumps)
    }
    fn jump(&mut self, from: &Sight<'_, D>, before: &Sight<'_, D>, after: &Sight<'_, D>) {
        self.iter_mut().for_each(|member| member.jump(from, before, after));
    }
    fn join(&mut self, next: Self) {
        self.iter_mut().zip(next).for_each(|(member, next)| member.join(next));
    }
    fn failure(&self) -> Option<Error> {
        self.iter().find_map(Observer::failure)
    }
    #[inline(always)]
    fn position_multiplier(&mut self, equation: usize, lambda: f64) {
        self.iter_mut().for_each(|member| member.position_multiplier(equation, lambda));
    }
    #[inline(always)]
    fn momentum_multiplier(&mut self, equation: usize, mu: f64) {
        self.iter_mut().for_each(|member| member.momentum_multiplier(equation, mu));
    }
}
