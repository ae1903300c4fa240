//! The RATTLE step of a row of trajectories of linked bodies.
//!
//! ```text
//! q′ = q + h v + M⁻¹Gᵀ(q) Λ                               Λ such that g(q′) = 0
//! v′ = v + M⁻¹Gᵀ(q) Λ/h − k M⁻¹∇U(q′) + M⁻¹Gᵀ(q′) η       η such that G(q′) v′ = 0
//! ```
//!
//! As in a [block](crate::run::ensemble::block) of single bodies, velocities are stored ahead and multiplied by the
//! step length, and equal steps need no η. Λ₀ is extrapolated from the last steps; Newton's method continues from there
//! with the matrix G(q′) M⁻¹Gᵀ(q) of the first guess, factored on the pattern of the links without a search for pivots.
//!
//! **Stopping.** Small residuals get one last correction, and G is evaluated once more where that leads. A lane that
//! has converged is not changed while others are corrected again, so every lane depends on its own past alone.
//!
//! **Which root.** Each ∇gᵢ(q′)·M⁻¹∇gᵢ(q) must be within an eighth of its value at the start, and pivots must not be
//! too small a part of it. Lanes that violate this, or do not converge, are solved as a
//! [`Simulation`](crate::run::simulation::Simulation) does. Every 64 steps other sheets are searched for
//! ([`crate::solve::crowd`]).

use crate::kernel::rounding::size_of_terms;
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::number::vector;
use crate::run::ensemble::block::{Part, extrapolated};
use crate::run::ensemble::engine::Stuck;
use crate::run::ensemble::forces_in_lanes::{Pulled, Pulling, Rows};
use crate::run::ensemble::linked_plan::{LinkedPlan, Links, Places, Takes};
use crate::systems::network::elimination::LOSSY;
use crate::systems::network::in_lanes::{Number, Numbers, Which, any, lost, ran_away, zeros};

/// So many roundings of the coordinates that a link depends on are left to the last correction. Its matrix is that of
/// the place before: of a residual r, as a part of coordinates, it leaves some r³ᐟ², which is 1/256 of a rounding then.
const AT_REST: f64 = 4096.0;

/// The slope ∇gᵢ(q′)·M⁻¹∇gᵢ(q) differs from what it was by no more than one over this: the cosine of the half by which
/// a normal may turn on a path that is [short](crate::solve::root).
pub(super) const TURN: f64 = 8.0;

/// Further corrections after which a lane goes apart.
const CORRECTIONS: usize = 5;

/// Pivots are no smaller than one over this, relative to what they were formed of: elimination then loses no more than
/// [twelve bits](LOSSY) of multipliers, and six of what they displace, which Newton's method finds again. In a straight
/// chain of n links that is eliminated from both ends the last pivot is 4/n.
pub(super) const PIVOT: f64 = 1.0 / LOSSY;

/// Finds the Λ of a lane that cannot go with the others.
pub(super) type Apart<'a, const W: usize> =
    dyn FnMut(usize, &Part, &[Numbers<W>]) -> Result<Vec<f64>, Stuck> + 'a;

/// What a row obeys, and the parts of its steps.
pub(super) struct Course<'a, const W: usize> {
    pub(super) plan: &'a LinkedPlan,
    pub(super) links: &'a Links<W>,
    /// 1 over the masses of all lanes, coordinate by coordinate, where they differ.
    pub(super) over: Option<&'a [Numbers<W>]>,
    pub(super) parts: &'a [Part],
    /// Whether all steps are equal.
    pub(super) equal: bool,
    /// Whether sums are compensated.
    pub(super) sums: bool,
    pub(super) set: Fusing,
}

/// Rows of linked bodies.
pub(super) struct LinkedRow;

impl<const W: usize> Rows<W> for LinkedRow {
    /// Coordinates; for each the mass and 1 over it; and what so many times M⁻¹f is added to.
    type Bodies<'a> = (&'a [Numbers<W>], &'a [[f64; 2]], &'a mut [Numbers<W>]);
}

impl<const D: usize, const W: usize> Pulled<D, W> for LinkedRow {
    type Times = [Number; D];
    type To = [Numbers<W>; D];

    #[inline(always)]
    fn each<'a>(
        times: f64,
        (q, masses, to): &'a mut Self::Bodies<'_>,
    ) -> impl Iterator<Item = ([Number; D], &'a [Numbers<W>; D], &'a mut [Numbers<W>; D])> {
        let bodies = q.as_chunks().0.iter().zip(masses.as_chunks::<D>().0).zip(to.as_chunks_mut().0);
        bodies.map(move |((q, masses), to)| (masses.map(|[_, over]| Fused(times * over)), q, to))
    }

    #[inline(always)]
    fn stays(times: [Number; D]) -> bool {
        times.iter().all(|times| times.0 == 0.0)
    }

    #[inline(always)]
    fn pull<const N: usize>(
        times: [Number; D],
        _: &[Numbers<N>; D],
        force: &[Numbers<N>; D],
        first: usize,
        to: &mut [Numbers<W>; D],
    ) {
        for d in 0..D {
            for l in 0..N {
                to[d].0[first + l] = times[d].multiply_add(force[d].0[l], to[d].0[first + l]);
            }
        }
    }
}

/// Writes `f` of each lane of these numbers.
#[inline(always)]
pub(super) fn each<const N: usize, const W: usize>(
    to: usize,
    of: [usize; N],
    numbers: &mut [Numbers<W>],
    f: impl Fn([Number; N]) -> Number,
) {
    let mut row = zeros();
    each_lane(&mut row, of.map(|number| &numbers[number]), f);
    numbers[to] = row;
}

/// See [`each`].
#[inline(always)]
fn each_lane<const N: usize, const W: usize>(
    row: &mut Numbers<W>,
    of: [&Numbers<W>; N],
    f: impl Fn([Number; N]) -> Number,
) {
    for l in 0..W {
        row.0[l] = f(of.map(|numbers| numbers.0[l]));
    }
}

impl<const W: usize> Course<'_, W> {
    /// Whether all ways are numbers, and no body has run away.
    #[inline(always)]
    pub(super) fn check(&self, numbers: &[Numbers<W>]) -> Result<(), Stuck> {
        let LinkedPlan { places: Places { q, way, .. }, coordinates: n, .. } = self.plan;
        let lost = lost(numbers[*way..way + n].iter()).or_else(|| ran_away(&numbers[*q..q + n]));
        lost.map_or(Ok(()), |lane| Err(Stuck { lane, failure: None }))
    }

    /// One part of a step.
    #[inline(always)]
    pub(super) fn advance(
        &self,
        part: &Part,
        numbers: &mut [Numbers<W>],
        pulling: &mut Option<&mut (dyn Pulling<LinkedRow, W> + '_)>,
        apart: &mut Apart<'_, W>,
    ) -> Result<(), Stuck> {
        let Self { plan, links, sums, set, .. } = *self;
        let m = plan.equations;
        let Places { q, q_low, way, way_low, guess, free, trial, lambda, found, .. } = plan.places;
        let share = Fused(part.h / part.unit);
        for &c in &plan.moving {
            if sums {
                let of = [q + c, way + c, q_low + c, way_low + c];
                each(free + c, of, numbers, |[q, way, q_low, way_low]| {
                    share.multiply_add(way, q + share.multiply_add(way_low, q_low))
                });
            } else {
                each(free + c, [q + c, way + c], numbers, |[q, way]| share.multiply_add(way, q));
            }
        }
        for i in 0..m {
            numbers[lambda + i] = numbers[guess + i];
        }
        plan.place.carry_out(numbers);
        links.gradients(plan, set, trial, numbers);
        plan.factor.carry_out(numbers);
        let mut going = self.astray(numbers);
        let astray = going;
        plan.correct(lambda, lambda, numbers);
        plan.place.carry_out(numbers);
        links.gradients(plan, set, trial, numbers);
        going = self.unrest(&going, numbers);
        plan.correct(lambda, found, numbers);
        if any(&going) {
            self.go_on(&mut going, &astray, numbers);
            for lane in (0..W).filter(|&lane| going[lane] != 0) {
                self.go_apart(lane, part, numbers, apart)?;
            }
        }
        self.finish(part, numbers, pulling);
        Ok(())
    }

    /// Corrects lanes that are not at rest, by Newton's method; at the end `going` are those that need more of it.
    /// Nothing changes in others.
    #[inline(always)]
    fn go_on(&self, going: &mut Which<W>, astray: &Which<W>, numbers: &mut [Numbers<W>]) {
        let Self { plan, links, set, .. } = *self;
        let Places { trial, lambda, found, .. } = plan.places;
        for _ in 0..CORRECTIONS {
            if going == astray {
                return;
            }
            plan.factor.carry_out(numbers);
            plan.solve(numbers);
            self.correct(lambda, going, numbers);
            plan.place.carry_out(numbers);
            links.gradients(plan, set, trial, numbers);
            let unrest = self.unrest(astray, numbers);
            plan.solve(numbers);
            self.correct(found, going, numbers);
            *going = unrest;
        }
    }

    /// Writes Λ less the correction in these lanes.
    #[inline(always)]
    fn correct(&self, to: usize, lanes: &Which<W>, numbers: &mut [Numbers<W>]) {
        let Places { lambda, x, .. } = self.plan.places;
        for i in 0..self.plan.equations {
            let (mut all, from, by) = (numbers[to + i], numbers[lambda + i], numbers[x + i]);
            for l in 0..W {
                all.0[l] = Real::select(lanes[l] != 0, from.0[l] - by.0[l], all.0[l]);
            }
            numbers[to + i] = all;
        }
    }

    /// These lanes, and those in which a residual is more than it may be at rest, or is no number.
    #[inline(always)]
    fn unrest(&self, beside: &Which<W>, numbers: &[Numbers<W>]) -> Which<W> {
        let Places { g, rest, .. } = self.plan.places;
        let mut which = *beside;
        for i in 0..self.plan.equations {
            let (g, rest) = (&numbers[g + i], &numbers[rest + i]);
            for l in 0..W {
                which[l] = if g.0[l].0.abs() <= rest.0[l].0 { which[l] } else { 1 };
            }
        }
        which
    }

    /// In which lanes the constraints may have been left, or depend on each other, as the matrix just factored says.
    #[inline(always)]
    fn astray(&self, numbers: &[Numbers<W>]) -> Which<W> {
        let Places { diagonal, inverse, square, .. } = self.plan.places;
        let mut which = [0; W];
        for i in 0..self.plan.equations {
            let (slope, inverse, square) =
                (&numbers[diagonal + i], &numbers[inverse + i], &numbers[square + i]);
            for l in 0..W {
                let (slope, inverse, square) = (slope.0[l].0, inverse.0[l].0, square.0[l].0);
                let upright = TURN * (slope - square).abs() <= square;
                let clear = (0.0 < inverse) & (inverse * slope <= PIVOT);
                which[l] = if upright & clear { which[l] } else { 1 };
            }
        }
        which
    }

    /// Finds where the step leads a lane that cannot go with the others.
    #[cold]
    #[inline(never)]
    fn go_apart(
        &self,
        lane: usize,
        part: &Part,
        numbers: &mut [Numbers<W>],
        apart: &mut Apart<'_, W>,
    ) -> Result<(), Stuck> {
        let multipliers = apart(lane, part, numbers)?;
        let lanes = numbers[self.plan.places.found..].iter_mut().map(|numbers| &mut numbers.0[lane]);
        lanes.zip(multipliers).for_each(|(to, from)| *to = Fused(from));
        Ok(())
    }

    /// Makes the new positions and ways, and the next guess.
    #[inline(always)]
    fn finish(
        &self,
        part: &Part,
        numbers: &mut [Numbers<W>],
        pulling: &mut Option<&mut (dyn Pulling<LinkedRow, W> + '_)>,
    ) {
        let Self { plan, equal, sums, .. } = *self;
        let Places { way, way_low, found, guess, last, earlier, .. } = plan.places;
        let (share, over) = (Fused(part.h / part.unit), part.over.map(Fused));
        if sums {
            plan.displace.hand_over(numbers, &MoveSums { places: &plan.places, share, over });
        } else {
            plan.displace.hand_over(numbers, &Move { places: &plan.places, over: over[0] });
        }
        // What residuals leave to the last correction has one sign for many steps: by normals of the place before it
        // the energy drifts by up to 1e-16 of itself a stage.
        self.links.gradients(plan, self.set, plan.places.q, numbers);
        if part.kick != 0.0 {
            self.kick(part.unit * part.kick, if sums { way_low } else { way }, numbers, pulling);
        }
        plan.lift(self.over, numbers);
        if !equal {
            self.project(numbers);
        } else if sums {
            for &c in &plan.moving {
                two_sum(way + c, way_low + c, way_low + c, numbers);
            }
        }
        let weights = part.weights.map(Fused);
        for i in 0..plan.equations {
            let (new, before, mut first) = (numbers[found + i], numbers[last + i], numbers[earlier + i]);
            for l in 0..W {
                first.0[l] = extrapolated(equal, weights, new.0[l], before.0[l], first.0[l]);
            }
            (numbers[guess + i], numbers[last + i], numbers[earlier + i]) = (first, new, before);
        }
    }

    /// Adds this many times M⁻¹f, with the forces where bodies are.
    #[inline(always)]
    pub(super) fn kick(
        &self,
        times: f64,
        to: usize,
        numbers: &mut [Numbers<W>],
        pulling: &mut Option<&mut (dyn Pulling<LinkedRow, W> + '_)>,
    ) {
        let (Some(pulling), LinkedPlan { coordinates: n, places: Places { q, pull, .. }, masses, .. }) =
            (pulling, self.plan)
        else {
            return;
        };
        let Some(over) = self.over else {
            if let Ok([q, to]) = numbers.get_disjoint_mut([*q..q + n, to..to + n]) {
                pulling.pull(self.set, times, (q, masses, to));
            }
            return;
        };
        if let Ok([q, pull]) = numbers.get_disjoint_mut([*q..q + n, *pull..pull + n]) {
            pull.fill(zeros());
            pulling.pull(self.set, 1.0, (q, masses, pull));
        }
        // Rounded as where masses are the same: bits depend on no neighbour.
        for c in 0..*n {
            let (over, force, mut sum) = (&over[c], numbers[pull + c], numbers[to + c]);
            for l in 0..W {
                sum.0[l] = (Fused(times) * over.0[l]).multiply_add(force.0[l], sum.0[l]);
            }
            numbers[to + c] = sum;
        }
    }

    /// Makes ways lead along the constraints, by G and M⁻¹Gᵀ as they are.
    #[inline(always)]
    pub(super) fn project(&self, numbers: &mut [Numbers<W>]) {
        self.set.run(Projection { course: self, numbers });
    }

    /// What |g| may be at rest, by the gradients just evaluated.
    #[inline(always)]
    pub(super) fn rest(&self, numbers: &mut [Numbers<W>]) {
        let (plan, share) = (self.plan, Fused(Part::longest(self.parts)));
        let Places { q, way, gradient, rest, x, lambda, .. } = plan.places;
        let (lengths, sizes) = (x, lambda); // which nothing reads before they are written again
        for i in 0..plan.equations {
            (numbers[lengths + i], numbers[sizes + i], numbers[rest + i]) = (zeros(), zeros(), zeros());
        }
        let mut path: Numbers<W> = zeros();
        for coordinate in 0..plan.coordinates {
            let ways = &numbers[way + coordinate];
            path.0.iter_mut().zip(&ways.0).for_each(|(most, way)| *most = most.max(share * way.abs()));
        }
        for (entry, &[coordinate, i]) in plan.of_entry.iter().enumerate() {
            each(lengths + i, [lengths + i, gradient + entry], numbers, |[most, x]| most.max(x.abs()));
            let of = [sizes + i, q + coordinate, way + coordinate];
            each(sizes + i, of, numbers, |[most, q, way]| most.max(q.abs()).max(share * way.abs()));
            let of = [rest + i, gradient + entry, q + coordinate, way + coordinate];
            each(rest + i, of, numbers, |[along, x, q, way]| {
                x.abs().multiply_add(q.abs().max(share * way.abs()), along)
            });
        }
        for i in 0..plan.equations {
            for l in 0..W {
                let [along, length, size] = [rest + i, lengths + i, sizes + i].map(|x| numbers[x].0[l]);
                numbers[rest + i].0[l] = at_rest(along, path.0[l], length, size);
            }
        }
    }
}

/// See [`Course::project`]. Work by itself: it is long, and many ask for it.
struct Projection<'a, 'b, const W: usize> {
    course: &'a Course<'b, W>,
    numbers: &'a mut [Numbers<W>],
}

impl<const W: usize> Work for Projection<'_, '_, W> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { course: &Course { plan, sums, .. }, numbers } = self;
        let Places { way, way_low, change, .. } = plan.places;
        for &c in &plan.moving {
            if sums {
                each(change + c, [way + c, way_low + c], numbers, |[way, low]| way + low);
            } else {
                numbers[change + c] = numbers[way + c];
            }
        }
        plan.factor.carry_out(numbers);
        plan.rates.carry_out(numbers);
        plan.solve(numbers);
        for &c in &plan.moving {
            numbers[change + c] = numbers[if sums { way_low } else { way } + c];
        }
        plan.push.carry_out(numbers);
        for &c in &plan.moving {
            if sums {
                two_sum(way + c, way_low + c, change + c, numbers);
            } else {
                numbers[way + c] = numbers[change + c];
            }
        }
    }
}

/// Moves a coordinate on by what constraints make of it.
struct Move<'a> {
    places: &'a Places,
    over: Number,
}

impl<const W: usize> Takes<W> for Move<'_> {
    #[inline(always)]
    fn take(&self, place: usize, moved: &Numbers<W>, numbers: &mut [Numbers<W>]) {
        let Places { q, way, free, change, .. } = *self.places;
        let c = place - change;
        let mut to = numbers[free + c];
        for l in 0..W {
            to.0[l] = to.0[l] + moved.0[l];
        }
        numbers[q + c] = to;
        add_times(self.over, moved, &mut numbers[way + c]);
    }
}

/// The same with compensated sums; what ways change by is left in their low digits.
struct MoveSums<'a> {
    places: &'a Places,
    share: Number,
    over: [Number; 2],
}

impl<const W: usize> Takes<W> for MoveSums<'_> {
    #[inline(always)]
    fn take(&self, place: usize, moved: &Numbers<W>, numbers: &mut [Numbers<W>]) {
        let Places { q, q_low, way, way_low, change, .. } = *self.places;
        let (c, share, mut by) = (place - change, self.share, zeros());
        let (way, back, low) = (&numbers[way + c], &numbers[q_low + c], &numbers[way_low + c]);
        for l in 0..W {
            by.0[l] = share.multiply_add(low.0[l], back.0[l]) + share.multiply_add(way.0[l], moved.0[l]);
        }
        add(q + c, q_low + c, &by, numbers);
        let (low, [over, rest]) = (&mut numbers[way_low + c], self.over);
        for l in 0..W {
            low.0[l] = over.multiply_add(moved.0[l], rest.multiply_add(moved.0[l], low.0[l]));
        }
    }
}

/// What |g| may be at rest, from the sum of its terms, from how far bodies go, and from the largest coordinates of ∇g
/// and of places.
#[inline(always)]
pub(super) fn at_rest(along: Number, path: Number, length: Number, size: Number) -> Number {
    Fused(AT_REST * f64::EPSILON) * size_of_terms(along, path * length, length * size)
}

/// Adds `by` to a number that is a sum of two.
#[inline(always)]
pub(super) fn two_sum<const W: usize>(high: usize, low: usize, by: usize, numbers: &mut [Numbers<W>]) {
    let by = numbers[by];
    add(high, low, &by, numbers);
}

/// See [`two_sum`].
#[inline(always)]
fn add<const W: usize>(high: usize, low: usize, by: &Numbers<W>, numbers: &mut [Numbers<W>]) {
    let (mut sum, mut rest) = (numbers[high], zeros());
    for l in 0..W {
        let ([s], [r]) = vector::two_sum(&[sum.0[l]], &[by.0[l]]);
        (sum.0[l], rest.0[l]) = (s, r);
    }
    (numbers[high], numbers[low]) = (sum, rest);
}

/// Adds this many times `by`.
#[inline(always)]
pub(super) fn add_times<const W: usize>(times: Number, by: &Numbers<W>, to: &mut Numbers<W>) {
    for l in 0..W {
        to.0[l] = times.multiply_add(by.0[l], to.0[l]);
    }
}
