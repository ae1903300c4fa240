//! DOP853: its coefficients in exact arithmetic, its step control, and systems of every kind.

use crate::common::linked::{Rod, chain, double_pendulum};
use crate::common::*;
use num_bigint::BigInt;
use rattle::Error;
use rattle::effect::{Acting, Effect, Moment};
use rattle::error::{MethodFailure, StepFailure};
use rattle::lanes::Lane;
use rattle::links::planar::TurningLine;
use rattle::methods::dop853_table as table;
use rattle::prelude::*;
use rattle::real::Real;
use rattle::surfaces::Torus;
use std::sync::{Arc, Mutex};

/// Decimals kept in exact sums.
const DECIMALS: u32 = 60;

/// A decimal number times 10⁶⁰.
fn scaled(text: &str) -> BigInt {
    let (sign, text) = text.strip_prefix('-').map_or((1, text), |text| (-1, text));
    let (whole, decimals) = text.split_once('.').unwrap_or((text, ""));
    let digits = DECIMALS as usize;
    assert!(decimals.len() <= digits);
    format!("{whole}{decimals:0<digits$}").parse::<BigInt>().unwrap() * sign
}

fn one() -> BigInt {
    BigInt::from(10).pow(DECIMALS)
}

fn product(a: &BigInt, b: &BigInt) -> BigInt {
    a * b / one()
}

/// The decimal digits of |x|, as a power of ten that is larger.
fn magnitude(x: &BigInt) -> i32 {
    let text = x.magnitude().to_string();
    if text == "0" { -1000 } else { text.len() as i32 - DECIMALS as i32 }
}

/// A rooted tree: its number of vertices, its density γ, and its elementary weights at the stages.
struct Tree {
    vertices: usize,
    density: u64,
    weights: Vec<BigInt>,
}

/// Sets of trees from the first `below` that have so many vertices together.
fn forests(trees: &[Tree], below: usize, vertices: usize) -> Vec<Vec<usize>> {
    if vertices == 0 {
        return vec![vec![]];
    }
    let mut found = Vec::new();
    for k in (0..below).filter(|&k| trees[k].vertices <= vertices) {
        for mut rest in forests(trees, k + 1, vertices - trees[k].vertices) {
            rest.push(k);
            found.push(rest);
        }
    }
    found
}

/// All rooted trees of at most `order` vertices (J. C. Butcher 1963).
fn trees(order: usize, a: &[Vec<BigInt>]) -> Vec<Tree> {
    let stages = a.len();
    let mut trees = vec![Tree { vertices: 1, density: 1, weights: vec![one(); stages] }];
    for vertices in 2..=order {
        let new: Vec<Tree> = forests(&trees, trees.len(), vertices - 1)
            .into_iter()
            .map(|children| {
                let densities = children.iter().map(|&k| trees[k].density);
                let density = densities.product::<u64>() * vertices as u64;
                let mut weights = vec![one(); stages];
                for k in children {
                    for (weight, row) in weights.iter_mut().zip(a) {
                        let inner = row.iter().zip(&trees[k].weights).map(|(a, u)| product(a, u));
                        *weight = product(weight, &inner.sum());
                    }
                }
                Tree { vertices, density, weights }
            })
            .collect();
        trees.extend(new);
    }
    trees
}

#[test]
fn coefficients_satisfy_the_conditions_of_every_tree() {
    let path = format!("{}/tests/data/dop853_coefficients.json", env!("CARGO_MANIFEST_DIR"));
    let table: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let numbers = |value: &serde_json::Value| -> Vec<BigInt> {
        value.as_array().unwrap().iter().map(|text| scaled(text.as_str().unwrap())).collect()
    };
    let a: Vec<Vec<BigInt>> = table["a"].as_array().unwrap().iter().map(numbers).collect();
    for (row, c) in a.iter().zip(numbers(&table["c"])) {
        assert!(magnitude(&(row.iter().sum::<BigInt>() - c)) <= -27);
    }
    // Largest defect by number of vertices: Σ bᵢ uᵢ = 1/γ, or 0 for differences of two formulas.
    let trees = trees(9, &a);
    let defects = |weights: &str, full: u32| -> Vec<i32> {
        let b = numbers(&table[weights]);
        let mut worst = vec![-1000; 10];
        for tree in &trees {
            let sum: BigInt = b.iter().zip(&tree.weights).map(|(b, u)| product(b, u)).sum();
            let defect = magnitude(&(sum - one() * full / tree.density));
            worst[tree.vertices] = worst[tree.vertices].max(defect);
        }
        worst
    };
    let count = |n| trees.iter().filter(|tree| tree.vertices == n).count();
    assert_eq!((1..=9).map(count).collect::<Vec<_>>(), [1, 1, 2, 4, 9, 20, 48, 115, 286]);
    for (weights, full, order) in [("b", 1, 8), ("b_3", 1, 3), ("e_5", 0, 5)] {
        let defects = defects(weights, full);
        assert!(defects[1..=order].iter().all(|&defect| defect <= -27), "{weights}: {defects:?}");
        assert!(defects[order + 1] >= -4, "{weights} is of order {order} and no more: {defects:?}");
    }
}

#[test]
fn the_stored_coefficients_are_the_nearest_doubles() {
    let path = format!("{}/tests/data/dop853_coefficients.json", env!("CARGO_MANIFEST_DIR"));
    let published: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let list = |value: &serde_json::Value| -> Vec<String> {
        value.as_array().unwrap().iter().map(|text| text.as_str().unwrap().to_owned()).collect()
    };
    let sparse = |list: Vec<String>| -> Vec<(usize, f64)> {
        list.iter().map(|text| text.parse().unwrap()).enumerate().filter(|&(_, x)| x != 0.0).collect()
    };
    let difference = |a: &[String], b: &[String]| -> Vec<(usize, f64)> {
        let exact = a.iter().zip(b).map(|(a, b)| decimal(&(scaled(a) - scaled(b))));
        sparse(exact.collect())
    };
    let (b, b_3) = (list(&published["b"]), list(&published["b_3"]));
    let rows: Vec<_> = published["a"].as_array().unwrap().iter().map(|row| sparse(list(row))).collect();
    let nodes: Vec<f64> = list(&published["c"]).iter().map(|text| text.parse().unwrap()).collect();
    assert_eq!(table::NODES, *nodes);
    assert_eq!(table::STEPS.map(<[_]>::to_vec), *rows);
    assert_eq!(table::ERROR_3, difference(&b, &b_3));
    assert_eq!(table::WEIGHTS, sparse(b));
    assert_eq!(table::ERROR_5, sparse(list(&published["e_5"])));
}

/// An integer over 10⁶⁰ as a decimal.
fn decimal(x: &BigInt) -> String {
    let digits = DECIMALS as usize;
    let text = format!("{:0>1$}", x.magnitude().to_string(), digits + 1);
    let (whole, decimals) = text.split_at(text.len() - digits);
    let sign = if x.sign() == num_bigint::Sign::Minus { "-" } else { "" };
    format!("{sign}{whole}.{decimals}")
}

/// The billiard at t = 5, where rounding of the start alone moves the end by 1e-16.
fn billiard_error(method: Dop853) -> f64 {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let rows = table("lemniscate_gravity");
    let at =
        |row: &&Row| row.text("ic") == "f64" && row.number("theta_deg") == 45.0 && row.number("t") == 5.0;
    let row = rows.iter().find(at).unwrap();
    let mut simulation = scene.simulate(billiard_45(), method).unwrap();
    simulation.run((5.0 / method.step_size()).round() as u64).unwrap();
    assert_eq!(simulation.time(), 5.0);
    let q = distance(simulation.position(), row.numbers(["x", "y", "z"]));
    q.max(distance(simulation.momentum(), row.numbers(["vx", "vy", "vz"])))
}

#[test]
fn errors_follow_the_tolerance() {
    for h in [0.5, 5.0] {
        let errors =
            [1e-6, 1e-8, 1e-10, 1e-12].map(|tolerance| billiard_error(Dop853::adaptive(h, tolerance)));
        println!("h = {h}: {errors:?}");
        // Some 200 inner steps, whose errors the motion spreads by less than a hundred.
        for (error, tolerance) in errors.into_iter().zip([1e-6, 1e-8, 1e-10, 1e-12]) {
            assert!(error <= 1e3 * tolerance, "h = {h}, tolerance {tolerance:e}: {error:e}");
        }
        assert!(errors[0] > 1e-8 && errors[3] < 1e-11, "{errors:?}");
    }
}

/// Whether a long step is right is asked of each of its inner steps: it costs what shorter ones do that take as long.
/// On one curve through its ends it was 60 times as much.
#[test]
fn long_steps_cost_what_their_inner_ones_do() {
    let evaluations = |h: f64| {
        let torus = Counted::new(Torus { major: 1.0, minor: 0.4 });
        let counts = torus.counts();
        let scene = Scene::on(torus).with(Gravity { g: 1.0 });
        let start = State::at([1.4, 0.0, 0.0]).moving([0.0, 0.6, 0.8]);
        let mut simulation = scene.simulate(start, Dop853::adaptive(h, 1e-10)).unwrap();
        let before = counts.all();
        simulation.run((10.0 / h).round() as u64).unwrap();
        counts.all() - before
    };
    let counted = [0.25, 1.0, 10.0].map(evaluations);
    println!("{counted:?}");
    assert!(counted.iter().max() < Some(&(counted[0] * 6 / 5)), "{counted:?}");
}

/// Two bodies on a line that attract each other like 1/r², and fall together from rest: at t = π/4 from a distance of
/// 1.
#[test]
fn a_collision_is_an_error_and_the_state_stays() {
    potential! {
        /// Gravity between two.
        struct Attraction {}
        |a: [f64; 1], b: [f64; 1]| -1 / abs(a[0] - b[0])
    }
    let scene = Scene::points(2).with(Attraction {}.over([[0, 1]]));
    let mut simulation = scene.simulate(State::of([[0.0], [1.0]]), Dop853::adaptive(0.5, 1e-10)).unwrap();
    simulation.run(1).unwrap();
    let before = simulation.state();
    let error = simulation.step().unwrap_err();
    assert!(
        matches!(
            error,
            Error::Step { step: 2, cause: StepFailure::Method(MethodFailure::StepsCollapse { .. }), .. }
        ),
        "{error}"
    );
    assert_eq!(simulation.state(), before);
    // r(t) = cos² η with t = (η + sin η cos η)/2: at t = 1/2 …
    let mut eta = 0.5_f64;
    for _ in 0..20 {
        eta -= (eta + eta.sin() * eta.cos() - 1.0) / (1.0 + (2.0 * eta).cos());
    }
    let [a, b]: [f64; 2] = before.positions().map(|q| q.x).collect::<Vec<_>>().try_into().unwrap();
    assert!((b - a - eta.cos().powi(2)).abs() < 1e-8, "{a} {b} {eta}");
}

/// In a million times the time in which the motion bends there is no room for a step, and no singular point.
#[test]
fn a_step_of_too_many_inner_ones_says_so() {
    let scene = Scene::on(rattle::surfaces::Sphere { r: 1.0 }).with(Gravity { g: 1.0 });
    let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 1.0, 0.0]);
    let mut long = scene.simulate(start, Dop853::adaptive(1.5e5, 1e-9)).unwrap();
    let error = long.step().unwrap_err().to_string();
    assert!(error.contains("at most 10⁶ inner steps") && error.contains("shorter h"), "{error}");
}

#[test]
fn a_tolerance_is_a_positive_length() {
    for tolerance in [0.0, -1e-6, f64::NAN, f64::INFINITY, 1e-160] {
        let found = Scene::point().simulate(State::at([0.0]), Dop853::adaptive(0.1, tolerance));
        assert!(matches!(found.unwrap_err(), Error::Tolerance(_)));
    }
}

/// A step that ends where Newton's iteration does not lead to the surface is an error.
#[test]
fn a_step_that_leaves_the_surface_is_an_error() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    for h in [0.9, 1.5, 2.0] {
        let mut simulation = scene.simulate(billiard_45(), Dop853::new(h)).unwrap();
        let (before, error) = (simulation.state(), simulation.step().unwrap_err());
        let expected = matches!(
            error,
            Error::Step { cause: StepFailure::Method(MethodFailure::NotProjected { .. }), .. }
        );
        assert!(expected, "{error}");
        assert_eq!(simulation.state(), before);
    }
}

/// The multipliers that an observer hears are those of the motion at the two ends of the step.
#[test]
fn multipliers_are_those_of_the_motion() {
    let surface = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let linked = Scene::points(3).link(Rod { length: 1.0 }, chain(2)).pin(0, [0.0; 2]);
    let linked = linked.with(PlanarGravity { g: 1.0 });
    let mut particle = surface.simulate(billiard_45(), Dop853::new(0.05)).unwrap();
    let mut rods = linked.simulate(double_pendulum(), Dop853::new(0.05)).unwrap();
    for _ in 0..10 {
        let (before, rods_before) = (particle.multipliers(), rods.multipliers());
        let mut heard = Trajectory::with_multipliers(&particle);
        particle.observe(1, 1, &mut heard).unwrap();
        let heard = heard.multipliers().unwrap();
        close(&heard.position[1..], &before);
        close(&heard.momentum[1..], &particle.multipliers());
        let mut heard = Trajectory::with_multipliers(&rods);
        rods.observe(1, 1, &mut heard).unwrap();
        let heard = heard.multipliers().unwrap();
        close(&heard.position[2..], &rods_before);
        close(&heard.momentum[2..], &rods.multipliers());
    }
}

/// To a few roundings.
fn close(a: &[f64], b: &[f64]) {
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() <= 1e-13 * b.abs().max(1.0), "{a:e} {b:e}");
    }
}

/// A bead on a turning rod: r = cosh ωt; the rod does the work ω² sinh² ωt.
#[test]
fn on_a_turning_rod() {
    let (omega, t) = (0.8, 1.5);
    let scene = Scene::points(1).link_moving(TurningLine { omega }, [[0]]);
    let start = State::of([[1.0, 0.0]]).moving([0.0, omega]);
    let mut simulation = scene.simulate(start, Dop853::new(0.05)).unwrap();
    simulation.run(30).unwrap();
    let (r, angle) = (f64::cosh(omega * t), omega * t);
    let q = simulation.positions().next().unwrap();
    assert!(distance(q, [r * angle.cos(), r * angle.sin()]) <= 1e-12, "{q}");
    let work = (omega * f64::sinh(omega * t)).powi(2);
    assert!((simulation.work() - work).abs() <= 1e-12, "{:e}", simulation.work() - work);
    assert!(simulation.energy_error().abs() <= 1e-12, "{:e}", simulation.energy_error());
}

/// Where the multiplier acts along x alone, y falls freely: y = y₀ − t²/2, and x stays on the circle.
#[test]
fn a_multiplier_on_one_coordinate() {
    let scene = Scene::point().link_acting(Pendulum { length: 1.0 }, [[0]], [[true, false]]);
    let scene = scene.with(PlanarGravity { g: 1.0 });
    let mut simulation = scene.simulate(State::at([0.6, 0.8]), Dop853::new(0.05)).unwrap();
    simulation.run(20).unwrap();
    let (q, y) = (simulation.position(), 0.8 - 0.5);
    assert!((q.y - y).abs() <= 1e-15 && (q.x - f64::sqrt(1.0 - y * y)).abs() <= 1e-15, "{q}");
}

potential! {
    /// The weight of a top: height of a point on its third axis.
    struct TopWeight { g }
    |_xx, _xy, _xz, _yx, _yy, _yz, _zx, _zy, zz| g * zz
}

/// A heavy top keeps its energy to the order of the method: torques are those of the potential.
#[test]
fn a_heavy_top() {
    let turned = nalgebra::Rotation3::from_euler_angles(0.4, 0.2, 0.0);
    let start = Rigid::start(turned.matrix(), &[0.3, -0.2, 2.0].into());
    let top = Scene::rigid(Rigid::new([0.6, 0.6, 0.4])).with(TopWeight { g: 1.0 });
    let after = |n: u32| {
        let mut simulation = top.simulate(start.clone(), Dop853::new(2.0 / f64::from(n))).unwrap();
        simulation.run(n.into()).unwrap();
        (simulation.energy_error(), simulation.kinetic_energy(), simulation.position())
    };
    let [(coarse, ..), (fine, kinetic, attitude)] = [20, 80].map(after);
    assert!(fine.abs() <= 1e-13 && coarse.abs() > 8.0 * fine.abs(), "{coarse:e} {fine:e}");
    let mut other = top.simulate(start, Composition::new(SUZUKI_1990_ORDER_4, 1e-3)).unwrap();
    assert!((kinetic - other.kinetic_energy()).abs() > 0.01, "the weight does something");
    other.run(2000).unwrap();
    assert!(distance(attitude, other.position()) <= 1e-10, "{:e}", distance(attitude, other.position()));
}

/// A free rigid body, reduced to three unknowns, against its reference.
#[test]
fn a_rigid_body() {
    let body = Rigid::new([0.6, 0.8, 1.0]);
    let start = Rigid::start(&nalgebra::Matrix3::identity(), &[1.8, 0.4, -0.9].into());
    let rows = table("rigid_body");
    let row = rows.iter().find(|row| row.number("t") == 1.0).unwrap();
    let mut simulation = Scene::rigid(body).simulate(start, Dop853::new(0.05)).unwrap();
    simulation.run(20).unwrap();
    let attitude = row.numbers(["Q11", "Q12", "Q13", "Q21", "Q22", "Q23", "Q31", "Q32", "Q33"]);
    assert!(distance(simulation.position(), attitude) <= 2e-13, "{}", simulation.position());
    let p = simulation.momentum();
    assert!(distance([p[0], p[1], p[2]], row.numbers(["m1", "m2", "m3"])) <= 2e-13);
}

/// Where a step would be divided into too many, the inner step that is told is the one that is needed, not one that
/// failed: it is too short for a millionth of the step.
#[test]
fn too_many_inner_steps_are_told_with_the_one_that_is_needed() {
    let scene = Scene::on(Sphere { r: 1.0 }).with(Gravity { g: 1.0 });
    let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 1.0, 0.0]);
    for h in [1e5, 3e5] {
        let error = scene.simulate(start.clone(), Dop853::adaptive(h, 1e-14)).unwrap().step().unwrap_err();
        let Error::Step {
            cause: StepFailure::Method(MethodFailure::TooManyInnerSteps { inner, .. }), ..
        } = error
        else {
            panic!("{error}");
        };
        assert!(inner < 1e-6 * h && inner > 1e-8 * h, "h = {h:e}: {inner:e}");
    }
}

/// A push along x that oscillates, U = -a cos(wt) x, which notes the times at which U is asked for.
#[derive(Debug, Clone)]
struct Tide {
    a: f64,
    w: f64,
    asked: Arc<Mutex<Vec<f64>>>,
}

/// The kind of the tide.
struct Tidal;

impl Effect<3, Tidal> for Tide {
    type Acting<T: Real> = Tide;
    fn acting<T: Real>(&self) -> Tide {
        self.clone()
    }
    type Swept<S: Lane, const L: usize> = [Tide; L];
}

impl<T: Real> Acting<T, 3> for Tide {
    type Room = ();
    fn room(&self, _: usize) {}
    fn changes_with_time(&self) -> bool {
        true
    }
    fn add_forces(&self, at: Moment<'_, T, 3>, (): &mut (), forces: &mut [[T; 3]]) {
        let push = T::from_f64(self.a * (self.w * at.time).cos());
        forces.iter_mut().for_each(|force| force[0] = force[0] + push);
    }
    fn energy(&self, at: Moment<'_, T, 3>) -> T {
        self.asked.lock().unwrap().push(at.time);
        let push = T::from_f64(-self.a * (self.w * at.time).cos());
        at.positions.iter().fold(T::from_f64(0.0), |sum, q| sum + push * q[0])
    }
    fn power(&self, at: Moment<'_, T, 3>) -> T {
        let push = T::from_f64(self.a * self.w * (self.w * at.time).sin());
        at.positions.iter().fold(T::from_f64(0.0), |sum, q| sum + push * q[0])
    }
}

constraint! {
    /// A ridge with a radius of some 10⁻⁶, of which no stage knows: inner steps over it are put back.
    struct Ridge { slope, radius }
    |x, _y, z| z + slope * sqrt(x^2 + radius^2)
}

/// The potential energy at the end of an inner step is that at the start of the next: in no step is one time asked for
/// twice. Where an inner step was put back, the work is still counted from where it began.
#[test]
fn a_driven_potential_is_evaluated_once_between_inner_steps() {
    let (mut divided, mut back) = (0, 0);
    for (x, h) in [(0.2, 0.2), (0.3, 0.2), (0.41, 0.2), (0.5, 0.2), (0.2, 0.5), (0.5, 0.5)] {
        let asked = Arc::new(Mutex::new(Vec::new()));
        let ridge = Ridge { slope: 0.3, radius: 1e-6 };
        let scene = Scene::on(ridge).with(Tide { a: 0.3, w: 2.0, asked: asked.clone() });
        let start = State::at([-x, 0.0, -0.3 * x]).moving([0.8, 0.3, 0.0]);
        let start = scene.project(&start).unwrap();
        let mut simulation = scene.simulate(start, Dop853::adaptive(h, 1e-5)).unwrap();
        for step in 1..=(2.0 / h) as u64 {
            asked.lock().unwrap().clear();
            simulation.step().unwrap();
            let mut times = std::mem::take(&mut *asked.lock().unwrap());
            divided += usize::from(times.len() > 2);
            back += times.windows(2).filter(|pair| pair[1] < pair[0]).count();
            times.sort_by(f64::total_cmp);
            let twice = times.windows(2).filter(|pair| pair[0] == pair[1]).count();
            assert_eq!(twice, 0, "from {x}, h = {h}, step {step}: {times:?}");
            let ends = [times[0], times[times.len() - 1]].map(|time| (time / h).round() as u64);
            assert_eq!(ends, [step - 1, step], "from {x}, h = {h}: {times:?}");
        }
        let [off, x_end] = [simulation.energy_error(), simulation.position().x];
        assert!(off.abs() < 1e-4 && x_end > 1.0, "from {x}, h = {h}: {off:e} at {x_end}");
    }
    assert!(divided > 4 && back > 4, "{divided} divided, {back} inner steps put back");
}

potential! {
    /// A spring that grows stiffer, slowly.
    struct Stiffening {}
    |x, y, t| exp(4.6 * tanh(t / 1000)) * (x^2 + y^2) / 2
}

/// A step ends after 10⁶ inner steps, also where each of them passes.
#[test]
#[cfg_attr(not(long), ignore = "a million inner steps, see `cargo long`")]
fn a_step_has_a_million_inner_steps_at_most() {
    let scene = Scene::points(1).with(Stiffening {});
    let mut simulation =
        scene.simulate(State::at([1.0, 0.0]).moving([0.0, 1.0]), Dop853::adaptive(3e5, 3.0)).unwrap();
    let error = simulation.run(1).unwrap_err();
    let Error::Step { cause: StepFailure::Method(MethodFailure::TooManyInnerSteps { inner, .. }), .. } =
        error
    else {
        panic!("{error}");
    };
    assert!(inner > 0.01 && inner < 0.3, "{inner:e}");
}
