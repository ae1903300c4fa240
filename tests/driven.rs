//! Forces beyond potentials: potentials that change with time, and forces f(q, v, t), on surfaces, of links and of
//! rigid bodies; each against an exact solution or against classical Runge–Kutta steps of the equations written by
//! hand.

use rattle::error::{EffectFailure, Error, StepFailure};
use rattle::links::planar::Rod;
use rattle::nalgebra::{Matrix3, SVector, Vector3};
use rattle::prelude::*;
use rattle::surfaces::Sphere;
use std::array::from_fn;

potential! {
    /// A spring, and a uniform field that oscillates.
    struct Shaken { a, w }
    |x, _y, t| x^2 / 2 - a * cos(w * t) * x
}

potential! {
    /// Weight that turns about y, and grows where x is.
    struct Turning { g, w }
    |x, _y, z, t| g * (cos(w * t) * z + sin(w * t) * x + x^2 * t / 20)
}

potential! {
    /// A moment that comes and goes, on the third axis of a rigid body.
    struct Tide { b }
    |q: [[f64; 3]; 3], t| -b * cos(2 * t) * q[2][2]
}

force! {
    /// Friction that is stronger along x, a field that turns velocities about z, and a push that oscillates: on a
    /// sphere, all three have parts along the normal.
    struct Storm { friction, field, push }
    |q: [f64; 3], v: [f64; 3], t| [
        -3 * friction * v[0] * (1 + norm(v)) + field * v[1] + push * q[1] * cos(t),
        -friction * v[1] - field * v[0] + push * sin(2 * t),
        -friction * v[2] * (1 + q[0]^2)
    ]
}

force! {
    /// Friction between two bodies that grows with speed and with time, and a push of one by the other that is not
    /// returned.
    struct Between { friction, push }
    |a: [f64; 2], b: [f64; 2], va: [f64; 2], vb: [f64; 2], t| {
        let along = friction * (1 + t / 4) * (1 + dot(va - vb, va - vb)) * (va - vb);
        [-along + push * (b - a), along]
    }
}

force! {
    /// A motor about the third axis of a rigid body, with friction.
    struct Motor { torque, friction }
    |_attitude: [f64; 9], rate: [f64; 9]| [0, 0, torque - friction * rate[2], [0, 0, 0, 0, 0, 0]]
}

force! {
    /// Friction that is linear and friction that is dry, and a force that ends at an edge.
    struct Rough { linear, dry, edge }
    |x, _y, vx, vy| [-linear * vx - dry * sign(vx) + 0.1 * sqrt(edge - x), -linear * vy]
}

/// The same for every h, in turn: how much an error falls as h is halved, as the power of two.
fn order(errors: [f64; 2]) -> f64 {
    (errors[0] / errors[1]).log2()
}

/// Classical Runge–Kutta steps of ẏ = f(t, y).
fn runge_kutta<const N: usize>(
    f: &dyn Fn(f64, &[f64; N]) -> [f64; N],
    mut y: [f64; N],
    time: f64,
    steps: u32,
) -> [f64; N] {
    let h = time / f64::from(steps);
    let plus = |y: &[f64; N], c: f64, f: &[f64; N]| from_fn(|i| y[i] + c * f[i]);
    for step in 0..steps {
        let t = h * f64::from(step);
        let a = f(t, &y);
        let b = f(t + 0.5 * h, &plus(&y, 0.5 * h, &a));
        let c = f(t + 0.5 * h, &plus(&y, 0.5 * h, &b));
        let d = f(t + h, &plus(&y, h, &c));
        y = from_fn(|i| y[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
    }
    y
}

/// The largest difference of two lists of numbers.
fn apart(a: impl IntoIterator<Item = f64>, b: &[f64]) -> f64 {
    a.into_iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn composed(h: f64) -> Composition {
    Composition::new(SUZUKI_1990_ORDER_4, h)
}

/// ẍ = −x + a cos wt from rest: x = a (cos wt − cos t)/(1 − w²). The energy error, with the work of the field, falls
/// with the order of the method, as the error does.
#[test]
fn forced_oscillator() {
    let (a, w, end) = (0.7, 2.3_f64, 6.0_f64);
    let x = a * ((w * end).cos() - end.cos()) / (1.0 - w * w);
    macro_rules! check {
        ($h:expr, $method:expr, $order:expr) => {{
            let errors = [$h, 0.5 * $h].map(|h| {
                let scene = Scene::point().with(Shaken { a, w });
                let mut simulation = scene.simulate(State::at([0.0, 0.0]), $method(h)).unwrap();
                let mut largest = 0.0_f64;
                for _ in 0..(end / h).round() as u32 {
                    simulation.step().unwrap();
                    largest = largest.max(simulation.energy_error().abs());
                }
                assert!(simulation.work().abs() > 0.02, "the field does work: {}", simulation.work());
                [(simulation.position().x - x).abs(), largest]
            });
            for i in 0..2 {
                let found = order([errors[0][i], errors[1][i]]);
                // Half a power for what higher powers of h add.
                assert!(
                    (found - f64::from($order)).abs() < 0.5,
                    "{} {errors:?} {found}",
                    stringify!($method)
                );
            }
        }};
    }
    check!(0.1, composed, 4);
    check!(0.2, Lobatto::<4>::new, 6);
}

/// The energy error of a symplectic method swings, and does not grow: as large in the last quarter of 4000 periods'
/// worth of time as in the first, while the work is a hundred times as large.
#[test]
fn energy_does_not_drift() {
    let scene = Scene::point().with(Shaken { a: 0.7, w: 2.3 });
    let mut simulation = scene.simulate(State::at([0.0, 0.0]), composed(0.1)).unwrap();
    let mut quarter = || {
        let (mut error, mut work) = (0.0_f64, 0.0_f64);
        for _ in 0..50_000 {
            simulation.step().unwrap();
            error = error.max(simulation.energy_error().abs());
            work = work.max(simulation.work().abs());
        }
        (error, work)
    };
    let quarters = [quarter(), quarter(), quarter(), quarter()];
    assert!(quarters[0].1 > 100.0 * quarters[0].0, "{quarters:?}");
    assert!((quarters[3].0 / quarters[0].0 - 1.0).abs() < 0.01, "{quarters:?}");
}

/// On a sphere, in a field that turns, where friction, field and push all have parts along the normal: against
/// q̈ = F − (|v|² + n·F) n. DOP853 without the force, RATTLE with it.
#[test]
fn on_a_surface() {
    let (storm, turning) = (Storm { friction: 0.2, field: 1.5, push: 0.6 }, Turning { g: 1.0, w: 1.7 });
    let driven = Scene::on(Sphere { r: 1.0 }).with(turning);
    let scene = driven.with(storm);
    let (q, v) = (Vector3::new(0.6, 0.0, 0.8), Vector3::new(0.0, 1.1, 0.0));
    let start = || State::at(q).moving(v);
    let end = |share: f64| {
        let rates = |t: f64, &[x, y, z, u, v, w]: &[f64; 6]| {
            let (q, v) = (Vector3::new(x, y, z), Vector3::new(u, v, w));
            let f = share * storm.value(&q, &v, t) - turning.gradient(&q, t);
            let a = f - q * (v.norm_squared() + q.dot(&f)) / q.norm_squared();
            [v.x, v.y, v.z, a.x, a.y, a.z]
        };
        runge_kutta(&rates, [q.x, q.y, q.z, v.x, v.y, v.z], 3.0, 6000)
    };

    let (exact, mut simulation) = (end(0.0), driven.simulate(start(), Dop853::new(0.05)).unwrap());
    simulation.run(60).unwrap();
    // Both far below: DOP853 of eighth order, in steps of 0.05; the reference of fourth, in steps of 5e-4.
    assert!(apart(<[f64; 3]>::from(simulation.position()), &exact) < 1e-10);
    assert!(simulation.work().abs() > 0.05 && simulation.energy_error().abs() < 1e-10);

    let exact = end(1.0);
    let [coarse, fine] = [0.01, 0.005].map(|h| {
        let mut simulation = scene.simulate(start(), Rattle::new(h)).unwrap();
        let allocated = allocation_counter::measure(|| simulation.run((3.0 / h).round() as u64).unwrap());
        assert_eq!(allocated.count_total, 0);
        let (q, v): ([f64; 3], [f64; 3]) = (simulation.position().into(), simulation.momentum().into());
        [apart(q.into_iter().chain(v), &exact), simulation.energy_error().abs()]
    });
    for (i, coarse) in coarse.into_iter().enumerate() {
        assert!(fine[i] < 2e-3 && (order([coarse, fine[i]]) - 2.0).abs() < 0.3, "{coarse:e} {fine:?}");
    }

    // Divided symmetrically: a step back undoes a step.
    let mut there = scene.simulate(start(), Rattle::new(0.02)).unwrap();
    there.run(50).unwrap();
    let mut back = scene.simulate(there.state(), Rattle::new(-0.02)).unwrap();
    back.run(50).unwrap();
    assert!((back.position() - q).norm() < 1e-13 && (back.momentum() - v).norm() < 1e-13);
}

/// Three bodies of which two are tied, a force between the first two and between the last two: so that members share a
/// body.
#[test]
fn force_between_linked_bodies() {
    let (between, masses) = (Between { friction: 0.4, push: 0.8 }, [1.0, 2.5, 0.7]);
    let scene = Scene::points::<2>(3).link(Rod { length: 1.0 }, [[0, 1]]).masses(masses);
    let scene = scene.with(between.over([[0, 1], [1, 2]]));
    let places = [[0.0, 0.0], [1.0, 0.0], [1.5, 1.0]];
    let momenta = [[0.2, 0.5], [0.5, -1.0], [0.0, 0.4]];
    let start = State::of(places).with_momenta(momenta);
    let pair = |q: &[f64], v: &[f64], t| {
        let [q, v] = [q, v].map(SVector::<f64, 4>::from_column_slice);
        between.value(&q, &v, t)
    };
    let rates = |t: f64, y: &[f64; 12]| {
        let (q, v) = y.split_at(6);
        let (first, last) = (pair(&q[..4], &v[..4], t), pair(&q[2..], &v[2..], t));
        let force = [first[0], first[1], first[2] + last[0], first[3] + last[1], last[2], last[3]];
        let mut a: [f64; 6] = from_fn(|i| force[i] / masses[i / 2]);
        let (rod, turn) = ([q[0] - q[2], q[1] - q[3]], [v[0] - v[2], v[1] - v[3]]);
        let bend = turn[0].powi(2) + turn[1].powi(2) + rod[0] * (a[0] - a[2]) + rod[1] * (a[1] - a[3]);
        let pull = -bend / (rod[0].powi(2) + rod[1].powi(2)) / (1.0 / masses[0] + 1.0 / masses[1]);
        for i in 0..2 {
            a[i] += pull * rod[i] / masses[0];
            a[2 + i] -= pull * rod[i] / masses[1];
        }
        from_fn(|i| if i < 6 { v[i] } else { a[i - 6] })
    };
    let at_start = scene.project(&start).unwrap();
    let numbers = |state: &State<2>| -> Vec<f64> {
        let speeds = state.momenta().zip(masses).flat_map(|(p, mass)| [p.x / mass, p.y / mass]);
        state.positions().flat_map(|q| [q.x, q.y]).chain(speeds).collect()
    };
    let first = numbers(&at_start);
    let exact = runge_kutta(&rates, from_fn(|i| first[i]), 2.0, 4000);
    let errors = [0.04, 0.02].map(|h| {
        let mut simulation = scene.simulate(at_start.clone(), Rattle::new(h)).unwrap();
        simulation.run((2.0 / h).round() as u64).unwrap();
        assert!(simulation.work().abs() > 0.1 && simulation.energy_error().abs() < 1e-13);
        apart(numbers(&simulation.state()), &exact)
    });
    assert!(errors[1] < 1e-3 && (order(errors) - 2.0).abs() < 0.2, "{errors:?}");
}

/// A top whose third axis is one of symmetry: J₃ Ω̇₃ = τ − c Ω₃ whatever else it does, and a tide that does work on it.
#[test]
fn force_on_a_rigid_body() {
    let body = Rigid::new([1.0, 1.0, 0.8]);
    let start = || Rigid::start(&Matrix3::identity(), &Vector3::new(0.4, -0.2, 0.5));
    let spin = |torque: f64, friction: f64, h: f64| {
        let scene = Scene::rigid(body).with(Tide { b: 0.9 }).with(Motor { torque, friction });
        let mut simulation = scene.simulate(start(), Rattle::new(h)).unwrap();
        simulation.run((2.0 / h).round() as u64).unwrap();
        (simulation.momentum()[2], simulation.energy_error().abs(), simulation.work())
    };
    // Without friction it grows linearly, and the tide acts on it not at all.
    let (grown, ..) = spin(0.3, 0.0, 0.05);
    assert!((grown - 1.1).abs() < 1e-14, "{grown}");
    let exact = 0.6 + (0.5 - 0.6) * (-0.4_f64 / 0.8 * 2.0).exp(); // J₃ τ/c = 0.6
    let [coarse, fine] = [0.1, 0.05].map(|h| spin(0.3, 0.4, h));
    let found = [coarse.0, fine.0].map(|spin| (spin - exact).abs());
    assert!(found[0] < 1e-3 && (order(found) - 2.0).abs() < 0.2, "{found:?}");
    let energy = order([coarse.1, fine.1]);
    assert!(fine.1 < 1e-3 && fine.2.abs() > 0.05 && (energy - 2.0).abs() < 0.3, "{coarse:?} {fine:?}");
}

/// However stiff friction is, it takes energy; where no change of the momentum is found, the step says so.
#[test]
fn stiff_and_rough() {
    let scene = |linear, dry, edge| Scene::point().with(Rough { linear, dry, edge });
    let start = || State::at([0.0, 0.0]).moving([1.0, 2.0]);
    let mut stiff = scene(1e6, 0.0, 1e3).simulate(start(), Rattle::new(0.01)).unwrap();
    let mut last = stiff.energy();
    for _ in 0..5000 {
        stiff.step().unwrap();
        assert!(stiff.energy() < last * (1.0 + 1e-12) + 1e-12, "{} {last}", stiff.energy());
        last = stiff.energy();
    }
    assert!(last < 1e-3 && stiff.energy_error().abs() < 1e-13, "{last}");

    let failure = |linear, dry, edge| {
        let mut simulation = scene(linear, dry, edge).simulate(start(), Rattle::new(0.1)).unwrap();
        let Error::Step { step, cause, .. } = simulation.run(100).unwrap_err() else { panic!("no step") };
        let message = cause.to_string();
        let StepFailure::Effect(EffectFailure::FlowNotFound { effect: "Rough", position, .. }) = cause else {
            panic!("{message}")
        };
        assert!(step > 0 && message.contains("`Rough`"), "{message}");
        position[0]
    };
    assert!((0.9..1.1).contains(&failure(0.1, 0.0, 1.0)), "beyond the edge there is no force");
    failure(0.1, 5.0, 1e3); // where it comes to rest, dry friction as a jump has no solution
}

/// Derivatives against central differences, of an error of h² f‴/6 and ε f/h: 1e-8 for h = 1e-5.
#[test]
fn derivatives() {
    let (h, near) = (1e-5, |a: f64, b: f64| assert!((a - b).abs() < 1e-8 * (1.0 + b.abs()), "{a} {b}"));
    let storm = Storm { friction: 0.2, field: 1.5, push: 0.6 };
    let (q, v, t) = (Vector3::new(0.6, -0.3, 0.8), Vector3::new(0.4, 1.1, -0.7), 0.9);
    let slopes = storm.slopes(&q, &v, t);
    for j in 0..3 {
        let mut step = Vector3::zeros();
        step[j] = h;
        let difference = (storm.value(&q, &(v + step), t) - storm.value(&q, &(v - step), t)) / (2.0 * h);
        (0..3).for_each(|i| near(slopes[(i, j)], difference[i]));
    }
    let turning = Turning { g: 1.3, w: 1.7 };
    near(turning.rate(&q, t), (turning.value(&q, t + h) - turning.value(&q, t - h)) / (2.0 * h));
    for j in 0..3 {
        let mut step = Vector3::zeros();
        step[j] = h;
        let difference = (turning.value(&(q + step), t) - turning.value(&(q - step), t)) / (2.0 * h);
        near(turning.gradient(&q, t)[j], difference);
    }
}
