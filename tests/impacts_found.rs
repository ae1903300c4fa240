//! Impacts that are hard to find: of gaps that are rounded much more coarsely than places are, behind a near miss
//! within one step, and in steps that are taken in parts.

use rattle::effect::{Contacts, DryFriction, Gradient, HardSpheres, LinearDrag, Stop};
use rattle::error::StepFailure;
use rattle::potentials::Gravity;
use rattle::prelude::*;
use rattle::surfaces::{Plane, Sphere};
use rattle::system::System;
use rattle::{Counted, Error, Geodesic};

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

/// A step of one stage that is taken in parts is as long as all of them: two beads go once round the other side of a
/// circle in it, and a third up through a ceiling and down again.
#[test]
fn steps_that_are_taken_in_parts_are_looked_at() {
    let sphere = Scene::on(Sphere { r: 1.0 });
    let beads = sphere.bodies(2);
    let at = |a: f64, v: f64| ([a.cos(), a.sin(), 0.0], [-a.sin() * v, a.cos() * v, 0.0]);
    let [(q, p), (r, s)] = [at(0.0, 1.0), at(1.0, -1.0)];
    let start = || State::of([q, r]).with_momenta([p, s]);
    let run = |h: f64, halvings: u32, steps: u64| {
        let beads = beads.simulate(start(), Rattle::new(h)).unwrap().retry(halvings);
        let mut beads = beads.collide(HardSpheres::new(0.1)).unwrap();
        beads.run(steps).unwrap();
        beads.events()
    };
    assert_eq!([run(0.05, 0, 38), run(1.9, 1, 1), run(1.9, 6, 1)], [1; 3]);

    fn below() -> impl Contacts<3> {
        Stop::below(Plane { a: 0.0, b: 0.0, c: 1.0, d: 0.9 })
    }
    let up = || State::at([1.0, 0.0, 0.0]).moving([0.0, 0.0, 1.0]);
    fn events<S: Method>(bead: Result<Simulation<impl System<f64, 3>, S, 3>, Error>) -> u64 {
        let mut bead = bead.unwrap().retry(6).collide(below()).unwrap();
        bead.step().unwrap();
        let z = bead.positions().next().unwrap().z;
        assert!(z <= 0.9 + 1e-14, "{z}");
        bead.events()
    }
    let mut short = sphere.simulate(up(), Rattle::new(0.055)).unwrap().collide(below()).unwrap();
    short.run(100).unwrap();
    assert_eq!(short.events(), 1);
    assert_eq!(events(sphere.simulate(up(), Rattle::new(5.5))), 1);
    assert_eq!(events(sphere.simulate(up(), Geodesic::new(2, 5.5))), 1);
    assert_eq!(events(sphere.simulate(up(), Composition::new(SUZUKI_1990_ORDER_4, 5.5))), 1);
    let checked = sphere.simulate(up(), Rattle::new(5.5)).unwrap().check_reversal(1e-13);
    assert_eq!(events(checked), 1);
}

/// What friction holds on a slope goes nowhere, and nothing is looked for in parts of its steps; nor where a `force!`
/// holds a weight, or drag its speed.
#[test]
fn looking_at_what_is_held_costs_no_parts() {
    force! {
        /// Up, against the weight.
        struct Lift { f }
        |_q: [f64; 3], _v: [f64; 3]| [0, 0, f]
    }
    let slope = Plane { a: 0.5, b: 0.0, c: 0.75_f64.sqrt(), d: 0.0 };
    let far = || Stop::above(Plane { a: 1.0, b: 0.0, c: 0.0, d: -1e4 });
    macro_rules! cost {
        ($scene:expr, $start:expr, $method:expr) => {{
            let mut weights = Vec::new();
            for walled in [false, true] {
                let weight = Counted::new(Gravity { g: 9.81 });
                let counts = weight.counts();
                let mut run = $scene(weight).simulate($start, $method).unwrap();
                if walled {
                    run = run.collide(far()).unwrap();
                }
                counts.reset();
                run.run(20).unwrap();
                weights.push(counts.gradients());
            }
            let [free, walled] = weights[..] else { panic!("{weights:?}") };
            assert!(walled <= 3 * free + 20, "{}: {walled} for {free}", $method.name());
        }};
    }
    macro_rules! all {
        ($method:expr) => {
            let friction = |weight| Scene::on(slope).with(weight).with(DryFriction { coefficient: 0.6 });
            cost!(friction, State::at([0.0; 3]), $method);
            cost!(friction, State::at([30.0 * slope.c, 2.0, -15.0]), $method);
            let lift = |weight| Scene::point().with(weight).with(Lift { f: 9.81 });
            cost!(lift, State::at([0.0; 3]), $method);
            cost!(lift, State::at([0.3, 0.2, 0.1]), $method);
            let drag = |weight| Scene::point().with(weight).with(LinearDrag::new(10.0));
            cost!(drag, State::at([0.0; 3]).moving([0.0, 0.0, -0.981]), $method);
        };
    }
    all!(Lobatto::<3>::new(0.05));
    all!(Geodesic::new(3, 0.05));
    all!(PositionVerlet::new(0.05));
    all!(Composition::new(SUZUKI_1990_ORDER_4, 0.05));
}

/// A step that is divided because it does not lead back is looked at in the parts in which it went, and no finer.
#[test]
fn looking_at_parts_that_do_not_lead_back_ends() {
    let weight = Counted::new(Gravity { g: 1.0 });
    let counts = weight.counts();
    let scene = Scene::on(Sphere { r: 1.0 }).with(weight);
    let bead = scene.simulate(State::at([1.0, 0.0, 0.0]).moving([0.0, 0.6, 0.8]), Rattle::new(0.7)).unwrap();
    // No way leads back to a thousandth of a rounding.
    let bead = bead.retry(6).check_reversal(1e-19).unwrap();
    let mut bead = bead.collide(Stop::above(Plane { a: 1.0, b: 0.0, c: 0.0, d: -10.0 })).unwrap();
    counts.reset();
    let error = bead.step().unwrap_err();
    assert!(matches!(error, Error::NotReversed { .. }), "{error}");
    assert!(counts.gradients() < 8 * 128, "{}", counts.gradients());
}

constraint! {
    /// A roof that hardly falls.
    struct Flat {}
    |x, _y, z| z + 0.1 * abs(x)
}
potential! {
    /// No body comes near the ridge.
    struct Barrier {}
    |x, _y, _z| 0.1 / x^2
}

/// A long step goes over a ridge that shorter ones turn back from: it is divided, whether or not something may collide.
#[test]
fn a_step_over_a_kink_is_divided_beside_contacts() {
    let scene = Scene::on(Flat {}).with(Barrier {});
    let run = || {
        let start = State::at([-1.0, 0.0, -0.1]).moving([1.0, 0.0, 0.1]);
        scene.simulate(start, Rattle::new(2.0)).unwrap().retry(6)
    };
    let mut free = run();
    free.run(10).unwrap();
    let far = Plane { a: 0.0, b: 0.0, c: 1.0, d: -1e3 };
    let mut walled = run().collide(Stop::above(far)).unwrap();
    walled.run(10).unwrap();
    assert_eq!((walled.position(), walled.momentum()), (free.position(), free.momentum()));
    assert!(free.position().x < 0.0);
}

/// What was not halved is not told as if it had been.
#[test]
fn what_comes_to_rest_was_not_halved() {
    let floor = Plane { a: 0.0, b: 0.0, c: 1.0, d: 0.0 };
    let scene = Scene::point().with(Gravity { g: 1.0 });
    let lying = scene.simulate(State::at([0.0; 3]), Rattle::new(0.1)).unwrap().retry(6);
    let error = lying.collide(Stop::above(floor)).unwrap().step().unwrap_err();
    assert!(matches!(error, Error::Step { cause: StepFailure::Rests { .. }, .. }), "{error}");

    // What was is, beside contacts as alone.
    let start = State::at([-1.0, 0.0, -0.1]).moving([1.0, 0.0, 0.1]);
    let run = || Scene::on(Flat {}).simulate(start.clone(), Rattle::new(0.3)).unwrap().retry(3);
    let error = run().run(9).unwrap_err();
    let beside = run().collide(Stop::above(Plane { d: -9.0, ..floor })).unwrap().run(9).unwrap_err();
    assert!(matches!(error, Error::Retried { halvings: 3, .. }), "{error}");
    assert_eq!(error, beside);
}

constraint! {
    /// A sphere that grows.
    struct Growing {}
    |x, y, z, t| x^2 + y^2 + z^2 - (1 + t)^2
}
constraint! {
    /// A table that rises.
    struct Rising {}
    |_x, _y, z, t| z - t
}

/// A body that a sphere takes along, as that grows, meets a ball around it: it cannot part, wherever it is. What
/// rounding leaves of a direction in which it could is none.
#[test]
fn what_cannot_part_from_a_curved_wall_is_told() {
    let scene = Scene::points(1).link_moving(Growing {}, [[0]]);
    for number in 0..200 {
        let (height, angle) = ((f64::from(number) + 0.5) / 100.0 - 1.0, 2.4 * f64::from(number));
        let (flat, [sin, cos]) = ((1.0 - height * height).sqrt(), [angle.sin(), angle.cos()]);
        let (q, along) = ([flat * cos, flat * sin, height], [-sin, cos, 0.0]);
        let v: [f64; 3] = std::array::from_fn(|i| q[i] + 0.3 * along[i]);
        let start = scene.project(&State::at(q).moving(v)).unwrap();
        let run = scene.simulate(start, Rattle::new(0.1)).unwrap().retry(3);
        let mut run = run.collide(Stop::below(Sphere { r: 1.45 })).unwrap();
        let error = run.run(8).unwrap_err();
        assert!(
            matches!(&error, Error::Step { cause: StepFailure::NoWayApart { .. }, .. }),
            "{number}: {error}"
        );
        assert_eq!((run.steps(), run.events()), (4, 0), "{number}");
    }
    // One that gives way a little parts, with the speed at which it met: 1 along the normal of a wall that is askew.
    for askew in [1e-1_f64, 1e-3, 1e-5, 1e-6] {
        let scene = Scene::points(1).link_moving(Rising {}, [[0]]);
        let run = scene.simulate(State::at([0.0; 3]).moving([0.0, 0.0, 1.0]), Rattle::new(0.1)).unwrap();
        let ceiling = Plane { a: askew.sin(), b: 0.0, c: askew.cos(), d: 0.45 * askew.cos() };
        let mut run = run.collide(Stop::below(ceiling)).unwrap();
        run.run(5).unwrap();
        let v = run.momenta().next().unwrap();
        // a v + c = −c
        let exact = -2.0 * askew.cos() / askew.sin();
        assert!((v.x / exact - 1.0).abs() < 1e-3 && v.y == 0.0 && (v.z - 1.0).abs() < 1e-12, "{askew}: {v}");
    }
}

/// A gap that is no number, and tells no bodies.
#[derive(Debug)]
struct Lost;

impl Contacts<3> for Lost {
    fn name(&self) -> &'static str {
        "Lost"
    }
    fn restitution(&self) -> f64 {
        1.0
    }
    fn check(&self, _: usize) -> Result<(), Error> {
        Ok(())
    }
    fn near(&self, _: &[[f64; 3]], _: f64, _: &mut Vec<usize>, found: &mut Vec<usize>) {
        found.push(0);
    }
    fn gap(&self, _: usize, q: &[[f64; 3]], gradient: &mut Gradient<3>) -> f64 {
        if q[0][2] < 0.0 {
            return f64::NAN;
        }
        gradient.push((0, [0.0, 0.0, 1.0]));
        1.0 + q[0][2]
    }
}

#[test]
fn a_gap_that_is_no_number_is_told() {
    let ball =
        Scene::point().simulate(State::at([0.0, 0.0, 0.25]).moving([0.0, 0.0, -1.0]), Rattle::new(0.1));
    let mut ball = ball.unwrap().collide(Lost).unwrap();
    let error = ball.run(9).unwrap_err();
    let cause =
        |error: &Error| matches!(error, Error::Step { cause: StepFailure::ConstraintNotFinite { .. }, .. });
    assert!(cause(&error) && ball.steps() == 2, "{error}");
}
