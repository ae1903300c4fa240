//! Inputs that are too deep or too long end in an error, never in a stack overflow.

use proc_macro2::{TokenStream, TokenTree};
use rattle_symbolic::{Macro, expand};

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

fn tokens(stream: TokenStream) -> usize {
    let own = |token| match token {
        TokenTree::Group(group) => 2 + tokens(group.stream()),
        _ => 1,
    };
    stream.into_iter().map(own).sum()
}

fn lets(n: usize, next: impl Fn(String) -> String) -> String {
    let lets: String = (1..=n).map(|k| format!("let f{k} = {};", next(format!("f{}", k - 1)))).collect();
    format!("|x, y| {{ let f0 = x + y; {lets} f{n} }}")
}

/// What is twice as long makes about twice as much, not four times, and only so many tokens for each part.
/// Twice is not exact: rarer functions are left to the trait, and long ones come in chapters.
#[test]
fn long_is_fine() {
    type Shape = (&'static str, usize, usize, fn(usize) -> String);
    let shapes: [Shape; 9] = [
        // name, size, tokens for each, expression
        ("one precedence", 800, 120, |n| {
            format!("|x, y| {}", (0..n).map(|i| format!("x * {i} + y")).collect::<Vec<_>>().join(" - "))
        }),
        ("products", 80, 1200, |n| lets(n, |f| format!("{f} * y + x"))),
        ("sines", 80, 1600, |n| lets(n, |f| format!("sin({f}) + x"))),
        ("quotients", 80, 3000, |n| lets(n, |f| format!("y / (1 + {f}^2)"))),
        ("branches", 100, 1800, |n| lets(n, |f| format!("if {f} < 0 {{ {f} * y }} else {{ x + {f} }}"))),
        ("norm", 200, 700, |n| format!("|x: [f64; {n}]| norm(x) - 1")),
        ("many variables", 200, 700, |n| format!("|x: [f64; {n}]| sum(i in 0..{n}, x[i]^4) - 1")),
        ("kinks", 200, 900, |n| {
            format!("|x: [f64; {n}]| sum(i in 0..{n}, if x[i] < 0 {{ x[i]^2 }} else {{ x[i] }})")
        }),
        ("conditions", 300, 700, |n| {
            let all = (0..n).map(|i| format!("x < {i}")).collect::<Vec<_>>().join(" && ");
            format!("|x, y| if {all} {{ x }} else {{ y }}")
        }),
    ];
    for (name, n, most, shape) in shapes {
        let count = |n| {
            let input: TokenStream = format!("struct A {{}} {}", shape(n)).parse().expect("tokens");
            let output = expand(Macro::Constraint, input);
            assert!(!output.to_string().contains("compile_error"), "{name}");
            tokens(output)
        };
        let (once, twice) = (count(n), count(2 * n));
        println!("{name}: {} and {} tokens for each", once / n, twice / (2 * n));
        assert!(twice <= 3 * once, "{name}: {once} tokens for {n}, {twice} for twice as many");
        assert!(twice <= most * 2 * n, "{name}: {twice} tokens for {}", 2 * n);
    }
}
