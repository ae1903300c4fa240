//! Steps of rigid bodies in lanes after which attitudes are made rotations again; each lane with inner steps of its own
//! where there is a tolerance. As on surfaces ([`crate::run::ensemble::projected`]) a row waits for its slowest lane,
//! and what becomes of a lane depends on itself alone.
//!
//! ```text
//! Q̂, m′                by the method (`rigid_stages`, `rigid_series`)
//! Q′ ← Q̂(3 − Q̂ᵀQ̂)/2    until it is a rotation
//! ```
//!
//! **Whether a step can be believed** is asked of each inner one, as a simulation asks it ([`crate::motion::course`]):
//! kinetic energy must not change by what torques did not give. A lane for which this does not hold, or whose attitude
//! is not made a rotation, takes the whole step by itself.

use crate::motion::course::{ASTRAY, JUMP, ROUNDINGS_OF_WAYS};
use crate::number::instructions::Work;
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::number::vector::{largest, scaled, sum, two_sum};
use crate::run::ensemble::engine::Stuck;
use crate::run::ensemble::pace::{ARRIVED, BY_ITSELF, MOST_NEWTON_STEPS, MOST_PASSES, MOVES, one_by_one};
use crate::run::ensemble::rigid_row::Nine;
use crate::run::ensemble::rigid_stand::{Departs, Pulls, ROW, Stand};
use crate::run::ensemble::track::{State, choose, put as put_there, state};
use crate::systems::network::in_lanes::{Numbers, Which, any, at, zeros};
use crate::systems::rigid::rotation::{CROOKED, deviation, has_rotation, product};

/// Finds where the step leads a lane by itself from there.
pub(super) type Apart<'a> = dyn FnMut(usize, &State<ROW>) -> Result<[Vec<f64>; 4], Stuck> + 'a;

/// Some steps of a row.
pub(super) struct ProjectedSteps<'a, 'b> {
    pub(super) pulling: Pulls<'a, 'b>,
    pub(super) apart: &'a mut Apart<'b>,
    /// Which lane each is a copy of.
    pub(super) copy_of: &'a [usize; ROW],
    pub(super) desk: &'a mut Desk<'b>,
    pub(super) kept: &'a mut State<ROW>,
    pub(super) steps: u64,
}

impl Work for ProjectedSteps<'_, '_> {
    type Done = Result<(), Vec<Stuck>>;

    #[inline(always)]
    fn run(self) -> Result<(), Vec<Stuck>> {
        let Self { mut pulling, apart, copy_of, desk, kept, steps } = self;
        if !desk.stand.there {
            kept.iter().zip(state(&mut desk.stand.tracks)).for_each(|(from, to)| to.copy_from_slice(from));
            desk.stand.be_there(&mut pulling);
        }
        for _ in 0..steps {
            desk.step(&mut pulling);
            let Stand { pace, tracks, .. } = &mut desk.stand;
            if pace.going.contains(&BY_ITSELF) {
                let put = &mut |lane, landed: &[Vec<f64>; 4]| put_there(tracks, lane, landed);
                one_by_one(&pace.going, copy_of, &mut |lane| apart(lane, kept), put)?;
                desk.stand.be_there(&mut pulling);
            }
            kept.iter_mut()
                .zip(state(&mut desk.stand.tracks))
                .for_each(|(to, from)| to.copy_from_slice(from));
        }
        Ok(())
    }
}

/// What a thread works on.
pub(super) struct Desk<'a> {
    pub(super) stand: Stand<'a>,
    method: Box<dyn Departs + 'a>,
    /// Attitudes to which the inner step led regardless of what makes them rotations; with a tolerance.
    departed: Vec<Numbers<ROW>>,
    /// Whether an attitude is still made a [rotation](MOVES), and how far it was from one before.
    seeking: Which<ROW>,
    distance: Numbers<ROW>,
}

impl<'a> Desk<'a> {
    /// For bodies that stand there and depart by this method.
    pub(super) fn new(stand: Stand<'a>, method: Box<dyn Departs + 'a>) -> Self {
        let departed = vec![zeros(); stand.trial[0].len()];
        Self { stand, method, departed, seeking: [ARRIVED; ROW], distance: zeros() }
    }

    /// Finds where one step leads all lanes. Those that it cannot lead there are [`BY_ITSELF`] then.
    #[inline(always)]
    fn step(&mut self, pulling: &mut Pulls<'_, '_>) {
        self.stand.pace.begin();
        for pass in 0..MOST_PASSES {
            self.method.depart(&mut self.stand, pulling);
            if self.stand.pace.tolerance().is_some() {
                self.departed.copy_from_slice(&self.stand.trial[0]);
            }
            let straight = self.straighten();
            self.stand.respond(pulling);
            self.look(&straight);
            self.weigh();
            self.method.compare(&mut self.stand);
            if !self.take(pass + 1) {
                return;
            }
        }
    }

    /// Makes attitudes rotations, as [`Nearing`](crate::solve::nearing::Nearing) judges it. Says of which lanes all
    /// are.
    #[inline(always)]
    fn straighten(&mut self) -> Which<ROW> {
        let Self { stand: Stand { pace, trial: [q, _, q_low, _], .. }, seeking, distance, .. } = self;
        let mut straight = [1; ROW];
        for (q, low) in q.as_chunks_mut().0.iter_mut().zip(q_low.as_chunks_mut().0) {
            for l in 0..ROW {
                let place = at(q, l);
                let seeks = if has_rotation(&place, &deviation(&place)) { MOVES } else { BY_ITSELF };
                seeking[l] = if pace.takes(l) { seeks } else { ARRIVED };
                distance.0[l] = Fused(f64::INFINITY);
            }
            for _ in 0..MOST_NEWTON_STEPS {
                let moves = approach(q, distance, seeking);
                if !any(&moves) {
                    break;
                }
                make_straight(&moves, q, low);
            }
            for l in 0..ROW {
                straight[l] = if seeking[l] == ARRIVED { straight[l] } else { 0 };
            }
        }
        straight
    }

    /// Has lanes go by themselves whose inner step cannot be believed.
    #[inline(always)]
    fn look(&mut self, straight: &Which<ROW>) {
        let Stand { inertia, pace, tracks, rates, trial: [_, m, ..], rates_there, .. } = &mut self.stand;
        let ([_, momenta], [_, from], [_, to]) = (tracks, rates, rates_there);
        let (mut was, mut is, mut given) = (zeros::<ROW>(), zeros::<ROW>(), zeros::<ROW>());
        for c in 0..m.len() {
            let (start, end) = ([&momenta.now[c], &from[c]], [&m[c], &to[c]]);
            add_energies(&inertia.over[c % 3], &pace.inner, start, end, &mut was, &mut is, &mut given);
        }
        for l in 0..ROW {
            let [was, is, given] = [&was, &is, &given].map(|of| of.0[l].0);
            let steady = (is - was - given).abs() <= JUMP * (was + is + given.abs());
            pace.doubt(l, steady & (is <= f64::MAX) & (straight[l] != 0));
        }
    }

    /// Has lanes go by themselves in which an attitude was [moved](crate::motion::course::moved) too far from where its
    /// inner step led.
    #[inline(always)]
    fn weigh(&mut self) {
        let Self { stand: Stand { inertia, pace, trial: [q, m, ..], .. }, departed, .. } = self;
        let Some(tolerance) = pace.tolerance() else { return };
        let h = pace.h().0.abs();
        let bodies = q.as_chunks::<9>().0.iter().zip(departed.as_chunks::<9>().0).zip(m.as_chunks::<3>().0);
        for ((q, departed), m) in bodies {
            let [mut off, mut speed] = [[0.0_f64; ROW]; 2];
            for (q, departed) in q.iter().zip(departed) {
                for l in 0..ROW {
                    let way = q.0[l].0 - departed.0[l].0;
                    off[l] += way * way;
                }
            }
            for (over, m) in inertia.over.iter().zip(m) {
                for l in 0..ROW {
                    speed[l] = speed[l].max((2.0 * over.0[l].0 * m.0[l].0).abs());
                }
            }
            for l in 0..ROW {
                let rounding = ROUNDINGS_OF_WAYS * f64::EPSILON * (1.0 + h * speed[l]);
                pace.doubt(l, off[l].sqrt() <= ASTRAY * tolerance + rounding);
            }
        }
    }

    /// Takes the inner steps that are taken, after so many. Returns whether a lane has still some way to go.
    #[inline(always)]
    fn take(&mut self, passes: usize) -> bool {
        let Stand { pace, trial: [q, m, q_low, m_low], tracks, rates, rates_there, .. } = &mut self.stand;
        let (moves, any) = pace.advance(passes);
        for (track, (high, low)) in tracks.iter_mut().zip([(q, q_low), (m, m_low)]) {
            for (c, (high, low)) in high.iter().zip(low).enumerate() {
                track.take(&moves, c, [high, low]);
            }
        }
        for (to, from) in rates.iter_mut().flatten().zip(rates_there.iter().flatten()) {
            choose(&moves, from, to);
        }
        any
    }
}

/// How far attitudes are from a rotation, and which of those that were not yet one move on: the others are one, or
/// lost.
#[inline(always)]
fn approach<const W: usize>(q: &Nine<W>, distance: &mut Numbers<W>, seeking: &mut Which<W>) -> Which<W> {
    let mut moves = [0; W];
    for l in 0..W {
        let far = largest(&deviation(&at(q, l))).0;
        let arrived = far <= CROOKED;
        let nearer = far < distance.0[l].0; // not where it is no number
        let seeks = seeking[l] == MOVES;
        moves[l] = u64::from(seeks & !arrived & nearer);
        let lost = if nearer { MOVES } else { BY_ITSELF };
        let on = if arrived { ARRIVED } else { lost };
        seeking[l] = if seeks { on } else { seeking[l] };
        distance.0[l] = Fused(far);
    }
    moves
}

/// Q(3 − QᵀQ)/2 (Å. Björck, C. Bowie 1971) of some lanes.
#[inline(always)]
fn make_straight<const W: usize>(lanes: &Which<W>, q: &mut Nine<W>, low: &mut Nine<W>) {
    for l in 0..W {
        let (from, rest) = (at(q, l), at(low, l));
        let by = scaled(Fused(0.5), &product(&from, &deviation(&from)));
        let (to, lost) = two_sum(&from, &sum(&rest, &by));
        for k in 0..9 {
            q[k].0[l] = Real::select(lanes[l] != 0, to[k], from[k]);
            low[k].0[l] = Real::select(lanes[l] != 0, lost[k], rest[k]);
        }
    }
}

/// Adds twice the kinetic energies of a component of a momentum at both ends of an inner step, and twice what torques
/// change them by.
#[inline(always)]
fn add_energies<const W: usize>(
    over: &Numbers<W>,
    inner: &Numbers<W>,
    [m, rate]: [&Numbers<W>; 2],
    [m_end, rate_end]: [&Numbers<W>; 2],
    was: &mut Numbers<W>,
    is: &mut Numbers<W>,
    given: &mut Numbers<W>,
) {
    for l in 0..W {
        let over = Fused(2.0) * over.0[l];
        let [spin, spin_end] = [over * m.0[l], over * m_end.0[l]];
        was.0[l] = spin.multiply_add(m.0[l], was.0[l]);
        is.0[l] = spin_end.multiply_add(m_end.0[l], is.0[l]);
        let power = spin.multiply_add(rate.0[l], spin_end * rate_end.0[l]);
        given.0[l] = inner.0[l].multiply_add(power, given.0[l]);
    }
}
