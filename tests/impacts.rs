//! Impacts where constraints move, or act along other directions than their gradients: the gap parts with e times the
//! speed at which it closed, and the energy changes by the work that is booked.

use rattle::Error;
use rattle::effect::{HardSpheres, Stop};
use rattle::error::StepFailure;
use rattle::potentials::Gravity;
use rattle::prelude::*;
use rattle::system::System;
use rattle::watch::{Each, Observer};

constraint! {
    /// A piston on a line.
    struct Piston { u }
    |x, t| x - u * t
}

constraint! {
    /// A rod that rises, at 45°.
    struct Rising { w }
    |x, y, t| x + y - w * t
}

constraint! {
    /// A table whose height is twice x.
    struct Twice {}
    |x, _y, z| z - 2 * x
}

constraint! {
    /// To the left of x = 1.
    struct Wall {}
    |x, _y| 1 - x
}

constraint! {
    /// On this side of a slanted wall.
    struct Slanted {}
    |x, y, _z| 1 - x - y
}

constraint! {
    /// Below a ceiling.
    struct Ceiling {}
    |_x, _y, z| 1 - z
}

constraint! {
    /// To the right of a wall far to the left.
    struct Far {}
    |x| x + 1000
}

constraint! {
    /// To the right of a wall.
    struct Left {}
    |x| x
}

constraint! {
    /// To the right of a wall at x = -1/2.
    struct Half {}
    |x, _y, _z| x + 1/2
}

constraint! {
    /// Above a floor that is out of reach.
    struct Low {}
    |_x, _y, z| z + 10
}

constraint! {
    /// Above the floor.
    struct Ground {}
    |_x, _y, z| z
}

fn near(found: &[f64], exact: &[f64]) {
    let off = found.iter().zip(exact).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
    assert!(off < 1e-13, "{found:?} for {exact:?}");
}

/// A ball that meets a piston of speed u with the velocity v leaves it with u + e (u − v), and no recoil.
#[test]
fn a_piston_drives_a_ball() {
    for (u, v, e, h) in
        [(0.3, -1.0, 1.0, 0.1), (1.0, 0.0, 1.0, 0.03), (-0.2, -1.5, 0.5, 0.1), (0.4, 0.1, 0.0, 0.07)]
    {
        let scene = Scene::points::<1>(2).link_moving(Piston { u }, [[0]]);
        let start = State::of([[0.0], [1.0]]).with_momenta([[u], [v]]);
        let balls = HardSpheres::new(0.5).restitution(e);
        let mut simulation = scene.simulate(start, Rattle::new(h)).unwrap().collide(balls).unwrap();
        simulation.run((0.5 / (u - v) / h) as u64 + 3).unwrap();
        let (after, state) = (u + e * (u - v), simulation.state());
        let momenta: Vec<f64> = state.momenta().map(|p| p.x).collect();
        near(&momenta, &[u, after]);
        near(&[simulation.work(), simulation.energy_error()], &[0.5 * (after * after - v * v), 0.0]);
    }
}

/// What moves along the rod is turned so that x̊ is.
#[test]
fn a_bead_on_a_rod_that_rises_meets_a_wall() {
    for (w, s, e) in [(1.0, 1.0, 1.0), (0.1, 1.0, 1.0), (-0.5, 1.2, 1.0), (1.0, 0.0, 1.0), (1.0, 1.0, 0.5)] {
        let part = s * 0.5_f64.sqrt();
        let v = [0.5 * w + part, 0.5 * w - part];
        let scene = Scene::point().link_moving(Rising { w }, [[0]]);
        let start = State::at([0.0, 0.0]).moving(v);
        let mut simulation = scene
            .simulate(start, Rattle::new(0.01))
            .unwrap()
            .collide(Stop::above(Wall {}).over([[0]]).restitution(e))
            .unwrap();
        simulation.run((100.0 / v[0]) as u64 + 20).unwrap();
        let (x, y) = (-e * v[0], w + e * v[0]);
        let p = simulation.momentum();
        near(&[p.x, p.y], &[x, y]);
        let work = 0.5 * (x * x + y * y - v[0] * v[0] - v[1] * v[1]);
        near(&[simulation.work(), simulation.energy_error()], &[work, 0.0]);
        assert_eq!(simulation.events(), 1);
    }
}

/// The height follows x without holding it: in x and y the body is free.
#[test]
fn who_is_led_along_meets_a_wall_as_if_free() {
    for (e, after) in [(1.0, [0.0, -1.0, 0.0]), (0.0, [0.5, -0.5, 1.0]), (0.5, [0.25, -0.75, 0.5])] {
        let scene = Scene::point().link_acting(Twice {}, [[0]], [[false, false, true]]);
        let start = State::at([0.0, 0.0, 0.0]).moving([1.0, 0.0, 2.0]);
        let mut simulation = scene
            .simulate(start, Rattle::new(0.3))
            .unwrap()
            .collide(Stop::above(Slanted {}).over([[0]]).restitution(e))
            .unwrap();
        simulation.run(6).unwrap();
        let p = simulation.momentum();
        near(&[p.x, p.y, p.z], &after);
        let work = 0.5 * (after.iter().map(|v| v * v).sum::<f64>() - 5.0);
        near(&[simulation.work(), simulation.energy_error()], &[work, 0.0]);
    }
}

/// A ceiling cannot keep what is led there.
#[test]
fn who_cannot_part_is_told() {
    let scene = Scene::point().link_acting(Twice {}, [[0]], [[false, false, true]]);
    let start = State::at([0.0, 0.0, 0.0]).moving([1.0, 0.0, 2.0]);
    let mut simulation =
        scene.simulate(start, Rattle::new(0.3)).unwrap().collide(Stop::above(Ceiling {})).unwrap();
    let error = simulation.run(6).unwrap_err();
    assert!(matches!(&error, Error::Step { cause: StepFailure::NoWayApart { .. }, step: 2, .. }), "{error}");
}

constraint! {
    /// The floor.
    struct Floor {}
    |_x, _y, z| z
}

/// A ball that falls from 1/2 meets the floor at t = 1, 3, 5, … It is at z on the way down √(1 − 2 z) after its highest
/// point, at t = 0, 2, 4, … Parabolas leave nothing but rounding, whatever lies between two sights.
#[test]
fn sections_end_at_impacts_and_begin_anew() {
    const Z: f64 = 0.02;
    let fall = (1.0 - 2.0 * Z).sqrt();
    for (h, every) in [(0.1, 1), (0.07, 1), (0.07, 3), (0.1, 7), (0.08, 25), (-0.07, 3)] {
        let scene = Scene::point().with(Gravity { g: 1.0 });
        let start = State::at([0.0, 0.0, 0.5]).moving([0.3, 0.0, 0.0]);
        let simulation = scene.simulate(start, Rattle::new(h)).unwrap();
        let mut simulation = simulation.collide(Stop::above(Floor {})).unwrap();
        let below = Section::of(|now: &Sight<'_, 3>| Z - now.position().z);
        let up = Section::of(|now: &Sight<'_, 3>| now.step_size().signum() * now.momentum().z);
        let mut sections = (below, Each::of(|| up.clone()));
        simulation.observe((10.0 / h).abs() as u64 / every * every, every, &mut sections).unwrap();
        let end = simulation.time().abs();
        let (below, up) = (sections.0, sections.1.get(0).unwrap());
        let times = |first: f64| (0..5).map(move |n| first + f64::from(2 * n)).filter(|&time| time < end);
        let expected: Vec<f64> = times(fall).collect();
        assert!(expected.len() > 3, "{h} {every}");
        let found: Vec<f64> = below.crossings().iter().map(|crossing| crossing.time.abs()).collect();
        assert_eq!(found.len(), expected.len(), "{h} {every}: {found:?}");
        near(&found, &expected);
        for crossing in below.crossings() {
            let sign = h.signum();
            near(&[crossing.positions[0].z, sign * crossing.momenta[0].z], &[Z, -fall]);
            near(&[crossing.positions[0].x], &[0.3 * crossing.time]);
        }
        let expected: Vec<f64> = times(1.0).collect();
        let found: Vec<f64> = up.crossings().iter().map(|crossing| crossing.time.abs()).collect();
        assert_eq!(found.len(), expected.len(), "{h} {every}: {found:?}");
        near(&found, &expected);
        up.crossings().iter().for_each(|crossing| near(&[crossing.momenta[0].z], &[h.signum()]));
    }
}

constraint! {
    /// Two planes that meet in a ridge at x = 0.
    struct Roof {}
    |x, _y, z| z + abs(x)
}

/// Up to the ridge at t = 1 and down behind it: just before the ridge the path passes a height that it has lost again
/// by the end of the step.
#[test]
fn sections_end_at_edges_and_begin_anew() {
    for (h, every) in [(0.03, 1), (0.03, 20), (0.4, 1)] {
        let start = State::at([-1.0, 0.0, -1.0]).moving([1.0, 0.5, 1.0]);
        let simulation = Scene::on(Roof {}).simulate(start, Rattle::new(h)).unwrap();
        let mut simulation = simulation.over_kinks().unwrap();
        let mut section = Section::of(|now: &Sight<'_, 3>| now.position().z + 0.005);
        simulation.observe((2.0 / h) as u64, every, &mut section).unwrap();
        let [crossing] = section.crossings() else { panic!("one crossing: {:?}", section.crossings()) };
        near(&[crossing.time, crossing.momenta[0].z, crossing.positions[0].y], &[0.995, 1.0, 0.4975]);
    }
}

/// A run that has failed after an impact leaves nothing behind: the next one begins at its own start, which is later.
#[test]
fn sections_forget_the_jumps_of_a_run_that_failed() {
    let scene = Scene::point().with(Gravity { g: 1.0 });
    let simulation = scene.simulate(State::at([0.0, 0.0, 0.5]), Rattle::new(0.1)).unwrap();
    let simulation = simulation.collide(Stop::above(Floor {}).restitution(0.5)).unwrap();
    let mut known = simulation.clone();
    known.run(100).unwrap_err();
    let end = known.time();
    let mut section = Section::of(|now: &Sight<'_, 3>| now.time - end);
    let mut simulation = simulation;
    let error = simulation.observe(100, 100, &mut section).unwrap_err();
    assert!(matches!(error, Error::Step { cause: StepFailure::Rests { .. }, .. }), "{error}");
    assert!(simulation.events() > 2 && section.crossings().is_empty());
    let mut free = scene.simulate(simulation.state(), Rattle::new(0.1)).unwrap();
    free.observe(1, 1, &mut section).unwrap();
    assert!(section.crossings().is_empty(), "{:?}", section.crossings());
}

/// A ball's energy by differences of its places, which begin anew after each bounce.
#[test]
fn shadow_energies_begin_anew_after_impacts() {
    let scene = Scene::point().with(Gravity { g: 1.0 });
    let ball = scene.simulate(State::at([0.0, 0.0, 0.5]), Rattle::new(0.013)).unwrap();
    let mut ball = ball.collide(Stop::above(Floor {})).unwrap();
    let mut shadow = ShadowEnergy::new(4).unwrap();
    ball.observe(300, 1, &mut shadow).unwrap(); // bounces at t = 1 and 3
    assert_eq!(shadow.values().len(), 300 + 1 - 3 * 4); // three flights, each without its ends
    // Differences of second order leave h² g²/24 beside U + p²/2 of Verlet; roundings are divided by h².
    let expected = shadow.values()[0];
    assert!((expected - 0.5).abs() < 1e-4 && shadow.values().iter().all(|e| (e - expected).abs() < 1e-11));
}

/// Elastic impacts leave nothing at rest: where a step has too many, a shorter one has fewer. Two masses of 1 and 10⁶
/// and a wall count digits of π, 3141 impacts.
#[test]
fn a_step_of_too_many_impacts_says_so() {
    let scene = Scene::points::<1>(2).masses([1.0, 1e6]);
    let start = || State::of([[2.0], [4.0]]).with_momenta([[0.0], [-1e6]]);
    let billiard = |h: f64| {
        let simulation = scene.simulate(start(), Rattle::new(h)).unwrap();
        let simulation = simulation.collide(HardSpheres::new(1.0)).unwrap();
        simulation.collide(Stop::above(Left {})).unwrap()
    };
    let error = billiard(7.3).step().unwrap_err().to_string();
    assert!(error.contains("2000 impacts") && error.contains("shorter step"), "{error}");
    assert!(!error.contains("rest"), "{error}");
    let mut shorter = billiard(7.3 / 4096.0);
    shorter.run(4096).unwrap();
    assert_eq!(shorter.events(), 3141);
    // A soft wall that is out of reach has no part in them.
    let soft = billiard(7.3).collide(Stop::above(Far {}).restitution(0.5)).unwrap().step().unwrap_err();
    assert!(matches!(soft, Error::Step { cause: StepFailure::TooManyImpacts { .. }, .. }), "{soft}");
    // What bounces lower and lower may come to rest within the step.
    let scene = Scene::point().with(Gravity { g: 1.0 });
    let ball = scene.simulate(State::at([0.0, 0.0, 0.5]), Rattle::new(100.0)).unwrap();
    let error =
        ball.collide(Stop::above(Ground {}).restitution(0.7)).unwrap().step().unwrap_err().to_string();
    println!("{error}");
    assert!(error.contains("shorter step") && error.contains("held by a link"), "{error}");
}

/// In steps so long that bodies go a third farther than the speeds at their ends tell, they do not pass through each
/// other, head on.
#[test]
fn long_steps_do_not_lead_through() {
    let sphere = Scene::on(rattle::surfaces::Sphere { r: 1.0 }).bodies(2);
    let mut met = 0;
    for h in [0.3_f64, 0.8, 0.9, 0.95] {
        for i in 0..100 {
            let at = |a: f64, v: f64| ([a.cos(), a.sin(), 0.0], [-a.sin() * v, a.cos() * v, 0.0]);
            let [(q, p), (r, s)] = [at(0.0, 1.0), at(0.2 + 0.02 * f64::from(i), -1.0)];
            let start = State::of([q, r]).with_momenta([p, s]);
            let balls = sphere.simulate(start, Rattle::new(h)).unwrap();
            let mut balls = balls.collide(HardSpheres::new(0.05)).unwrap();
            balls.step().unwrap();
            // Each goes at least h, at most arcsin h, and they meet at a distance of 0.05.
            let gap = 0.2 + 0.02 * f64::from(i) - 2.0 * (0.025_f64).asin();
            let most = if 2.0 * h.asin() > gap { 1 } else { 0 };
            let least = if 2.0 * h > gap { 1 } else { 0 };
            assert!((least..=most).contains(&balls.events()), "h = {h}, {i}: {}", balls.events());
            met += balls.events();
        }
    }
    assert!(met > 250, "{met}");
}

/// Cosine and a wall: contacts at 2π/3 and every 4π/3 from there on, however long steps are, for bodies that come back
/// within a step to where they were, too.
#[test]
fn contacts_of_a_whole_round_within_a_step_are_met() {
    use rattle::potentials::Harmonic;
    const FULL: f64 = 2.0 * std::f64::consts::PI;
    let scene = Scene::point().with(Harmonic { stiffness: 1.0, centre: [0.0; 3] });
    fn meets<S: Method>(h: f64, simulation: Result<Simulation<impl System<f64, 3>, S, 3>, Error>) -> u64 {
        let mut simulation = simulation.unwrap().collide(Stop::above(Half {})).unwrap();
        simulation.run((40.0 / h) as u64).unwrap();
        let exact = ((simulation.time() - FULL / 3.0) / (2.0 * FULL / 3.0)).floor() as u64 + 1;
        assert!(simulation.energy_error().abs() < 1e-6, "{}", simulation.energy_error());
        assert_eq!(simulation.events(), exact, "h = {h}");
        exact
    }
    let start = || State::at([1.0, 0.0, 0.0]);
    let mut met = 0;
    for h in [0.1, 0.5, 2.0, 4.9, 5.0, 6.0, FULL, 8.1, 9.0, 2.0 * FULL, 13.0] {
        met += meets(h, scene.simulate(start(), Dop853::adaptive(h, 1e-10)));
        met += meets(h, scene.simulate(start(), Taylor::adaptive(20, h, 1e-15)));
    }
    assert!(met > 2 * 11 * 7, "{met}");
}

/// Two beads on a circle: who comes round hits the other, which goes on with the same speed.
#[test]
fn beads_that_go_round_within_a_step_meet() {
    let sphere = Scene::on(rattle::surfaces::Sphere { r: 1.0 }).bodies(2);
    let start = || State::of([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]).with_momenta([[0.0, 1.0, 0.0], [0.0; 3]]);
    // They touch at this angle, and the gaps on both sides add up to 2π less two of these.
    let touch = 2.0 * (0.25_f64).asin();
    let exact = |time: f64| {
        ((time - (std::f64::consts::PI - touch)) / (2.0 * (std::f64::consts::PI - touch))).floor() as u64 + 1
    };
    for h in [0.7, 4.0, 5.0, 7.0, 9.0] {
        let balls = sphere.simulate(start(), Dop853::adaptive(h, 1e-10)).unwrap();
        let mut balls = balls.collide(HardSpheres::new(0.5)).unwrap();
        balls.run((50.0 / h) as u64).unwrap();
        assert_eq!(balls.events(), exact(balls.time()), "h = {h}");
        let balls = sphere.simulate(start(), Geodesic::new(40, h)).unwrap();
        let mut balls = balls.collide(HardSpheres::new(0.5)).unwrap();
        balls.run((50.0 / h) as u64).unwrap();
        assert_eq!(balls.events(), exact(balls.time()), "Geodesic, h = {h}");
    }
}

/// Where walls are out of reach, looking for them changes no bit, nor what observers hear.
#[test]
fn walls_out_of_reach_change_nothing_in_long_steps() {
    #[derive(Default, Debug, PartialEq, Clone)]
    struct Heard(Vec<u64>);
    impl Observer<3> for Heard {
        fn see(&mut self, _: &Sight<'_, 3>, now: &Sight<'_, 3>) {
            self.0.extend(now.positions[0].iter().map(|x| x.to_bits()));
        }
        fn join(&mut self, _: Self) {}
        fn position_multiplier(&mut self, _: usize, lambda: f64) {
            self.0.push(lambda.to_bits());
        }
    }
    fn alike<S: Method>(method: S) {
        let scene = Scene::on(rattle::surfaces::Sphere { r: 1.0 }).with(Gravity { g: 0.3 });
        let start = || State::at([1.0, 0.0, 0.0]).moving([0.0, 0.8, 0.6]);
        let simulation = || scene.simulate(start(), method.clone()).unwrap();
        let (mut free, mut walled) = (simulation(), simulation().collide(Stop::above(Low {})).unwrap());
        let [mut a, mut b] = [(); 2].map(|()| Heard::default());
        free.observe(20, 1, &mut a).unwrap();
        walled.observe(20, 1, &mut b).unwrap();
        assert_eq!(a, b, "{}", method.name());
    }
    alike(Dop853::adaptive(5.0, 1e-10));
    alike(Taylor::adaptive(20, 5.0, 1e-12));
    alike(Lobatto::<5>::new(0.7));
    alike(Geodesic::new(20, 0.9));
    alike(Bdf2::new(0.2));
    alike(Composition::new(SUZUKI_1990_ORDER_4, 0.6));
}

/// Series of high order take steps of more than two periods.
#[test]
fn steps_of_several_periods_are_looked_at() {
    use rattle::potentials::Harmonic;
    const ROUND: f64 = 4.0 * std::f64::consts::PI / 3.0;
    let scene = Scene::point().with(Harmonic { stiffness: 1.0, centre: [0.0; 3] });
    let simulation = scene.simulate(State::at([1.0, 0.0, 0.0]), Taylor::adaptive(64, 15.5, 1e-15)).unwrap();
    let mut simulation = simulation.collide(Stop::above(Half {})).unwrap();
    simulation.run(400).unwrap();
    let exact = ((simulation.time() - 0.5 * ROUND) / ROUND).floor() as u64 + 1;
    assert_eq!(simulation.events(), exact);
}

/// Two balls on a spring meet as often where all of it flies.
#[test]
fn what_flies_together_meets_as_at_rest() {
    pair_potential! {
        struct Tie { k }
        |r| k * (r - 2)^2 / 2
    }
    let scene = Scene::points::<3>(2).with(Tie { k: 0.5 });
    let events = [0.0, 100.0].map(|v| {
        let start = State::of([[0.0; 3], [3.0, 0.0, 0.0]]).with_momenta([[v, 0.1, 0.0], [v, -0.1, 0.0]]);
        let balls = scene.simulate(start, Dop853::adaptive(4.5, 1e-6)).unwrap();
        let mut balls = balls.collide(HardSpheres::new(1.2)).unwrap();
        balls.run(20).unwrap();
        balls.events()
    });
    assert!(events[0] > 15 && events[0] == events[1], "{events:?}");
}

/// Walls before an edge within the same step are met first.
#[test]
fn walls_before_an_edge_are_met() {
    constraint! {
        struct Roof {}
        |x, _y, z| z + abs(x)
    }
    constraint! {
        struct Side {}
        |_x, y, _z| y + 1/2
    }
    potential! {
        struct Bowl {}
        |x, y, z| (x^2 + 16 * y^2 + z^2) / 2
    }
    let scene = Scene::on(Roof {}).with(Bowl {});
    // x = −cos t is over the ridge at π/2, when y = cos 4t would be back from its first turn beyond the wall.
    let mut events = [5.0, 0.05].map(|h| {
        let start = State::at([-1.0, 1.0, -1.0]).moving([0.0; 3]);
        let ball = scene.simulate(start, Dop853::adaptive(h, 1e-12)).unwrap().over_kinks().unwrap();
        let mut ball = ball.collide(Stop::above(Side {})).unwrap();
        ball.run((20.0 / h).round() as u64).unwrap();
        (ball.events(), ball.position())
    });
    let [(long, p), (short, q)] = &mut events;
    assert!(*long > 8 && long == short && (*p - *q).norm() < 1e-9, "{long} {short} {p} {q}");
}

/// What an impact loses is not found again where time runs back.
#[test]
fn impacts_that_lose_energy_have_no_way_back() {
    let floor = rattle::surfaces::Plane { a: 0.0, b: 0.0, c: 1.0, d: 0.0 };
    let ball = |restitution: f64| {
        let scene = Scene::point().with(Gravity { g: 1.0 });
        let back = scene.simulate(State::at([0.0, 0.0, 0.5]), Rattle::new(-0.01)).unwrap();
        back.collide(Stop::above(floor).restitution(restitution))
    };
    let error = ball(0.5).unwrap_err();
    assert!(matches!(error, Error::NoEvents { .. }) && error.to_string().contains("back in time"), "{error}");
    let mut elastic = ball(1.0).unwrap();
    elastic.run(100).unwrap();
    assert_eq!(elastic.events(), 1);
}

/// An average over time of a speed that an impact turns round is right to rounding, wherever in a step that is.
#[test]
fn averages_over_time_go_to_an_impact_and_from_there() {
    let scene = Scene::point();
    for h in [0.3, 0.25] {
        let start = State::at([0.5]).moving([-1.0]);
        let mut run = scene.simulate(start, Rattle::new(h)).unwrap().collide(Stop::above(Left {})).unwrap();
        let mut mean = Mean::over_time(|now: &Sight<'_, 1>| now.momenta[0].x);
        run.observe(4, 1, &mut mean).unwrap();
        let exact = (run.position().x - 0.5) / run.time();
        assert_eq!(run.events(), 1);
        assert!((mean.mean() - exact).abs() < 1e-14, "{} for {exact}", mean.mean());
    }
}

/// So it is with several impacts between two sights, and within one step.
#[test]
fn averages_over_time_go_from_impact_to_impact() {
    constraint! {
        struct Right {}
        |x| 1 - x
    }
    // 20 steps are a period from wall to wall; in a step of 0.8 some meet both walls.
    for (h, steps, every) in [(0.1, 20, 20), (0.1, 60, 7), (0.8, 10, 1)] {
        let run = Scene::point().simulate(State::at([0.5]).moving([1.7]), Rattle::new(h)).unwrap();
        let mut run = run.collide(Stop::above(Left {})).unwrap().collide(Stop::above(Right {})).unwrap();
        let mut mean = Mean::over_time(|now: &Sight<'_, 1>| now.momenta[0].x);
        run.observe(steps, every, &mut mean).unwrap();
        let seen = h * (steps - steps % every) as f64;
        let place = (0.5 + 1.7 * seen).rem_euclid(2.0);
        let exact = (if place > 1.0 { 2.0 - place } else { place } - 0.5) / seen;
        assert!(run.events() > 1);
        assert!((mean.mean() - exact).abs() < 1e-13, "{h} {every}: {} for {exact}", mean.mean());
    }
}

/// A force that changes with time and is zero takes no digits from an impact of a heavy body, nor makes work.
#[test]
fn impacts_under_forces_of_time_are_as_those_without() {
    constraint! {
        struct Wall {}
        |x, y| 0.6 * x + 0.8 * y
    }
    potential! {
        struct Field { a }
        |x, _y, t| -a * cos(t) * x
    }
    let scene = Scene::point().mass(1e15);
    let start = || State::at([1.0, 1.0]).moving([-0.723e15, -0.7223e15]);
    let mut plain = scene.clone().simulate(start(), Rattle::new(0.01)).unwrap();
    plain = plain.collide(Stop::above(Wall {})).unwrap();
    let mut field = scene.with(Field { a: 0.0 }).simulate(start(), Rattle::new(0.01)).unwrap();
    field = field.collide(Stop::above(Wall {})).unwrap();
    plain.run(200).unwrap();
    field.run(200).unwrap();
    assert_eq!((plain.events(), field.events(), field.work()), (1, 1, 0.0));
    let off = (plain.momentum() - field.momentum()).norm() / plain.momentum().norm();
    assert!(off < 1e-15, "{off:e}");
}

/// On a piston that moves an impact is the same in any unit of mass.
#[test]
fn impacts_on_what_moves_know_no_unit_of_mass() {
    constraint! {
        struct Slope {}
        |x, y| 0.6 * x + 0.8 * y
    }
    constraint! {
        /// Drags the body along x.
        struct Belt { u }
        |x, _y, t| x - 1 + u * t
    }
    let ends = [1.0, 1e15].map(|mass| {
        let scene = Scene::points(1).link_moving(Belt { u: 1.0 }, [[0]]).masses([mass]);
        let start = State::of([[1.0, 1.0]]).with_momenta([[-mass, -0.7 * mass]]);
        let run = scene.simulate(start, Rattle::new(0.01)).unwrap();
        let mut run = run.collide(Stop::above(Slope {})).unwrap();
        run.run(200).unwrap();
        assert_eq!(run.events(), 1);
        (run.positions().next().unwrap(), run.momenta().next().unwrap() / mass)
    });
    let off = (ends[0].0 - ends[1].0).norm() + (ends[0].1 - ends[1].1).norm();
    assert!(off < 1e-12, "{off:e}: {ends:?}");
}
