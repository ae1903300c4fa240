//! Taylor's method: the series of every function, tolerances, and what it cannot do.

use crate::common::*;
use rattle::Error;
use rattle::error::{MethodFailure, StepFailure};
use rattle::prelude::*;

constraint! {
    /// A cylinder about the x axis, on which x moves freely under a potential of x.
    struct Cylinder {}
    |_x, y, z| y^2 + z^2 - 1
}

/// The way from 0.6 at this speed to t = 1, by steps of 1/n.
fn along(
    scene: &rattle::Scene<Cylinder, impl rattle::effect::Effects<3>, rattle::bodies::One, 3>,
    method: impl Method,
) -> [f64; 6] {
    let steps = (1.0 / method.step_size()).round() as u64;
    let start = State::at([0.6, 1.0, 0.0]).moving([0.1, 0.0, 0.3]);
    let mut simulation = scene.simulate(start, method).unwrap();
    simulation.run(steps).unwrap();
    let (q, p) = (simulation.position(), simulation.momentum());
    [q.x, q.y, q.z, p.x, p.y, p.z]
}

/// Each function in a potential: its derivatives are in the force. The same motion by another method, which evaluates
/// functions and makes no series; where x turns, functions of more than one number see both change.
macro_rules! functions {
    ($($name:ident: $expression:expr;)*) => {
        $(mod $name {
            rattle::potential! {
                pub(super) struct Hill {}
                |x, y, z| $expression + 0 * y * z
            }
        })*

        #[test]
        fn the_series_of_every_function() {
            let mut wrong = Vec::new();
            $({
                let scene = Scene::on(Cylinder {}).with($name::Hill {});
                let taylor = along(&scene, Taylor::new(18, 0.05));
                let other = along(&scene, Dop853::new(0.0125));
                let free = along(&scene, Taylor::new(18, 1.0));
                let off = distance(taylor, other);
                println!("{:8} {off:.1e}", stringify!($name));
                assert!(distance(free, [0.0; 6]) > 0.1 && (other[3] - 0.1).abs() > 1e-3, "something happens");
                // Rounding of some twenty steps.
                let same = off <= 2e-14; // false for NaN
                if !same {
                    wrong.push((stringify!($name), off));
                }
            })*
            assert!(wrong.is_empty(), "{wrong:?}");
        }
    };
}
functions! {
    product: x * (x + 1) * z - x / (y + 3);
    root: sqrt(x + 1);
    cube: cbrt(x + 2) * x;
    exponential: exp(x / 2) + exp(-z);
    natural: ln(x + 2);
    decimal: x * log10(x + 2);
    binary: log2(x + 2);
    sine: sin(2 * x);
    cosine: cos(x + y);
    tangent: tan(x / 3);
    arcsine: asin(x / 4);
    arccosine: acos(x / 4 + z / 9);
    arctangent: atan(x);
    hyperbolic_sine: sinh(x);
    hyperbolic_cosine: cosh(x);
    hyperbolic_tangent: x * tanh(x);
    area_sine: asinh(x);
    area_cosine: acosh(x + 3);
    area_tangent: atanh(x / 4);
    error: erf(x);
    power: (x + 2)^1.7;
    variable_power: (x + 2)^(y / 3);
    variable_base: 2^(z / 3 + x);
    integer_power: x^5 - x^(-2) / 100;
    angle: atan2(x, y + 3);
    length: hypot(x, y + 1);
    absolute: abs(x) * x;
    smaller: min(x^2, y + 9) + max(x, -5) * x;
    choice: if x < 9 { x^2 } else { x };
    sign_of: sign(x) * x^3;
    whole: x - 9 * floor(x / 9 + 1/2) + floor(z / 9 - 1/2) * y / 4;
}

fn billiard_error(method: Taylor) -> f64 {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let rows = table("lemniscate_gravity");
    let at =
        |row: &&Row| row.text("ic") == "f64" && row.number("theta_deg") == 45.0 && row.number("t") == 5.0;
    let row = rows.iter().find(at).unwrap();
    let steps = (5.0 / method.step_size()).round() as u64;
    let mut simulation = scene.simulate(billiard_45(), method).unwrap();
    simulation.run(steps).unwrap();
    assert_eq!(simulation.time(), 5.0);
    let q = distance(simulation.position(), row.numbers(["x", "y", "z"]));
    q.max(distance(simulation.momentum(), row.numbers(["vx", "vy", "vz"])))
}

#[test]
fn errors_follow_the_tolerance() {
    for order in [12, 16, 20] {
        let errors = [1e-6, 1e-10, 1e-14, 1e-17].map(|t| billiard_error(Taylor::adaptive(order, 0.5, t)));
        println!("{order}: {errors:?}");
        // Some fifty inner steps, whose errors the motion spreads by less than a hundred.
        for (error, tolerance) in errors.into_iter().zip([1e-6, 1e-10, 1e-14, 1e-17]) {
            assert!(error <= 1e3 * tolerance + 4e-15, "order {order}, tolerance {tolerance:e}: {error:e}");
        }
        assert!(errors[0] > 1e-9, "order {order}: tolerances do something, {errors:?}");
    }
}

/// Many bodies that act on each other: the reference of two.
#[test]
fn two_bodies_with_a_pair_potential() {
    let scene = Scene::on(SURFACE).bodies(2).with(Ricker { depth: 0.5, radius: SURFACE.r });
    let f = 0.1_f64.powi(4) - 0.1_f64.powi(2);
    let start = State::of([[0.0, 0.0, SURFACE.r], [0.1, 0.0, (1.0 / 36.0 - f * f).sqrt()]])
        .with_momenta([[0.3, 0.4, 0.0], [0.0; 3]]);
    let rows = table("ricker_two_particles");
    let row = rows.last().unwrap();
    let mut simulation = scene.simulate(start, Taylor::new(18, 0.01 * row.number("t"))).unwrap();
    simulation.run(100).unwrap();
    let found: Vec<f64> = simulation.positions().flat_map(<[f64; 3]>::from).collect();
    let error = distance::<6>(
        <[f64; 6]>::try_from(found).unwrap(),
        row.numbers(["x1", "y1", "z1", "x2", "y2", "z2"]),
    );
    assert!(error <= 1e-13, "{error:e}");
}

#[test]
fn multipliers_are_those_of_the_motion() {
    let surface = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let mut particle = surface.simulate(billiard_45(), Taylor::new(16, 0.05)).unwrap();
    for _ in 0..10 {
        let before = particle.multiplier();
        let mut heard = Trajectory::with_multipliers(&particle);
        particle.observe(1, 1, &mut heard).unwrap();
        let heard = heard.multipliers().unwrap();
        let after = particle.multiplier();
        assert!((heard.position[1] - before).abs() <= 1e-13 * before.abs().max(1.0));
        assert!((heard.momentum[1] - after).abs() <= 1e-13 * after.abs().max(1.0));
    }
}

#[test]
fn what_it_cannot_move_is_refused() {
    let start = State::at([0.0, 1.0, 0.0]);
    potential! {
        /// More operations than series are written for.
        struct Long {}
        |x, y, z| sum(i in 0..700, (x + i * y + z)^3 / (i + 2))
    }
    let found = Scene::on(Cylinder {}).with(Long {}).simulate(start.clone(), Taylor::new(16, 0.1));
    let error = found.unwrap_err();
    assert!(matches!(error, Error::CannotMove { method: "Taylor", .. }), "{error}");
    assert!(error.to_string().contains("2000 operations"), "{error}");
    for order in [0, 1, 65] {
        let found = Scene::on(Cylinder {}).simulate(start.clone(), Taylor::new(order, 0.1));
        assert!(matches!(found.unwrap_err(), Error::Order(found) if found == order));
    }
    let found = Scene::on(Cylinder {}).simulate(start, Taylor::adaptive(16, 0.1, -1.0));
    assert!(matches!(found.unwrap_err(), Error::Tolerance(_)));
}

potential! {
    /// Draws to the line x = 0, harder and harder.
    struct Well {}
    |x, _y, _z| -1 / abs(x)
}

#[test]
fn a_collision_is_an_error_and_the_state_stays() {
    let scene = Scene::on(Cylinder {}).with(Well {});
    let mut simulation =
        scene.simulate(State::at([1.0, 1.0, 0.0]), Taylor::adaptive(16, 0.5, 1e-12)).unwrap();
    simulation.run(2).unwrap(); // from rest at 1 it arrives at t = π/√8 = 1.11
    let before = simulation.state();
    let error = simulation.step().unwrap_err();
    assert!(
        matches!(
            error,
            Error::Step { step: 3, cause: StepFailure::Method(MethodFailure::StepsCollapse { .. }), .. }
        ),
        "{error}"
    );
    assert_eq!(simulation.state(), before);
}

/// In a million times the time in which the motion bends there is no room for a step, and no singular point.
#[test]
fn a_step_of_too_many_inner_ones_says_so() {
    let scene = Scene::on(rattle::surfaces::Sphere { r: 1.0 }).with(Gravity { g: 1.0 });
    let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 1.0, 0.0]);
    let mut long = scene.simulate(start, Taylor::adaptive(14, 1.5e5, 1e-9)).unwrap();
    let error = long.step().unwrap_err().to_string();
    assert!(error.contains("at most 10⁶ inner steps") && error.contains("shorter h"), "{error}");
}

/// Where a choice turns just at the start there is no series, and that is said; where it never turns there is.
#[test]
fn a_kink_at_the_start_is_an_error_without_a_tolerance() {
    potential! {
        /// Its third derivative jumps where z = 0.
        struct Valley {}
        |_x, _y, z| abs(z)^3
    }
    let scene = Scene::on(Cylinder {}).with(Valley {});
    let at = State::at([0.0, 1.0, 0.0]);
    for method in [Taylor::new(12, 0.1), Taylor::adaptive(12, 0.1, 1e-10)] {
        let mut through = scene.simulate(at.clone().moving([1.0, 0.0, 0.1]), method).unwrap();
        let stepped = through.step();
        if method.tolerance().is_some() {
            stepped.unwrap();
            assert!(through.energy_error().abs() < 1e-11, "{:e}", through.energy_error());
        } else {
            let error = stepped.unwrap_err();
            let cause = MethodFailure::StageNotFinite { h: 0.1 };
            assert!(
                matches!(&error, Error::Step { cause: StepFailure::Method(of), .. } if *of == cause),
                "{error}"
            );
        }
        let mut along = scene.simulate(at.clone().moving([1.0, 0.0, 0.0]), method).unwrap();
        along.run(10).unwrap();
        assert!(distance(along.position(), [1.0, 1.0, 0.0]) <= 1e-15);
    }
}

potential! {
    /// Its slope jumps at x = 0.
    struct Groove {}
    |x| abs(x) + x^2 / 2
}

/// Behind a change of branch the series is another one: the inner step ends right there, and the energy is kept as the
/// tolerance says, where slopes jump as where they bend.
#[test]
fn branches_of_potentials_are_not_passed_over() {
    let groove = Scene::points::<1>(1).with(Groove {});
    let pair = Scene::points::<3>(2).with(rattle::potentials::Wca { epsilon: 1.0, sigma: 1.0 });
    for tolerance in [1e-7, 1e-10, 1e-13] {
        for (order, h) in [(8, 0.1), (12, 0.5), (30, 0.02), (64, 0.5)] {
            let method = Taylor::adaptive(order, h, tolerance);
            let mut simulation = groove.simulate(State::at([1.0]).moving([0.1]), method).unwrap();
            simulation.run((10.0 / h) as u64).unwrap();
            let groove = simulation.energy_error().abs();
            let start =
                State::of([[0.0; 3], [1.7, 0.05, 0.0]]).with_momenta([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]);
            let mut simulation = pair.simulate(start, method).unwrap();
            simulation.run((2.0 / h) as u64).unwrap();
            let pair = simulation.energy_error().abs();
            println!("{tolerance:e} {order} {h}: {groove:e} {pair:e}");
            // Some six passages, each off by up to the tolerance over h in a velocity of 1.7.
            assert!(groove < 12.0 * tolerance / h && pair < 12.0 * tolerance / h, "{groove:e} {pair:e}");
        }
    }
    // Of many bodies each takes steps of its own.
    let (method, bodies) = (Taylor::adaptive(12, 0.5, 1e-8), 80);
    let start = State::of((0..bodies).map(|i| [1.0 + 1e-6 * f64::from(i)]).collect::<Vec<_>>());
    let mut simulation = Scene::points::<1>(bodies as usize).with(Groove {}).simulate(start, method).unwrap();
    simulation.run(8).unwrap();
    let lost = simulation.energy_error().abs() / f64::from(bodies);
    assert!(lost < 1e-7, "{lost:e}");
}
