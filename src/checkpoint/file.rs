//! Records as bytes, and files that appear whole or not at all.

use super::error::{CheckpointError, VERSION};
use rattle_core::motion::record::{Data, Field, Record};
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

const MAGIC: &[u8; 8] = b"\x89RATTLE\n";
/// Magic, version and length stand before the fields, and a check sum after them.
const HEAD: usize = 8 + 4 + 8;
const SUM: usize = 4;

/// So many links one after the other are followed, as Linux does.
const MOST_LINKS: usize = 40;

/// A record as the bytes of a file.
#[must_use]
pub fn encode(record: &Record) -> Vec<u8> {
    let mut fields = (record.fields().len() as u64).to_le_bytes().to_vec();
    for Field { name, shape, data } in record.fields() {
        fields.extend((name.len() as u32).to_le_bytes());
        fields.extend(name.as_bytes());
        fields.extend([kind(data), shape.len() as u8]);
        shape.iter().for_each(|&extent| fields.extend((extent as u64).to_le_bytes()));
        match data {
            Data::Numbers(numbers) => numbers.iter().for_each(|x| fields.extend(x.to_le_bytes())),
            Data::Counts(counts) => counts.iter().for_each(|x| fields.extend(x.to_le_bytes())),
            Data::Text(text) => fields.extend(text.as_bytes()),
        }
    }
    let mut bytes = MAGIC.to_vec();
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend((fields.len() as u64).to_le_bytes());
    bytes.extend(fields);
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    bytes
}

/// The record in the bytes of a file; `path` names the file in errors.
///
/// # Errors
/// [`CheckpointError`] for bytes that are no checkpoint, are of a later version, are cut off or have changed.
pub fn decode(bytes: &[u8], path: impl AsRef<Path>) -> Result<Record, CheckpointError> {
    let path = || path.as_ref().to_path_buf();
    let common = bytes.len().min(MAGIC.len());
    if bytes[..common] != MAGIC[..common] {
        return Err(CheckpointError::Foreign { path: path() });
    }
    let truncated = |of| CheckpointError::Truncated { path: path(), has: bytes.len() as u64, of };
    let damaged = |what| CheckpointError::Damaged { path: path(), what };
    let mut rest = Bytes(&bytes[common..]);
    let head = rest.u32().zip(rest.u64()).ok_or_else(|| truncated((HEAD + SUM) as u64));
    if let Some(version) = Bytes(&bytes[common..]).u32().filter(|&version| version > VERSION) {
        return Err(CheckpointError::Version { path: path(), version });
    }
    let (version, length) = head?;
    if version == 0 {
        return Err(damaged("its version is 0"));
    }
    let whole = length.checked_add((HEAD + SUM) as u64).ok_or_else(|| damaged("its length is none"))?;
    if (bytes.len() as u64) < whole {
        return Err(truncated(whole));
    }
    if bytes.len() as u64 > whole {
        return Err(damaged("more bytes follow than it says"));
    }
    let (content, sum) = bytes.split_at(bytes.len() - SUM);
    if crc32fast::hash(content).to_le_bytes() != sum {
        return Err(damaged("its check sum is another"));
    }
    fields(Bytes(&content[HEAD..])).map(Record::of).ok_or_else(|| damaged("its fields are none"))
}

/// Writes a record to a file. If that fails, an old file of this name is unchanged.
///
/// # Errors
/// [`CheckpointError::Io`].
pub fn write(record: &Record, path: impl AsRef<Path>) -> Result<(), CheckpointError> {
    let path = path.as_ref();
    put(path, &encode(record)).map_err(|source| CheckpointError::Io { path: path.into(), source })
}

/// Reads a record from a file.
///
/// # Errors
/// [`CheckpointError`] says what is wrong with the file.
pub fn read(path: impl AsRef<Path>) -> Result<Record, CheckpointError> {
    let path = path.as_ref();
    let failed = |source| CheckpointError::Io { path: path.into(), source };
    let mut file = File::open(path).map_err(failed)?;
    let mut bytes = Vec::new();
    Read::by_ref(&mut file).take(HEAD as u64).read_to_end(&mut bytes).map_err(failed)?;
    let head = decode(&bytes, path);
    let Err(CheckpointError::Truncated { of, .. }) = head else { return head };
    // No more is read than the head promises, and nothing where it promises more than there is: a file may be endless.
    let metadata = file.metadata().map_err(failed)?;
    if metadata.is_file() && metadata.len() < of {
        return Err(CheckpointError::Truncated { path: path.into(), has: metadata.len(), of });
    }
    file.take(of.saturating_add(1).saturating_sub(HEAD as u64)).read_to_end(&mut bytes).map_err(failed)?;
    decode(&bytes, path)
}

/// Makes missing folders, and fails where a record cannot be written to this file. What the file has stays.
pub(super) fn make_way(path: &Path) -> Result<(), CheckpointError> {
    let tried = path.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| {
        let (_, beside) = places(path)?;
        File::create(&beside)?;
        fs::remove_file(&beside)
    });
    tried.map_err(|source| CheckpointError::Io { path: path.into(), source })
}

/// Writes beside the file, syncs, renames, and syncs the folder.
fn put(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let (place, beside) = places(path)?;
    let written = fill(&beside, bytes).and_then(|()| fs::rename(&beside, &place));
    if let Err(error) = written {
        let _ = fs::remove_file(&beside); // which may not be there
        return Err(error);
    }
    sync_folder(&place);
    Ok(())
}

/// Where the file is, and where it is written before it gets its name.
fn places(path: &Path) -> io::Result<(PathBuf, PathBuf)> {
    let place = behind_links(path)?;
    if fs::metadata(&place).is_ok_and(|found| !found.is_file()) {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "there is something that is no plain file"));
    }
    let Some(name) = place.file_name() else {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "the path names no file"));
    };
    let mut beside = name.to_os_string();
    beside.push(".part");
    let beside = place.with_file_name(beside);
    Ok((place, beside))
}

/// Where a file is or is to be: a link stays one, also before it leads to a file.
fn behind_links(path: &Path) -> io::Result<PathBuf> {
    let mut place = path.to_path_buf();
    for _ in 0..=MOST_LINKS {
        let Ok(next) = fs::read_link(&place) else { return Ok(place) };
        place = place.with_file_name(next); // which may begin at the root
    }
    Err(io::Error::other("links lead round, or too many follow each other"))
}

fn fill(beside: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = File::create(beside)?;
    file.write_all(bytes)?;
    file.sync_all()
}

/// Has the new name outlast a crash of the system, where folders can be opened and synced: the file is in place, with
/// this or without.
fn sync_folder(place: &Path) {
    let folder = place.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = File::open(folder.unwrap_or_else(|| Path::new(".")));
    let _ = folder.and_then(|folder| folder.sync_all());
}

fn kind(data: &Data) -> u8 {
    match data {
        Data::Numbers(_) => 0,
        Data::Counts(_) => 1,
        Data::Text(_) => 2,
    }
}

fn fields(mut rest: Bytes<'_>) -> Option<Vec<Field>> {
    let number = rest.u64()?;
    let mut fields = Vec::new();
    for _ in 0..number {
        let length = rest.u32()? as usize;
        let name = String::from_utf8(rest.take(length)?.to_vec()).ok()?;
        let [kind, indices] = rest.array()?;
        let mut shape = Vec::new();
        for _ in 0..indices {
            shape.push(usize::try_from(rest.u64()?).ok()?);
        }
        let values = shape.iter().try_fold(1_usize, |all, &extent| all.checked_mul(extent))?;
        let data = match kind {
            0 => Data::Numbers(rest.eights(values)?.map(f64::from_le_bytes).collect()),
            1 => Data::Counts(rest.eights(values)?.map(u64::from_le_bytes).collect()),
            2 => Data::Text(String::from_utf8(rest.take(values)?.to_vec()).ok()?),
            _ => return None,
        };
        fields.push(Field { name, shape, data });
    }
    rest.0.is_empty().then_some(fields)
}

/// Bytes that are taken in turn.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, number: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(number)?;
        self.0 = rest;
        Some(taken)
    }
    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.try_into().ok()
    }
    fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }
    fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }
    fn eights(&mut self, number: usize) -> Option<impl Iterator<Item = [u8; 8]> + 'a> {
        let eights = self.take(number.checked_mul(8)?)?.as_chunks().0;
        Some(eights.iter().copied())
    }
}
