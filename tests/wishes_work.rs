//! Wishes where something does work, and for averages of what grows, by a clock that counts evaluations.

use super::common::larger;
use super::priced::{Counting, FREE, Forces, NONE, OnSurface, Several, double_pendulum, generated, on};
use rattle::Error;
use rattle::bodies::One;
use rattle::effect::{Effects, LinearDrag, MagneticField};
use rattle::error::PriceMistake;
use rattle::prelude::*;
use rattle::price::{Candidate, Clock, Prices};

potential! {
    /// A weight that is shaken.
    struct Shaken { g, a, w }
    |x, _y, z, t| g * z - a * cos(w * t) * x
}

potential! {
    /// A weight.
    struct Weight { g }
    |_x, _y, z| g * z
}

potential! {
    /// A weight in the plane.
    struct Heavy { g }
    |_x, z| g * z
}

constraint! {
    /// A washboard.
    struct Washboard { a }
    |x, z| z - a * cos(x)
}

/// A surface of which evaluations are counted, at a microsecond each, and the clock.
fn sphere() -> (Counted<Several>, Clock) {
    let surface = Counted::new(Several { sphere: 1.0, ..NONE });
    let counts = surface.counts();
    (surface, Clock::of(move || 1e-6 * counts.all() as f64))
}

fn start() -> State<3> {
    State::at([2.0, 0.0, 0.0]).moving([0.0, 0.6, 0.8])
}

/// The largest difference between the energy of a planned run and that of a run with so much shorter steps by this
/// method.
fn off<E: Effects<3>, M: Method>(
    scene: &Scene<Counted<Several>, E, One, 3>,
    mut planned: rattle::price::Planned<3>,
    finer: u64,
    method: impl Fn(f64) -> M,
) -> f64 {
    let mut exact = scene.simulate(start(), method(planned.h / finer as f64)).unwrap();
    let (mut worst, mut steps) = (0.0_f64, 0);
    let mut look = |now: &BoxedSimulation<3>| {
        exact.run(finer).unwrap();
        let off = (now.energy() - exact.energy()).abs();
        worst = larger(worst, off);
        steps += 1;
    };
    planned.simulation.run_with(planned.steps, &mut look).unwrap();
    assert!(steps > 0 && steps == planned.steps);
    worst
}

/// Where a potential changes with time, what the energy and the work are both off by is an error of the energy.
#[test]
fn energies_of_what_is_shaken_are_within_the_wish() {
    let (surface, clock) = sphere();
    let scene = Scene::on(surface).with(Shaken { g: 1.0, a: 0.3, w: 0.3 });
    for (duration, wish) in [(20.0, 1e-2), (100.0, 1e-2), (100.0, 1e-4)] {
        let asked = scene.within(wish).in_energy().budget(8.0).clock(clock.clone());
        let planned = asked.simulate(&start(), duration).unwrap();
        let told = planned.to_string();
        let off = off(&scene, planned, 1, |h| Dop853::adaptive(h, 1e-13));
        assert!(off <= 1.03 * wish, "{duration}, {wish:e}: {told}, in truth {off:e}");
    }
}

/// So it is where drag takes energy. All methods go half of it before each step and half after it, and are off by the
/// same for that.
#[test]
fn energies_under_drag_are_within_the_wish() {
    let (surface, clock) = sphere();
    let scene = Scene::on(surface).with(Weight { g: 1.0 }).with(LinearDrag::new(0.3));
    for (duration, wish) in [(20.0, 1e-2), (20.0, 1e-4)] {
        let asked = scene.within(wish).in_energy().budget(4.0).clock(clock.clone());
        let planned = asked.simulate(&start(), duration).unwrap();
        let told = planned.to_string();
        let off = off(&scene, planned, 20, Lobatto::<5>::new);
        assert!(off <= 1.03 * wish, "{duration}, {wish:e}: {told}, in truth {off:e}");
    }
}

/// What is told is the error, and no mere bound of it: measured against a reference, with what that one is off by. It
/// may be larger at instants at which it is not measured, by a tenth.
fn is_what_is_told(worst: f64, told: f64, reference: f64) -> bool {
    worst < 1.1 * told && told < 1.1 * worst + 2.0 * reference
}

/// The errors of the reference are those of the motion, not the difference of two that are off alike.
#[test]
fn references_under_drag_know_what_they_are_off_by() {
    let (surface, clock) = sphere();
    let scene = Scene::on(surface).with(Weight { g: 1.0 }).with(LinearDrag::new(0.3));
    let prices: Prices = scene.price(&start(), 5.0).budget(1.0).clock(clock).measure().unwrap();
    let mut checked = 0;
    for row in &prices.rows {
        let (Some(told), true) = (row.position, row.steps < 20_000 && row.method == Candidate::Lobatto5)
        else {
            continue;
        };
        let mut own = scene.simulate(start(), Lobatto::<5>::new(row.h)).unwrap();
        let mut exact = scene.simulate(start(), Lobatto::<5>::new(row.h / 20.0)).unwrap();
        let mut worst = 0.0_f64;
        own.run_with(row.steps, |now| {
            exact.run(20).unwrap();
            worst = larger(worst, (now.position() - exact.position()).norm());
        })
        .unwrap();
        assert!(
            is_what_is_told(worst, told, prices.reference_error),
            "told {told:e}, in truth {worst:e}: h = {}\n{prices:#}",
            row.h
        );
        checked += 1;
    }
    assert!(checked > 2, "{checked}\n{prices:#}");
}

/// An average of what the error makes run away is farther off at the end of a run than on the pilot.
#[test]
fn averages_of_what_grows_are_within_the_wish_beyond_the_pilot() {
    let surface = Counted::new(Washboard { a: 0.3 });
    let counts = surface.counts();
    let clock = Clock::of(move || 1e-6 * counts.all() as f64);
    let scene = Scene::on(surface).with(Heavy { g: 1.0 });
    let start = State::at([0.0, 0.3]).moving([1.3, 0.0]);
    let x = |now: &BoxedSimulation<2>| now.positions().next().unwrap().x;
    let mut longer = 0;
    for (duration, wish, budget) in [(2e3, 1e-1, 0.3), (2e3, 1e-2, 0.3), (2e4, 1.0, 0.3)] {
        let asked = scene.within(wish).in_average("x", x).budget(budget).clock(clock.clone());
        let mut planned = match asked.simulate(&start, duration) {
            Ok(planned) => planned,
            Err(Error::Price(PriceMistake::Unreachable { .. })) => continue,
            Err(error) => panic!("{error}"),
        };
        let told = format!("{planned}, pilot {}", planned.prices.pilot);
        longer += usize::from(planned.prices.pilot < 0.5 * duration);
        // The same instants by shorter steps of high order, and their trapezoidal sums: what states are off by.
        let h = duration / planned.steps as f64;
        let parts = (h / 0.1).ceil();
        let mut exact = scene.simulate(start.clone(), Lobatto::<5>::new(h / parts)).unwrap();
        let (mut sum, mut off) = (0.0, 0.0);
        planned
            .simulation
            .run_with(planned.steps, |now| {
                exact.run(parts as u64).unwrap();
                sum += exact.position().x;
                off += now.positions().next().unwrap().x - exact.position().x;
            })
            .unwrap();
        let off = (off / planned.steps as f64).abs();
        assert!(sum > 0.0 && off <= wish, "{duration}, {wish:e}: {told}, in truth {off:e}");
    }
    assert!(longer > 0);
}

/// A magnetic field does no work: in chaos too the energy is told, by what it changes by.
#[test]
fn a_magnetic_field_does_no_work() {
    let chaotic = double_pendulum(160.0);
    let clock = chaotic.clock();
    let (scene, wish) = (chaotic.scene.with(MagneticField::new([0.0, 0.0, 0.3])), 1e-3);
    let asked = scene.within(wish).in_energy().budget(4.0).clock(clock);
    let mut planned = asked.simulate(&chaotic.start, chaotic.duration).unwrap();
    let prices = &planned.prices;
    assert!(prices.predictable.is_some_and(|time| time < chaotic.duration), "{prices}");
    assert!(prices.reference_energy_error.is_none());
    let (told, mut worst) = (planned.to_string(), 0.0_f64);
    planned
        .simulation
        .run_with(planned.steps, |now| worst = larger(worst, now.energy_error().abs()))
        .unwrap();
    assert!(worst > 0.0 && worst <= 1.03 * wish, "{told}, in truth {worst:e}");

    // Drag does, beside a field too.
    let (surface, clock) = sphere();
    let scene = Scene::on(surface).with(LinearDrag::new(0.3)).with(MagneticField::new([0.0, 0.0, 0.3]));
    let prices = scene.price(&start(), 2.0).budget(1.0).clock(clock).measure().unwrap();
    assert!(prices.reference_energy_error.is_some(), "{prices}");
}

constraint! {
    /// A track with a narrow bump.
    struct Track { a, w, at }
    |x, z| z - a * exp(-((x - at) / w)^2)
}

/// A reference under drag is found where steps fail that are long enough elsewhere, or that are twice as long; and what
/// it is off by is known.
#[test]
fn references_under_drag_are_found_where_longer_steps_fail() {
    let mut checked = 0;
    for w in [0.0194, 0.0119] {
        let surface = Counted::new(Track { a: 0.3 * w, w, at: 3.0 });
        let counts = surface.counts();
        let clock = Clock::of(move || 1e-6 * counts.all() as f64);
        let scene = Scene::on(surface).with(LinearDrag::new(1e-2));
        let start = scene.project(&State::at([0.0, 0.0]).moving([1.0, 0.0])).unwrap();
        let prices = scene.price(&start, 5.0).budget(0.15).clock(clock).measure();
        let prices = prices.unwrap_or_else(|error| panic!("{w}: {error}"));
        println!("{w}: {prices:#}");
        for row in prices.rows.iter().filter(|row| row.method == Candidate::Rattle) {
            let parts = (row.h / 2e-4).ceil();
            let mut own = scene.simulate(start.clone(), Rattle::new(row.h)).unwrap();
            let mut exact = scene.simulate(start.clone(), Lobatto::<3>::new(row.h / parts)).unwrap();
            let mut worst = 0.0_f64;
            own.run_with(row.steps, |now| {
                exact.run(parts as u64).unwrap();
                worst = larger(worst, (now.position() - exact.position()).norm());
            })
            .unwrap();
            let told = row.position.unwrap();
            assert!(
                is_what_is_told(worst, told, prices.reference_error),
                "{w}: told {told:e}, in truth {worst:e}: h = {}",
                row.h
            );
            checked += 1;
        }
    }
    assert!(checked > 2, "{checked}");
}

/// An average may be exact to the last bit though states are off: that is no error that grows without end.
#[test]
fn averages_that_are_exact_are_taken() {
    let surface = Counted::new(Several { sphere: 1.0, ..NONE });
    let counts = surface.counts();
    let clock = Clock::of(move || 1e-6 * counts.all() as f64);
    let scene = Scene::on(surface);
    let radius = |now: &BoxedSimulation<3>| now.positions().next().unwrap().norm();
    let duration = 1e4;
    let asked = scene.within(1e-9).in_average("radius", radius).budget(0.3).clock(clock);
    let planned = asked.simulate(&start(), duration).unwrap();
    let rows = || planned.prices.rows.iter();
    let exact = rows().filter(|row| row.averages[0] == 0.0 && row.drifts[0][0] > 0.0).count();
    assert!(exact > 0 && planned.prices.pilot < 0.5 * duration, "{exact}, {:#}", planned.prices);
    let least = rows().map(|row| row.seconds).fold(f64::INFINITY, f64::min) * duration;
    assert!(planned.seconds <= least, "{planned}, {least}\n{:#}", planned.prices);
}

/// Released from an angle, with a push sideways.
fn released(angle: f64, duration: f64) -> OnSurface {
    let (sin, cos) = angle.sin_cos();
    let start = State::at([2.0 * sin, 0.0, -2.0 * cos]).moving([0.0, 0.3, 0.0]);
    on("pendulum", Several { sphere: 1.0, ..NONE }, Forces { g: 2.0, ..FREE }, start, duration)
}

fn rough(seed: u64, duration: f64) -> OnSurface {
    Counting { duration, ..generated(seed) }
}

/// By methods with a tolerance positions go astray with the square of time, though a short pilot does not show it.
#[test]
fn positions_by_methods_with_a_tolerance_are_within_the_wish_beyond_the_pilot() {
    for (scene, wish, budget) in
        [(released(2.8, 500.0), 1e-4, 0.3), (rough(0, 100.0), 1e-6, 0.1), (rough(1, 100.0), 1e-2, 0.3)]
    {
        let mut planned = scene.within(wish, budget).unwrap();
        let told = planned.to_string();
        let exact = Dop853::adaptive(planned.h, 1e-13);
        let mut exact = scene.scene.simulate(scene.start.clone(), exact).unwrap().retry(6);
        let mut farthest = 0.0_f64;
        let look = |now: &BoxedSimulation<3>| {
            exact.step().unwrap();
            let off = (now.positions().next().unwrap() - exact.position()).norm();
            farthest = larger(farthest, off);
        };
        planned.simulation.run_with(planned.steps, look).unwrap();
        assert!(farthest > 0.0 && farthest <= wish, "{}: {told}, in truth {farthest:e}", scene.name);
        assert!(planned.prices.pilot < 0.1 * scene.duration && told.contains(", as the first "), "{told}");
    }
}

/// Their energy drifts with time.
#[test]
fn energies_by_methods_with_a_tolerance_are_within_the_wish_beyond_the_pilot() {
    for (scene, wish, budget) in
        [(released(1.5, 1000.0), 1e-8, 1.0), (rough(0, 1000.0), 1e-6, 0.3), (rough(3, 1000.0), 1e-6, 1.0)]
    {
        let asked = scene.scene.within(wish).in_energy().budget(budget).clock(scene.clock());
        let mut planned = asked.simulate(&scene.start, scene.duration).unwrap();
        let (told, mut worst) = (planned.to_string(), 0.0_f64);
        let look = |now: &BoxedSimulation<3>| worst = larger(worst, now.energy_error().abs());
        planned.simulation.run_with(planned.steps, look).unwrap();
        assert!(worst > 0.0 && worst <= wish, "{}: {told}, in truth {worst:e}", scene.name);
        assert!(planned.prices.pilot < 0.1 * scene.duration, "{told}");
    }
}
