//! Errors of finished simulations, estimated: against exact motions, with contacts and edges, for staggered methods
//! and steps of their own length.

use rattle::Error;
use rattle::effect::{Langevin, Stop};
use rattle::error::PriceMistake;
use rattle::potentials::{Gravity, Harmonic};
use rattle::prelude::*;
use rattle::price::Estimate;
use rattle::surfaces::{Plane, Torus};

constraint! {
    /// Two planes that meet in a ridge.
    struct Roof {} |x, _y, z| z + abs(x)
}

fn within(factor: f64, estimate: &Estimate, truth: f64, who: &str) {
    let ratio = estimate.position / truth;
    assert!((1.0 / factor..factor).contains(&ratio), "{who}: {estimate}, in truth {truth:e}");
}

/// A ball that bounces: without its contact it would be 77 below the floor by then.
#[test]
fn contacts_are_those_of_the_run() {
    let floor = Plane { a: 0.0, b: 0.0, c: 1.0, d: 0.0 };
    let start = State::at([0.0, 0.0, 0.5]).moving([0.3, 0.0, 0.0]);
    let ball = Scene::point().with(Gravity { g: 1.0 }).simulate(start.clone(), Rattle::new(0.013)).unwrap();
    let mut ball = ball.collide(Stop::above(floor)).unwrap();
    ball.run(960).unwrap();
    assert_eq!(ball.events(), 6);
    // It rises from the floor with speed 1 every two units of time. Parabolas are exact, whatever the step.
    let since = (ball.time() + 1.0).rem_euclid(2.0);
    let truth = (ball.position().z - (since - 0.5 * since * since)).abs();
    let estimate = ball.estimate_error(&start).unwrap();
    assert!(truth < 1e-12 && estimate.position < 1e-12 && estimate.energy < 1e-12, "{estimate}, {truth:e}");

    // A spring in the place of weight: an error of h², which a contact passes on.
    let spring = Scene::point().with(Harmonic { stiffness: 1.0, centre: [0.0; 3] });
    let start = State::at([0.0, 0.0, 1.0]);
    let ball = spring.simulate(start.clone(), Rattle::new(0.02)).unwrap();
    let mut ball = ball.collide(Stop::above(floor)).unwrap();
    ball.run(500).unwrap();
    let truth = (ball.position().z - ball.time().cos().abs()).abs();
    assert_eq!(ball.events(), 3);
    within(1.1, &ball.estimate_error(&start).unwrap(), truth, "bouncing on a spring");
}

/// Over the ridge and down, and back by a spring: without `over_kinks` no comparison would pass the edge.
#[test]
fn edges_are_crossed_as_in_the_run() {
    let scene = Scene::on(Roof {}).with(Harmonic { stiffness: 1.0, centre: [0.0; 3] });
    let start = scene.project(&State::at([-0.5, 0.2, -0.5]).moving([1.0, 0.5, 1.0])).unwrap();
    let mut run = scene.simulate(start.clone(), Rattle::new(0.02)).unwrap().over_kinks().unwrap();
    run.run(400).unwrap();
    assert!(run.events() > 2);
    // Unfolded, the roof is a plane, and the centre lies in it.
    let (q, p) = (start.positions().next().unwrap(), start.momenta().next().unwrap());
    let (sin, cos) = run.time().sin_cos();
    let along = |q: f64, p: f64| q * cos + p * sin;
    let x = along(q.x, p.x);
    let exact = rattle::nalgebra::Vector3::new(x, along(q.y, p.y), -x.abs());
    within(1.5, &run.estimate_error(&start).unwrap(), (run.position() - exact).norm(), "roof");
}

/// Whatever draws: the method itself, or a flow that acts beside it.
#[test]
fn random_forces_are_refused() {
    let bath = Langevin { friction: 1.0, temperature: 0.5, seed: 3 };
    let scene = Scene::on(rattle::surfaces::Sphere { r: 1.0 }).with(bath);
    let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 0.5, 0.5]);
    fn asked<M: Method>(
        scene: &Scene<impl rattle::scene::Hold<3>, impl rattle::effect::Effects<3>, rattle::bodies::One, 3>,
        start: &State<3>,
        method: M,
    ) {
        let mut run = scene.simulate(start.clone(), method).unwrap();
        run.run(50).unwrap();
        let asked = run.estimate_error(start);
        assert!(matches!(asked, Err(Error::Price(PriceMistake::Random { .. }))), "{asked:?}");
    }
    asked(&scene, &start, Rattle::new(0.01));
    asked(&scene, &start, Baoab::new(0.01));
    let free = Scene::on(rattle::surfaces::Sphere { r: 1.0 });
    asked(&free, &start, Brownian::new(1.0, 1.0, 1, 0.01));
}

/// Momenta half a step off are those of another time for every step size.
#[test]
fn staggered_momenta_are_of_the_step_that_is_compared() {
    let spring = Scene::point().with(Harmonic { stiffness: 1.0, centre: [0.0; 3] });
    let start = State::at([1.0, 0.0, 0.0]);
    for h in [0.02, 0.01, 0.005] {
        let method = Leapfrog::new(h);
        let staggered = spring.staggered(&start, &method).unwrap();
        let mut run = spring.simulate(staggered.clone(), method).unwrap();
        run.run((10.0 / h) as u64).unwrap();
        let estimate = run.estimate_error(&staggered).unwrap();
        within(1.05, &estimate, (run.position().x - run.time().cos()).abs(), "leapfrog");
        assert!(estimate.order.is_some_and(|order| (order - 2.0).abs() < 0.05), "{estimate:?}");
        // The energy of leapfrog, with momenta of the same time, is off by h² sin² t/8.
        let energy = h * h * run.time().sin().powi(2) / 8.0;
        assert!((estimate.energy / energy - 1.0).abs() < 0.1, "{estimate}, energy {energy:e}");

        // From a state on the way, with momenta half a step later.
        let middle = run.state();
        run.run((10.0 / h) as u64).unwrap();
        let (q, p) = (middle.positions().next().unwrap().x, middle.momenta().next().unwrap().x);
        let (sin, cos) = (run.time() - middle.time()).sin_cos();
        let truth = run.position().x - (q * cos + (p + 0.5 * h * q) * sin);
        within(1.05, &run.estimate_error(&middle).unwrap(), truth.abs(), "leapfrog from a state on the way");
    }
    let scene = Scene::on(Torus { major: 1.0, minor: 0.3 }).with(Gravity { g: 2.0 });
    let start = scene.project(&State::at([1.0, 0.0, 0.3]).moving([0.4, 0.3, 0.0])).unwrap();
    let mut exact = scene.simulate(start.clone(), Lobatto::<8>::new(0.01)).unwrap();
    exact.run(300).unwrap();
    let method = Shake::new(0.01);
    let staggered = scene.staggered(&start, &method).unwrap();
    let mut run = scene.simulate(staggered.clone(), method).unwrap();
    run.run(300).unwrap();
    let estimate = run.estimate_error(&staggered).unwrap();
    within(1.2, &estimate, (run.position() - exact.position()).norm(), "SHAKE");

    let mut run = spring.simulate(State::at([1.0, 0.0, 0.0]), SymplecticEuler::new(0.001)).unwrap();
    run.run(5000).unwrap();
    let estimate = run.estimate_error(&State::at([1.0, 0.0, 0.0])).unwrap();
    within(1.05, &estimate, (run.position().x - run.time().cos()).abs(), "symplectic Euler");
}

/// Steps of their own length end at other times: the last one is made as long as it must be.
#[test]
fn runs_of_variable_steps_are_compared_at_one_time() {
    let spring = Scene::point().with(Harmonic { stiffness: 1.0, centre: [0.0; 3] });
    let start = State::at([1.0, 0.0, 0.0]);
    for h in [0.02, 0.01, 0.005] {
        for sign in [1.0, -1.0] {
            let mut run = spring.simulate(start.clone(), Variable::of(Rattle::new(sign * h), 1.0)).unwrap();
            run.run((10.0 / h) as u64).unwrap();
            let truth = (run.position().x - run.time().cos()).abs();
            within(1.1, &run.estimate_error(&start).unwrap(), truth, "variable steps of an oscillator");
        }
    }
    let scene = Scene::on(Torus { major: 1.0, minor: 0.3 }).with(Gravity { g: 2.0 });
    let start = scene.project(&State::at([1.0, 0.0, 0.3]).moving([0.4, 0.3, 0.0])).unwrap();
    let mut run = scene.simulate(start.clone(), Variable::of(Lobatto::<3>::new(0.02), 0.5)).unwrap();
    run.run(300).unwrap();
    let mut exact =
        scene.simulate(start.clone(), Dop853::adaptive(run.time() / 100.0, 1e-14)).unwrap().retry(6);
    exact.run(100).unwrap();
    let truth = (run.position() - exact.position()).norm();
    within(2.0, &run.estimate_error(&start).unwrap(), truth, "variable steps on a torus");
}
