//! Inputs that are too deep or too long end in an error, never in a stack overflow.

use proc_macro2::{TokenStream, TokenTree};
use rattle_symbolic::functions::{Binary, Function};
use rattle_symbolic::graph::Graph;
use rattle_symbolic::node::{Comparison, Id, Input};
use rattle_symbolic::routine::{constraint, potential};
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
        format!("y + {} x", "- ".repeat(100_000)),
        format!("y + {} 2", "x ^ ".repeat(100_000)),
        format!("y + x{}", ".sin()".repeat(100_000)),
        format!("y + x{}", "[0]".repeat(100_000)),
        format!("y + {} x", "if x < 1 { y } else ".repeat(100_000)),
        format!("y + {} x", "sqrt ".repeat(100_000)),
        format!("y + x {}", "= y ".repeat(100_000)),
        format!("y + {}x{}", "2^(".repeat(300), ")".repeat(300)),
        format!("y + {}x{}", "x[".repeat(300), "]".repeat(300)),
    ];
    for row in rows {
        let result = expanded(&row);
        assert!(result.contains("nested too deeply"), "{}: {}", &row[..40], &result[..result.len().min(400)]);
        assert!(result.contains("struct A"), "a stub stands in");
    }
}

/// Brackets this deep would exhaust the stack of whoever looks into them.
#[test]
fn brackets_without_end() {
    let n = 100_000;
    for (open, close) in
        [("(", ")"), ("[", "]"), ("{", "}"), ("sin(", ")"), ("x[", "]"), ("if ({", "}) < 1 { x } else { y }")]
    {
        let result = expanded(&format!("y + {}x{}", open.repeat(n), close.repeat(n)));
        assert!(result.contains("brackets nest more than"), "{open}: {}", &result[..result.len().min(400)]);
    }
    for place in
        ["#[doc{}] struct A { a } |x| a * x", "struct A { a: {} } |x| a * x", "struct A {} |x: {}| x"]
    {
        let input = place.replace("{}", &format!("{}f64{}", "[".repeat(n), "]".repeat(n)));
        let result = expand(Macro::Constraint, input.parse().expect("tokens")).to_string();
        assert!(result.contains("brackets nest more than"), "{place}");
    }
}

/// Thousands of mistakes are not all told, and what stands in for large systems is short.
#[test]
fn reports_are_short() {
    let unknown: String = (0..5000).map(|i| format!(" + unknown{i} * u{i}(x)")).collect();
    let lets: String = (0..5000).map(|i| format!("let known{i} = x; ")).collect();
    let result = expanded(&format!("{{ {lets} y {unknown} }}"));
    let told = result.matches("compile_error").count();
    assert!(told == 100 && result.len() < 100_000, "{told} mistakes in {} characters", result.len());
    let large = "struct A {} |x: [f64; 4096]| for i in 0..4096 { x[i] + unknown }";
    let result = expand(Macro::Constraint, large.parse().expect("tokens")).to_string();
    assert!(result.contains("unknown name `unknown`") && result.len() < 5000, "{}", result.len());
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
    let shapes: [Shape; 11] = [
        // name, size, tokens for each, expression
        ("one precedence", 800, 120, |n| {
            format!("|x, y| {}", (0..n).map(|i| format!("x * {i} + y")).collect::<Vec<_>>().join(" - "))
        }),
        ("products", 80, 1200, |n| lets(n, |f| format!("{f} * y + x"))),
        ("sines", 80, 1600, |n| lets(n, |f| format!("sin({f}) + x"))),
        ("quotients", 80, 3000, |n| lets(n, |f| format!("y / (1 + {f}^2)"))),
        ("branches", 100, 1800, |n| lets(n, |f| format!("if {f} < 0 {{ {f} * y }} else {{ x + {f} }}"))),
        ("table", 20, 3000, |n| {
            let pieces = (0..n).map(|i| format!("if x >= {i} && x < {i} + 1 {{ {i} * x^2 + y }} else"));
            format!("|x, y, z| y * {} {{ z * x }}", pieces.collect::<Vec<_>>().join(" "))
        }),
        ("table of parts without a slope", 20, 3000, |n| {
            let pieces = (0..n).map(|i| format!("if x >= {i} && x < {i} + 1 {{ {i} * x }} else"));
            format!("|x, y, z| z + ({} {{ 0 }}) / y", pieces.collect::<Vec<_>>().join(" "))
        }),
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

fn total(graph: &mut Graph, terms: Vec<Id>) -> Id {
    terms.into_iter().reduce(|a, b| graph.add(a, b)).expect("terms")
}

/// Twice as many terms take twice as many steps, but for a logarithm, up to the limit.
#[test]
fn work_grows_with_the_length() {
    type Shape = (&'static str, u32, fn(&mut Graph, &[Id], u32) -> Id);
    let shapes: [Shape; 5] = [
        // name, variables, expression of so many terms
        ("sines", 2, |g, x, n| {
            let terms = (1..n).map(|i| {
                let i = g.constant(f64::from(i));
                let phase = g.mul(i, x[0]);
                let sine = g.call(Function::Sin, phase);
                g.mul(sine, x[1])
            });
            let terms = terms.collect();
            total(g, terms)
        }),
        ("nested", 2, |g, x, n| {
            (0..n / 4).fold(x[0], |f, _| {
                let sine = g.call(Function::Sin, f);
                let product = g.mul(sine, x[1]);
                g.add(product, x[0])
            })
        }),
        ("branches", 2, |g, x, n| {
            let terms = (0..n).map(|i| {
                let (i, product) = (g.constant(f64::from(i)), g.mul(x[0], x[1]));
                let other = g.mul(i, product);
                g.select(Comparison::Less, x[0], i, product, other)
            });
            let terms = terms.collect();
            total(g, terms)
        }),
        ("branches in branches, and all of them", 2, |g, x, n| {
            let mut terms = vec![x[0]];
            for _ in 0..n / 2 {
                let (last, zero) = (terms[terms.len() - 1], g.constant(0.0));
                let (then, other) = (g.add(last, x[1]), g.sub(last, x[1]));
                terms.push(g.select(Comparison::Less, last, zero, then, other));
            }
            total(g, terms)
        }),
        ("kinks of many variables", 100, |g, x, n| {
            let zero = g.constant(0.0);
            let terms = (0..n as usize).map(|i| {
                let (a, b) = (x[i % 100], x[i / 100]);
                let difference = g.sub(a, b);
                let product = g.mul(a, difference);
                g.select(Comparison::Less, difference, zero, product, difference)
            });
            let terms = terms.collect();
            total(g, terms)
        }),
    ];
    for (name, variables, shape) in shapes {
        let steps = |n: u32| {
            let mut graph = Graph::new();
            let x: Vec<Id> = (0..variables).map(|k| graph.input(Input::Variable(k))).collect();
            let root = shape(&mut graph, &x, n);
            constraint(graph, &[root], variables).expect("within the limit").steps()
        };
        // From here on both are large: what small functions have besides is left to the trait.
        let (once, twice) = (steps(800), steps(1600));
        println!("{name}: {once} and {twice} steps");
        assert!(2 * twice <= 5 * once, "{name}: {once} steps, {twice} for twice as many terms");
    }
}

/// What would take the compiler minutes is refused before much is done, with how much it is and what to try.
#[test]
fn too_large() {
    let long = (0..10_000).map(|i| format!("x^{} * y", i % 30)).collect::<Vec<_>>().join(" + ");
    let sines = |n: usize| format!("struct A {{}} |x, y| sum(i in 1..{n}, sin(i * x) * cos(i * y) / i)");
    let rows = [
        (Macro::Constraint, format!("struct A {{}} |x, y| x + {long} + sum(i in 1..10000, exp(i * x))")),
        (Macro::Constraint, sines(2000)),
        (Macro::Constraint, sines(100_000)),
        (Macro::Potential, sines(5000)),
        (Macro::Potential, "struct A { a } |x| x^2 * sum(i in 1..9000, sin(i * a) / i)".to_owned()),
        (Macro::Constraint, "struct A { a } |x| x - sum(i in 1..9000, sin(i * a) / i)".to_owned()),
        (Macro::PairPotential, "struct A {} |r| sum(i in 1..15000, sin(i * r))".to_owned()),
        (
            Macro::Hamiltonian,
            "struct A {} |q: [f64; 1], p: [f64; 1]| p[0]^2 + sum(i in 1..8000, sin(i * q[0]))".to_owned(),
        ),
        (
            Macro::PhaseConstraint,
            "struct A {} |q: [f64; 2000], p: [f64; 2000]| for i in 0..2000 { q[i] * p[i] - 1 }".to_owned(),
        ),
        (Macro::Constraint, "struct A {} |x: [f64; 4000]| for i in 0..4000 { x[i]^2 - 1 }".to_owned()),
    ];
    for (which, row) in rows {
        let result = expand(which, row.parse().expect("tokens")).to_string();
        assert!(result.contains("or more, expected at most 80000"), "{row:.60}: {result:.3000}");
        assert!(result.contains("with a loop") && result.contains("struct A"), "{row:.60}");
        assert!(result.len() < 5000, "the stub is short");
    }
    let idle = "struct A {} |x| x + sum(i in 0..3000, j in 0..3000, 0 * i * j)";
    let result = expand(Macro::Constraint, idle.parse().expect("tokens")).to_string();
    assert!(result.contains("write it with shorter loops"), "{result}");
    let fits = expand(Macro::Constraint, sines(1000).parse().expect("tokens")).to_string();
    assert!(!fits.contains("compile_error"));
}

/// What holds itself twice at every level is no longer than its levels.
#[test]
fn doubled_at_every_level() {
    let steps = |levels: u32| {
        let mut graph = Graph::new();
        let [x, y] = [0, 1].map(|k| graph.input(Input::Variable(k)));
        let sum = graph.add(x, y);
        let distance = (0..levels).fold(sum, |f, _| graph.call2(Binary::Hypot, f, f));
        let square = graph.power(distance, 4);
        potential(graph, square, 2).expect("within the limit").steps()
    };
    let (once, twice) = (steps(8), steps(16));
    assert!(2 * twice <= 5 * once, "{once} steps, {twice} for twice as many levels");
}

/// Arrays of arrays of arrays are counted.
#[test]
fn arrays_without_end() {
    let lets: String = (1..=40).map(|k| format!("let f{k} = [f{}, f{}];", k - 1, k - 1)).collect();
    for body in ["f40[0][1]", "norm(f40)", "(if x < 0 { f40 } else { f40 })[0]"] {
        let input = format!("struct A {{}} |x, y| {{ let f0 = [x, y]; {lets} x + {body} }}");
        let result = expand(Macro::Potential, input.parse().expect("tokens")).to_string();
        assert!(result.contains("write it with shorter loops and smaller arrays"), "{result:.600}");
    }
}
