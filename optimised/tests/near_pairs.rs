//! Forces between near pairs: against plain loops over all pairs, bit for bit, wherever bodies go; cut-offs, kinds and
//! periodic boxes against their formulas; laws of a gas on a surface that repeats itself; errors.

use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use rattle::Error;
use rattle::bodies::Many;
use rattle::effect::{
    Acting, AlongSurface, BetweenKinds, BetweenNear, BetweenNearKinds, Effect, Effects, Moment, Within,
};
use rattle::error::PairMistake;
use rattle::instructions::InstructionSet;
use rattle::kernel::{Open, PairKernel, Periodic, Space};
use rattle::lanes::Fused;
use rattle::nalgebra::SVector;
use rattle::potentials::{LennardJones, Wca};
use rattle::prelude::*;
use rattle::real::Real;
use rattle::surfaces::{Gyroid, Sphere};
use std::array::from_fn;
use std::f64::consts::{PI, TAU};

pair_potential! {
    /// Odd, with a root and a pole.
    struct Screened { strength, length }
    |r| strength * exp(-r / length) / r
}

const SCREENED: Screened = Screened { strength: 0.7, length: 0.5 };
const LJ: LennardJones = LennardJones { epsilon: 1.0, sigma: 0.1 };
const REACH: f64 = 0.3;

fn random(seed: u64) -> SmallRng {
    SmallRng::seed_from_u64(seed)
}

fn vectors<const D: usize>(n: usize, size: f64, random: &mut SmallRng) -> Vec<[f64; D]> {
    (0..n).map(|_| from_fn(|_| random.random_range(-size..size))).collect()
}

fn bits<const D: usize>(vectors: &[[f64; D]]) -> Vec<u64> {
    vectors.iter().flatten().map(|x| x.to_bits()).collect()
}

/// Bodies that flow, cluster, collapse, fly apart and come back. They move by a twentieth of the reach or so, a sixth
/// of the skin: a list lasts some moves.
fn itinerary<const D: usize>(n: usize, far: f64) -> Vec<Vec<[f64; D]>> {
    let mut random = random(D as u64);
    // Some thirty bodies within reach of each.
    let ball = [2.0, PI, 4.0 / 3.0 * PI][D - 1];
    let size = 0.5 * REACH * (n as f64 / 30.0 * ball).powf(1.0 / D as f64);
    let mut places = vectors::<D>(n, size, &mut random);
    let velocities = vectors::<D>(n, REACH / 20.0, &mut random);
    let mut stops = vec![places.clone()];
    let mut go = |change: &dyn Fn(usize, [f64; D]) -> [f64; D], times: usize| {
        for _ in 0..times {
            places = (0..n).map(|i| change(i, places[i])).collect();
            stops.push(places.clone());
        }
    };
    go(&|i, q| from_fn(|d| q[d] + velocities[i][d]), 25);
    go(&|i, q| from_fn(|d| q[d] + 0.1 * ((i % 7) as f64 * size / 4.0 - size - q[d])), 12); // seven clusters
    go(&|_, q| q.map(|x| 0.8 * x), 8);
    go(&|_, q| q.map(|x| 1.6 * x), 8);
    go(&|i, q| if i == 5 { [far; D] } else { q }, 1);
    go(&|i, q| if i == 5 { [0.01; D] } else { q }, 1);
    go(&|i, q| from_fn(|d| q[d] - velocities[i][d]), 5);
    stops
}

/// Forces of U(r) − U(reach), body after body in the order of their numbers.
fn plain_loop<T: Real, P: PairPotential, const D: usize>(
    potential: &P,
    space: &impl Space<D>,
    places: &[[f64; D]],
    double: fn(T) -> f64,
) -> Vec<[f64; D]> {
    let kernel = potential.kernel::<T>();
    let places: Vec<_> = places.iter().map(|q| q.map(T::from_f64)).collect();
    let mut forces = vec![[T::from_f64(-0.0); D]; places.len()];
    for i in 1..places.len() {
        for j in 0..i {
            let apart = space.apart(&places[i], &places[j]);
            let square = (1..D).fold(apart[0] * apart[0], |sum, d| apart[d].multiply_add(apart[d], sum));
            if double(square) < REACH * REACH {
                let pull = T::from_f64(-2.0) * kernel.slope(square);
                for d in 0..D {
                    forces[i][d] = pull.multiply_add(apart[d], forces[i][d]);
                    forces[j][d] = (-pull).multiply_add(apart[d], forces[j][d]);
                }
            }
        }
    }
    forces.iter().map(|force| force.map(double)).collect()
}

/// Forces by a list are those of the plain loop at every stop.
fn as_in_a_plain_loop<P, B, const D: usize>(n: usize, potential: P, space: B, within: &Within<P, B>)
where
    P: PairPotential,
    B: Space<D>,
{
    let acting = Effect::<D, BetweenNear>::acting::<f64>(within);
    let mut list = Acting::<f64, D>::room(&acting, n);
    let (mut lengths, mut strong) = (Vec::new(), false);
    let far = if space.periods()[0].is_finite() { 1e5 } else { 1e300 };
    for (stop, places) in itinerary::<D>(n, far).iter().enumerate() {
        let mut forces = vec![[-0.0; D]; n];
        acting.add_forces(Moment { time: 0.0, positions: places }, &mut list, &mut forces);
        let expected = if InstructionSet::widest().fuses() {
            plain_loop::<Fused<f64>, _, D>(&potential, &space, places, |x| x.0)
        } else {
            plain_loop::<f64, _, D>(&potential, &space, places, |x| x)
        };
        assert_eq!(bits(&forces), bits(&expected), "{n} bodies, {D} coordinates, {space:?}, stop {stop}");
        lengths.push(list.pairs());
        strong |= forces.iter().flatten().any(|f| f.abs() > 1.0);
    }
    assert!(strong);
    let lists = 1 + lengths.windows(2).filter(|pair| pair[0] != pair[1]).count();
    assert!((10..lengths.len() - 10).contains(&lists), "{lists} lists at {} stops", lengths.len());
    let all = n * (n - 1) / 2;
    assert!(lengths[0] < all / 3 && lengths.contains(&all), "{lengths:?}, {all} pairs");
}

#[test]
#[cfg(long)]
fn forces_are_those_of_a_plain_loop_to_the_bit() {
    let within = SCREENED.within(REACH).shifted();
    as_in_a_plain_loop::<_, _, 2>(500, SCREENED, Open, &within);
    as_in_a_plain_loop::<_, _, 3>(500, SCREENED, Open, &within.skin(0.5 * REACH));
    // One cell, two, three, or more around, or space without end.
    for periods in [[0.7, 1.4, 1.1], [1.2, 2.0, f64::INFINITY], [2.5, 0.6, 1.5]] {
        let within = LJ.within(REACH).shifted().periodic(periods);
        as_in_a_plain_loop(500, LJ, Periodic::new(periods), &within);
    }
}

/// Periods that are whole numbers, and coordinates of twenty bits: all differences are exact.
#[test]
fn whole_periods_change_nothing() {
    let (mut random, n) = (random(7), 300);
    let within = LJ.within(REACH).periodic([1.0, 2.0, 1.0]);
    let acting = Effect::<3, BetweenNear>::acting::<f64>(&within);
    let places: Vec<[f64; 3]> = (0..n)
        .map(|_| from_fn(|_| f64::from(random.random_range(-(1 << 19)..1 << 19)) / f64::from(1 << 20)))
        .collect();
    let shifted: Vec<[f64; 3]> = places
        .iter()
        .map(|q| from_fn(|d| q[d] + [1.0, 2.0, 1.0][d] * f64::from(random.random_range(-100..100))))
        .collect();
    let at = |positions: &[[f64; 3]]| {
        let (mut forces, mut list) = (vec![[0.0; 3]; n], Acting::<f64, 3>::room(&acting, n));
        acting.add_forces(Moment { time: 0.0, positions }, &mut list, &mut forces);
        let energy: f64 = acting.energy(Moment { time: 0.0, positions });
        (forces, energy)
    };
    let ((forces, energy), (again, energy_again)) = (at(&places), at(&shifted));
    assert_eq!((bits(&forces), energy.to_bits()), (bits(&again), energy_again.to_bits()));

    // All images of all bodies, by a potential of its own that ends in the same way.
    let from = 0.9 * REACH;
    let pull = |r: f64| {
        let (u, slope) = (LJ.value(r), r * LJ.slope_over_distance(r));
        let (switch, falling) = switch(r, from, REACH);
        if r < REACH { -(slope * switch + u * falling) / r } else { 0.0 }
    };
    for (i, force) in forces.iter().enumerate() {
        let (mut expected, mut sizes) = ([0.0; 3], 0.0);
        for (j, image) in (0..n).flat_map(|j| (0..27).map(move |image| (j, image))).filter(|&(j, _)| j != i) {
            let steps = [image % 3, image / 3 % 3, image / 9].map(|step| f64::from(step) - 1.0);
            let apart: [f64; 3] = from_fn(|d| places[i][d] - places[j][d] - steps[d] * [1.0, 2.0, 1.0][d]);
            let r = apart.iter().map(|x| x * x).sum::<f64>().sqrt();
            expected = from_fn(|d| expected[d] + pull(r) * apart[d]);
            sizes += pull(r).abs() * r;
        }
        let off = (0..3).map(|d| (force[d] - expected[d]).abs()).fold(0.0, f64::max);
        // A pair rounds by some ε, where it is switched off by as many as the switch is steep: 2r/(reach² − from²)
        // times its slope.
        assert!(off <= 1e-14 * sizes && sizes > 0.0, "body {i}: {off:e} of {sizes:e}");
    }
}

/// S and dS/dr.
fn switch(r: f64, from: f64, reach: f64) -> (f64, f64) {
    let width = reach * reach - from * from;
    let x = ((r * r - from * from) / width).max(0.0);
    let falling = -30.0 * x * x * (1.0 - x) * (1.0 - x) * 2.0 * r / width;
    (1.0 - 10.0 * x.powi(3) + 15.0 * x.powi(4) - 6.0 * x.powi(5), falling)
}

/// U and −U′ of two bodies, by the two ways that there are: lists of doubles, and all pairs of any numbers.
fn of_two(within: &Within<Screened>, r: f64) -> (f64, f64) {
    let acting = Effect::<2, BetweenNear>::acting::<f64>(within);
    let (mut forces, mut list) = ([[0.0; 2]; 2], Acting::<f64, 2>::room(&acting, 2));
    let at = Moment { time: 0.0, positions: &[[0.0; 2], [0.0, r]] };
    acting.add_forces(at, &mut list, &mut forces);
    assert_eq!(forces[0][1], -forces[1][1]);

    let fused = Effect::<2, BetweenNear>::acting::<Fused<f64>>(within);
    let mut again = [[Fused(0.0); 2]; 2];
    let positions = [[Fused(0.0); 2], [Fused(0.0), Fused(r)]];
    let mut list = Acting::<Fused<f64>, 2>::room(&fused, 2);
    fused.add_forces(Moment { time: 0.0, positions: &positions }, &mut list, &mut again);
    if InstructionSet::widest().fuses() {
        assert_eq!(again[1][1].0, forces[1][1]);
    }
    (acting.energy(at), forces[1][1])
}

#[test]
fn potentials_end_as_they_say() {
    let (reach, from) = (1.5, 1.0);
    let ends = [
        SCREENED.within(reach).shifted(),
        SCREENED.within(reach).force_shifted(),
        SCREENED.within(reach).switched(from),
        SCREENED.within(reach),
    ];
    let u = |r: f64| SCREENED.value(r);
    let slope = |r: f64| r * SCREENED.slope_over_distance(r);
    let by_hand = |r: f64, from: f64| {
        let (switch, falling) = switch(r, from, reach);
        (u(r) * switch, -(slope(r) * switch + u(r) * falling))
    };
    for r in (1..32).map(|i| 0.05 * f64::from(i)) {
        let expected = [
            (u(r) - u(reach), -slope(r)),
            (u(r) - u(reach) - (r - reach) * slope(reach), -slope(r) + slope(reach)),
            by_hand(r, from),
            by_hand(r, 0.9 * reach),
        ];
        for (end, (energy, force)) in ends.iter().zip(expected) {
            let (energy, force) = if r < reach { (energy, force) } else { (0.0, 0.0) };
            let found = of_two(end, r);
            // Sums of some numbers as large as these, each off by some ε.
            let sizes = (u(r) + u(reach), slope(r).abs() + 20.0 * u(r));
            assert!((found.0 - energy).abs() <= 1e-15 * sizes.0, "{end:?} at {r}: {found:?}, {energy}");
            assert!((found.1 - force).abs() <= 1e-15 * sizes.1, "{end:?} at {r}: {found:?}, {force}");
        }
    }
    // What jumps at the reach, from a small way before it: force and slope of the force.
    let before = |end: &Within<Screened>, by: f64| of_two(end, reach - by);
    let jumps = ends.map(|end| {
        let (force, earlier) = (before(&end, 1e-6).1, before(&end, 2e-6).1);
        [before(&end, 1e-6).0.abs(), force.abs(), (force - earlier).abs() / 1e-6]
    });
    assert!(jumps.iter().all(|[energy, ..]| *energy < 1e-6));
    assert!(jumps[0][1] > 0.01 && jumps[1..].iter().all(|[_, force, _]| *force < 1e-6), "{jumps:?}");
    assert!(jumps[1][2] > 0.01 && jumps[2..].iter().all(|[.., bend]| *bend < 1e-3), "{jumps:?}");
}

/// A potential that ends by itself is not changed by its reach, also where that is the place at which it ends.
#[test]
fn what_ends_by_itself_has_no_switch() {
    let wca = Wca { epsilon: 1.0, sigma: 1.0 };
    for reach in [2.0_f64.powf(1.0 / 6.0), 1.2, 3.0] {
        let scene = Scene::points(2).with(wca.within(reach));
        for r in (1..=30).map(|i| 0.9 + 0.01 * f64::from(i)) {
            let simulation = scene.simulate(State::of([[0.0], [r]]), Rattle::new(1e-3)).unwrap();
            let off = simulation.energy() - wca.value(r);
            assert!(off.abs() <= 1e-15 * (1.0 + wca.value(r)), "reach {reach}, r = {r}: {off:e}");
        }
    }
    let whole = LennardJones { epsilon: 1.0, sigma: 1.0 };
    let scene = Scene::points(2).with(whole.within(2.5));
    let simulation = scene.simulate(State::of([[0.0], [2.4]]), Rattle::new(1e-3)).unwrap();
    assert!((simulation.energy() / whole.value(2.4)) < 0.5, "this one is switched off");
}

#[test]
fn positions_that_are_no_numbers_are_not_lost() {
    let acting = Effect::<3, BetweenNear>::acting::<f64>(&SCREENED.within(REACH));
    let (n, mut random) = (100, random(3));
    let places = vectors::<3>(n, 0.5, &mut random);
    let mut list = Acting::<f64, 3>::room(&acting, n);
    let mut forces = |places: &[[f64; 3]]| {
        let mut forces = vec![[0.0; 3]; n];
        acting.add_forces(Moment { time: 0.0, positions: places }, &mut list, &mut forces);
        forces
    };
    let before = forces(&places);
    for (body, x) in [(0, f64::NAN), (99, f64::INFINITY), (40, f64::NEG_INFINITY)] {
        let mut astray = places.clone();
        astray[body][1] = x;
        assert!(forces(&astray)[body].iter().all(|f| f.is_nan()), "body {body} at {x}");
        assert!(acting.energy(Moment { time: 0.0, positions: &astray }).is_nan() || x.is_infinite());
        assert_eq!(bits(&forces(&places)), bits(&before), "after body {body} at {x}");
    }
}

/// Forces and energies by kinds, each pair with its own strength and reach, against a loop over all pairs.
#[test]
fn kinds_have_potentials_of_their_own() {
    let (n, mut random) = (200, random(4));
    let places = vectors::<3>(n, 0.5, &mut random);
    let of: Vec<usize> = (0..n).map(|i| (i * i + i / 5) % 3).collect();
    let potential =
        |a: usize, b: usize| Screened { strength: 0.1 + (a * b) as f64, length: 0.1 * (1 + a + b) as f64 };
    let reach = |a: usize, b: usize| 0.05 * (2 + a + b) as f64;
    let table = |a, b| potential(a, b).within(reach(a, b)).shifted();

    let near = Kinds::mixed(of.clone(), table);
    let listed = Kinds::new(
        of.clone(),
        [table(0, 0), table(1, 0), table(1, 1), table(2, 0), table(2, 1), table(2, 2)],
    );
    assert!(near == listed);
    let at = Moment { time: 0.0, positions: &places };
    let (mut by_reach, mut by_all) = (vec![[0.0; 3]; n], vec![[0.0; 3]; n]);
    let acting = Effect::<3, BetweenNearKinds>::acting::<f64>(&near);
    acting.add_forces(at, &mut Acting::<f64, 3>::room(&acting, n), &mut by_reach);
    let all = Effect::<3, BetweenKinds>::acting::<f64>(&Kinds::mixed(of.clone(), potential));
    all.add_forces(at, &mut (), &mut by_all);

    let (mut energies, mut off) = ([0.0; 2], 0.0_f64);
    for i in 0..n {
        let (mut expected, mut sizes) = ([[0.0; 3]; 2], [0.0; 2]);
        for j in (0..n).filter(|&j| j != i) {
            let apart: [f64; 3] = from_fn(|d| places[i][d] - places[j][d]);
            let r = apart.iter().map(|x| x * x).sum::<f64>().sqrt();
            let (potential, reach) = (potential(of[i], of[j]), reach(of[i], of[j]));
            let pull = -potential.slope_over_distance(r);
            let pulls = [if r < reach { pull } else { 0.0 }, pull];
            let last = if r < reach { potential.value(r) - potential.value(reach) } else { 0.0 };
            for (k, energy) in [last, potential.value(r)].into_iter().enumerate() {
                energies[k] += 0.5 * energy;
                expected[k] = from_fn(|d| expected[k][d] + pulls[k] * apart[d]);
                sizes[k] += pulls[k].abs() * r;
            }
        }
        for (k, forces) in [&by_reach, &by_all].into_iter().enumerate() {
            let miss = (0..3).map(|d| (forces[i][d] - expected[k][d]).abs()).fold(0.0, f64::max);
            off = off.max(if sizes[k] > 0.0 { miss / sizes[k] } else { miss });
        }
    }
    assert!(off < 1e-14, "{off:e}"); // a pair rounds by some ε, sums of n by √n halves
    let found = [acting.energy(at), all.energy(at)];
    assert!((0..2).all(|k| (found[k] - energies[k]).abs() < 1e-13 * energies[k]), "{found:?} {energies:?}");
    assert!(energies[0] > 1.0 && energies[1] > 2.0 * energies[0]);
}

pair_potential! {
    /// The square of the distance, which then is read off the energy.
    struct Square {}
    |r| r^2
}

#[test]
fn distances_along_a_surface() {
    let r = 1.3;
    let square = Square {}.within(1.0).shifted().along(Sphere { r });
    let acting = Effect::<3, AlongSurface>::acting::<f64>(&square);
    let off = [0.4_f64, 0.2, 0.1].map(|angle| {
        let positions = [[0.0, 0.0, r], [r * angle.sin(), 0.0, r * angle.cos()]];
        let square: f64 = acting.energy(Moment { time: 0.0, positions: &positions }) + 1.0;
        (square - (r * angle).powi(2)).abs() / (angle.powi(6) * r * r / 90.0)
    });
    // d⁶/90 R⁴ and higher terms; of |Δ|² alone it would be 7.5/θ².
    assert!(off.iter().all(|off| (off - 1.0).abs() < 0.05), "{off:?}");

    // On a surface that repeats itself, by a list: forces are the gradient of the energy, and no bit of them is the
    // list's.
    let n = 60;
    let places = vectors::<3>(n, 1.5, &mut random(9));
    let gas = |skin| Square {}.within(REACH).skin(skin).periodic([1.0; 3]).along(GYROID);
    let acting = Effect::<3, AlongSurface>::acting::<f64>(&gas(0.05));
    let forces = |skin| {
        let acting = Effect::<3, AlongSurface>::acting::<f64>(&gas(skin));
        let (mut forces, mut list) = (vec![[-0.0; 3]; n], Acting::<f64, 3>::room(&acting, n));
        acting.add_forces(Moment { time: 0.0, positions: &places }, &mut list, &mut forces);
        forces
    };
    let found = forces(0.05);
    assert_eq!(bits(&found), bits(&forces(0.5)));
    let energy = |body: usize, d: usize, by: f64| -> f64 {
        let mut moved = places.clone();
        moved[body][d] += by;
        acting.energy(Moment { time: 0.0, positions: &moved })
    };
    let mut largest = 0.0_f64;
    for (body, d) in (0..n).flat_map(|body| (0..3).map(move |d| (body, d))) {
        let h = 1e-5;
        let [near, far] = [h, 2.0 * h].map(|h| (energy(body, d, -h) - energy(body, d, h)) / (2.0 * h));
        let expected = near + (near - far) / 3.0; // of fourth order
        largest = largest.max(expected.abs());
        // Energies round by 10 ε of some hundreds, over 10⁻⁵.
        let off = (found[body][d] - expected).abs();
        assert!(off < 1e-7 * (1.0 + expected.abs()), "body {body}: {} for {expected}", found[body][d]);
    }
    assert!(largest > 1.0);
}

/// A Lennard-Jones gas on the gyroid, of unit period.
type Gas = Within<LennardJones, Periodic<3>>;
const GYROID: Gyroid = Gyroid { k: TAU, epsilon: 0.0 };
const ATOMS: usize = 120;

fn atoms() -> Gas {
    LJ.within(0.25).periodic([1.0; 3])
}

fn scene(gas: Gas) -> Scene<Gyroid, impl Effects<3>, Many, 3> {
    Scene::on(GYROID).bodies(ATOMS).with(gas)
}

/// Atoms on the surface, none nearer to another than 0.9 σ, in one period of it or some periods away.
fn start(periods: i32) -> State<3> {
    let (mut random, mut places) = (random(5), Vec::<[f64; 3]>::new());
    while places.len() < ATOMS {
        let mut q = SVector::<f64, 3>::from(from_fn::<f64, 3, _>(|_| random.random_range(0.0..1.0)));
        for _ in 0..20 {
            let (value, jacobian) = GYROID.value_and_jacobian(&q);
            let normal = jacobian.transpose();
            q -= normal * (value[0] / normal.norm_squared());
        }
        let apart =
            |other| Periodic::new([1.0; 3]).apart(&q.into(), other).iter().map(|x| x * x).sum::<f64>();
        if GYROID.value(&q)[0].abs() < 1e-12 && places.iter().all(|other| apart(other) > 0.09 * 0.09) {
            places.push(q.into());
        }
    }
    let momenta = vectors::<3>(ATOMS, 1.0, &mut random);
    let places =
        places.iter().zip(0..).map(|(q, i)| from_fn::<_, 3, _>(|d| q[d] + f64::from(periods * (i % 3))));
    scene(atoms()).project(&State::of(places).with_momenta(momenta)).unwrap()
}

fn bits_of<const D: usize>(vectors: impl Iterator<Item = SVector<f64, D>>) -> Vec<u64> {
    vectors.flat_map(|q| <[f64; D]>::from(q).map(f64::to_bits)).collect()
}

#[test]
#[cfg(long)]
fn a_gas_on_a_surface_that_repeats_itself() {
    // Second order, with the switch that is usual.
    let errors = [2e-4, 1e-4, 5e-5].map(|h| {
        let mut simulation = scene(atoms()).simulate(start(0), Rattle::new(h)).unwrap();
        let mut energy = 0.0_f64;
        for _ in 0..(0.1 / h) as u64 {
            simulation.run(1).unwrap();
            energy = energy.max(simulation.energy_error().abs());
        }
        energy / simulation.energy().abs()
    });
    println!("energy errors {errors:?}");
    let order = (errors[0] / errors[2]).log2() / 2.0;
    assert!((1.8..2.2).contains(&order) && errors[0] > 1e-7, "order {order}, {errors:?}");

    // The skin decides nothing, nor where a list was made: restarts and clones go on to the bit.
    let run = |skin, steps| {
        let mut simulation = scene(atoms().skin(skin)).simulate(start(0), Rattle::new(1e-3)).unwrap();
        simulation.run(steps).unwrap();
        simulation
    };
    let mut usual = run(0.05, 300);
    for skin in [0.0, 0.01, 0.3] {
        let other = run(skin, 300);
        assert_eq!(bits_of(usual.positions()), bits_of(other.positions()), "skin {skin}");
        assert_eq!(bits_of(usual.momenta()), bits_of(other.momenta()), "skin {skin}");
    }
    let mut fresh = scene(atoms()).simulate(start(0), Rattle::new(1e-3)).unwrap();
    let allocated = allocation_counter::measure(|| fresh.run(300).unwrap());
    assert_eq!(allocated.count_total, 0, "from the first step on");
    let mut again = scene(atoms()).simulate(usual.state(), Rattle::new(1e-3)).unwrap();
    let mut cloned = usual.clone();
    let allocated = allocation_counter::measure(|| usual.run(200).unwrap());
    assert_eq!(allocated.count_total, 0);
    again.run(200).unwrap();
    cloned.run(200).unwrap();
    assert_eq!(bits_of(again.positions()), bits_of(usual.positions()));
    assert_eq!(bits_of(cloned.positions()), bits_of(usual.positions()));

    // Eight periods away coordinates are off by 4 ε, and k is 2π but for rounding; what a force is off by is the slope
    // of the force, 10⁴, times that. In this time, a fifth of that between two atoms that touch, it makes places be off
    // by no more.
    let mut elsewhere = scene(atoms()).simulate(start(4), Rattle::new(1e-4)).unwrap();
    let mut here = scene(atoms()).simulate(start(0), Rattle::new(1e-4)).unwrap();
    elsewhere.run(200).unwrap();
    here.run(200).unwrap();
    let moved = |i: usize, d: usize| elsewhere.positions().nth(i).unwrap()[d] - f64::from(4 * (i as i32 % 3));
    let off = here
        .positions()
        .enumerate()
        .map(|(i, q)| (0..3).map(|d| (q[d] - moved(i, d)).abs()).fold(0.0, f64::max));
    let off = off.fold(0.0, f64::max);
    println!("four and eight periods away: off by {off:e}");
    assert!(off < 2e-14, "{off:e}");
}

/// What each ending does to the energy in 10⁵ steps: `cargo long --test motion near_pairs:: -- --ignored --nocapture`.
#[test]
#[cfg(long)]
#[ignore = "a measurement of half a minute"]
fn drift_of_each_ending() {
    let ends: [(&str, Gas); 5] = [
        ("shifted", atoms().shifted()),
        ("force_shifted", atoms().force_shifted()),
        ("switched from 0.95", atoms().switched(0.95 * 0.25)),
        ("switched from 0.9", atoms()),
        ("switched from 0.7", atoms().switched(0.7 * 0.25)),
    ];
    println!("ending                    h   swing   energy off after 25 000, 50 000, 75 000, 100 000 steps");
    for h in [5e-4, 2.5e-4] {
        for (name, gas) in ends {
            let mut simulation = scene(gas).simulate(start(0), Rattle::new(h)).unwrap();
            let mut means = [0.0; 4];
            let mut swing = 0.0_f64;
            for mean in &mut means {
                let mut last = [0.0; 2];
                simulation.run(20_000).unwrap();
                for _ in 0..5_000 {
                    simulation.run(1).unwrap();
                    let off = simulation.energy_error();
                    last = [last[0] + off / 5_000.0, last[1] + off * off / 5_000.0];
                }
                *mean = last[0];
                swing = swing.max((last[1] - last[0] * last[0]).sqrt());
            }
            let kinetic = simulation.momenta().map(|p| 0.5 * p.norm_squared()).sum::<f64>();
            let means = means.map(|mean| format!("{mean:9.2e}")).join("  ");
            println!("{name:20} {h:7.1e} {swing:9.2e} {means}   of kinetic energy {kinetic:.1}");
        }
    }
}

#[test]
fn what_makes_no_sense_is_refused_before_the_run() {
    let lj = LennardJones { epsilon: 1.0, sigma: 1.0 };
    let (within, infinity) = (|reach| lj.within(reach), f64::INFINITY);
    let alone = |effect: Within<LennardJones>| Effect::<3, BetweenNear>::check(&effect, "Atoms", 3);
    let boxed = |reach: f64, periods| {
        Effect::<3, BetweenNear>::check(&lj.within(reach).periodic(periods), "Atoms", 3)
    };
    let kinds = |of: &[usize], size: usize| {
        Effect::<3, BetweenKinds>::check(&Kinds::new(of.to_vec(), vec![lj; size]), "Atoms", 3)
    };
    let said = |result: Result<(), Error>| match result {
        Err(Error::Pairs(mistake)) => mistake.to_string(),
        other => panic!("{other:?}"),
    };
    let reach = "and must be positive, with a square that is neither 0 nor infinite";
    for (result, text) in [
        (alone(within(0.0)), format!("the reach of Atoms is 0, {reach}")),
        (alone(within(-1.0)), format!("the reach of Atoms is -1, {reach}")),
        (alone(within(f64::NAN)), format!("the reach of Atoms is NaN, {reach}")),
        (alone(within(infinity)), format!("the reach of Atoms is inf, {reach}")),
        (alone(within(1e-200)), "the reach of Atoms is 1e-200".into()),
        (alone(within(1e-30).shifted()), "Atoms is inf at its reach 1e-30".into()),
        (alone(within(2.5).switched(2.5)), "Atoms is switched off from 2.5 on".into()),
        (alone(within(2.5).switched(-0.1)), "Atoms is switched off from -0.1 on".into()),
        (alone(within(2.5).switched(f64::NAN)), "Atoms is switched off from NaN on".into()),
        (alone(within(2.5).skin(-0.1)), "the skin of Atoms is -0.1".into()),
        (alone(within(2.5).skin(f64::NAN)), "the skin of Atoms is NaN".into()),
        (alone(within(2.5).skin(infinity)), "the skin of Atoms is inf".into()),
        (boxed(2.5, [5.0, 4.9, 5.0]), "repeats itself after 4.9 along coordinate 1".into()),
        (boxed(2.5, [5.0, 5.0, f64::NAN]), "repeats itself after NaN along coordinate 2".into()),
        (boxed(2.5, [-5.0, 5.0, 5.0]), "repeats itself after -5 along coordinate 0".into()),
        (kinds(&[0, 1, 0], 2), "1, 3, 6, 10, …; found 2".into()),
        (kinds(&[0, 0, 0], 0), "1, 3, 6, 10, …; found 0".into()),
        (kinds(&[0, 2, 0], 3), "body 1 is of kind 2, and the table is of 2 kinds".into()),
        (kinds(&[0, 1], 3), "2 kinds were given for 3 bodies".into()),
    ] {
        let said = said(result);
        assert!(said.contains(&text), "{said}\n{text}");
    }
    alone(within(2.5).skin(0.0)).unwrap();
    boxed(2.5, [5.0, infinity, 5.0]).unwrap();
    kinds(&[0, 1, 1], 3).unwrap();
    let mut two = Kinds::new([0, 0, 0], [lj.within(1.0).periodic([9.0; 3])]);
    Effect::<3, BetweenNearKinds>::check(&two, "Atoms", 3).unwrap();
    two = Kinds::new([0, 1, 0], [9.0, 9.0, 8.0].map(|period| lj.within(1.0).periodic([period; 3])));
    let mistake = Effect::<3, BetweenNearKinds>::check(&two, "Atoms", 3).unwrap_err();
    assert!(matches!(mistake, Error::Pairs(PairMistake::Boxes { what: "Atoms" })), "{mistake}");

    // A scene asks, and names the potential.
    let error =
        scene(LennardJones { epsilon: 1.0, sigma: 1.0 }.within(0.6).periodic([1.0; 3])).project(&start(0));
    assert!(error.unwrap_err().to_string().starts_with("LennardJones reaches as far as 0.6, and its box"));
}
