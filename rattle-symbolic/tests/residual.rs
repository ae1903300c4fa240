//! What `residual!` says about mistakes: each by its own message, and never by a panic.

use rattle_symbolic::residual;

fn says(input: &str) -> String {
    residual(input.parse().expect("tokens")).to_string()
}

#[test]
fn mistakes_have_messages() {
    let cases = [
        ("struct A {} |x, y| eliminate(z) [x, y]", "`z` is no unknown"),
        ("struct A {} |x, y| given |c| eliminate(c) [x, c * y]", "`c` is no unknown"),
        ("struct A {} |x, y| eliminate(y) [x, y, x * y]", "to eliminate some of 2 unknowns"),
        ("struct A {} |x: [f64; 5]| eliminate(x) x", "found 5 of 5"),
        ("struct A {} |x: [f64; 4], y| eliminate(x) [x, y]", "found 4 of 5"),
        ("struct A {} |x, y| { let a = x; [a, y] linearise [a, y, x] }", "found 5 in all"),
        ("struct A { unused } |x, y| [x, y]", "unused"),
        ("struct A {} |x, y| [x, t]", "hand it over with what is given"),
        ("struct A {} |x, y| given [x, y]", "unknown name `given`"),
        ("struct A {} [x, y]", "expected the variables between bars"),
        ("struct A {} |x, y| linearise", ""),
        ("struct A {} |x| eliminate", ""),
        ("struct A {} |", ""),
        ("", "expected `pub struct"),
    ];
    for (input, message) in cases {
        let output = says(input);
        assert!(output.contains("compile_error") && output.contains(message), "{input}: {output}");
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
