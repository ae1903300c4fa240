//! Archives: what goes in comes out, bit for bit, in Rust and in NumPy.

use rand::{RngExt, SeedableRng, rngs::StdRng};
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
    check(create().array(&"n".repeat(70_000), &[1], &[0.0]).unwrap_err(), &["wrong.npz", "less than 64KiB"]);
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
        crate::common::say("LEFT OUT: no python3 with numpy");
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
    let cases: [(&[u8], &[u8], &str); 10] = [
        (b"\x93NUMPY",      b"\x93NUMPX",      "does not begin like an .npy file"),
        (b"NUMPY\x01",      b"NUMPY\x09",      "version 9"),
        (b"'shape':",       b"'shapo':",       "no 'shape'"),
        (b"'descr':",       b"'descr';",       "no 'descr'"),
        (b"(2, 3), }",      b"(2, x), }",      "no tuple"),
        (b"(2, 3), }",      b"(9, 9), }",      "array `q`: "), // more values than there are
        (b"(2, 3), }     ", b"(2, 30000000000),}", "array `q`: "),
        (b"(2, 3), }",      b"(1, 3), }",      ""), // fewer
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

/// One array in a container without compression, whose checksum is right whatever the array's header says.
fn container(array: &[u8]) -> Vec<u8> {
    let bit = |crc: u32, _| (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg());
    let crc = !array.iter().fold(!0, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), bit));
    let size = u32::try_from(array.len()).unwrap();
    let numbers = |numbers: &[u32]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<_>>();
    let entry = [&[0; 10][..], &numbers(&[crc, size, size]), &[5, 0, 0, 0]].concat(); // a name of five bytes
    let local = [&b"PK\x03\x04"[..], &entry, b"q.npy", array].concat();
    let at = u32::try_from(local.len()).unwrap();
    let central = [&b"PK\x01\x02\0\0"[..], &entry, &[0; 14], b"q.npy"].concat();
    let long = u32::try_from(central.len()).unwrap();
    let end = [&b"PK\x05\x06\0\0\0\0\x01\0\x01\0"[..], &numbers(&[long, at]), &[0; 2]].concat();
    [local, central, end].concat()
}

/// An array of six values by version 2 of the format, which has four bytes for the length of its header.
fn array(length: Option<u32>, header: &str) -> Vec<u8> {
    let length = length.unwrap_or(u32::try_from(header.len()).unwrap()).to_le_bytes();
    let values = [0.5_f64; 6].map(f64::to_le_bytes).concat();
    [&b"\x93NUMPY\x02\0"[..], &length, header.as_bytes(), &values].concat()
}

/// What comes of a file, and that no more memory is taken for it than its size allows: 64 bytes for each of its own,
/// beside what buffers take.
fn read_within_bounds(path: &Path, file: &[u8]) -> Result<rattle::data::Array, DataError> {
    fs::write(path, file).unwrap();
    let mut result = None;
    let memory = allocation_counter::measure(|| result = Some(read(path, "q")));
    let allowed = 100_000 + 64 * file.len() as u64;
    assert!(memory.bytes_max <= allowed, "{} bytes for a file of {}", memory.bytes_max, file.len());
    result.unwrap()
}

/// The container is whole, so that nothing but the array's reader can see the lie.
#[test]
fn headers_that_lie_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.npz");
    let shaped = |shape: &str| format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
    let read = |length, header: &str| read_within_bounds(&path, &container(&array(length, header)));
    let truth = read(None, &shaped("(2, 3)")).unwrap();
    assert_eq!((truth.shape, truth.data), (vec![2, 3], vec![0.5; 6]));
    for (shape, words) in [
        ("(2, 4)", "says 8 values, and it ends after 6"),
        ("(9000000000000000000,)", "it ends after 6"),
        ("(2, 2)", "says 4 values, and 16 bytes follow them"),
        ("(0, 3)", "says 0 values, and 48 bytes follow them"),
        ("()", "says 1 values, and 40 bytes follow them"),
        ("(4294967296, 4294967296)", "too large"),
        ("(18446744073709551615, 2)", "too large"),
        ("(18446744073709551616,)", "no tuple of counts"),
        ("(-2, -3)", "no tuple of counts"),
        ("(2.0, 3)", "no tuple of counts"),
        ("(2, 3", "no tuple of counts"),
        ("6", "no tuple of counts"),
    ] {
        let message = read(None, &shaped(shape)).expect_err(shape).to_string();
        let told = message.contains("run.npz") && message.contains("array `q`") && message.contains(words);
        assert!(told, "{shape}: {message}");
    }
    for (length, words) in [
        (u32::MAX, "a header of 4294967295 bytes"),
        (65_535, "ends after 0"),
        (3, "no 'descr'"),
        (0, "no 'descr'"),
    ] {
        let message = read(Some(length), &shaped("(2, 3)")).expect_err("a length").to_string();
        assert!(message.contains(words), "{length}: {message}");
    }
    for kind in ["<f4", "<i8", "<c16", "|O", "<f80", "|V8", ""] {
        let header = shaped("(2, 3)").replace("<f8", kind);
        let error = read(None, &header).expect_err(kind);
        assert!(matches!(error, DataError::Layout { .. }), "{kind}: {error}");
    }
}

/// A file of one array, of which some bytes are others, or missing, or there twice.
fn damaged(random: &mut StdRng) -> Vec<u8> {
    let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }";
    let shapes = [
        "(6,)", "(2, -3)", "(2,, 3)", "(99999999999, 3)", "(1, 2, 3)", "False", "'<f8'", "((2, 3))",
        "(\u{fffd},)",
    ];
    let header = match random.random_range(0..3) {
        0 => header.replace("(2, 3)", shapes[random.random_range(0..shapes.len())]),
        _ => header.into(),
    };
    let mut array = array(None, &header);
    let mut damage = |bytes: &mut Vec<u8>| {
        for _ in 0..random.random_range(0..4) {
            let at = random.random_range(0..bytes.len());
            match random.random_range(0..6) {
                0 => bytes[at] = random.random_range(0..=255),
                1 => bytes[at] ^= 1 << random.random_range(0..8),
                2 => bytes.truncate(at + 1),
                3 => bytes.insert(at, random.random_range(0..=255)),
                4 => {
                    let to = random.random_range(at..=bytes.len().min(at + 30));
                    let again = bytes[at..to].to_vec();
                    bytes.splice(at..at, again);
                }
                _ => {
                    let end = bytes.len().min(at + 4);
                    let value = *[0, 1, 0x7f, 0xff].get(random.random_range(0..4_usize)).unwrap();
                    bytes[at..end].fill(value); // counts and sizes that are large
                }
            }
        }
    };
    damage(&mut array);
    let mut file = container(&array);
    damage(&mut file);
    file
}

/// How many files of so many were read, and how many were errors.
fn read_damaged(first: u64, count: u64) -> [u64; 2] {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.npz");
    let mut outcomes = [0; 2];
    for seed in first..first + count {
        let file = damaged(&mut StdRng::seed_from_u64(seed));
        match read_within_bounds(&path, &file) {
            Ok(array) => {
                let values: usize = array.shape.iter().product();
                assert_eq!(values, array.data.len(), "file {seed}");
                outcomes[0] += 1;
            }
            Err(error) => {
                let message = error.to_string();
                assert!(message.contains("run.npz") && message.len() > 12, "file {seed}: {message}");
                outcomes[1] += 1;
            }
        }
    }
    outcomes
}

#[test]
fn random_damage_is_an_array_or_an_error() {
    let [read, errors] = read_damaged(0, 2000);
    assert!(read > 100 && errors > 1000, "{read} arrays, {errors} errors"); // both are met
}

/// ```text
/// cargo test --release --test files data:: -- --ignored --nocapture
/// ```
#[test]
#[ignore = "a minute"]
fn random_damage_a_million_times() {
    println!("{:?} arrays and errors", read_damaged(1 << 32, 1_000_000));
}
