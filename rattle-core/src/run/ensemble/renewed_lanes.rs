//! Steps that draw momenta anew, in lanes: [Brownian motion](crate::methods::brownian).
//!
//! Each step begins as after flows of momenta: a kick and a first guess from g̈ = 0, since nothing can be extrapolated
//! from the steps before. Its drift is that of [splittings](crate::run::ensemble::loops). The numbers that a lane draws
//! are those of a [`Simulation`](crate::run::simulation::Simulation).

use crate::effect::noise::Noise;
use crate::error::Error;
use crate::kernel::functions::ConstraintKernel;
use crate::methods::brownian;
use crate::motion::bodies::Body;
use crate::motion::failure::Failure;
use crate::motion::method::{Renewal, Stage};
use crate::motion::record::{Hallmark, Reading, Record};
use crate::motion::system::System;
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::{Fused, Lane, is_finite};
use crate::number::vector::dot;
use crate::number::vectors::{Vectors, at};
use crate::run::ensemble::around::LookingAround;
use crate::run::ensemble::asked::{Kicking, answered_by_laws, forces, hallmarks};
use crate::run::ensemble::block::{Block, Desk, OfLane, Part, Scratch};
use crate::run::ensemble::crossing::crossings;
use crate::run::ensemble::engine::{Draws, Engine, Leg, Moved, OwnSteps, Stuck, Tour};
use crate::run::ensemble::laws::{Laws, system_of};
use crate::run::ensemble::loops::step;
use crate::run::ensemble::rhythm::{InRhythm, Rhythm, Turn, When};
use crate::run::ensemble::splits::of_renewal;
use crate::run::ensemble::splitting_lanes::{in_lanes, of_a_kink_ahead, out_of_lanes};
use crate::run::ensemble::stirred::{LARGER, lead, look_apart};
use crate::run::ensemble::stirring::DEVIATIONS;
use crate::run::fingerprint::Looks;
use crate::run::trouble::Trouble;
use crate::solve::crowd::EVERY;
use std::any::Any;
use std::array::from_fn;
use std::hint::black_box;

/// A block, what its lanes obey, and what they draw.
#[derive(Clone)]
pub(crate) struct RenewedLanes<S, X, const L: usize, const D: usize, const SUMS: usize> {
    block: Block<S, L, D, SUMS, false>,
    laws: X,
    renewal: Renewal,
    /// The step, momenta being ahead by no kick; and with its kick.
    drift: Part,
    whole: Part,
    rhythm: Rhythm<L>,
    /// By lane the square of the momentum beyond which it is asked at once whether other sheets are near.
    limits: Vec<f64>,
    h: f64,
    set: Fusing,
}

impl<S: Lane, X: Laws<S, D>, const L: usize, const D: usize, const SUMS: usize>
    RenewedLanes<S, X, L, D, SUMS>
{
    /// Lanes, none of them set, that obey these laws in steps of h with momenta drawn so.
    pub(crate) fn new(laws: X, renewal: Renewal, h: f64, set: Fusing) -> Self {
        let part = |before| Part::of::<false>(&[Stage { before, h, after: 0.0 }])[0];
        let (drift, whole) = (part(0.0), part(renewal.kick));
        let rhythm = Rhythm::renewing(h);
        Self { block: Block::new(), laws, renewal, drift, whole, rhythm, limits: vec![0.0; L], h, set }
    }

    /// The largest momentum to expect.
    #[inline(always)]
    fn least(&self) -> f64 {
        DEVIATIONS * self.renewal.deviation
    }
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize> Engine<D> for RenewedLanes<S, X, L, D, SUMS>
where
    S: Lane + 'static,
    X: Laws<S, D> + 'static,
{
    fn width(&self) -> usize {
        L
    }

    fn divides(&self) -> bool {
        false
    }

    fn go(&self, tour: &mut dyn Tour<D>) -> Result<Box<dyn Engine<D>>, Vec<Stuck>> {
        let (block, limits) = self.set.run_lanes::<L, _>(Going { lanes: self, tour })?;
        let (laws, rhythm) = (self.laws.clone(), self.rhythm.clone());
        Ok(Box::new(Self { block, limits, laws, rhythm, ..*self }))
    }

    fn set(&mut self, lane: usize, bodies: &[Body<f64, D>]) -> bool {
        self.limits[lane] = 0.0;
        let of = OfLane { block: &mut self.block, lane, laws: &self.laws, parts: &[self.drift] };
        // Momenta of a start are nothing to its first step, but are shown before it.
        let [_, numbers] = self.set.run_narrow((of, bodies[0].map(S::from_f64)));
        numbers
    }

    fn copy(&mut self, from: usize, to: usize) {
        self.block.copy(from, to);
        self.limits[to] = self.limits[from];
    }

    fn obey(&mut self, from: usize, to: usize) {
        self.laws.copy(from, to);
        self.rhythm.copy(from, to);
    }

    fn obey_as_in(&mut self, engine: &dyn Engine<D>) {
        if let Some(engine) = (engine as &dyn Any).downcast_ref::<Self>() {
            (self.laws, self.rhythm) = (engine.laws.clone(), engine.rhythm.clone());
        }
    }

    fn draw_as(&mut self, lane: usize, draws: Draws) {
        self.rhythm.draw_as(lane, draws);
    }

    fn bodies(&self, lane: usize) -> Vec<Body<f64, D>> {
        let of = OfLane { block: &self.block, lane, laws: &self.laws, parts: &[self.drift] };
        vec![self.set.run_narrow(of)]
    }

    fn by_itself(
        &self,
        lane: usize,
        bodies: &[Body<f64, D>],
        OwnSteps { from, number, .. }: OwnSteps,
        _: &mut u64,
    ) -> Result<Moved<D>, Trouble> {
        let (system, noise) = (system_of(&self.laws, lane), |step| self.rhythm.noise(lane, from + step));
        Ok(by_itself::<S, _, D>(&system, self.renewal, self.h, &noise, number, bodies)?)
    }

    fn kick_alone(&self, steps: u32) {
        let kicking = Kicking { q: &self.block.q, way: self.block.way, laws: &self.laws, kicks: steps };
        black_box(self.set.run_lanes::<L, _>(kicking));
    }

    fn forces(&self) -> Vec<&'static str> {
        forces(&self.laws)
    }

    fn record(&self, to: &mut Record) {
        self.block.record(to);
        to.list("square to ask at", &self.limits);
    }

    fn recalled(&self, from: &mut Reading<'_>) -> Result<Box<dyn Engine<D>>, Error> {
        let block = Block::recalled(from, 1)?;
        let limits = from.numbers("square to ask at", &[L])?.to_vec();
        Ok(Box::new(Self { block, limits, ..self.clone() }))
    }

    fn hallmarks(&self, lane: usize, looks: &Looks<D>) -> Vec<Hallmark> {
        hallmarks::<S, X, D, SUMS>(&self.laws, lane, looks)
    }

    fn method(&self) -> Hallmark {
        of_renewal(self.renewal, self.h)
    }
}

answered_by_laws!(RenewedLanes);

/// Where bodies are after so many steps of h that draw momenta anew, each with the noise of its number.
#[cold]
#[inline(never)]
pub(super) fn by_itself<S: Lane, Y: System<S, D>, const D: usize>(
    system: &Y,
    renewal: Renewal,
    h: f64,
    noise: &dyn Fn(u64) -> Noise,
    steps: u64,
    places: &[Body<f64, D>],
) -> Result<Moved<D>, Failure> {
    let mut bodies = system.bodies(&in_lanes(places), 0.0);
    for number in 0..steps {
        if number > 0 {
            system.refresh(&mut bodies); // as where a run is divided: bits depend on no division
        }
        bodies.noise = noise(number);
        let start = bodies.saved();
        if let Err(failure) = brownian::step(renewal, h, system, &mut bodies, &mut ()) {
            return Err(of_a_kink_ahead(system, &start, &mut bodies, failure, |bodies| {
                bodies.noise = noise(number);
                brownian::coast(renewal, h, system, bodies);
            }));
        }
        system.check_kinks(&start, &bodies)?;
    }
    Ok((out_of_lanes(&bodies.all()), 0.0))
}

/// A block on a tour.
struct Going<'a, S, X, const L: usize, const D: usize, const SUMS: usize> {
    lanes: &'a RenewedLanes<S, X, L, D, SUMS>,
    tour: &'a mut dyn Tour<D>,
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize> Work for Going<'_, S, X, L, D, SUMS>
where
    S: Lane,
    X: Laws<S, D>,
{
    type Done = Result<(Block<S, L, D, SUMS, false>, Vec<f64>), Stuck>;

    #[inline(always)]
    fn run(self) -> Self::Done {
        let Self { lanes, tour } = self;
        let laws = lanes.laws.clone(); // out of reach of what the loops write
        let mut desk = Desk::of(lanes.block.clone());
        let Desk { block, scratch, .. } = &mut desk;
        let mut limits = lanes.limits.clone();
        let mut steps_of = Stepping { lanes, laws: &laws, block, scratch, limits: &mut limits };
        while let Some(Leg { from, steps, written, shown }) = tour.next() {
            if from == 0 && steps > 0 {
                steps_of.forget();
            }
            let end = from + steps;
            // One place where it looks around, since all of that is inlined.
            for now in from..=end {
                let due = if now == end { shown && steps > 0 } else { now % EVERY == 0 };
                if due {
                    steps_of.look_around(now)?;
                }
                if now == end {
                    break;
                }
                steps_of.block.measure_after(now);
                let start = steps_of.block.q;
                lanes.rhythm.step(&mut steps_of, now, 1)?;
                if const { !X::Constraint::KINKS.is_empty() } {
                    crossings(&laws, &start, &steps_of.block.q)?;
                }
            }
            if steps > 0 {
                steps_of.check()?;
            }
            if let Some(written) = written {
                let (q, p) = steps_of.block.all(&laws, &[lanes.drift]);
                written.fill(L, |lane| at(&q, lane).map(S::to_f64), |lane| at(&p, lane).map(S::to_f64));
            }
        }
        Ok((desk.block, limits))
    }
}

/// Steps of a block.
struct Stepping<'a, S, X, const L: usize, const D: usize, const SUMS: usize> {
    lanes: &'a RenewedLanes<S, X, L, D, SUMS>,
    laws: &'a X,
    block: &'a mut Block<S, L, D, SUMS, false>,
    scratch: &'a mut Scratch<S, L, D>,
    limits: &'a mut [f64],
}

impl<S: Lane, X: Laws<S, D>, const L: usize, const D: usize, const SUMS: usize>
    Stepping<'_, S, X, L, D, SUMS>
{
    /// Asks whether other sheets are near all lanes, after so many steps, as far as momenta may lead that are drawn
    /// until it is asked again.
    #[inline(always)]
    fn look_around(&mut self, steps: u64) -> Result<(), Stuck> {
        let Self { lanes: RenewedLanes { whole, .. }, laws, block, .. } = self;
        let (least, lanes) = (self.lanes.least(), &[true; L]);
        LookingAround { block, laws: *laws, parts: &[*whole], steps, lanes, least: &|_| least }.run()?;
        self.set_limits(lanes);
        Ok(())
    }

    /// Sets the limits of these lanes.
    #[inline(always)]
    fn set_limits(&mut self, these: &[bool; L]) {
        let least = self.lanes.least();
        for (l, limit) in self.limits.iter_mut().enumerate().filter(|&(l, _)| these[l]) {
            let way = at(&self.block.way, l);
            *limit = LARGER * LARGER * dot(&way, &way).to_f64().max(least * least);
        }
    }

    /// Whether places and the forces there are numbers.
    #[inline(always)]
    fn check(&self) -> Result<(), Stuck> {
        for lane in 0..L {
            let q = at(&self.block.q, lane);
            let kicked = self.laws.kick(lane, &q, S::from_f64(self.lanes.renewal.kick), q);
            if !kicked.into_iter().all(is_finite) {
                return Err(Stuck::not_finite(lane));
            }
        }
        Ok(())
    }
}

impl<S: Lane, X: Laws<S, D>, const L: usize, const D: usize, const SUMS: usize> InRhythm
    for Stepping<'_, S, X, L, D, SUMS>
{
    /// Draws momenta; the kick that follows has them be along the surface.
    #[inline(always)]
    fn act(&mut self, when: When) -> Result<(), Stuck> {
        let RenewedLanes { renewal: Renewal { seed, deviation, .. }, rhythm, .. } = self.lanes;
        let mut noise: Vectors<Fused<f64>, L, D> = [[Fused(0.0); L]; D];
        rhythm.draw_all(&[*seed; L], Turn { number: 0, place: 0, when }, &mut noise);
        for d in 0..D {
            for l in 0..L {
                self.block.way[d][l] = S::from_f64(*deviation * noise[d][l].0);
            }
        }
        Ok(())
    }

    #[inline(always)]
    fn lead(&mut self) -> Result<(), Stuck> {
        lead(self.block, self.laws, &self.lanes.drift, self.lanes.renewal.kick);
        let within = |lanes: &Self, l: usize| {
            let way = at(&lanes.block.way, l);
            dot(&way, &way).to_f64() <= lanes.limits[l] // not where it is no number
        };
        let mut all = true;
        for l in 0..L {
            all &= within(self, l);
        }
        if all {
            return Ok(());
        }
        // No others, so that what becomes of a lane depends on that lane alone.
        let beyond = from_fn(|l| !within(self, l));
        let (lanes, least) = (self.lanes, self.lanes.least());
        look_apart(lanes.set, self.block, self.laws, &[lanes.whole], &beyond, &|_| least)?;
        self.set_limits(&beyond);
        Ok(())
    }

    #[inline(always)]
    fn advance(&mut self, _: usize, _: u64) -> Result<(), Stuck> {
        step(self.block, self.laws, &[self.lanes.drift], self.scratch)
    }

    #[inline(always)]
    fn forget(&mut self) {
        let (Block { way, way_low, guess, past, .. }, zero) = (&mut *self.block, [S::default(); L]);
        (*way, *way_low, *guess, *past) = ([zero; D], [[zero; D]; SUMS], zero, [zero; 2]);
    }
}
