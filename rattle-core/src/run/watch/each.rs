//! One observer for each trajectory.

use crate::error::Error;
use crate::run::watch::observer::Observer;
use crate::run::watch::sight::Sight;
use std::collections::BTreeMap;

/// One observer for each trajectory of an ensemble, made by `new` when the trajectory is first seen.
///
/// ```
/// # use rattle::{Rattle, Scene, State, Trajectory, watch::Each};
/// # let starts = (0..100).map(|i| State::at([0.0]).moving([f64::from(i)]));
/// # let mut ensemble = Scene::points::<1>(1).ensemble(starts, Rattle::new(0.5))?;
/// let paths = ensemble.observe(20, 2, || Each::of(Trajectory::new));
/// let path = paths.get(99).unwrap();
/// assert_eq!((path.shape(), path.positions()[1]), ([11, 1, 1], 99.0));
/// # Ok::<(), rattle::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Each<F, O> {
    new: F,
    observers: BTreeMap<usize, O>,
    /// That of a simulation, which hears multipliers before it is first shown the trajectory.
    unseen: Option<O>,
}

impl<F: Fn() -> O, O> Each<F, O> {
    /// Observers made by `new`, one for each trajectory.
    pub fn of(new: F) -> Self {
        Self { new, observers: BTreeMap::new(), unseen: None }
    }
}

impl<F, O> Each<F, O> {
    /// The observer of this trajectory; `None` if the trajectory failed before it was first seen.
    pub fn get(&self, trajectory: usize) -> Option<&O> {
        self.observers.get(&trajectory)
    }

    /// The numbers of the trajectories in order, each with its observer.
    pub fn iter(&self) -> impl Iterator<Item = (usize, &O)> {
        self.observers.iter().map(|(&trajectory, observer)| (trajectory, observer))
    }
}

impl<F: Fn() -> O, O> Each<F, O> {
    fn of_trajectory(&mut self, trajectory: usize) -> &mut O {
        let Self { new, observers, unseen } = self;
        observers.entry(trajectory).or_insert_with(|| unseen.take().unwrap_or_else(new))
    }

    /// The observer of the one trajectory of a simulation.
    fn of_simulation(&mut self) -> &mut O {
        let Self { new, observers, unseen } = self;
        match observers.values_mut().next() {
            Some(observer) => observer,
            None => unseen.get_or_insert_with(new),
        }
    }
}

impl<F: Fn() -> O, O: Observer<D>, const D: usize> Observer<D> for Each<F, O> {
    fn see(&mut self, before: &Sight<'_, D>, now: &Sight<'_, D>) {
        self.of_trajectory(now.trajectory).see(before, now);
    }

    fn sees_jumps(&self) -> bool {
        self.observers.values().next().is_none_or(Observer::sees_jumps)
    }

    fn jump(&mut self, from: &Sight<'_, D>, before: &Sight<'_, D>, after: &Sight<'_, D>) {
        self.of_trajectory(after.trajectory).jump(from, before, after);
    }

    fn join(&mut self, mut next: Self) {
        self.observers.append(&mut next.observers);
    }

    fn failure(&self) -> Option<Error> {
        self.observers.values().find_map(Observer::failure)
    }

    fn position_multiplier(&mut self, equation: usize, lambda: f64) {
        self.of_simulation().position_multiplier(equation, lambda);
    }

    fn momentum_multiplier(&mut self, equation: usize, mu: f64) {
        self.of_simulation().momentum_multiplier(equation, mu);
    }
}
