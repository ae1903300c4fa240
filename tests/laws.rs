//! What every step must obey, whatever the scene.

use crate::common::*;
use rattle::composition::Coefficients;
use rattle::error::{StepFailure, SurfaceFailure};
use rattle::prelude::*;
use rattle::{Counted, Error};
use std::hint::black_box;

#[test]
fn one_step_forth_and_back_returns() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    for theta in directions() {
        // Somewhere on the way, where nothing is symmetric.
        let mut there = scene.simulate(billiard(theta), Rattle::new(0.01)).unwrap();
        there.run(77).unwrap();
        let before = there.state();
        let mut forth = scene.simulate(before.clone(), Rattle::new(0.01)).unwrap();
        forth.step().unwrap();
        assert!(forth.position() != there.position(), "nothing moved");
        let mut back = scene.simulate(forth.state(), Rattle::new(-0.01)).unwrap();
        back.step().unwrap();
        let (q, p) = (before.positions().next().unwrap(), before.momenta().next().unwrap());
        let (dq, dp) = (distance(back.position(), q), distance(back.momentum(), p));
        assert!(dq <= 1e-15 && dp <= 1e-14, "θ = {theta}: {dq:e}, {dp:e}");
    }
}

constraint! {
    /// The lemniscate surface, as c·g = 0.
    struct Scaled { a, r, c }
    |x, y, z| {
        let f = (x^2 + y^2)^2 - a^2 * (x^2 - y^2);
        c * (f^2 + z^2 - r^2)
    }
}

#[test]
fn scaling_the_constraint_by_a_power_of_two_changes_no_bit() {
    let run = |c: f64| {
        let scaled = Scaled { a: 1.0, r: SURFACE.r, c };
        let scene = Scene::on(scaled).with(Gravity { g: 1.0 });
        let mut simulation = scene.simulate(billiard(0.7), Rattle::new(0.01)).unwrap();
        simulation.run(2000).unwrap();
        bits(&simulation.state())
    };
    let reference = run(1.0);
    for exponent in [-60, -1, 1, 60] {
        assert_eq!(run(2.0_f64.powi(exponent)), reference, "c = 2^{exponent}");
    }
    assert_ne!(run(1.1), reference, "the comparison sees a difference");
}

#[test]
fn a_saved_state_goes_on_bit_for_bit() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let mut whole = scene.simulate(billiard(0.7), Rattle::new(0.01)).unwrap();
    whole.run(500).unwrap();
    let mut half = scene.simulate(billiard(0.7), Rattle::new(0.01)).unwrap();
    half.run(250).unwrap();
    let mut rest = scene.simulate(half.state(), Rattle::new(0.01)).unwrap();
    rest.run(250).unwrap();
    assert_eq!(bits(&rest.state()), bits(&whole.state()));
}

#[test]
fn one_particle_alone_or_among_many_moves_the_same() {
    let one = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let starts = [0.3, 0.7, 2.0].map(billiard);
    let together = State::of(starts.iter().flat_map(State::positions))
        .with_momenta(starts.iter().flat_map(State::momenta));
    let mut many = one.bodies(3).simulate(together, Rattle::new(0.01)).unwrap();
    many.run(300).unwrap();
    for (i, start) in starts.into_iter().enumerate() {
        let mut alone = one.simulate(start, Rattle::new(0.01)).unwrap();
        alone.run(300).unwrap();
        assert_eq!(many.positions().nth(i).unwrap(), alone.position(), "particle {i}");
    }
}

#[test]
fn a_step_takes_few_evaluations() {
    let (mut values, mut gradients, mut forces) = (0, 0, 0);
    for theta in directions() {
        let (surface, gravity) = (Counted::new(SURFACE), Counted::new(Gravity { g: 1.0 }));
        let (on_surface, on_gravity) = (surface.counts(), gravity.counts());
        let mut simulation =
            Scene::on(surface).with(gravity).simulate(billiard(theta), Rattle::new(0.01)).unwrap();
        on_surface.reset();
        on_gravity.reset();
        simulation.run(2000).unwrap();
        values += on_surface.values();
        gradients += on_surface.gradients();
        forces += on_gravity.gradients();
        assert_eq!(on_gravity.values(), 0, "no step needs the energy");
        assert_eq!(on_surface.curvatures(), 2000);
    }
    let steps = 25.0 * 2000.0;
    let (values, gradients) = (values as f64 / steps, gradients as f64 / steps);
    println!("{values} evaluations of g, {gradients} of ∇g per step");
    assert!((2.0..=2.3).contains(&values), "{values} evaluations of g per step");
    assert!((2.0..=2.1).contains(&gradients), "{gradients} evaluations of ∇g per step");
    assert_eq!(forces, 25 * 2000, "one force per step");
}

#[test]
fn a_step_does_not_allocate() {
    let mut one =
        Scene::on(SURFACE).with(Gravity { g: 1.0 }).simulate(billiard(0.7), Rattle::new(0.01)).unwrap();
    let scene =
        Scene::on(SURFACE).with(Gravity { g: 1.0 }).bodies(2).with(Ricker { depth: 0.5, radius: SURFACE.r });
    let pair = scene.project(&State::of([[0.0, 0.0, 0.2], [0.1, 0.0, 0.2]])).unwrap();
    let mut two = scene.simulate(pair, Composition::new(SUZUKI_1990_ORDER_4, 0.01)).unwrap();
    let allocated = allocation_counter::measure(|| {
        one.run(500).unwrap();
        two.run(500).unwrap();
    });
    assert_eq!((one.steps(), two.steps()), (500, 500));
    assert_eq!(allocated.count_total, 0);
    assert!(
        allocation_counter::measure(|| drop(black_box(one.state()))).count_total > 0,
        "the counter counts"
    );
}

#[test]
fn second_order_multiplier_is_the_mean_of_both() {
    // λ(t) of the exact motion at t = 1, θ = 45°; each multiplier alone is first order.
    let rows = table("lemniscate_gravity");
    let row = rows.iter().find(|row| row.text("ic") == "f64" && row.number("theta_deg") == 45.0).unwrap();
    let exact = row.number("lambda");
    let mut errors = [Vec::new(), Vec::new(), Vec::new(), Vec::new()];
    for n in [400, 800, 1600] {
        let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
        let mut simulation = scene.simulate(billiard_45(), Rattle::new(1.0 / n as f64)).unwrap();
        let mut trajectory = Trajectory::with_multipliers(&simulation);
        simulation.observe(n, 1, &mut trajectory).unwrap();
        let from_state = simulation.multiplier();
        simulation.observe(1, 1, &mut trajectory).unwrap();
        let found = trajectory.multipliers().unwrap();
        let (lambda, mu) = (found.position[n as usize + 1], found.momentum[n as usize]);
        for (errors, found) in errors.iter_mut().zip([lambda, mu, (lambda + mu) / 2.0, from_state]) {
            errors.push((found - exact).abs());
        }
    }
    for (errors, expected) in errors.iter().zip([1.0, 1.0, 2.0, 2.0]) {
        assert!((order(errors) - expected).abs() < 0.1, "{errors:?}");
    }
}

#[test]
fn gas_energy_is_second_order_with_the_right_sign_of_force() {
    let surface = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let mut path = surface.simulate(billiard(directions().nth(3).unwrap()), Rattle::new(0.01)).unwrap();
    let mut points = vec![path.position()];
    for _ in 0..20 {
        path.run(100).unwrap();
        points.push(path.position());
    }
    let gas = Scene::on(SURFACE).bodies(21).with(Ricker { depth: 0.5, radius: SURFACE.r });
    let deviation = |h: f64, steps: u64| {
        let mut simulation = gas.simulate(State::of(points.clone()), Rattle::new(h)).unwrap();
        let (mut largest, mut kinetic) = (0.0_f64, 0.0_f64);
        let run = simulation.run_with(steps, |now| {
            largest = largest.max(now.energy_error().abs());
            kinetic = kinetic.max(now.kinetic_energy());
        });
        run.unwrap();
        assert!(kinetic > 0.1, "the particles move");
        largest / kinetic
    };
    // To t = 1, while the paths at all step sizes still agree.
    let errors = [deviation(0.01, 100), deviation(0.005, 200), deviation(0.0025, 400)];
    assert!((order(&errors) - 2.0).abs() < 0.1, "{errors:?}");

    let mut simulation = gas.simulate(State::of(points), Rattle::new(0.01)).unwrap();
    let (mut residual, mut cotangent) = (0.0_f64, 0.0_f64);
    let run = simulation.run_with(2000, |now| {
        residual = residual.max(now.constraint_residual());
        cotangent = cotangent.max(now.cotangent_residual());
    });
    run.unwrap();
    assert!(residual <= 1e-15 && cotangent <= 1e-15, "{residual:e}, {cotangent:e}");
}

/// Three particles on a sphere of radius 1, the last one fast: it fails after the others have moved.
fn last_one_fails() -> State<3> {
    State::of([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]).with_momenta([
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [12.0, 0.0, 0.0],
    ])
}

/// Runs until a step fails, then compares the state, and what the simulation does next, with a fresh one.
fn failure_leaves_no_trace<E, S>(
    scene: Scene<Sphere, E, rattle::bodies::Many, 3>,
    start: State<3>,
    method: S,
) -> Error
where
    E: rattle::effect::Effects<3> + Clone,
    S: Method,
{
    let mut simulation = scene.simulate(start, method.clone()).unwrap();
    let (error, before) = loop {
        let before = simulation.state();
        match simulation.step() {
            Err(error) => break (error, before),
            Ok(()) => assert!(simulation.steps() < 10_000, "fails sooner or later"),
        }
    };
    assert_eq!(bits(&simulation.state()), bits(&before));
    assert_eq!(simulation.step().unwrap_err(), error, "fails in the same way again");
    let debug = format!("{:?}", scene.simulate(before, method).unwrap());
    let kept = |text: &str| text[text.find("kept").unwrap()..].to_owned();
    assert_eq!(kept(&format!("{simulation:?}")), kept(&debug), "normals and forces are those of the state");
    error
}

#[test]
fn a_failed_step_leaves_no_trace() {
    let sphere = Scene::on(Sphere { r: 1.0 }).with(Gravity { g: 1.0 }).bodies(3);
    let error = failure_leaves_no_trace(sphere, last_one_fails(), Rattle::new(0.1));
    let Error::Step {
        step: 1,
        body: 2,
        cause: StepFailure::Surface(SurfaceFailure::StepTooLong { reach, longest, h, .. }),
        ..
    } = error
    else {
        panic!("{error:?}")
    };
    assert!((reach - 1.2).abs() < 1e-12 && (longest - 1.0 / 12.0).abs() < 1e-12 && h == 0.1, "{error}");

    // Falling from the top the last one gets faster, until a later stage of a composition fails.
    let start =
        State::of([[0.0, 0.0, 1.0]; 3]).with_momenta([[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [1.0, 0.0, 0.0]]);
    let method = Composition::new(SUZUKI_1990_ORDER_4, 0.72);
    let error = failure_leaves_no_trace(sphere, start, method);
    assert!(matches!(error, Error::Step { body: 2, .. }), "{error:?}");
}

#[test]
fn two_effects_add_up() {
    let one = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let three =
        Scene::on(SURFACE).with(Gravity { g: 0.25 }).with(Gravity { g: 0.25 }).with(Gravity { g: 0.5 });
    let mut whole = one.simulate(billiard(0.7), Rattle::new(0.01)).unwrap();
    let mut parts = three.simulate(billiard(0.7), Rattle::new(0.01)).unwrap();
    assert!((parts.potential_energy() - SURFACE.r).abs() < 1e-16);
    whole.run(500).unwrap();
    parts.run(500).unwrap();
    assert_eq!(whole.position(), parts.position());
}

#[test]
fn trajectory_has_one_row_per_step() {
    let scene = Scene::on(Sphere { r: 1.0 }).with(Gravity { g: 1.0 }).bodies(3);
    let start = State::of([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]).with_momenta([
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.3, 0.0, 0.0],
    ]);
    let mut simulation = scene.simulate(start, Composition::new(SUZUKI_1990_ORDER_4, 0.05)).unwrap();
    let mut trajectory = Trajectory::with_multipliers(&simulation);
    for step in 1..=10_u32 {
        simulation.observe(1, 1, &mut trajectory).unwrap();
        assert_eq!(*trajectory.times().last().unwrap(), 0.05 * f64::from(step));
        let last: Vec<f64> = simulation.positions().flat_map(<[f64; 3]>::from).collect();
        assert_eq!(trajectory.positions()[9 * step as usize..], last);
    }
    let multipliers = trajectory.multipliers().unwrap();
    assert_eq!((trajectory.times().len(), trajectory.momenta().len()), (11, 99));
    assert_eq!((multipliers.position.len(), multipliers.momentum.len()), (33, 33));

    // A failed step leaves no half row.
    let scene = Scene::on(Sphere { r: 1.0 }).bodies(3);
    let mut simulation = scene.simulate(last_one_fails(), Rattle::new(0.1)).unwrap();
    let mut trajectory = Trajectory::with_multipliers(&simulation);
    simulation.observe(1, 1, &mut trajectory).unwrap_err();
    assert_eq!(trajectory.multipliers().unwrap().position.len(), 3);
}

#[test]
fn rounding_in_the_energy_does_not_add_up() {
    // The speed of a free particle on a sphere is constant: what is left is rounding. Compensated, 1e6 steps leave a
    // few ulps; without the low parts of momentum or position it is 5e-15 and more.
    let scene = Scene::on(Sphere { r: 1.0 });
    let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 0.6, 0.8]);
    let mut simulation = scene.simulate(start, Rattle::new(0.01)).unwrap();
    let mut largest = 0.0_f64;
    for _ in 0..100 {
        simulation.run(10_000).unwrap();
        largest = largest.max(simulation.energy_error().abs());
    }
    assert!(largest <= 3e-15, "{largest:e}");
}

#[test]
fn coefficients_that_are_no_composition_are_refused() {
    let bad = |gammas: &'static [f64]| Coefficients { name: "bad", order: 4, gammas };
    for gammas in [&[][..], &[0.5], &[0.3, 0.7], &[1.0, f64::NAN, 1.0], &[0.5, 0.0, 0.5]] {
        let method = Composition::new(bad(gammas), 0.01);
        let error = Scene::on(SURFACE).simulate(billiard(0.7), method).unwrap_err();
        assert!(matches!(error, Error::Coefficients { .. }), "{gammas:?}: {error}");
    }
    let method = Composition::new(SUZUKI_1990_ORDER_4, 0.0);
    assert_eq!(Scene::on(SURFACE).simulate(billiard(0.7), method).unwrap_err(), Error::StepSize(0.0));
    let surplus = State::at([0.0, 0.0, SURFACE.r]).with_momenta([[1.0, 0.0, 0.0]; 2]);
    let error = Scene::on(SURFACE).simulate(surplus, Rattle::new(0.01)).unwrap_err();
    assert_eq!(error, Error::MomentumCount { bodies: 1, momenta: 2 });
}

/// Momenta are counted as far as it takes: those of a vector all, those of an iterator without end until there is one
/// too many. Other momenta in their place are other momenta.
#[test]
fn momenta_are_counted_no_further_than_needed() {
    let two = || State::of([[0.0, 0.0], [1.0, 0.0]]);
    let scene = Scene::points(2);
    let refused = |state: State<2>| scene.simulate(state, Rattle::new(0.1)).unwrap_err();
    let mut drawn = 0;
    let endless = std::iter::repeat_with(|| {
        drawn += 1;
        [0.0, f64::from(drawn)]
    });
    let error = refused(two().with_momenta(endless));
    assert_eq!(error, Error::MomentumCount { bodies: 2, momenta: 3 });
    assert!(error.to_string().contains("at least 3") && drawn <= 3, "{error} {drawn}");
    let many = refused(two().with_momenta(vec![[0.0; 2]; 7]));
    assert_eq!(many, Error::MomentumCount { bodies: 2, momenta: 7 });
    let few = refused(two().with_momenta([[0.0; 2]]));
    assert_eq!(few.to_string(), "the state has 2 bodies and was given 1 momentum");

    let again = two().with_momenta([[5.0; 2]]).moving([1.0, 0.0]);
    let run = scene.simulate(again, Rattle::new(0.1)).unwrap();
    assert!(run.momenta().all(|p| (p.x, p.y) == (1.0, 0.0)));
}

/// On a surface as in a network of one: normal, and with the weight what turns the velocity.
#[test]
fn constraint_forces_of_a_surface() {
    let scene = Scene::on(Pendulum { length: 2.0 }).with(PlanarGravity { g: 9.0 });
    let bottom = State::at([0.0, -2.0]).moving([3.0, 0.0]);
    let simulation = scene.simulate(bottom.clone(), Rattle::new(0.01)).unwrap();
    // v²/ℓ + g upwards.
    assert_eq!(simulation.constraint_forces(), [rattle::nalgebra::vector![0.0, 13.5]]);
    let linked = scene.mass(1.0).simulate(bottom, Rattle::new(0.01)).unwrap();
    assert!(distance(linked.constraint_forces()[0], [0.0, 13.5]) < 1e-14);
}

/// The forces that a step evaluates, as the bill counts them.
#[test]
fn evaluations_are_counted_once_a_kick() {
    use rattle::{Geodesic, PositionVerlet, Shake};
    let h = 0.01;
    assert_eq!(Rattle::new(h).evaluations(), Some(1));
    assert_eq!(Geodesic::new(8, h).evaluations(), Some(1));
    assert_eq!(PositionVerlet::new(h).evaluations(), Some(1));
    assert_eq!(Shake::new(h).evaluations(), Some(1));
    assert_eq!(Composition::new(SUZUKI_1990_ORDER_4, h).evaluations(), Some(5));
    assert_eq!(Composition::of(SUZUKI_1990_ORDER_4, Geodesic::new(4, h)).evaluations(), Some(5));
    assert_eq!(Lobatto::<3>::new(h).evaluations(), None);
}

/// A state that remembers a method is still asked whether its momentum is along the constraint of another scene.
#[test]
fn momenta_of_another_scene_are_refused() {
    let method = Rattle::new(0.01).guess(LastMultiplier);
    let plane = Scene::on(rattle::surfaces::Plane { a: 0.0, b: 0.0, c: 1.0, d: 0.5 });
    let start = State::at([1.0, 0.0, 0.5]).moving([-1.0, 0.0, 0.0]);
    let start = plane.project(&start).unwrap();
    let mut simulation = plane.simulate(start, method).unwrap();
    simulation.run(2).unwrap();
    let q = simulation.position();
    let sphere = Scene::on(Sphere { r: q.norm() });
    let error = sphere.simulate(simulation.state(), method).unwrap_err().to_string();
    assert!(error.contains("tangent"), "{error}");
}
