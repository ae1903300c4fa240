//! Impacts that are hard to find: of gaps that are rounded much more coarsely than places are, and behind a near miss
//! within one step.

use rattle::effect::{HardSpheres, Stop};
use rattle::potentials::Gravity;
use rattle::prelude::*;

constraint! {
    /// Above a round hill whose top is the origin: the gap is a small difference of squares of its radius.
    struct Hill { r }
    |x, y, z| x^2 + y^2 + (z + r)^2 - r^2
}

/// A ball bounces on a hill of any size, from a table to the Earth. The values of its gap near zero are as far apart as
/// r² is rounded, and a path often skips 0: no instant is found at which the gap is closed to the rounding of places.
#[test]
fn hills_of_any_size() {
    for (r, h, height, off) in [
        (1.0, 1e-3, 0.2, 0.05),
        (1.0, 2e-4, 0.2, 0.05),
        (10.0, 1e-2, 0.2, 0.05),
        (100.0, 1e-2, 1.0, 5.0),
        (1e5, 1e-2, 1.0, 50.0),
        (6.371e6, 1e-2, 1.0, 50.0),
    ] {
        for number in 0..12 {
            // Sunflower: places all over a disc.
            let (part, angle) = ((f64::from(number) + 0.5) / 12.0, 2.4 * f64::from(number));
            let (x, y) = (off * part.sqrt() * angle.cos(), off * part.sqrt() * angle.sin());
            let top = -(x * x + y * y) / (r + (r * r - x * x - y * y).sqrt());
            let start = State::at([x, y, top + height]).moving([0.01, 0.0, 0.0]);
            let scene = Scene::point().with(Gravity { g: 9.81 });
            let ball = scene.simulate(start, Rattle::new(h)).unwrap();
            let mut ball = ball.collide(Stop::above(Hill { r })).unwrap();
            let energy = ball.energy();
            for _ in 0..(2.0 / h) as u64 {
                ball.step().unwrap_or_else(|error| panic!("{r} {h} {number}: {error}"));
                let q = ball.position();
                // By a formula that takes no difference of squares, and rounding of r² over 2 r in the gap.
                let above = q.z + (q.x * q.x + q.y * q.y + q.z * q.z) / (2.0 * r);
                assert!(above > -4.0 * f64::EPSILON * r, "{r} {h} {number}: {above:e}");
            }
            assert!(ball.events() >= 2, "{r} {h} {number}: {} bounces", ball.events());
            // Steps along a parabola are exact, and a bounce keeps the speed: what is left is rounding.
            let lost = (ball.energy() - energy).abs();
            assert!(lost < 1e-13 * energy.abs().max(1.0), "{r} {h} {number}: {lost:e}");
        }
    }
}

potential! {
    /// Hardly anything up to x = 0.76, and no number behind.
    struct End {}
    |x, _y, _z| -1e-12 * ln(0.76 - x)
}
constraint! {
    /// To the left of x = 0.7.
    struct Wall {}
    |x, _y, _z| 0.7 - x
}

/// Within one step a ball misses another by a thousandth of its size, and meets a wall behind which the step cannot be
/// gone: the miss does not hide the wall.
#[test]
fn a_wall_behind_a_near_miss() {
    let scene = Scene::points(2).with(End {});
    let start = |aside: f64| {
        let places = [[0.0; 3], [0.2, aside, 0.0]];
        State::of(places).with_momenta([[1.0, 0.0, 0.0], [0.0; 3]])
    };
    for aside in [1.001, 1.3, 50.0] {
        let balls = scene.simulate(start(0.1 * aside), Rattle::new(1.0)).unwrap();
        let balls = balls.collide(HardSpheres::new(0.1)).unwrap();
        let mut balls = balls.collide(Stop::above(Wall {}).over([[0]])).unwrap();
        balls.step().unwrap_or_else(|error| panic!("{aside}: {error}"));
        let x = balls.positions().next().unwrap().x;
        assert!(balls.events() == 1 && (x - 0.4).abs() < 1e-9, "{aside}: {} events, {x}", balls.events());
    }
}

/// A ball that starts on a hill may be there to the rounding of the hill's gap, which its place does not tell.
#[test]
fn balls_start_on_hills_of_any_size() {
    for r in [1.0_f64, 1e3, 6.371e6] {
        let mut under = 0;
        for number in 0..200 {
            let x = 1e-3 * f64::from(number) * r.sqrt();
            let z = -x * x / (r + (r * r - x * x).sqrt());
            under += u32::from(x * x + (z + r) * (z + r) - r * r < 0.0);
            let scene = Scene::point().with(Gravity { g: 9.81 });
            let start = |z: f64| State::at([x, 0.0, z]).moving([0.0, 0.0, 1.0]);
            let ball = scene.simulate(start(z), Rattle::new(1e-3)).unwrap();
            let mut ball =
                ball.collide(Stop::above(Hill { r })).unwrap_or_else(|error| panic!("{r} {x}: {error}"));
            ball.run(10).unwrap_or_else(|error| panic!("{r} {x}: {error}"));
            assert!(ball.position().z > z, "{r} {x}");
            // Off by more it is within.
            let within = scene.simulate(start(z - 1e-12 * r - 1e-9 * x), Rattle::new(1e-3)).unwrap();
            assert!(within.collide(Stop::above(Hill { r })).is_err(), "{r} {x}");
        }
        assert!(under > 10, "{r}: only {under} start below 0");
    }
}
