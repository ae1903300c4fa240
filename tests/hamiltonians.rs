//! Hamiltonians without constraints: leapfrog, the implicit Störmer–Verlet step of energies whose parts are not apart,
//! compositions of both; in simulations, in lanes, of several bodies, and going on.

use crate::common::{larger, order};
use rattle::Error;
use rattle::composition::{KAHAN_LI_1997_ORDER_8, SUZUKI_1990_ORDER_4};
use rattle::error::{PhaseFailure, StepFailure};
use rattle::links::planar::Rod;
use rattle::methods::lobatto::Lobatto;
use rattle::potentials::planar::Gravity;
use rattle::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

hamiltonian! {
    /// A pendulum in which the places of q and p are exchanged.
    struct Exchanged {}
    |x, p| x^2 / 2 - cos(p)
}

hamiltonian! {
    /// Two rods of length 1 with masses of 1 at their ends, by their angles to the vertical.
    struct Double { g }
    |a, b, pa, pb|
        (pa^2 + 2 * pb^2 - 2 * pa * pb * cos(a - b)) / (2 * (1 + sin(a - b)^2)) - g * (2 * cos(a) + cos(b))
}

hamiltonian! {
    /// The same in other names.
    struct Named { g }
    |theta, phi, p_theta, pphi|
        (p_theta^2 + 2 * pphi^2 - 2 * p_theta * pphi * cos(theta - phi)) / (2 * (1 + sin(theta - phi)^2))
            - g * (2 * cos(theta) + cos(phi))
}

hamiltonian! {
    /// The same with arrays.
    struct Arrays { g }
    |q: [f64; 2], p: [f64; 2]|
        (p[0]^2 + 2 * p[1]^2 - 2 * p[0] * p[1] * cos(q[0] - q[1])) / (2 * (1 + sin(q[0] - q[1])^2))
            - g * (2 * cos(q[0]) + cos(q[1]))
}

hamiltonian! {
    /// Places that are called p, and their momenta.
    struct Places { g }
    |p1, p2, pp1, pp2|
        (pp1^2 + 2 * pp2^2 - 2 * pp1 * pp2 * cos(p1 - p2)) / (2 * (1 + sin(p1 - p2)^2)) - g * (2 * cos(p1) + cos(p2))
}

hamiltonian! {
    /// One by its letter alone.
    struct Letters { g }
    |q, s, p, ps|
        (p^2 + 2 * ps^2 - 2 * p * ps * cos(q - s)) / (2 * (1 + sin(q - s)^2)) - g * (2 * cos(q) + cos(s))
}

hamiltonian! {
    /// The double pendulum, with its second angle in another unit.
    struct InUnits { unit }
    |a, b, pa, pb| {
        let u = b * unit;
        let pu = pb / unit;
        (pa^2 + 2 * pu^2 - 2 * pa * pu * cos(a - u)) / (2 * (1 + sin(a - u)^2)) - 2 * cos(a) - cos(u)
    }
}

/// Numbers mean what arrays mean, however they are called.
#[test]
fn numbers_mean_what_arrays_mean() {
    let (q, p) = ([0.3, 1.1].into(), [-0.4, 0.7].into());
    let of = [
        (Double { g: 1.3 }.value(&q, &p), Double { g: 1.3 }.gradients(&q, &p)),
        (Named { g: 1.3 }.value(&q, &p), Named { g: 1.3 }.gradients(&q, &p)),
        (Places { g: 1.3 }.value(&q, &p), Places { g: 1.3 }.gradients(&q, &p)),
        (Letters { g: 1.3 }.value(&q, &p), Letters { g: 1.3 }.gradients(&q, &p)),
    ];
    assert_eq!(of, [(Arrays { g: 1.3 }.value(&q, &p), Arrays { g: 1.3 }.gradients(&q, &p)); 4]);
}

/// Of T(p) + U(q) a step is leapfrog, here with sums as they come: both are rounded in each of 1000 steps.
#[test]
fn separable_energies_go_by_leapfrog() {
    let (h, mut x, mut p) = (0.1, 0.3, 1.1);
    let start = State::at([x]).moving([p]);
    let mut simulation = Scene::hamiltonian(Exchanged {}).simulate(start, Rattle::new(h)).unwrap();
    let mut farthest = 0.0;
    for _ in 0..1000 {
        p -= 0.5 * h * x;
        x += h * p.sin();
        p -= 0.5 * h * x;
        simulation.run(1).unwrap();
        farthest = larger(farthest, (simulation.position().x - x).abs());
        farthest = larger(farthest, (simulation.momentum().x - p).abs());
    }
    assert!(farthest < 1e-12, "{farthest:e}");
    assert!(simulation.energy_error().abs() < 2e-3, "{:e}", simulation.energy_error());
    assert_eq!((simulation.constraint_residual(), simulation.work()), (0.0, 0.0));
}

/// Where the double pendulum is at t = 1 by linked bodies, and its momenta ∂L/∂ȧ and ∂L/∂ḃ there.
fn by_links(g: f64, [a, b]: [f64; 2]) -> [f64; 4] {
    let tip = |a: f64| [a.sin(), -a.cos()];
    let [[x, y], [u, v]] = [tip(a), tip(b)];
    let scene =
        Scene::points(3).link(Rod { length: 1.0 }, [[0, 1], [1, 2]]).pin(0, [0.0, 0.0]).with(Gravity { g });
    let start = State::of([[0.0, 0.0], [x, y], [x + u, y + v]]);
    let mut run = scene.simulate(start, Lobatto::<7>::new(1.0 / 128.0)).unwrap();
    run.run(128).unwrap();
    let (q, v): (Vec<_>, Vec<_>) = (run.positions().collect(), run.momenta().collect());
    let (first, second) = (q[1], q[2] - q[1]);
    let along =
        |of: &rattle::nalgebra::Vector2<f64>, v: &rattle::nalgebra::Vector2<f64>| of.x * v.y - of.y * v.x;
    [
        first.x.atan2(-first.y),
        second.x.atan2(-second.y),
        along(&first, &v[1]) + along(&first, &v[2]),
        along(&second, &v[2]),
    ]
}

/// Energies whose parts are not apart: orders against linked bodies, which know nothing of angles; and a motion that
/// returns.
#[test]
fn a_double_pendulum_by_its_angles_is_that_of_links() {
    let (g, angles) = (1.3, [2.0, 1.2]);
    let exact = by_links(g, angles);
    let scene = Scene::hamiltonian(Double { g });
    let start = || State::at(angles).moving([0.0, 0.0]);
    let off = |run: &dyn Fn(u32) -> State<2>, steps: u32| {
        let end = run(steps);
        let (q, p) = (end.positions().next().unwrap(), end.momenta().next().unwrap());
        [q.x, q.y, p.x, p.y].iter().zip(exact).fold(0.0, |most, (x, exact)| larger(most, (x - exact).abs()))
    };
    let plain = |steps: u32| {
        let mut run = scene.simulate(start(), Rattle::new(1.0 / f64::from(steps))).unwrap();
        run = run.check_reversal(1e-13).unwrap();
        run.run(u64::from(steps)).unwrap();
        run.state()
    };
    let fourth = |steps: u32| {
        let method = Composition::new(SUZUKI_1990_ORDER_4, 1.0 / f64::from(steps));
        let mut run = scene.simulate(start(), method).unwrap();
        run.run(u64::from(steps)).unwrap();
        run.state()
    };
    let eighth = |steps: u32| {
        let method = Composition::new(KAHAN_LI_1997_ORDER_8, 1.0 / f64::from(steps));
        let mut run = scene.simulate(start(), method).unwrap();
        run.run(u64::from(steps)).unwrap();
        run.state()
    };
    for (name, run, steps, expected, least) in [
        ("plain", &plain as &dyn Fn(u32) -> State<2>, [32, 64, 128, 256], 2.0, 1e-4),
        ("fourth", &fourth, [16, 32, 64, 128], 4.0, 1e-8),
        ("eighth", &eighth, [8, 16, 24, 32], 8.0, 1e-11),
    ] {
        let errors = steps.map(|steps| off(run, steps));
        let last = errors[3];
        let found = if name == "eighth" { (errors[0] / errors[1]).log2() } else { order(&errors) };
        assert!((found - expected).abs() < 0.25 * expected, "{name}: {found}, {errors:?}");
        assert!(last < least, "{name}: {errors:?}");
    }
}

/// Lanes, and several bodies of one scene, go as simulations of one do.
#[test]
fn lanes_and_several_bodies_go_as_one() {
    let scene = Scene::hamiltonian(Double { g: 1.0 });
    let start = |i: usize| State::at([0.1 * i as f64, 1.0]).moving([0.0, 0.3]);
    let mut lanes = scene.ensemble((0..21).map(start), Rattle::new(0.02)).unwrap();
    assert_eq!(lanes.plan().alone, 0, "{:?}", lanes.plan());
    lanes.run(200);
    assert_eq!(lanes.failures().count(), 0);
    let of_all = (0..3).map(|i| start(i).positions().next().unwrap().into());
    let momenta = (0..3).map(|i| start(i).momenta().next().unwrap().into());
    let of_all: State<2> =
        State::of(of_all.collect::<Vec<[f64; 2]>>()).with_momenta(momenta.collect::<Vec<[f64; 2]>>());
    let mut together = scene.bodies(3).simulate(of_all, Rattle::new(0.02)).unwrap();
    together.run(200).unwrap();
    for i in 0..21 {
        let mut alone = scene.simulate(start(i), Rattle::new(0.02)).unwrap();
        alone.run(200).unwrap();
        let (q, p) = (alone.position(), alone.momentum());
        let lane = lanes.state(i);
        let (at, momentum) = (lane.positions().next().unwrap(), lane.momenta().next().unwrap());
        let off = (at - q).iter().chain((momentum - p).iter()).fold(0.0, |most, x| larger(most, x.abs()));
        assert!(off < 1e-11, "{i}: {at} {q}");
        if i < 3 {
            assert_eq!(together.positions().nth(i).unwrap(), q);
            assert_eq!(together.momenta().nth(i).unwrap(), p);
        }
    }
}

/// A run that goes on from a checkpoint is the same to the bit; another energy is told.
#[test]
fn a_run_goes_on_from_a_checkpoint() {
    let begin = |g: f64| {
        let start = State::at([2.0, 1.2]).moving([0.0, 0.0]);
        Scene::hamiltonian(Double { g }).simulate(start, Rattle::new(0.02)).unwrap()
    };
    let (mut whole, mut parts) = (begin(1.0), begin(1.0));
    whole.run(100).unwrap();
    let checkpoint = whole.checkpoint();
    whole.run(100).unwrap();
    parts.resume(&checkpoint).unwrap();
    parts.run(100).unwrap();
    assert_eq!(crate::common::bits(&whole.state()), crate::common::bits(&parts.state()));
    assert!(begin(1.5).resume(&checkpoint).is_err());
}

hamiltonian! {
    /// Places and momenta that depend on each other, in one variable and the same beside a free one.
    struct Waves { k }
    |x, y, px, py| px^2 / 2 + x * sin(px) + k * (py^2 / 2 + y * sin(py))
}

/// An equation of p½ with several roots, of which only the one that comes from p as a step grows is a step: from
/// p = π/2 + 3 on −3 sin p½ is another one. With steps of a third it is the one that comes from p.
#[test]
fn steps_to_another_root_are_refused() {
    let run = |k: f64, h: f64| {
        let start = State::at([1.0, 1.0]).moving([FRAC_PI_2 + 3.0, k * (FRAC_PI_2 + 3.0)]);
        let scene = Scene::hamiltonian(Waves { k });
        let mut run = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
        let mut lanes = scene.ensemble(vec![start; 3], Rattle::new(h)).unwrap();
        assert_eq!(lanes.plan().alone, 0);
        lanes.run(1);
        let in_lanes = lanes.failures().map(|(_, error)| error.to_string()).next();
        (run.run(1).err(), in_lanes)
    };
    for k in [1.0, 0.0] {
        let (alone, in_lanes) = run(k, 6.0);
        let cause = |error: &Error| {
            matches!(error, Error::Step { cause: StepFailure::Phase(PhaseFailure::ImplicitStep { .. }), .. })
        };
        assert!(alone.as_ref().is_some_and(cause), "{k}: {alone:?}");
        assert!(in_lanes.is_some(), "{k}");
        let (alone, in_lanes) = run(k, 0.5);
        assert!(alone.is_none() && in_lanes.is_none(), "{k}: {alone:?} {in_lanes:?}");
    }
}

/// Double pendulums at random, in two units of an angle: of 800 steps of each size as many are refused as before first
/// moves were looked at.
#[test]
fn steps_that_come_nearer_in_any_unit_are_taken() {
    let mut random = 7_u64; // Knuth's MMIX
    let mut refused = [0; 4];
    for _ in 0..400 {
        let mut next = |size: f64| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            size * (2.0 * (random >> 11) as f64 / 2_f64.powi(53) - 1.0)
        };
        let (q, p) = ([next(PI), next(PI)], [next(4.0), next(4.0)]);
        for (refused, h) in refused.iter_mut().zip([0.1, 0.2, 0.4, 0.6]) {
            for unit in [1.0, 64.0] {
                let start = State::at([q[0], q[1] / unit]).moving([p[0], p[1] * unit]);
                let mut run = Scene::hamiltonian(InUnits { unit }).simulate(start, Rattle::new(h)).unwrap();
                *refused += u32::from(run.run(1).is_err());
            }
        }
    }
    assert_eq!(refused, [8, 70, 284, 442]);
}

/// Steps whose equation for p½ or q′ has no solution near by are errors, and nothing is moved.
#[test]
fn steps_too_long_for_their_equations_are_told() {
    let start = State::at([2.0, 1.2]).moving([5.0, -7.0]);
    let mut run = Scene::hamiltonian(Double { g: 1.0 }).simulate(start.clone(), Rattle::new(1.0)).unwrap();
    let error = run.run(1).unwrap_err();
    let cause = |error: &Error| {
        matches!(error, Error::Step { cause: StepFailure::Phase(PhaseFailure::ImplicitStep { .. }), .. })
    };
    assert!(cause(&error), "{error}");
    assert_eq!(run.position(), start.positions().next().unwrap());
    let mut lanes = Scene::hamiltonian(Double { g: 1.0 }).ensemble(vec![start; 3], Rattle::new(1.0)).unwrap();
    lanes.run(1);
    assert!(cause(lanes.failure(2).expect("it ends")));
}
