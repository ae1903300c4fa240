//! Rows of numbers, one number of each lane, to a record and back.

use crate::error::Error;
use crate::motion::record::{Reading, Record};
use crate::number::lanes::Lane;

/// Rows by their names.
pub(super) type Rows<'a, S> = Vec<(&'static str, &'a mut [S])>;

/// Writes them.
#[inline(never)]
pub(super) fn write<S: Lane>(rows: Rows<'_, S>, to: &mut Record) {
    for (name, numbers) in rows {
        to.numbers(name, &[numbers.len()], numbers.iter().map(|x| x.to_f64()));
    }
}

/// Fills them with what was written.
#[inline(never)]
pub(super) fn read<S: Lane>(rows: Rows<'_, S>, from: &mut Reading<'_>) -> Result<(), Error> {
    for (name, numbers) in rows {
        let found = from.numbers(name, &[numbers.len()])?;
        numbers.iter_mut().zip(found).for_each(|(x, &number)| *x = S::from_f64(number));
    }
    Ok(())
}
