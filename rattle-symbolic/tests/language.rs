//! What expressions mean, and what is said about those that mean nothing.

use proc_macro2::{TokenStream, TokenTree};
use rattle_symbolic::expand::{Macro, expand};

fn expanded(input: &str) -> TokenStream {
    expand(Macro::Constraint, input.parse().expect("tokens"))
}

/// The messages, in order.
fn messages(input: &str) -> Vec<String> {
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
    collect(expanded(input), &mut list);
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

/// Each mistake has its message, and no other.
#[test]
fn mistakes() {
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
    ];
    for (written, expected) in rows {
        assert_eq!(messages(&format!("struct A {written}")), expected, "{written}");
    }
}
