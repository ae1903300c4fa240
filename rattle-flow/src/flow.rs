//! A flow: terrain, friction, rain, infiltration, and boundary conditions.

use crate::conservative::Conservative;
use crate::error::{FlowError, one_for_each_vertex};
use crate::mesh::Mesh;
use crate::method::Method;
use crate::plane::{centroid, squared};
use crate::simulation::Simulation;

/// The law of resistance, whose coefficient is given for each triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Resistance {
    /// k |u| u = −g h ∇(b + h), with the pure number k: an eighth of the friction factor f of Darcy and Weisbach, as in
    /// the slope f u²/(8 g h).
    DarcyWeisbach {
        /// The gravitational acceleration g.
        gravity: f64,
    },
    /// |u| = h^(2/3) |∇(b + h)|^(1/2) / n, with n in time per cube root of length.
    Manning,
}

impl Resistance {
    /// α of |q| = c hᵅ √|∇(b + h)|.
    pub fn power(self) -> f64 {
        match self {
            Resistance::DarcyWeisbach { .. } => 1.5,
            Resistance::Manning => 5.0 / 3.0,
        }
    }
    /// c of |q| = c hᵅ √|∇(b + h)|.
    pub(crate) fn mobility(self, coefficient: f64) -> f64 {
        match self {
            Resistance::DarcyWeisbach { gravity } => (gravity / coefficient).sqrt(),
            Resistance::Manning => 1.0 / coefficient,
        }
    }
}

type Rate = Box<dyn Fn([f64; 2], f64) -> f64 + Send + Sync>;

/// A flow over a mesh. Terms that are not given are zero. Lengths and times have any units; depths have the unit of x.
///
/// ```text
/// ∂h/∂t + ∇·q = rain − infiltration        q · n = 0 on walls, by default the whole boundary
/// q = −c hᵅ ∇(b + h) / √|∇(b + h)|
/// ```
///
/// ```
/// use rattle_flow::{Flow, Mesh, Resistance};
/// let mesh = Mesh::polygon(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]], 0.25)?;
/// let depth = mesh.at_vertices(|[x, _]| if x < 1.0 { 1.0 } else { 0.0 });
/// let flow = Flow::over(mesh, Resistance::DarcyWeisbach { gravity: 9.81 }).friction(|_| 0.05);
/// let mut simulation = flow.simulate(depth, 0.01)?;
/// simulation.run(50)?;
/// assert!(simulation.depth().iter().all(|&h| h >= 0.0));
/// assert!(simulation.budget().remainder().abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias = "runoff")]
#[doc(alias = "shallow water")]
#[doc(alias = "kinematic wave")]
#[doc(alias = "hydrology")]
pub struct Flow {
    pub(crate) mesh: Mesh,
    pub(crate) resistance: Resistance,
    /// b at each vertex.
    pub(crate) terrain: Vec<f64>,
    /// k or n of each triangle.
    pub(crate) friction: Vec<f64>,
    rain: Vec<Rate>,
    /// At each vertex, length per time; of all its share, volume per time.
    rates: Vec<f64>,
    pub(crate) infiltration: Vec<f64>,
    /// Open edges, by their number in the boundary: slope, and half the length.
    open: Vec<(usize, f64, f64)>,
    /// At each vertex: Σ ½ length · c √slope of its open edges, once friction is known.
    pub(crate) outlet: Vec<f64>,
    inflow: Vec<(Vec<(u32, f64)>, Rate)>,
    /// Times that steps meet; ascending, once the flow is simulated.
    meet: Vec<f64>,
    /// What was given for edges, of which none was chosen.
    nowhere: Option<&'static str>,
}

impl Flow {
    /// Flow over flat ground, with the coefficient 1.
    pub fn over(mesh: Mesh, resistance: Resistance) -> Self {
        let (n, triangles) = (mesh.points().len(), mesh.triangles().len());
        Flow {
            resistance,
            terrain: vec![0.0; n],
            friction: vec![1.0; triangles],
            rain: Vec::new(),
            rates: vec![0.0; n],
            infiltration: vec![0.0; n],
            open: Vec::new(),
            outlet: vec![0.0; n],
            inflow: Vec::new(),
            meet: Vec::new(),
            nowhere: None,
            mesh,
        }
    }

    /// The height b of the ground, at the vertices.
    #[doc(alias = "elevation")]
    #[doc(alias = "DEM")]
    #[doc(alias = "topography")]
    #[must_use]
    pub fn terrain(mut self, height: impl Fn([f64; 2]) -> f64) -> Self {
        self.terrain = self.mesh.at_vertices(height);
        self
    }

    /// The coefficient of friction, k = f/8 or n, at the centroid of each triangle.
    #[doc(alias = "roughness")]
    #[doc(alias = "Manning")]
    #[must_use]
    pub fn friction(mut self, coefficient: impl Fn([f64; 2]) -> f64) -> Self {
        let count = self.mesh.triangles().len();
        self.friction =
            (0..count).map(|triangle| coefficient(centroid(self.mesh.corners(triangle)))).collect();
        self
    }

    /// Adds rain, in length per time, as a function of position and time; it must not be negative.
    ///
    /// A step takes the mean over its length, by Gauss's rule with three instants: at 11 %, 50 % and 89 % of the step.
    /// The budget has the same. That is exact for rates that jump between steps alone: see [`meet`](Flow::meet).
    #[doc(alias = "precipitation")]
    #[must_use]
    pub fn rain(mut self, rate: impl Fn([f64; 2], f64) -> f64 + Send + Sync + 'static) -> Self {
        self.rain.push(Box::new(rate));
        self
    }

    /// The infiltration capacity, in length per time. Where there is less water, only this water infiltrates, and the
    /// difference is counted as [unmet](crate::Budget::unmet).
    #[must_use]
    pub fn infiltration(mut self, rate: impl Fn([f64; 2]) -> f64) -> Self {
        self.rates = self.mesh.at_vertices(rate);
        self.infiltration =
            self.rates.iter().zip(self.mesh.shares()).map(|(rate, share)| rate * share).collect();
        self
    }

    /// Opens the boundary at edges whose midpoint is `chosen`: water leaves there as it would flow down a plane of this
    /// slope, q · n = c hᵅ √slope, with the friction of the triangle at the edge. An edge that is chosen again has the
    /// later slope.
    #[must_use]
    pub fn outlet(mut self, slope: f64, chosen: impl Fn([f64; 2]) -> bool) -> Self {
        let edges = self.edges("an outlet", chosen);
        self.open.retain(|open| edges.iter().all(|edge| edge.0 != open.0));
        self.open.extend(edges.into_iter().map(|(edge, half)| (edge, slope, half)));
        self
    }

    /// Times that steps meet: where rain or inflow jumps, or begins and ends soon after. Times from several calls add
    /// up.
    ///
    /// A step that would go over such a time is divided there, so that the volumes that fall and enter are exact for
    /// rates that are constant, or change like polynomials up to degree 5, from one time to the next.
    ///
    /// ```
    /// use rattle_flow::{Flow, Mesh, Resistance};
    /// let mesh = Mesh::polygon(&[[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [0.0, 1.0]], 0.5)?;
    /// let dry = vec![0.0; mesh.points().len()];
    /// let flow = Flow::over(mesh, Resistance::Manning)
    ///     .rain(|_, t| if (3600.0..3660.0).contains(&t) { 1e-5 } else { 0.0 })
    ///     .meet([3600.0, 3660.0]);
    /// let mut simulation = flow.simulate(dry, 1.0)?;
    /// simulation.run_until(7200.0, 1e-3, f64::INFINITY)?;
    /// assert!((simulation.budget().rain - 4.0 * 60.0 * 1e-5).abs() < 1e-15);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[doc(alias = "breakpoints")]
    #[doc(alias = "events")]
    #[doc(alias = "hyetograph")]
    #[must_use]
    pub fn meet(mut self, times: impl IntoIterator<Item = f64>) -> Self {
        self.meet.extend(times);
        self
    }

    /// Adds inflow over the boundary edges whose midpoint is `chosen`: −q · n with the outer normal n, positive and in
    /// area per time, as a function of position (evaluated at the ends of the edges) and time. Over an edge that is
    /// chosen again the sum enters. A step takes the mean over its length, as of [rain](Flow::rain).
    #[must_use]
    pub fn inflow(
        mut self,
        discharge: impl Fn([f64; 2], f64) -> f64 + Send + Sync + 'static,
        chosen: impl Fn([f64; 2]) -> bool,
    ) -> Self {
        let edges = self.edges("an inflow", chosen).into_iter();
        let shares =
            edges.flat_map(|(edge, half)| self.mesh.boundary()[edge].map(|vertex| (vertex, half))).collect();
        self.inflow.push((shares, Box::new(discharge)));
        self
    }

    /// The chosen edges of the boundary, by number, with half their length. It is noted where there are none.
    fn edges(&mut self, what: &'static str, chosen: impl Fn([f64; 2]) -> bool) -> Vec<(usize, f64)> {
        let with_ends = self.mesh.boundary().iter().enumerate();
        let with_ends = with_ends.map(|(edge, ends)| (edge, ends.map(|v| self.mesh.points()[v as usize])));
        let edges: Vec<_> = with_ends
            .filter(|(_, [a, b])| chosen([0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]))
            .map(|(edge, [a, b])| (edge, 0.5 * squared(a, b).sqrt()))
            .collect();
        if edges.is_empty() {
            self.nowhere = self.nowhere.or(Some(what));
        }
        edges
    }

    /// Whether water is let in over the boundary.
    pub(crate) fn has_inflow(&self) -> bool {
        !self.inflow.is_empty()
    }

    /// Whether anything falls or enters.
    pub(crate) fn has_sources(&self) -> bool {
        !self.rain.is_empty() || self.has_inflow()
    }

    /// The next time to meet after this one, with rounding of times in the past.
    pub(crate) fn next_meeting(&self, time: f64) -> Option<f64> {
        let past = time + 4.0 * f64::EPSILON * time.abs();
        self.meet.get(self.meet.partition_point(|&own| own <= past)).copied()
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }
    /// The height b of the ground at the vertices.
    pub fn bed(&self) -> &[f64] {
        &self.terrain
    }
    /// g of the law of Darcy and Weisbach, 1 for another.
    pub(crate) fn gravity(&self) -> f64 {
        match self.resistance {
            Resistance::DarcyWeisbach { gravity } => gravity,
            Resistance::Manning => 1.0,
        }
    }
    /// c of |q| = c hᵅ √|∇(b + h)| in a triangle.
    pub(crate) fn mobility(&self, triangle: usize) -> f64 {
        self.resistance.mobility(self.friction[triangle])
    }

    /// What falls and what enters at each vertex at a time, volume per time: (rain, inflow).
    pub(crate) fn sources(&self, time: f64, rain: &mut [f64], inflow: &mut [f64]) -> Result<(), FlowError> {
        rain.fill(0.0);
        inflow.fill(0.0);
        let vertices = self.mesh.points().iter().zip(self.mesh.shares());
        let given =
            |what, place, found| FlowError::Given { what, place, time, found, expected: AT_LEAST_ZERO };
        for rate in &self.rain {
            for (vertex, ((&place, share), sum)) in vertices.clone().zip(&mut *rain).enumerate() {
                let rate = rate(place, time);
                *sum += share * rate;
                if !(rate >= 0.0 && sum.is_finite()) {
                    return Err(given("rain at vertex", vertex, rate));
                }
            }
        }
        for (shares, discharge) in &self.inflow {
            for &(vertex, half) in shares {
                let vertex = vertex as usize;
                let discharge = discharge(self.mesh.points()[vertex], time);
                inflow[vertex] += half * discharge;
                if !(discharge >= 0.0 && inflow[vertex].is_finite()) {
                    return Err(given("inflow at vertex", vertex, discharge));
                }
            }
        }
        Ok(())
    }

    /// A simulation of the flow from this depth at the vertices at time 0, with time steps `step`, by the
    /// [conservative](Conservative) method.
    ///
    /// # Errors
    /// [`FlowError::Count`]; [`FlowError::Given`] for a depth, terrain, friction or infiltration that is negative where
    /// it must not be, or NaN; [`FlowError::Number`] for the time step, gravity, a time to meet, and the slope of an
    /// outlet;
    /// [`FlowError::NoEdge`] for an outlet or an inflow that chooses no edge.
    #[doc(alias = "integrate")]
    #[doc(alias = "solve")]
    #[doc(alias = "dt")]
    #[doc(alias = "timestep")]
    pub fn simulate(self, depth: Vec<f64>, step: f64) -> Result<Simulation<Conservative>, FlowError> {
        self.simulate_by(depth, step, Conservative::of)
    }

    /// As [`simulate`](Flow::simulate), by another method, which `method` makes for the flow.
    ///
    /// # Errors
    /// Those of [`simulate`](Flow::simulate), and [`FlowError::NotServed`] for parts of the flow that the method does
    /// not support.
    pub fn simulate_by<M: Method>(
        mut self,
        depth: Vec<f64>,
        step: f64,
        method: impl FnOnce(&Flow) -> M,
    ) -> Result<Simulation<M>, FlowError> {
        one_for_each_vertex(&depth, self.mesh.points().len())?;
        if let Resistance::DarcyWeisbach { gravity } = self.resistance {
            number("gravity", gravity, gravity > 0.0, "a positive number")?;
        }
        checked("the terrain at vertex", &self.terrain, 0.0, f64::NEG_INFINITY, "a finite height")?;
        checked("depth at vertex", &depth, 0.0, 0.0, AT_LEAST_ZERO)?;
        checked("friction of triangle", &self.friction, 0.0, f64::MIN_POSITIVE, "a positive coefficient")?;
        checked("infiltration at vertex", &self.rates, 0.0, 0.0, AT_LEAST_ZERO)?;
        for &time in &self.meet {
            number("a time to meet", time, true, "a finite number")?;
        }
        self.meet.sort_by(f64::total_cmp);
        if let Some(what) = self.nowhere {
            return Err(FlowError::NoEdge { what, edges: self.mesh.boundary().len() });
        }
        for &(edge, slope, half) in &self.open {
            number("the slope of an outlet", slope, slope >= 0.0, AT_LEAST_ZERO)?;
            let conduct = half * self.mobility(self.mesh.at_boundary()[edge] as usize) * slope.sqrt();
            self.mesh.boundary()[edge].iter().for_each(|&vertex| self.outlet[vertex as usize] += conduct);
        }
        let method = method(&self);
        method.serves(&self)?;
        Simulation::new(self, depth, step, method)
    }
}

const AT_LEAST_ZERO: &str = "a finite number that is not negative";

/// An error unless the numbers, of this time, are finite and not below the least one.
pub(crate) fn checked(
    what: &'static str,
    numbers: &[f64],
    time: f64,
    least: f64,
    expected: &'static str,
) -> Result<(), FlowError> {
    match numbers.iter().position(|&x| !x.is_finite() || x < least) {
        Some(place) => Err(FlowError::Given { what, place, time, found: numbers[place], expected }),
        None => Ok(()),
    }
}

/// An error unless the number is finite and `holds`.
pub(crate) fn number(
    what: &'static str,
    found: f64,
    holds: bool,
    expected: &'static str,
) -> Result<(), FlowError> {
    if holds && found.is_finite() { Ok(()) } else { Err(FlowError::Number { what, found, expected }) }
}

/// An error unless the square of the number is neither 0 nor infinite, nor that of a negative one.
pub(crate) fn squares(what: &'static str, found: f64, expected: &'static str) -> Result<(), FlowError> {
    number(what, found, (1e-150..=1e150).contains(&found), expected)
}
