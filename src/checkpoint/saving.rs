//! Runs that save themselves.

use super::error::CheckpointError;
use super::file::{encode, make_way, read};
use super::save::Save;
use crate::Error;
use rattle_core::run::checkpoint::Checkpoint;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Steps between two looks at the clock and at whether to stop are as many as take about so long, …
const LOOK: Duration = Duration::from_millis(5);
/// … and at most so many.
const MOST: u64 = 1 << 20;

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// All steps were taken.
    Done,
    /// It was told to stop, and saved.
    Stopped,
}

/// Where and when a run is saved: at its end and, if asked for, every so many steps or seconds.
#[doc(alias = "restart")]
#[derive(Debug, Clone)]
#[must_use = "it says how to save, and saves when it runs something"]
pub struct Saving {
    path: PathBuf,
    every: Option<u64>,
    seconds: Option<Duration>,
    stop: Option<Arc<AtomicBool>>,
}

impl Saving {
    /// Saves a run to this file when it ends. Missing folders are made before the first step. To save at once, call
    /// [`simulation.save(path)`](super::Save::save).
    pub fn to(path: impl AsRef<Path>) -> Self {
        Self { path: path.as_ref().into(), every: None, seconds: None, stop: None }
    }

    /// Also saves the run after every `steps` steps, counted from the very start of the simulation, also where it was
    /// restored; 0 counts as 1.
    pub fn every(mut self, steps: u64) -> Self {
        self.every = Some(steps.max(1));
        self
    }

    /// Also saves the run when this much wall-clock time has passed since it was saved last.
    pub fn every_time(mut self, passed: Duration) -> Self {
        self.seconds = Some(passed);
        self
    }

    /// Ends and saves the run soon after `stop` has become true: within some milliseconds, after a whole step. (An
    /// ensemble first finishes its present stretch of 1024 steps.)
    pub fn until(mut self, stop: Arc<AtomicBool>) -> Self {
        self.stop = Some(stop);
        self
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Restores the run from the file if there is one; returns whether there was. Remove a link that leads nowhere to
    /// begin anew.
    ///
    /// # Errors
    /// As [`Save::restore`]; [`CheckpointError::Io`] for a link that leads nowhere.
    pub fn restore(&self, run: &mut (impl Checkpoint + ?Sized)) -> Result<bool, CheckpointError> {
        let is_none = |error: &io::Error| error.kind() == io::ErrorKind::NotFound;
        match run.restore(&self.path) {
            Ok(()) => Ok(true),
            Err(CheckpointError::Io { source, .. }) if is_none(&source) => {
                // The file, or a folder on the way to it.
                if !self.path.ancestors().any(|path| path.is_symlink() && !path.exists()) {
                    return Ok(false);
                }
                let source = io::Error::new(source.kind(), format!("a link that leads nowhere: {source}"));
                Err(CheckpointError::Io { path: self.path.clone(), source })
            }
            Err(error) => Err(error),
        }
    }

    /// Takes steps until `steps` have been taken since the very start of the simulation, and saves the run. If there
    /// are as many already, none is taken, and the run is saved where the file is not one of it as it is.
    ///
    /// # Errors
    /// [`CheckpointError::Step`] for a step that cannot be taken; the steps before it are saved.
    /// [`CheckpointError::Io`] where the run cannot be saved: before the first step where that is known then, else it
    /// stands at the step that was to be saved. The last checkpoint is unchanged.
    pub fn run_to(&self, run: &mut (impl Checkpoint + ?Sized), steps: u64) -> Result<Ended, CheckpointError> {
        self.run_to_by(run, steps, 1, |run, part, _| run.take_steps(part))
    }

    /// As [`run_to`](Self::run_to), where `take` takes the steps, and may watch them: in parts that end at multiples of
    /// `every` steps, counted from the very start of the simulation, and at the end. `take` is told how many steps to
    /// take, and after how many of them to look, again and again. This is `every`, but less in the first part after a
    /// start from a step that is no multiple: so that it looks at multiples only, as if the run had never ended.
    ///
    /// A recorder that is flushed in `take` has all rows in its file that come before a checkpoint, also where it
    /// fails: then the last checkpoint stays. (`NpzParts` and `Parquet` can be read only when they are finished.) After
    /// a kill the file may have rows from behind the checkpoint too, which come again: let each start write a file of
    /// its own, or drop the rows whose step is past that of the checkpoint.
    ///
    /// ```
    /// # use rattle::{checkpoint::Saving, prelude::*, surfaces::Sphere};
    /// # use rattle::watch::{Columns, Recorder, Rows};
    /// # let folder = tempfile::tempdir()?;
    /// # let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 1.0, 0.0]);
    /// # let rows = Rows::default();
    /// let mut simulation = Scene::on(Sphere { r: 1.0 }).simulate(start, Rattle::new(0.01))?;
    /// let mut recorder = Recorder::of(&Columns::<3>::new().positions(), rows);
    /// let saving = Saving::to(folder.path().join("run.rattle")).every(1000);
    /// saving.run_to_by(&mut simulation, 10_000, 100, |simulation, steps, every| {
    ///     simulation.observe(steps, every, &mut recorder)?;
    ///     recorder.flush()
    /// })?;
    /// assert_eq!(recorder.finish()?.len(), 100);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`run_to`](Self::run_to); [`CheckpointError::Step`] also for other errors of `take`. After
    /// [`Error::Recorder`] nothing is saved.
    pub fn run_to_by<R: Checkpoint + ?Sized>(
        &self,
        run: &mut R,
        steps: u64,
        every: u64,
        mut take: impl FnMut(&mut R, u64, u64) -> Result<(), Error>,
    ) -> Result<Ended, CheckpointError> {
        let has_steps = run.steps_taken() >= steps;
        if has_steps && read(&self.path).is_ok_and(|there| encode(&there) == encode(&run.checkpoint())) {
            return Ok(Ended::Done);
        }
        make_way(&self.path)?;
        if has_steps {
            run.save(&self.path)?;
        }
        let (mut saved, least) = (Instant::now(), run.at_a_time());
        let (mut stretch, every) = (least, every.max(1));
        while run.steps_taken() < steps {
            let now = run.steps_taken();
            let next = self.every.map_or(steps, |every| steps.min((now / every + 1).saturating_mul(every)));
            let looks = self.stop.is_some() || self.seconds.is_some();
            let end = if looks { next.min((now / stretch + 1).saturating_mul(stretch)) } else { next };
            let behind = now % every;
            let end = if behind == 0 { end } else { now }; // the first part leads to a multiple
            let end = end.checked_next_multiple_of(every).map_or(steps, |end| steps.min(end));
            let begun = Instant::now();
            if let Err(error) = take(run, end - now, every - behind) {
                // Rows that a recorder has lost lie behind the last checkpoint, but before the run as it is.
                if !matches!(error, Error::Recorder { .. }) {
                    run.save(&self.path)?;
                }
                return Err(CheckpointError::Step(Box::new(error)));
            }
            if begun.elapsed() < LOOK && stretch < MOST {
                stretch *= 2;
            } else if begun.elapsed() > 2 * LOOK && stretch > least {
                stretch /= 2;
            }
            let late = self.seconds.is_some_and(|seconds| saved.elapsed() >= seconds);
            if self.stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed)) && end < steps {
                run.save(&self.path)?;
                return Ok(Ended::Stopped);
            }
            if end == steps || late || self.every.is_some_and(|wanted| end / wanted > now / wanted) {
                run.save(&self.path)?;
                saved = Instant::now();
            }
        }
        Ok(Ended::Done)
    }
}
