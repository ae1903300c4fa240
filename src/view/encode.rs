//! The data of a page as JSON; numbers as base64, little-endian.
//!
//! ```text
//! times, sizes, curves, attitudes  f32          points, colours  u16 of a cube or a range
//! indices                          u16 or u32   normals          i16
//! ```
//!
//! A point is rounded to 1/65535 of the scene's cube, a thirtieth of a pixel; the page has half the size of one with
//! f32. A graphics processor knows f32 alone: the page draws from a middle of the scene and in a unit of its own, which
//! are kept as f64, as are the middle of a chart and the first time, from which all times are told.

use super::mesh::Mesh;
use super::parts::{End, Moved, Strip};
use super::scene::Scene3;
use crate::base64::base64;
use crate::constant::is_constant;
use serde_json::{Value, json};
use std::borrow::Borrow;

/// The scene, whose surfaces have these numbers among the page's meshes.
pub(super) fn scene_json(scene: &Scene3, meshes: &[usize]) -> Value {
    let bodies = scene.positions.len();
    let mut places: Vec<[f64; 3]> = Vec::new();
    let mut index = |end: &End| match end {
        End::Body(body) => *body as u32,
        End::Place(place) => {
            places.push(*place);
            (bodies + places.len() - 1) as u32
        }
    };
    let rods: Vec<u32> = scene.rods.iter().flatten().map(&mut index).collect();
    let discs: Vec<Value> = scene
        .discs
        .iter()
        .map(|disc| json!({ "centre": index(&disc.centre), "axis": disc.axis, "radius": disc.radius }))
        .collect();
    // As the times that they are compared with.
    let starts = scene.surfaces.iter().map(|(time, _)| match f64::from(scene.since_first(*time)) {
        start if start.is_finite() => start,
        endless => 1e300_f64.copysign(endless),
    });
    let (middle, unit) = space(scene);
    let sizes = scene.sizes.as_ref().map(|sizes| {
        let (each, rows) = rows(sizes, bodies);
        json!({ "each": each, "values": singles(rows.into_iter().flatten()) })
    });
    let heat = scene.heat.as_ref().map(|(label, values)| scale_json(label, values.len(), values));
    let tints = scene.tints.as_ref().map(|(label, values)| {
        let (each, rows) = rows(values, bodies);
        scale_json(label, each, &rows.concat())
    });
    json!({
        "title": scene.title,
        "caption": scene.caption,
        "meshes": meshes,
        "starts": starts.collect::<Vec<f64>>(),
        "heat": heat,
        "trail": scene.trail.min(scene.times.len()),
        "seconds": scene.seconds,
        "middle": middle,
        "unit": unit,
        "periods": scene.periods,
        "particles": bodies,
        "from": scene.times[0],
        "times": letters(scene.times.iter().flat_map(|time| scene.since_first(*time).to_le_bytes())),
        "positions": points_json(scene.positions.iter().flatten()),
        "sizes": sizes,
        "tints": tints,
        "names": scene.names,
        "places": places,
        "rods": letters(rods.into_iter().flat_map(u32::to_le_bytes)),
        "discs": discs,
        "walls": scene.walls,
        "boxes": scene.boxes.iter().map(box_json).collect::<Vec<_>>(),
        "axes": scene.axes,
        "charts": scene.charts.iter().map(chart_json).collect::<Vec<_>>(),
    })
}

/// Where the page's own coordinates begin, and their unit, a power of two near half of the size: of the surfaces, so
/// that scenes on the same mesh share both, or else of all that has a place.
fn space(scene: &Scene3) -> ([f64; 3], f64) {
    let mut points: Vec<[f64; 3]> =
        scene.surfaces.iter().flat_map(|(_, mesh)| &mesh.vertices).copied().collect();
    if points.is_empty() {
        points.extend(scene.positions.iter().flatten());
        let ends = scene.rods.iter().flatten().chain(scene.discs.iter().map(|disc| &disc.centre));
        points.extend(ends.filter_map(|end| if let End::Place(place) = end { Some(*place) } else { None }));
        for [corner, a, b] in &scene.walls {
            let at = |i: f64, j: f64| [0, 1, 2].map(|k| corner[k] + i * a[k] + j * b[k]);
            points.extend([at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(1.0, 1.0)]);
        }
        for Moved { sides, centres, .. } in &scene.boxes {
            let beside =
                |sign: f64| centres.iter().map(move |q| [0, 1, 2].map(|i| q[i] + 0.5 * sign * sides[i]));
            points.extend(beside(-1.0).chain(beside(1.0)));
        }
    }
    let sides = [0, 1, 2].map(|i| ends(points.iter().map(|point| point[i]).filter(|x| x.is_finite())));
    let half = sides.map(|[low, high]| 0.5 * (high - low)).into_iter().fold(0.0, f64::max);
    let unit = if half > 0.0 { half.log2().floor().exp2() } else { 1.0 };
    (sides.map(|[low, high]| low + 0.5 * (high - low)), unit)
}

/// The least and the largest, or zero where there is none.
fn ends(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let end = |pick: fn(f64, f64) -> f64| values.clone().reduce(pick).unwrap_or(0.0);
    [end(f64::min), end(f64::max)]
}

/// Values less their middle: small changes of a large number would be lost in f32.
fn chart_json(strip: &Strip) -> Value {
    let [low, high] = ends(strip.curves.iter().flat_map(|(_, values)| values).copied());
    let middle = low + 0.5 * (high - low);
    let curve = |(label, values): &(String, Vec<f64>)| json!({ "label": label, "values": singles(values.iter().map(|value| value - middle)) });
    json!({ "title": strip.title, "middle": middle, "curves": strip.curves.iter().map(curve).collect::<Vec<_>>() })
}

/// A row for each body, all of the same length: one number for all times is repeated where others have more.
fn rows(lists: &[Vec<f64>], bodies: usize) -> (usize, Vec<Vec<f64>>) {
    let each = lists.iter().map(Vec::len).max().unwrap_or(1);
    let full = |list: &Vec<f64>| if list.len() < each { vec![list[0]; each] } else { list.clone() };
    (each, (0..bodies).map(|body| full(&lists[body.min(lists.len() - 1)])).collect())
}

/// Numbers as 16-bit fractions of their range; those of a constant are 0.
fn scale_json(label: &str, each: usize, values: &[f64]) -> Value {
    let [low, high] = ends(values.iter().copied());
    let span = if is_constant(low, high) { f64::INFINITY } else { high - low };
    let fraction = |value: &f64| (((value - low) / span * f64::from(u16::MAX)).round() as u16).to_le_bytes();
    json!({ "label": label, "low": low, "high": high, "each": each, "values": letters(values.iter().flat_map(fraction)) })
}

/// Attitudes as quaternions x, y, z, w.
fn box_json(shape: &Moved) -> Value {
    let turns = shape.axes.iter().flat_map(quaternion);
    json!({ "sides": shape.sides, "centres": points_json(shape.centres.iter()), "turns": singles(turns) })
}

/// Of a rotation with these columns (Shepperd 1978): the largest of its four parts first, so that nothing small
/// divides.
fn quaternion(columns: &[[f64; 3]; 3]) -> [f64; 4] {
    let q = |row: usize, column: usize| columns[column][row];
    let trace = q(0, 0) + q(1, 1) + q(2, 2);
    let squares = [2.0 * q(0, 0) - trace, 2.0 * q(1, 1) - trace, 2.0 * q(2, 2) - trace, trace]; // 4x² − 1, …
    let largest = (0..4).fold(0, |best, i| if squares[i] > squares[best] { i } else { best });
    let twice = (1.0 + squares[largest]).max(0.0).sqrt();
    let mut parts = [0.0; 4];
    parts[largest] = 0.5 * twice;
    for i in (0..4).filter(|i| *i != largest) {
        let sum = match (i.min(largest), i.max(largest)) {
            (a, 3) => q((a + 2) % 3, (a + 1) % 3) - q((a + 1) % 3, (a + 2) % 3),
            (a, b) => q(a, b) + q(b, a),
        };
        parts[i] = 0.5 * sum / twice;
    }
    parts
}

/// A closed mesh is turned outwards, so that the page needs to draw front faces only: where a back face peeps out at
/// the outline, its light would fray the edge.
pub(super) fn mesh_json(mesh: &Mesh) -> Value {
    let closed = mesh.is_closed();
    let inverted = closed && mesh.volume() < 0.0;
    let sign = if inverted { -1.0 } else { 1.0 };
    let wide = mesh.vertices.len() > usize::from(u16::MAX);
    let indices = mesh.triangles.iter().flat_map(|&[a, b, c]| if inverted { [a, c, b] } else { [a, b, c] });
    let normal = |&component: &f64| ((sign * component * f64::from(i16::MAX)).round() as i16).to_le_bytes();
    json!({
        "closed": closed,
        "vertices": points_json(mesh.vertices.iter()),
        "normals": letters(mesh.normals.iter().flatten().flat_map(normal)),
        "wide": wide,
        "triangles": if wide {
            letters(indices.flat_map(u32::to_le_bytes))
        } else {
            letters(indices.flat_map(|i| (i as u16).to_le_bytes()))
        },
    })
}

/// Points as 16-bit fractions of the cube around them.
fn points_json<'a>(points: impl Iterator<Item = &'a [f64; 3]> + Clone) -> Value {
    let sides = [0, 1, 2].map(|i| ends(points.clone().map(|p| p[i])));
    let corner = sides.map(|[low, _]| low);
    let size = sides.iter().map(|[low, high]| high - low).fold(f64::MIN_POSITIVE, f64::max);
    let fraction = |i: usize, x: f64| ((x - corner[i]) / size * f64::from(u16::MAX)).round() as u16;
    let bytes = points.clone().flat_map(|p| [0, 1, 2].map(|i| fraction(i, p[i]).to_le_bytes())).flatten();
    json!({ "corner": corner, "size": size, "points": letters(bytes) })
}

fn singles(values: impl IntoIterator<Item = impl Borrow<f64>>) -> String {
    letters(values.into_iter().flat_map(|value| (*value.borrow() as f32).to_le_bytes()))
}

fn letters(bytes: impl IntoIterator<Item = u8>) -> String {
    base64(&bytes.into_iter().collect::<Vec<u8>>())
}
