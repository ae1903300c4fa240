//! Rods' ends, discs, boxes and charts, as a scene keeps them.

/// The end of a rod or the centre of a disc: a body, or a fixed place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// The body of this number.
    Body(usize),
    /// A place.
    Place([f64; 3]),
}

impl From<usize> for End {
    fn from(body: usize) -> Self {
        Self::Body(body)
    }
}

impl From<[f64; 3]> for End {
    fn from(place: [f64; 3]) -> Self {
        Self::Place(place)
    }
}

#[derive(Clone, Debug)]
pub(super) struct Disc {
    pub(super) centre: End,
    pub(super) axis: [f64; 3],
    pub(super) radius: f64,
}

/// A box: lengths of its sides, and by time its centre and its axes in space.
#[derive(Clone, Debug)]
pub(super) struct Moved {
    pub(super) sides: [f64; 3],
    pub(super) centres: Vec<[f64; 3]>,
    pub(super) axes: Vec<[[f64; 3]; 3]>,
}

/// A chart over the scene's times.
#[derive(Clone, Debug)]
pub(super) struct Strip {
    pub(super) title: String,
    pub(super) curves: Vec<(String, Vec<f64>)>,
}
