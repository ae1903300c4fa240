//! What is kept of ensembles that are not stored: means, histograms, sections; and snapshots for a consumer beside.

use crate::common::linked::Rod;
use crate::common::*;
use rattle::ensemble::Ensemble;
use rattle::nalgebra::{Matrix3, Vector3};
use rattle::prelude::*;
use std::collections::HashMap;
use std::f64::consts::TAU;
use std::thread;

fn directions_of(number: usize) -> impl Iterator<Item = State<3>> {
    (0..number).map(move |i| billiard(TAU * i as f64 / number as f64))
}

fn billiards(number: usize) -> Ensemble<3> {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    scene.ensemble(directions_of(number), Rattle::new(0.01)).unwrap()
}

/// All that passes by, as text.
struct All(Vec<String>);

impl<const D: usize> Observer<D> for All {
    fn see(&mut self, before: &Sight<'_, D>, now: &Sight<'_, D>) {
        self.0.push(format!("{} {} {:?} {:?}", now.trajectory, now.time, now.positions, before.positions));
    }
    fn join(&mut self, next: Self) {
        self.0.extend(next.0);
    }
}

#[test]
fn observers_see_what_states_say() {
    let seen = billiards(150).observe(40, 20, || All(vec![]));
    let mut expected: HashMap<(usize, u32), String> = HashMap::new();
    let mut slowly = billiards(150);
    let mut before: Vec<_> = slowly.states().map(|state| state.positions().collect::<Vec<_>>()).collect();
    for sight in 0..2 {
        slowly.run(20);
        for (i, state) in slowly.states().enumerate() {
            let now: Vec<_> = state.positions().collect();
            let text = format!("{i} {} {now:?} {:?}", state.time(), before[i]);
            expected.insert((i, sight), text);
            before[i] = now;
        }
    }
    let group = |i: usize| i / 64;
    let mut order: Vec<_> = expected.keys().copied().collect();
    order.sort_by_key(|&(i, sight)| (group(i), sight, i));
    assert_eq!(seen.0.len(), 300);
    assert_eq!(seen.0, order.iter().map(|key| expected[key].clone()).collect::<Vec<_>>());
}

#[test]
fn means_and_histograms_are_those_of_all_numbers() {
    let height = |now: &Sight<'_, 3>| now.position().z;
    let empty = Histogram::of(height, -0.1, 0.1, 7).unwrap();
    let observers = || (Mean::of(height), empty.clone());
    let mut ensemble = billiards(100);
    let (mean, histogram) = ensemble.observe(300, 30, observers);
    assert_eq!(ensemble.steps(), 300);
    let mut heights = Vec::new();
    let mut slowly = billiards(100);
    for _ in 0..10 {
        slowly.run(30);
        heights.extend(slowly.states().map(|state| state.positions().next().unwrap().z));
    }
    let number = heights.len() as f64;
    let expected = heights.iter().sum::<f64>() / number;
    let variance = heights.iter().map(|z| (z - expected).powi(2)).sum::<f64>() / (number - 1.0);
    assert_eq!(mean.number(), 1000);
    assert!((mean.mean() - expected).abs() < 1e-15, "{} {expected}", mean.mean());
    assert!((mean.variance() / variance - 1.0).abs() < 1e-13);
    let counted = |from: f64, to: f64| heights.iter().filter(|&&z| from <= z && z < to).count() as u64;
    let width = 0.2 / 7.0;
    for (i, &count) in histogram.counts().iter().enumerate() {
        assert_eq!(count, counted(-0.1 + width * i as f64, -0.1 + width * (i + 1) as f64), "bin {i}");
    }
    assert_eq!(histogram.outside() + histogram.counts().iter().sum::<u64>(), 1000);
    assert!(histogram.outside() > 0);
    let nothing = billiards(3).observe(5, 10, || Mean::of(height));
    assert!(nothing.number() == 0 && nothing.mean().is_nan() && nothing.variance().is_nan());
    let empty = Histogram::of(|_: &Sight<'_, 3>| f64::NAN, 0.0, 1.0, 3).unwrap();
    let undefined = billiards(3).observe(5, 5, || empty.clone());
    assert_eq!((undefined.outside(), undefined.counts()), (3, &[0, 0, 0][..]));
}

/// Far from zero, few or many, and of all that is not a number nothing.
#[test]
fn means_keep_their_digits() {
    for number in [1, 2, 63, 64, 65, 200] {
        let quantity = |now: &Sight<'_, 3>| 1e9 + 2e-3 * now.trajectory as f64 + now.time;
        let mean = billiards(number).observe(4, 1, || Mean::of(quantity));
        let n = 4.0 * number as f64;
        assert_eq!(mean.number(), 4 * number as u64);
        // Numbers near 1e9 are rounded to 1.2e-7 (of the uniform spread of n things with spacing d: (n² − 1) d²/12).
        let expected = 1e9 + 1e-3 * (number as f64 - 1.0) + 0.025;
        assert!((mean.mean() - expected).abs() < 2.4e-7, "{number}: {}", mean.mean());
        let spread = |n: usize, d: f64| d * d * ((n * n) as f64 - 1.0) / 12.0;
        let expected = (spread(number, 2e-3) + spread(4, 0.01)) * n / (n - 1.0);
        // Of differences up to 0.4, each off by 1.2e-7 at most.
        assert!((mean.variance() - expected).abs() < 2.0 * 1.2e-7 * 0.4, "{number}: {}", mean.variance());
    }
    let mean = billiards(100)
        .observe(2, 1, || Mean::of(|now: &Sight<'_, 3>| if now.trajectory == 70 { f64::NAN } else { 1.0 }));
    assert!(mean.number() == 200 && mean.mean().is_nan() && mean.variance().is_nan());
}

#[test]
fn bins_hold_what_lies_between_their_ends() {
    let quantity = |now: &Sight<'_, 3>| {
        [-1.0, 0.0, 0.1_f64.next_down(), 0.3, 0.9, 1.0_f64.next_down(), 1.0][now.trajectory]
    };
    let empty = Histogram::of(quantity, 0.0, 1.0, 10).unwrap();
    let histogram = billiards(7).observe(1, 1, || empty.clone());
    assert_eq!(histogram.counts(), [2, 0, 0, 1, 0, 0, 0, 0, 0, 2]);
    assert_eq!(histogram.outside(), 2);
    for (from, to, bins) in [
        (0.0, 1.0, 0),
        (1.0, 1.0, 5),
        (2.0, 1.0, 5),
        (f64::NAN, 1.0, 5),
        (0.0, f64::NAN, 5),
        (f64::NEG_INFINITY, 1.0, 5),
        (0.0, f64::INFINITY, 5),
        (-1e308, 1e308, 5), // whose difference is not finite
    ] {
        let error = Histogram::of(quantity, from, to, bins).err().unwrap();
        assert!(matches!(error, rattle::Error::Bins { .. }), "{error}");
        let told = |x: f64| if x.abs() == 1e308 { format!("{x:e}") } else { x.to_string() };
        let found = format!("found {bins} from {} to {}", told(from), told(to));
        assert!(error.to_string().contains(&found), "{error}");
    }
}

/// The same for any number of threads, bit for bit.
#[test]
fn joined_in_order() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let observers = || {
            (
                Mean::of(|now: &Sight<'_, 3>| now.position().x),
                Section::of(|now: &Sight<'_, 3>| now.position().z),
            )
        };
        pool.install(|| {
            let (mean, section) = billiards(300).observe(200, 1, observers);
            format!("{:?} {:?} {:?}", mean.mean(), mean.variance(), section.crossings())
        })
    };
    let one = run(1);
    assert!(one.len() > 1000);
    assert_eq!(run(2), one);
    assert_eq!(run(3), one);
}

/// On the unit circle without force a particle of speed v comes back after 2π/v: exactly but for RATTLE's h²/24 of it.
#[test]
fn sections_know_when() {
    let circle = Scene::on(Pendulum { length: 1.0 });
    let speeds = [1.0, 1.25, 1.5, 2.0];
    let starts = speeds.map(|v| State::at([1.0, 0.0]).moving([0.0, v]));
    let mut ensemble = circle.ensemble(starts, Rattle::new(0.01)).unwrap();
    // Zero where x is; but not linear, so that the root takes some steps.
    let bent = |now: &Sight<'_, 2>| now.position().x * (5.0 * now.position().x).exp();
    let section = ensemble.observe(3000, 1, || Section::of(bent));
    let returns = section.return_times();
    assert!(returns.len() > 12, "{} returns", returns.len());
    for (trajectory, time) in returns {
        let v = speeds[trajectory];
        // The discrete motion turns by asin(h v) a step, at constant speed.
        let expected = TAU * 0.01 / (0.01 * v).asin();
        // The slopes at the ends are v, the speed between them asin(h v)/h: cubics are off by the difference (h v)³/6
        // times t (1 − t) (1 − 2t) ≤ 0.097, at either end.
        assert!((time - expected).abs() < 2.0 * 0.097 * (0.01 * v).powi(3) / 6.0 / v, "{time} {expected}");
    }
    for crossing in section.crossings() {
        let (q, p) = (crossing.positions[0], crossing.momenta[0]);
        // Outward by (h v)⁴/384 as any cubic, and by the same slopes: they point h v/2 off the chord.
        assert!(q.x.abs() < 1e-15 && (q.y + 1.0).abs() < 4e-9 && p.x > 0.0, "{q:?} {p:?}");
    }
}

potential! {
    struct Springs {}
    |x| x^2 / 2
}

/// Crossings of bodies of any mass, and of rigid bodies, are as near as those of unit masses: halved steps leave an
/// eighth of the error of momenta, and less of places.
#[test]
fn sections_know_masses() {
    const MASSES: [f64; 2] = [2.0, 0.1];
    let springs = Scene::points::<1>(2).masses(MASSES).with(Springs {});
    // Amplitudes 1 and 2, frequencies √(k/m), k = 1.
    let frequencies = MASSES.map(|mass| (1.0 / mass).sqrt());
    let off = |h: f64| {
        let start = State::of([[-1.0], [0.3]]).with_momenta([[0.0], [0.2]]);
        let mut simulation = springs.simulate(start, Lobatto::<4>::new(h)).unwrap();
        let mut section = Section::of(|now: &Sight<'_, 1>| now.positions[0].x);
        simulation.observe((3.0 / h) as u64, 1, &mut section).unwrap();
        let [crossing] = section.crossings() else { panic!("one crossing: {:?}", section.crossings()) };
        let t = 0.25 * TAU / frequencies[0];
        let (sin, cos) = (frequencies[1] * t).sin_cos();
        let place = 0.3 * cos + 0.2 / MASSES[1] / frequencies[1] * sin;
        let momentum = MASSES[1] * frequencies[1] * (0.2 / MASSES[1] / frequencies[1] * cos - 0.3 * sin);
        let [p0, p1] = [crossing.momenta[0].x, crossing.momenta[1].x];
        let places = (crossing.time - t).abs().max((crossing.positions[1].x - place).abs());
        [places, (p0 - MASSES[0] * frequencies[0]).abs().max((p1 - momentum).abs())]
    };
    let (coarse, fine) = (off(0.05), off(0.025));
    println!("{coarse:?} {fine:?}");
    // h⁴/384 and h³/96, with the tenth-mass body's frequency of 3.2 and amplitude of 0.7.
    assert!(coarse[0] < 2e-6 && coarse[1] < 1e-5, "{coarse:?}");
    assert!(fine[0] < 0.2 * coarse[0] && fine[1] < 0.3 * coarse[1], "{coarse:?} {fine:?}");
}

/// A body that turns about its third axis keeps its momentum at a crossing, and comes there after a quarter of a turn.
#[test]
fn sections_know_rigid_bodies() {
    let start = Rigid::start(&Matrix3::identity(), &Vector3::new(0.0, 0.0, 2.0));
    let body = Scene::rigid(Rigid::new([1.0, 1.5, 2.0]));
    let mut simulation = body.simulate(start, Dop853::new(0.1)).unwrap();
    let mut section = Section::of(|now: &Sight<'_, 9>| -now.position()[0]);
    simulation.observe(20, 1, &mut section).unwrap();
    let [crossing] = section.crossings() else { panic!("one crossing: {:?}", section.crossings()) };
    let m = crossing.momenta[0];
    // The cubic of cos t is off by h⁴/384.
    assert!((crossing.time - 0.25 * TAU).abs() < 0.1_f64.powi(4) / 384.0, "{crossing:?}");
    assert!((m[2] - 2.0).abs() < 1e-15 && m[0].abs() + m[1].abs() < 1e-15, "{crossing:?}");
}

#[test]
fn who_fails_is_not_seen_again() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let start = |i: u32| State::at([0.0, 0.0, SURFACE.r]).moving([if i == 3 { 7.0 } else { 0.5 }, 0.1, 0.0]);
    let mut ensemble = scene.ensemble((0..5).map(start), Rattle::new(0.02)).unwrap();
    let seen = ensemble.observe(200, 1, || All(vec![]));
    let Some(rattle::Error::Step { step, .. }) = ensemble.failure(3) else { panic!("nothing failed") };
    let of = |i: usize| seen.0.iter().filter(|text| text.starts_with(&format!("{i} "))).count();
    assert_eq!(of(3) as u64, step - 1);
    assert_eq!(of(2), 200);
}

/// Lanes that fail within a stretch, which is then gone through again: everything is shown once, as it is.
#[test]
fn what_is_gone_through_again_is_not_shown_again() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let start = |i: u32| {
        let speed = if i.is_multiple_of(9) { 3.0 + 0.08 * f64::from(i) } else { 0.7 };
        let angle = 0.37 * f64::from(i);
        State::at([0.0, 0.0, SURFACE.r]).moving([speed * angle.cos(), speed * angle.sin(), 0.0])
    };
    let of = |method| scene.ensemble((0..40).map(start), method).unwrap();
    let (steps, every) = (2500, 7);
    let mut ensemble = of(Rattle::new(0.02));
    let seen = ensemble.observe(steps, every, || All(vec![]));
    assert!(ensemble.failures().count() > 1, "{} failed", ensemble.failures().count());
    assert_eq!(ensemble.steps(), steps);

    let mut slowly = of(Rattle::new(0.02));
    let places = |ensemble: &Ensemble<3>| {
        ensemble.states().map(|state| state.positions().collect::<Vec<_>>()).collect::<Vec<_>>()
    };
    let (mut expected, mut before) = (vec![], places(&slowly));
    for _ in 0..steps / every {
        slowly.run(every);
        let now = places(&slowly);
        for (i, state) in slowly.states().enumerate().filter(|&(i, _)| slowly.failure(i).is_none()) {
            expected.push(format!("{i} {} {:?} {:?}", state.time(), now[i], before[i]));
        }
        before = now;
    }
    assert_eq!(seen.0.len(), expected.len());
    assert!(seen.0 == expected);
}

constraint! {
    struct Floor {}
    |x, y, z| z + 0 * x + 0 * y
}

potential! {
    /// Not a number where x < 0.
    struct Root {}
    |x, y, z| sqrt(x) + 0 * y + 0 * z
}

/// A step that gives a momentum that is not a number is not taken, and so not shown.
#[test]
fn what_is_not_a_number_is_not_shown() {
    let scene = Scene::on(Floor {}).with(Root {});
    let start = |speed: f64| State::at([0.1, 0.0, 0.0]).moving([speed, 0.0, 0.0]);
    for every in [1, 2] {
        let mut ensemble = scene.ensemble([start(3.0), start(-1.0)], Rattle::new(0.03)).unwrap();
        let seen = ensemble.observe(8, every, || Mean::of(|now: &Sight<'_, 3>| now.momentum().x)).mean();
        let Some(rattle::Error::Step { step: 4, .. }) = ensemble.failure(1) else { panic!("no failure") };
        assert!(seen.is_finite(), "every {every}: {seen}");
    }
}

/// Which trajectory, when, K and U.
struct Energies(Vec<(usize, f64, f64, f64)>);

impl<const D: usize> Observer<D> for Energies {
    fn see(&mut self, before: &Sight<'_, D>, now: &Sight<'_, D>) {
        assert_eq!(now.energy(), now.kinetic_energy() + now.potential_energy());
        if self.0.iter().all(|&(trajectory, ..)| trajectory != now.trajectory) {
            self.0.push((before.trajectory, before.time, before.kinetic_energy(), before.potential_energy()));
        }
        self.0.push((now.trajectory, now.time, now.kinetic_energy(), now.potential_energy()));
    }
    fn join(&mut self, next: Self) {
        self.0.extend(next.0);
    }
}

/// What each trajectory's own simulation says, with the energies of four sights of it; the largest difference.
fn energies_off<C, E, N, const D: usize>(
    scenes: &[Scene<C, E, N, D>],
    start: impl Fn(usize) -> State<D>,
    method: impl Method,
) -> f64
where
    C: rattle::scene::Hold<D> + 'static,
    E: rattle::effect::Effects<D> + 'static,
    N: rattle::bodies::Count,
{
    let each = scenes.iter().enumerate().map(|(i, scene)| (scene, start(i)));
    let mut ensemble = Ensemble::sweep(rattle::ensemble::Double, each, method.clone()).unwrap();
    let mut seen = ensemble.observe(30, 10, || Energies(vec![])).0;
    seen.sort_by(|a, b| (a.0, a.1).partial_cmp(&(b.0, b.1)).unwrap());
    let mut expected = Vec::new();
    for (i, scene) in scenes.iter().enumerate() {
        let mut alone = scene.simulate(start(i), method.clone()).unwrap();
        for sight in 0..4 {
            alone.run(if sight == 0 { 0 } else { 10 }).unwrap();
            expected.push((i, alone.time(), alone.kinetic_energy(), alone.potential_energy()));
        }
    }
    assert_eq!(seen.len(), expected.len());
    let mut worst = 0.0_f64;
    for (a, b) in seen.into_iter().zip(expected) {
        assert_eq!((a.0, a.1), (b.0, b.1));
        worst = [a.2 - b.2, a.3 - b.3].into_iter().fold(worst, |worst, off| larger(worst, off.abs()));
    }
    worst
}

potential! {
    /// A top's weight: its centre of mass lies on its third axis.
    struct Top { weight }
    |q: [[f64; 3]; 3]| weight * q[2][2]
}

phase_constraint! {
    /// The three-sphere.
    struct Hopf {}
    |q: [f64; 2], p: [f64; 2]| dot(q, q) + dot(p, p) - 1
}

hamiltonian! {
    /// Free fall.
    struct Falling { g }
    |q: [f64; 2], p: [f64; 2]| dot(p, p) / 2 + g * q[1]
}

/// Energies of a sight are those of the trajectory's own scene: in lanes, in sweeps, with masses, turning bodies, in
/// phase space. They are of order 1, and off by the rounding of some 30 steps.
#[test]
fn sights_know_their_energy() {
    let billiards: Vec<_> =
        (0..70).map(|i| Scene::on(SURFACE).with(Gravity { g: 0.5 + 0.02 * f64::from(i) })).collect();
    let off = energies_off(&billiards, |i| billiard(0.1 * i as f64).at_time(i as f64), Rattle::new(0.01));
    assert!(off < 2e-14, "in lanes {off:e}");
    let off = energies_off(&billiards[..3], |i| billiard(0.1 * i as f64), Lobatto::<3>::new(0.01));
    assert!(off < 1e-15, "alone {off:e}");

    let chains: Vec<_> = [1.0, 2.5]
        .map(|m| {
            let scene = Scene::points(3).link(Rod { length: 1.0 }, [[0, 1], [1, 2]]).pin(0, [0.0; 2]);
            scene.masses([1.0, m, 3.0]).with(PlanarGravity { g: 2.0 })
        })
        .into();
    let start =
        |_| State::of([[0.0, 0.0], [0.6, 0.8], [1.4, 0.2]]).with_momenta([[0.0; 2], [0.8, -0.6], [0.0; 2]]);
    let start = |i: usize| chains[i].project(&start(i)).unwrap();
    let off = energies_off(&chains, start, Rattle::new(0.01));
    assert!(off < 1e-14, "linked {off:e}");

    let tops: Vec<_> =
        [1.0, 1.5].map(|i| Scene::rigid(Rigid::new([i, 2.0, 2.2])).with(Top { weight: i })).into();
    let start = |_| Rigid::start(&Matrix3::identity(), &Vector3::new(0.3, 0.1, 2.0));
    let off = energies_off(&tops, start, Rattle::new(0.01));
    assert!(off < 1e-14, "rigid {off:e}");

    let fibres: Vec<_> = [0.3, 0.4].map(|g| Scene::in_phase_space(Hopf {}, Falling { g })).into();
    let start = |i: usize| fibres[i].project(&State::at([-0.55, -0.83])).unwrap();
    let off = energies_off(&fibres, start, Rattle::new(0.01));
    assert!(off < 1e-14, "in phase space {off:e}");
}

/// Sections are found on the way between sights; energies there are those of the places there.
#[test]
fn sections_may_be_of_energies() {
    let potential = |now: &Sight<'_, 3>| now.potential_energy();
    let height = |now: &Sight<'_, 3>| now.position().z;
    let (by_energy, by_height) =
        billiards(20).observe(500, 1, || (Section::of(potential), Section::of(height)));
    assert!(by_height.crossings().len() > 10);
    assert_eq!(by_energy.crossings(), by_height.crossings()); // U = z
}

/// Starts have times of their own, and who fails rests at the time of that.
#[test]
fn snapshots_tell_times() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let start = |i: u32| {
        let speed = if i == 66 { 7.0 } else { 0.5 };
        State::at([0.0, 0.0, SURFACE.r]).moving([speed, 0.1, 0.0]).at_time(0.1 * f64::from(i))
    };
    let mut ensemble = scene.ensemble((0..70).map(start), Rattle::new(0.02)).unwrap();
    let mut times = vec![];
    let copy = |snapshot: &rattle::ensemble::Snapshot<3>| {
        times.clone_from(&snapshot.times);
        Ok::<(), ()>(())
    };
    ensemble.stream(200, 100, copy).unwrap();
    let Some(rattle::Error::Step { time, .. }) = ensemble.failure(66) else { panic!("nothing failed") };
    assert_eq!(times[66], *time);
    assert_eq!(times, ensemble.states().map(|state| state.time()).collect::<Vec<_>>());
    assert!((times[69] - 10.9).abs() < 1e-14 && times[66] < 10.0);
    let none = scene.ensemble([], Rattle::new(0.02)).unwrap().snapshot();
    assert!(none.times.is_empty() && none.positions.is_empty());
}

#[test]
fn snapshots_come_in_turn_while_the_ensemble_goes_on() {
    let mut ensemble = billiards(200);
    let (mut steps, mut last, caller) = (vec![], None, thread::current().id());
    ensemble
        .stream(110, 25, |snapshot| {
            assert_ne!(thread::current().id(), caller);
            assert_eq!((snapshot.positions.len(), snapshot.momenta.len()), (200, 200));
            steps.push(snapshot.steps);
            last = Some(snapshot.clone());
            Ok::<(), ()>(())
        })
        .unwrap();
    assert_eq!(steps, [25, 50, 75, 100]);
    assert_eq!(ensemble.steps(), 110);
    let mut other = billiards(200);
    other.run(100);
    let (last, expected) = (last.unwrap(), other.snapshot());
    assert_eq!((last.positions, last.momenta), (expected.positions, expected.momenta));
    let mut taken = 0;
    let stopped = billiards(10).stream(100_000, 10, |_| {
        taken += 1;
        if taken == 3 { Err("full") } else { Ok(()) }
    });
    assert_eq!((stopped, taken), (Err("full"), 3));
}

/// The uncertainty of a mean along one trajectory, of steps that remember some twenty before, is what the means of 64
/// trajectories are apart by; by the variance it were a seventh. And of one that remembers nothing it is that by the
/// variance, for any number of sights.
#[test]
fn means_know_what_they_are_off_by() {
    let heat = rattle::effect::Langevin { friction: 1.0, temperature: 0.5, seed: 4 };
    let harmonic = rattle::potentials::planar::Harmonic { stiffness: 1.0, centre: [0.0, 0.0] };
    let scene = Scene::point().with(harmonic).with(heat);
    let starts = || (0..64).map(|_| State::at([0.0, 0.0]));
    let square = |now: &Sight<'_, 2>| now.position().norm_squared();
    let mut ensemble = scene.ensemble(starts(), Baoab::new(0.05)).unwrap();
    let each = ensemble.observe(20_000, 1, || Each::of(|| Mean::of(square)));
    let means: Vec<_> = (0..64).map(|i| each.get(i).unwrap()).collect();
    let spread = (means.iter().map(|mean| (mean.mean() - 1.0).powi(2)).sum::<f64>() / 64.0).sqrt();
    let told = (means.iter().map(|mean| mean.uncertainty().powi(2)).sum::<f64>() / 64.0).sqrt();
    let naive = (means[0].variance() / 20_000.0).sqrt();
    println!("{spread} {told} {naive} {}", each.uncertainty());
    // 64 means tell their spread to 9 %; the largest of some errors, each known to 3 to 18 %, is a little more.
    assert!((0.8..1.3).contains(&(told / spread)) && naive < 0.3 * spread, "{spread} {told} {naive}");
    assert!((each.uncertainty() * 8.0 / spread - 1.0).abs() < 0.1, "{} {spread}", each.uncertainty());

    // Of several trajectories at once sights are not one after the other.
    let mut again = scene.ensemble(starts(), Baoab::new(0.05)).unwrap();
    let all = again.observe(100, 1, || Mean::of(square));
    assert!(all.number() == 6400 && all.uncertainty().is_nan());
    for sights in [1023, 1024, 1984, 2047, 20_000] {
        let mut ratios = Vec::new();
        for seed in 0..60 {
            let white = Brownian::new(1.0, 1.0, seed, 1.0);
            let mut run = Scene::point().simulate(State::at([0.0]), white).unwrap();
            let last = std::cell::Cell::new(0.0);
            let mut steps = Mean::of(|now: &Sight<'_, 1>| now.position().x - last.replace(now.position().x));
            run.observe(sights, 1, &mut steps).unwrap();
            ratios.push(steps.uncertainty() / (steps.variance() / sights as f64).sqrt());
        }
        let mean = ratios.iter().sum::<f64>() / 60.0;
        println!("{sights}: {mean}");
        assert!(if sights < 1024 { mean.is_nan() } else { (0.93..1.15).contains(&mean) }, "{sights}: {mean}");
    }
}

/// Sections by methods whose momenta are of another time, or of none: where the path is straight, or a parabola, they
/// are exact.
#[test]
fn sections_by_methods_whose_momenta_are_beside_the_time() {
    let pull = || Scene::point().with(rattle::potentials::ConstantForce { force: [1.0, 0.0, 0.0] });
    let height = |now: &Sight<'_, 3>| now.position().x;
    let start = State::at([-0.0885, 0.0, 0.0]);
    let mut creeping = pull().simulate(start.clone(), Brownian::new(1.0, 0.0, 1, 0.1)).unwrap();
    let mut section = Section::of(height);
    creeping.observe(1, 1, &mut section).unwrap();
    let mut lanes = pull().ensemble([start], Brownian::new(1.0, 0.0, 1, 0.1)).unwrap();
    let side_by_side = lanes.observe(1, 1, || Section::of(height));
    for found in [section.crossings()[0].time, side_by_side.crossings()[0].time] {
        assert!((found - 0.0885).abs() < 1e-15, "{found}");
    }
    let spring = rattle::potentials::planar::Harmonic { stiffness: 1.0, centre: [1.0, 0.0] };
    let start = State::at([-0.05, 0.0]);
    let mut creeping = Scene::point().with(spring).simulate(start, Brownian::new(1.0, 0.0, 1, 0.1)).unwrap();
    let mut section = Section::of(|now: &Sight<'_, 2>| now.position().x);
    creeping.observe(1, 1, &mut section).unwrap();
    assert_eq!(section.crossings()[0].momenta[0].norm(), 0.0);
    let h = 0.5;
    let start = State::at([-0.11625, 0.0, 0.0]).moving([1.0 + 0.5 * h, 0.0, 0.0]); // momenta of h/2
    let mut falling = pull().simulate(start, Leapfrog::new(h)).unwrap();
    let mut section = Section::of(height);
    falling.observe(1, 1, &mut section).unwrap();
    let exact = (1.0_f64 + 2.0 * 0.11625).sqrt() - 1.0;
    let found = section.crossings()[0].time;
    assert!((found - exact).abs() < 1e-14, "{found} for {exact}");
}
