//! Rigid bodies in lanes.

use crate::error::Error;
use crate::motion::bodies::Body;
use crate::motion::record::{Hallmark, Reading, Record};
use crate::motion::system::System;
use crate::number::lanes::Fused;
use crate::run::answers::{Obeying, forces};
use crate::run::ensemble::block::Part;
use crate::run::ensemble::by_itself::split;
use crate::run::ensemble::engine::{Draws, Engine, Leg, Moved, OwnSteps, Stuck, Tour};
use crate::run::ensemble::forces_in_lanes::Pulling;
use crate::run::ensemble::lane_record::{read_all, write_all};
use crate::run::ensemble::linked_going::Width;
use crate::run::ensemble::rigid_going::Turns;
use crate::run::ensemble::rigid_law::RigidLaws;
use crate::run::ensemble::rigid_row::{Course, RigidRow, Rotor, Steps, Three, Weights, push};
use crate::run::ensemble::rigid_stirring::{Question, RotorStirring, StirredSteps, answer};
use crate::run::ensemble::splits::Splits;
use crate::run::fingerprint::{Looks, of_lane};
use crate::run::trouble::Trouble;
use crate::systems::network::in_lanes::{at, put, zeros};
use std::any::Any;
use std::array::from_fn;
use std::hint::black_box;
use std::sync::Arc;

/// A row of trajectories of rigid bodies, moved by a splitting. D is 9.
#[derive(Clone)]
pub(super) struct RigidLanes<Y, const D: usize, const W: usize> {
    laws: RigidLaws<Y, Rotor<W>, W>,
    bodies: Vec<Rotor<W>>,
    /// What stirs them, and the work of flows on each lane since the start; nothing without flows.
    stirring: Option<Box<RotorStirring<W>>>,
    work: Vec<f64>,
    method: Arc<Splits>,
    guesses: Arc<[Weights]>,
    /// The part of the method's step that comes next.
    part: usize,
}

impl<Y: System<f64, D>, const D: usize, const W: usize> RigidLanes<Y, D, W> {
    /// Lanes, none of them set, for so many bodies.
    pub(super) fn new(laws: RigidLaws<Y, Rotor<W>, W>, bodies: usize, method: Arc<Splits>) -> Self {
        Self {
            work: if const { Y::FLOWS > 0 } { vec![0.0; W] } else { Vec::new() },
            stirring: RotorStirring::of(|lane| laws.system(lane), &method).map(Box::new),
            laws,
            bodies: vec![Rotor::new(); bodies],
            guesses: Weights::of(&method.parts).into(),
            method,
            part: 0,
        }
    }

    fn course(&self) -> Course<'_, W> {
        let Self { laws, guesses, method, .. } = self;
        let Splits { parts, equal, sums, set, .. } = &**method;
        Course { inertia: &laws.inertia, parts, guesses, equal: *equal, sums: *sums, set: *set }
    }

    /// Momenta of all bodies times the unit of the part to come, and what rounding took from them: with the kick of
    /// that part taken back.
    fn ways(&self, bodies: &[Rotor<W>], part: usize) -> Vec<[Three<W>; 2]> {
        let Splits { parts, sums, set, .. } = &*self.method;
        let Part { unit, lead, .. } = parts[part];
        let mut ways: Vec<_> = bodies.iter().map(|rotor| [rotor.way, rotor.way_low]).collect();
        if lead != 0.0
            && let Some(pulls) = &self.laws.pulls
        {
            let mut kicks = vec![[zeros(); 3]; bodies.len()];
            pulls.begin().pull(*set, -unit * lead, (bodies, &mut kicks));
            for ([way, low], kick) in ways.iter_mut().zip(&kicks) {
                push(*sums, kick, way, low);
            }
        }
        ways
    }

    /// The bodies of a lane, with these momenta.
    fn bodies_of(
        &self,
        bodies: &[Rotor<W>],
        ways: &[[Three<W>; 2]],
        part: usize,
        lane: usize,
    ) -> Vec<Body<f64, D>> {
        let unit = self.method.parts[part].unit;
        let body = |(Rotor { q, q_low, .. }, [way, low]): (&Rotor<W>, &[Three<W>; 2])| {
            let [q, q_low] = [q, q_low].map(|q| at(q, lane));
            let momentum = |way: &Three<W>| from_fn(|k| if k < 3 { way[k].0[lane].0 / unit } else { 0.0 });
            let entries = |q: [_; 9]| {
                from_fn(|k| {
                    let Fused(x) = q[k];
                    x
                })
            };
            Body { q: entries(q), q_low: entries(q_low), p: momentum(way), p_low: momentum(low) }
        };
        bodies.iter().zip(ways).map(body).collect()
    }
}

impl<Y: System<f64, D>, const D: usize, const W: usize> Engine<D> for RigidLanes<Y, D, W>
where
    Width: Turns<W>,
{
    fn width(&self) -> usize {
        W
    }

    fn divides(&self) -> bool {
        self.method.renewal.is_none()
    }

    fn bodies_of_each(&self) -> usize {
        self.bodies.len()
    }

    fn go(&self, tour: &mut dyn Tour<D>) -> Result<Box<dyn Engine<D>>, Vec<Stuck>> {
        let (mut bodies, mut part, n) = (self.bodies.clone(), self.part, self.bodies.len());
        let mut room = self.laws.pulls.as_ref().map(|pulls| pulls.begin());
        let (mut kicks, mut work) = (vec![[zeros(); 3]; n], self.work.clone());
        while let Some(Leg { from, steps, written, .. }) = tour.next() {
            let (course, bodies, kicks) = (self.course(), &mut bodies[..], &mut kicks[..]);
            let pulling =
                room.as_deref_mut().map(|pulling| pulling as &mut dyn Pulling<RigidRow<Rotor<W>>, W>);
            if let Some(stirring) = &self.stirring {
                let answer = &mut |question: Question<'_, W>, changes: &mut [Three<W>]| {
                    if const { Y::FLOWS > 0 } {
                        answer(|lane| self.system(lane), &stirring.rhythm, question, changes);
                    }
                };
                let (work, kick) = (&mut work[..], self.method.stirred_kick);
                Width::stir(StirredSteps {
                    course,
                    stirring,
                    kick,
                    pulling,
                    answer,
                    bodies,
                    kicks,
                    work,
                    from,
                    steps,
                })?;
            } else {
                Width::turn(Steps { course, pulling, bodies, kicks, part: &mut part, from, steps })?;
            }
            if let Some(written) = written {
                let ways = self.ways(bodies, part);
                let now = (0..W).flat_map(|lane| self.bodies_of(bodies, &ways, part, lane));
                let now = now.collect::<Vec<_>>();
                written.fill(W * n, |i| now[i].q, |i| now[i].p);
            }
        }
        Ok(Box::new(Self { bodies, work, part, ..self.clone() }))
    }

    fn set(&mut self, lane: usize, bodies: &[Body<f64, D>]) -> bool {
        let (Part { h, unit, lead, .. }, before) =
            (self.method.parts[self.part], self.guesses[self.part].before);
        let (system, moments) = (self.system(lane), self.laws.inertia.lane(lane).map(|x| x.0));
        let mut ahead = system.bodies(bodies, 0.0);
        let (mut holds, mut numbers) = (system.settle(lead, h, &mut ahead, &mut ()).is_ok(), true);
        for (rotor, Body { q, q_low, p, p_low }) in self.bodies.iter_mut().zip(ahead.all()) {
            let three = |p: &[f64; D]| -> [f64; 3] { from_fn(|i| unit * p[i]) };
            let (way, low) = (three(&p), three(&p_low));
            let v = moments.ahead(&way.map(|x| h / unit * x));
            let x = moments.rotation(&v);
            holds &= x.is_some();
            numbers &= way.iter().sum::<f64>().is_finite();
            let rest = x.map_or([0.0; 3], |x| moments.rest(&v, &x));
            let sums = |x: f64| if self.method.sums { Fused(x) } else { Fused(0.0) };
            put(&mut rotor.q, lane, from_fn(|k| Fused(q[k])));
            put(&mut rotor.q_low, lane, from_fn(|k| sums(q_low[k])));
            put(&mut rotor.way, lane, way.map(Fused));
            put(&mut rotor.way_low, lane, low.map(sums));
            put(&mut rotor.guess, lane, rest.map(Fused));
            rotor.past.iter_mut().for_each(|past| put(past, lane, rest.map(|x| Fused(before * x))));
        }
        // Momenta of a start are nothing to a step that draws others.
        numbers && (holds || self.method.renewal.is_some())
    }

    fn copy(&mut self, from: usize, to: usize) {
        let rows = self.bodies.iter_mut().flat_map(Rotor::rows);
        rows.for_each(|row| row.0[to] = row.0[from]);
        if const { Y::FLOWS > 0 } {
            self.work[to] = self.work[from];
        }
    }

    fn obey(&mut self, from: usize, to: usize) {
        self.laws.copy(from, to);
        if let Some(stirring) = &mut self.stirring {
            stirring.copy(from, to);
        }
    }

    fn obey_as_in(&mut self, engine: &dyn Engine<D>) {
        if let Some(Self { laws, stirring, .. }) = (engine as &dyn Any).downcast_ref() {
            (self.laws, self.stirring) = (laws.clone(), stirring.clone());
        }
    }

    fn draw_as(&mut self, lane: usize, draws: Draws) {
        if let Some(stirring) = &mut self.stirring {
            stirring.rhythm.draw_as(lane, draws);
        }
    }

    fn work(&self, lane: usize) -> Option<f64> {
        self.work.get(lane).copied()
    }

    fn book(&mut self, lane: usize, work: f64) {
        if const { Y::FLOWS > 0 } {
            self.work[lane] = work;
        }
    }

    fn bodies(&self, lane: usize) -> Vec<Body<f64, D>> {
        self.bodies_of(&self.bodies, &self.ways(&self.bodies, self.part), self.part, lane)
    }

    fn by_itself(
        &self,
        lane: usize,
        bodies: &[Body<f64, D>],
        steps: OwnSteps,
        place: &mut u64,
    ) -> Result<Moved<D>, Trouble> {
        let rhythm = self.stirring.as_ref().map(|stirring| &stirring.rhythm);
        let of = (lane, self.work(lane));
        split(self.system(lane), &self.method, rhythm, of, bodies, steps, place)
    }

    fn kick_alone(&self, steps: u32) {
        let Some(pulls) = &self.laws.pulls else { return };
        let mut pulling = pulls.begin();
        let mut kicks = vec![[zeros(); 3]; self.bodies.len()];
        for _ in 0..steps * self.method.parts.len() as u32 {
            pulling.pull(self.method.set, 1e-9, (black_box(&self.bodies), &mut kicks));
        }
        black_box(kicks);
    }

    fn forces(&self) -> Vec<&'static str> {
        forces(self.system(0), &self.bodies(0))
    }

    fn record(&self, to: &mut Record) {
        write_all(&mut self.bodies.clone().iter_mut().flat_map(Rotor::rows).map(|row| &*row), to);
        to.counts("part", [self.part as u64]);
        if const { Y::FLOWS > 0 } {
            to.list("work", &self.work);
        }
    }

    fn recalled(&self, from: &mut Reading<'_>) -> Result<Box<dyn Engine<D>>, Error> {
        let mut again = self.clone();
        read_all(&mut again.bodies.iter_mut().flat_map(Rotor::rows), from)?;
        let [part] = from.counted("part")?;
        again.part = part as usize % self.method.parts.len();
        if const { Y::FLOWS > 0 } {
            again.work = from.numbers("work", &[W])?.to_vec();
        }
        Ok(Box::new(again))
    }

    fn hallmarks(&self, lane: usize, looks: &Looks<D>) -> Vec<Hallmark> {
        of_lane(self.system(lane), looks, self.step_size())
    }

    fn method(&self) -> Hallmark {
        self.method.hallmark()
    }
}

impl<Y: System<f64, D>, const D: usize, const W: usize> Obeying<D> for RigidLanes<Y, D, W> {
    type System = Y;

    fn system(&self, lane: usize) -> &Y {
        self.laws.system(lane)
    }

    fn step_size(&self) -> f64 {
        self.method.h
    }
}
