//! Observers: they collect data from a run of a simulation or an ensemble.
//!
//! An [`Observer`] is shown a [`Sight`] of each trajectory (its state at one time) after every so many steps. The same
//! observers watch [a simulation](crate::run::simulation::Simulation::observe) and [an
//! ensemble](crate::run::ensemble::Ensemble::observe):
//!
//! | observer | data |
//! |---|---|
//! | [`Trajectory`] | times, positions and momenta, row by row; of a simulation multipliers too |
//! | [`Mean`], [`Histogram`] | mean, variance and distribution of a quantity |
//! | [`Section`] | crossings of a Poincaré section |
//! | [`ShadowEnergy`] | an energy that RATTLE conserves to a higher order than H |
//! | [`Recorder`] | a table of chosen quantities, in memory or passed to a file |
//! | [`Each`] | one observer for each trajectory of an ensemble |
//! | [`Progress`] | none; it calls a closure that shows the progress of the run |
//! | `(A, B)`, `[A; N]` | those of its members |
//!
//! ```
//! # use rattle::{Scene, State, Rattle, Trajectory, watch::{Each, Mean, Sight}};
//! # let scene = Scene::points::<1>(1);
//! # let start = |p: i32| State::at([0.0]).moving([f64::from(p)]);
//! let height = |now: &Sight<'_, 1>| now.position().x;
//!
//! let mut simulation = scene.simulate(start(1), Rattle::new(0.5))?;
//! let mut seen = (Mean::of(height), Trajectory::of(&simulation));
//! simulation.observe(100, 10, &mut seen)?;
//! assert_eq!((seen.0.number(), seen.1.shape()), (10, [11, 1, 1]));
//!
//! let mut ensemble = scene.ensemble((0..3).map(start), Rattle::new(0.5))?;
//! let (mean, paths) = ensemble.observe(100, 10, || (Mean::of(height), Each::of(Trajectory::new)));
//! assert_eq!((mean.number(), paths.get(2).unwrap().positions()[10]), (30, 100.0));
//! # Ok::<(), rattle::Error>(())
//! ```

pub mod each;
pub mod histogram;
pub(in crate::run) mod listening;
pub mod mean;
pub mod observer;
pub mod progress;
pub mod recorder;
pub mod section;
pub(crate) mod seen;
pub mod shadow;
pub mod sight;
pub mod trajectory;

pub use each::Each;
pub use histogram::Histogram;
pub use mean::Mean;
pub use observer::Observer;
pub use progress::Progress;
pub use recorder::{Column, Columns, Recorder, Rows, Sink};
pub use section::{Crossing, Section};
pub use shadow::{ShadowEnergy, quadratic_form};
pub use sight::Sight;
pub use trajectory::{Multipliers, Trajectory};
