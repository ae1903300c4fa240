//! Sweeps over networks in lanes: each trajectory as a simulation of its own scene but for rounding.

use crate::common::larger;
use crate::lanes_linked::{Told, check, off_alone};
use rattle::bodies::Many;
use rattle::composition::SUZUKI_1990_ORDER_4;
use rattle::effect::Effects;
use rattle::links::planar::Rod;
use rattle::method::Method;
use rattle::network::Network;
use rattle::potentials::planar::{Gravity, weights};
use rattle::prelude::*;
use rattle::scene::Hold;

/// A number that differs from trajectory to trajectory.
fn spread(i: usize, from: f64, to: f64) -> f64 {
    from + (to - from) * (0.618 * i as f64).fract()
}

/// Rods of these lengths that hang from a pin at this angle, and swing.
fn start(lengths: [f64; 2], lean: f64) -> State<2> {
    let [a, b] = lengths.map(|length| [length * lean.sin(), -length * lean.cos()]);
    let ways = lengths.map(|length| [0.4 * length * lean.cos(), 0.4 * length * lean.sin()]);
    let (end, way) = ([a[0] + b[0], a[1] + b[1]], [ways[0][0] + ways[1][0], ways[0][1] + ways[1][1]]);
    State::of([[0.0; 2], a, end]).with_momenta([[0.0; 2], ways[0], way])
}

fn starts(number: usize, lengths: impl Fn(usize) -> [f64; 2]) -> Vec<State<2>> {
    (0..number).map(|i| start(lengths(i), spread(i, 0.3, 1.4))).collect()
}

/// How far places and momenta are off those of simulations after some steps.
fn off<P: Precision, C: Hold<2> + 'static, E: Effects<2> + 'static, S: Method>(
    precision: P,
    scenes: &[Scene<C, E, Many, 2>],
    starts: &[State<2>],
    method: &S,
) -> f64 {
    let starts: Vec<_> =
        scenes.iter().zip(starts).map(|(scene, start)| scene.project(start).unwrap()).collect();
    let mut sweep =
        Ensemble::sweep(precision, scenes.iter().zip(starts.iter().cloned()), method.clone()).unwrap();
    sweep.run(50);
    let each = scenes.iter().zip(&starts).enumerate();
    each.map(|(i, (scene, start))| off_alone(&sweep, i, scene, start, method, 50)).fold(0.0, larger)
}

const LENGTHS: fn(usize) -> [f64; 2] = |i| [spread(i, 0.5, 1.5), spread(i + 7, 0.5, 1.5)];

#[test]
fn lengths_and_gravity() {
    let scene = |i: usize| {
        let [a, b] = LENGTHS(i);
        Scene::points(3)
            .link_each([(Rod { length: a }, [0, 1]), (Rod { length: b }, [1, 2])])
            .pin(0, [0.0; 2])
            .with(Gravity { g: spread(i, 0.2, 2.0) })
    };
    let (scenes, starts): (Vec<_>, _) = ((0..70).map(scene).collect(), starts(70, LENGTHS));
    check(&[
        off(Double, &scenes, &starts, &Rattle::new(0.01)),
        off(Compensated, &scenes, &starts, &Composition::new(SUZUKI_1990_ORDER_4, 0.02)),
        off(Double, &scenes[..3], &starts, &PositionVerlet::new(0.01)),
    ]);
}

/// Weights know the masses, and so are effects of all bodies at once.
#[test]
fn masses_and_weights() {
    let scene = |i: usize| {
        let masses = [1.0, spread(i, 0.3, 3.0), spread(i + 3, 0.3, 3.0)];
        Scene::points(3)
            .link(Rod { length: 1.0 }, [[0, 1], [1, 2]])
            .pin(0, [0.0; 2])
            .masses(masses)
            .with(weights(1.0, masses))
    };
    let (scenes, starts): (Vec<_>, _) = ((0..70).map(scene).collect(), starts(70, |_| [1.0; 2]));
    check(&[
        off(Double, &scenes, &starts, &Rattle::new(0.01)),
        off(Compensated, &scenes, &starts, &Composition::new(SUZUKI_1990_ORDER_4, 0.02)),
    ]);
}

fn double(lengths: [f64; 2], g: f64) -> Scene<Network<2>, impl Effects<2> + 'static, Many, 2> {
    let [a, b] = lengths.map(|length| Rod { length });
    Scene::points(3).link_each([(a, [0, 1]), (b, [1, 2])]).pin(0, [0.0; 2]).with(Gravity { g })
}

/// All that can be told of a trajectory.
fn bits<const D: usize>(ensemble: &Ensemble<D>, i: usize) -> String {
    format!("{:?} {}", ensemble.state(i), ensemble.failure(i).is_some())
}

/// A sweep over equal scenes is an ensemble.
#[test]
fn equal_scenes_are_an_ensemble() {
    let starts = starts(70, |_| [1.0; 2]);
    let scenes: Vec<_> = (0..70).map(|_| double([1.0; 2], 1.0)).collect();
    let method = Composition::new(SUZUKI_1990_ORDER_4, 0.05);
    let mut sweep = Ensemble::sweep(Double, scenes.iter().zip(starts.iter().cloned()), method).unwrap();
    let mut ensemble = scenes[0].ensemble(starts, method).unwrap();
    sweep.run(200);
    ensemble.run(200);
    (0..70).for_each(|i| assert_eq!(bits(&sweep, i), bits(&ensemble, i), "{i}"));
}

/// Bits depend on no neighbour, no division of the run, and not on a checkpoint, also where some trajectories fail, or
/// their steps have to be divided. Of each three trajectories two have the same masses, which are in lanes without the
/// third one that does not.
#[test]
fn neighbours_are_not_disturbed() {
    undisturbed(|i| double(some_short(i), some_gravity(i)));
}

#[test]
#[cfg(long)]
fn neighbours_of_other_masses_are_not_disturbed() {
    undisturbed(|i| double(some_short(i), some_gravity(i)).masses(some_alike(i)));
}

#[test]
#[cfg(long)]
fn neighbours_of_other_weights_are_not_disturbed() {
    undisturbed(|i| {
        let (g, masses) = (some_gravity(i), some_alike(i));
        double(some_short(i), g).masses(masses).with(weights(g, masses))
    });
}

fn some_short(i: usize) -> [f64; 2] {
    if i.is_multiple_of(40) { [0.02, 1.0] } else { LENGTHS(i) }
}

fn some_alike(i: usize) -> [f64; 3] {
    if i % 3 == 1 { [1.0, spread(i, 0.3, 3.0), 1.0] } else { [1.0, 3.0, 1.7] }
}

fn some_gravity(i: usize) -> f64 {
    spread(i, 0.2, 2.0)
}

fn undisturbed<E: Effects<2> + 'static>(scene: impl Fn(usize) -> Scene<Network<2>, E, Many, 2>) {
    let number = 70;
    let scenes: Vec<_> = (0..number).map(scene).collect();
    let starts: Vec<_> = (0..number)
        .map(|i| {
            let at_rest = start(some_short(i), spread(i, 0.3, 1.4)).with_momenta([[0.0; 2]; 3]);
            let fast = if i.is_multiple_of(40) { 3.0 } else { 0.3 };
            scenes[i].project(&at_rest.with_momenta([[0.0; 2], [fast, 0.1], [-fast, 0.2]])).unwrap()
        })
        .collect();
    for halvings in [0, 3] {
        let of = |which: &[usize]| {
            let trajectories = which.iter().map(|&i| (&scenes[i], starts[i].clone()));
            Ensemble::sweep(Double, trajectories, Rattle::new(0.05)).unwrap().retry(halvings)
        };
        the_same_bits(number, of, halvings == 0);
    }
}

/// So many trajectories, of which every fortieth may fail, beside each other, beside two of three, in parts, and again.
pub(crate) fn the_same_bits<const D: usize>(
    number: usize,
    of: impl Fn(&[usize]) -> Ensemble<D>,
    some_fail: bool,
) {
    let all: Vec<_> = (0..number).collect();
    let mut first = of(&all);
    let at_first = first.checkpoint();
    first.run(80);
    assert!(!some_fail || first.failures().count() > 0);
    assert!(first.failures().all(|(i, _)| i.is_multiple_of(40)));
    let some: Vec<_> = all.iter().copied().filter(|i| i % 3 != 1).collect();
    let mut other = of(&some);
    other.run(80);
    some.iter().enumerate().for_each(|(place, &i)| assert_eq!(bits(&other, place), bits(&first, i), "{i}"));
    let mut parts = of(&all);
    for steps in [1, 63, 2, 14] {
        parts.run(steps);
        let (record, mut again) = (parts.checkpoint(), of(&all));
        again.resume(&record).unwrap();
        parts = again;
    }
    all.iter().for_each(|&i| assert_eq!(bits(&parts, i), bits(&first, i), "{i} in parts"));
    // Those that have ended go on from where they were before.
    for _ in 0..2 {
        parts.resume(&at_first).unwrap();
        parts.run(80);
        all.iter().for_each(|&i| assert_eq!(bits(&parts, i), bits(&first, i), "{i} from the start again"));
    }
}

/// Networks of other topologies are no sweep in lanes, and move all the same.
#[test]
fn other_topologies_go_alone() {
    let scene = |i: usize| {
        let free = Scene::points(3).link(Rod { length: 1.0 }, [[0, 1], [1, 2]]).with(Gravity { g: 1.0 });
        if i.is_multiple_of(2) { free } else { free.pin(0, [0.0; 2]) }
    };
    let (scenes, starts): (Vec<_>, _) = ((0..30).map(scene).collect(), starts(30, |_| [1.0; 2]));
    assert_eq!(off(Double, &scenes, &starts, &Rattle::new(0.01)), 0.0);
    let scene = |i: usize| {
        let ends = if i < 20 { [[0, 1], [1, 2]] } else { [[0, 1], [2, 1]] };
        Scene::points(3).link(Rod { length: 1.0 }, ends).with(Gravity { g: 1.0 })
    };
    let scenes: Vec<_> = (0..30).map(scene).collect();
    assert_eq!(off(Double, &scenes, &starts, &Rattle::new(0.01)), 0.0);
}

/// Energies and forces are those of the scene of each trajectory.
#[test]
fn sights_know_their_scenes() {
    let masses = |i: usize| [1.0, spread(i, 0.3, 3.0), spread(i + 3, 0.3, 3.0)];
    let scene = |i: usize| double(LENGTHS(i), spread(i, 0.2, 2.0)).masses(masses(i));
    let scenes: Vec<_> = (0..3).map(scene).collect();
    let starts: Vec<_> =
        scenes.iter().zip(starts(3, LENGTHS)).map(|(scene, start)| scene.project(&start).unwrap()).collect();
    let trajectories = scenes.iter().zip(starts.iter().cloned());
    let mut sweep = Ensemble::sweep(Double, trajectories, Rattle::new(0.01)).unwrap();
    let seen = sweep.observe(30, 10, || Each::of(Told::default));
    for (i, (scene, start)) in scenes.iter().zip(&starts).enumerate() {
        let off = seen.get(i).unwrap().off_alone(scene, start, &Rattle::new(0.01));
        assert!(off < 1e-11, "{i}: {off:e}");
    }
}

/// A sweep over networks of several sizes goes one by one, and its snapshot holds all bodies of each.
#[test]
fn snapshots_of_several_sizes() {
    let chain = |rods: usize| {
        let links = (0..rods).map(|i| [i, i + 1]);
        let scene = Scene::points(rods + 1).link(Rod { length: 1.0 }, links).pin(0, [0.0; 2]);
        (scene, State::of((0..=rods).map(|i| [i as f64, 0.0])))
    };
    let [few, many] = [chain(2), chain(4)];
    let sweep = [(&few.0, few.1), (&many.0, many.1)];
    let mut ensemble = Ensemble::sweep(Double, sweep, Rattle::new(0.01)).unwrap();
    ensemble.run(3);
    let snapshot = ensemble.snapshot();
    let all: Vec<_> = (0..2).flat_map(|i| ensemble.state(i).positions().collect::<Vec<_>>()).collect();
    assert_eq!((snapshot.positions.len(), snapshot.momenta.len()), (8, 8));
    assert_eq!(snapshot.positions, all);
}

/// More equations than coordinates: lanes that go by themselves are looked at all the same.
#[test]
fn snapshots_of_redundant_links() {
    let pins = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]];
    let scene = Scene::points(4).link(Rod { length: 1.0 }, (0..3).map(|i| [i, 3]));
    let scene = (0..3).fold(scene, |scene, i| scene.pin(i, pins[i]));
    let start = State::of(pins.into_iter().chain([[0.0; 2]]));
    let mut ensemble = scene.ensemble(vec![start; 3], Rattle::new(0.01)).unwrap();
    assert_eq!(ensemble.snapshot().positions[3].norm(), 0.0);
    ensemble.run(2);
    assert_eq!(ensemble.snapshot().positions[7].norm(), 0.0);
}
