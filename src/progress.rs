//! A progress bar for a run, with the time that is left.

use crate::watch::Progress;
use indicatif::{ProgressBar, ProgressStyle};

/// An observer that draws a progress bar on the terminal. It is full after `sights` observations: the number of steps
/// divided by `every`, times the number of trajectories of an ensemble. Where standard error is not a terminal, nothing
/// is drawn.
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
    let bar = ProgressBar::new(sights); // hidden where there is no terminal
    if let Ok(style) = ProgressStyle::with_template("{wide_bar} {percent} % {eta} left") {
        bar.set_style(style);
    }
    Progress::of(1, move |sights| {
        bar.inc(sights);
        if Some(bar.position()) >= bar.length() {
            bar.finish_and_clear();
        }
    })
}
