//! Rain and inflow that change with time: what falls is what was asked for, and runs end.

mod common;

use common::around;
use rattle_flow::{Flow, FlowError, Mesh, Method, Resistance, Simulation, dam_break};

/// A method that may try so many steps, and then is a failure of the test: what never ends is seen without a clock.
fn counted(flow: &Flow, mut left: usize) -> impl Method + use<> {
    around(flow, move |step, guess, make| {
        assert!(left > 0, "too many steps were tried, the last of length {step:e}");
        left -= 1;
        make(guess)
    })
}

/// A method whose depths are up and down by a millionth from step to step, however short.
fn noisy(flow: &Flow) -> impl Method + use<> {
    let mut up = false;
    around(flow, move |_, guess, make| {
        let info = make(guess)?;
        up = !up;
        let factor = if up { 1.0 + 1e-6 } else { 1.0 - 1e-6 };
        guess.iter_mut().for_each(|h| *h *= factor);
        Ok(info)
    })
}

/// A hillside of 100 by 20, dry, that leaks at its foot. Rain and so on are `with` it.
fn hillside(with: impl FnOnce(Flow) -> Flow, step: f64, left: usize) -> Simulation<impl Method> {
    let mesh = Mesh::polygon(&[[0.0, 0.0], [100.0, 0.0], [100.0, 20.0], [0.0, 20.0]], 5.0).unwrap();
    let dry = vec![0.0; mesh.points().len()];
    let flow = Flow::over(mesh, Resistance::Manning)
        .terrain(|[x, _]| 0.05 * x)
        .friction(|_| 0.05)
        .outlet(0.05, |[x, _]| x < 1e-6);
    with(flow).simulate_by(dry, step, |flow| counted(flow, left)).unwrap()
}

const AREA: f64 = 2000.0;
const RATE: f64 = 1e-5;

/// Rain from one time to another.
fn shower(from: f64, to: f64) -> impl Fn([f64; 2], f64) -> f64 + Send + Sync + 'static {
    move |_, t| if (from..to).contains(&t) { RATE } else { 0.0 }
}

/// The books close, and have so much rain.
fn check(simulation: &Simulation<impl Method>, rain: f64, most: f64) {
    let budget = simulation.budget();
    assert!(simulation.depth().iter().all(|&h| h >= 0.0));
    assert!(budget.remainder().abs() < 1e-13 * rain, "{budget:?}");
    assert!((budget.rain - rain).abs() <= most, "{} of {rain}, {:e} off", budget.rain, budget.rain - rain);
}

#[test]
fn rain_that_begins_later_on_dry_ground_comes() {
    for (drink, tolerance) in
        [(0.0, 1e-2), (0.0, 1e-3), (0.3 * RATE, 1e-3), (0.9 * RATE, 1e-3), (2.0 * RATE, 1e-3)]
    {
        let with = |flow: Flow| flow.rain(shower(600.0, 1e9)).infiltration(move |_| drink);
        let mut simulation = hillside(with, 1.0, 2000);
        simulation.run_until(1800.0, tolerance, 60.0).unwrap();
        // One step goes over the beginning, with an error of the tolerance, of the water of some steps of 60.
        check(&simulation, 1200.0 * RATE * AREA, tolerance * 120.0 * RATE * AREA);
        let with = |flow: Flow| flow.rain(shower(600.0, 1e9)).infiltration(move |_| drink).meet([600.0]);
        let mut simulation = hillside(with, 1.0, 1000);
        simulation.run_until(1800.0, tolerance, 60.0).unwrap();
        check(&simulation, 1200.0 * RATE * AREA, 1e-12 * RATE * AREA * 1200.0);
    }
    // The same of inflow, from an edge of 20.
    let inflow =
        |flow: Flow| flow.inflow(|_, t| if t >= 600.0 { 1e-4 } else { 0.0 }, |[x, _]| x > 100.0 - 1e-6);
    let mut simulation = hillside(inflow, 1.0, 2000);
    simulation.run_until(1800.0, 1e-3, 60.0).unwrap();
    let exact = 1200.0 * 20.0 * 1e-4;
    assert!(
        (simulation.budget().inflow - exact).abs() < 1e-3 * 120.0 * 20.0 * 1e-4,
        "{:?}",
        simulation.budget()
    );
}

/// Jumps in the first or the last thousandth of a step, up to a millionth, are in it.
#[test]
fn a_jump_near_an_end_of_a_step_is_seen() {
    for off in [0.0009, 0.0005, 1e-5, 3e-6] {
        for (from, to) in [(0.0, 1.0 - off), (off, 9.0), (0.0, 1.0 + off), (1.0 - off, 9.0)] {
            let mut simulation = hillside(|flow| flow.rain(shower(from, to)), 1.0, 1000);
            simulation.run_until(2.0, 1e-6, 1.0).unwrap();
            // One step goes over it, with an error of the tolerance, of the water of two steps.
            check(&simulation, (to.min(2.0) - from) * RATE * AREA, 1e-6 * 2.0 * RATE * AREA);
        }
    }
}

/// At a time of 10¹², where the clock goes on by 10⁻⁴, what jumps at an end of a step still jumps there.
#[test]
fn a_jump_at_an_end_of_a_step_is_not_in_it_at_any_time() {
    for start in [1e3, 1e6, 1e9, 1e12] {
        for within in
            [|t: f64, from: f64, to: f64| (from..to).contains(&t), |t, from, to| from < t && t <= to]
        {
            let rain = move |_: [f64; 2], t: f64| if within(t, start, start + 1.0) { RATE } else { 0.0 };
            let mut simulation = hillside(|flow| flow.rain(rain), 1.0, 1000);
            let mut thrown = 0;
            for end in [start, start + 1.0, start + 2.0] {
                thrown +=
                    simulation.run_until(end, 1e-3, if end > start { 1.0 } else { f64::INFINITY }).unwrap();
            }
            assert_eq!((thrown, simulation.time()), (0, start + 2.0), "{start:e}");
            check(&simulation, RATE * AREA, 1e-13 * RATE * AREA);
        }
    }
}

/// Ten minutes of rain after an hour without: steps are as long as they like.
#[test]
fn a_storm_after_an_hour_is_seen() {
    for longest in [f64::INFINITY, 1200.0, 600.0, 300.0] {
        let mut simulation = hillside(|flow| flow.rain(shower(3600.0, 4200.0)), 1.0, 2000);
        simulation.run_until(7200.0, 1e-3, longest).unwrap();
        // Its end and its beginning: each at most the tolerance of all that fell, and rounding.
        check(&simulation, 600.0 * RATE * AREA, 2e-3 * 600.0 * RATE * AREA);
        let with = |flow: Flow| flow.rain(shower(3600.0, 4200.0)).meet([4200.0, 3600.0]);
        let mut simulation = hillside(with, 1.0, 2000);
        simulation.run_until(7200.0, 1e-3, longest).unwrap();
        check(&simulation, 600.0 * RATE * AREA, 1e-12 * 600.0 * RATE * AREA);
    }
}

/// A shower of a minute in a day: seen where `longest` is twice as long, or the times are named.
#[test]
fn a_short_shower_is_seen_if_it_is_named_or_steps_are_short() {
    for at in (0..12).map(|k| 40_000.0 + 37.0 * f64::from(k)) {
        let mut simulation = hillside(|flow| flow.rain(shower(at, at + 60.0)), 1.0, 4000);
        simulation.run_until(86_400.0, 1e-3, 120.0).unwrap();
        check(&simulation, 60.0 * RATE * AREA, 2e-3 * 120.0 * RATE * AREA);
        let with = |flow: Flow| flow.rain(shower(at, at + 60.0)).meet([at, at + 60.0]);
        let mut simulation = hillside(with, 1.0, 4000);
        simulation.run_until(86_400.0, 1e-3, f64::INFINITY).unwrap();
        check(&simulation, 60.0 * RATE * AREA, 1e-12 * 60.0 * RATE * AREA);
    }
}

/// Ground that drinks all that falls has no water that could tell of an error.
#[test]
fn rain_on_ground_that_drinks_is_booked() {
    for longest in [60.0, 600.0, f64::INFINITY] {
        let with = |flow: Flow| flow.rain(shower(0.0, 1800.0)).infiltration(|_| 2.0 * RATE);
        let mut simulation = hillside(with, 1.0, 1000);
        simulation.run_until(7200.0, 1e-3, longest).unwrap();
        check(&simulation, 1800.0 * RATE * AREA, 1e-3 * 1800.0 * RATE * AREA);
        assert!((simulation.budget().infiltration - simulation.budget().rain).abs() < 1e-12);
    }
}

/// As the ground drinks the last water, what is left says nothing about errors: 880 steps were thrown away here.
#[test]
fn ground_that_falls_dry_does_not_stop_the_run() {
    let with = |flow: Flow| flow.rain(shower(0.0, 1800.0)).infiltration(|_| 0.2 * RATE);
    let mut simulation = hillside(with, 1.0, 1000);
    let thrown = simulation.run_until(7200.0, 1e-3, 600.0).unwrap();
    println!("{} steps, and {thrown} thrown away", simulation.steps());
    assert!(thrown < 50 && simulation.steps() < 400, "{thrown} of {}", simulation.steps());
    assert!(simulation.volume() < 1e-6, "{}", simulation.volume());
    check(&simulation, 1800.0 * RATE * AREA, 2e-3 * 1800.0 * RATE * AREA);
}

/// Rates that are polynomials in time fall and enter to rounding, with steps of one length and chosen ones.
#[test]
fn rates_up_to_the_fifth_power_of_time_are_exact() {
    for power in 0..=5 {
        let rate = move |t: f64| (t / 60.0).powi(power);
        let integral = 60.0 / f64::from(power + 1);
        let with = |flow: Flow| {
            flow.rain(move |_, t| 1e-4 * rate(t))
                .inflow(move |_, t| 1e-3 * rate(t), |[x, _]| x > 100.0 - 1e-6)
        };
        for chosen in [false, true] {
            let mut simulation = hillside(with, 7.5, 1000);
            if chosen {
                simulation.run_until(60.0, 1e-3, 20.0).unwrap();
            } else {
                simulation.run(8).unwrap();
            }
            let (rain, inflow) = (1e-4 * AREA * integral, 1e-3 * 20.0 * integral);
            let budget = simulation.budget();
            assert!((budget.rain - rain).abs() < 1e-14 * 60.0 * 1e-4 * AREA, "t^{power}: {budget:?} {rain}");
            assert!(
                (budget.inflow - inflow).abs() < 1e-14 * 60.0 * 1e-3 * 20.0,
                "t^{power}: {budget:?} {inflow}"
            );
            assert!(budget.remainder().abs() < 1e-13 * rain, "{budget:?}");
        }
    }
}

/// Rain up to a minute falls for a minute, by `<=` and by `<`, though no step ends at 60 exactly by adding up 0.1.
#[test]
fn time_is_the_number_of_steps_times_their_length() {
    for step in [0.1, 0.2, 0.3, 1.0] {
        let up_to = |flow: Flow| flow.rain(|_, t| if t <= 60.0 { RATE } else { 0.0 });
        let below = |flow: Flow| flow.rain(|_, t| if t < 60.0 { RATE } else { 0.0 });
        let (mut one, mut other) = (hillside(up_to, step, 1000), hillside(below, step, 1000));
        let steps = (100.0_f64 / step).floor() as usize;
        one.run(steps).unwrap();
        other.run(steps).unwrap();
        assert_eq!(one.time(), steps as f64 * step);
        check(&one, 60.0 * RATE * AREA, 1e-13 * 60.0 * RATE * AREA);
        check(&other, 60.0 * RATE * AREA, 1e-13 * 60.0 * RATE * AREA);
    }
    let mut simulation = hillside(|flow| flow, 0.1, 20_000);
    for n in 1..=20_000_u32 {
        simulation.step().unwrap();
        assert_eq!(simulation.time(), f64::from(n) * 0.1);
    }
}

/// Steps of one length are divided at times that they have to meet.
#[test]
fn a_step_is_divided_where_it_has_to_meet_times() {
    let with = |flow: Flow| {
        flow.rain(shower(1.3, 2.0 + 1e-7)).meet([2.0 + 1e-7, 1.3, 1.3, -5.0, 1e6]).meet([3.0, 2.5])
    };
    let mut simulation = hillside(with, 1.0, 1000);
    let info = simulation.step().unwrap();
    assert_eq!((info.booked.rain, simulation.steps()), (0.0, 1));
    let info = simulation.step().unwrap();
    assert!((info.booked.rain - 0.7 * RATE * AREA).abs() < 1e-14, "{info:?}");
    assert_eq!(simulation.steps(), 3);
    simulation.run(2).unwrap();
    assert_eq!(simulation.steps(), 3 + 3 + 1);
    assert!((simulation.time() - 4.0).abs() < 1e-15);
    check(&simulation, (0.7 + 1e-7) * RATE * AREA, 1e-14);
    let mesh = dam_break::mesh(0.5).unwrap();
    let depth = dam_break::depth(&mesh);
    let error = dam_break::flow(mesh).meet([1.0, f64::NAN]).simulate(depth, 0.1).map(drop).unwrap_err();
    assert!(matches!(error, FlowError::Number { what: "a time to meet", .. }), "{error}");
}

/// Below rounding is no tolerance; near it there is an end, reached or told why not.
#[test]
fn a_tolerance_that_is_too_small_is_an_error() {
    let mesh = dam_break::mesh(0.5).unwrap();
    let depth = dam_break::depth(&mesh);
    let start = |left| {
        let method = |flow: &Flow| counted(flow, left);
        dam_break::flow(mesh.clone()).simulate_by(depth.clone(), 1e-2, method).unwrap()
    };
    for tolerance in [1e-15, 0.0, -1.0, f64::NAN] {
        let error = start(10).run_until(0.1, tolerance, 1.0).unwrap_err();
        assert!(matches!(error, FlowError::Number { what: "the tolerance", .. }), "{error}");
    }
    let mut simulation = start(20_000);
    simulation.run(30).unwrap();
    simulation.run_until(0.31, 1e-12, 1.0).unwrap();
    assert!(simulation.time() == 0.31 && simulation.steps() > 500, "{}", simulation.steps());
    // Rain that nobody can integrate: on and off at each bit of the time.
    let noise = |_: [f64; 2], t: f64| {
        if t.to_bits().wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 63 == 1 { 1e-5 } else { 0.0 }
    };
    let mut simulation = hillside(|flow| flow.rain(noise), 1.0, 20_000);
    let outcome = simulation.run_until(10.0, 1e-2, 10.0);
    assert!(matches!(outcome, Ok(_) | Err(FlowError::TooExact { .. })), "{outcome:?}");
}

/// Errors that are no smaller in shorter steps: the run ends, says so, and keeps the last good state.
#[test]
fn a_tolerance_that_no_step_meets_is_told() {
    let mesh = dam_break::mesh(0.5).unwrap();
    let depth = dam_break::depth(&mesh);
    let mut simulation = dam_break::flow(mesh).simulate_by(depth, 1e-2, noisy).unwrap();
    simulation.run(2).unwrap();
    let error = simulation.run_until(1.0, 1e-9, 1.0).unwrap_err();
    let (time, text) = (simulation.time(), error.to_string());
    let volume = simulation.flow().mesh().volume(simulation.depth()).unwrap();
    assert!((0.02..0.021).contains(&time) && simulation.volume() == volume, "{time}");
    assert!(text.starts_with(&format!("at time {time} steps down to")) && text.contains("1e-9"), "{text}");
    match error {
        FlowError::TooExact { step, error, tolerance, .. } => {
            assert!(step < 1e-12 && error > 1e-9 && tolerance == 1e-9, "{step:e} {error:e}");
        }
        other => panic!("{other}"),
    }
}

/// Under rain that swells, ebbs and breaks off errors go with the root of the tolerance, as without rain.
#[test]
fn the_error_follows_the_tolerance_under_rain_that_changes() {
    let until = |tolerance: f64| {
        let rain = |_: [f64; 2], t: f64| if t < 700.0 { RATE * (1.0 + (t / 90.0).sin()) } else { 0.0 };
        let mut simulation = hillside(|flow| flow.rain(rain), 0.01, 100_000);
        simulation.run_until(900.0, tolerance, f64::INFINITY).unwrap();
        simulation.depth().to_vec()
    };
    let exact = until(1e-8);
    let errors = [1.6e-3, 4e-4, 1e-4, 2.5e-5].map(|tolerance| {
        let apart = until(tolerance).iter().zip(&exact).map(|(a, b)| (a - b).abs()).sum::<f64>();
        apart / exact.iter().sum::<f64>()
    });
    assert!(errors.windows(2).all(|pair| (1.5..3.0).contains(&(pair[0] / pair[1]))), "{errors:?}");
}

#[test]
fn an_end_that_is_past_is_no_run() {
    let mut simulation = hillside(|flow| flow.rain(shower(0.0, 9.0)), 1.0, 10);
    simulation.run(2).unwrap();
    let (depth, budget) = (simulation.depth().to_vec(), simulation.budget());
    for end in [2.0, 1.0, -7.0] {
        assert_eq!(simulation.run_until(end, 1e-3, 1.0).unwrap(), 0);
        assert_eq!((simulation.time(), simulation.depth(), simulation.budget()), (2.0, &depth[..], budget));
    }
}

/// Showers, slopes, thirst, depths, tolerances and steps at random: each run ends, after some hundred steps, and with
/// times to meet what fell is exact.
#[test]
fn runs_of_any_kind_end() {
    let mut state = 5_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    for round in 0..120 {
        let size = 10_f64.powf(3.0 * random());
        let corners = [[0.0, 0.0], [size, 0.0], [size, 0.5 * size], [0.0, 0.5 * size]];
        let mesh = Mesh::polygon(&corners, size / 6.0).unwrap();
        let (vertices, area) = (mesh.points().len(), mesh.area());
        let slope = [0.0, 1e-3, 0.05, 0.5][(4.0 * random()) as usize];
        let rate = 10_f64.powf(-8.0 + 4.0 * random());
        let drink = rate * [0.0, 0.1, 0.9, 1.5][(4.0 * random()) as usize];
        let wet = [0.0, 0.0, 1e-6, 0.01][(4.0 * random()) as usize];
        let mut times: Vec<f64> = (0..2 + 2 * (round % 3)).map(|_| (5000.0 * random()).floor()).collect();
        times.sort_by(f64::total_cmp);
        let fell: f64 = times.chunks(2).map(|shower| (shower[1] - shower[0]) * rate * area).sum();
        let showers = times.clone();
        let rains = move |t: f64| showers.chunks(2).any(|shower| (shower[0]..shower[1]).contains(&t));
        let mut flow = Flow::over(mesh, Resistance::Manning)
            .terrain(|[x, y]| slope * (x + 0.1 * size * (7.0 * y / size).sin()))
            .friction(|_| 0.05)
            .rain(move |_, t| if rains(t) { rate } else { 0.0 })
            .infiltration(|_| drink);
        if random() < 0.7 {
            flow = flow.outlet(0.05, |[x, _]| x < 1e-9 * size);
        }
        let named = random() < 0.5;
        if named {
            flow = flow.meet(times);
        }
        let (tolerance, first) = (10_f64.powf(-2.0 - 2.0 * random()), 10_f64.powf(-2.0 + 4.0 * random()));
        let longest = [60.0, 600.0, f64::INFINITY][(3.0 * random()) as usize];
        let method = |flow: &Flow| counted(flow, 2000);
        let mut simulation = flow.simulate_by(vec![wet; vertices], first, method).unwrap();
        simulation.run_until(6000.0, tolerance, longest).unwrap();
        let budget = simulation.budget();
        assert!(simulation.depth().iter().all(|&h| h >= 0.0), "round {round}");
        assert!(budget.remainder().abs() <= 1e-12 * (budget.start + fell), "round {round}: {budget:?}");
        assert!(!named || (budget.rain - fell).abs() <= 1e-12 * fell, "round {round}: {budget:?} {fell}");
    }
}
