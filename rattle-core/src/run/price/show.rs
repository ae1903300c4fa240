//! Prices as text: tables for people, rows for programs.

use crate::run::price::prices::{Price, Prices, Quantity};
use std::fmt::{self, Write};

impl fmt::Display for Prices {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, second] = self.reference;
        write!(
            f,
            "measured on {} of {} units of time, in {:.2} s; ",
            figure(self.pilot, 4),
            figure(self.duration, 4),
            self.seconds
        )?;
        writeln!(f, "errors against {first}, which {second} repeats to {:.1e}", self.reference_error)?;
        if let (Some(lyapunov), Some(predictable)) = (self.lyapunov_time, self.predictable) {
            writeln!(
                f,
                "chaotic: Lyapunov time {}; positions can be told until {} after the start",
                figure(lyapunov, 3),
                figure(predictable, 3)
            )?;
            if !self.tells_positions() {
                let until = figure(self.positions_until, 3);
                writeln!(
                    f,
                    "errors of position are those until {until}; beyond, of energy and averages alone"
                )?;
            }
        }
        for average in &self.averages {
            let mean = figure(average.mean, 6);
            writeln!(f, "mean of {}: {mean} ± {:.1e}", average.name, average.uncertainty)?;
        }
        let names = self.methods().into_iter().map(|method| method.to_string().chars().count() + 2);
        let wide = names.max().unwrap_or(0).max(34);
        if !f.alternate() {
            let (front, all) = (self.rows.iter().filter(|row| row.front).count(), self.rows.len());
            writeln!(f, "the {front} of {all} rows that nothing cheaper is as exact as; `{{:#}}` shows all")?;
        }
        writeln!(
            f,
            "\n{:wide$}  {:>9}  {:>9}  {:>9}  {:>6}  {:>11}  {:>5}  {:>9}",
            "method (* on the front)",
            "h or tol.",
            "position",
            "energy",
            "order",
            "ns per time",
            "±",
            "steps"
        )?;
        let all = f.alternate();
        for row in self.rows.iter().filter(|row| row.front || all) {
            let mark = if row.front { "*" } else { "" };
            let order = row.order.map_or(String::new(), |order| format!("{order:.1}"));
            let order = if row.rounding { "floor".into() } else { order };
            let position = row.position.map_or("–".into(), |error| format!("{error:.1e}"));
            write!(
                f,
                "{:wide$}  {:9.2e}  {position:>9}  {:9.1e}  {order:>6}  {:11.0}  {:4.0}%  {:9}",
                format!("{} {mark}", row.method),
                row.fineness(),
                row.energy,
                1e9 * row.seconds,
                100.0 * row.spread,
                row.steps,
            )?;
            for (average, error) in self.averages.iter().zip(&row.averages) {
                write!(f, "  {}: {error:.1e}", average.name)?;
            }
            writeln!(f)?;
        }
        for refused in &self.refused {
            match &refused.why {
                Some(why) => writeln!(f, "{}: {why}", refused.method)?,
                None => writeln!(f, "{}: no time within the budget", refused.method)?,
            }
        }
        let what = if self.quantity() == Quantity::Position { "position" } else { "energy" };
        for (digits, whose) in
            [(self.digits(), ""), (self.digits_in_lanes(), " and trajectory, side by side")]
        {
            if whose.is_empty() || !digits.is_empty() {
                writeln!(f, "\ndigits of {what}  ns per unit of time{whose}")?;
            }
            for (digits, nanoseconds, method) in digits {
                writeln!(f, "{digits:6}  {nanoseconds:19.0}  {method}")?;
            }
        }
        Ok(())
    }
}

impl Prices {
    /// All rows as comma-separated values, with names in the first line; seconds are per unit of simulated time.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut text = String::from(
            "method,h,tolerance,position,energy,seconds,spread,steps,corrections,order,rounding,front",
        );
        for average in &self.averages {
            let _ = write!(text, ",{}", quoted(&average.name));
        }
        text.push('\n');
        for Price {
            method,
            h,
            tolerance,
            position,
            energy,
            seconds,
            spread,
            steps,
            corrections,
            order,
            rounding,
            front,
            averages,
            ..
        } in &self.rows
        {
            let number = |x: &Option<f64>| x.map_or(String::new(), |x| format!("{x:e}"));
            let corrections = corrections.map_or(String::new(), |n| n.to_string());
            let _ = write!(
                text,
                "{},{h:e},{},{},{energy:e},{seconds:e},{spread:e},{steps},{corrections},{},{rounding},{front}",
                quoted(&method.to_string()),
                number(tolerance),
                number(position),
                number(order),
            );
            for error in averages {
                let _ = write!(text, ",{error:e}");
            }
            text.push('\n');
        }
        text
    }
}

/// With so many decimals, or by a power of ten where they would hide the number or be lost behind it.
pub(super) fn figure(x: f64, decimals: usize) -> String {
    if x == 0.0 || (1e-3..1e6).contains(&x.abs()) {
        format!("{x:.decimals$}")
    } else {
        format!("{x:.decimals$e}")
    }
}

/// A field of its own, whatever is in it.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.into()
    }
}
