//! Far along an axis that a constraint does not know: what its coordinate is rounded by is no measure of anything
//! across. A solve that took it for one ended 2e-8 off a cylinder at z = 1e8.

use rattle::Error;
use rattle::composition::SUZUKI_1990_ORDER_4;
use rattle::error::StartFailure;
use rattle::nalgebra::Vector3;
use rattle::potentials::Harmonic;
use rattle::prelude::*;

constraint! {
    /// A cylinder around the z axis.
    struct Tube {}
    |x, y, _z| x^2 + y^2 - 1
}

/// A solve ends at eight roundings of what moves a place across; the stages of Lobatto's method, of linked bodies, at
/// twice that.
const MOST: f64 = 18.0 * f64::EPSILON;

/// How far the worst place of a run is off the cylinder.
fn worst<S: Method>(linked: bool, z: f64, method: &S) -> f64 {
    let start = State::at([0.6, 0.8, z]).moving([-0.56, 0.42, 0.3]);
    let spring = Harmonic { stiffness: 1.0, centre: [2.0, 0.0, z] };
    let mut worst = 0.0_f64;
    let mut see = |q: &Vector3<f64>| worst = worst.max((q.x.hypot(q.y) - 1.0).abs());
    let name = method.name();
    if linked {
        let scene = Scene::point().link(Tube {}, [[0]]).with(spring);
        let mut run = scene.simulate(start, method.clone()).unwrap();
        let ended = run.run_with(300, |now| see(&now.position()));
        ended.unwrap_or_else(|error| panic!("{name}: {error}"));
    } else {
        let scene = Scene::on(Tube {}).with(spring);
        let mut run = scene.simulate(start.clone(), method.clone()).unwrap();
        let ended = run.run_with(300, |now| see(&now.position()));
        ended.unwrap_or_else(|error| panic!("{name}: {error}"));
        let mut ensemble = scene.ensemble([start], method.clone()).unwrap();
        ensemble.run(300);
        assert_eq!(ensemble.failure(0), None, "{name}");
        see(&ensemble.state(0).positions().next().unwrap());
    }
    worst
}

#[test]
fn constraints_hold_to_the_rounding_of_what_they_know() {
    fn check<S: Method>(method: S, beyond: &mut Vec<String>) {
        for (linked, z) in [(false, 1e8), (false, 1e12), (true, 1e8), (true, 1e12)] {
            let off = worst(linked, z, &method);
            let (name, h) = (method.name(), method.step_size());
            if off.is_nan() || off >= MOST {
                beyond.push(format!("{name}, h = {h}, linked: {linked}, z = {z:e}: {off:e}"));
            }
        }
    }
    let mut beyond = Vec::new();
    for h in [0.01, 0.1, 0.3] {
        check(Rattle::new(h), &mut beyond);
        check(Rattle::new(h).solved_by(Broyden), &mut beyond);
        check(Composition::new(SUZUKI_1990_ORDER_4, h), &mut beyond);
        check(Lobatto::<3>::new(h), &mut beyond);
        check(Taylor::new(8, h), &mut beyond);
        check(Dop853::new(h), &mut beyond);
        check(Bdf2::new(h), &mut beyond);
    }
    assert!(beyond.is_empty(), "{beyond:#?}");
}

#[test]
fn starts_are_as_near_there_as_elsewhere() {
    for z in [0.0, 1e8, 1e12] {
        let refused = |off: f64| {
            let start = State::at([1.0 + off, 0.0, z]).moving([0.0, 1.0, 0.0]);
            let alone = Scene::on(Tube {}).simulate(start.clone(), Rattle::new(0.01)).err();
            let linked = Scene::point().link(Tube {}, [[0]]).simulate(start, Rattle::new(0.01)).err();
            let of = |error: Option<Error>| {
                error.map(|error| match error {
                    Error::Start { cause, .. } => cause,
                    other => panic!("{other}"),
                })
            };
            [of(alone), of(linked)]
        };
        assert_eq!(refused(0.9e-10), [None, None], "z = {z:e}");
        let [alone, linked] = refused(1.1e-10);
        assert!(matches!(alone, Some(StartFailure::OffSurface { .. })), "z = {z:e}: {alone:?}");
        assert!(matches!(linked, Some(StartFailure::OffConstraint { .. })), "z = {z:e}: {linked:?}");
        let beside = State::at([1.5, 0.0, z]).moving([0.3, 1.0, 0.0]);
        for scene in
            [Scene::on(Tube {}).project(&beside), Scene::point().link(Tube {}, [[0]]).project(&beside)]
        {
            let q = scene.unwrap().positions().next().unwrap();
            assert!((q.x.hypot(q.y) - 1.0).abs() < 4e-16, "z = {z:e}: {q:?}");
        }
    }
}

constraint! {
    /// Tubes around the x axis, one inside the other.
    struct Tubes { k }
    |x, y, z| sin(k * (sqrt(y^2 + z^2) - 1)) + 0 * x
}

constraint! {
    /// The same around the origin.
    struct Rings { k }
    |x, y| sin(k * (sqrt(x^2 + y^2) - 1))
}

/// A step that ends on another tube is refused, also where x is so large that its rounding is as much as tubes are
/// apart; in lanes as well.
#[test]
fn other_sheets_are_told_from_rounding_far_along() {
    for x in [0.0, 1e6, 1e8] {
        let start = State::at([x, 1.0, 0.0]).moving([1.0, 0.0, 1.0]);
        let scene = Scene::on(Tubes { k: 1e5 });
        let told = scene.simulate(start.clone(), Lobatto::<2>::new(0.2)).unwrap().run(200).unwrap_err();
        assert!(told.to_string().contains("beside the sheet"), "x = {x:e}: {told}");
        let mut lanes = scene.ensemble(vec![start; 3], Lobatto::<2>::new(0.2)).unwrap();
        lanes.run(200);
        assert_eq!(lanes.failures().count(), 3, "x = {x:e}");
    }
}

#[test]
fn other_sheets_are_told_from_rounding_in_single_precision() {
    let mut refused = 0;
    for (k, h) in [(300.0, 0.2), (300.0, 0.4), (1e3, 0.2), (1e3, 0.3), (3e3, 0.2), (3e3, 0.3), (1e4, 0.2663)]
    {
        let start = State::at([0.0, 1.0, 0.0]).moving([1.0, 0.0, 1.0]);
        let scene = Scene::on(Tubes { k });
        let mut lanes = scene.ensemble_in(Single, vec![start; 16], Lobatto::<2>::new(h)).unwrap();
        assert_eq!(lanes.plan().in_lanes, 16);
        lanes.run(60);
        let told = lanes.failure(0).map(ToString::to_string).unwrap_or_default();
        refused += usize::from(told.contains("beside the sheet"));
        for i in 0..16 {
            let [_, y, z] = lanes.state(i).positions().next().unwrap().into();
            let off = y.hypot(z) - 1.0; // tubes are 2π/k apart
            assert!(off.abs() < 1e-5 + 1.0 / k, "k = {k}, h = {h}: {off:e}, {told}");
        }
    }
    assert!(refused >= 1, "{refused}");
}

constraint! {
    /// The same, a little tilted.
    struct Tilted { k, by }
    |x, y, z| sin(k * (sqrt(y^2 + z^2) - 1 - by * x))
}

#[test]
fn other_sheets_are_told_from_rounding_where_a_large_coordinate_counts_little() {
    for (x, by) in [(0.0, 0.0), (1e8, 1e-9), (1e8, 1e-12)] {
        let start = State::at([x, 1.0 + by * x, 0.0]).moving([1.0, 0.0, 1.0]);
        let scene = Scene::on(Tilted { k: 1e5, by });
        let start = scene.project(&start).unwrap();
        let told = scene.simulate(start, Lobatto::<2>::new(0.2)).unwrap().run(200).unwrap_err().to_string();
        assert!(told.contains("sheet") || told.contains("turns by more than"), "x = {x:e}: {told}");
    }
}

/// Stages that neither come nearer nor are at rounding: forces so strong that repetition goes round in circles.
#[test]
fn stages_that_stay_as_far_off_are_not_taken() {
    let scene = Scene::on(rattle::surfaces::Plane { a: 0.0, b: 0.0, c: 1.0, d: 1.0 })
        .with(Harmonic { stiffness: 1.0, centre: [0.0, 0.0, 1.0] });
    for amplitude in [1e-13, 1e-11, 1e-9] {
        let start = State::at([amplitude, 0.0, 1.0]);
        for h in [4.82, 4.87] {
            assert!(scene.simulate(start.clone(), Lobatto::<3>::new(h)).unwrap().run(9).is_err(), "h = {h}");
        }
        for h in [7.76, 7.95] {
            assert!(scene.simulate(start.clone(), Lobatto::<5>::new(h)).unwrap().run(9).is_err(), "h = {h}");
        }
    }
}

/// A body that is linked to nothing, however far away, is no measure for others.
#[test]
fn other_sheets_are_told_from_the_rounding_of_others() {
    for x in [0.0, 1e8] {
        let start = State::of([[1.0, 0.0], [x, 3.0]]).with_momenta([[0.0, 1.0], [0.0, 0.0]]);
        let scene = Scene::points(2).link(Rings { k: 1e5 }, [[0]]);
        let told = scene.simulate(start, Lobatto::<2>::new(0.2)).unwrap().run(200).unwrap_err();
        assert!(told.to_string().contains("beside the sheet"), "x = {x:e}: {told}");
    }
}

constraint! {
    /// A ball on the floor.
    struct Ball { r }
    |x, y, z| x^2 + y^2 + (z - r)^2 - r^2
}

constraint! {
    /// A wheel on the floor.
    struct Wheel { r }
    |x, y| x^2 + (y - r)^2 - r^2
}

/// Where coordinates are all small, g is rounded to what it is made of, and that is neither another sheet, nor a solve
/// that does not end.
#[test]
fn what_touches_the_floor_at_the_origin_goes_on() {
    for h in [1e-6, 1e-5, 3e-5, 1e-4, 1e-3] {
        let start = State::at([-30.3 * h, 0.0, 0.0]).moving([1.0, 0.0, 0.0]);
        let scene = Scene::on(Ball { r: 1.0 });
        let start = scene.project(&start).unwrap();
        let linked = Scene::points(2).link(Wheel { r: 1.0 }, [[0]]);
        let pair = State::of([[-30.3 * h, 0.0], [1.0, 0.0]]).with_momenta([[1.0, 0.0], [0.0, 0.0]]);
        let pair = linked.project(&pair).unwrap();
        macro_rules! passes {
            ($method:expr) => {
                let mut run = scene.simulate(start.clone(), $method).unwrap();
                let angle = |q: Vector3<f64>| q.x.atan2(1.0 - q.z); // on a circle of radius 1
                let expected = angle(run.position()) + 60.0 * h * run.momentum().norm();
                run.run(60).unwrap();
                let off = (angle(run.position()) - expected).abs();
                assert!(off < 1e-13 + 60.0 * h.powi(3), "h = {h:e}: {off:e}");
                assert!(run.constraint_residual() < 1e-15, "h = {h:e}");
                linked.simulate(pair.clone(), $method).unwrap().run(60).unwrap();
                let mut lanes = scene.ensemble(vec![start.clone(); 3], $method).unwrap();
                lanes.run(60);
                assert_eq!(lanes.failures().count(), 0, "h = {h:e}");
            };
        }
        passes!(Lobatto::<2>::new(h));
        passes!(Lobatto::<4>::new(h));
        passes!(rattle::Dop853::new(h));
        passes!(rattle::Taylor::new(8, h));
    }
}
