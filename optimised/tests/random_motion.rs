//! Random surfaces and networks, moved by every method: what is off the true motion falls as the order says.
//!
//! ```text
//! cargo long --test motion random_motion:: -- --nocapture
//! ```
//!
//! The truth takes nothing from the library: gradients and second derivatives are written out here, the multipliers are
//! eliminated from the second derivative of the constraints, and what is left is solved by Runge and Kutta's method of
//! order 4 in steps so short that its own error is known and small.

use crate::every_method::rows;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::bodies::Count;
use rattle::effect::Effects;
use rattle::effect::Over;
use rattle::links::planar::Rod;
use rattle::nalgebra::{DMatrix, DVector, Matrix3, SVector, Vector3};
use rattle::potentials::planar::weights;
use rattle::prelude::*;
use rattle::scene::Hold;

constraint! {
    /// A quadric and two waves.
    #[derive(Clone, Copy, Debug)]
    struct Waves { a: [f64; 6], height: [f64; 2], u: [f64; 3], w: [f64; 3], phase: [f64; 2], level }
    |x, y, z| {
        let quadric = a[0] * x^2 + a[1] * y^2 + a[2] * z^2 + a[3] * x * y + a[4] * y * z + a[5] * z * x;
        let one = height[0] * sin(u[0] * x + u[1] * y + u[2] * z + phase[0]);
        quadric + one + height[1] * sin(w[0] * x + w[1] * y + w[2] * z + phase[1]) - level
    }
}

potential! {
    /// A random force.
    #[derive(Clone, Copy, Debug)]
    struct Hill { s: [f64; 3] }
    |x, y, z| s[0] * x^2 + s[1] * y * z + s[2] * z
}

potential! {
    /// A spring between two bodies.
    #[derive(Clone, Copy, Debug)]
    struct Pull { k }
    |a: [f64; 2], b: [f64; 2]| k / 2 * dot(a - b, a - b)
}

/// Constraints and forces as a differential equation of second order: q̈ = M⁻¹ (F − Gᵀλ), G q̈ = −γ.
struct Equation {
    inverse_masses: DVector<f64>,
    force: Box<dyn Fn(&DVector<f64>) -> DVector<f64>>,
    /// G and γ, the second derivative of g along the velocity.
    constraints: Box<dyn Fn(&DVector<f64>, &DVector<f64>) -> (DMatrix<f64>, DVector<f64>)>,
}

impl Equation {
    fn acceleration(&self, q: &DVector<f64>, v: &DVector<f64>) -> DVector<f64> {
        let ((jacobian, curvature), force) = ((self.constraints)(q, v), (self.force)(q));
        let free = force.component_mul(&self.inverse_masses);
        let mut weighted = jacobian.transpose();
        for mut column in weighted.column_iter_mut() {
            column.component_mul_assign(&self.inverse_masses);
        }
        let multipliers = (&jacobian * &weighted).lu().solve(&(&jacobian * &free + curvature)).unwrap();
        free - weighted * multipliers
    }

    /// Positions and velocities after a time t, in n steps.
    fn moved(&self, start: [&DVector<f64>; 2], t: f64, n: u32) -> [DVector<f64>; 2] {
        let h = t / f64::from(n);
        let [mut q, mut v] = start.map(Clone::clone);
        for _ in 0..n {
            let a = self.acceleration(&q, &v);
            let (v2, a2) =
                (&v + &a * (h / 2.0), self.acceleration(&(&q + &v * (h / 2.0)), &(&v + &a * (h / 2.0))));
            let (v3, a3) =
                (&v + &a2 * (h / 2.0), self.acceleration(&(&q + &v2 * (h / 2.0)), &(&v + &a2 * (h / 2.0))));
            let (v4, a4) = (&v + &a3 * h, self.acceleration(&(&q + &v3 * h), &(&v + &a3 * h)));
            q += (&v + (&v2 + &v3) * 2.0 + v4) * (h / 6.0);
            v += (a + (a2 + a3) * 2.0 + a4) * (h / 6.0);
        }
        [q, v]
    }

    /// The truth, and its error: what half as many steps are off, over 2⁴ − 1.
    fn truth(&self, start: [&DVector<f64>; 2], t: f64) -> ([DVector<f64>; 2], [f64; 2]) {
        let (fine, coarse) = (self.moved(start, t, 2048), self.moved(start, t, 1024));
        let off = [0, 1].map(|i| (&fine[i] - &coarse[i]).amax() / 15.0);
        (fine, off)
    }
}

/// What became of a method.
#[derive(Default)]
struct Outcome {
    /// log₂ of the errors of n steps over those of 2n, where these are above rounding.
    falls: Vec<f64>,
    refused: u32,
    done: u32,
}

/// Puts every method to a random scene that ends at this time, in n and 2n steps.
fn put<C: Hold<D>, E: Effects<D>, N: Count, const D: usize>(
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
    equation: &Equation,
    (time, steps): (f64, u32),
    outcomes: &mut [Outcome],
) {
    let coordinates = |all: &mut dyn Iterator<Item = SVector<f64, D>>| {
        DVector::from_vec(all.flat_map(<[f64; D]>::from).collect())
    };
    let q = coordinates(&mut start.positions());
    let v = coordinates(&mut start.momenta()).component_mul(&equation.inverse_masses);
    let ([to_q, to_v], off) = equation.truth([&q, &v], time);
    // In parts of the way and of the velocity.
    let speed = v.amax().max(to_v.amax());
    let way = speed * time;
    for (row, outcome) in rows().iter().zip(outcomes) {
        // Of high orders not much is seen but in long steps.
        let steps = if row.order <= 2 { steps } else { steps.div_ceil(row.order) };
        let error = |n: u32| {
            let method = row.method.with_step(time / f64::from(n));
            let start = scene.staggered(start, &method).ok()?;
            let mut simulation = scene.simulate(start, method).unwrap();
            simulation.run(n.into()).ok()?;
            let state = simulation.state();
            let found = coordinates(&mut state.momenta()).component_mul(&equation.inverse_masses);
            let of_places = (coordinates(&mut state.positions()) - &to_q).amax() / way;
            let of_speeds =
                if row.method.momentum_delay() == 0.0 { (found - &to_v).amax() / speed } else { 0.0 };
            Some(of_places.max(of_speeds))
        };
        let (Some(coarse), Some(fine)) = (error(steps), error(2 * steps)) else {
            outcome.refused += 1;
            continue;
        };
        outcome.done += 1;
        // Rounding of g, of terms of size one, turns a momentum by as much over a step's length.
        let rounding = 64.0 * f64::EPSILON * f64::from(2 * steps) / way;
        let floor = 2.0 * (off[0] / way + off[1] / speed) + rounding;
        let what = || format!("{}, {steps} steps: {coarse:e}, {fine:e}, floor {floor:e}", row.name);
        let most = (8.0 / f64::from(steps)).powi(row.order.min(2).cast_signed()) + floor;
        assert!(coarse <= most && fine <= 1.5 * coarse + floor, "{}", what());
        if fine > 30.0 * floor {
            outcome.falls.push((coarse / fine).log2());
        }
    }
}

/// Of each method the mean order within these scenes.
fn check(what: &str, outcomes: Vec<Outcome>) {
    println!("{what}:");
    let mut judged = 0;
    for (row, mut outcome) in rows().into_iter().zip(outcomes) {
        outcome.falls.sort_by(f64::total_cmp);
        let falls = &outcome.falls;
        let quantile = |part: usize| falls.get(falls.len() * part / 20).copied().unwrap_or(f64::NAN);
        let found = [1, 10, 19].map(quantile);
        let Outcome { done, refused, .. } = outcome;
        println!(
            "  {}: order {}, {found:.2?} of {}; {done} done, {refused} refused",
            row.name,
            row.order,
            falls.len()
        );
        assert!(10 * refused <= done, "{}: {refused} refused of {done}", row.name);
        // Means of few, and steps of methods of high order that are still too long for it, say little.
        if falls.len() >= 4 * row.order as usize {
            let order = f64::from(row.order);
            assert!((found[1] - order).abs() <= 0.05 * order, "{}: {found:.2?}", row.name);
            judged += 1;
        }
    }
    assert!(judged >= 12, "{judged} methods");
}

fn vector(random: &mut StdRng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| random.random_range(-1.0..1.0))
}

/// A particle on a quadric with two waves, each of a length down to 1e-3 of the size.
fn on_waves(random: &mut StdRng, outcomes: &mut [Outcome]) {
    let mut a = [0.0; 6];
    a[..3].fill_with(|| random.random_range(0.2..2.0));
    a[3..].fill_with(|| random.random_range(-0.3..0.3));
    let numbers = [(); 2].map(|()| 10_f64.powf(random.random_range(0.0..3.0)));
    let height = numbers.map(|number| random.random_range(0.0..0.3) / (number * number));
    let [u, w] = numbers.map(|number| vector(random).normalize() * number);
    let phase = [(); 2].map(|()| random.random_range(0.0..6.0));
    let s = [(); 3].map(|()| random.random_range(-1.0..1.0));
    let surface = Waves { a, height, u: u.into(), w: w.into(), phase, level: 1.0 };
    let scene = Scene::on(surface).with(Hill { s });
    let Ok(start) = scene.project(&State::at(vector(random)).moving(vector(random))) else { return };

    let [xx, yy, zz, xy, yz, zx] = a;
    let form = Matrix3::new(2.0 * xx, xy, zx, xy, 2.0 * yy, yz, zx, yz, 2.0 * zz);
    let waves = [(height[0], u, phase[0]), (height[1], w, phase[1])];
    let constraints = move |q: &DVector<f64>, v: &DVector<f64>| {
        let [q, v] = [q, v].map(|all| Vector3::from_column_slice(all.as_slice()));
        let (mut normal, mut curvature) = (form * q, (form * v).dot(&v));
        for (height, u, phase) in waves {
            let (sin, cos) = (u.dot(&q) + phase).sin_cos();
            normal += u * (height * cos);
            curvature -= height * u.dot(&v).powi(2) * sin;
        }
        (DMatrix::from_row_slice(1, 3, normal.as_slice()), DVector::from_element(1, curvature))
    };
    let force = move |q: &DVector<f64>| -> DVector<f64> {
        DVector::from_vec(vec![-2.0 * s[0] * q[0], -s[1] * q[2], -s[1] * q[1] - s[2]])
    };
    let equation = Equation {
        inverse_masses: DVector::from_element(3, 1.0),
        force: Box::new(force),
        constraints: Box::new(constraints),
    };
    let speed = start.momenta().next().unwrap().amax().max(0.1);
    let time = random.random_range(0.5..1.5) / (speed * numbers[0].max(numbers[1]));
    put(&scene, &start, &equation, (time, random.random_range(24..64)), outcomes);
}

/// Bodies in the plane that a tree of rods links, and now and then rods that close loops; weights and springs.
fn of_rods(random: &mut StdRng, outcomes: &mut [Outcome]) {
    let bodies = random.random_range(2..7_usize);
    let places: Vec<[f64; 2]> =
        (0..bodies).map(|_| [(); 2].map(|()| random.random_range(-2.0..2.0))).collect();
    let mut rods: Vec<[usize; 2]> = (1..bodies).map(|i| [random.random_range(0..i), i]).collect();
    for _ in 0..random.random_range(0..3) {
        let (a, b) = (random.random_range(0..bodies), random.random_range(0..bodies));
        if a < b && !rods.contains(&[a, b]) && rods.len() + 3 < 2 * bodies {
            rods.push([a, b]);
        }
    }
    let masses: Vec<f64> = (0..bodies).map(|_| random.random_range(0.3..3.0)).collect();
    let pinned = random.random_bool(0.5);
    let springs: Vec<(f64, [usize; 2])> = (0..random.random_range(0..3))
        .map(|_| (random.random_range(0.0..2.0), [0, random.random_range(1..bodies)]))
        .collect();
    let away = |[a, b]: [usize; 2]| (places[a][0] - places[b][0]).hypot(places[a][1] - places[b][1]);
    if rods.iter().any(|&rod| away(rod) < 0.3) {
        return;
    }
    let mut scene = Scene::points(bodies)
        .link_each(rods.iter().map(|&rod| (Rod { length: away(rod) }, rod)).collect::<Vec<_>>())
        .masses(masses.clone());
    if pinned {
        scene = scene.pin(0, places[0]);
    }
    let pulls = Over::each(springs.iter().map(|&(k, pair)| (Pull { k }, pair)).collect::<Vec<_>>());
    let scene = scene.with(weights(1.0, masses.iter().copied())).with(pulls);
    let momenta: Vec<[f64; 2]> =
        (0..bodies).map(|_| [(); 2].map(|()| random.random_range(-1.0..1.0))).collect();
    let Ok(start) = scene.project(&State::of(places).with_momenta(momenta)) else { return };

    let inverse_masses =
        DVector::from_fn(2 * bodies, |i, _| if pinned && i < 2 { 0.0 } else { 1.0 / masses[i / 2] });
    let between = |q: &DVector<f64>, [a, b]: [usize; 2]| [0, 1].map(|i| q[2 * a + i] - q[2 * b + i]);
    let links = rods.clone();
    let constraints = move |q: &DVector<f64>, v: &DVector<f64>| {
        let mut jacobian = DMatrix::zeros(links.len(), q.len());
        let mut curvature = DVector::zeros(links.len());
        for (row, &[a, b]) in links.iter().enumerate() {
            let (apart, moving) = (between(q, [a, b]), between(v, [a, b]));
            for i in 0..2 {
                jacobian[(row, 2 * a + i)] = 2.0 * apart[i];
                jacobian[(row, 2 * b + i)] = -2.0 * apart[i];
                curvature[row] += 2.0 * moving[i] * moving[i];
            }
        }
        (jacobian, curvature)
    };
    let force = move |q: &DVector<f64>| {
        let mut force = DVector::from_fn(q.len(), |i, _| if i % 2 == 1 { -masses[i / 2] } else { 0.0 });
        for &(k, [a, b]) in &springs {
            for (i, apart) in between(q, [a, b]).into_iter().enumerate() {
                force[2 * a + i] -= k * apart;
                force[2 * b + i] += k * apart;
            }
        }
        force
    };
    let equation = Equation { inverse_masses, force: Box::new(force), constraints: Box::new(constraints) };
    let q = DVector::from_vec(start.positions().flat_map(<[f64; 2]>::from).collect());
    let (mut scaled, _) = (equation.constraints)(&q, &q);
    for mut row in scaled.row_iter_mut() {
        row.component_mul_assign(&equation.inverse_masses.map(f64::sqrt).transpose());
        let norm = row.norm();
        row /= norm;
    }
    if scaled.singular_values().min() < 0.2 {
        return; // rods that nearly depend on each other want steps of their own
    }
    put(&scene, &start, &equation, (random.random_range(0.3..1.5), random.random_range(24..64)), outcomes);
}

/// 500 scenes drawn from a seed.
fn scenes(what: &str, seed: u64, draw: fn(&mut StdRng, &mut [Outcome])) {
    let mut random = StdRng::seed_from_u64(seed);
    let mut outcomes: Vec<_> = rows().iter().map(|_| Outcome::default()).collect();
    for _ in 0..500 {
        draw(&mut random, &mut outcomes);
    }
    check(what, outcomes);
}

#[test]
fn on_random_surfaces() {
    scenes("surfaces", 31, on_waves);
}

#[test]
fn of_random_networks() {
    scenes("networks", 32, of_rods);
}
