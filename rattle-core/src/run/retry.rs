//! Steps that fail, in parts.

use crate::effect::interval::Half;
use crate::methods::able::view;
use crate::motion::method::Method;
use crate::motion::stir::{Chosen, draws, stir};
use crate::motion::system::System;
use crate::motion::witness::Hears;
use crate::number::clock::later;
use crate::run::seldom::part;
use crate::run::simulation::{Halving, MOST_HALVINGS, Simulation};
use crate::run::trouble::Trouble;

impl<Y: System<f64, D>, S: Method, const D: usize> Simulation<Y, S, D> {
    /// The same simulation, in which a step that fails is repeated in 2, 4, … 2^`halvings` equal parts.
    ///
    /// Only the step that fails is divided; after it, steps have their full length again. More than 16 halvings count
    /// as 16: a step that fails in 65 536 parts has reached an end of the motion, or is far too long. Without `retry`
    /// no step is ever divided, since a run with a divided step is no longer the iteration of one map, and at that step
    /// neither symplectic nor reversible.
    ///
    /// Random forces draw the numbers of the whole step, around all parts, in which other flows act; or in the middle
    /// of `Baoab`, whose free motion is made finer, as far as 65 536 parts go: if parts drew others, the bath would be
    /// too cold, since fast draws are those that fail. A method of one's own that has flows act [inside](Method::STIRS)
    /// its step, and names no [finer](Method::finer) one, is not divided where these are random.
    ///
    /// The memory of a method is reset before and after the parts, which allocates. Steps of staggered methods are not
    /// divided, since their momenta belong to one step size.
    ///
    /// ```
    /// # use rattle::{Rattle, Scene, State};
    /// let free = Scene::point().simulate(State::at([0.0]).moving([1.0]), Rattle::new(0.1))?;
    /// let mut simulation = free.retry(6);
    /// # simulation.step()?;
    /// # Ok::<(), rattle::Error>(())
    /// ```
    #[doc(alias = "subdivide")]
    #[doc(alias = "adaptive")]
    #[must_use]
    pub fn retry(mut self, halvings: u32) -> Self {
        self.halve(halvings);
        self
    }

    pub(crate) fn halve(&mut self, halvings: u32) {
        let most = halvings.min(MOST_HALVINGS);
        self.halving = (most > 0).then_some(Halving { most, take: Self::parts });
    }

    /// Takes a step in so many parts, with random numbers of the whole step if there are any.
    fn parts(&mut self, parts: u32, witness: &mut dyn Hears<f64>) -> Result<(), Trouble> {
        let (random, h) = (draws(&self.system), self.method.step_size());
        witness.forget();
        let (method, parts) = match self.method.finer(parts).filter(|_| random) {
            Some(finer) => (finer, 1),
            None => (self.method.with_step(h / f64::from(parts)), parts),
        };
        let around = const { !S::STIRS } && random;
        let inside = if around { Chosen::inside(&self.system) } else { Chosen::All };
        if random {
            self.bodies.noise = self.noise();
        }
        let seen = view(&method, &self.system)?;
        if around {
            stir(Chosen::Drawing, Half::Before, 0.5 * h, &self.system, &mut self.bodies)?;
        }
        let mut memory = method.memory_within(seen, &self.bodies, self.memory.as_ref());
        let (system, bodies) = (&self.system, &mut self.bodies);
        let mut before = bodies.saved();
        for _ in 0..parts {
            if let Some(taken) = part(&method, system, bodies, memory.as_mut(), witness, inside, &mut before)?
            {
                self.clock = later(self.clock, (taken, 0.0));
            }
        }
        if around {
            stir(Chosen::Drawing, Half::After, 0.5 * h, &self.system, &mut self.bodies)?;
        }
        self.memory = self.method.memory_within(seen, &self.bodies, self.memory.as_ref());
        Ok(())
    }
}
