//! Linked bodies: references, laws and errors.

mod common;
use rattle::prelude::*;

constraint! {
    /// Two points at a distance.
    struct Rod { length }
    |a: [f64; 2], b: [f64; 2]| sum(i in 0..2, (a[i] - b[i])^2) - length^2
}

potential! {
    /// Gravity along −y.
    struct Weight { g }
    |x, y| g * y
}

#[test]
fn a_pendulum_first() {
    let scene = Scene::points(3)
        .link(Rod { length: 1.0 }, [[0, 1], [1, 2]])
        .pin(0, [0.0, 0.0])
        .with(Weight { g: 1.0 });
    let start = State::of([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
    for h in [0.02, 0.01, 0.005] {
        let mut simulation = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
        let n = (1.0 / h) as u64;
        simulation.run(n).unwrap();
        println!(
            "{:?} {:e} {:e} {:?}",
            simulation.positions().collect::<Vec<_>>(),
            simulation.energy_error(),
            simulation.constraint_residual(),
            simulation.counts()
        );
        for report in simulation.system().components() {
            println!("{report}");
        }
    }
}
