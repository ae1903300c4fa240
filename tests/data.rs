//! Archives: what goes in comes out, bit for bit, in Rust and in NumPy.

use rattle::data::{DataError, Npz, read};
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
