//! Kinks and methods that disregard the constraint inside a step, and are projected onto it at its end: from beyond a
//! ridge of 90° or less Newton's iteration goes to and fro and ends on the ridge itself, from where bodies slid along.
//!
//! | roof | by | expected |
//! |---|---|---|
//! | flat | DOP853, Taylor, with a tolerance and without; retried; in lanes; as a link | the step across is an error |
//! | flat, cube | the same, `over_kinks` | straight lines on the faces laid out in a plane |
//! | curved, under gravity | the same, `over_kinks` | as by another method, to the order of the method |

use crate::common::*;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::error::StepFailure;
use rattle::prelude::*;

constraint! {
    struct Roof { slope }
    |x, _y, z| z + slope * abs(x)
}
constraint! {
    struct Cube { r }
    |x, y, z| max(abs(x), abs(y), abs(z)) - r
}
constraint! {
    /// Two curved sides.
    struct Tent { slope, bend }
    |x, y, z| z + slope * abs(x) + bend * (x^2 + y^2 + 0.3 * x * y)
}

/// Steps of 1/100 from the left of a ridge of 53°, which is at 47 and a seventh of them.
fn start() -> State<3> {
    State::at([-0.33, 0.0, -0.66]).moving([0.7, 0.37, 1.4])
}

fn told(error: Option<&rattle::Error>, name: &str) {
    let Some(rattle::Error::Step { step, cause, .. } | rattle::Error::Retried { step, cause, .. }) = error
    else {
        panic!("{name}: {error:?}")
    };
    let StepFailure::Kink { argument: "x", share, angle, .. } = cause else { panic!("{name}: {cause}") };
    let straight = 2.0 * 2.0_f64.atan();
    assert!(*step == 48 && (angle - straight).abs() < 1e-9, "{name}: step {step}, {}", angle.to_degrees());
    assert!(
        matches!(error, Some(rattle::Error::Retried { .. })) || (share - 1.0 / 7.0).abs() < 1e-5,
        "{share}"
    );
}

fn refused_by<M: Method + Copy>(method: M) {
    let (scene, name) = (Scene::on(Roof { slope: 2.0 }), method.name());
    let mut alone = scene.simulate(start(), method).unwrap();
    told(alone.run(100).err().as_ref(), name);
    assert!(alone.steps() == 47 && (alone.position().x + 1e-3).abs() < 1e-12, "{name}: {}", alone.position());
    let mut retried = scene.simulate(start(), method).unwrap().retry(6);
    told(retried.run(100).err().as_ref(), name);
    let mut ensemble = scene.ensemble(vec![start(); 3], method).unwrap();
    ensemble.run(100);
    for i in 0..3 {
        told(ensemble.failure(i), name);
        assert!((ensemble.state(i).positions().next().unwrap().x + 1e-3).abs() < 1e-12, "{name}");
    }
    let linked = Scene::points(1).link(Roof { slope: 2.0 }, [[0]]);
    told(linked.simulate(start(), method).unwrap().run(100).err().as_ref(), name);
}

#[test]
fn the_step_onto_a_sharp_ridge_is_an_error() {
    refused_by(Rattle::new(0.01));
    refused_by(Dop853::new(0.01));
    refused_by(Dop853::adaptive(0.01, 1e-10));
    refused_by(Taylor::new(6, 0.01));
    refused_by(Taylor::adaptive(10, 0.01, 1e-10));
}

/// On the faces laid out in a plane the way is straight.
fn straight_by<M: Method>(method: impl Fn(f64) -> M) {
    let mut random = StdRng::seed_from_u64(5);
    for _ in 0..60 {
        let slope = random.random_range(0.1..3.0);
        let (x, v) =
            (-random.random_range(0.2..0.6), [random.random_range(0.3..1.5), random.random_range(-1.0..1.0)]);
        let start = State::at([x, 0.0, slope * x]).moving([v[0], v[1], slope * v[0]]);
        let h = [0.01, 0.05, 0.2][random.random_range(0..3)];
        let mut body = Scene::on(Roof { slope }).simulate(start, method(h)).unwrap().over_kinks().unwrap();
        body.run((2.0 / h).round() as u64).unwrap();
        let end = x + 2.0 * v[0];
        let off = distance(body.position(), [end, 2.0 * v[1], -slope * end.abs()]);
        assert!(body.events() == 1 || end < 0.0, "{}", body.method().name());
        assert!(off < 1e-12, "{}, slope {slope}, h = {h}: {off:e}", body.method().name());
    }
}

#[test]
fn over_sharp_ridges_the_way_is_straight() {
    straight_by(Dop853::new);
    straight_by(|h| Dop853::adaptive(h, 1e-10));
    straight_by(|h| Taylor::new(6, h));
    straight_by(|h| Taylor::adaptive(10, h, 1e-10));
}

#[test]
fn round_a_cube_as_by_rattle() {
    fn end(method: impl Method) -> ([f64; 3], u64) {
        let start = State::at([0.2975, -0.2203, 1.0]).moving([-0.6606, -2.0319, 0.0]);
        let h = method.step_size();
        let mut body = Scene::on(Cube { r: 1.0 }).simulate(start, method).unwrap().over_kinks().unwrap();
        body.run((5.0 / h).round() as u64).unwrap();
        (body.position().into(), body.events())
    }
    for h in [0.2, 0.1] {
        let (exact, edges) = end(Rattle::new(h));
        assert!(edges > 4);
        for (found, events) in [end(Dop853::new(h)), end(Dop853::adaptive(h, 1e-9)), end(Taylor::new(5, h))] {
            assert_eq!(events, edges);
            assert!((0..3).all(|d| (found[d] - exact[d]).abs() < 1e-12), "{found:?} {exact:?}");
        }
    }
}

/// A stage beyond the ridge has the rates of the other side: the last step before it would be wrong by h times the jump
/// of the acceleration, 1e-3 here.
#[test]
fn no_stage_is_beyond_the_ridge() {
    fn worst<M: Method>(method: M) -> f64 {
        let mut random = StdRng::seed_from_u64(3);
        let mut worst = 0.0_f64;
        let mut crossed = 0;
        for _ in 0..30 {
            let slope =
                random.random_range(0.1..2.0) * if random.random_range(0.0..1.0) < 0.5 { -1.0 } else { 1.0 };
            let scene = Scene::on(Tent { slope, bend: 0.4 }).with(Gravity { g: -0.5 });
            let at = [-random.random_range(0.2..0.6), random.random_range(-0.3..0.3), 0.0];
            let moving = [random.random_range(0.3..1.0), random.random_range(-1.0..1.0), 0.0];
            let start = scene.project(&State::at(at).moving(moving)).unwrap();
            let mut exact = scene
                .simulate(start.clone(), Taylor::adaptive(20, 0.05, 1e-14))
                .unwrap()
                .over_kinks()
                .unwrap();
            exact.run(20).unwrap();
            let mut body = scene.simulate(start, method.clone()).unwrap().over_kinks().unwrap();
            body.run((1.0 / method.step_size()).round() as u64).unwrap();
            assert_eq!(body.events(), exact.events());
            crossed += body.events();
            worst = worst.max((body.position() - exact.position()).norm());
        }
        assert!(crossed > 10);
        worst
    }
    let found = [0.1, 0.05].map(|h| worst(Dop853::new(h)));
    println!("{found:?} {:e}", worst(Taylor::new(8, 0.05)));
    assert!(found[0] < 1e-7 && found[1] < 1e-8, "{found:?}");
    assert!(worst(Taylor::new(8, 0.05)) < 1e-9);
}

constraint! {
    /// A ridge with a radius of some 10⁻⁸.
    struct Rounded { slope, radius }
    |x, _y, z| z + slope * sqrt(x^2 + radius^2)
}

/// No stage and no term of a series knows of a rounded edge that the step passes over: one in thirty went on beyond
/// with another energy, 27 % less of it at worst.
fn never_over_a_rounded_edge<M: Method + Copy>(method: impl Fn(f64) -> M) {
    let (mut random, mut ended, mut went) = (StdRng::seed_from_u64(8), 0, 0);
    for _ in 0..150 {
        let (slope, x) = (random.random_range(0.3..3.0), -random.random_range(0.2..0.6));
        let v = [random.random_range(0.3..1.5), random.random_range(-1.0..1.0), 0.0];
        let method = method([0.01, 0.05, 0.2][random.random_range(0..3)]);
        let (h, steps) = (method.step_size(), (1.0 / method.step_size()).round() as u64);
        for radius in [1e-6, 1e-8, 1e-10] {
            let scene = Scene::on(Rounded { slope, radius });
            let start = scene.project(&State::at([x, 0.0, slope * x]).moving(v)).unwrap();
            let energy = |state: &State<3>| state.momenta().next().unwrap().norm_squared() / 2.0;
            let mut alone = scene.simulate(start.clone(), method).unwrap();
            let mut lanes = scene.ensemble([start.clone()], method).unwrap();
            lanes.run(steps);
            let alone = alone.run(steps).ok().map(|()| energy(&alone.state()));
            let lane = lanes.failure(0).is_none().then(|| energy(&lanes.state(0)));
            let linked = Scene::points(1).link(Rounded { slope, radius }, [[0]]);
            let mut links = linked.ensemble([start.clone()], method).unwrap();
            links.run(steps);
            let link = links.failure(0).is_none().then(|| energy(&links.state(0)));
            for end in [alone, lane, link] {
                let Some(end) = end else {
                    ended += 1;
                    continue;
                };
                went += 1;
                let off = (end / energy(&start) - 1.0).abs();
                assert!(off < 1e-5, "{}, slope {slope}, radius {radius}, h = {h}: {off:e}", method.name());
            }
        }
    }
    println!("{ended} ended, {went} went on");
    assert!(ended > 100 && went > 50, "{ended} ended, {went} went on");
}

#[test]
fn rounded_edges_are_not_passed_over() {
    never_over_a_rounded_edge(|h| Dop853::adaptive(h, 1e-8));
    never_over_a_rounded_edge(|h| Taylor::adaptive(10, h, 1e-8));
}

/// A step past a corner passes two edges, behind the first of which nothing of the second is seen at its ends.
#[test]
fn an_edge_before_a_corner_is_told() {
    let scene = Scene::on(Cube { r: 1.0 });
    let start = || State::at([1.0, 0.966, 0.985]).moving([0.0, 0.83, 0.56]);
    let told = |error: &rattle::Error| match error {
        rattle::Error::Step { cause: StepFailure::Kink { share, position, .. }, .. } => {
            // z = 1 after 0.015/0.56 of time, on the way to y = 1 after 0.034/0.83.
            assert!((share - 0.015 / 0.56 / 0.3).abs() < 1e-5 && (position[2] - 1.0).abs() < 1e-5, "{error}");
        }
        other => panic!("{other}"),
    };
    told(&scene.simulate(start(), Rattle::new(0.3)).unwrap().run(1).unwrap_err());
    told(&scene.simulate(start(), Lobatto::<3>::new(0.3)).unwrap().run(1).unwrap_err());
    let mut ensemble = scene.ensemble(vec![start(); 3], Rattle::new(0.3)).unwrap();
    ensemble.run(1);
    told(ensemble.failure(2).unwrap());
    let mut ensemble = scene.ensemble(vec![start(); 3], Lobatto::<3>::new(0.3)).unwrap();
    ensemble.run(1);
    told(ensemble.failure(2).unwrap());
}
