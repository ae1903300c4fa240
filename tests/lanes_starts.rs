//! Starts that a lane cannot hold: what is shown of the trajectories beside them, and of them, is where they are, and
//! nobody's steps change by a bit.

use rattle::bodies::{Count, Many, One};
use rattle::effect::{Effects, Langevin};
use rattle::ensemble::{InstructionSet, Snapshot};
use rattle::links::planar::Rod as PlanarRod;
use rattle::links::{Between, Rod};
use rattle::method::Method;
use rattle::nalgebra::{Rotation3, SVector, Vector3};
use rattle::network::Network;
use rattle::potentials::Gravity;
use rattle::prelude::*;
use rattle::scene::Hold;
use rattle::surfaces::Sphere;
use rattle::watch::{Columns, Recorder, Rows};
use std::collections::BTreeMap;

/// Time, positions and momenta.
type Place<const D: usize> = (f64, Vec<SVector<f64, D>>, Vec<SVector<f64, D>>);

/// What was shown of each trajectory: steps, and what was shown before and after them.
#[derive(Default, PartialEq, Debug)]
struct Seen<const D: usize>(BTreeMap<usize, Vec<(u64, [Place<D>; 2])>>);

impl<const D: usize> Observer<D> for Seen<D> {
    fn see(&mut self, before: &Sight<'_, D>, now: &Sight<'_, D>) {
        let place = |of: &Sight<'_, D>| (of.time, of.positions.to_vec(), of.momenta.to_vec());
        self.0.entry(now.trajectory).or_default().push((now.step, [place(before), place(now)]));
    }
    fn join(&mut self, next: Self) {
        self.0.extend(next.0);
    }
}

/// Where trajectories are, as an ensemble shows them.
fn shown<const D: usize>(ensemble: &Ensemble<D>) -> Vec<Place<D>> {
    let (snapshot, n) = (ensemble.snapshot(), ensemble.bodies());
    let of = |i: usize| {
        let bodies = i * n..(i + 1) * n;
        let [q, p] = [&snapshot.positions, &snapshot.momenta].map(|of| of[bodies.clone()].to_vec());
        (snapshot.times[i], q, p)
    };
    (0..ensemble.len()).map(of).collect()
}

/// Where trajectories are, each asked by itself.
fn told<const D: usize>(ensemble: &Ensemble<D>) -> Vec<Place<D>> {
    ensemble.states().map(|of| (of.time(), of.positions().collect(), of.momenta().collect())).collect()
}

/// Whatever shows trajectories shows where they are, and those in `well` are where they are beside copies of them.
/// Nothing is said of the others, which need not go on.
fn undisturbed<P: Precision, C: Hold<D> + 'static, E: Effects<D>, N: Count, S: Method, const D: usize>(
    precision: P,
    scene: &Scene<C, E, N, D>,
    starts: &[State<D>],
    well: &[usize],
    method: &S,
) {
    let begin = |starts: Vec<State<D>>| scene.ensemble_in(precision, starts, method.clone()).unwrap();
    let ill = || begin(starts.to_vec());
    let all_well = || {
        let copy = |i: usize| if well.contains(&i) { i } else { *well.first().unwrap_or(&i) };
        begin((0..starts.len()).map(|i| starts[copy(i)].clone()).collect())
    };
    let plan = ill().plan();
    assert_eq!(plan.in_lanes, if InstructionSet::widest().fuses() { starts.len() } else { 0 }, "{plan:?}");
    let (mut one, mut other) = (ill(), all_well());
    for (i, (place, start)) in shown(&one).iter().zip(starts).enumerate() {
        let off = place.1.iter().zip(start.positions()).map(|(q, start)| (q - start).norm());
        assert!(place.0 == start.time() && off.sum::<f64>() < 1e-6, "trajectory {i}: {place:?}");
    }
    for steps in [0, 1, 2, 61, 70] {
        one.run(steps);
        other.run(steps);
        assert_eq!(shown(&one), told(&one), "after {} steps", one.steps());
        let [shown, beside] = [&one, &other].map(shown);
        for &i in well {
            assert_eq!(shown[i], beside[i], "trajectory {i} after {} steps", one.steps());
        }
    }
    let mut again = ill();
    again.resume(&one.checkpoint()).unwrap();
    assert_eq!(shown(&again), shown(&one));
    for ensemble in [&mut one, &mut again, &mut other] {
        ensemble.run_until(142.5 * method.step_size()).unwrap();
    }
    assert_eq!((shown(&again), told(&again)), (shown(&one), told(&one)));

    let first = told(&ill());
    let [seen, beside] = [ill(), all_well()].map(|mut of| of.observe(70, 2, Seen::default).0);
    for (i, seen) in &seen {
        assert_eq!(seen[0].1[0], first[*i], "trajectory {i} at first");
        for two in seen.windows(2) {
            assert_eq!(two[1].1[0], two[0].1[1], "trajectory {i} after {} steps", two[0].0);
        }
    }
    for i in well {
        assert_eq!(seen[i], beside[i], "trajectory {i}");
    }
    let [streamed, beside] = [ill(), all_well()].map(|mut of| {
        let mut streamed = Vec::new();
        let keep = |now: &Snapshot<D>| -> Result<(), ()> {
            streamed.push((now.times.clone(), now.positions.clone()));
            Ok(())
        };
        of.stream(6, 2, keep).unwrap();
        streamed
    });
    for ((times, positions), beside) in streamed.iter().zip(&beside) {
        for &i in well {
            let n = positions.len() / times.len();
            let bodies = i * n..(i + 1) * n;
            assert_eq!(times[i], beside.0[i]);
            assert_eq!(positions[bodies.clone()], beside.1[bodies]);
        }
    }
}

/// Four rods hang from pins, and rods go along between their ends.
fn ladder() -> Scene<Network<2>, impl Effects<2> + Clone + 'static, Many, 2> {
    let mut scene = Scene::points::<2>(8)
        .link(PlanarRod { length: 1.0 }, [[0, 4], [1, 5], [2, 6], [3, 7]])
        .link(PlanarRod { length: 0.5 }, [[4, 5], [5, 6], [6, 7]]);
    for i in 0..4 {
        scene = scene.pin(i, [0.5 * i as f64, 0.0]);
    }
    scene
}

/// All rods at this angle; where it is zero they are along those between them.
fn rungs(angle: f64) -> State<2> {
    let (sin, cos) = angle.sin_cos();
    let foot = |i: usize| [0.5 * i as f64, 0.0];
    let places = (0..4).map(foot).chain((0..4).map(|i| [foot(i)[0] + cos, sin]));
    State::of(places).with_momenta((0..8).map(|i| if i < 4 { [0.0; 2] } else { [-sin, cos] }))
}

/// The first start and one in the middle are where links depend on each other.
fn ladders(number: usize) -> (Vec<State<2>>, Vec<usize>) {
    let lies = |i: &usize| *i == 0 || *i == 5;
    let angle = |i: usize| if lies(&i) { 0.0 } else { 0.3 + 0.1 * i as f64 };
    ((0..number).map(|i| rungs(angle(i))).collect(), (0..number).filter(|i| !lies(i)).collect())
}

fn ladders_by<E: Effects<2>>(scene: &Scene<Network<2>, E, Many, 2>, method: &impl Method) {
    for number in [3, 20] {
        let (starts, well) = ladders(number);
        undisturbed(Double, scene, &starts, &well, method);
    }
}

#[test]
fn links_that_depend_on_each_other() {
    ladders_by(&ladder(), &Rattle::new(0.02));
    ladders_by(&ladder(), &Composition::new(SUZUKI_1990_ORDER_4, 0.02));
}

#[test]
fn links_that_are_stirred() {
    let bath = Langevin { friction: 0.4, temperature: 1e-3, seed: 3 };
    ladders_by(&ladder().with(bath), &Rattle::new(0.02));
    ladders_by(&ladder().with(bath), &Baoab::new(0.02));
    ladders_by(&ladder(), &Brownian::new(1.5, 0.4, 9, 1e-4));
}

/// What a section and a recorder keep of a bar beside one that lies.
#[test]
fn links_as_watched() {
    let (starts, _) = ladders(3);
    let begin = || ladder().ensemble(starts.clone(), Rattle::new(0.02)).unwrap();
    let up = begin().observe(4, 1, || Section::of(|now: &Sight<'_, 2>| now.positions[4].y - 0.1));
    assert_eq!(up.crossings().iter().filter(|crossing| crossing.trajectory != 0).count(), 0);
    let columns = Columns::new().positions();
    let recorder = begin().observe(4, 1, || Recorder::of(&columns, Rows::default()));
    let rows = recorder.finish().unwrap();
    for row in 0..rows.len() {
        let y = rows.numbers("q").nth(row).unwrap()[2 * 4 + 1];
        let trajectory = rows.trajectories[row];
        assert!(trajectory == 0 || y > 0.3, "{trajectory}: {y}");
    }
}

/// All go by themselves: a body in the middle of two rods, of which one equation is more than is needed.
#[test]
fn links_that_depend_on_each_other_everywhere() {
    let scene = Scene::points(3)
        .link(Rod { length: 1.0 }, [[0, 1], [1, 2]])
        .link(Between { fraction: 0.5 }, [[0, 2, 1]])
        .with(Gravity { g: 1.0 });
    let start = |i: i32| {
        let (sin, cos) = (0.3 * f64::from(i)).sin_cos();
        let places = [[0.0, 0.0, 0.2], [sin, 0.0, 0.2 - cos], [2.0 * sin, 0.0, 0.2 - 2.0 * cos]];
        scene.project(&State::of(places).with_momenta([[0.0, 0.0, 0.1]; 3])).unwrap().at_time(f64::from(i))
    };
    let starts: Vec<_> = (0..2).map(start).collect();
    undisturbed(Double, &scene, &starts, &[], &Rattle::new(0.02));
    let mut ensemble = scene.ensemble(starts, Rattle::new(0.02)).unwrap();
    ensemble.run(50);
    for (i, seen) in ensemble.observe(3, 1, Seen::default).0 {
        let times = seen.iter().map(|(_, [before, now])| [before.0, now.0]);
        let due = (50..53).map(|step| [step, step + 1].map(|step| i as f64 + 0.02 * f64::from(step)));
        for (found, due) in times.zip(due) {
            assert!((found[0] - due[0]).abs() + (found[1] - due[1]).abs() < 1e-14, "{found:?}, not {due:?}");
        }
    }
}

/// The first, and every fifth, is this fast, others are slow.
fn balls(number: usize, r: f64, fast: f64) -> (Vec<State<3>>, Vec<usize>) {
    let is_fast = |i: &usize| i.is_multiple_of(5);
    let start = |i: usize| {
        let ((sin, cos), speed) = ((0.3 + 0.1 * i as f64).sin_cos(), if is_fast(&i) { fast } else { 1.0 });
        State::at([0.0, r * sin, r * cos]).moving([0.0, speed * cos, -speed * sin])
    };
    ((0..number).map(start).collect(), (0..number).filter(|i| !is_fast(i)).collect())
}

/// Squares of momenta are beyond numbers.
#[test]
fn balls_that_are_too_fast() {
    let scene = Scene::on(Sphere { r: 1.0 });
    for number in [2, 40] {
        let (starts, well) = balls(number, 1.0, 1e200);
        undisturbed(Double, &scene, &starts, &well, &Rattle::new(0.01));
        let (starts, well) = balls(number, 1.0, 1e20);
        undisturbed(Single, &scene, &starts, &well, &Rattle::new(0.01));
    }
}

/// So are their products with normals.
#[test]
fn balls_that_are_faster_still() {
    let bath = Langevin { friction: 0.1, temperature: 0.1, seed: 3 };
    let free = || Scene::on(Sphere { r: 10.0 });
    for number in [2, 40] {
        let (starts, well) = balls(number, 10.0, 1e308);
        undisturbed(Double, &free(), &starts, &well, &Composition::new(SUZUKI_1990_ORDER_4, 0.01));
        undisturbed(Double, &free().with(bath), &starts, &well, &Rattle::new(0.01));
        undisturbed(Double, &free().with(bath), &starts, &well, &Baoab::new(0.01));
        undisturbed(Double, &free(), &starts, &well, &Brownian::new(1.5, 0.1, 9, 1e-3));
    }
}

/// Slow enough for a step of 100.
const SLOW: f64 = 1e-5;

/// The first, and every fifth, turns beyond numbers.
fn tops_by<E: Effects<9>>(scene: &Scene<Rigid, E, One, 9>, method: &impl Method) {
    let is_fast = |i: &usize| i.is_multiple_of(5);
    let start = |i: usize| {
        let turned = Rotation3::from_euler_angles(0.02 * i as f64, 0.1, 0.3);
        Rigid::start(turned.matrix(), &(if is_fast(&i) { 1e307 } else { SLOW } * Vector3::new(1.0, 2.0, 3.0)))
    };
    for number in [2, 20] {
        let starts: Vec<_> = (0..number).map(start).collect();
        let well: Vec<_> = (0..number).filter(|i| !is_fast(i)).collect();
        undisturbed(Double, scene, &starts, &well, method);
    }
}

#[test]
fn tops_that_turn_too_fast() {
    let bath = Langevin { friction: 0.1, temperature: SLOW * SLOW, seed: 3 };
    let top = || Scene::rigid(Rigid::new([0.6, 0.8, 1.0]));
    tops_by(&top(), &Rattle::new(100.0));
    tops_by(&top().with(bath), &Rattle::new(100.0));
    tops_by(&top(), &Brownian::new(1.5, SLOW * SLOW, 9, 100.0));
}

/// No crossing is invented, and no energy is lost.
#[test]
fn balls_as_watched() {
    let starts = [
        State::at([1.0, 0.0, 0.0]).moving([0.0, 1e200, 0.0]),
        State::at([0.0, 0.6, 0.8]).moving([1.0, 0.0, 0.0]),
    ];
    let mut ensemble = Scene::on(Sphere { r: 1.0 }).ensemble(starts, Rattle::new(0.01)).unwrap();
    let (up, mean) = ensemble.observe(2, 1, || {
        let up = Section::of(|now: &Sight<'_, 3>| now.position().z - 0.5);
        (up, Mean::over_time(|now: &Sight<'_, 3>| now.kinetic_energy()))
    });
    assert!(up.crossings().is_empty());
    assert!((mean.mean() - 0.5).abs() < 1e-9, "{}", mean.mean());
}
