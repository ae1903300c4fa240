//! Events: instants inside a step at which momenta jump. The step is taken up to the instant, which is found to
//! rounding, the momenta are changed, and the rest of the step follows.
//!
//! ```text
//! Φ_h  becomes  Φ_{h−s} ∘ event ∘ Φ_s        s the first instant in (0, h] at which a gap closes or a normal jumps
//! ```
//!
//! Every try of an instant s is a step of the method from where the stretch began. An event is an [impact](impact) of a
//! [contact](crate::effect::contact), or the passage over an [edge](edge). Parts of a step are mirror images when
//! time runs back, so symmetric methods stay reversible, where impacts are elastic. Each event changes the lengths of
//! two steps: energy errors of the method then differ by their own size from stretch to stretch, and do no longer stay
//! on one shadow.
//!
//! There is no rest: where a restitution below 1, or a force against a closed contact, makes impacts without end, the
//! step fails with [`StepFailure::Rests`](crate::error::StepFailure::Rests), after 1000 impacts for each body at
//! most. What remains closed is a link. So many elastic impacts are too many for a step, not rest:
//! [`StepFailure::TooManyImpacts`](crate::error::StepFailure::TooManyImpacts).

mod edge;
mod impact;
mod meeting;
mod resolved;
mod stretch;

use crate::motion::method::Method;
use crate::motion::system::System;
use crate::number::clock::Parts;
use crate::run::trouble::Trouble;
use crate::run::watch::seen::Seen;
use edge::Edge;
pub(in crate::run) use meeting::Meetings;
use meeting::WhichContact;
pub(in crate::run) use stretch::Stretch;

/// Impacts in a step, for each body.
const MOST: u64 = 1000;
/// So many contacts in a row that are no impacts, each within this part of a step after the last, and bodies rest.
const IDLE: u32 = 64;
const SOON: f64 = 1e-9;
/// How often a stretch that cannot be gone is halved, in search of a contact before what hinders it; and one that is
/// gone, until its parts tell where bodies are in between.
const SHORTENED: u32 = 10;
/// A part has no more inner steps of its method than this: one in which a method tells its error by comparison is not
/// longer than half a period.
const FEW_INNER: u32 = 2;
/// Parts at first, at most.
const MOST_PARTS: u32 = 1 << 16;
/// Steps of methods of a higher order may be several periods long, if these do not follow roots in them: half of them
/// are looked at in any case.
const LOOKS_INSIDE: u32 = 12;

/// What is looked for.
#[derive(Debug)]
pub(in crate::run) struct Search<const D: usize> {
    pub(in crate::run) meetings: Meetings<D>,
    pub(in crate::run) over_kinks: bool,
    normals: [Vec<[f64; D]>; 2],
    /// Where momenta jumped in the last step, before it and after it, if anyone wants to know. Times are counted from
    /// the start of the step.
    pub(in crate::run) jumps: Option<Vec<[Seen<D>; 2]>>,
}

impl<const D: usize> Clone for Search<D> {
    #[inline(never)]
    fn clone(&self) -> Self {
        let (normals, jumps) = (self.normals.clone(), self.jumps.clone());
        Self { meetings: self.meetings.clone(), normals, jumps, ..*self }
    }
}

/// What is known of parts of a stretch.
enum Inside {
    Nothing,
    /// In this one something happens.
    Part(u32),
    /// They do not tell.
    Unknown,
}

/// What happens at an instant.
enum Event {
    /// Of this contact, and of others that are closed by then.
    Impacts(WhichContact),
    Edge(Edge),
}

impl<const D: usize> Search<D> {
    pub(in crate::run) fn among(bodies: usize) -> Self {
        let normals = [(); 2].map(|()| vec![[0.0; D]; bodies]);
        Self { meetings: Meetings::none(), over_kinks: false, normals, jumps: None }
    }

    /// Takes the step apart at its events, after it `went` as a whole; says how many there were.
    pub(in crate::run) fn meet<Y: System<f64, D>, S: Method>(
        &mut self,
        stretch: &mut Stretch<'_, Y, S, D>,
        mut went: Result<(), Trouble>,
    ) -> Result<u64, Trouble> {
        let whole = stretch.method.step_size().abs();
        let most = MOST * self.normals[0].len() as u64;
        let (mut parts, mut number, mut idle) = (Parts::of(whole, 0.0), 0, 0);
        self.meetings.begin();
        loop {
            let Some((event, after)) = self.first(stretch, parts.left(), went)? else { return Ok(number) };
            let before = self.jumps.as_ref().map(|_| stretch.seen(parts.time() + after));
            let earlier = number;
            number += match event {
                Event::Impacts(which) => {
                    let impacts = impact::impacts(&mut self.meetings, stretch, most - number)?;
                    idle = if impacts == 0 && after <= SOON * whole { idle + 1 } else { 0 };
                    if (impacts == 0 && after == 0.0) || idle > IDLE {
                        return Err(self.meetings.rests(which, stretch.bodies.q.as_ref()).into());
                    }
                    impacts
                }
                Event::Edge(edge) if number == most => return Err(edge.failure.into()),
                Event::Edge(edge) => {
                    parts.go(edge::cross(stretch, edge, &mut self.normals)?);
                    idle = 0;
                    1
                }
            };
            parts.go(after);
            if let (Some(jumps), Some(before)) = (&mut self.jumps, before)
                && number > earlier
            {
                jumps.push([before, stretch.seen(parts.time())]);
            }
            stretch.begin();
            if parts.left() <= f64::EPSILON * whole {
                return Ok(number);
            }
            went = stretch.go(parts.left());
        }
    }

    /// The first event of a stretch of this length, and when it comes; bodies are then there, or, without one, at the
    /// end.
    fn first<Y: System<f64, D>, S: Method>(
        &mut self,
        stretch: &mut Stretch<'_, Y, S, D>,
        length: f64,
        went: Result<(), Trouble>,
    ) -> Result<Option<(Event, f64)>, Trouble> {
        if went.is_ok() && self.is_long(stretch, length) {
            self.first_in_parts(stretch, length)
        } else {
            self.first_in_one(stretch, length, went, true)
        }
    }

    /// Whether contacts are to be looked for inside a stretch that was gone.
    fn is_long<Y: System<f64, D>, S: Method>(
        &mut self,
        stretch: &mut Stretch<'_, Y, S, D>,
        length: f64,
    ) -> bool {
        let inside = !S::HAS_STRUCTURE && stretch.method.order() > LOOKS_INSIDE;
        !self.meetings.kinds.is_empty() && (inside || !self.is_resolved(stretch, length))
    }

    /// The same of a stretch whose ends do not tell where bodies are in between: parts are gone that do, half as long
    /// and half again. Where nothing happens in them, bodies are put back to the end, and it is as if nobody had
    /// looked.
    #[cold]
    #[inline(never)]
    fn first_in_parts<Y: System<f64, D>, S: Method>(
        &mut self,
        stretch: &mut Stretch<'_, Y, S, D>,
        length: f64,
    ) -> Result<Option<(Event, f64)>, Trouble> {
        let (noise, noise_at_end, gone_in) = (stretch.noise, stretch.bodies.noise, stretch.parts);
        let known = self.meetings.noises.len();
        let [.., start, end] = &mut *stretch.aside;
        stretch.system.put_aside(stretch.start, start);
        stretch.system.put_aside(stretch.bodies, end);
        // In halves at least as often as the whole, and no more often: parts are as short as those it went in.
        let (inner, gone) = (stretch.bodies.inner_steps().div_ceil(FEW_INNER), stretch.parts());
        let least = inner.saturating_mul(gone).clamp(2, MOST_PARTS).ilog2();
        let most = *stretch.halvings.end();
        let halvings = std::mem::replace(&mut stretch.halvings, 0..=most);
        let last = (least + SHORTENED).min(MOST_PARTS.ilog2()).max(least);
        for halved in least..=last {
            let part = length / f64::from(1_u32 << halved);
            stretch.begin_again(noise);
            stretch.heard = false;
            let found = self.part_of_event(stretch, part, 1 << halved, halved < last);
            stretch.heard = true;
            let number = match found {
                Inside::Nothing => break,
                Inside::Unknown => continue,
                Inside::Part(number) => number,
            };
            // Once more, for those who hear of every part.
            stretch.begin_again(noise);
            for _ in 0..number {
                stretch.go(part)?;
                stretch.begin();
            }
            let went = stretch.go(part);
            if let Some((event, after)) = self.first_in_one(stretch, part, went, false)? {
                stretch.halvings = halvings;
                return Ok(Some((event, f64::from(number) * part + after)));
            }
        }
        self.meetings.noises.truncate(known);
        stretch.halvings = halvings;
        stretch.begin_again(noise);
        stretch.system.put_back(stretch.bodies, &stretch.aside[3]);
        (stretch.bodies.noise, stretch.parts) = (noise_at_end, gone_in);
        Ok(None)
    }

    /// In which of the parts from here on something happens first.
    fn part_of_event<Y: System<f64, D>, S: Method>(
        &mut self,
        stretch: &mut Stretch<'_, Y, S, D>,
        part: f64,
        parts: u32,
        asks: bool,
    ) -> Inside {
        for number in 0..parts {
            let went = stretch.go(part);
            if went.is_ok() && asks && !self.is_resolved(stretch, part) {
                return Inside::Unknown;
            }
            match self.first_in_one(stretch, part, went, false) {
                Ok(None) => stretch.begin_unheard(),
                Ok(Some(_)) => return Inside::Part(number),
                // Of a part alone: the whole was gone.
                Err(_) => return Inside::Unknown,
            }
        }
        Inside::Nothing
    }

    /// The first event of a stretch whose ends tell where bodies are in between, or that could not be gone. Of one that
    /// is `whole` what is before that is looked at in parts, if need be.
    fn first_in_one<Y: System<f64, D>, S: Method>(
        &mut self,
        stretch: &mut Stretch<'_, Y, S, D>,
        mut length: f64,
        went: Result<(), Trouble>,
        whole: bool,
    ) -> Result<Option<(Event, f64)>, Trouble> {
        match went {
            Ok(()) => self.first_contact(stretch, length),
            Err(trouble) => {
                let found = if self.over_kinks { edge::edge(stretch, length)? } else { None };
                if let Some((edge, after)) = found {
                    let before = if whole && self.is_long(stretch, after) {
                        self.first_in_parts(stretch, after)?
                    } else {
                        self.first_contact(stretch, after)?
                    };
                    Ok(before.or(Some((Event::Edge(edge), after))))
                } else {
                    // What hinders may lie behind a contact.
                    let mut clear = 0.0;
                    for _ in 0..SHORTENED {
                        let middle = 0.5 * (clear + length);
                        if stretch.go(middle).is_err() {
                            length = middle;
                            continue;
                        }
                        let found = if whole && self.is_long(stretch, middle) {
                            self.first_in_parts(stretch, middle)?
                        } else {
                            self.first_contact(stretch, middle)?
                        };
                        if found.is_some() {
                            return Ok(found);
                        }
                        clear = middle;
                    }
                    Err(trouble)
                }
            }
        }
    }

    /// The first contact of a stretch of this length, at the end of which bodies are, and when it comes; bodies are
    /// then there, or, without one, at the end.
    fn first_contact<Y: System<f64, D>, S: Method>(
        &mut self,
        stretch: &mut Stretch<'_, Y, S, D>,
        mut end: f64,
    ) -> Result<Option<(Event, f64)>, Trouble> {
        self.meetings.begin_stretch();
        let mut first = None;
        while let Some(contact) = self.meetings.suspect(stretch, end)? {
            let held = contact.stays() && impact::holds(&mut self.meetings, contact.which, stretch)?;
            if held {
                self.meetings.held.push(contact.which);
                stretch.go(end)?;
            } else if let Some(instant) = self.meetings.instant(stretch, &contact, end)? {
                (first, end) = (Some((Event::Impacts(contact.which), instant)), instant);
            } else {
                stretch.go(end)?;
            }
            if end <= 0.0 {
                break;
            }
        }
        Ok(first)
    }
}
