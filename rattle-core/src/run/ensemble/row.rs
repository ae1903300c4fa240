//! Rows of trajectories in lanes that are moved by [collocation](crate::run::ensemble::stages): the numbers kept from
//! step to step, and working memory for one step.

use crate::kernel::functions::ConstraintKernel;
use crate::kernel::rounding::size_along;
use crate::motion::bodies::Body;
use crate::motion::table::Table;
use crate::number::lanes::Lane;
use crate::number::vector::{add_scaled, dot};
use crate::number::vectors::{Vectors, at, put};
use crate::run::ensemble::inside::follows;
use crate::run::ensemble::lane_record::{InRows, Rows};
use crate::run::ensemble::laws::Laws;
use std::array::from_fn;
use std::borrow::Borrow;

/// Has to go by itself.
pub(super) const BY_ITSELF: f64 = -1.0;

/// Has gone farther astray than it was looked for other sheets.
pub(super) const LOOKING: f64 = -2.0;

/// The numbers of a method of N stages, times the step size.
#[derive(Debug, Clone)]
pub(super) struct Tableau<S, const N: usize> {
    /// The step size.
    pub(super) h: S,
    /// h cᵢ, and what rounding took from it.
    pub(super) drift: [S; N],
    pub(super) drift_rest: [S; N],
    /// h² aᵢⱼ, and what rounding took from it.
    pub(super) push: [[S; N]; N],
    pub(super) push_rest: [[S; N]; N],
    /// h bⱼ, and what rounding took from it.
    pub(super) kick: [S; N],
    pub(super) kick_rest: [S; N],
    /// From the last step's stages to this one's; and the same times h² aᵢⱼ.
    pub(super) ahead: [[S; N]; N],
    pub(super) first: [[S; N]; N],
}

impl<S: Lane, const N: usize> Tableau<S, N> {
    pub(super) fn of(table: &Table<N>, h: f64) -> Self {
        let number = S::from_f64;
        // What a float of lanes takes from a number of two doubles.
        let rest = |(high, low): (f64, f64)| number((high - number(high).to_f64()) + low);
        let push = |i: usize, j: usize| table.push(h, i, j).0;
        // The first stage is the last one of the step before.
        let ahead = |j: usize, k: usize| match j {
            0 => f64::from(u8::from(k == N - 1)),
            _ => table.ahead[j][k],
        };
        let first = |i: usize, k: usize| (0..N - 1).map(|j| push(i, j) * ahead(j, k)).sum::<f64>();
        Self {
            h: number(h),
            first: from_fn(|i| from_fn(|k| number(first(i, k)))),
            drift: from_fn(|i| number(table.drift(h, i).0)),
            drift_rest: from_fn(|i| rest(table.drift(h, i))),
            push: from_fn(|i| from_fn(|j| number(table.push(h, i, j).0))),
            push_rest: from_fn(|i| from_fn(|j| rest(table.push(h, i, j)))),
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
    /// Stages, how far they are from where they should be, and ∇g there. The first stage is the start.
    pub(super) place: [Vectors<S, L, D>; N],
    pub(super) away: [Vectors<S, L, D>; N],
    /// Where positions are compensated sums: what rounding took from the start, and from coefficients on the way from
    /// there to the stages.
    pub(super) rest: [Vectors<S, L, D>; N],
    pub(super) normal: [Vectors<S, L, D>; N],
    /// g of the linearised equations; then what λ is corrected by.
    pub(super) residual: [[S; L]; N],
    /// The matrix, and its factors.
    pub(super) matrix: [[[S; L]; N]; N],
    /// The largest displacement of a pass, and of the pass before.
    pub(super) moved: [S; L],
    pub(super) before: [S; L],
    /// By which part the last one was smaller than the one before.
    pub(super) rates: [S; L],
    /// How large places are along the normal, or the path; and how much displacements along each coordinate count.
    pub(super) size: [S; L],
    pub(super) counts: Vectors<S, L, D>,
    pub(super) path: [S; L],
    /// 1 while a lane is moved, 0 where it rests, [`BY_ITSELF`], or [`LOOKING`].
    pub(super) going: [S; L],
    /// The end of the step.
    pub(super) end: End<S, L, D>,
}

/// Where a step ends: place and momentum with what rounding took from them, ∇g, w and λ there (until then λ at the
/// start), and how far the step may have led astray.
#[derive(Clone)]
pub(super) struct End<S, const L: usize, const D: usize> {
    pub(super) q: Vectors<S, L, D>,
    pub(super) q_low: Vectors<S, L, D>,
    pub(super) p: Vectors<S, L, D>,
    pub(super) p_low: Vectors<S, L, D>,
    pub(super) normal: Vectors<S, L, D>,
    pub(super) total: Vectors<S, L, D>,
    pub(super) lambda: [S; L],
    pub(super) strays: [S; L],
}

impl<S: Lane, const L: usize, const D: usize, const N: usize> Scratch<S, L, D, N> {
    pub(super) fn new() -> Self {
        let zero = [S::default(); L];
        let (vectors, stages) = ([zero; D], [[zero; D]; N]);
        Self {
            place: stages,
            away: stages,
            rest: stages,
            normal: stages,
            residual: [zero; N],
            matrix: [[zero; N]; N],
            moved: zero,
            before: zero,
            rates: zero,
            size: zero,
            counts: vectors,
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
                strays: zero,
            },
        }
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

    /// Takes a step, the end of which was found; what is remembered of its other stages is there.
    #[inline(always)]
    pub(super) fn take(&mut self, end: &End<S, L, D>) {
        (self.q, self.p, self.normal) = (end.q, end.p, end.normal);
        for (low, x) in [(&mut self.q_low, &end.q_low), (&mut self.p_low, &end.p_low)] {
            if let Some(low) = low.first_mut() {
                *low = *x;
            }
        }
        (self.total[N - 1], self.lambda[N - 1]) = (end.total, end.lambda);
        for l in 0..L {
            self.astray[l] = self.astray[l].max(end.strays[l]);
        }
    }

    /// Notes where a step by itself has led a lane, and what the method remembers of it. Returns whether it has led
    /// along one sheet for all that is seen.
    pub(super) fn land(
        &mut self,
        lane: usize,
        laws: &impl Laws<S, D>,
        h: S,
        to: &Body<S, D>,
        memory: &[S],
        end: &mut End<S, L, D>,
    ) -> bool {
        let (totals, lambdas) = memory[1..].split_at(N * D);
        for j in 0..N - 1 {
            put(&mut self.total[j], lane, from_fn(|d| totals[j * D + d]));
            self.lambda[j][lane] = lambdas[j];
        }
        let [gradient] = laws.constraint(lane).borrow().jacobian(&to.q);
        let (multiplier, pulled) = pull(laws, lane, &to.q, &to.p, &gradient);
        let End { q, q_low, p, p_low, normal, total, lambda, strays } = end;
        let all = [(q, to.q), (q_low, to.q_low), (p, to.p), (p_low, to.p_low)];
        all.into_iter().chain([(normal, gradient), (total, pulled)]).for_each(|(x, of)| put(x, lane, of));
        lambda[lane] = multiplier;
        let from = [&self.q, &self.p, &self.total[N - 1]].map(|x| at(x, lane));
        let way = add_scaled(&to.q, S::from_f64(-1.0), &from[0]);
        let places = from_fn(|d| to.q[d].abs().max(from[0][d].abs()));
        let size = size_along(&gradient, dot(&gradient, &gradient).sqrt(), &places);
        let (strayed, plain) = follows(laws, lane, h, from, [way, to.p, gradient, pulled], size);
        strays[lane] = strayed;
        plain
    }

    /// A coordinate of a lane, what rounding took from it, and its momentum.
    #[inline(always)]
    pub(super) fn coordinate(&self, d: usize, lane: usize) -> (S, S, S) {
        let (q, p) = (self.q[d][lane], self.p[d][lane]);
        if const { SUMS == 0 } {
            (q, S::default(), p)
        } else {
            (q, self.q_low[0][d][lane], p + self.p_low[0][d][lane])
        }
    }

    /// The body of a lane.
    pub(super) fn body(&self, lane: usize) -> Body<S, D> {
        let low = |low: &[Vectors<S, L, D>; SUMS]| low.first().map_or([S::default(); D], |low| at(low, lane));
        let (q, p) = (at(&self.q, lane), at(&self.p, lane));
        Body { q, q_low: low(&self.q_low), p, p_low: low(&self.p_low) }
    }
}

impl<S: Lane, const L: usize, const D: usize, const SUMS: usize, const N: usize> InRows<S>
    for Row<S, L, D, SUMS, N>
{
    fn rows(&mut self) -> Rows<'_, S> {
        let Self { q, p, q_low, p_low, normal, total, lambda, asked, astray } = self;
        let mut rows: Rows<'_, S> = Vec::new();
        for (name, vectors) in [("q", &mut q[..]), ("p", p), ("normal", normal)] {
            vectors.iter_mut().for_each(|numbers| rows.push((name, numbers)));
        }
        for (name, vectors) in [("q rounding", q_low), ("p rounding", p_low)] {
            vectors.as_flattened_mut().iter_mut().for_each(|numbers| rows.push((name, numbers)));
        }
        total.as_flattened_mut().iter_mut().for_each(|numbers| rows.push(("pull", numbers)));
        lambda.iter_mut().for_each(|numbers| rows.push(("multiplier", numbers)));
        rows.extend([("asked", &mut asked[..]), ("astray", astray)]);
        rows
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
