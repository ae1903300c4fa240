//! Long chains, cost, memory, restarts; constraints that move, and their work.

use crate::common::linked::*;
use crate::common::*;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::links::planar::TurningLine;
use rattle::network::LinearAlgebra::{self, Elimination, Orthogonal};
use rattle::prelude::*;

/// A chain of N links of total length 1 and mass 1, falling from the horizontal. Returns the largest |ΔE|, relative
/// link error, and corrections per step.
fn falling_chain(links: usize, h: f64, t: f64) -> (f64, f64, f64) {
    let (length, mass) = (1.0 / links as f64, 1.0 / links as f64);
    let scene = Scene::points(links + 1)
        .link(Rod { length }, chain(links))
        .pin(0, [0.0, 0.0])
        .mass(mass)
        .with(PlanarGravity { g: mass });
    let start = State::of((0..=links).map(|i| [i as f64 * length, 0.0]));
    let start = scene.project(&start).unwrap(); // i/N is rounded
    let mut simulation = scene.simulate(start, Rattle::new(h)).unwrap();
    let report = simulation.system().components().next().unwrap();
    assert_eq!((report.by, report.fill), (Elimination, 0), "{report}");
    let (mut energy, mut off) = (0.0_f64, 0.0_f64);
    let steps = (t / h).round() as u64;
    for _ in 0..steps / 100 {
        simulation.run(100).unwrap();
        energy = energy.max(simulation.energy_error().abs());
        off = off.max(simulation.constraint_residual() / (2.0 * length * length));
    }
    let counts = simulation.counts();
    assert_eq!(counts.solves, steps);
    (energy, off, counts.corrections as f64 / steps as f64)
}

/// The numbers of the reference study; a tolerance that rounding cannot reach would take 16 corrections.
#[test]
#[cfg(long)]
fn a_chain_of_a_thousand_links() {
    let (energy, off, corrections) = falling_chain(1000, 2e-4, 2.0);
    println!("1000 links, h = 2e-4: |ΔE| {energy:.1e}, links {off:.1e}, {corrections:.3} corrections");
    assert!(energy <= 2e-5 && off <= 5e-13 && corrections <= 2.5, "{energy:e} {off:e} {corrections}");
    let (energy, off, corrections) = falling_chain(1000, 5e-5, 1.0);
    println!("1000 links, h = 5e-5: |ΔE| {energy:.1e}, links {off:.1e}, {corrections:.3} corrections");
    assert!(energy <= 1e-9 && off <= 5e-13 && corrections <= 2.5, "{energy:e} {off:e} {corrections}");
}

constraint! {
    /// A rod that grows.
    struct GrowingRod { length, rate }
    |a: [f64; 2], b: [f64; 2], t| sum(i in 0..2, (a[i] - b[i])^2) - (length + rate * t)^2
}

/// Scenes of every kind, each with a start.
fn scenes() -> Vec<(&'static str, Box<dyn Run>)> {
    let h = 0.01;
    let plane = |algebra: LinearAlgebra| {
        Scene::points(12)
            .link(Rod { length: 1.0 }, chain(11))
            .pin(0, [0.0, 0.0])
            .linear_algebra(algebra)
            .with(PlanarGravity { g: 1.0 })
    };
    let zigzag = State::of((0..12).map(|i| [0.8 * f64::from(i), 0.6 * f64::from(i % 2)]));
    let growing = Scene::points(3)
        .link_moving(GrowingRod { length: 1.0, rate: 0.1 }, chain(2))
        .pin(0, [0.0, 0.0])
        .with(PlanarGravity { g: 1.0 });
    let grown = growing.project(&double_pendulum().at_time(0.3)).unwrap();
    let surfaces = Scene::on(SURFACE).bodies(2).with(Ricker { depth: 0.5, radius: SURFACE.r }).mass(2.0);
    let f = 0.1_f64.powi(4) - 0.1_f64.powi(2);
    let two = State::of([[0.0, 0.0, SURFACE.r], [0.1, 0.0, (1.0 / 36.0 - f * f).sqrt()]])
        .with_momenta([[0.3, 0.4, 0.0], [0.0; 3]]);
    let triangle = Scene::points(4)
        .link(Rod { length: 1.0 }, [[0, 1], [1, 2], [2, 0], [2, 3]])
        .with(PlanarGravity { g: 1.0 });
    let bent =
        triangle.project(&State::of([[0.0, 0.0], [1.0, 0.0], [0.5, 0.9], [1.0, 1.6]]).moving([0.1, 0.3]));
    let suzuki = Composition::new(SUZUKI_1990_ORDER_4, h);
    vec![
        ("chain by elimination", run(&plane(Elimination), zigzag.clone(), Rattle::new(h))),
        ("chain by a basis", run(&plane(Orthogonal), zigzag, suzuki)),
        ("moving", run(&growing, grown.clone(), Rattle::new(h))),
        ("moving, composed", run(&growing, grown, suzuki)),
        ("surfaces", run(&surfaces, two, Rattle::new(h))),
        ("triangle", run(&triangle, bent.unwrap(), Rattle::new(h))),
    ]
}

/// A scene that can be run from its start, or from any state of it.
trait Run {
    fn bits(&self, parts: &[u64]) -> String;
    fn allocations(&self, steps: u64) -> u64;
}

fn run<E: rattle::effect::Effects<D> + Clone + 'static, S: Method + 'static, const D: usize>(
    scene: &Scene<rattle::network::Network<D>, E, rattle::bodies::Many, D>,
    start: State<D>,
    method: S,
) -> Box<dyn Run> {
    Box::new((scene.clone(), start, method))
}

impl<E: rattle::effect::Effects<D> + Clone, S: Method, const D: usize> Run
    for (Scene<rattle::network::Network<D>, E, rattle::bodies::Many, D>, State<D>, S)
{
    /// The bits of the state after all parts, each begun from the state that the last one ended with.
    fn bits(&self, parts: &[u64]) -> String {
        let mut state = self.1.clone();
        for &steps in parts {
            let mut simulation = self.0.simulate(state, self.2.clone()).unwrap();
            simulation.run(steps).unwrap();
            state = simulation.state();
        }
        assert!(apart(&phase(&state), &phase(&self.1)) > 1e-3, "it moved");
        bits(&state)
    }

    fn allocations(&self, steps: u64) -> u64 {
        let mut simulation = self.0.simulate(self.1.clone(), self.2.clone()).unwrap();
        let allocated = allocation_counter::measure(|| simulation.run(steps).unwrap());
        assert_eq!(simulation.steps(), steps);
        allocated.count_total
    }
}

#[test]
fn a_step_of_linked_bodies_does_not_allocate() {
    for (name, scene) in scenes() {
        assert_eq!(scene.allocations(100), 0, "{name}");
    }
    assert!(
        allocation_counter::measure(|| drop(std::hint::black_box(double_pendulum()))).count_total > 0,
        "the counter counts"
    );
}

#[test]
fn linked_bodies_go_on_bit_for_bit() {
    for (name, scene) in scenes() {
        let whole = scene.bits(&[100]);
        assert_eq!(scene.bits(&[100]), whole, "{name}: the same run twice");
        assert_eq!(scene.bits(&[37, 1, 62]), whole, "{name}: in parts");
        assert_ne!(scene.bits(&[99]), whole, "{name}: the comparison sees a difference");
    }
}

constraint! {
    /// A sphere that grows.
    struct Balloon { radius, rate }
    |x, y, z, t| x^2 + y^2 + z^2 - (radius + rate * t)^2
}

/// Free motion on r = 1 + at keeps its angular momentum L: θ = L t/(1 + at).
#[test]
fn on_a_sphere_that_grows() {
    let (rate, spin, t) = (0.5, 1.2, 2.0);
    let scene = Scene::points(1).link_moving(Balloon { radius: 1.0, rate }, [[0]]);
    let start = State::of([[1.0, 0.0, 0.0]]).moving([rate, spin, 0.0]);
    let (radius, angle) = (1.0 + rate * t, spin * t / (1.0 + rate * t));
    let exact = [radius * angle.cos(), radius * angle.sin(), 0.0];
    let work = 0.5 * (spin / radius).powi(2) - 0.5 * spin.powi(2);
    let measure = |n: u32| {
        let done = after(|h| scene.simulate(start.clone(), Rattle::new(h)), t, n);
        // The velocity fits the motion of the sphere, to rounding.
        assert!(done.cotangent_residual() <= 8.0 * f64::EPSILON, "{:e}", done.cotangent_residual());
        assert!(done.constraint_residual() <= 8.0 * f64::EPSILON, "{:e}", done.constraint_residual());
        [apart(&coordinates(&done.state()), &exact), done.energy_error().abs(), (done.work() - work).abs()]
    };
    let [a, b, c] = [100, 200, 400].map(measure);
    for (i, what) in ["position", "energy balance", "work"].iter().enumerate() {
        println!("balloon, {what}: {:?}", [a[i], b[i], c[i]]);
        check_ratios(what, [a[i], b[i], c[i]], 2);
    }
}

/// A bead on a turning rod: r = cosh ωt; the rod does the work ω² sinh² ωt.
#[test]
fn on_a_turning_rod() {
    let (omega, t) = (0.8, 1.5);
    let scene = Scene::points(1).link_moving(TurningLine { omega }, [[0]]);
    let start = State::of([[1.0, 0.0]]).moving([0.0, omega]);
    let (r, angle) = (f64::cosh(omega * t), omega * t);
    let exact = [r * angle.cos(), r * angle.sin()];
    let work = (omega * f64::sinh(omega * t)).powi(2);
    for (order, steps) in [(2, 100), (4, 20)] {
        let measure = |n: u32| {
            let (q, balance, done) = if order == 2 {
                let done = after(|h| scene.simulate(start.clone(), Rattle::new(h)), t, n);
                (coordinates(&done.state()), done.energy_error(), done.work())
            } else {
                let suzuki = |h| scene.simulate(start.clone(), Composition::new(SUZUKI_1990_ORDER_4, h));
                let done = after(suzuki, t, n);
                (coordinates(&done.state()), done.energy_error(), done.work())
            };
            [apart(&q, &exact), balance.abs(), (done - work).abs()]
        };
        let [a, b, c] = [steps, 2 * steps, 4 * steps].map(measure);
        for (i, what) in ["position", "energy balance", "work"].iter().enumerate() {
            println!("turning rod, order {order}, {what}: {:?}", [a[i], b[i], c[i]]);
            check_ratios(what, [a[i], b[i], c[i]], order);
        }
    }
}

constraint! {
    /// A hoop of radius 1 that turns about the vertical.
    struct Hoop { omega }
    |x, y, z, t| [x^2 + y^2 + z^2 - 1, y * cos(omega * t) - x * sin(omega * t)]
}

/// A bead on a turning hoop keeps Jacobi's integral E − ω L_z, which knows nothing of how work is summed.
#[test]
fn on_a_turning_hoop() {
    let omega = 1.3;
    let scene = Scene::points(1).link_moving(Hoop { omega }, [[0]]).with(Gravity { g: 1.0 });
    let start = State::of([[0.6, 0.0, -0.8]]).moving([0.0, 0.6 * omega, 0.0]);
    let measure = |n: u32| {
        let mut simulation = scene.simulate(start.clone(), Rattle::new(4.0 / f64::from(n))).unwrap();
        let jacobi = |now: &Simulation<_, _, 3>| -> f64 {
            let (q, p) = (now.positions().next().unwrap(), now.momenta().next().unwrap());
            now.energy() - omega * (q.x * p.y - q.y * p.x)
        };
        let before = jacobi(&simulation);
        let mut worst = [0.0_f64; 3];
        simulation
            .run_with(u64::from(n), |now| {
                worst[0] = worst[0].max((jacobi(now) - before).abs());
                worst[1] = worst[1].max(now.energy_error().abs());
                worst[2] = worst[2].max(now.work().abs());
            })
            .unwrap();
        worst
    };
    let [a, b, c] = [200, 400, 800].map(measure);
    println!("hoop: {a:?} {b:?} {c:?}");
    assert!(c[2] > 0.1, "the hoop works: {c:?}");
    check_ratios("Jacobi's integral", [a[0], b[0], c[0]], 2);
    check_ratios("energy balance", [a[1], b[1], c[1]], 2);
}

constraint! {
    /// Two walls that begin to move gently.
    struct Walls {}
    |x, y, t| [x - t^2, y - t^3]
}

/// A body that rests at the origin when its constraints begin to move has no path and no size yet.
#[test]
fn pushed_from_rest() {
    let scene = Scene::points(1).link_moving(Walls {}, [[0]]);
    let mut simulation = scene.simulate(State::of([[0.0, 0.0]]), Rattle::new(0.01)).unwrap();
    simulation.run(100).unwrap();
    assert!(distance(simulation.positions().next().unwrap(), [1.0, 1.0]) <= 1e-15);
    assert!(distance(simulation.momenta().next().unwrap(), [2.0, 3.0]) <= 1e-14);
}

/// Nothing moves, in any position, with any rounding of g there; the flatter the rhombus, the further rounding goes.
#[test]
fn rest_without_forces_is_no_failure() {
    let scene = Scene::points(4).link(Rod { length: 1.0 }, [[0, 1], [1, 2], [2, 3], [3, 0]]);
    let mut rested = 0;
    for i in 0..100 {
        let (sin, cos) = (0.1 + f64::from(i)).sin_cos();
        let rhombus = State::of([[0.3, 0.1], [0.3 + cos, 0.1 + sin], [cos - 0.4, 1.0 + sin], [-0.4, 0.9]]);
        let Ok(start) = scene.project(&rhombus) else { continue };
        let mut simulation = scene.simulate(start.clone(), Rattle::new(0.01)).unwrap();
        simulation.run(100).unwrap_or_else(|error| panic!("{i}: {error}"));
        let q: Vec<_> = start.positions().collect();
        let flatness = (q[1] - q[0]).perp(&(q[3] - q[0])).abs();
        let moved = apart(&phase(&simulation.state()), &phase(&start));
        assert!(moved <= 2.0 * f64::EPSILON / flatness, "{i}: {moved:e}, {flatness}");
        rested += 1;
    }
    assert!(rested > 50, "{rested}");
}

#[test]
fn moving_constraints_go_back_the_way_they_came() {
    let scene = Scene::points(3)
        .link_moving(GrowingRod { length: 1.0, rate: 0.1 }, chain(2))
        .pin(0, [0.0, 0.0])
        .with(PlanarGravity { g: 1.0 });
    let start = scene.project(&double_pendulum().at_time(0.3)).unwrap();
    let there = after(|h| scene.simulate(start.clone(), Rattle::new(h)), 1.0, 100);
    let back = after(|h| scene.simulate(there.state(), Rattle::new(h)), -1.0, 100);
    let error = apart(&phase(&back.state()), &phase(&start));
    println!("moving, there and back: {error:.1e}; work {:.2e} {:.2e}", there.work(), back.work());
    assert!(error <= 1e-13 && (back.time() - 0.3).abs() <= 1e-16, "{error:e}");
    assert!(there.work().abs() > 0.01 && (there.work() + back.work()).abs() <= 1e-13, "the work is undone");
}

/// μ of one step and λ of the next, each of first order with errors that cancel; in the order of naming, also where
/// equations of two components take turns.
#[test]
fn recorded_multipliers_are_in_the_order_of_naming() {
    let rods = [[0, 1], [2, 3], [1, 4], [3, 5]];
    let lengths = [1.0, 0.5, 0.8, 1.2];
    let scene = Scene::points(6)
        .link_each(lengths.map(|length| Rod { length }).into_iter().zip(rods))
        .pin(0, [0.0, 0.0])
        .pin(2, [5.0, 0.0])
        .with(PlanarGravity { g: 1.0 });
    let q = [[0.0, 0.0], [1.0, 0.0], [5.0, 0.0], [5.0, 0.5], [1.0, 0.8], [6.2, 0.5]];
    let error = |n: u32| {
        let mut simulation = scene.simulate(State::of(q), Rattle::new(1.0 / f64::from(n))).unwrap();
        assert_eq!(simulation.system().components().len(), 2);
        let mut trajectory = Trajectory::with_multipliers(&simulation);
        simulation.observe(u64::from(n), 1, &mut trajectory).unwrap();
        let exact = simulation.multipliers();
        simulation.observe(1, 1, &mut trajectory).unwrap();
        let found = trajectory.multipliers().unwrap();
        let row = 4 * n as usize;
        let mean: Vec<f64> =
            (0..4).map(|i| 0.5 * (found.momentum[row + i] + found.position[row + 4 + i])).collect();
        assert!(exact.iter().all(|x| x.abs() > 0.05), "{exact:?}");
        apart(&mean, &exact)
    };
    let errors = [200, 400, 800].map(error);
    println!("recorded multipliers: {errors:?}");
    check_ratios("λ", errors, 2);
}

/// A chain that hangs still: every rod carries what is below it, the pin all of it.
#[test]
fn constraint_forces_are_in_the_unit_of_force() {
    let masses = [1.0, 2.0, 0.5, 3.0];
    for algebra in [Orthogonal, Elimination] {
        let scene = Scene::points(4)
            .link(Rod { length: 1.0 }, chain(3))
            .pin(0, [0.0, 0.0])
            .masses(masses)
            .linear_algebra(algebra)
            .with(weights(&masses));
        let start = State::of((0..4).map(|i| [0.0, -f64::from(i)]));
        let mut simulation = scene.simulate(start.clone(), Rattle::new(0.01)).unwrap();
        simulation.run(10).unwrap();
        assert!(apart(&phase(&simulation.state()), &phase(&start)) <= 1e-15);
        let forces: Vec<f64> = simulation.constraint_forces().iter().map(|force| force.y).collect();
        assert!(apart(&forces, &[-5.5, 2.0, 0.5, 3.0]) <= 1e-14, "{forces:?}");
        // F = 2 λ · length for a rod of length 1.
        assert!(
            apart(&simulation.multipliers(), &[-2.75, -1.75, -1.5]) <= 1e-14,
            "{:?}",
            simulation.multipliers()
        );
    }
}

constraint! {
    /// A line that falls off to the right.
    struct Slope {}
    |x, y| y + x / 2
}

/// A bead that its slope pushes along y only, tied by a rod to another: the slope's equation feels the rod along x too.
#[test]
fn a_multiplier_on_chosen_coordinates_among_others() {
    let start = State::of([[0.0, 0.0], [0.6, -0.8]]);
    let scene = Scene::points(2)
        .link(Rod { length: 1.0 }, [[0, 1]])
        .link_acting(Slope {}, [[0]], [[false, true]])
        .with(PlanarGravity { g: 1.0 });
    let ends = [Orthogonal, Elimination].map(|algebra| {
        let scene = scene.clone().linear_algebra(algebra);
        let done = after(|h| scene.simulate(start.clone(), Rattle::new(h)), 0.5, 100);
        assert!(done.constraint_residual() <= 1e-15 && done.cotangent_residual() <= 1e-15);
        phase(&done.state())
    });
    assert!(apart(&ends[0], &ends[1]) <= 1e-13, "{ends:?}");
    // At rest: with r = (0.6, −0.8) the rod pulls body 0 by T r and body 1 by −T r, the slope lifts body 0 by N.
    //   rod     (T r + (0, N)) · r = −T r · r              2 T = 0.8 N
    //   slope   T r_y + N − 1 + T r_x/2 = 0                N − 0.5 T = 1
    let (tension, lift) = (0.5, 1.25);
    let simulation = scene.simulate(start, Rattle::new(0.01)).unwrap();
    // ∇g of the rod on body 0 is −2 r.
    let multipliers = simulation.multipliers();
    assert!(apart(&multipliers, &[-tension / 2.0, lift]) <= 1e-15, "{multipliers:?}");
}

pair_potential! {
    struct Repulsion { strength }
    |r| strength * exp(-r^2)
}

/// Random networks, in lanes and as simulations: links that close loops, masses over two decades, pins, forces between
/// all bodies, steps from 1e-3 to 0.2. Both end at the same places, or both fail; only in steps far too long may one go
/// on where the other does not.
#[test]
#[cfg(long)]
fn random_networks_in_lanes_are_simulations() {
    let mut random = StdRng::seed_from_u64(1);
    let (mut agree, mut fail, mut differ) = (0, 0, 0);
    for network in 0..200 {
        let n = random.random_range(2..11);
        let place = |random: &mut StdRng| [random.random_range(0.0..3.0), random.random_range(0.0..3.0)];
        let places: Vec<[f64; 2]> = (0..n).map(|_| place(&mut random)).collect();
        let mut ties: Vec<[usize; 2]> = Vec::new();
        for i in 1..n {
            if random.random_bool(0.85) {
                ties.push([random.random_range(0..i), i]);
            }
        }
        for _ in 0..random.random_range(0..3) {
            let (a, b) = (random.random_range(0..n), random.random_range(0..n));
            let tie = [a.min(b), a.max(b)];
            if a != b && !ties.contains(&tie) {
                ties.push(tie);
            }
        }
        let length = |&[a, b]: &[usize; 2]| {
            let (p, q): ([f64; 2], [f64; 2]) = (places[a], places[b]);
            (p[0] - q[0]).hypot(p[1] - q[1])
        };
        let links: Vec<_> = ties.iter().map(|tie| (Rod { length: length(tie) }, *tie)).collect();
        let masses: Vec<f64> = (0..n).map(|_| 10_f64.powf(random.random_range(-1.0..1.0))).collect();
        let mut scene = Scene::points(n)
            .link_each(links)
            .masses(masses)
            .with(PlanarGravity { g: 1.0 })
            .with(Repulsion { strength: random.random_range(0.0..1.0) });
        for body in 0..n {
            if random.random_bool(0.2) {
                scene = scene.pin(body, places[body]);
            }
        }
        let method = Rattle::new(10_f64.powf(random.random_range(-3.0..-0.7)));
        let starts: Vec<_> = (0..10)
            .map(|_| {
                let way = |_| [random.random_range(-0.5..0.5), random.random_range(-0.5..0.5)];
                let momenta: Vec<[f64; 2]> = (0..n).map(way).collect();
                scene.project(&State::of(places.clone()).with_momenta(momenta))
            })
            .filter_map(Result::ok)
            .collect();
        let Ok(mut ensemble) = scene.ensemble(starts.clone(), method) else { continue };
        ensemble.run(40);
        for (i, start) in starts.into_iter().enumerate() {
            let mut simulation = scene.simulate(start, method).unwrap();
            let end = simulation.run(40);
            let state = ensemble.state(i);
            match (ensemble.failure(i), end) {
                (None, Ok(())) => {
                    let apart = state.positions().zip(simulation.positions()).map(|(a, b)| (a - b).norm());
                    let apart = apart.fold(0.0, f64::max);
                    assert!(apart < 1e-8, "network {network}, trajectory {i}: {apart:e}");
                    agree += 1;
                }
                (Some(_), Err(_)) => fail += 1,
                _ => differ += 1,
            }
        }
    }
    println!("{agree} agree, {fail} fail in both, {differ} in one of them");
    assert!(agree > 1500 && fail > 20 && differ <= 8, "{agree} {fail} {differ}");
}
