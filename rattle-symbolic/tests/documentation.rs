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

/// The page of `constraint!` lists every function of the table.
#[test]
fn every_function_is_listed() {
    let page = include_str!("../../rattle-macros/src/lib.rs");
    let (_, list) = page.split_once("functions    ").expect("the list of functions");
    let (list, _) = list.split_once("also as methods").expect("its end");
    let listed: Vec<&str> = list.split_whitespace().filter(|word| *word != "///").collect();
    for function in Function::ALL {
        assert!(listed.contains(&function.name()), "`{}` is missing among {listed:?}", function.name());
    }
}
