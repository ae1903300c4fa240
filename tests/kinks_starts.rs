//! Starts on an edge of a constraint.
//!
//! | roof | momentum | expected |
//! |---|---|---|
//! | falling away along its ridge | along the ridge | an error that names the edge, by each method, in lanes |
//! | straight | along the ridge | goes on |
//! | both | along a face | on that face once projected, with the same momentum, and energy kept |

use crate::common::*;
use rattle::Error;
use rattle::error::StepFailure;
use rattle::prelude::*;

constraint! {
    /// Two planes that meet in a ridge.
    struct Roof { slope }
    |x, _y, z| z + slope * abs(x)
}

/// The step that failed, its argument, the share of the step and the angle by which the normal turns, in degrees.
fn kink(error: Error) -> (u64, &'static str, f64, f64) {
    match error {
        Error::Step { step, cause: StepFailure::Kink { argument, share, angle, .. }, .. } => {
            (step, argument, share, angle.to_degrees())
        }
        other => panic!("{other}"),
    }
}

constraint! {
    /// A roof whose ridge falls away.
    struct Saddled { slope }
    |x, y, z| z + slope * abs(x) + 0.2 * y^2
}

/// Along a ridge the constraint takes the body over it, to one side or the other: the edge is named, whatever the step.
#[test]
fn a_start_along_a_ridge_is_told_as_such() {
    let scene = Scene::on(Saddled { slope: 0.7 });
    let degrees = 2.0 * 0.7_f64.atan().to_degrees();
    for h in [1e-2, 1e-4, 1e-7] {
        let start = State::at([0.0, 0.0, 0.0]).moving([0.0, 0.5, 0.0]);
        let mut simulation = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
        let error = simulation.run(3).unwrap_err();
        let text = error.to_string();
        assert!(text.contains("begin beside it") && !text.contains("let `over_kinks`"), "{text}");
        let (step, argument, share, angle) = kink(error);
        assert!(
            (step, argument) == (1, "x") && share < 1e-5 && (angle - degrees).abs() < 0.1,
            "{share} {angle}"
        );
        let over = scene.simulate(start, Rattle::new(h)).unwrap().over_kinks().unwrap().run(3).unwrap_err();
        assert_eq!(kink(over).1, "x");
    }
    fn by<S: Method>(method: &S) {
        let scene = Scene::on(Saddled { slope: 0.7 });
        let start = State::at([0.0; 3]).moving([0.0, 0.5, 0.0]);
        let start = scene.staggered(&start, method).unwrap();
        assert_eq!(kink(scene.simulate(start, method.clone()).unwrap().run(3).unwrap_err()).1, "x");
    }
    by(&Rattle::new(0.01).solved_by(Broyden));
    by(&Shake::new(0.01));
    by(&PositionVerlet::new(0.01));
    by(&Lobatto::<3>::new(0.01));
    by(&Dop853::new(0.01));
    by(&Taylor::adaptive(12, 0.01, 1e-12));
    let starts = (0..16).map(|i| State::at([0.0; 3]).moving([0.0, 0.4 + 0.01 * f64::from(i), 0.0]));
    let mut ensemble = scene.ensemble(starts, Rattle::new(0.01)).unwrap();
    ensemble.run(3);
    assert_eq!(ensemble.failures().count(), 16);
    assert_eq!(kink(ensemble.failure(0).unwrap().clone()).1, "x");
    // A straight ridge, along which both faces lead.
    Scene::on(Roof { slope: 0.7 })
        .simulate(State::at([0.0; 3]).moving([0.0, 0.5, 0.0]), Rattle::new(0.01))
        .unwrap()
        .run(3)
        .unwrap();
}

/// From an edge along that face whose normal is not the one at the edge: refused with the name of the edge, and
/// `project` takes this face, with all of the momentum. Right of the edge nothing is changed.
#[test]
fn a_start_on_an_edge_is_on_the_face_of_its_momentum() {
    for (surface, y) in [(Saddled { slope: 0.7 }, 0.0_f64), (Saddled { slope: 0.7 }, 0.3)] {
        let (scene, fall) = (Scene::on(surface), 0.2 * y * y);
        let slide = |vx: f64, vy: f64| [vx, vy, -0.7 * vx.abs() - 0.4 * y * vy];
        let left = State::at([0.0, y, -fall]).moving(slide(-0.5, 0.2));
        let error = scene.simulate(left.clone(), Rattle::new(0.01)).unwrap_err().to_string();
        assert!(error.contains("on an edge, where `x` changes its sign"), "{error}");
        let start = scene.project(&left).unwrap();
        let (q, p) = (start.positions().next().unwrap(), start.momenta().next().unwrap());
        assert!(q.x < 0.0 && q.x > -1e-12 && distance(q, [0.0, y, -fall]) < 1e-12, "{q}");
        assert!(distance(p, slide(-0.5, 0.2)) < 1e-12, "{p}");
        assert_eq!(scene.project(&start).unwrap(), start, "what is on its face stays there");
        let mut simulation = scene.simulate(start, Rattle::new(1e-3)).unwrap();
        simulation.run(100).unwrap();
        assert!(simulation.position().x < -0.04 && simulation.energy_error().abs() < 1e-8);

        let right = State::at([0.0, y, -fall]).moving(slide(0.5, 0.2));
        let same = scene.project(&right).unwrap();
        assert_eq!(same.positions().next().unwrap(), right.positions().next().unwrap());
        scene.simulate(right, Rattle::new(1e-3)).unwrap().run(100).unwrap();
    }
    // Towards the edge along the right face: on that face, and over the edge in the first step.
    let scene = Scene::on(Roof { slope: 0.5 });
    let across = State::at([0.0; 3]).moving([-1.0, 0.2, 0.5]);
    assert_eq!(scene.project(&across).unwrap(), across);
    for y in [0.3, 0.0, -2.0] {
        let start = || State::at([0.0, y, 0.0]).moving([-1.0, 0.2, 0.5]);
        let text = scene.simulate(start(), Rattle::new(0.01)).unwrap().step().unwrap_err().to_string();
        assert!(text.contains("let `over_kinks`") && !text.contains("begin beside it"), "{text}");
        let mut over = scene.simulate(start(), Rattle::new(0.01)).unwrap().over_kinks().unwrap();
        over.run(10).unwrap();
        assert!(distance(over.position(), [-0.1, y + 0.02, -0.05]) < 1e-14, "{}", over.position());
        assert!(over.events() == 1 && over.energy_error().abs() < 1e-15);
    }
    // Who creeps does not decide how far another goes beyond the edge.
    let two = Scene::on(Roof { slope: 0.5 }).bodies(2);
    let start = State::of([[0.053, 0.0, -0.0265], [1.0, 0.0, -0.5]]);
    let fast = [-1.0, 0.2, 0.5];
    let start = start.with_momenta([fast, fast.map(|p| 1e-16 * p)]);
    let alone = Scene::on(Roof { slope: 0.5 });
    let of_one = State::at([0.053, 0.0, -0.0265]).moving(fast);
    let mut one = alone.simulate(of_one, Rattle::new(0.01)).unwrap().over_kinks().unwrap();
    let mut both = two.simulate(start, Rattle::new(0.01)).unwrap().over_kinks().unwrap();
    one.run(10).unwrap();
    both.run(10).unwrap();
    let off = (both.positions().next().unwrap() - one.position()).norm();
    assert!(off < 1e-14 && both.events() == 1 && both.energy_error().abs() < 1e-14, "{off:e}");
    // To neither: that of the left face, to which less is normal.
    let near = scene.project(&State::at([0.0; 3]).moving([-1.0, 0.2, -0.4])).unwrap();
    let p = near.momenta().next().unwrap();
    assert!((p.z - 0.5 * p.x).abs() < 1e-15 && distance(p, [-1.0, 0.2, -0.4]) < 0.1, "{p}");
}

/// A place exactly on an edge belongs to one side, wherever it lies in a step: half way, at an end, or within a
/// rounding of one.
#[test]
fn an_edge_that_is_met_exactly() {
    let scene = Scene::on(Roof { slope: 0.5 });
    let h = 1.0 / 128.0;
    for way in [-1.0_f64, 1.0] {
        for part in [0.5, 0.25, 0.375, 1.0, 1.0 - 1.0 / 1024.0, 0.3] {
            let start = || {
                let x = -way * part * h;
                State::at([x, 0.0, -0.5 * x.abs()]).moving([way, 0.25, 0.5])
            };
            let told = scene.simulate(start(), Rattle::new(h)).unwrap().run(2).unwrap_err();
            let (step, argument, share, angle) = kink(told);
            let there = if way > 0.0 || part < 1.0 { (1, part) } else { (2, 0.0) };
            assert!(
                step == there.0 && argument == "x" && (share - there.1).abs() < 1e-5,
                "{part} {step} {share}"
            );
            assert!((angle - 2.0 * 0.5_f64.atan().to_degrees()).abs() < 1e-3);
            let mut over = scene.simulate(start(), Rattle::new(h)).unwrap().over_kinks().unwrap();
            over.run(4).unwrap();
            let x = way * (4.0 - part) * h;
            assert!(distance(over.position(), [x, h, -0.5 * x.abs()]) < 1e-15, "{part} {}", over.position());
            assert!(over.events() == 1 && over.energy_error().abs() < 1e-15);
        }
    }
    // The fifth step ends before the edge by less than a rounding of its length.
    let start = State::at([0.05, 0.0, -0.025]).moving([-1.0, 0.2, 0.5]);
    let mut over = scene.simulate(start, Rattle::new(0.01)).unwrap().over_kinks().unwrap();
    over.run(5).unwrap();
    assert!(over.position().x > 0.0 && over.events() == 0);
    over.run(5).unwrap();
    assert!(distance(over.position(), [-0.05, 0.02, -0.025]) < 1e-15 && over.events() == 1);
}

constraint! {
    /// A valley.
    struct Vee {}
    |x, y| y - abs(x)
}

/// A step that would end on an edge, to the bit or nearly, names it.
#[test]
fn steps_that_end_on_an_edge_name_it() {
    let scene = Scene::on(Vee {}).with(rattle::potentials::planar::Gravity { g: 1.0 });
    for h in [0.1, 0.2, 0.13] {
        for at in [1.0, 1.01] {
            let error = scene.simulate(State::at([-at, at]), Rattle::new(h)).unwrap().run(80).unwrap_err();
            assert_eq!(kink(error).1, "x", "{h} {at}");
        }
    }
}
