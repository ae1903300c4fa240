//! Many bodies on a surface, several at a time: the two halves of a step as plain loops over a tile of bodies, which a
//! compiler vectorises, entered through one function per instruction set.
//!
//! The position equation is solved as [`solver`](crate::systems::surface::position) says, by one cycle of Ostrowski's
//! iteration from g₀, ∇g₀ and g₁, and a Newton step from where that leads, with g₂ and ∇g₂:
//!
//! ```text
//! Λ₁ = Λ₀ − g₀/s₀      Λ₂ = Λ₁ − (g₁/s₀) g₀/(g₀ − 2g₁)      Λ₃ = Λ₂ − g₂/s₂      sᵢ = ∇gᵢ·∇g(q)
//! ```
//!
//! Divisions take a processor ten times as long as products, so that there are as few as may be.
//!
//! Corrections below the rounding of the position are not applied, so converged bodies do not change. A body whose last
//! Newton step was not small takes further ones by itself. Bodies that do not converge, or whose root is not trusted,
//! are left to be moved one by one; so are those near other sheets ([`crate::systems::surface::around`]).
//!
//! The motion of a body does not depend on the other bodies of its tile.

use crate::effect::force::Force;
use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::kernel::functions::ConstraintKernel;
use crate::kernel::rounding::size_along_square;
use crate::motion::bodies::Count;
use crate::motion::failure::Failure;
use crate::motion::iteration::Newton;
use crate::motion::witness::Witness;
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::Fused;
use crate::number::real::{Real, Scalar};
use crate::number::vector::{add_scaled, dot, scaled, sum, two_sum};
use crate::number::vectors::{CHUNK, LANES, MOST_COORDINATES, at, put};
use crate::solve::root::{FAR_GUESS, is_the_root};
use crate::systems::surface::around::Around;
use crate::systems::surface::diagnosis::FailureAt;
use crate::systems::surface::in_lanes::{InEach, Number, Numbers, TileInLanes};
use crate::systems::surface::kept::{BodiesOf, OnSurface, OneByOne};
use crate::systems::surface::normal::Normal;
use crate::systems::surface::step::is_finite;
use crate::systems::surface::tile::{Tile, fused, plain};
use std::any::TypeId;
use std::array::from_fn;
use std::ops::Range;

/// From so many bodies on it pays.
const MANY: usize = CHUNK;

/// Newton steps of a body by itself before it is left to be moved alone.
pub(crate) const CORRECTIONS: usize = 3;

/// At rest where the last correction is at most so many roundings of the position: Newton's step leaves its square.
pub(crate) const AT_REST: f64 = 256.0;

/// Whether a scene may have so many bodies. Where it may not, what is done in tiles is not mentioned: it is the value
/// of a constant. For the compiler goes through all that a function mentions.
const fn may_go_in_tiles<N: Count, const D: usize>() -> bool {
    N::MANY && D <= MOST_COORDINATES
}

/// [`drift_in_tiles`](OnSurface::drift_in_tiles) of a system, or none.
type Drifts<Y, T, B, W> = Option<fn(&Y, Fusing, f64, f64, &[T], &mut B, &mut W) -> Result<(), Failure>>;
/// [`settle_in_tiles`](OnSurface::settle_in_tiles) of a system, or none.
type Settles<Y, B, W> = Option<fn(&Y, Fusing, f64, f64, &mut B, &mut W) -> Result<(), Failure>>;
/// [`fuse_all`](OnSurface::fuse_all) of a system, or none.
type Fuses<Y, B> = Option<fn(&Y, &mut B)>;

impl<K, F, N: Count, L> OnSurface<K, F, N, L> {
    /// The first half of a step, of scenes that may go in tiles.
    pub(super) const fn drifts<T: Scalar, W: Witness<T>, const D: usize>()
    -> Drifts<Self, T, BodiesOf<N, T, F, D>, W>
    where
        K: ConstraintKernel<T, D, 1>,
        L: ConstraintKernel<Number, D, 1>,
        F: Forces<T, D>,
    {
        if may_go_in_tiles::<N, D>() { Some(Self::drift_in_tiles::<T, W, D>) } else { None }
    }

    /// The second half of a step, of scenes that may go in tiles.
    pub(super) const fn settles<T: Scalar, W: Witness<T>, const D: usize>()
    -> Settles<Self, BodiesOf<N, T, F, D>, W>
    where
        F: Forces<T, D>,
    {
        if may_go_in_tiles::<N, D>() { Some(Self::settle_in_tiles::<T, W, D>) } else { None }
    }

    /// Instructions for so many bodies at a time, if there are any: with fused multiply-add, for doubles.
    #[inline(always)]
    pub(super) fn instructions<T: Scalar, const D: usize>(&self) -> Option<Fusing>
    where
        L: 'static,
    {
        let may = const { may_go_in_tiles::<N, D>() } && TypeId::of::<L>() != TypeId::of::<OneByOne>();
        if may && self.count.number() >= MANY && T::doubles::<D>(&[]).is_some() {
            Fusing::widest()
        } else {
            None
        }
    }

    /// The first half of a step of all bodies.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "what a step knows when it departs")]
    fn drift_in_tiles<T: Scalar, W: Witness<T>, const D: usize>(
        &self,
        set: Fusing,
        kick: f64,
        h: f64,
        guess: &[T],
        bodies: &mut BodiesOf<N, T, F, D>,
        witness: &mut W,
    ) -> Result<(), Failure>
    where
        K: ConstraintKernel<T, D, 1>,
        L: ConstraintKernel<Number, D, 1>,
        F: Forces<T, D>,
    {
        let turn = bodies.kept.crowd.turn(h);
        for (number, tile) in tiles(self.count.number()).enumerate() {
            if let Some((turn, h)) = turn {
                // As at first where a sheet was near: a few places may all miss it.
                let turn = if bodies.kept.crowd.of_tile(number) == 0 { turn } else { 0 };
                let of_tile = Tile::of(bodies, tile.clone());
                let around = Around { constraint: &self.in_lanes, bodies: of_tile, h, turn };
                let near = set.run(around);
                bodies.kept.crowd.note(number, near);
            }
            let crowd = bodies.kept.crowd.of_tile(number);
            let mut left = set.run(Drift {
                crowd,
                constraint: &self.in_lanes,
                kick,
                h,
                guess: guess.get(tile.clone()).unwrap_or(&[]),
                bodies: Tile::of(bodies, tile.clone()),
            });
            if W::LISTENS {
                let moved = Tile::of(bodies, tile.clone());
                for i in (0..tile.len()).filter(|i| left >> i & 1 == 0) {
                    witness.position_multiplier(tile.start + i, moved.multiplier(i));
                }
            }
            while left != 0 {
                let body = tile.start + left.trailing_zeros() as usize;
                let nothing = [f64::NAN; 2]; // is known of steps before
                bodies.drift::<Newton, _, _>(kick, h, None, nothing, &self.constraint, body, witness)?;
                bodies.kept.normal.as_mut()[body] = fused_normal(&self.in_lanes, &bodies.q.as_ref()[body]);
                left &= left - 1;
            }
        }
        Ok(())
    }

    /// The second half of a step of all bodies.
    #[inline(always)]
    fn settle_in_tiles<T: Scalar, W: Witness<T>, const D: usize>(
        &self,
        set: Fusing,
        kick: f64,
        h: f64,
        bodies: &mut BodiesOf<N, T, F, D>,
        witness: &mut W,
    ) -> Result<(), Failure>
    where
        F: Forces<T, D>,
    {
        for tile in tiles(self.count.number()) {
            let of_tile = Tile::of(bodies, tile.clone());
            if !set.run(Settle { kick, h, bodies: of_tile }) {
                let (p, kept) = (&bodies.p.as_ref()[tile.clone()], &bodies.kept);
                let at = Moment { time: bodies.time, positions: bodies.q.as_ref() };
                let infinite = p.iter().position(|p| !is_finite(p)).unwrap_or(0);
                let failure = FailureAt::of(tile.start + infinite);
                return Err(failure.not_finite(&self.effects, at, kept.normal.as_ref()));
            }
            if W::LISTENS {
                let moved = Tile::of(bodies, tile.clone());
                for i in 0..tile.len() {
                    witness.momentum_multiplier(tile.start + i, moved.multiplier(i));
                }
            }
        }
        Ok(())
    }

    /// Evaluates all normals if bodies go in tiles, and says whether they do: what is kept must be a function of the
    /// positions, to the bit, also after steps that move them one by one.
    #[inline(always)]
    pub(super) fn fuse_normals<T: Scalar, const D: usize>(&self, bodies: &mut BodiesOf<N, T, F, D>) -> bool
    where
        L: ConstraintKernel<Number, D, 1>,
        F: Forces<T, D>,
    {
        match const { Self::fuses::<T, D>() } {
            Some(fuse) if self.instructions::<T, D>().is_some() => fuse(self, bodies),
            _ => return false,
        }
        true
    }

    const fn fuses<T: Scalar, const D: usize>() -> Fuses<Self, BodiesOf<N, T, F, D>>
    where
        L: ConstraintKernel<Number, D, 1>,
        F: Forces<T, D>,
    {
        if may_go_in_tiles::<N, D>() { Some(Self::fuse_all::<T, D>) } else { None }
    }

    #[inline(always)]
    fn fuse_all<T: Scalar, const D: usize>(&self, bodies: &mut BodiesOf<N, T, F, D>)
    where
        L: ConstraintKernel<Number, D, 1>,
        F: Forces<T, D>,
    {
        for (normal, q) in bodies.kept.normal.as_mut().iter_mut().zip(bodies.q.as_ref()) {
            *normal = fused_normal(&self.in_lanes, q);
        }
    }
}

/// The normal with products that are not rounded.
fn fused_normal<T: Scalar, K: ConstraintKernel<Number, D, 1>, const D: usize>(
    constraint: &K,
    q: &[T; D],
) -> Normal<T, D> {
    let [gradient] = constraint.jacobian(&q.map(fused));
    let Normal { gradient, inverse_square } = Normal::new(gradient);
    Normal { gradient: gradient.map(plain), inverse_square: plain(inverse_square) }
}

/// Bodies in tiles of 64, 24 or 16 lanes, and of [`CHUNK`] bodies at least. More widths would pay by a tenth and take a
/// second each to compile.
fn tiles(number: usize) -> impl Iterator<Item = Range<usize>> {
    let mut first = 0;
    std::iter::from_fn(move || {
        let left = number - first;
        let most = match left {
            0..=16 | 25..=32 => 16,
            17..=24 | 33..=48 => 24,
            _ if left > LANES && left < LANES + CHUNK => LANES - CHUNK,
            _ => LANES,
        };
        let next = first + left.min(most);
        (left > 0).then(|| std::mem::replace(&mut first, next)..next)
    })
}

/// How many tiles so many bodies go in.
pub(super) fn tiles_of(bodies: usize) -> usize {
    if bodies < MANY { 0 } else { tiles(bodies).count() }
}

/// A bit for each of so many bodies.
#[inline(always)]
pub(super) fn all(number: usize) -> u64 {
    u64::MAX >> (LANES - number)
}

#[inline(always)]
fn either<const D: usize>(first: bool, a: [Number; D], b: [Number; D]) -> [Number; D] {
    from_fn(|d| Real::select(first, a[d], b[d]))
}

/// Where a body would land.
#[inline(always)]
fn point<const D: usize>(
    q: &InEach<D>,
    free: &InEach<D>,
    normal: &InEach<D>,
    multiplier: &Numbers,
    l: usize,
) -> [Number; D] {
    sum(&at(q, l), &add_scaled(&at(free, l), multiplier[l], &at(normal, l)))
}

/// Λ after a correction, unless that is at the rounding of the position; and 1 if the body then rests.
#[inline(always)]
fn corrected(
    multiplier: Number,
    correction: Number,
    square: Number,
    floor_square: Number,
) -> (Number, Number) {
    let off_square = correction * correction * square;
    let there = off_square.le(floor_square);
    let rests = off_square.le(Fused(AT_REST * AT_REST) * floor_square);
    let correction = Real::select(there, Fused(0.0), correction);
    (multiplier + correction, Real::select(rests, Fused(1.0), Fused(0.0)))
}

/// The first half of a step of at most [`LANES`] bodies.
struct Drift<'a, T, K, F, const D: usize> {
    constraint: &'a K,
    kick: f64,
    h: f64,
    /// λ, or nothing: then from g̈ = 0.
    guess: &'a [T],
    /// Those that stay where they are in any case.
    crowd: u64,
    bodies: Tile<'a, T, F, D>,
}

impl<T: Scalar, K: ConstraintKernel<Number, D, 1>, F: Force<T, D>, const D: usize> Work
    for Drift<'_, T, K, F, D>
{
    /// A bit for each body that has been left where it was.
    type Done = u64;

    #[inline(always)]
    fn run(self) -> u64 {
        match self.bodies.q.len() {
            0..=16 => self.in_lanes::<16>(),
            17..=24 => self.in_lanes::<24>(),
            _ => self.in_lanes::<LANES>(),
        }
    }
}

impl<T: Scalar, K: ConstraintKernel<Number, D, 1>, F: Force<T, D>, const D: usize> Drift<'_, T, K, F, D> {
    #[inline(always)]
    fn in_lanes<const L: usize>(self) -> u64 {
        let Self { constraint, kick, h, guess, crowd, mut bodies } = self;
        let constraint = constraint.clone(); // out of reach of what the loops write
        let (number, chunks) = (bodies.q.len(), bodies.chunks);
        // `share` of the force in the motion: 1 for RATTLE.
        let [step, pushed, half_square, share] = [h, h * kick, 0.5 * h * h, 2.0 * kick / h].map(Fused);
        let over_half_square = Fused(1.0) / half_square;
        let lanes = bodies.spread();
        let TileInLanes { q, q_low, p, p_low, normal, force, free, next, inverse_square, square, .. } = lanes;
        let TileInLanes { multiplier, bend, floor_square, path_square, first, g, slope, over_slope, .. } =
            lanes;
        let TileInLanes { gentle, rests, arrives, .. } = lanes;

        if guess.is_empty() {
            for l in 0..L {
                [bend[l]] = constraint.jet(&at(q, l), &at(p, l)).2;
            }
        } else {
            for l in 0..L {
                let (n, lambda) = (at(normal, l), fused(guess[l.min(number - 1)]));
                let along = if F::ACTS { share * dot(&at(force, l), &n) } else { Fused(0.0) };
                bend[l] = -lambda.multiply_add(dot(&n, &n), along);
            }
        }
        for l in 0..L {
            let (q, p, n) = (at(q, l), at(p, l), at(normal, l));
            let mut way = sum(&scaled(step, &p), &add_scaled(&at(q_low, l), step, &at(p_low, l)));
            let (speed_square, mut along) = (dot(&p, &p), bend[l]);
            path_square[l] = step * step * speed_square;
            if F::ACTS {
                let force = at(force, l);
                way = add_scaled(&way, pushed, &force);
                along = share.multiply_add(dot(&force, &n), along);
                path_square[l] = (pushed * pushed).multiply_add(dot(&force, &force), path_square[l]);
            }
            put(free, l, way);
            multiplier[l] = -half_square * along * inverse_square[l];
            let is_gentle =
                (Fused(4.0) * step * step * bend[l] * bend[l] * inverse_square[l]).le(speed_square);
            gentle[l] = Real::select(is_gentle, Fused(1.0), Fused(0.0));
            square[l] = dot(&n, &n);
            let places: [_; D] = from_fn(|i| q[i].abs().max(way[i].abs()));
            let size_square = size_along_square(&n, inverse_square[l], &places);
            floor_square[l] = Fused(f64::EPSILON * f64::EPSILON) * size_square;
            // Less than the least of numbers tells nobody who has arrived.
            let tells = Fused(f64::MIN_POSITIVE).le(floor_square[l]);
            gentle[l] = Real::select(tells, gentle[l], Fused(0.0));
        }

        for l in 0..L {
            let point = point(q, free, normal, multiplier, l);
            let ([residual], [gradient]) = constraint.value_and_jacobian(&point);
            g[l] = residual;
            slope[l] = dot(&gradient, &at(normal, l));
            over_slope[l] = Fused(1.0) / slope[l];
            first[l] = -residual * over_slope[l];
            let there = (first[l] * first[l] * square[l]).le(floor_square[l]);
            multiplier[l] = multiplier[l] + Real::select(there, Fused(0.0), first[l]);
        }
        for l in 0..L {
            let [residual] = constraint.value(&point(q, free, normal, multiplier, l));
            let ostrowski = -residual * over_slope[l] * (g[l] / Fused(-2.0).multiply_add(residual, g[l]));
            let going = floor_square[l].lt(first[l] * first[l] * square[l]);
            let near = going & residual.abs().lt(Fused(0.25) * g[l].abs()); // else the parabola says nothing
            multiplier[l] = multiplier[l] + Real::select(near, ostrowski, Fused(0.0));
        }
        for l in 0..L {
            let point = point(q, free, normal, multiplier, l);
            let ([residual], [gradient]) = constraint.value_and_jacobian(&point);
            let last = -residual / dot(&gradient, &at(normal, l));
            (multiplier[l], rests[l]) = corrected(multiplier[l], last, square[l], floor_square[l]);
        }
        for begin in chunks.begins() {
            let chunk = begin..begin + chunks.length();
            for _ in 0..CORRECTIONS {
                if rests[chunk.clone()].iter().all(|&rests| rests == Fused(1.0)) {
                    break;
                }
                for l in chunk.clone() {
                    let point = point(q, free, normal, multiplier, l);
                    let ([residual], [gradient]) = constraint.value_and_jacobian(&point);
                    let last = -residual / dot(&gradient, &at(normal, l));
                    let further = corrected(multiplier[l], last, square[l], floor_square[l]);
                    let rested = rests[l] == Fused(1.0);
                    multiplier[l] = Real::select(rested, multiplier[l], further.0);
                    rests[l] = Real::select(rested, rests[l], further.1);
                }
            }
        }
        for l in 0..L {
            let [gradient] = constraint.jacobian(&point(q, free, normal, multiplier, l));
            let off_square = first[l] * first[l] * square[l];
            let last_slope = dot(&gradient, &at(normal, l));
            let root = is_the_root(off_square, [square[l], slope[l], last_slope], path_square[l], FAR_GUESS);
            put(next, l, gradient);
            arrives[l] = Real::select(root, rests[l] * gentle[l], Fused(0.0));
        }
        if crowd != 0 {
            for l in 0..L {
                arrives[l] = if crowd >> l & 1 == 0 { arrives[l] } else { Fused(0.0) };
            }
        }
        let mut left = 0;
        for l in 0..L {
            left |= u64::from(arrives[l] == Fused(0.0)) << l;
        }

        for l in 0..L {
            let (n, arrives) = (at(normal, l), arrives[l] == Fused(1.0));
            let mut change = add_scaled(&at(p_low, l), multiplier[l] / step, &n);
            if F::ACTS {
                change = add_scaled(&change, Fused(kick), &at(force, l));
            }
            let (high, rest) = two_sum(&at(p, l), &change);
            let (high, rest) = (either(arrives, high, at(p, l)), either(arrives, rest, at(p_low, l)));
            put(p, l, high);
            put(p_low, l, rest);
        }
        for l in 0..L {
            let (n, arrives) = (at(normal, l), arrives[l] == Fused(1.0));
            let (high, rest) = two_sum(&at(q, l), &add_scaled(&at(free, l), multiplier[l], &n));
            let (high, rest) = (either(arrives, high, at(q, l)), either(arrives, rest, at(q_low, l)));
            put(q, l, high);
            put(q_low, l, rest);
        }
        for l in 0..L {
            let (gradient, arrives) = (at(next, l), arrives[l] == Fused(1.0));
            let inverse = Normal::new(gradient).inverse_square;
            inverse_square[l] = Real::select(arrives, inverse, inverse_square[l]);
            let gradient = either(arrives, gradient, at(normal, l));
            put(normal, l, gradient);
            multiplier[l] = multiplier[l] * over_half_square;
        }
        bodies.keep_places();
        bodies.keep_momenta();
        left & all(number)
    }
}

/// The second half of a step of at most [`LANES`] bodies.
struct Settle<'a, T, F, const D: usize> {
    kick: f64,
    h: f64,
    bodies: Tile<'a, T, F, D>,
}

impl<T: Scalar, F: Force<T, D>, const D: usize> Work for Settle<'_, T, F, D> {
    /// Whether all momenta are numbers.
    type Done = bool;

    #[inline(always)]
    fn run(self) -> bool {
        match self.bodies.q.len() {
            0..=16 => self.in_lanes::<16>(),
            17..=24 => self.in_lanes::<24>(),
            _ => self.in_lanes::<LANES>(),
        }
    }
}

impl<T: Scalar, F: Force<T, D>, const D: usize> Settle<'_, T, F, D> {
    #[inline(always)]
    fn in_lanes<const L: usize>(self) -> bool {
        let Self { kick, h, mut bodies } = self;
        let over_half = Fused(1.0 / (0.5 * h));
        let TileInLanes { p, p_low, normal, force, inverse_square, multiplier, .. } = bodies.spread_momenta();
        let mut finite = true;
        for l in 0..L {
            let (moving, n) = (at(p, l), at(normal, l));
            let mut change = at(p_low, l);
            if F::ACTS {
                change = add_scaled(&change, Fused(kick), &at(force, l));
            }
            let eta = -dot(&n, &sum(&moving, &change)) * inverse_square[l];
            multiplier[l] = eta * over_half;
            let (high, rest) = two_sum(&moving, &add_scaled(&change, eta, &n));
            put(p, l, high);
            put(p_low, l, rest);
            finite &= is_finite(&high);
        }
        bodies.keep_momenta();
        finite
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_body_is_in_one_tile_of_a_chunk_at_least() {
        for number in MANY..1000 {
            let mut next = 0;
            for tile in tiles(number) {
                assert_eq!(tile.start, next, "{number} bodies");
                assert!((CHUNK..=LANES).contains(&tile.len()), "{number} bodies: {tile:?}");
                next = tile.end;
            }
            assert_eq!(next, number);
        }
    }
}
