//! Terrain as a GeoTIFF: one band of heights, north up, on square cells in metres.

use crate::raster::Raster;
use crate::read::ReadError;
use std::io::Cursor;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;
use tiff::{TiffError, TiffFormatError};

/// Heights of at most so many bytes, as they lie in the file.
const LARGEST: usize = 4 << 30;
/// Sides of a cell that differ by less than this part are the same.
const SQUARE: f64 = 1e-9;
/// Keys of GeoTIFF, and what they may say (OGC 19-008, 7.1).
const MODEL: u16 = 1024;
const GEOGRAPHIC: u16 = 2;
const PIXEL_IS: u16 = 1025;
const POINT: u16 = 2;

/// Whether a file begins as TIFF does, or as its form for large files.
pub(crate) fn is_tiff(bytes: &[u8]) -> bool {
    [b"II\x2a\0", b"MM\0\x2a", b"II\x2b\0", b"MM\0\x2b"].iter().any(|magic| bytes.starts_with(*magic))
}

pub(crate) fn parse(bytes: &[u8]) -> Result<Raster, ReadError> {
    let mut limits = Limits::default();
    (limits.decoding_buffer_size, limits.intermediate_buffer_size) = (LARGEST, LARGEST);
    let mut file = Decoder::new(Cursor::new(bytes)).map_err(wrong)?.with_limits(limits);
    let (columns, rows) = file.dimensions().map_err(wrong)?;
    let keys = optional(file.get_tag_u16_vec(Tag::GeoKeyDirectoryTag))?.unwrap_or_default();
    let key = |wanted| keys.as_chunks::<4>().0.iter().skip(1).find(|key| key[0] == wanted).map(|key| key[3]);
    if key(MODEL) == Some(GEOGRAPHIC) {
        return Err(refused("coordinates in degrees; `gdalwarp -t_srs EPSG:…` puts them into metres"));
    }
    let scale = optional(file.get_tag_f64_vec(Tag::ModelPixelScaleTag))?;
    let tie = optional(file.get_tag_f64_vec(Tag::ModelTiepointTag))?;
    let (Some([cell, height, ..]), Some([i, j, _, x, y, _])) = (scale.as_deref(), tie.as_deref()) else {
        return Err(refused("no cell size and no one point of the map; `gdalwarp` makes rasters north up"));
    };
    let is_square = (cell - height).abs() <= SQUARE * cell && *cell > 0.0 && cell.is_finite();
    if !(is_square && x.is_finite() && y.is_finite()) {
        return Err(refused(&format!("cells of {cell} by {height}; `gdalwarp -tr` makes them square")));
    }
    // The point of the map lies at a corner of a cell, or in its middle.
    let middle = if key(PIXEL_IS) == Some(POINT) { 0.0 } else { 0.5 };
    let none = optional(file.get_tag_ascii_string(Tag::GdalNodata))?;
    let none = none.and_then(|text| text.trim_matches(['\0', ' ']).parse::<f64>().ok());
    let mut heights: Vec<f64> = match file.read_image().map_err(wrong)? {
        DecodingResult::U8(heights) => heights.into_iter().map(f64::from).collect(),
        DecodingResult::I8(heights) => heights.into_iter().map(f64::from).collect(),
        DecodingResult::U16(heights) => heights.into_iter().map(f64::from).collect(),
        DecodingResult::I16(heights) => heights.into_iter().map(f64::from).collect(),
        DecodingResult::U32(heights) => heights.into_iter().map(f64::from).collect(),
        DecodingResult::I32(heights) => heights.into_iter().map(f64::from).collect(),
        DecodingResult::F32(heights) => heights.into_iter().map(f64::from).collect(),
        DecodingResult::F64(heights) => heights,
        _ => return Err(refused("heights of another kind than 8 to 32 bits and real numbers")),
    };
    let (columns, rows) = (columns as usize, rows as usize);
    if columns.checked_mul(rows) != Some(heights.len()) || heights.is_empty() {
        return Err(refused("several bands; `gdal_translate -b 1` takes the first"));
    }
    if let Some(none) = none {
        let is_none = |height: f64| height == none || height == f64::from(none as f32); // as it was rounded
        heights.iter_mut().filter(|height| is_none(**height)).for_each(|height| *height = f64::NAN);
    }
    let first = [x + (middle - i) * cell, y - (middle - j + (rows - 1) as f64) * cell];
    Ok(Raster { columns, rows, first, cell: *cell, heights })
}

fn refused(what: &str) -> ReadError {
    ReadError::GeoTiff { what: what.into() }
}

fn wrong(error: TiffError) -> ReadError {
    refused(&error.to_string())
}

/// Nothing where there is no such tag.
fn optional<T>(tag: Result<T, TiffError>) -> Result<Option<T>, ReadError> {
    match tag {
        Ok(value) => Ok(Some(value)),
        Err(TiffError::FormatError(TiffFormatError::RequiredTagNotFound(_))) => Ok(None),
        Err(error) => Err(wrong(error)),
    }
}
