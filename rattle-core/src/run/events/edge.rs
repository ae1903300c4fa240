//! Crossing an edge of a constraint: where its normal jumps, momenta are rotated from one side into the other.
//!
//! ```text
//! u₁ = P₁n₂/|P₁n₂|,   u₂ = P₂n₁/|P₂n₁|        n: the normals of the two sides, P: onto momenta along each, | | by M⁻¹
//! p⁺ = p − (p·M⁻¹u₁)(u₁ + u₂)                 what is along the edge is kept, what is across it is turned
//! ```
//!
//! This is the rotation about the edge that takes n₁ to n₂. Kinetic energy is conserved, and a free particle moves
//! straight on if the two sides are unfolded into a plane. It is the limit of smooth surfaces with an ever smaller
//! radius at the edge. Where two edges meet, limits differ, and the step fails.

use crate::error::StepFailure;
use crate::motion::bodies::Saved;
use crate::motion::capability::Rates;
use crate::motion::failure::Failure;
use crate::motion::method::Method;
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::number::vector::{add_scaled, dot, scaled, sum, two_sum};
use crate::run::events::stretch::Stretch;
use crate::run::trouble::Trouble;

/// Rounds of the search; each takes eighteen bits of the bracket, or one.
const ROUNDS: u32 = 80;
/// How often the way beyond the edge is doubled, from a rounding on.
const DOUBLINGS: u32 = 20;
/// The turned momenta must have the length that energy asks for, to this: less is left by rounding, more where a
/// second edge is passed.
const KEPT: f64 = 1e-6;

/// An edge ahead.
#[derive(Debug, Clone)]
pub(super) struct Edge {
    /// The kink.
    pub(super) failure: Failure,
    /// How long from there to the other side, by rounding.
    beyond: f64,
}

/// The edge on the way of a stretch that cannot be gone this far: after how long. Bodies are then put before it.
pub(super) fn edge<Y: System<f64, D>, S: Method, const D: usize>(
    stretch: &mut Stretch<'_, Y, S, D>,
    length: f64,
) -> Result<Option<(Edge, f64)>, Trouble> {
    let halvings = std::mem::replace(&mut stretch.halvings, 0..=0);
    stretch.system.put_aside(stretch.start, &mut stretch.aside[0]);
    let (mut low, mut high) = (0.0, length);
    for _ in 0..ROUNDS {
        let width = high - low;
        if width <= 2.0 * f64::EPSILON * high {
            break;
        }
        let tries = if let Some(Failure { cause: StepFailure::Kink { share, .. }, .. }) =
            ahead(stretch, width)
        {
            let (about, slack) = (low + share * width, (width / 262_144.0).max(2.0 * f64::EPSILON * high));
            [about - slack, about + slack]
        } else {
            [low + 0.5 * width; 2]
        };
        for at in tries {
            if !(low < at && at < high) {
                continue;
            }
            if stretch.go(at).is_ok() {
                low = at;
                stretch.system.put_aside(stretch.bodies, &mut stretch.aside[0]);
            } else {
                high = at;
            }
        }
    }
    // As the last one that is told of.
    if low > 0.0 {
        stretch.go(low)?
    } else {
        stretch.go_back()
    }
    stretch.halvings = halvings;
    let times = (0..stretch.aside[0].q.as_ref().len()).map(|body| {
        let v = stretch.system.velocity(&stretch.aside[0], body);
        let q = stretch.aside[0].q.as_ref()[body];
        f64::EPSILON * (dot(&q, &q) / dot(&v, &v)).sqrt()
    });
    // Of the fastest body; in the origin any will do.
    let least = f64::max(2.0 * f64::EPSILON * high, f64::EPSILON * f64::EPSILON * length);
    let fastest = times.filter(|&time| time > 0.0).fold(f64::INFINITY, f64::min);
    let mut beyond = if fastest.is_finite() { least.max(fastest) } else { least };
    for _ in 0..DOUBLINGS {
        if let Some(failure) = ahead(stretch, beyond) {
            stretch.system.put_back(stretch.bodies, &stretch.aside[0]);
            return Ok(Some((Edge { failure, beyond }, low)));
        }
        beyond *= 4.0;
    }
    Ok(None)
}

/// The kink on a straight way for this time from the place that is put aside.
fn ahead<Y: System<f64, D>, S: Method, const D: usize>(
    stretch: &mut Stretch<'_, Y, S, D>,
    time: f64,
) -> Option<Failure> {
    let time = stretch.sign() * time;
    stretch.bodies.restore(&stretch.aside[0]);
    shift(stretch.system, stretch.bodies, time);
    stretch.system.check_kinks(&stretch.aside[0], stretch.bodies).err()
}

/// Goes straight on for this time.
fn shift<Y: System<f64, D>, const D: usize>(system: &Y, bodies: &mut BodiesOf<Y, f64, D>, time: f64) {
    for body in 0..bodies.q.as_ref().len() {
        let v = system.velocity(bodies, body);
        let (q, low) = (bodies.q.as_ref()[body], bodies.q_low.as_ref()[body]);
        (bodies.q.as_mut()[body], bodies.q_low.as_mut()[body]) = two_sum(&q, &sum(&low, &scaled(time, &v)));
    }
}

/// Takes bodies, which are before the edge, over it; says how long that took.
pub(super) fn cross<Y: System<f64, D>, S: Method, const D: usize>(
    stretch: &mut Stretch<'_, Y, S, D>,
    edge: Edge,
    normals: &mut [Vec<[f64; D]>; 2],
) -> Result<f64, Trouble> {
    let (system, sign, bodies) = (stretch.system, stretch.sign(), &mut *stretch.bodies);
    let [before, after, ..] = &mut *stretch.aside;
    let [first, second] = normals;
    system.put_aside(bodies, before);
    let energy = system.kinetic_energy(before) + system.potential_energy(before);
    system.kinked_normal(bodies, &edge.failure, first);

    // Straight on, off the surface by rounding, normals are those of the other side.
    beyond(system, before, bodies, sign * edge.beyond).ok_or_else(|| edge.failure.clone())?;
    system.put_aside(bodies, after);
    system.put_back(bodies, after);
    system.kinked_normal(bodies, &edge.failure, second);

    // n₁ becomes u₂, n₂ becomes u₁.
    along(system, bodies, first)?;
    system.put_back(bodies, before);
    along(system, bodies, second)?;
    let across: f64 =
        second.iter().enumerate().map(|(body, u1)| dot(u1, &system.velocity(before, body))).sum();
    for (body, (u2, u1)) in first.iter().zip(second.iter()).enumerate() {
        let change = scaled(-across, &sum(u1, u2));
        let (p, low) = (&mut before.p.as_mut()[body], &mut before.p_low.as_mut()[body]);
        (*p, *low) = two_sum(p, &sum(low, &change));
    }

    // With the new momenta along the new side; the way is some roundings long, and takes time, under forces.
    let time = beyond(system, before, bodies, sign * edge.beyond).ok_or_else(|| edge.failure.clone())?;
    if let Ok(rates) = system.rates() {
        rates.project(time, bodies)?;
    }
    system.settle(time, time, bodies, &mut ())?;
    bodies.work = before.work;
    let factor = ((energy - system.potential_energy(bodies)) / system.kinetic_energy(bodies)).sqrt();
    let kept = (factor - 1.0).abs() < KEPT;
    if !kept {
        return Err(edge.failure.into());
    }
    for (p, low) in bodies.p.as_mut().iter_mut().zip(bodies.p_low.as_mut()) {
        (*p, *low) = two_sum(p, &add_scaled(low, factor - 1.0, p));
    }
    Ok(time.abs())
}

/// Goes straight on until beyond the edge, by more than rounding may take back; says how long.
fn beyond<Y: System<f64, D>, const D: usize>(
    system: &Y,
    before: &Saved<Y::Count, f64, D>,
    bodies: &mut BodiesOf<Y, f64, D>,
    mut time: f64,
) -> Option<f64> {
    let mut passed = 0;
    for _ in 0..DOUBLINGS {
        bodies.restore(before);
        shift(system, bodies, time);
        passed = if system.check_kinks(before, bodies).is_err() { passed + 1 } else { 0 };
        if passed == 3 {
            return Some(time);
        }
        time *= 4.0;
    }
    None
}

/// The part of a covector that is along the constraints where bodies are, of length 1; their momenta are lost.
fn along<Y: System<f64, D>, const D: usize>(
    system: &Y,
    bodies: &mut BodiesOf<Y, f64, D>,
    covector: &mut [[f64; D]],
) -> Result<(), Failure> {
    bodies.p.as_mut().copy_from_slice(covector);
    bodies.p_low.as_mut().fill([0.0; D]);
    system.settle(0.0, 1.0, bodies, &mut ())?;
    let length = (2.0 * system.kinetic_energy(bodies)).sqrt();
    for (part, p) in covector.iter_mut().zip(bodies.p.as_ref()) {
        *part = scaled(1.0 / length, p);
    }
    Ok(())
}
