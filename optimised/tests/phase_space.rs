//! Constraints on phase space: geometric RATTLE against 50-digit maps, solutions, laws, and other ways to the same
//! motion.

use crate::common::symplectic::defect;
use crate::common::*;
use rattle::bodies::{Body, One};
use rattle::composition::*;
use rattle::error::{PhaseFailure, PhaseMistake, StartFailure, StepFailure};
use rattle::nalgebra::SVector;
use rattle::prelude::*;
use rattle::system::Parts;
use rattle::system::System;
use rattle::{Error, Mass};

phase_constraint! {
    /// The three-sphere, whose fibres are those of Hopf.
    pub struct Hopf {}
    |q: [f64; 2], p: [f64; 2]| dot(q, q) + dot(p, p) - 1
}
hamiltonian! {
    /// Free fall.
    pub struct Falling { g }
    |q: [f64; 2], p: [f64; 2]| dot(p, p) / 2 + g * q[1]
}
hamiltonian! {
    /// A charge in a magnetic field: not separable.
    pub struct Charge { b, g }
    |q: [f64; 2], p: [f64; 2]| ((p[0] + b * q[1])^2 + (p[1] - b * q[0])^2) / 2 + g * q[1] + cos(q[0]) * p[1] / 5
}
phase_constraint! {
    /// A sphere in six dimensions and an angular momentum: they commute.
    pub struct Turning { l }
    |q: [f64; 3], p: [f64; 3]| [dot(q, q) + dot(p, p) - 1, q[0] * p[1] - q[1] * p[0] - l]
}
hamiltonian! {
    /// Without symmetry.
    pub struct Uneven3 { g }
    |q: [f64; 3], p: [f64; 3]| (p[0]^2 + 2 * p[1]^2 + p[2]^2 / 2) / 2 + g * q[2] + q[0]^2 * q[1] + q[2] * p[0] / 4
}
phase_constraint! {
    /// Not quadratic, so that its fibres have no formula.
    pub struct Wavy {}
    |q: [f64; 2], p: [f64; 2]| q[0]^2 + q[1]^4 + exp(p[0]) + p[1]^2 * (2 + sin(q[0])) - 3
}

/// The Hopf pendulum of the references, and a start of theirs.
fn hopf() -> Scene<rattle::phase::PhaseSpace<Hopf, Falling, 1>, (), One, 2> {
    Scene::in_phase_space(Hopf {}, Falling { g: 0.3 })
}
fn start(name: &str) -> State<2> {
    let rows = table("hopf_pendulum");
    let row = rows.iter().find(|row| row.text("start") == name && row.number("t") == 0.0).unwrap();
    State::at(row.numbers(["q1", "q2"])).moving(row.numbers(["p1", "p2"]))
}

/// An uneven start that a scene projects.
fn turning() -> (Scene<rattle::phase::PhaseSpace<Turning, Uneven3, 2>, (), One, 3>, State<3>) {
    let scene = Scene::in_phase_space(Turning { l: 0.2 }, Uneven3 { g: 0.3 });
    let start = scene.project(&State::at([0.5, 0.1, 0.4]).moving([0.1, 0.6, -0.3])).unwrap();
    (scene, start)
}
fn charge() -> (Scene<rattle::phase::PhaseSpace<Hopf, Charge, 1>, (), One, 2>, State<2>) {
    let scene = Scene::in_phase_space(Hopf {}, Charge { b: 0.4, g: 0.3 });
    let start = scene.project(&start("C")).unwrap();
    (scene, start)
}
fn wavy() -> (Scene<rattle::phase::PhaseSpace<Wavy, Falling, 1>, (), One, 2>, State<2>) {
    let scene = Scene::in_phase_space(Wavy {}, Falling { g: 0.3 });
    let start = scene.project(&State::at([0.96, -0.81]).moving([0.42, 0.21])).unwrap();
    (scene, start)
}

/// q and p of one body.
pub(crate) fn point<Y: System<f64, D, Count = One>, S: Method, const D: usize>(
    simulation: &Simulation<Y, S, D>,
) -> [[f64; D]; 2] {
    [simulation.position().into(), simulation.momentum().into()]
}
fn apart<const D: usize>(a: [[f64; D]; 2], b: [[f64; D]; 2]) -> f64 {
    distance(a[0], b[0]).max(distance(a[1], b[1]))
}

#[test]
fn the_discrete_map_agrees_with_50_digit_arithmetic() {
    let rows = table("golden_discrete_hopf");
    for row in &rows {
        let n = row.text("n").parse().unwrap();
        let mut simulation = hopf().simulate(start("B"), Rattle::new(0.1)).unwrap();
        let mut trajectory = Trajectory::with_multipliers(&simulation);
        simulation.observe(n, 1, &mut trajectory).unwrap();
        let off = apart(point(&simulation), [row.numbers(["q1", "q2"]), row.numbers(["p1", "p2"])]);
        assert!(off <= 1e-15 * (1.0 + n as f64), "n = {n}: off by {off:e}"); // one rounding of the start grows like t
        // The table's angle s turns (q, p) by the flow of (q² + p²)/2: s = −2 σ, σ = h/2 λ. Rounding ε of g is ε/(hN)
        // in s.
        let multipliers = trajectory.multipliers().unwrap();
        for (column, found) in
            [("fibre_lambda_last", &multipliers.position), ("fibre_mu_last", &multipliers.momentum)]
        {
            let off = (found.last().unwrap() * -0.1 - row.number(column)).abs();
            assert!(off <= 40.0 * f64::EPSILON + 1e-15 * n as f64, "n = {n}, {column}: off by {off:e}");
        }
    }
    assert_eq!(rows.len(), 3);
}

#[test]
#[cfg(long)]
fn high_orders_meet_the_solutions() {
    let mut compared = 0;
    for name in ["B", "C"] {
        for row in table("hopf_pendulum").iter().filter(|row| row.text("start") == name) {
            let t = row.number("t");
            let n = (20.0 * t) as u64;
            let method = Composition::new(SOFRONIOU_SPALETTA_2005_ORDER_10, 0.05);
            let mut simulation = hopf().simulate(start(name), method).unwrap();
            simulation.run(n).unwrap();
            let off = apart(point(&simulation), [row.numbers(["q1", "q2"]), row.numbers(["p1", "p2"])]);
            assert!(off <= 2e-13, "{name}, t = {t}: off by {off:e}"); // rounding, grown like t²
            // The reference has (q² + p² − 1)/2 for g and the other sign.
            let off = (simulation.multiplier() + 0.5 * row.number("lambda")).abs();
            assert!(off <= 1e-12, "{name}, t = {t}: λ off by {off:e}");
            compared += 1;
        }
    }
    assert_eq!(compared, 14);
}

/// Errors at t = 2 with halved steps, against the finest method, which another test holds to a solution.
fn slope<C: rattle::scene::Hold<D>, const D: usize>(
    scene: &Scene<C, (), One, D>,
    start: &State<D>,
    coefficients: Option<Coefficients>,
    coarsest: u64,
) -> f64 {
    fn end<C: rattle::scene::Hold<D>, S: Method, const D: usize>(
        scene: &Scene<C, (), One, D>,
        start: &State<D>,
        method: S,
        n: u64,
    ) -> [[f64; D]; 2] {
        let mut simulation = scene.simulate(start.clone(), method).unwrap();
        simulation.run(n).unwrap();
        point(&simulation)
    }
    let exact = end(scene, start, Composition::new(SOFRONIOU_SPALETTA_2005_ORDER_10, 0.02), 100);
    let errors: Vec<f64> = (0..3)
        .map(|k| {
            let n = coarsest << k;
            let h = 2.0 / n as f64;
            let found = match coefficients {
                None => end(scene, start, Rattle::new(h), n),
                Some(coefficients) => end(scene, start, Composition::new(coefficients, h), n),
            };
            apart(found, exact)
        })
        .collect();
    assert!(errors[2] > 1e-14, "well above rounding, 1e-15: {errors:?}");
    order(&errors)
}

#[test]
#[cfg(long)]
fn orders_are_two_and_those_of_compositions() {
    let ((turning, spinning), (charge, charged), (wavy, waving)) = (turning(), charge(), wavy());
    // Steps until t = 2 in the coarsest of three runs. What is not quadratic comes to order 8 only at rounding.
    for (order, coefficients, [hopf_steps, two, charge_steps, wavy_steps]) in [
        (2.0, None, [40, 80, 60, 80]),
        (4.0, Some(SUZUKI_1990_ORDER_4), [16, 32, 24, 32]),
        (6.0, Some(KAHAN_LI_1997_ORDER_6), [10, 20, 15, 20]),
        (8.0, Some(KAHAN_LI_1997_ORDER_8), [3, 6, 6, 0]),
    ] {
        let mut slopes = vec![
            ("Hopf", slope(&hopf(), &start("C"), coefficients, hopf_steps)),
            ("two equations", slope(&turning, &spinning, coefficients, two)),
            ("not separable", slope(&charge, &charged, coefficients, charge_steps)),
        ];
        if wavy_steps > 0 {
            slopes.push(("not quadratic", slope(&wavy, &waving, coefficients, wavy_steps)));
        }
        for (name, slope) in slopes {
            println!("{name}, order {order}: {slope:.2}");
            assert!((slope - order).abs() < 0.1 * order, "{name}, order {order}: {slope}");
        }
    }
}

/// The equations of motion themselves, by the classical Runge–Kutta method, with λ from derivatives by differences.
#[test]
fn motion_is_that_of_the_equations() {
    fn check<C: rattle::scene::Hold<D>, const D: usize>(
        name: &str,
        scene: &Scene<C, (), One, D>,
        start: &State<D>,
        rates: impl Fn(&[SVector<f64, D>; 2]) -> [SVector<f64, D>; 2],
    ) {
        let method = Composition::new(KAHAN_LI_1997_ORDER_8, 0.02);
        let mut simulation = scene.simulate(start.clone(), method).unwrap();
        simulation.run(50).unwrap();
        let mut z = [start.positions().next().unwrap(), start.momenta().next().unwrap()];
        let plus =
            |z: &[SVector<f64, D>; 2], c: f64, v: &[SVector<f64, D>; 2]| [z[0] + c * v[0], z[1] + c * v[1]];
        let (n, h) = (1000, 0.001);
        for _ in 0..n {
            let k1 = rates(&z);
            let k2 = rates(&plus(&z, 0.5 * h, &k1));
            let k3 = rates(&plus(&z, 0.5 * h, &k2));
            let k4 = rates(&plus(&z, h, &k3));
            for i in 0..2 {
                z[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
            }
        }
        let off = apart(point(&simulation), [z[0].into(), z[1].into()]);
        println!("{name}: {off:.1e}");
        // λ has differences of differences in it: 1e-10 or so.
        assert!(off < 1e-8, "{name}: off by {off:e}");
        assert!(distance(simulation.position(), start.positions().next().unwrap()) > 0.1, "{name} moves");
    }

    /// (q̇, ṗ) with λ such that {g, H} stays: N λ = −ḣ, both by differences of {g, H}.
    fn rates<G: PhaseConstraint<D, M>, H: Hamiltonian<D>, const D: usize, const M: usize>(
        g: &G,
        h: &H,
        z: &[SVector<f64, D>; 2],
    ) -> [SVector<f64, D>; 2] {
        let hidden = |z: &[SVector<f64, D>; 2]| {
            let ((g_q, g_p), (h_q, h_p)) = (g.jacobians(&z[0], &z[1]), h.gradients(&z[0], &z[1]));
            g_q * h_p - g_p * h_q
        };
        let along = |v: &[SVector<f64, D>; 2]| {
            let at = |c: f64| hidden(&[z[0] + c * v[0], z[1] + c * v[1]]);
            let e = 1e-3;
            (8.0 * (at(e) - at(-e)) - (at(2.0 * e) - at(-2.0 * e))) / (12.0 * e)
        };
        let (h_q, h_p) = h.gradients(&z[0], &z[1]);
        let (g_q, g_p) = g.jacobians(&z[0], &z[1]);
        let free = [h_p, -h_q];
        let fibres: Vec<_> = (0..M).map(|i| [-g_p.row(i).transpose(), g_q.row(i).transpose()]).collect();
        let rate = along(&free);
        let n = rattle::nalgebra::DMatrix::from_fn(M, M, |i, j| along(&fibres[j])[i]);
        let rate = rattle::nalgebra::DVector::from_fn(M, |i, _| -rate[i]);
        let lambda = n.lu().solve(&rate).unwrap();
        let mut rates = free;
        for (fibre, &lambda) in fibres.iter().zip(lambda.iter()) {
            rates = [rates[0] + lambda * fibre[0], rates[1] + lambda * fibre[1]];
        }
        rates
    }

    let falling = Falling { g: 0.3 };
    check("Hopf", &hopf(), &start("C"), |z| rates(&Hopf {}, &falling, z));
    let (scene, start) = turning();
    check("two equations", &scene, &start, |z| rates(&Turning { l: 0.2 }, &Uneven3 { g: 0.3 }, z));
    let (scene, start) = charge();
    check("not separable", &scene, &start, |z| rates(&Hopf {}, &Charge { b: 0.4, g: 0.3 }, z));
    let (scene, start) = wavy();
    check("not quadratic", &scene, &start, |z| rates(&Wavy {}, &falling, z));
}

fn one_step<C: rattle::scene::Hold<D>, const D: usize>(
    scene: &Scene<C, (), One, D>,
    h: f64,
) -> impl Fn(State<D>) -> State<D> {
    move |state| {
        let mut simulation = scene.simulate(state, Rattle::new(h)).unwrap();
        simulation.step().unwrap();
        simulation.state()
    }
}

#[test]
fn a_step_is_symplectic_on_the_hidden_constraint() {
    let ((turning, spinning), (charge, charged), (wavy, waving)) = (turning(), charge(), wavy());
    for (name, defect) in [
        ("Hopf", defect(&hopf(), &start("C"), one_step(&hopf(), 0.1))),
        ("two equations", defect(&turning, &spinning, one_step(&turning, 0.05))),
        ("not separable", defect(&charge, &charged, one_step(&charge, 0.1))),
        ("not quadratic", defect(&wavy, &waving, one_step(&wavy, 0.1))),
    ] {
        println!("{name}: {defect:.1e}");
        assert!(defect <= 2e-11, "{name}: {defect:e}");
    }
}

/// There and back: rounding only, which grows with the number of steps, and for N near zero faster.
#[test]
fn a_step_back_undoes_a_step() {
    fn check<C: rattle::scene::Hold<D>, const D: usize>(
        name: &str,
        scene: &Scene<C, (), One, D>,
        start: &State<D>,
    ) {
        for (n, bound) in [(1, 1e-15), (5, 4e-15), (20, 2e-14), (1000, 1e-12)] {
            let mut there = scene.simulate(start.clone(), Rattle::new(0.02)).unwrap();
            let from = point(&there);
            there.run(n).unwrap();
            assert!(apart(point(&there), from) > 1e-3);
            let mut back = scene.simulate(there.state(), Rattle::new(-0.02)).unwrap();
            back.run(n).unwrap();
            let off = apart(point(&back), from);
            assert!(off <= bound, "{name}: off by {off:e} after {n} steps and back");
        }
    }
    check("Hopf", &hopf(), &start("B"));
    let (scene, start) = charge();
    check("not separable", &scene, &start);
    let (scene, start) = wavy();
    check("not quadratic", &scene, &start);
}

#[test]
#[cfg(long)]
fn energy_stays_and_constraints_hold() {
    let mut simulation = hopf().simulate(start("B"), Rattle::new(0.1)).unwrap();
    let (mut worst, mut g, mut hidden) = (0.0_f64, 0.0_f64, 0.0_f64);
    let mut windows = [0.0; 2];
    for window in &mut windows {
        simulation
            .run_with(20_000, |now| {
                *window += now.energy_error() / 20_000.0;
                worst = worst.max(now.energy_error().abs());
                g = g.max(now.constraint_residual());
                hidden = hidden.max(now.cotangent_residual());
            })
            .unwrap();
    }
    println!("energy {worst:.2e}, means {windows:?}, g {g:.1e}, {{g, H}} {hidden:.1e}");
    assert!((1.0e-5..1.2e-4).contains(&worst), "{worst:e}"); // 1.14e-4 in 1e5 steps
    assert!((windows[1] - windows[0]).abs() < 1e-7, "no drift: {windows:?}");
    // Four coordinates rounded by ε/2, each with a slope of up to 2 in g and 2.6 in {g, H}, and the terms as often.
    assert!(g <= 2e-15 && hidden <= 3e-15, "{g:e}, {hidden:e}");
}

/// Compensated sums: without them the energy of both runs is off by 3e-15 after 136 000 stages.
#[test]
#[cfg(long)]
fn rounding_does_not_add_up() {
    for name in ["B", "C"] {
        let method = Composition::new(KAHAN_LI_1997_ORDER_8, 0.05); // its own error is some 1e-16
        let mut simulation = hopf().simulate(start(name), method).unwrap();
        simulation.run(8_000).unwrap();
        let off = simulation.energy_error().abs();
        assert!(off <= 1e-15, "{name}: {off:e}");
    }
}

/// A step is a map of fibres: it does not see where on its fibre it starts.
#[test]
fn steps_from_all_points_of_a_fibre_arrive_together() {
    let from = start("C");
    let system = hopf().simulate(from.clone(), Rattle::new(0.1)).unwrap().system().clone();
    let (q, p) = (from.positions().next().unwrap(), from.momenta().next().unwrap());
    let arrive = |s: f64| -> [[f64; 2]; 2] {
        let (sin, cos) = s.sin_cos();
        let (q, p) = ((q * cos + p * sin).into(), (p * cos - q * sin).into());
        let mut bodies = system.bodies(&[Body { q, q_low: [0.0; 2], p, p_low: [0.0; 2] }], 0.0);
        Rattle::new(0.1).step(&system, &mut bodies, &mut [], &mut ()).unwrap();
        [bodies.q[0], bodies.p[0]]
    };
    for s in [0.02, -0.05, 0.1] {
        let off = apart(arrive(s), arrive(0.0));
        assert!(off <= 2e-15, "from {s}: off by {off:e}"); // ε/(hN) on the way, taken back by the last slide
    }
}

/// Sliding along a fibre changes nothing but the place on it: it is taken back by `project`.
#[test]
fn fibres_are_slid_along_exactly() {
    let (scene, from) = (hopf(), start("B"));
    let (q, p) = (from.positions().next().unwrap(), from.momenta().next().unwrap());
    for s in [0.01_f64, -0.1, 0.3] {
        let (sin, cos) = s.sin_cos();
        let turned = State::at(q * cos + p * sin).moving(p * cos - q * sin);
        let back = scene.project(&turned).unwrap();
        let off =
            distance(back.positions().next().unwrap(), q).max(distance(back.momenta().next().unwrap(), p));
        assert!(off <= 1e-15, "turned by {s}: off by {off:e}");
        assert!(matches!(
            scene.simulate(turned, Rattle::new(0.1)).unwrap_err(),
            Error::Start { cause: StartFailure::Phase(PhaseMistake::Hidden { equation: 0, .. }), .. }
        ));
    }
}

phase_constraint! {
    /// Positions alone.
    pub struct Rods { length }
    |q: [f64; 4], p: [f64; 4]| [
        q[0]^2 + q[1]^2 - length^2,
        (q[2] - q[0])^2 + (q[3] - q[1])^2 - length^2 + 0 * p[0],
    ]
}
hamiltonian! {
    /// Two masses that hang.
    pub struct Hanging { g, m }
    |q: [f64; 4], p: [f64; 4]| (p[0]^2 + p[1]^2) / 2 + (p[2]^2 + p[3]^2) / (2 * m) + g * (q[1] + m * q[3])
}
constraint! {
    /// The same rods.
    pub struct PlainRods { length }
    |x, y, u, v| [x^2 + y^2 - length^2, (u - x)^2 + (v - y)^2 - length^2]
}
potential! {
    /// The same weights.
    pub struct Weights { g, m }
    |x, y, u, v| g * (y + m * v)
}

#[test]
fn constraints_on_positions_are_moved_by_rattle() {
    let (g, m, h) = (1.0, 2.0, 0.01);
    let here = State::at([1.0, 0.0, 1.0, 1.0]);
    let phase = Scene::in_phase_space(Rods { length: 1.0 }, Hanging { g, m });
    let masses = Mass::from([1.0, 1.0, m, m]);
    let plain = Scene::on(PlainRods { length: 1.0 }).with(Weights { g, m }).mass(masses);
    let mut phase = phase.simulate(here.clone(), Rattle::new(h)).unwrap();
    let mut plain = plain.simulate(here, Rattle::new(h)).unwrap();
    let (mut one, mut other) = (Trajectory::with_multipliers(&phase), Trajectory::with_multipliers(&plain));
    phase.observe(200, 1, &mut one).unwrap();
    plain.observe(200, 1, &mut other).unwrap();
    let off = apart(point(&phase), point(&plain));
    assert!(off <= 1e-13, "{off:e}");
    assert!((phase.energy() - plain.energy()).abs() <= 1e-14);
    // λ is a displacement of rounding size divided by h²/2.
    let (one, other) = (one.multipliers().unwrap(), other.multipliers().unwrap());
    for (a, b) in [(&one.position, &other.position), (&one.momentum, &other.momentum)] {
        let off = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(a.len() == 402 && off <= 1e-10, "{off:e}");
    }
}

#[test]
fn bodies_do_not_see_each_other_and_steps_do_not_allocate() {
    let scene = hopf().bodies(2);
    let (b, c) = (start("B"), start("C"));
    let both = State::of([b.positions().next().unwrap(), c.positions().next().unwrap()])
        .with_momenta([b.momenta().next().unwrap(), c.momenta().next().unwrap()]);
    let mut together = scene.simulate(both, Rattle::new(0.05)).unwrap();
    let mut alone = hopf().simulate(c, Rattle::new(0.05)).unwrap();
    let allocated = allocation_counter::measure(|| together.run(100).unwrap());
    assert_eq!(allocated.count_total, 0);
    alone.run(100).unwrap();
    assert_eq!(together.positions().nth(1).unwrap(), alone.position());
    assert_eq!(together.residuals().len(), 2);
    assert!(alone.shadow_energy().is_nan(), "none is known");
}

phase_constraint! {
    /// Conjugate: they do not commute.
    pub struct Conjugate {}
    |q: [f64; 2], p: [f64; 2]| [q[0] - 1, 3 * p[0]]
}
phase_constraint! {
    /// Commutes with its Hamiltonian: every motion stays on it, and nothing determines λ.
    pub struct Level {}
    |q: [f64; 2], p: [f64; 2]| dot(p, p) / 2 + 3 * q[1] / 10 - 1
}

#[test]
fn what_makes_no_sense_is_refused_by_name() {
    let conjugate = Scene::in_phase_space(Conjugate {}, Falling { g: 0.3 });
    let error = conjugate.simulate(State::at([1.0, 0.0]), Rattle::new(0.1)).unwrap_err();
    let Error::Start { body: 0, cause: StartFailure::Phase(mistake) } = &error else { panic!("{error}") };
    assert_eq!(*mistake, PhaseMistake::NotCoisotropic { first: 0, second: 1, bracket: 3.0, share: 1.0 });
    assert!(error.to_string().contains("{g0, g1} = 3.000e0"), "{error}");

    let phase = |state, method| match hopf().simulate(state, method).unwrap_err() {
        Error::Start { cause: StartFailure::Phase(mistake), .. } => mistake,
        other => panic!("{other}"),
    };
    let off = phase(State::at([0.5, 0.5]), Rattle::new(0.1));
    assert!(matches!(off, PhaseMistake::Off { equation: 0, value: -0.5, .. }), "{off}");

    let level = Scene::in_phase_space(Level {}, Falling { g: 0.3 });
    let error = level.simulate(State::at([0.0, 0.0]).moving([2.0_f64.sqrt(), 0.0]), Rattle::new(0.1));
    let error = error.unwrap_err();
    let Error::Start { cause: StartFailure::Phase(PhaseMistake::Undetermined { slopes }), .. } = &error
    else {
        panic!("{error}")
    };
    assert!(slopes.len() == 1 && slopes[0].abs() < 1e-15, "{error}");

    let nan = hopf().simulate(State::at([f64::NAN, 0.5]), Rattle::new(0.1)).unwrap_err();
    assert!(matches!(nan, Error::Start { cause: StartFailure::NotFinite { .. }, .. }), "{nan}");

    fn method<S: Method>(method: S) {
        let error = hopf().simulate(start("B"), method).unwrap_err();
        assert!(matches!(error, Error::CannotMove { system: "a system in phase space", .. }), "{error}");
    }
    method(Shake::new(0.1));
    method(PositionVerlet::new(0.1));
    method(Geodesic::new(2, 0.1));
    method(SymplecticEuler::new(0.1));
    method(Lobatto::<3>::new(0.1));
    method(Composition::of(SUZUKI_1990_ORDER_4, Geodesic::new(2, 0.1)));
}

/// Start A of the reference runs into N = 0 at t = 2.58986 and has no motion beyond; other sheets are near.
#[test]
fn where_the_motion_ends_there_is_an_error() {
    let (q, s) = ([0.3_f64, 0.4], 1.040_765_8_f64);
    let p = [0.75_f64.sqrt() * 1.0_f64.cos(), 0.75_f64.sqrt() * 1.0_f64.sin()];
    let (sin, cos) = s.sin_cos();
    let turned = [0, 1].map(|i| q[i] * cos + p[i] * sin);
    let momentum = [0, 1].map(|i| p[i] * cos - q[i] * sin);
    let scene = hopf();
    let start = scene.project(&State::at(turned).moving(momentum)).unwrap();
    for h in [0.05, 0.01, 0.002] {
        let mut simulation = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
        assert!((simulation.energy() - 0.249_810_83).abs() < 1e-8);
        let mut before = bits(&simulation.state());
        let mut error = None;
        for _ in 0..(4.0 / h) as u32 {
            match simulation.step() {
                Ok(()) => before = bits(&simulation.state()),
                Err(why) => {
                    error = Some(why);
                    break;
                }
            }
        }
        assert_eq!(bits(&simulation.state()), before, "a failed step leaves everything as it was");
        let (t, error) = (simulation.time(), error.expect("the motion ends"));
        println!("h = {h}: {error}");
        assert!((t - 2.589_86).abs() < 3.0 * h, "stopped at {t}");
        assert!(simulation.energy_error().abs() < h, "{:e}", simulation.energy_error());
        let Error::Step { cause, .. } = error else { panic!("{error}") };
        use PhaseFailure::{NoSlide, SheetLost, Undetermined};
        let StepFailure::Phase(cause) = cause else { panic!("{cause}") };
        assert!(matches!(cause, Undetermined { .. } | NoSlide { .. } | SheetLost { .. }), "{cause}");
    }
}

phase_constraint! {
    /// At rest in y, which a weight does not stay.
    pub struct Still {}
    |_q: [f64; 2], p: [f64; 2]| p[1]
}

#[test]
fn what_cannot_be_projected_says_so() {
    let nowhere = hopf().project(&State::at([0.0, 0.0])).unwrap_err();
    assert!(nowhere.to_string().contains("equation 0 has no gradient"), "{nowhere}");
    let still = Scene::in_phase_space(Still {}, Falling { g: 0.3 });
    let error = still.project(&State::at([0.2, 0.5])).unwrap_err();
    let Error::Start { cause: StartFailure::Phase(PhaseMistake::NoSlide { equation: 0, residuals }), .. } =
        &error
    else {
        panic!("{error}")
    };
    assert_eq!(residuals.len(), 1);
}

/// Whatever the step, it arrives on the constraint, if short with about the energy it had, or it is an error and
/// nothing has happened.
#[test]
#[cfg(long)]
fn steps_of_any_length_arrive_or_fail_cleanly() {
    fn check<C: rattle::scene::Hold<D>, const D: usize>(
        name: &str,
        scene: &Scene<C, (), One, D>,
        start: &State<D>,
    ) {
        let (mut taken, mut failed) = (0, 0);
        for k in 0..60 {
            let h = 1e-3 * 1.3_f64.powi(k); // to 5000
            let mut simulation = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
            for _ in 0..5 {
                let before = bits(&simulation.state());
                match simulation.step() {
                    Ok(()) => {
                        taken += 1;
                        assert!(simulation.constraint_residual() <= 1e-14, "{name}, h = {h}");
                        let off = simulation.energy_error().abs();
                        // Second order where that means something; other sheets are some 0.1 off.
                        assert!(h > 0.25 || off <= 0.2 * h * h, "{name}, h = {h}: energy off by {off:e}");
                    }
                    Err(error) => {
                        failed += 1;
                        assert!(matches!(error, Error::Step { .. }));
                        assert_eq!(bits(&simulation.state()), before, "{name}, h = {h}: {error}");
                    }
                }
            }
        }
        println!("{name}: {taken} steps taken, {failed} failed");
        assert!(taken > 50 && failed > 50, "{name}: {taken} {failed}");
    }
    let ((turning, spinning), (charge, charged), (wavy, waving)) = (turning(), charge(), wavy());
    check("Hopf", &hopf(), &start("C"));
    check("two equations", &turning, &spinning);
    check("not separable", &charge, &charged);
    check("not quadratic", &wavy, &waving);

    // h b/2 is what the implicit equations of this energy contract by.
    let strong = Scene::in_phase_space(Hopf {}, Charge { b: 4.0, g: 0.3 });
    let here = strong.project(&start("C")).unwrap();
    let error = strong.simulate(here, Rattle::new(0.6)).unwrap().step().unwrap_err();
    let Error::Step { cause: StepFailure::Phase(cause), .. } = error else { panic!("{error}") };
    assert!(matches!(cause, PhaseFailure::ImplicitStep { h: 0.6, .. }), "{cause}");
}
