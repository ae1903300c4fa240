//! Splittings of kicks and drifts, compositions of them, and collocation, in lanes: as each trajectory alone but for
//! rounding.

use crate::common::{Trough, larger};
use rattle::composition::SUZUKI_1990_ORDER_4;
use rattle::ensemble::InstructionSet;
use rattle::method::Method;
use rattle::prelude::*;
use rattle::surfaces::Lemniscate;

const R: f64 = 1.0 / 6.0;

fn starts() -> Vec<State<3>> {
    let angle = |i: i32| 0.1 * f64::from(i);
    (0..70).map(|i| State::at([0.0, 0.0, R]).moving([angle(i).cos(), angle(i).sin(), 0.0])).collect()
}

fn off<P: Precision, S: Method>(precision: P, method: S, steps: u64) -> f64 {
    let scene = Scene::on(Lemniscate { a: 1.0, r: R }).with(Trough { g: 1.0 });
    let mut ensemble = scene.ensemble_in(precision, starts(), method.clone()).unwrap();
    ensemble.run(steps);
    let apart = starts().into_iter().enumerate().map(|(i, start)| {
        let mut simulation = scene.simulate(start, method.clone()).unwrap();
        simulation.run(steps).unwrap();
        let state = ensemble.state(i);
        let (q, p) = (state.positions().next().unwrap(), state.momenta().next().unwrap());
        assert_eq!(state.time(), simulation.time());
        (q - simulation.position()).norm().max((p - simulation.momentum()).norm())
    });
    apart.fold(0.0, larger)
}

#[test]
fn as_alone_but_for_rounding() {
    let found = [
        off(Double, PositionVerlet::new(0.01), 50),
        off(Double, SymplecticEuler::new(0.01), 50),
        off(Double, Geodesic::new(1, 0.01), 50),
        off(Double, Geodesic::new(3, 0.02), 25),
        #[cfg(long)]
        off(Compensated, Geodesic::new(3, 0.02), 25),
        off(Compensated, PositionVerlet::new(0.01), 50),
        off(Double, Composition::of(SUZUKI_1990_ORDER_4, PositionVerlet::new(0.02)), 25),
        off(Double, Rattle::new(0.01), 50),
        off(Double, Composition::new(SUZUKI_1990_ORDER_4, 0.02), 25),
        #[cfg(long)]
        off(Double, Lobatto::<2>::new(0.01), 50),
        off(Double, Lobatto::<3>::new(0.01), 50),
        #[cfg(long)]
        off(Compensated, Lobatto::<3>::new(0.01), 50),
        #[cfg(long)]
        off(Double, Lobatto::<5>::new(0.02), 25),
        off(Compensated, Lobatto::<5>::new(0.02).guess(Extrapolated), 25),
        #[cfg(long)]
        off(Double, Lobatto::<9>::new(0.05), 10),
    ];
    println!("{found:?}");
    let fused = InstructionSet::widest().fuses(); // else all go alone, and nothing differs
    assert!(found.iter().all(|&off| off < 1e-12 && (off > 0.0) == fused), "{found:?}");
    assert!(off(Single, PositionVerlet::new(0.01), 50) < 1e-3);
    #[cfg(long)]
    assert!(off(Single, Lobatto::<4>::new(0.02), 25) < 1e-3);
}

potential! {
    /// No number beyond x = 0.1.
    struct Cliff {}
    |x, _y, _z| (0.1 - x)^2.5
}

/// A kick in the middle of a step that is not a number is told of as by a simulation, not as a constraint that is none.
#[test]
fn forces_that_end_in_the_middle_of_a_step() {
    let scene = Scene::on(Lemniscate { a: 1.0, r: R }).with(Cliff {});
    let fast = || State::at([0.0, 0.0, R]).moving([1.0, 0.0, 0.0]);
    let mut ensemble = scene.ensemble(vec![fast(); 3], PositionVerlet::new(0.02)).unwrap();
    ensemble.run(20);
    let mut alone = scene.simulate(fast(), PositionVerlet::new(0.02)).unwrap();
    let words = |error: &rattle::Error| error.to_string();
    let alone = words(&alone.run(20).unwrap_err());
    assert!(alone.contains("the force of `Cliff` is [NaN"), "{alone}");
    let message = words(ensemble.failure(1).unwrap());
    assert_eq!(message.split(" at q").next(), alone.split(" at q").next());
}

#[test]
fn sweeps_and_energies() {
    let scenes: Vec<_> = (0..70)
        .map(|i| Scene::on(Lemniscate { a: 1.0, r: R }).with(Trough { g: 0.02 * f64::from(i) }))
        .collect();
    let mut ensemble =
        Ensemble::sweep(Double, scenes.iter().zip(starts()), PositionVerlet::new(0.01)).unwrap();
    let mean = ensemble.observe(500, 5, || Mean::of(|now: &Sight<'_, 3>| now.energy()));
    let exact: f64 = (0..70).map(|i| 0.5 + 0.02 * f64::from(i) * R).sum::<f64>() / 70.0;
    assert!((mean.mean() - exact).abs() < 1e-3, "{} {exact}", mean.mean());
}

/// More than two rows of scenes that differ, the last row with one trajectory.
#[test]
fn sweeps_by_stages() {
    let scene = |i: usize| Scene::on(Lemniscate { a: 1.0, r: R }).with(Trough { g: 0.02 * i as f64 });
    let start = || State::at([0.0, 0.0, R]).moving([0.6, 0.8, 0.0]);
    let scenes: Vec<_> = (0..65).map(scene).collect();
    let starts = scenes.iter().map(|scene| (scene, start()));
    let mut ensemble = Ensemble::sweep(Double, starts, Lobatto::<3>::new(0.01)).unwrap();
    ensemble.run(50);
    for (i, scene) in scenes.iter().enumerate() {
        let mut alone = scene.simulate(start(), Lobatto::<3>::new(0.01)).unwrap();
        alone.run(50).unwrap();
        let off = (ensemble.state(i).positions().next().unwrap() - alone.position()).norm();
        assert!(off < 1e-12, "{i}: {off:e}");
    }
}

/// Trajectories too fast for their steps end; calm ones beside them have the bits that they have without them, also
/// where a checkpoint is gone on from.
#[test]
fn stages_that_fail_touch_no_one_else() {
    let scene = Scene::on(Lemniscate { a: 1.0, r: R }).with(Trough { g: 1.0 });
    let start = |i: u32| {
        let (speed, angle) = (if i.is_multiple_of(3) { 12.0 } else { 1.0 }, 0.37 * f64::from(i));
        State::at([0.0, 0.0, R]).moving([speed * angle.cos(), speed * angle.sin(), 0.0])
    };
    let of =
        |numbers: Vec<u32>| scene.ensemble(numbers.into_iter().map(start), Lobatto::<3>::new(0.02)).unwrap();
    let bits = |state: State<3>| format!("{state:?}");
    let mut all = of((0..50).collect());
    all.run(150);
    let record = all.checkpoint();
    all.run(150);
    let calm: Vec<u32> = (0..50).filter(|i| i % 3 != 0).collect();
    let mut calm_ones = of(calm.clone());
    calm_ones.run(300);
    let mut resumed = of((0..50).collect());
    resumed.resume(&record).unwrap();
    resumed.run(150);
    for (i, state) in calm.into_iter().zip(calm_ones.states()) {
        let expected = bits(state);
        assert_eq!(bits(all.state(i as usize)), expected, "trajectory {i}");
        assert_eq!(bits(resumed.state(i as usize)), expected, "trajectory {i} resumed");
    }
    let ended = all.failures().map(|(i, _)| i).collect::<Vec<_>>();
    assert!(ended.len() > 5 && ended.iter().all(|i| i % 3 == 0), "{ended:?}");
}

/// Halved steps leave 2^-(2s - 2) of the error; the reference is of twice the order, alone.
#[test]
fn stages_have_their_order() {
    fn errors<const S: usize>(steps: [u64; 2]) -> f64
    where
        Lobatto<S>: Method,
        rattle::table::Table<S>: rattle::table::Tabulated,
    {
        let scene = Scene::on(Lemniscate { a: 1.0, r: R }).with(Trough { g: 1.0 });
        let start = || State::at([0.0, 0.0, R]).moving([0.6, 0.8, 0.0]);
        let mut exact = scene.simulate(start(), Lobatto::<9>::new(1.0 / 64.0)).unwrap();
        exact.run(32).unwrap();
        let [one, two] = steps.map(|steps| {
            let mut ensemble =
                scene.ensemble([start(), start()], Lobatto::<S>::new(0.5 / steps as f64)).unwrap();
            ensemble.run(steps);
            (ensemble.state(1).positions().next().unwrap() - exact.position()).norm()
        });
        (one / two).log2()
    }
    let found = [
        #[cfg(long)]
        (2.0, errors::<2>([32, 64])),
        (4.0, errors::<3>([16, 32])),
        #[cfg(long)]
        (6.0, errors::<4>([16, 32])),
        #[cfg(long)]
        (8.0, errors::<5>([16, 32])),
    ];
    println!("{found:?}");
    for (expected, order) in found {
        assert!((order - expected).abs() < 0.6, "{order}, not {expected}"); // steps are far from vanishing
    }
}

constraint! {
    /// An ellipsoid of axes 1, 1/2 and 1/5.
    struct Ellipsoid {}
    |x, y, z| x^2 + 4 * y^2 + 25 * z^2 - 1
}

/// Of starts from which a step is too long for the curvature, h·κ·|v| > 1, lanes refuse those that simulations refuse.
#[test]
fn too_long_a_first_step_is_refused() {
    let scene = Scene::on(Ellipsoid {});
    let starts: Vec<_> = (0..500_u32)
        .filter_map(|i| {
            let turn = |rate: f64, by: f64| (rate * f64::from(i) + by).sin();
            let place = [turn(1.1, 0.3), 0.5 * turn(1.9, 1.0), 0.2 * turn(0.7, 0.1)];
            scene.project(&State::at(place).moving([turn(1.7, 0.0), turn(2.3, 2.5), turn(0.7, 2.0)])).ok()
        })
        .collect();
    let mut refused = 0;
    for h in [0.05, 0.1] {
        let mut ensemble = scene.ensemble(starts.iter().cloned(), Rattle::new(h)).unwrap();
        ensemble.run(1);
        for (i, start) in starts.iter().enumerate() {
            let mut alone = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
            let error = alone.run(1).err();
            refused += usize::from(error.is_some());
            assert_eq!(ensemble.failure(i).is_some(), error.is_some(), "{i} by {h}: {error:?}");
        }
    }
    println!("{refused} of {}", 2 * starts.len());
    assert!(starts.len() > 400 && refused > 30, "{refused}");
}

constraint! {
    /// Two branches of a hyperbola, with a neck between them of half this width.
    struct Neck { r }
    |x, z| x^2 - z^2 - r^2
}

/// Where places come nearer to the origin they stay on the surface as nearly as their numbers tell: what may be left of
/// a correction is found every 64 steps, from farther out.
#[test]
fn necks_are_passed_on_the_surface() {
    fn farthest<P: Precision>(precision: P, rounding: f64, r: f64, share: f64) -> f64 {
        let scene = Scene::on(Neck { r });
        let starts = (0..64).map(|i| {
            let z = 0.6 + 0.005 * f64::from(i);
            let x = (z * z + r * r).sqrt();
            State::at([x, z]).moving([-z / x, -1.0])
        });
        let starts: Vec<_> = starts.map(|start| scene.project(&start).unwrap()).collect();
        let mut ensemble = scene.ensemble_in(precision, starts, Rattle::new(share * r)).unwrap();
        let mut farthest = 0.0_f64;
        for _ in 0..(2.0 / (share * r)) as u32 {
            ensemble.run(1);
            for state in ensemble.states() {
                let q = state.positions().next().unwrap();
                let off = Neck { r }.value(&q)[0].abs() / Neck { r }.jacobian(&q).norm();
                farthest = farthest.max(off / (rounding * q.amax()));
            }
        }
        assert_eq!(ensemble.failures().count(), 0);
        farthest
    }
    for (r, share) in [(0.1, 0.3), (0.1, 0.6), (0.02, 0.3), (0.02, 0.6)] {
        let single = farthest(Single, f64::from(f32::EPSILON), r, share);
        let double = farthest(Double, f64::EPSILON, r, share);
        println!("r = {r}, h|v| = {share} r: {single:.2} and {double:.2} roundings off");
        assert!(single < 4.0 && double < 4.0, "{single} {double}");
    }
}
