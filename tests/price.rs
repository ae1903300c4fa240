//! Prices of accuracy: orders, errors, limits and wishes refused, by a clock that counts evaluations. Wishes met,
//! chaos, and errors estimated are asked in `optimised/tests/price.rs`.

use crate::priced::{FREE, Forces, NONE, Several, double_pendulum, on, pendulum, sphere};
use rattle::Error;
use rattle::effect::{Langevin, LinearDrag};
use rattle::error::{Limit, PriceMistake};
use rattle::prelude::*;
use rattle::price::{Candidate, Clock, Numbers, Price, Prices};

#[test]
fn orders_and_errors_are_those_of_the_methods() {
    let scene = sphere();
    let prices = scene.scene.price(&scene.start, 5.0).budget(0.2).clock(scene.clock()).measure().unwrap();
    assert!(prices.tells_positions() && prices.lyapunov_time.is_none() && prices.reference_error < 1e-14);
    let (mut orders, mut checked) = (0, 0);
    for row in &prices.rows {
        let error = row.position.unwrap();
        // The error that a run of one's own has against the great circle, after any step.
        if row.method == Candidate::Rattle && error > 1e-9 {
            let mut own = scene.scene.simulate(scene.start.clone(), Rattle::new(row.h)).unwrap();
            let mut worst = 0.0_f64;
            for _ in 0..row.steps {
                own.step().unwrap();
                let (sin, cos) = (0.5 * own.time()).sin_cos();
                let exact = rattle::nalgebra::Vector3::new(2.0 * cos, 1.2 * sin, 1.6 * sin);
                worst = worst.max((own.position() - exact).norm());
            }
            assert!((worst / error - 1.0).abs() < 1e-5, "{worst:e} and {error:e} at h = {}", row.h);
            checked += 1;
        }
        // On a circle every method is of its order long before rounding, to one part in seven.
        let order = f64::from(row.method.order());
        if let (Some(found), true) = (row.order, (1e-12..1e-3).contains(&error) && !row.rounding) {
            assert!((found / order - 1.0).abs() < 0.15, "{}: order {found} at h = {}", row.method, row.h);
            orders += 1;
        }
    }
    assert!(orders > 15 && checked > 5, "{orders} orders, {checked} errors\n{prices}");
    assert!(prices.floor(Candidate::Lobatto5).is_some_and(|floor| floor < 1e-13), "{prices}");
    // The front goes up in time and down in error, and the list of digits lies on it.
    let front: Vec<_> = prices.front().map(|row| (row.seconds, row.position.unwrap())).collect();
    assert!(front.len() > 3 && front.windows(2).all(|pair| pair[0].0 <= pair[1].0 && pair[0].1 >= pair[1].1));
    let digits = prices.digits();
    assert!(digits.len() > 10 && digits.windows(2).all(|pair| pair[0].1 <= pair[1].1), "{digits:?}");
    assert_eq!(prices.csv().lines().count(), prices.rows.len() + 1);
    // Times of any size can be read.
    let shown = |duration, lyapunov| {
        let [lyapunov_time, predictable] = [Some(lyapunov), Some(3.0 * lyapunov)];
        let (pilot, positions_until) = (duration, 0.5 * duration);
        Prices { duration, pilot, positions_until, lyapunov_time, predictable, ..prices.clone() }.to_string()
    };
    for (text, words) in [
        (
            shown(5.0, 2.0),
            [
                "measured on 5.0000 of 5.0000 units",
                "Lyapunov time 2.000",
                "until 6.000 after",
                "until 2.500;",
            ],
        ),
        (
            shown(5e-12, 2e-13),
            [
                "measured on 5.0000e-12 of", "Lyapunov time 2.000e-13", "until 6.000e-13 after",
                "until 2.500e-12;",
            ],
        ),
        (
            shown(4e9, 1e8),
            ["measured on 4.0000e9 of", "Lyapunov time 1.000e8", "until 3.000e8 after", "until 2.000e9;"],
        ),
    ] {
        words.iter().for_each(|words| assert!(text.contains(words), "no `{words}` in\n{text}"));
    }
}

/// The rows in lanes beside those of a simulation with the same steps, their errors the same to this rounding.
fn like_alone(prices: &Prices, lanes: Candidate, method: Candidate, rounding: f64) -> Vec<(&Price, &Price)> {
    let rows = |method: Candidate| prices.rows.iter().filter(move |row| row.method == method);
    let both = rows(lanes).flat_map(|row| rows(method).map(move |alone| (row, alone)));
    let both: Vec<_> =
        both.filter(|(row, alone)| (row.h, row.tolerance) == (alone.h, alone.tolerance)).collect();
    for (row, alone) in &both {
        let [a, b] = [row, alone].map(|row| row.position.unwrap());
        assert!((a - b).abs() <= rounding + 1e-9 * b, "{lanes}: {a:e} and {b:e} at h = {}", row.h);
    }
    both
}

/// A trajectory in lanes is the one of a simulation, to rounding; a single has seven digits; what cannot go side by
/// side says so.
#[test]
fn lanes_are_priced_beside_simulations() {
    let scene = sphere();
    let others =
        |count: u32| (1..count).map(|i| scene.start.clone().moving([0.0, 0.6, 0.8 - 0.001 * f64::from(i)]));
    let asked = |count| scene.scene.price(&scene.start, 5.0).side_by_side(others(count)).budget(6.0);
    let prices = asked(16).clock(scene.clock()).measure().unwrap();
    let rows = |method: Candidate| prices.rows.iter().filter(move |row| row.method == method);
    let mut compared = 0;
    for lanes in Candidate::LANES {
        let Candidate::InLanes(&method, numbers) = lanes else { panic!("{lanes}") };
        assert!(rows(lanes).count() > 1, "{lanes}");
        let rounding = if numbers == Numbers::Single { 1e-4 } else { 1e-13 };
        for (row, alone) in like_alone(&prices, lanes, method, rounding) {
            // A row has room for 64, of which 16 are used.
            let ratio = row.seconds / alone.seconds;
            assert!((0.5..20.0).contains(&ratio), "{lanes}: {ratio} times the evaluations at h = {}", row.h);
            compared += 1;
        }
    }
    assert!(compared > 20, "{compared}\n{prices}");
    for (lanes, bounds) in Candidate::LANES.into_iter().zip([1e-8..1e-5, 1e-17..1e-14, 1e-17..1e-14]) {
        let energy = rows(lanes).map(|row| row.energy).fold(0.0, f64::max); // on a circle that of rounding alone
        assert!(bounds.contains(&energy), "{lanes}: {energy:e}");
    }
    let digits = prices.digits_in_lanes();
    assert!(digits.len() > 10 && digits.iter().all(|offer| offer.2.is_in_lanes()), "{digits:?}");
    assert!(prices.digits().iter().all(|offer| !offer.2.is_in_lanes()));
    assert!(prices.front().all(|row| !row.method.is_in_lanes()));

    let few = scene.scene.price(&scene.start, 1.0).side_by_side([]).budget(0.1).clock(scene.clock());
    let few = few.measure().unwrap();
    let alone = few.refused.iter().filter(|refused| refused.method.is_in_lanes());
    assert!(alone.clone().count() == Candidate::LANES.len(), "{few}");
    assert!(alone.clone().all(|refused| matches!(refused.why, Some(Error::Price(PriceMistake::OneByOne)))));
}

/// What drag takes is no error of the energy, in lanes as in simulations.
#[test]
fn work_is_no_error() {
    let surface = Counted::new(Several { sphere: 1.0, ..NONE });
    let counts = surface.counts();
    let clock = Clock::of(move || 1e-6 * counts.all() as f64);
    let (slow, start) = (Scene::on(surface).with(LinearDrag::new(1.0)), sphere().start);
    let prices = slow.price(&start, 2.0).side_by_side(vec![start.clone(); 15]).budget(2.0).clock(clock);
    let prices = prices.measure().unwrap();
    let double = |row: &&Price| match row.method {
        Candidate::InLanes(_, numbers) => numbers != Numbers::Single,
        method => method == Candidate::Rattle,
    };
    let rows: Vec<_> = prices.rows.iter().filter(double).collect();
    assert!(rows.iter().filter(|row| row.method.is_in_lanes()).count() > 2, "{prices}");
    rows.iter().for_each(|row| assert!(row.energy < 1e-13, "{}: {:e}", row.method, row.energy));
}

/// In double precision, by all methods that are asked.
#[test]
fn links_are_priced_side_by_side() {
    let scene = double_pendulum(1.0);
    let others = (1..16).map(|i| {
        let (sin, cos) = (0.1 * f64::from(i)).sin_cos();
        State::of([[0.0, 0.0], [1.0, 0.0], [1.0 + sin, cos]])
    });
    let prices = scene.scene.price(&scene.start, 1.0).side_by_side(others).budget(2.0).clock(scene.clock());
    let prices = prices.measure().unwrap();
    let mut compared = 0;
    for lanes in Candidate::LANES {
        let Candidate::InLanes(&method, numbers) = lanes else { panic!("{lanes}") };
        let why = prices
            .refused
            .iter()
            .find(|refused| refused.method == lanes)
            .and_then(|refused| refused.why.as_ref());
        match (method, numbers) {
            (_, Numbers::Single) => {
                assert!(matches!(why, Some(Error::Price(PriceMistake::AlwaysDouble))), "{why:?}")
            }
            _ => {
                assert!(why.is_none(), "{lanes}: {why:?}");
                let alike = like_alone(&prices, lanes, method, 1e-13).len();
                assert!(alike > 0, "{lanes}\n{prices:#}");
                compared += alike;
            }
        }
    }
    assert!(compared >= 20, "{compared}\n{prices}");
    for method in [Candidate::Lobatto3, Candidate::Lobatto5, Candidate::Lobatto8, Candidate::Taylor] {
        let in_lanes = |row: &Price| matches!(row.method, Candidate::InLanes(&of, _) if of == method);
        assert!(prices.rows.iter().any(in_lanes), "{method} in lanes");
    }
}

#[test]
fn time_is_never_longer_than_asked() {
    for budget in [0.003, 0.03, 0.3] {
        let scene = double_pendulum(5.0);
        let clock = scene.clock();
        let begun = clock.now();
        let measured = scene.scene.price(&scene.start, 5.0).budget(budget).clock(clock.clone()).measure();
        let spent = clock.now() - begun;
        // A quarter of a look's steps are made to their end.
        assert!(spent <= 1.05 * budget + 1e-4, "{spent} of {budget}");
        match measured {
            Ok(prices) => assert!(prices.seconds <= 1.05 * budget + 1e-4 && !prices.rows.is_empty()),
            Err(error) => {
                assert!(budget < 0.1 && matches!(error, Error::Price(PriceMistake::Late { .. })), "{error}")
            }
        }
    }
}

#[test]
fn what_limits_accuracy_is_named() {
    let scene = pendulum();
    match scene.within(1e-18, 0.5) {
        Err(Error::Price(PriceMistake::Unreachable { limit: Limit::Rounding, best, .. })) => {
            assert!((1e-18..1e-13).contains(&best), "{best:e}");
        }
        other => panic!("{other:?}"),
    }
    match scene.within(1e-11, 0.01) {
        Err(Error::Price(PriceMistake::Unreachable { limit: Limit::Budget { seconds }, best, .. })) => {
            assert!(seconds == 0.01 && best > 1e-11);
        }
        Err(Error::Price(PriceMistake::Late { budget })) => assert_eq!(budget, 0.01),
        other => panic!("{other:?}"),
    }
    let start = State::at([2.0, 0.0, 0.0]).moving([0.0, 0.6, 0.8]);
    let kinked = on("kink", Several { sphere: 1.0, ..NONE }, Forces { kink: 0.3, ..FREE }, start, 5.0);
    match kinked.within(1e-12, 0.5) {
        Err(Error::Price(PriceMistake::Unreachable { limit: Limit::Kink { order }, best, .. })) => {
            assert!(order < 4.0 && best < 1e-2, "{order} {best:e}");
        }
        other => panic!("{other:?}"),
    }
    let surface = Counted::new(Several { sphere: 1.0, ..NONE });
    let counts = surface.counts();
    let clock = Clock::of(move || 1e-6 * counts.all() as f64);
    let slow = Scene::on(surface).with(LinearDrag::new(1.0));
    let start = State::at([2.0, 0.0, 0.0]).moving([0.0, 0.6, 0.8]);
    match slow.within(1e-12).budget(0.5).clock(clock).simulate(&start, 5.0) {
        Err(Error::Price(PriceMistake::Unreachable { limit: Limit::Flows { seconds }, best, .. })) => {
            assert!(seconds == 0.5 && best > 1e-12, "{best:e}");
        }
        other => panic!("{other:?}"),
    }
}

/// Steps with a tolerance are made shorter where whole ones lead too far.
#[test]
fn methods_with_a_tolerance_find_a_step() {
    let ellipsoid = Several { quadric: 1.0, c: 1.0 / 2.25, ..NONE };
    let scene = on("ellipsoid", ellipsoid, Forces { g: 9.81, ..FREE }, State::at([1.0, 0.0, 0.0]), 10.0);
    let prices = scene.scene.price(&scene.start, 10.0).budget(2.0).clock(scene.clock()).measure().unwrap();
    for method in [Candidate::Dop853, Candidate::Taylor] {
        let rows = prices.rows.iter().filter(|row| row.method == method);
        assert!(rows.clone().count() > 2, "{method}: {prices:#}");
    }
}

#[test]
fn senseless_wishes_are_refused() {
    let scene = sphere();
    for (wish, budget, duration) in
        [(0.0, 1.0, 5.0), (f64::NAN, 1.0, 5.0), (1e-6, 0.0, 5.0), (1e-6, 1.0, -5.0)]
    {
        let asked = scene.scene.within(wish).budget(budget).simulate(&scene.start, duration);
        assert!(matches!(asked, Err(Error::Price(PriceMistake::NotPositive { .. }))), "{asked:?}");
    }
    let hot = Scene::points::<1>(1).with(Langevin { friction: 1.0, temperature: 1.0, seed: 1 });
    let asked = hot.price(&State::at([0.0]), 5.0).measure();
    assert!(matches!(asked, Err(Error::Price(PriceMistake::Random { .. }))), "{asked:?}");
    let surface = Counted::new(Several { sphere: 1.0, ..NONE });
    let counts = surface.counts();
    let clock = Clock::of(move || 1e-6 * counts.all() as f64);
    let slow = Scene::on(surface).with(LinearDrag::new(1.0));
    let prices = slow.price(&scene.start, 5.0).budget(0.05).clock(clock).measure().unwrap();
    assert!(prices.refused.iter().any(|refused| matches!(refused.why, Some(Error::CannotMove { .. }))));
}

/// A state on the way is as good a start as the first one: errors count from there. Others are refused.
#[test]
fn errors_are_estimated_from_any_state_of_the_run() {
    let scene = Scene::on(rattle::surfaces::Sphere { r: 1.0 });
    let start = State::at([1.0, 0.0, 0.0]).moving([0.0, 0.6, 0.8]);
    let h = 0.02;
    let mut run = scene.simulate(start.clone(), Rattle::new(h)).unwrap();
    run.run(100).unwrap();
    let middle = run.state();
    run.run(300).unwrap();
    // A step takes the angle arcsin h on a great circle, h³/6 too much.
    for (from, steps) in [(&start, 400.0), (&middle, 300.0)] {
        let (estimate, truth) = (run.estimate_error(from).unwrap(), steps * h * h * h / 6.0);
        assert!((estimate.position / truth - 1.0).abs() < 0.01, "{estimate} for {truth:e}");
    }
    let other = |start: &State<3>| {
        matches!(run.estimate_error(start), Err(Error::Price(PriceMistake::OtherStart { .. })))
    };
    assert!(other(&start.clone().at_time(0.5)) && other(&middle.clone().after_steps(50)) && !other(&middle));
    let none = run.estimate_error(&run.state());
    assert!(matches!(none, Err(Error::Price(PriceMistake::NotPositive { .. }))), "{none:?}");
}

/// With flows steps of all methods are of second order: that errors fall like h² is not rounding.
#[test]
fn with_flows_second_order_is_not_rounding() {
    let surface = Counted::new(Several { sphere: 1.0, ..NONE });
    let counts = surface.counts();
    let clock = Clock::of(move || 1e-6 * counts.all() as f64);
    let slow = Scene::on(surface).with(LinearDrag::new(1e-3));
    let start = State::at([2.0, 0.0, 0.0]).moving([0.0, 0.6, 0.8]);
    let prices = slow.price(&start, 0.5).budget(2.0).clock(clock).measure().unwrap();
    let fixed = prices.rows.iter().filter(|row| row.tolerance.is_none());
    let called: Vec<_> = fixed.clone().filter(|row| row.rounding).collect();
    let least = fixed.filter(|row| row.method.order() >= 6).filter_map(|row| row.position);
    let least = least.fold(f64::INFINITY, f64::min);
    println!("{prices}\n{least:e}");
    assert!(least < 1e-10, "{least:e}");
    assert!(called.iter().all(|row| row.position.is_some_and(|error| error < 1e-11)), "{called:?}");
}
