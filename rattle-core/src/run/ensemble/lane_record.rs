//! Rows of numbers, one number of each lane, to a record and back.

use crate::error::Error;
use crate::motion::method::Method;
use crate::motion::record::{Hallmark, Reading, Record};
use crate::number::lanes::{Fused, Lane};
use crate::systems::network::in_lanes::Numbers;

/// Rows by their names.
pub(super) type Rows<'a, S> = Vec<(&'static str, &'a mut [S])>;

/// What is kept of lanes from step to step, as rows of numbers.
pub(super) trait InRows<S: Lane>: Clone {
    /// Each row of numbers, one of each lane.
    fn rows(&mut self) -> Rows<'_, S>;

    /// Copies a lane.
    fn copy(&mut self, from: usize, to: usize) {
        self.rows().into_iter().for_each(|(_, numbers)| numbers[to] = numbers[from]);
    }

    /// Writes all lanes.
    fn record(&self, to: &mut Record) {
        write(self.clone().rows(), to);
    }

    /// The same with the numbers that were written.
    fn recalled(mut self, from: &mut Reading<'_>) -> Result<Self, Error> {
        read(self.rows(), from)?;
        Ok(self)
    }
}

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

/// Writes rows that need no names.
pub(super) fn write_all<const W: usize>(rows: &mut dyn Iterator<Item = &Numbers<W>>, to: &mut Record) {
    let numbers: Vec<_> = rows.flat_map(|row| row.0.map(|x| x.0)).collect();
    to.numbers("numbers", &[numbers.len() / W, W], numbers);
}

/// Fills them with what was written.
pub(super) fn read_all<const W: usize>(
    rows: &mut dyn Iterator<Item = &mut Numbers<W>>,
    from: &mut Reading<'_>,
) -> Result<(), Error> {
    let rows: Vec<_> = rows.collect();
    let numbers = from.numbers("numbers", &[rows.len(), W])?;
    rows.into_iter().zip(numbers.as_chunks().0).for_each(|(row, &of_lanes)| row.0 = of_lanes.map(Fused));
    Ok(())
}

/// What tells a method from others whose steps are projected.
pub(super) fn of_projected<M: Method>(method: &M) -> Hallmark {
    let numbers = [f64::from(method.order()), method.step_size(), method.tolerance().unwrap_or(0.0)];
    Hallmark::of_parameters("method", method.name(), numbers.to_vec())
}
