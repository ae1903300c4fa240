//! The stepper over several lanes: the same step source, every lane bit for bit its own scalar run.

mod common;
use common::lanes::Four;
use common::*;
use rattle::bodies::{Body, One};
use rattle::prelude::*;
use std::array::from_fn;

#[test]
fn four_trajectories_in_lanes_are_the_four_alone() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let directions = [0.1, 0.7, 2.0, 4.4];
    let alone = directions.map(|theta| scene.simulate(billiard(theta), Rattle::new(0.01)).unwrap());
    let system = scene.system::<Four>();
    let lanes = |component: &dyn Fn(usize) -> [f64; 3]| from_fn(|d| Four(from_fn(|lane| component(lane)[d])));
    let zero = [Four([0.0; 4]); 3];
    let mut together = system.bodies(One, |_| Body {
        q: lanes(&|lane| alone[lane].position().into()),
        q_low: zero,
        p: lanes(&|lane| alone[lane].momentum().into()),
        p_low: zero,
    });
    let mut alone = alone;
    for step in 0..1000 {
        Rattle::new(0.01).step(&system, &mut together, &mut ()).unwrap();
        for (lane, simulation) in alone.iter_mut().enumerate() {
            simulation.step().unwrap();
            let q = together.q[0].map(|q| q.0[lane]);
            assert_eq!(q, <[f64; 3]>::from(simulation.position()), "lane {lane}, step {step}");
        }
    }
}

#[test]
fn a_lane_that_fails_is_told() {
    let scene = Scene::on(Sphere { radius: 1.0 });
    let system = scene.system::<Four>();
    let (zero, one) = (Four([0.0; 4]), Four([1.0; 4]));
    let mut bodies = system.bodies(One, |_| Body {
        q: [one, zero, zero],
        q_low: [zero; 3],
        p: [zero, Four([0.1, 0.2, 30.0, 0.4]), zero],
        p_low: [zero; 3],
    });
    let failure = Rattle::new(0.1).step(&system, &mut bodies, &mut ()).unwrap_err();
    let rattle::error::StepFailure::StepTooLong { speed, .. } = failure.cause else { panic!("{failure:?}") };
    assert_eq!(speed, 30.0);
}
