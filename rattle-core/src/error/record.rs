//! Errors of checkpoints.

/// Why a run cannot continue from a checkpoint.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RecordMistake {
    /// It was written by another scene, method or ensemble. This is the first part that differs.
    #[error(
        "the checkpoint is of another run ({part}): it was written by {file}, and here is {here}; \
         go on with what it was written by, or start anew"
    )]
    Another {
        /// Which part.
        part: String,
        /// The part in the checkpoint.
        file: String,
        /// The part here.
        here: String,
    },

    /// A field is missing, or has the wrong kind or shape.
    #[error("the checkpoint does not fit: {wanted} is wanted, and {found} is there")]
    Field {
        /// The expected field.
        wanted: String,
        /// The field found.
        found: String,
    },
}
