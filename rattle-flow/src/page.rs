//! A web page in one file that shows water moving over the ground.

use crate::error::{FlowError, one_for_each_vertex};
use crate::flow::{Flow, checked, number};
use base64::prelude::{BASE64_STANDARD, Engine};
use std::fmt::Write;

/// An interactive page with the depths of a flow at some times, to be rotated and played.
///
/// ```
/// use rattle_flow::{Flow, Mesh, Page, Resistance};
/// let mesh = Mesh::polygon(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]], 0.25)?;
/// let depth = mesh.at_vertices(|[x, _]| if x < 1.0 { 1.0 } else { 0.0 });
/// let mut simulation = Flow::over(mesh, Resistance::DarcyWeisbach { gravity: 1.0 }).simulate(depth, 0.1)?;
/// let mut page = Page::new("A dam breaks", simulation.flow());
/// for _ in 0..10 {
///     simulation.step()?;
///     page.add(simulation.time(), simulation.depth())?;
/// }
/// let html = page.caption("A second of it.").units("m", "s").to_html()?;
/// assert!(html.contains("A dam breaks") && !html.contains("http"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Page {
    title: String,
    caption: String,
    /// Vertices from the middle of all.
    points: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    times: Vec<f64>,
    depths: Vec<f64>,
    lift: f64,
    seconds: f64,
    units: [String; 2],
}

impl Page {
    /// A page without depths; [`add`](Page::add) adds them.
    pub fn new(title: impl Into<String>, flow: &Flow) -> Self {
        let places = || flow.mesh().points().iter().zip(flow.bed()).map(|([x, y], b)| [*x, *y, *b]);
        // From the middle, before they are rounded: coordinates of maps lie millions of metres from their zero.
        let middle = [0, 1, 2].map(|i| {
            let along = || places().map(move |place| place[i]);
            let (low, high) =
                (along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max));
            low + 0.5 * (high - low)
        });
        Page {
            title: title.into(),
            caption: String::new(),
            points: places().map(|place| [0, 1, 2].map(|i| (place[i] - middle[i]) as f32)).collect(),
            triangles: flow.mesh().triangles().to_vec(),
            times: Vec::new(),
            depths: Vec::new(),
            lift: 1.0,
            seconds: 20.0,
            units: [const { String::new() }; 2],
        }
    }

    /// Adds the depth at the vertices at a time.
    ///
    /// # Errors
    /// [`FlowError::Count`] if the number of depths is not the number of vertices; [`FlowError::Number`] for a time and
    /// [`FlowError::Given`] for a depth that is not finite. The page is then as it was.
    pub fn add(&mut self, time: f64, depth: &[f64]) -> Result<(), FlowError> {
        one_for_each_vertex(depth, self.points.len())?;
        number("the time on a page", time, true, "a finite number")?;
        checked("depth at vertex", depth, time, f64::NEG_INFINITY, "a finite number")?;
        self.times.push(time);
        self.depths.extend_from_slice(depth);
        Ok(())
    }

    /// A sentence or two under the title.
    #[must_use]
    pub fn caption(mut self, caption: impl Into<String>) -> Self {
        self.caption = caption.into();
        self
    }

    /// The vertical exaggeration; by default 1.
    #[must_use]
    pub fn lift(mut self, lift: f64) -> Self {
        self.lift = lift;
        self
    }

    /// The units of lengths and times, for the legend: `"m"` and `"s"`. By default there are none.
    #[must_use]
    pub fn units(mut self, length: impl Into<String>, time: impl Into<String>) -> Self {
        self.units = [length.into(), time.into()];
        self
    }

    /// How many seconds the whole motion takes on the page; by default 20.
    #[must_use]
    pub fn seconds(mut self, seconds: f64) -> Self {
        self.seconds = seconds;
        self
    }

    /// The page as text. It holds depths rounded to 1/65535 of the largest one.
    ///
    /// # Errors
    /// [`FlowError::Number`] for an exaggeration that is not finite, a number of seconds that is not above 0, and a
    /// page to which nothing was added.
    pub fn to_html(&self) -> Result<String, FlowError> {
        number("the vertical exaggeration on a page", self.lift, true, "a finite number")?;
        number("the seconds that a page plays", self.seconds, self.seconds > 0.0, "a finite number above 0")?;
        let frames = self.times.len();
        number(
            "the number of times on a page",
            frames as f64,
            frames > 0,
            "one at least: `Page::add` adds it",
        )?;
        let deepest = self.depths.iter().copied().fold(0.0, f64::max);
        let deepest = if deepest > 0.0 { deepest } else { 1.0 }; // of dry ground any unit does
        let shares = self.depths.iter().map(|h| (h.max(0.0) / deepest * 65535.0).round() as u16);
        let depths = encoded(shares.flat_map(u16::to_le_bytes));
        let points = encoded(self.points.iter().flatten().flat_map(|x| x.to_le_bytes()));
        let triangles = encoded(self.triangles.iter().flatten().flat_map(|v| v.to_le_bytes()));
        let mut data = String::new();
        let Page { times, lift, seconds, .. } = self;
        let film = 0.002 * deepest;
        let [length, time] = self.units.each_ref().map(|unit| quoted(unit));
        let _ = write!(
            data,
            r#"{{"times":{times:?},"deepest":{deepest:e},"film":{film:e},"lift":{lift},"seconds":{seconds},"length":{length},"time":{time},"#
        );
        let _ = write!(data, r#""points":"{points}","triangles":"{triangles}","depths":"{depths}"}}"#);
        let (title, caption) = (escaped(&self.title), escaped(&self.caption));
        // All at once: what is put in may look like a place where something is put in.
        let parts = include_str!("page.html").split("__").map(|part| match part {
            "TITLE" => &title,
            "CAPTION" => &caption,
            "DATA" => &data,
            other => other,
        });
        Ok(parts.collect())
    }

    /// Writes the page to a file.
    ///
    /// # Errors
    /// Those of the file system, and [`InvalidInput`](std::io::ErrorKind::InvalidInput) for those of
    /// [`to_html`](Page::to_html).
    pub fn write(&self, path: impl AsRef<std::path::Path>) -> std::io::Result<()> {
        let html = self.to_html();
        std::fs::write(
            path,
            html.map_err(|error| std::io::Error::new(std::io::ErrorKind::InvalidInput, error))?,
        )
    }
}

fn encoded(bytes: impl Iterator<Item = u8>) -> String {
    BASE64_STANDARD.encode(bytes.collect::<Vec<u8>>())
}

/// As a string of JavaScript's inside a script.
fn quoted(text: &str) -> String {
    format!("{text:?}").replace('<', "\\x3c")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
