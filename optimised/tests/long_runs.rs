//! Long runs: rounding in the energy grows like √n, and no faster; the shadow energy stays where it is. Short versions
//! run always; the long ones by name:
//!
//! ```text
//! cargo long --test motion long_runs:: -- --ignored --nocapture
//! STEPS=10000 cargo long --test motion long_runs::soak -- --ignored --nocapture      10⁴ trajectories; 10⁶ steps each if nothing is said
//! ```

use crate::common::*;
use rattle::composition::{KAHAN_LI_1997_ORDER_8, SUZUKI_1990_ORDER_4, YOSHIDA_1990_ORDER_4};
use rattle::ensemble::{Compensated, Ensemble};
use rattle::guess::{FromState, Guess};
use rattle::iteration::Iteration;
use rattle::nalgebra::{Rotation3, Vector3};
use rattle::prelude::*;
use rattle::table::{Table, Tabulated};

/// Energy errors of spherical pendulums after so many steps of RATTLE, 17 in each of a composition whose own error is
/// below rounding: the root of their mean square, after each of `counts` macro steps.
fn growth<S: Method>(method: &S, counts: &[u64]) -> Vec<f64> {
    let scene = Scene::on(Sphere { r: 1.0 }).with(Gravity { g: 1.0 });
    let mut squares = vec![0.0; counts.len()];
    for speed in [1.1, 1.2, 1.3, 1.4, 1.5, 1.6] {
        let (sin, cos) = std::f64::consts::FRAC_PI_3.sin_cos();
        let start = scene.project(&State::at([sin, 0.0, -cos]).moving([0.0, speed, 0.01])).unwrap();
        let mut simulation = scene.simulate(start, method.clone()).unwrap();
        for (square, &count) in squares.iter_mut().zip(counts) {
            simulation.run(count - simulation.steps()).unwrap();
            *square += simulation.energy_error().powi(2) / 6.0;
        }
    }
    squares.into_iter().map(f64::sqrt).collect()
}

fn check_growth<G: Guess, X: Iteration>(guess: G, by: X, counts: &[u64]) {
    let method = Rattle::new(0.025).guess(guess).solved_by(by);
    let method = Composition::of(KAHAN_LI_1997_ORDER_8, method);
    for (&count, error) in counts.iter().zip(growth(&method, counts)) {
        let steps = 17.0 * count as f64;
        println!("{steps:9.1e} steps: {error:.1e}, that is {:.1e} √n", error / steps.sqrt());
        // 1e-17 √n, and the rounding of the energy itself: |z| and p²/2 up to 2, both at the start and now.
        assert!(error <= 1e-17 * steps.sqrt() + 4.0 * f64::EPSILON, "{steps} steps: {error:e}");
    }
}

#[test]
#[cfg(long)]
fn rounding_grows_like_the_root_of_the_steps() {
    check_growth(FromState, Newton, &[1_000, 10_000, 60_000]);
}

/// What a linear iteration leaves has one sign, and would add up like n.
#[test]
#[cfg(long)]
fn so_it_does_however_the_position_equation_is_solved() {
    check_growth(FromState, Symmetric, &[1_000, 60_000]);
    check_growth(FromState, Simplified, &[1_000, 60_000]);
    check_growth(FromState, Broyden, &[1_000, 60_000]);
    check_growth(LastMultiplier, Newton, &[1_000, 60_000]);
    check_growth(LastMultiplier, Simplified, &[1_000, 60_000]);
    check_growth(Extrapolated, Broyden, &[1_000, 60_000]);
}

#[test]
#[cfg(long)]
#[ignore = "a minute: 1e8 steps of six pendulums"]
fn rounding_grows_like_the_root_of_1e8_steps() {
    check_growth(FromState, Newton, &[60_000, 600_000, 6_000_000]);
}

/// The largest energy error of the plane pendulum in so many steps of 0.01.
fn swing(steps: u64) -> f64 {
    let scene = Scene::on(Pendulum { length: 1.0 }).with(PlanarGravity { g: 1.0 });
    let mut simulation = scene.simulate(State::at([1.0, 0.0]), Rattle::new(0.01)).unwrap();
    let mut largest = 0.0_f64;
    simulation.run_with(steps, |now| largest = largest.max(now.energy_error().abs())).unwrap();
    largest
}

#[test]
fn the_swing_of_the_energy_is_the_same_after_1e6_steps() {
    let (early, late) = (swing(10_000), swing(1_000_000));
    println!("{early:e} {late:e}");
    assert!((late - early).abs() <= 1e-4 * early, "{early:e}, then {late:e}"); // which phases are seen
}

#[test]
#[cfg(long)]
#[ignore = "half a minute"]
fn the_swing_of_the_energy_is_the_same_after_1e8_steps() {
    let (early, late) = (swing(1_000_000), swing(100_000_000));
    println!("{early:e} {late:e}");
    assert!((late - early).abs() <= 1e-6 * early, "{early:e}, then {late:e}");
}

/// Mean and spread of the shadow energy in four quarters of a run that starts so far beside 45°.
fn shadow(steps: u64, beside: f64) -> [(f64, f64); 4] {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let start = billiard(std::f64::consts::FRAC_PI_4 + beside);
    let mut simulation = scene.simulate(start, Rattle::new(0.01)).unwrap();
    let every = 50;
    [(); 4].map(|()| {
        let (mut sum, mut least, mut most) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
        let samples = steps / 4 / every;
        for _ in 0..samples {
            simulation.run(every).unwrap();
            let energy = simulation.shadow_energy();
            sum += energy;
            (least, most) = (least.min(energy), most.max(energy));
        }
        (sum / samples as f64, most - least)
    })
}

/// The motion is chaotic, and passes over the sharpest ends are rare: they make the spread, and their sum walks. So the
/// drift of one run is luck; of 24 at 1e5 steps the largest is 1.5e-8 per unit of time, and the root of the mean square
/// 7e-9. Solved to |g| < 1e-6 instead of to rounding it drifts by 1e-6 and more.
fn check_shadow(steps: u64) {
    let (mut square, runs) = (0.0, 8);
    for run in 0..runs {
        let quarters = shadow(steps, 1e-12 * f64::from(run));
        let spread = quarters.iter().fold(0.0_f64, |most, quarter| most.max(quarter.1));
        let drift = (quarters[3].0 - quarters[0].0).abs();
        let rate = drift / (0.75 * 0.01 * steps as f64) / quarters[0].0;
        println!("spread {spread:.1e}, drift per time {rate:.1e}");
        assert!(spread < 1e-3, "{spread:e}");
        square += rate * rate / f64::from(runs);
    }
    assert!(square.sqrt() < 1.5e-8, "{:e}", square.sqrt());
}

#[test]
fn shadow_energy_stays_over_1e5_steps() {
    check_shadow(100_000);
}

#[test]
#[cfg(long)]
#[ignore = "seconds: 1e6 steps"]
fn shadow_energy_stays_over_1e6_steps() {
    check_shadow(1_000_000);
}

/// The slope of the energy of a plane pendulum, relative and per step, by Lobatto's methods.
fn drift<const S: usize>(link: bool, h: f64, extrapolated: bool, steps: u64) -> f64
where
    Table<S>: Tabulated,
{
    fn of<Y: rattle::system::System<f64, 2>, M: Method>(
        mut simulation: Simulation<Y, M, 2>,
        steps: u64,
    ) -> f64 {
        let (start, half) = (simulation.energy().abs(), 0.5 * steps as f64);
        let (mut n, mut sums) = (0.0, [0.0; 4]);
        let fit = |now: &Simulation<Y, M, 2>| {
            n += 1.0;
            let (x, y) = ((n - half) / half, now.energy_error() / start);
            sums = [sums[0] + x, sums[1] + y, sums[2] + x * y, sums[3] + x * x];
        };
        simulation.run_with(steps, fit).unwrap();
        let [x, y, xy, xx] = sums;
        (xy - x * y / n) / (xx - x * x / n) / half
    }
    let method = Lobatto::<S>::new(h);
    let (rod, weight) = (Pendulum { length: 1.0 }, PlanarGravity { g: 1.0 });
    let (at, p) = ([0.0, -1.0], [1.0, 0.0]);
    match (link, extrapolated) {
        (false, false) => {
            of(Scene::on(rod).with(weight).simulate(State::at(at).moving(p), method).unwrap(), steps)
        }
        (false, true) => {
            let scene = Scene::on(rod).with(weight);
            of(scene.simulate(State::at(at).moving(p), method.guess(Extrapolated)).unwrap(), steps)
        }
        (true, _) => {
            let scene = Scene::points(2).link(rattle::links::planar::Rod { length: 1.0 }, [[0, 1]]);
            let scene = scene.pin(0, [0.0; 2]).with(weight);
            let start = State::of([[0.0; 2], at]).with_momenta([[0.0; 2], p]);
            of(scene.simulate(start, method).unwrap(), steps)
        }
    }
}

/// What a solve for the stages leaves, and what rounding takes from coefficients, has one sign and adds up like n.
fn check_drift<const S: usize>(steps: u64, bound: f64)
where
    Table<S>: Tabulated,
{
    let slopes = [
        drift::<S>(false, 1.0 / 64.0, false, steps),
        drift::<S>(false, 1.0 / 16.0, true, steps),
        drift::<S>(true, 1.0 / 64.0, false, steps),
    ];
    println!("{S} stages: {slopes:?} of the energy each step");
    for (slope, what) in slopes.into_iter().zip(["surface", "surface, long steps", "link"]) {
        assert!(slope.abs() <= bound, "{S} stages, {what}: {slope:e}");
    }
}

/// Random roundings of 1e-17 leave 2e-17/n^{3/2}·n = 4e-20 of a slope in 2.5e5 steps.
#[test]
#[cfg(long)]
fn energy_does_not_drift_by_collocation() {
    check_drift::<5>(250_000, 1.5e-19);
    check_drift::<7>(250_000, 1.5e-19);
}

/// The mean slope of the energy of 24 pendulums that swing wide, each step.
fn drift_of_many<const S: usize>(h: f64, steps: u64) -> f64
where
    Table<S>: Tabulated,
{
    let scene = Scene::on(Pendulum { length: 1.0 }).with(PlanarGravity { g: 1.0 });
    let slope = |i: u32| {
        let angle = 0.9 + 0.05 * f64::from(i);
        let start = State::at([angle.sin(), -angle.cos()]);
        let mut simulation = scene.simulate(start, Lobatto::<S>::new(h)).unwrap();
        simulation.run(steps).unwrap();
        simulation.energy_error() / steps as f64
    };
    (0..24).map(slope).sum::<f64>() / 24.0
}

/// Random roundings leave 2e-20 of a mean. What rounding takes from weights, lost in the sums that it is added to one
/// by one, leaves up to 2.5e-19, another slope for each number of stages and each step. At h = 0.1 the stages end a
/// little before they hold to rounding, which leaves 2e-19; what rounding takes from the sum of drift and bend would
/// leave 5.9e-19.
#[test]
#[cfg(long)]
fn energy_does_not_drift_by_the_rounding_of_weights() {
    for (h, bound) in [(0.05, 1e-19), (0.07, 1e-19), (0.1, 3e-19)] {
        let slopes = [drift_of_many::<8>(h, 16_000), drift_of_many::<9>(h, 16_000)];
        println!("8 and 9 stages, h = {h}: {slopes:?} each step");
        assert!(slopes.iter().all(|slope| slope.abs() <= bound), "h = {h}: {slopes:?}");
    }
}

/// The mean of 64 energies, before so many steps and after them.
fn mean_energies<const D: usize>(
    mut ensemble: Ensemble<D>,
    steps: u64,
    energy: impl Fn(&State<D>) -> f64,
) -> [f64; 2] {
    let mean = |ensemble: &Ensemble<D>| ensemble.states().map(|state| energy(&state)).sum::<f64>() / 64.0;
    let before = mean(&ensemble);
    ensemble.run(steps);
    assert_eq!(ensemble.failures().count(), 0);
    [before, mean(&ensemble)]
}

/// The mean of 64 pendulums. Rounding of the energies at both ends leaves 1e-22 of a slope, random roundings of 1e-17
/// in each step 5e-21; rounded coefficients would leave 7e-20.
#[test]
#[cfg(long)]
fn energy_does_not_drift_by_collocation_in_lanes() {
    let scene = Scene::on(Pendulum { length: 1.0 }).with(PlanarGravity { g: 1.0 });
    let start = |i: u32| {
        let angle = 0.3 + 1.5 * f64::from(i) / 64.0;
        State::at([angle.sin(), -angle.cos()])
    };
    let method = Lobatto::<5>::new(0.03);
    let ensemble = scene.ensemble_in(Compensated, (0..64).map(start), method).unwrap();
    let [before, after] = mean_energies(ensemble, 200_000, |state| {
        0.5 * state.momenta().next().unwrap().norm_squared() + state.positions().next().unwrap().y
    });
    let slope = (after - before) / 2e5;
    println!("in lanes: {slope:.1e} each step");
    assert!(slope.abs() <= 2e-20, "{slope:e}");
}

/// The same of great circles by compositions, which keep their energy exactly: all of it is rounding. It was 2e-18 and
/// more where the normal at the end of a stage was that before its last correction.
#[test]
#[cfg(long)]
fn energy_does_not_drift_by_compositions_in_lanes() {
    let (scene, r) = (Scene::on(Sphere { r: 1.3 }), 1.3);
    for (coefficients, h) in
        [(SUZUKI_1990_ORDER_4, 0.05), (SUZUKI_1990_ORDER_4, 0.1), (YOSHIDA_1990_ORDER_4, 0.02)]
    {
        let start = |i: u32| {
            let (angle, v) = (0.37 * f64::from(i), 0.7 + 0.011 * f64::from(i));
            let (sin, cos) = angle.sin_cos();
            State::at([r * cos, r * sin, 0.0]).moving([-0.6 * v * sin, 0.6 * v * cos, 0.8 * v])
        };
        let starts = (0..64).map(|i| scene.project(&start(i)).unwrap());
        let method = Composition::new(coefficients, h);
        let ensemble = scene.ensemble_in(Compensated, starts, method).unwrap();
        let kinetic = |state: &State<3>| 0.5 * state.momenta().next().unwrap().norm_squared();
        let [before, after] = mean_energies(ensemble, 20_000, kinetic);
        let slope = (after - before) / before / (2e4 * coefficients.gammas.len() as f64);
        println!("{}, h = {h}: {slope:.1e} each stage", coefficients.name);
        assert!(slope.abs() <= 5e-20, "{}, h = {h}: {slope:e}", coefficients.name);
    }
}

/// The same of double pendulums that swing a little, by a composition whose own error is below rounding.
#[test]
#[cfg(long)]
fn energy_does_not_drift_of_links_in_lanes() {
    let scene = Scene::points(3)
        .link(rattle::links::planar::Rod { length: 1.0 }, [[0, 1], [1, 2]])
        .pin(0, [0.0, 0.0])
        .with(PlanarGravity { g: 1.0 });
    let start = |i: u32| {
        let (a, b) = (0.1 + 0.5 * f64::from(i) / 64.0, 0.4 - 0.6 * f64::from(i) / 64.0);
        let first = [a.sin(), -a.cos()];
        State::of([[0.0, 0.0], first, [first[0] + b.sin(), first[1] - b.cos()]])
    };
    let method = Composition::new(KAHAN_LI_1997_ORDER_8, 0.05);
    let ensemble = scene.ensemble_in(Compensated, (0..64).map(start), method).unwrap();
    let [before, after] = mean_energies(ensemble, 50_000, |state| {
        let kinetic = state.momenta().map(|p| 0.5 * p.norm_squared()).sum::<f64>();
        kinetic + state.positions().map(|q| q.y).sum::<f64>()
    });
    let slope = (after - before) / (5e4 * 17.0);
    println!("links in lanes: {slope:.1e} each stage");
    assert!(slope.abs() <= 1e-19, "{slope:e}");
}

potential! {
    /// A weight, and a field that knows all three axes.
    struct Field { weight, pull }
    |q: [[f64; 3]; 3]| weight * q[2][2] + pull * (q[0][1]^2 + q[1][0] / 3)
}

/// The slope of the mean energy of 64 rigid bodies, relative to it and per stage.
fn spinning(moments: [f64; 3], heavy: bool, steps: u64) -> f64 {
    let (weight, pull) = (0.3, 0.2);
    let start = |i: u32| {
        let i = f64::from(i);
        let attitude = Rotation3::from_euler_angles(0.3 + 0.1 * i, 0.5 - 0.07 * i, 0.2 * i);
        let rate = Vector3::new((1.0 + i).sin(), (2.0 * i + 0.5).cos(), (0.7 * i + 0.3).sin());
        Rigid::start(attitude.matrix(), &(0.7 * rate.component_mul(&Vector3::from(moments))))
    };
    let energy = |state: &State<9>| {
        let (q, p) = (state.positions().next().unwrap(), state.momenta().next().unwrap());
        let field = if heavy { weight * q[8] + pull * (q[1] * q[1] + q[3] / 3.0) } else { 0.0 };
        (0..3).map(|i| 0.5 * p[i] * p[i] / moments[i]).sum::<f64>() + field
    };
    let (free, starts) = (Scene::rigid(Rigid::new(moments)), (0..64).map(start));
    let (ensemble, stages) = if heavy {
        let scene = free.with(Field { weight, pull });
        let method = Composition::new(KAHAN_LI_1997_ORDER_8, 0.05);
        (scene.ensemble_in(Compensated, starts, method).unwrap(), 17)
    } else {
        (free.ensemble_in(Compensated, starts, Rattle::new(0.05)).unwrap(), 1)
    };
    let [before, after] = mean_energies(ensemble, steps, energy);
    (after - before) / before.abs() / (steps * stages) as f64
}

/// The same of rigid bodies: free, when RATTLE keeps their energy, and by a composition whose own error is below
/// rounding. Numbers of the moments of inertia that are rounded leave 1e-18 where steps are longer.
fn check_spinning(steps: u64) {
    for moments in [[0.6, 0.8, 1.0], [1.0, 1.0, 0.4], [1.0, 2.0, 2.9], [1.0, 1.0, 1e-3]] {
        let heavy = if moments[2] < 0.1 { 0.0 } else { spinning(moments, true, steps / 17) };
        let slopes = [spinning(moments, false, steps), heavy];
        println!("{moments:?}: {slopes:?} each stage");
        assert!(slopes.iter().all(|slope| slope.abs() <= 1e-19), "{moments:?}: {slopes:?}");
    }
}

#[test]
#[cfg(long)]
fn energy_does_not_drift_of_rigid_bodies_in_lanes() {
    check_spinning(100_000);
}

#[test]
#[cfg(long)]
#[ignore = "ten seconds"]
fn energy_does_not_drift_in_1e6_steps_of_rigid_bodies_in_lanes() {
    check_spinning(1_000_000);
}

#[test]
#[cfg(long)]
#[ignore = "a minute"]
fn energy_does_not_drift_in_1e6_steps_by_collocation() {
    let slope = drift::<3>(false, 1.0 / 64.0, false, 1_000_000);
    println!("3 stages: {slope:.1e} of the energy each step"); // in longer steps its own error swings too far
    assert!(slope.abs() <= 1e-19, "{slope:e}");
    check_drift::<4>(1_000_000, 1e-19);
    check_drift::<5>(1_000_000, 1e-19);
    check_drift::<6>(1_000_000, 1e-19);
    check_drift::<7>(1_000_000, 1e-19);
    check_drift::<8>(1_000_000, 1e-19);
    check_drift::<9>(1_000_000, 1e-19);
}

constraint! {
    /// A rigid connection in space.
    struct Bar { length }
    |a: [f64; 3], b: [f64; 3]| (a[0] - b[0])^2 + (a[1] - b[1])^2 + (a[2] - b[2])^2 - length^2
}

/// The slope of the energy of a bar that turns freely about its end, relative and per step. The method keeps that
/// energy but for rounding.
fn turning<M: Method>(mass: f64, algebra: LinearAlgebra, method: M, steps: u64) -> f64 {
    let scene = Scene::points(2).masses([1.0, mass]).link(Bar { length: 1.0 }, [[0, 1]]).pin(0, [0.0; 3]);
    let scene = scene.linear_algebra(algebra);
    let start =
        State::of([[0.0; 3], [0.48, 0.6, 0.64]]).with_momenta([[0.0; 3], [0.8 * mass, 0.1, -0.6 * mass]]);
    let mut simulation = scene.simulate(scene.project(&start).unwrap(), method).unwrap();
    let (half, mut sums, energy) = (50.0, [0.0; 2], simulation.energy());
    for sample in 1..100 {
        simulation.run(steps / 100).unwrap();
        let x = f64::from(sample) - half;
        sums = [sums[0] + x * simulation.energy_error() / energy, sums[1] + x * x];
    }
    sums[0] / sums[1] / (steps as f64 / 100.0)
}

/// 1/h and 1/m that are rounded are as wrong in every step: the energy would grow by 2e-19 to 8e-19 of itself each
/// step.
#[test]
#[cfg(long)]
fn steps_and_masses_that_are_no_powers_of_two_do_not_make_energy_drift() {
    for algebra in [LinearAlgebra::Elimination, LinearAlgebra::Orthogonal] {
        for (mass, h) in [(3.0, 0.05), (0.7, 0.05), (0.7, 0.07)] {
            let slopes = [
                turning(mass, algebra, Rattle::new(h), 200_000),
                turning(mass, algebra, Rattle::new(h).guess(Extrapolated).solved_by(Broyden), 200_000),
            ];
            println!("{algebra:?}, m = {mass}, h = {h}: {slopes:?} of the energy each step");
            assert!(
                slopes.iter().all(|slope| slope.abs() <= 1.2e-19),
                "{algebra:?}, {mass}, {h}: {slopes:?}"
            );
        }
    }
}

/// The same of 128 dumbbells side by side in one simulation, which turn about their centres at rest. Random roundings
/// of 3e-16 in each step of each leave 3e-20 of a slope; 1/h that is rounded leaves 1.4e-19.
#[test]
#[cfg(long)]
fn energy_does_not_drift_of_molecules() {
    let (n, steps) = (128, 1_000_000);
    let places = (0..n).flat_map(|i| {
        let angle = 0.1 * f64::from(i);
        [[3.0, 0.0, angle], [3.0 + angle.sin(), angle.cos(), angle]]
    });
    let momenta = (1..=n).flat_map(|i| {
        let p = [0.3, 1.7, 2.9].map(|speed| (speed * f64::from(i)).sin());
        [p, p.map(|p| -p)]
    });
    let scene = Scene::points(2 * n as usize)
        .link(Bar { length: 1.0 }, (0..n as usize).map(|i| [2 * i, 2 * i + 1]))
        .masses((0..2 * n).map(|i| 1.0 + 0.013 * f64::from(i)));
    let start = scene.project(&State::of(places).with_momenta(momenta)).unwrap();
    let mut simulation = scene.simulate(start, Rattle::new(0.06)).unwrap();
    let energy = simulation.energy();
    simulation.run(steps).unwrap();
    let slope = simulation.energy_error() / energy / steps as f64;
    println!("molecules: {slope:.1e} of the energy each step");
    assert!(slope.abs() <= 7e-20, "{slope:e}");
    let q: Vec<_> = simulation.positions().collect();
    let off = q.chunks(2).map(|q| ((q[0] - q[1]).norm() - 1.0).abs()).fold(0.0, f64::max);
    assert!(off <= 64.0 * f64::EPSILON, "{off:e}"); // of coordinates up to 13
}

/// What an ensemble of billiards with weight is like: the mean of the energies' changes and its standard error, the
/// largest distance from the surface, and the largest ∇g·p/|p|.
struct Health {
    change: f64,
    error: f64,
    off: f64,
    along: f64,
}

fn health(ensemble: &Ensemble<3>, energies: &[f64]) -> Health {
    let (n, mut sum, mut squares, mut off, mut along) = (energies.len() as f64, 0.0, 0.0, 0.0_f64, 0.0_f64);
    for (state, start) in ensemble.states().zip(energies) {
        let change = energy(&state) - start;
        (sum, squares) = (sum + change, squares + change * change);
        let (q, p) = (state.positions().next().unwrap(), state.momenta().next().unwrap());
        let (g, gradient) = SURFACE.value_and_jacobian(&q);
        off = off.max(g[0].abs() / gradient.norm());
        along = along.max((gradient * p)[0].abs() / p.norm());
        assert!(g[0].is_finite() && p.norm().is_finite(), "{state:?}");
    }
    let (change, mean_square) = (sum / n, squares / n);
    Health { change, error: ((mean_square - change * change) / n).sqrt(), off, along }
}

fn energy(state: &State<3>) -> f64 {
    let (q, p) = (state.positions().next().unwrap(), state.momenta().next().unwrap());
    0.5 * p.norm_squared() + q.z
}

/// Trajectories of so many steps; told of in ten parts.
fn check_soak(trajectories: u32, steps: u64) {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let starts: Vec<_> = (0..trajectories).map(|i| billiard(0.001 + 0.0006 * f64::from(i))).collect();
    let energies: Vec<_> = starts.iter().map(energy).collect();
    let mut ensemble = scene.ensemble(starts, Rattle::new(0.01)).unwrap();
    let parts = [(); 10].map(|()| {
        ensemble.run(steps / 10);
        if let Some((trajectory, error)) = ensemble.failures().next() {
            panic!("trajectory {trajectory}: {error}");
        }
        let part = health(&ensemble, &energies);
        let Health { change, error, off, along } = part;
        let all = f64::from(trajectories) * ensemble.steps() as f64;
        println!("{all:.1e} steps: energy {change:+.2e} ± {error:.0e}, {off:.1e} off the surface, ∇g·p/|p| = {along:.1e}");
        // Coordinates are below 1.1, each rounded by at most ε/2; the solve leaves a sixteenth of that, and g here is a
        // sum of terms of up to 1 with |∇g| from 1/6 on. Normals are sums of terms of up to 8. In each a few roundings
        // are left, at the worst of so many places.
        assert!(off <= 8.0 * f64::EPSILON && along <= 64.0 * f64::EPSILON, "{off:e}, {along:e}");
        part
    });
    // The energy swings with the place, by the square of the step, so that its mean is not that of the start; but it
    // stays there: five standard errors, of which one is met in two million such runs.
    let mean = |parts: &[Health]| {
        let n = parts.len() as f64;
        let squares: f64 = parts.iter().map(|part| part.error * part.error).sum();
        (parts.iter().map(|part| part.change).sum::<f64>() / n, squares / (n * n))
    };
    let ((early, of_early), (late, of_late)) = (mean(&parts[..5]), mean(&parts[5..]));
    let (drift, error) = (late - early, (of_early + of_late).sqrt());
    println!("energy: {drift:+.1e} ± {error:.0e} from the first half to the second");
    assert!(drift.abs() <= 5.0 * error, "{drift:e} ± {error:e}");
}

#[test]
#[cfg(long)]
fn ensembles_stay_healthy() {
    check_soak(200, 100_000);
}

#[test]
#[cfg(long)]
#[ignore = "a minute on two cores: 1e10 steps"]
fn soak() {
    let steps = std::env::var("STEPS").map_or(1_000_000, |steps| steps.parse().expect("a number of steps"));
    check_soak(10_000, steps);
}
