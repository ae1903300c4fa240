//! Motion against solutions known to 30 digits: the error falls like the order says, and is as small as it says.

use crate::common::*;
use rattle::prelude::*;

/// The final position for each number of steps.
fn positions_at<C, E, S, const D: usize>(
    scene: &rattle::Scene<C, E, rattle::bodies::One, D>,
    start: &State<D>,
    t: f64,
    steps: &[u32],
    method: impl Fn(f64) -> S,
) -> Vec<[f64; D]>
where
    C: Constraint<D, 1>,
    E: rattle::effect::Effects<D>,
    S: Method,
{
    let run = |&n: &u32| {
        let mut simulation = scene.simulate(start.clone(), method(t / f64::from(n))).unwrap();
        simulation.run(u64::from(n)).unwrap();
        assert_eq!(simulation.steps(), u64::from(n));
        simulation.position().into()
    };
    steps.iter().map(run).collect()
}

/// Checks the fitted order, and that the constant is not larger than measured in the reference study.
fn check_order<const D: usize>(
    what: &str,
    found: &[[f64; D]],
    exact: [f64; D],
    order_expected: f64,
    largest: f64,
) {
    let errors: Vec<f64> = found.iter().map(|q| distance(*q, exact)).collect();
    let slope = order(&errors);
    assert!((slope - order_expected).abs() < 0.1, "{what}: order {slope:.3}, errors {errors:?}");
    assert!(errors[0] <= largest, "{what}: {:e} at the longest step, allowed {largest:e}", errors[0]);
}

#[test]
fn billiard_converges_at_second_and_fourth_order() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let rows = table("lemniscate_gravity");
    let row = rows.iter().find(|row| row.text("ic") == "f64" && row.number("theta_deg") == 45.0).unwrap();
    assert_eq!(row.number("t"), 1.0);
    let exact = row.numbers(["x", "y", "z"]);
    let steps = [50, 100, 200, 400, 800];
    // The reference study measured 1.18e-3, 2.91e-4, 7.25e-5 at h = 0.02, 0.01, 0.005.
    check_order(
        "RATTLE",
        &positions_at(&scene, &billiard_45(), 1.0, &steps, Rattle::new),
        exact,
        2.0,
        1.19e-3,
    );
    let suzuki = |h| Composition::new(SUZUKI_1990_ORDER_4, h);
    let steps = [100, 200, 400, 800];
    check_order("Suzuki", &positions_at(&scene, &billiard_45(), 1.0, &steps, suzuki), exact, 4.0, 2e-6);
}

#[test]
fn billiard_reaches_twelve_digits_at_fourth_order() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let suzuki = |h| Composition::new(SUZUKI_1990_ORDER_4, h);
    for row in table("lemniscate_gravity") {
        let (t, theta) = (row.number("t"), row.number("theta_deg"));
        if row.text("ic") != "f64" || t != 1.0 || theta != 45.0 {
            continue;
        }
        let [q] = positions_at(&scene, &billiard_45(), t, &[20_000], suzuki)[..] else { unreachable!() };
        let error = distance(q, row.numbers(["x", "y", "z"]));
        assert!(error < 1e-12, "θ = {theta}, t = {t}: {error:e}");
        return;
    }
    panic!("no row compared");
}

#[test]
fn directions_of_the_notebook_at_t_1() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let mut worst = [0.0_f64; 2];
    for (theta, row) in directions().zip(table("lemniscate_t1_25_directions")) {
        let found = positions_at(&scene, &billiard(theta), 1.0, &[100, 200], Rattle::new);
        for (worst, q) in worst.iter_mut().zip(found) {
            *worst = worst.max(distance(q, row.numbers(["x", "y", "z"])));
        }
    }
    assert!(worst[0] <= 5.8e-4, "h = 0.01: {:e}", worst[0]);
    let ratio = worst[0] / worst[1];
    assert!((3.9..4.1).contains(&ratio), "{worst:?}, ratio {ratio}");
}

#[test]
fn sphere_geodesic() {
    let scene = Scene::on(Sphere { r: 2.0 });
    let start = State::at([2.0, 0.0, 0.0]).moving([0.0, 0.6, 0.8]);
    let row = &table("sphere_geodesic")[0];
    let found = positions_at(&scene, &start, row.number("t"), &[20, 40, 80, 160], Rattle::new);
    // The discrete angle per step is asin(h/2): at t = 1 the angle is late by h²/48, on a radius of 2.
    check_order("sphere", &found, row.numbers(["x", "y", "z"]), 2.0, 1.1 * 2.0 * 0.05 * 0.05 / 48.0);
}

#[test]
fn torus_geodesic_in_two_forms() {
    let angle = std::f64::consts::PI / 6.0;
    let start = State::at([1.3, 0.0, 0.0]).moving([0.0, angle.cos(), angle.sin()]);
    let (root, quartic) = (TorusByDistance { major: 1.0, minor: 0.3 }, Torus { major: 1.0, minor: 0.3 });
    let rows = table("torus_geodesic");
    let row = rows.iter().find(|row| row.number("t") == 5.0).unwrap();
    let exact = row.numbers(["x", "y", "z"]);
    let steps = [500, 1000, 2000];
    let found = positions_at(&Scene::on(root), &start, 5.0, &steps, Rattle::new);
    // The reference study measured 9.03e-5 at h = 0.01.
    check_order("torus", &found, exact, 2.0, 9.1e-5);
    let other = positions_at(&Scene::on(quartic), &start, 5.0, &steps, Rattle::new);
    for (a, b) in found.iter().zip(&other) {
        // The discrete motion depends on the surface, not on the function that vanishes there.
        assert!(distance(*a, *b) < 1e-13, "{:e}", distance(*a, *b));
    }
}

#[test]
fn pendulum_against_elliptic_functions() {
    let scene = Scene::on(Pendulum { length: 1.0 }).with(PlanarGravity { g: 1.0 });
    let rows = table("planar_pendulum");
    let row = rows.iter().find(|row| row.text("theta0") == "pi/2" && row.number("t") == 5.0).unwrap();
    let found = positions_at(&scene, &State::at([1.0, 0.0]), 5.0, &[250, 500, 1000, 2000], Rattle::new);
    check_order("pendulum", &found, row.numbers(["x", "y"]), 2.0, 1e-3);
}

/// Two interacting particles: also the sign of the pair force, which the notebook's code has reversed.
#[test]
fn two_ricker_particles() {
    let scene = Scene::on(SURFACE).bodies(2).with(Ricker { depth: 0.5, radius: SURFACE.r });
    let f = 0.1_f64.powi(4) - 0.1_f64.powi(2);
    let start = State::of([[0.0, 0.0, SURFACE.r], [0.1, 0.0, (1.0 / 36.0 - f * f).sqrt()]])
        .with_momenta([[0.3, 0.4, 0.0], [0.0; 3]]);
    let rows = table("ricker_two_particles");
    let row = rows.last().unwrap();
    let t = row.number("t");
    let exact = row.numbers(["x1", "y1", "z1", "x2", "y2", "z2"]);
    let mut errors = Vec::new();
    for n in [50_u32, 100, 200, 400] {
        let mut simulation = scene.simulate(start.clone(), Rattle::new(t / f64::from(n))).unwrap();
        simulation.run(u64::from(n)).unwrap();
        let found: Vec<f64> = simulation.positions().flat_map(<[f64; 3]>::from).collect();
        errors.push(distance::<6>(<[f64; 6]>::try_from(found).unwrap(), exact));
    }
    let slope = order(&errors);
    assert!((slope - 2.0).abs() < 0.1, "order {slope:.3}, errors {errors:?}");
}

/// Every high-order method at every reference up to t = 5, positions and momenta.
#[test]
fn high_order_methods_meet_every_reference() {
    let mut met = 0;
    let billiards = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    for row in table("lemniscate_gravity") {
        let theta = row.number("theta_deg");
        if row.text("ic") == "f64" && row.number("t") <= 5.0 {
            let start = if theta == 45.0 { billiard_45() } else { billiard(theta.to_radians()) };
            met += meets("lemniscate, gravity", &billiards, &start, 800, &row, ["x", "y", "z"]);
        }
    }
    let geodesics = Scene::on(SURFACE);
    for row in table("lemniscate_geodesic") {
        if row.text("ic") == "f64" && row.number("t") <= 5.0 {
            let theta = row.number("theta_deg");
            let start = if theta == 45.0 { billiard_45() } else { billiard(theta.to_radians()) };
            met += meets("lemniscate", &geodesics, &start, 400, &row, ["x", "y", "z"]);
        }
    }
    let angle = std::f64::consts::PI / 6.0;
    let along = State::at([1.3, 0.0, 0.0]).moving([0.0, angle.cos(), angle.sin()]);
    for row in table("torus_geodesic").iter().filter(|row| row.number("t") <= 5.0) {
        let quartic = Scene::on(Torus { major: 1.0, minor: 0.3 });
        met += meets("quartic torus", &quartic, &along, 60, row, ["x", "y", "z"]);
        let root = Scene::on(TorusByDistance { major: 1.0, minor: 0.3 });
        met += meets("torus", &root, &along, 60, row, ["x", "y", "z"]);
    }
    for row in table("sphere_geodesic").iter().filter(|row| row.number("t") <= 5.0) {
        let start = State::at([2.0, 0.0, 0.0]).moving([0.0, 0.6, 0.8]);
        met += meets("sphere", &Scene::on(Sphere { r: 2.0 }), &start, 20, row, ["x", "y", "z"]);
    }
    for row in table("spherical_pendulum").iter().filter(|row| row.number("t") <= 5.0) {
        let (sin, cos) = std::f64::consts::FRAC_PI_3.sin_cos();
        let start = State::at([sin, 0.0, -cos]).moving([0.0, 1.5, 0.0]);
        let scene = Scene::on(Sphere { r: 1.0 }).with(Gravity { g: 1.0 });
        met += meets("spherical pendulum", &scene, &start, 30, row, ["x", "y", "z"]);
    }
    let quarter = |row: &&Row| row.text("theta0") == "pi/2" && row.number("t") <= 5.0;
    for row in table("planar_pendulum").iter().filter(quarter) {
        let scene = Scene::on(Pendulum { length: 1.0 }).with(PlanarGravity { g: 1.0 });
        met += meets("pendulum", &scene, &State::at([1.0, 0.0]), 30, row, ["x", "y"]);
    }
    assert_eq!(met, 19);
}

/// Runs every method to a row's time, with so many steps per unit of time of the shortest kind, and compares.
fn meets<C, E, const D: usize>(
    what: &str,
    scene: &rattle::Scene<C, E, rattle::bodies::One, D>,
    start: &State<D>,
    steps: u32,
    row: &Row,
    columns: [&str; D],
) -> u32
where
    C: Constraint<D, 1>,
    E: rattle::effect::Effects<D>,
{
    let t = row.number("t");
    let (q, p) = (row.numbers(columns), columns.map(|column| row.number(&format!("v{column}"))));
    let check = |name: &str, (found_q, found_p): ([f64; D], [f64; D])| {
        let error = distance(found_q, q).max(distance(found_p, p));
        println!("{what:20} t = {t}: {name:24} {error:.1e}");
        assert!(error <= 1e-12, "{what}, t = {t}, {name}: {error:e}");
    };
    let kahan_li = |h| Composition::new(rattle::composition::KAHAN_LI_1997_ORDER_8, h);
    let sofroniou = |h| Composition::new(rattle::composition::SOFRONIOU_SPALETTA_2005_ORDER_10, h);
    check("Kahan–Li, order 8", end(scene, start, t, steps, kahan_li));
    check("Sofroniou–Spaletta", end(scene, start, t, steps, sofroniou));
    check("Lobatto, order 8", end(scene, start, t, steps, Lobatto::<5>::new));
    check("Lobatto, order 16", end(scene, start, t, steps / 4, Lobatto::<9>::new));
    check("DOP853", end(scene, start, t, steps, Dop853::new));
    check("DOP853, adaptive", end(scene, start, t, 1, |h| Dop853::adaptive(h, 1e-15)));
    check("Taylor, order 18", end(scene, start, t, steps / 2, |h| Taylor::new(18, h)));
    check("Taylor, adaptive", end(scene, start, t, 1, |h| Taylor::adaptive(18, h, 1e-16)));
    1
}

/// Position and momentum at `t`.
fn end<C, E, S: Method, const D: usize>(
    scene: &rattle::Scene<C, E, rattle::bodies::One, D>,
    start: &State<D>,
    t: f64,
    per_time: u32,
    method: impl Fn(f64) -> S,
) -> ([f64; D], [f64; D])
where
    C: Constraint<D, 1>,
    E: rattle::effect::Effects<D>,
{
    let steps = (t * f64::from(per_time)).round();
    let mut simulation = scene.simulate(start.clone(), method(t / steps)).unwrap();
    simulation.run(steps as u64).unwrap();
    (simulation.position().into(), simulation.momentum().into())
}
