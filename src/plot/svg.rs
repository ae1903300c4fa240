//! SVG text (W3C, version 1.1) as far as a chart needs it: lengths are pixels, x from the left, y from the top.

use crate::xml::escaped;

pub(super) const INK: &str = "#2b2f36";
pub(super) const PALE: &str = "#e8eaee";
const FONTS: &str = "Inter, Segoe UI, Helvetica Neue, Liberation Sans, DejaVu Sans, Arial, sans-serif";

type Place = (f64, f64);

/// A picture being written.
pub(super) struct Svg {
    text: String,
}

impl Svg {
    /// A white sheet.
    pub(super) fn new(width: f64, height: f64) -> Self {
        let size = format!(r#"width="{width:.0}" height="{height:.0}" viewBox="0 0 {width:.0} {height:.0}""#);
        let style = format!(r#"font-family="{FONTS}" stroke-width="0.8" stroke-linejoin="round""#);
        let mut svg = Self { text: String::new() };
        svg.add(&format!(r#"<svg xmlns="http://www.w3.org/2000/svg" {size} {style}>"#));
        svg.add(r##"<rect width="100%" height="100%" fill="#ffffff"/>"##);
        svg
    }

    pub(super) fn finish(mut self) -> String {
        self.add("</svg>");
        self.text
    }

    /// A fine line.
    pub(super) fn line(&mut self, from: Place, to: Place, colour: &str) {
        let ends = format!(r#"x1="{:.2}" y1="{:.2}" x2="{:.2}" y2="{:.2}""#, from.0, from.1, to.0, to.1);
        self.add(&format!(r#"<line {ends} stroke="{colour}"/>"#));
    }

    /// A line through the points; dashes are lengths drawn and left out in turn, or `none`.
    pub(super) fn path(&mut self, points: &[Place], colour: &str, width: f64, dashes: &str) {
        let points: Vec<String> = points.iter().map(|(x, y)| format!("{x:.2} {y:.2}")).collect();
        let stroke = format!(r#"stroke="{colour}" stroke-width="{width}" stroke-dasharray="{dashes}""#);
        self.add(&format!(r#"<path d="M {}" fill="none" {stroke}/>"#, points.join(" L ")));
    }

    /// A filled region, so opaque.
    pub(super) fn region(&mut self, points: &[Place], colour: &str, opacity: f64) {
        let points: Vec<String> = points.iter().map(|(x, y)| format!("{x:.2} {y:.2}")).collect();
        let fill = format!(r#"fill="{colour}" fill-opacity="{opacity}""#);
        self.add(&format!(r#"<path d="M {} Z" {fill}/>"#, points.join(" L ")));
    }

    /// A filled rectangle between two corners; neighbours of one colour show no seam.
    pub(super) fn rectangle(&mut self, a: Place, b: Place, colour: &str) {
        let [a, b] = [a, b].map(|(x, y)| ((100.0 * x).round() / 100.0, (100.0 * y).round() / 100.0));
        let place = format!(r#"x="{:.2}" y="{:.2}""#, a.0.min(b.0), a.1.min(b.1));
        let size = format!(r#"width="{:.2}" height="{:.2}""#, (a.0 - b.0).abs(), (a.1 - b.1).abs());
        self.add(&format!(r#"<rect {place} {size} fill="{colour}" shape-rendering="crispEdges"/>"#));
    }

    pub(super) fn circle(&mut self, (x, y): Place, radius: f64, colour: &str) {
        self.add(&format!(r#"<circle cx="{x:.2}" cy="{y:.2}" r="{radius:.2}" fill="{colour}"/>"#));
    }

    /// Words whose `start`, `middle` or `end` stands at the place.
    pub(super) fn text(&mut self, (x, y): Place, size: f64, anchor: &str, words: &str) {
        let place = format!(r#"x="{x:.2}" y="{y:.2}" text-anchor="{anchor}""#);
        self.words(&place, size, words);
    }

    /// Words that run upwards, with their middle at the place.
    pub(super) fn upright_text(&mut self, (x, y): Place, size: f64, words: &str) {
        let place = format!(r#"transform="translate({x:.2} {y:.2}) rotate(-90)" text-anchor="middle""#);
        self.words(&place, size, words);
    }

    fn words(&mut self, place: &str, size: f64, words: &str) {
        if words.is_empty() {
            return;
        }
        let words = escaped(words);
        self.add(&format!(r#"<text {place} font-size="{size}" fill="{INK}">{words}</text>"#));
    }

    fn add(&mut self, element: &str) {
        self.text += element;
        self.text.push('\n');
    }
}
