//! Contacts of bodies that constraints hold in touch: those do not meet, and what really closes is told.

use rattle::Error;
use rattle::effect::{HardSpheres, Stop};
use rattle::error::StepFailure;
use rattle::links::Rod;
use rattle::potentials::Gravity;
use rattle::prelude::*;

constraint! {
    /// Where the first ball of a chain is led: to and fro.
    struct Led {}
    |x, y, z, t| [x - sin(t) / 4, y, z]
}

constraint! {
    /// To the right of a wall beside a chain.
    struct Beside {}
    |x, _y, _z| x + 1/4
}

constraint! {
    /// A rod that grows shorter.
    struct Shrinking { length, u }
    |a, b, t| (a - b)^2 - (length - u * t)^2
}

constraint! {
    /// A ring.
    struct Ring {}
    |x, y| x^2 + y^2 - 1
}

constraint! {
    /// A wall that touches the ring from outside.
    struct Touching { sin, cos }
    |x, y| cos * x + sin * y - 1
}

/// A start of three balls on rods as long as balls are thick, which hang down in a plane at this turn.
fn hanging(angle: f64, turn: f64) -> State<3> {
    let rod = |angle: f64| [angle.sin() * turn.cos(), angle.sin() * turn.sin(), -angle.cos()];
    let (first, second) = (rod(angle), rod(1.2 * angle));
    State::of([[0.0; 3], first, std::array::from_fn(|i| first[i] + second[i])])
}

/// Rods hold balls in touch whose diameter they have: no impact, no rest, and every bit as without contacts. Where the
/// chain meets a wall, balls that are held give no impulse to each other.
fn what_rods_hold_in_touch(steps: u64) {
    let scene = || {
        Scene::points(3).pin(0, [0.0; 3]).link(Rod { length: 1.0 }, [[0, 1], [1, 2]]).with(Gravity { g: 1.0 })
    };
    let led = || {
        let scene = Scene::points(3).link_moving(Led {}, [[0]]);
        scene.link(Rod { length: 1.0 }, [[0, 1], [1, 2]]).with(Gravity { g: 1.0 })
    };
    let (balls, wall) = (|| HardSpheres::new(1.0), || Stop::above(Beside {}).over([[2]]));
    for (angle, turn) in [(0.1, 0.6), (0.2, 0.6), (0.3, 0.0)] {
        macro_rules! alike {
            ($scene:expr, $walled:expr) => {
                let start = $scene.project(&hanging(angle, turn)).unwrap();
                let run = || $scene.simulate(start.clone(), Rattle::new(0.01)).unwrap();
                let (mut without, mut with) = (run(), run().collide(balls()).unwrap());
                if $walled {
                    (without, with) = (without.collide(wall()).unwrap(), with.collide(wall()).unwrap());
                }
                with.run(steps).unwrap();
                without.run(steps).unwrap();
                assert_eq!((with.events() > 0, with.events()), ($walled, without.events()), "{angle}");
                assert_eq!(with.state(), without.state(), "{angle}");
            };
        }
        alike!(scene(), false);
        alike!(led(), false);
        if turn == 0.0 {
            alike!(scene(), true);
        }
    }
}

#[test]
fn what_rods_hold_in_touch_does_not_meet() {
    what_rods_hold_in_touch(if cfg!(long) { 50_000 } else { 4000 });
}

/// Corrections of a run, up to each sight and each jump.
#[derive(Default)]
struct Corrections(Vec<[u64; 3]>);

impl Observer<3> for Corrections {
    fn see(&mut self, _: &Sight<'_, 3>, now: &Sight<'_, 3>) {
        self.0.push([now; 3].map(|sight| sight.corrections().unwrap()));
    }
    fn sees_jumps(&self) -> bool {
        true
    }
    fn jump(&mut self, from: &Sight<'_, 3>, before: &Sight<'_, 3>, after: &Sight<'_, 3>) {
        self.0.push([from, before, after].map(|sight| sight.corrections().unwrap()));
    }
    fn join(&mut self, _: Self) {}
}

/// A sight at an impact tells of the corrections up to there, not of those up to the next sight.
#[test]
fn sights_at_impacts_count_up_to_there() {
    let scene = Scene::points(3).pin(0, [0.0; 3]).link(Rod { length: 1.0 }, [[0, 1], [1, 2]]);
    let scene = scene.with(Gravity { g: 1.0 });
    let start = scene.project(&hanging(0.3, 0.0)).unwrap();
    let run = scene.simulate(start, Rattle::new(0.01)).unwrap();
    let mut run = run.collide(Stop::above(Beside {}).over([[2]])).unwrap();
    let mut seen = Corrections::default();
    run.observe(2000, 100, &mut seen).unwrap();
    assert!(seen.0.len() > 22 && seen.0.iter().flatten().is_sorted(), "{:?}", seen.0);
    let jumps: Vec<_> = seen.0.iter().zip(&seen.0[1..]).filter(|(jump, _)| jump[0] < jump[1]).collect();
    assert_eq!(jumps.len(), seen.0.len() - 20, "{:?}", seen.0);
    assert!(jumps.iter().all(|(jump, next)| jump[2] < next[1]), "{jumps:?}");
}

/// A rod that grows shorter takes balls together that touch, however slowly.
#[test]
fn what_a_rod_takes_together_is_told() {
    for (length, u, step) in [(1.0, 0.1, 1), (1.0, 1e-12, 1), (1.055, 0.1, 6)] {
        let scene = Scene::points::<1>(2).link_moving(Shrinking { length, u }, [[0, 1]]);
        let start = State::of([[0.0], [length]]).with_momenta([[0.5 * u], [-0.5 * u]]);
        let run = scene.simulate(start, Rattle::new(0.1)).unwrap();
        let error = run.collide(HardSpheres::new(1.0)).unwrap().run(9).unwrap_err();
        let Error::Step { cause: StepFailure::NoWayApart { .. }, step: found, .. } = &error else {
            panic!("{length} {u}: {error}")
        };
        assert_eq!(*found, step, "{error}");
    }
}

/// A bead on a ring parts from a wall that touches it, whatever rounding says of its speed towards the wall.
#[test]
fn a_bead_on_a_ring_parts_from_a_wall_that_touches() {
    for [cos, sin] in [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]] {
        for rounding in [-1e-16, -1e-18, 1e-18, 1e-17, 1e-16] {
            let scene = Scene::points(1).link(Ring {}, [[0]]);
            let towards = [rounding * cos - sin, rounding * sin + cos];
            let start = State::of([[cos, sin]]).with_momenta([towards]);
            let run = || scene.simulate(start.clone(), Rattle::new(0.1)).unwrap();
            let (mut free, mut beside) = (run(), run().collide(Stop::below(Touching { sin, cos })).unwrap());
            beside.run(40).unwrap();
            free.run(40).unwrap();
            assert_eq!((beside.state(), beside.events()), (free.state(), 0), "{towards:?}");
        }
    }
}
