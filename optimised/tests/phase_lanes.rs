//! Trajectories in phase space in lanes: on their sheets, and for long.

use crate::common::outcome::Outcome;
use crate::phase_sheets::{
    Level, Rings, Shells, Three, TurningShells, WavyShells, momentum, radius, sum_of_squares, wavy,
};
use crate::phase_space::{Charge, Falling, Hopf, Uneven3};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::bodies::One;
use rattle::composition::{KAHAN_LI_1997_ORDER_8, SUZUKI_1990_ORDER_4};
use rattle::phase::PhaseSpace;
use rattle::prelude::*;
use rayon::prelude::*;

/// As `phase_sheets` has it for simulations: random scenes and starts, as many sweeps of forty, each by a step of its
/// own.
fn stay<G, H, S, const D: usize, const M: usize>(
    seed: u64,
    sweeps: u32,
    scene: impl Fn(f64) -> Scene<PhaseSpace<G, H, M>, (), One, D>,
    levels: &[Level<D>],
    method: impl Fn(f64) -> S,
) -> Outcome
where
    G: PhaseConstraint<D, M> + 'static,
    H: Hamiltonian<D> + 'static,
    S: Method,
{
    let mut random = StdRng::seed_from_u64(seed);
    let mut outcome = Outcome::default();
    for _ in 0..sweeps {
        let method = method(10_f64.powf(random.random_range(-2.5..-0.3)));
        let (mut scenes, mut starts, mut far) = (Vec::new(), Vec::new(), Vec::new());
        while scenes.len() < 40 {
            let k = 10_f64.powf(random.random_range(0.5..4.5));
            let [q, p] = [0, 1].map(|_| std::array::from_fn::<f64, D, _>(|_| random.random_range(-0.9..0.9)));
            let scene = scene(k);
            let Ok(start) = scene.project(&State::at(q).moving(p)) else { continue };
            if scene.simulate(start.clone(), method.clone()).is_ok() {
                scenes.push(scene);
                starts.push(start);
                far.push(0.3 / k);
            }
        }
        let mut sweep = Ensemble::sweep(Double, scenes.iter().zip(starts.clone()), method).unwrap();
        let level = |state: &State<D>, level: &Level<D>| {
            let [q, p] = [state.positions().next().unwrap(), state.momenta().next().unwrap()];
            level([q.into(), p.into()])
        };
        let mut most = vec![0.0_f64; starts.len()];
        for _ in 0..40 {
            sweep.run(1);
            for (i, most) in most.iter_mut().enumerate() {
                let off = |of: &Level<D>| (level(&sweep.state(i), of) - level(&starts[i], of)).abs();
                *most = levels.iter().map(off).fold(*most, |most, off| if off <= most { most } else { off });
            }
        }
        for (i, (&off, &far)) in most.iter().zip(&far).enumerate() {
            outcome.note(off, sweep.failure(i), far);
        }
    }
    println!("seed {seed}: {outcome:?}");
    outcome
}

fn families(seed: u64, sweeps: u32) -> [Outcome; 7] {
    let suzuki = |h| Composition::new(SUZUKI_1990_ORDER_4, h);
    let (falling, charge, uneven) = (Falling { g: 0.3 }, Charge { b: 0.4, g: 0.3 }, Uneven3 { g: 0.3 });
    let shells = |k| Scene::in_phase_space(Shells { k }, falling);
    let charged = |k| Scene::in_phase_space(Shells { k }, charge);
    let wavy_shells = |k| Scene::in_phase_space(WavyShells { k }, falling);
    let three = |k| Scene::in_phase_space(Three { apart: 1.0 / k }, falling);
    let rings = |k| Scene::in_phase_space(Rings { k }, falling);
    let turning = |k| Scene::in_phase_space(TurningShells { k, l: 0.2 }, uneven);
    [
        stay(seed, sweeps, shells, &[sum_of_squares], Rattle::new),
        stay(seed + 1, sweeps, charged, &[sum_of_squares], Rattle::new),
        stay(seed + 2, sweeps, wavy_shells, &[wavy], Rattle::new),
        stay(seed + 3, sweeps, three, &[sum_of_squares], Rattle::new),
        stay(seed + 4, sweeps, rings, &[radius], Rattle::new),
        stay(seed + 5, sweeps, turning, &[sum_of_squares, momentum], Rattle::new),
        stay(seed + 6, sweeps, shells, &[sum_of_squares], suzuki),
    ]
}

#[test]
#[cfg(long)]
fn lanes_stay_on_their_sheets() {
    families(1, 1).iter().for_each(|outcome| outcome.check(13));
    let rings = |k| Scene::in_phase_space(Rings { k }, Falling { g: 0.3 });
    stay(1004, 5, rings, &[radius], Rattle::new).check(100);
}

/// `cargo long --test phase phase_lanes::many -- --ignored`
#[test]
#[cfg(long)]
#[ignore = "some minutes"]
fn many_lanes_stay_on_their_sheets() {
    let wrong = |seed: u64| families(1000 + 7 * seed, 5).iter().map(|outcome| outcome.wrong).sum::<u32>();
    assert_eq!((0..20).into_par_iter().map(wrong).sum::<u32>(), 0);
}

/// Rounding does not add up, and constraints hold, as in simulations: a step of order 8 has an error of its own of some
/// 1e-16, and sums are compensated.
#[test]
#[cfg(long)]
fn energy_stays_and_constraints_hold() {
    let scene = Scene::in_phase_space(Hopf {}, Falling { g: 0.3 });
    let start = |i: u32| {
        let e = 1.0 + 2e-3 * f64::from(i);
        scene.project(&State::at([-0.55 / e, -0.83 * e]).moving([0.03, 0.02])).unwrap()
    };
    let starts: Vec<_> = (0..16).map(start).collect();
    let method = Composition::new(KAHAN_LI_1997_ORDER_8, 0.05);
    let mut ensemble = scene.ensemble(starts.iter().cloned(), method).unwrap();
    ensemble.run(8_000);
    for (i, start) in starts.into_iter().enumerate() {
        let before = scene.simulate(start, method).unwrap().energy();
        let now = scene.simulate(ensemble.state(i), method).unwrap();
        let (off, g, hidden) = (now.energy() - before, now.constraint_residual(), now.cotangent_residual());
        println!("{i}: energy {off:e}, g {g:e}, {{g, H}} {hidden:e}");
        assert!(off.abs() <= 1e-15 && g <= 2e-15 && hidden <= 3e-15, "{i}: {off:e}, {g:e}, {hidden:e}");
    }
}
