//! Flows of momenta in lanes: as each trajectory alone but for rounding, what they keep, and their work.

use crate::common::{Trough, larger};
use rattle::composition::SUZUKI_1990_ORDER_4;
use rattle::effect::{
    Andersen, DryFriction, Effects, Flow, Inertia, Interval, Langevin, LinearDrag, MagneticField,
};
use rattle::effect::{QuadraticDrag, Rule, SelfPropulsion, VelocityRescaling};
use rattle::ensemble::{InstructionSet, NotInLanes};
use rattle::method::Method;
use rattle::nalgebra::Vector3;
use rattle::prelude::*;
use rattle::real::Real;
use rattle::surfaces::{Sphere, Torus};

constraint! {
    /// Spheres of radius 1 + nπ/k.
    struct Shells { k }
    |x, y, z| sin(k * (sqrt(x^2 + y^2 + z^2) - 1))
}

force! {
    /// Wind that turns with time, against which bodies drag.
    struct Wind { c }
    |q: [f64; 3], v: [f64; 3], t| [c * (cos(t) - v[0]), c * (sin(t) - v[1]) * (1 + q[2]^2), -c * v[2]]
}

/// Momenta along a line of the place are slowed: a field that is not the same everywhere, and turns what leads off.
#[derive(Debug, Clone)]
struct Combed(f64);

impl Flow<3> for Combed {
    #[inline(always)]
    fn flow<T: Real>(&self, during: &Interval<'_, T, 3>, changes: &mut [[T; 3]]) {
        let lost = T::from_f64((-self.0 * during.h).exp_m1());
        for (i, (change, [px, py, pz])) in changes.iter_mut().zip(during.momenta).enumerate() {
            let [x, y, z] = during.at.positions[i];
            let along = lost * (x * *px + y * *py + z * *pz) / (x * x + y * y + z * z);
            let normal = during.surface.map_or([T::from_f64(0.0); 3], |surface| surface.normal(i));
            let push = T::from_f64(0.1 * during.h);
            *change = [along * x + push * normal[1], along * y - push * normal[0], along * z];
        }
    }
}

/// A random push, along x alone.
#[derive(Debug, Clone)]
struct Shaken(f64);

impl Flow<3> for Shaken {
    const RULE: Rule = Rule::Random;

    fn flow<T: Real>(&self, during: &Interval<'_, T, 3>, changes: &mut [[T; 3]]) {
        for (body, change) in changes.iter_mut().enumerate() {
            let [a, ..] = during.noise.uniform(11, body as u64);
            *change = [T::from_f64(self.0 * during.h * (2.0 * a - 1.0)), T::from_f64(0.0), T::from_f64(0.0)];
        }
    }
}

const HEAT: Langevin = Langevin { friction: 2.0, temperature: 0.5, seed: 7 };
const RING: Torus = Torus { major: 1.2, minor: 0.5 };
const FIELD: [f64; 3] = [0.7, -0.4, 1.5];

fn ring() -> Scene<Torus, impl Effects<3> + Clone, rattle::bodies::One, 3> {
    Scene::on(RING).with(Trough { g: 1.0 })
}

/// From different places and times, of trajectories with numbers and steps behind them, and without.
fn start(i: u64) -> State<3> {
    let angle = 0.1 * i as f64;
    let (x, y) = (angle.cos(), angle.sin());
    let state = State::at([1.7 * x, 1.7 * y, 0.0]).moving([-0.4 * y, 0.4 * x, 0.8 + 0.01 * i as f64]);
    let state = state.at_time(0.01 * i as f64);
    match i % 3 {
        0 => state.numbered(1000 + i),
        1 => state.after_steps(5 * i),
        _ => state,
    }
}

/// An ensemble counts its trajectories; a simulation has to be told.
fn numbered(i: u64) -> State<3> {
    if i.is_multiple_of(3) { start(i) } else { start(i).numbered(i) }
}

fn off(a: &State<3>, b: &State<3>) -> f64 {
    let apart = a.positions().zip(b.positions()).chain(a.momenta().zip(b.momenta()));
    apart.map(|(a, b)| (a - b).norm()).fold(0.0, larger)
}

fn in_lanes<const D: usize>(ensemble: &Ensemble<D>) {
    let plan = ensemble.plan();
    assert_eq!(plan.in_lanes == ensemble.len(), InstructionSet::widest().fuses(), "{plan:?}");
}

/// How far lanes are from simulations after so many steps, in places, momenta and work.
fn apart<P: Precision, E: Effects<3>, S: Method>(
    precision: P,
    scene: &Scene<Torus, E, rattle::bodies::One, 3>,
    method: &S,
    steps: u64,
) -> f64 {
    let mut ensemble = scene.ensemble_in(precision, (0..67).map(start), method.clone()).unwrap();
    in_lanes(&ensemble);
    ensemble.run(steps);
    assert_eq!(ensemble.failures().count(), 0);
    let alone = (0..67).map(|i| {
        let mut simulation = scene.simulate(numbered(i), method.clone()).unwrap();
        simulation.run(steps).unwrap();
        let (own, state) = (simulation.state(), ensemble.state(i as usize));
        assert_eq!((own.time(), own.steps()), (state.time(), state.steps()));
        larger(off(&own, &state), (simulation.work() - ensemble.work(i as usize)).abs())
    });
    alone.fold(0.0, larger)
}

fn as_alone<E: Effects<3>>(scene: &Scene<Torus, E, rattle::bodies::One, 3>, name: &str) {
    check(
        name,
        &[
            apart(Double, scene, &Rattle::new(0.02), 30),
            #[cfg(long)]
            apart(Compensated, scene, &Rattle::new(0.02), 30),
            #[cfg(long)]
            apart(Double, scene, &Baoab::new(0.02), 30),
        ],
    );
}

fn check(name: &str, found: &[f64]) {
    println!("{name}: {found:?}");
    assert!(found.iter().all(|&off| off < 1e-12), "{name}: {found:?}");
}

#[test]
fn ready_made_flows_as_alone() {
    as_alone(&ring().with(LinearDrag::new(0.7)), "drag");
    as_alone(&ring().with(LinearDrag::along([0.1, 2.0, 0.7]).times([1.5])), "drag by direction");
    as_alone(&ring().with(MagneticField::new(FIELD).charges([-2.0])), "a field");
    as_alone(&ring().with(QuadraticDrag { coefficient: 1.5 }), "drag by the square");
}

#[test]
fn heat_as_alone() {
    as_alone(&ring().with(HEAT), "a bath");
    as_alone(&ring().with(Andersen { rate: 5.0, temperature: 0.5, seed: 3 }), "collisions");
    as_alone(&ring().with(VelocityRescaling { time: 0.3, temperature: 0.5, seed: 3 }), "rescaling");
}

#[test]
fn flows_of_ones_own_as_alone() {
    as_alone(&ring().with(Combed(0.8)), "one's own");
    as_alone(&ring().with(Shaken(3.0)), "random");
    as_alone(&ring().with(Wind { c: 0.9 }), "wind");
}

/// Several flows, of all kinds; each in its order, with its own random numbers.
#[test]
fn several_flows_as_alone() {
    let scene = ring().with(HEAT).with(MagneticField::new(FIELD)).with(Combed(0.8));
    as_alone(&scene, "three");
    check(
        "three in other ways",
        &[apart(Compensated, &scene, &Rattle::new(0.02), 30), apart(Double, &scene, &Baoab::new(0.02), 30)],
    );
    let five = scene.with(Langevin { friction: 0.5, temperature: 2.0, seed: 7 }).with(Wind { c: 0.2 });
    as_alone(&five, "five");
}

#[test]
fn by_each_method() {
    let scene = ring().with(LinearDrag::along([0.1, 2.0, 0.7])).with(HEAT);
    check(
        "heat and drag",
        &[
            apart(Double, &scene, &PositionVerlet::new(0.02), 30),
            #[cfg(long)]
            apart(Double, &scene, &Geodesic::new(2, 0.02), 30),
            #[cfg(long)]
            apart(Double, &scene, &Baoab::with_inner(3, 0.02), 30),
            apart(Compensated, &scene, &Baoab::with_inner(2, 0.02), 30),
        ],
    );
    check(
        "one flow",
        &[
            apart(Double, &ring().with(Combed(0.8)), &Composition::new(SUZUKI_1990_ORDER_4, 0.04), 15),
            apart(Compensated, &ring().with(Wind { c: 0.5 }), &Geodesic::new(2, 0.02), 30),
            apart(Double, &ring().with(MagneticField::new(FIELD)), &Rattle::new(-0.02), 30),
        ],
    );
    let single = apart(Single, &ring().with(MagneticField::new(FIELD)).with(HEAT), &Rattle::new(0.02), 30);
    assert!(single < 1e-3, "{single:e}");
    // One trajectory by itself has lanes of its own.
    let mut one = scene.ensemble([numbered(4)], Rattle::new(0.02)).unwrap();
    in_lanes(&one);
    one.run(30);
    let mut alone = scene.simulate(numbered(4), Rattle::new(0.02)).unwrap();
    alone.run(30).unwrap();
    assert!(off(&one.state(0), &alone.state()) < 1e-12);
}

/// Each trajectory of a sweep has flows of its own.
#[test]
fn flows_by_lane() {
    let scene = |i: u32| {
        let x = f64::from(i);
        ring()
            .with(LinearDrag::along([0.01 * x, 0.02, 0.03]))
            .with(Combed(0.01 * x))
            .with(MagneticField::new([0.0, 0.02 * x, 1.0]))
            .with(Langevin { friction: 0.05 * x, seed: u64::from(i % 5), ..HEAT })
    };
    let scenes: Vec<_> = (0..66).map(scene).collect();
    let mut sweep = Ensemble::sweep(Double, scenes.iter().zip((0..).map(start)), Rattle::new(0.02)).unwrap();
    in_lanes(&sweep);
    sweep.run(30);
    for (i, scene) in scenes.iter().enumerate() {
        let mut alone = scene.simulate(numbered(i as u64), Rattle::new(0.02)).unwrap();
        alone.run(30).unwrap();
        let work = (alone.work() - sweep.work(i)).abs();
        assert!(off(&alone.state(), &sweep.state(i)) < 1e-12 && work < 1e-12, "{i} {work}");
    }
}

/// On a sphere without forces momenta fall like exp(−γt), and energy is lost as work.
#[test]
fn drag_of_geodesics() {
    let scene = Scene::on(Sphere { r: 1.0 }).with(LinearDrag::new(0.3));
    let starts = (0..64).map(|i| State::at([1.0, 0.0, 0.0]).moving([0.0, 0.6, 0.01 * f64::from(i)]));
    for method in [0.1, 0.01].map(Rattle::new) {
        let mut ensemble = scene.ensemble(starts.clone(), method).unwrap();
        in_lanes(&ensemble);
        let first: Vec<_> = ensemble.states().map(|state| state.momenta().next().unwrap().norm()).collect();
        ensemble.run_until(5.0).unwrap();
        for (i, first) in first.into_iter().enumerate() {
            let now = ensemble.state(i).momenta().next().unwrap().norm();
            assert!((now / (first * (-1.5_f64).exp()) - 1.0).abs() < 1e-12, "{now}");
            let lost = 0.5 * (now * now - first * first);
            assert!((ensemble.work(i) - lost).abs() < 1e-13, "{} {lost}", ensemble.work(i));
        }
    }
}

/// A field does no work, whatever its direction; and bodies on a sphere in a field along z keep
/// (q × p)_z + B (x² + y²)/2.
#[test]
fn fields_keep_energy() {
    let tilted = Scene::on(Sphere { r: 1.7 }).with(MagneticField::new(FIELD));
    let mut ensemble = tilted.ensemble((0..64).map(start), Rattle::new(0.05)).unwrap();
    in_lanes(&ensemble);
    let first: Vec<_> = ensemble.states().map(|state| state.momenta().next().unwrap().norm()).collect();
    ensemble.run(1000);
    for (i, first) in first.into_iter().enumerate() {
        let now = ensemble.state(i).momenta().next().unwrap().norm();
        assert!((now / first - 1.0).abs() < 1e-13 && ensemble.work(i).abs() < 1e-13, "{now} {first}");
    }
    // ṗ = v × B: with B along z, (q × p)_z + B (x² + y²)/2 stays.
    let field = Scene::on(Sphere { r: 1.0 }).with(MagneticField::new([0.0, 0.0, 2.0]));
    let moment = |state: &State<3>| {
        let (q, p): (Vector3<f64>, Vector3<f64>) =
            (state.positions().next().unwrap(), state.momenta().next().unwrap());
        q.cross(&p).z + q.xy().norm_squared()
    };
    let worst = |h: f64| {
        let begin = |i: i32| State::at([0.0, 0.6, 0.8]).moving([0.1 * f64::from(i) - 3.0, 0.08, -0.06]);
        let mut ensemble = field.ensemble((0..64).map(begin), Rattle::new(h)).unwrap();
        let first: Vec<_> = ensemble.states().map(|state| moment(&state)).collect();
        ensemble.run_until(2.0).unwrap();
        let off = ensemble.states().zip(first).map(|(state, first)| (moment(&state) - first).abs());
        off.fold(0.0, larger)
    };
    let order = crate::common::order(&[0.04, 0.02, 0.01].map(worst));
    assert!((1.8..2.2).contains(&order), "{order}");
}

/// What energy changes by beyond the work of flows is of second order.
#[test]
fn work_and_energy() {
    fn balance<E: Effects<3>>(scene: &Scene<Torus, E, rattle::bodies::One, 3>) {
        let worst = |h: f64| {
            let mut ensemble = scene.ensemble((0..64).map(start), Rattle::new(h)).unwrap();
            let energy = |state: State<3>| {
                let simulation = scene.simulate(state, Rattle::new(h)).unwrap();
                simulation.energy()
            };
            let first: Vec<_> = ensemble.states().map(energy).collect();
            ensemble.run((1.0 / h).round() as u64);
            let parts = ensemble.states().enumerate().zip(first);
            let off = parts.map(|((i, state), first)| (energy(state) - first - ensemble.work(i)).abs());
            (off.fold(0.0, larger), ensemble.work(3).abs())
        };
        let [a, b, c] = [0.04, 0.02, 0.01].map(worst);
        let order = crate::common::order(&[a.0, b.0, c.0]);
        assert!((1.7..2.4).contains(&order) && a.1 > 0.05, "{order} {a:?} {b:?} {c:?}");
    }
    balance(&ring().with(LinearDrag::along([0.1, 2.0, 0.7])));
    balance(&ring().with(QuadraticDrag { coefficient: 1.5 }).with(MagneticField::new(FIELD)));
    balance(&ring().with(Wind { c: 0.9 }));
}

/// In equilibrium ½kT for each of two momenta, by a bath around RATTLE as by the simulations it is compared with.
#[test]
fn temperatures() {
    let scene = Scene::on(Sphere { r: 1.0 }).with(HEAT).with(MagneticField::new(FIELD));
    let starts = || (0..192).map(|_| State::at([0.0, 0.0, -1.0]));
    let energy = || Mean::of(|now: &Sight<'_, 3>| 0.5 * now.momentum().norm_squared());
    let mut ensemble = scene.ensemble(starts(), Rattle::new(0.1)).unwrap();
    in_lanes(&ensemble);
    ensemble.run(40);
    let mean = ensemble.observe(200, 20, energy).mean();
    // 1920 samples of an exponential distribution, independent: energies lose their past in 1/2γ, 2.5 steps.
    assert!((mean / 0.5 - 1.0).abs() < 4.5 / 1920.0_f64.sqrt(), "{mean}");
    let alone = starts().take(40).enumerate().map(|(i, start)| {
        let mut simulation = scene.simulate(start.numbered(i as u64), Rattle::new(0.1)).unwrap();
        simulation.run(240).unwrap();
        larger((simulation.work() - ensemble.work(i)).abs(), off(&simulation.state(), &ensemble.state(i)))
    });
    let worst = alone.fold(0.0, larger);
    assert!(worst < 1e-9, "{worst:e}");
}

fn bits(state: &State<3>) -> String {
    format!("{state:?}")
}

/// Trajectories of which some fail: at speeds that the surface is too curved for. Bits depend on no neighbour, on no
/// division of a run, and not on a checkpoint between; also the work on those that rest.
#[test]
fn those_that_fail_disturb_no_other() {
    fn check<E: Effects<3>>(scene: &Scene<Torus, E, rattle::bodies::One, 3>, speeds_up: bool) {
        let method = Rattle::new(0.05);
        let fast = |i: u64| i % 7 == 3;
        let begin = |i: u64| {
            let start = start(i).numbered(i);
            let faster: Vec<_> = start.momenta().map(|p| (6.0 + 0.2 * i as f64) * p).collect();
            if fast(i) { start.with_momenta(faster) } else { start }
        };
        let of = |numbers: Vec<u64>| scene.ensemble(numbers.into_iter().map(begin), method).unwrap();
        let (mut all, mut few) = (of((0..70).collect()), of((0..70).filter(|&i| !fast(i)).collect()));
        all.run(40);
        let record = all.checkpoint();
        all.run(50);
        (0..9).for_each(|_| few.run(10));
        let failed: Vec<_> = all.failures().map(|(i, _)| i as u64).collect();
        assert!(failed.len() > 3 && failed.iter().all(|&i| fast(i)), "{failed:?}");
        let later = failed.iter().any(|&i| all.work(i as usize) != 0.0);
        assert_eq!(later, speeds_up, "whether some fail on the way: {failed:?}");
        for (number, i) in (0..70).filter(|&i| !fast(i)).enumerate() {
            assert_eq!(bits(&few.state(number)), bits(&all.state(i as usize)), "{i}");
            assert_eq!(few.work(number).to_bits(), all.work(i as usize).to_bits(), "{i}");
        }
        let mut again = of((0..70).collect());
        again.resume(&record).unwrap();
        again.run(50);
        for i in 0..70 {
            assert_eq!(bits(&again.state(i)), bits(&all.state(i)), "{i}, from a checkpoint");
            assert_eq!(again.work(i).to_bits(), all.work(i).to_bits(), "{i}, from a checkpoint");
        }
    }
    check(&ring().with(LinearDrag::along([0.1, 2.0, 0.7])).with(HEAT), false);
    check(&ring().with(Combed(-0.5)).with(Shaken(0.1)), true);
}

/// A checkpoint of other flows is refused.
#[test]
fn other_flows_are_refused() {
    fn refused<A: Effects<3>, B: Effects<3>>(
        a: &Scene<Torus, A, rattle::bodies::One, 3>,
        b: &Scene<Torus, B, rattle::bodies::One, 3>,
        part: &str,
    ) {
        let begin = || (0..5).map(start);
        let record = a.ensemble(begin(), Rattle::new(0.02)).unwrap().checkpoint();
        let told = b.ensemble(begin(), Rattle::new(0.02)).unwrap().resume(&record).unwrap_err().to_string();
        assert!(told.contains(part), "{told}");
    }
    let drag = |c: f64| ring().with(HEAT).with(LinearDrag::new(c));
    refused(&drag(0.5), &drag(0.6), "flow 1");
    refused(&ring().with(Combed(0.5)), &ring().with(Combed(0.6)), "flow 0");
    refused(&ring().with(HEAT), &ring().with(Langevin { seed: 8, ..HEAT }), "flow 0");
}

/// Steps in parts have flows in parts, as in a simulation.
#[test]
fn parts_of_steps() {
    let scene = Scene::on(Sphere { r: 1.0 }).with(HEAT).with(Combed(0.8)).with(Wind { c: 0.4 });
    let begin = |i: u64| State::at([1.0, 0.0, 0.0]).moving([0.0, 6.0, 0.0]).numbered(i).after_steps(i);
    let method = Rattle::new(0.5);
    let mut whole = scene.ensemble((0..20).map(begin), method).unwrap();
    whole.run(1);
    assert_eq!(whole.failures().count(), 20);
    let mut ensemble = scene.ensemble((0..20).map(begin), method).unwrap().retry(8);
    in_lanes(&ensemble);
    ensemble.run(2);
    for i in 0..20 {
        let mut alone = scene.simulate(begin(i), method).unwrap().retry(8);
        alone.run(2).unwrap();
        let (i, work) = (i as usize, (alone.work() - ensemble.work(i as usize)).abs());
        assert!(off(&alone.state(), &ensemble.state(i)) < 1e-11 && work < 1e-11, "{i} {work}");
    }
}

/// A flow that no momentum along the surface fits is refused by a simulation, and by the lane that it stops.
#[test]
fn flows_that_fail() {
    /// Nothing beyond a height.
    #[derive(Debug, Clone)]
    struct Ends(f64);
    impl Flow<3> for Ends {
        fn flow<T: Real>(&self, during: &Interval<'_, T, 3>, changes: &mut [[T; 3]]) {
            let [nan, zero, height] = [f64::NAN, 0.0, self.0].map(T::from_f64);
            for (change, [_, _, z]) in changes.iter_mut().zip(during.at.positions) {
                *change = [T::select(height.lt(*z), nan, zero); 3];
            }
        }
    }
    let scene = Scene::on(RING).with(Ends(0.4));
    let (mut ensemble, method) =
        (scene.ensemble((0..64).map(start), Rattle::new(0.02)).unwrap(), Rattle::new(0.02));
    in_lanes(&ensemble);
    ensemble.run(100);
    assert_eq!(ensemble.failures().count(), 64);
    for (i, told) in ensemble.failures() {
        let mut alone = scene.simulate(start(i as u64), method).unwrap();
        let (own, told) = (alone.run(100).unwrap_err().to_string(), told.to_string());
        let what = |told: &str| told.split_once(" from p").map(|(what, _)| what.to_string()).unwrap();
        assert_eq!(what(&own), what(&told));
        assert!(off(&alone.state(), &ensemble.state(i)) < 1e-12);
    }
}

/// Baths in a crowd of shells: started at rest, kicked by single collisions, no trajectory lands on another shell in
/// silence. Outside of `cargo long` the bath by friction is that of `lanes_heat` alone.
#[test]
fn shells_are_kept() {
    fn check<E: Effects<3>>(scene: &Scene<Shells, E, rattle::bodies::One, 3>, k: f64) -> usize {
        let begin = |i: u64| State::at([(i as f64).cos(), (i as f64).sin(), 0.0]).numbered(i);
        let mut ensemble = scene.ensemble((0..32).map(begin), Rattle::new(0.1)).unwrap();
        ensemble.run(60);
        for (i, state) in ensemble.states().enumerate() {
            let radius = state.positions().next().unwrap().norm();
            assert!((radius - 1.0).abs() < 0.5 / k, "k = {k}, {i}: on the sphere of radius {radius}");
        }
        32 - ensemble.failures().count()
    }
    let mut kept = 0;
    for k in [30.0, 100.0, 1e3] {
        let shells = Scene::on(Shells { k });
        let each = [
            #[cfg(long)]
            check(&shells.with(Langevin { friction: 5.0, temperature: 1.0, seed: 3 }), k),
            check(&shells.with(Andersen { rate: 0.5, temperature: 2.0, seed: 3 }), k),
            check(&shells.with(Wind { c: 1.0 }), k),
        ];
        kept += each.iter().sum::<usize>();
    }
    println!("{kept} of {} kept their shell for 60 steps", if cfg!(long) { 288 } else { 192 });
    assert!(kept > if cfg!(long) { 100 } else { 66 }, "{kept}");
}

/// ṗ = r p.
#[derive(Debug, Clone)]
struct Growing {
    r: f64,
    as_matrix: bool,
}

impl Flow<3> for Growing {
    #[inline(always)]
    fn flow<T: Real>(&self, during: &Interval<'_, T, 3>, changes: &mut [[T; 3]]) {
        let gained = T::from_f64((self.r * during.h).exp_m1());
        for (change, p) in changes.iter_mut().zip(during.momenta) {
            *change = p.map(|p| gained * p);
        }
    }
    fn linear(&self, h: f64, _: usize, _: &dyn Inertia<f64, 3>) -> Option<[[f64; 3]; 3]> {
        let gained = (self.r * h).exp_m1();
        self.as_matrix.then_some([[gained, 0.0, 0.0], [0.0, gained, 0.0], [0.0, 0.0, gained]])
    }
}

/// A force about the z axis and up, that changes with time.
#[derive(Debug, Clone)]
struct Timed(f64);

impl Flow<3> for Timed {
    #[inline(always)]
    fn flow<T: Real>(&self, during: &Interval<'_, T, 3>, changes: &mut [[T; 3]]) {
        let push = T::from_f64(self.0 * during.h * (5.0 * during.at.time).sin());
        for (change, [x, y, _]) in changes.iter_mut().zip(during.at.positions) {
            *change = [push * *y, -(push * *x), push];
        }
    }
    fn changes_with_time(&self) -> bool {
        self.0 != 0.0
    }
}

/// Flows that make momenta ten times as large within some steps: on spheres of radius 1 + nπ/k a simulation stays on
/// its own, and so does a lane.
#[test]
fn shells_are_kept_by_those_that_flows_speed_up() {
    force! { struct Gale { c } |_q: [f64; 3], v: [f64; 3]| [c * (8 - v[0]), c * (8 - v[1]), c * (8 - v[2])] }
    fn check<E: Effects<3>>(scene: &Scene<Shells, E, rattle::bodies::One, 3>, k: f64, h: f64) -> [usize; 2] {
        let begin = |i: u64| {
            let (a, slow) = (0.01 * i as f64, 0.01 * i as f64 / 32.0);
            State::at([a.cos(), a.sin(), 0.0]).moving([-slow * a.sin(), slow * a.cos(), 0.003])
        };
        let mut ensemble = scene.ensemble((0..32).map(begin), Rattle::new(h)).unwrap();
        in_lanes(&ensemble);
        ensemble.run(40);
        let shown = ensemble.states().map(|state| state.positions().next().unwrap().norm() - 1.0);
        let kept = shown.filter(|off| off.abs() <= 0.5 / k).count();
        [32 - kept, 32 - ensemble.failures().count()]
    }
    let all = [(1e3, 0.05), (500.0, 0.02), (3e3, 0.05)];
    let (mut astray, mut survivors) = (0, 0);
    let mut add = |[off, on]: [usize; 2]| (astray, survivors) = (astray + off, survivors + on);
    for &(k, h) in if cfg!(long) { &all[..] } else { &all[..1] } {
        let shells = || Scene::on(Shells { k });
        for &c in if cfg!(long) { &[20.0, 60.0][..] } else { &[60.0] } {
            add(check(&shells().with(Gale { c }), k, h));
            add(check(&shells().with(Timed(8.0 * c)), k, h));
        }
        for &r in if cfg!(long) { &[10.0, 40.0][..] } else { &[40.0] } {
            let drag = QuadraticDrag { coefficient: r / 12.0 };
            add(check(&shells().with(Growing { r, as_matrix: true }).with(drag), k, h));
            add(check(&shells().with(Growing { r, as_matrix: false }).with(drag), k, h));
        }
    }
    assert!(astray == 0 && survivors > 50, "{astray} astray of 128, or 768, {survivors} took all steps");
}

/// In a sweep one scene may stand still and the next change with time.
#[test]
fn some_scenes_change_with_time() {
    let scenes = [0.0, 2.0, 0.0, 1.0].map(|a| Scene::on(Sphere { r: 1.0 }).with(Timed(a)));
    let begin = || State::at([1.0, 0.0, 0.0]).moving([0.0, 1.0, 0.0]);
    let mut ensemble =
        Ensemble::sweep(Double, scenes.iter().map(|scene| (scene, begin())), Rattle::new(0.01)).unwrap();
    in_lanes(&ensemble);
    ensemble.run(100);
    for (i, scene) in scenes.iter().enumerate() {
        let mut alone = scene.simulate(begin(), Rattle::new(0.01)).unwrap();
        alone.run(100).unwrap();
        assert!(off(&alone.state(), &ensemble.state(i)) < 1e-12, "{i}");
    }
}

/// However strong a field is, half a step turns momenta by less than a right angle: it does no work, and leaves no
/// impulse of the surface undetermined. (Half turns of up to 180° did, at 1e6 and above.)
#[test]
fn strong_fields_do_no_work() {
    for b in [10.0, 1e3, 1e5, 1e6, 1e7] {
        let scene = Scene::on(Sphere { r: 1.0 }).with(MagneticField::new([b, 2.0 * b, -b]));
        let begin = |i: u64| State::at([(i as f64).cos(), (i as f64).sin(), 0.0]).moving([0.0, 0.0, 0.5]);
        let mut ensemble = scene.ensemble((0..20).map(begin), Rattle::new(0.02)).unwrap();
        in_lanes(&ensemble);
        ensemble.run(20);
        let work = (0..20).map(|i| ensemble.work(i).abs()).fold(0.0, larger);
        // Of 0.125, in 40 halves of steps.
        assert!(work < 40.0 * f64::EPSILON, "{b:e}: {work:e}");
        assert_eq!(ensemble.failures().count(), 0, "{b:e}");
    }
}

/// Why trajectories go alone.
#[test]
fn plans() {
    fn of<E: Effects<3>, S: Method>(
        scene: &Scene<Torus, E, rattle::bodies::One, 3>,
        method: S,
    ) -> Option<NotInLanes> {
        let plan = scene.ensemble((0..5).map(start), method).unwrap().plan();
        assert_eq!((plan.in_lanes, plan.alone), if plan.reason.is_none() { (5, 0) } else { (0, 5) });
        plan.reason
    }
    if !InstructionSet::widest().fuses() {
        return;
    }
    let rough = ring().with(DryFriction { coefficient: 0.1 });
    assert_eq!(of(&rough, Rattle::new(0.01)), Some(NotInLanes::FeelsForces("DryFriction")));
    let swims = ring().with(SelfPropulsion::new(0.1, 0.2, 3));
    assert_eq!(of(&swims, Rattle::new(0.01)), Some(NotInLanes::Effect("SelfPropulsion")));
    assert_eq!(of(&ring().with(HEAT), Lobatto::<3>::new(0.01)), Some(NotInLanes::Flows));
    assert_eq!(of(&ring(), Lobatto::<3>::new(0.01)), None);
    assert!(matches!(of(&ring(), Bdf2::new(0.01)), Some(NotInLanes::Method(_))));
    assert_eq!(of(&ring(), Rattle::new(1e-16)), None);
    assert_eq!(of(&ring(), Rattle::new(1e-101)), Some(NotInLanes::ShortSteps(1e-101)));
    let single = ring().ensemble_in(Single, (0..5).map(start), Rattle::new(1e-16)).unwrap();
    assert_eq!(single.plan().reason, Some(NotInLanes::ShortSteps(1e-16)));
    let top = Scene::rigid(rattle::rigid::Rigid::new([1.0, 2.0, 2.5])).with(LinearDrag::new(1.0));
    let start = State::of([[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]]);
    assert_eq!(top.ensemble([start], Rattle::new(0.01)).unwrap().plan().reason, None);
    let start = State::of([[1.7, 0.0, 0.0], [0.7, 0.0, 0.0]]);
    let two = Scene::on(RING).bodies(2).ensemble([start], Rattle::new(0.01)).unwrap();
    assert_eq!(two.plan().reason, Some(NotInLanes::System));
}
