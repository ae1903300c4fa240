//! Faults that people make in control volumes, planted on purpose: which law catches which.
//!
//! The fluxes of the conservative method are written out here once more, in plain steps, each of which can be made
//! wrong. Right, they are the library's; wrong, the laws named in the table must notice. Volume alone is not enough: it
//! is kept by upwinding the wrong way, and without a face. (Derivatives have a test of their own, `residual.rs`, which
//! sees each entry of the blocks with a number other than zero.)

#[allow(dead_code)]
mod exact;
mod random;

use exact::{UNIT, strip, wave};
use random::Random;
use rattle_flow::{Flow, Mesh};

#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    None,
    /// What flows has the depth it flows to …
    Downstream,
    /// … or the mean of both.
    Central,
    /// A face gives water that nobody gets …
    LostFace,
    /// … or is not there.
    MissingFace,
    /// All vertices have the same area …
    EqualMass,
    /// … or a triangle's first corner has half of its area.
    UnequalMass,
    /// The cotangent at an end of an edge, not opposite to it.
    WrongAngle,
    /// The slope of the ground is left out.
    NoGround,
    /// Opposite to an obtuse angle the depth upstream is carried, not the least of the triangle.
    Creeping,
    /// |q| goes with the slope, not with its root.
    NoRoot,
}

/// The areas of vertices.
fn masses(fault: Fault, mesh: &Mesh) -> Vec<f64> {
    let count = mesh.points().len();
    let mut masses = vec![0.0; count];
    for (triangle, vertices) in mesh.triangles().iter().enumerate() {
        let parts = if fault == Fault::UnequalMass { [0.5, 0.25, 0.25] } else { [1.0 / 3.0; 3] };
        let area = area(mesh.corners(triangle));
        (0..3).for_each(|i| masses[vertices[i] as usize] += parts[i] * area);
    }
    if fault == Fault::EqualMass { vec![mesh.area() / count as f64; count] } else { masses }
}

fn area([a, b, c]: [[f64; 2]; 3]) -> f64 {
    0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]))
}

/// What flows out of each vertex, volume per time, with c = 1 and α = 3/2.
fn out(fault: Fault, mesh: &Mesh, bed: &[f64], depth: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; depth.len()];
    for (triangle, vertices) in mesh.triangles().iter().enumerate() {
        let (at, twice) = (mesh.corners(triangle), 2.0 * area(mesh.corners(triangle)));
        let side = |i: usize, j: usize| [at[j % 3][0] - at[i % 3][0], at[j % 3][1] - at[i % 3][1]];
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let vertex = |i: usize| vertices[i % 3] as usize;
        let mut slope = [0.0; 2];
        let ground = |i: usize| if fault == Fault::NoGround { 0.0 } else { bed[vertex(i)] };
        for i in 0..3 {
            let ([x, y], height) = (side(i + 1, i + 2), ground(i) + depth[vertex(i)]);
            slope = [slope[0] - y / twice * height, slope[1] + x / twice * height];
        }
        let size = slope[0].hypot(slope[1]);
        let root = if fault == Fault::NoRoot || size == 0.0 { 1.0 } else { size.sqrt() };
        for i in 0..3 {
            let (j, k) = (i + 1, if fault == Fault::WrongAngle { i } else { i + 2 });
            let (others, along) = ([(k + 1) % 3, (k + 2) % 3], side(i, j));
            let cotangent = dot(side(k, others[0]), side(k, others[1])) / twice;
            let drive = -0.5 * cotangent * dot(slope, along) / root;
            let (giver, taker) = if drive < 0.0 { (j % 3, i) } else { (i, j % 3) };
            let (from, to) = (vertex(giver), vertex(taker));
            let depth = match fault {
                Fault::Downstream => depth[to],
                Fault::Central => 0.5 * (depth[from] + depth[to]),
                Fault::Creeping => depth[from],
                _ if cotangent < 0.0 => depth[from].min(depth[to]).min(depth[vertex(i + 2)]),
                _ => depth[from],
            };
            let flux = drive.abs() * depth.max(0.0).powf(1.5);
            let faulty = i == 2 && triangle % 7 == 3;
            if !(faulty && fault == Fault::MissingFace) {
                out[from] += flux;
                out[to] -= if faulty && fault == Fault::LostFace { 0.0 } else { flux };
            }
        }
    }
    out
}

/// Squares with moved corners, so that no triangle is like another and some are obtuse.
fn uneven() -> Mesh {
    let n = 8;
    let wave = |i: u32, j: u32, by: f64| 0.24 * (by * f64::from(7 * i + 13 * j)).sin();
    let inside = |i: u32| i > 0 && i < n;
    let points = (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j))).map(|(i, j)| {
        let x = f64::from(i) + if inside(i) { wave(i, j, 1.3) } else { 0.0 };
        let y = f64::from(j) + if inside(j) { wave(i, j, 2.1) } else { 0.0 };
        [x / f64::from(n), y / f64::from(n)]
    });
    let triangles = (0..n * n).flat_map(|square| {
        let [a, b] = [square % n + (n + 1) * (square / n), square % n + (n + 1) * (square / n) + 1];
        let [c, d] = [b + n + 1, a + n + 1];
        if square % 3 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
    });
    Mesh::new(points.collect(), triangles.collect()).unwrap()
}

/// Water with waves on it, and dry land.
fn sea(mesh: &Mesh) -> Vec<f64> {
    mesh.at_vertices(|[x, y]| (0.5 + 0.3 * (5.0 * x).sin() - 0.9 * y + 0.2 * (9.0 * x * y).cos()).max(0.0))
}

/// How far the volumes of linear functions are from exact.
fn volume_of_linear_depth(fault: Fault) -> f64 {
    let mesh = uneven();
    let masses = masses(fault, &mesh);
    let volume =
        |f: fn([f64; 2]) -> f64| mesh.points().iter().zip(&masses).map(|(p, mass)| f(*p) * mass).sum::<f64>();
    [volume(|_| 1.0) - 1.0, volume(|[x, _]| x) - 0.5, volume(|[_, y]| y) - 0.5]
        .into_iter()
        .fold(0.0, |a, b| b.abs().max(a))
}

/// What flows out of all vertices together, in parts of what flows.
fn balance(fault: Fault) -> f64 {
    let mesh = uneven();
    let out = out(fault, &mesh, &vec![0.0; mesh.points().len()], &sea(&mesh));
    out.iter().sum::<f64>().abs() / out.iter().map(|x| x.abs()).sum::<f64>()
}

/// The most that flows out of a vertex without water.
fn from_dry_land(fault: Fault) -> f64 {
    let mesh = uneven();
    let depth = sea(&mesh);
    let out = out(fault, &mesh, &mesh.at_vertices(|[x, y]| x - 2.0 * y), &depth);
    depth.iter().zip(out).filter(|(h, _)| **h == 0.0).map(|(_, out)| out).fold(0.0, f64::max)
}

/// The most that flows out of a vertex of a level lake with dry shores; the root of rounding.
fn unrest(fault: Fault) -> f64 {
    let mesh = uneven();
    let bed = mesh.at_vertices(|[x, y]| 0.4 * x + 0.5 * (7.0 * y).sin());
    let depth: Vec<f64> = bed.iter().map(|b| (0.3 - b).max(0.0)).collect();
    out(fault, &mesh, &bed, &depth).into_iter().fold(0.0, |most, x| x.abs().max(most))
}

/// The most energy that a triangle gives to the water, in parts of what it moves: of triangles with angles from 10° to
/// 170°, over ground of any slope, with dry corners and films.
fn given_energy(fault: Fault) -> f64 {
    let mut random = Random(4);
    let mut most = 0.0_f64;
    for _ in 0..2000 {
        let (angle, side) = ((10.0 + 160.0 * random.next()).to_radians(), 0.2 + 2.0 * random.next());
        let points = vec![[0.0, 0.0], [1.0, 0.0], [side * angle.cos(), side * angle.sin()]];
        let mesh = Mesh::new(points, vec![random.one_of(&[[0, 1, 2], [1, 2, 0], [2, 0, 1]])]).unwrap();
        let bed = [(); 3].map(|()| random.one_of(&[0.0, 1.0]) * random.next());
        let depth = [(); 3].map(|()| random.one_of(&[0.0, 1e-9, 0.1, 1.0]) * random.next());
        // As nothing is lost, levels may be counted from any of them; else they are rounded.
        let level = [0, 1, 2].map(|i| (bed[i] - bed[0]) + (depth[i] - depth[0]));
        let out = out(fault, &mesh, &bed, &depth);
        let power: Vec<f64> = level.iter().zip(out).map(|(level, out)| level * out).collect();
        let moved = power.iter().map(|x| x.abs()).sum::<f64>().max(f64::MIN_POSITIVE);
        most = most.max(-power.iter().sum::<f64>() / moved);
    }
    most
}

/// Of equal depth on a plane nothing gathers at vertices inside, whatever the direction.
fn uniform_flow(fault: Fault) -> f64 {
    let mesh = uneven();
    let inside = |[x, y]: [f64; 2]| x > 0.0 && x < 1.0 && y > 0.0 && y < 1.0;
    let most = |angle: f64| {
        let bed = mesh.at_vertices(|[x, y]| 0.3 * (x * angle.cos() + y * angle.sin()));
        let out = out(fault, &mesh, &bed, &vec![0.7; bed.len()]);
        mesh.points()
            .iter()
            .zip(out)
            .filter(|(p, _)| inside(**p))
            .map(|(_, out)| out.abs())
            .fold(0.0, f64::max)
    };
    (0..8).map(|i| most(0.8 * f64::from(i))).fold(0.0, f64::max)
}

/// The order of the error of the front that runs down a dry plane, by explicit steps, with the exact depth at its
/// beginning.
fn order_of_front(fault: Fault) -> f64 {
    let errors = [40, 80].map(|cells| {
        let mesh = strip(cells, 2.0);
        let (masses, bed) = (masses(fault, &mesh), mesh.at_vertices(|[x, _]| -x));
        let mut depth = mesh.at_vertices(|[x, _]| wave(x, 0.5));
        let steps = cells * cells / 2;
        for i in 1..=steps {
            let t = 0.5 + 0.5 * i as f64 / steps as f64;
            let out = out(fault, &mesh, &bed, &depth);
            let fixed = mesh.points().iter().map(|[x, _]| (*x == 0.0).then(|| wave(*x, t)));
            for ((h, fixed), (out, mass)) in depth.iter_mut().zip(fixed).zip(out.iter().zip(&masses)) {
                *h = fixed.unwrap_or((*h - 0.5 / steps as f64 * out / mass).clamp(-9.0, 9.0));
            }
        }
        let exact = mesh.at_vertices(|[x, _]| wave(x, 1.0));
        depth.iter().zip(exact).map(|(h, exact)| (h - exact).abs()).sum::<f64>() / depth.len() as f64
    });
    (errors[0] / errors[1]).log2()
}

/// Right, it is the library's: a short step changes depth as it says, of first order in the step.
#[test]
fn without_a_fault_it_is_the_method_of_the_library() {
    let mesh = uneven();
    let (bed, depth) = (mesh.at_vertices(|[x, y]| x - 2.0 * y), sea(&mesh));
    let out = out(Fault::None, &mesh, &bed, &depth);
    let apart = [1e-5, 1e-6].map(|step| {
        let flow = Flow::over(mesh.clone(), UNIT).terrain(|[x, y]| x - 2.0 * y);
        let mut simulation = flow.simulate(depth.clone(), step).unwrap();
        simulation.step().unwrap();
        let change = simulation
            .depth()
            .iter()
            .zip(&depth)
            .zip(mesh.shares())
            .map(|((new, old), m)| m * (new - old) / step);
        change.zip(&out).map(|(change, out)| (change + out).abs()).fold(0.0, f64::max)
    });
    let most = out.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    assert!(apart[0] < 3e-3 * most && apart[1] < 0.15 * apart[0], "{apart:?} of {most}");
    assert!(masses(Fault::None, &mesh).iter().zip(mesh.shares()).all(|(a, b)| (a - b).abs() < 1e-16));
}

#[test]
fn every_planted_fault_is_caught() {
    type Law = (&'static str, fn(Fault) -> f64, fn(f64) -> bool);
    let laws: [Law; 7] = [
        ("linear depth", volume_of_linear_depth, |off| off < 1e-13),
        ("balance", balance, |off| off < 1e-14),
        ("dry land", from_dry_land, |out| out == 0.0),
        ("rest", unrest, |out| out < 1e-8),
        ("energy", given_energy, |power| power < 1e-14),
        ("uniform flow", uniform_flow, |out| out < 1e-14),
        ("front", order_of_front, |order| order > 0.8 && order < 1.3),
    ];
    let expected: [(Fault, &[&str]); 11] = [
        (Fault::None, &[]),
        (Fault::Downstream, &["dry land", "rest", "front"]),
        (Fault::Central, &["dry land", "rest"]),
        (Fault::LostFace, &["balance", "uniform flow"]),
        (Fault::MissingFace, &["uniform flow"]),
        (Fault::EqualMass, &["linear depth"]),
        (Fault::UnequalMass, &["linear depth"]),
        (Fault::WrongAngle, &["uniform flow"]),
        (Fault::NoGround, &["rest", "uniform flow", "front"]),
        (Fault::Creeping, &["rest", "energy"]),
        (Fault::NoRoot, &["front"]),
    ];
    let mut wrong = Vec::new();
    for (fault, caught_by) in expected {
        let mut caught = Vec::new();
        print!("{:12}", format!("{fault:?}"));
        for (name, measure, holds) in laws {
            let found = measure(fault);
            print!(" {name} {found:9.2e}");
            if !holds(found) {
                caught.push(name);
            }
        }
        println!("  caught by {caught:?}");
        // Right is right by every law; a fault may be caught by more than it must.
        let missed = caught_by.iter().any(|name| !caught.contains(name));
        if missed || (fault == Fault::None && !caught.is_empty()) {
            wrong.push((fault, caught));
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}
