//! A row of trajectories of rigid bodies, and the loops of its steps, which know no effects: compiled once here.
//!
//! As in [blocks](crate::run::ensemble::block), momenta are kept ahead by the first kick of the step to come, times the
//! [unit](crate::run::ensemble::block::Part) of its part. The equation of [`rotation`](crate::systems::rigid::rotation)
//! is solved by two corrections with one matrix. Extrapolated from the last three steps is what u has beyond its second
//! order, the *rest*, so that guesses are good to a millionth where a body turns by a quarter of a radian. **A lane
//! that does not rest then** is corrected again, by a mask, with a matrix of its own. **A lane in trouble** (a guess
//! that is far off, a matrix that is nearly singular) is solved for as in a simulation.

use crate::motion::failure::Failure;
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::number::vector::{add_scaled, dot, scaled, sum, two_sum};
use crate::run::ensemble::block::{Part, extrapolated};
use crate::run::ensemble::engine::Stuck;
use crate::run::ensemble::forces_in_lanes::{Pulled, Pulling, Rows};
use crate::solve::crowd::EVERY;
use crate::systems::network::in_lanes::{Number, Numbers, at, lost, put, zeros};
use crate::systems::rigid::rotation::{
    Inverse, LEFT, Moments, deviation, product, share, too_fast, turn, turning,
};
use std::array::from_fn;
use std::marker::PhantomData;

/// A first correction of x of more than this is no step of Newton's method from near by.
const FAR: f64 = 1.0 / 64.0;

/// 1/det M is no larger. Where a body spins about an axis that is so at 75° in a step.
const STEEP: f64 = 4.0;

/// Times that two corrections are made again.
const AGAIN: usize = 4;

/// A vector in each of W lanes.
pub(super) type Three<const W: usize> = [Numbers<W>; 3];

/// A matrix in each of W lanes, by rows.
pub(super) type Nine<const W: usize> = [Numbers<W>; 9];

/// A rigid body in each of W lanes.
#[derive(Clone)]
pub(super) struct Rotor<const W: usize> {
    pub(super) q: Nine<W>,
    pub(super) q_low: Nine<W>,
    /// Momenta, ahead by the first kick of the step to come, times [`Part::unit`], and what rounding took from them.
    pub(super) way: Three<W>,
    pub(super) way_low: Three<W>,
    /// The rest of the step to come as extrapolated, and those of the last two, the last one first.
    pub(super) guess: Three<W>,
    pub(super) past: [Three<W>; 2],
}

impl<const W: usize> Rotor<W> {
    /// A body in no lane.
    pub(super) fn new() -> Self {
        let (three, nine) = ([zeros(); 3], [zeros(); 9]);
        Self { q: nine, q_low: nine, way: three, way_low: three, guess: three, past: [three; 2] }
    }

    /// All numbers, row by row.
    pub(super) fn rows(&mut self) -> impl Iterator<Item = &mut Numbers<W>> {
        let Self { q, q_low, way, way_low, guess, past } = self;
        let threes = [way, way_low, guess].into_iter().chain(past).flatten();
        q.iter_mut().chain(q_low).chain(threes)
    }
}

/// The moments of inertia of W lanes.
pub(super) type Inertia<const W: usize> = Moments<Numbers<W>>;

impl<const W: usize> Inertia<W> {
    /// Those of a lane.
    #[inline(always)]
    pub(super) fn lane(&self, l: usize) -> Moments<Number> {
        let Moments { over, bend: [bend, bend_low], push: [push, push_low] } = self;
        Moments {
            over: at(over, l),
            bend: [at(bend, l), at(bend_low, l)],
            push: [at(push, l), at(push_low, l)],
        }
    }

    /// Has a lane have these.
    pub(super) fn put(&mut self, l: usize, moments: &Moments<Number>) {
        let Moments { over, bend: [bend, bend_low], push: [push, push_low] } = self;
        put(over, l, moments.over);
        for (to, from) in [bend, bend_low].into_iter().zip(moments.bend) {
            put(to, l, from);
        }
        for (to, from) in [push, push_low].into_iter().zip(moments.push) {
            put(to, l, from);
        }
    }
}

/// Numbers of one step, which need no keeping.
struct Scratch<const W: usize> {
    rest: Three<W>,
    x: Three<W>,
    state: States<W>,
}

/// For each lane whether it is at [rest](RESTS), [goes](GOES) on, or goes [apart](APART); as wide as what is compared,
/// so that comparing is done side by side.
type States<const W: usize> = [u64; W];

const RESTS: u64 = 0;
const GOES: u64 = 1;
const APART: u64 = 2;

/// A rigid body in each of W lanes, which has an attitude.
pub(super) trait Attitude<const W: usize>: Send + Sync + 'static {
    fn attitude(&self) -> &Nine<W>;
}

impl<const W: usize> Attitude<W> for Rotor<W> {
    #[inline(always)]
    fn attitude(&self) -> &Nine<W> {
        &self.q
    }
}

impl<const W: usize> Attitude<W> for Nine<W> {
    #[inline(always)]
    fn attitude(&self) -> &Nine<W> {
        self
    }
}

/// Rows of rigid bodies B.
pub(super) struct RigidRow<B>(PhantomData<B>);

impl<B: Attitude<W>, const W: usize> Rows<W> for RigidRow<B> {
    /// The bodies, and where so many times the torques, in the frames of the bodies, are written.
    type Bodies<'a> = (&'a [B], &'a mut [Three<W>]);
}

/// D is 9.
impl<B: Attitude<W>, const D: usize, const W: usize> Pulled<D, W> for RigidRow<B> {
    type Times = Number;
    type To = Three<W>;

    #[inline(always)]
    fn each<'a>(
        times: f64,
        (bodies, to): &'a mut Self::Bodies<'_>,
    ) -> impl Iterator<Item = (Number, &'a [Numbers<W>; D], &'a mut Three<W>)> {
        bodies
            .iter()
            .zip(&mut **to)
            .filter_map(move |(body, to)| Some((Fused(times), body.attitude().first_chunk()?, to)))
    }

    #[inline(always)]
    fn pull<const N: usize>(
        times: Number,
        q: &[Numbers<N>; D],
        force: &[Numbers<N>; D],
        first: usize,
        to: &mut Three<W>,
    ) {
        for l in 0..N {
            let torque = turning(&from_fn(|k| q[k].0[l]), &from_fn(|k| force[k].0[l]));
            put(to, first + l, torque.map(|torque| times * torque));
        }
    }
}

/// How rests are extrapolated, for each part of a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weights {
    /// The rest of the part before in terms of its own.
    pub(super) before: f64,
    /// By which the rests of this part and the last ones are extrapolated to the next, that of this one first.
    weights: [f64; 3],
}

impl Weights {
    /// Λ is of second order in the step, a rest of third.
    pub(super) fn of(parts: &[Part]) -> Vec<Self> {
        let n = parts.len();
        let of = |i: usize| {
            let (before, Part { h, before: square, weights: [a, b, c], .. }) =
                (parts[(i + n - 1) % n].h, parts[i]);
            let next = parts[(i + 1) % n].h;
            Self { before: square * before / h, weights: [a * next / h, b * next / before, c] }
        };
        (0..n).map(of).collect()
    }
}

/// What a row obeys.
#[derive(Clone, Copy)]
pub(super) struct Course<'a, const W: usize> {
    pub(super) inertia: &'a Inertia<W>,
    pub(super) parts: &'a [Part],
    pub(super) guesses: &'a [Weights],
    /// Whether all steps are equal.
    pub(super) equal: bool,
    /// Whether sums are compensated.
    pub(super) sums: bool,
    pub(super) set: Fusing,
}

/// Some steps of a row, after so many.
pub(super) struct Steps<'a, 'b, const W: usize> {
    pub(super) course: Course<'a, W>,
    pub(super) pulling: Option<&'a mut (dyn Pulling<RigidRow<Rotor<W>>, W> + 'b)>,
    pub(super) bodies: &'a mut [Rotor<W>],
    /// Room for torques.
    pub(super) kicks: &'a mut [Three<W>],
    pub(super) part: &'a mut usize,
    pub(super) from: u64,
    pub(super) steps: u64,
}

impl<const W: usize> Work for Steps<'_, '_, W> {
    type Done = Result<(), Stuck>;

    #[inline(always)]
    fn run(self) -> Result<(), Stuck> {
        let Self { course, mut pulling, bodies, kicks, part: number, from, steps } = self;
        if steps == 0 {
            return Ok(());
        }
        let mut row = Row::new(course);
        for now in from + 1..=from + steps {
            for _ in 0..if course.equal { 1 } else { course.parts.len() } {
                row.advance(*number, now, bodies, kicks, &mut pulling)?;
                *number = if *number + 1 == course.parts.len() { 0 } else { *number + 1 };
            }
        }
        finite(bodies)
    }
}

/// An error for the first lane in which a momentum is no number.
#[inline(always)]
pub(super) fn finite<const W: usize>(bodies: &[Rotor<W>]) -> Result<(), Stuck> {
    let ways = bodies.iter().flat_map(|rotor| &rotor.way);
    lost(ways).map_or(Ok(()), |lane| Err(Stuck { lane, failure: None }))
}

/// What a row obeys, and working memory.
pub(super) struct Row<'a, const W: usize> {
    course: Course<'a, W>,
    /// Those of the course, out of reach of what the loops write.
    inertia: Inertia<W>,
    scratch: Scratch<W>,
}

impl<'a, const W: usize> Row<'a, W> {
    #[inline(always)]
    pub(super) fn new(course: Course<'a, W>) -> Self {
        let scratch = Scratch { rest: [zeros(); 3], x: [zeros(); 3], state: [RESTS; W] };
        Self { course, inertia: *course.inertia, scratch }
    }

    /// Moves bodies by this part of step number `now`, counted from 1.
    #[inline(always)]
    pub(super) fn advance<'b>(
        &mut self,
        number: usize,
        now: u64,
        bodies: &mut [Rotor<W>],
        kicks: &mut [Three<W>],
        pulling: &mut Option<&mut (dyn Pulling<RigidRow<Rotor<W>>, W> + 'b)>,
    ) -> Result<(), Stuck> {
        let Self { course: Course { parts, guesses, equal, sums, set, .. }, inertia, scratch } = self;
        let part = &parts[number];
        for (body, rotor) in bodies.iter_mut().enumerate() {
            rotate(inertia, part, body, rotor, scratch)?;
            advance(inertia, part, *equal, *sums, rotor, &guesses[number], scratch);
        }
        if now.is_multiple_of(EVERY) && number + 1 == parts.len() {
            bodies.iter_mut().for_each(|rotor| straighten(*sums, &mut rotor.q, &mut rotor.q_low));
        }
        if part.kick != 0.0
            && let Some(pulling) = pulling
        {
            pulling.pull(*set, part.unit * part.kick, (bodies, kicks));
            for (rotor, kick) in bodies.iter_mut().zip(&*kicks) {
                push(*sums, kick, &mut rotor.way, &mut rotor.way_low);
            }
        } else if *sums {
            bodies.iter_mut().for_each(|rotor| settle(&mut rotor.way, &mut rotor.way_low));
        }
        Ok(())
    }
}

/// Finds the rotations of a part of a step.
#[inline(always)]
fn rotate<const W: usize>(
    inertia: &Inertia<W>,
    part: &Part,
    body: usize,
    rotor: &Rotor<W>,
    scratch: &mut Scratch<W>,
) -> Result<(), Stuck> {
    let (share, Scratch { rest, x, state }) = (Fused(part.h / part.unit), scratch);
    solve(inertia, share, &rotor.way, &rotor.guess, rest, x, state);
    if state.iter().fold(0, |any, which| any | which) == RESTS {
        return Ok(());
    }
    for _ in 0..AGAIN {
        if !state.contains(&GOES) {
            break;
        }
        let (mut next_rest, mut next_x, mut next) = ([zeros(); 3], [zeros(); 3], [RESTS; W]);
        solve(inertia, share, &rotor.way, rest, &mut next_rest, &mut next_x, &mut next);
        for (to, from) in rest.iter_mut().chain(&mut *x).zip(next_rest.iter().chain(&next_x)) {
            for l in 0..W {
                to.0[l] = Real::select(state[l] == GOES, from.0[l], to.0[l]);
            }
        }
        for l in 0..W {
            state[l] = if state[l] == GOES { next[l] } else { state[l] };
        }
    }
    for lane in (0..W).filter(|&lane| state[lane] != RESTS) {
        let [own, turned] = alone(&inertia.lane(lane), part, body, lane, &at(&rotor.way, lane))?;
        put(rest, lane, own);
        put(x, lane, turned);
    }
    Ok(())
}

/// Two corrections of the rest in all lanes, with one matrix.
#[inline(always)]
fn solve<const W: usize>(
    inertia: &Inertia<W>,
    share: Number,
    way: &Three<W>,
    guess: &Three<W>,
    to: &mut Three<W>,
    turned: &mut Three<W>,
    state: &mut States<W>,
) {
    let [far, steep, left] = [FAR * FAR, STEEP, LEFT * LEFT / 16.0].map(Fused);
    let minus = Fused(-1.0);
    for l in 0..W {
        let moments = inertia.lane(l);
        let (v, rest) = (moments.ahead(&scaled(share, &at(way, l))), at(guess, l));
        let second_order = moments.next(&v, &v);
        let u = sum(&second_order, &rest);
        let x = sum(&v, &u);
        let inverse = Inverse::at(&moments, &v, &x);
        let first = inverse.times(&moments.residual(&v, &u, &x));
        let rest = add_scaled(&rest, minus, &first);
        let u = sum(&second_order, &rest);
        let x = sum(&v, &u);
        let second = inverse.times(&moments.residual(&v, &u, &x));
        let rest = add_scaled(&rest, minus, &second);
        let x = sum(&v, &sum(&second_order, &rest));
        put(to, l, rest);
        put(turned, l, x);
        // What a third one would be, as in a simulation; here of squares, as roots take long.
        let (first, over) = (dot(&first, &first), inverse.over);
        let next = over * over * first * dot(&second, &second);
        let clear = (0.0 < over.0) & (over.0 <= steep.0) & (first.0 <= far.0);
        let rests = clear & (next.0 <= (left * dot(&x, &x)).0);
        let going = if clear { GOES } else { APART };
        state[l] = if rests { RESTS } else { going };
    }
}

/// The rest and x of a lane that cannot go with the others, as in a simulation.
#[cold]
#[inline(never)]
fn alone(
    moments: &Moments<Number>,
    part: &Part,
    body: usize,
    lane: usize,
    way: &[Number; 3],
) -> Result<[[Number; 3]; 2], Stuck> {
    let moments = moments.map(|x| x.0);
    let m = way.map(|x| x.0 / part.unit);
    let v = moments.ahead(&scaled(part.h / part.unit, &way.map(|x| x.0)));
    let stuck = |cause| Stuck { lane, failure: Some(Failure { body, cause }) };
    if !m.iter().sum::<f64>().is_finite() {
        return Err(Stuck { lane, failure: None }); // a simulation finds out why
    }
    let x = moments.rotation(&v).ok_or_else(|| stuck(too_fast(&moments, part.h, &m)))?;
    Ok([moments.rest(&v, &x), x].map(|of| of.map(Fused)))
}

/// The new attitudes and ways, but for a kick, and the next guess.
#[inline(always)]
fn advance<const W: usize>(
    inertia: &Inertia<W>,
    part: &Part,
    equal: bool,
    sums: bool,
    rotor: &mut Rotor<W>,
    guess: &Weights,
    Scratch { rest, x, .. }: &Scratch<W>,
) {
    let over = part.over.map(Fused);
    let Rotor { q, q_low, way, way_low, guess: ahead, past: [last, earlier] } = rotor;
    if sums {
        turn_sums(inertia, over, x, q, q_low, way, way_low);
    } else {
        turn_plain(inertia, over, x, q, way);
    }
    let weights = guess.weights.map(Fused);
    for i in 0..3 {
        let (rest, last, earlier, ahead) = (&rest[i], &mut last[i], &mut earlier[i], &mut ahead[i]);
        for l in 0..W {
            let (found, before, first) = (rest.0[l], last.0[l], earlier.0[l]);
            ahead.0[l] = extrapolated(equal, weights, found, before, first);
            (last.0[l], earlier.0[l]) = (found, before);
        }
    }
}

/// What a step takes from the way, negative.
#[inline(always)]
fn change(moments: &Moments<Number>, [over, low]: [Number; 2], x: &[Number; 3], s: Number) -> [Number; 3] {
    let (along, [push, rest]) = (Moments::along(x, s), moments.push);
    from_fn(|i| {
        let taken = push[i].multiply_add(along[i], rest[i] * along[i]); // rounded once: else the rest were lost
        (-over).multiply_add(taken, -(low * taken))
    })
}

#[inline(always)]
fn turn_plain<const W: usize>(
    inertia: &Inertia<W>,
    over: [Number; 2],
    x: &Three<W>,
    q: &mut Nine<W>,
    way: &mut Three<W>,
) {
    for l in 0..W {
        let x = at(x, l);
        let s = share(&x);
        let change = change(&inertia.lane(l), over, &x, s);
        let ahead = sum(&at(way, l), &change);
        put(way, l, ahead);
        let from = at(q, l);
        put(q, l, sum(&from, &product(&from, &turn(&x, s))));
    }
}

/// The same with compensated sums.
#[inline(always)]
fn turn_sums<const W: usize>(
    inertia: &Inertia<W>,
    over: [Number; 2],
    x: &Three<W>,
    q: &mut Nine<W>,
    q_low: &mut Nine<W>,
    way: &mut Three<W>,
    way_low: &mut Three<W>,
) {
    for l in 0..W {
        let x = at(x, l);
        let s = share(&x);
        let change = change(&inertia.lane(l), over, &x, s);
        let (high, low) = two_sum(&at(way, l), &change);
        let low = sum(&low, &at(way_low, l));
        put(way, l, high);
        put(way_low, l, low);
        let from = at(q, l);
        let (high, low) = two_sum(&from, &sum(&at(q_low, l), &product(&from, &turn(&x, s))));
        put(q, l, high);
        put(q_low, l, low);
    }
}

/// Adds kicks to the ways.
#[inline(always)]
pub(super) fn push<const W: usize>(sums: bool, kick: &Three<W>, way: &mut Three<W>, way_low: &mut Three<W>) {
    if !sums {
        for l in 0..W {
            let pushed = sum(&at(way, l), &at(kick, l));
            put(way, l, pushed);
        }
        return;
    }
    for l in 0..W {
        let (high, low) = two_sum(&at(way, l), &at(kick, l));
        let (high, low) = two_sum(&high, &sum(&low, &at(way_low, l)));
        put(way, l, high);
        put(way_low, l, low);
    }
}

/// Adds low digits to the ways.
#[inline(always)]
fn settle<const W: usize>(way: &mut Three<W>, way_low: &mut Three<W>) {
    for l in 0..W {
        let (high, low) = two_sum(&at(way, l), &at(way_low, l));
        put(way, l, high);
        put(way_low, l, low);
    }
}

/// Q(3 − QᵀQ)/2 (Å. Björck, C. Bowie 1971).
#[inline(always)]
fn straighten<const W: usize>(sums: bool, q: &mut Nine<W>, q_low: &mut Nine<W>) {
    for l in 0..W {
        let from = at(q, l);
        let by = scaled(Fused(0.5), &product(&from, &deviation(&from)));
        if sums {
            let (high, low) = two_sum(&from, &sum(&at(q_low, l), &by));
            put(q, l, high);
            put(q_low, l, low);
        } else {
            put(q, l, sum(&from, &by));
        }
    }
}
