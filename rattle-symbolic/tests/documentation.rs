//! What the generated documentation says.

use rattle_symbolic::expand::{Macro, expand};

#[test]
fn formula_gradient_and_counts() {
    let input = "/// A surface.
        pub struct Lemniscate { a, r }
        |x, y, z| { let f = (x^2 + y^2)^2 - a^2 * (x^2 - y^2); f^2 + z^2 - r^2 }";
    let output = expand(Macro::Constraint, input.parse().expect("tokens")).to_string();
    println!("{}", &output[..1500]);
    for line in [
        "f = (x^2 + y^2)^2 - a^2 * (x^2 - y^2)",
        "g = f^2 + z^2 - r^2",
        "2 * z)",
        "11 `value`, 19 `value_and_jacobian`",
        "41 `jet`",
    ] {
        assert!(output.contains(line), "{line}");
    }
}
