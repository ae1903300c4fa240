//! What is kept of ensembles that are not stored: means, histograms, sections; and snapshots for a consumer beside.

mod common;
use common::*;
use rattle::ensemble::{Ensemble, Histogram, Mean, Observer, Section, Sight};
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
    let observers = || (Mean::of(height), Histogram::of(height, -0.1, 0.1, 7));
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
    let undefined = billiards(3).observe(5, 5, || Histogram::of(|_: &Sight<'_, 3>| f64::NAN, 0.0, 1.0, 3));
    assert_eq!((undefined.outside(), undefined.counts()), (3, &[0, 0, 0][..]));
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
    let section = ensemble.observe(3000, 1, || Section::of(|now: &Sight<'_, 2>| now.position().x));
    let returns = section.return_times();
    assert!(returns.len() > 12, "{} returns", returns.len());
    for (trajectory, time) in returns {
        let v = speeds[trajectory];
        // The discrete motion turns by asin(h v) a step, at constant speed.
        let expected = TAU * 0.01 / (0.01 * v).asin();
        // The slopes at the ends are v, the speed between them asin(h v)/h: cubics are off by the difference (h v)³/6 times
        // t (1 − t) (1 − 2t) ≤ 0.097, at either end.
        assert!((time - expected).abs() < 2.0 * 0.097 * (0.01 * v).powi(3) / 6.0 / v, "{time} {expected}");
    }
    for crossing in section.crossings() {
        let (q, p) = (crossing.positions[0], crossing.momenta[0]);
        // Outward by (h v)⁴/384 as any cubic, and by the same slopes: they point h v/2 off the chord.
        assert!(q.x.abs() < 1e-15 && (q.y + 1.0).abs() < 4e-9 && p.x > 0.0, "{q:?} {p:?}");
    }
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
