//! Sheets that lie side by side: a step must not end on another one, however well everything there fits.
//!
//! `sin(k(t(q)))` is zero on the surfaces t = πj/k; every second one has the orientation of t = 0. What tells
//! whether a particle is
//! still on t = 0 is t, which no simulation sees.

use crate::common::outcome::Outcome;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::composition::*;
use rattle::nalgebra::Vector3;
use rattle::potentials::Gravity;
use rattle::prelude::*;
use rattle::surfaces::{Thylakoid, Torus};
use rayon::prelude::*;

constraint! {
    /// Spheres.
    #[derive(Clone, Copy)]
    struct Shells { k }
    |x, y, z| sin(k * (sqrt(x^2 + y^2 + z^2) - 1))
}

/// Random motion on the sphere among shells, by a method.
fn among_shells<S: Method>(seed: u64, runs: u32, method: impl Fn(f64) -> S) -> Outcome {
    let mut random = StdRng::seed_from_u64(seed);
    let mut outcome = Outcome::default();
    for _ in 0..runs {
        let k = 10_f64.powf(random.random_range(2.5..6.0));
        let h = 10_f64.powf(random.random_range(-1.7..-0.4));
        let mut vector = || Vector3::from_fn(|_, _| random.random_range(-1.0..1.0));
        let q = vector().normalize();
        let p = vector().cross(&q);
        let scene = Scene::on(Shells { k }).with(Gravity { g: 1.0 });
        let simulation = scene.simulate(State::at(q).moving(p), method(h)).unwrap();
        let off = |now: &Simulation<_, S, 3>| (now.position().norm() - 1.0).abs();
        outcome.watch(format_args!("k = {k:e}, h = {h}"), simulation, 60, off, 1e-9);
    }
    outcome
}

/// None is wrong, and so many are not refused: where shells are closer than a path in which a root can be followed,
/// it cannot.
fn stays<S: Method>(seed: u64, runs: u32, right: u32, method: impl Fn(f64) -> S) {
    among_shells(seed, runs, method).check(right);
}

#[test]
#[cfg(long)]
fn rattle_stays_on_its_sheet() {
    stays(1, 2000, 1250, Rattle::new);
}

#[test]
#[cfg(long)]
fn other_iterations_and_guesses_stay_on_theirs() {
    stays(2, 500, 310, |h| Rattle::new(h).solved_by(Broyden));
    stays(3, 500, 290, |h| Rattle::new(h).guess(Extrapolated));
    stays(4, 500, 310, |h| Rattle::new(h).guess(LastMultiplier).solved_by(Symmetric));
}

/// Steps of a composition differ in length: what a guess is off by grows and shrinks with h³, the distance of sheets
/// does not.
#[test]
#[cfg(long)]
fn compositions_stay_on_theirs() {
    stays(6, 1000, 500, |h| Composition::new(SUZUKI_1990_ORDER_4, h));
    stays(7, 1000, 500, |h| Composition::new(YOSHIDA_1990_ORDER_4, h));
    stays(8, 500, 250, |h| Composition::new(KAHAN_LI_1997_ORDER_8, h));
}

/// The rounding of g is hundreds of that of places where a tube is thin: no root is taken for lost because of it, and a
/// restart, of which nothing is remembered, goes on bit for bit.
#[test]
fn the_rounding_of_g_is_no_sheet() {
    for minor in [0.1, 0.01, 0.001] {
        for h in [1e-3 * minor, 1e-5, 1e-7] {
            let scene = Scene::on(Torus { major: 1.0, minor }).with(Gravity { g: 1.0 });
            let start = State::at([1.0 + minor, 0.0, 0.0]).moving([0.0, 0.3, 0.4]);
            let mut simulation = scene.simulate(start, Rattle::new(h)).unwrap();
            simulation.run(3000).unwrap();
            let now = simulation.state();
            simulation.run(3000).unwrap();
            let mut again = scene.simulate(now, Rattle::new(h)).unwrap();
            again.run(3000).unwrap();
            assert_eq!(again.position(), simulation.position(), "minor {minor}, h = {h:e}");
            assert_eq!(again.momentum(), simulation.momentum(), "minor {minor}, h = {h:e}");
        }
    }
    let shifted = Scene::on(Shifted { r: 1e6 });
    let slow = State::at([0.0; 3]).moving([1e-9, 0.0, 0.0]);
    shifted.simulate(slow, Rattle::new(0.01)).unwrap().run(1000).unwrap();
}

constraint! {
    /// A sphere through the origin.
    struct Shifted { r }
    |x, y, z| x^2 + y^2 + (z - r)^2 - r^2
}

/// Where curvature jumps, what a guess is off by grows late in a step; no step is refused for that.
#[test]
fn seams_are_no_sheets() {
    let mut random = StdRng::seed_from_u64(9);
    let scene = Scene::on(Thylakoid { width: 3.0, length: 10.0, flare: 3.0 });
    let somewhere = scene.project(&State::at([3.0, 0.1, 14.0]).moving([0.0, 0.0, 1.0])).unwrap();
    for _ in 0..300 {
        let across = Vector3::from_fn(|_, _| random.random_range(-1.0..1.0));
        let start = State::at(somewhere.positions().next().unwrap()).moving(across);
        let h = random.random_range(0.05..0.4);
        scene.simulate(scene.project(&start).unwrap(), Rattle::new(h)).unwrap().run(400).unwrap();
    }
}

#[test]
#[cfg(long)]
#[ignore = "some minutes"]
fn a_million_scenes_stay_on_their_sheets() {
    let wrong: u32 =
        (0..1000_u64).into_par_iter().map(|seed| among_shells(1000 + seed, 1000, Rattle::new).wrong).sum();
    assert_eq!(wrong, 0);
}

/// Random motion among three shells, by a method that does not follow its root.
fn among_three<S: Method>(
    seed: u64,
    runs: u32,
    steps: std::ops::Range<f64>,
    method: impl Fn(f64) -> S,
) -> Outcome {
    let mut random = StdRng::seed_from_u64(seed);
    let mut outcome = Outcome::default();
    for _ in 0..runs {
        let gap = 10_f64.powf(random.random_range(-3.5..-2.0));
        let h = random.random_range(steps.clone());
        let mut vector = || Vector3::from_fn(|_, _| random.random_range(-1.0..1.0));
        let q = vector().normalize();
        let p = 1.5 * vector().cross(&q);
        let scene = Scene::on(ThreeShells { gap }).with(Gravity { g: 1.0 });
        let mut simulation = scene.simulate(State::at(q).moving(p), method(h)).unwrap();
        let failure = simulation.run(60).err();
        let off = (simulation.position().norm() - 1.0).abs();
        if off > 0.5 * gap {
            println!("gap {gap:e}, h = {h}: {off:e} after {} steps, {failure:?}", simulation.steps());
        }
        outcome.note(off, failure.as_ref(), 0.5 * gap);
    }
    outcome
}

constraint! {
    /// Spheres of radius 1, and nearly.
    #[derive(Clone, Copy)]
    struct ThreeShells { gap }
    |x, y, z| {
        let off = sqrt(x^2 + y^2 + z^2) - 1;
        off * (off - gap) * (off + gap)
    }
}

#[test]
#[cfg(long)]
fn methods_that_follow_no_root_say_where_they_left_it() {
    among_three(11, 200, 0.05..0.8, Lobatto::<3>::new).check(75);
    among_three(12, 100, 0.05..1.0, Lobatto::<5>::new).check(50);
    among_three(13, 100, 0.05..1.0, Lobatto::<7>::new).check(50);
    among_three(14, 200, 0.02..0.5, |h| Taylor::new(3, h)).check(100);
    among_three(15, 200, 0.05..0.8, |h| Taylor::new(6, h)).check(110);
    among_three(16, 100, 0.05..0.8, Dop853::new).check(65);
    // Inner steps that lead as far astray as the shells are apart.
    among_three(17, 100, 0.5..3.0, |h| Dop853::adaptive(h, 1e-3)).check(70);
    among_three(18, 100, 0.5..3.0, |h| Taylor::adaptive(6, h, 1e-3)).check(90);
}
