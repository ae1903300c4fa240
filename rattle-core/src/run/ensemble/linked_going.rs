//! Steps and observations of rows of linked bodies, compiled once here instead of wherever an ensemble is made.

use crate::number::instructions::Work;
use crate::run::ensemble::engine::Stuck;
use crate::run::ensemble::forces_in_lanes::Pulling;
use crate::run::ensemble::linked_projected::ProjectedSteps;
use crate::run::ensemble::linked_row::{Apart, Course, LinkedRow};
use crate::run::ensemble::linked_stirred::StirredSteps;
use crate::solve::crowd::EVERY;
use crate::systems::network::group::LinkGroup;
use crate::systems::network::in_lanes::{FEW, Numbers, ROW, RowLinks};

/// Rows of so many lanes, whose work is compiled here and not wherever an ensemble is made.
pub(super) trait Wide<const W: usize> {
    /// The links of a group.
    fn links<const D: usize>(group: &dyn LinkGroup<D>) -> Option<Box<dyn RowLinks<W>>>;
    /// Takes steps.
    fn go(steps: Steps<'_, '_, W>) -> Result<(), Stuck>;
    /// Takes steps with flows.
    fn stir(steps: StirredSteps<'_, '_, W>) -> Result<(), Stuck>;
    /// Takes steps that are projected.
    fn project(steps: ProjectedSteps<'_, '_, W>) -> Result<(), Vec<Stuck>>;
    /// Writes velocities.
    fn look(velocities: Velocities<'_, '_, W>);
}

/// Names a number of lanes.
pub(super) struct Width;

impl Wide<ROW> for Width {
    fn links<const D: usize>(group: &dyn LinkGroup<D>) -> Option<Box<dyn RowLinks<ROW>>> {
        group.in_lanes()
    }
    fn go(steps: Steps<'_, '_, ROW>) -> Result<(), Stuck> {
        steps.course.set.run(steps)
    }
    fn stir(steps: StirredSteps<'_, '_, ROW>) -> Result<(), Stuck> {
        steps.course.set.run(steps)
    }
    fn project(steps: ProjectedSteps<'_, '_, ROW>) -> Result<(), Vec<Stuck>> {
        steps.desk.set().run(steps)
    }
    fn look(velocities: Velocities<'_, '_, ROW>) {
        velocities.course.set.run(velocities);
    }
}

impl Wide<FEW> for Width {
    fn links<const D: usize>(group: &dyn LinkGroup<D>) -> Option<Box<dyn RowLinks<FEW>>> {
        group.in_few_lanes()
    }
    fn go(steps: Steps<'_, '_, FEW>) -> Result<(), Stuck> {
        steps.course.set.run(steps)
    }
    fn stir(steps: StirredSteps<'_, '_, FEW>) -> Result<(), Stuck> {
        steps.course.set.run(steps)
    }
    fn project(steps: ProjectedSteps<'_, '_, FEW>) -> Result<(), Vec<Stuck>> {
        steps.desk.set().run(steps)
    }
    fn look(velocities: Velocities<'_, '_, FEW>) {
        velocities.course.set.run(velocities);
    }
}

/// Some steps of a row, after so many.
pub(super) struct Steps<'a, 'b, const W: usize> {
    pub(super) course: &'a Course<'b, W>,
    pub(super) pulling: Option<&'a mut (dyn Pulling<LinkedRow, W> + 'b)>,
    pub(super) apart: &'a mut Apart<'b, W>,
    /// All numbers, those of one step too.
    pub(super) numbers: &'a mut [Numbers<W>],
    pub(super) part: &'a mut usize,
    pub(super) from: u64,
    pub(super) steps: u64,
    /// Whether it is to be asked at the end whether other sheets are near.
    pub(super) looks: bool,
}

impl<const W: usize> Work for Steps<'_, '_, W> {
    type Done = Result<(), Stuck>;

    #[inline(always)]
    fn run(self) -> Result<(), Stuck> {
        let Self { course, mut pulling, apart, numbers, part, from, steps, looks } = self;
        if steps == 0 {
            return Ok(());
        }
        let Course { plan, parts, equal, .. } = course;
        for c in 0..plan.coordinates {
            numbers[plan.places.trial + c] = numbers[plan.places.q + c]; // where pinned bodies stay
        }
        if from == 0 {
            course.look_around((0, &[1; W]), &parts[*part], &[], numbers, &mut pulling)?;
        }
        let of_step = if *equal { 1 } else { parts.len() };
        let (mut now, end) = (from, from + steps);
        while now < end {
            let next = end.min((now / EVERY + 1) * EVERY);
            course.go((next - now) as usize * of_step, part, numbers, &mut pulling, apart)?;
            now = next;
            if now % EVERY == 0 {
                course.rest(numbers);
            }
            if now % EVERY == 0 || (looks && now == end) {
                course.look_around((now, &[1; W]), &parts[*part], &[], numbers, &mut pulling)?;
            }
        }
        course.check(numbers)
    }
}

/// Writes velocities, see [`Course::velocities`].
pub(super) struct Velocities<'a, 'b, const W: usize> {
    pub(super) course: &'a Course<'b, W>,
    pub(super) pulling: Option<&'a mut (dyn Pulling<LinkedRow, W> + 'b)>,
    pub(super) numbers: &'a mut [Numbers<W>],
    pub(super) part: usize,
}

impl<const W: usize> Work for Velocities<'_, '_, W> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { course, mut pulling, numbers, part } = self;
        course.velocities(&course.parts[part], numbers, &mut pulling);
    }
}

impl<const W: usize> Course<'_, W> {
    /// So many parts of steps.
    #[inline(always)]
    fn go(
        &self,
        count: usize,
        part: &mut usize,
        numbers: &mut [Numbers<W>],
        pulling: &mut Option<&mut (dyn Pulling<LinkedRow, W> + '_)>,
        apart: &mut Apart<'_, W>,
    ) -> Result<(), Stuck> {
        let mut left = count;
        while left > 0 {
            if const { W == ROW } {
                let going = (*part, left);
                let done = if self.sums {
                    self.go_few::<true>(going, numbers, pulling)
                } else {
                    self.go_few::<false>(going, numbers, pulling)
                };
                *part = (*part + done) % self.parts.len();
                left -= done;
            }
            if left > 0 {
                self.advance(&self.parts[*part], numbers, pulling, apart)?;
                *part = (*part + 1) % self.parts.len();
                left -= 1;
            }
        }
        Ok(())
    }
}
