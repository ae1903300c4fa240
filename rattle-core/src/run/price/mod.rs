//! What accuracy costs in computing time, measured before a run.
//!
//! ```text
//! scene.price(&start, duration)       errors and seconds of each method and step size, on a pilot interval
//! scene.within(1e-6)                  the fastest method and step size with this error, and the expected cost
//! simulation.estimate_error(&start)   the error of a finished simulation
//! ```
//!
//! ```
//! use rattle::prelude::*;
//! use rattle::surfaces::Sphere;
//!
//! let scene = Scene::on(Sphere { r: 1.0 });
//! let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 0.6, 0.8]);
//! let prices = scene.price(&start, 5.0).budget(1.0).measure()?;
//! println!("{prices}");
//! let mut planned = scene.within(1e-8).budget(1.0).simulate(&start, 5.0)?;
//! println!("{planned}");
//! let bill = planned.run()?;
//! let q = planned.simulation.positions().next().unwrap();
//! assert!((q.x - 5_f64.cos()).abs() < 1e-8, "{bill}");
//! # Ok::<(), rattle::Error>(())
//! ```
//!
//! Errors are measured against a reference: the motion computed by a method of high order with tolerances near
//! rounding. A second such method repeats it, and their difference estimates the error of the reference itself.

mod beside;
mod candidate;
mod chaos;
mod clock;
mod estimate;
mod ladder;
mod moving;
mod prices;
mod pricing;
mod reference;
mod set;
mod show;
mod within;

pub use candidate::{Candidate, Numbers};
pub use clock::Clock;
pub use estimate::Estimate;
pub use prices::{Average, Price, Prices, Refused};
pub use pricing::Pricing;
pub use within::{Planned, Spent, Within};
