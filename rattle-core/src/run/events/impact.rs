//! The change of momenta by an impact, by the formula of [`contact`](crate::effect::contact).
//!
//! Several contacts that are closed at one instant are handled in the order of their kinds and numbers, again and
//! again, until no gap closes any more. So a row of touching balls passes an impact on. Other orders may give other
//! results; Newton's laws do not decide.

use crate::effect::interval::inverse_mass;
use crate::motion::method::Method;
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::number::twofold::Twofold;
use crate::number::vector::{add_scaled, dot, extent, larger_or_nan, largest, scaled, sum, two_sum};
use crate::run::events::meeting::{Meetings, TOUCHING, WhichContact};
use crate::run::events::stretch::Stretch;
use crate::run::trouble::Trouble;
use std::array::from_fn;

/// So many roundings of the terms of w·∇gap are none: less is left where ∇gap is a normal of the constraints to 1e-7,
/// and w is no more than that part of it.
const ROUNDINGS: f64 = 16.0;

/// Takes all impacts at the present place, at most so many; says how many.
pub(super) fn impacts<Y: System<f64, D>, S: Method, const D: usize>(
    meetings: &mut Meetings<D>,
    stretch: &mut Stretch<'_, Y, S, D>,
    most: u64,
) -> Result<u64, Trouble> {
    let mut number = 0;
    loop {
        let so_far = number;
        for i in 0..meetings.near.len() {
            let which = meetings.near[i];
            if meetings.look(which, stretch.sign(), stretch.system, stretch.bodies).meets() {
                if number == most {
                    return Err(meetings.too_many(which).into());
                }
                if !impact(meetings, which, stretch)? {
                    continue;
                }
                number += 1;
                meetings.impacts += 1;
                let restitution = meetings.kinds[which.kind].restitution();
                meetings.restitution = meetings.restitution.min(restitution);
            }
        }
        if number == so_far {
            return Ok(number);
        }
    }
}

/// What an impulse along w = P ∇gap does to a contact.
struct Push {
    /// Whether ∇gap·v is w·v, to the last bit.
    plain: bool,
    /// p·M⁻¹w and w·M⁻¹w.
    along: Twofold,
    square: Twofold,
    /// ∇gap·M⁻¹p and ∇gap·M⁻¹w.
    closes: Twofold,
    answer: Twofold,
}

/// What constraints leave of an impulse along the gradient of a gap.
enum Answer {
    Parts(Push),
    /// Nothing, and they hold the gap as it is.
    Holds,
    /// Nothing, and the gap closes.
    GivesNoWay,
}

/// Whether constraints hold the gap of this contact where the stretch begins: bodies are there then, with momenta of
/// any kind.
#[cold]
pub(super) fn holds<Y: System<f64, D>, S: Method, const D: usize>(
    meetings: &mut Meetings<D>,
    which: WhichContact,
    stretch: &mut Stretch<'_, Y, S, D>,
) -> Result<bool, Trouble> {
    stretch.go_back();
    meetings.look(which, stretch.sign(), stretch.system, stretch.bodies);
    Ok(matches!(answer(meetings, stretch)?, Answer::Holds))
}

/// Takes the impact of the contact that was looked at last, unless constraints hold its gap, whose rate is rounding
/// then; says whether there was one.
fn impact<Y: System<f64, D>, S: Method, const D: usize>(
    meetings: &Meetings<D>,
    which: WhichContact,
    stretch: &mut Stretch<'_, Y, S, D>,
) -> Result<bool, Trouble> {
    let answer = answer(meetings, stretch)?;
    let (system, bodies, before) = (stretch.system, &mut *stretch.bodies, &stretch.aside[0]);
    let Push { plain, along, square, closes, answer } = match answer {
        Answer::Parts(push) => push,
        Answer::Holds => {
            system.put_back(bodies, before);
            return Ok(false);
        }
        Answer::GivesNoWay => return Err(meetings.gives_no_way(which).into()),
    };
    let e = meetings.kinds[which.kind].restitution();
    let ratio = closes.over(answer);
    let impulses = [ratio.high, e * ratio.high, ratio.low, e * ratio.low]; // their sum, turned round
    for body in 0..bodies.p.as_ref().len() {
        let (p, p_low) = (before.p.as_ref()[body], before.p_low.as_ref()[body]);
        let w = bodies.p.as_ref()[body];
        let after: [Twofold; D] = from_fn(|i| {
            let p = Twofold { high: p[i], low: p_low[i] };
            impulses.iter().fold(p, |p, impulse| p.plus_product(-impulse, w[i]))
        });
        (bodies.p.as_mut()[body], bodies.p_low.as_mut()[body]) =
            two_sum(&after.map(|p| p.high), &after.map(|p| p.low));
    }
    // J w·v + J² w·M⁻¹w/2, where constraints give or take what the gap does not lose.
    let impulse = (1.0 + e) * ratio.high;
    let lost = match plain {
        true => 0.5 * (1.0 - e * e) * along.high * ratio.high,
        false => impulse * (along.high - 0.5 * impulse * square.high),
    };
    bodies.work = before.work - lost;
    Ok(true)
}

/// What constraints leave of an impulse along the gradient of the contact that was looked at last. Bodies are where
/// they were, with w for momenta, and as they were in the first place aside.
fn answer<Y: System<f64, D>, S: Method, const D: usize>(
    meetings: &Meetings<D>,
    stretch: &mut Stretch<'_, Y, S, D>,
) -> Result<Answer, Trouble> {
    let (system, bodies, [before, still, ..]) = (stretch.system, &mut *stretch.bodies, &mut *stretch.aside);
    system.put_aside(bodies, before);
    let at_rest = |bodies: &mut BodiesOf<Y, f64, D>| {
        bodies.p.as_mut().fill([0.0; D]);
        bodies.p_low.as_mut().fill([0.0; D]);
    };
    // Where constraints move, P takes bodies at rest along: it is what is added to that.
    let moves = system.constraints_move();
    at_rest(bodies);
    if moves {
        system.settle(0.0, 1.0, bodies, &mut ())?;
        system.put_aside(bodies, still);
        at_rest(bodies);
    }
    // As large as what constraints give, which is subtracted: any multiple of ∇gap does.
    let given = if moves { still.p.as_ref().iter().map(largest).fold(0.0, f64::max) } else { 0.0 };
    let steep = meetings.gradient.iter().map(|(_, gradient)| largest(gradient)).fold(0.0, f64::max);
    let scale = if moves && given / steep < f64::MAX { (given / steep).max(1.0) } else { 1.0 };
    for (body, gradient) in &meetings.gradient {
        bodies.p.as_mut()[*body] = scaled(scale, gradient);
    }
    system.settle(0.0, 1.0, bodies, &mut ())?;
    // Momenta along constraints that rest, and give way along their normals: ∇gap·v is w·v, to the last bit.
    let plain = !moves && system.pulls_along_normals();
    // The same few places are met again and again: the last bit of an impulse would not average out.
    let (mut along, mut square) = (Twofold::default(), Twofold::default());
    let (mut closes, mut answer) = (Twofold::default(), Twofold::default());
    let (inertia, mut terms, mut most) = (system.inertia(), 0.0, 0.0);
    for body in 0..bodies.p.as_ref().len() {
        let mut w = bodies.p.as_ref()[body];
        if moves {
            let low = add_scaled(&bodies.p_low.as_ref()[body], -1.0, &still.p_low.as_ref()[body]);
            w = sum(&add_scaled(&w, -1.0, &still.p.as_ref()[body]), &low);
        }
        if inertia.is_pinned(body) {
            w = [0.0; D];
        }
        bodies.p.as_mut()[body] = w;
        most = larger_or_nan(most, extent(&w));
        let gradient = meetings.gradient.iter().find(|of| of.0 == body).map_or([0.0; D], |of| of.1);
        let (p, p_low) = (before.p.as_ref()[body], before.p_low.as_ref()[body]);
        for (i, column) in inverse_mass(inertia, body).iter().enumerate() {
            let v = column.iter().zip(&w).fold(Twofold::default(), |v, (m, w)| v.plus_product(*m, *w));
            along = along.plus_multiple(p[i], v).plus_product(p_low[i], v.high);
            square = square.plus_multiple(w[i], v);
            if !plain {
                let u =
                    column.iter().zip(&gradient).fold(Twofold::default(), |u, (m, n)| u.plus_product(*m, *n));
                terms += u.high.abs();
                closes = closes.plus_multiple(p[i], u).plus_product(p_low[i], u.high);
                answer = answer.plus_multiple(w[i], u);
            }
        }
    }
    let nothing = if plain {
        (closes, answer) = (along, square);
        most <= (ROUNDINGS * f64::EPSILON).sqrt() * steep
    } else {
        answer.high <= ROUNDINGS * f64::EPSILON * terms * (scale * steep + given)
    };
    if !nothing {
        return Ok(Answer::Parts(Push { plain, along, square, closes, answer }));
    }
    // What constraints that rest leave nothing of has no rate; others may take bodies there.
    let (mut rate, mut speeds) = (0.0_f64, 0.0);
    for (body, gradient) in &meetings.gradient {
        let v = system.velocity(before, *body);
        rate += dot(gradient, &v);
        speeds += (dot(gradient, gradient) * dot(&v, &v)).sqrt();
    }
    let holds = plain || rate.abs() <= TOUCHING * f64::EPSILON * speeds;
    Ok(if holds { Answer::Holds } else { Answer::GivesNoWay })
}
