//! What a notebook (“Billiards on surfaces”), a lecture note on symplectic methods and a tutorial on multipliers say of
//! their runs, found again. The examples `billiards`, `leapfrog` and `pendulum_three_ways` make the same runs.

use crate::common::*;
use rattle::composition::SOFRONIOU_SPALETTA_2005_ORDER_10;
use rattle::potentials::planar::Gravity as Weight;
use rattle::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, SQRT_2};

potential! {
    /// A pendulum of length 1 over its angle from the bottom.
    struct Swing {}
    |angle| -cos(angle)
}

constraint! {
    /// |∇c| = 1, so that λ is a force.
    struct Length {}
    |x, y| sqrt(x^2 + y^2) - 1
}

/// Whether a number is that of the source, or of the example, to so many parts of it.
fn near(found: f64, told: f64, parts: f64) {
    assert!((found / told - 1.0).abs() <= parts, "{found}, where {told} is told");
}

/// The largest deviation of the energy until t = 5 and until t = 20, over the mean kinetic energy, of 25 directions.
fn deviations(h: f64) -> Vec<[f64; 2]> {
    let steps = (20.0 / h).round() as u64;
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let of_one = |theta| {
        let mut simulation = scene.simulate(billiard(theta), Rattle::new(h)).unwrap();
        let (mut largest, mut kinetic) = ([0.0_f64; 2], simulation.kinetic_energy());
        let see = |now: &Simulation<_, _, 3>| {
            let until = if now.time() < 5.0 + 0.5 * h { 0 } else { 1 };
            largest[until] = largest[until].max(now.energy_error().abs());
            kinetic += now.kinetic_energy();
        };
        simulation.run_with(steps, see).unwrap();
        let mean = kinetic / (steps + 1) as f64;
        [largest[0] / mean, largest[0].max(largest[1]) / mean]
    };
    directions().map(of_one).collect()
}

/// The notebook: “on the order of 1 %”, and “cut by a factor of four” with half the step. The factor is that of order
/// 2, to what is left of order 4, a fortieth; the worst path is the same at both steps until t = 5 alone. Numbers are
/// those that the example prints, whose last digit is a 200th of the smallest.
#[test]
fn billiards_deviate_by_a_percent_and_a_quarter_of_it_by_half_the_step() {
    let [whole, half] = [0.01, 0.005].map(deviations);
    let worst = |all: &[[f64; 2]], until: usize| all.iter().map(|own| own[until]).fold(0.0, f64::max);
    let mean = |all: &[[f64; 2]]| all.iter().map(|own| own[1]).sum::<f64>() / 25.0;
    near(worst(&whole, 0), 0.01071, 0.005);
    near(worst(&half, 0), 0.00263, 0.005);
    near(worst(&whole, 1), 0.01229, 0.005);
    near(worst(&half, 1), 0.00280, 0.005);
    near(mean(&whole), 0.00909, 0.005);
    near(mean(&half), 0.00223, 0.005);
    near(worst(&whole, 0) / worst(&half, 0), 4.0, 0.025);
    near(mean(&whole) / mean(&half), 4.0, 0.025);
}

/// The lecture note: bounded for all of its steps. Momentum is 0 half a step beside the start, so that the energy there
/// is h²/8. The energy that the method keeps is p²/2 − cos θ + h² (p² cos θ/12 − sin² θ/24) with momenta at the times
/// of the angles, and p²/2 − cos θ + h² (sin² θ/12 − p² cos θ/24) with those between: of that |θ| is π/2 + h²/8 at
/// most, |p| √2 (1 + h²/12), and the energy goes from −h²/12 to h²/8. What is left is of order h⁴, a fortieth of that
/// as measured.
#[test]
fn the_leapfrog_stays_where_the_energy_that_it_keeps_holds_it() {
    for h in [0.1, 0.05] {
        let scene = Scene::point().with(Swing {});
        let mut simulation = scene.simulate(State::at([FRAC_PI_2]), Leapfrog::new(h)).unwrap();
        let (mut angle, mut momentum, mut energies) = (0.0_f64, 0.0_f64, [f64::INFINITY, f64::NEG_INFINITY]);
        let mut before = 0.0;
        let steps = (500.0 / h).round() as u64;
        for _ in 0..steps {
            simulation.step().unwrap();
            let after = simulation.momentum().x;
            angle = angle.max(simulation.position().x.abs());
            momentum = momentum.max(after.abs());
            let at_angle = 0.5 * (before + after);
            let energy = 0.5 * at_angle * at_angle + simulation.potential_energy();
            energies = [energies[0].min(energy), energies[1].max(energy)];
            before = after;
        }
        let h2 = h * h;
        for (what, found, exact) in [
            ("|θ|", angle, FRAC_PI_2 + h2 / 8.0),
            ("|p|", momentum, SQRT_2 * (1.0 + h2 / 12.0)),
            ("least energy", energies[0], -h2 / 12.0),
            ("most energy", energies[1], h2 / 8.0),
        ] {
            assert!((found - exact).abs() <= h2 * h2 / 32.0, "h = {h}, {what}: {found} for {exact}");
        }
    }
}

/// The lecture note's run by a package: steps of 1.2, a sixth of the period, until t = 50, of which the example says
/// 6.6e-6. Half the step leaves less than order 10 says, 2⁻¹⁰.
#[test]
fn a_method_of_order_ten_swings_by_a_sixth_of_the_period() {
    let error = |h| {
        let method = Composition::new(SOFRONIOU_SPALETTA_2005_ORDER_10, h);
        let mut simulation = Scene::point().with(Swing {}).simulate(State::at([FRAC_PI_2]), method).unwrap();
        let mut error = 0.0_f64;
        simulation
            .run_with((50.0_f64 / h).ceil() as u64, |now| error = error.max(now.energy_error().abs()))
            .unwrap();
        (simulation.steps(), error)
    };
    let ((steps, whole), (_, half)) = (error(1.2), error(0.6));
    assert_eq!(steps, 42);
    near(whole, 6.6e-6, 0.01);
    assert!(half <= whole / 1024.0, "{half:e} after {whole:e}");
}

/// Where the tutorial's pendulum begins, at rest.
const HIGH: f64 = 0.9 * PI;

/// The largest of each until t = 100, but for the energy at the end.
struct Pendulum {
    /// |φ − φ'|, every 0.01, φ' being that of the angle as a coordinate by another method.
    angle: f64,
    energy: f64,
    /// |−λ − (3 cos φ − 2 cos φ₀)|.
    tension: f64,
    /// Least and most tension.
    ends: [f64; 2],
}

impl Pendulum {
    fn by<S: Method>(method: S) -> Self {
        let mut exact = vec![HIGH];
        let by_angle = Scene::point().with(Swing {}).simulate(State::at([HIGH]), Dop853::new(0.01));
        by_angle.unwrap().run_with(10_000, |now| exact.push(now.position().x)).unwrap();

        let h = method.step_size();
        let start = State::at([HIGH.sin(), -HIGH.cos()]);
        let mut simulation = Scene::on(Length {}).with(Weight { g: 1.0 }).simulate(start, method).unwrap();
        let mut seen =
            Pendulum { angle: 0.0, energy: 0.0, tension: 0.0, ends: [f64::INFINITY, f64::NEG_INFINITY] };
        let every = (0.01 / h).round() as u64;
        let see = |now: &Simulation<_, S, 2>| {
            let q = now.position();
            if now.steps().is_multiple_of(every) {
                let off = q.x.atan2(-q.y) - exact[(now.steps() / every) as usize];
                seen.angle = seen.angle.max(off.abs());
            }
            let tension = -now.multiplier();
            seen.tension = seen.tension.max((tension + 3.0 * q.y + 2.0 * HIGH.cos()).abs());
            seen.ends = [seen.ends[0].min(tension), seen.ends[1].max(tension)];
            seen.energy = now.energy_error();
        };
        simulation.run_with((100.0 / h).round() as u64, see).unwrap();
        seen
    }
}

/// The tutorial draws φ(t) and λ(t) of one motion. By RATTLE both are of order 2, with what was measured at h = 0.01
/// and a fiftieth. The rod pulls with 3 cos φ − 2 cos φ₀, and where that is negative it pushes: at the top with cos φ₀.
#[test]
fn a_pendulum_that_its_rod_pulls_and_pushes() {
    for h in [0.01, 0.005] {
        let seen = Pendulum::by(Rattle::new(h));
        near(seen.angle, 26.8 * h * h, 0.02);
        near(seen.tension, 1.93 * h * h, 0.02);
        for (found, exact) in seen.ends.into_iter().zip([HIGH.cos(), 3.0 - 2.0 * HIGH.cos()]) {
            assert!((found - exact).abs() <= 2.0 * h * h, "h = {h}: {found} for {exact}");
        }
        assert!(
            seen.ends[0] < -0.95 && seen.energy.abs() <= 0.11 * h * h,
            "{:?} {:e}",
            seen.ends,
            seen.energy
        );
    }
}

/// The tutorial wants “a small dt for the time stepping scheme to be nearly energy-conserving”, and takes BDF2 with h =
/// 0.01. It loses energy in every swing, like h³, and runs ahead: 90 times as far off as RATTLE at the same step.
#[test]
fn the_same_pendulum_loses_energy_by_bdf2() {
    let [whole, half] = [0.01, 0.005].map(|h| Pendulum::by(Bdf2::new(h)));
    near(whole.angle, 0.2427, 0.01);
    near(whole.energy, -1.34e-3, 0.01);
    near(half.energy, -1.875e-4, 0.01);
    near(whole.ends[1], 4.8997, 1e-4);
    let rattle = Pendulum::by(Rattle::new(0.01));
    near(whole.angle / rattle.angle, 90.0, 0.02);
}
