//! Steps of a row whose links are few: what [`linked_row`](crate::run::ensemble::linked_row) does sum by sum in memory,
//! in some loops over lanes, with sizes known when they are compiled, so that numbers stay in registers between two
//! evaluations of the links.
//!
//! Only the usual cases are here: a step in which some lane may be astray, or is not at rest after [`CORRECTIONS`], is
//! left undone, and goes by the [`Course`]. Sums have the same terms in the same order as there, so that all bits are
//! the same, and no lane depends on who else is in its row.

use crate::number::instructions::Work;
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::number::vector::{dot, two_sum};
use crate::run::ensemble::block::extrapolated;
use crate::run::ensemble::forces_in_lanes::Pulling;
use crate::run::ensemble::linked_plan::Places;
use crate::run::ensemble::linked_row::{Course, LinkedRow, PIVOT, TURN};
use crate::systems::network::few_in_lanes::{
    Normals, by_coordinate, factor, grid, lifted, of_few, of_size, sized, solve, sum_of,
};
use crate::systems::network::in_lanes::{Number, Numbers, Which, any, at, put, zeros};
use std::array::from_fn;

/// Corrections by a matrix of its own each. Two are needed where stages are long.
const CORRECTIONS: usize = 2;

/// Numbers of M equations and K coordinates.
#[repr(C, align(64))]
struct Scratch<const M: usize, const K: usize, const W: usize> {
    lambda: [Numbers<W>; M],
    found: [Numbers<W>; M],
    /// L below the diagonal, U above it, and on it the inverse pivots.
    matrix: [[Numbers<W>; M]; M],
    going: Which<W>,
    /// In place of low digits where there are none; not looked at.
    none: [[Numbers<W>; K]; 2],
}

impl<const M: usize, const K: usize, const W: usize> Scratch<M, K, W> {
    fn new() -> Self {
        let [lambda, found] = [[zeros(); M]; 2];
        Self { lambda, found, matrix: [[zeros(); M]; M], going: [0; W], none: [[zeros(); K]; 2] }
    }
}

/// What a step begins with, by coordinate.
#[derive(Clone, Copy)]
struct Start<'a, const M: usize, const K: usize, const W: usize, const S: bool> {
    q: &'a [Numbers<W>; K],
    q_low: &'a [Numbers<W>; K],
    way: &'a [Numbers<W>; K],
    way_low: &'a [Numbers<W>; K],
    /// G, and M⁻¹.
    normals: &'a Normals<'a, M, K, W>,
    over: &'a [Number; K],
    /// The length of the step, in units of ways.
    share: Number,
}

impl<const M: usize, const K: usize, const W: usize, const S: bool> Start<'_, M, K, W, S> {
    /// M⁻¹Gᵀ of a lane.
    #[inline(always)]
    fn lifted(&self, l: usize) -> [[Number; K]; M] {
        lifted(self.normals, self.over, l)
    }

    /// Where multipliers lead a lane.
    #[inline(always)]
    fn place(&self, l: usize, lifted: &[[Number; K]; M], lambda: &[Number; M]) -> [Number; K] {
        from_fn(|k| {
            let (q, way) = (self.q[k].0[l], self.way[k].0[l]);
            let q = if S { q + self.share.multiply_add(self.way_low[k].0[l], self.q_low[k].0[l]) } else { q };
            sum_of(self.share.multiply_add(way, q), lifted, lambda, k)
        })
    }
}

/// Some parts of steps of a row, from one on.
struct Stretch<'a, 'b, 'c, 'd, const M: usize, const K: usize, const W: usize, const S: bool> {
    course: &'a Course<'b, W>,
    first: usize,
    count: usize,
    numbers: &'a mut [Numbers<W>],
    pulling: &'a mut Option<&'c mut (dyn Pulling<LinkedRow, W> + 'd)>,
}

impl<const W: usize> Course<'_, W> {
    /// Takes so many parts of steps, from this one on, up to the first in which a lane needs more than the plain case;
    /// returns how many. None where sizes are not compiled.
    pub(super) fn go_few<const S: bool>(
        &self,
        (first, count): (usize, usize),
        numbers: &mut [Numbers<W>],
        pulling: &mut Option<&mut (dyn Pulling<LinkedRow, W> + '_)>,
    ) -> usize {
        macro_rules! run {
            ($m:expr, $k:expr) => {
                // By itself, since code for all sizes in one function takes five times as long to compile.
                self.set.run(Stretch::<$m, $k, W, S> { course: self, first, count, numbers, pulling })
            };
        }
        self.plan.few.map_or(0, |sizes| sized!(sizes, run, 0))
    }
}

impl<const M: usize, const K: usize, const W: usize, const S: bool> Work
    for Stretch<'_, '_, '_, '_, M, K, W, S>
{
    type Done = usize;

    #[inline(always)]
    fn run(self) -> usize {
        let Self { course, first, count, numbers, pulling } = self;
        go::<M, K, W, S>(course, (first, count), numbers, pulling)
    }
}

/// See [`Course::go_few`].
#[inline(always)]
fn go<const M: usize, const K: usize, const W: usize, const S: bool>(
    course: &Course<'_, W>,
    (first, count): (usize, usize),
    numbers: &mut [Numbers<W>],
    pulling: &mut Option<&mut (dyn Pulling<LinkedRow, W> + '_)>,
) -> usize {
    let Course { plan, links, parts, set, equal, .. } = *course;
    let Places { q, q_low, way, way_low, lifted, guess, last, earlier, square, rest, .. } = plan.places;
    let Places { trial, g, gradient, .. } = plan.places;
    let (n, low, entries) = (plan.coordinates, if S { plan.coordinates } else { 0 }, plan.of_entry.len());
    let ranges = [
        (q, n),
        (q_low, low),
        (way, n),
        (way_low, low),
        (lifted, entries),
        (guess, M),
        (last, M),
        (earlier, M),
        (square, M),
        (rest, M),
        (trial, n),
        (g, M),
        (gradient, entries),
    ];
    let ranges = ranges.map(|(start, number)| start..start + number);
    let Ok(all) = numbers.get_disjoint_mut(ranges) else { return 0 }; // not reached: so they are laid out
    let [q, q_low, way, way_low, mut old, guess, last, earlier, square, rest, trial, g, mut new] = all;
    let [guess, last, earlier, square, rest, g] =
        [guess, last, earlier, square, rest, g].map(of_size::<M, W>);

    let moving = plan.moving[0]..plan.moving[0] + K;
    let over: [Number; K] = from_fn(|k| Fused(plan.masses[moving.start + k][1]));
    let mut entry = [[None; K]; M];
    for (i, entries) in plan.of_row.iter().enumerate() {
        for &[number, c] in entries.iter().filter(|[_, c]| moving.contains(c)) {
            entry[i][c - moving.start] = Some(number);
        }
    }
    let (zero, mut scratch) = (zeros(), Scratch::<M, K, W>::new());
    let Scratch { lambda, found, matrix, going, none: [none, none_of_ways] } = &mut scratch;

    // At first M⁻¹Gᵀ stands for G.
    let mut over_old = [Fused(1.0); K];
    let mut done = 0;
    while done < count {
        let part = &parts[(first + done) % parts.len()];
        let (share, over_share) = (Fused(part.h / part.unit), part.over.map(Fused));
        let normals = by_coordinate(&entry, old, &zero);
        let start = Start::<M, K, W, S> {
            q: of_few(&q[moving.clone()]),
            q_low: if S { of_few(&q_low[moving.clone()]) } else { none },
            way: of_few(&way[moving.clone()]),
            way_low: if S { of_few(&way_low[moving.clone()]) } else { none_of_ways },
            normals: &normals,
            over: &over_old,
            share,
        };
        leave(start, guess, of_size(&mut trial[moving.clone()]));
        links.gradients_at(set, trial, g, new);
        *lambda = *guess;
        *going = [1; W];
        let mut astray = false;
        for correction in 0..CORRECTIONS {
            let now = by_coordinate(&entry, new, &zero);
            let here = of_size(&mut trial[moving.clone()]);
            let clear = correct(start, &now, [g, square], going, lambda, matrix, here);
            astray |= correction == 0 && !clear;
            links.gradients_at(set, trial, g, new);
            if astray || !correct_again(matrix, [g, rest, lambda], going, found) {
                break;
            }
        }
        if astray || any(going) {
            break;
        }
        move_on::<M, K, W, S>(
            (&normals, &over_old, share, over_share),
            found,
            of_size(&mut q[moving.clone()]),
            if S { of_size(&mut q_low[moving.clone()]) } else { none },
            of_size(&mut way[moving.clone()]),
            if S { of_size(&mut way_low[moving.clone()]) } else { none_of_ways },
        );
        links.gradients_at(set, q, g, new);
        if let (true, Some(pulling)) = (part.kick != 0.0, &mut *pulling) {
            pulling.pull(set, part.unit * part.kick, (q, &plan.masses, if S { way_low } else { way }));
        }
        let now = by_coordinate(&entry, new, &zero);
        let here = of_size(&mut way[moving.clone()]);
        let low = if S { of_size(&mut way_low[moving.clone()]) } else { &mut *none };
        if !equal {
            project::<M, K, W, S>(&now, &over, here, low);
        } else if S {
            sum_up::<K, W>(here, low);
        }
        lift(&now, &over, square);
        extrapolate(equal, part.weights.map(Fused), found, guess, last, earlier);
        std::mem::swap(&mut old, &mut new);
        over_old = over;
        done += 1;
    }
    // M⁻¹Gᵀ and G, where they were.
    for (number, &[c, _]) in plan.of_entry.iter().enumerate().filter(|_| done > 0) {
        let (over, normal) = (Fused(plan.masses[c][1]), old[number]);
        let mut up = normal;
        for l in 0..W {
            up.0[l] = over * normal.0[l];
        }
        (old[number], new[number]) = if done % 2 == 0 { (up, normal) } else { (normal, up) };
    }
    done
}

/// Where the first guess leads. (Arguments of a function are known not to overlap, so that its loop becomes one over
/// vectors.)
#[inline(always)]
fn leave<const M: usize, const K: usize, const W: usize, const S: bool>(
    start: Start<'_, M, K, W, S>,
    guess: &[Numbers<W>; M],
    trial: &mut [Numbers<W>; K],
) {
    for l in 0..W {
        let place = start.place(l, &start.lifted(l), &at(guess, l));
        put(trial, l, place);
    }
}

/// Corrects these lanes by Newton's method. Returns whether the constraints have been left in none of them, nor depend
/// on each other.
#[inline(always)]
fn correct<const M: usize, const K: usize, const W: usize, const S: bool>(
    start: Start<'_, M, K, W, S>,
    normals: &Normals<M, K, W>,
    [g, square]: [&[Numbers<W>; M]; 2],
    going: &Which<W>,
    lambda: &mut [Numbers<W>; M],
    matrix: &mut [[Numbers<W>; M]; M],
    trial: &mut [Numbers<W>; K],
) -> bool {
    let mut clear = true;
    for l in 0..W {
        let lifted = start.lifted(l);
        let (factored, slopes) = factor(&grid(normals, l), &lifted);
        let x = solve(&factored, at(g, l));
        for i in 0..M {
            let (slope, inverse, square) = (slopes[i].0, factored[i][i].0, square[i].0[l].0);
            clear &= TURN * (slope - square).abs() <= square;
            clear &= (0.0 < inverse) & (inverse * slope <= PIVOT);
        }
        let corrected = from_fn(|i| Real::select(going[l] != 0, lambda[i].0[l] - x[i], lambda[i].0[l]));
        let place = start.place(l, &lifted, &corrected);
        put(trial, l, place);
        for i in 0..M {
            lambda[i].0[l] = corrected[i];
            for j in 0..M {
                matrix[i][j].0[l] = factored[i][j];
            }
        }
    }
    clear
}

/// Corrects these lanes once more by the same matrix. Those remain in which that is not enough; returns whether there
/// are any.
#[inline(always)]
fn correct_again<const M: usize, const W: usize>(
    matrix: &[[Numbers<W>; M]; M],
    [g, rest, lambda]: [&[Numbers<W>; M]; 3],
    going: &mut Which<W>,
    found: &mut [Numbers<W>; M],
) -> bool {
    for l in 0..W {
        let x = solve(&from_fn(|i| at(&matrix[i], l)), at(g, l));
        let mut unrest = 0;
        for i in 0..M {
            unrest = if g[i].0[l].0.abs() <= rest[i].0[l].0 { unrest } else { 1 };
            found[i].0[l] = Real::select(going[l] != 0, lambda[i].0[l] - x[i], found[i].0[l]);
        }
        going[l] = unrest;
    }
    any(going)
}

/// Takes bodies to the end of the step, without the kick there; where sums are compensated, what ways change by is left
/// in their low digits.
#[inline(always)]
fn move_on<const M: usize, const K: usize, const W: usize, const S: bool>(
    (normals, over, share, [over_share, over_rest]): (&Normals<M, K, W>, &[Number; K], Number, [Number; 2]),
    found: &[Numbers<W>; M],
    q: &mut [Numbers<W>; K],
    q_low: &mut [Numbers<W>; K],
    way: &mut [Numbers<W>; K],
    way_low: &mut [Numbers<W>; K],
) {
    for l in 0..W {
        let (lifted, lambda) = (lifted(normals, over, l), at(found, l));
        for k in 0..K {
            let moved = sum_of(Fused(0.0), &lifted, &lambda, k);
            if S {
                let low = way_low[k].0[l];
                let by = share.multiply_add(low, q_low[k].0[l]) + share.multiply_add(way[k].0[l], moved);
                let ([sum], [rest]) = two_sum(&[q[k].0[l]], &[by]);
                (q[k].0[l], q_low[k].0[l]) = (sum, rest);
                way_low[k].0[l] = over_share.multiply_add(moved, over_rest.multiply_add(moved, low));
            } else {
                q[k].0[l] = share.multiply_add(way[k].0[l], q[k].0[l]) + moved;
                way[k].0[l] = over_share.multiply_add(moved, way[k].0[l]);
            }
        }
    }
}

/// Makes ways lead along the constraints; where sums are compensated, with what they change by.
#[inline(always)]
fn project<const M: usize, const K: usize, const W: usize, const S: bool>(
    normals: &Normals<M, K, W>,
    over: &[Number; K],
    way: &mut [Numbers<W>; K],
    way_low: &mut [Numbers<W>; K],
) {
    for l in 0..W {
        let (normal, lifted) = (grid(normals, l), lifted(normals, over, l));
        let (matrix, _) = factor(&normal, &lifted);
        let high = at(way, l);
        let all: [Number; K] = from_fn(|k| if S { high[k] + way_low[k].0[l] } else { high[k] });
        let off = solve(&matrix, from_fn(|i| dot(&normal[i], &all)));
        for k in 0..K {
            let less = |first| (0..M).fold(first, |sum, i| (-lifted[i][k]).multiply_add(off[i], sum));
            if S {
                let ([sum], [rest]) = two_sum(&[high[k]], &[less(way_low[k].0[l])]);
                (way[k].0[l], way_low[k].0[l]) = (sum, rest);
            } else {
                way[k].0[l] = less(high[k]);
            }
        }
    }
}

/// Adds to ways what they change by.
#[inline(always)]
fn sum_up<const K: usize, const W: usize>(way: &mut [Numbers<W>; K], way_low: &mut [Numbers<W>; K]) {
    for k in 0..K {
        for l in 0..W {
            let ([sum], [rest]) = two_sum(&[way[k].0[l]], &[way_low[k].0[l]]);
            (way[k].0[l], way_low[k].0[l]) = (sum, rest);
        }
    }
}

/// Writes ∇gᵢ·M⁻¹∇gᵢ.
#[inline(always)]
fn lift<const M: usize, const K: usize, const W: usize>(
    normals: &Normals<M, K, W>,
    over: &[Number; K],
    square: &mut [Numbers<W>; M],
) {
    for i in 0..M {
        for l in 0..W {
            let normal: [Number; K] = from_fn(|k| normals[i][k].0[l]);
            square[i].0[l] = dot(&normal, &from_fn(|k| over[k] * normal[k]));
        }
    }
}

/// Makes the next guess.
#[inline(always)]
fn extrapolate<const M: usize, const W: usize>(
    equal: bool,
    weights: [Number; 3],
    found: &[Numbers<W>; M],
    guess: &mut [Numbers<W>; M],
    last: &mut [Numbers<W>; M],
    earlier: &mut [Numbers<W>; M],
) {
    for i in 0..M {
        for l in 0..W {
            let (new, before, first) = (found[i].0[l], last[i].0[l], earlier[i].0[l]);
            guess[i].0[l] = extrapolated(equal, weights, new, before, first);
            (last[i].0[l], earlier[i].0[l]) = (new, before);
        }
    }
}
