//! Where the water came from and where it went.

/// The volumes since the start. What remains after all of them are set off against each other is rounding.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Budget {
    /// The volume at the start.
    pub start: f64,
    /// The volume now.
    pub now: f64,
    /// What fell as rain.
    pub rain: f64,
    /// What seeped away.
    pub infiltration: f64,
    /// What would have seeped away in addition, had there been water.
    pub unmet: f64,
    /// What entered over the boundary.
    pub inflow: f64,
    /// What left over the boundary.
    pub outflow: f64,
}

impl Budget {
    /// The change of volume that nothing explains.
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
