//! Events inside steps: collisions, walls, slack strings, edges.
//!
//! | system | compared with | bound |
//! |---|---|---|
//! | a ball in a box, in a ring, on a floor | folded lines, chords, parabolas | rounding |
//! | balls in a row, two balls far faster than a step | exchanged and reflected velocities | rounding |
//! | a string between two bodies | the chords of relative motion | as above |
//! | restitution | energies, work | rounding |
//! | beads on a surface of genus two | energy, the way back | rounding, and what collisions make of it |
//! | a link with corners | constant speed around them | rounding |
//!
//! Edges of surfaces: `tests/kinks.rs`.

use crate::common::*;
use rattle::Error;
use rattle::bodies::Many;
use rattle::composition::SOFRONIOU_SPALETTA_2005_ORDER_10;
use rattle::effect::{HardSpheres, Stop};
use rattle::error::StepFailure;
use rattle::links::planar::Rod;
use rattle::potentials::planar;
use rattle::prelude::*;
use rattle::system::System;

constraint! {
    /// A straight wall: positive on the side to which (a, b) points.
    struct Side { a, b, c }
    |x, y| a * x + b * y - c
}
constraint! {
    /// A round wall.
    struct Ring { r }
    |x, y| x^2 + y^2 - r^2
}

/// Numbers between −1 and 1 without order, the same each time.
struct Draws(f64);

impl Draws {
    fn next(&mut self, r: f64) -> f64 {
        self.0 += 1.0;
        r * (2.0 * (43_758.545_3 * self.0.sin()).rem_euclid(1.0) - 1.0)
    }
}

type Plane<Y> = Simulation<Y, Rattle, 2>;

/// Bodies in the plane under gravity, all of one type.
fn plane(g: f64, masses: &[f64], start: State<2>, h: f64) -> Plane<impl System<f64, 2, Count = Many>> {
    let scene = Scene::points(start.len()).masses(masses.iter().copied()).with(planar::Gravity { g });
    scene.simulate(start, Rattle::new(h)).unwrap()
}

fn q<Y: System<f64, 2>>(simulation: &Plane<Y>, body: usize) -> [f64; 2] {
    simulation.positions().nth(body).unwrap().into()
}

fn p<Y: System<f64, 2>>(simulation: &Plane<Y>, body: usize) -> [f64; 2] {
    simulation.momenta().nth(body).unwrap().into()
}

/// x on a straight way that is folded between two walls.
fn folded(x: f64, low: f64, high: f64) -> f64 {
    let (wide, x) = (high - low, (x - low).rem_euclid(2.0 * (high - low)));
    low + if x > wide { 2.0 * wide - x } else { x }
}

#[test]
fn a_ball_in_a_box_follows_the_folded_line() {
    for h in [0.037, 0.5, 3.1] {
        let start = State::at([0.1, 0.2]).moving([1.0, 0.37]);
        let mut ball = plane(0.0, &[1.0], start, h);
        for wall in [(1.0, 0.0, -1.0), (-1.0, 0.0, -1.0), (0.0, 1.0, 0.0), (0.0, -1.0, -0.7)] {
            ball = ball.collide(Stop::above(Side { a: wall.0, b: wall.1, c: wall.2 })).unwrap();
        }
        for _ in 0..(300.0 / h) as u32 {
            ball.step().unwrap();
            let (t, [x, y]) = (ball.time(), q(&ball, 0));
            let exact = [folded(0.1 + t, -1.0, 1.0), folded(0.2 + 0.37 * t, 0.0, 0.7)];
            let off = (x - exact[0]).abs().max((y - exact[1]).abs());
            assert!(off < 1e-12, "h = {h}, t = {t}: {off:e}");
        }
        assert!((305..312).contains(&ball.events()), "{}", ball.events());
        assert!(ball.energy_error().abs() < 1e-15, "{:e}", ball.energy_error());
    }
}

/// In a circle every chord meets the wall at one angle.
#[test]
fn a_ball_in_a_round_box_follows_chords() {
    let ([x, y], [u, v]) = ([0.3, -0.2], [0.8_f64, 0.45]);
    let speed = u.hypot(v);
    // From the middle of the first chord, at a distance b from the centre.
    let b = (x * v - y * u) / speed;
    let before = -(x * u + y * v) / speed;
    let (half, first) = ((1.0 - b * b).sqrt(), v.atan2(u));
    let turn = 2.0 * b.abs().acos();
    for h in [0.02, 0.9] {
        let mut ball = plane(0.0, &[1.0], State::at([x, y]).moving([u, v]), h);
        ball = ball.collide(Stop::below(Ring { r: 1.0 })).unwrap();
        for _ in 0..(300.0 / h) as u32 {
            ball.step().unwrap();
            let along = speed * ball.time() - before + half;
            let chord = (along / (2.0 * half)).floor();
            let (rest, way) = (along - 2.0 * half * chord - half, first + b.signum() * turn * chord);
            let (sin, cos) = way.sin_cos();
            let exact = [rest * cos + b * sin, rest * sin - b * cos];
            let [x, y] = q(&ball, 0);
            let off = (x - exact[0]).hypot(y - exact[1]);
            assert!(off < 2e-12, "h = {h}, t = {}: {off:e}", ball.time());
        }
        assert!(ball.events() > 130 && ball.energy_error().abs() < 1e-14);
    }
}

/// Parabolas, which the method follows exactly: from height 1, down in √2, and up again.
#[test]
fn a_ball_on_a_floor_falls_and_rises() {
    for h in [0.01, 0.3, 1.5] {
        let start = State::at([0.0, 1.0]).moving([0.25, 0.0]);
        let ball = plane(1.0, &[2.0], start, h);
        // Weight is in proportion to mass 1, so that the ball of mass 2 falls at 1/2, for t = 2.
        let mut ball = ball.collide(Stop::above(Side { a: 0.0, b: 2.0, c: 0.0 })).unwrap();
        for _ in 0..(400.0 / h) as u32 {
            ball.step().unwrap();
            let phase = (ball.time() + 2.0).rem_euclid(4.0) - 2.0;
            let off = (q(&ball, 0)[1] - (1.0 - 0.25 * phase * phase)).abs();
            assert!(off < 1e-12, "h = {h}, t = {}: {off:e}", ball.time());
        }
        let impacts = ((ball.time() + 2.0) / 4.0).floor() as u64;
        assert_eq!(ball.events(), impacts, "h = {h}");
        assert!(ball.energy_error().abs() < 1e-14, "{:e}", ball.energy_error());
    }
}

#[test]
fn restitution_takes_its_share_and_books_it() {
    let start = State::at([0.0, 1.0]).moving([0.3, 0.0]);
    let mut ball = plane(1.0, &[1.0], start, 0.05);
    ball = ball.collide(Stop::above(Side { a: 0.0, b: 1.0, c: 0.0 }).restitution(0.5)).unwrap();
    let (height, work) = (|n: i32| 0.25_f64.powi(n), |n: i32| 0.25_f64.powi(n) - 1.0);
    // Each bounce takes half as long as the last, so that the ball is at rest at t = 3 √2, in step 85.
    let error = loop {
        let was = (bits(&ball.state()), ball.events(), ball.steps());
        if let Err(error) = ball.step() {
            assert_eq!(
                was,
                (bits(&ball.state()), ball.events(), ball.steps()),
                "a step that fails leaves no trace"
            );
            break error;
        }
        let now = ball.events() as i32;
        let energy = ball.energy() - 0.045;
        assert!((energy - height(now)).abs() < 4e-16, "{now}: {energy:e} {:e}", height(now));
        assert!((ball.work() - work(now)).abs() < 4e-16 && ball.energy_error().abs() < 4e-16);
    };
    assert!(ball.steps() == 84 && ball.events() > 5, "{} {}", ball.steps(), ball.events());
    let Error::Step { cause: StepFailure::Rests { contact: "Side", ref bodies, .. }, .. } = error else {
        panic!("{error}")
    };
    assert!(bodies == &[0] && error.to_string().contains("must be held by a link"), "{error}");
}

#[test]
fn balls_in_a_row_hand_a_blow_on() {
    for (gap, e) in [(0.0, 1.0), (0.1, 1.0), (0.0, 0.0)] {
        let places = [0.0, 1.3, 1.8 + gap, 2.3 + 2.0 * gap].map(|x| [x, 0.0]);
        let start = State::of(places).with_momenta([[1.0, 0.0], [0.0; 2], [0.0; 2], [0.0; 2]]);
        let spheres = HardSpheres::new(0.5).restitution(e);
        let mut row = plane(0.0, &[1.0; 4], start, 0.4).collide(spheres).unwrap();
        row.run(5).unwrap();
        let speeds: Vec<f64> = (0..4).map(|i| p(&row, i)[0]).collect();
        if e == 1.0 {
            // Impulses have twice the digits.
            let wrong = |(v, exact): (&f64, f64)| (v - exact).abs() > f64::EPSILON.powi(2);
            assert!(!speeds.iter().zip([0.0, 0.0, 0.0, 1.0]).any(wrong), "{speeds:?}");
            assert_eq!(row.events(), 3);
            assert!((q(&row, 3)[0] - (2.0 - 0.8 + 2.3)).abs() < 4e-15);
        } else {
            assert!(speeds.iter().all(|v| (v - 0.25).abs() < 1e-15), "{speeds:?}");
            assert!((row.work() + 0.375).abs() < 1e-15 && row.energy_error().abs() < 1e-15);
        }
    }
}

/// Two balls that pass through each other many times over in one step, and back within it, unless they are seen to
/// meet.
#[test]
fn fast_balls_do_not_tunnel() {
    let mut draws = Draws(0.0);
    let (mut met, mut passed) = (0, 0);
    while met < 200 || passed < 50 {
        let d = 0.05;
        let mut draw = |r: f64| [draws.next(r), draws.next(r)];
        let (a, b, u) = (draw(1.0), draw(1.0), draw(20.0));
        // Aimed at the other one, to pass by 1.3 diameters at most.
        let aim = draw(1.3 * d);
        let v = [0, 1].map(|i| u[i] + 8.0 * (a[i] + aim[i] - b[i]));
        let masses = [1.0, 2.5];
        let start = State::of([a, b]).with_momenta([u, v.map(|v| 2.5 * v)]);
        let h = [0.05, 0.4, 1.0][met as usize % 3];
        let (r, w) = ([0, 1].map(|i| a[i] - b[i]), [0, 1].map(|i| u[i] - v[i]));
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        if dot(r, r) < d * d {
            continue;
        }
        let pair = || plane(0.0, &masses, start.clone(), h);
        let mut balls = pair().collide(HardSpheres::new(d)).unwrap();
        balls.run_until(1.0).unwrap();
        let under = dot(r, w).powi(2) - dot(w, w) * (dot(r, r) - d * d);
        if under < 0.0 || dot(r, w) > 0.0 {
            let mut free = pair();
            free.run_until(1.0).unwrap();
            assert_eq!(
                (balls.events(), bits(&balls.state())),
                (0, bits(&free.state())),
                "to the bit as without contacts"
            );
            passed += 1;
            continue;
        }
        let t = (-dot(r, w) - under.sqrt()) / dot(w, w);
        let n = [0, 1].map(|i| (r[i] + t * w[i]) / d);
        let impulse = 2.0 * dot(n, w) / (1.0 + 1.0 / 2.5);
        let (rest, graze) = (balls.time() - t, (under.sqrt() / dot(w, w).sqrt() / d).max(1e-9));
        for i in 0..2 {
            let exact = a[i] + u[i] * t + rest * (u[i] - impulse * n[i]);
            // The gap is landed on to 2 τ, τ = ε Σ|∂gap|(|q| + way); over d and the cosine that turns n, and the
            // velocity after by 16 ε (1 + 3 way); as much for the formulas here.
            let way = 1.25 * h * [u, v].map(|v| dot(v, v).sqrt()).iter().fold(0.0_f64, |a, b| a.max(*b));
            let bound = 32.0 * f64::EPSILON * (1.0 + 3.0 * way) * dot(w, w).sqrt() / d / graze;
            assert!((q(&balls, 0)[i] - exact).abs() < bound, "{} {exact}, {bound:e}", q(&balls, 0)[i]);
        }
        assert_eq!(balls.events(), 1);
        assert!(balls.energy_error().abs() < 1e-12 && balls.work() == 0.0);
        met += 1;
    }
}

/// Two bodies on a string: their centre goes straight on, and relative motion is that in a round box.
#[test]
fn a_string_goes_slack_and_tightens() {
    let masses = [1.0, 3.0];
    for (h, members) in [(0.01, [[0, 1]]), (0.7, [[1, 0]])] {
        let start = State::of([[0.0, 0.0], [0.3, 0.4]]).with_momenta([[0.2, 0.1], [-0.3, 1.2]]);
        let string = Stop::below(Rod { length: 1.0 }).over(members);
        let mut pair = plane(0.0, &masses, start, h).collide(string).unwrap();
        let (mut r, mut w, mut since) = ([0.3, 0.4], [-0.3, 0.3], 0.0_f64);
        let (mut tight, mut longest) = (0, 0.0_f64);
        for _ in 0..(100.0 / h) as u32 {
            pair.step().unwrap();
            // The instants at which the string tightens, one after the other, by the formula of roots.
            loop {
                let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
                let (rw, ww) = (dot(r, w), dot(w, w));
                let next = (-rw + (rw * rw + ww * (1.0 - dot(r, r))).sqrt()) / ww;
                if since + next > pair.time() {
                    break;
                }
                r = [0, 1].map(|i| r[i] + next * w[i]);
                let along = 2.0 * (r[0] * w[0] + r[1] * w[1]);
                w = [0, 1].map(|i| w[i] - along * r[i]);
                (since, tight) = (since + next, tight + 1);
            }
            let (a, b, t) = (q(&pair, 0), q(&pair, 1), pair.time() - since);
            for i in 0..2 {
                assert!((b[i] - a[i] - (r[i] + t * w[i])).abs() < 2e-12, "h = {h}, t = {}", pair.time());
                let centre = [0.225, 0.3][i] + pair.time() * [-0.025, 0.325][i];
                assert!((0.25 * a[i] + 0.75 * b[i] - centre).abs() < 1e-13);
            }
            longest = longest.max((b[0] - a[0]).hypot(b[1] - a[1]));
        }
        assert_eq!(pair.events(), tight);
        assert!(tight > 10 && longest <= 1.0 + 1e-15, "{tight}, {longest}");
        assert!(pair.energy_error().abs() < 1e-14);
    }
}

#[test]
fn what_makes_no_sense_is_refused() {
    let pair = || plane(0.0, &[1.0; 2], State::of([[0.0, 0.0], [1.0, 0.0]]), 0.1);
    let told = |refused: Result<Plane<_>, Error>| refused.map(|_| ()).unwrap_err();
    let error = told(pair().collide(HardSpheres::new(1.5)));
    assert!(
        matches!(&error, Error::Overlap { contact: "HardSpheres", bodies, .. } if bodies == &[0, 1]),
        "{error}"
    );
    assert!(matches!(told(pair().collide(HardSpheres::new(f64::NAN))), Error::Diameter(_)));
    assert!(matches!(told(pair().collide(HardSpheres::new(0.5).restitution(1.5))), Error::Restitution(1.5)));
    for member in [[0, 2], [1, 1]] {
        let error = told(pair().collide(Stop::below(Rod { length: 2.0 }).over([member])));
        assert!(matches!(error, Error::Network(_)), "{error}");
    }
    // A ball that lies on the floor under gravity.
    let lying = plane(1.0, &[1.0], State::at([0.0, 0.0]), 0.1);
    let error = lying.collide(Stop::above(Side { a: 0.0, b: 1.0, c: 0.0 })).unwrap().step().unwrap_err();
    assert!(matches!(error, Error::Step { cause: StepFailure::Rests { .. }, .. }), "{error}");
}

const GAS: Lemniscate = Lemniscate { a: 1.0, r: 1.0 / 6.0 };

/// Beads on the lemniscate surface that do not overlap.
fn beads(number: usize, diameter: f64, h: f64) -> Simulation<impl System<f64, 3>, Composition<Rattle>, 3> {
    let (mut draws, one) = (Draws(0.0), Scene::on(GAS));
    let mut places: Vec<([f64; 3], [f64; 3])> = Vec::new();
    while places.len() < number {
        let mut draw = |r: f64| [(); 3].map(|()| draws.next(r));
        let (q, p) = (draw(1.0), draw(1.0));
        let Ok(state) = one.project(&State::at([q[0], 0.5 * q[1], 0.2 * q[2]]).moving(p)) else { continue };
        let [q, p] = [state.positions().next().unwrap(), state.momenta().next().unwrap()];
        if places.iter().all(|(other, _)| (q - nalgebra::Vector3::from(*other)).norm() > 1.01 * diameter) {
            places.push((q.into(), p.into()));
        }
    }
    let start =
        State::of(places.iter().map(|place| place.0)).with_momenta(places.iter().map(|place| place.1));
    let gas = Scene::on(GAS)
        .bodies(number)
        .simulate(start, Composition::new(SOFRONIOU_SPALETTA_2005_ORDER_10, h))
        .unwrap();
    gas.collide(HardSpheres::new(diameter)).unwrap()
}

fn gas_keeps_its_energy(collisions: u64, bound: f64) {
    let mut gas = beads(16, 0.12, 0.003);
    let energy = gas.energy();
    let (mut worst, mut nearest) = (0.0_f64, f64::INFINITY);
    while gas.events() < collisions {
        gas.run(50).unwrap();
        worst = worst.max(gas.energy_error().abs() / energy);
        let q: Vec<_> = gas.positions().collect();
        let pairs = (0..q.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        nearest = pairs.fold(nearest, |least, (i, j)| least.min((q[i] - q[j]).norm()));
    }
    println!("{} collisions in {} steps, energy {worst:e}, nearest {nearest}", gas.events(), gas.steps());
    assert!(worst < bound && nearest > 0.12 * (1.0 - 1e-12) && gas.constraint_residual() < 1e-15);
}

#[test]
#[cfg(long)]
fn a_gas_of_beads_keeps_its_energy() {
    // Without optimisation a tenth of them.
    gas_keeps_its_energy(2000, 1e-13);
}

/// `cargo long --test motion events:: -- --ignored --nocapture`
#[test]
#[cfg(long)]
#[ignore = "takes minutes"]
fn a_gas_of_beads_keeps_its_energy_for_long() {
    gas_keeps_its_energy(100_000, 1e-12);
}

/// Each collision multiplies rounding by some two free ways over a diameter, for the two that take part.
#[test]
#[cfg(long)]
fn a_gas_of_beads_runs_back() {
    let mut gas = beads(30, 0.16, 0.02);
    let start = gas.state();
    gas.run_while(10_000, |now| now.events() < 100).unwrap();
    let (there, steps, number) = (gas.state(), gas.steps(), gas.events());
    let back: Vec<_> = there.momenta().map(|p| -p).collect();
    let scene = Scene::on(GAS).bodies(30);
    let turned = State::of(there.positions()).with_momenta(back);
    let mut gas = scene
        .simulate(turned, Composition::new(SOFRONIOU_SPALETTA_2005_ORDER_10, 0.02))
        .unwrap()
        .collide(HardSpheres::new(0.16))
        .unwrap();
    gas.run(steps).unwrap();
    let off = gas.positions().zip(start.positions()).map(|(a, b)| distance(a, b)).fold(0.0, f64::max);
    println!("{number} collisions in {steps} steps: {off:e}");
    assert!(gas.events() == number && off < 1e-9, "{} {number} {off:e}", gas.events());
}

constraint! {
    /// A rod whose length is the sum of its sides.
    struct Sides { length }
    |a: [f64; 2], b: [f64; 2]| abs(a[0] - b[0]) + abs(a[1] - b[1]) - length
}

/// The relative place of two bodies runs around a square at constant speed: masses decide what is across the edge.
#[test]
fn links_go_over_their_edges() {
    for (h, masses) in [(0.01, [1.0, 1.0]), (0.3, [1.0, 5.0])] {
        let scene = Scene::points(2).masses(masses).with(planar::Gravity { g: 0.0 });
        let start = State::of([[0.5, 0.1], [0.1, -0.5]]).with_momenta([[0.3, 0.1], [0.2, 0.6]]);
        let scene = scene.link(Sides { length: 1.0 }, [[0, 1]]);
        let start = scene.project(&start).unwrap();
        let pair = scene.simulate(start, Rattle::new(h)).unwrap();
        let between = |pair: &Plane<_>| [0, 1].map(|i| q(pair, 0)[i] - q(pair, 1)[i]);
        let (r, v) =
            (between(&pair), [0, 1].map(|i| p(&pair, 0)[i] / masses[0] - p(&pair, 1)[i] / masses[1]));
        // From corner to corner in 1/|ẋ|, counted from the corner (1, 0) through (0, 1).
        let around = |[x, y]: [f64; 2]| if y >= 0.0 { 1.0 - x } else { 3.0 + x };
        let speed = if around([r[0] + 1e-3 * v[0], r[1] + 1e-3 * v[1]]) > around(r) {
            v[0].abs()
        } else {
            -v[0].abs()
        };
        let mut pair = pair.over_kinks().unwrap();
        for _ in 0..(100.0 / h) as u32 {
            pair.step().unwrap();
            let off = (around(between(&pair)) - around(r) - speed * pair.time() + 2.0).rem_euclid(4.0) - 2.0;
            assert!(off.abs() < 1e-12, "h = {h}, t = {}: {off:e}", pair.time());
        }
        assert!(pair.events() > 10 && pair.energy_error().abs() < 1e-14, "{}", pair.events());
    }
}

/// The blow goes through the rod: a pendulum swings to and fro between a wall and itself, and its momentum stays
/// along the circle.
#[test]
fn impacts_act_along_constraints() {
    let scene = Scene::points(2).masses([1.0, 3.0]).with(planar::Gravity { g: 0.0 });
    let scene = scene.link(Rod { length: 1.0 }, [[0, 1]]).pin(0, [0.0; 2]);
    let start = State::of([[0.0, 0.0], [0.6, 0.8]]).with_momenta([[0.0, 0.0], [-2.4, 1.8]]);
    let pendulum = scene.simulate(start, Rattle::new(0.05)).unwrap();
    let mut pendulum = pendulum.collide(Stop::above(Side { a: 1.0, b: 0.5, c: -0.3 })).unwrap();
    pendulum.run_while(100_000, |now| now.events() < 100).unwrap();
    // Some thousand roundings of 1e-17; the last bit of an impulse, the same at the same place, would make 1e-14 of
    // them.
    assert!(pendulum.energy_error().abs() < 2e-15 && pendulum.cotangent_residual() < 1e-15);
    assert!(pendulum.constraint_residual() < 1e-15 && p(&pendulum, 0) == [0.0; 2]);
    let (steps, [x, y]) = (pendulum.steps(), q(&pendulum, 1));
    assert!(x + 0.5 * y + 0.3 >= 0.0);
    let back = pendulum.momenta().map(|p| -p).collect::<Vec<_>>();
    let turned = State::of(pendulum.positions()).with_momenta(back);
    let back = scene.simulate(turned, Rattle::new(0.05)).unwrap();
    let mut back = back.collide(Stop::above(Side { a: 1.0, b: 0.5, c: -0.3 })).unwrap();
    back.run(steps).unwrap();
    assert!((q(&back, 1)[0] - 0.6).abs() < 5e-13 && back.events() == pendulum.events());
}
