//! A sheet of curves as SVG text: lengths are pixels, x from the left, y from the top.
//!
//! ```text
//!                 title
//!       y label │ curves           legend
//!               └────────────────
//!                     x label
//! ```

use super::axis::Axis;
use super::curve::{Curve, Style};
use super::svg::{INK, PALE, Svg};

const WIDTH: f64 = 860.0;
const HEIGHT: f64 = 480.0;
/// Lowest and highest sheet where both axes have one scale.
const HEIGHTS: [f64; 2] = [240.0, 900.0];
/// A linear axis has at most one label on so much paper, across and up.
const PER_LABEL: [f64; 2] = [90.0, 60.0];
/// The length of a tick.
const MARK: f64 = 5.0;

// Heights of letters.
const TITLE: f64 = 18.0;
const LABEL: f64 = 14.0;
const LEGEND: f64 = 13.0;
const TICK: f64 = 12.0;
/// The width of a letter in parts of its height, on average and a little more: nobody knows the reader's fonts.
const LETTER: f64 = 0.56;

/// All that a picture shows. There is at least one point, and all are finite (positive where the axes are logarithmic).
pub(super) struct Sheet<'a> {
    pub(super) title: &'a str,
    pub(super) x: &'a str,
    pub(super) y: &'a str,
    pub(super) log: bool,
    /// One scale for both axes.
    pub(super) equal: bool,
    pub(super) curves: &'a [Curve],
}

pub(super) fn draw(sheet: &Sheet) -> String {
    let frame = Frame::of(sheet);
    let mut svg = Svg::new(WIDTH, frame.height);
    frame.words(&mut svg, sheet);
    frame.axes(&mut svg);
    sheet.curves.iter().for_each(|curve| frame.curve(&mut svg, curve));
    frame.legend(&mut svg, sheet);
    svg.finish()
}

/// The rectangle between the axes, and what numbers it shows.
struct Frame {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    height: f64,
    x: Axis,
    y: Axis,
}

impl Frame {
    fn of(sheet: &Sheet) -> Self {
        let (x, y) = windows(sheet);
        let legend = longest(named(sheet).map(|curve| &curve.label));
        let [across, up] = [x.ticks(WIDTH / PER_LABEL[0]), y.ticks(HEIGHT / PER_LABEL[1])];
        let [across, up] = [across, up].map(|ticks| longest(ticks.iter().map(|tick| &tick.label)));

        let left = 18.0 + TICK * up + if sheet.y.is_empty() { 0.0 } else { 1.7 * LABEL };
        let at_right = if legend > 0.0 { 50.0 + LEGEND * legend } else { 14.0 + 0.5 * TICK * across };
        let right = f64::max(WIDTH - at_right, left + 0.3 * WIDTH);
        let top = if sheet.title.is_empty() { 18.0 } else { 46.0 };
        let below = 26.0 + if sheet.x.is_empty() { 0.0 } else { 1.7 * LABEL };
        let mut frame = Self { left, right, top, bottom: HEIGHT - below, height: HEIGHT, x, y };
        if sheet.equal {
            frame.one_scale(below);
        }
        frame
    }

    /// Gives the sheet the height, and the axes the windows, with which one unit is equally long on both.
    fn one_scale(&mut self, below: f64) {
        let width = self.right - self.left;
        let wanted = self.top + width * self.y.span() / self.x.span() + below;
        self.height = wanted.clamp(HEIGHTS[0], HEIGHTS[1]);
        self.bottom = self.height - below;
        let unit = f64::max(self.x.span() / width, self.y.span() / (self.bottom - self.top));
        self.x.widen(unit * width);
        self.y.widen(unit * (self.bottom - self.top));
    }

    fn point(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let [across, up] = [self.x.part(x), self.y.part(y)];
        (self.left + across * (self.right - self.left), self.bottom - up * (self.bottom - self.top))
    }

    fn words(&self, svg: &mut Svg, sheet: &Sheet) {
        let middle = (0.5 * (self.left + self.right), 0.5 * (self.top + self.bottom));
        svg.text((0.5 * WIDTH, 28.0), TITLE, "middle", sheet.title);
        svg.text((middle.0, self.height - 12.0), LABEL, "middle", sheet.x);
        svg.upright_text((20.0, middle.1), LABEL, sheet.y);
    }

    /// Grid, axes, ticks and their labels.
    fn axes(&self, svg: &mut Svg) {
        let Self { left, right, top, bottom, .. } = *self;
        let across = self.x.ticks((right - left) / PER_LABEL[0]).into_iter();
        let across: Vec<_> = across.map(|tick| (left + tick.part * (right - left), tick.label)).collect();
        let up = self.y.ticks((bottom - top) / PER_LABEL[1]).into_iter();
        let up: Vec<_> = up.map(|tick| (bottom - tick.part * (bottom - top), tick.label)).collect();
        for (x, _) in &across {
            svg.line((*x, top), (*x, bottom), PALE);
        }
        for (y, _) in &up {
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

    fn curve(&self, svg: &mut Svg, curve: &Curve) {
        let points: Vec<(f64, f64)> = curve.points.iter().map(|&point| self.point(point)).collect();
        if curve.style != Style::Points {
            let (width, dashes) = stroke(curve.style);
            svg.path(&points, &curve.colour, width, dashes);
        }
        if let Some(radius) = radius(curve) {
            points.iter().for_each(|&point| svg.circle(point, radius, &curve.colour));
        }
    }

    fn legend(&self, svg: &mut Svg, sheet: &Sheet) {
        for (row, curve) in named(sheet).enumerate() {
            let (x, y) = (self.right + 16.0, self.top + 12.0 + 20.0 * row as f64);
            if curve.style != Style::Points {
                let (width, dashes) = stroke(curve.style);
                svg.path(&[(x, y), (x + 22.0, y)], &curve.colour, f64::max(width, 1.6), dashes);
            }
            if let Some(radius) = radius(curve) {
                svg.circle((x + 11.0, y), radius.max(2.5), &curve.colour);
            }
            svg.text((x + 29.0, y + 0.35 * LEGEND), LEGEND, "start", &curve.label);
        }
    }
}

fn windows(sheet: &Sheet) -> (Axis, Axis) {
    let points = || sheet.curves.iter().flat_map(|curve| &curve.points);
    let (x, y) = (points().map(|point| point.0), points().map(|point| point.1));
    if sheet.log {
        return (Axis::logarithmic(x), Axis::logarithmic(y));
    }
    let dots = sheet.curves.iter().any(|curve| curve.style == Style::Points);
    let at_the_sides = match (sheet.equal, dots) {
        (true, _) => 0.05,
        (false, true) => 0.015, // a dot is not cut in half
        (false, false) => 0.0,
    };
    (Axis::linear(x, at_the_sides), Axis::linear(y, 0.06))
}

/// The curves of the legend.
fn named<'a>(sheet: &Sheet<'a>) -> impl Iterator<Item = &'a Curve> {
    sheet.curves.iter().filter(|curve| !curve.label.is_empty())
}

/// The width of the longest text in heights of its letters.
fn longest<'a>(texts: impl Iterator<Item = &'a String>) -> f64 {
    texts.map(|text| text.chars().count()).max().unwrap_or(0) as f64 * LETTER
}

/// Width and dashes of a line.
fn stroke(style: Style) -> (f64, &'static str) {
    match style {
        Style::Line | Style::Marked | Style::Points => (1.6, "none"),
        Style::Thin => (1.0, "none"),
        Style::Slope(_) => (1.2, "5 3"),
    }
}

/// The radius of the curve's marks, if it has some. So many dots all together cover the same part of the paper, as long as
/// one can be seen.
fn radius(curve: &Curve) -> Option<f64> {
    match curve.style {
        Style::Points => Some((3.0 * (300.0 / curve.points.len() as f64).sqrt()).clamp(0.8, 3.0)),
        Style::Marked => Some(4.0),
        Style::Line | Style::Thin | Style::Slope(_) => None,
    }
}
