//! What trajectories of linked bodies obey, as a simulation does.

use crate::effect::list::{Effects, Forces};
use crate::effect::moment::Moment;
use crate::motion::bodies::{Body, Many};
use crate::motion::parts::{Given, Parts};
use crate::motion::state::State;
use crate::motion::witness::Witness;
use crate::number::lanes::{Fused, Lanes};
use crate::run::ensemble::forces_in_lanes::{Pulls, of_all, of_each};
use crate::run::ensemble::linked_going::{Wide, Width};
use crate::run::ensemble::linked_plan::{LinkedPlan, Links, masses};
use crate::run::ensemble::linked_row::LinkedRow;
use crate::run::ensemble::linked_stirring::{Question, RowStirring, vectors};
use crate::systems::linked::Linked;
use crate::systems::linked::kept::BodiesOf;
use crate::systems::network::in_lanes::{Numbers, ROW};
use crate::systems::network::{Network, constraints};
use std::array::from_fn;
use std::sync::Arc;

/// A network, what moves a lane of it as a simulation does, and the mass and 1 over it of each coordinate.
#[derive(Clone)]
pub(super) struct Law<F, const D: usize> {
    pub(super) network: Network<D>,
    pub(super) system: Arc<Linked<F, Many, D>>,
    pub(super) masses: Vec<[f64; 2]>,
    /// Whether the start wants an orthonormal basis, for which elimination stands in: bodies go by themselves.
    narrow: bool,
}

impl<F: Forces<f64, D>, const D: usize> Law<F, D> {
    /// None where they cannot go side by side. The linear algebra is that of this start, but for a basis.
    fn new<E: Effects<D, Forces<f64> = F>>(
        network: &Network<D>,
        effects: &E,
        start: &State<D>,
        h: f64,
    ) -> Option<Self> {
        let (count, forces) = (Many(start.len()), || effects.forces::<f64>());
        let ready = Linked::ready(network, forces(), count, start, h, false).ok()?;
        let narrow = ready.is_narrow();
        let system =
            if narrow { Linked::new(network.shape(start.len()).ok()?, forces(), count) } else { ready };
        let masses = masses(&system.shape)?;
        let wide = !system.is_narrow();
        wide.then(|| Self { network: network.clone(), system: Arc::new(system), masses, narrow })
    }

    /// Whether no link depends on others where these bodies are placed.
    fn is_independent(&self, plan: &LinkedPlan, placed: &BodiesOf<F, Many, D>) -> bool {
        self.system.freedom(placed) + plan.equations == plan.moving.len()
    }

    /// Effects, what they act on, and masses.
    pub(super) fn shown(&self) -> (&F, &Linked<F, Many, D>, &[[f64; 2]]) {
        (&self.system.effects, &self.system, &self.masses)
    }

    /// Whether elimination by this plan is enough for these bodies, in a system and as they are, in steps of this
    /// length: no link depends on others there, nor nearly. And what answers for them where they want a basis.
    pub(super) fn is_plain(
        &self,
        plan: &LinkedPlan,
        (placed, bodies): (&BodiesOf<F, Many, D>, &[Body<f64, D>]),
        h: f64,
    ) -> (bool, Narrow<F, D>) {
        let independent = self.is_independent(plan, placed);
        if plan.equations <= constraints::FEW {
            return (independent, None);
        }
        match self.ready(bodies, h) {
            Some(system) if system.is_narrow() => (false, Some(Arc::new(system))),
            system => (independent && system.is_some(), None),
        }
    }

    /// What moves these bodies as a simulation does, in steps of this length.
    pub(super) fn ready(&self, bodies: &[Body<f64, D>], h: f64) -> Option<Linked<F, Many, D>> {
        let none: [[f64; D]; 0] = [];
        let start = State { bodies: bodies.to_vec(), ..State::of(none) };
        let (effects, count) = (self.system.effects.clone(), Many(bodies.len()));
        Linked::ready(&self.network, effects, count, &start, h, false).ok()
    }
}

/// The system of bodies whose links nearly depend on each other, by an orthonormal basis; none where they do not.
pub(super) type Narrow<F, const D: usize> = Option<Arc<Linked<F, Many, D>>>;

/// What the lanes of a row obey.
#[derive(Clone)]
pub(super) struct LinkedLaws<F, const D: usize, const W: usize> {
    /// One for all lanes, or one for each.
    pub(super) laws: Vec<Law<F, D>>,
    pub(super) links: Links<W>,
    pub(super) pulls: Option<Box<dyn Pulls<LinkedRow, W>>>,
    /// 1 over the masses of all lanes, where they differ.
    pub(super) over: Option<Vec<Numbers<W>>>,
    /// Flows, or momenta that are drawn anew.
    pub(super) stirring: Option<Box<RowStirring<W>>>,
}

impl<F, const D: usize, const W: usize> LinkedLaws<F, D, W> {
    /// What a lane obeys.
    pub(super) fn law(&self, lane: usize) -> &Law<F, D> {
        &self.laws[self.number_of_law(lane)]
    }

    pub(super) fn number_of_law(&self, lane: usize) -> usize {
        if self.laws.len() == 1 { 0 } else { lane }
    }

    /// Whether all lanes obey the same.
    pub(super) fn alike(&self) -> bool {
        self.laws.len() == 1 && self.stirring.is_none()
    }

    /// Has lane `to` obey what lane `from` does.
    pub(super) fn copy(&mut self, from: usize, to: usize)
    where
        F: Clone,
    {
        let Self { laws, links, pulls, over, stirring } = self;
        if let Some(stirring) = stirring {
            stirring.copy(from, to);
        }
        if laws.len() == 1 {
            return;
        }
        laws[to] = laws[from].clone();
        links.copy(from, to);
        if let Some(pulls) = pulls {
            pulls.copy(from, to);
        }
        over.iter_mut().flatten().for_each(|over| over.0[to] = over.0[from]);
    }
}

impl<F: Forces<f64, D>, const D: usize, const W: usize> LinkedLaws<F, D, W>
where
    Width: Wide<W>,
{
    /// The same for all lanes: a network under these effects, with steps of this length from these starts. None where
    /// they cannot go side by side, as where all want a basis.
    pub(super) fn by_all<E: Effects<D, Forces<f64> = F>>(
        network: &Network<D>,
        effects: &E,
        (starts, h): (&[State<D>], f64),
        sums: bool,
    ) -> Option<(LinkedPlan, Self)> {
        let bodies = starts.first()?.len();
        let shape = network.shape(bodies).ok()?;
        let (plan, links) =
            (LinkedPlan::of(&shape, sums, false)?, Links::of(&shape, |_, group| Width::links(group))?);
        // That of a start without dependent links, if there is one: links are compared with what they were at first.
        let mut law: Option<Law<F, D>> = None;
        for start in starts {
            let of_start = Law::new(network, effects, start, h)?;
            if of_start.narrow {
                continue;
            }
            let placed = of_start.system.bodies(&start.bodies, start.time);
            let independent = of_start.is_independent(&plan, &placed);
            if law.is_none() || independent {
                law = Some(of_start);
            }
            if independent {
                break;
            }
        }
        let laws = vec![law?];
        Some((plan, Self { laws, links, pulls: of_all(effects, bodies), over: None, stirring: None }))
    }
}

impl<F: Forces<f64, D>, const D: usize> LinkedLaws<F, D, ROW> {
    /// For a sweep, each trajectory in a network and under effects of its own, of the same topology. Lanes beyond them
    /// obey what the first does.
    pub(super) fn by_each<E: Effects<D, Forces<f64> = F> + 'static>(
        networks: &[&Network<D>],
        effects: &[&E],
        (starts, h): (&[State<D>], f64),
        sums: bool,
    ) -> Option<(LinkedPlan, Self)> {
        let bodies = starts.first()?.len();
        let own = networks.iter().zip(effects).zip(starts);
        let laws = own.map(|((network, effects), start)| Law::new(network, *effects, start, h));
        let laws = laws.collect::<Option<Vec<_>>>()?;
        if laws.iter().all(|law| law.narrow) {
            return None;
        }
        let of = |lane: usize| if lane < laws.len() { lane } else { 0 };
        let pinned = |law: &Law<F, D>| law.masses.iter().map(|mass| mass[1] == 0.0).collect::<Vec<_>>();
        let first = &laws[0];
        if laws.iter().any(|law| {
            law.system.shape.groups.len() != first.system.shape.groups.len() || pinned(law) != pinned(first)
        }) {
            return None;
        }
        let apart = laws.iter().any(|law| law.masses != first.masses);
        let plan = LinkedPlan::of(&first.system.shape, sums, apart)?;
        let links = Links::of(&first.system.shape, |number, group| {
            let groups: Vec<_> = laws.iter().map(|law| &*law.system.shape.groups[number]).collect();
            group.swept(&groups)
        })?;
        let over = |c: usize| Lanes(from_fn(|lane| Fused(laws[of(lane)].masses[c][1])));
        let obeyed = Self {
            over: apart.then(|| (0..plan.coordinates).map(over).collect()),
            links,
            pulls: of_each(|lane| effects[of(lane)], bodies),
            stirring: None,
            laws: (0..ROW).map(|lane| laws[of(lane)].clone()).collect(),
        };
        Some((plan, obeyed))
    }
}

/// Writes what a flow changes the velocities of each lane by that is asked.
pub(super) fn answer<'a, F: Forces<f64, D>, const D: usize, const W: usize>(
    law: impl Fn(usize) -> &'a Law<F, D>,
    freedom: usize,
    stirring: &RowStirring<W>,
    Question { turn, lanes: asked, q, v }: Question<'_, W>,
    changes: &mut [Numbers<W>],
) {
    for lane in (0..W).filter(|&lane| asked[lane] != 0) {
        let Law { system, masses, .. } = law(lane);
        let [positions, velocities] = [q, v].map(|rows| vectors(rows, lane, |_, x| x.0));
        let momenta: Vec<[f64; D]> = vectors(v, lane, |c, x| masses[c][0] * x.0);
        let given = Given { velocities: &velocities, ..stirring.rhythm.given(lane, turn) };
        let time = stirring.rhythm.time_of(lane, turn);
        let seen = (Moment { time, positions: &positions }, &momenta[..], &[][..]);
        let during = given.interval(seen, system.inertia(), None, (system.equations() > 0, freedom));
        let mut own = vec![[0.0; D]; positions.len()];
        system.effects.flow(turn.number, &during, &mut system.effects.room(own.len()), &mut own);
        for ((to, change), [_, over]) in changes.iter_mut().zip(own.as_flattened()).zip(masses) {
            to.0[lane] = Fused(if *over == 0.0 { 0.0 } else { over * change });
        }
    }
}

/// Hears all multipliers of a step.
pub(super) struct Heard {
    /// Of the position and the momentum equation, by equation of the scene.
    pub(super) multipliers: [Vec<f64>; 2],
}

impl Heard {
    pub(super) fn of<F: Forces<f64, D>, const D: usize>(system: &Linked<F, Many, D>) -> Self {
        let equations = system.equations();
        Self { multipliers: [vec![0.0; equations], vec![0.0; equations]] }
    }
}

impl Witness<f64> for Heard {
    fn position_multiplier(&mut self, equation: usize, lambda: f64) {
        self.multipliers[0][equation] = lambda;
    }
    fn momentum_multiplier(&mut self, equation: usize, mu: f64) {
        self.multipliers[1][equation] = mu;
    }
}

/// Entries of all gradients at these places.
pub(super) fn gradients<F: Forces<f64, D>, const D: usize>(
    system: &Linked<F, Many, D>,
    q: &[[f64; D]],
) -> Vec<f64> {
    let shape = &*system.shape;
    let (mut g, mut rates) = (vec![0.0; shape.equations], vec![0.0; shape.equations]);
    let mut blocks = vec![[0.0; D]; shape.blocks];
    for (c, component) in shape.components.iter().enumerate() {
        shape.gradients(c, 0.0, q, &mut g, &mut blocks[component.first.1..], &mut rates);
    }
    blocks.as_flattened().to_vec()
}
