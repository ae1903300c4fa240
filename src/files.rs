//! New files.

use std::fs::{self, File};
use std::io;
use std::path::Path;

/// Creates a file, and its folder where that is missing.
pub(crate) fn create(path: &Path) -> io::Result<File> {
    path.parent().map_or(Ok(()), fs::create_dir_all)?;
    File::create(path)
}
