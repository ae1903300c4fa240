//! Elementary functions in lanes, against values of many digits, and against those of the system's library.

use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use rattle::instructions::{InstructionSet, Work};
use rattle::lanes::{Fused, Lane};
use rattle::real::Real;
use std::array::from_fn;

/// A function, that of the system, and the largest error allowed in units of the last place, over a range; and how far
/// the system's may be from ours there.
struct Row {
    name: &'static str,
    lanes: fn(Fused<f64>) -> Fused<f64>,
    single: fn(Fused<f32>) -> Fused<f32>,
    system: fn(f64) -> f64,
    allowed: f64,
    apart: f64,
    range: [f64; 2],
}

macro_rules! rows {
    ($($name:ident $allowed:literal $apart:literal $low:literal .. $high:literal;)*) => {
        [$(Row {
            name: stringify!($name),
            lanes: Real::$name,
            single: Real::$name,
            system: <f64 as Real>::$name,
            allowed: $allowed,
            apart: $apart,
            range: [$low, $high],
        }),*]
    };
}

/// Half a unit is the rounding of the result. Where the last operation adds a number to a larger one, the rounding of
/// the smaller one comes to it: a quarter of a unit or half of one where it is a fourth or a half as large. Roundings
/// of factors of the result (sinh, tanh, erf, arcosh, whose sums are quotients and roots) count whole. The table has
/// the arguments with the largest errors of 250 000. The system's functions are off by up to one unit, tanh by two;
/// arcosh near 1 and artanh below 0 by much more, and not compared there.
const ROWS: [Row; 18] = rows! {
    exp 1.05 3.0 -708.3 .. 709.7;
    ln 0.8 2.0 0.0 .. 4.0;
    sin 0.85 2.0 -4e5 .. 4e5;
    cos 0.8 2.0 -4e5 .. 4e5;
    cosh 1.4 3.0 -30.0 .. 30.0;
    sinh 1.7 3.0 -30.0 .. 30.0;
    tanh 1.4 4.0 -3.0 .. 3.0;
    tan 0.9 2.0 -4e5 .. 4e5;
    atan 0.9 2.0 -4.0 .. 4.0;
    asin 1.2 2.0 -1.0 .. 1.0;
    acos 1.2 2.0 -1.0 .. 1.0;
    log2 0.75 2.0 0.0 .. 4.0;
    log10 0.75 2.0 0.0 .. 4.0;
    cbrt 0.501 2.0 -9.0 .. 9.0;
    erf 1.7 3.0 -6.0 .. 6.0;
    asinh 1.25 3.0 -4.0 .. 4.0;
    acosh 1.6 3.0 3.0 .. 30.0;
    atanh 1.1 3.0 0.0 .. 1.0;
};

/// Functions of two numbers: the system's, and the largest error allowed.
struct OfTwo {
    name: &'static str,
    lanes: fn(Fused<f64>, Fused<f64>) -> Fused<f64>,
    system: fn(f64, f64) -> f64,
    allowed: f64,
}

const OF_TWO: [OfTwo; 3] = [
    OfTwo { name: "powf", lanes: Real::powf, system: f64::powf, allowed: 0.8 },
    OfTwo { name: "atan2", lanes: Real::atan2, system: f64::atan2, allowed: 0.8 },
    OfTwo { name: "hypot", lanes: Real::hypot, system: f64::hypot, allowed: 1.0 },
];

fn ulp(x: f64) -> f64 {
    let x = x.abs();
    f64::from_bits(x.to_bits() + 1) - x
}

#[test]
fn values_are_right_to_the_last_place() {
    let mut reader = csv::Reader::from_path("tests/data/functions.csv").unwrap();
    let mut seen = [(0, 0.0_f64); ROWS.len()];
    for record in reader.records() {
        let record = record.unwrap();
        let number = |i: usize| record[i].parse::<f64>().unwrap();
        let (x, nearest, beyond) = (number(1), number(2), number(3));
        let (i, row) = ROWS.iter().enumerate().find(|(_, row)| row.name == &record[0]).unwrap();
        let found = (row.lanes)(Fused(x)).0;
        if row.name == "exp" && nearest < f64::MIN_POSITIVE {
            assert_eq!(found, 0.0, "exp({x:?})"); // below all normal numbers
            continue;
        }
        let off = ((found - nearest) / ulp(nearest) - beyond).abs();
        // Far out angles are reduced to 2⁻⁷⁵, and to 2⁻⁶⁵ at the end.
        let angle = ["sin", "cos", "tan"].contains(&row.name) && x.abs() > 4e5;
        let slope = if row.name == "tan" { 1.0 + nearest * nearest } else { 1.0 };
        let reduced = if angle { x.abs() * slope * 2.0_f64.powi(-105) / ulp(nearest) } else { 0.0 };
        let allowed = row.allowed + reduced;
        assert!(off <= allowed, "{}({x:?}) = {found:?}, {off} units off {nearest:?}", row.name);
        seen[i].0 += 1;
        if !angle {
            seen[i].1 = seen[i].1.max(off);
        }
    }
    for (row, (number, worst)) in ROWS.iter().zip(seen) {
        println!("{}: at most {worst:.3} units of the last place, of {number} values", row.name);
        assert!(number > 400 && worst > 0.5 * row.allowed, "{}: {number} values, {worst}", row.name);
    }
}

#[test]
fn values_of_two_are_right_to_the_last_place() {
    let mut reader = csv::Reader::from_path("tests/data/functions_of_two.csv").unwrap();
    let mut seen = [(0, 0.0_f64); OF_TWO.len()];
    for record in reader.records() {
        let record = record.unwrap();
        let number = |i: usize| record[i].parse::<f64>().unwrap();
        let (x, y, nearest, beyond) = (number(1), number(2), number(3), number(4));
        let (i, row) = OF_TWO.iter().enumerate().find(|(_, row)| row.name == &record[0]).unwrap();
        let found = (row.lanes)(Fused(x), Fused(y)).0;
        let off = ((found - nearest) / ulp(nearest) - beyond).abs();
        // Among the subnormal ones a result is rounded twice.
        let allowed = if nearest.abs() < f64::MIN_POSITIVE { 1.1 } else { row.allowed };
        assert!(off <= allowed, "{}({x:?}, {y:?}) = {found:?}, {off} units off {nearest:?}", row.name);
        seen[i] = (seen[i].0 + 1, seen[i].1.max(off));
    }
    for (row, (number, worst)) in OF_TWO.iter().zip(seen) {
        println!("{}: at most {worst:.3} units of the last place, of {number} values", row.name);
        assert!(number > 400 && worst > 0.5 * row.allowed, "{}: {number} values, {worst}", row.name);
    }
}

#[test]
#[cfg(long)]
fn everywhere_near_those_of_the_system() {
    let mut random = SmallRng::seed_from_u64(6);
    for Row { name, lanes, system, apart, range: [low, high], .. } in ROWS {
        for narrow in [1.0, 1e-2] {
            for _ in 0..500_000 {
                let x = random.random_range(narrow * low..narrow * high);
                let (found, theirs) = (lanes(Fused(x)).0, system(x));
                let off = (found - theirs).abs() / ulp(theirs);
                let same = off <= apart || found.is_nan() && theirs.is_nan();
                assert!(same, "{name}({x:?}) = {found:?}, not {theirs:?}");
            }
        }
    }
}

/// Every pair of numbers among which there are exceptions: zeros, infinities, whole and odd numbers, the largest and
/// the smallest.
#[test]
fn of_two_at_the_ends() {
    let infinite = f64::INFINITY;
    let sizes = [
        0.0,
        5e-324,
        f64::MIN_POSITIVE,
        1e-200,
        0.3,
        0.5,
        1.0,
        1.5,
        2.0,
        3.0,
        4.0,
        1e9 + 1.0,
        1e200,
        f64::MAX,
    ];
    let odd = 9_007_199_254_740_991.0_f64; // 2⁵³ − 1
    let sizes = sizes.into_iter().chain([odd, odd + 1.0, odd.next_down(), infinite, f64::NAN]);
    let numbers: Vec<f64> = sizes.flat_map(|x| [x, -x]).collect();
    for OfTwo { name, lanes, system, .. } in OF_TWO {
        for &x in &numbers {
            for &y in &numbers {
                let (found, theirs) = (lanes(Fused(x), Fused(y)).0, system(x, y));
                if theirs.is_nan() {
                    assert!(found.is_nan(), "{name}({x:?}, {y:?}) = {found:?}, not a number");
                    continue;
                }
                let near = (found - theirs).abs() <= 1.5 * ulp(theirs) && theirs.is_finite();
                let same = found == theirs || near && theirs != 0.0;
                let sign = found.is_sign_negative() == theirs.is_sign_negative();
                assert!(same && sign, "{name}({x:?}, {y:?}) = {found:?}, not {theirs:?}");
            }
        }
    }
}

#[test]
fn ends_of_the_range() {
    let infinite = f64::INFINITY;
    for Row { name, lanes, single, system, .. } in ROWS {
        for x in [0.0, -0.0, f32::NAN, f32::INFINITY, -f32::INFINITY] {
            let (found, theirs) = (single(Fused(x)).0, system(f64::from(x)) as f32);
            let same = found.to_bits() == theirs.to_bits() || found.is_nan() && theirs.is_nan();
            assert!(same, "{name}({x:?}) = {found:?}, not {theirs:?}");
        }
        let cases = [0.0, -0.0, f64::NAN, infinite, -infinite, 1e-310, -1e-310, 5e-324, 1e308, -1e308];
        for x in cases {
            let (found, theirs) = (lanes(Fused(x)).0, system(x));
            let far = x.abs() == 1e308 && ["sin", "cos", "tan"].contains(&name);
            if name == "asinh" && x.abs() == 1e308 || name == "acosh" && x == 1e308 {
                assert_eq!(found, 709.889_355_822_726_f64.copysign(x)); // where the system's is infinite
            } else if theirs.is_nan() || far {
                assert!(found.is_nan(), "{name}({x:?}) = {found:?}");
            } else {
                assert_eq!(found.to_bits(), theirs.to_bits(), "{name}({x:?}) = {found:?}, not {theirs:?}");
            }
        }
    }
    let exp = |x| Fused(x).exp().0;
    assert_eq!(
        (exp(709.782_712_893_384), exp(709.782_712_893_385)),
        (f64::exp(709.782_712_893_384), infinite)
    );
    let smallest = -708.396_418_532_264_1_f64; // below it there are no normal numbers
    assert!((exp(smallest) / f64::exp(smallest) - 1.0).abs() < 1e-15 && exp(smallest.next_down()) == 0.0);
    assert!(
        Fused(710.475_860_073_943_9_f64).cosh().0.is_finite()
            && Fused(710.475_860_073_944_1_f64).cosh().0 == infinite
    );
    let farthest = 2.0_f64.powi(40);
    assert!(Fused(farthest).sin().0.is_finite() && Fused(farthest.next_up()).sin().0.is_nan());
}

/// Also of plain numbers: the standard library's own loses half of the digits near −1.
#[test]
fn plain_atanh_is_odd() {
    for x in [1e-9, 0.5, 0.99991, 0.999_999_999_f64] {
        assert_eq!(Real::atanh(-x), -Real::atanh(x));
        let exact = 0.5 * (x.ln_1p() - (-x).ln_1p());
        assert!((Real::atanh(-x) + exact).abs() <= 4.0 * f64::EPSILON * exact, "{x}");
        assert_eq!(Real::atanh(-x as f32), -Real::atanh(x as f32));
    }
    assert_eq!(Real::atanh(-1.0_f64), f64::NEG_INFINITY);
}

#[test]
fn odd_and_even_to_the_bit_and_sin_cos_is_both() {
    let mut random = SmallRng::seed_from_u64(7);
    for _ in 0..100_000 {
        let x = Fused(random.random_range(-30.0..30.0));
        for (odd, even) in [(Real::sin as fn(_) -> _, Real::cos as fn(_) -> _), (Real::sinh, Real::cosh)] {
            assert_eq!((odd(-x), even(-x)), (-odd(x), even(x)));
        }
        for odd in [Real::tanh, Real::tan, Real::atan, Real::cbrt, Real::erf, Real::asinh] {
            assert_eq!(odd(-x), -odd(x));
        }
        let part = x / Fused(30.0);
        for odd in [Real::asin as fn(_) -> _, Real::atanh] {
            assert_eq!(odd(-part), -odd(part));
        }
        assert_eq!(x.sin_cos(), (x.sin(), x.cos()));
    }
}

#[test]
fn exact_where_the_value_is_a_float() {
    for k in -1074..1024 {
        let power = Fused(2.0_f64).powf(Fused(f64::from(k)));
        assert_eq!((power.0, power.log2().0), (2.0_f64.powf(f64::from(k)), f64::from(k)));
    }
    let mut ten = 1.0;
    for k in 0..23 {
        assert_eq!((Fused(ten).log10().0, Fused(10.0).powf(Fused(f64::from(k))).0), (f64::from(k), ten));
        ten *= 10.0;
    }
    for n in 1..2000 {
        let n = f64::from(n);
        assert_eq!((Fused(n * n * n).cbrt().0, Fused(n).powf(Fused(3.0)).0), (n, n * n * n));
        assert_eq!((Fused(3.0 * n).hypot(Fused(4.0 * n)).0, Fused(n * n).powf(Fused(0.5)).0), (5.0 * n, n));
    }
}

/// All functions of each of some numbers and of it and the next.
struct All<'a>(&'a [f64; 64]);

impl Work for All<'_> {
    type Done = Vec<u64>;
    #[inline(always)]
    fn run(self) -> Vec<u64> {
        let numbers = self.0.map(Fused);
        let mut bits = Vec::new();
        macro_rules! of_one {
            ($($name:ident)*) => {$(bits.extend(numbers.map(|x| Real::$name(x).0.to_bits()));)*};
        }
        macro_rules! of_two {
            ($($name:ident)*) => {$(
                bits.extend(from_fn::<_, 64, _>(|i| Real::$name(numbers[i], numbers[(i + 1) % 64]).0.to_bits()));
            )*};
        }
        of_one!(exp ln sin cos tan sinh cosh tanh atan asin acos log2 log10 cbrt erf asinh acosh atanh sqrt abs floor);
        of_two!(powf atan2 hypot);
        bits
    }
}

#[test]
fn the_same_bits_with_all_instructions() {
    use InstructionSet::{Avx2, Avx512, Portable};
    let mut random = SmallRng::seed_from_u64(9);
    for size in [1.0, 10.0, 1e3, 1e300] {
        for _ in 0..200 {
            let numbers = from_fn(|_| random.random_range(-size..size));
            let expected = <Fused<f64> as Lane>::run(Portable, All(&numbers)); // its products and sums are calls
            for set in [Avx2, Avx512].into_iter().filter(|set| set.is_present()) {
                let found = <Fused<f64> as Lane>::run(set, All(&numbers));
                for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
                    let (found, expected) = (f64::from_bits(*found), f64::from_bits(*expected));
                    let same = found.to_bits() == expected.to_bits() || found.is_nan() && expected.is_nan();
                    assert!(same, "{set}, function {}: {found:?}, not {expected:?}", i / 64);
                }
            }
        }
    }
}

/// In single precision: the largest error of those functions that have code of their own; the others are the value in
/// double precision, rounded.
const SINGLE: [(&str, f64); 7] =
    [("exp", 0.9), ("ln", 0.8), ("sin", 1.6), ("cos", 1.6), ("sinh", 1.7), ("cosh", 1.4), ("tanh", 1.4)];

/// A million of all floats there are, evenly by their bits, against the system's functions of double precision.
#[test]
#[cfg(long)]
fn single_precision() {
    for Row { name, single, system, .. } in ROWS {
        let allowed = SINGLE.iter().find(|row| row.0 == name).map_or(0.5 + 1e-6, |row| row.1);
        let mut worst = 0.0_f64;
        for bits in (0..=u32::MAX).step_by(4093) {
            let x = f32::from_bits(bits);
            let (found, theirs) = (single(Fused(x)).0, system(f64::from(x)));
            let too_far = x.abs() > 1_099_511_627_776.0 && ["sin", "cos", "tan"].contains(&name);
            let right = theirs as f32;
            if theirs.is_nan() || too_far {
                assert!(found.is_nan(), "{name}({x:?}) = {found:?}, not a number");
            } else if right.is_infinite() || theirs == 0.0 {
                assert_eq!(found.to_bits(), right.to_bits(), "{name}({x:?}) = {found:?}, not {right:?}");
            } else {
                let unit = f64::from(f32::from_bits(right.abs().to_bits() + 1)) - f64::from(right.abs());
                let off = (f64::from(found) - theirs).abs() / unit;
                assert!(off <= allowed, "{name}({x:?}) = {found:?}, {off} units off {theirs:?}");
                worst = worst.max(off);
            }
        }
        println!("{name}: at most {worst:.3} units of the last place in single precision");
        assert!(worst > 0.5 * allowed, "{name}: {worst}");
    }
}
