//! What is too much for one macro.

use std::fmt::{self, Display, Formatter};

/// The most operations that all functions of a macro together may come to; a result counts as a sixteenth.
///
/// ```text
///                       operations   rustc, release     of which expansion
/// 200 monomials             17 000      4 s                 0.1 s
/// 1000 branches             26 000      7 s                 0.2 s
/// sum of 1000 sines         62 000     12 s                 0.5 s
/// 1000 nested sines         65 000     11 s                 0.9 s
/// 5000 tangled operations   76 000     11 s                 2.3 s
/// ```
///
/// Seconds of one core, for a program that makes some steps with it.
pub(crate) const MOST: usize = 80_000;

/// The most steps that it may take to read an expression: for loops that make little of much.
pub(crate) const STEPS: usize = 1 << 21;

/// Functions that come to more than [`MOST`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct TooLarge {
    /// Operations of the expression as it is written; none where reading it took too long.
    pub written: Option<usize>,
    /// Operations of the functions, those counted so far.
    pub found: usize,
}

impl Display for TooLarge {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let TooLarge { written, found } = self;
        if let Some(written) = written {
            write!(f, "the expression has {written} operations, with its derivatives {found} or more")?;
        } else {
            write!(f, "the expression has {found} operations or more")?;
        }
        write!(f, ", expected at most {MOST}, which take the compiler about 10 s; {ADVICE}")
    }
}

/// What to try.
const ADVICE: &str = "write it with fewer terms, divide it among several structs, or implement the trait by hand, \
                      with a loop";
