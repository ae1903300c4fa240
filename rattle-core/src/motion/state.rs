//! States: positions and momenta of all bodies, as a start or as read from a simulation.

use crate::motion::bodies::Body;
use crate::motion::identity::Identity;
use nalgebra::SVector;

/// What a method remembered, and whose memory it is.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Remembered {
    pub(crate) method: Identity,
    /// What was moved, in the state that remembers.
    pub(crate) system: Identity,
    pub(crate) numbers: Box<[f64]>,
}

/// The D coordinates of a body: an array, a vector of `nalgebra`, or anything that converts into one.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no place or momentum of a body here",
    label = "as many numbers `f64` as the scene has coordinates: an array such as `[0.0, 0.0, 1.0]`, or a vector of `nalgebra`",
    note = "of a `Vec` or a slice: `<[f64; 3]>::try_from(numbers)`, which fails where there are not three",
    note = "places of several bodies: `State::of([[0.0, 0.0], [1.0, 0.0]])`"
)]
pub trait Coordinates<const D: usize> {
    /// The coordinates as an array.
    fn coordinates(self) -> [f64; D];
}

#[diagnostic::do_not_recommend]
impl<X: Into<SVector<f64, D>>, const D: usize> Coordinates<D> for X {
    fn coordinates(self) -> [f64; D] {
        self.into().into()
    }
}

/// Positions and momenta of all bodies, each with `D` coordinates.
///
/// Momenta are p = M v; they are velocities as long as the scene names no masses.
///
/// A state that is read from a simulation also holds the low digits of its compensated sums, and the memory of the
/// method and the effects. A simulation that starts from it, in the same scene with the same method, continues bit for
/// bit; where 24 or more molecules are alike, to rounding: their first steps from a state are looked at one by one, and
/// only a [checkpoint](crate::run::checkpoint::Checkpoint) holds what was seen before. With other momenta, or in a
/// scene of other energies, accelerations or types of effects, the memory is dropped; with another method that of the
/// method is, and headings of [`SelfPropulsion`](crate::effect::SelfPropulsion) stay.
///
/// ```
/// use rattle::State;
///
/// let one = State::at([0.0, 0.0, 1.0]).moving([1.0, 0.0, 0.0]);
/// let two = State::of([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]); // at rest
/// assert_eq!((one.len(), two.len()), (1, 2));
/// ```
#[doc(alias = "initial condition")]
#[doc(alias = "restart")]
#[derive(Debug, Clone, PartialEq)]
pub struct State<const D: usize> {
    pub(crate) bodies: Vec<Body<f64, D>>,
    /// The time of the start, and what rounding took from it; matters to moving constraints.
    pub(crate) time: f64,
    pub(crate) time_low: f64,
    pub(crate) remembered: Option<Remembered>,
    /// Steps taken since the first start: random numbers go on from there.
    pub(crate) steps: u64,
    /// The number of the trajectory, if it was given one.
    pub(crate) number: Option<u64>,
    /// How many momenta were given, at least, if not one for each body.
    pub(crate) other_momenta: Option<usize>,
}

impl<const D: usize> State<D> {
    /// One body at rest at `position`.
    #[must_use]
    pub fn at(position: impl Coordinates<D>) -> Self {
        Self::of([position])
    }

    /// Bodies at rest at these positions.
    #[must_use]
    pub fn of<Q: Coordinates<D>>(positions: impl IntoIterator<Item = Q>) -> Self {
        let zero = [0.0; D];
        let at_rest = |q: Q| Body { q: q.coordinates(), q_low: zero, p: zero, p_low: zero };
        let bodies = positions.into_iter().map(at_rest).collect();
        let (time, time_low, steps) = (0.0, 0.0, 0);
        Self { bodies, time, time_low, remembered: None, steps, number: None, other_momenta: None }
    }

    /// The same state, with `momentum` for every body.
    #[doc(alias = "velocity")]
    #[doc(alias = "initial velocity")]
    #[must_use]
    pub fn moving(mut self, momentum: impl Coordinates<D>) -> Self {
        let p = momentum.coordinates();
        for body in &mut self.bodies {
            (body.p, body.p_low) = (p, [0.0; D]);
        }
        (self.remembered, self.other_momenta) = (None, None);
        self
    }

    /// The same state with these momenta, one for each body, in their order. A list of another length is refused when
    /// the simulation is made. No more than one too many is asked for: of momenta without end `take` as many as there
    /// are bodies.
    #[must_use]
    pub fn with_momenta<P: Coordinates<D>>(mut self, momenta: impl IntoIterator<Item = P>) -> Self {
        let mut momenta = momenta.into_iter();
        let mut given = 0;
        for (body, p) in self.bodies.iter_mut().zip(&mut momenta) {
            (body.p, body.p_low) = (p.coordinates(), [0.0; D]);
            given += 1;
        }
        let others = match momenta.size_hint() {
            (others, Some(most)) if others == most => others,
            _ => momenta.take(1).count(), // maybe without end
        };
        given = others.saturating_add(given);
        self.remembered = None;
        self.other_momenta = (given != self.bodies.len()).then_some(given);
        self
    }

    /// The same state at time `time`; by default it is 0.
    #[must_use]
    pub fn at_time(mut self, time: f64) -> Self {
        (self.time, self.time_low) = (time, 0.0);
        self
    }

    /// The same state with this trajectory number, on which [random numbers](crate::effect::Noise) depend.
    ///
    /// By default it is 0 in a simulation, and the index of the trajectory in an ensemble. So the third state of an
    /// ensemble, numbered 2, continues in a simulation with the noise that it would have in the ensemble.
    #[must_use]
    pub fn numbered(mut self, trajectory: u64) -> Self {
        self.number = Some(trajectory);
        self
    }

    /// The same state after `steps` steps, on whose number [random numbers](crate::effect::Noise) depend.
    ///
    /// So a run whose positions and momenta were read from a file continues with the noise of the next step. By default
    /// a run begins with the noise of the first step.
    #[must_use]
    pub fn after_steps(mut self, steps: u64) -> Self {
        self.steps = steps;
        self
    }

    /// The number of steps since the first start.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The time.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// The number of bodies.
    #[must_use]
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// Whether there is no body.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// The positions, in the order of the bodies.
    pub fn positions(&self) -> impl ExactSizeIterator<Item = SVector<f64, D>> + '_ {
        self.bodies.iter().map(|body| body.q.into())
    }

    /// The momenta, in the order of the bodies.
    pub fn momenta(&self) -> impl ExactSizeIterator<Item = SVector<f64, D>> + '_ {
        self.bodies.iter().map(|body| body.p.into())
    }
}
