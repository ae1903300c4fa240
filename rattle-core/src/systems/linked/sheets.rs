//! Whether a step of a method that does not follow roots has ended on the sheets on which it began, where equations
//! have several.
//!
//! Two signs show that it may be on others, as on surfaces ([`crate::systems::surface::sheets`]): gradients change if
//! bodies are displaced along them as far as the step may have gone wrong; or an equation *inside* the step, on a curve
//! through its ends, is not as small as it is along one sheet. A third one is that of links alone, which may be put
//! together in several ways: near a toggle, where links come to depend on each other, the mirror image of an elbow is
//! no gradient's way away, and the curve to it meets all equations. But with the gradients of one end and those of the
//! other G M⁻¹Gᵀ has a pivot that is not positive there: its determinant has another sign for the mirror image. In
//! each case bodies are moved along the curve in parts of the step, each with a step of RATTLE. If the step ended on
//! another sheet, they arrive at another point. This allocates.
//!
//! The curve is Hermite's cubic, and where an equation is not small on it, the quartic that also matches the
//! acceleration at the end.

use crate::effect::force::Force;
use crate::effect::interval::Inertia;
use crate::effect::list::Forces;
use crate::error::StepFailure;
use crate::motion::affected::Affected;
use crate::motion::bodies::{Count, Saved};
use crate::motion::capability::Rates;
use crate::motion::failure::Failure;
use crate::motion::system::System;
use crate::number::vector::{add_scaled, dot, largest};
use crate::solve::aim::{INSIDE, OFF_INSIDE, ROUNDINGS};
use crate::solve::crowd::{OF_RADIUS, RISES, shares, there};
use crate::solve::curve::quartic;
use crate::systems::linked::kept::{BodiesOf, Linked, Room, Tied};
use std::array::from_fn;
use std::mem::take;

/// On the quartic g is less than this part of s (s/path)⁴, where s is by how much a body's velocity changes, times h:
/// three times what it is on a circle. For a body that starts at rest that is more than it may have been led astray.
const OF_TURN: f64 = 1e-3;

/// Parts of a step in which one goes there, and in which it is tried again and again.
const PARTS: [u32; 3] = [2, 16, 128];

/// At the end parts shrink so often by a factor of 8: one ends beside the curve by about the square of the last one.
const SHRINKS: u32 = 6;

impl<F: Forces<f64, D>, N: Count, const D: usize> Linked<F, N, D> {
    /// Looks inside a step of length h, and now and then whether other roots are near.
    pub(super) fn look_inside(
        &self,
        h: f64,
        before: &Saved<N, f64, D>,
        now: &mut BodiesOf<F, N, D>,
    ) -> Result<(), Failure> {
        let roots = &self.shape.roots;
        now.kept.tied.lend_normals(&self.shape, now.time, now.q.as_ref());
        now.kept.tied.room.lift.fill([0.0; D]);
        self.take_ends(h, before, now);
        self.ask(before, now);
        if now.kept.tied.asked.near || self.turns_over(before, now) {
            return self.go_there(h, before, now);
        }
        if !self.is_off_inside(h, false, before, now) {
            return Ok(());
        }
        let mut forces = take(&mut now.kept.tied.room.forces);
        self.evaluate_rates(now, &mut forces, &mut ());
        self.take_ends(h, before, now);
        for (body, root) in roots.iter().enumerate() {
            let (a, [q, r]) = (root.velocity(&forces[body]), [&before.q, &now.q].map(|q| q.as_ref()[body]));
            let Room { drift: v, velocity: w, lift, .. } = &mut now.kept.tied.room;
            let of_cubic = |i: usize| 6.0 * (q[i] - r[i]) + h * (2.0 * v[body][i] + 4.0 * w[body][i]);
            lift[body] = from_fn(|i| 0.5 * (h * h * a[i] - of_cubic(i)));
        }
        now.kept.tied.room.forces = forces;
        if self.is_off_inside(h, true, before, now) { self.go_there(h, before, now) } else { Ok(()) }
    }

    /// Velocities at the two ends of a step in `drift` and `velocity`, and in `push` how far astray it may have led
    /// each body.
    fn take_ends(&self, h: f64, before: &Saved<N, f64, D>, now: &mut BodiesOf<F, N, D>) {
        let room = &mut now.kept.tied.room;
        for (body, root) in self.shape.roots.iter().enumerate() {
            let [v, w] = [&before.p, &now.p].map(|p| root.velocity(&p.as_ref()[body]));
            (room.drift[body], room.velocity[body]) = (v, w);
            let way = add_scaled(&now.q.as_ref()[body], -1.0, &before.q.as_ref()[body]);
            room.push[body] = from_fn(|i| way[i] - 0.5 * h * (v[i] + w[i]));
        }
    }

    /// Now and then, and after a step that may have led farther astray than was asked for, asks whether other roots are
    /// near.
    fn ask(&self, before: &Saved<N, f64, D>, now: &mut BodiesOf<F, N, D>) {
        let astray = most(now.kept.tied.room.push.iter().map(largest));
        let Some(turn) = now.kept.tied.asked.turn(astray, 1.0) else { return };
        let ways = now.q.as_ref().iter().zip(before.q.as_ref());
        let path = most(ways.map(|(q, from)| largest(&add_scaled(q, -1.0, from))));
        let radius = path * (path / (12.0 * astray)).sqrt(); // as on a circle; none where nothing is led astray
        let reach = (OF_RADIUS * radius).min(now.kept.tied.asked.reach);
        now.kept.tied.asked.near = self.others_are_near(turn, reach, now);
    }

    /// Whether an equation's gradient, where bodies are moved along gradients up to this far, is less than half of what
    /// it was.
    #[cold]
    #[inline(never)]
    fn others_are_near(&self, turn: u64, reach: f64, now: &mut BodiesOf<F, N, D>) -> bool {
        let shape = &*self.shape;
        let (q, time) = (now.q.as_ref(), now.time);
        let Tied { room, blocks, .. } = &mut now.kept.tied;
        shares(turn).any(|share| {
            shape.components.iter().enumerate().any(|(c, component)| {
                let (rows, (_, first)) = (&component.rows, component.first);
                let here = &blocks[first..first + rows.blocks()];
                let square =
                    |row: usize| rows.touched_by(row).map(|(block, _)| dot(&here[block], &here[block]));
                rows.touched().iter().for_each(|&body| room.trial[body] = q[body]);
                for row in 0..rows.equations() {
                    let free = || rows.touched_by(row).filter(|&(_, body)| !shape.is_pinned(body));
                    let of_free: f64 = free().map(|(block, _)| dot(&here[block], &here[block])).sum();
                    // What bodies that are free do alone, for those that are pinned too.
                    let shift = share * reach * square(row).sum::<f64>().sqrt() / of_free;
                    for (block, body) in free() {
                        room.trial[body] = add_scaled(&room.trial[body], shift, &here[block]);
                    }
                }
                let there = &mut room.blocks[..rows.blocks()];
                shape.gradients(c, time, &room.trial, &mut room.g, there, &mut room.rates);
                (0..rows.equations()).any(|row| {
                    let along: f64 =
                        rows.touched_by(row).map(|(block, _)| dot(&here[block], &there[block])).sum();
                    let rises = RISES * square(row).sum::<f64>() <= along;
                    !rises // where it is not a number either
                })
            })
        })
    }

    /// Whether a pivot of G M⁻¹Gᵀ, with the gradients of both ends, is not positive: links turned by more than a right
    /// angle, or are put together in another way. Not asked of links that act along other directions than their
    /// gradients, whose pivots may have any sign.
    fn turns_over(&self, before: &Saved<N, f64, D>, now: &mut BodiesOf<F, N, D>) -> bool {
        let shape = &*self.shape;
        let Tied { room, solvers, .. } = &mut now.kept.tied;
        shape.components.iter().zip(solvers).enumerate().any(|(c, (component, solver))| {
            let rows = &component.rows;
            if rows.acting {
                return false;
            }
            let blocks = &mut room.blocks[..rows.blocks()];
            shape.gradients(c, before.time, before.q.as_ref(), &mut room.g, blocks, &mut room.rates);
            let upright = solver.chord::<false>(rows, blocks, &shape.roots) > 0.0;
            !upright // where it is not a number either
        })
    }

    /// Whether an equation is not as small inside the step as it is along one root, on the curve of the two ends and of
    /// `lift`: a cubic or a quartic.
    fn is_off_inside(
        &self,
        h: f64,
        quartic: bool,
        before: &Saved<N, f64, D>,
        now: &mut BodiesOf<F, N, D>,
    ) -> bool {
        let shape = &*self.shape;
        let (from, to, time) = (before.q.as_ref(), now.q.as_ref(), [before.time, now.time]);
        let Tied { room, blocks, .. } = &mut now.kept.tied;
        let mut farthest: Option<(usize, usize, f64)> = None;
        for s in INSIDE {
            for body in 0..to.len() {
                room.trial[body] = between(h, s, [&from[body], &to[body]], room, body);
            }
            let time = (1.0 - s) * time[0] + s * time[1];
            let allowed = |body: usize| {
                let turned = add_scaled(&room.velocity[body], -1.0, &room.drift[body]);
                let (s, path) =
                    (h.abs() * largest(&turned), largest(&add_scaled(&to[body], -1.0, &from[body])));
                let squared = (s / path) * (s / path);
                let turn = if quartic { OF_TURN * s * squared * squared } else { 0.0 };
                let rounding = ROUNDINGS * f64::EPSILON * largest(&to[body]);
                (OFF_INSIDE * largest(&room.push[body])).max(turn) + rounding
            };
            for (c, component) in shape.components.iter().enumerate() {
                let (rows, (_, first)) = (&component.rows, component.first);
                shape.values(c, time, &room.trial, &mut room.g);
                for row in 0..rows.equations() {
                    let (mut square, mut most) = (0.0, 0.0_f64);
                    for (block, body) in rows.touched_by(row) {
                        square += dot(&blocks[first + block], &blocks[first + block]);
                        most = most.max(allowed(body));
                    }
                    let (g, length) = (room.g[row].abs(), square.sqrt());
                    let (small, distance) = (g <= most * length, g / length);
                    if !(small || quartic && distance.is_finite()) {
                        return true; // where it is not a number either
                    }
                    if !small && farthest.is_none_or(|(_, _, most)| most < distance) {
                        farthest = Some((c, row, distance));
                    }
                }
            }
        }
        farthest.is_some_and(|(c, row, distance)| !self.is_rounding(c, row, distance, now))
    }

    /// Goes from the start of a step to its end in small parts. An error where that is not reached.
    #[cold]
    #[inline(never)]
    fn go_there(&self, h: f64, before: &Saved<N, f64, D>, now: &BodiesOf<F, N, D>) -> Result<(), Failure> {
        let (mut off, mut body) = (f64::NAN, 0);
        let sizes = self.sizes(h, before, now);
        for parts in PARTS {
            let Some(reached) = self.goes_along(h, parts, before, now) else { continue };
            let places = reached.iter().zip(now.q.as_ref());
            let offs: Vec<f64> = places.map(|(a, b)| largest(&add_scaled(a, -1.0, b))).collect();
            let is_there = |&body: &usize| offs[body] <= there::<f64>() * sizes[body];
            let elsewhere = (0..offs.len()).filter(|body| !is_there(body));
            let Some(farthest) = elsewhere.max_by(|&a, &b| offs[a].total_cmp(&offs[b])) else {
                return Ok(());
            };
            (off, body) = (offs[farthest], farthest);
        }
        let position = now.q.as_ref()[body].to_vec();
        Err(Failure { body, cause: StepFailure::OtherSheet { h, off, position } })
    }

    /// How large places are, at both ends of a step and on the way, of what each body is linked to, and what forces
    /// alone would have moved that by: the rounding of others is not theirs.
    fn sizes(&self, h: f64, before: &Saved<N, f64, D>, now: &BodiesOf<F, N, D>) -> Vec<f64> {
        let size = |body: usize| {
            let force = now.kept.tied.force[body].components();
            let pushed = largest(&self.shape.pushed(body, h, &force));
            let places = [&before.q, &now.q].map(|q| largest(&q.as_ref()[body]));
            let way = |p: &[f64; D]| h.abs() * largest(&self.shape.roots[body].velocity(p));
            let ways = [&before.p, &now.p].map(|p| way(&p.as_ref()[body]));
            most(places.into_iter().chain(ways).chain([pushed]))
        };
        let mut sizes: Vec<f64> = (0..now.q.as_ref().len()).map(size).collect();
        for component in &self.shape.components {
            let touched = component.rows.touched();
            let size = most(touched.iter().map(|&body| sizes[body]));
            touched.iter().for_each(|&body| sizes[body] = size);
        }
        sizes
    }

    /// Where one gets to in so many parts; None where one of them cannot be taken.
    fn goes_along(
        &self,
        h: f64,
        parts: u32,
        before: &Saved<N, f64, D>,
        now: &BodiesOf<F, N, D>,
    ) -> Option<Vec<[f64; D]>> {
        let mut ahead = now.clone();
        self.put_back(&mut ahead, before);
        let length = 1.0 / f64::from(parts);
        let close = (1..=SHRINKS).map(|n| 1.0 - length / f64::from(1_u32 << (3 * n)));
        let shares = (1..parts).map(|n| f64::from(n) * length).chain(close).chain([1.0]);
        let mut last = 0.0;
        for s in shares {
            let part = h * (s - last);
            last = s;
            for (body, root) in self.shape.roots.iter().enumerate() {
                let ends = [&before.q, &now.q].map(|q| &q.as_ref()[body]);
                let way = add_scaled(
                    &between(h, s, ends, &now.kept.tied.room, body),
                    -1.0,
                    &ahead.q.as_ref()[body],
                );
                let velocity = way.map(|x| x / part);
                let axis = |i: usize| from_fn(|j| f64::from(u8::from(i == j)));
                ahead.p.as_mut()[body] = from_fn(|i| root.product(&axis(i), &velocity));
                ahead.p_low.as_mut()[body] = [0.0; D];
            }
            self.settle(0.0, part, &mut ahead, &mut ()).ok()?;
            self.drift(0.0, part, &mut ahead, &mut ()).ok()?;
        }
        Some(ahead.q.as_ref().to_vec())
    }
}

/// The largest of these; NaN if one is.
fn most(numbers: impl Iterator<Item = f64>) -> f64 {
    numbers.fold(0.0, |most, x| if x <= most { most } else { x })
}

/// Where a body is after the share s of a step of length h, on the curve of its places and velocities at both ends, and
/// of `lift`.
fn between<const D: usize>(h: f64, s: f64, ends: [&[f64; D]; 2], room: &Room<D>, body: usize) -> [f64; D] {
    let Room { drift: v, velocity: w, lift, .. } = room;
    quartic(h, s, ends, [&v[body], &w[body]], &lift[body])
}
