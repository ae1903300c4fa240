//! The numbers that trajectories in lanes are made of.

use crate::bodies::Count;
use crate::effect::Effects;
use crate::ensemble::block::{Each, Same};
use crate::ensemble::group::{Group, SideBySide};
use crate::ensemble::{GROUP, InstructionSet};
use crate::kernel::Constraint;
use crate::lanes::{Fused, Lane};
use crate::scene::Scene;
use crate::state::State;
use std::array::from_fn;

/// Double precision; what rounding takes from a position is lost. The default.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Double;

/// Double precision, with positions and momenta as compensated sums, as a
/// [`Simulation`](crate::simulation::Simulation) keeps them: for runs of millions of steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Compensated;

/// Single precision: half the time and memory, where seven digits are enough.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Single;

/// What numbers in lanes are: [`Double`], [`Compensated`] or [`Single`].
pub trait Precision: Copy {
    /// Groups of these trajectories.
    #[doc(hidden)]
    fn groups<C: Constraint<D, 1>, E: Effects<D>, const D: usize>(
        scenes: Scenes<'_, C, E>,
        starts: &[State<D>],
        lanes: &InLanes,
    ) -> Vec<Box<dyn Group<D>>>;
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

/// What each trajectory obeys.
#[doc(hidden)]
#[derive(Debug)]
pub enum Scenes<'a, C, E> {
    /// All the same.
    Same(&'a C, &'a E),
    /// Each its own.
    Each(Vec<(&'a C, &'a E)>),
}

impl<'a, C, E> Scenes<'a, C, E> {
    /// Those of the scenes, of which there is one at least.
    pub(crate) fn of<N: Count, const D: usize>(scenes: &[&'a Scene<C, E, N, D>]) -> Self {
        if scenes.iter().all(|&scene| std::ptr::eq(scene, scenes[0])) {
            Self::Same(&scenes[0].constraint, &scenes[0].effects)
        } else {
            Self::Each(scenes.iter().map(|scene| (&scene.constraint, &scene.effects)).collect())
        }
    }
}

macro_rules! precision {
    ($($name:ident: $float:ident, $sums:literal;)*) => {$(
        impl Precision for $name {
            fn groups<C: Constraint<D, 1>, E: Effects<D>, const D: usize>(
                scenes: Scenes<'_, C, E>,
                starts: &[State<D>],
                lanes: &InLanes,
            ) -> Vec<Box<dyn Group<D>>> {
                if lanes.set.fuses() {
                    groups::<Fused<$float>, C, E, D, $sums>(scenes, starts, lanes)
                } else {
                    groups::<$float, C, E, D, $sums>(scenes, starts, lanes)
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

fn groups<S: Lane, C: Constraint<D, 1>, E: Effects<D>, const D: usize, const SUMS: usize>(
    scenes: Scenes<'_, C, E>,
    starts: &[State<D>],
    InLanes { lengths, h, .. }: &InLanes,
) -> Vec<Box<dyn Group<D>>> {
    type Of<S, C, E, X, const L: usize, const D: usize, const SUMS: usize> =
        SideBySide<S, <C as Constraint<D, 1>>::Kernel<S>, <E as Effects<D>>::Field<S>, X, L, D, SUMS>;
    vec![match scenes {
        Scenes::Same(constraint, effects) => {
            let laws = Same(constraint.kernel::<S>(), effects.field::<S>());
            if starts.len() == 1 {
                Box::new(Of::<S, C, E, _, 1, D, SUMS>::new(starts, laws, lengths, *h))
            } else {
                Box::new(Of::<S, C, E, _, GROUP, D, SUMS>::new(starts, laws, lengths, *h))
            }
        }
        Scenes::Each(each) => {
            let of = |lane: usize| {
                let (constraint, effects) = each[if lane < each.len() { lane } else { 0 }];
                (constraint.kernel::<S>(), effects.field::<S>())
            };
            Box::new(Of::<S, C, E, _, GROUP, D, SUMS>::new(
                starts,
                Each::<_, _, GROUP>(from_fn(of)),
                lengths,
                *h,
            ))
        }
    }]
}
