//! The RATTLE step of a [block](crate::run::ensemble::block) of trajectories.
//!
//! **The step in four loops** that compilers vectorise, each of them short. A processor has some two hundred
//! instructions in flight at a time, so the time of a loop is proportional to (its instructions) × (the latency of its
//! longest chain), until its arithmetic alone takes longer. [`guess`] evaluates g and ∇g at Λ₀, extrapolated from the
//! last steps; [`improve`] evaluates g₁ after the Newton step Λ₁ = Λ₀ − g₀/s, s = ∇g(q′)·∇g(q), and goes on to the root
//! of the parabola through g₀, s and g₁,
//!
//! ```text
//! Λ₂ = Λ₁ − (g₁/s) (1 + 2t + 5t² + …),   t = g₁/g₀         (the coefficients: binomials of Catalan's numbers)
//! ```
//!
//! [`examine`] evaluates g and ∇g at Λ₂, and makes the last small correction −g₂/s; [`finish`] makes the new way.
//! Without the third term of the series, three times as many steps need a further correction.
//!
//! **Extrapolation** is of Λ|∇g(q)|², a second derivative of g along the path, since Λ itself varies with |∇g| too:
//! with it a third as many steps need a further correction. The last Λ are kept in units of the step to come.
//! (|∇g|²/s)² for what |∇g|² changes by would be known earlier. But s belongs to the guess, whose errors then feed the
//! next guess: they grow from step to step where a step turns by more than a third.
//!
//! **Stopping.** A displacement |g|/|∇g| of at most 256 ε|q|∞ gets one last correction, a chord step, whose remaining
//! error is below rounding. Where the displacement is larger, the lane is corrected again by itself. Squares of
//! displacements are compared, g·(g/s), which take two products. How large |q| is along the normal is measured every 64
//! steps ([`Block::measure_after`]): in double precision a bound that is some times too large still leaves less than
//! rounding. In single precision, where 256 roundings squared are more, they are 32, and measured every 8. ∇g is
//! carried on through the last correction, as it changed on the way from Λ₀: corrections have one sign for many steps,
//! and by ∇g of the place before them the energy drifts by up to 1e-16 of itself a step.
//!
//! **Which root.** |∇g(q)|²/s must be between 2/3 and 2. Lanes where it is not, or that have not converged after three
//! corrections, are lost, and solved as a [`Simulation`](crate::run::simulation::Simulation) does; so is their next
//! step, if other sheets have come near. Where sheets of a surface are closer to each other than the errors of guesses,
//! lanes are moved one by one ([`LookingAround`](crate::run::ensemble::around::LookingAround)).

use crate::kernel::functions::ConstraintKernel;
use crate::motion::failure::Failure;
use crate::number::lanes::{Lane, is_finite};
use crate::number::vector::{add_scaled, dot, scaled, sum, two_sum};
use crate::number::vectors::{Vectors, at, put};
use crate::run::ensemble::block::{Block, LOST, Part, Scratch, extrapolated, not_finite};
use crate::run::ensemble::engine::Stuck;
use crate::run::ensemble::laws::Laws;
use crate::run::ensemble::rest::{at_rest, rest_square};
use crate::systems::surface::normal::Normal;
use crate::systems::surface::position::Departure;
use crate::systems::surface::tiles::{AT_REST, CORRECTIONS};
use std::borrow::Borrow;

/// A last correction of less than this part of the way to it is one: ∇g then changes as on that way.
const LITTLE: f64 = 1.0 / 256.0;

/// Moves all lanes through the next part of a step. Where one cannot be moved the block is left half way.
#[inline(always)]
pub(super) fn step<S, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>(
    block: &mut Block<S, L, D, SUMS, EQUAL>,
    laws: &impl Laws<S, D>,
    parts: &[Part],
    scratch: &mut Scratch<S, L, D>,
) -> Result<(), Stuck>
where
    S: Lane,
{
    let part = &parts[block.part];
    let lost = if const { L == 1 } {
        advance(block, laws, part, &mut Scratch::new())? // in registers
    } else {
        advance(block, laws, part, scratch)?
    };
    block.part = if block.part + 1 == parts.len() { 0 } else { block.part + 1 };
    if lost != 0 {
        let part = &parts[block.part];
        for lane in (0..L).filter(|lane| lost >> lane & 1 != 0) {
            let Block { q, way, normal, square, rest, guess, past, .. } = &mut *block;
            let place = (at(q, lane), at(way, lane), at(normal, lane), square[lane]);
            let (anew, near) = part.guess_anew(laws, lane, place);
            guess[lane] = anew;
            if near {
                rest[lane] = S::from_f64(LOST);
            }
            for past in past {
                past[lane] = S::from_f64(part.before) * guess[lane];
            }
        }
    }
    Ok(())
}

/// x + c·y; x + y where steps are equal.
#[inline(always)]
fn plus<S: Lane, const D: usize, const EQUAL: bool>(x: &[S; D], c: S, y: &[S; D]) -> [S; D] {
    if EQUAL { sum(x, y) } else { add_scaled(x, c, y) }
}

/// q′ − q without the constraint, beyond the way of a step: what sums have kept back.
#[inline(always)]
fn kept_back<S: Lane, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>(
    share: S,
    q_low: &[Vectors<S, L, D>; SUMS],
    way_low: &[Vectors<S, L, D>; SUMS],
    lane: usize,
) -> [S; D] {
    if const { SUMS == 0 } {
        return [S::default(); D];
    }
    plus::<S, D, EQUAL>(&at(&q_low[0], lane), share, &at(&way_low[0], lane))
}

/// One part of a step. Its loops are told what they work on one by one, since compilers then know that no two overlap.
/// Returns which lanes were lost and moved by themselves, a bit for each.
#[inline(always)]
fn advance<S, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>(
    block: &mut Block<S, L, D, SUMS, EQUAL>,
    laws: &impl Laws<S, D>,
    part: &Part,
    scratch: &mut Scratch<S, L, D>,
) -> Result<u64, Stuck>
where
    S: Lane,
{
    let mut lost = 0_u64;
    let Scratch { free, old, first, multiplier, over_slope, g } = scratch;
    let Block { q, way, normal, square, rest, guess: ahead, past, q_low, way_low, .. } = block;
    let share = S::from_f64(part.h / part.unit);
    guess::<S, L, D, SUMS, EQUAL>(
        laws, share, q, way, q_low, way_low, normal, ahead, free, first, multiplier, over_slope, g,
    );
    let unrest;
    if const { L == 1 } {
        // Nothing waits for this lane: it looks at once whether Newton's step was enough.
        g[0] = S::from_f64(1.0) / g[0];
        let newton = Newton { over_first: g[0], over_slope: over_slope[0], multiplier: multiplier[0] };
        let n = at(normal, 0);
        put(old, 0, n);
        let point = add_scaled(&at(free, 0), newton.multiplier, &n);
        let ([residual], [gradient]) = laws.constraint(0).borrow().value_and_jacobian(&point);
        if off_square(residual, newton.over_slope).lt(rest[0]) {
            put(normal, 0, carried(gradient, &at(first, 0), residual * g[0]));
            (multiplier[0], g[0]) =
                last_correction(square[0], residual, newton.multiplier, newton.over_slope);
            unrest = !g[0].lt(rest[0]);
        } else {
            (multiplier[0], over_slope[0]) = newton.improved(residual, rest[0]);
            unrest = examine(laws, old, free, square, rest, first, over_slope, multiplier, g, normal);
        }
    } else {
        improve(laws, normal, free, rest, g, multiplier, over_slope, old);
        unrest = examine(laws, old, free, square, rest, first, over_slope, multiplier, g, normal);
    }
    if unrest {
        for lane in 0..L {
            if g[lane].lt(rest[lane]) {
                continue;
            }
            let n = at(old, lane);
            let path = (&at(free, lane), &n, square[lane], at_rest(&n, &at(q, lane)));
            let astray = !is_finite(g[lane]) || rest[lane].le(S::default());
            let landing =
                if astray { None } else { again(laws.constraint(lane).borrow(), path, multiplier[lane]) };
            let (found, gradient) = match landing {
                Some(landing) => landing,
                None => {
                    lost |= 1 << lane;
                    let back = kept_back::<S, L, D, SUMS, EQUAL>(share, q_low, way_low, lane);
                    let p = scaled(S::from_f64(1.0 / part.unit), &at(way, lane));
                    alone(laws, lane, part.h, (at(q, lane), p, back, n, square[lane]))
                        .map_err(|failure| Stuck { lane, failure: Some(failure) })?
                }
            };
            multiplier[lane] = found;
            put(normal, lane, gradient);
            let place = add_scaled(&at(free, lane), found, &n);
            rest[lane] = rest_square(&gradient, dot(&gradient, &gradient), &place);
        }
    }
    if EQUAL || part.kick != 0.0 {
        finish::<S, L, D, SUMS, EQUAL, true>(
            laws, part, old, normal, free, multiplier, q, way, q_low, way_low, square, ahead, past,
        );
    } else {
        finish::<S, L, D, SUMS, EQUAL, false>(
            laws, part, old, normal, free, multiplier, q, way, q_low, way_low, square, ahead, past,
        );
    }
    Ok(lost)
}

/// Evaluates g at Λ₀ in all lanes and takes Newton's step from there.
#[allow(clippy::too_many_arguments, reason = "see `advance`")]
#[inline(always)]
fn guess<S, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>(
    laws: &impl Laws<S, D>,
    share: S,
    q: &Vectors<S, L, D>,
    way: &Vectors<S, L, D>,
    q_low: &[Vectors<S, L, D>; SUMS],
    way_low: &[Vectors<S, L, D>; SUMS],
    normal: &Vectors<S, L, D>,
    guess: &[S; L],
    free: &mut Vectors<S, L, D>,
    first: &mut Vectors<S, L, D>,
    multiplier: &mut [S; L],
    over_slope: &mut [S; L],
    g: &mut [S; L],
) where
    S: Lane,
{
    for i in 0..L {
        let mut start = at(q, i);
        if const { SUMS == 1 } {
            start = sum(&start, &kept_back::<S, L, D, SUMS, EQUAL>(share, q_low, way_low, i));
        }
        let (start, n) = (plus::<S, D, EQUAL>(&start, share, &at(way, i)), at(normal, i));
        let ([residual], [gradient]) =
            laws.constraint(i).borrow().value_and_jacobian(&add_scaled(&start, guess[i], &n));
        let over = S::from_f64(1.0) / dot(&gradient, &n);
        put(free, i, start);
        put(first, i, gradient);
        multiplier[i] = (-residual).multiply_add(over, guess[i]);
        (over_slope[i], g[i]) = (over, residual);
    }
}

/// Evaluates g after Newton's step in all lanes, and finds Λ₂; g₀ becomes 1/g₀. Normals are copied on the way: here is
/// time for it.
#[allow(clippy::too_many_arguments, reason = "see `advance`")]
#[inline(always)]
fn improve<S, const L: usize, const D: usize>(
    laws: &impl Laws<S, D>,
    normal: &Vectors<S, L, D>,
    free: &Vectors<S, L, D>,
    rest: &[S; L],
    g: &mut [S; L],
    multiplier: &mut [S; L],
    over_slope: &mut [S; L],
    old: &mut Vectors<S, L, D>,
) where
    S: Lane,
{
    for i in 0..L {
        g[i] = S::from_f64(1.0) / g[i];
        let newton = Newton { over_first: g[i], over_slope: over_slope[i], multiplier: multiplier[i] };
        let n = at(normal, i);
        put(old, i, n);
        let point = add_scaled(&at(free, i), newton.multiplier, &n);
        let [residual] = laws.constraint(i).borrow().value(&point);
        (multiplier[i], over_slope[i]) = newton.improved(residual, rest[i]);
    }
}

/// Newton's step from the guess.
struct Newton<S> {
    /// 1/g₀, at the guess.
    over_first: S,
    /// 1/s.
    over_slope: S,
    /// Λ₁.
    multiplier: S,
}

impl<S: Lane> Newton<S> {
    /// Λ₂ and 1/s there, from g₁; Λ₁ and 1/s where that is at rest, as a lane that is alone looks at once.
    #[inline(always)]
    fn improved(&self, residual: S, rest: S) -> (S, S) {
        let [zero, one, two, five, most] = [0.0, 1.0, 2.0, 5.0, 0.0625].map(S::from_f64);
        let change = residual * self.over_slope;
        let rests = off_square(residual, self.over_slope).lt(rest);
        let ratio = S::select(rests, zero, residual * self.over_first);
        let ratio = S::select(ratio.lt(most), ratio, most);
        let ratio = S::select((-most).lt(ratio), ratio, -most); // also where g₀ is 0, and the ratio not a number
        let series = five.multiply_add(ratio, two).multiply_add(ratio, one);
        let improved = (-change).multiply_add(series, self.multiplier);
        (S::select(rests, self.multiplier, improved), self.over_slope * series)
    }
}

/// Evaluates g and ∇g at Λ₂ and makes the last correction. Returns whether a lane is not at rest.
#[allow(clippy::too_many_arguments, reason = "see `advance`")]
#[inline(always)]
fn examine<S, const L: usize, const D: usize>(
    laws: &impl Laws<S, D>,
    normal: &Vectors<S, L, D>,
    free: &Vectors<S, L, D>,
    square: &[S; L],
    rest: &[S; L],
    first: &Vectors<S, L, D>,
    over_slope: &[S; L],
    multiplier: &mut [S; L],
    g: &mut [S; L],
    next: &mut Vectors<S, L, D>,
) -> bool
where
    S: Lane,
{
    let mut unrest = false;
    for i in 0..L {
        let n = at(normal, i);
        let point = add_scaled(&at(free, i), multiplier[i], &n);
        let ([residual], [gradient]) = laws.constraint(i).borrow().value_and_jacobian(&point);
        put(next, i, carried(gradient, &at(first, i), residual * g[i]));
        (multiplier[i], g[i]) = last_correction(square[i], residual, multiplier[i], over_slope[i]);
        unrest |= !g[i].lt(rest[i]); // also where it is not a number
    }
    unrest
}

/// The square of the displacement |g|/|∇g|.
#[inline(always)]
fn off_square<S: Lane>(residual: S, over_slope: S) -> S {
    residual * (residual * over_slope)
}

/// Λ after the last correction, and how far off it was before, squared, or not a number where the surface may have been
/// left.
#[inline(always)]
fn last_correction<S: Lane>(square: S, residual: S, multiplier: S, over_slope: S) -> (S, S) {
    let [middle, off, nan] = [4.0 / 3.0, 2.0 / 3.0, f64::NAN].map(S::from_f64);
    let near = over_slope.multiply_add(square, -middle).abs().le(off);
    let off = off_square(residual, over_slope);
    ((-residual).multiply_add(over_slope, multiplier), S::select(near, off, nan))
}

/// ∇g after the last correction, as it changed from Λ₀ on, of which way that is the share g₂/g₀.
#[inline(always)]
fn carried<S: Lane, const D: usize>(gradient: [S; D], first: &[S; D], share: S) -> [S; D] {
    let is_little = share.abs().lt(S::from_f64(LITTLE)); // not where g₀ is 0, and the share not a number
    let share = S::select(is_little, share, S::from_f64(0.0));
    add_scaled(&gradient, share, &add_scaled(&gradient, S::from_f64(-1.0), first))
}

/// Λ and ∇g of a lane that is corrected again, unless it goes astray.
#[inline(always)]
fn again<S: Lane, K: ConstraintKernel<S, D, 1>, const D: usize>(
    constraint: &K,
    (free, n, square, rest): (&[S; D], &[S; D], S, S),
    mut multiplier: S,
) -> Option<(S, [S; D])> {
    for _ in 0..CORRECTIONS {
        let ([residual], [gradient]) = constraint.value_and_jacobian(&add_scaled(free, multiplier, n));
        let slope = dot(&gradient, n);
        let off = (slope - square).abs();
        if !(off + off).le(square) {
            return None;
        }
        multiplier = multiplier - residual / slope;
        if residual.abs().le(rest) {
            let is_there = (S::from_f64(AT_REST) * residual.abs()).le(rest); // but for a rounding
            let there = || constraint.jacobian(&add_scaled(free, multiplier, n))[0];
            return Some((multiplier, if is_there { gradient } else { there() }));
        }
    }
    None
}

/// Makes the new positions and ways, and the next guess. Without kicks no force is evaluated.
#[allow(clippy::too_many_arguments, reason = "see `advance`")]
#[inline(always)]
fn finish<S, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool, const KICKS: bool>(
    laws: &impl Laws<S, D>,
    part: &Part,
    normal: &Vectors<S, L, D>,
    next: &Vectors<S, L, D>,
    free: &Vectors<S, L, D>,
    multiplier: &[S; L],
    q: &mut Vectors<S, L, D>,
    way: &mut Vectors<S, L, D>,
    q_low: &mut [Vectors<S, L, D>; SUMS],
    way_low: &mut [Vectors<S, L, D>; SUMS],
    square: &mut [S; L],
    guess: &mut [S; L],
    [last, earlier]: &mut [[S; L]; 2],
) where
    S: Lane,
{
    let [share, kick] = [part.h / part.unit, part.unit * part.kick].map(S::from_f64);
    let [over_share, rest_of_share] = part.over.map(S::from_f64);
    let weights = part.weights.map(S::from_f64);
    for i in 0..L {
        let (n, m, old, found) = (at(normal, i), at(next, i), at(way, i), multiplier[i]);
        let place = if const { SUMS == 0 } {
            add_scaled(&at(free, i), found, &n)
        } else {
            let back = kept_back::<S, L, D, SUMS, EQUAL>(share, q_low, way_low, i);
            let change = add_scaled(&plus::<S, D, EQUAL>(&back, share, &old), found, &n);
            let (place, low) = two_sum(&at(q, i), &change);
            put(&mut q_low[0], i, low);
            place
        };
        let push = if EQUAL { found } else { over_share * found };
        let length = dot(&m, &m);
        // Equal steps: Λ of the next one projects.
        let project = |change: [S; D], along: S| {
            if EQUAL { change } else { add_scaled(&change, -along / length, &m) }
        };
        let kicked = |p: [S; D]| if KICKS { laws.kick(i, &place, kick, p) } else { p };
        let new = if const { SUMS == 0 } {
            let pushed = kicked(add_scaled(&old, push, &n));
            project(pushed, dot(&m, &pushed))
        } else {
            let mut low = at(&way_low[0], i);
            if !EQUAL {
                low = add_scaled(&low, rest_of_share * found, &n);
            }
            let change = kicked(add_scaled(&low, push, &n));
            let (new, low) = two_sum(&old, &project(change, dot(&m, &sum(&old, &change))));
            put(&mut way_low[0], i, low);
            new
        };
        put(q, i, place);
        put(way, i, new);
        let ratio = square[i] / length;
        square[i] = length;
        guess[i] = ratio * extrapolated(EQUAL, weights, found, last[i], earlier[i]);
        earlier[i] = ratio * last[i];
        last[i] = ratio * found;
    }
}

/// Λ and ∇g(q′) of a lane by itself, as [`Simulation`](crate::run::simulation::Simulation) finds them: from a tangent
/// momentum. What p leads off the surface, and Λ puts back, is added in the end.
#[cold]
#[inline(never)]
fn alone<S: Lane, const D: usize>(
    laws: &impl Laws<S, D>,
    lane: usize,
    h: f64,
    (q, p, back, gradient, square): ([S; D], [S; D], [S; D], [S; D], S),
) -> Result<(S, [S; D]), Failure> {
    let step = S::from_f64(h);
    let normal = Normal { gradient, inverse_square: S::from_f64(1.0) / square };
    let (eta, back_on) = normal.projection(&p);
    let p = sum(&p, &back_on);
    if !is_finite(dot(&p, &p)) {
        return Err(not_finite(laws, lane, q)); // by a kick between stages
    }
    let constraint = laws.constraint(lane);
    let constraint = constraint.borrow();
    let departure = Departure::coasting(constraint, h, 0, [&q, &back, &p], &normal);
    let landing = departure.land(constraint)?;
    Ok((landing.multiplier + step * eta, landing.gradient))
}
