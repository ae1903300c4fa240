//! Many particles, each on its own copy of a surface, go several at a time where the processor fuses multiply-add: as
//! each would go alone, whatever the number, and with the same errors.

use crate::common::*;
use nalgebra::SVector;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::effect::Effects;
use rattle::error::{EffectFailure, StepFailure};
use rattle::prelude::*;
use rattle::surfaces::Gyroid;
use rattle::{Error, bodies::One};
use std::array::from_fn;

constraint! {
    struct Landscape { height }
    |x, y, z| z - height * exp(-x^2 - y^2) + tanh(x) / 4 - ln(2 + y^2) / 4
}

constraint! {
    /// A sphere in ten dimensions.
    struct Ball {}
    |x: [f64; 10]| dot(x, x) - 1
}

/// So many starts on a surface, near the origin and further out by `size`, each on its own way with a speed up to 1.
fn starts<C: Constraint<D, 1> + Copy, const D: usize>(surface: C, number: usize, size: f64) -> Vec<State<D>> {
    let mut random = StdRng::seed_from_u64(number as u64);
    let mut starts = Vec::new();
    while starts.len() < number {
        let (q, p) = from_pairs(|| (random.random_range(-size..size), random.random_range(-1.0..1.0)));
        if let Ok(start) = Scene::on(surface).project(&State::at(q).moving(p)) {
            starts.push(start);
        }
    }
    starts
}

fn from_pairs<const D: usize>(mut pair: impl FnMut() -> (f64, f64)) -> (SVector<f64, D>, SVector<f64, D>) {
    let pairs: [(f64, f64); D] = from_fn(|_| pair());
    (pairs.map(|(q, _)| q).into(), pairs.map(|(_, p)| p).into())
}

fn together<const D: usize>(starts: &[State<D>]) -> State<D> {
    let (q, p) = (starts.iter().flat_map(State::positions), starts.iter().flat_map(State::momenta));
    State::of(q).with_momenta(p)
}

/// The multipliers of each equation in the order in which they are told.
#[derive(Default)]
struct Multipliers(Vec<(usize, f64)>, Vec<(usize, f64)>);

impl<const D: usize> Observer<D> for Multipliers {
    fn see(&mut self, _: &Sight<'_, D>, _: &Sight<'_, D>) {}
    fn join(&mut self, _: Self) {}
    fn position_multiplier(&mut self, equation: usize, lambda: f64) {
        self.0.push((equation, lambda));
    }
    fn momentum_multiplier(&mut self, equation: usize, mu: f64) {
        self.1.push((equation, mu));
    }
}

/// Moves particles together and alone: as far apart as rounding brings them, and with the same multipliers.
fn go_as_alone<C, E, S, const D: usize>(scene: &Scene<C, E, One, D>, surface: C, method: S, size: f64) -> f64
where
    C: Constraint<D, 1> + Copy + rattle::scene::Hold<D>,
    E: Effects<D> + Copy,
    S: Method,
{
    let mut worst = 0.0_f64;
    for number in [7, 8, 9, 16, 17, 24, 25, 32, 33, 63, 64, 65, 130] {
        let starts = starts(surface, number, size);
        let mut many = (*scene).bodies(number).simulate(together(&starts), method.clone()).unwrap();
        let mut of_many = Multipliers::default();
        many.observe(40, 1, &mut of_many).unwrap();
        for (body, start) in starts.into_iter().enumerate() {
            let mut alone = scene.simulate(start, method.clone()).unwrap();
            let mut of_one = Multipliers::default();
            alone.observe(40, 1, &mut of_one).unwrap();
            let state = many.state();
            let (q, p) = (state.positions().nth(body).unwrap(), state.momenta().nth(body).unwrap());
            let off = (q - alone.position()).amax().max((p - alone.momentum()).amax());
            worst = worst.max(off);
            assert!(off < 1e-13, "{number} particles, {body}: {off:e}");
            // λ is a displacement, rounded as positions are, over h²/2 and |∇g|.
            let displacement = 0.5 * method.step_size().powi(2) * surface.jacobian(&q).norm();
            for (all, own) in [(&of_many.0, &of_one.0), (&of_many.1, &of_one.1)] {
                let all: Vec<f64> =
                    all.iter().filter(|of| of.0 == body).map(|&(_, multiplier)| multiplier).collect();
                assert_eq!(all.len(), own.len());
                if let (Some(together), Some((_, alone))) = (all.last(), own.last()) {
                    let off = displacement * (together - alone).abs();
                    assert!(off < 1e-14, "{number} particles, {body}: {together} not {alone}");
                }
            }
        }
        assert!(many.cotangent_residual() < 1e-14);
    }
    worst
}

#[test]
#[cfg(long)]
fn many_go_as_each_alone() {
    let ring = TorusByDistance { major: 1.0, minor: 0.3 };
    let landscape = Landscape { height: 0.5 };
    let gyroid = Gyroid { k: 1.0, epsilon: 0.1 };
    let rattle = Rattle::new(0.01);
    let off = [
        go_as_alone(&Scene::on(SURFACE), SURFACE, rattle, 1.0),
        go_as_alone(&Scene::on(SURFACE).with(Gravity { g: 1.0 }), SURFACE, Rattle::new(-0.005), 1.0),
        go_as_alone(
            &Scene::on(ring).with(Gravity { g: 1.0 }),
            ring,
            Composition::new(SUZUKI_1990_ORDER_4, 0.01),
            1.5,
        ),
        go_as_alone(
            &Scene::on(landscape).with(Gravity { g: 1.0 }),
            landscape,
            rattle.guess(Extrapolated),
            2.0,
        ),
        go_as_alone(&Scene::on(gyroid), gyroid, Geodesic::new(1, 0.02), 3.0),
        go_as_alone(&Scene::on(gyroid).with(Gravity { g: 1.0 }), gyroid, rattle.guess(LastMultiplier), 3.0),
        go_as_alone(&Scene::on(ring).with(Gravity { g: 1.0 }), ring, rattle.solved_by(Broyden), 1.5),
        go_as_alone(&Scene::on(Ball {}), Ball {}, rattle, 1.0),
    ];
    println!("off by {off:?}");
}

/// One step that leads from a start on a surface in steps of 1, of all lengths up to thrice the radius of curvature.
fn long_steps<C: Constraint<3, 1> + Copy>(surface: C, number: usize, size: f64) -> Vec<State<3>> {
    let mut random = StdRng::seed_from_u64(5);
    let scaled = |start: &State<3>| {
        let (q, p) = (start.positions().next().unwrap(), start.momenta().next().unwrap());
        let reach = surface.jet(&q, &p).2[0].abs() / (surface.jacobian(&q).norm() * p.norm());
        State::at(q).moving(p * (random.random_range(0.0..3.0) / reach))
    };
    starts(surface, number, size).iter().map(scaled).collect()
}

/// Steps that alone can be taken end together where they end alone; the first that cannot is named, for the same
/// reason, and all stay where they are.
fn hard_steps_end_alike<C: Constraint<3, 1> + Copy>(surface: C, size: f64) -> [usize; 2] {
    let scene = Scene::on(surface);
    let steps = long_steps(surface, 2000, size);
    let (mut taken, mut refused) = (Vec::new(), Vec::new());
    for start in steps {
        let Ok(mut alone) = scene.simulate(start.clone(), Rattle::new(1.0)) else { continue };
        match alone.step() {
            Ok(()) => taken.push((start, alone.position(), alone.momentum())),
            Err(Error::Step { cause, .. }) => refused.push((start, cause)),
            Err(other) => panic!("{other}"),
        }
    }
    for (starts, refused) in taken.chunks(100).zip(refused.chunks(8)) {
        if starts.len() < 8 {
            continue; // would go one by one
        }
        let crowd: Vec<State<3>> = starts.iter().map(|(start, ..)| start.clone()).collect();
        let mut many =
            Scene::on(surface).bodies(crowd.len()).simulate(together(&crowd), Rattle::new(1.0)).unwrap();
        many.step().unwrap();
        for (i, (_, q, p)) in starts.iter().enumerate() {
            let (q_of, p_of) = (many.positions().nth(i).unwrap(), many.momenta().nth(i).unwrap());
            let off = ((q_of - q) / size).amax().max((p_of - p).amax() / (1.0 + p.amax()));
            assert!(off < 1e-12, "particle {i} ends {off:e} off");
        }
        for (k, (start, cause)) in refused.iter().enumerate() {
            let place = (37 * k) % crowd.len();
            let mut crowd = crowd.clone();
            crowd.insert(place, start.clone());
            crowd.push(refused[0].0.clone()); // a later one, which is not told
            let scene = Scene::on(surface).bodies(crowd.len());
            let mut many = scene.simulate(together(&crowd), Rattle::new(1.0)).unwrap();
            let before = bits(&many.state());
            let Err(Error::Step { body, cause: found, .. }) = many.step() else { panic!("{cause}") };
            assert_eq!(body, place, "{found}, not {cause}");
            assert_eq!(std::mem::discriminant(&found), std::mem::discriminant(cause), "{found}, not {cause}");
            assert_eq!(bits(&many.state()), before);
        }
    }
    [taken.len(), refused.len()]
}

#[test]
fn hard_steps_end_as_alone_and_are_refused_for_the_same_reason() {
    let ends = [
        hard_steps_end_alike(SURFACE, 1.1),
        hard_steps_end_alike(Lemniscate { a: 1.0, r: 0.01 }, 1.1),
        hard_steps_end_alike(TorusByDistance { major: 1.0, minor: 0.3 }, 1.3),
        hard_steps_end_alike(Gyroid { k: 1.0, epsilon: 0.0 }, 3.0),
        hard_steps_end_alike(Landscape { height: 0.5 }, 2.0),
    ];
    println!("taken and refused {ends:?}");
    assert!(ends.iter().all(|[taken, refused]| *taken > 300 && *refused > 100));
}

#[test]
fn a_start_that_is_gone_on_from_gives_the_same_bits() {
    let ring = TorusByDistance { major: 1.0, minor: 0.3 };
    let scene = Scene::on(ring).with(Gravity { g: 1.0 }).bodies(40);
    let start = || together(&starts(ring, 40, 1.5));
    macro_rules! check {
        ($($method:expr),*) => {$({
            let mut whole = scene.simulate(start(), $method).unwrap();
            let mut first = scene.simulate(start(), $method).unwrap();
            whole.run(30).unwrap();
            first.run(10).unwrap();
            let mut rest = scene.simulate(first.state(), $method).unwrap();
            rest.run(20).unwrap();
            assert_eq!(bits(&rest.state()), bits(&whole.state()), "{}", stringify!($method));
        })*};
    }
    let h = 0.05; // long enough that some go one by one
    check!(
        Rattle::new(h),
        Rattle::new(h).guess(Extrapolated),
        Rattle::new(h).solved_by(Broyden),
        Composition::new(SUZUKI_1990_ORDER_4, h),
        Shake::new(h),
        Geodesic::new(2, h),
        Lobatto::<3>::new(h),
        Dop853::new(h)
    );
}

#[test]
fn who_rests_stays_at_rest() {
    fn check<C: Constraint<3, 1> + Copy>(surface: C) {
        for number in [7, 8, 64, 200] {
            let still: Vec<_> =
                starts(surface, number, 1.5).iter().map(|start| start.clone().moving([0.0; 3])).collect();
            let (scene, still) = (Scene::on(surface).bodies(number), together(&still));
            let mut simulation = scene.simulate(still.clone(), Rattle::new(0.02)).unwrap();
            simulation.run(10).unwrap();
            // A start may be some roundings off, and is put right: a way of 1e-16, of which momenta keep the rounding.
            let moved = simulation.positions().zip(still.positions()).map(|(a, b)| (a - b).amax());
            assert!(moved.fold(0.0, f64::max) < 1e-15);
            assert!(simulation.momenta().map(|p| p.amax()).fold(0.0, f64::max) < 1e-27);
            scene.simulate(simulation.state(), Rattle::new(0.02)).unwrap();
        }
    }
    check(rattle::surfaces::Sphere { r: 1.0 });
    check(TorusByDistance { major: 1.0, minor: 0.3 });
    check(SURFACE);
    check(Gyroid { k: 1.0, epsilon: 0.1 });
}

#[test]
fn rounding_does_not_add_up() {
    // Great circles: RATTLE keeps their energy, and what is left is rounding, of compensated sums.
    let sphere = rattle::surfaces::Sphere { r: 1.3 };
    let starts: Vec<_> = starts(sphere, 64, 1.0).iter().map(unit_speed).collect();
    let mut many = Scene::on(sphere).bodies(64).simulate(together(&starts), Rattle::new(0.02)).unwrap();
    let mut worst = 0.0_f64;
    many.run_with(8_000, |now| worst = worst.max((now.energy_error() / 32.0).abs())).unwrap();
    println!("energy off by {worst:e}");
    assert!(worst < 2e-15, "{worst:e}");
    assert!(many.constraint_residual() < 1e-15);
}

fn unit_speed(start: &State<3>) -> State<3> {
    let (q, p) = (start.positions().next().unwrap(), start.momenta().next().unwrap());
    State::at(q).moving(p.normalize())
}

#[test]
fn a_force_that_stops_being_a_number_is_told_with_the_particle() {
    potential! {
        struct Edge {}
        |x, y, z| (0.9 - x)^(3/2)
    }
    let scene = Scene::on(rattle::surfaces::Sphere { r: 1.0 }).with(Edge {}).bodies(70);
    // Particle 67 goes over the edge.
    let starts = State::of((0..70).map(|_| [0.6, 0.8, 0.0]));
    let starts = starts.with_momenta((0..70).map(|i| if i == 67 { [4.0, -3.0, 0.0] } else { [0.0; 3] }));
    let mut simulation = scene.simulate(starts, Rattle::new(0.01)).unwrap();
    let (before, error) = loop {
        let before = bits(&simulation.state());
        if let Err(error) = simulation.step() {
            break (before, error);
        }
    };
    let Error::Step {
        body: 67,
        cause: StepFailure::Effect(EffectFailure::ForceNotFinite { effect: "Edge", .. }),
        ..
    } = error
    else {
        panic!("{error}")
    };
    assert_eq!(bits(&simulation.state()), before);
}
