//! Errors, with the numbers that explain them.

/// What is wrong with a mesh.
#[derive(Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A coordinate of a vertex is not finite.
    #[error("vertex {vertex} is at ({x}, {y}); expected finite coordinates")]
    NotFinite {
        /// Which one.
        vertex: usize,
        /// Its first coordinate.
        x: f64,
        /// Its second coordinate.
        y: f64,
    },
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} names vertex {vertex}, and there are {vertices}")]
    NoVertex {
        /// Which triangle.
        triangle: usize,
        /// The vertex it names.
        vertex: usize,
        /// The number of vertices.
        vertices: usize,
    },
    /// A triangle is clockwise, or flat.
    #[error(
        "triangle {triangle} at ({x:.6}, {y:.6}) has the area {area:e}; expected vertices in counter-clockwise order"
    )]
    Inverted {
        /// Which triangle.
        triangle: usize,
        /// Where it is, by its centroid.
        x: f64,
        /// Where it is, by its centroid.
        y: f64,
        /// Its signed area.
        area: f64,
    },
    /// Two triangles lie on the same side of an edge.
    #[error("triangles {first} and {second} both have the edge from vertex {from} to {to}: they overlap")]
    Overlap {
        /// One triangle.
        first: usize,
        /// The other.
        second: usize,
        /// Where the edge begins.
        from: usize,
        /// Where it ends.
        to: usize,
    },
    /// Two triangles that have no edge in common lie over each other.
    #[error(
        "triangles {first} and {second} both cover ({x:.6}, {y:.6}): they overlap; leave one out, or move the one \
         piece of the mesh away from the other"
    )]
    Over {
        /// One triangle.
        first: usize,
        /// The other.
        second: usize,
        /// Where both are.
        x: f64,
        /// Where both are.
        y: f64,
    },
    /// A vertex lies inside the edge of a triangle that does not have it as a vertex.
    #[error(
        "vertex {vertex} hangs on the edge from {from} to {to} of triangle {triangle}; split the triangle there"
    )]
    Hanging {
        /// The vertex.
        vertex: usize,
        /// Where the edge begins.
        from: usize,
        /// Where it ends.
        to: usize,
        /// The triangle of the edge.
        triangle: usize,
    },
    /// A vertex belongs to no triangle.
    #[error("vertex {vertex} belongs to no triangle; leave it out")]
    Loose {
        /// Which one.
        vertex: usize,
    },
    /// The mesh has no triangle.
    #[error("the mesh has no triangle")]
    Empty,
    /// Two vertices of the boundary are at one place: between their triangles would be a wall of no width.
    #[error(
        "vertices {first} and {second} of the boundary are both at ({x:.6}, {y:.6}): nothing would flow between their \
         triangles; make them one vertex, or leave a gap where a wall is meant"
    )]
    Seam {
        /// One vertex.
        first: usize,
        /// The other.
        second: usize,
        /// Where they are.
        x: f64,
        /// Where they are.
        y: f64,
    },
    /// Two sides of a polygon cross or touch, elsewhere than in a corner that both have.
    #[error(
        "the sides of the polygon that begin at corners {first} and {second} meet at ({x:.6}, {y:.6}); expected \
         sides that meet in their common corners alone (corners are counted from 0)"
    )]
    SidesMeet {
        /// The corner where one side begins.
        first: usize,
        /// The corner where the other begins.
        second: usize,
        /// Where they meet.
        x: f64,
        /// Where they meet.
        y: f64,
    },
    /// The corners are not those of a polygon, or the spacing is too fine.
    #[error("the polygon of {corners} corners with spacing {spacing} cannot be meshed: {reason}")]
    Polygon {
        /// The number of corners given.
        corners: usize,
        /// The spacing asked for.
        spacing: f64,
        /// Why.
        reason: &'static str,
    },
}

/// Why a flow cannot be started, or a step not be taken.
#[derive(Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FlowError {
    /// A given number is NaN, or out of its range.
    #[error("{what} {place} is {found} at time {time}; expected {expected}")]
    Given {
        /// Which number, up to the place: "rain at vertex".
        what: &'static str,
        /// The number of its vertex; for friction, of its triangle.
        place: usize,
        /// The time.
        time: f64,
        /// What was found.
        found: f64,
        /// What was expected.
        expected: &'static str,
    },
    /// A list of numbers does not fit the mesh.
    #[error("{what}: found {found} numbers, and there are {expected} vertices")]
    Count {
        /// Which numbers.
        what: &'static str,
        /// How many were given.
        found: usize,
        /// How many are needed.
        expected: usize,
    },
    /// An outlet or an inflow is nowhere.
    #[error(
        "{what} chooses none of the {edges} edges of the boundary; it is asked at their midpoints, \
         which rounding moves: compare with a tolerance"
    )]
    NoEdge {
        /// What chooses none.
        what: &'static str,
        /// The number of edges of the boundary.
        edges: usize,
    },
    /// The method does not support a part of the flow.
    #[error("{method} does not have {what}; take it out of the flow, or simulate by the conservative method")]
    NotServed {
        /// Which method.
        method: &'static str,
        /// The part that it does not support.
        what: &'static str,
    },
    /// A number that belongs to no place, such as the time step, is NaN, or out of its range.
    #[error("{what} is {found}; expected {expected}")]
    Number {
        /// Which number.
        what: &'static str,
        /// What was found.
        found: f64,
        /// What was expected.
        expected: &'static str,
    },
    /// However short a step is, its error is above the tolerance.
    #[error(
        "at time {time} steps down to {step:e} have an error of {error:e}, above the tolerance {tolerance:e}; take a \
         larger tolerance, or name times where rain or inflow jumps by `Flow::meet`; the last good state is kept"
    )]
    TooExact {
        /// The time of the last good state.
        time: f64,
        /// The smallest time step tried.
        step: f64,
        /// Its error, relative to the water, as [`run_until`](crate::Simulation::run_until) has it.
        error: f64,
        /// The tolerance.
        tolerance: f64,
    },
    /// Newton's method did not converge, however small the step.
    #[error(
        "no depth found at time {time} with time steps down to {step:e}: after {iterations} iterations depth still \
         changes by {change:e} at vertex {vertex} ({x:.6}, {y:.6}); the last good state is kept"
    )]
    NotConverged {
        /// The time of the last good state.
        time: f64,
        /// The smallest time step tried.
        step: f64,
        /// Iterations of the last try.
        iterations: usize,
        /// The last change of depth.
        change: f64,
        /// Where it is largest.
        vertex: usize,
        /// Its place.
        x: f64,
        /// Its place.
        y: f64,
    },
    /// The linear equations are singular.
    #[error(
        "the linear equations at time {time} with time step {step:e} are singular at vertex {vertex} ({x:.6}, {y:.6}); the last good state is kept"
    )]
    Singular {
        /// The time of the last good state.
        time: f64,
        /// The smallest time step tried.
        step: f64,
        /// A vertex at which the solution is NaN.
        vertex: usize,
        /// Its place.
        x: f64,
        /// Its place.
        y: f64,
    },
}

/// A program that ends with an error prints it by `Debug`: these say there what they say to a person.
macro_rules! debug_as_display {
    ($($error:ty),*) => {$(
        impl std::fmt::Debug for $error {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                std::fmt::Display::fmt(self, f)
            }
        }
    )*};
}

debug_as_display!(MeshError, FlowError, crate::ReadError);

/// An error unless there is a depth for each of so many vertices.
pub(crate) fn one_for_each_vertex(depth: &[f64], vertices: usize) -> Result<(), FlowError> {
    if depth.len() == vertices {
        return Ok(());
    }
    Err(FlowError::Count { what: "depth", found: depth.len(), expected: vertices })
}
