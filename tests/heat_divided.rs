//! Baths where steps are divided, because they are too long, or at contacts and edges: random numbers are those of the
//! whole step, so that what a step meets does not choose among them.

use crate::common::larger;
use rattle::Error;
use rattle::effect::{
    Andersen, Langevin, LinearDrag, MagneticField, SelfPropulsion, Stop, VelocityRescaling,
};
use rattle::prelude::*;
use rattle::surfaces::Sphere;
use rattle::watch::{Mean, Sight};

constraint! {
    /// A box from 0 to 1.
    struct Room {}
    |x| x * (1 - x)
}

constraint! {
    /// Two slopes that meet in a ridge.
    struct Roof { k }
    |x, _y, z| z + k * abs(x)
}

const KT: f64 = 4.0;

fn bath() -> Langevin {
    Langevin { friction: 1.0, temperature: KT, seed: 3 }
}

/// 2 T/2 for the two momenta along the sphere, with its standard error: p has forgotten itself after a time of 2.
fn temperature<S: Method>(
    scene: &Scene<Sphere, impl rattle::effect::Effects<3>, rattle::bodies::One, 3>,
    method: S,
) -> f64 {
    let start = |i| scene.maxwell(&State::at([1.0, 0.0, 0.0]).numbered(i), KT, 5).unwrap();
    let mut ensemble = scene.ensemble((0..128).map(start), method).unwrap().retry(8);
    let mean = ensemble.observe(if cfg!(long) { 1000 } else { 250 }, 1, || {
        Mean::of(|now: &Sight<'_, 3>| 0.5 * now.momentum().norm_squared())
    });
    assert_eq!(ensemble.failures().count(), 0);
    mean.mean()
}

/// One step in some of these is too long: a third of all by g-BAOAB. When parts drew numbers of their own, temperatures
/// were 3.33, 3.62 and 3.62.
#[test]
fn fast_draws_are_as_frequent_as_they_should_be() {
    let scene = Scene::on(Sphere { r: 1.0 });
    let heated = scene.with(bath());
    let kicked = scene.with(Andersen { rate: 1.0, temperature: KT, seed: 3 });
    for (name, found) in [
        ("g-BAOAB", temperature(&heated, Baoab::new(0.4))),
        ("RATTLE", temperature(&heated, Rattle::new(0.2))),
        ("RATTLE, Andersen", temperature(&kicked, Rattle::new(0.2))),
    ] {
        // Of 128 000 momenta, of which those of a time of 2 are one sample, it is known to 0.04 or so, of a fourth of
        // them to twice that; draws are fixed.
        let bound = if cfg!(long) { 0.1 } else { 0.2 };
        assert!((found - KT).abs() < bound, "{name}: {found}");
    }
}

/// In lanes and alone, steps in parts are the same.
#[test]
fn parts_in_lanes_are_those_of_simulations() {
    fn check<S: Method>(
        scene: &Scene<Sphere, impl rattle::effect::Effects<3>, rattle::bodies::One, 3>,
        method: S,
    ) {
        let start = |i| scene.maxwell(&State::at([1.0, 0.0, 0.0]).numbered(i), KT, 5).unwrap();
        let mut ensemble = scene.ensemble((0..40).map(start), method.clone()).unwrap().retry(8);
        ensemble.run(12);
        let mut without = scene.ensemble((0..40).map(start), method.clone()).unwrap();
        without.run(12);
        assert!(without.failures().count() > 3, "{}", method.name());
        for i in 0..40 {
            let mut alone = scene.simulate(start(i), method.clone()).unwrap().retry(8);
            alone.run(12).unwrap();
            let state = ensemble.state(i as usize);
            let off = (state.positions().next().unwrap() - alone.position()).norm();
            let work = (ensemble.work(i as usize) - alone.work()).abs();
            assert!(off < 1e-10 && work < 1e-9, "{}, {i}: {off:e}, {work:e}", method.name());
        }
    }
    let scene = Scene::on(Sphere { r: 1.0 }).with(bath());
    check(&scene, Baoab::new(0.4));
    check(&scene, Rattle::new(0.4));
    let scene = scene.with(MagneticField::new([0.0, 0.0, 2.0]));
    check(&scene, Baoab::new(0.4));
    check(&scene, Rattle::new(0.4));
}

/// Beside a bath that does nothing, a field acts in each part of a step as it does without: not around all parts.
#[test]
fn flows_that_draw_nothing_act_in_parts() {
    let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 1.5, 0.5]);
    let scene = Scene::on(Sphere { r: 1.0 });
    let field = || MagneticField::new([0.0, 0.0, 2.0]);
    let (alone, h, steps) = (scene.with(field()), 1.5, 40);
    assert!(alone.simulate(start.clone(), Rattle::new(h)).unwrap().run(steps).is_err());
    let nothing = Langevin { friction: 1e-15, temperature: 0.0, seed: 3 };
    let beside = scene.with(nothing).with(field());
    let mut alone = alone.simulate(start.clone(), Rattle::new(h)).unwrap().retry(8);
    let mut lanes = beside.ensemble([start.clone()], Rattle::new(h)).unwrap().retry(8);
    let mut beside = beside.simulate(start, Rattle::new(h)).unwrap().retry(8);
    alone.run(steps).unwrap();
    beside.run(steps).unwrap();
    lanes.run(steps);
    let lane = lanes.state(0).positions().next().unwrap();
    for (name, place) in [("alone", beside.position()), ("in lanes", lane)] {
        assert!((place - alone.position()).norm() < 1e-10, "{name}: {place} for {}", alone.position());
    }
}

/// The step in parts has the noise of the whole step, to the bit.
#[test]
fn a_step_in_parts_is_a_finer_one() {
    let scene = Scene::on(Sphere { r: 1.0 }).with(bath());
    let start = |i| scene.maxwell(&State::at([1.0, 0.0, 0.0]).numbered(i), KT, 5).unwrap();
    let (mut divided, h) = (0, 0.4);
    for i in 0..600 {
        let Err(_) = scene.simulate(start(i), Baoab::new(h)).unwrap().run(1) else { continue };
        let mut parts = scene.simulate(start(i), Baoab::new(h)).unwrap().retry(1);
        let mut finer = scene.simulate(start(i), Baoab::with_inner(2, h)).unwrap();
        if parts.run(1).is_ok() {
            finer.run(1).unwrap();
            assert_eq!((parts.position(), parts.momentum()), (finer.position(), finer.momentum()), "{i}");
            divided += 1;
        }
    }
    assert!(divided > 5, "{divided}");
}

/// Walls turn momenta round, and do not cool. When they chose among random numbers, kT was 0.669 with this step.
#[test]
fn walls_do_not_cool() {
    let (kt, h, steps) = (0.7, 0.3, if cfg!(long) { 400_000 } else { 100_000 });
    let heat = |seed| Langevin { friction: 1.0, temperature: kt, seed };
    let scene = Scene::point().with(heat(1));
    let mut run = scene
        .simulate(State::at([0.5]).moving([0.5]), Rattle::new(h))
        .unwrap()
        .collide(Stop::above(Room {}).over([[0]]))
        .unwrap();
    let mut mean = Mean::of(|now: &Sight<'_, 1>| now.momentum().x.powi(2));
    run.observe(steps, 1, &mut mean).unwrap();
    assert!(run.events() > steps / 10);
    // p² has a standard deviation of √2 kT, and is forgotten in a time of 1/2.
    let bound = 4.0 * 2.0_f64.sqrt() * kt / (steps as f64 * h).sqrt();
    assert!((mean.mean() - kt).abs() < bound, "{} ± {bound:.3}", mean.mean());

    let again = Scene::point().with(heat(1)).simulate(State::at([0.5]), Baoab::new(h)).unwrap();
    let refused = again.collide(Stop::above(Room {}).over([[0]])).map(drop);
    assert!(matches!(refused, Err(Error::NoEvents { who: "g-BAOAB", .. })), "{refused:?}");
}

/// A bath that rescales the one momentum that there is keeps it going: at contacts it came to rest for ever.
#[test]
fn rescaling_goes_on_between_walls() {
    for seed in 0..6 {
        let scene = Scene::point().with(VelocityRescaling { time: 1.0, temperature: 0.7, seed });
        let mut run = scene
            .simulate(State::at([0.5]).moving([0.5]), Rattle::new(0.1))
            .unwrap()
            .collide(Stop::above(Room {}).over([[0]]))
            .unwrap();
        run.run(5000).unwrap();
        assert!(run.momentum().x != 0.0 && run.events() > 100, "{seed}: {} events", run.events());
    }
}

/// Over the ridge and back, for as long as one likes.
#[test]
fn heat_goes_over_edges() {
    for seed in 0..4 {
        let scene = Scene::on(Roof { k: 0.5 })
            .with(rattle::potentials::Harmonic { stiffness: 1.0, centre: [0.0; 3] })
            .with(Langevin { friction: 0.5, temperature: 0.5, seed });
        let start = State::at([-0.3, 0.0, -0.15]).moving([0.2, 0.1, 0.1]);
        let mut run = scene.simulate(start, Rattle::new(0.05)).unwrap().over_kinks().unwrap();
        run.run(4000).unwrap();
        assert!(run.events() > 20, "{seed}: {}", run.events());
    }
}

constraint! {
    /// What is to the left of a wall.
    struct Left {}
    |x, _y| x
}

force! {
    /// Towards the wall.
    struct Push {}
    |_x, _y| [-1, 0]
}

/// A bath that does nothing, and draws.
fn cold() -> Langevin {
    Langevin { friction: 0.0, temperature: 0.0, seed: 1 }
}

/// Beside a bath a constant push has a body bounce as a weight has: p²/2 + Fx stays, to the rounding of some hundred
/// impacts, since parabolas are exact.
#[test]
fn a_constant_push_between_impacts_is_exact() {
    for h in [0.083, 0.0415] {
        let scene = Scene::points::<2>(1).with(Push {}).with(cold());
        let run = scene.simulate(State::of([[0.5, 0.0]]), Rattle::new(h)).unwrap();
        let mut run = run.collide(Stop::above(Left {})).unwrap();
        let mut off = 0.0_f64;
        for _ in 0..(200.0 / h) as u32 {
            run.run(1).unwrap();
            let (q, p) = (run.positions().next().unwrap(), run.momenta().next().unwrap());
            off = larger(off, (0.5 * p.norm_squared() + q.x - 0.5).abs());
        }
        assert!(run.events() > 90, "{}", run.events());
        assert!(off < 1e-12, "{h}: {off:e}");
    }
}

/// Bodies that propel themselves against an elastic wall under drag come to it, and stay: with one impact a step at
/// most, no faster than what two steps give, 2F h, and no farther than that leads in one.
#[test]
fn active_bodies_stay_at_a_wall() {
    let push = SelfPropulsion::new(1.0, 0.0, 1).headed([[-1.0, 0.0]]);
    let scene = Scene::points::<2>(1).with(push).with(LinearDrag::new(2.0));
    let (h, steps) = (0.05, 4000);
    let mut run = scene.simulate(State::of([[0.5, 0.0]]), Rattle::new(h)).unwrap();
    run = run.collide(Stop::above(Left {})).unwrap();
    run.run(steps).unwrap();
    let (q, p) = (run.positions().next().unwrap(), run.momenta().next().unwrap());
    assert!(run.events() <= steps, "{}", run.events());
    assert!(q.x >= 0.0 && q.x < 2.0 * h * h && p.x.abs() < 2.0 * h, "{q} {p}");
}

/// Which numbers are drawn depends neither on what is met in a step nor on flows that draw nothing: a body without
/// charge far from a wall goes as without the wall, beside one with a charge that bounces.
#[test]
fn numbers_are_those_of_the_step_whatever_is_met() {
    let field = MagneticField::new([0.0, 0.0, 1.3]).charges([1.0, 0.0]);
    let start = || State::of([[0.3, 0.0], [100.0, 0.0]]).with_momenta([[-0.7, 0.2], [0.0, 0.0]]);
    let scene = Scene::points::<2>(2).with(field).with(bath());
    let mut free = scene.clone().simulate(start(), Rattle::new(0.1)).unwrap();
    let mut walled =
        scene.simulate(start(), Rattle::new(0.1)).unwrap().collide(Stop::above(Left {})).unwrap();
    free.run(100).unwrap();
    walled.run(100).unwrap();
    assert!(walled.events() > 0, "no impact");
    let [free, walled] =
        [free, walled].map(|run| (run.positions().nth(1).unwrap(), run.momenta().nth(1).unwrap()));
    let off = larger((free.0 - walled.0).norm(), (free.1 - walled.1).norm());
    assert!(off < 1e-11, "{off:e}: {walled:?} for {free:?}");
}

/// A bath that does nothing leaves a magnetic field between impacts where it was.
#[test]
fn a_bath_without_heat_changes_no_impacts() {
    let scene = Scene::points::<2>(1).with(MagneticField::new([0.0, 0.0, 1.3]));
    let start = || State::of([[0.2, 0.0]]).with_momenta([[-0.7, 0.2]]);
    let mut plain = scene.clone().simulate(start(), Rattle::new(0.1)).unwrap();
    let mut bathed = scene.with(cold()).simulate(start(), Rattle::new(0.1)).unwrap();
    plain = plain.collide(Stop::above(Left {})).unwrap();
    bathed = bathed.collide(Stop::above(Left {})).unwrap();
    plain.run(300).unwrap();
    bathed.run(300).unwrap();
    assert!(plain.events() > 5, "{}", plain.events());
    assert_eq!(plain.events(), bathed.events());
    let [off, turned] = [
        (plain.positions().next().unwrap() - bathed.positions().next().unwrap()).norm(),
        (plain.momenta().next().unwrap() - bathed.momenta().next().unwrap()).norm(),
    ];
    assert!(off < 1e-12 && turned < 1e-12, "{off:e} {turned:e}");
}
