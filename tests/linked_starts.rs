//! How far a start of linked bodies may be off: taken at 0.99 of tolerances that are written out by hand, refused at
//! 1.01.

use rattle::error::StartFailure;
use rattle::links::Rod;
use rattle::network::LinearAlgebra;
use rattle::prelude::*;
use rattle::{Error, START_TOLERANCE};

constraint! {
    /// A rod whose length grows, and whose equation has any scale.
    struct Growing { length, rate, scale }
    |a: [f64; 3], b: [f64; 3], t| scale * (dot(b - a, b - a) - (length + rate * t)^2)
}

constraint! {
    /// A circle that is led along x, and whose equation has any scale.
    struct Led { scale, speed }
    |x, y, t| scale * ((x - speed * t)^2 + y^2 - 1)
}

/// The end of a start that is off by this part of what is tolerated.
fn check(what: &str, refused: impl Fn(&StartFailure) -> bool, start: impl Fn(f64) -> Result<(), Error>) {
    for part in [0.99, -0.99] {
        assert!(start(part).is_ok(), "{what}, {part}: {:?}", start(part));
    }
    for part in [1.01, -1.01] {
        let end = start(part);
        let told = matches!(&end, Err(Error::Start { cause, .. }) if refused(cause));
        assert!(told, "{what}, {part}: {end:?}");
    }
}

/// |g|/|∇g| of a rod of length L that is d too long is d/√2 with two ends that can move, and d with one. It has no
/// normal where its ends meet: L/√2 away, by how the normals of both ends turn.
#[test]
fn places() {
    let off = |cause: &StartFailure| matches!(cause, StartFailure::OffConstraint { .. });
    for (length, scale) in [(1.0, 1.0), (1.0, 1e-30), (0.01, 1e20)] {
        let link = Growing { length, rate: 0.0, scale };
        let both = |part: f64| {
            let end = 3.0 * length + length * (1.0 + part * START_TOLERANCE);
            let start = State::of([[0.0, 3.0 * length, 0.0], [0.0, end, 0.0]]);
            Scene::points(2).link_moving(link, [[0, 1]]).simulate(start, Rattle::new(0.01)).map(drop)
        };
        check("two ends", off, both);
        let one = |part: f64| {
            let end = length * (1.0 + part * START_TOLERANCE / 2.0_f64.sqrt());
            let start = State::of([[0.0; 3], [end, 0.0, 0.0]]);
            let scene = Scene::points(2).link_moving(link, [[0, 1]]).pin(0, [0.0; 3]);
            scene.simulate(start, Rattle::new(0.01)).map(drop)
        };
        check("one end", off, one);
    }
}

/// The sine of the angle to the constraint; of links that move, the rate that is left by all that could cancel it.
#[test]
fn momenta() {
    let not_along = |cause: &StartFailure| matches!(cause, StartFailure::NotAlong { .. });
    for scale in [1.0, 1e-30, 1e20] {
        let start = |rate: f64, momentum: [f64; 3]| {
            let start = State::of([[0.0; 3], [2.0, 0.0, 0.0]]).with_momenta([[0.0; 3], momentum]);
            let link = Growing { length: 2.0, rate, scale };
            let scene = Scene::points(2).link_moving(link, [[0, 1]]).pin(0, [0.0; 3]);
            scene.simulate(start, Rattle::new(0.01)).map(drop)
        };
        check("at rest", not_along, |part| start(0.0, [3.0 * part * START_TOLERANCE, 3.0, 0.0]));
        check("growing", not_along, |part| {
            start(5.0, [5.0 * (1.0 + 2.0 * part * START_TOLERANCE), 0.0, 0.0])
        });
    }
}

/// A pinned body may be off its pin by a part of the largest coordinate of all, be it of the pin or of another body.
#[test]
fn pins() {
    let pinned = |cause: &StartFailure| matches!(cause, StartFailure::Pinned { .. });
    for (pin, other) in [(5.0, 0.0), (5.0, 100.0)] {
        let largest = f64::max(pin, other);
        check("a pin", pinned, |part| {
            let start = State::of([[pin + part * START_TOLERANCE * largest, 0.0, 0.0], [0.0, other, 0.0]]);
            Scene::points(2).pin(0, [pin, 0.0, 0.0]).simulate(start, Rattle::new(0.01)).map(drop)
        });
    }
    // A link between two pins holds, or not: as between two ends that can move, by its length if that is less than
    // coordinates are.
    let off = |cause: &StartFailure| matches!(cause, StartFailure::BetweenPins { .. });
    for (from, length) in [(0.0, 4.0), (4e3, 4.0), (1.0, 1e-2)] {
        check("between pins", off, |part| {
            let end = [0.0, from + length + length * part * START_TOLERANCE, 0.0];
            let scene = Scene::points(3).link(Rod { length }, [[0, 1]]).pin(0, [0.0, from, 0.0]).pin(1, end);
            scene.simulate(State::of([[0.0, from, 0.0], end, [1.0, 0.0, 0.0]]), Rattle::new(0.01)).map(drop)
        });
    }
}

/// What is pinned is put onto its pin: an equation must hold there, and not where a state has it within what is
/// tolerated beside bodies that are far away.
#[test]
fn equations_hold_at_the_pins() {
    let scene = Scene::points(3).link(Rod { length: 1.0 }, [[0, 1]]).pin(0, [0.0; 3]);
    let start = |off: f64, end: f64| State::of([[0.0, 0.0, off], [0.0, 0.0, end], [1e6, 0.0, 0.0]]);
    let off = |start| match scene.simulate(start, Rattle::new(0.01)).map(drop).unwrap_err() {
        Error::Start { cause: StartFailure::OffConstraint { distance, .. }, .. } => distance,
        other => panic!("{other}"),
    };
    let distance = off(start(9e-5, -1.0 + 9e-5));
    assert!((distance - 9e-5).abs() < 1e-8, "{distance:e}");
    let simulation = scene.simulate(start(9e-5, -1.0), Rattle::new(0.01)).unwrap();
    assert!(simulation.constraint_residual() < 1e-15);
    // Between two pins too.
    let scene = Scene::points(3).link(Rod { length: 1.0 }, [[0, 1]]).pin(0, [0.0; 3]).pin(1, [1.0, 0.0, 0.0]);
    let start = |off: f64, end: f64| State::of([[off, 0.0, 0.0], [end, 0.0, 0.0], [1e6, 0.0, 0.0]]);
    assert!(scene.simulate(start(9e-5, 1.0), Rattle::new(0.01)).is_ok());
    let scene =
        Scene::points(3).link(Rod { length: 1.0 }, [[0, 1]]).pin(0, [0.0; 3]).pin(1, [1.0 - 1e-5, 0.0, 0.0]);
    let refused = scene.simulate(start(8e-5, 1.0 + 8e-5), Rattle::new(0.01)).map(drop);
    assert!(
        matches!(refused, Err(Error::Start { cause: StartFailure::BetweenPins { .. }, .. })),
        "{refused:?}"
    );
}

/// How far it is to where a normal is none does not depend on the unit of time, nor on that of g.
#[test]
fn links_that_move_in_any_unit() {
    let off = |cause: &StartFailure| matches!(cause, StartFailure::OffConstraint { .. });
    for (speed, scale) in [(1.0, 1.0), (100.0, 1.0), (3e10, 1.0), (1e-10, 1.0), (1.0, 1e12), (1.0, 1e-12)] {
        let scene = Scene::point().link_moving(Led { speed, scale }, [[0]]);
        let start = |part: f64| {
            // Off by d, with a normal of the length 2 (1 + d).
            let start = State::at([0.0, -1.0 - part * START_TOLERANCE]).moving([speed, 0.0]);
            scene.simulate(start, Rattle::new(1e-3 / speed)).map(drop)
        };
        check("led", off, start);
        let mut simulation =
            scene.simulate(State::at([0.0, -1.0]).moving([speed, 0.0]), Rattle::new(1e-3 / speed)).unwrap();
        simulation.run(10).unwrap();
        let way = simulation.position().x;
        assert!((way - 0.01).abs() < 1e-15, "at rest on the circle: {way}");
    }
}

/// A beam of triangles in the plane, and the same with one rod too many, from end to end or across a field.
#[test]
fn one_rod_too_many_in_a_long_beam() {
    let beam = |bays: usize, extra: Option<[usize; 2]>, algebra: LinearAlgebra| {
        let place = |k: usize| {
            let [x, y, w] = [k / 2, k % 2, k].map(|k| k as f64);
            [x + 0.05 * (7.0 * w).sin(), y + 0.05 * (5.0 * w).cos()]
        };
        let q: Vec<_> = (0..2 * bays).map(place).collect();
        let uprights = (0..bays).map(|i| [2 * i, 2 * i + 1]);
        let fields =
            (0..bays - 1).flat_map(|i| [[2 * i, 2 * i + 2], [2 * i + 1, 2 * i + 3], [2 * i, 2 * i + 3]]);
        let length = |[a, b]: [usize; 2]| (q[a][0] - q[b][0]).hypot(q[a][1] - q[b][1]);
        let rods: Vec<_> = uprights
            .chain(fields)
            .chain(extra)
            .map(|ends| (rattle::links::planar::Rod { length: length(ends) }, ends))
            .collect();
        let scene = Scene::points::<2>(2 * bays).linear_algebra(algebra).link_each(rods);
        let turning = q.iter().map(|q| [-q[1], q[0]]);
        let start = scene.project(&State::of(q.clone()).with_momenta(turning))?;
        scene.simulate(start, Rattle::new(0.01)).map(|simulation| simulation.freedom())
    };
    for (bays, algebra) in [
        (20, LinearAlgebra::Elimination),
        (21, LinearAlgebra::Elimination),
        (150, LinearAlgebra::Elimination),
        (260, LinearAlgebra::Automatic),
        (277, LinearAlgebra::Automatic),
    ] {
        assert_eq!(beam(bays, None, algebra).unwrap(), 3, "{bays}");
        for extra in [[0, 2 * bays - 2], [bays / 2 * 2 + 1, bays / 2 * 2 + 2]] {
            let error = beam(bays, Some(extra), algebra).unwrap_err();
            let Error::Start { cause: StartFailure::Dependent { sine, .. }, .. } = &error else {
                panic!("{bays} {extra:?}: {error}")
            };
            assert!(*sine < 1e-7, "{bays} {extra:?}: {error}");
        }
    }
}
