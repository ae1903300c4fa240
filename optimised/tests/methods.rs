//! Every method under the same laws: order, reversal, symplecticity, constraints and energy, from one table.

use crate::common::symplectic::defect as symplectic_defect;
use crate::common::*;
use crate::every_method::{NONE, OneOf, Row, rows};
use rattle::bodies::{Count, Many};
use rattle::composition::*;
use rattle::effect::Effects;
use rattle::links::planar::Rod;
use rattle::prelude::*;
use rattle::scene::Hold;

/// The motion from `start`, whose momenta are of the same time, in `n` steps.
fn run<C: Hold<D>, E: Effects<D>, N: Count, const D: usize>(
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
    method: OneOf,
    n: u32,
) -> State<D> {
    let mut simulation = scene.simulate(scene.staggered(start, &method).unwrap(), method).unwrap();
    simulation.run(n.into()).unwrap();
    assert_eq!(simulation.steps(), u64::from(n));
    simulation.state()
}

/// Where a method says that the bodies are after `n` steps, and where they are; momenta too unless staggered.
fn error<const D: usize>(method: OneOf, found: &State<D>, q: &[f64], p: &[f64]) -> f64 {
    let off = |found: Vec<f64>, exact: &[f64]| {
        let moving = &found[found.len() - exact.len()..]; // pinned bodies come first
        moving.iter().zip(exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let positions = off(found.positions().flat_map(<[f64; D]>::from).collect(), q);
    let momenta = off(found.momenta().flat_map(<[f64; D]>::from).collect(), p);
    if method.momentum_delay() == 0.0 { positions.max(momenta) } else { positions }
}

fn lemniscate_at_1(method: OneOf, n: u32) -> f64 {
    let rows = table("lemniscate_gravity");
    let row = rows
        .iter()
        .find(|row| row.text("ic") == "f64" && row.number("theta_deg") == 45.0 && row.number("t") == 1.0);
    let row = row.unwrap();
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let method = method.with_step(1.0 / f64::from(n));
    let found = run(&scene, &billiard_45(), method, n);
    error(method, &found, &row.numbers(["x", "y", "z"]), &row.numbers(["vx", "vy", "vz"]))
}

/// The spherical pendulum at angle π/3 from the bottom, with the horizontal speed 3/2.
fn swinging() -> State<3> {
    let (sin, cos) = std::f64::consts::FRAC_PI_3.sin_cos();
    State::at([sin, 0.0, -cos]).moving([0.0, 1.5, 0.0])
}

fn spherical_at_1(method: OneOf, n: u32) -> f64 {
    let rows = table("spherical_pendulum");
    let row = rows.iter().find(|row| row.text("case") == "a" && row.number("t") == 1.0).unwrap();
    let scene = Scene::on(Sphere { r: 1.0 }).with(Gravity { g: 1.0 });
    let method = method.with_step(1.0 / f64::from(n));
    let found = run(&scene, &swinging(), method, n);
    error(method, &found, &row.numbers(["x", "y", "z"]), &row.numbers(["vx", "vy", "vz"]))
}

/// Two rods, the first one pinned at its end, from rest: over the corner.
fn double_pendulum() -> (Scene<rattle::network::Network<2>, impl Effects<2> + Clone, Many, 2>, State<2>) {
    let (scene, start) = rods();
    (scene.with(PlanarGravity { g: 1.0 }), start)
}

fn rods() -> (Scene<rattle::network::Network<2>, (), Many, 2>, State<2>) {
    let scene = Scene::points(3).link(Rod { length: 1.0 }, [[0, 1], [1, 2]]).pin(0, [0.0, 0.0]);
    (scene, State::of([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]))
}

fn double_at_2(method: OneOf, n: u32) -> f64 {
    let rows = table("double_pendulum");
    let row = rows.iter().find(|row| row.text("case") == "equal" && row.number("t") == 2.0).unwrap();
    let (scene, start) = double_pendulum();
    let method = method.with_step(2.0 / f64::from(n));
    let found = run(&scene, &start, method, n);
    error(method, &found, &row.numbers(["x1", "y1", "x2", "y2"]), &row.numbers(["vx1", "vy1", "vx2", "vy2"]))
}

/// Slope of log error over log step, by least squares.
fn slope(steps: &[u32], errors: &[f64]) -> f64 {
    let points = || steps.iter().zip(errors).map(|(&n, error)| (-f64::from(n).ln(), error.ln()));
    let count = steps.len() as f64;
    let (x, y) = points().fold((0.0, 0.0), |(sx, sy), (x, y)| (sx + x / count, sy + y / count));
    let (above, below) =
        points().fold((0.0, 0.0), |(a, b), (u, v)| (a + (u - x) * (v - y), b + (u - x) * (u - x)));
    above / below
}

#[test]
fn errors_fall_with_the_order_of_the_method() {
    type ErrorAt = fn(OneOf, u32) -> f64;
    let problems: [(&str, ErrorAt); 3] = [
        ("lemniscate", lemniscate_at_1),
        ("spherical pendulum", spherical_at_1),
        ("double pendulum", double_at_2),
    ];
    let mut wrong = Vec::new();
    for Row { name, order, method, windows, .. } in rows() {
        assert_eq!(method.order(), order, "{name}");
        for ((problem, at), [first, last]) in problems.into_iter().zip(windows) {
            if [first, last] == NONE {
                continue;
            }
            let ratio = f64::from(last) / f64::from(first);
            let steps: Vec<u32> =
                (0..=4).map(|k| (f64::from(first) * ratio.powf(f64::from(k) / 4.0)).round() as u32).collect();
            let errors: Vec<f64> = steps.iter().map(|&n| at(method, n)).collect();
            let found = slope(&steps, &errors);
            println!("{name:40} {problem:18} {found:6.3}  {:.1e} … {:.1e}", errors[0], errors[4]);
            if (found - f64::from(order)).abs() > 0.15 {
                wrong.push(format!("{name}, {problem}: order {found:.3}, {steps:?} {errors:?}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn order_ten_reaches_rounding_in_96_steps() {
    let method = OneOf::Composed(Composition::new(SOFRONIOU_SPALETTA_2005_ORDER_10, 1.0));
    let errors = [40, 96].map(|n| lemniscate_at_1(method, n));
    assert!(errors[0] > 1e-11 && errors[1] <= 1e-14, "{errors:?}");
}

potential! {
    /// Gravity, and a force that changes from place to place: methods that take it at a wrong one show.
    struct Uneven { g }
    |x, y, z| g * z + x^2 * y + x * z / 2 + y^2 / 3
}

potential! {
    /// The same in the plane.
    struct UnevenPlane { g }
    |x, y| g * y + x^2 * y / 2 + x * y / 3
}

/// On the way over the lemniscate, after so many steps of 0.01; nothing is symmetric there.
fn on_the_way(steps: u64) -> State<3> {
    let scene = Scene::on(SURFACE).with(Uneven { g: 1.0 });
    let mut simulation = scene.simulate(billiard(0.7), Rattle::new(0.01)).unwrap();
    simulation.run(steps).unwrap();
    simulation.state()
}

/// The double pendulum in an uneven field.
fn uneven_pendulum() -> (Scene<rattle::network::Network<2>, impl Effects<2> + Clone, Many, 2>, State<2>) {
    let (scene, start) = rods();
    (scene.with(UnevenPlane { g: 1.0 }), start)
}

/// It when both rods swing.
fn both_swinging() -> State<2> {
    let (scene, start) = uneven_pendulum();
    let mut simulation = scene.simulate(start, Rattle::new(0.01)).unwrap();
    simulation.run(130).unwrap();
    simulation.state()
}

fn largest_difference<const D: usize>(a: &State<D>, b: &State<D>) -> (f64, f64) {
    let largest =
        |a: Vec<_>, b: Vec<_>| a.into_iter().zip(b).map(|(a, b)| distance::<D>(a, b)).fold(0.0, f64::max);
    let q = largest(a.positions().collect(), b.positions().collect());
    (q, largest(a.momenta().collect(), b.momenta().collect()))
}

/// What a law is off by where it does not hold: hundreds of times what rounding would make of it.
const BROKEN: f64 = 1e-9;

/// Steps after which that is seen: the first step of BDF2 is another method's.
const SOME: u32 = 3;

/// How far so many steps forth and back lead from the start.
fn there_and_back<C: Hold<D>, E: Effects<D>, N: Count, const D: usize>(
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
    method: OneOf,
    steps: u32,
) -> (f64, f64) {
    let mut forth = scene.simulate(start.clone(), method).unwrap();
    forth.run(steps.into()).unwrap();
    assert!(largest_difference(&forth.state(), start).0 > 1e-3, "nothing moved");
    let back = method.with_step(-method.step_size());
    let along = !matches!(method, OneOf::Bdf2(_)); // otherwise momenta are not those of motion along the constraint
    let turn = if along { forth.state() } else { scene.project(&forth.state()).unwrap() };
    let mut back = scene.simulate(turn, back).unwrap();
    back.run(steps.into()).unwrap();
    largest_difference(&back.state(), start)
}

#[test]
fn symmetric_methods_go_back_and_others_do_not() {
    let surface = Scene::on(SURFACE).with(Uneven { g: 1.0 });
    let (linked, _) = uneven_pendulum();
    let mut symmetric = 0;
    for Row { name, method, unstructured, .. } in rows() {
        let steps = if unstructured.is_some() { SOME } else { 1 };
        let [one, two] = unstructured.unwrap_or([0.01; 2]).map(|h| method.with_step(h));
        let on_surface = there_and_back(&surface, &on_the_way(77), one, steps);
        let on_links = there_and_back(&linked, &both_swinging(), two, steps);
        for (dq, dp) in [on_surface, on_links] {
            println!("{name:40} {dq:.1e} {dp:.1e}");
            if method.is_symmetric() {
                // A rounding or two of q and p, which low parts keep from adding up.
                assert!(dq <= 4e-16 && dp <= 2e-15, "{name}: {dq:e}, {dp:e}");
                symmetric += 1;
            } else {
                let shows = if unstructured.is_some() { BROKEN } else { 1e-5 };
                assert!(dq.max(dp) > shows, "{name}: {dq:e}, {dp:e}");
            }
        }
    }
    assert_eq!(symmetric, 2 * 20);
}

/// SHAKE goes back once position and momentum have changed places in time.
#[test]
fn shake_goes_back_with_the_momentum_on_the_other_side() {
    let scene = Scene::on(SURFACE).with(Uneven { g: 1.0 });
    let method = Shake::new(0.01);
    let mut forth = scene.simulate(scene.staggered(&on_the_way(77), &method).unwrap(), method).unwrap();
    let states: Vec<_> = (0..3)
        .map(|_| {
            forth.step().unwrap();
            forth.state()
        })
        .collect();
    let start = State::of(states[1].positions()).with_momenta(states[2].momenta());
    let mut back = scene.simulate(start, method.with_step(-0.01)).unwrap();
    back.step().unwrap();
    let (q, p) = (states[0].positions().next().unwrap(), states[1].momenta().next().unwrap());
    let (dq, dp) = (distance(back.position(), q), distance(back.momentum(), p));
    assert!(dq <= 1e-15 && dp <= 1e-13, "{dq:e}, {dp:e}");
}

#[test]
fn methods_are_symplectic_or_shown_not_to_be() {
    let surface = Scene::on(SURFACE).with(Uneven { g: 1.0 });
    let (linked, _) = uneven_pendulum();
    for Row { name, method, unstructured, .. } in rows() {
        let steps = if unstructured.is_some() { SOME } else { 1 };
        let [one, two] = unstructured.unwrap_or([0.02; 2]).map(|h| method.with_step(h));
        let on_surface =
            symplectic_defect(&surface, &on_the_way(40), |state| run(&surface, &state, one, steps));
        let on_links = symplectic_defect(&linked, &both_swinging(), |state| run(&linked, &state, two, steps));
        println!("{name:40} {on_surface:.1e} {on_links:.1e}");
        if unstructured.is_some() {
            assert!(on_surface > BROKEN && on_links > BROKEN, "{name}: {on_surface:e}, {on_links:e}");
        } else {
            assert!(on_surface <= 2e-11 && on_links <= 2e-11, "{name}: {on_surface:e}, {on_links:e}");
        }
    }
    // The law sees a part in 10⁹ of the momentum that goes astray.
    let slowed = |state: State<3>| {
        let momenta: Vec<_> = state.momenta().map(|p| p * (1.0 - 1e-9)).collect();
        state.with_momenta(momenta)
    };
    assert!(symplectic_defect(&surface, &on_the_way(40), slowed) > 2e-10);
}

#[test]
#[cfg(long)]
fn every_method_stays_on_the_constraint() {
    let surface = Scene::on(SURFACE).with(Uneven { g: 1.0 });
    let (linked, start) = uneven_pendulum();
    for Row { name, method, .. } in rows() {
        let method = method.with_step(0.01);
        let mut particle =
            surface.simulate(surface.staggered(&billiard(0.7), &method).unwrap(), method).unwrap();
        let mut rods = linked.simulate(linked.staggered(&start, &method).unwrap(), method).unwrap();
        let mut worst = [0.0_f64; 4];
        for _ in 0..2000 {
            particle.step().unwrap();
            rods.step().unwrap();
            let found = [
                particle.constraint_residual(),
                particle.cotangent_residual(),
                rods.constraint_residual(),
                rods.cotangent_residual(),
            ];
            worst = std::array::from_fn(|i| worst[i].max(found[i]));
        }
        println!("{name:40} {worst:?}");
        let [g, gp, rod, rod_p] = worst;
        assert!(g <= 1e-15 && rod <= 4e-15, "{name}: {worst:?}");
        if matches!(method, OneOf::Bdf2(_)) {
            assert!(gp > 1e-3 && rod_p > 1e-3, "{name}: momenta of differences are not tangent: {worst:?}");
        } else if method.momentum_delay() == 0.0 {
            assert!(gp <= 2e-15 && rod_p <= 2e-14, "{name}: {worst:?}");
        } else {
            assert!(gp > 1e-3 && rod_p > 1e-3, "{name}: momenta half a step away are not tangent: {worst:?}");
        }
    }
}

/// Energy errors of a run in four quarters: the mean of each, and the largest of each.
fn energy_errors<C: Hold<D>, E: Effects<D>, N: Count, const D: usize>(
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
    method: OneOf,
    time: f64,
) -> [(f64, f64); 4] {
    let mut simulation = scene.simulate(scene.staggered(start, &method).unwrap(), method).unwrap();
    // A method that sees energy at another time is compared with itself.
    simulation.step().unwrap();
    let first = if method.momentum_delay() == 0.0 { 0.0 } else { simulation.energy_error() };
    let quarter = (0.25 * time / method.step_size()) as u64;
    let mut found = [(0.0, 0.0_f64); 4];
    for (mean, largest) in &mut found {
        let see = |now: &Simulation<_, _, D>| {
            let error = now.energy_error() - first;
            *mean += error / quarter as f64;
            *largest = largest.max(error.abs());
        };
        simulation.run_with(quarter, see).unwrap();
    }
    found
}

#[test]
#[cfg(long)]
fn energy_does_not_drift() {
    let scene = Scene::on(Sphere { r: 1.0 }).with(Gravity { g: 1.0 });
    for Row { name, order, method, windows, unstructured } in rows() {
        let method = method.with_step(if order == 1 { 0.01 } else { 1.0 / f64::from(windows[1][0]) });
        // 500 swings: the means differ by where in a swing a quarter ends.
        let quarters = energy_errors(&scene, &swinging(), method, 2000.0);
        let amplitude = quarters.iter().fold(0.0_f64, |largest, quarter| largest.max(quarter.1));
        let drift = (quarters[3].0 - quarters[0].0).abs();
        println!("{name:40} h = {:.4}: {amplitude:.1e}, drift {drift:.1e}", method.step_size());
        assert!(amplitude > 1e-13, "{name}: too small to see a drift in");
        if unstructured.is_some() {
            assert!(drift > 0.1 * amplitude, "{name}: {drift:e} of {amplitude:e}");
        } else {
            assert!(drift <= 1e-3 * amplitude + 6e-14, "{name}: {drift:e} of {amplitude:e}");
        }
    }
}

#[test]
#[cfg(long)]
fn energy_stays_bounded_in_chaos() {
    let surface = Scene::on(SURFACE).with(Uneven { g: 1.0 });
    let (linked, start) = uneven_pendulum();
    for Row { name, method, .. } in rows() {
        let method = method.with_step(0.01);
        for (problem, quarters) in [
            ("lemniscate", energy_errors(&surface, &billiard_45(), method, 200.0)),
            ("double pendulum", energy_errors(&linked, &start, method, 200.0)),
        ] {
            let [a, b, c, d] = quarters.map(|quarter| quarter.1);
            let (first, last) = (a.max(b), c.max(d));
            println!("{name:40} {problem:16} {first:.1e} {last:.1e}");
            // Where the surface bends most, errors are largest; how near a path comes is chance.
            assert!(last <= 8.0 * first + 1e-13, "{name}, {problem}: {first:e}, then {last:e}");
        }
    }
}

potential! {
    /// A spring that stiffens.
    struct Spring { k }
    |x| k * (x^2 / 2 + x^4 / 4)
}

/// Without constraints the methods are those of the textbooks, written out here.
#[test]
fn free_bodies_move_as_in_textbooks() {
    let (h, force) = (0.1, |x: f64| -(x + x * x * x));
    let kick_drift_kick = |x: f64, p: f64| {
        let p = p + 0.5 * h * force(x);
        let x = x + h * p;
        (x, p + 0.5 * h * force(x))
    };
    let drift_kick_drift = |x: f64, p: f64| {
        let x = x + 0.5 * h * p;
        let p = p + h * force(x);
        (x + 0.5 * h * p, p)
    };
    let kick_drift = |x: f64, p: f64| {
        let p = p + h * force(x);
        (x + h * p, p)
    };
    type Textbook<'a> = &'a dyn Fn(f64, f64) -> (f64, f64);
    let rows: [(OneOf, Textbook); 5] = [
        (OneOf::Rattle(Rattle::new(h)), &kick_drift_kick),
        (OneOf::Geodesic(Geodesic::new(3, h)), &kick_drift_kick),
        (OneOf::PositionVerlet(PositionVerlet::new(h)), &drift_kick_drift),
        (OneOf::Euler(SymplecticEuler::new(h)), &kick_drift),
        (OneOf::Shake(Shake::new(h)), &kick_drift),
    ];
    for (method, textbook) in rows {
        let start = State::at([0.8]).moving([0.5]);
        let mut simulation = Scene::point().with(Spring { k: 1.0 }).simulate(start, method).unwrap();
        let (mut x, mut p) = (0.8, 0.5);
        for step in 1..=50 {
            simulation.step().unwrap();
            (x, p) = textbook(x, p);
            let (dx, dp) = (simulation.position().x - x, simulation.momentum().x - p);
            assert!(dx.abs() <= 3e-14 && dp.abs() <= 3e-14, "{method:?}, step {step}: {dx:e}, {dp:e}");
        }
    }
}

#[test]
fn shake_is_rattle_seen_half_a_step_earlier() {
    let scene = Scene::on(SURFACE).with(Uneven { g: 1.0 });
    let h = 0.01;
    let mut rattle = scene.simulate(on_the_way(77), Rattle::new(h)).unwrap();
    let mut shake =
        scene.simulate(scene.staggered(&on_the_way(77), &Shake::new(h)).unwrap(), Shake::new(h)).unwrap();
    for _ in 0..100 {
        let before = rattle.position();
        rattle.step().unwrap();
        shake.step().unwrap();
        assert!(
            distance(rattle.position(), shake.position()) <= 1e-15,
            "{:e}",
            distance(rattle.position(), shake.position())
        );
        let velocity = (shake.position() - before) / h;
        assert!(distance(shake.momentum(), velocity) <= 1e-13);
        assert_eq!(shake.momentum_time(), shake.time() - 0.5 * h);
    }
    assert_ne!(rattle.momentum(), shake.momentum());
}

/// A step is a function of the state alone: of nothing that was kept from the step before.
#[test]
fn a_saved_state_goes_on_bit_for_bit() {
    let surface = Scene::on(SURFACE).with(Uneven { g: 1.0 });
    let (linked, start) = uneven_pendulum();
    for Row { name, method, .. } in rows() {
        let method = method.with_step(0.01);
        goes_on(name, &surface, &surface.staggered(&billiard(0.7), &method).unwrap(), method);
        goes_on(name, &linked, &linked.staggered(&start, &method).unwrap(), method);
    }
}

fn goes_on<C: Hold<D>, E: Effects<D>, N: Count, const D: usize>(
    name: &str,
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
    method: OneOf,
) {
    let mut whole = scene.simulate(start.clone(), method).unwrap();
    whole.run(25).unwrap();
    let mut rest = scene.simulate(whole.state(), method).unwrap();
    assert_eq!(rest.multipliers(), whole.multipliers(), "{name}: multipliers are those of the state");
    whole.run(25).unwrap();
    rest.run(25).unwrap();
    assert_ne!(bits(&rest.state()), bits(start));
    assert_eq!(bits(&rest.state()), bits(&whole.state()), "{name}");
}

#[test]
fn no_step_allocates() {
    let surface = Scene::on(SURFACE).with(Uneven { g: 1.0 });
    let (linked, start) = uneven_pendulum();
    for Row { name, method, .. } in rows() {
        let method = method.with_step(0.01);
        let mut particle =
            surface.simulate(surface.staggered(&billiard(0.7), &method).unwrap(), method).unwrap();
        let mut rods = linked.simulate(linked.staggered(&start, &method).unwrap(), method).unwrap();
        let allocated = allocation_counter::measure(|| {
            particle.run(50).unwrap();
            rods.run(50).unwrap();
        });
        assert_eq!((particle.steps(), allocated.count_total), (50, 0), "{name}");
        assert_eq!(rods.steps(), 50, "{name}");
    }
}

/// Round the unit sphere at unit speed h·κ·|v| is h: at most 1 for each inner step.
#[test]
fn inner_steps_have_the_limit() {
    let takes = |method: OneOf| {
        let scene = Scene::on(Sphere { r: 1.0 });
        let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 1.0, 0.0]);
        scene.simulate(start, method).unwrap().run(100).is_ok()
    };
    type OfStep = fn(f64) -> OneOf;
    let limits: [(OfStep, f64); 5] = [
        (|h| OneOf::Rattle(Rattle::new(h)), 1.0),
        (|h| OneOf::Euler(SymplecticEuler::new(h)), 1.0),
        (|h| OneOf::PositionVerlet(PositionVerlet::new(h)), 2.0),
        (|h| OneOf::Geodesic(Geodesic::new(4, h)), 4.0),
        (|h| OneOf::Composed(Composition::new(SUZUKI_1990_ORDER_4, h)), 1.0 / 0.657_963_087_177_503),
    ];
    for (method, limit) in limits {
        assert!(takes(method(0.9 * limit)) && !takes(method(1.02 * limit)), "{:?}", method(limit));
    }
}
