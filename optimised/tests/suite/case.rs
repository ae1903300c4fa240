//! A row of the table, and what becomes of it: measured, printed, written to the page.

use rattle::Error;
use std::fmt::Write;

/// What a row measures; an error is beyond every bound.
pub type Measured = Result<f64, Error>;

/// One hard case.
pub struct Case {
    pub name: String,
    /// Why naive code breaks there.
    pub why: &'static str,
    /// What holds instead: a solution, an invariant, an error.
    pub expect: &'static str,
    /// The largest number that may be measured, and why this one.
    pub bound: f64,
    pub reason: &'static str,
    pub measure: Box<dyn Fn() -> Measured + Send + Sync>,
    /// Whether it takes seconds if it is not optimised: `cargo long` measures it.
    pub long: bool,
}

/// What the cases of one kind have in common.
#[derive(Clone, Copy)]
pub struct Kind {
    pub why: &'static str,
    pub expect: &'static str,
    pub reason: &'static str,
}

impl Kind {
    pub fn case(
        self,
        name: impl Into<String>,
        bound: f64,
        measure: impl Fn() -> Measured + Send + Sync + 'static,
    ) -> Case {
        let Self { why, expect, reason } = self;
        Case { name: name.into(), why, expect, bound, reason, measure: Box::new(measure), long: false }
    }

    /// A case that takes long.
    pub fn long(
        self,
        name: impl Into<String>,
        bound: f64,
        measure: impl Fn() -> Measured + Send + Sync + 'static,
    ) -> Case {
        Case { long: true, ..self.case(name, bound, measure) }
    }
}

/// The cases of one area.
pub struct Area {
    pub name: &'static str,
    pub cases: Vec<Case>,
}

/// A case with what was measured.
pub struct Row {
    pub case: Case,
    pub measured: Measured,
}

impl Row {
    pub fn of(case: Case) -> Self {
        let measured = (case.measure)();
        Self { case, measured }
    }

    /// Not a number is beyond every bound.
    pub fn holds(&self) -> bool {
        matches!(self.measured, Ok(found) if found <= self.case.bound)
    }

    /// One line for the terminal.
    pub fn line(&self) -> String {
        let found = match &self.measured {
            Ok(found) => short(*found),
            Err(error) => error.to_string(),
        };
        let verdict = if self.holds() { "  " } else { "✗ " };
        format!("{verdict}{:<64} {found:>8} ≤ {}", self.case.name, short(self.case.bound))
    }
}

/// Counts as they are, other numbers to two digits.
fn short(x: f64) -> String {
    if x == x.trunc() && x.abs() < 100.0 { format!("{x}") } else { format!("{x:.1e}") }
}

/// What opens the page.
const HEAD: &str = "# Hard cases

Where naive code breaks, what holds here instead, and what was measured. The suite writes this page, and fails where
a number is beyond its bound:

```sh
cargo long --test cases suite:: -- --nocapture          # measures all rows; `cargo test` those that take no seconds
cargo long --test cases suite::page -- --ignored       # writes this page
```

Lengths, times and masses are of size one where a case says nothing else. ε is 2.2e-16. A bound of 0 is met bit for
bit, or by every attempt. 〃 is the same as above. Measured numbers are those of one machine: last digits differ.
";

/// The page, in Markdown.
pub fn page(areas: &[(&'static str, Vec<Row>)]) -> String {
    let mut text = HEAD.to_string();
    for (area, rows) in areas {
        let _ = writeln!(text, "\n## {area}\n");
        let _ = writeln!(
            text,
            "| case | what breaks elsewhere | what holds here | measured | bound | why this bound |"
        );
        let _ = writeln!(text, "|---|---|---|---|---|---|");
        let mut above = ["", "", ""];
        for Row { case, measured } in rows {
            let now = [case.why, case.expect, case.reason];
            let [why, expect, reason] =
                std::array::from_fn(|i| if now[i] == above[i] { "〃" } else { now[i] });
            let found = measured.as_ref().map_or_else(|_| "an error".to_string(), |found| short(*found));
            let cells = [&case.name, why, expect, &found, &short(case.bound), reason]
                .map(|cell| cell.replace('|', "\\|"));
            let _ = writeln!(text, "| {} |", cells.join(" | "));
            above = now;
        }
    }
    text
}

/// The areas and names of cases that a page lists, in order.
pub fn listed(page: &str) -> Vec<(String, String)> {
    let mut area = String::new();
    let mut names = Vec::new();
    for line in page.lines() {
        if let Some(name) = line.strip_prefix("## ") {
            area = name.to_string();
        } else if let Some(row) = line.strip_prefix("| ")
            && let Some((name, _)) = row.split_once(" |")
            && name != "case"
        {
            names.push((area.clone(), name.replace("\\|", "|")));
        }
    }
    names
}
