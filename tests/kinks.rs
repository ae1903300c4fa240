//! Kinks: where the normal of a constraint jumps no step leads across, and where only its curvature does, steps go on.
//!
//! | constraint | what happens where its argument changes sign | expected |
//! |---|---|---|
//! | roof, octahedron, cube, a step of a floor | the normal turns, or the surface ends | an error that names argument, place, step |
//! | abs(x)^3, x abs(x), max(x, 0)^2, a capsule, c g with another c | the curvature or the scale jumps | goes on |
//! | rods by sums of sides, in a chain, moving | as on surfaces | an error that names the link |
//! | potentials abs(x) | the force jumps | goes on, energy to first order |
//! | octahedron, roof, `over_kinks` | the same | the straight line on the net laid out in the plane, energy, to rounding |

use crate::common::*;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::Error;
use rattle::composition::SUZUKI_1990_ORDER_4;
use rattle::ensemble::{Double, InstructionSet, Precision, Single};
use rattle::error::StepFailure;
use rattle::kernel::ConstraintKernel;
use rattle::prelude::*;
use rattle::system::System;

constraint! {
    /// Two planes that meet in a ridge.
    struct Roof { slope }
    |x, _y, z| z + slope * abs(x)
}
constraint! {
    /// The octahedron (a = b = 1, c = 1, d = 0), a roof (a = 1/2, b = c = 0, d = 1).
    struct Faces { a, b, c, d, r }
    |x, y, z| a * abs(x) + b * abs(y) + c * abs(z) + d * z - r
}
constraint! {
    /// The cube.
    struct Cube { r }
    |x, y, z| max(abs(x), abs(y), abs(z)) - r
}
constraint! {
    /// A floor with a step.
    struct Stairs { height }
    |x, _y, z| z - height * sign(x)
}
constraint! {
    /// A plane that begins to rise.
    struct Ramp { slope }
    |x, y, z| { let across = x + y; if across < 1 { z } else { z - slope * (across - 1) } }
}

const OCTAHEDRON: Faces = Faces { a: 1.0, b: 1.0, c: 1.0, d: 0.0, r: 1.0 };
const ROOF: Faces = Faces { a: 0.5, b: 0.0, c: 0.0, d: 1.0, r: 0.0 };
constraint! {
    /// Steps of a stair, of width 1/2.
    struct Flight { height }
    |x, _y, z| z - height * floor(2 * x)
}
constraint! {
    /// Steps of a slope, of width 1, until x = 3.
    struct SlopedStairs { height }
    |x, _y, z| z - height * floor(x) - mod(x, 3)
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

/// From the left, straight on without a force: the step in which x = 0 is crossed is known.
#[test]
fn the_step_across_a_ridge_is_an_error() {
    for slope in [1e-3, 0.1, 0.5, 1.0, -0.5, 5.0] {
        for h in [1e-4, 0.01, 0.033, 0.3] {
            let scene = Scene::on(Roof { slope });
            let start = State::at([-1.0, 0.0, -slope]).moving([0.7, 0.3, 0.7 * slope]);
            let mut simulation = scene.simulate(start, Rattle::new(h)).unwrap();
            let error = simulation.run(1_000_000).unwrap_err();
            let text = error.to_string();
            let (step, argument, share, angle) = kink(error);
            let exact = 1.0 / (0.7 * h); // no whole number of steps
            assert_eq!((step, argument), (exact.ceil() as u64, "x"), "slope {slope}, h = {h}");
            assert!((share - exact.fract()).abs() < 1e-5, "{share} {}", exact.fract());
            assert!((angle - 2.0 * slope.abs().atan().to_degrees()).abs() < 1e-9, "{angle}");
            assert!(
                text.contains("where `x` changes its sign") && text.contains("sqrt(x^2 + eps^2)"),
                "{text}"
            );
            assert_eq!(simulation.steps(), step - 1, "the simulation is as before the step");
            assert!(simulation.energy_error().abs() < 1e-12 && simulation.position().x < 0.0);
        }
    }
}

/// A step that ends on the edge to the last bit. There the normal is that of the right side, as abs′(0) = 1: so from
/// the left it is the step across, and from the right the one after it is. (Numbers of few bits, so that none is
/// rounded.)
#[test]
fn a_step_that_ends_on_the_edge_is_an_error_or_the_next_one_is() {
    for (side, across, part) in [(-1.0, 4, 1.0), (1.0, 5, 0.0)] {
        let scene = Scene::on(Roof { slope: 0.5 });
        let start = State::at([0.5 * side, 0.0, -0.25]).moving([-side, 0.0, 0.5]);
        let mut simulation = scene.simulate(start, Rattle::new(0.125)).unwrap();
        let (step, argument, share, _) = kink(simulation.run(10).unwrap_err());
        assert_eq!((step, argument), (across, "x"), "{side}");
        assert!((share - part).abs() < 1e-5, "{share}");
        assert_eq!(simulation.position().x, side * (0.5 - 0.125 * (across - 1) as f64));
        assert_eq!(simulation.energy_error(), 0.0);
    }
}

constraint! {
    /// A roof whose 33 ridges are a unit apart.
    struct Ridges { slope }
    |x, _y, z| z + slope * (abs(x) + abs(x - 1) + abs(x - 2) + abs(x - 3) + abs(x - 4) + abs(x - 5) + abs(x - 6)
        + abs(x - 7) + abs(x - 8) + abs(x - 9) + abs(x - 10) + abs(x - 11) + abs(x - 12) + abs(x - 13) + abs(x - 14)
        + abs(x - 15) + abs(x - 16) + abs(x - 17) + abs(x - 18) + abs(x - 19) + abs(x - 20) + abs(x - 21) + abs(x - 22)
        + abs(x - 23) + abs(x - 24) + abs(x - 25) + abs(x - 26) + abs(x - 27) + abs(x - 28) + abs(x - 29) + abs(x - 30)
        + abs(x - 31) + abs(x - 32) - 528)
}

/// Arguments are looked at in pages of 32: one of the first, and the last one, alone on its page.
#[test]
fn of_many_ridges_each_is_told() {
    for (from, ridge, name) in [(2.3, 3.0, "x - 3"), (31.3, 32.0, "x - 32")] {
        let scene = Scene::on(Ridges { slope: 0.01 });
        let start = scene.project(&State::at([from, 0.0, 0.0]).moving([1.0, 0.0, 0.0])).unwrap();
        let mut simulation = scene.simulate(start, Rattle::new(0.05)).unwrap();
        let (_, argument, ..) = kink(simulation.run(100).unwrap_err());
        assert_eq!(argument, name);
        assert!(simulation.position().x < ridge && simulation.position().x > ridge - 0.1);
    }
}

/// Flat sides, ways straight: until the error energy is kept to rounding, however the edges are met.
fn ends_at_an_edge<C: Constraint<3, 1> + Copy + 'static>(surface: C, arguments: &[&str], degrees: f64) {
    let (scene, mut random) = (Scene::on(surface).with(Gravity { g: 0.0 }), StdRng::seed_from_u64(4));
    let mut ended = 0;
    while ended < 200 {
        let mut draw = || Vector3::from_fn(|_, _| random.random_range(-1.0..1.0));
        let Ok(start) = scene.project(&State::at(draw()).moving(draw())) else { continue };
        let h = random.random_range(1e-3..0.1);
        let Ok(mut simulation) = scene.simulate(start, Rattle::new(h)) else { continue };
        let (_, argument, _, angle) = kink(simulation.run(1_000_000).unwrap_err());
        assert!(arguments.contains(&argument), "{argument}");
        assert!((angle - degrees).abs() < 0.1, "{angle}");
        assert!(simulation.energy_error().abs() < 1e-12, "{:e}", simulation.energy_error());
        ended += 1;
    }
}

#[test]
fn edges_of_polyhedra_are_errors() {
    ends_at_an_edge(OCTAHEDRON, &["x", "y", "z"], (1.0_f64 / 3.0).acos().to_degrees());
    ends_at_an_edge(Cube { r: 1.0 }, &["abs(x) - abs(y)", "max(abs(x), abs(y)) - abs(z)"], 90.0);
}

#[test]
fn steps_of_a_floor_and_branches_are_errors() {
    let scene = Scene::on(Stairs { height: 0.01 });
    let start = State::at([-1.0, 0.0, -0.01]).moving([1.0, 0.0, 0.0]);
    let error = scene.simulate(start, Rattle::new(0.03)).unwrap().run(1000).unwrap_err();
    assert!(error.to_string().contains("the surface goes on 2.0e-2 away"), "{error}");
    assert_eq!(kink(error).0, 34);

    // Where floor jumps: at all whole numbers, even and odd, up and down.
    for (x, v, end) in
        [(-0.25, 1.0, 0.0), (0.25, 1.0, 0.5), (0.75, 1.0, 1.0), (0.25, -1.0, 0.0), (-0.25, -1.0, -0.5)]
    {
        let start = State::at([x, 0.0, 0.01 * f64::floor(2.0 * x)]).moving([v, 0.0, 0.0]);
        let mut simulation = Scene::on(Flight { height: 0.01 }).simulate(start, Rattle::new(0.03)).unwrap();
        let (step, argument, share, _) = kink(simulation.run(1000).unwrap_err());
        assert_eq!((step, argument), (9, "x * 2 - 2 * floor(x * 2 / 2) - 1")); // 0.25 is 8⅓ steps
        assert!((share - 1.0 / 3.0).abs() < 1e-5 && (simulation.position().x - end).abs() < 0.03, "{share}");
    }

    // Newton's steps go to and fro across a step of a slope, on neither side of which the body lands.
    let start = State::at([0.5, 0.0, 0.5]).moving([1.0, 0.0, 1.0]);
    for height in [0.1, 0.01] {
        let scene = Scene::on(SlopedStairs { height });
        let mut simulation = scene.simulate(start.clone(), Rattle::new(0.03)).unwrap();
        let error = simulation.run(1000).unwrap_err();
        assert!(error.to_string().contains("the surface goes on 7.1e-"), "{error}");
        assert_eq!((simulation.steps(), simulation.residuals()), (16, vec![0.0]));
        assert_eq!(kink(error).1, "x - 2 * floor(x / 2) - 1");
    }

    let start = State::at([-1.0, 0.0, 0.0]).moving([1.0, 0.5, 0.0]);
    let mut simulation = Scene::on(Ramp { slope: 0.2 }).simulate(start, Rattle::new(0.03)).unwrap();
    let (step, argument, ..) = kink(simulation.run(1000).unwrap_err());
    assert_eq!((step, argument), (45, "across - 1"));
}

fn roof_by<S: Method>(method: &S) {
    let scene = Scene::on(Roof { slope: 0.5 });
    let start = State::at([-1.0, 0.0, -0.5]).moving([1.0, 0.3, 0.5]);
    let mut simulation = scene.simulate(scene.staggered(&start, method).unwrap(), method.clone()).unwrap();
    let (_, argument, ..) = kink(simulation.run(100_000).unwrap_err());
    let last = simulation.position().x;
    assert!(argument == "x" && (-0.031..=1e-12).contains(&last), "{}: {argument}, x = {last}", method.name());
}

#[test]
fn no_method_goes_across() {
    let h = 0.03;
    roof_by(&Rattle::new(h));
    roof_by(&Rattle::new(h).solved_by(Broyden));
    roof_by(&Shake::new(h));
    roof_by(&PositionVerlet::new(h));
    roof_by(&Composition::new(SUZUKI_1990_ORDER_4, h));
    roof_by(&Lobatto::<3>::new(h));
    roof_by(&Variable::of(Rattle::new(h), 0.3));
    roof_by(&Dop853::new(h));
    roof_by(&Dop853::adaptive(h, 1e-10));
    roof_by(&Taylor::new(8, h));
    roof_by(&Taylor::adaptive(12, h, 1e-12));
    roof_by(&Bdf2::new(h));
}

/// A spring pulls over the ridge and back within one step, which is divided: inner steps are looked at.
#[test]
fn there_and_back_within_a_step() {
    potential! {
        struct Spring {}
        |x, _y, _z| x^2 / 2
    }
    let scene = Scene::on(Roof { slope: 0.5 }).with(Spring {});
    let period = std::f64::consts::TAU * 1.25_f64.sqrt(); // of (1 + slope²) ẋ²/2 + x²/2
    fn crosses(simulated: Result<(), Error>) {
        let (step, argument, share, _) = kink(simulated.unwrap_err());
        assert_eq!((step, argument), (1, "x"));
        assert!((share - 0.25).abs() < 0.02, "{share}"); // where the straight way of an inner step meets the ridge
    }
    let start = State::at([1.0, 0.0, -0.5]);
    crosses(scene.simulate(start.clone(), Dop853::adaptive(period, 1e-8)).unwrap().run(1));
    crosses(scene.simulate(start.clone(), Taylor::adaptive(12, period, 1e-8)).unwrap().run(1));
    if InstructionSet::widest().fuses() {
        let mut ensemble = scene.ensemble([start], Dop853::adaptive(period, 1e-8)).unwrap();
        ensemble.run(1);
        crosses(Err(ensemble.failure(0).unwrap().clone()));
    }
}

constraint! {
    /// Continuous curvature.
    struct Cubic {}
    |x, _y, z| z - abs(x)^3
}
constraint! {
    /// Curvature that changes its sign.
    struct Wave {}
    |x, _y, z| z - x * abs(x) / 2
}
constraint! {
    /// Curvature that begins.
    struct Gutter {}
    |x, y, z| z - max(x, 0)^2 - max(-x - 1, 0)^2 + 0.1 * min(y, 0)^2
}
constraint! {
    /// A cylinder with two half spheres. Away from the surface g itself jumps where they meet.
    struct Capsule { half, r }
    |x, y, z| {
        if abs(z) < half { x^2 + y^2 - r^2 } else { norm(x, y, abs(z) - half) - r }
    }
}
constraint! {
    /// A paraboloid, with another factor on each side.
    struct TwoScales {}
    |x, y, z| { let g = z - (x^2 + y^2) / 2; if x < 0 { g } else { 10 * g } }
}
/// How often the first argument changed its sign in as many steps, and the largest energy error.
fn goes_on<C: Constraint<3, 1>, S: Method>(
    surface: C,
    start: [[f64; 3]; 2],
    method: S,
    steps: u32,
) -> (u32, f64) {
    let scene = Scene::on(surface).with(Gravity { g: 1.0 });
    let start = scene.project(&State::at(start[0]).moving(start[1])).unwrap();
    let mut simulation = scene.simulate(start, method).unwrap();
    let (mut crossed, mut energy, mut last) = (0, 0.0_f64, simulation.position().x);
    for _ in 0..steps {
        simulation.step().unwrap();
        let now = simulation.position().x;
        crossed += u32::from((now < 0.0) != (last < 0.0));
        energy = energy.max(simulation.energy_error().abs());
        last = now;
    }
    (crossed, energy)
}

#[test]
fn where_only_the_curvature_jumps_steps_go_on() {
    let start = [[-0.5, 0.1, 0.2], [0.3, 0.1, 0.0]];
    for h in [2.5e-3, 0.01, 0.04] {
        let steps = (100.0 / h) as u32;
        let rows = [
            ("cubic", goes_on(Cubic {}, start, Rattle::new(h), steps)),
            ("gutter", goes_on(Gutter {}, start, Rattle::new(h), steps)),
            (
                "capsule",
                goes_on(
                    Capsule { half: 1.0, r: 0.5 },
                    [[0.5, 0.0, 0.9], [0.0, 1.0, 0.6]],
                    Rattle::new(h),
                    steps,
                ),
            ),
            ("two scales", goes_on(TwoScales {}, start, Rattle::new(h), steps)),
            ("two scales, Lobatto", goes_on(TwoScales {}, start, Lobatto::<3>::new(h), steps)),
        ];
        for (name, (crossed, energy)) in rows {
            println!("{name}, h = {h}: crossed {crossed} times, energy {energy:e}");
            assert!(crossed > 10 && energy < 40.0 * h * h, "{name}: {crossed}, {energy:e}");
        }
        let (crossed, energy) =
            goes_on(Wave {}, [[-0.5, 0.1, 0.0], [0.9, 0.1, 0.0]], Rattle::new(h), (2.0 / h) as u32);
        assert!(crossed == 1 && energy < 10.0 * h * h, "{crossed}, {energy:e}");
    }
}

constraint! {
    /// A rod whose length is the sum of its sides.
    struct Sides { length }
    |a: [f64; 2], b: [f64; 2]| abs(a[0] - b[0]) + abs(a[1] - b[1]) - length
}
constraint! {
    /// A roof that rises.
    struct Lift { speed }
    |x, y, t| y + abs(x) / 2 - speed * t
}

#[test]
fn links_are_named() {
    let scene = Scene::points(3).link(Sides { length: 1.0 }, [[0, 1], [1, 2]]).pin(0, [0.0; 2]);
    let start =
        State::of([[0.0, 0.0], [0.5, 0.5], [0.91, 1.09]]).with_momenta([[0.0; 2], [0.1, -0.1], [-0.3, 0.3]]);
    for h in [0.01, 0.07] {
        let mut simulation = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
        let error = simulation.run(10_000).unwrap_err();
        let Error::Step { step, cause: StepFailure::Kink { argument, equation, .. }, .. } = &error else {
            panic!("{error}")
        };
        let equation = equation.as_ref().unwrap();
        assert_eq!((equation.link, equation.member, &equation.bodies[..]), ("Sides", 1, &[1, 2][..]));
        assert_eq!((*argument, *step), ("a[0] - b[0]", (1.025 / h).ceil() as u64), "{error}");
        assert!(error.to_string().contains("Sides 1 (bodies 1, 2) has a kink"), "{error}");
        assert!(simulation.energy_error().abs() < 1e-14);
    }
    let lifted = Scene::points(1).link_moving(Lift { speed: 0.1 }, [[0]]);
    let start = State::at([-1.0, -0.5]).moving([0.9, 0.55]);
    let mut simulation = lifted.simulate(start, Rattle::new(0.01)).unwrap();
    assert_eq!(kink(simulation.run(10_000).unwrap_err()).1, "x");
}

fn lanes<P: Precision>(precision: P, method: impl Method, halvings: u32) {
    let scene = Scene::on(Roof { slope: 0.5 });
    let starts = (0..70).map(|i| {
        let speed = if i % 7 == 3 { 0.3 + 0.01 * f64::from(i) } else { -1.0 };
        scene.project(&State::at([-1.0, 0.0, -0.5]).moving([speed, 0.3, 0.5 * speed])).unwrap()
    });
    let starts: Vec<_> = starts.collect();
    let mut ensemble = scene.ensemble_in(precision, starts.clone(), method.clone()).unwrap().retry(halvings);
    ensemble.run(2000);
    assert_eq!(ensemble.failures().count(), 10);
    for (i, error) in ensemble.failures() {
        let mut alone = scene.simulate(starts[i].clone(), method.clone()).unwrap();
        let (step, argument, ..) = kink(alone.run(2000).unwrap_err());
        let (Error::Step { step: found, cause, .. } | Error::Retried { step: found, cause, .. }) = error
        else {
            panic!("{error}")
        };
        assert!(matches!(cause, StepFailure::Kink { argument: "x", .. }) && argument == "x", "{cause}");
        assert_eq!(found, &step, "trajectory {i}");
        let (state, own) = (ensemble.state(i), alone.position());
        assert!(
            distance(state.positions().next().unwrap(), own) < 1e-5,
            "trajectory {i} rests before the step"
        );
        assert!(state.momenta().next().unwrap().norm() < 2.0);
    }
}

#[test]
fn lanes_end_as_simulations_do() {
    for &halvings in if cfg!(long) { &[0, 3][..] } else { &[3] } {
        lanes(Double, Rattle::new(0.01), halvings);
        lanes(Double, Lobatto::<3>::new(0.01), halvings);
        lanes(Double, Dop853::new(0.01), halvings);
    }
    lanes(Single, Rattle::new(0.01), 0);
}

/// The rounding of g, be it in single precision or in short ways, is no gap.
#[test]
fn rounding_is_no_jump() {
    let scene = Scene::on(Tilted {}).with(Gravity { g: 1.0 });
    let start = |i: u32| State::at([-0.5, 0.01 * f64::from(i), 0.3]).moving([0.3, 0.1, 0.0]);
    let starts = || (0..70).map(|i| scene.project(&start(i)).unwrap());
    for h in [0.02, 0.003] {
        let mut ensemble = scene.ensemble_in(Single, starts(), Rattle::new(h)).unwrap();
        ensemble.run(5_000);
        assert_eq!(ensemble.failures().next().map(|(_, failure)| failure.to_string()), None);
        assert_eq!(ensemble.failures().count(), 0);
    }
    let mut random = StdRng::seed_from_u64(1);
    let seam = scene.project(&State::at([0.0, 0.3, 0.3])).unwrap().positions().next().unwrap();
    for _ in 0..300 {
        let slow = State::at(seam).moving([(); 3].map(|()| random.random_range(-1e-7..1e-7)));
        let slow = Scene::on(Tilted {}).project(&slow).unwrap();
        Scene::on(Tilted {}).simulate(slow, Rattle::new(1e-3)).unwrap().run(20).unwrap();
    }
}

constraint! {
    /// Half a plane that goes over into a half of a cylinder, tilted.
    struct Tilted {}
    |x, y, z| {
        let u = 0.8 * x + 0.36 * y + 0.48 * z;
        let v = 0.6 * z - 0.8 * y;
        max(u, 0)^2 + (v - 1)^2 - 1
    }
}

/// Twenty particles side by side, of which the seventh crosses.
#[test]
fn particles_in_tiles_are_looked_at() {
    let scene = Scene::on(Roof { slope: 0.5 }).bodies(20);
    let speed = |i: usize| if i == 7 { 1.0 } else { -0.1 };
    let start =
        State::of([[-1.0, 0.0, -0.5]; 20]).with_momenta((0..20).map(|i| [speed(i), 0.0, 0.5 * speed(i)]));
    let error = scene.simulate(start, Rattle::new(0.03)).unwrap().run(1000).unwrap_err();
    assert!(matches!(error, Error::Step { step: 34, body: 7, .. }), "{error}");
    assert_eq!(kink(error).1, "x");
}

potential! {
    /// A force that jumps at x = 0.
    struct Slope { force }
    |x, _y, _z| force * abs(x)
}

/// A jump of the force is crossed: the energy error is of first order in the step.
#[test]
fn kinks_of_potentials_are_no_errors() {
    let worst = |h: f64| {
        let scene = Scene::on(Sphere { r: 1.0 }).with(Slope { force: 1.0 });
        let mut simulation =
            scene.simulate(State::at([0.0, 0.0, 1.0]).moving([0.8, 0.4, 0.0]), Rattle::new(h)).unwrap();
        let mut worst = 0.0_f64;
        simulation.run_with((100.0 / h) as u64, |now| worst = worst.max(now.energy_error().abs())).unwrap();
        worst / h
    };
    for h in [0.02, 0.01, 0.005] {
        println!("h = {h}: energy error {:.2} h", worst(h));
        assert!((0.01..10.0).contains(&worst(h)), "{}", worst(h));
    }
}

/// What has no kinks has no list of them: nothing is compared. Roots of what cannot be negative are no kinks.
#[test]
fn smooth_constraints_have_no_list() {
    fn listed<C: Constraint<3, 1>>(_: &C) -> usize {
        C::Kernel::<f64>::KINKS.len()
    }
    assert_eq!(listed(&SURFACE), 0);
    assert_eq!(listed(&TorusByDistance { major: 2.0, minor: 1.0 }), 0);
    assert_eq!(listed(&Roof { slope: 0.5 }), 1);
    assert_eq!(listed(&OCTAHEDRON), 3);
}

fn on_faces(
    surface: Faces,
    g: f64,
    [q, p]: [[f64; 3]; 2],
    h: f64,
) -> Simulation<impl System<f64, 3, Count = rattle::bodies::One>, Rattle, 3> {
    let scene = Scene::on(surface).with(Gravity { g });
    let start = scene.project(&State::at(q).moving(p)).unwrap();
    scene.simulate(start, Rattle::new(h)).unwrap().over_kinks().unwrap()
}

/// A straight line on the net of the octahedron, laid out triangle by triangle: the third corner of the next one is
/// opposite to that of the last. No normal is looked at.
struct Net {
    /// The corners of the face in space, and in the plane.
    face: [([f64; 3], [f64; 2]); 3],
    at: [f64; 2],
    way: [f64; 2],
    edges: u64,
}

impl Net {
    fn new(q: [f64; 3], v: [f64; 3]) -> Self {
        let corner = |i: usize| std::array::from_fn(|k| if k == i { q[i].signum() } else { 0.0 });
        let flat = [[0.0, 0.0], [2_f64.sqrt(), 0.0], [0.5_f64.sqrt(), 1.5_f64.sqrt()]];
        let face = [0, 1, 2].map(|i| (corner(i), flat[i]));
        let lay = |x: [f64; 3]| [0, 1].map(|k| (0..3).map(|i| x[i].abs() * flat[i][k]).sum());
        let at = lay(q);
        // Along the face the sum of the barycentric coordinates does not change.
        let way = [0, 1].map(|k| (0..3).map(|i| v[i] * q[i].signum() * flat[i][k]).sum());
        Self { face, at, way, edges: 0 }
    }

    /// Barycentric coordinates.
    fn shares(&self, x: [f64; 2]) -> [f64; 3] {
        let [a, b, c] = self.face.map(|corner| corner.1);
        let area = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        };
        let whole = area(a, b, c);
        [area(x, b, c) / whole, area(a, x, c) / whole, area(a, b, x) / whole]
    }

    /// The place in space at this time; times must not go back.
    fn place(&mut self, t: f64) -> [f64; 3] {
        let x = [0, 1].map(|k| self.at[k] + t * self.way[k]);
        loop {
            // The edge through which the line leaves: the first of the shares to become negative.
            let (now, then) = (self.shares(self.at), self.shares(x));
            let left = (0..3).filter(|&i| then[i] < 0.0 && then[i] < now[i]);
            let time = |i: usize| now[i] / (now[i] - then[i]);
            let Some(i) = left.min_by(|&i, &j| time(i).total_cmp(&time(j))) else { break };
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let flat = [0, 1].map(|d| self.face[j].1[d] + self.face[k].1[d] - self.face[i].1[d]);
            self.face[i] = (self.face[i].0.map(|x| -x), flat);
            self.edges += 1;
        }
        let shares = self.shares(x);
        std::array::from_fn(|d| (0..3).map(|i| shares[i] * self.face[i].0[d]).sum())
    }
}

#[test]
fn over_the_edges_of_an_octahedron_the_way_is_straight() {
    for (h, way) in [(0.01, [0.31, 0.47, -0.2]), (0.7, [-0.11, 0.9, 0.23])] {
        let mut particle = on_faces(OCTAHEDRON, 0.0, [[0.2, 0.3, 0.5], way], h);
        let mut net = Net::new(particle.position().into(), particle.momentum().into());
        for _ in 0..(100.0 / h) as u32 {
            particle.step().unwrap();
            let off = distance(particle.position(), net.place(particle.time()));
            assert!(off < 1e-12, "h = {h}, t = {}: {off:e}", particle.time());
        }
        assert_eq!(particle.events(), net.edges);
        assert!(net.edges > 40);
    }
}

#[test]
#[cfg(long)]
fn over_thousands_of_edges_energy_is_kept() {
    let mut particle = on_faces(OCTAHEDRON, 0.0, [[0.2, 0.3, 0.5], [0.83, 0.31, 0.2]], 0.4);
    particle.run_while(200_000, |now| now.events() < 2_000).unwrap();
    println!("{} steps, energy {:e}", particle.steps(), particle.energy_error());
    assert!(particle.energy_error().abs() < 1e-13 && particle.constraint_residual() < 1e-14);
    // Under gravity: parabolas on the faces, which the method follows exactly.
    for (surface, g) in [(OCTAHEDRON, 0.2), (ROOF, -0.5)] {
        let mut particle = on_faces(surface, g, [[-0.4, 0.1, 0.4], [0.3, 0.2, 0.1]], 0.03);
        particle.run_while(40_000, |now| now.events() < 200).unwrap();
        assert!(particle.energy_error().abs() < 1e-13, "{:e}", particle.energy_error());
    }
}

#[test]
fn without_being_asked_an_edge_is_an_error() {
    let scene = Scene::on(ROOF).with(Gravity { g: -0.5 });
    let start = scene.project(&State::at([-0.4, 0.1, 0.4]).moving([0.3, 0.2, 0.1])).unwrap();
    let error = scene.simulate(start.clone(), Rattle::new(0.03)).unwrap().run(1000).unwrap_err();
    assert!(error.to_string().contains("`over_kinks`"), "{error}");
    let staggered =
        scene.simulate(scene.staggered(&start, &Shake::new(0.03)).unwrap(), Shake::new(0.03)).unwrap();
    let error = staggered.over_kinks().map(|_| ()).unwrap_err();
    assert!(matches!(error, Error::NoEvents { who: "SHAKE", .. }), "{error}");
}

constraint! {
    /// A roof without a word of it.
    struct Rooted { slope }
    |x, _y, z| z + slope * (sqrt(x^2) + (4 * x^2)^0.5) / 2
}

/// The root of a square is an absolute value.
#[test]
fn a_root_of_a_square_has_an_edge() {
    let scene = Scene::on(Rooted { slope: 0.5 });
    let start = scene.project(&State::at([0.3, 0.0, -0.2]).moving([-1.0, 0.1, 0.5])).unwrap();
    let error = scene.simulate(start, Rattle::new(0.05)).unwrap().run(40).unwrap_err();
    assert!(matches!(&error, Error::Step { cause: StepFailure::Kink { argument: "x", .. }, .. }), "{error}");
}
