//! Terrain as a raster: the ASCII grid of ESRI, which geographic programs write, and GeoTIFF (feature `geotiff`).

use crate::mesh::Mesh;
use crate::read::{ReadError, Words, bytes, text};
use std::path::Path;

/// The height of cells without data in an ASCII grid that names none (ESRI, ASCII raster format).
const NONE: f64 = -9999.0;

/// What ESRI's `cellsize` says, and GDAL's `dx` and `dy` need not.
const SQUARES: &str = "square cells (`gdalwarp -tr` makes them, `gdal_translate -of AAIGrid` writes them)";
/// No height of a terrain is as large: such numbers stand for no data, and are written with more or fewer digits.
pub(crate) const HUGE: f64 = 1e30;
/// What numbers of six digits may differ by.
const SIX_DIGITS: f64 = 1e-5;

/// Heights at the centres of square cells. A cell without data has the height NaN.
#[doc(alias = "DEM")]
#[doc(alias = "terrain")]
#[doc(alias = "elevation")]
#[derive(Debug, Clone, PartialEq)]
pub struct Raster {
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    /// The middle of the cell in the south-west.
    pub(crate) first: [f64; 2],
    pub(crate) cell: f64,
    /// Row by row from the north, as in the file.
    pub(crate) heights: Vec<f64>,
}

impl Raster {
    /// Reads a file: an ASCII grid, or with the feature `geotiff` a GeoTIFF of one band, north up, on square cells in
    /// metres. A GeoTIFF that names other units or a system in other units, or a scale or an offset of heights, is
    /// refused. One that names neither units nor a system counts as in metres. Where blocks of a GeoTIFF were left out,
    /// there are no data, or the height is 0 if no number stands for no data. Finite heights above 10³⁰ in size are
    /// refused, unless they stand for no data.
    ///
    /// Of files beside a GeoTIFF a mask (`.msk`) is refused, and what GDAL writes (`.aux.xml`) if it has a scale, an
    /// offset, a unit other than metres, or another number for no data than the file. Others are not looked at, and
    /// none beside an ASCII grid.
    ///
    /// # Errors
    /// [`ReadError`], for an ASCII grid with the number of the line.
    pub fn read(path: impl AsRef<Path>) -> Result<Raster, ReadError> {
        let path = path.as_ref();
        let bytes = bytes(path)?;
        if is_tiff(&bytes) {
            #[cfg(feature = "geotiff")]
            return crate::geotiff::read(path, &bytes);
            #[cfg(not(feature = "geotiff"))]
            return Err(ReadError::Io {
                path: path.display().to_string(),
                source: std::io::Error::new(
                    std::io::ErrorKind::Unsupported,
                    "a GeoTIFF, which needs the feature `geotiff` of rattle-flow",
                ),
            });
        }
        Raster::parse(&text(path, bytes)?)
    }

    /// Reads an ASCII grid from the text of a file. Cells of the height `NODATA_value` are without data; where the file
    /// does not name it, this is −9999, as ESRI defines it. Where it is above 10³⁰ in size, as −3.4e38 is, the first
    /// six digits decide. A word of the header that is there twice is refused.
    ///
    /// ```
    /// use rattle_flow::Raster;
    /// let text = "ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 10\nNODATA_value -9999\n3 3 4\n1 2 -9999\n";
    /// let raster = Raster::parse(text)?;
    /// assert_eq!(raster.height([10.0, 10.0]), 2.25); // the mean of 3, 3, 1 and 2
    /// let (mesh, heights) = raster.mesh()?;
    /// assert_eq!((mesh.points().len(), heights[0]), (4, 1.0));
    /// # Ok::<(), rattle_flow::ReadError>(())
    /// ```
    ///
    /// # Errors
    /// [`ReadError`], with the number of the line.
    pub fn parse(text: &str) -> Result<Raster, ReadError> {
        let mut words = Words::of(text);
        let (mut columns, mut rows, mut cell) = (None::<usize>, None::<usize>, None::<f64>);
        let (mut x, mut y, mut none) = (None, None, None);
        let mut sides = [None; 2];
        let start = loop {
            let Some(word) = words.next() else { return Err(words.wrong("heights", "")) };
            match word.to_ascii_lowercase().as_str() {
                "ncols" => once(&mut columns, word, &mut words, |it| it.number("the number of columns"))?,
                "nrows" => once(&mut rows, word, &mut words, |it| it.number("the number of rows"))?,
                "cellsize" => once(&mut cell, word, &mut words, side)?,
                "dx" => once(&mut sides[0], word, &mut words, side)?,
                "dy" => once(&mut sides[1], word, &mut words, side)?,
                "xllcorner" => once(&mut x, word, &mut words, |it| Ok((coordinate(it)?, 0.5)))?,
                "yllcorner" => once(&mut y, word, &mut words, |it| Ok((coordinate(it)?, 0.5)))?,
                "xllcenter" => once(&mut x, word, &mut words, |it| Ok((coordinate(it)?, 0.0)))?,
                "yllcenter" => once(&mut y, word, &mut words, |it| Ok((coordinate(it)?, 0.0)))?,
                "nodata_value" => {
                    once(&mut none, word, &mut words, |it| it.number::<f64>("the height that is none"))?;
                }
                _ => break word,
            }
            if let [Some(dx), Some(dy)] = sides {
                if let Some(cell) = cell.filter(|cell| *cell != dx || *cell != dy) {
                    return Err(words.wrong(SQUARES, &format!("cellsize {cell}, dx {dx} and dy {dy}")));
                }
                if dx != dy {
                    return Err(words.wrong(SQUARES, &format!("dx {dx} and dy {dy}")));
                }
            }
        };
        let cell = cell.or(if let [Some(dx), Some(_)] = sides { Some(dx) } else { None });
        let none = none.unwrap_or(NONE);
        let columns = columns.ok_or(ReadError::Missing { section: "ncols" })?;
        let rows = rows.ok_or(ReadError::Missing { section: "nrows" })?;
        let cell = cell.ok_or(ReadError::Missing { section: "cellsize" })?;
        let (x, of_x) = x.ok_or(ReadError::Missing { section: "xllcorner" })?;
        let (y, of_y) = y.ok_or(ReadError::Missing { section: "yllcorner" })?;
        if columns == 0 || rows == 0 {
            return Err(words.wrong("one column and one row at least", "none"));
        }
        let Some(count) = columns.checked_mul(rows).filter(|count| *count <= text.len()) else {
            return Err(words.wrong("a size with as many cells as there are heights", "a larger one"));
        };
        let mut heights = Vec::with_capacity(count);
        for i in 0..count {
            let word = if i == 0 { start } else { words.next().unwrap_or("") };
            let height: f64 = word.parse().map_err(|_| words.wrong("a height", word))?;
            let height = if is_none(height, none) { f64::NAN } else { height };
            if height.is_finite() && height.abs() > HUGE {
                return Err(words.wrong("a height, or the number for no data", word));
            }
            heights.push(height);
        }
        if let Some(word) = words.next() {
            return Err(words.wrong("the end of the file", word));
        }
        Ok(Raster { columns, rows, first: [x + of_x * cell, y + of_y * cell], cell, heights })
    }

    /// The height of the cell in a column from the west and a row from the south.
    fn at(&self, column: usize, row: usize) -> f64 {
        self.heights[(self.rows - 1 - row) * self.columns + column]
    }

    /// The height at a position: bilinear between the centres of cells; NaN outside of these, and where one of the four
    /// cells has no data. What is at the centre of a cell but for rounding, as vertices of the [mesh](Self::mesh) are,
    /// has the height of this cell, whatever is beside it.
    pub fn height(&self, place: [f64; 2]) -> f64 {
        let [u, v] = [0, 1].map(|i| in_cells(place[i], self.first[i], self.cell));
        let (right, top) = ((self.columns - 1) as f64, (self.rows - 1) as f64);
        let inside = (0.0..=right).contains(&u) && (0.0..=top).contains(&v);
        if !inside {
            return f64::NAN;
        }
        let part = |x: f64, count: usize| {
            let low = (x as usize).min(count.saturating_sub(2));
            (low, (low + 1).min(count - 1), x - low as f64)
        };
        let ((i, k, a), (j, l, b)) = (part(u, self.columns), part(v, self.rows));
        let along = |row: usize| mixed(self.at(i, row), self.at(k, row), a);
        mixed(along(j), along(l), b)
    }

    /// A mesh with a vertex at the centre of each cell, and the heights there. Between four cells with data there are
    /// two triangles, with alternating diagonals.
    ///
    /// **Valleys need several cells.** Nothing flows along the diagonal of a square, opposite to right angles: a valley
    /// that is one cell wide and goes diagonally is a row of ponds. Along one that goes straight the friction of the
    /// water beside dry banks has the slope from its surface up to them. Between banks of 0.6, with cells of 1, a depth
    /// of 0.3 and a slope of 0.02, valleys of 1, 2, 3, 5 and 9 cells carry 26, 63, 75, 85 and 92 % of what they should,
    /// and diagonal ones 0, 31, 42, 80 and 89 %. Take a finer raster, or [a mesh](Mesh::read_gmsh) with several
    /// vertices across a channel.
    ///
    /// # Errors
    /// [`ReadError::Mesh`] where there are nowhere four adjacent cells with data.
    pub fn mesh(&self) -> Result<(Mesh, Vec<f64>), ReadError> {
        let (columns, rows) = (self.columns, self.rows);
        let number = |i: usize, j: usize| j * columns + i;
        let mut squares = Vec::new();
        for j in 0..rows.saturating_sub(1) {
            for i in 0..columns.saturating_sub(1) {
                let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                if corners.iter().all(|&(i, j)| self.at(i, j).is_finite()) {
                    let mut around = corners.map(|(i, j)| number(i, j));
                    if (i + j) % 2 == 1 {
                        around.rotate_left(1);
                    }
                    squares.push(around);
                }
            }
        }
        let mut names = vec![u32::MAX; columns * rows];
        squares.iter().flatten().for_each(|&vertex| names[vertex] = 0);
        let (mut points, mut heights) = (Vec::new(), Vec::new());
        for (vertex, name) in names.iter_mut().enumerate().filter(|(_, name)| **name == 0) {
            let (i, j) = (vertex % columns, vertex / columns);
            *name = points.len() as u32;
            points.push([self.first[0] + i as f64 * self.cell, self.first[1] + j as f64 * self.cell]);
            heights.push(self.at(i, j));
        }
        let triangles = squares.into_iter().flat_map(|around| {
            let [a, b, c, d] = around.map(|vertex| names[vertex]);
            [[a, b, c], [a, c, d]]
        });
        Ok((Mesh::new(points, triangles.collect())?, heights))
    }
}

/// Whether a file begins as TIFF does, or as its form for large files.
pub(crate) fn is_tiff(bytes: &[u8]) -> bool {
    [b"II\x2a\0", b"MM\0\x2a", b"II\x2b\0", b"MM\0\x2b"].iter().any(|magic| bytes.starts_with(*magic))
}

/// Whether a height stands for no data: of a huge one six digits decide.
pub(crate) fn is_none(height: f64, none: f64) -> bool {
    let slack = if none.is_finite() && none.abs() > HUGE { SIX_DIGITS * none.abs() } else { 0.0 };
    height == none || (height - none).abs() <= slack
}

/// The next word as the side of a cell.
fn side(words: &mut Words) -> Result<f64, ReadError> {
    let side = words.number::<f64>("the size of a cell")?;
    let is_side = side > 0.0 && side.is_finite();
    if is_side { Ok(side) } else { Err(words.wrong("the size of a cell, above 0", &side.to_string())) }
}

fn coordinate(words: &mut Words) -> Result<f64, ReadError> {
    let place = words.number::<f64>("a coordinate")?;
    if place.is_finite() { Ok(place) } else { Err(words.wrong("a finite coordinate", &place.to_string())) }
}

/// A word of the header with what it says, of which there is one.
fn once<'a, T>(
    said: &mut Option<T>,
    word: &str,
    words: &mut Words<'a>,
    what: impl FnOnce(&mut Words<'a>) -> Result<T, ReadError>,
) -> Result<(), ReadError> {
    if said.is_some() {
        return Err(words.wrong("each word of the header once (leave one of the two out)", word));
    }
    *said = Some(what(words)?);
    Ok(())
}

/// How many cells a coordinate lies behind the first centre: a whole number where rounding may hide that it is one.
fn in_cells(place: f64, first: f64, cell: f64) -> f64 {
    let cells = (place - first) / cell;
    // Of a coordinate that was rounded after it was made of these, and of the two operations above.
    let rounding = 4.0 * f64::EPSILON * ((place.abs() + first.abs()) / cell + cells.abs());
    let whole = cells.round();
    if (cells - whole).abs() <= rounding { whole } else { cells }
}

/// a + s (b − a), and a or b itself at the ends, whatever the other is.
fn mixed(a: f64, b: f64, s: f64) -> f64 {
    if s == 0.0 {
        a
    } else if s == 1.0 {
        b
    } else {
        a + s * (b - a)
    }
}
