//! Meshes, rasters and pictures: read back what is written, and name what is wrong.

use base64::prelude::{BASE64_STANDARD, Engine};
use rattle_flow::{Flow, FlowError, Mesh, MeshError, Page, Raster, ReadError, Resistance, vtu};

const SQUARE: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 1 \"water\"\n$EndPhysicalNames\n$Nodes\n5\n\
    10 0 0 0\n20 1 0 0\n30 1 1 0\n40 0 1 0\n99 7 7 0\n$EndNodes\n$Elements\n4\n1 15 2 0 1 10\n2 1 2 0 1 10 20\n\
    3 2 2 0 1 10 20 30\n4 2 2 0 1 10 30 40\n$EndElements\n";

const SQUARE_4: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 1 0\n1 0 0 0 1 1 0 0 0\n$EndEntities\n$Nodes\n\
    2 4 10 40\n1 1 0 2\n10\n20\n0 0 0\n1 0 0\n2 1 1 2\n30\n40\n1 1 0 0.5 0.5\n0 1 0 0.1 0.2\n$EndNodes\n$Elements\n\
    2 3 1 3\n1 1 1 1\n1 10 20\n2 1 2 2\n2 10 30 20\n3 10 40 30\n$EndElements\n";

#[test]
fn both_versions_of_gmsh_give_the_same_mesh() {
    let old = Mesh::from_gmsh(SQUARE).unwrap();
    assert_eq!((old.points().len(), old.boundary().len()), (4, 4));
    assert!((old.area() - 1.0).abs() < 1e-15);
    let new = Mesh::from_gmsh(SQUARE_4).unwrap(); // clockwise there, and turned over
    assert_eq!(old.points(), new.points());
    let sorted = |mesh: &Mesh| {
        let mut list: Vec<Vec<u32>> = mesh.triangles().iter().map(|t| t.to_vec()).collect();
        list.iter_mut().for_each(|t| t.sort_unstable());
        list.sort();
        list
    };
    assert_eq!(sorted(&old), sorted(&new));
    assert_eq!(old.boundary(), new.boundary());
}

#[test]
fn what_is_wrong_with_a_file_is_named_with_its_line() {
    let line = |text: &str| match Mesh::from_gmsh(text).unwrap_err() {
        ReadError::Word { line, found, .. } => (line, found),
        other => panic!("{other}"),
    };
    assert_eq!(line(&SQUARE.replace("20 1 0 0", "20 one 0 0")), (11, "one".to_owned()));
    assert_eq!(line(&SQUARE.replace("4 2 2 0 1 10 30 40\n$EndElements\n", "")), (20, String::new()));
    let error = |text: &str| Mesh::from_gmsh(text).unwrap_err();
    assert!(matches!(error(&SQUARE.replace("2.2 0", "2.2 1")), ReadError::Version { .. }));
    assert!(matches!(error(&SQUARE.replace("2.2 0", "3.0 0")), ReadError::Version { .. }));
    assert!(matches!(error("hello"), ReadError::Missing { .. }));
    assert_eq!(line(&SQUARE.replace("10 30 40", "10 30 41")), (21, "41".to_owned()));
    assert_eq!(line(&SQUARE_4.replace("10 40 30", "10 40 31")), (27, "31".to_owned()));
    assert!(matches!(Mesh::read_gmsh("no/such/file"), Err(ReadError::Io { .. })));
}

/// More or less than a file says of itself, or twice: the line is told.
#[test]
fn a_file_of_gmsh_that_contradicts_itself_is_refused() {
    let cases = [
        (SQUARE.replace("30 1 1 0", "20 1 1 0"), 12, "each node once", "20"),
        (SQUARE_4.replace("10\n20\n0", "10\n10\n0"), 12, "each node once", "10"),
        (SQUARE.replace("$Nodes\n5", "$Nodes\n4"), 14, "`$EndNodes`", "99"),
        (SQUARE.replace("$Elements\n4", "$Elements\n3"), 21, "`$EndElements`", "4"),
        (SQUARE_4.replace("2 3 1 3\n1 1", "1 3 1 3\n1 1"), 24, "as many elements", "1"),
        (SQUARE_4.replace("2 3 1 3\n1 1", "2 4 1 4\n1 1"), 27, "as many elements", "3"),
        (SQUARE_4.replace("2 4 10 40", "2 5 10 40"), 19, "as many nodes", "4"),
        (SQUARE_4.replace("2 1 2 2\n", "2 1 2 1\n"), 26, "as many elements", "2"),
        (format!("{SQUARE}$Elements\n0\n$EndElements\n"), 23, "each section once", "$Elements"),
        (format!("{SQUARE}$Nodes\n0\n$EndNodes\n"), 23, "each section once", "$Nodes"),
        (format!("{SQUARE}$MeshFormat\n4.1 0 8\n"), 23, "each section once", "$MeshFormat"),
    ];
    for (text, at, wanted, word) in cases {
        let error = Mesh::from_gmsh(&text).unwrap_err();
        assert!(
            matches!(&error, ReadError::Word { line, expected, found }
                if *line == at && expected.contains(wanted) && found == word),
            "{at} {wanted} {word}: {error}"
        );
    }
}

/// Files that are no text in UTF-8: what is not names of groups says what it is.
#[test]
fn files_of_gmsh_in_bytes_are_told_or_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("square.msh");
    let mut binary = b"$MeshFormat\n4.1 1 8\n".to_vec();
    binary.extend([1, 0, 0, 0, b'\n', 0xff, 0xfe, 0x80]);
    std::fs::write(&path, binary).unwrap();
    let error = Mesh::read_gmsh(&path).unwrap_err();
    assert!(matches!(error, ReadError::Version { .. }), "{error}");
    let latin: Vec<u8> =
        SQUARE.bytes().flat_map(|byte| if byte == b'w' { vec![0xdc] } else { vec![byte] }).collect();
    std::fs::write(&path, latin).unwrap();
    assert_eq!(Mesh::read_gmsh(&path).unwrap(), Mesh::from_gmsh(SQUARE).unwrap());
}

/// What would be a hole in the mesh is refused, in both versions and whatever its order.
#[test]
fn surfaces_of_gmsh_that_are_no_triangles_are_refused() {
    let old = |element: &str| SQUARE.replace("4 2 2 0 1 10 30 40", element);
    let new = |kind: &str, nodes: &str| {
        SQUARE_4.replace("2 1 2 2\n2 10 30 20", &format!("2 1 {kind} 2\n2 {nodes}"))
    };
    let cases = [
        (old("4 3 2 0 1 10 30 40 99"), 21, "a quadrangle", "`Recombine Surface`"),
        (old("4 9 2 0 1 10 30 40 99 99 99"), 21, "a triangle of higher order", "`gmsh -2 -order 1"),
        (old("4 21 2 0 1 10 30 40 99 99 99 99 99 99 99"), 21, "a triangle of higher order", "-order 1"),
        // Gmsh writes lines before triangles, and those of order 3 are of kind 26.
        (
            old("4 21 2 0 1 10 30 40 99 99 99 99 99 99 99")
                .replace("2 1 2 0 1 10 20", "2 26 2 0 1 10 20 99 99"),
            21,
            "a triangle of higher order",
            "-order 1",
        ),
        (new("3", "10 30 20 40"), 26, "a quadrangle", "`Mesh.RecombineAll`"),
    ];
    for (text, line, found, advice) in cases {
        let error = Mesh::from_gmsh(&text).unwrap_err();
        assert!(error.to_string().contains(advice), "{error}");
        assert!(
            matches!(error, ReadError::Hole { line: l, found: f, .. } if l == line && f == found),
            "{error}"
        );
    }
}

/// Version 2.2 writes an element once for each physical group that it belongs to.
#[test]
fn triangles_of_two_groups_are_read_once() {
    let text = SQUARE.replace("$Elements\n4\n", "$Elements\n6\n");
    let text = text.replace("$EndElements", "5 2 2 7 1 10 20 30\n6 2 2 7 1 40 10 30\n$EndElements");
    let (once, twice) = (Mesh::from_gmsh(SQUARE).unwrap(), Mesh::from_gmsh(&text).unwrap());
    assert_eq!(once.triangles(), twice.triangles());
    let other = text.replace("6 2 2 7 1 40 10 30", "6 2 2 7 1 10 20 40");
    assert!(matches!(Mesh::from_gmsh(&other), Err(ReadError::Mesh(MeshError::Overlap { .. }))));
}

/// The mark of byte order that editors of Windows put before a text.
#[test]
fn a_mark_of_byte_order_is_passed_over() {
    let marked = |text: &str| format!("\u{feff}{text}");
    assert_eq!(Mesh::from_gmsh(&marked(SQUARE)).unwrap().points().len(), 4);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("marked.asc");
    std::fs::write(&path, marked(&grid("", "1 2\n3 4\n"))).unwrap();
    assert_eq!(Raster::read(path).unwrap().height([0.5, 0.5]), 3.0);
}

/// An ASCII grid of two by two cells.
fn grid(more: &str, heights: &str) -> String {
    format!("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n{more}{heights}")
}

#[test]
fn headers_of_ascii_grids_mean_what_their_writers_meant() {
    // The least number of 32 bits, by GDAL and by programs that write six digits.
    let least = "-3.4028234663852886e+38";
    for none in ["-3.40282e+38", "-3.4028235e+38", least] {
        let raster =
            Raster::parse(&grid(&format!("NODATA_value {none}\n"), &format!("1 {least}\n3 4\n"))).unwrap();
        assert!(raster.height([1.5, 1.5]).is_nan() && raster.height([0.5, 1.5]) == 1.0, "{none}");
    }
    let near = Raster::parse(&grid("NODATA_value 5\n", "5 5.0000001\n3 4\n")).unwrap();
    assert!(near.height([0.5, 1.5]).is_nan() && near.height([1.5, 1.5]) == 5.0000001, "near it is not at it");
    let all = Raster::parse(&grid("NODATA_value -inf\n", "1 2\n3 4\n")).unwrap();
    assert!(all.height([1.0, 1.0]) == 2.5);

    let sides = |sides: &str| grid("", "1 2\n3 4\n").replace("cellsize 1\n", sides);
    assert_eq!(Raster::parse(&sides("dx 10.0\ndy 10\n")).unwrap().height([10.0, 10.0]), 2.5);
    let cases = [
        (sides("dx 10\ndy 12\n"), 6, "`gdalwarp -tr`", "dx 10 and dy 12"),
        (sides("cellsize -1\n"), 5, "above 0", "-1"),
        (sides("cellsize 0\n"), 5, "above 0", "0"),
        (sides("cellsize inf\n"), 5, "above 0", "inf"),
        (sides("cellsize 1\n").replace("xllcorner 0", "xllcorner nan"), 3, "a finite coordinate", "NaN"),
        (sides("cellsize 1\n").replace("yllcorner 0", "yllcenter inf"), 4, "a finite coordinate", "inf"),
    ];
    for (text, line, wanted, word) in cases {
        let error = Raster::parse(&text).unwrap_err();
        assert!(
            matches!(&error, ReadError::Word { line: l, expected, found } if *l == line && expected.contains(wanted) && found == word),
            "{error}"
        );
    }
}

/// Cells of 10 cm far from zero, as on maps: no triangle of the page is flat, and lengths are right.
#[test]
fn a_page_of_a_map_keeps_its_shape() {
    let text = grid("", &"1500.25 1500.5 1500.75 1501\n".repeat(3));
    let text = text.replace("ncols 2\nnrows 2", "ncols 4\nnrows 3").replace("cellsize 1", "cellsize 0.1");
    let raster = Raster::parse(
        &text.replace("xllcorner 0", "xllcorner 512345").replace("yllcorner 0", "yllcorner 5412345"),
    );
    let (mesh, heights) = raster.unwrap().mesh().unwrap();
    let raster = Raster::parse(&text).unwrap();
    let flow = Flow::over(mesh, Resistance::Manning).terrain(move |[x, y]| {
        raster.height([x - 512345.0, y - 5412345.0].map(|x| (x * 20.0).round() / 20.0))
    });
    let mut page = Page::new("A map", &flow);
    page.add(0.0, &vec![0.1; heights.len()]).unwrap();
    let html = page.to_html().unwrap();
    let data = html.split("\"points\":\"").nth(1).unwrap().split('"').next().unwrap();
    let numbers = BASE64_STANDARD.decode(data).unwrap();
    let numbers: Vec<f64> = numbers.as_chunks().0.iter().map(|x| f64::from(f32::from_le_bytes(*x))).collect();
    let points = numbers.as_chunks::<3>().0;
    assert_eq!(points.len(), 12);
    for corners in flow.mesh().triangles() {
        let [a, b, c] = corners.map(|corner| points[corner as usize]);
        let area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
        assert!((area - 0.005).abs() < 1e-8, "{area} at {a:?}");
    }
    let first = flow.mesh().points()[0];
    for (place, [x, y, b]) in flow.mesh().points().iter().zip(points) {
        let expected = [place[0] - first[0], place[1] - first[1]];
        assert!(
            (x - points[0][0] - expected[0]).abs() < 1e-7 && (y - points[0][1] - expected[1]).abs() < 1e-7
        );
        assert!((b - points[0][2] - 2.5 * expected[0]).abs() < 1e-6, "{b}");
    }

    let told = |page: &Page| page.to_html().unwrap_err().to_string();
    for seconds in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let page = page.clone().seconds(seconds);
        assert!(
            matches!(page.to_html(), Err(FlowError::Number { what: "the seconds that a page plays", .. })),
            "{}",
            told(&page)
        );
        let folder = tempfile::tempdir().unwrap();
        let error = page.write(folder.path().join("page.html")).unwrap_err();
        assert_eq!((error.kind(), error.to_string()), (std::io::ErrorKind::InvalidInput, told(&page)));
    }
    for lift in [f64::NAN, f64::NEG_INFINITY] {
        let error = told(&page.clone().lift(lift));
        assert!(error.starts_with("the vertical exaggeration on a page is"), "{error}");
    }
}

#[test]
fn what_is_no_mesh_is_refused() {
    let points = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [1.0, 0.0], [1.0, -1.0]];
    let error = |triangles: Vec<[u32; 3]>| Mesh::new(points.clone(), triangles).unwrap_err();
    let whole = vec![[0, 1, 2], [0, 2, 3], [0, 5, 4], [4, 5, 1]];
    let hanging = error(whole.clone());
    assert!(matches!(hanging, MeshError::Hanging { vertex: 4, from: 0, to: 1, triangle: 0 }), "{hanging}");
    let split = vec![[0, 4, 2], [4, 1, 2], [0, 2, 3], [0, 5, 4], [4, 5, 1]];
    assert!(Mesh::new(points.clone(), split.clone()).is_ok());
    let turned = |i: usize| {
        let mut list = split.clone();
        list[i].swap(0, 1);
        list
    };
    assert!(matches!(error(turned(2)), MeshError::Inverted { triangle: 2, area, .. } if area == -2.0));
    assert!(matches!(error(whole[..2].to_vec()), MeshError::Loose { vertex: 4 }));
    assert!(matches!(
        error([&split[..], &[[0, 4, 2]]].concat()),
        MeshError::Overlap { first: 0, second: 5, .. }
    ));
    let mut nowhere = points.clone();
    nowhere[3][1] = f64::NAN;
    assert!(matches!(Mesh::new(nowhere, split), Err(MeshError::NotFinite { vertex: 3, .. })));
    for corners in [&[[0.0, 0.0], [1.0, 0.0]][..], &[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]] {
        assert!(matches!(Mesh::polygon(corners, 0.1), Err(MeshError::Polygon { .. })));
    }
    assert!(matches!(Mesh::polygon(&points[..4], 1e-9), Err(MeshError::Polygon { .. })));
}

#[test]
fn a_raster_is_a_terrain_and_a_mesh() {
    let (columns, rows) = (7, 5);
    let plane = |i: usize, j: usize| 2.0 * i as f64 - 3.0 * j as f64;
    let mut text = format!(
        "NCOLS {columns}\nnrows {rows}\nxllcenter 100\nyllcenter 200\ncellsize 5\nNODATA_value -9999\n"
    );
    for j in (0..rows).rev() {
        let row: Vec<String> = (0..columns)
            .map(|i| if i == 6 && j == 4 { "-9999".into() } else { plane(i, j).to_string() })
            .collect();
        text += &(row.join(" ") + "\n");
    }
    let raster = Raster::parse(&text).unwrap();
    assert_eq!(raster.height([100.0, 200.0]), 0.0);
    assert!((raster.height([112.5, 217.0]) - (2.0 * 2.5 - 3.0 * 3.4)).abs() < 1e-12);
    assert!(raster.height([131.0, 200.0]).is_nan() && raster.height([128.0, 218.0]).is_nan());
    let (mesh, heights) = raster.mesh().unwrap();
    assert_eq!((mesh.points().len(), mesh.triangles().len()), (34, 46));
    assert!((mesh.area() - 23.0 * 25.0).abs() < 1e-9);
    assert!(mesh.points().iter().zip(&heights).all(|(&place, &b)| (raster.height(place) - b).abs() < 1e-12));

    let line = |text: &str| match Raster::parse(text).unwrap_err() {
        ReadError::Word { line, .. } => line,
        other => panic!("{other}"),
    };
    let unnamed = Raster::parse(&text.replace("NODATA_value -9999\n", "")).unwrap();
    assert_eq!(unnamed.mesh().unwrap().1, heights, "-9999 is the height of no data where none is named");
    let zero = Raster::parse(&text.replace("NODATA_value -9999", "nodata_value 0")).unwrap();
    assert!(zero.height([100.0, 200.0]).is_nan() && zero.height([130.0, 220.0]) == -9999.0);

    assert_eq!(line(&text.replace("-9999\n", "high\n").replacen("high", "-9999", 1)), 7);
    assert!(matches!(
        Raster::parse(&text.replace("cellsize 5", "")),
        Err(ReadError::Missing { section: "cellsize" })
    ));
    assert_eq!(line(&(text.clone() + "1.0\n")), 12);
    assert!(line(&text.replace("nrows 5", "nrows 50000000")) > 0);
    for empty in ["ncols 0\nnrows 2", "ncols 2\nnrows 0", "ncols 0\nnrows 0"] {
        let empty = format!("{empty}\nxllcorner 0\nyllcorner 0\ncellsize 1\n");
        for text in [empty.clone() + "1\n", empty] {
            assert!(Raster::parse(&text).is_err(), "{text}");
        }
    }

    // Terrain with a hole in it: the vertex is named before anything flows.
    let square =
        Mesh::polygon(&[[100.0, 200.0], [130.0, 200.0], [130.0, 220.0], [100.0, 220.0]], 5.0).unwrap();
    let depth = vec![0.1; square.points().len()];
    let error =
        Flow::over(square, Resistance::Manning).terrain(|place| raster.height(place)).simulate(depth, 1.0);
    assert!(error.is_err_and(|error| error.to_string().contains("the terrain at vertex")));
}

#[test]
fn paraview_gets_what_was_there() {
    let mesh = Mesh::from_gmsh(SQUARE).unwrap();
    let depth = [0.1, 1.0 / 3.0, 0.0, 2e-300];
    let q = [[1.0, -1.0], [0.5, 0.25]];
    let text = vtu::text(&mesh, &[0.0; 4], &[("depth <m>", &depth)], &[("q", &q)]);
    let numbers = |name: &str| -> Vec<f64> {
        let start = text.find(&format!("Name=\"{name}\"")).expect(name);
        let body = text[start..].split_once('>').unwrap().1.split_once('<').unwrap().0;
        body.split_whitespace().map(|word| word.parse().unwrap()).collect()
    };
    assert_eq!(numbers("depth &lt;m&gt;"), depth);
    assert_eq!(numbers("q"), [1.0, -1.0, 0.0, 0.5, 0.25, 0.0]);
    assert_eq!(numbers("offsets"), [3.0, 6.0]);
    assert_eq!(numbers("points").len(), 12);
    let folder = std::env::temp_dir().join(format!("rattle-flow-{}", std::process::id()));
    let mut series = vtu::Series::create(folder.join("flow.pvd")).unwrap();
    series.add(0.0, &text).unwrap();
    series.add(0.5, &text).unwrap();
    let list = std::fs::read_to_string(folder.join("flow.pvd")).unwrap();
    assert!(list.contains("timestep=\"0.5\"") && list.contains("flow_000001.vtu"));
    assert_eq!(std::fs::read_to_string(folder.join("flow_000001.vtu")).unwrap(), text);
    std::fs::remove_dir_all(folder).unwrap();
}

/// Rasters that GDAL 3.10.3 wrote (by rasterio 1.4.4): four rows of six heights, the one in the north-east missing; or
/// as said where they are read. Options of GDAL: `GDAL_TIFF_INTERNAL_MASK`, `PHOTOMETRIC=MINISWHITE`,
/// `INTERLEAVE=BAND`, `NBITS=4`, `NBITS=16` and `COMPRESS=ZSTD` for those named so.
fn by_gdal(name: &str) -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// Real numbers with deflate and a predictor, integers in tiles with LZW, doubles; heights of cells, and of points.
#[test]
fn geotiff_is_the_terrain_that_gdal_wrote() {
    for name in ["float_deflate.tif", "int_lzw_tiled.tif", "double.tif", "point.tif"] {
        let raster = Raster::read(by_gdal(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        for (row, column) in
            (0..4).flat_map(|row| (0..6).map(move |column| (f64::from(row), f64::from(column))))
        {
            let found = raster.height([1005.0 + 10.0 * column, 535.0 - 10.0 * row]);
            let written = 10.0 * row + column + 0.25 * row * column;
            let written = if name.starts_with("int") { written.trunc() } else { written };
            let is_right = if row == 0.0 && column == 5.0 { found.is_nan() } else { found == written };
            assert!(is_right, "{name}: {found} at {row}, {column}");
        }
        assert!(raster.height([1000.0, 520.0]).is_nan(), "{name}: outside of the middles of cells");
        assert_eq!(raster.mesh().unwrap().0.points().len(), 23, "{name}");
    }
}

/// Blocks of 16 by 16 that GDAL left out of twenty rows of forty (`SPARSE_OK=TRUE`): no data where a number stands for
/// them, else 0.
#[test]
fn blocks_that_are_left_out_are_read_as_gdal_does() {
    for name in ["sparse.tif", "sparse_none.tif"] {
        let raster = Raster::read(by_gdal(name)).unwrap();
        for (row, column) in (0..20).flat_map(|row| (0..40).map(move |column| (row, column))) {
            let found = raster.height([1005.0 + 10.0 * f64::from(column), 535.0 - 10.0 * f64::from(row)]);
            let written = f64::from(10 * row + column + row * column / 4);
            let is_right = match (row < 16 && (16..32).contains(&column), name) {
                (false, _) => found == written,
                (true, "sparse.tif") => found == 0.0,
                (true, _) => found.is_nan(),
            };
            assert!(is_right, "{name}: {found} at {row}, {column}");
        }
    }
}

/// Tiles of LZW with a predictor (30 rows of 40 integers), which `tiff` does not read row by row; 16 bits a number.
#[test]
fn geotiff_is_read_tile_by_tile() {
    let raster = Raster::read(by_gdal("int_lzw_predictor.tif")).unwrap();
    for (row, column) in (0..30).flat_map(|row| (0..40).map(move |column| (row, column))) {
        let found = raster.height([1005.0 + 10.0 * f64::from(column), 535.0 - 10.0 * f64::from(row)]);
        assert_eq!(found, -f64::from(10 * row + column + row * column / 4), "{row}, {column}");
    }
    let raster = Raster::read(by_gdal("sixteen_bits.tif")).unwrap();
    assert_eq!([raster.height([1055.0, 505.0]), raster.height([1015.0, 525.0])], [38.75, 11.25]);
}

#[test]
fn geotiff_that_is_no_terrain_is_refused() {
    let cases = [
        ("degrees.tif", "coordinates in degrees; `gdalwarp -t_srs"),
        ("oblong.tif", "cells of 10 by 12; `gdalwarp -tr`"),
        ("turned.tif", "`gdalwarp` makes rasters north up"),
        ("two_bands.tif", "several bands; `gdal_translate -b 1`"),
        ("bands_apart.tif", "several bands; `gdal_translate -b 1`"),
        ("mask.tif", "a mask says which cells have data; `gdalwarp -dstnodata -9999 in.tif out.tif`"),
        ("min_is_white.tif", "`gdal_translate -co PHOTOMETRIC=MINISBLACK in.tif out.tif`"),
        ("four_bits.tif", "heights of 4 bits; `gdal_translate -ot Float64 in.tif out.tif`"),
        ("zstd.tif", "compression by ZSTD is not read; `gdal_translate -co COMPRESS=DEFLATE in.tif out.tif`"),
    ];
    for (name, what) in cases {
        let error = Raster::read(by_gdal(name)).unwrap_err().to_string();
        assert!(error.starts_with("GeoTIFF: ") && error.contains(what), "{name}: {error}");
    }
    // Whatever is damaged: a raster or an error, soon. Each in a file of its own: to write one over waits for the disk.
    let folder = tempfile::tempdir().unwrap();
    for name in ["float_deflate.tif", "int_lzw_tiled.tif", "mask.tif", "sixteen_bits.tif", "sparse.tif"] {
        let whole = std::fs::read(by_gdal(name)).unwrap();
        let text = |raster: Result<Raster, ReadError>| raster.ok().map(|raster| format!("{raster:?}"));
        let sound = text(Raster::read(by_gdal(name)));
        let read = |bytes: &[u8], file: String| {
            let path = folder.path().join(file);
            std::fs::write(&path, bytes).unwrap();
            let read = text(Raster::read(&path));
            std::fs::remove_file(path).unwrap();
            read
        };
        for at in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[at] ^= 1 << (at % 8);
            read(&damaged, format!("{at}.tif"));
            // What stands behind the last height, a check sum or the rest of a tile, is not needed.
            let cut = read(&whole[..at], format!("{at}_cut.tif"));
            assert!(cut.is_none() || at > whole.len() / 2 && cut == sound, "{name}: the first {at} bytes");
        }
    }
}

/// What GDAL writes beside a file says more of its heights.
#[test]
fn geotiff_with_side_files_that_change_its_heights_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let beside = |name: &str, ending: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::copy(by_gdal(name), &path).unwrap();
        let side = folder.path().join(format!("{name}{ending}"));
        std::fs::write(&side, text).unwrap();
        let read = Raster::read(&path).map_err(|error| error.to_string());
        std::fs::remove_file(side).unwrap();
        read.map(drop)
    };
    let band = |what: &str| {
        format!("<PAMDataset>\n <PAMRasterBand band=\"1\">\n{what}\n</PAMRasterBand></PAMDataset>")
    };
    let (float, sparse) = ("float_deflate.tif", "sparse.tif");
    let cases = [
        (float, ".msk", String::new(), "float_deflate.tif.msk"),
        (float, ".aux.xml", band("<Scale>0.1</Scale>"), "a scale of 0.1; `gdal_translate -unscale"),
        (float, ".aux.xml", band("<Offset>1000</Offset>"), "an offset of 1000; `gdal_translate -unscale"),
        (float, ".aux.xml", band("<UnitType>ft</UnitType>"), "heights in `ft`"),
        (float, ".aux.xml", band("<NoDataValue>7</NoDataValue>"), "isclose(A, 7.0), -9999.0, A)"),
        (
            sparse,
            ".aux.xml",
            band("<NoDataValue le_hex_endian=\"00\">7.0</NoDataValue>"),
            "no data where the height is 7; `gdal_edit.py -a_nodata 7.0 in.tif`",
        ),
    ];
    for (name, ending, text, words) in cases {
        let error = beside(name, ending, &text).expect_err(&text);
        assert!(error.starts_with("GeoTIFF: ") && error.contains(words), "{text}: {error}");
    }
    let plain = band(
        "<Scale>1</Scale><Offset>0.0</Offset><UnitType>m</UnitType><Metadata><MDI key=\"STATISTICS_MEAN\">3</MDI></Metadata>",
    );
    assert_eq!(beside(float, ".aux.xml", &plain), Ok(()));
}

/// As far as rounding goes: corners with decimals, thirds of metres, far from zero as on maps, and beside no data.
#[test]
fn a_raster_has_its_heights_at_the_vertices_of_its_mesh() {
    let mut state = 7_u64;
    let mut random = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / 2_f64.powi(53)
    };
    let cells = [0.1, 0.2, 0.3, 1.0 / 3.0, 0.7, 1.0, 12.5];
    for i in 0..700 {
        let (cell, far, lost) = (cells[i % 7], [10.0, 6e6][i / 7 % 2], [0.0, 0.1][i / 14 % 2]);
        let [columns, rows] = [(); 2].map(|()| 2 + (10.0 * random()) as usize);
        let [x, y] = [(); 2].map(|()| (100.0 * far * (random() - 0.5)).round() / 100.0);
        let mut text = format!("ncols {columns} nrows {rows} xllcorner {x} yllcorner {y} cellsize {cell} ");
        for _ in 0..columns * rows {
            text += &if random() < lost { "-9999 ".to_owned() } else { format!("{} ", random()) };
        }
        let raster = Raster::parse(&text).unwrap();
        let Ok((mesh, heights)) = raster.mesh() else {
            assert!(lost > 0.0, "{text}");
            continue;
        };
        let read: Vec<f64> = mesh.points().iter().map(|place| raster.height(*place)).collect();
        assert_eq!(read, heights, "{text}");
        let [x, y] = mesh.points()[0];
        assert!(lost > 0.0 || raster.height([x - 1e-6 * cell, y]).is_nan(), "{text}");
    }
}

/// Of two words only one can be meant; the second is named.
#[test]
fn a_header_says_everything_once() {
    let twice = [
        ("cellsize 2", 6, "cellsize"),
        ("NCOLS 2", 6, "NCOLS"),
        ("nrows 4", 6, "nrows"),
        ("xllcenter 0.5", 6, "xllcenter"),
        ("yllcorner 0", 6, "yllcorner"),
        ("dx 1\ndx 1", 7, "dx"),
        ("NODATA_value 1\nnodata_value 2", 7, "nodata_value"),
        ("dx 2\ndy 2", 7, "cellsize 1, dx 2 and dy 2"),
    ];
    for (more, line, word) in twice {
        let error = Raster::parse(&grid(&format!("{more}\n"), "1 2\n3 4\n")).unwrap_err();
        assert!(
            matches!(&error, ReadError::Word { line: l, found, .. } if *l == line && found == word),
            "{error}"
        );
    }
    assert!(Raster::parse(&grid("dx 1\ndy 1\n", "1 2\n3 4\n")).is_ok());
}

/// What a page is told is shown as it is, though it looks like a place where other things are put.
#[test]
fn a_page_says_what_it_is_told() {
    let flow = Flow::over(Mesh::from_gmsh(SQUARE).unwrap(), Resistance::Manning);
    let mut page = Page::new("__CAPTION__ & __DATA__", &flow).caption("of __DATA__, __TITLE__");
    page.add(0.0, &vec![0.0; flow.mesh().points().len()]).unwrap();
    let html = page.to_html().unwrap();
    assert!(html.contains("<title>__CAPTION__ &amp; __DATA__</title>"));
    assert!(html.contains("<h1>__CAPTION__ &amp; __DATA__</h1><p>of __DATA__, __TITLE__</p>"));
    assert_eq!(html.matches("\"triangles\":").count(), 1);
}
