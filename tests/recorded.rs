//! What a recorder keeps and how it is called in files: times that a run reaches, names that would hide others.

use rattle::Error;
use rattle::prelude::*;
use rattle::record::{Stream, Vtu, Xyz};
use rattle::vtu::Series;
use rattle::watch::{Columns, Recorder, Rows};
use std::fs;

/// A free body from this time on, in so many steps of h, recorded at these times.
fn rows(start: f64, h: f64, steps: u64, times: &[f64]) -> Vec<f64> {
    let start = State::at([0.0, 0.0, 0.0]).moving([1.0, 0.0, 0.0]).at_time(start);
    let mut simulation = Scene::point().simulate(start, Rattle::new(h)).unwrap();
    let columns = Columns::<3>::new().positions().at_times(times.iter().copied());
    let mut recorder = Recorder::of(&columns, Rows::default());
    simulation.observe(steps, 1, &mut recorder).unwrap();
    recorder.finish().unwrap().times
}

fn near(found: &[f64], expected: &[f64]) {
    let same = found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9);
    assert!(same, "{found:?} for {expected:?}");
}

/// Forwards the first sight at or after, backwards at or before; the start is that of all times before it.
#[test]
fn times_are_reached_whichever_way_they_run() {
    near(&rows(1.0, -0.01, 100, &[1.0, 0.95, 0.935]), &[1.0, 0.95, 0.93]);
    near(&rows(1.0, -0.01, 100, &[0.935, 2.0, f64::NEG_INFINITY]), &[1.0, 0.93]);
    near(&rows(0.0, 0.01, 100, &[-1.0, 0.02]), &[0.0, 0.02]);
    near(&rows(0.0, 0.01, 100, &[0.015, 0.0151, 0.5, f64::INFINITY]), &[0.02, 0.5]);
    near(&rows(0.0, 0.01, 100, &[]), &[]);
    near(&rows(5.0, 0.01, 100, &[0.5, 1.0]), &[5.0]);
}

/// A time is not a step late because it was rounded up.
#[test]
fn times_that_are_whole_steps_away_are_reached_by_these() {
    for (start, h) in [(0.0, 0.01_f64), (0.0, -0.01), (1.0, 0.1 / 3.0), (-2.0, -0.07)] {
        let times: Vec<f64> = (0..40).map(|k| start + (h * 10.0) * f64::from(k)).collect();
        near(&rows(start, h, 395, &times), &times);
        let later: Vec<f64> = times.iter().map(|time| time + 1e-4 * h).collect();
        let next: Vec<f64> = times.iter().map(|time| time + h).collect();
        near(&rows(start, h, 395, &later), &next);
    }
}

#[test]
fn a_time_that_is_no_number_is_told() {
    let mut simulation = Scene::points::<3>(1).simulate(State::at([0.0; 3]), Rattle::new(0.1)).unwrap();
    let columns = Columns::<3>::new().at_times([0.1, f64::NAN]);
    let mut recorder = Recorder::of(&columns, Rows::default());
    let error = simulation.observe(10, 1, &mut recorder).unwrap_err();
    assert!(matches!(&error, Error::Recorder { rows: 0, why } if why.contains("NaN")), "{error}");
}

/// Only the ending is cut off, and names are what they are in XML.
#[test]
fn series_keep_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for name in ["k=0.1", "k=0.2", "a&b.pvd", "plain", "x.vtu"] {
        Series::create(at(name)).unwrap().add(0.5, name).unwrap();
    }
    let files = ["k=0.1", "k=0.2", "a&b", "plain", "x.vtu"];
    for (file, name) in files.iter().zip(["k=0.1", "k=0.2", "a&b.pvd", "plain", "x.vtu"]) {
        assert_eq!(fs::read_to_string(at(&format!("{file}_000000.vtu"))).unwrap(), name);
        let list = fs::read_to_string(at(&format!("{file}.pvd"))).unwrap();
        let told = format!("file=\"{}_000000.vtu\"", file.replace('&', "&amp;"));
        assert!(list.contains(&told), "{list}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 10);
    Vtu::create(at("k=0.3")).unwrap();
    assert!(at("k=0.3.pvd").exists());
    for none in ["..", ".pvd"] {
        assert!(Series::create(at(none)).is_err(), "{none}");
    }
}

/// A line of extended XYZ has each key once.
#[test]
fn keys_of_extended_xyz_are_not_taken_twice() {
    let told = |names: &[&str]| {
        let stream = Stream::to(Xyz::to(Vec::new(), "X"));
        let columns = Columns::<3>::new().positions();
        let columns = names.iter().fold(columns, |columns, name| columns.quantity(name, |_| 1.0));
        let mut recorder = Recorder::of(&columns, stream.sink());
        let start = State::at([0.0; 3]);
        let mut simulation = Scene::points::<3>(1).simulate(start, Rattle::new(0.1)).unwrap();
        let ended = simulation.observe(10, 1, &mut recorder).and_then(|()| recorder.finish().map(drop));
        let told = stream.finish().map_err(|error| error.to_string());
        assert!(ended.is_ok() || told.is_err(), "{ended:?}");
        told
    };
    for key in ["Lattice", "Properties", "pbc", "Time", "Step", "Trajectory"] {
        assert!(told(&[key]).unwrap_err().contains(&format!("`{key}` is a key of extended XYZ")), "{key}");
    }
    assert!(told(&["a b", "a_b"]).unwrap_err().contains("two quantities would be called `a_b`"));
    assert_eq!(told(&["time", "a b", "a=c"]), Ok(10));
}

/// A name that is empty is not called one that is there twice.
#[test]
fn an_empty_name_is_told() {
    let columns = Columns::<3>::new().quantity("", |_| 0.0);
    let mut recorder = Recorder::of(&columns, Rows::default());
    let mut simulation = Scene::points::<3>(1).simulate(State::at([0.0; 3]), Rattle::new(0.1)).unwrap();
    let error = simulation.observe(10, 1, &mut recorder).unwrap_err().to_string();
    assert!(error.contains("an empty one") && !error.contains("again"), "{error}");
}
