//! Fingerprints of scene and method: the values that they give at a state and near it.
//!
//! The code of an expression cannot be compared at run time, but its values can. Masses, constraints, energies and each
//! effect alone are evaluated at positions that differ from those of the record by pseudo-random steps of a thousandth
//! or two, so that g is not zero there, and somewhat later, so that what changes with time counts at time 0 as well. So
//! parameters, expressions, masses, pins and the order of effects all count where they show in such values. What such
//! values need not show is compared by itself: parameters of methods, contacts and
//! [flows](crate::effect::Flow::parameters). Bodies on which an effect does not act there, as those out of each other's
//! reach, are drawn together until it does. What is still zero then, as a field that is elsewhere, does not count.

use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::effect::noise::Noise;
use crate::motion::bodies::Body;
use crate::motion::method::{Method, Stage};
use crate::motion::parts::Given;
use crate::motion::record::{Hallmark, short_name};
use crate::motion::system::System;
use crate::number::real::Real;
use std::any::type_name;
use std::array::from_fn;

/// It is looked beside a place by so much of a [size]; and after a time by so much of it, or of 1.
pub(in crate::run) const BESIDE: f64 = 1e-3;

/// Pairs of bodies on which an effect does not act are brought half as far from each other so many times.
const HALVINGS: i32 = 20;

/// The size of these numbers, which have a unit: the largest, rounded up to a power of two; 1 where all are zero.
fn size<'a>(numbers: impl Iterator<Item = &'a f64>) -> f64 {
    let most = numbers.fold(0.0_f64, |most, x| most.max(x.abs()));
    let power = f64::from_bits(most.to_bits() & f64::INFINITY.to_bits()); // without its digits
    match power {
        _ if most == 0.0 => 1.0,
        0.0 => f64::MIN_POSITIVE,
        _ if power == most || power > 1e300 => power,
        _ => 2.0 * power,
    }
}

/// Places and momenta beside these, each by a part of their own size.
#[inline(never)]
pub(in crate::run) fn beside<const D: usize>(bodies: &[Body<f64, D>]) -> Vec<Body<f64, D>> {
    let places = BESIDE * size(bodies.iter().flat_map(|body| &body.q));
    let momenta = BESIDE * size(bodies.iter().flat_map(|body| &body.p));
    let mut number = 0_u32;
    let mut aside = |x: f64, step: f64| {
        number += 1;
        x + step * ((f64::from(number) * 0.618_033_988_749_894_9).fract() - 0.3)
    };
    let zero = [0.0; D];
    let mut moved = |body: &Body<f64, D>| Body {
        q: body.q.map(|q| aside(q, places)),
        q_low: zero,
        p: body.p.map(|p| aside(p, momenta)),
        p_low: zero,
    };
    bodies.iter().map(&mut moved).collect()
}

/// The places of bodies, with the second one of each two at this part of its way from the first.
fn drawn_together<const D: usize>(bodies: &[Body<f64, D>], part: f64) -> Vec<[f64; D]> {
    let mut places: Vec<_> = bodies.iter().map(|body| body.q).collect();
    for [first, second] in places.as_chunks_mut().0 {
        *second = from_fn(|i| first[i] + part * (second[i] - first[i]));
    }
    places
}

/// The parts of a system, asked beside these bodies at this time.
pub(in crate::run) fn of_system<Y: System<f64, D>, const D: usize>(
    system: &Y,
    places: &[Body<f64, D>],
    time: f64,
) -> Vec<Hallmark> {
    let n = places.len();
    let later = time + BESIDE * time.abs().max(1.0);
    let near = beside(places);
    let mut bodies = system.bodies(&near, later);
    let equations = system.equations();
    let sizes = vec![n as f64, D as f64, equations as f64, Y::EFFECTS as f64, Y::FLOWS as f64];
    let mut marks = vec![Hallmark::new("system", system.kind(), sizes)];
    let (mut velocities, mut pinned) = (vec![[0.0; D]; n], vec![0.0; n]);
    for body in 0..n {
        velocities[body] = system.velocity(&bodies, body);
        pinned[body] = f64::from(u8::from(system.inertia().is_pinned(body)));
    }
    marks.push(Hallmark::new("masses", "a list", [velocities.as_flattened(), &pinned].concat()));
    marks.push(Hallmark::new("kinetic energy", "a function", vec![system.kinetic_energy(&bodies)]));
    let mut of_equations = vec![0.0; 2 * equations];
    let (g, rates) = of_equations.split_at_mut(equations);
    system.residuals(&bodies, g);
    system.drift_rates(&bodies, rates);
    marks.push(Hallmark::new("constraints", "a list", of_equations));
    for number in 0..Y::EFFECTS {
        let mut forces = vec![[0.0; D]; n];
        let name = system.add_force_alone(number, &mut bodies, &mut forces);
        // Flows have no name here, and parameters of their own.
        let acts = |forces: &[[f64; D]]| forces.as_flattened().iter().any(|&force| force != 0.0);
        if n > 1 && name.is_some() && !acts(&forces) {
            let mut room = system.effects().room(n);
            for halvings in 1..=HALVINGS {
                let positions = &drawn_together(&near, 0.5_f64.powi(halvings))[..];
                let at = Moment { time: later, positions };
                system.effects().contribute_alone(number, at, &mut room, &mut forces);
                if acts(&forces) {
                    break;
                }
            }
        }
        marks.push(of_effect(number, name, forces.as_flattened().to_vec()));
    }
    marks.push(Hallmark::new("potential energy", "a function", vec![system.potential_energy(&bodies)]));
    let momenta = Body::momenta(places);
    if Y::REMEMBERS {
        bodies.marks = system.first_marks(&bodies).unwrap_or_default();
    }
    let silent = Y::REMEMBERS && bodies.marks.is_empty(); // of effects that cannot act beside the places
    for number in 0..if silent { 0 } else { Y::FLOWS } {
        let (manner, name) = system.effects().manner(number);
        let noise = Noise { effect: number as u64, ..Noise::default() };
        let (velocities, rates, holding) = (&velocities[..], &momenta[..], &momenta[..]);
        let given = Given { velocities, rates, holding, coming: rates, ..Given::of(BESIDE, true, noise) };
        let mut changes = vec![[0.0; D]; n];
        system.flow(number, given, &mut bodies, &mut changes);
        let name = format!("{} ({manner})", short_name(name));
        marks.push(Hallmark::new(format!("flow {number}"), name, changes.as_flattened().to_vec()));
    }
    marks.extend((0..Y::FLOWS).filter_map(|number| of_flow(number, system.effects())));
    marks
}

/// The parameters of a flow that its changes of momenta need not show, if it names some.
pub(in crate::run) fn of_flow<T: Real, const D: usize>(
    number: usize,
    effects: &impl Forces<T, D>,
) -> Option<Hallmark> {
    let (parameters, name) = (effects.parameters(number), short_name(effects.manner(number).1));
    let part = format!("parameters of flow {number}");
    (!parameters.is_empty()).then(|| Hallmark::of_parameters(part, name, parameters))
}

/// As [`of_system`], of a lane. Momenta are left out: in lanes they run ahead by a kick, so that another force would be
/// told as other masses. In phase space H decides what velocities are, and comes before them.
pub(in crate::run) fn of_lane<Y: System<f64, D>, const D: usize>(
    system: &Y,
    places: &[Body<f64, D>],
) -> Vec<Hallmark> {
    let zero = [0.0; D];
    let places = places.iter().map(|body| Body { p: zero, p_low: zero, ..*body }).collect::<Vec<_>>();
    let mut marks = of_system(system, &places, 0.0);
    if system.rates().is_err() {
        let masses = marks.remove(1);
        marks.insert(2, masses);
    }
    marks
}

/// An effect of which the type has this name, and what it gives alone.
pub(in crate::run) fn of_effect(number: usize, name: Option<&str>, forces: Vec<f64>) -> Hallmark {
    Hallmark::new(format!("effect {number}"), short_name(name.unwrap_or("no potential")), forces)
}

/// What was asked for beside scene and method, each with a number.
pub(in crate::run) fn of_options(options: &[(&str, f64)]) -> Hallmark {
    let names: Vec<_> = options.iter().map(|option| option.0).collect();
    let names = if names.is_empty() { "none".into() } else { names.join(", ") };
    Hallmark::of_parameters("options", names, options.iter().map(|option| option.1).collect())
}

/// A method, with its step size and parameters, and the random numbers that it draws.
pub(in crate::run) fn of_method<S: Method>(method: &S) -> Hallmark {
    let name = format!("{} ({})", method.name(), short_name(type_name::<S>()));
    let (parameters, stages) = (method.parameters(), Stage::numbers(&method.stages()));
    let drawn = method.renewal().map_or_else(Vec::new, |renewal| renewal.numbers().to_vec());
    let numbers = [vec![method.step_size()], parameters, stages, drawn];
    Hallmark::of_parameters("method", name, numbers.concat())
}
