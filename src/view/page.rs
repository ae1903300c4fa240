//! One HTML file that needs no network: scenes to switch between, and the program that shows them.
//!
//! ```text
//! page.html  ◀── page.css, three.min.js (made by bundle.sh), the page's own script (the files of page/)
//!            ◀── data: JSON, as `encode.rs` writes it
//! ```

use super::encode::{mesh_json, scene_json};
use super::error::PageError;
use super::mesh::Mesh;
use super::scene::Scene3;
use crate::files;
use crate::xml::escaped;
use serde_json::{Value, json};
use std::io::Write as _;
use std::path::Path;

/// The page's own script, one module in parts.
const SCRIPT: &str = concat!(
    include_str!("page/data.js"),
    include_str!("page/bodies.js"),
    include_str!("page/motion.js"),
    include_str!("page/notes.js"),
    include_str!("page/charts.js"),
    include_str!("page/export.js"),
    include_str!("page/stage.js"),
);

/// A page with scenes to switch between.
#[doc(alias = "html")]
#[doc(alias = "animation")]
#[doc(alias = "viewer")]
#[doc(alias = "movie")]
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

    /// Adds a scene; with two or more, the page has a menu. Scenes on the same mesh share its data.
    ///
    /// ```
    /// use rattle::view::{Page, Scene3};
    /// let scene = |title| Scene3::new(title).bodies(&[0.0, 1.0], &[[[0.0; 3], [1.0; 3]]]);
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
    /// [`PageError::NoScene`], and for a scene [`PageError::NoMotion`], [`PageError::Times`],
    /// [`PageError::OtherTimes`], [`PageError::Length`], [`PageError::NotFinite`], [`PageError::TooMany`],
    /// [`PageError::NoBody`], [`PageError::Count`], [`PageError::Dimension`], [`PageError::Number`] and
    /// [`PageError::Attitude`].
    ///
    /// ```
    /// use rattle::view::{Page, PageError, Scene3};
    /// let scene = Scene3::new("flight").bodies(&[0.0, 1.0], &[[[0.0; 3], [f64::NAN; 3]]]);
    /// let error = Page::new("Flight").scene(scene).to_html().unwrap_err();
    /// assert!(matches!(error, PageError::NotFinite { body: 0, frame: 1, .. }));
    /// ```
    pub fn to_html(&self) -> Result<String, PageError> {
        if self.scenes.is_empty() {
            return Err(PageError::NoScene);
        }
        let mut meshes: Vec<&Mesh> = Vec::new();
        let mut scenes = Vec::new();
        for scene in &self.scenes {
            scene.check()?;
            let number = |surface| {
                meshes.iter().position(|known| *known == surface).unwrap_or_else(|| {
                    meshes.push(surface);
                    meshes.len() - 1
                })
            };
            let numbers: Vec<usize> = scene.surfaces.iter().map(|(_, surface)| surface).map(number).collect();
            scenes.push(scene_json(scene, &numbers));
        }
        let meshes: Vec<Value> = meshes.into_iter().map(mesh_json).collect();
        let data = json!({ "meshes": meshes, "scenes": scenes }).to_string();
        Ok(fill(include_str!("page.html"), |name| match name {
            "title" => escaped(&self.title),
            "style" => include_str!("page.css").into(),
            "three" => include_str!("three.min.js").into(),
            "script" => SCRIPT.into(),
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
    /// let scene = Scene3::new("flight").bodies(&[0.0, 1.0], &[[[0.0; 3], [1.0; 3]]]);
    /// Page::new("Flight").scene(scene).write(folder.path().join("out/flight.html"))?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), PageError> {
        let path = path.as_ref();
        let html = self.to_html()?;
        let written = files::create(path).and_then(|mut file| file.write_all(html.as_bytes()));
        written.map_err(|source| PageError::Io { path: path.into(), source })
    }
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
