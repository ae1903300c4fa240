//! Poincaré sections: where trajectories pass through a surface in phase space.

use crate::run::watch::observer::Observer;
use crate::run::watch::sight::Sight;
use nalgebra::SVector;

/// A Poincaré section: where and when trajectories pass from s < 0 to s ≥ 0.
///
/// Between two sights the path of a body is the cubic through both positions with the velocities there (Hermite
/// interpolation), off by up to h⁴/384 times the fourth derivative of q. Momenta are interpolated by parabolas, bent by
/// the change of forces: off by up to h³/96 times their third derivative. Forces of velocities or time and drag, which
/// a [flow](crate::effect::Flow) gives, bend no parabola: what they add to momenta is off by up to h²/8 times its
/// second derivative. The crossing is where s is zero on that path. A crossing evaluates velocities and forces at both
/// sights, and allocates. Momenta of staggered methods, as [`Leapfrog`](crate::methods::leapfrog::Leapfrog), are those
/// of half a step beside the time of the crossing. Where no body has a velocity at either sight, as
/// [`Brownian`](crate::methods::brownian::Brownian) leaves them, the path is a straight line.
///
/// A crossing is seen where s < 0 at one sight and s ≥ 0 at the next. What passes zero and comes back between two
/// sights is not: look often enough that s changes its sign no more than once from one sight to the next.
///
/// Where momenta [jump](Observer::jump) between two sights, at impacts and edges, the path ends at the jump and begins
/// anew there. If s itself passes zero by the jump, the crossing is at its instant, with the momenta after it.
#[doc(alias = "event detection")]
#[doc(alias = "Poincaré map")]
#[doc(alias = "return map")]
#[derive(Debug, Clone)]
pub struct Section<Q, const D: usize> {
    quantity: Q,
    crossings: Vec<Crossing<D>>,
    /// The trajectory at the last sight and right after the last jump since then.
    jumped: Option<[Crossing<D>; 2]>,
}

/// A crossing of a [`Section`].
#[derive(Debug, Clone, PartialEq)]
pub struct Crossing<const D: usize> {
    /// The number of the trajectory.
    pub trajectory: usize,
    /// The time.
    pub time: f64,
    /// Positions of the bodies.
    pub positions: Vec<SVector<f64, D>>,
    /// Momenta of the bodies.
    pub momenta: Vec<SVector<f64, D>>,
}

impl<Q: Fn(&Sight<'_, D>) -> f64, const D: usize> Section<Q, D> {
    /// A section where this quantity s passes zero from below.
    pub fn of(quantity: Q) -> Self {
        Self { quantity, crossings: Vec::new(), jumped: None }
    }

    /// All crossings: those of the first group of trajectories in the order in which they happened, then those of the
    /// next group. [`return_times`](Self::return_times) sorts them by trajectory.
    pub fn crossings(&self) -> &[Crossing<D>] {
        &self.crossings
    }

    /// Adds the crossing on a way without jumps, if there is one.
    #[inline(always)]
    fn pass(&mut self, from: &Sight<'_, D>, to: &Sight<'_, D>) {
        let (s0, s1) = ((self.quantity)(from), (self.quantity)(to));
        if s0 < 0.0 && s1 >= 0.0 {
            self.crossings.push(self.crossing((from, s0), (to, s1)));
        }
    }

    /// Where s passes from s₀ < 0 to s₁ ≥ 0.
    #[inline(never)]
    fn crossing(&self, (before, s0): (&Sight<'_, D>, f64), (now, s1): (&Sight<'_, D>, f64)) -> Crossing<D> {
        // The root by regula falsi; s at an end that stays twice is halved (Dowell and Jarratt 1971). It is nearly
        // linear in a step.
        let (mut low, mut high, mut at_low, mut at_high) = (0.0, 1.0, s0, s1);
        let (mut crossing, mut last, mut was_below) = (Crossing::of(now), f64::NAN, None);
        let ends = [(before, before.rates()), (now, now.rates())];
        for _ in 0..60 {
            let part = low - at_low * (high - low) / (at_high - at_low);
            crossing.move_to(&ends, part);
            let s = (self.quantity)(&crossing.sight(now));
            let below = s < 0.0;
            let (end, at_end, at_other) = if below {
                (&mut low, &mut at_low, &mut at_high)
            } else {
                (&mut high, &mut at_high, &mut at_low)
            };
            (*end, *at_end) = (part, s);
            if was_below == Some(below) {
                *at_other *= 0.5;
            }
            if s == 0.0 || high - low <= f64::EPSILON || (part - last).abs() <= f64::EPSILON {
                break;
            }
            (last, was_below) = (part, Some(below));
        }
        crossing
    }

    /// The times between successive crossings of one trajectory, each with the number of the trajectory.
    pub fn return_times(&self) -> Vec<(usize, f64)> {
        let mut order: Vec<&Crossing<D>> = self.crossings.iter().collect();
        order.sort_by(|a, b| {
            (a.trajectory, a.time).partial_cmp(&(b.trajectory, b.time)).unwrap_or(std::cmp::Ordering::Equal)
        });
        let pairs = order.windows(2).filter(|pair| pair[0].trajectory == pair[1].trajectory);
        pairs.map(|pair| (pair[1].trajectory, pair[1].time - pair[0].time)).collect()
    }
}

impl<Q: Fn(&Sight<'_, D>) -> f64, const D: usize> Observer<D> for Section<Q, D> {
    #[inline(always)]
    fn see(&mut self, before: &Sight<'_, D>, now: &Sight<'_, D>) {
        match self.jumped.take() {
            // Not that of a run that ended with an error before its next sight.
            Some([last, after]) if last == Crossing::of(before) => self.pass(&after.sight(now), now),
            _ => self.pass(before, now),
        }
    }

    fn sees_jumps(&self) -> bool {
        true
    }

    fn jump(&mut self, from: &Sight<'_, D>, before: &Sight<'_, D>, after: &Sight<'_, D>) {
        self.pass(from, before);
        let there = Crossing::of(after);
        if (self.quantity)(before) < 0.0 && (self.quantity)(after) >= 0.0 {
            self.crossings.push(there.clone());
        }
        let from = Crossing::of(from);
        let last = match self.jumped.take() {
            Some([last, after]) if after == from => last,
            _ => from,
        };
        self.jumped = Some([last, there]);
    }

    fn join(&mut self, mut next: Self) {
        self.crossings.append(&mut next.crossings);
    }
}

impl<const D: usize> Crossing<D> {
    fn of(now: &Sight<'_, D>) -> Self {
        let (positions, momenta) = (now.positions.to_vec(), now.momenta.to_vec());
        Self { trajectory: now.trajectory, time: now.time, positions, momenta }
    }

    fn sight<'a>(&'a self, now: &Sight<'a, D>) -> Sight<'a, D> {
        let Self { trajectory, time, positions, momenta } = self;
        Sight { trajectory: *trajectory, time: *time, positions, momenta, ..*now }
    }

    /// Puts it a part of the way from one sight, with its rates, to the next.
    fn move_to(&mut self, ends: &[(&Sight<'_, D>, [Vec<SVector<f64, D>>; 2]); 2], part: f64) {
        let [(before, [v0, f0]), (now, [v1, f1])] = ends;
        let (t, rest, h) = (part, 1.0 - part, now.time - before.time);
        self.time = before.time + part * h;
        let straight = [v0, v1].into_iter().flatten().all(|v| v.norm_squared() == 0.0);
        for body in 0..self.positions.len() {
            let (q0, q1) = (before.positions[body], now.positions[body]);
            let [v0, v1] = [v0[body], v1[body]];
            self.positions[body] = if straight {
                q0 * rest + q1 * t
            } else {
                let curve = v0 * (h * t * rest * rest) - v1 * (h * t * t * rest);
                q0 * ((1.0 + 2.0 * t) * rest * rest) + q1 * (t * t * (3.0 - 2.0 * t)) + curve
            };
            // What flows give at both ends alike is in the change of p; how that changes is left out.
            let (p0, p1) = (before.momenta[body], now.momenta[body]);
            let bent = if straight { 0.0 } else { 0.5 * h * t * rest };
            self.momenta[body] = p0 * rest + p1 * t + (f0[body] - f1[body]) * bent;
        }
    }
}
