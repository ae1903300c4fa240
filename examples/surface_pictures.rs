//! The pictures in the documentation of `rattle::surfaces`: each surface with geodesics on it.
//!
//! ```text
//! cargo run --release --example surface_pictures          needs Chromium
//! ```
//!
//! Writes `src/surfaces/<name>.html`, which the documentation includes: an `img` with the picture inside.

#[path = "../tests/browser/mod.rs"]
#[allow(dead_code, reason = "the test of the page uses the rest")]
mod browser;

use rattle::kernel::Constraint;
use rattle::nalgebra::Vector3;
use rattle::prelude::*;
use rattle::surfaces::*;
use rattle::view::{Mesh, Page, Scene3};
use std::error::Error;
use std::fs;
use std::path::Path;

const GEODESICS: u32 = 16;

fn main() -> Result<(), Box<dyn Error>> {
    let chromium = browser::find().ok_or("no Chromium; set CHROME or put chromium on the path")?;
    let mut artist =
        Artist { browser: browser::Browser::start(&chromium, &[]), folder: tempfile::tempdir()? };
    artist.browser.resize(640, 480, false);
    let golden = (1.0 + 5_f64.sqrt()) / 2.0;
    let pi = std::f64::consts::PI;

    artist.draw("sphere", Sphere { r: 1.0 }, 1.2)?;
    artist.draw("ellipsoid", Ellipsoid { a: 1.5, b: 1.0, c: 0.7 }, 1.6)?;
    artist.draw("cylinder", Cylinder { r: 0.8 }, 1.5)?;
    artist.draw("dented_cylinder", DentedCylinder { r: 0.8, l: 0.8, a: 0.35 }, 1.5)?;
    artist.draw("plane", Plane { a: 0.0, b: 0.3, c: 1.0, d: 0.0 }, 1.2)?;
    artist.draw("wiggly_plane", WigglyPlane { a: 0.3, w: 4.0 }, 1.5)?;
    artist.draw("gaussian_bump", GaussianBump { a: 0.9, l: 0.5, inner: 0.9, outer: 1.4 }, 1.7)?;
    artist.draw("dumbbell", Dumbbell { a: 0.8, k: 1.0, b: 1.0, c: 2.2 }, 2.2)?;
    artist.draw("spine", Spine { a: 0.6, k: 1.1, b: 1.0, b2: 1.4, c: 2.8 }, 2.2)?;
    artist.draw("spine_two", SpineTwo { a: 0.6, k: 1.1, b: 1.0, b2: 1.4, c: 2.8 }, 2.2)?;
    artist.draw("thylakoid", Thylakoid { width: 3.0, length: 10.0, flare: 3.0 }, 32.0)?;
    artist.draw("supersphere", Supersphere { r: 1.0, q: 4.0 }, 1.2)?;
    artist.draw("superellipsoid", Superellipsoid { a: 1.2, b: 1.0, c: 0.8, n: 3.0, m: 2.5 }, 1.4)?;
    artist.draw("torus_by_distance", TorusByDistance { major: 1.0, minor: 0.35 }, 1.5)?;
    artist.draw("torus", Torus { major: 1.0, minor: 0.45 }, 1.6)?;
    artist.draw("gyroid", Gyroid { k: pi, epsilon: 0.0 }, 1.0)?;
    artist.draw("primitive", Primitive { k: pi, epsilon: 0.0 }, 1.0)?;
    artist.draw("diamond", Diamond { k: pi, epsilon: 0.0 }, 1.0)?;
    artist.draw("neovius", Neovius { k: pi }, 1.0)?;
    artist.draw("i_wrapped_package", IWrappedPackage { k: pi }, 1.0)?;
    artist.draw("lidinoid", Lidinoid { k: pi, epsilon: 0.3 }, 1.0)?;
    artist.draw("lemniscate", Lemniscate { a: 1.0, r: 1.0 / 6.0 }, 1.2)?;
    artist.draw("three_foci", ThreeFoci { a: 1.0, c: 1.0, r: 0.4 }, 1.7)?;
    artist.draw("clebsch", Clebsch {}, 2.5)?;
    artist.draw("cayley", Cayley {}, 2.0)?;
    artist.draw("barth_sextic", BarthSextic { w: 1.0 }, golden * 1.2)?;
    artist.draw("kummer", Kummer { mu: 1.25 }, 1.7)?;
    artist.draw("tanglecube", Tanglecube { c: 11.8 }, 2.6)?;
    artist.draw("chmutov", Chmutov {}, 1.1)?;
    artist.draw("decocube", Decocube { b: 0.02, c: 0.95 }, 1.5)?;
    artist.draw("heart", Heart {}, 1.5)?;
    artist.draw("dupin_cyclide", DupinCyclide { a: 1.5, b: 1.4, d: 0.8 }, 2.8)?;
    artist.draw("metaballs", Metaballs { c: 1.0, level: 1.8 }, 2.2)?;
    artist.draw("hyperboloid", Hyperboloid { a: 0.6, c: 0.8 }, 1.4)?;
    artist.draw("paraboloid", Paraboloid { a: 1.0, b: 1.2 }, 1.4)?;
    artist.draw("saddle", Saddle { a: 1.0, b: 1.0 }, 1.2)?;
    artist.draw("monkey_saddle", MonkeySaddle {}, 1.2)?;
    artist.draw("catenoid", Catenoid { a: 0.5 }, 1.4)?;
    artist.draw("helicoid", Helicoid { c: 0.4 }, 1.3)?;
    artist.draw("scherk", Scherk {}, 1.5)?;
    Ok(())
}

struct Artist {
    browser: browser::Browser,
    folder: tempfile::TempDir,
}

impl Artist {
    /// Draws the part of the surface in the cube of this half side.
    fn draw<C: Constraint<3, 1> + Copy>(
        &mut self,
        name: &str,
        surface: C,
        half: f64,
    ) -> Result<(), Box<dyn Error>> {
        let g = |q: [f64; 3]| {
            let (value, gradient) = surface.value_and_jacobian(&q.into());
            let gradient: [f64; 3] = gradient.row(0).transpose().into();
            (value[0], gradient.map(|slope| if slope.is_finite() { slope } else { 0.0 }))
        };
        let scene = Scene::on(surface);
        // Until it leaves the cube or a step fails.
        let geodesic = |start: State<3>| {
            let mut simulation =
                scene.simulate(scene.project(&start).ok()?, Rattle::new(0.004 * half)).ok()?;
            let mut path = vec![simulation.position()];
            while path.len() < 400 && simulation.step().is_ok() && simulation.position().amax() < half {
                path.push(simulation.position());
            }
            Some(path)
        };
        self.picture(name, half, &g, &geodesic)
    }

    fn picture(
        &mut self,
        name: &str,
        half: f64,
        g: &dyn Fn([f64; 3]) -> (f64, [f64; 3]),
        geodesic: &dyn Fn(State<3>) -> Option<Vec<Vector3<f64>>>,
    ) -> Result<(), Box<dyn Error>> {
        // Not centred on the symmetry planes, where some functions have no gradient.
        let (low, high) = ([-half, -1.0003 * half, -0.9997 * half], [half, 0.9997 * half, 1.0003 * half]);
        let mesh = Mesh::of(g, low, high, 90).or_else(|_| Mesh::within(g, low, high, 90))?;
        let paths = geodesics(g, geodesic, &mesh, half);
        let samples = paths.iter().map(Vec::len).max().unwrap_or(0);
        let padded = paths.into_iter().map(|mut path| {
            path.resize(samples, *path.last().unwrap_or(&Vector3::zeros()));
            path
        });
        let padded: Vec<_> = padded.collect();
        let times: Vec<f64> = (0..samples).map(|i| i as f64).collect();
        let file = self.folder.path().join("page.html");
        Page::new(name)
            .scene(Scene3::new(name).surface(&mesh).bodies(&times, &padded).trail(3 * samples))
            .write(&file)?;
        self.browser.open(&file);
        self.browser.wait("window.rattle !== undefined && rattle.frame() > 0");
        let picture = "rattle.pause(), rattle.seek(rattle.frames() - 1), rattle.draw(), \
                       document.getElementById('canvas').toDataURL('image/webp', 0.8)";
        let picture = self.browser.evaluate(picture);
        let picture = picture.as_str().ok_or("the page gave no picture")?;
        let path = Path::new("src/surfaces").join(format!("{name}.html"));
        fs::create_dir_all("src/surfaces")?;
        fs::write(&path, format!("<img alt=\"{name}\" width=\"320\" src=\"{picture}\">\n"))?;
        println!("{name}: {} triangles, {} bytes", mesh.triangles.len(), fs::metadata(&path)?.len());
        Ok(())
    }
}

/// Geodesics from a vertex in the middle of the picture.
fn geodesics(
    g: &dyn Fn([f64; 3]) -> (f64, [f64; 3]),
    geodesic: &dyn Fn(State<3>) -> Option<Vec<Vector3<f64>>>,
    mesh: &Mesh,
    half: f64,
) -> Vec<Vec<Vector3<f64>>> {
    let viewer = Vector3::new(-0.4, -0.75, 0.53).normalize();
    let off_axis = |q: &Vector3<f64>| (q - viewer * q.dot(&viewer)).norm();
    let mut vertices: Vec<Vector3<f64>> = mesh.vertices.iter().map(|&q| q.into()).collect();
    vertices.retain(|q| q.amax() < 0.8 * half);
    // Near the line of sight, and then in front: rank by both.
    let rank = |q: &Vector3<f64>| off_axis(q) - 0.4 * q.dot(&viewer);
    vertices.sort_by(|a, b| rank(a).total_cmp(&rank(b)));
    for &start in vertices.iter().step_by(7) {
        let from_here = |i: u32| {
            let angle = std::f64::consts::TAU * f64::from(i) / f64::from(GEODESICS);
            let normal = Vector3::from(g(start.into()).1).normalize();
            let across = normal.cross(&Vector3::new(0.3, 0.5, 0.8)).normalize();
            let direction = across * angle.cos() + normal.cross(&across) * angle.sin();
            geodesic(State::at(start).moving(direction))
        };
        let paths: Vec<_> = (0..GEODESICS).filter_map(from_here).collect();
        if paths.len() == GEODESICS as usize && paths.iter().all(|path| path.len() > 40) {
            return paths;
        }
    }
    vec![vec![Vector3::from(mesh.vertices[0]); 2]]
}
