//! How fast baths and noise act, where equilibrium does not tell: exact laws at the temperature zero, and statistics of
//! single steps with bounds of 4.5 standard deviations.

use crate::common::statistics::DEVIATIONS;
use crate::common::{Sphere, distance};
use rattle::effect::{Andersen, Langevin, VelocityRescaling};
use rattle::potentials::ConstantForce;
use rattle::prelude::*;

const AT_REST: [f64; 3] = [0.0; 3];

fn langevin(friction: f64) -> Langevin {
    Langevin { friction, temperature: 0.0, seed: 1 }
}

/// p = p₀ exp(−γt), alone and in lanes.
#[test]
fn friction_of_langevin_is_its_rate() {
    fn check<S: Method>(method: S) {
        let (scene, p, steps) = (Scene::point().with(langevin(0.7)), [1.0, -2.0, 0.5], 25);
        let start = State::at(AT_REST).moving(p);
        let mut alone = scene.simulate(start.clone(), method.clone()).unwrap();
        alone.run(steps).unwrap();
        let mut lanes = scene.ensemble([start], method.clone()).unwrap();
        lanes.run(steps);
        let left = (-0.7 * alone.time()).exp();
        for found in [alone.momentum(), lanes.state(0).momenta().next().unwrap()] {
            let off = distance(found, p.map(|p| p * left));
            assert!(off < 1e-14, "{}: {found:?}, {off:e}", method.name());
        }
    }
    check(Rattle::new(0.1));
    check(Baoab::new(0.1));
    check(Baoab::new(0.02));
}

/// Under a constant force f bodies drift at f/γ · x coth x, x = hγ/2.
#[test]
fn drift_of_langevin_in_long_steps() {
    let f = [1.0, 0.0, 0.0];
    for (steepness, told) in [(0.5, 1.02), (1.0, 1.08), (4.0, 2.07), (10.0, 5.0)] {
        let (friction, x) = (2.0, 0.5 * steepness);
        let (h, exact) = (steepness / friction, x / f64::tanh(x));
        assert!((exact - told).abs() < 0.006, "as told: {exact}");
        let scene = Scene::point().with(ConstantForce { force: f }).with(langevin(friction));
        let start = State::at(AT_REST);
        let mut rattle = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
        let mut baoab = scene.simulate(start, Baoab::new(h)).unwrap();
        rattle.run(100).unwrap(); // until e⁻⁵⁰ of the rest is left
        baoab.run(100).unwrap();
        let before = [rattle.position().x, baoab.position().x];
        rattle.run(10).unwrap();
        baoab.run(10).unwrap();
        for (before, now) in before.into_iter().zip([rattle.position().x, baoab.position().x]) {
            let times = (now - before) / (10.0 * h) * friction;
            assert!((times / exact - 1.0).abs() < 1e-12, "hγ = {steepness}: {times} for {exact}");
        }
    }
}

/// K = K₀ exp(−t/τ).
#[test]
fn rescaling_has_its_time() {
    let bath = VelocityRescaling { time: 1.7, temperature: 0.0, seed: 1 };
    let start = State::of([AT_REST; 3]).with_momenta([[1.0, 2.0, 0.0], [0.0, -1.0, 0.5], [0.3, 0.0, 0.0]]);
    let mut simulation = Scene::points(3).with(bath).simulate(start, Rattle::new(0.1)).unwrap();
    let first = simulation.kinetic_energy();
    simulation.run(30).unwrap();
    let (found, exact) = (simulation.kinetic_energy() / first, (-simulation.time() / 1.7).exp());
    assert!((found / exact - 1.0).abs() < 1e-13, "{found} for {exact}");
}

/// Collisions with a bath at the temperature zero stop bodies: exp(−νt) of them have met none.
#[test]
fn collisions_of_andersen_have_their_rate() {
    let (n, rate) = (10_000, 0.8);
    let bath = Andersen { rate, temperature: 0.0, seed: 5 };
    let start = State::of(vec![AT_REST; n]).moving([1.0, 0.0, 0.0]);
    let mut simulation = Scene::points(n).with(bath).simulate(start, Rattle::new(0.25)).unwrap();
    for _ in 0..3 {
        simulation.run(2).unwrap();
        let share = simulation.momenta().filter(|p| p.x != 0.0).count() as f64 / n as f64;
        let exact = (-rate * simulation.time()).exp();
        let deviation = (exact * (1.0 - exact) / n as f64).sqrt();
        assert!((share - exact).abs() < DEVIATIONS * deviation, "{share} for {exact} ± {deviation:.1e}");
    }
}

/// The kinetic energy and the chain of free bodies by their equations, in steps of Runge and Kutta.
fn chain(mut x: [f64; 4], [freedom, kt, tau]: [f64; 3], time: f64) -> [f64; 4] {
    let pull = 1.0 / (tau * tau);
    let rates = |[k, a, b, c]: [f64; 4]| {
        let first = (2.0 * k / (freedom * kt) - 1.0) * pull - a * b;
        [-2.0 * a * k, first, freedom * a * a - pull - b * c, b * b - pull]
    };
    let ahead = |x: [f64; 4], h: f64, v: [f64; 4]| std::array::from_fn(|i| x[i] + h * v[i]);
    let (steps, h) = (2000, time / 2000.0);
    for _ in 0..steps {
        let first = rates(x);
        let second = rates(ahead(x, 0.5 * h, first));
        let third = rates(ahead(x, 0.5 * h, second));
        let last = rates(ahead(x, h, third));
        x = std::array::from_fn(|i| x[i] + h / 6.0 * (first[i] + 2.0 * (second[i] + third[i]) + last[i]));
    }
    x
}

/// K is what the equations of the chain make of it. At first it swings by ω² = 2/τ²: (K − K̄)/(K₀ − K̄) = 1 − t²/τ².
#[test]
fn baths_of_nose_and_hoover_have_their_time() {
    let (kt, tau, freedom) = (0.7, 1.3, 6.0);
    let hot = |by: f64| {
        let p = (by * kt).sqrt(); // p²/2 = by · kT/2 for each of six momenta
        State::of([AT_REST; 2]).moving([p, -p, p])
    };
    let mean = 0.5 * freedom * kt;
    let run = |by: f64, h: f64, steps: u64| {
        let mut simulation = Scene::points(2).simulate(hot(by), NoseHoover::new(kt, tau, h)).unwrap();
        assert!((simulation.kinetic_energy() / (by * mean) - 1.0).abs() < 1e-14);
        simulation.run(steps).unwrap();
        (simulation.kinetic_energy(), simulation.time())
    };
    let by = 1.0 + 1e-4;
    let (now, time) = run(by, 1e-3, 50);
    let swung = (1.0 - (now - mean) / (1e-4 * mean)) * (tau / time).powi(2);
    assert!((swung - 1.0).abs() < 1e-2, "{swung}");
    for by in [0.5, 2.0] {
        let (now, time) = run(by, 2e-3, 2000);
        let exact = chain([by * mean, 0.0, 0.0, 0.0], [freedom, kt, tau], time)[0];
        assert!((now / exact - 1.0).abs() < 1e-4, "{now} for {exact}");
    }
}

/// ⟨Δq²⟩ = 2 kT h/(γm) of 600 000 numbers in single steps: to 4.5 √(2/n), 0.8 %.
#[test]
fn brownian_steps_have_their_length() {
    let (n, [kt, friction, mass, h]) = (50_000, [0.5, 2.0, 2.5, 0.03]);
    let scene = Scene::points(n).masses(vec![mass; n]);
    let mut simulation =
        scene.simulate(State::of(vec![AT_REST; n]), Brownian::new(friction, kt, 9, h)).unwrap();
    let (mut sum, mut before) = (0.0, vec![AT_REST; n]);
    for _ in 0..4 {
        simulation.run(1).unwrap();
        for (q, before) in simulation.positions().zip(&mut before) {
            sum += (0..3).map(|i| (q[i] - before[i]).powi(2)).sum::<f64>();
            *before = q.into();
        }
    }
    let (numbers, exact) = (12.0 * n as f64, 2.0 * kt * h / (friction * mass));
    let found = sum / numbers;
    assert!((found / exact - 1.0).abs() < DEVIATIONS * (2.0 / numbers).sqrt(), "{found} for {exact}");

    // Without heat a force moves a body by h f/(γm).
    let pulled = Scene::points(1).masses([mass]).with(ConstantForce { force: [0.0, 3.0, 0.0] });
    let mut simulation = pulled.simulate(State::of([AT_REST]), Brownian::new(friction, 0.0, 9, h)).unwrap();
    simulation.run(1).unwrap();
    let (found, exact) = (simulation.positions().next().unwrap().y, 3.0 * h / (friction * mass));
    assert!((found - exact).abs() < 1e-16, "{found} for {exact}");
}

/// ½kT for each of 200 000 momenta along spheres: the standard deviation of a mean is kT (2/N)^½.
#[test]
fn gases_begin_at_their_temperature() {
    let (n, kt) = (100_000, 0.7);
    let places = (0..n).map(|i| {
        let (sin, cos) = (0.1 * f64::from(i)).sin_cos();
        [0.6 * cos, 0.6 * sin, if i % 2 == 0 { 0.8 } else { -0.8 }]
    });
    let gas = Scene::on(Sphere { r: 1.0 }).bodies(n as usize);
    let start = gas.maxwell(&State::of(places), kt, 3).unwrap();
    let momenta = 2.0 * f64::from(n);
    let found = start.momenta().map(|p| p.norm_squared()).sum::<f64>() / momenta;
    assert!((found - kt).abs() < DEVIATIONS * kt * (2.0 / momenta).sqrt(), "{found}");
}
