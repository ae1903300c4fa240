//! Prices of accuracy: orders, errors, wishes met and forecasts kept, by a clock that counts evaluations.
//!
//! Long lists of scenes: `cargo test --release --test price -- --ignored --nocapture`.

mod common;
use common::{PlanarGravity, Row, billiard_45, table};
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use rattle::bodies::{Count, Many, One};
use rattle::effect::{Effects, Langevin, LinearDrag, OnEach, With};
use rattle::error::{Limit, PriceMistake};
use rattle::links::planar::Rod;
use rattle::nalgebra::Matrix3;
use rattle::network::Network;
use rattle::prelude::*;
use rattle::price::{Candidate, Clock, Planned};
use rattle::scene::Hold;
use rattle::{Error, counted::Counts};

const WISHES: [f64; 4] = [1e-4, 1e-6, 1e-8, 1e-11];

constraint! {
    /// Several surfaces in one type, each with its weight: what is compiled once serves all.
    struct Several { sphere, torus, lemniscate, quadric, a, b, c, wave, k }
    |x, y, z| {
        let f = (x^2 + y^2)^2 - (x^2 - y^2);
        let ring = sqrt(x^2 + y^2) - 1;
        sphere * (x^2 + y^2 + z^2 - 4)
            + torus * (ring^2 + z^2 - 0.09)
            + lemniscate * (f^2 + z^2 - 1 / 36)
            + quadric * (a * x^2 + b * y^2 + c * z^2 - 1 + wave * sin(k * x + 0.3) * cos(k * y) * sin(k * z + 0.7))
    }
}

potential! {
    /// Weight, a spring, a wave, and a kink.
    struct Forces { g, spring, wave, kink }
    |x, y, z| g * z + spring * (x - 0.3)^2 / 2 + wave * cos(2 * x + y) * sin(z - y) + kink * abs(x - 0.2)
}

potential! {
    /// Weight of a body whose centre of mass lies on its third axis.
    struct Top { weight }
    |q: [[f64; 3]; 3]| weight * q[2][2]
}

const NONE: Several = Several {
    sphere: 0.0,
    torus: 0.0,
    lemniscate: 0.0,
    quadric: 0.0,
    a: 1.0,
    b: 1.0,
    c: 1.0,
    wave: 0.0,
    k: 1.0,
};
const FREE: Forces = Forces { g: 0.0, spring: 0.0, wave: 0.0, kink: 0.0 };

/// A scene whose evaluations are counted, at a microsecond each.
struct Counting<C, E, N, const D: usize> {
    name: String,
    scene: Scene<C, E, N, D>,
    start: State<D>,
    duration: f64,
    counts: Vec<Counts>,
    /// Positions at the end, of the bodies that come last; none where a series of another order is to tell.
    exact: Option<Vec<f64>>,
}

impl<C: Hold<D>, E: Effects<D>, N: Count, const D: usize> Counting<C, E, N, D> {
    fn clock(&self) -> Clock {
        let counts = self.counts.clone();
        Clock::of(move || 1e-6 * counts.iter().map(|counts| counts.all()).sum::<u64>() as f64)
    }

    fn within(&self, wish: f64, budget: f64) -> Result<Planned<D>, Error> {
        self.scene.within(wish).budget(budget).clock(self.clock()).simulate(&self.start, self.duration)
    }

    /// The exact positions at the end; else by a series of another order and other steps than any reference of prices has.
    fn truth(&self) -> Vec<f64> {
        self.exact.clone().unwrap_or_else(|| {
            let steps = (self.duration / 0.07).ceil();
            let method = Taylor::adaptive(26, self.duration / steps, 1e-18);
            let mut exact = self.scene.simulate(self.start.clone(), method).unwrap();
            exact.run(steps as u64).unwrap();
            exact.positions().flat_map(<[f64; D]>::from).collect()
        })
    }

    /// The farthest that a body is from there.
    fn off(&self, now: &BoxedSimulation<D>, truth: &[f64]) -> f64 {
        let now: Vec<f64> = now.positions().flat_map(<[f64; D]>::from).collect();
        let last = &now[now.len() - truth.len()..];
        let bodies = last.chunks(D).zip(truth.chunks(D));
        let distance =
            |(a, b): (&[f64], &[f64])| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        bodies.map(distance).fold(0.0, f64::max)
    }

    /// Every wish is met, by the forecast, and at little more than the least that any row of the ladder costs.
    fn keeps(&self, wishes: &[f64], budget: f64) {
        let truth = self.truth();
        for &wish in wishes {
            let mut planned =
                self.within(wish, budget).unwrap_or_else(|error| panic!("{} {wish:e}: {error}", self.name));
            let spent = planned.run().unwrap();
            let error = self.off(&planned.simulation, &truth);
            println!("{:24} {wish:8.0e} {error:9.1e}  {planned}", self.name);
            assert!(error <= wish, "{}: {error:e} for {wish:e} by {planned}", self.name);
            let off = spent.seconds / spent.expected - 1.0;
            assert!(off.abs() < 0.15, "{} {wish:e}: {spent}", self.name);
            let met =
                planned.prices.rows.iter().filter(|row| row.position.is_some_and(|error| error <= wish));
            let least = met.map(|row| row.seconds).fold(f64::INFINITY, f64::min) * self.duration;
            assert!(
                planned.seconds <= 1.2 * least,
                "{} {wish:e}: {:e} for {least:e}",
                self.name,
                planned.seconds
            );
        }
    }
}

type OnSurface = Counting<Counted<Several>, With<(), Counted<Forces>, OnEach>, One, 3>;
type Linked = Counting<Network<2>, With<(), Counted<PlanarGravity>, OnEach>, Many, 2>;

fn on(name: &str, surface: Several, forces: Forces, start: State<3>, duration: f64) -> OnSurface {
    let (surface, forces) = (Counted::new(surface), Counted::new(forces));
    let counts = vec![surface.counts(), forces.counts()];
    let scene = Scene::on(surface).with(forces);
    let start = scene.project(&start).unwrap();
    Counting { name: name.into(), scene, start, duration, counts, exact: None }
}

fn exactly<C, E, N, const D: usize>(scene: Counting<C, E, N, D>, exact: &[f64]) -> Counting<C, E, N, D> {
    Counting { exact: Some(exact.to_vec()), ..scene }
}

fn row(name: &str, having: &[(&str, &str)]) -> Row {
    table(name).into_iter().find(|row| having.iter().all(|(column, text)| row.text(column) == *text)).unwrap()
}

fn lemniscate() -> OnSurface {
    let (surface, forces) = (Several { lemniscate: 1.0, ..NONE }, Forces { g: 1.0, ..FREE });
    let exact = row("lemniscate_gravity", &[("theta_deg", "45"), ("ic", "f64"), ("t", "5.0")]);
    exactly(on("lemniscate", surface, forces, billiard_45(), 5.0), &exact.numbers(["x", "y", "z"]))
}

fn sphere() -> OnSurface {
    let start = State::at([2.0, 0.0, 0.0]).moving([0.0, 0.6, 0.8]);
    let (sin, cos) = (2.5_f64.sin(), 2.5_f64.cos());
    exactly(
        on("sphere", Several { sphere: 1.0, ..NONE }, FREE, start, 5.0),
        &[2.0 * cos, 1.2 * sin, 1.6 * sin],
    )
}

fn torus() -> OnSurface {
    let angle = std::f64::consts::FRAC_PI_6;
    let start = State::at([1.3, 0.0, 0.0]).moving([0.0, angle.cos(), angle.sin()]);
    let exact = row("torus_geodesic", &[("case", "30deg"), ("t", "5")]).numbers(["x", "y", "z"]);
    exactly(on("torus", Several { torus: 1.0, ..NONE }, FREE, start, 5.0), &exact)
}

/// Rods in a row from a pin at the origin, or among the bodies.
fn chain(name: &str, lengths: &[f64], start: &[[f64; 2]], g: f64, duration: f64) -> Linked {
    let weight = Counted::new(PlanarGravity { g });
    let rods: Vec<_> = lengths.iter().map(|&length| Counted::new(Rod { length })).collect();
    let counts = rods.iter().map(Counted::counts).chain([weight.counts()]).collect();
    let links = rods.into_iter().enumerate().map(|(i, rod)| (rod, [i, i + 1]));
    let scene = Scene::points(start.len()).link_each(links).pin(0, start[0]).with(weight);
    let start = scene.project(&State::of(start.iter().copied())).unwrap();
    Counting { name: name.into(), scene, start, duration, counts, exact: None }
}

fn pendulum() -> Linked {
    let exact = row("planar_pendulum", &[("theta0", "pi/2"), ("t", "5")]).numbers(["x", "y"]);
    exactly(chain("pendulum", &[1.0], &[[0.0, 0.0], [1.0, 0.0]], 1.0, 5.0), &exact)
}

fn double_pendulum(duration: f64) -> Linked {
    chain("double pendulum", &[1.0, 1.0], &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], 1.0, duration)
}

#[test]
fn orders_and_errors_are_those_of_the_methods() {
    let scene = sphere();
    let prices = scene.scene.price(&scene.start, 5.0).budget(0.2).clock(scene.clock()).measure().unwrap();
    assert!(prices.tells_positions() && prices.lyapunov_time.is_none() && prices.reference_error < 1e-14);
    let (mut orders, mut checked) = (0, 0);
    for row in &prices.rows {
        let error = row.position.unwrap();
        // The error that a run of one's own has against the great circle, at the last look or before.
        if row.method == Candidate::Rattle && error > 1e-9 {
            let mut own = scene.scene.simulate(scene.start.clone(), Rattle::new(row.h)).unwrap();
            let mut worst = 0.0_f64;
            for step in 1..=row.steps {
                own.step().unwrap();
                let (sin, cos) = (0.5 * own.time()).sin_cos();
                if step % (row.steps / 4) == 0 {
                    let exact = rattle::nalgebra::Vector3::new(2.0 * cos, 1.2 * sin, 1.6 * sin);
                    worst = worst.max((own.position() - exact).norm());
                }
            }
            assert!((worst / error - 1.0).abs() < 1e-5, "{worst:e} and {error:e} at h = {}", row.h);
            checked += 1;
        }
        // On a circle every method is of its order long before rounding, to one part in seven.
        let order = f64::from(row.method.order());
        if let (Some(found), true) = (row.order, (1e-12..1e-3).contains(&error) && !row.rounding) {
            assert!((found / order - 1.0).abs() < 0.15, "{}: order {found} at h = {}", row.method, row.h);
            orders += 1;
        }
    }
    assert!(orders > 15 && checked > 5, "{orders} orders, {checked} errors\n{prices}");
    assert!(prices.floor(Candidate::Lobatto5).is_some_and(|floor| floor < 1e-13), "{prices}");
    // The front goes up in time and down in error, and the list of digits lies on it.
    let front: Vec<_> = prices.front().map(|row| (row.seconds, row.position.unwrap())).collect();
    assert!(front.len() > 3 && front.windows(2).all(|pair| pair[0].0 <= pair[1].0 && pair[0].1 >= pair[1].1));
    let digits = prices.digits();
    assert!(digits.len() > 10 && digits.windows(2).all(|pair| pair[0].1 <= pair[1].1), "{digits:?}");
    assert_eq!(prices.csv().lines().count(), prices.rows.len() + 1);
}

#[test]
fn wishes_are_met() {
    lemniscate().keeps(&[1e-4, 1e-8], 4.0);
    pendulum().keeps(&[1e-6, 1e-11], 0.5);
}

#[test]
fn time_is_never_longer_than_asked() {
    for budget in [0.003, 0.03, 0.3] {
        let scene = double_pendulum(5.0);
        let clock = scene.clock();
        let begun = clock.now();
        let measured = scene.scene.price(&scene.start, 5.0).budget(budget).clock(clock.clone()).measure();
        let spent = clock.now() - begun;
        // A quarter of a look's steps are made to their end.
        assert!(spent <= 1.05 * budget + 1e-4, "{spent} of {budget}");
        match measured {
            Ok(prices) => assert!(prices.seconds <= 1.05 * budget + 1e-4 && !prices.rows.is_empty()),
            Err(error) => {
                assert!(budget < 0.1 && matches!(error, Error::Price(PriceMistake::Late { .. })), "{error}")
            }
        }
    }
}

#[test]
fn chaos_is_told() {
    // A double pendulum from such heights has a Lyapunov time of a few units (its exponent is about 0.4).
    let scene = double_pendulum(400.0);
    let prices = scene.scene.price(&scene.start, 400.0).budget(2.0).clock(scene.clock());
    let prices = prices.observe("height", |now| now.positions().nth(2).unwrap().y).measure().unwrap();
    let time = prices.lyapunov_time.unwrap();
    assert!((1.0..8.0).contains(&time), "Lyapunov time {time}");
    let predictable = prices.predictable.unwrap();
    assert!((30.0..250.0).contains(&predictable), "predictable until {predictable}");
    assert!(prices.averages[0].uncertainty > 1e-3 && prices.to_string().contains("chaotic"));

    let error = scene.within(1e-6, 2.0).unwrap_err();
    let Error::Price(PriceMistake::Unreachable { limit: Limit::Chaos { lyapunov_time, .. }, .. }) = &error
    else {
        panic!("{error}")
    };
    assert!((1.0..8.0).contains(lyapunov_time));
    let mut planned = scene
        .scene
        .within(0.02)
        .in_energy()
        .budget(2.0)
        .clock(scene.clock())
        .simulate(&scene.start, 400.0)
        .unwrap();
    planned.run().unwrap();
    assert!(planned.simulation.energy_error().abs() <= 0.02, "{planned}");

    let scene = pendulum();
    let prices = scene.scene.price(&scene.start, 500.0).budget(0.5).clock(scene.clock()).measure().unwrap();
    assert_eq!((prices.lyapunov_time, prices.predictable), (None, None));
}

#[test]
fn what_limits_accuracy_is_named() {
    let scene = pendulum();
    match scene.within(1e-18, 0.5) {
        Err(Error::Price(PriceMistake::Unreachable { limit: Limit::Rounding, best, .. })) => {
            assert!((1e-18..1e-13).contains(&best), "{best:e}");
        }
        other => panic!("{other:?}"),
    }
    match scene.within(1e-11, 0.01) {
        Err(Error::Price(PriceMistake::Unreachable { limit: Limit::Budget { seconds }, best, .. })) => {
            assert!(seconds == 0.01 && best > 1e-11);
        }
        Err(Error::Price(PriceMistake::Late { budget })) => assert_eq!(budget, 0.0075),
        other => panic!("{other:?}"),
    }
    let start = State::at([2.0, 0.0, 0.0]).moving([0.0, 0.6, 0.8]);
    let kinked = on("kink", Several { sphere: 1.0, ..NONE }, Forces { kink: 0.3, ..FREE }, start, 5.0);
    match kinked.within(1e-12, 0.5) {
        Err(Error::Price(PriceMistake::Unreachable { limit: Limit::Kink { order }, best, .. })) => {
            assert!(order < 4.0 && best < 1e-2, "{order} {best:e}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn senseless_wishes_are_refused() {
    let scene = sphere();
    for (wish, budget, duration) in
        [(0.0, 1.0, 5.0), (f64::NAN, 1.0, 5.0), (1e-6, 0.0, 5.0), (1e-6, 1.0, -5.0)]
    {
        let asked = scene.scene.within(wish).budget(budget).simulate(&scene.start, duration);
        assert!(matches!(asked, Err(Error::Price(PriceMistake::NotPositive { .. }))), "{asked:?}");
    }
    let hot = Scene::points::<1>(1).with(Langevin { friction: 1.0, temperature: 1.0, seed: 1 });
    let asked = hot.price(&State::at([0.0]), 5.0).measure();
    assert!(matches!(asked, Err(Error::Price(PriceMistake::Random { .. }))), "{asked:?}");
    let slow = Scene::points::<1>(1).with(LinearDrag::new(1.0));
    let prices = slow.price(&State::at([0.0]).moving([1.0]), 5.0).budget(0.05).measure().unwrap();
    assert!(prices.refused.iter().any(|refused| matches!(refused.why, Some(Error::CannotMove { .. }))));
}

#[test]
fn a_forecast_from_a_pilot_holds() {
    let scene = Counting { duration: 200.0, ..pendulum() };
    let mut planned = scene.within(1e-3, 3.0).unwrap();
    assert!(planned.prices.pilot < 100.0, "{planned}");
    let spent = planned.run().unwrap();
    // A period is 7.4: parts of the run that the pilot did not see cost as much, to the share of a period in it.
    assert!(
        (spent.seconds / spent.expected - 1.0).abs() < 0.15,
        "{spent}: {planned} from {}",
        planned.prices.pilot
    );
    assert!((planned.simulation.time() - 200.0).abs() < 1e-6);
}

/// A body of three different moments of inertia, free or with its weight off the centre.
fn rigid(name: &str, weight: f64) -> Counting<Rigid, With<(), Counted<Top>, OnEach>, One, 9> {
    let weight = Counted::new(Top { weight });
    let counts = vec![weight.counts()];
    let start = Rigid::start(&Matrix3::identity(), &[1.8, 0.4, -0.9].into());
    let scene = Scene::rigid(Rigid::new([0.6, 0.8, 1.0])).with(weight);
    Counting { name: name.into(), scene, start, duration: 1.0, counts, exact: None }
}

/// Numbers of a seed, from 0 to 1.
fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut random = SmallRng::seed_from_u64(seed);
    move || random.random()
}

/// An ellipsoid with waves on it, under weight, a spring and a wave of forces.
fn generated(seed: u64) -> OnSurface {
    let mut next = numbers(seed);
    let mut between = |low: f64, high: f64| low + (high - low) * next();
    let [a, b, c] = [between(0.3, 1.5), between(0.3, 1.5), between(0.3, 1.5)];
    let surface = Several { quadric: 1.0, a, b, c, wave: between(0.0, 0.15), k: between(1.0, 2.5), ..NONE };
    let forces =
        Forces { g: between(-1.0, 1.0), spring: between(0.0, 1.0), wave: between(-0.4, 0.4), kink: 0.0 };
    let place = [between(-0.5, 0.5), between(-0.5, 0.5), 1.0 / c.sqrt()];
    let start = State::at(place).moving([between(-1.0, 1.0), between(-1.0, 1.0), between(-1.0, 1.0)]);
    on(&format!("quadric {seed}"), surface, forces, start, 4.0)
}

/// Two to six rods of random lengths in random directions.
fn generated_chain(seed: u64) -> Linked {
    let mut next = numbers(seed);
    let rods = 2 + (5.0 * next()) as usize;
    let lengths: Vec<f64> = (0..rods).map(|_| 0.5 + next()).collect();
    let mut places = vec![[0.0, 0.0]];
    for (i, length) in lengths.iter().enumerate() {
        let (sin, cos) = (0.2 + 1.2 * next()).sin_cos();
        places.push([places[i][0] + length * sin, places[i][1] - length * cos]);
    }
    chain(&format!("chain of {rods}, {seed}"), &lengths, &places, 1.0, 3.0)
}

/// Whether the estimate is within a factor of 3 of the truth, for runs by some methods and steps that make sense.
fn estimates<C: Hold<D>, E: Effects<D>, N: Count, const D: usize>(scene: &Counting<C, E, N, D>) -> Vec<bool> {
    let truth = scene.truth();
    let mut held = Vec::new();
    for steps in [200_u64, 400, 800] {
        let h = scene.duration / steps as f64;
        held.extend(estimated(scene, &truth, Rattle::new(0.25 * h), 4 * steps));
        held.extend(estimated(scene, &truth, Composition::new(SUZUKI_1990_ORDER_4, h), steps));
        held.extend(estimated(scene, &truth, Lobatto::<4>::new(2.0 * h), steps / 2));
        held.extend(estimated(scene, &truth, Dop853::adaptive(scene.duration / 10.0, 1e-3 * h.powi(3)), 10));
    }
    held
}

fn estimated<C: Hold<D>, E: Effects<D>, N: Count, S: Method, const D: usize>(
    scene: &Counting<C, E, N, D>,
    truth: &[f64],
    method: S,
    steps: u64,
) -> Option<bool> {
    let name = method.name();
    let mut run = scene.scene.simulate(scene.start.clone(), method).unwrap();
    run.run(steps).ok()?;
    let clock = scene.clock();
    let begun = clock.now();
    let estimate = run.estimate_error_by(&scene.start, &clock).unwrap();
    assert!(estimate.seconds > 0.0 && (estimate.seconds - (clock.now() - begun)).abs() < 1e-12, "{estimate}");
    let error = scene.off(&run.boxed(), truth);
    // Below, the error of the reference and the rounding of one run are as large.
    if error < 1e-13 {
        return None;
    }
    let ratio = estimate.position / error;
    let held = (1.0 / 3.0..3.0).contains(&ratio);
    if !held {
        println!("{}: {name} in {steps} steps: {:e} for {error:e}", scene.name, estimate.position);
    }
    Some(held)
}

fn nineteen_of_twenty(held: &[bool], at_least: usize) {
    let kept = held.iter().filter(|held| **held).count();
    println!("{kept} of {} estimates within a factor of 3", held.len());
    assert!(held.len() >= at_least, "{} estimates", held.len());
    assert!(kept as f64 >= 0.95 * held.len() as f64, "{kept} of {}", held.len());
}

#[test]
fn estimates_are_within_a_factor_of_three() {
    let mut held = estimates(&lemniscate());
    held.extend(estimates(&double_pendulum(3.0)));
    held.extend((0..2).flat_map(|seed| estimates(&generated(seed))));
    nineteen_of_twenty(&held, 30);
}

#[test]
#[ignore = "takes a minute: cargo test --release --test price estimates -- --ignored --nocapture"]
fn estimates_of_a_hundred_scenes() {
    let mut held: Vec<_> = (0..60).flat_map(|seed| estimates(&generated(seed))).collect();
    held.extend((0..40).flat_map(|seed| estimates(&generated_chain(seed))));
    nineteen_of_twenty(&held, 800);
}

#[test]
#[ignore = "takes minutes: cargo test --release --test price every_wish -- --ignored --nocapture"]
fn every_wish_is_met_in_every_scene() {
    let budget = 4.0;
    sphere().keeps(&WISHES, budget);
    torus().keeps(&WISHES, budget);
    lemniscate().keeps(&WISHES, budget);
    pendulum().keeps(&WISHES, budget);
    double_pendulum(5.0).keeps(&WISHES, budget);
    let hanging: Vec<_> = (0..=10).map(|i| [0.1 * f64::from(i), 0.0]).collect();
    Counting { exact: None, ..chain("chain of 10", &[0.1; 10], &hanging, 1.0, 1.0) }.keeps(&WISHES, budget);
    let free = row("rigid_body", &[("case", "free"), ("t", "1.0")]);
    let places = std::array::from_fn::<_, 9, _>(|i| free.number(&format!("Q{}{}", i / 3 + 1, i % 3 + 1)));
    exactly(rigid("free body", 0.0), &places).keeps(&WISHES, budget);
    rigid("heavy body", 1.0).keeps(&WISHES, budget);
    (0..10).for_each(|seed| generated(seed).keeps(&WISHES, budget));
    (0..10).for_each(|seed| generated_chain(seed).keeps(&WISHES, budget));
}
