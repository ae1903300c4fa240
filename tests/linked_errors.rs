//! What cannot be is an error that says which body, which number and what to try, and leaves the simulation as it was.

use crate::common::linked::*;
use crate::common::*;
use rattle::error::{EffectFailure, LinkedFailure, NetworkMistake, Passing, StartFailure, StepFailure};
use rattle::linked::Linked;
use rattle::network::LinearAlgebra::Elimination;
use rattle::prelude::*;
use rattle::system::System;
use rattle::{Error, bodies::Count, effect::Forces};

/// The message has all of these.
fn says(error: &Error, words: &[&str]) {
    let text = error.to_string();
    for word in words {
        assert!(text.contains(word), "`{word}` is not in: {text}");
    }
}

/// Runs until a step fails, and checks that the simulation is then as it was, to the bit, also in what it keeps.
fn fails<F, N, S, const D: usize>(simulation: &mut Simulation<Linked<F, N, D>, S, D>, steps: u64) -> Error
where
    F: Forces<f64, D>,
    N: Count,
    S: Method,
    Linked<F, N, D>: System<f64, D, Count = N>,
{
    for _ in 0..steps {
        let (state, seen) = (bits(&simulation.state()), seen(simulation));
        let taken = simulation.steps();
        if let Err(error) = simulation.step() {
            assert_eq!(bits(&simulation.state()), state, "{error}");
            assert_eq!(self::seen(simulation), seen, "{error}");
            assert_eq!(simulation.steps(), taken);
            let Error::Step { step, .. } = error else { panic!("{error}") };
            assert_eq!(step, taken + 1);
            assert_eq!(simulation.step().unwrap_err().to_string(), error.to_string(), "again the same");
            return error;
        }
    }
    panic!("no failure in {steps} steps");
}

/// What is evaluated at the state.
fn seen<F: Forces<f64, D>, N: Count, S: Method, const D: usize>(
    simulation: &Simulation<Linked<F, N, D>, S, D>,
) -> String
where
    Linked<F, N, D>: System<f64, D, Count = N>,
{
    let (energy, work) = (simulation.energy(), simulation.work());
    format!("{energy} {work} {:?} {:?}", simulation.multipliers(), simulation.constraint_forces())
}

fn start_cause(error: Error) -> (usize, StartFailure) {
    match error {
        Error::Start { body, cause } => (body, cause),
        other => panic!("{other}"),
    }
}

fn step_cause(error: Error) -> StepFailure {
    match error {
        Error::Step { cause, .. } => cause,
        other => panic!("{other}"),
    }
}

#[test]
fn links_and_pins_that_make_no_sense() {
    let free = || Scene::points::<2>(3);
    let start = double_pendulum;
    let rod = Rod { length: 1.0 };
    let check = |result: Result<(), Error>, mistake: NetworkMistake, words: &[&str]| {
        let error = result.unwrap_err();
        says(&error, words);
        assert_eq!(error, Error::Network(mistake));
    };
    let method = Rattle::new(0.01);
    let missing = |what, member, body| NetworkMistake::NoSuchBody { what, member, body, bodies: 3 };
    for body in [3, 4, usize::MAX] {
        let link = free().link(rod, [[0, 1], [1, body]]).simulate(start(), method);
        check(link.map(drop), missing("Rod", 1, body), &["Rod 1", &format!("body {body}"), "has 3"]);
        let each = free().link_each([(rod, [body, 0])]).simulate(start(), method);
        check(each.map(drop), missing("Rod", 0, body), &["Rod 0"]);
        let project = free().link(rod, [[body, 1]]).project(&start());
        check(project.map(drop), missing("Rod", 0, body), &["Rod 0"]);
        let pin = free().pin(body, [0.0; 2]).simulate(start(), method);
        check(pin.map(drop), missing("pin", 0, body), &["pin", "has 3"]);
        let acting = free().link_acting(rod, [[0, body]], [[true; 2]; 2]).simulate(start(), method);
        check(acting.map(drop), missing("Rod", 0, body), &["Rod 0"]);
        let effect = free().with(PlanarGravity { g: 1.0 }.over([[0], [body]])).simulate(start(), method);
        let error = effect.map(drop).unwrap_err();
        says(&error, &["Gravity", " 1 names body", &body.to_string()]);
    }
    let twice = free().link(rod, [[0, 1], [2, 2]]).simulate(start(), method);
    let mistake = NetworkMistake::Repeated { what: "Rod", member: 1, body: 2 };
    check(twice.map(drop), mistake, &["Rod 1", "body 2 twice", "different bodies"]);
    let coupled = nalgebra::Matrix2::new(2.0, 1.0, 1.0, 2.0);
    let acting = free().mass(coupled).link_acting(rod, [[0, 1]], [[true; 2]; 2]).simulate(start(), method);
    let mistake = NetworkMistake::ActingNeedsDiagonalMass { what: "Rod" };
    check(acting.map(drop), mistake, &["Rod", "do not couple"]);

    // Of some bodies alone, none of which there is a copy of for each of another number.
    let [pinned, rods] = [free().pin(0, [0.0; 2]), free().link(rod, [[0, 1], [1, 2]])];
    let some = free().link(Pendulum { length: 1.0 }, [[0]]);
    let each = [0, 1, 2].map(|body| (Pendulum { length: 1.0 + body as f64 }, [body]));
    for (scene, what) in
        [(pinned, "pin"), (rods, "Rod"), (some, "Pendulum"), (free().link_each(each), "Pendulum")]
    {
        let rest = State::of([[1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]);
        assert!(scene.clone().bodies(3).project(&rest).is_ok(), "{what}");
        let more = State::of([[1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [4.0, 0.0]]);
        let (started, projected) = (
            scene.clone().bodies(4).simulate(more.clone(), method).map(drop),
            scene.bodies(4).project(&more),
        );
        says(&started.unwrap_err(), &[what, "some of 3 bodies", "`bodies(4)`"]);
        says(&projected.unwrap_err(), &[what, "some of 3 bodies"]);
    }

    let counted = free().simulate(State::of([[0.0, 0.0]]), method).map(drop).unwrap_err();
    assert!(matches!(counted, Error::BodyCount { scene: 3, state: 1 }), "{counted}");
}

#[test]
fn nothing_is_something_too() {
    let method = Rattle::new(0.5);
    let mut none = Scene::points::<2>(0).simulate(State::of([[0.0; 2]; 0]), method).unwrap();
    none.run(3).unwrap();
    assert_eq!((none.bodies(), none.energy(), none.time()), (0, 0.0, 1.5));
    let none =
        Scene::points::<2>(0).link(Rod { length: 1.0 }, [[0_usize; 2]; 0]).project(&State::of([[0.0; 2]; 0]));
    assert!(none.unwrap().is_empty());

    let flying = State::of([[0.0, 0.0], [1.0, 0.0]]).moving([2.0, 1.0]);
    let mut free = Scene::points(2)
        .link(Rod { length: 1.0 }, [[0_usize; 2]; 0])
        .mass(2.0)
        .simulate(flying, method)
        .unwrap();
    free.run(2).unwrap();
    assert_eq!(free.positions().map(<[f64; 2]>::from).collect::<Vec<_>>(), [[1.0, 0.5], [2.0, 0.5]]);
    assert!(free.multipliers().is_empty() && free.constraint_residual() == 0.0);
}

#[test]
fn starts_that_do_not_fit() {
    let scene = Scene::points(3).link(Rod { length: 1.0 }, chain(2)).pin(0, [0.0, 0.0]);
    let method = Rattle::new(0.01);
    let simulate = |state| scene.simulate(state, method).map(drop).unwrap_err();

    let off = State::of([[0.0, 0.0], [1.0, 0.0], [1.0, 1.001]]);
    let error = simulate(off.clone());
    says(&error, &["body 1", "Rod 1 (bodies 1, 2)", "off by 7.0", "g = 2.0", "`scene.project(state)`"]);
    let StartFailure::OffConstraint { distance, value, .. } = start_cause(error).1 else { panic!() };
    // |g|/|∇g| with ∇g on both bodies: 2.001e-3 / (2·1.001·√2).
    assert!(
        (value - 2.001e-3).abs() < 1e-12 && (distance - 2.001e-3 / (2.002 * 2.0_f64.sqrt())).abs() < 1e-12
    );
    scene.simulate(scene.project(&off).unwrap(), method).unwrap();

    let bent = double_pendulum().with_momenta([[0.0, 0.0], [0.0, 1.0], [0.0, 1.001]]);
    let error = simulate(bent.clone());
    says(&error, &["momenta break Rod 1 (bodies 1, 2)", "rate 2.000e-3", "`scene.project(state)`"]);
    assert!(matches!(start_cause(error), (1, StartFailure::NotAlong { .. })));
    scene.simulate(scene.project(&bent).unwrap(), method).unwrap();

    let error = simulate(State::of([[0.0, 0.1], [1.0, 0.0], [1.0, 1.0]]));
    says(&error, &["body 0", "pinned at [0.0, 0.0]", "[0.0, 0.1]"]);
    let error = simulate(double_pendulum().moving([0.0, 1.0]));
    says(&error, &["body 0", "pinned", "momentum [0.0, 1.0]"]);
    for bad in [f64::NAN, f64::INFINITY] {
        let error = simulate(State::of([[0.0, 0.0], [1.0, bad], [1.0, 1.0]]));
        says(&error, &["body 1", "position[1]", "finite"]);
        let error = simulate(double_pendulum().with_momenta([[0.0, 0.0], [0.0, 0.0], [bad, 0.0]]));
        says(&error, &["body 2", "momentum[0]", "finite"]);
        assert!(
            scene.clone().pin(0, [bad, 0.0]).simulate(double_pendulum(), method).is_err(),
            "pin at {bad}"
        );
    }
}

constraint! {
    /// The plane z = 0, written as z².
    struct Square {}
    |_x, _y, z| z^2
}

constraint! {
    /// Only where x ≥ 0.
    struct Half {}
    |x, y| y + sqrt(x)^3
}

#[test]
fn constraints_that_are_no_constraints() {
    let method = Rattle::new(0.01);
    let flat = Scene::points(1).link(Square {}, [[0]]).simulate(State::of([[1.0, 0.0, 0.0]]), method);
    let error = flat.map(drop).unwrap_err();
    says(&error, &["Square 0 (body 0)", "second order", "z instead of z²"]);

    // Not a number at the start, and on the way.
    let half = Scene::points(1).link(Half {}, [[0]]);
    let error = half.simulate(State::of([[-1.0, 0.0]]), method).map(drop).unwrap_err();
    assert!(matches!(start_cause(error), (0, StartFailure::ConstraintNotFinite { .. })));
    let start = half.project(&State::of([[1.0, -1.0]]).moving([-1.0, 1.5])).unwrap();
    let mut simulation = half.simulate(start, Rattle::new(0.05)).unwrap();
    let error = fails(&mut simulation, 1000);
    assert!(simulation.position_of(0)[0] < 0.2, "{error}");
}

trait PositionOf<const D: usize> {
    fn position_of(&self, body: usize) -> [f64; D];
}
impl<Y: System<f64, D>, S: Method, const D: usize> PositionOf<D> for Simulation<Y, S, D> {
    fn position_of(&self, body: usize) -> [f64; D] {
        self.positions().nth(body).unwrap().into()
    }
}

#[test]
fn dependent_and_contradictory_equations() {
    let method = Rattle::new(0.01);
    let rod = Rod { length: 1.0 };
    let twice = || Scene::points(2).link(rod, [[0, 1], [0, 1]]).pin(0, [0.0, 0.0]);
    let start = State::of([[0.0, 0.0], [0.6, 0.8]]);
    twice().simulate(start.clone(), method).unwrap().run(10).unwrap();
    for error in [
        twice().linear_algebra(Elimination).simulate(start.clone(), method).map(drop).unwrap_err(),
        twice().linear_algebra(Elimination).project(&start).map(drop).unwrap_err(),
    ] {
        says(
            &error,
            &["Rod 1 (bodies 0, 1)", "depends on the others", "leave it out", "LinearAlgebra::Orthogonal"],
        );
        assert!(matches!(start_cause(error).1, StartFailure::Dependent { sine, .. } if sine <= 1e-7));
    }

    // Two lengths for one rod.
    let both = Scene::points(2).link_each([(rod, [0, 1]), (Rod { length: 1.1 }, [0, 1])]).pin(0, [0.0, 0.0]);
    let error = both.project(&start).unwrap_err();
    says(&error, &["Rod ", "(bodies 0, 1)", "contradicts the others"]);
    assert!(matches!(start_cause(error).1, StartFailure::Contradictory { distance, .. } if distance > 0.01));
}

constraint! {
    /// A rod that grows.
    struct GrowingRod { rate }
    |a: [f64; 2], b: [f64; 2], t| sum(i in 0..2, (a[i] - b[i])^2) - (1 + rate * t^2)^2
}

/// At t = 0 both agree in all that can be seen; then they part.
#[test]
fn moving_constraints_that_part() {
    let scene = Scene::points(2)
        .link_moving(GrowingRod { rate: 0.0 }, [[0, 1]])
        .link_moving(GrowingRod { rate: 0.1 }, [[0, 1]])
        .pin(0, [0.0, 0.0]);
    let mut simulation = scene.simulate(State::of([[0.0, 0.0], [0.6, 0.8]]), Rattle::new(0.01)).unwrap();
    let error = fails(&mut simulation, 10);
    says(&error, &["GrowingRod 0 (bodies 0, 1)", "contradicts the others", "residuals as lengths"]);
    assert!(matches!(step_cause(error), StepFailure::Linked(LinkedFailure::Contradictory { .. })));
}

/// A parallelogram of equal sides branches where it is flat: it could go on as an anti-parallelogram. It is refused
/// there, not turned over.
#[test]
fn four_bars_at_the_flat_place() {
    let bars = [[0, 1], [1, 2], [2, 3]];
    let lengths = [1.0, 2.0, 1.0].map(|length| Rod { length });
    let scene =
        Scene::points(4).link_each(lengths.into_iter().zip(bars)).pin(0, [0.0, 0.0]).pin(3, [2.0, 0.0]);
    // Turning at a constant angle a step, so that the flat place is hit to rounding.
    let steps = 50;
    let h = f64::sin(std::f64::consts::FRAC_PI_2 / f64::from(steps));
    let start = State::of([[0.0, 0.0], [0.0, 1.0], [2.0, 1.0], [2.0, 0.0]]).with_momenta([
        [0.0, 0.0],
        [1.0, 0.0],
        [1.0, 0.0],
        [0.0, 0.0],
    ]);
    for algebra in [rattle::network::LinearAlgebra::Orthogonal, Elimination] {
        let scene = scene.clone().linear_algebra(algebra);
        let mut simulation = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
        let error = fails(&mut simulation, 2 * steps as u64);
        println!("{algebra:?}: {error}");
        // Newton's method knows the flat place itself to √ε only: it may be the next step that cannot be taken.
        assert!((steps as u64 - 1..=steps as u64).contains(&simulation.steps()), "{error}");
        says(&error, &["Rod", "depend on the others", "branches here"]);
        let advised = error.to_string().contains("`LinearAlgebra::Orthogonal`");
        assert_eq!(advised, algebra == Elimination, "what is at work is not advised: {error}");
        assert!(
            matches!(step_cause(error), StepFailure::Linked(LinkedFailure::RankLost { sine, .. }) if sine <= 1e-6)
        );

        // A step across it has no root that is followed from h = 0; until then the bars are parallel.
        let mut simulation = scene.simulate(start.clone(), Rattle::new(0.03)).unwrap();
        let parallel = |now: &Simulation<_, _, 2>| {
            let q: Vec<_> = now.positions().collect();
            (q[2] - q[1] - (q[3] - q[0])).norm()
        };
        let mut worst = 0.0_f64;
        let ended = simulation.run_with(400, |now| worst = worst.max(parallel(now)));
        println!("parallel to {worst:.1e}, {ended:?}");
        assert!(worst <= 1e-12 && simulation.steps() > 50, "{worst:e}");
        says(&ended.unwrap_err(), &["Rod ", "branches here"]);
    }
}

/// A pendulum whose rod acts along x only: near the bottom x does not change the length.
#[test]
fn a_multiplier_that_cannot_act() {
    let scene = Scene::points(1)
        .link_acting(Pendulum { length: 1.0 }, [[0]], [[true, false]])
        .with(PlanarGravity { g: 1.0 });
    let mut simulation = scene.simulate(State::of([[1.0, 0.0]]), Rattle::new(0.01)).unwrap();
    let error = fails(&mut simulation, 1000);
    println!("{error}");
    says(&error, &["body 0", "Pendulum 0 (body 0)", "no longer hold", "share", "let it act on the others"]);
    let [x, y] = simulation.position_of(0);
    assert!(x.abs() < 0.25 && y < -0.96, "{x}, {y}");
    assert!(
        matches!(step_cause(error), StepFailure::Linked(LinkedFailure::CannotAct { share, .. }) if share < 0.25)
    );
    // y falls freely: that is what it means.
    let t = simulation.time();
    assert!((y + 0.5 * t * t).abs() <= 1e-14, "{y}, {t}");

    let error = scene.simulate(State::of([[0.0, -1.0]]), Rattle::new(0.01)).map(drop).unwrap_err();
    says(&error, &["Pendulum 0 (body 0)", "does not change here"]);
}

#[test]
fn a_step_too_long_says_what_passes() {
    let scene = Scene::points(3)
        .link(Rod { length: 1.0 }, chain(2))
        .pin(0, [0.0, 0.0])
        .with(PlanarGravity { g: 1.0 });
    let (mut found, mut composed_failures) = (0, 0);
    for (speed, h) in [(3.0, 0.5), (10.0, 0.3), (1.0, 2.0), (0.0, 4.0)] {
        let start = double_pendulum().with_momenta([[0.0, 0.0], [0.0, speed], [-speed, speed]]);
        let mut simulation = scene.simulate(start, Rattle::new(h)).unwrap();
        let Err(error) = simulation.run(100) else { continue };
        let state = simulation.state();
        assert_eq!(fails(&mut simulation, 1), error);
        says(
            &error,
            &["step ", "body ", "Rod ", "(bodies ", "residuals as lengths [", "|∇g| = 2.", "h·|∇²g v|/|∇g|"],
        );
        let StepFailure::Linked(LinkedFailure::NotSolved {
            passing: Passing(Some(short)),
            turn,
            h: asked,
            gradient,
            ref residuals,
            ..
        }) = step_cause(error.clone())
        else {
            panic!("{error}")
        };
        println!("{error}");
        assert!(asked == h && !residuals.is_empty() && turn.is_finite());
        assert!((gradient - 8.0_f64.sqrt()).abs() < 1e-12 || (gradient - 2.0).abs() < 1e-12, "{gradient}");
        says(&error, &[&format!("a step of {short:.3e} passes")]);
        scene.simulate(state.clone(), Rattle::new(short)).unwrap().step().unwrap();
        assert!(
            scene.simulate(state.clone(), Rattle::new(2.0 * short)).unwrap().step().is_err(),
            "the longest"
        );
        // In a composition stages before the one that fails are taken back too.
        let suzuki = Composition::new(SUZUKI_1990_ORDER_4, 4.0 * short);
        let mut composed = scene.simulate(state, suzuki).unwrap();
        composed_failures += u32::from(matches!(fails(&mut composed, 1000), Error::Step { .. }));
        found += 1;
    }
    assert!(found >= 3 && composed_failures == found, "{found}");
}

potential! {
    /// Not a number left of the origin.
    struct Edge {}
    |x, _y| sqrt(x)^3
}

#[test]
fn forces_that_are_not_finite() {
    let scene = Scene::points(3).link(Rod { length: 1.0 }, chain(2)).pin(0, [0.0, 0.0]);
    let edge = scene.clone().with(PlanarGravity { g: 1.0 }).with(Edge {}.over([[2]]));
    let start = double_pendulum().with_momenta([[0.0, 0.0], [0.0, 0.0], [-1.0, 0.0]]);
    let mut simulation = edge.simulate(start, Rattle::new(0.05)).unwrap();
    let error = fails(&mut simulation, 100);
    says(&error, &["body 2", "Edge", "check the potential's domain"]);
    assert!(matches!(step_cause(error), StepFailure::Effect(EffectFailure::ForceNotFinite { .. })));
    assert!(simulation.position_of(2)[0] >= 0.0);

    let left = State::of([[0.0, 0.0], [-1.0, 0.0], [-1.0, 1.0]]);
    let error = edge.simulate(left, Rattle::new(0.05)).map(drop).unwrap_err();
    says(&error, &["body 2", "Edge", "domain"]);

    // Too strong to be squared.
    let strong = scene.with(PlanarGravity { g: 1e200 });
    let mut simulation = strong.simulate(double_pendulum(), Rattle::new(0.05)).unwrap();
    println!("{}", fails(&mut simulation, 1));
}

/// Pinning a whole edge of a net leaves links between pins: they hold, or the error says that.
#[test]
fn links_between_pins() {
    let scene = |length| {
        Scene::points(3)
            .link(Rod { length }, [[0, 1]])
            .link(Rod { length: 1.0 }, [[1, 2]])
            .pin(0, [0.0, 0.0])
            .pin(1, [3.0, 0.0])
    };
    let start = State::of([[0.0, 0.0], [3.0, 0.0], [4.0, 0.0]]);
    let mut simulation =
        scene(3.0).with(PlanarGravity { g: 1.0 }).simulate(start.clone(), Rattle::new(0.01)).unwrap();
    simulation.run(100).unwrap();
    assert!(simulation.constraint_residual() < 1e-14 && simulation.multipliers().len() == 2);
    assert_eq!(simulation.multipliers()[0], 0.0);
    for error in
        [scene(1.0).project(&start).unwrap_err(), scene(1.0).simulate(start, Rattle::new(0.01)).unwrap_err()]
    {
        says(&error, &["Rod 0 (bodies 0, 1)", "joins pinned bodies alone", "off by"]);
    }
}

/// Links that cannot hold together are named.
#[test]
fn links_that_cannot_hold_together() {
    let triangle = Scene::points(3)
        .link_each([1.0, 1.0, 3.0].map(|length| Rod { length }).into_iter().zip([[0, 1], [1, 2], [0, 2]]));
    let error = triangle.project(&State::of([[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]])).unwrap_err();
    says(&error, &["Rod", "hold"]);
}
