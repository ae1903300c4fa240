//! Steps that are taken back, and compared with where they came from.

use crate::error::Error;
use crate::methods::able::{no_way_back, view};
use crate::motion::bodies::Body;
use crate::motion::method::{Method, check_tolerance};
use crate::motion::stir::Chosen;
use crate::motion::system::System;
use crate::number::vector::larger_or_nan;
use crate::run::seldom::seldom;
use crate::run::simulation::{Reversal, Simulation};
use crate::run::trouble::Trouble;

/// Refuses a check of the steps of this method in this system, if there is no way back.
///
/// # Errors
/// [`Error::NeedsSymmetricMethod`], and [`Error::Effect`] for what is random.
pub(in crate::run) fn has_way_back<Y: System<f64, D>, S: Method, const D: usize>(
    method: &S,
    system: &Y,
) -> Result<(), Error> {
    if !method.is_symmetric() {
        let (what, method) = ("a check of reversal", method.name());
        return Err(Error::NeedsSymmetricMethod { what, method });
    }
    no_way_back(system)
}

impl<Y: System<f64, D>, S: Method, const D: usize> Simulation<Y, S, D> {
    /// From now on every step is taken back and compared, see [`Self::check_reversal`].
    ///
    /// # Errors
    /// As there.
    pub(super) fn reverse(&mut self, tolerance: f64) -> Result<(), Error> {
        check_tolerance(Some(tolerance))?;
        has_way_back(&self.method, &self.system)?;
        let backwards = self.method.with_step(-self.method.step_size());
        let memory = backwards.memory(view(&backwards, &self.system)?, &self.bodies);
        let (after, blank) = (self.before.clone(), memory.clone());
        self.reversal =
            Some(Box::new(Reversal { take: Self::take_back, tolerance, backwards, after, blank, memory }));
        self.goes_again = true;
        Ok(())
    }

    /// Takes the step just made, in so many parts, back, compares, and makes it again.
    fn take_back(&mut self, parts: u32) -> Result<(), Trouble> {
        let Some(reversal) = &mut self.reversal else { return Ok(()) };
        self.system.put_aside(&self.bodies, &mut reversal.after);
        reversal.memory.as_mut().copy_from_slice(reversal.blank.as_ref());
        let memory = reversal.memory.as_mut();
        let backwards = reversal.backwards.with_step(reversal.backwards.step_size() / f64::from(parts));
        let bodies = &mut self.bodies;
        let back = (0..parts)
            .try_for_each(|_| seldom(&backwards, &self.system, bodies, memory, &mut (), Chosen::All));
        let n = self.bodies.q.as_ref().len();
        compare(n, &|i| [self.before.body(i), self.bodies.body(i)], back.is_ok(), reversal.tolerance)?;
        self.system.put_back(&mut self.bodies, &reversal.after);
        Ok(())
    }
}

/// Compares so many bodies as they were with what the way back led to, if it led anywhere.
///
/// # Errors
/// [`Trouble::NotReversed`] where a coordinate of a place or momentum differs by more than so many times the largest.
pub(super) fn compare<const D: usize>(
    bodies: usize,
    was_and_is: &dyn Fn(usize) -> [Body<f64, D>; 2],
    led: bool,
    tolerance: f64,
) -> Result<(), Trouble> {
    let (mut worst, mut body, mut size) = (0.0, 0, 0.0_f64);
    for i in 0..bodies {
        let [was, is] = was_and_is(i);
        let off = larger_or_nan(farthest(&was.q, &is.q), farthest(&was.p, &is.p));
        size = size.max(farthest(&was.q, &[0.0; D])).max(farthest(&was.p, &[0.0; D]));
        if off > worst || off.is_nan() {
            (worst, body) = (off, i);
        }
    }
    if led && worst <= tolerance * size {
        return Ok(());
    }
    let off = if led { worst / size } else { f64::NAN };
    Err(Trouble::NotReversed { body, off, tolerance })
}

/// The largest difference of a coordinate; NaN if one is.
fn farthest<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    a.iter().zip(b).fold(0.0, |most, (a, b)| larger_or_nan((a - b).abs(), most))
}
