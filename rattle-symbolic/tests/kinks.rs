//! What is listed where equations are not smooth.

use proc_macro2::{TokenStream, TokenTree};
use rattle_symbolic::{Macro, expand};

/// The list in the generated code, or what was wrong.
fn listed(input: TokenStream) -> Vec<String> {
    let output = expand(Macro::Constraint, input).to_string();
    assert!(!output.contains("compile_error"), "{output}");
    let list = output.split_once("const KINKS :").and_then(|(_, rest)| rest.split_once("= & ["));
    let list = list.and_then(|(_, rest)| rest.split_once("] ;")).map_or("", |(list, _)| list);
    list.split(" , ")
        .map(|text| text.trim().trim_matches('"').to_owned())
        .filter(|text| !text.is_empty())
        .collect()
}

fn listed_of(body: &str) -> String {
    let input = format!("struct A {{ _a, _b, _c, _n }} |_x, _y, z| z - ({body})");
    let input = ["_a", "_b", "_c", "_n", "_x", "_y"].iter().fold(input, |input, &name| {
        let used = body.split(|c: char| !c.is_alphanumeric()).any(|word| word == &name[1..]);
        if used { input.replace(name, &name[1..]) } else { input }
    });
    listed(input.parse().expect("tokens")).join(", ")
}

fn check(rows: &[(&str, &str)]) {
    let wrong = rows.iter().filter_map(|&(body, expected)| {
        let found = listed_of(body);
        (found != expected).then(|| format!("{body}: found [{found}], expected [{expected}]"))
    });
    let wrong: Vec<String> = wrong.collect();
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

/// Multiples of absolute values, in all their spellings, and what is one seen from afar.
#[test]
fn edges_of_roots() {
    check(&[
        ("sqrt(x^2)", "x"),
        ("sqrt(x^2 / a^2)", "x"),
        ("sqrt(a * x^2)", "x"),
        ("(a * x^2)^0.5", "x"),
        ("(a * x^2)^-0.5", "x"),
        ("sqrt(a * x * x)", "x"),
        ("sqrt(x * a * x)", "x"),
        ("sqrt(a * x^2 + c^2)", "x"),
        ("sqrt(x^2 + c^2 + a)", "x"),
        ("sqrt(a * (x^2 + c))", "x"),
        ("(x^2)^n", "x"),
        ("((x / a)^2)^n + ((y / b)^2)^n", "x, y"),
        ("(x^4)^(1/4)", "x"),
        ("sqrt(sqrt(x^4 + c))", "x"),
        ("sqrt(sqrt(sqrt(x^8 + c) + a))", "x"),
        ("hypot(x, x)", "x"),
        ("hypot(x, a)", "x"),
        ("hypot(x / a, b * x)", "x"),
        ("norm(x / a, 0 * x)", "x"),
        ("norm([x / a, x / b, x])", "x"),
        ("cbrt(x^6)^(1/2)", "x"),
        ("cbrt(x^2)", "x"),
        ("cbrt(x^2 * y)", "y * x^2, x"),
        ("sqrt((x - y)^2 / a^2)", "x - y"),
        ("sqrt((x - a)^2 / b)", "x - a"),
        ("sqrt((1 + x)^2 * x^2)", "x + 1, x"),
        ("sqrt(x^2 * y^2 + x^2)", "x"),
        ("sqrt(a * x^2 + b * x^2)", "x"),
        ("sqrt(a * sin(x)^2)", "sin(x)"),
        ("1 / sqrt(a / x^2)", "x"),
        ("abs(x) + sqrt(x^2 + c^2)", "x"),
    ]);
}

/// Jumps through an infinity, which a function of bounds makes finite.
#[test]
fn jumps_of_quotients() {
    check(&[
        ("atan(y / x)", "x"),
        ("tanh(y / (2 * x))", "x * 2"),
        ("1 / (1 + exp(1 / x))", "x"),
        ("a * atan((1 / x)^3)", "x"),
        ("a * atan((1 / x)^n)", "x"),
        ("a * tanh(sinh(1 / x))", "x"),
        ("a / (1 + 2^(1 / x))", "x"),
        ("a * atan(exp(1 / x))", "x"),
        ("atan(cbrt(y / x))", "x, y / x"),
        ("atan(tan(x))", "cos(x)"),
        ("1 / (1 + exp((y - 1) / (x - a)^3))", "(x - a)^3"),
    ]);
}

/// What is smooth has no list, nor has what no body passes.
#[test]
fn smooth_formulas_have_no_list() {
    check(&[
        ("sqrt(x^2 + y^2)", ""),
        ("norm(x, y)", ""),
        ("norm(x, y, a)", ""),
        ("(x^2 + y^2)^(3/2)", ""),
        ("(x^2 + c)^(3/2)", ""),
        ("(x^2 + y^2)^n", ""),
        ("x^n", ""),
        ("(a * x^2)^2", ""),
        ("sqrt(x^4)", ""),
        ("sqrt(x^4 + c)", ""),
        ("sqrt(a^2 - x^2)", ""),
        ("sqrt(x)", ""),
        ("sqrt(x * y)", ""),
        ("cbrt(x^6)", ""),
        ("cbrt(x^2 + y^2)", ""),
        ("(sqrt(x^2 + y^2) - a)^2", ""),
        ("exp(-(x^2 + y^2) / (2 * a^2))", ""),
        ("exp(-x / a) * sin(y / b)", ""),
        ("exp(-a / (x^2 + y^2))", ""),
        ("1 / sqrt(x^2 + y^2) + a / (x^2 + y^2 + b^2)^3", ""),
        ("x / (1 + x^2) + 1 / x", ""),
        ("acos((x * y) / (norm(x, y) * norm(y, z)))", ""),
        ("tanh(x / norm(x, y))", ""),
    ]);
}

/// The constraints of a file, by name.
fn constraints(stream: TokenStream, into: &mut Vec<(String, TokenStream)>) {
    let list: Vec<TokenTree> = stream.into_iter().collect();
    for (i, token) in list.iter().enumerate() {
        let TokenTree::Group(group) = token else { continue };
        let called = |back: usize, name: &str| i >= back && list[i - back].to_string() == name;
        if called(1, "!") && called(2, "constraint") {
            let mut words =
                group.stream().into_iter().skip_while(|token| token.to_string() != "struct").skip(1);
            into.push((words.next().expect("a name").to_string(), group.stream()));
        } else {
            constraints(group.stream(), into);
        }
    }
}

/// Lanes compare what is listed in each step, so that an entry more would be paid for by all.
#[test]
fn ready_made_constraints_have_what_they_need() {
    let mut all = Vec::new();
    for file in ["surfaces.rs", "links.rs", "links/planar.rs"] {
        let text = std::fs::read_to_string(format!("../src/{file}")).expect(file);
        constraints(text.parse().expect(file), &mut all);
    }
    assert!(all.len() > 50, "{}", all.len());
    let lists = all.into_iter().map(|(name, input)| (name, listed(input).join(", ")));
    let lists: Vec<(String, String)> = lists.filter(|(_, list)| !list.is_empty()).collect();
    let expected = [
        ("DentedCylinder", "z, l - abs(z)"),
        ("GaussianBump", "rho - outer, rho - inner"),
        ("Spine", "z"),
        ("SpineTwo", "z"),
        (
            "Thylakoid",
            "x, u - (3 + face + 7.5), y, across - along, along, across, mouth - (u - (15 + (face + 6))), max(mouth, u - (15 + (face + 6))) - (along - 3), stack - (rho - width / 2), rho - (flare + width / 2), u - length / 2",
        ),
        ("Supersphere", "x, y, z"),
        ("Superellipsoid", "x / a, y / b, z / c"),
    ];
    let found: Vec<(&str, &str)> = lists.iter().map(|(name, list)| (&name[..], &list[..])).collect();
    assert_eq!(found, expected);
}
