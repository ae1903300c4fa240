//! Kernels over several numbers side by side, and systems over other scalars than `f64`.

use crate::common::lanes::Four;
use crate::common::*;
use crate::complex::Complex;
use rattle::bodies::Body;
use rattle::kernel::{ConstraintKernel, PotentialKernel};
use rattle::need::Need;
use rattle::prelude::*;
use rattle::system::Parts;
use rattle::system::System;
use std::array::from_fn;

/// So small that its square is no number beside 1: what is imaginary is a derivative to rounding.
const TINY: f64 = 1e-100;

/// Over complex numbers a method makes the steps of a simulation, and with them their derivatives (Squire and Trapp
/// 1998), against central differences of two simulations.
#[test]
fn steps_over_complex_numbers_have_their_derivatives() {
    has_derivatives(&Rattle::new(0.01));
    has_derivatives(&Rattle::new(0.01).solved_by(Symmetric));
    has_derivatives(&Rattle::new(0.01).solved_by(Simplified));
    has_derivatives(&Rattle::new(0.01).solved_by(Broyden));
    has_derivatives(&Rattle::new(0.01).guess(LastMultiplier));
    has_derivatives(&SymplecticEuler::new(0.01));
    has_derivatives(&Shake::new(0.01));
    has_derivatives(&Geodesic::new(3, 0.02));
    has_derivatives(&PositionVerlet::new(0.01));
    has_derivatives(&Composition::of(SUZUKI_1990_ORDER_4, PositionVerlet::new(0.01)));
    has_derivatives(&Lobatto::<4>::new(0.02));
    has_derivatives(&Dop853::new(0.02));
}

fn has_derivatives<S: Method>(method: &S) {
    const STEPS: u64 = 50;
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    // From one place in directions that turn.
    let start = |theta: f64| {
        let mut simulation = scene.simulate(billiard(theta), method.clone()).unwrap();
        let [q, p] = [simulation.position(), simulation.momentum()];
        simulation.run(STEPS).unwrap();
        ([q.into(), p.into()], simulation.position())
    };
    let (theta, small) = (0.7, 1e-5);
    let [(before, q_before), (at, q), (after, q_after)] = [theta - small, theta, theta + small].map(start);
    let tangent = |k: usize| -> [Complex; 3] {
        let [before, at, after]: [[f64; 3]; 3] = [before[k], at[k], after[k]];
        from_fn(|d| Complex(at[d], TINY * (after[d] - before[d]) / (2.0 * small)))
    };
    let (system, zero) = (scene.system::<Complex>(), [Complex(0.0, 0.0); 3]);
    let place = Body { q: tangent(0), q_low: zero, p: tangent(1), p_low: zero };
    let mut bodies = system.bodies(&[place], 0.0);
    let seen = || S::Need::of(&system).unwrap();
    let mut memory = method.memory(seen(), &bodies);
    for _ in 0..STEPS {
        method.step(seen(), &mut bodies, memory.as_mut(), &mut ()).unwrap();
    }
    for d in 0..3 {
        let Complex(place, change) = bodies.q[0][d];
        assert!((place - q[d]).abs() < 1e-12, "{}: {place} and {}", method.name(), q[d]);
        let difference = (q_after[d] - q_before[d]) / (2.0 * small);
        assert!(
            (change / TINY - difference).abs() < 1e-8,
            "{}: {} and {difference}",
            method.name(),
            change / TINY
        );
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
