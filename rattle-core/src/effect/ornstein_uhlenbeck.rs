//! Flows that are an Ornstein–Uhlenbeck process of the momenta.

/// The numbers of a flow Φₕ(p) = c p + √variance Π L ξ for one length of time: each momentum keeps the share c of
/// itself and gains noise, with M = L Lᵀ, Π onto momenta along the constraints, and ξ independent normal numbers of
/// variance 1.
///
/// ξ are those of [`Interval::normal`](crate::effect::Interval::normal). Ensembles apply such a flow in SIMD lanes.
///
/// Source: G. Uhlenbeck, L. Ornstein, Phys. Rev. 36 (1930) 823.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrnsteinUhlenbeck {
    /// c − 1, the share of its momentum that a body loses; negative.
    pub lost: f64,
    /// The variance of the noise, an energy: (1 − c²) kT at the temperature kT.
    pub variance: f64,
    /// The seed of the random numbers.
    pub seed: u64,
}

impl OrnsteinUhlenbeck {
    /// kT, the variance of a momentum of unit mass in equilibrium: 0 without friction and noise, infinite where noise
    /// has no friction to balance it.
    pub(crate) fn temperature(&self) -> f64 {
        let balance = -self.lost * (2.0 + self.lost); // 1 − c²
        if self.variance == 0.0 { 0.0 } else { (self.variance / balance.max(0.0)).max(0.0) }
    }
}
