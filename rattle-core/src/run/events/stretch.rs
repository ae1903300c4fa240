//! A stretch of a step: from where it begins, made for any length.

use crate::effect::interval::Half;
use crate::effect::noise::Noise;
use crate::methods::able::view;
use crate::motion::bodies::Saved;
use crate::motion::course::check;
use crate::motion::method::Method;
use crate::motion::parts::BodiesOf;
use crate::motion::stir::{Chosen, stir};
use crate::motion::system::System;
use crate::motion::witness::Hears;
use crate::run::seldom::{part, seldom};
use crate::run::trouble::Trouble;
use crate::run::watch::seen::{Seen, write};
use std::ops::RangeInclusive;

/// A stretch of a step. Lengths are positive, whichever way time runs.
pub(in crate::run) struct Stretch<'a, Y: System<f64, D>, S: Method, const D: usize> {
    pub(in crate::run) system: &'a Y,
    pub(in crate::run) method: &'a S,
    /// Where the last try has led.
    pub(in crate::run) bodies: &'a mut BodiesOf<Y, f64, D>,
    /// Where the stretch begins.
    pub(in crate::run) start: &'a mut Saved<Y::Count, f64, D>,
    /// Which random numbers come first there.
    pub(in crate::run) noise: Noise,
    /// Room for two more places, and for both ends of a stretch that is looked at in parts.
    pub(in crate::run) aside: &'a mut [Saved<Y::Count, f64, D>; 4],
    pub(in crate::run) witness: &'a mut dyn Hears<f64>,
    /// Whether the witness hears of what is tried.
    pub(in crate::run) heard: bool,
    /// How often a try is halved at least, and where it fails at most.
    pub(in crate::run) halvings: RangeInclusive<u32>,
    /// Which flows act inside it, and not around the whole step.
    pub(in crate::run) flows: Chosen,
    /// In how many parts the last try went; none if nothing was tried but the whole step.
    pub(in crate::run) parts: Option<u32>,
}

impl<Y: System<f64, D>, S: Method, const D: usize> Stretch<'_, Y, S, D> {
    /// The way time runs, 1 or −1.
    pub(super) fn sign(&self) -> f64 {
        self.method.step_size().signum()
    }

    /// In how many parts the last try went.
    pub(super) fn parts(&self) -> u32 {
        self.parts.unwrap_or(1)
    }

    /// In how many inner steps of the method it went, if each part took as many as the last.
    pub(super) fn inner_steps(&self) -> u32 {
        self.bodies.inner_steps().saturating_mul(self.parts())
    }

    /// Goes this far from the start: in one step, or in parts if that is allowed and needed. The method remembers
    /// nothing of what was before.
    pub(in crate::run) fn go(&mut self, length: f64) -> Result<(), Trouble> {
        let (least, most) = (*self.halvings.start(), *self.halvings.end());
        let mut went = self.go_in_parts(length, 1 << least);
        for halved in least + 1..=most {
            if went.is_ok() {
                break;
            }
            went = self.go_in_parts(length, 1 << halved);
        }
        went.map_err(|trouble| trouble.halved(most))
    }

    /// Has flows that draw random numbers act before the whole step and after it, and events meet between: a contact
    /// does not choose the noise that led to it.
    pub(in crate::run) fn between_flows(
        &mut self,
        meet: impl FnOnce(&mut Self, Result<(), Trouble>) -> Result<u64, Trouble>,
    ) -> Result<u64, Trouble> {
        let h = self.method.step_size();
        self.go_back();
        stir(Chosen::Drawing, Half::Before, 0.5 * h, self.system, self.bodies)?;
        self.begin();
        let went = self.go(h.abs());
        let met = meet(self, went)?;
        stir(Chosen::Drawing, Half::After, 0.5 * h, self.system, self.bodies)?;
        Ok(met)
    }

    fn go_in_parts(&mut self, length: f64, parts: u32) -> Result<(), Trouble> {
        self.go_back();
        self.parts = Some(parts);
        let whole = self.method.with_step(self.sign() * length);
        let method =
            if parts == 1 { whole.clone() } else { whole.with_step(whole.step_size() / f64::from(parts)) };
        let mut memory = method.memory(view(&method, self.system)?, self.bodies);
        let witness: &mut dyn Hears<f64> = if self.heard { &mut *self.witness } else { &mut () };
        if parts == 1 {
            seldom(&method, self.system, self.bodies, memory.as_mut(), witness, self.flows)?;
            return Ok(check::<S, _, _, D>(whole.step_size(), self.system, self.start, self.bodies)?);
        }
        let mut before = self.bodies.saved();
        for _ in 0..parts {
            part(&method, self.system, self.bodies, memory.as_mut(), witness, self.flows, &mut before)?;
        }
        Ok(())
    }

    /// Back to where it begins.
    pub(super) fn go_back(&mut self) {
        if self.heard {
            self.witness.forget();
        }
        self.system.put_back(self.bodies, self.start);
        self.bodies.noise = self.noise;
    }

    /// What is seen of bodies this far from the start of the step.
    pub(super) fn seen(&self, passed: f64) -> Seen<D> {
        let (q, p) = (self.bodies.q.as_ref(), self.bodies.p.as_ref());
        let mut seen = Seen::new(0, 1, q.len(), |page| {
            page.times[0] = self.sign() * passed;
            write(q, page.positions);
            write(p, page.momenta);
        });
        seen.corrections = self.system.corrections(self.bodies);
        seen
    }

    /// Begins anew where bodies are.
    pub(super) fn begin(&mut self) {
        self.begin_unheard();
        self.witness.keep();
    }

    /// The same, where it is not known yet whether the way so far will be gone.
    pub(super) fn begin_unheard(&mut self) {
        self.system.put_aside(self.bodies, self.start);
        self.noise = self.bodies.noise;
    }

    /// Begins where a stretch began that is looked at in parts, with these random numbers first.
    pub(super) fn begin_again(&mut self, noise: Noise) {
        self.system.put_aside(&self.aside[2], self.start);
        self.noise = noise;
    }
}
