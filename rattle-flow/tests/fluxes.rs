//! The flux that is shown is the one that moves the water: exact in uniform flow, none at rest, and, as
//! meshes get fine, as fast as the first moment of the water changes.

#[allow(dead_code)]
mod exact;

use exact::{UNIT, barenblatt, strip};
use rattle_flow::{Conservative, Flow, FlowError, Mesh, Resistance, Settings, dam_break};

fn largest(flux: &[[f64; 2]]) -> f64 {
    flux.iter().map(|q| q[0].hypot(q[1])).fold(0.0, f64::max)
}

fn area([a, b, c]: [[f64; 2]; 3]) -> f64 {
    0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]))
}

/// ∫ h x of vertices' areas, and Σ |T| q.
fn moment(mesh: &Mesh, depth: &[f64]) -> [f64; 2] {
    let water = || mesh.points().iter().zip(depth).zip(mesh.shares());
    [0, 1].map(|x| water().map(|((place, h), share)| share * h * place[x]).sum())
}

fn whole(mesh: &Mesh, flux: &[[f64; 2]]) -> [f64; 2] {
    [0, 1].map(|x| flux.iter().enumerate().map(|(t, q)| area(mesh.corners(t)) * q[x]).sum())
}

/// Also before the first step.
#[test]
fn the_flux_of_uniform_flow_is_exact() {
    for (resistance, power, c) in
        [(UNIT, 1.5, 1.0 / 0.03_f64.sqrt()), (Resistance::Manning, 5.0 / 3.0, 1.0 / 0.03)]
    {
        let turned =
            |t: f64| Mesh::polygon(&[[0.0, 0.0], [2.0, t], [2.0 - t, 1.0 + t], [-t, 1.0]], 0.2).unwrap();
        for mesh in [strip(10, 1.0), turned(0.0), turned(0.3)] {
            for down in [[1.0, 0.0], [0.6, 0.8]] {
                let depth = vec![0.1; mesh.points().len()];
                let flow = Flow::over(mesh.clone(), resistance).friction(|_| 0.03);
                let flow = flow.terrain(|[x, y]| -0.01 * (down[0] * x + down[1] * y));
                let simulation = flow.simulate(depth, 1e-3).unwrap();
                let exact = c * 0.1_f64.powf(power) * 0.1;
                assert!((simulation.mean_flux() - exact).abs() < 1e-13, "{} {exact}", simulation.mean_flux());
                for q in simulation.flux() {
                    assert!((q[0] - exact * down[0]).hypot(q[1] - exact * down[1]) < 1e-13, "{q:?} {exact}");
                }
            }
        }
    }
}

/// At the shores of an island and of obtuse triangles too. Slopes are rounded to 1e-14, of which q has the root.
#[test]
fn water_at_rest_has_no_flux() {
    let square = Mesh::polygon(&[[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [0.0, 2.0]], 0.1).unwrap();
    for sheared in [0.0, 0.5, 2.0] {
        let oblique = square.points().iter().map(|[x, y]| [x + sheared * y, *y]).collect();
        let mesh = Mesh::new(oblique, square.triangles().to_vec()).unwrap();
        let ground = |[x, y]: [f64; 2]| {
            let x = x - sheared * y;
            1.2 * (1.0 - 2.0 * (x - 1.3).hypot(y - 0.9)).max(0.0) + 0.1 * (3.0 * x).sin()
        };
        let depth = mesh.at_vertices(|place| (0.6 - ground(place)).max(0.0));
        let dry = depth.iter().filter(|&&h| h == 0.0).count();
        assert!(dry > 5 && dry < depth.len() / 2, "{dry}");
        let mut simulation = Flow::over(mesh, UNIT).terrain(ground).simulate(depth, 0.1).unwrap();
        for _ in 0..10 {
            let most = largest(&simulation.flux());
            assert!(most < 5e-7 && simulation.mean_flux() < 1e-7, "{most:e} {:e}", simulation.mean_flux());
            simulation.step().unwrap();
        }
    }
}

/// A film above a lake carries as little as it is thick, though the lake beside it is deep and the way steep.
#[test]
fn a_film_carries_little() {
    let mesh = Mesh::polygon(&[[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [0.0, 2.0]], 0.1).unwrap();
    let ground = |[x, y]: [f64; 2]| 0.5 * x + 0.1 * y;
    for film in [1e-4, 1e-6, 1e-8, 1e-300] {
        let depth = mesh.at_vertices(|place| (0.6 - ground(place)).max(film));
        let flow = Flow::over(mesh.clone(), UNIT).terrain(ground);
        let flux = flow.simulate(depth.clone(), 0.1).unwrap().flux();
        for (q, corners) in flux.iter().zip(mesh.triangles()) {
            if corners.iter().any(|&vertex| depth[vertex as usize] <= film) {
                // √slope is 0.7; of three edges each has ½ cot at most 1.
                assert!(q[0].hypot(q[1]) < 20.0 * film.powf(1.5) + 1e-7, "{q:?} of {film:e}");
            }
        }
    }
}

/// In a closed basin the water's first moment changes by Δt Σ |T| q in a step, with fronts, shores and all: as mesh and
/// step get fine, with the first order of both.
#[test]
fn the_flux_moves_the_first_moment_of_the_water() {
    let off = |spacing: f64| {
        let mesh = dam_break::mesh(spacing).unwrap();
        let depth = dam_break::depth(&mesh);
        let step = spacing / 8.0;
        let mut simulation = dam_break::flow(mesh.clone()).simulate(depth, step).unwrap();
        let start = moment(&mesh, simulation.depth());
        let mut moved = [0.0; 2];
        for _ in 0..(3.0 / step) as usize {
            simulation.step().unwrap();
            let flux = whole(&mesh, &simulation.flux());
            moved = [0, 1].map(|x| moved[x] + step * flux[x]);
        }
        let end = moment(&mesh, simulation.depth());
        let changed = end[1] - start[1];
        assert!(changed < -2.5, "the water goes down: {changed}");
        (moved[1] - changed).abs() / changed.abs()
    };
    let off = [0.4, 0.2, 0.1].map(off);
    assert!(off[0] < 0.1 && off[1] < 0.7 * off[0] && off[2] < 0.7 * off[1], "{off:?}");
}

/// The exact flux of the drop at its start, q = β x h / t: of first order in the mesh.
#[test]
fn the_flux_of_the_drop_is_near_the_exact_one() {
    let errors = [50, 100, 200].map(|cells| {
        let mesh = strip(cells, 1.2);
        let depth = mesh.at_vertices(|[x, _]| barenblatt(1.0, 1.5, x, 1.0));
        let simulation = Flow::over(mesh.clone(), UNIT).simulate(depth, 0.1).unwrap();
        let beta = 1.0 / (1.0 + 1.5);
        let exact = |t: usize| {
            let x = mesh.corners(t).iter().map(|corner| corner[0]).sum::<f64>() / 3.0;
            beta * x * barenblatt(1.0, 1.5, x, 1.0)
        };
        let flux = simulation.flux();
        let sizes = (0..flux.len()).map(|t| area(mesh.corners(t)));
        let off: f64 =
            sizes.clone().zip(&flux).enumerate().map(|(t, (area, q))| area * (q[0] - exact(t)).abs()).sum();
        let all: f64 = sizes.enumerate().map(|(t, area)| area * exact(t)).sum();
        off / all
    });
    assert!(errors[0] / errors[1] > 1.7 && errors[1] / errors[2] > 1.7 && errors[2] < 0.05, "{errors:?}");
}

/// Settings with which no iteration ends are told as that, before a step.
#[test]
fn settings_that_cannot_serve_are_named() {
    let default = Settings::default();
    let mesh = dam_break::mesh(0.5).unwrap();
    let depth = dam_break::depth(&mesh);
    let start = |settings| {
        let method = |flow: &Flow| Conservative::with(flow, settings);
        dam_break::flow(mesh.clone()).simulate_by(depth.clone(), 0.1, method)
    };
    let named = |settings, name: &str| match start(settings).map(drop) {
        Err(FlowError::Number { what, .. }) => assert_eq!(what, name),
        other => panic!("{name}: {other:?}"),
    };
    for epsilon in [0.0, -1e-6, f64::NAN, f64::INFINITY, 1e-200, 1e200] {
        named(Settings { epsilon, ..default }, "the setting epsilon");
    }
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        named(Settings { tolerance, ..default }, "the setting tolerance");
    }
    named(Settings { most: 0, ..default }, "the setting most");
    for epsilon in [1e-150, 1e-6] {
        start(Settings { epsilon, ..default }).unwrap();
    }
}
