//! What a method remembers: carried from step to step, put back with a failed step, cloned, and taken on by a restart.

use crate::common::*;
use rattle::bodies::Bodies;
use rattle::method::{Failure, Witness};
use rattle::need::Steps;
use rattle::prelude::*;
use rattle::real::Scalar;
use rattle::system::System;

/// RATTLE with steps that grow by an eighth each: the next step and the last one are remembered.
#[derive(Debug, Clone, Copy)]
struct Growing {
    first: f64,
}

fn number<T: Scalar>(x: T) -> f64 {
    x.lanes().next().unwrap()
}

impl Method for Growing {
    type Memory<T: Scalar> = Vec<T>;
    type Need = Steps;

    fn step_size(&self) -> f64 {
        self.first
    }
    fn order(&self) -> u32 {
        2
    }
    fn name(&self) -> &'static str {
        "growing"
    }
    fn with_step(&self, h: f64) -> Self {
        Self { first: h }
    }
    fn is_symmetric(&self) -> bool {
        false
    }
    fn memory<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        _: &Y,
        _: &Bodies<Y::Count, T, Y::Kept, D>,
    ) -> Vec<T> {
        vec![T::from_f64(self.first), T::from_f64(0.0)]
    }
    fn time_taken<T: Scalar>(&self, memory: &[T]) -> Option<T> {
        Some(memory[1])
    }
    fn step<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: &Y,
        bodies: &mut Bodies<Y::Count, T, Y::Kept, D>,
        memory: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        let h = memory[0];
        (memory[0], memory[1]) = (h * T::from_f64(1.125), h);
        Rattle::new(number(h)).step(system, bodies, &mut [], witness)
    }
}

type Ball = rattle::surfaces::Sphere;

fn simulation(
    method: Growing,
) -> Simulation<impl System<f64, 3, Count = rattle::bodies::One> + use<>, Growing, 3> {
    let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 1.0, 0.0]);
    Scene::on(Ball { r: 1.0 }).simulate(start, method).unwrap()
}

#[test]
fn one_step_methods_remember_nothing() {
    fn size<S: Method>() -> usize {
        size_of::<S::Memory<f64>>()
    }
    assert_eq!([size::<Rattle>(), size::<Composition>(), size::<Lobatto<5>>(), size::<Leapfrog>()], [0; 4]);
}

#[test]
fn time_is_the_sum_of_steps_of_different_lengths() {
    let mut simulation = simulation(Growing { first: 0.01 });
    simulation.run(20).unwrap();
    let exact = 0.01 * (1.125_f64.powi(20) - 1.0) / 0.125;
    assert!((simulation.time() - exact).abs() <= 4.0 * f64::EPSILON * exact, "{}", simulation.time());
    // Each step of RATTLE at unit speed turns by asin h.
    let (mut angle, mut h) = (0.0, 0.01_f64);
    for _ in 0..20 {
        angle += h.asin();
        h *= 1.125;
    }
    let q = simulation.position();
    assert!((q.y.atan2(q.x) - angle).abs() <= 1e-14, "{} {angle}", q.y.atan2(q.x));
}

#[test]
fn a_failed_step_is_forgotten() {
    let mut simulation = simulation(Growing { first: 0.5 });
    simulation.run(6).unwrap();
    let last = simulation.state(); // the seventh step would be of 0.5 × 1.125⁶ > 1
    for _ in 0..2 {
        let error = simulation.step().unwrap_err();
        assert!(matches!(error, rattle::Error::Step { step: 7, .. }), "{error}");
        assert_eq!(simulation.state(), last, "what is remembered is part of a state");
    }
}

#[test]
fn clones_and_restarts_go_on_bit_for_bit() {
    let method = Growing { first: 0.01 };
    let mut whole = simulation(method);
    whole.run(10).unwrap();
    let mut clone = whole.clone();
    let scene = Scene::on(Ball { r: 1.0 });
    let mut rest = scene.simulate(whole.state(), method).unwrap();
    for simulation in [&mut whole, &mut clone] {
        simulation.run(10).unwrap();
    }
    rest.run(10).unwrap();
    assert_eq!(bits(&clone.state()), bits(&whole.state()));
    assert_eq!(bits(&rest.state()), bits(&whole.state()));
    assert_eq!((rest.time(), clone.time()), (whole.time(), whole.time()));

    // Other momenta, and another step size, start anew.
    let state = clone.state();
    let p = state.momenta().next().unwrap();
    let mut anew = scene.simulate(state.clone().with_momenta([p]), method).unwrap();
    let mut other = scene.simulate(state.clone(), method.with_step(0.02)).unwrap();
    anew.step().unwrap();
    other.step().unwrap();
    let after = |h: f64| (state.time() + h) - state.time();
    assert_eq!((anew.time() - state.time(), other.time() - state.time()), (after(0.01), after(0.02)));
}

#[test]
fn remembering_does_not_allocate() {
    let mut simulation = simulation(Growing { first: 0.01 });
    let allocated = allocation_counter::measure(|| simulation.run(20).unwrap());
    assert_eq!((simulation.steps(), allocated.count_total), (20, 0));
}

/// RATTLE with steps that are longer by the number of the trajectory.
#[derive(Debug, Clone, Copy)]
struct Numbered {
    h: f64,
}

impl Method for Numbered {
    type Memory<T: Scalar> = [T; 0];
    type Need = Steps;

    fn step_size(&self) -> f64 {
        self.h
    }
    fn order(&self) -> u32 {
        2
    }
    fn name(&self) -> &'static str {
        "numbered"
    }
    fn with_step(&self, h: f64) -> Self {
        Self { h }
    }
    fn is_symmetric(&self) -> bool {
        true
    }
    const DRAWS: bool = true;
    fn step<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: &Y,
        bodies: &mut Bodies<Y::Count, T, Y::Kept, D>,
        memory: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        let number = bodies.noise.trajectory as f64;
        Rattle::new(self.h * (1.0 + number)).step(system, bodies, memory, witness)
    }
}

/// A method is told which trajectory it moves: its number in an ensemble, 0 in a simulation; and so is one that is
/// composed.
#[test]
fn a_method_knows_its_trajectory() {
    fn check<S: Method>(method: S) {
        let (scene, start) = (Scene::point(), State::at([0.0]).moving([1.0]));
        let mut alone = scene.simulate(start.clone(), method.clone()).unwrap();
        alone.step().unwrap();
        assert!((alone.position().x - 0.5).abs() <= 1e-15, "{}: {}", method.name(), alone.position().x);
        let mut ensemble = scene.ensemble(vec![start; 40], method.clone()).unwrap();
        ensemble.run(1);
        for trajectory in 0..40 {
            let at = ensemble.state(trajectory).positions().next().unwrap().x;
            let expected = 0.5 * (1.0 + trajectory as f64);
            assert!((at / expected - 1.0).abs() <= 1e-14, "{}: {trajectory} at {at}", method.name());
        }
    }
    let method = Numbered { h: 0.5 };
    check(method);
    check(Composition::of(SUZUKI_1990_ORDER_4, method));
}

/// RATTLE that says that flows act inside its step, where none does, and that its step cannot be divided.
#[derive(Debug, Clone, Copy)]
struct Unmoved {
    inner: Rattle,
}

impl Method for Unmoved {
    type Memory<T: Scalar> = [T; 0];
    type Need = Steps;
    const HAS_STRUCTURE: bool = false;
    const CHECKS: bool = true;
    const STIRS: bool = true;

    fn step_size(&self) -> f64 {
        self.inner.step_size()
    }
    fn order(&self) -> u32 {
        2
    }
    fn name(&self) -> &'static str {
        "unmoved by flows"
    }
    fn with_step(&self, h: f64) -> Self {
        Self { inner: self.inner.with_step(h) }
    }
    fn is_symmetric(&self) -> bool {
        true
    }
    fn undivided(&self) -> Option<&'static str> {
        Some("it says so")
    }
    fn step<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: &Y,
        bodies: &mut Bodies<Y::Count, T, Y::Kept, D>,
        memory: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        self.inner.step(system, bodies, memory, witness)
    }
}

/// What is made of another method has its properties: flows do not act a second time around its steps.
#[test]
fn properties_of_a_base_are_those_of_what_is_made_of_it() {
    fn properties<S: Method>(method: &S) -> (bool, bool, bool, bool, Option<&'static str>) {
        (S::HAS_STRUCTURE, S::FOLLOWS_ROOTS, S::CHECKS, S::STIRS, method.undivided())
    }
    let (base, start) = (Unmoved { inner: Rattle::new(0.01) }, || State::at([1.0, 0.0, 0.0]));
    let (composed, variable) = (Composition::of(SUZUKI_1990_ORDER_4, base), Variable::of(base, 0.3));
    assert_eq!(properties(&composed), properties(&base));
    assert_eq!(properties(&variable), properties(&base));

    let scene = Scene::on(Ball { r: 1.0 });
    let dragged = scene.with(rattle::effect::LinearDrag::new(1.0));
    let mut still =
        scene.simulate(start().moving([0.0, 1.0, 0.0]), Composition::new(SUZUKI_1990_ORDER_4, 0.01)).unwrap();
    let mut moved = dragged.simulate(start().moving([0.0, 1.0, 0.0]), composed).unwrap();
    still.run(10).unwrap();
    moved.run(10).unwrap();
    assert_eq!(still.position(), moved.position());
}

potential! { struct Pull { k } |q: [f64; 3]| k * dot(q, q) / 2 }

/// What a bath remembers belongs to a scene, whatever the units: accelerations are compared with accelerations alone.
#[test]
fn the_memory_of_another_scene_is_dropped() {
    for unit in [1.0, 1e-21, 1e21] {
        let scene = |mass: f64| Scene::points::<3>(2).mass(mass * unit).with(Pull { k: unit });
        let method = NoseHoover::new(unit, 1.0, 0.1);
        let start = State::of([[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]])
            .with_momenta([[0.0, unit, 0.0], [0.3 * unit, 0.0, unit]]);
        let mut run = scene(1.0).simulate(start, method).unwrap();
        run.run(20).unwrap();
        let reached = run.state();
        let anew = State::of(reached.positions()).with_momenta(reached.momenta());
        for (mass, remembers) in [(1.0, true), (3.0, false)] {
            let ends = [&reached, &anew].map(|state| {
                let mut run = scene(mass).simulate(state.clone(), method).unwrap();
                run.run(5).unwrap();
                run.positions().collect::<Vec<_>>()
            });
            let off = ends[0].iter().zip(&ends[1]).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            assert_eq!(off > 1e-6, remembers, "mass {mass}, unit {unit:e}: {off:e}"); // else rounding
        }
    }
}
