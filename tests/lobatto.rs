//! Lobatto IIIA–IIIB on surfaces: coefficients, the discrete map, orders, structure.

use crate::common::*;
use rattle::links::planar::Rod;
use rattle::prelude::*;
use rattle::table::{Table, Tabulated};

/// Calls a function for every number of stages.
macro_rules! for_all_stages {
    ($check:ident $(, $argument:expr)*) => {
        $check::<2>($($argument),*);
        $check::<3>($($argument),*);
        $check::<4>($($argument),*);
        $check::<5>($($argument),*);
        $check::<6>($($argument),*);
        $check::<7>($($argument),*);
        $check::<8>($($argument),*);
        $check::<9>($($argument),*);
    };
}

#[test]
fn coefficients_satisfy_their_conditions() {
    fn check<const S: usize>()
    where
        Table<S>: Tabulated,
    {
        let (s, Table { nodes, weights, positions, .. }) = (S, Table::<S>::TABLE);
        let exact = |power: i32| 1.0 / f64::from(power + 1);
        // Quadrature is exact for polynomials of degree 2s − 3.
        for power in 0..=2 * s as i32 - 3 {
            let sum: f64 = nodes.iter().zip(weights).map(|(c, b)| b * c.powi(power)).sum();
            assert!((sum - exact(power)).abs() < 4.0 * f64::EPSILON, "s = {s}, power {power}: {sum}");
        }
        // Σⱼ aᵢⱼ cⱼᵏ = cᵢᵏ⁺²/((k + 1)(k + 2)) for k ≤ s − 3: positions are exact for accelerations of that degree.
        assert_eq!(positions[0], [0.0; S]);
        for (i, row) in positions.iter().enumerate() {
            assert_eq!(row[s - 1], 0.0);
            for power in 0..=s as i32 - 3 {
                let sum: f64 = row.iter().zip(nodes).map(|(a, c)| a * c.powi(power)).sum();
                let expected = nodes[i].powi(power + 2) / f64::from((power + 1) * (power + 2));
                assert!((sum - expected).abs() < 4.0 * f64::EPSILON, "s = {s}, row {i}, power {power}");
            }
        }
        // The last row is bⱼ(1 − cⱼ), as symplecticity asks for: the quadrature of ∫ (1 − t) q̈ dt.
        for (j, a) in positions[s - 1].iter().enumerate() {
            assert!((a - weights[j] * (1.0 - nodes[j])).abs() < 2.0 * f64::EPSILON, "s = {s}, column {j}");
        }
        // Symmetry: read backwards in time, the method is the same.
        for j in 0..s {
            assert!((nodes[j] + nodes[s - 1 - j] - 1.0).abs() < 2.0 * f64::EPSILON);
            assert!((weights[j] - weights[s - 1 - j]).abs() < 2.0 * f64::EPSILON);
        }
    }
    for_all_stages!(check);
}

#[test]
fn the_discrete_maps_agree_with_40_digit_arithmetic() {
    fn check<const S: usize>(row: &Row)
    where
        Table<S>: Tabulated,
    {
        let (h, n) = (row.number("h"), row.text("n").parse().unwrap());
        let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
        let mut simulation = scene.simulate(billiard_45(), Lobatto::<S>::new(h)).unwrap();
        simulation.run(n).unwrap();
        let error = distance(simulation.position(), row.numbers(["x", "y", "z"]));
        assert!(error <= 1e-15, "s = {S}, n = {n}: position off by {error:e}");
        let error = distance(simulation.momentum(), row.numbers(["px", "py", "pz"]));
        assert!(error <= 4e-15, "s = {S}, n = {n}: momentum off by {error:e}");
    }
    let mut compared = 0;
    for row in table("golden_discrete_lemniscate") {
        match row.text("method") {
            "LobattoSPARK2" => check::<2>(&row),
            "LobattoSPARK3" => check::<3>(&row),
            "LobattoSPARK4" => check::<4>(&row),
            "LobattoSPARK5" => check::<5>(&row),
            _ => continue,
        }
        compared += 1;
    }
    assert_eq!(compared, 8);
}

/// The slope of the straight line through three points, by least squares.
fn slope(points: [(f64, f64); 3]) -> f64 {
    let mean = |f: fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / 3.0;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    (mean(|p| p.0 * p.1) - x * y) / (mean(|p| p.0 * p.0) - x * x)
}

#[test]
fn orders_2_to_16_on_the_spherical_pendulum() {
    fn check<const S: usize>(steps: [u64; 3])
    where
        Table<S>: Tabulated,
    {
        let rows = table("spherical_pendulum");
        let row = rows.iter().find(|row| row.text("case") == "a" && row.number("t") == 5.0).unwrap();
        let exact = row.numbers(["x", "y", "z"]);
        let alpha = std::f64::consts::FRAC_PI_3;
        let scene = Scene::on(Sphere { r: 1.0 }).with(Gravity { g: 1.0 });
        let start = State::at([alpha.sin(), 0.0, -alpha.cos()]).moving([0.0, 1.5, 0.0]);
        let start = scene.project(&start).unwrap();
        let points = steps.map(|n| {
            let mut simulation = scene.simulate(start.clone(), Lobatto::<S>::new(5.0 / n as f64)).unwrap();
            simulation.run(n).unwrap();
            let error = distance(simulation.position(), exact);
            assert!((1e-14..0.1).contains(&error), "s = {S}, {n} steps: {error:e}");
            ((1.0 / n as f64).ln(), error.ln())
        });
        let slope = slope(points);
        // Long steps are not yet in the limit: an eighth of the order.
        let order = f64::from(Lobatto::<S>::new(1.0).order());
        assert!((slope - order).abs() < order / 8.0, "s = {S}: slope {slope}, order {order}");
    }
    // Steps with errors between 1e-2 and 1e-13.
    check::<2>([40, 60, 80]);
    check::<3>([16, 24, 32]);
    check::<4>([12, 18, 24]);
    check::<5>([9, 13, 18]);
    check::<6>([8, 12, 16]);
    check::<7>([6, 8, 10]);
    check::<8>([5, 6, 7]);
    check::<9>([4, 5, 6]);
}

#[test]
fn forth_and_back_and_on_the_surface() {
    fn check<const S: usize>(h: f64)
    where
        Table<S>: Tabulated,
    {
        let h = if S == 2 { 0.5 * h } else { h }; // two stages are RATTLE, with its limit
        let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
        let start = billiard_45();
        let mut forth = scene.simulate(start.clone(), Lobatto::<S>::new(h)).unwrap();
        forth.run(20).unwrap();
        assert!(forth.constraint_residual() < 1e-15 && forth.cotangent_residual() < 1e-15);
        let mut back = scene.simulate(forth.state(), Lobatto::<S>::new(-h)).unwrap();
        back.run(20).unwrap();
        let error = distance(back.position(), start.positions().next().unwrap());
        assert!(error < 2e-14, "s = {S}, h = {h}: {error:e}"); // measured up to 5e-15
    }
    for_all_stages!(check, 0.02);
    for_all_stages!(check, 0.05);
}

#[test]
fn steps_three_times_as_long_as_those_of_rattle() {
    // RATTLE ends at h = 0.031 on this motion (h·κ·|v| = 1). It is chaotic: how near a path comes to where the surface
    // bends most, and so its worst energy, is chance; in the middle of 200 starts 1e-13 apart it is 0.08 (of 0.83)
    // until t = 200.
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    for extrapolated in [false, true] {
        let mut errors: Vec<f64> = (0..9)
            .map(|k| {
                let start = billiard(std::f64::consts::FRAC_PI_4 + 1e-13 * f64::from(k));
                let mut worst = 0.0_f64;
                let method = Lobatto::<5>::new(0.1);
                let residual = if extrapolated {
                    let mut simulation = scene.simulate(start, method.guess(Extrapolated)).unwrap();
                    simulation.run_with(500, |now| worst = worst.max(now.energy_error().abs())).unwrap();
                    simulation.constraint_residual()
                } else {
                    let mut simulation = scene.simulate(start, method).unwrap();
                    simulation.run_with(500, |now| worst = worst.max(now.energy_error().abs())).unwrap();
                    simulation.constraint_residual()
                };
                assert!(residual < 1e-15);
                worst
            })
            .collect();
        errors.sort_by(f64::total_cmp);
        assert!(errors[4] < 0.15 && errors[8] < 0.5, "{extrapolated}: {errors:?}");
    }
}

#[test]
fn orders_2_to_16_of_linked_bodies() {
    fn check<const S: usize>(steps: [u64; 3])
    where
        Table<S>: Tabulated,
    {
        let rows = table("double_pendulum");
        let row = rows.iter().find(|row| row.text("case") == "equal" && row.number("t") == 1.0).unwrap();
        let exact = row.numbers(["x1", "y1", "x2", "y2"]);
        let scene = Scene::points(3)
            .link(Rod { length: 1.0 }, [[0, 1], [1, 2]])
            .pin(0, [0.0, 0.0])
            .with(PlanarGravity { g: 1.0 });
        let start = State::of([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
        let points = steps.map(|n| {
            let mut simulation = scene.simulate(start.clone(), Lobatto::<S>::new(1.0 / n as f64)).unwrap();
            simulation.run(n).unwrap();
            let q: Vec<_> = simulation.positions().collect();
            let error = distance([q[1].x, q[1].y, q[2].x, q[2].y], exact);
            assert!(simulation.constraint_residual() < 1e-15 && error < 0.1);
            ((1.0 / n as f64).ln(), error.ln())
        });
        let slope = slope(points);
        let order = f64::from(Lobatto::<S>::new(1.0).order());
        assert!((slope - order).abs() < order / 8.0, "s = {S}: slope {slope}, order {order}");
    }
    check::<2>([40, 60, 80]);
    check::<3>([4, 6, 8]);
    check::<4>([3, 4, 5]);
    check::<5>([2, 3, 4]);
    check::<6>([2, 3, 4]);
    check::<7>([2, 3, 4]);
    // Beyond, a single step of length 1 leaves 2e-10 and 4e-12.
    single::<8>(1e-9);
    single::<9>(1e-11);
}

fn single<const S: usize>(bound: f64)
where
    Table<S>: Tabulated,
{
    let rows = table("double_pendulum");
    let row = rows.iter().find(|row| row.text("case") == "equal" && row.number("t") == 1.0).unwrap();
    let scene = Scene::points(3)
        .link(Rod { length: 1.0 }, [[0, 1], [1, 2]])
        .pin(0, [0.0, 0.0])
        .with(PlanarGravity { g: 1.0 });
    let start = State::of([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
    let mut simulation = scene.simulate(start, Lobatto::<S>::new(1.0)).unwrap();
    simulation.step().unwrap();
    let q: Vec<_> = simulation.positions().collect();
    let error = distance([q[1].x, q[1].y, q[2].x, q[2].y], row.numbers(["x1", "y1", "x2", "y2"]));
    assert!(error < bound, "s = {S}: {error:e}");
}

constraint! {
    /// A sphere whose radius swings with time.
    struct Breathing { amplitude }
    |x, y, z, t| x^2 + y^2 + z^2 - (1 + amplitude * sin(t))^2
}

#[test]
fn the_work_of_a_moving_constraint_is_known_to_the_method_s_order() {
    let scene = Scene::point().link_moving(Breathing { amplitude: 0.3 }, [[0]]).with(Gravity { g: 1.0 });
    let start = scene.project(&State::at([0.8, 0.0, 0.6]).moving([0.0, 1.0, 0.0])).unwrap();
    let missing = [8_u64, 16].map(|n| {
        let mut simulation = scene.simulate(start.clone(), Lobatto::<3>::new(2.0 / n as f64)).unwrap();
        simulation.run(n).unwrap();
        assert!(simulation.work().abs() > 0.1);
        simulation.energy_error().abs()
    });
    let ratio = missing[0] / missing[1];
    assert!((13.0..20.0).contains(&ratio), "order 4 has 16: {ratio}, {missing:?}");
}

constraint! {
    /// A saddle through the origin.
    struct Saddle {}
    |x, y, z| z - x^2 + y^2
}

#[test]
fn a_start_at_the_origin() {
    let scene = Scene::on(Saddle {}).with(Gravity { g: 1.0 });
    for momentum in [[1.0, 0.0, 0.0], [0.0; 3]] {
        let start = State::at([0.0; 3]).moving(momentum);
        let mut simulation = scene.simulate(start.clone(), Lobatto::<5>::new(0.01)).unwrap();
        let mut fine = scene.simulate(start, Composition::new(SUZUKI_1990_ORDER_4, 0.001)).unwrap();
        simulation.run(100).unwrap();
        fine.run(1000).unwrap();
        assert!(distance(simulation.position(), fine.position()) < 1e-11);
        assert!(simulation.constraint_residual() < 1e-15);
    }
}

constraint! {
    /// A place on a line that moves.
    struct Drive { speed }
    |x, _y, t| x - speed * t
}

constraint! {
    /// The same at first, later faster.
    struct Faster { speed, more }
    |x, _y, t| x - speed * t - more * t^3
}

constraint! {
    /// The unit circle.
    struct Circle {}
    |x, y| x^2 + y^2 - 1
}

constraint! {
    /// An ellipse that touches it.
    struct Ellipse {}
    |x, y| x^2 + 4 * y^2 - 1
}

#[test]
fn dependent_equations_that_part_are_refused() {
    use rattle::error::{LinkedFailure, StepFailure};
    for more in [1.0, 1e-3] {
        let scene = Scene::point()
            .link_moving(Drive { speed: 0.1 }, [[0]])
            .link_moving(Faster { speed: 0.1, more }, [[0]])
            .with(PlanarGravity { g: 1.0 });
        let start = State::at([0.0, 0.0]).moving([0.1, 0.0]);
        let error = scene.simulate(start, Lobatto::<5>::new(0.01)).unwrap().step().unwrap_err();
        assert!(
            matches!(
                &error,
                rattle::Error::Step { cause: StepFailure::Linked(LinkedFailure::Contradictory { .. }), .. }
            ),
            "{error}"
        );
    }
    let scene = Scene::point().link(Circle {}, [[0]]).link(Ellipse {}, [[0]]);
    let start = State::at([1.0, 0.0]).moving([0.0, 1.0]);
    assert!(scene.simulate(start, Lobatto::<4>::new(0.01)).unwrap().step().is_err());
}

#[test]
fn a_chain_keeps_its_links_and_does_not_hear_of_bodies_far_away() {
    for (n, h) in [(3_u32, 0.1), (10, 0.02), (40, 0.005)] {
        let length = 1.0 / f64::from(n);
        let chain = |more: usize| {
            Scene::points(n as usize + 1 + more)
                .link(Rod { length }, (0..n as usize).map(|i| [i, i + 1]))
                .pin(0, [0.0, 0.0])
                .with(PlanarGravity { g: 1.0 })
        };
        let straight =
            |far: Option<[f64; 2]>| State::of((0..=n).map(|i| [f64::from(i) * length, 0.0]).chain(far));
        let start = chain(0).project(&straight(None)).unwrap();
        let mut alone = chain(0).simulate(start, Lobatto::<5>::new(h)).unwrap();
        let start = chain(1).project(&straight(Some([1e6, 0.0]))).unwrap();
        let mut with_another = chain(1).simulate(start, Lobatto::<5>::new(h)).unwrap();
        let mut worst = 0.0_f64;
        for _ in 0..40 {
            alone.step().unwrap();
            with_another.step().unwrap();
            worst = worst.max(alone.constraint_residual() / (2.0 * length * length));
        }
        // A rounding of the coordinates is ε/ℓ of a link; measured 2e-15 … 2e-14.
        assert!(worst < 4.0 * f64::EPSILON * f64::from(n).max(4.0), "{n} links: {worst:e}");
        let apart =
            alone.positions().zip(with_another.positions()).map(|(a, b)| distance(a, b)).fold(0.0, f64::max);
        assert!(apart < 1e-14, "{n} links: {apart:e}");
    }
}

#[test]
fn what_has_no_collocation_is_refused_at_once() {
    let body = Rigid::new([1.0; 3]);
    let start = Rigid::start(&rattle::nalgebra::Matrix3::identity(), &rattle::nalgebra::Vector3::x());
    let error = Scene::rigid(body).simulate(start, Lobatto::<3>::new(0.1)).unwrap_err();
    assert!(matches!(error, rattle::Error::CannotMove { .. }), "{error}");
}

potential! {
    /// Not a number beyond x = 0.95.
    struct Edge {}
    |x, _y, _z| sqrt(0.95 - x)
}

#[test]
fn errors_name_the_body() {
    let scene = Scene::on(Sphere { r: 1.0 }).bodies(3);
    let still = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
    let fast = State::of(still).with_momenta([[0.0; 3], [0.0; 3], [1000.0, 0.0, 0.0]]);
    let error = scene.simulate(fast, Lobatto::<5>::new(0.1)).unwrap().step().unwrap_err();
    assert!(matches!(error, rattle::Error::Step { body: 2, .. }), "{error}");
    let scene = scene.with(Edge {});
    let over = State::of(still).with_momenta([[0.0; 3], [0.0; 3], [3.0, 0.0, 0.0]]);
    let error = scene.simulate(over, Lobatto::<5>::new(0.1)).unwrap().run(100).unwrap_err();
    assert!(error.to_string().contains("body 2") && error.to_string().contains("Edge"), "{error}");
}

/// Stages on both sides of an edge that is round, but not to them, know nothing of the force there: the energy grew
/// five-thousandfold in a step.
#[test]
fn over_a_rounded_edge_no_energy_comes_from_nowhere() {
    let mut refused = 0;
    for (i, s) in (0..40).flat_map(|i| [1e-2, 1e-3, 1e-4, 1e-7].map(|s| (i, s))) {
        let (x, v) = (0.001 + 0.0025 * f64::from(i), std::f64::consts::FRAC_1_SQRT_2);
        let scene = Scene::on(Ridge { s });
        let start = scene.project(&State::at([x, 0.0, -x]).moving([-v, 0.0, v])).unwrap();
        let mut simulation = scene.simulate(start.clone(), Lobatto::<3>::new(0.03)).unwrap();
        let mut ensemble = scene.ensemble([start], Lobatto::<3>::new(0.03)).unwrap();
        ensemble.run(4);
        let alone = simulation.run(4).map(|()| simulation.momentum().norm_squared());
        let state = ensemble.state(0);
        let in_lanes = state.momenta().next().unwrap().norm_squared();
        refused += u32::from(alone.is_err());
        assert_eq!(alone.is_err(), ensemble.failure(0).is_some(), "{i}, {s}");
        for square in alone.ok().into_iter().chain([in_lanes]) {
            assert!(square < 2.0, "{i}, {s}: {square}");
        }
    }
    assert!(refused > 80, "{refused}");
}

/// What leads beyond the numbers is said so, and not measured in NaN roundings.
#[test]
fn stages_beyond_the_numbers_are_called_so() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    for h in [1e3, 1e100, 1e200] {
        let mut simulation = scene.simulate(billiard_45(), Lobatto::<3>::new(h)).unwrap();
        let text = simulation.run(1).unwrap_err().to_string();
        assert!(!text.contains("NaN") && !text.contains("inf "), "h = {h:e}: {text}");
    }
}
