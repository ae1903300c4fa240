//! First guesses: the same motion whichever is made, and what each costs.

use crate::common::*;
use rattle::Counted;
use rattle::links::planar::Rod;
use rattle::prelude::*;

/// The largest difference of positions after so many steps by two methods.
fn apart<A: Method, B: Method>(one: A, other: B, steps: u64) -> f64 {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let mut one = scene.simulate(billiard_45(), one).unwrap();
    let mut other = scene.simulate(billiard_45(), other).unwrap();
    one.run(steps).unwrap();
    other.run(steps).unwrap();
    distance(one.position(), other.position())
}

#[test]
fn extrapolated_guesses_give_the_same_motion() {
    // Until t = 1, where a rounding has grown tenfold; goldens agree to 1e-15 as well.
    assert!(apart(Lobatto::<3>::new(0.01), Lobatto::<3>::new(0.01).guess(Extrapolated), 100) <= 2e-15);
    assert!(apart(Lobatto::<5>::new(0.02), Lobatto::<5>::new(0.02).guess(Extrapolated), 50) <= 2e-15);
    assert!(apart(Rattle::new(0.01), Rattle::new(0.01).guess(Extrapolated), 100) <= 2e-15);
    assert!(apart(Lobatto::<9>::new(0.05), Lobatto::<9>::new(0.05).guess(Extrapolated), 20) <= 2e-15);
    let (linked, start) = double();
    let mut pure = linked.simulate(start.clone(), Lobatto::<5>::new(0.02)).unwrap();
    let mut extrapolated = linked.simulate(start, Lobatto::<5>::new(0.02).guess(Extrapolated)).unwrap();
    pure.run(50).unwrap();
    extrapolated.run(50).unwrap();
    let apart =
        pure.positions().zip(extrapolated.positions()).map(|(a, b)| distance(a, b)).fold(0.0, f64::max);
    assert!(apart <= 2e-15, "{apart:e}");
}

type Rods<E> = Scene<rattle::network::Network<2>, E, rattle::bodies::Many, 2>;

fn double() -> (Rods<impl rattle::effect::Effects<2> + Clone>, State<2>) {
    let scene = Scene::points(3).link(Rod { length: 1.0 }, [[0, 1], [1, 2]]).pin(0, [0.0, 0.0]);
    (scene.with(PlanarGravity { g: 1.0 }), State::of([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]))
}

/// Evaluations of g, ∇g and second derivatives per step, until t = 5 at θ = 45°.
fn evaluations<S: Method>(method: S) -> [f64; 3] {
    let surface = Counted::new(SURFACE);
    let counts = surface.counts();
    let steps = (5.0 / method.step_size()).round() as u64;
    let mut simulation = Scene::on(surface).with(Gravity { g: 1.0 }).simulate(billiard_45(), method).unwrap();
    counts.reset();
    simulation.run(steps).unwrap();
    [counts.values(), counts.gradients(), counts.curvatures()].map(|count| count as f64 / steps as f64)
}

#[test]
fn extrapolated_stages_take_fewer_iterations() {
    for (h, most) in [(0.02, 0.87), (0.01, 0.83), (0.005, 0.79)] {
        let [pure, ..] = evaluations(Lobatto::<5>::new(h));
        let [extrapolated, ..] = evaluations(Lobatto::<5>::new(h).guess(Extrapolated));
        println!("h = {h}: {pure:.2} evaluations of g per step, extrapolated {extrapolated:.2}");
        // 18 for iterations that end below half a rounding, 2 inside the step, 1 with the gradient where it ends, and a
        // look for other sheets or an acceleration.
        assert!(pure <= 22.5, "h = {h}: {pure}");
        assert!(extrapolated <= most * pure, "h = {h}: {extrapolated} of {pure}");
    }
}

#[test]
fn extrapolated_multipliers_take_few_evaluations_and_no_second_derivative() {
    let (mut total, mut steps) = ([0.0; 3], 0.0);
    for theta in directions() {
        let surface = Counted::new(SURFACE);
        let counts = surface.counts();
        let method = Rattle::new(0.01).guess(Extrapolated);
        let mut simulation =
            Scene::on(surface).with(Gravity { g: 1.0 }).simulate(billiard(theta), method).unwrap();
        counts.reset();
        simulation.run(2000).unwrap();
        let found = [counts.values(), counts.gradients(), counts.curvatures()];
        total = std::array::from_fn(|i| total[i] + found[i] as f64);
        steps += 2000.0;
    }
    let [values, gradients, curvatures] = total.map(|count| count / steps);
    println!("{values:.3} evaluations of g, {gradients:.3} of ∇g, {curvatures:.3} of vᵀ∇²g v per step");
    assert!((2.0..=2.4).contains(&values) && (2.0..=2.1).contains(&gradients) && curvatures <= 0.12);
}

/// Where multipliers change from step to step by more than a guess can follow, steps are those without one.
#[test]
fn guesses_that_mislead_are_not_followed() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    for theta in [0.3, 0.7, 1.2] {
        let mut pure = scene.simulate(billiard(theta), Rattle::new(0.025)).unwrap();
        let mut extrapolated =
            scene.simulate(billiard(theta), Rattle::new(0.025).guess(Extrapolated)).unwrap();
        let mut last = scene.simulate(billiard(theta), Rattle::new(0.025).guess(LastMultiplier)).unwrap();
        for step in 0..160 {
            pure.step().unwrap();
            extrapolated.step().unwrap();
            last.step().unwrap();
            let apart = |other| distance(pure.position(), other);
            let apart = apart(extrapolated.position()).max(apart(last.position()));
            assert!(apart <= 1e-11, "θ = {theta}, step {step}: {apart:e}"); // until t = 4 roundings grow by 1e4
        }
    }
}

#[test]
fn a_restart_remembers_the_guess() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    restart(&scene, billiard(0.7), Rattle::new(0.02).guess(Extrapolated));
    restart(&scene, billiard(0.7), Rattle::new(0.02).guess(LastMultiplier));
    restart(
        &scene,
        billiard(0.7),
        Composition::of(SUZUKI_1990_ORDER_4, Rattle::new(0.02).guess(LastMultiplier)),
    );
    restart(&double().0, double().1, Rattle::new(0.02).guess(LastMultiplier));
    restart(&double().0, double().1, Rattle::new(0.02).guess(Extrapolated));
    let method = Lobatto::<5>::new(0.02).guess(Extrapolated);
    restart(&scene, billiard(0.7), method);
    let (linked, start) = double();
    restart(&linked, start, method);
}

fn restart<C, E, N, S, const D: usize>(scene: &Scene<C, E, N, D>, start: State<D>, method: S)
where
    C: rattle::scene::Hold<D>,
    E: rattle::effect::Effects<D>,
    N: rattle::bodies::Count,
    S: Method,
{
    let mut whole = scene.simulate(start, method.clone()).unwrap();
    whole.run(25).unwrap();
    let mut rest = scene.simulate(whole.state(), method.clone()).unwrap();
    let mut forgetful = scene.simulate(whole.state().with_momenta(whole.momenta()), method).unwrap(); // momenta given anew
    let allocated = allocation_counter::measure(|| whole.run(25).unwrap());
    assert_eq!(allocated.count_total, 0);
    rest.run(25).unwrap();
    forgetful.run(25).unwrap();
    assert_eq!(bits(&rest.state()), bits(&whole.state()));
    assert_ne!(
        bits(&forgetful.state()),
        bits(&whole.state()),
        "roundings tell whether stages were remembered"
    );
}

/// Where a guess is given up, the step is begun again as without one: of 200 such runs 3 end at a step without a
/// solution, and 1 of those without a memory.
#[test]
#[cfg(long)]
fn long_steps_survive_bad_guesses() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let lost = (0..14).filter(|&k| {
        let start = billiard(std::f64::consts::FRAC_PI_4 + 1e-13 * f64::from(k));
        scene.simulate(start, Lobatto::<5>::new(0.1).guess(Extrapolated)).unwrap().run(2000).is_err()
    });
    let lost = lost.count();
    assert!(lost <= 1, "{lost} of 14");
}
