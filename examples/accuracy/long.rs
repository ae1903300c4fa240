//! Long runs: what rounding does to the energy, and what numbers cost.
//!
//! ```text
//! √⟨ΔE²⟩ ~ √n   where roundings are independent;   ~ n   where they are biased
//! ```

use crate::clock;
use rattle::composition::KAHAN_LI_1997_ORDER_8;
use rattle::plot::Chart;
use rattle::potentials::Gravity;
use rattle::prelude::*;
use rattle::surfaces::Sphere;

/// Trajectories, each a spherical pendulum.
const PENDULUMS: u32 = 16;
/// Steps of RATTLE in a step of the composition, whose own error is below rounding.
const SUBSTEPS: u64 = 17;
/// Energies are asked for after so many steps of it, a thousand of RATTLE, then after √10 times as many, …
const FIRST: f64 = 60.0;
/// Energies of rounding alone are of this size, for each root of a step.
const LAW: f64 = 1e-17;

/// The errors of the energy with one kind of numbers.
pub(crate) struct Run {
    pub(crate) numbers: &'static str,
    /// Steps, and the root of the mean square of the error.
    pub(crate) errors: Vec<(f64, f64)>,
    /// Nanoseconds of a step of one trajectory, on one core.
    pub(crate) ns: f64,
}

/// The runs with every kind of numbers, of so many steps of RATTLE.
pub(crate) fn runs(steps: f64) -> Result<Vec<Run>, rattle::Error> {
    let scene = Scene::on(Sphere { r: 1.0 }).with(Gravity { g: 1.0 });
    let (sin, cos) = std::f64::consts::FRAC_PI_3.sin_cos();
    let starts: Vec<_> = (0..PENDULUMS)
        .map(|i| {
            let start = State::at([sin, 0.0, -cos]).moving([0.0, 1.1 + 0.03 * f64::from(i), 0.01]);
            scene.project(&start)
        })
        .collect::<Result<_, _>>()?;
    let method = || Composition::of(KAHAN_LI_1997_ORDER_8, Rattle::new(0.025));
    let alone = {
        let few = &starts[..4];
        let mut all: Vec<_> =
            few.iter().map(|start| scene.simulate(start.clone(), method())).collect::<Result<_, _>>()?;
        run("compensated, alone", few.len(), steps, |steps| {
            all.iter_mut().try_for_each(|simulation| simulation.run(steps))?;
            Ok(all.iter().map(|simulation| simulation.energy_error()).collect())
        })?
    };
    let compensated = scene.ensemble_in(Compensated, starts.clone(), method())?;
    let double = scene.ensemble_in(Double, starts.clone(), method())?;
    let single = scene.ensemble_in(Single, starts.clone(), method())?;
    Ok(vec![
        alone,
        in_lanes("compensated, in lanes", &starts, steps, compensated)?,
        in_lanes("double, in lanes", &starts, steps, double)?,
        in_lanes("single, in lanes", &starts, steps, single)?,
    ])
}

fn in_lanes(
    numbers: &'static str,
    starts: &[State<3>],
    steps: f64,
    mut ensemble: rattle::Ensemble<3>,
) -> Result<Run, rattle::Error> {
    let energy = |state: &State<3>| {
        let (q, p) = (state.positions().next().expect("a body"), state.momenta().next().expect("a body"));
        0.5 * p.norm_squared() + q.z
    };
    // In single precision the start itself is rounded.
    ensemble.run(1);
    let first: Vec<f64> = ensemble.states().map(|state| energy(&state)).collect();
    run(numbers, starts.len(), steps, |steps| {
        ensemble.run(steps);
        Ok(ensemble.states().zip(&first).map(|(state, first)| energy(&state) - first).collect())
    })
}

fn run(
    numbers: &'static str,
    trajectories: usize,
    steps: f64,
    mut go: impl FnMut(u64) -> Result<Vec<f64>, rattle::Error>,
) -> Result<Run, rattle::Error> {
    let (mut done, mut errors) = (0, Vec::new());
    let begun = clock::cpu_seconds();
    let all = (steps / SUBSTEPS as f64).max(FIRST);
    let counts =
        (0..).map(|i| FIRST * 10_f64.powf(0.5 * f64::from(i))).take_while(|&count| count < 0.9 * all);
    for next in counts.chain([all]).map(|count| count as u64) {
        let found = go(next - done)?;
        let square = found.iter().map(|error| error * error).sum::<f64>() / found.len() as f64;
        errors.push(((SUBSTEPS * next) as f64, square.sqrt()));
        done = next;
    }
    let ns = 1e9 * (clock::cpu_seconds() - begun) / (done * SUBSTEPS) as f64 / trajectories as f64;
    Ok(Run { numbers, errors, ns })
}

/// The diagram, with the law.
pub(crate) fn chart(runs: &[Run]) -> Chart {
    let chart =
        Chart::new("The energy in long runs").x("steps of RATTLE").y("error of the energy, r.m.s.").log_log();
    let law = |&(n, _): &(f64, f64)| (n, LAW * n.sqrt());
    let law = runs[0].errors.iter().map(law).collect::<Vec<_>>();
    let chart = chart.line("1e-17 √n", law);
    runs.iter().fold(chart, |chart, run| {
        let seen = run.errors.iter().copied().filter(|error| error.1 > 0.0);
        chart.marked(format!("{}: {:.0} ns a step", run.numbers, run.ns), seen)
    })
}
