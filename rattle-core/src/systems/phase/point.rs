//! A point (q, p) of phase space, constraint and energy there, and the step of the energy alone.

use crate::error::PhaseMistake;
use crate::kernel::functions::{HamiltonianKernel, PhaseConstraintKernel};
use crate::number::linear::solve;
use crate::number::vector::{add_scaled, dot, largest, scaled, sum};
use std::array::from_fn;

/// A point of phase space, or a difference of two.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point<const D: usize> {
    pub(super) q: [f64; D],
    pub(super) p: [f64; D],
}

impl<const D: usize> Point<D> {
    pub(super) const ZERO: Self = Self { q: [0.0; D], p: [0.0; D] };

    pub(super) fn plus(&self, other: &Self) -> Self {
        Self { q: sum(&self.q, &other.q), p: sum(&self.p, &other.p) }
    }
    pub(super) fn minus(&self, other: &Self) -> Self {
        self.plus(&other.times(-1.0))
    }
    pub(super) fn times(&self, factor: f64) -> Self {
        self.weighted(factor, factor)
    }
    pub(super) fn weighted(&self, q: f64, p: f64) -> Self {
        Self { q: scaled(q, &self.q), p: scaled(p, &self.p) }
    }
    /// The sizes of coordinates here and there, whichever is larger.
    pub(super) fn reach(&self, other: &Self) -> Self {
        let larger = |a: &[f64; D], b: &[f64; D]| from_fn(|i| a[i].abs().max(b[i].abs()));
        Self { q: larger(&self.q, &other.q), p: larger(&self.p, &other.p) }
    }
    /// How many times this is as large as the other, in positions or in momenta, whichever is more; 0 where the other
    /// is.
    pub(super) fn over(&self, other: &Self) -> f64 {
        let part = |x: &[f64; D], other: &[f64; D]| {
            let length = largest(other);
            if length > 0.0 { largest(x) / length } else { 0.0 }
        };
        part(&self.q, &other.q).max(part(&self.p, &other.p))
    }
    /// The largest coordinate and the largest momentum.
    pub(super) fn sizes(&self) -> [f64; 2] {
        [largest(&self.q), largest(&self.p)]
    }
    /// What a function with these slopes changes by along a direction.
    pub(super) fn along(&self, direction: &Self) -> f64 {
        dot(&self.q, &direction.q) + dot(&self.p, &direction.p)
    }
    /// The size of the terms of that.
    pub(super) fn size_along(&self, direction: &Self) -> f64 {
        products(&self.q, &direction.q) + products(&self.p, &direction.p)
    }
    /// The largest coordinate for all of them, and the largest momentum.
    pub(super) fn most(&self) -> Self {
        let [q, p] = self.sizes();
        Self { q: [q; D], p: [p; D] }
    }
    /// The same of those on which a function with these slopes depends.
    pub(super) fn most_along(&self, slopes: &Self) -> Self {
        let known = |x: &[f64; D], slopes: &[f64; D]| from_fn(|i| if slopes[i] == 0.0 { 0.0 } else { x[i] });
        Self { q: known(&self.q, &slopes.q), p: known(&self.p, &slopes.p) }.most()
    }
}

/// g and its gradients at a point.
pub(super) struct Level<const D: usize, const M: usize> {
    pub(super) value: [f64; M],
    /// (∂gᵢ/∂q, ∂gᵢ/∂p).
    pub(super) gradients: [Point<D>; M],
    /// Σ |∂gᵢ/∂zₖ| rₖ with r the reach: times ε the rounding of gᵢ that comes from that of the point.
    pub(super) size: [f64; M],
    /// The same with the largest coordinates of the reach for all: no less where a point is at zero in some.
    pub(super) extent: [f64; M],
}

impl<const D: usize, const M: usize> Level<D, M> {
    /// At a point whose coordinates were, on the way there, as large as those of `reach`.
    pub(super) fn of<K>(constraint: &K, at: &Point<D>, reach: &Point<D>) -> Self
    where
        K: PhaseConstraintKernel<f64, D, M>,
    {
        let (value, by_q, by_p) = constraint.value_and_jacobians(&at.q, &at.p);
        let gradients = from_fn(|i| Point { q: by_q[i], p: by_p[i] });
        let size = gradients.map(|g| g.size_along(reach));
        Self { value, gradients, size, extent: extents(&gradients, reach) }
    }

    /// As `extent`, of this reach.
    pub(super) fn extent_of(&self, reach: &Point<D>) -> [f64; M] {
        extents(&self.gradients, reach)
    }

    /// g as a part of what it is made of, its slopes times the largest coordinates.
    pub(super) fn shares(&self) -> [f64; M] {
        from_fn(|i| if self.value[i] == 0.0 { 0.0 } else { self.value[i] / self.extent[i] })
    }

    /// The first equation whose gradient is made of those before it, if there is one; in units of the largest
    /// coordinate and of the largest momentum.
    #[cold]
    pub(super) fn dependent(&self, at: &Point<D>) -> Option<PhaseMistake> {
        let [q, p] = units(at);
        let mut basis = [Point::ZERO; M];
        for equation in 0..M {
            let gradient = self.gradients[equation].weighted(q, p);
            let [by_q, by_p] = gradient.sizes();
            let mut rest = gradient.times(1.0 / by_q.max(by_p));
            let whole = rest.along(&rest).sqrt();
            // Twice, since what the first time leaves are the roundings of what it takes away.
            for before in [&basis[..equation]; 2].into_iter().flatten() {
                rest = rest.plus(&before.times(-rest.along(before)));
            }
            let length = rest.along(&rest).sqrt();
            if by_q.max(by_p) == 0.0 || length <= DEPENDENT * whole {
                return Some(PhaseMistake::Dependent { equation, part: length / whole });
            }
            basis[equation] = rest.times(1.0 / length);
        }
        None
    }

    /// The direction in which σᵢ slides.
    pub(super) fn fibre(&self, i: usize) -> Point<D> {
        Point { q: scaled(-1.0, &self.gradients[i].p), p: self.gradients[i].q }
    }

    /// {gᵢ, gⱼ}, and the size of its terms.
    pub(super) fn bracket(&self, i: usize, j: usize) -> (f64, f64) {
        bracket(&self.gradients[i], &self.gradients[j])
    }

    /// ∇{gᵢ, gⱼ} = gⱼ″ (−∂gᵢ/∂p, ∂gᵢ/∂q) − gᵢ″ (−∂gⱼ/∂p, ∂gⱼ/∂q) at the point where this is.
    #[cold]
    pub(super) fn slopes_of_bracket<K>(&self, constraint: &K, at: &Point<D>, i: usize, j: usize) -> Point<D>
    where
        K: PhaseConstraintKernel<f64, D, M>,
    {
        let turned = |of: usize, along: usize| {
            let Point { q, p } = self.fibre(along);
            let (by_q, by_p) = constraint.hessian_vector(&at.q, &at.p, &q, &p);
            Point { q: by_q[of], p: by_p[of] }
        };
        turned(j, i).minus(&turned(i, j))
    }
}

/// The hidden constraint hᵢ = {gᵢ, H}, with what says how it changes.
pub(super) struct Hidden<const D: usize, const M: usize> {
    /// g there.
    pub(super) level: Level<D, M>,
    pub(super) value: [f64; M],
    /// ∇hᵢ.
    pub(super) gradients: [Point<D>; M],
    /// Σ |∂hᵢ/∂zₖ| rₖ with r the largest coordinates and momenta of the reach on which hᵢ depends: times ε the rounding
    /// of hᵢ that comes from that of the point, in whatever units q and p are. Others may be however large.
    pub(super) size: [f64; M],
    /// The same with the largest of all.
    pub(super) extent: [f64; M],
    /// Nᵢⱼ = ∂hᵢ/∂σⱼ, along the fibre.
    pub(super) slopes: [[f64; M]; M],
    /// The largest of the terms that make up each slope.
    terms: [[f64; M]; M],
    /// ḣᵢ along the motion without constraint.
    pub(super) rates: [f64; M],
}

impl<const D: usize, const M: usize> Hidden<D, M> {
    /// At a point whose coordinates were, on the way there, as large as those of `reach`.
    pub(super) fn of<K, H>(constraint: &K, energy: &H, at: &Point<D>, reach: &Point<D>) -> Self
    where
        K: PhaseConstraintKernel<f64, D, M>,
        H: HamiltonianKernel<f64, D>,
    {
        let level = Level::of(constraint, at, reach);
        let (by_q, by_p) = energy.gradients(&at.q, &at.p);
        let [slope, free] = [Point { q: by_q, p: by_p }, Point { q: by_p, p: scaled(-1.0, &by_q) }];
        let fibres: [_; M] = from_fn(|j| level.fibre(j));
        // ∇{gᵢ, H} = gᵢ″ (∂H/∂p, −∂H/∂q) + H″ (−∂gᵢ/∂p, ∂gᵢ/∂q), of which all else is made.
        let (g_q, g_p) = constraint.hessian_vector(&at.q, &at.p, &free.q, &free.p);
        let parts: [[Point<D>; 2]; M] = from_fn(|i| {
            let (q, p) = energy.hessian_vector(&at.q, &at.p, &fibres[i].q, &fibres[i].p);
            [Point { q: g_q[i], p: g_p[i] }, Point { q, p }]
        });
        let gradients = parts.map(|[by_g, by_h]| by_g.plus(&by_h));
        let terms = parts
            .map(|[by_g, by_h]| fibres.map(|fibre| by_g.size_along(&fibre).max(by_h.size_along(&fibre))));
        Self {
            value: level.gradients.map(|g| bracket(&g, &slope).0),
            size: gradients.map(|h| h.size_along(&reach.most_along(&h))),
            extent: extents(&gradients, reach),
            slopes: gradients.map(|h| fibres.map(|fibre| h.along(&fibre))),
            terms,
            rates: gradients.map(|h| h.along(&free)),
            gradients,
            level,
        }
    }

    /// As `extent`, of this reach.
    pub(super) fn extent_of(&self, reach: &Point<D>) -> [f64; M] {
        extents(&self.gradients, reach)
    }

    /// Whether N is singular here but for rounding, in whatever units the equations are.
    pub(super) fn is_undetermined(&self, at: &Point<D>) -> bool {
        let [q, p] = units(at);
        let steepness = self.level.gradients.map(|g| largest(&g.weighted(q, p).sizes()));
        let scaled = |i: usize, x: &[f64; M]| from_fn(|j| x[j] / steepness[j] / steepness[i]);
        let sizes: [f64; M] = from_fn(|i| largest::<_, M>(&scaled(i, &self.terms[i])));
        let slopes = from_fn(|i| scaled(i, &self.slopes[i]).map(|slope| slope / sizes[i]));
        let positive = |x: &f64| *x > 0.0 && x.is_finite();
        !steepness.iter().chain(&sizes).all(positive)
            || (0..M).any(|j| {
                let unit = from_fn(|i| f64::from(u8::from(i == j)));
                solve(slopes, unit).is_none_or(|column| largest(&column) > 1.0 / SINGULAR)
            })
    }

    /// λ such that the motion stays where h = 0; none where the fibre is tangent to that.
    pub(super) fn multipliers(&self) -> Option<[f64; M]> {
        solve(self.slopes, self.rates.map(|rate| -rate))
    }
}

/// N is singular where its smallest part is this far below the terms that it is made of.
const SINGULAR: f64 = 1e-10;
/// A gradient of which those before leave less makes N singular by itself, since N has its square.
const DEPENDENT: f64 = 1e-5;

/// The largest coordinate and the largest momentum; 1 where they are 0.
fn units<const D: usize>(at: &Point<D>) -> [f64; 2] {
    at.sizes().map(|size| if size > 0.0 { size } else { 1.0 })
}

/// What the largest coordinates and momenta of a reach may add up to in functions with these gradients.
#[inline(always)]
fn extents<const D: usize, const M: usize>(gradients: &[Point<D>; M], reach: &Point<D>) -> [f64; M] {
    let most = reach.most();
    gradients.map(|slopes| slopes.size_along(&most))
}

/// {a, b} from gradients, and the size of its terms.
pub(super) fn bracket<const D: usize>(a: &Point<D>, b: &Point<D>) -> (f64, f64) {
    (dot(&a.q, &b.p) - dot(&a.p, &b.q), products(&a.q, &b.p) + products(&a.p, &b.q))
}

/// Σ |aₖ bₖ|.
fn products<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    dot(&a.map(f64::abs), &b.map(f64::abs))
}

/// Iterations of an implicit equation, of which separable energies need one.
const MAX_ITERATIONS: usize = 60;
/// What no longer shrinks is rounding below this part of itself.
pub(crate) const ROUNDING: f64 = 1e-13;
/// And below this part of what it is added to: that is rounded where the equation is evaluated.
pub(crate) const ROUNDING_OF_BASE: f64 = 4.0 * f64::EPSILON;
/// Where the largest of so many moves is no less than that of as many before, what is left may be rounding of the
/// largest coordinate. Single moves say little: of what is coupled one passes zero while others are large.
pub(crate) const MOVES: usize = 4;

/// The Störmer–Verlet step of any energy, symplectic and symmetric:
///
/// ```text
/// p½ = p − h/2 ∂H/∂q(q, p½)
/// q′ = q + h/2 (∂H/∂p(q, p½) + ∂H/∂p(q′, p½))
/// p′ = p½ − h/2 ∂H/∂q(q′, p½)
/// ```
pub(super) struct Verlet<const D: usize> {
    start: [f64; D],
    half: [f64; D],
    end: [f64; D],
    /// z′ − z.
    pub(super) change: Point<D>,
}

impl<const D: usize> Verlet<D> {
    /// The step from a point; none if its equations are not solved.
    pub(super) fn of<H: HamiltonianKernel<f64, D>>(energy: &H, h: f64, from: &Point<D>) -> Option<Self> {
        let Point { q, p } = from;
        let half = 0.5 * h;
        let kick = settle(p, Roots::Many, |kick| scaled(-half, &energy.gradients(q, &sum(p, kick)).0))?;
        let half_way = sum(p, &kick);
        let out = scaled(half, &energy.gradients(q, &half_way).1);
        let next = |drift: &_| add_scaled(&out, half, &energy.gradients(&sum(q, drift), &half_way).1);
        let drift = settle(q, Roots::Many, next)?;
        let end = sum(q, &drift);
        let change = Point { q: drift, p: add_scaled(&kick, -half, &energy.gradients(&end, &half_way).0) };
        Some(Self { start: *q, half: half_way, end, change })
    }

    /// Where it takes a small change of the point it starts from; none as for the step.
    pub(super) fn tangent<H: HamiltonianKernel<f64, D>>(
        &self,
        energy: &H,
        h: f64,
        v: &Point<D>,
    ) -> Option<Point<D>> {
        let half = 0.5 * h;
        let at_start = |dq: &_, dp: &_| energy.hessian_vector(&self.start, &self.half, dq, dp);
        let at_end = |dq: &_, dp: &_| energy.hessian_vector(&self.end, &self.half, dq, dp);
        let p = settle(&v.p, Roots::One, |p| add_scaled(&v.p, -half, &at_start(&v.q, p).0))?;
        let out = add_scaled(&v.q, half, &at_start(&v.q, &p).1);
        let q = settle(&v.q, Roots::One, |q| add_scaled(&out, half, &at_end(q, &p).1))?;
        Some(Point { q, p: add_scaled(&p, -half, &at_end(&q, &p).0) })
    }
}

/// How many roots an equation x = f(x) may have.
///
/// Of many, the step is the root that grows from 0 as h does. Where f is a contraction, with components in whatever
/// units, that is the only root; the component that is largest in these units then moves less from f(0) to f(f(0)) than
/// from 0 to f(0). Where no component moves less, the iteration may end at another root.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Roots {
    /// Of a linear equation.
    One,
    Many,
}

/// x = f(x), iterated from f(0) until each component stays; none where one does not, or where it may stay at another
/// [root](Roots). `base` is what x is added to: a component that is small by cancellation has the rounding of that.
/// What is no number is handed on.
fn settle<const D: usize>(
    base: &[f64; D],
    roots: Roots,
    f: impl Fn(&[f64; D]) -> [f64; D],
) -> Option<[f64; D]> {
    let (mut x, mut last) = (f(&[0.0; D]), f64::INFINITY);
    let (first, mut left) = (x, [Left::NONE; D]);
    for pass in 1..=MAX_ITERATIONS {
        let next = f(&x);
        let moved = add_scaled(&next, -1.0, &x);
        x = next;
        let (most, all) = (largest(&moved), ROUNDING * largest(base).max(largest(&x)));
        let mut rests = true;
        for i in 0..D {
            left[i].note(moved[i].abs(), pass % MOVES == 0);
            rests &= left[i].is_rounding(moved[i].abs(), x[i].abs(), base[i].abs(), all);
        }
        if rests || moved.iter().any(|x| x.is_nan()) {
            return Some(x);
        }
        let nearer = |i: usize| moved[i].abs() < first[i].abs();
        let astray = most >= 2.0 * last || pass == 1 && roots == Roots::Many && !(0..D).any(nearer);
        if !most.is_finite() || (astray && most > all) {
            return None;
        }
        last = most;
    }
    None
}

/// How a component of such an iteration comes nearer.
#[derive(Clone, Copy)]
struct Left {
    /// The least that it was moved by, as it was halved again and again; and whether the last move was no such half. A
    /// component that does not move says nothing: others may move it in the next pass.
    least: f64,
    stalled: bool,
    /// The largest move of the last few, and of those before.
    peak: f64,
    peak_before: f64,
    /// Whether that did not fall, and was not halved since.
    stuck: bool,
}

impl Left {
    const NONE: Self =
        Self { least: f64::INFINITY, stalled: false, peak: 0.0, peak_before: f64::INFINITY, stuck: false };

    /// A move, and whether it is the last one of a few.
    #[inline(always)]
    fn note(&mut self, moved: f64, last: bool) {
        let nearer = moved < 0.5 * self.least;
        if moved > 0.0 {
            (self.stalled, self.least) = (!nearer, if nearer { moved } else { self.least });
        }
        self.peak = self.peak.max(moved);
        if last {
            let fell = self.peak < self.peak_before || self.peak_before == 0.0;
            self.stuck = !fell || (self.stuck && self.peak >= 0.5 * self.peak_before);
            (self.peak_before, self.peak) = (self.peak, 0.0);
        }
    }

    /// Whether what is left is rounding: of a component of size x, of what it is added to, or at last of the largest.
    #[inline(always)]
    fn is_rounding(&self, moved: f64, x: f64, base: f64, all: f64) -> bool {
        let own = (ROUNDING * x).max(ROUNDING_OF_BASE * base);
        moved <= f64::EPSILON * x
            || (self.stalled && moved <= own)
            || (self.stuck && moved.max(self.peak_before) <= all)
    }
}
