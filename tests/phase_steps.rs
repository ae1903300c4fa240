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
