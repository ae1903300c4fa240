//! What `residual!` says about mistakes: each by its own message, and never by a panic.

use rattle_symbolic::residual;

fn says(input: &str) -> String {
    residual(input.parse().expect("tokens")).to_string()
}

/// The messages, as an input of the compiler's gets them.
fn messages(output: &str) -> Vec<&str> {
    let mut parts = output.split("compile_error ! { \"");
    parts.next();
    parts.filter_map(|rest| rest.split_once("\" }").map(|(message, _)| message)).collect()
}

/// One message each, at its own token (`tests/messages/residuals.rs` shows where), and a kernel with all
/// its functions: what uses it makes no second error.
#[test]
fn each_mistake_has_one_message_and_a_kernel_stands_in() {
    let cases = [
        ("struct A {} |x, y| eliminate(z) [x, y]", "`z` is no unknown"),
        ("struct A {} |x, y| given |c| eliminate(c) [x, c * y]", "`c` is no unknown"),
        ("struct A {} |x, y| eliminate(y) [x, y, x * y]", "to eliminate some of 2 unknowns"),
        ("struct A {} |x: [f64; 5]| eliminate(x) x", "found 5 of 5"),
        ("struct A {} |x: [f64; 4], y| eliminate(x) [x, y]", "found 4 of 5"),
        ("struct A {} |x, y| { let a = x; [a, y] linearise [a, y, x] }", "before it, 2; found 3"),
        ("struct A {} |x, y| [x, y, x * y] linearise [x]", "before it, 3; found 1"), // four in all, and no halves
        ("struct A {} |x, y| x linearise [y, x, y]", "before it, 1; found 3"),
        (
            "struct A {} |h, p| eliminate(p) [p - h, h - 1]",
            "the component in the place of `p` does not depend on `p`, which it is to be found from",
        ),
        (
            "struct A {} |h, p: [f64; 2]| eliminate(p) [h, p[1] + h, h^2]",
            "the component in the place of `p[1]` does not depend on `p[0]`, `p[1]`",
        ),
        (
            "struct A {} |h, p| eliminate(p) [h + p, p] linearise [h + p, h]",
            "the component in the place of `p`",
        ),
        (
            "struct A {} |h, p, q| eliminate(p, q) [h + q, h + p, h - p]",
            "no component in the places of `p`, `q` depends on `q`",
        ),
        (
            "struct A {} |h, p, q| eliminate(p, q) [h, p + q, p + q - h]",
            "the components in the places of `p`, `q` do not tell these apart",
        ),
        ("struct A { unused } |x, y| [x, y]", "unused"),
        ("struct A {} |x, y| [x, t]", "hand it over with what is given"),
        ("struct A {} |x, y| given [x, y]", "expected two bars after `given`"),
        ("struct A { c } |x, y| given |c [x, y]", "expected two bars after `given`"),
        ("struct A { s } |x, y| given (d) eliminate(y) [x, y * s]", "expected two bars after `given`"),
        ("struct A {} |x, y| given || [x, y]", "leave `given` out"),
        ("struct A {} |x, y| given |x| [x, y]", "`x`"),
        ("struct A {} |x, y| eliminate y [x, y]", "expected names of unknowns in parentheses"),
        ("struct A {} |x, y| eliminate [y] [x, y]", "expected names of unknowns in parentheses"),
        ("struct A {} |x, y| eliminate() [x, y]", "expected names of unknowns in parentheses"),
        ("struct A {} |x, y| eliminate(2) [x, y]", "expected names of unknowns in parentheses"),
        ("struct A {} |x, y| eliminate(y, y) [x, y]", "`y` stands here twice"),
        ("struct A {} |x, y| eliminate(y) eliminate(y) [x, y]", "`y` stands here twice"),
        ("struct A {} |x, y: [f64; 2]| eliminate(y[0]) [x, y]", "it goes as a whole"),
        ("struct A { c } |x, y: [f32; 3]| eliminate(y) [x, c * y[0], y[1], y[2]]", "found `f32`"),
        ("struct A {} |x: [Vec; 2], y| eliminate(y) [x[0], x[1], y]", "found `Vec`"),
        ("struct A {} |x y| eliminate(y) [x, y]", "expected `,` or `|` after a variable"),
        ("struct A { s } |x, y| linearise [x * s, y]", "expected the residual before `linearise`"),
        (
            "struct A { s } |x, y| { let z = s * x; [z, y] linearise }",
            "expected the residual before `linearise`",
        ),
        ("struct A { s } |x| x linearise s * x linearise x", "`linearise` stands once"),
        ("struct A { s } |x| x linearize s * x", "write `linearise`"),
        ("struct A {} |x| y linearise x", "unknown name `y`"),
        ("struct A {} [x, y]", "expected the variables between bars"),
        ("struct A {} |x| eliminate", "unknown name `eliminate`"),
        ("struct A {} |x|", "the expression is missing"),
        ("struct A {} |x, y| given |c|", "the expression is missing"),
    ];
    for (input, message) in cases {
        let output = says(input);
        let found = messages(&output);
        assert!(found.len() == 1 && found[0].contains(message), "{input}: {found:?}");
        let stands = [
            "struct A", "struct AKernel", "fn kernel", "fn residual_and_jacobian", "fn condensed",
            "fn recovered",
        ];
        assert!(stands.iter().all(|part| output.contains(part)), "{input}: {output}");
    }
    // Mistakes of several kinds at once.
    let several = says("struct A {} |x, y| eliminate(z, 2) [x, q + f(y)] linearize [x, w]");
    assert_eq!(messages(&several).len(), 6, "{several}");
    for input in ["struct A {} |", "", "|", "|x|", "struct", "struct A {} |x| given |", "struct A {} |x| {"] {
        let Ok(tokens) = input.parse() else { continue };
        assert!(residual(tokens).to_string().contains("compile_error"), "{input}");
    }
}

/// A name that is also a heading's is a name where an operator follows.
#[test]
fn headings_are_words_of_their_place() {
    for input in [
        "struct A { given } |x, y| [given * x, y]",
        "struct A { given } |x| given * x",
        "struct A { eliminate } |x| eliminate + x",
        "struct A {} |x, y| eliminate(y,) given |c: [f64; 2],| [x, y * c[0]]", // in any order
        "struct A {} |x, y| given |c| given |d| [x * d, y * c]",
    ] {
        assert!(!says(input).contains("compile_error"), "{input}: {}", says(input));
    }
}

#[test]
fn what_is_right_has_its_functions() {
    let plain = says("struct A { a } |x, y| given |c| [a * x + y * c, y^2, x - c]");
    assert!(plain.contains("fn residual_and_jacobian") && !plain.contains("fn condensed"));
    assert!(!plain.contains("compile_error"), "{plain}");
    let text = "struct A { d } |x, y| given |c,| eliminate(y) { let r = x + y; [r - c, y * r] linearise { let s = d + y; [r, s * y] } }";
    let whole = says(text);
    assert!(
        ["fn condensed", "fn condensed_residual", "fn recovered"].iter().all(|name| whole.contains(name)),
        "{whole}"
    );
    assert_eq!(whole, says(text), "the same input gives the same tokens");
}
