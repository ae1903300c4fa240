//! Linked bodies in lanes.

use crate::effect::force::Force;
use crate::effect::list::{Effects, Forces};
use crate::effect::moment::Moment;
use crate::error::Error;
use crate::motion::bodies::{Body, Many};
use crate::motion::capability::Rates;
use crate::motion::failure::Failure;
use crate::motion::method::Stage;
use crate::motion::record::{Hallmark, Reading, Record};
use crate::motion::state::State;
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::{Fused, Lanes};
use crate::number::real::Real;
use crate::run::ensemble::block::Part;
use crate::run::ensemble::engine::{Engine, Leg, Stuck, Tour};
use crate::run::ensemble::linked_going::{Steps, Velocities, Wide, Width};
use crate::run::ensemble::linked_row::{Course, Landed, Pulling, Pulls, at_rest};
use crate::run::ensemble::plan::{Links, Places, Plan};
use crate::run::ensemble::splitting_lanes::by_itself;
use crate::run::fingerprint::of_system;
use crate::run::readings::as_shown;
use crate::run::watch::sight::{Sight, Source};
use crate::systems::linked::Linked;
use crate::systems::linked::kept::BodiesOf;
use crate::systems::network::in_lanes::{FEW, Number, Numbers, zeros};
use crate::systems::network::{Network, constraints};
use nalgebra::SVector;
use std::array::from_fn;
use std::hint::black_box;
use std::sync::Arc;

/// What all rows of an ensemble have in common.
struct Common<F, const D: usize, const W: usize> {
    network: Network<D>,
    system: Linked<F, Many, D>,
    plan: Plan,
    links: Links<W>,
    pulls: Option<Box<dyn Pulls<W>>>,
    stages: Vec<Stage>,
    parts: Vec<Part>,
    h: f64,
    equal: bool,
    sums: bool,
    set: Fusing,
}

/// A row of trajectories of linked bodies, moved by a splitting.
pub(super) struct LinkedLanes<F, const D: usize, const W: usize> {
    common: Arc<Common<F, D, W>>,
    /// Number by number, as the [`Plan`] lays them out.
    numbers: Vec<Numbers<W>>,
    /// The part of the method's step that comes next.
    part: usize,
}

impl<F, const D: usize, const W: usize> Clone for LinkedLanes<F, D, W> {
    fn clone(&self) -> Self {
        Self { common: self.common.clone(), numbers: self.numbers.clone(), part: self.part }
    }
}

impl<F: Forces<f64, D>, const D: usize, const W: usize> LinkedLanes<F, D, W>
where
    Width: Wide<W>,
{
    /// Lanes, none of them set, for so many bodies of a network under these effects, by a method of these stages, all
    /// of which are `equal`, or not; with compensated sums or without. None where they cannot go side by side.
    pub(super) fn new<E: Effects<D, Forces<f64> = F>>(
        network: &Network<D>,
        effects: &E,
        bodies: usize,
        (stages, equal, h): (&[Stage], bool, f64),
        sums: bool,
        set: Fusing,
    ) -> Option<Self> {
        let shape = network.shape(bodies).ok()?;
        let (plan, links) = (Plan::of(&shape, sums)?, Links::of(&shape, |group| Width::links(group))?);
        let system = Linked::new(shape, effects.forces::<f64>(), Many(bodies));
        if system.is_narrow() {
            return None;
        }
        let pulls: Option<Box<dyn Pulls<W>>> = if const { F::EFFECTS == 0 } {
            None
        } else if const { F::ON_EACH } {
            Some(Box::new(OnEach(effects.forces::<Number>())))
        } else {
            Some(Box::new(Any { effects: effects.forces::<Vector>(), bodies }))
        };
        let parts = if equal { Part::of::<true>(stages) } else { Part::of::<false>(stages) };
        let numbers = vec![zeros(); plan.places.kept];
        let (network, stages) = (network.clone(), stages.to_vec());
        let common = Common { network, system, plan, links, pulls, stages, parts, h, equal, sums, set };
        Some(Self { common: Arc::new(common), numbers, part: 0 })
    }

    /// All numbers, with room for those of one step.
    fn with_room(&self) -> Vec<Numbers<W>> {
        let mut numbers = self.numbers.clone();
        numbers.resize(self.common.plan.places.end, zeros());
        numbers
    }

    /// Bodies of a lane, with these places of the numbers of velocities, times the unit of a part.
    fn bodies_of(&self, numbers: &[Numbers<W>], lane: usize, [way, low]: [usize; 2]) -> Vec<Body<f64, D>> {
        let Common { plan, parts, sums, .. } = &*self.common;
        bodies_of(plan, numbers, lane, [way, low], parts[self.part].unit, *sums)
    }

    /// Writes velocities and what rounding took from them; returns where.
    fn velocities(&self, numbers: &mut [Numbers<W>], part: usize) -> [usize; 2] {
        let mut pulling = self.common.pulls.as_ref().map(|pulls| pulls.begin());
        let pulling = pulling.as_deref_mut().map(|pulling| pulling as &mut dyn Pulling<W>);
        let course = self.common.course();
        Width::look(Velocities { course: &course, pulling, numbers, part });
        let Places { free, change, .. } = self.common.plan.places;
        [free, change]
    }
}

impl<F: Clone, const D: usize, const W: usize> Common<F, D, W> {
    /// What moves these bodies as a simulation does.
    fn ready(&self, bodies: &[Body<f64, D>]) -> Option<Linked<F, Many, D>> {
        let none: [[f64; D]; 0] = [];
        let start = State { bodies: bodies.to_vec(), ..State::of(none) };
        let (effects, count) = (self.system.effects.clone(), Many(bodies.len()));
        Linked::ready(&self.network, effects, count, &start, self.h, false).ok()
    }

    fn course(&self) -> Course<'_, W> {
        let Self { plan, links, parts, equal, sums, set, .. } = self;
        Course { plan, links, parts, equal: *equal, sums: *sums, set: *set }
    }
}

/// Bodies of a lane; low digits of momenta only where sums are compensated.
fn bodies_of<const D: usize, const W: usize>(
    plan: &Plan,
    numbers: &[Numbers<W>],
    lane: usize,
    [way, low]: [usize; 2],
    unit: f64,
    sums: bool,
) -> Vec<Body<f64, D>> {
    let Places { q, q_low, .. } = plan.places;
    let vector = |from: usize, body: usize| from_fn(|d| numbers[from + body * D + d].0[lane].0);
    let momentum = |from: usize, body: usize| -> [f64; D] {
        let way: [f64; D] = vector(from, body);
        from_fn(|d| plan.masses[body * D + d][0] * (way[d] / unit))
    };
    let body = |body| Body {
        q: vector(q, body),
        q_low: if sums { vector(q_low, body) } else { [0.0; D] },
        p: momentum(way, body),
        p_low: if sums { momentum(low, body) } else { [0.0; D] },
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
    common: &Common<F, D, W>,
    lane: usize,
    part: &Part,
    numbers: &[Numbers<W>],
    room: &mut Option<BodiesOf<F, Many, D>>,
) -> Result<Landed, Stuck> {
    let Common { system, plan, sums, .. } = common;
    let Places { way, way_low, .. } = plan.places;
    let places = bodies_of(plan, numbers, lane, [way, way_low], part.unit, *sums);
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
    let mut heard = Heard::of(system);
    let stuck = |failure| Stuck { lane, failure: Some(failure) };
    system.settle(0.0, part.h, bodies, &mut heard).map_err(stuck)?;
    system.drift(0.0, part.h, bodies, &mut heard).map_err(stuck)?;
    // What the way leads off the constraints Λ puts back.
    let [drift, settle] = &heard.multipliers;
    let multiplier = |&i: &usize| 0.5 * part.h * part.h * (drift[i] + settle[i]);
    let multipliers = plan.equation.iter().map(multiplier).collect();
    Ok(Landed { multipliers, gradients: gradients(system, &bodies.q) })
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
        let mut room = common.pulls.as_ref().map(|pulls| pulls.begin());
        let course = common.course();
        let mut bodies = None;
        let mut apart = |lane: usize, part: &Part, numbers: &[Numbers<W>]| {
            go_apart(common, lane, part, numbers, &mut bodies)
        };
        let n = self.bodies_of_each();
        while let Some(Leg { from, steps, written }) = tour.next() {
            Width::go(Steps {
                course: &course,
                pulling: room.as_deref_mut().map(|pulling| pulling as &mut dyn Pulling<W>),
                apart: &mut apart,
                numbers: &mut numbers,
                part: &mut part,
                from,
                steps,
                looks: written.is_some(),
            })?;
            if let Some(written) = written {
                let mut now = numbers.clone();
                let way = self.velocities(&mut now, part);
                let bodies = (0..W).flat_map(|lane| self.bodies_of(&now, lane, way)).collect::<Vec<_>>();
                written.fill(W * n, |i| bodies[i].q, |i| bodies[i].p);
            }
        }
        numbers.truncate(common.plan.places.kept);
        Ok(Box::new(Self { common: self.common.clone(), numbers, part }))
    }

    fn set(&mut self, lane: usize, bodies: &[Body<f64, D>]) -> bool {
        let Common { system, plan, parts, equal, sums, .. } = &*self.common;
        let Places { q, q_low, way, way_low, lifted, guess, last, earlier, square, rest, .. } = plan.places;
        let part = &parts[self.part];
        let mut ahead = system.bodies(bodies, 0.0);
        let independent = system.freedom(&ahead) + plan.equations == plan.moving.len();
        let narrow = plan.equations > constraints::FEW
            && self.common.ready(bodies).is_none_or(|system| system.is_narrow());
        let mut heard = Heard::of(system);
        let settled = system.settle(part.lead, part.h, &mut ahead, &mut ());
        let places: Vec<_> = (0..bodies.len()).map(|body| ahead.body(body)).collect();
        let entries = gradients(system, &ahead.q);
        let drifted = settled.and_then(|()| system.drift(0.0, part.h, &mut ahead, &mut heard));
        let multipliers = plan.equation.iter().map(|&i| 0.5 * part.h * part.h * heard.multipliers[0][i]);
        let multipliers: Vec<_> = multipliers.collect();

        let mut put = |place: usize, x: f64| self.numbers[place].0[lane] = Fused(x);
        let coordinates = places.iter().flat_map(|body| (0..D).map(move |d| (body, d)));
        let (mut path, mut off, mut sizes) = (0.0_f64, 0.0_f64, vec![0.0; plan.coordinates]);
        let mut back = vec![0.0; plan.coordinates];
        let (mut squares, mut lengths, mut reaches) =
            (vec![0.0; plan.equations], vec![0.0_f64; plan.equations], vec![0.0_f64; plan.equations]);
        for (entry, (&[c, i], &x)) in plan.of_entry.iter().zip(&entries).enumerate() {
            let over = plan.masses[c][1];
            put(lifted + entry, over * x);
            back[c] += over * x * multipliers[i];
            squares[i] += over * x * x;
            lengths[i] = lengths[i].max(x.abs());
        }
        for (c, (body, d)) in coordinates.enumerate() {
            let over = plan.masses[c][1];
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

    fn obey(&mut self, _: usize, _: usize) {}

    fn obey_as_in(&mut self, _: &dyn Engine<D>) {}

    fn bodies(&self, lane: usize) -> Vec<Body<f64, D>> {
        let mut now = self.with_room();
        let way = self.velocities(&mut now, self.part);
        self.bodies_of(&now, lane, way)
    }

    fn by_itself(
        &self,
        _: usize,
        bodies: &[Body<f64, D>],
        _: u64,
        steps: u64,
        parts: u32,
    ) -> Result<Vec<Body<f64, D>>, Failure> {
        let ready = self.common.ready(bodies);
        let system = ready.as_ref().unwrap_or(&self.common.system);
        by_itself::<f64, _, D>(system, &self.common.stages, None, steps, parts, bodies)
    }

    fn kick_alone(&self, steps: u32) {
        let Some(pulls) = &self.common.pulls else { return };
        let Common { plan, parts, set, .. } = &*self.common;
        let (mut pulling, n) = (pulls.begin(), plan.coordinates);
        let mut kicked = vec![zeros(); n];
        for _ in 0..steps * parts.len() as u32 {
            let q = &self.numbers[plan.places.q..plan.places.q + n];
            pulling.pull(*set, 1e-9, black_box(q), &plan.masses, &mut kicked);
        }
        black_box(kicked);
    }

    fn forces(&self) -> Vec<&'static str> {
        let mut bodies = self.common.system.bodies(&self.bodies(0), 0.0);
        let mut forces = vec![[0.0; D]; self.bodies_of_each()];
        let name = |number| self.common.system.add_force_alone(number, &mut bodies, &mut forces);
        (0..F::EFFECTS).filter_map(name).collect()
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
        again.part = part as usize % self.common.parts.len();
        Ok(Box::new(again))
    }

    fn hallmarks(&self, _: usize, bodies: &[Body<f64, D>]) -> Vec<Hallmark> {
        of_system(&self.common.system, bodies, 0.0)
    }

    fn method(&self) -> Hallmark {
        let stages = self.common.stages.iter().flat_map(|stage| [stage.before, stage.h, stage.after]);
        Hallmark::new("method", "a splitting", stages.collect())
    }
}

/// Forces of effects that act on each body by itself.
struct OnEach<G, const D: usize>(G);

impl<G: Forces<Number, D>, const D: usize, const W: usize> Pulls<W> for OnEach<G, D> {
    fn begin(&self) -> Box<dyn Pulling<W> + '_> {
        Box::new(self)
    }
}

impl<G: Forces<Number, D>, const D: usize, const W: usize> Pulling<W> for &OnEach<G, D> {
    fn pull(
        &mut self,
        set: Fusing,
        times: f64,
        q: &[Numbers<W>],
        masses: &[[f64; 2]],
        to: &mut [Numbers<W>],
    ) {
        set.run(PullEach { effects: &self.0, times, q, masses, to });
    }
}

struct PullEach<'a, G, const D: usize, const W: usize> {
    effects: &'a G,
    times: f64,
    q: &'a [Numbers<W>],
    masses: &'a [[f64; 2]],
    to: &'a mut [Numbers<W>],
}

impl<G: Forces<Number, D>, const D: usize, const W: usize> Work for PullEach<'_, G, D, W> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { effects, times, q, masses, to } = self;
        let effects = effects.clone(); // out of reach of what the loops write
        let bodies = q.as_chunks::<D>().0.iter().zip(masses.as_chunks::<D>().0);
        for ((q, masses), to) in bodies.zip(to.as_chunks_mut::<D>().0) {
            if masses[0][1] != 0.0 {
                pull_one(&effects, masses.map(|[_, over]| Fused(times * over)), q, to);
            }
        }
    }
}

/// One body. Arguments of a function are known not to overlap, so that the loop becomes one over vectors.
#[inline(always)]
fn pull_one<G: Forces<Number, D>, const D: usize, const W: usize>(
    effects: &G,
    times: [Number; D],
    q: &[Numbers<W>; D],
    to: &mut [Numbers<W>; D],
) {
    let (zero, one) = ([Fused(-0.0); D], Fused(1.0));
    for l in 0..W {
        let force = effects.kick(&from_fn(|d| q[d].0[l]), one, zero);
        for d in 0..D {
            to[d].0[l] = times[d].multiply_add(force[d], to[d].0[l]);
        }
    }
}

/// Numbers of the lanes for which forces between bodies are evaluated at once.
type Vector = Numbers<FEW>;

/// Forces of any effects.
struct Any<G, const D: usize> {
    effects: G,
    bodies: usize,
}

impl<G: Forces<Vector, D>, const D: usize, const W: usize> Pulls<W> for Any<G, D> {
    fn begin(&self) -> Box<dyn Pulling<W> + '_> {
        let zero = zeros::<FEW>();
        Box::new(Room {
            effects: &self.effects,
            positions: vec![[zero; D]; self.bodies],
            forces: vec![Force::zero(); self.bodies],
            room: self.effects.room(self.bodies),
        })
    }
}

/// Effects, and room for some lanes.
struct Room<'a, G: Forces<Vector, D>, const D: usize> {
    effects: &'a G,
    positions: Vec<[Vector; D]>,
    forces: Vec<G::Force>,
    room: G::Room,
}

impl<G: Forces<Vector, D>, const D: usize, const W: usize> Pulling<W> for Room<'_, G, D> {
    fn pull(
        &mut self,
        set: Fusing,
        times: f64,
        q: &[Numbers<W>],
        masses: &[[f64; 2]],
        to: &mut [Numbers<W>],
    ) {
        set.run(PullAll { room: self, times, q, masses, to });
    }
}

struct PullAll<'a, 'b, G: Forces<Vector, D>, const D: usize, const W: usize> {
    room: &'a mut Room<'b, G, D>,
    times: f64,
    q: &'a [Numbers<W>],
    masses: &'a [[f64; 2]],
    to: &'a mut [Numbers<W>],
}

impl<G: Forces<Vector, D>, const D: usize, const W: usize> Work for PullAll<'_, '_, G, D, W> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { room: Room { effects, positions, forces, room }, times, q, masses, to } = self;
        for first in (0..W).step_by(FEW) {
            for (position, q) in positions.iter_mut().zip(q.as_chunks::<D>().0) {
                *position = from_fn(|d| Lanes(from_fn(|l| q[d].0[first + l])));
            }
            effects.evaluate(Moment { time: 0.0, positions }, room, forces);
            let bodies = forces.iter().zip(masses.as_chunks::<D>().0).zip(to.as_chunks_mut::<D>().0);
            for ((force, masses), to) in bodies {
                let force = force.components();
                for d in 0..D {
                    let times = Fused(times * masses[d][1]);
                    for l in 0..FEW {
                        to[d].0[first + l] = times.multiply_add(force[d].0[l], to[d].0[first + l]);
                    }
                }
            }
        }
    }
}

impl<F: Forces<f64, D>, const D: usize, const W: usize> Source<D> for LinkedLanes<F, D, W> {
    fn energies(&self, _: usize, sight: &Sight<'_, D>) -> [f64; 2] {
        let Common { system, .. } = &*self.common;
        let bodies = as_shown(system, sight);
        [system.kinetic_energy(&bodies), system.potential_energy(&bodies)]
    }

    fn constraints(&self, _: usize, sight: &Sight<'_, D>) -> (Vec<f64>, Vec<SVector<f64, D>>) {
        let Common { system, .. } = &*self.common;
        let bodies = as_shown(system, sight);
        let (mut multipliers, mut forces) =
            (vec![0.0; system.equations()], vec![[0.0; D]; sight.positions.len()]);
        system.multipliers(&bodies, &mut multipliers);
        system.constraint_forces(&bodies, &mut forces);
        (multipliers, forces.into_iter().map(Into::into).collect())
    }

    fn effect_energies(&self, _: usize, sight: &Sight<'_, D>) -> Vec<f64> {
        let (system, mut energies) = (&self.common.system, Vec::new());
        system.effect_energies(&as_shown(system, sight), &mut energies);
        energies
    }

    fn residuals(&self, _: usize, sight: &Sight<'_, D>) -> Vec<f64> {
        let system = &self.common.system;
        let mut residuals = vec![0.0; system.equations()];
        system.residuals(&as_shown(system, sight), &mut residuals);
        residuals
    }

    fn temperature(&self, _: usize, sight: &Sight<'_, D>) -> f64 {
        let system = &self.common.system;
        let bodies = as_shown(system, sight);
        2.0 * system.kinetic_energy(&bodies) / system.freedom(&bodies) as f64
    }

    fn mass_product(&self, _: usize, body: usize, a: &[f64; D], b: &[f64; D]) -> f64 {
        Rates::mass_product(&self.common.system, body, a, b)
    }

    fn step_size(&self) -> f64 {
        self.common.h
    }
}
