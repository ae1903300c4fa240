//! Slides along fibres in lanes, by the Gauss method of [`fibre`](crate::systems::phase::fibre).
//!
//! ```text
//! Kᵢ = Σₘ σₘ fₘ(z + Σⱼ aᵢⱼ Kⱼ)        fₘ = (−∂gₘ/∂p, ∂gₘ/∂q)        z̃ − z = Σ bᵢ Kᵢ
//! ```
//!
//! The stages are iterated in all lanes; a lane that rests keeps its own. What is kept of a slide are the fₘ, so that
//! one by another σ begins with them. A lane where a simulation divides the slide into parts goes by itself.

use crate::kernel::functions::PhaseConstraintKernel;
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::number::vector::largest;
use crate::number::vectors::at;
use crate::run::ensemble::phase_row::{Each, Laws, Number, Points, ROW, Vector, ZEROS};
use crate::systems::phase::fibre::{A, B, CONTRACTION, DECAY, DETAILS, LEFT, ROUNDING, SHRINKS, STAGES};

/// A lane goes on, rests, or goes by itself.
pub(super) const GOES: f64 = 1.0;
pub(super) const RESTS: f64 = 0.0;
pub(super) const BY_ITSELF: f64 = -1.0;

/// Passes after which a lane goes by itself.
const MOST_PASSES: usize = 24;

/// A slide of each lane.
pub(super) struct Slide<const D: usize, const M: usize> {
    /// The fₘ at the stages.
    pub(super) directions: [[Points<D>; M]; STAGES],
    /// The stages, and the Kᵢ.
    stages: [Points<D>; STAGES],
    speeds: [Points<D>; STAGES],
    /// z̃ − z.
    pub(super) change: Points<D>,
    sliding: Each,
    /// The largest Kᵢ, by which they have moved, and with what weights both count, of positions and of momenta.
    sizes: [Each; 2],
    moved: [Each; 2],
    weights: [Each; 2],
    /// One size for both; what the last pass and the one before it moved; and by what part that shrank.
    size: Each,
    last: [Each; 2],
    rate: Each,
}

impl<const D: usize, const M: usize> Slide<D, M> {
    pub(super) const NONE: Self = Self {
        directions: [const { [const { Points::ZERO }; M] }; STAGES],
        stages: [const { Points::ZERO }; STAGES],
        speeds: [const { Points::ZERO }; STAGES],
        change: Points::ZERO,
        sliding: ZEROS,
        sizes: [ZEROS; 2],
        moved: [ZEROS; 2],
        weights: [ZEROS; 2],
        size: ZEROS,
        last: [ZEROS; 2],
        rate: ZEROS,
    };

    /// Has all stages begin with the directions of the first.
    #[inline(always)]
    pub(super) fn begin(&mut self) {
        let (first, others) = self.directions.split_at_mut(1);
        for other in others {
            for m in 0..M {
                (other[m].q, other[m].p) = (first[0][m].q, first[0][m].p);
            }
        }
    }

    /// Slides by σ from these points where lanes are going.
    #[inline(always)]
    pub(super) fn slide(
        &mut self,
        laws: &impl Laws<D, M>,
        start: &Points<D>,
        sigma: &[Each; M],
        going: &mut Each,
    ) {
        let Self { directions, stages, speeds, change, sliding, sizes, moved, weights, size, last, rate } =
            self;
        for l in 0..ROW {
            let goes = Fused(0.0).lt(going[l]);
            sliding[l] = Real::select(goes, Fused(GOES), Fused(RESTS));
        }
        (*sizes, *last, *rate) = ([ZEROS; 2], [[Fused(f64::INFINITY); ROW]; 2], ZEROS);
        for i in 0..STAGES {
            speed(sigma, &directions[i], &mut speeds[i], sizes);
        }
        for pass in 0..MOST_PASSES {
            for d in 0..D {
                advance(d, &start.q, speeds, stages);
                advance_momenta(d, &start.p, speeds, stages);
            }
            *moved = [ZEROS; 2];
            for i in 0..STAGES {
                look(laws, &stages[i], sigma, sliding, &mut directions[i], &mut speeds[i], moved);
            }
            if pass == 0 {
                weigh(start, moved, sizes, weights, size);
            }
            if !decide(pass, moved, weights, size, last, rate, sliding) {
                break;
            }
        }
        for d in 0..D {
            gather(d, speeds, change);
        }
        for (detail, most) in DETAILS.iter().zip([DECAY.powi(3), DECAY.powi(4)]) {
            *moved = [ZEROS; 2];
            for d in 0..D {
                grow(d, speeds, detail, moved);
            }
            judge(moved, weights, size, most, sliding);
        }
        for l in 0..ROW {
            let lost = sliding[l].lt(Fused(0.0)) & Fused(0.0).lt(going[l]);
            going[l] = Real::select(lost, Fused(BY_ITSELF), going[l]);
        }
    }
}

/// Kᵢ, and the largest of its components in positions and in momenta, and of what was found before.
#[inline(always)]
fn speed<const D: usize, const M: usize>(
    sigma: &[Each; M],
    directions: &[Points<D>; M],
    speed: &mut Points<D>,
    [size_q, size_p]: &mut [Each; 2],
) {
    for l in 0..ROW {
        let (mut most_q, mut most_p) = (size_q[l], size_p[l]);
        for d in 0..D {
            let (mut q, mut p) = (Fused(0.0), Fused(0.0));
            for m in 0..M {
                q = sigma[m][l].multiply_add(directions[m].q[d][l], q);
                p = sigma[m][l].multiply_add(directions[m].p[d][l], p);
            }
            (most_q, most_p) = (most_q.max(q.abs()), most_p.max(p.abs()));
            (speed.q[d][l], speed.p[d][l]) = (q, p);
        }
        (size_q[l], size_p[l]) = (most_q, most_p);
    }
}

/// With what weights positions and momenta count, as in a simulation, and the size of the Kᵢ then.
#[inline(always)]
fn weigh<const D: usize>(
    start: &Points<D>,
    moved: &[Each; 2],
    sizes: &[Each; 2],
    weights: &mut [Each; 2],
    size: &mut Each,
) {
    let (zero, most) = (Fused(0.0), Fused(f64::MAX));
    for l in 0..ROW {
        let reach = [largest(&at(&start.q, l)), largest(&at(&start.p, l))];
        size[l] = zero;
        for part in 0..2 {
            // What is zero at first may move in the first pass. One that begins to later is lost.
            let motion = sizes[part][l].max(moved[part][l]);
            let weight = Fused(1.0) / (motion.sqrt() * reach[part].max(motion).sqrt());
            weights[part][l] = Real::select(zero.lt(motion), weight, most);
            size[l] = size[l].max(motion * weights[part][l]);
        }
    }
}

/// One coordinate of all stages.
#[inline(always)]
fn advance<const D: usize>(
    d: usize,
    start: &Vector<D>,
    speeds: &[Points<D>; STAGES],
    stages: &mut [Points<D>; STAGES],
) {
    for l in 0..ROW {
        for i in 0..STAGES {
            let mut inner = Fused(0.0);
            for j in 0..STAGES {
                inner = Fused(A[i][j]).multiply_add(speeds[j].q[d][l], inner);
            }
            stages[i].q[d][l] = start[d][l] + inner;
        }
    }
}

/// One momentum of all stages.
#[inline(always)]
fn advance_momenta<const D: usize>(
    d: usize,
    start: &Vector<D>,
    speeds: &[Points<D>; STAGES],
    stages: &mut [Points<D>; STAGES],
) {
    for l in 0..ROW {
        for i in 0..STAGES {
            let mut inner = Fused(0.0);
            for j in 0..STAGES {
                inner = Fused(A[i][j]).multiply_add(speeds[j].p[d][l], inner);
            }
            stages[i].p[d][l] = start[d][l] + inner;
        }
    }
}

/// The fₘ at a stage and its Kᵢ, where lanes are sliding; and the largest position and momentum by which that or one
/// before has moved. (One that is no number shows at the end of the step.)
#[inline(always)]
fn look<const D: usize, const M: usize>(
    laws: &impl Laws<D, M>,
    stage: &Points<D>,
    sigma: &[Each; M],
    sliding: &Each,
    directions: &mut [Points<D>; M],
    speed: &mut Points<D>,
    [moved_q, moved_p]: &mut [Each; 2],
) {
    for l in 0..ROW {
        let (by_q, by_p) = laws.constraint(l).jacobians(&at(&stage.q, l), &at(&stage.p, l));
        let (slides, mut most_q, mut most_p) = (Fused(0.0).lt(sliding[l]), moved_q[l], moved_p[l]);
        for d in 0..D {
            let (mut to_q, mut to_p) = (Fused(0.0), Fused(0.0));
            for m in 0..M {
                let Points { q, p } = &mut directions[m];
                q[d][l] = Real::select(slides, -by_p[m][d], q[d][l]);
                p[d][l] = Real::select(slides, by_q[m][d], p[d][l]);
                to_q = sigma[m][l].multiply_add(q[d][l], to_q);
                to_p = sigma[m][l].multiply_add(p[d][l], to_p);
            }
            most_q = most_q.max((to_q - speed.q[d][l]).abs());
            most_p = most_p.max((to_p - speed.p[d][l]).abs());
            (speed.q[d][l], speed.p[d][l]) = (to_q, to_p);
        }
        (moved_q[l], moved_p[l]) = (most_q, most_p);
    }
}

/// Which lanes rest now, and which go by themselves. Returns whether one is still sliding.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "what passes move, and what is made of it")]
fn decide(
    pass: usize,
    moved: &[Each; 2],
    weights: &[Each; 2],
    size: &Each,
    last: &mut [Each; 2],
    rate: &mut Each,
    sliding: &mut Each,
) -> bool {
    let [zero, half, goes, by_itself] = [0.0, 0.5, GOES, BY_ITSELF].map(Fused);
    let [left, epsilon, rounding, shrinks] = [LEFT, f64::EPSILON, ROUNDING, SHRINKS].map(Fused);
    let slowest = Fused(CONTRACTION * CONTRACTION);
    let (first, late, end) = (pass == 0, pass > 1, pass + 1 == MOST_PASSES);
    let mut any = false;
    for l in 0..ROW {
        let off = (moved[0][l] * weights[0][l]).max(moved[1][l] * weights[1][l]);
        let (before, earlier, size) = (last[1][l], last[0][l], size[l]);
        // Where passes move positions and momenta in turn, the slower of two tells what is left.
        let (now, slower) = (off / before, rate[l]);
        rate[l] = Real::select(shrinks.le(now), now, shrinks);
        let rate = rate[l].max(slower);
        let is_noise = off.le(rounding * size);
        let still = off.le(epsilon * size) | (!first & (rate * off).le(left * size));
        let rests = still | (late & (half * before).le(off) & is_noise);
        let slow = late & !is_noise & !off.le(slowest * earlier);
        let lost = slow | end | !off.le(Fused(f64::MAX));
        let now = Real::select(rests, zero, Real::select(lost, by_itself, goes));
        sliding[l] = Real::select(zero.lt(sliding[l]), now, sliding[l]);
        (last[0][l], last[1][l]) = (before, off);
        any |= zero.lt(sliding[l]);
    }
    any
}

/// One coordinate and momentum of Σ wᵢ Kᵢ in a lane.
#[inline(always)]
fn combined<const D: usize>(
    (d, l): (usize, usize),
    speeds: &[Points<D>; STAGES],
    weights: &[f64; STAGES],
) -> [Number; 2] {
    let [mut q, mut p] = [Fused(0.0); 2];
    for j in 0..STAGES {
        q = Fused(weights[j]).multiply_add(speeds[j].q[d][l], q);
        p = Fused(weights[j]).multiply_add(speeds[j].p[d][l], p);
    }
    [q, p]
}

/// The largest coordinate and momentum of that, up to this one.
#[inline(always)]
fn grow<const D: usize>(
    d: usize,
    speeds: &[Points<D>; STAGES],
    weights: &[f64; STAGES],
    [most_q, most_p]: &mut [Each; 2],
) {
    for l in 0..ROW {
        let [q, p] = combined((d, l), speeds, weights);
        (most_q[l], most_p[l]) = (most_q[l].max(q.abs()), most_p[l].max(p.abs()));
    }
}

/// Lanes in which that is more than this part of the motion go by themselves.
#[inline(always)]
fn judge(found: &[Each; 2], weights: &[Each; 2], size: &Each, most: f64, sliding: &mut Each) {
    for l in 0..ROW {
        let off = (found[0][l] * weights[0][l]).max(found[1][l] * weights[1][l]);
        sliding[l] = Real::select(off.le(Fused(most) * size[l]), sliding[l], Fused(BY_ITSELF));
    }
}

/// One coordinate and momentum of the whole slide.
#[inline(always)]
fn gather<const D: usize>(d: usize, speeds: &[Points<D>; STAGES], change: &mut Points<D>) {
    for l in 0..ROW {
        let [q, p] = combined((d, l), speeds, &B);
        (change.q[d][l], change.p[d][l]) = (q, p);
    }
}
