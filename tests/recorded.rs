//! What a recorder keeps and how it is called in files: times that a run reaches, names that would hide others.

use crate::recorders::{python, read_by};
use parquet::file::reader::{FileReader, SerializedFileReader};
use rattle::checkpoint::{CheckpointError, Ended, Saving};
use rattle::links::planar::{Crank, Rod, Slider};
use rattle::potentials::planar::Gravity;
use rattle::prelude::*;
use rattle::record::{Csv, NpzParts, Parquet, Stream, Vtu, Writer, Xyz};
use rattle::surfaces::Sphere;
use rattle::system::System;
use rattle::vtu::Series;
use rattle::watch::{Column, Columns, Each, Recorder, Rows};
use rattle::{Error, data};
use std::fs::{self, File};
use std::io;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

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

/// Trajectories that go one by one hand in blocks of one trajectory each.
#[test]
fn vtu_takes_one_trajectory_and_xyz_names_each() {
    let folder = tempfile::tempdir().unwrap();
    let recorded = |stream: Stream, number: u16| {
        let start = |i| State::at([1.0, 0.0, 0.0]).moving([0.0, 1.0 + f64::from(i), 0.0]);
        let scene = Scene::on(Sphere { r: 1.0 });
        let mut ensemble = scene.ensemble((0..number).map(start), NoseHoover::new(0.5, 1.0, 0.01)).unwrap();
        assert_eq!(ensemble.plan().in_lanes, 0);
        let columns = Columns::<3>::new().positions();
        let _ = ensemble.observe(20, 10, || Recorder::of(&columns, stream.sink())).finish();
        stream.finish().map_err(|error| error.to_string())
    };
    let vtu = |name: &str| Stream::to(Vtu::create(folder.path().join(name)).unwrap());
    assert_eq!(recorded(vtu("one"), 1), Ok(2));
    let error = recorded(vtu("two"), 2).unwrap_err();
    assert!(error.contains("the writer had taken 2 rows, then: VTU takes one trajectory"), "{error}");
    let path = folder.path().join("two.xyz");
    assert_eq!(recorded(Stream::to(Xyz::create(&path, "X").unwrap()), 2), Ok(4));
    let text = fs::read_to_string(path).unwrap();
    assert_eq!(["Trajectory=0", "Trajectory=1"].map(|name| text.matches(name).count()), [2, 2]);
}

/// Records into a file, of two bodies that are free.
fn of_two_bodies<const D: usize>(writer: impl Writer, columns: &Columns<D>, steps: u64) -> u64 {
    let stream = Stream::to(writer);
    let mut recorder = Recorder::of(columns, stream.sink());
    let start = State::of([[0.5; D], [0.25; D]]);
    Scene::points(2).simulate(start, Rattle::new(0.1)).unwrap().observe(steps, 1, &mut recorder).unwrap();
    recorder.finish().unwrap();
    stream.finish().unwrap()
}

/// A number is a number, whatever it is called.
#[test]
fn quantities_named_as_vectors_are_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let columns =
        Columns::<3>::new().positions().quantity("p", |_| 7.0).quantity("constraint_forces", |_| 8.0);
    assert_eq!(of_two_bodies(Xyz::create(at("run.xyz"), "X").unwrap(), &columns, 3), 3);
    let text = fs::read_to_string(at("run.xyz")).unwrap();
    assert_eq!(text.matches("Properties=species:S:1:pos:R:3 pbc").count(), 3);
    assert_eq!(
        text.matches(" p=\"7.0\" constraint_forces=\"8.0\"\nX 0.5 0.5 0.5\nX 0.25 0.25 0.25\n").count(),
        3
    );
    assert_eq!(of_two_bodies(Vtu::create(at("run")).unwrap(), &columns, 3), 3);
    let text = fs::read_to_string(at("run_000002.vtu")).unwrap();
    assert!(text.contains("0.25") && !text.contains("momentum") && !text.contains("force"), "{text}");
}

/// On a line too, positions are those of bodies.
#[test]
fn bodies_on_a_line_have_positions() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.xyz");
    let columns = Columns::<1>::new().positions().momenta();
    of_two_bodies(Xyz::create(&path, "X").unwrap(), &columns, 1);
    let text = fs::read_to_string(path).unwrap();
    assert!(text.ends_with("X 0.5 0.0 0.0 0.0 0.0 0.0\nX 0.25 0.0 0.0 0.0 0.0 0.0\n"), "{text}");
}

/// Columns are known where a sight was, if no row.
#[test]
fn files_without_rows_have_columns() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let columns = Columns::<3>::new().positions().energies().quantity("height", |_| 1.0).at_times([1e9]);
    let [npz, table] = ["run.npz", "run.parquet"].map(at);
    assert_eq!(of_two_bodies(NpzParts::create(&npz).unwrap(), &columns, 5), 0);
    let shape = |name: &str| data::read(&npz, &format!("{name}.000000")).unwrap().shape;
    for name in ["step", "trajectory", "t", "height"] {
        assert_eq!(shape(name), [0], "{name}");
    }
    assert_eq!((shape("q"), shape("energies")), (vec![0, 2, 3], vec![0, 2]));
    assert_eq!(of_two_bodies(Parquet::create(&table).unwrap(), &columns, 5), 0);
    let names = |path| {
        let file = SerializedFileReader::new(File::open(path).unwrap()).unwrap();
        let about = file.metadata().file_metadata();
        assert_eq!(about.num_rows(), 0);
        about.schema_descr().columns().iter().map(|column| column.name().to_string()).collect::<Vec<_>>()
    };
    let expected = "step trajectory t q_0_0 q_0_1 q_0_2 q_1_0 q_1_1 q_1_2 energies_0 energies_1 height";
    assert_eq!(names(&table).join(" "), expected);
    let text = at("run.csv");
    let line = |path| fs::read_to_string(path).unwrap();
    assert_eq!(of_two_bodies(Csv::create(&text).unwrap(), &columns, 5), 0);
    assert_eq!(line(&text), expected.replace(' ', ",") + "\n");

    // Without a sight too, what every row has.
    of_two_bodies(NpzParts::create(&npz).unwrap(), &columns, 0);
    assert_eq!(shape("trajectory"), [0]);
    of_two_bodies(Parquet::create(&table).unwrap(), &columns, 0);
    assert_eq!(names(&table).join(" "), "step trajectory t");
    of_two_bodies(Csv::create(&text).unwrap(), &columns, 0);
    assert_eq!(line(&text), "step,trajectory,t\n");

    // In an ensemble some recorders may have rows, and others none.
    let stream = Stream::to(NpzParts::create(&npz).unwrap());
    let starts = [0.0, 1.0].map(|time| State::at([1.0, 0.0, 0.0]).moving([0.0, 1.0, 0.0]).at_time(time));
    let method = NoseHoover::new(0.5, 1.0, 0.01);
    let mut ensemble = Scene::on(Sphere { r: 1.0 }).ensemble(starts, method).unwrap();
    let columns = Columns::<3>::new().positions().at_times([0.05]);
    ensemble.observe(9, 1, || Recorder::of(&columns, stream.sink())).finish().unwrap();
    assert_eq!(stream.finish().unwrap(), 2);
    assert_eq!(shape("q"), [2, 1, 3]);
}

/// A quantity is asked once for each row, and columns are found once, also where there are none.
#[test]
fn nothing_is_asked_without_a_row() {
    let asked = Arc::new(AtomicU64::new(0));
    let asks = asked.clone();
    let columns = Columns::<3>::new().quantity("asked", move |_| asks.fetch_add(1, Ordering::Relaxed) as f64);
    let mut simulation = Scene::point().simulate(State::at([0.0; 3]), Rattle::new(0.1)).unwrap();
    let mut recorder = Recorder::of(&columns.at_times([0.35, 0.65]), Rows::default());
    simulation.observe(10, 1, &mut recorder).unwrap();
    let rows = recorder.finish().unwrap();
    assert_eq!((rows.len(), asked.load(Ordering::Relaxed)), (2, 2));

    let mut recorder = Recorder::of(&Columns::<3>::new().at_times([1e9]), Rows::default());
    let mut allocated = |steps| {
        let observed = || simulation.observe(steps, 1, &mut recorder).unwrap();
        allocation_counter::measure(observed).count_total
    };
    let [few, many] = [10, 1000].map(&mut allocated);
    assert!(many <= few, "{few} for 10 steps, {many} for 1000");
}

/// What moves by itself has no momentum of its own, and no temperature.
#[test]
fn without_freedom_there_is_no_temperature() {
    let scene = Scene::points(2)
        .link_moving(Crank { centre: [0.0; 2], radius: 1.0, omega: 2.0, phase: 0.0 }, [[0]])
        .link(Rod { length: 3.0 }, [[0, 1]])
        .link(Slider { point: [0.0; 2], direction: [1.0, 0.0] }, [[1]]);
    let start = scene.project(&State::of([[1.0, 0.0], [4.0, 0.0]])).unwrap();
    let mut simulation = scene.simulate(start.clone(), Rattle::new(0.01)).unwrap();
    let columns = Columns::<2>::new().temperature();
    let mut recorder = Recorder::of(&columns, Rows::default());
    simulation.observe(20, 1, &mut recorder).unwrap();
    assert_eq!(simulation.freedom(), 0);
    assert!(simulation.temperature().is_nan() && simulation.boxed().temperature().is_nan());
    assert!(recorder.finish().unwrap().numbers.iter().all(|x| x.is_nan()));
    let mut ensemble = scene.ensemble([start.clone(), start], Rattle::new(0.01)).unwrap();
    let rows = ensemble.observe(20, 1, || Recorder::of(&columns, Rows::default())).finish().unwrap();
    assert!(rows.len() == 40 && rows.numbers.iter().all(|x| x.is_nan()), "{:?}", rows.numbers);
}

/// A free body on a line, at speed 1.
fn on_a_line(h: f64) -> Simulation<impl System<f64, 1>, Rattle, 1> {
    Scene::point().simulate(State::at([0.0]).moving([1.0]), Rattle::new(h)).unwrap()
}

/// A time between the last sight of a call and its end is met by the first sight of the next one.
#[test]
fn no_time_is_lost_between_two_calls() {
    let recorder = |times: &[f64]| {
        let columns = Columns::<1>::new().at_times(times.iter().copied());
        Recorder::of(&columns, Rows::default())
    };
    for direction in [1.0, -1.0] {
        let given = [5.0, 10.2, 10.4, 15.0].map(|time| direction * time);
        let expected = |times: &[f64]| times.iter().map(|time| direction * time).collect::<Vec<_>>();
        let (mut run, mut seen) = (on_a_line(0.1 * direction), recorder(&given));
        for _ in 0..2 {
            run.observe(105, 10, &mut seen).unwrap(); // the last sights are those of steps 100 and 205
        }
        near(&seen.finish().unwrap().times, &expected(&[5.0, 11.5, 15.5]));

        // What nobody sees between two calls is between them, too.
        let (mut run, mut seen) = (on_a_line(0.1 * direction), recorder(&given));
        run.observe(100, 10, &mut seen).unwrap();
        run.run(35).unwrap();
        run.observe(30, 10, &mut seen).unwrap();
        near(&seen.finish().unwrap().times, &expected(&[5.0, 14.5, 15.5]));

        // A run that begins anew has all its times, be it another one or the same at a checkpoint.
        let (mut run, mut seen) = (on_a_line(0.1 * direction), recorder(&given));
        let start = run.checkpoint();
        run.observe(105, 10, &mut seen).unwrap();
        run.resume(&start).unwrap();
        run.observe(105, 10, &mut seen).unwrap();
        on_a_line(0.1 * direction).observe(60, 10, &mut seen).unwrap();
        near(&seen.finish().unwrap().times, &expected(&[5.0, 5.0, 5.0]));
    }
}

/// Each trajectory has its own sights: one ends where others go on.
#[test]
fn times_are_met_by_each_trajectory() {
    let starts = [0.0, 0.03, -0.04].map(|time| State::at([0.0]).moving([1.0]).at_time(time));
    let mut ensemble = Scene::points::<1>(1).ensemble(starts, Rattle::new(0.01)).unwrap();
    let columns = Columns::<1>::new().at_times([0.055, 0.1]);
    let rows = ensemble.observe(25, 10, || Recorder::of(&columns, Rows::default())).finish().unwrap();
    let of = |trajectory| {
        let rows = rows.trajectories.iter().zip(&rows.times).filter(move |row| *row.0 == trajectory);
        rows.map(|row| *row.1).collect::<Vec<_>>()
    };
    near(&of(0), &[0.1]);
    near(&of(1), &[0.13]);
    near(&of(2), &[0.06, 0.16]);
}

/// Chains of 3 and of 5 bodies, side by side.
fn of_two_sizes() -> Ensemble<2> {
    let chain = |rods: usize| {
        let links = (0..rods).map(|i| [i, i + 1]);
        let scene = Scene::points(rods + 1).link(Rod { length: 1.0 }, links).pin(0, [0.0; 2]);
        (scene, State::of((0..=rods).map(|i| [i as f64, 0.0])))
    };
    let [few, many] = [chain(2), chain(4)];
    Ensemble::sweep(Double, [(&few.0, few.1), (&many.0, many.1)], Rattle::new(0.01)).unwrap()
}

/// Rows of one table have one length: those of other sizes are told, and not mixed in.
#[test]
fn rows_of_several_sizes_are_not_mixed() {
    let places = Columns::<2>::new().positions();
    let told = |error: Error| {
        let Error::Recorder { why, .. } = &error else { panic!("{error}") };
        assert!(
            why.contains("`q` has the shape [") && why.contains("3, 2]") && why.contains("5, 2]"),
            "{why}"
        );
    };
    told(of_two_sizes().observe(2, 1, || Recorder::of(&places, Rows::default())).finish().unwrap_err());
    let energies = Columns::<2>::new().energies();
    let rows = of_two_sizes().observe(2, 1, || Recorder::of(&energies, Rows::default())).finish().unwrap();
    assert_eq!((rows.len(), rows.numbers("energies").count()), (4, 4));

    // In a file whose parts have a shape each, all is there.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.npz");
    let stream = Stream::to(NpzParts::create(&path).unwrap());
    of_two_sizes().observe(2, 1, || Recorder::of(&places, stream.sink())).finish().unwrap();
    assert_eq!(stream.finish().unwrap(), 4);
    let mut shapes = [0, 1].map(|part| data::read(&path, &format!("q.{part:06}")).unwrap().shape);
    shapes.sort();
    assert_eq!(shapes, [[2, 3, 2], [2, 5, 2]]);
    // A table of numbers has one width.
    let stream = Stream::to(Parquet::create(folder.path().join("run.parquet")).unwrap());
    let _ = of_two_sizes().observe(2, 1, || Recorder::of(&places, stream.sink())).finish();
    let error = stream.finish().unwrap_err().to_string();
    assert!(error.contains("`q` has the shape ["), "{error}");

    // Nor are those of one run after another.
    let free = |bodies: usize| {
        let start = State::of((0..bodies).map(|i| [i as f64, 0.0]));
        Scene::points(bodies).simulate(start, Rattle::new(0.01)).unwrap()
    };
    let mut recorder = Recorder::of(&places, Rows::default());
    free(3).observe(2, 1, &mut recorder).unwrap();
    told(free(5).observe(2, 1, &mut recorder).unwrap_err());
    let mut path = Trajectory::new();
    free(3).observe(2, 1, &mut path).unwrap();
    let error = free(5).observe(2, 1, &mut path).unwrap_err();
    assert!(matches!(&error, Error::Recorder { rows: 3, why } if why.contains("3 bodies")), "{error}");
    assert_eq!((path.shape(), path.positions().len()), ([3, 3, 2], 18));
}

/// One trajectory has one shape; `Each` keeps one of each.
#[test]
#[should_panic(expected = "take `Each::of(Trajectory::new)`")]
fn trajectories_of_several_sizes_are_not_joined() {
    let kept = of_two_sizes().observe(2, 1, || Each::of(Trajectory::new));
    assert_eq!([0, 1].map(|i| kept.get(i).unwrap().shape()), [[3, 3, 2], [3, 5, 2]]);
    of_two_sizes().observe(2, 1, Trajectory::new);
}

/// Multipliers have a row for each row of places, in trajectories that were joined, too: NaN where none were heard.
#[test]
fn joined_trajectories_have_multipliers_of_one_shape() {
    let scene = Scene::on(rattle::surfaces::Sphere { r: 1.0 });
    let start = || State::at([1.0, 0.0, 0.0]).moving([0.0, 1.0, 0.0]);
    let mut run = scene.simulate(start(), Rattle::new(0.01)).unwrap();
    let mut path = Trajectory::with_multipliers(&run);
    run.observe(3, 1, &mut path).unwrap();
    let mut others = [Trajectory::new(), Trajectory::with_multipliers(&run)];
    for other in &mut others {
        run.observe(2, 1, other).unwrap();
    }
    let heard = others[1].multipliers().unwrap().clone();
    others.into_iter().for_each(|other| Observer::<3>::join(&mut path, other));
    let (rows, lambda) = (path.times().len(), &path.multipliers().unwrap().position);
    assert_eq!((rows, lambda.len()), (10, 10));
    assert!(lambda[4..7].iter().all(|x| x.is_nan()) && lambda[7..] == heard.position);
}

/// Takes so many blocks, and keeps their steps.
struct Blocks(usize, Arc<Mutex<Vec<u64>>>);

impl Writer for Blocks {
    fn write(&mut self, rows: &Rows) -> io::Result<()> {
        self.0 = self.0.checked_sub(1).ok_or_else(|| io::Error::other("the disk is full"))?;
        self.1.lock().unwrap().extend(&rows.steps);
        Ok(())
    }
    fn finish(self) -> io::Result<()> {
        Ok(())
    }
}

/// No checkpoint is ahead of the file of a recorder that was flushed, also where that failed.
#[test]
fn a_run_whose_rows_are_lost_is_not_saved_behind_them() {
    let folder = tempfile::tempdir().unwrap();
    let saving = Saving::to(folder.path().join("run.rattle")).every(100);
    let kept = Arc::new(Mutex::new(Vec::new()));
    let stream = Stream::to(Blocks(2, kept.clone()));
    let mut recorder = Recorder::of(&Columns::<1>::new().positions(), stream.sink());
    let mut run = on_a_line(0.1);
    let ended = saving.run_to_by(&mut run, 1000, 10, |run, steps, every| {
        run.observe(steps, every, &mut recorder)?;
        recorder.flush()
    });
    let error = ended.unwrap_err();
    assert!(matches!(error, CheckpointError::Step(_)) && error.to_string().contains("is full"), "{error}");
    let mut again = on_a_line(0.1);
    assert!(saving.restore(&mut again).unwrap());
    assert_eq!(kept.lock().unwrap().last(), Some(&200));
    assert_eq!((run.steps(), again.steps()), (300, 200));
}

/// A run that has its steps already is saved, and not again where the file is of that step.
#[test]
fn a_run_without_steps_to_take_is_saved() {
    let folder = tempfile::tempdir().unwrap();
    let saving = Saving::to(folder.path().join("deep/run.rattle"));
    let mut run = on_a_line(0.1);
    run.run(10).unwrap();
    assert_eq!(saving.run_to(&mut run, 10).unwrap(), Ended::Done);
    let mut again = on_a_line(0.1);
    assert!(saving.restore(&mut again).unwrap());
    assert_eq!(again.steps(), 10);
    fs::create_dir(folder.path().join("deep/run.rattle.part")).unwrap(); // where nothing can be written
    assert_eq!(saving.run_to(&mut run, 5).unwrap(), Ended::Done);
    run.run(1).unwrap();
    assert!(matches!(saving.run_to(&mut run, 5), Err(CheckpointError::Io { .. })));
}

/// Flushes do not make parts: a file of few rows at a time is as large as one of many.
#[test]
fn an_archive_has_parts_of_some_size() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.npz");
    let stream = Stream::to(NpzParts::create(&path).unwrap());
    let mut recorder = Recorder::of(&Columns::<1>::new().positions().momenta(), stream.sink());
    let mut run = on_a_line(0.1);
    for _ in 0..1000 {
        run.observe(1, 1, &mut recorder).unwrap();
        recorder.flush().unwrap();
    }
    recorder.finish().unwrap();
    assert_eq!(stream.finish().unwrap(), 1000);
    let times = data::read(&path, "t.000000").unwrap();
    assert_eq!((&times.shape[..], times.data[999]), (&[1000][..], run.time()));
    assert_eq!(data::read(&path, "q.000000").unwrap().shape, [1000, 1, 1]);
    assert!(data::read(&path, "q.000001").is_err());
    let (size, numbers) = (fs::metadata(&path).unwrap().len(), 1000 * 5 * 8);
    assert!((numbers..2 * numbers).contains(&size), "{size} bytes for {numbers} of numbers");

    // Of 2²⁰ numbers or a block more each, in the order of their rows.
    let mut writer = NpzParts::create(&path).unwrap();
    for block in 0..5 {
        let count = |row: u64| 100_000 * block + row;
        writer
            .write(&Rows {
                steps: (0..100_000).map(count).collect(),
                trajectories: vec![0; 100_000],
                times: vec![0.5; 100_000],
                numbers: (0..100_000).map(|row| count(row) as f64).collect(),
                columns: [Column { name: "x".into(), shape: Vec::new(), place: 0..1 }].into(),
            })
            .unwrap();
    }
    writer.finish().unwrap();
    let parts = [0, 1].map(|part| data::read(&path, &format!("x.{part:06}")).unwrap());
    assert_eq!([&parts[0].shape[..], &parts[1].shape[..]], [[300_000], [200_000]]);
    assert!(parts.iter().flat_map(|part| &part.data).copied().eq((0..500_000).map(f64::from)));
}

/// A column whose name begins as another's is no part of it.
#[test]
fn columns_are_told_apart_by_the_line_for_numpy() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.npz");
    let place = |now: &Sight<'_, 3>| now.position().x;
    let columns =
        Columns::<3>::new().quantity("x", place).quantity("x.abs", place).quantity("x.abs.y", place);
    of_two_bodies(NpzParts::create(&path).unwrap(), &columns, 4);
    let pages = [include_str!("../src/record.rs"), include_str!("../docs/guide/long-runs.md")];
    for page in pages {
        assert!(page.contains("for k in sorted(f) if k.rpartition(\".\")[0] == \"q\"])"));
    }
    let Some(python) = python("zipfile") else { return };
    let code = "import sys, zipfile\nf = [name[:-4] for name in zipfile.ZipFile(sys.argv[1]).namelist()]\n\
        for c in ['x', 'x.abs', 'x.abs.y', 'abs']: print(len([k for k in f if k.rpartition('.')[0] == c]))";
    assert_eq!(read_by(&python, code, &path), [1.0, 1.0, 1.0, 0.0]);
}

/// The cell of a periodic scene is in each frame; lengths that are none are refused.
#[test]
fn xyz_has_a_cell() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.xyz");
    let xyz = Xyz::create(&path, "Ar").unwrap().cell([8.0, 7.5, 1.0], [true, true, false]).unwrap();
    let stream = Stream::to(xyz);
    let columns = Columns::<2>::new().positions();
    let mut recorder = Recorder::of(&columns, stream.sink());
    let start = State::of([[7.9, 0.0], [1.0, 0.0]]).moving([1.0, 0.0]);
    Scene::points(2).simulate(start, Rattle::new(0.5)).unwrap().observe(2, 1, &mut recorder).unwrap();
    recorder.finish().unwrap();
    stream.finish().unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let cell = "Lattice=\"8.0 0.0 0.0 0.0 7.5 0.0 0.0 0.0 1.0\" pbc=\"T T F\" Time=";
    assert_eq!(text.matches(cell).count(), 2, "{text}");
    assert!(text.contains("Ar 8.9 0.0 0.0"), "positions are as they are: {text}");
    for length in [0.0, -1.0, f64::INFINITY, f64::NAN] {
        let error = Xyz::to(Vec::new(), "Ar").cell([1.0, length, 1.0], [true; 3]).unwrap_err();
        assert!(error.to_string().contains("positive and finite"), "{error}");
    }
}

/// A row tells of the iterations up to its own time, that of the start too; by itself and in an ensemble of those that
/// go one by one.
#[test]
fn iterations_are_those_of_the_time_of_a_row() {
    let columns = Columns::<2>::new().iterations().with_start();
    let scene = || {
        let scene = Scene::points(2).pin(0, [0.0, 0.0]).link(Rod { length: 1.0 }, [[0, 1]]);
        scene.with(Gravity { g: 1.0 })
    };
    let start = State::of([[0.0, 0.0], [1.0, 0.0]]);
    let mut recorder = Recorder::of(&columns, Rows::default());
    scene().simulate(start.clone(), Shake::new(0.01)).unwrap().observe(50, 10, &mut recorder).unwrap();
    let rows = recorder.finish().unwrap();
    let found: Vec<f64> = rows.numbers("iterations").flatten().copied().collect();
    assert!(found[0] == 0.0 && found.is_sorted_by(|a, b| a + 10.0 <= *b), "{found:?}");
    let mut ensemble = scene().ensemble([start], Shake::new(0.01)).unwrap();
    let rows = ensemble.observe(50, 10, || Recorder::of(&columns, Rows::default())).finish().unwrap();
    assert!(rows.numbers("iterations").flatten().eq(&found));
}
