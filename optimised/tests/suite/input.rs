//! What nobody means: an error that says what, where and how much, and never a panic or a silent repair.

use crate::suite::case::{Case, Kind, Measured};
use crate::suite::scenes::*;
use rattle::Error;
use rattle::error::{StartFailure, StepFailure, SurfaceFailure};
use rattle::prelude::*;

fn refused(simulation: Result<BoxedSimulation<3>, Error>, meant: fn(&Error) -> bool) -> f64 {
    unless(simulation, meant)
}

fn not_finite(error: &Error) -> bool {
    matches!(error, Error::Start { cause: StartFailure::NotFinite { .. }, .. })
}

fn singular(error: &Error) -> bool {
    matches!(error, Error::Start { cause: StartFailure::SingularPoint { .. }, .. })
}

fn off(error: &Error) -> bool {
    matches!(error, Error::Start { cause: StartFailure::OffSurface { .. }, .. })
}

pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let numbers = Kind {
        why: "NaN compares false with everything: tests pass, loops end, and results are no numbers",
        expect: "an error before the first step that names the component or parameter",
        reason: "each is refused",
    };
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let fine = [1.0, 0.0, 0.0];
        cases.push(numbers.case(format!("a place of {bad}"), 0.0, move || {
            Ok(refused(on(sphere(1.0), 1.0, at([1.0, bad, 0.0], [0.0; 3]), Rattle::new(0.01)), not_finite))
        }));
        cases.push(numbers.case(format!("a momentum of {bad}"), 0.0, move || {
            Ok(refused(on(sphere(1.0), 1.0, at(fine, [0.0, bad, 0.0]), Rattle::new(0.01)), not_finite))
        }));
        cases.push(numbers.case(format!("gravity of {bad}"), 0.0, move || {
            Ok(refused(on(sphere(1.0), bad, State::at(fine), Rattle::new(0.01)), |error| {
                let nan = matches!(error, Error::NanParameter { parameter: "g", .. });
                nan || matches!(error, Error::Start { cause: StartFailure::ForceNotFinite { .. }, .. })
            }))
        }));
        cases.push(numbers.case(format!("a radius of {bad}"), 0.0, move || {
            Ok(refused(on(sphere(bad), 1.0, State::at(fine), Rattle::new(0.01)), |error| {
                let nan = matches!(error, Error::NanParameter { parameter: "k", .. });
                nan || matches!(error, Error::Start { cause: StartFailure::ConstraintNotFinite { .. }, .. })
            }))
        }));
    }
    let steps = Kind {
        why: "a step of zero runs for ever, a step of NaN poisons the state",
        expect: "an error that says so",
        reason: "each is refused",
    };
    for h in [0.0, f64::NAN, f64::INFINITY] {
        cases.push(steps.case(format!("a step of {h}"), 0.0, move || {
            let run = on(sphere(1.0), 1.0, State::at([1.0, 0.0, 0.0]), Rattle::new(h));
            Ok(refused(run, |error| matches!(error, Error::StepSize(_))))
        }));
    }
    let told = Kind {
        why: "a start that is moved onto the surface in silence is another problem than the one that was set",
        expect: "the error tells how far the start is off, a length",
        reason: "second order of the distance, and rounding of g",
    };
    for distance in [1e-2, 1e-4, 1e-6, 1e-8] {
        cases.push(told.case(
            format!("a start {distance:e} off the sphere"),
            0.6 * distance + 4.0 * E / distance,
            move || {
                let run = on(sphere(1.0), 1.0, State::at([1.0 + distance, 0.0, 0.0]), Rattle::new(0.01));
                Ok(match run {
                    Err(Error::Start { cause: StartFailure::OffSurface { distance: found, .. }, .. }) => {
                        (found / distance - 1.0).abs()
                    }
                    _ => f64::NAN,
                })
            },
        ));
    }
    let tilted = Kind {
        why: "a momentum across the surface is lost in the first projection, and its energy with it",
        expect: "the error tells the sine of its angle with the surface",
        reason: "rounding of the product of normal and momentum",
    };
    for sine in [1e-2, 1e-4, 1e-6, 1e-8] {
        cases.push(tilted.case(format!("a momentum {sine:e} off the tangent"), 4.0 * E / sine, move || {
            let p = [sine, (1.0 - sine * sine).sqrt(), 0.0];
            Ok(match on(sphere(1.0), 1.0, at([1.0, 0.0, 0.0], p), Rattle::new(0.01)) {
                Err(Error::Start { cause: StartFailure::NotTangent { sine: found, .. }, .. }) => {
                    (found / sine - 1.0).abs()
                }
                _ => f64::NAN,
            })
        }));
    }
    let none = Kind {
        why: "g has no surface, or no normal on it: any place solves, or none",
        expect: "an error that says which of both",
        reason: "each is refused",
    };
    cases.push(none.case("g = z², zero to second order", 0.0, || {
        let flat = Quadric { axes: [0.0, 0.0, 1.0], k: 0.0, ..sphere(1.0) };
        Ok(refused(on(flat, 0.0, State::at([1.0, 1.0, 0.0]), Rattle::new(0.01)), singular))
    }));
    cases.push(none.case("g = 0 everywhere", 0.0, || {
        let nothing = Quadric { c: 0.0, ..sphere(1.0) };
        Ok(refused(on(nothing, 0.0, State::at([1.0, 0.0, 0.0]), Rattle::new(0.01)), singular))
    }));
    cases.push(none.case("g = q² + 1, nowhere zero", 0.0, || {
        let empty = Quadric { k: -1.0, ..sphere(1.0) };
        Ok(refused(on(empty, 0.0, State::at([1.0, 0.0, 0.0]), Rattle::new(0.01)), off))
    }));
    cases.push(none.case("g = q² + 1, projected", 0.0, || {
        let empty = Quadric { k: -1.0, ..sphere(1.0) };
        Ok(refused(onto(empty, 0.0, State::at([1.0, 0.5, 0.25]), Rattle::new(0.01)), |error| {
            let Error::Start { cause, .. } = error else { return false };
            matches!(cause, StartFailure::NoProjection { .. } | StartFailure::SingularPoint { .. })
        }))
    }));
    cases.push(none.case("a sphere of radius zero", 0.0, || {
        Ok(refused(on(sphere(0.0), 0.0, State::at([0.0; 3]), Rattle::new(0.01)), singular))
    }));
    let masses = Kind {
        why: "a mass that is no positive number divides by zero or turns energy over",
        expect: "an error that names the body, or the weight that is no number",
        reason: "each is refused",
    };
    for mass in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-320] {
        cases.push(masses.case(format!("a mass of {mass:?}"), 0.0, move || {
            let rods = Rods {
                places: vec![[0.0, 0.0], [1.0, 0.0]],
                masses: vec![1.0, mass],
                rods: vec![[0, 1]],
                ..Rods::default()
            };
            Ok(unless(rods.simulate(Rattle::new(0.01)), |error| {
                matches!(error, Error::Network(_) | Error::NanParameter { .. })
            }))
        }));
    }
    let moments = Kind {
        why: "moments that no body has give energies that no body has",
        expect: "an error with the moments",
        reason: "each is refused",
    };
    for moments_of in [[1.0, 2.0, 3.1], [0.0, 1.0, 1.0], [-1.0; 3], [f64::NAN, 1.0, 1.0]] {
        cases.push(moments.case(format!("moments of inertia {moments_of:?}"), 0.0, move || {
            let start = Rigid::start(&nalgebra::Matrix3::identity(), &nalgebra::Vector3::new(0.1, 0.2, 0.3));
            let run = Scene::rigid(Rigid::new(moments_of)).simulate(start, Rattle::new(0.01));
            Ok(unless(run, |error| matches!(error, Error::Network(_))))
        }));
    }
    let counts = Kind {
        why: "an index beyond the bodies is a panic, or another body's memory",
        expect: "an error with both numbers",
        reason: "each is refused",
    };
    cases.push(counts.case("a state of two bodies for a scene of one", 0.0, || {
        let two = State::of([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        Ok(refused(on(sphere(1.0), 0.0, two, Rattle::new(0.01)), |error| {
            matches!(error, Error::BodyCount { scene: 1, state: 2 })
        }))
    }));
    cases.push(counts.case("a rod to a body that there is not", 0.0, || {
        let pair = Rods { places: vec![[0.0, 0.0], [1.0, 0.0]], ..Rods::default() };
        let rods = vec![(crate::common::linked::Rod { length: 1.0 }, [0, 2])];
        Ok(unless(pair.simulate_with(rods, Rattle::new(0.01)), |error| matches!(error, Error::Network(_))))
    }));
    cases.push(counts.case("a rod from a body to itself", 0.0, || {
        let pair = Rods { places: vec![[0.0, 0.0], [1.0, 0.0]], ..Rods::default() };
        let rods = vec![(crate::common::linked::Rod { length: 1.0 }, [1, 1])];
        Ok(unless(pair.simulate_with(rods, Rattle::new(0.01)), |error| matches!(error, Error::Network(_))))
    }));
    let after = Kind {
        why: "a step that fails half-way leaves new places with old momenta",
        expect: "the state before the step, bit for bit, and a shorter step goes on from it",
        reason: "bit for bit",
    };
    cases.push(after.case("on with a shorter step", 0.0, on_with_a_shorter_step));
    cases
}

fn on_with_a_shorter_step() -> Measured {
    let start = at([1.0, 0.0, 0.0], [0.0, 0.6, 0.8]);
    let mut long = on(sphere(1.0), 1.0, start.clone(), Rattle::new(1.5))?;
    let failed = unless(long.step(), |error| {
        matches!(error, Error::Step { cause: StepFailure::Surface(SurfaceFailure::StepTooLong { .. }), .. })
    });
    let mut short = on(sphere(1.0), 1.0, long.state(), Rattle::new(0.01))?;
    let mut fresh = on(sphere(1.0), 1.0, start, Rattle::new(0.01))?;
    short.run(100)?;
    fresh.run(100)?;
    Ok(failed + apart(&short.state(), &fresh.state()))
}
