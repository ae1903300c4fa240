//! A step in phase space for trajectories in lanes: geometric RATTLE, as in
//! [`landing`](crate::systems::phase::landing) and [`step`](crate::systems::phase::step).
//!
//! Each lane does what a simulation does, from the same first guesses, until the same residuals are rounding, and is
//! asked the same questions: whether the guess was near, N has changed little, and what the guess was off by is as
//! usual. **A lane for which the answer is not plain takes the step by itself**, as a simulation does: there the step
//! is looked at inside, followed from its start, or refused. So a lane ends on no other sheet than a simulation does.

use crate::kernel::functions::PhaseConstraintKernel;
use crate::motion::start::START_TOLERANCE;
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::number::vector::{dot, largest, two_sum};
use crate::number::vectors::{at, put};
use crate::run::ensemble::phase_energy::Leap;
use crate::run::ensemble::phase_fibre::{BY_ITSELF, GOES, RESTS, Slide};
use crate::run::ensemble::phase_hidden::{directions, evaluate, hidden, rates};
use crate::run::ensemble::phase_numbers::{over, solve, turn, worst};
use crate::run::ensemble::phase_row::{Each, Laws, Matrix, Points, ROW, Row, ZEROS, matrix};
use crate::solve::aim::{Aim, ROUNDINGS};
use crate::solve::root::{FAR_GUESS, SHORT_PATH, straight};
use crate::systems::phase::landing::{STEADY, TILT};
use crate::systems::phase::noise::NOISE;
use crate::systems::phase::step::TURN;

/// Corrections after which a lane goes by itself.
const MOST_LOOKS: usize = 10;

/// What a step works on.
#[repr(C, align(64))]
pub(super) struct Scratch<const D: usize, const M: usize> {
    slide: Slide<D, M>,
    leap: Leap<D>,
    sigma: [Each; M],
    guess: [Each; M],
    correction: [Each; M],
    /// The point after the first slide, and directions of fibres there; where a small change of it leads.
    kicked: Points<D>,
    fibre: [Points<D>; M],
    small: Points<D>,
    /// All of a slide and a step; and the sizes of coordinates on the way.
    change: Points<D>,
    at: Points<D>,
    reach: Points<D>,
    /// What shall vanish, its size, and that if all coordinates were as large as the largest.
    value: [Each; M],
    size: [Each; M],
    extent: [Each; M],
    /// (∂gᵢ/∂q, ∂gᵢ/∂p).
    gradients: [Points<D>; M],
    energy: Points<D>,
    slopes: Matrix<M>,
    first: Matrix<M>,
    off: [Each; M],
    corrected: Each,
    roundings: Each,
    /// 1 while a lane is moved, 0 where it rests, −1 where it has to go by itself.
    pub(super) going: Each,
    /// Where the first half of the step leads, and the whole one.
    middle: Row<D, M>,
    pub(super) end: Row<D, M>,
}

impl<const D: usize, const M: usize> Scratch<D, M> {
    pub(super) fn new() -> Self {
        Self {
            slide: Slide::NONE,
            leap: Leap::NONE,
            sigma: [ZEROS; M],
            guess: [ZEROS; M],
            correction: [ZEROS; M],
            kicked: Points::ZERO,
            fibre: [const { Points::ZERO }; M],
            small: Points::ZERO,
            change: Points::ZERO,
            at: Points::ZERO,
            reach: Points::ZERO,
            value: [ZEROS; M],
            size: [ZEROS; M],
            extent: [ZEROS; M],
            gradients: [const { Points::ZERO }; M],
            energy: Points::ZERO,
            slopes: [[ZEROS; M]; M],
            first: [[ZEROS; M]; M],
            off: [ZEROS; M],
            corrected: ZEROS,
            roundings: ZEROS,
            going: ZEROS,
            middle: Row::new(),
            end: Row::new(),
        }
    }
}

/// Finds where a step of h leads all lanes, with these weights of what guesses were off by before. Says whether it may
/// be taken as it is; if not, `going` tells which lanes have to go by themselves.
#[inline(always)]
pub(super) fn step<const D: usize, const M: usize>(
    row: &Row<D, M>,
    laws: &impl Laws<D, M>,
    h: f64,
    weights: [f64; 2],
    scratch: &mut Scratch<D, M>,
) -> bool {
    scratch.going = [Fused(GOES); ROW];
    guess(row, laws, h, scratch);
    drift(row, laws, h, scratch);
    trust(row, h, weights, scratch);
    let Scratch { change, middle, end, off, .. } = scratch;
    arrive(row, change, middle);
    note(row, off, end);
    settle(laws, scratch);
    let Scratch { slide, slopes, going, middle, end, .. } = scratch;
    arrive(middle, &slide.change, end);
    end.slopes = *slopes;
    turns(&row.slopes, end, going)
}

/// σ such that the hidden constraint stays, and the directions of fibres at the start.
#[inline(always)]
fn guess<const D: usize, const M: usize>(
    row: &Row<D, M>,
    laws: &impl Laws<D, M>,
    h: f64,
    scratch: &mut Scratch<D, M>,
) {
    let Scratch { slide, sigma, guess, gradients, energy, going, .. } = scratch;
    evaluate(laws, &row.high, gradients, energy);
    directions(gradients, &mut slide.directions[0]);
    slide.begin();
    let share = Fused(-0.5 * h);
    for l in 0..ROW {
        let rates = rates(laws, l, &row.high, gradients, energy);
        let lambda = solve(matrix(&row.slopes, l), rates);
        let mut finite = Fused(0.0);
        for m in 0..M {
            let found = share * lambda[m];
            (guess[m][l], sigma[m][l]) = (found, found);
            finite = Fused(0.0).multiply_add(found, finite);
        }
        going[l] = Real::select(finite.le(Fused(0.0)), going[l], Fused(BY_ITSELF));
    }
}

/// From the start to g = 0.
#[inline(always)]
fn drift<const D: usize, const M: usize>(
    row: &Row<D, M>,
    laws: &impl Laws<D, M>,
    h: f64,
    scratch: &mut Scratch<D, M>,
) {
    let Scratch { slide, leap, sigma, correction, kicked, fibre, small, change, .. } = scratch;
    let Scratch { at: place, reach, value, size, extent, gradients, slopes, .. } = scratch;
    let Scratch { first, off, corrected, roundings, going, .. } = scratch;
    (*corrected, *roundings) = (ZEROS, [Fused(f64::INFINITY); ROW]);
    for number in 0..MOST_LOOKS {
        slide.slide(laws, &row.high, sigma, going);
        displace(row, &slide.change, kicked);
        leap.leap(laws, h, kicked, going);
        add(&slide.change, &leap.change, change);
        displace(row, change, place);
        reaches(&row.high, change, reach);
        level(laws, place, reach, value, size, extent, gradients);
        if number == 0 {
            shares(value, extent, off);
        }
        if !decide(number, value, size, extent, roundings, going) {
            break;
        }
        fibres(laws, kicked, fibre);
        for j in 0..M {
            leap.tangent(laws, h, kicked, &fibre[j], small, going);
            slope(gradients, small, j, going, slopes);
        }
        if number == 0 {
            *first = *slopes;
        }
        correct(value, slopes, correction, going, sigma, corrected);
    }
}

/// From there to {g, H} = 0; with N at the end.
#[inline(always)]
fn settle<const D: usize, const M: usize>(laws: &impl Laws<D, M>, scratch: &mut Scratch<D, M>) {
    let Scratch { slide, sigma, correction, at: place, reach, value, size, extent, .. } = scratch;
    let Scratch { gradients, energy, slopes, corrected, roundings, going, middle, .. } = scratch;
    for l in 0..ROW {
        going[l] = Real::select(going[l].lt(Fused(0.0)), going[l], Fused(GOES));
    }
    (*sigma, *roundings) = ([ZEROS; M], [Fused(f64::INFINITY); ROW]);
    for number in 0..MOST_LOOKS {
        if number == 0 {
            slide.change = Points::ZERO;
        } else {
            slide.slide(laws, &middle.high, sigma, going);
        }
        displace(middle, &slide.change, place);
        reaches(&middle.high, &slide.change, reach);
        evaluate(laws, place, gradients, energy);
        if number == 0 {
            directions(gradients, &mut slide.directions[0]);
            slide.begin();
        }
        hidden(laws, place, gradients, energy, reach, slopes, value, [size, extent]);
        if !decide(number, value, size, extent, roundings, going) {
            break;
        }
        correct(value, slopes, correction, going, sigma, corrected);
    }
    if const { M > 1 } {
        commute(gradients, going);
    }
}

/// Has lanes go by themselves where equations do not commute, so that the slide has led off g = 0; or where the terms
/// of a bracket are nothing.
#[inline(always)]
fn commute<const D: usize, const M: usize>(gradients: &[Points<D>; M], going: &mut Each) {
    for second in 1..M {
        for first in 0..second {
            for l in 0..ROW {
                let [a_q, b_q] = [first, second].map(|m| at(&gradients[m].q, l));
                let [a_p, b_p] = [first, second].map(|m| at(&gradients[m].p, l));
                let bracket = dot(&a_q, &b_p) - dot(&a_p, &b_q);
                let [sizes_q, sizes_p] = [[a_q, b_p], [a_p, b_q]].map(|of| of.map(|x| x.map(|x| x.abs())));
                let size = dot(&sizes_q[0], &sizes_q[1]) + dot(&sizes_p[0], &sizes_p[1]);
                let vanishes = bracket.abs().le(Fused(START_TOLERANCE) * size);
                going[l] = Real::select(vanishes, going[l], Fused(BY_ITSELF));
            }
        }
    }
}

/// The same at a point.
#[inline(always)]
fn fibres<const D: usize, const M: usize>(
    laws: &impl Laws<D, M>,
    place: &Points<D>,
    to: &mut [Points<D>; M],
) {
    for l in 0..ROW {
        let (by_q, by_p) = laws.constraint(l).jacobians(&at(&place.q, l), &at(&place.p, l));
        for m in 0..M {
            put(&mut to[m].q, l, by_p[m].map(|x| -x));
            put(&mut to[m].p, l, by_q[m]);
        }
    }
}

/// The point after a change.
#[inline(always)]
fn displace<const D: usize, const M: usize>(row: &Row<D, M>, change: &Points<D>, to: &mut Points<D>) {
    let Row { high, low, .. } = row;
    for d in 0..D {
        for l in 0..ROW {
            to.q[d][l] = high.q[d][l] + (low.q[d][l] + change.q[d][l]);
            to.p[d][l] = high.p[d][l] + (low.p[d][l] + change.p[d][l]);
        }
    }
}

#[inline(always)]
fn add<const D: usize>(one: &Points<D>, other: &Points<D>, to: &mut Points<D>) {
    for d in 0..D {
        for l in 0..ROW {
            to.q[d][l] = one.q[d][l] + other.q[d][l];
            to.p[d][l] = one.p[d][l] + other.p[d][l];
        }
    }
}

/// The sizes of coordinates of a point and a change of it, whichever are larger.
#[inline(always)]
fn reaches<const D: usize>(start: &Points<D>, change: &Points<D>, to: &mut Points<D>) {
    for d in 0..D {
        for l in 0..ROW {
            to.q[d][l] = start.q[d][l].abs().max(change.q[d][l].abs());
            to.p[d][l] = start.p[d][l].abs().max(change.p[d][l].abs());
        }
    }
}

/// g, its gradients, and the sizes of what it is made of.
#[inline(always)]
fn level<const D: usize, const M: usize>(
    laws: &impl Laws<D, M>,
    place: &Points<D>,
    reach: &Points<D>,
    value: &mut [Each; M],
    size: &mut [Each; M],
    extent: &mut [Each; M],
    gradients: &mut [Points<D>; M],
) {
    for l in 0..ROW {
        let constraint = laws.constraint(l);
        let (g, by_q, by_p) = constraint.value_and_jacobians(&at(&place.q, l), &at(&place.p, l));
        for m in 0..M {
            value[m][l] = g[m];
            put(&mut gradients[m].q, l, by_q[m]);
            put(&mut gradients[m].p, l, by_p[m]);
        }
    }
    for l in 0..ROW {
        let (q, p) = (at(&reach.q, l), at(&reach.p, l));
        let (most_q, most_p) = ([largest(&q); D], [largest(&p); D]);
        for m in 0..M {
            let by_q = at(&gradients[m].q, l).map(|x| x.abs());
            let by_p = at(&gradients[m].p, l).map(|x| x.abs());
            size[m][l] = dot(&by_q, &q) + dot(&by_p, &p);
            extent[m][l] = dot(&by_q, &most_q) + dot(&by_p, &most_p);
        }
    }
}

/// g as a part of what it is made of.
#[inline(always)]
fn shares<const M: usize>(value: &[Each; M], extent: &[Each; M], to: &mut [Each; M]) {
    let zero = Fused(0.0);
    for m in 0..M {
        for l in 0..ROW {
            let share = value[m][l] / extent[m][l];
            to[m][l] = Real::select(value[m][l] == zero, zero, share);
        }
    }
}

/// Which lanes rest now, and which go by themselves. Returns whether one is still going.
#[inline(always)]
fn decide<const M: usize>(
    number: usize,
    value: &[Each; M],
    size: &[Each; M],
    extent: &[Each; M],
    last: &mut Each,
    going: &mut Each,
) -> bool {
    let [zero, one, goes, rests, by_itself] = [0.0, 1.0, GOES, RESTS, BY_ITSELF].map(Fused);
    let noise = Fused(NOISE);
    let mut any = false;
    for l in 0..ROW {
        let roundings = worst(value, size, l);
        let is_noise = roundings.le(noise) | worst(value, extent, l).le(one);
        let rested = roundings.le(one) | (last[l].le(roundings) & is_noise);
        let lost = (number + 1 == MOST_LOOKS) | !roundings.le(Fused(f64::MAX));
        let now = Real::select(rested, rests, Real::select(lost, by_itself, goes));
        going[l] = Real::select(zero.lt(going[l]), now, going[l]);
        last[l] = roundings;
        any |= zero.lt(going[l]);
    }
    any
}

/// Column j of ∂g/∂σ, from where a small change along a fibre leads.
#[inline(always)]
fn slope<const D: usize, const M: usize>(
    gradients: &[Points<D>; M],
    small: &Points<D>,
    j: usize,
    going: &Each,
    slopes: &mut Matrix<M>,
) {
    for i in 0..M {
        for l in 0..ROW {
            let [q, p] = [&gradients[i].q, &gradients[i].p].map(|x| at(x, l));
            let slope = dot(&q, &at(&small.q, l)) + dot(&p, &at(&small.p, l));
            slopes[i][j][l] = Real::select(Fused(0.0).lt(going[l]), slope, slopes[i][j][l]);
        }
    }
}

/// Corrects σ where lanes are going.
#[inline(always)]
fn correct<const M: usize>(
    value: &[Each; M],
    slopes: &Matrix<M>,
    correction: &mut [Each; M],
    going: &mut Each,
    sigma: &mut [Each; M],
    corrected: &mut Each,
) {
    for l in 0..ROW {
        let by = solve(matrix(slopes, l), at(value, l));
        put(correction, l, by);
    }
    for l in 0..ROW {
        let (goes, mut finite) = (Fused(0.0).lt(going[l]), Fused(0.0));
        for m in 0..M {
            let by = correction[m][l];
            sigma[m][l] = Real::select(goes, sigma[m][l] - by, sigma[m][l]);
            finite = Fused(0.0).multiply_add(by, finite);
        }
        corrected[l] = Real::select(goes, Fused(GOES), corrected[l]);
        let lost = goes & !finite.le(Fused(0.0));
        going[l] = Real::select(lost, Fused(BY_ITSELF), going[l]);
    }
}

/// Has lanes go by themselves where something speaks against the landing.
#[inline(always)]
fn trust<const D: usize, const M: usize>(
    row: &Row<D, M>,
    h: f64,
    weights: [f64; 2],
    scratch: &mut Scratch<D, M>,
) {
    let Scratch { sigma, guess, change, reach, gradients, slopes, first, off, corrected, going, .. } =
        scratch;
    let [far, short, steady, tilt, straight, rounding] =
        [FAR_GUESS, SHORT_PATH, STEADY, TILT, straight::<f64>(), ROUNDINGS * f64::EPSILON].map(Fused);
    let h = Fused(h);
    for l in 0..ROW {
        let reach = [at(&reach.q, l), at(&reach.p, l)];
        let path = over(&[at(&change.q, l), at(&change.p, l)], &reach);
        let (mut q, mut p) = ([Fused(0.0); D], [Fused(0.0); D]);
        for m in 0..M {
            let by = sigma[m][l] - guess[m][l];
            for d in 0..D {
                q[d] = (-by).multiply_add(gradients[m].p[d][l], q[d]);
                p[d] = by.multiply_add(gradients[m].q[d][l], p[d]);
            }
        }
        let slid = over(&[q, p], &reach);
        let (mut near, mut usual) = (true, true);
        for m in 0..M {
            let (off, aims) = (off[m][l], [row.aims[0][m][l], row.aims[1][m][l]]);
            near &= off.abs().le(far * path);
            let aim = Aim { last: aims[0], before: aims[1] };
            usual &= off.abs().le(rounding) | aim.is_usual(off, weights);
        }
        let last = matrix(slopes, l);
        let changes = turn(matrix(first, l), &last);
        let before = matrix(&row.slopes, l).map(|row| row.map(|x| h * x));
        let is_short = changes.le(steady) & (changes * path).le(short * slid);
        let plain = turn(before, &last).le(tilt) & (changes.le(straight) | (near & is_short));
        let is_certain = usual & (plain | (corrected[l] == Fused(0.0)));
        going[l] = Real::select(is_certain, going[l], Fused(BY_ITSELF));
    }
}

/// Has lanes go by themselves where N has changed too much, or they are not at numbers. Returns whether none has to.
#[inline(always)]
fn turns<const D: usize, const M: usize>(before: &Matrix<M>, end: &Row<D, M>, going: &mut Each) -> bool {
    let mut all = true;
    for l in 0..ROW {
        let mut finite = Fused(0.0);
        for d in 0..D {
            finite = Fused(0.0).multiply_add(end.high.q[d][l] + end.high.p[d][l], finite);
        }
        let [before, after] = [before, &end.slopes].map(|slopes| matrix(slopes, l));
        let [there, back] = [turn(before, &after), turn(after, &before)];
        let turn = Fused(TURN);
        let plain = there.le(turn) & back.le(turn) & finite.le(Fused(0.0));
        going[l] = Real::select(plain, going[l], Fused(BY_ITSELF));
        all &= Fused(0.0).le(going[l]);
    }
    all
}

/// The point after a change, with what rounding took from it.
#[inline(always)]
fn arrive<const D: usize, const M: usize>(from: &Row<D, M>, change: &Points<D>, to: &mut Row<D, M>) {
    let Row { high, low, .. } = to;
    for d in 0..D {
        for l in 0..ROW {
            let change_q = from.low.q[d][l] + change.q[d][l];
            let change_p = from.low.p[d][l] + change.p[d][l];
            let (sums, rests) = two_sum(&[from.high.q[d][l], from.high.p[d][l]], &[change_q, change_p]);
            [high.q[d][l], high.p[d][l]] = sums;
            [low.q[d][l], low.p[d][l]] = rests;
        }
    }
}

/// Notes what guesses were off by.
#[inline(always)]
fn note<const D: usize, const M: usize>(row: &Row<D, M>, off: &[Each; M], end: &mut Row<D, M>) {
    end.aims = [*off, row.aims[0]];
}
