//! Words of a text file, and what is wrong with them.

use crate::error::MeshError;
use std::path::Path;

/// A file that cannot be read.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file cannot be opened or read.
    #[error("{path}: {source}")]
    Io {
        /// Which file.
        path: String,
        /// Why.
        source: std::io::Error,
    },
    /// A word that was not expected.
    #[error("line {line}: expected {expected}, found `{found}`")]
    Word {
        /// Its line, from 1.
        line: usize,
        /// What was expected.
        expected: &'static str,
        /// What was found; nothing at the end of the file.
        found: String,
    },
    /// An element of a mesh that is no triangle of three vertices, and would be a hole if it were left out.
    #[error("line {line}: {found} would be a hole in the mesh of triangles; {advice}")]
    Hole {
        /// Its line, from 1.
        line: usize,
        /// What it is.
        found: &'static str,
        /// How to get triangles.
        advice: &'static str,
    },
    /// A part of the file is missing.
    #[error("there is no `{section}` in the file")]
    Missing {
        /// Which part.
        section: &'static str,
    },
    /// A version or kind of file that is not supported.
    #[error("{found} is not read; save the mesh as ASCII in version 2.2 or 4.1")]
    Version {
        /// What the file is.
        found: String,
    },
    /// A GeoTIFF that is not a supported terrain.
    #[cfg(feature = "geotiff")]
    #[error("GeoTIFF: {what}")]
    GeoTiff {
        /// What is wrong, and how to mend it.
        what: String,
    },
    /// The mesh in the file is invalid.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

/// The words of a text one after the other, with their lines.
pub(crate) struct Words<'a> {
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
    here: std::str::SplitWhitespace<'a>,
    line: usize,
}

impl<'a> Words<'a> {
    /// Without the mark of byte order that editors of Windows put before a text.
    pub(crate) fn of(text: &'a str) -> Self {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        Words { lines: text.lines().enumerate(), here: "".split_whitespace(), line: 0 }
    }

    pub(crate) fn next(&mut self) -> Option<&'a str> {
        loop {
            if let Some(word) = self.here.next() {
                return Some(word);
            }
            let (line, text) = self.lines.next()?;
            self.line = line + 1;
            self.here = text.split_whitespace();
        }
    }

    /// The next word as a number.
    pub(crate) fn number<T: std::str::FromStr>(&mut self, expected: &'static str) -> Result<T, ReadError> {
        let found = self.next().unwrap_or("");
        found.parse().map_err(|_| self.wrong(expected, found))
    }

    /// The line of the last word, from 1.
    pub(crate) fn line(&self) -> usize {
        self.line
    }

    pub(crate) fn wrong(&self, expected: &'static str, found: &str) -> ReadError {
        ReadError::Word { line: self.line, expected, found: found.to_owned() }
    }
}

pub(crate) fn bytes(path: &Path) -> Result<Vec<u8>, ReadError> {
    std::fs::read(path).map_err(|source| ReadError::Io { path: path.display().to_string(), source })
}

pub(crate) fn text(path: &Path, bytes: Vec<u8>) -> Result<String, ReadError> {
    String::from_utf8(bytes).map_err(|error| {
        let source = std::io::Error::new(std::io::ErrorKind::InvalidData, error);
        ReadError::Io { path: path.display().to_string(), source }
    })
}
