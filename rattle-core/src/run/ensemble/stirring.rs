//! Flows of momenta in lanes: half before each step and half after it, or in the middle of the step.
//!
//! ```text
//! linear     δ(p) = A p + √variance ξ      A a matrix, ξ normal
//! any other  δ(p) = Φₕ(p) − p              asked of the flow, lane by lane
//!
//! random     p ← p + δ(p) + N              N = μ∇g(q) such that p is along the surface
//! symmetric  p ← p + δ(p + N/2) + N
//! ```
//!
//! For linear flows μ has a formula, for others it is found by the secant rule, as [`crate::motion::stir`] does. A lane
//! for which it is not found goes by itself. Random words are those of [`Noise`], a function of trajectory and step.

use crate::effect::interval::{Interval, Normals, Rule, UnitMasses};
use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::effect::noise::{Noise, halves};
use crate::kernel::functions::ConstraintKernel;
use crate::motion::parts::Given;
use crate::motion::record::{Hallmark, short_name};
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::{Fused, Lane, is_finite};
use crate::number::vector::{add_scaled, dot, largest, sum, two_sum};
use crate::number::vectors::{Vectors, at, put};
use crate::run::ensemble::laws::Laws;
use crate::run::ensemble::rhythm::{Rhythm, Turn, When};
use crate::run::fingerprint::{BESIDE, IN_A_STEP, of_flow, told};
use crate::systems::surface::normal::Normal;
use std::array::from_fn;
use std::borrow::Borrow;

/// Momenta are taken to be no more than so many times their standard deviation in equilibrium: a normal number is
/// beyond that once in 5e8.
pub(super) const DEVIATIONS: f64 = 6.0;

/// Lanes for which no μ is found in so many rounds go by themselves. Three are enough for flows that are linear.
pub(super) const MOST_ROUNDS: usize = 16;

/// What stirs each lane.
pub(super) struct Stirring<S, const L: usize, const D: usize> {
    flows: Vec<Stir<S, L, D>>,
    pub(super) rhythm: Rhythm<L>,
}

/// A flow.
#[derive(Clone)]
enum Stir<S, const L: usize, const D: usize> {
    Linear(Box<Linear<S, L, D>>),
    /// By asking it.
    Asked(Rule),
}

/// A flow that is linear in each lane, with noise.
#[derive(Clone)]
struct Linear<S, const L: usize, const D: usize> {
    matrix: [[[S; L]; D]; D],
    rule: Rule,
    /// Whether there is noise; √variance, and the seeds.
    draws: bool,
    deviation: [f64; L],
    seed: [u64; L],
    /// The largest momentum to expect.
    most: [f64; L],
}

/// What flows act on.
pub(super) struct Stirred<'a, S, const L: usize, const D: usize> {
    pub(super) q: &'a Vectors<S, L, D>,
    pub(super) normal: &'a Vectors<S, L, D>,
    pub(super) square: &'a [S; L],
    /// Momenta, and what rounding took from them.
    pub(super) p: &'a mut Vectors<S, L, D>,
    pub(super) low: &'a mut Vectors<S, L, D>,
    /// The work of all flows since the start.
    pub(super) work: &'a mut [f64; L],
}

/// What is asked of a flow: what momenta change by.
pub(super) struct Question<'a, S, const L: usize, const D: usize> {
    turn: Turn,
    q: &'a Vectors<S, L, D>,
    normal: &'a Vectors<S, L, D>,
    square: &'a [S; L],
    p: &'a Vectors<S, L, D>,
}

/// Who answers.
type Answer<'a, S, const L: usize, const D: usize> =
    dyn FnMut(Question<'_, S, L, D>, &mut Vectors<S, L, D>) + 'a;

impl<S: Clone, const L: usize, const D: usize> Clone for Stirring<S, L, D> {
    #[inline(never)] // compiled for those without flows, too
    fn clone(&self) -> Self {
        Self { flows: self.flows.clone(), rhythm: self.rhythm.clone() }
    }
}

impl<S: Lane, const L: usize, const D: usize> Stirring<S, L, D> {
    /// What stirs lanes that obey these laws in steps of h, after so many parts of each; none where nothing does.
    pub(super) fn of<X: Laws<S, D>>(laws: &X, after: usize, h: f64) -> Option<Box<Self>> {
        if const { X::Forces::FLOWS == 0 } {
            return None;
        }
        let (effects, numbers) = (laws.effects(0), 0..X::Forces::FLOWS);
        let effects = effects.borrow();
        let rule = |number| effects.manner(number).0.rule;
        let once = X::Forces::FLOWS == 1 && rule(0) == Rule::Random;
        let changes = (0..L).any(|lane| laws.effects(lane).borrow().changes_with_time());
        let rhythm = Rhythm::of(after, h, once, changes);
        let stir = |number| match Linear::of(laws, number, rhythm.time, rule(number)) {
            Some(linear) => Stir::Linear(linear),
            None => Stir::Asked(rule(number)),
        };
        Some(Box::new(Self { flows: numbers.map(stir).collect(), rhythm }))
    }

    /// Has lane `to` be stirred as lane `from` is.
    pub(super) fn copy(&mut self, from: usize, to: usize) {
        self.rhythm.copy(from, to);
        for flow in &mut self.flows {
            if let Stir::Linear(linear) = flow {
                linear.copy(from, to);
            }
        }
    }

    /// The largest momentum to expect of a lane.
    #[inline(always)]
    pub(super) fn momentum(&self, lane: usize) -> f64 {
        let most = self.flows.iter().map(|flow| match flow {
            Stir::Linear(linear) => linear.most[lane],
            Stir::Asked(_) => 0.0,
        });
        most.fold(0.0, f64::max)
    }

    /// Whether momenta may be any after the next step, whatever they are now.
    pub(super) fn is_abrupt(&self) -> bool {
        self.flows.iter().any(|flow| matches!(flow, Stir::Asked(Rule::Random)))
    }

    /// What tells the flows of a lane from others, asked beside this place and the time 0; of those that are asked what
    /// they do also with this momentum, in a step.
    pub(super) fn hallmarks<X: Laws<S, D>>(
        &self,
        laws: &X,
        lane: usize,
        [q, p]: [[S; D]; 2],
    ) -> Vec<Hallmark> {
        let effects = laws.effects(lane);
        let (effects, time) = (effects.borrow(), self.rhythm.time);
        let ornstein = |number: usize| {
            let of = effects.ornstein_uhlenbeck(number, time)?;
            let [high, low] = halves(of.seed);
            let numbers = vec![of.lost, of.variance, high, low];
            Some(Hallmark::of_parameters(format!("flow {number}"), "friction and noise", numbers))
        };
        let asked = |number: usize, moment: f64, p: [S; D], to: [S; D]| {
            let (manner, name) = effects.manner(number);
            let [gradient] = laws.constraint(lane).borrow().jacobian(&q);
            let (noise, mut changes) = (Noise { effect: number as u64, ..Noise::default() }, [to]);
            let (at, normals) = ([[q], [p]], [Normal::new(gradient)]);
            let normals = &&normals[..];
            let during = interval(Given::of(time, true, noise), moment, [&at[0], &at[1]], normals);
            laws.flow(lane, number, &during, &mut changes);
            let numbers = changes[0].map(S::to_f64).to_vec();
            Hallmark::new(format!("flow {number}"), format!("{} ({manner})", short_name(name)), numbers)
        };
        let mark = |number| ornstein(number).unwrap_or_else(|| asked(number, BESIDE, q, q));
        let in_a_step = |number| {
            let changes = || asked(number, time.abs(), p, [S::default(); D]);
            ornstein(number).is_none().then(|| told(changes(), IN_A_STEP))
        };
        let parameters = (0..X::Forces::FLOWS).filter_map(|number| of_flow(number, effects));
        let all = (0..X::Forces::FLOWS).map(mark).chain(parameters);
        all.chain((0..X::Forces::FLOWS).filter_map(in_a_step)).collect()
    }

    /// Has all flows act in all lanes, before a step or after it. Momenta are along the surface then.
    ///
    /// # Errors
    /// The first lane in which one of them cannot.
    #[inline(never)]
    pub(super) fn act(
        &self,
        set: Fusing,
        when: When,
        stirred: Stirred<'_, S, L, D>,
        answer: &mut Answer<'_, S, L, D>,
    ) -> Result<(), usize> {
        set.run_lanes::<L, _>(Acting { stirring: self, when, stirred, answer })
    }
}

impl<S: Lane, const L: usize, const D: usize> Linear<S, L, D> {
    /// Flow number `number` in a time h, if it is linear in all lanes.
    fn of<X: Laws<S, D>>(laws: &X, number: usize, h: f64, rule: Rule) -> Option<Box<Self>> {
        let (zero, none) = ([S::default(); L], [0.0; L]);
        let (matrix, deviation, most) = ([[zero; D]; D], none, none);
        let mut linear = Box::new(Self { matrix, rule, draws: false, deviation, seed: [0; L], most });
        for lane in 0..L {
            let effects = laws.effects(lane);
            let effects: &X::Forces = effects.borrow();
            let matrix = match effects.ornstein_uhlenbeck(number, h) {
                Some(of) => {
                    linear.draws |= of.variance != 0.0;
                    linear.deviation[lane] = of.variance.sqrt();
                    linear.seed[lane] = of.seed;
                    linear.most[lane] = DEVIATIONS * of.temperature().sqrt();
                    from_fn(|i| from_fn(|k| if i == k { of.lost } else { 0.0 }))
                }
                None => effects.linear(number, h, 0, &UnitMasses)?,
            };
            for (to, from) in linear.matrix.as_flattened_mut().iter_mut().zip(matrix.as_flattened()) {
                to[lane] = S::from_f64(*from);
            }
        }
        Some(linear)
    }

    fn copy(&mut self, from: usize, to: usize) {
        self.matrix.as_flattened_mut().iter_mut().for_each(|numbers| numbers[to] = numbers[from]);
        (self.deviation[to], self.seed[to], self.most[to]) =
            (self.deviation[from], self.seed[from], self.most[from]);
    }

    /// Acts in all lanes, with these random numbers.
    #[inline(always)]
    fn act(
        &self,
        noise: Option<&Vectors<Fused<f64>, L, D>>,
        stirred: &mut Stirred<'_, S, L, D>,
    ) -> Result<(), usize> {
        let Stirred { normal, square, p, low, work, .. } = stirred;
        let mut changes = [[S::default(); L]; D];
        multiply(&self.matrix, p, &mut changes);
        if let Some(noise) = noise {
            add_random(&self.deviation, noise, &mut changes);
        }
        if self.rule == Rule::Symmetric {
            hold(&self.matrix, normal, square, p, &mut changes)?;
        }
        add(&changes, normal, square, p, low, work);
        Ok(())
    }
}

/// A x, of one lane.
#[inline(always)]
fn times<S: Lane, const L: usize, const D: usize>(
    matrix: &[[[S; L]; D]; D],
    lane: usize,
    x: &[S; D],
) -> [S; D] {
    from_fn(|i| {
        let mut sum = matrix[i][i][lane] * x[i];
        for k in 0..D {
            if k != i {
                sum = matrix[i][k][lane].multiply_add(x[k], sum);
            }
        }
        sum
    })
}

/// A p of all lanes.
#[inline(always)]
fn multiply<S: Lane, const L: usize, const D: usize>(
    matrix: &[[[S; L]; D]; D],
    p: &Vectors<S, L, D>,
    changes: &mut Vectors<S, L, D>,
) {
    for l in 0..L {
        put(changes, l, times(matrix, l, &at(p, l)));
    }
}

/// Adds noise.
#[inline(always)]
fn add_random<S: Lane, const L: usize, const D: usize>(
    deviation: &[f64; L],
    noise: &Vectors<Fused<f64>, L, D>,
    changes: &mut Vectors<S, L, D>,
) {
    for l in 0..L {
        let random = at(noise, l).map(|x| S::from_f64(deviation[l] * x.0));
        put(changes, l, sum(&at(changes, l), &random));
    }
}

/// What a flow leaves of a normal's half, and that half, are less than this part of the normal where the impulse that
/// holds momenta along the surface is hardly known: a field turns them by 160° in half a step.
const HELD: f64 = 1.0 / 32.0;

/// Adds N, and what flows of this matrix make of half of it, such that momenta are along the surface. An error for the
/// first lane that has to find N by itself.
#[inline(always)]
fn hold<S: Lane, const L: usize, const D: usize>(
    matrix: &[[[S; L]; D]; D],
    normal: &Vectors<S, L, D>,
    square: &[S; L],
    p: &Vectors<S, L, D>,
    changes: &mut Vectors<S, L, D>,
) -> Result<(), usize> {
    let (half, least) = (S::from_f64(0.5), S::from_f64(HELD));
    let mut held = [S::default(); L];
    for l in 0..L {
        let (n, change) = (at(normal, l), at(changes, l));
        let turned = times(matrix, l, &n);
        let slope = half.multiply_add(dot(&n, &turned), square[l]);
        let mu = -dot(&n, &sum(&at(p, l), &change)) / slope;
        put(changes, l, add_scaled(&change, mu, &add_scaled(&n, half, &turned)));
        held[l] = slope.abs() - least * square[l];
    }
    held.iter().position(|&held| held.lt(S::default())).map_or(Ok(()), Err)
}

/// Adds changes to the momenta of all lanes, makes them ones along the surface, and books what that adds to the kinetic
/// energy.
#[inline(always)]
fn add<S: Lane, const L: usize, const D: usize>(
    changes: &Vectors<S, L, D>,
    normal: &Vectors<S, L, D>,
    square: &[S; L],
    p: &mut Vectors<S, L, D>,
    low: &mut Vectors<S, L, D>,
    work: &mut [f64; L],
) {
    let half = S::from_f64(0.5);
    for l in 0..L {
        let (n, old, old_low) = (at(normal, l), at(p, l), at(low, l));
        let change = sum(&old_low, &at(changes, l));
        let change = add_scaled(&change, -dot(&n, &sum(&old, &change)) / square[l], &n);
        let (new, new_low) = two_sum(&old, &change);
        put(p, l, new);
        put(low, l, new_low);
        let energy = |p: &[S; D], low: &[S; D]| half.multiply_add(dot(p, p), dot(low, p));
        work[l] += (energy(&new, &new_low) - energy(&old, &old_low)).to_f64();
    }
}

/// All flows at work.
struct Acting<'a, 'b, S, const L: usize, const D: usize> {
    stirring: &'a Stirring<S, L, D>,
    when: When,
    stirred: Stirred<'a, S, L, D>,
    answer: &'a mut Answer<'b, S, L, D>,
}

impl<S: Lane, const L: usize, const D: usize> Work for Acting<'_, '_, S, L, D> {
    type Done = Result<(), usize>;

    #[inline(always)]
    fn run(self) -> Self::Done {
        let Self { stirring, when, mut stirred, answer } = self;
        for turn in stirring.rhythm.turns(stirring.flows.len(), when) {
            match &stirring.flows[turn.number] {
                Stir::Linear(linear) => {
                    if linear.draws {
                        let mut noise = [[Fused(0.0); L]; D];
                        stirring.rhythm.draw_all(&linear.seed, turn, &mut noise);
                        linear.act(Some(&noise), &mut stirred)?;
                    } else {
                        linear.act(None, &mut stirred)?;
                    }
                }
                Stir::Asked(rule) => ask(*rule, turn, &mut stirred, answer)?,
            }
        }
        Ok(())
    }
}

/// Has a flow that is asked act in all lanes.
#[inline(always)]
fn ask<S: Lane, const L: usize, const D: usize>(
    rule: Rule,
    turn: Turn,
    stirred: &mut Stirred<'_, S, L, D>,
    answer: &mut Answer<'_, S, L, D>,
) -> Result<(), usize> {
    let Stirred { q, normal, square, p, low, work } = stirred;
    let zero = [S::default(); L];
    let (mut changes, mut tried) = ([zero; D], **p);
    let mut search = Search { mu: zero, before: zero, rest: zero, settled: [false; L] };
    for round in 0..MOST_ROUNDS {
        let question = Question { turn, q, normal, square, p: &tried };
        answer(question, &mut changes);
        search.judge(round == 0, normal, square, p, low, &changes, &mut tried);
        if rule == Rule::Random || search.settled == [true; L] {
            break;
        }
    }
    if rule == Rule::Random {
        for l in 0..L {
            search.settled[l] = at(&changes, l).map(is_finite) == [true; D];
            search.mu[l] = S::default();
        }
    }
    if let Some(lane) = search.settled.iter().position(|&settled| !settled) {
        return Err(lane);
    }
    for l in 0..L {
        let change = add_scaled(&at(&changes, l), search.mu[l], &at(normal, l));
        put(&mut changes, l, change);
    }
    add(&changes, normal, square, p, low, work);
    Ok(())
}

/// μ of all lanes, by the secant rule.
struct Search<S, const L: usize> {
    mu: [S; L],
    before: [S; L],
    /// What is still to be added to μ, as seen the last time.
    rest: [S; L],
    settled: [bool; L],
}

impl<S: Lane, const L: usize> Search<S, L> {
    /// Says by what momenta change where settled, and tries others elsewhere. μ of a lane that has settled stays what
    /// it is.
    #[allow(clippy::too_many_arguments, reason = "slices that are arguments do not overlap")]
    #[inline(always)]
    fn judge<const D: usize>(
        &mut self,
        first: bool,
        normal: &Vectors<S, L, D>,
        square: &[S; L],
        p: &Vectors<S, L, D>,
        low: &Vectors<S, L, D>,
        changes: &Vectors<S, L, D>,
        tried: &mut Vectors<S, L, D>,
    ) {
        let [zero, half, least] = [0.0, 0.5, f64::MIN_POSITIVE].map(S::from_f64);
        let rounding = S::from_f64(8.0 * S::EPSILON);
        for l in 0..L {
            let (n, old, change, mu) = (at(normal, l), at(p, l), at(changes, l), self.mu[l]);
            let new = sum(&old, &add_scaled(&sum(&at(low, l), &change), mu, &n));
            let rest = -dot(&n, &new) / square[l];
            let size = largest(&new).max(largest(&change)).max(least);
            let settled = (rest.abs() * largest(&n)).le(rounding * size);
            let slope = (rest - self.rest[l]) / (mu - self.before[l]);
            let known = !first & (slope.lt(zero) | zero.lt(slope));
            let step = S::select(known, -rest / slope, rest);
            let next = S::select(settled, mu, mu + step);
            (self.before[l], self.rest[l]) = (S::select(settled, self.before[l], mu), rest);
            (self.mu[l], self.settled[l]) = (next, settled);
            put(tried, l, add_scaled(&old, half * next, &n));
        }
    }
}

/// Who asks the flows of these laws.
pub(super) struct Asking<'a, S, X, const L: usize, const D: usize> {
    pub(super) laws: &'a X,
    pub(super) stirring: &'a Stirring<S, L, D>,
    pub(super) question: Question<'a, S, L, D>,
    pub(super) changes: &'a mut Vectors<S, L, D>,
}

impl<S: Lane, X: Laws<S, D>, const L: usize, const D: usize> Work for Asking<'_, S, X, L, D> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { laws, stirring, question, changes } = self;
        let Question { turn, q, normal, square, p } = question;
        let rhythm = &stirring.rhythm;
        for l in 0..L {
            let one = S::from_f64(1.0);
            let normals = [Normal { gradient: at(normal, l), inverse_square: one / square[l] }];
            let (now, mut change) = (rhythm.time_of(l, turn), [[S::default(); D]]);
            let (q, p, normals) = ([at(q, l)], [at(p, l)], &&normals[..]);
            let during = interval(rhythm.given(l, turn), now, [&q, &p], normals);
            laws.flow(l, turn.number, &during, &mut change);
            put(changes, l, change[0]);
        }
    }
}

/// What a flow is shown of a body with this place and momentum.
#[inline(always)]
fn interval<'a, S: Lane, const D: usize>(
    given: Given<'a, S, D>,
    time: f64,
    [positions, momenta]: [&'a [[S; D]]; 2],
    surface: &'a dyn Normals<S, D>,
) -> Interval<'a, S, D> {
    let given = Given { velocities: momenta, ..given };
    let seen = (Moment { time, positions }, momenta, &[][..]);
    given.interval(seen, &UnitMasses, Some(surface), (false, D - 1))
}
