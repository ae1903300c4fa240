//! Elementary functions without branches, calls or tables, so that loops over them vectorise.
//!
//! The functions of the system's library are calls, and one call keeps a compiler from vectorising a whole loop. No
//! crate serves on stable Rust: of those that have these functions in double precision, `sleef` needs the unstable
//! `portable_simd`, `wide` chooses instructions when it is compiled, and `libm` branches.
//!
//! All is made of operations that round once and of bits of floats. So every instruction set gives the same numbers.
//!
//! Where a sum or a quotient loses digits that the result needs, it comes with what rounding took from it, as a
//! [`Pair`]. Polynomials are the best ones on their intervals, by the exchange algorithm of Remez, rounded to double
//! precision; `tests/data/polynomials.py` finds them.
//!
//! The largest errors seen, in units of the last place, are in `tests/functions.rs`.

mod arc;
mod arithmetic;
mod circular;
mod erf;
mod exponential;
mod logarithm;
mod power;
mod root;
pub(super) mod single;

pub(super) use arc::{acos, asin, atan, atan2};
pub(super) use circular::{cos, sin, sin_cos, tan};
pub(super) use erf::erf;
pub(super) use exponential::{cosh, exp, sinh, tanh};
pub(super) use logarithm::{acosh, asinh, atanh, ln, log2, log10};
pub(super) use power::powf;
pub(super) use root::{cbrt, hypot};
