//! Linked bodies: a [network](crate::systems::network) of any number of constraints, with any masses.

mod abreast;
mod aim;
mod chords;
mod collocation;
mod diagnosis;
mod drift_abreast;
mod few;
mod flight;
mod hold;
mod in_rows;
pub(crate) mod kept;
mod rates;
mod room;
mod series;
mod settle_abreast;
mod sheets;
mod start;
mod strip;
mod system;

use crate::motion::iteration::Newton;
use crate::motion::witness::Whoever;

pub use kept::{Counts, Kept, Linked};

/// Functions that are compiled in this crate, see [`crate::instances`]; forces are vectors there.
pub(crate) fn instances<const D: usize>() -> [*const (); 18] {
    [
        start::check::<D> as *const (),
        start::project::<D> as *const (),
        flight::Flight::<D>::find as *const (),
        flight::Flight::<D>::try_to_solve::<Newton> as *const (),
        few::Few::<[f64; D], D>::drift as *const (),
        few::Momenta::<[f64; D], D>::settle as *const (),
        in_rows::InRows::new::<D> as *const (),
        in_rows::InRows::drift::<[f64; D], (), D> as *const (),
        in_rows::InRows::drift::<[f64; D], Whoever<f64>, D> as *const (),
        in_rows::InRows::settle::<[f64; D], (), D> as *const (),
        in_rows::InRows::settle::<[f64; D], Whoever<f64>, D> as *const (),
        in_rows::InRows::take_back::<D> as *const (),
        strip::set_out::<[f64; D], D> as *const (),
        strip::advance::<[f64; D], D> as *const (),
        strip::Strip::<[f64; D], D>::settle as *const (),
        diagnosis::acting_share::<D> as *const (),
        crate::systems::network::shape::Shape::<D>::equation_at as *const (),
        kept::Room::<D>::clone as *const (),
    ]
}
