//! Sheets that lie side by side: a step must not end on another one, however well everything there fits.
//!
//! `sin(k(t(q)))` is zero on the surfaces t = πj/k; every second one has the orientation of t = 0. What tells whether a particle is
//! still on t = 0 is t, which no simulation sees.

use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::potentials::Gravity;
use rattle::prelude::*;
use rattle::{Error, nalgebra::Vector3};
use rayon::prelude::*;

constraint! {
    /// Spheres.
    #[derive(Clone, Copy)]
    struct Shells { k }
    |x, y, z| sin(k * (sqrt(x^2 + y^2 + z^2) - 1))
}

/// How runs of so many steps ended.
#[derive(Debug, Default, PartialEq)]
struct Outcome {
    right: u32,
    refused: u32,
    wrong: u32,
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
        let mut simulation = scene.simulate(State::at(q).moving(p), method(h)).unwrap();
        let mut ended = None;
        for _ in 0..60 {
            if let Err(error) = simulation.step() {
                ended = Some(error);
                break;
            }
            if (simulation.position().norm() - 1.0).abs() > 1e-9 {
                outcome.wrong += 1;
                println!(
                    "k = {k:e}, h = {h}: {:e} after {} steps",
                    simulation.position().norm() - 1.0,
                    simulation.steps()
                );
                break;
            }
        }
        match ended {
            Some(Error::Step { .. }) => outcome.refused += 1,
            Some(other) => panic!("{other}"),
            None => outcome.right += 1,
        }
    }
    outcome.right -= outcome.wrong;
    println!("{outcome:?}");
    outcome
}

#[test]
fn rattle_stays_on_its_sheet() {
    assert_eq!(among_shells(1, 2000, Rattle::new).wrong, 0);
}

#[test]
fn other_iterations_and_guesses_stay_on_theirs() {
    assert_eq!(among_shells(2, 500, |h| Rattle::new(h).solved_by(Broyden)).wrong, 0);
    assert_eq!(among_shells(3, 500, |h| Rattle::new(h).guess(Extrapolated)).wrong, 0);
    assert_eq!(among_shells(4, 500, |h| Rattle::new(h).guess(LastMultiplier).solved_by(Symmetric)).wrong, 0);
}

#[test]
#[ignore = "some minutes"]
fn a_million_scenes_stay_on_their_sheets() {
    let wrong: u32 =
        (0..1000_u64).into_par_iter().map(|seed| among_shells(1000 + seed, 1000, Rattle::new).wrong).sum();
    assert_eq!(wrong, 0);
}

/// Particles that go several at a time.
#[test]
fn particles_stay_on_their_sheet() {
    let mut random = StdRng::seed_from_u64(5);
    let (mut right, mut refused, mut wrong) = (0, 0, 0);
    for _ in 0..200 {
        let k = 10_f64.powf(random.random_range(2.5..6.0));
        let h = 10_f64.powf(random.random_range(-1.7..-0.4));
        let scene = Scene::on(Shells { k }).bodies(20).with(Gravity { g: 1.0 });
        let mut vector = || Vector3::from_fn(|_, _| random.random_range(-1.0..1.0));
        let places: Vec<Vector3<f64>> = (0..20).map(|_| vector().normalize()).collect();
        let momenta: Vec<Vector3<f64>> = places.iter().map(|q| vector().cross(q)).collect();
        let mut simulation = scene.simulate(State::of(places).with_momenta(momenta), Rattle::new(h)).unwrap();
        let ended = simulation.run(60);
        wrong += simulation.positions().filter(|q| (q.norm() - 1.0).abs() > 1e-9).count();
        match ended {
            Ok(()) => right += 1,
            Err(Error::Step { .. }) => refused += 1,
            Err(other) => panic!("{other}"),
        }
    }
    println!("{right} right, {refused} refused, {wrong} particles on another sheet");
    assert_eq!(wrong, 0);
}
