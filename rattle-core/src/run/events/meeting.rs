//! Finding contacts: which gap closes first within a part of a step, and when.
//!
//! A gap is known, with its rate, at both ends of the stretch. It is suspect where it is negative at the end, or
//! falls at first and rises at last, and the tangents at the two ends meet below zero: a gap that bends upwards lies
//! above both. In steps so long that bodies go farther than their speeds at the ends tell, tangents are as much
//! steeper.
//!
//! ```text
//! root     s ← s − gap(s)/rate(s), in brackets, halved where that does not help        until 0 ≤ gap ≤ 2 τ
//! dip      s where the rate is zero by a straight line through both ends, until the tangents meet above zero
//! τ = ε Σ |∂gap/∂qᵢ| (|qᵢ| + way)                                                   the rounding of the gap
//! ```
//!
//! A gap that is a small difference of large terms, as x² + y² + (z + r)² − r², is rounded more coarsely than τ tells.
//! Then there may be no instant with 0 ≤ gap ≤ 2τ. Where no instant is left between a positive gap and a negative one,
//! the larger of the two is the noise of this gap, and it is closed within that for the rest of the step.
//!
//! Each try is a step of the method from the start of the stretch, so the instant is that of the method's own motion.
//! A gap that is closed at the start and opens is divided by the time: s = 0 is not the root that is sought.
//!
//! Where constraints hold a closed gap, as a rod does between balls as thick as it is long, what the gap and its rate
//! tell is rounding. Such a contact is left out of a stretch at whose end the gap has not really closed.

use crate::effect::contact::{Contacts, Gradient};
use crate::error::StepFailure;
use crate::kernel::rounding::rounding_of_g;
use crate::motion::bodies::Bodies;
use crate::motion::failure::Failure;
use crate::motion::method::Method;
use crate::motion::system::System;
use crate::number::vector::{add_scaled, dot, largest};
use crate::run::events::stretch::Stretch;
use crate::run::trouble::Trouble;
use crate::solve::aim::noise_of_terms;
use std::sync::Arc;

/// Contacts with gaps of less than so many roundings are closed; gaps are landed on to two.
pub(super) const TOUCHING: f64 = 64.0;
/// Newton's corrections until a bracket is halved at every second try.
const CORRECTIONS: u32 = 12;
/// Tries until a bracket has come to its rounding, or a dip to its bottom.
const TRIES: u32 = 128;
/// How much faster than at its ends a body may be within a stretch, for bodies to be near.
const FASTER: f64 = 1.25;
/// Rates of gaps are taken to be faster by no more than this.
const FASTEST: f64 = 4.0;

/// Which contact: of which kind, and its number there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct WhichContact {
    pub(super) kind: usize,
    pub(super) number: usize,
}

/// A contact at one instant.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    gap: f64,
    /// Of the gap, in the direction in which the run goes.
    rate: f64,
    /// The roundings of both.
    rounding: f64,
    slow: f64,
    /// The contact is closed at gaps up to this.
    touching: f64,
}

impl Look {
    fn touches(&self) -> bool {
        self.gap <= self.touching
    }
    /// The same of a gap with this noise.
    fn with_noise(self, noise: f64) -> Self {
        Self { rounding: self.rounding.max(noise), touching: self.touching.max(2.0 * noise), ..self }
    }
    /// Whether the contact is closed here, and no farther by the end, but for rounding.
    fn stays(&self, end: &Self) -> bool {
        self.touches() && end.gap >= self.gap.min(0.0) - self.touching
    }
    /// Whether the contact is closed and would open into the other body.
    pub(super) fn meets(&self) -> bool {
        self.touches() && self.rate < -self.slow
    }
}

/// A contact that may close within a stretch, as it is at both ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Suspect {
    pub(super) which: WhichContact,
    start: Look,
    end: Look,
    /// About when.
    about: f64,
}

impl Suspect {
    /// Whether the contact is closed where the stretch begins, and no farther by its end, but for rounding.
    pub(super) fn stays(&self) -> bool {
        self.start.stays(&self.end)
    }
}

/// Contacts, and the room to look at them.
#[derive(Debug, Clone)]
pub(in crate::run) struct Meetings<const D: usize> {
    pub(in crate::run) kinds: Vec<Arc<dyn Contacts<D>>>,
    /// Room of each kind.
    pub(in crate::run) rooms: Vec<Vec<usize>>,
    /// Those that can have closed in the stretch.
    pub(super) near: Vec<WhichContact>,
    /// Those that do not, though they look like it.
    cleared: Vec<WhichContact>,
    /// Those whose gaps are held by constraints where the stretch begins.
    pub(super) held: Vec<WhichContact>,
    /// Of gaps in this step that are rounded more coarsely than their gradients tell.
    pub(super) noises: Vec<(WhichContact, f64)>,
    found: Vec<usize>,
    pub(super) gradient: Gradient<D>,
    /// The farthest that a body goes in the step.
    way: f64,
    /// How much faster than at its ends, at most, a body was in this stretch.
    faster: f64,
    /// Impacts in the step.
    pub(super) impacts: u64,
    /// The smallest restitution of those.
    pub(super) restitution: f64,
}

impl<const D: usize> Meetings<D> {
    pub(in crate::run) fn none() -> Self {
        Self {
            kinds: Vec::new(),
            rooms: Vec::new(),
            near: Vec::new(),
            cleared: Vec::new(),
            held: Vec::new(),
            noises: Vec::new(),
            found: Vec::new(),
            gradient: Vec::new(),
            way: 0.0,
            faster: 1.0,
            impacts: 0,
            restitution: 1.0,
        }
    }

    /// Begins a step.
    pub(super) fn begin(&mut self) {
        (self.way, self.impacts, self.restitution) = (0.0, 0, 1.0);
        self.noises.clear();
    }

    /// Begins a stretch.
    pub(super) fn begin_stretch(&mut self) {
        self.cleared.clear();
        self.held.clear();
    }

    /// A contact as it is at these places; ∇gap is left in `gradient`.
    pub(super) fn look<Y: System<f64, D>, X>(
        &mut self,
        which: WhichContact,
        sign: f64,
        system: &Y,
        bodies: &Bodies<Y::Count, f64, X, D>,
    ) -> Look {
        self.gradient.clear();
        let q = bodies.q.as_ref();
        let gap = self.kinds[which.kind].gap(which.number, q, &mut self.gradient);
        let (mut rate, mut rounding, mut slow) = (0.0, 0.0, 0.0);
        for (body, gradient) in &self.gradient {
            let v = system.velocity(bodies, *body);
            rate += sign * dot(gradient, &v);
            for d in 0..D {
                rounding += gradient[d].abs() * (q[*body][d].abs() + self.way);
                slow += (gradient[d] * v[d]).abs();
            }
        }
        let (rounding, slow) = (f64::EPSILON * rounding, 4.0 * f64::EPSILON * slow);
        Look { gap, rate, rounding, slow, touching: TOUCHING * rounding }.with_noise(self.noise(which))
    }

    /// The noise of a gap, as far as it is known in this step.
    fn noise(&self, which: WhichContact) -> f64 {
        self.noises.iter().filter(|noise| noise.0 == which).fold(0.0, |most, noise| noise.1.max(most))
    }

    /// Finds the contacts that can have closed where no body went farther than `way`, more than before.
    pub(in crate::run) fn find_near(&mut self, q: &[[f64; D]], way: f64) {
        self.way = self.way.max(way);
        self.near.clear();
        for (kind, contacts) in self.kinds.iter().enumerate() {
            self.found.clear();
            contacts.near(q, way, &mut self.rooms[kind], &mut self.found);
            self.near.extend(self.found.iter().map(|&number| WhichContact { kind, number }));
        }
    }

    /// The contacts that were found near, by name and bodies, with their gaps in roundings below zero.
    pub(in crate::run) fn overlaps<Y: System<f64, D>, X>(
        &mut self,
        system: &Y,
        bodies: &Bodies<Y::Count, f64, X, D>,
    ) -> Option<(&'static str, Vec<usize>, f64)> {
        for i in 0..self.near.len() {
            let look = self.look(self.near[i], 1.0, system, bodies);
            let apart = look.gap >= -look.touching;
            if !apart && look.gap.abs() > self.noise_of_terms(self.near[i], bodies.q.as_ref()) {
                return Some((self.kinds[self.near[i].kind].name(), self.touched(), look.gap));
            }
        }
        None
    }

    /// The noise of the gap that was looked at last, as far as it does not follow its bodies along the gradient; as it
    /// is left in `gradient` again.
    #[cold]
    fn noise_of_terms(&mut self, which: WhichContact, q: &[[f64; D]]) -> f64 {
        let (normal, mut moved) = (self.gradient.clone(), q.to_vec());
        let length = normal.iter().map(|(_, n)| dot(n, n)).sum::<f64>().sqrt();
        let size = normal.iter().map(|(body, _)| largest(&q[*body])).fold(0.0, f64::max);
        let contacts = self.kinds[which.kind].clone();
        let mut gap = |shift: f64| {
            for (body, n) in &normal {
                moved[*body] = add_scaled(&q[*body], shift / length, n);
            }
            self.gradient.clear();
            contacts.gap(which.number, &moved, &mut self.gradient)
        };
        let here = gap(0.0);
        let mut bent = |shift: f64| ((gap(shift) - here) / length - shift).abs();
        let noise = noise_of_terms::<f64>(size, |size| rounding_of_g(size, f64::INFINITY, &mut bent));
        self.gradient = normal;
        noise * length
    }

    /// The bodies of the contact that was looked at last.
    fn touched(&self) -> Vec<usize> {
        self.gradient.iter().map(|(body, _)| *body).collect()
    }

    /// A failure of the contact that was looked at last, by its name and bodies.
    fn told(
        &self,
        which: WhichContact,
        cause: impl FnOnce(&'static str, Vec<usize>) -> StepFailure,
    ) -> Failure {
        let bodies = self.touched();
        Failure {
            body: bodies.first().copied().unwrap_or(0),
            cause: cause(self.kinds[which.kind].name(), bodies),
        }
    }

    /// The failure of a contact at which there is no end of impacts.
    #[cold]
    pub(super) fn rests(&mut self, which: WhichContact, q: &[[f64; D]]) -> Failure {
        self.gradient.clear();
        self.kinds[which.kind].gap(which.number, q, &mut self.gradient);
        let (impacts, restitution) = (self.impacts, self.kinds[which.kind].restitution());
        self.told(which, |contact, bodies| StepFailure::Rests { contact, bodies, impacts, restitution })
    }

    /// The failure of the contact that was looked at last, where there were as many impacts as a step may have: without
    /// end only where one of them took energy away.
    #[cold]
    pub(super) fn too_many(&self, which: WhichContact) -> Failure {
        let impacts = self.impacts;
        let restitution = self.restitution.min(self.kinds[which.kind].restitution());
        self.told(which, |contact, bodies| {
            if restitution < 1.0 {
                StepFailure::Rests { contact, bodies, impacts, restitution }
            } else {
                StepFailure::TooManyImpacts { contact, bodies, impacts }
            }
        })
    }

    /// The failure of the contact that was looked at last, of whose bodies constraints let none part.
    #[cold]
    pub(super) fn gives_no_way(&self, which: WhichContact) -> Failure {
        self.told(which, |contact, bodies| StepFailure::NoWayApart { contact, bodies })
    }

    /// The contact that seems to close first in a stretch of this length, at the end of which bodies are.
    pub(super) fn suspect<Y: System<f64, D>, S: Method>(
        &mut self,
        stretch: &Stretch<'_, Y, S, D>,
        length: f64,
    ) -> Result<Option<Suspect>, Trouble> {
        if self.kinds.is_empty() {
            return Ok(None);
        }
        let (system, start, end) = (stretch.system, &*stretch.start, &*stretch.bodies);
        let (mut way, mut faster) = (0.0_f64, 1.0_f64);
        for (body, (from, to)) in start.q.as_ref().iter().zip(end.q.as_ref()).enumerate() {
            let apart = add_scaled(to, -1.0, from);
            let speeds = [system.velocity(start, body), system.velocity(end, body)].map(|v| dot(&v, &v));
            let (gone, at_ends) = (dot(&apart, &apart), length * length * speeds[0].max(speeds[1]));
            way = way.max(gone).max(at_ends);
            if gone > faster * at_ends && at_ends > 0.0 {
                faster = gone / at_ends; // the square of it: the way is longer than its chord
            }
        }
        self.faster = faster.min(FASTEST);
        self.find_near(end.q.as_ref(), FASTER * way.sqrt());
        let mut first: Option<Suspect> = None;
        for i in 0..self.near.len() {
            let which = self.near[i];
            let [start, end] = [
                self.look(which, stretch.sign(), system, start),
                self.look(which, stretch.sign(), system, end),
            ];
            if end.gap.is_nan() {
                let position =
                    self.touched().iter().flat_map(|&body| stretch.bodies.q.as_ref()[body]).collect();
                let body = self.touched().first().copied().unwrap_or(0);
                return Err(Failure { body, cause: StepFailure::ConstraintNotFinite { position } }.into());
            }
            if self.held.contains(&which) && start.stays(&end) {
                continue;
            }
            let about = if start.meets() {
                0.0
            } else if closed(&start, &end) {
                length * start.gap.max(0.0) / (start.gap.max(0.0) - end.gap)
            } else if let Some(about) = dips(self.faster, [(0.0, &start), (length, &end)])
                && !self.cleared.contains(&which)
            {
                about
            } else {
                continue;
            };
            if first.is_none_or(|first| about < first.about) {
                first = Some(Suspect { which, start, end, about });
            }
        }
        Ok(first)
    }

    /// The instant at which a suspect meets, and bodies there; none if it does not after all, and then bodies are
    /// anywhere.
    pub(super) fn instant<Y: System<f64, D>, S: Method>(
        &mut self,
        stretch: &mut Stretch<'_, Y, S, D>,
        suspect: &Suspect,
        length: f64,
    ) -> Result<Option<f64>, Trouble> {
        let Suspect { which, start, end, .. } = *suspect;
        if start.meets() {
            stretch.go_back();
            return Ok(Some(0.0));
        }
        if closed(&start, &end) {
            return self.root(stretch, which, &start, (length, end));
        }
        let (mut low, mut high) = ((0.0, start), (length, end));
        for _ in 0..TRIES {
            let Some(_) = dips(self.faster, [(low.0, &low.1), (high.0, &high.1)]) else { break };
            let at = low.0 + (high.0 - low.0) * low.1.rate / (low.1.rate - high.1.rate);
            if !(low.0 < at && at < high.0) {
                break;
            }
            stretch.go(at)?;
            let look = self.look(which, stretch.sign(), stretch.system, stretch.bodies);
            if closed(&start, &look) {
                return self.root(stretch, which, &start, (at, look));
            }
            *(if look.rate < 0.0 { &mut low } else { &mut high }) = (at, look);
        }
        self.cleared.push(which);
        Ok(None)
    }

    /// The instant at which the gap is zero, from above, before it is negative; none where it was noise that closed it.
    fn root<Y: System<f64, D>, S: Method>(
        &mut self,
        stretch: &mut Stretch<'_, Y, S, D>,
        which: WhichContact,
        start: &Look,
        (mut high, end): (f64, Look),
    ) -> Result<Option<f64>, Trouble> {
        let opens = start.touches();
        if opens && start.rate <= start.slow {
            return Err(self.rests(which, stretch.bodies.q.as_ref()).into());
        }
        let level = if opens { start.gap } else { 0.0 };
        let (mut low, mut at, mut look) = (0.0, high, end);
        let [mut above, mut below] = [start.gap, end.gap].map(|gap| (gap - level).abs());
        for tried in 0..TRIES {
            // In the middle of what is landed on.
            let (gap, rate) = (look.gap - level - look.rounding, look.rate);
            let slope = if opens { rate - gap / at } else { rate };
            let newton = at - gap / slope;
            let halve = tried > CORRECTIONS && tried % 2 == 0;
            at = if low < newton && newton < high && !halve { newton } else { low + 0.5 * (high - low) };
            if at <= low || at >= high {
                break;
            }
            stretch.go(at)?;
            look = self.look(which, stretch.sign(), stretch.system, stretch.bodies);
            let gap = look.gap - level;
            if 0.0 <= gap && gap <= 2.0 * look.rounding {
                return Ok(Some(at));
            }
            if gap > 0.0 {
                (low, above) = (at, gap);
            } else {
                (high, below) = (at, -gap);
            }
        }
        // No instant is left in between: the last one before.
        let noise = above.max(below);
        self.noises.push((which, noise));
        if !closed(&start.with_noise(noise), &end.with_noise(noise)) {
            self.cleared.push(which);
            return Ok(None);
        }
        if low > 0.0 {
            stretch.go(low)?
        } else {
            stretch.go_back()
        }
        Ok(Some(low))
    }
}

/// Whether a contact has closed by the end.
fn closed(start: &Look, end: &Look) -> bool {
    let level = start.gap.min(0.0);
    end.gap < level - end.rounding || (end.gap < level && end.rate < -end.slow)
}

/// Where the tangents at two instants meet, with rates that are so much faster, if that is below zero.
fn dips(faster: f64, [(a, low), (b, high)]: [(f64, &Look); 2]) -> Option<f64> {
    let [falls, rises] = [low.rate, high.rate].map(|rate| faster * rate);
    if !(falls < 0.0 && rises > 0.0) {
        return None;
    }
    let after = ((high.gap - low.gap) - rises * (b - a)) / (falls - rises);
    (low.gap + falls * after < low.gap.min(0.0) - low.rounding).then_some(a + after)
}
