//! Fekete points: twenty particles on a sphere that repel each other, slowed down by drag until they rest, against the
//! reference of the test set for initial value problems. Solvers that reduce the index leave the sphere soon.

use rattle::curvature::points::uniform;
use rattle::effect::LinearDrag;
use rattle::prelude::*;
use rattle::surfaces::Sphere;
use std::f64::consts::{PI, TAU};

pair_potential! {
    /// Repulsion by −ln r: the product of all distances becomes a maximum.
    struct Repulsion {}
    |r| -ln(r)
}

/// The start of the test set: circles of 3, 7, 6 and 4 particles, at rest.
fn start() -> State<3> {
    let circles = [(3, 13.0, 3.0 / 8.0), (7, 29.0, 1.0 / 8.0), (6, 7.0, -2.0 / 15.0), (4, 17.0, -3.0 / 10.0)];
    State::of(circles.into_iter().flat_map(|(number, shift, height)| {
        let latitude: f64 = PI * height;
        // The last circle begins a place earlier.
        let first = usize::from(number != 4);
        (first..number + first).map(move |i| {
            let angle = TAU * i as f64 / number as f64 + PI / shift;
            [angle.cos() * latitude.cos(), angle.sin() * latitude.cos(), latitude.sin()]
        })
    }))
}

/// Where they rest at t = 1000: places of second order in h, which differ by the turn that the motion leaves behind;
/// extrapolated they are the reference, which was found at tolerances of 1e-12, to 1e-9. Energy goes into work, and
/// particles stay on the sphere.
#[test]
#[cfg(long)]
fn twenty_particles_come_to_rest_where_the_reference_has_them() {
    let reference: Vec<[f64; 3]> = crate::common::table("fekete")
        .iter()
        .map(|row| ["x", "y", "z"].map(|name| row.number(name)))
        .collect();
    let scene = Scene::on(Sphere { r: 1.0 }).bodies(20).with(Repulsion {}).with(LinearDrag::new(0.5));
    let rest = |h: f64| {
        let mut simulation = scene.simulate(start(), Rattle::new(h)).unwrap();
        // Until t = 64 in steps of h; after that they move by less than 1e-13.
        simulation.run_until(64.0).unwrap();
        let mut simulation = scene.simulate(simulation.state(), Rattle::new(0.1)).unwrap();
        simulation.run_until(1000.0).unwrap();
        assert!(simulation.constraint_residual() < 1e-15);
        assert!(simulation.momenta().all(|p| p.norm() < 1e-8));
        simulation.positions().map(<[f64; 3]>::from).collect::<Vec<_>>()
    };
    let [coarse, middle, fine] = [0.02, 0.01, 0.005].map(rest);
    let off = |places: &[[f64; 3]]| {
        let distances = places.iter().zip(&reference).map(|(a, b)| crate::common::distance(*a, *b));
        distances.fold(0.0, f64::max)
    };
    let errors = [&coarse, &middle, &fine].map(|places| off(places));
    let order = crate::common::order(&errors);
    assert!((1.9..2.1).contains(&order) && errors[2] < 1e-4, "{errors:?}");
    // h² and h⁴ taken away.
    let extrapolated: Vec<[f64; 3]> = (0..20)
        .map(|i| {
            std::array::from_fn(|d| {
                let (a, b, c) = (coarse[i][d], middle[i][d], fine[i][d]);
                (64.0 * c - 20.0 * b + a) / 45.0
            })
        })
        .collect();
    assert!(off(&extrapolated) < 1e-8, "{:e}", off(&extrapolated));
}

/// From any start the energy falls to that of a minimum; it is the same as that of the reference or a little higher.
#[test]
#[cfg(long)]
fn other_starts_come_to_rest_too() {
    let sphere = Sphere { r: 1.0 };
    let scene = Scene::on(sphere).bodies(20).with(Repulsion {}).with(LinearDrag::new(0.5));
    let lowest = {
        let reference: Vec<[f64; 3]> = crate::common::table("fekete")
            .iter()
            .map(|row| ["x", "y", "z"].map(|name| row.number(name)))
            .collect();
        let at_rest = scene.project(&State::of(reference)).unwrap();
        scene.simulate(at_rest, Rattle::new(0.01)).unwrap().energy()
    };
    for seed in 0..2 {
        let places = State::of(uniform(&sphere, [-1.0; 3], [1.0; 3], 20, seed).unwrap());
        let mut simulation = scene.simulate(places, Rattle::new(0.01)).unwrap().retry(12);
        simulation.run_until(100.0).unwrap();
        let (energy, work) = (simulation.energy(), simulation.work());
        assert!((lowest - 1e-9..lowest + 0.5).contains(&energy), "{energy} against {lowest}");
        assert!(work < 0.0 && simulation.kinetic_energy() < 1e-6);
    }
}
