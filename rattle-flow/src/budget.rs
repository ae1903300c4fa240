//! The water budget: where the water came from and where it went.

/// The volumes of water since the start. Their balance, the [`remainder`](Budget::remainder), is only rounding with
/// [`Conservative`](crate::Conservative).
#[doc(alias = "mass balance")]
#[doc(alias = "conservation")]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Budget {
    /// The volume at the start.
    pub start: f64,
    /// The volume now.
    pub now: f64,
    /// The volume of rain.
    pub rain: f64,
    /// The volume that infiltrated.
    pub infiltration: f64,
    /// The volume that would have infiltrated in addition, had there been enough water.
    pub unmet: f64,
    /// The volume that entered over the boundary.
    pub inflow: f64,
    /// The volume that left over the boundary.
    pub outflow: f64,
}

impl Budget {
    /// The change of volume that none of these terms explains.
    pub fn remainder(&self) -> f64 {
        self.now - self.start - self.rain - self.inflow + self.infiltration + self.outflow
    }

    pub(crate) fn add(&mut self, other: &Budget) {
        self.rain += other.rain;
        self.infiltration += other.infiltration;
        self.unmet += other.unmet;
        self.inflow += other.inflow;
        self.outflow += other.outflow;
    }
}
