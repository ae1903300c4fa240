//! Steps that are too long never end on another root, and no input makes a panic.

use crate::common::linked::*;
use crate::common::*;
use nalgebra::{Matrix2, Vector2, vector};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::bodies::Many;
use rattle::effect::Effects;
use rattle::network::{LinearAlgebra, Mass, Network};
use rattle::prelude::*;

/// A double pendulum about the origin.
#[derive(Debug, Clone, Copy)]
struct Double {
    q: [Vector2<f64>; 2],
    v: [Vector2<f64>; 2],
    masses: [f64; 2],
    lengths: [f64; 2],
    g: f64,
}

impl Double {
    fn random(rng: &mut StdRng) -> Self {
        let mut number = |a: f64, b: f64| rng.random_range(a..b);
        let (masses, lengths) = ([number(0.1, 3.0), number(0.1, 3.0)], [number(0.5, 1.5), number(0.5, 1.5)]);
        let mut q = [Vector2::zeros(); 2];
        let mut v = q;
        for i in 0..2 {
            let (sin, cos) = number(-4.0, 4.0).sin_cos();
            let rate = number(-3.0, 3.0);
            let (arm, turning) = (lengths[i] * vector![cos, sin], rate * lengths[i] * vector![-sin, cos]);
            (q[i], v[i]) = if i == 0 { (arm, turning) } else { (q[0] + arm, v[0] + turning) };
        }
        Self { q, v, masses, lengths, g: number(0.0, 2.0) }
    }

    /// Its scene, the pivot being body 0, and its start.
    fn scene(
        &self,
        algebra: LinearAlgebra,
    ) -> (Scene<Network<2>, impl Effects<2> + use<>, Many, 2>, State<2>) {
        let Self { q, v, masses, lengths, g } = *self;
        let zero = Vector2::zeros();
        let scene = Scene::points(3)
            .link_each([(Rod { length: lengths[0] }, [0, 1]), (Rod { length: lengths[1] }, [1, 2])])
            .pin(0, [0.0, 0.0])
            .masses([1.0, masses[0], masses[1]])
            .linear_algebra(algebra)
            .with(weights(&[1.0, g * masses[0], g * masses[1]]));
        let momenta = [zero, v[0] * masses[0], v[1] * masses[1]];
        (scene, State::of([zero, q[0], q[1]]).with_momenta(momenta))
    }

    /// The rods' equations, and their gradients as [rod][body].
    fn rods(&self, q: &[Vector2<f64>; 2]) -> (Vector2<f64>, [[Vector2<f64>; 2]; 2]) {
        let arm = q[1] - q[0];
        let g = vector![
            q[0].norm_squared() - self.lengths[0].powi(2),
            arm.norm_squared() - self.lengths[1].powi(2)
        ];
        (g, [[2.0 * q[0], Vector2::zeros()], [-2.0 * arm, 2.0 * arm]])
    }

    /// Positions at the part s of the step with these multipliers.
    fn at(&self, s: f64, h: f64, x: &Vector2<f64>) -> [Vector2<f64>; 2] {
        let normals = self.rods(&self.q).1;
        [0, 1].map(|i| {
            let push = vector![0.0, -self.g];
            let pull = (normals[0][i] * x[0] + normals[1][i] * x[1]) / self.masses[i];
            self.q[i] + s * h * self.v[i] + 0.5 * (s * h).powi(2) * push + pull
        })
    }

    /// The largest relative change of a normal within a step.
    fn turn(&self, h: f64) -> f64 {
        let first = h * self.v[0].norm() / self.lengths[0];
        first.max(h * (self.v[1] - self.v[0]).norm() / self.lengths[1])
    }

    /// Where the root goes that begins at h = 0, in a thousand parts; None where it ends, which a turned determinant or
    /// Newton's method without end shows.
    fn continued(&self, h: f64) -> Option<[Vector2<f64>; 2]> {
        const PARTS: u32 = 1000;
        let normals = self.rods(&self.q).1;
        let (mut x, mut before) = (Vector2::zeros(), Vector2::zeros());
        for part in 1..=PARTS {
            let s = f64::from(part) / f64::from(PARTS);
            let guess = 2.0 * x - before;
            (before, x) = (x, guess);
            let mut size = f64::INFINITY;
            for _ in 0..10 {
                let (g, slopes) = self.rods(&self.at(s, h, &x));
                let entry = |row: usize, column: usize| -> f64 {
                    (0..2).map(|i| slopes[row][i].dot(&normals[column][i]) / self.masses[i]).sum()
                };
                let matrix = Matrix2::new(entry(0, 0), entry(0, 1), entry(1, 0), entry(1, 1));
                if matrix.determinant() <= 0.0 {
                    return None;
                }
                let correction = matrix.try_inverse()? * g;
                x -= correction;
                size = correction.norm() / (1e-6 + x.norm());
            }
            if size > 1e-9 {
                return None;
            }
        }
        Some(self.at(1.0, h, &x))
    }
}

/// Either an error, or the root that is reached from h = 0. Where that root ends there may only be an error.
#[test]
#[cfg(long)]
fn a_long_step_is_an_error_or_the_right_root() {
    long_steps(Rattle::new);
    long_steps(|h| Rattle::new(h).solved_by(Symmetric));
    long_steps(|h| Rattle::new(h).solved_by(Simplified));
    long_steps(|h| Rattle::new(h).solved_by(Broyden));
}

fn long_steps<S: Method>(method: impl Fn(f64) -> S) {
    let mut rng = StdRng::seed_from_u64(10);
    let (mut right, mut wrong, mut beyond, mut refused, mut ended, mut needlessly) = (0, 0, 0, 0, 0, 0);
    for _ in 0..1200 {
        let double = Double::random(&mut rng);
        let h = rng.random_range(0.0..3.0) / double.turn(1.0);
        for algebra in [LinearAlgebra::Orthogonal, LinearAlgebra::Elimination] {
            let (scene, start) = double.scene(algebra);
            let mut simulation = scene.simulate(start, method(h)).unwrap();
            match (simulation.step(), double.continued(h)) {
                (Ok(()), Some(end)) => {
                    let found: Vec<f64> = coordinates(&simulation.state())[2..].to_vec();
                    let exact: Vec<f64> = end.iter().flat_map(|q| [q.x, q.y]).collect();
                    if apart(&found, &exact) <= 1e-7 { right += 1 } else { wrong += 1 }
                }
                (Ok(()), None) => beyond += 1,
                (Err(_), Some(_)) => {
                    refused += 1;
                    needlessly += u32::from(double.turn(h) < 0.5);
                }
                (Err(_), None) => ended += 1,
            }
        }
    }
    println!(
        "right {right}, wrong {wrong}, where the root ends {beyond}; refused {refused}, and rightly {ended}"
    );
    assert_eq!((wrong, beyond), (0, 0));
    assert!(right > 400 && ended > 400, "both happen");
    assert_eq!(needlessly, 0, "of steps that are not long none is refused");
    assert!(refused * 5 <= right, "few are refused without need: {refused}");
}

/// Long steps one after another, begun from what is remembered: each ends where one without a memory ends, or is an
/// error as that is.
#[test]
#[cfg(long)]
fn guesses_do_not_mislead_long_steps() {
    remembering(|h| Rattle::new(h).guess(LastMultiplier));
    remembering(|h| Rattle::new(h).guess(Extrapolated));
    remembering(|h| Rattle::new(h).guess(LastMultiplier).solved_by(Broyden));
    remembering(|h| Rattle::new(h).guess(Extrapolated).solved_by(Simplified));
}

fn remembering<S: Method>(method: impl Fn(f64) -> S) {
    let mut rng = StdRng::seed_from_u64(12);
    let (mut taken, mut refused) = (0, 0);
    for _ in 0..1000 {
        let double = Double::random(&mut rng);
        let h = rng.random_range(0.0..1.0) / double.turn(1.0);
        for algebra in [LinearAlgebra::Orthogonal, LinearAlgebra::Elimination] {
            let (scene, start) = double.scene(algebra);
            let mut simulation = scene.simulate(start, method(h)).unwrap();
            for _ in 0..8 {
                let mut pure = scene.simulate(simulation.state(), Rattle::new(h)).unwrap();
                match (simulation.step(), pure.step()) {
                    (Ok(()), Ok(())) => {
                        let off = apart(&coordinates(&simulation.state()), &coordinates(&pure.state()));
                        assert!(off <= 1e-9, "{double:?}, h = {h}: {off:e}");
                        taken += 1;
                    }
                    (Err(error), Err(other)) => {
                        refused += 1;
                        assert_eq!(error.to_string().split(':').nth(1), other.to_string().split(':').nth(1));
                        break;
                    }
                    (one, other) => panic!("{double:?}, h = {h}: {one:?}, {other:?}"),
                }
            }
        }
    }
    println!("{taken} taken, {refused} refused");
    assert!(taken > 2000 && refused > 500);
}

constraint! {
    /// A circle whose centre moves.
    struct Circling { radius, rate }
    |x, y, t| (x - sin(rate * t))^2 + y^2 - radius^2
}

constraint! {
    /// Three bodies on a line through their middle, with an expression that can leave its domain.
    struct Between { offset }
    |a: [f64; 2], b: [f64; 2], c: [f64; 2]| [sqrt(a[0] - b[0] + offset) - c[1], b[1]^2 - c[0] * a[1]]
}

potential! {
    /// Finite inside only.
    struct Bowl { depth }
    |x, y| depth * ln(4 - x^2 - y^2)
}

fn number(rng: &mut StdRng) -> f64 {
    let odd =
        [0.0, -0.0, 1.0, -1.0, 1e-310, 1e-160, 1e160, 1e308, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    match rng.random_range(0..400) {
        i if i < odd.len() => odd[i],
        _ => rng.random_range(-2.0..2.0),
    }
}

fn mass(rng: &mut StdRng) -> Mass<2> {
    let positive =
        |rng: &mut StdRng| if rng.random_bool(0.97) { rng.random_range(0.1..3.0) } else { number(rng) };
    match rng.random_range(0..4) {
        0 => Mass::Unit,
        1 => positive(rng).into(),
        2 => [positive(rng), positive(rng)].into(),
        _ => {
            let (a, b, c) = (positive(rng), number(rng), positive(rng));
            Mass::Matrix([[a * a, a * b], [a * b, b * b + c * c]])
        }
    }
}

/// Any networks, any numbers: answers and errors, no panic; after an error everything is as it was.
#[test]
#[cfg(long)]
fn no_network_makes_a_panic() {
    let mut rng = StdRng::seed_from_u64(11);
    let (mut mistakes, mut starts, mut steps, mut runs, mut checked) = (0, 0, 0, 0, 0);
    for _ in 0..20_000 {
        let rng = &mut rng;
        let bodies = if rng.random_bool(0.02) { 0 } else { rng.random_range(1..7_usize) };
        let slip = rng.random_bool(0.05);
        let body = |rng: &mut StdRng| {
            if slip && rng.random_bool(0.3) {
                [7, 8, usize::MAX][rng.random_range(0..3)]
            } else {
                rng.random_range(0..bodies.max(1))
            }
        };
        let pair = |rng: &mut StdRng| {
            let (a, b) = (body(rng), body(rng));
            if a == b && (!slip || rng.random_bool(0.8)) && bodies > 1 {
                [a, a.wrapping_add(1) % bodies]
            } else {
                [a, b]
            }
        };
        let count = |rng: &mut StdRng, most: usize| rng.random_range(0..=most.min(2 * bodies));
        let rods: Vec<_> = (0..count(rng, 10)).map(|_| pair(rng)).collect();
        let own: Vec<_> = (0..count(rng, 2)).map(|_| (Rod { length: number(rng) }, pair(rng))).collect();
        let circles: Vec<_> = (0..count(rng, 2)).map(|_| [body(rng)]).collect();
        let arms: Vec<_> = (0..count(rng, 1)).map(|_| [body(rng)]).collect();
        let between: Vec<_> = (0..usize::from(rng.random_bool(0.1)))
            .map(|_| if bodies > 2 { [0, 1, 2] } else { [body(rng), body(rng), body(rng)] })
            .collect();
        let algebra = [LinearAlgebra::Automatic, LinearAlgebra::Orthogonal, LinearAlgebra::Elimination]
            [rng.random_range(0..3)];
        let mut scene = Scene::points(bodies)
            .link(Rod { length: 1.0 }, rods)
            .link_each(own)
            .link_moving(Circling { radius: 1.0, rate: number(rng) }, circles)
            .link_acting(Pendulum { length: 1.0 }, arms, [[rng.random_bool(0.8), rng.random_bool(0.8)]])
            .link(Between { offset: 3.0 }, between)
            .linear_algebra(algebra);
        if rng.random_bool(0.5) {
            let short = usize::from(slip && bodies > 0);
            let masses: Vec<_> = (short..bodies).map(|_| mass(rng)).collect();
            scene = scene.masses(masses);
        }
        let mut q: Vec<[f64; 2]> = (0..bodies)
            .map(|i| {
                if rng.random_bool(0.9) {
                    [0.9 * i as f64, rng.random_range(-1.0..1.0)]
                } else {
                    [number(rng), number(rng)]
                }
            })
            .collect();
        for _ in 0..rng.random_range(0..3) {
            let at = [number(rng), number(rng)];
            let body = body(rng);
            scene = scene.pin(body, at);
            if let Some(q) = q.get_mut(body) {
                *q = at;
            }
        }
        let p: Vec<[f64; 2]> = (0..bodies).map(|_| random(rng)).collect();
        let start =
            State::of(q).with_momenta(p).at_time(if rng.random_bool(0.98) { 0.0 } else { number(rng) });
        let scene = scene.with(PlanarGravity { g: 1.0 }).with(
            Bowl { depth: if rng.random_bool(0.3) { 1.0 } else { 0.0 } }
                .over((0..bodies.min(1)).map(|i| [i])),
        );
        let h = if rng.random_bool(0.95) { rng.random_range(-0.3..0.3) } else { number(rng) };
        let start = match scene.project(&start) {
            Ok(projected) => projected,
            Err(error) => {
                mistakes += usize::from(matches!(error, rattle::Error::Network(_)));
                starts += 1;
                assert!(!error.to_string().is_empty());
                start
            }
        };
        let mut simulation = match scene.simulate(start, Rattle::new(h)) {
            Ok(simulation) => simulation,
            Err(error) => {
                assert!(!error.to_string().is_empty());
                continue;
            }
        };
        runs += 1;
        for _ in 0..20 {
            let before = bits(&simulation.state());
            if let Err(error) = simulation.step() {
                assert!(!error.to_string().is_empty());
                assert_eq!(bits(&simulation.state()), before);
                steps += 1;
                break;
            }
            let phase = phase(&simulation.state());
            assert!(phase.iter().all(|x| x.is_finite()), "no step ends in NaN");
            let size = phase.iter().fold(1.0, |size, x| f64::max(size, x.abs()));
            if size < 1e3 {
                // No length here is longer than that, and no gradient larger than a few times the lengths.
                let off = simulation.constraint_residual().max(simulation.cotangent_residual());
                assert!(off <= 1e-9 * size * size, "{off:e} at {phase:?}");
                checked += 1;
            }
        }
        let _ = (simulation.energy_error(), simulation.constraint_forces(), simulation.multipliers());
    }
    println!(
        "{mistakes} mistakes, {starts} bad starts, {runs} runs of which {steps} ended early; {checked} steps checked"
    );
    assert!(mistakes > 100 && starts > 1000 && runs > 1000 && steps > 100);
}
