//! A step that cannot be taken is taken in parts, if that is asked for.

use crate::common::*;
use rattle::error::{StepFailure, SurfaceFailure};
use rattle::prelude::*;
use rattle::{Counted, Error, Geodesic};

/// A ball that falls from the top of a unit sphere: h·κ·|v| is h|v|, and |v| grows to 2 at the bottom.
fn falling<S: Method>(
    method: S,
) -> Simulation<impl rattle::system::System<f64, 3, Count = rattle::bodies::One>, S, 3> {
    let start = State::at([0.0, 0.0, 1.0]).moving([0.2, 0.0, 0.0]);
    Scene::on(Sphere { r: 1.0 }).with(Gravity { g: 1.0 }).simulate(start, method).unwrap()
}

/// Steps until the first that fails.
fn until_failure<S: Method>(method: S) -> u64 {
    let mut simulation = falling(method);
    let error = simulation.run(1000).unwrap_err();
    assert!(matches!(error, Error::Step { .. }), "{error}");
    simulation.steps()
}

#[test]
fn only_the_step_that_fails_is_divided() {
    check(Rattle::new(0.7));
    check(Rattle::new(0.7).guess(Extrapolated));
    check(Geodesic::new(2, 1.6));
    check(Composition::new(SUZUKI_1990_ORDER_4, 1.0));
    check(PositionVerlet::new(1.3));
}

/// Places and momenta, without what is remembered of the steps before.
fn bodies(state: &State<3>) -> String {
    let all = bits(state);
    all[..all.find("time").unwrap()].to_owned()
}

fn check<S: Method>(method: S) {
    let (name, h) = (method.name(), method.step_size());
    let before = until_failure(method.clone());
    let mut simulation = falling(method.clone()).retry(4);
    simulation.run(before).unwrap();
    let mut plain = falling(method.clone());
    plain.run(before).unwrap();
    assert_eq!(bits(&simulation.state()), bits(&plain.state()), "{name}: steps that can be taken are whole");

    // The next one is that of two halves, or of four quarters …, bit for bit.
    simulation.step().unwrap();
    let parts = [2, 4, 8, 16].map(|parts: u32| {
        let scene = Scene::on(Sphere { r: 1.0 }).with(Gravity { g: 1.0 });
        let mut inner = scene.simulate(plain.state(), method.with_step(h / f64::from(parts))).unwrap();
        inner.run(parts.into()).is_ok().then(|| bodies(&inner.state()))
    });
    let first = parts.into_iter().flatten().next().expect("some parts can be taken");
    assert_eq!(bodies(&simulation.state()), first, "{name}");
    assert_eq!((simulation.steps(), simulation.time()), (before + 1, (before + 1) as f64 * h), "{name}");

    simulation.run(100).unwrap();
    assert!(simulation.constraint_residual() <= 1e-15);
}

#[test]
fn what_cannot_be_taken_in_parts_either_is_an_error_and_leaves_no_trace() {
    let before = until_failure(Rattle::new(0.7));
    let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 100.0, 0.0]);
    let mut simulation = Scene::on(Sphere { r: 1.0 }).simulate(start, Rattle::new(0.7)).unwrap().retry(3);
    let was = simulation.state();
    let error = simulation.step().unwrap_err();
    let Error::Retried {
        step: 1,
        halvings: 3,
        body: 0,
        cause: StepFailure::Surface(SurfaceFailure::StepTooLong { h, .. }),
        ..
    } = error
    else {
        panic!("{error}")
    };
    assert_eq!(h, 0.7 / 8.0, "the cause is that of the shortest parts");
    assert_eq!(bits(&simulation.state()), bits(&was));
    assert_eq!((simulation.steps(), simulation.time()), (0, 0.0));
    assert!(error.to_string().contains("halved 3 times"), "{error}");
    assert!(before > 0);

    // Staggered momenta belong to one step size.
    let method = Shake::new(0.7);
    let error = falling(method).retry(3).run(1000).unwrap_err();
    assert!(matches!(error, Error::Step { .. }), "{error}");
}

potential! {
    /// Not a number beyond x = 0.95.
    struct Edge {}
    |x, _y, _z| sqrt(0.95 - x)
}

/// Parts that were taken before one failed are taken back.
#[test]
fn parts_before_the_one_that_fails_leave_no_trace() {
    let scene = Scene::on(Sphere { r: 1.0 }).with(Edge {});
    let start = scene.project(&State::at([0.9, 0.4, 0.0]).moving([0.4, -0.9, 0.0])).unwrap();
    let mut simulation = scene.simulate(start, Rattle::new(0.3)).unwrap().retry(3);
    let was = simulation.state();
    let error = simulation.step().unwrap_err();
    assert!(matches!(error, Error::Retried { .. }), "{error}");
    assert_eq!(bits(&simulation.state()), bits(&was));
    assert_eq!(simulation.step().unwrap_err().to_string(), error.to_string());
}

constraint! {
    /// A plane with a small roof around x = 0.
    struct Roof { slope, width }
    |x, _y, z| z - slope * max(0, width - x^2 / width)
}
potential! {
    /// A spring, and no number where a step of 1.2 from x = −0.6 at unit speed ends.
    struct Hole { k }
    |x, _y, _z| if abs(x - 0.6432) < 0.005 { sqrt(-1 - x^2) } else { k * x^2 / 2 }
}

/// The whole step fails. The first of two parts ends on the roof, beyond an edge, the second beyond all.
#[test]
fn edges_within_parts_are_told() {
    let scene = Scene::on(Roof { slope: 0.08, width: 0.2 }).with(Hole { k: 0.1 });
    let start = State::at([-0.6, 0.0, 0.0]).moving([1.0, 0.0, 0.0]);
    fn told<S: Method, E: rattle::effect::Effects<3>>(
        scene: &Scene<Roof, E, rattle::bodies::One, 3>,
        start: &State<3>,
        method: S,
    ) {
        let mut simulation = scene.simulate(start.clone(), method.clone()).unwrap().retry(1);
        let error = simulation.step().unwrap_err();
        let mut ensemble = scene.ensemble([start.clone()], method).unwrap().retry(1);
        ensemble.run(2); // in lanes the force at the end is that of the next step
        for error in [&error, ensemble.failure(0).expect("an edge")] {
            let Error::Retried { cause: StepFailure::Kink { argument, .. }, .. } = error else {
                panic!("{error}")
            };
            assert!(argument.contains("width"), "{argument}");
        }
    }
    told(&scene, &start, Rattle::new(1.2));
    told(&scene, &start, Lobatto::<3>::new(1.2));
}

/// A wall within a step, which parts however short run into: the work ends all the same.
#[test]
fn at_a_wall_work_is_bounded() {
    let edge = Counted::new(Edge {});
    let counts = edge.counts();
    let scene = Scene::point().with(edge);
    let start = || State::at([0.0, 0.0, 0.0]).moving([1.0, 0.0, 0.0]);
    let mut simulation = scene.simulate(start(), Rattle::new(1.5)).unwrap().retry(30);
    let error = simulation.step().unwrap_err();
    assert!(matches!(error, Error::Retried { halvings: 16, .. }), "{error}");
    let alone = counts.gradients();
    assert!((1 << 15..1 << 18).contains(&alone), "{alone} evaluations");

    let mut ensemble = scene.ensemble([start()], Rattle::new(1.5)).unwrap().retry(30);
    ensemble.run(1);
    assert!(matches!(ensemble.failure(0), Some(Error::Retried { halvings: 16, .. })));
    let together = counts.gradients() - alone;
    assert!((1 << 15..1 << 18).contains(&together), "{together} evaluations");
}
