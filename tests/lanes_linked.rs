//! Linked bodies in lanes: as each trajectory alone but for rounding, whatever the links, masses, effects and methods.

use crate::common::{PlanarGravity, Trough, larger};
use rattle::bodies::Count;
use rattle::composition::{KAHAN_LI_1997_ORDER_8, SUZUKI_1990_ORDER_4};
use rattle::effect::Effects;
use rattle::ensemble::InstructionSet;
use rattle::guess::Extrapolated;
use rattle::links::planar::Rod as PlanarRod;
use rattle::links::{Angle, Rod};
use rattle::method::Method;
use rattle::potentials::weights;
use rattle::prelude::*;
use rattle::scene::Hold;

pair_potential! {
    struct Repulsion { strength }
    |r| strength * exp(-r^2)
}

constraint! {
    /// A hinge of two equations: the second body is at unit distance, and in a plane that turns with the first.
    struct Hinge { pitch }
    |a: [f64; 3], b: [f64; 3]| [dot(b - a, b - a) - 1, b[2] - a[2] - pitch * sin(a[0])]
}

/// Places of a chain of rods of unit length, that hangs at these angles.
pub(crate) fn chain<const D: usize>(links: usize, lean: f64) -> Vec<[f64; D]> {
    let mut places = vec![[0.0; D]];
    for i in 0..links {
        let (angle, mut next) = (lean + 0.3 * i as f64, places[i]);
        next[0] += angle.sin();
        next[D - 1] -= angle.cos();
        places.push(next);
    }
    places
}

/// More than a row, in motion along the constraints.
pub(crate) fn starts<C: Hold<D>, E: Effects<D>, N: Count, const D: usize>(
    scene: &Scene<C, E, N, D>,
    places: impl Fn(f64) -> Vec<[f64; D]>,
) -> Vec<State<D>> {
    let start = |i: u32| {
        let lean = 0.4 + 0.02 * f64::from(i);
        let places = places(lean);
        let momenta = places.iter().map(|q| {
            let mut p = [0.2; D];
            p[0] = 0.5 * (q[D - 1] + lean).cos();
            p
        });
        let momenta: Vec<_> = momenta.collect();
        scene.project(&State::of(places).with_momenta(momenta)).unwrap()
    };
    (0..70).map(start).collect()
}

/// How far positions and momenta of an ensemble are off those of simulations.
fn off<P: Precision, C: Hold<D> + 'static, E: Effects<D>, N: Count, S: Method, const D: usize>(
    precision: P,
    scene: &Scene<C, E, N, D>,
    starts: &[State<D>],
    method: &S,
    steps: u64,
) -> f64 {
    let mut ensemble = scene.ensemble_in(precision, starts.iter().cloned(), method.clone()).unwrap();
    ensemble.run(steps);
    let each = starts.iter().enumerate().step_by(3);
    each.map(|(i, start)| off_alone(&ensemble, i, scene, start, method, steps)).fold(0.0, larger)
}

/// How far a trajectory is off a simulation of its scene.
pub(crate) fn off_alone<C: Hold<D>, E: Effects<D>, N: Count, S: Method, const D: usize>(
    ensemble: &Ensemble<D>,
    i: usize,
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
    method: &S,
    steps: u64,
) -> f64 {
    let mut simulation = scene.simulate(start.clone(), method.clone()).unwrap();
    simulation.run(steps).unwrap();
    let state = ensemble.state(i);
    assert_eq!((ensemble.failure(i), state.time()), (None, simulation.time()));
    let places = state.positions().zip(simulation.positions()).map(|(a, b)| (a - b).norm());
    let ways = state.momenta().zip(simulation.momenta()).map(|(a, b)| (a - b).norm());
    places.chain(ways).fold(0.0, larger)
}

/// All that sights tell, each 10 of 30 steps.
#[derive(Default)]
pub(crate) struct Told(Vec<f64>);

impl<const D: usize> Observer<D> for Told {
    fn see(&mut self, _: &Sight<'_, D>, now: &Sight<'_, D>) {
        self.0.extend([now.kinetic_energy(), now.potential_energy(), now.temperature(), now.time]);
        self.0.extend(now.multipliers().into_iter().chain(now.effect_energies()).chain(now.residuals()));
        self.0.extend(now.velocities().iter().flat_map(|v| v.iter()));
        self.0.extend(now.constraint_forces().iter().map(|f| f.norm()));
        self.0.extend(now.positions.iter().chain(now.momenta).flat_map(|q| q.iter()));
    }
    fn join(&mut self, next: Self) {
        self.0.extend(next.0);
    }
}

impl Told {
    /// How far this is off what is told of a simulation.
    pub(crate) fn off_alone<C: Hold<D>, E: Effects<D>, N: Count, S: Method, const D: usize>(
        &self,
        scene: &Scene<C, E, N, D>,
        start: &State<D>,
        method: &S,
    ) -> f64 {
        let mut own = Self::default();
        scene.simulate(start.clone(), method.clone()).unwrap().observe(30, 10, &mut own).unwrap();
        assert_eq!(self.0.len(), own.0.len());
        // Phase space has no temperature: NaN for both.
        let off = |(a, b): (&f64, &f64)| if a.is_nan() && b.is_nan() { 0.0 } else { (a - b).abs() };
        self.0.iter().zip(&own.0).map(off).fold(0.0, larger)
    }
}

/// Whether all is rounding, and something is: who goes alone is off by nothing.
pub(crate) fn check(found: &[f64]) {
    println!("{found:?}");
    let fused = InstructionSet::widest().fuses(); // else all go alone, and nothing differs
    assert!(found.iter().all(|&off| off < 4e-13 && (off > 0.0) == fused), "{found:?}");
}

/// Equal steps, and unequal ones with compensated sums, in this scene.
fn agree<C: Hold<D> + 'static, E: Effects<D>, N: Count, const D: usize>(
    scene: &Scene<C, E, N, D>,
    places: impl Fn(f64) -> Vec<[f64; D]>,
) {
    let starts = starts(scene, places);
    check(&[
        off(Double, scene, &starts, &Rattle::new(0.01), 50),
        off(Compensated, scene, &starts, &Composition::new(SUZUKI_1990_ORDER_4, 0.02), 25),
        off(Double, scene, &starts[..5], &Rattle::new(0.01), 50), // in a row of a few
        off(Double, scene, &starts, &Dop853::new(0.02), 25),
        off(Double, scene, &starts, &Lobatto::<4>::new(0.02), 25),
    ]);
}

/// All methods and precisions.
#[test]
fn methods_and_precisions() {
    let scene = Scene::points(3)
        .link(PlanarRod { length: 1.0 }, [[0, 1], [1, 2]])
        .pin(0, [0.0, 0.0])
        .masses([1.0, 2.5, 0.3])
        .with(PlanarGravity { g: 1.0 });
    let (starts, scene) = (starts(&scene, |lean| chain(2, lean)), &scene);
    check(&[
        off(Compensated, scene, &starts, &Rattle::new(0.01), 50),
        off(Single, scene, &starts, &Rattle::new(0.01), 50), // in double precision too
        off(Double, scene, &starts, &PositionVerlet::new(0.01), 50),
        off(Double, scene, &starts, &SymplecticEuler::new(-0.01), 50),
        off(Compensated, scene, &starts, &Geodesic::new(2, 0.02), 25),
        off(Double, scene, &starts, &Composition::new(SUZUKI_1990_ORDER_4, 0.02), 25),
        off(Compensated, scene, &starts, &Composition::new(KAHAN_LI_1997_ORDER_8, 0.1), 5),
        off(Single, scene, &starts, &Dop853::new(0.02), 25), // in double precision, sums compensated
        off(Double, scene, &starts[..5], &Dop853::new(0.02), 25),
        off(Double, scene, &starts, &Dop853::adaptive(0.1, 1e-12), 5),
        off(Double, scene, &starts, &Dop853::adaptive(-0.25, 1e-9), 2),
        off(Double, scene, &starts, &Lobatto::<2>::new(0.02), 25),
        off(Single, scene, &starts, &Lobatto::<3>::new(0.02), 25), // in double precision, sums compensated
        off(Double, scene, &starts[..5], &Lobatto::<5>::new(-0.05), 10),
        off(Double, scene, &starts, &Lobatto::<9>::new(0.1).guess(Extrapolated), 5),
    ]);
}

#[test]
fn double_pendulums_with_masses() {
    let scene = Scene::points(3)
        .link(PlanarRod { length: 1.0 }, [[0, 1], [1, 2]])
        .pin(0, [0.0, 0.0])
        .masses([1.0, 2.5, 0.3])
        .with(PlanarGravity { g: 1.0 });
    agree(&scene, |lean| chain(2, lean));
}

#[test]
fn chains_in_space_with_weights_and_a_free_end() {
    let scene = Scene::points(7)
        .link(Rod { length: 1.0 }, (0..5).map(|i| [i, i + 1])) // body 6 is free
        .masses((0..7).map(|i| [1.0 + 0.1 * f64::from(i), 2.0, 0.7]))
        .with(Trough { g: 0.5 })
        .with(weights(1.0, (0..7).map(f64::from)));
    agree(&scene, |lean| [chain(5, lean), vec![[3.0, 1.0, lean]]].concat());
}

/// A link between two pins, to which a third body is tied, is no equation of motion.
#[test]
fn links_between_pins() {
    let scene = Scene::points(3)
        .link(PlanarRod { length: 1.0 }, [[0, 1], [1, 2]])
        .pin(0, [0.0, 0.0])
        .pin(1, [1.0, 0.0])
        .with(PlanarGravity { g: 1.0 });
    agree(&scene, |lean| vec![[0.0, 0.0], [1.0, 0.0], [1.0 + lean.sin(), -lean.cos()]]);
}

/// A ring fills in where it is eliminated.
#[test]
fn rings_and_angles() {
    let ring = |lean: f64| {
        let corner = |i: u32| {
            let angle = lean + f64::from(i) * std::f64::consts::TAU / 5.0;
            let radius = 0.5 / (std::f64::consts::TAU / 10.0).sin();
            [radius * angle.cos(), radius * angle.sin(), 0.3 * lean]
        };
        (0..5).map(corner).collect()
    };
    let inner = 0.6 * std::f64::consts::PI;
    let scene = Scene::points(5)
        .link(Rod { length: 1.0 }, (0..5).map(|i| [i, (i + 1) % 5]))
        .link(Angle { angle: inner }, [[0, 1, 2]])
        .with(Trough { g: 1.0 });
    agree(&scene, ring);
}

/// Components of two bodies each, with forces between all.
#[test]
fn dumbbells_that_repel_each_other() {
    let scene = Scene::points(6)
        .link(PlanarRod { length: 1.0 }, [[0, 1], [2, 3], [4, 5]])
        .with(Repulsion { strength: 2.0 });
    let places = |lean: f64| {
        let pair = |i: u32| {
            let (x, angle) = (1.5 * f64::from(i), lean * f64::from(i + 1));
            [[x, 0.0], [x + angle.cos(), angle.sin()]]
        };
        (0..3).flat_map(pair).collect()
    };
    agree(&scene, places);
}

#[test]
fn links_of_two_equations_and_one_body() {
    let scene = Scene::points(3)
        .link(Hinge { pitch: 0.3 }, [[0, 1], [1, 2]])
        .pin(0, [0.0; 3])
        .with(Trough { g: 1.0 });
    let places = |lean: f64| {
        let second = [lean.cos(), lean.sin(), 0.0];
        let rise = 0.3 * second[0].sin();
        let flat = (1.0 - rise * rise).sqrt();
        vec![[0.0; 3], second, [second[0] + flat * lean.sin(), second[1] + flat * lean.cos(), rise]]
    };
    agree(&scene, places);

    constraint! {
        struct Curve { tilt }
        |x, y, z| [x^2 + y^2 + z^2 - 1, z - tilt * x]
    }
    let tilt = 0.4_f64;
    let scene = Scene::on(Curve { tilt }).with(Trough { g: 1.0 });
    let round = (1.0 + tilt * tilt).sqrt();
    agree(&scene, |lean| vec![[lean.cos() / round, lean.sin(), tilt * lean.cos() / round]]);
}

/// What cannot go side by side goes alone: those are simulations, bit for bit.
#[test]
fn others_go_alone() {
    let double = || Scene::points(3).link(PlanarRod { length: 1.0 }, [[0, 1], [1, 2]]).pin(0, [0.0, 0.0]);
    let places = |lean| chain(2, lean);
    fn alone<C: Hold<2> + 'static, E: Effects<2>, N: Count>(
        scene: &Scene<C, E, N, 2>,
        places: impl Fn(f64) -> Vec<[f64; 2]>,
    ) {
        let starts = &starts(scene, places)[..9];
        assert_eq!(off(Double, scene, starts, &Rattle::new(0.01), 20), 0.0);
    }
    // Twice the same rod: normals depend on each other.
    alone(
        &double().link(PlanarRod { length: 1.0 }, [[1, 2]]).linear_algebra(LinearAlgebra::Orthogonal),
        places,
    );
    alone(&double().link(PlanarRod { length: 1.0 }, [[1, 2]]), places);
    // A mass that is a matrix.
    alone(&double().mass(nalgebra::Matrix2::new(1.0, 0.2, 0.2, 2.0)), places);
    // A link with a kink.
    constraint! {
        struct Bent {}
        |x, y| abs(x) + y
    }
    alone(&Scene::points(1).link(Bent {}, [[0]]), |lean| vec![[1.0 + lean, -1.0 - lean]]);
    // A link that moves.
    constraint! {
        struct Lift {}
        |_x, y, t| y - sin(t)
    }
    alone(&Scene::points(1).link_moving(Lift {}, [[0]]), |lean| vec![[lean, 0.0]]);
}

/// Trajectories of rows of 64 have the bits that they have in rows of 8, where no step is compiled for its sizes.
fn same_in_rows<C: Hold<D> + 'static, E: Effects<D>, N: Count, const D: usize>(
    scene: &Scene<C, E, N, D>,
    places: impl Fn(f64) -> Vec<[f64; D]>,
) {
    fn bits<C: Hold<D> + 'static, E: Effects<D>, N: Count, const D: usize>(
        scene: &Scene<C, E, N, D>,
        starts: &[State<D>],
    ) -> Vec<String> {
        let starts = || starts.iter().cloned();
        let mut equal = scene.ensemble(starts(), Rattle::new(0.01)).unwrap();
        let mut sums = scene.ensemble_in(Compensated, starts(), Rattle::new(0.01)).unwrap();
        let composed = Composition::new(SUZUKI_1990_ORDER_4, 0.02);
        let mut unequal = scene.ensemble(starts(), composed).unwrap();
        let mut all = scene.ensemble_in(Compensated, starts(), composed).unwrap();
        let mut projected = scene.ensemble(starts(), Dop853::adaptive(0.01, 1e-8)).unwrap();
        let each = [&mut equal, &mut sums, &mut unequal, &mut all, &mut projected].map(|ensemble| {
            ensemble.run(130);
            assert_eq!(ensemble.failures().count(), 0);
            (0..8).map(|i| format!("{:?}", ensemble.state(i))).collect::<Vec<_>>()
        });
        each.concat()
    }
    let starts = starts(scene, places);
    let [many, few] = [&starts[..64], &starts[..8]].map(|starts| bits(scene, starts));
    let other = (0..32).filter(|&i| many[i] != few[i]).collect::<Vec<_>>();
    assert!(other.is_empty(), "{other:?}: {} and {}", many[other[0]], few[other[0]]);
}

#[test]
fn steps_compiled_for_their_sizes_give_the_same_bits() {
    let planar = |lean| chain(3, lean);
    let line = |links: Vec<[usize; 2]>| Scene::points(links.len() + 1).link(PlanarRod { length: 1.0 }, links);
    let (pinned, gravity) = ([0.0, 0.0], PlanarGravity { g: 1.0 });
    for masses in [[1.0; 4], [0.3, 1.0, 2.5, 0.7]] {
        let of = |n: usize| masses[..n].to_vec();
        let few = |n: usize| move |lean| planar(lean)[..n].to_vec();
        same_in_rows(&line(vec![[0, 1]]).masses(of(2)).with(gravity), few(2));
        same_in_rows(&line(vec![[1, 0]]).pin(0, pinned).masses(of(2)).with(gravity), few(2));
        let double = line(vec![[0, 1], [2, 1]]).pin(0, pinned);
        same_in_rows(&double.masses(of(3)).with(gravity), few(3));
        let triple = line(vec![[2, 3], [1, 2], [0, 1]]).pin(0, pinned);
        same_in_rows(&triple.masses(of(4)).with(gravity), few(4));
    }
    let line = |links: Vec<[usize; 2]>| Scene::points(links.len() + 1).link(Rod { length: 1.0 }, links);
    let (pinned, weight) = ([0.0; 3], Trough { g: 0.5 });
    let few = |n: usize| move |lean| chain(n - 1, lean);
    same_in_rows(&line(vec![[0, 1]]).masses([2.0, 0.7]).with(weight), few(2));
    same_in_rows(&line(vec![[0, 1]]).pin(0, pinned).with(weight), few(2));
    same_in_rows(&line(vec![[0, 1], [1, 2]]).pin(0, pinned).with(weight), few(3));
    let triangle =
        Scene::points(3).link(Rod { length: 1.0 }, [[2, 1], [0, 2], [1, 0]]).masses([16.0, 1.0, 1.0]);
    same_in_rows(&triangle.with(weight), |lean| {
        vec![
            [0.0; 3],
            [lean.cos(), 0.0, lean.sin()],
            [(lean + 60_f64.to_radians()).cos(), 0.0, (lean + 60_f64.to_radians()).sin()],
        ]
    });
}

/// Bits of a trajectory depend on no neighbour, no division of the run, no number of threads, no instruction set that
/// fuses, and not on a checkpoint. Some steps are too long for some of the trajectories: these end, or go apart.
#[test]
#[cfg(long)]
fn the_same_bits_everywhere() {
    let scene = Scene::points(3)
        .link(PlanarRod { length: 1.0 }, [[0, 1], [1, 2]])
        .pin(0, [0.0, 0.0])
        .with(PlanarGravity { g: 1.0 });
    fn check<S: Method>(
        scene: &Scene<impl Hold<2> + Sync + 'static, impl Effects<2> + Sync, impl Count, 2>,
        method: &S,
        fails: bool,
    ) {
        let start = |i: u32| {
            let speed = if i.is_multiple_of(5) { 8.0 } else { 0.3 };
            let places = chain(2, 0.005 * f64::from(i));
            scene.project(&State::of(places).with_momenta([[0.0, 0.0], [speed, 0.1], [-speed, 0.2]])).unwrap()
        };
        let of = |numbers: &[u32], set| {
            let starts = numbers.iter().map(|&i| start(i));
            Ensemble::of(Double, scene, starts, method.clone(), set).unwrap()
        };
        let bits = |ensemble: &Ensemble<2>| {
            let states = (0..ensemble.len()).map(|i| (ensemble.state(i), ensemble.failure(i).cloned()));
            states.map(|(state, why)| format!("{state:?} {}", why.is_some())).collect::<Vec<_>>()
        };
        let (numbers, widest): (Vec<u32>, _) = ((0..90).collect(), InstructionSet::widest());
        let mut first = of(&numbers, widest);
        first.run(200);
        let expected = bits(&first);
        let ended = first.failures().map(|(i, _)| i).collect::<Vec<_>>();
        println!("{} ended", ended.len());
        assert!(ended.is_empty() != fails && ended.iter().all(|i| i.is_multiple_of(5)), "{ended:?}");
        for set in [InstructionSet::Avx2, InstructionSet::Avx512] {
            if set.is_present() && set.fuses() && widest.fuses() {
                let mut other = of(&numbers, set);
                other.run(200);
                assert_eq!(bits(&other), expected, "{set}");
            }
        }
        let mut parts = of(&numbers, widest);
        for steps in [1, 63, 2, 71, 63] {
            parts.run(steps);
            let (record, mut again) = (parts.checkpoint(), of(&numbers, widest));
            again.resume(&record).unwrap();
            parts = again;
        }
        assert_eq!(bits(&parts), expected, "in parts");
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let mut others = of(&numbers[7..], widest);
        pool.install(|| others.run(200));
        assert_eq!(bits(&others), expected[7..], "others beside them");
        let calm = numbers.iter().copied().filter(|i| !i.is_multiple_of(5)).collect::<Vec<_>>();
        let mut calm_ones = of(&calm, widest);
        calm_ones.run(200);
        for (state, i) in bits(&calm_ones).into_iter().zip(calm) {
            assert_eq!(state, expected[i as usize], "trajectory {i} without its wild neighbours");
        }
        let mut alone = of(&[77], widest);
        alone.run(200);
        assert_eq!(bits(&alone)[0], expected[77]);
    }
    check(&scene, &Rattle::new(0.02), false);
    check(&scene, &Rattle::new(0.2), true);
    check(&scene, &Composition::new(SUZUKI_1990_ORDER_4, 0.1), true);
}

/// In steps far too long a lane ends where a simulation ends, or neither does; and so does what is halved. What a lane
/// starts with is momenta after the first kick, so that a step may be trusted that a simulation refuses: one here.
#[test]
#[cfg(long)]
fn long_steps_end_where_those_of_simulations_end() {
    let scene = Scene::points(4)
        .link(PlanarRod { length: 1.0 }, [[0, 1], [1, 2], [2, 3]])
        .pin(0, [0.0, 0.0])
        .with(PlanarGravity { g: 1.0 });
    let start = |i: u32| {
        let (places, rate) = (chain(3, 0.1 * f64::from(i)), 0.2 * f64::from(i));
        let momenta = [[0.0, 0.0], [rate, 0.1], [0.3, -rate], [0.0, 0.5]];
        scene.project(&State::of(places).with_momenta(momenta)).unwrap()
    };
    let (mut ended, mut bolder, mut longest) = (0, 0, 0.0_f64);
    for halvings in [0, 8] {
        let mut ensemble =
            scene.ensemble((0..64).step_by(2).map(start), Rattle::new(0.3)).unwrap().retry(halvings);
        ensemble.run(6);
        for i in 0..32 {
            let mut simulation = scene.simulate(start(2 * i), Rattle::new(0.3)).unwrap().retry(halvings);
            let end = simulation.run(6).err();
            let (state, why) = (ensemble.state(i as usize), ensemble.failure(i as usize));
            let apart = state.positions().zip(simulation.positions()).map(|(a, b)| (a - b).norm());
            let far = apart.fold(0.0, larger);
            if state.time() > simulation.time() || (halvings > 0 && far > 1e-9) {
                bolder += 1;
                continue;
            }
            assert_eq!((why.is_some(), state.time()), (end.is_some(), simulation.time()), "trajectory {i}");
            (ended, longest) = (ended + u32::from(end.is_some()), longest.max(far));
        }
    }
    println!("{ended} ended, {bolder} bolder, others {longest:e} apart");
    assert!(ended > 20 && bolder <= 2 && longest < 1e-9, "{ended} {bolder} {longest:e}");
}

/// What a sight tells in lanes, it tells of simulations.
#[test]
fn sights_tell_the_same() {
    let scene = Scene::points(3)
        .link(PlanarRod { length: 1.0 }, [[0, 1], [1, 2]])
        .pin(0, [0.0, 0.0])
        .masses([1.0, 2.0, 3.0])
        .with(PlanarGravity { g: 1.0 });
    let starts = starts(&scene, |lean| chain(2, lean));
    let mut ensemble = scene.ensemble(starts[..3].iter().cloned(), Rattle::new(0.01)).unwrap();
    let seen = ensemble.observe(30, 10, || Each::of(Told::default));
    for (i, start) in starts[..3].iter().enumerate() {
        let off = seen.get(i).unwrap().off_alone(&scene, start, &Rattle::new(0.01));
        assert!(off < 1e-11, "{i}: {off:e}");
    }
    let bill = ensemble.bill().unwrap();
    assert_eq!(
        (bill.side_by_side > 1, &bill.items[0].what[..]),
        (InstructionSet::widest().fuses(), "force of `Gravity`")
    );
    assert_eq!(ensemble.bodies(), 3);
}

/// Nearly taut between two pins the links of a chain depend on each other but for a little. A simulation then uses an
/// orthonormal basis from its start, and so does a trajectory that goes by itself.
#[test]
fn chains_that_are_nearly_taut() {
    let (links, sag) = (8_u32, 1e-9);
    let place = |i: u32| [f64::from(i), sag * f64::from(i * (links - i))];
    let rods = (0..links).map(|i| {
        let ([x, y], [a, b]) = (place(i), place(i + 1));
        (PlanarRod { length: (a - x).hypot(b - y) }, [i as usize, i as usize + 1])
    });
    let scene =
        Scene::points(9).link_each(rods).pin(0, place(0)).pin(8, place(8)).with(PlanarGravity { g: 1e-9 });
    let start = State::of((0..=links).map(place));
    let simulation = scene.simulate(start.clone(), Rattle::new(1e-3)).map(|mut simulation| {
        assert_eq!(simulation.system().components().next().unwrap().by, LinearAlgebra::Orthogonal);
        let end = simulation.run(20).map_err(|error| error.to_string());
        (simulation.positions().collect::<Vec<_>>(), end)
    });
    let ensemble = scene.ensemble(vec![start; 3], Rattle::new(1e-3)).map(|mut ensemble| {
        ensemble.run(20);
        let end = ensemble.failure(1).map_or(Ok(()), |error| Err(error.to_string()));
        (ensemble.state(1).positions().collect::<Vec<_>>(), end)
    });
    println!("{simulation:?}\n{ensemble:?}");
    let (alone, together) = (simulation.unwrap(), ensemble.unwrap());
    let apart = alone.0.iter().zip(&together.0).map(|(a, b)| (a - b).norm()).fold(0.0, larger);
    assert!(alone.1.is_ok() && together.1.is_ok() && apart < 1e-12, "{apart:e}");
}

/// A lane that goes by itself takes the multipliers over. In a step that begins with normals clearly independent and
/// ends with others, these were told in the basis of the end.
#[test]
fn rods_are_kept_where_normals_come_close() {
    let mut passed = 0;
    for i in 0..800_u32 {
        let [a, b, c] = [0.731, 1.917, 1.0].map(|x| x * f64::from(i));
        let (mass, h) = (10_f64.powf(f64::from((i * 7) % 31) / 10.0), 0.02 + 0.28 * (0.37 * c).sin().abs());
        let scene = Scene::points(3)
            .link(PlanarRod { length: 1.0 }, [[0, 1], [1, 2]])
            .masses([1.0, 1.0, mass])
            .pin(0, [0.0, 0.0]);
        let elbow = [a.cos(), a.sin()];
        let start = State::of([[0.0; 2], elbow, [elbow[0] + b.cos(), elbow[1] + b.sin()]]);
        let fast = [mass * (3.0 * c).sin(), mass * (1.3 * c).cos()];
        let start = start.with_momenta([[0.0; 2], [c.sin(), (2.0 * c).sin()], fast]);
        let start = scene.project(&start).unwrap();
        let mut ensemble = scene.ensemble([start.clone()], Rattle::new(h)).unwrap();
        ensemble.run(1);
        if ensemble.failure(0).is_some() {
            continue;
        }
        passed += 1;
        let q: Vec<_> = ensemble.state(0).positions().collect();
        for length in [(q[1] - q[0]).norm(), (q[2] - q[1]).norm()] {
            assert!((length - 1.0).abs() < 1e-14, "pendulum {i}: {length}");
        }
        let mut alone = scene.simulate(start, Rattle::new(h)).unwrap();
        alone.step().unwrap();
        let off = alone.positions().zip(&q).map(|(p, q)| (p - q).norm()).fold(0.0, larger);
        assert!(off < 1e-12, "pendulum {i}: {off:e} off the simulation");
    }
    assert!(passed > 600, "{passed}");
}

/// A square with both diagonals, one rod more than it needs, and a rod that hangs from it: what sights tell of
/// temperatures, multipliers and forces is what they tell of simulations.
#[test]
fn sights_of_redundant_links() {
    let long = 2.0_f64.sqrt();
    let rods = [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2], [1, 3], [1, 4]];
    let length = |i: usize| if i == 4 || i == 5 { long } else { 1.0 };
    let scene = Scene::points(5)
        .link_each(rods.into_iter().enumerate().map(|(i, ends)| (PlanarRod { length: length(i) }, ends)))
        .with(PlanarGravity { g: 0.3 });
    let places = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [1.0, -1.0]];
    let start = State::of(places).with_momenta(places.map(|[x, y]| [-y, x]));
    let method = Rattle::new(0.01);
    assert_eq!(scene.simulate(start.clone(), method).unwrap().temperature(), 1.5, "6 of 7 equations count");
    let mut ensemble = scene.ensemble(vec![start.clone(); 3], method).unwrap();
    let seen = ensemble.observe(30, 10, || Each::of(Told::default));
    let each = scene.clone();
    let mut sweep = Ensemble::sweep(Double, (0..3).map(|_| (&each, start.clone())), method).unwrap();
    let swept = sweep.observe(30, 10, || Each::of(Told::default));
    for told in [&seen, &swept] {
        let off = told.get(1).unwrap().off_alone(&scene, &start, &method);
        assert!(off < 1e-12, "{off:e}");
    }
}

/// Links that come to depend on each other end a trajectory in lanes as they end a simulation.
#[test]
fn links_that_lose_their_rank_end_lanes_too() {
    constraint! {
        /// Dependent at z = 0.
        struct Twist {}
        |x, y, z| [y, y + z * x]
    }
    let scene = Scene::points(1).link(Twist {}, [[0]]);
    let start = State::of([[0.0, 0.0, 1.0]]).with_momenta([[0.0, 0.0, -1.0]]);
    let method = Dop853::new(0.125);
    let mut alone = scene.simulate(start.clone(), method).unwrap();
    let end = alone.run(8).unwrap_err();
    // Also beside one whose links depend on each other from the start on.
    let ill = State::of([[0.0, 0.0, 0.0]]);
    for starts in [vec![start.clone()], vec![ill, start]] {
        let last = starts.len() - 1;
        let mut ensemble = scene.ensemble(starts, method).unwrap();
        ensemble.run(8);
        assert_eq!(ensemble.failure(last).map(ToString::to_string), Some(end.to_string()));
    }
}
