//! What is written into the 3-D page, and scenes that cannot be drawn.

use crate::page::{ball, billiards, flight};
use base64::prelude::{BASE64_STANDARD, Engine};
use rattle::view::{Page, PageError, Scene3};
use serde_json::json;
use std::fs;

/// The page's data.
fn written(scene: Scene3) -> serde_json::Value {
    let html = Page::new("Page").scene(scene).to_html().unwrap();
    let data = html.split(r#"<script type="application/json" id="data">"#).nth(1).unwrap();
    serde_json::from_str(data.split("</script>").next().unwrap()).unwrap()
}

/// From the first time on, as the page has them.
fn times_of(data: &serde_json::Value) -> Vec<f64> {
    let bytes = BASE64_STANDARD.decode(data["scenes"][0]["times"].as_str().unwrap()).unwrap();
    bytes.as_chunks().0.iter().map(|&four| f64::from(f32::from_le_bytes(four))).collect()
}

/// Surfaces that begin at the times of the motion are shown from there on: both are rounded to f32.
#[test]
fn surfaces_begin_at_their_times() {
    for from in [0.0, 1e6] {
        let times: Vec<f64> = (0..10).map(|k| from + 0.1 * f64::from(k)).collect();
        let surfaces: Vec<_> = times.iter().map(|&t| (t, ball(0.5 + (t - from) / 2.0))).collect();
        let data = written(Scene3::new("balloon").times(&times).moving_surface(&surfaces));
        let starts: Vec<f64> = serde_json::from_value(data["scenes"][0]["starts"].clone()).unwrap();
        for (frame, time) in times_of(&data).into_iter().enumerate() {
            assert_eq!(starts.iter().rposition(|start| *start <= time), Some(frame), "at {from} + {time}");
        }
    }
    let times = [0.0, 0.5, 1.0];
    let endless = [(f64::NEG_INFINITY, ball(0.5)), (1e300, ball(1.0))];
    let data = written(Scene3::new("balloon").times(&times).moving_surface(&endless));
    assert_eq!(data["scenes"][0]["starts"], json!([-1e300, 1e300]));
}

/// Late in a long run samples lie as far apart as early in it, although f32 knows no two of these times.
#[test]
fn late_times_are_as_far_apart_as_early_ones() {
    for from in [0.0, 1e5, 1e6, -1e9, 1e12] {
        let times: Vec<f64> = (0..100).map(|k| from + 0.05 * f64::from(k)).collect();
        let path: Vec<_> = times.iter().map(|t| [t - from, 0.0, 0.0]).collect();
        let data = written(Scene3::new("late").bodies(&times, &[path]));
        assert_eq!(data["scenes"][0]["from"], json!(from));
        let shown = times_of(&data);
        assert_eq!((shown.len(), shown[0]), (100, 0.0));
        for (pair, wanted) in shown.windows(2).zip(times.windows(2)) {
            let [apart, wanted] = [pair, wanted].map(|pair| pair[1] - pair[0]);
            assert!((apart / wanted - 1.0).abs() < 0.01, "{apart} and {wanted} after {from}");
        }
    }
}

#[test]
fn scenes_that_cannot_be_drawn_are_errors() {
    let path = [[0.0; 3], [1.0; 3]];
    let scene = |times: &[f64], paths: &[Vec<[f64; 3]>]| Scene3::new("flight").bodies(times, paths);
    let far = vec![[0.0; 3], [1e39, 0.0, 0.0]];
    let on_a_line =
        rattle::Scene::point().simulate(rattle::State::at([0.0]), rattle::Rattle::new(0.1)).unwrap();
    let line = rattle::Trajectory::of(&on_a_line);
    let run = |h| {
        let start = rattle::State::at([0.0; 3]).moving([1.0, 0.0, 0.0]);
        let mut simulation = rattle::Scene::point().simulate(start, rattle::Rattle::new(h)).unwrap();
        let mut trajectory = rattle::Trajectory::of(&simulation);
        simulation.observe(10, 5, &mut trajectory).unwrap();
        trajectory
    };
    let (slow, fast) = (run(0.25), run(0.5));
    let same = Scene3::new("flight").trajectory(&slow).trajectory(&slow);
    assert!(Page::new("Page").scene(same).to_html().is_ok());
    #[rustfmt::skip]
    let cases = [
        ("nobody",    scene(&[0.0, 1.0], &[]),                                  "nothing moves"),
        ("no time",   scene(&[0.0], &[vec![[0.0; 3]]]),                         "nothing moves"),
        ("backwards", scene(&[0.0, -1.0], &[path.to_vec()]),                    "time 1 is -1"),
        ("NaN time",  scene(&[f64::NAN, 1.0], &[path.to_vec()]),                "time 1 is 1"),
        ("as one",    scene(&[0.0, 1.0, 1.0 + 1e-12], &[path.to_vec()]),        "time 2 is 1.000000000001, which does not follow"),
        ("endless",   scene(&[0.0, 1e39], &[path.to_vec()]),                    "time 1 is 1"),
        ("short",     scene(&[0.0, 1.0, 2.0], &[path.to_vec()]),                "body 0 has 2 positions for 3 times"),
        ("NaN",       scene(&[0.0, 1.0], &[path.to_vec(), vec![[0.0; 3], [0.0, f64::NAN, 0.0]]]), "body 1 is at [0.0, NaN, 0.0] at time 1"),
        ("no body",   flight().rods([(0, 1)]),                                  "there is no body 1 for a rod"),
        ("no place",  flight().rods([(0, [f64::NAN, 0.0, 0.0])]),               "coordinate NaN"),
        ("no radius", flight().disc(0, [1.0, 0.0, 0.0], 0.0),                   "radius of a disc 0"),
        ("no axis",   flight().disc(0, [0.0; 3], 1.0),                          "axis 0"),
        ("no wall",   flight().wall([f64::INFINITY; 3], [[1.0; 3]; 2]),         "wall inf"),
        ("sizes",     flight().sizes(&[[1.0, 2.0, 3.0]]),                       "sizes: 3 for 2 times (or one)"),
        ("size",      flight().sizes(&[[-1.0]]),                                "size -1"),
        ("colours",   flight().coloured_by("speed", &[[1.0], [2.0]]),           "speed: 2 for 1 body"),
        ("colour",    flight().coloured_by("speed", &[[f64::NAN]]),             "speed NaN"),
        ("names",     flight().names(["a", "b"]),                               "names: 2 for 1 body"),
        ("heat",      flight().heat("curvature", [1.0]),                        "curvature: 1 for 0 vertices"),
        ("chart",     flight().chart("Energy", [("E", [1.0])]),                 "E: 1 for 2 times"),
        ("mirror",    flight().turning_box([1.0; 3], &[[0.0; 3]], &[[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]]), "box 0 at time 0 are no rotation"),
        ("thin box",  flight().turning_box([1.0, 0.0, 1.0], &[[0.0; 3]], &[[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]]), "side of a box 0"),
        ("late",      flight().moving_surface(&[(1.0, ball(1.0)), (0.5, ball(1.0))]), "come after the one before, at time 0.5"),
        ("at once",   flight().seconds(0.0),                                    "duration 0"),
        ("never",     flight().seconds(f64::INFINITY),                          "duration inf"),
        ("period",    flight().periods([0.0, -1.0, 0.0]),                       "period -1"),
        ("no period", flight().periods([f64::NAN, 0.0, 0.0]),                   "period NaN"),
        ("a line",    flight().trajectory(&line),                               "a trajectory has 1"),
        ("two paces", Scene3::new("flight").trajectory(&slow).trajectory(&fast), "has time 1 at 2.5, and the bodies before it at 1.25"),
        ("too far",   scene(&[0.0, 1.0], &[far]),                               "1e39"),
    ];
    for (name, scene, words) in cases {
        let message = Page::new("Page").scene(flight()).scene(scene).to_html().expect_err(name).to_string();
        assert!(message.contains("scene `flight`") && message.contains(words), "{name}: {message}");
    }
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    let error = Page::new("Page").scene(flight()).write(folder.path().join("file/page.html"));
    assert!(matches!(error, Err(PageError::Io { .. })));
}

#[test]
fn text_is_escaped_and_a_shared_mesh_is_written_once() {
    let html = billiards().to_html().unwrap();
    assert_eq!(html.matches("</script>").count(), 3, "data, three.js and the page's own script");
    assert_eq!(html.matches("\"triangles\"").count(), 1);
    assert!(html.contains("<title>Billiards on a surface of &lt;genus&gt; two &amp; more</title>"));
    assert!(html.contains("The MIT License"), "three.js keeps its licence");
    assert!(!html.contains("{{"), "a hole in the template is left");
}
