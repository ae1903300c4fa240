//! One HTML file without a network: scenes with a surface and particles that leave fading trails.
//!
//! ```text
//! page.html  ◀── page.css, three.min.js (made by bundle.sh), page.js
//!            ◀── data: JSON; numbers as base64, little-endian: times f32, points u16 of a cube, normals i16
//! ```
//!
//! A point is rounded to 1/65535 of the scene's cube, a thirtieth of a pixel; the page has half the size of one with f32.

use super::mesh::Mesh;
use crate::Trajectory;
use base64::prelude::{BASE64_STANDARD, Engine};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::{fs, io};

/// Positions of all particles of a scene that a page takes; every WebGL 2 has a texture that holds them.
const MAX_POINTS: usize = 2048 * 2048;

/// A page with scenes to switch between.
#[derive(Clone, Debug)]
pub struct Page {
    title: String,
    scenes: Vec<Scene3>,
}

impl Page {
    /// A page without scenes.
    ///
    /// ```
    /// use rattle::view::{Page, PageError};
    /// assert!(matches!(Page::new("Empty").to_html(), Err(PageError::NoScene)));
    /// ```
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), scenes: Vec::new() }
    }

    /// Adds a scene; with two or more the page has a switch. Scenes on the same mesh share its data.
    ///
    /// ```
    /// use rattle::view::{Page, Scene3};
    /// let scene = |title| Scene3::new(title).particles(&[0.0, 1.0], &[[[0.0; 3], [1.0; 3]]]);
    /// let html = Page::new("Two scenes").scene(scene("slow")).scene(scene("fast")).to_html()?;
    /// assert!(html.contains("slow") && html.contains("fast"));
    /// # Ok::<(), rattle::view::PageError>(())
    /// ```
    pub fn scene(mut self, scene: Scene3) -> Self {
        self.scenes.push(scene);
        self
    }

    /// The page as text.
    ///
    /// # Errors
    /// [`PageError::NoScene`], and for a scene [`PageError::NoMotion`], [`PageError::Times`], [`PageError::Length`],
    /// [`PageError::NotFinite`] and [`PageError::TooMany`].
    ///
    /// ```
    /// use rattle::view::{Page, PageError, Scene3};
    /// let scene = Scene3::new("flight").particles(&[0.0, 1.0], &[[[0.0; 3], [f64::NAN; 3]]]);
    /// let error = Page::new("Flight").scene(scene).to_html().unwrap_err();
    /// assert!(matches!(error, PageError::NotFinite { particle: 0, frame: 1, .. }));
    /// ```
    pub fn to_html(&self) -> Result<String, PageError> {
        if self.scenes.is_empty() {
            return Err(PageError::NoScene);
        }
        let mut meshes: Vec<&Mesh> = Vec::new();
        let mut scenes = Vec::new();
        for scene in &self.scenes {
            scene.check()?;
            let mesh = scene.surface.as_ref().map(|surface| {
                meshes.iter().position(|known| *known == surface).unwrap_or_else(|| {
                    meshes.push(surface);
                    meshes.len() - 1
                })
            });
            scenes.push(scene.json(mesh));
        }
        let meshes: Vec<Value> = meshes.into_iter().map(mesh_json).collect();
        let data = json!({ "meshes": meshes, "scenes": scenes }).to_string();
        Ok(fill(include_str!("page.html"), |name| match name {
            "title" => escape(&self.title),
            "style" => include_str!("page.css").into(),
            "three" => include_str!("three.min.js").into(),
            "script" => include_str!("page.js").into(),
            "data" => data.replace('<', "\\u003c"), // no `</script>` in a title ends the data
            _ => unreachable!("page.html names only the above"),
        }))
    }

    /// Writes the page, and makes its folder where that is missing.
    ///
    /// # Errors
    /// Those of [`to_html`](Page::to_html), and [`PageError::Io`].
    ///
    /// ```
    /// use rattle::view::{Page, Scene3};
    /// # let folder = tempfile::tempdir()?;
    /// let scene = Scene3::new("flight").particles(&[0.0, 1.0], &[[[0.0; 3], [1.0; 3]]]);
    /// Page::new("Flight").scene(scene).write(folder.path().join("out/flight.html"))?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), PageError> {
        let path = path.as_ref();
        let html = self.to_html()?;
        let written = path.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| fs::write(path, html));
        written.map_err(|source| PageError::Io { path: path.into(), source })
    }
}

/// A scene of a [`Page`]: particles, and the surface they move on if there is one.
#[derive(Clone, Debug)]
pub struct Scene3 {
    title: String,
    caption: String,
    surface: Option<Mesh>,
    times: Vec<f64>,
    positions: Vec<Vec<[f64; 3]>>,
    trail: usize,
    seconds: f64,
}

impl Scene3 {
    /// A scene that still lacks its particles.
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
            surface: None,
            times: Vec::new(),
            positions: Vec::new(),
            trail: 100,
            seconds: 30.0,
        }
    }

    /// The surface, drawn softly lit; trails behind it shine through faintly.
    ///
    /// ```
    /// use rattle::view::{Mesh, Page, Scene3};
    /// let sphere = |[x, y, z]: [f64; 3]| (x * x + y * y + z * z - 1.0, [2.0 * x, 2.0 * y, 2.0 * z]);
    /// let mesh = Mesh::of(sphere, [-1.2; 3], [1.2; 3], 12)?;
    /// let scene = Scene3::new("at the pole").surface(&mesh).particles(&[0.0, 1.0], &[[[0.0, 0.0, 1.0]; 2]]);
    /// assert!(Page::new("Rest").scene(scene).to_html().is_ok());
    /// # Ok::<(), rattle::view::MeshError>(())
    /// ```
    pub fn surface(mut self, mesh: &Mesh) -> Self {
        self.surface = Some(mesh.clone());
        self
    }

    /// The motion: increasing times, and for each particle its position at each of them (arrays or nalgebra's
    /// vectors). Particles get colours around the hue circle in their order.
    ///
    /// ```
    /// use nalgebra::{Vector3, vector};
    /// let path: Vec<Vector3<f64>> = vec![vector![0.0, 0.0, 0.0], vector![1.0, 0.0, 0.0]];
    /// let scene = rattle::view::Scene3::new("flight").particles(&[0.0, 1.0], &[path]);
    /// assert!(rattle::view::Page::new("Flight").scene(scene).to_html().is_ok());
    /// ```
    pub fn particles<P, Q>(mut self, times: &[f64], positions: &[P]) -> Self
    where
        P: AsRef<[Q]>,
        Q: Copy + Into<[f64; 3]>,
    {
        self.times = times.to_vec();
        self.positions =
            positions.iter().map(|path| path.as_ref().iter().map(|&point| point.into()).collect()).collect();
        self
    }

    /// The bodies of a trajectory, after those there are: a run of many bodies, or several runs with the same times. Those in
    /// the plane move at z = 0.
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
    /// # Panics
    /// If bodies have other than two or three coordinates.
    #[track_caller]
    pub fn trajectory(mut self, trajectory: &Trajectory) -> Self {
        let [_, bodies, coordinates] = trajectory.shape();
        assert!(
            bodies == 0 || matches!(coordinates, 2 | 3),
            "a page shows two or three coordinates, not {coordinates}"
        );
        if self.times.is_empty() {
            self.times = trajectory.times().to_vec();
        }
        let place = |q: &[f64]| [q[0], q[1], q.get(2).copied().unwrap_or(0.0)];
        let path = |body| trajectory.path(body).map(place).collect();
        self.positions.extend((0..bodies).map(path));
        self
    }

    /// Length of the trails in samples, at most the whole motion; 100 unless told.
    ///
    /// ```
    /// let times: Vec<f64> = (0..60).map(f64::from).collect();
    /// let path: Vec<[f64; 3]> = times.iter().map(|&t| [t, 0.0, 0.0]).collect();
    /// let scene = rattle::view::Scene3::new("flight").particles(&times, &[path]).trail(25);
    /// assert!(rattle::view::Page::new("Flight").scene(scene).to_html()?.contains(r#""trail":25"#));
    /// # Ok::<(), rattle::view::PageError>(())
    /// ```
    pub fn trail(mut self, samples: usize) -> Self {
        self.trail = samples.max(1);
        self
    }

    /// How many seconds the whole motion takes on the page at speed 1; 30 unless told.
    ///
    /// ```
    /// let scene = rattle::view::Scene3::new("flight").particles(&[0.0, 1.0], &[[[0.0; 3], [1.0; 3]]]).seconds(10.0);
    /// assert!(rattle::view::Page::new("Flight").scene(scene).to_html()?.contains(r#""seconds":10.0"#));
    /// # Ok::<(), rattle::view::PageError>(())
    /// ```
    ///
    /// # Panics
    /// When `seconds` is not a positive number.
    #[track_caller]
    pub fn seconds(mut self, seconds: f64) -> Self {
        assert!(seconds.is_finite() && seconds > 0.0, "a motion takes a positive time, not {seconds} s");
        self.seconds = seconds;
        self
    }

    /// A sentence or two under the title.
    ///
    /// ```
    /// let scene = rattle::view::Scene3::new("flight").particles(&[0.0, 1.0], &[[[0.0; 3], [1.0; 3]]]);
    /// let html = rattle::view::Page::new("Flight").scene(scene.caption("Straight on.")).to_html()?;
    /// assert!(html.contains("Straight on."));
    /// # Ok::<(), rattle::view::PageError>(())
    /// ```
    pub fn caption(mut self, caption: impl Into<String>) -> Self {
        self.caption = caption.into();
        self
    }

    fn check(&self) -> Result<(), PageError> {
        let scene = || self.title.clone();
        if self.positions.is_empty() || self.times.len() < 2 {
            return Err(PageError::NoMotion { scene: scene() });
        }
        // The page holds times as f32, and divides by their differences.
        let single = |i: usize| self.times[i] as f32;
        let increasing =
            |&i: &usize| single(i - 1).is_finite() && single(i).is_finite() && single(i - 1) < single(i);
        if let Some(frame) = (1..self.times.len()).find(|i| !increasing(i)) {
            return Err(PageError::Times { scene: scene(), frame, time: self.times[frame] });
        }
        for (particle, path) in self.positions.iter().enumerate() {
            if path.len() != self.times.len() {
                let (positions, times) = (path.len(), self.times.len());
                return Err(PageError::Length { scene: scene(), particle, positions, times });
            }
            let finite = |point: &[f64; 3]| point.iter().all(|&x| (x as f32).is_finite());
            if let Some(frame) = path.iter().position(|point| !finite(point)) {
                return Err(PageError::NotFinite { scene: scene(), particle, frame, position: path[frame] });
            }
        }
        let points = self.positions.len() * self.times.len();
        if points > MAX_POINTS {
            return Err(PageError::TooMany { scene: scene(), points });
        }
        Ok(())
    }

    fn json(&self, mesh: Option<usize>) -> Value {
        json!({
            "title": self.title,
            "caption": self.caption,
            "mesh": mesh,
            "trail": self.trail.min(self.times.len()),
            "seconds": self.seconds,
            "particles": self.positions.len(),
            "times": base64(self.times.iter().flat_map(|&time| (time as f32).to_le_bytes())),
            "positions": points_json(self.positions.iter().flatten()),
        })
    }
}

/// A closed mesh is turned outwards, so that the page needs to draw front faces only: where a back face peeps out at
/// the outline, its light would fray the edge.
fn mesh_json(mesh: &Mesh) -> Value {
    let closed = mesh.is_closed();
    let inverted = closed && mesh.volume() < 0.0;
    let sign = if inverted { -1.0 } else { 1.0 };
    let wide = mesh.vertices.len() > usize::from(u16::MAX);
    let indices = mesh.triangles.iter().flat_map(|&[a, b, c]| if inverted { [a, c, b] } else { [a, b, c] });
    let normal = |&component: &f64| ((sign * component * f64::from(i16::MAX)).round() as i16).to_le_bytes();
    json!({
        "closed": closed,
        "vertices": points_json(mesh.vertices.iter()),
        "normals": base64(mesh.normals.iter().flatten().flat_map(normal)),
        "wide": wide,
        "triangles": if wide {
            base64(indices.flat_map(u32::to_le_bytes))
        } else {
            base64(indices.flat_map(|i| (i as u16).to_le_bytes()))
        },
    })
}

/// Points as 16-bit fractions of the cube around them.
fn points_json<'a>(points: impl Iterator<Item = &'a [f64; 3]> + Clone) -> Value {
    let bound =
        |i: usize, pick: fn(f64, f64) -> f64| points.clone().map(|p| p[i]).reduce(pick).unwrap_or(0.0);
    let corner = [0, 1, 2].map(|i| bound(i, f64::min));
    let size = (0..3).map(|i| bound(i, f64::max) - corner[i]).fold(f64::MIN_POSITIVE, f64::max);
    let fraction = |i: usize, x: f64| ((x - corner[i]) / size * f64::from(u16::MAX)).round() as u16;
    let bytes = points.clone().flat_map(|p| [0, 1, 2].map(|i| fraction(i, p[i]).to_le_bytes())).flatten();
    json!({ "corner": corner, "size": size, "points": base64(bytes) })
}

fn base64(bytes: impl IntoIterator<Item = u8>) -> String {
    BASE64_STANDARD.encode(bytes.into_iter().collect::<Vec<u8>>())
}

/// Replaces each `{{name}}` once; what is put in is not looked at again.
fn fill(template: &str, value: impl Fn(&str) -> String) -> String {
    let mut parts = template.split("{{");
    let mut html = parts.next().unwrap_or_default().to_string();
    for part in parts {
        let (name, rest) = part.split_once("}}").expect("page.html closes its braces");
        html += &value(name);
        html += rest;
    }
    html
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// What can go wrong with a page.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PageError {
    /// The page has no scene.
    #[error("the page has no scene")]
    NoScene,
    /// A scene has no particle, or less than two times.
    #[error("scene `{scene}`: nothing moves; give at least one particle and two times")]
    NoMotion {
        /// The scene.
        scene: String,
    },
    /// Times must be finite and increase, also as f32.
    #[error("scene `{scene}`: time {frame} is {time}, which does not follow the one before")]
    Times {
        /// The scene.
        scene: String,
        /// The time's number.
        frame: usize,
        /// The time.
        time: f64,
    },
    /// A particle has not as many positions as there are times.
    #[error("scene `{scene}`: particle {particle} has {positions} positions for {times} times")]
    Length {
        /// The scene.
        scene: String,
        /// The particle.
        particle: usize,
        /// Its positions.
        positions: usize,
        /// The times.
        times: usize,
    },
    /// A position is NaN, infinite or beyond f32.
    #[error("scene `{scene}`: particle {particle} is at {position:?} at time {frame}")]
    NotFinite {
        /// The scene.
        scene: String,
        /// The particle.
        particle: usize,
        /// The time's number.
        frame: usize,
        /// The position.
        position: [f64; 3],
    },
    /// More positions than every graphics processor can hold.
    #[error("scene `{scene}`: {points} positions, at most {MAX_POINTS}; take every second or tenth time")]
    TooMany {
        /// The scene.
        scene: String,
        /// Particles × times.
        points: usize,
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
