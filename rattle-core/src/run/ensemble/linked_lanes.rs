//! Linked bodies in lanes.

use crate::effect::list::{Effects, Forces};
use crate::error::Error;
use crate::motion::bodies::{Body, Many};
use crate::motion::failure::Failure;
use crate::motion::record::{Hallmark, Reading, Record};
use crate::motion::state::State;
use crate::motion::system::System;
use crate::motion::witness::{Whoever, Witness};
use crate::number::lanes::{Fused, Lanes};
use crate::run::answers::{Obeying, forces};
use crate::run::ensemble::block::Part;
use crate::run::ensemble::engine::{Engine, Leg, Moved, Stuck, Tour};
use crate::run::ensemble::forces_in_lanes::{Pulling, Pulls, of_all, of_each};
use crate::run::ensemble::linked_going::{Steps, Velocities, Wide, Width};
use crate::run::ensemble::linked_row::{Course, Landed, LinkedRow, at_rest};
use crate::run::ensemble::plan::{Links, Places, Plan, masses};
use crate::run::ensemble::splitting_lanes::{Splits, by_itself};
use crate::run::fingerprint::of_system;
use crate::systems::linked::Linked;
use crate::systems::linked::kept::BodiesOf;
use crate::systems::network::in_lanes::{Numbers, ROW, zeros};
use crate::systems::network::shape::Shape;
use crate::systems::network::{Network, constraints};
use std::any::Any;
use std::array::from_fn;
use std::hint::black_box;
use std::sync::Arc;

/// What all rows of an ensemble have in common.
pub(super) struct Common {
    plan: Plan,
    method: Splits,
}

/// A network, what moves a lane of it as a simulation does, and the mass and 1 over it of each coordinate.
#[derive(Clone)]
struct Law<F, const D: usize> {
    network: Network<D>,
    system: Arc<Linked<F, Many, D>>,
    masses: Vec<[f64; 2]>,
}

/// What the lanes of a row obey.
struct Obeyed<F, const D: usize, const W: usize> {
    /// One for all lanes, or one for each.
    laws: Vec<Law<F, D>>,
    links: Links<W>,
    pulls: Option<Box<dyn Pulls<LinkedRow, W>>>,
    /// 1 over the masses of all lanes, where they differ.
    over: Option<Vec<Numbers<W>>>,
}

impl<F: Clone, const D: usize, const W: usize> Clone for Obeyed<F, D, W> {
    fn clone(&self) -> Self {
        let Self { laws, links, pulls, over } = self;
        let pulls = pulls.as_ref().map(|pulls| pulls.boxed());
        Self { laws: laws.clone(), links: links.clone(), pulls, over: over.clone() }
    }
}

/// A row of trajectories of linked bodies, moved by a splitting.
pub(super) struct LinkedLanes<F, const D: usize, const W: usize> {
    common: Arc<Common>,
    obeyed: Arc<Obeyed<F, D, W>>,
    /// Number by number, as the [`Plan`] lays them out.
    numbers: Vec<Numbers<W>>,
    /// The part of the method's step that comes next.
    part: usize,
}

impl<F, const D: usize, const W: usize> Clone for LinkedLanes<F, D, W> {
    fn clone(&self) -> Self {
        let Self { common, obeyed, numbers, part } = self;
        Self { common: common.clone(), obeyed: obeyed.clone(), numbers: numbers.clone(), part: *part }
    }
}

impl<F: Forces<f64, D>, const D: usize, const W: usize> LinkedLanes<F, D, W>
where
    Width: Wide<W>,
{
    /// Lanes, none of them set, for so many bodies of a network under these effects. None where they cannot go side by
    /// side.
    pub(super) fn new<E: Effects<D, Forces<f64> = F>>(
        network: &Network<D>,
        effects: &E,
        bodies: usize,
        method: Splits,
    ) -> Option<Self> {
        let shape = network.shape(bodies).ok()?;
        let (plan, links) =
            (Plan::of(&shape, method.sums, false)?, Links::of(&shape, |_, group| Width::links(group))?);
        let obeyed = Obeyed {
            laws: vec![Law::new(network, shape, effects, bodies)?],
            links,
            pulls: of_all(effects, bodies),
            over: None,
        };
        Some(Self::with(plan, obeyed, method))
    }

    fn with(plan: Plan, obeyed: Obeyed<F, D, W>, method: Splits) -> Self {
        let numbers = vec![zeros(); plan.places.kept];
        Self { common: Arc::new(Common { plan, method }), obeyed: Arc::new(obeyed), numbers, part: 0 }
    }
}

impl<F: Forces<f64, D>, const D: usize> LinkedLanes<F, D, ROW> {
    /// The same for a sweep, each trajectory in a network and under effects of its own, of the same topology. Lanes
    /// beyond them obey what the first does.
    pub(super) fn swept<E: Effects<D, Forces<f64> = F> + 'static>(
        networks: &[&Network<D>],
        effects: &[&E],
        bodies: usize,
        method: Splits,
    ) -> Option<Self> {
        let laws = networks
            .iter()
            .zip(effects)
            .map(|(network, effects)| Law::new(network, network.shape(bodies).ok()?, *effects, bodies));
        let laws = laws.collect::<Option<Vec<_>>>()?;
        let of = |lane: usize| if lane < laws.len() { lane } else { 0 };
        let pinned = |law: &Law<F, D>| law.masses.iter().map(|mass| mass[1] == 0.0).collect::<Vec<_>>();
        let first = &laws[0];
        if laws.iter().any(|law| {
            law.system.shape.groups.len() != first.system.shape.groups.len() || pinned(law) != pinned(first)
        }) {
            return None;
        }
        let apart = laws.iter().any(|law| law.masses != first.masses);
        let plan = Plan::of(&first.system.shape, method.sums, apart)?;
        let links = Links::of(&first.system.shape, |number, group| {
            let groups: Vec<_> = laws.iter().map(|law| &*law.system.shape.groups[number]).collect();
            group.swept(&groups)
        })?;
        let over = |c: usize| Lanes(from_fn(|lane| Fused(laws[of(lane)].masses[c][1])));
        let obeyed = Obeyed {
            over: apart.then(|| (0..plan.coordinates).map(over).collect()),
            links,
            pulls: of_each(|lane| effects[of(lane)], bodies),
            laws: (0..ROW).map(|lane| laws[of(lane)].clone()).collect(),
        };
        Some(Self::with(plan, obeyed, method))
    }
}

impl<F: Forces<f64, D>, const D: usize, const W: usize> LinkedLanes<F, D, W>
where
    Width: Wide<W>,
{
    /// All numbers, with room for those of one step.
    fn with_room(&self) -> Vec<Numbers<W>> {
        let mut numbers = self.numbers.clone();
        numbers.resize(self.common.plan.places.end, zeros());
        numbers
    }

    /// Bodies of a lane, with these places of the numbers of velocities, times the unit of a part.
    fn bodies_of(&self, numbers: &[Numbers<W>], lane: usize, [way, low]: [usize; 2]) -> Vec<Body<f64, D>> {
        let unit = self.common.method.parts[self.part].unit;
        bodies_of(&self.common, &self.law(lane).masses, numbers, lane, [way, low], unit)
    }

    /// Writes velocities and what rounding took from them; returns where.
    fn velocities(&self, numbers: &mut [Numbers<W>], part: usize) -> [usize; 2] {
        let mut pulling = self.obeyed.pulls.as_ref().map(|pulls| pulls.begin());
        let pulling = pulling.as_deref_mut().map(|pulling| pulling as &mut dyn Pulling<LinkedRow, W>);
        let course = self.course();
        Width::look(Velocities { course: &course, pulling, numbers, part });
        let Places { free, change, .. } = self.common.plan.places;
        [free, change]
    }
}

impl<F: Forces<f64, D>, const D: usize> Law<F, D> {
    /// None where they cannot go side by side.
    fn new<E: Effects<D, Forces<f64> = F>>(
        network: &Network<D>,
        shape: Shape<D>,
        effects: &E,
        bodies: usize,
    ) -> Option<Self> {
        let masses = masses(&shape)?;
        let system = Linked::new(shape, effects.forces::<f64>(), Many(bodies));
        let wide = !system.is_narrow();
        wide.then(|| Self { network: network.clone(), system: Arc::new(system), masses })
    }

    /// What moves these bodies as a simulation does, in steps of this length.
    fn ready(&self, bodies: &[Body<f64, D>], h: f64) -> Option<Linked<F, Many, D>> {
        let none: [[f64; D]; 0] = [];
        let start = State { bodies: bodies.to_vec(), ..State::of(none) };
        let (effects, count) = (self.system.effects.clone(), Many(bodies.len()));
        Linked::ready(&self.network, effects, count, &start, h, false).ok()
    }
}

impl<F, const D: usize, const W: usize> LinkedLanes<F, D, W> {
    /// What a lane obeys.
    fn law(&self, lane: usize) -> &Law<F, D> {
        &self.obeyed.laws[self.number_of_law(lane)]
    }

    fn number_of_law(&self, lane: usize) -> usize {
        if self.obeyed.laws.len() == 1 { 0 } else { lane }
    }

    fn course(&self) -> Course<'_, W> {
        let Common { plan, method: Splits { parts, equal, sums, set, .. } } = &*self.common;
        let Obeyed { links, over, .. } = &*self.obeyed;
        Course { plan, links, over: over.as_deref(), parts, equal: *equal, sums: *sums, set: *set }
    }
}

/// Bodies of a lane; low digits of momenta only where sums are compensated.
#[inline(never)]
pub(super) fn bodies_of<const D: usize, const W: usize>(
    Common { plan, method: Splits { sums, .. } }: &Common,
    masses: &[[f64; 2]],
    numbers: &[Numbers<W>],
    lane: usize,
    [way, low]: [usize; 2],
    unit: f64,
) -> Vec<Body<f64, D>> {
    let Places { q, q_low, .. } = plan.places;
    let vector = |from: usize, body: usize| from_fn(|d| numbers[from + body * D + d].0[lane].0);
    let momentum = |from: usize, body: usize| -> [f64; D] {
        let way: [f64; D] = vector(from, body);
        from_fn(|d| masses[body * D + d][0] * (way[d] / unit))
    };
    let body = |body| Body {
        q: vector(q, body),
        q_low: if *sums { vector(q_low, body) } else { [0.0; D] },
        p: momentum(way, body),
        p_low: if *sums { momentum(low, body) } else { [0.0; D] },
    };
    (0..plan.coordinates / D).map(body).collect()
}

/// Hears all multipliers of a step.
struct Heard {
    /// Of the position and the momentum equation, by equation of the scene.
    multipliers: [Vec<f64>; 2],
}

impl Heard {
    fn of<F: Forces<f64, D>, const D: usize>(system: &Linked<F, Many, D>) -> Self {
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
fn gradients<F: Forces<f64, D>, const D: usize>(system: &Linked<F, Many, D>, q: &[[f64; D]]) -> Vec<f64> {
    let shape = &*system.shape;
    let (mut g, mut rates) = (vec![0.0; shape.equations], vec![0.0; shape.equations]);
    let mut blocks = vec![[0.0; D]; shape.blocks];
    for (c, component) in shape.components.iter().enumerate() {
        shape.gradients(c, 0.0, q, &mut g, &mut blocks[component.first.1..], &mut rates);
    }
    blocks.as_flattened().to_vec()
}

/// Where a part of a step leads a lane by itself.
#[cold]
#[inline(never)]
fn go_apart<F: Forces<f64, D>, const D: usize, const W: usize>(
    common: &Common,
    Law { system, masses, .. }: &Law<F, D>,
    lane: usize,
    part: &Part,
    numbers: &[Numbers<W>],
    room: &mut Option<BodiesOf<F, Many, D>>,
) -> Result<Landed, Stuck> {
    let plan = &common.plan;
    let Places { way, way_low, .. } = plan.places;
    let places = bodies_of(common, masses, numbers, lane, [way, way_low], part.unit);
    let bodies = match room {
        None => room.insert(system.bodies(&places, 0.0)),
        Some(bodies) => {
            for (i, &Body { q, q_low, p, p_low }) in places.iter().enumerate() {
                (bodies.q[i], bodies.q_low[i], bodies.p[i], bodies.p_low[i]) = (q, q_low, p, p_low);
            }
            system.refresh(bodies);
            bodies
        }
    };
    let mut heard = Heard::of(&**system);
    let stuck = |failure| Stuck { lane, failure: Some(failure) };
    system.settle(0.0, part.h, bodies, &mut Whoever(&mut heard)).map_err(stuck)?;
    system.drift(0.0, part.h, bodies, &mut Whoever(&mut heard)).map_err(stuck)?;
    // What the way leads off the constraints Λ puts back.
    let [drift, settle] = &heard.multipliers;
    let multiplier = |&i: &usize| 0.5 * part.h * part.h * (drift[i] + settle[i]);
    let multipliers = plan.equation.iter().map(multiplier).collect();
    Ok(Landed { multipliers, gradients: gradients(&**system, &bodies.q) })
}

impl<F: Forces<f64, D>, const D: usize, const W: usize> Engine<D> for LinkedLanes<F, D, W>
where
    Width: Wide<W>,
{
    fn width(&self) -> usize {
        W
    }

    fn boxed(&self) -> Box<dyn Engine<D>> {
        Box::new(self.clone())
    }

    fn bodies_of_each(&self) -> usize {
        self.common.plan.coordinates / D
    }

    fn go(&self, tour: &mut dyn Tour<D>) -> Result<Box<dyn Engine<D>>, Stuck> {
        let common = &*self.common;
        let mut numbers = self.with_room();
        let mut part = self.part;
        let mut room = self.obeyed.pulls.as_ref().map(|pulls| pulls.begin());
        let course = self.course();
        let mut bodies: Vec<_> = self.obeyed.laws.iter().map(|_| None).collect();
        let mut apart = |lane: usize, part: &Part, numbers: &[Numbers<W>]| {
            let law = self.number_of_law(lane);
            go_apart(common, &self.obeyed.laws[law], lane, part, numbers, &mut bodies[law])
        };
        let n = self.bodies_of_each();
        while let Some(Leg { from, steps, written, shown }) = tour.next() {
            Width::go(Steps {
                course: &course,
                pulling: room.as_deref_mut().map(|pulling| pulling as &mut dyn Pulling<LinkedRow, W>),
                apart: &mut apart,
                numbers: &mut numbers,
                part: &mut part,
                from,
                steps,
                looks: shown,
            })?;
            if let Some(written) = written {
                let mut now = numbers.clone();
                let way = self.velocities(&mut now, part);
                let bodies = (0..W).flat_map(|lane| self.bodies_of(&now, lane, way)).collect::<Vec<_>>();
                written.fill(W * n, |i| bodies[i].q, |i| bodies[i].p);
            }
        }
        numbers.truncate(common.plan.places.kept);
        Ok(Box::new(Self { common: self.common.clone(), obeyed: self.obeyed.clone(), numbers, part }))
    }

    fn set(&mut self, lane: usize, bodies: &[Body<f64, D>]) -> bool {
        let law = self.law(lane).clone();
        let (system, common) = (&*law.system, self.common.clone());
        let Common { plan, method: Splits { parts, equal, sums, h, .. } } = &*common;
        let Places { q, q_low, way, way_low, lifted, guess, last, earlier, square, rest, .. } = plan.places;
        let part = &parts[self.part];
        let mut ahead = system.bodies(bodies, 0.0);
        let independent = system.freedom(&ahead) + plan.equations == plan.moving.len();
        let narrow = plan.equations > constraints::FEW
            && law.ready(bodies, *h).is_none_or(|system| system.is_narrow());
        let mut heard = Heard::of(system);
        let settled = system.settle(part.lead, part.h, &mut ahead, &mut ());
        let places = ahead.all();
        let entries = gradients(system, &ahead.q);
        let drifted = settled.and_then(|()| system.drift(0.0, part.h, &mut ahead, &mut Whoever(&mut heard)));
        let multipliers = plan.equation.iter().map(|&i| 0.5 * part.h * part.h * heard.multipliers[0][i]);
        let multipliers: Vec<_> = multipliers.collect();

        let mut put = |place: usize, x: f64| self.numbers[place].0[lane] = Fused(x);
        let coordinates = places.iter().flat_map(|body| (0..D).map(move |d| (body, d)));
        let (mut path, mut off, mut sizes) = (0.0_f64, 0.0_f64, vec![0.0; plan.coordinates]);
        let mut back = vec![0.0; plan.coordinates];
        let (mut squares, mut lengths, mut reaches) =
            (vec![0.0; plan.equations], vec![0.0_f64; plan.equations], vec![0.0_f64; plan.equations]);
        for (entry, (&[c, i], &x)) in plan.of_entry.iter().zip(&entries).enumerate() {
            let over = law.masses[c][1];
            put(lifted + entry, over * x);
            back[c] += over * x * multipliers[i];
            squares[i] += over * x * x;
            lengths[i] = lengths[i].max(x.abs());
        }
        for (c, (body, d)) in coordinates.enumerate() {
            let over = law.masses[c][1];
            let h = part.unit * over;
            // Equal steps: as if one had led here, which would have left half of Λ in the way.
            let left = if *equal { back[c] } else { 0.0 };
            put(q + c, body.q[d]);
            put(way + c, h * body.p[d] - left);
            if *sums {
                put(q_low + c, body.q_low[d]);
                put(way_low + c, h * body.p_low[d]);
            }
            path = path.max((part.h * over * body.p[d]).abs());
            off = off.max(back[c].abs());
            sizes[c] = body.q[d].abs().max((h * body.p[d] - left).abs());
        }
        plan.of_entry.iter().for_each(|&[c, i]| reaches[i] = reaches[i].max(sizes[c]));
        for i in 0..plan.equations {
            let first = if *equal { 2.0 * multipliers[i] } else { multipliers[i] };
            put(guess + i, first);
            put(last + i, part.before * first);
            put(earlier + i, part.before * first);
            put(square + i, squares[i]);
            put(rest + i, at_rest(Fused(lengths[i]), Fused(reaches[i])).0);
        }
        drifted.is_ok() && independent && !narrow && path.is_finite() && off <= 2.0 * path
    }

    fn copy(&mut self, from: usize, to: usize) {
        self.numbers.iter_mut().for_each(|numbers| numbers.0[to] = numbers.0[from]);
    }

    fn obey(&mut self, from: usize, to: usize) {
        if self.obeyed.laws.len() == 1 {
            return;
        }
        let Obeyed { laws, links, pulls, over } = Arc::make_mut(&mut self.obeyed);
        laws[to] = laws[from].clone();
        links.copy(from, to);
        if let Some(pulls) = pulls {
            pulls.copy(from, to);
        }
        over.iter_mut().flatten().for_each(|over| over.0[to] = over.0[from]);
    }

    fn obey_as_in(&mut self, engine: &dyn Engine<D>) {
        if let Some(Self { obeyed, .. }) = (engine as &dyn Any).downcast_ref() {
            self.obeyed = obeyed.clone();
        }
    }

    fn bodies(&self, lane: usize) -> Vec<Body<f64, D>> {
        let mut now = self.with_room();
        let way = self.velocities(&mut now, self.part);
        self.bodies_of(&now, lane, way)
    }

    fn by_itself(
        &self,
        lane: usize,
        bodies: &[Body<f64, D>],
        _: u64,
        steps: u64,
        parts: u32,
        _: &mut u64,
    ) -> Result<Moved<D>, Failure> {
        let law = self.law(lane);
        let ready = law.ready(bodies, self.common.method.h);
        let system = ready.as_ref().unwrap_or(&law.system);
        by_itself::<f64, _, D>(system, &self.common.method.stages, None, steps, parts, bodies)
    }

    fn kick_alone(&self, steps: u32) {
        let Some(pulls) = &self.obeyed.pulls else { return };
        let Common { plan, method: Splits { parts, set, .. } } = &*self.common;
        let (mut pulling, n) = (pulls.begin(), plan.coordinates);
        let mut kicked = vec![zeros(); n];
        for _ in 0..steps * parts.len() as u32 {
            let q = &self.numbers[plan.places.q..plan.places.q + n];
            pulling.pull(*set, 1e-9, (black_box(q), &plan.masses, &mut kicked));
        }
        black_box(kicked);
    }

    fn forces(&self) -> Vec<&'static str> {
        forces(self.system(0), &self.bodies(0))
    }

    fn record(&self, to: &mut Record) {
        let numbers = self.numbers.iter().flat_map(|numbers| numbers.0.map(|x| x.0));
        to.numbers("numbers", &[self.numbers.len(), W], numbers);
        to.counts("part", [self.part as u64]);
    }

    fn recalled(&self, from: &mut Reading<'_>) -> Result<Box<dyn Engine<D>>, Error> {
        let mut again = self.clone();
        let numbers = from.numbers("numbers", &[self.numbers.len(), W])?;
        for (to, from) in again.numbers.iter_mut().zip(numbers.as_chunks().0) {
            *to = Lanes(from.map(Fused));
        }
        let [part] = from.counted("part")?;
        again.part = part as usize % self.common.method.parts.len();
        Ok(Box::new(again))
    }

    fn hallmarks(&self, lane: usize, bodies: &[Body<f64, D>]) -> Vec<Hallmark> {
        of_system(self.system(lane), bodies, 0.0)
    }

    fn method(&self) -> Hallmark {
        self.common.method.hallmark()
    }
}

impl<F: Forces<f64, D>, const D: usize, const W: usize> Obeying<D> for LinkedLanes<F, D, W> {
    type System = Linked<F, Many, D>;

    fn system(&self, lane: usize) -> &Self::System {
        &self.law(lane).system
    }

    fn step_size(&self) -> f64 {
        self.common.method.h
    }
}
