//! An axis: the window on the numbers, where a number lies in it, and its ticks.
//!
//! ```text
//! linear        ticks at the multiples of 1, 2 or 5 · 10ᵏ
//! logarithmic   ticks at the powers of ten, every n-th where they are many, also at their multiples by 2 and 5 where they
//!               are few; a window of about a decade gets the ticks of a linear axis
//! ```

/// Room at the ends of a logarithmic axis, in decades.
const ROOM: f64 = 0.13;
/// With fewer decades an axis gets the ticks of a linear one, and with fewer than the second number 2 and 5 between.
const FEW_DECADES: [f64; 2] = [1.2, 3.5];
/// With more decades only every n-th has a tick.
const MANY_DECADES: f64 = 16.0;
/// What is shorter counts as nothing: a hundredth of it is still a double of full precision.
const SMALLEST: f64 = 1e-303;
/// A tick this part of a step outside is still at the end: the step is rounded.
const ROUNDING: f64 = 1e-9;
/// Numbers of a higher power of ten are not written in full.
const LARGEST_IN_FULL: i32 = 4;

/// The window on the numbers, as logarithms to base ten on a logarithmic axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis {
    log: bool,
    low: f64,
    high: f64,
}

/// A mark on an axis.
#[derive(Debug, PartialEq)]
pub(super) struct Tick {
    /// Where it lies: 0 at the axis's low end, 1 at its high end.
    pub(super) part: f64,
    pub(super) label: String,
}

impl Axis {
    /// A linear axis around the numbers, longer at both ends by this part of their range.
    pub(super) fn linear(values: impl Iterator<Item = f64>, margin: f64) -> Self {
        let (low, high) = range(values);
        let span = high - low;
        // A constant still gets an axis, wide enough that its ticks are distinct doubles.
        let room = if span > f64::max(1e-9 * low.abs().max(high.abs()), SMALLEST) {
            margin * span
        } else if low.abs() < SMALLEST {
            1.0
        } else {
            1e-3 * low.abs()
        };
        Self { log: false, low: low - room, high: high + room }
    }

    /// A logarithmic axis around the numbers, all positive.
    pub(super) fn logarithmic(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = range(values.map(f64::log10));
        Self { log: true, low: low - ROOM, high: high + ROOM }
    }

    /// How much the axis covers: in its numbers' unit, or in decades.
    pub(super) fn span(&self) -> f64 {
        self.high - self.low
    }

    /// Widens the window about its middle, to the span.
    pub(super) fn widen(&mut self, span: f64) {
        let room = 0.5 * (span - self.span());
        (self.low, self.high) = (self.low - room, self.high + room);
    }

    /// Where the number lies: 0 at the low end, 1 at the high end.
    pub(super) fn part(&self, value: f64) -> f64 {
        let value = if self.log { value.log10() } else { value };
        (value - self.low) / self.span()
    }

    /// The ticks in sight, on a linear axis about `number` and at least two.
    pub(super) fn ticks(&self, number: f64) -> Vec<Tick> {
        if !self.log {
            return self.multiples(self.low, self.high, number);
        }
        if self.span() < FEW_DECADES[0] {
            return self.multiples(10f64.powf(self.low), 10f64.powf(self.high), number);
        }
        let stride = 1 + (self.span() / MANY_DECADES) as i32;
        let digits: &[i64] = if self.span() < FEW_DECADES[1] { &[1, 2, 5] } else { &[1] };
        let decades = self.low.floor() as i32..=self.high.floor() as i32;
        let places =
            decades.filter(|decade| decade % stride == 0).flat_map(|k| digits.iter().map(move |&n| (n, k)));
        let tick = |(n, decade): (i64, i32)| Tick {
            part: (f64::from(decade) + (n as f64).log10() - self.low) / self.span(),
            label: self.label(n, decade),
        };
        places.map(tick).filter(|tick| (0.0..=1.0).contains(&tick.part)).collect()
    }

    /// Ticks at the multiples of the smallest step 1, 2 or 5 · 10ᵏ that makes at most `number` of them from `low` to
    /// `high`.
    fn multiples(&self, low: f64, high: f64, number: f64) -> Vec<Tick> {
        let wanted = (high - low) / f64::max(number, 3.0);
        let decade = wanted.log10().floor() as i32;
        let steps = [(1, decade), (2, decade), (5, decade)];
        let fits = |&(n, decade): &(i64, i32)| n as f64 * 10f64.powi(decade) >= wanted;
        let (n, decade) = steps.into_iter().find(fits).unwrap_or((1, decade + 1));
        let step = n as f64 * 10f64.powi(decade);
        let [first, last] = [(low / step - ROUNDING).ceil() as i64, (high / step + ROUNDING).floor() as i64];
        let tick = |i: i64| Tick { part: self.part(i as f64 * step), label: self.label(i * n, decade) };
        (first..=last).map(tick).collect()
    }

    /// The number n · 10ᵏ, in full where that is short, else with a power of ten: 0.25, 12000, 5·10⁻⁴, 10⁻¹⁶.
    fn label(&self, n: i64, decade: i32) -> String {
        if n == 0 {
            return "0".into();
        }
        let sign = if n < 0 { "−" } else { "" };
        let all = n.unsigned_abs().to_string();
        let digits = all.trim_end_matches('0');
        let exponent = decade + all.len() as i32 - 1; // of the first digit
        let smallest = if self.log { -2 } else { -3 }; // on a logarithmic axis 10⁻³ reads better among its neighbours
        let number = match exponent {
            0..=LARGEST_IN_FULL => pointed(digits, exponent as usize + 1),
            _ if (smallest..0).contains(&exponent) => {
                format!("0.{}{digits}", "0".repeat((-exponent - 1) as usize))
            }
            _ if digits == "1" => power(exponent),
            _ => format!("{}·{}", pointed(digits, 1), power(exponent)),
        };
        format!("{sign}{number}")
    }
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(value), high.max(value)))
}

/// The digits with so many of them before the point, filled up with zeros.
fn pointed(digits: &str, whole: usize) -> String {
    match digits.split_at_checked(whole) {
        Some((whole, rest)) if !rest.is_empty() => format!("{whole}.{rest}"),
        _ => format!("{digits:0<whole$}"),
    }
}

fn power(exponent: i32) -> String {
    let raised = |c: char| match c.to_digit(10) {
        Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
        None => '⁻',
    };
    format!("10{}", exponent.to_string().chars().map(raised).collect::<String>())
}
