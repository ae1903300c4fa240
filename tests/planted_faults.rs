//! Faults that people make in RATTLE, planted on purpose: which law catches which.
//!
//! RATTLE for one particle is written out here once more, in plain steps, each of which can be made wrong. Right, it is
//! the library's; wrong, the laws named in the table must notice. Energy alone is not enough: without the projection of
//! the momentum, or after a single iteration of Newton, it looks as it should.

use crate::common::*;
use rattle::nalgebra::{SVector, Vector3};
use rattle::prelude::*;

potential! {
    /// Gravity, and a force that changes from place to place.
    struct Uneven { g }
    |x, y, z| g * z + x^2 * y + x * z / 2 + y^2 / 3
}

const FIELD: Uneven = Uneven { g: 1.0 };

#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    None,
    /// The multiplier of the position acts along ∇g in the middle of the step …
    GradientInTheMiddle,
    /// … or where the step would lead without it.
    GradientAhead,
    /// p½ without the multiplier.
    NoMultiplier,
    /// The second kick is left out …
    NoLastKick,
    /// … or takes the force of the old place.
    OldForce,
    /// The momentum is made tangent to the surface in the middle of the step …
    ProjectedInTheMiddle,
    /// … or not at all.
    NotProjected,
    /// A single iteration of Newton.
    OneIteration,
    /// Newton until |g| < 1e-6.
    LooseTolerance,
    /// The force pushes the wrong way.
    WrongSign,
}

#[derive(Debug, Clone, Copy)]
struct Point {
    q: Vector3<f64>,
    p: Vector3<f64>,
}

fn gradient(q: Vector3<f64>) -> Vector3<f64> {
    SURFACE.jacobian(&q).transpose()
}

fn lambda(at: Point) -> f64 {
    let n = gradient(at.q);
    let bend = (SURFACE.hessian_vector(&at.q, &at.p) * at.p)[0];
    -(bend - n.dot(&FIELD.gradient(&at.q))) / n.norm_squared()
}

/// A step of RATTLE with this fault.
fn step(fault: Fault, h: f64, Point { q, p }: Point) -> Point {
    let sign = if fault == Fault::WrongSign { -1.0 } else { 1.0 };
    let force = |q| -sign * FIELD.gradient(&q);
    let free = h * p + 0.5 * h * h * force(q);
    let along = match fault {
        Fault::GradientInTheMiddle => gradient(q + 0.5 * free),
        Fault::GradientAhead => gradient(q + free),
        _ => gradient(q),
    };
    let mut multiplier = 0.5 * h * h * lambda(Point { q, p });
    for iteration in 0..50 {
        let q_next = q + (free + multiplier * along);
        let (g, n) = (SURFACE.value(&q_next)[0], gradient(q_next));
        let change = -g / n.dot(&along);
        let done = match fault {
            Fault::OneIteration => iteration == 1,
            Fault::LooseTolerance => g.abs() < 1e-6,
            _ => iteration > 2 && (change * along).norm() < 1e-16,
        };
        if done {
            break;
        }
        multiplier += change;
    }
    let q_next = q + (free + multiplier * along);
    let impulse = if fault == Fault::NoMultiplier { Vector3::zeros() } else { multiplier / h * along };
    let last = match fault {
        Fault::NoLastKick => Vector3::zeros(),
        Fault::OldForce => force(q),
        _ => force(q_next),
    };
    let p = p + 0.5 * h * force(q) + impulse + 0.5 * h * last;
    let normal = match fault {
        Fault::ProjectedInTheMiddle => gradient(0.5 * (q + q_next)),
        Fault::NotProjected => Vector3::zeros(),
        _ => gradient(q_next),
    };
    let off = if fault == Fault::NotProjected { 0.0 } else { normal.dot(&p) / normal.norm_squared() };
    Point { q: q_next, p: p - off * normal }
}

fn scene() -> Scene<Lemniscate, impl rattle::effect::Effects<3> + Clone, rattle::bodies::One, 3> {
    Scene::on(SURFACE).with(FIELD)
}

/// On the way over the surface, where nothing is symmetric.
fn start() -> Point {
    let mut simulation = scene().simulate(billiard(0.7), Lobatto::<6>::new(0.01)).unwrap();
    simulation.run(40).unwrap();
    Point { q: simulation.position(), p: simulation.momentum() }
}

fn tangent(at: Point) -> Point {
    let state = scene().project(&State::at(at.q).moving(at.p)).unwrap();
    Point { q: state.positions().next().unwrap(), p: state.momenta().next().unwrap() }
}

fn energy(at: Point) -> f64 {
    0.5 * at.p.norm_squared() + FIELD.value(&at.q)
}

/// H₂ = H + h²(|a|²/24 + (vᵀ∇²U v + ∇U·a)/12).
fn shadow(at: Point, h: f64) -> f64 {
    let pull = FIELD.gradient(&at.q);
    let a = lambda(at) * gradient(at.q) - pull;
    let e = 1e-4;
    let bend =
        (FIELD.gradient(&(at.q + e * at.p)) - FIELD.gradient(&(at.q - e * at.p))).dot(&at.p) / (2.0 * e);
    energy(at) + h * h * (a.norm_squared() / 24.0 + (bend + pull.dot(&a)) / 12.0)
}

/// The spread of a quantity over a time of 4, at steps of 0.01 and of 0.005: its order.
fn order_of_spread(fault: Fault, of: impl Fn(Point, f64) -> f64) -> f64 {
    let spread = [0.01, 0.005].map(|h: f64| {
        let (mut at, mut least, mut most) = (start(), f64::INFINITY, f64::NEG_INFINITY);
        for _ in 0..(4.0 / h).round() as u32 {
            at = step(fault, h, at);
            let x = of(at, h);
            (least, most) = (least.min(x), most.max(x));
        }
        most - least
    });
    (spread[0] / spread[1]).log2()
}

/// The order of the error at t = 1, against a method of order 16.
fn order_of_error(fault: Fault) -> f64 {
    let from = start();
    let start = State::at(from.q).moving(from.p);
    let mut exact = scene().simulate(scene().project(&start).unwrap(), Lobatto::<9>::new(0.02)).unwrap();
    exact.run(50).unwrap();
    let errors = [0.01, 0.005].map(|h: f64| {
        let end = (0..(1.0 / h).round() as u32).fold(from, |at, _| step(fault, h, at));
        distance(end.q, exact.position()).max(distance(end.p, exact.momentum()))
    });
    (errors[0] / errors[1]).log2()
}

/// How far a step forth and one back lead from the start.
fn reversal(fault: Fault) -> f64 {
    let from = step(fault, 0.01, start());
    let back = step(fault, -0.01, step(fault, 0.01, from));
    distance(back.q, from.q).max(distance(back.p, from.p))
}

/// |g|, and the part of the momentum that is not tangent, at most in 400 steps.
fn off_the_surface(fault: Fault) -> f64 {
    let (mut at, mut worst) = (start(), 0.0_f64);
    for _ in 0..400 {
        at = step(fault, 0.01, at);
        worst = worst.max(SURFACE.value(&at.q)[0].abs()).max(gradient(at.q).dot(&at.p).abs());
    }
    worst
}

/// The largest change of ω = dq ∧ dp in one step, by differences of fourth order along the tangent bundle.
fn symplectic_defect(fault: Fault) -> f64 {
    let from = start();
    let e = 2e-4;
    let near = |direction: usize, by: f64| {
        let wave = |i: usize| (1.0 + direction as f64 + 2.7 * i as f64).sin();
        let moved =
            |x: Vector3<f64>, first: usize| SVector::<f64, 3>::from_fn(|i, _| x[i] + by * wave(first + i));
        tangent(Point { q: moved(from.q, 0), p: moved(from.p, 3) })
    };
    let derivative = |map: &dyn Fn(Point) -> Point, direction: usize| {
        let at = |k: f64| map(near(direction, k * e));
        let (a, b, c, d) = (at(1.0), at(-1.0), at(2.0), at(-2.0));
        let by = |x: fn(&Point) -> Vector3<f64>| (8.0 * (x(&a) - x(&b)) - (x(&c) - x(&d))) / (12.0 * e);
        Point { q: by(|at| at.q), p: by(|at| at.p) }
    };
    let omega = |a: Point, b: Point| a.q.dot(&b.p) - a.p.dot(&b.q);
    let moves = |at| step(fault, 0.02, at);
    let mut worst = 0.0_f64;
    for a in 0..4 {
        for b in 0..a {
            let before = omega(derivative(&|at| at, a), derivative(&|at| at, b));
            let after = omega(derivative(&moves, a), derivative(&moves, b));
            worst = worst.max((after - before).abs());
        }
    }
    worst
}

#[test]
fn without_a_fault_it_is_the_method_of_the_library() {
    let from = start();
    let state = scene().project(&State::at(from.q).moving(from.p)).unwrap();
    let mut library = scene().simulate(state, Rattle::new(0.01)).unwrap();
    let mut at = Point { q: library.position(), p: library.momentum() };
    for _ in 0..100 {
        library.step().unwrap();
        at = step(Fault::None, 0.01, at);
    }
    let off = distance(at.q, library.position()).max(distance(at.p, library.momentum()));
    assert!(off <= 1e-13, "{off:e}");
    assert!((shadow(at, 0.01) - library.shadow_energy()).abs() <= 1e-9);
}

#[test]
fn every_planted_fault_is_caught() {
    type Law = (&'static str, fn(Fault) -> f64, fn(f64) -> bool);
    let laws: [Law; 6] = [
        ("order", order_of_error, |order| (order - 2.0).abs() < 0.2),
        ("energy", |fault| order_of_spread(fault, |at, _| energy(at)), |order| (order - 2.0).abs() < 0.2),
        ("shadow energy", |fault| order_of_spread(fault, shadow), |order| order > 3.7),
        ("surface", off_the_surface, |off| off <= 1e-14),
        ("reversal", reversal, |off| off <= 2e-14),
        ("symplecticity", symplectic_defect, |defect| defect <= 2e-11),
    ];
    let expected: [(Fault, &[&str]); 11] = [
        (Fault::None, &[]),
        (Fault::GradientInTheMiddle, &["order", "energy", "shadow energy", "reversal", "symplecticity"]),
        (Fault::GradientAhead, &["order", "energy", "shadow energy", "reversal", "symplecticity"]),
        (Fault::NoMultiplier, &["order", "energy", "shadow energy", "reversal", "symplecticity"]),
        (Fault::NoLastKick, &["order", "energy", "shadow energy", "reversal"]),
        (Fault::OldForce, &["order", "energy", "shadow energy", "reversal", "symplecticity"]),
        (
            Fault::ProjectedInTheMiddle,
            &["order", "energy", "shadow energy", "surface", "reversal", "symplecticity"],
        ),
        (Fault::NotProjected, &["order", "shadow energy", "surface", "reversal"]),
        (Fault::OneIteration, &["surface", "reversal"]),
        (Fault::LooseTolerance, &["shadow energy", "surface", "reversal", "symplecticity"]),
        (Fault::WrongSign, &["order", "energy", "shadow energy"]),
    ];
    let mut wrong = Vec::new();
    for (fault, caught_by) in expected {
        let mut caught = Vec::new();
        print!("{:22}", format!("{fault:?}"));
        for (name, measure, holds) in laws {
            let found = measure(fault);
            print!(" {name} {found:9.2e}");
            if !holds(found) {
                caught.push(name);
            }
        }
        println!("  caught by {caught:?}");
        // Right is right by every law; a fault may be caught by more than it must.
        let missed = caught_by.iter().any(|name| !caught.contains(name));
        if missed || (fault == Fault::None && !caught.is_empty()) {
            wrong.push((fault, caught));
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}
