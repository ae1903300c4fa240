//! What expressions mean, and what is said about those that mean nothing.

use proc_macro2::{TokenStream, TokenTree};
use rattle_symbolic::functions::Function;
use rattle_symbolic::{Macro, expand};

fn expanded(input: &str) -> TokenStream {
    expand(Macro::Constraint, input.parse().expect("tokens"))
}

/// The messages, in order.
fn messages(input: &str) -> Vec<String> {
    messages_of(Macro::Constraint, input)
}

fn messages_of(which: Macro, input: &str) -> Vec<String> {
    fn collect(tokens: TokenStream, into: &mut Vec<String>) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        for (i, token) in tokens.iter().enumerate() {
            let TokenTree::Group(group) = token else { continue };
            let error = i >= 2 && tokens[i - 2].to_string() == "compile_error";
            match error {
                true => into.push(group.stream().to_string()),
                false => collect(group.stream(), into),
            }
        }
    }
    let mut list = Vec::new();
    collect(expand(which, input.parse().expect("tokens")), &mut list);
    list.iter().map(|text| text.trim_matches('"').to_owned()).collect()
}

/// The body of `value`, its temporaries numbered as they come: unused indices leave gaps in the numbers.
fn value(input: &str) -> String {
    let text = expanded(input).to_string();
    assert!(!text.contains("compile_error"), "{input}: {:?}", messages(input));
    let body = text.split_once("fn value (").and_then(|(_, rest)| rest.split_once("# [inline"));
    let mut names: Vec<&str> = Vec::new();
    let numbered = body.expect("a function").0.split(' ').map(|word| match word.starts_with("__t") {
        false => word.to_owned(),
        true => {
            let known = names.iter().position(|name| *name == word);
            let number = known.unwrap_or_else(|| {
                names.push(word);
                names.len() - 1
            });
            format!("t{number}")
        }
    });
    numbered.collect::<Vec<_>>().join(" ")
}

/// Conditions of indices and numbers together: each row as it is written, and worked out by hand.
#[test]
fn indices_in_conditions() {
    let rows = [
        (
            "for i in 0..2 { if i == 0 && x[0] > 0 { x[1] } else { x[2] } }",
            "[if x[0] > 0 { x[1] } else { x[2] }, x[2]]",
        ),
        (
            "for i in 0..3 { if i > 0 && x[i - 1] > 0 { x[i] } else { x[0] } }",
            "[x[0], if x[0] > 0 { x[1] } else { x[0] }, if x[1] > 0 { x[2] } else { x[0] }]",
        ),
        (
            "for i in 0..2 { if x[i + 1] < x[i] && i < 1 { x[0] } else { x[2] } }",
            "[if x[1] < x[0] { x[0] } else { x[2] }, x[2]]",
        ),
        (
            "for i in 0..2 { if i == 0 || x[i - 1] > 0 { x[i] } else { x[2] } }",
            "[x[0], if x[0] > 0 { x[1] } else { x[2] }]",
        ),
        (
            "for i in 0..3 { if i == 2 || x[0] > 0 && i > 0 { x[1] } else { x[2] } }",
            "[x[2], if x[0] > 0 { x[1] } else { x[2] }, x[1]]",
        ),
        (
            "for i in 0..2 { if (i == 0 || x[i - 1] > 0) && (x[i + 1] < 1 || i > 0) { x[0] } else { x[2] } }",
            "[if x[1] < 1 { x[0] } else { x[2] }, if x[0] > 0 { x[0] } else { x[2] }]",
        ),
        (
            "if x[0] < 1 && 1 < 2 && x[1] < 2 || 2 < 1 || x[2] < 3 { x[0] } else { x[1] }",
            "if x[0] < 1 && x[1] < 2 || x[2] < 3 { x[0] } else { x[1] }",
        ),
        (
            "sum(i in 0..3, if 1 <= i && x[i - 1] >= 0 { x[i] } else { 1 })",
            "1 + if x[0] >= 0 { x[1] } else { 1 } + if x[1] >= 0 { x[2] } else { 1 }",
        ),
    ];
    for (written, by_hand) in rows {
        let item = |expression: &str| {
            format!("struct A {{}} |x: [f64; 3]| [x[0] + x[1] + x[2], 0 * x[0] + 1 * x[1], {expression}]")
        };
        assert_eq!(value(&item(written)), value(&item(by_hand)), "{written}");
    }
}

/// Arithmetic of arrays: each row, and the same number by number.
#[test]
fn arrays_are_combined_number_by_number() {
    let rows = [
        ("a + b", "[a[0] + b[0], a[1] + b[1]]"),
        ("a - b", "[a[0] - b[0], a[1] - b[1]]"),
        ("a * c", "[a[0] * c, a[1] * c]"),
        ("c * a", "[c * a[0], c * a[1]]"),
        ("a / c", "[a[0] / c, a[1] / c]"),
        ("if c > 0 { a } else { b }", "[if c > 0 { a[0] } else { b[0] }, if c > 0 { a[1] } else { b[1] }]"),
    ];
    for (written, by_hand) in rows {
        let item = |array: &str| {
            format!(
                "struct A {{ c }} |a: [f64; 2], b: [f64; 2]| {{ let s = {array}; [s[0] + c * a[0], s[1] + b[1] * b[0]] }}"
            )
        };
        assert_eq!(value(&item(written)), value(&item(by_hand)), "{written}");
    }
    let no_meaning =
        |operator| format!("`{operator}` of two arrays has no one meaning; use `dot(a, b)` or indices");
    let disagree = |what| format!("{what}; the shapes must agree");
    let rows = [
        ("a * b", no_meaning('*')),
        ("a / b", no_meaning('/')),
        ("a + 1", disagree("`+` of an array of 2 and a number")),
        ("1 - a", disagree("`-` of a number and an array of 2")),
        ("1 / a", disagree("`/` of a number and an array of 2")),
        ("a + d", disagree("`+` of an array of 2 and an array of 3")),
        ("a / 0", "division by zero".to_owned()),
    ];
    for (written, expected) in rows {
        let item = format!(
            "struct A {{}} |a: [f64; 2], b: [f64; 2], d: [f64; 3]| dot(a, b) + norm(d) + norm({written})"
        );
        assert_eq!(messages(&item), [expected], "{written}");
    }
}

/// Each mistake has its message, and no other.
#[test]
fn mistakes() {
    let functions: Vec<&str> = Function::ALL.iter().map(|function| function.name()).collect();
    let unknown = format!(
        "unknown function `weihgt`, expected one of {}, min, max, mod, atan2, hypot, pow, dot, norm, delta, sum, product",
        functions.join(", ")
    );
    let rows = [
        (
            "{} |x: [f64; 2]| for i in 0..2 { if i == 0 && x[i] == 0 { x[0] } else { x[1] } }",
            vec!["`==` of real numbers is rarely true; compare with `<` or `<=`"],
        ),
        (
            "{} |x: [f64; 2]| for i in 0..2 { if i > 0 || x[i - 1] > 0 { x[0] } else { x[1] } }",
            vec!["the index is -1, expected 0 to 1"],
        ),
        (
            "{} |x: [f64; 2]| for i in 0..2 { if i > 0 && x { x[0] } else { x[1] } }",
            vec!["expected a comparison, as in `x < 1`"],
        ),
        ("{} |x| x * π", vec!["unknown name `π`, expected one of x, pi, e; did you mean `pi`?"]),
        ("{ a } |x| x * self.a", vec!["parameters are named directly: `a`"]),
        (
            "{ radius } |x| x - raduis",
            vec!["unknown name `raduis`, expected one of radius, x, pi, e; did you mean `radius`?"],
        ),
        ("{} |x| 10^-320 * x", vec!["this constant is too small for `f64`, and would be 0"]),
        ("{} |x| 1e-200 * 1e-200 * x", vec!["this constant is too small for `f64`, and would be 0"]),
        ("{} |x| 1e-200 / 1e200 * x", vec!["this constant is too small for `f64`, and would be 0"]),
        ("{} |x| (1e-3)^200.3 * x", vec!["this constant is too small for `f64`, and would be 0"]),
        ("{} |x| 1e-200^2 * x", vec!["this constant is too small for `f64`, and would be 0"]),
        (
            "{} |x| product(_i in 0..400, 1/10) * x",
            vec!["this constant is too small for `f64`, and would be 0"],
        ),
        ("{} |x| 1e-320 * x + 1e-200 * 1e-110 * x + exp(-1000) * x + 0 * 3 * x + 0^2 + 0 / 2", vec![]),
        (
            "{} |x: [f64; 3]| norm(cross(x, x))",
            vec![
                "unknown function `cross`; write its components: `a[1] * b[2] - a[2] * b[1]` is the first of three",
            ],
        ),
        ("{} |x| { a = x; a + x }", vec!["`let` is missing; write `let a = …;`"]),
        ("{} |x| { let a = x; b = 2 * a; a + b }", vec!["`let` is missing; write `let b = …;`"]),
        (
            "{ r } |x| { x = r }",
            vec!["found `=`, expected an expression; for a constraint `left = right` write `left - right`"],
        ),
        ("{ k = 1 } |x| k * x", vec!["parameters have no defaults; values are given where `A` is made"]),
        (
            "{ k: f64 = 1.0, l } |x| k * x - l",
            vec!["parameters have no defaults; values are given where `A` is made"],
        ),
        ("{ k: [f64; 2] } |x| k.1 * x", vec!["a component is written with brackets: `[1]`"]),
        ("{ k: [f64; 2] } |x| k.* x", vec!["expected a function after the dot, as in `x.sin()`"]),
        ("{ weight } |x| x - mass", vec!["unknown name `mass`, expected one of weight, x, pi, e"]),
        ("{ weight } |x| x - weihgt(2)", vec![unknown.as_str()]),
        (
            "{ e } |x| x - e + y",
            vec![
                "unknown name `y`, expected one of e, x, pi",
                "`e` is Euler's number here; choose another name",
            ],
        ),
    ];
    for (written, expected) in rows {
        assert_eq!(messages(&format!("struct A {written}")), expected, "{written}");
    }
}

/// Velocities follow coordinates, and the time follows both.
#[test]
fn variables_have_their_order() {
    let velocities = "coordinates come first, then velocities: `|q, v|`";
    let time = "`t` is the time of a moving constraint, and stands last, as in `|x, y, t|`";
    let rows = [
        (Macro::Force, "{ c } |v: [f64; 2]| -c * v", Some(velocities)),
        (Macro::Force, "{ c } |v, q| -c * v", Some(velocities)),
        (Macro::Force, "{ c } |vx, vy| [-c * vx, -c * vy]", Some(velocities)),
        (Macro::Force, "{ c } |va: [f64; 2], vb: [f64; 2]| [-c * va, -c * vb]", Some(velocities)),
        (Macro::Force, "{ c } |velocity, t| -c * velocity * t", Some(velocities)),
        (Macro::Force, "{ c } |v_x, v_y| [-c * v_x, -c * v_y, 0]", Some(velocities)),
        (Macro::Force, "{ c } |u, v| [-c * v, c * u]", None),
        (Macro::Force, "{ c } |volume| -c * volume", None),
        (Macro::Force, "{ c } |vertical, vx| -c * vx", None),
        (Macro::Force, "{ c } |_q, v| -c * v", None),
        (Macro::Force, "{ c } |x, v, y| [c * x, c * v, c * y]", None),
        (Macro::Force, "{ c } |u, v, du, dv| [-c * u - du, -c * v - dv]", None),
        (Macro::Force, "{ c } |x, y, vx, vy| [-c * x - vx, -c * y - vy]", None),
        (Macro::Potential, "{ c } |v| c * v^2", None),
        (Macro::Constraint, "{ w } |t, x, y| x * sin(w * t) - y * cos(w * t)", Some(time)),
        (Macro::Constraint, "{ w } |a: [f64; 2], t, b: [f64; 2]| dot(a, b) - w * t", Some(time)),
        (Macro::Constraint, "{ w } |x, y, t| x * sin(w * t) - y * cos(w * t)", None),
        (Macro::Constraint, "{ w } |t| t^2 - w", None),
        (Macro::Constraint, "{ w } |t: [f64; 2], y| dot(t, t) + y - w", None),
    ];
    for (which, written, expected) in rows {
        let found = messages_of(which, &format!("struct A {written}"));
        assert_eq!(found, expected.map(str::to_owned).into_iter().collect::<Vec<_>>(), "{written}");
    }
    let rows = [
        (
            Macro::Force,
            "|x, vx, y, vy| [-x - vx, -y - vy]",
            "coordinates come first, then velocities: `|x, y, vx, vy|`",
        ),
        (
            Macro::Force,
            "|x, vx, y, vy, t| [-x - vx, -y - vy * t]",
            "coordinates come first, then velocities: `|x, y, vx, vy, t|`",
        ),
        (
            Macro::Force,
            "|a: [f64; 2], va: [f64; 2], b: [f64; 2], vb: [f64; 2]| [b - a - va, a - b - vb]",
            "coordinates come first, then velocities: `|a, b, va, vb|`",
        ),
        (
            Macro::Force,
            "|vx, x, vy, y| [-x - vx, -y - vy]",
            "coordinates come first, then velocities: `|x, y, vx, vy|`",
        ),
        (
            Macro::Hamiltonian,
            "|p: [f64; 2], x: [f64; 2]| dot(p, p) + dot(x, x)",
            "coordinates come first, then momenta: write `|x: [f64; 2], p: [f64; 2]|`",
        ),
        (Macro::Hamiltonian, "|v, q| v^2 + q^4", "coordinates come first, then momenta: write `|q, v|`"),
        (
            Macro::PhaseConstraint,
            "|p0: [f64; 2], q0: [f64; 2]| p0[0] - q0[1]",
            "coordinates come first, then momenta: write `|q0: [f64; 2], p0: [f64; 2]|`",
        ),
    ];
    for (which, written, expected) in rows {
        assert_eq!(messages_of(which, &format!("struct A {{}} {written}")), [expected], "{written}");
    }
    let time = "`time` is the time of a moving constraint, and stands last, as in `|x, y, t|`";
    assert_eq!(messages("struct A { w } |time, y| y - w * time"), [time]);
}

/// A force depends on velocities also where they choose between numbers.
#[test]
fn forces_that_velocities_choose() {
    let rows = [
        ("-mu * sign(v[0])", true),
        ("if v[0] < 0 { mu } else { 2 * mu }", true),
        ("mu * floor(v[1] + q[0])", true),
        ("-mu * v[1]", true),
        ("-mu * q[0] + 0 * v[0]", false),
        ("if q[0] < 0 { mu } else { 2 * mu }", false),
    ];
    for (first, depends) in rows {
        let item = format!("struct A {{ mu }} |q: [f64; 2], v: [f64; 2]| [{first}, 0]");
        let text = expand(Macro::Force, item.parse().expect("tokens")).to_string();
        let line = format!("ON_VELOCITY : :: core :: primitive :: bool = {depends}");
        assert!(text.contains(&line), "{first}");
    }
}

/// Exponents are exact fractions: 0.1 + 0.2 is 3/10 here, not the sum of two `f64`.
#[test]
fn exponents_are_exact() {
    let rows = [
        ("x^(0.1 + 0.2)", "x^0.3"),
        ("x^(1/3 + 1/6)", "sqrt(x)"),
        ("x^(2 * 0.1 * 5)", "x"),
        ("{ let n = 0.1; x^(3 * n) }", "x^(3/10)"),
    ];
    for (written, exact) in rows {
        let item = |expression: &str| format!("struct A {{}} |x| [{expression}, x]");
        assert_eq!(value(&item(written)), value(&item(exact)), "{written}");
    }
    let sum = value("struct A {} |x| [x^(0.1 + 0.2), x]");
    assert!(sum.contains("0.3f64"), "{sum}");
}

/// An attribute with `doc` in its text is no documentation; one that is keeps ours away.
#[test]
fn documented_fields() {
    let note = |attribute: &str| {
        let text = expanded(&format!("struct A {{ {attribute} r }} |x| x - r")).to_string();
        text.contains("The parameter `r`.")
    };
    assert!(note("") && note("#[cfg_attr(docs, allow(unused))]") && note("#[deprecated = \"see the doc\"]"));
    assert!(!note("/// Radius.\n") && !note("#[allow(unused)] #[doc = \"Radius.\"]"));
    assert!(note("#[doc(alias = \"radius\")]") && note("#[doc(hidden)]"));
}

/// What every struct derives anyway is taken out of a list of derives, and nothing of another crate.
#[test]
fn derives_once() {
    let rows = [
        ("#[derive(Clone, Default)]", "# [derive (Default)]"),
        (
            "#[derive(core::clone::Clone, ::std::fmt::Debug, std::hash::Hash)]",
            "# [derive (std :: hash :: Hash)]",
        ),
        ("#[derive(derive_more::Debug)]", "# [derive (derive_more :: Debug)]"),
        ("#[derive(my::own::PartialEq, Copy)]", "# [derive (my :: own :: PartialEq)]"),
        ("#[cfg_attr(all(), derive(Clone, Default))]", "# [cfg_attr (all () , derive (Default))]"),
        ("#[cfg_attr(test, derive(Clone), allow(unused))]", "# [cfg_attr (test , allow (unused))]"),
        ("#[cfg_attr(test, derive(Clone))]", ""),
        ("#[cfg_attr(test, allow(unused))]", "# [cfg_attr (test , allow (unused))]"),
    ];
    for (written, expected) in rows {
        let text = expanded(&format!("{written} struct A {{ r }} |x| x - r")).to_string();
        let begin = text.split_once("# [doc").expect("documentation").0;
        assert_eq!(begin.trim(), expected, "{written}");
    }
}

/// The last round of a loop is made also where no whole number follows.
#[test]
fn loops_to_the_last_number() {
    let sum = |range: &str| value(&format!("struct A {{}} |x| sum(_i in {range}, x) + x"));
    assert_eq!(sum("9223372036854775806..=9223372036854775807"), sum("0..=1"));
    assert_ne!(sum("9223372036854775806..=9223372036854775807"), sum("0..1"));
}

/// Slips of those who come from elsewhere: what to write.
#[test]
fn what_is_written_otherwise() {
    let bars = "there are no bars; an absolute value is written `abs(x)`, that of an array `norm(a)`";
    let rows = [
        ("|x| |x| - 1", bars),
        ("|x| 2 * |x| - 1", bars),
        ("|x| x + ||x|| - 1", bars),
        ("|m: [[f64; 2]; 2]| m[0, 1] - 1", "each index has its own brackets; write `[0][1]`"),
        ("|x| x + .5", "a number begins with a digit; write `0.5`"),
        ("|x| { let y = x; y += 1; y }", "a name is set once; write `let` and another name"),
        (
            "|x: [f64; 3]| x[0] + x.len()",
            "unknown function `len`; write the number itself: lengths are known, as in `sum(i in 0..3, a[i])`",
        ),
        ("|x| x < 1 ? x : 2", "there is no `?`; a choice is written `if x < 1 { a } else { b }`"),
        ("|x| if x < 1 { x } elif x < 2 { 2 } else { 3 * x }", "`elif` is written `else if`"),
        ("|x, y| if x < 1 and y < 2 { x } else { y }", "`and` is written `&&`"),
        ("|x, y| if x < 1 or y < 2 { x } else { y }", "`or` is written `||`"),
        ("|(x, y)| x * y - 1", "variables are names alone, as in `|x, y|` or `|q: [f64; 3]|`"),
        ("|&x| x - 1", "variables are names alone, as in `|x, y|` or `|q: [f64; 3]|`"),
        ("|mut x| x - 1", "variables are names alone, as in `|x, y|` or `|q: [f64; 3]|`"),
        ("|x| x^1/2 - 1", "`^` comes before `/`; a root is written `x^(1/2)`"),
    ];
    for (written, expected) in rows {
        assert_eq!(messages(&format!("struct A {{}} {written}")), [expected], "{written}");
    }
    assert!(messages("struct A { and } |x, or| x^(1/2) + and * or + x^1 / or").is_empty());
}

/// A time whose type is not known is one of the mistakes that are told.
#[test]
fn variables_of_unknown_types() {
    for (which, input) in [
        (Macro::Force, "struct F { k } |x: Real, v: Real, t: Real| -k * x - v * t"),
        (Macro::Potential, "struct P {} |x: Real, t: Real| x * sin(t)"),
        (Macro::Potential, "struct P {} |t: Real| t"),
    ] {
        let said = messages_of(which, input);
        assert!(said[0].contains("expected `f64`"), "{input}: {said:?}");
    }
}
