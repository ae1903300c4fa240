//! Where curvature jumps and the normal does not, there is no kink, however far a step goes.

use rattle::bodies::One;
use rattle::effect::Effects;
use rattle::prelude::*;
use rattle::scene::Hold;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

constraint! {
    /// Two straight lines and two half circles.
    struct Stadium {}
    |x, y| { let d = max(abs(x) - 1, 0); d^2 + y^2 - 1 }
}

#[test]
fn jumps_of_curvature_are_no_kinks() {
    let scene = Scene::on(Stadium {});
    for (h, tolerance) in [(2.0_f64, 1e-5), (0.1, 1e-9)] {
        let mut fell = Vec::new();
        for i in 0..50 {
            let x = -0.893 + 0.0357 * f64::from(i);
            let start = State::at([x, -1.0]).moving([1.0, 0.0]);
            let mut run = scene.simulate(start, Taylor::adaptive(18, h, tolerance)).unwrap();
            if let Err(error) = run.run((20.0 / h) as u64) {
                fell.push(format!("{x}: {error}"));
            }
        }
        assert!(fell.is_empty(), "h = {h}: {} of 50\n{}", fell.len(), fell.join("\n"));
    }
}

potential! {
    /// A spring that holds on one side.
    struct OneSided { k }
    |x| k / 2 * max(x, 0)^2
}

/// The place after so much of the way around the stadium, from (−1, −1) to the right.
fn along(way: f64) -> [f64; 2] {
    let bend = |x: f64, angle: f64| [x + x * angle.sin(), -x * angle.cos()];
    match way {
        _ if way < 2.0 => [way - 1.0, -1.0],
        _ if way < 2.0 + PI => bend(1.0, way - 2.0),
        _ if way < 4.0 + PI => [3.0 + PI - way, 1.0],
        _ => bend(-1.0, way - 4.0 - PI),
    }
}

/// Series from the very place where curvature jumps have no other coefficients than 0: the motion goes on from there.
#[test]
fn starts_where_curvature_jumps() {
    let scene = Scene::on(Stadium {});
    for (x, speed) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 0.7), (-1.0, -0.7)] {
        let start = State::at([x, -1.0]).moving([speed, 0.0]);
        let mut run = scene.simulate(start, Taylor::adaptive(18, 0.1, 1e-9)).unwrap();
        run.run(200).unwrap();
        // Along two straight lines of 2 and two half circles, from the end of a line.
        let outwards = x * speed > 0.0;
        let way = (20.0 * speed.abs() + if outwards { 2.0 } else { 0.0 }) % (4.0 + TAU);
        let place = along(way);
        let expected = [place[0] * speed.signum(), place[1]];
        let off = (run.position()[0] - expected[0]).hypot(run.position()[1] - expected[1]);
        assert!(off < 1e-7, "{x} {speed}: {:?} for {expected:?}", run.position());
    }
    let spring = Scene::point().with(OneSided { k: 4.0 });
    let mut run = spring.simulate(State::at([0.0]).moving([1.0]), Taylor::adaptive(14, 0.25, 1e-11)).unwrap();
    run.run(4).unwrap();
    assert!((run.position().x - 0.5 * 2.0_f64.sin()).abs() < 1e-10, "{}", run.position().x);
    run.run(4).unwrap();
    let free = FRAC_PI_2 - 2.0; // thrown back at π/2
    assert!((run.position().x - free).abs() < 1e-9, "{}", run.position().x);
}

potential! {
    /// The same along y, from an edge on, with a weight.
    struct Upper { k, edge, g }
    |_x, y| k / 2 * max(y - edge, 0)^2 - g * y
}

potential! {
    /// Its force has a slope without end at the edge.
    struct Steep { k }
    |_x, y| if y > 0 { k * y^2.4 } else { 0 }
}

/// In the second coordinate, at rest, far from the origin, in single precision, and where high rates of forces are
/// infinite at the edge.
#[test]
fn starts_on_edges_of_all_kinds() {
    fn error<C: Hold<2>, E: Effects<2>>(scene: Scene<C, E, One, 2>, [y, vy]: [f64; 2], h: f64) -> f64 {
        let start = State::at([0.0, y]).moving([1.0, vy]);
        let mut run = scene.simulate(start, Taylor::adaptive(14, h, 1e-11)).unwrap();
        run.run((4.0 / h.abs()) as u64).unwrap();
        assert!((run.position().x - 4.0 * h.signum()).abs() < 1e-9);
        run.energy_error().abs()
    }
    let found = [
        error(Scene::point().with(Upper { k: 4.0, edge: 0.0, g: 0.0 }), [0.0, 1.0], 0.25),
        error(Scene::point().with(Upper { k: 4.0, edge: 0.0, g: 0.5 }), [0.0, 0.0], 0.25),
        error(Scene::point().with(Upper { k: 4.0, edge: 0.0, g: 0.5 }), [0.0, 0.0], -0.25),
        error(Scene::point().with(Upper { k: 4.0, edge: 1000.0, g: 0.0 }), [1000.0, 1.0], 1e-4),
        error(Scene::point().with(Steep { k: 2.0 }), [0.0, 1.0], 0.25),
    ];
    println!("{found:?}");
    assert!(found.iter().all(|&error| error < 1e-9), "{found:?}");
    let starts = [1.0, -1.0].map(|x| State::at([x, -1.0]).moving([1.0, 0.0]));
    let mut single =
        Scene::on(Stadium {}).ensemble_in(Single, starts, Taylor::adaptive(10, 0.1, 1e-5)).unwrap();
    single.run(50);
    assert_eq!(single.failures().count(), 0, "{:?}", single.failure(0));
    for (i, way) in [7.0, 5.0].into_iter().enumerate() {
        let (place, expected) = (single.state(i).positions().next().unwrap(), along(way));
        assert!((place[0] - expected[0]).hypot(place[1] - expected[1]) < 1e-3, "{place:?} for {expected:?}");
    }
}

potential! {
    /// No number where y is in a narrow band.
    struct Band {}
    |x, y| x + if y > 0.45 && y < 0.5 { sqrt(-1 - y^2) } else { 0 }
}

/// A force that is no number in one component alone, inside of an inner step.
#[test]
fn forces_that_are_no_numbers_are_met_inside() {
    let method = Taylor::adaptive(18, 2.0, 1e-8);
    let start = State::at([0.0, 0.0]).moving([0.0, 1.0]);
    let mut run = Scene::point().with(Band {}).simulate(start, method).unwrap();
    let error = run.run(1).unwrap_err();
    println!("{error}");
    assert!(run.position().y < 0.5, "{error}");
}
