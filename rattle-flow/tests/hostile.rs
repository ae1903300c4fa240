//! Flows that nobody should ask for: a step is right or is refused, depth is never negative, no water is lost, and
//! nothing panics.

mod random;

use random::Random;
use rattle_flow::{Conservative, Flow, Mesh, Resistance, Settings};

const DARCY: Resistance = Resistance::DarcyWeisbach { gravity: 9.81 };

/// A power of ten, to a power between these.
fn size_in(random: &mut Random, [from, to]: [f64; 2]) -> f64 {
    10.0_f64.powf(from + (to - from) * random.next())
}

/// A net of n by m squares of two triangles each, moved and stretched: angles down to `flat`.
fn net(random: &mut Random, size: f64, flat: f64) -> Mesh {
    loop {
        let (n, m) = (2 + (6.0 * random.next()) as u32, 2 + (6.0 * random.next()) as u32);
        let mut points = Vec::new();
        for (i, j) in (0..=m).flat_map(|j| (0..=n).map(move |i| (i, j))) {
            let [x, y] = [i, j].map(|x| f64::from(x) + 0.6 * (random.next() - 0.5));
            points.push([size * (x + y / 3.0), size * flat * y]);
        }
        let mut triangles = Vec::new();
        for (i, j) in (0..m).flat_map(|j| (0..n).map(move |i| (i, j))) {
            let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| j * (n + 1) + i);
            triangles.extend(if random.next() < 0.5 {
                [[a, b, c], [a, c, d]]
            } else {
                [[a, b, d], [b, c, d]]
            });
        }
        if let Ok(mesh) = Mesh::new(points, triangles) {
            return mesh;
        }
    }
}

/// What is drawn from.
struct Lists<'a> {
    size: [f64; 2],
    flat: &'a [f64],
    deep: &'a [f64],
    steep: &'a [f64],
    rough: [f64; 2],
    step: &'a [f64],
    rates: &'a [f64],
}

/// Draws a flow and makes five steps of it, by LU or by iteration. What must be so whatever is asked for: depth is
/// finite and not negative, and of all the water that there was and that came this part at most is not accounted for.
fn drawn(random: &mut Random, lists: &Lists, lost: f64) -> Result<(), String> {
    let (size, flat) = (size_in(random, lists.size), random.one_of(lists.flat));
    let mesh = net(random, size, flat);
    let (law, deep) = (random.one_of(&[DARCY, Resistance::Manning]), random.one_of(lists.deep));
    let (steep, rough) = (random.one_of(lists.steep), size_in(random, lists.rough));
    let (wet, step, open) =
        (random.next(), random.one_of(lists.step), random.one_of(&[-1.0, 0.0, 0.01, 100.0]));
    let [rain, drink, enters] = [(); 3].map(|()| random.one_of(lists.rates));
    let count = mesh.points().len();
    let mut depth = || if random.next() < wet { deep * random.next() } else { 0.0 };
    let depth: Vec<f64> = (0..count).map(|_| depth()).collect();
    let bed: Vec<f64> = (0..count).map(|_| size * steep * random.next()).collect();
    let direct = random.one_of(&[0, usize::MAX]);
    let name = format!(
        "{law:?}, {count} vertices, size {size:e}, flat {flat:e}, {deep:e} deep, steep {steep:e}, friction {rough:e}, \
         Δt {step:e}, rain {rain:e}, infiltration {drink:e}, inflow {enters:e}, outlet {open:e}, direct {direct}"
    );
    let places = mesh.points().to_vec();
    let mut flow = Flow::over(mesh, law)
        .terrain(|place| bed[places.iter().position(|own| *own == place).unwrap()])
        .friction(|_| rough)
        .rain(move |_, _| rain)
        .infiltration(|_| drink)
        .inflow(move |_, _| enters, |[x, _]| x < size);
    if open >= 0.0 {
        flow = flow.outlet(open, |[_, y]| y > size * flat);
    }
    let settings = Settings { direct, ..Settings::default() };
    let method = |flow: &Flow| Conservative::with(flow, settings);
    let mut simulation = flow.simulate_by(depth, step, method).map_err(|error| format!("{name}: {error}"))?;
    let mut outcome = Ok(());
    for _ in 0..5 {
        outcome = outcome.and(simulation.step().map(drop));
        let (budget, depth) = (simulation.budget(), simulation.depth());
        let came = budget.start + budget.rain + budget.inflow;
        assert!(depth.iter().all(|h| *h >= 0.0 && h.is_finite()), "{name}: {depth:?}");
        assert!(
            budget.remainder().abs() <= lost * came + 1e-300,
            "{name}: {:e}, {budget:?}",
            budget.remainder()
        );
        // As exact as depth is asked to be.
        let capacity = budget.unmet + budget.infiltration;
        let least = -1e-9 * (came + capacity) - 1e-300;
        assert!(budget.unmet >= least && budget.infiltration >= least, "{name}: {budget:?}");
    }
    outcome.map_err(|error| format!("{name}: {error}"))
}

/// Some centimetres to kilometres, up to 45° steep, with all the rain and thirst there can be: each step is made.
#[test]
fn what_might_be_asked_for_is_done() {
    let lists = Lists {
        size: [-1.0, 3.0],
        flat: &[1.0, 1.0, 0.3],
        deep: &[0.0, 1e-6, 1e-3, 1.0, 1.0],
        steep: &[0.0, 1e-6, 0.1, 1.0],
        rough: [-3.0, 1.0],
        step: &[1e-9, 1e-3, 1.0, 1.0, 10.0],
        rates: &[0.0, 0.0, 1e-9, 1e-5],
    };
    let mut random = Random(1);
    for round in 0..300 {
        if let Err(error) = drawn(&mut random, &lists, 1e-13) {
            panic!("round {round}: {error}");
        }
    }
}

/// Slivers of a ten-thousandth, 100 times as steep as long, a kilometre of rain in a second, steps of 30 years: it is
/// done or refused. Where water goes through a triangle 10¹² times in a step, so much of it is rounding.
#[test]
fn whatever_is_asked_for_no_water_is_lost() {
    let lists = Lists {
        size: [-3.0, 3.0],
        flat: &[1.0, 1.0, 0.3, 1e-2, 1e-4],
        deep: &[1e-300, 1e-20, 1e-6, 1.0, 1.0, 1e6],
        steep: &[0.0, 1e-6, 0.1, 1.0, 100.0],
        rough: [-6.0, 3.0],
        step: &[1e-9, 1e-3, 1.0, 1.0, 100.0, 1e9],
        rates: &[0.0, 0.0, 1e-9, 0.1, 1e3],
    };
    let (mut random, mut refused) = (Random(2), Vec::new());
    for round in 0..300 {
        if let Err(error) = drawn(&mut random, &lists, 1e-7) {
            refused.push(format!("round {round}: {error}"));
        }
    }
    println!("{}", refused.join("\n"));
    assert!(refused.len() < 150, "{} of 300", refused.len());
}

/// Numbers at the ends of their range: an error or a step, and no panic.
#[test]
fn numbers_at_the_ends_of_their_range_are_steps_or_errors() {
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let ends = [f64::MIN_POSITIVE * f64::EPSILON, f64::MIN_POSITIVE, 1e-160, 1.0, 1e160, f64::MAX];
    let mut steps = 0;
    for (name, which) in ["depth", "step", "terrain", "friction", "gravity", "rain", "infiltration", "outlet"]
        .into_iter()
        .zip(0..)
    {
        for (end, direct) in ends.into_iter().flat_map(|end| [(end, 0), (end, usize::MAX)]) {
            let of = move |own: usize| if own == which { end } else { 1.0 };
            let mesh = Mesh::polygon(&square, 0.3).unwrap();
            let depth = mesh.at_vertices(|[x, _]| if x < 0.5 { of(0) } else { 0.0 });
            let flow = Flow::over(mesh, Resistance::DarcyWeisbach { gravity: of(4) })
                .terrain(|[x, y]| of(2) * (x + y))
                .friction(|_| of(3))
                .rain(move |_, _| of(5))
                .infiltration(|[_, y]| of(6) * y)
                .outlet(of(7), |[x, _]| x < 1e-9);
            let method = |flow: &Flow| Conservative::with(flow, Settings { direct, ..Settings::default() });
            let Ok(mut simulation) = flow.simulate_by(depth, 0.01 * of(1), method) else { continue };
            steps += usize::from(simulation.step().is_ok());
            assert!(simulation.depth().iter().all(|h| *h >= 0.0 && h.is_finite()), "{name} {end:e} {direct}");
            let _ = (simulation.mean_flux(), simulation.flux(), simulation.run_until(1.0, 1e-3, 1.0));
        }
    }
    assert!(steps > 40, "{steps}");
}

/// Lakes behind dry walls, and meshes that do not touch: each keeps its own water.
#[test]
fn lakes_that_do_not_touch_keep_their_own() {
    let lake = |[x, _]: [f64; 2]| (x / 1.5).floor() as usize;
    for direct in [0, usize::MAX] {
        let mesh = Mesh::polygon(&[[0.0, 0.0], [6.0, 0.0], [6.0, 1.0], [0.0, 1.0]], 0.1).unwrap();
        let wall =
            |[x, _]: [f64; 2]| if (x / 1.5).fract().mul_add(1.5, -0.75).abs() > 0.5 { 3.0 } else { 0.0 };
        // As many different levels, sloshing.
        let depth = mesh
            .at_vertices(|p| if wall(p) > 0.0 { 0.0 } else { (0.3 + lake(p) as f64) * (0.5 + 0.5 * p[1]) });
        let volumes = |mesh: &Mesh, depth: &[f64]| {
            let own = |i: usize| {
                mesh.volume(
                    &mesh
                        .points()
                        .iter()
                        .zip(depth)
                        .map(|(&p, h)| if lake(p) == i { *h } else { 0.0 })
                        .collect::<Vec<_>>(),
                )
                .unwrap()
            };
            [0, 1, 2, 3].map(own)
        };
        let before = volumes(&mesh, &depth);
        let method = |flow: &Flow| Conservative::with(flow, Settings { direct, ..Settings::default() });
        let mut simulation =
            Flow::over(mesh.clone(), DARCY).terrain(wall).simulate_by(depth, 0.05, method).unwrap();
        simulation.run(100).unwrap();
        let after = volumes(&mesh, simulation.depth());
        // What is lacking in a solution by iteration is spread over all vertices; 100 steps with ten digits each.
        let most = if direct == 0 { 100.0 * 1e-10 * 2.0 } else { 1e-14 };
        for (i, (a, b)) in before.into_iter().zip(after).enumerate() {
            assert!((a - b).abs() <= most, "lake {i} with direct {direct}: {a} {b}, {:e}", a - b);
        }
        assert!(simulation.budget().remainder().abs() < 1e-13);
    }
}
