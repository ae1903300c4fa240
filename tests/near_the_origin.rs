//! Near the origin, where coordinates are smaller than what forces alone would move a body by in a step: it is that
//! whose rounding is left, and to ask for less refused small oscillations about an equilibrium.

use crate::common::larger;
use rattle::composition::SUZUKI_1990_ORDER_4;
use rattle::curvature::geodesic_distance;
use rattle::ensemble::Precision;
use rattle::nalgebra::Vector3;
use rattle::potentials::Gravity;
use rattle::prelude::*;
use rattle::surfaces::Plane;

constraint! { struct Bowl {} |x, y, z| z - (x^2 + 2 * y^2) / 2 }
constraint! { struct Curve {} |x, y, z| [z - x^2, y - x / 10] }

const G: f64 = 9.81;

/// Swings of this momentum about the bottom: they come to their size and keep it, and the surface to the rounding of
/// h²g.
fn swings<S: Method>(e: f64, method: &S) {
    let (h, name) = (method.step_size(), method.name());
    let start = State::at([0.0; 3]).moving([e, 0.7 * e, 0.0]);
    // Along x alone bodies swing as far as this; across it less far, and faster.
    let size = e / G.sqrt();
    let look = |q: Vector3<f64>, what: &str| {
        let off = q.z - (q.x * q.x + 2.0 * q.y * q.y) / 2.0;
        let floor = 8.0 * f64::EPSILON * (q.norm() + h * h * G);
        assert!(off.abs() <= floor, "{name}, {what}, p = {e:e}: {off:e} beside, {floor:e} is rounding");
        assert!(q.norm() < 1.3 * size, "{name}, {what}, p = {e:e}: {q:?}");
        q.norm()
    };
    let swung = |farthest: f64, what: &str| {
        assert!(farthest > 0.9 * size, "{name}, {what}, p = {e:e}: {farthest:e} of {size:e}");
    };
    let told = |what: &str, error: rattle::Error| panic!("{name}, {what}, p = {e:e}: {error}");
    let scene = Scene::on(Bowl {}).with(Gravity { g: G });
    let mut surface = scene.simulate(start.clone(), method.clone()).unwrap();
    let mut farthest = 0.0;
    surface
        .run_with(300, |now| farthest = larger(farthest, look(now.position(), "surface")))
        .unwrap_or_else(|error| told("surface", error));
    swung(farthest, "surface");
    let scene = Scene::on(Bowl {}).mass(1.0).with(Gravity { g: G });
    let mut linked = scene.simulate(start, method.clone()).unwrap();
    let mut farthest = 0.0;
    linked
        .run_with(300, |now| farthest = larger(farthest, look(now.position(), "linked")))
        .unwrap_or_else(|error| told("linked", error));
    swung(farthest, "linked");
}

#[test]
fn small_swings_go_on() {
    for k in 2..15 {
        let e = 10_f64.powi(-k);
        swings(e, &Rattle::new(0.01));
        swings(e, &Composition::of(SUZUKI_1990_ORDER_4, Rattle::new(0.05)));
        swings(e, &Lobatto::<3>::new(0.05));
        swings(e, &Lobatto::<5>::new(0.05));
        swings(e, &Bdf2::new(0.01));
        swings(e, &Dop853::new(0.05));
        swings(e, &Taylor::new(12, 0.05));
    }
}

/// Two equations of one body, and many bodies at once, which go in rows.
#[test]
fn small_swings_along_a_curve() {
    for k in 2..15 {
        let e = 10_f64.powi(-k);
        let start = State::at([0.0; 3]).moving([e, 0.1 * e, 0.0]);
        let scene = Scene::on(Curve {}).with(Gravity { g: G });
        let mut farthest = 0.0;
        let mut run = scene.simulate(start.clone(), Rattle::new(0.01)).unwrap();
        let run = run.run_with(1000, |now| farthest = larger(farthest, now.position().norm()));
        assert!(run.is_ok(), "1e-{k}: {run:?}");
        // The energy is ½ 1.01 ẋ² + g x².
        let size = 1.01 * e / (2.0 * G).sqrt();
        assert!(farthest > 0.9 * size && farthest < 1.1 * size, "1e-{k}: {farthest:e} of {size:e}");
        let many = Scene::on(Bowl {}).mass(1.0).bodies(100).with(Gravity { g: G });
        let start = State::of([[0.0; 3]; 100]).with_momenta([[e, 0.0, 0.0]; 100]);
        let mut farthest = [0.0; 100];
        let run = many.simulate(start, Rattle::new(0.01)).unwrap().run_with(300, |now| {
            let bodies = farthest.iter_mut().zip(now.positions());
            bodies.for_each(|(far, q)| *far = larger(*far, q.norm()));
        });
        assert!(run.is_ok(), "1e-{k}, many: {run:?}");
        let size = e / G.sqrt();
        let swung = farthest.iter().all(|far| (0.9 * size..1.1 * size).contains(far));
        assert!(swung, "1e-{k}, many: {farthest:?} of {size:e}");
    }
}

/// Thrown up a plane through the origin, a body is back after a step, on its way down: where it ends tells nothing of
/// how far it went.
#[test]
fn back_at_the_origin() {
    let plane = Plane { a: 0.5, b: 0.0, c: 0.75_f64.sqrt(), d: 0.0 };
    let down = Vector3::new(0.75_f64.sqrt(), 0.0, -0.5);
    for part in [1.0, 1.0 - 1e-12, 1.0 + 1e-9, 1.0 - 1e-6, 0.999, 1.0 + 1e-3] {
        fn back<S: Method>(plane: Plane, p: Vector3<f64>, method: S) {
            let start = State::at([0.0; 3]).moving(p);
            let surface = Scene::on(plane).with(Gravity { g: G });
            let back = |q: Vector3<f64>, now: Vector3<f64>| {
                let name = method.name();
                assert!(q.norm() < 1e-2 * method.step_size() * p.norm(), "{name}: {q:?}");
                // Of speeds that differ by a thousandth from that with which it is back to the bit.
                assert!((now + p).norm() < 1e-2 * p.norm(), "{name}: {now:?} for {:?}", -p);
            };
            let mut run = surface.simulate(surface.project(&start).unwrap(), method.clone()).unwrap();
            run.run(1).unwrap_or_else(|error| panic!("{}, surface: {error}", method.name()));
            back(run.position(), run.momentum());
            let linked = Scene::on(plane).mass(1.0).with(Gravity { g: G });
            let mut run = linked.simulate(linked.project(&start).unwrap(), method.clone()).unwrap();
            run.run(1).unwrap_or_else(|error| panic!("{}, linked: {error}", method.name()));
            back(run.position(), run.momentum());
        }
        let (h, p) = (0.01, -part * 0.5 * 0.01 * G * 0.5 * down);
        back(plane, p, Rattle::new(h));
        back(plane, p, Lobatto::<3>::new(h));
        back(plane, p, Lobatto::<5>::new(h));
        back(plane, p, Taylor::new(8, h));
        back(plane, p, Dop853::new(h));
        back(plane, p, Bdf2::new(h));
    }
}

/// A place that a run reached is on the surface, however near to the origin.
#[test]
fn geodesics_from_the_origin() {
    let plane = Plane { a: 0.5, b: 0.0, c: 0.75_f64.sqrt(), d: 0.0 };
    let along = Vector3::new(0.75_f64.sqrt(), 0.0, -0.5);
    let mut run = Scene::on(plane).simulate(State::at(-along).moving(along), Rattle::new(0.1)).unwrap();
    run.run(10).unwrap();
    let way = geodesic_distance(&plane, &run.position(), &along).unwrap();
    assert!((way.distance - 1.0).abs() < 1e-15, "{:e}", way.distance - 1.0);
}

constraint! {
    /// An ellipsoid of half axes r, 1.3 r and 0.8 r, by a distance.
    struct Egg { r }
    |x, y, z| norm(x, y / 1.3, z / 0.8) - r
}

/// On surfaces so small that squares of roundings are 0 bodies are as near to them as on others, and go around them.
#[test]
fn on_surfaces_of_any_size() {
    fn off(r: f64, p: impl Precision, unit: f64) -> f64 {
        let scene = Scene::on(Egg { r });
        let start = |i: i32| State::at([r, 0.0, 0.0]).moving([0.0, r, 0.03 * f64::from(i) * r]);
        let mut ensemble = scene.ensemble_in(p, (0..20).map(start), Rattle::new(0.25)).unwrap();
        ensemble.run(12);
        for state in ensemble.states() {
            let q = state.positions().next().unwrap();
            assert!((q - Vector3::x() * r).norm() > r, "{r:e}, nearly half around: {q:?}");
        }
        ensemble.run(88);
        assert_eq!(ensemble.failures().count(), 0, "{r:e}: {:?}", ensemble.failures().next());
        let off = ensemble.states().map(|state| {
            let q = state.positions().next().unwrap();
            (Vector3::new(q.x, q.y / 1.3, q.z / 0.8).norm() / r - 1.0).abs() / unit
        });
        off.fold(0.0, larger)
    }
    for r in [1.0, 1e-100, 1e-140, 1e-147, 1e-150, 1e-152] {
        assert!(off(r, Double, f64::EPSILON) < 4.0, "{r:e}: {}", off(r, Double, f64::EPSILON));
        let start = (0..20).map(|i| (0.3 * f64::from(i)).sin_cos());
        let (places, momenta): (Vec<_>, Vec<_>) =
            start.map(|(s, c)| ([c * r, 1.3 * s * r, 0.0], [0.0, 0.0, r])).unzip();
        let many = Scene::on(Egg { r }).bodies(20);
        let start = State::of(places).with_momenta(momenta);
        let mut many = many.simulate(start.clone(), Rattle::new(0.25)).unwrap();
        let mut farthest = [0.0; 20];
        many.run_with(100, |now| {
            let gone = now.positions().zip(start.positions()).map(|(now, then)| (now - then).norm());
            farthest.iter_mut().zip(gone).for_each(|(far, gone)| *far = larger(*far, gone));
        })
        .unwrap();
        assert!(farthest.iter().all(|far| *far > r), "{r:e}: {farthest:?}");
        let off = many.positions().map(|q| Vector3::new(q.x, q.y / 1.3, q.z / 0.8).norm() / r - 1.0);
        let off = off.map(f64::abs).fold(0.0, larger);
        assert!(off < 4.0 * f64::EPSILON, "{r:e}, many bodies: {off:e}");
    }
    for r in [1.0, 1e-10, 1e-14, 1e-15, 1e-16] {
        let off = off(r, Single, f64::from(f32::EPSILON));
        assert!(off < 4.0, "{r:e}, single precision: {off}");
    }
}
