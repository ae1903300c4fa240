//! Flows of momenta on linked bodies in lanes: as each trajectory alone but for rounding, what they keep, their work.
//!
//! Many kinds of flows take long to compile: those of `flows_by_lane` stand for them, and `cargo long` has all.
#![cfg_attr(not(long), allow(unused_imports, dead_code, reason = "of the long tests"))]

use crate::common::larger;
use rattle::bodies::{Count, Many};
use rattle::composition::SUZUKI_1990_ORDER_4;
use rattle::effect::{
    Andersen, Effects, Flow, Interval, Langevin, LinearDrag, MagneticField, QuadraticDrag, VelocityRescaling,
};
use rattle::ensemble::{InstructionSet, NotInLanes};
use rattle::links::Rod;
use rattle::links::planar::Rod as PlanarRod;
use rattle::method::Method;
use rattle::network::Network;
use rattle::potentials::planar::Gravity as PlanarGravity;
use rattle::prelude::*;
use rattle::real::Real;

const HEAT: Langevin = Langevin { friction: 2.0, temperature: 0.5, seed: 7 };
const FIELD: [f64; 3] = [0.7, -0.4, 1.5];

/// Drag along the radius, that turns with time and differs by body.
#[derive(Debug, Clone)]
struct Combed(f64);

impl<const D: usize> Flow<D> for Combed {
    #[inline(always)]
    fn flow<T: Real>(&self, during: &Interval<'_, T, D>, changes: &mut [[T; D]]) {
        let lost = (-self.0 * during.h * (1.5 + during.at.time.sin())).exp_m1();
        for (body, (change, p)) in changes.iter_mut().zip(during.momenta).enumerate() {
            let q = during.at.positions[body];
            let [along, square] = [p, &q].map(|x| (0..D).fold(T::from_f64(0.0), |sum, d| sum + x[d] * q[d]));
            let share = T::from_f64(lost / (1.0 + body as f64)) * along / (square + T::from_f64(0.5));
            *change = q.map(|q| share * q);
        }
    }
    fn changes_with_time(&self) -> bool {
        true
    }
}

type Linked<E, const D: usize> = Scene<Network<D>, E, Many, D>;

fn dumbbell() -> Linked<impl Effects<3> + Clone + 'static, 3> {
    Scene::points(2).link(Rod { length: 1.0 }, [[0, 1]]).masses([1.0, 3.0])
}

fn triangle() -> Linked<impl Effects<3> + Clone + 'static, 3> {
    Scene::points(3).link(Rod { length: 1.0 }, [[0, 1], [1, 2], [2, 0]]).masses([16.0, 1.0, 1.0])
}

fn pendulum() -> Linked<impl Effects<2> + Clone + 'static, 2> {
    Scene::points(3)
        .link(PlanarRod { length: 1.0 }, [[0, 1], [1, 2]])
        .pin(0, [0.0, 0.0])
        .masses([1.0, 2.5, 0.3])
        .with(PlanarGravity { g: 1.0 })
}

fn chain() -> Linked<impl Effects<3> + Clone + 'static, 3> {
    Scene::points(8).link(Rod { length: 1.0 }, (0..6).map(|i| [i, i + 1])) // body 7 is free
}

/// Places that links of unit length allow, of so many bodies: a triangle of three in space, chains of others.
fn places<const D: usize>(bodies: usize, lean: f64) -> Vec<[f64; D]> {
    let mut places = vec![[0.0; D]];
    for i in 1..bodies {
        let angle = if (bodies, D) == (3, 3) {
            lean - 2.094_395_102_393_195_5 * (i as f64)
        } else {
            lean + 0.3 * i as f64
        };
        let mut next = places[i - 1];
        next[0] += angle.sin();
        next[D - 1] -= angle.cos();
        places.push(next);
    }
    places
}

/// Some with numbers of their own, some after steps.
fn start<E: Effects<D>, const D: usize>(scene: &Linked<E, D>, bodies: usize, i: u64) -> State<D> {
    let lean = 0.4 + 0.02 * i as f64;
    let momenta = (0..bodies).map(|body| {
        let mut p = [0.2; D];
        p[0] = 0.5 * (body as f64 + lean).cos();
        p
    });
    let rough = State::of(places(bodies, lean)).with_momenta(momenta.collect::<Vec<_>>());
    let state = scene.project(&rough).unwrap().at_time(0.01 * i as f64);
    if i.is_multiple_of(2) { state.numbered(1000 + i) } else { state.numbered(i).after_steps(5 * i) }
}

fn off<const D: usize>(a: &State<D>, b: &State<D>) -> f64 {
    let apart = a.positions().zip(b.positions()).chain(a.momenta().zip(b.momenta()));
    apart.map(|(a, b)| (a - b).norm()).fold(0.0, larger)
}

fn in_lanes<const D: usize>(ensemble: &Ensemble<D>) {
    let plan = ensemble.plan();
    assert_eq!(plan.in_lanes == ensemble.len(), InstructionSet::widest().fuses(), "{plan:?}");
}

/// How far lanes are from simulations after so many steps, in places, momenta and work.
fn apart<P: Precision, E: Effects<D>, S: Method, const D: usize>(
    precision: P,
    scene: &Linked<E, D>,
    [bodies, trajectories]: [usize; 2],
    method: &S,
    steps: u64,
) -> f64 {
    let starts = || (0..trajectories as u64).map(|i| start(scene, bodies, i));
    let mut ensemble = scene.ensemble_in(precision, starts(), method.clone()).unwrap();
    in_lanes(&ensemble);
    ensemble.run(steps);
    assert_eq!(ensemble.failures().count(), 0);
    let alone = starts().enumerate().step_by(5).map(|(i, start)| {
        let mut simulation = scene.simulate(start, method.clone()).unwrap();
        simulation.run(steps).unwrap();
        let (own, state) = (simulation.state(), ensemble.state(i));
        assert_eq!((own.time(), own.steps()), (state.time(), state.steps()));
        larger(off(&own, &state), (simulation.work() - ensemble.work(i)).abs())
    });
    alone.fold(0.0, larger)
}

/// By RATTLE and by BAOAB, in rows of 64 and of 8.
fn as_alone<E: Effects<D>, const D: usize>(scene: &Linked<E, D>, bodies: usize, name: &str) {
    let found = [
        apart(Double, scene, [bodies, 70], &Rattle::new(0.02), 30),
        apart(Compensated, scene, [bodies, 70], &Rattle::new(0.02), 30),
        apart(Compensated, scene, [bodies, 5], &Baoab::with_inner(2, 0.02), 30),
        apart(Double, scene, [bodies, 5], &Baoab::new(0.02), 30),
    ];
    println!("{name}: {found:?}");
    let fused = InstructionSet::widest().fuses();
    assert!(found.iter().all(|&off| off < 1e-12 && (off > 0.0) == fused), "{name}: {found:?}");
}

#[test]
fn heat_as_alone() {
    as_alone(&dumbbell().with(HEAT), 2, "dumbbells");
    as_alone(&triangle().with(HEAT), 3, "triangles");
    as_alone(&pendulum().with(HEAT), 3, "pendulums");
    as_alone(&chain().with(HEAT), 8, "chains");
}

/// Who starts at rest goes side by side too: not with the bits of a simulation.
#[test]
fn from_rest() {
    let scene = triangle().with(HEAT);
    let begin = |i: u64| start(&scene, 3, i).with_momenta([[0.0; 3]; 3]);
    let mut ensemble = scene.ensemble((0..64).map(begin), Rattle::new(0.02)).unwrap();
    ensemble.run(30);
    for i in (0..64).step_by(5) {
        let mut alone = scene.simulate(begin(i), Rattle::new(0.02)).unwrap();
        alone.run(30).unwrap();
        let off = off(&alone.state(), &ensemble.state(i as usize));
        assert!(off < 1e-12 && (off > 0.0) == InstructionSet::widest().fuses(), "{i}: {off}");
    }
}

/// Where masses differ by direction drag has no single rate.
#[test]
fn drag_by_the_square_as_alone() {
    let mass = |x: f64| [x, 2.0 * x, 0.3];
    let scene = Scene::points(2).link(Rod { length: 1.0 }, [[0, 1]]).masses([mass(1.0), mass(3.0)]);
    as_alone(&scene.with(QuadraticDrag { coefficient: 1.5 }), 2, "drag by the square");
}

#[test]
#[cfg(long)]
fn flows_as_alone() {
    as_alone(&dumbbell().with(Andersen { rate: 5.0, temperature: 0.5, seed: 3 }), 2, "collisions");
    as_alone(&dumbbell().with(VelocityRescaling { time: 0.3, temperature: 0.5, seed: 3 }), 2, "rescaling");
    as_alone(&triangle().with(LinearDrag::along([0.1, 2.0, 0.7]).times([1.0, 3.0, 0.5])), 3, "drag");
    as_alone(&dumbbell().with(MagneticField::new(FIELD).charges([-2.0, 1.0])), 2, "a field");
    as_alone(
        &pendulum().with(MagneticField::new([0.0, 0.0, 3.0])).with(LinearDrag::new(0.5)),
        3,
        "in a plane",
    );
    as_alone(&chain().with(Combed(0.8)), 8, "one's own");
    let several = triangle().with(HEAT).with(MagneticField::new(FIELD)).with(Combed(0.8)).with(HEAT);
    as_alone(&several, 3, "several");
    let (drag, field) = (LinearDrag::along([0.1, 2.0]), MagneticField::new([0.0, 0.0, 1.0]));
    let found = [
        apart(
            Double,
            &pendulum().with(drag.clone()),
            [3, 20],
            &Composition::new(SUZUKI_1990_ORDER_4, 0.04),
            15,
        ),
        apart(Compensated, &pendulum().with(drag), [3, 20], &Geodesic::new(2, 0.02), 30),
        apart(Double, &pendulum().with(field), [3, 20], &Rattle::new(-0.02), 30),
        apart(Double, &pendulum().with(HEAT), [3, 20], &PositionVerlet::new(0.02), 30),
    ];
    assert!(found.iter().all(|&off| off < 1e-12), "{found:?}");
}

#[cfg(long)]
constraint! {
    /// A rod in ten dimensions.
    struct LongRod { length }
    |c: [[f64; 10]; 2]| sum(k in 0..10, (c[0][k] - c[1][k])^2) - length^2
}

/// Bodies of many coordinates.
#[test]
#[cfg(long)]
fn ten_dimensions_as_alone() {
    let rod = || Scene::points::<10>(2).link(LongRod { length: 1.0 }, [[0, 1]]).masses([1.0, 3.0]);
    as_alone(&rod().with(LinearDrag::new(0.9)).with(HEAT), 2, "in ten dimensions");
}

/// Each trajectory of a sweep has masses, links and flows of its own.
#[test]
fn flows_by_lane() {
    let scene = |i: u32| {
        let x = f64::from(i);
        Scene::points(2)
            .link(Rod { length: 1.0 }, [[0, 1]])
            .masses([1.0, 1.0 + 0.1 * x])
            .with(LinearDrag::along([0.01 * x, 0.02, 0.3]))
            .with(Combed(0.01 * x))
            .with(MagneticField::new([0.0, 0.02 * x, 1.0]))
            .with(Langevin { friction: 0.05 * x, seed: u64::from(i % 5), ..HEAT })
    };
    let scenes: Vec<_> = (0..66).map(scene).collect();
    let starts: Vec<_> = scenes.iter().zip(0..).map(|(scene, i)| start(scene, 2, i)).collect();
    let mut sweep =
        Ensemble::sweep(Double, scenes.iter().zip(starts.iter().cloned()), Rattle::new(0.02)).unwrap();
    in_lanes(&sweep);
    sweep.run(30);
    for (i, (scene, start)) in scenes.iter().zip(starts).enumerate() {
        let mut alone = scene.simulate(start, Rattle::new(0.02)).unwrap();
        alone.run(30).unwrap();
        let work = (alone.work() - sweep.work(i)).abs();
        assert!(off(&alone.state(), &sweep.state(i)) < 1e-12 && work < 1e-12, "{i} {work}");
    }
}

/// ½kT for each of five momenta of a dumbbell and of six of a triangle, whatever the masses.
#[test]
fn temperatures() {
    fn check<E: Effects<3>, S: Method>(scene: &Linked<E, 3>, bodies: usize, freedom: f64, method: S) {
        let starts = (0..64).map(|i| start(scene, bodies, i));
        let mut ensemble = scene.ensemble(starts, method).unwrap();
        in_lanes(&ensemble);
        ensemble.run(40);
        let kinetic = || Mean::of(|now: &Sight<'_, 3>| now.kinetic_energy());
        let mean = ensemble.observe(2000, 20, kinetic).mean();
        // Energies lose their past in 1/2γ, 2.5 steps. 6400 samples, of variance f kT²/2 about f kT/2.
        let (expected, samples) = (0.5 * freedom * HEAT.temperature, 6400.0_f64);
        let deviation = HEAT.temperature * (0.5 * freedom / samples).sqrt();
        println!("{mean} {expected} {deviation}");
        assert!((mean - expected).abs() < 4.5 * deviation, "{mean} for {expected}");
    }
    check(&dumbbell().with(HEAT), 2, 5.0, Rattle::new(0.1));
    check(&triangle().with(HEAT), 3, 6.0, Baoab::new(0.1));
}

/// Without forces the same share of all momenta is lost, and energy as work; a field does none.
#[test]
fn work_and_energy() {
    let energy = |ensemble: &Ensemble<3>| -> Vec<f64> {
        let of = |state: State<3>| {
            state.momenta().zip([1.0, 3.0]).map(|(p, m)| p.norm_squared() / (2.0 * m)).sum()
        };
        ensemble.states().map(of).collect()
    };
    let drag = dumbbell().with(LinearDrag::new(0.9).times([1.0, 3.0]));
    let lossless = dumbbell().with(MagneticField::new(FIELD).charges([3.0, -5.0]));
    let mut slowed = drag.ensemble((0..64).map(|i| start(&drag, 2, i)), Rattle::new(0.02)).unwrap();
    let mut turned = lossless.ensemble((0..64).map(|i| start(&lossless, 2, i)), Rattle::new(0.02)).unwrap();
    let first = [energy(&slowed), energy(&turned)];
    slowed.run(50);
    turned.run(500);
    for (i, (now, first)) in energy(&slowed).into_iter().zip(&first[0]).enumerate() {
        assert!(
            (now / (first * (-1.8_f64).exp()) - 1.0).abs() < 1e-12 && *first > 0.05,
            "{i}: {now} {first}"
        );
        assert!((slowed.work(i) - (now - first)).abs() < 1e-13, "{i}: {}", slowed.work(i));
    }
    for (i, (now, first)) in energy(&turned).into_iter().zip(&first[1]).enumerate() {
        assert!((now / first - 1.0).abs() < 1e-12 && turned.work(i).abs() < 1e-13, "{i}: {now} {first}");
    }
}

fn bits<const D: usize>(ensemble: &Ensemble<D>, i: usize) -> String {
    format!("{:?} {:?}", ensemble.state(i), ensemble.work(i).to_bits())
}

/// Some fail. Bits depend on no neighbour, on no division of a run, no observer, not on a checkpoint between.
fn disturb_no_other<C: Effects<3>>(scene: &Linked<C, 3>, bodies: usize) {
    let fast = |i: u64| i % 7 == 3;
    let begin = |i: u64| {
        let start = start(scene, bodies, i);
        let faster: Vec<_> = start.momenta().map(|p| (300.0 + 10.0 * i as f64) * p).collect();
        if fast(i) { start.with_momenta(faster) } else { start }
    };
    let of = |numbers: Vec<u64>| scene.ensemble(numbers.into_iter().map(begin), Rattle::new(0.05)).unwrap();
    let (mut all, mut few) = (of((0..70).collect()), of((0..70).filter(|&i| !fast(i)).collect()));
    all.run(40);
    let record = all.checkpoint();
    all.run(50);
    (0..9).for_each(|_| few.run(10));
    let failed: Vec<_> = all.failures().map(|(i, _)| i as u64).collect();
    assert!(failed.len() > 3 && failed.iter().all(|&i| fast(i)), "{failed:?}");
    for (number, i) in (0..70).filter(|&i| !fast(i)).enumerate() {
        assert_eq!(bits(&few, number), bits(&all, i as usize), "{i}");
    }
    let (mut again, mut seen) = (of((0..70).collect()), of((0..70).collect()));
    again.resume(&record).unwrap();
    again.run(50);
    seen.observe(90, 3, || Mean::of(|now: &Sight<'_, 3>| now.kinetic_energy()));
    for i in 0..70 {
        assert_eq!(bits(&again, i), bits(&all, i), "{i}, from a checkpoint");
        assert_eq!(bits(&seen, i), bits(&all, i), "{i}, observed");
    }
}

#[test]
fn those_that_fail_disturb_no_other() {
    #[cfg(long)]
    disturb_no_other(&triangle().with(LinearDrag::along([0.1, 2.0, 0.7])).with(HEAT), 3);
    disturb_no_other(&chain().with(Combed(0.5)).with(Andersen { rate: 2.0, temperature: 0.1, seed: 3 }), 8);
}

/// A lane that stands in for one that has ended draws as the one that it is a copy of. Where it drew otherwise, it
/// would fail where that one does not, which would go by itself then.
#[test]
#[cfg(long)]
fn stand_ins_draw_as_their_originals() {
    let scene = dumbbell().with(Langevin { temperature: 36.0, ..HEAT }); // so hot that several fail
    let ends = |i: &u64| i.is_multiple_of(3);
    let begin = |i: u64| {
        let start = start(&scene, 2, i);
        let faster: Vec<_> = start.momenta().map(|p| 1e4 * p).collect();
        if ends(&i) { start.with_momenta(faster) } else { start }
    };
    let of = |numbers: Vec<u64>| scene.ensemble(numbers.into_iter().map(begin), Rattle::new(0.05)).unwrap();
    let others: Vec<u64> = (0..64).filter(|i| !ends(i)).collect();
    let (mut all, mut few) = (of((0..64).collect()), of(others.clone()));
    all.run(60);
    few.run(60);
    assert!((0..64).filter(ends).all(|i| all.failure(i as usize).is_some()));
    for (number, i) in others.into_iter().enumerate() {
        assert_eq!(bits(&few, number), bits(&all, i as usize), "{i}");
    }
}

/// Bits are the same by all instruction sets that fuse, and for one thread and two; a bill changes none.
#[test]
#[cfg(long)]
fn bits_depend_on_no_machine() {
    fn check<E: Effects<3>, S: Method>(scene: &Linked<E, 3>, bodies: usize, method: &S) {
        let widest = InstructionSet::widest();
        let of = |set: InstructionSet| {
            let starts = (0..70).map(|i| start(scene, bodies, i));
            Ensemble::of(Double, scene, starts, method.clone(), set).unwrap()
        };
        let all = |ensemble: &Ensemble<3>| (0..ensemble.len()).map(|i| bits(ensemble, i)).collect::<Vec<_>>();
        let mut first = of(widest);
        in_lanes(&first);
        first.run(40);
        let expected = all(&first);
        for set in [InstructionSet::Avx2, InstructionSet::Avx512] {
            if set.is_present() && set.fuses() && widest.fuses() {
                let mut other = of(set);
                other.run(40);
                assert!(all(&other) == expected, "{set}");
            }
        }
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut other = of(widest);
            pool.install(|| other.run(40));
            assert!(all(&other) == expected, "{threads} threads");
        }
        let mut few = scene.ensemble((0..5).map(|i| start(scene, bodies, i)), method.clone()).unwrap();
        few.run(40);
        let before = all(&few);
        assert_eq!(few.bill().unwrap().side_by_side > 1, widest.fuses());
        assert!(all(&few) == before, "after a bill");
    }
    check(&dumbbell().with(HEAT).with(MagneticField::new(FIELD)), 2, &Baoab::new(0.02));
    check(&triangle().with(Combed(0.8)).with(HEAT), 3, &Rattle::new(0.02));
}

/// A checkpoint of other flows is refused.
#[test]
fn other_flows_are_refused() {
    let ensemble = |heat: Langevin| {
        let scene = dumbbell().with(heat);
        scene.ensemble((0..5).map(|i| start(&scene, 2, i)), Rattle::new(0.02)).unwrap()
    };
    let told =
        ensemble(Langevin { seed: 8, ..HEAT }).resume(&ensemble(HEAT).checkpoint()).unwrap_err().to_string();
    assert!(told.contains("flow 0"), "{told}");
}

/// Steps in parts have flows in parts, as in a simulation.
#[test]
fn parts_of_steps() {
    let scene = dumbbell().with(Langevin { temperature: 0.01, ..HEAT }).with(Combed(0.8));
    let begin = |i: u64| {
        let ([a, b], turn) = ([0.0, 1.0].map(|x| [x, 0.0, 0.0]), [0.0, 4.0, 0.0]);
        State::of([a, b]).with_momenta([turn, turn.map(|p: f64| -p)]).numbered(i).after_steps(i)
    };
    let mut ensemble = scene.ensemble((0..20).map(begin), Rattle::new(0.5)).unwrap().retry(8);
    in_lanes(&ensemble);
    ensemble.run(2);
    let mut whole = scene.ensemble((0..20).map(begin), Rattle::new(0.5)).unwrap();
    whole.run(1);
    assert_eq!(whole.failures().count(), 20);
    for i in 0..20 {
        let mut alone = scene.simulate(begin(i), Rattle::new(0.5)).unwrap().retry(8);
        alone.run(2).unwrap();
        let (i, work) = (i as usize, (alone.work() - ensemble.work(i as usize)).abs());
        assert!(off(&alone.state(), &ensemble.state(i)) < 1e-11 && work < 1e-11, "{i} {work}");
    }
}

/// Why trajectories go alone.
#[test]
fn plans() {
    fn of<C: Count, E: Effects<2>>(
        scene: &Scene<Network<2>, E, C, 2>,
        method: impl Method,
    ) -> Option<NotInLanes> {
        let start = State::of([[0.0; 2], [1.0, 0.0], [2.0, 0.0]]);
        scene.ensemble([start], method).unwrap().plan().reason
    }
    if InstructionSet::widest().fuses() {
        let scene = pendulum().with(HEAT);
        assert_eq!(of(&scene, Rattle::new(0.01)), None);
        assert_eq!(of(&scene, Lobatto::<3>::new(0.01)), Some(NotInLanes::Flows));
        assert_eq!(of(&pendulum(), Lobatto::<3>::new(0.01)), None);
    }
}
