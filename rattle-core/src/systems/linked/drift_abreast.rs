//! Where a step leads a row of components that are alike.
//!
//! Only the plain case is here, as in [`few`](crate::systems::linked::few). Newton's method goes on with one derivative
//! until a residual is below [`REST`]; the correction after that is the last. Lanes in which anything else happens are
//! left where they were, and go by themselves. A lane that rests is not changed while others are corrected, so none
//! depends on its neighbours.

use crate::kernel::rounding::size_of_terms;
use crate::number::instructions::Work;
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::number::vector::dot;
use crate::solve::aim::SMOOTH;
use crate::solve::root::FAR_GUESS;
use crate::systems::linked::abreast::{
    KeptRow, Lanes, RowUnderWay, add_up, factor_rows, places, square, square_mut,
};
use crate::systems::network::few_in_lanes::{
    Normals, by_coordinate, grid, lifted, of_few, of_size, sized, solve, sum_of,
};
use crate::systems::network::in_lanes::{Number, Numbers, ROW, Which, any, at, put, zeros};
use std::array::from_fn;

/// So many roundings of the coordinates that a link depends on are left to the last correction, which takes all but a
/// small part of them.
const REST: f64 = 1.0;

/// Corrections, after which a lane goes by itself.
const CORRECTIONS: u64 = 5;

impl RowUnderWay<'_> {
    /// Finds where a step leads.
    pub(super) fn find(&mut self, h: f64, kick: f64) {
        macro_rules! run {
            ($m:expr, $k:expr) => {
                self.set.run(Find::<$m, $k> { row: self, h: Fused(h), kick: Fused(kick) })
            };
        }
        sized!(self.sizes, run, ());
    }

    /// Takes the lanes to where it leads that are plain.
    pub(super) fn move_on(&mut self, h: f64, kick: f64) {
        macro_rules! run {
            ($m:expr, $k:expr) => {
                self.set.run(MoveOn::<$m, $k> { row: self, h: Fused(h), kick: Fused(kick) })
            };
        }
        sized!(self.sizes, run, ());
    }
}

/// What a step begins with.
#[derive(Clone, Copy)]
struct Start<'a, const M: usize, const K: usize> {
    normals: &'a Normals<'a, M, K, ROW>,
    over: &'a [Numbers<ROW>; K],
    q: &'a [Numbers<ROW>; K],
    q_low: &'a [Numbers<ROW>; K],
    /// The way without the constraints.
    free: &'a [Numbers<ROW>; K],
}

impl<const M: usize, const K: usize> Start<'_, M, K> {
    /// M⁻¹Gᵀ of a lane.
    #[inline(always)]
    fn lifted(&self, l: usize) -> [[Number; K]; M] {
        lifted(self.normals, &at(self.over, l), l)
    }

    /// Where multipliers lead.
    #[inline(always)]
    fn place(&self, l: usize, lifted: &[[Number; K]; M], x: &[Number; M]) -> [Number; K] {
        from_fn(|k| self.q[k].0[l] + (self.q_low[k].0[l] + sum_of(self.free[k].0[l], lifted, x, k)))
    }
}

struct Find<'a, 'b, const M: usize, const K: usize> {
    row: &'a mut RowUnderWay<'b>,
    h: Number,
    kick: Number,
}

impl<const M: usize, const K: usize> Work for Find<'_, '_, M, K> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { row: RowUnderWay { links, set, kept, lanes, .. }, h, kick } = self;
        let (places, set, zero) = (places::<M, K>(links), *set, zeros());
        let mut touches = [[Fused(0.0); K]; M];
        for [row, coordinate] in &links.entries {
            touches[*row][*coordinate] = Fused(1.0);
        }
        let [over, old] = [&kept.over, &kept.normals];
        let (over, old) = (of_few::<K, ROW>(over), by_coordinate(&places, old, &zero));
        let at_start = square::<M>(&kept.matrix);
        #[rustfmt::skip]
        let Lanes {
            q, q_low, p, p_low, force, velocity, push, free, sizes, trial, path, g, bends, turns, scale, matrix,
            gradients, x, off, roundings, going, plain, corrections, ..
        } = &mut **lanes;
        let (q, q_low) = (of_few::<K, ROW>(q), of_few::<K, ROW>(q_low));
        let (free, trial) = (of_size::<K, ROW>(free), of_size::<K, ROW>(trial));
        let (velocity, push, sizes) = (of_size(velocity), of_size(push), of_size(sizes));
        let begin = [q, of_few(p), of_few(p_low), of_few(force), over];
        set_out(begin, [h, kick], velocity, push, free, sizes, path);
        links.bends(set, [q, velocity], bends, turns);
        let start = Start { normals: &old, over, q, q_low, free };
        let x = of_size::<M, ROW>(x);
        leave(start, h, at_start, push, [of_few(bends), of_few(turns)], x, trial, plain);
        links.gradients(set, trial, g, gradients);
        let now = by_coordinate(&places, gradients, &zero);
        let matrix = square_mut::<M>(matrix.as_flattened_mut());
        let (scale, off, roundings) =
            (of_size::<M, ROW>(scale), of_size::<M, ROW>(off), of_size::<M, ROW>(roundings));
        measure(&now, of_few(g), [trial, sizes], path, &touches, scale, off, roundings);
        factor_rows::<false, M, K>(&now, &old, over, matrix, going);
        for l in 0..ROW {
            plain[l] &= going[l];
        }
        (*going, *corrections) = ([1; ROW], [0; ROW]);
        correct::<true, M, K>(start, matrix, [of_few(g), scale], path, x, trial, going, corrections, plain);
        for _ in 1..CORRECTIONS {
            if !any(going) {
                break;
            }
            links.gradients(set, trial, g, gradients);
            correct::<false, M, K>(
                start,
                matrix,
                [of_few(g), scale],
                path,
                x,
                trial,
                going,
                corrections,
                plain,
            );
        }
        for l in 0..ROW {
            plain[l] &= 1 - going[l];
        }
    }
}

/// Ways without the constraints. (Arguments of a function are known not to overlap, so that its loop becomes one over
/// vectors.)
#[inline(always)]
fn set_out<const K: usize>(
    [q, p, p_low, force, over]: [&[Numbers<ROW>; K]; 5],
    [h, kick]: [Number; 2],
    velocity: &mut [Numbers<ROW>; K],
    push: &mut [Numbers<ROW>; K],
    free: &mut [Numbers<ROW>; K],
    sizes: &mut [Numbers<ROW>; K],
    path: &mut Numbers<ROW>,
) {
    for l in 0..ROW {
        let (mut way, mut shove) = (Fused(0.0), Fused(0.0));
        for k in 0..K {
            let over = over[k].0[l];
            let v = over * p[k].0[l];
            let drift = h.multiply_add(v, h * (over * p_low[k].0[l]));
            let pushed = over * (h * kick * force[k].0[l]);
            (velocity[k].0[l], push[k].0[l], free[k].0[l]) = (v, pushed, drift + pushed);
            sizes[k].0[l] = q[k].0[l].abs().max(drift.abs()).max(pushed.abs());
            (way, shove) = (way.max(drift.abs()), shove.max(pushed.abs()));
        }
        path.0[l] = way + shove;
    }
}

/// The first guess, from g̈ = 0, and where it leads; plain are lanes whose normals turn by little.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "what a guess is made of, and what it gives")]
fn leave<const M: usize, const K: usize>(
    start: Start<'_, M, K>,
    h: Number,
    at_start: &[[Numbers<ROW>; M]; M],
    push: &[Numbers<ROW>; K],
    [bends, turns]: [&[Numbers<ROW>; M]; 2],
    x: &mut [Numbers<ROW>; M],
    trial: &mut [Numbers<ROW>; K],
    plain: &mut Which<ROW>,
) {
    let half_square = Fused(0.5) * h * h;
    for l in 0..ROW {
        let (normals, push) = (grid(start.normals, l), at(push, l));
        let (mut smooth, mut needed) = (true, [Fused(0.0); M]);
        for i in 0..M {
            let turn = h * h * turns[i].0[l];
            smooth &= turn.le(Fused(SMOOTH * SMOOTH) * dot(&normals[i], &normals[i]));
            needed[i] = -half_square * bends[i].0[l] - dot(&normals[i], &push);
        }
        let guess = solve(&from_fn(|i| at(&at_start[i], l)), needed);
        let place = start.place(l, &start.lifted(l), &guess);
        put(trial, l, place);
        put(x, l, guess);
        plain[l] = if smooth { 1 } else { 0 };
    }
}

/// 1 over the rounding of less than this is no number.
const LEAST: f64 = 1e-290;

/// How far the guess is off, as lengths and in roundings of the coordinates that a link depends on.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "only arguments are known not to overlap")]
fn measure<const M: usize, const K: usize>(
    normals: &Normals<M, K, ROW>,
    g: &[Numbers<ROW>; M],
    [trial, sizes]: [&[Numbers<ROW>; K]; 2],
    path: &Numbers<ROW>,
    touches: &[[Number; K]; M],
    scale: &mut [Numbers<ROW>; M],
    off: &mut [Numbers<ROW>; M],
    roundings: &mut [Numbers<ROW>; M],
) {
    for i in 0..M {
        for l in 0..ROW {
            let (mut square, mut along, mut most) = (Fused(0.0), Fused(0.0), Fused(0.0));
            for k in 0..K {
                let normal = normals[i][k].0[l];
                square = normal.multiply_add(normal, square);
                let size = sizes[k].0[l].max(trial[k].0[l].abs());
                along = normal.abs().multiply_add(size, along);
                most = most.max(touches[i][k] * size);
            }
            let (length, g) = (square.sqrt(), g[i].0[l]);
            let size = size_of_terms(along, path.0[l] * length, most * length).max(g.abs()).max(Fused(LEAST));
            let rounds = Fused(1.0) / (Fused(f64::EPSILON) * size);
            // None where coordinates are infinite.
            let rounds = Real::select(Fused(0.0).lt(rounds), rounds, Fused(f64::NAN));
            (scale[i].0[l], off[i].0[l], roundings[i].0[l]) = (rounds, g / length, g.abs() * rounds);
        }
    }
}

/// Corrects lanes that are going. The first time, plain are those that are not far from their guess.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "only arguments are known not to overlap")]
fn correct<const FIRST: bool, const M: usize, const K: usize>(
    start: Start<'_, M, K>,
    matrix: &[[Numbers<ROW>; M]; M],
    [g, scale]: [&[Numbers<ROW>; M]; 2],
    path: &Numbers<ROW>,
    x: &mut [Numbers<ROW>; M],
    trial: &mut [Numbers<ROW>; K],
    going: &mut Which<ROW>,
    corrections: &mut Which<ROW>,
    plain: &mut Which<ROW>,
) {
    for l in 0..ROW {
        let by = solve(&from_fn(|i| at(&matrix[i], l)), at(g, l));
        let (goes, mut rests, mut corrected) = (going[l] != 0, true, at(x, l));
        for i in 0..M {
            rests &= (g[i].0[l].abs() * scale[i].0[l]).le(Fused(REST));
            corrected[i] = Real::select(goes, corrected[i] - by[i], corrected[i]);
        }
        let lifted = start.lifted(l);
        let place = start.place(l, &lifted, &corrected);
        put(trial, l, place);
        put(x, l, corrected);
        corrections[l] += going[l];
        going[l] = if goes & !rests { 1 } else { 0 };
        if FIRST {
            let (mut first, mut sum) = (Fused(0.0), Fused(0.0));
            for k in 0..K {
                let way = sum_of(Fused(0.0), &lifted, &by, k).abs();
                (first, sum) = (first.max(way), sum + way); // no number if one is not
            }
            let near = first.le(Fused(FAR_GUESS) * path.0[l]) & sum.le(Fused(f64::MAX));
            plain[l] &= if near { 1 } else { 0 };
        }
    }
}

struct MoveOn<'a, 'b, const M: usize, const K: usize> {
    row: &'a mut RowUnderWay<'b>,
    h: Number,
    kick: Number,
}

impl<const M: usize, const K: usize> Work for MoveOn<'_, '_, M, K> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { row, h, kick } = self;
        let RowUnderWay { links, set, kept, lanes, .. } = row;
        let (places, zero) = (places::<M, K>(links), zeros());
        let KeptRow { over, normals, matrix } = &mut **kept;
        let (over, old) = (of_few::<K, ROW>(over), by_coordinate(&places, normals, &zero));
        let Lanes { q, q_low, p, p_low, force, free, lift, push, g, gradients, x, plain, clear, .. } =
            &mut **lanes;
        let (q, q_low) = (of_size::<K, ROW>(q), of_size(q_low));
        let (p, p_low) = (of_size::<K, ROW>(p), of_size(p_low));
        let (lift, push) = (of_size::<K, ROW>(lift), of_size::<K, ROW>(push));
        let given = [of_few(free), of_few(force), q_low, p_low];
        advance(&old, over, given, of_few(x), [h, kick], lift, push);
        add_up(plain, lift, q, q_low);
        add_up(plain, push, p, p_low);
        links.gradients(*set, q, g, gradients);
        for (old, new) in normals.iter_mut().zip(&*gradients) {
            renew(plain, new, old);
        }
        let now = by_coordinate(&places, normals, &zero);
        factor_rows::<true, M, K>(&now, &now, over, square_mut::<M>(matrix), clear);
    }
}

/// Takes new numbers over in these lanes.
#[inline(always)]
fn renew(which: &Which<ROW>, new: &Numbers<ROW>, numbers: &mut Numbers<ROW>) {
    for l in 0..ROW {
        numbers.0[l] = Real::select(which[l] != 0, new.0[l], numbers.0[l]);
    }
}

/// What places and momenta change by in the step.
#[inline(always)]
fn advance<const M: usize, const K: usize>(
    normals: &Normals<M, K, ROW>,
    over: &[Numbers<ROW>; K],
    [free, force, q_low, p_low]: [&[Numbers<ROW>; K]; 4],
    x: &[Numbers<ROW>; M],
    [h, kick]: [Number; 2],
    lift: &mut [Numbers<ROW>; K],
    change: &mut [Numbers<ROW>; K],
) {
    for l in 0..ROW {
        let (normals, lifted) = (grid(normals, l), lifted(normals, &at(over, l), l));
        let x = at(x, l);
        let impulses: [Number; M] = from_fn(|i| Fused(x[i].0 / h.0));
        for k in 0..K {
            lift[k].0[l] = q_low[k].0[l] + sum_of(free[k].0[l], &lifted, &x, k);
            let kicked = kick.multiply_add(force[k].0[l], p_low[k].0[l]);
            change[k].0[l] = sum_of(kicked, &normals, &impulses, k);
        }
    }
}
