//! Charts as SVG files: curves, marks, bars, bands and maps; linear and logarithmic axes, families of curves, reference
//! slopes. Curves that lie on earlier ones are dashed. Of long curves only as many points are written as can be seen.
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

mod axis;
mod curve;
mod draw;
mod series;
mod svg;

use crate::files;
use curve::{Curve, Map, Style};
use draw::Sheet;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// A family shows this many of its curves in the legend.
const FAMILY_LABELS: usize = 5;
/// Beyond, the arithmetic of the axes would overflow.
const LARGEST: f64 = 1e150;

/// A chart to be saved as SVG. Curves are drawn in the order in which they are added; a curve with an empty label is
/// not in the legend.
#[doc(alias = "plot")]
#[doc(alias = "graph")]
#[doc(alias = "svg")]
#[doc(alias = "figure")]
#[derive(Clone, Debug)]
pub struct Chart {
    title: String,
    x: String,
    y: String,
    log: [bool; 2],
    equal: bool,
    curves: Vec<Curve>,
    map: Option<Map>,
    singles: usize,
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
            log: [false; 2],
            equal: false,
            curves: Vec::new(),
            map: None,
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
        self.log = [true; 2];
        self
    }

    /// The horizontal axis logarithmic; every x must then be positive.
    ///
    /// ```
    /// # use rattle::plot::Chart;
    /// let chart = Chart::new("Response").log_x().line("", [(0.01, 0.0), (1.0, -3.0), (100.0, -40.0)]);
    /// assert!(chart.to_svg()?.contains("100"));
    /// # Ok::<(), rattle::plot::PlotError>(())
    /// ```
    pub fn log_x(mut self) -> Self {
        self.log[0] = true;
        self
    }

    /// The vertical axis logarithmic; every y must then be positive.
    ///
    /// ```
    /// # use rattle::plot::Chart;
    /// let decay = (0..50).map(|t| (f64::from(t), (-0.5 * f64::from(t)).exp()));
    /// assert!(Chart::new("Decay").log_y().line("", decay).to_svg()?.contains("10⁻⁸"));
    /// # Ok::<(), rattle::plot::PlotError>(())
    /// ```
    pub fn log_y(mut self) -> Self {
        self.log[1] = true;
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

    /// A curve with a mark at each point, for few or measured values.
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

    /// Points without a line: a scatter plot, or measurements on top of a curve.
    ///
    /// ```
    /// # use rattle::plot::Chart;
    /// let chart = Chart::new("Section").points("returns", [(1.0, 3.0), (2.0, 1.0), (1.2, 2.0)]);
    /// assert!(chart.to_svg()?.matches("<circle").count() >= 3);
    /// # Ok::<(), rattle::plot::PlotError>(())
    /// ```
    #[doc(alias = "scatter")]
    pub fn points(self, label: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        self.single(label.into(), points, Style::Points)
    }

    /// Bars from zero (on a logarithmic axis, from the axis) to each point, as wide as the least distance between two
    /// points.
    ///
    /// ```
    /// # use rattle::plot::Chart;
    /// let counts = [(0.5, 3.0), (1.5, 7.0), (2.5, 4.0)];
    /// assert_eq!(Chart::new("Counts").bars("", counts).to_svg()?.matches("crispEdges").count(), 3);
    /// # Ok::<(), rattle::plot::PlotError>(())
    /// ```
    #[doc(alias = "histogram")]
    pub fn bars(self, label: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let points: Vec<(f64, f64)> = points.into_iter().collect();
        let mut places: Vec<f64> = points.iter().map(|point| point.0).collect();
        places.sort_by(f64::total_cmp);
        let apart = places.windows(2).map(|pair| pair[1] - pair[0]).filter(|&apart| apart > 0.0);
        let width = apart.reduce(f64::min).filter(|width| *width <= LARGEST).unwrap_or(1.0);
        self.single(label.into(), points, Style::Bars(width))
    }

    /// The region between a lower and an upper curve, given as (x, low, high) from left to right: a deviation, a
    /// confidence interval. It has the colour of the next curve.
    ///
    /// ```
    /// # use rattle::plot::Chart;
    /// let mean = |t: f64| 1.0 - (-t).exp();
    /// let times = || (0..=40).map(|i| 0.1 * f64::from(i));
    /// let chart = Chart::new("Warming")
    ///     .band("± σ", times().map(|t| (t, mean(t) - 0.1, mean(t) + 0.1)))
    ///     .line("mean", times().map(|t| (t, mean(t))));
    /// assert!(chart.to_svg()?.contains("fill-opacity"));
    /// # Ok::<(), rattle::plot::PlotError>(())
    /// ```
    #[doc(alias = "fill_between")]
    #[doc(alias = "error bars")]
    pub fn band(
        mut self,
        label: impl Into<String>,
        points: impl IntoIterator<Item = (f64, f64, f64)>,
    ) -> Self {
        let points: Vec<(f64, f64, f64)> = points.into_iter().collect();
        let (low, high) = (points.iter().map(|p| (p.0, p.1)), points.iter().rev().map(|p| (p.0, p.2)));
        let (points, colour) = (low.chain(high).collect(), curve::single(self.singles));
        self.curves.push(Curve { label: label.into(), points, colour, style: Style::Band });
        self
    }

    /// A heat map: numbers on a rectangle as colours, with a colour scale. Rows of equal length go from low y to high
    /// y, each from low x to high x. A chart has one map, under all its curves. Cells are equally long in x and in y,
    /// on logarithmic axes too, where they look narrower towards their ends.
    ///
    /// ```
    /// # use rattle::plot::Chart;
    /// let row = |j: u32| (0..40).map(|i| (0.2 * f64::from(i)).sin() * (0.2 * f64::from(j)).cos()).collect();
    /// let chart = Chart::new("Potential").map("U", [0.0, 8.0], [0.0, 4.0], (0..20).map(row).collect());
    /// assert!(chart.to_svg()?.contains(">U<"));
    /// # Ok::<(), rattle::plot::PlotError>(())
    /// ```
    #[doc(alias = "heatmap")]
    #[doc(alias = "imshow")]
    pub fn map(mut self, label: impl Into<String>, x: [f64; 2], y: [f64; 2], rows: Vec<Vec<f64>>) -> Self {
        self.map = Some(Map { label: label.into(), x, y, rows });
        self
    }

    /// Many curves in the order of a parameter: thin lines, coloured along viridis, and a legend that names the first,
    /// the last and a few between.
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
            let colour = curve::along(i as f64 / last as f64);
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

    /// On log–log axes, a dashed line of the given slope to compare the order of convergence: everywhere below the
    /// curve added last, and where they are nearest at half its height. Nothing is drawn without a curve before it, or
    /// on linear axes.
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
        self.curves.push(Curve { label: label.into(), points, colour: curve::GREY.into(), style });
        self
    }

    /// The chart as SVG text: white ground, no font files, about 16 bytes a point. A curve from left to right is
    /// written with some thousands of points at most, chosen so that it looks the same as with all of them.
    ///
    /// # Errors
    /// [`PlotError::Empty`] where there is no point, [`PlotError::NotFinite`], on logarithmic axes
    /// [`PlotError::NotPositive`], and [`PlotError::Map`].
    ///
    /// ```
    /// # use rattle::plot::{Chart, PlotError};
    /// let chart = Chart::new("Energy").line("RATTLE", [(0.0, 1.0), (1.0, f64::NAN)]);
    /// assert!(matches!(chart.to_svg(), Err(PlotError::NotFinite { index: 1, .. })));
    /// ```
    pub fn to_svg(&self) -> Result<String, PlotError> {
        self.check()?;
        let curves = self.drawn();
        let Self { title, x, y, log, equal, map, .. } = self;
        let equal = *equal && *log == [false; 2];
        Ok(draw::draw(&Sheet { title, x, y, log: *log, equal, curves: &curves, map: map.as_ref() }))
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
        let written = files::create(path).and_then(|mut file| file.write_all(svg.as_bytes()));
        written.map_err(|source| PlotError::Io { path: path.into(), source })
    }

    fn single(mut self, label: String, points: impl IntoIterator<Item = (f64, f64)>, style: Style) -> Self {
        let colour = curve::single(self.singles);
        self.singles += 1;
        self.curves.push(Curve { label, points: points.into_iter().collect(), colour, style });
        self
    }

    fn check(&self) -> Result<(), PlotError> {
        if let Some(map) = &self.map {
            self.check_map(map)?;
        } else if self.curves.iter().all(|curve| curve.points.is_empty()) {
            return Err(PlotError::Empty { title: self.title.clone() });
        }
        for (number, curve) in self.curves.iter().enumerate() {
            for (place, &(x, y)) in curve.points.iter().enumerate() {
                let names = || (self.title.clone(), curve.label.clone());
                // A band goes there and back.
                let back = curve.points.len() - 1 - place;
                let index = if curve.style == Style::Band { place.min(back) } else { place };
                if !(x.abs() <= LARGEST && y.abs() <= LARGEST) {
                    let (title, label) = names();
                    return Err(PlotError::NotFinite { title, curve: number, label, index, x, y });
                }
                let shown = |log: bool, value: f64| !log || value >= 1.0 / LARGEST;
                if !(shown(self.log[0], x) && shown(self.log[1], y)) {
                    let (title, label) = names();
                    return Err(PlotError::NotPositive { title, curve: number, label, index, x, y });
                }
            }
        }
        Ok(())
    }

    fn check_map(&self, map: &Map) -> Result<(), PlotError> {
        let Map { x, y, rows, .. } = map;
        let wide = |[low, high]: [f64; 2], log: bool| {
            low < high && low.abs().max(high.abs()) <= LARGEST && (!log || low >= 1.0 / LARGEST)
        };
        let columns = rows.first().map_or(0, Vec::len);
        let even = columns > 0 && rows.iter().all(|row| row.len() == columns);
        let number = rows.iter().flatten().position(|value| !matches!(value.abs(), 0.0..=LARGEST));
        if wide(*x, self.log[0]) && wide(*y, self.log[1]) && even && number.is_none() {
            return Ok(());
        }
        let cell = number.filter(|_| even).map(|i| (i / columns, i % columns));
        Err(PlotError::Map { title: self.title.clone(), x: *x, y: *y, rows: rows.len(), columns, cell })
    }

    /// The curves with their reference lines worked out, and without those that have nothing to draw.
    fn drawn(&self) -> Vec<Curve> {
        let floor = self.curves.iter().flat_map(|curve| &curve.points).map(|p| p.1).fold(f64::MAX, f64::min);
        let mut curves = self.curves.clone();
        curves.retain_mut(|curve| {
            if let Style::Slope(order) = curve.style {
                curve.points = if self.log == [true; 2] {
                    curve::slope(&curve.points, order, floor)
                } else {
                    Vec::new()
                };
                curve.points.retain(|(x, y)| [x, y].iter().all(|v| (1.0 / LARGEST..=LARGEST).contains(*v)));
            }
            !curve.points.is_empty()
        });
        curves
    }
}

/// What can go wrong with a chart.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum PlotError {
    /// There is nothing to draw.
    #[error("chart `{title}` has no point")]
    Empty {
        /// The chart.
        title: String,
    },
    /// A coordinate is NaN, infinite or beyond 1e150.
    #[error(
        "chart `{title}`, curve {curve} `{label}`: point {index} is ({}, {}), {}; leave it out",
        shortly(*x), shortly(*y),
        if x.is_nan() || y.is_nan() { "which is not a number" } else { "which is beyond 1e150" }
    )]
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
    /// A map needs a box that is wide and high, rows of one length, and numbers of at most 1e150.
    #[error(
        "chart `{title}`: a map of {rows} rows, the first of {columns} numbers, over x = {x:?} and y = {y:?}{}",
        match cell { Some((row, column)) => format!(": number {column} of row {row} is not finite"), None => "; give rows of one length and a box from low to high, positive on logarithmic axes".into() }
    )]
    Map {
        /// The chart.
        title: String,
        /// Lowest and highest x.
        x: [f64; 2],
        /// Lowest and highest y.
        y: [f64; 2],
        /// Rows.
        rows: usize,
        /// Numbers in the first row.
        columns: usize,
        /// Row and column of a number that is not finite.
        cell: Option<(usize, usize)>,
    },
    /// A logarithmic axis can't show zero, a negative value or one below 1e-150.
    #[error(
        "chart `{title}`, curve {curve} `{label}`: point {index} is ({x:e}, {y:e}), but an axis is logarithmic; leave it out"
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
        /// The error of the file system.
        source: io::Error,
    },
}

debug_as_display!(PlotError);

/// A number, with an exponent where it would be long.
fn shortly(x: f64) -> String {
    let is_short = x == 0.0 || !x.is_finite() || (1e-4..1e6).contains(&x.abs());
    if is_short { format!("{x}") } else { format!("{x:e}") }
}
