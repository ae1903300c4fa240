//! Building a scene; `shapes.rs` has the shapes besides bodies.

use super::error::{MAX_POINTS, PageError};
use super::mesh::Mesh;
use super::parts::{Disc, End, Moved, Strip};
use crate::Trajectory;

/// Of numbers that may change with time.
pub(super) const TIMES: [&str; 2] = ["time (or one)", "times (or one)"];

/// A place in space: an array, or a vector of `nalgebra`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no place in space",
    label = "a place is an array of three numbers, or a vector of `nalgebra`",
    note = "places are listed body by body: `&[[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]]` is one body at two times"
)]
pub trait Place: Copy {
    /// Its coordinates.
    fn place(self) -> [f64; 3];
}

#[diagnostic::do_not_recommend]
impl<X: Copy + Into<[f64; 3]>> Place for X {
    fn place(self) -> [f64; 3] {
        self.into()
    }
}

/// A scene of a [`Page`](super::Page): bodies, and the surface on which they move, if any.
#[derive(Clone, Debug)]
pub struct Scene3 {
    pub(super) title: String,
    pub(super) caption: String,
    /// From which time on which surface is shown.
    pub(super) surfaces: Vec<(f64, Mesh)>,
    /// Of each vertex of the surfaces.
    pub(super) heat: Option<(String, Vec<f64>)>,
    pub(super) times: Vec<f64>,
    pub(super) positions: Vec<Vec<[f64; 3]>>,
    /// Of a trajectory that no page shows.
    pub(super) coordinates: Option<usize>,
    /// Of a trajectory that has others than the scene: its number, the trajectory's time and the scene's.
    pub(super) other: Option<(usize, [f64; 2])>,
    pub(super) trail: usize,
    pub(super) seconds: f64,
    /// Of space along the axes, 0 where it has none.
    pub(super) periods: [f64; 3],
    /// By body, one number or one for each time.
    pub(super) sizes: Option<Vec<Vec<f64>>>,
    pub(super) tints: Option<(String, Vec<Vec<f64>>)>,
    pub(super) names: Vec<String>,
    pub(super) rods: Vec<[End; 2]>,
    pub(super) discs: Vec<Disc>,
    pub(super) walls: Vec<[[f64; 3]; 3]>,
    pub(super) boxes: Vec<Moved>,
    pub(super) axes: Option<[String; 3]>,
    pub(super) charts: Vec<Strip>,
}

impl Scene3 {
    /// A scene without bodies.
    ///
    /// ```
    /// use rattle::view::{Page, PageError, Scene3};
    /// let error = Page::new("Page").scene(Scene3::new("nothing moves")).to_html().unwrap_err();
    /// assert!(matches!(error, PageError::NoMotion { .. }));
    /// ```
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            caption: String::new(),
            surfaces: Vec::new(),
            heat: None,
            times: Vec::new(),
            positions: Vec::new(),
            coordinates: None,
            other: None,
            trail: 0,
            seconds: 30.0,
            periods: [0.0; 3],
            sizes: None,
            tints: None,
            names: Vec::new(),
            rods: Vec::new(),
            discs: Vec::new(),
            walls: Vec::new(),
            boxes: Vec::new(),
            axes: None,
            charts: Vec::new(),
        }
    }

    /// The surface, drawn softly lit; trails behind it shine through faintly.
    ///
    /// ```
    /// use rattle::view::{Mesh, Page, Scene3};
    /// let sphere = |[x, y, z]: [f64; 3]| (x * x + y * y + z * z - 1.0, [2.0 * x, 2.0 * y, 2.0 * z]);
    /// let mesh = Mesh::of(sphere, [-1.2; 3], [1.2; 3], 12)?;
    /// let scene = Scene3::new("at the pole").surface(&mesh).bodies(&[0.0, 1.0], &[[[0.0, 0.0, 1.0]; 2]]);
    /// assert!(Page::new("Rest").scene(scene).to_html().is_ok());
    /// # Ok::<(), rattle::view::MeshError>(())
    /// ```
    pub fn surface(mut self, mesh: &Mesh) -> Self {
        self.surfaces = vec![(f64::NEG_INFINITY, mesh.clone())];
        self
    }

    /// A moving surface: each mesh is shown from its time until the time of the next.
    ///
    /// ```
    /// use rattle::view::{Mesh, MeshError, Page, Scene3};
    /// let balloon = |t: f64| {
    ///     let g = move |[x, y, z]: [f64; 3]| (x * x + y * y + z * z - t, [2.0 * x, 2.0 * y, 2.0 * z]);
    ///     Ok::<_, MeshError>((t, Mesh::of(g, [-1.5; 3], [1.5; 3], 12)?))
    /// };
    /// let surfaces = [1.0, 1.2, 1.4].into_iter().map(balloon).collect::<Result<Vec<_>, _>>()?;
    /// let scene = Scene3::new("balloon").times(&[1.0, 1.4]).moving_surface(&surfaces);
    /// assert!(Page::new("Balloon").scene(scene).to_html().is_ok());
    /// # Ok::<(), MeshError>(())
    /// ```
    pub fn moving_surface(mut self, surfaces: &[(f64, Mesh)]) -> Self {
        self.surfaces = surfaces.to_vec();
        self
    }

    /// Colours the surface by a number for each vertex of its mesh, with a colour scale: a curvature, a
    /// [density](Mesh::density). For a moving surface, `values` has the vertices of all meshes one after the other.
    ///
    /// ```
    /// use rattle::view::{Mesh, Page, Scene3};
    /// let sphere = |[x, y, z]: [f64; 3]| (x * x + y * y + z * z - 1.0, [2.0 * x, 2.0 * y, 2.0 * z]);
    /// let mesh = Mesh::of(sphere, [-1.2; 3], [1.2; 3], 12)?;
    /// let scene = Scene3::new("height").bodies(&[0.0, 1.0], &[[[0.0, 0.0, 1.0]; 2]]).surface(&mesh);
    /// let page = Page::new("Height").scene(scene.heat("z", mesh.vertices.iter().map(|q| q[2])));
    /// assert!(page.to_html().is_ok());
    /// # Ok::<(), rattle::view::MeshError>(())
    /// ```
    pub fn heat(mut self, label: impl Into<String>, values: impl IntoIterator<Item = f64>) -> Self {
        self.heat = Some((label.into(), values.into_iter().collect()));
        self
    }

    /// The times of the motion, for a scene without [bodies](Scene3::bodies).
    ///
    /// ```
    /// let scene = rattle::view::Scene3::new("at rest").times(&[0.0, 1.0]);
    /// assert!(rattle::view::Page::new("Rest").scene(scene).to_html().is_err());
    /// ```
    pub fn times(mut self, times: &[f64]) -> Self {
        (self.times, self.other) = (times.to_vec(), None);
        self
    }

    /// The motion: increasing times, and for each body its position at each of them (arrays or nalgebra's vectors).
    /// Bodies are coloured around the hue circle in their order, in several shades if they are many. Pointing at a body
    /// on the page shows its number or [name](Scene3::names).
    ///
    /// ```
    /// let path = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
    /// let scene = rattle::view::Scene3::new("flight").bodies(&[0.0, 1.0], &[path]);
    /// assert!(rattle::view::Page::new("Flight").scene(scene).to_html().is_ok());
    /// ```
    pub fn bodies<P, Q>(mut self, times: &[f64], positions: &[P]) -> Self
    where
        P: AsRef<[Q]>,
        Q: Place,
    {
        (self.times, self.other) = (times.to_vec(), None);
        self.positions =
            positions.iter().map(|path| path.as_ref().iter().map(|point| point.place()).collect()).collect();
        self
    }

    /// Adds the bodies of a trajectory: of one run, or of several runs with the same times in turn. Bodies in the plane
    /// move at z = 0.
    ///
    /// ```
    /// use rattle::prelude::*;
    /// let start = State::of([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).moving([0.0, 0.0, 1.0]);
    /// let mut simulation = Scene::points(2).simulate(start, Rattle::new(0.1))?;
    /// let mut trajectory = Trajectory::of(&simulation);
    /// simulation.observe(100, 2, &mut trajectory)?;
    /// let scene = rattle::view::Scene3::new("two in flight").trajectory(&trajectory);
    /// assert!(rattle::view::Page::new("Flight").scene(scene).to_html().is_ok());
    /// # Ok::<(), rattle::Error>(())
    /// ```
    ///
    /// A page says [`PageError::Dimension`] if the bodies have other than two or three coordinates, and
    /// [`PageError::OtherTimes`] if a trajectory has other times than the one before.
    pub fn trajectory(mut self, trajectory: &Trajectory) -> Self {
        let [_, bodies, coordinates] = trajectory.shape();
        if bodies > 0 && !matches!(coordinates, 2 | 3) {
            self.coordinates = Some(coordinates);
            return self;
        }
        if self.times.is_empty() {
            self.times = trajectory.times().to_vec();
        }
        // The page has one list of times; what nobody sees of them is rounding.
        let span = self.times.last().map_or(0.0, |last| last - self.times[0]);
        let pairs = trajectory.times().iter().zip(&self.times).map(|(&found, &wanted)| [found, wanted]);
        let differ = |(_, [found, wanted]): &(usize, [f64; 2])| (found - wanted).abs() > 1e-6 * span;
        self.other = self.other.or_else(|| pairs.enumerate().find(differ));
        let place = |q: &[f64]| [q[0], q[1], q.get(2).copied().unwrap_or(0.0)];
        let path = |body| trajectory.path(body).map(place).collect();
        self.positions.extend((0..bodies).map(path));
        self
    }

    /// Length of the trails in samples, at most the whole motion; by default 0, no trails.
    ///
    /// ```
    /// let times: Vec<f64> = (0..60).map(f64::from).collect();
    /// let path: Vec<[f64; 3]> = times.iter().map(|&t| [t, 0.0, 0.0]).collect();
    /// let scene = rattle::view::Scene3::new("flight").bodies(&times, &[path]).trail(25);
    /// assert!(rattle::view::Page::new("Flight").scene(scene).to_html()?.contains(r#""trail":25"#));
    /// # Ok::<(), rattle::view::PageError>(())
    /// ```
    pub fn trail(mut self, samples: usize) -> Self {
        self.trail = samples;
        self
    }

    /// How many seconds the whole motion takes on the page at speed 1; by default 30.
    ///
    /// ```
    /// let scene = rattle::view::Scene3::new("flight").bodies(&[0.0, 1.0], &[[[0.0; 3], [1.0; 3]]]).seconds(10.0);
    /// assert!(rattle::view::Page::new("Flight").scene(scene).to_html()?.contains(r#""seconds":10.0"#));
    /// # Ok::<(), rattle::view::PageError>(())
    /// ```
    ///
    /// A page says [`PageError::Number`] if `seconds` is not a positive number.
    pub fn seconds(mut self, seconds: f64) -> Self {
        self.seconds = seconds;
        self
    }

    /// Periods of space along the axes; 0 for an axis without. Between two samples a body moves to the nearest image of
    /// its next place, its trail follows all such ways back, and rods end at nearest images. So a body that leaves on
    /// one side enters on the other without a streak across the picture.
    ///
    /// ```
    /// let out_and_in = [[0.9, 0.0, 0.0], [0.1, 0.0, 0.0]];
    /// let scene = rattle::view::Scene3::new("around").bodies(&[0.0, 1.0], &[out_and_in]).periods([1.0, 0.0, 0.0]);
    /// assert!(rattle::view::Page::new("Around").scene(scene).to_html()?.contains(r#""periods":[1.0,0.0,0.0]"#));
    /// # Ok::<(), rattle::view::PageError>(())
    /// ```
    ///
    /// A page says [`PageError::Number`] if a period is negative, or not a number.
    pub fn periods(mut self, periods: [f64; 3]) -> Self {
        self.periods = periods;
        self
    }

    /// Changes the title, for a copy of a scene.
    ///
    /// ```
    /// let scene = rattle::view::Scene3::new("flight").bodies(&[0.0, 1.0], &[[[0.0; 3], [1.0; 3]]]);
    /// let other = scene.clone().renamed("flight with trails").trail(2);
    /// assert!(rattle::view::Page::new("Flights").scene(scene).scene(other).to_html()?.contains("with trails"));
    /// # Ok::<(), rattle::view::PageError>(())
    /// ```
    pub fn renamed(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// A sentence or two under the title.
    ///
    /// ```
    /// let scene = rattle::view::Scene3::new("flight").bodies(&[0.0, 1.0], &[[[0.0; 3], [1.0; 3]]]);
    /// let html = rattle::view::Page::new("Flight").scene(scene.caption("Straight on.")).to_html()?;
    /// assert!(html.contains("Straight on."));
    /// # Ok::<(), rattle::view::PageError>(())
    /// ```
    pub fn caption(mut self, caption: impl Into<String>) -> Self {
        self.caption = caption.into();
        self
    }

    /// Radii of the bodies in the scene's unit: one number for all, `&[[0.1]]`; one for each; or for each a list with
    /// one number for each time. By default bodies are small, and stay visible from afar.
    ///
    /// ```
    /// # use rattle::view::{Page, Scene3};
    /// let still = [[[0.0; 3]; 2], [[1.0; 3]; 2]];
    /// let scene = Scene3::new("two").bodies(&[0.0, 1.0], &still);
    /// let breathing = scene.clone().sizes(&[vec![0.1], vec![0.2, 0.3]]);
    /// assert!(Page::new("Sizes").scene(scene.sizes(&[[0.2]])).scene(breathing).to_html().is_ok());
    /// ```
    pub fn sizes(mut self, radii: &[impl AsRef<[f64]>]) -> Self {
        self.sizes = Some(radii.iter().map(|radii| radii.as_ref().to_vec()).collect());
        self
    }

    /// Colours bodies by a number, with a colour scale: for each body one number, or one for each time.
    ///
    /// ```
    /// # use rattle::view::{Page, Scene3};
    /// let still = [[[0.0; 3]; 2], [[1.0; 3]; 2]];
    /// let scene = Scene3::new("two").bodies(&[0.0, 1.0], &still).coloured_by("speed", &[[0.0, 1.0], [3.0, 2.0]]);
    /// assert!(Page::new("Speeds").scene(scene).to_html()?.contains("speed"));
    /// # Ok::<(), rattle::view::PageError>(())
    /// ```
    pub fn coloured_by(mut self, label: impl Into<String>, values: &[impl AsRef<[f64]>]) -> Self {
        self.tints = Some((label.into(), values.iter().map(|values| values.as_ref().to_vec()).collect()));
        self
    }

    /// Labels beside the bodies, in their order. An empty name shows no label; nor do bodies after the last name.
    ///
    /// ```
    /// # use rattle::view::{Page, Scene3};
    /// let scene = Scene3::new("two").bodies(&[0.0, 1.0], &[[[0.0; 3]; 2], [[1.0; 3]; 2]]).names(["sun", "earth"]);
    /// assert!(Page::new("Names").scene(scene).to_html()?.contains("earth"));
    /// # Ok::<(), rattle::view::PageError>(())
    /// ```
    pub fn names(mut self, names: impl IntoIterator<Item = impl Into<String>>) -> Self {
        self.names = names.into_iter().map(Into::into).collect();
        self
    }

    pub(super) fn check(&self) -> Result<(), PageError> {
        let scene = || self.title.clone();
        if let Some(coordinates) = self.coordinates {
            return Err(PageError::Dimension { scene: scene(), coordinates });
        }
        if let Some((frame, [found, wanted])) = self.other {
            return Err(PageError::OtherTimes { scene: scene(), frame, found, wanted });
        }
        self.numbers("duration", [&self.seconds], true)?;
        self.numbers("period", self.periods.iter().filter(|&&period| period != 0.0), true)?;
        let moves = !self.positions.is_empty() || !self.boxes.is_empty() || self.surfaces.len() > 1;
        if !moves || self.times.len() < 2 {
            return Err(PageError::NoMotion { scene: scene() });
        }
        // The page divides by the differences of the times that it holds.
        let since = |i: usize| self.since_first(self.times[i]);
        let increasing = |&i: &usize| since(i).is_finite() && since(i - 1) < since(i);
        if let Some(frame) = (1..self.times.len()).find(|i| !increasing(i)) {
            return Err(PageError::Times { scene: scene(), frame, time: self.times[frame] });
        }
        for (body, path) in self.positions.iter().enumerate() {
            if path.len() != self.times.len() {
                let (positions, times) = (path.len(), self.times.len());
                return Err(PageError::Length { scene: scene(), body, positions, times });
            }
            let finite = |point: &[f64; 3]| point.iter().all(|&x| (x as f32).is_finite());
            if let Some(frame) = path.iter().position(|point| !finite(point)) {
                return Err(PageError::NotFinite { scene: scene(), body, frame, position: path[frame] });
            }
        }
        let points = self.positions.len() * self.times.len();
        if points > MAX_POINTS {
            return Err(PageError::TooMany { scene: scene(), points });
        }
        self.check_bodies()?;
        self.check_shapes()
    }

    /// A time as the page holds it: f32, and from the first time on, since late in a run f32 would tell few apart.
    pub(super) fn since_first(&self, time: f64) -> f32 {
        (time - self.times[0]) as f32
    }

    /// Numbers of bodies, of vertices and in charts.
    fn check_bodies(&self) -> Result<(), PageError> {
        let bodies = self.positions.len();
        if let Some(sizes) = &self.sizes {
            self.series("sizes", sizes, sizes.len() == 1)?;
            self.numbers("size", sizes.iter().flatten(), true)?;
        }
        if let Some((label, tints)) = &self.tints {
            self.series(label, tints, false)?;
            self.numbers(label, tints.iter().flatten(), false)?;
        }
        self.count("names", self.names.len().min(bodies), self.names.len(), ["body", "bodies"])?;
        if let Some((label, heat)) = &self.heat {
            let vertices = self.surfaces.iter().map(|(_, mesh)| mesh.vertices.len()).sum();
            self.count(label, vertices, heat.len(), ["vertex", "vertices"])?;
            self.numbers(label, heat, false)?;
        }
        for Strip { title, curves } in &self.charts {
            for (label, values) in curves {
                let name = if label.is_empty() { title } else { label };
                self.count(name, self.times.len(), values.len(), ["time", "times"])?;
                self.numbers(name, values, false)?;
            }
        }
        Ok(())
    }

    /// As many lists as bodies, or one for all, of one number or as many as times.
    fn series(&self, what: &str, lists: &[Vec<f64>], one: bool) -> Result<(), PageError> {
        if !one {
            self.count(what, self.positions.len(), lists.len(), ["body", "bodies"])?;
        }
        let odd = lists.iter().find(|list| list.len() != 1 && list.len() != self.times.len());
        odd.map_or(Ok(()), |odd| self.count(what, self.times.len(), odd.len(), TIMES))
    }

    pub(super) fn count(
        &self,
        what: &str,
        wanted: usize,
        found: usize,
        of: [&str; 2],
    ) -> Result<(), PageError> {
        let (scene, what, of) = (self.title.clone(), what.to_string(), of[usize::from(wanted != 1)]);
        let error = || PageError::Count { scene, what, found, wanted: format!("{wanted} {of}") };
        if found == wanted { Ok(()) } else { Err(error()) }
    }

    /// Numbers that the page holds as f32; lengths are positive.
    pub(super) fn numbers<'a>(
        &self,
        what: &str,
        values: impl IntoIterator<Item = &'a f64>,
        length: bool,
    ) -> Result<(), PageError> {
        let odd = |value: &&f64| !(**value as f32).is_finite() || (length && **value as f32 <= 0.0);
        let error = |&value| PageError::Number { scene: self.title.clone(), what: what.into(), value };
        values.into_iter().find(odd).map_or(Ok(()), |value| Err(error(value)))
    }
}
