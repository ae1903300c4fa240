//! The few scenes that all rows share, and what rows ask of a run.

use crate::common::linked::Rod;
pub use crate::common::{Gravity, Lemniscate, Ridge, SURFACE, Torus, TorusByDistance};
use crate::suite::case::Measured;
use rattle::Error;
use rattle::nalgebra::Vector3;
use rattle::potentials::planar::weights;
use rattle::prelude::*;

pub const E: f64 = f64::EPSILON;

constraint! {
    /// Spheres, ellipsoids, tubes, cones and hyperboloids, anywhere, of any size, as c·g = 0.
    #[derive(Clone, Copy)]
    pub struct Quadric { c, centre: [f64; 3], axes: [f64; 3], k }
    |q: [f64; 3]| c * (sum(i in 0..3, axes[i] * (q[i] - centre[i])^2) - k)
}

pub fn sphere(radius: f64) -> Quadric {
    Quadric { c: 1.0, centre: [0.0; 3], axes: [1.0; 3], k: radius * radius }
}

/// x² + y² − z² = k: a double cone for k = 0.
pub fn hyperboloid(k: f64) -> Quadric {
    Quadric { c: 1.0, centre: [0.0; 3], axes: [1.0, 1.0, -1.0], k }
}

pub fn at(q: [f64; 3], p: [f64; 3]) -> State<3> {
    State::at(q).moving(p)
}

/// A body on a surface, under gravity.
pub fn on<C: Constraint<3, 1> + 'static, S: Method + 'static>(
    surface: C,
    g: f64,
    start: State<3>,
    method: S,
) -> Result<BoxedSimulation<3>, Error> {
    Ok(Scene::on(surface).with(Gravity { g }).simulate(start, method)?.boxed())
}

/// The same from a start that need not be quite on the surface.
pub fn onto<C: Constraint<3, 1> + 'static, S: Method + 'static>(
    surface: C,
    g: f64,
    start: State<3>,
    method: S,
) -> Result<BoxedSimulation<3>, Error> {
    let scene = Scene::on(surface).with(Gravity { g });
    Ok(scene.simulate(scene.project(&start)?, method)?.boxed())
}

/// Bodies in the plane tied by rods of the lengths that they have at the start, some bodies pinned, under gravity.
#[derive(Clone, Default)]
pub struct Rods {
    pub places: Vec<[f64; 2]>,
    pub momenta: Vec<[f64; 2]>,
    pub masses: Vec<f64>,
    pub rods: Vec<[usize; 2]>,
    pub pins: Vec<usize>,
    pub g: f64,
    pub algebra: LinearAlgebra,
}

impl Rods {
    pub fn simulate<S: Method + 'static>(&self, method: S) -> Result<BoxedSimulation<2>, Error> {
        let length = |&[a, b]: &[usize; 2]| {
            let [a, b] = [self.places[a], self.places[b]];
            (a[0] - b[0]).hypot(a[1] - b[1])
        };
        let rods: Vec<_> = self.rods.iter().map(|rod| (Rod { length: length(rod) }, *rod)).collect();
        self.simulate_with(rods, method)
    }

    /// With rods of other lengths.
    pub fn simulate_with<S: Method + 'static>(
        &self,
        rods: Vec<(Rod, [usize; 2])>,
        method: S,
    ) -> Result<BoxedSimulation<2>, Error> {
        let n = self.places.len();
        let masses = if self.masses.is_empty() { vec![1.0; n] } else { self.masses.clone() };
        let mut scene =
            Scene::points::<2>(n).link_each(rods).masses(masses.clone()).linear_algebra(self.algebra);
        for &pin in &self.pins {
            scene = scene.pin(pin, self.places[pin]);
        }
        let scene = scene.with(weights(self.g, masses));
        let mut start = State::of(self.places.iter().copied());
        if !self.momenta.is_empty() {
            start = start.with_momenta(self.momenta.iter().copied());
        }
        Ok(scene.simulate(scene.project(&start)?, method)?.boxed())
    }
}

pair_potential! {
    /// Kepler's pull or Coulomb's push, a hard core, and a spring.
    #[derive(Clone, Copy)]
    pub struct Pair { charge, core, size, k, rest }
    |r| charge / r + core * (size / r)^12 + k * (r - rest)^2 / 2
}

/// Two or more free bodies in the plane with a pair potential between any two.
pub fn pairs<S: Method + 'static>(
    potential: Pair,
    masses: &[f64],
    start: State<2>,
    method: S,
) -> Result<BoxedSimulation<2>, Error> {
    let scene = Scene::points::<2>(masses.len()).masses(masses.iter().copied()).with(potential);
    Ok(scene.simulate(start, method)?.boxed())
}

/// The larger number; what is no number stays.
pub fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b <= a { a } else { b }
}

/// The largest of what is seen after each of so many steps.
pub fn largest<const D: usize>(
    mut simulation: BoxedSimulation<D>,
    steps: u64,
    see: impl Fn(&BoxedSimulation<D>) -> f64,
) -> Measured {
    let mut worst = 0.0;
    simulation.run_with(steps, |now| worst = larger(worst, see(now)))?;
    assert_eq!(simulation.steps(), steps);
    Ok(worst)
}

/// The place after so many steps.
pub fn place_after(mut simulation: BoxedSimulation<3>, steps: u64) -> Result<Vector3<f64>, Error> {
    simulation.run(steps)?;
    Ok(place(&simulation))
}

pub fn place(now: &BoxedSimulation<3>) -> Vector3<f64> {
    now.positions().next().unwrap()
}

pub fn momentum(now: &BoxedSimulation<3>) -> Vector3<f64> {
    now.momenta().next().unwrap()
}

/// Energy errors as parts of the energy at the start.
pub fn relative_energy<const D: usize>(simulation: BoxedSimulation<D>, steps: u64) -> Measured {
    let energy = simulation.energy().abs();
    largest(simulation, steps, |now| now.energy_error().abs() / energy)
}

/// How far a way back ends from the start, by a method with the other sign of its step.
pub fn apart<const D: usize>(a: &State<D>, b: &State<D>) -> f64 {
    let between =
        |a: &rattle::nalgebra::SVector<f64, D>, b: &rattle::nalgebra::SVector<f64, D>| (a - b).amax();
    let places = a.positions().zip(b.positions()).map(|(a, b)| between(&a, &b));
    let momenta = a.momenta().zip(b.momenta()).map(|(a, b)| between(&a, &b));
    places.chain(momenta).fold(0.0, larger)
}

/// One where something else came than the error that is meant, which names the reason; the page then says so.
pub fn unless<T>(result: Result<T, Error>, meant: impl Fn(&Error) -> bool) -> f64 {
    match result {
        Err(error) if meant(&error) => 0.0,
        Err(error) => {
            println!("instead: {error}");
            1.0
        }
        Ok(_) => 1.0,
    }
}

/// The first error of a run.
pub fn ends<const D: usize>(mut simulation: BoxedSimulation<D>, steps: u64) -> Result<(), Error> {
    simulation.run(steps)
}
