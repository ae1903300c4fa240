//! Flows of momenta that are ready-made: drag, dry friction and magnetic fields, against exact motions; their order
//! along curved constraints, their work, and what a magnetic field keeps.

use crate::common::order;
use crate::common::symplectic::defect_in;
use rattle::effect::{
    DryFriction, Effects, Flow, LinearDrag, MagneticField, QuadraticDrag, SelfPropulsion, Stop,
};
use rattle::links::Rod;
use rattle::nalgebra::{Matrix3, SVector, Vector3};
use rattle::potentials::Gravity;
use rattle::prelude::*;
use rattle::scene::Hold;
use rattle::surfaces::{Plane, Sphere, Torus};

/// Where a motion ends, and the error of its energy balance.
fn end<C: Hold<D>, E: Effects<D>, N: rattle::bodies::Count, const D: usize>(
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
    h: f64,
    time: f64,
) -> (Vec<SVector<f64, D>>, f64) {
    let mut simulation = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
    simulation.run((time / h).round() as u64).unwrap();
    (simulation.positions().collect(), simulation.energy_error())
}

/// The order that places and energy balance show when a step is halved three times, against a step of a 64th.
fn orders<C: Hold<D>, E: Effects<D>, N: rattle::bodies::Count, const D: usize>(
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
    h: f64,
    time: f64,
) -> [f64; 2] {
    let (reference, _) = end(scene, start, h / 64.0, time);
    let ends = [h, h / 2.0, h / 4.0].map(|h| end(scene, start, h, time));
    let off = |places: &[SVector<f64, D>]| {
        places.iter().zip(&reference).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
    };
    [order(&ends.each_ref().map(|(places, _)| off(places))), order(&ends.map(|(_, error)| error.abs()))]
}

const START: [f64; 3] = [1.7, 0.0, 0.0];

fn ring() -> Scene<Torus, (), rattle::bodies::One, 3> {
    Scene::on(Torus { major: 1.2, minor: 0.5 })
}

fn of_second_order(effect: impl Flow<3>) {
    let scene = ring().with(Gravity { g: 1.0 }).with(effect);
    let start = State::at(START).moving([0.0, 1.0, 0.5]);
    let [places, energy] = orders(&scene, &start, 0.04, 2.0);
    assert!((1.8..2.3).contains(&places) && energy > 1.7, "{places:.2}, {energy:.2}");
}

/// Also where a flow leads off the surface: drag that differs by direction, a field across the surface.
#[test]
fn flows_on_a_surface_are_of_second_order() {
    of_second_order(LinearDrag::along([0.1, 2.0, 0.7]));
    of_second_order(QuadraticDrag { coefficient: 1.5 });
    of_second_order(MagneticField::new([0.7, -0.4, 1.5]));
    of_second_order(DryFriction { coefficient: 0.1 });
}

/// Bodies of different masses and drag, tied together: neither commutes with making momenta tangent.
#[test]
fn flows_of_linked_bodies_are_of_second_order() {
    let chain = Scene::points::<3>(3)
        .masses([1.0, 2.0, 0.5])
        .link(Rod { length: 1.0 }, [[0, 1], [1, 2]])
        .pin(0, [0.0; 3])
        .with(Gravity { g: 1.0 });
    let start = State::of([[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]);
    let drag = chain.clone().with(LinearDrag::along([0.3, 0.1, 0.8]).times([1.0, 0.2, 3.0]));
    let [places, energy] = orders(&drag, &start, 0.04, 1.0);
    assert!((1.8..2.3).contains(&places) && energy > 1.7, "{places:.2}, {energy:.2}");
    let turned = chain.with(MagneticField::new([0.5, 1.0, 1.5]).charges([0.0, 1.0, -2.0]));
    let [places, energy] = orders(&turned, &start, 0.04, 1.0);
    assert!((1.8..2.3).contains(&places) && energy > 1.7, "{places:.2}, {energy:.2}");
}

/// Each step turns by 2 arctan(h/2); a circle of N steps closes when they make 2π.
#[test]
fn charges_run_around_circles() {
    let steps = 40;
    let h = 2.0 * (std::f64::consts::PI / f64::from(steps)).tan();
    let plane = Scene::point().with(MagneticField::new([0.0, 0.0, 1.0]));
    let start = State::at([0.3, 0.0]).moving([0.6, 0.8]);
    let mut simulation = plane.simulate(start, Rattle::new(h)).unwrap();
    simulation.run(steps as u64).unwrap();
    let off = (simulation.position() - Vector::new(0.3, 0.0)).norm()
        + (simulation.momentum() - Vector::new(0.6, 0.8)).norm();
    assert!(off < 1e-14, "{off:e}");
    assert!(simulation.work().abs() < 1e-15 && simulation.energy_error().abs() < 1e-15);
}
type Vector = rattle::nalgebra::Vector2<f64>;

/// ω = dq ∧ d(p + B × q/2) of a uniform field: kept to second order on a torus, as the motion is, and to rounding by
/// free bodies, with the momenta that Boris' method has between its halves.
#[test]
fn what_a_field_does_to_the_symplectic_form() {
    let field = Vector3::new(0.7, -0.4, 1.5);
    let canonical = |field: Vector3<f64>, scale: f64| {
        move |state: State<3>| {
            let both = state.positions().zip(state.momenta());
            let shifted: Vec<_> = both.map(|(q, p)| scale * p + 0.5 * field.cross(&q)).collect();
            state.with_momenta(shifted)
        }
    };
    let start = State::at(START).moving([0.0, 1.0, 0.5]);
    let on_ring = ring().with(Gravity { g: 1.0 });
    let charged = on_ring.with(MagneticField::new(field.into()));
    let errors = [0.1, 0.05, 0.025].map(|h| {
        let run = |state: State<3>| {
            let mut simulation = charged.simulate(state, Rattle::new(h)).unwrap();
            simulation.run((0.5 / h).round() as u64).unwrap();
            simulation.state()
        };
        defect_in(&on_ring, &start, canonical(field, 1.0), run)
    });
    let order = order(&errors);
    assert!((1.7..2.3).contains(&order), "{errors:?}");

    let (free, h) = (Scene::point().with(Gravity { g: 1.0 }), 0.1);
    let charged = free.clone().with(MagneticField::new(field.into()));
    let turn = (0.5 * h * field.norm()).atan(); // half of that from step to step
    let run = |state: State<3>| {
        let mut simulation = charged.simulate(state, Rattle::new(h)).unwrap();
        simulation.run(5).unwrap();
        simulation.state()
    };
    let kept = defect_in(&free, &start, canonical(field, 1.0 / turn.cos()), run);
    assert!(kept < 2e-11, "{kept:e}");
    let slowed = free.clone().with(LinearDrag::new(0.1));
    let run = |state: State<3>| {
        let mut simulation = slowed.simulate(state, Rattle::new(h)).unwrap();
        simulation.run(5).unwrap();
        simulation.state()
    };
    let lost = defect_in(&free, &start, canonical(Vector3::zeros(), 1.0), run);
    assert!(lost > 1e-3, "{lost:e}");
}

/// Kinetic energy in a field without forces: no drift in 20 000 steps, and back and forth to rounding; a field of any
/// strength, too.
#[test]
fn a_field_does_no_work() {
    let ball = Scene::on(Sphere { r: 1.0 }).with(MagneticField::new([0.5, 0.3, 2.0]));
    let start = State::at([0.0, 0.0, 1.0]).moving([1.0, 0.0, 0.0]);
    let mut simulation = ball.simulate(start.clone(), Rattle::new(0.05)).unwrap();
    simulation.run(20_000).unwrap();
    assert!((simulation.kinetic_energy() - 0.5).abs() < 1e-12, "{:e}", simulation.kinetic_energy() - 0.5);
    let mut there = ball.simulate(start, Rattle::new(0.05)).unwrap().check_reversal(1e-13).unwrap();
    there.run(100).unwrap();
    let strong = Scene::point().with(MagneticField::new([0.0, 0.0, 100.0]));
    let mut simulation =
        strong.simulate(State::at([0.0; 3]).moving([1.0, 0.0, 0.0]), Rattle::new(0.1)).unwrap();
    simulation.run(100).unwrap();
    assert!((simulation.kinetic_energy() - 0.5).abs() < 1e-13);
}

/// Where a mass is a matrix, 1 − A M⁻¹ can lack its first pivot: at h = 1.9/0.9 times a field of 1, here.
#[test]
fn a_field_does_no_work_on_masses_that_are_matrices() {
    let mass = Matrix3::new(1.0, 0.9, 0.0, 0.9, 1.0, 0.0, 0.0, 0.0, 1.0);
    let inverse = mass.try_inverse().unwrap();
    let scene = Scene::point().mass(mass).with(MagneticField::new([0.0, 0.0, -1.0]));
    let start = State::at([0.0; 3]).moving([1.0, 0.3, 0.2]);
    let least = 4.0 / inverse[(1, 0)].abs();
    for h in [least, least * (1.0 + 1e-12), least * (1.0 - 1e-9), 0.1, 3.0, 100.0] {
        let mut simulation = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
        let before = simulation.kinetic_energy();
        simulation.run(10).unwrap();
        let off = simulation.kinetic_energy() / before - 1.0;
        assert!(off.abs() < 1e-13, "h = {h}: {off:e}");
    }
}

potential! { struct Push { f } |x, y, _z| -f * (x + y) }

/// ṗ = −μN v/|v| where v is not along p, against steps of a thousandth; and at rest in the end.
#[test]
fn friction_is_along_the_velocity() {
    let floor = Plane { a: 0.0, b: 0.0, c: 1.0, d: 0.0 };
    let (mu, mass) = (0.1, [1.0, 4.0, 2.0]);
    let scene = Scene::point().link(floor, [[0]]).mass(mass);
    let scene = scene.with(Gravity { g: 1.0 }).with(DryFriction { coefficient: mu });
    let start = State::at([0.0; 3]).moving([1.0, 4.0, 0.0]);
    let rate = |p: [f64; 2]| {
        let v = [p[0] / mass[0], p[1] / mass[1]];
        v.map(|x| -mu * x / v[0].hypot(v[1])) // N = 1, by gravity of 1
    };
    let (mut p, steps) = ([1.0, 4.0], 100_000);
    for _ in 0..steps {
        let h = 1.0 / f64::from(steps);
        let first = rate(p);
        let middle = rate([p[0] + 0.5 * h * first[0], p[1] + 0.5 * h * first[1]]);
        p = [p[0] + h * middle[0], p[1] + h * middle[1]];
    }
    let exact = Vector3::new(p[0] / mass[0], p[1] / mass[1], 0.0);
    let errors = [0.1, 0.05, 0.025].map(|h| {
        let mut simulation = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
        simulation.run((1.0 / h).round() as u64).unwrap();
        (simulation.velocity() - exact).norm()
    });
    let order = order(&errors);
    assert!(errors[2] < 1e-7 && (1.8..2.3).contains(&order), "{errors:?}");
    // No half of a step gains energy, however v turns away from p, until the body rests; then it stays.
    for light in [0.5, 0.1, 1e-2, 1e-4] {
        let floor = Scene::point().link(floor, [[0]]).mass([1.0, light, 1.0]).with(Gravity { g: 1.0 });
        let scene = floor.with(DryFriction { coefficient: mu });
        let mut now =
            scene.simulate(State::at([0.0; 3]).moving([1.0, 0.01, 0.0]), Rattle::new(0.01)).unwrap();
        let mut energy = now.kinetic_energy();
        for step in 0..1010 {
            now.step().unwrap();
            assert!(now.kinetic_energy() <= energy, "mass {light}, step {step}");
            energy = now.kinetic_energy();
        }
        let place = now.position();
        now.run(10).unwrap();
        assert_eq!((now.velocity().norm(), now.position()), (0.0, place), "mass {light}");
        // By 1.1 of the friction it is pushed away, by 0.9 it is not.
        for (part, moves) in [(0.9, false), (1.1, true)] {
            let force = part * mu * std::f64::consts::FRAC_1_SQRT_2;
            let mut pushed = scene
                .clone()
                .with(Push { f: force })
                .simulate(State::at([0.0; 3]), Rattle::new(0.01))
                .unwrap();
            pushed.run(10).unwrap();
            assert_eq!(pushed.position().norm() > 0.0, moves, "mass {light}, {part}");
        }
    }
}

/// On a slope of 45°: starting, sliding and coming to rest, against v = g (sin α ∓ μ cos α) t.
#[test]
fn sliding_on_a_slope() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let slope = |mu| {
        Scene::on(Plane { a: half, b: 0.0, c: half, d: 0.0 })
            .with(Gravity { g: 1.0 })
            .with(DryFriction { coefficient: mu })
    };
    let (down, up) = ([half, 0.0, -half], [-half, 0.0, half]);
    let along = |q: SVector<f64, 3>| q.dot(&SVector::from(down));
    let mut slides = slope(0.5).simulate(State::at([0.0; 3]), Rattle::new(0.01)).unwrap();
    slides.run(200).unwrap();
    assert!((along(slides.position()) - 0.5 * half * 0.5 * 4.0).abs() < 1e-13);
    assert!((slides.energy_error() / slides.work()).abs() < 1e-12, "friction is all the work");
    // Upwards it comes to rest at v²/(2 g (sin α + μ cos α)), within a step of the time, and stays for μ > 1.
    let mut stops = slope(1.5).simulate(State::at([0.0; 3]).moving(up), Rattle::new(0.01)).unwrap();
    stops.run(100).unwrap();
    let (rest, reached) = (stops.position(), 1.0 / (2.0 * half * 2.5));
    assert!((along(rest) + reached).abs() < 1e-4, "{} of {reached}", along(rest));
    stops.run(1000).unwrap();
    assert_eq!(stops.position(), rest);
    assert_eq!(stops.momentum().norm(), 0.0);
    // Exactly at the limit and above it nothing moves; below it the body starts.
    for (mu, moves) in [(1.001, false), (0.999, true)] {
        let mut simulation = slope(mu).simulate(State::at([0.0; 3]), PositionVerlet::new(0.01)).unwrap();
        simulation.run(100).unwrap();
        assert_eq!(simulation.position().norm() > 1e-5, moves, "{mu}");
    }
}

potential! { struct Springs { k: [f64; 2] } |x, y, _z| (k[0] * x^2 + k[1] * y^2) / 2 }

/// Whatever the stages of a method: on a bowl and under springs, where the force changes along the way, and on a rod.
#[test]
fn what_sticks_stays() {
    let floor = Plane { a: 0.0, b: 0.0, c: 1.0, d: 0.0 };
    let springs = Springs { k: [20.0, 5.0] };
    let at = Vector3::new(0.3_f64.sin(), 0.0, -0.3_f64.cos());
    let rests = |name: &str, place: Vector3<f64>, at: Vector3<f64>, energy: f64| {
        assert_eq!(place, at, "{name}");
        assert!(energy.abs() < 1e-13, "{name}: {energy:e}");
    };
    let rough = DryFriction { coefficient: 0.6 };
    let weight = Gravity { g: 9.81 };
    let bowl = Scene::on(Sphere { r: 1.0 }).with(weight).with(rough);
    let floor = Scene::on(floor).bodies(2).with(weight).with(springs).with(rough);
    let rod = Scene::points(2).link(Rod { length: 1.0 }, [[0, 1]]).pin(0, [0.0; 3]).with(weight).with(rough);
    // One that rests, beside one that slides.
    let both = State::of([[0.2, 0.3, 0.0], [0.5, 0.0, 0.0]]).with_momenta([[0.0; 3], [0.0, 4.0, 0.0]]);
    let hanging = State::of([[0.0; 3], at.into()]);
    macro_rules! stays {
        ($method:expr) => {
            let (method, name) = ($method, $method.name());
            let mut run = bowl.simulate(State::at(at), method.clone()).unwrap();
            run.run(100).unwrap();
            rests(name, run.position(), at, run.energy_error());
            let mut run = floor.simulate(both.clone(), method.clone()).unwrap();
            run.run(20).unwrap();
            let places: Vec<_> = run.positions().collect();
            // h = 0.05 where the period is 1.4: a second order error of what slides.
            assert!(run.energy_error().abs() < 0.05 && places[1].y > 0.5, "{name}: {}", run.energy_error());
            rests(name, places[0], Vector3::new(0.2, 0.3, 0.0), 0.0);
            let mut run = rod.simulate(hanging.clone(), method).unwrap();
            run.run(100).unwrap();
            rests(name, run.positions().nth(1).unwrap(), at, run.energy_error());
        };
    }
    stays!(Rattle::new(0.05));
    stays!(Geodesic::new(3, 0.05));
    stays!(PositionVerlet::new(0.05));
    stays!(Lobatto::<3>::new(0.05));
    stays!(Lobatto::<5>::new(0.05));
    stays!(Composition::of(SUZUKI_1990_ORDER_4, Rattle::new(0.05)));
    // Beside one that bounces, in steps that are taken in parts, too.
    let ball = State::of([[0.2, 0.3, 0.0], [0.5, 0.0, 0.0]]).with_momenta([[0.0; 3], [4.0, 0.0, 0.0]]);
    let wall = Stop::below(Plane { a: 1.0, b: 0.0, c: 0.0, d: 0.6 });
    let mut run = floor.simulate(ball, Lobatto::<3>::new(0.05)).unwrap().retry(4).collide(wall).unwrap();
    run.run(20).unwrap();
    rests("beside a ball", run.positions().next().unwrap(), Vector3::new(0.2, 0.3, 0.0), 0.0);
    // What acts in the middle of a step cannot know of forces that come at its end.
    let refused = bowl.simulate(State::at([0.0, 0.0, -1.0]), Baoab::new(0.05)).unwrap_err().to_string();
    assert!(refused.contains("feels forces") && refused.contains("Geodesic"), "{refused}");
    assert!(!refused.contains("Brownian"), "{refused}");
}

/// What a body at rest did before is not known: an error where time runs back.
#[test]
fn what_sticks_has_no_way_back() {
    let slope = Scene::on(Plane { a: 0.6, b: 0.0, c: 0.8, d: 0.0 }).with(Gravity { g: 1.0 });
    let slope = slope.with(DryFriction { coefficient: 1.0 });
    let mut back = slope.simulate(State::at([0.0; 3]), Rattle::new(-0.01)).unwrap();
    let error = back.step().unwrap_err().to_string();
    assert!(error.contains("DryFriction") && back.steps() == 0, "{error}");
}

force! {
    /// A magnetic field along −y.
    struct Lorentz { b }
    |_q: [f64; 3], v: [f64; 3]| [-b * v[2], 0 * v[1], b * v[0]]
}

/// Friction feels others as they are in the middle of its flow, by their momenta as by their velocities: v′ = −μ(g +
/// bv) on a floor in a magnetic field; and on a slope, where drag differs by direction.
#[test]
fn friction_feels_others_to_second_order() {
    let floor = Scene::on(Plane { a: 0.0, b: 0.0, c: 1.0, d: 0.0 }).with(Gravity { g: 2.0 });
    let (rough, start) = (DryFriction { coefficient: 0.3 }, State::at([0.0; 3]).moving([1.0, 0.0, 0.0]));
    let exact = 5.0 * (-0.15_f64).exp() - 4.0;
    let errors = |scene: &dyn Fn(f64) -> f64| [0.05, 0.025, 0.0125].map(|h| (scene(h) - exact).abs());
    let speed = |mut simulation: BoxedSimulation<3>, h: f64| {
        simulation.run((1.0 / h).round() as u64).unwrap();
        simulation.momenta().next().unwrap().x
    };
    let field = floor.with(MagneticField::new([0.0, -0.5, 0.0])).with(rough);
    let force = floor.with(Lorentz { b: -0.5 }).with(rough);
    let by_field = errors(&|h| speed(field.simulate(start.clone(), Rattle::new(h)).unwrap().boxed(), h));
    let by_force = errors(&|h| speed(force.simulate(start.clone(), Rattle::new(h)).unwrap().boxed(), h));
    assert!(order(&by_field) > 1.9 && order(&by_force) > 1.9, "{by_field:?} {by_force:?}");
    assert!(by_field[0] < 1e-5, "{by_field:?}");
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let slope = Scene::on(Plane { a: half, b: 0.0, c: half, d: 0.0 }).with(Gravity { g: 2.0 });
    let slope = slope.with(LinearDrag::along([1.5, 0.0, 0.0])).with(rough);
    let [places, _] = orders(&slope, &State::at([0.0; 3]).moving([half, 0.0, -half]), 0.05, 1.0);
    assert!(places > 1.9, "{places}");
}

/// Sticking weighs what all forces give, and N is of all of them: potentials, `force!` and self-propulsion, however
/// they are named. At 98 % of μN nothing moves to the last bit; at twice μN a body is faster by h (f − μN) in each
/// step.
#[test]
fn friction_weighs_all_forces() {
    force! {
        /// Weight, and a pull along x.
        struct Pull { weight, pull }
        |_q: [f64; 3]| [pull, 0, -weight]
    }
    fn check<E: Effects<3>>(scene: &Scene<Plane, E, rattle::bodies::One, 3>, moves: bool) {
        let mut simulation = scene.simulate(State::at([0.0; 3]), Rattle::new(0.01)).unwrap();
        simulation.run(100).unwrap();
        let x = simulation.position().x;
        if moves {
            assert!((x - 0.5 * 0.5).abs() < 1e-13, "{x}");
            assert!(simulation.energy_error().abs() < 1e-13);
        } else {
            assert_eq!((x, simulation.momentum().x), (0.0, 0.0));
        }
    }
    let table = || Scene::on(Plane { a: 0.0, b: 0.0, c: 1.0, d: 0.0 });
    let rough = DryFriction { coefficient: 0.5 }; // N = 1
    for (force, moves) in [(0.49, false), (1.0, true)] {
        let pull = Pull { weight: 1.0, pull: force };
        check(&table().with(pull).with(rough), moves);
        check(&table().with(rough).with(pull), moves);
        let half = Pull { weight: 0.5, pull: 0.5 * force };
        check(&table().with(half).with(rough).with(half), moves);
        let light = Pull { weight: 0.4, pull: force };
        check(&table().with(Gravity { g: 0.6 }).with(rough).with(light), moves);
        let along = SelfPropulsion::new(force, 0.0, 1).headed([[1.0, 0.0, 0.0]]);
        check(&table().with(Gravity { g: 1.0 }).with(rough).with(along.clone()), moves);
        check(&table().with(Gravity { g: 1.0 }).with(along).with(rough), moves);
    }
    // Of second order where N changes on the way, by a force that knows velocities.
    force! {
        /// Weight that depends on place and speed, and a push across.
        struct Wind {}
        |q: [f64; 3], v: [f64; 3], t| [-v[0] / 5, sin(q[0]) / 10, -1 - q[0]^2 - v[0] * v[1] + cos(t) / 2]
    }
    let start = State::at([0.0; 3]).moving([1.0, 0.5, 0.0]);
    for scene in [
        orders(&table().with(Wind {}).with(rough), &start, 0.04, 0.8),
        orders(&table().with(rough).with(Wind {}), &start, 0.04, 0.8),
    ] {
        assert!((1.8..2.3).contains(&scene[0]), "{scene:?}");
    }
}

/// Where a method leaves forces of another place, friction takes those of now: of second order by every method.
#[test]
fn friction_feels_the_forces_of_now() {
    potential! {
        /// Heavier by the square of x, and a slope along y.
        struct Uneven {}
        |x, y, z| z * (1 + x^2) + y / 10
    }
    let plane = Plane { a: 0.0, b: 0.0, c: 1.0, d: 0.0 };
    let scene = Scene::on(plane).with(Uneven {}).with(DryFriction { coefficient: 0.3 });
    let end = |h: f64| {
        let start = State::at([0.0; 3]).moving([1.0, 0.0, 0.0]);
        let mut simulation = scene.simulate(start, PositionVerlet::new(h)).unwrap();
        simulation.run((0.5 / h).round() as u64).unwrap();
        simulation.position().x
    };
    let exact = end(0.05 / 128.0);
    let order = order(&[0.05, 0.025, 0.0125].map(|h| (end(h) - exact).abs()));
    assert!((1.8..2.3).contains(&order), "{order}");
}

/// The constraint forces of a curved path: on a cylinder's inside without gravity a body slows like v₀/(1 + μ v₀ t/r).
#[test]
fn friction_by_curvature() {
    let ball = Scene::on(Sphere { r: 2.0 }).with(DryFriction { coefficient: 0.3 });
    let start = || State::at([2.0, 0.0, 0.0]).moving([0.0, 1.0, 0.0]);
    let speed = |h: f64| {
        let mut simulation = ball.simulate(start(), Rattle::new(h)).unwrap();
        simulation.run((4.0 / h).round() as u64).unwrap();
        (simulation.momentum().norm() - 1.0 / 1.6).abs()
    };
    let errors = [0.2, 0.1, 0.05].map(speed);
    assert!((1.8..2.3).contains(&order(&errors)) && errors[2] < 1e-4, "{errors:?}");
}

/// A top with drag about its axes: mᵢ falls like exp(−cᵢt/Iᵢ) where it turns about one of them.
#[test]
fn rigid_bodies_have_drag() {
    let top = Scene::rigid(Rigid::new([1.0, 1.0, 2.0]))
        .with(LinearDrag::along([0.1, 0.1, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
    let start = Rigid::start(&Matrix3::identity(), &Vector3::new(0.0, 0.0, 3.0));
    let mut simulation = top.simulate(start, Rattle::new(0.1)).unwrap();
    simulation.run(40).unwrap();
    assert!((simulation.momentum()[2] - 3.0 * (-1.0_f64).exp()).abs() < 1e-14);
}

/// Nothing touches a rigid body or a free point: they have no normal force. A momentum turns with its body, and keeps
/// its length.
#[test]
fn what_nothing_touches_has_no_dry_friction() {
    let point = Scene::point::<3>().with(DryFriction { coefficient: 0.5 });
    let mut free = point.simulate(State::at([0.0; 3]).moving([0.3, 0.1, 1.0]), Rattle::new(0.01)).unwrap();
    free.run(100).unwrap();
    assert_eq!((free.momentum().as_slice(), free.work()), (&[0.3, 0.1, 1.0][..], 0.0));

    let body = Scene::rigid(Rigid::new([0.5, 0.5, 0.2])).with(DryFriction { coefficient: 0.1 });
    let start = Rigid::start(&Matrix3::identity(), &Vector3::new(0.3, 0.1, 1.0));
    let mut simulation = body.simulate(start, Rattle::new(0.01)).unwrap();
    let before = simulation.momentum().norm();
    simulation.run(100).unwrap();
    assert!((simulation.momentum().norm() / before - 1.0).abs() < 1e-14);
    assert_eq!(simulation.work(), 0.0);
}

#[test]
fn what_makes_no_sense_is_refused() {
    let told = |effect: MagneticField| {
        let scene = Scene::points::<3>(2).with(effect);
        scene.simulate(State::of([[0.0; 3]; 2]), Rattle::new(0.1)).unwrap_err().to_string()
    };
    let field = MagneticField::new([0.0, 0.0, 1.0]);
    assert_eq!(told(field.clone().charges([1.0])), "effect `MagneticField`: 1 number was given for 2 bodies");
    let drag = Scene::points::<1>(2).with(rattle::effect::LinearDrag::new(1.0).times([]));
    let of_drag = drag.simulate(State::of([[0.0], [1.0]]), Rattle::new(0.1)).unwrap_err().to_string();
    assert_eq!(of_drag, "effect `LinearDrag`: 0 numbers were given for 2 bodies");
    // Also one that is empty by mistake.
    assert_eq!(told(field.clone().charges([])), "effect `MagneticField`: 0 numbers were given for 2 bodies");
    assert!(told(field.charges([1.0, f64::NAN])).contains("a charge must be finite, found NaN"));
    assert!(told(MagneticField::new([f64::INFINITY, 0.0, 0.0])).contains("must be finite"));
}

constraint! {
    /// The floor of a lift, with speed and acceleration.
    struct Lift { u, a }
    |_x, y, t| y - u * t - a * t^2 / 2
}

/// A lift carries its load without friction: at a constant speed the load slides as on the ground, and comes to rest
/// there; N grows by the acceleration.
#[test]
fn friction_in_a_lift() {
    let (mu, g, mass, v) = (0.1, 9.81, 2.5, 3.0);
    for (u, a) in [(0.0, 0.0), (1.0, 0.0), (10.0, 0.0), (-3.0, 2.0), (0.0, -4.0)] {
        let scene = Scene::point()
            .link_moving(Lift { u, a }, [[0]])
            .masses([mass])
            .with(rattle::potentials::planar::weights(g, [mass]))
            .with(DryFriction { coefficient: mu });
        let start = State::at([0.0, 0.0]).with_momenta([[v * mass, u * mass]]);
        let mut simulation = scene.simulate(start, Rattle::new(0.01)).unwrap();
        let slows = mu * (g + a);
        let end = v / slows;
        simulation.run_until(0.5 * end).unwrap();
        let t = simulation.time();
        let (x, p) = (v * t - 0.5 * slows * t * t, mass * (v - slows * t));
        assert!(
            (simulation.position().x - x).abs() < 1e-12,
            "u = {u}, a = {a}: {} for {x}",
            simulation.position().x
        );
        assert!((simulation.momentum().x - p).abs() < 1e-12, "u = {u}, a = {a}");
        simulation.run_until(end + 1.0).unwrap();
        let (x, p) = (simulation.position().x, simulation.momentum().x);
        assert!((x - 0.5 * v * end).abs() < 1e-3 && p.abs() < 1e-13, "u = {u}, a = {a}: {x}, {p}");
    }
}

/// What a step leaves along a line of drag that is far too strong for it in one direction, as its page says.
#[test]
fn drag_far_above_the_step_on_a_line() {
    for angle in [0.2_f64, 0.8, 1.4] {
        let (sin, cos) = angle.sin_cos();
        let scene = Scene::on(Plane { a: -sin, b: cos, c: 0.0, d: 0.0 });
        let scene = scene.with(LinearDrag::along([1e9, 0.0, 0.0]));
        let mut run = scene.simulate(State::at([0.0; 3]).moving([cos, sin, 0.0]), Rattle::new(0.1)).unwrap();
        run.step().unwrap();
        let left = (sin * sin / (1.0 + cos * cos)).powi(2);
        assert!((run.momentum().norm() - left).abs() < 1e-12, "{angle}: {}", run.momentum().norm());
    }
}
