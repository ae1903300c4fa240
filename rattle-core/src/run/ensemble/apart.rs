//! Which trajectories of an ensemble are computed in lanes, and why others are not.

use crate::effect::list::Forces;
use crate::motion::method::{Method, Splitting};
use crate::number::instructions::InstructionSet;

/// How the trajectories of an ensemble are computed.
///
/// ```
/// # use rattle::effect::DryFriction;
/// # use rattle::{surfaces::Torus, Rattle, Scene, State};
/// let rough = Scene::on(Torus { major: 1.0, minor: 0.25 }).with(DryFriction { coefficient: 0.1 });
/// let start = State::at([1.25, 0.0, 0.0]).moving([0.0, 1.0, 0.0]);
/// let plan = rough.ensemble(vec![start; 100], Rattle::new(0.01))?.plan();
/// assert_eq!((plan.in_lanes, plan.alone), (0, 100));
/// println!("{}", plan.reason.unwrap()); // flow `DryFriction` depends on forces, which are not known in lanes
/// # Ok::<(), rattle::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Plan {
    /// The number of trajectories in SIMD lanes.
    pub in_lanes: usize,
    /// The number of trajectories that are a simulation each.
    pub alone: usize,
    /// Why the first of those is not in a lane; `None` if there is none.
    pub reason: Option<NotInLanes>,
}

/// Why a trajectory is computed as a simulation, not in a lane.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NotInLanes {
    /// Without fused multiply-add, lanes are slower than simulations.
    #[error("the instruction set `{0}` has no fused multiply-add")]
    Instructions(InstructionSet),
    /// The method has no form in lanes, or none for bodies of this kind. The name of the method.
    #[error("`{0}` has no form in lanes for these bodies")]
    Method(&'static str),
    /// Steps or stages are shorter than [`Precision::SHORTEST`](crate::run::ensemble::Precision::SHORTEST). The step
    /// size.
    #[error("steps of {0:e}, or their stages, are too short for lanes, where products of them would vanish")]
    ShortSteps(f64),
    /// An effect needs working memory or a memory of its own, or is a force that changes with time. The name of its
    /// type.
    #[error("effect `{0}` needs a memory, or is a force that changes with time")]
    Effect(&'static str),
    /// A flow depends on [forces](crate::effect::Flow::FEELS_FORCES), which are not known in lanes. The name of its
    /// type.
    #[error("flow `{0}` depends on forces, which are not known in lanes")]
    FeelsForces(&'static str),
    /// In lanes, flows of momenta act on bodies that a splitting into kicks and drifts moves.
    #[error("flows of momenta act in lanes on bodies that are moved by kicks and drifts")]
    Flows,
    /// Steps are [taken back](crate::run::ensemble::Ensemble::check_reversal): lanes look less closely at them.
    #[error("steps are taken back and compared, at which lanes look less closely than simulations")]
    TakenBack,
    /// The bodies, or the constraints and links between them, have no form in lanes, or scenes of a sweep differ in
    /// more than parameters.
    #[error(
        "these bodies and constraints have no form in lanes, or the scenes of a sweep differ in more than parameters"
    )]
    System,
}

impl Plan {
    /// All are left alone, since steps are taken back.
    pub(super) fn take_back(&mut self) {
        let Self { in_lanes, alone, reason } = *self;
        let reason = if in_lanes > 0 { Some(NotInLanes::TakenBack) } else { reason };
        *self = Self { in_lanes: 0, alone: alone + in_lanes, reason };
    }

    /// So many more are left alone: for this reason, or because of bodies and constraints.
    pub(super) fn leave(&mut self, number: usize, why: Option<NotInLanes>) {
        self.alone += number;
        self.reason = self.reason.or(why).or(Some(NotInLanes::System));
    }
}

/// Why these effects cannot act in lanes, if they cannot: forces can, and flows on one body on a surface, on linked
/// bodies and on rigid ones.
pub(super) fn act_in_lanes<S: Method, F: Forces<f64, D>, const D: usize>(effects: &F) -> Option<NotInLanes> {
    if let Some(effect) = effects.not_in_lanes() {
        return Some(NotInLanes::Effect(effect));
    }
    if const { F::FLOWS == 0 } {
        return None;
    }
    let manners = (0..F::FLOWS).map(|number| effects.manner(number));
    if let Some((_, effect)) = manners.into_iter().find(|(manner, _)| manner.feels) {
        return Some(NotInLanes::FeelsForces(effect));
    }
    let flows_do = const { !matches!(S::SPLITTING, Splitting::Not) };
    if flows_do { None } else { Some(NotInLanes::Flows) }
}
