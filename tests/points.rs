//! Points on surfaces: uniform in area, even, apart; and momenta of a temperature.

use crate::common::statistics::fits;
use rattle::curvature::points::{PointsError, apart, even, uniform};
use rattle::curvature::{integrate, measure};
use rattle::prelude::*;
use rattle::surfaces::{Ellipsoid, Gyroid, Lemniscate, Sphere, Torus};
use std::f64::consts::TAU;

constraint! {
    /// A circle.
    struct Circle { r }
    |x, y| x^2 + y^2 - r^2
}

constraint! {
    /// The unit sphere of four dimensions.
    struct ThreeSphere {}
    |q: [f64; 4]| dot(q, q) - 1
}

const N: usize = 2000;

/// By exact laws of the area: on a torus, an ellipsoid, a circle, a sphere of three dimensions in four.
#[test]
fn uniform_in_area() {
    const BINS: usize = 16;
    let bin = |share: f64| ((share * BINS as f64) as usize).min(BINS - 1);
    let (major, minor) = (1.0, 0.5);
    let mut counts = [[0.0; BINS]; 2];
    for q in uniform(&Torus { major, minor }, [-2.0; 3], [2.0; 3], N, 1).unwrap() {
        let angle = q.z.atan2(q.x.hypot(q.y) - major).rem_euclid(TAU);
        counts[0][bin(angle / TAU)] += 1.0;
        counts[1][bin(q.y.atan2(q.x).rem_euclid(TAU) / TAU)] += 1.0;
    }
    let edge = |i: usize| TAU * i as f64 / BINS as f64;
    let area = |angle: f64| (angle + minor / major * angle.sin()) / TAU;
    fits(&counts[0], &std::array::from_fn::<_, BINS, _>(|i| area(edge(i + 1)) - area(edge(i))));
    fits(&counts[1], &[1.0 / BINS as f64; BINS]);

    let mut counts = [0.0; BINS];
    for q in uniform(&Circle { r: 2.0 }, [-2.0; 2], [2.0; 2], N, 2).unwrap() {
        counts[bin(q.y.atan2(q.x).rem_euclid(TAU) / TAU)] += 1.0;
    }
    fits(&counts, &[1.0 / BINS as f64; BINS]);

    // q₀ of a point on S³ has the density (2/π) √(1 − q₀²).
    let mut counts = [0.0; BINS];
    for q in uniform(&ThreeSphere {}, [-1.0; 4], [1.0; 4], N, 3).unwrap() {
        assert!((q.norm() - 1.0).abs() < 1e-15);
        counts[bin(0.5 * (q[0] + 1.0))] += 1.0;
    }
    let below = |x: f64| 0.5 + (x * (1.0 - x * x).sqrt() + x.asin()) / std::f64::consts::PI;
    let at = |i: usize| 2.0 * i as f64 / BINS as f64 - 1.0;
    fits(&counts, &std::array::from_fn::<_, BINS, _>(|i| below(at(i + 1)) - below(at(i))));
}

/// By integrals over surfaces that have no formula: octants of the notebook's surface, shifted, where lines meet up to
/// eight sheets.
#[test]
#[cfg(long)]
fn uniform_where_there_is_no_formula() {
    let surface = Lemniscate { a: 1.0, r: 1.0 / 6.0 };
    let (low, high) = ([-1.3, -0.7, -0.3], [1.3, 0.7, 0.3]);
    let part = |q: &rattle::nalgebra::Vector3<f64>| {
        usize::from(q.x > 0.4) + 2 * usize::from(q.y > 0.1) + 4 * usize::from(q.z > 0.07)
    };
    let area = measure(&surface, low, high, 200).unwrap().area;
    let shares = integrate(&surface, low, high, 200, |q, _| {
        std::array::from_fn::<_, 8, _>(|i| f64::from(u8::from(part(q) == i)) / area)
    })
    .unwrap();
    let mut counts = [0.0; 8];
    uniform(&surface, low, high, N, 4).unwrap().iter().for_each(|q| counts[part(q)] += 1.0);
    fits(&counts, &shares);
}

/// Of two spheres, one in the other, on the inner one lies 1/10 of the area, though lines that meet it meet both:
/// points are taken with a chance that goes with their number.
#[test]
fn all_meetings_count() {
    constraint! {
        /// Spheres of radius 1 and 3.
        struct Nested {}
        |x, y, z| (x^2 + y^2 + z^2 - 1) * (x^2 + y^2 + z^2 - 9)
    }
    let inner =
        uniform(&Nested {}, [-3.0; 3], [3.0; 3], N, 7).unwrap().iter().filter(|q| q.norm() < 2.0).count();
    fits(&[inner as f64, (N - inner) as f64], &[0.1, 0.9]);
}

/// A surface that goes on outside of the box ends at its sides; the same seed gives the same points.
#[test]
fn boxes_and_seeds() {
    let gyroid = Gyroid { k: 1.0, epsilon: 0.0 };
    let points = uniform(&gyroid, [0.0; 3], [TAU; 3], 500, 5).unwrap();
    assert_eq!(points.len(), 500);
    assert!(points.iter().flatten().all(|&x| (0.0..=TAU).contains(&x)));
    assert!(points.iter().all(|q| gyroid.value(q).x.abs() < 1e-14));
    assert_eq!(points, uniform(&gyroid, [0.0; 3], [TAU; 3], 500, 5).unwrap());
    assert_ne!(points, uniform(&gyroid, [0.0; 3], [TAU; 3], 500, 6).unwrap());
    let error = uniform(&Sphere { r: 1.0 }, [2.0; 3], [3.0; 3], 5, 1).unwrap_err();
    assert!(matches!(error, PointsError::NotMet { found: 0, number: 5, .. }), "{error}");
    assert!(matches!(uniform(&Sphere { r: 1.0 }, [1.0; 3], [1.0; 3], 5, 1), Err(PointsError::Box { .. })));
    assert!(matches!(
        uniform(&Sphere { r: 1.0 }, [f64::NAN; 3], [1.0; 3], 5, 1),
        Err(PointsError::Box { .. })
    ));
}

/// A pole, and the edge of where g is a number, are no zeros.
#[test]
fn only_zeros_are_points() {
    constraint! {
        /// It has no zero.
        struct Pole {}
        |x, y, z| 1 / (x^2 + y^2 + z^2 - 1)
    }
    constraint! {
        /// A sphere of radius √2; no number inside of 1.
        struct Hollow {}
        |x, y, z| sqrt(x^2 + y^2 + z^2 - 1) - 1
    }
    assert!(matches!(
        uniform(&Pole {}, [-2.0; 3], [2.0; 3], 3, 1),
        Err(PointsError::NotMet { found: 0, .. })
    ));
    let points = uniform(&Hollow {}, [-2.0; 3], [2.0; 3], 50, 1).unwrap();
    assert_eq!(points.len(), 50);
    for q in points {
        assert!((q.norm() - 2_f64.sqrt()).abs() < 1e-14, "{q}");
    }
    assert!(matches!(apart(&Hollow {}, [-2.0; 3], [2.0; 3], 3, f64::NAN, 1), Err(PointsError::Distance(_))));
}

/// The mean of z² over points on a sphere, 1/3: of even points nearer than of random ones, whose deviation is √(4/45n),
/// by more than half.
#[test]
#[cfg(long)]
fn even_points() {
    let mean = |points: Vec<rattle::nalgebra::Vector3<f64>>| {
        points.iter().map(|q| q.z * q.z).sum::<f64>() / points.len() as f64 - 1.0 / 3.0
    };
    let sphere = Sphere { r: 1.0 };
    let deviation = (4.0 / 45.0 / N as f64).sqrt();
    let worst = |means: &mut dyn Iterator<Item = f64>| (means.map(|x| x * x).sum::<f64>() / 8.0).sqrt();
    let spread = worst(&mut (0..8).map(|seed| mean(uniform(&sphere, [-1.0; 3], [1.0; 3], N, seed).unwrap())));
    assert!((0.4..1.7).contains(&(spread / deviation)), "{}", spread / deviation);
    let few = N / 8;
    let even = worst(&mut (0..8).map(|seed| mean(even(&sphere, [-1.0; 3], [1.0; 3], few, seed).unwrap())));
    assert!(even < 0.5 * (8.0_f64.sqrt() * deviation), "{}", even / deviation);
}

#[test]
fn points_apart() {
    let egg = Ellipsoid { a: 1.0, b: 1.2, c: 1.5 };
    let points = apart(&egg, [-1.5; 3], [1.5; 3], 200, 0.2, 1).unwrap();
    assert_eq!(points.len(), 200);
    for (i, q) in points.iter().enumerate() {
        assert!(points[..i].iter().all(|other| (q - other).norm() >= 0.2));
    }
    let error = apart(&egg, [-1.5; 3], [1.5; 3], 200, 0.7, 1).unwrap_err();
    assert!(matches!(error, PointsError::Full { number: 200, .. }), "{error}");
}

/// Where few lines meet a surface, and none of their points was too near to another, a smaller distance is no help.
#[test]
fn points_apart_in_a_large_box() {
    for distance in [0.0, 1e-9] {
        let error = apart(&Sphere { r: 1.0 }, [-40.0; 3], [40.0; 3], 50, distance, 2).unwrap_err();
        assert!(matches!(error, PointsError::NotMet { found: 1.., number: 50, .. }), "{error}");
    }
}

/// Momenta of Maxwell's distribution: tangent, and ½kT for each independent one, also of a chain with masses.
#[test]
fn momenta_of_a_temperature() {
    let sphere = Sphere { r: 1.0 };
    let gas = Scene::on(sphere).bodies(2000);
    let places = State::of(uniform(&sphere, [-1.0; 3], [1.0; 3], 2000, 1).unwrap());
    let start = gas.maxwell(&places, 0.7, 3).unwrap();
    for (q, p) in start.positions().zip(start.momenta()) {
        assert!(q.dot(&p).abs() < 1e-15 * p.norm().max(1.0));
    }
    let now = gas.simulate(start.clone(), Rattle::new(0.01)).unwrap();
    assert!((now.temperature() - 0.7).abs() < 4.5 * 0.7 / 2000_f64.sqrt(), "{}", now.temperature());
    assert_eq!(start, gas.maxwell(&places, 0.7, 3).unwrap());
    assert_ne!(start, gas.maxwell(&places, 0.7, 4).unwrap());
    assert!(gas.maxwell(&places, -0.7, 4).unwrap_err().to_string().contains("temperature must be"));

    let chain = Scene::points::<2>(4)
        .masses([1.0, 3.0, 0.5, 2.0])
        .link(rattle::links::planar::Rod { length: 1.0 }, [[0, 1], [1, 2], [2, 3]]);
    let places = State::of([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [2.0, 1.0]]);
    let draws = 2000;
    let sum: f64 = (0..draws)
        .map(|i| {
            let start = chain.maxwell(&places.clone().numbered(i), 0.7, 1).unwrap();
            chain.simulate(start, Rattle::new(0.01)).unwrap().temperature()
        })
        .sum();
    let deviation = 0.7 * (2.0 / (5.0 * draws as f64)).sqrt();
    assert!((sum / draws as f64 - 0.7).abs() < 4.5 * deviation, "{}", sum / draws as f64);
}

/// Where a line is not in the box nothing is asked: in a flat one most of it. So a box that is larger along all sides
/// takes more by the square of its size.
#[test]
fn lines_are_asked_in_the_box_alone() {
    let asked = |[x, z]: [f64; 2]| {
        let torus = Counted::new(Torus { major: 1.0, minor: 0.02 });
        uniform(&torus, [-x, -x, -z], [x, x, z], 200, 3).unwrap();
        torus.counts().values() as f64 / 200.0
    };
    let [tight, wide] = [[1.021, 0.021], [2.042, 0.042]].map(asked);
    println!("{tight} evaluations a point in a tight box, {wide} in one twice as wide");
    assert!(tight < 4000.0, "{tight}"); // 818; 15 660 where lines were followed beyond the box
    assert!(wide > 2.0 * tight && wide < 6.0 * tight, "{tight} {wide}");
}

constraint! {
    /// Five spheres: a line through all of them meets ten points.
    struct Onion {}
    |x, y, z| {
        let s = x^2 + y^2 + z^2;
        (s - 0.04) * (s - 0.16) * (s - 0.36) * (s - 0.64) * (s - 1)
    }
}

/// One point of each seed: lines that meet many points are not drawn more seldom than those that meet few. The largest
/// sphere has 1/2.2 of the area; of 2000 points, 4.5 deviations are 0.05.
#[test]
#[cfg_attr(not(long), ignore = "20 s as it is compiled: run by `cargo long`")]
fn one_point_of_a_seed_is_uniform_too() {
    let seeds = 2000;
    let outside = |seed: &u64| uniform(&Onion {}, [-1.0; 3], [1.0; 3], 1, *seed).unwrap()[0].norm() > 0.9;
    let share = (0..seeds).filter(outside).count() as f64 / seeds as f64;
    assert!((share - 1.0 / 2.2).abs() < 0.05, "{share}");
}
