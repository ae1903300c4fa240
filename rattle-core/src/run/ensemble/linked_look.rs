//! Readings of a row of trajectories of linked bodies outside of its steps: whether other sheets are near, and the
//! velocities of the bodies.

use crate::number::instructions::Work;
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::run::ensemble::block::Part;
use crate::run::ensemble::engine::Stuck;
use crate::run::ensemble::forces_in_lanes::Pulling;
use crate::run::ensemble::linked_plan::Places;
use crate::run::ensemble::linked_row::{Course, LinkedRow, each, two_sum};
use crate::solve::crowd::{self, PATH, RISES, ROOT_3, shares};
use crate::systems::network::in_lanes::{Numbers, Which, zeros};

impl<const W: usize> Course<'_, W> {
    /// Whether no other sheets are near these lanes, after so many steps; see [`crate::solve::crowd`]. Where flows stir
    /// bodies, ways are taken to be no shorter than the `least` of each coordinate, which is empty elsewhere.
    #[inline(always)]
    pub(super) fn look_around(
        &self,
        (steps, lanes): (u64, &Which<W>),
        part: &Part,
        least: &[Numbers<W>],
        numbers: &mut [Numbers<W>],
        pulling: &mut Option<&mut (dyn Pulling<LinkedRow, W> + '_)>,
    ) -> Result<(), Stuck> {
        self.set.run(Look { course: self, steps, lanes, part, least, numbers, pulling })
    }

    /// Writes velocities, times the unit of the part to come and along the constraints, to `free`, and what rounding
    /// took from them to `change`: with the kick of that part taken back, and by the normals where the bodies are. What
    /// is kept is no longer valid then.
    #[inline(always)]
    pub(super) fn velocities(
        &self,
        part: &Part,
        numbers: &mut [Numbers<W>],
        pulling: &mut Option<&mut (dyn Pulling<LinkedRow, W> + '_)>,
    ) {
        let Self { plan, links, sums, set, .. } = *self;
        let Places { q, way, way_low, free, change, .. } = plan.places;
        links.gradients(plan, set, q, numbers);
        plan.lift(self.over, numbers);
        for &c in &plan.moving {
            numbers[free + c] = if sums { numbers[way_low + c] } else { zeros() };
        }
        if part.lead != 0.0 {
            self.kick(-part.unit * part.lead, free, numbers, pulling);
        }
        for &c in &plan.moving {
            each(change + c, [way + c, free + c], numbers, |[way, low]| way + low);
        }
        plan.factor.carry_out(numbers);
        plan.rates.carry_out(numbers);
        plan.solve(numbers);
        for &c in &plan.moving {
            numbers[change + c] = numbers[free + c];
        }
        plan.push.carry_out(numbers);
        for &c in &plan.moving {
            numbers[free + c] = numbers[way + c];
            two_sum(free + c, change + c, change + c, numbers);
        }
    }
}

/// See [`Course::look_around`].
struct Look<'a, 'b, 'c, 'd, const W: usize> {
    course: &'a Course<'b, W>,
    steps: u64,
    lanes: &'a Which<W>,
    part: &'a Part,
    least: &'a [Numbers<W>],
    numbers: &'a mut [Numbers<W>],
    pulling: &'a mut Option<&'c mut (dyn Pulling<LinkedRow, W> + 'd)>,
}

impl<const W: usize> Work for Look<'_, '_, '_, '_, W> {
    type Done = Result<(), Stuck>;

    #[inline(always)]
    fn run(self) -> Result<(), Stuck> {
        let Self { course, steps, lanes, part, least, numbers, pulling } = self;
        let Course { plan, links, set, .. } = *course;
        let (n, m) = (plan.coordinates, plan.equations);
        let Places { q, way, lifted, guess, last, earlier, square, diagonal, .. } = plan.places;
        let Places { free, trial, change, lambda, found, x, .. } = plan.places;
        let &Part { h, unit, kick, reach, .. } = part;
        for c in 0..n {
            (numbers[free + c], numbers[change + c]) = (numbers[q + c], zeros());
        }
        course.kick(reach * h * kick, change, numbers, pulling);
        // By equation: the largest entry of M⁻¹Gᵀ, and how far the way and the forces of a step lead.
        let (entries, ways, pushes) = (x, found, lambda);
        for i in 0..m {
            for to in [entries, ways, pushes] {
                numbers[to + i] = zeros();
            }
        }
        for (entry, &[coordinate, i]) in plan.of_entry.iter().enumerate() {
            for (to, of) in
                [(entries, lifted + entry), (ways, way + coordinate), (pushes, change + coordinate)]
            {
                each(to + i, [to + i, of], numbers, |[most, x]| most.max(x.abs()));
            }
            if !least.is_empty() {
                let (mut way, least) = (numbers[ways + i], &least[coordinate]);
                for l in 0..W {
                    way.0[l] = way.0[l].max(least.0[l]);
                }
                numbers[ways + i] = way;
            }
        }
        let [reach, path, pushed] = [reach, ROOT_3 * reach * PATH * (h / unit).abs(), ROOT_3].map(Fused);
        for i in 0..m {
            let of = [entries, ways, pushes, guess, last, earlier].map(|of| of + i);
            each(ways + i, of, numbers, |[entry, way, push, guess, last, earlier]| {
                let back = guess.abs().max(last.abs()).max(earlier.abs());
                let along = path * way / entry;
                crowd::furthest(reach * back, along, pushed * push / entry)
            });
        }
        let mut crowded = [0; W];
        for share in shares(steps) {
            for i in 0..m {
                each(lambda + i, [ways + i], numbers, |[furthest]| Fused(share) * furthest);
            }
            plan.place.carry_out(numbers);
            links.gradients(plan, set, trial, numbers);
            plan.slopes(numbers);
            for i in 0..m {
                let (slope, square) = (&numbers[diagonal + i], &numbers[square + i]);
                for l in 0..W {
                    let rises = RISES * square.0[l].0 <= slope.0[l].0;
                    crowded[l] = if rises { crowded[l] } else { lanes[l] };
                }
            }
        }
        let crowded = crowded.iter().position(|&crowded| crowded != 0);
        crowded.map_or(Ok(()), |lane| Err(Stuck { lane, failure: None }))
    }
}
