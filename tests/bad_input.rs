//! What nobody means gets an error that says so: counts that do not fit, numbers that cannot be, names that stand
//! twice.

use rattle::Error;
use rattle::Rigid;
use rattle::effect::Stop;
use rattle::error::{NetworkMistake, PhaseMistake, RigidFailure, StartFailure, StepFailure, SurfaceFailure};
use rattle::links::Rod;
use rattle::potentials::{Wca, planar::Harmonic};
use rattle::prelude::*;
use rattle::surfaces::{Plane, Sphere};
use rattle::watch::{Histogram, Mean, ShadowEnergy, Sight};

potential! {
    /// Of two bodies on a line.
    struct Spring { k }
    |a, b| k * (a - b)^2 / 2
}

potential! { struct Shaken { a } |x, _y, t| a * x * sin(t) }
phase_constraint! { struct Circle { r } |q, p| q^2 + p^2 - r^2 }
hamiltonian! { struct Dropping { g } |q, p| p^2 / 2 + g * q }

force! {
    /// Another push where the body goes back.
    struct Thrust { f }
    |_q: [f64; 2], v: [f64; 2]| [if v[0] < 0 { f } else { 2 * f }, 0]
}
force! { struct Rubbing { mu } |_q: [f64; 2], v: [f64; 2]| -mu * sign(v[0]) * [1, 0] }
force! { struct Wind { f } |_q: [f64; 2], v: [f64; 2]| [f + 0 * v[0], 0] }

fn refused<T>(result: Result<T, Error>) -> Error {
    result.map(|_| ()).unwrap_err()
}

fn mistake(error: Error) -> NetworkMistake {
    match error {
        Error::Network(mistake) => mistake,
        other => panic!("{other}"),
    }
}

#[test]
fn nobody_is_moved_by_every_method() {
    let nobody = State::of(Vec::<[f64; 2]>::new());
    let scene = Scene::points::<2>(0);
    scene.simulate(nobody.clone(), Rattle::new(0.1)).unwrap().run(3).unwrap();
    scene.simulate(nobody.clone(), Taylor::new(8, 0.1)).unwrap().run(3).unwrap();
    scene.simulate(nobody.clone(), Taylor::adaptive(8, 0.1, 1e-9)).unwrap().run(3).unwrap();
    scene.simulate(nobody.clone(), Dop853::adaptive(0.1, 1e-9)).unwrap().run(3).unwrap();
    scene.simulate(nobody.clone(), Lobatto::<3>::new(0.1)).unwrap().run(3).unwrap();
    scene.simulate(nobody, Dop853::new(0.1)).unwrap().run(3).unwrap();
    let (scene, nobody) = (Scene::on(Sphere { r: 1.0 }).bodies(0), State::of(Vec::<[f64; 3]>::new()));
    scene.simulate(nobody.clone(), Rattle::new(0.1)).unwrap().run(3).unwrap();
    scene.simulate(nobody, Taylor::adaptive(8, 0.1, 1e-9)).unwrap().run(3).unwrap();
    fn several<S: Method + Copy>(method: S) {
        let nobody = State::of(Vec::<[f64; 2]>::new());
        let mut several = Scene::points::<2>(0).ensemble(vec![nobody; 3], method).unwrap();
        several.run(3);
        let written = several.checkpoint();
        several.resume(&written).unwrap();
    }
    several(Rattle::new(0.1));
    several(Taylor::new(8, 0.1));
    several(Taylor::adaptive(8, 0.1, 1e-9));
    several(Dop853::adaptive(0.1, 1e-9));
    several(Lobatto::<3>::new(0.1));
    let (scene, nobody) = (Scene::rigid(Rigid::new([1.0; 3])).bodies(0), State::of(Vec::<[f64; 9]>::new()));
    scene.ensemble(vec![nobody.clone(); 3], Rattle::new(0.1)).unwrap().run(3);
    scene.ensemble(vec![nobody.clone(); 3], Dop853::adaptive(0.1, 1e-9)).unwrap().run(3);
    scene.ensemble(vec![nobody.clone(); 3], Taylor::new(8, 0.1)).unwrap().run(3);
    scene.ensemble(vec![nobody.clone(); 3], Taylor::adaptive(8, 0.1, 1e-9)).unwrap().run(3);
    scene.simulate(nobody.clone(), Rattle::new(0.1)).unwrap().run(3).unwrap();
    scene.simulate(nobody.clone(), Dop853::adaptive(0.1, 1e-9)).unwrap().run(3).unwrap();
    scene.simulate(nobody.clone(), Taylor::new(8, 0.1)).unwrap().run(3).unwrap();
    scene.simulate(nobody, Taylor::adaptive(8, 0.1, 1e-9)).unwrap().run(3).unwrap();
}

#[test]
fn a_state_of_other_bodies_is_told_by_the_numbers_of_both() {
    let scene = Scene::points(3).link(Rod { length: 1.0 }, [[0, 1], [1, 2]]);
    let error = refused(scene.project(&State::at([0.0, 0.0, 0.0])));
    assert!(matches!(error, Error::BodyCount { scene: 3, state: 1 }), "{error}");
}

#[test]
fn staggered_momenta_are_those_of_all_bodies() {
    let spring = Spring { k: 1.0 };
    let method = Shake::new(0.1);
    let scene = Scene::points::<1>(3).with(spring.over([[0, 1], [1, 2]]));
    let start = State::of([[0.0], [1.0], [2.0]]);
    scene.staggered(&start, &method).unwrap();
    let error = refused(scene.staggered(&State::of([[0.0], [1.0]]), &method));
    assert!(matches!(error, Error::BodyCount { scene: 3, state: 2 }), "{error}");
    let error = refused(scene.staggered(&State::of([[0.0]; 3]).with_momenta([[0.0]; 4]), &method));
    assert!(matches!(error, Error::MomentumCount { bodies: 3, momenta: 4 }), "{error}");
    let few = State::of([[0.0], [1.0], [2.0]]).with_momenta([[0.5]; 2]);
    for error in [
        refused(scene.staggered(&few, &method)),
        refused(scene.simulate(few.clone(), Rattle::new(0.1))),
        refused(scene.project(&few)),
        refused(scene.ensemble([start.clone(), few], Rattle::new(0.1))),
    ] {
        assert!(error.to_string().contains("the state has 3 bodies and was given 2 momenta"), "{error}");
    }
    let stray = Scene::points::<1>(3).with(spring.over([[0, 3]]));
    let error = mistake(refused(stray.staggered(&start, &method)));
    assert!(matches!(error, NetworkMistake::NoSuchBody { body: 3, bodies: 3, .. }), "{error}");
}

#[test]
fn moments_of_inertia_are_those_of_a_body() {
    let begin = |moments| {
        let start = Rigid::start(&nalgebra::Matrix3::identity(), &nalgebra::Vector3::new(0.1, 0.2, 0.3));
        Scene::rigid(Rigid::new(moments)).simulate(start, Rattle::new(0.01))
    };
    begin([1.0, 2.0, 3.0]).unwrap(); // a lamina
    begin([0.1, 0.2, 0.1 + 0.2]).unwrap();
    for moments in
        [[1e308; 3], [1e-320; 3], [1.0, 2.0, 3.1], [0.0, 1.0, 1.0], [-1.0; 3], [f64::NAN, 1.0, 1.0]]
    {
        let error = mistake(refused(begin(moments)));
        assert!(matches!(error, NetworkMistake::Inertia { .. }), "{moments:?}: {error}");
    }
    for mass in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-320] {
        let scene = Scene::point::<1>().mass(mass);
        let error = mistake(refused(scene.simulate(State::at([0.0]), Rattle::new(0.1))));
        assert!(matches!(error, NetworkMistake::Mass { body: 0 }), "{mass}: {error}");
    }
}

/// Where a rotation is not found the message's bound is true: below 1 there always is one.
#[test]
fn bodies_that_turn_too_far_are_above_the_bound() {
    let mut failed = 0;
    for k in 0..400 {
        let (angle, height) = (0.7 * f64::from(k), 0.005 * f64::from(k) - 1.0);
        let across = (1.0 - height * height).sqrt();
        let rate = nalgebra::Vector3::new(across * angle.cos(), across * angle.sin(), height);
        let speed = 0.9 + 0.001 * f64::from(k);
        let moments = [0.3, 0.71, 1.0];
        let m = rate.component_mul(&nalgebra::Vector3::from(moments)) * speed;
        let start = Rigid::start(&nalgebra::Matrix3::identity(), &m);
        let mut simulation = Scene::rigid(Rigid::new(moments)).simulate(start, Rattle::new(1.0)).unwrap();
        if let Err(error) = simulation.step() {
            let Error::Step { cause: StepFailure::Rigid(RigidFailure::TurnsTooFar { turn, .. }), .. } = error
            else {
                panic!("{error}")
            };
            assert!(turn >= 1.0 && error.to_string().contains("below 1"), "{error}");
            failed += 1;
        }
    }
    assert!(failed > 100, "{failed}");
}

/// A step is too long only where it is.
#[test]
fn numbers_that_overflow_are_not_too_long_a_step() {
    let sphere = Scene::on(Sphere { r: 1e85 });
    let start = State::at([1e85, 0.0, 0.0]).moving([0.0, 1e80, 0.0]);
    let error = sphere.simulate(start, Rattle::new(1e3)).unwrap().step().unwrap_err();
    let Error::Step { cause: StepFailure::Surface(SurfaceFailure::OutOfScale { reach, .. }), .. } = error
    else {
        panic!("{error}")
    };
    assert!((reach - 0.01).abs() < 1e-3, "{reach}");
}

#[test]
fn a_free_body_that_runs_away_is_told() {
    let start = State::at([0.0]).moving([1e150]);
    let mut simulation = Scene::point().simulate(start, Rattle::new(1e3)).unwrap();
    let error = simulation.run(1000).unwrap_err();
    let Error::Step { step, cause: StepFailure::RanAway { position }, .. } = error else { panic!("{error}") };
    assert!(position[0] > 1e153 && simulation.steps() + 1 == step, "{position:?} in step {step}");
    let starts = [1e150, 1.0, 1e150].map(|v| State::at([0.0]).moving([v]));
    let mut ensemble = Scene::point().ensemble(starts, Rattle::new(1e3)).unwrap();
    ensemble.run(1000);
    let told = |i| {
        ensemble
            .failure(i)
            .map(|error| matches!(error, Error::Step { cause: StepFailure::RanAway { .. }, .. }))
    };
    assert_eq!([0, 1, 2].map(told), [Some(true), None, Some(true)], "{:?}", ensemble.failure(0));
}

phase_constraint! {
    /// On a circle of phase space.
    struct Round {}
    |q: [f64; 1], p: [f64; 1]| q[0]^2 + p[0]^2 - 1
}
hamiltonian! {
    /// Not a number for q < 0.5.
    struct Half {}
    |q: [f64; 1], p: [f64; 1]| sqrt(q[0] - 0.5) + p[0]
}

#[test]
fn a_hamiltonian_that_is_no_number_is_no_constraint() {
    let scene = Scene::in_phase_space(Round {}, Half {});
    let start = State::at([0.0]).moving([1.0]);
    let errors = [refused(scene.project(&start)), refused(scene.simulate(start, Rattle::new(0.1)))];
    for error in errors {
        let Error::Start { cause: StartFailure::Phase(mistake), .. } = error else { panic!("{error}") };
        assert!(matches!(mistake, PhaseMistake::HamiltonianNotFinite { .. }), "{mistake}");
    }
}

phase_constraint! {
    /// Of which nothing is left where q₀ and p₀ are nothing, as they are where {g, H} is.
    struct Twisted {}
    |q: [f64; 2], p: [f64; 2]| q[0] * p[1] - q[1] * p[0] - q[0]
}
hamiltonian! {
    struct Falling {}
    |q: [f64; 2], p: [f64; 2]| dot(p, p) / 2 + q[1]
}

/// What `project` gives is a start, also where all that g is made of is rounding.
#[test]
fn rounding_of_nothing_is_a_start() {
    let scene = Scene::in_phase_space(Twisted {}, Falling {});
    let start = scene.project(&State::at([1.0, 0.2]).moving([0.1, 1.0])).unwrap();
    assert!(start.positions().all(|q| q.x != 0.0 && q.x.abs() < 1e-15), "{start:?}");
    let mut simulation = scene.simulate(start, Rattle::new(0.01)).unwrap();
    simulation.run(100).unwrap();
    assert!(simulation.position().x.abs() < 1e-14);
    // What is off by more than rounding is none.
    let off = State::at([1e-12, 0.2]).moving([0.0, 2.0]);
    assert!(matches!(refused(scene.simulate(off, Rattle::new(0.01))), Error::Start { .. }));
}

#[test]
fn a_body_is_pinned_at_one_place() {
    let scene = Scene::points(2).link(Rod { length: 1.0 }, [[0, 1]]).pin(0, [0.0; 3]);
    let start = State::of([[0.0; 3], [1.0, 0.0, 0.0]]);
    scene.clone().pin(0, [0.0; 3]).simulate(start.clone(), Rattle::new(0.1)).unwrap();
    let error = mistake(refused(scene.pin(0, [2.0, 0.0, 0.0]).simulate(start, Rattle::new(0.1))));
    let NetworkMistake::PinnedTwice { body: 0, first, second } = &error else { panic!("{error}") };
    assert_eq!((&first[..], &second[..]), (&[0.0; 3][..], &[2.0, 0.0, 0.0][..]));
}

/// A pin that is nowhere is no mistake of the start, which no projection could mend.
#[test]
fn a_pin_is_somewhere() {
    for place in [f64::NAN, f64::INFINITY] {
        let scene = Scene::points(2).link(Rod { length: 1.0 }, [[0, 1]]).pin(0, [0.0, place, 0.0]);
        let start = State::of([[0.0; 3], [1.0, 0.0, 0.0]]);
        let errors =
            [refused(scene.simulate(start.clone(), Rattle::new(0.1))), scene.project(&start).unwrap_err()];
        for error in errors.map(|error| error.to_string()) {
            assert!(
                error.contains("the pin of body 0 is at [0.0, ") && !error.contains("project"),
                "{error}"
            );
        }
    }
}

/// Very large and very small numbers are told with their power of ten.
#[test]
fn numbers_in_messages_are_short() {
    use rattle::error::{EffectMistake, PriceMistake};
    for (x, text) in
        [(-1e300, "-1e300"), (2.5e-300, "2.5e-300"), (-0.5, "-0.5"), (0.0, "0"), (f64::NAN, "NaN")]
    {
        let wrong = EffectMistake::Parameter { name: "a number", range: "another", value: x };
        let errors = [
            Error::StepSize(x),
            Error::ChangeTime(x),
            Error::Time(x),
            Error::EndTime(x),
            Error::Tolerance(x),
            Error::Restitution(x),
            Error::Diameter(x),
            Error::Effect { effect: "it", mistake: wrong },
            Error::Price(PriceMistake::NotPositive { what: "duration", value: x }),
        ];
        for error in errors.map(|error| error.to_string()) {
            assert!(error.ends_with(&format!("found {text}")), "{error}");
        }
    }
}

#[test]
fn members_of_an_effect_are_different_bodies() {
    let spring = Spring { k: 1.0 };
    let start = State::of([[0.0], [1.0]]);
    let scene = |members: [usize; 2]| Scene::points::<1>(2).with(spring.over([[0, 1], members]));
    scene([1, 0]).simulate(start.clone(), Rattle::new(0.1)).unwrap();
    let error = mistake(refused(scene([1, 1]).simulate(start.clone(), Rattle::new(0.1))));
    assert!(matches!(error, NetworkMistake::Repeated { member: 1, body: 1, .. }), "{error}");
    let error = mistake(refused(scene([0, 2]).simulate(start, Rattle::new(0.1))));
    assert!(matches!(error, NetworkMistake::NoSuchBody { member: 1, body: 2, bodies: 2, .. }), "{error}");
}

/// A long path is no reason to begin far from a plane.
#[test]
fn a_start_off_a_plane_is_refused_however_long_the_path() {
    let plane = Scene::on(Plane { a: 0.0, b: 0.0, c: 1.0, d: 0.0 });
    let start = |height| State::at([0.0, 0.0, height]).moving([1e9, 0.0, 0.0]);
    plane.simulate(start(0.0), Rattle::new(1.0)).unwrap();
    plane.simulate(start(1e-7), Rattle::new(1.0)).unwrap(); // rounding of places that far away
    let error = refused(plane.simulate(start(0.01), Rattle::new(1.0)));
    assert!(matches!(error, Error::Start { cause: StartFailure::OffSurface { .. }, .. }), "{error}");
}

#[test]
fn momenta_whose_squares_are_no_numbers_have_a_direction() {
    let sphere = Scene::on(Sphere { r: 1.0 });
    for size in [1e-200, 1.0, 1e160, 1e300] {
        let start = |p: [f64; 3]| State::at([1.0, 0.0, 0.0]).moving(p);
        let error = refused(sphere.simulate(start([size, size, 0.0]), Rattle::new(1e3 / size)));
        let Error::Start { cause: StartFailure::NotTangent { sine, .. }, .. } = error else {
            panic!("{size:e}: {error}")
        };
        assert!((sine - 0.5_f64.sqrt()).abs() < 1e-12, "{size:e}: {sine}");
    }
}

#[test]
fn a_histogram_has_no_more_bins_than_there_is_memory_for() {
    let energy = |now: &Sight<'_, 1>| now.energy();
    for bins in [usize::MAX / 2, 1 << 40, (1 << 27) + 1] {
        let error = refused(Histogram::of(energy, 0.0, 1.0, bins));
        assert!(matches!(error, Error::Bins { .. }), "{error}");
    }
}

constraint! {
    /// A rod, times a number.
    struct ScaledRod { c }
    |a: [f64; 3], b: [f64; 3]| c * (sum(i in 0..3, (a[i] - b[i])^2) - 1)
}

/// Steps divide by the square of a gradient. Where the square is beyond the numbers the error says so, and not that
/// there is no gradient.
#[test]
fn gradients_whose_squares_are_no_numbers_are_told() {
    let start = State::of([[0.0; 3], [1.0, 0.0, 0.0]]).with_momenta([[0.0; 3], [0.0, 1.0, 0.0]]);
    let scene = |c: f64| Scene::points(2).link(ScaledRod { c }, [[0, 1]]);
    for c in [-1.0, 1e-140, 1e140] {
        let mut simulation = scene(c).simulate(scene(c).project(&start).unwrap(), Rattle::new(0.1)).unwrap();
        simulation.run(10).unwrap();
        let [a, b] = [0, 1].map(|i| simulation.positions().nth(i).unwrap());
        assert!(((a - b).norm() - 1.0).abs() <= 8.0 * f64::EPSILON, "{c:e}: {a} {b}"); // a rounding of each coordinate
    }
    for c in [1e-300, -1e-200, 1e-160, 1e160, 1e200, 1e300] {
        let errors =
            [refused(scene(c).simulate(start.clone(), Rattle::new(0.1))), refused(scene(c).project(&start))];
        for error in errors {
            let Error::Start { cause: StartFailure::OutOfScale { equation, gradient }, .. } = &error else {
                panic!("{c:e}: {error}")
            };
            assert!((gradient / (8.0_f64.sqrt() * c.abs()) - 1.0).abs() < 1e-12, "{c:e}: {error}");
            assert!(equation.as_ref().is_some_and(|equation| equation.bodies == [0, 1]), "{error}");
            assert!(error.to_string().contains("multiply the constraint by about"), "{error}");
        }
    }
}

/// So they do by that over the masses, which is another's size where masses are.
#[test]
fn gradients_whose_squares_over_masses_are_no_numbers_are_told() {
    let start = State::of([[0.0; 3], [1.0, 0.0, 0.0]]);
    let scene = |c: f64, mass: f64| Scene::points(2).link(ScaledRod { c }, [[0, 1]]).masses([mass; 2]);
    for (c, mass) in [(1e-140, 1e30), (1e140, 1e-30)] {
        let errors = [
            refused(scene(c, mass).simulate(start.clone(), Rattle::new(0.1))),
            refused(scene(c, mass).project(&start)),
        ];
        for error in errors {
            let told = matches!(error, Error::Start { cause: StartFailure::OutOfScale { .. }, .. });
            assert!(told && error.to_string().contains("over the masses"), "{c:e} {mass:e}: {error}");
        }
        let spin = State::of([[0.0; 3], [1.0, 0.0, 0.0]]).with_momenta([[0.0; 3], [0.0, mass, 0.0]]);
        let scene = scene(1.0, mass);
        let mut simulation = scene.simulate(scene.project(&spin).unwrap(), Rattle::new(0.1)).unwrap();
        simulation.run(10).unwrap();
        let [a, b] = [0, 1].map(|i| simulation.positions().nth(i).unwrap());
        assert!(((a - b).norm() - 1.0).abs() <= 8.0 * f64::EPSILON, "{mass:e}: {a} {b}");
    }
}

pair_potential! {
    /// A bond that breaks at r₀ (FENE).
    struct Fene { k, r0 }
    |r| -k * r0^2 / 2 * ln(1 - (r / r0)^2)
}

/// Where a potential is no number, its force is none, though the formula of its slope has a value there: nobody passes.
#[test]
fn no_one_goes_where_a_potential_is_no_number() {
    let bond = Scene::points::<3>(2).with(Fene { k: 30.0, r0: 1.5 });
    let start = || State::of([[0.0; 3], [1.0, 0.0, 0.0]]).with_momenta([[-9.0, 0.0, 0.0], [9.0, 0.0, 0.0]]);
    fn refused(error: Option<rattle::Error>, method: &str) {
        let error = error.map(|error| error.to_string()).unwrap_or_default();
        println!("{method}: {error}");
        assert!(error.contains("Fene"), "{method}: {error}");
    }
    fn breaks<S: Method>(
        bond: &Scene<rattle::network::Network<3>, impl rattle::effect::Effects<3>, rattle::bodies::Many, 3>,
        start: State<3>,
        method: S,
    ) -> bool {
        let mut simulation = bond.simulate(start, method).unwrap();
        let broken = simulation.run(100).is_err();
        let [a, b] = [0, 1].map(|body| simulation.positions().nth(body).unwrap());
        let bound = (a - b).norm() < 1.5 && simulation.energy().is_finite();
        assert!(broken || bound, "{}", simulation.method().name());
        broken
    }
    for h in [0.02, 0.05] {
        refused(bond.simulate(start(), Rattle::new(h)).unwrap().run(100).err(), "Rattle");
        assert!(breaks(&bond, start(), PositionVerlet::new(h)));
        assert_eq!(breaks(&bond, start(), Lobatto::<4>::new(h)), h > 0.02);
        breaks(&bond, start(), Dop853::new(h));
        let mut ensemble = bond.ensemble((0..9).map(|_| start()), Rattle::new(h)).unwrap();
        ensemble.run(100);
        assert_eq!(ensemble.failures().count(), 9);
    }
    macro_rules! each {
        ($($name:ident: $potential:expr_2021, $beyond:literal;)*) => {$(
            potential! { struct $name {} |x| $potential }
            let scene = Scene::points::<1>(1).with($name {});
            refused(scene.simulate(State::at([$beyond]), Rattle::new(0.1)).err(), stringify!($name));
        )*};
    }
    each! {
        FeneLn: ln(x), -0.5;
        FeneLog10: log10(x), -0.5;
        FeneLog2: log2(x), -0.5;
        FeneAtanh: atanh(x), 1.5;
        FeneAcosh: acosh(x), -1.5;
        FeneAsin: asin(x), 1.5;
        FeneAcos: acos(x), -1.5;
        FeneSqrt: sqrt(x), -0.5;
        FenePower: x^2.5, -0.5;
    }
}

#[test]
fn steps_without_inner_steps_are_refused() {
    let scene = Scene::on(Sphere { r: 1.0 });
    let start = || State::at([1.0, 0.0, 0.0]).moving([0.0, 1.0, 0.0]);
    for inner in [0, 65_537, u32::MAX] {
        let (geodesic, baoab) = (Geodesic::new(inner, 0.01), Baoab::with_inner(inner, 0.01));
        for (method, alone, in_lanes) in [
            (
                "geodesic RATTLE",
                scene.simulate(start(), geodesic).map(drop),
                scene.ensemble([start()], geodesic).map(drop),
            ),
            ("g-BAOAB", scene.simulate(start(), baoab).map(drop), scene.ensemble([start()], baoab).map(drop)),
        ] {
            let error = Error::InnerSteps { method, inner };
            assert_eq!(alone, Err(error.clone()));
            let told = in_lanes.unwrap_err().to_string();
            assert_eq!(told, format!("trajectory 0: {error}"));
        }
    }
    assert!(scene.simulate(start(), Geodesic::new(65_536, 0.01)).is_ok());
}

#[test]
fn shadow_energies_have_few_orders() {
    for order in [0, 1, 3, 13, 14, usize::MAX] {
        assert_eq!(ShadowEnergy::<3>::new(order).map(drop), Err(Error::ShadowOrder(order)));
    }
    assert!((2..=12).step_by(2).all(|order| ShadowEnergy::<3>::new(order).is_ok()));
}

/// `steps / frames` is 0 where there are more frames than steps.
#[test]
fn every_0_steps_is_every_step() {
    let scene = Scene::point();
    let start = || State::at([0.0]).moving([1.0]);
    let mean = || Mean::of(|now: &Sight<'_, 1>| now.position().x);
    let mut simulation = scene.simulate(start(), Rattle::new(0.5)).unwrap();
    let mut seen = mean();
    simulation.observe(4, 0, &mut seen).unwrap();
    assert_eq!((seen.number(), seen.mean()), (4, 1.25));
    let mut ensemble = scene.ensemble([start()], Rattle::new(0.5)).unwrap();
    let seen = ensemble.observe(4, 0, mean);
    assert_eq!((seen.number(), seen.mean()), (4, 1.25));
    assert_eq!(ensemble.run_while(10, 0, |now| now.state(0).time() < 3.0), 2);
    let mut snapshots = 0;
    let count = |_: &rattle::ensemble::Snapshot<1>| {
        snapshots += 1;
        Ok::<(), Error>(())
    };
    ensemble.stream(3, 0, count).unwrap();
    assert_eq!(snapshots, 3);
}

/// Forces that velocities choose are no pushes, though they have no slopes; momenta take them as they are.
#[test]
fn brownian_motion_has_no_velocities_to_choose_by() {
    let (start, brownian) =
        (|| State::at([0.0, 0.0]).moving([0.1, 0.0]), || Brownian::new(1.0, 1.0, 1, 0.01));
    let told = [
        refused(Scene::point().with(Thrust { f: 1.0 }).simulate(start(), brownian())).to_string(),
        refused(Scene::point().with(Rubbing { mu: 1.0 }).simulate(start(), brownian())).to_string(),
    ];
    assert!(told.iter().all(|told| told.contains("Rattle") && !told.contains("Brownian,")), "{told:?}");
    Scene::point().with(Wind { f: 1.0 }).simulate(start(), brownian()).unwrap().run(3).unwrap();

    let mut back = Scene::point().with(Thrust { f: -0.1 }).simulate(start(), Rattle::new(0.01)).unwrap();
    back.run(100).unwrap();
    assert!((back.momentum()[0] - -0.05).abs() < 1e-3, "{}", back.momentum()); // 0.1 − 0.2·0.5 − 0.1·0.5
}

#[test]
fn a_kind_that_is_no_number_of_a_kind_is_refused() {
    for kind in [1024, 4_000_000_000, usize::MAX] {
        let mixed = Kinds::mixed([0, kind], |_, _| Wca { epsilon: 1.0, sigma: 1.0 });
        let two = State::of([[0.0; 3], [2.0, 0.0, 0.0]]);
        let told = Scene::points(2).with(mixed).simulate(two, Rattle::new(0.01)).unwrap_err().to_string();
        assert!(told.contains(&kind.to_string()) && told.contains("1024"), "{told}");
    }
}

#[test]
fn a_parameter_that_is_nan_is_told_by_its_name() {
    let named = |result: Result<(), Error>| match result.unwrap_err() {
        Error::NanParameter { formula, parameter } => format!("{formula}.{parameter}"),
        other => panic!("{other}"),
    };
    macro_rules! moved {
        ($scene:expr, $start:expr) => {
            named($scene.simulate(State::of($start), Rattle::new(0.01)).map(|_| ()))
        };
    }
    let (nan, two, line) = (f64::NAN, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], [[0.0], [1.0]]);
    let (pair, beads, plane) = (Scene::points::<3>(2), Scene::points::<1>(2), [[0.0, 0.0], [1.0, 0.0]]);
    let wca = Wca { epsilon: 1.0, sigma: nan };
    assert_eq!(moved!(pair.clone().with(wca), two), "Wca.sigma");
    assert_eq!(moved!(pair.clone().with(wca.within(2.0)), two), "Wca.sigma");
    assert_eq!(moved!(pair.clone().with(Kinds::new([0, 0], [wca])), two), "Wca.sigma");
    assert_eq!(moved!(pair.clone().with(Kinds::new([0, 0], [wca.within(2.0)])), two), "Wca.sigma");
    let sphere = Scene::on(Sphere { r: nan }).bodies(2).with(wca);
    assert_eq!(moved!(sphere, two), "Sphere.r");
    assert_eq!(named(sphere.project(&State::of(two)).map(|_| ())), "Sphere.r");
    let spring = |k| Spring { k };
    assert_eq!(moved!(beads.clone().with(spring(nan).over([[0, 1]])), line), "Spring.k");
    let each = Over::each([(spring(1.0), [0, 1]), (spring(nan), [1, 0])]);
    assert_eq!(moved!(beads.clone().with(each), line), "Spring.k");
    let in_plane = Scene::points::<2>(2);
    assert_eq!(moved!(in_plane.clone().with(Thrust { f: nan }), plane), "Thrust.f");
    assert_eq!(
        moved!(in_plane.clone().with(Harmonic { stiffness: 1.0, centre: [0.0, nan] }), plane),
        "Harmonic.centre"
    );
    assert_eq!(moved!(in_plane.clone().with(Shaken { a: nan }), plane), "Shaken.a");
    let rods = pair.clone().link_each([(Rod { length: 1.0 }, [0, 1]), (Rod { length: nan }, [1, 0])]);
    assert_eq!(moved!(rods, two), "Rod.length");
    let free = pair.simulate(State::of(two), Rattle::new(0.01)).unwrap();
    let wall = Plane { a: 1.0, b: 0.0, c: nan, d: 0.0 };
    assert_eq!(named(free.collide(Stop::above(wall)).map(|_| ())), "Plane.c");
    let hopf = Scene::in_phase_space(Circle { r: 1.0 }, Dropping { g: nan });
    assert_eq!(named(hopf.project(&State::at([1.0])).map(|_| ())), "Dropping.g");
    let starts = [0.5, nan].map(|r| (Scene::on(Sphere { r }), State::at([r, 0.0, 0.0])));
    let swept = starts.iter().map(|(scene, start)| (scene, start.clone()));
    let told = refused(Ensemble::sweep(Double, swept, Rattle::new(0.1))).to_string();
    assert_eq!(told, "trajectory 1: `Sphere`: its parameter r is NaN");
}

/// Potentials that have a force where they have no value: the effect is named, in ensembles too, where a scene has
/// others, and where the time makes it so.
#[test]
fn energies_without_a_value_are_refused() {
    potential! { struct Offset { g, c } |x, y| g * y + x * 0 + ln(c) }
    potential! { struct Steps { c } |x, y| c * floor(sqrt(x)) + y }
    potential! { struct Rising { c } |_x, y, t| c * y + ln(t) }
    let said = |refused: Result<(), rattle::Error>| refused.unwrap_err().to_string();
    let start = State::at([-1.0, 1.0]);
    macro_rules! refused {
        ($name:literal, $effect:expr) => {{
            let scene = Scene::point().with(Offset { g: 1.0, c: 1.0 }).with($effect);
            let alone = said(scene.simulate(start.clone(), Rattle::new(0.01)).map(|_| ()));
            assert!(alone.starts_with(concat!("effect `", $name, "`: its energy is NaN")), "{alone}");
            let starts = (0..20).map(|i| State::at([f64::from(i) - 19.0, 1.0]));
            let many = said(scene.ensemble(starts, Rattle::new(0.01)).map(|_| ()));
            assert!(many.contains(concat!("trajectory 0: effect `", $name, "`")), "{many}");
        }};
    }
    refused!("Offset", Offset { g: 1.0, c: -1.0 });
    refused!("Steps", Steps { c: 1.0 });
    let late = Scene::point().with(Rising { c: 1.0 });
    let early = said(late.simulate(start.clone().at_time(-1.0), Rattle::new(0.01)).map(|_| ()));
    assert!(early.contains("Rising"), "{early}");
    late.simulate(start.at_time(1.0), Rattle::new(0.01)).unwrap();
}
