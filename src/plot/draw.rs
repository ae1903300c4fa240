//! A sheet of curves as SVG text: lengths are pixels, x from the left, y from the top.
//!
//! ```text
//!                 title
//!       y label │ curves           legend, or the scale of a map
//!               └────────────────
//!                     x label
//! ```

use super::axis::Axis;
use super::curve::{Curve, Map, Style, viridis};
use super::series::{hidden, thinned};
use super::svg::{INK, PALE, Svg};

const WIDTH: f64 = 860.0;
const HEIGHT: f64 = 480.0;
/// Lowest sheet where both axes have one scale, and the highest up to which a frame grows.
const HEIGHTS: [f64; 2] = [240.0, 900.0];
/// A linear axis has at most one label on so much paper, across and up.
const PER_LABEL: [f64; 2] = [90.0, 60.0];
/// The length of a tick.
const MARK: f64 = 5.0;
/// Between the frame and what is drawn, so that no mark is cut and no line lies on the frame.
const ROOM: f64 = 6.0;
/// The part of the distance between bars that a bar fills.
const FILLED: f64 = 0.92;
/// A map's scale: its width, its steps of colour, and the room for it and its numbers in heights of letters.
const SCALE: (f64, usize, f64) = (14.0, 64, 4.5);

/// The legend: its first row below the frame's top, and from row to row.
const ROWS: [f64; 2] = [12.0, 20.0];

// Heights of letters.
const TITLE: f64 = 18.0;
const LABEL: f64 = 14.0;
const LEGEND: f64 = 13.0;
const TICK: f64 = 12.0;
/// The width of a small letter and of a capital in parts of their height, on average and a little more: nobody knows
/// the reader's fonts.
const LETTER: [f64; 2] = [0.56, 0.72];
/// Lines on the first that lies beneath, on the second, …
const DASHES: [&str; 4] = ["none", "9 7", "3 8", "12 4 2 4"];

/// All that a picture shows. There is at least one point, and all are finite (positive where an axis is logarithmic).
pub(super) struct Sheet<'a> {
    pub(super) title: &'a str,
    pub(super) x: &'a str,
    pub(super) y: &'a str,
    /// Whether x and y are logarithmic.
    pub(super) log: [bool; 2],
    /// One scale for both axes.
    pub(super) equal: bool,
    pub(super) curves: &'a [Curve],
    pub(super) map: Option<&'a Map>,
}

pub(super) fn draw(sheet: &Sheet) -> String {
    let frame = Frame::of(sheet);
    let mut svg = Svg::new(WIDTH, frame.height);
    frame.words(&mut svg, sheet);
    if let Some(map) = sheet.map {
        frame.map(&mut svg, map);
    }
    frame.axes(&mut svg, sheet.map.is_none());
    if let Some(map) = sheet.map {
        frame.scale(&mut svg, map);
    }
    let dashes = frame.curves(&mut svg, sheet.curves);
    frame.legend(&mut svg, sheet, &dashes);
    svg.finish()
}

/// The rectangle between the axes, and what numbers it shows.
struct Frame {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    /// Between the frame and the foot of its words, above which the sheet goes on where the legend is longer.
    below: f64,
    height: f64,
    /// What stays empty inside at the sides, above and below.
    room: [f64; 3],
    x: Axis,
    y: Axis,
}

impl Frame {
    fn of(sheet: &Sheet) -> Self {
        let legend = longest(named(sheet).map(|curve| curve.label.as_str()));
        let scale = scale_width(sheet);
        let legend = if legend > 0.0 && scale > 0.0 { 3.0 + legend + scale } else { legend.max(scale) };
        let top = if sheet.title.is_empty() { 18.0 } else { 46.0 };
        let below = 26.0 + if sheet.x.is_empty() { 0.0 } else { 1.7 * LABEL };
        let rows = top + ROWS[0] + ROWS[1] * named(sheet).count() as f64;
        let height = HEIGHT.max(rows);
        let bottom = height.min(HEIGHTS[1]) - below;
        let number = (bottom - top) / PER_LABEL[1];
        let y = window(sheet, 1, number);
        let up = longest(y.ticks().iter().map(|tick| tick.label.as_str()));
        let left = 18.0 + TICK * up + if sheet.y.is_empty() { 0.0 } else { 1.7 * LABEL };
        let x = |right: f64| window(sheet, 0, (right - left) / PER_LABEL[0]);
        let across = x(WIDTH).ticks();
        let across = longest(across.iter().map(|tick| tick.label.as_str()));
        let at_right = if legend > 0.0 { 50.0 + LEGEND * legend } else { 14.0 + 0.5 * TICK * across };
        let right = f64::max(WIDTH - at_right, left + 0.3 * WIDTH);

        let marks = sheet.curves.iter().any(|curve| curve.style.has_marks());
        let bars = sheet.curves.iter().any(|curve| matches!(curve.style, Style::Bars(_)));
        let sides = if marks || bars { ROOM } else { 0.0 };
        let room = match sheet.map {
            Some(_) => [0.0; 3],
            None => [sides, ROOM, if bars { 0.0 } else { ROOM }],
        };
        let mut frame = Self { left, right, top, bottom, below, height, room, x: x(right), y };
        if sheet.equal {
            frame.one_scale();
            frame.height = frame.height.max(rows);
        }
        frame
    }

    /// Gives the sheet the height, and the axes the windows, with which one unit is equally long on both.
    fn one_scale(&mut self) {
        self.room = [ROOM; 3];
        let width = self.right - self.left - 2.0 * ROOM;
        let wanted = self.top + width * self.y.span() / self.x.span() + 2.0 * ROOM + self.below;
        self.height = wanted.clamp(HEIGHTS[0], HEIGHTS[1]);
        self.bottom = self.height - self.below;
        let height = self.bottom - self.top - 2.0 * ROOM;
        let unit = f64::max(self.x.span() / width, self.y.span() / height);
        self.x.widen(unit * width, width / PER_LABEL[0]);
        self.y.widen(unit * height, height / PER_LABEL[1]);
    }

    fn point(&self, (x, y): (f64, f64)) -> (f64, f64) {
        self.place([self.x.part(x), self.y.part(y)])
    }

    /// Where these parts of the windows lie.
    fn place(&self, [across, up]: [f64; 2]) -> (f64, f64) {
        let [sides, above, below] = self.room;
        let (width, height) = (self.right - self.left - 2.0 * sides, self.bottom - self.top - above - below);
        (self.left + sides + across * width, self.bottom - below - up * height)
    }

    fn words(&self, svg: &mut Svg, sheet: &Sheet) {
        let middle = (0.5 * (self.left + self.right), 0.5 * (self.top + self.bottom));
        svg.text((0.5 * WIDTH, 28.0), TITLE, "middle", sheet.title);
        svg.text((middle.0, self.bottom + self.below - 12.0), LABEL, "middle", sheet.x);
        svg.upright_text((20.0, middle.1), LABEL, sheet.y);
    }

    /// Grid if wanted, axes, ticks and their labels.
    fn axes(&self, svg: &mut Svg, grid: bool) {
        let Self { left, right, top, bottom, .. } = *self;
        let across = self.x.ticks().into_iter();
        let across: Vec<_> = across.map(|tick| (self.place([tick.part, 0.0]).0, tick.label)).collect();
        let up = self.y.ticks().into_iter();
        let up: Vec<_> = up.map(|tick| (self.place([0.0, tick.part]).1, tick.label)).collect();
        for (x, _) in across.iter().filter(|_| grid) {
            svg.line((*x, top), (*x, bottom), PALE);
        }
        for (y, _) in up.iter().filter(|_| grid) {
            svg.line((left, *y), (right, *y), PALE);
        }
        svg.line((left, top), (left, bottom), INK);
        svg.line((left, bottom), (right, bottom), INK);
        for (x, label) in &across {
            svg.line((*x, bottom), (*x, bottom + MARK), INK);
            svg.text((*x, bottom + MARK + 1.2 * TICK), TICK, "middle", label);
        }
        for (y, label) in &up {
            svg.line((left - MARK, *y), (left, *y), INK);
            svg.text((left - MARK - 4.0, y + 0.35 * TICK), TICK, "end", label);
        }
    }

    /// Draws all curves, and returns the dashes of each.
    fn curves(&self, svg: &mut Svg, curves: &[Curve]) -> Vec<&'static str> {
        let mut drawn: Vec<Vec<(f64, f64)>> = Vec::new();
        let mut dashes = Vec::new();
        for curve in curves {
            let mut points: Vec<(f64, f64)> = curve.points.iter().map(|&point| self.point(point)).collect();
            if matches!(curve.style, Style::Line | Style::Thin) {
                points = thinned(points);
            }
            let mut dash = stroke(curve.style).1;
            if curve.style == Style::Line {
                let under = drawn.iter().filter(|below| hidden(&points, below)).count();
                dash = DASHES[under.min(DASHES.len() - 1)];
                drawn.push(points.clone());
            }
            self.curve(svg, curve, &points, dash);
            dashes.push(dash);
        }
        dashes
    }

    fn curve(&self, svg: &mut Svg, curve: &Curve, points: &[(f64, f64)], dashes: &str) {
        match curve.style {
            Style::Band => svg.region(points, &curve.colour, PALENESS),
            Style::Bars(width) => {
                for &(x, y) in &curve.points {
                    let [a, b] = [-0.5, 0.5].map(|side| x + side * FILLED * width);
                    let (mut foot, head) = (self.point((a, self.y.base())), self.point((b, y)));
                    // Left of the axis, or at no place of a logarithmic one.
                    foot.0 = foot.0.max(self.left);
                    svg.rectangle(foot, head, &curve.colour);
                }
            }
            Style::Points => {}
            _ => svg.path(points, &curve.colour, stroke(curve.style).0, dashes),
        }
        if let Some(radius) = radius(curve) {
            points.iter().for_each(|&point| svg.circle(point, radius, &curve.colour));
        }
    }

    fn numbers(&self, map: &Map) -> Axis {
        Axis::linear(map.rows.iter().flatten().copied(), (self.bottom - self.top) / PER_LABEL[1])
    }

    fn map(&self, svg: &mut Svg, map: &Map) {
        let scale = self.numbers(map);
        let colour = |value: f64| viridis(scale.part(value));
        let side = |ends: [f64; 2], i: usize, n: usize| ends[0] + (ends[1] - ends[0]) * i as f64 / n as f64;
        for (j, row) in map.rows.iter().enumerate() {
            let [low, high] = [j, j + 1].map(|j| side(map.y, j, map.rows.len()));
            let mut i = 0;
            while i < row.len() {
                let run = row[i..].iter().take_while(|value| colour(**value) == colour(row[i])).count();
                let [a, b] = [i, i + run].map(|i| side(map.x, i, row.len()));
                svg.rectangle(self.point((a, low)), self.point((b, high)), &colour(row[i]));
                i += run;
            }
        }
    }

    /// What the colours of a map mean, on its right.
    fn scale(&self, svg: &mut Svg, map: &Map) {
        let (x, height) = (self.right + 18.0, self.bottom - self.top - 24.0);
        let y = |part: f64| self.bottom - part * height;
        for i in 0..SCALE.1 {
            let [a, b] = [i, i + 1].map(|i| i as f64 / SCALE.1 as f64);
            svg.rectangle((x, y(a)), (x + SCALE.0, y(b)), &viridis(0.5 * (a + b)));
        }
        for tick in self.numbers(map).ticks() {
            let end = x + SCALE.0;
            svg.line((end, y(tick.part)), (end + MARK, y(tick.part)), INK);
            svg.text((end + MARK + 4.0, y(tick.part) + 0.35 * TICK), TICK, "start", &tick.label);
        }
        svg.text((x, self.top + 8.0), LEGEND, "start", &map.label);
    }

    fn legend(&self, svg: &mut Svg, sheet: &Sheet, dashes: &[&str]) {
        let scale = scale_width(sheet);
        let left = self.right + 16.0 + if scale > 0.0 { LEGEND * (scale + 3.0) } else { 0.0 };
        let named = sheet.curves.iter().zip(dashes).filter(|(curve, _)| !curve.label.is_empty());
        for (row, (curve, dashes)) in named.enumerate() {
            let (x, y) = (left, self.top + ROWS[0] + ROWS[1] * row as f64);
            let corners = [(x, y - 5.0), (x + 22.0, y - 5.0), (x + 22.0, y + 5.0), (x, y + 5.0)];
            match curve.style {
                Style::Band => svg.region(&corners, &curve.colour, PALENESS),
                Style::Bars(_) => svg.rectangle(corners[0], corners[2], &curve.colour),
                Style::Points => {}
                style => {
                    let width = f64::max(stroke(style).0, 1.6);
                    svg.path(&[(x, y), (x + 22.0, y)], &curve.colour, width, dashes);
                }
            }
            if let Some(radius) = radius(curve) {
                svg.circle((x + 11.0, y), radius.max(2.5), &curve.colour);
            }
            svg.text((x + 29.0, y + 0.35 * LEGEND), LEGEND, "start", &curve.label);
        }
    }
}

/// How opaque bands are.
const PALENESS: f64 = 0.25;

/// The window of the axis on all that is drawn, with about so many ticks.
fn window(sheet: &Sheet, axis: usize, number: f64) -> Axis {
    let pick = |point: &(f64, f64)| if axis == 0 { point.0 } else { point.1 };
    let map = sheet.map.into_iter().flat_map(|map| if axis == 0 { map.x } else { map.y });
    let bars = sheet.curves.iter().flat_map(|curve| {
        let Style::Bars(width) = curve.style else { return Vec::new() };
        let ends = || curve.points.iter().flat_map(|p| [p.0 - 0.5 * width, p.0 + 0.5 * width]);
        match (axis, sheet.log[axis]) {
            (0, log) => ends().filter(|&x| !log || x > 0.0).collect(),
            // The lowest has some height, too.
            (_, true) => curve.points.iter().map(|p| 0.5 * p.1).filter(|&low| low > 0.0).collect(),
            (_, false) => vec![0.0],
        }
    });
    let values = sheet.curves.iter().flat_map(|curve| curve.points.iter().map(pick)).chain(map).chain(bars);
    if sheet.log[axis] { Axis::logarithmic(values, number) } else { Axis::linear(values, number) }
}

/// The curves of the legend.
fn named<'a>(sheet: &Sheet<'a>) -> impl Iterator<Item = &'a Curve> {
    sheet.curves.iter().filter(|curve| !curve.label.is_empty())
}

/// The width of a map's scale with its numbers and label, in heights of letters.
fn scale_width(sheet: &Sheet) -> f64 {
    sheet.map.map_or(0.0, |map| longest([map.label.as_str()].into_iter()).max(SCALE.2))
}

/// The width of the longest text in heights of its letters.
fn longest<'a>(texts: impl Iterator<Item = &'a str>) -> f64 {
    let width = |text: &str| text.chars().map(|c| LETTER[usize::from(c.is_uppercase())]).sum::<f64>();
    texts.map(width).fold(0.0, f64::max)
}

/// Width and dashes of a line.
fn stroke(style: Style) -> (f64, &'static str) {
    match style {
        Style::Line | Style::Marked | Style::Points => (1.6, "none"),
        Style::Thin | Style::Bars(_) | Style::Band => (1.0, "none"),
        Style::Slope(_) => (1.2, "5 3"),
    }
}

/// The radius of the curve's marks, if it has some. So many dots all together cover the same part of the paper, as long
/// as one can be seen.
fn radius(curve: &Curve) -> Option<f64> {
    match curve.style {
        Style::Points => Some((3.0 * (300.0 / curve.points.len() as f64).sqrt()).clamp(0.8, 3.0)),
        Style::Marked => Some(4.0),
        // A line of no length is a dot.
        Style::Line | Style::Thin if curve.points.windows(2).all(|pair| pair[0] == pair[1]) => Some(2.0),
        Style::Line | Style::Thin | Style::Slope(_) | Style::Bars(_) | Style::Band => None,
    }
}
