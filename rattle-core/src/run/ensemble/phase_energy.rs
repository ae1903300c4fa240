//! The step of the energy alone in lanes: the Störmer–Verlet step of [`point`](crate::systems::phase::point), and where
//! it takes a small change of the point that it starts from.
//!
//! Each of its equations x = f(x) is iterated in all lanes; a lane that rests keeps its x.

use crate::kernel::functions::HamiltonianKernel;
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::number::vector::{add_scaled, largest, scaled, sum};
use crate::number::vectors::{at, put};
use crate::run::ensemble::phase_fibre::{BY_ITSELF, GOES, RESTS};
use crate::run::ensemble::phase_row::{Each, Laws, Number, Points, ROW, Vector, ZEROS};
use crate::systems::phase::point::{MOVES, ROUNDING, ROUNDING_OF_BASE, Roots};

/// Passes after which a lane goes by itself.
const MOST_PASSES: usize = 40;

/// A step of each lane.
pub(super) struct Leap<const D: usize> {
    kick: Vector<D>,
    half: Vector<D>,
    out: Vector<D>,
    drift: Vector<D>,
    end: Vector<D>,
    /// The same of a small change: its kick, and what half the step leads to.
    small: [Vector<D>; 2],
    /// Where the step leads.
    pub(super) change: Points<D>,
}

impl<const D: usize> Leap<D> {
    pub(super) const NONE: Self = Self {
        kick: [ZEROS; D],
        half: [ZEROS; D],
        out: [ZEROS; D],
        drift: [ZEROS; D],
        end: [ZEROS; D],
        small: [[ZEROS; D]; 2],
        change: Points::ZERO,
    };

    /// The step from these points, in lanes that do not go by themselves.
    #[inline(always)]
    pub(super) fn leap<const M: usize>(
        &mut self,
        laws: &impl Laws<D, M>,
        h: f64,
        from: &Points<D>,
        going: &mut Each,
    ) {
        let Self { kick, half, out, drift, end, change, .. } = self;
        let share = Fused(0.5 * h);
        iterate(&Kick { laws, share, from }, &from.p, kick, RESTS, going);
        for l in 0..ROW {
            let half_way = sum(&at(&from.p, l), &at(kick, l));
            put(half, l, half_way);
            put(out, l, scaled(share, &laws.energy(l).gradients(&at(&from.q, l), &half_way).1));
        }
        iterate(&Drift { laws, share, from: &from.q, half, out }, &from.q, drift, RESTS, going);
        for l in 0..ROW {
            let (drift, half) = (at(drift, l), at(half, l));
            let place = sum(&at(&from.q, l), &drift);
            let second = laws.energy(l).gradients(&place, &half).0;
            put(end, l, place);
            put(&mut change.q, l, drift);
            put(&mut change.p, l, add_scaled(&at(kick, l), -share, &second));
        }
    }

    /// Where the step takes this small change of the points that it started from, in lanes that do not rest.
    #[inline(always)]
    pub(super) fn tangent<const M: usize>(
        &mut self,
        laws: &impl Laws<D, M>,
        h: f64,
        from: &Points<D>,
        change: &Points<D>,
        to: &mut Points<D>,
        going: &mut Each,
    ) {
        let Self { half, end, small: [kick, out], .. } = self;
        let share = Fused(0.5 * h);
        iterate(&SmallKick { laws, share, from: &from.q, half, change }, &change.p, kick, GOES, going);
        for l in 0..ROW {
            let (v, p) = (at(&change.q, l), at(kick, l));
            let rate = laws.energy(l).hessian_vector(&at(&from.q, l), &at(half, l), &v, &p).1;
            put(out, l, add_scaled(&v, share, &rate));
        }
        iterate(&SmallDrift { laws, share, end, half, out, kick }, &change.q, &mut to.q, GOES, going);
        for l in 0..ROW {
            let (q, p) = (at(&to.q, l), at(kick, l));
            let rate = laws.energy(l).hessian_vector(&at(end, l), &at(half, l), &q, &p).0;
            put(&mut to.p, l, add_scaled(&p, -share, &rate));
        }
    }
}

/// An equation x = f(x) in each lane. (No closure: what is not inlined is compiled for no instruction set.)
trait Equation<const D: usize> {
    /// How many roots it may have, of which one is wanted.
    const ROOTS: Roots;
    /// f(x) in a lane. Must be `#[inline(always)]`.
    fn at(&self, lane: usize, x: &[Number; D]) -> [Number; D];
}

/// −h/2 ∂H/∂q(q, p + x).
struct Kick<'a, X, const D: usize, const M: usize> {
    laws: &'a X,
    share: Number,
    from: &'a Points<D>,
}

impl<X: Laws<D, M>, const D: usize, const M: usize> Equation<D> for Kick<'_, X, D, M> {
    const ROOTS: Roots = Roots::Many;

    #[inline(always)]
    fn at(&self, l: usize, kick: &[Number; D]) -> [Number; D] {
        let p = sum(&at(&self.from.p, l), kick);
        scaled(-self.share, &self.laws.energy(l).gradients(&at(&self.from.q, l), &p).0)
    }
}

/// What half the step leads to, + h/2 ∂H/∂p(q + x, p½).
struct Drift<'a, X, const D: usize, const M: usize> {
    laws: &'a X,
    share: Number,
    from: &'a Vector<D>,
    half: &'a Vector<D>,
    out: &'a Vector<D>,
}

impl<X: Laws<D, M>, const D: usize, const M: usize> Equation<D> for Drift<'_, X, D, M> {
    const ROOTS: Roots = Roots::Many;

    #[inline(always)]
    fn at(&self, l: usize, drift: &[Number; D]) -> [Number; D] {
        let q = sum(&at(self.from, l), drift);
        add_scaled(&at(self.out, l), self.share, &self.laws.energy(l).gradients(&q, &at(self.half, l)).1)
    }
}

/// The derivative of the first.
struct SmallKick<'a, X, const D: usize, const M: usize> {
    laws: &'a X,
    share: Number,
    from: &'a Vector<D>,
    half: &'a Vector<D>,
    change: &'a Points<D>,
}

impl<X: Laws<D, M>, const D: usize, const M: usize> Equation<D> for SmallKick<'_, X, D, M> {
    const ROOTS: Roots = Roots::One;

    #[inline(always)]
    fn at(&self, l: usize, p: &[Number; D]) -> [Number; D] {
        let (q, half) = (at(self.from, l), at(self.half, l));
        let rate = self.laws.energy(l).hessian_vector(&q, &half, &at(&self.change.q, l), p).0;
        add_scaled(&at(&self.change.p, l), -self.share, &rate)
    }
}

/// The derivative of the second.
struct SmallDrift<'a, X, const D: usize, const M: usize> {
    laws: &'a X,
    share: Number,
    end: &'a Vector<D>,
    half: &'a Vector<D>,
    out: &'a Vector<D>,
    kick: &'a Vector<D>,
}

impl<X: Laws<D, M>, const D: usize, const M: usize> Equation<D> for SmallDrift<'_, X, D, M> {
    const ROOTS: Roots = Roots::One;

    #[inline(always)]
    fn at(&self, l: usize, q: &[Number; D]) -> [Number; D] {
        let (end, half) = (at(self.end, l), at(self.half, l));
        let rate = self.laws.energy(l).hessian_vector(&end, &half, q, &at(self.kick, l)).1;
        add_scaled(&at(self.out, l), self.share, &rate)
    }
}

/// Iterates from 0, until each rests, in lanes that [go](GOES), and where the `lowest` is [`RESTS`], in those that rest
/// as well; `base` is what x is added to.
#[inline(always)]
fn iterate<E: Equation<D>, const D: usize>(
    equation: &E,
    base: &Vector<D>,
    x: &mut Vector<D>,
    lowest: f64,
    going: &mut Each,
) {
    let lowest = Fused(lowest);
    let [zero, goes, rests, by_itself] = [0.0, GOES, RESTS, BY_ITSELF].map(Fused);
    let [half, two, epsilon, rounding] = [0.5, 2.0, f64::EPSILON, ROUNDING].map(Fused);
    let [of_base, infinity] = [ROUNDING_OF_BASE, f64::INFINITY].map(Fused);
    let (mut settling, mut last) = (ZEROS, [infinity; ROW]);
    // By what components were moved at least, and whether the last move was no half of it.
    let (mut least, mut stalled): (Vector<D>, _) = ([[infinity; ROW]; D], [[false; ROW]; D]);
    // Their largest move of the last few, and of those before; and whether that does not fall.
    let (mut peak, mut peak_before): (Vector<D>, Vector<D>) = ([ZEROS; D], [[infinity; ROW]; D]);
    let mut stuck = [[false; ROW]; D];
    // Their last move, and their first one, from 0.
    let (mut moved, mut way): (Vector<D>, Vector<D>) = ([ZEROS; D], [ZEROS; D]);
    for l in 0..ROW {
        settling[l] = Real::select(lowest.le(going[l]), goes, rests);
    }
    *x = [ZEROS; D];
    for pass in 0..MOST_PASSES {
        // The first one is f(0).
        let (first, end) = (pass == 0, pass + 1 == MOST_PASSES);
        let mut any = false;
        for l in 0..ROW {
            let old = at(x, l);
            let next = equation.at(l, &old);
            let off = add_scaled(&next, Fused(-1.0), &old);
            let (settles, mut rested) = (zero.lt(settling[l]), !first);
            for d in 0..D {
                moved[d][l] = off[d].abs();
                rested &= moved[d][l].le(epsilon * next[d].abs());
                x[d][l] = Real::select(settles, next[d], old[d]);
            }
            settling[l] = Real::select(settles & rested, rests, settling[l]);
            any |= zero.lt(settling[l]);
        }
        if !any {
            break;
        }
        if first {
            way = moved;
            continue;
        }
        // Some are not at their own rounding yet: energies that are separable do not come here.
        any = false;
        for l in 0..ROW {
            let all = rounding * largest(&at(base, l)).max(largest(&at(x, l)));
            let (off, mut rested) = (largest(&at(&moved, l)), true);
            let mut nearer = pass > 1 || E::ROOTS == Roots::One;
            for d in 0..D {
                let moved = moved[d][l];
                nearer |= moved.lt(way[d][l]);
                let (halved, moves) = (moved.lt(half * least[d][l]), zero.lt(moved));
                least[d][l] = Real::select(halved & moves, moved, least[d][l]);
                stalled[d][l] = (moves & !halved) | (!moves & stalled[d][l]);
                peak[d][l] = peak[d][l].max(moved);
                if pass % MOVES == 0 {
                    let (now, before) = (peak[d][l], peak_before[d][l]);
                    let stays = before.le(now) & zero.lt(before);
                    stuck[d][l] = stays | (stuck[d][l] & (half * before).le(now));
                    (peak_before[d][l], peak[d][l]) = (now, zero);
                }
                let size = x[d][l].abs();
                let own = (rounding * size).max(of_base * base[d][l].abs());
                let of_all = stuck[d][l] & moved.max(peak_before[d][l]).le(all);
                rested &= moved.le(epsilon * size) | (stalled[d][l] & moved.le(own)) | of_all;
            }
            let lost = end | (!(nearer & off.lt(two * last[l])) & !off.le(all));
            let now = Real::select(rested, rests, Real::select(lost, by_itself, goes));
            settling[l] = Real::select(zero.lt(settling[l]), now, settling[l]);
            last[l] = off;
            any |= zero.lt(settling[l]);
        }
        if !any {
            break;
        }
    }
    for l in 0..ROW {
        let lost = settling[l].lt(zero);
        going[l] = Real::select(lost, by_itself, going[l]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::functions::PhaseConstraintKernel;

    /// H = c q p; nothing is asked of its constraint.
    #[derive(Clone)]
    struct Product(f64);

    type One = [Number; 1];

    impl HamiltonianKernel<Number, 1> for Product {
        fn value(&self, [q]: &One, [p]: &One) -> Number {
            Fused(self.0) * *q * *p
        }
        fn gradients(&self, [q]: &One, [p]: &One) -> (One, One) {
            ([Fused(self.0) * *p], [Fused(self.0) * *q])
        }
        fn hessian_vector(&self, _: &One, _: &One, dq: &One, dp: &One) -> (One, One) {
            self.gradients(dq, dp)
        }
    }

    impl PhaseConstraintKernel<Number, 1, 1> for Product {
        fn value(&self, _: &One, _: &One) -> One {
            [Fused(0.0)]
        }
        fn jacobians(&self, _: &One, _: &One) -> ([One; 1], [One; 1]) {
            ([[Fused(0.0)]; 1], [[Fused(0.0)]; 1])
        }
        fn value_and_jacobians(&self, q: &One, p: &One) -> (One, [One; 1], [One; 1]) {
            let (by_q, by_p) = self.jacobians(q, p);
            ([Fused(0.0)], by_q, by_p)
        }
        fn hessian_vector(&self, q: &One, p: &One, _: &One, _: &One) -> ([One; 1], [One; 1]) {
            self.jacobians(q, p)
        }
    }

    impl Laws<1, 1> for Product {
        type Constraint = Self;
        type Energy = Self;

        fn constraint(&self, _: usize) -> Self {
            self.clone()
        }
        fn energy(&self, _: usize) -> Self {
            self.clone()
        }
        fn copy(&mut self, _: usize, _: usize) {}
    }

    /// Where the iteration does not converge, lanes that take the step go by themselves: of small changes, those that
    /// are still going.
    #[test]
    fn what_rests_is_asked_for_no_small_changes() {
        let (mut leap, mut small, h) = (Leap::NONE, Points::ZERO, 1.0);
        let point = Points { q: [[Fused(1.0); ROW]], p: [[Fused(1.0); ROW]] };
        let begun = || {
            let mut going = [Fused(RESTS); ROW];
            (going[3], going[5]) = (Fused(GOES), Fused(BY_ITSELF));
            going
        };
        for (c, of_leap, of_small) in
            [(0.5, [RESTS, GOES], [RESTS, GOES]), (4.0, [BY_ITSELF; 2], [RESTS, BY_ITSELF])]
        {
            let mut going = begun();
            leap.leap(&Product(c), h, &point, &mut going);
            assert_eq!([going[0].0, going[3].0, going[5].0], [of_leap[0], of_leap[1], BY_ITSELF]);
            let mut going = begun();
            leap.tangent(&Product(c), h, &point, &point, &mut small, &mut going);
            assert_eq!([going[0].0, going[3].0, going[5].0], [of_small[0], of_small[1], BY_ITSELF]);
        }
    }
}
