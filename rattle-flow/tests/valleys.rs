//! What valleys of a raster carry that are a few cells wide: a limit of resolution, and the figures that the guide has.

use rattle_flow::{Flow, Raster, Resistance};

const UNIT: Resistance = Resistance::DarcyWeisbach { gravity: 1.0 };
/// Of the valley along itself, over the depth of 0.3, between banks of 0.6; cells of 1.
const SLOPE: f64 = 0.02;
const DEPTH: f64 = 0.3;
const BANK: f64 = 0.6;
const STEP: f64 = 0.5;

/// What flows through the middle of a valley so many cells wide, in parts of c hᵅ √S times its width.
fn carried(cells: usize, diagonal: bool) -> f64 {
    let (columns, rows) = if diagonal { (41, 41) } else { (41, cells + 6) };
    let in_valley = |i: usize, j: usize| {
        let across = if diagonal { i + cells / 2 } else { j };
        let first = if diagonal { j } else { 3 };
        (first..first + cells).contains(&across)
    };
    let root = 0.5_f64.sqrt();
    let along = |i: usize, j: usize| if diagonal { root * (i + j) as f64 } else { i as f64 };
    let mut text = format!("ncols {columns}\nnrows {rows}\nxllcenter 0\nyllcenter 0\ncellsize 1\n");
    for (i, j) in (0..rows).rev().flat_map(|j| (0..columns).map(move |i| (i, j))) {
        let bank = if in_valley(i, j) { 0.0 } else { BANK };
        text += &format!("{:e}\n", bank - SLOPE * along(i, j));
    }
    let raster = Raster::parse(&text).unwrap();
    let (mesh, _) = raster.mesh().unwrap();
    let depth = mesh.at_vertices(|[x, y]| if in_valley(x as usize, y as usize) { DEPTH } else { 0.0 });
    // Long enough for water to find its level across the valley, and too short for the ends to be felt at the middle.
    let flow = Flow::over(mesh.clone(), UNIT).terrain(|place| raster.height(place));
    let mut simulation = flow.simulate(depth, STEP).unwrap();
    simulation.run(20).unwrap();
    let before = simulation.depth().to_vec();
    simulation.step().unwrap();
    let places = || mesh.points().iter().map(|&[x, y]| (x as usize, y as usize)).enumerate();
    let middle = along(columns / 2, if diagonal { rows / 2 } else { 0 });
    let past = |from: f64| {
        let below = places().filter(|(_, (i, j))| along(*i, *j) > from + 1e-9);
        below.map(|(v, _)| (simulation.depth()[v] - before[v]) * mesh.shares()[v]).sum::<f64>()
    };
    let near = places().filter(|&(_, (i, j))| in_valley(i, j) && (along(i, j) - middle).abs() < 2.0);
    let near: Vec<f64> = near.map(|(v, _)| before[v].powf(1.5)).collect();
    let of_depth = near.iter().sum::<f64>() / near.len() as f64;
    // Each cell of a diagonal is √2 long, so that the width of each is 1/√2.
    let width = cells as f64 * if diagonal { root } else { 1.0 };
    let passed = 0.5 * (past(middle) + past(middle - if diagonal { root } else { 1.0 }));
    passed / STEP / (of_depth * SLOPE.sqrt() * width)
}

/// Straight: the edges along the water's sides feel the slope up to the banks, a root of 15 in one of two triangles.
/// Diagonal: nothing flows along the diagonal of a square, opposite to right angles.
#[test]
fn valleys_of_a_few_cells_carry_too_little() {
    let figures = [(1, 0.26, 0.0), (2, 0.63, 0.31), (3, 0.75, 0.42), (5, 0.85, 0.80), (9, 0.92, 0.89)];
    for (cells, straight, diagonal) in figures {
        let found = [carried(cells, false), carried(cells, true)];
        println!("{cells} cells: {:.3} straight, {:.3} diagonal", found[0], found[1]);
        assert!(
            (found[0] - straight).abs() < 6e-3 && (found[1] - diagonal).abs() < 6e-3,
            "{cells}: {found:?}"
        );
        // Of n rows of edges one is at banks, with one of its two triangles on each side.
        let n = cells as f64;
        assert!(
            (found[0] - (n - 1.0 + (SLOPE / (BANK - DEPTH)).sqrt()) / n).abs() < 2e-3,
            "{cells}: {found:?}"
        );
    }
}
