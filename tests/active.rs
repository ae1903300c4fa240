//! Active particles against exact laws: persistence in the plane, great circles and holonomy on the sphere; order,
//! work, restarts and company. Bounds of means are 4.5 standard deviations, at fixed seeds.

use crate::common::order;
use crate::common::statistics::DEVIATIONS;
use rattle::effect::{Acting, Effect, Interval, Manner, Moment, Rule};
use rattle::effect::{DryFriction, Langevin, LinearDrag, MagneticField, SelfPropulsion};
use rattle::lanes::Lane;
use rattle::links::Rod;
use rattle::nalgebra::{SVector, Vector3};
use rattle::potentials::{Gravity, Wca};
use rattle::prelude::*;
use rattle::real::Real;
use rattle::surfaces::{Plane, Sphere, Torus};
use std::f64::consts::TAU;
use std::sync::{Arc, Mutex};

/// The mean of some numbers is this, within chance and what the step is off by.
fn is(numbers: &[f64], exact: f64, by_step: f64) {
    let n = numbers.len() as f64;
    let mean = numbers.iter().sum::<f64>() / n;
    let sigma = (numbers.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n * (n - 1.0))).sqrt();
    assert!(sigma < 0.06 * exact.abs(), "noise that hides everything: {sigma} of {exact}");
    assert!((mean - exact).abs() < DEVIATIONS * sigma + by_step, "{mean} of {exact} ± {sigma:.1e}");
}

/// `⟨|Δr|²⟩ = 4Dt + 2(v/D_r)² (D_r t − 1 + e^{−D_r t})` and `⟨Δr·u(0)⟩ = (v/D_r)(1 − e^{−D_r t})` (C. Bechinger et al.,
/// Rev. Mod. Phys. 88 (2016) 045006, equations 9 and 10), in the plane and on one in space. A step of h is off by (D_r
/// h)²/12 of what persists.
#[test]
fn persistence_in_the_plane() {
    const N: usize = 1500;
    const H: f64 = 0.05;
    let (force, turning, friction, kt) = (3.0, 2.0, 1.5, 0.4);
    let (v, d) = (force / friction, kt / friction);
    let laws = |time: f64, squares: &[f64], along: &[f64]| {
        let (x, fade) = (turning * time, -(-turning * time).exp_m1());
        let active = 2.0 * (v / turning).powi(2) * (x - fade);
        let by_step = (turning * H).powi(2) / 6.0;
        is(squares, 4.0 * d * time + active, by_step * active);
        is(along, v / turning * fade, by_step * v / turning * fade);
    };
    let method = Brownian::new(friction, kt, 3, H);

    let flat = Scene::points::<2>(N).with(SelfPropulsion::new(force, turning, 1));
    let mut simulation = flat.simulate(State::of([[0.0; 2]; N]), method).unwrap();
    let first: Vec<_> = SelfPropulsion::<2>::headings(simulation.marks()).collect();
    assert!(first.iter().all(|u| (u.norm() - 1.0).abs() < 1e-15));
    for _ in 0..2 {
        simulation.run(15).unwrap();
        let squares: Vec<_> = simulation.positions().map(|q| q.norm_squared()).collect();
        let along: Vec<_> = simulation.positions().zip(&first).map(|(q, u)| q.dot(u)).collect();
        laws(simulation.time(), &squares, &along);
    }

    let slope = Plane { a: 0.6, b: 0.0, c: 0.8, d: 0.0 };
    let start = [0.8, 0.0, -0.6];
    let tilted = Scene::on(slope).bodies(N).with(SelfPropulsion::new(force, turning, 2).headed([start; N]));
    let mut simulation = tilted.simulate(State::of([[0.0; 3]; N]), method).unwrap();
    simulation.run(10).unwrap();
    let squares: Vec<_> = simulation.positions().map(|q| q.norm_squared()).collect();
    let along: Vec<_> = simulation.positions().map(|q| q.dot(&SVector::from(start))).collect();
    laws(simulation.time(), &squares, &along);
    // cos(angle) falls like exp(−D_r t) at the step's end, whatever h.
    let turned: Vec<_> =
        SelfPropulsion::<3>::headings(simulation.marks()).map(|u| u.dot(&SVector::from(start))).collect();
    is(&turned, (-turning * simulation.time()).exp(), 0.0);
}

/// A method and a flow draw numbers of their own, also by equal seeds: displacements tell nothing of turns.
#[test]
fn seeds_of_methods_and_flows_may_be_equal() {
    const N: usize = 4000;
    let flat = Scene::points::<2>(N).with(SelfPropulsion::new(0.0, 1.0, 7).headed(vec![[0.0, 1.0]; N]));
    let mut simulation = flat.simulate(State::of([[0.0; 2]; N]), Brownian::new(1.0, 1.0, 7, 0.01)).unwrap();
    simulation.step().unwrap();
    let turned: Vec<_> = SelfPropulsion::<2>::headings(simulation.marks()).map(|u| -u.x).collect();
    for along in 0..2 {
        let mean = |of: &dyn Fn(usize) -> f64| (0..N).map(of).sum::<f64>() / N as f64;
        let moved: Vec<_> = simulation.positions().map(|q| q[along]).collect();
        let [square, other] = [&moved, &turned].map(|x| mean(&|i| x[i] * x[i]));
        let correlation = mean(&|i| moved[i] * turned[i]) / (square * other).sqrt();
        assert!(correlation.abs() < DEVIATIONS / (N as f64).sqrt(), "{correlation} along {along}");
    }
}

/// With inertia: without noise of momenta ⟨v·u⟩ = F/(γ + D_r) in the end (H. Löwen, J. Chem. Phys. 152 (2020) 040901),
/// by methods that push at the ends of a step or in its middle.
#[test]
fn inertia_lags_behind_the_heading() {
    fn check(method: impl Method) {
        const N: usize = 2000;
        let (force, turning, friction) = (1.0, 1.0, 2.0);
        let active = Scene::points::<2>(N)
            .with(LinearDrag::new(friction))
            .with(SelfPropulsion::new(force, turning, 4));
        let mut simulation = active.simulate(State::of([[0.0; 2]; N]), method).unwrap();
        simulation.run(80).unwrap();
        let headings = SelfPropulsion::<2>::headings(simulation.marks());
        let along: Vec<_> = simulation.velocities().zip(headings).map(|(v, u)| v.dot(&u)).collect();
        is(&along, force / (friction + turning), 1e-3);
    }
    check(Rattle::new(0.05));
    check(Baoab::new(0.05));
}

/// Without noise a heading stays tangent to the great circle, which the particle does not leave by more than rounding,
/// and its way is that of a push against drag: γ²s/F = γt − 1 + e^{−γt}, to second order.
#[test]
fn great_circles() {
    let (q, u): (Vector3<f64>, Vector3<f64>) = (Vector3::new(0.6, 0.0, 0.8), Vector3::new(0.64, 0.6, -0.48));
    assert!(q.dot(&u).abs() < 1e-15 && (u.norm() - 1.0).abs() < 1e-15);
    let (force, friction) = (2.0, 0.5);
    let off = |h: f64| {
        let active = Scene::on(Sphere { r: 1.0 })
            .with(LinearDrag::new(friction))
            .with(SelfPropulsion::new(force, 0.0, 1).headed([(3.0 * u).into()]));
        let mut simulation = active.simulate(State::at(q), Rattle::new(h)).unwrap();
        simulation.run((4.0 / h).round() as u64).unwrap();
        let across = q.cross(&u);
        let heading = SelfPropulsion::<3>::headings(simulation.marks()).next().unwrap();
        assert!(simulation.position().dot(&across).abs() < 1e-13);
        assert!(heading.dot(&across).abs() < 1e-13 && heading.dot(&simulation.position()).abs() < 1e-13);
        assert!((simulation.momentum().normalize() - heading).norm() < 1e-13);
        let way = force / (friction * friction) * (4.0 * friction - 1.0 + (-4.0 * friction).exp());
        (simulation.position() - (q * way.cos() + u * way.sin())).norm()
    };
    // Both halves of a push are along the way, in the direction of their own places: |p| = F t to rounding.
    let free = Scene::on(Sphere { r: 1.0 }).with(SelfPropulsion::new(force, 0.0, 1).headed([u.into()]));
    let mut simulation = free.simulate(State::at(q), Rattle::new(0.1)).unwrap();
    simulation.run(20).unwrap();
    assert!((simulation.momentum().norm() - 2.0 * force).abs() < 1e-13);
    let errors = [0.02, 0.01, 0.005].map(off);
    assert!((1.9..2.1).contains(&order(&errors)), "{errors:?}");
}

/// Around a circle of latitude a heading turns by the solid angle within, 2π (1 − cos θ): in a field B along the axis
/// every particle without pushes goes around once in 2π/B. Each step carries by great circles, so that polygons are
/// measured: of second order.
#[test]
fn holonomy_is_the_solid_angle() {
    for theta in [0.4_f64, 1.0, 1.9] {
        let off = |steps: u32| {
            let ball = Scene::on(Sphere { r: 1.0 })
                .with(MagneticField::new([0.0, 0.0, -1.0]))
                .with(SelfPropulsion::new(0.0, 0.0, 1).headed([[theta.cos(), 0.0, -theta.sin()]]));
            let start = State::at([theta.sin(), 0.0, theta.cos()]).moving([0.0, theta.sin(), 0.0]);
            let mut simulation = ball.simulate(start, Rattle::new(TAU / f64::from(steps))).unwrap();
            simulation.run(u64::from(steps)).unwrap();
            let q = simulation.position();
            let (east, south) = (
                Vector3::new(-q.y, q.x, 0.0).normalize(),
                Vector3::new(q.x * q.z, q.y * q.z, -q.xy().norm_squared()).normalize(),
            );
            let u = SelfPropulsion::<3>::headings(simulation.marks()).next().unwrap();
            // Counterclockwise from south, seen from outside: at the place that the last step has led to.
            let turned = u.dot(&east).atan2(u.dot(&south));
            let exact = TAU * (1.0 - theta.cos());
            ((turned - exact + 0.5 * TAU).rem_euclid(TAU) - 0.5 * TAU).abs()
        };
        let errors = [100, 200, 400].map(off);
        assert!((1.8..2.2).contains(&order(&errors)) && errors[2] < 1e-3, "θ = {theta}: {errors:?}");
    }
}

/// Places and energy balance are of second order on a torus, with a potential and friction beside.
#[test]
fn pushes_are_of_second_order_and_work_is_booked() {
    let active = Scene::on(Torus { major: 1.2, minor: 0.5 })
        .with(Gravity { g: 1.0 })
        .with(DryFriction { coefficient: 0.1 })
        .with(SelfPropulsion::new(0.8, 0.0, 1).headed([[0.3, 1.0, 0.5]]));
    fn end<E: rattle::effect::Effects<3>>(
        scene: &Scene<Torus, E, rattle::bodies::One, 3>,
        h: f64,
        method: impl Method,
    ) -> (SVector<f64, 3>, f64, f64) {
        let start = State::at([1.7, 0.0, 0.0]).moving([0.0, 1.0, 0.5]);
        let mut simulation = scene.simulate(start, method).unwrap();
        simulation.run((2.0 / h).round() as u64).unwrap();
        (simulation.position(), simulation.energy_error().abs(), simulation.work())
    }
    let h = 0.04;
    let (exact, _, _) = end(&active, h / 64.0, Rattle::new(h / 64.0));
    let ends = [h, h / 2.0, h / 4.0].map(|h| end(&active, h, Rattle::new(h)));
    let places = order(&ends.map(|(q, ..)| (q - exact).norm()));
    let energy = order(&ends.map(|(_, error, _)| error));
    assert!((1.8..2.3).contains(&places) && energy > 1.7, "{places:.2}, {energy:.2}");
    let verlet = |h| (end(&active, h, PositionVerlet::new(h)).0 - exact).norm();
    let middle = order(&[h, h / 2.0, h / 4.0].map(verlet));
    assert!((1.8..2.3).contains(&middle), "{middle:.2}");
    assert!(ends[2].2.abs() > 0.1 && ends[2].1 < 1e-3 * ends[2].2.abs(), "work {}", ends[2].2);
}

/// The same bits after a restart, in an ensemble and after a step that is put back; other numbers, other headings.
#[test]
fn headings_are_the_same_in_any_company() {
    let active = Scene::on(Torus { major: 1.2, minor: 0.5 })
        .bodies(3)
        .with(Wca { epsilon: 1.0, sigma: 0.3 }.within(0.3 * 2.0_f64.powf(1.0 / 6.0)).shifted())
        .with(Langevin { friction: 1.0, temperature: 0.1, seed: 3 })
        .with(SelfPropulsion::new(1.0, 0.7, 3));
    let start = State::of([[1.7, 0.0, 0.0], [-0.7, 0.0, 0.0], [0.0, 1.2, 0.5]]);
    let run = |start: State<3>, steps| {
        let mut simulation = active.simulate(start, Baoab::new(0.02)).unwrap();
        simulation.run(steps).unwrap();
        simulation.state()
    };
    let whole = run(start.clone(), 50);
    assert_eq!(run(run(start.clone(), 20), 30), whole);
    let mut ensemble = active.ensemble(vec![start.clone(); 5], Baoab::new(0.02)).unwrap();
    ensemble.run(50);
    assert_eq!(ensemble.state(0), whole);
    let (there, alone) = (ensemble.state(4), run(start.clone().numbered(4), 50));
    assert!(there.positions().eq(alone.positions()) && there.momenta().eq(alone.momenta()));
    assert_ne!(ensemble.state(4).positions().next(), whole.positions().next());

    // A step that fails is put back with its headings: the way around it is as if it had not been tried.
    constraint! {
        /// A plane up to x = 1, where no number is.
        struct Ends {}
        |x, y, z| z + 0 * sqrt(1 - x) + 0 * y
    }
    let short = Scene::on(Ends {}).with(SelfPropulsion::new(1.0, 0.3, 1).headed([[1.0, 0.0, 0.0]]));
    let mut simulation =
        short.simulate(State::at([0.9, 0.0, 0.0]).moving([1.0, 0.0, 0.0]), Rattle::new(0.03)).unwrap();
    let before = loop {
        let before = simulation.state();
        if simulation.step().is_err() {
            break before;
        }
    };
    assert!(simulation.steps() > 1);
    assert_eq!(simulation.state(), before);
}

#[test]
fn what_makes_no_sense_is_refused() {
    let push = || SelfPropulsion::new(1.0, 1.0, 1);
    let start = || State::at([0.0, 0.0, 1.0]);
    let told = |effect: SelfPropulsion<3>| {
        let ball = Scene::on(Sphere { r: 1.0 }).with(effect);
        ball.simulate(start(), Rattle::new(0.1)).unwrap_err().to_string()
    };
    assert!(
        told(SelfPropulsion::new(-1.0, 1.0, 1)).contains("force must be 0 or positive, and finite, found -1")
    );
    assert!(told(SelfPropulsion::new(1.0, f64::NAN, 1)).contains("rotational diffusion must be"));
    assert!(told(push().headed([[1.0, 0.0, 0.0]; 2])).contains("2 numbers were given for 1 body"));
    assert!(told(push().headed([])).contains("0 numbers were given for 1 body"));
    let along = told(push().headed([[0.0, 0.0, 2.0]]));
    assert!(along.contains("the heading [0.0, 0.0, 2.0] of body 0 has no part along the surface"), "{along}");
    let rods = Scene::points::<3>(2).link(Rod { length: 1.0 }, [[0, 1]]).with(push());
    let told =
        rods.simulate(State::of([[0.0; 3], [1.0, 0.0, 0.0]]), Rattle::new(0.1)).unwrap_err().to_string();
    assert!(told.contains("`SelfPropulsion`") && told.contains("each on a surface"), "{told}");
    // Brownian motion has no momenta for drag, and knows pushes.
    let slowed = Scene::on(Sphere { r: 1.0 }).with(push()).with(LinearDrag::new(1.0));
    let told = slowed.simulate(start(), Brownian::new(1.0, 1.0, 1, 0.1)).unwrap_err().to_string();
    assert!(told.contains("Rattle") && !told.contains("Brownian,"), "{told}");
}

/// Headings are a part of the state: they go on with another step size, and by another method; so does the bath of
/// Nosé and Hoover with another step size.
#[test]
fn headings_and_baths_go_on_with_other_steps() {
    let scene = Scene::on(Sphere { r: 1.0 }).with(SelfPropulsion::new(1.0, 0.0, 3));
    let mut run = scene.simulate(State::at([1.0, 0.0, 0.0]), Brownian::new(1.0, 0.0, 1, 0.01)).unwrap();
    run.run(100).unwrap();
    let same = scene.simulate(run.state(), Brownian::new(1.0, 0.0, 1, 0.005)).unwrap();
    let other = scene.simulate(run.state(), Rattle::new(0.01)).unwrap();
    assert_eq!((same.marks(), other.marks()), (run.marks(), run.marks()));

    let scene = Scene::on(Sphere { r: 1.0 }).bodies(3).with(Gravity { g: 1.0 });
    let start = State::of([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let start = start.with_momenta([[0.0, 0.5, 0.0], [0.0, 0.0, 0.5], [0.5, 0.0, 0.0]]);
    let method = |h| NoseHoover::new(1.0, 0.5, h);
    let mut run = scene.simulate(start, method(0.01)).unwrap();
    run.run(100).unwrap();
    let finer = scene.simulate(run.state(), method(0.005)).unwrap();
    assert_eq!(finer.memory(), run.memory());
    let hotter = scene.simulate(run.state(), NoseHoover::new(2.0, 0.5, 0.01)).unwrap();
    assert!(hotter.memory().iter().all(|&x| x == 0.0));
}

/// A flow that does nothing, and notes which random numbers it is handed: where it takes note, and where it acts.
#[derive(Debug, Clone, Default)]
struct Notes([Arc<Mutex<Vec<[u64; 4]>>>; 2]);
/// The kind of effect that notes.
struct Noting;

impl<const D: usize> Effect<D, Noting> for Notes {
    type Acting<T: Real> = Notes;
    fn acting<T: Real>(&self) -> Notes {
        self.clone()
    }
    type Swept<S: Lane, const L: usize> = [Notes; L];
}

impl<T: Real, const D: usize> Acting<T, D> for Notes {
    type Room = ();
    const FLOWS: bool = true;
    const REMEMBERS: bool = true;
    const PUSHES: bool = true;
    fn room(&self, _: usize) {}
    fn manner(&self) -> Manner {
        Manner { rule: Rule::Random, feels: false, pushes: true }
    }
    fn take_note(&self, during: &Interval<'_, T, D>, _: &mut [T]) {
        self.0[0].lock().unwrap().push(during.noise.words(7, 0));
    }
    fn flow(&self, during: &Interval<'_, T, D>, (): &mut (), changes: &mut [[T; D]]) {
        self.0[1].lock().unwrap().push(during.noise.words(7, 0));
        changes.fill([T::from_f64(0.0); D]);
    }
    fn add_forces(&self, _: Moment<'_, T, D>, (): &mut (), _: &mut [[T; D]]) {}
    fn energy(&self, _: Moment<'_, T, D>) -> T {
        T::from_f64(0.0)
    }
}

/// All flows of a scene by one seed: no number is drawn twice, be it where they take note or where they act.
#[test]
fn no_number_is_drawn_twice() {
    fn drawn(method: impl Method) -> [usize; 2] {
        let notes = Notes::default();
        let scene = Scene::point().with(notes.clone()).with(notes.clone());
        let mut simulation = scene.simulate(State::at([0.0, 0.0]), method).unwrap();
        simulation.run(5).unwrap();
        let [noted, acted] = notes.0.map(|list| list.lock().unwrap().clone());
        let mut all = [&noted[..], &acted].concat();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), noted.len() + acted.len());
        [noted.len(), acted.len()]
    }
    // Five steps: two flows that take note twice and act twice, and in Brownian motion once.
    assert_eq!([drawn(Rattle::new(0.1)), drawn(Baoab::new(0.1))], [[20, 20]; 2]);
    assert_eq!(drawn(Brownian::new(1.0, 1.0, 7, 0.1)), [20, 10]);
}

/// A heading that no start can have is refused with the number of that start, as what else is wrong with starts is.
#[test]
fn the_start_without_a_heading_is_named() {
    let swimmers = SelfPropulsion::new(1.0, 0.5, 7).headed([[0.0, 0.0, 1.0]]);
    let scene = Scene::on(Sphere { r: 1.0 }).with(swimmers);
    let start = |i: u32| {
        let height = if i == 37 { 1.0 } else { 0.5 };
        State::at([f64::sqrt(1.0 - height * height), 0.0, height])
    };
    let alone = scene.simulate(start(37), Rattle::new(0.01)).unwrap_err();
    let error = scene.ensemble((0..100).map(start), Rattle::new(0.01)).unwrap_err();
    assert_eq!(error, rattle::Error::Trajectory { trajectory: 37, error: Box::new(alone) });
}
