//! The error function.
//!
//! ```text
//! erf x = 2x/√π + x³ P(x²)     |x| < 1
//! erf x = 1 − exp(−Q(x))       beyond, Q = −ln erfc
//! ```
//!
//! Q is needed the less precisely the larger it is.

use crate::number::functions::arithmetic::{Pair, at_most, polynomial, select};
use crate::number::functions::exponential::exp;

/// 2/√π.
const SLOPE: Pair = [std::f64::consts::FRAC_2_SQRT_PI, 1.533_545_961_316_588e-17];

/// (erf x − 2x/√π)/x³, in x².
const ERF: [f64; 12] = [
    -0.376_126_389_031_837_5, 0.112_837_916_709_549_3, -0.026_866_170_645_084_505, 0.005_223_977_624_882_167,
    -0.000_854_832_698_410_842_3, 0.000_120_553_312_202_613_1, -1.492_559_767_879_772_5e-5,
    1.646_103_664_667_149_1e-6, -1.635_067_404_058_567_6e-7, 1.466_208_073_377_879_9e-8,
    -1.138_134_467_029_476_5e-9, 5.970_932_782_953_214e-11,
];

/// −ln erfc(x), in x − 1, up to 5.93; weighed by erfc.
const ERFC: [f64; 18] = [
    1.849_605_509_933_248_2, 2.638_967_514_234_775_7, 0.843_107_256_359_413_3, 0.041_561_098_025_060_85,
    -0.010_033_825_178_903_007, 0.001_977_901_214_483_238_7, -0.000_237_316_429_838_029_43,
    -2.629_633_942_918_844_8e-5, 2.719_899_538_037_111e-5, -9.671_407_362_597_12e-6,
    2.131_970_117_390_383e-6, -2.048_343_733_673_021_8e-7, -5.799_935_400_586_116_6e-8,
    3.338_643_488_233_45e-8, -8.517_442_196_912_12e-9, 1.318_860_470_881_295e-9,
    -1.192_997_079_138_983_6e-10, 4.863_756_878_929_271_6e-12,
];

/// (2/√π) ∫₀ˣ exp(−t²) dt.
#[inline(always)]
pub(in crate::number) fn erf(x: f64) -> f64 {
    let size = at_most(5.93, x.abs()); // where it is 1 to rounding
    let square = size * size;
    let low = size.mul_add(square * polynomial(&ERF, square), size * SLOPE[1]);
    let near = size.mul_add(SLOPE[0], low);
    let far = 1.0 - exp(-polynomial(&ERFC, size - 1.0));
    select(size < 1.0, near, far).copysign(x)
}
