//! The density of places in heat: area in the metric of the masses, of linked bodies, of masses that differ by
//! direction, and on surfaces whose ∇g is not everywhere as long. Each mean is compared with those of other densities
//! too, from which it must differ by as much as it may differ from its own.

use crate::common::statistics::DEVIATIONS;
use rattle::effect::Langevin;
use rattle::links::planar::{Pendulum, Rod};
use rattle::prelude::*;
use std::f64::consts::TAU;

const HEAT: Langevin = Langevin { friction: 1.0, temperature: 1.0, seed: 3 };

/// The mean of f over trajectories and so many samples of each, and its deviation: samples of one trajectory depend on
/// each other, those of different ones do not.
fn mean<const D: usize>(
    ensemble: &mut Ensemble<D>,
    samples: u64,
    every: u64,
    f: impl Fn(&State<D>) -> f64,
) -> [f64; 2] {
    let mut sums = vec![0.0; ensemble.len()];
    for _ in 0..samples {
        ensemble.run(every);
        sums.iter_mut().zip(ensemble.states()).for_each(|(sum, state)| *sum += f(&state));
    }
    assert!(ensemble.failures().next().is_none(), "{:?}", ensemble.failures().next());
    let (n, means) = (sums.len() as f64, sums.iter().map(|sum| sum / samples as f64));
    let mean = means.clone().sum::<f64>() / n;
    let variance = means.map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
    [mean, (variance / n).sqrt()]
}

/// The mean is what it should be, and not what others would be: but for chance, and for `steps`, the square of the
/// curvature times the way of a step, (κh)²kT/m or 2Dhκ².
fn is_of([mean, sigma]: [f64; 2], right: f64, others: &[f64], steps: f64) {
    let off = |other: f64| (mean - other).abs() / (DEVIATIONS * sigma + steps);
    assert!(off(right) < 1.0, "{mean} ± {sigma} of {right}");
    assert!(others.iter().all(|&other| off(other) > 1.0), "{mean} ± {sigma}: {right} or {others:?}");
}

/// The mean of f over an angle with this density.
fn over_angles(density: impl Fn(f64) -> f64, f: impl Fn(f64) -> f64) -> f64 {
    let angles = (0..500).map(|i| TAU * f64::from(i) / 500.0); // periodic: to rounding
    let sums = angles.fold([0.0; 2], |[sum, all], x| [sum + density(x) * f(x), all + density(x)]);
    sums[0] / sums[1]
}

/// The angle θ between two rods in a plane, with a light body between two others: the kinetic energy of the angles has
/// the determinant (m₀ + m₁)(m₁ + m₂) − m₀m₂ cos²θ, but for a factor. Others are that of equal masses, and all angles
/// alike, as without rods.
fn angles_between_rods(method: impl Method, settle: u64, [samples, every]: [u64; 2], steps: f64) {
    let (light, number) = (0.3, if cfg!(long) { 1024 } else { 512 });
    let scene = Scene::points::<2>(3).link(Rod { length: 1.0 }, [[0, 1], [1, 2]]).masses([1.0, light, 1.0]);
    let start = |i: u32| {
        let angle = TAU * f64::from(i) / 512.0;
        State::of([[-1.0, 0.0], [0.0; 2], [angle.cos(), angle.sin()]])
    };
    let of = |a: f64| over_angles(|x| (a * a - x.cos().powi(2)).sqrt(), |x| (2.0 * x).cos());
    let twice = |state: &State<2>| {
        let q: Vec<_> = state.positions().collect();
        2.0 * (q[1] - q[0]).dot(&(q[2] - q[1])).powi(2) - 1.0
    };
    let found = if method.name() == "Brownian motion" {
        let mut ensemble = scene.ensemble((0..number).map(start), method).unwrap();
        ensemble.run(settle);
        mean(&mut ensemble, samples, every, twice)
    } else {
        let mut ensemble = scene.with(HEAT).ensemble((0..number).map(start), method).unwrap();
        ensemble.run(settle);
        mean(&mut ensemble, samples, every, twice)
    };
    is_of(found, of(1.0 + light), &[of(2.0), 0.0], steps);
}

#[test]
fn angles_between_rods_in_heat() {
    angles_between_rods(Baoab::new(0.05), 60, [40, 4], 0.008);
}

#[test]
fn angles_between_rods_without_inertia() {
    angles_between_rods(Brownian::new(1.0, 1.0, 5, 1e-3), 400, [40, 15], 0.007);
}

/// A bead on a circle whose mass differs by direction: dq = (−sin φ, cos φ) dφ has the length √(m₁ sin²φ + m₂ cos²φ).
/// And one whose mass is a matrix with these axes, turned by 45°.
#[test]
fn a_bead_whose_mass_differs_by_direction() {
    let ring = || Scene::points::<2>(1).link(Pendulum { length: 1.0, pivot: [0.0; 2] }, [[0]]);
    let start = |i: u32| {
        let angle = TAU * f64::from(i) / 512.0;
        State::at([angle.cos(), angle.sin()])
    };
    let place = |state: &State<2>| state.positions().next().unwrap();
    let twice = |state: &State<2>| 2.0 * place(state).x.powi(2) - 1.0;
    let right = over_angles(|x| (x.sin().powi(2) + 4.0 * x.cos().powi(2)).sqrt(), |x| (2.0 * x).cos());

    let scene = ring().mass([1.0, 4.0]);
    let mut hot = scene.clone().with(HEAT).ensemble((0..512).map(start), Baoab::new(0.05)).unwrap();
    hot.run(60);
    is_of(mean(&mut hot, 40, 5, twice), right, &[0.0, -right], 0.003);
    let mut slow = scene.ensemble((0..512).map(start), Brownian::new(1.0, 1.0, 5, 0.01)).unwrap();
    slow.run(200);
    is_of(mean(&mut slow, 40, 10, twice), right, &[0.0, -right], 0.02);

    let matrix = rattle::nalgebra::matrix![2.5, -1.5; -1.5, 2.5]; // 1 along (1, 1), 4 along (1, −1)
    let scene = ring().mass(matrix);
    let turned = |state: &State<2>| 2.0 * place(state).x * place(state).y;
    let mut hot = scene.with(HEAT).ensemble((0..512).map(start), Baoab::new(0.05)).unwrap();
    hot.run(60);
    is_of(mean(&mut hot, 40, 5, turned), right, &[0.0, -right], 0.003);
}

constraint! {
    /// A torus by a function that is steeper where x is large: |∇g| = 2 r eˣ.
    struct Uneven { major, minor }
    |x, y, z| exp(x) * ((sqrt(x^2 + y^2) - major)^2 + z^2 - minor^2)
}

/// On a torus, whose area is dA = (R + r cos θ) r dθ dφ: ⟨cos θ⟩ = r/2R and ⟨cos φ⟩ = 0. Other densities are those of
/// the angles alone, of δ(g) dq, which is dA/|∇g|, and of its opposite.
#[test]
fn area_whatever_the_equation() {
    let surface = Uneven { major: 1.0, minor: 0.5 };
    let start = |i: u32| {
        let (theta, phi) = (0.618_034 * TAU * f64::from(i), TAU * f64::from(i) / 512.0);
        let out = 1.0 + 0.5 * theta.cos();
        State::at([out * phi.cos(), out * phi.sin(), 0.5 * theta.sin()])
    };
    let across = |state: &State<3>| {
        let q = state.positions().next().unwrap();
        (q.x.hypot(q.y) - 1.0) / 0.5
    };
    let around = |state: &State<3>| {
        let q = state.positions().next().unwrap();
        q.x / q.x.hypot(q.y)
    };
    // ⟨cos φ⟩ of dA/|∇g|, with e^{−x} in the place of 1/|∇g|.
    let out = |theta: f64| 1.0 + 0.5 * theta.cos();
    let whole = |theta: f64| over_angles(|_| 1.0, |phi| out(theta) * (-out(theta) * phi.cos()).exp());
    let steep = over_angles(whole, |theta| over_angles(|phi| (-out(theta) * phi.cos()).exp(), f64::cos));
    let scene = Scene::on(surface);
    let mut hot = scene.with(HEAT).ensemble((0..512).map(start), Baoab::new(0.05)).unwrap();
    hot.run(60);
    is_of(mean(&mut hot, 20, 5, across), 0.25, &[0.0], 0.01);
    is_of(mean(&mut hot, 20, 5, around), 0.0, &[steep, -steep], 0.01);
    let mut slow = scene.ensemble((0..512).map(start), Brownian::new(1.0, 1.0, 5, 0.002)).unwrap();
    slow.run(500);
    is_of(mean(&mut slow, 30, 10, across), 0.25, &[0.0], 0.02);
    is_of(mean(&mut slow, 30, 10, around), 0.0, &[steep, -steep], 0.02);
}
