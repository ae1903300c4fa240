//! Trajectories side by side whose steps are solved in stages: collocation by [`lobatto`](crate::methods::lobatto) in
//! lanes.
//!
//! ```text
//! Qᵢ = q + h cᵢ p + h² Σⱼ aᵢⱼ wⱼ       wⱼ = f(Qⱼ) + ∇g(Qⱼ) λⱼ       0 = g(Qᵢ),   i = 2 … s,   Q₁ = q
//! p′ = p + h Σⱼ bⱼ wⱼ                   λₛ such that ∇g(q′)·p′ = 0,   q′ = Qₛ
//! ```
//!
//! **First guess:** w and λ are the polynomials through the last step's stages and this step's exact start.
//! **A pass** evaluates g, ∇g and f at all stages, forms the sums, and corrects λ by Newton's method and the matrix of
//! the first pass, h² aᵢⱼ ∇g(Qᵢ)·∇g(Qⱼ), as in [`crate::systems::surface::collocation`]. **A lane rests** where what
//! the next pass would move, by how the last ones shrank, is below half a rounding. Its stages and λ then stay what
//! they are, however many passes its neighbours take; a last evaluation of ∇g and f at the resting stages makes w, so
//! that momenta are kicked by forces at the very places.
//!
//! **Not in lanes:** a lane whose guess was far off, that does not converge, whose normals turn over, or whose end may
//! lie on another sheet, takes the step by itself, as a [`Simulation`](crate::run::simulation::Simulation) does.

use crate::error::Error;
use crate::kernel::functions::ConstraintKernel;
use crate::motion::bodies::Body;
use crate::motion::record::{Reading, Record};
use crate::motion::table::Table;
use crate::number::lanes::Lane;
use crate::number::vector::{add_scaled, dot, largest, scaled, sum, two_sum};
use crate::number::vectors::{Vectors, at, put};
use crate::run::ensemble::laws::Laws;
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

/// Has to go by itself.
pub(super) const BY_ITSELF: f64 = -1.0;

/// Has gone farther astray than it was looked for other sheets.
pub(super) const LOOKING: f64 = -2.0;

/// The numbers of a method of N stages, times the step size.
#[derive(Debug, Clone)]
pub(super) struct Tableau<S, const N: usize> {
    /// The step size.
    pub(super) h: S,
    /// h cᵢ.
    drift: [S; N],
    /// h² aᵢⱼ; and what rounding took from the last row.
    push: [[S; N]; N],
    push_rest: [S; N],
    /// h bⱼ, and what rounding took from it.
    kick: [S; N],
    kick_rest: [S; N],
    /// From the last step's stages to this one's.
    ahead: [[S; N]; N],
}

impl<S: Lane, const N: usize> Tableau<S, N> {
    pub(super) fn of(table: &Table<N>, h: f64) -> Self {
        let number = S::from_f64;
        // What a float of lanes takes from a number of two doubles.
        let rest = |(high, low): (f64, f64)| number((high - number(high).to_f64()) + low);
        Self {
            h: number(h),
            drift: from_fn(|i| number(table.drift(h, i).0)),
            push: from_fn(|i| from_fn(|j| number(table.push(h, i, j).0))),
            push_rest: from_fn(|j| rest(table.push(h, N - 1, j))),
            kick: from_fn(|j| number(table.kick(h, j).0)),
            kick_rest: from_fn(|j| rest(table.kick(h, j))),
            ahead: table.ahead.map(|row| row.map(number)),
        }
    }
}

/// Trajectories side by side. `SUMS` is 1 if positions and momenta are compensated sums, else 0.
#[derive(Clone)]
#[repr(C, align(64))]
pub(crate) struct Row<S, const L: usize, const D: usize, const SUMS: usize, const N: usize> {
    pub(super) q: Vectors<S, L, D>,
    pub(super) p: Vectors<S, L, D>,
    pub(super) q_low: [Vectors<S, L, D>; SUMS],
    pub(super) p_low: [Vectors<S, L, D>; SUMS],
    /// ∇g(q).
    pub(super) normal: Vectors<S, L, D>,
    /// w = f + ∇g λ at the last step's stages, but at its end instead of at the last of them.
    pub(super) total: [Vectors<S, L, D>; N],
    /// λ there.
    pub(super) lambda: [[S; L]; N],
    /// How far steps may lead astray: how far it was asked for other sheets; and how far they have since.
    pub(super) asked: [S; L],
    pub(super) astray: [S; L],
}

/// Numbers of one step, which need no keeping.
#[derive(Clone)]
#[repr(C, align(64))]
pub(super) struct Scratch<S, const L: usize, const D: usize, const N: usize> {
    /// p, with what rounding took from it.
    v: Vectors<S, L, D>,
    /// Stages, and by how much they should be away from q.
    place: [Vectors<S, L, D>; N],
    increment: [Vectors<S, L, D>; N],
    /// ∇g, w and λ there. The first stage is the start.
    normal: [Vectors<S, L, D>; N],
    total: [Vectors<S, L, D>; N],
    lambda: [[S; L]; N],
    /// What λ is corrected by, times ∇g.
    push: [Vectors<S, L, D>; N],
    /// g of the linearised equations; then what λ is corrected by.
    residual: [[S; L]; N],
    /// The matrix, and its factors.
    matrix: [[[S; L]; N]; N],
    /// The largest displacement of a pass, and of the pass before.
    moved: [S; L],
    before: [S; L],
    /// The size of places, and of the path.
    size: [S; L],
    path: [S; L],
    /// 1 while a lane is moved, 0 where it rests, [`BY_ITSELF`], or [`LOOKING`].
    pub(super) going: [S; L],
    /// The end of the step.
    pub(super) end: End<S, L, D>,
}

/// Where a step ends: place and momentum with what rounding took from them, ∇g, w and λ there, and how far the step may
/// have led astray.
#[derive(Clone)]
pub(super) struct End<S, const L: usize, const D: usize> {
    q: Vectors<S, L, D>,
    q_low: Vectors<S, L, D>,
    p: Vectors<S, L, D>,
    p_low: Vectors<S, L, D>,
    normal: Vectors<S, L, D>,
    total: Vectors<S, L, D>,
    lambda: [S; L],
    pub(super) astray: [S; L],
}

impl<S: Lane, const L: usize, const D: usize, const N: usize> Scratch<S, L, D, N> {
    pub(super) fn new() -> Self {
        let zero = [S::default(); L];
        let (vectors, stages) = ([zero; D], [[zero; D]; N]);
        Self {
            v: vectors,
            place: stages,
            increment: stages,
            normal: stages,
            total: stages,
            lambda: [zero; N],
            push: stages,
            residual: [zero; N],
            matrix: [[zero; N]; N],
            moved: zero,
            before: zero,
            size: zero,
            path: zero,
            going: zero,
            end: End {
                q: vectors,
                q_low: vectors,
                p: vectors,
                p_low: vectors,
                normal: vectors,
                total: vectors,
                lambda: zero,
                astray: zero,
            },
        }
    }
}

/// Where a lane has landed.
pub(super) struct Landed<S, const D: usize> {
    pub(super) q: [S; D],
    pub(super) p: [S; D],
    pub(super) normal: [S; D],
    pub(super) pull: [S; D],
    pub(super) astray: S,
}

impl<S: Lane, const L: usize, const D: usize, const N: usize> Scratch<S, L, D, N> {
    /// Where the step leads a lane.
    pub(super) fn landed(&self, lane: usize) -> Landed<S, D> {
        let End { q, p, normal, total, astray, .. } = &self.end;
        let [q, p, normal, pull] = [q, p, normal, total].map(|x| at(x, lane));
        Landed { q, p, normal, pull, astray: astray[lane] }
    }

    /// Notes where a step by itself has led a lane from q and p, and what the method remembers of it.
    pub(super) fn land(
        &mut self,
        lane: usize,
        laws: &impl Laws<S, D>,
        h: f64,
        [q, p]: [&[S; D]; 2],
        to: &Body<S, D>,
        memory: &[S],
    ) {
        let (totals, lambdas) = memory[1..].split_at(N * D);
        for j in 0..N {
            put(&mut self.total[j], lane, from_fn(|d| totals[j * D + d]));
            self.lambda[j][lane] = lambdas[j];
        }
        let [gradient] = laws.constraint(lane).borrow().jacobian(&to.q);
        let (lambda, total) = pull(laws, lane, &to.q, &to.p, &gradient);
        let End { q: end, q_low, p: p_end, p_low, normal, total: pulled, lambda: multiplier, astray } =
            &mut self.end;
        let all = [(end, to.q), (q_low, to.q_low), (p_end, to.p), (p_low, to.p_low)];
        all.into_iter().chain([(normal, gradient), (pulled, total)]).for_each(|(x, of)| put(x, lane, of));
        multiplier[lane] = lambda;
        let way = add_scaled(&to.q, S::from_f64(-1.0), q);
        astray[lane] = largest(&add_scaled(&way, S::from_f64(-0.5 * h), &sum(p, &to.p)));
    }
}

impl<S: Lane, const L: usize, const D: usize, const SUMS: usize, const N: usize> Row<S, L, D, SUMS, N> {
    /// A row in which no lane is set.
    pub(super) fn new() -> Self {
        let zero = [S::default(); L];
        let vectors = [zero; D];
        Self {
            q: vectors,
            p: vectors,
            q_low: [vectors; SUMS],
            p_low: [vectors; SUMS],
            normal: vectors,
            total: [vectors; N],
            lambda: [zero; N],
            asked: zero,
            astray: zero,
        }
    }

    /// Puts a trajectory into a lane, as if w and λ had not changed in the step before. False where they are no
    /// numbers.
    pub(super) fn set(
        &mut self,
        lane: usize,
        laws: &impl Laws<S, D>,
        &Body { q, q_low, p, p_low }: &Body<S, D>,
    ) -> bool {
        let [gradient] = laws.constraint(lane).borrow().jacobian(&q);
        let (lambda, total) = pull(laws, lane, &q, &p, &gradient);
        for (vectors, x) in [(&mut self.q, q), (&mut self.p, p), (&mut self.normal, gradient)] {
            put(vectors, lane, x);
        }
        for (low, x) in [(&mut self.q_low, q_low), (&mut self.p_low, p_low)] {
            if let Some(low) = low.first_mut() {
                put(low, lane, x);
            }
        }
        for (totals, lambdas) in self.total.iter_mut().zip(&mut self.lambda) {
            put(totals, lane, total);
            lambdas[lane] = lambda;
        }
        (self.asked[lane], self.astray[lane]) = (S::default(), S::default());
        let numbers = dot(&total, &total) + dot(&p, &p);
        numbers.le(S::from_f64(f64::MAX))
    }

    /// Takes a step, the end of which was found.
    #[inline(always)]
    pub(super) fn take(&mut self, scratch: &Scratch<S, L, D, N>) {
        let Scratch { end, total, lambda, .. } = scratch;
        (self.q, self.p, self.normal) = (end.q, end.p, end.normal);
        for (low, x) in [(&mut self.q_low, &end.q_low), (&mut self.p_low, &end.p_low)] {
            if let Some(low) = low.first_mut() {
                *low = *x;
            }
        }
        for j in 0..N - 1 {
            (self.total[j], self.lambda[j]) = (total[j], lambda[j]);
        }
        (self.total[N - 1], self.lambda[N - 1]) = (end.total, end.lambda);
        for l in 0..L {
            self.astray[l] = self.astray[l].max(end.astray[l]);
        }
    }

    /// The body of a lane.
    pub(super) fn body(&self, lane: usize) -> Body<S, D> {
        let low = |low: &[Vectors<S, L, D>; SUMS]| low.first().map_or([S::default(); D], |low| at(low, lane));
        let (q, p) = (at(&self.q, lane), at(&self.p, lane));
        Body { q, q_low: low(&self.q_low), p, p_low: low(&self.p_low) }
    }

    /// Copies a lane.
    pub(super) fn copy(&mut self, from: usize, to: usize) {
        self.numbers(|_, numbers| numbers[to] = numbers[from]);
    }

    /// Writes all lanes.
    pub(super) fn record(&self, to: &mut Record) {
        let mut row = self.clone();
        row.numbers(|name, numbers| to.numbers(name, &[L], numbers.iter().map(|x| x.to_f64())));
    }

    /// The row that was written.
    pub(super) fn recalled(from: &mut Reading<'_>) -> Result<Self, Error> {
        let (mut row, mut went) = (Self::new(), Ok(()));
        row.numbers(|name, numbers| {
            let found = from.numbers(name, &[L]);
            went = went.clone().and(found.map(|found| {
                numbers.iter_mut().zip(found).for_each(|(x, &number)| *x = S::from_f64(number));
            }));
        });
        went.map(|()| row)
    }

    /// Shows each row of numbers, one of each lane.
    fn numbers(&mut self, mut show: impl FnMut(&str, &mut [S; L])) {
        let Self { q, p, q_low, p_low, normal, total, lambda, asked, astray } = self;
        for (name, vectors) in [("q", q), ("p", p), ("normal", normal)] {
            vectors.iter_mut().for_each(|numbers| show(name, numbers));
        }
        for (name, vectors) in [("q rounding", q_low), ("p rounding", p_low)] {
            vectors.as_flattened_mut().iter_mut().for_each(|numbers| show(name, numbers));
        }
        total.as_flattened_mut().iter_mut().for_each(|numbers| show("pull", numbers));
        lambda.iter_mut().for_each(|numbers| show("multiplier", numbers));
        show("asked", asked);
        show("astray", astray);
    }
}

/// λ from g̈ = 0, and f + ∇g λ.
#[inline(always)]
pub(super) fn pull<S: Lane, const D: usize>(
    laws: &impl Laws<S, D>,
    lane: usize,
    q: &[S; D],
    p: &[S; D],
    gradient: &[S; D],
) -> (S, [S; D]) {
    let [bend] = laws.constraint(lane).borrow().jet(q, p).2;
    let force = laws.kick(lane, q, S::from_f64(1.0), [S::default(); D]);
    let lambda = -(bend + dot(&force, gradient)) / dot(gradient, gradient);
    (lambda, add_scaled(&force, lambda, gradient))
}

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
