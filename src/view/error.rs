//! What can go wrong with a page.

use std::io;
use std::path::PathBuf;

/// Positions of all bodies of a scene that a page takes; every WebGL 2 has a texture that holds them.
pub(super) const MAX_POINTS: usize = 2048 * 2048;

/// What can go wrong with a page.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum PageError {
    /// The page has no scene.
    #[error("the page has no scene")]
    NoScene,
    /// A scene has no body, box or surface that moves, or less than two times.
    #[error("scene `{scene}`: nothing moves; give at least one body and two times")]
    NoMotion {
        /// The scene.
        scene: String,
    },
    /// Times are not finite, or do not increase, when what they are past the first one is rounded to f32.
    #[error("scene `{scene}`: time {frame} is {time}, which does not follow the one before")]
    Times {
        /// The scene.
        scene: String,
        /// The time's number.
        frame: usize,
        /// The time.
        time: f64,
    },
    /// A trajectory has other times than the bodies before it.
    #[error(
        "scene `{scene}`: a trajectory has time {frame} at {found}, and the bodies before it at {wanted}; record all at the same times"
    )]
    OtherTimes {
        /// The scene.
        scene: String,
        /// The time's number.
        frame: usize,
        /// The time in the trajectory.
        found: f64,
        /// The time in the scene.
        wanted: f64,
    },
    /// The number of positions of a body is not the number of times.
    #[error("scene `{scene}`: body {body} has {positions} positions for {times} times")]
    Length {
        /// The scene.
        scene: String,
        /// The body.
        body: usize,
        /// Its positions.
        positions: usize,
        /// The times.
        times: usize,
    },
    /// A position is NaN, infinite or beyond f32.
    #[error("scene `{scene}`: body {body} is at {position:?} at time {frame}")]
    NotFinite {
        /// The scene.
        scene: String,
        /// The body.
        body: usize,
        /// The time's number.
        frame: usize,
        /// The position.
        position: [f64; 3],
    },
    /// More positions than every graphics processor can hold.
    #[error("scene `{scene}`: {points} positions, at most {MAX_POINTS}; take every second or tenth time")]
    TooMany {
        /// The scene.
        scene: String,
        /// Bodies × times.
        points: usize,
    },
    /// A rod, a disc or a ring names a body that does not exist.
    #[error("scene `{scene}`: there is no body {body} for {what}; bodies are 0 … {bodies} − 1")]
    NoBody {
        /// The scene.
        scene: String,
        /// The shape that names the body.
        what: &'static str,
        /// The body.
        body: usize,
        /// How many there are.
        bodies: usize,
    },
    /// A trajectory of bodies that have other than two or three coordinates.
    #[error(
        "scene `{scene}`: a page shows bodies with two or three coordinates, and a trajectory has {coordinates}"
    )]
    Dimension {
        /// The scene.
        scene: String,
        /// Coordinates of each body.
        coordinates: usize,
    },
    /// A list has the wrong length.
    #[error("scene `{scene}`: {what}: {found} for {wanted}")]
    Count {
        /// The scene.
        scene: String,
        /// What is listed.
        what: String,
        /// How many there are.
        found: usize,
        /// How many there must be.
        wanted: String,
    },
    /// A number is NaN or infinite, or a length that is not positive.
    #[error("scene `{scene}`: {what} {value} can't be drawn")]
    Number {
        /// The scene.
        scene: String,
        /// What the number means.
        what: String,
        /// The number.
        value: f64,
    },
    /// The axes of a box are not a right-handed system of three orthogonal unit vectors.
    #[error(
        "scene `{scene}`: the axes of box {number} at time {frame} are no rotation; give three columns of QᵀQ = 1, det Q = 1"
    )]
    Attitude {
        /// The scene.
        scene: String,
        /// The box.
        number: usize,
        /// The time's number.
        frame: usize,
    },
    /// The file can't be written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The error of the file system.
        source: io::Error,
    },
}

debug_as_display!(PageError);
