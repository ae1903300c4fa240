//! Archives: what goes in comes out, bit for bit, in Rust and in NumPy.

use rattle::data::{DataError, Npz, read};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Every kind of double; NaN is compared by its bits.
const VALUES: [f64; 6] = [0.0, -0.0, 1.0 / 3.0, f64::MIN_POSITIVE / 4.0, f64::NEG_INFINITY, f64::NAN];

fn write(path: &Path) {
    let npz = Npz::create(path).unwrap();
    let npz = npz.array("t", &[3], &[0.0, 0.5, 1.0]).unwrap().array("q", &[1, 2, 3], &VALUES).unwrap();
    npz.array("empty", &[0, 3], &[]).unwrap().array("scalar", &[], &[7.0]).unwrap().finish().unwrap();
}

#[test]
fn arrays_come_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("new/run.npz");
    write(&path);
    for (name, shape, data) in [
        ("t", vec![3], vec![0.0, 0.5, 1.0]),
        ("q", vec![1, 2, 3], VALUES.to_vec()),
        ("empty", vec![0, 3], vec![]),
        ("scalar", vec![], vec![7.0]),
    ] {
        let array = read(&path, name).unwrap();
        assert_eq!(array.shape, shape, "{name}");
        let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&array.data), bits(&data), "{name}");
    }
}

#[test]
fn errors_name_the_file_and_the_array() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.npz");
    write(&path);
    let create = || Npz::create(folder.path().join("wrong.npz")).unwrap();
    let check = |error: DataError, words: &[&str]| {
        let message = error.to_string();
        words.iter().for_each(|word| assert!(message.contains(word), "{message}: no `{word}`"));
    };
    check(create().array("q", &[2, 3], &[0.0; 5]).unwrap_err(), &["wrong.npz", "`q`", "[2, 3]", "6", "5"]);
    check(create().array("q", &[usize::MAX, 2], &[]).unwrap_err(), &["`q`", "too many"]);
    let twice = create().array("t", &[1], &[0.0]).unwrap().array("t", &[1], &[0.0]);
    check(twice.unwrap_err(), &["wrong.npz", "`t`", "twice"]);
    check(read(&path, "p").unwrap_err(), &["run.npz", "no array `p`"]);
    check(read(folder.path().join("none.npz"), "p").unwrap_err(), &["none.npz"]);
    check(Npz::create(path.join("below/a/file.npz")).unwrap_err(), &["below"]);
}

#[test]
fn numpy_reads_and_writes_the_same_files() {
    let python = |code: &str, path: &Path| Command::new("python3").args(["-c", code]).arg(path).output();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.npz");
    if !python("import numpy", &path).is_ok_and(|output| output.status.success()) {
        println!("skipped: no python3 with numpy");
        return;
    }
    write(&path);
    let code = "
import sys, numpy
f = numpy.load(sys.argv[1])
q = f['q']
assert sorted(f.files) == ['empty', 'q', 'scalar', 't'], f.files
assert q.shape == (1, 2, 3) and q.dtype == numpy.dtype('<f8') and q.flags.c_contiguous, q
assert q[0, 0, 2] == 1 / 3 and numpy.isnan(q[0, 1, 2]) and f['t'][1] == 0.5
assert f['empty'].shape == (0, 3) and f['scalar'] == 7
numpy.savez(sys.argv[1], a=numpy.arange(6.0).reshape(2, 3), turned=numpy.asfortranarray(numpy.eye(2)), whole=numpy.arange(3))
";
    let output = python(code, &path).unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let array = read(&path, "a").unwrap();
    assert_eq!((array.shape, array.data), (vec![2, 3], vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0]));
    for name in ["turned", "whole"] {
        assert!(matches!(read(&path, name), Err(DataError::Layout { .. })), "{name}");
    }
}

/// `tests/data/numpy.npz` was written by NumPy itself, so this needs no Python.
#[test]
fn files_of_numpy_are_read() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/numpy.npz");
    let counted = |n: u32| (0..n).map(f64::from).collect::<Vec<_>>();
    for (name, shape, data) in [
        ("plain", vec![2, 3], counted(6).iter().map(|x| x / 3.0).collect()),
        ("one", vec![3], vec![0.5, -0.0, 5e-324]),
        ("scalar", vec![], vec![7.0]),
        ("empty", vec![0, 3], vec![]),
        ("wide", vec![1, 2, 3, 4], counted(24)),
        ("second", vec![2], vec![1.0, 2.0]),
        ("third", vec![1], vec![3.0]),
        ("big", vec![2], vec![0.5, 1e300]),
    ] {
        let array = read(&path, name).unwrap();
        assert_eq!((array.shape, array.data), (shape, data), "{name}");
    }
    for name in ["turned", "whole", "single", "fields"] {
        assert!(matches!(read(&path, name), Err(DataError::Layout { .. })), "{name}");
    }
}

/// The very bytes that `numpy.save` writes for these arrays.
#[test]
fn the_header_is_numpys() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.npz");
    for (shape, tuple) in [(&[2, 3][..], "(2, 3)"), (&[6], "(6,)"), (&[0, 1_000_000], "(0, 1000000)")] {
        let data = vec![0.5; shape.iter().product()];
        Npz::create(&path).unwrap().array("q", shape, &data).unwrap().finish().unwrap();
        let file = fs::read(&path).unwrap();
        let text = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {tuple}, }}");
        let mut array = b"\x93NUMPY\x01\x00v\x00".to_vec();
        array.extend(format!("{text:<117}\n").bytes());
        assert_eq!(array.len(), 128);
        array.extend(data.iter().flat_map(|x| x.to_le_bytes()));
        assert!(
            file.windows(array.len()).any(|window| window == array),
            "{}",
            String::from_utf8_lossy(&file)
        );
    }
}

#[test]
fn damaged_files_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.npz");
    Npz::create(&path).unwrap().array("q", &[2, 3], &[0.5; 6]).unwrap().finish().unwrap();
    let whole = fs::read(&path).unwrap();
    #[rustfmt::skip]
    let cases: [(&[u8], &[u8], &str); 9] = [
        (b"\x93NUMPY",      b"\x93NUMPX",      "does not begin like an .npy file"),
        (b"NUMPY\x01",      b"NUMPY\x09",      "version 9"),
        (b"'shape':",       b"'shapo':",       "no 'shape'"),
        (b"'descr':",       b"'descr';",       "no 'descr'"),
        (b"(2, 3), }",      b"(2, x), }",      "no tuple"),
        (b"(2, 3), }",      b"(9, 9), }",      ""), // more values than there are
        (b"(2, 3), }     ", b"(2, 30000000000),}", ""),
        (b"v\x00{",         b"v\xff{",         ""), // a header longer than the file
        (b"\x00\x00\xe0\x3f", b"\x00\x00\xf0\x3f", "checksum"), // 0.5 becomes 1
    ];
    for (from, to, words) in cases {
        let at = whole.windows(from.len()).position(|window| window == from).unwrap();
        let mut file = whole.clone();
        file[at..at + to.len()].copy_from_slice(to);
        fs::write(&path, file).unwrap();
        let error = read(&path, "q").expect_err(&format!("{from:?} -> {to:?}"));
        assert!(matches!(error, DataError::Io { .. }), "{error:?}");
        let message = error.to_string();
        assert!(message.contains("run.npz") && message.contains(words), "{message}: no `{words}`");
    }
}
