//! Saving to files and restoring from them.

use super::error::CheckpointError;
use super::file::{read, write};
use rattle_core::run::checkpoint::Checkpoint;
use std::path::Path;

/// Saves simulations and ensembles to files, and restores them.
pub trait Save: Checkpoint {
    /// Writes all that is needed to continue. An old file is replaced only when the new one is complete.
    ///
    /// # Errors
    /// [`CheckpointError::Io`]; an old file is then unchanged.
    #[doc(alias = "checkpoint")]
    #[doc(alias = "dump")]
    fn save(&self, path: impl AsRef<Path>) -> Result<(), CheckpointError> {
        write(&self.checkpoint(), path)
    }

    /// Sets the run to the state in the file, which must have been saved from the same scene and method. The present
    /// state is replaced.
    ///
    /// # Errors
    /// [`CheckpointError`] says what is wrong with the file; the run is then unchanged.
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
    #[doc(alias = "restart")]
    #[doc(alias = "resume")]
    #[doc(alias = "load")]
    fn restore(&mut self, path: impl AsRef<Path>) -> Result<(), CheckpointError> {
        let path = path.as_ref();
        let refused = |error| CheckpointError::Refused { path: path.into(), error: Box::new(error) };
        self.resume(&read(path)?).map_err(refused)
    }
}

impl<X: Checkpoint + ?Sized> Save for X {}
