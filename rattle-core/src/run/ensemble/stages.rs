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
use crate::kernel::rounding::size_along;
use crate::number::lanes::Lane;
use crate::number::vector::{add_scaled, dot, scaled, sum, two_sum};
use crate::number::vectors::{Vectors, at, put};
use crate::run::ensemble::around::may_go;
use crate::run::ensemble::inside::follows;
use crate::run::ensemble::laws::Laws;
use crate::run::ensemble::row::{BY_ITSELF, End, Row, Scratch, Tableau, pull};
use crate::solve::root::{STAGES_ALIKE, alike};
use crate::solve::stop::{LAST_OF_STAGES, NOISE};
use std::borrow::Borrow;

/// Passes after which a lane goes by itself.
const MOST_PASSES: usize = 24;

/// A guess that is off by more than this part of the path is not trusted. (Where the step ends is looked at whatever
/// the guess was, so that this may be more than in a simulation.)
const FAR_GUESS: f64 = 2e-1;

/// No pass is trusted to shrink what is left by more than this.
const SHRINKS: f64 = 1e-3;

/// Finds where one step leads all lanes. Says whether it may be taken as it is; if not, `going` tells which lanes have
/// to go by themselves, or have to look around first.
#[inline(always)]
pub(super) fn advance<S, const L: usize, const D: usize, const SUMS: usize, const N: usize>(
    row: &mut Row<S, L, D, SUMS, N>,
    laws: &impl Laws<S, D>,
    tableau: &Tableau<S, N>,
    scratch: &mut Scratch<S, L, D, N>,
) -> bool
where
    S: Lane,
{
    let Scratch { place, away, rest, normal, residual, matrix, moved, .. } = scratch;
    let Scratch { before, rates, size, counts, path, going, end, .. } = scratch;
    for d in 0..D {
        begin(tableau, d, row, place, counts, path);
    }
    weigh(&row.normal, path, counts, size);
    extrapolate(&tableau.ahead, &mut row.lambda, &mut end.lambda);
    normal[0] = row.normal;
    *going = [S::from_f64(1.0); L];
    for pass in 0..MOST_PASSES {
        for i in 1..N {
            evaluate(laws, i, place, &row.lambda, residual, normal, &mut row.total);
        }
        for d in 0..D {
            if SUMS > 0 && pass == 0 {
                round(tableau, d, row, &end.lambda, rest);
            }
            miss(tableau, d, row, &end.lambda, place, normal, rest, away, residual);
        }
        if pass == 0 {
            factor(&tableau.push, normal, matrix);
        }
        substitute(matrix, residual);
        correct(residual, going, &mut row.lambda);
        *moved = [S::default(); L];
        for d in 0..D {
            shift(&tableau.push, d, residual, normal, away, going, &counts[d], place, moved);
        }
        if !decide(pass, size, path, moved, before, rates, going) {
            break;
        }
    }
    for i in 1..N - 1 {
        evaluate_forces(laws, i, place, &row.lambda, normal, &mut row.total, going);
    }
    for d in 0..D {
        gather(tableau, d, row, away, end);
    }
    settle(laws, tableau.kick[N - 1], row, &away[0], &normal[N - 2], size, end, going);
    stray(laws, tableau.h, row, &away[N - 1], end, size, going);
    may_go(&row.asked, &end.strays, going)
}

/// λ at this step's stages, from those of the last one, of which the end is kept. The first stage is that end.
#[inline(always)]
fn extrapolate<S: Lane, const L: usize, const N: usize>(
    ahead: &[[S; N]; N],
    lambda: &mut [[S; L]; N],
    end: &mut [S; L],
) {
    for l in 0..L {
        let mut past = [S::default(); N];
        for j in 0..N {
            past[j] = lambda[j][l];
        }
        (lambda[0][l], end[l]) = (past[N - 1], past[N - 1]);
        for i in 1..N - 1 {
            let mut x = ahead[i][N - 1] * past[N - 1];
            for j in 0..N - 1 {
                x = ahead[i][j].multiply_add(past[j], x);
            }
            lambda[i][l] = x;
        }
    }
}

/// One coordinate of the stages, by w from the last step's; how large it is, and the size of the path, as far as this
/// coordinate.
#[inline(always)]
fn begin<S: Lane, const L: usize, const D: usize, const SUMS: usize, const N: usize>(
    tableau: &Tableau<S, N>,
    d: usize,
    row: &Row<S, L, D, SUMS, N>,
    place: &mut [Vectors<S, L, D>; N],
    large: &mut Vectors<S, L, D>,
    path: &mut [S; L],
) {
    let (drift, first) = (tableau.drift, &tableau.first);
    for l in 0..L {
        let (q, low, v) = row.coordinate(d, l);
        let mut past = [S::default(); N];
        for j in 0..N {
            past[j] = row.total[j][d][l];
        }
        let mut x = S::default();
        for i in 1..N {
            x = drift[i] * v;
            for j in 0..N {
                x = first[i][j].multiply_add(past[j], x);
            }
            place[i][d][l] = if const { SUMS == 0 } { q + x } else { q + (low + x) };
        }
        let (way, far) = (x.abs(), q.abs().max(place[N - 1][d][l].abs()));
        path[l] = if d == 0 { way } else { way.max(path[l]) };
        large[d][l] = far;
    }
}

/// How large places are [along the normal](size_along), or the path if that is larger; and by what displacements along
/// coordinates count that are larger still, which are rounded to more and do not lead off the constraint.
#[inline(always)]
fn weigh<S: Lane, const L: usize, const D: usize>(
    normal: &Vectors<S, L, D>,
    path: &[S; L],
    counts: &mut Vectors<S, L, D>,
    size: &mut [S; L],
) {
    for l in 0..L {
        let (n, large) = (at(normal, l), at(counts, l));
        let along = size_along(&n, dot(&n, &n).sqrt(), &large).max(path[l]);
        put(counts, l, large.map(|x| S::select(along.lt(x), along / x, S::from_f64(1.0))));
        size[l] = along;
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

/// ∇g and w at a final stage; a lane whose normal has turned over since the stage before has to go by itself.
#[inline(always)]
fn evaluate_forces<S: Lane, const L: usize, const D: usize, const N: usize>(
    laws: &impl Laws<S, D>,
    i: usize,
    place: &[Vectors<S, L, D>; N],
    lambda: &[[S; L]; N],
    normal: &mut [Vectors<S, L, D>; N],
    total: &mut [Vectors<S, L, D>; N],
    going: &mut [S; L],
) {
    let (place, lambda, total) = (&place[i], &lambda[i], &mut total[i]);
    let [one, by_itself, least] = [1.0, BY_ITSELF, STAGES_ALIKE].map(S::from_f64);
    let (before, normal) = normal.split_at_mut(i);
    let (before, normal) = (&before[i - 1], &mut normal[0]);
    for l in 0..L {
        let q = at(place, l);
        let [gradient] = laws.constraint(l).borrow().jacobian(&q);
        put(normal, l, gradient);
        put(total, l, laws.kick(l, &q, one, scaled(lambda[l], &gradient)));
        let upright = least.lt(alike(&at(before, l), &gradient));
        going[l] = S::select(upright, going[l], by_itself);
    }
}

/// w at all stages but the last, one coordinate of one lane; at the start by how much λ is another one than that of
/// g̈ = 0, which is given.
#[inline(always)]
fn pulls<S: Lane, const L: usize, const D: usize, const SUMS: usize, const N: usize>(
    row: &Row<S, L, D, SUMS, N>,
    lambda: &[S; L],
    d: usize,
    l: usize,
) -> [S; N] {
    let mut w = [S::default(); N];
    w[0] = (row.lambda[0][l] - lambda[l]).multiply_add(row.normal[d][l], row.total[N - 1][d][l]);
    for j in 1..N - 1 {
        w[j] = row.total[j][d][l];
    }
    w
}

/// One coordinate of what rounding took from the start, and from coefficients on the way to the stages: by the first w,
/// of which all but a small part is guessed.
#[inline(always)]
fn round<S: Lane, const L: usize, const D: usize, const SUMS: usize, const N: usize>(
    tableau: &Tableau<S, N>,
    d: usize,
    row: &Row<S, L, D, SUMS, N>,
    lambda: &[S; L],
    rest: &mut [Vectors<S, L, D>; N],
) {
    let Tableau { drift_rest, push_rest, .. } = tableau;
    for l in 0..L {
        let (_, low, v) = row.coordinate(d, l);
        let w = pulls(row, lambda, d, l);
        for i in 1..N {
            let mut x = drift_rest[i].multiply_add(v, low);
            for j in 0..N - 1 {
                x = push_rest[i][j].multiply_add(w[j], x);
            }
            rest[i][d][l] = x;
        }
    }
}

/// One coordinate of how far stages are from where they should be by the present w; adds to g by how much it changes on
/// the way.
#[allow(clippy::too_many_arguments, reason = "slices that are arguments do not overlap")]
#[inline(always)]
fn miss<S: Lane, const L: usize, const D: usize, const SUMS: usize, const N: usize>(
    tableau: &Tableau<S, N>,
    d: usize,
    row: &Row<S, L, D, SUMS, N>,
    lambda: &[S; L],
    place: &[Vectors<S, L, D>; N],
    normal: &[Vectors<S, L, D>; N],
    rest: &[Vectors<S, L, D>; N],
    away: &mut [Vectors<S, L, D>; N],
    residual: &mut [[S; L]; N],
) {
    let Tableau { drift, push, .. } = tableau;
    for l in 0..L {
        let (q, _, v) = row.coordinate(d, l);
        let w = pulls(row, lambda, d, l);
        for i in 1..N {
            // What rounding took comes first: added to a rounded sum it would be lost each time.
            let mut x =
                if const { SUMS == 0 } { drift[i] * v } else { drift[i].multiply_add(v, rest[i][d][l]) };
            for j in 0..N - 1 {
                x = push[i][j].multiply_add(w[j], x);
            }
            let off = x - (place[i][d][l] - q);
            away[i][d][l] = off;
            residual[i][l] = normal[i][d][l].multiply_add(off, residual[i][l]);
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

/// Corrects λ where lanes are going, by less what was solved for, of which it changes the sign.
#[inline(always)]
fn correct<S: Lane, const L: usize, const N: usize>(
    solved: &mut [[S; L]; N],
    going: &[S; L],
    lambda: &mut [[S; L]; N],
) {
    // One loop over lanes: compilers would unroll shorter ones, and vectorise those around them, across stages.
    for l in 0..L {
        let goes = S::default().lt(going[l]);
        for j in 0..N - 1 {
            let (change, old) = (-solved[j][l], lambda[j][l]);
            solved[j][l] = change;
            lambda[j][l] = S::select(goes, old + change, old);
        }
    }
}

/// Moves one coordinate of the stages to where they should be where lanes are going, and notes how far.
#[allow(clippy::too_many_arguments, reason = "slices that are arguments do not overlap")]
#[inline(always)]
fn shift<S: Lane, const L: usize, const D: usize, const N: usize>(
    push: &[[S; N]; N],
    d: usize,
    solved: &[[S; L]; N],
    normal: &[Vectors<S, L, D>; N],
    away: &[Vectors<S, L, D>; N],
    going: &[S; L],
    counts: &[S; L],
    place: &mut [Vectors<S, L, D>; N],
    moved: &mut [S; L],
) {
    for l in 0..L {
        let mut w = [S::default(); N];
        for j in 0..N - 1 {
            w[j] = solved[j][l] * normal[j][d][l];
        }
        let (goes, mut most) = (S::default().lt(going[l]), moved[l]);
        for i in 1..N {
            let mut x = away[i][d][l];
            for j in 0..N - 1 {
                x = push[i][j].multiply_add(w[j], x);
            }
            let off = counts[l] * x.abs();
            most = S::select(off.lt(most), most, off); // also where it is not a number
            let old = place[i][d][l];
            place[i][d][l] = S::select(goes, old + x, old);
        }
        moved[l] = most;
    }
}

/// Which lanes rest now, and which go by themselves. What is left is told by the slower of the last two rates, since
/// one lucky displacement is not the rate: by the last one alone some steps ended 20 and 30 roundings off. Returns
/// whether one is still going.
#[inline(always)]
fn decide<S: Lane, const L: usize>(
    pass: usize,
    size: &[S; L],
    path: &[S; L],
    moved: &[S; L],
    before: &mut [S; L],
    rates: &mut [S; L],
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
        let slower = if first { one } else { rate.max(rates[l]) };
        let rests = (slower * off).le(last * size) | (late & half.le(rate) & off.le(noise * size));
        let lost = if first { !off.le(far * path[l]) } else { !off.le(before[l] + noise * size) | end };
        let now = S::select(rests, zero, S::select(lost, by_itself, one));
        going[l] = S::select(zero.lt(going[l]), now, going[l]);
        (before[l], rates[l]) = (off, if first { shrinks } else { rate });
        any |= zero.lt(going[l]);
    }
    any
}

/// One coordinate of where the step leads, and of w at its start; and of the way there, and of what momenta are kicked
/// by on it, by the last w.
#[inline(always)]
fn gather<S: Lane, const L: usize, const D: usize, const SUMS: usize, const N: usize>(
    tableau: &Tableau<S, N>,
    d: usize,
    row: &mut Row<S, L, D, SUMS, N>,
    away: &mut [Vectors<S, L, D>; N],
    end: &mut End<S, L, D>,
) {
    let Tableau { h, push, push_rest, kick, kick_rest, .. } = tableau;
    let (h, push, push_rest, kick, kick_rest) = (*h, push[N - 1], push_rest[N - 1], *kick, *kick_rest);
    for l in 0..L {
        let (q, low, v) = row.coordinate(d, l);
        let w = pulls(row, &end.lambda, d, l);
        let (mut way, mut kicked) = (S::default(), S::default());
        // What rounding took comes first: added to a rounded sum it would be lost each time.
        if const { SUMS == 0 } {
            for j in 0..N - 1 {
                way = push[j].multiply_add(w[j], push_rest[j].multiply_add(w[j], way));
                kicked = kick[j].multiply_add(w[j], kick_rest[j].multiply_add(w[j], kicked));
            }
        } else {
            let p_low = row.p_low[0][d][l];
            (way, kicked) = (h.multiply_add(p_low, low), p_low);
            for j in 0..N - 1 {
                way = push_rest[j].multiply_add(w[j], way);
                kicked = kick_rest[j].multiply_add(w[j], kicked);
            }
            for j in 0..N - 1 {
                way = push[j].multiply_add(w[j], way);
                kicked = kick[j].multiply_add(w[j], kicked);
            }
        }
        let way = h.multiply_add(v, way);
        (away[N - 1][d][l], away[0][d][l], row.total[0][d][l]) = (way, kicked, w[0]);
        if const { SUMS == 0 } {
            end.q[d][l] = q + way;
        } else {
            let ([place], [rest]) = two_sum(&[q], &[way]);
            (end.q[d][l], end.q_low[d][l]) = (place, rest);
        }
    }
}

/// The last kick, and the momentum along the surface; then what is kept there. A lane whose normal has turned over
/// since the stage before has to go by itself, and so has one that ends beside the surface: by more than the noise that
/// may end its iteration, or that of g, which is evaluated with its gradient anyway.
#[allow(clippy::too_many_arguments, reason = "slices that are arguments do not overlap")]
#[inline(always)]
fn settle<S: Lane, const L: usize, const D: usize, const SUMS: usize, const N: usize>(
    laws: &impl Laws<S, D>,
    kick: S,
    row: &Row<S, L, D, SUMS, N>,
    kicked: &Vectors<S, L, D>,
    before: &Vectors<S, L, D>,
    size: &[S; L],
    end: &mut End<S, L, D>,
    going: &mut [S; L],
) {
    let End { q, p, p_low, normal, total, lambda, .. } = end;
    let [by_itself, least, noise] = [BY_ITSELF, STAGES_ALIKE, NOISE * S::EPSILON].map(S::from_f64);
    for l in 0..L {
        let (q, old) = (at(q, l), at(&row.p, l));
        let ([g], [gradient]) = laws.constraint(l).borrow().value_and_jacobian(&q);
        let change = laws.kick(l, &q, kick, at(kicked, l));
        let (square, off) = (dot(&gradient, &gradient), noise * size[l]);
        let eta = -dot(&gradient, &sum(&old, &change)) / square;
        let (new, low) = two_sum(&old, &add_scaled(&change, eta, &gradient));
        let (multiplier, pulled) = pull(laws, l, &q, &new, &gradient);
        put(p, l, new);
        if const { SUMS > 0 } {
            put(p_low, l, low);
        }
        put(normal, l, gradient);
        put(total, l, pulled);
        lambda[l] = multiplier;
        let right = least.lt(alike(&at(before, l), &gradient)) & (g * g).le(off * off * square);
        going[l] = S::select(right, going[l], by_itself);
    }
}

/// How far the step may have led astray; has lanes go by themselves where it may have led to another sheet.
#[inline(always)]
fn stray<S: Lane, const L: usize, const D: usize, const SUMS: usize, const N: usize>(
    laws: &impl Laws<S, D>,
    h: S,
    row: &Row<S, L, D, SUMS, N>,
    way: &Vectors<S, L, D>,
    end: &mut End<S, L, D>,
    size: &[S; L],
    going: &mut [S; L],
) {
    let pulls = &row.total[N - 1];
    for l in 0..L {
        let from = [&row.q, &row.p, pulls].map(|x| at(x, l));
        let to = [way, &end.p, &end.normal, &end.total].map(|x| at(x, l));
        let (off, plain) = follows(laws, l, h, from, to, size[l]);
        end.strays[l] = off;
        going[l] = S::select(plain, going[l], S::from_f64(BY_ITSELF));
    }
}
