//! The bodies that a step moves.

/// Positions and momenta of all bodies, and what rounding took from them.
pub(super) struct Moving<'a, const D: usize> {
    pub(super) q: &'a mut [[f64; D]],
    pub(super) q_low: &'a mut [[f64; D]],
    pub(super) p: &'a mut [[f64; D]],
    pub(super) p_low: &'a mut [[f64; D]],
}
