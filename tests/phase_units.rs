//! {g, H} = 0 in phase space holds to rounding, also where a part of the fibre vanishes, and in whatever units
//! positions and momenta are.

use crate::common::order;
use rattle::Error;
use rattle::composition::SUZUKI_1990_ORDER_4;
use rattle::error::{PhaseMistake, StartFailure};
use rattle::prelude::*;

phase_constraint! {
    /// A circle of x and its momentum, with x in units of 1/s; y is free.
    struct Circle { s }
    |q: [f64; 2], p: [f64; 2]| (q[0] / s)^2 + p[0]^2 + 0 * q[1] + 0 * p[1] - 1
}
phase_constraint! {
    /// The three-sphere, with positions in units of 1/s.
    struct Hopf { s }
    |q: [f64; 2], p: [f64; 2]| dot(q, q) / s^2 + dot(p, p) - 1
}
hamiltonian! {
    /// A weight whose field depends on x, in the same units.
    struct Weight { s, g, a, b }
    |q: [f64; 2], p: [f64; 2]| s * dot(p, p) / 2 + q[1] * (g + a * q[0] / s + b * (q[0] / s)^2)
}

/// {g, H} = 2 p₀ (q₀ − ∂H/∂q₀) on the circle: p₀ is 0 and x stays. So the field is that of x, and y falls in it.
const FALLING: Weight = Weight { s: 1.0, g: 0.4, a: 0.2, b: 0.3 };

fn circle(s: f64) -> Scene<rattle::phase::PhaseSpace<Circle, Weight, 1>, (), rattle::bodies::One, 2> {
    Scene::in_phase_space(Circle { s }, Weight { s, ..FALLING })
}

/// At x = ±s.
fn start(s: f64, x: f64) -> State<2> {
    State::at([x * s, 0.5 * s]).moving([0.0, 0.3])
}

/// (q/s, p).
fn point(state: &State<2>, s: f64) -> [f64; 4] {
    let (q, p) = (state.positions().next().unwrap(), state.momenta().next().unwrap());
    [q[0] / s, q[1] / s, p[0], p[1]]
}

fn apart(a: [f64; 4], b: [f64; 4]) -> f64 {
    (0..4).map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max)
}

/// p₀ is rounded where slides by some h of it end at 0: once by ε h and, by corrections, a few times.
#[test]
fn a_momentum_that_is_zero_stays_zero() {
    for h in [0.04, 0.03, 0.02, 0.01, 0.005] {
        for x in [-1.0, 1.0] {
            let (scene, from, steps) = (circle(1.0), start(1.0, x), (1.0 / h) as u64);
            let mut alone = scene.simulate(from.clone(), Rattle::new(h)).unwrap();
            let (mut p, mut hidden) = (0.0_f64, 0.0_f64);
            let watch = |now: &Simulation<_, _, 2>| {
                (p, hidden) = (p.max(now.momentum()[0].abs()), hidden.max(now.cotangent_residual()));
            };
            alone.run_with(steps, watch).unwrap();
            let mut lanes = scene.ensemble(vec![from.clone(); 3], Rattle::new(h)).unwrap();
            for _ in 0..steps {
                lanes.run(1);
                p = p.max(point(&lanes.state(1), 1.0)[2].abs());
            }
            assert_eq!(lanes.failures().count(), 0);
            let off = apart(point(&lanes.state(1), 1.0), point(&alone.state(), 1.0));
            println!("h = {h}, x = {x}: p {p:e}, {{g, H}} {hidden:e}, lanes off by {off:e}");
            assert!(p < 1e-16 && hidden < 4e-16 && off < 2e-15);
        }
    }
}

#[test]
fn steps_there_are_reversible_and_of_the_order_of_their_method() {
    for h in [0.04, 0.02, 0.01] {
        let run = circle(1.0).simulate(start(1.0, -1.0), Rattle::new(h)).unwrap();
        run.check_reversal(1e-13).unwrap().run(30).unwrap();
    }
    for (x, field) in [(-1.0, 0.4 - 0.2 + 0.3), (1.0, 0.4 + 0.2 + 0.3)] {
        let exact = [x, 0.5 + 0.3 - 0.5 * field, 0.0, 0.3 - field];
        let error = |steps: u32| {
            let method = Composition::new(SUZUKI_1990_ORDER_4, 1.0 / f64::from(steps));
            let mut run = circle(1.0).simulate(start(1.0, x), method).unwrap();
            run.run(steps.into()).unwrap();
            apart(point(&run.state(), 1.0), exact)
        };
        let errors = [8, 16, 32].map(error);
        println!("x = {x}: {errors:?}");
        assert!(errors[2] > 1e-13 && (order(&errors) - 4.0).abs() < 0.2, "{errors:?}");
    }
}

/// With q and H in other units the same motion. Each step is rounded elsewhere, by ε/2 of what is near 1, which grows
/// like the time: where the field is uneven, by as much again.
#[test]
fn motions_do_not_depend_on_units() {
    fn check<C: rattle::scene::Hold<2> + 'static>(
        name: &str,
        scene: impl Fn(f64) -> Scene<C, (), rattle::bodies::One, 2>,
        start: impl Fn(f64) -> State<2>,
    ) {
        for h in [0.04, 0.03, 0.02, 0.005] {
            let steps = (0.6 / h) as u64;
            let end = |s: f64| {
                let mut alone = scene(s).simulate(start(s), Rattle::new(h)).unwrap();
                alone.run(steps).unwrap_or_else(|error| panic!("{name}, s = {s:e}, h = {h}: {error}"));
                let mut lanes = scene(s).ensemble(vec![start(s); 3], Rattle::new(h)).unwrap();
                lanes.run(steps);
                assert_eq!(lanes.failures().count(), 0, "{name}, s = {s:e}, h = {h}");
                [point(&alone.state(), s), point(&lanes.state(1), s)]
            };
            let [one, _] = end(1.0);
            for s in [1e-60, 1e-6, 1e-3, 30.0, 1e4, 1e6, 1e8, 1e60] {
                let off = end(s).map(|end| apart(end, one));
                println!("{name}, s = {s:e}, h = {h}: {off:?}");
                assert!(off.iter().all(|&off| off < 2e-15), "{name}, s = {s:e}, h = {h}: {off:?}");
            }
        }
    }
    check("circle", circle, |s| start(s, -1.0));
    let hopf = |s| Scene::in_phase_space(Hopf { s }, Weight { s, g: 0.3, a: 0.0, b: 0.0 });
    let project = |q: [f64; 2], p| hopf(1.0).project(&State::at(q).moving(p)).unwrap();
    for from in [project([-0.55, -0.83], [0.03, 0.02]), project([-0.4, -0.9], [0.3, 0.1])] {
        let [x, y, u, v] = point(&from, 1.0);
        check("sphere", hopf, |s| State::at([x * s, y * s]).moving([u, v]));
    }
}

/// A start off {g, H} = 0 by more than the tolerance is refused, and a projected one is at rounding.
#[test]
fn starts_are_held_to_it() {
    let sharp = |p: f64| State::at([-(1.0 - p * p).sqrt(), 0.5]).moving([p, 0.3]);
    for s in [1e-6, 1.0, 1e6] {
        for p in [1e-3, 1e-5, 1e-7, 1e-9] {
            let off = State::at([sharp(p).positions().next().unwrap()[0] * s, 0.5 * s]).moving([p, 0.3]);
            let error = circle(s).simulate(off, Rattle::new(0.01)).unwrap_err();
            let hidden = |mistake: &PhaseMistake| matches!(mistake, PhaseMistake::Hidden { equation: 0, .. });
            assert!(
                matches!(&error, Error::Start { cause: StartFailure::Phase(mistake), .. } if hidden(mistake)),
                "s = {s:e}, p = {p:e}: {error}"
            );
        }
    }
    for p in [1e-2, 1e-4, 1e-8, 3e-10] {
        let found = point(&circle(1.0).project(&sharp(p)).unwrap(), 1.0)[2];
        println!("p = {p:e}: {found:e}");
        assert!(found.abs() < 1e-16, "p = {p:e}: {found:e}");
    }
}

phase_constraint! {
    /// The three-sphere of two of three coordinates and their momenta; the third is free.
    struct Beside {}
    |q: [f64; 3], p: [f64; 3]| q[1]^2 + q[2]^2 + p[1]^2 + p[2]^2 - 1 + 0 * q[0] + 0 * p[0]
}
hamiltonian! {
    /// Weight.
    struct Heavy { g }
    |q: [f64; 3], p: [f64; 3]| dot(p, p) / 2 + g * q[2]
}

/// What a constraint does not know is no measure of its rounding, however large: in simulations and in lanes.
#[test]
fn free_coordinates_may_be_as_large_as_they_like() {
    let scene = Scene::in_phase_space(Beside {}, Heavy { g: 0.3 });
    let start = |q: f64, p: f64| {
        let start = State::at([0.0, -0.55, -0.83]).moving([0.0, 0.03, 0.02]);
        let start = scene.project(&start).unwrap();
        let ([_, a, b], [_, c, d]): ([f64; 3], [f64; 3]) =
            (start.positions().next().unwrap().into(), start.momenta().next().unwrap().into());
        State::at([q, a, b]).moving([p, c, d])
    };
    let end = |state: &State<3>| {
        let (q, p) = (state.positions().next().unwrap(), state.momenta().next().unwrap());
        [q[1], q[2], p[1], p[2]]
    };
    let run = |q: f64, p: f64| {
        let mut alone = scene.simulate(start(q, p), Rattle::new(0.05)).unwrap();
        let mut hidden = 0.0_f64;
        alone.run_with(40, |now| hidden = hidden.max(now.cotangent_residual())).unwrap();
        assert!(hidden < 4e-16, "q₀ = {q:e}, p₀ = {p:e}: {hidden:e}");
        let mut lanes = scene.ensemble(vec![start(q, p); 3], Rattle::new(0.05)).unwrap();
        lanes.run(40);
        assert_eq!((lanes.plan().in_lanes, lanes.failures().count()), (3, 0));
        [end(&alone.state()), end(&lanes.state(1))]
    };
    let [exact, _] = run(0.0, 0.0);
    for (q, p) in [(0.0, 1e4), (0.0, 1e8), (0.0, 1e10), (1e10, 0.0)] {
        for found in run(q, p) {
            assert!(apart(found, exact) < 1e-14, "q₀ = {q:e}, p₀ = {p:e}: {:e}", apart(found, exact));
        }
    }
}

phase_constraint! {
    /// An angular momentum in the plane, and what bends its fibres.
    struct Spin { l }
    |q: [f64; 2], p: [f64; 2]| q[0] * p[1] - q[1] * p[0] + (q[0] * p[0])^2 / l - l
}
hamiltonian! {
    /// Springs along two axes, one twice as strong.
    struct Springs { over, k }
    |q: [f64; 2], p: [f64; 2]| over * dot(p, p) / 2 + k * (q[0]^2 + 2 * q[1]^2) / 2
}

/// Units of which squares are no numbers are units, too, in simulations and in lanes: in powers of two the motion is
/// the same, bit for bit.
#[test]
fn squares_of_units_may_be_no_numbers() {
    let scene =
        |q: f64, p: f64| Scene::in_phase_space(Spin { l: 0.5 * q * p }, Springs { over: q / p, k: p / q });
    let first = scene(1.0, 1.0).project(&State::at([1.0, 0.1]).moving([0.3, 0.5])).unwrap();
    let [x, y, u, v] = point(&first, 1.0);
    let end = |q: f64, p: f64| {
        let start = || State::at([x * q, y * q]).moving([u * p, v * p]);
        let mut alone = scene(q, p).simulate(start(), Rattle::new(0.05)).unwrap();
        alone.run(10).unwrap();
        let mut lanes = scene(q, p).ensemble(vec![start(); 3], Rattle::new(0.05)).unwrap();
        lanes.run(10);
        assert_eq!(lanes.failures().count(), 0, "q = {q:e}, p = {p:e}");
        [alone.state(), lanes.state(1)].map(|end| {
            let [x, y, u, v] = point(&end, q);
            [x, y, u / p, v / p]
        })
    };
    let ones = end(1.0, 1.0);
    for (q, p) in [(-500, 500), (-538, 481), (-548, 471), (481, -538)] {
        let found = end(2.0_f64.powi(q), 2.0_f64.powi(p));
        let off = [0, 1].map(|i| apart(found[i], ones[i]));
        assert_eq!(off, [0.0; 2], "q = 2^{q}, p = 2^{p}");
    }
}

/// Where all numbers are double, an ensemble in single precision refuses none of them.
#[test]
fn single_precision_is_double_here() {
    let s = 1e60;
    let end = |ensemble: Result<Ensemble<2>, Error>| {
        let mut ensemble = ensemble.unwrap();
        ensemble.run(4);
        format!("{:?}", ensemble.state(2))
    };
    let starts = || vec![start(s, -1.0); 3];
    let single = end(circle(s).ensemble_in(Single, starts(), Rattle::new(0.01)));
    assert_eq!(single, end(circle(s).ensemble(starts(), Rattle::new(0.01))));
}
