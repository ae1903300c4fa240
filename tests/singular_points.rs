//! Singular points on the way: RATTLE and its relatives end there, and methods that know nothing of the constraint are
//! stopped.
//!
//! | way | without a look afterwards | expected |
//! |---|---|---|
//! | straight through the apex of a cone | on the other half, energy exact | no normal there, at the step across |
//! | past the apex by a hundredth of a step | energies of 1e25 and more | an error, or an accurate way around |
//! | a pinch | an energy of 0.3 becomes 1593 in one step | an error |
//! | a force that is no number where SHAKE arrives | seen a step later | an error in the step that leads there |
//! | a lane that fails at an apex, or where a force is no number | | rests where a simulation does |
//! | over a ridge rounded to less than a step | a tenth of the energy is left, or five times of it is there | an error |
//! | long steps, twisted strips, starts from rest, springs | | no error |

use crate::common::{Ridge, distance};
use rand::{RngExt, SeedableRng, rngs::SmallRng};
use rattle::Error;
use rattle::bodies::One;
use rattle::composition::SUZUKI_1990_ORDER_4;
use rattle::effect::Effects;
use rattle::ensemble::{Double, Precision, Single};
use rattle::error::{EffectFailure, MethodFailure, StepFailure};
use rattle::potentials::{Gravity, Harmonic, Spring};
use rattle::prelude::*;
use rattle::surfaces::{Helicoid, Lemniscate, Sphere};

constraint! {
    /// A double cone.
    struct Cone {}
    |x, y, z| x^2 + y^2 - z^2
}

/// What stopped a run of so long, if anything, and the largest energy error until then.
fn run<C: Constraint<3, 1>, S: Method>(
    surface: C,
    g: f64,
    start: [[f64; 3]; 2],
    method: S,
    time: f64,
) -> (Option<StepFailure>, f64) {
    let scene = Scene::on(surface).with(Gravity { g });
    let start = scene.project(&State::at(start[0]).moving(start[1])).unwrap();
    let mut simulation = scene.simulate(start, method.clone()).unwrap();
    let mut energy = 0.0_f64;
    let end = simulation.run_with((time / method.step_size()) as u64, |now| {
        energy = energy.max(now.energy_error().abs());
    });
    let cause = end.err().map(|error| match error {
        Error::Step { cause, .. } => cause,
        other => panic!("{other}"),
    });
    (cause, energy)
}

fn through_the_apex<S: Method>(method: S) {
    for g in [0.0, 1.0] {
        let name = method.name();
        let (cause, energy) = run(Cone {}, g, [[1.0, 0.0, 1.0], [-1.0, 0.0, -1.0]], method.clone(), 2.0);
        let Some(StepFailure::NoNormal { position, gradient }) = cause else { panic!("{name}: {cause:?}") };
        assert!(
            position.iter().chain(&gradient).all(|x| x.abs() < 0.02),
            "{name}: {position:?}, {gradient:?}"
        );
        assert!(energy < 1e-9, "{name}: {energy:e}");
    }
}

#[test]
fn an_apex_is_not_gone_through() {
    for h in [0.1, 0.03, 0.01] {
        through_the_apex(Dop853::new(h));
        through_the_apex(Dop853::adaptive(h, 1e-10));
        through_the_apex(Taylor::new(4, h));
        through_the_apex(Taylor::new(10, h));
        through_the_apex(Taylor::adaptive(12, h, 1e-12));
        through_the_apex(Bdf2::new(h));
    }
}

/// The second step ends at the apex, to the last bit.
#[test]
fn a_step_onto_an_apex_is_told() {
    fn onto<S: Method>(method: S) {
        let (name, scene) = (method.name(), Scene::on(Cone {}));
        let start = State::at([1.0, 0.0, 1.0]).moving([-1.0, 0.0, -1.0]);
        let mut ensemble = scene.ensemble([start.clone()], method.clone()).unwrap();
        ensemble.run(3);
        let alone = scene.simulate(start, method).unwrap().run(3).unwrap_err();
        for error in [&alone, ensemble.failures().next().unwrap().1] {
            let Error::Step { cause: StepFailure::NoNormal { position, gradient }, step: 2, .. } = error
            else {
                panic!("{name}: {error}")
            };
            assert!(position.iter().chain(gradient).all(|&x| x == 0.0), "{name}: {error}");
        }
    }
    onto(Rattle::new(0.5));
    onto(Shake::new(0.5));
    onto(Geodesic::new(2, 0.5));
}

/// Whatever goes on has an energy of the size that it had: 2, or less than that.
fn past_the_apex<S: Method>(method: &S, accurate: bool) -> bool {
    let mut ended = false;
    for g in [0.0, 1.0] {
        for aside in [1e-6, 1e-4, 1e-3, 0.05] {
            let start = [[1.0, 0.0, 1.0], [-1.0, aside, -1.0]];
            let (cause, energy) = run(Cone {}, g, start, method.clone(), 2.0);
            let most = if accurate { 1e-6 } else { 20.0 };
            assert!(
                energy < most,
                "{}, h = {}, {aside} aside: {energy:e}",
                method.name(),
                method.step_size()
            );
            ended |= cause.is_some();
        }
    }
    ended
}

#[test]
fn past_an_apex_no_energy_comes_from_nowhere() {
    for h in [0.1, 0.03] {
        assert!(past_the_apex(&Dop853::new(h), false));
        assert!(past_the_apex(&Taylor::new(4, h), false));
        assert!(past_the_apex(&Taylor::new(10, h), false));
        assert!(past_the_apex(&Bdf2::new(h), false));
        past_the_apex(&Dop853::adaptive(h, 1e-10), true);
        past_the_apex(&Taylor::adaptive(12, h, 1e-12), true);
    }
}

#[test]
fn a_pinch_gives_no_energy() {
    let pinched = Lemniscate { a: 1.0, r: 0.25 };
    for h in [0.1, 0.05, 0.03] {
        for aside in [0.0, 1e-3, 1e-2] {
            let start = [[0.5, 0.0, 0.2], [0.7, aside, 0.0]];
            for (cause, energy) in [
                run(pinched, 1.0, start, Taylor::new(4, h), 3.0),
                run(pinched, 1.0, start, Taylor::new(10, h), 3.0),
                run(pinched, 1.0, start, Dop853::new(h), 3.0),
            ] {
                assert!(energy < 3.0, "h = {h}, {aside} aside: {energy:e}, {cause:?}");
            }
        }
    }
}

#[test]
fn the_error_tells_where_the_energy_is_from() {
    let start = [[1.0, 0.0, 1.0], [-1.0, 1e-3, -1.0]];
    let (cause, _) = run(Cone {}, 0.0, start, Taylor::new(10, 0.1), 2.0);
    let Some(cause @ StepFailure::Method(MethodFailure::EnergyJump { before, after, given, .. })) = cause
    else {
        panic!("{cause:?}")
    };
    assert!(after > 4.0 * before && given == 0.0, "{cause}");
    assert!(cause.to_string().contains("look for a singular point"), "{cause}");
}

/// Long steps that turn the normal over, a strip that twists, starts from rest, and turning points.
#[test]
fn what_is_smooth_goes_on() {
    let around = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    for h in [1.0, 2.0, 3.0, 4.0] {
        let (cause, energy) = run(Sphere { r: 1.0 }, 0.0, around, Taylor::new(40, h), 100.0);
        assert!(cause.is_none() && energy < 1e-9, "h = {h}: {cause:?}, {energy:e}");
        let (cause, energy) = run(Sphere { r: 1.0 }, 1.0, around, Taylor::adaptive(20, h, 1e-13), 100.0);
        assert!(cause.is_none() && energy < 1e-9, "h = {h}: {cause:?}, {energy:e}");
        let (cause, energy) =
            run(Helicoid { c: 1.0 }, 0.0, [[0.0; 3], [0.0, 0.0, 1.0]], Dop853::new(h), 100.0);
        assert!(cause.is_none() && energy < 1e-9, "h = {h}: {cause:?}, {energy:e}");
    }
    let at_rest = [[1.0, 0.0, 0.0], [0.0; 3]];
    for (cause, _) in [
        run(Sphere { r: 1.0 }, 1.0, at_rest, Dop853::new(0.1), 100.0),
        run(Sphere { r: 1.0 }, 1.0, at_rest, Taylor::new(8, 0.1), 100.0),
        run(Sphere { r: 1.0 }, 1.0, at_rest, Bdf2::new(0.1), 100.0),
        run(Sphere { r: 1.0 }, 1.0, [[0.6, 0.0, 0.8], [0.0; 3]], Bdf2::new(0.01), 100.0),
    ] {
        assert_eq!(cause, None);
    }
}

potential! {
    /// No number beyond x = 0.
    struct Edge {}
    |x, _y, _z| sqrt(x)
}

fn ends_where_the_force_does<S: Method>(method: &S) {
    let scene = Scene::on(Sphere { r: 1.0 }).with(Edge {});
    let start = scene.project(&State::at([0.3, 0.0, 1.0]).moving([-1.0, 0.2, 0.0])).unwrap();
    let mut simulation = scene.simulate(scene.staggered(&start, method).unwrap(), method.clone()).unwrap();
    let error = simulation.run(1000).unwrap_err();
    assert!(
        matches!(
            &error,
            Error::Step { cause: StepFailure::Effect(EffectFailure::ForceNotFinite { .. }), .. }
        ),
        "{error}"
    );
    assert!(simulation.position().x >= 0.0 && simulation.energy().is_finite(), "{error}");

    let linked = Scene::points(2).link(rattle::links::Rod { length: 1.0 }, [[0, 1]]).with(Edge {});
    let start = State::of([[0.3, 0.0, 0.0], [0.3, 0.0, 1.0]]).moving([-1.0, 0.0, 0.0]);
    let mut simulation = linked.simulate(linked.staggered(&start, method).unwrap(), method.clone()).unwrap();
    let error = simulation.run(1000).unwrap_err();
    assert!(
        matches!(
            &error,
            Error::Step { cause: StepFailure::Effect(EffectFailure::ForceNotFinite { .. }), .. }
        ),
        "{error}"
    );
    assert!(simulation.energy().is_finite(), "{error}");
}

#[test]
fn a_force_is_looked_at_in_the_step_that_leads_there() {
    ends_where_the_force_does(&Rattle::new(0.03));
    ends_where_the_force_does(&Shake::new(0.03));
}

/// A lane that fails, between two that go on, rests where a simulation does.
fn rests<P: Precision, S: Method, C: Constraint<3, 1> + 'static, E: Effects<3> + 'static>(
    precision: P,
    method: &S,
    scene: &Scene<C, E, One, 3>,
    [fails, goes_on]: [State<3>; 2],
) {
    let [fails, goes_on] = [fails, goes_on].map(|start| scene.project(&start).unwrap());
    let mut alone = scene.simulate(fails.clone(), method.clone()).unwrap();
    let Err(Error::Step { step, .. }) = alone.run(100) else { panic!("no way") };
    let mut ensemble =
        scene.ensemble_in(precision, [goes_on.clone(), fails, goes_on], method.clone()).unwrap();
    ensemble.run(100);
    assert_eq!(ensemble.failures().map(|(i, _)| i).collect::<Vec<_>>(), [1]);
    let Some(Error::Step { step: found, cause, .. }) = ensemble.failure(1) else { panic!("a step") };
    let state = ensemble.state(1);
    let (q, p) = (state.positions().next().unwrap(), state.momenta().next().unwrap());
    assert_eq!(*found, step, "{cause}");
    assert!(q.iter().chain(p.iter()).all(|x| x.is_finite()), "{}: {q} {p}", method.name());
    let off = distance(q, alone.position()).max(distance(p, alone.momentum()));
    assert!(off < 1e-6, "{}: {q} {p}, {off:e}", method.name()); // of Single
}

#[test]
fn a_lane_rests_in_its_last_good_state() {
    let along = |v: f64| State::at([1.0, 0.0, 1.0]).moving([v, 0.0, v]);
    let cone = Scene::on(Cone {});
    let edge = Scene::on(Sphere { r: 1.0 }).with(Edge {});
    for v in [1.0, 0.7] {
        let pair = || [along(-v), along(v)];
        rests(Double, &Rattle::new(0.125), &cone, pair());
        rests(Single, &Rattle::new(0.125), &cone, pair());
    }
    for x in [0.3, 0.0] {
        let pair = || [State::at([x, 0.0, 1.0]).moving([-1.0, 0.2, 0.0]), State::at([1.0, 0.0, 0.0])];
        rests(Double, &Rattle::new(0.03), &edge, pair());
        rests(Double, &SymplecticEuler::new(0.03), &edge, pair());
    }
}

/// Near rest the kinetic energy of a step is less than the rounding of the potential energy: it does not come from
/// nowhere.
#[test]
fn small_motion_near_rest_is_no_energy_from_nowhere() {
    let bottom = |angle: f64| [angle.sin(), 0.0, -angle.cos()];
    let scene = Scene::on(Sphere { r: 1.0 }).with(Gravity { g: 9.81 });
    for angle in [0.0, 1e-9, 1e-7, 1e-5] {
        let start = || State::at(bottom(angle));
        for h in [1e-4, 0.01] {
            scene.simulate(start(), Dop853::new(h)).unwrap().run(500).unwrap();
            scene.simulate(start(), Taylor::new(8, h)).unwrap().run(500).unwrap();
            scene.simulate(start(), Bdf2::new(h)).unwrap().run(500).unwrap();
        }
    }
}

/// Energies of what went on over a ridge, as parts of those before, and how many were refused.
fn over_a_ridge<S: Method>(s: f64, method: &S) -> (Vec<f64>, usize) {
    let mut draw = SmallRng::seed_from_u64(7);
    let (mut energies, mut refused) = (Vec::new(), 0);
    for _ in 0..40 {
        let (x, v, along) =
            (draw.random_range(-0.3..-0.2), draw.random_range(0.5..1.5), draw.random_range(-0.5..0.5));
        let scene = Scene::on(Ridge { s });
        let start = scene.project(&State::at([x, 0.0, x]).moving([v, along, v])).unwrap();
        let mut simulation = scene.simulate(start, method.clone()).unwrap();
        let before = simulation.energy();
        match simulation.run(20) {
            Ok(()) => energies.push(simulation.energy() / before),
            Err(Error::Step { .. }) => refused += 1,
            Err(other) => panic!("{other}"),
        }
    }
    (energies, refused)
}

/// A ridge rounded to much less than a step is not seen in the step that leads across: methods without structure took a
/// tenth of the energy on, or five times of it, and said nothing.
#[test]
fn over_a_ridge_no_energy_comes_or_goes() {
    fn check<S: Method>(method: S) {
        for s in [0.03, 1e-2, 3e-3, 1e-3, 1e-5, 1e-7] {
            let (energies, refused) = over_a_ridge(s, &method);
            let (least, most) =
                energies.iter().fold((1.0, 1.0), |(a, b), &e| (f64::min(a, e), f64::max(b, e)));
            println!("{}, s = {s:e}: {refused} refused, {least:.3} to {most:.3}", method.name());
            assert!(least > 0.4 && most < 2.25, "{}, s = {s:e}: {least:.3} to {most:.3}", method.name());
        }
        assert_eq!(over_a_ridge(1.0, &method).1, 0, "{}: none is refused where none is sharp", method.name());
    }
    check(Rattle::new(0.03));
    check(Composition::new(SUZUKI_1990_ORDER_4, 0.03));
    check(Lobatto::<3>::new(0.03));
    check(Lobatto::<5>::new(0.03));
    check(Taylor::new(4, 0.03));
    check(Taylor::new(8, 0.03));
    check(Taylor::adaptive(8, 0.03, 1e-9));
    check(Dop853::new(0.03));
    check(Dop853::adaptive(0.03, 1e-9));
    check(Bdf2::new(0.03));
}

potential! {
    /// Gravity from the bottom of a unit sphere, where its terms cancel.
    struct FromBottom { g }
    |_x, _y, z| g * (z + 1)
}

/// Small swings have less energy than a potential is rounded to whose terms cancel: what it says has not jumped.
#[test]
fn rounding_of_a_potential_is_no_jump() {
    fn check<S: Method>(method: S) {
        let scene = Scene::on(Sphere { r: 1.0 }).with(FromBottom { g: 1.0 });
        for speed in [1e-12, 1e-9, 1e-7] {
            let start = State::at([0.0, 0.0, -1.0]).moving([speed, 0.0, 0.0]);
            let mut simulation = scene.simulate(start, method.clone()).unwrap();
            simulation.run(300).unwrap_or_else(|error| panic!("{}, {speed:e}: {error}", method.name()));
        }
        let spring = Spring { stiffness: 1.0, length: 1.0 }.over([[0, 1]]);
        let pair = Scene::points::<3>(2).with(spring);
        let start = State::of([[0.1, 0.2, 0.3], [0.1 + 0.6, 0.2 + 0.8, 0.3]]);
        pair.simulate(start, method.clone()).unwrap().run(100).unwrap();
        // At rest at the centre of a trap, but for rounding.
        let trap = Harmonic { stiffness: 1.0, centre: [0.6, 0.0, 0.8] };
        let start = scene.project(&State::at([0.6, 0.0, 0.8])).unwrap();
        Scene::on(Sphere { r: 1.0 }).with(trap).simulate(start, method.clone()).unwrap().run(100).unwrap();
    }
    for h in [0.02, 0.1] {
        check(Lobatto::<2>::new(h));
        check(Lobatto::<3>::new(h));
        check(Taylor::new(8, h));
        check(Dop853::new(h));
        check(Dop853::adaptive(h, 1e-10));
    }
}

/// From where a surface is nearly flat Newton's step leads far beyond it: up to 1e20 times as far as it is away.
#[test]
fn projections_from_flat_places_do_not_run_away() {
    for n in [8.0, 20.0, 40.0, 100.0] {
        constraint! {
            struct Cushion { n }
            |x, y, z| abs(x)^n + abs(y)^n + abs(z)^n - 1
        }
        let scene = Scene::on(Cushion { n });
        let start = State::at([0.5, 0.6, 0.3]).moving([0.1, 0.2, 0.3]);
        let on = scene.project(&start).unwrap_or_else(|error| panic!("{n}: {error}"));
        let q = on.positions().next().unwrap();
        assert!((0.98..=1.0).contains(&q.amax()), "{n}: {q:?}");
        scene.simulate(on, Rattle::new(1e-3)).unwrap();
    }
}

/// On the other side of an edge the gradient is as long: that it stays so is no sign that g does.
#[test]
fn projections_over_edges_end_on_the_surface() {
    constraint! {
        struct Octahedron {}
        |x, y, z| abs(x) + abs(y) + abs(z) - 1
    }
    constraint! {
        /// A slope of 10 below 0.4, and of 1 above.
        struct Bent {}
        |x, _y, z| z + 4.5 * ((z - 0.4) - abs(z - 0.4)) + 0 * x
    }
    for start in [[1.1, 0.02, 0.01], [3.0, 0.1, 0.1], [0.2, 0.3, 0.1], [-2.0, 1e-9, 0.5]] {
        let scene = Scene::on(Octahedron {});
        let on = scene.project(&State::at(start)).unwrap_or_else(|error| panic!("{start:?}: {error}"));
        scene.simulate(on, Rattle::new(1e-6)).unwrap_or_else(|error| panic!("{start:?}: {error}"));
    }
    let on = Scene::on(Bent {}).project(&State::at([0.0, 0.0, 1.0])).unwrap();
    assert!((on.positions().next().unwrap().z - 0.36).abs() < 1e-15);
}
