//! What the generated documentation says.

use rattle_symbolic::functions::Function;
use rattle_symbolic::{Macro, expand};

#[test]
fn formula_gradient_and_counts() {
    let input = "/// A surface.
        pub struct Lemniscate { a, r }
        |x, y, z| { let f = (x^2 + y^2)^2 - a^2 * (x^2 - y^2); f^2 + z^2 - r^2 }";
    let output = expand(Macro::Constraint, input.parse().expect("tokens")).to_string();
    println!("{}", &output[..1800]);
    for line in [
        "f = (x^2 + y^2)^2 - a^2 * (x^2 - y^2)",
        "g = f^2 + z^2 - r^2",
        "∂g/∂x = 8 * x * f * ((x^2 + y^2) - 0.5 * a^2)",
        "∂g/∂z = 2 * z\"",
        "11 `value`, 19 `value_and_jacobian`",
        "41 `jet`",
    ] {
        assert!(output.contains(line), "{line}");
    }
}

/// Each component has its line and its indices, named parts keep their names, and loops have none.
#[test]
fn derivatives_by_component() {
    let input = "struct Two {} |q: [f64; 2], z| { let s = norm(q); let c = [q[0] * z, 1]; [s * z, dot(c, q), for i in 0..1 { let t = q[i]^2; t * z }] }";
    let output = expand(Macro::Constraint, input.parse().expect("tokens")).to_string();
    for line in [
        "∂g[0]/∂q[0] = q[0] * z * ",
        "∂g[0]/∂z = s",
        "∂g[1]/∂q[1] = 1",
        "∂g[2]/∂q[1] = 0",
        "∂g[2]/∂q[0] = 2 * q[0] * z",
    ] {
        assert!(output.contains(&format!("\"{line}")), "{line} in {}", &output[..1200]);
    }
}

/// Names of `let`s are those of what stands outside of loops, also after a loop. A power is shown as it is written.
#[test]
fn names_after_a_loop() {
    let input =
        "struct S {} |q: [f64; 2], z| { let s = norm(q); let c = sum(k in 0..2, q[k]^1.7); s * z + c }";
    let output = expand(Macro::Constraint, input.parse().expect("tokens")).to_string();
    for line in ["∂g/∂z = s\"", "∂g/∂q[0] = 1.7 * q[0]^0.7 + q[0] * z * (if s <= 0 { 0 } else { 1 / s })"]
    {
        assert!(output.contains(&format!("\"{line}")), "{line} in {}", &output[..1200]);
    }
    assert!(output[..1500].contains("q[0]^0.7") && !output[..1500].contains("powf(q"), "{}", &output[..1500]);
}

/// Derivatives of several equations of coordinates and momenta, each by its own variable.
#[test]
fn derivatives_on_phase_space() {
    let input = "struct Two {} |q: [f64; 2], p: [f64; 2]| [q[0]^3 * p[1]^2 - 1, q[1]^5 * p[0]^7 - 2]";
    let output = expand(Macro::PhaseConstraint, input.parse().expect("tokens")).to_string();
    for line in [
        "∂g[0]/∂q[0] = 3 * q[0]^2 * p[1]^2",
        "∂g[0]/∂q[1] = 0",
        "∂g[0]/∂p[0] = 0",
        "∂g[0]/∂p[1] = 2 * q[0]^3 * p[1]",
        "∂g[1]/∂q[0] = 0",
        "∂g[1]/∂q[1] = 5 * p[0]^7 * q[1]^4",
        "∂g[1]/∂p[0] = 7 * q[1]^5 * p[0]^6",
        "∂g[1]/∂p[1] = 0",
    ] {
        assert!(output.contains(&format!("\"{line}")), "{line} in {}", &output[..1200]);
    }
}

/// Conditions are shown as they are read: `&&` binds tighter than `||`, and comparisons tighter than both.
#[test]
fn conditions_as_written() {
    let rows = [
        ("(x < 0 || y < 1) && y < 2", "(x < 0 || y < 1) && y < 2"),
        ("x < 0 || y < 1 && y < 2", "x < 0 || y < 1 && y < 2"),
        ("x < 0 || (y < 1 && y < 2)", "x < 0 || y < 1 && y < 2"),
        ("(x < 0) && (y + 1 < x - 2) && x <= y", "x < 0 && y + 1 < x - 2 && x <= y"),
        ("x < 0 && (y < 1 && y < 2)", "x < 0 && (y < 1 && y < 2)"),
    ];
    for (written, shown) in rows {
        let input = format!("struct A {{}} |x, y| if {written} {{ x }} else {{ y }}");
        let output = expand(Macro::Potential, input.parse().expect("tokens")).to_string();
        assert!(
            output.contains(&format!("\"U = if {shown} {{ x }} else {{ y }}\"")),
            "{written}: {output:.600}"
        );
    }
}

/// A list of functions: a file, its text, where in it the list begins and ends, and which ones it leaves out.
struct List {
    file: &'static str,
    text: &'static str,
    ends: [&'static str; 2],
    without: &'static [&'static str],
}

macro_rules! lists {
    ($($file:literal $begin:literal $end:literal, without $without:expr;)*) => {
        [$(List {
            file: $file,
            text: include_str!(concat!("../../", $file)),
            ends: [$begin, $end],
            without: &$without,
        }),*]
    };
}

/// Pages that list the functions of the table, and tests that ask each one.
const LISTS: [List; 8] = lists! {
    "rattle-macros/src/lib.rs"   "functions    "       "also as methods", without [];
    "docs/guide/constraints.md"  "functions    "       "also as methods", without [];
    "benches/kernels.rs"         "    each_of! {"      "\n    }",        without ["abs", "sign", "floor"];
    "tests/derivatives.rs"       "    functions! {\n" "\n    }",        without [];
    "tests/functions.rs"         "= rows! {"           "\n}",            without ["sqrt", "abs", "sign", "floor"];
    "tests/functions.rs"         "of_one!(exp"         ");",             without ["sign"];
    "tests/series.rs"            "\nfunctions! {"      "\n}",            without [];
    "tests/taylor.rs"            "\nfunctions! {"      "\n}",            without [];
};

#[test]
fn every_function_is_listed() {
    let mut missing = Vec::new();
    for List { file, text, ends: [begin, end], without } in LISTS {
        let list = text.find(begin).map(|at| &text[at..]).unwrap_or_else(|| panic!("{file}: no `{begin}`"));
        let list = list.find(end).map(|at| &list[..at]).unwrap_or_else(|| panic!("{file}: no `{end}`"));
        let words: Vec<&str> = list.split(|c: char| !(c.is_alphanumeric() || c == '_')).collect();
        let names = Function::ALL.iter().map(|function| function.name());
        let lost = names.filter(|name| !words.contains(name) && !without.contains(name));
        missing.extend(lost.map(|name| format!("{file}, after `{begin}`: `{name}`")));
    }
    assert!(missing.is_empty(), "functions that lists lack: {missing:#?}");
}
