//! Whether a stretch is short enough for its ends to tell where bodies are in between.
//!
//! By a method that divides its steps, or of high order, bodies may go round and round within a stretch, and what they
//! meet there cannot be seen from its ends. They tell where the velocity and the acceleration at the end lead back to
//! its start:
//!
//! ```text
//! q₀ ≈ q₁ − s v₁ + s²/2 a₁     off by s³/6 times the third derivative of q
//! v₀ ≈ v₁ − s a₁               off by s²/2 times it
//! ```
//!
//! Of 4000 phases of an oscillation none passes for short where a stretch takes 0.41 to 1.3 periods, and of longer ones
//! up to 1.5 of 100: so steps that are divided, by their method or because they failed, are looked at in parts of few
//! inner steps.
//!
//! The acceleration is that of forces and constraints; where it does not lead back, that of flows is added. So it is 0
//! for a body that dry friction holds.

use crate::effect::interval::Half;
use crate::motion::capability::Rates;
use crate::motion::method::{Method, Splitting};
use crate::motion::stir::{Chosen, SHORTLY, push};
use crate::motion::system::System;
use crate::number::vector::{add_scaled, dot, largest, scaled, sum};
use crate::run::events::stretch::Stretch;
use crate::run::events::{FEW_INNER, Search};

/// By these parts of its way a body may be elsewhere than it is led back to, and its velocity times the length of the
/// stretch be another: on a circle after 0.55 radians.
const ELSEWHERE: [f64; 2] = [0.05, 0.15];

/// By this part of the largest way of all bodies any body may be elsewhere: what hardly moves closes no gap unnoticed.
/// By this part of the way that it would go without flows, too.
const HARDLY: f64 = 1e-6;

/// Ways of less than so many roundings of places tell nothing.
const ROUNDINGS: f64 = 64.0;

impl<const D: usize> Search<D> {
    /// Whether the ends of a stretch of this length, at the end of which bodies are, tell where they are in between.
    /// They do after a step of one stage, which cannot be long.
    #[inline(always)]
    pub(super) fn is_resolved<Y: System<f64, D>, S: Method>(
        &mut self,
        stretch: &mut Stretch<'_, Y, S, D>,
        length: f64,
    ) -> bool {
        let is_one = const { matches!(S::SPLITTING, Splitting::OneStage) };
        (is_one && stretch.parts() == 1) || self.is_led_back(stretch, length)
    }

    #[inline(never)]
    fn is_led_back<Y: System<f64, D>, S: Method>(
        &mut self,
        stretch: &mut Stretch<'_, Y, S, D>,
        length: f64,
    ) -> bool {
        let time = stretch.sign() * length;
        let Ok(capability) = stretch.system.rates() else { return true }; // not reached: asked before the run
        if stretch.inner_steps() > FEW_INNER {
            return false;
        }
        let [rates, flows] = &mut self.normals;
        if const { !S::KEEPS_FORCES } {
            stretch.system.evaluate_forces(stretch.bodies);
        }
        capability.evaluate_rates(stretch.bodies, rates, &mut ());
        if leads_back(stretch, time, rates, None) {
            return true;
        }
        if const { Y::FLOWS == 0 }
            || stretch.flows == Chosen::None
            || !ask_flows(stretch, SHORTLY * time, flows)
        {
            return false;
        }
        flows.iter_mut().zip(&*rates).for_each(|(both, rate)| *both = sum(both, rate));
        leads_back(stretch, time, flows, Some(rates))
    }
}

/// Writes ṗ by flows where bodies are, from what these give them in a time h; whether they give anything.
#[cold]
#[inline(never)]
fn ask_flows<Y: System<f64, D>, S: Method, const D: usize>(
    stretch: &mut Stretch<'_, Y, S, D>,
    h: f64,
    rates: &mut [[f64; D]],
) -> bool {
    let Stretch { system, ref mut bodies, ref mut aside, flows, .. } = *stretch;
    let noise = bodies.noise;
    system.put_aside(bodies, &mut aside[0]);
    let pushed = push(flows, Half::Before, h, system, bodies);
    let before = aside[0].p.as_ref();
    for ((rate, p), before) in rates.iter_mut().zip(bodies.p.as_ref()).zip(before) {
        *rate = scaled(1.0 / h, &add_scaled(p, -1.0, before));
    }
    system.put_back(bodies, &aside[0]);
    bodies.noise = noise;
    pushed.is_ok()
}

/// Whether bodies at the end of a stretch, which takes this time, are led back to its start by ṗ there; which is
/// beside that without flows, if they count.
fn leads_back<Y: System<f64, D>, S: Method, const D: usize>(
    stretch: &mut Stretch<'_, Y, S, D>,
    time: f64,
    rates: &[[f64; D]],
    without: Option<&[[f64; D]]>,
) -> bool {
    let Stretch { system, ref start, ref mut bodies, .. } = *stretch;
    let number = start.q.as_ref().len();
    // A velocity that several bodies have in common takes them past no gap between them, nor to a wall unnoticed.
    let mut common = [0.0; D];
    if number > 1 {
        for body in 0..number {
            common = add_scaled(&common, 1.0 / number as f64, &system.velocity(bodies, body));
        }
    }
    let way = |to: &[[f64; D]], body: usize| add_scaled(&to[body], -1.0, &start.q.as_ref()[body]);
    let own = |way: &[f64; D]| add_scaled(way, -time, &common);
    let (mut farthest, mut largest_place) = (0.0_f64, 0.0_f64);
    for body in 0..number {
        let [from, to] = [start.q.as_ref(), bodies.q.as_ref()];
        farthest = farthest.max(largest(&own(&way(to, body))));
        largest_place = largest_place.max(largest(&from[body])).max(largest(&to[body]));
    }
    let least = (ROUNDINGS * f64::EPSILON * largest_place).max(HARDLY * farthest);
    rates.iter().enumerate().all(|(body, rate)| {
        let [before, after] = [system.velocity(start, body), system.velocity(bodies, body)];
        let mut change = |rate: &[f64; D]| {
            let p = std::mem::replace(&mut bodies.p.as_mut()[body], *rate);
            let change = system.velocity(bodies, body).map(|a| time * a);
            bodies.p.as_mut()[body] = p;
            change
        };
        let balanced = without.map_or(0.0, |without| HARDLY * time.abs() * largest(&change(&without[body])));
        let change = change(rate);
        let way = way(bodies.q.as_ref(), body);
        let elsewhere = add_scaled(&add_scaled(&way, -time, &after), 0.5 * time, &change);
        let faster = add_scaled(&add_scaled(&after, -1.0, &before), -1.0, &change).map(|v| time * v);
        let [before, after] = [before, after].map(|v| add_scaled(&v, -1.0, &common));
        let squares = [&before, &after, &change].map(|v| time * time * dot(v, v));
        let way = own(&way);
        let size = squares.into_iter().fold(dot(&way, &way), f64::max).sqrt();
        let mut off = [&elsewhere, &faster].into_iter().zip(ELSEWHERE);
        !off.any(|(off, part)| largest(off) > least.max(balanced).max(part * size)) // NaN is told elsewhere
    })
}
