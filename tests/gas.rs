//! Many bodies with forces between all pairs: forces against sums of one pair after the other, laws, and errors.

use crate::common::*;
use nalgebra::{SVector, vector};
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use rattle::Error;
use rattle::bodies::Many;
use rattle::effect::{Acting, BetweenPairs, Effect, Effects, Moment};
use rattle::error::StartFailure;
use rattle::potentials::Gaussian;
use rattle::prelude::*;
use rattle::surfaces::Sphere;
use std::array::from_fn;

pair_potential! {
    /// Odd, with a root and a pole.
    struct Screened { strength, length }
    |r| strength * exp(-r / length) / r
}

fn places<const D: usize>(n: usize) -> Vec<[f64; D]> {
    let mut random = SmallRng::seed_from_u64(n as u64);
    (0..n).map(|_| from_fn(|_| random.random_range(-1.0..1.0))).collect()
}

/// Each force against the sum of its pairs, of functions of the system's library; the error in units of the sum of
/// sizes.
fn forces_off<P: PairPotential, const D: usize>(potential: &P, n: usize) -> [f64; 2] {
    let places = places::<D>(n);
    let mut forces = vec![[0.0; D]; n];
    let acting = <P as Effect<D, BetweenPairs>>::acting::<f64>(potential);
    acting.add_forces(Moment { time: 0.0, positions: &places }, &mut (), &mut forces);
    let (mut worst, mut total, mut size) = (0.0_f64, [0.0; D], 0.0);
    for (i, q) in places.iter().enumerate() {
        let (mut expected, mut sizes) = ([0.0; D], 0.0);
        for other in places.iter().enumerate().filter(|&(j, _)| j != i).map(|(_, other)| other) {
            let apart: [f64; D] = from_fn(|d| q[d] - other[d]);
            let r = apart.iter().map(|x| x * x).sum::<f64>().sqrt();
            let pull = -potential.slope_over_distance(r);
            expected = from_fn(|d| expected[d] + pull * apart[d]);
            sizes += pull.abs() * r;
        }
        worst = worst.max(distance(forces[i], expected) / sizes);
        total = from_fn(|d| total[d] + forces[i][d]);
        size += sizes;
    }
    [worst, distance(total, [0.0; D]) / size]
}

#[test]
fn forces_are_those_of_the_pairs_and_add_up_to_nothing() {
    let mut worst = [0.0_f64; 2];
    for n in (2..40).chain([63, 64, 65, 66, 100, 127, 128, 129, 200, 333]) {
        let bell = Gaussian { height: 0.7, width: 0.6 };
        let screened = Screened { strength: 0.3, length: 0.4 };
        let rows = [
            forces_off::<_, 3>(&bell, n),
            forces_off::<_, 2>(&bell, n),
            forces_off::<_, 3>(&screened, n),
            forces_off::<_, 5>(&screened, n),
        ];
        for off in rows {
            // A pair rounds by some ε, and sums of n numbers in n/8 + 3 or n steps by as many halves at most, in
            // practice √n.
            assert!(off[0] < 1e-14 && off[1] < 1e-15, "{n} bodies: {off:?}");
            worst = from_fn(|k| worst[k].max(off[k]));
        }
    }
    println!("forces off by {:e}, their total {:e} of the sum of sizes", worst[0], worst[1]);
}

/// Energies against the sum of all pairs, of functions of the system's library, in units of the sum of sizes.
fn energy_off<P: PairPotential, const D: usize>(potential: &P, n: usize) -> f64 {
    let places = places::<D>(n);
    let acting = <P as Effect<D, BetweenPairs>>::acting::<f64>(potential);
    let energy = acting.energy(Moment { time: 0.0, positions: &places });
    let (mut expected, mut size) = (0.0, 0.0);
    for (i, q) in places.iter().enumerate() {
        for other in &places[..i] {
            let squares: f64 = q.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum();
            let value = PairPotential::value(potential, squares.sqrt());
            expected += value;
            size += value.abs();
        }
    }
    (energy - expected).abs() / size
}

#[test]
fn energies_are_those_of_the_pairs() {
    let mut worst = 0.0_f64;
    for n in (2..40).chain([63, 64, 65, 66, 100, 127, 128, 129, 200, 333]) {
        let bell = Gaussian { height: 0.7, width: 0.6 };
        let screened = Screened { strength: 0.3, length: 0.4 };
        for off in
            [energy_off::<_, 3>(&bell, n), energy_off::<_, 2>(&screened, n), energy_off::<_, 5>(&screened, n)]
        {
            // A pair rounds by some ε, the sum that it is compared with by n²/2 halves at most, in practice n/2.
            assert!(off < 1e-14, "{n} bodies: {off:e}");
            worst = worst.max(off);
        }
    }
    println!("energies off by {worst:e} of the sum of sizes");
}

/// So many that pairs are formed on several threads, where there are.
const FOR_THREADS: usize = 1100;

#[test]
fn any_number_of_threads_gives_the_same_bits_and_steps_do_not_allocate() {
    let sphere = Sphere { r: 20.0 };
    let scene = Scene::on(sphere).bodies(FOR_THREADS).with(Gaussian { height: 0.3, width: 1.5 });
    let places = places::<3>(FOR_THREADS);
    let start =
        scene.project(&State::of(places.iter().map(|q| SVector::from(*q).normalize() * 20.0))).unwrap();
    let run = || {
        let mut simulation = scene.simulate(start.clone(), Rattle::new(0.02)).unwrap();
        let allocated = allocation_counter::measure(|| simulation.run(3).unwrap());
        (bits(&simulation.state()), simulation.energy().to_bits(), allocated.count_total)
    };
    let alone = run();
    assert_eq!(alone.2, 0);
    for threads in [8, 3, 2, 1].into_iter().take(if cfg!(long) { 4 } else { 2 }) {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(pool.install(run), alone, "on {threads} threads");
    }
}

const BODIES: usize = 100;

/// A repelling gas on a sphere: bodies on a spiral, each moving its own way.
fn scene() -> Scene<Sphere, impl Effects<3>, Many, 3> {
    Scene::on(Sphere { r: 1.0 }).bodies(BODIES).with(Gaussian { height: 0.02, width: 0.5 })
}

fn start() -> State<3> {
    let place = |i: usize| -> SVector<f64, 3> {
        let (z, angle) = (1.0 - (2 * i + 1) as f64 / BODIES as f64, 2.4 * i as f64);
        let rho = (1.0 - z * z).sqrt();
        vector![rho * angle.cos(), rho * angle.sin(), z]
    };
    let spin = |i: usize| vector![(i as f64).sin(), (2.0 * i as f64).cos(), 0.3];
    let momenta = (0..BODIES).map(|i| 0.5 * spin(i).cross(&place(i)));
    scene().project(&State::of((0..BODIES).map(place)).with_momenta(momenta)).unwrap()
}

#[test]
fn laws_hold() {
    let errors = [0.02, 0.01, 0.005].map(|h| {
        let mut simulation = scene().simulate(start(), Rattle::new(h)).unwrap();
        let turning = |simulation: &Simulation<_, _, 3>| {
            let pairs = simulation.positions().zip(simulation.momenta());
            pairs.fold(vector![0.0, 0.0, 0.0], |sum, (q, p)| sum + q.cross(&p))
        };
        let (before, steps) = (turning(&simulation), (2.0 / h) as u64);
        let mut energy = 0.0_f64;
        simulation.run_with(steps, |now| energy = energy.max(now.energy_error().abs())).unwrap();
        // Pairs pull along the line between them, the sphere along its radius: all that turns is kept, but for
        // rounding.
        let lost = (turning(&simulation) - before).norm();
        assert!(lost < 1e-13, "h = {h}: {lost:e} of the angular momentum");
        assert!(simulation.constraint_residual() < 1e-15);
        energy
    });
    println!("energy errors {errors:?}");
    let order = order(&errors);
    assert!((1.8..2.2).contains(&order) && errors[0] > 1e-6, "order {order}, {errors:?}");
}

#[test]
fn the_way_back_leads_home() {
    let home = start();
    let mut there = scene().simulate(start(), Rattle::new(0.01)).unwrap();
    there.run(100).unwrap();
    let ways = there.positions().zip(home.positions()).map(|(a, b)| distance(a, b));
    assert!(ways.sum::<f64>() > 0.1 * BODIES as f64);
    let turned = State::of(there.positions()).with_momenta(there.momenta().map(|p| -p));
    let mut back = scene().simulate(turned, Rattle::new(0.01)).unwrap();
    back.run(100).unwrap();
    let gaps = back.positions().zip(home.positions()).map(|(a, b)| distance(a, b));
    let gap = gaps.fold(0.0, f64::max);
    println!("home to {gap:e}");
    // Compensated sums lose some ε² per step, forces some ε, which nothing here makes grow more than tenfold.
    assert!(gap < 1e-14, "{gap:e}");
}

#[test]
fn runs_and_restarts_are_the_same_to_the_bit_and_do_not_allocate() {
    let mut whole = scene().simulate(start(), Rattle::new(0.01)).unwrap();
    let mut first = scene().simulate(start(), Rattle::new(0.01)).unwrap();
    let allocations = allocation_counter::measure(|| whole.run(50).unwrap());
    assert_eq!(allocations.count_total, 0);
    first.run(20).unwrap();
    let mut second = scene().simulate(first.state(), Rattle::new(0.01)).unwrap();
    second.run(30).unwrap();
    assert_eq!(bits(&second.state()), bits(&whole.state()));
}

/// Two of many bodies at one place, where a force has a pole.
#[test]
fn a_force_that_is_no_number_is_found_and_named() {
    let scene = Scene::on(Sphere { r: 1.0 }).bodies(BODIES).with(Gaussian { height: 0.1, width: 0.5 });
    let scene = scene.with(Screened { strength: 0.3, length: 0.4 });
    let mut places: Vec<_> = start().positions().collect();
    places[70] = places[3];
    let error = scene.simulate(State::of(places), Rattle::new(0.01)).unwrap_err();
    println!("{error}");
    let Error::Start { body, cause } = error else { panic!("{error}") };
    assert_eq!(body, 3);
    assert!(matches!(cause, StartFailure::ForceNotFinite { effect, .. } if effect.ends_with("Screened")));
}
