//! Rigid bodies in lanes: as each trajectory alone but for rounding, whatever the moments of inertia, effects and
//! methods.

use crate::common::larger;
use crate::lanes_linked::Told;
use rattle::bodies::Count;
use rattle::composition::{KAHAN_LI_1997_ORDER_8, SUZUKI_1990_ORDER_4};
use rattle::effect::{Effects, Langevin};
use rattle::ensemble::InstructionSet;
use rattle::method::Method;
use rattle::nalgebra::{Rotation3, Vector3};
use rattle::prelude::*;

potential! {
    /// A weight, and a field that knows all three axes.
    pub(crate) struct Field { weight, pull }
    |q: [[f64; 3]; 3]| weight * q[2][2] + pull * (q[0][1]^2 + q[1][0] / 3)
}

potential! {
    /// Of two bodies: their third axes like to be alike.
    pub(crate) struct Alike { strength }
    |a: [[f64; 3]; 3], b: [[f64; 3]; 3]| -strength * (a[0][2] * b[0][2] + a[1][2] * b[1][2] + a[2][2] * b[2][2])
}

potential! {
    /// No number where the third axis points down.
    struct Upright {}
    |q: [[f64; 3]; 3]| sqrt(q[2][2] + 0.2)
}

/// From a sphere, and nearly one, to needles and a lamina.
const MOMENTS: [[f64; 3]; 8] = [
    [0.6, 0.8, 1.0],
    [1.0, 1.0, 0.4],
    [1.0, 2.0, 3.0],
    [1.0, 1.0, 1.0],
    [1.0, 1.0 - 1e-9, 1.0 + 1e-9],
    [1.0, 1.0, 1e-3],
    [1.0, 1.0 + 1e-7, 1e-6],
    [2e80, 1e80, 1.5e80],
];

/// Turning at about this speed.
pub(crate) fn start(i: u32, moments: [f64; 3], speed: f64) -> State<9> {
    let i = f64::from(i);
    let attitude = Rotation3::from_euler_angles(0.3 + 0.1 * i, 0.5 - 0.07 * i, 0.2 * i);
    let rate = speed * Vector3::new((1.0 + i).sin(), (2.0 * i + 0.5).cos(), (0.7 * i + 0.3).sin());
    Rigid::start(attitude.matrix(), &rate.component_mul(&Vector3::from(moments)))
}

/// Three bodies of these moments, which turn at about this speed.
pub(crate) fn start_of_three(i: u32, moments: [f64; 3], speed: f64) -> State<9> {
    let bodies = [0, 1, 2].map(|body| start(3 * i + body, moments, speed));
    let places = bodies.each_ref().map(|body| body.positions().next().unwrap());
    State::of(places).with_momenta(bodies.map(|body| body.momenta().next().unwrap()))
}

/// How far attitudes, and momenta by the largest moment of inertia, of these trajectories are off those of simulations.
pub(crate) fn off<E: Effects<9>, N: Count, S: Method>(
    ensemble: &mut Ensemble<9>,
    scene: impl Fn(usize) -> Scene<Rigid, E, N, 9>,
    starts: &[State<9>],
    method: &S,
    steps: u64,
    moments: [f64; 3],
) -> f64 {
    ensemble.run(steps);
    let size = moments.into_iter().fold(0.0, larger);
    let apart = starts.iter().enumerate().step_by(5).map(|(i, start)| {
        let mut simulation = scene(i).simulate(start.clone(), method.clone()).unwrap();
        simulation.run(steps).unwrap();
        let state = ensemble.state(i);
        assert_eq!((ensemble.failure(i), state.time()), (None, simulation.time()));
        let places = state.positions().zip(simulation.positions()).map(|(a, b)| (a - b).amax());
        let ways = state.momenta().zip(simulation.momenta()).map(|(a, b)| (a - b).amax() / size);
        places.chain(ways).fold(0.0, larger)
    });
    apart.fold(0.0, larger)
}

/// Whether all is rounding, and something is.
pub(crate) fn check(found: &[f64], what: [f64; 3]) {
    println!("{what:?}: {found:?}");
    let fused = InstructionSet::widest().fuses(); // else all go alone, and nothing differs
    assert!(found.iter().all(|&off| off < 3e-14 && (off > 0.0) == fused), "{what:?}: {found:?}");
}

/// Ensembles of this scene, of so many trajectories.
fn agree<E: Effects<9>, P: Precision, S: Method>(
    precision: P,
    scene: &Scene<Rigid, E, rattle::bodies::One, 9>,
    moments: [f64; 3],
    number: u32,
    method: &S,
    steps: u64,
) -> f64
where
    Scene<Rigid, E, rattle::bodies::One, 9>: Copy,
{
    let starts: Vec<_> = (0..number).map(|i| start(i, moments, 1.0)).collect();
    let mut ensemble = scene.ensemble_in(precision, starts.iter().cloned(), method.clone()).unwrap();
    off(&mut ensemble, |_| *scene, &starts, method, steps, moments)
}

#[test]
fn free_bodies() {
    for moments in MOMENTS {
        let scene = Scene::rigid(Rigid::new(moments));
        check(
            &[
                agree(Double, &scene, moments, 70, &Rattle::new(0.05), 40),
                agree(Compensated, &scene, moments, 9, &Rattle::new(0.3), 20), // in a row of a few
                agree(Compensated, &scene, moments, 70, &Composition::new(SUZUKI_1990_ORDER_4, 0.1), 10),
                agree(Double, &scene, moments, 70, &Dop853::new(0.2), 10),
                agree(Double, &scene, moments, 9, &Dop853::adaptive(0.5, 1e-10), 4),
                agree(Double, &scene, moments, 9, &Dop853::adaptive(1.0, 1e-3), 2),
                agree(Double, &scene, moments, 70, &Taylor::new(9, 0.2), 10),
                agree(Double, &scene, moments, 9, &Taylor::adaptive(14, 0.5, 1e-13), 4),
            ],
            moments,
        );
    }
}

#[test]
fn heavy_bodies() {
    for moments in MOMENTS {
        // So heavy, that a needle is not turned too fast.
        let weight = 0.3 * moments.into_iter().fold(f64::INFINITY, f64::min);
        let scene = Scene::rigid(Rigid::new(moments)).with(Field { weight, pull: 0.5 * weight });
        check(
            &[
                agree(Double, &scene, moments, 70, &Rattle::new(0.05), 40),
                agree(Compensated, &scene, moments, 70, &Composition::new(KAHAN_LI_1997_ORDER_8, 0.2), 5),
                agree(Double, &scene, moments, 70, &Dop853::new(0.05), 40),
                agree(Double, &scene, moments, 9, &Dop853::adaptive(-0.5, 1e-10), 4),
                agree(Double, &scene, moments, 70, &Taylor::new(15, 0.1), 20),
                agree(Double, &scene, moments, 9, &Taylor::adaptive(18, -1.0, 1e-13), 2),
            ],
            moments,
        );
    }
    let moments = MOMENTS[0];
    let scene = Scene::rigid(Rigid::new(moments)).with(Field { weight: 1.0, pull: 0.5 });
    check(
        &[
            agree(Single, &scene, moments, 70, &Rattle::new(0.05), 40), // in double precision too
            agree(Double, &scene, moments, 70, &PositionVerlet::new(0.05), 40),
            agree(Double, &scene, moments, 9, &SymplecticEuler::new(-0.05), 40),
            agree(Compensated, &scene, moments, 9, &Composition::new(SUZUKI_1990_ORDER_4, 0.1), 10),
        ],
        moments,
    );
}

/// Several bodies in one scene: alone they are what each is, in lanes as alone; also where two of them feel each other.
#[test]
fn several_bodies() {
    let (moments, method) = (MOMENTS[0], Rattle::new(0.05));
    let one = Scene::rigid(Rigid::new(moments)).with(Field { weight: 1.0, pull: 0.5 });
    let starts: Vec<_> = (0..70).map(|i| start_of_three(i, moments, 1.0)).collect();
    let three = one.bodies(3);
    let mut simulation = three.simulate(starts[4].clone(), method).unwrap();
    simulation.run(100).unwrap();
    for (body, place) in simulation.positions().enumerate() {
        let mut alone = one.simulate(start(12 + body as u32, moments, 1.0), method).unwrap();
        alone.run(100).unwrap();
        assert_eq!(place, alone.position(), "bit for bit");
    }
    let mut ensemble = three.ensemble(starts.iter().cloned(), method).unwrap();
    let each = off(&mut ensemble, |_| three, &starts, &method, 40, moments);
    let coupled = three.with(Alike { strength: 0.7 }.over([[0, 1], [1, 2]]));
    let mut ensemble = coupled.ensemble(starts.iter().cloned(), method).unwrap();
    let pairs = off(&mut ensemble, |_| coupled.clone(), &starts, &method, 40, moments);
    let explicit = Dop853::adaptive(0.5, 1e-9);
    let mut ensemble = coupled.ensemble(starts.iter().cloned(), explicit).unwrap();
    let by_dop853 = off(&mut ensemble, |_| coupled.clone(), &starts, &explicit, 4, moments);
    check(&[each, pairs, by_dop853], moments);
    for series in [Taylor::new(12, 0.05), Taylor::adaptive(12, 0.3, 1e-12)] {
        let mut ensemble = coupled.ensemble(starts.iter().cloned(), series).unwrap();
        check(&[off(&mut ensemble, |_| coupled.clone(), &starts, &series, 4, moments)], moments);
    }
    assert_eq!(ensemble.bodies(), 3);
}

/// Bits of a trajectory depend on no neighbour, no division of the run, no number of threads, no instruction set that
/// fuses, and not on a checkpoint. Some trajectories turn by more than lanes can hold, some so fast that they end, at
/// least so many.
#[test]
fn the_same_bits_everywhere() {
    let (moments, steps) = (MOMENTS[0], 200);
    let scene = Scene::rigid(Rigid::new(moments)).with(Field { weight: 1.0, pull: 0.5 });
    let wild = |i: u32| i.is_multiple_of(5);
    let start = |i: u32| start(i, moments, if wild(i) { 1.0 + 0.2 * f64::from(i) } else { 0.7 });
    fn check<S: Method>(
        scene: &(impl Fn(&[u32], InstructionSet, S) -> Ensemble<9> + Sync),
        method: &S,
        wild: impl Fn(u32) -> bool,
        steps: u64,
        least: usize,
    ) {
        let of = |numbers: &[u32], set| scene(numbers, set, method.clone());
        let bits = |ensemble: &Ensemble<9>| {
            let of = |i| (ensemble.state(i), ensemble.failure(i).is_some(), ensemble.work(i).to_bits());
            (0..ensemble.len()).map(|i| format!("{:?}", of(i))).collect::<Vec<_>>()
        };
        let (numbers, widest): (Vec<u32>, _) = ((0..90).collect(), InstructionSet::widest());
        let mut first = of(&numbers, widest);
        first.run(steps);
        let expected = bits(&first);
        let ended = first.failures().map(|(i, _)| i as u32).collect::<Vec<_>>();
        println!("{} ended", ended.len());
        assert!((least..18).contains(&ended.len()) && ended.iter().all(|&i| wild(i)), "{ended:?}");
        for set in [InstructionSet::Avx2, InstructionSet::Avx512] {
            if set.is_present() && set.fuses() && widest.fuses() {
                let mut other = of(&numbers, set);
                other.run(steps);
                assert_eq!(bits(&other), expected, "{set}");
            }
        }
        let mut parts = of(&numbers, widest);
        for part in [1, 63, 2, 71, 63] {
            parts.run(part);
            let (record, mut again) = (parts.checkpoint(), of(&numbers, widest));
            again.resume(&record).unwrap();
            parts = again;
        }
        assert_eq!(bits(&parts), expected, "in parts");
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let mut others = of(&numbers[7..], widest);
        pool.install(|| others.run(steps));
        assert_eq!(bits(&others), expected[7..], "others beside them");
        let calm = numbers.iter().copied().filter(|&i| !wild(i)).collect::<Vec<_>>();
        let mut calm_ones = of(&calm, widest);
        calm_ones.run(steps);
        for (state, i) in bits(&calm_ones).into_iter().zip(calm) {
            assert_eq!(state, expected[i as usize], "trajectory {i} without its wild neighbours");
        }
        let mut alone = of(&[77], widest);
        alone.run(steps);
        assert_eq!(bits(&alone)[0], expected[77]);
    }
    let rattle = |numbers: &[u32], set, method: Rattle| {
        Ensemble::of(Double, &scene, numbers.iter().map(|&i| start(i)), method, set).unwrap()
    };
    check(&rattle, &Rattle::new(0.1), wild, steps, 3);
    let hot = scene.with(Langevin { friction: 0.1, temperature: 0.01, seed: 3 });
    let stirred = |numbers: &[u32], set, method: Rattle| {
        let starts = numbers.iter().map(|&i| start(i).numbered(i.into()));
        Ensemble::of(Double, &hot, starts, method, set).unwrap()
    };
    check(&stirred, &Rattle::new(0.1), wild, steps, 3);
    let suzuki = |numbers: &[u32], set, method: Composition<Rattle>| {
        Ensemble::of(Compensated, &scene, numbers.iter().map(|&i| start(i)), method, set).unwrap()
    };
    check(&suzuki, &Composition::new(SUZUKI_1990_ORDER_4, 0.2), wild, steps, 3);
    let explicit = |numbers: &[u32], set, method: Dop853| {
        Ensemble::of(Double, &scene, numbers.iter().map(|&i| start(i)), method, set).unwrap()
    };
    check(&explicit, &Dop853::new(0.4), wild, steps, 3);
    if cfg!(long) {
        check(&explicit, &Dop853::adaptive(0.2, 1e-9), wild, steps, 0); // none is too fast for inner steps
    }
    let series = |numbers: &[u32], set, method: Taylor| {
        Ensemble::of(Double, &scene, numbers.iter().map(|&i| start(i)), method, set).unwrap()
    };
    if cfg!(long) {
        check(&series, &Taylor::new(6, 0.4), wild, steps, 3);
    }
    check(&series, &Taylor::adaptive(12, 0.2, 1e-9), wild, steps, 0);
}

/// Where a body turns too far for a step, or its force is no number, a lane ends where a simulation ends, and says what
/// that says but for rounding; and so does what is halved.
#[test]
fn lanes_end_where_simulations_end() {
    let [whole, halved] = end_alike(Rattle::new(0.3));
    assert!(whole.0 > 3 && whole.1 > 3, "{whole:?}");
    assert!(halved.0 <= 3 && halved.1 > 3, "what is halved turns less far: {halved:?}");
    end_alike(Dop853::new(0.3)); // which says that stages are no numbers, whatever of them
    end_alike(Dop853::adaptive(0.3, 1e-6));
    end_alike(Taylor::new(8, 0.3));
    end_alike(Taylor::adaptive(12, 0.3, 1e-9));
}

/// How many of 64 end, of another reason than a force and of a force, without and with halved steps.
fn end_alike<M: Method + Copy>(method: M) -> [(usize, usize); 2] {
    let moments = MOMENTS[0];
    let scene = Scene::rigid(Rigid::new(moments)).with(Field { weight: 1.0, pull: 0.5 }).with(Upright {});
    // Figures are those of attitudes that differ by rounding.
    let words = |error: Option<&rattle::Error>| {
        let text = error.map(ToString::to_string).unwrap_or_default();
        text.chars().filter(|c| !c.is_ascii_digit() && !"-.e".contains(*c)).collect::<String>()
    };
    [0, 5].map(|halvings| {
        let start = |i: u32| start(i % 8, moments, 0.1 + 0.05 * f64::from(i));
        let mut ensemble = scene.ensemble((0..64).map(start), method).unwrap().retry(halvings);
        ensemble.run(8);
        let (mut told, mut far) = (Vec::new(), 0.0_f64);
        for i in 0..64 {
            let mut simulation = scene.simulate(start(i), method).unwrap().retry(halvings);
            let end = simulation.run(8).err();
            let (state, why) = (ensemble.state(i as usize), ensemble.failure(i as usize));
            assert_eq!(state.time(), simulation.time(), "trajectory {i}: {why:?}, {end:?}");
            assert_eq!(words(why), words(end.as_ref()), "trajectory {i}");
            far = far.max((state.positions().next().unwrap() - simulation.position()).amax());
            told.extend(end.map(|end| end.to_string().contains("Upright")));
        }
        let of_force = told.iter().filter(|&&of_force| of_force).count();
        println!("{} ended, {of_force} of a force, others {far:e} apart", told.len());
        assert!((4..60).contains(&told.len()) && far < 1e-9, "{told:?} {far:e}");
        (told.len() - of_force, of_force)
    })
}

/// What a sight tells in lanes, it tells of simulations.
#[test]
fn sights_tell_the_same() {
    let (moments, method) = (MOMENTS[0], Rattle::new(0.05));
    let scene = Scene::rigid(Rigid::new(moments)).with(Field { weight: 1.0, pull: 0.5 });
    let starts: Vec<_> = (0..3).map(|i| start(i, moments, 1.0)).collect();
    let mut ensemble = scene.ensemble(starts.iter().cloned(), method).unwrap();
    let seen = ensemble.observe(30, 10, || Each::of(Told::default));
    for (i, start) in starts.iter().enumerate() {
        let off = seen.get(i).unwrap().off_alone(&scene, start, &method);
        assert!(off < 1e-13, "{i}: {off:e}");
    }
    let bill = ensemble.bill().unwrap();
    let side_by_side = InstructionSet::widest().fuses();
    assert_eq!((bill.side_by_side > 1, &bill.items[0].what[..]), (side_by_side, "force of `Field`"));
}
