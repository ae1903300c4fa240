//! Steps in phase space: the step of H alone where it is implicit, and equations that commute at the start alone. What
//! simulations tell, lanes tell, too.

use rattle::Error;
use rattle::error::{PhaseFailure, StepFailure};
use rattle::prelude::*;

phase_constraint! {
    /// Brackets {g₀, g₁} = c q₁² are zero where q₁ is.
    struct Drifting { c }
    |q: [f64; 3], p: [f64; 3]| [q[0] - c * q[1]^2 * p[2], q[2]]
}
hamiltonian! {
    struct Leaning {}
    |q: [f64; 3], p: [f64; 3]| dot(p, p) / 2 + 0.3 * q[0] + 0.3 * q[2]
}

/// The pair and its bracket that ended a run.
fn clash(error: &Error) -> (u64, usize, usize, f64, f64) {
    match error {
        Error::Step {
            step,
            cause: StepFailure::Phase(PhaseFailure::NotCoisotropic { first, second, bracket, share, .. }),
            ..
        } => (*step, *first, *second, *bracket, *share),
        other => panic!("{other}"),
    }
}

/// q₁ = t: the first step leads to where the bracket is c h², all that there is of it, and no step is short enough.
#[test]
fn equations_that_commute_at_the_start_alone_are_told() {
    let start = State::at([0.0; 3]).moving([0.0, 1.0, 0.0]);
    for (c, h) in [(1e-6, 0.05), (1e-3, 0.05), (1e-3, 0.01), (0.1, 0.05), (1.0, 0.05)] {
        let scene = Scene::in_phase_space(Drifting { c }, Leaning {});
        let mut alone = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
        let error = alone.run(100).unwrap_err();
        let (step, first, second, bracket, share) = clash(&error);
        println!("c = {c}, h = {h}: {error}");
        assert_eq!((step, first, second, alone.time()), (1, 0, 1, 0.0));
        assert!(
            (bracket / (c * h * h) - 1.0).abs() < 1e-3 && (share - 1.0).abs() < 1e-12,
            "{bracket:e} {share}"
        );
        assert!(error.to_string().contains("not coisotropic"), "{error}");

        let mut lanes = scene.ensemble(vec![start.clone(); 3], Rattle::new(h)).unwrap();
        lanes.run(100);
        let (step, first, second, of_lane, _) = clash(lanes.failure(1).expect("it ends"));
        assert_eq!((step, first, second, lanes.state(1).time()), (1, 0, 1, 0.0));
        assert!((of_lane / bracket - 1.0).abs() < 1e-12, "{of_lane:e} {bracket:e}");
    }
}

phase_constraint! {
    /// A circle in a tilted plane. Where k is not 0, brackets are 2k p₂ times the first equation, so rounding.
    struct Tilted { k }
    |q: [f64; 3], p: [f64; 3]| [
        q[2] - 0.3 * q[0] + 0 * p[0],
        dot(q, q) - 1 + k * (q[2] - 0.3 * q[0]) * p[2]^2,
    ]
}

/// Both are the same circle, on which the same body moves: what the second adds to an equation is zero, and its slopes
/// are those of the first, so that it slides along the same fibres.
#[test]
fn a_bracket_that_is_rounding_is_no_clash() {
    let plain = Scene::in_phase_space(Tilted { k: 0.0 }, Leaning {});
    let start = plain.project(&State::at([0.53, 0.62, 0.15]).moving([0.7, -0.3, 0.5])).unwrap();
    let state = |k: f64, h: f64, steps: u64| {
        let (scene, start) = (Scene::in_phase_space(Tilted { k }, Leaning {}), start.clone());
        let mut alone = scene.simulate(start.clone(), Rattle::new(h)).unwrap_or_else(|e| panic!("{k}: {e}"));
        alone.run(steps).unwrap_or_else(|error| panic!("{k}: {error}"));
        assert!(alone.constraint_residual() < 1e-15);
        scene.simulate(alone.state(), Rattle::new(h)).unwrap_or_else(|error| panic!("{k}, again: {error}"));
        let mut lanes = scene.ensemble(vec![start; 3], Rattle::new(h)).unwrap();
        lanes.run(steps);
        assert_eq!(lanes.failures().count(), 0, "{k}");
        [alone.state(), lanes.state(1)].map(|state| <[f64; 3]>::from(state.positions().next().unwrap()))
    };
    let [plain, _] = state(0.0, 0.01, 300);
    for other in state(0.2, 0.01, 300) {
        let off = (0..3).map(|i| (other[i] - plain[i]).abs()).fold(0.0, f64::max);
        println!("{off:e}");
        assert!(off < 1e-13, "{off:e}");
    }
}

phase_constraint! {
    struct Rail {}
    |q: [f64; 2], p: [f64; 2]| q[1] + 0 * p[0]
}
hamiltonian! {
    struct Twisted { k, c }
    |q: [f64; 2], p: [f64; 2]| dot(p, p) / 2 + q[0]^2 / 2 + k * q[0] * p[0] + c * q[0]^2 * p[0]^2
}

/// The small root of a x² + b x + c.
fn root(a: f64, b: f64, c: f64) -> f64 {
    -2.0 * c / (b + b.signum() * (b * b - 4.0 * a * c).sqrt())
}

/// The step along the rail: its equations are quadratic.
///
/// ```text
/// p½ = p − h/2 (q + k p½ + 2c q p½²)
/// q′ = q + h/2 (p½ + k q + 2c q² p½ + p½ + k q′ + 2c q′² p½)
/// ```
fn step_along_rail([q, p]: [f64; 2], h: f64, k: f64, c: f64) -> [f64; 2] {
    let s = 0.5 * h;
    let half = root(2.0 * s * c * q, 1.0 + s * k, s * q - p);
    let out = q + s * (2.0 * half + k * q + 2.0 * c * q * q * half);
    let end = root(2.0 * s * c * half, s * k - 1.0, out);
    [end, half - s * (end + k * half + 2.0 * c * end * half * half)]
}

/// Kicks and drifts pass zero, where their rounding is that of momenta and coordinates; many such runs ended there. The
/// pace depends on the energy, of which each step rounds another part away: after n steps it is off by √n roundings,
/// and the body by n times that.
#[test]
fn implicit_steps_go_on_where_a_change_passes_zero() {
    let rail = |i: u32| 0.45 * f64::from(i).sin();
    let runs = [(0.1, 0.9, 0.1, 1000, vec![[0.2, 0.1]])].into_iter().chain(
        [(0.2, 0.9, 0.1), (0.2, 0.9, 0.0)]
            .map(|(h, k, c)| (h, k, c, 3000, (1..6).map(|i| [rail(2 * i), rail(2 * i + 1)]).collect())),
    );
    for (h, k, c, steps, starts) in runs {
        let scene = Scene::in_phase_space(Rail {}, Twisted { k, c });
        let state = |[q, p]: &[f64; 2]| State::at([*q, 0.0]).moving([*p, 0.0]);
        let mut lanes = scene.ensemble(starts.iter().map(state), Rattle::new(h)).unwrap();
        lanes.run(steps);
        let mut most = [0.0_f64; 2];
        for (i, start) in starts.iter().enumerate() {
            let mut alone = scene.simulate(state(start), Rattle::new(h)).unwrap();
            alone.run(steps).unwrap_or_else(|error| panic!("k = {k}, c = {c}, {start:?}: {error}"));
            assert!(lanes.failure(i).is_none(), "k = {k}, c = {c}, {start:?}: {:?}", lanes.failure(i));
            let exact = (0..steps).fold(*start, |at, _| step_along_rail(at, h, k, c));
            for (most, end) in most.iter_mut().zip([alone.state(), lanes.state(i)]) {
                let (q, p) = (end.positions().next().unwrap()[0], end.momenta().next().unwrap()[0]);
                *most = most.max((q - exact[0]).abs()).max((p - exact[1]).abs());
            }
        }
        println!("h = {h}, k = {k}, c = {c}: off by {most:?}");
        let rounding = 1e-15 * (steps as f64).powf(1.5);
        assert!(most.iter().all(|&off| off < rounding), "h = {h}, k = {k}, c = {c}: off by {most:?}");
    }
}

phase_constraint! {
    struct Flat {}
    |q: [f64; 3], p: [f64; 3]| q[2] + 0 * p[0]
}
hamiltonian! {
    /// What is driven is coordinate 0, and coordinate 1 does not know it: implicit in the second alone.
    struct Apart { a }
    |q: [f64; 3], p: [f64; 3]| p[0]^2 / 2 + a * q[0] + p[1]^2 * (1 + q[1]^2) / 2 + q[1]^2 / 2 + p[2]^2 / 2
}

/// q₁ is the same beside a body at rest and beside one that is 2e18 away.
#[test]
fn small_coordinates_are_exact_beside_large_ones() {
    let (h, steps) = (0.1, 200);
    let end = |a: f64| {
        let scene = Scene::in_phase_space(Flat {}, Apart { a });
        let start = State::at([0.0, 0.3, 0.0]).moving([0.0, 0.4, 0.0]);
        let mut alone = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
        alone.run(steps).unwrap();
        let mut lanes = scene.ensemble(vec![start; 3], Rattle::new(h)).unwrap();
        lanes.run(steps);
        assert_eq!(lanes.failures().count(), 0, "a = {a:e}");
        [alone.state(), lanes.state(1)].map(|state| <[f64; 3]>::from(state.positions().next().unwrap()))
    };
    let [exact, _] = end(0.0);
    for a in [1.0, 1e4, 1e8, 1e10, 1e16] {
        for found in end(a) {
            let fallen = -0.5 * a * (h * steps as f64).powi(2);
            let off = (found[1] - exact[1]).abs();
            println!("a = {a:e}: {off:e}");
            assert!(off < 1e-15 && (found[0] / fallen - 1.0).abs() < 1e-13, "a = {a:e}: {off:e}, {found:?}");
        }
    }
}

phase_constraint! {
    struct Held {}
    |q: [f64; 4], p: [f64; 4]| q[3] + 0 * p[0]
}
hamiltonian! {
    /// q·Ap of two coordinates, as in a rotating frame, beside a third that is free.
    struct Stirred { a, b, c, d }
    |q: [f64; 4], p: [f64; 4]|
        dot(p, p) / 2 + q[0] * (a * p[0] + b * p[1]) + q[1] * (c * p[0] + d * p[1])
}

/// x where [[a, b], [c, d]] x = r.
fn solve_two([a, b, c, d]: [f64; 4], r: [f64; 2]) -> [f64; 2] {
    let determinant = a * d - b * c;
    [(d * r[0] - b * r[1]) / determinant, (a * r[1] - c * r[0]) / determinant]
}

/// The first step from q = 0: its equations are linear, with s = h/2.
///
/// ```text
/// (1 + sA) p½ = p
/// (1 − sAᵀ) q′ = h p½
/// p′ = p½ − sA p½
/// ```
fn stirred([a, b, c, d]: [f64; 4], h: f64, p: [f64; 2]) -> [f64; 4] {
    let s = 0.5 * h;
    let half = solve_two([1.0 + s * a, s * b, s * c, 1.0 + s * d], p);
    let q = solve_two([1.0 - s * a, -s * c, -s * b, 1.0 - s * d], half.map(|x| h * x));
    let [x, y] = half;
    [q[0], q[1], x - s * (a * x + b * y), y - s * (c * x + d * y)]
}

/// By how much the first step of a simulation and of a lane are off, beside this momentum; none where one is refused
/// since H alone has no step, as both must be.
fn off_when_stirred(of: [f64; 4], h: f64, p: [f64; 2], beside: f64) -> Option<f64> {
    let [a, b, c, d] = of;
    let scene = Scene::in_phase_space(Held {}, Stirred { a, b, c, d });
    let start = State::at([0.0; 4]).moving([p[0], p[1], beside, 0.0]);
    let mut alone = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
    let mut lanes = scene.ensemble(vec![start; 3], Rattle::new(h)).unwrap();
    let refused = alone.run(1).err();
    lanes.run(1);
    for error in refused.iter().chain(lanes.failure(1)) {
        let implicit =
            matches!(error, Error::Step { cause: StepFailure::Phase(PhaseFailure::ImplicitStep { .. }), .. });
        assert!(implicit, "{of:?}: {error}");
    }
    assert_eq!(refused.is_some(), lanes.failure(1).is_some(), "{of:?}");
    let exact = stirred(of, h, p);
    let off = [alone.state(), lanes.state(1)].map(|state| {
        let (q, p) = (state.positions().next().unwrap(), state.momenta().next().unwrap());
        let found = [q[0], q[1], p[0], p[1]];
        (0..4).map(|i| (found[i] - exact[i]).abs()).fold(0.0, f64::max)
    });
    refused.is_none().then_some(off[0].max(off[1]))
}

/// In a rotating frame, from a momentum along an axis, each component moves in every other pass alone.
#[test]
fn implicit_steps_are_solved_where_a_component_does_not_move_in_a_pass() {
    for (h, w) in [(0.1, 1.0), (0.2, 3.0), (0.5, 1.0)] {
        for beside in [0.0, 1.0, 1e3, 1e6, 1e10] {
            let off = off_when_stirred([0.0, -w, w, 0.0], h, [0.0, 1.0], beside).expect("a step");
            println!("h = {h}, w = {w}, beside {beside:e}: {off:e}");
            assert!(off < 1e-15, "h = {h}, w = {w}, beside {beside:e}: {off:e}");
        }
    }
}

/// What comes nearer slowly is not there yet, however large other momenta are.
#[test]
fn implicit_steps_that_hardly_contract_are_refused() {
    for s in [0.85, 0.9, 0.95, 0.99] {
        for beside in [0.0, 1e6, 1e10] {
            assert_eq!(off_when_stirred([20.0 * s, 0.0, 0.0, 0.0], 0.1, [1.0, 0.0], beside), None, "{s}");
        }
    }
}

/// Components that are coupled pass zero while others are large: that is no sign of rest. A step is right or refused.
/// What contracts slowly is left at 1e-13 of itself, that times ten where the rate is 0.9.
#[test]
fn no_implicit_step_is_taken_that_is_not_solved() {
    let number = |i: u32| (43758.5453 * (12.9898 * f64::from(i)).sin()).fract();
    let (mut most, mut solved) = (0.0_f64, 0);
    for i in 0..400 {
        let scale = 5.0 * (1.0 + f64::from(i % 4));
        let of = [0, 1, 2, 3].map(|k| scale * number(6 * i + k));
        let p = [4, 5].map(|k| number(6 * i + k));
        let Some(off) = off_when_stirred(of, 0.1, p, 1e10) else { continue };
        (most, solved) = (most.max(off), solved + 1);
        assert!(off < 1e-11, "{of:?}, {p:?}: {off:e}");
    }
    println!("{solved} are solved, off by {most:e}");
    assert!(solved > 150, "{solved}");
}

hamiltonian! {
    /// Of half a space.
    struct Edge {}
    |q: [f64; 3], p: [f64; 3]| dot(p, p) / 2 + sqrt(q[0])
}

/// g knows nothing of the coordinate in which H ends.
#[test]
fn leaving_the_domain_of_the_energy_is_told_as_that() {
    let scene = Scene::in_phase_space(Flat {}, Edge {});
    let start = State::at([0.01, 0.3, 0.0]).moving([-1.0, 0.2, 0.0]);
    let mut alone = scene.simulate(start.clone(), Rattle::new(0.05)).unwrap();
    let mut lanes = scene.ensemble(vec![start; 3], Rattle::new(0.05)).unwrap();
    lanes.run(1);
    for error in [&alone.run(1).unwrap_err(), lanes.failure(1).unwrap()] {
        let ends = matches!(
            error,
            Error::Step { cause: StepFailure::Phase(PhaseFailure::HamiltonianNotFinite { .. }), .. }
        );
        assert!(ends, "{error}");
    }
}

phase_constraint! {
    /// The axis, by an equation that grows along it: N is e²ˣ.
    struct Line {}
    |q: [f64; 2], p: [f64; 2]| q[1] * exp(q[0]) + 0 * p[0]
}
phase_constraint! {
    /// And two of them, that grow the other way about.
    struct Lines {}
    |q: [f64; 3], p: [f64; 3]| [q[1] * exp(q[0]) + 0 * p[0], q[2] * exp(-q[0]) + 0.3 * q[1]]
}
hamiltonian! {
    struct Along {}
    |q: [f64; 2], p: [f64; 2]| dot(p, p) / 2
}
hamiltonian! {
    struct AlongSpace {}
    |q: [f64; 3], p: [f64; 3]| dot(p, p) / 2
}

/// Where N grows, a step is taken as far as its way back is; and more than twice or half as much is told either way.
#[test]
fn a_step_is_taken_where_its_way_back_is() {
    let end = |v: f64, h: f64| {
        let scene = Scene::in_phase_space(Line {}, Along {});
        let start = State::at([0.0; 2]).moving([v, 0.0]);
        let mut lanes = scene.ensemble(vec![start.clone(); 3], Rattle::new(h)).unwrap();
        lanes.run(3);
        let run = scene.simulate(start, Rattle::new(h)).unwrap().run(3).map(|_| ());
        assert_eq!(run.is_ok(), lanes.failure(1).is_none(), "{v}, {h}");
        run
    };
    for h in [0.1, 0.25, 0.34] {
        for v in [-1.0, 1.0] {
            end(v, h).unwrap_or_else(|error| panic!("{v}, {h}: {error}"));
            let scene = Scene::in_phase_space(Line {}, Along {});
            let run = scene.simulate(State::at([0.0; 2]).moving([v, 0.0]), Rattle::new(h)).unwrap();
            run.check_reversal(1e-13).unwrap_or_else(|error| panic!("{v}, {h}: {error}"));
            let scene = Scene::in_phase_space(Lines {}, AlongSpace {});
            let run = scene.simulate(State::at([0.0; 3]).moving([v, 0.0, 0.0]), Rattle::new(h)).unwrap();
            run.check_reversal(1e-13).unwrap_or_else(|error| panic!("two, {v}, {h}: {error}"));
        }
    }
    let mut changes = [-1.0, 1.0].map(|v| match end(v, 0.36) {
        Err(Error::Step { cause: StepFailure::Phase(PhaseFailure::Undetermined { change, .. }), .. }) => {
            change
        }
        other => panic!("{other:?}"),
    });
    changes.sort_by(f64::total_cmp);
    assert!(changes.iter().all(|change| (change - (f64::exp(0.72) - 1.0)).abs() < 1e-12), "{changes:?}");
}
