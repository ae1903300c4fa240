//! The numbers that trajectories in lanes are computed with.

use crate::effect::list::Effects;
use crate::kernel::functions::Constraint;
use crate::motion::method::Stage;
use crate::motion::state::State;
use crate::motion::table::{Table, Tabulated};
use crate::number::instructions::Fusing;
use crate::number::lanes::{Fused, Lane};
use crate::number::vectors::LANES;
use crate::run::ensemble::collocation_lanes::CollocationLanes;
use crate::run::ensemble::group::Group;
use crate::run::ensemble::laws::{Each, Same};
use crate::run::ensemble::side_by_side::SideBySide;
use crate::run::ensemble::splitting_lanes::SplittingLanes;

/// Double precision without compensated sums; the default.
///
/// Each step loses the rounding of the position. On coordinates near 1 that loss is biased, since doubles above 1 are
/// twice as far apart as those below: on a unit sphere the energy grows by 1e-17 of itself in each step.
/// [`Compensated`] has no such drift.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Double;

/// Double precision, with positions and momenta as compensated sums, as a
/// [`Simulation`](crate::run::simulation::Simulation) keeps them: for runs of millions of steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Compensated;

/// Single precision, where seven digits are enough: half the memory, and a half to two thirds of the time.
///
/// tan, ∛, powers, log₂, log₁₀, erf and inverse functions are evaluated in double precision. Trajectories that do not
/// go in lanes are computed in double precision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Single;

/// What numbers in lanes are: [`Double`], [`Compensated`] or [`Single`].
pub trait Precision: Copy {
    /// The largest finite number.
    const MOST: f64;

    /// A group of trajectories that obey the same; `EQUAL` says that a step is one stage.
    #[doc(hidden)]
    fn same<C: Constraint<D, 1>, E: Effects<D>, const EQUAL: bool, const D: usize>(
        scene: (&C, &E),
        starts: &[State<D>],
        lanes: &InLanes,
    ) -> Box<dyn Group<D>>;

    /// A group of trajectories that obey different parameters.
    #[doc(hidden)]
    fn each<C: Constraint<D, 1> + 'static, E: Effects<D> + 'static, const EQUAL: bool, const D: usize>(
        scenes: &[(&C, &E)],
        starts: &[State<D>],
        lanes: &InLanes,
    ) -> Box<dyn Group<D>>;

    /// Groups of trajectories that obey the same, by collocation of N stages.
    #[doc(hidden)]
    fn collocated<C: Constraint<D, 1>, E: Effects<D>, const N: usize, const D: usize>(
        scene: (&C, &E),
        starts: &[State<D>],
        lanes: &InLanes,
    ) -> Vec<Box<dyn Group<D>>>
    where
        Table<N>: Tabulated;

    /// Groups of trajectories that obey different parameters, by collocation of N stages.
    #[doc(hidden)]
    fn collocated_each<
        C: Constraint<D, 1> + 'static,
        E: Effects<D> + 'static,
        const N: usize,
        const D: usize,
    >(
        scenes: &[(&C, &E)],
        starts: &[State<D>],
        lanes: &InLanes,
    ) -> Vec<Box<dyn Group<D>>>
    where
        Table<N>: Tabulated;
}

/// How trajectories go in lanes.
#[doc(hidden)]
#[derive(Debug)]
pub struct InLanes {
    /// The stages of a step.
    pub(crate) stages: Vec<Stage>,
    /// The step.
    pub(crate) h: f64,
    /// The instructions.
    pub(crate) set: Fusing,
}

macro_rules! precision {
    ($($name:ident: $float:ident, $sums:literal;)*) => {$(
        impl Precision for $name {
            const MOST: f64 = $float::MAX as f64;

            fn same<C: Constraint<D, 1>, E: Effects<D>, const EQUAL: bool, const D: usize>(
                scene: (&C, &E),
                starts: &[State<D>],
                lanes: &InLanes,
            ) -> Box<dyn Group<D>> {
                same::<Fused<$float>, C, E, D, $sums, EQUAL>(scene, starts, lanes)
            }

            fn each<C: Constraint<D, 1> + 'static, E: Effects<D> + 'static, const EQUAL: bool, const D: usize>(
                scenes: &[(&C, &E)],
                starts: &[State<D>],
                lanes: &InLanes,
            ) -> Box<dyn Group<D>> {
                each::<Fused<$float>, C, E, D, $sums, EQUAL>(scenes, starts, lanes)
            }

            fn collocated<C: Constraint<D, 1>, E: Effects<D>, const N: usize, const D: usize>(
                scene: (&C, &E),
                starts: &[State<D>],
                lanes: &InLanes,
            ) -> Vec<Box<dyn Group<D>>>
            where
                Table<N>: Tabulated,
            {
                collocated::<Fused<$float>, C, E, D, $sums, N>(scene, starts, lanes)
            }

            fn collocated_each<
                C: Constraint<D, 1> + 'static,
                E: Effects<D> + 'static,
                const N: usize,
                const D: usize,
            >(
                scenes: &[(&C, &E)],
                starts: &[State<D>],
                lanes: &InLanes,
            ) -> Vec<Box<dyn Group<D>>>
            where
                Table<N>: Tabulated,
            {
                collocated_each::<Fused<$float>, C, E, D, $sums, N>(scenes, starts, lanes)
            }
        }
    )*};
}
precision! {
    Double: f64, 0;
    Compensated: f64, 1;
    Single: f32, 0;
}

fn same<S, C, E, const D: usize, const SUMS: usize, const EQUAL: bool>(
    (constraint, effects): (&C, &E),
    starts: &[State<D>],
    InLanes { stages, h, set }: &InLanes,
) -> Box<dyn Group<D>>
where
    S: Lane,
    C: Constraint<D, 1>,
    E: Effects<D>,
{
    let laws = Same(constraint.kernel::<S>(), effects.forces::<S>());
    if starts.len() == 1 {
        let engine = SplittingLanes::<S, _, 1, D, SUMS, EQUAL>::new(laws, stages, *set);
        Box::new(SideBySide::new(engine, starts, *h))
    } else {
        let engine = SplittingLanes::<S, _, LANES, D, SUMS, EQUAL>::new(laws, stages, *set);
        Box::new(SideBySide::new(engine, starts, *h))
    }
}

fn each<S, C, E, const D: usize, const SUMS: usize, const EQUAL: bool>(
    scenes: &[(&C, &E)],
    starts: &[State<D>],
    InLanes { stages, h, set }: &InLanes,
) -> Box<dyn Group<D>>
where
    S: Lane,
    C: Constraint<D, 1> + 'static,
    E: Effects<D> + 'static,
{
    let of = |lane: usize| scenes[if lane < scenes.len() { lane } else { 0 }]; // the rest copies the first
    let laws = Each::<C, E, S, LANES, D>::new(of);
    let engine = SplittingLanes::<S, _, LANES, D, SUMS, EQUAL>::new(laws, stages, *set);
    Box::new(SideBySide::new(engine, starts, *h))
}

/// Lanes of a row of trajectories by collocation: so many that what is kept of their stages fits the nearest cache.
const ROW: usize = 32;

fn collocated<S, C, E, const D: usize, const SUMS: usize, const N: usize>(
    (constraint, effects): (&C, &E),
    starts: &[State<D>],
    InLanes { h, set, .. }: &InLanes,
) -> Vec<Box<dyn Group<D>>>
where
    S: Lane,
    C: Constraint<D, 1>,
    E: Effects<D>,
    Table<N>: Tabulated,
{
    let row = |starts: &[State<D>]| -> Box<dyn Group<D>> {
        let laws = Same(constraint.kernel::<S>(), effects.forces::<S>());
        if starts.len() == 1 {
            let engine =
                CollocationLanes::<S, _, 1, D, SUMS, N>::new(laws, const { &Table::<N>::TABLE }, *h, *set);
            Box::new(SideBySide::new(engine, starts, *h))
        } else {
            let engine =
                CollocationLanes::<S, _, ROW, D, SUMS, N>::new(laws, const { &Table::<N>::TABLE }, *h, *set);
            Box::new(SideBySide::new(engine, starts, *h))
        }
    };
    starts.chunks(ROW).map(row).collect()
}

fn collocated_each<S, C, E, const D: usize, const SUMS: usize, const N: usize>(
    scenes: &[(&C, &E)],
    starts: &[State<D>],
    InLanes { h, set, .. }: &InLanes,
) -> Vec<Box<dyn Group<D>>>
where
    S: Lane,
    C: Constraint<D, 1> + 'static,
    E: Effects<D> + 'static,
    Table<N>: Tabulated,
{
    let row = |(scenes, starts): (&[(&C, &E)], &[State<D>])| -> Box<dyn Group<D>> {
        let of = |lane: usize| scenes[if lane < scenes.len() { lane } else { 0 }]; // the rest copies the first
        let laws = Each::<C, E, S, ROW, D>::new(of);
        let engine =
            CollocationLanes::<S, _, ROW, D, SUMS, N>::new(laws, const { &Table::<N>::TABLE }, *h, *set);
        Box::new(SideBySide::new(engine, starts, *h))
    };
    scenes.chunks(ROW).zip(starts.chunks(ROW)).map(row).collect()
}
