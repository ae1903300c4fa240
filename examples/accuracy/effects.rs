//! What effects cost: a step of RATTLE on the surface of genus two with more and more of them.

use crate::clock;
use rattle::bodies::Count;
use rattle::effect::{Effects, Langevin, LinearDrag, MagneticField};
use rattle::potentials::{Gravity, Ricker};
use rattle::prelude::*;
use rattle::scene::Hold;
use rattle::surfaces::Lemniscate;

const H: f64 = 0.01;
const STEPS: u64 = 20_000;
/// Repeats of which the median counts.
const REPEATS: usize = 5;

potential! {
    /// A lamp that swings.
    struct Swinging { strength }
    |x, y, z, t| strength * x * sin(t)
}

/// Names, and nanoseconds of a step of one body.
pub(crate) fn costs() -> Result<Vec<(&'static str, f64)>, rattle::Error> {
    let on = || Scene::on(Lemniscate { a: 1.0, r: 1.0 / 6.0 });
    let gravity = Gravity { g: 1.0 };
    let start = State::at([0.0, 0.0, 1.0 / 6.0]).moving([0.6, 0.8, 0.0]);
    let bath = Langevin { friction: 1.0, temperature: 0.5, seed: 1 };
    let many = on().bodies(21).with(Ricker { depth: 0.5, radius: 1.0 / 6.0 });
    let crowd = many.project(&crate::crowd(&many)?.moving([0.3, 0.2, 0.1]))?;
    Ok(vec![
        ("no effect", cost(&on(), &start)?),
        ("gravity", cost(&on().with(gravity), &start)?),
        (
            "gravity, a potential of position and time",
            cost(&on().with(gravity).with(Swinging { strength: 0.1 }), &start)?,
        ),
        ("gravity, linear drag", cost(&on().with(gravity).with(LinearDrag::new(0.1)), &start)?),
        (
            "gravity, a magnetic field",
            cost(&on().with(gravity).with(MagneticField::new([0.0, 0.0, 1.0])), &start)?,
        ),
        ("gravity, a heat bath (Langevin)", cost(&on().with(gravity).with(bath), &start)?),
        ("21 bodies, no effect", cost(&on().bodies(21), &crowd)?),
        ("21 bodies, a potential between all pairs", cost(&many, &crowd)?),
    ])
}

fn cost<C: Hold<3>, E: Effects<3>, N: Count>(
    scene: &Scene<C, E, N, 3>,
    start: &State<3>,
) -> Result<f64, rattle::Error> {
    let mut simulation = scene.simulate(start.clone(), Rattle::new(H))?;
    let steps = STEPS / start.positions().count() as u64;
    let mut times = Vec::new();
    for _ in 0..REPEATS {
        let begun = clock::cpu_seconds();
        simulation.run(steps)?;
        times.push(1e9 * (clock::cpu_seconds() - begun) / (steps * start.positions().count() as u64) as f64);
    }
    times.sort_by(f64::total_cmp);
    Ok(times[REPEATS / 2])
}
