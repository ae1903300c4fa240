//! Heat: the temperature of each independent momentum, the measure on the surface, averages over places, and noise that
//! is the same in any company. Bounds are from statistics, at fixed seeds: 4.5 standard deviations of what the law
//! gives for so many samples.

use crate::common::statistics::{DEVIATIONS, fits};
use rattle::bodies::Many;
use rattle::curvature::points;
use rattle::effect::{Andersen, Effects, Flow, HardSpheres, Langevin, VelocityRescaling};
use rattle::ensemble::InstructionSet;
use rattle::error::{MethodFailure, StepFailure};
use rattle::links::Rod;
use rattle::method::Method;
use rattle::potentials::{Gravity, Harmonic, LennardJones};
use rattle::prelude::*;
use rattle::surfaces::{Ellipsoid, Sphere, Torus};
use std::f64::consts::TAU;

const KT: f64 = 0.7;

/// A bath in which a momentum is forgotten within a step: exp(−γh) = e⁻².
fn strong(h: f64) -> Langevin {
    Langevin { friction: 2.0 / h, temperature: KT, seed: 11 }
}

/// The mean of kT over so many steps against `KT`: its variance is 2 kT²/N for one sample, and samples a step apart
/// have the correlation e⁻⁸ by each half of the flow's squares.
macro_rules! has_temperature {
    ($simulation:expr, $steps:expr, $freedom:expr) => {{
        let mut simulation = $simulation;
        assert_eq!(simulation.freedom(), $freedom);
        simulation.run(20).unwrap();
        let (mut sum, steps) = (0.0, $steps);
        simulation.run_with(steps, |now| sum += now.temperature()).unwrap();
        let (mean, sigma) = (sum / steps as f64, KT * (2.0 / ($freedom * steps) as f64).sqrt());
        assert!((mean - KT).abs() < DEVIATIONS * sigma, "{mean} of {KT}, σ = {sigma:.1e}");
    }};
}

#[test]
fn half_kt_for_each_independent_momentum() {
    let egg = Scene::on(Ellipsoid { a: 1.0, b: 1.5, c: 2.0 });
    let h = 0.02;
    let start = State::at([0.0, 0.0, 2.0]);
    has_temperature!(egg.with(strong(h)).simulate(start, Rattle::new(h)).unwrap(), 10_000, 2);
    let ring = || Scene::on(Torus { major: 2.0, minor: 0.7 });
    let two = State::of([[2.7, 0.0, 0.0], [-1.3, 0.0, 0.0]]);
    has_temperature!(ring().bodies(2).with(strong(h)).simulate(two, Baoab::new(h)).unwrap(), 4_000, 4);
    let many = State::of((0..1000).map(|i| {
        let angle = f64::from(i);
        [2.7 * angle.cos(), 2.7 * angle.sin(), 0.0]
    }));
    has_temperature!(ring().bodies(1000).with(strong(h)).simulate(many, Baoab::new(h)).unwrap(), 100, 2000);
}

#[test]
fn chains_and_rigid_bodies() {
    // Five rods, pinned at one end, with masses between 1 and 3: 15 coordinates less 5 equations.
    let chain = Scene::points::<3>(6)
        .masses((0..6).map(|i| 1.0 + 0.4 * f64::from(i)))
        .link(Rod { length: 1.0 }, (0..5).map(|i| [i, i + 1]))
        .pin(0, [0.0; 3]);
    let h = 0.01;
    let start = State::of((0..6).map(|i| [f64::from(i), 0.0, 0.0]));
    has_temperature!(chain.with(strong(h)).simulate(start, Baoab::new(h)).unwrap(), 5_000, 10);

    let body = Scene::rigid(Rigid::new([0.5, 1.0, 1.2])).with(strong(h));
    let start = || Rigid::start(&rattle::nalgebra::Matrix3::identity(), &rattle::nalgebra::Vector3::zeros());
    has_temperature!(body.simulate(start(), Rattle::new(h)).unwrap(), 10_000, 3);
    // ½kT about each axis: ⟨m₁²⟩ = I₁ kT.
    let mut body = body.simulate(start(), Rattle::new(h)).unwrap();
    let mut squares = [0.0; 3];
    let steps = 10_000;
    body.run_with(steps, |now| {
        (0..3).for_each(|i| squares[i] += now.momentum()[i].powi(2) / [0.5, 1.0, 1.2][i]);
    })
    .unwrap();
    for square in squares {
        let (mean, sigma) = (square / steps as f64, KT * (2.0 / steps as f64).sqrt());
        assert!((mean - KT).abs() < DEVIATIONS * sigma, "{mean} of {KT}, σ = {sigma:.1e}");
    }
}

/// Places of free bodies in heat are uniform in area. Samples are 50 steps apart, a time of 5, in which friction takes
/// all but e⁻²·⁵ of a momentum: bodies have crossed the surface.
#[test]
#[cfg(long)]
fn places_are_uniform_in_area() {
    const BINS: usize = 20;
    let heat = Langevin { friction: 0.5, temperature: 1.0, seed: 5 };
    let (major, minor) = (1.0, 0.5);
    let ring = Scene::on(Torus { major, minor }).bodies(100).with(heat);
    let mut simulation = ring.simulate(State::of([[1.5, 0.0, 0.0]; 100]), Baoab::new(0.1)).unwrap();
    simulation.run(200).unwrap();
    let mut counts = [0.0; BINS];
    for _ in 0..25 {
        simulation.run(50).unwrap();
        for q in simulation.positions() {
            let angle = q.z.atan2(q.x.hypot(q.y) - major).rem_euclid(TAU);
            counts[(angle / TAU * BINS as f64) as usize % BINS] += 1.0;
        }
    }
    // dA = (R + r cos θ) r dθ dφ
    let edge = |i: usize| TAU * i as f64 / BINS as f64;
    let area = |angle: f64| (angle + minor / major * angle.sin()) / TAU;
    fits(&counts, &std::array::from_fn::<_, BINS, _>(|i| area(edge(i + 1)) - area(edge(i))));

    let (a, c) = (1.0, 2.0);
    let egg = Scene::on(Ellipsoid { a, b: a, c }).bodies(100).with(heat);
    let mut simulation = egg.simulate(State::of([[0.0, 0.0, c]; 100]), Baoab::new(0.1)).unwrap();
    simulation.run(200).unwrap();
    let mut counts = [0.0; BINS];
    for _ in 0..25 {
        simulation.run(50).unwrap();
        for q in simulation.positions() {
            counts[((0.5 * (q.z / c + 1.0) * BINS as f64) as usize).min(BINS - 1)] += 1.0;
        }
    }
    // dA = 2πa √(1 − u² + (a u/c)²) c du with u = z/c, by Simpson's rule.
    let density = |u: f64| (1.0 - u * u + (a * u / c).powi(2)).sqrt();
    let part = |i: usize| {
        let (from, step) = (2.0 * i as f64 / BINS as f64 - 1.0, 2.0 / BINS as f64);
        step / 6.0 * (density(from) + 4.0 * density(from + 0.5 * step) + density(from + step))
    };
    let total = (0..BINS).map(part).sum::<f64>();
    fits(&counts, &std::array::from_fn::<_, BINS, _>(|i| part(i) / total));
}

/// ⟨z⟩ of a body on a sphere of radius 2 under gravity g = ½: −2 L(1/kT) with Langevin's function L(x) = coth x − 1/x.
fn height(kt: f64) -> f64 {
    2.0 * (kt - 1.0 / (1.0 / kt).tanh())
}

/// The mean of z over so many bodies and steps, and its deviation, from the means of single bodies.
fn mean_height<E: Effects<3>>(
    scene: &Scene<Sphere, E, Many, 3>,
    bodies: usize,
    method: impl Method,
    steps: u64,
) -> [f64; 2] {
    let mut simulation = scene.simulate(State::of(vec![[0.0, 0.0, -2.0]; bodies]), method).unwrap();
    simulation.run(steps / 10).unwrap();
    let mut sums = vec![0.0; bodies];
    simulation
        .run_with(steps, |now| sums.iter_mut().zip(now.positions()).for_each(|(sum, q)| *sum += q.z))
        .unwrap();
    let means = sums.iter().map(|sum| sum / steps as f64);
    let mean = means.clone().sum::<f64>() / bodies as f64;
    let variance = means.map(|x| (x - mean).powi(2)).sum::<f64>() / (bodies - 1) as f64;
    [mean, (variance / bodies as f64).sqrt()]
}

/// In a harmonic trap of k = 1 and h = 1, where ω²h²/4 = ¼: by g-BAOAB ⟨x²⟩ = kT/k, whatever the step, and ⟨p²⟩/m = kT
/// (1 − h²k/4m); with heat at the ends of a step ⟨x²⟩ = kT/(k (1 − h²k/4m)), and ⟨p²⟩/m = kT.
#[test]
fn averages_in_a_trap_are_what_theory_says() {
    const BODIES: usize = 300;
    fn mean_squares(method: impl Method) -> [[f64; 2]; 2] {
        let heat = Langevin { friction: 1.0, temperature: KT, seed: 3 };
        let scene = Scene::points(BODIES).with(Harmonic { stiffness: 1.0, centre: [0.0; 3] }).with(heat);
        let mut simulation = scene.simulate(State::of([[0.0; 3]; BODIES]), method).unwrap();
        simulation.run(30).unwrap();
        let mut sums = vec![[0.0; 2]; BODIES];
        let steps = 300;
        simulation
            .run_with(steps, |now| {
                for ((sum, q), p) in sums.iter_mut().zip(now.positions()).zip(now.momenta()) {
                    *sum = [sum[0] + q.norm_squared() / 3.0, sum[1] + p.norm_squared() / 3.0];
                }
            })
            .unwrap();
        [0, 1].map(|which| {
            let means = sums.iter().map(|sum| sum[which] / steps as f64);
            let mean = means.clone().sum::<f64>() / BODIES as f64;
            let variance = means.map(|x| (x - mean).powi(2)).sum::<f64>() / (BODIES - 1) as f64;
            [mean, (variance / BODIES as f64).sqrt()]
        })
    }
    let check = |found: [[f64; 2]; 2], exact: [f64; 2]| {
        for ([mean, sigma], exact) in found.into_iter().zip(exact) {
            assert!((mean - exact).abs() < DEVIATIONS * sigma, "{mean} ± {sigma:.1e} of {exact}");
            assert!(sigma < 0.02 * KT, "noise that hides a difference of a quarter");
        }
    };
    check(mean_squares(Baoab::new(1.0)), [KT, 0.75 * KT]);
    check(mean_squares(Rattle::new(1.0)), [KT / 0.75, KT]);
}

/// The table in the documentation of [`rattle::methods::baoab`]:
/// `cargo test --release --test effects heat::table -- --ignored --nocapture`.
#[test]
#[ignore = "some minutes"]
fn table() {
    let heat = Langevin { friction: 1.0, temperature: 0.5, seed: 3 };
    let scene = Scene::on(Sphere { r: 2.0 }).bodies(2000).with(Gravity { g: 0.5 }).with(heat);
    println!("| h | `Baoab` | `Baoab::with_inner(4, h)` | `Rattle` | noise |\n|---|---|---|---|---|");
    for h in [0.1, 0.2, 0.3] {
        let steps = (8_000.0 / h) as u64;
        let means = [
            mean_height(&scene, 2000, Baoab::new(h), steps),
            mean_height(&scene, 2000, Baoab::with_inner(4, h), steps),
            mean_height(&scene, 2000, Rattle::new(h), steps),
        ];
        let [middle, inner, ends] = means.map(|[mean, _]| format!("{:+.1e}", mean - height(0.5)));
        let noise = means.iter().fold(0.0_f64, |most, [_, sigma]| most.max(*sigma));
        println!("| {h} | {middle} | {inner} | {ends} | {noise:.0e} |");
    }
}

/// The same noise for any number of threads and neighbours, after a restart, and for another number of the trajectory
/// another: to the bit, but for rounding where an ensemble goes in lanes.
#[test]
fn noise_is_the_same_in_any_company() {
    let rounding = if InstructionSet::widest().fuses() { 1e-9 } else { 0.0 };
    same_in_any_company(Rattle::new(0.1), rounding);
    same_in_any_company(Baoab::new(0.1), rounding);
}

fn same_in_any_company<S: Method>(method: S, rounding: f64) {
    let heat = Langevin { friction: 1.0, temperature: 0.5, seed: 9 };
    let scene = Scene::on(Sphere { r: 1.0 }).with(Gravity { g: 1.0 }).with(heat);
    let start = State::at([0.0, 0.0, 1.0]);
    let run = |start: State<3>, steps| {
        let mut simulation = scene.simulate(start, method.clone()).unwrap();
        simulation.run(steps).unwrap();
        simulation.state()
    };
    let place = |state: &State<3>| state.positions().next().unwrap();
    let same = |one: &State<3>, other: &State<3>| (place(one) - place(other)).norm() <= rounding;
    let whole = run(start.clone(), 60);
    assert_eq!(place(&run(run(start.clone(), 25), 35)), place(&whole));
    assert_ne!(place(&run(start.clone().numbered(1), 60)), place(&whole));
    let mut ensemble = scene.ensemble(vec![start.clone(); 70], method.clone()).unwrap();
    ensemble.run(60);
    assert!(same(&ensemble.state(0), &whole));
    assert!(same(&ensemble.state(69), &run(start.clone().numbered(69), 60)));
    // An ensemble goes on from its own states, and one of them alone if it is numbered.
    let states: Vec<_> = (0..70).map(|i| ensemble.state(i)).collect();
    let mut again = scene.ensemble(states.clone(), method.clone()).unwrap();
    ensemble.run(10);
    again.run(10);
    assert!(same(&again.state(3), &ensemble.state(3)));
    assert!(same(&run(states[3].clone().numbered(3), 10), &ensemble.state(3)));
    let other = Langevin { seed: 10, ..heat };
    let mut other = Scene::on(Sphere { r: 1.0 })
        .with(Gravity { g: 1.0 })
        .with(other)
        .simulate(start, method.clone())
        .unwrap();
    other.run(60).unwrap();
    assert_ne!(place(&other.state()), place(&whole));
}

/// Baths that draw and that rescale: mean and variance of the kinetic energy, N kT/2 and N (kT)²/2.
#[test]
fn kinetic_energies_are_canonical() {
    fn check(heat: impl Flow<3>) {
        let gas = Scene::on(Sphere { r: 1.0 }).bodies(10).with(heat);
        let start = State::of([[0.0, 0.0, 1.0]; 10]).moving([1.0, 0.0, 0.0]);
        let mut simulation = gas.simulate(start, Rattle::new(0.05)).unwrap();
        simulation.run(50).unwrap();
        let (mut energies, steps) = (Vec::new(), 2_000);
        for _ in 0..steps {
            simulation.run(2).unwrap();
            energies.push(simulation.kinetic_energy());
        }
        let (n, freedom) = (steps as f64, 20.0);
        let mean = energies.iter().sum::<f64>() / n;
        let variance = energies.iter().map(|k| (k - mean).powi(2)).sum::<f64>() / n;
        // Correlations from one sample to the next are e⁻⁴ at most.
        let (k, spread) = (0.5 * freedom * KT, 0.5 * freedom * KT * KT);
        assert!((mean - k).abs() < DEVIATIONS * (spread / n).sqrt() * 1.05, "{mean} of {k}");
        // Of a gamma distribution of shape N/2 the fourth moment is (3 + 12/N) σ⁴.
        let of_variance = spread * ((2.0 + 12.0 / freedom) / n).sqrt();
        assert!((variance - spread).abs() < DEVIATIONS * of_variance * 1.05, "{variance} of {spread}");
    }
    check(Andersen { rate: 20.0, temperature: KT, seed: 2 });
    check(VelocityRescaling { time: 0.025, temperature: KT, seed: 2 });
    check(strong(0.05));
}

/// Heat is booked as work: on a sphere RATTLE keeps the kinetic energy of free motion, so that nothing else is left.
#[test]
fn heat_is_work() {
    let ball = Scene::on(Sphere { r: 1.0 }).with(Langevin { friction: 1.0, temperature: KT, seed: 1 });
    let mut simulation = ball.simulate(State::at([0.0, 0.0, 1.0]), Baoab::new(0.05)).unwrap();
    simulation.run(1000).unwrap();
    assert!(simulation.kinetic_energy() > 0.0 && simulation.work() > 0.0);
    assert!(simulation.energy_error().abs() < 1e-12, "{:e}", simulation.energy_error());
}

/// Bodies in a Nosé–Hoover chain, which repel each other: the energy of bodies and bath is kept to second order without
/// drift, the kinetic energy is canonical by mean and variance, and a restart goes on to the bit.
#[test]
fn a_bath_without_chance() {
    let sphere = Sphere { r: 2.0 };
    let gas = Scene::on(sphere).bodies(8).with(LennardJones { epsilon: 1.0, sigma: 0.8 });
    let places = State::of(points::apart(&sphere, [-2.0; 3], [2.0; 3], 8, 1.0, 1).unwrap());
    let start = gas.maxwell(&places, KT, 1).unwrap();
    let swing = |h: f64, time: f64| {
        let method = NoseHoover::new(KT, 0.5, h);
        let mut simulation = gas.simulate(start.clone(), method).unwrap();
        let (first, mut most, mut sums) = (simulation.energy(), [0.0_f64; 2], [0.0; 2]);
        let steps = (time / h).round() as u64;
        for part in 0..2 {
            simulation
                .run_with(steps / 2, |now| {
                    let kept = now.energy() + method.bath_energy(now.memory(), now.freedom());
                    most[part] = most[part].max((kept - first).abs());
                    let now = now.temperature();
                    sums = [sums[0] + now, sums[1] + now * now];
                })
                .unwrap();
        }
        (most, sums.map(|sum| sum / steps as f64), simulation)
    };
    let swings = [0.01, 0.005, 0.0025].map(|h| swing(h, 10.0).0[0]);
    assert!((1.7..2.3).contains(&crate::common::order(&swings)), "{swings:?}");
    let time = if cfg!(long) { 300.0 } else { 100.0 };
    let ([first, second], [mean, square], simulation) = swing(0.01, time);
    assert!(second < 1.5 * first, "no drift: {first:.1e}, {second:.1e}");
    // Kinetic energies forget within the swing of the bath, some 1: so many samples of N = 16 momenta, of which 2K/N
    // has the variance 2(kT)²/N, and the fourth moment (3 + 12/N) times its square.
    let (n, freedom, variance) = (time, 16.0_f64, square - mean * mean);
    let exact = 2.0 / freedom * KT * KT;
    assert!((mean - KT).abs() < DEVIATIONS * (exact / n).sqrt(), "{mean}");
    let of_variance = exact * ((2.0 + 12.0 / freedom) / n).sqrt();
    assert!((variance - exact).abs() < DEVIATIONS * of_variance, "{variance} of {exact}");
    let mut again = gas.simulate(simulation.state(), *simulation.method()).unwrap();
    let mut simulation = simulation;
    again.run(10).unwrap();
    simulation.run(10).unwrap();
    assert_eq!(again.state(), simulation.state());
}

/// Far hotter than its bath, in steps as long as the bath's swing: exp(−hξ) would overflow.
#[test]
fn a_bath_that_steps_do_not_resolve() {
    let start =
        State::of([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).with_momenta([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let gas = Scene::on(Sphere { r: 1.0 }).bodies(2);
    let mut simulation = gas.simulate(start.clone(), NoseHoover::new(0.01, 1.0, 1.0)).unwrap();
    let Err(rattle::Error::Step {
        cause: StepFailure::Method(MethodFailure::BathTooFast { factor, hot, .. }),
        ..
    }) = simulation.run(10)
    else {
        panic!("the bath is not followed")
    };
    assert!(!(1e-3..=1e3).contains(&factor) && hot.is_finite(), "{factor:e} {hot:e}");
    let mut simulation = gas.simulate(start, NoseHoover::new(0.01, 1.0, 0.01)).unwrap();
    simulation.run(10_000).unwrap();
}

/// ⟨(q(t) − q(0))²⟩ = 2R² (1 − exp(−2Dt/R²)) on a sphere with D = kT/γ; cos of the angle has the variance
/// (1 + 2e^{−6Dt/R²})/3 − e^{−4Dt/R²}.
#[test]
fn mean_square_displacement_on_a_sphere() {
    const BODIES: usize = 400;
    let (r, friction, temperature, h) = (2.0, 2.0, 1.0, 0.004);
    let d = temperature / friction;
    let start = State::of(vec![[0.0, 0.0, r]; BODIES]);
    let scene = Scene::on(Sphere { r }).bodies(BODIES);
    let mut simulation = scene.simulate(start, Brownian::new(friction, temperature, 1, h)).unwrap();
    for _ in 0..4 {
        simulation.run(250).unwrap();
        let fade = (-2.0 * d * simulation.time() / (r * r)).exp();
        let exact = 2.0 * r * r * (1.0 - fade);
        let mean = simulation.positions().map(|q| 2.0 * r * (r - q.z)).sum::<f64>() / BODIES as f64;
        let sigma = 2.0 * r * r * (((1.0 + 2.0 * fade.powi(3)) / 3.0 - fade * fade) / BODIES as f64).sqrt();
        // A step of the method is off by h, some 2Dh/R² of the exponent's rate.
        let by_steps = exact * 2.0 * d * h / (r * r);
        assert!((mean - exact).abs() < DEVIATIONS * sigma + by_steps, "{mean} of {exact} ± {sigma:.1e}");
    }
}

/// Brownian motion under gravity is of the density exp(−U/kT), to first order: a step of 0.02 is off by some 0.02.
#[test]
fn brownian_motion_has_the_right_density() {
    let scene = Scene::on(Sphere { r: 2.0 }).bodies(100).with(Gravity { g: 0.5 });
    let coarse = mean_height(&scene, 100, Brownian::new(1.0, 0.5, 2, 0.02), 2_000);
    let off = coarse[0] - height(0.5);
    assert!(off.abs() < DEVIATIONS * coarse[1] + 0.02, "{off:.1e} ± {:.1e}", coarse[1]);
}

/// Methods that cannot be divided say so: a bath goes on from step to step, and Brownian motion has no momenta to
/// reflect. Links that move are refused by a bath; a start from numbers goes on with the noise of then.
#[test]
fn what_cannot_be_divided_is_refused() {
    let gas = || Scene::on(Sphere { r: 1.0 }).bodies(2);
    let start = || State::of([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]).moving([1.0, 0.0, 0.0]);
    let bath = gas().simulate(start(), NoseHoover::new(KT, 0.5, 0.01)).unwrap();
    let told = bath.collide(HardSpheres::new(0.1)).unwrap_err().to_string();
    assert!(told.contains("bath"), "{told}");
    let dust = gas().simulate(start(), Brownian::new(1.0, KT, 1, 0.01)).unwrap();
    let told = dust.collide(HardSpheres::new(0.1)).unwrap_err().to_string();
    assert!(told.contains("no momenta"), "{told}");

    let heat = Langevin { friction: 1.0, temperature: KT, seed: 1 };
    let heated = Scene::on(Sphere { r: 1.0 }).with(heat);
    let mut whole = heated.simulate(State::at([0.0, 0.0, 1.0]), Rattle::new(0.01)).unwrap();
    whole.run(3).unwrap();
    let state = whole.state();
    let (q, p) = (state.positions().next().unwrap(), state.momenta().next().unwrap());
    let numbers = State::at(q).moving(p).at_time(state.time()).after_steps(state.steps());
    let mut again = heated.simulate(numbers, Rattle::new(0.01)).unwrap();
    whole.run(1).unwrap();
    again.run(1).unwrap();
    assert!((whole.position() - again.position()).norm() < 1e-15);
}

#[test]
fn what_makes_no_sense_is_refused() {
    let at_rest = || State::at([0.0, 0.0, 1.0]);
    let ball = || Scene::on(Sphere { r: 1.0 });
    let bath = |friction, temperature| Langevin { friction, temperature, seed: 0 };
    let told =
        |heat: Langevin, h| ball().with(heat).simulate(at_rest(), Rattle::new(h)).unwrap_err().to_string();
    assert_eq!(
        told(bath(-1.0, 1.0), 0.1),
        "effect `Langevin`: friction must be 0 or positive, and finite, found -1"
    );
    assert!(told(bath(1.0, f64::NAN), 0.1).contains("temperature must be"));
    assert!(told(bath(1.0, 1.0), -0.1).contains("what is random is not undone"));
    let simulation = ball().with(bath(1.0, 1.0)).simulate(at_rest(), Rattle::new(0.1)).unwrap();
    assert!(simulation.check_reversal(1e-12).unwrap_err().to_string().contains("`Langevin`"));
    // No composition of what draws random numbers.
    let composed = Composition::of(SUZUKI_1990_ORDER_4, Baoab::new(0.1));
    assert!(
        ball()
            .with(bath(1.0, 1.0))
            .simulate(at_rest(), composed)
            .unwrap_err()
            .to_string()
            .contains("symmetric")
    );
}

/// What links that move impose on bodies is no heat: on a plane that is lifted by 3 in a unit of time, of masses 1 and
/// 2, the temperature is that of momenta along the plane, and baths hold them at it.
#[test]
fn bodies_that_are_carried_are_not_hot() {
    constraint! {
        /// A plane on its way up.
        struct Lift { v }
        |_x, _y, z, t| z - v * t
    }
    const N: usize = 20;
    const V: f64 = 3.0;
    fn check(heat: impl Flow<3>) {
        let mass = |i: usize| 1.0 + (i % 2) as f64;
        let scene = Scene::points::<3>(N)
            .masses((0..N).map(mass))
            .link_moving(Lift { v: V }, (0..N).map(|i| [i]))
            .with(heat);
        let at = State::of([[0.0; 3]; N]);
        let carried = at.clone().with_momenta((0..N).map(|i| [0.0, 0.0, mass(i) * V]));
        let still = scene.simulate(carried, Rattle::new(0.05)).unwrap();
        assert!(still.temperature().abs() < 1e-13 && still.kinetic_energy() > 100.0);
        let start = at.with_momenta((0..N).map(|i| [1.0, 0.0, mass(i) * V]));
        let mut simulation = scene.simulate(start, Rattle::new(0.05)).unwrap();
        assert_eq!(simulation.freedom(), 2 * N);
        simulation.run(40).unwrap();
        let (mut sum, steps) = (0.0, 200);
        for _ in 0..steps {
            simulation.run(2).unwrap(); // correlations are e⁻⁴ at most
            sum += simulation.temperature();
        }
        let (mean, sigma) = (sum / f64::from(steps), KT * (1.0 / (N as f64 * f64::from(steps))).sqrt());
        assert!((mean - KT).abs() < DEVIATIONS * 1.05 * sigma, "{mean} of {KT} ± {sigma:.1e}");
        assert!(simulation.momenta().enumerate().all(|(i, p)| (p.z - mass(i) * V).abs() < 1e-13));
    }
    check(VelocityRescaling { time: 0.025, temperature: KT, seed: 2 });
    check(strong(0.05));
    check(Andersen { rate: 20.0, temperature: KT, seed: 2 });
}
