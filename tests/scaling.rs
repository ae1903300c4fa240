//! c·g = 0 is the same surface as g = 0: for a power of two, bit for bit, whatever the method.

use crate::common::*;
use rattle::prelude::*;
use rattle::{Dop853, Geodesic, Variable};

constraint! {
    /// The lemniscate surface, as c·g = 0.
    struct Scaled { a, r, c }
    |x, y, z| {
        let f = (x^2 + y^2)^2 - a^2 * (x^2 - y^2);
        c * (f^2 + z^2 - r^2)
    }
}

/// Places and momenta after 200 steps; what is remembered holds multipliers, and they scale.
fn end<S: Method>(method: &S, c: f64) -> String {
    let scene = Scene::on(Scaled { a: 1.0, r: SURFACE.r, c }).with(Gravity { g: 1.0 });
    let start = scene.staggered(&billiard(0.7), method).unwrap();
    let mut simulation = scene.simulate(start, method.clone()).unwrap();
    simulation.run(200).unwrap();
    let all = bits(&simulation.state());
    all[..all.find("time").unwrap()].to_owned()
}

#[test]
fn no_method_knows_how_g_is_scaled() {
    fn check<S: Method>(method: S) {
        let reference = end(&method, 1.0);
        for exponent in [-60, -1, 1, 60] {
            assert!(end(&method, 2.0_f64.powi(exponent)) == reference, "{}, 2^{exponent}", method.name());
        }
        assert!(end(&method, 1.1) != reference, "{}: the comparison sees a difference", method.name());
    }
    check(Rattle::new(0.01));
    check(Rattle::new(0.01).guess(Extrapolated));
    check(Rattle::new(0.01).guess(LastMultiplier));
    check(Rattle::new(0.01).solved_by(Symmetric));
    check(Rattle::new(0.01).solved_by(Simplified));
    check(Rattle::new(0.01).solved_by(Broyden));
    check(SymplecticEuler::new(0.01));
    check(Shake::new(0.01));
    check(Geodesic::new(3, 0.01));
    check(PositionVerlet::new(0.01));
    for coefficients in rattle::composition::ALL {
        check(Composition::new(coefficients, 0.01));
    }
    check(Lobatto::<2>::new(0.01));
    check(Lobatto::<3>::new(0.02));
    check(Lobatto::<4>::new(0.02));
    check(Lobatto::<5>::new(0.02));
    check(Lobatto::<5>::new(0.02).guess(Extrapolated));
    check(Lobatto::<6>::new(0.02));
    check(Lobatto::<7>::new(0.02));
    check(Lobatto::<8>::new(0.02));
    check(Lobatto::<9>::new(0.02));
    check(Variable::of(Rattle::new(0.02), 0.3));
    check(Dop853::new(0.01));
}
