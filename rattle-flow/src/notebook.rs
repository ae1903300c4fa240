//! The method of a published notebook: the MINI element, with an active set that keeps depths from becoming negative.
//!
//! ```text
//! ∫ ((h′ − h)/Δt + ∇·q) φ = 0,    ∫ (k |q| q + g h³ ∇(b + h)) · v = 0        q = 0 on the boundary
//! h, φ linear;  q, v linear with a bubble 27 φ₀φ₁φ₂
//! ```
//!
//! It is for comparison: **its volume grows**. Where the depth would become negative, the first equation is dropped
//! (the set A), and the volume gains Δt Σ_A F, which [`Budget::remainder`](crate::Budget::remainder) shows: 1.4 % for
//! the dam break, all of it while dry ground gets wet. The iteration is PETSc's SNESVINEWTONRSLS with full steps:
//!
//! ```text
//! A = {i : hᵢ ≤ 10⁻⁸, Fᵢ > 0};   J_II y = −F_I, y_A = 0;   x ← max(x + y, 0 for depth)
//! until |F_I| < 10⁻⁸ of what it was, J being that of √(q² + ε²) in the place of |q|
//! ```
//!
//! In still water there is nothing but rounding from the start, and in small flows equations of volume have more of it
//! than 10⁻⁸ of those of momentum: after the first iterate each Fᵢ that is at the rounding of its terms counts as 0.
//! The numbers 10⁻⁸ and ε = 10⁻³ are lengths and fluxes of the notebook's: where all of q is far below ε the iteration
//! may not end. [`Notebook::with_epsilon`] takes another ε; it is in the derivative alone, so that the equations stay
//! the same. Friction k is that at the centroid of each triangle, where the notebook evaluates it at each point of
//! quadrature.
//!
//! Shapero, "Overland flow" (notebook); Arnold, Brezzi, Fortin 1984 for the element.

use crate::budget::Budget;
use crate::error::FlowError;
use crate::flow::{Flow, Resistance, squares};
use crate::method::{Method, StepInfo, Trouble};
use crate::plane::signed_area;
use crate::sparse::Sparse;
use rattle::lanes::Lanes;
use rattle::real::Real;
use rattle_macros::residual;
use std::array::from_fn;

residual! {
    /// The momentum equation at a point, friction and weight, with the vectors q and s = ∇(b + h).
    pub struct Momentum {
        /// What rounds |q| off at 0, in the derivative alone.
        epsilon
    }
    |h, s: [f64; 2], q: [f64; 2]|
    given |k, g|
    {
        let weight = g * h^3;
        [k * norm(q) * q + weight * s]
        linearise [k * sqrt(dot(q, q) + epsilon^2) * q + weight * s]
    }
}

/// So many triangles go side by side.
const L: usize = 8;
type Wide = Lanes<f64, L>;

/// Unknowns of a triangle: depth at three corners, q at three corners, q of the bubble.
const LOCAL: usize = 9;

/// A quadrature point: barycentric coordinates, bubble, weight.
struct Point {
    hats: [f64; 3],
    bubble: f64,
    weight: f64,
}

/// The method of the MINI element with an active set; its volume grows.
pub struct Notebook {
    points: Vec<Point>,
    /// ∇φ of three hats and the area, of each triangle.
    shapes: Vec<([[f64; 2]; 3], f64)>,
    places: Vec<[[u32; LOCAL]; LOCAL]>,
    matrix: Sparse,
    fixed: Vec<bool>,
    /// q at the vertices, and of each bubble.
    q: Vec<[f64; 2]>,
    bubbles: Vec<[f64; 2]>,
    before: (Vec<[f64; 2]>, Vec<[f64; 2]>),
    /// By element: what recovers the bubble, −J⁻¹ r and −J⁻¹ Jₖ.
    recovery: Vec<([f64; 2], [[f64; LOCAL]; 2])>,
    residual: Vec<f64>,
    /// The same before bubbles are eliminated, and the sum of the sizes of its terms.
    plain: Vec<f64>,
    terms: Vec<f64>,
    /// The squares of the bubbles' equations, of those that count.
    of_bubbles: f64,
    epsilon: f64,
}

/// The element's equations, depth first, then q by vertex, then the bubble.
struct Element {
    residual: [f64; LOCAL + 2],
    /// The sizes of its terms, added up.
    terms: [f64; LOCAL + 2],
    jacobian: [[f64; LOCAL + 2]; LOCAL + 2],
}

impl Notebook {
    /// The notebook's ε, a flux.
    pub const EPSILON: f64 = 1e-3;

    /// The method for a flow with the law of Darcy and Weisbach, with ε = 10⁻³ as in the notebook. Another law,
    /// infiltration, inflow and outlets are [refused](crate::FlowError::NotServed) before the run.
    pub fn of(flow: &Flow) -> Self {
        Self::with_epsilon(flow, Self::EPSILON)
    }

    /// The same with this ε, which is to be well below q (the notebook's is 1/27 of the mean of |q|), but not by so
    /// much that dry ground has no derivative.
    /// A flow is not [started](Flow::simulate_by) with one that is not a number from 10⁻¹⁵⁰ to 10¹⁵⁰:
    /// [`FlowError::Number`].
    ///
    /// ```
    /// use rattle_flow::{Flow, Mesh, Notebook, Resistance};
    /// // A film of millimetres on a hillside of two metres: q is 10⁻⁴ m²/s at most.
    /// let mesh = Mesh::polygon(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]], 0.25)?;
    /// let flow = Flow::over(mesh, Resistance::DarcyWeisbach { gravity: 9.81 }).terrain(|[x, _]| 0.1 * x);
    /// let depth = vec![1e-3; flow.mesh().points().len()];
    /// let mut simulation = flow.simulate_by(depth, 1.0, |flow| Notebook::with_epsilon(flow, 1e-6))?;
    /// simulation.run(10)?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_epsilon(flow: &Flow, epsilon: f64) -> Self {
        let mesh = flow.mesh();
        let n = mesh.points().len();
        let groups = mesh.triangles().iter().map(numbers);
        let matrix = Sparse::of_groups(3 * n, groups.clone());
        let places = groups.map(|own| own.map(|row| own.map(|column| matrix.place(row, column)))).collect();
        let mut fixed = vec![false; 3 * n];
        for &vertex in mesh.boundary().iter().flatten() {
            fixed[3 * vertex as usize + 1] = true;
            fixed[3 * vertex as usize + 2] = true;
        }
        let shapes = (0..mesh.triangles().len()).map(|triangle| {
            let place = mesh.corners(triangle);
            let area = signed_area(place);
            let grad = from_fn(|i| {
                let (a, b) = (place[(i + 1) % 3], place[(i + 2) % 3]);
                [(a[1] - b[1]) / (2.0 * area), (b[0] - a[0]) / (2.0 * area)]
            });
            (grad, area)
        });
        let triangles = mesh.triangles().len();
        Notebook {
            points: quadrature(),
            shapes: shapes.collect(),
            places,
            matrix,
            fixed,
            q: vec![[0.0; 2]; n],
            bubbles: vec![[0.0; 2]; triangles],
            before: (vec![[0.0; 2]; n], vec![[0.0; 2]; triangles]),
            recovery: vec![([0.0; 2], [[0.0; LOCAL]; 2]); triangles],
            residual: vec![0.0; 3 * n],
            plain: vec![0.0; 3 * n],
            terms: vec![0.0; 3 * n],
            of_bubbles: 0.0,
            epsilon,
        }
    }

    /// Friction and weight against each test function, and their derivatives, of triangles side by side.
    fn momentum(&self, flow: &Flow, depth: &[f64], of_lane: [usize; L]) -> ([[Wide; 2]; 4], Derivatives) {
        let kernel = Momentum { epsilon: self.epsilon }.kernel::<Wide>();
        let wide = |lane: &dyn Fn(usize) -> f64| Lanes(of_lane.map(lane));
        let corner = |triangle: usize, i: usize| flow.mesh().triangles()[triangle][i] as usize;
        let h: [Wide; 3] = from_fn(|i| wide(&|t| depth[corner(t, i)]));
        let q: [[Wide; 2]; 4] = from_fn(|a| {
            from_fn(
                |x| if a < 3 { wide(&|t| self.q[corner(t, a)][x]) } else { wide(&|t| self.bubbles[t][x]) },
            )
        });
        let s: [Wide; 2] = from_fn(|x| {
            let along = |t: usize, i: usize| {
                self.shapes[t].0[i][x] * (flow.bed()[corner(t, i)] + depth[corner(t, i)])
            };
            wide(&|t| (0..3).map(|i| along(t, i)).sum())
        });
        let given = [wide(&|t| flow.friction[t]), Wide::from_f64(flow.gravity())];
        let zero = Wide::from_f64(0.0);
        let mut residual = [[zero; 2]; 4];
        let mut slopes = Derivatives {
            by_q: [[[zero; 3]; 4]; 4],
            by_h: [[[zero; 2]; 3]; 4],
            weight: [zero; 4],
            sizes: [[zero; 2]; 4],
        };
        for point in &self.points {
            let hats = point.hats.map(Wide::from_f64);
            let tests = [hats[0], hats[1], hats[2], Wide::from_f64(point.bubble)];
            let here = h[0] * hats[0] + h[1] * hats[1] + h[2] * hats[2];
            let flux: [Wide; 2] = from_fn(|x| (0..4).fold(zero, |sum, a| sum + tests[a] * q[a][x]));
            let unknowns = [here, s[0], s[1], flux[0], flux[1]];
            let (value, by) = kernel.residual_and_jacobian(&unknowns, &given);
            for a in 0..4 {
                let test = tests[a] * Wide::from_f64(point.weight);
                for x in 0..2 {
                    residual[a][x] = residual[a][x] + test * value[x];
                    slopes.sizes[a][x] = slopes.sizes[a][x] + test * value[x].abs();
                }
                slopes.weight[a] = slopes.weight[a] + test * by[0][1];
                for j in 0..3 {
                    for x in 0..2 {
                        slopes.by_h[a][j][x] = slopes.by_h[a][j][x] + test * hats[j] * by[x][0];
                    }
                }
                for b in 0..=a {
                    let both = test * tests[b];
                    let of = &mut slopes.by_q[a][b];
                    *of = [of[0] + both * by[0][3], of[1] + both * by[0][4], of[2] + both * by[1][4]];
                }
            }
        }
        (residual, slopes)
    }

    fn element(
        &self,
        flow: &Flow,
        triangle: usize,
        depths: [&[f64]; 2],
        step: f64,
        wide: &Wides,
        lane: usize,
    ) -> Element {
        let (grad, area) = &self.shapes[triangle];
        let corners = flow.mesh().triangles()[triangle].map(|vertex| vertex as usize);
        let mut residual = [0.0; LOCAL + 2];
        let mut jacobian = [[0.0; LOCAL + 2]; LOCAL + 2];
        let mut terms = [0.0; LOCAL + 2];
        let place = |a: usize, x: usize| 3 + 2 * a + x;
        for i in 0..3 {
            for j in 0..3 {
                let mass = area / if i == j { 6.0 } else { 12.0 };
                residual[i] += mass * (depths[1][corners[j]] - depths[0][corners[j]]) / step;
                terms[i] += mass * (depths[1][corners[j]] + depths[0][corners[j]]) / step;
                jacobian[i][j] = mass / step;
                for x in 0..2 {
                    let flows = area / 3.0 * grad[j][x] * self.q[corners[j]][x];
                    jacobian[i][place(j, x)] = area / 3.0 * grad[j][x];
                    residual[i] += flows;
                    terms[i] += flows.abs();
                }
            }
            for x in 0..2 {
                let bubble = -BUBBLE * area * grad[i][x]; // ∫ ∇β φᵢ = −∫ β ∇φᵢ
                jacobian[i][place(3, x)] = bubble;
                residual[i] += bubble * self.bubbles[triangle][x];
                terms[i] += (bubble * self.bubbles[triangle][x]).abs();
            }
        }
        let (values, slopes) = wide;
        // Levels are sums, and their slope is one of differences; friction is at most the weight and the sum of both.
        let level = |j: usize| flow.bed()[corners[j]].abs() + depths[1][corners[j]];
        let steep: [f64; 2] = from_fn(|x| (0..3).map(|j| grad[j][x].abs() * level(j)).sum());
        for a in 0..4 {
            for x in 0..2 {
                residual[place(a, x)] = area * values[a][x].0[lane];
                terms[place(a, x)] =
                    area * (slopes.sizes[a][x].0[lane] + 2.0 * slopes.weight[a].0[lane] * steep[x]);
                for j in 0..3 {
                    jacobian[place(a, x)][j] =
                        area * (slopes.by_h[a][j][x].0[lane] + slopes.weight[a].0[lane] * grad[j][x]);
                }
                for b in 0..4 {
                    for y in 0..2 {
                        jacobian[place(a, x)][place(b, y)] =
                            area * slopes.by_q[a.max(b)][a.min(b)][x + y].0[lane];
                    }
                }
            }
        }
        Element { residual, terms, jacobian }
    }

    /// All equations and their derivatives, without the bubbles. Of these, equations up to `rounded` parts of their
    /// terms do not count.
    fn assemble(&mut self, flow: &Flow, depth: &[f64], guess: &[f64], step: f64, rain: &[f64], rounded: f64) {
        self.residual.fill(0.0);
        self.plain.fill(0.0);
        self.terms.fill(0.0);
        self.matrix.values.fill(0.0);
        self.of_bubbles = 0.0;
        let triangles = flow.mesh().triangles();
        for first in (0..triangles.len()).step_by(L) {
            let wide = self.momentum(flow, guess, from_fn(|lane| (first + lane).min(triangles.len() - 1)));
            for lane in 0..L.min(triangles.len() - first) {
                let triangle = first + lane;
                let Element { residual, terms, jacobian } =
                    self.element(flow, triangle, [depth, guess], step, &wide, lane);
                let [[a, b], [c, d]] = [9, 10].map(|i| [jacobian[i][9], jacobian[i][10]]);
                let determinant = a * d - b * c;
                let solved =
                    |r: [f64; 2]| [(b * r[1] - d * r[0]) / determinant, (c * r[0] - a * r[1]) / determinant];
                let own = solved([residual[9], residual[10]]);
                let columns: [[f64; 2]; LOCAL] = from_fn(|j| solved([jacobian[9][j], jacobian[10][j]]));
                self.recovery[triangle] = (own, from_fn(|x| columns.map(|column| column[x])));
                let counting = (9..11).filter(|&i| counts(residual[i], terms[i], rounded));
                self.of_bubbles += counting.map(|i| residual[i].powi(2)).sum::<f64>();
                let rows = numbers(&triangles[triangle]);
                for i in 0..LOCAL {
                    let row = rows[i] as usize;
                    self.terms[row] += terms[i];
                    self.plain[row] += residual[i];
                    self.residual[row] += residual[i] + jacobian[i][9] * own[0] + jacobian[i][10] * own[1];
                    for j in 0..LOCAL {
                        let column = columns[j];
                        self.matrix.values[self.places[triangle][i][j] as usize] +=
                            jacobian[i][j] + jacobian[i][9] * column[0] + jacobian[i][10] * column[1];
                    }
                }
            }
        }
        for (i, rain) in rain.iter().enumerate() {
            self.residual[3 * i] -= rain;
            self.plain[3 * i] -= rain;
            self.terms[3 * i] += rain;
        }
    }

    /// Where an equation is not asked for: q on the boundary, and depth that is held at zero.
    fn idle(&self, guess: &[f64]) -> Vec<bool> {
        let held = |i: usize| i.is_multiple_of(3) && guess[i / 3] <= HELD && self.plain[i] > 0.0;
        (0..self.fixed.len()).map(|i| self.fixed[i] || held(i)).collect()
    }

    fn iterate(
        &mut self,
        flow: &Flow,
        depth: &[f64],
        guess: &mut [f64],
        step: f64,
        rain: &[f64],
    ) -> Result<usize, Trouble> {
        let mut first = None;
        let mut change = vec![0.0; self.residual.len()];
        for iteration in 0..=MOST {
            let rounded = if iteration == 0 { 0.0 } else { ROUNDED };
            self.assemble(flow, depth, guess, step, rain, rounded);
            let idle = self.idle(guess);
            let counting =
                (0..idle.len()).filter(|&i| !idle[i] && counts(self.plain[i], self.terms[i], rounded));
            let size = (counting.map(|i| self.plain[i].powi(2)).sum::<f64>() + self.of_bubbles).sqrt();
            let start = *first.get_or_insert(size);
            if iteration > 0 && size <= 1e-8 * start || size < 1e-50 {
                return Ok(iteration);
            }
            change.iter_mut().zip(&self.residual).for_each(|(change, r)| *change = -r);
            for row in (0..idle.len()).filter(|&row| idle[row]) {
                change[row] = 0.0;
                let columns: Vec<usize> = self.matrix.column(row).map(|(column, _)| column).collect();
                for column in columns {
                    let place = self.matrix.place(row as u32, column as u32) as usize;
                    self.matrix.values[place] = f64::from(u8::from(column == row));
                }
            }
            self.matrix.factorise().map_err(|place| Trouble::Singular { vertex: place / 3 })?;
            self.matrix.solve(&mut change);
            if let Some(place) = change.iter().position(|x| !x.is_finite()) {
                return Err(Trouble::Singular { vertex: place / 3 });
            }
            for (triangle, corners) in flow.mesh().triangles().iter().enumerate() {
                let own = numbers(corners).map(|i| change[i as usize]);
                let (rest, by) = &self.recovery[triangle];
                for x in 0..2 {
                    self.bubbles[triangle][x] += rest[x] + (0..LOCAL).map(|j| by[x][j] * own[j]).sum::<f64>();
                }
            }
            for i in 0..guess.len() {
                guess[i] = (guess[i] + change[3 * i]).max(0.0);
                (0..2).for_each(|x| self.q[i][x] += change[3 * i + 1 + x]);
            }
        }
        let depths = (0..guess.len()).map(|i| (i, change[3 * i].abs()));
        let (vertex, change) = depths.fold((0, 0.0), |best, own| if own.1 > best.1 { own } else { best });
        Err(Trouble::NotConverged { iterations: MOST, change, vertex })
    }
}

/// So many iterations, as PETSc has it.
const MOST: usize = 50;
/// Depth up to here counts as none, as PETSc has it.
const HELD: f64 = 1e-8;
/// Each term is a product of some eight rounded factors, and rounding of sums is of random sign.
const ROUNDED: f64 = 8.0 * f64::EPSILON;

/// Whether an equation is more than this part of its terms, or no number.
fn counts(residual: f64, terms: f64, rounded: f64) -> bool {
    !residual.is_finite() || residual.abs() > rounded * terms
}

/// ∫ 27 φ₀φ₁φ₂ over the area: 27 · 2!/5!.
const BUBBLE: f64 = 0.45;

/// Derivatives of momentum against each test function.
struct Derivatives {
    /// Of functions a ≥ b: ∂x by x, by y, and ∂y by y.
    by_q: [[[Wide; 3]; 4]; 4],
    by_h: [[[Wide; 2]; 3]; 4],
    /// ∫ g h³ v.
    weight: [Wide; 4],
    /// Of momentum, ∫ |k |q| q + g h³ ∇(b + h)| v.
    sizes: [[Wide; 2]; 4],
}

type Wides = ([[Wide; 2]; 4], Derivatives);

/// The numbers of a triangle's unknowns: depth at three corners, then q at each.
fn numbers(corners: &[u32; 3]) -> [u32; LOCAL] {
    let [a, b, c] = corners.map(|vertex| 3 * vertex);
    [a, b, c, a + 1, a + 2, b + 1, b + 2, c + 1, c + 2]
}

/// Gauss's rule with six points along each of two sides, collapsed to a triangle: exact up to degree 10.
fn quadrature() -> Vec<Point> {
    // Gauss and Legendre on (−1, 1), six points.
    let nodes = [0.238_619_186_083_196_9, 0.661_209_386_466_264_5, 0.932_469_514_203_152];
    let weights = [0.467_913_934_572_691_04, 0.360_761_573_048_138_6, 0.171_324_492_379_170_35];
    let line: Vec<(f64, f64)> = (0..3)
        .flat_map(|i| {
            [(0.5 * (1.0 - nodes[i]), 0.5 * weights[i]), (0.5 * (1.0 + nodes[i]), 0.5 * weights[i])]
        })
        .collect();
    let mut points = Vec::new();
    for &(u, wu) in &line {
        for &(v, wv) in &line {
            let hats = [u, v * (1.0 - u), (1.0 - u) * (1.0 - v)];
            let bubble = 27.0 * hats[0] * hats[1] * hats[2];
            points.push(Point { hats, bubble, weight: 2.0 * wu * wv * (1.0 - u) });
        }
    }
    points
}

impl Method for Notebook {
    fn serves(&self, flow: &Flow) -> Result<(), FlowError> {
        let expected = "a number from 1e-150 to 1e150; 1e-3 is the notebook's";
        squares("the ε of the notebook's method", self.epsilon, expected)?;
        let some = |rates: &[f64]| rates.iter().any(|&rate| rate != 0.0);
        let wanting = [
            (!matches!(flow.resistance, Resistance::DarcyWeisbach { .. }), "the law of Gauckler and Manning"),
            (some(&flow.infiltration), "infiltration"),
            (flow.has_inflow(), "inflow"),
            (some(&flow.outlet), "outlets"),
        ];
        match wanting.into_iter().find(|(wanted, _)| *wanted) {
            Some((_, what)) => Err(FlowError::NotServed { method: "the notebook's method", what }),
            None => Ok(()),
        }
    }

    fn step(
        &mut self,
        flow: &Flow,
        depth: &[f64],
        guess: &mut [f64],
        step: f64,
        (rain, _): (&[f64], &[f64]),
    ) -> Result<StepInfo, Trouble> {
        self.before.0.copy_from_slice(&self.q);
        self.before.1.copy_from_slice(&self.bubbles);
        guess.copy_from_slice(depth);
        match self.iterate(flow, depth, guess, step, rain) {
            Ok(iterations) => {
                let rain = step * rain.iter().sum::<f64>();
                Ok(StepInfo { iterations, booked: Budget { rain, ..Budget::default() } })
            }
            Err(trouble) => {
                self.undo();
                Err(trouble)
            }
        }
    }

    fn undo(&mut self) {
        self.q.copy_from_slice(&self.before.0);
        self.bubbles.copy_from_slice(&self.before.1);
    }

    fn mean_flux(&self, flow: &Flow, _: &[f64]) -> f64 {
        let mut sum = 0.0;
        for (triangle, corners) in flow.mesh().triangles().iter().enumerate() {
            let q = corners.map(|vertex| self.q[vertex as usize]);
            let at = |point: &Point, x: usize| {
                let linear: f64 = (0..3).map(|i| point.hats[i] * q[i][x]).sum();
                linear + point.bubble * self.bubbles[triangle][x]
            };
            let size = |point: &Point| point.weight * at(point, 0).hypot(at(point, 1));
            sum += self.shapes[triangle].1 * self.points.iter().map(size).sum::<f64>();
        }
        sum / flow.mesh().area()
    }

    fn flux(&self, flow: &Flow, _: &[f64]) -> Vec<[f64; 2]> {
        let mean = |(triangle, corners): (usize, &[u32; 3])| {
            let linear = |x| corners.iter().map(|&vertex| self.q[vertex as usize][x]).sum::<f64>() / 3.0;
            from_fn(|x| linear(x) + BUBBLE * self.bubbles[triangle][x])
        };
        flow.mesh().triangles().iter().enumerate().map(mean).collect()
    }
}
