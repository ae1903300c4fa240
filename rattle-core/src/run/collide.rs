//! Events inside steps: collisions, and edges of constraints.

use crate::effect::contact::Contacts;
use crate::error::{Error, StepFailure};
use crate::methods::able::view;
use crate::motion::failure::Failure;
use crate::motion::method::Method;
use crate::motion::stir::{Chosen, draws};
use crate::motion::system::System;
use crate::motion::witness::Hears;
use crate::run::events::{Search, Stretch};
use crate::run::simulation::{Events, Simulation};
use crate::run::trouble::Trouble;
use std::sync::Arc;

impl<Y: System<f64, D>, S: Method, const D: usize> Simulation<Y, S, D> {
    /// The same simulation with collisions: [`HardSpheres`](crate::effect::HardSpheres), a
    /// [`Stop`](crate::effect::Stop), or [`Contacts`] of your own.
    ///
    /// The step in which a gap closes is taken up to the instant of contact, which is found to the rounding of the gap.
    /// There momenta change by the impulse of the contact, and the rest of the step follows. Contacts that close at the
    /// same instant are handled in the order in which they were given. A fast body does not pass through another: the
    /// gap is searched for a zero wherever its tangents at the two ends of a step meet below zero (see [`Contacts`]).
    /// Where velocities at the ends of a step do not tell where bodies go in between, as where they go round within a
    /// long step of [`Dop853`](crate::methods::dop853::Dop853), it is searched in parts that are short enough.
    ///
    /// Impulses respect constraints and masses. Elastic impulses conserve the kinetic energy to rounding; the energy
    /// lost in others counts as negative [`work`](Self::work), and what moving constraints do in an impact as work.
    /// [`StepFailure::NoWayApart`] where constraints let nobody part. Bodies that constraints hold in touch, as rods do
    /// balls as thick as rods are long, do not meet. [`events`](Self::events) counts impacts. Where a contact would
    /// stay closed, like that of a ball at rest on a floor, the step fails with [`StepFailure::Rests`]; a step with
    /// more elastic impacts than 1000 for each body fails with [`StepFailure::TooManyImpacts`].
    ///
    /// Random forces act before the whole step and after it, whatever happens between: a contact does not choose among
    /// them. Inside of them other flows act before and after each stretch between contacts.
    /// [`SelfPropulsion`](crate::effect::SelfPropulsion) counts as random: so bodies that it presses against a wall
    /// stay there, where a force within stretches would have them bounce ever more often. By `Baoab`, which has random
    /// forces in the middle, nothing collides where they are.
    ///
    /// Contacts are not part of a [`State`](crate::motion::state::State): call `collide` again after a restart. In a
    /// step with events [`retry`](Self::retry) divides the parts between events, and
    /// [`check_reversal`](Self::check_reversal) does not check.
    ///
    /// # Errors
    /// [`Error::Overlap`] for bodies that overlap at the start, [`Error::Restitution`], [`Error::Diameter`] and
    /// [`Error::Network`] for contacts that make no sense, [`Error::NoEvents`] for staggered methods, methods with
    /// steps of their own length, rigid bodies and phase space, and for contacts that lose energy where the step size
    /// is negative.
    #[doc(alias = "bounce")]
    #[doc(alias = "billiard")]
    #[doc(alias = "hard spheres")]
    #[doc(alias = "contact")]
    #[doc(alias = "collision")]
    pub fn collide(mut self, contacts: impl Contacts<D>) -> Result<Self, Error> {
        self.takes_events()?;
        contacts.check(self.bodies())?;
        if self.step_size() < 0.0 && contacts.restitution() < 1.0 {
            let why = "its steps lead back in time, where an impact of a restitution below 1 is not undone";
            return Err(Error::NoEvents { who: self.method.name(), why });
        }
        let mut alone = Search::among(self.bodies());
        let contacts: Arc<dyn Contacts<D>> = Arc::new(contacts);
        let search = &mut alone.meetings;
        search.kinds.push(contacts.clone());
        search.rooms.push(Vec::new());
        search.find_near(self.bodies.q.as_ref(), 0.0);
        if let Some((contact, bodies, gap)) = search.overlaps(&self.system, &self.bodies) {
            return Err(Error::Overlap { contact, bodies, gap });
        }
        let meetings = &mut self.with_events().search.meetings;
        meetings.kinds.push(contacts);
        meetings.rooms.push(Vec::new());
        Ok(self)
    }

    /// The same simulation, whose steps cross edges (kinks) of a constraint. Without this a step that meets an edge
    /// fails with [`StepFailure::Kink`]. The step is taken up to the edge; there the momentum is rotated about the edge
    /// into the new side. The component along the edge and the size of the component across it are unchanged, so energy
    /// is conserved to rounding, and a free particle moves along a straight line if the two sides are unfolded into a
    /// plane. Where two edges meet, or the surface ends, the step still fails.
    ///
    /// ```
    /// use rattle::prelude::*;
    ///
    /// constraint! { struct Roof {} |x, _y, z| z + abs(x) }
    ///
    /// let start = State::at([-1.0, 0.0, -1.0]).moving([1.0, 0.5, 1.0]);
    /// let mut simulation = Scene::on(Roof {}).simulate(start, Rattle::new(0.03))?.over_kinks()?;
    /// simulation.run(100)?; // up to the ridge at t = 1, and down on the other side
    /// let (q, p) = (simulation.position(), simulation.momentum());
    /// assert!((q.x - 2.0).abs() < 1e-14 && (q.y - 1.5).abs() < 1e-14 && (p.z + 1.0).abs() < 1e-14);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::NoEvents`] as [`collide`](Self::collide), and where constraints or forces change with time.
    #[doc(alias = "edge")]
    #[doc(alias = "non-smooth")]
    pub fn over_kinks(mut self) -> Result<Self, Error> {
        self.takes_events()?;
        if self.system.moves_with_time() {
            let why = "an edge is taken where constraints and forces do not change with time";
            return Err(Error::NoEvents { who: self.system.kind(), why });
        }
        self.with_events().search.over_kinks = true;
        Ok(self)
    }

    fn takes_events(&self) -> Result<(), Error> {
        let (method, system) = (self.method.name(), self.system.kind());
        if self.method.momentum_delay() != 0.0 {
            return Err(Error::NoEvents {
                who: method,
                why: "its momenta are of another time than its places",
            });
        }
        if let Some(why) = self.method.undivided() {
            return Err(Error::NoEvents { who: method, why });
        }
        if const { S::STIRS } && draws(&self.system) {
            return Err(Error::NoEvents {
                who: method,
                why: "random forces act in the middle of its steps; by Rattle they act before and after them",
            });
        }
        if self.method.time_taken(self.memory.as_ref()).is_some() {
            return Err(Error::NoEvents { who: method, why: "it chooses the lengths of its steps" });
        }
        if !self.system.is_cartesian() || self.system.rates().is_err() {
            return Err(Error::NoEvents { who: system, why: "momenta are not mass times velocity" });
        }
        Ok(())
    }

    /// Has the contacts and edges of another simulation happen in the steps of this one, which has none yet.
    pub(in crate::run) fn meet_what(&mut self, other: &Self) {
        let Some(theirs) = &other.events else { return };
        let Search { meetings, over_kinks, .. } = &theirs.search;
        let (kinds, over_kinks) = (meetings.kinds.clone(), *over_kinks);
        let own = &mut self.with_events().search;
        own.meetings.rooms = vec![Vec::new(); kinds.len()];
        (own.meetings.kinds, own.over_kinks) = (kinds, over_kinks);
    }

    /// Takes the step just made apart where something happens inside it; in parts, as often halved as is allowed, where
    /// the way back does not lead to where it began.
    fn meet(&mut self, stepped: Result<(), Failure>, witness: &mut dyn Hears<f64>) -> Result<(), Error> {
        let halvings = self.most_halvings();
        let mut met = self.meet_halved(0, Some(stepped.map_err(Trouble::from)), witness);
        for least in 1..=halvings {
            if !matches!(met, Err(Trouble::NotReversed { .. })) {
                break;
            }
            self.put_back();
            met = self.meet_halved(least, None, witness);
        }
        met.map_err(|mut trouble| {
            self.put_back();
            self.explain(&mut trouble);
            trouble.told(self.steps + 1, self.time())
        })
    }

    /// Takes a step apart where something happens inside it, each stretch in halves at least so often; it is the one
    /// that went so, or is made.
    fn meet_halved(
        &mut self,
        least: u32,
        went: Option<Result<(), Trouble>>,
        witness: &mut dyn Hears<f64>,
    ) -> Result<(), Trouble> {
        let (noise, most) = (self.noise(), self.most_halvings());
        let Some(events) = self.events.as_deref_mut() else { return Ok(()) };
        let Events { search, start, aside, .. } = events;
        self.system.put_aside(&self.before, start);
        let (system, method, bodies) = (&self.system, &self.method, &mut self.bodies);
        let (flows, halvings, parts, heard) = (Chosen::inside(system), least..=most, None, true);
        let mut stretch =
            Stretch { system, method, bodies, start, noise, aside, witness, heard, halvings, flows, parts };
        let number = match flows {
            Chosen::All => {
                // An edge that is to be crossed is found in the whole step.
                let divides = |failure: &Failure| {
                    most > 0 && !(search.over_kinks && matches!(failure.cause, StepFailure::Kink { .. }))
                };
                let went = went
                    .filter(|went| !matches!(went, Err(Trouble::Failed { failure, .. }) if divides(failure)));
                let went = went.unwrap_or_else(|| stretch.go(method.step_size().abs()));
                search.meet(&mut stretch, went)
            }
            _ => stretch.between_flows(|stretch, went| search.meet(stretch, went)),
        }?;
        let parts = stretch.parts;
        events.number += number;
        if parts.is_some() {
            self.memory = self.method.memory(view(&self.method, &self.system)?, &self.bodies);
        }
        if number == 0 { self.compare(parts.unwrap_or(1)) } else { Ok(()) }
    }

    fn with_events(&mut self) -> &mut Events<Y, S, D> {
        let bodies = self.bodies();
        self.goes_again = true;
        self.events.get_or_insert_with(|| {
            let (start, aside) = (self.before.clone(), [(); 4].map(|()| self.before.clone()));
            Box::new(Events { meet: Self::meet, search: Search::among(bodies), number: 0, start, aside })
        })
    }
}
