//! Meshes of Gmsh: its format `.msh`, versions 2.2 and 4.1, in ASCII.

use crate::mesh::Mesh;
use crate::plane::signed_area;
use crate::read::{ReadError, Words, bytes};
use std::collections::{HashMap, HashSet};
use std::path::Path;

/// Gmsh's number for triangles with three nodes.
const TRIANGLE: usize = 2;
/// Nodes of Gmsh's kinds of elements, from 1: lines, triangles, quadrangles, tetrahedra, …, points.
const NODES: [usize; 15] = [2, 3, 4, 4, 8, 6, 5, 3, 6, 9, 10, 27, 18, 14, 1];

impl Mesh {
    /// Reads the triangles of a file written by Gmsh, projected to the plane. Points, lines and solids, and nodes that
    /// belong to no triangle, are left out. The remaining nodes are renumbered in order. If all triangles are
    /// clockwise, they are reversed. A triangle that is written once for each of its physical groups is one triangle.
    /// A file that contradicts itself is refused: by more or fewer nodes or elements than it announces, a node that is
    /// there twice, or a triangle of a node that is not there.
    ///
    /// # Errors
    /// [`ReadError`], with the number of the line. [`ReadError::Hole`] for quadrangles and elements of higher order.
    #[doc(alias = "load")]
    #[doc(alias = "msh")]
    pub fn read_gmsh(path: impl AsRef<Path>) -> Result<Mesh, ReadError> {
        // Names of groups may be in any encoding, and files that are no text say so in their first section.
        Mesh::from_gmsh(&String::from_utf8_lossy(&bytes(path.as_ref())?))
    }

    /// As [`read_gmsh`](Mesh::read_gmsh), from the text of such a file.
    ///
    /// ```
    /// let text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n\
    ///             $Elements\n1\n1 2 2 0 1 1 2 3\n$EndElements\n";
    /// assert_eq!(rattle_flow::Mesh::from_gmsh(text)?.area(), 0.5);
    /// # Ok::<(), rattle_flow::ReadError>(())
    /// ```
    ///
    /// # Errors
    /// [`ReadError`], with the number of the line.
    pub fn from_gmsh(text: &str) -> Result<Mesh, ReadError> {
        let mut words = Words::of(text);
        let (mut is_new, mut nodes, mut triangles) = (None, None, None);
        while let Some(word) = words.next() {
            let is_there = match word {
                "$MeshFormat" => is_new.is_some(),
                "$Nodes" => nodes.is_some(),
                "$Elements" => triangles.is_some(),
                _ => false,
            };
            if is_there {
                return Err(words.wrong("each section once", word));
            }
            match word {
                "$MeshFormat" => is_new = Some(version(&mut words)?),
                "$Nodes" => nodes = Some(read_nodes(&mut words, is_new)?),
                "$Elements" => triangles = Some(read_triangles(&mut words, is_new)?),
                _ => {} // of another section
            }
        }
        let nodes = nodes.ok_or(ReadError::Missing { section: "$Nodes" })?;
        let triangles = triangles.ok_or(ReadError::Missing { section: "$Elements" })?;
        built(nodes, triangles)
    }
}

/// Whether the version is 4.1, and not 2.2.
fn version(words: &mut Words) -> Result<bool, ReadError> {
    let number = words.next().unwrap_or("");
    let binary = words.number::<u32>("0 for ASCII, 1 for binary")? != 0;
    match number {
        _ if binary => Err(ReadError::Version { found: "a binary file".to_owned() }),
        "2.2" | "2" => Ok(false),
        "4.1" => Ok(true),
        _ => Err(ReadError::Version { found: format!("version {number}") }),
    }
}

type Node = (u64, [f64; 2]);

fn place(words: &mut Words) -> Result<[f64; 2], ReadError> {
    let place = [words.number("a coordinate")?, words.number("a coordinate")?];
    words.number::<f64>("a coordinate")?;
    Ok(place)
}

/// The number of a node that is new.
fn named(words: &mut Words, seen: &mut HashSet<u64>) -> Result<u64, ReadError> {
    let name = words.number("the number of a node")?;
    if seen.insert(name) { Ok(name) } else { Err(words.wrong("each node once", &name.to_string())) }
}

/// The end of a section whose blocks, if it has any, hold what is announced for all of them.
fn ended(
    words: &mut Words,
    [end, in_blocks]: [&'static str; 2],
    counts: [usize; 2],
) -> Result<(), ReadError> {
    if counts[0] != counts[1] {
        return Err(words.wrong(in_blocks, &counts[0].to_string()));
    }
    let found = words.next().unwrap_or("");
    if end.contains(&format!("`{found}`")) { Ok(()) } else { Err(words.wrong(end, found)) }
}

fn read_nodes(words: &mut Words, is_new: Option<bool>) -> Result<Vec<Node>, ReadError> {
    let told =
        ["`$EndNodes` behind as many nodes as are announced", "as many nodes in all blocks as are announced"];
    let (mut nodes, mut seen) = (Vec::new(), HashSet::new());
    if !is_new.ok_or(ReadError::Missing { section: "$MeshFormat" })? {
        let count = words.number::<usize>("the number of nodes")?;
        for _ in 0..count {
            nodes.push((named(words, &mut seen)?, place(words)?));
        }
        ended(words, told, [count; 2])?;
        return Ok(nodes);
    }
    let blocks = words.number::<usize>("the number of blocks")?;
    let announced = words.number::<usize>("the number of nodes")?;
    for _ in 0..2 {
        words.number::<u64>("numbers of nodes")?;
    }
    for _ in 0..blocks {
        let dimension = words.number::<usize>("a dimension")?;
        words.number::<i64>("the number of an entity")?;
        let parametric = words.number::<usize>("0 or 1")?;
        let count = words.number::<usize>("the number of nodes")?;
        let first = nodes.len();
        for _ in 0..count {
            nodes.push((named(words, &mut seen)?, [0.0; 2]));
        }
        for i in 0..count {
            nodes[first + i].1 = place(words)?;
            for _ in 0..dimension * parametric.min(1) {
                words.number::<f64>("a parameter of a node")?;
            }
        }
    }
    ended(words, told, [nodes.len(), announced])?;
    Ok(nodes)
}

/// A triangle by the numbers of its nodes, and its line.
type Triangle = ([u64; 3], usize);

fn corners(words: &mut Words) -> Result<Triangle, ReadError> {
    let mut corner = || words.number("the number of a node");
    let corners = [corner()?, corner()?, corner()?];
    Ok((corners, words.line()))
}

/// Reads past an element that is none of a surface.
fn skipped(words: &mut Words, kind: usize) -> Result<(), ReadError> {
    let hole = |found, advice| Err(ReadError::Hole { line: words.line(), found, advice });
    match kind {
        3 | 10 | 16 | 36..=41 | 47..=51 => {
            return hole("a quadrangle", "mesh it without `Recombine Surface` and `Mesh.RecombineAll`");
        }
        9 | 20..=25 | 42..=46 => {
            return hole(
                "a triangle of higher order",
                "`gmsh -2 -order 1 in.geo -o out.msh` makes plain ones",
            );
        }
        _ => {}
    }
    let count = match kind {
        1..=15 => NODES[kind - 1],
        // Lines of higher order.
        26..=28 => kind - 22,
        62..=66 => kind - 55,
        _ => return Err(words.wrong("points, lines, triangles or simple solids", &format!("kind {kind}"))),
    };
    (0..count).try_for_each(|_| words.number::<u64>("the number of a node").map(drop))
}

fn read_triangles(words: &mut Words, is_new: Option<bool>) -> Result<Vec<Triangle>, ReadError> {
    let told = [
        "`$EndElements` behind as many elements as are announced",
        "as many elements in all blocks as are announced",
    ];
    let mut triangles = Vec::new();
    if !is_new.ok_or(ReadError::Missing { section: "$MeshFormat" })? {
        let count = words.number::<usize>("the number of elements")?;
        for _ in 0..count {
            words.number::<u64>("the number of an element")?;
            let kind = words.number::<usize>("the kind of an element")?;
            for _ in 0..words.number::<usize>("the number of tags")? {
                words.number::<i64>("a tag")?;
            }
            if kind == TRIANGLE { triangles.push(corners(words)?) } else { skipped(words, kind)? }
        }
        ended(words, told, [count; 2])?;
        return Ok(triangles);
    }
    let blocks = words.number::<usize>("the number of blocks")?;
    let announced = words.number::<usize>("the number of elements")?;
    for _ in 0..2 {
        words.number::<u64>("numbers of elements")?;
    }
    let mut elements = 0;
    for _ in 0..blocks {
        words.number::<usize>("a dimension")?;
        words.number::<i64>("the number of an entity")?;
        let kind = words.number::<usize>("the kind of an element")?;
        for _ in 0..words.number::<usize>("the number of elements")? {
            words.number::<u64>("the number of an element")?;
            elements += 1;
            if kind == TRIANGLE { triangles.push(corners(words)?) } else { skipped(words, kind)? }
        }
    }
    ended(words, told, [elements, announced])?;
    Ok(triangles)
}

fn built(nodes: Vec<Node>, mut named: Vec<Triangle>) -> Result<Mesh, ReadError> {
    let mut seen = HashSet::new();
    named.retain(|(corners, _)| {
        let mut corners = *corners;
        corners.sort_unstable();
        seen.insert(corners)
    });
    let used: HashSet<u64> = named.iter().flat_map(|(corners, _)| *corners).collect();
    let nodes: Vec<Node> = nodes.into_iter().filter(|(name, _)| used.contains(name)).collect();
    let index: HashMap<u64, u32> = nodes.iter().enumerate().map(|(i, (name, _))| (*name, i as u32)).collect();
    let points: Vec<[f64; 2]> = nodes.iter().map(|(_, place)| *place).collect();
    let mut triangles = Vec::with_capacity(named.len());
    for (corners, line) in named {
        let number = |name: u64| {
            let expected = "a node of the section `$Nodes`";
            index.get(&name).copied().ok_or_else(|| ReadError::Word {
                line,
                expected,
                found: name.to_string(),
            })
        };
        let [a, b, c] = corners.map(number);
        triangles.push([a?, b?, c?]);
    }
    let place = |vertex: u32| points[vertex as usize];
    if triangles.iter().all(|corners| signed_area(corners.map(place)) < 0.0) {
        triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
    }
    Ok(Mesh::new(points, triangles)?)
}
