//! Edges and jumps of formulas that do not say `abs`, `sign` or `if`: angles, quotients within bounds, roots, lengths,
//! and several jumps in a step.

use rattle::Error;
use rattle::error::StepFailure;
use rattle::kernel::ConstraintKernel;
use rattle::prelude::*;

constraint! {
    /// A helicoid by its angle, which jumps where x is negative and y passes zero.
    struct ByAngle { c }
    |x, y, z| z - c * atan2(y, x)
}
constraint! {
    /// The same by a quotient, which jumps at x = 0.
    struct ByQuotient { c }
    |x, y, z| z - c * atan(y / x)
}
constraint! {
    /// Roofs whose slope is no `abs`: by a root and by a length.
    struct ByRoot { slope, eps }
    |x, _y, z| z + slope * sqrt(x^2 + eps^2)
}
constraint! { struct ByLength { slope, eps } |x, _y, z| z + slope * hypot(eps, x) }
constraint! {
    /// Saw teeth of width w.
    struct Teeth { height, w }
    |x, _y, z| z - height * mod(x, w)
}

/// The argument, and the angle by which the normal turns, in degrees.
fn kink(error: Error) -> (&'static str, f64) {
    match error {
        Error::Step { cause: StepFailure::Kink { argument, angle, .. }, .. } => {
            (argument, angle.to_degrees())
        }
        other => panic!("{other}"),
    }
}

/// Where an angle jumps, the surface goes on elsewhere: every method says so, and in lanes each trajectory.
#[test]
fn an_angle_that_jumps_is_an_error() {
    fn ends<C: Constraint<3, 1> + 'static>(surface: C, argument: &str, at: [f64; 3], v: [f64; 3]) {
        let scene = Scene::on(surface);
        let start = scene.project(&State::at(at).moving(v)).unwrap();
        let jumps = |ended: Result<(), Error>| {
            let error = ended.unwrap_err();
            assert!(error.to_string().contains("the surface goes on"), "{error}");
            assert_eq!(kink(error).0, argument);
        };
        jumps(scene.simulate(start.clone(), Rattle::new(0.01)).unwrap().run(100));
        jumps(scene.simulate(start.clone(), Lobatto::<4>::new(0.01)).unwrap().run(100));
        jumps(scene.simulate(start.clone(), Dop853::new(0.01)).unwrap().run(100));
        let mut many = scene.ensemble((0..70).map(|_| start.clone()), Rattle::new(0.01)).unwrap();
        many.run(100);
        assert_eq!(many.failures().count(), 70);
    }
    for c in [0.005, 0.01, 0.03, 0.2] {
        let angle = f64::atan2(0.205, -1.0);
        ends(ByAngle { c }, "y", [-1.0, 0.205, c * angle], [0.0, -1.0, 0.0]);
        ends(ByQuotient { c }, "x", [0.205, 1.0, c * f64::atan(1.0 / 0.205)], [-1.0, 0.0, 0.0]);
    }
    // On the other side nothing jumps.
    let scene = Scene::on(ByAngle { c: 0.03 });
    let start = scene
        .project(&State::at([1.0, 0.205, 0.03 * f64::atan2(0.205, 1.0)]).moving([0.0, -1.0, 0.0]))
        .unwrap();
    let mut run = scene.simulate(start, Rattle::new(0.01)).unwrap();
    run.run(100).unwrap();
    assert!(run.position().y < -0.7 && run.energy_error().abs() < 1e-6);
}

/// Edges of roots and lengths are those of `abs`; a smooth ridge is passed.
#[test]
fn edges_without_abs_are_errors() {
    fn ridge<C: Constraint<3, 1>>(surface: C, x: f64) -> Result<f64, Error> {
        let scene = Scene::on(surface);
        let start = scene.project(&State::at([x, 0.0, 0.0]).moving([1.0, 0.0, 0.0])).unwrap();
        let mut run = scene.simulate(start, Rattle::new(0.033)).unwrap();
        run.run(60).map(|()| run.energy_error())
    }
    for slope in [0.2, 0.02] {
        for text in [ridge(ByRoot { slope, eps: 0.0 }, -1.0), ridge(ByLength { slope, eps: 0.0 }, -1.0)] {
            let (argument, angle) = kink(text.unwrap_err());
            assert_eq!(argument, "x");
            assert!((angle - 2.0 * slope.atan().to_degrees()).abs() < 1e-3, "{angle}");
        }
    }
    for eps in [0.3, 1.0] {
        assert!(ridge(ByRoot { slope: 0.2, eps }, -1.0).unwrap().abs() < 1e-3);
        assert!(ridge(ByLength { slope: 0.2, eps }, -1.0).unwrap().abs() < 1e-3);
    }
}

/// A step over an even number of jumps is an error too.
#[test]
fn steps_over_several_teeth_are_errors() {
    for teeth in 1..=7 {
        let h = 0.01 * f64::from(teeth);
        let scene = Scene::on(Teeth { height: 0.1, w: 0.01 });
        let start = State::at([0.005, 0.0, 0.0005]).moving([1.0, 0.0, 0.1]);
        let mut run = scene.simulate(start, Rattle::new(h)).unwrap();
        kink(run.run(10).unwrap_err());
    }
}

/// An angle that is to be zero does not jump there, nor does one whose first argument is a length: such links are not
/// looked at.
#[test]
fn angles_of_links_have_no_list() {
    use rattle::links::{Angle, Torsion, planar};
    fn listed<C: Constraint<D, 1>, const D: usize>(_: &C) -> usize {
        C::Kernel::<f64>::KINKS.len()
    }
    assert_eq!(listed::<_, 6>(&planar::Angle { angle: 1.0 }), 0);
    assert_eq!(listed::<_, 9>(&Angle { angle: 1.0 }), 0);
    assert_eq!(listed::<_, 12>(&Torsion { angle: 1.0 }), 0);
    assert_eq!(listed::<_, 3>(&ByAngle { c: 1.0 }), 1);
}

/// A wedge y = |x|/2 in many spellings: none of them is passed.
#[test]
fn edges_in_roots_and_powers_are_errors() {
    macro_rules! wedges {
        ($($name:ident { $($number:ident: $value:expr),* } $body:expr;)*) => {$({
            constraint! { struct $name { $($number),* } |x, y| y - ($body) }
            let scene = Scene::on($name { $($number: $value),* });
            let start = scene.project(&State::at([0.4, 0.2]).moving([-1.0, -0.5])).unwrap();
            let ended = scene.simulate(start, Rattle::new(0.013)).unwrap().run(90);
            let (argument, angle) = kink(ended.expect_err(stringify!($body)));
            assert_eq!(argument, "x", "{}", stringify!($body));
            // The sides are compared where c = 1e-40 is still felt.
            assert!((angle - 2.0 * 0.5_f64.atan().to_degrees()).abs() < 1e-2, "{}: {angle}", stringify!($body));
        })*};
    }
    wedges! {
        Quotient { a: 2.0 } sqrt(x^2 / a^2);
        Product { a: 0.25 } sqrt(a * x^2);
        Half { a: 0.25 } (a * x^2)^0.5;
        Twice { a: 0.25 } sqrt(a * x * x);
        Rounded { a: 0.25, c: 1e-12 } sqrt(a * x^2 + c^2);
        Round { a: 0.25, c: 1e-11 } sqrt(a * x^2 + c^2); // farther from 0 than sides that are compared nearer
        Any { n: 0.5, k: 0.5 } k * (x^2)^n;
        Fourth { k: 0.5 } k * (x^4)^(1/4);
        Nested { k: 0.5, c: 1e-40 } k * sqrt(sqrt(x^4 + c));
        Length { k: 0.5 } k * hypot(x, x) / sqrt(2);
        Norm { a: 2.0 } norm(x / a, 0 * x);
        Third { k: 0.5 } k * cbrt(x^6)^(1/2);
        Common { k: 0.125 } sqrt(k * x^2 + x^2 / 8);
    }
}

/// A superellipse that is a square, and a ridge along x = y.
#[test]
fn edges_of_lengths_are_errors() {
    constraint! { struct Square { n, a } |x, y| ((x / a)^2)^n + (y^2)^n - 1 }
    let scene = Scene::on(Square { n: 0.5, a: 2.0 });
    let start = scene.project(&State::at([0.4, 0.8]).moving([-1.0, 0.5])).unwrap();
    assert_eq!(kink(scene.simulate(start, Rattle::new(0.013)).unwrap().run(90).unwrap_err()).0, "x");
    constraint! { struct Ridge { a } |x, y, z| z - sqrt((x - y)^2 / a^2) }
    let scene = Scene::on(Ridge { a: 2.0 });
    let start = scene.project(&State::at([0.4, 0.0, 0.2]).moving([-1.0, 0.0, -0.5])).unwrap();
    assert_eq!(kink(scene.simulate(start, Rattle::new(0.013)).unwrap().run(90).unwrap_err()).0, "x - y");
}

/// Steps through an infinity that a function makes finite: the surface goes on elsewhere. Where a step ends so near
/// that the slope overflows there is no normal.
#[test]
fn jumps_through_an_infinity_are_errors() {
    macro_rules! steps {
        ($($name:ident $body:expr;)*) => {$({
            constraint! { struct $name { k } |x, y| y - k * ($body) }
            let mut kinks = 0;
            for k in [0.1, 1.0] {
                let at = -$name { k }.value(&[0.4, 0.0].into())[0];
                let scene = Scene::on($name { k });
                let start = scene.project(&State::at([0.4, at]).moving([-1.0, 0.0])).unwrap();
                for h in [0.01, 0.0117, 0.013] {
                    let ended = scene.simulate(start.clone(), Rattle::new(h)).unwrap().run(300);
                    match ended.expect_err(stringify!($body)) {
                        Error::Step { cause: StepFailure::Kink { argument, .. }, .. } => {
                            assert_eq!(argument, "x", "{}", stringify!($body));
                            kinks += 1;
                        }
                        error => assert!(error.to_string().contains("no normal"), "{error}"),
                    }
                }
            }
            assert!(kinks > 0, "{}", stringify!($body));
        })*};
    }
    steps! {
        Exponential 1 / (1 + exp(1 / x));
        Power 1 / (1 + 2^(1 / x));
        Cube atan((1 / x)^3);
        Sinh tanh(sinh(1 / x));
        Angle atan(exp(1 / x));
    }
}
