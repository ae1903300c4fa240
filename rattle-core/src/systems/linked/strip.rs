//! The momenta of bodies [in a line](crate::systems::network::line), settled by streams over memory.

use crate::effect::force::Force;
use crate::number::vector::{sum, two_sum};
use crate::systems::linked::kept::Room;
use crate::systems::linked::pull::Rounds;
use crate::systems::network::elimination::Elimination;
use crate::systems::network::line::Line;
use std::array::from_fn;
use std::ops::Range;

/// Notes how bodies set out: their velocities, and their ways without the constraints.
pub(super) fn set_out<Fo: Force<f64, D>, const D: usize>(
    bodies: Range<usize>,
    [h, kick]: [f64; 2],
    over_masses: &[[f64; D]],
    [p, p_low]: [&[[f64; D]]; 2],
    force: &[Fo],
    room: &mut Room<D>,
) {
    let Room { velocity, drift, push, .. } = room;
    let to =
        velocity[bodies.clone()].iter_mut().zip(&mut drift[bodies.clone()]).zip(&mut push[bodies.clone()]);
    let from = p[bodies.clone()].iter().zip(&p_low[bodies.clone()]).zip(&force[bodies.clone()]);
    for ((((v, drift), push), ((p, low), force)), over) in to.zip(from).zip(&over_masses[bodies]) {
        let force = force.add_to([0.0; D], h * kick);
        for d in 0..D {
            v[d] = over[d] * p[d];
            drift[d] = h * v[d] + h * (over[d] * low[d]);
            push[d] = over[d] * force[d];
        }
    }
}

/// Moves and kicks the bodies of a line, with multipliers x; `impulses` is room for as many numbers.
pub(super) fn advance<Fo: Force<f64, D>, const D: usize>(
    line: &Line,
    elimination: &Elimination<D>,
    [h, kick]: [f64; 2],
    [q, q_low, p, p_low]: [&mut [[f64; D]]; 4],
    force: &[Fo],
    room: &mut Room<D>,
    x: Range<usize>,
) {
    let Room { drift, push, dx, x: all, .. } = room;
    let (bodies, impulses, x) = (line.bodies(x.len()), &mut dx[..x.len()], &all[x]);
    impulses.iter_mut().zip(x).for_each(|(impulse, x)| *impulse = x / h);
    let places = q[bodies.clone()].iter_mut().zip(&mut q_low[bodies.clone()]);
    let momenta = p[bodies.clone()].iter_mut().zip(&mut p_low[bodies.clone()]);
    let ways = drift[bodies.clone()].iter().zip(&push[bodies.clone()]).zip(&force[bodies]);
    let mut bodies = places.zip(momenta).zip(ways);
    let [normals, lifted] = elimination.at_start();
    line.combine_both([lifted, normals], [x, impulses], |way, impulse| {
        if let Some((((q, q_low), (p, p_low)), ((drift, push), force))) = bodies.next() {
            let lift = sum(&sum(drift, push), &way);
            let change = sum(&force.add_to(*p_low, kick), &impulse);
            (*q, *q_low) = two_sum(q, &sum(q_low, &lift));
            (*p, *p_low) = two_sum(p, &change);
        }
    });
}

/// The bodies of a line and their momenta.
pub(super) struct Strip<'a, Fo, const D: usize> {
    pub(super) line: &'a Line,
    pub(super) q: &'a [[f64; D]],
    pub(super) p: &'a mut [[f64; D]],
    pub(super) p_low: &'a mut [[f64; D]],
    pub(super) force: &'a [Fo],
    /// Room for the change of each body of the scene.
    pub(super) change: &'a mut [[f64; D]],
    pub(super) kick: f64,
}

impl<Fo: Force<f64, D>, const D: usize> Strip<'_, Fo, D> {
    /// Kicks the momenta and makes them tangent; writes the multipliers. Returns the sum of the squares of places and
    /// momenta. `needed` and `x` are room for a number of each row.
    pub(super) fn settle(
        &mut self,
        elimination: &mut Elimination<D>,
        needed: &mut [f64],
        x: &mut [f64],
        total: &mut [f64],
    ) -> f64 {
        let free = self.line.bodies(total.len());
        let bodies = self.change[free.clone()].iter_mut().zip(&self.force[free.clone()]);
        for ((change, force), low) in bodies.zip(&self.p_low[free.clone()]) {
            *change = force.add_to(*low, self.kick);
        }
        self.fall_short::<false>(elimination, needed);
        elimination.solve(needed, total);
        self.push(elimination, total);
        // The second time takes what rounding left, if it left more than comes from forming the rates.
        let mut rounds = Rounds::after_one();
        while rounds.has_another(elimination.is_lossy()) && !self.fall_short::<true>(elimination, needed) {
            elimination.solve(needed, x);
            if !rounds.takes(x, needed) {
                break;
            }
            total.iter_mut().zip(&*x).for_each(|(total, x)| *total += x);
            self.push(elimination, x);
        }
        let mut size = [0.0; D];
        let bodies = self.p[free.clone()].iter_mut().zip(&mut self.p_low[free.clone()]);
        for (((p, low), change), q) in bodies.zip(&self.change[free.clone()]).zip(&self.q[free]) {
            (*p, *low) = two_sum(p, change);
            size = from_fn(|d| size[d] + (p[d] * p[d] + q[d] * q[d]));
        }
        size.iter().sum()
    }

    /// Writes by how much ∇gᵢ·v falls short of 0. With `SMALL`, whether that is no more than comes from forming it.
    #[inline(always)]
    fn fall_short<const SMALL: bool>(&self, elimination: &Elimination<D>, needed: &mut [f64]) -> bool {
        let (first, m) = (self.line.first, needed.len());
        let all = first..first + m + 1;
        let mut momenta = self.p[all.clone()].iter().zip(&self.change[all]).map(|(p, change)| sum(p, change));
        let (Some(mut before), [_, lifted]) = (momenta.next(), elimination.at_start()) else { return false };
        let mut small = true;
        for ((needed, [own, next]), after) in needed.iter_mut().zip(lifted.as_chunks::<2>().0).zip(momenta) {
            let products: [[f64; D]; 2] = [from_fn(|d| own[d] * before[d]), from_fn(|d| next[d] * after[d])];
            let rate = total(&sum(&products[0], &products[1]));
            *needed = -rate;
            if SMALL {
                let sizes: [f64; D] = from_fn(|d| products[0][d].abs() + products[1][d].abs());
                small &= rate.abs() <= 2.0 * f64::EPSILON * total(&sizes);
            }
            before = after;
        }
        small
    }

    #[inline(always)]
    fn push(&mut self, elimination: &Elimination<D>, x: &[f64]) {
        let mut changes = self.change[self.line.bodies(x.len())].iter_mut();
        self.line.combine(elimination.at_start()[0], x, |impulse| {
            if let Some(change) = changes.next() {
                *change = sum(change, &impulse);
            }
        });
    }
}

#[inline(always)]
fn total<const D: usize>(a: &[f64; D]) -> f64 {
    let mut sum = a[0];
    for x in &a[1..] {
        sum += x;
    }
    sum
}
