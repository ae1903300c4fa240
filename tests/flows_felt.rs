//! Dry friction beside drags that stop bodies within a step, or in much less.

use rattle::bodies::One;
use rattle::effect::{DryFriction, Effects, LinearDrag, QuadraticDrag};
use rattle::potentials::Gravity;
use rattle::prelude::*;
use rattle::scene::Hold;
use rattle::surfaces::Plane;

const FLOOR: Plane = Plane { a: 0.0, b: 0.0, c: 1.0, d: 0.0 };
const ROUGH: DryFriction = DryFriction { coefficient: 1.0 };

potential! { struct Push { f } |x, _y, _z| -f * x }

/// The speed of a body of mass 1 after so many steps along the first axis.
fn speed<C: Hold<3>, E: Effects<3>>(scene: &Scene<C, E, One, 3>, (speed, h, steps): (f64, f64, u64)) -> f64 {
    let start = State::at([0.0; 3]).moving([speed, 0.0, 0.0]);
    let mut simulation = scene.simulate(start, Rattle::new(h)).unwrap();
    simulation.run(steps).unwrap();
    assert!(simulation.velocity().iter().skip(1).all(|&v| v == 0.0));
    simulation.velocity().x
}

/// Half of a step takes h/2 from what slides on, by N = 1, whatever drag takes before and after it.
#[test]
fn friction_slows_beside_any_drag() {
    let (weighs, h, v) = (Scene::on(FLOOR).with(Gravity { g: 1.0 }), 0.1, 10.0);
    for c in [1.0_f64, 16.0, 18.0, 20.0, 40.0] {
        let left = (-0.5 * c * h).exp();
        let [first, last] = [
            speed(&weighs.with(LinearDrag::new(c)).with(ROUGH), (v, h, 1)),
            speed(&weighs.with(ROUGH).with(LinearDrag::new(c)), (v, h, 1)),
        ];
        let expected = [(v * left - h) * left, (v - 0.5 * h) * left * left - 0.5 * h];
        assert!((first - expected[0]).abs() < 1e-13, "drag first, c = {c}: {first} of {}", expected[0]);
        assert!((last - expected[1]).abs() < 1e-13, "friction first, c = {c}: {last} of {}", expected[1]);
    }
    // Nothing is left in much less than a step, and nothing turns round.
    for c in [100.0, 1e3, 1e5] {
        let [first, last] = [
            speed(&weighs.with(LinearDrag::new(c)).with(ROUGH), (v, h, 10)),
            speed(&weighs.with(ROUGH).with(LinearDrag::new(c)), (v, h, 10)),
        ];
        assert_eq!([first, last], [0.0; 2], "c = {c}");
    }
}

/// In the end a body that is pulled goes x coth x times as far as it should, as without friction; where friction comes
/// first too far by a second order.
#[test]
fn ways_of_pulled_bodies_beside_friction() {
    let pulled = Scene::on(FLOOR).with(Gravity { g: 1.0 }).with(Push { f: 2.0 });
    fn way<E: Effects<3>>(scene: &Scene<Plane, E, One, 3>, h: f64) -> f64 {
        let mut simulation = scene.simulate(State::at([0.0; 3]), Rattle::new(h)).unwrap();
        simulation.run((50.0 / h) as u64).unwrap();
        let before = simulation.position().x;
        simulation.step().unwrap();
        (simulation.position().x - before) / h
    }
    let drag = || LinearDrag::new(1.0);
    for h in [0.5, 1.0, 2.0, 4.0] {
        let (times, x) = (way(&pulled.with(drag()).with(ROUGH), h), 0.5 * h);
        assert!((times * x.tanh() / x - 1.0).abs() < 0.01, "h = {h}: {times} of {}", x / x.tanh());
    }
    let [long, short] = [0.2, 0.1].map(|h| way(&pulled.with(ROUGH).with(drag()), h) - 1.0);
    assert!((3.5..4.5).contains(&(long / short)), "{long} {short}");
}

/// On a slope, where friction has to know the normal force beside drag: in the end a body goes at the share of its
/// speed without friction that is left of the force.
#[test]
fn normal_forces_beside_any_drag() {
    let (sin, cos) = (0.5, 0.75_f64.sqrt());
    let slope = Scene::on(Plane { a: sin, b: 0.0, c: cos, d: 0.0 }).with(Gravity { g: 1.0 });
    let mu = 0.3;
    fn way<E: Effects<3>>(scene: &Scene<Plane, E, One, 3>) -> f64 {
        let mut simulation = scene.simulate(State::at([0.0; 3]), Rattle::new(0.1)).unwrap();
        simulation.run(200).unwrap();
        let before = simulation.position();
        simulation.step().unwrap();
        (simulation.position() - before).norm()
    }
    for c in [1.0, 100.0, 300.0, 600.0] {
        let free = way(&slope.with(LinearDrag::new(c)));
        let held = way(&slope.with(LinearDrag::new(c)).with(DryFriction { coefficient: mu }));
        let expected = (sin - mu * cos) / sin;
        assert!((held / free - expected).abs() < 1e-3 * expected, "c = {c}: {} of {expected}", held / free);
    }
    // Neither axis is that of the slope. Farther on nothing is left of a momentum in half a step; bodies count as at
    // rest, and steps do not fail.
    let slope = Scene::on(Plane { a: 0.36, b: 0.48, c: 0.8, d: 0.0 }).with(Gravity { g: 1.0 });
    for c in [1e3, 4e4, 1e6, 1e9] {
        let held = slope.with(LinearDrag::new(c)).with(DryFriction { coefficient: mu });
        assert!(way(&held) <= way(&slope.with(LinearDrag::new(c))));
    }
}

/// A drag that has no way back from here slows, as without friction.
#[test]
fn friction_beside_a_drag_without_a_way_back() {
    let scene = Scene::on(FLOOR).with(Gravity { g: 9.81 });
    let drag = QuadraticDrag { coefficient: 1.0 };
    let (v, h, mu) = (100.0, 0.1, 0.1);
    let both = speed(&scene.with(drag).with(DryFriction { coefficient: mu }), (v, h, 1));
    let slowed = |v: f64| v / (1.0 + 0.5 * h * v);
    assert!((both - slowed(slowed(v) - h * mu * 9.81)).abs() < 1e-12, "{both}");
}
