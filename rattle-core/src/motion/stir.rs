//! Strang splitting: a step of a method between two halves of the flows of momenta.
//!
//! ```text
//! A_{h/2} B_{h/2} … step … B_{h/2} A_{h/2}        A, B, … the flows in the order in which a scene names them
//! ```
//!
//! Source: G. Strang, SIAM J. Numer. Anal. 5 (1968) 506.

use crate::effect::interval::{Half, Manner, Rule};
use crate::effect::list::Forces;
use crate::effect::noise::Noise;
use crate::error::EffectFailure;
use crate::motion::bodies::{Bodies, Count};
use crate::motion::failure::{Failure, numbers};
use crate::motion::method::{Method, View};
use crate::motion::parts::{BodiesOf, Given};
use crate::motion::rest::{along, imposed};
use crate::motion::sticking;
use crate::motion::system::System;
use crate::motion::witness::Witness;
use crate::number::real::Scalar;
use crate::number::vector::{add_scaled, dot, largest, scaled, sum, two_sum};

/// A system with flows, as messages name it.
pub(crate) const FLOW: &str = "bodies under drag or another flow of momenta";

/// The same where flows feel forces.
pub(crate) const FEELING_FLOW: &str = "bodies under dry friction or another flow that feels forces";

/// Vectors of room for each body: velocities, rates, holding forces, changes, momenta at first with what rounding took,
/// four others; and what is still to come, velocities and momenta in the middle, what another flow gives and what of it
/// is along the constraints, momenta that are imposed, momenta put aside with what rounding took.
pub(crate) const ROOM: usize = 18;

/// [`Rule::Symmetric`] is iterated no more often: where each iteration takes half of what is left, all digits take 53.
const MOST_ITERATIONS: usize = 100;

/// Iterations after which what a body lacks is a rounding of others, if it is one of the largest momentum and no longer
/// shrinks: before, it may do so on the way.
const PATIENCE: usize = 16;

/// What [`Rule::Symmetric`] may lack where no iteration brings it nearer, as part of the largest momentum: of a flow
/// that is stiff along the normals of many constraints.
const SETTLED: f64 = 1e-8;

/// The first flow that draws random numbers.
pub(crate) fn random<T: Scalar, Y: System<T, D>, const D: usize>(system: &Y) -> Option<&'static str> {
    if const { Y::FLOWS == 0 } {
        return None;
    }
    let mut manners = (0..Y::FLOWS).map(|number| system.effects().manner(number));
    manners.find(|(manner, _)| manner.rule == Rule::Random).map(|(_, effect)| effect)
}

/// Whether flows draw random numbers. A step in parts has those of the whole step: parts that drew their own would
/// favour the numbers that need no parts.
pub(crate) fn draws<T: Scalar, Y: System<T, D>, const D: usize>(system: &Y) -> bool {
    random(system).is_some()
}

/// Which of the flows act.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Chosen {
    All,
    /// Those that draw random numbers, as they act or as they take note.
    Drawing,
    /// Those that draw none.
    Others,
    None,
}

impl Chosen {
    /// Those that act inside a stretch of a step, where those that draw act around the whole step: to have the others
    /// act there too would be of first order only where stretches differ in length.
    pub(crate) fn inside<T: Scalar, Y: System<T, D>, const D: usize>(system: &Y) -> Self {
        if !draws(system) {
            return Self::All;
        }
        let others = (0..Y::FLOWS).any(|number| Self::Others.has(system.effects().manner(number).0));
        if others { Self::Others } else { Self::None }
    }

    fn has(self, Manner { rule, .. }: Manner) -> bool {
        match self {
            Self::All => true,
            Self::Drawing => rule == Rule::Random,
            Self::Others => rule != Rule::Random,
            Self::None => false,
        }
    }

    fn take_note(self) -> bool {
        matches!(self, Self::All | Self::Drawing)
    }
}

/// Whether a flow feels forces.
pub(crate) fn feels<T: Scalar, Y: System<T, D>, const D: usize>(system: &Y) -> bool {
    if const { Y::FLOWS == 0 } {
        return false;
    }
    (0..Y::FLOWS).any(|number| system.effects().manner(number).0.feels)
}

/// The order of steps with flows, unless that of the method is lower.
pub(crate) const ORDER: u32 = 2;

/// One step of the method; of a system with flows between two halves of the chosen ones, unless the method has them act
/// itself.
#[inline(always)]
pub(crate) fn step<S: Method, T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
    chosen: Chosen,
    method: &S,
    seen: View<'_, S, T, Y, D>,
    system: &Y,
    bodies: &mut BodiesOf<Y, T, D>,
    memory: &mut [T],
    witness: &mut W,
) -> Result<(), Failure> {
    if const { Y::FLOWS == 0 || S::STIRS } || chosen == Chosen::None {
        return method.step(seen, bodies, memory, witness);
    }
    let half = 0.5 * method.step_size();
    let first = |bodies: &mut BodiesOf<Y, T, D>| stir(chosen, Half::Before, half, system, bodies);
    let mut middle = |bodies: &mut BodiesOf<Y, T, D>| method.step(seen, bodies, memory, witness);
    let last = |bodies: &mut BodiesOf<Y, T, D>| stir(chosen, Half::After, half, system, bodies);
    // Bodies that constraints move are never at rest.
    if feels(system) && !system.constraints_move() {
        return sticking::step(system, bodies, first, middle, last);
    }
    first(bodies)?;
    middle(bodies)?;
    last(bodies)
}

/// Has all flows act for a time h, symmetrically: for a method that wants them in the middle of its step.
#[inline(always)]
pub(crate) fn in_the_middle<T: Scalar, Y: System<T, D>, const D: usize>(
    h: f64,
    system: &Y,
    bodies: &mut BodiesOf<Y, T, D>,
) -> Result<(), Failure> {
    if const { Y::FLOWS == 0 } {
        return Ok(());
    }
    if at_once(system) {
        return stir(Chosen::All, Half::Before, h, system, bodies);
    }
    stir(Chosen::All, Half::After, 0.5 * h, system, bodies)?; // of the drift that was
    stir(Chosen::All, Half::Before, 0.5 * h, system, bodies)
}

/// Whether flows that act in the middle of a step act all at once: the two halves of more than one, or of one that is
/// no exact solution, would not commute.
fn at_once<T: Scalar, Y: System<T, D>, const D: usize>(system: &Y) -> bool {
    Y::FLOWS == 1 && !Y::REMEMBERS && system.effects().manner(0).0.rule == Rule::Random
}

/// How often a step of the method has the flows act.
pub(crate) fn times<S: Method, T: Scalar, Y: System<T, D>, const D: usize>(system: &Y) -> u32 {
    if S::STIRS && (S::FORGETS || at_once(system)) { 1 } else { 2 }
}

/// Has the chosen flows act for a time h, one after the other, and take note of it; those that draw take note for all.
/// Positions, and what is kept there, stay. The change of kinetic energy counts as work.
pub(crate) fn stir<T: Scalar, Y: System<T, D>, const D: usize>(
    chosen: Chosen,
    half: Half,
    h: f64,
    system: &Y,
    bodies: &mut BodiesOf<Y, T, D>,
) -> Result<(), Failure> {
    let notes = chosen.take_note();
    if notes && half == Half::Before {
        take_note(half, h, system, bodies);
    }
    push(chosen, half, h, system, bodies)?;
    if notes && half == Half::After {
        take_note(half, h, system, bodies);
        bodies.noise.place += u64::from(Y::REMEMBERS);
    }
    Ok(())
}

/// The force of a flow is what it gives in this part of a time, where its way is nearly a straight line and has a way
/// back; or in a fourth, a sixteenth … of that, if a drag stops bodies in much less.
pub(crate) const SHORTLY: f64 = 1.0 / 64.0;
const MOST_SHORTENED: i32 = 32;

/// Of this part of what a flow gives it may give more forwards than backwards; then the force is right to a 400th.
const BENT: f64 = 1.0 / 16.0;

/// Whether what a flow gives each body in a time and what it gives it backwards are nearly opposite; not where they are
/// no numbers.
fn is_straight<T: Scalar, const D: usize>(forth: &[[T; D]], back: &[[T; D]]) -> bool {
    forth.iter().zip(back).all(|(forth, back)| {
        let (mut bent, mut whole) = (0.0, 0.0);
        for (forth, back) in forth.iter().zip(back) {
            let (forth, back) = (forth.to_f64(), back.to_f64());
            (bent, whole) = ((forth + back).abs() + bent, (forth - back).abs() + whole);
        }
        whole.is_finite() && bent <= BENT * whole
    })
}

/// In the place of [`Noise`] where flows take note, so that they draw other numbers than where they act.
const NOTES: u64 = 1 << 22;

/// Has all flows take note of a time h that passes.
pub(crate) fn take_note<T: Scalar, Y: System<T, D>, const D: usize>(
    half: Half,
    h: f64,
    system: &Y,
    bodies: &mut BodiesOf<Y, T, D>,
) {
    if const { Y::REMEMBERS } {
        for number in 0..Y::FLOWS {
            let noise = Noise { effect: number as u64, place: bodies.noise.place | NOTES, ..bodies.noise };
            system.take_note(number, Given::of(h, half == Half::Before, noise), bodies);
        }
    }
}

/// Who has flows act for a time h.
type Act<Y, T, const D: usize> = fn(Chosen, Half, f64, &Y, &mut BodiesOf<Y, T, D>) -> Result<(), Failure>;

/// Has the chosen flows act for a time h, one after the other.
pub(crate) fn push<T: Scalar, Y: System<T, D>, const D: usize>(
    chosen: Chosen,
    half: Half,
    h: f64,
    system: &Y,
    bodies: &mut BodiesOf<Y, T, D>,
) -> Result<(), Failure> {
    // A constant, so that the compiler goes through nothing of flows where there are none.
    let act: Act<Y, T, D> =
        const { if Y::FLOWS == 0 { |_, _, _, _, _| Ok(()) } else { push_each::<T, Y, D> } };
    act(chosen, half, h, system, bodies)
}

/// The same where there are flows.
fn push_each<T: Scalar, Y: System<T, D>, const D: usize>(
    chosen: Chosen,
    half: Half,
    h: f64,
    system: &Y,
    bodies: &mut BodiesOf<Y, T, D>,
) -> Result<(), Failure> {
    let (before, work) = (system.kinetic_energy(bodies), bodies.work);
    bodies.with_room(ROOM, |bodies, _, room| {
        let n = bodies.q.as_ref().len();
        for number in 0..Y::FLOWS {
            let number = if half == Half::Before { number } else { Y::FLOWS - 1 - number };
            let (manner, name) = system.effects().manner(number);
            let (Manner { rule, feels, .. }, acts) = (manner, chosen.has(manner));
            if !acts {
                bodies.noise.place += u64::from(chosen == Chosen::Drawing); // as if it acted
                continue;
            }
            let (room, p) = room.split_at_mut(4 * n);
            let (p, felt) = p.split_at_mut(6 * n);
            let (first, low) = p.split_at_mut(n);
            let (low, other) = low.split_at_mut(n);
            first.copy_from_slice(bodies.p.as_ref());
            low.copy_from_slice(bodies.p_low.as_ref());
            let mut flow = Flowing { number, half, feels, system, room, felt, first, low };
            match rule {
                Rule::Random => flow.act(h, bodies)?,
                Rule::Symmetric => flow.act_symmetrically(h, bodies, other, name)?,
            }
            bodies.noise.place += u64::from(chosen != Chosen::Others);
        }
        Ok(())
    })?;
    // Links that move book what they do to make momenta fit; that is in the change of energy too.
    bodies.work = work + (system.kinetic_energy(bodies) - before);
    Ok(())
}

/// A flow at work.
struct Flowing<'a, T, Y, const D: usize> {
    number: usize,
    half: Half,
    feels: bool,
    system: &'a Y,
    /// Velocities, rates, holding forces and changes.
    room: &'a mut [[T; D]],
    /// What is still to come, velocities and momenta in the middle, what another flow gives, what of that is along the
    /// constraints, what is imposed, two vectors to put momenta aside.
    felt: &'a mut [[T; D]],
    /// The momenta at first, and what rounding had taken from them.
    first: &'a [[T; D]],
    low: &'a [[T; D]],
}

impl<T: Scalar, Y: System<T, D>, const D: usize> Flowing<'_, T, Y, D> {
    /// Writes what the momenta now would change by in a time h.
    fn ask(&mut self, h: f64, bodies: &mut BodiesOf<Y, T, D>) -> Result<(), Failure> {
        let (system, n) = (self.system, self.first.len());
        let (velocities, room) = self.room.split_at_mut(n);
        let (rates, room) = room.split_at_mut(n);
        let (holding, changes) = room.split_at_mut(n);
        let inertia = system.inertia();
        for (body, velocity) in velocities.iter_mut().enumerate() {
            *velocity = inertia.velocity(body, &bodies.p.as_ref()[body]);
        }
        let mut given = Given {
            velocities,
            ..Given::of(h, self.half == Half::Before, Noise { effect: self.number as u64, ..bodies.noise })
        };
        let (coming, others) = self.felt.split_at_mut(n);
        let (middle, others) = others.split_at_mut(n);
        let (momenta, others) = others.split_at_mut(n);
        let (push, others) = others.split_at_mut(n);
        let (way, others) = others.split_at_mut(n);
        let (still, aside) = others.split_at_mut(n);
        if self.feels || system.constraints_move() {
            imposed(system, bodies, still, aside)?;
            let energy = |(body, p): (usize, &[T; D])| T::from_f64(0.5) * dot(p, &inertia.velocity(body, p));
            given.imposed =
                still.iter().enumerate().map(energy).fold(T::from_f64(0.0), |sum, part| sum + part);
        }
        given.led = if system.constraints_move() { still } else { &[] };
        if self.feels {
            system.evaluate_forces(bodies); // a method may have left those of another place
            middle.copy_from_slice(velocities);
            momenta.copy_from_slice(bodies.p.as_ref());
        }
        let others = |number: usize| number != self.number && system.effects().manner(number).0.is_felt();
        let others = || (0..Y::FLOWS).filter(|&number| self.feels && others(number));
        // Others are felt as they are in the middle of the flow, so that it is of second order.
        for _ in 0..if others().next().is_some() { 2 } else { 1 } {
            if self.feels {
                system.feel(bodies, rates, holding);
                let share = T::from_f64(if given.before { h } else { 0.0 });
                coming.iter_mut().zip(&*rates).for_each(|(coming, rate)| *coming = scaled(share, rate));
            }
            for number in others() {
                // The force at these velocities: of a short time, forwards and backwards, without its own way between.
                let mut short = SHORTLY * h;
                let at = |h: f64| Given { h, velocities: middle, ..given };
                momenta.swap_with_slice(bodies.p.as_mut());
                for round in 0..=MOST_SHORTENED {
                    // Where no way is straight, as where a body is stopped, that of the first time is taken.
                    short =
                        if round < MOST_SHORTENED { SHORTLY * h * 0.25_f64.powi(round) } else { SHORTLY * h };
                    system.flow(number, at(short), bodies, push);
                    system.flow(number, at(-short), bodies, way);
                    if is_straight(push, way) {
                        break;
                    }
                }
                for (push, way) in push.iter_mut().zip(&mut *way) {
                    *push = scaled(T::from_f64(0.5 / short), &minus(push, way));
                    *way = *push;
                }
                momenta.swap_with_slice(bodies.p.as_mut());
                along(system, bodies, way, still, aside)?;
                for body in 0..n {
                    let (push, way) = (&push[body], &way[body]);
                    rates[body] = sum(&rates[body], way);
                    holding[body] = sum(&holding[body], &minus(way, push));
                }
                // What is to come of it is that of the whole time: drag stops a body, and does not turn it round.
                if (number > self.number) == given.before {
                    momenta.swap_with_slice(bodies.p.as_mut());
                    system.flow(number, at(h), bodies, way);
                    momenta.swap_with_slice(bodies.p.as_mut());
                    along(system, bodies, way, still, aside)?;
                    coming.iter_mut().zip(&*way).for_each(|(coming, way)| *coming = sum(coming, way));
                }
            }
            system.flow(self.number, Given { rates, holding, coming, ..given }, bodies, changes);
            for body in 0..if self.feels { n } else { 0 } {
                momenta[body] = add_scaled(&bodies.p.as_ref()[body], T::from_f64(0.5), &changes[body]);
                middle[body] = inertia.velocity(body, &momenta[body]);
            }
        }
        for (body, change) in changes.iter_mut().enumerate() {
            if system.inertia().is_pinned(body) {
                *change = [T::from_f64(0.0); D];
            }
            let finite = change.iter().all(|x| x.to_f64().is_finite());
            if !finite {
                let (effect, q) = (system.effects().manner(self.number).1, bodies.q.as_ref()[body]);
                let (momentum, position) = (numbers(&bodies.p.as_ref()[body]), numbers(&q));
                let cause = EffectFailure::FlowNotFound { effect, h, momentum, position }.into();
                return Err(Failure { body, cause });
            }
        }
        Ok(())
    }

    fn changes(&self) -> &[[T; D]] {
        &self.room[3 * self.first.len()..]
    }

    /// [`Rule::Random`].
    fn act(&mut self, h: f64, bodies: &mut BodiesOf<Y, T, D>) -> Result<(), Failure> {
        self.ask(h, bodies)?;
        if self.rests() {
            return Ok(());
        }
        add(self.changes(), bodies);
        self.system.settle(0.0, h, bodies, &mut ())
    }

    /// Whether there is no change at all: then momenta stay to the bit, as if there were no flow.
    fn rests(&self) -> bool {
        self.changes().iter().flatten().all(|x| x.to_f64() == 0.0)
    }

    /// [`Rule::Symmetric`]: N is found by repetition, each time with what it lacks, r, and from two rounds on by the
    /// secant through both (D. G. Anderson 1965). `others` are N and r, now and before.
    fn act_symmetrically(
        &mut self,
        h: f64,
        bodies: &mut BodiesOf<Y, T, D>,
        others: &mut [[T; D]],
        effect: &'static str,
    ) -> Result<(), Failure> {
        let (system, n, zero) = (self.system, self.first.len(), T::from_f64(0.0));
        let (now, before) = others.split_at_mut(2 * n);
        let ((impulses, lacks), (impulses_before, lacks_before)) =
            (now.split_at_mut(n), before.split_at_mut(n));
        impulses.fill([zero; D]);
        let rounding = T::from_f64(8.0 * T::EPSILON);
        let most_settled = SETTLED.max(8.0 * T::EPSILON);
        let mut last = f64::INFINITY;
        for iteration in 0..MOST_ITERATIONS {
            if iteration > 0 {
                self.put_back(bodies);
                let halves = &mut self.room[n..2 * n];
                halves.iter_mut().zip(&*impulses).for_each(|(half, n)| *half = scaled(T::from_f64(0.5), n));
                add(halves, bodies);
            }
            self.ask(h, bodies)?;
            if iteration == 0 && self.rests() {
                return Ok(());
            }
            self.put_back(bodies);
            let changes = &mut self.room[3 * n..];
            changes.iter_mut().zip(&*impulses).for_each(|(change, n)| *change = sum(change, n));
            add(changes, bodies);
            system.settle(0.0, h, bodies, &mut ())?;
            let (mut lack, mut size, mut worst) = (zero, T::from_f64(f64::MIN_POSITIVE), 0.0_f64);
            for (body, change) in changes.iter().enumerate() {
                let (p, p_low) = (&bodies.p.as_ref()[body], &bodies.p_low.as_ref()[body]);
                let moved = minus(p, &self.first[body]);
                lacks[body] = minus(&sum(&moved, &minus(p_low, &self.low[body])), change);
                let (own, first) = (largest(&lacks[body]), largest(&self.first[body]));
                let own_size = largest(p).max(largest(change)).max(largest(&impulses[body])).max(first);
                (lack, size) = (lack.max(own), size.max(own_size));
                if !own.le(rounding * own_size) {
                    worst = worst.max((own / own_size).to_f64());
                }
            }
            // To the rounding of each body, or of all where that of one, at which impulses cancel, is brought no
            // nearer.
            let stalls = worst >= 0.5 * last && (worst <= most_settled || iteration >= PATIENCE);
            let settled = lack.le(rounding * size);
            if system.equations() == 0 || (settled && (worst == 0.0 || stalls)) {
                return Ok(());
            }
            last = worst;
            if iteration + 1 == MOST_ITERATIONS && lack.le(T::from_f64(most_settled) * size) {
                return Ok(());
            }
            improve([impulses, lacks], [impulses_before, lacks_before], iteration > 0);
        }
        Err(Failure { body: 0, cause: EffectFailure::FlowTooLong { effect, h }.into() })
    }

    fn put_back(&self, bodies: &mut BodiesOf<Y, T, D>) {
        bodies.p.as_mut().copy_from_slice(self.first);
        bodies.p_low.as_mut().copy_from_slice(self.low);
    }
}

/// The next impulses, N + r − γ (N − N₀ + r − r₀), with γ such that |r − γ (r − r₀)| is least; and what is there
/// becomes what was before.
fn improve<T: Scalar, const D: usize>(
    [impulses, lacks]: [&mut [[T; D]]; 2],
    [impulses_before, lacks_before]: [&mut [[T; D]]; 2],
    both: bool,
) {
    let zero = T::from_f64(0.0);
    let (mut along, mut square) = (zero, zero);
    if both {
        for (now, then) in lacks.iter().zip(&*lacks_before) {
            let change = minus(now, then);
            (along, square) = (along + dot(&change, now), square + dot(&change, &change));
        }
    }
    let gamma = T::select(zero.lt(square), along / square, zero);
    for body in 0..impulses.len() {
        let (impulse, lack) = (impulses[body], lacks[body]);
        let next = sum(&impulse, &lack);
        let back = minus(&next, &sum(&impulses_before[body], &lacks_before[body]));
        if both {
            impulses[body] = add_scaled(&next, -gamma, &back);
        } else {
            impulses[body] = next;
        }
        (impulses_before[body], lacks_before[body]) = (impulse, lack);
    }
}

fn minus<T: Scalar, const D: usize>(a: &[T; D], b: &[T; D]) -> [T; D] {
    add_scaled(a, T::from_f64(-1.0), b)
}

/// Adds changes to the momenta.
fn add<N: Count, T: Scalar, X, const D: usize>(changes: &[[T; D]], bodies: &mut Bodies<N, T, X, D>) {
    for ((p, low), change) in bodies.p.as_mut().iter_mut().zip(bodies.p_low.as_mut()).zip(changes) {
        (*p, *low) = two_sum(p, &sum(low, change));
    }
}
