//! Line charts as SVG files: linear or log–log, families of curves, reference slopes.
//!
//! ```
//! use rattle::plot::Chart;
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("accuracy.svg");
//! let steps = [0.02, 0.01, 0.005];
//! Chart::new("What accuracy costs")
//!     .x("step h")
//!     .y("error in position")
//!     .log_log()
//!     .marked("RATTLE", steps.map(|h| (h, 2.0 * h * h)))
//!     .slope(2.0, "h²")
//!     .save(&path)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use kuva::backend::svg::SvgBackend;
use kuva::plot::colormap::ColorMap;
use kuva::plot::legend::{LegendEntry, LegendShape};
use kuva::plot::{LinePlot, LineStyle, ScatterPlot};
use kuva::render::layout::{Layout, TickFormat};
use kuva::render::plots::Plot;
use kuva::render::render::render_multiple;
use kuva::render::theme::Theme;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::{fs, io};

/// Okabe & Ito (2008), told apart by all kinds of colour vision; in an order that keeps neighbours far apart.
const COLOURS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"];
const GREY: &str = "#8a8f98";
/// Viridis ends in a yellow that white paper swallows.
const VIRIDIS_END: f64 = 0.9;
/// A family shows this many of its curves in the legend.
const FAMILY_LABELS: usize = 5;
/// Beyond, the arithmetic of the axes would overflow.
const LARGEST: f64 = 1e150;
const WIDTH: f64 = 860.0;
const HEIGHT: f64 = 480.0;

/// A chart to be saved as SVG. Curves come in the order of drawing; an empty label stays out of the legend.
#[derive(Clone, Debug)]
pub struct Chart {
    title: String,
    x: String,
    y: String,
    log: bool,
    equal: bool,
    curves: Vec<Curve>,
    singles: usize,
}

#[derive(Clone, Debug)]
struct Curve {
    label: String,
    points: Vec<(f64, f64)>,
    colour: String,
    style: Style,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Style {
    Line,
    Thin,
    Marked,
    Points,
    Slope(f64),
}

impl Chart {
    /// An empty chart.
    ///
    /// ```
    /// # use rattle::plot::{Chart, PlotError};
    /// assert!(matches!(Chart::new("Nothing yet").to_svg(), Err(PlotError::Empty { .. })));
    /// ```
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            x: String::new(),
            y: String::new(),
            log: false,
            equal: false,
            curves: Vec::new(),
            singles: 0,
        }
    }

    /// The horizontal axis, with its unit: `"time t / s"`.
    ///
    /// ```
    /// # use rattle::plot::Chart;
    /// let chart = Chart::new("Fall").x("time t / s").line("", [(0.0, 0.0), (1.0, 4.9)]);
    /// assert!(chart.to_svg()?.contains("time t / s"));
    /// # Ok::<(), rattle::plot::PlotError>(())
    /// ```
    pub fn x(mut self, label: impl Into<String>) -> Self {
        self.x = label.into();
        self
    }

    /// The vertical axis, with its unit.
    ///
    /// ```
    /// # use rattle::plot::Chart;
    /// let chart = Chart::new("Fall").y("depth / m").line("", [(0.0, 0.0), (1.0, 4.9)]);
    /// assert!(chart.to_svg()?.contains("depth / m"));
    /// # Ok::<(), rattle::plot::PlotError>(())
    /// ```
    pub fn y(mut self, label: impl Into<String>) -> Self {
        self.y = label.into();
        self
    }

    /// Both axes logarithmic; every coordinate must then be positive.
    ///
    /// ```
    /// # use rattle::plot::{Chart, PlotError};
    /// let chart = Chart::new("Error").log_log().line("order 4", [(0.1, 1e-16), (0.01, 0.0)]);
    /// assert!(matches!(chart.to_svg(), Err(PlotError::NotPositive { index: 1, .. })));
    /// ```
    pub fn log_log(mut self) -> Self {
        self.log = true;
        self
    }

    /// One unit is equally long on both axes: a circle stays a circle.
    ///
    /// ```
    /// # use rattle::plot::Chart;
    /// let circle = (0..=90).map(|i| (f64::from(4 * i)).to_radians().sin_cos());
    /// assert!(Chart::new("Circle").equal_aspect().line("", circle).to_svg().is_ok());
    /// ```
    pub fn equal_aspect(mut self) -> Self {
        self.equal = true;
        self
    }

    /// A curve in a colour of its own.
    ///
    /// ```
    /// # use rattle::plot::Chart;
    /// let chart = Chart::new("Energy").line("RATTLE", (0..9).map(|i| (f64::from(i), 1.0)));
    /// assert!(chart.to_svg()?.contains("RATTLE"));
    /// # Ok::<(), rattle::plot::PlotError>(())
    /// ```
    pub fn line(self, label: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        self.single(label.into(), points, Style::Line)
    }

    /// A curve whose points carry marks: few, measured values.
    ///
    /// ```
    /// # use rattle::plot::Chart;
    /// let chart = Chart::new("Cost").marked("measured", [(1.0, 3.0), (2.0, 1.0)]);
    /// assert!(chart.to_svg()?.contains("<circle"));
    /// # Ok::<(), rattle::plot::PlotError>(())
    /// ```
    pub fn marked(self, label: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        self.single(label.into(), points, Style::Marked)
    }

    /// Points that no line joins: values of one thing over another, or measurements on top of a curve.
    ///
    /// ```
    /// # use rattle::plot::Chart;
    /// let chart = Chart::new("Section").points("returns", [(1.0, 3.0), (2.0, 1.0), (1.2, 2.0)]);
    /// assert!(chart.to_svg()?.matches("<circle").count() >= 3);
    /// # Ok::<(), rattle::plot::PlotError>(())
    /// ```
    pub fn points(self, label: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        self.single(label.into(), points, Style::Points)
    }

    /// Many curves of one kind in the order of a parameter: thin lines, colours along viridis, and a legend that
    /// names a few of them, first and last always.
    ///
    /// ```
    /// # use rattle::plot::Chart;
    /// let curve = |k: u32| (format!("θ = {}°", 15 * k), [(0.0, 0.0), (1.0, f64::from(k))]);
    /// let svg = Chart::new("Directions").family((0..25).map(curve)).to_svg()?;
    /// assert!(svg.contains("θ = 0°") && svg.contains("θ = 360°") && !svg.contains("θ = 15°"));
    /// # Ok::<(), rattle::plot::PlotError>(())
    /// ```
    pub fn family<L, P>(mut self, curves: impl IntoIterator<Item = (L, P)>) -> Self
    where
        L: Into<String>,
        P: IntoIterator<Item = (f64, f64)>,
    {
        let members: Vec<(L, P)> = curves.into_iter().collect();
        let last = members.len().saturating_sub(1).max(1);
        let labelled: Vec<usize> = (0..FAMILY_LABELS).map(|k| k * last / (FAMILY_LABELS - 1)).collect();
        for (i, (label, points)) in members.into_iter().enumerate() {
            let colour = ColorMap::Viridis.map(VIRIDIS_END * i as f64 / last as f64);
            let label = if labelled.contains(&i) { label.into() } else { String::new() };
            self.curves.push(Curve {
                label,
                points: points.into_iter().collect(),
                colour,
                style: Style::Thin,
            });
        }
        self
    }

    /// On log–log axes, a dashed line of the given slope below the curve added last: the order to compare with.
    /// Without a curve before it, or on linear axes, nothing is drawn.
    ///
    /// ```
    /// # use rattle::plot::Chart;
    /// let chart = Chart::new("Error").log_log().marked("RATTLE", [(0.1, 1e-2), (0.01, 1e-4)]).slope(2.0, "h²");
    /// assert!(chart.to_svg()?.contains("h²"));
    /// # Ok::<(), rattle::plot::PlotError>(())
    /// ```
    pub fn slope(mut self, order: f64, label: impl Into<String>) -> Self {
        let measured = self.curves.iter().rev().find(|curve| !matches!(curve.style, Style::Slope(_)));
        let points = measured.map(|curve| curve.points.clone()).unwrap_or_default();
        let style = Style::Slope(order);
        self.curves.push(Curve { label: label.into(), points, colour: GREY.into(), style });
        self
    }

    /// The chart as SVG text: white ground, no font files, about 15 bytes a point.
    ///
    /// # Errors
    /// [`PlotError::Empty`] without a single point, [`PlotError::NotFinite`], and on logarithmic axes
    /// [`PlotError::NotPositive`].
    ///
    /// ```
    /// # use rattle::plot::{Chart, PlotError};
    /// let chart = Chart::new("Energy").line("RATTLE", [(0.0, 1.0), (1.0, f64::NAN)]);
    /// assert!(matches!(chart.to_svg(), Err(PlotError::NotFinite { index: 1, .. })));
    /// ```
    pub fn to_svg(&self) -> Result<String, PlotError> {
        self.check()?;
        let curves = self.drawn();
        let frame = Frame::around(self, &curves);
        let layout = self.layout(&frame, &curves);
        let plots = curves.iter().flat_map(|curve| frame.plots(curve)).collect();
        Ok(SvgBackend::default().render_scene(&render_multiple(plots, layout)))
    }

    /// Writes the SVG, and makes its folder where that is missing.
    ///
    /// # Errors
    /// Those of [`to_svg`](Chart::to_svg), and [`PlotError::Io`].
    ///
    /// ```
    /// # use rattle::plot::Chart;
    /// # let folder = tempfile::tempdir()?;
    /// # let path = folder.path().join("out/fall.svg");
    /// Chart::new("Fall").line("", [(0.0, 0.0), (1.0, 4.9)]).save(&path)?;
    /// assert!(std::fs::read_to_string(path)?.starts_with("<svg"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), PlotError> {
        let path = path.as_ref();
        let svg = self.to_svg()?;
        let written = path.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| fs::write(path, svg));
        written.map_err(|source| PlotError::Io { path: path.into(), source })
    }

    fn single(mut self, label: String, points: impl IntoIterator<Item = (f64, f64)>, style: Style) -> Self {
        let colour = COLOURS[self.singles % COLOURS.len()].into();
        self.singles += 1;
        self.curves.push(Curve { label, points: points.into_iter().collect(), colour, style });
        self
    }

    fn check(&self) -> Result<(), PlotError> {
        if self.curves.iter().all(|curve| curve.points.is_empty()) {
            return Err(PlotError::Empty { title: self.title.clone() });
        }
        for (number, curve) in self.curves.iter().enumerate() {
            for (index, &(x, y)) in curve.points.iter().enumerate() {
                let (title, label) = (self.title.clone(), curve.label.clone());
                if !(x.abs() <= LARGEST && y.abs() <= LARGEST) {
                    return Err(PlotError::NotFinite { title, curve: number, label, index, x, y });
                }
                if self.log && !(x >= 1.0 / LARGEST && y >= 1.0 / LARGEST) {
                    return Err(PlotError::NotPositive { title, curve: number, label, index, x, y });
                }
            }
        }
        Ok(())
    }

    /// The curves with their reference lines worked out, and without those that have nothing to draw.
    fn drawn(&self) -> Vec<Curve> {
        let floor = self.curves.iter().flat_map(|curve| &curve.points).map(|p| p.1).fold(f64::MAX, f64::min);
        let mut curves = self.curves.clone();
        curves.retain_mut(|curve| {
            if let Style::Slope(order) = curve.style {
                curve.points = if self.log { reference(&curve.points, order, floor) } else { Vec::new() };
            }
            !curve.points.is_empty()
        });
        curves
    }

    fn layout(&self, frame: &Frame, curves: &[Curve]) -> Layout {
        let legend: Vec<LegendEntry> = curves.iter().filter(|c| !c.label.is_empty()).map(entry).collect();
        let ticks = |shift, stride| Ticks { log: self.log, shift, stride };
        let mut layout = Layout::new(frame.x, frame.y)
            .with_width(WIDTH)
            .with_height(frame.height)
            .with_title(self.title.clone())
            .with_theme(theme())
            .with_font_family(
                "Inter, Segoe UI, Helvetica Neue, Liberation Sans, DejaVu Sans, Arial, sans-serif",
            )
            .with_title_size(18)
            .with_label_size(14)
            .with_tick_size(12)
            .with_body_size(13)
            .with_axis_line_width(0.8)
            .with_tick_width(0.8)
            .with_grid_line_width(0.6)
            .with_x_axis_min(frame.x.0)
            .with_x_axis_max(frame.x.1)
            .with_y_axis_min(frame.y.0)
            .with_y_axis_max(frame.y.1)
            .with_legend_box(false)
            .with_x_tick_format(ticks(frame.shift.0, frame.stride.0).format())
            .with_y_tick_format(ticks(frame.shift.1, frame.stride.1).format());
        if !self.x.is_empty() {
            layout = layout.with_x_label(self.x.clone());
        }
        if !self.y.is_empty() {
            layout = layout.with_y_label(self.y.clone());
        }
        if self.log {
            layout = layout.with_log_scale();
        }
        if self.equal {
            layout = layout.with_equal_aspect();
        }
        if !legend.is_empty() {
            layout = layout.with_legend_entries(legend);
        }
        layout
    }
}

/// The window on the data. `shift` moves data by whole decades, because the chart crate takes every logarithm of
/// max(x, 1e-10), and every range shorter than about 1e-12 for empty, and we plot errors down to 1e-16; the tick labels
/// shift back.
struct Frame {
    x: (f64, f64),
    y: (f64, f64),
    shift: (i32, i32),
    stride: (i32, i32),
    height: f64,
}

impl Frame {
    fn around(chart: &Chart, curves: &[Curve]) -> Self {
        let range = |value: fn(&(f64, f64)) -> f64| {
            let values = curves.iter().flat_map(|curve| &curve.points).map(value);
            values.fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)))
        };
        let (x, y) = (range(|p| p.0), range(|p| p.1));
        if chart.log {
            let shift = (-x.0.log10().floor() as i32, -y.0.log10().floor() as i32);
            let window = |(low, high): (f64, f64), shift| {
                (scaled(low, shift) / LOG_MARGIN, scaled(high, shift) * LOG_MARGIN)
            };
            let stride = |(low, high): (f64, f64)| 1 + ((high / low).log10() / LOG_LABELS) as i32;
            return Self {
                x: window(x, shift.0),
                y: window(y, shift.1),
                shift,
                stride: (stride(x), stride(y)),
                height: HEIGHT,
            };
        }
        let mut shift = (decades_up(x), decades_up(y));
        if chart.equal {
            shift = (shift.0.min(shift.1), shift.0.min(shift.1));
        }
        let moved = |(low, high): (f64, f64), shift| (scaled(low, shift), scaled(high, shift));
        let (x, y) = (moved(x, shift.0), moved(y, shift.1));
        let dots = curves.iter().any(|curve| curve.style == Style::Points);
        let at_the_sides = match (chart.equal, dots) {
            (true, _) => 0.05,
            (false, true) => 0.015, // a dot is not cut in half
            (false, false) => 0.0,
        };
        let (x, y) = (padded(x, at_the_sides), padded(y, 0.06));
        let height = if chart.equal {
            // Title, ticks and labels take about 110 of the height and 90 of the width.
            (110.0 + (WIDTH - 90.0) * (y.1 - y.0) / (x.1 - x.0)).clamp(240.0, 900.0)
        } else {
            HEIGHT
        };
        Self { x, y, shift, stride: (1, 1), height }
    }

    fn plots(&self, curve: &Curve) -> Vec<Plot> {
        let points: Vec<(f64, f64)> =
            curve.points.iter().map(|&(x, y)| (scaled(x, self.shift.0), scaled(y, self.shift.1))).collect();
        let (width, style) = match curve.style {
            Style::Line => (1.6, LineStyle::Solid),
            Style::Thin => (1.0, LineStyle::Solid),
            Style::Marked | Style::Points => (1.6, LineStyle::Solid),
            Style::Slope(_) => (1.2, LineStyle::Dashed),
        };
        let line = LinePlot::new().with_color(&*curve.colour).with_stroke_width(width).with_line_style(style);
        let mut plots = Vec::new();
        if curve.style != Style::Points {
            plots.push(Plot::Line(line.with_data(points.iter().copied())));
        }
        if matches!(curve.style, Style::Marked | Style::Points) {
            let size = if curve.style == Style::Points { dot(points.len()) } else { 4.0 };
            plots.push(Plot::Scatter(
                ScatterPlot::new().with_data(points).with_color(&*curve.colour).with_size(size),
            ));
        }
        plots
    }
}

/// Decades that fit on a logarithmic axis with a label each.
const LOG_LABELS: f64 = 16.0;
/// Room at the ends of a logarithmic axis.
const LOG_MARGIN: f64 = 1.35;

/// The radius of so many dots: all together they cover the same part of the paper, as long as one can be seen.
fn dot(number: usize) -> f64 {
    (3.0 * (300.0 / number as f64).sqrt()).clamp(0.8, 3.0)
}

/// By how many decades tiny numbers are to be raised on a linear axis; none from 10⁻⁶ on.
fn decades_up((low, high): (f64, f64)) -> i32 {
    let size = low.abs().max(high.abs());
    if size > 0.0 && size < 1e-6 { -(size.log10().floor() as i32) } else { 0 }
}

fn padded((low, high): (f64, f64), part: f64) -> (f64, f64) {
    let span = high - low;
    // A constant still gets an axis, wide enough that its ticks are distinct doubles.
    if span <= 1e-9 * low.abs().max(high.abs()) || span == 0.0 {
        let half = if low == 0.0 { 1.0 } else { 1e-3 * low.abs() };
        return (low - half, high + half);
    }
    (low - part * span, high + part * span)
}

/// y = c xᵖ through half the height of the curve's last point, cut off at the lowest value on the chart.
fn reference(points: &[(f64, f64)], order: f64, floor: f64) -> Vec<(f64, f64)> {
    let by_x = |a: &&(f64, f64), b: &&(f64, f64)| a.0.total_cmp(&b.0);
    let (Some(&(x0, _)), Some(&(x1, y1))) = (points.iter().min_by(by_x), points.iter().max_by(by_x)) else {
        return Vec::new();
    };
    let y1 = y1 / 2.0;
    let start = if order > 0.0 { x0.max(x1 * (floor / y1).powf(1.0 / order)) } else { x0 };
    vec![(start, y1 * (start / x1).powf(order)), (x1, y1)]
}

fn entry(curve: &Curve) -> LegendEntry {
    let dashed = matches!(curve.style, Style::Slope(_)).then(|| "5 3".into());
    LegendEntry {
        label: curve.label.clone(),
        color: curve.colour.clone(),
        shape: if curve.style == Style::Points { LegendShape::Circle } else { LegendShape::Line },
        dasharray: dashed,
    }
}

fn theme() -> Theme {
    let (ink, pale) = ("#2b2f36".to_string(), "#e8eaee".to_string());
    Theme {
        axis_color: ink.clone(),
        tick_color: ink.clone(),
        text_color: ink,
        grid_color: pale,
        ..Theme::light()
    }
}

fn scaled(value: f64, decades: i32) -> f64 {
    value * 10f64.powi(decades)
}

/// How an axis writes its ticks.
#[derive(Clone, Copy)]
struct Ticks {
    log: bool,
    shift: i32,
    /// On wide logarithmic axes only every n-th decade is labelled.
    stride: i32,
}

impl Ticks {
    fn format(self) -> TickFormat {
        TickFormat::Custom(Arc::new(move |value| self.label(value)))
    }

    /// Plain where that is short, else a power of ten: 0.25, 12000, 5·10⁻⁴, 10⁻¹⁶.
    fn label(self, value: f64) -> String {
        if value == 0.0 {
            return "0".into();
        }
        let text = format!("{value:.5e}");
        let (mantissa, exponent) = text.split_once('e').expect("`{:e}` writes an exponent");
        let exponent = exponent.parse::<i32>().expect("an integer") - self.shift;
        let mantissa = mantissa.trim_end_matches('0').trim_end_matches('.').replace('-', "−");
        let plain_from = if self.log { -2 } else { -3 }; // on log axes 10⁻³ reads better among its neighbours
        match (exponent, mantissa.as_str()) {
            _ if self.log && exponent % self.stride != 0 => String::new(),
            _ if (plain_from..=4).contains(&exponent) => plain(value * 10f64.powi(-self.shift)),
            (_, "1") => format!("10{}", superscript(exponent)),
            (_, "−1") => format!("−10{}", superscript(exponent)),
            _ => format!("{mantissa}·10{}", superscript(exponent)),
        }
    }
}

fn plain(value: f64) -> String {
    let text = format!("{value:.6}");
    text.trim_end_matches('0').trim_end_matches('.').replace('-', "−")
}

fn superscript(exponent: i32) -> String {
    let digit = |c: char| {
        c.to_digit(10).map_or('⁻', |d| ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][d as usize])
    };
    exponent.to_string().chars().map(digit).collect()
}

/// What can go wrong with a chart.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlotError {
    /// There is nothing to draw.
    #[error("chart `{title}` has no point")]
    Empty {
        /// The chart.
        title: String,
    },
    /// A coordinate is NaN, infinite or beyond 1e150.
    #[error("chart `{title}`, curve {curve} `{label}`: point {index} is ({x}, {y})")]
    NotFinite {
        /// The chart.
        title: String,
        /// The curve's number in the order of drawing.
        curve: usize,
        /// The curve's label.
        label: String,
        /// The point's number.
        index: usize,
        /// The point.
        x: f64,
        /// The point.
        y: f64,
    },
    /// A logarithmic axis can't show zero, a negative value or one below 1e-150.
    #[error(
        "chart `{title}`, curve {curve} `{label}`: point {index} is ({x:e}, {y:e}), but the axes are logarithmic; leave it out"
    )]
    NotPositive {
        /// The chart.
        title: String,
        /// The curve's number in the order of drawing.
        curve: usize,
        /// The curve's label.
        label: String,
        /// The point's number.
        index: usize,
        /// The point.
        x: f64,
        /// The point.
        y: f64,
    },
    /// The file can't be written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}
