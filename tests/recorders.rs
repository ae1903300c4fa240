//! Recorders: what they keep is what a look at the run would have told; files are what others read; what cannot be
//! written ends the run and leaves it as it was.

use crate::common::*;
use rattle::Error;
use rattle::checkpoint::{Ended, Saving};
use rattle::effect::LinearDrag;
use rattle::links::planar::Rod;
use rattle::prelude::*;
use rattle::record::{NpzParts, Parquet, Stream, Vtu, Writer, Xyz};
use rattle::view::{Mesh, surface};
use rattle::watch::{Columns, Recorder, Rows};
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

fn ring(
    n: usize,
) -> Simulation<impl rattle::system::System<f64, 3, Count = rattle::bodies::Many>, Rattle, 3> {
    let scene = Scene::on(Torus { major: 2.0, minor: 0.7 }).bodies(n).with(Gravity { g: 1.0 });
    let scene = scene.with(LinearDrag::new(0.1)).with(Gravity { g: 0.5 });
    let angle = |i: usize| i as f64;
    let places = State::of((0..n).map(|i| [2.7 * angle(i).cos(), 2.7 * angle(i).sin(), 0.0]));
    scene.simulate(places.moving([0.0, 0.0, 0.4]), Rattle::new(0.01)).unwrap()
}

fn everything() -> Columns<3> {
    let height = |now: &Sight<'_, 3>| now.position().z;
    Columns::new()
        .positions()
        .momenta()
        .energies()
        .effect_energies()
        .residuals()
        .temperature()
        .multipliers()
        .constraint_forces()
        .quantity("height", height)
}

#[test]
fn rows_are_what_a_look_tells() {
    let (mut seen, mut simulation) = (ring(3), ring(3));
    let mut recorder = Recorder::of(&everything(), Rows::default());
    simulation.observe(50, 5, &mut recorder).unwrap();
    let rows = recorder.finish().unwrap();
    assert_eq!(rows.len(), 10);
    assert_eq!(rows.column("q").unwrap().shape, [3, 3]);
    assert_eq!(rows.column("lambda").unwrap().shape, [3]);
    assert!(rows.column("height").unwrap().shape.is_empty() && rows.column("absent").is_none());
    for row in 0..rows.len() {
        seen.run(5).unwrap();
        let of = |name| rows.numbers(name).nth(row).unwrap().to_vec();
        let flat = |vectors: Vec<rattle::nalgebra::SVector<f64, 3>>| {
            vectors.iter().flat_map(|v| v.iter().copied()).collect::<Vec<_>>()
        };
        assert_eq!((rows.steps[row], rows.times[row]), (seen.steps(), seen.time()));
        assert_eq!(of("q"), flat(seen.positions().collect()));
        assert_eq!(of("p"), flat(seen.momenta().collect()));
        assert_eq!(of("energies"), [seen.kinetic_energy(), seen.potential_energy()]);
        assert_eq!(of("effect_energies"), seen.effect_energies());
        assert_eq!(of("effect_energies").len(), 2, "drag has no energy");
        let [one, half] = of("effect_energies")[..] else { panic!() };
        assert!((one + half - seen.potential_energy()).abs() < 1e-15 && (one - 2.0 * half).abs() < 1e-15);
        assert_eq!(of("residuals"), seen.residuals());
        assert_eq!(of("temperature"), [seen.temperature()]);
        assert_eq!(of("lambda"), seen.multipliers());
        assert_eq!(of("constraint_forces"), flat(seen.constraint_forces()));
        assert_eq!(of("height"), [seen.positions().next().unwrap().z]);
    }
}

#[test]
fn iterations_where_they_are_counted() {
    let columns = Columns::<2>::new().iterations();
    let scene = Scene::points(2).pin(0, [0.0, 0.0]).link(Rod { length: 1.0 }, [[0, 1]]);
    let start = State::of([[0.0, 0.0], [1.0, 0.0]]);
    let mut pendulum = scene.with(PlanarGravity { g: 1.0 }).simulate(start, Rattle::new(0.01)).unwrap();
    let mut recorder = Recorder::of(&columns, Rows::default());
    let mut counted = Vec::new();
    for _ in 0..5 {
        pendulum.observe(10, 10, &mut recorder).unwrap();
        counted.push(pendulum.counts().corrections as f64);
    }
    assert!(recorder.finish().unwrap().numbers("iterations").flatten().eq(&counted) && counted[4] >= 50.0);
    let mut recorder = Recorder::of(&Columns::new().iterations(), Rows::default());
    ring(2).observe(10, 10, &mut recorder).unwrap();
    assert!(recorder.finish().unwrap().numbers("iterations").flatten().all(|x| x.is_nan()));
}

#[test]
fn at_given_times_and_no_others() {
    let mut simulation = ring(1);
    let columns = Columns::new().at_times([0.255, 0.1, 0.37, 99.0]);
    let mut recorder = Recorder::of(&columns, Rows::default());
    simulation.observe(50, 1, &mut recorder).unwrap();
    assert_eq!(recorder.finish().unwrap().times, [0.1, 0.26, 0.37]);
}

/// A lane's columns are those of a simulation, to the rounding of ten steps.
#[test]
fn columns_of_lanes_are_those_of_simulations() {
    let scene = Scene::on(Torus { major: 2.0, minor: 0.7 }).with(Gravity { g: 1.0 }).with(Gravity { g: 0.5 });
    let columns = Columns::<3>::new().energies().effect_energies().residuals().temperature().multipliers();
    let start = State::at([2.7, 0.0, 0.0]).moving([0.0, 0.3, 0.4]);
    let mut lanes = scene.ensemble(vec![start.clone(); 9], Rattle::new(0.01)).unwrap();
    let lanes = lanes.observe(10, 5, || Recorder::of(&columns, Rows::default())).finish().unwrap();
    let mut alone = scene.simulate(start, Rattle::new(0.01)).unwrap();
    let mut recorder = Recorder::of(&columns, Rows::default());
    alone.observe(10, 5, &mut recorder).unwrap();
    let alone = recorder.finish().unwrap();
    let sizes =
        [("energies", 2), ("effect_energies", 2), ("temperature", 1), ("lambda", 1), ("residuals", 1)];
    for (name, size) in sizes {
        let lanes: Vec<_> = lanes.numbers(name).collect();
        let alone: Vec<_> = alone.numbers(name).flat_map(|row| [row; 9]).collect();
        assert_eq!((lanes.len(), alone.len()), (18, 18), "{name}");
        for (lane, simulation) in lanes.iter().zip(&alone) {
            let apart = lane.iter().zip(*simulation).map(|(a, b)| (a - b).abs()).fold(0.0, larger);
            // g here has terms up to 117.
            assert!([lane.len(), simulation.len()] == [size; 2] && apart < 1e-13, "{name}: {lane:?}");
        }
    }
}

#[test]
fn ensembles_by_trajectory_for_any_number_of_threads() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let columns = Columns::new().positions().energies();
    let record = |threads: usize| {
        let mut ensemble = scene
            .ensemble(directions().chain(directions()).chain(directions()).map(billiard), Rattle::new(0.01))
            .unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| ensemble.observe(40, 10, || Recorder::of(&columns, Rows::default())))
            .finish()
            .unwrap()
    };
    let rows = record(1);
    assert_eq!(rows.len(), 4 * 75);
    assert_eq!(record(2), rows);
    let row = (0..rows.len()).find(|&row| rows.trajectories[row] == 70 && rows.steps[row] == 30).unwrap();
    let mut one = scene.simulate(billiard(directions().nth(20).unwrap()), Rattle::new(0.01)).unwrap();
    one.run(30).unwrap();
    let q = rows.numbers("q").nth(row).unwrap();
    assert!(distance(one.position(), <[f64; 3]>::try_from(q).unwrap()) < 1e-13);
}

/// Takes so many rows.
struct Full(u64);

impl Writer for Full {
    fn write(&mut self, rows: &Rows) -> io::Result<()> {
        self.0 = self.0.checked_sub(rows.len() as u64).ok_or(io::ErrorKind::StorageFull)?;
        Ok(())
    }
    fn finish(self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn what_cannot_be_written_ends_the_run_and_leaves_it_as_it_was() {
    let (mut simulation, mut alone) = (ring(2), ring(2));
    let stream = Stream::to(Full(3000));
    let mut recorder = Recorder::of(&Columns::new().energies(), stream.sink());
    let error = simulation.observe(1_000_000, 1, &mut recorder).unwrap_err();
    assert!(matches!(error, Error::Recorder { .. }), "{error}");
    assert!(error.to_string().contains("the writer had taken 2048 rows, then"), "{error}");
    let steps = simulation.steps();
    assert!((3072..100_000).contains(&steps), "{steps}"); // what waited for the writer was handed on
    alone.run(steps).unwrap();
    assert_eq!(bits(&simulation.state()), bits(&alone.state()));
    simulation.step().unwrap();
    assert_eq!(recorder.finish().unwrap_err(), error);
    let error = stream.finish().unwrap_err();
    assert_eq!((error.rows, error.source.kind()), (2048, io::ErrorKind::StorageFull));
}

/// By the method's kind in lanes, in three groups, or each by itself: all stop after the same step, as if they had been
/// told to, and can go on.
#[test]
#[cfg(long)]
fn what_cannot_be_written_ends_an_ensemble_at_one_time() {
    fn check(method: impl Method, trajectories: usize, steps: u64, every: u64) {
        let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
        let starts = || (0..6).flat_map(|_| directions()).map(billiard).take(trajectories);
        let mut ensemble = scene.ensemble(starts(), method.clone()).unwrap();
        let stream = Stream::to(Full(3000));
        let columns = Columns::new().positions();
        let recorder = ensemble.observe(steps, every, || Recorder::of(&columns, stream.sink()));
        let error = recorder.finish().unwrap_err();
        assert!(matches!(error, Error::Recorder { .. }), "{error}");
        assert_eq!(stream.finish().unwrap_err().source.kind(), io::ErrorKind::StorageFull);
        let taken = ensemble.steps();
        assert!(taken < steps && taken.is_multiple_of(64), "{taken}");
        let mut other = scene.ensemble(starts(), method).unwrap();
        other.run(taken);
        for further in [0, 10] {
            ensemble.run(further);
            other.run(further);
            for trajectory in 0..ensemble.len() {
                let states = [&ensemble, &other].map(|ensemble| bits(&ensemble.state(trajectory)));
                assert_eq!(states[0], states[1], "{trajectory} after {further}");
            }
        }
    }
    check(Rattle::new(1e-3), 150, 50_000, 10);
    check(Dop853::new(1e-4), 3, 9_000, 1);
}

#[cfg(target_os = "linux")] // of `/dev/full`
#[test]
fn a_full_disk() {
    let stream = Stream::to(Xyz::to(File::create("/dev/full").unwrap(), "X"));
    let mut recorder = Recorder::of(&Columns::new().positions(), stream.sink());
    let ended = ring(2).observe(20_000, 1, &mut recorder).and_then(|()| recorder.finish());
    let error = stream.finish().unwrap_err();
    assert_eq!(error.source.kind(), io::ErrorKind::StorageFull);
    assert!(ended.unwrap_err().to_string().contains("No space left on device"));
    let stream = Stream::to(Parquet::create("/dev/full").unwrap());
    let mut recorder = Recorder::of(&Columns::new().positions(), stream.sink());
    ring(2).observe(2000, 1, &mut recorder).and_then(|()| recorder.finish()).unwrap(); // they wait for a group
    assert_eq!(stream.finish().unwrap_err().source.kind(), io::ErrorKind::StorageFull);
}

/// Columns of positions are called `q_0_0` there, and so on.
#[test]
fn names_in_parquet_are_not_taken_twice() {
    let folder = tempfile::tempdir().unwrap();
    let stream = Stream::to(Parquet::create(folder.path().join("twice.parquet")).unwrap());
    let columns = Columns::new().positions().quantity("q_0_0", |now: &Sight<'_, 3>| now.position().x);
    let mut recorder = Recorder::of(&columns, stream.sink());
    let ended = ring(2).observe(10, 1, &mut recorder).and_then(|()| recorder.finish().map(drop));
    let told = stream.finish().map(drop).unwrap_err().to_string();
    assert!(told.contains("two columns would be called `q_0_0`"), "{told}, {ended:?}");
}

/// A start is a row where it is asked for, in each trajectory; times that are those of the start are met by it.
#[test]
fn a_start_is_a_row_where_it_is_asked_for() {
    let table = |columns: Columns<3>| {
        let mut recorder = Recorder::of(&columns, Rows::default());
        ring(2).observe(4, 2, &mut recorder).unwrap();
        recorder.finish().unwrap()
    };
    let plain = Columns::new().positions();
    let (without, with) = (table(plain.clone()), table(plain.clone().with_start()));
    assert_eq!((&without.steps[..], &with.steps[..]), (&[2, 4][..], &[0, 2, 4][..]));
    assert_eq!(with.numbers[6..], without.numbers);
    assert_eq!(with.numbers[0], 2.7, "{with:?}");
    assert_eq!(table(plain.clone().at_times([0.0, 0.03])).times, [0.0, 0.04]);
    assert_eq!(table(plain.clone().at_times([0.03])).times, [0.04]);

    let starts = (0..70).map(|i| State::at([1.0, 0.0, 0.0]).moving([0.0, 0.01 * f64::from(i), 0.0]));
    let mut ensemble = Scene::on(Sphere { r: 1.0 }).ensemble(starts, Rattle::new(0.01)).unwrap();
    let columns = plain.with_start();
    let rows = ensemble.observe(4, 2, || Recorder::of(&columns, Rows::default())).finish().unwrap();
    assert_eq!((rows.len(), rows.steps.iter().filter(|&&step| step == 0).count()), (210, 70));
}

/// What writes into memory that a test can look at while the run goes on.
#[derive(Clone, Default)]
struct Shared(std::sync::Arc<std::sync::Mutex<Vec<u8>>>);

impl io::Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().extend(bytes);
        Ok(bytes.len())
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Shared {
    fn frames(&self) -> usize {
        String::from_utf8(self.0.lock().unwrap().clone()).unwrap().matches("Time=").count()
    }
}

/// Rows are in the file after a flush, at each save of a run that flushes, and after a recorder was dropped; a stream
/// that ends before its recorder is an error.
#[test]
fn no_row_is_lost_without_a_word() {
    let columns = Columns::<3>::new().positions();
    let to = Shared::default();
    let stream = Stream::to(Xyz::to(to.clone(), "X"));
    let mut recorder = Recorder::of(&columns, stream.sink());
    let mut run = ring(2);
    run.observe(30, 1, &mut recorder).unwrap();
    assert_eq!(to.frames(), 0);
    recorder.flush().unwrap();
    assert_eq!(to.frames(), 30);

    let folder = tempfile::tempdir().unwrap();
    let saving = Saving::to(folder.path().join("run.rattle")).every(25);
    let mut seen = Vec::new();
    let ended = saving.run_to_by(&mut run, 117, 10, |run, steps, every| {
        seen.push((run.steps(), saving.path().exists(), to.frames()));
        run.observe(steps, every, &mut recorder)?;
        recorder.flush()
    });
    assert_eq!(ended.unwrap(), Ended::Done);
    // Multiples of 25 are met by the next multiple of ten.
    assert_eq!(seen, [(30, false, 30), (50, true, 32), (80, true, 35), (100, true, 37)]);
    run.observe(3, 1, &mut recorder).unwrap();
    drop(recorder);
    assert_eq!((stream.finish().unwrap(), to.frames()), (41, 41));

    let stream = Stream::to(Xyz::to(Shared::default(), "X"));
    let mut recorder = Recorder::of(&columns, stream.sink());
    ring(2).observe(3, 1, &mut recorder).unwrap();
    let error = stream.finish().unwrap_err();
    assert!(error.to_string().contains("taken 0 rows, then: a recorder still has rows"), "{error:?}");
    assert_eq!(format!("{error:?}"), error.to_string(), "a program that ends with it says the same");
    assert!(recorder.finish().is_err());
}

/// A run that ended at a step that is no multiple has, gone on with, the rows of a run that never ended.
#[test]
fn a_restart_has_the_rows_of_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let rows = |targets: &[u64]| {
        let saving = Saving::to(folder.path().join(format!("{targets:?}"))).every(500);
        let mut all = Vec::new();
        for &target in targets {
            let (mut run, mut recorder) =
                (ring(2), Recorder::of(&Columns::<3>::new().positions(), Rows::default()));
            saving.restore(&mut run).unwrap();
            let take = |run: &mut _, steps, every| Simulation::observe(run, steps, every, &mut recorder);
            assert_eq!(saving.run_to_by(&mut run, target, 100, take).unwrap(), Ended::Done);
            let rows = recorder.finish().unwrap();
            all.extend(rows.steps.iter().copied().zip(rows.numbers("q").map(<[f64]>::to_vec)));
        }
        all
    };
    let whole = rows(&[1000]);
    assert_eq!(whole.len(), 10);
    for targets in [&[250, 1000][..], &[250, 280, 1000], &[99, 100, 101, 600, 1000]] {
        assert_eq!(rows(targets), whole, "{targets:?}");
    }
}

/// Two columns of one name, and words that would break a file.
#[test]
fn names_are_names() {
    for columns in [
        Columns::<3>::new().positions().quantity("q", |_| 0.0),
        Columns::new().quantity("t", |_| 0.0),
        Columns::new().quantity("", |_| 0.0),
    ] {
        let mut recorder = Recorder::of(&columns, Rows::default());
        let mut run = ring(2);
        let error = run.observe(1000, 1, &mut recorder).unwrap_err();
        assert!(
            error.to_string().contains("a name of its own") && run.steps() <= 1,
            "{error} at {}",
            run.steps()
        );
    }
    let folder = tempfile::tempdir().unwrap();
    assert!(Xyz::create(folder.path().join("a.xyz"), "my atom").is_err());
    let to = Shared::default();
    let stream = Stream::to(Xyz::to(to.clone(), "X"));
    let columns = Columns::<3>::new().positions().quantity("my = \"value\"", |_| 7.0);
    let mut recorder = Recorder::of(&columns, stream.sink());
    ring(1).observe(1, 1, &mut recorder).unwrap();
    recorder.finish().unwrap();
    stream.finish().unwrap();
    let text = String::from_utf8(to.0.lock().unwrap().clone()).unwrap();
    assert!(text.contains(" my____value_=\"7.0\""), "{text}");
}

/// Python with these packages, of the path or of `target/foreign`; says so where there is none.
pub(crate) fn python(packages: &str) -> Option<PathBuf> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/foreign/bin/python");
    let able = |python: &PathBuf| {
        let import = Command::new(python).args(["-c", &format!("import {packages}")]).output();
        import.is_ok_and(|output| output.status.success())
    };
    let found = [own, "python3".into()].into_iter().find(able);
    if found.is_none() {
        say(&format!("LEFT OUT: no python3 with {packages}"));
    }
    found
}

pub(crate) fn read_by(python: &Path, code: &str, file: &Path) -> Vec<f64> {
    let output = Command::new(python).args(["-c", code]).arg(file).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    text.split_whitespace().map(|number| number.parse().unwrap()).collect()
}

/// Records into a file and into memory.
fn both(writer: impl Writer, steps: u64) -> Rows {
    let stream = Stream::to(writer);
    let mut recorder =
        (Recorder::of(&everything(), stream.sink()), Recorder::of(&everything(), Rows::default()));
    ring(3).observe(steps, 1, &mut recorder).unwrap();
    recorder.0.finish().unwrap();
    assert_eq!(stream.finish().unwrap(), steps);
    recorder.1.finish().unwrap()
}

#[test]
fn numpy_reads_what_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.npz");
    let rows = both(NpzParts::create(&path).unwrap(), 1000); // three blocks, which are one part
    let Some(python) = python("numpy") else { return };
    let code = "import numpy, sys\nf = numpy.load(sys.argv[1])\n\
        whole = lambda c: numpy.concatenate([f[k] for k in sorted(f) if k.rpartition('.')[0] == c])\n\
        assert whole('q').shape == (1000, 3, 3) and whole('height').shape == (1000,) and len(f) == 12\n\
        for c in ['t', 'q', 'lambda']: print(*(repr(float(x)) for x in whole(c).ravel()))";
    let read = read_by(&python, code, &path);
    let of = |name| rows.numbers(name).flatten().copied();
    let expected: Vec<f64> = rows.times.iter().copied().chain(of("q")).chain(of("lambda")).collect();
    assert!(read == expected);
}

#[test]
#[cfg(long)]
fn ase_reads_extended_xyz() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.xyz");
    let rows = both(Xyz::create(&path, "Ar").unwrap(), 7);
    let text = fs::read_to_string(&path).unwrap();
    assert_eq!(text.lines().count(), 7 * 5);
    let Some(python) = python("ase.io") else { return };
    let code = "import ase.io, sys\nframes = ase.io.read(sys.argv[1], ':', format='extxyz')\n\
        assert len(frames) == 7 and frames[0].get_chemical_symbols() == ['Ar'] * 3\n\
        for a in frames:\n  print(a.info['Time'], a.info['Step'], a.info['height'])\n  \
        print(*(repr(float(x)) for x in a.positions.ravel()), *(repr(float(x)) for x in a.arrays['momenta'].ravel()))";
    let read = read_by(&python, code, &path);
    let mut expected = Vec::new();
    for row in 0..7 {
        expected.extend([rows.times[row], rows.steps[row] as f64]);
        for name in ["height", "q", "p"] {
            expected.extend(rows.numbers(name).nth(row).unwrap());
        }
    }
    assert_eq!(read, expected);
}

#[test]
#[cfg(long)]
fn arrow_reads_parquet() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deep/run.parquet");
    let steps = 40_000; // 34 numbers a row: a group, and another
    let rows = both(Parquet::create(&path).unwrap(), steps);
    let none = folder.path().join("none.parquet");
    Stream::to(Parquet::create(&none).unwrap()).finish().unwrap();
    let Some(python) = python("pyarrow.parquet") else { return };
    let code = "import pyarrow.parquet as p, sys\nf = p.ParquetFile(sys.argv[1])\nt = f.read()\n\
        assert f.num_row_groups > 1 and t.column('step').to_pylist() == list(range(1, 40001))\n\
        assert set(t.column('trajectory').to_pylist()) == {0}\n\
        for c in ['t', 'q_0_0', 'q_2_1', 'lambda_1', 'height', 'energies_1']:\n  \
        print(*(repr(x) for x in t.column(c).to_pylist()))";
    let read = read_by(&python, code, &path);
    let of = |name, number: usize| rows.numbers(name).map(move |row| row[number]);
    let expected = rows.times.iter().copied().chain(of("q", 0)).chain(of("q", 7)).chain(of("lambda", 1));
    assert!(expected.chain(of("height", 0)).chain(of("energies", 1)).eq(read));
    let code = "import pyarrow.parquet as p, sys\nt = p.read_table(sys.argv[1])\n\
        print(t.num_rows, *(int(name in ['step', 'trajectory', 't']) for name in t.column_names))";
    assert_eq!(read_by(&python, code, &none), [0.0, 1.0, 1.0, 1.0]);
}

#[test]
#[cfg(long)]
fn meshio_reads_points_with_vectors_and_their_surface() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.pvd");
    let torus = Torus { major: 2.0, minor: 0.7 };
    let mesh = Mesh::around(surface(&torus), [2.7, 0.0, 0.0], 20).unwrap();
    let rows = both(Vtu::create(&path).unwrap().beside("torus", &mesh.to_vtu()).unwrap(), 4);
    let index = fs::read_to_string(&path).unwrap();
    for (row, time) in rows.times.iter().enumerate() {
        for (part, file) in [format!("run_{row:06}.vtu"), "run_torus.vtu".into()].iter().enumerate() {
            let entry = format!("<DataSet timestep=\"{time:?}\" part=\"{part}\" file=\"{file}\"/>");
            assert!(index.contains(&entry), "{index}");
        }
    }
    let Some(python) = python("meshio") else { return };
    let code = "import meshio, sys\nm = meshio.read(sys.argv[1])\nassert len(m.cells_dict['vertex']) == 3\n\
        for a in [m.points, m.point_data['momentum'], m.point_data['constraint force']]:\n  \
        print(*(repr(float(x)) for x in a.ravel()))";
    for row in 0..4 {
        let of = |name| rows.numbers(name).nth(row).unwrap().to_vec();
        let read = read_by(&python, code, &folder.path().join(format!("run_{row:06}.vtu")));
        assert_eq!(read, [of("q"), of("p"), of("constraint_forces")].concat());
    }
    let code = "import meshio, sys\nm = meshio.read(sys.argv[1])\nprint(m.cells_dict['triangle'].sum())\n\
        for a in [m.points, m.point_data['normal']]:\n  print(*(repr(float(x)) for x in a.ravel()))";
    let read = read_by(&python, code, &folder.path().join("run_torus.vtu"));
    assert_eq!(read[0], mesh.triangles.as_flattened().iter().map(|&i| f64::from(i)).sum::<f64>());
    assert_eq!(read[1..], [mesh.vertices.as_flattened(), mesh.normals.as_flattened()].concat());
}

/// The bar is drawn by an observer that is one like all others; here is no terminal.
#[test]
fn a_bar_beside_a_recorder() {
    let mut seen = (Recorder::of(&Columns::new(), Rows::default()), rattle::progress::bar(10));
    ring(1).observe(100, 10, &mut seen).unwrap();
    assert_eq!(seen.0.finish().unwrap().len(), 10);
}

/// The most memory that this program has had, in KiB.
fn most_memory() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with("VmHWM")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}

/// `cargo test --release --test files recorders:: -- --ignored a_billion_steps --nocapture`
#[test]
#[ignore = "takes minutes"]
fn a_billion_steps_in_flat_memory() {
    let folder = tempfile::tempdir().unwrap();
    let stream = Stream::to(NpzParts::create(folder.path().join("run.npz")).unwrap());
    let mut simulation = Scene::on(SURFACE).simulate(billiard_45(), Rattle::new(0.01)).unwrap();
    let mut recorder = Recorder::of(&Columns::new().positions().momenta().energies(), stream.sink());
    simulation.observe(20_000_000, 100, &mut recorder).unwrap(); // two parts: all memory that is ever taken
    let before = most_memory();
    simulation.observe(980_000_000, 1_000, &mut recorder).unwrap(); // ten more
    recorder.finish().unwrap();
    assert_eq!(stream.finish().unwrap(), 1_180_000);
    let after = most_memory();
    println!("{} steps: {before} KiB after two per cent, {after} KiB at the end", simulation.steps());
    assert!(after - before < 1024);
}

/// What recording every 100th step costs: `cargo test --release --test files recorders:: -- --ignored throughput
/// --nocapture --test-threads 1`. No test, a measurement: ratios to a run that records nothing, in the same round.
#[test]
#[ignore = "measures time"]
fn throughput() {
    const STEPS: u64 = 5_000_000; // 0.4 s: making files and completing them is not seen
    const OF_ALL: u64 = 10 * STEPS;
    type Row<'a> = (&'a str, usize, &'a dyn Fn());
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let columns = Columns::new().positions().momenta().energies();
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let timed = |(_, without, run): Row<'_>| {
        let now = std::time::Instant::now();
        run();
        now.elapsed().as_secs_f64() * 1e9 / if without == 0 { STEPS as f64 } else { OF_ALL as f64 }
    };
    let simulation = || scene.simulate(billiard_45(), Rattle::new(0.01)).unwrap();
    let into = |stream: Stream| {
        let mut recorder = Recorder::of(&columns, stream.sink());
        simulation().observe(STEPS, 100, &mut recorder).unwrap();
        recorder.finish().unwrap();
        stream.finish().unwrap();
    };
    let memory = || {
        let mut recorder = Recorder::of(&columns, Rows::default());
        simulation().observe(STEPS, 100, &mut recorder).unwrap();
        assert_eq!(recorder.finish().unwrap().len() as u64, STEPS / 100);
    };
    let ensemble =
        || scene.ensemble((0..40).flat_map(|_| directions()).map(billiard), Rattle::new(0.01)).unwrap();
    let each = OF_ALL / ensemble().len() as u64;
    let ensemble_into = |stream: Stream| {
        ensemble().observe(each, 100, || Recorder::of(&columns, stream.sink())).finish().unwrap();
        stream.finish().unwrap();
    };
    let ensemble_in_memory = || {
        let rows =
            ensemble().observe(each, 100, || Recorder::of(&columns, Rows::default())).finish().unwrap();
        assert_eq!(rows.len() as u64, OF_ALL / 100);
    };
    let rows: [Row<'_>; 9] = [
        ("simulation", 0, &|| simulation().run(STEPS).unwrap()),
        ("  into memory", 0, &memory),
        ("  NpzParts", 0, &|| into(Stream::to(NpzParts::create(path("run.npz")).unwrap()))),
        ("  Xyz", 0, &|| into(Stream::to(Xyz::create(path("run.xyz"), "X").unwrap()))),
        ("  Parquet", 0, &|| into(Stream::to(Parquet::create(path("run.parquet")).unwrap()))),
        ("ensemble", 5, &|| ensemble().run(each)),
        ("  into memory", 5, &ensemble_in_memory),
        ("  NpzParts", 5, &|| ensemble_into(Stream::to(NpzParts::create(path("all.npz")).unwrap()))),
        ("  Parquet", 5, &|| ensemble_into(Stream::to(Parquet::create(path("all.parquet")).unwrap()))),
    ];
    let rounds: Vec<[f64; 9]> = (0..9).map(|_| rows.map(timed)).collect();
    let median = |mut numbers: Vec<f64>| {
        numbers.sort_by(f64::total_cmp);
        numbers[numbers.len() / 2]
    };
    println!("every 100th step        ns a step   of one without");
    for (i, (name, without, _)) in rows.iter().enumerate() {
        let ns = median(rounds.iter().map(|round| round[i]).collect());
        let ratio = median(rounds.iter().map(|round| round[i] / round[*without]).collect());
        println!("{name:22} {ns:10.1} {ratio:16.3}");
    }
}
