//! The kernel of a pair potential with a cut-off.

use crate::kernel::functions::{PairKernel, PairPotential};
use crate::kernel::within::{Ending, Within};
use crate::number::real::Real;

/// A pair potential with a [cut-off](Within), over a scalar; zero beyond.
#[derive(Debug, Clone)]
pub struct CutOff<K, T> {
    kernel: K,
    reach_square: T,
    ending: Ended<T>,
}

/// How it ends, with all that depends on parameters alone.
#[derive(Debug, Clone, Copy)]
enum Ended<T> {
    Shifted { value: T },
    ForceShifted { value: T, slope: T, reach: T },
    Switched { from_square: T, per_width: T },
}

impl<P: PairPotential, B> Within<P, B> {
    /// The kernel with this value's parameters.
    pub(crate) fn cut_off<T: Real>(&self) -> CutOff<P::Kernel<T>, T> {
        let number = T::from_f64;
        let (kernel, reach) = (self.potential.kernel::<T>(), number(self.reach));
        let square = reach * reach;
        let ending = match self.ending {
            Ending::Shifted => Ended::Shifted { value: kernel.value(square) },
            Ending::ForceShifted => {
                let slope = number(2.0) * reach * kernel.slope(square); // dU/dr
                Ended::ForceShifted { value: kernel.value(square), slope, reach }
            }
            Ending::Switched { from } => {
                let from_square = number(from) * number(from);
                Ended::Switched { from_square, per_width: number(1.0) / (square - from_square) }
            }
        };
        CutOff { kernel, reach_square: square, ending }
    }
}

impl<T: Real, K: PairKernel<T>> CutOff<K, T> {
    #[inline(always)]
    fn ends(&self, s: T, within: T) -> T {
        T::select(self.reach_square.le(s), T::from_f64(0.0), within)
    }
}

impl<T: Real, K: PairKernel<T>> PairKernel<T> for CutOff<K, T> {
    #[inline(always)]
    fn value(&self, s: T) -> T {
        let value = self.kernel.value(s);
        self.ends(
            s,
            match self.ending {
                Ended::Shifted { value: last } => value - last,
                Ended::ForceShifted { value: last, slope, reach } => {
                    value - last - (s.sqrt() - reach) * slope
                }
                Ended::Switched { from_square, per_width } => value * switch(s, from_square, per_width).1,
            },
        )
    }
    #[inline(always)]
    fn slope(&self, s: T) -> T {
        let mut slope = [s];
        self.slope_block(&mut slope);
        slope[0]
    }
    #[inline(always)]
    fn slope_block<const L: usize>(&self, s: &mut [T; L]) {
        match self.ending {
            Ended::Shifted { .. } => s.iter_mut().for_each(|s| *s = self.ends(*s, self.kernel.slope(*s))),
            Ended::ForceShifted { slope, .. } => {
                s.iter_mut().for_each(|s| *s = self.ends(*s, force_shifted_slope(&self.kernel, *s, slope)));
            }
            Ended::Switched { from_square, per_width } => {
                let slope = |s| switched_slope(&self.kernel, s, from_square, per_width);
                s.iter_mut().for_each(|s| *s = self.ends(*s, slope(*s)));
            }
        }
    }
}

/// dU/ds − U′(reach)/2r; at contact, where a force has no direction, that of U alone.
#[inline(always)]
fn force_shifted_slope<T: Real, K: PairKernel<T>>(kernel: &K, s: T, slope: T) -> T {
    let zero = T::from_f64(0.0);
    let less = T::select(s.le(zero), zero, T::from_f64(0.5) * slope / s.sqrt());
    kernel.slope(s) - less
}

/// d(U S)/ds.
#[inline(always)]
fn switched_slope<T: Real, K: PairKernel<T>>(kernel: &K, s: T, from_square: T, per_width: T) -> T {
    let (x, switch) = switch(s, from_square, per_width);
    let (slope, one) = (kernel.slope(s), T::from_f64(1.0));
    let bend = x * (one - x);
    let falling = T::from_f64(-30.0) * per_width * (bend * bend);
    let switched = slope.multiply_add(switch, kernel.value(s) * falling);
    T::select(x.le(T::from_f64(0.0)), slope, switched) // there a value may be infinite
}

/// x and S(x) = 1 − 10x³ + 15x⁴ − 6x⁵.
#[inline(always)]
fn switch<T: Real>(s: T, from_square: T, per_width: T) -> (T, T) {
    let number = T::from_f64;
    let x = ((s - from_square) * per_width).max(number(0.0));
    let inner = x.multiply_add(x.multiply_add(number(6.0), number(-15.0)), number(10.0));
    (x, (-(x * x * x)).multiply_add(inner, number(1.0)))
}
