//! Errors of steps: why an effect could not act.

/// Why an effect could not act.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EffectFailure {
    /// A force is NaN or infinite.
    #[error(
        "the force of `{effect}` is {force:?} at q = {position:?}; check the potential's domain, or try a smaller step"
    )]
    ForceNotFinite {
        /// The type of the effect.
        effect: &'static str,
        /// −∇U.
        force: Vec<f64>,
        /// Where.
        position: Vec<f64>,
    },
    /// The implicit equation of a force that depends on velocities was not solved, or the force is not finite.
    #[error(
        "no change of the momentum by `{effect}` is found, in a time {h:.3e} from p = {momentum:?} at q = {position:?}: check where \
         the force is a number, and whether it jumps, or try a smaller step"
    )]
    FlowNotFound {
        /// The type of the effect.
        effect: &'static str,
        /// The time for which it acts.
        h: f64,
        /// The momentum before.
        momentum: Vec<f64>,
        /// Where.
        position: Vec<f64>,
    },
    /// A flow changes momenta by too much in one step: no constraint impulse was found that keeps them tangent.
    #[error(
        "the flow of `{effect}` for a time of {h:.3e} is not found together with the impulse of the constraints: it changes momenta by more than themselves; try a smaller step"
    )]
    FlowTooLong {
        /// The type of the effect.
        effect: &'static str,
        /// The time for which it acts.
        h: f64,
    },
}
