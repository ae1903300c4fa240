//! Terrain as a GeoTIFF: one band of heights, north up, on square cells in metres.

mod units;

use crate::raster::{HUGE, Raster, is_none};
use crate::read::ReadError;
use std::collections::HashSet;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use tiff::decoder::{ChunkType, Decoder, DecodingResult, Limits};
use tiff::tags::{CompressionMethod, Tag};
use tiff::{ColorType, TiffError, TiffFormatError, TiffUnsupportedError};
use units::Keys;

/// Heights of at most so many bytes, as they lie in the file, and as they are read.
const LARGEST: usize = 4 << 30;
/// Sides of a cell that differ by less than this part are the same.
const SQUARE: f64 = 1e-9;
/// What GDAL says of bands, as XML.
const METADATA: Tag = Tag::Unknown(42112);
const METRES: [&str; 6] = ["", "m", "metre", "metres", "meter", "meters"];
/// The bit of `NewSubfileType` that marks a mask.
const MASK: u32 = 4;

type File<'a> = Decoder<Cursor<&'a [u8]>>;

/// Reads the bytes of the file at a path. Side files of GDAL that change its heights are refused.
pub(crate) fn read(path: &Path, bytes: &[u8]) -> Result<Raster, ReadError> {
    let beside = |ending: &str| {
        let mut name = path.as_os_str().to_owned();
        name.push(ending);
        PathBuf::from(name)
    };
    let mask = beside(".msk");
    if mask.exists() {
        return Err(refused(&format!(
            "{} says which cells have data; `gdalwarp -dstnodata -9999 in.tif out.tif` writes this into the heights",
            mask.display()
        )));
    }
    let more = beside(".aux.xml");
    let more = if more.exists() {
        of_side_file(&String::from_utf8_lossy(&crate::read::bytes(&more)?))?
    } else {
        None
    };
    parse_with(bytes, more)
}

#[cfg(test)]
fn parse(bytes: &[u8]) -> Result<Raster, ReadError> {
    parse_with(bytes, None)
}

/// Reads the bytes of a file beside which the height of no data may stand.
fn parse_with(bytes: &[u8], beside: Option<f64>) -> Result<Raster, ReadError> {
    let mut limits = Limits::default();
    (limits.decoding_buffer_size, limits.intermediate_buffer_size) = (LARGEST, LARGEST);
    let mut file = Decoder::new(Cursor::new(bytes)).map_err(wrong)?.with_limits(limits);
    let (columns, rows) = file.dimensions().map_err(wrong)?;
    let keys = Keys {
        keys: optional(file.get_tag_u16_vec(Tag::GeoKeyDirectoryTag))?.unwrap_or_default(),
        numbers: optional(file.get_tag_f64_vec(Tag::GeoDoubleParamsTag))?.unwrap_or_default(),
    };
    keys.check().map_err(|what| refused(&what))?;
    if let Some(metadata) = optional(file.get_tag_ascii_string(METADATA))? {
        check_band(&metadata)?;
    }
    let scale = optional(file.get_tag_f64_vec(Tag::ModelPixelScaleTag))?;
    let tie = optional(file.get_tag_f64_vec(Tag::ModelTiepointTag))?;
    let (Some([cell, height, up @ ..]), Some([i, j, k, x, y, z])) = (scale.as_deref(), tie.as_deref()) else {
        return Err(refused("no cell size and no one point of the map; `gdalwarp` makes rasters north up"));
    };
    let is_square = (cell - height).abs() <= SQUARE * cell && *cell > 0.0 && cell.is_finite();
    if !(is_square && x.is_finite() && y.is_finite()) {
        return Err(refused(&format!("cells of {cell} by {height}; `gdalwarp -tr` makes them square")));
    }
    if keys.has_vertical_system() {
        check_vertical(up.first().map_or(0.0, |scale| *scale), z - k)?;
    }
    let none = optional(file.get_tag_ascii_string(Tag::GdalNodata))?;
    let none = none.map_or(Ok(None), |text| height_of_none(&text))?;
    let is_told =
        |beside: f64| none.is_some_and(|none| is_none(beside, none) || beside.is_nan() && none.is_nan());
    if let Some(beside) = beside.filter(|beside| !is_told(*beside)) {
        let how = says_none(none, beside);
        return Err(refused(&format!(
            "a side file says that there are no data where the height is {beside}; {how}"
        )));
    }
    let size = [columns as usize, rows as usize];
    let bits = bits_of_heights(&mut file)?;
    let mut heights = read_heights(&mut file, size, bits, none.map_or(0.0, |_| f64::NAN))?;
    if let Some(none) = none {
        let is_none = |height: f64| is_none(height, none) || height == f64::from(none as f32); // as it was rounded
        heights.iter_mut().filter(|height| is_none(**height)).for_each(|height| *height = f64::NAN);
    }
    if let Some(height) = heights.iter().find(|height| height.is_finite() && height.abs() > HUGE) {
        let how = says_none(none, *height);
        return Err(refused(&format!("a height of {height:e}, which is none of a terrain; {how}")));
    }
    // The point of the map lies at a corner of a cell, or in its middle.
    let middle = if keys.is_of_points() { 0.0 } else { 0.5 };
    let [columns, rows] = size;
    let first = [x + (middle - i) * cell, y - (middle - j + (rows - 1) as f64) * cell];
    Ok(Raster { columns, rows, first, cell: *cell, heights })
}

/// How many bits a height has. Refuses what is other than one band of heights as they are.
fn bits_of_heights(file: &mut File) -> Result<usize, ReadError> {
    let bands = file.find_tag_unsigned::<u16>(Tag::SamplesPerPixel).map_err(wrong)?;
    if bands.is_some_and(|bands| bands != 1) {
        return Err(refused("several bands; `gdal_translate -b 1` takes the first"));
    }
    if file.find_tag_unsigned::<u16>(Tag::PhotometricInterpretation).map_err(wrong)? == Some(0) {
        return Err(refused(
            "the smallest number is white, so that some programs read heights turned over; \
             `gdal_translate -co PHOTOMETRIC=MINISBLACK in.tif out.tif` keeps the numbers and drops this",
        ));
    }
    if has_mask(file)? {
        return Err(refused(
            "a mask says which cells have data; `gdalwarp -dstnodata -9999 in.tif out.tif` writes this into the heights",
        ));
    }
    match file.colortype().map_err(wrong)? {
        ColorType::Gray(bits @ (8 | 16 | 32 | 64)) => Ok(usize::from(bits)),
        ColorType::Gray(bits) => Err(refused(&format!(
            "heights of {bits} bits; `gdal_translate -ot Float64 in.tif out.tif` writes them in a usual size"
        ))),
        _ => Err(refused("colours in the place of heights")),
    }
}

/// Whether one of the pictures behind the first is a mask.
fn has_mask(file: &mut File) -> Result<bool, ReadError> {
    let mut next = file.image_ifd().directory().next();
    let mut seen = HashSet::new();
    while let Some(place) = next.filter(|place| seen.insert(place.0)) {
        let directory = file.read_directory(place).map_err(wrong)?;
        let kind = file.read_directory_tags(&directory).find_tag_unsigned::<u32>(Tag::NewSubfileType);
        if kind.map_err(wrong)?.is_some_and(|kind| kind & MASK != 0) {
            return Ok(true);
        }
        next = directory.next();
    }
    Ok(false)
}

/// The heights of all strips or tiles. One that was left out of the file, for all its heights are alike, has `absent`.
///
/// Each is read with its padding at once. In shorter parts the end of some tiles is not found: `weezl` 0.1.12, which
/// `tiff` 0.11.3 needs, says then that nothing was read (its issue 68, mended in 0.2.0).
fn read_heights(
    file: &mut File,
    [columns, rows]: [usize; 2],
    bits: usize,
    absent: f64,
) -> Result<Vec<f64>, ReadError> {
    let count =
        columns.checked_mul(rows).filter(|count| *count <= LARGEST / (bits / 8).max(size_of::<f64>()));
    let count = count.ok_or_else(|| {
        refused(&format!(
            "{columns} by {rows} heights are too many; `gdal_translate -srcwin` cuts a part out"
        ))
    })?;
    let lengths = match file.get_chunk_type() {
        ChunkType::Strip => Tag::StripByteCounts,
        ChunkType::Tile => Tag::TileByteCounts,
    };
    let lengths = file.get_tag_u64_vec(lengths).map_err(wrong)?;
    let [width, height] = <[u32; 2]>::from(file.chunk_dimensions()).map(|side| side as usize);
    let across = columns.div_ceil(width);
    let (mut heights, mut block) = (vec![0.0; count], DecodingResult::U8(Vec::new()));
    for (i, length) in (0..).zip(lengths) {
        let [left, top] = [i as usize % across * width, i as usize / across * height];
        let [wide, high] = <[u32; 2]>::from(file.chunk_data_dimensions(i)).map(|side| side as usize);
        let here =
            heights.chunks_exact_mut(columns).skip(top).take(high).map(|row| &mut row[left..left + wide]);
        if length == 0 {
            here.for_each(|row| row.fill(absent));
            continue;
        }
        file.read_chunk_to_buffer(&mut block, i, width * (bits / 8)).map_err(|error| {
            refused(&format!("heights from column {left} and row {top} on: {}", told(&error)))
        })?;
        match &block {
            DecodingResult::U8(from) => put(from, width, here, f64::from),
            DecodingResult::I8(from) => put(from, width, here, f64::from),
            DecodingResult::U16(from) => put(from, width, here, f64::from),
            DecodingResult::I16(from) => put(from, width, here, f64::from),
            DecodingResult::U32(from) => put(from, width, here, f64::from),
            DecodingResult::I32(from) => put(from, width, here, f64::from),
            DecodingResult::F32(from) => put(from, width, here, f64::from),
            DecodingResult::F16(from) => put(from, width, here, |height| height.to_f64()),
            DecodingResult::F64(from) => put(from, width, here, |height| height),
            _ => {
                return Err(refused(
                    "integers of 64 bits; `gdal_translate -ot Float64 in.tif out.tif` writes real numbers",
                ));
            }
        }
    }
    Ok(heights)
}

/// Rows of a block go to their places; what is behind them is padding.
fn put<'a, T: Copy>(
    from: &[T],
    width: usize,
    to: impl Iterator<Item = &'a mut [f64]>,
    as_height: impl Fn(T) -> f64,
) {
    for (from, to) in from.chunks_exact(width).zip(to) {
        to.iter_mut().zip(from).for_each(|(to, from)| *to = as_height(*from));
    }
}

/// What has such heights stand for no data, beside those that do already: a file names one number alone.
fn says_none(none: Option<f64>, height: f64) -> String {
    match none {
        Some(none) => format!(
            "`gdal_calc.py -A in.tif --calc=\"numpy.where(numpy.isclose(A, {height:?}), {none:?}, A)\" --NoDataValue={none:?} \
             --outfile=out.tif` has them stand for no data, as those of {none:?} do"
        ),
        None => format!("`gdal_edit.py -a_nodata {height:?} in.tif` says that there are no data"),
    }
}

/// The height that stands for no data, by the number that the text begins with, as GDAL reads it.
fn height_of_none(text: &str) -> Result<Option<f64>, ReadError> {
    let text = text.split('\0').next().unwrap_or("");
    let Some(word) = text.split_whitespace().next() else { return Ok(None) };
    word.parse().map(Some).map_err(|_| {
        refused(&format!(
            "no data where the height is `{word}`, which is no number; `gdal_edit.py -a_nodata -9999 in.tif` names one, \
             and `gdal_edit.py -unsetnodata in.tif` none"
        ))
    })
}

/// Where a file has a vertical system, GDAL writes scale and offset of its one band beside the size of cells and the
/// point of the map, and 0 or 1 for no scale.
fn check_vertical(scale: f64, offset: f64) -> Result<(), ReadError> {
    if scale != 0.0 && scale != 1.0 {
        return Err(scaled(&format!("a scale of {scale}")));
    }
    if offset == 0.0 { Ok(()) } else { Err(scaled(&format!("an offset of {offset}"))) }
}

fn scaled(what: &str) -> ReadError {
    refused(&format!("heights with {what}; `gdal_translate -unscale -ot Float64` writes them as they are"))
}

/// The height that stands for no data by what GDAL wrote beside the file. Refuses a scale, an offset and a unit there.
fn of_side_file(text: &str) -> Result<Option<f64>, ReadError> {
    let value = |name: &str| {
        let (_, rest) = text.split_once(&format!("<{name}>")).or_else(|| {
            let (_, rest) = text.split_once(&format!("<{name} "))?;
            rest.split_once('>').map(|(_, rest)| ("", rest))
        })?;
        rest.split('<').next().map(str::trim)
    };
    for (name, role) in [("Scale", "scale"), ("Offset", "offset"), ("UnitType", "unittype")] {
        value(name).map_or(Ok(()), |value| check_role(role, value))?;
    }
    value("NoDataValue").map_or(Ok(None), height_of_none)
}

/// Refuses heights that are other than the numbers in the file: by a scale, an offset or a unit of the first band.
fn check_band(metadata: &str) -> Result<(), ReadError> {
    for item in metadata.split("<Item").skip(1) {
        let Some((head, rest)) = item.split_once('>') else { continue };
        let value = rest.split('<').next().unwrap_or("").trim();
        if attribute(head, "sample") != Some("0") {
            continue; // of the file as a whole, or of another band
        }
        check_role(attribute(head, "role").unwrap_or(""), value)?;
    }
    Ok(())
}

/// Refuses a scale, an offset or a unit of heights that changes what the numbers are.
fn check_role(role: &str, value: &str) -> Result<(), ReadError> {
    match role {
        "scale" if value.parse() != Ok(1.0) => Err(scaled(&format!("a scale of {value}"))),
        "offset" if value.parse() != Ok(0.0) => Err(scaled(&format!("an offset of {value}"))),
        "unittype" if !METRES.iter().any(|metres| value.eq_ignore_ascii_case(metres)) => {
            Err(refused(&format!(
                "heights in `{value}`; `gdal_calc.py --calc=0.3048*A -A in.tif --outfile=out.tif` puts feet into metres"
            )))
        }
        _ => Ok(()),
    }
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
    refused(&told(&error))
}

/// What an error of the library says, with what to try.
fn told(error: &TiffError) -> String {
    match error {
        TiffError::UnsupportedError(TiffUnsupportedError::UnsupportedCompressionMethod(method)) => {
            let method = match method {
                CompressionMethod::Unknown(34887) => "LERC".into(),
                CompressionMethod::Unknown(34925) => "LZMA".into(),
                other => format!("{other:?}"),
            };
            format!(
                "compression by {method} is not read; `gdal_translate -co COMPRESS=DEFLATE in.tif out.tif` writes one \
                 that is"
            )
        }
        TiffError::UnsupportedError(_) => format!(
            "{error}; `gdal_translate -ot Float64 -co PHOTOMETRIC=MINISBLACK -co COMPRESS=DEFLATE in.tif out.tif` \
             writes heights in a way that is read"
        ),
        _ => error.to_string(),
    }
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
    use tiff::encoder::{DirectoryEncoder, TiffEncoder, TiffKindStandard, colortype::Gray32Float};

    const HEIGHTS: [f32; 6] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];

    /// What tags are written to.
    type Tags<'a, 'b> = DirectoryEncoder<'a, &'b mut Cursor<Vec<u8>>, TiffKindStandard>;

    /// Two rows of three heights with these keys, of which sizes of units stand in `numbers`, and with what GDAL says.
    fn file(keys: &[[u16; 2]], numbers: &[f64], metadata: &str) -> Vec<u8> {
        file_of(&HEIGHTS, keys, |to| {
            if !numbers.is_empty() {
                to.write_tag(Tag::GeoDoubleParamsTag, numbers).unwrap();
            }
            if !metadata.is_empty() {
                to.write_tag(METADATA, metadata).unwrap();
            }
        })
    }

    /// Two rows of three heights with these keys, and with more tags.
    fn file_of(heights: &[f32], keys: &[[u16; 2]], more: impl FnOnce(&mut Tags)) -> Vec<u8> {
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
        more(to);
        image.write_data(heights).unwrap();
        bytes.into_inner()
    }

    /// Where a file has a vertical system, GDAL writes scale and offset of its band as third numbers, and not as XML.
    #[test]
    fn a_scale_of_heights_that_stands_at_the_size_of_cells_is_refused() {
        let of = |keys: &[[u16; 2]], scale: f64, [k, offset]: [f64; 2]| {
            parse(&file_of(&HEIGHTS, keys, |to| {
                to.write_tag(Tag::ModelPixelScaleTag, &[10.0, 10.0, scale][..]).unwrap();
                to.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, k, 500.0, 700.0, offset][..]).unwrap();
            }))
        };
        for keys in [&[[3072, 25832], [4096, 5783]][..], &[[3072, 25832], [4099, 9001]]] {
            for plain in [0.0, 1.0] {
                assert!(of(keys, plain, [0.0; 2]).is_ok(), "{keys:?} {plain}");
            }
            for (scale, tie, words) in [
                (0.1, [0.0; 2], "a scale of 0.1"),
                (-1.0, [0.0; 2], "a scale of -1"),
                (f64::NAN, [0.0; 2], "a scale of NaN"),
                (1.0, [0.0, 1000.0], "an offset of 1000"),
                (0.0, [0.0, -5.0], "an offset of -5"),
                (1.0, [3.0, 0.0], "an offset of -3"),
            ] {
                let error = of(keys, scale, tie).unwrap_err().to_string();
                assert!(error.contains(words) && error.contains("`gdal_translate -unscale"), "{error}");
            }
        }
        // Without a vertical system these numbers say nothing of heights.
        assert!(of(&[[3072, 25832]], 10.0, [0.0, 7.0]).is_ok());
    }

    /// GDAL takes the number that the text begins with.
    #[test]
    fn the_height_that_is_none_is_read_as_gdal_reads_it() {
        let of = |text: &str, heights: &[f32; 6]| {
            parse(&file_of(heights, &[], |to| to.write_tag(Tag::GdalNodata, text).unwrap()))
        };
        let mut heights = HEIGHTS;
        heights[0] = -9999.0;
        for text in ["-9999", "-9999 ", "-9999\n", " -9999\t", "-9999 0", "-9.999e3\r\n"] {
            let heights = of(text, &heights).unwrap().heights;
            assert!(heights[0].is_nan() && heights[1] == 2.0, "{text:?}: {heights:?}");
        }
        for text in ["nan", "NaN\n", "-nan", "", " ", "inf"] {
            assert_eq!(of(text, &heights).unwrap().heights[0], -9999.0, "{text:?}");
        }
        for text in ["none", "-9999;", "-9999,5"] {
            let error = of(text, &heights).unwrap_err().to_string();
            assert!(error.contains(text) && error.contains("`gdal_edit.py -a_nodata"), "{error}");
        }
        // As in ASCII grids six digits of a huge number decide.
        heights[0] = f32::MIN;
        for text in ["-3.40282e+38", "-3.4028234663852886e+38", "-3.4028235e38"] {
            assert!(of(text, &heights).unwrap().heights[0].is_nan(), "{text}");
        }
        for (text, advice) in
            [("", "-a_nodata -3.4"), ("-9999", "--NoDataValue=-9999.0 "), ("1e31", "--NoDataValue=1e31 ")]
        {
            let error = of(text, &heights).unwrap_err().to_string();
            assert!(error.contains("a height of -3.4028") && error.contains(advice), "{error}");
        }
        heights[0] = f32::INFINITY;
        assert!(of("", &heights).is_ok());
    }

    #[test]
    fn coordinates_of_a_geographic_system_alone_are_degrees() {
        let error = parse(&file(&[[2048, 4326]], &[], "")).unwrap_err().to_string();
        assert!(error.contains("coordinates in degrees; `gdalwarp -t_srs"), "{error}");
        for keys in
            [&[[2048, 4326], [3072, 32632]][..], &[[1024, 1], [2048, 4326]], &[[2048, 4258], [3076, 9001]]]
        {
            assert!(parse(&file(keys, &[], "")).is_ok(), "{keys:?}");
        }
    }

    /// The bytes of numbers the other way around, and the form for large files.
    #[test]
    fn every_form_of_tiff_is_read() {
        let mut bytes = Cursor::new(Vec::new());
        let mut file = TiffEncoder::new_big(&mut bytes).unwrap();
        let mut image = file.new_image::<Gray32Float>(3, 2).unwrap();
        image.encoder().write_tag(Tag::ModelPixelScaleTag, &[10.0, 10.0, 0.0][..]).unwrap();
        image.encoder().write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, 500.0, 700.0, 0.0][..]).unwrap();
        image.write_data(&HEIGHTS).unwrap();
        let large = bytes.into_inner();

        // Width, height, bits, compression, meaning, place, samples, rows and bytes of the strip, real numbers.
        let tags = [
            [256, 3],
            [257, 2],
            [258, 32],
            [259, 1],
            [262, 1],
            [273, 8],
            [277, 1],
            [278, 2],
            [279, 24],
            [339, 3],
        ];
        let mut turned = b"MM\0\x2a\0\0\0\x68".to_vec(); // directory behind 24 and 72 bytes of data
        HEIGHTS.iter().for_each(|height| turned.extend(height.to_be_bytes()));
        let numbers = [10.0, 10.0, 0.0, 0.0, 0.0, 0.0, 500.0, 700.0, 0.0_f64];
        numbers.iter().for_each(|number| turned.extend(number.to_be_bytes()));
        turned.extend((tags.len() as u16 + 2).to_be_bytes());
        let mut entry = |tag: u16, kind: u16, count: u32, value: u32| {
            turned.extend([tag.to_be_bytes(), kind.to_be_bytes()].concat());
            turned.extend([count.to_be_bytes(), value.to_be_bytes()].concat());
        };
        tags.iter().for_each(|&[tag, value]| entry(tag, 4, 1, u32::from(value)));
        entry(33550, 12, 3, 32);
        entry(33922, 12, 6, 56);
        turned.extend([0; 4]);

        for bytes in [large, turned] {
            assert!(crate::raster::is_tiff(&bytes));
            let raster = parse(&bytes).unwrap();
            assert_eq!([raster.height([505.0, 695.0]), raster.height([525.0, 685.0])], [1.0, 6.0]);
        }
    }

    fn item(attributes: &str, value: &str) -> String {
        format!("<GDALMetadata>\n  <Item name=\"X\" {attributes}>{value}</Item>\n</GDALMetadata>\n")
    }

    #[test]
    fn metres_are_read() {
        for keys in [&[][..], &[[3076, 9001], [4099, 9001]], &[[3076, 0], [4099, 0]]] {
            assert_eq!(parse(&file(keys, &[], "")).unwrap().height([505.0, 695.0]), 1.0, "{keys:?}");
        }
        // Systems in metres whose units GDAL does not write, and one that is none of EPSG.
        let systems = [
            [25832, 5783],
            [28992, 5709],
            [6339, 5703],
            [3857, 3855],
            [2056, 5728],
            [27700, 5701],
            [32767, 32767],
        ];
        for [system, heights] in systems {
            assert!(parse(&file(&[[3072, system], [4096, heights]], &[], "")).is_ok(), "{system} {heights}");
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
        // Of a compound system GDAL writes the numbers of its parts, and no unit.
        told(
            keys(&[[3072, 2263], [4096, 6360]], 1.0),
            ["coordinates of EPSG:2263 in US survey feet", "`gdalwarp"],
        );
        told(
            keys(&[[3072, 26910], [4096, 6360]], 1.0),
            ["heights of EPSG:6360 in feet", "`gdalwarp -t_srs EPSG:…+…`"],
        );
        told(
            keys(&[[3072, 26910], [4096, 8228]], 1.0),
            ["heights of EPSG:8228 in feet", "`gdalwarp -t_srs EPSG:…+…`"],
        );
        told(keys(&[[3072, 2136]], 1.0), ["coordinates of EPSG:2136 in the unit of 0.30479971", "`gdalwarp"]);
        told(keys(&[[3072, 30000]], 1.0), ["EPSG:30000, and its unit is not known", "`gdal_edit.py -a_srs"]);
        told(keys(&[[3072, 26910], [4096, 4999]], 1.0), ["heights of EPSG:4999", "`gdal_edit.py -a_srs"]);
        let depths = ["depths, of EPSG:5715", "`gdal_translate -scale 0 1 0 -1"];
        told(keys(&[[3072, 26910], [4096, 5715]], 1.0), depths);
        told(keys(&[[3072, 26910], [4096, 5715], [4099, 9001]], 1.0), depths);
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
