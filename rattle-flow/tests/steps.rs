//! Time steps: chosen by their error, halved where they fail, and what stays when they fail for good.

mod common;

use common::around;
use rattle_flow::{Budget, Conservative, Flow, FlowError, Method, Settings, Trouble, dam_break};

/// With 4 times as small a tolerance steps are half as long, and the error, as long as space does not matter, half.
#[test]
fn the_error_follows_the_tolerance() {
    let mesh = dam_break::mesh(0.4).unwrap();
    let depth = dam_break::depth(&mesh);
    let until = |tolerance: f64| {
        let mut simulation = dam_break::flow(mesh.clone()).simulate(depth.clone(), 1e-4).unwrap();
        simulation.run_until(3.0, tolerance, 1.0).unwrap();
        assert_eq!(simulation.time(), 3.0);
        assert!(simulation.budget().remainder().abs() < 1e-13);
        assert!(simulation.depth().iter().all(|&h| h >= 0.0));
        (simulation.depth().to_vec(), simulation.steps())
    };
    let (exact, many) = until(1e-6);
    let runs = [1.6e-3, 4e-4, 1e-4].map(until);
    let errors = runs.each_ref().map(|(depth, _)| {
        let difference: Vec<f64> = depth.iter().zip(&exact).map(|(a, b)| (a - b).abs()).collect();
        mesh.volume(&difference).unwrap() / mesh.volume(&exact).unwrap()
    });
    let steps = runs.map(|(_, steps)| steps);
    for i in 0..2 {
        let (error, length) = (errors[i] / errors[i + 1], steps[i + 1] as f64 / steps[i] as f64);
        assert!((1.5..3.0).contains(&error) && (1.4..2.6).contains(&length), "{errors:?} {steps:?} {many}");
    }
}

#[test]
fn a_flow_that_changes_little_takes_long_steps() {
    let mesh = dam_break::mesh(0.4).unwrap();
    let depth = dam_break::depth(&mesh);
    let mut simulation = dam_break::flow(mesh).simulate(depth, 1e-3).unwrap();
    simulation.run_until(20.0, 1e-3, 5.0).unwrap();
    let steps = simulation.steps();
    simulation.run_until(60.0, 1e-3, 5.0).unwrap();
    assert!(simulation.steps() - steps < steps, "{steps} steps of {}", simulation.steps());
    let level = 15.0_f64.sqrt() - 3.0; // at rest
    let (low, high) =
        simulation.depth().iter().fold((f64::INFINITY, 0.0_f64), |(a, b), &h| (a.min(h), b.max(h)));
    assert!(low >= 0.0 && high < level && high > 0.75, "{low} {high}");
}

/// A method that fails as it is told: so many steps may be made, and then steps no longer than this.
fn failing(flow: &Flow, mut good: usize, longest: f64, trouble: Trouble) -> impl Method + use<> {
    around(flow, move |step, guess, make| {
        if good == 0 && step > longest {
            guess.fill(f64::NAN);
            return Err(trouble);
        }
        good = good.saturating_sub(1);
        make(guess)
    })
}

#[test]
fn a_step_that_fails_is_halved_and_the_last_good_state_stays() {
    let mesh = dam_break::mesh(0.5).unwrap();
    let depth = dam_break::depth(&mesh);
    let start = |longest, trouble| {
        let method = |flow: &Flow| failing(flow, 3, longest, trouble);
        dam_break::flow(mesh.clone()).simulate_by(depth.clone(), 0.1, method).unwrap()
    };
    let trouble = Trouble::Singular { vertex: 7 };
    let mut simulation = start(0.03, trouble);
    simulation.run(4).unwrap();
    assert_eq!(simulation.steps(), 3 + 4);
    assert!((simulation.time() - 0.4).abs() < 1e-15 && simulation.budget().remainder().abs() < 1e-13);

    for trouble in [trouble, Trouble::NotConverged { iterations: 30, change: 0.5, vertex: 7 }] {
        let mut simulation = start(0.0, trouble);
        simulation.run(3).unwrap();
        let (kept, budget): (Vec<f64>, Budget) = (simulation.depth().to_vec(), simulation.budget());
        let error = simulation.step().unwrap_err();
        assert!((simulation.time() - 0.3).abs() < 1e-15);
        assert_eq!((simulation.depth(), simulation.budget()), (&kept[..], budget));
        let text = error.to_string();
        assert!(
            text.contains("at time 0.3") && text.contains("vertex 7") && text.contains("last good"),
            "{text}"
        );
        match error {
            FlowError::Singular { vertex: 7, step, .. } | FlowError::NotConverged { vertex: 7, step, .. } => {
                assert_eq!(step, 0.1 / 4096.0);
            }
            other => panic!("{other}"),
        }
    }
}

/// Steps that are chosen by their error are divided as those of one length: by 4096, however short they are.
#[test]
fn a_chosen_step_that_fails_is_divided_however_short_it_is() {
    let mesh = dam_break::mesh(0.5).unwrap();
    let depth = dam_break::depth(&mesh);
    let longest = 0.1 / 8192.0;
    // The third step fails that often, and then each step is made.
    let fails_of = |count: usize| {
        let (mut made, mut failed) = (0, 0);
        move |step: f64, guess: &mut [f64], make: &mut common::Step<'_>| {
            if made == 2 && failed < count && step > 0.0 {
                failed += 1;
                guess.fill(f64::NAN);
                return Err(Trouble::Singular { vertex: 7 });
            }
            made += 1;
            make(guess)
        }
    };
    let start = |count| {
        let method = |flow: &Flow| around(flow, fails_of(count));
        dam_break::flow(mesh.clone()).simulate_by(depth.clone(), 0.1, method).unwrap()
    };
    for count in [1, 6] {
        let mut simulation = start(count);
        let end = 40.0 * longest;
        assert_eq!(simulation.run_until(end, 1e-3, longest).unwrap(), count);
        assert_eq!(simulation.time(), end);
        assert!(simulation.budget().remainder().abs() < 1e-13);
    }
    let mut simulation = start(7);
    let error = simulation.run_until(40.0 * longest, 1e-3, longest).unwrap_err();
    assert!(
        matches!(error, FlowError::Singular { step, vertex: 7, .. } if step == longest / 4096.0),
        "{error}"
    );
    assert_eq!(simulation.time(), 2.0 * longest);
}

/// A step that has grown long is divided down to what is tried of the first one.
#[test]
fn a_step_that_has_grown_long_is_divided_as_far_as_the_first() {
    let mesh = dam_break::mesh(0.5).unwrap();
    let depth: Vec<f64> = dam_break::depth(&mesh).iter().map(|_| 1.0).collect(); // at rest, so that steps grow
    let fails_of = || {
        let (mut fails, mut is_over) = (false, false);
        move |step: f64, guess: &mut [f64], make: &mut common::Step<'_>| {
            fails |= step >= 1.0 && !is_over;
            if fails && step > 1e-4 {
                guess.fill(f64::NAN);
                return Err(Trouble::Singular { vertex: 7 });
            }
            (fails, is_over) = (false, is_over | fails);
            make(guess)
        }
    };
    let method = |flow: &Flow| around(flow, fails_of());
    let mut simulation = dam_break::flow(mesh).simulate_by(depth, 1e-3, method).unwrap();
    assert_eq!(simulation.run_until(100.0, 1e-3, 1.0).unwrap(), 7);
    assert_eq!(simulation.time(), 100.0);
}

/// Fluxes cancel in pairs in every linear system that is solved, so one iteration a step keeps the volume as well as
/// many.
#[test]
fn every_iterate_keeps_the_volume() {
    let mesh = dam_break::mesh(0.4).unwrap();
    let depth = dam_break::depth(&mesh);
    let settings = Settings { tolerance: 1e3, ..Settings::default() };
    let method = |flow: &Flow| Conservative::with(flow, settings);
    let mut hasty = dam_break::flow(mesh.clone()).simulate_by(depth.clone(), 0.02, method).unwrap();
    let mut thorough = dam_break::flow(mesh).simulate(depth, 0.02).unwrap();
    hasty.run(50).unwrap();
    thorough.run(50).unwrap();
    assert_eq!(hasty.iterations(), 50);
    let apart = hasty.depth().iter().zip(thorough.depth()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart > 1e-4, "{apart:e}: what is not solved for is seen");
    assert!(hasty.budget().remainder().abs() < 1e-13, "{:e}", hasty.budget().remainder());
}

/// Linear equations solved by iteration: the same depths, and no less volume, with sinks and outlets too.
#[test]
fn equations_solved_by_iteration_give_the_same_flow_and_the_same_books() {
    let mesh = dam_break::mesh(0.2).unwrap();
    let depth = dam_break::depth(&mesh);
    let start = |direct, tolerance| {
        let settings = Settings { direct, tolerance, ..Settings::default() };
        let flow = dam_break::flow(mesh.clone()).rain(|_, t| if t < 0.5 { 0.05 } else { 0.0 });
        let flow =
            flow.infiltration(|[x, _]| if x < 1.5 { 0.08 } else { 0.0 }).outlet(0.1, |[_, y]| y < 1e-9);
        flow.simulate_by(depth.clone(), 0.02, |flow| Conservative::with(flow, settings)).unwrap()
    };
    let mut by_factors = start(usize::MAX, 1e-10);
    by_factors.run(100).unwrap();
    let mut hasty = start(0, 1e3); // one inexact solution a step
    hasty.run(100).unwrap();
    let mut by_iteration = start(0, 1e-10);
    by_iteration.run(100).unwrap();
    let apart = by_iteration.depth().iter().zip(by_factors.depth()).map(|(a, b)| (a - b).abs());
    let apart = apart.fold(0.0, f64::max);
    assert!(apart < 1e-7, "{apart:e}"); // each step is solved to 1e-10
    for (simulation, solved) in [(&by_factors, true), (&by_iteration, true), (&hasty, false)] {
        let budget = simulation.budget();
        // What is not solved for may be anything but a gain of volume.
        assert!(!solved || budget.unmet > 0.1 && budget.outflow > 1e-3, "{budget:?}");
        assert!(budget.remainder().abs() < 1e-13 * budget.start, "{:e}", budget.remainder());
    }
    assert!(by_iteration.depth().iter().all(|&h| h >= 0.0));
}

#[test]
fn an_iteration_that_may_not_end_is_an_error() {
    let mesh = dam_break::mesh(0.5).unwrap();
    let depth = dam_break::depth(&mesh);
    let settings = Settings { most: 1, ..Settings::default() };
    let method = |flow: &Flow| Conservative::with(flow, settings);
    let mut simulation = dam_break::flow(mesh).simulate_by(depth.clone(), 0.1, method).unwrap();
    assert!(matches!(simulation.step(), Err(FlowError::NotConverged { iterations: 1, .. })));
    assert_eq!((simulation.time(), simulation.depth()), (0.0, &depth[..]));
}

/// The dam break of the notebook: what `cargo run --release --example dam_break` shows, on half as fine a mesh.
#[test]
fn the_dam_breaks_with_its_volume_kept_to_rounding() {
    let mesh = dam_break::mesh(0.25).unwrap();
    let depth = dam_break::depth(&mesh);
    let mut simulation = dam_break::flow(mesh).simulate(depth, 1.0 / 32.0).unwrap();
    let mut flux = 0.0;
    for step in 0..1920 {
        simulation.step().unwrap();
        flux += simulation.mean_flux() / 1920.0;
        assert!(simulation.depth().iter().all(|&h| h >= 0.0), "step {step}");
        let gain = (simulation.volume() / simulation.budget().start - 1.0).abs();
        assert!(gain <= 1e-13, "{gain:e} at step {step}"); // 1920 steps of rounding at random are 10⁻¹⁴
    }
    assert!((1e4 * flux - 266.2).abs() < 1.0, "{flux}"); // by a second program, on other meshes too
}
