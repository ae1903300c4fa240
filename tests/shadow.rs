//! Shadow energies: kept to their order, and what they catch.

use crate::common::*;
use rattle::bodies::{Bodies, Count};
use rattle::effect::Effects;
use rattle::links::planar::Rod;
use rattle::method::{Failure, Witness};
use rattle::nalgebra::{Matrix3, Vector3};
use rattle::need::Kicks;
use rattle::prelude::*;
use rattle::real::Scalar;
use rattle::scene::Hold;
use rattle::system::System;
use rattle::watch::quadratic_form;

potential! {
    /// Gravity, and a force that changes from place to place.
    struct Uneven { g }
    |x, y, z| g * z + x^2 * y + x * z / 2 + y^2 / 3
}

potential! {
    /// A top's weight: its centre of mass lies on its third axis.
    struct Top { weight }
    |q: [[f64; 3]; 3]| weight * q[2][2]
}

#[test]
fn quadratic_forms_are_the_rational_ones() {
    let path = format!("{}/tests/data/shadow_quadratic_forms.json", env!("CARGO_MANIFEST_DIR"));
    let table: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let rational = |text: &str| -> f64 {
        let (above, below) = text.split_once('/').unwrap_or((text, "1"));
        above.parse::<f64>().unwrap() / below.parse::<f64>().unwrap()
    };
    let table = table.as_object().unwrap();
    assert_eq!(table.len(), 6);
    for (order, rows) in table {
        let form = quadratic_form(order.parse().unwrap()).unwrap();
        let rows = rows.as_array().unwrap();
        assert_eq!(form.len(), rows.len());
        for (found, row) in form.iter().zip(rows) {
            for (found, exact) in found.iter().zip(row.as_array().unwrap()) {
                let exact = rational(exact.as_str().unwrap());
                assert!((found - exact).abs() <= 1e-14, "order {order}: {found} for {exact}");
            }
        }
    }
}

/// By how much H, H₂, E[4], E[6] and E[8] vary in a run.
fn spreads<C: Hold<D>, E: Effects<D>, N: Count, S: Method, const D: usize>(
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
    method: &S,
    time: f64,
) -> [f64; 5] {
    let mut simulation = scene.simulate(scene.staggered(start, method).unwrap(), method.clone()).unwrap();
    let mut shadows = [4, 6, 8].map(|order| ShadowEnergy::new(order).unwrap());
    let mut energies = [vec![simulation.energy()], vec![simulation.shadow_energy()]];
    for _ in 0..(time / method.step_size()).round() as u64 {
        simulation.observe(1, 1, &mut shadows).unwrap();
        energies[0].push(simulation.energy());
        energies[1].push(simulation.shadow_energy());
    }
    let spread = |values: &[f64]| {
        let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(l, h), &x| (l.min(x), h.max(x)));
        high - low
    };
    let [h, h2] = &energies;
    let [e4, e6, e8] = shadows.each_ref().map(ShadowEnergy::values);
    [h.as_slice(), h2, e4, e6, e8].map(spread)
}

/// Orders between two steps, the second half the first.
fn orders(long: [f64; 5], short: [f64; 5]) -> [f64; 5] {
    std::array::from_fn(|i| (long[i] / short[i]).log2())
}

#[test]
fn shadow_energies_are_kept_to_their_order() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let [long, short] = [0.01, 0.005].map(|h| spreads(&scene, &billiard_45(), &Rattle::new(h), 4.0));
    let [h, h2, e4, e6, e8] = orders(long, short);
    println!("{short:?} {:?}", orders(long, short));
    assert!((h - 2.0).abs() < 0.1 && h2 > 3.7 && e4 > 3.7 && e6 > 5.3 && e8 > 7.0);
    // The reference study measured these at h = 0.005.
    for (found, measured) in short.into_iter().zip([3.6e-4, 1.2e-6, 1.5e-5, 8.7e-7, 1.0e-7]) {
        assert!(found <= 1.1 * measured, "{found:e}, measured {measured:e}");
    }
}

#[test]
fn with_masses_links_and_rigid_bodies_too() {
    let linked = Scene::points(3)
        .masses([1.0, 2.0, 0.5])
        .link(Rod { length: 1.0 }, [[0, 1], [1, 2]])
        .pin(0, [0.0, 0.0])
        .with(PlanarGravity { g: 1.0 });
    let start = State::of([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
    let [long, short] = [0.02, 0.01].map(|h| spreads(&linked, &start, &Rattle::new(h), 4.0));
    let found = orders(long, short);
    println!("{short:?} {found:?}");
    assert!((found[0] - 2.0).abs() < 0.1 && found[1] > 3.7 && found[2] > 3.7 && found[3] > 5.3, "{found:?}");

    let top = Scene::rigid(Rigid::new([0.6, 0.8, 1.0])).with(Top { weight: 0.7 });
    let start = Rigid::start(&Matrix3::identity(), &Vector3::new(1.8, 0.4, -0.9));
    let [long, short] = [0.02, 0.01].map(|h| spreads(&top, &start, &Rattle::new(h), 4.0));
    let found = orders(long, short);
    println!("{short:?} {found:?}");
    assert!((found[0] - 2.0).abs() < 0.1 && found[1] > 3.7 && found[2] > 3.7 && found[3] > 5.3, "{found:?}");
}

#[test]
fn shake_has_the_shadow_energy_of_rattle() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let rattle = spreads(&scene, &billiard_45(), &Rattle::new(0.005), 1.0);
    let shake = spreads(&scene, &billiard_45(), &Shake::new(0.005), 1.0);
    assert!(rattle[4] > 0.0 && (rattle[4] - shake[4]).abs() <= 1e-12, "{rattle:?}, {shake:?}");
    assert!(shake[0] > 100.0 * rattle[1], "momenta half a step away are not those of H₂");
}

/// RATTLE with a fault.
#[derive(Debug, Clone, Copy)]
enum Faulty {
    NoFinalKick(f64),
    OldForces(f64),
    /// A thousandth of the second kick is missing.
    ShortKick(f64),
}

impl Faulty {
    fn h(self) -> f64 {
        let (Self::NoFinalKick(h) | Self::OldForces(h) | Self::ShortKick(h)) = self;
        h
    }
}

impl Method for Faulty {
    type Memory<T: Scalar> = [T; 0];
    type Need = Kicks;

    fn step_size(&self) -> f64 {
        self.h()
    }
    fn order(&self) -> u32 {
        1
    }
    fn name(&self) -> &'static str {
        "faulty"
    }
    fn with_step(&self, h: f64) -> Self {
        match self {
            Self::NoFinalKick(_) => Self::NoFinalKick(h),
            Self::OldForces(_) => Self::OldForces(h),
            Self::ShortKick(_) => Self::ShortKick(h),
        }
    }
    fn is_symmetric(&self) -> bool {
        false
    }
    fn step<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: &Y,
        bodies: &mut Bodies<Y::Count, T, Y::Kept, D>,
        _: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        let h = self.h();
        system.drift(0.5 * h, h, bodies, witness)?;
        match self {
            Self::OldForces(_) => {
                system.settle(0.5 * h, h, bodies, witness)?;
                system.evaluate_forces(bodies);
                Ok(())
            }
            Self::NoFinalKick(_) => {
                system.evaluate_forces(bodies);
                system.settle(0.0, h, bodies, witness)
            }
            Self::ShortKick(_) => {
                system.evaluate_forces(bodies);
                system.settle(0.4995 * h, h, bodies, witness)
            }
        }
    }
}

#[test]
fn faults_show_in_the_orders() {
    let scene = Scene::on(SURFACE).with(Uneven { g: 1.0 });
    for fault in [Faulty::NoFinalKick(1.0), Faulty::OldForces(1.0), Faulty::ShortKick(1.0)] {
        let [long, short] = [0.01, 0.005].map(|h| spreads(&scene, &billiard_45(), &fault.with_step(h), 4.0));
        let found = orders(long, short);
        println!("{fault:?}: {short:?} {found:?}");
        assert!(found[1] < 3.0 && found[2] < 3.0 && found[4] < 5.0, "{fault:?}: {found:?}");
    }
}
