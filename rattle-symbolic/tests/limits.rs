//! Inputs that are too deep or too long end in an error, never in a stack overflow.

use proc_macro2::TokenStream;
use rattle_symbolic::expand::{Macro, expand};
use std::time::{Duration, Instant};

fn expanded(expression: &str) -> String {
    let input: TokenStream = format!("pub struct A {{}} |x, y| {expression}").parse().expect("tokens");
    expand(Macro::Constraint, input).to_string()
}

#[test]
fn too_deep() {
    let rows = [
        format!("y + {}x{}", "(".repeat(400), ")".repeat(400)),
        format!("y + {} x", "- ".repeat(4000)),
        format!("y + {} 2", "x ^ ".repeat(4000)),
        format!("y + x{}", ".sin()".repeat(4000)),
        format!("y + {} x {}", "{ let a = x; a + ".repeat(300), "}".repeat(300)),
        format!("y + {} x", "if x < 1 { y } else ".repeat(1000)),
        format!("y + {}x{}", "sum(i in 0..2, ".repeat(300), ")".repeat(300)),
    ];
    for row in rows {
        let result = expanded(&row);
        assert!(result.contains("nested too deeply"), "{}: {}", &row[..40], &result[..result.len().min(400)]);
        assert!(result.contains("struct A"), "a stub stands in");
    }
}

/// A chain of one precedence is not nesting.
#[test]
fn long_is_fine() {
    let start = Instant::now();
    let result = expanded(&(0..5000).map(|i| format!("x * {i} + y")).collect::<Vec<_>>().join(" - "));
    assert!(!result.contains("compile_error"));
    assert!(result.contains("fn jet"));
    // A generous guard against quadratic passes, not a measurement: it takes about a second.
    assert!(start.elapsed() < Duration::from_secs(60), "{:?}", start.elapsed());
}
