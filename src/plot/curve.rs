//! What a chart draws between its axes.

/// Okabe & Ito (2008), told apart by all kinds of colour vision; in an order that keeps neighbours far apart.
const COLOURS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"];
/// Lines to compare with.
pub(super) const GREY: &str = "#8a8f98";
/// Viridis (van der Walt & Smith 2015) at 0, 0.1 … 1.
const VIRIDIS: [[u8; 3]; 11] = [
    [0x44, 0x01, 0x54],
    [0x48, 0x25, 0x76],
    [0x41, 0x44, 0x87],
    [0x35, 0x5f, 0x8d],
    [0x2a, 0x78, 0x8e],
    [0x21, 0x91, 0x8c],
    [0x22, 0xa8, 0x84],
    [0x44, 0xbf, 0x70],
    [0x7a, 0xd1, 0x51],
    [0xbd, 0xdf, 0x26],
    [0xfd, 0xe7, 0x25],
];
/// White paper swallows the yellow in which viridis ends: lines go as far as this.
const ON_PAPER: f64 = 0.9;

#[derive(Clone, Debug)]
pub(super) struct Curve {
    /// An empty label stays out of the legend.
    pub(super) label: String,
    pub(super) points: Vec<(f64, f64)>,
    pub(super) colour: String,
    pub(super) style: Style,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Style {
    Line,
    /// One of many.
    Thin,
    /// A line with a mark at each point.
    Marked,
    /// Marks without a line.
    Points,
    /// The line c xᵖ to compare with; p.
    Slope(f64),
    /// A bar at each point, as wide as this; the points are the ends of bars.
    Bars(f64),
    /// The region inside a closed line.
    Band,
}

impl Style {
    /// Whether points carry marks, which take room at the frame.
    pub(super) fn has_marks(self) -> bool {
        matches!(self, Self::Marked | Self::Points)
    }
}

/// Numbers of cells in a rectangle, as colours.
#[derive(Clone, Debug)]
pub(super) struct Map {
    pub(super) label: String,
    pub(super) x: [f64; 2],
    pub(super) y: [f64; 2],
    /// From low y to high y.
    pub(super) rows: Vec<Vec<f64>>,
}

/// The colour of the n-th single curve.
pub(super) fn single(n: usize) -> String {
    COLOURS[n % COLOURS.len()].into()
}

/// The colour of a family's curve: 0 is the first one's, 1 the last one's.
pub(super) fn along(part: f64) -> String {
    viridis(ON_PAPER * part)
}

/// The colour of a part of a scale.
pub(super) fn viridis(part: f64) -> String {
    let place = part * (VIRIDIS.len() - 1) as f64;
    let below = (place as usize).min(VIRIDIS.len() - 2);
    let mix = |i: usize| {
        let [a, b] = [below, below + 1].map(|k| f64::from(VIRIDIS[k][i]));
        (a + (place - below as f64) * (b - a)).round() as u8
    };
    format!("#{:02x}{:02x}{:02x}", mix(0), mix(1), mix(2))
}

/// y = c xᵖ between the ends of a curve, with c such that the line is nowhere above half the curve and somewhere there.
/// It is cut off at the lowest value on the chart, but not within a decade of its top.
pub(super) fn slope(points: &[(f64, f64)], order: f64, floor: f64) -> Vec<(f64, f64)> {
    let [low, high] = [f64::min, f64::max].map(|pick| points.iter().map(|p| p.0).reduce(pick));
    let (Some(low), Some(high)) = (low, high) else { return Vec::new() };
    // Logarithms, since powers may overflow.
    let c = points.iter().map(|(x, y)| (0.5 * y).ln() - order * x.ln()).fold(f64::MAX, f64::min);
    let height = |x: f64| c + order * x.ln();
    let top = height(low).max(height(high));
    let least = floor.ln().min(top - 10_f64.ln());
    let cut = ((least - c) / order).exp();
    let [a, b] = match order {
        rising if rising > 0.0 => [low.max(cut), high],
        falling if falling < 0.0 => [low, high.min(cut)],
        _ => [low, high],
    };
    [a, b].map(|x| (x, height(x).exp())).to_vec()
}
