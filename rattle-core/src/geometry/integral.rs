//! Integrals over a closed surface, without a mesh and without a parametrisation.
//!
//! ```text
//! ∫ f dA = Σ_k ∬ Σ f w_k dA_k,   w_k = |n_k|⁵ / (n_x⁶ + n_y⁶ + n_z⁶)
//!          k = x, y, z;  the inner sum is over the points where a line along axis k meets the surface
//! ```
//!
//! A piece dA of the surface has the projection dA_k = |n_k| dA onto the plane across axis k, so Σ w_k dA_k = dA.
//! Nothing is divided by |n_k|, which is 0 at the rim of a projection. Powers 1 and 2 instead of 5 and 6 would be exact
//! too. But then the integrand would go to zero at the rim like √d, with d the distance from the rim, and a rule of
//! equal weights would lose its order. With 5 and 6 it goes to zero like d^(5/2).
//!
//! The lines are those of a grid, so that one value of g per grid point serves all three directions. Between two
//! neighbours with different signs of g lies a point of the surface, found by Newton's method inside this bracket.
//!
//! **Error**: of order c⁴ in the distance c between lines, c^(7/2) where the rim is straight along the grid. The number
//! of lines per smallest radius of curvature matters: two give about 1 %, six a few 1e-4. Two sheets nearer than c can
//! be missed. Where the normal jumps the error is of first order: that of the area is up to c times the length of the
//! edges; and so is that of ∫ K dA where the curvature jumps. [`Measure::uncertainty`] tells whether lines are too few.
//! That the genus is near an integer does not: on thin tori whose area is wrong by two thirds it is 1.004.

use crate::geometry::curvature::Curvature;
use crate::kernel::functions::{Constraint, ConstraintKernel};
use crate::kernel::kinks::{first_kink, sign_changes};
use nalgebra::SVector;
use std::f64::consts::TAU;

type Point = SVector<f64, 3>;

/// A meeting point is found when the next displacement is below this part of a cell: far below the error of the rule.
const FOUND: f64 = 1e-9;
/// A singular point is on the surface when it is nearer than this part of a cell.
const SINGULAR: f64 = 1e-6;
/// An edge is on the surface where it is nearer than this part of the way to it along a tangent …
const BESIDE: f64 = 0.1;
/// … and turns the normal by more than this.
const SHARP: f64 = 1e-5;
/// Bisection alone takes 30 steps, Newton's method three or four.
const ROOT_STEPS: usize = 60;
/// More lines, and the two planes of values kept would take more than a gigabyte.
const MOST_LINES: usize = 8192;

/// Area and total curvature of a closed surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measure {
    /// ∫ dA.
    pub area: f64,
    /// By how much other rules from the same points differ from the area: one of weights |n_k|, and one of every second
    /// line each way, of which there are four. Both are far less exact, so where the surface is resolved its area is
    /// far nearer than this; where this is a good part of the area, lines are too few.
    pub uncertainty: f64,
    /// ∫ K dA, with the Gaussian curvature K.
    pub total_curvature: f64,
}

impl Measure {
    /// χ = ∫ K dA/2π (Gauss and Bonnet): an integer, up to the error of the integral.
    #[must_use]
    pub fn euler_characteristic(&self) -> f64 {
        self.total_curvature / TAU
    }

    /// 1 − ∫ K dA/4π: for a connected surface its genus, the number of handles, up to the error of the integral. A
    /// surface of several pieces has Σ(genus − 1) + 1.
    #[must_use]
    pub fn genus(&self) -> f64 {
        1.0 - self.total_curvature / (2.0 * TAU)
    }
}

/// Area and total curvature of the closed surface g = 0 inside the box from `low` to `high`.
///
/// `lines` is the number of grid cells along the longest side of the box; g is evaluated (lines + 1)³ times or less.
///
/// # Errors
/// Those of [`integrate`], and [`IntegralError::Edge`] where the normal jumps: ∫ K dA lacks what the surface turns by
/// there. Normals are compared where the formula has kinks, such as those of `abs`, `max` or `if`.
#[doc(alias = "surface area")]
#[doc(alias = "genus")]
pub fn measure<C: Constraint<3, 1>>(
    surface: &C,
    low: [f64; 3],
    high: [f64; 3],
    lines: usize,
) -> Result<Measure, IntegralError> {
    let kernel = surface.kernel::<f64>();
    let (mut area, mut total_curvature, mut plain, mut halves) = (0.0, 0.0, 0.0, [0.0; 4]);
    for_each(surface, low, high, lines, |found| {
        let Found { q, normal, weight, shadow, line, cell } = found;
        if let Some(edge) = edge(&kernel, &q, &normal, cell) {
            return Err(edge);
        }
        area += weight;
        total_curvature += weight * finite(&q, surface.gaussian_curvature(&q))?;
        plain += shadow;
        halves[2 * (line[0] % 2) + line[1] % 2] += 4.0 * weight;
        Ok(())
    })?;
    let off = halves.map(|half: f64| (half - area).abs());
    let uncertainty = (plain - area).abs() + off.into_iter().fold(0.0, f64::max);
    Ok(Measure { area, uncertainty, total_curvature })
}

/// Where the normal jumps within a cell of a place of the surface, on the surface, if it does.
fn edge<K: ConstraintKernel<f64, 3, 1>>(
    kernel: &K,
    q: &Point,
    normal: &Point,
    cell: f64,
) -> Option<IntegralError> {
    if K::KINKS.is_empty() {
        return None;
    }
    let aside = Point::ith(normal.iamin(), 1.0).cross(normal).normalize();
    let across = normal.cross(&aside);
    let from = [[q.x, q.y, q.z]];
    [aside, -aside, across, -across].iter().find_map(|way| {
        let to = [(q + way * cell).into()];
        if !sign_changes(kernel, &from, &to) {
            return None;
        }
        let kink = first_kink::<f64, _, 3, 1, 1>(kernel, &from, &to)?;
        let point = [kink.place[0], kink.place[1], kink.place[2]];
        let ([value], [gradient]) = kernel.value_and_jacobian(&point);
        // Between two sheets normals jump off the surface.
        let on = value.abs() <= BESIDE * kink.share * cell * Point::from(gradient).norm();
        (on && kink.angle > SHARP).then_some(IntegralError::Edge { point, angle: kink.angle })
    })
}

/// ∫ f(q, n) dA over the closed surface g = 0 inside the box from `low` to `high`, for several f at once. n is ∇g/|∇g|.
///
/// `lines` is the number of grid cells along the longest side of the box; g is evaluated (lines + 1)³ times or less, f
/// about 3/2 times for each c² of the area, c being the side of a cell. Where the normal jumps, the error is of first
/// order in c.
///
/// # Errors
/// [`IntegralError::Box`] and [`IntegralError::Lines`] for an invalid grid, [`IntegralError::Cut`] when the surface
/// leaves the box, [`IntegralError::Empty`] when no line meets it, [`IntegralError::NotFinite`] where g, ∇g or f is
/// not, [`IntegralError::Jump`] where g changes sign without being zero, [`IntegralError::Singular`] where ∇g = 0.
#[doc(alias = "quadrature")]
#[doc(alias = "surface integral")]
pub fn integrate<C: Constraint<3, 1>, const N: usize>(
    surface: &C,
    low: [f64; 3],
    high: [f64; 3],
    lines: usize,
    mut f: impl FnMut(&Point, &Point) -> [f64; N],
) -> Result<[f64; N], IntegralError> {
    let mut sums = [0.0; N];
    for_each(surface, low, high, lines, |Found { q, normal, weight, .. }| {
        for (sum, value) in sums.iter_mut().zip(f(&q, &normal)) {
            *sum += weight * finite(&q, value)?;
        }
        Ok(())
    })?;
    Ok(sums)
}

/// A value of the function under an integral.
fn finite(q: &Point, value: f64) -> Result<f64, IntegralError> {
    let wrong = IntegralError::NotFinite { what: "f", point: (*q).into(), value };
    if value.is_finite() { Ok(value) } else { Err(wrong) }
}

/// A point where a line meets the surface.
struct Found {
    q: Point,
    /// ∇g/|∇g|.
    normal: Point,
    /// The area that it stands for.
    weight: f64,
    /// The same by the weight |n_k|.
    shadow: f64,
    /// The numbers of the line, across it.
    line: [usize; 2],
    /// The longest side of a cell.
    cell: f64,
}

/// Shows all points where lines meet the surface.
fn for_each<C: Constraint<3, 1>>(
    surface: &C,
    low: [f64; 3],
    high: [f64; 3],
    lines: usize,
    mut show: impl FnMut(Found) -> Result<(), IntegralError>,
) -> Result<(), IntegralError> {
    let grid = Grid::new(low, high, lines)?;
    let kernel = surface.kernel::<f64>();
    let cell = grid.step.into_iter().fold(0.0, f64::max);
    let mut met = false;
    grid.crossings(&kernel, |crossing| {
        met = true;
        let (q, gradient) = crossing.root(&kernel)?;
        let turn = surface.hessian_vector(&q, &gradient).norm();
        // |∇g|²/|∇²g ∇g| is the distance to the point where ∇g = 0, to first order.
        if gradient.norm_squared() <= SINGULAR * crossing.cell * turn || gradient.norm() == 0.0 {
            return Err(IntegralError::Singular { point: q.into() });
        }
        let normal = gradient / gradient.norm();
        let shadow = grid.shadow(crossing.axis);
        let weight = shadow * share(&normal, crossing.axis);
        let shadow = shadow * normal[crossing.axis].abs();
        show(Found { q, normal, weight, shadow, line: crossing.line, cell })
    })?;
    if met { Ok(()) } else { Err(IntegralError::Empty { low, high, lines }) }
}

/// w_k: what a shadow of area 1 across `axis` counts of the surface above it.
fn share(normal: &Point, axis: usize) -> f64 {
    normal[axis].abs().powi(5) / normal.map(|x| x.powi(6)).sum()
}

/// Points low + i·step, i = 0 … cells along each axis.
struct Grid {
    low: [f64; 3],
    step: [f64; 3],
    cells: [usize; 3],
}

impl Grid {
    fn new(low: [f64; 3], high: [f64; 3], lines: usize) -> Result<Self, IntegralError> {
        let side = [0, 1, 2].map(|k| high[k] - low[k]);
        if !side.iter().all(|&side| side > 0.0 && side.is_finite()) {
            return Err(IntegralError::Box { low, high });
        }
        if !(2..=MOST_LINES).contains(&lines) {
            return Err(IntegralError::Lines(lines));
        }
        let longest = side.into_iter().fold(0.0, f64::max);
        let cells = side.map(|side| ((side / longest * lines as f64).ceil() as usize).max(2));
        Ok(Self { low, step: [0, 1, 2].map(|k| side[k] / cells[k] as f64), cells })
    }

    fn point(&self, index: [usize; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| self.low[k] + index[k] as f64 * self.step[k])
    }

    /// The area across `axis` that a line along it stands for.
    fn shadow(&self, axis: usize) -> f64 {
        self.step[(axis + 1) % 3] * self.step[(axis + 2) % 3]
    }

    /// Shows every change of sign between neighbours, plane by plane along x.
    fn crossings<K: ConstraintKernel<f64, 3, 1>>(
        &self,
        kernel: &K,
        mut see: impl FnMut(Crossing) -> Result<(), IntegralError>,
    ) -> Result<(), IntegralError> {
        let [nx, ny, nz] = self.cells;
        let [mut before, mut here] = [(); 2].map(|()| vec![0.0; (ny + 1) * (nz + 1)]);
        let mut outside = None;
        for i in 0..=nx {
            std::mem::swap(&mut before, &mut here);
            for j in 0..=ny {
                for k in 0..=nz {
                    let q = self.point([i, j, k]);
                    let [value] = kernel.value(&q);
                    if !value.is_finite() {
                        return Err(IntegralError::NotFinite { what: "g", point: q, value });
                    }
                    let at = j * (nz + 1) + k;
                    here[at] = value;
                    let border = i == 0 || i == nx || j == 0 || j == ny || k == 0 || k == nz;
                    if border && *outside.get_or_insert(positive(value)) != positive(value) {
                        return Err(IntegralError::Cut { point: q });
                    }
                    let neighbours = [
                        (i > 0).then(|| before[at]),
                        (j > 0).then(|| here[at - nz - 1]),
                        (k > 0).then(|| here[at - 1]),
                    ];
                    for (axis, neighbour) in neighbours.into_iter().enumerate() {
                        let Some(neighbour) = neighbour.filter(|&g| positive(g) != positive(value)) else {
                            continue;
                        };
                        let line = [[j, k], [i, k], [i, j]][axis];
                        see(Crossing {
                            end: q,
                            axis,
                            line,
                            cell: self.step[axis],
                            values: [neighbour, value],
                        })?;
                    }
                }
            }
        }
        Ok(())
    }
}

/// A zero at a grid point belongs to one side, so that it is met once.
fn positive(g: f64) -> bool {
    g >= 0.0
}

/// A change of sign between `end − cell` and `end` along `axis`.
struct Crossing {
    end: [f64; 3],
    axis: usize,
    /// The numbers of the line, across the axis.
    line: [usize; 2],
    cell: f64,
    values: [f64; 2],
}

impl Crossing {
    /// The point between, and ∇g there.
    fn root<K: ConstraintKernel<f64, 3, 1>>(&self, kernel: &K) -> Result<(Point, Point), IntegralError> {
        let Self { end, axis, cell, values: [before, after], .. } = *self;
        let (mut low, mut high) = (end[axis] - cell, end[axis]);
        let mut q = end;
        q[axis] -= cell * after / (after - before);
        for _ in 0..ROOT_STEPS {
            let ([value], [gradient]) = kernel.value_and_jacobian(&q);
            if let Some(&number) = [value].iter().chain(&gradient).find(|number| !number.is_finite()) {
                return Err(IntegralError::NotFinite { what: "g or ∇g", point: q, value: number });
            }
            *(if positive(value) == positive(after) { &mut high } else { &mut low }) = q[axis];
            let newton = q[axis] - value / gradient[axis];
            let next = if low <= newton && newton <= high { newton } else { 0.5 * (low + high) };
            if (next - q[axis]).abs() > FOUND * cell {
                q[axis] = next;
                continue;
            }
            let gradient = Point::from(gradient);
            // Bisection ends at poles and steps too, but g is not small there.
            let pole = value.abs() > 1e3 * before.abs().max(after.abs());
            let step = value.abs() > 1e-3 * cell * gradient.norm();
            if pole || step {
                return Err(IntegralError::Jump { point: q, value });
            }
            return Ok((q.into(), gradient));
        }
        Err(IntegralError::Jump { point: q, value: kernel.value(&q)[0] })
    }
}

/// Why an integral over a surface could not be taken.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IntegralError {
    /// A box that is empty, turned or not finite.
    #[error("the box from {low:?} to {high:?} has no volume; every side must be finite and longer than 0")]
    Box {
        /// Its least coordinates.
        low: [f64; 3],
        /// Its greatest coordinates.
        high: [f64; 3],
    },
    /// Too few lines to measure with, or too many to keep.
    #[error("can't lay {0} lines along a box; between 2 and 8192 can be")]
    Lines(usize),
    /// The surface is not closed, or larger than the box.
    #[error("the surface leaves the box near {point:?}; integrals need a closed surface and room around it")]
    Cut {
        /// A point on the side of the box before which g changed its sign.
        point: [f64; 3],
    },
    /// g has one sign on the whole grid.
    #[error(
        "no line meets the surface: g has one sign at all grid points from {low:?} to {high:?} with {lines} lines; \
         try another box, or more lines"
    )]
    Empty {
        /// Least coordinates of the box.
        low: [f64; 3],
        /// Greatest coordinates of the box.
        high: [f64; 3],
        /// Lines along its longest side.
        lines: usize,
    },
    /// A number that is NaN or infinite.
    #[error("{what} is {value} at {point:?}; it must be finite in the whole box")]
    NotFinite {
        /// `g`, its gradient, or the function under the integral.
        what: &'static str,
        /// Where.
        point: [f64; 3],
        /// The number.
        value: f64,
    },
    /// g changes its sign but is not zero: a pole, or a step.
    #[error(
        "g changes sign near {point:?} without being zero (g = {value:e}): a pole or a step, not a surface"
    )]
    Jump {
        /// Where.
        point: [f64; 3],
        /// g next to it.
        value: f64,
    },
    /// The surface has no normal.
    #[error("∇g = 0 on the surface at {point:?}; it is singular there")]
    Singular {
        /// Where.
        point: [f64; 3],
    },
    /// The normal of the surface jumps.
    #[error(
        "the surface has an edge near {point:?}, where its normal jumps by {angle:.3}: the integral of K lacks what the \
         surface turns by there, and with it the genus; `integrate` has the area alone, to first order in the distance \
         of lines"
    )]
    Edge {
        /// Where.
        point: [f64; 3],
        /// The angle between the normals on both sides.
        angle: f64,
    },
}
