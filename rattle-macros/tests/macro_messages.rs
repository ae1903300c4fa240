//! Every mistake in an expression is reported at its own token, all of them at once, and nothing else
//! is: no second wave of errors from what could not be generated.

#[test]
fn messages() {
    trybuild::TestCases::new().compile_fail("tests/messages/*.rs");
}
