//! Steps taken back: on request after every step, and over long ways.

use crate::common::*;
use rattle::bodies::Bodies;
use rattle::method::{Failure, Witness};
use rattle::need::Kicks;
use rattle::prelude::*;
use rattle::real::Scalar;
use rattle::system::System;
use rattle::{Error, Geodesic, nalgebra};

#[test]
fn symmetric_methods_pass_and_go_on_as_without_the_check() {
    fn check<S: Method>(method: S) {
        let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
        let mut plain = scene.simulate(billiard(0.7), method.clone()).unwrap();
        let mut checked =
            scene.simulate(billiard(0.7), method.clone()).unwrap().check_reversal(1e-14).unwrap();
        plain.run(300).unwrap();
        let allocated = allocation_counter::measure(|| checked.run(300).unwrap());
        assert_eq!(bits(&checked.state()), bits(&plain.state()), "{}", method.name());
        assert_eq!((checked.steps(), checked.time(), allocated.count_total), (300, plain.time(), 0));
    }
    check(Rattle::new(0.01));
    check(Rattle::new(0.01).guess(Extrapolated));
    check(Geodesic::new(3, 0.01));
    check(PositionVerlet::new(0.01));
    check(Composition::new(SUZUKI_1990_ORDER_4, 0.01));
    check(Lobatto::<5>::new(0.02));
    check(Lobatto::<5>::new(0.02).guess(Extrapolated));
}

/// Symplectic Euler, which says that it is symmetric.
#[derive(Debug, Clone, Copy)]
struct Pretending(SymplecticEuler);

impl Method for Pretending {
    type Memory<T: Scalar> = [T; 0];
    type Need = Kicks;

    fn step_size(&self) -> f64 {
        self.0.step_size()
    }
    fn order(&self) -> u32 {
        1
    }
    fn name(&self) -> &'static str {
        "pretending"
    }
    fn with_step(&self, h: f64) -> Self {
        Self(self.0.with_step(h))
    }
    fn is_symmetric(&self) -> bool {
        true
    }
    fn step<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: &Y,
        bodies: &mut Bodies<Y::Count, T, Y::Kept, D>,
        memory: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        self.0.step(system, bodies, memory, witness)
    }
}

#[test]
fn steps_that_do_not_reverse_are_refused_and_leave_no_trace() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let simulation = scene.simulate(billiard(0.7), Pretending(SymplecticEuler::new(0.01))).unwrap();
    let mut simulation = simulation.check_reversal(1e-14).unwrap();
    let was = simulation.state();
    let error = simulation.step().unwrap_err();
    let Error::NotReversed { step: 1, body: 0, off, tolerance: 1e-14, .. } = error else { panic!("{error}") };
    assert!((1e-9..1e-3).contains(&off), "{error}"); // of the size of an error of the step; the start is a flat point
    assert_eq!(bits(&simulation.state()), bits(&was));
    assert_eq!(simulation.step().unwrap_err().to_string(), error.to_string(), "and again");

    // A tolerance below rounding refuses what is right.
    let strict = scene.simulate(billiard(0.7), Rattle::new(0.01)).unwrap().check_reversal(1e-300);
    assert!(matches!(strict.unwrap().run(100), Err(Error::NotReversed { .. })));
}

#[test]
fn what_cannot_be_checked_is_refused_at_once() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    for tolerance in [-1.0, 0.0, f64::INFINITY, f64::NAN] {
        let error = scene.simulate(billiard(0.7), Rattle::new(0.01)).unwrap().check_reversal(tolerance);
        assert!(matches!(error.unwrap_err(), Error::Tolerance(_)), "{tolerance}");
    }
    fn refused<S: Method>(method: S) {
        let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
        let start = scene.staggered(&billiard(0.7), &method).unwrap();
        let error = scene.simulate(start, method).unwrap().check_reversal(1e-14).unwrap_err();
        let Error::NeedsSymmetricMethod { what: "a check of reversal", .. } = error else {
            panic!("{error}")
        };
    }
    refused(SymplecticEuler::new(0.01));
    refused(Shake::new(0.01));
    refused(Dop853::new(0.01));
    refused(Bdf2::new(0.01));
    refused(Variable::of(Rattle::new(0.01), 0.3)); // symmetric only with what it remembers
}

/// A ball that falls from the top of a sphere, until steps are too long and are taken in parts.
#[test]
fn steps_in_parts_are_taken_back_in_parts() {
    fn falling<S: Method>(method: S) -> Simulation<impl System<f64, 3, Count = rattle::bodies::One>, S, 3> {
        let start = State::at([0.0, 0.0, 1.0]).moving([0.2, 0.0, 0.0]);
        Scene::on(Sphere { r: 1.0 }).with(Gravity { g: 1.0 }).simulate(start, method).unwrap()
    }
    /// Places and momenta, without what is remembered.
    fn bodies(state: &State<3>) -> String {
        let all = bits(state);
        all[..all.find("time").unwrap()].to_owned()
    }
    fn check<S: Method>(method: S) {
        let h = method.step_size();
        let scene = Scene::on(Sphere { r: 1.0 }).with(Gravity { g: 1.0 });
        let mut checked = falling(method.clone()).retry(5).check_reversal(1e-12).unwrap();
        let (mut divided, mut alone) = (0, 0);
        for _ in 0..100 {
            // In as few parts as lead back by hand.
            let start = checked.state();
            let in_parts = |parts: u32| {
                let method = method.with_step(h / f64::from(parts));
                let mut forth = scene.simulate(start.clone(), method.clone()).unwrap();
                forth.run(parts.into()).ok()?;
                let back = method.with_step(-method.step_size());
                let mut back = scene.simulate(forth.state(), back).unwrap();
                let off = back.run(parts.into()).map_or(f64::INFINITY, |()| {
                    let (q, p) = (start.positions().next().unwrap(), start.momenta().next().unwrap());
                    distance(back.position(), q).max(distance(back.momentum(), p))
                });
                let size = start.positions().chain(start.momenta()).map(|x| x.amax()).fold(0.0, f64::max);
                Some((bodies(&forth.state()), off <= 1e-12 * size))
            };
            let tries: Vec<_> = [1, 2, 4, 8, 16, 32].map(in_parts).into_iter().collect();
            let first = tries.iter().position(|tried| tried.as_ref().is_some_and(|tried| tried.1)).unwrap();
            checked.step().unwrap();
            assert_eq!(bodies(&checked.state()), tries[first].as_ref().unwrap().0, "{}", method.name());
            divided += u32::from(first > 0);
            alone += u32::from(tries[..first].iter().any(Option::is_some));
        }
        println!(
            "{}: {divided} steps divided, {alone} of them although fewer parts could be taken",
            method.name()
        );
        assert!(divided > 0);
    }
    check(Rattle::new(0.7));
    check(Rattle::new(0.7).guess(LastMultiplier));
    check(Rattle::new(0.7).solved_by(Broyden));
    check(Geodesic::new(2, 1.6));
    check(Composition::new(SUZUKI_1990_ORDER_4, 1.0));
    let error =
        falling(Pretending(SymplecticEuler::new(0.7))).retry(5).check_reversal(1e-12).unwrap().run(100);
    assert!(matches!(error, Err(Error::NotReversed { .. })));
}

constraint! {
    /// Above a floor that is far away.
    struct Far {}
    |_x, _y, z| z + 10
}

/// Where contacts are looked for, steps that fail, or do not lead back, are taken in the same parts as without.
#[test]
fn steps_in_parts_look_for_contacts() {
    let mut divided = 0;
    for i in 0..60 {
        let scene = Scene::on(Sphere { r: 1.0 }).with(Gravity { g: if i % 2 == 0 { 1.0 } else { 2.0 } });
        let start = State::at([0.0, 0.0, 1.0]).moving([0.1 + 0.005 * f64::from(i), 0.03, 0.0]);
        let begin = || scene.simulate(start.clone(), Rattle::new(0.7)).unwrap().retry(5);
        let floor = || rattle::effect::Stop::above(Far {});
        let (mut free, mut stopped) = (begin(), begin().collide(floor()).unwrap());
        let mut checked = begin().check_reversal(1e-12).unwrap();
        let mut both = begin().check_reversal(1e-12).unwrap().collide(floor()).unwrap();
        for _ in 0..60 {
            let mut whole = scene.simulate(checked.state(), Rattle::new(0.7)).unwrap();
            let went = whole.step();
            free.step().unwrap();
            stopped.step().unwrap();
            checked.step().unwrap();
            both.step().unwrap();
            assert_eq!(bits(&stopped.state()), bits(&free.state()));
            assert_eq!(bits(&both.state()), bits(&checked.state()));
            divided += u32::from(went.is_ok() && whole.position() != checked.position());
        }
    }
    assert!(divided > 3, "{divided} that could be taken as a whole, and do not lead back");
}

/// How much a small change of the state at the turning point has grown at most on the way back: what the roundings of
/// the way may have grown by.
fn growth<S: Method>(at_turn: &State<3>, method: &S, n: u64) -> f64 {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let small = 1e-7;
    let mut most = 1.0_f64;
    let back = method.with_step(-method.step_size());
    for direction in 0..6 {
        let shifted = |x: nalgebra::SVector<f64, 3>, first: usize| {
            nalgebra::SVector::<f64, 3>::from_fn(|d, _| {
                x[d] + if first + d == direction { small } else { 0.0 }
            })
        };
        let moved = State::of(at_turn.positions().map(|q| shifted(q, 0)))
            .with_momenta(at_turn.momenta().map(|p| shifted(p, 3)));
        let moved = scene.project(&moved).unwrap();
        let mut one = scene.simulate(at_turn.clone(), back.clone()).unwrap();
        let mut other = scene.simulate(moved, back.clone()).unwrap();
        for _ in 0..n {
            one.step().unwrap();
            other.step().unwrap();
            let apart =
                distance(one.position(), other.position()).max(distance(one.momentum(), other.momentum()));
            most = most.max(apart / small);
        }
    }
    most
}

/// After n steps forth and n back every reversible method is where it began, up to two roundings of three momenta (4ε)
/// and those of the way, √n of them, that have grown as small changes of the state do. Low parts leave of each rounding
/// that of a step's increment, well below a tenth.
#[test]
#[cfg(long)]
fn long_ways_lead_back() {
    fn check<S: Method>(name: &str, method: S) {
        let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
        let mut on_the_way = scene.simulate(billiard(0.7), Rattle::new(0.01)).unwrap();
        on_the_way.run(77).unwrap(); // where nothing is symmetric
        let start = on_the_way.state();
        for n in [1, 5, 20, 300] {
            let mut forth = scene.simulate(start.clone(), method.clone()).unwrap();
            forth.run(n).unwrap();
            let turn = forth.state();
            let mut back = scene.simulate(turn.clone(), method.with_step(-method.step_size())).unwrap();
            back.run(n).unwrap();
            let (q, p) = (start.positions().next().unwrap(), start.momenta().next().unwrap());
            let off = distance(back.position(), q).max(distance(back.momentum(), p));
            let growth = growth(&turn, &method, n);
            let allowed = f64::EPSILON * (4.0 + 0.1 * (n as f64).sqrt() * growth);
            println!("{name:40} {n:5}: {off:.1e}, allowed {allowed:.1e}, growth {growth:.1e}");
            assert!(off <= allowed, "{name}, {n} steps: {off:e}, allowed {allowed:e}");
        }
    }
    check("RATTLE", Rattle::new(0.01));
    check("RATTLE, extrapolated", Rattle::new(0.01).guess(Extrapolated));
    check("RATTLE, last multiplier", Rattle::new(0.01).guess(LastMultiplier));
    check("RATTLE, symmetric", Rattle::new(0.01).solved_by(Symmetric));
    check("RATTLE, simplified", Rattle::new(0.01).solved_by(Simplified));
    check("RATTLE, Broyden", Rattle::new(0.01).solved_by(Broyden));
    check("geodesic RATTLE", Geodesic::new(4, 0.01));
    check("position Verlet", PositionVerlet::new(0.01));
    for coefficients in rattle::composition::ALL {
        check(coefficients.name, Composition::new(coefficients, 0.01));
    }
    check("geodesic RATTLE, Suzuki", Composition::of(SUZUKI_1990_ORDER_4, Geodesic::new(4, 0.01)));
    check("position Verlet, Suzuki", Composition::of(SUZUKI_1990_ORDER_4, PositionVerlet::new(0.01)));
    check("Lobatto, 2 stages", Lobatto::<2>::new(0.01));
    check("Lobatto, 3 stages", Lobatto::<3>::new(0.01));
    check("Lobatto, 5 stages", Lobatto::<5>::new(0.01));
    check("Lobatto, 5 stages, extrapolated", Lobatto::<5>::new(0.01).guess(Extrapolated));
    check("Lobatto, 9 stages", Lobatto::<9>::new(0.01));
}
