//! The gallery of the guide: every surface, pair potential and link with a picture, every example with what it writes.
//!
//! ```text
//! cargo run --release --example gallery             writes docs/gallery/ and docs/guide/gallery.md
//! cargo run --release --example gallery -- pages    also runs every example, minutes, and takes pictures of pages
//! ```
//!
//! Pictures of surfaces are those of the reference, which `surface_pictures` draws. Links are drawn as they move, from
//! the state with rods to where the paths end. Pictures of pages need Chromium.

#[path = "../tests/browser/mod.rs"]
#[allow(dead_code, reason = "the test of the page uses the rest")]
mod browser;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use rattle::kernel::Potential;
use rattle::links::planar::*;
use rattle::nalgebra::SVector;
use rattle::plot::Chart;
use rattle::potentials::planar::{AnisotropicHarmonic, Gravity, Harmonic, Kepler};
use rattle::potentials::{
    Coulomb, Gaussian, HarmonicPair, LennardJones, Morse, Ricker, SoftSphere, Wca, Yukawa,
};
use rattle::prelude::*;
use rattle::system::System;
use serde_json::json;
use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

type Outcome = Result<(), Box<dyn Error>>;

/// Places of a path.
const FRAMES: u32 = 240;

fn main() -> Outcome {
    std::env::set_current_dir(env!("CARGO_MANIFEST_DIR"))?;
    fs::create_dir_all("docs/gallery")?;
    let mut page = String::from(
        "# Gallery\n\nMade by `cargo run --release --example gallery`.\n\n## Surfaces\n\nEach with geodesics from one place; \
         formulas, parameters and costs are on their pages in `rattle::surfaces`.\n\n",
    );
    surfaces(&mut page)?;
    page += "\n## Pair potentials\n\nWith parameters of one; formulas are on their pages in `rattle::potentials`.\n\n\
             ![Pair potentials that attract](../gallery/attracting.svg)\n\n\
             ![Pair potentials that repel](../gallery/repelling.svg)\n";
    potentials()?;
    page += "\n## Potentials of one body\n\nIn the plane (`rattle::potentials::planar`), each with the path of a free \
             body; those in space are alike.\n\n| | |\n|---|---|\n";
    wells(&mut page)?;
    page += "\n## Links\n\nPaths of bodies under gravity, from the state that is drawn with dots; in the plane \
             (`rattle::links::planar`) …\n\n| | |\n|---|---|\n";
    links(&mut page)?;
    page += "\n… and in space (`rattle::links`), seen from aside; those that are not here are as in the plane.\n\n\
             | | |\n|---|---|\n";
    links_in_space(&mut page)?;
    if std::env::args().nth(1).as_deref() == Some("pages") {
        take_pages()?;
    }
    page +=
        "\n## Pages\n\nThey move, turn and zoom in a browser; here is what they show after some seconds.\n\n";
    pages(&mut page)?;
    page += "\n## Examples\n\nEach is `cargo run --release --example NAME`, and writes into `out/`. A page opens in any browser.\n\n\
             | example | shows | writes |\n|---|---|---|\n";
    examples(&mut page)?;
    fs::write("docs/guide/gallery.md", page)?;
    println!("docs/guide/gallery.md, docs/gallery");
    Ok(())
}

/// The pictures in the reference, in the order of their module, four in a row.
fn surfaces(page: &mut String) -> Outcome {
    let source = fs::read_to_string("src/surfaces.rs")?;
    let pictures = source.split("include_str!(\"surfaces/").skip(1).filter_map(|rest| rest.split('.').next());
    let names: Vec<&str> = pictures.collect();
    *page += "| | | | |\n|---|---|---|---|\n";
    for row in names.chunks(4) {
        for name in row {
            let html = fs::read_to_string(format!("src/surfaces/{name}.html"))?;
            let data = html.split("base64,").nth(1).and_then(|rest| rest.split('"').next());
            fs::write(
                format!("docs/gallery/{name}.webp"),
                STANDARD.decode(data.ok_or("no picture inside")?)?,
            )?;
            let words = name.replace('_', " ");
            write!(page, "| ![{words}](../gallery/{name}.webp) {words} ")?;
        }
        *page += "|\n";
    }
    println!("{} surfaces", names.len());
    Ok(())
}

fn potentials() -> Outcome {
    let curve = |u: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        let r = (1..=300).map(|i| 0.01 * f64::from(i));
        r.map(|r| (r, u(r))).filter(|(_, u)| u.abs() <= 2.5).collect()
    };
    let chart = |title: &str| Chart::new(title).x("r").y("U");
    chart("Pair potentials that attract")
        .line("Lennard-Jones", curve(&|r| LennardJones { epsilon: 1.0, sigma: 1.0 }.value(r)))
        .line("Morse", curve(&|r| Morse { depth: 1.0, alpha: 3.0, length: 1.0 }.value(r)))
        .line("Ricker", curve(&|r| Ricker { depth: 1.0, radius: 1.0 }.value(r)))
        .line("harmonic pair", curve(&|r| HarmonicPair { stiffness: 1.0, length: 1.0 }.value(r)))
        .save("docs/gallery/attracting.svg")?;
    chart("Pair potentials that repel")
        .line("Coulomb", curve(&|r| Coulomb { strength: 1.0 }.value(r)))
        .line("Yukawa", curve(&|r| Yukawa { strength: 1.0, kappa: 1.0 }.value(r)))
        .line("WCA", curve(&|r| Wca { epsilon: 1.0, sigma: 1.0 }.value(r)))
        .line("Gaussian", curve(&|r| Gaussian { height: 1.0, width: 1.0 }.value(r)))
        .line("soft sphere", curve(&|r| SoftSphere { stiffness: 2.0, diameter: 1.0 }.value(r)))
        .save("docs/gallery/repelling.svg")?;
    Ok(())
}

/// U in colours, and where a free body goes.
fn well<P>(page: &mut String, name: &str, potential: P, start: State<2>, time: f64) -> Outcome
where
    P: Potential<2> + Copy + Send + Sync + 'static,
{
    let (grid, half) = (40, 1.5);
    let at = |i: usize| half * (2.0 * i as f64 / (grid - 1) as f64 - 1.0);
    let value = |x: f64, y: f64| potential.value(&[x, y].into()).max(-4.0);
    let rows = (0..grid).map(|j| (0..grid).map(|i| value(at(i), at(j))).collect()).collect();
    let mut simulation = Scene::point().with(potential).simulate(start, Lobatto::<5>::new(0.02))?;
    let mut path = Vec::new();
    simulation.run_with((time / 0.02) as u64, |now| path.push((now.position().x, now.position().y)))?;
    let chart = Chart::new(name).x("x").y("y").equal_aspect().map("U", [-half, half], [-half, half], rows);
    save(page, name, &chart.marked("", path.first().copied()).line("", path))
}

fn wells(page: &mut String) -> Outcome {
    let side = |x: f64, y: f64| State::at([x, 0.0]).moving([0.0, y]);
    well(page, "Gravity", Gravity { g: 1.0 }, State::at([-1.4, -0.9]).moving([1.3, 1.9]), 2.1)?;
    let centre = [0.0, 0.0];
    well(page, "Harmonic", Harmonic { stiffness: 1.0, centre }, side(1.2, 0.6), 6.2)?;
    let uneven = AnisotropicHarmonic { stiffness: [1.0, 2.3], centre };
    well(page, "Anisotropic harmonic", uneven, side(1.1, 1.3), 40.0)?;
    well(page, "Kepler", Kepler { mu: 1.0, centre }, side(1.3, 0.55), 6.2)?;
    end_row(page);
    Ok(())
}

/// Saves a chart, and puts it into the table of two columns.
fn save(page: &mut String, name: &str, chart: &Chart) -> Outcome {
    let file = name.to_lowercase().replace(' ', "_");
    chart.save(format!("docs/gallery/{file}.svg"))?;
    let ends = if page.ends_with("|\n") { "|" } else { "" };
    write!(page, "{ends} ![{name}](../gallery/{file}.svg) |")?;
    if ends.is_empty() {
        *page += "\n";
    }
    Ok(())
}

fn end_row(page: &mut String) {
    if !page.ends_with("|\n") {
        *page += " |\n";
    }
}

/// Draws how the bodies of a simulation move for `time`, those of `chains` joined by rods where they start.
fn draw<Y: System<f64, D>, const D: usize>(
    page: &mut String,
    name: &str,
    simulation: Result<Simulation<Y, Rattle, D>, rattle::Error>,
    time: f64,
    chains: &[&[usize]],
) -> Outcome {
    let mut simulation = simulation?;
    // In space from aside, z upwards.
    let seen = |q: SVector<f64, D>| {
        if D == 3 { (q[0] + 0.45 * q[1], q[2] + 0.3 * q[1]) } else { (q[0], q[1]) }
    };
    let places = |now: &Simulation<Y, Rattle, D>| -> Vec<(f64, f64)> { now.positions().map(seen).collect() };
    let start = places(&simulation);
    let mut paths = vec![Vec::new(); start.len()];
    for frame in 0..=FRAMES {
        paths.iter_mut().zip(places(&simulation)).for_each(|(path, q)| path.push(q));
        simulation.run_until(time * f64::from(frame + 1) / f64::from(FRAMES))?;
    }
    let far = simulation.constraint_residual();
    assert!(far < 1e-13, "{name}: {far:e} off");
    let axes = if D == 3 { ["x + 0.45 y", "z + 0.3 y"] } else { ["x", "y"] };
    let mut chart = Chart::new(name).x(axes[0]).y(axes[1]).equal_aspect();
    for chain in chains {
        chart = chart.marked("", chain.iter().map(|&i| start[i]));
    }
    for path in paths {
        chart = chart.line("", path);
    }
    save(page, name, &chart)
}

fn links_in_space(page: &mut String) -> Outcome {
    use rattle::links::{Angle, Pendulum, Rod, Slider, Torsion};
    let heavy = rattle::potentials::Gravity { g: 1.0 };
    let method = Rattle::new(0.01);
    let bob = Scene::on(Pendulum { length: 1.0, pivot: [0.0; 3] }).with(heavy);
    let start = State::at([0.8, 0.0, -0.6]).moving([0.0, 0.5, 0.0]);
    draw(page, "Spherical pendulum", bob.simulate(start, method), 12.0, &[&[0]])?;

    let rod = Rod { length: 1.0 };
    let zigzag = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.6, 1.0, -0.8]];
    let hung = |n| Scene::points::<3>(n).pin(0, [0.0; 3]).with(heavy);
    let scene = hung(3).link(rod, [[0, 1], [1, 2]]);
    let start = State::of(zigzag[..3].to_vec());
    draw(page, "Rods in space", scene.simulate(start.clone(), method), 2.5, &[&[0, 1, 2]])?;

    let right = Angle { angle: std::f64::consts::FRAC_PI_2 };
    let bent = |sign: f64| {
        let mut places = zigzag[..3].to_vec();
        places[2][1] *= sign;
        hung(3).link(rod, [[0, 1], [1, 2]]).link(right, [[0, 1, 2]]).simulate(State::of(places), method)
    };
    draw(page, "Angle in space", bent(1.0).or_else(|_| bent(-1.0)), 3.0, &[&[0, 1, 2]])?;

    // Four bodies of a molecule, twisted by a right angle that stays.
    let twisted = |angle: f64| {
        let rods = hung(4).link(rod, [[0, 1], [1, 2], [2, 3]]).link(Torsion { angle }, [[0, 1, 2, 3]]);
        let start = rods.project(&State::of([zigzag[0], zigzag[1], zigzag[2], [1.0, 1.0, -1.0]]))?;
        rods.simulate(start, method)
    };
    let quarter = std::f64::consts::FRAC_PI_2;
    draw(page, "Torsion", twisted(quarter).or_else(|_| twisted(-quarter)), 1.4, &[&[0, 1, 2, 3]])?;

    let guide = Slider { point: [0.0; 3], direction: [1.0, 0.0, 0.0] };
    let scene = Scene::points::<3>(2).link(guide, [[0]]).link(rod, [[0, 1]]).with(heavy);
    let start = State::of([[0.0; 3], [0.0, 0.8, -0.6]]).with_momenta([[0.3, 0.0, 0.0], [0.3, 0.0, 0.0]]);
    draw(page, "Slider in space", scene.simulate(start, method), 6.0, &[&[0, 1]])?;
    end_row(page);
    Ok(())
}

/// The names of all examples.
fn names() -> Result<Vec<String>, Box<dyn Error>> {
    let mut names = Vec::new();
    for entry in fs::read_dir("examples")? {
        names.push(entry?.path().file_stem().unwrap_or_default().to_string_lossy().into_owned());
    }
    names.sort();
    Ok(names)
}

/// Runs the examples, and takes a picture of each page that one writes.
fn take_pages() -> Outcome {
    let chromium = browser::find().ok_or("no Chromium; set CHROME or put chromium on the path")?;
    let folder = std::env::current_dir()?;
    fs::create_dir_all("docs/gallery/pages")?;
    for name in names()?.iter().filter(|name| !["gallery", "surface_pictures"].contains(&name.as_str())) {
        println!("{name}");
        let ended = Command::new(env!("CARGO"))
            .args(["run", "--quiet", "--release", "--example", name])
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .status()?;
        if !ended.success() {
            return Err(format!("the example {name} ended with {ended}").into());
        }
        let written = [name.clone(), format!("{name}_conservative")];
        let written = written.iter().flat_map(|name| {
            [folder.join(format!("out/{name}/index.html")), folder.join(format!("out/{name}.html"))]
        });
        let Some(file) = written.into_iter().find(|file| file.exists()) else { continue };
        let mut browser = browser::Browser::start(&chromium, &[]);
        browser.resize(900, 600, false);
        browser.open(&file);
        std::thread::sleep(Duration::from_secs(4));
        let answer = browser.call("Page.captureScreenshot", json!({ "format": "webp", "quality": 75 }));
        let picture = STANDARD.decode(answer["data"].as_str().ok_or("no picture")?)?;
        fs::write(format!("docs/gallery/pages/{name}.webp"), picture)?;
    }
    Ok(())
}

/// The pictures of pages that there are, two in a row.
fn pages(page: &mut String) -> Outcome {
    let has = |name: &String| Path::new(&format!("docs/gallery/pages/{name}.webp")).exists();
    let names: Vec<_> = names()?.into_iter().filter(has).collect();
    *page += "| | |\n|---|---|\n";
    for pair in names.chunks(2) {
        for name in pair {
            write!(page, "| ![{name}](../gallery/pages/{name}.webp) `{name}` ")?;
        }
        *page += if pair.len() == 2 { "|\n" } else { "| |\n" };
    }
    Ok(())
}

fn links(page: &mut String) -> Outcome {
    let heavy = Gravity { g: 1.0 };
    let method = Rattle::new(0.01);
    let rod = Rod { length: 1.0 };
    let hung = |n| Scene::points::<2>(n).pin(0, [0.0, 0.0]);

    let scene = hung(3).link(rod, [[0, 1], [1, 2]]).with(heavy);
    let start = State::of([[0.0, 0.0], [1.0, 0.0], [1.6, 0.8]]);
    draw(page, "Rod", scene.simulate(scene.project(&start)?, method), 2.5, &[&[0, 1, 2]])?;

    let pendulum = Pendulum { length: 1.0, pivot: [0.0, 0.0] };
    let scene = Scene::on(pendulum).with(heavy);
    draw(page, "Pendulum", scene.simulate(State::at([0.8, 0.6]), method), 3.5, &[&[0]])?;

    // Two rods, each with ends of its own, joined by a hinge.
    let scene = hung(4).link(rod, [[0, 1], [2, 3]]).link(Coincident {}, [[1, 2]]).with(heavy);
    let start = State::of([[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
    draw(page, "Coincident", scene.simulate(start, method), 2.5, &[&[0, 1], &[2, 3]])?;

    let scene = hung(3).link(rod, [[0, 1]]).link(Between { fraction: 0.5 }, [[0, 1, 2]]).with(heavy);
    let start = State::of([[0.0, 0.0], [1.0, 0.0], [0.5, 0.0]]);
    draw(page, "Between", scene.simulate(start, method), 3.0, &[&[0, 2, 1]])?;

    // Three bodies stay on one line, the outer ones at any distance.
    let scene = Scene::points::<2>(3).link(rod, [[0, 1]]).link(Collinear {}, [[0, 1, 2]]).with(heavy);
    let start =
        State::of([[0.0, 0.0], [1.0, 0.0], [1.5, 0.0]]).with_momenta([[0.0, 0.5], [0.0, 1.0], [0.4, 1.25]]);
    draw(page, "Collinear", scene.simulate(scene.project(&start)?, method), 2.0, &[&[0, 1, 2]])?;

    let right = Angle { angle: std::f64::consts::FRAC_PI_2 };
    let scene = hung(3).link(rod, [[0, 1], [1, 2]]).link(right, [[0, 1, 2]]).with(heavy);
    // The sign of a right angle is the order of its bodies: one of the two sides is right.
    let angled = |y: f64| scene.simulate(State::of([[0.0, 0.0], [1.0, 0.0], [1.0, y]]), method);
    draw(page, "Angle", angled(1.0).or_else(|_| angled(-1.0)), 3.0, &[&[0, 1, 2]])?;

    // A rod between two guides.
    let guide = |direction| Slider { point: [0.0, 0.0], direction };
    let scene = Scene::points::<2>(2)
        .link(rod, [[0, 1]])
        .link(guide([1.0, 0.0]), [[0]])
        .link(guide([0.0, 1.0]), [[1]])
        .with(heavy);
    draw(
        page,
        "Slider",
        scene.simulate(State::of([[0.6, 0.0], [0.0, 0.8]]), Rattle::new(0.005)),
        2.0,
        &[&[0, 1]],
    )?;

    let crank = Crank { centre: [0.0, 0.0], radius: 0.5, omega: 2.0, phase: 0.0 };
    let scene =
        Scene::points::<2>(2).link_moving(crank, [[0]]).link(Rod { length: 1.0 }, [[0, 1]]).with(heavy);
    let start = State::of([[0.5, 0.0], [0.5, -1.0]]).with_momenta([[0.0, 1.0], [0.0, 1.0]]);
    draw(page, "Crank", scene.simulate(scene.project(&start)?, method), 3.0, &[&[0, 1]])?;

    let scene = Scene::points::<2>(1).link_moving(TurningLine { omega: 1.0 }, [[0]]);
    let start = State::at([0.3, 0.0]).moving([0.0, 0.3]);
    draw(page, "Turning line", scene.simulate(start, method), 2.5, &[&[0]])?;
    end_row(page);
    Ok(())
}

/// A name as a program formats it, with `*` for what it puts in.
fn formatted(word: &str) -> String {
    let mut parts = word.split('{');
    let first = parts.next().unwrap_or_default().to_string();
    parts.fold(first, |name, part| name + "*" + part.split_once('}').map_or("", |(_, after)| after))
}

/// Whether one name holds all that another says: a file in that folder, or a pattern that the other file is one of.
fn says_more(one: &str, other: &str) -> bool {
    let is_between = |(before, after)| {
        let name = other.strip_prefix(before).and_then(|rest: &str| rest.strip_suffix(after));
        one != other && name.is_some_and(|name: &str| !name.contains('/'))
    };
    one.starts_with(&format!("{other}/")) || one.split_once('*').is_some_and(is_between)
}

/// Every example by the first line of its documentation and the files that it names.
fn examples(page: &mut String) -> Outcome {
    let mut files: Vec<_> =
        fs::read_dir("examples")?.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>()?;
    files.sort();
    for path in files {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let folder = path.is_dir();
        let source = fs::read_to_string(if folder { path.join("main.rs") } else { path })?;
        let about: Vec<&str> = source
            .lines()
            .map_while(|line| line.strip_prefix("//!"))
            .map(str::trim)
            .take_while(|line| !line.is_empty())
            .collect();
        let mut written: Vec<String> = source
            .split(|c: char| c.is_whitespace() || "\"`;".contains(c))
            .filter(|word| word.starts_with("out/") && word.len() > 4)
            .map(|word| formatted(word.trim_end_matches([',', '.', ':', '/'])))
            .filter(|word| !word.starts_with("out/*"))
            .collect();
        written.sort_unstable();
        written.dedup();
        let all = written.clone();
        written.retain(|word| !all.iter().any(|other| says_more(other, word)));
        let written = written.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ");
        writeln!(page, "| `{name}` | {} | {written} |", about.join(" "))?;
    }
    Ok(())
}
