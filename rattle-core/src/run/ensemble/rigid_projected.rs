//! Steps of rigid bodies in lanes by the stages of [`Dop853`], after which attitudes are made rotations again; each
//! lane with inner steps of its own where there is a tolerance. As on surfaces ([`crate::run::ensemble::projected`]) a
//! row waits for its slowest lane, and what becomes of a lane depends on itself alone.
//!
//! ```text
//! Q̇ = Q Ω̂,   ṁ = m × Ω + torque,   Ω = J⁻¹m     at each stage
//! Q ← Q(3 − QᵀQ)/2                              at the end, until Q is a rotation
//! ```
//!
//! **Whether a step can be believed** is asked of each inner one, as a simulation asks it ([`crate::motion::course`]):
//! kinetic energy must not change by what torques did not give. A lane for which this does not hold, or whose attitude
//! is not made a rotation, takes the whole step by itself.

use crate::methods::dop853::Dop853;
use crate::methods::dop853_table::STAGES;
use crate::motion::course::JUMP;
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::number::vector::{largest, scaled, sum, two_sum};
use crate::run::ensemble::dop853_row::Stages;
use crate::run::ensemble::engine::Stuck;
use crate::run::ensemble::forces_in_lanes::Pulling;
use crate::run::ensemble::pace::{
    ARRIVED, BY_ITSELF, MOST_NEWTON_STEPS, MOST_PASSES, MOVES, Pace, one_by_one,
};
use crate::run::ensemble::rigid_row::{Inertia, Nine, RigidRow, Three};
use crate::run::ensemble::track::{State, Track, choose, put as put_there, state};
use crate::systems::network::in_lanes::{Numbers, Which, any, at, put, zeros};
use crate::systems::rigid::rotation::{CROOKED, Moments, cross, deviation, product};
use std::array::from_fn;

/// Trajectories in a row: as many as the nearer cache holds the stages of.
pub(super) const ROW: usize = 16;

/// Coordinates of a body: its attitude by rows, and its momentum.
pub(super) const COORDINATES: [usize; 2] = [9, 3];

/// Finds where the step leads a lane by itself from there.
pub(super) type Apart<'a> = dyn FnMut(usize, &State<ROW>) -> Result<[Vec<f64>; 4], Stuck> + 'a;

/// Effects that turn bodies, if any do.
type Pulls<'a, 'b> = Option<&'a mut (dyn Pulling<RigidRow<Nine<ROW>>, ROW> + 'b)>;

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
        if !desk.there {
            kept.iter().zip(state(&mut desk.tracks)).for_each(|(from, to)| to.copy_from_slice(from));
            desk.be_there(&mut pulling);
        }
        for _ in 0..steps {
            desk.step(&mut pulling);
            if desk.pace.going.contains(&BY_ITSELF) {
                let Desk { pace, tracks, .. } = &mut *desk;
                let put = &mut |lane, landed: &[Vec<f64>; 4]| put_there(tracks, lane, landed);
                one_by_one(&pace.going, copy_of, &mut |lane| apart(lane, kept), put)?;
                desk.be_there(&mut pulling);
            }
            kept.iter_mut().zip(state(&mut desk.tracks)).for_each(|(to, from)| to.copy_from_slice(from));
        }
        Ok(())
    }
}

/// What a thread works on.
pub(super) struct Desk<'a> {
    inertia: &'a Inertia<ROW>,
    pub(super) set: Fusing,
    pace: Pace<ROW>,
    /// Attitudes and momenta; and their rates there, once they have been evaluated.
    tracks: [Track<ROW>; 2],
    stages: Stages<ROW>,
    there: bool,
    rates: [Vec<Numbers<ROW>>; 2],
    /// The same at a stage, or at the end of an inner step; and what rounding takes from both at that end.
    trial: State<ROW>,
    rates_there: [Vec<Numbers<ROW>>; 2],
    torques: Vec<Three<ROW>>,
    /// Whether an attitude is still made a [rotation](MOVES), and how far it was from one before.
    seeking: Which<ROW>,
    distance: Numbers<ROW>,
}

impl<'a> Desk<'a> {
    /// For so many bodies.
    #[inline(never)]
    pub(super) fn new(inertia: &'a Inertia<ROW>, bodies: usize, method: Dop853, set: Fusing) -> Self {
        let rows = |i: usize| vec![zeros::<ROW>(); COORDINATES[i] * bodies];
        Self {
            inertia,
            set,
            pace: Pace::new(&method),
            tracks: COORDINATES.map(|own| Track::new(own * bodies)),
            stages: Stages::new(COORDINATES.map(|own| own * bodies)),
            there: false,
            rates: from_fn(rows),
            trial: [rows(0), rows(1), rows(0), rows(1)],
            rates_there: from_fn(rows),
            torques: vec![[zeros(); 3]; bodies],
            seeking: [ARRIVED; ROW],
            distance: zeros(),
        }
    }

    /// Rates where all bodies are.
    #[inline(always)]
    fn be_there(&mut self, pulling: &mut Pulls<'_, '_>) {
        let Self { trial: [q, m, ..], tracks: [attitudes, momenta], .. } = self;
        q.copy_from_slice(&attitudes.now);
        m.copy_from_slice(&momenta.now);
        self.respond(pulling);
        self.there = true;
        self.rates.iter_mut().zip(&self.rates_there).for_each(|(to, from)| to.copy_from_slice(from));
    }

    /// Rates on trial.
    #[inline(always)]
    fn respond(&mut self, pulling: &mut Pulls<'_, '_>) {
        let Self { inertia, set, trial: [q, m, ..], rates_there: [turned, pushed], torques, .. } = self;
        let q = q.as_chunks::<9>().0;
        if let Some(pulling) = pulling {
            pulling.pull(*set, 1.0, (q, torques));
        }
        let rates = turned.as_chunks_mut().0.iter_mut().zip(pushed.as_chunks_mut().0);
        for ((q, m), (torque, (turned, pushed))) in
            q.iter().zip(m.as_chunks().0).zip(torques.iter().zip(rates))
        {
            rates_of(inertia, q, m, torque, turned, pushed);
        }
    }

    /// Finds where one step leads all lanes. Those that it cannot lead there are [`BY_ITSELF`] then.
    #[inline(always)]
    fn step(&mut self, pulling: &mut Pulls<'_, '_>) {
        self.pace.begin();
        for pass in 0..MOST_PASSES {
            self.evaluate(pulling);
            self.judge();
            self.depart();
            let straight = self.straighten();
            self.respond(pulling);
            self.look(&straight);
            if !self.take(pass + 1) {
                return;
            }
        }
    }

    /// The stages of an inner step.
    #[inline(always)]
    fn evaluate(&mut self, pulling: &mut Pulls<'_, '_>) {
        self.stages.begin(&mut self.pace);
        for (of_stages, rates) in self.stages.of.iter_mut().zip(&self.rates) {
            of_stages.note(0, rates);
        }
        for stage in 1..STAGES {
            for ((track, rates), trial) in self.tracks.iter().zip(&self.stages.of).zip(&mut self.trial) {
                rates.stage(stage, track, 0..trial.len(), &self.pace.inner, trial);
            }
            self.respond(pulling);
            for (of_stages, rates) in self.stages.of.iter_mut().zip(&self.rates_there) {
                of_stages.note(stage, rates);
            }
        }
    }

    /// Which inner steps are within the tolerance.
    #[inline(always)]
    fn judge(&mut self) {
        if self.pace.tolerance().is_some() {
            for body in 0..self.torques.len() {
                let ([attitudes, momenta], mut rates) = (&self.stages.of, [zeros(); 2]);
                for i in 0..3 {
                    let squares = momenta.squares(3 * body + i..3 * body + i + 1);
                    as_matrices(&self.inertia.over[i], &squares, &mut rates);
                }
                let places = attitudes.squares(9 * body..9 * body + 9);
                self.stages.note(&self.pace, &places, &rates);
            }
        }
        self.stages.judge(&mut self.pace);
    }

    /// Where inner steps lead.
    #[inline(always)]
    fn depart(&mut self) {
        let [q, m, q_low, m_low] = &mut self.trial;
        let tracks = self.tracks.iter().zip(&self.stages.of);
        for ((track, rates), (high, low)) in tracks.zip([(q, q_low), (m, m_low)]) {
            for (c, (high, low)) in high.iter_mut().zip(low).enumerate() {
                rates.arrive(track, c, &self.pace.inner, high, low);
            }
        }
    }

    /// Makes attitudes rotations, as [`Nearing`](crate::solve::nearing::Nearing) judges it. Says of which lanes all
    /// are.
    #[inline(always)]
    fn straighten(&mut self) -> Which<ROW> {
        let Self { pace, trial: [q, _, q_low, _], seeking, distance, .. } = self;
        let mut straight = [1; ROW];
        for (q, low) in q.as_chunks_mut().0.iter_mut().zip(q_low.as_chunks_mut().0) {
            for l in 0..ROW {
                seeking[l] = if pace.takes(l) { MOVES } else { ARRIVED };
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
        let Self { inertia, pace, tracks: [_, momenta], rates: [_, from], trial: [_, m, ..], .. } = self;
        let (mut was, mut is, mut given) = (zeros::<ROW>(), zeros::<ROW>(), zeros::<ROW>());
        for body in 0..self.torques.len() {
            for i in 0..3 {
                let c = 3 * body + i;
                add_energies(
                    &inertia.over[i],
                    &pace.inner,
                    [&momenta.now[c], &from[c]],
                    [&m[c], &self.rates_there[1][c]],
                    &mut was,
                    &mut is,
                    &mut given,
                );
            }
        }
        for l in 0..ROW {
            let [was, is, given] = [&was, &is, &given].map(|of| of.0[l].0);
            let steady = (is - was - given).abs() <= JUMP * (was + is + given.abs());
            pace.doubt(l, steady & (is <= f64::MAX) & (straight[l] != 0));
        }
    }

    /// Takes the inner steps that are taken, after so many. Returns whether a lane has still some way to go.
    #[inline(always)]
    fn take(&mut self, passes: usize) -> bool {
        let (moves, any) = self.pace.advance(passes);
        let [q, m, q_low, m_low] = &self.trial;
        for (track, (high, low)) in self.tracks.iter_mut().zip([(q, q_low), (m, m_low)]) {
            for (c, (high, low)) in high.iter().zip(low).enumerate() {
                track.take(&moves, c, [high, low]);
            }
        }
        for (to, from) in self.rates.iter_mut().flatten().zip(self.rates_there.iter().flatten()) {
            choose(&moves, from, to);
        }
        any
    }
}

/// Q̇ and ṁ of a body.
#[inline(always)]
fn rates_of<const W: usize>(
    inertia: &Inertia<W>,
    q: &Nine<W>,
    m: &Three<W>,
    torque: &Three<W>,
    turned: &mut Nine<W>,
    pushed: &mut Three<W>,
) {
    for l in 0..W {
        let (moments, q) = (inertia.lane(l), at(q, l));
        let rate = moments.rate(&at(m, l));
        put(pushed, l, sum(&moments.gyration(&Moments::others(&rate)), &at(torque, l)));
        let row = |i: usize| cross(&from_fn(|j| q[3 * i + j]), &rate);
        let rows = [row(0), row(1), row(2)];
        put(turned, l, from_fn(|k| rows[k / 3][k % 3]));
    }
}

/// Adds what squares of rates of a momentum are of those of an attitude: |Q v̂|² is 2 |v|².
#[inline(always)]
fn as_matrices<const W: usize>(over: &Numbers<W>, squares: &[Numbers<W>; 2], to: &mut [Numbers<W>; 2]) {
    for (square, to) in squares.iter().zip(to) {
        for l in 0..W {
            let rate = Fused(2.0) * over.0[l];
            to.0[l] = (Fused(2.0) * rate * rate).multiply_add(square.0[l], to.0[l]);
        }
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
