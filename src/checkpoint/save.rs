//! To files and back, by one word each.

use super::error::CheckpointError;
use super::file::{read, write};
use rattle_core::run::checkpoint::Checkpoint;
use std::path::Path;

/// Simulations and ensembles to files and back.
pub trait Save: Checkpoint {
    /// Writes all that is needed to go on; an old file is replaced once the new one is whole.
    ///
    /// # Errors
    /// [`CheckpointError::Io`]; an old file, and what is saved, are as they were.
    fn save(&self, path: impl AsRef<Path>) -> Result<(), CheckpointError> {
        write(&self.checkpoint(), path)
    }

    /// Goes on from a file that was saved by the same scene and method, whatever the state was here.
    ///
    /// # Errors
    /// [`CheckpointError`] says what the file is instead; what was to go on is as it was.
    ///
    /// ```
    /// # use rattle::prelude::*;
    /// # use rattle::checkpoint::Save;
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("run.rattle");
    /// let scene = |g: f64| Scene::point().with(rattle::potentials::planar::Gravity { g });
    /// let start = State::at([0.0, 1.0]);
    /// scene(9.81).simulate(start.clone(), Rattle::new(0.1))?.save(&path)?;
    /// let refused = scene(1.62).simulate(start, Rattle::new(0.1))?.restore(&path).unwrap_err();
    /// assert!(refused.to_string().contains("(effect 0): it was written by Gravity with -9.81, and here is Gravity with -1.62"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    fn restore(&mut self, path: impl AsRef<Path>) -> Result<(), CheckpointError> {
        let path = path.as_ref();
        let refused = |error| CheckpointError::Refused { path: path.into(), error: Box::new(error) };
        self.resume(&read(path)?).map_err(refused)
    }
}

impl<X: Checkpoint + ?Sized> Save for X {}
