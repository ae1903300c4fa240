//! Adaptive methods: what is local is not stepped over, work that changes fast is booked, and time has any unit.

use rattle::links::planar::{Rod, TurningLine};
use rattle::prelude::*;
use rattle::surfaces::Sphere;

potential! {
    /// A spot on a sphere that nothing with less energy than a passes.
    struct Spot { a, w, cx, cy, cz }
    |x, y, z| a * exp(-((x - cx)^2 + (y - cy)^2 + (z - cz)^2) / w^2)
}

potential! {
    /// The same on a line.
    struct Bump { a, w }
    |x| a * exp(-(x / w)^2)
}

potential! {
    /// A weight that is shaken.
    struct ShakenWeight { g, b, w }
    |_x, _y, z, t| (g + b * sin(w * t)) * z
}

potential! {
    /// An oscillator, and a part of time alone.
    struct Gauge { k, w }
    |x, t| k * x^2 + sin(w * t)
}

potential! {
    /// A weight in the plane.
    struct Weight { g }
    |_x, y| g * y
}

constraint! {
    /// A table.
    struct Table { height }
    |_x, _y, z| z - height
}

/// Starts that run head-on into a spot at (0, 1, 0), at distances of 1.2 to 1.8.
fn head_on(number: u32) -> impl Iterator<Item = State<3>> {
    (0..number).map(move |i| {
        let (sin, cos) =
            (std::f64::consts::FRAC_PI_2 - 1.2 - 0.6 * f64::from(i) / f64::from(number)).sin_cos();
        State::at([cos, sin, 0.0]).moving([-sin, cos, 0.0])
    })
}

/// An energy of 0.5 does not pass a spot of height 2, and is kept.
#[test]
fn series_do_not_step_over_spots() {
    for (w, h, order) in [(0.1, 2.5, 18), (0.05, 1.0, 12), (0.05, 1.0, 18), (0.05, 1.0, 30)] {
        let scene = Scene::on(Sphere { r: 1.0 }).with(Spot { a: 2.0, w, cx: 0.0, cy: 1.0, cz: 0.0 });
        let (mut through, mut gained, mut all) = (0, 0.0_f64, 0);
        for start in head_on(40) {
            let mut run = scene.simulate(start, Taylor::adaptive(order, h, 1e-8)).unwrap();
            run.run((3.0 / h).ceil() as u64).unwrap();
            through += usize::from(run.position().x < -0.1);
            gained = gained.max(run.energy_error().abs());
            all += 1;
        }
        println!("w {w} h {h} order {order}: {through} of {all} through, {gained:e}");
        if w / h >= 0.05 {
            assert!(all == 40 && through == 0 && gained < 1e-5, "{through} of {all} through, {gained:e}");
        }
    }
}

/// So it is in lanes, which go by themselves there.
#[test]
fn lanes_do_not_step_over_spots() {
    let scene = Scene::on(Sphere { r: 1.0 }).with(Spot { a: 2.0, w: 0.05, cx: 0.0, cy: 1.0, cz: 0.0 });
    let mut ensemble = scene.ensemble(head_on(64), Taylor::adaptive(18, 1.0, 1e-8)).unwrap();
    ensemble.run(3);
    assert_eq!(ensemble.failures().count(), 0);
    let through = ensemble.states().filter(|state| state.positions().next().unwrap().x < -0.1).count();
    assert_eq!(through, 0);
}

/// The table pushes with what the weight pulls with, and the body goes on: U changes by work alone.
#[test]
fn work_that_changes_fast_is_booked() {
    let scene = Scene::on(Table { height: 1.0 }).with(ShakenWeight { g: 1.0, b: 0.5, w: 50.0 });
    let start = State::at([0.0, 0.0, 1.0]).moving([1.0, 0.0, 0.0]);
    for h in [0.5, 0.05] {
        let mut run = scene.simulate(start.clone(), Dop853::adaptive(h, 1e-12)).unwrap();
        run.run((5.0 / h) as u64).unwrap();
        let exact = 0.5 * (50.0 * run.time()).sin();
        assert!((run.work() - exact).abs() < 1e-9 && run.energy_error().abs() < 1e-9, "{h}: {}", run.work());
    }
    let free = Scene::point().with(Gauge { k: 0.5, w: 50.0 });
    for h in [0.1, 1.0] {
        let mut run = free.simulate(State::at([1.0]), Dop853::adaptive(h, 1e-10)).unwrap();
        run.run((10.0 / h) as u64).unwrap();
        assert!((run.work() - (50.0 * run.time()).sin()).abs() < 1e-8, "{h}: {}", run.work());
        assert!(run.energy_error().abs() < 1e-8, "{h}: {:e}", run.energy_error());
    }
    // A link that moves: its work is that of λ.
    let line = Scene::points(1).link_moving(TurningLine { omega: 0.8 }, [[0]]);
    let mut run =
        line.simulate(State::of([[1.0, 0.0]]).moving([0.0, 0.8]), Dop853::adaptive(0.5, 1e-12)).unwrap();
    run.run(10).unwrap();
    let exact = (0.8 * (0.8 * run.time()).sinh()).powi(2);
    assert!((run.work() / exact - 1.0).abs() < 1e-8, "{} for {exact}", run.work());
    assert!(run.energy_error().abs() < 1e-8 * exact, "{:e}", run.energy_error());
}

/// A pendulum of any size and any frequency, as a link: it swings as one of length 1 and frequency 1.
#[test]
fn links_have_a_unit_of_time() {
    let swing = |length: f64, omega: f64, order| {
        let scene = Scene::points(2)
            .link(Rod { length }, [[0, 1]])
            .pin(0, [0.0; 2])
            .with(Weight { g: length * omega * omega });
        let start = State::of([[0.0, 0.0], [length, 0.0]]);
        let method = Taylor::adaptive(order, 0.25 / omega, 1e-12 * length);
        let mut run = scene.simulate(start, method).unwrap();
        run.run(20).map(|()| run.positions().nth(1).unwrap() / length)
    };
    let turned = |omega: f64, order| {
        let line = Scene::points(1).link_moving(TurningLine { omega }, [[0]]);
        let start = State::of([[1.0, 0.0]]).moving([0.0, omega]);
        let mut run = line.simulate(start, Taylor::adaptive(order, 0.25 / omega, 1e-12)).unwrap();
        run.run(10).map(|()| (run.positions().next().unwrap(), run.work() / (omega * omega)))
    };
    for order in [12, 24, 30, 50] {
        let exact = swing(1.0, 1.0, order).unwrap();
        let (place, work) = turned(1.0, order).unwrap();
        for (length, omega) in [(1e-10, 1e14), (1.0, 1e-8), (1e3, 1e-8)] {
            let found = swing(length, omega, order).unwrap();
            assert!((found - exact).norm() < 1e-10, "{length:e} {omega:e} {order}: {found} {exact}");
            let (there, done) = turned(omega, order).unwrap();
            let off = (there - place).norm().max((done - work).abs());
            assert!(off < 1e-9, "{omega:e} {order}: {off:e}");
        }
    }
}

/// So do rigid bodies.
#[test]
fn rigid_bodies_have_a_unit_of_time() {
    let body = Scene::rigid(Rigid::new([0.6, 0.8, 1.0]));
    let turned = |omega: f64, order| {
        let spin = rattle::nalgebra::Vector3::new(1.8, 0.4, -0.9) * omega;
        let start = Rigid::start(&rattle::nalgebra::Matrix3::identity(), &spin);
        let mut run = body.simulate(start, Taylor::adaptive(order, 0.25 / omega, 1e-12)).unwrap();
        run.run(20).map(|()| run.position())
    };
    for order in [12, 30, 50] {
        let exact = turned(1.0, order).unwrap();
        for omega in [1e14, 1e-8] {
            let off = (turned(omega, order).unwrap() - exact).norm();
            assert!(off < 1e-10, "{omega:e} {order}: {off:e}");
        }
    }
}

/// A bump on a line is met too.
#[test]
fn series_turn_back_before_bumps() {
    let scene = Scene::point().with(Bump { a: 2.0, w: 0.05 });
    for i in 0..40 {
        let x = -1.2 - 0.015 * f64::from(i);
        let mut run = scene.simulate(State::at([x]).moving([1.0]), Taylor::adaptive(18, 1.0, 1e-8)).unwrap();
        run.run(3).unwrap();
        assert!(run.position().x < 0.0 && run.energy_error().abs() < 1e-5, "{x}: {}", run.position().x);
    }
}

constraint! {
    /// A tube along x.
    struct Tube {}
    |_x, y, z| y^2 + z^2 - 1
}

constraint! {
    /// A plane that goes to and fro.
    struct Shaken {}
    |x, _y, t| x - sin(t)
}

/// Equal inner steps are rounded alike: what each of hundreds loses of the time would add up. Along a tube x tells how
/// much time has passed, while the way around it has inner steps be short; by simulations and in lanes, of one equation
/// and of links.
#[test]
fn long_steps_take_all_of_their_time() {
    fn check<S: Method>(method: S) {
        let (h, name) = (method.step_size(), method.name());
        let start = || State::of([[0.0, 1.0, 0.0]]).with_momenta([[1.0, 0.0, 1.0]]);
        let mut passed = Vec::new();
        macro_rules! both {
            ($scene:expr) => {
                let mut alone = $scene.simulate(start(), method.clone()).unwrap();
                alone.run(1).unwrap();
                passed.push(alone.positions().next().unwrap().x);
                let mut lanes = $scene.ensemble(vec![start(); 8], method.clone()).unwrap();
                lanes.run(1);
                passed.push(lanes.state(3).positions().next().unwrap().x);
            };
        }
        both!(Scene::on(Tube {}));
        both!(Scene::points(1).link(Tube {}, [[0]]));
        assert!(passed.iter().all(|x| (x - h).abs() <= 2.0 * f64::EPSILON * h), "{name}: {passed:?}");
    }
    check(Taylor::adaptive(18, 400.0, 1e-15));
    check(Dop853::adaptive(100.0, 1e-12));

    // Where the plane is tells what time it is.
    fn check_time<S: Method>(method: S) {
        let (h, name) = (method.step_size(), method.name());
        let plane = Scene::points(1).link_moving(Shaken {}, [[0]]);
        let start = State::of([[0.0, 0.0]]).with_momenta([[1.0, 0.0]]);
        let mut run = plane.simulate(start, method).unwrap();
        run.run(1).unwrap();
        let x = run.positions().next().unwrap().x;
        assert!((x - h.sin()).abs() <= f64::EPSILON * h, "{name}: {:e}", x - h.sin());
    }
    check_time(Taylor::adaptive(18, 1000.0, 1e-11));
    check_time(Dop853::adaptive(1000.0, 1e-10));
}
