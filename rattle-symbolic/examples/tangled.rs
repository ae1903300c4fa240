//! A program with a constraint of so many operations, each `let` made of the last ones: how long does it compile?
//!
//! ```text
//! cargo run -p rattle-symbolic --example tangled 5000 > examples/tangled.rs
//! touch examples/tangled.rs && CARGO_INCREMENTAL=0 cargo build --example tangled [--release]
//! ```
//!
//! Seconds for 5 000 operations, measured on one core of two: see `LARGE` in `src/routine.rs`.

use rattle_symbolic::{Macro, expand};
use std::error::Error;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let operations = std::env::args().nth(1).map_or(Ok(5000), |text| text.parse())?;
    let input = tangled(operations);
    let tokens = input.parse()?;
    let start = Instant::now();
    let output = expand(Macro::Constraint, tokens);
    eprintln!("expansion alone: {:.2?}, {} characters", start.elapsed(), output.to_string().len());
    println!("use rattle::prelude::*;\n\nrattle::constraint! {{\n    {input}\n}}\n");
    println!("fn main() {{\n    let (g, q) = (Tangled {{ a: 0.5 }}, [0.1, 0.2, 0.3].into());");
    println!("    println!(\"{{}} {{}}\", g.value_and_jacobian(&q).1, g.hessian_vector(&q, &q));");
    println!("    println!(\"{{:?}}\", g.jet(&q, &q));\n}}");
    Ok(())
}

/// Every `let` has 16 operations: sums and products of the three before it, a quotient, a root and a sine.
fn tangled(operations: usize) -> String {
    let mut lets = String::from("let f0 = x; let f1 = y; let f2 = z;");
    let last = operations / 16 + 2;
    for k in 3..=last {
        let (p, q, r) = (k - 1, k - 2, k - 3);
        lets += &format!(
            " let f{k} = (f{p} * f{q} + a * f{r} * x + f{q} / (2 + f{p}^2) + sqrt(1 + f{r}^2) + sin(f{p} + y)) / 4;"
        );
    }
    format!("struct Tangled {{ a }} |x, y, z| {{ {lets} f{last} - a }}")
}
