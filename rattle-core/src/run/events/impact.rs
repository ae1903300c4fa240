//! What an impact does to the momenta: the formula is that of [`contact`](crate::effect::contact).
//!
//! Several contacts that are closed at one instant are taken in the order of their kinds and numbers, again and
//! again, until no gap closes any more: so a row of balls that touch hands a blow on. Other orders may lead
//! elsewhere; Newton's laws do not decide.

use crate::motion::capability::Rates;
use crate::motion::method::Method;
use crate::motion::system::System;
use crate::number::vector::{add_scaled, dot, scaled, sum, two_sum};
use crate::run::events::meeting::{Meetings, Which};
use crate::run::events::stretch::Stretch;
use crate::run::trouble::Trouble;

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
                    return Err(meetings.rests(which, stretch.bodies.q.as_ref()).into());
                }
                impact(meetings, which, stretch)?;
                number += 1;
                meetings.impacts += 1;
            }
        }
        if number == so_far {
            return Ok(number);
        }
    }
}

/// Takes the impact of the contact that was looked at last.
fn impact<Y: System<f64, D>, S: Method, const D: usize>(
    meetings: &Meetings<D>,
    which: Which,
    stretch: &mut Stretch<'_, Y, S, D>,
) -> Result<(), Trouble> {
    let (system, bodies, [before, _]) = (stretch.system, &mut *stretch.bodies, &mut *stretch.aside);
    system.put_aside(bodies, before);
    // Where constraints move, P is that of a change of momenta.
    let moves = system.moves_with_time();
    if !moves {
        bodies.p.as_mut().fill([0.0; D]);
        bodies.p_low.as_mut().fill([0.0; D]);
    }
    for (body, gradient) in &meetings.gradient {
        let p = &mut bodies.p.as_mut()[*body];
        *p = sum(p, gradient);
    }
    system.settle(0.0, 1.0, bodies, &mut ())?;
    let (mut along, mut square) = (0.0, 0.0);
    for body in 0..bodies.p.as_ref().len() {
        let mut w = bodies.p.as_ref()[body];
        if moves {
            let low = add_scaled(&bodies.p_low.as_ref()[body], -1.0, &before.p_low.as_ref()[body]);
            w = sum(&add_scaled(&w, -1.0, &before.p.as_ref()[body]), &low);
        }
        let ones = [1.0; D];
        if system.rates().is_ok_and(|masses| masses.mass_product(body, &ones, &ones) <= 0.0) {
            w = [0.0; D]; // pinned
        }
        bodies.p.as_mut()[body] = w;
        let v = system.velocity(bodies, body);
        along += dot(&before.p.as_ref()[body], &v) + dot(&before.p_low.as_ref()[body], &v);
        square += dot(&w, &v);
    }
    let e = meetings.kinds[which.kind].restitution();
    let impulse = -(1.0 + e) * along / square;
    for body in 0..bodies.p.as_ref().len() {
        let change = scaled(impulse, &bodies.p.as_ref()[body]);
        let (p, p_low) = (before.p.as_ref()[body], before.p_low.as_ref()[body]);
        (bodies.p.as_mut()[body], bodies.p_low.as_mut()[body]) = two_sum(&p, &sum(&p_low, &change));
    }
    bodies.work = before.work - 0.5 * (1.0 - e * e) * along * along / square;
    Ok(())
}
