//! What the constraint knows about its surface: how many handles it has, and what its multiplier shows.
//!
//! ```text
//! cargo run --release --example curvature
//! ```
//!
//! 1. The genus of the notebook's surface, measured as 1 − ∫ K dA/4π (Gauss and Bonnet) without a mesh. The notebook
//!    guesses that the surface has its handles while r < a/√2; they close at r = a⁴/4.
//! 2. The notebook guesses that the multiplier indicates curvature. It is λ|∇g| = −(κ|v|² + n·f): for a free particle
//!    the normal curvature along the path itself, with a force also what that presses on the surface.
//!
//! Prints both as tables and draws them into `out/curvature/`.

use rattle::bill::Bill;
use rattle::curvature::{Curvature, measure};
use rattle::nalgebra::SVector;
use rattle::plot::Chart;
use rattle::potentials::Gravity;
use rattle::prelude::*;
use rattle::surfaces::Lemniscate;
use std::error::Error;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

const SURFACE: Lemniscate = Lemniscate { a: 1.0, r: 1.0 / 6.0 };
const T: f64 = 5.0;

fn main() -> Result<(), Box<dyn Error>> {
    handles()?;
    multipliers()
}

/// Genus over r, with two numbers of lines: where they agree, it can be believed.
fn handles() -> Result<(), Box<dyn Error>> {
    let radii = [
        0.05, 0.1, 0.15, 0.2, 0.22, 0.24, 0.245, 0.248, 0.249, 0.2495, 0.2505, 0.251, 0.252, 0.255, 0.26,
        0.28, 0.3, 0.35, 0.4, 0.45,
    ];
    println!("Lemniscate, a = 1: measured with 150 and with 300 lines along the box\n");
    println!("     r     area     ∫K dA/4π   genus (150)   genus (300)   rounded");
    let (mut coarse, mut fine) = (Vec::new(), Vec::new());
    for r in radii {
        let surface = Lemniscate { a: 1.0, r };
        let with = |lines| measure(&surface, [-1.3, -0.8, -0.5], [1.3, 0.8, 0.5], lines);
        let (rough, found) = (with(150)?, with(300)?);
        println!(
            "{r:8.4} {:8.4} {:10.5} {:13.5} {:13.5} {:9.0}",
            found.area,
            found.total_curvature / (4.0 * PI),
            rough.genus(),
            found.genus(),
            found.genus().round() + 0.0, // no −0
        );
        coarse.push((r, rough.genus()));
        fine.push((r, found.genus()));
    }
    Chart::new("Inflated lemniscate, a = 1: the two handles close at r = a⁴/4 = 0.25")
        .x("radius r")
        .y("genus, measured as 1 − ∫K dA / 4π")
        .marked("150 lines", coarse)
        .marked("300 lines", fine)
        .save("out/curvature/genus.svg")?;
    Ok(())
}

/// The parts of λ|∇g| = −(κ|v|² + n·f) after every step.
#[derive(Default)]
struct Parts {
    t: Vec<f64>,
    /// (μₙ + λₙ₊₁)/2 · |∇g|: what RATTLE's equations gave, which know nothing of curvature.
    rattle: Vec<f64>,
    /// −κ|v|².
    bending: Vec<f64>,
    /// −n·f.
    pressure: Vec<f64>,
    /// What a step costs.
    bill: Option<Bill>,
}

impl Parts {
    /// The notebook's path in the direction 45°, with gravity `g` or none.
    fn of(g: f64, h: f64) -> Result<Self, rattle::Error> {
        let gravity = || Gravity { g };
        let start = State::at([0.0, 0.0, SURFACE.r]).moving([FRAC_1_SQRT_2, FRAC_1_SQRT_2, 0.0]);
        let mut simulation = Scene::on(SURFACE).with(gravity()).simulate(start, Rattle::new(h))?;
        let mut path = Trajectory::with_multipliers(&simulation);
        simulation.observe((T / h).round() as u64, 1, &mut path)?;

        let mut parts = Self { bill: Some(simulation.bill()?), ..Self::default() };
        let Some(found) = path.multipliers() else { return Ok(parts) };
        let (positions, momenta) = (path.positions().as_chunks().0, path.momenta().as_chunks().0);
        for n in 1..path.times().len() - 1 {
            let (q, v) = (positions[n].into(), SVector::<f64, 3>::from(momenta[n]));
            let gradient = SURFACE.jacobian(&q).transpose();
            parts.t.push(path.times()[n]);
            parts.rattle.push((found.momentum[n] + found.position[n + 1]) / 2.0 * gradient.norm());
            parts.bending.push(-SURFACE.normal_curvature(&q, &v) * v.norm_squared());
            parts.pressure.push(gradient.normalize().dot(&gravity().gradient(&q)));
        }
        Ok(parts)
    }

    /// The largest |RATTLE − (−κ|v|² − n·f)|.
    fn error(&self) -> f64 {
        let exact = self.bending.iter().zip(&self.pressure).map(|(bending, pressure)| bending + pressure);
        self.rattle.iter().zip(exact).map(|(rattle, exact)| (rattle - exact).abs()).fold(0.0, f64::max)
    }

    fn against_time<'a>(&'a self, y: &'a [f64]) -> impl Iterator<Item = (f64, f64)> + 'a {
        self.t.iter().copied().zip(y.iter().copied())
    }
}

fn multipliers() -> Result<(), Box<dyn Error>> {
    println!("\nLargest difference of RATTLE's (μₙ + λₙ₊₁)/2 · |∇g| and −(κ|v|² + n·f) until t = {T}\n");
    println!("       h      free        gravity");
    let (mut last, mut ratios) = ([f64::NAN; 2], [f64::NAN; 2]);
    for h in [0.01, 0.005, 0.0025, 0.00125] {
        let now = [Parts::of(0.0, h)?.error(), Parts::of(1.0, h)?.error()];
        println!("{h:8.5} {:11.3e} {:12.3e}", now[0], now[1]);
        ratios = [last[0] / now[0], last[1] / now[1]];
        last = now;
    }
    println!("Ratios of the last two rows: {:.2} and {:.2}; second order is 4.", ratios[0], ratios[1]);

    let (free, falling) = (Parts::of(0.0, 0.00125)?, Parts::of(1.0, 0.00125)?);
    if let Some(bill) = &falling.bill {
        println!("\n{bill}");
    }
    Chart::new("Billiard under gravity 1 (a = 1, r = 1/6): what the multiplier is made of")
        .x("time t")
        .y("force along the normal, per mass")
        .line("λ|∇g|, RATTLE", falling.against_time(&falling.rattle))
        .line("−κ|v|², curvature", falling.against_time(&falling.bending))
        .line("−n·f, weight", falling.against_time(&falling.pressure))
        .save("out/curvature/multiplier.svg")?;
    let over_curvature = |parts: &Parts| {
        let curvature = parts.bending.iter().map(|bending| -bending);
        curvature.zip(parts.rattle.iter().copied()).collect::<Vec<_>>()
    };
    let every_fiftieth: Vec<_> = over_curvature(&free).into_iter().step_by(50).collect();
    Chart::new("The multiplier shows the curvature: exactly, where no force acts")
        .x("κ|v|², normal curvature along the path times speed squared")
        .y("λ|∇g| of RATTLE")
        .line("gravity: off by −n·f, up to ±1", over_curvature(&falling))
        .points("free: λ|∇g| = −κ|v|²", every_fiftieth)
        .save("out/curvature/scatter.svg")?;
    println!("\nWritten to out/curvature: genus.svg, multiplier.svg, scatter.svg");
    Ok(())
}
