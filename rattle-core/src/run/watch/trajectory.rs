//! Trajectories in memory: times, positions and momenta, row by row.

use crate::error::Error;
use crate::motion::method::Method;
use crate::motion::system::System;
use crate::run::simulation::Simulation;
use crate::run::watch::observer::Observer;
use crate::run::watch::sight::Sight;
use nalgebra::SVector;

/// Times, positions and momenta of a run, row by row from its start; multipliers on request.
///
/// Positions and momenta have the shape [rows, bodies, D], with the last index fastest, as NumPy arrays and pages take
/// it. For an ensemble use one for each trajectory, by [`Each`](crate::run::watch::Each): rows are those of one
/// trajectory, and to be shown another is a panic. They have one shape, too: a run of another number of bodies or
/// coordinates ends with [`Error::Recorder`], and to join trajectories of several sizes is a panic.
///
/// ```
/// # use rattle::{Rattle, Scene, State, Trajectory};
/// # let start = State::of([[0.0, 1.0], [0.0, 2.0]]).moving([1.0, 0.0]);
/// let mut simulation = Scene::points(2).simulate(start, Rattle::new(0.1))?;
/// let mut trajectory = Trajectory::of(&simulation);
/// simulation.observe(100, 10, &mut trajectory)?; // every tenth step
/// assert_eq!(trajectory.shape(), [11, 2, 2]);
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "history")]
#[doc(alias = "output")]
#[doc(alias = "time series")]
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Trajectory {
    bodies: usize,
    coordinates: usize,
    /// The number of the trajectory in the ensemble, once it is known.
    number: Option<usize>,
    times: Vec<f64>,
    positions: Vec<f64>,
    momenta: Vec<f64>,
    multipliers: Option<Multipliers>,
    /// λ and μ of the step under way, one of each per equation; in a method of stages those of the last stage.
    under_way: Multipliers,
    failure: Option<Error>,
}

/// λ and μ of a run, one of each per equation and row, on the scale of M q̈ = −∇U + Gᵀλ.
///
/// They are those of the method's own equations: of `Rattle` the mean of μ and the next λ is λ(t) to second order. Of
/// `SymplecticEuler` the mean of both of a step is, of `Shake` μ belongs to the time before; `Geodesic` and `Baoab`
/// have λ for the free motion and μ for forces; those of `Brownian` are 2/(γh) times as large. Forces of constraints at
/// the rows' times, whatever the method, are `Sight::multipliers`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Multipliers {
    /// λ of the step that led to the row; in the first row λ(t₀) of the exact motion. NaN in an ensemble, where
    /// observers do not receive multipliers.
    pub position: Vec<f64>,
    /// μ of the step that led to the row; in the first row λ(t₀) of the exact motion.
    pub momentum: Vec<f64>,
}

impl Trajectory {
    /// An empty trajectory. Its first row will be the state before the first observed step.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A trajectory whose first row is the present state of the simulation.
    pub fn of<Y: System<f64, D>, S: Method, const D: usize>(simulation: &Simulation<Y, S, D>) -> Self {
        let mut trajectory = Self::new();
        trajectory.row(simulation.time(), simulation.positions(), simulation.momenta());
        trajectory
    }

    /// As [`of`](Self::of), with the multipliers λ and μ of the step that led to each row.
    pub fn with_multipliers<Y: System<f64, D>, S: Method, const D: usize>(
        simulation: &Simulation<Y, S, D>,
    ) -> Self {
        let position: Vec<f64> = simulation.multipliers();
        let unknown = vec![f64::NAN; position.len()];
        let under_way = Multipliers { position: unknown.clone(), momentum: unknown };
        let at_start = Multipliers { momentum: position.clone(), position };
        Self { multipliers: Some(at_start), under_way, ..Self::of(simulation) }
    }

    fn row<const D: usize>(
        &mut self,
        time: f64,
        positions: impl ExactSizeIterator<Item = SVector<f64, D>>,
        momenta: impl Iterator<Item = SVector<f64, D>>,
    ) {
        (self.bodies, self.coordinates) = (positions.len(), D);
        self.times.push(time);
        positions.for_each(|q| self.positions.extend(q.iter()));
        momenta.for_each(|p| self.momenta.extend(p.iter()));
    }

    /// Takes the number of the trajectory whose rows come next, which is that of the rows before.
    #[track_caller]
    fn follow(&mut self, next: Option<usize>) {
        if let (Some(own), Some(next)) = (self.number, next) {
            let what = "rows of trajectories";
            assert!(own == next, "{what} {own} and {next} are no one path: take `Each::of(Trajectory::new)`");
        }
        self.number = self.number.or(next);
    }

    /// Rows, bodies, and coordinates of a body: the shape of positions and momenta.
    #[must_use]
    pub fn shape(&self) -> [usize; 3] {
        [self.times.len(), self.bodies, self.coordinates]
    }

    /// Time of each row.
    #[must_use]
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Positions, shape [rows, bodies, D].
    #[must_use]
    pub fn positions(&self) -> &[f64] {
        &self.positions
    }

    /// The positions of one body, row by row, D coordinates each.
    ///
    /// # Panics
    /// If there is no such body.
    #[track_caller]
    pub fn path(&self, body: usize) -> impl ExactSizeIterator<Item = &[f64]> {
        assert!(body < self.bodies, "body {body} of {}", self.bodies);
        self.positions.chunks_exact(self.coordinates).skip(body).step_by(self.bodies)
    }

    /// Momenta, shape [rows, bodies, D].
    #[must_use]
    pub fn momenta(&self) -> &[f64] {
        &self.momenta
    }

    /// The number of equations whose multipliers are kept; 0 if they were not asked for.
    #[must_use]
    pub fn equations(&self) -> usize {
        self.under_way.position.len()
    }

    /// The multipliers, shape [rows, equations] each, if they were asked for; on surfaces a body has one equation.
    #[must_use]
    pub fn multipliers(&self) -> Option<&Multipliers> {
        self.multipliers.as_ref()
    }
}

impl<const D: usize> Observer<D> for Trajectory {
    /// # Panics
    /// If it is another trajectory than before.
    fn see(&mut self, before: &Sight<'_, D>, now: &Sight<'_, D>) {
        self.follow(Some(now.trajectory));
        let row = |sight: &Sight<'_, D>, trajectory: &mut Self| {
            let (positions, momenta) = (sight.positions.iter().copied(), sight.momenta.iter().copied());
            trajectory.row(sight.time, positions, momenta);
        };
        if self.times.is_empty() {
            row(before, self);
        }
        if [self.bodies, self.coordinates] != [now.positions.len(), D] {
            let why = if self.bodies == now.positions.len() {
                format!("places in them have {} coordinates, and here {D}", self.coordinates)
            } else {
                format!("they are of {} bodies, and here are {}", self.bodies, now.positions.len())
            };
            self.failure = Some(Error::Recorder { rows: self.times.len() as u64, why });
            return;
        }
        row(now, self);
        if let Some(rows) = &mut self.multipliers {
            for (rows, under_way) in [
                (&mut rows.position, &mut self.under_way.position),
                (&mut rows.momentum, &mut self.under_way.momentum),
            ] {
                rows.extend(under_way.iter());
                under_way.fill(f64::NAN);
            }
        }
    }

    /// # Panics
    /// If both have rows, and those of `next` are of another trajectory or have another shape.
    fn join(&mut self, next: Self) {
        self.failure = self.failure.take().or(next.failure);
        if next.times.is_empty() {
            return;
        }
        self.follow(next.number);
        let fits = self.times.is_empty() || self.shape()[1..] == [next.bodies, next.coordinates];
        let both = [[self.bodies, self.coordinates], [next.bodies, next.coordinates]];
        assert!(
            fits,
            "trajectories of {both:?} bodies and coordinates have no common shape: take `Each::of(Trajectory::new)`"
        );
        (self.bodies, self.coordinates) = (next.bodies, next.coordinates);
        if let Some(rows) = &mut self.multipliers {
            let unknown = vec![f64::NAN; next.times.len() * self.under_way.position.len()];
            let theirs =
                next.multipliers.unwrap_or(Multipliers { momentum: unknown.clone(), position: unknown });
            rows.position.extend(theirs.position);
            rows.momentum.extend(theirs.momentum);
        }
        self.times.extend(next.times);
        self.positions.extend(next.positions);
        self.momenta.extend(next.momenta);
    }

    fn failure(&self) -> Option<Error> {
        self.failure.clone()
    }

    fn position_multiplier(&mut self, equation: usize, lambda: f64) {
        if let Some(under_way) = self.under_way.position.get_mut(equation) {
            *under_way = lambda;
        }
    }

    fn momentum_multiplier(&mut self, equation: usize, mu: f64) {
        if let Some(under_way) = self.under_way.momentum.get_mut(equation) {
            *under_way = mu;
        }
    }
}
