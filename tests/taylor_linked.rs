//! Taylor's method on linked and rigid bodies: masses, trees and nets, redundant, moving and acting links, against
//! exact motions, references, and DOP853, which shares no recurrence with it.

use crate::common::linked::*;
use crate::common::*;
use rattle::LinearAlgebra::{Automatic, Elimination, Orthogonal};
use rattle::bodies::Many;
use rattle::effect::Effects;
use rattle::links::planar::TurningLine;
use rattle::nalgebra::{Matrix2, Matrix3, Vector3};
use rattle::network::Network;
use rattle::potentials::planar::Spring;
use rattle::prelude::*;

/// Positions, momenta and the work of moving links at t = 1, after so many steps.
fn end<E: Effects<D>, S: Method, const D: usize>(
    scene: &Scene<Network<D>, E, Many, D>,
    start: &State<D>,
    method: S,
) -> Vec<f64> {
    let mut simulation = scene.simulate(start.clone(), method.clone()).unwrap();
    simulation.run((1.0 / method.step_size()).round() as u64).unwrap();
    let mut found = phase(&simulation.state());
    found.push(simulation.work());
    found
}

/// The same motion by DOP853, by steps so short that what is left is rounding.
fn check<E: Effects<D>, const D: usize>(
    what: &str,
    scene: &Scene<Network<D>, E, Many, D>,
    start: &State<D>,
    h: f64,
    bound: f64,
) {
    let found = end(scene, start, Taylor::new(18, h));
    let other = end(scene, start, Dop853::new(h / 10.0));
    let coarse = end(scene, start, Taylor::new(6, h));
    println!("{what}: {:.1e}, order 6 {:.1e}", apart(&found, &other), apart(&coarse, &other));
    assert!(apart(&found, &phase(start).into_iter().chain([0.0]).collect::<Vec<_>>()) > 0.1, "it moved");
    assert!(apart(&found, &other) <= bound, "{what}: {:e}", apart(&found, &other));
    assert!(apart(&coarse, &other) > 100.0 * bound, "{what}: the order matters");
}

/// Two masses on a rod turn about their centre, which moves straight on: all coefficients are known.
#[test]
fn a_dumbbell_that_flies() {
    let (light, heavy, turn) = (1.0, 3.0, 1.25);
    let scene = Scene::points(2).link(Rod { length: 1.0 }, [[0, 1]]).masses([light, heavy]);
    let (a, b) = (0.75, -0.25); // from the centre of mass
    let drift = [0.5, -0.25];
    let momentum = |mass: f64, x: f64| [mass * drift[0], mass * (drift[1] + turn * x)];
    let start = State::of([[a, 0.0], [b, 0.0]]).with_momenta([momentum(light, a), momentum(heavy, b)]);
    for algebra in [Orthogonal, Elimination] {
        let mut simulation =
            scene.clone().linear_algebra(algebra).simulate(start.clone(), Taylor::new(20, 0.25)).unwrap();
        simulation.run(8).unwrap();
        let (t, (sin, cos)) = (2.0, (2.0 * turn).sin_cos());
        for (q, arm) in simulation.positions().zip([a, b]) {
            let exact = [arm * cos + drift[0] * t, arm * sin + drift[1] * t];
            assert!(distance(q, exact) <= 2e-15, "{:e}", distance(q, exact));
        }
        // λ ∇g = 2 λ (a − b) is the pull of the rod.
        let tension = light * a * turn * turn;
        assert!((2.0 * simulation.multipliers()[0] + tension).abs() <= 1e-14);
    }
}

#[test]
fn a_double_pendulum() {
    let rows = table("double_pendulum");
    let row = rows.iter().find(|row| row.text("case") == "equal" && row.number("t") == 2.0).unwrap();
    let exact = row.numbers::<4>(["x1", "y1", "x2", "y2"]);
    for algebra in [Orthogonal, Elimination] {
        let scene = Scene::points(3).link(Rod { length: 1.0 }, chain(2)).pin(0, [0.0; 2]);
        let scene = scene.linear_algebra(algebra).with(PlanarGravity { g: 1.0 });
        for method in [Taylor::new(18, 0.05), Taylor::adaptive(18, 0.5, 1e-16)] {
            let mut simulation = scene.simulate(double_pendulum(), method).unwrap();
            simulation.run((2.0 / method.step_size()).round() as u64).unwrap();
            let found = coordinates(&simulation.state());
            println!("{:e}", apart(&found[2..], &exact));
            assert!(apart(&found[2..], &exact) <= 1e-14, "{:e}", apart(&found[2..], &exact));
        }
    }
}

#[test]
fn chains_and_nets() {
    let zigzag = State::of((0..9).map(|i| [0.8 * f64::from(i), 0.6 * f64::from(i % 2)]));
    for algebra in [Orthogonal, Elimination] {
        let scene = Scene::points(9).link(Rod { length: 1.0 }, chain(8)).pin(0, [0.0; 2]);
        let scene = scene.linear_algebra(algebra).with(PlanarGravity { g: 1.0 });
        check("chain", &scene, &zigzag, 0.05, 1e-12);
    }
    let triangle = Scene::points(4)
        .link(Rod { length: 1.0 }, [[0, 1], [1, 2], [2, 0], [2, 3]])
        .link(Rod { length: 1.0 }, [[1, 2]]) // once more
        .with(PlanarGravity { g: 1.0 });
    let bent = State::of([[0.0, 0.0], [1.0, 0.0], [0.5, 0.9], [1.0, 1.6]]).with_momenta([
        [0.1, 0.9],
        [0.0; 2],
        [-0.5, 0.3],
        [0.8, 0.0],
    ]);
    let bent = triangle.project(&bent).unwrap();
    check("triangle with a rod twice", &triangle, &bent, 0.25, 1e-12);
}

#[test]
fn masses_springs_and_pairs() {
    let matrix = Matrix2::new(2.0, 0.3, 0.3, 1.0);
    let scene = Scene::points(4)
        .link(Rod { length: 1.0 }, [[0, 1], [1, 2]])
        .pin(0, [0.0; 2])
        .masses([matrix, Matrix2::identity(), matrix, Matrix2::identity() * 0.7])
        .with(PlanarGravity { g: 1.0 })
        .with(Spring { stiffness: 3.0, length: 0.6 }.over([[2, 3], [1, 3]]))
        .with(Ricker { depth: 0.5, radius: 0.8 });
    let start = State::of([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.8, 0.4]]).moving([0.0; 2]);
    check("springs", &scene, &start, 0.05, 2e-12);
}

constraint! {
    /// Two points whose distance grows with time.
    struct GrowingRod { length, rate }
    |a: [f64; 2], b: [f64; 2], t| sum(i in 0..2, (a[i] - b[i])^2) - (length + rate * t + rate * t^2)^2
}

/// A bead on a turning rod: r = cosh ωt; the rod does the work ω² sinh² ωt.
#[test]
fn links_that_move() {
    let (omega, t) = (0.8, 1.5);
    let line = Scene::points(1).link_moving(TurningLine { omega }, [[0]]);
    let start = State::of([[1.0, 0.0]]).moving([0.0, omega]);
    for method in [Taylor::new(18, 0.25), Taylor::adaptive(18, 0.75, 1e-16)] {
        let mut simulation = line.simulate(start.clone(), method).unwrap();
        simulation.run((t / method.step_size()).round() as u64).unwrap();
        let (r, angle) = (f64::cosh(omega * t), omega * t);
        let q = simulation.positions().next().unwrap();
        assert!(distance(q, [r * angle.cos(), r * angle.sin()]) <= 2e-15, "{q}");
        let work = (omega * f64::sinh(omega * t)).powi(2);
        assert!((simulation.work() - work).abs() <= 4e-15, "{:e}", simulation.work() - work);
        assert!(simulation.energy_error().abs() <= 4e-15, "{:e}", simulation.energy_error());
    }
    let growing = Scene::points(3)
        .link_moving(GrowingRod { length: 1.0, rate: 0.1 }, chain(2))
        .pin(0, [0.0; 2])
        .with(PlanarGravity { g: 1.0 });
    let grown = growing.project(&double_pendulum().at_time(0.3)).unwrap();
    check("rods that grow", &growing, &grown, 0.05, 1e-12);
}

/// Where the multiplier acts along x alone, y falls freely: y = y₀ − t²/2, and x stays on the circle.
#[test]
fn a_multiplier_on_one_coordinate() {
    let scene = Scene::point().link_acting(Pendulum { length: 1.0 }, [[0]], [[true, false]]);
    let scene = scene.with(PlanarGravity { g: 1.0 });
    let mut simulation = scene.simulate(State::at([0.6, 0.8]), Taylor::new(18, 0.05)).unwrap();
    simulation.run(20).unwrap();
    let (q, y) = (simulation.position(), 0.8 - 0.5);
    assert!((q.y - y).abs() <= 1e-15 && (q.x - f64::sqrt(1.0 - y * y)).abs() <= 1e-15, "{q}");
}

constraint! {
    /// QᵀQ = 1, the mixed equations twice.
    struct OrthogonalTwice {}
    |m: [[f64; 3]; 3]| for i in 0..3, j in 0..3 { sum(k in 0..3, m[k][i] * m[k][j]) - delta(i, j) }
}

/// A rigid body as nine coordinates under nine equations, of which six are independent.
#[test]
fn a_rigid_body_under_redundant_equations() {
    let (body, upright) = (Rigid::new([0.6, 0.8, 1.0]), Matrix3::identity());
    let d = body.column_masses();
    let scene = Scene::on(OrthogonalTwice {}).mass(std::array::from_fn::<f64, 9, _>(|k| d[k % 3]));
    let momenta = body.matrix_momenta(&upright, &Vector3::new(1.8, 0.4, -0.9));
    let start = State::at(Rigid::coordinates(&upright)).moving(momenta);
    let rows = table("rigid_body");
    let row = rows.iter().find(|row| row.number("t") == 1.0).unwrap();
    let mut simulation = scene.linear_algebra(Automatic).simulate(start, Taylor::new(18, 0.05)).unwrap();
    simulation.run(20).unwrap();
    let attitude = row.numbers(["Q11", "Q12", "Q13", "Q21", "Q22", "Q23", "Q31", "Q32", "Q33"]);
    assert!(distance(simulation.position(), attitude) <= 1e-14, "{}", simulation.position());
}

potential! {
    /// The weight of a top, and an uneven field.
    struct TopWeight { g }
    |q: [[f64; 3]; 3]| g * q[2][2] + g / (3 + q[0][1]) + sin(q[1][0] * q[2][1])
}

/// The same reduced to three unknowns, and two tops that act on each other.
#[test]
fn rigid_bodies() {
    let body = Rigid::new([0.6, 0.8, 1.0]);
    let start = Rigid::start(&Matrix3::identity(), &Vector3::new(1.8, 0.4, -0.9));
    let rows = table("rigid_body");
    let row = rows.iter().find(|row| row.number("t") == 1.0).unwrap();
    let mut simulation = Scene::rigid(body).simulate(start, Taylor::new(18, 0.05)).unwrap();
    simulation.run(20).unwrap();
    let attitude = row.numbers(["Q11", "Q12", "Q13", "Q21", "Q22", "Q23", "Q31", "Q32", "Q33"]);
    assert!(distance(simulation.position(), attitude) <= 2e-15, "{}", simulation.position());
    let p = simulation.momentum();
    assert!(distance([p[0], p[1], p[2]], row.numbers(["m1", "m2", "m3"])) <= 2e-15);

    let tops = Scene::rigid(Rigid::new([0.6, 0.6, 0.4])).bodies(2).with(TopWeight { g: 1.0 });
    let tops = tops.with(Ricker { depth: 0.5, radius: 0.8 });
    let turned = rattle::nalgebra::Rotation3::from_euler_angles(0.4, 0.2, 0.0);
    let coordinates = [turned.matrix(), &Matrix3::identity()].map(Rigid::coordinates);
    let start = State::of(coordinates).with_momenta([
        [0.3, -0.2, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.1, 0.9, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    ]);
    let after = |method: Taylor| {
        let mut simulation = tops.simulate(start.clone(), method).unwrap();
        simulation.run((1.0 / method.step_size()).round() as u64).unwrap();
        phase(&simulation.state())
    };
    let mut other = tops.simulate(start.clone(), Dop853::new(0.005)).unwrap();
    other.run(200).unwrap();
    let other = phase(&other.state());
    let errors =
        [Taylor::new(18, 0.0125), Taylor::new(4, 0.0125)].map(|method| apart(&after(method), &other));
    println!("tops: {errors:?}");
    assert!(errors[0] <= 1e-13 && errors[1] > 1e-8, "{errors:?}");
}

/// The multipliers that an observer hears are those of the motion at the two ends of the step.
#[test]
fn multipliers_are_those_of_the_motion() {
    let scene = Scene::points(3).link(Rod { length: 1.0 }, chain(2)).pin(0, [0.0; 2]);
    let scene = scene.with(PlanarGravity { g: 1.0 });
    let mut rods = scene.simulate(double_pendulum(), Taylor::new(18, 0.05)).unwrap();
    for _ in 0..10 {
        let before = rods.multipliers();
        let mut heard = Trajectory::with_multipliers(&rods);
        rods.observe(1, 1, &mut heard).unwrap();
        let heard = heard.multipliers().unwrap();
        assert!(apart(&heard.position[2..], &before) <= 1e-13);
        assert!(apart(&heard.momentum[2..], &rods.multipliers()) <= 1e-13);
    }
}

#[test]
fn a_step_does_not_allocate() {
    let scene = Scene::points(3).link(Rod { length: 1.0 }, chain(2)).pin(0, [0.0; 2]);
    let scene = scene.with(PlanarGravity { g: 1.0 });
    let mut rods = scene.simulate(double_pendulum(), Taylor::adaptive(16, 0.5, 1e-15)).unwrap();
    let surface = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let mut particle = surface.simulate(billiard_45(), Taylor::new(16, 0.01)).unwrap();
    let allocated = allocation_counter::measure(|| {
        rods.run(5).unwrap();
        particle.run(50).unwrap();
    });
    assert_eq!(allocated.count_total, 0);
}

/// Steps far too long end in an error as soon as their end cannot be brought back: no step leaves the links apart.
#[test]
fn a_motion_that_runs_away_is_an_error_at_once() {
    fn check(method: impl Method + std::fmt::Debug) {
        let scene = Scene::points::<2>(3)
            .link(Rod { length: 1.0 }, [[0, 1], [1, 2]])
            .pin(0, [0.0; 2])
            .with(PlanarGravity { g: 9.81 });
        let what = format!("{method:?}");
        let mut simulation = scene.simulate(double_pendulum(), method).unwrap();
        let mut steps = 0;
        let error = loop {
            match simulation.step() {
                Ok(()) => steps += 1,
                Err(error) => break error,
            }
            let size = coordinates(&simulation.state()).iter().fold(0.0_f64, |size, x| size.max(x.abs()));
            assert!(simulation.constraint_residual() < 1e-13 && size < 3.0, "{what}, step {steps}: {size:e}");
            assert!(steps < 1000, "{what} goes on");
        };
        println!("{what} ends after {steps} steps: {error}");
    }
    check(Dop853::new(0.2));
    check(Dop853::new(0.3));
    check(Taylor::new(16, 0.1));
    check(Taylor::new(16, 0.2));
    check(Taylor::new(32, 0.05));
}
