//! Reversible variable steps: order, the way back, and energy where a naive choice of steps loses it.

mod common;
use common::*;
use rattle::bodies::{Bodies, Body, One};
use rattle::prelude::*;
use rattle::real::Real;
use rattle::stepper::{Failure, Witness};
use rattle::system::System;
use rattle::{Error, Variable};

/// Steps chosen from the present state alone: what not to do.
#[derive(Debug, Clone, Copy)]
struct Naive {
    longest: f64,
    tau: f64,
}

impl Stepper for Naive {
    type Memory<T: Real> = Vec<T>;

    fn step_size(&self) -> f64 {
        self.longest
    }
    fn order(&self) -> u32 {
        2
    }
    fn name(&self) -> &'static str {
        "naive"
    }
    fn with_step(&self, h: f64) -> Self {
        Self { longest: h, ..*self }
    }
    fn is_symmetric(&self) -> bool {
        false
    }
    fn memory<T: Real, Y: System<T, D>, const D: usize>(
        &self,
        _: &Y,
        _: &Bodies<Y::Count, T, Y::Kept, D>,
    ) -> Vec<T> {
        vec![T::from_f64(0.0)]
    }
    fn time_taken<T: Real>(&self, memory: &[T]) -> Option<T> {
        Some(memory[0])
    }
    fn step<T: Real, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: &Y,
        bodies: &mut Bodies<Y::Count, T, Y::Kept, D>,
        memory: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        let mut rates = vec![[T::from_f64(0.0); D]];
        let _ = system.rates(bodies, &mut rates, &mut ());
        let square = |x: &[T; D]| x.iter().map(|x| x.lanes().next().unwrap().powi(2)).sum::<f64>();
        let wanted = 1.0 + self.tau * self.tau * square(&rates[0]) / (square(&bodies.p.as_ref()[0]) + 1.0);
        let h = 0.5 * self.longest / wanted.sqrt();
        memory[0] = T::from_f64(h);
        Rattle::new(h).step(system, bodies, &mut [], witness)
    }
}

fn scene() -> Scene<Lemniscate, impl rattle::effect::Effects<3> + Clone, One, 3> {
    Scene::on(SURFACE).with(Gravity { g: 1.0 })
}

#[test]
fn second_order_in_the_longest_step() {
    let errors = [0.02, 0.01, 0.005, 0.0025].map(|longest| {
        let mut simulation =
            scene().simulate(billiard_45(), Variable::of(Rattle::new(longest), 0.3)).unwrap();
        while simulation.time() < 1.0 {
            simulation.step().unwrap();
        }
        // The exact place at that time: on from the start by a method of order 16.
        let steps = 40_u32;
        let exact = Lobatto::<9>::new(simulation.time() / f64::from(steps));
        let mut exact = scene().simulate(billiard_45(), exact).unwrap();
        exact.run(steps.into()).unwrap();
        distance(simulation.position(), exact.position())
    });
    println!("{errors:?}");
    assert!((order(&errors) - 2.0).abs() < 0.2, "{errors:?}");
}

#[test]
fn with_what_it_remembers_it_goes_back() {
    let system = scene().lanes::<f64>();
    let start = billiard(0.7);
    let (q, p) = (start.positions().next().unwrap().into(), start.momenta().next().unwrap().into());
    let mut bodies = system.bodies(|_| Body { q, q_low: [0.0; 3], p, p_low: [0.0; 3] }, 0.0);
    let method = Variable::of(Rattle::new(0.02), 0.3);
    let mut memory: Vec<f64> = method.memory(&system, &bodies);
    let density = memory[1];
    let (mut shortest, mut longest) = (f64::INFINITY, 0.0_f64);
    for _ in 0..200 {
        method.step(&system, &mut bodies, &mut memory, &mut ()).unwrap();
        (shortest, longest) = (shortest.min(memory[0]), longest.max(memory[0]));
    }
    assert!(longest > 3.0 * shortest, "steps differ: {shortest} … {longest}");
    let back = method.with_step(-0.02);
    for _ in 0..200 {
        back.step(&system, &mut bodies, &mut memory, &mut ()).unwrap();
    }
    let off = distance(bodies.q[0], q).max(distance(bodies.p[0], p));
    assert!(off <= 1e-12 && (memory[1] - density).abs() <= 1e-11, "{off:e}, {} {density}", memory[1]);
}

/// Over the sharp ends of the surface again and again: steps between 0.001 and 0.01.
#[test]
fn energy_stays_where_naive_steps_lose_it() {
    fn errors<S: Stepper>(method: S) -> ([f64; 2], f64) {
        let mut simulation = scene().simulate(billiard_45(), method).unwrap();
        let (mut means, mut steps) = ([0.0; 2], 0.0);
        for mean in &mut means {
            let (until, mut count) = (simulation.time() + 500.0, 0.0);
            while simulation.time() < until {
                simulation.step().unwrap();
                *mean += simulation.energy_error();
                count += 1.0;
            }
            *mean /= count;
            steps += count;
        }
        (means, steps)
    }
    let (reversible, steps) = errors(Variable::of(Rattle::new(0.03), 0.3));
    let (naive, naive_steps) = errors(Naive { longest: 0.03, tau: 0.3 });
    println!("reversible {reversible:?} in {steps} steps, naive {naive:?} in {naive_steps}");
    let (kept, lost) = ((reversible[1] - reversible[0]).abs(), (naive[1] - naive[0]).abs());
    assert!(kept < 1e-3 && lost > 10.0 * kept, "{kept:e}, naive {lost:e}");
}

#[test]
fn what_makes_no_sense_is_refused() {
    let method = Variable::of(SymplecticEuler::new(0.01), 0.3);
    let error = scene().simulate(billiard_45(), method).unwrap_err();
    assert!(matches!(error, Error::NeedsSymmetricMethod { .. }), "{error}");
    let error = scene().simulate(billiard_45(), Variable::of(Rattle::new(0.01), -1.0)).unwrap_err();
    assert_eq!(error, Error::ChangeTime(-1.0));
}

/// A body at rest far from where forces act, and linked bodies.
#[test]
fn every_system_and_rest() {
    let rest = State::at([0.0, 0.0, SURFACE.r]);
    let mut still = Scene::on(SURFACE).simulate(rest.clone(), Variable::of(Rattle::new(0.01), 0.3)).unwrap();
    still.run(10).unwrap();
    assert_eq!(still.position(), rest.positions().next().unwrap());
    let mut hanging = scene().simulate(billiard_45(), Variable::of(Lobatto::<3>::new(0.05), 0.3)).unwrap();
    let allocated = allocation_counter::measure(|| hanging.run(100).unwrap());
    assert_eq!(allocated.count_total, 0);
    let linked = Scene::on(Pendulum { length: 1.0 }).mass(2.0).with(PlanarGravity { g: 2.0 });
    let start = State::at([1.0, 0.0]);
    let mut linked = linked.simulate(start, Variable::of(Rattle::new(0.05), 0.3)).unwrap();
    let allocated = allocation_counter::measure(|| linked.run(400).unwrap());
    assert_eq!(allocated.count_total, 0);
    assert!(linked.time() > 5.0 && linked.energy_error().abs() < 1e-3);
}
