//! A progress bar for a run, with the time that is left.

use crate::watch::Progress;
use indicatif::{ProgressBar, ProgressStyle};

/// A bar is moved so often at most, by one sight or by several at once.
const CALLS: u64 = 1_000_000;

/// An observer that draws a progress bar on the terminal. It is full after `sights` observations: the number of steps
/// divided by `every`. Where standard error is not a terminal, nothing is drawn. For an ensemble, see [`Bar`].
///
/// ```
/// # use rattle::prelude::*;
/// # let mut simulation = Scene::point().simulate(State::at([0.0]), Rattle::new(0.1))?;
/// simulation.observe(100_000, 1000, &mut rattle::progress::bar(100))?;
/// # Ok::<(), rattle::Error>(())
/// ```
///
/// Join it with another observer by a tuple: `let mut both = (recorder, bar(100))`, then `&mut both`, and at last
/// `both.0.finish()?`.
pub fn bar(sights: u64) -> Progress<impl FnMut(u64)> {
    Bar::of(sights).observer()
}

/// A progress bar for several observers, such as those of an ensemble: each of its groups of trajectories has one, and
/// all of them move the same bar.
///
/// ```
/// # use rattle::prelude::*;
/// use rattle::progress::Bar;
/// # let starts = (0..100).map(|i| State::at([0.0]).moving([f64::from(i)]));
/// # let mut ensemble = Scene::points::<1>(1).ensemble(starts, Rattle::new(0.5))?;
/// let bar = Bar::of(10 * ensemble.len() as u64);
/// ensemble.observe(1000, 100, || bar.observer());
/// assert_eq!(bar.sights(), 1000);
/// # Ok::<(), rattle::Error>(())
/// ```
///
/// The bar goes when it is full. Trajectories that fail have fewer sights: then it goes when it is dropped.
#[derive(Clone, Debug)]
pub struct Bar {
    of: u64,
    bar: ProgressBar,
}

impl Bar {
    /// Full after `sights` observations: the number of steps divided by `every`, times the number of trajectories.
    #[must_use]
    pub fn of(sights: u64) -> Self {
        let bar = ProgressBar::new(sights); // hidden where there is no terminal
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} {percent} % {eta} left") {
            bar.set_style(style);
        }
        Self { of: sights, bar }
    }

    /// An observer that moves the bar.
    pub fn observer(&self) -> Progress<impl FnMut(u64) + use<>> {
        let Self { of, bar } = self.clone();
        Progress::of(of / CALLS, move |sights| {
            bar.inc(sights);
            if bar.position() >= of {
                bar.finish_and_clear();
            }
        })
    }

    /// Observations so far. What an observer has seen last it tells when it is dropped.
    #[must_use]
    pub fn sights(&self) -> u64 {
        self.bar.position()
    }
}
