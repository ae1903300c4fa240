//! One array in NumPy's file format (NEP 1; versions 1.0 to 3.0 are read, 1.0 is written).
//!
//! ```text
//! "\x93NUMPY", version, length of the text   8 bytes and 2 for the length (4 from version 2.0 on)
//! {'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }   padded, so that the values begin at a multiple of 64
//! the values
//! ```

use std::io::{self, BufRead, BufReader, BufWriter, ErrorKind, Read, Write};

const MAGIC: &[u8; 6] = b"\x93NUMPY";
/// Magic, version and length in version 1.0.
const PREFIX: usize = 10;
/// The values begin at a multiple of it.
const ALIGNMENT: usize = 64;
/// The longest text that is read: what version 1.0 can say; longer ones describe records.
pub(super) const LONGEST_TEXT: u32 = u16::MAX as u32;

/// Writes the array; `data` runs with the last index fastest.
pub(super) fn write(file: impl Write, shape: &[usize], data: &[f64]) -> io::Result<()> {
    let extents = match shape {
        [one] => format!("{one},"), // Python's tuple of one
        _ => shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", "),
    };
    let text = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({extents}), }}");
    let length = (PREFIX + text.len() + 1).next_multiple_of(ALIGNMENT) - PREFIX;
    let bytes = u16::try_from(length).map_err(|_| broken("too many indices"))?.to_le_bytes();

    let mut file = BufWriter::new(file);
    file.write_all(MAGIC)?;
    file.write_all(&[1, 0, bytes[0], bytes[1]])?;
    writeln!(file, "{text:<0$}", length - 1)?;
    for value in data {
        file.write_all(&value.to_le_bytes())?;
    }
    file.flush()
}

/// Reads shape and values; `None` when the array is not `f64` in C order. Reads to the end of the file.
pub(super) fn read(file: impl Read) -> io::Result<Option<(Vec<usize>, Vec<f64>)>> {
    let mut file = BufReader::new(file);
    let text = header(&mut file)?;
    let value = |key| value(&text, key).ok_or_else(|| broken(&format!("no {key} in the header")));
    let [descr, order, shape] = [value("'descr'")?, value("'fortran_order'")?, value("'shape'")?];

    let number = match descr.get(..5) {
        Some("'<f8'") => f64::from_le_bytes,
        Some("'>f8'") => f64::from_be_bytes,
        _ => return Ok(None),
    };
    if !order.starts_with("False") {
        return Ok(None);
    }
    let shape = extents(shape).ok_or_else(|| broken("the header's shape is no tuple of counts"))?;
    let count = shape.iter().try_fold(1, |size: usize, &n| size.checked_mul(n));
    let count = count.ok_or_else(|| broken("the header's shape is too large"))?;

    let mut data = Vec::new(); // grows with what is there, whatever the header says
    let mut bytes = [0; 8];
    for _ in 0..count {
        file.read_exact(&mut bytes).map_err(|error| match error.kind() {
            ErrorKind::UnexpectedEof => {
                broken(&format!("its header says {count} values, and it ends after {}", data.len()))
            }
            _ => error,
        })?;
        data.push(number(bytes));
    }
    match io::copy(&mut file, &mut io::sink())? {
        // at the end the container compares its checksum
        0 => Ok(Some((shape, data))),
        more => Err(broken(&format!("its header says {count} values, and {more} bytes follow them"))),
    }
}

/// The text of the header, with single quotes only: Python takes both.
fn header(file: &mut impl BufRead) -> io::Result<String> {
    let mut start = [0; 8];
    file.read_exact(&mut start)?;
    if &start[..6] != MAGIC {
        return Err(broken("it does not begin like an .npy file"));
    }
    let mut length = [0; 4];
    match start[6] {
        1 => file.read_exact(&mut length[..2])?,
        2 | 3 => file.read_exact(&mut length)?,
        version => return Err(broken(&format!("version {version} of the format"))),
    }
    let length = u32::from_le_bytes(length);
    if length > LONGEST_TEXT {
        return Err(broken(&format!("a header of {length} bytes")));
    }
    let mut text = Vec::new();
    file.take(length.into()).read_to_end(&mut text)?;
    Ok(String::from_utf8_lossy(&text).replace('"', "'"))
}

/// What follows the key and its colon.
fn value<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    let behind = |(start, _)| text[start + key.len()..].trim_start().strip_prefix(':');
    text.match_indices(key).find_map(behind).map(str::trim_start)
}

/// The numbers of a tuple: `()`, `(3,)`, `(2, 3)`.
fn extents(tuple: &str) -> Option<Vec<usize>> {
    let (inside, _) = tuple.strip_prefix('(')?.split_once(')')?;
    inside.split(',').map(str::trim).filter(|n| !n.is_empty()).map(|n| n.parse().ok()).collect()
}

fn broken(what: &str) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, format!("not an array that can be read or written: {what}"))
}
