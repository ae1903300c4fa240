//! Linked bodies near a toggle that they do not reach, by methods that do not follow the roots of the constraints: no
//! step ends on the mirror image of an elbow, which fits the constraints as well.

use rattle::Error;
use rattle::bodies::Many;
use rattle::effect::list::Effects;
use rattle::ensemble::InstructionSet;
use rattle::error::StepFailure;
use rattle::links::planar::{Rod, Slider};
use rattle::network::Network;
use rattle::prelude::*;
use std::f64::consts::PI;

potential! { struct Well { k } |x, y| k * (x - 1.5)^2 / 2 + 0 * y }
constraint! { struct Drive { x0, a } |x, y, t| [x - x0 - a * (1 - cos(t)), y] }

const ROD: Rod = Rod { length: 1.0 };

/// The elbow between a pin at the origin and an end at x, above both.
fn bent(x: f64) -> State<2> {
    State::of([[0.0, 0.0], [x / 2.0, (1.0 - x * x / 4.0).sqrt()], [x, 0.0]])
}

/// Two rods from a pin by a light elbow to a heavy slider, which swings by x = 1.5 − (0.5 − d) cos t.
fn press() -> Scene<Network<2>, impl Effects<2>, Many, 2> {
    Scene::points(3)
        .link(ROD, [[0, 1], [1, 2]])
        .pin(0, [0.0, 0.0])
        .link(Slider { point: [0.0, 0.0], direction: [1.0, 0.0] }, [[2]])
        .masses([1.0, 1e-6, 1e6])
        .with(Well { k: 1e6 }.over([[2]]))
}

fn pressed(d: f64) -> State<2> {
    press().project(&bent(1.0 + d)).unwrap()
}

/// The same rods with an end that is led from 2 − d − 2a to 2 − d and back: nothing is free.
fn led(d: f64, a: f64) -> (Scene<Network<2>, (), Many, 2>, State<2>) {
    let x0 = 2.0 - d - 2.0 * a;
    let scene =
        Scene::points(3).link(ROD, [[0, 1], [1, 2]]).pin(0, [0.0, 0.0]).link_moving(Drive { x0, a }, [[2]]);
    let start = scene.project(&bent(x0)).unwrap();
    (scene, start)
}

/// How many turns go through, and how many are refused, which those in few steps are for other reasons too: of those in
/// 10 to 283 steps, with the toggle at a distance of 1e-3 to 1e-8.
macro_rules! turns {
    ($start:expr, |$h:ident| $method:expr) => {{
        let [mut through, mut refused] = [0; 2];
        for d in [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8] {
            for steps in [10_u32, 23, 45, 100, 283] {
                let $h = 2.0 * PI / f64::from(steps);
                let (scene, start) = $start(d);
                let mut simulation = scene.simulate(start, $method).unwrap();
                let run = simulation.run(steps.into());
                refused += u32::from(run.is_err());
                through += u32::from(run.is_ok() && simulation.state().positions().any(|q| q.y < -0.1));
            }
        }
        println!("{}: {through} of 30 go through, {refused} are refused", stringify!($method));
        [through, refused]
    }};
}

/// None goes through, and no more are refused than these and those that did.
fn none_goes_through(turns: &[([u32; 2], u32)]) {
    for ([through, refused], most) in turns {
        assert_eq!(*through, 0);
        assert!(refused <= most, "{refused} of 30");
    }
}

#[test]
fn an_elbow_that_is_led_stays_on_its_side() {
    let start = |d| led(d, 0.4);
    none_goes_through(&[
        (turns!(start, |h| Dop853::new(h)), 20),
        (turns!(start, |h| Taylor::new(8, h)), 27),
        (turns!(start, |h| Taylor::new(16, h)), 28),
        (turns!(start, |h| Taylor::adaptive(12, h, 1e-3)), 13),
    ]);
}

#[test]
fn an_elbow_that_a_slider_takes_along_stays_on_its_side() {
    let start = |d| (press(), pressed(d));
    none_goes_through(&[
        (turns!(start, |h| Dop853::new(h)), 22),
        (turns!(start, |h| Taylor::new(8, h)), 27),
        (turns!(start, |h| Bdf2::new(h)), 29),
    ]);
}

/// The turn that was found first.
#[test]
fn a_step_through_a_toggle_is_told() {
    let mut simulation = press().simulate(pressed(1e-6), Dop853::new(2.0 * PI / 23.0)).unwrap();
    let run = simulation.run(23);
    assert!(matches!(run, Err(Error::Step { cause: StepFailure::OtherSheet { .. }, .. })), "{run:?}");
    assert!(simulation.state().positions().nth(1).unwrap().y > 0.0);
}

/// The same of components that are alike, in one scene.
#[test]
fn so_is_one_of_32() {
    const COPIES: usize = 32;
    let bodies = 3 * COPIES;
    let rods = (0..bodies).filter(|body| body % 3 < 2).map(|body| [body, body + 1]);
    let sliders = (0..COPIES).map(|copy| [3 * copy + 2]);
    let scene = Scene::points(bodies)
        .link(ROD, rods)
        .link(Slider { point: [0.0, 0.0], direction: [1.0, 0.0] }, sliders.clone())
        .masses((0..bodies).map(|body| [1.0, 1e-6, 1e6][body % 3]))
        .with(Well { k: 1e6 }.over(sliders));
    let scene = (0..COPIES).fold(scene, |scene, copy| scene.pin(3 * copy, [0.0, 0.0]));
    let each = (0..COPIES).map(|copy| pressed(1e-6 + 1e-9 * copy as f64));
    let places = each.flat_map(|state| state.positions().collect::<Vec<_>>());
    let start = scene.project(&State::of(places.map(|q| [q.x, q.y]))).unwrap();
    let mut simulation = scene.simulate(start, Dop853::new(2.0 * PI / 23.0)).unwrap();
    let run = simulation.run(23);
    assert!(matches!(run, Err(Error::Step { cause: StepFailure::OtherSheet { .. }, .. })), "{run:?}");
    assert!(simulation.state().positions().all(|q| q.y > -0.1));
}

/// And in lanes.
#[test]
fn none_of_an_ensemble_goes_through() {
    /// How many are refused.
    fn refused(method: impl Method, steps: u64) -> usize {
        let starts = (0..320).map(|i| pressed(1e-6 + 1e-3 * f64::from(i) / 320.0));
        let mut ensemble = press().ensemble(starts, method.clone()).unwrap();
        assert_eq!(ensemble.plan().in_lanes, if InstructionSet::widest().fuses() { 320 } else { 0 });
        ensemble.run(steps);
        for (i, state) in ensemble.states().enumerate() {
            let y = state.positions().nth(1).unwrap().y; // also before a step that failed
            assert!(y > 0.0, "{} steps of {}: trajectory {i} went through to {y}", steps, method.name());
        }
        let refused = ensemble.failures().count();
        println!("{steps} steps of {}: {refused} of 320 refused", method.name());
        refused
    }
    for steps in [23, 45] {
        let h = 2.0 * PI / steps as f64;
        assert!(refused(Dop853::new(h), steps) <= if steps == 23 { 245 } else { 62 });
        refused(Taylor::new(10, h), steps);
        refused(Taylor::adaptive(12, h, 1e-6), steps);
    }
}
