//! The plan of a step of linked bodies in lanes, made once: which products of numbers make which number.
//!
//! A [row](crate::run::ensemble::linked_row) of trajectories stores its numbers in one list; each entry has one number
//! for every trajectory. A [`Sheet`] is a list of sums of products of such entries. So the topology of the links is
//! read once, and a step consists of loops over lanes that know nothing of bodies.

use crate::number::instructions::Fusing;
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::systems::network::group::LinkGroup;
use crate::systems::network::in_lanes::{Numbers, RowLinks, zeros};
use crate::systems::network::mass::Root;
use crate::systems::network::pattern::Pattern;
use crate::systems::network::rows::Rows;
use crate::systems::network::shape::Shape;
use std::ops::Range;

/// More numbers than that are not kept side by side: they would be read from far away in each step.
const MOST_NUMBERS: usize = 16_384;

/// So many equations, or fewer, have entries for all pairs of them, and are eliminated in turn, as
/// [those of sizes that are compiled](crate::run::ensemble::linked_few) are.
const FEW: usize = 3;

/// Sums of products.
#[derive(Debug, Clone, Default)]
pub(super) struct Sheet {
    sums: Vec<Sum>,
    /// The factors of all products, in turn.
    products: Vec<[u32; 2]>,
}

/// One of them: a number, and what products add to it and then take from it.
#[derive(Debug, Clone)]
struct Sum {
    to: u32,
    from: u32,
    added: Range<u32>,
    taken: Range<u32>,
    end: End,
}

/// What becomes of a sum.
#[derive(Debug, Clone, Copy)]
pub(super) enum End {
    /// It is the number.
    Plain,
    /// It is multiplied by this one.
    Times(usize),
    /// Its inverse is the number.
    Inverse,
}

/// Who is handed each sum of a sheet. (No closure: what is not inlined is compiled for no instruction set.)
pub(super) trait Takes<const W: usize> {
    /// Takes the sum that was written to this place. Must be `#[inline(always)]`.
    fn take(&self, place: usize, sum: &Numbers<W>, numbers: &mut [Numbers<W>]);
}

impl<const W: usize> Takes<W> for () {
    #[inline(always)]
    fn take(&self, _: usize, _: &Numbers<W>, _: &mut [Numbers<W>]) {}
}

/// Writes `from` less x.
struct Less {
    from: usize,
    to: usize,
    x: usize,
}

impl<const W: usize> Takes<W> for Less {
    #[inline(always)]
    fn take(&self, place: usize, by: &Numbers<W>, numbers: &mut [Numbers<W>]) {
        let i = place - self.x;
        let mut less = numbers[self.from + i];
        for l in 0..W {
            less.0[l] = less.0[l] - by.0[l];
        }
        numbers[self.to + i] = less;
    }
}

impl Sheet {
    /// One more sum.
    fn put(&mut self, to: usize, from: usize, added: &[[usize; 2]], taken: &[[usize; 2]], end: End) {
        let mut all = |products: &[[usize; 2]]| {
            let first = self.products.len();
            self.products.extend(products.iter().map(|factors| factors.map(index)));
            index(first)..index(self.products.len())
        };
        let (added, taken) = (all(added), all(taken));
        self.sums.push(Sum { to: index(to), from: index(from), added, taken, end });
    }

    /// Computes all of them in turn.
    #[inline(always)]
    pub(super) fn carry_out<const W: usize>(&self, numbers: &mut [Numbers<W>]) {
        self.hand_over(numbers, &());
    }

    /// The same, and hands over each as it is written.
    #[inline(always)]
    pub(super) fn hand_over<const W: usize>(&self, numbers: &mut [Numbers<W>], to_whom: &impl Takes<W>) {
        for Sum { to, from, added, taken, end } in &self.sums {
            let mut sum = numbers[*from as usize];
            for &[a, b] in &self.products[added.start as usize..added.end as usize] {
                add_product(&mut sum, &numbers[a as usize], &numbers[b as usize]);
            }
            for &[a, b] in &self.products[taken.start as usize..taken.end as usize] {
                take_product(&mut sum, &numbers[a as usize], &numbers[b as usize]);
            }
            match *end {
                End::Plain => {}
                End::Times(factor) => {
                    for l in 0..W {
                        sum.0[l] = sum.0[l] * numbers[factor].0[l];
                    }
                }
                End::Inverse => {
                    for l in 0..W {
                        sum.0[l].0 = 1.0 / sum.0[l].0;
                    }
                }
            }
            numbers[*to as usize] = sum;
            to_whom.take(*to as usize, &sum, numbers);
        }
    }
}

/// Adds a product of two numbers of each lane.
#[inline(always)]
pub(super) fn add_product<const W: usize>(sum: &mut Numbers<W>, a: &Numbers<W>, b: &Numbers<W>) {
    for l in 0..W {
        sum.0[l] = a.0[l].multiply_add(b.0[l], sum.0[l]);
    }
}

#[inline(always)]
fn take_product<const W: usize>(sum: &mut Numbers<W>, a: &Numbers<W>, b: &Numbers<W>) {
    for l in 0..W {
        sum.0[l] = (-a.0[l]).multiply_add(b.0[l], sum.0[l]);
    }
}

fn index(i: usize) -> u32 {
    u32::try_from(i).unwrap_or(u32::MAX) // there are no more than `MOST_NUMBERS`
}

/// Where the numbers of a row begin: one for each coordinate, each entry of the gradients, or each equation.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Places {
    /// Positions, and what rounding took from them.
    pub(super) q: usize,
    pub(super) q_low: usize,
    /// M⁻¹ times momenta, ahead by the first kick of the step to come, times [`Part::unit`]; and what rounding took.
    ///
    /// [`Part::unit`]: crate::run::ensemble::block::Part
    pub(super) way: usize,
    pub(super) way_low: usize,
    /// M⁻¹Gᵀ(q), entry by entry.
    pub(super) lifted: usize,
    /// Λ₀ of the step to come, and Λ of the last two, the last one first.
    pub(super) guess: usize,
    pub(super) last: usize,
    pub(super) earlier: usize,
    /// ∇gᵢ·M⁻¹∇gᵢ.
    pub(super) square: usize,
    /// What |gᵢ| may be at rest.
    pub(super) rest: usize,
    /// What is kept from step to step ends here; what follows is room for one step.
    pub(super) kept: usize,
    /// q + h v.
    pub(super) free: usize,
    pub(super) trial: usize,
    /// M⁻¹GᵀΛ; or a way that is to be made one along the constraints.
    pub(super) change: usize,
    pub(super) g: usize,
    /// G at the trial.
    pub(super) gradient: usize,
    /// The diagonal of G(q′) M⁻¹Gᵀ(q), and the inverse pivots.
    pub(super) diagonal: usize,
    pub(super) inverse: usize,
    lower: usize,
    upper: usize,
    pub(super) lambda: usize,
    pub(super) found: usize,
    pub(super) x: usize,
    y: usize,
    zero: usize,
    /// Forces, where masses differ between lanes.
    pub(super) pull: usize,
    /// The end of all.
    pub(super) end: usize,
}

/// A network made ready for trajectories side by side.
pub(super) struct LinkedPlan {
    pub(super) places: Places,
    /// Coordinates of all bodies, equations that can be solved for, and entries of their gradients.
    pub(super) coordinates: usize,
    pub(super) equations: usize,
    entries: usize,
    /// Equations and coordinates of a component that goes [by itself](crate::run::ensemble::linked_few), where it is
    /// all that moves.
    pub(super) few: Option<(usize, usize)>,
    /// For each coordinate its mass and 1 over it; both 0 where pinned. Of one where they differ between lanes.
    pub(super) masses: Vec<[f64; 2]>,
    /// The coordinates that are not pinned.
    pub(super) moving: Vec<usize>,
    /// For each entry its coordinate, and its equation; those of an equation in turn.
    pub(super) of_entry: Vec<[usize; 2]>,
    /// For each equation its entries and their coordinates, in the order of these.
    pub(super) of_row: Vec<Vec<[usize; 2]>>,
    /// The equations of each component.
    pub(super) components: Vec<Range<usize>>,
    /// The number of each row among the equations of the scene.
    pub(super) equation: Vec<usize>,
    /// The trial, from what is free and Λ.
    pub(super) place: Sheet,
    /// M⁻¹GᵀΛ of what was found.
    pub(super) displace: Sheet,
    /// The matrix of the position equation, factored.
    pub(super) factor: Sheet,
    /// What solves it for g: forwards, and back to x.
    pub(super) forwards: Sheet,
    pub(super) back: Sheet,
    /// How fast a way leads off the constraints, and what x makes of it.
    pub(super) rates: Sheet,
    pub(super) push: Sheet,
}

impl LinkedPlan {
    /// For so many bodies of D coordinates; none where they cannot go side by side. `sums` says whether sums are
    /// compensated, `apart` whether masses differ between lanes.
    #[inline(never)]
    pub(super) fn of<const D: usize>(shape: &Shape<D>, sums: bool, apart: bool) -> Option<Self> {
        let mut masses = masses(shape)?;
        if apart {
            let one = |x: f64| if x == 0.0 { 0.0 } else { 1.0 };
            masses.iter_mut().for_each(|mass| *mass = mass.map(one));
        }
        // Not those of links between pinned bodies, which hold or do not.
        let equations = shape.components.iter().map(|component| component.rows.equations()).sum();
        let (n, m, entries) = (masses.len(), equations, shape.blocks * D);
        let mut pieces: Vec<Piece> = Vec::new();
        let (mut lower, mut upper) = (0, 0);
        for component in &shape.components {
            let rows = &component.rows;
            let mut of_body = vec![Vec::new(); rows.bodies.len()];
            for row in 0..rows.equations() {
                rows.blocks_of(row).for_each(|(_, body)| of_body[body].push(row));
            }
            let m = rows.equations();
            let pattern = if m <= FEW { Pattern::full(m) } else { Pattern::new(&of_body, m) };
            let firsts = (lower, upper);
            lower += pattern.lower.len();
            upper += pattern.upper.len();
            pieces.push(Piece { rows, row: component.first.0, block: component.first.1, pattern, firsts });
        }

        let (mut places, mut next) = (Places::default(), 0);
        let mut take = |number: usize| {
            next += number;
            next - number
        };
        places.q = take(n);
        places.q_low = take(if sums { n } else { 0 });
        places.way = take(n);
        places.way_low = take(if sums { n } else { 0 });
        places.lifted = take(entries);
        for place in [&mut places.guess, &mut places.last, &mut places.earlier] {
            *place = take(m);
        }
        (places.square, places.rest) = (take(m), take(m));
        places.kept = take(0);
        (places.free, places.trial, places.change) = (take(n), take(n), take(n));
        (places.g, places.gradient) = (take(m), take(entries));
        (places.diagonal, places.inverse) = (take(m), take(m));
        (places.lower, places.upper) = (take(lower), take(upper));
        (places.lambda, places.found, places.x, places.y) = (take(m), take(m), take(m), take(m));
        (places.zero, places.pull) = (take(1), take(if apart { n } else { 0 }));
        places.end = take(0);
        if places.end > MOST_NUMBERS {
            return None;
        }

        let mut plan = Self {
            places,
            coordinates: n,
            equations: m,
            entries,
            few: None,
            moving: (0..n).filter(|&c| masses[c][1] != 0.0).collect(),
            masses,
            of_entry: vec![[usize::MAX; 2]; entries],
            of_row: vec![Vec::new(); m],
            components: Vec::new(),
            equation: vec![0; m],
            place: Sheet::default(),
            displace: Sheet::default(),
            factor: Sheet::default(),
            forwards: Sheet::default(),
            back: Sheet::default(),
            rates: Sheet::default(),
            push: Sheet::default(),
        };
        let side_by_side = plan.moving.windows(2).all(|pair| pair[0] + 1 == pair[1]);
        if let [Piece { rows, .. }] = &pieces[..]
            && rows.bodies.len() * D == plan.moving.len()
            && side_by_side
            && !apart
        {
            plan.few = Some((m, plan.moving.len()));
        }
        let mut by_coordinate = vec![Vec::new(); n];
        for piece in &pieces {
            plan.components.push(piece.row..piece.row + piece.rows.equations());
            for row in 0..piece.rows.equations() {
                plan.equation[piece.row + row] = piece.rows.equation(row);
                for (block, body) in piece.rows.touched_by(row) {
                    for d in 0..D {
                        let (entry, coordinate) = ((piece.block + block) * D + d, body * D + d);
                        plan.of_entry[entry] = [coordinate, piece.row + row];
                        plan.of_row[piece.row + row].push([entry, coordinate]);
                        if plan.masses[coordinate][1] != 0.0 {
                            by_coordinate[coordinate].push((entry, piece.row + row));
                        }
                    }
                }
            }
            plan.eliminate::<D>(piece);
        }
        plan.of_row.iter_mut().for_each(|entries| entries.sort_by_key(|&[_, coordinate]| coordinate));
        let Places { lifted, free, trial, change, lambda, found, x, zero, .. } = places;
        for &c in &plan.moving {
            let entries = &by_coordinate[c];
            let products = |of: usize| -> Vec<_> {
                entries.iter().map(|&(entry, row)| [lifted + entry, of + row]).collect()
            };
            plan.place.put(trial + c, free + c, &products(lambda), &[], End::Plain);
            plan.displace.put(change + c, zero, &products(found), &[], End::Plain);
            if !entries.is_empty() {
                plan.push.put(change + c, change + c, &[], &products(x), End::Plain);
            }
        }
        Some(plan)
    }

    /// Writes down the elimination of a component.
    fn eliminate<const D: usize>(&mut self, piece: &Piece<'_>) {
        let Piece { rows, row, block, pattern, firsts } = piece;
        let Places { lifted, gradient, g, diagonal, inverse, lower, upper, x, y, zero, change, .. } =
            self.places;
        let (lower, upper) = (lower + firsts.0, upper + firsts.1);
        let entry = |block_of_row: usize, d: usize| (block + block_of_row) * D + d;
        // ∇gᵢ(q′)·M⁻¹∇gⱼ(q), as products.
        let entries = |i: usize, j: usize| -> Vec<[usize; 2]> {
            let pairs = in_turn(rows, i).into_iter().flat_map(|(a, body)| {
                rows.blocks_of(j).filter(move |&(_, other)| other == body).map(move |(b, _)| (a, b))
            });
            let each = pairs.flat_map(|(a, b)| (0..D).map(move |d| (a, b, d)));
            each.map(|(a, b, d)| [gradient + entry(a, d), lifted + entry(b, d)]).collect()
        };
        // Where entry (k, j) of L, and (j, k) of U, is.
        let of_lower = |k: usize, j: usize| {
            let columns = &pattern.lower[pattern.lower_start[k]..pattern.lower_start[k + 1]];
            columns.binary_search(&j).ok().map(|at| lower + pattern.lower_start[k] + at)
        };
        let of_upper = |k: usize, j: usize| {
            let columns = &pattern.upper[pattern.upper_start[k]..pattern.upper_start[k + 1]];
            columns.binary_search(&j).ok().map(|at| upper + pattern.upper_start[k] + at)
        };
        let columns = |k: usize| pattern.lower[pattern.lower_start[k]..pattern.lower_start[k + 1]].to_vec();
        // What rows before `past` take from entry (i, j).
        let taken = |i: usize, j: usize, past: usize| -> Vec<[usize; 2]> {
            let before = columns(i).into_iter().filter(|&k| k < past);
            before.filter_map(|k| Some([of_lower(i, k)?, of_upper(k, j)?])).collect()
        };
        let m = pattern.order.len();
        let (factor, forwards, back) = (&mut self.factor, &mut self.forwards, &mut self.back);
        for i in 0..m {
            let own = pattern.order[i];
            for k in columns(i) {
                let Some(to) = of_lower(i, k) else { continue };
                let end = End::Times(inverse + row + pattern.order[k]);
                factor.put(to, zero, &entries(own, pattern.order[k]), &taken(i, k, k), end);
            }
            let (all, place) = (entries(own, own), diagonal + row + own);
            factor.put(place, zero, &all, &[], End::Plain);
            factor.put(inverse + row + own, place, &[], &taken(i, i, i), End::Inverse);
            for &j in &pattern.upper[pattern.upper_start[i]..pattern.upper_start[i + 1]] {
                let Some(to) = of_upper(i, j) else { continue };
                factor.put(to, zero, &entries(own, pattern.order[j]), &taken(i, j, i), End::Plain);
            }
            let known: Vec<_> =
                columns(i).into_iter().filter_map(|k| Some([of_lower(i, k)?, y + row + k])).collect();
            forwards.put(y + row + i, g + row + own, &[], &known, End::Plain);
        }
        for i in (0..m).rev() {
            let own = pattern.order[i];
            let known: Vec<_> = pattern.upper[pattern.upper_start[i]..pattern.upper_start[i + 1]]
                .iter()
                .filter_map(|&j| Some([of_upper(i, j)?, x + row + pattern.order[j]]))
                .collect();
            back.put(x + row + own, y + row + i, &[], &known, End::Times(inverse + row + own));
        }
        for i in 0..m {
            let blocks = in_turn(rows, i).into_iter().map(|(block, body)| (block, rows.bodies[body]));
            let each = blocks.flat_map(|(block, body)| (0..D).map(move |d| (block, body * D + d, d)));
            let along: Vec<_> = each.map(|(block, c, d)| [gradient + entry(block, d), change + c]).collect();
            self.rates.put(g + row + i, zero, &along, &[], End::Plain);
        }
    }

    /// Solves for x, and writes `from` less x.
    #[inline(always)]
    pub(super) fn correct<const W: usize>(&self, from: usize, to: usize, numbers: &mut [Numbers<W>]) {
        let Places { x, .. } = self.places;
        self.forwards.carry_out(numbers);
        self.back.hand_over(numbers, &Less { from, to, x });
    }

    /// Solves for x.
    #[inline(always)]
    pub(super) fn solve<const W: usize>(&self, numbers: &mut [Numbers<W>]) {
        self.forwards.carry_out(numbers);
        self.back.carry_out(numbers);
    }

    /// Writes M⁻¹Gᵀ from G, and ∇gᵢ·M⁻¹∇gᵢ; with M⁻¹ of each lane where they differ.
    #[inline(always)]
    pub(super) fn lift<const W: usize>(&self, of_lanes: Option<&[Numbers<W>]>, numbers: &mut [Numbers<W>]) {
        let Places { lifted, gradient, square, .. } = self.places;
        for (i, entries) in self.of_row.iter().enumerate() {
            let mut sum = zeros::<W>();
            for &[entry, coordinate] in entries {
                let (over, of) = (Fused(self.masses[coordinate][1]), &numbers[gradient + entry]);
                let mut up = zeros::<W>();
                if let Some(over) = of_lanes {
                    for l in 0..W {
                        up.0[l] = over[coordinate].0[l] * of.0[l];
                    }
                } else {
                    for l in 0..W {
                        up.0[l] = over * of.0[l];
                    }
                }
                for l in 0..W {
                    sum.0[l] = of.0[l].multiply_add(up.0[l], sum.0[l]);
                }
                numbers[lifted + entry] = up;
            }
            numbers[square + i] = sum;
        }
    }

    /// Writes ∇gᵢ·M⁻¹∇gᵢ with the gradients of another place: the diagonal of the matrix.
    #[inline(always)]
    pub(super) fn slopes<const W: usize>(&self, numbers: &mut [Numbers<W>]) {
        let Places { lifted, gradient, diagonal, .. } = self.places;
        for i in 0..self.equations {
            numbers[diagonal + i] = zeros();
        }
        for (entry, &[_, i]) in self.of_entry.iter().enumerate() {
            let mut sum = numbers[diagonal + i];
            add_product(&mut sum, &numbers[gradient + entry], &numbers[lifted + entry]);
            numbers[diagonal + i] = sum;
        }
    }
}

/// For each coordinate its mass and 1 over it, both 0 where pinned; none where a mass is a matrix.
#[inline(never)]
pub(super) fn masses<const D: usize>(shape: &Shape<D>) -> Option<Vec<[f64; 2]>> {
    let over = shape.roots.iter().map(Root::over_masses).collect::<Option<Vec<_>>>()?;
    let mass = |over: f64| if over == 0.0 { 0.0 } else { 1.0 / over };
    Some(over.as_flattened().iter().map(|&over| [mass(over), over]).collect())
}

/// The blocks of an equation, by the numbers of their bodies.
fn in_turn(rows: &Rows, i: usize) -> Vec<(usize, usize)> {
    let mut blocks: Vec<_> = rows.blocks_of(i).collect();
    blocks.sort_by_key(|&(_, body)| rows.bodies[body]);
    blocks
}

/// A component, where its rows and blocks begin, the pattern of its matrix, and where L and U begin.
struct Piece<'a> {
    rows: &'a Rows,
    row: usize,
    block: usize,
    pattern: Pattern,
    firsts: (usize, usize),
}

/// All links of a network, for W trajectories side by side.
#[derive(Clone)]
pub(super) struct Links<const W: usize>(Vec<OfOneKind<W>>);

/// Links of one kind, and where what they give is written.
#[derive(Clone)]
struct OfOneKind<const W: usize> {
    links: Box<dyn RowLinks<W>>,
    /// Members, their first row and first entry.
    runs: Vec<(Range<usize>, usize, usize)>,
    equations: usize,
    /// Entries of an equation.
    width: usize,
}

/// Members of a group in turn, their first row and first entry.
pub(super) fn runs<const D: usize>(shape: &Shape<D>, group: usize) -> Vec<(Range<usize>, usize, usize)> {
    let of_component = shape.components.iter().flat_map(|component| {
        let (row, block) = component.first;
        let own = component.rows.runs.iter().filter(move |run| run.group == group);
        own.map(move |run| (run.members.clone(), row + run.row, (block + run.block) * D))
    });
    of_component.collect()
}

impl<const W: usize> Links<W> {
    /// Those of a network, each group by its number; none where some cannot go side by side.
    pub(super) fn of<const D: usize>(
        shape: &Shape<D>,
        in_lanes: impl Fn(usize, &dyn LinkGroup<D>) -> Option<Box<dyn RowLinks<W>>>,
    ) -> Option<Self> {
        let mut links = Vec::new();
        for (number, group) in shape.groups.iter().enumerate() {
            let (equations, width) = (group.equations(), group.bodies().1 * D);
            let runs = runs(shape, number);
            links.push(OfOneKind { links: in_lanes(number, &**group)?, runs, equations, width });
        }
        Some(Self(links))
    }

    /// Has lane `to` obey what lane `from` does.
    pub(super) fn copy(&mut self, from: usize, to: usize) {
        self.0.iter_mut().for_each(|links| links.links.copy(from, to));
    }

    /// g and its gradients at these coordinates.
    #[inline(always)]
    pub(super) fn gradients(&self, plan: &LinkedPlan, set: Fusing, at: usize, numbers: &mut [Numbers<W>]) {
        let Places { g, gradient, .. } = plan.places;
        let ranges = [at..at + plan.coordinates, g..g + plan.equations, gradient..gradient + plan.entries];
        let Ok([q, g, gradients]) = numbers.get_disjoint_mut(ranges) else { return }; // as they are laid out
        self.gradients_at(set, q, g, gradients);
    }

    /// The same in rows of their own.
    #[inline(always)]
    pub(super) fn gradients_at(
        &self,
        set: Fusing,
        q: &[Numbers<W>],
        g: &mut [Numbers<W>],
        gradients: &mut [Numbers<W>],
    ) {
        for OfOneKind { links, runs, equations, width } in &self.0 {
            for (members, row, entry) in runs {
                let rows = members.len() * equations;
                let (g, gradients) = (&mut g[*row..row + rows], &mut gradients[*entry..entry + rows * width]);
                links.gradients(set, members.clone(), q, g, gradients);
            }
        }
    }

    /// d²g/dt² at these coordinates along constant velocities, and |∇²g v|².
    #[inline(always)]
    pub(super) fn bends(
        &self,
        set: Fusing,
        of: [&[Numbers<W>]; 2],
        bends: &mut [Numbers<W>],
        turns: &mut [Numbers<W>],
    ) {
        for OfOneKind { links, runs, equations, .. } in &self.0 {
            for (members, row, _) in runs {
                let rows = *row..*row + members.len() * equations;
                links.bends(set, members.clone(), of, &mut bends[rows.clone()], &mut turns[rows]);
            }
        }
    }
}
