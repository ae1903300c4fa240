//! Who watches and who runs: observers see the same in simulations and in ensembles; runs end when they are told to; a
//! boxed simulation is the same simulation.

use crate::common::linked::Rod;
use crate::common::*;
use rattle::Error;
use rattle::bill::Bill;
use rattle::effect::{Acting, Effect, Moment};
use rattle::lanes::Lane;
use rattle::prelude::*;
use rattle::real::Real;
use rattle::watch::{Each, Observer, Sight};
use std::panic::{AssertUnwindSafe, catch_unwind};

constraint! {
    /// Above a floor in the south of a sphere.
    struct South {}
    |_x, _y, z| z + 0.3
}

constraint! {
    /// Eight faces of the slope 1.
    struct Octahedron {}
    |x, y, z| abs(x) + abs(y) + abs(z) - 1
}

fn scene() -> Scene<Lemniscate, impl rattle::effect::Effects<3> + use<>, rattle::bodies::One, 3> {
    Scene::on(SURFACE).with(Gravity { g: 1.0 })
}

fn pendulum() -> (
    Scene<
        impl rattle::scene::Hold<2> + use<>,
        impl rattle::effect::Effects<2> + use<>,
        rattle::bodies::Many,
        2,
    >,
    State<2>,
) {
    let scene = Scene::points(2)
        .masses([1.0, 2.0])
        .link(Rod { length: 1.0 }, [[0, 1]])
        .pin(0, [0.0, 0.0])
        .with(PlanarGravity { g: 1.0 });
    (scene, State::of([[0.0, 0.0], [1.0, 0.0]]))
}

fn near(a: &[f64], b: &[f64], bound: f64) {
    assert_eq!(a.len(), b.len());
    let off = a.iter().zip(b).fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs()));
    assert!(off <= bound, "{off:e} apart");
}

#[test]
fn every_observer_watches_simulations_and_ensembles() {
    let z = |now: &Sight<'_, 3>| now.position().z;
    let energy = |now: &Sight<'_, 3>| now.energy();
    let bins = Histogram::of(z, -0.2, 0.2, 5).unwrap();
    let shadow = ShadowEnergy::new(4).unwrap();
    let watch = || ((Mean::of(energy), bins.clone()), (Section::of(z), shadow.clone()));
    let mut simulation = scene().simulate(billiard(0.3), Rattle::new(0.01)).unwrap();
    let mut seen = watch();
    simulation.observe(700, 1, &mut seen).unwrap();
    let mut ensemble = scene().ensemble([billiard(0.3)], Rattle::new(0.01)).unwrap();
    let found = ensemble.observe(700, 1, watch);
    let (((mean, bins), (section, shadow)), ((mean_2, bins_2), (section_2, shadow_2))) = (seen, found);
    assert_eq!((mean.number(), shadow.values().len()), (700, 697));
    assert!((mean.mean() - mean_2.mean()).abs() < 1e-12, "{} {}", mean.mean(), mean_2.mean());
    assert_eq!(bins.counts(), bins_2.counts());
    near(shadow.values(), shadow_2.values(), 1e-9);
    assert!(section.crossings().len() > 2);
    let times = |section: &[rattle::watch::Crossing<3>]| section.iter().map(|c| c.time).collect::<Vec<_>>();
    near(&times(section.crossings()), &times(section_2.crossings()), 1e-9);
}

#[test]
fn trajectories_of_an_ensemble_are_kept_apart_and_are_those_of_simulations() {
    let (scene, start) = pendulum();
    let starts = || (0..5).map(|i| start.clone().with_momenta([[0.0, 0.0], [0.0, 0.1 * f64::from(i)]]));
    let mut ensemble = scene.ensemble(starts(), Rattle::new(0.02)).unwrap();
    let shadow = ShadowEnergy::new(2).unwrap();
    let seen = ensemble.observe(100, 7, || Each::of(|| (Trajectory::new(), shadow.clone())));
    for (i, start) in starts().enumerate() {
        let mut alone = scene.simulate(start, Rattle::new(0.02)).unwrap();
        let mut own = Trajectory::of(&alone);
        alone.observe(100, 7, &mut own).unwrap();
        let (path, shadow) = seen.get(i).unwrap();
        assert_eq!((path.shape(), path.times()), ([15, 2, 2], own.times()), "{i}");
        near(path.positions(), own.positions(), 1e-14);
        near(path.momenta(), own.momenta(), 1e-14);
        assert!(shadow.values().is_empty(), "steps are missing between sights");
    }
    assert_eq!(seen.iter().map(|(i, _)| i).collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
}

/// λ and the forces of constraints, asked for at both sights.
struct Asked(Vec<(u64, [Vec<f64>; 2], [f64; 2])>);

impl<const D: usize> Observer<D> for Asked {
    fn see(&mut self, before: &Sight<'_, D>, now: &Sight<'_, D>) {
        let forces = [before, now].map(|sight| sight.constraint_forces().iter().map(|f| f.norm()).sum());
        self.0.push((now.step, [before.multipliers(), now.multipliers()], forces));
    }
    fn join(&mut self, next: Self) {
        self.0.extend(next.0);
    }
}

#[test]
fn sights_tell_multipliers_in_simulations_and_in_lanes() {
    let mut simulation = scene().simulate(billiard(0.3), Rattle::new(0.01)).unwrap();
    let mut expected = vec![(simulation.multiplier(), simulation.constraint_forces()[0].norm())];
    for _ in 0..4 {
        simulation.run(25).unwrap();
        expected.push((simulation.multiplier(), simulation.constraint_forces()[0].norm()));
    }
    let mut again = scene().simulate(billiard(0.3), Rattle::new(0.01)).unwrap();
    let mut alone = Asked(vec![]);
    again.observe(100, 25, &mut alone).unwrap();
    let lanes =
        scene()
            .ensemble([billiard(0.3), billiard(0.4)], Rattle::new(0.01))
            .unwrap()
            .observe(100, 25, || Each::of(|| Asked(vec![])));
    for (seen, bound) in [(&alone.0, 1e-13), (&lanes.get(0).unwrap().0, 1e-10)] {
        assert_eq!(seen.len(), 4);
        for (i, (step, multipliers, forces)) in seen.iter().enumerate() {
            assert_eq!(*step, 25 * (i as u64 + 1));
            for (sight, (lambda, force)) in expected[i..i + 2].iter().enumerate() {
                assert!((multipliers[sight][0] - lambda).abs() <= bound, "{i} {multipliers:?} {lambda}");
                assert!((forces[sight] - force).abs() <= bound, "{i} {forces:?} {force}");
            }
        }
    }
}

#[test]
fn looks_do_not_allocate() {
    let mut simulation = scene().simulate(billiard(0.3), Rattle::new(0.01)).unwrap();
    let mut seen =
        (Mean::of(|now: &Sight<'_, 3>| now.energy()), Mean::of(|now: &Sight<'_, 3>| now.position().z));
    let mut allocated = |steps| {
        let measured = allocation_counter::measure(|| simulation.observe(steps, 1, &mut seen).unwrap());
        measured.count_total
    };
    assert_eq!(allocated(1), allocated(500));
}

#[test]
fn progress_tells_each_sight_once() {
    use std::sync::atomic::{AtomicU64, Ordering};
    let (told, calls) = (AtomicU64::new(0), AtomicU64::new(0));
    let tell = |sights| {
        told.fetch_add(sights, Ordering::Relaxed);
        calls.fetch_add(1, Ordering::Relaxed);
    };
    let mut ensemble =
        scene().ensemble((0..100).map(|i| billiard(0.01 * f64::from(i))), Rattle::new(0.01)).unwrap();
    ensemble.observe(105, 10, || Progress::of(300, tell));
    assert_eq!(told.swap(0, Ordering::Relaxed), 100 * 10);
    assert_eq!(calls.swap(0, Ordering::Relaxed), 5); // 640 and 360 sights, of two groups
    let mut simulation = scene().simulate(billiard(0.3), Rattle::new(0.01)).unwrap();
    simulation.observe(1000, 4, &mut (Progress::of(100, tell), Trajectory::new())).unwrap();
    assert_eq!((told.into_inner(), calls.into_inner()), (250, 3));
}

#[test]
fn runs_end_at_the_first_step_that_is_there() {
    let run = |h: f64, start: f64, until: f64| {
        let free = Scene::point().simulate(State::at([0.0]).moving([1.0]).at_time(start), Rattle::new(h));
        let mut simulation = free.unwrap();
        simulation.run_until(until).unwrap();
        (simulation.steps(), simulation.time())
    };
    for n in (1..2000_u32).step_by(29) {
        for h in [0.1, 0.01, 1.0 / 3.0, 0.7e-3] {
            let (exact, summed) = (f64::from(n) * h, (0..n).fold(0.0, |t, _| t + h));
            for until in [exact, exact.next_up(), exact.next_down(), summed] {
                assert_eq!(run(h, 0.0, until).0, u64::from(n), "{n} × {h}");
            }
            assert_eq!(run(h, 0.0, exact + 1e-3 * h).0, u64::from(n) + 1);
            assert_eq!(run(-h, 0.0, -exact).0, u64::from(n));
            assert_eq!(run(h, 1e5, 1e5 + exact).0, u64::from(n));
        }
    }
    assert_eq!(run(0.1, 2.0, 1.0), (0, 2.0));
    assert_eq!(run(0.1, 2.0, 2.0), (0, 2.0));
    for time in [f64::NAN, f64::INFINITY] {
        let mut simulation = Scene::point().simulate(State::at([0.0]), Rattle::new(0.1)).unwrap();
        let error = simulation.run_until(time).unwrap_err();
        assert!(error.to_string().starts_with("the time until which to run must be finite"), "{error}");
        assert_eq!(simulation.steps(), 0);
    }
}

#[test]
fn steps_of_different_lengths_end_there_too() {
    let mut simulation = scene().simulate(billiard(0.3), Dop853::adaptive(0.01, 1e-10)).unwrap();
    let mut last = 0.0;
    for until in [0.5, 0.5, 0.8, 2.0] {
        simulation.run_until(until).unwrap();
        assert!(simulation.time() >= until - 1e-8, "{}", simulation.time());
        let mut one_less = scene().simulate(billiard(0.3), Dop853::adaptive(0.01, 1e-10)).unwrap();
        one_less.run(simulation.steps() - 1).unwrap();
        assert!(one_less.time() < until, "{} {until}", one_less.time());
        last = simulation.time();
    }
    assert!(last < 2.5);
}

#[test]
fn runs_stop_early() {
    let mut simulation = scene().simulate(billiard(0.3), Rattle::new(0.01)).unwrap();
    let steps = simulation.run_while(5000, |now| now.position().x < 0.4).unwrap();
    assert_eq!(steps, simulation.steps());
    assert!(simulation.position().x >= 0.4);
    let mut other = scene().simulate(billiard(0.3), Rattle::new(0.01)).unwrap();
    other.run(steps - 1).unwrap();
    assert!(other.position().x < 0.4);
    assert_eq!(simulation.run_while(10, |_| true).unwrap(), 10);
    assert_eq!(simulation.run_while(10, |_| false).unwrap(), 0);
    let failing =
        Scene::on(SURFACE).simulate(billiard(0.3), Rattle::new(10.0)).unwrap().run_while(10, |_| true);
    assert!(matches!(failing, Err(rattle::Error::Step { step: 1, .. })));
}

#[test]
fn boxed_simulations_are_the_same_simulations() {
    let (linked, start) = pendulum();
    let mut pendulum = linked.simulate(start.clone(), Rattle::new(0.02)).unwrap();
    let points = Scene::points::<2>(2).simulate(start, Shake::new(0.02)).unwrap();
    let mut all: Vec<BoxedSimulation<2>> = vec![pendulum.clone().boxed(), points.boxed()];
    let (mut path, mut own) = (Trajectory::new(), Trajectory::new());
    all[0].observe(60, 3, &mut path).unwrap();
    pendulum.observe(60, 3, &mut own).unwrap();
    all.iter_mut().for_each(|simulation| simulation.run_until(2.0).unwrap());
    pendulum.run_until(2.0).unwrap();
    let boxed = &all[0];
    assert_eq!((path, boxed.steps(), boxed.time()), (own, 100, pendulum.time()));
    assert_eq!(bits(&boxed.state()), bits(&pendulum.state()));
    assert_eq!(boxed.positions().collect::<Vec<_>>(), pendulum.positions().collect::<Vec<_>>());
    assert_eq!(boxed.momenta().collect::<Vec<_>>(), pendulum.momenta().collect::<Vec<_>>());
    assert_eq!(boxed.velocities().collect::<Vec<_>>(), pendulum.velocities().collect::<Vec<_>>());
    assert_ne!(boxed.velocities().nth(1), boxed.momenta().nth(1));
    let numbers = |one: [f64; 8]| one.map(f64::to_bits);
    assert_eq!(
        numbers([
            boxed.kinetic_energy(),
            boxed.potential_energy(),
            boxed.temperature(),
            boxed.energy(),
            boxed.energy_error(),
            boxed.work(),
            boxed.constraint_residual(),
            boxed.cotangent_residual()
        ]),
        numbers([
            pendulum.kinetic_energy(),
            pendulum.potential_energy(),
            pendulum.temperature(),
            pendulum.energy(),
            pendulum.energy_error(),
            pendulum.work(),
            pendulum.constraint_residual(),
            pendulum.cotangent_residual()
        ])
    );
    assert_eq!((boxed.multipliers(), boxed.residuals()), (pendulum.multipliers(), pendulum.residuals()));
    assert_eq!(boxed.constraint_forces(), pendulum.constraint_forces());
    assert_eq!((boxed.freedom(), boxed.effect_energies()), (pendulum.freedom(), pendulum.effect_energies()));
    let items = |bill: Bill| bill.items.into_iter().map(|item| item.what).collect::<Vec<_>>();
    assert_eq!(items(boxed.bill().unwrap()), items(pendulum.bill().unwrap()));
    assert_eq!((boxed.bodies(), all[1].multipliers().len(), all[1].steps()), (2, 0, 100));
    assert_eq!((boxed.momentum_time(), all[1].momentum_time()), (boxed.time(), 2.0 - 0.01));
    let mut clone = all[0].clone();
    clone.step().unwrap();
    assert_eq!((clone.steps(), all[0].steps()), (101, 100));
}

/// U = t z.
#[derive(Debug, Clone, Copy)]
struct Rising;
struct WithTime;

impl Effect<3, WithTime> for Rising {
    type Acting<T: Real> = Self;
    fn acting<T: Real>(&self) -> Self {
        Self
    }
    type Swept<S: Lane, const L: usize> = [Self; L];
}

impl<T: Real> Acting<T, 3> for Rising {
    type Room = ();
    fn room(&self, _: usize) {}
    fn changes_with_time(&self) -> bool {
        true
    }
    fn add_forces(&self, at: Moment<'_, T, 3>, (): &mut (), forces: &mut [[T; 3]]) {
        forces.iter_mut().for_each(|force| force[2] = force[2] - T::from_f64(at.time));
    }
    fn energy(&self, at: Moment<'_, T, 3>) -> T {
        at.positions.iter().fold(T::from_f64(0.0), |sum, q| sum + T::from_f64(at.time) * q[2])
    }
}

#[test]
fn energies_are_those_of_the_time_of_the_sight() {
    struct Check(u64);
    impl Observer<3> for Check {
        fn see(&mut self, before: &Sight<'_, 3>, now: &Sight<'_, 3>) {
            for sight in [before, now] {
                let expected = sight.time * sight.position().z;
                assert!((sight.potential_energy() - expected).abs() < 1e-15, "{sight:?}");
            }
            self.0 += 1;
        }
        fn join(&mut self, next: Self) {
            self.0 += next.0;
        }
    }
    let scene = Scene::on(SURFACE).with(Rising);
    let mut simulation = scene.simulate(billiard(0.3), Rattle::new(0.01)).unwrap();
    let mut check = Check(0);
    simulation.observe(100, 10, &mut check).unwrap();
    let mut ensemble = scene.ensemble([billiard(0.3), billiard(0.4)], Rattle::new(0.01)).unwrap();
    let found = ensemble.observe(100, 10, || Check(0));
    assert_eq!((check.0, found.0), (10, 20));
}

/// λ and μ in the order in which they are told.
#[derive(Debug, Default, Clone, PartialEq)]
struct Told(Vec<(bool, f64)>);

impl<const D: usize> Observer<D> for Told {
    fn see(&mut self, _: &Sight<'_, D>, _: &Sight<'_, D>) {}
    fn join(&mut self, _: Self) {}
    fn position_multiplier(&mut self, _: usize, lambda: f64) {
        self.0.push((true, lambda));
    }
    fn momentum_multiplier(&mut self, _: usize, mu: f64) {
        self.0.push((false, mu));
    }
}

/// Of iterations, of tries that fail, and of those in search of an instant, no multiplier is told.
#[test]
fn multipliers_are_those_of_what_is_taken() {
    let sphere = Scene::on(Sphere { r: 1.0 });
    let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 0.6, 0.8]);
    let mut told = Told::default();
    sphere.simulate(start.clone(), Bdf2::new(0.01)).unwrap().observe(50, 1, &mut told).unwrap();
    assert_eq!(told.0.len(), 100, "one λ and one μ a step");
    // |v|²/|∇g|² for both.
    assert!(told.0[2..].iter().all(|(_, multiplier)| (multiplier + 0.5).abs() < 1e-3), "{:?}", &told.0[..6]);

    // A step that fails as a whole, and is taken in parts: what is told is as of a run with such steps.
    let falling = sphere.with(Gravity { g: 1.0 });
    let top = State::at([0.0, 0.0, 1.0]).moving([0.2, 0.0, 0.0]);
    let mut whole = falling.simulate(top.clone(), Rattle::new(0.7)).unwrap();
    whole.run(1000).unwrap_err();
    let before = whole.steps();
    let mut retried = falling.simulate(top, Rattle::new(0.7)).unwrap().retry(4);
    retried.run(before).unwrap();
    let (at, mut told) = (retried.state(), Told::default());
    retried.observe(1, 1, &mut told).unwrap();
    let parts = told.0.len() / 2;
    let mut same = Told::default();
    let mut divided = falling.simulate(at, Rattle::new(0.7 / parts as f64)).unwrap();
    divided.observe(parts as u64, 1, &mut same).unwrap();
    assert!(parts > 1 && told == same, "{told:?} {same:?}");

    // With impacts and edges: as many stretches as there are events, and one more.
    let floor = rattle::effect::Stop::above(South {});
    let mut ball = sphere.simulate(start, Rattle::new(0.01)).unwrap().collide(floor).unwrap();
    let mut told = Told::default();
    ball.observe(1000, 1, &mut told).unwrap();
    assert!(ball.events() > 1 && told.0.len() as u64 == 2 * (1000 + ball.events()), "{}", told.0.len());
    assert!(told.0.iter().all(|(_, multiplier)| (multiplier + 0.5).abs() < 1e-3));
    let octahedron = Scene::on(Octahedron {});
    let start = State::at([0.5, 0.3, 0.2]).moving([-1.0, 0.4, 0.6]);
    let mut over = octahedron.simulate(start, Rattle::new(0.01)).unwrap().over_kinks().unwrap();
    let mut told = Told::default();
    over.observe(400, 1, &mut told).unwrap();
    assert!(over.events() > 2 && (802..=2 * (400 + over.events() as usize)).contains(&told.0.len()));
}

/// An observer of each trajectory hands on what it hears of its simulation, and why one of them fails.
#[test]
fn each_hands_on_multipliers_and_failures() {
    let scene = Scene::on(Sphere { r: 1.0 }).with(Gravity { g: 1.0 });
    let start = || State::at([1.0, 0.0, 0.0]).moving([0.0, 0.6, 0.8]);
    let mut run = scene.simulate(start(), Rattle::new(0.01)).unwrap();
    let mut each = Each::of(|| Trajectory::with_multipliers(&run));
    let mut one = Trajectory::with_multipliers(&run);
    let mut others = run.clone();
    run.clone().observe(30, 10, &mut each).unwrap();
    others.observe(30, 10, &mut one).unwrap();
    let each = each.get(0).unwrap();
    assert_eq!((each.multipliers(), each.positions()), (one.multipliers(), one.positions()));
    assert!(one.multipliers().unwrap().position[1..].iter().all(|lambda| lambda.is_finite()));

    // In an ensemble none is heard: not that of the start either, as that of the first step.
    let mut ensemble = scene.ensemble([start()], Rattle::new(0.01)).unwrap();
    let paths = ensemble.observe(30, 10, || Each::of(|| Trajectory::with_multipliers(&run)));
    let found = &paths.get(0).unwrap().multipliers().unwrap().position;
    assert_eq!((found.len(), found[0].is_nan()), (4, false));
    assert!(found[1..].iter().all(|lambda| lambda.is_nan()), "{found:?}");

    #[derive(Default)]
    struct Full(u64);
    impl<const D: usize> Observer<D> for Full {
        fn see(&mut self, _: &Sight<'_, D>, _: &Sight<'_, D>) {
            self.0 += 1;
        }
        fn join(&mut self, _: Self) {}
        fn failure(&self) -> Option<Error> {
            (self.0 >= 3).then(|| Error::Before("disk full".into()))
        }
    }
    let error = run.observe(100, 10, &mut Each::of(Full::default)).unwrap_err();
    assert_eq!((error.to_string().contains("disk full"), run.steps()), (true, 30));
}

/// Rows of a trajectory are of one scene: what differs in another is named, its bodies or their coordinates.
#[test]
fn trajectories_name_what_does_not_fit() {
    let mut path = Trajectory::new();
    let start = || State::of([[0.0, 1.0], [0.0, 2.0]]);
    let mut plane = Scene::points(2).simulate(start(), Rattle::new(0.1)).unwrap();
    plane.observe(2, 1, &mut path).unwrap();
    let mut more = Scene::points(3).simulate(State::of([[0.0; 2]; 3]), Rattle::new(0.1)).unwrap();
    let error = more.observe(1, 1, &mut path.clone()).unwrap_err().to_string();
    assert!(error.contains("of 2 bodies, and here are 3"), "{error}");
    let mut space = Scene::points(2).simulate(State::of([[0.0; 3]; 2]), Rattle::new(0.1)).unwrap();
    let error = space.observe(1, 1, &mut path).unwrap_err().to_string();
    assert!(error.contains("2 coordinates") && error.contains("3"), "{error}");
}

/// A trajectory holds rows of one, also where an observer is shown many: in lanes they would be mixed, and one after
/// the other where there are no lanes.
#[test]
fn a_trajectory_is_one_trajectory() {
    fn check(method: impl Method) {
        let starts =
            |n: u32| (0..n).map(|i| State::at([1.0, 0.0, 0.0]).moving([0.0, 1.0 + f64::from(i), 0.0]));
        let sphere = Scene::on(Sphere { r: 1.0 });
        let mut one = sphere.ensemble(starts(1), method.clone()).unwrap();
        assert_eq!(one.observe(20, 10, Trajectory::new).shape(), [3, 1, 3]);
        let mut two = sphere.ensemble(starts(2), method.clone()).unwrap();
        let seen = catch_unwind(AssertUnwindSafe(|| two.observe(20, 10, Trajectory::new))).unwrap_err();
        let told = seen.downcast_ref::<String>().unwrap();
        assert!(told.contains("0 and 1") && told.contains("take `Each::of(Trajectory::new)`"), "{told}");
    }
    check(Rattle::new(0.01));
    check(Shake::new(0.01));
}
