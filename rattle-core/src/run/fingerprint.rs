//! Fingerprints of scene and method: the values that they give at a state and near it.
//!
//! The code of an expression cannot be compared at run time, but its values can. Masses, constraints, energies and each
//! effect alone are evaluated at positions that differ from those of the record by pseudo-random steps of a thousandth
//! or two, so that g is not zero there, and somewhat later, so that what changes with time counts at time 0 as well;
//! and at the positions themselves, since a thousandth of the way from the origin may be far from all that acts there.
//! So parameters, expressions, masses, pins and the order of effects all count where they show in such values. What
//! such values need not show is compared by itself: parameters of methods, contacts and
//! [flows](crate::effect::Flow::parameters). Bodies on which an effect does not act there, as those out of each other's
//! reach, are drawn together until it does. What is still zero then, as a field that is elsewhere, does not count.
//!
//! The velocity of each body, each equation and the force on each body (in phase space what its momentum changes by) is
//! compared by its own size, or by what [roundings](Looks::rounded) of the positions make of it.

use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::effect::noise::Noise;
use crate::motion::bodies::{Body, Count};
use crate::motion::method::{Method, Stage};
use crate::motion::parts::{BodiesOf, Given};
use crate::motion::record::{Hallmark, short_name};
use crate::motion::system::System;
use crate::number::real::Real;
use std::any::type_name;
use std::array::from_fn;

/// It is looked beside a place by so much of a [size]; and after a time by so much of it, or of 1.
pub(in crate::run) const BESIDE: f64 = 1e-3;

/// Places and momenta are rounded otherwise by so much of their size: some roundings of a double.
const ROUNDED: f64 = 1.4e-14;

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

/// These bodies, each number of their places and momenta moved by a part of the size of all of its kind. `part` makes
/// it of numbers that fill [0, 1) evenly, times `most`.
#[inline(never)]
pub(in crate::run) fn moved<const D: usize>(
    bodies: &[Body<f64, D>],
    most: f64,
    part: fn(f64) -> f64,
) -> Vec<Body<f64, D>> {
    let places = most * size(bodies.iter().flat_map(|body| &body.q));
    let momenta = most * size(bodies.iter().flat_map(|body| &body.p));
    let mut number = 0_u32;
    let mut aside = |x: f64, step: f64| {
        number += 1;
        x + step * part((f64::from(number) * 0.618_033_988_749_894_9).fract())
    };
    let mut moved = |body: &Body<f64, D>| Body {
        q: body.q.map(|q| aside(q, places)),
        p: body.p.map(|p| aside(p, momenta)),
        ..*body
    };
    bodies.iter().map(&mut moved).collect()
}

/// Places and momenta beside these, each by a part of their own size.
fn beside<const D: usize>(bodies: &[Body<f64, D>]) -> Vec<Body<f64, D>> {
    let zero = [0.0; D];
    let mut beside = moved(bodies, BESIDE, |even| even - 0.3);
    beside.iter_mut().for_each(|body| (body.q_low, body.p_low) = (zero, zero));
    beside
}

/// The same places and momenta but for some roundings.
fn rounded<const D: usize>(bodies: &[Body<f64, D>]) -> Vec<Body<f64, D>> {
    moved(bodies, ROUNDED, |even| {
        let part = even - 0.5;
        part + 0.5_f64.copysign(part) // in no direction none
    })
}

/// Where a system is asked: beside its places, and at them.
pub(in crate::run) struct Looks<const D: usize> {
    near: Vec<Body<f64, D>>,
    at: Vec<Body<f64, D>>,
    /// The same with the momenta of the bodies.
    moving: [Vec<Body<f64, D>>; 2],
}

impl<const D: usize> Looks<D> {
    /// Of these bodies.
    pub(in crate::run) fn of(bodies: &[Body<f64, D>]) -> Self {
        let (near, at) = (beside(bodies), bodies.to_vec());
        Self { moving: [near.clone(), at.clone()], near, at }
    }

    /// Of bodies in lanes, without their momenta: these run ahead there by a kick, so that another force would be told
    /// as other masses.
    pub(in crate::run) fn in_lanes(bodies: Vec<Body<f64, D>>) -> Self {
        let zero = [0.0; D];
        let at_rest: Vec<_> = bodies.iter().map(|body| Body { p: zero, p_low: zero, ..*body }).collect();
        Self { moving: [beside(&bodies), bodies], ..Self::of(&at_rest) }
    }

    /// The same with the momenta of the bodies.
    pub(in crate::run) fn in_motion(&self) -> Self {
        let [near, at] = self.moving.clone();
        Self { near, at, moving: self.moving.clone() }
    }

    /// The same but for some roundings. What these make of a number is what other machines may.
    pub(in crate::run) fn rounded(&self) -> Self {
        let [near, at] = &self.moving;
        Self { near: rounded(&self.near), at: rounded(&self.at), moving: [rounded(near), rounded(at)] }
    }

    /// The position of the first body beside its place, and there.
    pub(in crate::run) fn first(&self) -> [[f64; D]; 2] {
        [self.near[0].q, self.at[0].q]
    }

    /// Its momentum, also where these are looks at bodies without.
    pub(in crate::run) fn first_momentum(&self) -> [f64; D] {
        self.moving[1][0].p
    }
}

/// These marks, where as much is allowed as the same ones at rounded places tell.
pub(in crate::run) fn allowing(mut marks: Vec<Hallmark>, at_rounded: &[Hallmark]) -> Vec<Hallmark> {
    marks.iter_mut().zip(at_rounded).for_each(|(mark, rounded)| mark.allow(rounded));
    marks
}

/// The places of bodies, with the second one of each two at this part of its way from the first.
fn drawn_together<const D: usize>(bodies: &[Body<f64, D>], part: f64) -> Vec<[f64; D]> {
    let mut places: Vec<_> = bodies.iter().map(|body| body.q).collect();
    for [first, second] in places.as_chunks_mut().0 {
        *second = from_fn(|i| first[i] + part * (second[i] - first[i]));
    }
    places
}

/// The parts of a system, asked there at this time; its flows also as they act in a step of h.
pub(in crate::run) fn of_system<Y: System<f64, D>, const D: usize>(
    system: &Y,
    looks: &Looks<D>,
    time: f64,
    h: f64,
) -> Vec<Hallmark> {
    let Looks { near, at, .. } = looks;
    let n = near.len();
    let (later, next) = (time + BESIDE * time.abs().max(1.0), time + h);
    let mut bodies = system.bodies(near, later);
    let equations = system.equations();
    let sizes = vec![n as f64, D as f64, equations as f64, Y::EFFECTS as f64, Y::FLOWS as f64];
    let mut marks = vec![Hallmark::new("system", system.kind(), sizes)];
    let (mut velocities, mut pinned) = (vec![[0.0; D]; n], vec![0.0; n]);
    for body in 0..n {
        velocities[body] = system.velocity(&bodies, body);
        pinned[body] = f64::from(u8::from(system.inertia().is_pinned(body)));
    }
    marks.push(of_masses(&velocities, &pinned));
    marks.push(Hallmark::new("kinetic energy", "a function", vec![system.kinetic_energy(&bodies)]));
    marks.push(of_equations(system, &bodies));
    marks.extend(of_pushes(system, &bodies).map(Hallmark::later));
    for number in 0..Y::EFFECTS {
        let mut forces = vec![[0.0; D]; n];
        let name = system.add_force_alone(number, &mut bodies, &mut forces);
        // Flows have no name here, and parameters of their own.
        if const { Y::Count::MANY } && n > 1 && name.is_some() && !act(&forces) {
            let mut room = system.effects().room(n);
            for halvings in 1..=HALVINGS {
                let positions = &drawn_together(near, 0.5_f64.powi(halvings))[..];
                let at = Moment { time: later, positions };
                system.effects().contribute_alone(number, at, &mut room, &mut forces);
                if act(&forces) {
                    break;
                }
            }
        }
        marks.push(of_effect(number, name, &forces));
    }
    marks.push(Hallmark::new("potential energy", "a function", vec![system.potential_energy(&bodies)]));
    if const { Y::FLOWS > 0 } {
        marks.extend(of_flows(system, looks, later, BESIDE));
        marks.extend((0..Y::FLOWS).filter_map(|number| of_flow(number, system.effects())));
    }
    tell(at_places(system, near, at, later), AT_ITS_PLACES, &mut marks);
    if system.moves_with_time() {
        tell(at_places(system, near, at, next), "after a step", &mut marks);
    }
    if const { Y::FLOWS > 0 } {
        tell(of_flows(system, &looks.in_motion(), next, h.abs()), IN_A_STEP, &mut marks);
    }
    marks
}

/// Whether one of these forces is not zero.
fn act<const D: usize>(forces: &[[f64; D]]) -> bool {
    forces.as_flattened().iter().any(|&force| force != 0.0)
}

/// Velocities, and whether bodies are pinned.
fn of_masses<const D: usize>(velocities: &[[f64; D]], pinned: &[f64]) -> Hallmark {
    let masses: Vec<_> = velocities.iter().map(|v| &v[..]).chain([pinned]).collect();
    Hallmark::of_vectors("masses", "a list", &masses)
}

/// Adds these marks, each as [`told`] makes it.
pub(in crate::run) fn tell(marks: Vec<Hallmark>, how: &str, to: &mut Vec<Hallmark>) {
    to.extend(marks.into_iter().map(|mark| told(mark, how)));
}

/// What flows do there at this time, for so long.
fn of_flows<Y: System<f64, D>, const D: usize>(
    system: &Y,
    Looks { near, at, .. }: &Looks<D>,
    time: f64,
    during: f64,
) -> Vec<Hallmark> {
    let mut bodies = system.bodies(near, time);
    let velocities: Vec<_> = (0..near.len()).map(|body| system.velocity(&bodies, body)).collect();
    let momenta = Body::momenta(at);
    if Y::REMEMBERS {
        bodies.marks = system.first_marks(&bodies).unwrap_or_default();
    }
    let silent = Y::REMEMBERS && bodies.marks.is_empty(); // of effects that cannot act beside the places
    let mark = |number: usize| {
        let (manner, name) = system.effects().manner(number);
        let noise = Noise { effect: number as u64, ..Noise::default() };
        let (velocities, rates, holding) = (&velocities[..], &momenta[..], &momenta[..]);
        let given = Given { velocities, rates, holding, coming: rates, ..Given::of(during, true, noise) };
        let mut changes = vec![[0.0; D]; near.len()];
        system.flow(number, given, &mut bodies, &mut changes);
        let name = format!("{} ({manner})", short_name(name));
        Hallmark::new(format!("flow {number}"), name, changes.as_flattened().to_vec())
    };
    (0..if silent { 0 } else { Y::FLOWS }).map(mark).collect()
}

/// The equations of a system: g and its rates.
fn of_equations<Y: System<f64, D>, const D: usize>(system: &Y, bodies: &BodiesOf<Y, f64, D>) -> Hallmark {
    let mut numbers = vec![0.0; 2 * system.equations()];
    let (g, rates) = numbers.split_at_mut(system.equations());
    system.residuals(bodies, g);
    system.drift_rates(bodies, rates);
    Hallmark::of_parameters("constraints", "a list", numbers)
}

/// What momenta change by where there are no masses. H need not show it, of which it may be less than a rounding.
fn of_pushes<Y: System<f64, D>, const D: usize>(
    system: &Y,
    bodies: &BodiesOf<Y, f64, D>,
) -> Option<Hallmark> {
    let mut pushes = vec![[0.0; D]; bodies.q.as_ref().len()];
    if system.rates().is_ok() || system.pushes(bodies, &mut pushes).is_err() {
        return None;
    }
    let pushes: Vec<_> = pushes.iter().map(|push| &push[..]).collect();
    Some(Hallmark::of_vectors("rates of momenta", "a list", &pushes))
}

/// The former bodies at the places of the latter.
fn put_at<const D: usize>(near: &[Body<f64, D>], at: &[Body<f64, D>]) -> Vec<Body<f64, D>> {
    near.iter().zip(at).map(|(near, at)| Body { q: at.q, ..*near }).collect()
}

/// Constraints, energies and forces at the places themselves, with momenta beside those of the bodies.
fn at_places<Y: System<f64, D>, const D: usize>(
    system: &Y,
    near: &[Body<f64, D>],
    at: &[Body<f64, D>],
    time: f64,
) -> Vec<Hallmark> {
    let mut bodies = system.bodies(&put_at(near, at), time);
    let mut energies = vec![system.kinetic_energy(&bodies)];
    system.effect_energies(&bodies, &mut energies);
    let mut marks = vec![of_equations(system, &bodies)];
    marks.extend(of_pushes(system, &bodies));
    for number in 0..Y::EFFECTS {
        let mut forces = vec![[0.0; D]; at.len()];
        let name = system.add_force_alone(number, &mut bodies, &mut forces);
        if name.is_some() {
            marks.push(of_effect(number, name, &forces));
        }
    }
    marks.push(Hallmark::of_parameters("energies", "a list", energies));
    marks
}

/// Of the places themselves.
pub(in crate::run) const AT_ITS_PLACES: &str = "at its places";
/// Of bodies with their momenta.
pub(in crate::run) const IN_MOTION: &str = "in motion";
/// Of what flows do in a step, which tells rates from others that are too fast to be told after [`BESIDE`].
pub(in crate::run) const IN_A_STEP: &str = "in a step";

/// The same part, asked so; records of before do not tell of it.
pub(in crate::run) fn told(mark: Hallmark, how: &str) -> Hallmark {
    Hallmark { part: format!("{} {how}", mark.part), ..mark }.later()
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

/// As [`of_system`], of a lane that takes steps of h. In phase space H decides what velocities are, and comes before
/// them.
pub(in crate::run) fn of_lane<Y: System<f64, D>, const D: usize>(
    system: &Y,
    looks: &Looks<D>,
    h: f64,
) -> Vec<Hallmark> {
    let mut marks = of_system(system, looks, 0.0, h);
    if system.rates().is_err() {
        let masses = marks.remove(1);
        marks.insert(2, masses);
    }
    marks
}

/// An effect of which the type has this name, and what it gives alone.
pub(in crate::run) fn of_effect<const D: usize>(
    number: usize,
    name: Option<&str>,
    forces: &[[f64; D]],
) -> Hallmark {
    let (part, name) = (format!("effect {number}"), short_name(name.unwrap_or("no potential")));
    Hallmark::of_vectors(part, name, &forces.iter().map(|force| &force[..]).collect::<Vec<_>>())
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
