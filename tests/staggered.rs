//! What constraints give by a method whose momenta are half a step apart: asked with momenta of the time of the
//! positions, so of the order of the method.

use rattle::links::planar::{Pendulum, Rod};
use rattle::potentials::planar::Gravity;
use rattle::prelude::*;

/// The forces of constraints on the last body at each sight.
#[derive(Default)]
struct Tensions(Vec<f64>);

impl Observer<2> for Tensions {
    fn see(&mut self, _: &Sight<'_, 2>, now: &Sight<'_, 2>) {
        let forces = now.constraint_forces();
        self.0.push(forces[forces.len() - 1].norm());
    }
    fn join(&mut self, other: Self) {
        self.0.extend(other.0);
    }
}

/// From rest at the side: the tension of a pendulum is v² + g cos θ, and v² = 2 g cos θ.
#[test]
fn the_tension_of_a_pendulum_is_of_second_order() {
    let gravity = Gravity { g: 1.0 };
    let alone = Scene::on(Pendulum { length: 1.0, pivot: [0.0; 2] }).with(gravity);
    let linked = Scene::points(2)
        .link(Rod { length: 1.0 }, [[0, 1]])
        .pin(0, [0.0; 2])
        .masses([1.0, 1.0])
        .with(gravity);
    let starts = (State::at([1.0, 0.0]), State::of([[0.0, 0.0], [1.0, 0.0]]));
    let mut exact = alone.simulate(starts.0.clone(), Dop853::new(1.0 / 64.0)).unwrap();
    exact.run(64).unwrap();
    let exact = -3.0 * exact.position().y;
    let mut before = f64::NAN;
    for steps in [16_u64, 32, 64, 128] {
        let h = 1.0 / steps as f64;
        let method = Shake::new(h);
        let staggered = alone.staggered(&starts.0, &method).unwrap();
        let mut one = alone.simulate(staggered.clone(), method).unwrap();
        one.run(steps).unwrap();
        let tension = one.constraint_forces()[0].norm();
        // The gradient of the constraint is 2q, of length 2.
        let rounding = 1024.0 * f64::EPSILON; // as many as steps, some of each
        assert!((tension + 2.0 * one.multiplier()).abs() <= rounding, "{tension} or {}", one.multiplier());

        let mut two = linked.simulate(linked.staggered(&starts.1, &method).unwrap(), method).unwrap();
        two.run(steps).unwrap();
        let Tensions(seen) =
            alone.ensemble([staggered], method).unwrap().observe(steps, steps, Tensions::default);
        let mut rattle = alone.simulate(starts.0.clone(), Rattle::new(h)).unwrap();
        rattle.run(steps).unwrap();
        // Positions are those of RATTLE, and then so are momenta of their time.
        for other in [two.constraint_forces()[1].norm(), seen[seen.len() - 1], -2.0 * rattle.multiplier()] {
            assert!((tension - other).abs() <= rounding, "{steps} steps: {tension} and {other}");
        }
        let off = (tension - exact).abs();
        // h² times what was measured at h = 1/16, and a tenth.
        assert!(off <= 0.19 * h * h, "{steps} steps: {off:e}");
        let order = (before / off).log2();
        assert!(before.is_nan() || (order - 2.0).abs() <= 0.05, "{steps} steps: order {order}");
        before = off;
    }
}
