//! Slides along fibres in lanes, by the Gauss method of [`fibre`](crate::systems::phase::fibre).
//!
//! ```text
//! Kᵢ = Σₘ σₘ fₘ(z + Σⱼ aᵢⱼ Kⱼ)        fₘ = (−∂gₘ/∂p, ∂gₘ/∂q)        z̃ − z = Σ bᵢ Kᵢ
//! ```
//!
//! The stages are iterated in all lanes; a lane that rests keeps its own. What is kept of a slide are the fₘ, so that
//! one by another σ begins with them. A lane whose stages come nearer too slowly, where a simulation divides the slide
//! into parts, goes by itself.

use crate::kernel::functions::PhaseConstraintKernel;
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::number::vectors::at;
use crate::run::ensemble::phase_row::{Each, Laws, Points, ROW, Vector, ZEROS};
use crate::systems::phase::fibre::{A, B, CONTRACTION, STAGES};

/// A lane goes on, rests, or goes by itself.
pub(super) const GOES: f64 = 1.0;
pub(super) const RESTS: f64 = 0.0;
pub(super) const BY_ITSELF: f64 = -1.0;

/// Passes after which a lane goes by itself.
const MOST_PASSES: usize = 24;

/// What is left of a change is nothing below this part of it: a sixteenth of a rounding.
const LEFT: f64 = f64::EPSILON / 16.0;

/// What no longer shrinks is rounding below this part.
const ROUNDING: f64 = 1e-13;

/// No pass is trusted to shrink what is left by more than this.
const SHRINKS: f64 = 1e-3;

/// Where stages have begun with those of a nearby slide, they come nearer by at least this factor.
const NEARER: f64 = 0.25;

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
    moved: Each,
    size: Each,
    last: Each,
}

impl<const D: usize, const M: usize> Slide<D, M> {
    pub(super) const NONE: Self = Self {
        directions: [const { [const { Points::ZERO }; M] }; STAGES],
        stages: [const { Points::ZERO }; STAGES],
        speeds: [const { Points::ZERO }; STAGES],
        change: Points::ZERO,
        sliding: ZEROS,
        moved: ZEROS,
        size: ZEROS,
        last: ZEROS,
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

    /// Slides by σ from these points where lanes are going. `anew` says that the directions are those of the start.
    #[inline(always)]
    pub(super) fn slide(
        &mut self,
        laws: &impl Laws<D, M>,
        start: &Points<D>,
        sigma: &[Each; M],
        anew: bool,
        going: &mut Each,
    ) {
        let Self { directions, stages, speeds, change, sliding, moved, size, last } = self;
        for l in 0..ROW {
            let goes = Fused(0.0).lt(going[l]);
            sliding[l] = Real::select(goes, Fused(GOES), Fused(RESTS));
            last[l] = Fused(f64::INFINITY);
        }
        *size = ZEROS;
        for i in 0..STAGES {
            speed(sigma, &directions[i], &mut speeds[i], size);
        }
        for pass in 0..MOST_PASSES {
            for d in 0..D {
                advance(d, &start.q, speeds, stages);
                advance_momenta(d, &start.p, speeds, stages);
            }
            *moved = ZEROS;
            for i in 0..STAGES {
                look(laws, &stages[i], sigma, sliding, &mut directions[i], &mut speeds[i], moved);
            }
            if !decide(pass, anew, moved, size, last, sliding) {
                break;
            }
        }
        for d in 0..D {
            gather(d, speeds, change);
        }
        for l in 0..ROW {
            let lost = sliding[l].lt(Fused(0.0));
            going[l] = Real::select(lost, Fused(BY_ITSELF), going[l]);
        }
    }
}

/// Kᵢ, and the largest of its components and of what was found before.
#[inline(always)]
fn speed<const D: usize, const M: usize>(
    sigma: &[Each; M],
    directions: &[Points<D>; M],
    speed: &mut Points<D>,
    size: &mut Each,
) {
    for l in 0..ROW {
        let mut most = size[l];
        for d in 0..D {
            let (mut q, mut p) = (Fused(0.0), Fused(0.0));
            for m in 0..M {
                q = sigma[m][l].multiply_add(directions[m].q[d][l], q);
                p = sigma[m][l].multiply_add(directions[m].p[d][l], p);
            }
            most = most.max(q.abs()).max(p.abs());
            (speed.q[d][l], speed.p[d][l]) = (q, p);
        }
        size[l] = most;
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

/// The fₘ at a stage and its Kᵢ, where lanes are sliding; and the largest component by which that or one before has
/// moved. (One that is no number shows at the end of the step.)
#[inline(always)]
fn look<const D: usize, const M: usize>(
    laws: &impl Laws<D, M>,
    stage: &Points<D>,
    sigma: &[Each; M],
    sliding: &Each,
    directions: &mut [Points<D>; M],
    speed: &mut Points<D>,
    moved: &mut Each,
) {
    for l in 0..ROW {
        let (by_q, by_p) = laws.constraint(l).jacobians(&at(&stage.q, l), &at(&stage.p, l));
        let (slides, mut most) = (Fused(0.0).lt(sliding[l]), moved[l]);
        for d in 0..D {
            let (mut to_q, mut to_p) = (Fused(0.0), Fused(0.0));
            for m in 0..M {
                let Points { q, p } = &mut directions[m];
                q[d][l] = Real::select(slides, -by_p[m][d], q[d][l]);
                p[d][l] = Real::select(slides, by_q[m][d], p[d][l]);
                to_q = sigma[m][l].multiply_add(q[d][l], to_q);
                to_p = sigma[m][l].multiply_add(p[d][l], to_p);
            }
            most = most.max((to_q - speed.q[d][l]).abs()).max((to_p - speed.p[d][l]).abs());
            (speed.q[d][l], speed.p[d][l]) = (to_q, to_p);
        }
        moved[l] = most;
    }
}

/// Which lanes rest now, and which go by themselves. Returns whether one is still sliding.
#[inline(always)]
fn decide(pass: usize, anew: bool, moved: &Each, size: &Each, last: &mut Each, sliding: &mut Each) -> bool {
    let [zero, half, goes, by_itself] = [0.0, 0.5, GOES, BY_ITSELF].map(Fused);
    let [left, epsilon, rounding, shrinks] = [LEFT, f64::EPSILON, ROUNDING, SHRINKS].map(Fused);
    let slowest = Fused(if anew { CONTRACTION } else { NEARER });
    let (first, late, end) = (pass == 0, pass > 1, pass + 1 == MOST_PASSES);
    let mut any = false;
    for l in 0..ROW {
        let (off, before, size) = (moved[l], last[l], size[l]);
        let rate = off / before;
        let rate = Real::select(shrinks.le(rate), rate, shrinks);
        let is_noise = off.le(rounding * size);
        let still = off.le(epsilon * size) | (!first & (rate * off).le(left * size));
        let rests = still | (late & (half * before).le(off) & is_noise);
        let slow = !first & !is_noise & !off.le(slowest * before);
        let lost = slow | end | !off.le(Fused(f64::MAX));
        let now = Real::select(rests, zero, Real::select(lost, by_itself, goes));
        sliding[l] = Real::select(zero.lt(sliding[l]), now, sliding[l]);
        last[l] = off;
        any |= zero.lt(sliding[l]);
    }
    any
}

/// One coordinate and momentum of the whole slide.
#[inline(always)]
fn gather<const D: usize>(d: usize, speeds: &[Points<D>; STAGES], change: &mut Points<D>) {
    for l in 0..ROW {
        let (mut q, mut p) = (Fused(0.0), Fused(0.0));
        for j in 0..STAGES {
            q = Fused(B[j]).multiply_add(speeds[j].q[d][l], q);
            p = Fused(B[j]).multiply_add(speeds[j].p[d][l], p);
        }
        (change.q[d][l], change.p[d][l]) = (q, p);
    }
}
