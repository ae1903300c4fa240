//! The pendulum three ways: by its angle, with a multiplier by RATTLE, and with a multiplier by BDF2. And once more,
//! with a multiplier that acts on x alone.
//!
//! ```text
//! cargo run --release --example pendulum_three_ways
//! angle        φ̈ = −(g/l) sin φ
//! multiplier   q̈ = −g e_y + λ ∇c,          c = √(x² + y²) − l
//! x alone      ẍ = λ ∂c/∂x,   ÿ = −g,      c = 0
//! ```
//!
//! The first two equations are one motion, and the three ways come together like h². BDF2 is what general solvers of
//! differential-algebraic equations do: it loses energy in every swing, and from 0.9 π, where a little energy changes
//! the period much, it soon runs ahead. RATTLE keeps energy at the same step. λ is positive where the rod pushes
//! outwards; texts that write the force as −λ∇c have the tension −λ of here, and that is drawn. The third is not
//! mechanics: the mass falls freely in y, and at the bottom no force along x can hold the rod: the error says so.
//!
//! Draws φ(t) and the tension as texts on multipliers do, energy errors, and the fall with a multiplier on x alone,
//! into `out/pendulum_three_ways/`.

use rattle::bill::Bill;
use rattle::plot::Chart;
use rattle::potentials::planar::Gravity;
use rattle::prelude::*;
use std::error::Error;
use std::f64::consts::PI;

constraint! {
    /// A rod of this length from the origin; |∇c| = 1, so that λ is a force.
    struct Rod { length }
    |x, y| sqrt(x^2 + y^2) - length
}

potential! {
    /// The same over the angle from the bottom.
    struct Swing { g, length }
    |angle| -g * length * cos(angle)
}

const LENGTH: f64 = 1.0;
const G: f64 = 1.0;
const START: f64 = 0.9 * PI;
const T: f64 = 100.0;

type Curve = Vec<(f64, f64)>;

/// φ and kinetic energy by the angle. The momentum of an angle is l² φ̇: the mass in that coordinate is l².
fn by_angle(h: f64) -> Result<(Curve, Curve), rattle::Error> {
    let scene = Scene::point().mass(LENGTH * LENGTH).with(Swing { g: G, length: LENGTH });
    let mut simulation = scene.simulate(State::at([START]), Rattle::new(h))?;
    let (mut angle, mut kinetic) = (Vec::new(), Vec::new());
    let mut see = |now: &Simulation<_, _, 1>| {
        angle.push((now.time(), now.position().x));
        kinetic.push((now.time(), now.kinetic_energy()));
    };
    see(&simulation);
    simulation.run_with((T / h).round() as u64, see)?;
    Ok((angle, kinetic))
}

/// What a run in x and y shows.
#[derive(Default)]
struct Run {
    angle: Curve,
    tension: Curve,
    kinetic: Curve,
    energy_error: Curve,
    /// What a step costs.
    bill: Option<Bill>,
    /// Why it ended before its time.
    ended: Option<rattle::Error>,
}

/// The pendulum in x and y. The multiplier acts on these coordinates; on both is what `link` or `Scene::on` would do.
fn by_multiplier(method: impl Method, acting: [bool; 2]) -> Result<Run, rattle::Error> {
    let rod = Rod { length: LENGTH };
    let scene = Scene::point().link_acting(rod, [[0]], [acting]).with(Gravity { g: G });
    let start = State::at([LENGTH * START.sin(), -LENGTH * START.cos()]);
    let steps = (T / method.step_size()).round() as u64;
    let mut simulation = scene.simulate(start, method)?;
    let mut run = Run::default();
    let mut see = |now: &Simulation<_, _, 2>| {
        let (q, t) = (now.position(), now.time());
        run.angle.push((t, q.x.atan2(-q.y)));
        run.tension.push((t, -now.multiplier()));
        run.kinetic.push((t, now.kinetic_energy()));
        run.energy_error.push((t, now.energy_error()));
    };
    see(&simulation);
    run.ended = simulation.run_with(steps, see).err();
    run.bill = simulation.bill().ok();
    Ok(run)
}

/// The largest difference of two curves at the same times.
fn apart(a: &Curve, b: &Curve) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a.1 - b.1).abs()).fold(0.0, f64::max)
}

/// A run with the multiplier on both, which nothing ends before its time.
fn whole(method: impl Method) -> Result<Run, rattle::Error> {
    let mut run = by_multiplier(method, [true, true])?;
    match run.ended.take() {
        Some(error) => Err(error),
        None => Ok(run),
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "largest |φ − φ'| from the motion by its angle at h = 0.000625, and energy error at the end, t = {T}"
    );
    println!(
        "     h       angle   ratio      RATTLE   ratio        BDF2   ratio  energy, RATTLE  energy, BDF2"
    );
    let fine = by_angle(0.000_625)?.0;
    let mut last = [None; 3];
    for h in [0.01, 0.005, 0.0025] {
        let every = (h / 0.000_625_f64).round() as usize;
        let exact: Curve = fine.iter().step_by(every).copied().collect();
        let (rattle, bdf2) = (whole(Rattle::new(h))?, whole(Bdf2::new(h))?);
        let errors = [&by_angle(h)?.0, &rattle.angle, &bdf2.angle].map(|angle| apart(angle, &exact));
        let mut line = format!("{h:6.4}");
        for (error, last) in errors.into_iter().zip(&mut last) {
            let ratio = last.map_or(String::new(), |last: f64| format!("{:.2}", last / error));
            line += &format!(" {error:11.2e} {ratio:>7}");
            *last = Some(error);
        }
        let [kept, lost] = [&rattle, &bdf2].map(|run| run.energy_error.last().map_or(f64::NAN, |p| p.1));
        println!("{line} {kept:15.2e} {lost:13.2e}");
    }

    let h = 0.01;
    let (angle, kinetic) = by_angle(h)?;
    let (rattle, bdf2) = (whole(Rattle::new(h))?, whole(Bdf2::new(h))?);
    let falling = by_multiplier(Rattle::new(h), [true, false])?;
    let largest = rattle.tension.iter().map(|p| p.1).fold(f64::MIN, f64::max);
    let smallest = rattle.tension.iter().map(|p| p.1).fold(f64::MAX, f64::min);
    println!("\nTension of the rod from {smallest:.4} to {largest:.4}; exact, 3 cos φ − 2 cos φ₀ times m g:");
    println!("                   from {:.4} to {:.4}", START.cos(), 3.0 - 2.0 * START.cos());
    if let Some(error) = falling.ended {
        let bottom = (2.0 * LENGTH * (1.0 - START.cos()) / G).sqrt();
        println!("\nMultiplier on x alone; free fall reaches the bottom at t = {bottom:.4}:\n  {error}");
    }

    for bill in [&rattle.bill, &bdf2.bill].into_iter().flatten() {
        println!("\n{bill}");
    }

    let time = "time t / √(l/g)";
    fn last_swings(curve: &Curve) -> impl Iterator<Item = (f64, f64)> {
        curve.iter().copied().filter(|point| point.0 >= 0.8 * T)
    }
    // As texts draw it: angle and multiplier in one picture.
    for (name, title, of) in [
        ("angle", "A pendulum from 0.9 π, three ways, h = 0.01: the last swings", None),
        ("rattle", "RATTLE: angle and tension of the rod, negative where it pushes outwards", Some(&rattle)),
        ("bdf2", "BDF2: angle and tension of the rod, negative where it pushes outwards", Some(&bdf2)),
    ] {
        let chart = Chart::new(title).x(time).y("angle φ / rad, tension −λ / m g");
        let chart = match of {
            Some(run) => chart
                .line("angle φ", run.angle.iter().copied())
                .line("tension −λ", run.tension.iter().copied()),
            None => chart
                .y("angle φ from the bottom / rad")
                .line("RATTLE", last_swings(&rattle.angle))
                .line("BDF2", last_swings(&bdf2.angle))
                .points("by the angle", last_swings(&angle).step_by(25)),
        };
        chart.save(format!("out/pendulum_three_ways/{name}.svg"))?;
    }
    Chart::new("Energy error: RATTLE swings, BDF2 loses")
        .x(time)
        .y("energy error / m g l")
        .line("RATTLE", rattle.energy_error.iter().copied())
        .line("BDF2", bdf2.energy_error.iter().copied())
        .save("out/pendulum_three_ways/energy.svg")?;
    // What grows without bound at the bottom, t = 1.98, would flatten all else.
    let early = |curve: Curve| curve.into_iter().filter(|p| p.0 <= 1.6).collect::<Vec<_>>();
    Chart::new("The first moments, whole multiplier and on x alone")
        .x(time)
        .y("tension −λ / m g, kinetic energy / m g l")
        .line("tension", early(rattle.tension))
        .line("tension, on x", early(falling.tension))
        .line("energy", early(kinetic))
        .line("energy, on x", early(falling.kinetic))
        .save("out/pendulum_three_ways/first_moments.svg")?;
    println!(
        "\nWritten to out/pendulum_three_ways: angle.svg, rattle.svg, bdf2.svg, energy.svg, first_moments.svg"
    );
    Ok(())
}
