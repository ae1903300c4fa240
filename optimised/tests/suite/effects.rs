//! Stiff springs, close encounters, masses apart by twelve digits, forces that are no numbers.

use crate::suite::case::{Case, Kind, Measured};
use crate::suite::scenes::*;
use rattle::Error;
use rattle::composition::SUZUKI_1990_ORDER_4;
use rattle::error::{EffectFailure, StartFailure, StepFailure};
use rattle::nalgebra::Vector2;
use rattle::prelude::*;

const NONE: Pair = Pair { charge: 0.0, core: 0.0, size: 1.0, k: 0.0, rest: 1.0 };

pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let stiff = Kind {
        why: "near h·ω = 2 the method is at the edge of stability, and each rounding is magnified",
        expect: "the discrete solution, an oscillation of the rate 2 asin(hω/2)/h, for 1000 steps",
        reason: "n roundings of the angle, magnified by 1/√(1 − (hω/2)²)",
    };
    for reach in [1e-3, 0.1, 1.0, 1.9, 1.99_f64] {
        let bound = 1000.0 * E / (1.0 - reach * reach / 4.0).sqrt();
        cases.push(stiff.case(format!("spring with h·ω = {reach}"), bound, move || spring(reach)));
    }
    let kepler = Kind {
        why: "the force at the closest point is 10⁴ times that at the start: a step there is a blow",
        expect: "the angular momentum stays, whatever the step",
        reason: "ε of the products of closest place and largest momentum, at random over 20 000 steps",
    };
    for e in [0.5, 0.9, 0.99] {
        cases.push(kepler.case(format!("orbit of eccentricity {e}, angular momentum"), 1e-14, move || {
            let simulation = orbit(e, Rattle::new(1e-3))?;
            let first = turning(&simulation);
            largest(simulation, 20_000, move |now| (turning(now) - first).abs())
        }));
    }
    let near = Kind {
        why: "steps of one length are too long at the encounter or too short all else",
        expect: "with adaptive reversible steps the energy is back after five orbits",
        reason: "errors of a symmetric method come back as the bodies part",
    };
    for e in [0.9, 0.99] {
        cases.push(near.case(format!("orbit of eccentricity {e}, adaptive steps"), 1e-9, move || {
            let mut simulation = orbit(e, Variable::of(Rattle::new(0.01), 0.3))?;
            let energy = simulation.energy().abs();
            simulation.run_while(1_000_000, |now| now.time() < 5.0 * std::f64::consts::TAU)?;
            assert!(simulation.time() >= 5.0 * std::f64::consts::TAU, "five orbits");
            Ok(simulation.energy_error().abs() / energy)
        }));
    }
    let head = Kind {
        why: "a core r⁻¹² turns a body within one step of a tenth of its width: overshoot gives energy",
        expect: "the way back ends at the start",
        reason: "roundings magnified by the core's slope at the turn",
    };
    for speed in [1.0, 10.0, 100.0] {
        cases.push(head.case(
            format!("head-on against a core, speed {speed}, and back"),
            1e-15 * speed,
            move || head_on(speed),
        ));
    }
    let masses = Kind {
        why: "the light body's momentum is rounding beside the heavy one's",
        expect: "the sum of momenta stays",
        reason: "rounding of the force's two signs: none but that of the sums",
    };
    for ratio in [1e-3, 1e-6, 1e-12, 1e12] {
        cases.push(masses.case(format!("two bodies, masses 1 and {ratio:e}"), 4.0 * E * ratio, move || {
            let start = State::of([[0.0, 0.0], [1.0, 0.0]]).with_momenta([[0.0, 0.0], [0.0, ratio]]);
            let simulation = pairs(Pair { charge: -ratio, ..NONE }, &[1.0, ratio], start, Rattle::new(1e-3))?;
            largest(simulation, 10_000, move |now| {
                (now.momenta().sum::<Vector2<f64>>() - Vector2::new(0.0, ratio)).amax()
            })
        }));
    }
    let kicks = Kind {
        why: "sums over pairs in another order for each body are not opposite to the last bit",
        expect: "twenty bodies that push each other keep their centre of mass",
        reason: "2000 sums of 19 forces of size one times h, at random: 200 ε",
    };
    cases.push(kicks.case("gas of twenty", 5e-14, gas));
    let together = Kind {
        why: "U′/r is 0/0: no number, which spreads to all bodies",
        expect: "an error that names the effect",
        reason: "each is refused",
    };
    cases.push(together.case("two bodies at one place", 0.0, || {
        let start = State::of([[0.0, 0.0], [0.0, 0.0]]);
        let run = pairs(Pair { charge: 1.0, ..NONE }, &[1.0, 1.0], start, Rattle::new(0.01));
        Ok(unless(run, |error| {
            let Error::Start { cause: StartFailure::ForceNotFinite { effect, .. }, .. } = error else {
                return false;
            };
            effect.ends_with("Pair")
        }))
    }));
    let edge = Kind {
        why: "the force is no number where the step arrives: seen a step later, the state is lost",
        expect: "an error in the step that leads there; places and energy stay numbers",
        reason: "each is refused",
    };
    for h in [0.03, 0.001] {
        cases.push(edge.case(format!("off the edge of a potential, h = {h}"), 0.0, move || over_the_edge(h)));
    }
    let order = Kind {
        why: "an effect evaluated elsewhere than the method says costs an order in silence",
        expect: "order 4: half the step, a sixteenth of the error",
        reason: "the next term of the error: (h/2)² of the order",
    };
    cases.push(order.case("order of Suzuki's composition on an orbit", 0.01, || {
        let end = |h: f64| {
            let mut simulation = orbit(0.5, Composition::new(SUZUKI_1990_ORDER_4, h))?;
            simulation.run((2.0 / h).round() as u64)?;
            Ok::<_, Error>(simulation.state())
        };
        let exact = end(1e-3)?;
        let [coarse, fine] = [apart(&end(0.02)?, &exact), apart(&end(0.01)?, &exact)];
        Ok(((coarse / fine).log2() - 4.0).abs())
    }));
    let work = Kind {
        why: "gravity's energy is a difference of large numbers far above its zero",
        expect: "the energy error at a height of 10⁹ is that of the rounding there",
        reason: "the potential energy is rounded by ε·10⁹",
    };
    cases.push(work.case("pendulum at a height of 1e9", 2.0 * E * 1e9, || {
        let surface = |height| Quadric { centre: [0.0, 0.0, height], ..sphere(1.0) };
        let swing = |height: f64| {
            let mut simulation = on(surface(height), 1.0, State::at([1.0, 0.0, height]), Rattle::new(0.01))?;
            simulation.run(1000)?;
            Ok::<_, Error>(simulation.energy_error())
        };
        Ok((swing(1e9)? - swing(0.0)?).abs())
    }));
    cases
}

/// Two unit masses on a spring with ω² = 2 k, half a unit too long: how far their distance is off.
fn spring(reach: f64) -> Measured {
    let (omega, k) = (2.0_f64.sqrt() * 100.0, 1e4);
    let start = State::of([[-0.75, 0.0], [0.75, 0.0]]);
    let simulation = pairs(Pair { k, ..NONE }, &[1.0, 1.0], start, Rattle::new(reach / omega))?;
    largest(simulation, 1000, move |now| {
        let q: Vec<_> = now.positions().collect();
        let exact = 1.0 + 0.5 * (now.steps() as f64 * 2.0 * (reach / 2.0).asin()).cos();
        (q[1].x - q[0].x - exact).abs()
    })
}

/// A light body about a heavy one, half axis one, from its farthest place.
fn orbit<S: Method + 'static>(e: f64, method: S) -> Result<BoxedSimulation<2>, Error> {
    let speed = ((1.0 - e) / (1.0 + e)).sqrt();
    let start =
        State::of([[0.0, 0.0], [1.0 + e, 0.0]]).with_momenta([[0.0, -0.5 * speed], [0.0, 0.5 * speed]]);
    pairs(Pair { charge: -0.5, ..NONE }, &[1.0, 1.0], start, method)
}

fn turning(now: &BoxedSimulation<2>) -> f64 {
    now.positions().zip(now.momenta()).map(|(q, p)| q.x * p.y - q.y * p.x).sum()
}

fn head_on(speed: f64) -> Measured {
    let core = Pair { core: 1.0, size: 1.0, ..NONE };
    let start = State::of([[-1.5, 0.0], [1.5, 0.0]]).with_momenta([[speed, 0.01], [-speed, -0.01]]);
    let h = 1e-3 / speed;
    let mut there = pairs(core, &[1.0, 1.0], start.clone(), Rattle::new(h))?;
    there.run(3000)?;
    assert!(there.momenta().next().unwrap().x < 0.0, "it is turned back");
    let mut back = pairs(core, &[1.0, 1.0], there.state(), Rattle::new(-h))?;
    back.run(3000)?;
    Ok(apart(&back.state(), &start))
}

fn gas() -> Measured {
    let place = |i: u32| [f64::from(i % 5) + 0.1 * f64::from(i).sin(), f64::from(i / 5)];
    let push = Pair { charge: 1.0, core: 0.01, size: 0.5, ..NONE };
    let simulation = pairs(push, &[1.0; 20], State::of((0..20).map(place)), Rattle::new(1e-3))?;
    largest(simulation, 2000, |now| now.momenta().sum::<Vector2<f64>>().amax())
}

potential! {
    /// No number beyond x = 0.
    struct Edge {}
    |x, _y, _z| sqrt(x)
}

fn over_the_edge(h: f64) -> Measured {
    let scene = Scene::on(sphere(1.0)).with(Edge {});
    let start = scene.project(&at([0.3, 0.0, 1.0], [-1.0, 0.2, 0.0]))?;
    let mut simulation = scene.simulate(start, Rattle::new(h))?.boxed();
    let ended = simulation.run(10_000);
    let finite = place(&simulation).x >= 0.0 && simulation.energy().is_finite() && simulation.steps() > 0;
    let told = |error: &Error| {
        matches!(error, Error::Step { cause: StepFailure::Effect(EffectFailure::ForceNotFinite { .. }), .. })
    };
    Ok(unless(ended, told) + f64::from(!finite))
}
