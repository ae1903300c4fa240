//! Units of coordinates and heights, by the keys of GeoTIFF (OGC 19-008, 7.1) and the numbers of EPSG.

const MODEL: u16 = 1024;
const GEOGRAPHIC: u16 = 2;
const GEOGRAPHIC_SYSTEM: u16 = 2048;
const PIXEL_IS: u16 = 1025;
const POINT: u16 = 2;
const SYSTEM: u16 = 3072;
const UNITS: u16 = 3076;
const SIZE_OF_UNIT: u16 = 3077;
const SYSTEM_OF_HEIGHTS: u16 = 4096;
const UNITS_OF_HEIGHTS: u16 = 4099;
/// Keys of projected systems, and of vertical ones.
const PROJECTED: std::ops::RangeInclusive<u16> = 3072..=4095;
const VERTICAL: std::ops::RangeInclusive<u16> = 4096..=5119;
const UNDEFINED: u16 = 0;
const METRE: u16 = 9001;
const OF_A_USER: u16 = 32767;

/// What the file says of its coordinates.
pub(super) struct Keys {
    /// The directory of keys, four numbers for each.
    pub keys: Vec<u16>,
    /// Where the size of the unit of a user stands.
    pub numbers: Vec<f64>,
}

impl Keys {
    /// The number that stands last in the entry of a key.
    fn last(&self, wanted: u16) -> Option<u16> {
        self.keys.as_chunks::<4>().0.iter().skip(1).find(|key| key[0] == wanted).map(|key| key[3])
    }

    /// The value of a key, unless it says nothing.
    fn get(&self, wanted: u16) -> Option<u16> {
        self.last(wanted).filter(|value| *value != UNDEFINED)
    }

    /// Whether heights are those of points, and not of cells.
    pub(super) fn is_of_points(&self) -> bool {
        self.get(PIXEL_IS) == Some(POINT)
    }

    /// Whether a vertical system is named, or a part of one.
    pub(super) fn has_vertical_system(&self) -> bool {
        self.has_one_of(VERTICAL)
    }

    fn has_one_of(&self, wanted: std::ops::RangeInclusive<u16>) -> bool {
        self.keys.as_chunks::<4>().0.iter().skip(1).any(|key| wanted.contains(&key[0]))
    }

    /// An error for what is not in metres, with what to try.
    pub(super) fn check(&self) -> Result<(), String> {
        let is_geographic = match self.get(MODEL) {
            Some(model) => model == GEOGRAPHIC,
            None => self.get(GEOGRAPHIC_SYSTEM).is_some() && !self.has_one_of(PROJECTED),
        };
        if is_geographic {
            return Err("coordinates in degrees; `gdalwarp -t_srs EPSG:…` puts them into metres".into());
        }
        let named = |key| self.get(key).filter(|system| *system != OF_A_USER);
        match self.get(UNITS) {
            Some(METRE) => {}
            Some(OF_A_USER) if self.size_of_unit() == Some(1.0) => {}
            Some(unit) => return Err(coordinates(&format!("coordinates in {}", unit_of(unit)))),
            None => named(SYSTEM).map_or(Ok(()), check_system)?,
        }
        match self.get(UNITS_OF_HEIGHTS) {
            Some(METRE) => named(SYSTEM_OF_HEIGHTS).filter(is_of_depths).map_or(Ok(()), depths),
            Some(unit) => Err(heights(&format!("heights in {}", unit_of(unit)))),
            None => named(SYSTEM_OF_HEIGHTS).map_or(Ok(()), check_system_of_heights),
        }
    }

    fn size_of_unit(&self) -> Option<f64> {
        self.numbers.get(usize::from(self.last(SIZE_OF_UNIT)?)).copied()
    }
}

fn coordinates(what: &str) -> String {
    format!("{what}; `gdalwarp -t_srs EPSG:…` puts them into metres, and leaves heights as they are")
}

fn heights(what: &str) -> String {
    format!(
        "{what}; `gdalwarp -t_srs EPSG:…+…`, with a vertical system in metres after the `+`, puts them into metres"
    )
}

/// A unit of length by its number in EPSG.
fn unit_of(unit: u16) -> String {
    match unit {
        9002 => "feet (EPSG:9002)".into(),
        9003 => "US survey feet (EPSG:9003)".into(),
        OF_A_USER => "a unit that is none of EPSG".into(),
        other => format!("the unit EPSG:{other}"),
    }
}

/// Of a compound system GDAL writes the numbers of the two that it is made of, and no units.
fn check_system(system: u16) -> Result<(), String> {
    let definition = crs_definitions::from_code(system).map_or("", |found| found.proj4);
    let word = |name: &str| definition.split_whitespace().find_map(|word| word.strip_prefix(name));
    let unit = match (word("+units="), word("+to_meter=")) {
        (Some("m"), None) => return Ok(()),
        (Some("us-ft"), None) => "US survey feet".into(),
        (Some("ft"), None) => "feet".into(),
        (Some(unit), None) => format!("`{unit}`"),
        (_, Some(size)) => format!("the unit of {size} m"),
        (None, None) => {
            return Err(format!(
                "coordinates of EPSG:{system}, and its unit is not known here; `gdal_edit.py -a_srs EPSG:{system} \
                 in.tif` writes it into the file, as of heights in metres"
            ));
        }
    };
    Err(coordinates(&format!("coordinates of EPSG:{system} in {unit}")))
}

/// Whether heights of a vertical system of EPSG 12.029 are depths.
fn is_of_depths(system: &u16) -> bool {
    matches!(
        system,
        5336 | 5612 | 5614 | 5706 | 5715 | 5734 | 5739 | 5789 | 5831 | 5861..=5867 | 5873 | 6357..=6359 | 7976 | 8051
            | 8053 | 8358 | 8378 | 8897 | 9287..=9288 | 9672 | 10150..=10151 | 10349 | 10364 | 10370..=10379
            | 10547..=10552 | 10649..=10650 | 10678
    )
}

fn depths(system: u16) -> Result<(), String> {
    Err(format!(
        "depths, of EPSG:{system}; `gdal_translate -scale 0 1 0 -1 -a_srs EPSG:… in.tif out.tif`, with the system of \
         the map alone, makes heights of them"
    ))
}

/// As [`check_system`], by the vertical systems of EPSG 12.029.
#[rustfmt::skip]
fn check_system_of_heights(system: u16) -> Result<(), String> {
    match system {
        _ if is_of_depths(&system) => depths(system),
        // Heights in metres, upwards.
        3855 | 3886 | 3900 | 4440 | 4458 | 5193 | 5195 | 5214 | 5237 | 5317 | 5597 | 5600..=5611 | 5613 | 5615..=5621 |
        5701 | 5703..=5705 | 5709..=5714 | 5716..=5733 | 5735..=5738 | 5740..=5753 | 5755..=5788 | 5790..=5799 | 5829 |
        5843 | 5868..=5872 | 5874 | 5941 | 6178..=6187 | 6638..=6644 | 6647 | 6693..=6695 | 6916 | 7446..=7447 |
        7651..=7652 | 7699..=7700 | 7707 | 7832 | 7837 | 7839 | 7841 | 7888..=7890 | 7962 | 7968 | 7979 | 8089 |
        8266..=8267 | 8357 | 8434 | 8675 | 8690..=8691 | 8841 | 8881 | 8904 | 8911 | 9130 | 9245 | 9255 | 9274 | 9279 |
        9303 | 9335 | 9351 | 9389..=9390 | 9392..=9402 | 9451 | 9458 | 9471 | 9650..=9651 | 9663 | 9666 | 9669 | 9675 |
        9681 | 9721..=9722 | 9923 | 9927 | 10190 | 10352..=10354 | 10482..=10485 | 10565 | 10588 | 10642 | 10740 |
        10763 | 10900 | 10918 | 10999 | 11157 | 20000 | 20034..=20036 => Ok(()),
        5702 | 5754 | 6130..=6132 | 6360 | 8050 | 8052 | 8228 | 10919 => {
            Err(heights(&format!("heights of EPSG:{system} in feet")))
        }
        _ => Err(format!(
            "heights of EPSG:{system}, of which it is not known here that they are in metres upwards; if they are, \
             `gdal_edit.py -a_srs EPSG:… in.tif`, with the system of the map alone, takes this out"
        )),
    }
}
