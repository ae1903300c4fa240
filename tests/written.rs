//! What other programs read: numbers that are none in `.vtu`, names and species in extended XYZ, tables as text.

use crate::recorders::{python, read_by};
use base64::prelude::{BASE64_STANDARD, Engine};
use rattle::Error;
use rattle::prelude::*;
use rattle::record::{Csv, Stream, Writer, Xyz};
use rattle::vtu::{Cells, Field, Series, text};
use rattle::watch::{Columns, Recorder, Rows};
use std::fs::{self, File};
use std::io;
use std::path::Path;

/// The numbers of an array, as a reader of VTK's files takes them: words, or a length in bytes with the bytes.
fn numbers(text: &str, name: &str) -> Vec<f64> {
    let after = text.split(&format!("Name=\"{name}\"")).nth(1).unwrap();
    let (tag, rest) = after.split_once('>').unwrap();
    let content = rest.split('<').next().unwrap().trim();
    if tag.contains("format=\"ascii\"") {
        return content.split_whitespace().map(|word| word.parse().unwrap()).collect();
    }
    assert!(tag.contains("format=\"binary\"") && text.contains("header_type=\"UInt64\""), "{text}");
    let bytes = BASE64_STANDARD.decode(content).unwrap();
    let (length, bytes) = bytes.split_first_chunk().unwrap();
    assert_eq!(u64::from_le_bytes(*length), bytes.len() as u64);
    bytes.as_chunks().0.iter().map(|&eight| f64::from_le_bytes(eight)).collect()
}

/// Words such as `NaN` and `inf` end an array for VTK: where a number is none, the array is bytes.
#[test]
fn what_is_no_number_is_read_back_too() {
    let folder = tempfile::tempdir().unwrap();
    let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.0, 5e-324, f64::MAX, 0.1];
    for n in 1..=odd.len() {
        let plain: Vec<f64> = (0..n).map(|i| 0.1 + i as f64).collect();
        let points: Vec<[f64; 3]> = plain.iter().map(|&x| [x, 0.0, 0.0]).collect();
        let turned: Vec<[f64; 3]> = odd[..n].iter().map(|&x| [1.0, x, 2.0]).collect();
        let fields = [
            Field::number("odd", &odd[..n]),
            Field::number("plain", &plain),
            Field::vector("turned", &turned),
            Field::number("last", &plain),
        ];
        let written = text(&points, &Cells::Points, &fields, &[]);
        assert!(!written.contains("NaN") && !written.contains("inf"), "{written}");
        assert!(written.contains("Name=\"plain\" NumberOfComponents=\"1\" format=\"ascii\""), "{written}");
        let bits = |numbers: &[f64]| numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        for (name, wanted) in [("odd", &odd[..n]), ("plain", &plain), ("turned", turned.as_flattened())] {
            assert_eq!(bits(&numbers(&written, name)), bits(wanted), "{name} of {n}");
        }
        let path = folder.path().join("odd.vtu");
        fs::write(&path, written).unwrap();
        let wanted = [&odd[..n], turned.as_flattened(), &plain].concat();
        read_elsewhere(&path, &wanted);
    }
}

/// By meshio and by VTK itself, where they are installed.
fn read_elsewhere(path: &Path, wanted: &[f64]) {
    let by_meshio = "import meshio, sys\nd = meshio.read(sys.argv[1]).point_data\n";
    let by_vtk = "import sys\nfrom vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader as R\n\
        from vtkmodules.util.numpy_support import vtk_to_numpy as n\nr = R()\nr.SetFileName(sys.argv[1])\n\
        r.Update()\np = r.GetOutput().GetPointData()\nd = {k: n(p.GetArray(k)) for k in ['odd', 'turned', 'last']}\n";
    let print = "import struct\nfor k in ['odd', 'turned', 'last']:\n  \
        print(*(h for x in d[k].ravel() for h in struct.unpack('<2I', struct.pack('<d', x))))";
    for (package, read) in [("meshio", by_meshio), ("vtkmodules.vtkIOXML", by_vtk)] {
        let Some(python) = python(package) else { continue };
        let halves: Vec<f64> = read_by(&python, &format!("{read}{print}"), path);
        let found: Vec<u64> =
            halves.as_chunks().0.iter().map(|&[low, high]| low as u64 | (high as u64) << 32).collect();
        assert_eq!(found, wanted.iter().map(|x| x.to_bits()).collect::<Vec<_>>(), "by {package}");
    }
}

/// Digits are the names of the files of the series itself.
#[test]
fn what_lies_beside_a_series_is_not_named_by_a_number() {
    let folder = tempfile::tempdir().unwrap();
    let mut series = Series::create(folder.path().join("run")).unwrap();
    let error = series.beside("000000", "surface").unwrap_err();
    assert!(error.to_string().contains("digits"), "{error}");
    assert!(!folder.path().join("run_000000.vtu").exists());
    series.beside("torus 2", "surface").unwrap();
    series.add(0.0, "first").unwrap();
    assert_eq!(fs::read_to_string(folder.path().join("run_torus 2.vtu")).unwrap(), "surface");
}

/// Two bodies that are free, with a quantity of each name.
fn xyz(xyz: Xyz<fs::File>, names: &[String]) -> Result<u64, String> {
    let columns = names.iter().enumerate().fold(Columns::<3>::new().positions(), |columns, (i, name)| {
        columns.quantity(name, move |_| i as f64)
    });
    let stream = Stream::to(xyz);
    let mut recorder = Recorder::of(&columns, stream.sink());
    let start = State::of([[0.5; 3], [0.25; 3]]);
    let mut simulation = Scene::points(2).simulate(start, Rattle::new(0.1)).unwrap();
    let _ = simulation.observe(2, 1, &mut recorder).and_then(|()| recorder.finish());
    stream.finish().map_err(|error| error.to_string())
}

/// What would quote, group or divide in a line is not in its keys.
#[test]
fn keys_of_extended_xyz_are_words() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.xyz");
    let odd: Vec<char> = "'\"{}[]()\\= \t\n".chars().collect();
    let names: Vec<String> = odd.iter().enumerate().map(|(i, odd)| format!("a{odd}{odd}b{i}")).collect();
    assert_eq!(xyz(Xyz::create(&path, "Ar").unwrap(), &names), Ok(2));
    let text = fs::read_to_string(&path).unwrap();
    let line = text.lines().nth(1).unwrap();
    for i in 0..odd.len() {
        assert!(line.contains(&format!(" a__b{i}=\"{i}.0\"")), "{line}");
    }
    let Some(python) = python("ase.io") else { return };
    let code = "import ase.io, sys\na = ase.io.read(sys.argv[1], 1, format='extxyz')\n\
        print(*(a.info['a__b' + str(i)] for i in range(13)), a.info['Step'])";
    let wanted: Vec<f64> = (0..13).map(f64::from).chain([2.0]).collect();
    assert_eq!(read_by(&python, code, &path), wanted);
}

/// Each body has a species of its own, where they are told; a list of another length is an error.
#[test]
fn bodies_of_extended_xyz_have_their_species() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.xyz");
    let with = |species: &[&str]| Xyz::create(&path, "X").unwrap().species(species);
    assert_eq!(xyz(with(&["Na", "Cl"]).unwrap(), &[]), Ok(2));
    let text = fs::read_to_string(&path).unwrap();
    assert_eq!(text.matches("\nNa 0.5 0.5 0.5\nCl 0.25 0.25 0.25\n").count(), 2, "{text}");
    let told = xyz(with(&["Na", "Cl", "Na"]).unwrap(), &[]).unwrap_err();
    assert!(told.contains("3 species for 2 bodies"), "{told}");
    assert!(with(&["Na", "my atom"]).unwrap_err().to_string().contains("one word"));
}

/// Two bodies that are free, on their way from numbers that have many digits.
fn two_bodies() -> Simulation<impl rattle::system::System<f64, 3>, Rattle, 3> {
    let start = State::of([[0.1, 1.0 / 3.0, -1e-300], [1e9, -0.0, 0.7]]);
    let start = start.with_momenta([[1.0 / 7.0, -2.0, 1e-3], [0.0, 5e-324, 3.0]]);
    Scene::points(2).simulate(start, Rattle::new(0.1)).unwrap()
}

/// Numbers as text are the numbers, bit for bit, whatever they are, and names are read as they were given.
#[test]
fn a_table_of_text_is_read_back_bit_for_bit() {
    let odd = [
        ("plain", f64::NAN),
        ("a,b", f64::INFINITY),
        ("\"quoted\"", f64::NEG_INFINITY),
        ("a b", -0.0),
        ("µ", 5e-324),
        ("#", 0.1 + 0.2),
    ];
    let columns = Columns::<3>::new().positions().momenta().energies();
    let columns = odd.iter().fold(columns, |columns, &(name, x)| columns.quantity(name, move |_| x));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deep/run.csv");
    let stream = Stream::to(Csv::create(&path).unwrap());
    let mut seen = (Recorder::of(&columns, stream.sink()), Recorder::of(&columns, Rows::default()));
    two_bodies().observe(2000, 1, &mut seen).unwrap(); // two blocks
    seen.0.finish().unwrap();
    assert_eq!(stream.finish().unwrap(), 2000);
    let rows = seen.1.finish().unwrap();

    let mut wanted = Vec::new();
    let width = rows.numbers.len() / rows.len();
    for (row, numbers) in rows.numbers.chunks(width).enumerate() {
        wanted.extend([rows.steps[row] as f64, rows.trajectories[row] as f64, rows.times[row]]);
        wanted.extend(numbers);
    }
    let same = |found: &[f64], by: &str| {
        let other = found.iter().zip(&wanted).position(|(a, b)| a.to_bits() != b.to_bits());
        assert_eq!((found.len(), other.map(|i| (i, found[i]))), (wanted.len(), None), "by {by}");
    };
    let mut reader = csv::Reader::from_path(&path).unwrap();
    let of_two = |name: &str| [0, 1].map(|body| [0, 1, 2].map(|i| format!("{name}_{body}_{i}"))).concat();
    let names = [
        ["step", "trajectory", "t"].map(String::from).to_vec(),
        of_two("q"),
        of_two("p"),
        vec!["energies_0".into(), "energies_1".into()],
        odd.iter().map(|(name, _)| (*name).to_string()).collect(),
    ];
    assert_eq!(reader.headers().unwrap().iter().collect::<Vec<_>>(), names.concat());
    let read: Vec<f64> = reader
        .records()
        .flat_map(|row| row.unwrap().iter().map(|x| x.parse().unwrap()).collect::<Vec<_>>())
        .collect();
    same(&read, "csv");

    let print =
        "import struct\nprint(*(h for x in a.ravel() for h in struct.unpack('<2I', struct.pack('<d', x))))";
    for (package, read) in [
        ("numpy", "a = numpy.loadtxt(sys.argv[1], delimiter=',', skiprows=1)"),
        ("pandas", "a = pandas.read_csv(sys.argv[1], float_precision='round_trip').to_numpy(dtype=float)"),
    ] {
        let Some(python) = python(package) else { continue };
        let code = format!("import {package}, sys\n{read}\n{print}");
        let halves: Vec<f64> = read_by(&python, &code, &path);
        let found: Vec<f64> = halves
            .as_chunks()
            .0
            .iter()
            .map(|&[low, high]| f64::from_bits(low as u64 | (high as u64) << 32))
            .collect();
        same(&found, package);
    }
}

/// A line of names is one line, and what it says holds for all that follows.
#[test]
fn a_table_of_text_has_one_line_of_names() {
    let told = |of: &[&Columns<3>]| {
        let stream = Stream::to(Csv::to(Vec::new()));
        for columns in of {
            let mut recorder = Recorder::of(columns, stream.sink());
            let _ = two_bodies().observe(2, 1, &mut recorder).and_then(|()| recorder.finish());
        }
        stream.finish().map_err(|error| error.to_string())
    };
    let plain = Columns::<3>::new().positions();
    assert_eq!(told(&[&plain, &plain]), Ok(4));
    let twice = plain.clone().quantity("q_0_0", |_| 1.0);
    assert!(told(&[&twice]).unwrap_err().contains("two columns would be called `q_0_0`"));
    let error = told(&[&plain, &plain.clone().momenta()]).unwrap_err();
    assert!(error.contains("the writer had taken 2 rows, then: rows have other columns"), "{error}");
}

/// Rows are whole lines in the file after a flush.
#[test]
fn rows_of_text_are_in_the_file_after_a_flush() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    let stream = Stream::to(Csv::create(&path).unwrap());
    let mut recorder = Recorder::of(&Columns::<3>::new().energies(), stream.sink());
    let lines = || fs::read_to_string(&path).unwrap().matches('\n').count();
    two_bodies().observe(30, 1, &mut recorder).unwrap();
    assert_eq!(lines(), 0);
    recorder.flush().unwrap();
    assert_eq!(lines(), 31);
    recorder.finish().unwrap();
    assert_eq!((stream.finish().unwrap(), lines()), (30, 31));
}

/// A file that looks at each piece that is written to it.
struct Pieces<F>(F);

impl<F: Fn(&str)> io::Write for Pieces<F> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        (self.0)(std::str::from_utf8(bytes).unwrap());
        Ok(bytes.len())
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A program that is killed leaves whole lines and whole frames, since nothing else is handed to the system.
#[test]
fn pieces_of_text_are_whole() {
    let columns = Columns::<3>::new().positions().constraint_forces();
    let record = |stream: Stream| {
        let mut recorder = Recorder::of(&columns, stream.sink());
        two_bodies().observe(2000, 1, &mut recorder).unwrap();
        recorder.finish().unwrap();
        assert_eq!(stream.finish().unwrap(), 2000);
    };
    record(Stream::to(Csv::to(Pieces(|text: &str| assert!(text.ends_with('\n'), "{text}")))));
    record(Stream::to(Xyz::to(
        Pieces(|text: &str| {
            let lines: Vec<_> = text.lines().collect();
            for frame in lines.chunks(4) {
                assert!(frame.len() == 4 && frame[0] == "2", "{text}");
                assert!(
                    frame[1].starts_with("Properties=species:S:1:pos:R:3:constraint_forces:R:3 "),
                    "{text}"
                );
                assert!(frame[2..].iter().all(|line| line.split(' ').count() == 7), "{text}");
            }
        }),
        "X",
    )));
}

/// A writer that panics is not taken for a stream that was finished.
#[test]
fn a_writer_that_panics_is_told() {
    struct Hasty(u64);
    impl Writer for Hasty {
        fn write(&mut self, rows: &Rows) -> io::Result<()> {
            assert!(self.0 == 0, "more than one block");
            self.0 += rows.len() as u64;
            Ok(())
        }
        fn finish(self) -> io::Result<()> {
            Ok(())
        }
    }
    let stream = Stream::to(Hasty(0));
    let mut recorder = Recorder::of(&Columns::<3>::new().positions(), stream.sink());
    let ended = two_bodies().observe(100_000, 1, &mut recorder).and_then(|()| recorder.finish());
    assert!(matches!(&ended, Err(Error::Recorder { why, .. }) if why.contains("panicked")), "{ended:?}");
    let error = stream.finish().unwrap_err();
    assert!(error.rows > 0 && error.to_string().contains("the writer panicked"), "{error}");
}

#[cfg(unix)]
#[test]
fn a_full_disk_ends_a_table_of_text() {
    let stream = Stream::to(Csv::to(File::create("/dev/full").unwrap()));
    let mut recorder = Recorder::of(&Columns::<3>::new().positions(), stream.sink());
    let ended = two_bodies().observe(20_000, 1, &mut recorder).and_then(|()| recorder.finish());
    assert!(matches!(&ended, Err(Error::Recorder { why, .. }) if why.contains("No space left")), "{ended:?}");
    assert_eq!(stream.finish().unwrap_err().source.kind(), io::ErrorKind::StorageFull);
}
