//! An axis: the window on the numbers, where a number lies in it, and its ticks. The window ends at ticks.
//!
//! ```text
//! linear        ticks at the multiples of 1, 2 or 5 · 10ᵏ
//! logarithmic   ticks at the powers of ten, every n-th where they are many, also at their multiples by 2 and 5 where they
//!               are few; a window of about a decade gets the ticks of a linear axis
//! ```

use crate::constant::is_constant;

/// With fewer decades an axis gets the ticks of a linear one, and with fewer than the second number 2 and 5 between.
const FEW_DECADES: [f64; 2] = [1.2, 3.5];
/// With more decades only every n-th has a tick.
const MANY_DECADES: f64 = 16.0;
/// What is shorter counts as nothing: a hundredth of it is still a double of full precision.
const SMALLEST: f64 = 1e-303;
/// A tick this part of a step outside is still at the end: the step is rounded.
const ROUNDING: f64 = 1e-9;
/// The powers of ten of numbers that are written in full, and the most decimals of such numbers.
const IN_FULL: [i32; 2] = [-3, 5];
const MOST_DECIMALS: i32 = 7;

/// The window on the numbers, as logarithms to base ten on a logarithmic axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis {
    log: bool,
    low: f64,
    high: f64,
    ticks: Ticks,
}

/// Where an axis has ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Ticks {
    Multiples(Step),
    /// At the powers of ten, and at 2 and 5 times those.
    Digits,
    /// At every n-th power of ten.
    Decades(i32),
}

/// A mark on an axis.
#[derive(Debug, PartialEq)]
pub(super) struct Tick {
    /// Where it lies: 0 at the axis's low end, 1 at its high end.
    pub(super) part: f64,
    pub(super) label: String,
}

impl Axis {
    /// A linear axis from the last tick at or below the numbers to the first at or above them, with about so many
    /// ticks.
    pub(super) fn linear(values: impl Iterator<Item = f64>, number: f64) -> Self {
        let (low, high) = range(values);
        // A constant still gets an axis, wide enough that its ticks are distinct doubles.
        let room = if !is_constant(low, high) && high - low > SMALLEST {
            0.0
        } else if low.abs() < SMALLEST {
            1.0
        } else {
            1e-3 * low.abs()
        };
        let (low, high) = (low - room, high + room);
        let step = Step::of(high - low, number);
        let [low, high] = step.around(low, high);
        Self { log: false, low, high, ticks: Ticks::Multiples(step) }
    }

    /// A logarithmic axis around the numbers, all positive, from tick to tick.
    pub(super) fn logarithmic(values: impl Iterator<Item = f64>, number: f64) -> Self {
        let (mut low, mut high) = range(values.map(f64::log10));
        if high - low < 1e-3 {
            (low, high) = (low - 0.3, high + 0.3);
        }
        let from = |[low, high]: [f64; 2], ticks| Self { log: true, low, high, ticks };
        if high - low < FEW_DECADES[0] {
            let (low, high) = (10f64.powf(low), 10f64.powf(high));
            let step = Step::of(high - low, number);
            let [below, above] = step.around(low, high);
            let ends = [if below > 0.0 { below } else { low }, above];
            return from(ends.map(f64::log10), Ticks::Multiples(step));
        }
        if high - low < FEW_DECADES[1] {
            let digits = [1.0, 2.0, 5.0, 10.0].map(f64::log10);
            let below = digits.map(|d| low.floor() + d).into_iter().rfind(|tick| *tick <= low + ROUNDING);
            let above = digits.map(|d| high.floor() + d).into_iter().find(|tick| *tick >= high - ROUNDING);
            return from([below.unwrap_or(low), above.unwrap_or(high)], Ticks::Digits);
        }
        let stride = 1 + ((high - low) / MANY_DECADES) as i32;
        let many = f64::from(stride);
        let [below, above] = [(low + ROUNDING) / many, (high - ROUNDING) / many];
        from([many * below.floor(), many * above.ceil()], Ticks::Decades(stride))
    }

    /// How much the axis covers: in its numbers' unit, or in decades.
    pub(super) fn span(&self) -> f64 {
        self.high - self.low
    }

    /// Widens a linear axis about its middle, to the span, with about so many ticks.
    pub(super) fn widen(&mut self, span: f64, number: f64) {
        let room = 0.5 * (span - self.span());
        if room > ROUNDING * span {
            (self.low, self.high) = (self.low - room, self.high + room);
            self.ticks = Ticks::Multiples(Step::of(span, number));
        }
    }

    /// Where the number lies: 0 at the low end, 1 at the high end.
    pub(super) fn part(&self, value: f64) -> f64 {
        let value = if self.log { value.log10() } else { value };
        (value - self.low) / self.span()
    }

    /// Where bars begin: zero, or the low end where there is no zero.
    pub(super) fn base(&self) -> f64 {
        if self.log { 10f64.powf(self.low) } else { 0f64.clamp(self.low, self.high) }
    }

    /// The ticks in sight.
    pub(super) fn ticks(&self) -> Vec<Tick> {
        let (stride, digits): (i32, &[i64]) = match self.ticks {
            Ticks::Multiples(step) => return self.multiples(step),
            Ticks::Digits => (1, &[1, 2, 5]),
            Ticks::Decades(stride) => (stride, &[1]),
        };
        let decades = (self.low + ROUNDING).floor() as i32..=(self.high + ROUNDING).floor() as i32;
        let places: Vec<(i64, i32)> = decades
            .filter(|decade| decade % stride == 0)
            .flat_map(|k| digits.iter().map(move |&n| (n, k)))
            .filter(|&(n, k)| {
                let place = f64::from(k) + (n as f64).log10();
                (self.low - ROUNDING..=self.high + ROUNDING).contains(&place)
            })
            .collect();
        // From a hundredth to ten thousand in full, or all by powers of ten.
        let full = places.iter().all(|&(_, k)| (-2..IN_FULL[1]).contains(&k));
        let label = |n: i64, k: i32| match (full, n) {
            (true, _) => fixed(n, k, (-k).max(0)),
            (false, 1) => power(k),
            (false, _) => format!("{n}·{}", power(k)),
        };
        let part = |n: i64, k: i32| (f64::from(k) + (n as f64).log10() - self.low) / self.span();
        places.into_iter().map(|(n, k)| Tick { part: part(n, k), label: label(n, k) }).collect()
    }

    /// Ticks at the multiples of a step, all in one notation: in full with equally many decimals, or with one power of
    /// ten.
    fn multiples(&self, Step { n, decade, size }: Step) -> Vec<Tick> {
        let [low, high] = [self.low, self.high].map(|end| if self.log { 10f64.powf(end) } else { end });
        let [first, last] =
            [rounded(low / size, -1.0).ceil() as i64, rounded(high / size, 1.0).floor() as i64];
        let largest = first.unsigned_abs().max(last.unsigned_abs()) as i64 * n;
        let exponent = decade + largest.to_string().len() as i32 - 1; // of the largest number's first digit
        let full = (IN_FULL[0]..=IN_FULL[1]).contains(&exponent) && -decade <= MOST_DECIMALS;
        let label = |i: i64| match (i, full) {
            (0, _) => "0".into(),
            (_, true) => fixed(i * n, decade, (-decade).max(0)),
            (_, false) => {
                let decimals = (exponent - decade).max(0);
                format!("{}·{}", fixed(i * n, decade - exponent, decimals), power(exponent))
            }
        };
        (first..=last).map(|i| Tick { part: self.part(i as f64 * size), label: label(i) }).collect()
    }
}

/// n · 10ᵏ with n = 1, 2 or 5.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Step {
    n: i64,
    decade: i32,
    size: f64,
}

impl Step {
    /// The smallest step that fits into the span at most `number` times.
    fn of(span: f64, number: f64) -> Self {
        let wanted = span / f64::max(number, 3.0) * (1.0 - ROUNDING);
        let decade = wanted.log10().floor() as i32;
        let steps = [(1, decade), (2, decade), (5, decade)];
        let fits = |&(n, decade): &(i64, i32)| n as f64 * 10f64.powi(decade) >= wanted;
        let (n, decade) = steps.into_iter().find(fits).unwrap_or((1, decade + 1));
        Self { n, decade, size: n as f64 * 10f64.powi(decade) }
    }

    /// The nearest multiples around both.
    fn around(&self, low: f64, high: f64) -> [f64; 2] {
        let [below, above] = [
            rounded(low / self.size, 1.0).floor() * self.size,
            rounded(high / self.size, -1.0).ceil() * self.size,
        ];
        [low.min(below), high.max(above)]
    }
}

/// A number of steps, so much up or down that rounding makes no step of it; many steps are rounded themselves.
fn rounded(steps: f64, sign: f64) -> f64 {
    steps + sign * f64::max(ROUNDING, 4.0 * f64::EPSILON * steps.abs())
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(value), high.max(value)))
}

/// n · 10ᵏ in full, with so many decimals.
fn fixed(n: i64, decade: i32, decimals: i32) -> String {
    let sign = if n < 0 { "−" } else { "" };
    let mut digits = n.unsigned_abs().to_string();
    digits.extend(std::iter::repeat_n('0', (decade + decimals).max(0) as usize));
    let decimals = decimals as usize;
    let digits = format!("{digits:0>width$}", width = decimals + 1);
    match digits.split_at(digits.len() - decimals) {
        (whole, "") => format!("{sign}{whole}"),
        (whole, rest) => format!("{sign}{whole}.{rest}"),
    }
}

fn power(exponent: i32) -> String {
    let raised = |c: char| match c.to_digit(10) {
        Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
        None => '⁻',
    };
    format!("10{}", exponent.to_string().chars().map(raised).collect::<String>())
}
