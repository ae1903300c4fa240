//! One motion, whichever way its multipliers are found: few equations at once, rods in a line by streams over memory,
//! or as of any network; and wherever it is.

use crate::common::linked::*;
use crate::common::*;
use rattle::bodies::Many;
use rattle::links::Coincident;
use rattle::links::planar::{Pendulum, Slider};
use rattle::network::{LinearAlgebra, Network};
use rattle::prelude::*;

type Net = Scene<Network<2>, (), Many, 2>;

fn place(body: usize) -> [f64; 2] {
    let turn = 0.9 * body as f64;
    [body as f64 + 0.3 * turn.sin(), 0.5 * turn.cos()]
}

/// Rods between bodies of unequal masses, some of them pinned.
fn net(bodies: usize, rods: &[[usize; 2]], pins: &[usize]) -> Net {
    let rods = rods.iter().map(|rod| {
        let [a, b] = rod.map(place);
        (Rod { length: (a[0] - b[0]).hypot(a[1] - b[1]) }, *rod)
    });
    let scene = Scene::points(bodies).link_each(rods).masses((0..bodies).map(|i| 1.0 + 0.25 * i as f64));
    pins.iter().fold(scene, |scene, &pin| scene.pin(pin, place(pin)))
}

fn start(scene: &Net, bodies: usize) -> State<2> {
    let pushed = |i: usize| [(1.7 * i as f64).sin(), (2.3 * i as f64).cos() - 0.4];
    let free = State::of((0..bodies).map(place)).with_momenta((0..bodies).map(pushed));
    scene.project(&free).unwrap()
}

/// Where this leads, and the corrections on the way.
fn end(scene: &Net, start: &State<2>, h: f64, steps: u64) -> (Vec<f64>, u64) {
    let scene = scene.clone().with(PlanarGravity { g: 1.0 });
    let mut simulation = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
    simulation.run(steps).unwrap();
    // Coordinates are as large as there are bodies, and rods of length 1.
    let rounding = 8.0 * f64::EPSILON * start.len() as f64;
    assert!(simulation.constraint_residual() <= rounding, "{:e}", simulation.constraint_residual());
    (phase(&simulation.state()), simulation.counts().corrections)
}

/// Sizes that are compiled, (1, 1) to (3, 3), and one that is not.
#[test]
fn few_equations_at_once_or_by_lists() {
    let held = Pendulum { length: 1.5, pivot: [2.0, 1.5] };
    let nets = [
        (2, net(2, &[[0, 1]], &[0])),
        (2, net(2, &[[0, 1]], &[])),
        (3, net(3, &[[0, 1], [1, 2]], &[0])),
        (3, net(3, &[[1, 0], [2, 1]], &[0]).link(held, [[2]])),
        (4, net(4, &[[0, 1], [2, 1], [2, 3]], &[0])),
        (3, net(3, &[[0, 1], [1, 2], [2, 0]], &[])),
    ];
    for (number, (bodies, scene)) in nets.into_iter().enumerate() {
        let start = start(&scene, bodies);
        let (at_once, corrections) = end(&scene, &start, 0.01, 100);
        for algebra in [LinearAlgebra::Elimination, LinearAlgebra::Orthogonal] {
            let (other, others) = end(&scene.clone().linear_algebra(algebra), &start, 0.01, 100);
            let difference = apart(&at_once, &other);
            println!("net {number}, {algebra:?}: {difference:.1e}, {corrections} and {others} corrections");
            assert!(difference <= 1e-12, "net {number}, {algebra:?}: {difference:e}");
            assert!(corrections.abs_diff(others) <= 5, "net {number}: {corrections} {others}");
        }
        // Long steps look inside, and follow their roots: what goes on from the plain case is the same.
        let long = 0.15;
        let difference = apart(
            &end(&scene, &start, long, 8).0,
            &end(&scene.linear_algebra(LinearAlgebra::Elimination), &start, long, 8).0,
        );
        assert!(difference <= 1e-11, "net {number}, long steps: {difference:e}");
    }
}

/// Rods from end to end are a line; named backwards, or from their other ends, they are any chain.
#[test]
fn rods_in_a_line_or_not() {
    for (rods, pins) in [(40, &[0][..]), (41, &[]), (40, &[0, 40]), (41, &[41]), (7, &[0]), (8, &[8])] {
        let bodies = rods + 1;
        let line: Vec<[usize; 2]> = chain(rods);
        let backwards: Vec<_> = line.iter().rev().copied().collect();
        let turned: Vec<_> = line.iter().map(|&[a, b]| [b, a]).collect();
        let scene = net(bodies, &line, pins);
        let start = start(&scene, bodies);
        let (in_line, corrections) = end(&scene, &start, 0.01, 100);
        for other in [backwards, turned] {
            let (other, others) = end(&net(bodies, &other, pins), &start, 0.01, 100);
            let difference = apart(&in_line, &other);
            println!("{rods} rods, {pins:?}: {difference:.1e}, {corrections} and {others} corrections");
            assert!(difference <= 1e-11, "{rods} rods, {pins:?}: {difference:e}");
            assert!(corrections.abs_diff(others) <= 10, "{rods} rods: {corrections} {others}");
        }
    }
}

/// A step that is too long ends with the same reason, and leaves all as it was; a state goes on to the bit.
#[test]
fn few_equations_fail_and_go_on_as_others() {
    let scene = net(3, &[[0, 1], [1, 2], [2, 0]], &[]);
    let start = start(&scene, 3);
    let faster = start.momenta().map(|p| 30.0 * p);
    let start = State::of(start.positions()).with_momenta(faster);
    let reason = |scene: &Net| {
        let mut simulation = scene.simulate(start.clone(), Rattle::new(0.5)).unwrap();
        let before = bits(&simulation.state());
        let reason = simulation.step().unwrap_err().to_string();
        assert_eq!(bits(&simulation.state()), before);
        reason
    };
    let at_once = reason(&scene);
    assert_eq!(at_once, reason(&scene.clone().linear_algebra(LinearAlgebra::Elimination)));

    let whole = scene.simulate(start.clone(), Rattle::new(1e-3)).unwrap();
    let (mut whole, mut first) = (whole.clone(), whole);
    whole.run(60).unwrap();
    first.run(25).unwrap();
    let mut rest = scene.simulate(first.state(), Rattle::new(1e-3)).unwrap();
    rest.run(35).unwrap();
    assert_eq!(bits(&whole.state()), bits(&rest.state()));
}

/// Where coordinates are zero, what is rounded is still as large as those of the bodies that are linked there: every
/// method goes on, also begun again from each state, and to the same places as seen from there.
#[test]
fn what_is_at_the_origin_moves_as_elsewhere() {
    macro_rules! alike {
        ($name:literal, $scene:expr, $origins:expr, $($method:expr),*) => {$(
            let (method, mut first) = ($method, None);
            for origin in $origins {
                let (scene, start) = $scene(origin);
                let start = scene.staggered(&scene.project(&start).unwrap(), &method).unwrap();
                let which = format!("{}, {}, h = {}, at {origin:?}", $name, method.name(), method.step_size());
                let mut simulation = scene.simulate(start.clone(), method.clone()).unwrap();
                for _ in 0..60 {
                    simulation.step().unwrap_or_else(|error| panic!("{which}: {error}"));
                    let again = scene.simulate(simulation.state(), method.clone());
                    again.map(drop).unwrap_or_else(|error| panic!("{which}, begun again: {error}"));
                }
                let mut ensemble = scene.ensemble(vec![start; 17], method.clone()).unwrap();
                ensemble.run(60);
                assert!(ensemble.failure(0).is_none(), "{which}, in lanes: {}", ensemble.failure(0).unwrap());
                let seen = |q: nalgebra::SVector<f64, _>| [q[0] - origin[0], q[1] - origin[1]];
                let end: Vec<f64> = simulation.positions().flat_map(seen).collect();
                let off = apart(&end, first.get_or_insert_with(|| end.clone()));
                assert!(off < 1e-10, "{which}: {off:e}");
            }
        )*};
    }
    macro_rules! by_every_method {
        ($name:literal, $scene:expr, $origins:expr) => {
            for h in [0.02, 0.005] {
                alike!(
                    $name,
                    $scene,
                    $origins,
                    Rattle::new(h),
                    Rattle::new(h).solved_by(Broyden),
                    Rattle::new(h).guess(Extrapolated),
                    Shake::new(h),
                    PositionVerlet::new(h),
                    Composition::new(SUZUKI_1990_ORDER_4, h),
                    Lobatto::<2>::new(h),
                    Lobatto::<3>::new(h),
                    Lobatto::<4>::new(h).guess(Extrapolated),
                    Lobatto::<5>::new(h),
                    Dop853::new(h),
                    Taylor::new(12, h),
                    Bdf2::new(h)
                );
            }
        };
    }
    let slides = |at: [f64; 2]| {
        let rail = Slider { point: at, direction: [1.0, 0.0] };
        let scene = Scene::points(2).link(rail, [[0]]).link(Rod { length: 1.0 }, [[0, 1]]);
        let start = State::of([at, [at[0] + 0.6, at[1] - 0.8]]);
        (scene.with(PlanarGravity { g: 9.81 }), start)
    };
    by_every_method!("slider", slides, [[3.0, 1.0], [0.0, 0.0], [0.5, 0.0], [0.0, 1e-3]]);
    let hangs = |at: [f64; 3]| {
        let scene = Scene::points(3).pin(0, at).link(Coincident {}, [[0, 1]]);
        let end = [at[0] + 0.6, at[1], at[2] + 0.8];
        let scene = scene.link(Rod3 { length: 1.0 }, [[1, 2]]);
        (scene.with(rattle::potentials::Gravity { g: 1.0 }), State::of([at, at, end]))
    };
    by_every_method!("pivot", hangs, [[3.0, 2.0, 1.0], [0.0; 3], [0.5, 0.0, 0.0], [0.0, 0.0, 1.0]]);
}

/// A body on a rod by a method that looks for other sheets: that it hangs from above the origin, and not there, takes
/// no further look, and so no room.
#[test]
fn a_pin_is_where_it_is_when_other_sheets_are_looked_for() {
    fn by<S: Method>(method: S) {
        for pin in [[0.0, 0.0], [0.0, 5.0], [-3.0, 4.0], [100.0, -1.0]] {
            let scene = Scene::points(2).link(Rod { length: 1.0 }, [[0, 1]]).pin(0, pin);
            let bob = [pin[0] + 0.1, pin[1] - 0.99_f64.sqrt()];
            let start = scene.project(&State::of([pin, bob])).unwrap();
            let scene = scene.with(PlanarGravity { g: 1.0 }.over([[0], [1]]));
            let mut simulation = scene.simulate(start, method.clone()).unwrap();
            let allocated = allocation_counter::measure(|| simulation.run(200).unwrap());
            assert_eq!(allocated.count_total, 0, "{} at {pin:?}", method.name());
        }
    }
    by(Lobatto::<3>::new(0.02));
    by(Dop853::new(0.02));
    by(Taylor::new(10, 0.02));
}

/// A start may be off its pin by rounding, and more: the body is where the pin is, alone and in lanes.
#[test]
fn a_pinned_body_is_at_its_pin() {
    let scene = Scene::points(2).link(Rod { length: 1.0 }, [[0, 1]]).pin(0, [0.3, 0.0]);
    let scene = scene.with(PlanarGravity { g: 1.0 }.over([[0], [1]]));
    let start = || State::of([[0.3 + 5e-12, 0.0], [1.3, 0.0]]);
    let mut simulation = scene.simulate(start(), Rattle::new(0.01)).unwrap();
    let mut exact = scene.simulate(State::of([[0.3, 0.0], [1.3, 0.0]]), Rattle::new(0.01)).unwrap();
    let mut lanes = scene.ensemble((0..8).map(|_| start()), Rattle::new(0.01)).unwrap();
    let mut later = scene.simulate(start(), Rattle::new(0.01)).unwrap();
    simulation.run(50).unwrap();
    later.resume(&simulation.checkpoint()).unwrap();
    later.run(50).unwrap();
    simulation.run(50).unwrap();
    exact.run(100).unwrap();
    lanes.run(100);
    assert_eq!(bits(&simulation.state()), bits(&exact.state()));
    assert_eq!(bits(&simulation.state()), bits(&later.state()));
    assert!(simulation.constraint_residual() < 1e-15 && lanes.plan().in_lanes == 8);
    assert!(apart(&phase(&lanes.state(3)), &phase(&exact.state())) < 1e-13);
}

/// What a run by another linear algebra wrote is refused, and by the same goes on bit for bit.
#[test]
fn the_linear_algebra_of_a_checkpoint_is_that_of_its_start() {
    // A parallelogram, which is folded flat at 0, and a tail.
    let rods = [[0, 2], [2, 3], [3, 1], [2, 4], [4, 5], [5, 6], [6, 7]];
    let scene = Scene::points(8).link(Rod { length: 1.0 }, rods).pin(0, [0.0; 2]).pin(1, [1.0, 0.0]);
    let at = |angle: f64| {
        let (x, y) = (angle.cos(), angle.sin());
        let tail = (1..5).map(|i| [x, y - f64::from(i)]);
        let places = [[0.0; 2], [1.0, 0.0], [x, y], [x + 1.0, y]].into_iter().chain(tail);
        scene.simulate(State::of(places), Rattle::new(0.01)).unwrap()
    };
    let by = |angle: f64| at(angle).system().components().next().unwrap().by;
    assert_eq!((by(1e-4), by(1.0)), (LinearAlgebra::Orthogonal, LinearAlgebra::Elimination));
    for angle in [1e-4, 1.0] {
        let (mut first, mut same, mut other) = (at(angle), at(angle), at(1.0 + 1e-4 - angle));
        first.run(5).unwrap();
        same.resume(&first.checkpoint()).unwrap();
        let error = other.resume(&first.checkpoint()).unwrap_err().to_string();
        assert!(error.contains("linear algebra") && other.steps() == 0, "{error}");
        first.run(5).unwrap();
        same.run(5).unwrap();
        assert_eq!(bits(&same.state()), bits(&first.state()));
    }
}
