//! Effects that see time, and effects that see momenta: a force that changes with time, and drag as a flow of momenta,
//! on surfaces, of links and of rigid bodies.

use crate::common::Gravity;
use rattle::effect::{Acting, Effect, Flow, Interval, Moment};
use rattle::ensemble::InstructionSet;
use rattle::lanes::Lane;
use rattle::links::planar::Rod;
use rattle::nalgebra::{Matrix3, Vector3};
use rattle::prelude::*;
use rattle::real::Real;
use rattle::surfaces::Sphere;
use std::array::from_fn;

constraint! {
    /// z = 0.
    struct Floor {}
    |_x, _y, z| z
}

constraint! {
    /// The body is led along x = c t.
    struct Led { c }
    |x, _y, t| x - c * t
}

potential! {
    /// A uniform field that oscillates.
    struct Swinging {}
    |x, _y, _z, t| -cos(2 * t) * x
}

/// f = t (c + A q).
#[derive(Debug, Clone)]
struct Growing<const D: usize> {
    constant: [f64; D],
    matrix: [[f64; D]; D],
}

impl<const D: usize> Growing<D> {
    fn along(constant: [f64; D]) -> Self {
        Self { constant, matrix: [[0.0; D]; D] }
    }
}

/// The kind of effect that grows with time.
struct WithTime;

impl<const D: usize> Effect<D, WithTime> for Growing<D> {
    type Acting<T: Real> = Self;
    fn acting<T: Real>(&self) -> Self {
        self.clone()
    }
    type Swept<S: Lane, const L: usize> = [Self; L];
}

impl<T: Real, const D: usize> Acting<T, D> for Growing<D> {
    type Room = ();
    fn room(&self, _: usize) {}
    fn changes_with_time(&self) -> bool {
        true
    }
    fn add_forces(&self, at: Moment<'_, T, D>, (): &mut (), forces: &mut [[T; D]]) {
        for (q, force) in at.positions.iter().zip(forces) {
            *force = from_fn(|d| {
                let own = (0..D).map(|k| T::from_f64(self.matrix[d][k]) * q[k]);
                let sum = own.fold(T::from_f64(self.constant[d]), |sum, term| sum + term);
                force[d] + T::from_f64(at.time) * sum
            });
        }
    }
    fn energy(&self, _: Moment<'_, T, D>) -> T {
        T::from_f64(0.0)
    }
}

/// ṗ = −γ p, times t/2 if it grows.
#[derive(Debug, Clone, Copy)]
struct Drag {
    gamma: f64,
    grows: bool,
}

impl<const D: usize> Flow<D> for Drag {
    fn flow<T: Real>(&self, during: &Interval<'_, T, D>, changes: &mut [[T; D]]) {
        let Interval { h, at, momenta, .. } = *during;
        let rate = self.gamma * if self.grows { 0.5 * at.time } else { 1.0 };
        for (change, p) in changes.iter_mut().zip(momenta) {
            *change = p.map(|p| T::from_f64((-rate * h).exp_m1()) * p);
        }
    }
    fn changes_with_time(&self) -> bool {
        self.grows
    }
}

/// ṗ = b v × e_z, by Rodrigues' formula.
#[derive(Debug, Clone, Copy)]
struct Magnetic(f64);

impl Flow<3> for Magnetic {
    fn flow<T: Real>(&self, during: &Interval<'_, T, 3>, changes: &mut [[T; 3]]) {
        let Interval { h, momenta, .. } = *during;
        let (sin, half) = ((self.0 * h).sin(), (0.5 * self.0 * h).sin());
        let (sin, less) = (T::from_f64(sin), T::from_f64(-2.0 * half * half));
        for (change, &[x, y, _]) in changes.iter_mut().zip(momenta) {
            *change = [less * x + sin * y, less * y - sin * x, T::from_f64(0.0)];
        }
    }
}

/// Drag along x alone, which turning does not commute with.
#[derive(Debug, Clone, Copy)]
struct AlongX(f64);

impl Flow<3> for AlongX {
    fn flow<T: Real>(&self, during: &Interval<'_, T, 3>, changes: &mut [[T; 3]]) {
        let Interval { h, momenta, .. } = *during;
        let (lost, none) = (T::from_f64((-self.0 * h).exp_m1()), T::from_f64(0.0));
        let changed = changes.iter_mut().zip(momenta);
        changed.for_each(|(change, p)| *change = [lost * p[0], none, none]);
    }
}

/// Flows that do not commute: the last one of the first half is the first one of the second.
#[test]
fn flows_stand_symmetrically_about_a_step() {
    let scene = Scene::point().with(Gravity { g: 1.0 }).with(Magnetic(2.0)).with(AlongX(0.7));
    let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 1.0, 0.5]);
    let mut checked = scene.simulate(start, Rattle::new(0.1)).unwrap().check_reversal(1e-14).unwrap();
    checked.run(40).unwrap();
}

const DRAG: Drag = Drag { gamma: 0.3, grows: false };

fn bits<const D: usize>(state: &State<D>) -> Vec<u64> {
    let all = state.positions().chain(state.momenta());
    all.flat_map(|q| <[f64; D]>::from(q).map(f64::to_bits)).collect()
}

/// By the method, off the place where ẍ = t leads from rest at x = 0 between t = 1 and t = 3: (27 − 1)/6 − 1.
macro_rules! off_after_two {
    ($scene:expr, $start:expr, $method:expr) => {{
        let (scene, method) = ($scene, $method);
        let steps = (2.0 / method.step_size()).round() as u64;
        let mut simulation = scene.simulate($start.at_time(1.0), method).unwrap();
        simulation.run(steps / 2).unwrap();
        let mut again = scene.simulate(simulation.state(), $method).unwrap();
        simulation.run(steps / 2).unwrap();
        again.run(steps / 2).unwrap();
        assert_eq!(bits(&simulation.state()), bits(&again.state()), "{}", stringify!($method));
        assert_eq!(simulation.time(), 3.0);
        let (x, p) = (simulation.position()[0], simulation.momentum()[0]);
        [x - 10.0 / 3.0, p - 4.0].map(f64::abs)
    }};
}

#[test]
fn forces_that_grow_with_time() {
    let floor = || Scene::on(Floor {}).with(Growing::along([1.0, 0.0, 0.3]));
    let point = || Scene::point().with(Growing::along([1.0, 0.0]));
    let (on_floor, at_point) = (|| State::at([0.0, 0.5, 0.0]), || State::at([0.0, 0.5]));
    macro_rules! both {
        ($method:expr) => {
            [off_after_two!(floor(), on_floor(), $method), off_after_two!(point(), at_point(), $method)]
        };
    }
    // Of second order: momenta exact where kicks are those of the trapezoid or midpoint, positions off by h²/3 and
    // h²/6.
    for [place, momentum] in both!(Rattle::new(0.125)) {
        assert!(
            (place - 0.125_f64.powi(2) / 3.0).abs() < 1e-14 && momentum < 1e-14,
            "{place:e} {momentum:e}"
        );
    }
    for [place, momentum] in both!(PositionVerlet::new(0.125)) {
        assert!(
            (place - 0.125_f64.powi(2) / 6.0).abs() < 1e-14 && momentum < 1e-14,
            "{place:e} {momentum:e}"
        );
    }
    // Of first order, but of the time of the positions' end.
    for [place, momentum] in both!(SymplecticEuler::new(0.125)) {
        assert!(place < 0.3 && momentum < 0.126 && momentum > 0.1, "{place:e} {momentum:e}");
    }
    // Exact.
    let composed = || Composition::new(SUZUKI_1990_ORDER_4, 0.125);
    for off in
        both!(composed()).into_iter().chain(both!(Lobatto::<3>::new(0.125))).chain(both!(Dop853::new(0.125)))
    {
        assert!(off.iter().all(|off| *off < 1e-13), "{off:?}");
    }
}

/// Where a moment that grows with time turns a rigid body about its axis: θ = t³/6 after rest at t = 0.
#[test]
fn moments_that_grow_with_time() {
    let moment = 0.7;
    let mut matrix = [[0.0; 9]; 9]; // F = ½ τ t ê_z Q gives the moment τ t about z
    for j in 0..3 {
        (matrix[j][3 + j], matrix[3 + j][j]) = (-0.5 * moment, 0.5 * moment);
    }
    let body = Rigid::new([1.0, 1.3, 0.7]);
    let scene = Scene::rigid(body).with(Growing { constant: [0.0; 9], matrix });
    let start = || Rigid::start(&Matrix3::identity(), &Vector3::zeros());
    let off = |h: f64| {
        let mut simulation = scene.simulate(start(), Rattle::new(h)).unwrap();
        simulation.run((2.0 / h).round() as u64).unwrap();
        let attitude = Rigid::attitude(&simulation.position().into());
        let angle = 8.0 / 6.0; // τ/J = 1
        (attitude[(0, 0)] - f64::cos(angle)).abs().max((attitude[(1, 0)] - f64::sin(angle)).abs())
    };
    let (coarse, fine) = (off(0.02), off(0.01));
    assert!(coarse < 1e-3 && (3.9..4.1).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
}

#[test]
fn methods_that_cannot_see_time_are_refused() {
    let scene = Scene::on(Floor {}).with(Growing::along([1.0, 0.0, 0.0]));
    let start = || State::at([0.0; 3]);
    let error = scene.simulate(start(), Bdf2::new(0.1)).unwrap_err().to_string();
    assert!(error.contains("cannot move constraints or forces that change with time"), "{error}");
    assert!(scene.simulate(start(), Taylor::new(8, 0.1)).is_err());
    let scene = Scene::point().with(Growing::along([1.0, 0.0, 0.0]));
    let error = scene.simulate(start(), Bdf2::new(0.1)).unwrap_err().to_string();
    assert!(error.contains("cannot move constraints or forces that change with time"), "{error}");
    assert!(scene.simulate(start(), Taylor::new(8, 0.1)).is_err());
}

/// A refusal names the methods that accept the scene, and no others: each is tried.
#[test]
fn who_can_see_time_is_told() {
    let (h, start) = (0.1, || State::at([0.1, 0.2, 0.0]));
    macro_rules! check {
        ($scene:expr) => {{
            let scene = $scene;
            let rattle::Error::CannotMove { others, .. } = scene.simulate(start(), Bdf2::new(h)).unwrap_err()
            else {
                panic!("Bdf2 is refused")
            };
            macro_rules! named {
                ($name:literal, $method:expr) => {{
                    let method = $method;
                    let start = scene.staggered(&start(), &method).unwrap();
                    let moves =
                        scene.simulate(start, method).map(|mut simulation| simulation.run(3).unwrap());
                    assert_eq!(others.contains(&$name), moves.is_ok(), "{}: {others:?}", $name);
                }};
            }
            named!("Rattle", Rattle::new(h));
            named!("Baoab", Baoab::new(h));
            named!("NoseHoover", NoseHoover::new(1.0, 0.5, h));
            named!("Brownian", Brownian::new(1.0, 1.0, 1, h));
            named!("Geodesic", Geodesic::new(2, h));
            named!("PositionVerlet", PositionVerlet::new(h));
            named!("Shake", Shake::new(h));
            named!("SymplecticEuler", SymplecticEuler::new(h));
            named!("Leapfrog", Leapfrog::new(h));
            named!("Lobatto", Lobatto::<3>::new(h));
            named!("Dop853", Dop853::new(h));
            named!("Taylor", Taylor::new(8, h));
            named!("Bdf2", Bdf2::new(h));
            named!("Variable", Variable::of(Rattle::new(h), 0.5));
            others.len()
        }};
    }
    let told = [
        check!(Scene::point().with(Swinging {})),
        check!(Scene::on(Floor {}).with(Swinging {})),
        check!(Scene::on(Floor {}).with(Growing::along([1.0, 0.0, 0.0]))),
    ];
    assert!(told.iter().all(|number| *number > 3), "{told:?}");
}

/// The speed under drag falls by exp(−γ t) exactly where no force acts, however long the steps; what it took is work.
#[test]
fn drag_is_exact_without_forces() {
    let left = (-0.3_f64 * 2.0).exp();
    macro_rules! check {
        ($scene:expr, $start:expr, $method:expr) => {{
            let mut simulation = $scene.with(DRAG).simulate($start, $method).unwrap();
            let energy = simulation.energy();
            simulation.run((2.0 / simulation.method().step_size()).round() as u64).unwrap();
            let error = (simulation.energy() / energy / (left * left) - 1.0).abs();
            assert!(error < 1e-13, "{} {error:e}", stringify!($method));
            let work = (simulation.work() / energy - (left * left - 1.0)).abs();
            assert!(work < 1e-13 && simulation.energy_error().abs() < 1e-14 * energy, "{work:e}");
        }};
    }
    let on_sphere = || State::at([0.0, 0.0, 1.0]).moving([0.8, 0.6, 0.0]);
    check!(Scene::on(Sphere { r: 1.0 }), on_sphere(), Rattle::new(0.1));
    check!(Scene::on(Sphere { r: 1.0 }), on_sphere(), Lobatto::<3>::new(0.1));
    check!(Scene::on(Sphere { r: 1.0 }), on_sphere(), Geodesic::new(3, 0.1));
    let two = || State::of([[1.0, 0.0], [2.0, 0.0]]).with_momenta([[0.0, 1.0], [0.0, 2.0]]);
    let links = || rods().masses([1.0, 2.5]);
    check!(links(), links().project(&two()).unwrap(), Rattle::new(0.1));
    check!(links(), links().project(&two()).unwrap(), Lobatto::<2>::new(0.1));
    let top = Rigid::new([1.0, 1.0, 1.0]);
    let spin = || Rigid::start(&Matrix3::identity(), &Vector3::new(0.3, 0.2, 0.9));
    check!(Scene::rigid(top), spin(), Rattle::new(0.1));
}

fn rods() -> Scene<rattle::network::Network<2>, (), rattle::bodies::Many, 2> {
    Scene::points::<2>(2).link(Rod { length: 1.0 }, [[0, 1]])
}

/// With forces the division is of second order, and the energy error is that of the method, however much energy drag
/// takes.
#[test]
fn drag_with_weight() {
    let (start, sphere) = (State::at([1.0, 0.0, 0.0]).moving([0.0, 1.0, 0.5]), Sphere { r: 1.0 });
    for grows in [false, true] {
        let scene = Scene::on(sphere).with(Gravity { g: 1.0 }).with(Drag { gamma: 0.3, grows });
        let end = |h: f64| {
            let mut simulation = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
            simulation.run((4.0 / h).round() as u64).unwrap();
            assert!(simulation.work() < -0.3, "drag takes energy");
            (simulation.position(), simulation.energy_error().abs())
        };
        let ((a, first), (b, second), (c, _)) = (end(0.04), end(0.02), end(0.01));
        let ratio = (a - b).norm() / (b - c).norm();
        assert!((3.8..4.2).contains(&ratio), "{ratio} {grows}");
        assert!(first < 1e-3 && (3.0..5.0).contains(&(first / second)), "{first:e} {second:e}");
    }
}

#[test]
fn flows_go_back_restart_and_clone() {
    let scene = Scene::on(Sphere { r: 1.0 }).with(Gravity { g: 1.0 });
    let scene = scene
        .with(Drag { gamma: 0.3, grows: true })
        .with(Magnetic(0.7))
        .with(Drag { gamma: -0.2, grows: false });
    let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 1.0, 0.5]).at_time(0.3);
    let run = || scene.simulate(start.clone(), Rattle::new(0.05)).unwrap();
    let mut whole = run();
    let allocated = allocation_counter::measure(|| whole.run(20).unwrap());
    assert_eq!(allocated.count_total, 0);
    let mut again = scene.simulate(whole.state(), Rattle::new(0.05)).unwrap();
    let mut cloned = whole.clone();
    [&mut whole, &mut again, &mut cloned].into_iter().for_each(|simulation| simulation.run(20).unwrap());
    assert_eq!(bits(&whole.state()), bits(&again.state()));
    assert_eq!(bits(&whole.state()), bits(&cloned.state()));

    // Drag reverses, in the opposite order on the way back; an ensemble's trajectories do the same as each alone.
    let drags = Scene::on(Sphere { r: 1.0 })
        .with(Gravity { g: 1.0 })
        .with(DRAG)
        .with(Drag { gamma: 0.2, grows: true });
    let mut checked =
        drags.simulate(start.clone(), Rattle::new(0.05)).unwrap().check_reversal(1e-13).unwrap();
    checked.run(40).unwrap();
    let mut plain = drags.simulate(start.clone(), Rattle::new(0.05)).unwrap();
    plain.run(40).unwrap();
    assert_eq!(bits(&plain.state()), bits(&checked.state()));
    for set in [InstructionSet::Portable, InstructionSet::widest()] {
        let starts = vec![start.clone(); 3];
        let mut ensemble = Ensemble::of(Double, &drags, starts, Rattle::new(0.05), set).unwrap();
        ensemble.run(40);
        let (one, other) = (ensemble.state(2), plain.state());
        if set.fuses() {
            // In lanes, to rounding.
            let apart = one.positions().zip(other.positions()).chain(one.momenta().zip(other.momenta()));
            assert!(apart.into_iter().all(|(a, b)| (a - b).norm() < 1e-13), "{one:?} {other:?}");
        } else {
            assert_eq!(bits(&one), bits(&other));
        }
    }

    // A step in parts.
    let fast = State::at([1.0, 0.0, 0.0]).moving([0.0, 30.0, 0.0]);
    let mut parts = drags.simulate(fast, Rattle::new(0.05)).unwrap();
    let before = (bits(&parts.state()), parts.work());
    assert!(parts.step().is_err());
    assert_eq!((bits(&parts.state()), parts.work()), before);
    let mut parts = parts.retry(6);
    parts.run(4).unwrap();
    assert!(parts.energy_error().abs() < 1e-2 * parts.work().abs(), "{:e}", parts.energy_error());
}

/// A charge in a plane runs around a circle: each half turns the momentum by its own angle, and takes no energy.
#[test]
fn magnetic_fields_turn() {
    let scene = Scene::on(Floor {}).with(Magnetic(2.0));
    let mut simulation =
        scene.simulate(State::at([0.0; 3]).moving([1.0, 0.0, 0.0]), Rattle::new(0.05)).unwrap();
    simulation.run(40).unwrap();
    let (p, angle) = (simulation.momentum(), 4.0_f64);
    assert!((p.x - angle.cos()).abs() < 1e-14 && (p.y + angle.sin()).abs() < 1e-14, "{p}");
    assert!(simulation.work().abs() < 1e-15 && simulation.energy_error().abs() < 1e-15);
}

/// What drag takes from a body that is led, the lead gives back: no work remains of the two.
#[test]
fn links_that_move_and_pins() {
    let led = Scene::point::<2>().link_moving(Led { c: 2.0 }, [[0]]).with(DRAG);
    let mut simulation = led.simulate(State::at([0.0, 0.0]).moving([2.0, 1.0]), Rattle::new(0.1)).unwrap();
    simulation.run(20).unwrap();
    let y = (-0.6_f64).exp();
    assert!((simulation.momentum().x - 2.0).abs() < 1e-14 && (simulation.momentum().y - y).abs() < 1e-14);
    assert!((simulation.work() - 0.5 * (y * y - 1.0)).abs() < 1e-13, "{}", simulation.work());
    assert!(simulation.energy_error().abs() < 1e-13, "{:e}", simulation.energy_error());

    /// Every momentum grows.
    #[derive(Clone)]
    struct Wind;
    impl Flow<2> for Wind {
        fn flow<T: Real>(&self, during: &Interval<'_, T, 2>, changes: &mut [[T; 2]]) {
            let Interval { h, velocities, .. } = *during;
            let pushed = |(change, v): (&mut [T; 2], &[T; 2])| {
                *change = v.map(|v| T::from_f64(h) * (T::from_f64(1.0) - v))
            };
            changes.iter_mut().zip(velocities).for_each(pushed);
        }
    }
    let pinned = rods().pin(0, [0.0, 0.0]).with(Wind);
    let start = pinned.project(&State::of([[0.0, 0.0], [0.0, 1.0]])).unwrap();
    let mut simulation = pinned.simulate(start, Rattle::new(0.01)).unwrap();
    simulation.run(10).unwrap();
    let momenta: Vec<_> = simulation.momenta().collect();
    assert!(momenta[0].norm() == 0.0 && momenta[1].x > 0.08, "{momenta:?}");
    assert!(simulation.cotangent_residual() < 1e-14);
}

#[test]
fn methods_that_cannot_be_divided_are_refused() {
    let scene = Scene::point().with(DRAG);
    let start = || State::at([0.0, 0.0]).moving([1.0, 0.0]);
    macro_rules! refused {
        ($($method:expr),*) => {$(
            let error = scene.simulate(start(), $method).unwrap_err().to_string();
            assert!(error.contains("cannot move bodies under drag or another flow"), "{error}");
        )*};
    }
    refused!(
        Bdf2::new(0.1),
        Dop853::new(0.1),
        Leapfrog::new(0.1),
        Shake::new(0.1),
        SymplecticEuler::new(0.1)
    );
    refused!(Variable::of(Rattle::new(0.1), 1.0));
    assert!(scene.simulate(start(), Taylor::new(6, 0.1)).is_err());
}
