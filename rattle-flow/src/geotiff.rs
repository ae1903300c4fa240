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
const UNITS: u16 = 3076;
const SIZE_OF_UNIT: u16 = 3077;
const UNITS_OF_HEIGHTS: u16 = 4099;
const UNDEFINED: u16 = 0;
const METRE: u16 = 9001;
const OF_A_USER: u16 = 32767;
const METRES: [&str; 6] = ["", "m", "metre", "metres", "meter", "meters"];
/// What GDAL says of bands, as XML.
const METADATA: Tag = Tag::Unknown(42112);

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
    let mut is_metre = false;
    if let (Some(OF_A_USER), Some(place)) = (key(UNITS), key(SIZE_OF_UNIT)) {
        let numbers = optional(file.get_tag_f64_vec(Tag::GeoDoubleParamsTag))?.unwrap_or_default();
        is_metre = numbers.get(usize::from(place)) == Some(&1.0);
    }
    if let Some(unit) = key(UNITS).filter(|unit| !is_metre && ![METRE, UNDEFINED].contains(unit)) {
        let unit = named(unit);
        return Err(refused(&format!(
            "coordinates in {unit}; `gdalwarp -t_srs EPSG:…` puts them into metres, and leaves heights as they are"
        )));
    }
    if let Some(unit) = key(UNITS_OF_HEIGHTS).filter(|unit| ![METRE, UNDEFINED].contains(unit)) {
        let unit = named(unit);
        return Err(refused(&format!(
            "heights in {unit}; `gdalwarp -t_srs EPSG:…+…`, with a vertical system in metres after the `+`, puts them \
             into metres"
        )));
    }
    if let Some(metadata) = optional(file.get_tag_ascii_string(METADATA))? {
        check_band(&metadata)?;
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

/// A unit of length by its number in EPSG.
fn named(unit: u16) -> String {
    match unit {
        9002 => "feet (EPSG:9002)".into(),
        9003 => "US survey feet (EPSG:9003)".into(),
        OF_A_USER => "a unit that is none of EPSG".into(),
        other => format!("the unit EPSG:{other}"),
    }
}

/// Refuses heights that are other than the numbers in the file: by a scale, an offset or a unit of the first band.
fn check_band(metadata: &str) -> Result<(), ReadError> {
    for item in metadata.split("<Item").skip(1) {
        let Some((head, rest)) = item.split_once('>') else { continue };
        let value = rest.split('<').next().unwrap_or("").trim();
        if attribute(head, "sample") != Some("0") {
            continue; // of the file as a whole, or of another band
        }
        let plain = match attribute(head, "role") {
            Some("scale") => 1.0,
            Some("offset") => 0.0,
            Some("unittype") if METRES.iter().any(|metres| value.eq_ignore_ascii_case(metres)) => continue,
            Some("unittype") => {
                return Err(refused(&format!(
                    "heights in `{value}`; `gdal_calc.py --calc=0.3048*A -A in.tif --outfile=out.tif` puts feet into \
                     metres"
                )));
            }
            _ => continue,
        };
        if value.parse() != Ok(plain) {
            return Err(refused(&format!(
                "heights with {} {value}; `gdal_translate -unscale -ot Float64` writes them as they are",
                if plain == 1.0 { "a scale of" } else { "an offset of" }
            )));
        }
    }
    Ok(())
}

/// What stands in quotes after the name of an attribute.
fn attribute<'a>(head: &'a str, name: &str) -> Option<&'a str> {
    let (_, rest) = head.split_once(&format!(" {name}="))?;
    let quote = rest.chars().next().filter(|quote| ['"', '\''].contains(quote))?;
    rest[1..].split(quote).next()
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

#[cfg(test)]
mod tests {
    use super::*;
    use tiff::encoder::{TiffEncoder, colortype::Gray32Float};

    /// Two rows of three heights with these keys, of which sizes of units stand in `numbers`, and with what GDAL says.
    fn file(keys: &[[u16; 2]], numbers: &[f64], metadata: &str) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let mut file = TiffEncoder::new(&mut bytes).unwrap();
        let mut image = file.new_image::<Gray32Float>(3, 2).unwrap();
        let mut list = vec![1, 1, 0, keys.len() as u16];
        for &[key, value] in keys {
            let (place, count) = if key == 3077 { (34736, 1) } else { (0, 1) };
            list.extend([key, place, count, value]);
        }
        let to = image.encoder();
        to.write_tag(Tag::GeoKeyDirectoryTag, &list[..]).unwrap();
        to.write_tag(Tag::ModelPixelScaleTag, &[10.0, 10.0, 0.0][..]).unwrap();
        to.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, 500.0, 700.0, 0.0][..]).unwrap();
        if !numbers.is_empty() {
            to.write_tag(Tag::GeoDoubleParamsTag, numbers).unwrap();
        }
        if !metadata.is_empty() {
            to.write_tag(Tag::Unknown(42112), metadata).unwrap();
        }
        image.write_data(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).unwrap();
        bytes.into_inner()
    }

    fn item(attributes: &str, value: &str) -> String {
        format!("<GDALMetadata>\n  <Item name=\"X\" {attributes}>{value}</Item>\n</GDALMetadata>\n")
    }

    #[test]
    fn metres_are_read() {
        for keys in [&[][..], &[[3076, 9001], [4099, 9001]], &[[3076, 0], [4099, 0]]] {
            assert_eq!(parse(&file(keys, &[], "")).unwrap().height([505.0, 695.0]), 1.0, "{keys:?}");
        }
        // A unit of a user that is one metre; the key says where its size stands.
        let of_a_user = [[3076, 32767], [3077, 1]];
        assert!(parse(&file(&of_a_user, &[7.0, 1.0], "")).is_ok());
        let plain = [
            item("sample=\"0\" role=\"scale\"", "1"),
            item("sample=\"0\" role=\"offset\"", " 0.0 "),
            item("sample=\"0\" role=\"unittype\"", "metre"),
            item("sample=\"0\" role=\"unittype\"", "Meters"),
            item("sample=\"1\" role=\"scale\"", "0.1"), // of a band that is not there
            item("", "0.1"),
            "<Item sample=\"0\" role=\"scale".into(),
        ];
        for metadata in plain {
            assert!(parse(&file(&[], &[], &metadata)).is_ok(), "{metadata}");
        }
    }

    #[test]
    fn what_is_not_in_metres_is_refused_with_advice() {
        let told = |file: Vec<u8>, words: [&str; 2]| {
            let error = parse(&file).unwrap_err();
            assert!(matches!(error, ReadError::GeoTiff { .. }));
            assert!(words.iter().all(|words| error.to_string().contains(words)), "{error}");
        };
        let keys = |keys: &[[u16; 2]], size: f64| file(keys, &[size], "");
        told(keys(&[[3076, 9003]], 1.0), ["coordinates in US survey feet", "`gdalwarp -t_srs EPSG:…`"]);
        told(keys(&[[3076, 9036]], 1.0), ["coordinates in the unit EPSG:9036", "`gdalwarp"]);
        told(keys(&[[3076, 32767]], 1.0), ["none of EPSG", "`gdalwarp"]);
        told(keys(&[[3076, 32767], [3077, 0]], 0.3), ["none of EPSG", "`gdalwarp"]);
        let metres = [3076, 9001];
        told(keys(&[metres, [4099, 9002]], 1.0), ["heights in feet (EPSG:9002)", "`gdalwarp"]);
        told(keys(&[metres, [4099, 32767]], 1.0), ["heights in a unit that is none", "`gdalwarp"]);
        let band =
            |role: &str, value: &str| file(&[], &[], &item(&format!("sample=\"0\" role=\"{role}\""), value));
        told(band("scale", "0.1"), ["a scale of 0.1", "`gdal_translate -unscale"]);
        told(band("offset", "1000"), ["an offset of 1000", "`gdal_translate -unscale"]);
        told(band("scale", "much"), ["a scale of much", "`gdal_translate -unscale"]);
        told(band("unittype", "ft"), ["heights in `ft`", "`gdal_calc.py"]);
    }
}
