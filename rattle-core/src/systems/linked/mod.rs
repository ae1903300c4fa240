//! Linked bodies: a [network](crate::systems::network) of any number of constraints, with any masses.

mod abreast;
mod aim;
mod at_start;
mod chords;
mod collocation;
mod diagnosis;
mod drift_abreast;
mod few;
mod flight;
mod hold;
mod in_rows;
mod independence;
pub(crate) mod kept;
mod moving;
mod pull;
mod rates;
mod room;
mod series;
mod settle_abreast;
mod sheets;
mod start;
mod step;
mod strip;
mod system;

use crate::motion::iteration::Newton;
use crate::motion::witness::Whoever;

pub use kept::{Counts, Kept, Linked};

/// Functions that are compiled in this crate, see [`crate::instances`]; forces are vectors there.
pub(crate) fn instances<const D: usize>() -> impl Copy {
    [
        start::check::<D> as *const (),
        start::project::<D> as *const (),
        kept::Tied::<[f64; D], D>::new as *const (),
        kept::Tied::<[f64; D], D>::drift::<Newton, ()> as *const (),
        kept::Tied::<[f64; D], D>::drift::<Newton, Whoever<f64>> as *const (),
        kept::Tied::<[f64; D], D>::settle::<()> as *const (),
        kept::Tied::<[f64; D], D>::settle::<Whoever<f64>> as *const (),
        kept::Tied::<[f64; D], D>::normals as *const (),
        kept::Tied::<[f64; D], D>::clone as *const (),
    ]
}
