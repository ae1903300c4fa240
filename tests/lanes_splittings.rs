//! Splittings of kicks and drifts, and compositions of them, in lanes: as each trajectory alone but for rounding.

use rattle::composition::SUZUKI_1990_ORDER_4;
use rattle::ensemble::InstructionSet;
use rattle::method::Method;
use rattle::prelude::*;
use rattle::surfaces::Lemniscate;

potential! {
    struct Weight { g }
    |_x, y, z| g * z + y^2 / 4
}

const R: f64 = 1.0 / 6.0;

fn starts() -> Vec<State<3>> {
    let angle = |i: i32| 0.1 * f64::from(i);
    (0..70).map(|i| State::at([0.0, 0.0, R]).moving([angle(i).cos(), angle(i).sin(), 0.0])).collect()
}

fn off<P: Precision, S: Method>(precision: P, method: S, steps: u64) -> f64 {
    let scene = Scene::on(Lemniscate { a: 1.0, r: R }).with(Weight { g: 1.0 });
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
    apart.fold(0.0, f64::max)
}

#[test]
fn as_alone_but_for_rounding() {
    let found = [
        off(Double, PositionVerlet::new(0.01), 50),
        off(Double, SymplecticEuler::new(0.01), 50),
        off(Double, Geodesic::new(1, 0.01), 50),
        off(Double, Geodesic::new(3, 0.02), 25),
        off(Compensated, Geodesic::new(3, 0.02), 25),
        off(Compensated, PositionVerlet::new(0.01), 50),
        off(Double, Composition::of(SUZUKI_1990_ORDER_4, PositionVerlet::new(0.02)), 25),
        off(Double, Rattle::new(0.01), 50),
        off(Double, Composition::new(SUZUKI_1990_ORDER_4, 0.02), 25),
        off(Double, Lobatto::<2>::new(0.01), 50),
        off(Double, Lobatto::<3>::new(0.01), 50),
        off(Compensated, Lobatto::<3>::new(0.01), 50),
        off(Double, Lobatto::<5>::new(0.02), 25),
        off(Compensated, Lobatto::<5>::new(0.02).guess(Extrapolated), 25),
        off(Double, Lobatto::<9>::new(0.05), 10),
    ];
    println!("{found:?}");
    let fused = InstructionSet::widest().fuses(); // else all go alone, and nothing differs
    assert!(found.iter().all(|&off| off < 1e-12 && (off > 0.0) == fused), "{found:?}");
    assert!(off(Single, PositionVerlet::new(0.01), 50) < 1e-3);
    assert!(off(Single, Lobatto::<4>::new(0.02), 25) < 1e-3);
}

#[test]
fn sweeps_and_energies() {
    let scenes: Vec<_> = (0..70)
        .map(|i| Scene::on(Lemniscate { a: 1.0, r: R }).with(Weight { g: 0.02 * f64::from(i) }))
        .collect();
    let mut ensemble =
        Ensemble::sweep(Double, scenes.iter().zip(starts()), PositionVerlet::new(0.01)).unwrap();
    let mean = ensemble.observe(500, 5, || Mean::of(|now: &Sight<'_, 3>| now.energy()));
    let exact: f64 = (0..70).map(|i| 0.5 + 0.02 * f64::from(i) * R).sum::<f64>() / 70.0;
    assert!((mean.mean() - exact).abs() < 1e-3, "{} {exact}", mean.mean());
}
