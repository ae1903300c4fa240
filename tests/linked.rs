//! Linked bodies against solutions known to 30 digits, and the same mechanics in other words.

use crate::common::linked::*;
use crate::common::*;
use rattle::links::RotationMatrix;
use rattle::network::{LinearAlgebra, Mass};
use rattle::prelude::*;
use rattle::system::System;

/// The errors of what `measure` finds with n, 2n and 4n steps.
fn errors<Y: System<f64, D>, S: Method, const D: usize>(
    simulate: impl Fn(f64) -> Result<Simulation<Y, S, D>, rattle::Error>,
    (t, n): (f64, u32),
    exact: &[f64],
    measure: impl Fn(&Simulation<Y, S, D>) -> Vec<f64>,
) -> [f64; 3] {
    [n, 2 * n, 4 * n].map(|n| apart(&measure(&after(&simulate, t, n)), exact))
}

const PENDULUM_COLUMNS: [&str; 8] = ["x1", "y1", "x2", "y2", "vx1", "vy1", "vx2", "vy2"];

#[test]
fn double_pendulum_as_links_of_bodies() {
    let scene = Scene::points(3)
        .link(Rod { length: 1.0 }, chain(2))
        .pin(0, [0.0, 0.0])
        .with(PlanarGravity { g: 1.0 });
    let mut compared = 0;
    for row in table("double_pendulum") {
        // Later than t = 2 the motion is chaotic enough that h³ shows beside h².
        let t = row.number("t");
        if t > 2.0 {
            continue;
        }
        let exact = row.numbers(PENDULUM_COLUMNS);
        let steps = (200.0 * t) as u32;
        let start = double_pendulum();
        let second =
            errors(|h| scene.simulate(start.clone(), Rattle::new(h)), (t, steps), &exact, without_pivot);
        check_ratios(&format!("RATTLE, t = {t}"), second, 2);
        let suzuki = |h| scene.simulate(start.clone(), Composition::new(SUZUKI_1990_ORDER_4, h));
        let fourth = errors(suzuki, (t, steps / 4), &exact, without_pivot);
        check_ratios(&format!("Suzuki, t = {t}"), fourth, 4);
        // λ of |q|² − 1 and of |q₂ − q₁|² − 1.
        let multipliers = row.numbers(["lam1", "lam2"]);
        let lambda = errors(
            |h| scene.simulate(start.clone(), Rattle::new(h)),
            (t, steps),
            &multipliers,
            |now| now.multipliers(),
        );
        check_ratios(&format!("λ, t = {t}"), lambda, 2);
        println!("double pendulum, t = {t}: {second:?} {fourth:?} λ {lambda:?}");
        compared += 1;
    }
    assert_eq!(compared, 3);
}

/// Positions and momenta of all bodies but the first.
fn without_pivot<Y: System<f64, D>, S: Method, const D: usize>(now: &Simulation<Y, S, D>) -> Vec<f64> {
    [&now_part(now, true)[D..], &now_part(now, false)[D..]].concat()
}

/// Positions or momenta of all bodies.
fn now_part<Y: System<f64, D>, S: Method, const D: usize>(
    now: &Simulation<Y, S, D>,
    positions: bool,
) -> Vec<f64> {
    if positions {
        now.positions().flat_map(<[f64; D]>::from).collect()
    } else {
        now.momenta().flat_map(<[f64; D]>::from).collect()
    }
}

#[test]
fn double_pendulum_as_one_body_with_two_equations() {
    let one = Scene::on(BothRods { first: 1.0, second: 1.0 }).with(BothWeights { first: 1.0, second: 1.0 });
    let start = State::at([1.0, 0.0, 1.0, 1.0]);
    let row = &table("double_pendulum")[2];
    assert_eq!(row.number("t"), 2.0);
    let exact = row.numbers(PENDULUM_COLUMNS);
    let found = errors(
        |h| one.simulate(start.clone(), Rattle::new(h)),
        (2.0, 400),
        &exact,
        |now| phase(&now.state()),
    );
    check_ratios("one body", found, 2);

    // The discrete motion does not know how coordinates are shared out: rounding, ×20 by the motion.
    let links = Scene::points(3)
        .link(Rod { length: 1.0 }, chain(2))
        .pin(0, [0.0, 0.0])
        .with(PlanarGravity { g: 1.0 });
    let a = after(|h| one.simulate(start.clone(), Rattle::new(h)), 2.0, 400);
    let b = after(|h| links.simulate(double_pendulum(), Rattle::new(h)), 2.0, 400);
    let difference = apart(&now_part(&a, true), &now_part(&b, true)[2..]);
    println!("one body or links: {difference:.1e}");
    assert!(difference <= 1e-13, "{difference:e}");
}

#[test]
fn spherical_pendulum_with_its_multiplier() {
    let (sin, cos) = std::f64::consts::FRAC_PI_3.sin_cos();
    let start = State::at([sin, 0.0, -cos]).moving([0.0, 1.5, 0.0]);
    let scene = Scene::on(Sphere { r: 1.0 }).with(Gravity { g: 1.0 }).mass(1.0);
    for row in table("spherical_pendulum").iter().filter(|row| row.number("t") <= 5.0) {
        let t = row.number("t");
        let run = |h| scene.simulate(scene.project(&start).unwrap(), Rattle::new(h));
        let exact = row.numbers(["x", "y", "z", "vx", "vy", "vz"]);
        let found = errors(run, (t, (100.0 * t) as u32), &exact, |now| phase(&now.state()));
        check_ratios(&format!("t = {t}"), found, 2);
        let exact = row.numbers(["lambda_for_g=q2-1"]);
        let lambda = errors(run, (t, (100.0 * t) as u32), &exact, |now| now.multipliers());
        check_ratios(&format!("λ at t = {t}"), lambda, 2);
        println!("spherical pendulum, t = {t}: {found:?} λ {lambda:?}");
    }
}

#[test]
fn two_ricker_particles_in_a_network() {
    let surface = Scene::on(SURFACE).bodies(2).with(Ricker { depth: 0.5, radius: SURFACE.r });
    let network = surface.mass(1.0);
    let f = 0.1_f64.powi(4) - 0.1_f64.powi(2);
    let start = State::of([[0.0, 0.0, SURFACE.r], [0.1, 0.0, (1.0 / 36.0 - f * f).sqrt()]])
        .with_momenta([[0.3, 0.4, 0.0], [0.0; 3]]);
    let rows = table("ricker_two_particles");
    let row = rows.last().unwrap();
    let t = row.number("t");
    let exact = row.numbers(["x1", "y1", "z1", "x2", "y2", "z2"]);
    let run = |h| network.simulate(start.clone(), Rattle::new(h));
    let found = errors(run, (t, 200), &exact, |now| now_part(now, true));
    check_ratios("Ricker", found, 2);
    let a = after(|h| surface.simulate(start.clone(), Rattle::new(h)), t, 400);
    let difference = apart(&phase(&a.state()), &phase(&after(run, t, 400).state()));
    println!("Ricker: {found:?}, surface or network {difference:.1e}");
    assert!(difference <= 1e-12, "{difference:e}");
}

constraint! {
    /// QᵀQ = 1, all nine.
    struct RotationNine {}
    |q: [[f64; 3]; 3]| for i in 0..3, j in 0..3 { sum(k in 0..3, q[k][i] * q[k][j]) - delta(i, j) }
}

constraint! {
    /// The same six between the columns of Q as bodies.
    struct Frame {}
    |c: [[f64; 3]; 3]| for i in 0..3, j in i..3 { dot(c[i], c[j]) - delta(i, j) }
}

/// I₁ = d₂ + d₃ and so on for moments of inertia (0.6, 0.8, 1): H = tr(P D⁻¹Pᵀ)/2 is that of the rigid body.
const D: [f64; 3] = [0.6, 0.4, 0.2];

fn column_masses() -> [f64; 9] {
    std::array::from_fn(|i| D[i % 3])
}

/// Q = 1 and P = Q ω̂ D for the body momentum (1.8, 0.4, −0.9).
fn rigid_start() -> State<9> {
    let (x, y, z) = (1.8 / 0.6, 0.4 / 0.8, -0.9);
    let turning = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
    let q: [f64; 9] = std::array::from_fn(|i| f64::from(u8::from(i % 4 == 0)));
    let p: [f64; 9] = std::array::from_fn(|i| turning[i / 3][i % 3] * D[i % 3]);
    State::at(q).moving(p)
}

/// Σ qᵢ × pᵢ over the columns.
fn angular_momentum(q: &[f64], p: &[f64]) -> [f64; 3] {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        (0..3).map(|c| q[3 * j + c] * p[3 * k + c] - q[3 * k + c] * p[3 * j + c]).sum()
    })
}

#[test]
fn free_rigid_body_as_six_equations() {
    let scene = Scene::on(RotationMatrix {}).mass(column_masses());
    let columns = ["Q11", "Q12", "Q13", "Q21", "Q22", "Q23", "Q31", "Q32", "Q33"];
    let mut compared = 0;
    for row in table("rigid_body").iter().filter(|row| row.number("t") <= 5.0) {
        let (t, exact) = (row.number("t"), row.numbers(columns));
        let run = |h| scene.simulate(rigid_start(), Rattle::new(h));
        let found = errors(run, (t, (200.0 * t) as u32), &exact, |now| now_part(now, true));
        check_ratios(&format!("t = {t}"), found, 2);
        let suzuki = |h| scene.simulate(rigid_start(), Composition::new(SUZUKI_1990_ORDER_4, h));
        let fourth = errors(suzuki, (t, (40.0 * t) as u32), &exact, |now| now_part(now, true));
        check_ratios(&format!("Suzuki, t = {t}"), fourth, 4);
        println!("rigid body, t = {t}: {found:?} {fourth:?}");
        compared += 1;
    }
    assert_eq!(compared, 3);
}

/// Both are exact invariants of the discrete map (Moser and Veselov 1991); what is left is rounding, ε√n.
#[test]
fn free_rigid_body_keeps_energy_and_angular_momentum() {
    for redundant in [false, true] {
        let six = Scene::on(RotationMatrix {}).mass(column_masses());
        let nine = Scene::on(RotationNine {}).mass(column_masses());
        let mut worst = (0.0_f64, 0.0_f64);
        let see = |q: &[f64], p: &[f64], energy: f64| {
            worst.0 = worst.0.max(energy.abs());
            worst.1 = worst.1.max(apart(&angular_momentum(q, p), &[1.8, 0.4, -0.9]));
        };
        let simulation = if redundant { nine } else { six }.simulate(rigid_start(), Rattle::new(0.05));
        let mut simulation = simulation.unwrap();
        let mut see = see;
        simulation
            .run_with(if cfg!(long) { 8_000 } else { 2_000 }, |now| {
                see(now.position().as_slice(), now.momentum().as_slice(), now.energy_error());
            })
            .unwrap();
        let moved = apart(simulation.position().as_slice(), &coordinates(&rigid_start()));
        assert!(moved > 0.1, "{moved}");
        println!("rigid body, redundant {redundant}: {worst:?}");
        assert!(worst.0 <= 1e-13 && worst.1 <= 1e-13, "redundant {redundant}: {worst:?}");
        assert!(simulation.constraint_residual() <= 1e-15);
    }
}

#[test]
fn columns_of_a_rotation_as_three_bodies() {
    let one = Scene::on(RotationMatrix {}).mass(column_masses());
    let three = Scene::points(3).link(Frame {}, [[0, 1, 2]]).masses(D);
    let start = rigid_start();
    let column = |numbers: &[f64], c: usize| [numbers[c], numbers[3 + c], numbers[6 + c]];
    let (q, p) = (coordinates(&start), &phase(&start)[9..]);
    let columns = State::of([0, 1, 2].map(|c| column(&q, c))).with_momenta([0, 1, 2].map(|c| column(p, c)));
    let a = after(|h| one.simulate(start.clone(), Rattle::new(h)), 10.0, 200);
    let b = after(|h| three.simulate(columns.clone(), Rattle::new(h)), 10.0, 200);
    let a = coordinates(&a.state());
    let b = coordinates(&b.state());
    let turned: Vec<f64> = (0..3).flat_map(|c| column(&a, c)).collect();
    assert!(apart(&turned, &b) <= 1e-13, "{:e}", apart(&turned, &b));
}

constraint! {
    /// A surface twice.
    struct Twice { a, r }
    |x, y, z| {
        let f = (x^2 + y^2)^2 - a^2 * (x^2 - y^2);
        let g = f^2 + z^2 - r^2;
        [g, g]
    }
}

constraint! {
    /// A surface, and once more in another scale.
    struct Doubled { a, r }
    |x, y, z| {
        let f = (x^2 + y^2)^2 - a^2 * (x^2 - y^2);
        let g = f^2 + z^2 - r^2;
        [g, 2 * g]
    }
}

/// Redundant equations change nothing but the multipliers, which are shared: rounding of 200 steps, with a safety
/// factor for the chaos of the billiard.
#[test]
fn redundant_equations_give_the_same_motion() {
    let run = |h| Scene::on(RotationMatrix {}).mass(column_masses()).simulate(rigid_start(), Rattle::new(h));
    let six = after(run, 10.0, 200);
    let run = |h| Scene::on(RotationNine {}).mass(column_masses()).simulate(rigid_start(), Rattle::new(h));
    let nine = after(run, 10.0, 200);
    let report = nine.system().components().next().unwrap();
    assert_eq!((report.equations, report.rank, report.by), (9, 6, LinearAlgebra::Orthogonal), "{report}");
    let difference = apart(&phase(&six.state()), &phase(&nine.state()));
    println!("nine equations or six: {difference:.1e}");
    assert!(difference <= 1e-12, "{difference:e}");
    // Least norm: an equation that is there twice carries half each time.
    let (a, b) = (six.multipliers(), nine.multipliers());
    let halves = [a[0], a[1] / 2.0, a[2] / 2.0, a[1] / 2.0, a[3], a[4] / 2.0, a[2] / 2.0, a[4] / 2.0, a[5]];
    assert!(apart(&halves, &b) <= 1e-12 * a.iter().fold(0.0, |m, x| f64::max(m, x.abs())), "{a:?}\n{b:?}");

    let gravity = Gravity { g: 1.0 };
    let once = Scene::on(SURFACE).with(gravity);
    let once = after(|h| once.simulate(billiard_45(), Rattle::new(h)), 2.0, 200);
    let twice = Scene::on(Twice { a: 1.0, r: SURFACE.r }).with(gravity);
    let twice = after(|h| twice.simulate(billiard_45(), Rattle::new(h)), 2.0, 200);
    let doubled = Scene::on(Doubled { a: 1.0, r: SURFACE.r }).with(gravity);
    let doubled = after(|h| doubled.simulate(billiard_45(), Rattle::new(h)), 2.0, 200);
    for (name, other) in [("[g, g]", &twice), ("[g, 2 g]", &doubled)] {
        let difference = apart(&phase(&once.state()), &phase(&other.state()));
        println!("{name}: {difference:.1e}");
        assert!(difference <= 1e-12, "{name}: {difference:e}");
    }
    // Scaled to normals of length 1 both carry half: 2 g needs half the multiplier of g.
    let (whole, parts) = (once.multiplier(), doubled.multipliers());
    assert!(apart(&[whole / 2.0, whole / 4.0], &parts) <= 1e-10 * whole.abs(), "{whole} {parts:?}");
}

/// `.mass(1.0)` and the matrix 1 are the number 1.
#[test]
fn unit_masses_in_every_form() {
    let scene = Scene::points(3).link(Rod { length: 1.0 }, chain(2)).pin(0, [0.0, 0.0]);
    let scene = scene.with(PlanarGravity { g: 1.0 });
    let run = |mass: Mass<2>| {
        let scene = scene.clone().mass(mass);
        bits(&after(|h| scene.simulate(double_pendulum(), Rattle::new(h)), 2.0, 200).state())
    };
    let unit = run(Mass::Unit);
    assert_eq!(run(1.0.into()), unit);
    assert_eq!(run([1.0, 1.0].into()), unit);
    assert_eq!(run(Mass::Matrix([[1.0, 0.0], [0.0, 1.0]])), unit);
}

/// However often and when the number of bodies is said, each has a copy of what all had.
#[test]
fn each_body_has_a_copy_of_its_constraint() {
    let starts = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let momenta = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
    let end = |scene: Scene<rattle::network::Network<3>, (), rattle::bodies::Many, 3>| {
        let start = State::of(starts).with_momenta(momenta);
        let mut simulation = scene.simulate(start, Rattle::new(0.05)).unwrap();
        simulation.run(20).unwrap();
        assert_eq!(simulation.freedom(), 6);
        simulation.positions().map(|q| q.map(f64::to_bits)).collect::<Vec<_>>()
    };
    let sphere = || Scene::on(rattle::surfaces::Sphere { r: 1.0 });
    let right = end(sphere().bodies(3).mass(2.0));
    assert_eq!(end(sphere().mass(2.0).bodies(3)), right);
    assert_eq!(end(sphere().bodies(2).mass(2.0).bodies(3)), right);
    assert_eq!(end(sphere().bodies(5).mass(2.0).bodies(3)), right);
    assert_eq!(end(sphere().bodies(2).mass(2.0).bodies(7).mass(2.0).bodies(3)), right);
}
