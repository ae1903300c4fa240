//! Why a checkpoint is not gone on from.

/// What is wrong with a checkpoint, for what is to go on from it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RecordMistake {
    /// It was written by another scene, method or ensemble: the first part that differs.
    #[error(
        "the checkpoint is of another run ({part}): it was written by {file}, and here is {here}; \
         go on with what it was written by, or start anew"
    )]
    Another {
        /// Which part.
        part: String,
        /// What it is in the checkpoint.
        file: String,
        /// What it is here.
        here: String,
    },

    /// A field is not there, or of another kind or shape than it must be.
    #[error("the checkpoint does not fit: {wanted} is wanted, and {found} is there")]
    Field {
        /// The field that is wanted.
        wanted: String,
        /// What is there.
        found: String,
    },
}
