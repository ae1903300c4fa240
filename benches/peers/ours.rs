//! One motion of a hard case by RATTLE of this library, for `hard_cases.py`, which asks and judges.
//!
//! ```text
//! ours MODEL PARAMETERS … -- GRAVITY STEP STEPS -- POSITIONS … -- VELOCITIES …
//! ```
//!
//! It prints a line `q … v …` for the start and for each step, and `error: …` where the motion ends early. The
//! constraints are written as in `cases.py`. Without arguments, as cargo runs benchmarks, it says how it is meant.

use rattle::links::planar::Rod;
use rattle::potentials::{Gravity, planar};
use rattle::prelude::*;
use std::io::{BufWriter, Write};

constraint! {
    struct Shells { k }
    |x, y, z| sin(k * (sqrt(x^2 + y^2 + z^2) - 1))
}
constraint! {
    struct ThreeShells { gap }
    |x, y, z| {
        let off = sqrt(x^2 + y^2 + z^2) - 1;
        off * (off - gap) * (off + gap)
    }
}
constraint! {
    struct Tube { minor }
    |x, y, z| (sqrt(x^2 + y^2) - 1)^2 + z^2 - minor^2
}
constraint! {
    struct Pinched {}
    |x, y, z| {
        let f = (x^2 + y^2)^2 - (x^2 - y^2);
        f^2 + z^2 - 1/16
    }
}
constraint! {
    struct Cone {}
    |x, y, z| z^2 - x^2 - y^2
}
constraint! {
    struct Octahedron {}
    |x, y, z| abs(x) + abs(y) + abs(z) - 1
}
constraint! {
    struct Roof {}
    |x, _y, z| z + abs(x) / 2
}
constraint! {
    struct Ball { scale, centre }
    |x, y, z| scale * ((x - centre)^2 + y^2 + z^2 - 1)
}
constraint! {
    struct Reach {}
    |x, y| x^2 + y^2 - 1
}
constraint! {
    struct Guide {}
    |_x, y| y
}

/// What is asked for.
struct Request {
    model: String,
    parameters: Vec<f64>,
    gravity: f64,
    h: f64,
    steps: u64,
    q: Vec<f64>,
    v: Vec<f64>,
}

fn read() -> Option<Request> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut parts = arguments.split(|a| a == "--");
    let numbers = |part: &[String]| part.iter().map(|a| a.parse().ok()).collect::<Option<Vec<f64>>>();
    let (model, parameters) = parts.next()?.split_first()?;
    let parameters = numbers(parameters)?;
    let run = numbers(parts.next()?)?;
    let (q, v) = (numbers(parts.next()?)?, numbers(parts.next()?)?);
    let [gravity, h, steps] = run[..] else { return None };
    Some(Request { model: model.clone(), parameters, gravity, h, steps: steps as u64, q, v })
}

/// The run of any scene: its type is known to the macro alone.
macro_rules! run {
    ($scene:expr, $start:expr, $request:expr) => {{
        let scene = $scene;
        let mut out = BufWriter::new(std::io::stdout().lock());
        let mut simulation = match scene.simulate($start, Rattle::new($request.h)) {
            Ok(simulation) => simulation,
            Err(error) => return writeln!(out, "error: {error}"),
        };
        let mut show = |q: Vec<f64>, v: Vec<f64>| {
            let line: Vec<String> = q.iter().chain(&v).map(|x| format!("{x:e}")).collect();
            writeln!(out, "{}", line.join(" "))
        };
        for step in 0..=$request.steps {
            if step > 0
                && let Err(error) = simulation.step()
            {
                return writeln!(out, "error: {error}");
            }
            show(
                simulation.positions().flat_map(|q| q.as_slice().to_vec()).collect(),
                simulation.velocities().flat_map(|v| v.as_slice().to_vec()).collect(),
            )?;
        }
        out.flush()
    }};
}

/// Points in a plane, from all their coordinates; masses tell momenta.
fn planar_start(request: &Request, masses: &[f64]) -> State<2> {
    let pairs = |x: &[f64]| x.chunks(2).map(|c| [c[0], c[1]]).collect::<Vec<_>>();
    let momenta = pairs(&request.v).into_iter().zip(masses).map(|(v, m)| v.map(|x| m * x));
    State::of(pairs(&request.q)).with_momenta(momenta)
}

fn on<C: Constraint<3, 1>>(surface: C, request: &Request) -> std::io::Result<()> {
    let [x, y, z, u, v, w] = [0, 1, 2, 3, 4, 5].map(|i| if i < 3 { request.q[i] } else { request.v[i - 3] });
    let start = State::at([x, y, z]).moving([u, v, w]);
    run!(Scene::on(surface).with(Gravity { g: request.gravity }), start, request)
}

fn main() -> std::io::Result<()> {
    let Some(request) = read() else {
        println!("benches/peers: see its README, and hard_cases.py, which asks");
        return Ok(());
    };
    let p = &request.parameters;
    let g = request.gravity;
    let rod = Rod { length: 1.0 };
    match request.model.as_str() {
        "shells" => on(Shells { k: p[0] }, &request),
        "three shells" => on(ThreeShells { gap: p[0] }, &request),
        "torus" => on(Tube { minor: p[0] }, &request),
        "pinch" => on(Pinched {}, &request),
        "cone" => on(Cone {}, &request),
        "octahedron" => on(Octahedron {}, &request),
        "roof" => on(Roof {}, &request),
        "sphere" => on(Ball { scale: p[0], centre: p[1] }, &request),
        "double pendulum" => run!(
            Scene::points(2)
                .link(Reach {}, [[0]])
                .link(rod, [[0, 1]])
                .masses([p[0], p[1]])
                .with(planar::weights(g, [p[0], p[1]])),
            planar_start(&request, p),
            request
        ),
        "rod twice" => run!(
            Scene::points(1).link(Reach {}, [[0], [0]]).with(planar::Gravity { g }),
            planar_start(&request, &[1.0]),
            request
        ),
        "crank" => run!(
            Scene::points(2).link(Reach {}, [[0]]).link(rod, [[0, 1]]).link(Guide {}, [[1]]),
            planar_start(&request, &[1.0, 1.0]),
            request
        ),
        other => {
            println!("error: no model “{other}”");
            Ok(())
        }
    }
}
