//! Prices of motions that start near the origin, in any unit, of steps that get too long later, and what is told then;
//! of energies with any zero.

use crate::priced::{FREE, Forces, NONE, Several, on};
use rattle::Error;
use rattle::error::{Limit, PriceMistake};
use rattle::potentials::Harmonic;
use rattle::prelude::*;
use rattle::price::{Candidate, Clock, Prices};
use rattle::surfaces::Plane;
use std::f64::consts::FRAC_PI_2;
use std::sync::atomic::{AtomicU32, Ordering};

const FLOOR: Plane = Plane { a: 0.0, b: 0.0, c: 1.0, d: 0.0 };

/// A body on a spring in a plane, its evaluations a microsecond each.
fn prices(start: &State<3>, stiffness: f64, duration: f64) -> Result<Prices, Error> {
    let spring = Counted::new(Harmonic { stiffness, centre: [0.0; 3] });
    let counts = spring.counts();
    let clock = Clock::of(move || 1e-6 * counts.all() as f64);
    Scene::on(FLOOR).with(spring).price(start, duration).budget(0.3).clock(clock).measure()
}

/// Neither the unit of length nor the origin decides what a tolerance is: from the origin, or a rounding beside it,
/// rows are those of the same motion in another unit.
#[test]
fn tolerances_have_the_size_of_the_motion() {
    let rows = |unit: f64, x: f64| {
        let start = State::at([x, 0.0, 0.0]).moving([0.6 * unit, 0.8 * unit, 0.0]);
        let prices = prices(&start, 1.0, 5.0).unwrap();
        assert!(prices.reference_error < 1e-13 * unit, "unit {unit:e}, x = {x:e}: {prices}");
        let rows = prices.rows.into_iter().filter(|row| row.method == Candidate::Dop853);
        rows.map(|row| row.position.unwrap() / unit).collect::<Vec<_>>()
    };
    let home = rows(1.0, 0.0);
    assert!(home.len() > 5 && home.iter().any(|off| *off < 1e-12), "{home:?}");
    for (unit, x) in [(2_f64.powi(-30), 0.0), (2_f64.powi(23), 0.0), (1.0, 1.2e-16)] {
        let found = rows(unit, x);
        assert_eq!(found.len(), home.len(), "unit {unit:e}, x = {x:e}: {found:?} {home:?}");
        for (a, b) in found.iter().zip(&home) {
            assert!((a - b).abs() < 0.01 * b + 1e-13, "unit {unit:e}, x = {x:e}: {found:?} {home:?}");
        }
    }
}

/// What a simulation starts from has a price.
#[test]
fn starts_are_as_near_as_for_simulations() {
    let start = State::at([0.0, 0.0, 0.3 - 0.1 * 3.0]).moving([1.0, 0.0, 0.0]);
    Scene::on(FLOOR).simulate(start.clone(), Rattle::new(0.01)).unwrap();
    let priced = prices(&start, 1.0, 5.0).unwrap();
    assert!(priced.rows.len() > 20, "{priced}");
    let off = State::at([0.0, 0.0, 1e-3]).moving([1.0, 0.0, 0.0]);
    let refused = prices(&off, 1.0, 5.0);
    assert!(matches!(refused, Err(Error::Start { .. })), "{refused:?}");
}

/// What limits an energy is measured in energies, which here are 1e-20 where lengths are 2.
#[test]
fn limits_of_energies_are_energies() {
    let start = State::at([2.0, 0.0, 0.0]).moving([0.0, 0.6e-10, 0.8e-10]);
    let forces = Forces { wave: 1e-20, ..FREE };
    let slow = on("slow", Several { sphere: 1.0, ..NONE }, forces, start, 5e10);
    let mut short = 0;
    for budget in [0.02, 0.03, 0.04, 0.06, 0.08, 0.12, 0.2] {
        let within = slow.scene.within(1e-50).in_energy().budget(budget).clock(slow.clock());
        match within.simulate(&slow.start, 5e10) {
            Err(Error::Price(PriceMistake::Late { .. })) => {}
            Err(Error::Price(PriceMistake::Unreachable { limit, best, .. })) => {
                let in_time = matches!(limit, Limit::Budget { .. });
                assert!(in_time || best < 1e-32, "{budget}: {best:e}, {limit}");
                short += usize::from(in_time);
            }
            other => panic!("{budget}: {:?}", other.map(|planned| planned.to_string())),
        }
    }
    assert!(short > 0);
}

/// The budget is told as it was given.
#[test]
fn a_budget_is_told_as_it_is_given() {
    let start = State::at([1.0, 0.0, 0.0]);
    let scene = Scene::on(FLOOR).with(Counted::new(Harmonic { stiffness: 1.0, centre: [0.0; 3] }));
    let told = scene.within(1e-6).budget(-1.0).simulate(&start, 5.0).unwrap_err();
    assert!(matches!(told, Error::Price(PriceMistake::NotPositive { value: -1.0, .. })), "{told}");
}

/// A thin plate: where the body starts steps are long that are far too long on the rim. How its neighbours part is
/// known by shorter ones.
#[test]
fn chaos_is_looked_for_with_shorter_steps_where_long_ones_fail() {
    let plate = Several { quadric: 1.0, a: 1.0, b: 1.7, c: 400.0, ..NONE };
    let start = State::at([0.0, 0.1, 0.05]).moving([0.6, 0.3, 0.0]);
    for duration in [20.0, 60.0] {
        let scene = on("plate", plate, Forces { spring: 1.0, ..FREE }, start.clone(), duration);
        let prices = scene.scene.price(&scene.start, duration).budget(3.0).clock(scene.clock()).measure();
        let Prices { rounding, lyapunov_time, predictable, .. } = prices.unwrap();
        println!("{rounding:e} {lyapunov_time:?} {predictable:?}");
        assert!((1e-17..1e-11).contains(&rounding), "{duration}: {rounding:e}");
    }
}

hamiltonian! {
    /// A pendulum, with any zero of its energy.
    struct Pendulum { g, zero }
    |phi, p| p^2 / 2 - g * cos(phi) + zero
}

hamiltonian! {
    /// A body on a spring, whose energy at rest is c².
    struct Fast { c }
    |x, p| sqrt(c^2 * p^2 + c^4) + x^2 / 2
}

hamiltonian! {
    /// The same without that.
    struct Plain {}
    |x, p| p^2 / 2 + x^2 / 2
}

/// Prices by a clock that goes on whenever it is asked.
fn prices_of<H: Hamiltonian<1>>(energy: H, start: &State<1>, duration: f64) -> Prices {
    let calls = AtomicU32::new(0);
    let clock = Clock::of(move || 1e-4 * f64::from(calls.fetch_add(1, Ordering::Relaxed)));
    Scene::hamiltonian(energy).price(start, duration).budget(1.0).clock(clock).measure().unwrap()
}

/// What is added to a Hamiltonian changes no pilot and no row, also where H is zero at the start or negative; from a
/// start at rest too.
#[test]
fn hamiltonians_have_any_zero() {
    let g = 9.81;
    let start = State::at([FRAC_PI_2]).moving([0.0]);
    let found = |zero: f64| {
        let Prices { pilot, reference, rows, .. } = prices_of(Pendulum { g, zero }, &start, 5.0);
        let rows: Vec<_> =
            rows.into_iter().map(|row| (row.method, row.h, row.steps, row.position, row.rounding)).collect();
        (pilot, reference, rows)
    };
    let from_below = found(g);
    assert!(from_below.0 == 5.0 && from_below.2.len() > 10, "{from_below:?}");
    for zero in [0.0, -2.0 * g, 1e3] {
        assert_eq!(found(zero), from_below, "{zero}");
    }
}

/// Energies that are known to little more than what changes in a motion tell no step to be too long.
#[test]
fn large_energies_at_rest_are_no_errors() {
    let start = State::at([5.0]).moving([0.0]);
    let [slow, fast] = [1e2, 3e8].map(|c| prices_of(Fast { c }, &start, 20.0));
    assert!(fast.pilot == 20.0 && slow.pilot == 20.0, "{} {}", slow.pilot, fast.pilot);
    // Where c is large, the motion is that of a slow body: so are the longest steps.
    let longest = |prices: &Prices| prices.rows.iter().map(|row| row.h).fold(0.0, f64::max);
    let plain = prices_of(Plain {}, &start, 20.0);
    assert_eq!(longest(&slow), longest(&plain));
}
