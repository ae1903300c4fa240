//! Steps that disregard the constraint until their end is projected onto it, for trajectories in lanes.
//!
//! ```text
//! q̂ = q + way,   p̂ = p + change                          by the method, regardless of the constraint
//! q′ nearest to q̂ with g(q′) = 0,   p′ = p̂ + ∇g(q′) η     η such that ∇g(q′)·p′ = 0
//! ```
//!
//! **With a tolerance** a step is divided into inner steps, as many in each lane as its trajectory needs. A lane that
//! has arrived, or whose inner step is too long for the tolerance, keeps its numbers while its neighbours go on; so
//! what becomes of it depends on itself alone. A row waits for its slowest lane.
//!
//! **Whether a step can be believed** is asked of each inner one: along the curve through its two ends g must be as
//! small as along one sheet, the step must not lead far from where its momenta say, no kink may lie between them, the
//! normal must not turn over, and kinetic energy must not change by as much as a simulation would look into. A lane for
//! which one of these does not hold takes the whole step by itself, as a
//! [`Simulation`](crate::run::simulation::Simulation) does, with all that is looked at there
//! ([`crate::motion::course`]).

use crate::effect::list::Forces;
use crate::kernel::functions::ConstraintKernel;
use crate::kernel::kinks::sign_changes;
use crate::kernel::rounding::{TERMS, size_along};
use crate::methods::dop853::SMALLEST_PART;
use crate::methods::taylor::ROUNDINGS_OF_SERIES;
use crate::motion::bodies::One;
use crate::motion::course::{ASTRAY, ROUNDINGS_OF_WAYS};
use crate::motion::failure::Failure;
use crate::motion::method::Method;
use crate::number::lanes::Lane;
use crate::number::vector::{add_scaled, dot, largest, scaled, sum, two_sum};
use crate::number::vectors::{Vectors, at, put};
use crate::run::ensemble::around::may_go;
use crate::run::ensemble::inside::follows;
use crate::run::ensemble::laws::Laws;
use crate::run::ensemble::pace::{MOST_NEWTON_STEPS, MOST_PASSES};
use crate::run::ensemble::projected_row::{Place, Row, Scratch};
use crate::run::ensemble::row::{BY_ITSELF, pull};
use crate::solve::aim::{BOLD, ROUNDINGS};
use crate::solve::stop::NOISE;
use crate::systems::surface::kept::{BodiesOf, OnSurface, OneByOne};
use std::borrow::Borrow;

/// In single precision no tolerance is smaller than so many roundings of places: each inner step leaves one.
const LEAST_ROUNDINGS: f64 = 4.0;

/// What a tolerance counts as at least, at this place; 0 in double precision.
#[inline(always)]
pub(super) fn least_tolerance<S: Lane, const D: usize>(q: &[S; D]) -> S {
    if const { S::EPSILON > f64::EPSILON } {
        S::from_f64(LEAST_ROUNDINGS * S::EPSILON) * largest(q)
    } else {
        S::default()
    }
}

/// A method whose steps are projected, for L lanes: what its inner steps change, regardless of the constraint.
pub(super) trait Projects<S: Lane, const L: usize, const D: usize>:
    Clone + Send + Sync + 'static
{
    /// The method itself.
    type Method: Method;
    /// Room for an inner step.
    type Room;

    /// The method, as simulations have it.
    fn method(&self) -> &Self::Method;
    /// Room for an inner step.
    fn room(&self) -> Self::Room;
    /// How often an inner step evaluates forces.
    fn evaluations(&self) -> u32;
    /// Has lane `to` obey what lane `from` does, where the method keeps what lanes obey.
    fn obey(&mut self, _from: usize, _to: usize) {}

    /// Writes what inner steps of all lanes from `now` on change places and momenta by. The lengths that they are to
    /// have are `inner`, or `left` where that is shorter; those that they have are written there, and to `next` those
    /// of the inner steps to come. Says in which lanes the change is within the tolerance: others try again.
    #[allow(clippy::too_many_arguments, reason = "slices that are arguments do not overlap")]
    fn sum<const SUMS: usize>(
        &self,
        laws: &impl Laws<S, D>,
        now: &Place<S, L, D>,
        left: &[S; L],
        inner: &mut [S; L],
        next: &mut [S; L],
        taken: &mut [bool; L],
        way_and_change: [&mut Vectors<S, L, D>; 2],
        room: &mut Self::Room,
    );

    /// Accelerations at the ends of inner steps, if the method tells from them whether these are in the branch of a
    /// potential where they began; and by how much they may be off the right ones, and how far that may lead.
    fn bends<'a>(&self, _room: &'a Self::Room) -> Option<(&'a Vectors<S, L, D>, &'a [S; L], f64)> {
        None
    }

    /// Takes a body that obeys what a lane does through a step in so many parts.
    ///
    /// # Errors
    /// Those of the method.
    fn by_itself<K: ConstraintKernel<S, D, 1>, F: Forces<S, D>>(
        &self,
        system: &OnSurface<K, F, One, OneByOne>,
        parts: u32,
        bodies: &mut BodiesOf<One, S, F, D>,
    ) -> Result<(), Failure>;
}

/// Finds where one step leads all lanes: `scratch.now`. Says whether it may be taken as it is; if not, `going` tells
/// which lanes have to go by themselves, or have to look around first.
#[inline(always)]
pub(super) fn advance<S, M, const L: usize, const D: usize, const SUMS: usize>(
    row: &Row<S, L, D>,
    laws: &impl Laws<S, D>,
    method: &M,
    h: S,
    scratch: &mut Scratch<S, M::Room, L, D>,
) -> bool
where
    S: Lane,
    M: Projects<S, L, D>,
{
    let Scratch { now, trial, way, change, left, left_low, inner, next, taken, .. } = scratch;
    let Scratch { strays, going, seeking, distance, rounding, room, .. } = scratch;
    *now = row.place;
    (*left, *left_low, *inner) = ([h; L], [S::default(); L], [h; L]);
    (*going, *strays) = ([S::from_f64(1.0); L], [S::default(); L]);
    for pass in 0..MOST_PASSES {
        method.sum::<SUMS>(laws, now, left, inner, next, taken, [way, change], room);
        depart::<S, L, D, SUMS>(now, [way, change], inner, trial, rounding);
        look_ahead(laws, [&now.q, &trial.q], going, taken);
        seek(going, taken, seeking, distance);
        for _ in 0..MOST_NEWTON_STEPS {
            if !approach::<S, L, D, SUMS>(laws, rounding, trial, seeking, distance) {
                break;
            }
        }
        settle::<S, L, D, SUMS>(laws, trial);
        look(laws, inner, [now, trial], seeking, strays, going, taken);
        if let Some(tolerance) = method.method().tolerance() {
            weigh(h, S::from_f64(tolerance), [way, change], [now, trial], going, taken);
        }
        if let Some((bends, left_out, tolerance)) = method.bends(room) {
            compare(h, inner, (bends, left_out), S::from_f64(tolerance), [now, trial], going, taken);
        }
        if !take::<S, L, D, SUMS>(
            pass,
            h,
            inner,
            next,
            taken,
            [&mut *left, &mut *left_low],
            going,
            now,
            trial,
        ) {
            break;
        }
    }
    may_go(&row.asked, strays, going)
}

/// Where inner steps lead, as sums; and what rounding takes from places there.
#[inline(always)]
fn depart<S: Lane, const L: usize, const D: usize, const SUMS: usize>(
    now: &Place<S, L, D>,
    [way, change]: [&Vectors<S, L, D>; 2],
    inner: &[S; L],
    trial: &mut Place<S, L, D>,
    rounding: &mut [S; L],
) {
    let Place { q, p, q_low, p_low, .. } = trial;
    let unit = S::from_f64(S::EPSILON);
    for l in 0..L {
        let (mut by, mut pushed) = (at(way, l), at(change, l));
        if const { SUMS > 0 } {
            (by, pushed) = (sum(&at(&now.q_low, l), &by), sum(&at(&now.p_low, l), &pushed));
        }
        let (place, place_low) = two_sum(&at(&now.q, l), &by);
        let (momentum, momentum_low) = two_sum(&at(&now.p, l), &pushed);
        put(q, l, place);
        put(p, l, momentum);
        if const { SUMS > 0 } {
            put(q_low, l, place_low);
            put(p_low, l, momentum_low);
        }
        rounding[l] = unit * largest(&place).max(largest(&scaled(inner[l], &momentum)));
    }
}

/// Whether a kink may lie between places of each lane; nothing at all where there are none.
#[inline(always)]
pub(super) fn look_for_kinks<S: Lane, X: Laws<S, D>, const L: usize, const D: usize>(
    laws: &X,
    [from, to]: [&Vectors<S, L, D>; 2],
    found: &mut [bool; L],
) {
    if const { !X::Constraint::KINKS.is_empty() } {
        for l in 0..L {
            found[l] |= sign_changes(laws.constraint(l).borrow(), &[at(from, l)], &[at(to, l)]);
        }
    }
}

/// Has lanes go by themselves for which a kink may lie before where their inner step led, regardless of the constraint:
/// from there Newton's iteration may end [on the edge itself](crate::motion::course::land).
#[inline(always)]
fn look_ahead<S: Lane, X: Laws<S, D>, const L: usize, const D: usize>(
    laws: &X,
    [from, to]: [&Vectors<S, L, D>; 2],
    going: &mut [S; L],
    taken: &[bool; L],
) {
    if const { !X::Constraint::KINKS.is_empty() } {
        let mut ahead = [false; L];
        look_for_kinks(laws, [from, to], &mut ahead);
        for l in 0..L {
            let moves = S::default().lt(going[l]) & taken[l];
            going[l] = S::select(moves & ahead[l], S::from_f64(BY_ITSELF), going[l]);
        }
    }
}

/// Has those lanes seek the constraint whose inner step is taken.
#[inline(always)]
fn seek<S: Lane, const L: usize>(
    going: &[S; L],
    taken: &[bool; L],
    seeking: &mut [S; L],
    distance: &mut [S; L],
) {
    let [zero, one, far] = [0.0, 1.0, f64::INFINITY].map(S::from_f64);
    for l in 0..L {
        seeking[l] = S::select(zero.lt(going[l]) & taken[l], one, zero);
        distance[l] = far;
    }
}

/// A Newton step towards the constraint, as [`Nearing`](crate::solve::nearing::Nearing) judges it. Returns whether a
/// lane is still seeking.
#[inline(always)]
fn approach<S: Lane, const L: usize, const D: usize, const SUMS: usize>(
    laws: &impl Laws<S, D>,
    rounding: &[S; L],
    trial: &mut Place<S, L, D>,
    seeking: &mut [S; L],
    distance: &mut [S; L],
) -> bool {
    let Place { q, q_low, normal, .. } = trial;
    let [zero, one, by_itself, noise, unit, terms] =
        [0.0, 1.0, BY_ITSELF, NOISE, S::EPSILON, TERMS].map(S::from_f64);
    let mut any = false;
    for l in 0..L {
        let place = at(q, l);
        let ([g], [gradient]) = laws.constraint(l).borrow().value_and_jacobian(&place);
        let off = scaled(-g * (one / dot(&gradient, &gradient)), &gradient);
        let (length, last) = (dot(&off, &off).sqrt(), distance[l]);
        let near = length.le(noise * rounding[l]);
        let mut along = zero;
        for d in 0..D {
            along = along + (gradient[d] * place[d]).abs();
        }
        let there = g.abs().le(unit * terms.multiply_add(along, rounding[l] * largest(&gradient)));
        let arrived = (there & length.le(rounding[l])) | (near & last.le(length + length));
        let nearer = near | length.lt(last);
        let seeks = zero.lt(seeking[l]);
        let moves = seeks & !arrived & nearer;
        let by = if const { SUMS > 0 } { sum(&at(q_low, l), &off) } else { off };
        let (there, low) = two_sum(&place, &by);
        for d in 0..D {
            q[d][l] = S::select(moves, there[d], place[d]);
            normal[d][l] = S::select(seeks, gradient[d], normal[d][l]);
        }
        if const { SUMS > 0 } {
            for d in 0..D {
                q_low[d][l] = S::select(moves, low[d], q_low[d][l]);
            }
        }
        distance[l] = length;
        let goes_on = S::select(arrived, zero, S::select(nearer, one, by_itself));
        seeking[l] = S::select(seeks, goes_on, seeking[l]);
        any |= zero.lt(seeking[l]);
    }
    any
}

/// Momenta along the constraint, and accelerations there.
#[inline(always)]
fn settle<S: Lane, const L: usize, const D: usize, const SUMS: usize>(
    laws: &impl Laws<S, D>,
    trial: &mut Place<S, L, D>,
) {
    let Place { q, p, p_low, normal, pull: pulls, .. } = trial;
    for l in 0..L {
        let (place, momentum, gradient) = (at(q, l), at(p, l), at(normal, l));
        let eta = -dot(&gradient, &momentum) / dot(&gradient, &gradient);
        let mut back = scaled(eta, &gradient);
        if const { SUMS > 0 } {
            back = sum(&at(p_low, l), &back);
        }
        let (momentum, low) = two_sum(&momentum, &back);
        put(p, l, momentum);
        if const { SUMS > 0 } {
            put(p_low, l, low);
        }
        put(pulls, l, pull(laws, l, &place, &momentum, &gradient).1);
    }
}

/// Has lanes go by themselves whose inner step cannot be believed.
#[inline(always)]
fn look<S: Lane, X: Laws<S, D>, const L: usize, const D: usize>(
    laws: &X,
    inner: &[S; L],
    [now, trial]: [&Place<S, L, D>; 2],
    seeking: &[S; L],
    strays: &mut [S; L],
    going: &mut [S; L],
    taken: &[bool; L],
) {
    let [zero, half, bold, most] = [0.0, 0.5, BOLD, f64::MAX].map(S::from_f64);
    let rounding = S::from_f64(ROUNDINGS * S::EPSILON);
    for l in 0..L {
        let from = [&now.q, &now.p, &now.pull].map(|x| at(x, l));
        let [q, p, normal, pull] = trial.vectors().map(|x| at(x, l));
        let way = add_scaled(&q, S::from_f64(-1.0), &from[0]);
        let size = largest(&from[0]).max(largest(&q));
        let path = scaled(half * inner[l], &sum(&from[1], &p));
        let off = add_scaled(&way, S::from_f64(-1.0), &path);
        let mut places = q;
        for d in 0..D {
            places[d] = q[d].abs().max(from[0][d].abs());
        }
        let along = size_along(&normal, dot(&normal, &normal).sqrt(), &places);
        let (strayed, plain) = follows(laws, l, inner[l], from, [way, p, normal, pull], along);
        let short = dot(&off, &off).le(bold * bold * dot(&path, &path)) | strayed.le(rounding * size);
        let upright = zero.lt(dot(&at(&now.normal, l), &normal));
        let numbers = (dot(&p, &p) + dot(&pull, &pull)).le(most);
        let arrived = zero.le(seeking[l]) & !zero.lt(seeking[l]);
        let moves = zero.lt(going[l]) & taken[l];
        let mut believed = plain & short & upright & numbers & arrived;
        if const { !X::Constraint::KINKS.is_empty() } {
            believed &= !sign_changes(laws.constraint(l).borrow(), &[from[0]], &[q]);
        }
        strays[l] = S::select(moves & strays[l].lt(strayed), strayed, strays[l]);
        going[l] = S::select(moves & !believed, S::from_f64(BY_ITSELF), going[l]);
    }
}

/// Has lanes go by themselves that were [moved](crate::motion::course::moved) onto the constraint too far for the
/// tolerance.
#[inline(always)]
fn weigh<S: Lane, const L: usize, const D: usize>(
    h: S,
    tolerance: S,
    [way, change]: [&Vectors<S, L, D>; 2],
    [now, trial]: [&Place<S, L, D>; 2],
    going: &mut [S; L],
    taken: &[bool; L],
) {
    let [zero, minus, astray, roundings] =
        [0.0, -1.0, ASTRAY, ROUNDINGS_OF_WAYS * S::EPSILON].map(S::from_f64);
    for l in 0..L {
        let (q, p) = (at(&trial.q, l), at(&trial.p, l));
        let off = add_scaled(&q, minus, &sum(&at(&now.q, l), &at(way, l)));
        let turned = add_scaled(&p, minus, &sum(&at(&now.p, l), &at(change, l)));
        let moved = dot(&off, &off).sqrt() + h.abs() * dot(&turned, &turned).sqrt();
        let size = largest(&q) + h.abs() * largest(&p);
        let within = moved.le(astray * tolerance.max(least_tolerance(&q)) + roundings * size);
        let moves = zero.lt(going[l]) & taken[l];
        going[l] = S::select(moves & !within, S::from_f64(BY_ITSELF), going[l]);
    }
}

/// Has lanes go by themselves whose inner step ends in another branch of a potential.
#[inline(always)]
fn compare<S: Lane, const L: usize, const D: usize>(
    h: S,
    inner: &[S; L],
    (bends, left_out): (&Vectors<S, L, D>, &[S; L]),
    tolerance: S,
    [now, trial]: [&Place<S, L, D>; 2],
    going: &mut [S; L],
    taken: &[bool; L],
) {
    let [zero, minus, roundings] = [0.0, -1.0, ROUNDINGS_OF_SERIES * S::EPSILON].map(S::from_f64);
    for l in 0..L {
        let [from, to, pull, bend] = [&now.q, &trial.q, &trial.pull, bends].map(|x| at(x, l));
        let off = largest(&add_scaled(&pull, minus, &bend)) - left_out[l];
        let size = largest(&from).max(largest(&to)) + largest(&pull) * inner[l] * inner[l];
        // In the time of both steps; rounding is that of places in the square of the inner one.
        let within = (off * (inner[l] * h).abs()).le(tolerance + roundings * size * (h / inner[l]).abs());
        let moves = zero.lt(going[l]) & taken[l];
        going[l] = S::select(moves & !within, S::from_f64(BY_ITSELF), going[l]);
    }
}

/// Takes the inner steps that are taken. Returns whether a lane has still some way to go.
#[allow(clippy::too_many_arguments, reason = "slices that are arguments do not overlap")]
#[inline(always)]
fn take<S: Lane, const L: usize, const D: usize, const SUMS: usize>(
    pass: usize,
    h: S,
    inner: &mut [S; L],
    next: &[S; L],
    taken: &[bool; L],
    [left, left_low]: [&mut [S; L]; 2],
    going: &mut [S; L],
    now: &mut Place<S, L, D>,
    trial: &Place<S, L, D>,
) -> bool {
    let [zero, one, by_itself] = [0.0, 1.0, BY_ITSELF].map(S::from_f64);
    let (shortest, end) = (S::from_f64(SMALLEST_PART) * h.abs(), pass + 1 == MOST_PASSES);
    let mut moves = [false; L];
    let mut any = false;
    for l in 0..L {
        let goes = zero.lt(going[l]);
        moves[l] = goes & taken[l];
        let ([less], [lost]) = two_sum(&[left[l]], &[-inner[l]]);
        let rest = S::select(moves[l], less, left[l]);
        let collapsed = !taken[l] & next[l].abs().lt(shortest);
        let arrived = S::select(rest.abs().le(zero), zero, one);
        let on = S::select(collapsed | (end & zero.lt(arrived)), by_itself, arrived);
        let low = left_low[l] + S::select(moves[l], lost, zero);
        let ([rest], [low]) = two_sum(&[rest], &[S::select(zero.lt(arrived), low, zero)]);
        (left[l], left_low[l]) = (rest, low);
        inner[l] = next[l];
        going[l] = S::select(goes, on, going[l]);
        any |= zero.lt(going[l]);
    }
    let Place { q, p, q_low, p_low, normal, pull } = now;
    for (to, from) in [(q, &trial.q), (p, &trial.p), (normal, &trial.normal), (pull, &trial.pull)] {
        choose(&moves, from, to);
    }
    if const { SUMS > 0 } {
        choose(&moves, &trial.q_low, q_low);
        choose(&moves, &trial.p_low, p_low);
    }
    any
}

/// Writes the vectors of these lanes.
#[inline(always)]
fn choose<S: Lane, const L: usize, const D: usize>(
    lanes: &[bool; L],
    from: &Vectors<S, L, D>,
    to: &mut Vectors<S, L, D>,
) {
    for d in 0..D {
        for l in 0..L {
            to[d][l] = S::select(lanes[l], from[d][l], to[d][l]);
        }
    }
}
