//! Where curvature jumps and the normal does not, there is no kink, however far a step goes.

use rattle::prelude::*;
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
