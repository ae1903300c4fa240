//! Brownian motion in lanes: as each trajectory alone but for rounding, with the same random numbers.

use crate::common::{Gravity, Trough, larger};
use rattle::Error;
use rattle::effect::Effects;
use rattle::ensemble::{InstructionSet, NotInLanes};
use rattle::error::{StepFailure, SurfaceFailure};
use rattle::prelude::*;
use rattle::surfaces::{Sphere, Torus};

constraint! {
    /// Spheres of radius 1 + nπ/k.
    struct Shells { k }
    |x, y, z| sin(k * (sqrt(x^2 + y^2 + z^2) - 1))
}

constraint! {
    /// A roof with its ridge along y.
    struct Roof {}
    |x, _y, z| z + abs(x)
}

const RING: Torus = Torus { major: 1.2, minor: 0.5 };

fn method(h: f64) -> Brownian {
    Brownian::new(1.5, 0.4, 9, h)
}

/// From different places, of trajectories with numbers and steps behind them, and without.
fn start(i: u64) -> State<3> {
    let (x, y) = ((0.1 * i as f64).cos(), (0.1 * i as f64).sin());
    let state = State::at([1.7 * x, 1.7 * y, 0.0]).moving([-y, x, 0.3]);
    match i % 3 {
        0 => state.numbered(1000 + i),
        1 => state.after_steps(5 * i),
        _ => state,
    }
}

/// An ensemble counts its trajectories; a simulation has to be told.
fn numbered(i: u64) -> State<3> {
    if i.is_multiple_of(3) { start(i) } else { start(i).numbered(i) }
}

/// How far places are from each other; momenta have to be zero.
fn off(a: &State<3>, b: &State<3>) -> f64 {
    assert_eq!((a.time(), a.steps()), (b.time(), b.steps()));
    assert!(a.momenta().chain(b.momenta()).all(|p| p.norm() == 0.0));
    a.positions().zip(b.positions()).map(|(a, b)| (a - b).norm()).fold(0.0, larger)
}

/// In which step what is said, but for other numbers: these agree to rounding.
pub(crate) fn words(error: &Error) -> String {
    let told = error.to_string();
    let (step, rest) = told.split_once(" (t").unwrap();
    let rest: String = rest.chars().filter(|c| !c.is_ascii_digit() && *c != '-').collect();
    format!("{step}{rest}")
}

fn in_lanes(ensemble: &Ensemble<3>) {
    let plan = ensemble.plan();
    assert_eq!(plan.in_lanes == ensemble.len(), InstructionSet::widest().fuses(), "{plan:?}");
}

/// Of so many trajectories how far the worst is from its simulation after so many steps.
fn apart<P: Precision>(precision: P, number: u64, h: f64, steps: u64) -> f64 {
    let scene = Scene::on(RING).with(Trough { g: 1.0 });
    let mut ensemble = scene.ensemble_in(precision, (0..number).map(start), method(h)).unwrap();
    in_lanes(&ensemble);
    let [first, given] = [ensemble.state(0), scene.simulate(start(0), method(h)).unwrap().state()]
        .map(|state| state.momenta().next().unwrap());
    assert!((first - given).norm() < 1e-6, "momenta of a start are shown before its first step");
    ensemble.run(steps);
    assert_eq!(ensemble.failures().count(), 0);
    let alone = (0..number).map(|i| {
        let mut simulation = scene.simulate(numbered(i), method(h)).unwrap();
        simulation.run(steps).unwrap();
        assert_eq!([simulation.work(), ensemble.work(i as usize)], [0.0; 2]);
        off(&simulation.state(), &ensemble.state(i as usize))
    });
    alone.fold(0.0, larger)
}

#[test]
fn as_alone_but_for_rounding() {
    let found = [
        apart(Double, 67, 0.01, 40),
        apart(Compensated, 67, 0.01, 40),
        apart(Double, 1, 0.02, 40),
        apart(Compensated, 1, 0.02, 40),
    ];
    assert!(found.iter().all(|&off| off < 2e-14), "{found:?}");
    let single = apart(Single, 67, 0.01, 40);
    assert!(single < 1e-5, "{single}");
}

/// Each trajectory of a sweep has a surface and a force of its own.
#[test]
fn scenes_by_lane() {
    let scene = |i: u32| {
        Scene::on(Torus { minor: 0.5, major: 1.2 + 0.002 * f64::from(i) })
            .with(Trough { g: 0.1 * f64::from(i) })
    };
    let scenes: Vec<_> = (0..66).map(scene).collect();
    let begin = |i: u32| State::at([1.7 + 0.002 * f64::from(i), 0.0, 0.0]);
    let mut sweep = Ensemble::sweep(Double, scenes.iter().zip((0..).map(begin)), method(0.01)).unwrap();
    in_lanes(&sweep);
    sweep.run(30);
    for (scene, i) in scenes.iter().zip(0..) {
        let mut alone = scene.simulate(begin(i).numbered(u64::from(i)), method(0.01)).unwrap();
        alone.run(30).unwrap();
        assert!(off(&alone.state(), &sweep.state(i as usize)) < 1e-14, "{i}");
    }
}

/// Bits depend on no neighbour, on no division of a run, and not on a checkpoint between.
#[test]
fn the_same_bits() {
    let scene = Scene::on(RING).with(Trough { g: 1.0 });
    let by = |method, numbers: Vec<u64>| {
        scene.ensemble(numbers.into_iter().map(|i| start(i).numbered(i)), method).unwrap()
    };
    let of = |numbers| by(method(0.01), numbers);
    let (mut all, mut few) = (of((0..70).collect()), of((0..70).step_by(7).collect()));
    all.run(90);
    few.run(33);
    let record = few.checkpoint();
    few.run(57);
    let mut again = of((0..70).step_by(7).collect());
    again.resume(&record).unwrap();
    again.run(57);
    let bits = |state: &State<3>| format!("{state:?}");
    for (i, state) in few.states().enumerate() {
        assert_eq!(bits(&state), bits(&all.state(7 * i)), "{i}");
        assert_eq!(bits(&state), bits(&again.state(i)), "{i}, from a checkpoint");
    }
    for other in [Brownian::new(1.5, 0.4, 10, 0.01), Brownian::new(1.5, 0.5, 9, 0.01), method(0.02)] {
        let refused = by(other, (0..70).step_by(7).collect()).resume(&record).unwrap_err().to_string();
        assert!(refused.contains("method"), "{refused}");
    }
}

/// Heights on a sphere have the density exp(−gz/kT), and where there is no force ⟨(q − q₀)²⟩ = 2R² (1 − exp(−2Dt/R²)):
/// both to first order in h.
#[test]
fn laws() {
    const H: f64 = 0.005;
    let sphere = Scene::on(Sphere { r: 1.0 });
    let starts = |number| (0..number).map(|_| State::at([0.0, 0.0, -1.0]));
    let mut free = sphere.ensemble(starts(4096), Brownian::new(1.0, 0.5, 7, H)).unwrap();
    free.run(100);
    let mean =
        free.states().map(|state| 2.0 + 2.0 * state.positions().next().unwrap().z).sum::<f64>() / 4096.0;
    let exact = 2.0 - 2.0 * (-2.0 * 0.5 * 100.0 * H).exp();
    // 4.5 times the standard deviation of the mean, some 0.8/√4096, and what is left of first order.
    assert!((mean - exact).abs() < 4.5 * 0.8 / 64.0 + H, "{mean} {exact}");

    let heavy = sphere.with(Gravity { g: 1.0 });
    let mut ensemble = heavy.ensemble(starts(512), Brownian::new(1.0, 0.5, 7, H)).unwrap();
    ensemble.run(400);
    let height = ensemble.observe(2000, 100, || Mean::of(|now: &Sight<'_, 3>| now.position().z));
    let z = 0.5 - 1.0 / (1.0_f64 / 0.5).tanh();
    // Heights lose their past in 1/2D or so: each trajectory gives some 10 that are independent.
    assert!((height.mean() - z).abs() < 4.5 * 0.42 / 5120.0_f64.sqrt() + H, "{} {z}", height.mean());
}

/// Trajectories do not land on shells 3e-5 to 0.1 apart in silence, and those that go by themselves draw what
/// simulations draw.
#[test]
fn shells_are_kept() {
    let (mut kept, mut refused) = (0, 0);
    for (k, g, h) in [(30.0, 1.0, 0.01), (300.0, 1.0, 0.003), (1e3, 0.0, 0.01), (1e5, 2.0, 0.1)] {
        let scene = Scene::on(Shells { k }).with(Gravity { g });
        let by = Brownian::new(1.0, 0.5, 3, h);
        let begin = |i: u64| State::at([(i as f64).cos(), (i as f64).sin(), 0.0]).numbered(i);
        let mut ensemble = scene.ensemble((0..32).map(begin), by).unwrap();
        ensemble.run(70);
        refused += ensemble.failures().count();
        for (i, state) in ensemble.states().enumerate() {
            let radius = state.positions().next().unwrap().norm();
            assert!((radius - 1.0).abs() < 1e-9, "k = {k}, h = {h}, {i}: on the sphere of radius {radius}");
            let mut alone = scene.simulate(begin(i as u64), by).unwrap();
            match (alone.run(70), ensemble.failure(i)) {
                (Ok(()), None) => {
                    assert!(off(&alone.state(), &state) < 1e-10, "k = {k}, {i}");
                    kept += 1;
                }
                (Err(own), Some(told)) => assert_eq!(words(&own), words(told)),
                (own, told) => panic!("k = {k}, {i}: alone {own:?}, in lanes {told:?}"),
            }
        }
    }
    println!("{kept} kept their shell for 70 steps, {refused} were refused");
    assert!(kept > 20 && refused > 20, "{kept} {refused}");
}

/// Steps cannot be repeated in parts, which would draw other numbers: an ensemble says what a simulation says. Who
/// goes on has the bits of one who was alone.
#[test]
fn who_cannot_go_on_says_why() {
    fn compare<C: Constraint<3, 1> + 'static>(
        scene: &Scene<C, impl Effects<3>, rattle::bodies::One, 3>,
        at: [f64; 3],
        h: f64,
    ) -> [usize; 2] {
        let by = |h| Brownian::new(1.0, 0.5, 1, h);
        let begin = |i: u64| State::at(at).numbered(i);
        let mut ensemble = scene.ensemble((0..64).map(begin), by(h)).unwrap().retry(6);
        in_lanes(&ensemble);
        ensemble.run(6);
        let mut ended = 0;
        for i in 0..64 {
            let mut alone = scene.simulate(begin(i), by(h)).unwrap().retry(6);
            let (own, told) = (alone.run(6).err(), ensemble.failure(i as usize));
            assert_eq!(own.as_ref().map(words), told.map(words), "{i}");
            ended += usize::from(told.is_some());
            if told.is_none() {
                let mut one = scene.ensemble([begin(i)], by(h)).unwrap();
                one.run(6);
                assert_eq!(format!("{:?}", one.state(0)), format!("{:?}", ensemble.state(i as usize)), "{i}");
            }
        }
        [ended, 64 - ended]
    }
    let too_long = compare(&Scene::on(Sphere { r: 1.0 }), [0.0, 0.0, 1.0], 0.12);
    let over_the_ridge = compare(&Scene::on(Roof {}).with(Gravity { g: 1.0 }), [0.15, 0.0, -0.15], 0.004);
    println!("{too_long:?} {over_the_ridge:?}");
    assert!([too_long, over_the_ridge].as_flattened().iter().all(|&number| number > 5));
}

constraint! {
    /// A cube.
    struct Cube { r }
    |x, y, z| max(abs(x), max(abs(y), abs(z))) - r
}

/// Beyond an edge of a cube normals are across the old one, and no correction is a number: it is the edge that is told.
#[test]
fn edges_of_a_cube_are_told() {
    let scene = Scene::on(Cube { r: 1.0 });
    let by = Brownian::new(1.0, 1.0, 3, 5e-4);
    let begin = |i: u64| State::at([0.03 * i as f64 - 0.5, 0.2, 1.0]).numbered(i);
    let mut ensemble = scene.ensemble((0..32).map(begin), by).unwrap();
    in_lanes(&ensemble);
    ensemble.run(2000);
    let mut ended = 0;
    for i in 0..32 {
        let mut alone = scene.simulate(begin(i), by).unwrap();
        let (own, told) = (alone.run(2000).err(), ensemble.failure(i as usize));
        assert_eq!(own.as_ref().map(words), told.map(words), "{i}");
        if let Some(error) = told {
            assert!(matches!(error, Error::Step { cause: StepFailure::Kink { .. }, .. }), "{i}: {error}");
            ended += 1;
        }
    }
    println!("{ended} of 32 came to an edge");
    assert!(ended > 5, "{ended}");
}

potential! {
    /// A force that has no value below a height, and pushes there.
    pub(crate) struct Ending { g }
    |_x, _y, z| g * sqrt(z)
}

potential! {
    /// Pushes ever more, the farther from the plane.
    pub(crate) struct Unstable { a }
    |_x, _y, z| -a / 2 * z^2
}

/// Steps, after which it is looked at who ended, and when: at once, one by one, and alone.
macro_rules! ends_alike {
    ($scene:expr, $start:expr, $method:expr, $steps:expr, $number:expr) => {{
        let of = |numbers: std::ops::Range<u64>| {
            $scene.ensemble(numbers.map(|i| $start(i).numbered(i)), $method).unwrap()
        };
        let (mut at_once, mut one_by_one) = (of(0..$number), of(0..$number));
        at_once.run($steps);
        (0..$steps).for_each(|_| one_by_one.run(1));
        let mut ended = 0;
        for i in 0..$number as usize {
            let mut single = of(i as u64..i as u64 + 1);
            single.run($steps);
            let mut simulation = $scene.simulate($start(i as u64).numbered(i as u64), $method).unwrap();
            let own = simulation.run($steps).err();
            for (ensemble, i) in [(&at_once, i), (&one_by_one, i), (&single, 0)] {
                assert_eq!(own.as_ref().map(words), ensemble.failure(i).map(words), "{i}");
                assert_eq!(format!("{:?}", ensemble.state(i)), format!("{:?}", single.state(0)), "{i}");
            }
            ended += usize::from(own.is_some());
        }
        [ended, $number as usize - ended]
    }};
}
pub(crate) use ends_alike;

/// Where a force is no number it is said in the step that led there, however the run is divided; and steps that are too
/// long are rescued, or not, likewise.
#[test]
fn who_ends_ends_in_the_same_step() {
    let by = Brownian::new(1.0, 0.02, 5, 0.02);
    let cylinder = Scene::on(Sphere { r: 1.0 }).with(Ending { g: 1.0 });
    let low = |i: u64| {
        let z = 0.05 + 0.03 * i as f64;
        State::at([(1.0 - z * z).sqrt(), 0.0, z])
    };
    let forces = ends_alike!(cylinder, low, by, 9, 20);
    let hot = Brownian::new(1.0, 1.0, 5, 0.06);
    let pole = |_: u64| State::at([0.0, 0.0, 1.0]);
    let steps = ends_alike!(Scene::on(Sphere { r: 1.0 }), pole, hot, 20, 64);
    println!("{forces:?} {steps:?}");
    assert!([forces, steps].as_flattened().iter().all(|&number| number > 3));
}

/// Starts ever farther from a plane in scenes by k and by how much forces grow: none is found at another distance from
/// 0 than 1. How many still move after 63 steps, and how many were refused.
macro_rules! kept_where_forces_grow {
    ($scene:expr, $places:expr, $ks:expr, $growths:expr) => {{
        let [mut kept, mut refused] = [0, 0];
        for k in $ks {
            for a in $growths {
                let begin = |i: i32| {
                    let z = 1e-9 * 10_f64.powf(0.25 * f64::from(i));
                    State::of($places([(1.0 - z * z).sqrt(), 0.0, z]))
                };
                let by = Brownian::new(1.0, 0.0, 1, 1.0);
                let mut ensemble = $scene(k, a).ensemble((0..17).map(begin), by).unwrap();
                for _ in 0..63 {
                    ensemble.run(1);
                    for state in ensemble.states() {
                        let off = (state.positions().last().unwrap().norm() - 1.0).abs();
                        assert!(off < 1e-9, "k = {k}, a = {a}: {off}");
                    }
                }
                refused += ensemble.failures().count();
                kept += 17 - ensemble.failures().count();
            }
        }
        println!("{kept} {refused}");
        [kept, refused]
    }};
}
pub(crate) use kept_where_forces_grow;

/// Forces that grow by any factor between two looks at other sheets do not lead to these in silence.
#[test]
fn growing_forces_lead_to_no_other_shell() {
    let scene = |k, a| Scene::on(Shells { k }).with(Unstable { a });
    let found = kept_where_forces_grow!(scene, |at: [f64; 3]| [at], [3e3, 1e4, 1e5], [0.35, 0.6, 0.85]);
    assert!(found.iter().all(|&number| number > 10), "{found:?}");
}

/// Headings and other pushes are not known in lanes.
#[test]
fn pushes_go_alone() {
    let pushed = rattle::effect::SelfPropulsion::new(1.0, 1.0, 3);
    let scene = Scene::on(Sphere { r: 1.0 }).with(pushed);
    let plan = scene.ensemble((0..3).map(|_| State::at([0.0, 0.0, 1.0])), method(0.01)).unwrap().plan();
    assert!(plan.alone == 3 && plan.reason != Some(NotInLanes::Method("Brownian motion")), "{plan:?}");
}

/// Momenta are drawn by the same random numbers, shorter by √h: what is said to be the longest step is.
#[test]
fn the_longest_step_is_told() {
    let scene = Scene::on(Sphere { r: 1.0 });
    let start = || State::at([0.0, 0.0, 1.0]);
    let longest = |error: &Error| match error {
        Error::Step { cause: StepFailure::Surface(SurfaceFailure::StepTooLong { longest, .. }), .. } => {
            Some(*longest)
        }
        _ => None,
    };
    let mut failed = 0;
    for seed in 0..40 {
        let takes = |h| {
            let method = Brownian::new(1.0, 1.0, seed, h);
            let mut ensemble = scene.ensemble([start()], method).unwrap();
            ensemble.run(1);
            let in_lanes = ensemble.failures().next().and_then(|(_, error)| longest(error));
            let alone =
                scene.simulate(start(), method).unwrap().run(1).err().and_then(|error| longest(&error));
            assert_eq!(in_lanes.is_some(), alone.is_some(), "h = {h}");
            assert!(in_lanes.zip(alone).is_none_or(|(a, b)| (a / b - 1.0).abs() < 1e-12));
            alone
        };
        let Some(longest) = takes(0.7) else { continue };
        failed += 1;
        assert!(takes(1.01 * longest).is_some(), "{longest}");
        assert!(takes(0.99 * longest).is_none(), "{longest}");
    }
    assert!(failed > 10, "{failed}");
}
