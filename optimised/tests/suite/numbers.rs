//! Scales of g, of lengths, of speeds and of time; far from the origin; units; turning points and rest.

use crate::common::distance;
use crate::suite::case::{Case, Kind, Measured};
use crate::suite::scenes::*;
use rattle::Error;
use rattle::error::StartFailure::OutOfScale;
use rattle::error::{StepFailure, SurfaceFailure};
use rattle::nalgebra::Vector3;
use rattle::prelude::*;

pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let scaled = Kind {
        why: "a tolerance on g is met too early or never; squares of its gradient leave the range",
        expect: "c·g = 0 moves like g = 0",
        reason: "1000 roundings of the products with c, at random: 32 ε",
    };
    for c in [-3e-3, 1e-8, 1e8, 1e-100, 1e100, 1e-150, 1e150] {
        cases.push(scaled.case(format!("g times {c:e}"), 1e-14, move || any_multiple(c)));
    }
    let sizes = Kind {
        why: "what is small against one is taken for zero, and what is large for never solved",
        expect: "the discrete solution on the sphere, as part of the radius",
        reason: "100 roundings of a step's angle of 0.1, twice",
    };
    for radius in [1e-70, 1e-50, 1e-20, 1e-8, 1e8, 1e20, 1e50, 1e70] {
        cases.push(sizes.case(format!("sphere of radius {radius:e}"), 20.0 * E, move || circle(radius, 1.0)));
    }
    for speed in [1e-100, 1e-20, 1e20, 1e100, 1e140] {
        let name = format!("speed {speed:e}, steps as much shorter");
        cases.push(sizes.case(name, 20.0 * E, move || circle(1.0, speed)));
    }
    let range = Kind {
        why: "squares overflow: infinity minus infinity is no number, and a solver takes it for a root",
        expect: "an error that says that numbers leave their range, or the solution; no garbage",
        reason: "each is refused, or right to 20 ε",
    };
    for radius in [1e-160, 1e-100, 1e100, 1e160, 1e300] {
        cases.push(
            range.case(format!("sphere of radius {radius:e}"), 0.0, move || Ok(refused_or_right(radius))),
        );
    }
    for c in [1e-300, 1e-200, 1e-155, -1e-153, 1e153, 1e155, 1e200, 1e300] {
        cases.push(range.case(format!("g times {c:e}"), 0.0, move || {
            Ok(match any_multiple(c) {
                Ok(off) => f64::from(off.is_nan() || off > 1e-14),
                other => {
                    unless(other, |error| matches!(error, Error::Start { cause: OutOfScale { .. }, .. }))
                }
            })
        }));
    }
    let units = Kind {
        why: "a constant with a unit hides in a tolerance",
        expect: "lengths and times in units of powers of two give the same digits",
        reason: "bit for bit: powers of two round nothing",
    };
    for (length, time) in [(20, 0), (-20, 0), (100, 0), (-100, 0), (0, 30), (0, -100), (-7, 11)] {
        let name = format!("units of 2^{length} of length and 2^{time} of time");
        cases.push(units.case(name, 0.0, move || other_units(length, time)));
    }
    let far = Kind {
        why: "coordinates are rounded by the distance from the origin, not by the size of the surface",
        expect: "the sphere of radius 1 that far away is kept",
        reason: "three coordinates, each rounded by half of the last place there, and the solve 12 at most",
    };
    for offset in [1e3, 1e6, 1e9] {
        cases.push(far.case(format!("sphere {offset:e} from the origin"), 4.0 * E * offset, move || {
            far_away(offset).map(|found| found[0])
        }));
    }
    let along = Kind {
        why: "the coordinate along the axis is rounded by more than steps are long, and the surface does not know it",
        expect: "the cylinder of radius 1 is kept, and a start 1e-6 off it refused",
        reason: "eight roundings where a solve ends, and two of the coordinates",
    };
    for z in [1e4, 1e8, 1e12] {
        cases.push(
            along.case(format!("cylinder, z = {z:e}, RATTLE"), 10.0 * E, move || {
                along_axis(z, Rattle::new(0.1))
            }),
        );
        cases.push(
            along.case(format!("cylinder, z = {z:e}, BDF2"), 10.0 * E, move || along_axis(z, Bdf2::new(0.1))),
        );
        cases.push(along.case(format!("cylinder, z = {z:e}, Lobatto"), 10.0 * E, move || {
            along_axis(z, Lobatto::<3>::new(0.1))
        }));
    }
    let energy = Kind {
        why: "each step rounds the place by 1e-10: without compensation the energy walks",
        expect: "the energy far from the origin stays over 10 000 steps",
        reason: "normals are known to ε·offset, and 10 000 steps of 0.01 add up at random: 1",
    };
    for offset in [1e3, 1e6, 1e9] {
        cases.push(energy.case(format!("energy {offset:e} from the origin"), 2.0 * E * offset, move || {
            far_away(offset).map(|found| found[1])
        }));
    }
    let origin = Kind {
        why: "the coordinates are smaller than the rounding of g: a relative tolerance asks for too much",
        expect: "swings of any size about a point of the surface at the origin keep their size",
        reason: "h²/16 = 6e-6 of the method's own frequency and amplitude, and amplitude² of a pendulum",
    };
    for amplitude in [1e-3, 1e-6, 1e-9, 1e-12, 1e-100] {
        cases.push(
            origin.case(format!("swings of {amplitude:e} at the origin"), 1e-5, move || swings(amplitude)),
        );
    }
    let turning = Kind {
        why: "path and push cancel: a correction relative to the path divides by zero",
        expect: "the turning point is passed, at rest to rounding",
        reason: "h²p⁴/8 of the method, with p = 0.1 after ten steps",
    };
    for off in [0.0, 1e-16, -1e-9, 1e-5] {
        cases.push(turning.case(
            format!("a kick takes away all but {off:?} of the momentum"),
            1.25e-9,
            move || {
                let start = at([1.0, 0.0, 0.0], [0.0, 0.0, 0.005 + off]);
                energy_error(on(sphere(1.0), 1.0, start, Rattle::new(0.01))?, 10)
            },
        ));
    }
    let rest = Kind {
        why: "the guess is exact and every correction 0/0; on top rounding of one sign starts the fall",
        expect: "a body at rest in equilibrium stays there, also on top",
        reason: "bit for bit across; along the normal the last place",
    };
    for (name, z) in [("top", 1.0), ("bottom", -1.0)] {
        cases.push(rest.case(format!("rest at the {name}, 10 000 steps"), E, move || {
            let simulation = on(sphere(1.0), 1.0, State::at([0.0, 0.0, z]), Rattle::new(0.01))?;
            largest(simulation, 10_000, |now| {
                let q = place(now);
                if [q.x, q.y] == [0.0; 2] { (q.z - z).abs() } else { 1.0 }
            })
        }));
    }
    cases.push(rest.case("rest without gravity, 10 000 steps", 0.0, || {
        let simulation = on(sphere(1.0), 0.0, State::at([0.0, 0.6, 0.8]), Rattle::new(0.01))?;
        let first = place(&simulation);
        largest(simulation, 10_000, move |now| distance(place(now), first))
    }));
    let weak = Kind {
        why: "forces of 1e-300 vanish in products, and their squares are zero",
        expect: "a body at rest gathers the momentum g·t, however weak the pull",
        reason: "some roundings of g·t",
    };
    for g in [1e-10, 1e-100, 1e-200, 1e-290] {
        cases.push(weak.case(format!("gravity of {g:e}"), 4.0 * E, move || {
            let mut simulation = on(sphere(1.0), g, State::at([1.0, 0.0, 0.0]), Rattle::new(0.01))?;
            simulation.run(200)?;
            Ok((momentum(&simulation).z / (-2.0 * g) - 1.0).abs())
        }));
    }
    cases
}

fn energy_error(simulation: BoxedSimulation<3>, steps: u64) -> Measured {
    largest(simulation, steps, |now| now.energy_error().abs())
}

/// After 1000 steps under gravity, on an ellipsoid.
fn any_multiple(c: f64) -> Measured {
    let surface = |c| Quadric { c, centre: [0.1, 0.2, 0.3], axes: [1.0, 2.0, 3.0], k: 1.0 };
    let start = || at([1.1, 0.2, 0.3], [0.0, 0.6, 0.8]);
    let there = |c| place_after(on(surface(c), 1.0, start(), Rattle::new(0.01))?, 1000);
    Ok(distance(there(c)?, there(1.0)?))
}

/// A great circle in steps of 0.1 R, as part of the radius.
fn circle(radius: f64, speed: f64) -> Measured {
    let start = at([radius, 0.0, 0.0], [0.0, 0.6 * speed, 0.8 * speed]);
    let simulation = on(sphere(radius), 0.0, start, Rattle::new(0.1 * radius / speed))?;
    largest(simulation, 100, |now| {
        let (sin, cos) = (now.steps() as f64 * 0.1_f64.asin()).sin_cos();
        distance(place(now) / radius, [cos, 0.6 * sin, 0.8 * sin])
    })
}

fn refused_or_right(radius: f64) -> f64 {
    match circle(radius, 1.0) {
        Ok(error) => f64::from(error.is_nan() || error > 20.0 * E),
        Err(
            Error::Start { .. }
            | Error::Step { cause: StepFailure::Surface(SurfaceFailure::OutOfScale { .. }), .. },
        ) => 0.0,
        Err(error) => {
            println!("instead: {error}");
            1.0
        }
    }
}

/// Positions and momenta in other units, after 300 steps, apart.
fn other_units(length: i32, time: i32) -> Measured {
    let run = |l: f64, t: f64| {
        let surface = Quadric { c: 1.0, centre: [0.0; 3], axes: [1.0, 2.0, 3.0], k: l * l };
        let start = at([l, 0.0, 0.0], [0.0, 0.6 * l / t, 0.8 * l / t]);
        let mut simulation = on(surface, l / t / t, start, Rattle::new(0.01 * t))?;
        simulation.run(300)?;
        Ok::<_, Error>(State::at(place(&simulation) / l).moving(momentum(&simulation) / l * t))
    };
    Ok(apart(&run(2.0_f64.powi(length), 2.0_f64.powi(time))?, &run(1.0, 1.0)?))
}

/// The largest distance from the sphere, and energy error, of 10 000 steps that far from the origin.
fn far_away(offset: f64) -> Result<[f64; 2], Error> {
    let centre = [offset, -offset, offset];
    let surface = Quadric { centre, ..sphere(1.0) };
    let start = at([offset + 1.0, -offset, offset], [0.0, 0.6, 0.8]);
    let mut simulation = on(surface, 0.0, start, Rattle::new(0.01))?;
    let mut found = [0.0; 2];
    simulation.run_with(10_000, |now| {
        let off = ((place(now) - rattle::nalgebra::Vector3::from(centre)).norm() - 1.0).abs();
        found = [larger(found[0], off), larger(found[1], now.energy_error().abs())];
    })?;
    Ok(found)
}

/// How far the largest swing is off the first, at the bottom of a sphere that touches the origin from above.
fn swings(amplitude: f64) -> Measured {
    let surface = Quadric { centre: [0.0, 0.0, 1.0], ..sphere(1.0) };
    let start = State::at([amplitude, 0.0, 0.5 * amplitude * amplitude]);
    let simulation = onto(surface, 1.0, start, Rattle::new(0.01))?;
    Ok((largest(simulation, 5000, |now| place(now).x.abs())? / amplitude - 1.0).abs())
}

/// How far a body that goes around a cylinder comes off it, alone and side by side.
fn along_axis<S: Method + 'static>(z: f64, method: S) -> Measured {
    let cylinder = Quadric { axes: [1.0, 1.0, 0.0], ..sphere(1.0) };
    let off = |q: Vector3<f64>| (q.x.hypot(q.y) - 1.0).abs();
    let start = at([0.6, 0.8, z], [-0.56, 0.42, 0.3]);
    let beside = at([1.0 + 1e-6, 0.0, z], [0.0, 0.7, 0.3]);
    if on(cylinder, 0.0, beside, method.clone()).is_ok() {
        return Ok(f64::INFINITY);
    }
    let mut worst = 0.0_f64;
    let mut run = on(cylinder, 0.0, start.clone(), method.clone())?;
    run.run_with(300, |now| worst = now.positions().map(off).fold(worst, f64::max))?;
    let mut ensemble = Scene::on(cylinder).ensemble([start], method)?;
    ensemble.run(300);
    Ok(ensemble.state(0).positions().map(off).fold(worst, f64::max))
}
