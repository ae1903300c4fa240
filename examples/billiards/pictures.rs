//! The notebook's curves, the data, and the page.

use crate::{Run, SURFACE, directions};
use rattle::data::Npz;
use rattle::plot::Chart;
use rattle::view::{Mesh, Page, Scene3, surface};
use std::error::Error;
use std::f64::consts::TAU;
use std::path::Path;

pub(crate) fn write(falling: &[Run], gas: &Run) -> Result<(), Box<dyn Error>> {
    let folder = Path::new("out/billiards");
    curves(falling, gas, folder)?;
    data(falling, gas, folder)?;
    page(falling, gas, folder)
}

/// The curve itself, energies, and the multipliers of one path.
fn curves(falling: &[Run], gas: &Run, folder: &Path) -> Result<(), Box<dyn Error>> {
    let parametric = (0..=256).map(|i| {
        let (sin, cos) = (TAU * f64::from(i) / 256.0).sin_cos();
        let scale = SURFACE.a * sin / (1.0 + cos * cos);
        (scale, scale * cos)
    });
    Chart::new("The Bernoulli lemniscate, a = 1")
        .x("x")
        .y("y")
        .equal_aspect()
        .line("", parametric)
        .save(folder.join("lemniscate.svg"))?;

    let energy = |run: &Run| {
        let scaled = run.energy_errors.iter().map(|error| error / run.mean_kinetic);
        run.trajectory.times().iter().copied().zip(scaled).collect::<Vec<_>>()
    };
    // The other directions mirror these seven, and would be drawn over them.
    let labels = directions().take(7).map(|theta| format!("θ = {:.0}°", theta.to_degrees()));
    Chart::new("Energy error under gravity, h = 0.01, directions 0° to 90°")
        .x("time t")
        .y("(E − E₀) / mean kinetic energy")
        .family(labels.zip(falling.iter().map(energy)))
        .save(folder.join("energy.svg"))?;
    Chart::new("Energy error of the gas, h = 0.01")
        .x("time t")
        .y("(E − E₀) / mean kinetic energy")
        .line("", energy(gas))
        .save(folder.join("gas_energy.svg"))?;

    // The notebook's path 6. Each multiplier alone is first order, their mean second: λ(tₙ) = (μₙ + λₙ₊₁)/2.
    let path = &falling[6].trajectory;
    let Some(multipliers) = path.multipliers() else { return Err("no multipliers were recorded".into()) };
    let means =
        multipliers.momentum.iter().zip(&multipliers.position[1..]).map(|(mu, lambda)| (mu + lambda) / 2.0);
    Chart::new("Multiplier of the path θ = 90°")
        .x("time t")
        .y("λ(t) = (μₙ + λₙ₊₁)/2")
        .line("", path.times().iter().copied().zip(means))
        .save(folder.join("multipliers.svg"))?;
    Ok(())
}

/// Arrays for `numpy.load`.
fn data(falling: &[Run], gas: &Run, folder: &Path) -> Result<(), Box<dyn Error>> {
    let times = falling[0].trajectory.times();
    let (paths, rows) = (falling.len(), times.len());
    let joined = |part: &dyn Fn(&Run) -> &[f64]| falling.iter().flat_map(part).copied().collect::<Vec<f64>>();
    let multipliers = |run: &Run| run.trajectory.multipliers().cloned().unwrap_or_default();
    let lambda: Vec<f64> = falling.iter().flat_map(|run| multipliers(run).position).collect();
    let mu: Vec<f64> = falling.iter().flat_map(|run| multipliers(run).momentum).collect();
    Npz::create(folder.join("trajectories.npz"))?
        .array("t", &[rows], times)?
        .array("q", &[paths, rows, 3], &joined(&|run| run.trajectory.positions()))?
        .array("p", &[paths, rows, 3], &joined(&|run| run.trajectory.momenta()))?
        .array("lambda", &[paths, rows], &lambda)?
        .array("mu", &[paths, rows], &mu)?
        .finish()?;
    Npz::create(folder.join("gas.npz"))?.trajectory(&gas.trajectory)?.finish()?;
    Ok(())
}

/// One page with both halves, meshed from the constraint itself.
fn page(falling: &[Run], gas: &Run, folder: &Path) -> Result<(), Box<dyn Error>> {
    let mesh = Mesh::around(surface(&SURFACE), [0.0, 0.0, 0.1], 160)?;
    let fan = falling
        .iter()
        .fold(Scene3::new("25 directions under gravity").surface(&mesh).trail(100), |scene, run| {
            scene.trajectory(&run.trajectory)
        });
    let crowd = Scene3::new("A gas of 21 particles").surface(&mesh).trajectory(&gas.trajectory).trail(100);
    Page::new("Billiards on a surface of genus two")
        .scene(
            fan.caption(
                "25 particles of mass 1 start at the crossing of the lemniscate, 15° apart; gravity 1 acts along −z. \
                 The first and the last direction are the same but for rounding: chaos parts them near t = 11.",
            ),
        )
        .scene(
            crowd.caption(
                "They start at rest, along one path of the first scene. Two of them repel each other when nearer than \
                 1/6, the radius of the tube, and attract when farther, up to about 1/2.",
            ),
        )
        .write(folder.join("index.html"))?;
    Ok(())
}
