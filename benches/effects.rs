//! What a scene does not name costs nothing: counted in evaluations, bytes and instructions.
//!
//! ```text
//! cargo bench --bench effects
//! ```
//!
//! Instructions are those of callgrind (Debian: `apt-get install valgrind`), per step, from the difference
//! of two runs of this program with different numbers of steps, so that set-up cancels. The yardsticks are
//! the same method written by hand for this one surface, with nothing that a free particle does not need: once without
//! any check, and once with those that a scene makes, which are when a solve has ended, by third derivatives; whether
//! the root found is the one that the motion continues on, by slopes and by what guesses were off before; whether
//! momenta are numbers. Where a check asks for a look inside the step, it looks; where that asks for the root to be
//! followed, the loop goes on without.

use rattle::Counted;
use rattle::bodies::{Bodies, One};
use rattle::effect::Effects;
use rattle::potentials::Gravity;
use rattle::prelude::*;
use rattle::surface::Kept;
use rattle::surfaces::Lemniscate;
use std::hint::black_box;
use std::process::Command;

const SURFACE: Lemniscate = Lemniscate { a: 1.0, r: 1.0 / 6.0 };
const H: f64 = 0.01;
/// A name, and the position after so many steps.
type Program = (&'static str, fn(u64) -> [f64; 3]);
const PROGRAMS: [Program; 4] = [
    ("by hand, free", by_hand::<false>),
    ("by hand, checked", by_hand::<true>),
    ("scene, free", free),
    ("scene, gravity", falling),
];

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let [_, flag, program, steps] = &arguments[..]
        && flag == "--run"
    {
        let (_, run) = PROGRAMS[program.parse::<usize>().expect("a program's number")];
        black_box(run(steps.parse().expect("a number of steps")));
        return;
    }
    evaluations();
    bytes();
    let [by_hand, checked, free, _] = PROGRAMS.map(|(_, run)| run(1000));
    for other in [by_hand, checked] {
        let apart = other.iter().zip(free).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-8, "the loop written by hand moves otherwise: {apart:e}"); // chaos amplifies rounding
    }
    instructions();
}

fn start() -> State<3> {
    State::at([0.0, 0.0, SURFACE.r]).moving([0.7_f64.cos(), 0.7_f64.sin(), 0.0])
}

fn free(steps: u64) -> [f64; 3] {
    let mut simulation =
        Scene::on(SURFACE).simulate(start(), Rattle::new(H)).expect("a start on the surface");
    simulation.run(steps).expect("a step within reach");
    simulation.position().into()
}

fn falling(steps: u64) -> [f64; 3] {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let mut simulation = scene.simulate(start(), Rattle::new(H)).expect("a start on the surface");
    simulation.run(steps).expect("a step within reach");
    simulation.position().into()
}

fn evaluations() {
    let steps = 10_000;
    println!("evaluations per step          g      ∇g     v·∇²g·v     ∇U       U");
    for acts in [false, true] {
        let (surface, gravity) = (Counted::new(SURFACE), Counted::new(Gravity { g: 1.0 }));
        let counts = [surface.counts(), gravity.counts()];
        if acts {
            let scene = Scene::on(surface).with(gravity);
            let mut simulation = scene.simulate(start(), Rattle::new(H)).expect("a start on the surface");
            counts.iter().for_each(rattle::counted::Counts::reset);
            simulation.run(steps).expect("a step within reach");
        } else {
            let mut simulation =
                Scene::on(surface).simulate(start(), Rattle::new(H)).expect("a start on the surface");
            counts[0].reset();
            simulation.run(steps).expect("a step within reach");
        }
        let per_step = |count: u64| count as f64 / steps as f64;
        println!(
            "{:22} {:8.3} {:8.3} {:8.3} {:8.3} {:8.3}",
            if acts { "gravity" } else { "free" },
            per_step(counts[0].values()),
            per_step(counts[0].gradients()),
            per_step(counts[0].curvatures()),
            per_step(counts[1].gradients()),
            per_step(counts[1].values()),
        );
    }
}

fn bytes() {
    fn of<C, E: Effects<3>>(_: &Scene<C, E, One, 3>) -> usize {
        size_of::<Bodies<One, f64, Kept<One, f64, E::Forces<f64>, 3>, 3>>()
    }
    let scene = Scene::on(SURFACE);
    let (free, forced) = (of(&scene), of(&scene.with(Gravity { g: 1.0 })));
    println!("\nbytes per particle: {free} free, {forced} with a force; no multiplier is among them");
    assert_eq!(free + size_of::<[f64; 3]>(), forced);
}

fn instructions() {
    println!("\ninstructions per step (callgrind)");
    let counts: Vec<f64> = (0..PROGRAMS.len()).filter_map(instructions_per_step).collect();
    let [by_hand, checked, free, gravity] = counts[..] else {
        println!("skipped: valgrind was not found (Debian: apt-get install valgrind)");
        return;
    };
    for ((name, _), count) in PROGRAMS.iter().zip(&counts) {
        println!("{name:22} {count:8.1}");
    }
    println!("\nratio free_over_by_hand {:.3}", free / by_hand);
    println!("ratio free_over_checked_by_hand {:.3}", free / checked);
    println!("ratio gravity_over_free {:.3}", gravity / free);
}

fn instructions_per_step(program: usize) -> Option<f64> {
    let (few, many) = (1_000_u64, 11_000_u64);
    let total = |steps: u64| -> Option<f64> {
        let this = std::env::current_exe().ok()?;
        let output = Command::new("valgrind")
            .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
            .arg(this)
            .args(["--run", &program.to_string(), &steps.to_string()])
            .output()
            .ok()?;
        let report = String::from_utf8_lossy(&output.stderr).into_owned();
        let line = report.lines().find(|line| line.contains("Collected"))?;
        line.rsplit(' ').next()?.parse().ok()
    };
    Some((total(many)? - total(few)?) / (many - few) as f64)
}

/// RATTLE for a free particle on this surface, compensated, as one would write it by hand; with the checks of a scene,
/// or without.
fn by_hand<const CHECKED: bool>(steps: u64) -> [f64; 3] {
    let (a2, r2) = (SURFACE.a * SURFACE.a, SURFACE.r * SURFACE.r);
    let value = |[x, y, z]: [f64; 3]| {
        let (x2, y2) = (x * x, y * y);
        let s = x2 + y2;
        let f = s * s - a2 * (x2 - y2);
        f * f + z * z - r2
    };
    let value_and_gradient = |[x, y, z]: [f64; 3]| {
        let (x2, y2) = (x * x, y * y);
        let s = x2 + y2;
        let f = s * s - a2 * (x2 - y2);
        let (fx, fy) = (x * (s + s - a2), y * (s + s + a2)); // half the derivatives of f
        let f4 = 4.0 * f;
        (f * f + z * z - r2, [f4 * fx, f4 * fy, z + z])
    };
    let bend = |[x, y, z]: [f64; 3], [u, v, w]: [f64; 3]| {
        let _ = z;
        let (x2, y2) = (x * x, y * y);
        let s = x2 + y2;
        let f = s * s - a2 * (x2 - y2);
        let (m, p) = (s + s - a2, s + s + a2);
        let along = x * m * u + y * p * v;
        let spin = x * u + y * v;
        8.0 * along * along + (w * w + w * w) + 4.0 * f * (4.0 * spin * spin + m * u * u + p * v * v)
    };
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let two_sum = |a: [f64; 3], b: [f64; 3]| {
        let (mut high, mut low) = ([0.0; 3], [0.0; 3]);
        for i in 0..3 {
            high[i] = a[i] + b[i];
            let part = high[i] - a[i];
            low[i] = (a[i] - (high[i] - part)) + (b[i] - part);
        }
        (high, low)
    };
    let largest = |a: [f64; 3]| a[0].abs().max(a[1].abs()).max(a[2].abs());

    let mut q = [0.0, 0.0, SURFACE.r];
    let mut p = [0.7_f64.cos(), 0.7_f64.sin(), 0.0];
    let (mut q_low, mut p_low) = ([0.0; 3], [0.0; 3]);
    let mut n = value_and_gradient(q).1;
    let mut n_square = dot(n, n);
    let (mut off_before, mut off_last) = (f64::NAN, f64::NAN);
    for _ in 0..steps {
        let curve = bend(q, p);
        let mut free = [0.0; 3];
        for i in 0..3 {
            free[i] = H * p[i] + H * p_low[i];
        }
        if (H * curve) * (H * curve) > dot(p, p) * n_square {
            panic!("step too long");
        }
        let floor = f64::EPSILON * largest(q).max(largest(free));
        let length = n_square.sqrt();
        let point = |multiplier: f64| {
            let mut x = [0.0; 3];
            for i in 0..3 {
                x[i] = q[i] + (q_low[i] + (free[i] + multiplier * n[i]));
            }
            x
        };
        let guess = -0.5 * H * H * curve / n_square;
        let mut multiplier = guess;
        let (mut last, mut last_slope) = (f64::INFINITY, 0.0);
        let mut at_guess = None;
        let (gradient, at_end) = loop {
            let (g, gradient) = value_and_gradient(point(multiplier));
            let slope = dot(gradient, n);
            let newton = -g / slope;
            let first = newton.abs() * length;
            at_guess.get_or_insert((first, slope));
            let stalled = if CHECKED {
                let straight = (slope - last_slope).abs() <= 1e-7 * slope.abs();
                first >= 0.5 * last && straight && f64::EPSILON * first * first <= floor * floor
            } else {
                first >= 0.5 * last && first < 1e4 * floor
            };
            if first <= floor || stalled {
                break (gradient, slope);
            }
            multiplier += newton;
            let next = value(point(multiplier));
            let ratio = next / g;
            (last, last_slope) = (first, slope);
            if ratio.abs() < 0.25 {
                let bend = 1.0 - 2.0 * ratio;
                let share = ratio / bend;
                multiplier += share * newton;
                let second = share.abs() * first;
                if if CHECKED { 16.0 } else { 256.0 } * share * share * second <= floor {
                    let gradient = value_and_gradient(point(multiplier)).1;
                    let at_end = dot(gradient, n);
                    if !CHECKED {
                        break (gradient, at_end);
                    }
                    let of_parabola = slope * (bend - 2.0 * ratio * (1.0 - ratio));
                    let found = bend * at_end;
                    if 16.0 * (found - of_parabola).abs() * second <= floor * found.abs() {
                        break (gradient, at_end);
                    }
                }
            }
            if CHECKED && !first.is_finite() {
                panic!("no root");
            }
        };
        if CHECKED {
            let (first, slope) = at_guess.expect("a cycle");
            let (off, path_square) = (multiplier - guess, H * H * dot(p, p));
            let change = (at_end - slope) / at_end;
            let (change_square, first_square) = (change * change, first * first);
            let upright = 1e-3 * n_square < at_end && at_end <= 1e3 * n_square;
            let near =
                first_square <= 4e-4 * path_square && change_square * path_square <= 0.25 * first_square;
            let short = 4.0 * (H * curve) * (H * curve) <= dot(p, p) * n_square;
            let trusted = short && upright && (change_square <= 1e-14 || near);
            let expected = 2.0 * off_last - off_before;
            let usual = (off - expected).abs() <= 0.5 * off_last.abs().max(off_before.abs());
            if !(trusted && (usual || first <= 64.0 * floor)) {
                let inside = |s: f64| {
                    let mut x = [0.0; 3];
                    for i in 0..3 {
                        x[i] = q[i] + (q_low[i] + (s * free[i] + s * s * guess * n[i]));
                    }
                    -value(x) / slope
                };
                let looks = [std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::SQRT_2 - 1.0].map(inside);
                black_box(looks);
            }
            (off_before, off_last) = (off_last, off);
        }
        let multiplier_per_step = multiplier / H;
        let (mut step, mut kick) = ([0.0; 3], [0.0; 3]);
        for i in 0..3 {
            step[i] = q_low[i] + (free[i] + multiplier * n[i]);
            kick[i] = p_low[i] + multiplier_per_step * n[i];
        }
        (q, q_low) = two_sum(q, step);
        (p, p_low) = two_sum(p, kick);
        n = gradient;
        n_square = dot(n, n);
        let hat = [p[0] + p_low[0], p[1] + p_low[1], p[2] + p_low[2]];
        let eta = -dot(n, hat) / n_square;
        for i in 0..3 {
            kick[i] = p_low[i] + eta * n[i];
        }
        (p, p_low) = two_sum(p, kick);
        if CHECKED && !dot(p, p).is_finite() {
            panic!("no finite momentum");
        }
    }
    q
}
