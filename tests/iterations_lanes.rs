//! What a step costs in lanes, counted: lanes that do more than they need, or go by themselves, end at the same places.

use crate::common::*;
use rattle::Counted;
use rattle::composition::*;
use rattle::ensemble::InstructionSet;
use rattle::prelude::*;

/// How often g, its gradient and second derivatives are evaluated in a step of one of 64 trajectories: within three in
/// a hundred of what was counted, lanes that went by themselves now and then among them.
fn check<S: Method>(name: &str, counted: f64, method: S) {
    let surface = Counted::new(SURFACE);
    let counts = surface.counts();
    let scene = Scene::on(surface).with(Gravity { g: 1.0 });
    let starts = (0..64).map(|i| scene.project(&billiard(0.1 + 0.01 * f64::from(i))).unwrap());
    let mut ensemble = scene.ensemble(starts, method).unwrap();
    ensemble.run(20);
    counts.reset();
    ensemble.run(100);
    let found = counts.all() as f64 / 6400.0;
    println!("{name}: {found:.2}");
    assert!((0.97..=1.03).contains(&(found / counted)), "{name}: {found:.2} instead of {counted}");
}

#[test]
fn a_step_costs_what_it_did() {
    if !InstructionSet::widest().fuses() {
        return;
    }
    check("RATTLE", 5.13, Rattle::new(0.01));
    check("Suzuki 1990, order 4", 25.13, Composition::new(SUZUKI_1990_ORDER_4, 0.01));
    check("position Verlet", 10.13, PositionVerlet::new(0.01));
    check("geodesic RATTLE", 20.13, Geodesic::new(4, 0.01));
    check("Lobatto, 3 stages", 21.16, Lobatto::<3>::new(0.01));
    check("Lobatto, 5 stages", 31.72, Lobatto::<5>::new(0.01));
    check("DOP853", 30.99, Dop853::new(0.01));
    check("Taylor, order 12", 9.83, Taylor::new(12, 0.01));
}
