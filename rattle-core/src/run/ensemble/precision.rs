//! The numbers that trajectories in lanes are made of.

use crate::effect::list::Effects;
use crate::kernel::functions::Constraint;
use crate::motion::state::State;
use crate::number::instructions::InstructionSet;
use crate::number::lanes::{Fused, Lane};
use crate::run::ensemble::group::Group;
use crate::run::ensemble::laws::{Each, Same};
use crate::run::ensemble::side_by_side::GROUP;
use crate::run::ensemble::side_by_side::SideBySide;

/// Double precision; what rounding takes from a position is lost. The default. (On coordinates near 1, above which doubles are
/// twice as far apart as below, rounding is biased: on a unit sphere the energy grows by 1e-17 of itself in each step.)
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Double;

/// Double precision, with positions and momenta as compensated sums, as a
/// [`Simulation`](crate::run::simulation::Simulation) keeps them: for runs of millions of steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Compensated;

/// Single precision, where seven digits are enough: half the memory, and a half to two thirds of the time (but tan, ∛, powers,
/// log₂, log₁₀, erf and inverse functions are computed in double precision). What does not go in lanes is computed in double precision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Single;

/// What numbers in lanes are: [`Double`], [`Compensated`] or [`Single`].
pub trait Precision: Copy {
    /// The largest number that there is.
    const MOST: f64;

    /// A group of trajectories that obey the same.
    #[doc(hidden)]
    fn same<C: Constraint<D, 1>, E: Effects<D>, const D: usize>(
        scene: (&C, &E),
        starts: &[State<D>],
        lanes: &InLanes,
    ) -> Box<dyn Group<D>>;

    /// A group of trajectories that obey different parameters.
    #[doc(hidden)]
    fn each<C: Constraint<D, 1> + 'static, E: Effects<D> + 'static, const D: usize>(
        scenes: &[(&C, &E)],
        starts: &[State<D>],
        lanes: &InLanes,
    ) -> Box<dyn Group<D>>;
}

/// How trajectories go in lanes.
#[doc(hidden)]
#[derive(Debug)]
pub struct InLanes {
    /// The RATTLE steps of a step.
    pub lengths: Vec<f64>,
    /// The step.
    pub h: f64,
    /// The instructions.
    pub set: InstructionSet,
}

macro_rules! precision {
    ($($name:ident: $float:ident, $sums:literal;)*) => {$(
        impl Precision for $name {
            const MOST: f64 = $float::MAX as f64;

            fn same<C: Constraint<D, 1>, E: Effects<D>, const D: usize>(
                scene: (&C, &E),
                starts: &[State<D>],
                lanes: &InLanes,
            ) -> Box<dyn Group<D>> {
                if lanes.set.fuses() {
                    same::<Fused<$float>, C, E, D, $sums>(scene, starts, lanes)
                } else {
                    same::<$float, C, E, D, $sums>(scene, starts, lanes)
                }
            }

            fn each<C: Constraint<D, 1> + 'static, E: Effects<D> + 'static, const D: usize>(
                scenes: &[(&C, &E)],
                starts: &[State<D>],
                lanes: &InLanes,
            ) -> Box<dyn Group<D>> {
                if lanes.set.fuses() {
                    each::<Fused<$float>, C, E, D, $sums>(scenes, starts, lanes)
                } else {
                    each::<$float, C, E, D, $sums>(scenes, starts, lanes)
                }
            }
        }
    )*};
}
precision! {
    Double: f64, 0;
    Compensated: f64, 1;
    Single: f32, 0;
}

fn same<S: Lane, C: Constraint<D, 1>, E: Effects<D>, const D: usize, const SUMS: usize>(
    (constraint, effects): (&C, &E),
    starts: &[State<D>],
    InLanes { lengths, h, .. }: &InLanes,
) -> Box<dyn Group<D>> {
    let laws = Same(constraint.kernel::<S>(), effects.forces::<S>());
    if starts.len() == 1 {
        Box::new(SideBySide::<S, _, 1, D, SUMS>::new(starts, laws, lengths, *h))
    } else {
        Box::new(SideBySide::<S, _, GROUP, D, SUMS>::new(starts, laws, lengths, *h))
    }
}

fn each<
    S: Lane,
    C: Constraint<D, 1> + 'static,
    E: Effects<D> + 'static,
    const D: usize,
    const SUMS: usize,
>(
    scenes: &[(&C, &E)],
    starts: &[State<D>],
    InLanes { lengths, h, .. }: &InLanes,
) -> Box<dyn Group<D>> {
    let of = |lane: usize| scenes[if lane < scenes.len() { lane } else { 0 }]; // the rest copies the first
    let laws = Each::<C, E, S, GROUP, D>::new(of);
    Box::new(SideBySide::<S, _, GROUP, D, SUMS>::new(starts, laws, lengths, *h))
}
