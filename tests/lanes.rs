//! The method over several lanes: the same step source, every lane bit for bit its own scalar run.

use crate::common::lanes::Four;
use crate::common::*;
use rattle::bodies::{Body, One};
use rattle::error::{StepFailure, SurfaceFailure};
use rattle::kernel::{ConstraintKernel, PotentialKernel};
use rattle::need::Need;
use rattle::prelude::*;
use rattle::real::Real;
use rattle::surface::{OnSurface, OneByOne};
use rattle::system::System;
use std::array::from_fn;

#[test]
fn four_trajectories_in_lanes_are_the_four_alone() {
    four_alone(&Rattle::new(0.01));
    four_alone(&Rattle::new(0.01).solved_by(Symmetric));
    four_alone(&Rattle::new(0.01).solved_by(Simplified));
    four_alone(&Rattle::new(0.01).solved_by(Broyden));
    four_alone(&Rattle::new(0.01).guess(LastMultiplier));
    four_alone(&SymplecticEuler::new(0.01));
    four_alone(&Shake::new(0.01));
    four_alone(&Geodesic::new(3, 0.02));
    four_alone(&PositionVerlet::new(0.01));
    four_alone(&Composition::of(SUZUKI_1990_ORDER_4, PositionVerlet::new(0.01)));
    four_alone(&Dop853::new(0.02));
}

fn four_alone<S: Method>(method: &S) {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let directions = [0.1, 0.7, 2.0, 4.4];
    let alone = directions.map(|theta| scene.simulate(billiard(theta), method.clone()).unwrap());
    let system = scene.lanes::<Four>();
    let lanes = |component: &dyn Fn(usize) -> [f64; 3]| from_fn(|d| Four(from_fn(|lane| component(lane)[d])));
    let zero = [Four([0.0; 4]); 3];
    let mut together = system.bodies(
        &[Body {
            q: lanes(&|lane| alone[lane].position().into()),
            q_low: zero,
            p: lanes(&|lane| alone[lane].momentum().into()),
            p_low: zero,
        }],
        0.0,
    );
    let seen = || S::Need::of(&system).unwrap();
    let mut memory = method.memory(seen(), &together);
    let mut alone = alone;
    for step in 0..1000 {
        method.step(seen(), &mut together, memory.as_mut(), &mut ()).unwrap();
        for (lane, simulation) in alone.iter_mut().enumerate() {
            simulation.step().unwrap();
            let q = together.q[0].map(|q| q.0[lane]);
            assert_eq!(
                q,
                <[f64; 3]>::from(simulation.position()),
                "{}: lane {lane}, step {step}",
                method.name()
            );
        }
    }
}

#[test]
fn parameters_can_differ_from_lane_to_lane() {
    // A sweep over r, with a constraint of parameters alone (a², r²) computed per lane.
    let surfaces = [0.05, 0.1, 0.15, 0.2].map(|r| Lemniscate { a: 1.0, r });
    let gravities = [1.0, 0.5, 0.0, -1.0].map(|g| Gravity { g });
    let start = |r: f64| State::at([0.0, 0.0, r]).moving([0.6, 0.8, 0.0]);
    let mut alone: Vec<_> = surfaces
        .iter()
        .map(|&surface| Scene::on(surface).simulate(start(surface.r), Rattle::new(2e-3)).unwrap())
        .collect();
    let constraint = Lemniscate::kernel_of_lanes::<Four>(|lane| &surfaces[lane]);
    let gravity = Gravity::kernel_of_lanes::<Four>(|lane| &gravities[lane]);
    let height = [Four([0.1; 4]), Four([0.2; 4]), Four([3.0; 4])];
    assert_eq!(gravity.value(&height).0, [3.0, 1.5, 0.0, -3.0]);

    let same = Four::from_f64;
    let place = Body {
        q: [same(0.0), same(0.0), Four(surfaces.map(|surface| surface.r))],
        q_low: [same(0.0); 3],
        p: [same(0.6), same(0.8), same(0.0)],
        p_low: [same(0.0); 3],
    };
    let system = OnSurface::new(constraint, OneByOne, (), One);
    let mut together = system.bodies(&[place], 0.0);
    for _ in 0..500 {
        Rattle::new(2e-3).step(&system, &mut together, &mut [], &mut ()).unwrap();
        for (lane, simulation) in alone.iter_mut().enumerate() {
            simulation.step().unwrap();
            assert_eq!(
                together.q[0].map(|q| q.0[lane]),
                <[f64; 3]>::from(simulation.position()),
                "lane {lane}"
            );
        }
    }
}

/// Each lane of a kernel of lanes, by itself, is the kernel of that lane's parameters.
#[test]
fn a_lane_of_a_kernel_is_a_kernel() {
    constraint! {
        struct Bowl { shape: [f64; 2], depth }
        |x, y, z| exp(shape[0] * depth) * x^2 + y^2 / sqrt(shape[1] + depth) - z * cos(depth) - shape[0]
    }
    let bowls = [0.3, 0.8, 1.1, 2.9].map(|depth| Bowl { shape: [depth - 1.0, depth * depth], depth });
    let gravities = [1.0, 0.5, 0.0, -1.0].map(|g| Gravity { g });
    let bowl_of_lanes = Bowl::kernel_of_lanes::<Four>(|lane| &bowls[lane]);
    let gravity_of_lanes = Gravity::kernel_of_lanes::<Four>(|lane| &gravities[lane]);
    let (q, v) = ([0.3, -1.2, 0.7], [1.0, 0.2, -0.5]);
    for lane in 0..4 {
        let bowl: <Bowl as Constraint<3, 1>>::Kernel<f64> =
            Bowl::map_kernel(&bowl_of_lanes, |four: &Four| four.0[lane]);
        let own = bowls[lane].kernel::<f64>();
        assert_eq!(bowl.value_and_jacobian(&q), own.value_and_jacobian(&q), "lane {lane}");
        assert_eq!(bowl.jet(&q, &v), own.jet(&q, &v), "lane {lane}");
        let gravity = Gravity::map_kernel(&gravity_of_lanes, |four: &Four| four.0[lane]);
        assert_eq!(gravity.value(&q), gravities[lane].kernel::<f64>().value(&q), "lane {lane}");
    }
    let values = (0..4).map(|lane| bowls[lane].kernel::<f64>().value(&q)[0].to_bits());
    assert_eq!(values.collect::<std::collections::HashSet<_>>().len(), 4);
}

constraint! {
    /// The upper half of the unit sphere: not a number outside the unit circle, where a first guess may lie.
    struct Dome {}
    |x, y, z| sqrt(1 - x^2 - y^2) - z
}

#[test]
fn a_lane_that_leaves_the_domain_does_not_touch_the_others() {
    let scene = Scene::on(Dome {}).with(Gravity { g: 1.0 });
    let system = scene.lanes::<Four>();
    let mut compared = 0;
    for group in 0..2000_u32 {
        // Points spread over the dome, some close to its rim, moving outwards.
        let alone: [_; 4] = from_fn(|lane| {
            let angle = f64::from(4 * group + lane as u32) * 2.399;
            let radius = 0.3 + 0.69 * f64::from((group * 7 + 3 * lane as u32) % 100) / 100.0;
            let (x, y) = (radius * angle.cos(), radius * angle.sin());
            let start = State::at([x, y, (1.0 - radius * radius).sqrt()]).moving([0.9 * x, 0.9 * y, 0.1]);
            scene.simulate(scene.project(&start).unwrap(), Rattle::new(0.2)).unwrap()
        });
        let lanes =
            |component: &dyn Fn(usize) -> [f64; 3]| from_fn(|d| Four(from_fn(|lane| component(lane)[d])));
        let zero = [Four([0.0; 4]); 3];
        let mut together = system.bodies(
            &[Body {
                q: lanes(&|lane| alone[lane].position().into()),
                q_low: zero,
                p: lanes(&|lane| alone[lane].momentum().into()),
                p_low: zero,
            }],
            0.0,
        );
        let mut alone = alone;
        let all = alone.each_mut().map(|simulation| simulation.step().is_ok()) == [true; 4];
        assert_eq!(
            Rattle::new(0.2).step(&system, &mut together, &mut [], &mut ()).is_ok(),
            all,
            "group {group}"
        );
        if all {
            compared += 1;
            for (lane, simulation) in alone.iter().enumerate() {
                let (q, p) = (together.q[0].map(|q| q.0[lane]), together.p[0].map(|p| p.0[lane]));
                assert_eq!(q, <[f64; 3]>::from(simulation.position()), "group {group}, lane {lane}");
                assert_eq!(p, <[f64; 3]>::from(simulation.momentum()), "group {group}, lane {lane}");
            }
        }
    }
    assert!(compared > 100, "{compared} groups compared");
}

#[test]
fn a_lane_that_fails_is_told() {
    let scene = Scene::on(Sphere { r: 1.0 });
    let system = scene.lanes::<Four>();
    let (zero, one) = (Four([0.0; 4]), Four([1.0; 4]));
    let mut bodies = system.bodies(
        &[Body {
            q: [one, zero, zero],
            q_low: [zero; 3],
            p: [zero, Four([0.1, 0.2, 30.0, 0.4]), zero],
            p_low: [zero; 3],
        }],
        0.0,
    );
    let failure = Rattle::new(0.1).step(&system, &mut bodies, &mut [], &mut ()).unwrap_err();
    let StepFailure::Surface(SurfaceFailure::StepTooLong { speed, .. }) = failure.cause else {
        panic!("{failure:?}")
    };
    assert_eq!(speed, 30.0);
}
