//! Reversible variable steps: order, the way back, and energy where a naive choice of steps loses it.

use crate::common::*;
use rattle::bodies::{Body, One};
use rattle::capability::Rates;
use rattle::error::{MethodFailure, StepFailure};
use rattle::method::{Failure, View, Witness};
use rattle::need::{Steps, WithRates};
use rattle::prelude::*;
use rattle::real::Scalar;
use rattle::system::Parts;
use rattle::system::{BodiesOf, System};
use rattle::{Error, Variable};

/// Steps chosen from the present state alone: what not to do.
#[derive(Debug, Clone, Copy)]
struct Naive {
    longest: f64,
    tau: f64,
}

impl Method for Naive {
    type Memory<T: Scalar> = Vec<T>;
    type Need = (Steps, WithRates);

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
    fn memory<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        _: View<'_, Self, T, Y, D>,
        _: &BodiesOf<Y, T, D>,
    ) -> Vec<T> {
        vec![T::from_f64(0.0)]
    }
    fn time_taken<T: Scalar>(&self, memory: &[T]) -> Option<T> {
        Some(memory[0])
    }
    fn step<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        (system, rates): View<'_, Self, T, Y, D>,
        bodies: &mut BodiesOf<Y, T, D>,
        memory: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        let mut found = vec![[T::from_f64(0.0); D]];
        let _ = rates.evaluate_rates(bodies, &mut found, &mut ());
        let square = |x: &[T; D]| x.iter().map(|x| x.lanes().next().unwrap().powi(2)).sum::<f64>();
        let wanted = 1.0 + self.tau * self.tau * square(&found[0]) / (square(&bodies.p.as_ref()[0]) + 1.0);
        let h = self.longest / wanted.sqrt();
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
    let system = scene().system::<f64>();
    let start = billiard(0.7);
    let (q, p) = (start.positions().next().unwrap().into(), start.momenta().next().unwrap().into());
    let mut bodies = system.bodies(&[Body { q, q_low: [0.0; 3], p, p_low: [0.0; 3] }], 0.0);
    let method = Variable::of(Rattle::new(0.02), 0.3);
    let all = (&system, &system, &system);
    let mut memory: Vec<f64> = method.memory(all, &bodies);
    let density = memory[1];
    let (mut shortest, mut longest) = (f64::INFINITY, 0.0_f64);
    for _ in 0..200 {
        method.step(all, &mut bodies, &mut memory, &mut ()).unwrap();
        (shortest, longest) = (shortest.min(memory[0]), longest.max(memory[0]));
    }
    assert!(longest > 3.0 * shortest, "steps differ: {shortest} … {longest}");
    let mut turned = (bodies.clone(), memory.clone());
    let back = method.with_step(-0.02);
    for _ in 0..200 {
        back.step(all, &mut bodies, &mut memory, &mut ()).unwrap();
    }
    let off = distance(bodies.q[0], q).max(distance(bodies.p[0], p));
    assert!(off <= 1e-12 && (memory[1] - density).abs() <= 1e-11, "{off:e}, {} {density}", memory[1]);

    // The same with momenta turned round, and with them the change of ρ.
    let (bodies, memory) = &mut turned;
    let turn = |p: [f64; 3]| p.map(|p| -p);
    (bodies.p[0], bodies.p_low[0], memory[3]) = (turn(bodies.p[0]), turn(bodies.p_low[0]), -memory[3]);
    for _ in 0..200 {
        method.step(all, bodies, memory, &mut ()).unwrap();
    }
    let off = distance(bodies.q[0], q).max(distance(bodies.p[0], turn(p)));
    assert!(off <= 1e-12 && (memory[1] - density).abs() <= 1e-11, "{off:e}, {} {density}", memory[1]);
}

/// Energy over a long time, in the sharp ends of the surface again and again.
struct Long {
    steps: u64,
    shortest: f64,
    longest: f64,
    /// The largest energy error in each half of the time.
    worst: [f64; 2],
}

fn long<S: Method>(method: S, until: f64) -> Long {
    let mut simulation = scene().simulate(billiard_45(), method).unwrap();
    let mut long = Long { steps: 0, shortest: f64::INFINITY, longest: 0.0, worst: [0.0; 2] };
    while simulation.time() < until {
        let before = simulation.time();
        simulation.step().unwrap();
        let h = simulation.time() - before;
        (long.shortest, long.longest) = (long.shortest.min(h), long.longest.max(h));
        let half = usize::from(simulation.time() > 0.5 * until);
        long.worst[half] = long.worst[half].max(simulation.energy_error().abs());
        long.steps += 1;
    }
    long
}

/// ε = 0.02 and τ = 1/3: steps between 0.002 and 0.02. The energy is no farther off after half of the time than before,
/// and two- to fourfold closer than with as many steps of one length; bounds leave room for the chance in the largest
/// of a chaotic run.
#[test]
fn energy_stays_where_naive_steps_lose_it() {
    let (epsilon, tau, until) = (0.02, 1.0 / 3.0, 600.0);
    let naive = long(Naive { longest: epsilon, tau }, until);
    let rattle = long(Variable::of(Rattle::new(epsilon), tau), until);
    let fixed = long(Rattle::new(until / rattle.steps as f64), until);
    let suzuki = Composition::new(SUZUKI_1990_ORDER_4, epsilon);
    let fourth = long(Variable::of(suzuki, tau), until);
    let fourth_fixed = long(suzuki.with_step(until / fourth.steps as f64), until);
    let all = [
        ("naive", &naive),
        ("RATTLE", &rattle),
        ("as many of one length", &fixed),
        ("order 4", &fourth),
        ("as many of one length", &fourth_fixed),
    ];
    for (name, Long { steps, shortest, longest, worst }) in all {
        println!(
            "{name:22} {steps:6} steps of {shortest:.5} to {longest:.5}, energy {:.1e} {:.1e}",
            worst[0], worst[1]
        );
    }
    let largest = |long: &Long| long.worst[0].max(long.worst[1]);
    let [before, after] = rattle.worst;
    assert!(rattle.longest > 8.0 * rattle.shortest && rattle.longest <= 1.05 * epsilon);
    assert!((0.4..2.5).contains(&(after / before)));
    assert!(naive.worst[1] > 10.0 * after && naive.worst[1] > 1.3 * naive.worst[0]);
    assert!(largest(&rattle) <= 0.8 * largest(&fixed) && largest(&fourth) <= 0.8 * largest(&fourth_fixed));
}

/// Steps that are too long for the change of R lose it; that is told, and nothing happened.
#[test]
fn steps_that_go_astray_are_refused() {
    let mut simulation = scene().simulate(billiard_45(), Variable::of(Rattle::new(0.06), 1.0 / 3.0)).unwrap();
    let error = loop {
        let before = bits(&simulation.state());
        if let Err(error) = simulation.step() {
            assert_eq!(bits(&simulation.state()), before);
            break error;
        }
        assert!(simulation.time() < 200.0, "it goes astray");
    };
    let Error::Step { cause: StepFailure::Method(MethodFailure::Astray { ratio, longest: 0.06 }), .. } =
        error
    else {
        panic!("{error}")
    };
    assert!(!(0.5..=1.5).contains(&ratio), "{error}");
}

/// Where one method stopped another, or the same with another τ, starts anew.
#[test]
fn a_memory_is_that_of_one_method() {
    let method = Variable::of(Rattle::new(0.02), 0.3);
    let mut whole = scene().simulate(billiard(0.7), method).unwrap();
    whole.run(60).unwrap();
    let state = whole.state();
    let blank = state.clone().with_momenta(state.momenta()); // nothing remembered
    fn next<S: Method>(state: &State<3>, method: S) -> String {
        let mut simulation = scene().simulate(state.clone(), method).unwrap();
        simulation.step().unwrap();
        bits(&simulation.state())
    }
    whole.step().unwrap();
    assert_eq!(next(&state, method), bits(&whole.state()));
    assert_ne!(next(&blank, method), bits(&whole.state()), "what is remembered matters");
    // Low parts apart, which a blank state has lost, ρ is that of the place and not of the way there.
    let density = |state: &State<3>, tau: f64| {
        let text = next(state, Variable::of(Rattle::new(0.02), tau));
        let numbers = &text[text.find("numbers: [").unwrap() + 10..];
        let numbers: Vec<f64> =
            numbers[..numbers.find(']').unwrap()].split(", ").map(|x| x.parse().unwrap()).collect();
        numbers[1]
    };
    for tau in [0.31, 3.0] {
        let (with, without) = (density(&state, tau), density(&blank, tau));
        assert!((with / without - 1.0).abs() <= 1e-12, "τ = {tau}: {with}, {without}");
    }
    assert!((density(&state, 0.3) / density(&blank, 0.3) - 1.0).abs() > 1e-6);
}

/// A state of one scene starts anew in another, also where types and sizes are the same: ρ is then that of the new
/// forces.
#[test]
fn a_memory_is_that_of_one_scene() {
    let method = Variable::of(Rattle::new(0.02), 0.3);
    let scene = |g| Scene::on(SURFACE).with(Gravity { g });
    let mut here = scene(1.0).simulate(billiard(0.7), method).unwrap();
    here.run(60).unwrap();
    let state = here.state();
    let blank = state.clone().with_momenta(state.momenta()); // nothing remembered
    let step = |g: f64, state: &State<3>| {
        let mut simulation = scene(g).simulate(state.clone(), method).unwrap();
        simulation.step().unwrap();
        simulation.time() - state.time()
    };
    let off = |g| (step(g, &state) / step(g, &blank) - 1.0).abs();
    let [same, other] = [1.0, 9.0].map(off);
    assert!(same > 1e-6, "what is remembered matters: {same:e}");
    assert!(other <= 1e-12, "{other:e}");
    here.step().unwrap();
    assert_eq!(step(1.0, &state), here.time() - state.time());
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

    // A rod named twice, and a pivot that is moved: probes stay on the constraints, and time and work are put back.
    let double =
        Scene::points(3).pin(0, [0.0, 0.0]).link(linked::Rod { length: 1.0 }, [[0, 1], [1, 2], [1, 0]]);
    let double = double.with(PlanarGravity { g: 1.0 });
    let mut double =
        double.simulate(linked::double_pendulum(), Variable::of(Rattle::new(0.01), 0.3)).unwrap();
    double.run(500).unwrap();
    assert!(
        double.energy_error().abs() < 1e-3 && double.constraint_residual() <= 1e-14,
        "{}",
        double.energy_error()
    );
    let lifted = Scene::point().link_moving(Lifted { length: 1.0 }, [[0]]).with(PlanarGravity { g: 1.0 });
    let mut lifted = lifted.simulate(State::at([0.6, -0.8]), Variable::of(Rattle::new(0.01), 0.3)).unwrap();
    lifted.run(500).unwrap();
    assert!(lifted.work().abs() > 0.1 && lifted.energy_error().abs() < 1e-3, "{}", lifted.energy_error());
}

constraint! {
    /// A rod about a pivot that goes up and down.
    struct Lifted { length }
    |x, y, t| x^2 + (y - (1 - cos(2 * t)) / 5)^2 - length^2
}

constraint! {
    /// A circle whose centre rises.
    struct Rising { w }
    |x, y, t| x^2 + (y - w * t)^2 - 1
}

/// Collocation looks for other sheets over the time that a step really takes. On the circle that rises a body turns as
/// on one that rests.
#[test]
fn collocation_on_links_that_move() {
    let scene = Scene::point().link_moving(Rising { w: 0.7 }, [[0]]);
    let start = State::at([1.0, 0.0]).moving([0.0, 0.7 + 0.9]);
    for h in [0.05, 0.01] {
        let method = Variable::of(Lobatto::<3>::new(h), 0.3);
        let mut run = scene.simulate(start.clone(), method).unwrap();
        run.run_until(5.0).unwrap();
        let (q, t) = (run.position(), run.time());
        let (sin, cos) = (0.9 * t).sin_cos();
        let off = (q.x - cos).hypot(q.y - 0.7 * t - sin);
        assert!(off < 20.0 * h.powi(4), "h = {h}: {off:e} at t = {t}");
    }
}

/// Its base keeps no memory, so a guess that needs one has no effect.
#[test]
fn guesses_of_the_base_have_no_effect() {
    fn end<S: Method>(base: S) -> String {
        let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
        let mut simulation = scene.simulate(billiard_45(), Variable::of(base, 0.3)).unwrap();
        simulation.run(20).unwrap();
        let all = bits(&simulation.state());
        all[..all.find("time").unwrap()].to_owned()
    }
    let plain = end(Rattle::new(0.01));
    assert_eq!(end(Rattle::new(0.01).guess(LastMultiplier)), plain);
    assert_eq!(end(Rattle::new(0.01).guess(Extrapolated)), plain);
    let plain = end(Composition::of(SUZUKI_1990_ORDER_4, Rattle::new(0.01)));
    assert_eq!(end(Composition::of(SUZUKI_1990_ORDER_4, Rattle::new(0.01).guess(LastMultiplier))), plain);
}

/// The probes begin with the forces at the state, though a step that ends with a drift leaves those before it: else ρ
/// goes astray, after 3288 steps of an oscillator.
#[test]
fn steps_that_end_with_a_drift_stay_on_their_density() {
    let spring = Scene::point().with(rattle::potentials::Harmonic { stiffness: 1.0, centre: [0.0; 3] });
    fn stays(simulation: Result<Simulation<impl System<f64, 3>, impl Method, 3>, Error>) {
        let mut simulation = simulation.unwrap();
        let (mut early, mut late) = (0.0_f64, 0.0_f64);
        for step in 0..6000 {
            simulation.step().unwrap();
            let worst = if step < 1000 { &mut early } else { &mut late };
            *worst = worst.max(simulation.energy_error().abs());
        }
        assert!(late < 1.2 * early, "{early:e} at first, {late:e} later");
    }
    let start = || State::at([1.0, 0.0, 0.0]);
    stays(spring.simulate(start(), Variable::of(PositionVerlet::new(0.1), 1.0)));
    let composed = Composition::of(rattle::composition::YOSHIDA_1990_ORDER_4, PositionVerlet::new(0.2));
    stays(spring.simulate(start(), Variable::of(composed, 1.0)));
}

/// p₀² is that of the start of a run, whatever steps were taken in parts since: here near the centre of an orbit, where
/// a new one would be a thousand times as large, and steps no longer short.
#[test]
fn steps_in_parts_leave_the_rule_as_it_was() {
    let scene = Scene::point().with(rattle::potentials::planar::Kepler { mu: 1.0, centre: [0.0; 2] });
    let start = State::at([1.9, 0.0]).moving([0.0, (0.1_f64 / 1.9).sqrt()]);
    let method = Variable::of(Rattle::new(0.4), 0.3);
    let mut whole = scene.simulate(start.clone(), method).unwrap();
    assert!(whole.run(2000).is_err(), "no step is taken in parts");
    let mut simulation = scene.simulate(start, method).unwrap().retry(8);
    let first = simulation.memory()[2];
    simulation.run(2000).unwrap();
    assert_eq!(simulation.memory()[2], first);
}
