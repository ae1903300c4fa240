//! Components that are alike go side by side: each as it would alone but for rounding, and whoever is beside it.

use crate::common::{PlanarGravity, Trough};
use rattle::bodies::Count;
use rattle::checkpoint::Save;
use rattle::composition::KAHAN_LI_1997_ORDER_8;
use rattle::effect::Effects;
use rattle::ensemble::InstructionSet;
use rattle::links::Rod;
use rattle::links::planar::Rod as PlanarRod;
use rattle::method::Method;
use rattle::nalgebra::SVector;
use rattle::prelude::*;
use rattle::scene::Hold;
use rattle::system::System;
use std::array::from_fn;

constraint! {
    /// Two equations: the second body is at unit distance, and in a plane that turns with the first.
    struct Hinge { pitch }
    |a: [f64; 3], b: [f64; 3]| [dot(b - a, b - a) - 1, b[2] - a[2] - pitch * sin(a[0])]
}

constraint! {
    /// A ring that a bead is on.
    struct Ring { radius }
    |x, y| x^2 + y^2 - radius^2
}

constraint! {
    /// Distance 1, or 1 + πj/k.
    struct Shells { k }
    |a: [f64; 3], b: [f64; 3]| sin(k * (norm(b - a) - 1))
}

/// How molecules of N bodies are tied, and where the bodies of the m-th one are.
struct Molecules<B, const N: usize, const D: usize> {
    tied: B,
    places: fn(u32) -> [[f64; D]; N],
}

impl<B, C: Hold<D>, E: Effects<D>, A: Count, const N: usize, const D: usize> Molecules<B, N, D>
where
    B: Fn(Vec<[usize; N]>, Vec<f64>) -> Scene<C, E, A, D>,
{
    /// Some molecules and their start. Bodies of one follow each other, or those of the same place in all of them.
    fn of(&self, molecules: &[u32], follow: bool) -> (Scene<C, E, A, D>, State<D>) {
        let n = molecules.len();
        let number = |m: usize, b: usize| if follow { m * N + b } else { b * n + m };
        let bodies = (0..n).map(|m| from_fn(|b| number(m, b)));
        let (mut masses, mut places) = (vec![0.0; n * N], vec![[0.0; D]; n * N]);
        let mut momenta = places.clone();
        for (m, &molecule) in molecules.iter().enumerate() {
            for (b, place) in (self.places)(molecule).into_iter().enumerate() {
                let i = number(m, b);
                masses[i] = 1.0 + 0.01 * f64::from(molecule) + 0.3 * b as f64;
                places[i] = place;
                momenta[i] = from_fn(|d| (1.7 * f64::from(molecule) + (b * D + d) as f64).sin());
            }
        }
        let scene = (self.tied)(bodies.collect(), masses);
        let start = scene.project(&State::of(places).with_momenta(momenta)).unwrap();
        (scene, start)
    }

    /// How far molecules are off where each would be alone.
    fn off(&self, molecules: &[u32], follow: bool, method: &impl Method, steps: u64) -> f64 {
        let (scene, start) = self.of(molecules, follow);
        let mut all = scene.simulate(start, method.clone()).unwrap();
        all.run(steps).unwrap();
        let (q, p): (Vec<_>, Vec<_>) = (all.positions().collect(), all.momenta().collect());
        let mut off = 0.0_f64;
        for (m, &molecule) in molecules.iter().enumerate() {
            let (scene, start) = self.of(&[molecule], true);
            let mut alone = scene.simulate(start, method.clone()).unwrap();
            alone.run(steps).unwrap();
            for (b, (own_q, own_p)) in alone.positions().zip(alone.momenta()).enumerate() {
                let i = if follow { m * N + b } else { b * molecules.len() + m };
                off = off.max((q[i] - own_q).norm()).max((p[i] - own_p).norm());
            }
        }
        off
    }
}

/// Whether all is rounding, and something is: who goes alone is off by nothing.
fn check(off: f64) {
    let fused = InstructionSet::widest().fuses(); // else all go alone, and nothing differs
    assert!(off < 4e-13 && (off > 0.0) == fused, "{off:e}");
}

/// In rows that are full, and that are not; after 50 steps.
fn agree<B, C: Hold<D>, E: Effects<D>, A: Count, const N: usize, const D: usize>(
    molecules: &Molecules<B, N, D>,
) where
    B: Fn(Vec<[usize; N]>, Vec<f64>) -> Scene<C, E, A, D>,
{
    for n in [24, 63, 64, 130] {
        let all: Vec<u32> = (0..n).collect();
        check(molecules.off(&all, n % 2 == 0, &Rattle::new(0.01), 50));
    }
    let few: Vec<u32> = (0..23).collect();
    assert_eq!(molecules.off(&few, true, &Rattle::new(0.01), 50), 0.0, "so few go alone");
}

fn dumbbell(m: u32) -> [[f64; 3]; 2] {
    let angle = 0.1 * f64::from(m);
    [[3.0, 0.0, angle], [3.0 + angle.sin(), angle.cos(), angle]]
}

fn dumbbells(
    bodies: Vec<[usize; 2]>,
    masses: Vec<f64>,
) -> Scene<impl Hold<3>, impl Effects<3>, impl Count, 3> {
    Scene::points(masses.len()).link(Rod { length: 1.0 }, bodies).masses(masses).with(Trough { g: 0.5 })
}

/// Three bodies, each tied to the others.
fn triangle(m: u32) -> [[f64; 3]; 3] {
    let (angle, x) = (0.1 * f64::from(m), 0.01 * f64::from(m));
    let (sine, cosine) = angle.sin_cos();
    [[x, 0.0, 0.0], [x + 0.8 * cosine, 0.6, 0.8 * sine], [x - 0.8 * cosine, 0.6, -0.8 * sine]]
}

fn triangles(
    bodies: Vec<[usize; 3]>,
    masses: Vec<f64>,
) -> Scene<impl Hold<3>, impl Effects<3>, impl Count, 3> {
    let legs: Vec<_> = bodies.iter().flat_map(|&[a, b, c]| [[a, b], [a, c]]).collect();
    Scene::points(masses.len())
        .link(Rod { length: 1.0 }, legs)
        .link(Rod { length: 1.6 }, bodies.iter().map(|&[_, b, c]| [b, c]))
        .masses(masses)
        .with(Trough { g: 0.5 })
}

#[test]
fn dumbbells_go_as_each_alone() {
    agree(&Molecules { tied: dumbbells, places: dumbbell });
}

#[test]
fn triangles_go_as_each_alone() {
    agree(&Molecules { tied: triangles, places: triangle });
}

fn hinges(bodies: Vec<[usize; 2]>, masses: Vec<f64>) -> Scene<impl Hold<3>, impl Effects<3>, impl Count, 3> {
    Scene::points(masses.len()).link(Hinge { pitch: 0.3 }, bodies).masses(masses).with(Trough { g: 0.5 })
}

fn hinge(m: u32) -> [[f64; 3]; 2] {
    let angle = 0.1 * f64::from(m);
    let rise = 0.3 * angle.sin();
    let reach = (1.0 - rise * rise).sqrt();
    [[angle, 0.0, 0.0], [angle + reach * angle.cos(), reach * angle.sin(), rise]]
}

#[test]
fn hinges_go_as_each_alone() {
    agree(&Molecules { tied: hinges, places: hinge });
}

#[test]
fn those_in_the_plane_go_as_each_alone() {
    let dumbbells = |bodies: Vec<[usize; 2]>, masses: Vec<f64>| {
        Scene::points(masses.len())
            .link(PlanarRod { length: 1.0 }, bodies)
            .masses(masses)
            .with(PlanarGravity { g: 1.0 })
    };
    agree(&Molecules {
        tied: dumbbells,
        places: |m| {
            let (sine, cosine) = (0.1 * f64::from(m)).sin_cos();
            [[1.0, 0.0], [1.0 + cosine, sine]]
        },
    });
    let triangles = |bodies: Vec<[usize; 3]>, masses: Vec<f64>| {
        let sides: Vec<_> = bodies.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        Scene::points(masses.len()).link(PlanarRod { length: 1.0 }, sides).masses(masses)
    };
    agree(&Molecules {
        tied: triangles,
        places: |m| {
            from_fn(|b| {
                let angle = 0.1 * f64::from(m) + std::f64::consts::TAU / 3.0 * b as f64;
                [angle.cos() / 3_f64.sqrt(), angle.sin() / 3_f64.sqrt()]
            })
        },
    });
    let beads = |bodies: Vec<[usize; 1]>, masses: Vec<f64>| {
        Scene::points(masses.len())
            .link(Ring { radius: 2.0 }, bodies)
            .masses(masses)
            .with(PlanarGravity { g: 1.0 })
    };
    agree(&Molecules {
        tied: beads,
        places: |m| {
            let (sine, cosine) = (0.1 * f64::from(m)).sin_cos();
            [[2.0 * cosine, 2.0 * sine]]
        },
    });
}

/// All methods: those that split go in rows, others settle in them or do not, and none is astray because some do.
#[test]
fn methods() {
    let (molecules, all) = (Molecules { tied: triangles, places: triangle }, (0..30).collect::<Vec<_>>());
    check(molecules.off(&all, true, &PositionVerlet::new(0.01), 50));
    check(molecules.off(&all, true, &SymplecticEuler::new(-0.01), 50));
    check(molecules.off(&all, true, &Geodesic::new(2, 0.02), 25));
    check(molecules.off(&all, true, &Shake::new(0.01), 20));
    check(molecules.off(&all, true, &Composition::new(KAHAN_LI_1997_ORDER_8, 0.1), 5));
    // Their stages end, and their steps are as long, as the worst component asks for.
    assert!(molecules.off(&all, true, &Lobatto::<3>::new(0.02), 10) < 1e-14);
    check(molecules.off(&all, true, &Rattle::new(0.01).guess(Extrapolated), 20)); // the first steps in rows
    check(molecules.off(&all, true, &Rattle::new(0.01).solved_by(Broyden), 20)); // momenta are settled in rows
    check(molecules.off(&all, true, &Taylor::new(12, 0.05), 5));
    assert!(molecules.off(&all, true, &Dop853::new(0.02), 5) < 1e-14);
}

/// Molecules that differ in what ties them, and bodies that nothing ties, each as it would alone.
#[test]
fn mixtures() {
    let n = 40;
    let scene = Scene::points(5 * n + 3)
        .link(
            Rod { length: 1.0 },
            (0..n).flat_map(|i| [[5 * i, 5 * i + 1], [5 * i + 2, 5 * i + 3], [5 * i + 3, 5 * i + 4]]),
        )
        .link(Rod { length: 1.6 }, (0..n).map(|i| [5 * i + 2, 5 * i + 4]))
        .link(Rod { length: 0.5 }, [[5 * n, 5 * n + 1]]);
    let places = (0..n).flat_map(|i| {
        let at = 10.0 * i as f64;
        [[at, 0.0, 0.0], [at, 1.0, 0.0], [at + 3.8, 0.6, 0.0], [at + 3.0, 0.0, 0.0], [at + 2.2, 0.6, 0.0]]
    });
    let places = places.chain([[0.0, 0.0, 5.0], [0.5, 0.0, 5.0], [0.0, 0.0, 7.0]]);
    let momenta = (0..5 * n + 3).map(|i| from_fn(|d| ((3 * i + d) as f64).sin()));
    let start = scene.project(&State::of(places).with_momenta(momenta)).unwrap();
    let mut simulation = scene.simulate(start.clone(), Rattle::new(0.01)).unwrap();
    simulation.run(200).unwrap();
    let q: Vec<_> = simulation.positions().collect();
    let long = |a: usize, b: usize, length: f64| ((q[a] - q[b]).norm() - length).abs() / f64::EPSILON;
    for i in (0..5 * n).step_by(5) {
        // Rounding of coordinates up to 400.
        assert!(
            long(i, i + 1, 1.0) < 1000.0
                && long(i + 2, i + 3, 1.0) < 1000.0
                && long(i + 2, i + 4, 1.6) < 1000.0
        );
    }
    // Without forces the free one goes straight, and momenta stay together.
    let last = start.positions().last().unwrap() + 2.0 * start.momenta().last().unwrap();
    assert!((q[5 * n + 2] - last).norm() < 1e-13);
    let total = |momenta: Vec<SVector<f64, 3>>| momenta.iter().sum::<SVector<f64, 3>>();
    assert!((total(simulation.momenta().collect()) - total(start.momenta().collect())).norm() < 1e-12);
}

/// Lengths, and that they do not change, hold to roundings of the coordinates, also in long steps.
#[test]
fn lengths_hold_to_roundings() {
    let n = 64;
    let places = (0..n).flat_map(|i| {
        let (sine, cosine) = (0.1 * i as f64).sin_cos();
        [[0.5 * sine, 0.5 * cosine, 0.0], [-0.5 * sine, -0.5 * cosine, 0.0]]
    });
    let momenta = (1..=n).flat_map(|i| {
        let p = [0.3, 1.7, 2.9].map(|speed| (speed * i as f64).sin());
        [p, p.map(|p| -p)]
    });
    let scene = Scene::points(2 * n).link(Rod { length: 1.0 }, (0..n).map(|i| [2 * i, 2 * i + 1]));
    let start = scene.project(&State::of(places).with_momenta(momenta)).unwrap();
    let (mut off, mut rate) = (0.0_f64, 0.0_f64);
    for h in [0.01, 0.03, 0.1] {
        let mut simulation = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
        for _ in 0..100 {
            simulation.run(1).unwrap();
            let (q, p): (Vec<_>, Vec<_>) = (simulation.positions().collect(), simulation.momenta().collect());
            for (q, p) in q.chunks(2).zip(p.chunks(2)) {
                let (rod, v) = (q[1] - q[0], p[1] - p[0]);
                off = off.max((rod.norm() - 1.0).abs());
                rate = rate.max(rod.dot(&v).abs() / v.norm());
            }
        }
    }
    println!("lengths off by {:.2} ε, rates by {:.2} ε", off / f64::EPSILON, rate / f64::EPSILON);
    assert!(off <= 3.0 * f64::EPSILON && rate <= 3.0 * f64::EPSILON, "{off:e}, {rate:e}");
}

/// Bits of positions and momenta of a molecule of three.
fn bits(simulation: &Simulation<impl System<f64, 3>, impl Method, 3>, molecule: usize) -> Vec<u64> {
    let bodies = 3 * molecule..3 * molecule + 3;
    let vectors = simulation.positions().zip(simulation.momenta()).skip(bodies.start).take(3);
    vectors
        .flat_map(|(q, p)| [q, p])
        .flat_map(|x| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>())
        .collect()
}

/// One of them turns so fast that it has to be moved alone: its neighbours move as if it did not, bit for bit.
#[test]
fn no_molecule_minds_its_neighbours() {
    let (molecules, all) = (Molecules { tied: triangles, places: triangle }, (0..70).collect::<Vec<_>>());
    let (scene, start) = molecules.of(&all, true);
    let momenta: Vec<_> = start.momenta().collect();
    let faster = momenta.iter().enumerate().map(|(i, p)| if (15..18).contains(&i) { 30.0 * p } else { *p });
    let fast = State::of(start.positions()).with_momenta(faster);
    let mut wild = scene.simulate(fast, Rattle::new(0.01)).unwrap();
    let same = State::of(start.positions()).with_momenta(momenta);
    let mut calm = scene.simulate(same, Rattle::new(0.01)).unwrap();
    calm.run(100).unwrap();
    wild.run(100).unwrap();
    for molecule in (0..70).filter(|&molecule| molecule != 5) {
        assert_eq!(bits(&calm, molecule), bits(&wild, molecule), "molecule {molecule}");
    }
    assert_ne!(bits(&calm, 5), bits(&wild, 5));
}

/// Looking changes nothing, and what is seen is that of each alone.
#[test]
fn readings() {
    let (molecules, all) = (Molecules { tied: triangles, places: triangle }, (0..30).collect::<Vec<_>>());
    let (scene, start) = molecules.of(&all, true);
    let mut looked_at = scene.simulate(start.clone(), Rattle::new(0.01)).unwrap();
    let mut left_alone = scene.simulate(start, Rattle::new(0.01)).unwrap();
    for _ in 0..10 {
        looked_at.run(3).unwrap();
        let _ = (looked_at.multipliers(), looked_at.constraint_forces(), looked_at.temperature());
    }
    left_alone.run(30).unwrap();
    for molecule in 0..30 {
        assert_eq!(bits(&looked_at, molecule), bits(&left_alone, molecule));
    }
    let (forces, residuals) = (left_alone.constraint_forces(), left_alone.residuals());
    let (legs, off) = (60, |a: f64, b: f64| (a - b).abs());
    for &molecule in &all {
        let (scene, start) = molecules.of(&[molecule], true);
        let mut alone = scene.simulate(start, Rattle::new(0.01)).unwrap();
        alone.run(30).unwrap();
        let m = molecule as usize;
        for (b, force) in alone.constraint_forces().iter().enumerate() {
            assert!((forces[3 * m + b] - force).norm() < 1e-12);
        }
        for (i, g) in [2 * m, 2 * m + 1, legs + m].into_iter().zip(alone.residuals()) {
            assert!(off(residuals[i], g) < 4e-15);
        }
    }
}

/// A run that is taken up from a checkpoint goes on to the last bit, also where some turn too fast for a row, and where
/// a method leaves the rows after a few steps.
#[test]
fn checkpoints() {
    check_checkpoint(PositionVerlet::new(0.02), 50);
    check_checkpoint(Rattle::new(0.01), 20);
    check_checkpoint(Rattle::new(0.01).guess(Extrapolated), 2);
    check_checkpoint(Rattle::new(0.01).solved_by(Broyden), 5);
    check_checkpoint(Bdf2::new(0.01), 1);
    check_checkpoint(Lobatto::<3>::new(0.02), 3);
}

fn check_checkpoint(method: impl Method, steps: u64) {
    let (molecules, all) = (Molecules { tied: hinges, places: hinge }, (0..70).collect::<Vec<_>>());
    let (scene, start) = molecules.of(&all, false);
    let path = std::env::temp_dir().join(format!("rattle-molecules-{}", std::process::id()));
    let momenta = start.momenta().enumerate().map(|(i, p)| if i % 9 == 0 { 5.0 * p } else { p });
    let start = scene.project(&State::of(start.positions()).with_momenta(momenta)).unwrap();
    let mut whole = scene.simulate(start.clone(), method.clone()).unwrap();
    whole.run(steps).unwrap();
    whole.save(&path).unwrap();
    let mut taken_up = scene.simulate(start, method).unwrap();
    taken_up.restore(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    assert_eq!(whole.constraint_forces(), taken_up.constraint_forces());
    whole.run(20).unwrap();
    taken_up.run(20).unwrap();
    assert_eq!(format!("{:?}", whole.state()), format!("{:?}", taken_up.state()));
}

/// Those with parameters of their own are not alike.
#[test]
fn each_with_its_own_length() {
    let tied = |bodies: Vec<[usize; 2]>, masses: Vec<f64>| {
        let rods = masses.chunks(2).map(|m| Rod { length: 0.5 + 0.1 * m[0] });
        Scene::points(masses.len()).link_each(rods.zip(bodies)).masses(masses.clone())
    };
    let molecules = Molecules { tied, places: dumbbell };
    assert_eq!(molecules.off(&(0..30).collect::<Vec<_>>(), true, &Rattle::new(0.01), 20), 0.0);
}

/// Momenta that lead off the constraints alone come to rest.
#[test]
fn what_is_pushed_along_its_rod_comes_to_rest() {
    let scene = Scene::points(2).link(Rod { length: 1.0 }, [[0, 1]]);
    let along = [0.6, 0.64, 0.48];
    let state = State::of([[0.0; 3], along]).with_momenta([along.map(|x| -0.1 * x), along.map(|x| 0.1 * x)]);
    let start = scene.project(&state).unwrap();
    assert!(start.momenta().all(|p| p.norm() == 0.0));
    let mut simulation = scene.simulate(start.clone(), Rattle::new(0.1)).unwrap();
    simulation.run(10).unwrap();
    assert!(simulation.positions().eq(start.positions()));
}

/// Back where it came from, but for rounding.
#[test]
fn steps_are_reversible() {
    let (molecules, all) = (Molecules { tied: triangles, places: triangle }, (0..70).collect::<Vec<_>>());
    let (scene, start) = molecules.of(&all, true);
    let mut there = scene.simulate(start.clone(), Rattle::new(0.02)).unwrap();
    there.run(100).unwrap();
    let mut back = scene.simulate(there.state(), Rattle::new(-0.02)).unwrap();
    back.run(100).unwrap();
    let off = back.positions().zip(start.positions()).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    assert!(off < 1e-12, "{off:e}");
}

/// Shells that lie close: each ends on its own, or is refused. All molecules of a scene are in the same state, since
/// one that is refused ends the run for all.
#[test]
fn none_jumps_to_another_shell() {
    let n = 24;
    let (mut steps, mut refused) = (0, 0);
    for number in 0..100_u32 {
        let (k, h) = (1e3 * 1.1_f64.powi(number as i32), 0.01 * f64::from(1 + number % 6));
        let scene = Scene::points(2 * n)
            .link(Shells { k }, (0..n).map(|i| [2 * i, 2 * i + 1]))
            .masses((0..2 * n).map(|i| if i % 2 == 0 { 1.0 } else { 0.2 })) // one falls faster
            .with(Trough { g: 0.5 });
        let places = (0..n).flat_map(|_| dumbbell(number));
        let momenta = (0..2 * n).map(|i| from_fn(|d| 0.2 * ((3 * (i % 2) + d) as f64).sin()));
        let start = scene.project(&State::of(places).with_momenta(momenta)).unwrap();
        let mut simulation = scene.simulate(start, Rattle::new(h)).unwrap();
        for _ in 0..20 {
            if simulation.run(1).is_err() {
                refused += 1;
                break;
            }
            steps += 1;
            let q: Vec<_> = simulation.positions().collect();
            let off = q.chunks(2).map(|q| ((q[0] - q[1]).norm() - 1.0).abs()).fold(0.0, f64::max);
            assert!(off < 1e-12, "k = {k}, h = {h}: off by {off:e}");
        }
    }
    println!("{steps} steps, {refused} runs refused");
    assert!(steps > 500 && refused > 10);
}
