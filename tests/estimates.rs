//! Errors of finished simulations, estimated: against exact motions, with contacts and edges, for staggered methods
//! and steps of their own length.

use rattle::effect::{Langevin, LinearDrag, Stop};
use rattle::error::PriceMistake;
use rattle::potentials::planar::Kepler;
use rattle::potentials::{Gravity, Harmonic};
use rattle::prelude::*;
use rattle::price::Estimate;
use rattle::surfaces::{Plane, Sphere, Torus};
use rattle::{Error, Variable};

constraint! {
    /// Two planes that meet in a ridge.
    struct Roof {} |x, _y, z| z + abs(x)
}

potential! {
    /// None at all at odd multiples of half a period.
    struct Gate { w } |_x, _y, z, t| z * sqrt(cos(w * t))
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
    let scene = Scene::on(Sphere { r: 1.0 }).with(bath);
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
    let free = Scene::on(Sphere { r: 1.0 });
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

/// The estimate of a run on a torus under gravity, and its true error.
fn told<M: Method>(method: M, steps: u64) -> (Estimate, f64) {
    let scene = Scene::on(Torus { major: 1.0, minor: 0.3 }).with(Gravity { g: 1.0 });
    let start = State::at([1.3, 0.0, 0.0]).moving([0.0, 1.0, 0.3]);
    let mut exact = scene.simulate(start.clone(), Taylor::adaptive(24, method.step_size(), 1e-16)).unwrap();
    exact.run(steps).unwrap();
    let mut run = scene.simulate(start.clone(), method).unwrap();
    run.run(steps).unwrap();
    (run.estimate_error(&start).unwrap(), (run.position() - exact.position()).norm())
}

/// With steps shorter than the tolerance asks for, a smaller tolerance alone would change nothing.
#[test]
fn steps_may_decide_the_error_of_an_adaptive_method() {
    for (h, tolerance) in [(0.3, 1e-3), (0.1, 1e-3), (0.1, 1e-6), (1.0, 1e-3), (1.0, 1e-6), (0.3, 1e-9)] {
        let (estimate, truth) = told(Dop853::adaptive(h, tolerance), (6.0 / h) as u64);
        within(1.1, &estimate, truth, &format!("DOP853 with {h} and {tolerance:e}"));
    }
    for (order, h, tolerance) in
        [(6, 0.01, 1e-6), (6, 0.1, 1e-6), (4, 0.01, 1e-6), (12, 0.3, 1e-3), (4, 1.0, 1e-6)]
    {
        let (estimate, truth) = told(Taylor::adaptive(order, h, tolerance), (6.0 / h) as u64);
        within(1.1, &estimate, truth, &format!("Taylor {order} with {h} and {tolerance:e}"));
    }
    // Beyond rounding.
    for tolerance in [1e-14, 1e-15, 1e-16] {
        let (estimate, truth) = told(Taylor::adaptive(16, 0.1, tolerance), 60);
        assert!(estimate.position < 1e-13 && truth < 1e-13, "{estimate}, in truth {truth:e}");
        let (estimate, truth) = told(Dop853::adaptive(0.1, tolerance), 60);
        assert!(estimate.position < 1e-13 && truth < 1e-13, "{estimate}, in truth {truth:e}");
    }
}

/// However few: the run that is compared is never the run itself.
#[test]
fn few_steps_have_an_error_too() {
    for steps in (1..24).chain([33, 101, 102, 103]) {
        let (estimate, truth) = told(Rattle::new(0.05), steps);
        within(1.1, &estimate, truth, &format!("{steps} steps of RATTLE"));
        let (estimate, truth) = told(Lobatto::<3>::new(0.05), steps);
        within(1.1, &estimate, truth, &format!("{steps} steps of Lobatto"));
    }
}

/// Another motion is told from an error, where it is off by more than that.
#[test]
fn starts_of_another_motion_are_refused() {
    fn refused<M: Method>(method: M, steps: u64) {
        let scene = Scene::on(Torus { major: 1.0, minor: 0.3 }).with(Gravity { g: 1.0 });
        let start = |v: f64| State::at([1.3, 0.0, 0.0]).moving([0.0, 1.0, v]);
        let mut run = scene.simulate(start(0.3), method).unwrap();
        run.run(steps).unwrap();
        assert!(run.estimate_error(&start(0.3)).is_ok());
        let other = run.estimate_error(&start(0.5));
        assert!(matches!(other, Err(Error::Price(PriceMistake::OtherMotion { .. }))), "{other:?}");
    }
    for steps in [1, 3, 8, 100, 101] {
        refused(Rattle::new(0.01), steps);
        refused(Lobatto::<3>::new(0.01), steps);
        refused(Dop853::adaptive(0.01, 1e-6), steps);
        refused(Variable::of(Rattle::new(0.01), 0.5), steps);
    }
}

/// A state with more steps behind it than the run is no start of it, also where steps have lengths of their own.
#[test]
fn later_states_are_no_starts() {
    fn refused<M: Method>(method: M) {
        let scene = Scene::on(Torus { major: 1.0, minor: 0.3 }).with(Gravity { g: 1.0 });
        let start = State::at([1.3, 0.0, 0.0]).moving([0.0, 1.0, 0.3]);
        let run = |steps: u64| {
            let mut run = scene.simulate(start.clone(), method.clone()).unwrap();
            run.run(steps).unwrap();
            run
        };
        let told = run(50).estimate_error(&run(100).state());
        assert!(matches!(told, Err(Error::Price(PriceMistake::OtherStart { .. }))), "{told:?}");
    }
    refused(Rattle::new(0.01));
    refused(Variable::of(Rattle::new(0.01), 0.5));
}

/// A step of twice 0.55 leaves the sphere of radius 1: then steps half as long are compared.
#[test]
fn runs_that_cannot_be_compared_are_told() {
    let scene = Scene::on(Sphere { r: 1.0 });
    let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 0.6, 0.8]);
    let mut run = scene.simulate(start.clone(), Rattle::new(0.55)).unwrap();
    run.run(10).unwrap();
    let off = 10.0 * (0.55_f64.asin() - 0.55); // an angle
    within(1.1, &run.estimate_error(&start).unwrap(), 2.0 * (0.5 * off).sin(), "long steps on a sphere");

    // At the ends of whole steps the gate is open, and in the middle of one there is none.
    let h = 0.1;
    let gate = Scene::point().with(Gate { w: std::f64::consts::TAU / h });
    let start = State::at([0.0; 3]);
    let mut run = gate.simulate(start.clone(), Rattle::new(h)).unwrap();
    run.run(4).unwrap();
    let error = run.estimate_error(&start).unwrap_err().to_string();
    assert!(
        error.starts_with("the comparison with steps of 0.05 failed: step 1 (t = 0.0), body 0:"),
        "{error}"
    );
}

/// With flows steps are of second order, whatever the method.
#[test]
fn few_steps_with_flows() {
    let damping = 0.5_f64;
    let scene =
        Scene::point().with(Harmonic { stiffness: 1.0, centre: [0.0; 3] }).with(LinearDrag::new(damping));
    fn check<M: Method>(
        scene: &Scene<impl rattle::scene::Hold<3>, impl rattle::effect::Effects<3>, rattle::bodies::One, 3>,
        method: M,
        damping: f64,
    ) {
        let start = State::at([1.0, 0.0, 0.0]);
        let mut run = scene.simulate(start.clone(), method).unwrap();
        run.run(5).unwrap();
        let (rate, t) = ((1.0 - 0.25 * damping * damping).sqrt(), run.time());
        let exact = (-0.5 * damping * t).exp() * ((rate * t).cos() + 0.5 * damping / rate * (rate * t).sin());
        let truth = (run.position().x - exact).abs();
        within(1.05, &run.estimate_error(&start).unwrap(), truth, "few steps with drag");
    }
    check(&scene, Rattle::new(0.1), damping);
    check(&scene, Lobatto::<5>::new(0.1), damping);
}

/// From a state on the way, near the centre of an orbit: the other runs keep to the rule of this one, which knows the
/// speed at its start.
#[test]
fn variable_steps_from_a_state_on_the_way() {
    let scene = Scene::point().with(Kepler { mu: 1.0, centre: [0.0; 2] });
    let start = State::at([1.9, 0.0]).moving([0.0, (0.1_f64 / 1.9).sqrt()]);
    let mut run = scene.simulate(start.clone(), Variable::of(Rattle::new(0.01), 1.0)).unwrap();
    run.run_while(u64::MAX, |now| now.position().norm() > 0.15).unwrap();
    let middle = run.state();
    run.run_while(u64::MAX, |now| now.time() < middle.time() + 4.0).unwrap();
    let steps = Taylor::adaptive(24, (run.time() - middle.time()) / 400.0, 1e-16);
    let mut exact = scene.simulate(middle.clone(), steps).unwrap();
    exact.run(400).unwrap();
    let truth = (run.position() - exact.position()).norm();
    within(1.5, &run.estimate_error(&middle).unwrap(), truth, "variable steps on the way");
}
