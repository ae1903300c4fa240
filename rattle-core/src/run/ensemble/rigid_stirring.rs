//! Flows of momenta on a row of trajectories of rigid bodies, and steps with them, compiled once here.
//!
//! ```text
//! bath     m ← m + lost·m + noise of covariance J       in lanes
//! other    m ← Φₕ(m)                                     asked of the flow, lane by lane
//! ```
//!
//! No constraint acts on angular momenta, so that what a flow changes is all there is. Kicks of two steps are not
//! merged where flows act between them.

use crate::effect::interval::Rule;
use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::motion::parts::Given;
use crate::motion::system::System;
use crate::number::instructions::Work;
use crate::number::lanes::{Fused, Lanes};
use crate::number::real::Real;
use crate::run::ensemble::engine::Stuck;
use crate::run::ensemble::forces_in_lanes::Pulling;
use crate::run::ensemble::rhythm::{Bath, InRhythm, Rhythm, Turn, When};
use crate::run::ensemble::rigid_row::{Course, RigidRow, Rotor, Row, Three, finite, push};
use crate::run::ensemble::splits::Splits;
use crate::systems::network::in_lanes::{Numbers, at, lost, zeros};
use std::array::from_fn;

/// What stirs the lanes of a row.
#[derive(Clone)]
pub(super) struct RotorStirring<const W: usize> {
    flows: Vec<Stir<W>>,
    pub(super) rhythm: Rhythm<W>,
    /// √J and 1/J.
    root: Three<W>,
    over: Three<W>,
}

/// A flow.
#[derive(Clone)]
enum Stir<const W: usize> {
    /// By the same share of all momenta, with noise.
    Bath(Bath<W>),
    /// By asking it.
    Asked,
}

/// What is asked of a flow: what momenta change by.
pub(super) struct Question<'a, const W: usize> {
    pub(super) turn: Turn,
    pub(super) bodies: &'a [Rotor<W>],
}

/// Who answers.
pub(super) type Answer<'a, const W: usize> = dyn FnMut(Question<'_, W>, &mut [Three<W>]) + 'a;

impl<const W: usize> RotorStirring<W> {
    /// What stirs lanes of these systems by this method, or draws their momenta anew; none where nothing does.
    pub(super) fn of<'a, Y: System<f64, D>, const D: usize>(
        lane: impl Fn(usize) -> &'a Y,
        method: &Splits,
    ) -> Option<Self> {
        if let Some(renewal) = method.renewal {
            let bath = Stir::Bath(Bath::of(&[renewal.process(); W]));
            return Some(Self::acting(lane, vec![bath], Rhythm::renewing(method.h)));
        }
        if const { Y::FLOWS == 0 } {
            return None;
        }
        let once = Y::FLOWS == 1 && lane(0).effects().manner(0).0.rule == Rule::Random;
        let rhythm = Rhythm::of(
            method.stirs_after,
            method.h,
            once,
            (0..W).any(|l| lane(l).effects().changes_with_time()),
        );
        let flows = (0..Y::FLOWS).map(|flow| {
            let processes: Option<Vec<_>> =
                (0..W).map(|l| lane(l).effects().ornstein_uhlenbeck(flow, rhythm.time)).collect();
            processes.map_or(Stir::Asked, |lanes| Stir::Bath(Bath::of(&lanes)))
        });
        let flows = flows.collect();
        Some(Self::acting(lane, flows, rhythm))
    }

    /// These flows.
    fn acting<'a, Y: System<f64, D>, const D: usize>(
        lane: impl Fn(usize) -> &'a Y,
        flows: Vec<Stir<W>>,
        rhythm: Rhythm<W>,
    ) -> Self {
        let of_each = |of: &dyn Fn(&Y, usize) -> f64| from_fn(|k| Lanes(from_fn(|l| Fused(of(lane(l), k)))));
        let unit = |k: usize| from_fn(|i| if i == k { 1.0 } else { 0.0 });
        Self {
            flows,
            root: of_each(&|system, k| system.inertia().root(0, &unit(k))[k]),
            over: of_each(&|system, k| system.inertia().velocity(0, &unit(k))[k]),
            rhythm,
        }
    }

    /// Has lane `to` be stirred as lane `from` is.
    pub(super) fn copy(&mut self, from: usize, to: usize) {
        self.rhythm.copy(from, to);
        self.root.iter_mut().chain(&mut self.over).for_each(|row| row.0[to] = row.0[from]);
        for flow in &mut self.flows {
            if let Stir::Bath(bath) = flow {
                bath.copy(from, to);
            }
        }
    }

    /// Twice the kinetic energy of each lane.
    #[inline(always)]
    fn energy(&self, bodies: &[Rotor<W>]) -> Numbers<W> {
        let mut sum = zeros::<W>();
        for rotor in bodies {
            for k in 0..3 {
                for l in 0..W {
                    let (m, low) = (rotor.way[k].0[l], rotor.way_low[k].0[l]);
                    let square = (Fused(2.0) * m).multiply_add(low, m * m);
                    sum.0[l] = self.over[k].0[l].multiply_add(square, sum.0[l]);
                }
            }
        }
        sum
    }

    /// What a bath changes the momenta of a body by.
    #[inline(always)]
    fn bathe(&self, bath: &Bath<W>, turn: Turn, body: usize, rotor: &Rotor<W>, change: &mut Three<W>) {
        for k in 0..3 {
            for l in 0..W {
                change[k].0[l] = bath.lost.0[l] * rotor.way[k].0[l];
            }
        }
        if bath.draws {
            // As a simulation draws nine numbers for each body, four at a time, of which three are used.
            let mut drawn = [[Fused(0.0); W]; 3];
            self.rhythm.draw(&bath.seed, turn, 3 * body as u64, &mut drawn);
            for k in 0..3 {
                for l in 0..W {
                    let size = bath.deviation.0[l] * self.root[k].0[l];
                    change[k].0[l] = size.multiply_add(drawn[k][l], change[k].0[l]);
                }
            }
        }
    }
}

/// Writes what a flow changes the momenta of each lane by that is asked.
pub(super) fn answer<'a, Y: System<f64, D>, const D: usize, const W: usize>(
    lane: impl Fn(usize) -> &'a Y,
    rhythm: &Rhythm<W>,
    Question { turn, bodies }: Question<'_, W>,
    changes: &mut [Three<W>],
) {
    for l in 0..W {
        let system = lane(l);
        let inertia = system.inertia();
        let spread = |x: [Fused<f64>; 3]| from_fn(|k| x.get(k).map_or(0.0, |x| x.0));
        let positions: Vec<[f64; D]> = bodies.iter().map(|rotor| from_fn(|k| rotor.q[k].0[l].0)).collect();
        let momenta: Vec<[f64; D]> = bodies.iter().map(|rotor| spread(at(&rotor.way, l))).collect();
        let velocities: Vec<_> =
            momenta.iter().enumerate().map(|(body, p)| inertia.velocity(body, p)).collect();
        let given = Given { velocities: &velocities, ..rhythm.given(l, turn) };
        let seen = (Moment { time: rhythm.time_of(l, turn), positions: &positions }, &momenta[..], &[][..]);
        let during = given.interval(seen, inertia, None, (false, 3 * bodies.len()));
        let mut own = vec![[0.0; D]; bodies.len()];
        let effects = system.effects();
        effects.flow(turn.number, &during, &mut effects.room(own.len()), &mut own);
        for (to, change) in changes.iter_mut().zip(&own) {
            for (to, change) in to.iter_mut().zip(change) {
                to.0[l] = Fused(*change);
            }
        }
    }
}

/// Some steps of a row with flows, after so many.
pub(super) struct StirredSteps<'a, 'b, const W: usize> {
    pub(super) course: Course<'a, W>,
    pub(super) stirring: &'a RotorStirring<W>,
    /// The kick that follows the half of flows before a step.
    pub(super) kick: f64,
    pub(super) pulling: Option<&'a mut (dyn Pulling<RigidRow<Rotor<W>>, W> + 'b)>,
    pub(super) answer: &'a mut Answer<'b, W>,
    pub(super) bodies: &'a mut [Rotor<W>],
    /// Room for torques, and for what flows change.
    pub(super) kicks: &'a mut [Three<W>],
    /// The work of flows on each lane.
    pub(super) work: &'a mut [f64],
    pub(super) from: u64,
    pub(super) steps: u64,
}

impl<const W: usize> Work for StirredSteps<'_, '_, W> {
    type Done = Result<(), Stuck>;

    #[inline(always)]
    fn run(mut self) -> Result<(), Stuck> {
        if self.steps == 0 {
            return Ok(());
        }
        let (rhythm, from, end) = (&self.stirring.rhythm, self.from, self.from + self.steps);
        let (row, parts) = (Row::new(self.course), self.course.parts.len());
        let mut stepping = Stepping { row, steps: &mut self };
        if rhythm.renews && from == 0 {
            stepping.forget();
        }
        for steps in from..end {
            rhythm.step(&mut stepping, steps, parts)?;
        }
        if rhythm.renews { self.check() } else { finite(self.bodies) }
    }
}

impl<const W: usize> StirredSteps<'_, '_, W> {
    /// Whether attitudes and the torques there are numbers, momenta being forgotten.
    #[inline(always)]
    fn check(&mut self) -> Result<(), Stuck> {
        let Self { course, pulling, bodies, kicks, kick, .. } = self;
        kicks.fill([zeros(); 3]);
        if let Some(pulling) = pulling {
            pulling.pull(course.set, *kick, (bodies, kicks));
        }
        let rows = bodies.iter().flat_map(|rotor| &rotor.q).chain(kicks.iter().flatten());
        lost(rows).map_or(Ok(()), |lane| Err(Stuck::not_finite(lane)))
    }
}

/// Steps, and the row that takes them.
struct Stepping<'a, 'b, 'c, const W: usize> {
    steps: &'c mut StirredSteps<'a, 'b, W>,
    row: Row<'a, W>,
}

impl<const W: usize> InRhythm for Stepping<'_, '_, '_, W> {
    #[inline(always)]
    fn act(&mut self, when: When) -> Result<(), Stuck> {
        let StirredSteps { course, stirring, bodies, kicks: changes, work, answer, .. } = &mut *self.steps;
        let sums = course.sums;
        course.set.run(Acting { stirring, sums, when, bodies, changes, work, answer: *answer });
        Ok(())
    }

    #[inline(always)]
    fn lead(&mut self) -> Result<(), Stuck> {
        let StirredSteps { course, pulling, bodies, kicks, kick, .. } = &mut *self.steps;
        if let Some(pulling) = pulling
            && *kick != 0.0
        {
            pulling.pull(course.set, *kick, (bodies, kicks));
            add(course.sums, kicks, bodies);
        }
        Ok(())
    }

    #[inline(always)]
    fn advance(&mut self, part: usize, steps: u64) -> Result<(), Stuck> {
        let StirredSteps { stirring, bodies, kicks, pulling, .. } = &mut *self.steps;
        let renews = stirring.rhythm.renews;
        let unless_told = |of: Stuck| if of.failure.is_none() { Stuck::not_finite(of.lane) } else { of };
        let advanced = self.row.advance(part, steps + 1, bodies, kicks, pulling);
        if renews { advanced.map_err(unless_told) } else { advanced }
    }

    #[inline(always)]
    fn forget(&mut self) {
        let three = [zeros(); 3];
        for Rotor { way, way_low, guess, past, .. } in &mut *self.steps.bodies {
            (*way, *way_low, *guess, *past) = (three, three, three, [three; 2]);
        }
    }
}

/// Adds these to the ways of all bodies.
#[inline(always)]
fn add<const W: usize>(sums: bool, changes: &[Three<W>], bodies: &mut [Rotor<W>]) {
    for (rotor, change) in bodies.iter_mut().zip(changes) {
        push(sums, change, &mut rotor.way, &mut rotor.way_low);
    }
}

/// Has all flows act. Work by itself: it is long, and a step asks for it more than once.
struct Acting<'a, 'c, const W: usize> {
    stirring: &'a RotorStirring<W>,
    sums: bool,
    when: When,
    bodies: &'a mut [Rotor<W>],
    changes: &'a mut [Three<W>],
    work: &'a mut [f64],
    answer: &'a mut Answer<'c, W>,
}

impl<const W: usize> Work for Acting<'_, '_, W> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { stirring, sums, when, bodies, changes, work, answer } = self;
        let before = stirring.energy(bodies);
        for turn in stirring.rhythm.turns(stirring.flows.len(), when) {
            match &stirring.flows[turn.number] {
                Stir::Bath(bath) => {
                    for (body, (rotor, change)) in bodies.iter().zip(&mut *changes).enumerate() {
                        stirring.bathe(bath, turn, body, rotor, change);
                    }
                }
                Stir::Asked => answer(Question { turn, bodies }, changes),
            }
            add(sums, changes, bodies);
        }
        let after = stirring.energy(bodies);
        for (l, work) in work.iter_mut().enumerate() {
            *work += 0.5 * (after.0[l] - before.0[l]).0;
        }
    }
}
