//! Sheets that lie side by side in phase space: each step stays on its own, or is refused.

use crate::common::outcome::Outcome;
use crate::phase_space::{Charge, Falling, Uneven3, point};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::bodies::One;
use rattle::composition::SUZUKI_1990_ORDER_4;
use rattle::phase::PhaseSpace;
use rattle::prelude::*;
use rayon::prelude::*;

phase_constraint! {
    /// Three-spheres at distances of π/k in the sum of squares.
    pub(crate) struct Shells { k }
    |q: [f64; 2], p: [f64; 2]| sin(k * (dot(q, q) + dot(p, p) - 1))
}
phase_constraint! {
    /// The same of a sheet whose fibres have no formula.
    pub(crate) struct WavyShells { k }
    |q: [f64; 2], p: [f64; 2]| sin(k * (q[0]^2 + q[1]^4 + exp(p[0]) + p[1]^2 * (2 + sin(q[0])) - 3))
}
phase_constraint! {
    /// Three of them, this far apart.
    pub(crate) struct Three { apart }
    |q: [f64; 2], p: [f64; 2]| {
        let g = dot(q, q) + dot(p, p) - 1;
        g * (g - apart) * (g + apart)
    }
}
phase_constraint! {
    /// Circles at distances of π/k: of positions alone.
    pub(crate) struct Rings { k }
    |q: [f64; 2], _p: [f64; 2]| sin(k * (norm(q) - 1))
}
phase_constraint! {
    struct Line {}
    |q: [f64; 2], _p: [f64; 2]| q[1]
}
phase_constraint! {
    struct Ring {}
    |q: [f64; 2], _p: [f64; 2]| dot(q, q) - 1
}
phase_constraint! {
    /// Spheres as above, each with an angular momentum, of which there are many too.
    pub(crate) struct TurningShells { k, l }
    |q: [f64; 3], p: [f64; 3]| [
        sin(k * (dot(q, q) + dot(p, p) - 1)),
        sin(2 * k * (q[0] * p[1] - q[1] * p[0] - l)),
    ]
}
pub(crate) fn sum_of_squares<const D: usize>([q, p]: [[f64; D]; 2]) -> f64 {
    q.iter().chain(&p).map(|x| x * x).sum()
}
pub(crate) fn wavy([q, p]: [[f64; 2]; 2]) -> f64 {
    q[0].powi(2) + q[1].powi(4) + p[0].exp() + p[1].powi(2) * (2.0 + q[0].sin())
}
pub(crate) fn radius([q, _]: [[f64; 2]; 2]) -> f64 {
    q[0].hypot(q[1])
}
pub(crate) fn momentum([q, p]: [[f64; 3]; 2]) -> f64 {
    q[0] * p[1] - q[1] * p[0]
}

/// A function of position and momentum.
pub(crate) type Level<const D: usize> = fn([[f64; D]; 2]) -> f64;

/// Random starts and steps; `levels` are functions that no motion changes by as much as sheets are apart, which is more
/// than 0.3/k.
fn stays<G, H, S, const D: usize, const M: usize>(
    seed: u64,
    number: u32,
    scene: impl Fn(f64) -> Scene<PhaseSpace<G, H, M>, (), One, D>,
    levels: &[Level<D>],
    method: impl Fn(f64) -> S,
) -> Outcome
where
    PhaseSpace<G, H, M>: rattle::scene::Hold<D>,
    S: Method,
{
    let mut random = StdRng::seed_from_u64(seed);
    let mut outcome = Outcome::default();
    while outcome.right + outcome.refused + outcome.wrong < number {
        let k = 10_f64.powf(random.random_range(0.5..4.5));
        let h = 10_f64.powf(random.random_range(-2.5..-0.3));
        let scene = scene(k);
        let [q, p] = [0, 1].map(|_| std::array::from_fn::<f64, D, _>(|_| random.random_range(-0.9..0.9)));
        let Ok(start) = scene.project(&State::at(q).moving(p)) else { continue };
        let Ok(simulation) = scene.simulate(start, method(h)) else { continue };
        let first: Vec<_> = levels.iter().map(|level| level(point(&simulation))).collect();
        let off = |now: &Simulation<_, S, D>| {
            let offs = levels.iter().zip(&first).map(|(level, first)| (level(point(now)) - first).abs());
            offs.fold(0.0, |most, off| if off <= most { most } else { off })
        };
        outcome.watch(format_args!("seed {seed}, k = {k:e}, h = {h}"), simulation, 40, off, 0.3 / k);
    }
    println!("seed {seed}: {outcome:?}");
    outcome
}

fn families(seed: u64, number: u32) -> [Outcome; 7] {
    let suzuki = |h| Composition::new(SUZUKI_1990_ORDER_4, h);
    let (falling, charge, uneven) = (Falling { g: 0.3 }, Charge { b: 0.4, g: 0.3 }, Uneven3 { g: 0.3 });
    let shells = |k| Scene::in_phase_space(Shells { k }, falling);
    let charged = |k| Scene::in_phase_space(Shells { k }, charge);
    let wavy_shells = |k| Scene::in_phase_space(WavyShells { k }, falling);
    let three = |k| Scene::in_phase_space(Three { apart: 1.0 / k }, falling);
    let rings = |k| Scene::in_phase_space(Rings { k }, falling);
    let turning = |k| Scene::in_phase_space(TurningShells { k, l: 0.2 }, uneven);
    [
        stays(seed, number, shells, &[sum_of_squares], Rattle::new),
        stays(seed + 1, number, charged, &[sum_of_squares], Rattle::new),
        stays(seed + 2, number, wavy_shells, &[wavy], Rattle::new),
        stays(seed + 3, number, three, &[sum_of_squares], Rattle::new),
        stays(seed + 4, number, rings, &[radius], Rattle::new),
        stays(seed + 5, number, turning, &[sum_of_squares, momentum], Rattle::new),
        stays(seed + 6, number, shells, &[sum_of_squares], suzuki),
    ]
}

#[test]
#[cfg(long)]
fn steps_stay_on_their_sheets() {
    families(1, 50).iter().for_each(|outcome| outcome.check(22));
}

/// Scenes with one sheet go on as if nobody looked: at rest, with coordinates that are zero, in long steps and in short
/// ones.
#[test]
fn what_has_one_sheet_is_not_refused() {
    fn go(constraint: impl PhaseConstraint<2, 1>, [q, p]: [[f64; 2]; 2], h: f64) {
        let scene = Scene::in_phase_space(constraint, Falling { g: 1.0 });
        let start = scene.project(&State::at(q).moving(p)).unwrap();
        let mut simulation = scene.simulate(start, Rattle::new(h)).unwrap();
        simulation.run(500).unwrap_or_else(|error| panic!("{q:?}, {p:?}, h = {h}: {error}"));
    }
    for h in [1e-12, 1e-6, 0.01, 0.3] {
        go(Line {}, [[0.6, 0.0], [0.5, 0.0]], h);
        go(Ring {}, [[0.6, -0.8], [0.5, 0.3]], h);
        for off in [0.0, 1e-15, 1e-9, 1e-3] {
            go(Ring {}, [[off, -1.0], [off, 0.0]], h);
        }
    }
}

/// What is remembered of guesses goes along with a checkpoint.
#[test]
fn a_checkpoint_goes_on_to_the_bit() {
    let scene = Scene::in_phase_space(Shells { k: 300.0 }, Falling { g: 0.3 });
    let start = scene.project(&State::at([0.4, 0.1]).moving([0.5, 0.3])).unwrap();
    let mut whole = scene.simulate(start.clone(), Rattle::new(0.03)).unwrap();
    whole.run(20).unwrap();
    let record = whole.checkpoint();
    let mut again = scene.simulate(start, Rattle::new(0.03)).unwrap();
    again.resume(&record).unwrap();
    for _ in 0..20 {
        whole.run(1).unwrap();
        again.run(1).unwrap();
        assert_eq!(whole.state(), again.state());
        assert_eq!(format!("{:?}", whole.checkpoint()), format!("{:?}", again.checkpoint()));
    }
}

/// `cargo long --test phase phase_sheets::many -- --ignored`
#[test]
#[cfg(long)]
#[ignore = "some minutes"]
fn many_steps_stay_on_their_sheets() {
    let wrong = |seed: u64| families(1000 + 7 * seed, 150).iter().map(|outcome| outcome.wrong).sum::<u32>();
    assert_eq!((0..100).into_par_iter().map(wrong).sum::<u32>(), 0);
}
