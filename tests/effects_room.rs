//! Effects with room of their own: a list of near pairs, made before the first step and renewed when a body has moved
//! by half of its skin, against the same force between all pairs. Forces do not depend on room, so all is equal to the
//! bit.

use rattle::effect::{Acting, Effect, Moment};
use rattle::lanes::Lane;
use rattle::prelude::*;
use rattle::real::{Mask, Real};
use rattle::surfaces::Sphere;
use std::array::from_fn;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// U = Σ (1 − r²/reach²)³ over all pairs nearer than `reach`; the list holds those nearer than `reach + skin`.
#[derive(Debug, Clone)]
struct Near {
    reach: f64,
    skin: f64,
    counts: Arc<Counts>,
}

#[derive(Debug, Default)]
struct Counts {
    rooms: AtomicU64,
    evaluations: AtomicU64,
    lists: AtomicU64,
}

/// Pairs that are near where the bodies were when the list was made, in the order of their numbers.
#[derive(Debug, Clone)]
struct List<T, const D: usize> {
    made_at: Vec<[T; D]>,
    pairs: Vec<(usize, usize)>,
}

/// The kind of effect that acts between near bodies.
struct BetweenNear;

impl<const D: usize> Effect<D, BetweenNear> for Near {
    type Acting<T: Real> = Near;
    fn acting<T: Real>(&self) -> Near {
        self.clone()
    }
    type Swept<S: Lane, const L: usize> = [Near; L];
}

fn apart<T: Real, const D: usize>(a: &[T; D], b: &[T; D]) -> ([T; D], T) {
    let apart: [T; D] = from_fn(|d| a[d] - b[d]);
    (apart, apart.iter().fold(T::from_f64(0.0), |sum, &x| sum + x * x))
}

impl<T: Real, const D: usize> Acting<T, D> for Near {
    type Room = List<T, D>;
    fn room(&self, bodies: usize) -> List<T, D> {
        self.counts.rooms.fetch_add(1, Relaxed);
        let nowhere = [T::from_f64(f64::NAN); D];
        List { made_at: vec![nowhere; bodies], pairs: Vec::with_capacity(bodies * bodies / 2) }
    }

    fn add_forces(&self, at: Moment<'_, T, D>, list: &mut List<T, D>, forces: &mut [[T; D]]) {
        self.counts.evaluations.fetch_add(1, Relaxed);
        let half = T::from_f64(0.25 * self.skin * self.skin);
        let stays = |(q, was)| apart::<T, D>(q, was).1.le(half).all(); // false for NaN
        if !at.positions.iter().zip(&list.made_at).all(stays) {
            self.counts.lists.fetch_add(1, Relaxed);
            list.made_at.copy_from_slice(at.positions);
            list.pairs.clear();
            let far = T::from_f64((self.reach + self.skin).powi(2));
            for i in 1..at.positions.len() {
                let near = |&j: &usize| !far.lt(apart(&at.positions[i], &at.positions[j]).1).all();
                list.pairs.extend((0..i).filter(near).map(|j| (i, j)));
            }
        }
        let (zero, square) = (T::from_f64(0.0), T::from_f64(self.reach * self.reach));
        for &(i, j) in &list.pairs {
            let (apart, s) = apart(&at.positions[i], &at.positions[j]);
            let left = T::from_f64(1.0) - s / square;
            let pull = T::select(s.lt(square), T::from_f64(6.0) * left * left / square, zero);
            for d in 0..D {
                forces[i][d] = forces[i][d] + pull * apart[d];
                forces[j][d] = forces[j][d] - pull * apart[d];
            }
        }
    }

    fn energy(&self, at: Moment<'_, T, D>) -> T {
        let (mut energy, square) = (T::from_f64(0.0), T::from_f64(self.reach * self.reach));
        for (i, q) in at.positions.iter().enumerate() {
            for other in &at.positions[..i] {
                let left = T::from_f64(1.0) - apart(q, other).1 / square;
                energy = energy + T::select(T::from_f64(0.0).lt(left), left * left * left, T::from_f64(0.0));
            }
        }
        energy
    }
}

/// Near pairs with this skin: all pairs where it is infinite.
fn near(skin: f64) -> (Near, Arc<Counts>) {
    let counts = Arc::new(Counts::default());
    (Near { reach: 0.6, skin, counts: counts.clone() }, counts)
}

const BODIES: usize = 12;

fn start<const D: usize>() -> State<D> {
    let number = |i: usize, d: usize| (1.7 * (D * i + d) as f64 + 0.3 * (i * i) as f64).sin();
    let state = State::of((0..BODIES).map(|i| from_fn::<_, D, _>(|d| number(i, d))));
    state.with_momenta((0..BODIES).map(|i| from_fn::<_, D, _>(|d| number(d, i))))
}

fn bits<const D: usize>(positions: impl Iterator<Item = rattle::nalgebra::SVector<f64, D>>) -> Vec<u64> {
    positions.flat_map(|q| <[f64; D]>::from(q).map(f64::to_bits)).collect()
}

/// Steps of a method with a list and with all pairs, also after a restart.
macro_rules! lists_are_all_pairs {
    ($scene:expr, $method:expr) => {{
        let ((listed, counts), (all, _)) = (near(0.3), near(f64::INFINITY));
        let (listed, all) = ($scene.with(listed), $scene.with(all));
        let start = listed.project(&start()).unwrap();
        let mut by_list = listed.simulate(start.clone(), $method).unwrap();
        let mut by_all = all.simulate(start, $method).unwrap();
        by_list.run(150).unwrap();
        by_all.run(150).unwrap();
        assert_eq!(bits(by_list.positions()), bits(by_all.positions()), "{}", stringify!($method));
        assert_eq!(bits(by_list.momenta()), bits(by_all.momenta()), "{}", stringify!($method));
        assert_eq!(by_list.multipliers(), by_all.multipliers());
        let (evaluations, lists) = (counts.evaluations.load(Relaxed), counts.lists.load(Relaxed));
        assert!(lists >= 5 && 3 * lists < evaluations, "{lists} lists in {evaluations} evaluations");

        // A list made elsewhere changes nothing: restarts and clones go on alike.
        let mut again = listed.simulate(by_list.state(), $method).unwrap();
        let mut cloned = by_list.clone();
        by_list.run(50).unwrap();
        again.run(50).unwrap();
        cloned.run(50).unwrap();
        assert_eq!(bits(again.positions()), bits(by_list.positions()), "{}", stringify!($method));
        assert_eq!(bits(cloned.positions()), bits(by_list.positions()));
        let off = by_list.energy_error() / by_list.energy();
        assert!(off.abs() < 2e-3, "{off:e}");
    }};
}

#[test]
fn near_pairs_are_all_that_act() {
    let gas = || Scene::on(Sphere { r: 1.0 }).bodies(BODIES);
    lists_are_all_pairs!(gas(), Rattle::new(0.01));
    lists_are_all_pairs!(gas(), Lobatto::<3>::new(0.02));
    let free = || Scene::points::<2>(BODIES);
    lists_are_all_pairs!(free(), Rattle::new(0.01));
    lists_are_all_pairs!(free(), Lobatto::<3>::new(0.02));
    lists_are_all_pairs!(free(), Dop853::new(0.02));
}

#[test]
fn rigid_bodies_have_room_too() {
    let body = || Scene::rigid(Rigid::new([1.0, 1.2, 1.4])).bodies(3);
    let attitudes = [0.1_f64, 0.3, 0.5].map(|angle| {
        let (sin, cos) = angle.sin_cos();
        [cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0]
    });
    let run = |skin| {
        let (effect, counts) = near(skin);
        let mut simulation = body().with(effect).simulate(State::of(attitudes), Rattle::new(0.05)).unwrap();
        simulation.run(100).unwrap();
        (bits(simulation.positions()), counts.lists.load(Relaxed))
    };
    let ((listed, lists), (all, once)) = (run(0.2), run(f64::INFINITY));
    assert_eq!(listed, all);
    assert!(lists > once && listed[0] != 0.1_f64.cos().to_bits(), "{lists} lists");
}

/// A step that fails, is retried in parts, or is taken back leaves a list elsewhere; what follows is the same.
#[test]
fn failed_steps_and_retries() {
    let fast = |skin| {
        let (effect, counts) = near(skin);
        let scene = Scene::on(Sphere { r: 1.0 }).bodies(BODIES).with(effect);
        let start = scene.project(&start()).unwrap();
        let simulation = scene.simulate(start, Rattle::new(0.8)).unwrap();
        (simulation, counts)
    };
    let ((mut listed, _), (mut all, _)) = (fast(0.3), fast(f64::INFINITY));
    let fails = |simulation: &mut dyn FnMut() -> Result<(), rattle::Error>| {
        (0..100).find_map(|_| simulation().err()).expect("a step too long").to_string()
    };
    let (by_list, by_all) = (fails(&mut || listed.step()), fails(&mut || all.step()));
    assert_eq!(by_list, by_all);
    assert_eq!(bits(listed.positions()), bits(all.positions()));
    assert_eq!(listed.multipliers(), all.multipliers());

    let (mut listed, mut all) = (listed.retry(8), all.retry(8));
    listed.run(20).unwrap();
    all.run(20).unwrap();
    assert_eq!(bits(listed.positions()), bits(all.positions()));

    let ((listed, _), (all, _)) = (fast(0.3), fast(f64::INFINITY));
    let (mut listed, mut all) =
        (listed.retry(8).check_reversal(1e-11).unwrap(), all.retry(8).check_reversal(1e-11).unwrap());
    listed.run(5).unwrap();
    all.run(5).unwrap();
    assert_eq!(bits(listed.positions()), bits(all.positions()));
}

/// Trajectories of an ensemble have a room each, and so do not go in lanes.
#[test]
fn ensembles() {
    let (effect, counts) = near(0.3);
    let gas = Scene::on(Sphere { r: 1.0 }).bodies(BODIES).with(effect.clone());
    let alone = Scene::on(Sphere { r: 1.0 }).with(effect);
    let gases: Vec<_> = (0..3)
        .map(|i| {
            let places: Vec<_> = start::<3>().positions().collect();
            let turned = State::of((0..BODIES).map(|k| places[(k + i) % BODIES]));
            gas.project(&turned).unwrap()
        })
        .collect();
    let mut ensemble = gas.ensemble(gases.clone(), Rattle::new(0.01)).unwrap();
    ensemble.run(60);
    for (i, start) in gases.into_iter().enumerate() {
        let mut simulation = gas.simulate(start, Rattle::new(0.01)).unwrap();
        simulation.run(60).unwrap();
        assert_eq!(bits(ensemble.state(i).positions()), bits(simulation.positions()));
    }
    let one = State::at([0.0, 0.0, 1.0]).moving([1.0, 0.0, 0.0]);
    let rooms = counts.rooms.load(Relaxed);
    let mut ensemble = alone.ensemble(vec![one.clone(); 100], Rattle::new(0.01)).unwrap();
    assert!(counts.rooms.load(Relaxed) >= rooms + 100);
    let made = counts.rooms.load(Relaxed);
    ensemble.run(10);
    assert_eq!(counts.rooms.load(Relaxed), made, "no room is made in a step");
    let mut simulation = alone.simulate(one, Rattle::new(0.01)).unwrap();
    simulation.run(10).unwrap();
    assert_eq!(bits(ensemble.state(99).positions()), bits(simulation.positions()));
}

#[test]
fn steps_do_not_allocate() {
    let (effect, counts) = near(0.3);
    let gas = Scene::on(Sphere { r: 1.0 }).bodies(BODIES).with(effect.clone());
    let mut on_sphere = gas.simulate(gas.project(&start()).unwrap(), Lobatto::<3>::new(0.02)).unwrap();
    let mut free = Scene::points::<2>(BODIES).with(effect).simulate(start(), Rattle::new(0.01)).unwrap();
    let lists = counts.lists.load(Relaxed);
    let allocated = allocation_counter::measure(|| {
        on_sphere.run(100).unwrap();
        free.run(100).unwrap();
    });
    assert_eq!(allocated.count_total, 0);
    assert!(counts.lists.load(Relaxed) > lists + 5);
}
