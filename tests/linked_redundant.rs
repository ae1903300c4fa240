//! Links of which some follow from the others where all hold, and only there: off the constraints their normals are
//! independent by a sine of about how far off a place is. The motion has nothing of that, and nor have starts.

use crate::common::PlanarGravity;
use rattle::bodies::Many;
use rattle::effect::list::Effects;
use rattle::error::{Error, StartFailure};
use rattle::links::planar::Rod;
use rattle::nalgebra::SVector;
use rattle::network::Network;
use rattle::prelude::*;

constraint! {
    /// The last body is halfway between the others.
    struct Halfway {} |a: [f64; 2], c: [f64; 2], b: [f64; 2]| for i in 0..2 { b[i] - (a[i] + c[i]) / 2 }
}

constraint! {
    /// Three directions at right angles. That the third has the length 1 follows from the others.
    struct Frame {}
    |a: [f64; 3], b: [f64; 3], c: [f64; 3]| [
        dot(a, a) - 1,
        dot(b, b) - 1,
        dot(a, b),
        c[0] - (a[1] * b[2] - a[2] * b[1]),
        c[1] - (a[2] * b[0] - a[0] * b[2]),
        c[2] - (a[0] * b[1] - a[1] * b[0]),
        dot(c, c) - 1
    ]
}

constraint! {
    /// The same without that.
    struct FrameOfSix {}
    |a: [f64; 3], b: [f64; 3], c: [f64; 3]| [
        dot(a, a) - 1,
        dot(b, b) - 1,
        dot(a, b),
        c[0] - (a[1] * b[2] - a[2] * b[1]),
        c[1] - (a[2] * b[0] - a[0] * b[2]),
        c[2] - (a[0] * b[1] - a[1] * b[0])
    ]
}

potential! {
    /// A constant force on each of three bodies.
    struct Pulls {}
    |a: [f64; 3], b: [f64; 3], c: [f64; 3]|
        -(0.3 * a[0] - 0.7 * a[1] + 0.2 * a[2])
        - (0.5 * b[0] + 0.1 * b[1] - 0.4 * b[2])
        - (-0.6 * c[0] + 0.8 * c[1] + 1.1 * c[2])
}

/// The pins of the cranks of a linkage whose first pin is there.
fn pins([x, y]: [f64; 2]) -> [[f64; 2]; 3] {
    let (sin, cos) = 0.3_f64.sin_cos();
    [0.0, 1.0, 2.0].map(|i| [x + i * cos, y + i * sin])
}

/// Three parallel cranks whose ends are on one bar: two of them would do.
fn linkage(first: [f64; 2]) -> Scene<Network<2>, impl Effects<2>, Many, 2> {
    hung(first, 0)
}

/// The same with a chain of so many rods at the last end. From seven equations on elimination is what does the work if
/// nothing speaks against it.
fn hung(first: [f64; 2], rods: usize) -> Scene<Network<2>, impl Effects<2>, Many, 2> {
    let chain: Vec<_> = (0..rods).map(|i| [5 + i, 6 + i]).collect();
    let scene = Scene::points(6 + rods)
        .link(Rod { length: 1.0 }, [[0, 3], [1, 4], [2, 5]])
        .link(Rod { length: 1.0 }, chain)
        .link(Rod { length: 2.0 }, [[3, 5]])
        .link(Halfway {}, [[3, 5, 4]])
        .with(PlanarGravity { g: 9.81 });
    pins(first).into_iter().enumerate().fold(scene, |scene, (i, pin)| scene.pin(i, pin))
}

/// The cranks turn. Numbers are as `write` leaves them.
fn turning(first: [f64; 2], write: impl Fn(f64) -> f64) -> State<2> {
    let (sin, cos) = (-2.0_f64).sin_cos();
    let ends = pins(first).map(|[x, y]| [write(x + cos), write(y + sin)]);
    let still = [[0.0; 2]; 3];
    State::of(pins(first).into_iter().chain(ends))
        .with_momenta(still.into_iter().chain([[write(-sin), write(cos)]; 3]))
}

/// Places with a chain of so many rods at the last.
fn with_chain(mut places: Vec<[f64; 2]>, rods: usize) -> Vec<[f64; 2]> {
    for _ in 0..rods {
        let [x, y] = places[places.len() - 1];
        places.push([x + 0.6, y - 0.8]);
    }
    places
}

fn exactly(x: f64) -> f64 {
    x
}

/// As a file has it with 11 digits.
fn printed(x: f64) -> f64 {
    format!("{x:.10e}").parse().unwrap()
}

/// The one free direction remains, however far away the linkage is, and the energy is kept as near the origin.
#[test]
fn linkages_move_far_away() {
    for first in [[0.0, 0.0], [1e4, 0.0], [1e4, 2e4], [5e5, 5e6]] {
        let (scene, start) = (linkage(first), turning(first, exactly));
        let mut simulation = scene.simulate(start.clone(), Rattle::new(0.01)).unwrap();
        simulation.run(100).unwrap();
        // Started anew from there it goes on.
        let there = scene.project(&simulation.state()).unwrap();
        let mut anew = scene.simulate(there, Rattle::new(0.01)).unwrap();
        for simulation in [&mut simulation, &mut anew] {
            let before = simulation.energy();
            simulation.run(100).unwrap();
            assert_eq!(simulation.freedom(), 1, "{first:?}");
            let off = simulation.energy() - before;
            // Heights are rounded to 1e-9 where they are the largest.
            assert!(off.abs() < 1e-3, "{first:?}: {off:e}");
        }
        assert!(simulation.energy_error().abs() < 1e-3, "{first:?}: {:e}", simulation.energy_error());

        let mut ensemble = scene.ensemble(vec![start.clone(); 3], Rattle::new(0.01)).unwrap();
        ensemble.run(200);
        for (lane, state) in ensemble.states().enumerate() {
            let error = ensemble.failure(lane);
            assert!(error.is_none(), "{first:?}: {error:?}");
            let [alone, beside]: [Vec<_>; 2] =
                [simulation.positions().collect(), state.positions().collect()];
            let off = apart(&alone, &beside);
            assert!(off <= 1e-12, "{first:?}, {lane}: {off:e}");
        }
    }
}

/// By an explicit method, whose stages are off the constraints.
#[test]
fn stages_of_linkages_are_right() {
    for first in [[0.0, 0.0], [1e4, 2e4]] {
        for h in [0.02, 0.01, 1e-3, 3e-4] {
            let scene = linkage(first);
            let mut simulation = scene.simulate(turning(first, exactly), Dop853::new(h)).unwrap();
            simulation.run((0.9 / h) as u64).unwrap();
            let (off, allowed) = (simulation.energy_error(), 1e-9 + 1e-12 * first[1]);
            assert_eq!(simulation.freedom(), 1, "{first:?}, {h}");
            assert!(off.abs() < allowed, "{first:?}, {h}: {off:e}");
        }
    }
}

/// From where a mechanism branches, with fewer independent equations than anywhere else, it goes on as it moves there.
#[test]
fn starts_at_branches_go_on() {
    fn check<S: Method>(method: S, steps: u64, allowed: f64) {
        // A parallelogram that is flat, and opens.
        let scene = Scene::points(4)
            .link(Rod { length: 1.0 }, [[0, 2], [1, 3]])
            .link(Rod { length: 2.0 }, [[2, 3]])
            .pin(0, [0.0, 0.0])
            .pin(1, [2.0, 0.0]);
        let start = State::of([[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [3.0, 0.0]]);
        let start = start.with_momenta([[0.0, 0.0], [0.0, 0.0], [0.0, 1.0], [0.0, 1.0]]);
        let mut simulation = scene.simulate(start, method).unwrap();
        assert_eq!(simulation.freedom(), 2);
        simulation.run(steps).unwrap();
        assert_eq!(simulation.freedom(), 1);
        let (sin, cos) = simulation.time().sin_cos();
        let ends = [[0.0, 0.0], [2.0, 0.0], [cos, sin], [2.0 + cos, sin]].map(SVector::from);
        let off = apart(&simulation.positions().collect::<Vec<_>>(), &ends);
        assert!(off < allowed, "{}: {off:e}", simulation.method().name());
    }
    check(Rattle::new(1e-3), 1000, 1e-6);
    check(Dop853::new(0.01), 100, 1e-12);
    check(Dop853::new(0.1), 10, 1e-10);
    check(Dop853::adaptive(0.1, 1e-11), 10, 1e-10);
    check(Taylor::new(12, 0.05), 20, 1e-12);
}

/// Starts that are off by what is tolerated move, by every method, or are refused.
#[test]
fn printed_starts_move() {
    fn check<S: Method>(method: S) {
        let mut simulation = linkage([0.0; 2]).simulate(turning([0.0; 2], printed), method).unwrap();
        simulation.run(10).unwrap();
        let speed = simulation.momenta().map(|p| p.norm()).fold(0.0, f64::max);
        assert!(speed > 0.5, "{}: {speed:e}", simulation.method().name());
        assert_eq!(simulation.freedom(), 1, "{}", simulation.method().name());
    }
    check(Rattle::new(0.01));
    check(Shake::new(0.01));
    check(Baoab::new(0.01));
    check(Dop853::new(0.01));
    check(Taylor::new(10, 0.01));
    check(Bdf2::new(0.01));
    check(Lobatto::<3>::new(0.01));
}

/// And so do those that were projected, from near and from afar: no farther than they were off.
#[test]
fn starts_are_projected_across_the_motion() {
    for off in [1e-12, 1e-11, 1e-9, 1e-7, 1e-5, 1e-3] {
        for first in [[0.0; 2], [1e4, 2e4]] {
            let exact = turning(first, exactly);
            let places = exact.positions().enumerate().map(|(i, q)| {
                let off = if i < 3 { 0.0 } else { off };
                [q.x + off * (i as f64).sin(), q.y + off * (3.0 * i as f64).cos()]
            });
            let momenta = exact.momenta().map(|p| [p.x, p.y]);
            let beside = State::of(places.collect::<Vec<_>>()).with_momenta(momenta);
            let projected = linkage(first).project(&beside).unwrap();
            for (a, b) in projected.positions().zip(beside.positions()) {
                let allowed = 4.0 * off + 1e-15 * first[1] + 1e-15;
                assert!((a - b).norm() <= allowed, "{off:e} {first:?}: moved by {:e}", (a - b).norm());
            }
            let simulation = linkage(first).simulate(projected, Rattle::new(0.01)).unwrap();
            assert_eq!(simulation.freedom(), 1, "{off:e} {first:?}");
            assert!(simulation.momenta().any(|p| p.norm() > 0.5), "{off:e} {first:?}");
        }
    }
}

/// Where the frame is at the time 1, by seven equations and by six, and how much energies are off.
fn frames<S: Method>(steps: u64, method: S) -> [(Vec<SVector<f64, 3>>, f64); 2] {
    // Turning at (0.4, −0.9, 1.3).
    let start = State::of([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]).with_momenta([
        [0.0, 1.3, 0.9],
        [-1.3, 0.0, 0.4],
        [-0.9, -0.4, 0.0],
    ]);
    let scene = Scene::points(3).with(Pulls {}.over([[0, 1, 2]]));
    [scene.clone().link(Frame {}, [[0, 1, 2]]), scene.link(FrameOfSix {}, [[0, 1, 2]])].map(|scene| {
        let mut simulation = scene.simulate(start.clone(), method.clone()).unwrap();
        simulation.run(steps).unwrap();
        assert_eq!(simulation.freedom(), 3, "{}", method.name());
        (simulation.positions().collect(), simulation.energy_error())
    })
}

/// How far apart the places are.
fn apart<const D: usize>(a: &[SVector<f64, D>], b: &[SVector<f64, D>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

/// Stages are off the constraints, and so is where a step ends: it is moved there, not along the motion.
#[test]
fn stages_take_no_more_equations_than_the_start() {
    let [(right, _), _] = frames(100, Taylor::new(18, 0.01));
    let check = |method: &str, h: f64, [(seven, off), (six, off_six)]: [(Vec<_>, f64); 2]| {
        let (error, error_six) = (apart(&seven, &right), apart(&six, &right));
        println!("{method}, {h}: {error:e} and {error_six:e}, energies {off:e} and {off_six:e}");
        // Of other equations stages and projections are others, and errors as large.
        assert!(error <= 2.0 * error_six + 1e-13, "{method}, {h}: {error:e} where six have {error_six:e}");
        assert!(
            off.abs() <= 4.0 * off_six.abs() + 1e-13,
            "{method}, {h}: {off:e} where six have {off_six:e}"
        );
    };
    for steps in [5, 7, 10, 14, 20, 50, 100, 1000] {
        let h = 1.0 / steps as f64;
        check("Dop853", h, frames(steps, Dop853::new(h)));
        check("adaptive Dop853", h, frames(steps, Dop853::adaptive(h, 1e-10)));
        check("adaptive Taylor", h, frames(steps, Taylor::adaptive(10, h, 1e-10)));
        for order in [6, 10, 14] {
            check("Taylor", h, frames(steps, Taylor::new(order, h)));
        }
        check("Bdf2", h, frames(steps, Bdf2::new(h)));
        check("Lobatto", h, frames(steps, Lobatto::<4>::new(h)));
    }
}

/// A start that is off by more than where a mechanism branches has the freedom of where all hold.
#[test]
fn starts_that_are_far_off_move() {
    let (first, exact) = ([5e5, 5e6], turning([5e5, 5e6], exactly));
    let far = [5e6, 5e7];
    for (off, rods) in [4.5e-3_f64, 2e-3].into_iter().flat_map(|off| (0..4).map(move |rods| (off, rods))) {
        let mut places: Vec<_> = turning(far, exactly).positions().map(|q| [q.x, q.y]).collect();
        let (sin, cos) = (off - 2.0).sin_cos();
        places[4] = [pins(far)[1][0] + cos, pins(far)[1][1] + sin];
        let start = State::of(with_chain(places, rods));
        let simulation = hung(far, rods).simulate(start, Rattle::new(0.01)).unwrap();
        assert_eq!(simulation.freedom(), 1 + rods, "{off:e}, {rods}");
    }
    let speeds = [0.0, 4e-6, 4e-5, 4e-4].map(|off| {
        let mut places: Vec<_> = exact.positions().map(|q| [q.x, q.y]).collect();
        let (sin, cos) = (off - 2.0_f64).sin_cos();
        places[4] = [pins(first)[1][0] + cos, pins(first)[1][1] + sin];
        let (scene, mut start) = (linkage(first), State::of(places));
        assert_eq!(scene.simulate(start.clone(), Rattle::new(0.01)).unwrap().freedom(), 1, "{off:e}");
        if off > 1e-4 {
            start = scene.project(&start).unwrap(); // a step does not get from there onto the constraints
        }
        let mut simulation = scene.simulate(start, Rattle::new(0.01)).unwrap();
        simulation.run(20).unwrap();
        assert_eq!(simulation.freedom(), 1, "{off:e}");
        simulation.momenta().map(|p| p.norm()).fold(0.0, f64::max)
    });
    assert!(speeds.iter().all(|speed| (speed - speeds[0]).abs() < 1e-3 && *speed > 0.5), "{speeds:?}");
}

/// Rounding turns short cranks far away by as much.
#[test]
fn short_cranks_move_far_away() {
    let (length, first) = (1e-3, [5e5, 5e6]);
    // From none of these they come to where they are along the bar, and branch.
    for angle in (0..20).map(|i| 0.35 + 0.09 * f64::from(i)) {
        let (sin, cos) = f64::sin_cos(0.3);
        let pins = [0.0, 1.0, 2.0].map(|i| [first[0] + i * length * cos, first[1] + i * length * sin]);
        let (sin, cos) = angle.sin_cos();
        let ends = pins.map(|[x, y]| [x + length * cos, y + length * sin]);
        let scene = Scene::points(6)
            .link(Rod { length }, [[0, 3], [1, 4], [2, 5]])
            .link(Rod { length: 2.0 * length }, [[3, 5]])
            .link(Halfway {}, [[3, 5, 4]]);
        let scene = pins.into_iter().enumerate().fold(scene, |scene, (i, pin)| scene.pin(i, pin));
        let (speed, still) = (1e-3, [[0.0; 2]; 3]);
        let start = State::of(pins.into_iter().chain(ends))
            .with_momenta(still.into_iter().chain([[-sin * speed, cos * speed]; 3]));
        let start = scene.project(&start).unwrap();
        let mut simulation = scene.simulate(start, Rattle::new(1e-3)).unwrap();
        assert_eq!(simulation.freedom(), 1, "{angle}");
        simulation.run(1000).unwrap();
        assert_eq!(simulation.freedom(), 1, "{angle}");
        let moves = simulation.momenta().map(|p| p.norm()).fold(0.0, f64::max);
        assert!((moves / speed - 1.0).abs() < 1e-2, "{angle}: {moves:e}");
    }
}

/// A short rod, whose normal is known to few digits, leaves momenta of other links checked as well.
#[test]
fn short_rods_leave_other_momenta_checked() {
    let scene = Scene::points(3)
        .link(Rod { length: 1.0 }, [[0, 1]])
        .link(Rod { length: 1e-9 }, [[1, 2]])
        .pin(0, [0.0, 0.0]);
    let at = |v: f64| {
        let start = State::of([[0.0, 0.0], [1.0, 0.0], [1.0, 1e-9]]);
        scene.simulate(start.with_momenta([[0.0, 0.0], [v, 1.0], [v, 1.0]]), Rattle::new(1e-12))
    };
    let error = at(0.0).err();
    assert!(error.is_none(), "{error:?}");
    let error = at(1e-6).expect_err("a velocity that is off by 1e-6");
    assert!(matches!(error, Error::Start { cause: StartFailure::NotAlong { .. }, .. }), "{error}");
}

/// Chains far away whose normals are turned by more than is tolerated are checked and projected.
#[test]
fn long_chains_far_away_are_checked() {
    let (n, length) = (3000, 1e-3);
    let scene = Scene::points(n + 1).link(Rod { length }, (0..n).map(|i| [i, i + 1]).collect::<Vec<_>>());
    let places = (0..=n).map(|i| [0.8, 0.6].map(|part| 5e3 + part * length * i as f64));
    // It turns about its first end.
    let momenta = (0..=n).map(|i| [-0.6 * length * i as f64, 0.8 * length * i as f64]);
    let start = State::of(places.collect::<Vec<_>>()).with_momenta(momenta.collect::<Vec<_>>());
    scene.simulate(start.clone(), Rattle::new(1e-6)).unwrap();
    scene.project(&start).unwrap();
}

/// What rounding does to the normals beside one is found once for all: a chain twice as long takes twice as many
/// evaluations. Each takes its own room, which is what is counted.
#[test]
fn normals_beside_one_are_looked_at_once() {
    let [short, long] = [1000, 2000].map(|n| {
        // A long rod, whose normal is known, and a short one, whose is not, in turn.
        let rods = (0..n).map(|i| (Rod { length: if i % 2 == 0 { 1.0 } else { 1e-3 } }, [i, i + 1]));
        let scene = Scene::points(n + 1).link_each(rods.collect::<Vec<_>>());
        let along = (0..=n).map(|i| i.div_ceil(2) as f64 + 1e-3 * (i / 2) as f64);
        let places = along.map(|along| [5e3 + 0.8 * along, 5e3 + 0.6 * along]);
        // Each long rod grows at 2e-9 while all go sideways at 1: sines of 1e-9, where 1e-10 is tolerated.
        let momenta = (0..=n).map(|i| 2e-9 * i.div_ceil(2) as f64).map(|v| [0.8 * v - 0.6, 0.6 * v + 0.8]);
        let start = State::of(places.collect::<Vec<_>>()).with_momenta(momenta.collect::<Vec<_>>());
        let rooms = allocation_counter::measure(|| {
            let error = scene.simulate(start.clone(), Rattle::new(1e-6)).map(drop).expect_err("rods grow");
            assert!(matches!(error, Error::Start { cause: StartFailure::NotAlong { .. }, .. }), "{error}");
        });
        rooms.count_total
    });
    // Of all for each it would be four times as many.
    assert!(short > 1000 && 2 * long < 5 * short, "{short} and {long}");
}

/// Near the origin terms of g are as large as what is pinned.
#[test]
fn bodies_that_end_at_the_origin_are_projected() {
    use rattle::links::Rod;
    let check = |pin: [f64; 3], length: f64, end: [f64; 3]| {
        let scene = Scene::points(2).link(Rod { length }, [[0, 1]]).pin(0, pin);
        let projected = scene.project(&State::of([pin, end]));
        let projected = projected.unwrap_or_else(|error| panic!("{pin:?} {length} {end:?}: {error}"));
        let found =
            projected.positions().map(|q| (q[0] - pin[0]).hypot((q[1] - pin[1]).hypot(q[2] - pin[2])));
        let off = found.last().unwrap() - length;
        assert!(off.abs() <= 4.0 * f64::EPSILON * length, "{pin:?} {length} {end:?}: {off:e}");
    };
    let pin = [1.5622853108777695, 1.783769397613859, -0.45764863954058477];
    check(pin, 2.4149556794528357, [0.0; 3]);
    let length = 0.940366682312408;
    check([0.0, length, 0.0], length, [0.0, 2.1489705265908876e-5, 0.0]);
    for i in 0..40 {
        let pin = [2.399, 1.113, 3.771].map(|k| 2.0 * (k * f64::from(i) + 0.3).sin());
        let length = pin[0].hypot(pin[1]).hypot(pin[2]);
        for size in [0.0, 1e-12, 1e-9, 1e-6, 1e-3] {
            check(pin, length, [1.7, 2.9, 4.3].map(|k| size * (k * f64::from(i)).cos()));
        }
    }
}

/// Ends that meet have no direction.
#[test]
fn a_rod_whose_ends_meet_has_no_normal() {
    let scene = Scene::points::<3>(2).link(rattle::links::Rod { length: 1.0 }, [[0, 1]]);
    let error = scene.project(&State::of([[0.5; 3]; 2])).unwrap_err().to_string();
    assert!(error.contains("gradient") && !error.contains("finite"), "{error}");
}

/// From there Newton's step leads far beyond, where places are rounded to more.
#[test]
fn a_rod_whose_ends_nearly_meet_is_laid_where_they_are() {
    let scene = Scene::points::<3>(2).link(rattle::links::Rod { length: 1.0 }, [[0, 1]]);
    let middle = SVector::<f64, 3>::from([0.3, 0.7, -0.2]);
    let along = SVector::<f64, 3>::from([2.0, -1.0, 2.0]) / 3.0;
    let ends = [middle - 5e-10 * along, middle + 5e-10 * along].map(|q| [q.x, q.y, q.z]);
    let projected = scene.project(&State::of(ends)).unwrap();
    let ends: Vec<_> = projected.positions().collect();
    assert!(((ends[0] + ends[1]) / 2.0 - middle).norm() <= 1e-15, "{ends:?}");
    // 1e-9 has a direction to 1e-7.
    assert!((ends[1] - ends[0] - along).norm() < 1e-6, "{ends:?}");
    assert!(((ends[1] - ends[0]).norm() - 1.0).abs() <= 4.0 * f64::EPSILON, "{ends:?}");
}

/// Light joints make the sines of straight chains small: their rods are independent for all that, far away and off.
#[test]
fn light_joints_far_away_are_projected() {
    for (away, light, off) in [
        (1e5, 1e-2, [6e-3, 3e-3]),
        (1e5, 1e-3, [2.8e-3, 1.2e-3]),
        (1e4, 1e-3, [1.3e-3, 3e-4]),
        (1e3, 1e-5, [1.5e-4, 5e-5]),
        (1e3, 1e-4, [0.8e-4, 0.2e-4]),
        (1e6, 1e-2, [2e-2, -1e-2]),
    ] {
        let scene = Scene::points(3)
            .masses([1.0, light, 1.0])
            .link(Rod { length: 1.0 }, [[0, 1], [1, 2]])
            .pin(0, [away, 0.0]);
        let joint = away + 1.0 + off[0];
        let start = State::of([[away, 0.0], [joint, 0.0], [joint + 1.0 + off[1], 0.0]]);
        let state = scene.project(&start).unwrap_or_else(|error| panic!("{away:e}, {light:e}: {error}"));
        let places: Vec<_> = state.positions().collect();
        for (a, b) in [(0, 1), (1, 2)] {
            assert!(((places[b] - places[a]).norm() - 1.0).abs() < 4.0 * f64::EPSILON * away, "{away:e}");
        }
        assert_eq!(scene.simulate(state, Rattle::new(0.01)).unwrap().freedom(), 2, "{away:e}, {light:e}");
    }
}

/// A link without curvature, off by as much as its coordinates allow, and a light joint: both of its links count.
#[test]
fn light_joints_that_are_off_hold() {
    constraint! { struct Beside { by } |a: [f64; 2], b: [f64; 2]| b[0] - a[0] - by }
    for light in [5e-4, 1e-4] {
        let away = 5e6;
        let scene = Scene::points(3)
            .masses([1.0, light, 1.0])
            .link(Rod { length: 1.0 }, [[0, 1]])
            .link(Beside { by: 1.0 }, [[1, 2]])
            .pin(0, [away, 0.0]);
        let start = State::of([[away, 0.0], [away + 1.0, 0.0], [away + 2.0 + 4e-4, 0.0]]);
        let mut simulation = scene.simulate(start, Rattle::new(0.01)).unwrap();
        assert_eq!(simulation.freedom(), 2, "{light:e}");
        simulation.run(10).unwrap();
        let places: Vec<_> = simulation.positions().collect();
        for off in [(places[1] - places[0]).norm() - 1.0, places[2].x - places[1].x - 1.0] {
            assert!(off.abs() <= 4.0 * f64::EPSILON * away, "{light:e}: {off:e}");
        }
    }
}

/// `project` moves a mechanism by no more than it is off, along its motion too.
#[test]
fn linkages_are_not_projected_along_their_motion() {
    let near = [(1e-4, 2e-6), (1e-3, 2e-6), (1e-3, 5e-6), (1e-2, 2e-6), (1e-2, 2e-5)];
    let far = [(0.03, 2e-3), (0.1, 2e-3), (0.1, 2e-5)];
    for (at, rods) in [[0.0, 0.0], [1e4, 2e4]].into_iter().flat_map(|at| [0, 1, 4].map(|rods| (at, rods))) {
        for (r, turned) in near.into_iter().chain(far) {
            let (scene, start) = (hung(at, rods), turning(at, exactly));
            let (sin, cos) = (-2.0_f64 + turned).sin_cos();
            let mut places: Vec<_> = start.positions().map(<[f64; 2]>::from).collect();
            let pin = places[1];
            places[4] = [pin[0] + (1.0 + r) * cos, pin[1] + (1.0 + r) * sin];
            let places = with_chain(places, rods);
            let state = scene.project(&State::of(places.clone())).unwrap();
            let moved = state.positions().zip(&places).map(|(q, from)| (q - SVector::from(*from)).norm());
            let moved = moved.fold(0.0, f64::max);
            assert!(moved < 4.0 * r, "{r:e}, {turned:e}, {rods}: moved by {moved:e}");
            let simulation = scene.simulate(state, Rattle::new(0.01)).unwrap();
            assert_eq!(simulation.freedom(), 1 + rods, "{r:e}, {turned:e}, {rods}");
        }
    }
}

/// Long chains of light and heavy joints far away, straight and off.
#[test]
fn chains_of_light_joints_far_away_are_projected() {
    let links = 10;
    for seed in 0..5 {
        let masses = (0..=links).map(|i| if i % 2 == 1 { 1e-4 } else { 1.0 });
        let chain: Vec<_> = (0..links).map(|i| [i, i + 1]).collect();
        let scene =
            Scene::points(links + 1).masses(masses).link(Rod { length: 1.0 }, chain).pin(0, [1e3, 0.0]);
        let off = |i: usize| if i == 0 { 0.0 } else { 1e-3 * (3.7 * i as f64 + 0.9 * f64::from(seed)).sin() };
        let state = State::of((0..=links).map(|i| [1e3 + i as f64 + off(i), 0.0]));
        let state = scene.project(&state).unwrap_or_else(|error| panic!("{seed}: {error}"));
        assert_eq!(scene.simulate(state, Rattle::new(0.01)).unwrap().freedom(), links, "{seed}");
    }
}
