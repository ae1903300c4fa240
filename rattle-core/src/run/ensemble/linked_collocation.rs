//! Steps of linked bodies in lanes by collocation: the stages of [`lobatto`](crate::methods::lobatto) solved together,
//! as [a simulation](crate::systems::linked) does.
//!
//! ```text
//! Qᵢ = q + h cᵢ v + h² Σⱼ aᵢⱼ wⱼ       wⱼ = M⁻¹(f(Qⱼ) + G(Qⱼ)ᵀλⱼ)       0 = g(Qᵢ),   i = 2 … s,   Q₁ = q
//! v̂ = v + h Σⱼ bⱼ wⱼ,   j < s          and the last kick by the forces at q′ = Qₛ, before v̂ is projected there
//! δλⱼ = −Σᵢ (h² a)⁻¹ⱼᵢ (G₀M⁻¹G₀ᵀ)⁻¹ rᵢ
//! ```
//!
//! **First guess:** w and λ are the polynomials through the last step's stages and this step's exact start; a lane that
//! has no last step begins with the acceleration at its start. **A lane has arrived** where the last displacement of
//! its stages was below half a rounding, or no longer shrinks among roundings. Its stages are then not changed, however
//! many passes its neighbours take. A lane whose stages are not found so takes the step by itself.

use crate::kernel::rounding::size_of_terms;
use crate::motion::table::Table;
use crate::number::instructions::Work;
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::run::ensemble::linked_plan::{LinkedPlan, Places, add_product};
use crate::run::ensemble::linked_projected_row::{at_least, terms};
use crate::run::ensemble::linked_row::{Course, add_times};
use crate::run::ensemble::linked_stand::{Departs, Pulls, Stand};
use crate::run::ensemble::pace::{ARRIVED, MOVES};
use crate::run::ensemble::track::Track;
use crate::solve::stop::{LAST_OF_STAGES, NOISE};
use crate::systems::network::in_lanes::{Number, Numbers, Which, any, zeros};

/// Passes after which a lane goes by itself.
const MOST_PASSES: usize = 40;

/// Displacements that shrink by less than this are roundings, from this pass on where they are small …
const STALLED: (f64, usize) = (0.9, 4);

/// … and from this pass on have no end where they are not.
const PATIENCE: usize = 20;

/// Coefficients of a method with a step size; of each what rounding took from it, too.
pub(super) struct Coefficients {
    stages: usize,
    /// h cᵢ; h² aᵢⱼ, row by row; h bⱼ.
    drift: Vec<[Number; 2]>,
    push: Vec<[Number; 2]>,
    kick: Vec<[Number; 2]>,
    /// −(h² a)⁻¹, row j and column i.
    inverse: Vec<Number>,
    /// Row i, column j: the polynomial that is 1 at cⱼ and 0 at the other nodes, at 1 + cᵢ.
    ahead: Vec<Number>,
}

impl Coefficients {
    /// Those of this table.
    pub(super) fn of<const S: usize>(table: &Table<S>, h: f64) -> Self {
        let pair = |(high, low): (f64, f64)| [high, low].map(Fused);
        let square = |of: &dyn Fn(usize, usize) -> f64| -> Vec<Number> {
            (0..S * S).map(|at| Fused(of(at / S, at % S))).collect()
        };
        Self {
            stages: S,
            drift: (0..S).map(|i| pair(table.drift(h, i))).collect(),
            push: (0..S * S).map(|at| pair(table.push(h, at / S, at % S))).collect(),
            kick: (0..S).map(|i| pair(table.kick(h, i))).collect(),
            inverse: square(&|j, i| -table.inverse[j][i] / (h * h)),
            ahead: square(&|i, j| table.ahead[i][j]),
        }
    }
}

/// Where steps lead, by collocation.
pub(super) struct Collocation<const W: usize> {
    with: Coefficients,
    /// Groups of coordinates and of equations that reach each other, and which groups are of one loose body.
    groups: [Vec<usize>; 2],
    loose: Vec<bool>,
    /// 1 over the masses.
    over: Vec<Numbers<W>>,
    /// w and its change in this pass, stage by stage but for the last, and coordinate by coordinate.
    total: Vec<Numbers<W>>,
    change: Vec<Numbers<W>>,
    /// λ likewise, equation by equation; and residuals, or what answers them, of all stages.
    lambda: Vec<Numbers<W>>,
    right: Vec<Numbers<W>>,
    /// Entries of G, stage by stage.
    normals: Vec<Numbers<W>>,
    /// Displacements of a stage; changes of λ of a stage.
    shift: Vec<Numbers<W>>,
    multipliers: Vec<Numbers<W>>,
    /// How large coordinates are that are rounded, group by group: along normals, and of ways.
    sizes: Vec<Numbers<W>>,
    ways: Vec<Numbers<W>>,
    going: Which<W>,
    worst: Numbers<W>,
    last: Numbers<W>,
}

impl<const W: usize> Collocation<W> {
    /// Of bodies of so many coordinates.
    pub(super) fn new(with: Coefficients, plan: &LinkedPlan, dimension: usize) -> Self {
        let (s, n, m) = (with.stages, plan.coordinates, plan.equations);
        let rows = |number: usize| vec![zeros::<W>(); number];
        let (groups, number) = groups(plan, dimension);
        let loose = (0..number).map(|group| !groups[1].contains(&group)).collect();
        Self {
            with,
            groups,
            loose,
            over: plan.masses.iter().map(|&[_, over]| every(Fused(over))).collect(),
            total: rows((s - 1) * n),
            change: rows((s - 1) * n),
            lambda: rows((s - 1) * m),
            right: rows(s * m),
            normals: rows(s * plan.of_entry.len()),
            shift: rows(n),
            multipliers: rows(m),
            sizes: rows(number),
            ways: rows(number),
            going: [ARRIVED; W],
            worst: zeros(),
            last: zeros(),
        }
    }
}

/// How often a step of so many stages evaluates forces, about: some passes, and once at the end. For the bill.
pub(super) const fn evaluations(stages: u32) -> u32 {
    6 * (stages - 2) + 1
}

/// How many numbers of each lane go on from step to step: whether there are any, w and λ of all stages but the last.
pub(super) fn remembered(stages: usize, plan: &LinkedPlan) -> usize {
    1 + (stages - 1) * (plan.coordinates + plan.equations)
}

/// The group of each coordinate, and of each equation: of bodies that are linked, or one that is loose.
fn groups(plan: &LinkedPlan, dimension: usize) -> ([Vec<usize>; 2], usize) {
    let mut of_body: Vec<usize> = (0..plan.coordinates / dimension).collect();
    let moves = |c: usize| plan.masses[c][1] != 0.0;
    for entries in &plan.of_row {
        let linked: Vec<_> =
            entries.iter().filter(|&&[_, c]| moves(c)).map(|[_, c]| of_body[c / dimension]).collect();
        if let Some(&least) = linked.iter().min() {
            of_body.iter_mut().filter(|of| linked.contains(of)).for_each(|of| *of = least);
        }
    }
    let mut names = of_body.clone();
    names.sort_unstable();
    names.dedup();
    let named = |c: usize| names.binary_search(&of_body[c / dimension]).unwrap_or(0);
    let of_row =
        |entries: &Vec<[usize; 2]>| entries.iter().find(|&&[_, c]| moves(c)).map_or(0, |&[_, c]| named(c));
    ([(0..plan.coordinates).map(named).collect(), plan.of_row.iter().map(of_row).collect()], names.len())
}

impl<const W: usize> Departs<W> for Collocation<W> {
    fn depart(&mut self, stand: &mut Stand<'_, W>, pulling: &mut Pulls<'_, '_, W>) {
        stand.course.set.run(Depart { collocation: self, stand, pulling });
    }

    fn lands(&self) -> bool {
        true
    }

    fn kick(&mut self, stand: &mut Stand<'_, W>, pulling: &mut Pulls<'_, '_, W>) {
        let [last, _] = self.with.kick[self.with.stages - 1];
        stand.course.set.run(Kick { last, stand, pulling });
    }
}

/// See [`Departs::kick`].
struct Kick<'a, 'b, 'c, 'd, const W: usize> {
    last: Number,
    stand: &'a mut Stand<'b, W>,
    pulling: &'a mut Pulls<'c, 'd, W>,
}

impl<const W: usize> Work for Kick<'_, '_, '_, '_, W> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { last, stand, pulling } = self;
        stand.pull_there(pulling);
        let (plan, way_low) = (stand.course.plan, stand.course.plan.places.way_low);
        for &c in &plan.moving {
            add_times(last, &stand.pulled[c], &mut stand.numbers[way_low + c]);
        }
    }
}

/// See [`Departs::depart`].
struct Depart<'a, 'b, 'c, 'd, const W: usize> {
    collocation: &'a mut Collocation<W>,
    stand: &'a mut Stand<'b, W>,
    pulling: &'a mut Pulls<'c, 'd, W>,
}

impl<const W: usize> Work for Depart<'_, '_, '_, '_, W> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { collocation, stand, pulling } = self;
        stand.pace.begin_inner();
        (stand.pace.next, stand.pace.taken) = (stand.pace.inner, [true; W]);
        for l in 0..W {
            collocation.going[l] = if stand.pace.takes(l) { MOVES } else { ARRIVED };
        }
        collocation.begin(stand);
        for pass in 0..MOST_PASSES {
            collocation.evaluate(stand, pulling);
            collocation.answer(stand);
            collocation.correct(stand);
            collocation.measure(stand);
            if !collocation.decide(pass, stand) {
                break;
            }
        }
        collocation.arrive(stand);
    }
}

impl<const W: usize> Collocation<W> {
    /// The first guess, and the matrix of the start.
    #[inline(always)]
    fn begin(&mut self, stand: &mut Stand<'_, W>) {
        let Self { with, groups: [of_coordinate, of_row], loose, over, total, lambda, normals, .. } = self;
        let Stand { course: Course { plan, over: of_lanes, .. }, numbers, tracks, past, .. } = stand;
        let (s, n, entries) = (with.stages, plan.coordinates, plan.of_entry.len());
        let (Places { gradient, .. }, sizes) = (plan.places, &mut self.sizes);
        if let Some(of_lanes) = of_lanes {
            over.copy_from_slice(of_lanes);
        }
        let (filled, past) = past.split_at(1);
        let (before, multipliers) = past.split_at((s - 1) * n);
        extrapolate(with, &filled[0], &stand.pull, before, total);
        extrapolate(with, &filled[0], &stand.multipliers, multipliers, lambda);
        normals[..entries].copy_from_slice(&stand.normals);
        numbers[gradient..gradient + entries].copy_from_slice(&stand.normals);
        plan.lift(*of_lanes, numbers);
        plan.factor.carry_out(numbers);
        sizes.fill(zeros());
        for (i, entries) in plan.of_row.iter().enumerate() {
            let (mut square, mut along, mut most) = (zeros::<W>(), zeros::<W>(), zeros::<W>());
            for &[entry, c] in entries {
                terms(&stand.normals[entry], &tracks[0].now[c], &mut square, &mut along, &mut most);
            }
            size_of_row(&square, &along, &most, &mut sizes[of_row[i]]);
        }
        for &c in plan.moving.iter().filter(|&&c| loose[of_coordinate[c]]) {
            larger(&tracks[0].now[c], &mut sizes[of_coordinate[c]]);
        }
        self.last = every(Fused(f64::INFINITY));
    }

    /// g, its gradients and w at all stages, and what w changes by.
    #[inline(always)]
    fn evaluate(&mut self, stand: &mut Stand<'_, W>, pulling: &mut Pulls<'_, '_, W>) {
        let Self {
            with, groups: [of_coordinate, _], over, total, change, lambda, right, normals, ways, ..
        } = self;
        let Stand { course, numbers, tracks, .. } = stand;
        let Course { plan, links, set, .. } = *course;
        let Places { q, g, gradient, change: free, .. } = plan.places;
        let (s, n, m, entries) = (with.stages, plan.coordinates, plan.equations, plan.of_entry.len());
        let square = with.drift[s - 1][0] * with.drift[s - 1][0];
        change[..n].fill(zeros());
        ways.fill(zeros());
        for i in 1..s {
            for &c in &plan.moving {
                let mut by = zeros();
                way_to(with, i, n, c, total, &tracks[1], &mut by);
                let from = [&tracks[0].now[c], &tracks[0].low[c]];
                lead(&by, from, &mut numbers[q + c], &mut ways[of_coordinate[c]]);
            }
            links.gradients(plan, set, q, numbers);
            normals[i * entries..][..entries].copy_from_slice(&numbers[gradient..gradient + entries]);
            right[i * m..][..m].copy_from_slice(&numbers[g..g + m]);
            if i == s - 1 {
                continue; // of the last stage only the place counts
            }
            numbers[free..free + n].fill(zeros());
            course.kick(1.0, free, numbers, pulling);
            for &c in &plan.moving {
                // A way is the sum of what forces alone do and of what constraints do, and is rounded as both.
                at_least(square, &numbers[free + c], &mut ways[of_coordinate[c]]);
            }
            for (entry, &[c, row]) in plan.of_entry.iter().enumerate() {
                let normal = &normals[i * entries + entry];
                pull(&over[c], normal, &lambda[i * m + row], &mut numbers[free + c]);
            }
            for &c in &plan.moving {
                let at = i * n + c;
                renew(&self.going, &numbers[free + c], &mut total[at], &mut change[at]);
            }
        }
    }

    /// What the normals of the start answer to rᵢ = gᵢ + Gᵢ h² Σⱼ aᵢⱼ (change of stage j).
    #[inline(always)]
    fn answer(&mut self, stand: &mut Stand<'_, W>) {
        let Self { with, change, right, normals, shift, .. } = self;
        let Stand { course: Course { plan, .. }, numbers, .. } = stand;
        let (Places { g, x, .. }, entries) = (plan.places, plan.of_entry.len());
        let (n, m) = (plan.coordinates, plan.equations);
        for i in 1..with.stages {
            displace(with, i, n, &plan.moving, change, shift);
            let right = &mut right[i * m..][..m];
            for (entry, &[c, row]) in plan.of_entry.iter().enumerate() {
                add_product(&mut right[row], &normals[i * entries + entry], &shift[c]);
            }
            numbers[g..g + m].copy_from_slice(right);
            plan.solve(numbers);
            right.copy_from_slice(&numbers[x..x + m]);
        }
    }

    /// Corrects λ, and w by what it pulls.
    #[inline(always)]
    fn correct(&mut self, stand: &mut Stand<'_, W>) {
        let Self { with, over, total, change, lambda, right, normals, multipliers, going, .. } = self;
        let plan = stand.course.plan;
        let (s, n, m, entries) = (with.stages, plan.coordinates, plan.equations, plan.of_entry.len());
        for j in 0..s - 1 {
            multipliers.fill(zeros());
            for i in 1..s {
                for (sum, answer) in multipliers.iter_mut().zip(&right[i * m..]) {
                    add_times(with.inverse[j * s + i], answer, sum);
                }
            }
            for (multiplier, lambda) in multipliers.iter_mut().zip(&mut lambda[j * m..]) {
                add_where(going, multiplier, lambda);
            }
            for (entry, &[c, row]) in plan.of_entry.iter().enumerate() {
                let (normal, at) = (&normals[j * entries + entry], j * n + c);
                let mut by = zeros();
                pull(&over[c], normal, &multipliers[row], &mut by);
                add(&by, &mut total[at]);
                add(&by, &mut change[at]);
            }
        }
    }

    /// By how many roundings stages are displaced, at most.
    #[inline(always)]
    fn measure(&mut self, stand: &mut Stand<'_, W>) {
        let Self { with, groups: [of_coordinate, _], change, shift, sizes, ways, worst, .. } = self;
        let Stand { course: Course { plan, .. }, tracks, .. } = stand;
        *worst = zeros();
        for i in 1..with.stages {
            displace(with, i, plan.coordinates, &plan.moving, change, shift);
            for &c in &plan.moving {
                let group = of_coordinate[c];
                slower(&shift[c], &tracks[0].now[c], [&sizes[group], &ways[group]], worst);
            }
        }
    }

    /// Which lanes have arrived after this pass, and which go by themselves; returns whether any goes on.
    #[inline(always)]
    fn decide(&mut self, pass: usize, stand: &mut Stand<'_, W>) -> bool {
        let Self { going, worst, last, .. } = self;
        let long = NOISE * (stand.course.plan.equations as f64).sqrt().max(1.0); // roundings of a chain add up along it
        for l in 0..W {
            let (worst, before) = (worst.0[l].0, last.0[l].0);
            let stalled = worst >= STALLED.0 * before;
            let arrived = (worst <= LAST_OF_STAGES) | (pass >= STALLED.1) & stalled & (worst <= long);
            let finds = (worst <= f64::MAX) & !((pass >= PATIENCE) & stalled) & (pass + 1 < MOST_PASSES);
            let goes = going[l] == MOVES;
            stand.pace.doubt(l, !goes | arrived | finds);
            going[l] = if goes & !arrived & finds { MOVES } else { ARRIVED };
        }
        *last = *worst;
        any(going)
    }

    /// Where stages lead, and what the next step begins with.
    #[inline(always)]
    fn arrive(&mut self, stand: &mut Stand<'_, W>) {
        let Self { with, total, lambda, .. } = self;
        let plan = stand.course.plan;
        for &c in &plan.moving {
            let [mut by, mut kicked] = [zeros(); 2];
            way_to(with, with.stages - 1, plan.coordinates, c, total, &stand.tracks[1], &mut by);
            kicks(with, plan.coordinates, c, total, &mut kicked);
            stand.arrive(c, [&by, &kicked]);
        }
        let past = &mut stand.past;
        past[0] = every(Fused(1.0));
        for (to, from) in past[1..].iter_mut().zip(total.iter().chain(&*lambda)) {
            *to = *from;
        }
    }
}

/// The polynomials through the last step's stages and this step's start, where lanes have a last step; else what is at
/// the start everywhere.
#[inline(always)]
fn extrapolate<const W: usize>(
    with: &Coefficients,
    filled: &Numbers<W>,
    start: &[Numbers<W>],
    past: &[Numbers<W>],
    to: &mut [Numbers<W>],
) {
    let (s, n) = (with.stages, start.len());
    to[..n].copy_from_slice(start);
    for i in 1..s - 1 {
        let ahead = &with.ahead[i * s..][..s];
        for c in 0..n {
            let mut sum = zeros();
            add_times(ahead[s - 1], &start[c], &mut sum);
            for j in 0..s - 1 {
                add_times(ahead[j], &past[j * n + c], &mut sum);
            }
            for l in 0..W {
                to[i * n + c].0[l] = Real::select(filled.0[l].0 == 1.0, sum.0[l], start[c].0[l]);
            }
        }
    }
}

/// How large the coordinates are whose rounding moves an equation along its normal, if no other's are larger.
#[inline(always)]
fn size_of_row<const W: usize>(
    square: &Numbers<W>,
    along: &Numbers<W>,
    most: &Numbers<W>,
    size: &mut Numbers<W>,
) {
    for l in 0..W {
        let length = square.0[l].sqrt();
        let own = size_of_terms(along.0[l], Fused(0.0), most.0[l] * length) / length;
        size.0[l] = size.0[l].max(own);
    }
}

/// The way of a coordinate to a stage: what rounding took comes first, since added to a rounded sum it would be lost.
#[inline(always)]
fn way_to<const W: usize>(
    with: &Coefficients,
    stage: usize,
    n: usize,
    c: usize,
    total: &[Numbers<W>],
    velocities: &Track<W>,
    to: &mut Numbers<W>,
) {
    let (drift, pushes) = (with.drift[stage], &with.push[stage * with.stages..]);
    let (v, v_low) = (&velocities.now[c], &velocities.low[c]);
    for l in 0..W {
        to.0[l] = drift[1].multiply_add(v.0[l], drift[0] * v_low.0[l]);
    }
    for j in 0..with.stages - 1 {
        add_times(pushes[j][1], &total[j * n + c], to);
    }
    for j in 0..with.stages - 1 {
        add_times(pushes[j][0], &total[j * n + c], to);
    }
    add_times(drift[0], v, to);
}

/// What a velocity is kicked by, but for the last kick.
#[inline(always)]
fn kicks<const W: usize>(with: &Coefficients, n: usize, c: usize, total: &[Numbers<W>], to: &mut Numbers<W>) {
    for part in [1, 0] {
        for j in 0..with.stages - 1 {
            add_times(with.kick[j][part], &total[j * n + c], to);
        }
    }
}

/// Leads a coordinate to a stage, and notes how far that is.
#[inline(always)]
fn lead<const W: usize>(
    by: &Numbers<W>,
    [from, low]: [&Numbers<W>; 2],
    to: &mut Numbers<W>,
    farthest: &mut Numbers<W>,
) {
    for l in 0..W {
        to.0[l] = from.0[l] + (low.0[l] + by.0[l]);
        farthest.0[l] = farthest.0[l].max(by.0[l].abs());
    }
}

/// Notes the size of a coordinate.
#[inline(always)]
fn larger<const W: usize>(q: &Numbers<W>, most: &mut Numbers<W>) {
    for l in 0..W {
        most.0[l] = most.0[l].max(q.0[l].abs());
    }
}

/// Adds what a multiplier pulls a coordinate by.
#[inline(always)]
fn pull<const W: usize>(
    over: &Numbers<W>,
    normal: &Numbers<W>,
    multiplier: &Numbers<W>,
    to: &mut Numbers<W>,
) {
    for l in 0..W {
        to.0[l] = (over.0[l] * normal.0[l]).multiply_add(multiplier.0[l], to.0[l]);
    }
}

/// Renews a number of the lanes that go on, and notes by how much it changes there.
#[inline(always)]
fn renew<const W: usize>(lanes: &Which<W>, new: &Numbers<W>, to: &mut Numbers<W>, change: &mut Numbers<W>) {
    for l in 0..W {
        let by = Real::select(lanes[l] == MOVES, new.0[l] - to.0[l], Fused(0.0));
        to.0[l] = Real::select(lanes[l] == MOVES, new.0[l], to.0[l]);
        change.0[l] = by;
    }
}

/// h² Σⱼ aᵢⱼ (change of stage j) of all coordinates.
#[inline(always)]
fn displace<const W: usize>(
    with: &Coefficients,
    stage: usize,
    n: usize,
    coordinates: &[usize],
    change: &[Numbers<W>],
    to: &mut [Numbers<W>],
) {
    let pushes = &with.push[stage * with.stages..];
    for &c in coordinates {
        let mut sum = zeros();
        for j in 0..with.stages - 1 {
            add_times(pushes[j][0], &change[j * n + c], &mut sum);
        }
        to[c] = sum;
    }
}

/// A displacement in roundings, where that is more than those before, and where it is no number.
#[inline(always)]
fn slower<const W: usize>(
    shift: &Numbers<W>,
    q: &Numbers<W>,
    [size, way]: [&Numbers<W>; 2],
    worst: &mut Numbers<W>,
) {
    for l in 0..W {
        let size = size.0[l].max(way.0[l]).max(q.0[l].abs());
        let ratio =
            Real::select(shift.0[l].0 == 0.0, Fused(0.0), shift.0[l].abs() / (Fused(f64::EPSILON) * size));
        let before = worst.0[l];
        let kept = (ratio.0 <= before.0) | before.0.is_nan();
        worst.0[l] = Real::select(kept, before, ratio);
    }
}

/// Changes a number of some lanes; in others the change is made none.
#[inline(always)]
fn add_where<const W: usize>(lanes: &Which<W>, change: &mut Numbers<W>, to: &mut Numbers<W>) {
    for l in 0..W {
        change.0[l] = Real::select(lanes[l] == MOVES, change.0[l], Fused(0.0));
        to.0[l] = to.0[l] + change.0[l];
    }
}

#[inline(always)]
fn add<const W: usize>(by: &Numbers<W>, to: &mut Numbers<W>) {
    for l in 0..W {
        to.0[l] = to.0[l] + by.0[l];
    }
}

/// The same number in all lanes.
fn every<const W: usize>(x: Number) -> Numbers<W> {
    let mut all = zeros();
    all.0 = [x; W];
    all
}
