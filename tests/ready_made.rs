//! Every ready-made potential and link: the formula against one written by hand, derivatives against differences, known
//! limits, runs that keep what they must, and that all of them, and surfaces, go to a file and back.

use crate::common::larger;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::Error;
use rattle::links::{self, planar};
use rattle::nalgebra::{SVector, Vector2, Vector3};
use rattle::potentials::{self, *};
use rattle::prelude::*;
use rattle::surfaces::*;
use rattle::system::System;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::f64::consts::{E, FRAC_PI_2, PI, SQRT_2};
use std::fmt::Debug;

type Function = Box<dyn Fn(&[f64]) -> Vec<f64>>;
type Along = Box<dyn Fn(&[f64], &[f64]) -> Vec<f64>>;
type Largest = Box<dyn Fn(f64, u64) -> f64>;

/// A function, with what the macro made of it, behind one type: checks are compiled once.
struct Row {
    name: &'static str,
    /// A point around which the function is smooth.
    at: Vec<f64>,
    by_hand: fn(&[f64]) -> Vec<f64>,
    value: Function,
    /// Row after row.
    jacobian: Function,
    /// ∇²gᵢ v, row after row; of constraints.
    bend: Option<Along>,
    /// The largest energy error of a scene's run with so many of these steps; of potentials.
    energy: Option<Largest>,
}

/// What all ready-made types can.
trait ReadyMade: Copy + Debug + PartialEq + Serialize + DeserializeOwned + 'static {}
impl<T: Copy + Debug + PartialEq + Serialize + DeserializeOwned + 'static> ReadyMade for T {}

fn there_and_back<T: ReadyMade>(name: &str, given: &T) {
    let text = serde_json::to_string(given).unwrap();
    let back: T = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{name}: {error} in {text}"));
    assert_eq!(*given, back, "{name}: {text}");
}

fn vector<const D: usize>(x: &[f64]) -> SVector<f64, D> {
    SVector::from_column_slice(x)
}

fn link<const K: usize, const M: usize>(
    name: &'static str,
    g: impl Constraint<K, M> + ReadyMade,
    at: [f64; K],
    by_hand: fn(&[f64]) -> Vec<f64>,
) -> Row {
    there_and_back(name, &g);
    Row {
        name,
        at: at.to_vec(),
        by_hand,
        value: Box::new(move |q| g.value(&vector(q)).as_slice().to_vec()),
        jacobian: Box::new(move |q| g.jacobian(&vector(q)).transpose().as_slice().to_vec()),
        bend: Some(Box::new(move |q, v| {
            g.hessian_vector(&vector(q), &vector(v)).transpose().as_slice().to_vec()
        })),
        energy: None,
    }
}

fn largest_error<Y: System<f64, D>, const D: usize>(mut run: Simulation<Y, Rattle, D>, steps: u64) -> f64 {
    let mut largest = 0.0;
    run.run_with(steps, |now| largest = larger(largest, now.energy_error().abs())).unwrap();
    largest
}

fn potential<const K: usize>(
    name: &'static str,
    u: impl Potential<K> + ReadyMade,
    at: [f64; K],
    by_hand: fn(&[f64]) -> Vec<f64>,
) -> Row {
    there_and_back(name, &u);
    Row {
        name,
        at: at.to_vec(),
        by_hand,
        value: Box::new(move |q| vec![u.value(&vector(q))]),
        jacobian: Box::new(move |q| u.gradient(&vector(q)).as_slice().to_vec()),
        bend: None,
        energy: Some(Box::new(move |h, steps| {
            let start = State::at(at).moving([0.1; K]);
            largest_error(Scene::point().with(u).simulate(start, Rattle::new(h)).unwrap(), steps)
        })),
    }
}

fn pair(
    name: &'static str,
    u: impl PairPotential + ReadyMade,
    r: f64,
    by_hand: fn(&[f64]) -> Vec<f64>,
) -> Row {
    there_and_back(name, &u);
    Row {
        name,
        at: vec![r],
        by_hand,
        value: Box::new(move |r| vec![u.value(r[0])]),
        jacobian: Box::new(move |r| vec![u.slope_over_distance(r[0]) * r[0]]),
        bend: None,
        energy: Some(Box::new(move |h, steps| {
            let start = State::of([[0.0], [r]]).with_momenta([[-0.1], [0.1]]);
            let scene = Scene::points(2).masses([2.0; 2]).with(u);
            largest_error(scene.simulate(start, Rattle::new(h)).unwrap(), steps)
        })),
    }
}

fn v3(q: &[f64], body: usize) -> Vector3<f64> {
    vector(&q[3 * body..3 * body + 3])
}

fn v2(q: &[f64], body: usize) -> Vector2<f64> {
    vector(&q[2 * body..2 * body + 2])
}

/// The angle of a vector of the plane, counterclockwise from x.
fn direction(v: Vector2<f64>) -> f64 {
    v.y.atan2(v.x)
}

/// The same angle between −π and π.
fn wrapped(angle: f64) -> f64 {
    angle - 2.0 * PI * (angle / (2.0 * PI)).round()
}

/// The torsion of four points: the angle between what is across the axis in a − b and in d − c, signed by the axis.
fn torsion(q: &[f64]) -> f64 {
    let axis = (v3(q, 2) - v3(q, 1)).normalize();
    let across = |v: Vector3<f64>| v - axis * v.dot(&axis);
    let (near, far) = (across(v3(q, 0) - v3(q, 1)), across(v3(q, 3) - v3(q, 2)));
    near.cross(&far).dot(&axis).atan2(near.dot(&far))
}

const LENNARD_JONES: LennardJones = LennardJones { epsilon: 1.3, sigma: 0.9 };
const WCA: Wca = Wca { epsilon: 1.3, sigma: 0.9 };
const MORSE: Morse = Morse { depth: 1.7, alpha: 2.5, length: 1.25 };
const SOFT: SoftSphere = SoftSphere { stiffness: 3.0, diameter: 1.1 };

#[rustfmt::skip] // one row each
fn rows() -> Vec<Row> {
    let centre = [0.1, -0.2, 0.3];
    let (here, there) = ([0.7, -0.4, 1.1], [0.7, -0.4]);
    let (apart, abreast) = ([0.0, 0.1, 0.2, 1.0, -0.5, 0.7], [0.0, 0.1, 1.0, -0.5]);
    vec![
        potential("Gravity", Gravity { g: 9.81 }, here, |q| vec![9.81 * q[2]]),
        potential("ConstantForce", ConstantForce { force: [1.0, -2.0, 3.0] }, here, |q| vec![2.0 * q[1] - q[0] - 3.0 * q[2]]),
        potential("Harmonic", Harmonic { stiffness: 3.0, centre }, here, |q| vec![1.5 * (v3(q, 0) - Vector3::new(0.1, -0.2, 0.3)).norm_squared()]),
        potential("AnisotropicHarmonic", AnisotropicHarmonic { stiffness: [1.0, 0.0, 3.0], centre }, here,
            |q| vec![0.5 * (q[0] - 0.1).powi(2) + 1.5 * (q[2] - 0.3).powi(2)]),
        potential("Kepler", Kepler { mu: 2.0, centre }, here, |q| vec![-2.0 / (v3(q, 0) - Vector3::new(0.1, -0.2, 0.3)).norm()]),
        potential("Spring", Spring { stiffness: 3.0, length: 0.8 }, apart, |q| vec![1.5 * ((v3(q, 1) - v3(q, 0)).norm() - 0.8).powi(2)]),
        potential("InverseDistance", InverseDistance { strength: -2.0 }, apart, |q| vec![-2.0 / (v3(q, 1) - v3(q, 0)).norm()]),

        potential("planar Gravity", potentials::planar::Gravity { g: 9.81 }, there, |q| vec![9.81 * q[1]]),
        potential("planar ConstantForce", potentials::planar::ConstantForce { force: [1.0, -2.0] }, there, |q| vec![2.0 * q[1] - q[0]]),
        potential("planar Harmonic", potentials::planar::Harmonic { stiffness: 3.0, centre: [0.1, -0.2] }, there,
            |q| vec![1.5 * (v2(q, 0) - Vector2::new(0.1, -0.2)).norm_squared()]),
        potential("planar AnisotropicHarmonic", potentials::planar::AnisotropicHarmonic { stiffness: [1.0, 3.0], centre: [0.1, -0.2] }, there,
            |q| vec![0.5 * (q[0] - 0.1).powi(2) + 1.5 * (q[1] + 0.2).powi(2)]),
        potential("planar Kepler", potentials::planar::Kepler { mu: 2.0, centre: [0.1, -0.2] }, there,
            |q| vec![-2.0 / (v2(q, 0) - Vector2::new(0.1, -0.2)).norm()]),
        potential("planar Spring", potentials::planar::Spring { stiffness: 3.0, length: 0.8 }, abreast,
            |q| vec![1.5 * ((v2(q, 1) - v2(q, 0)).norm() - 0.8).powi(2)]),
        potential("planar InverseDistance", potentials::planar::InverseDistance { strength: -2.0 }, abreast,
            |q| vec![-2.0 / (v2(q, 1) - v2(q, 0)).norm()]),

        pair("Coulomb", Coulomb { strength: -1.5 }, 1.0, |r| vec![-1.5 / r[0]]),
        pair("LennardJones", LENNARD_JONES, 1.2, |r| vec![5.2 * ((0.9 / r[0]).powi(12) - (0.9 / r[0]).powi(6))]),
        pair("Wca within", WCA, 0.85, |r| vec![5.2 * ((0.9 / r[0]).powi(12) - (0.9 / r[0]).powi(6)) + 1.3]),
        pair("Wca beyond", WCA, 1.2, |_| vec![0.0]),
        pair("Morse", MORSE, 1.0, |r| vec![1.7 * ((1.0 - (-2.5 * (r[0] - 1.25)).exp()).powi(2) - 1.0)]),
        pair("Yukawa", Yukawa { strength: 1.5, kappa: 0.7 }, 1.0, |r| vec![1.5 / (r[0] * (0.7 * r[0]).exp())]),
        pair("Ricker", Ricker { depth: 0.5, radius: 1.2 }, 1.0,
            |r| vec![0.25 * (1.0 - 3.0 * (r[0] / 1.2).powi(2)) * (1.5 - 1.5 * (r[0] / 1.2).powi(2)).exp()]),
        pair("Gaussian", Gaussian { height: 2.0, width: 0.8 }, 1.0, |r| vec![2.0 / (r[0] / 0.8).powi(2).exp()]),
        pair("HarmonicPair", HarmonicPair { stiffness: 3.0, length: 1.3 }, 1.0, |r| vec![1.5 * (1.3 - r[0]).powi(2)]),
        pair("SoftSphere within", SOFT, 0.8, |r| vec![1.5 * (1.1 - r[0]).powi(2)]),
        pair("SoftSphere beyond", SOFT, 1.4, |_| vec![0.0]),

        link("Rod", links::Rod { length: 1.3 }, apart, |q| vec![(v3(q, 1) - v3(q, 0)).norm_squared() - 1.69]),
        link("Pendulum", links::Pendulum { length: 1.3, pivot: centre }, here, |q| vec![(v3(q, 0) - Vector3::new(0.1, -0.2, 0.3)).norm_squared() - 1.69]),
        link("Coincident", links::Coincident {}, apart, |q| (v3(q, 0) - v3(q, 1)).as_slice().to_vec()),
        link("Between", links::Between { fraction: 0.25 }, [0.0, 0.1, 0.2, 1.0, -0.5, 0.7, 0.3, 0.0, 0.4],
            |q| (v3(q, 2) - v3(q, 0).lerp(&v3(q, 1), 0.25)).as_slice().to_vec()),
        link("Angle", links::Angle { angle: 1.1 }, [1.0, 0.1, 0.2, 0.0, 0.0, 0.1, 0.4, 1.2, 0.3],
            |q| vec![(v3(q, 0) - v3(q, 1)).angle(&(v3(q, 2) - v3(q, 1))) - 1.1]),
        link("Torsion", links::Torsion { angle: 3.0 }, [1.0, 0.1, 0.2, 0.0, 0.0, 0.1, 0.1, -0.1, 1.2, -0.8, -0.3, 1.4],
            |q| vec![wrapped(torsion(q) - 3.0)]),
        link("RotationMatrix", links::RotationMatrix {}, [1.0, 0.1, -0.2, 0.3, 0.9, 0.1, 0.2, -0.1, 1.1], |q| {
            let column = |i: usize| Vector3::new(q[i], q[3 + i], q[6 + i]);
            let pairs = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
            pairs.map(|(i, j)| column(i).dot(&column(j)) - f64::from(u8::from(i == j))).to_vec()
        }),
        // The normals of the line z = 0 = y that Duff and others' formula takes: −z and y.
        link("Slider", links::Slider { point: centre, direction: [2.0, 0.0, 0.0] }, here, |q| vec![0.3 - q[2], q[1] + 0.2]),

        link("planar Rod", planar::Rod { length: 1.3 }, abreast, |q| vec![(v2(q, 1) - v2(q, 0)).norm_squared() - 1.69]),
        link("planar Pendulum", planar::Pendulum { length: 1.3, pivot: [0.1, -0.2] }, there, |q| vec![(v2(q, 0) - Vector2::new(0.1, -0.2)).norm_squared() - 1.69]),
        link("planar Coincident", planar::Coincident {}, abreast, |q| (v2(q, 0) - v2(q, 1)).as_slice().to_vec()),
        link("planar Between", planar::Between { fraction: 0.25 }, [0.0, 0.1, 1.0, -0.5, 0.3, 0.0],
            |q| (v2(q, 2) - v2(q, 0).lerp(&v2(q, 1), 0.25)).as_slice().to_vec()),
        link("planar Collinear", planar::Collinear {}, [0.0, 0.1, 1.0, -0.5, 0.3, 0.4],
            |q| vec![(v2(q, 1) - v2(q, 0)).normalize().perp(&(v2(q, 2) - v2(q, 0)))]),
        link("planar Angle", planar::Angle { angle: -2.0 }, [1.0, 0.1, 0.0, 0.1, -0.4, -0.9],
            |q| vec![wrapped(direction(v2(q, 2) - v2(q, 1)) - direction(v2(q, 0) - v2(q, 1)) + 2.0)]),
        link("planar Slider", planar::Slider { point: [0.1, -0.2], direction: [3.0, 4.0] }, there, |q| vec![0.6 * (q[1] + 0.2) - 0.8 * (q[0] - 0.1)]),
        link("planar Crank", planar::Crank { centre: [0.1, -0.2], radius: 1.5, omega: 2.0, phase: 0.3 }, [0.7, -0.4, 0.6], |q| {
            let (sin, cos) = (2.0 * q[2] + 0.3).sin_cos();
            vec![q[0] - 0.1 - 1.5 * cos, q[1] + 0.2 - 1.5 * sin]
        }),
        link("planar TurningLine", planar::TurningLine { omega: 2.0 }, [0.7, -0.4, 0.6], |q| {
            let (sin, cos) = (2.0 * q[2]).sin_cos();
            vec![Vector2::new(cos, sin).perp(&Vector2::new(q[0], q[1]))]
        }),
    ]
}

/// (4 D(h/2) − D(h)) / 3 of central differences along coordinate k: h⁴/480 times a fifth derivative, and rounding
/// eps/h.
fn difference(f: impl Fn(&[f64]) -> Vec<f64>, q: &[f64], k: usize) -> Vec<f64> {
    let central = |h: f64| {
        let at = |by: f64| {
            let mut q = q.to_vec();
            q[k] += by;
            f(&q)
        };
        at(h).iter().zip(at(-h)).map(|(ahead, behind)| (ahead - behind) / (2.0 * h)).collect::<Vec<_>>()
    };
    let (half, whole) = (central(1.0 / 4096.0), central(1.0 / 2048.0));
    half.iter().zip(whole).map(|(half, whole)| (4.0 * half - whole) / 3.0).collect()
}

/// Formulas are of order one and so are their derivatives of any order here, but for pair potentials at short distance.
#[test]
fn formulas_and_derivatives() {
    let rows = rows();
    assert_eq!(rows.len(), 42);
    let mut generator = StdRng::seed_from_u64(17);
    for row in &rows {
        let (name, variables) = (row.name, row.at.len());
        for _ in 0..50 {
            let q: Vec<f64> = row.at.iter().map(|x| x + generator.random_range(-0.1..0.1)).collect();
            let v: Vec<f64> = q.iter().map(|_| generator.random_range(-1.0..1.0)).collect();
            let (value, by_hand, jacobian) = ((row.value)(&q), (row.by_hand)(&q), (row.jacobian)(&q));
            let size = jacobian.iter().chain(&value).fold(1.0, |size: f64, x| size.max(x.abs()));
            let close = |what: &str, found: f64, expected: f64, bound: f64| {
                let error = (found - expected).abs();
                assert!(error <= bound * size, "{name}: {what} at {q:?} is {found}, expected {expected}");
            };
            assert_eq!(value.len(), by_hand.len(), "{name}");
            for (found, expected) in value.iter().zip(&by_hand) {
                close("value", *found, *expected, 1e-14);
            }
            let mut bend = vec![0.0; jacobian.len()];
            for k in 0..variables {
                let slopes = difference(row.by_hand, &q, k);
                for (i, slope) in slopes.iter().enumerate() {
                    close("derivative", jacobian[i * variables + k], *slope, 1e-10);
                }
                for (sum, change) in bend.iter_mut().zip(difference(&row.jacobian, &q, k)) {
                    *sum += v[k] * change;
                }
            }
            let found = row.bend.as_ref().map(|bend| bend(&q, &v));
            for (found, expected) in found.iter().flatten().zip(&bend) {
                close("second derivative", *found, *expected, 1e-9);
            }
        }
    }
}

/// U and U′ at r.
fn at(u: &impl PairPotential, r: f64) -> (f64, f64) {
    (u.value(r), u.slope_over_distance(r) * r)
}

#[track_caller]
fn assert_near(found: f64, expected: f64, ulps: f64) {
    assert!(
        (found - expected).abs() <= ulps * f64::EPSILON * (1.0 + expected.abs()),
        "{found}, not {expected}"
    );
}

#[test]
fn limits_of_pair_potentials() {
    // Lennard-Jones: −ε at 2^(1/6) σ, without force; 0 at σ; beyond, −4ε (σ/r)⁶.
    let cut = 0.9 * 2_f64.powf(1.0 / 6.0);
    let (bottom, slope) = at(&LENNARD_JONES, cut);
    assert_near(bottom, -1.3, 4.0);
    assert_near(slope, 0.0, 200.0); // terms of 20 cancel
    assert_near(LENNARD_JONES.value(0.9), 0.0, 32.0); // of 5.2 · 12 roundings
    assert_near(LENNARD_JONES.value(900.0) * 1e18, -5.2, 8.0);
    // WCA: the same with ε added up to there, and nothing beyond; no jump in the force.
    assert_near(WCA.value(0.9), 1.3, 32.0);
    assert_near(at(&WCA, 0.9).1, at(&LENNARD_JONES, 0.9).1, 32.0);
    for r in [cut * (1.0 - 1e-12), cut.next_down(), cut, cut.next_up(), cut * (1.0 + 1e-12)] {
        let (value, slope) = at(&WCA, r);
        assert!((0.0..1e-22).contains(&value) && (-1e-10..=0.0).contains(&slope), "{r}: {value} {slope}");
    }
    assert_eq!(at(&WCA, cut * (1.0 + 1e-15)), (0.0, 0.0));
    // Morse: −D at its length, without force, with stiffness 2Dα²; D (e^(2αr₀) − 2e^(αr₀)) at contact; 0 far away.
    assert_eq!(at(&MORSE, 1.25), (-1.7, 0.0));
    let stiffness = (at(&MORSE, 1.25 + 1e-6).1 - at(&MORSE, 1.25 - 1e-6).1) / 2e-6;
    assert!((stiffness / (2.0 * 1.7 * 2.5 * 2.5) - 1.0).abs() < 1e-9, "{stiffness}");
    assert_near(MORSE.value(0.0), 1.7 * (6.25_f64.exp() - 2.0 * 3.125_f64.exp()), 8.0);
    assert!((-1e-40..0.0).contains(&MORSE.value(40.0)));
    // Yukawa: Coulomb without screening; 1/e of it at 1/κ.
    let screened = Yukawa { strength: 1.5, kappa: 4.0 };
    assert_eq!(at(&Yukawa { kappa: 0.0, ..screened }, 0.7), at(&Coulomb { strength: 1.5 }, 0.7));
    assert_near(screened.value(0.25), 6.0 / E, 4.0);
    // Ricker: the well at its radius, zero at radius/√3, the hill at contact; pushes within and pulls beyond.
    let ricker = Ricker { depth: 0.5, radius: 1.5 };
    assert_eq!(ricker.value(1.5), -0.5);
    assert_near(at(&ricker, 1.5).1, 0.0, 4.0);
    assert_near(ricker.value(1.5 / 3_f64.sqrt()), 0.0, 4.0);
    assert_near(ricker.value(0.0), 0.25 * 1.5_f64.exp(), 4.0);
    assert!(ricker.slope_over_distance(1.49) < 0.0 && ricker.slope_over_distance(1.51) > 0.0);
    assert!(ricker.slope_over_distance(0.0) < 0.0);
    // Gaussian: height at contact, where it has the stiffness −2 height/width²; height/e at width; steepest at
    // width/√2.
    let bump = Gaussian { height: 2.0, width: 0.8 };
    assert_eq!((bump.value(0.0), at(&bump, 0.0).1), (2.0, 0.0));
    assert_near(bump.slope_over_distance(0.0), -6.25, 4.0);
    assert_near(bump.value(0.8), 2.0 / E, 4.0);
    let steep = -at(&bump, 0.8 / SQRT_2).1;
    assert!(steep > -at(&bump, 0.57).1 && steep > -at(&bump, 0.56).1);
    // Springs: at rest at their length; spheres that do not overlap do not touch.
    assert_eq!(at(&HarmonicPair { stiffness: 3.0, length: 1.3 }, 1.3), (0.0, 0.0));
    assert_eq!((at(&SOFT, 1.1), at(&SOFT, 1.1_f64.next_up())), ((0.0, 0.0), (0.0, 0.0)));
    assert_near(at(&SOFT, 0.6).1, -1.5, 4.0);
}

/// The largest energy error with n steps, and with twice as many, is as 4 to 1.
#[track_caller]
fn check_energy(what: &str, largest: impl Fn(f64, u64) -> f64) {
    let (n, h) = (100, 0.002);
    let errors = [largest(h, n), largest(h / 2.0, 2 * n)];
    println!("{what}: energy errors {errors:?}");
    assert!(errors[0] > 1e-10 && errors[0] < 1e-2, "{what}: something moved, and not wildly: {errors:?}");
    assert!((errors[0] / errors[1] / 4.0 - 1.0).abs() < 0.05, "{what}: not of second order: {errors:?}");
}

/// One body, or two by their distance, under each potential: of Rattle, the leapfrog method where nothing is
/// constrained, energy errors fall with h².
#[test]
fn potentials_keep_energy() {
    let rows = rows();
    let mut seen = 0;
    for (name, energy) in rows.iter().filter_map(|row| Some((row.name, row.energy.as_ref()?))) {
        if energy(0.002, 100) > 1e-12 {
            check_energy(name, energy);
            seen += 1;
        }
    }
    // Where the force is the same everywhere, leapfrog is exact: two each of gravity and of a constant force; two have
    // none.
    assert_eq!(seen, 25 - 4 - 2);
}

/// Sums over bodies and pairs, written out; the same in the plane; and a run of each.
#[test]
fn weights_charges_and_gravitation() {
    let (masses, charge) = ([2.0, 3.0, 1.0, 5.0], [1.0, -2.0, 0.0, 0.5]);
    let places = [[0.0, 0.0, 0.0], [0.6, 0.4, 0.8], [2.0, 2.0, 2.0], [0.0, -1.0, 0.9]];
    let mut expected = [0.0; 2];
    for (i, a) in places.iter().enumerate() {
        let heights = [a[2], a[1]];
        for (dimension, sum) in expected.iter_mut().enumerate() {
            *sum += 9.81 * masses[i] * heights[dimension];
        }
        for (j, b) in places[..i].iter().enumerate() {
            let apart = v3(a, 0) - v3(b, 0);
            expected[0] += (-0.7 * masses[i] * masses[j] + 1.1 * charge[i] * charge[j]) / apart.norm();
            expected[0] += Wca { epsilon: 0.3, sigma: 1.3 }.value(apart.norm());
            expected[1] += (-0.7 * masses[i] * masses[j] + 1.1 * charge[i] * charge[j]) / apart.xy().norm();
        }
    }
    let space = Scene::points(4)
        .masses(masses)
        .with(weights(9.81, masses))
        .with(gravitation(0.7, masses))
        .with(charges(1.1, charge))
        .with(Wca { epsilon: 0.3, sigma: 1.3 });
    let start = State::of(places);
    assert_near(space.simulate(start.clone(), Rattle::new(0.01)).unwrap().energy(), expected[0], 8.0);
    check_energy("space", |h, steps| {
        largest_error(space.simulate(start.clone(), Rattle::new(h)).unwrap(), steps)
    });
    let plane = Scene::points(4)
        .masses(masses)
        .with(potentials::planar::weights(9.81, masses))
        .with(potentials::planar::gravitation(0.7, masses))
        .with(potentials::planar::charges(1.1, charge));
    let start = State::of(places.map(|[x, y, _]| [x, y]));
    assert_near(plane.simulate(start.clone(), Rattle::new(0.01)).unwrap().energy(), expected[1], 8.0);
    check_energy("plane", |h, steps| {
        largest_error(plane.simulate(start.clone(), Rattle::new(h)).unwrap(), steps)
    });
    // A body without charge is left out: it may be where another one is.
    let touching = State::of([places[0], places[1], places[1], places[3]]);
    assert!(
        Scene::points(4).with(charges(1.1, charge)).simulate(touching.clone(), Rattle::new(0.01)).is_ok()
    );
    // A list with an entry for each body is not for more bodies, nor for fewer.
    let five = State::of([[0.0; 3], [1.0; 3], [2.0; 3], [3.0; 3], [4.0; 3]]);
    let told = |result: Result<(), Error>| result.unwrap_err().to_string();
    assert_eq!(
        told(
            Scene::points(5).with(weights(9.81, masses)).simulate(five.clone(), Rattle::new(0.01)).map(drop)
        ),
        "effect `Gravity`: 4 numbers were given for 5 bodies"
    );
    assert_eq!(
        told(Scene::points(5).with(gravitation(1.0, masses)).simulate(five, Rattle::new(0.01)).map(drop)),
        "effect `InverseDistance`: 4 numbers were given for 5 bodies"
    );
    let four = Scene::points(4).with(charges(1.0, [1.0, 2.0, 3.0]));
    assert!(four.ensemble([touching], Rattle::new(0.01)).is_err());
}

/// A mechanism of all links in space: what they say holds at the end, measured in other words.
#[test]
fn links_in_space_hold() {
    let (open, turned) = (1.9, -2.5);
    let scene = Scene::points(7)
        .link(links::Pendulum { length: 1.0, pivot: [0.0, 0.0, 1.0] }, [[0]])
        .link(links::Rod { length: 1.0 }, [[0, 1], [1, 2], [2, 3], [5, 6]])
        .link(links::Angle { angle: open }, [[0, 1, 2]])
        .link(links::Torsion { angle: turned }, [[0, 1, 2, 3]])
        .link(links::Between { fraction: 0.25 }, [[0, 1, 4]])
        .link(links::Coincident {}, [[3, 5]])
        .link(links::Slider { point: [0.0, 3.0, 0.0], direction: [1.0, -0.2, 0.4] }, [[6]])
        .with(Gravity { g: 1.0 });
    let rough = State::of([
        [0.9, 0.1, 0.5],
        [1.0, 1.0, 0.3],
        [0.4, 1.4, 1.0],
        [0.4, 2.3, 1.3],
        [0.9, 0.3, 0.4],
        [0.4, 2.3, 1.3],
        [0.3, 3.0, 0.5],
    ]);
    let start = scene.project(&rough.with_momenta([[0.2, -0.3, 0.1]; 7])).unwrap();
    check_energy("links in space", |h, steps| {
        let mut simulation = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
        let mut largest = 0.0;
        simulation.run_with(steps, |now| largest = larger(largest, now.energy_error().abs())).unwrap();
        let q: Vec<f64> = simulation.positions().flat_map(<[f64; 3]>::from).collect();
        let body = |i| v3(&q, i);
        let angle = (body(0) - body(1)).angle(&(body(2) - body(1)));
        let from_point = body(6) - Vector3::new(0.0, 3.0, 0.0);
        let along = Vector3::new(1.0, -0.2, 0.4).normalize();
        let off = [
            (body(0) - Vector3::z()).norm() - 1.0,
            (body(1) - body(0)).norm() - 1.0,
            (body(6) - body(5)).norm() - 1.0,
            angle - open,
            torsion(&q) - turned,
            (body(4) - body(0)).norm() - 0.25,
            (body(4) - body(1)).norm() - 0.75,
            (body(3) - body(5)).norm(),
            from_point.cross(&along).norm(),
        ];
        assert!(off.iter().all(|off| off.abs() <= 1e-13), "{off:?}");
        let path = simulation.positions().zip(start.positions()).map(|(now, then)| (now - then).norm());
        assert!(path.fold(f64::INFINITY, f64::min) > 0.01);
        largest
    });
}

/// The same in the plane. Three bodies make a straight bar by an angle of π.
#[test]
fn links_in_the_plane_hold() {
    let crank = planar::Crank { centre: [0.0, 0.0], radius: 1.0, omega: 2.0, phase: 0.3 };
    let scene = Scene::points(9)
        .link_moving(crank, [[0]])
        .link_moving(planar::TurningLine { omega: 0.7 }, [[8]])
        .link(planar::Rod { length: 2.0 }, [[0, 1]])
        .link(planar::Slider { point: [0.0, -0.2], direction: [5.0, 0.5] }, [[1]])
        .link(planar::Between { fraction: 0.5 }, [[0, 1, 2]])
        .link(planar::Collinear {}, [[0, 1, 3]])
        .link(planar::Pendulum { length: 1.0, pivot: [0.0, 3.0] }, [[4]])
        .link(planar::Rod { length: 1.0 }, [[4, 5], [5, 6]])
        .link(planar::Angle { angle: PI }, [[4, 5, 6]])
        .link(planar::Coincident {}, [[6, 7]])
        .with(potentials::planar::Gravity { g: 1.0 });
    let (sin, cos) = 0.3_f64.sin_cos();
    let rough = [
        [cos, sin],
        [2.9, 0.1],
        [1.9, 0.2],
        [1.5, 0.2],
        [0.9, 2.5],
        [1.5, 1.8],
        [2.0, 1.1],
        [2.0, 1.1],
        [1.0, 0.0],
    ];
    let start = State::of(rough).with_momenta([[0.3, 0.2]; 9]);
    let start = scene.project(&start).unwrap();
    check_energy("links in the plane", |h, steps| {
        let mut simulation = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
        let mut largest = 0.0;
        simulation.run_with(steps, |now| largest = larger(largest, now.energy_error().abs())).unwrap();
        let q: Vec<f64> = simulation.positions().flat_map(<[f64; 2]>::from).collect();
        let (body, t) = (|i| v2(&q, i), simulation.time());
        let slope = Vector2::new(5.0, 0.5).normalize();
        let off = [
            direction(body(0)) - (2.0 * t + 0.3),
            body(0).norm() - 1.0,
            (body(1) - body(0)).norm() - 2.0,
            slope.perp(&(body(1) - Vector2::new(0.0, -0.2))),
            (body(2) - (body(0) + body(1)) / 2.0).norm(),
            (body(3) - body(0)).normalize().perp(&(body(1) - body(0))),
            (body(6) - body(4)).norm() - 2.0, // straight
            (body(4) - Vector2::new(0.0, 3.0)).norm() - 1.0,
            (body(7) - body(6)).norm(),
            direction(body(8)) - 0.7 * t,
        ];
        assert!(off.iter().all(|off| off.abs() <= 1e-13), "{off:?}");
        assert!(simulation.work().abs() > 0.05, "the crank drives");
        largest
    });
}

/// The two normals of a slider in space are as long as the distance from the line, whatever its direction.
#[test]
fn sliders_measure_the_distance() {
    let mut generator = StdRng::seed_from_u64(5);
    let mut random = || Vector3::from_fn(|_, _| generator.random_range(-1.0..1.0));
    let axes = [Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y(), Vector3::z(), -Vector3::z()];
    let steep = [Vector3::new(1e-9, -1e-9, -1.0), Vector3::new(1.0, 1.0, -1e-300)];
    for direction in axes.into_iter().chain(steep).chain((0..100).map(|_| random())).collect::<Vec<_>>() {
        let (point, q) = (random(), random());
        let slider = links::Slider { point: point.into(), direction: (3.0 * direction).into() };
        let distance = (q - point).cross(&direction.normalize()).norm();
        let error = (slider.value(&q).norm() - distance).abs();
        assert!(error <= 8.0 * f64::EPSILON, "{direction}: {error}");
        let along = slider.value(&(point + direction)).amax();
        assert!(along <= 8.0 * f64::EPSILON, "{direction}: {along}");
    }
}

/// The sign of a torsion as IUPAC has it, and its turns by π/2.
#[test]
fn torsions_turn_clockwise() {
    // Seen from b, above, down to c the nearer bond points along x, and a clockwise turn leads to −y.
    let at = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        vector(&[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, cos, -sin, -1.0])
    };
    for quarter in -1..=2 {
        let angle = f64::from(quarter) * FRAC_PI_2;
        assert!(links::Torsion { angle }.value(&at(angle))[0].abs() <= 4.0 * f64::EPSILON, "{angle}");
        let missing = links::Torsion { angle: 0.0 }.value(&at(0.9 * angle))[0];
        assert!((missing - 0.9 * angle).abs() <= 4.0 * f64::EPSILON, "{missing}");
    }
}

constraint! {
    /// A type of one's own: what is derived inside the macro holds.
    #[derive(Serialize, Deserialize)]
    struct Edge { at, normal: [f64; 2] }
    |q: [f64; 2]| dot(normal, q) - at
}

/// Surfaces as files; potentials and links are asked in their rows.
#[test]
fn surfaces_go_to_files_and_back() {
    fn check(name: &str, surface: impl ReadyMade, _known: Option<[f64; 3]>) {
        there_and_back(name, &surface);
    }
    catalogue!(check);
    there_and_back("Edge", &Edge { at: 1.0 / 3.0, normal: [0.6, 0.8] });
    let text = serde_json::to_string(&links::Pendulum { length: 2.0, pivot: [0.1, 0.2, 0.3] }).unwrap();
    assert_eq!(text, r#"{"length":2.0,"pivot":[0.1,0.2,0.3]}"#);
    let mistake = serde_json::from_str::<Torus>(r#"{"major": 1.5}"#).unwrap_err();
    assert!(mistake.to_string().contains("missing field `minor`"), "{mistake}");
}
