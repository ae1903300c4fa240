//! Collocation ([`lobatto`](crate::methods::lobatto)) for trajectories in lanes.
//!
//! ```text
//! Qᵢ = q + h cᵢ p + h² Σⱼ aᵢⱼ wⱼ       wⱼ = f(Qⱼ) + ∇g(Qⱼ) λⱼ       0 = g(Qᵢ),   i = 2 … s,   Q₁ = q
//! p′ = p + h Σⱼ bⱼ wⱼ                   λₛ such that ∇g(q′)·p′ = 0,   q′ = Qₛ
//! ```
//!
//! **First guess:** w and λ are the polynomials through the last step's stages and this step's exact start. **A pass**
//! evaluates g, ∇g and f at all stages, forms the sums, and corrects λ by Newton's method and the matrix of the first
//! pass, h² aᵢⱼ ∇g(Qᵢ)·∇g(Qⱼ), as in [`crate::systems::surface::collocation`]. **A lane has converged** where the
//! displacement of the next pass, estimated from the last ones, is below half a rounding. Its stages and λ are then not
//! changed, however many passes its neighbours take. A last evaluation of ∇g and f at the final stages gives w, so that
//! momenta are kicked by the forces there.
//!
//! **Not in lanes:** a lane whose guess has a large error, that does not converge, whose normals reverse, or that may
//! end on another sheet takes the step by itself, as a [`Simulation`](crate::run::simulation::Simulation) does.

use crate::kernel::functions::ConstraintKernel;
use crate::number::lanes::Lane;
use crate::number::vector::{add_scaled, dot, largest, scaled, sum, two_sum};
use crate::number::vectors::{Vectors, at, put};
use crate::run::ensemble::laws::Laws;
use crate::run::ensemble::row::{BY_ITSELF, End, LOOKING, Row, Scratch, Tableau, pull};
use crate::solve::aim::{INSIDE, OFF_INSIDE, ROUNDINGS};
use crate::solve::stop::{LAST_OF_STAGES, NOISE};
use std::array::from_fn;
use std::borrow::Borrow;

/// Passes after which a lane goes by itself.
const MOST_PASSES: usize = 24;

/// A guess that is off by more than this part of the path is not trusted. (Where the step ends is looked at whatever
/// the guess was, so that this may be more than in a simulation.)
const FAR_GUESS: f64 = 5e-2;

/// No pass is trusted to shrink what is left by more than this.
const SHRINKS: f64 = 1e-3;

/// Finds where one step leads all lanes. Says whether it may be [taken](Row::take) as it is; if not, `going` tells
/// which lanes have to go by themselves, or have to look around first.
#[inline(always)]
pub(super) fn advance<S, const L: usize, const D: usize, const SUMS: usize, const N: usize>(
    row: &Row<S, L, D, SUMS, N>,
    laws: &impl Laws<S, D>,
    tableau: &Tableau<S, N>,
    scratch: &mut Scratch<S, L, D, N>,
) -> bool
where
    S: Lane,
{
    let Row { q, p, q_low, p_low, normal: at_start, total: past, lambda: past_lambda, asked, .. } = row;
    let Scratch {
        v,
        place,
        increment,
        normal,
        total,
        lambda,
        push,
        residual,
        matrix,
        moved,
        before,
        size,
        path,
        going,
        end,
    } = scratch;
    *v = *p;
    for d in 0..D * SUMS {
        for i in 0..L {
            v[d][i] = p[d][i] + p_low[0][d][i];
        }
    }
    extrapolate(&tableau.ahead, past, past_lambda, total, lambda);
    normal[0] = *at_start;
    *going = [S::from_f64(1.0); L];
    for d in 0..D {
        for i in 1..N {
            displace::<S, L, N>(&tableau.drift, &tableau.push, i, d, v, total, increment);
            let (from, to, increment) = (&q[d], &mut place[i][d], &increment[i][d]);
            if SUMS == 0 {
                for l in 0..L {
                    to[l] = from[l] + increment[l];
                }
            } else {
                let low = &q_low[0][d];
                for l in 0..L {
                    to[l] = from[l] + (low[l] + increment[l]);
                }
            }
        }
    }
    for l in 0..L {
        let (end, away) = (at(&place[N - 1], l), at(&increment[N - 1], l));
        path[l] = largest(&away);
        size[l] = largest(&at(q, l)).max(largest(&end));
    }
    for pass in 0..MOST_PASSES {
        for i in 1..N {
            evaluate(laws, i, place, lambda, residual, normal, total);
        }
        first_total(past, past_lambda, lambda, normal, total);
        for d in 0..D {
            for i in 1..N {
                displace::<S, L, N>(&tableau.drift, &tableau.push, i, d, v, total, increment);
                linearise::<S, L, D, SUMS>(
                    &q[d],
                    q_low,
                    d,
                    &place[i][d],
                    &increment[i][d],
                    &normal[i][d],
                    &mut residual[i],
                );
            }
        }
        if pass == 0 {
            factor(&tableau.push, normal, matrix);
        }
        substitute(matrix, residual);
        correct(residual, going, normal, lambda, push);
        *moved = [S::default(); L];
        for d in 0..D {
            for i in 1..N {
                let row = tableau.push[i];
                shift::<S, L, D, SUMS, N>(
                    &row,
                    &q[d],
                    q_low,
                    d,
                    push,
                    &increment[i][d],
                    going,
                    &mut place[i][d],
                    moved,
                );
            }
        }
        if !decide(pass, size, path, moved, before, going) {
            break;
        }
    }
    for i in 1..N - 1 {
        evaluate(laws, i, place, lambda, residual, normal, total);
    }
    first_total(past, past_lambda, lambda, normal, total);
    for d in 0..D {
        gather(tableau, d, q, v, total, increment, push, &mut end.q);
        if SUMS == 1 {
            for l in 0..L {
                let change = [increment[N - 1][d][l] + q_low[0][d][l]];
                let ([place], [low]) = two_sum(&[q[d][l]], &change);
                (end.q[d][l], end.q_low[d][l]) = (place, low);
                push[0][d][l] = push[0][d][l] + p_low[0][d][l];
            }
        }
    }
    settle(laws, tableau.kick[N - 1], p, &push[0], end);
    upright(normal, going);
    stray(laws, tableau.h, q, p, &past[N - 1], &increment[N - 1], end, size, going);
    ask(asked, &end.astray, going)
}

/// w and λ at this step's stages, from those of the last one. The first stage is its end.
#[inline(always)]
fn extrapolate<S: Lane, const L: usize, const D: usize, const N: usize>(
    ahead: &[[S; N]; N],
    past: &[Vectors<S, L, D>; N],
    past_lambda: &[[S; L]; N],
    total: &mut [Vectors<S, L, D>; N],
    lambda: &mut [[S; L]; N],
) {
    (total[0], lambda[0]) = (past[N - 1], past_lambda[N - 1]);
    for i in 1..N - 1 {
        let weights = ahead[i];
        for d in 0..D {
            for l in 0..L {
                let mut x = weights[N - 1] * past[N - 1][d][l];
                for j in 0..N - 1 {
                    x = weights[j].multiply_add(past[j][d][l], x);
                }
                total[i][d][l] = x;
            }
        }
        for l in 0..L {
            let mut x = weights[N - 1] * past_lambda[N - 1][l];
            for j in 0..N - 1 {
                x = weights[j].multiply_add(past_lambda[j][l], x);
            }
            lambda[i][l] = x;
        }
    }
}

/// One coordinate of Qᵢ − q, by the present w.
#[inline(always)]
fn displace<S: Lane, const L: usize, const N: usize>(
    drift: &[S; N],
    push: &[[S; N]; N],
    i: usize,
    d: usize,
    v: &[[S; L]],
    total: &[impl AsRef<[[S; L]]>; N],
    increment: &mut [impl AsMut<[[S; L]]>; N],
) {
    let (drift, row) = (drift[i], push[i]);
    let (v, to) = (&v[d], &mut increment[i].as_mut()[d]);
    for l in 0..L {
        let mut x = drift * v[l];
        for j in 0..N - 1 {
            x = row[j].multiply_add(total[j].as_ref()[d][l], x);
        }
        to[l] = x;
    }
}

/// g, ∇g and w at a stage.
#[inline(always)]
fn evaluate<S: Lane, const L: usize, const D: usize, const N: usize>(
    laws: &impl Laws<S, D>,
    i: usize,
    place: &[Vectors<S, L, D>; N],
    lambda: &[[S; L]; N],
    residual: &mut [[S; L]; N],
    normal: &mut [Vectors<S, L, D>; N],
    total: &mut [Vectors<S, L, D>; N],
) {
    let (place, lambda) = (&place[i], &lambda[i]);
    let (residual, normal, total) = (&mut residual[i], &mut normal[i], &mut total[i]);
    let one = S::from_f64(1.0);
    if i < N - 1 {
        for l in 0..L {
            let q = at(place, l);
            let ([g], [gradient]) = laws.constraint(l).borrow().value_and_jacobian(&q);
            residual[l] = g;
            put(normal, l, gradient);
            put(total, l, laws.kick(l, &q, one, scaled(lambda[l], &gradient)));
        }
    } else {
        for l in 0..L {
            let ([g], [gradient]) = laws.constraint(l).borrow().value_and_jacobian(&at(place, l));
            residual[l] = g;
            put(normal, l, gradient);
        }
    }
}

/// w at the start, by how much λ is another one than that of g̈ = 0.
#[inline(always)]
fn first_total<S: Lane, const L: usize, const D: usize, const N: usize>(
    past: &[Vectors<S, L, D>; N],
    past_lambda: &[[S; L]; N],
    lambda: &[[S; L]; N],
    normal: &[Vectors<S, L, D>; N],
    total: &mut [Vectors<S, L, D>; N],
) {
    let (start, end, lambda) = (&past[N - 1], &past_lambda[N - 1], &lambda[0]);
    let (normal, total) = (&normal[0], &mut total[0]);
    for d in 0..D {
        for l in 0..L {
            total[d][l] = (lambda[l] - end[l]).multiply_add(normal[d][l], start[d][l]);
        }
    }
}

/// Adds what g changes by, along one coordinate, from where a stage is to where it should be.
#[inline(always)]
fn linearise<S: Lane, const L: usize, const D: usize, const SUMS: usize>(
    q: &[S; L],
    q_low: &[Vectors<S, L, D>; SUMS],
    d: usize,
    place: &[S; L],
    increment: &[S; L],
    normal: &[S; L],
    residual: &mut [S; L],
) {
    if SUMS == 0 {
        for l in 0..L {
            residual[l] = normal[l].multiply_add(increment[l] - (place[l] - q[l]), residual[l]);
        }
    } else {
        let low = &q_low[0][d];
        for l in 0..L {
            let off = (increment[l] + low[l]) - (place[l] - q[l]);
            residual[l] = normal[l].multiply_add(off, residual[l]);
        }
    }
}

/// The matrix h² aᵢⱼ ∇g(Qᵢ)·∇g(Qⱼ), rows 1 … N − 1 and columns 0 … N − 2, and its factors; reciprocals on the diagonal.
/// Without exchanges: leading minors of the tables are positive, and normals of successive stages do not turn over.
#[inline(always)]
fn factor<S: Lane, const L: usize, const D: usize, const N: usize>(
    push: &[[S; N]; N],
    normal: &[Vectors<S, L, D>; N],
    matrix: &mut [[[S; L]; N]; N],
) {
    for i in 1..N {
        for j in 0..N - 1 {
            let (a, x, y) = (push[i][j], &normal[i], &normal[j]);
            let to = &mut matrix[i][j];
            for l in 0..L {
                to[l] = a * dot(&at(x, l), &at(y, l));
            }
        }
    }
    // Rows are copied: loops over lanes are short, and compilers would vectorise those around them, across rows.
    for k in 0..N - 1 {
        let mut pivot = matrix[k + 1][k];
        for l in 0..L {
            pivot[l] = S::from_f64(1.0) / pivot[l];
        }
        matrix[k + 1][k] = pivot;
        for i in k + 1..N - 1 {
            let mut factor = matrix[i + 1][k];
            for l in 0..L {
                factor[l] = factor[l] * pivot[l];
            }
            matrix[i + 1][k] = factor;
            for j in k + 1..N - 1 {
                let (mut to, of_pivot) = (matrix[i + 1][j], &matrix[k + 1][j]);
                for l in 0..L {
                    to[l] = (-factor[l]).multiply_add(of_pivot[l], to[l]);
                }
                matrix[i + 1][j] = to;
            }
        }
    }
}

/// Solves with the factors: equations in rows 1 … N − 1, unknowns in rows 0 … N − 2.
#[inline(always)]
fn substitute<S: Lane, const L: usize, const N: usize>(
    matrix: &[[[S; L]; N]; N],
    residual: &mut [[S; L]; N],
) {
    for i in 0..N - 1 {
        let mut x = residual[i + 1];
        for j in 0..i {
            let (factor, known) = (&matrix[i + 1][j], &residual[j]);
            for l in 0..L {
                x[l] = (-factor[l]).multiply_add(known[l], x[l]);
            }
        }
        residual[i] = x;
    }
    for i in (0..N - 1).rev() {
        let mut x = residual[i];
        for j in i + 1..N - 1 {
            let (factor, known) = (&matrix[i + 1][j], &residual[j]);
            for l in 0..L {
                x[l] = (-factor[l]).multiply_add(known[l], x[l]);
            }
        }
        for l in 0..L {
            residual[i][l] = x[l] * matrix[i + 1][i][l];
        }
    }
}

/// Corrects λ where lanes are going, by less what was solved for, and makes ∇g times that.
#[inline(always)]
fn correct<S: Lane, const L: usize, const D: usize, const N: usize>(
    solved: &[[S; L]; N],
    going: &[S; L],
    normal: &[Vectors<S, L, D>; N],
    lambda: &mut [[S; L]; N],
    push: &mut [Vectors<S, L, D>; N],
) {
    // One loop over lanes: compilers would unroll shorter ones, and vectorise those around them, across stages.
    for j in 0..N - 1 {
        let (solved, lambda, normal, push) = (&solved[j], &mut lambda[j], &normal[j], &mut push[j]);
        for l in 0..L {
            let better = lambda[l] - solved[l];
            lambda[l] = S::select(S::default().lt(going[l]), better, lambda[l]);
            put(push, l, scaled(-solved[l], &at(normal, l)));
        }
    }
}

/// Moves one coordinate of a stage to where it should be where lanes are going, and notes how far.
#[allow(clippy::too_many_arguments, reason = "slices that are arguments do not overlap")]
#[inline(always)]
fn shift<S: Lane, const L: usize, const D: usize, const SUMS: usize, const N: usize>(
    row: &[S; N],
    q: &[S; L],
    q_low: &[Vectors<S, L, D>; SUMS],
    d: usize,
    push: &[Vectors<S, L, D>; N],
    increment: &[S; L],
    going: &[S; L],
    place: &mut [S; L],
    moved: &mut [S; L],
) {
    for l in 0..L {
        let mut x = increment[l];
        for j in 0..N - 1 {
            x = row[j].multiply_add(push[j][d][l], x);
        }
        let to = if SUMS == 0 { q[l] + x } else { q[l] + (q_low[0][d][l] + x) };
        let off = (to - place[l]).abs();
        moved[l] = S::select(off.le(moved[l]), moved[l], off); // also where it is not a number
        place[l] = S::select(S::default().lt(going[l]), to, place[l]);
    }
}

/// Which lanes rest now, and which go by themselves. Returns whether one is still going.
#[inline(always)]
fn decide<S: Lane, const L: usize>(
    pass: usize,
    size: &[S; L],
    path: &[S; L],
    moved: &[S; L],
    before: &mut [S; L],
    going: &mut [S; L],
) -> bool {
    let [zero, one, half, by_itself] = [0.0, 1.0, 0.5, BY_ITSELF].map(S::from_f64);
    let (rounding, far) = (S::from_f64(S::EPSILON), S::from_f64(FAR_GUESS));
    let [last, noise, shrinks] = [LAST_OF_STAGES, NOISE, SHRINKS].map(S::from_f64);
    let (first, late, end) = (pass == 0, pass > 3, pass + 1 == MOST_PASSES);
    let mut any = false;
    for l in 0..L {
        let (off, size) = (moved[l], rounding * size[l]);
        let rate = off / before[l];
        let rate = S::select(shrinks.le(rate), rate, shrinks);
        let rate = if first { one } else { rate };
        let rests = (rate * off).le(last * size) | (late & half.le(rate) & off.le(noise * size));
        let lost = if first { !off.le(far * path[l]) } else { !off.le(before[l] + noise * size) | end };
        let now = S::select(rests, zero, S::select(lost, by_itself, one));
        going[l] = S::select(zero.lt(going[l]), now, going[l]);
        before[l] = off;
        any |= zero.lt(going[l]);
    }
    any
}

/// One coordinate of where the step leads, and of what momenta are kicked by on the way, by the last w.
#[allow(clippy::too_many_arguments, reason = "slices that are arguments do not overlap")]
#[inline(always)]
fn gather<S: Lane, const L: usize, const D: usize, const N: usize>(
    tableau: &Tableau<S, N>,
    d: usize,
    q: &Vectors<S, L, D>,
    v: &Vectors<S, L, D>,
    total: &[Vectors<S, L, D>; N],
    increment: &mut [Vectors<S, L, D>; N],
    push: &mut [Vectors<S, L, D>; N],
    place: &mut Vectors<S, L, D>,
) {
    let Tableau { h, push: pushes, push_rest, kick, kick_rest, .. } = tableau;
    let (h, pushes, push_rest, kick, kick_rest) = (*h, pushes[N - 1], *push_rest, *kick, *kick_rest);
    let (increment, push) = (&mut increment[N - 1][d], &mut push[0][d]);
    for l in 0..L {
        let (mut way, mut kicked) = (S::default(), S::default());
        for j in 0..N - 1 {
            let w = total[j][d][l];
            way = pushes[j].multiply_add(w, push_rest[j].multiply_add(w, way));
            kicked = kick[j].multiply_add(w, kick_rest[j].multiply_add(w, kicked));
        }
        let way = h.multiply_add(v[d][l], way);
        (increment[l], push[l]) = (way, kicked);
        place[d][l] = q[d][l] + way;
    }
}

/// The last kick, and the momentum along the surface; then what is kept there.
#[inline(always)]
fn settle<S: Lane, const L: usize, const D: usize>(
    laws: &impl Laws<S, D>,
    kick: S,
    p: &Vectors<S, L, D>,
    kicked: &Vectors<S, L, D>,
    end: &mut End<S, L, D>,
) {
    let End { q, p: to, p_low, normal, total, lambda, .. } = end;
    for l in 0..L {
        let (q, old) = (at(q, l), at(p, l));
        let [gradient] = laws.constraint(l).borrow().jacobian(&q);
        let change = laws.kick(l, &q, kick, at(kicked, l));
        let eta = -dot(&gradient, &sum(&old, &change)) / dot(&gradient, &gradient);
        let (new, low) = two_sum(&old, &add_scaled(&change, eta, &gradient));
        let (multiplier, pulled) = pull(laws, l, &q, &new, &gradient);
        put(to, l, new);
        put(p_low, l, low);
        put(normal, l, gradient);
        put(total, l, pulled);
        lambda[l] = multiplier;
    }
}

/// Has lanes go by themselves whose normals of successive stages are turned over.
#[inline(always)]
fn upright<S: Lane, const L: usize, const D: usize, const N: usize>(
    normal: &[Vectors<S, L, D>; N],
    going: &mut [S; L],
) {
    let (zero, by_itself) = (S::default(), S::from_f64(BY_ITSELF));
    for i in 1..N {
        let (before, after) = (&normal[i - 1], &normal[i]);
        for l in 0..L {
            let along = dot(&at(before, l), &at(after, l));
            going[l] = S::select(zero.lt(along), going[l], by_itself);
        }
    }
}

/// How far the step may have led astray, and whether it may have led to another sheet: whether g is not as small as
/// along one sheet on the curve through both ends with their momenta and accelerations, see
/// [`check_sheets`](crate::motion::system::System::check_sheets).
#[allow(clippy::too_many_arguments, reason = "slices that are arguments do not overlap")]
#[inline(always)]
fn stray<S: Lane, const L: usize, const D: usize>(
    laws: &impl Laws<S, D>,
    h: S,
    q: &Vectors<S, L, D>,
    p: &Vectors<S, L, D>,
    pull: &Vectors<S, L, D>,
    way: &Vectors<S, L, D>,
    end: &mut End<S, L, D>,
    size: &[S; L],
    going: &mut [S; L],
) {
    let End { p: p_end, normal, total, astray, .. } = end;
    let [half, two, three, off_inside, by_itself] = [0.5, 2.0, 3.0, OFF_INSIDE, BY_ITSELF].map(S::from_f64);
    let (rounding, half_square) = (S::from_f64(ROUNDINGS * S::EPSILON), half * h * h);
    let inside = INSIDE.map(|s| {
        let r = 1.0 - s;
        [s * s * (3.0 - 2.0 * s), s * r * r, -r * s * s, s * s * r * r * r, s * s * s * r * r]
            .map(S::from_f64)
    });
    for l in 0..L {
        let (from, way) = (at(q, l), at(way, l));
        let [first, last] = [scaled(h, &at(p, l)), scaled(h, &at(p_end, l))];
        let both = sum(&first, &last);
        let off = largest(&add_scaled(&way, -half, &both));
        astray[l] = off;
        // Half of what the accelerations at both ends are beyond those of the cubic.
        let at_first: [S; D] = from_fn(|d| two.multiply_add(first[d], last[d]) - three * way[d]);
        let at_last: [S; D] = from_fn(|d| three * way[d] - two.multiply_add(last[d], first[d]));
        let at_first = add_scaled(&at_first, half_square, &at(pull, l));
        let at_last = add_scaled(&at_last, half_square, &at(total, l));
        let n = at(normal, l);
        let most = off_inside.multiply_add(off, rounding * size[l]);
        let most = most * most * dot(&n, &n);
        let mut plain = true;
        for [a, b, c, d, e] in inside {
            let place = add_scaled(&add_scaled(&add_scaled(&from, a, &way), b, &first), c, &last);
            let place = add_scaled(&add_scaled(&place, d, &at_first), e, &at_last);
            let [g] = laws.constraint(l).borrow().value(&place);
            plain &= (g * g).le(most);
        }
        going[l] = S::select(plain, going[l], by_itself);
    }
}

/// Has lanes look around that have gone farther astray than was looked. Returns whether nothing speaks against the
/// step.
#[inline(always)]
fn ask<S: Lane, const L: usize>(asked: &[S; L], astray: &[S; L], going: &mut [S; L]) -> bool {
    let (zero, looking) = (S::default(), S::from_f64(LOOKING));
    let mut all = true;
    for l in 0..L {
        let look = zero.le(going[l]) & !astray[l].le(asked[l]);
        going[l] = S::select(look, looking, going[l]);
        all &= zero.le(going[l]);
    }
    all
}
