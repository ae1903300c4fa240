//! Meshes of polygons: whole, whatever way they are turned and wherever they lie; and what is no polygon is named.
//! Meshes of many pieces, which may lie over each other.

use rattle_flow::{Flow, Mesh, MeshError, Resistance};

/// Numbers in 0 … 1, the same in every run.
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1_u64 << 53) as f64
}

/// The area by the formula of Gauss, from the first corner.
fn area(corners: &[[f64; 2]]) -> f64 {
    let from = |p: [f64; 2]| [p[0] - corners[0][0], p[1] - corners[0][1]];
    let around = corners.iter().zip(corners.iter().cycle().skip(1));
    0.5 * around.map(|(&a, &b)| (from(a), from(b))).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>().abs()
}

/// At `b`, from `a` to `c`, in degrees.
fn angle([a, b, c]: [[f64; 2]; 3]) -> f64 {
    let (u, v) = ([a[0] - b[0], a[1] - b[1]], [c[0] - b[0], c[1] - b[1]]);
    (u[0] * v[1] - u[1] * v[0]).abs().atan2(u[0] * v[0] + u[1] * v[1]).to_degrees()
}

fn least_angle(mesh: &Mesh) -> f64 {
    let of = |triangle: usize| {
        let [a, b, c] = mesh.corners(triangle);
        [[a, b, c], [b, c, a], [c, a, b]].map(angle).into_iter().fold(180.0, f64::min)
    };
    (0..mesh.triangles().len()).map(of).fold(180.0, f64::min)
}

/// The mesh covers the polygon, with so many edges on the boundary as its sides have parts, each on a side.
fn check(corners: &[[f64; 2]], spacing: f64, least: f64) -> Mesh {
    let mesh =
        Mesh::polygon(corners, spacing).unwrap_or_else(|error| panic!("{error}: {corners:?} {spacing}"));
    let far = corners.iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
    let length = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
        (a[0] - b[0]).hypot(a[1] - b[1])
    };
    let around: f64 = (0..corners.len()).map(length).sum();
    // Each point of a side may be off by rounding.
    let most = 1e-13 * area(corners) + 2.0 * f64::EPSILON * far * around;
    assert!((mesh.area() - area(corners)).abs() <= most, "{:e} of {corners:?}", mesh.area() - area(corners));
    let parts = |i: usize| (length(i) / spacing - 1e-6).ceil().max(1.0) as usize;
    let parts: usize = (0..corners.len()).map(parts).sum();
    assert_eq!(mesh.boundary().len(), parts, "{corners:?} {spacing}");
    assert!(least_angle(&mesh) > least, "{} of {corners:?} {spacing}", least_angle(&mesh));
    mesh
}

#[test]
fn a_triangle_with_a_slanted_side_is_meshed() {
    check(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], 0.1, 24.0);
}

#[test]
fn a_rectangle_is_meshed_however_it_is_turned_and_wherever_it_is() {
    for at in [[0.0, 0.0], [5e5, 5.4e6], [-5e6, 5e6]] {
        for (turn, spacing) in (0..20).flat_map(|turn| [0.1, 0.2, 0.5].map(|spacing| (turn, spacing))) {
            let (s, c) = (0.05 + 0.3 * f64::from(turn)).sin_cos();
            let corner = |x: f64, y: f64| [at[0] + c * x - s * y, at[1] + s * x + c * y];
            check(&[corner(0.0, 0.0), corner(3.0, 0.0), corner(3.0, 2.0), corner(0.0, 2.0)], spacing, 24.0);
        }
    }
}

#[test]
fn polygons_of_any_shape_are_meshed() {
    let mut state = 1;
    for round in 0..200 {
        let count = 5 + round % 7;
        let spoke = |k: usize, state: &mut u64| {
            let turn = (k as f64 + 0.6 * random(state)) * std::f64::consts::TAU / count as f64;
            let long = 100.0 + 100.0 * random(state);
            [long * turn.cos(), long * turn.sin()]
        };
        let corners: Vec<[f64; 2]> = (0..count).map(|k| spoke(k, &mut state)).collect();
        let at = |i: usize| corners[i % count];
        let sharpest = (0..count).map(|i| angle([at(i), at(i + 1), at(i + 2)])).fold(180.0, f64::min);
        check(&corners, 10.0, if sharpest > 60.0 { 24.0 } else { 0.25 * sharpest });
        let far: Vec<[f64; 2]> = corners.iter().map(|[x, y]| [4e5 + x, 5e6 + y]).collect();
        check(&far, 10.0, if sharpest > 60.0 { 24.0 } else { 0.25 * sharpest });
    }
}

/// A lake over a slanted ground, in a rectangle that is turned, in coordinates of a map: it is level, and stays so.
#[test]
fn a_lake_in_a_turned_rectangle_on_a_map_rests() {
    for (turn, spacing) in [(0.05_f64, 0.2), (0.35, 0.1), (1.15, 0.2)] {
        let ([x0, y0], (s, c)) = ([5e5, 5.4e6], turn.sin_cos());
        let corner = |x: f64, y: f64| [x0 + c * x - s * y, y0 + s * x + c * y];
        let mesh =
            Mesh::polygon(&[corner(0.0, 0.0), corner(3.0, 0.0), corner(3.0, 2.0), corner(0.0, 2.0)], spacing)
                .unwrap();
        let bed = move |[x, y]: [f64; 2]| 0.3 * (c * (x - x0) + s * (y - y0));
        let lake = mesh.at_vertices(|place| (0.45 - bed(place)).max(0.0));
        let dry = lake.iter().filter(|&&h| h == 0.0).count();
        assert!(dry > 10 && dry < lake.len() - 10, "{dry} of {}", lake.len());
        let flow = Flow::over(mesh, Resistance::Manning).terrain(bed).friction(|_| 0.05);
        let mut simulation = flow.simulate(lake.clone(), 0.1).unwrap();
        simulation.run(50).unwrap();
        let moved =
            simulation.depth().iter().zip(&lake).map(|(h, start)| (h - start).abs()).fold(0.0, f64::max);
        // Newton's method ends at 1e-10 of the largest depth.
        assert!(moved <= 1e-10 * 0.45, "depth has changed by {moved:e}");
    }
}

/// As `GeoJSON` and shapefiles have rings: closed by the first corner.
#[test]
fn a_ring_that_is_closed_is_the_same_polygon() {
    let ring = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0], [0.0, 0.0]];
    let mesh = Mesh::polygon(&ring, 0.2).unwrap();
    assert_eq!(mesh, Mesh::polygon(&ring[..4], 0.2).unwrap());
    let twice = [ring[0], ring[0], ring[1], ring[2], ring[2], ring[2], ring[3], ring[4], ring[4]];
    assert_eq!(mesh, Mesh::polygon(&twice, 0.2).unwrap());
    assert!(matches!(Mesh::polygon(&[ring[0]; 5], 0.2), Err(MeshError::Polygon { corners: 5, .. })));
}

#[test]
fn sides_that_meet_are_named() {
    type Row<'a> = (&'a [[f64; 2]], f64, [usize; 2], [f64; 2], f64);
    let rows: [Row; 6] = [
        // Two that cross; the place is known.
        (&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]], 0.1, [0, 2], [0.5, 0.5], 0.1),
        // A side that goes back on the one before: outwards, inwards, at the end.
        (
            &[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [3.0, 1.0], [2.0, 1.0], [0.0, 1.0]],
            0.2,
            [2, 3],
            [2.5, 1.0],
            0.5,
        ),
        (
            &[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.3, 1.0], [1.3, 0.4], [1.3, 1.0], [0.0, 1.0]],
            0.2,
            [3, 4],
            [1.3, 0.7],
            0.3,
        ),
        (&[[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 1.0]], 0.23, [0, 1], [1.5, 0.0], 0.5),
        // A corner on another side, exactly, and to rounding.
        (&[[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [1.7, 0.0], [0.0, 2.0]], 0.21, [0, 2], [1.7, 0.0], 1e-12),
        (&[[0.0, 0.0], [3.0, 0.3], [3.0, 2.0], [1.7, 0.17], [0.0, 2.0]], 0.21, [0, 3], [1.7, 0.17], 1e-12),
    ];
    for (corners, spacing, sides, place, near) in rows {
        match Mesh::polygon(corners, spacing) {
            Err(MeshError::SidesMeet { first, second, x, y }) => {
                assert_eq!([first, second], sides, "{corners:?}");
                assert!((x - place[0]).hypot(y - place[1]) <= near, "({x}, {y}) of {corners:?}");
            }
            other => panic!("{corners:?}: {other:?}"),
        }
    }
    let line = Mesh::polygon(&[[0.0, 0.0], [0.3, 0.1], [0.9, 0.3], [0.6, 0.2]], 0.1).unwrap_err().to_string();
    assert!(line.contains("its corners lie on one line"), "{line}");
}

/// A wedge of half a degree has triangles as thin, and its area.
#[test]
fn a_thin_wedge_is_meshed() {
    check(&[[0.0, 0.0], [10.0, 0.0], [10.0, 0.1]], 0.2, 0.5);
}

/// Whatever the numbers: a mesh or an error that names the polygon.
#[test]
fn numbers_at_the_ends_of_their_range_are_a_mesh_or_an_error() {
    let sizes = [f64::MIN_POSITIVE, 1e-160, 1e-45, 1e-12, 1e-3, 1.0, 1e16, 1e30, 1e100, f64::MAX];
    let mut meshes = 0;
    for (&size, &at) in sizes.iter().flat_map(|size| [0.0, 1.0, -1e17, 1e30].iter().map(move |at| (size, at)))
    {
        for part in [0.1, 0.5, 3.0, f64::INFINITY] {
            let corners =
                [[at, at], [at + size, at], [at + 0.7 * size, at + size], [at - size, at + 0.9 * size]];
            match Mesh::polygon(&corners, part * size) {
                Ok(mesh) => meshes += usize::from(mesh.area() > 0.0),
                Err(MeshError::Polygon { .. } | MeshError::SidesMeet { .. }) => {}
                Err(other) => panic!("{other}: {corners:?}"),
            }
        }
    }
    assert!(meshes > 10, "{meshes}");
}

/// Whether two sides have a point in common besides a corner that both have; corners are whole numbers, so it is exact.
fn meet(corners: &[[f64; 2]]) -> bool {
    let count = corners.len();
    let side = |i: usize| [corners[i % count], corners[(i + 1) % count]];
    let turn = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).partial_cmp(&0.0).unwrap() as i32
    };
    let on = |p: [f64; 2], [a, b]: [[f64; 2]; 2]| {
        let between = |x: usize| p[x] >= a[x].min(b[x]) && p[x] <= a[x].max(b[x]);
        turn(a, b, p) == 0 && between(0) && between(1)
    };
    (0..count).any(|i| {
        (i + 1..count).any(|j| {
            let ([a, b], [c, d]) = (side(i), side(j));
            if j == i + 1 || (i == 0 && j == count - 1) {
                // Of neighbours the end of one on the other, besides the corner between them.
                let (before, after) = if j == i + 1 { ([a, b], [c, d]) } else { ([c, d], [a, b]) };
                return on(after[1], before) || on(before[0], after);
            }
            let crosses = turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0;
            crosses || on(a, [c, d]) || on(b, [c, d]) || on(c, [a, b]) || on(d, [a, b])
        })
    })
}

/// Corners on a grid, at random: a polygon that is one has its area, one that is not is refused.
#[test]
fn polygons_on_a_grid_are_meshed_or_refused() {
    let (mut state, mut simple, mut refused) = (7, 0, 0);
    for round in 0..3000 {
        let count = 3 + round % 5;
        let at = |state: &mut u64| [0, 1].map(|_| (6.0 * random(state)).floor());
        let mut corners: Vec<[f64; 2]> = (0..count).map(|_| at(&mut state)).collect();
        corners.dedup();
        while corners.len() > 1 && corners[0] == corners[corners.len() - 1] {
            corners.pop();
        }
        let is_one = corners.len() >= 3 && !meet(&corners);
        // As it is; and turned, in other units, on a map, where corners are rounded and touch but for that.
        let (turn, unit) = (6.3 * random(&mut state), 10.0_f64.powf(4.0 * random(&mut state) - 2.0));
        let (s, c) = turn.sin_cos();
        let moved =
            corners.iter().map(|[x, y]| [5e5 + unit * (c * x - s * y), 5.4e6 + unit * (s * x + c * y)]);
        for (corners, unit, rounded) in [(corners.clone(), 1.0, 0.0), (moved.collect(), unit, 1e-9)] {
            match Mesh::polygon(&corners, 0.9 * unit) {
                Ok(mesh) => {
                    assert!(is_one, "{corners:?}");
                    let most = 1e-12 * unit * unit + 100.0 * unit * rounded;
                    assert!((mesh.area() - area(&corners)).abs() < most, "{} of {corners:?}", mesh.area());
                    simple += 1;
                }
                Err(error @ (MeshError::SidesMeet { .. } | MeshError::Polygon { .. })) => {
                    assert!(!is_one, "{error}: {corners:?}");
                    refused += 1;
                }
                Err(other) => panic!("{other}: {corners:?}"),
            }
        }
    }
    assert!(simple > 500 && refused > 500, "{simple} {refused}");
}

/// Two rectangles side by side whose nodes on the common side are there twice: a wall that nobody asked for.
#[test]
fn a_seam_is_refused_wherever_it_is() {
    for (at, long) in [(0.0, 1.0), (5e6, 0.1), (5e6, 10.0), (5e7, 1.0)] {
        let (s, c) = 0.3_f64.sin_cos();
        let place = |x: f64, y: f64| [at + long * (c * x - s * y), at + long * (s * x + c * y)];
        let left = [place(0.0, 0.0), place(1.0, 0.0), place(1.0, 1.0), place(0.0, 1.0)];
        let right = [place(1.0, 0.0), place(2.0, 0.0), place(2.0, 1.0), place(1.0, 1.0)];
        let triangles = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        let error = Mesh::new([left, right].concat(), triangles.clone()).unwrap_err();
        assert!(
            matches!(
                error,
                MeshError::Seam { first: 1, second: 4, .. } | MeshError::Seam { first: 2, second: 7, .. }
            ),
            "{error}"
        );
        // With a gap of a thousandth it is a wall that somebody asked for.
        let apart = right.map(|[x, y]| [x + 1e-3 * long * c, y + 1e-3 * long * s]);
        assert_eq!(Mesh::new([left, apart].concat(), triangles).unwrap().boundary().len(), 8);
    }
}

#[test]
fn a_hanging_vertex_is_found_wherever_it_is() {
    for at in [0.0, 5e5, 5e6, 5e7] {
        for (turn, long) in (0..40).flat_map(|turn| [0.1, 0.2, 1.0, 10.0].map(|long| (turn, long))) {
            let (s, c) = (0.03 + 0.15 * f64::from(turn)).sin_cos();
            let place = |x: f64, y: f64| [at + long * (c * x - s * y), at + long * (s * x + c * y)];
            let points = vec![
                place(0.0, 0.0),
                place(2.0, 0.0),
                place(2.0, 2.0),
                place(0.0, 2.0),
                place(1.0, 0.0),
                place(1.0, -1.0),
            ];
            let error = Mesh::new(points, vec![[0, 1, 2], [0, 2, 3], [0, 5, 4], [4, 5, 1]]);
            assert!(
                matches!(error, Err(MeshError::Hanging { vertex: 4, from: 0, to: 1, triangle: 0 })),
                "{error:?} at {at:e}, {long}"
            );
        }
    }
}

/// Two rings of `count` corners each around a place, with triangles between them; one radius after the other.
fn ring([x, y]: [f64; 2], radii: [f64; 2], count: u32, first: u32) -> (Vec<[f64; 2]>, Vec<[u32; 3]>) {
    let corner = |radius: f64, i: u32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(count)).sin_cos();
        [x + radius * cos, y + radius * sin]
    };
    let points = radii.into_iter().flat_map(|radius| (0..count).map(move |i| corner(radius, i))).collect();
    let triangles = (0..count).flat_map(|i| {
        let j = (i + 1) % count;
        let [a, b, c, d] = [i, count + i, count + j, j].map(|vertex| first + vertex);
        [[a, b, c], [a, c, d]]
    });
    (points, triangles.collect())
}

#[test]
fn triangles_that_lie_over_each_other_are_refused() {
    type Piece = (Vec<[f64; 2]>, Vec<[u32; 3]>);
    let of = |pieces: &[Piece]| {
        let (mut points, mut triangles) = (Vec::new(), Vec::new());
        for (own, corners) in pieces {
            let first = points.len() as u32;
            triangles.extend(corners.iter().map(|corners| corners.map(|vertex| first + vertex)));
            points.extend(own);
        }
        Mesh::new(points, triangles)
    };
    let one = |corners: [[f64; 2]; 3]| (corners.to_vec(), vec![[0, 1, 2]]);
    let large = one([[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]]);
    let around = |place, radii| ring(place, radii, 40, 0);
    let over = [
        vec![large.clone(), one([[0.3, 0.3], [1.3, 0.3], [0.3, 1.3]])],
        vec![one([[0.3, 0.3], [1.3, 0.3], [0.3, 1.3]]), large.clone()],
        vec![large.clone(), one([[0.3, 0.3], [3.0, 0.5], [0.3, 1.3]])], // crosses one side
        vec![large.clone(), one([[-0.5, 0.4], [3.0, 0.5], [3.0, 0.7]])], // crosses two
        vec![around([0.0; 2], [1.0, 2.0]), around([0.0; 2], [1.5, 3.0])],
        vec![around([0.0; 2], [1.5, 3.0]), around([0.0; 2], [1.0, 2.0])],
        vec![around([0.0; 2], [1.0, 4.0]), around([0.0; 2], [2.0, 3.0])],
        vec![around([0.0; 2], [1.0, 2.0]), one([[0.0, -9.0], [9.0, 0.1], [-9.0, 7.0]])], // covered as a whole
        vec![around([0.0; 2], [1.0, 2.0]), around([3.1, 0.05], [1.0, 2.0])], // as links of a chain
        vec![
            // One vertex in both.
            (large.0.iter().copied().chain([[0.5, 0.2], [0.2, 0.5]]).collect(), vec![[0, 1, 2], [0, 3, 4]]),
        ],
        vec![{
            // A spiral staircase of two rounds.
            let at = |k: u32| f64::from(k).mul_add(0.3, 0.0).sin_cos();
            let points = (0..42).flat_map(|k| {
                let (sin, cos) = at(k);
                [[cos, sin], [2.0 * cos, 2.0 * sin]]
            });
            (
                points.collect(),
                (0..41)
                    .flat_map(|k| [[2 * k, 2 * k + 1, 2 * k + 3], [2 * k, 2 * k + 3, 2 * k + 2]])
                    .collect(),
            )
        }],
    ];
    for (i, pieces) in over.iter().enumerate() {
        let error = of(pieces).expect_err(&i.to_string());
        let MeshError::Over { first, second, x, y } = error else { panic!("{i}: {error}") };
        let all: Vec<[[f64; 2]; 3]> = pieces
            .iter()
            .flat_map(|(points, triangles)| triangles.iter().map(|t| t.map(|v| points[v as usize])))
            .collect();
        for triangle in [first, second] {
            let [a, b, c] = all[triangle];
            let side = |a: [f64; 2], b: [f64; 2]| (b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1]);
            assert!([side(a, b), side(b, c), side(c, a)].iter().all(|side| *side > -1e-12), "{i}: {error}");
        }
        assert!(first != second, "{i}: {error}");
    }
    let beside = [
        vec![around([0.0; 2], [1.0, 2.0]), around([0.0; 2], [0.5, 0.9])], // one in the hole of the other
        vec![around([0.0; 2], [0.5, 0.9]), around([0.0; 2], [1.0, 2.0]), around([4.1, 0.0], [1.0, 2.0])],
        vec![(
            large.0.iter().copied().chain([[-0.5, -0.2], [-0.2, -0.5]]).collect(),
            vec![[0, 1, 2], [0, 3, 4]],
        )],
    ];
    for (i, pieces) in beside.iter().enumerate() {
        assert!(of(pieces).is_ok(), "{i}: {}", of(pieces).unwrap_err());
    }
}

/// Squares of two triangles that meet in corners alone, as around cells without data, over a square and beside it.
#[test]
fn pieces_that_meet_in_corners_are_told_apart() {
    let squares = |away: f64, large: bool| {
        let (mut points, mut triangles) = (Vec::new(), Vec::new());
        for (i, j) in (0..6).flat_map(|i| (0..6).map(move |j| (i, j))) {
            points.push([f64::from(i), f64::from(j)]);
            if i < 5 && j < 5 && (i + j) % 2 == 0 {
                let [a, b, c, d] = [6 * i + j, 6 * i + 6 + j, 6 * i + 7 + j, 6 * i + 1 + j];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        let corner = if large {
            [[-9.0, -9.0], [30.0, -9.0], [-9.0, 30.0]]
        } else {
            [[0.2, 0.1], [0.8, 0.1], [0.8, 0.7]]
        };
        points.extend(corner.map(|[x, y]| [x + away, y]));
        triangles.push([36, 37, 38]);
        Mesh::new(points, triangles)
    };
    for (away, large) in [(0.0, true), (0.0, false), (2.0, false), (4.0, false)] {
        let error = squares(away, large).unwrap_err();
        assert!(matches!(error, MeshError::Over { second: 26, .. }), "{away} {large}: {error}");
    }
    for (away, large) in [(1.0, false), (3.0, false), (40.0, true)] {
        assert!(squares(away, large).is_ok(), "{away} {large}");
    }
}

/// Many holes and many pieces, far from the origin: looked through in about the time that a mesh takes anyway.
#[test]
fn meshes_of_many_pieces_are_looked_through_soon() {
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    for k in 0..3000 {
        let [x, y] = [f64::from(k % 60), f64::from(k / 60)].map(|x| 5e5 + 3.0 * x);
        let first = points.len() as u32;
        let (own, corners) = ring([x, y], [0.5, 1.4], 20, first);
        points.extend(own);
        triangles.extend(corners);
    }
    let start = std::time::Instant::now();
    let mesh = Mesh::new(points, triangles).unwrap();
    assert_eq!(mesh.boundary().len(), 120_000);
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed()); // where each edge met each other: minutes
}
