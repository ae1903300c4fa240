//! The conservative method held to what is known exactly: volume, sign, rest, and solutions in closed form.
//!
//! Orders are those of a method that is of first order where the solution is smooth. At a front h ~ √distance, which no
//! method of low order resolves better than its mesh. Orders measured are
//! 0.92 and 0.8 for the drop on a line and in the plane, 0.92 for the front (`--example flow_accuracy`), and bounds are
//! below.

mod exact;

use exact::{UNIT, barenblatt, error, strip, wave};
use rattle_flow::{Flow, FlowError, Mesh, Page, Resistance};

fn order(errors: &[f64]) -> f64 {
    let last = errors.len() - 1;
    (errors[last - 1] / errors[last]).log2()
}

/// A third of each triangle belongs to each of its vertices: then, and only then, depth that is linear has its volume.
#[test]
fn linear_depth_has_its_volume() {
    // An L of three unit squares: area 3, with the centroid (5/6, 5/6).
    let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    let mesh = Mesh::polygon(&corners, 0.17).unwrap();
    for (constant, x, y) in [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (2.0, 0.3, -0.7)] {
        let volume = mesh.volume(&mesh.at_vertices(|place| constant + x * place[0] + y * place[1])).unwrap();
        let exact = 3.0 * constant + 2.5 * (x + y);
        assert!((volume - exact).abs() < 1e-13, "{volume} {exact}"); // sums over some 150 vertices
    }
}

/// Functions that are linear in each triangle come back from a projection, and others keep their integral.
#[test]
fn a_projection_is_exact_where_it_can_be() {
    for spacing in [0.3, 0.07] {
        let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let mesh = Mesh::polygon(&corners, spacing).unwrap();
        for (constant, x, y) in [(3.0, 0.0, 0.0), (0.5, 1.0, -2.0), (1e3, -2.0, 7.0)] {
            let f = |place: [f64; 2]| constant + x * place[0] + y * place[1];
            let exact = mesh.at_vertices(f);
            let off = mesh.projected(f).iter().zip(&exact).map(|(h, f)| (h - f).abs()).fold(0.0, f64::max);
            assert!(off < 1e-13 * (constant + 10.0), "{spacing} {constant}: {off:e}");
        }
        let square = mesh.volume(&mesh.projected(|[x, y]| x * x + y)).unwrap(); // 3 + 5/2 over the L
        assert!((square - 5.5).abs() < 1e-3, "{square}");
    }
}

#[test]
fn the_drop_spreads_in_one_dimension_at_first_order() {
    let (coarse, fine) = (&[100, 200][..], &[100, 200, 400][..]);
    for (resistance, power, meshes, most) in
        [(UNIT, 1.5, fine, 7e-3), (Resistance::Manning, 5.0 / 3.0, coarse, 14e-3)]
    {
        let mut errors = Vec::new();
        for &cells in meshes {
            let mesh = strip(cells, 1.2);
            let depth = mesh.at_vertices(|[x, _]| barenblatt(1.0, power, x, 1.0));
            let steps = 4 * cells;
            let mut simulation = Flow::over(mesh, resistance).simulate(depth, 7.0 / steps as f64).unwrap();
            let start = simulation.volume();
            simulation.run(steps).unwrap();
            assert!(simulation.depth().iter().all(|&h| h >= 0.0));
            // Rounding: some ten sums of a volume per step, of random sign.
            assert!(
                simulation.budget().remainder().abs() <= 1e-14 * start,
                "{:e}",
                simulation.budget().remainder()
            );
            errors.push(error(&simulation, |[x, _]| barenblatt(1.0, power, x, 8.0)));
        }
        let last = *errors.last().unwrap();
        assert!(order(&errors) > 0.85 && last < most, "{resistance:?}: {errors:?}");
    }
}

#[test]
fn the_drop_spreads_in_two_dimensions_alike_in_all_directions() {
    let mut errors = Vec::new();
    for spacing in [1.0 / 16.0, 1.0 / 32.0] {
        let corner = 1.0;
        let mesh =
            Mesh::polygon(&[[0.0, 0.0], [corner, 0.0], [corner, corner], [0.0, corner]], spacing).unwrap();
        let depth = mesh.at_vertices(|[x, y]| barenblatt(2.0, 1.5, x.hypot(y), 1.0));
        let steps = (7.0 / spacing) as usize;
        let mut simulation = Flow::over(mesh, UNIT).simulate(depth, 7.0 / steps as f64).unwrap();
        simulation.run(steps).unwrap();
        assert!(simulation.depth().iter().all(|&h| h >= 0.0));
        errors.push(error(&simulation, |[x, y]| barenblatt(2.0, 1.5, x.hypot(y), 8.0)));
        // The radius of the front along the axes and the diagonal, as the farthest vertex in a sector with water.
        let front = |from: f64, to: f64| {
            let points = simulation.flow().mesh().points().iter().zip(simulation.depth());
            let wet = points.filter(|&(&[x, y], &h)| h > 1e-3 && (from..=to).contains(&y.atan2(x)));
            wet.map(|([x, y], _)| x.hypot(*y)).fold(0.0, f64::max)
        };
        let fronts = [front(0.0, 0.3), front(0.6, 0.97), front(1.27, 1.58)];
        let spread = fronts.iter().fold(0.0, |spread: f64, r| spread.max((r - fronts[0]).abs()));
        assert!(fronts[0] > 0.7 && spread < spacing, "{fronts:?}");
    }
    assert!(order(&errors) > 0.7 && errors[1] < 0.08, "{errors:?}");
}

#[test]
fn a_front_runs_down_a_dry_plane_at_first_order() {
    let mut errors = Vec::new();
    for cells in [40, 80, 160] {
        let mesh = strip(cells, 4.0);
        let width = 4.0 / cells as f64;
        let depth = mesh.at_vertices(|[x, _]| wave(x, 1.0));
        let steps = 2 * cells;
        let step = 2.0 / steps as f64;
        // What enters at x = 0 is the exact flux there, c h.
        let flow =
            Flow::over(mesh, UNIT).terrain(|[x, _]| -x).inflow(|_, t| wave(0.0, 1.0 + t), |[x, _]| x < 1e-9);
        let mut simulation = flow.simulate(depth, step).unwrap();
        simulation.run(steps).unwrap();
        let budget = simulation.budget();
        // −u − ln(1 − u) = t has dt = u/(1 − u) du, so ∫ u dt = t − u²/2.
        let entered = |t: f64| width * (t - 0.5 * wave(0.0, t).powi(2));
        let expected = entered(3.0) - entered(1.0);
        assert!((budget.inflow - expected).abs() < 1e-13, "{} {expected}", budget.inflow);
        assert!(budget.remainder().abs() < 1e-14, "{:e}", budget.remainder());
        errors.push(error(&simulation, |[x, _]| wave(x, 3.0)));
    }
    assert!(order(&errors) > 0.85 && errors[2] < 2e-2, "{errors:?}");
}

#[test]
fn uniform_flow_is_exact() {
    let (slope, h) = (0.04_f64, 0.3_f64);
    for (resistance, power) in [(UNIT, 1.5), (Resistance::Manning, 5.0 / 3.0)] {
        let mesh = strip(20, 2.0);
        let depth = vec![h; mesh.points().len()];
        let discharge = h.powf(power) * slope.sqrt();
        let flow = Flow::over(mesh, resistance)
            .terrain(move |[x, _]| -slope * x)
            .inflow(move |_, _| discharge, |[x, _]| x < 1e-9)
            .outlet(slope, |[x, _]| x > 2.0 - 1e-9);
        let mut simulation = flow.simulate(depth, 0.5).unwrap();
        simulation.run(20).unwrap();
        assert!(simulation.depth().iter().all(|d| (d - h).abs() < 1e-13));
        assert!((simulation.mean_flux() - discharge).abs() < 1e-13);
        assert!((simulation.budget().outflow - 10.0 * 0.1 * discharge).abs() < 1e-14);
    }
}

/// The later slope is that of the edge, and the sum of inflows enters.
#[test]
fn an_edge_that_is_chosen_twice_is_open_once() {
    let (slope, h) = (0.04_f64, 0.3_f64);
    let mesh = strip(20, 2.0);
    let depth = vec![h; mesh.points().len()];
    let discharge = h.powf(1.5) * slope.sqrt();
    let flow = Flow::over(mesh, UNIT)
        .terrain(move |[x, _]| -slope * x)
        .inflow(move |_, _| 0.25 * discharge, |[x, _]| x < 1e-9)
        .inflow(move |_, _| 0.75 * discharge, |[x, _]| x < 1e-9)
        .outlet(3.0, |[x, _]| x > 2.0 - 1e-9)
        .outlet(slope, |[x, _]| x > 2.0 - 1e-9);
    let mut simulation = flow.simulate(depth, 0.5).unwrap();
    simulation.run(20).unwrap();
    assert!(simulation.depth().iter().all(|d| (d - h).abs() < 1e-13), "{:?}", simulation.depth());
}

/// Friction is that at the outlet, whenever it is given: the lower half has four times as much, and is as much steeper.
#[test]
fn water_leaves_by_the_friction_at_the_outlet() {
    let (slope, h) = (0.04_f64, 0.3_f64);
    let mesh = strip(20, 2.0);
    let depth = vec![h; mesh.points().len()];
    let discharge = h.powf(1.5) * slope.sqrt();
    let flow = Flow::over(mesh, UNIT)
        .terrain(move |[x, _]| -slope * (x + 3.0 * (x - 1.0).max(0.0)))
        .inflow(move |_, _| discharge, |[x, _]| x < 1e-9)
        .outlet(4.0 * slope, |[x, _]| x > 2.0 - 1e-9)
        .friction(|[x, _]| if x < 1.0 { 1.0 } else { 4.0 });
    let mut simulation = flow.simulate(depth, 0.5).unwrap();
    simulation.run(20).unwrap();
    assert!(simulation.depth().iter().all(|d| (d - h).abs() < 1e-13), "{:?}", simulation.depth());
    assert!((simulation.budget().outflow - 10.0 * 0.1 * discharge).abs() < 1e-14);
}

/// Steady flow with h = 0.5 + 0.1 sin x over the ground that it needs, b′ = −h′ − q²/h³, in the manner of MacDonald.
#[test]
fn steady_flow_over_uneven_ground_is_of_first_order() {
    let (q, h) = (0.2, |x: f64| 0.5 + 0.1 * x.sin());
    let length = 6.0;
    let ground = move |x: f64| {
        let parts = 400;
        let dx = x / f64::from(parts);
        let slope = |x: f64| q * q / h(x).powi(3);
        // Simpson's rule: 1e-10 of the ground's height here.
        let drop: f64 = (0..parts)
            .map(|i| {
                let a = f64::from(i) * dx;
                dx / 6.0 * (slope(a) + 4.0 * slope(a + 0.5 * dx) + slope(a + dx))
            })
            .sum();
        -h(x) - drop
    };
    let mut errors = Vec::new();
    for cells in [30, 60, 120] {
        let mesh = strip(cells, length);
        let depth = mesh.at_vertices(|[x, _]| h(x));
        let leaving = (q / h(length).powf(1.5)).powi(2);
        let flow = Flow::over(mesh, UNIT)
            .terrain(|[x, _]| ground(x))
            .inflow(move |_, _| q, |[x, _]| x < 1e-9)
            .outlet(leaving, move |[x, _]| x > length - 1e-9);
        let mut simulation = flow.simulate(depth, 2.0).unwrap();
        simulation.run(60).unwrap();
        errors.push(error(&simulation, |[x, _]| h(x)));
    }
    assert!(order(&errors) > 0.85 && errors[2] < 0.01, "{errors:?}");
}

#[test]
fn a_lake_with_a_dry_island_rests() {
    let mesh = Mesh::polygon(&[[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [0.0, 2.0]], 0.1).unwrap();
    let ground =
        |[x, y]: [f64; 2]| 1.2 * (1.0 - 2.0 * (x - 1.3).hypot(y - 0.9)).max(0.0) + 0.1 * (3.0 * x).sin();
    let depth = mesh.at_vertices(|place| (0.6 - ground(place)).max(0.0));
    let dry = depth.iter().filter(|&&h| h == 0.0).count();
    assert!(dry > 5 && dry < depth.len() / 2, "an island of {dry} vertices");
    let mut simulation = Flow::over(mesh, UNIT).terrain(ground).simulate(depth.clone(), 0.1).unwrap();
    for _ in 0..50 {
        simulation.step().unwrap();
        let most =
            simulation.depth().iter().zip(&depth).map(|(h, start)| (h - start).abs()).fold(0.0, f64::max);
        assert!(most <= 1e-14, "depth has changed by {most:e}");
    }
}

/// Also where triangles at the shore are obtuse, up to 130°, and where it meets the edge of the mesh.
#[test]
fn a_lake_rests_on_obtuse_triangles() {
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    for (spacing, sheared) in [(0.13, 0.0), (0.07, 0.0), (0.13, 0.5), (0.07, -0.5)] {
        let plain = Mesh::polygon(&square, spacing).unwrap();
        let points = plain.points().iter().map(|[x, y]| [x + sheared * y, *y]).collect();
        let mesh = Mesh::new(points, plain.triangles().to_vec()).unwrap();
        let ground = move |[x, y]: [f64; 2]| 0.4 * (x - sheared * y) + 0.5 * (7.0 * y).sin();
        let depth = mesh.at_vertices(|place| (0.3 - ground(place)).max(0.0));
        let dry = depth.iter().filter(|&&h| h == 0.0).count();
        assert!(dry > 10 && dry < depth.len() - 10, "{dry}");
        let mut simulation = Flow::over(mesh, UNIT).terrain(ground).simulate(depth.clone(), 0.1).unwrap();
        simulation.run(50).unwrap();
        let moved =
            simulation.depth().iter().zip(&depth).map(|(h, start)| (h - start).abs()).fold(0.0, f64::max);
        assert!(moved <= 1e-14, "depth has changed by {moved:e} with {sheared}");
    }
}

/// Rain on dry ground that drinks: what there is not cannot seep away, and the books say so.
#[test]
fn rain_and_infiltration_are_booked_to_rounding() {
    let mesh = Mesh::polygon(&[[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [0.0, 2.0]], 0.2).unwrap();
    let dry = vec![0.0; mesh.points().len()];
    let area = mesh.area();
    let flow = Flow::over(mesh, Resistance::Manning)
        .terrain(|[x, y]| 0.1 * x + 0.05 * (4.0 * y).sin())
        .friction(|[x, _]| 0.05 + 0.02 * x)
        .rain(|[x, _], t| if t < 3.0 { 0.02 * (1.0 + 0.5 * x) } else { 0.0 })
        .infiltration(|[_, y]| if y < 1.0 { 0.01 } else { 0.0 })
        .outlet(0.1, |[x, _]| x < 1e-9);
    let mut simulation = flow.simulate(dry, 0.1).unwrap();
    for i in 1..=100 {
        simulation.step().unwrap();
        let budget = simulation.budget();
        // Σ over some 250 vertices and 100 steps of volumes of 0.5 altogether.
        assert!(budget.remainder().abs() < 1e-14, "{budget:?}");
        assert!(simulation.depth().iter().all(|&h| h >= 0.0), "step {i}");
        assert!(budget.unmet >= 0.0 && budget.infiltration >= 0.0);
    }
    let budget = simulation.budget();
    // Over x from 0 to 4 the mean of 1 + x/2 is 2.
    assert!((budget.rain - 3.0 * 0.02 * area * 2.0).abs() < 1e-13, "{budget:?}");
    assert!((budget.infiltration + budget.unmet - 10.0 * 0.01 * area / 2.0).abs() < 0.06, "{budget:?}");
    assert!(budget.unmet > 0.05 && budget.outflow > 0.1 * budget.rain, "{budget:?}");
}

#[test]
fn what_is_wrong_is_named() {
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mesh = Mesh::polygon(&square, 0.25).unwrap();
    let depth = vec![1.0; mesh.points().len()];
    let start = |flow: Flow, depth: &[f64], step| flow.simulate(depth.to_vec(), step).map(drop).unwrap_err();
    let flow = || Flow::over(mesh.clone(), UNIT);
    let hole = start(flow().terrain(|[x, y]| if x + y > 1.9 { f64::NAN } else { 0.0 }), &depth, 0.1);
    assert!(matches!(hole, FlowError::Given { what: "the terrain at vertex", .. }), "{hole}");
    assert_eq!(format!("{hole:?}"), hole.to_string()); // a program that ends with it prints that
    assert!(matches!(start(flow(), &depth[1..], 0.1), FlowError::Count { .. }));
    assert!(matches!(start(flow(), &depth, f64::NAN), FlowError::Number { what: "the time step", .. }));
    assert!(matches!(
        start(flow().friction(|_| 0.0), &depth, 0.1),
        FlowError::Given { what: "friction of triangle", .. }
    ));
    for slope in [-1.0, f64::NAN, f64::INFINITY] {
        let error = start(flow().outlet(slope, |_| true), &depth, 0.1);
        assert!(matches!(error, FlowError::Number { what: "the slope of an outlet", .. }), "{error}");
    }
    let nowhere = start(flow().outlet(0.1, |[x, _]| x > 3.0), &depth, 0.1);
    assert!(matches!(nowhere, FlowError::NoEdge { what: "an outlet", edges: 16 }), "{nowhere}");
    let nowhere = start(flow().inflow(|_, _| 1.0, |_| false), &depth, 0.1);
    assert!(nowhere.to_string().starts_with("an inflow chooses none of the 16 edges"), "{nowhere}");
    assert!(matches!(mesh.volume(&depth[1..]), Err(FlowError::Count { what: "depth", .. })));
    let mut page = Page::new("Nothing", &flow());
    assert!(matches!(page.add(0.0, &depth[1..]), Err(FlowError::Count { .. })));
    let mut hole = depth.clone();
    hole[3] = f64::NAN;
    let error = page.add(2.0, &hole).unwrap_err().to_string();
    assert!(error.starts_with("depth at vertex 3 is NaN at time 2"), "{error}");
    assert!(matches!(page.add(f64::NAN, &depth), Err(FlowError::Number { .. })));
    assert!(page.add(0.0, &depth).is_ok());
    for gravity in [0.0, -9.81, f64::NAN, f64::INFINITY] {
        let error = start(Flow::over(mesh.clone(), Resistance::DarcyWeisbach { gravity }), &depth, 0.1);
        assert!(matches!(error, FlowError::Number { what: "gravity", .. }), "{error}");
    }
    let error = start(flow().infiltration(|_| -2.0), &depth, 0.1);
    assert!(error.to_string().starts_with("infiltration at vertex 0 is -2 "), "{error}");
    for rate in [-2.0, f64::NAN, f64::INFINITY] {
        let mut simulation =
            flow().rain(|_, _| 3.0).rain(move |_, _| rate).simulate(depth.clone(), 0.1).unwrap();
        let error = simulation.step().unwrap_err();
        assert!(error.to_string().starts_with(&format!("rain at vertex 0 is {rate} at time 0.0")), "{error}");
        let mut simulation = flow().inflow(move |_, _| rate, |_| true).simulate(depth.clone(), 0.1).unwrap();
        let error = simulation.step().unwrap_err();
        assert!(matches!(error, FlowError::Given { what: "inflow at vertex", .. }), "{error}");
    }
    let mut simulation = flow().simulate(depth.clone(), 0.1).unwrap();
    for (end, tolerance, longest) in
        [(f64::NAN, 1e-3, 1.0), (f64::INFINITY, 1e-3, 1.0), (1.0, 0.0, 1.0), (1.0, 1e-3, f64::NAN)]
    {
        let error = simulation.run_until(end, tolerance, longest).unwrap_err();
        assert!(matches!(error, FlowError::Number { .. }), "{error}");
    }
    assert!(matches!(
        start(flow(), &vec![-1.0; depth.len()], 0.1),
        FlowError::Given { what: "depth at vertex", .. }
    ));

    // Rain that breaks off in numbers: the time is named, the last good state stays.
    let flow = flow().rain(|_, t| if t > 0.25 { f64::INFINITY } else { 0.1 });
    let mut simulation = flow.simulate(depth, 0.1).unwrap();
    let error = simulation.run(10).unwrap_err();
    assert!(matches!(error, FlowError::Given { what: "rain at vertex", time, .. } if time > 0.25), "{error}");
    assert!((simulation.time() - 0.2).abs() < 1e-12 && simulation.budget().remainder().abs() < 1e-14);
}
