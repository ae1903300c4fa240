//! A magnetic field, which turns momenta and does no work.

use crate::effect::flow::Flow;
use crate::effect::interval::{Inertia, Interval, diagonal, inverse_mass};
use crate::error::EffectMistake;
use crate::number::linear::solve_positive;
use crate::number::real::Real;
use crate::number::vector::{dot, scaled};
use std::array::from_fn;

/// A uniform magnetic field, for charges in space or in a plane (H. Lorentz 1895).
///
/// ```text
/// ṗ = e v × B       e a charge, B in the unit of momentum over charge and length
/// ```
///
/// Each half of the flow turns the momentum by arctan(ω h/2), ω = e|B|/m, of a step h: two halves that meet make the
/// turn of J. Boris (1970), tan(φ/2) = ω h/2. So the drift across the field under a constant force f is f × B/(e B²) at
/// any h ω, also where steps do not resolve the rotation. Kinetic energy is conserved to rounding, with constraints
/// too, and steps are reversible. For free bodies RATTLE with this field is Boris' method, which is symplectic: its
/// positions are those of a discrete action with the vector potential B × q/2. With constraints, momenta are turned at
/// fixed positions. This is reversible and conserves volume and energy, but is symplectic only to second order
/// (`cargo test --release --test effects flows::`). Steps that follow the rotation itself have h ω below ½: a turn is
/// too slow by (h ω)²/12 of itself.
///
/// A field that depends on position is a [`Flow`] of your own, with the same formula: a turn by arctan(ω h) in the time
/// h that it is handed. For bodies in the plane only the
/// third component of B counts.
///
/// ```
/// use rattle::effect::MagneticField;
/// use rattle::prelude::*;
///
/// let scene = Scene::point().with(MagneticField::new([0.0, 0.0, 1.0]));
/// let start = State::at([0.0, 0.0, 0.0]).moving([1.0, 0.0, 0.0]); // a circle of radius 1
/// let mut simulation = scene.simulate(start, Rattle::new(0.01))?;
/// simulation.run(1000)?;
/// let centre = -rattle::nalgebra::Vector3::y();
/// assert!(((simulation.position() - centre).norm() - 1.0).abs() < 1e-4);
/// assert!(simulation.work().abs() < 1e-15);
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "Lorentz force")]
#[doc(alias = "Boris")]
#[doc(alias = "charge")]
#[doc(alias = "cyclotron")]
#[derive(Debug, Clone, PartialEq)]
pub struct MagneticField {
    field: [f64; 3],
    /// Of each body; without, 1.
    charges: Option<Vec<f64>>,
}

impl MagneticField {
    /// The field B, for bodies of charge 1.
    #[must_use]
    pub fn new(field: [f64; 3]) -> Self {
        Self { field, charges: None }
    }

    /// The same for bodies of these charges.
    ///
    /// ```
    /// use rattle::effect::MagneticField;
    /// use rattle::prelude::*;
    ///
    /// // An ion, its opposite, and a neutral body, all along x.
    /// let field = MagneticField::new([0.0, 0.0, 1.0]).charges([1.0, -1.0, 0.0]);
    /// let start = State::of([[0.0; 3]; 3]).moving([1.0, 0.0, 0.0]);
    /// let mut simulation = Scene::points(3).with(field).simulate(start, Rattle::new(0.01))?;
    /// simulation.run(100)?;
    /// let [ion, opposite, neutral] = [0, 1, 2].map(|i| simulation.positions().nth(i).unwrap());
    /// assert!(ion.y < -0.4 && (ion.y + opposite.y).abs() < 1e-15 && neutral.y == 0.0);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    #[must_use]
    pub fn charges(mut self, charges: impl IntoIterator<Item = f64>) -> Self {
        self.charges = Some(charges.into_iter().collect());
        self
    }

    /// h e B of a body.
    fn turn<T: Real>(&self, h: f64, body: usize) -> [T; 3] {
        let charge = self.charges.as_ref().map_or(1.0, |charges| charges[body]);
        self.field.map(|b| T::from_f64(h * charge * b))
    }

    /// What a momentum in space changes by in a time h.
    fn in_space<T: Real>(&self, h: f64, inertia: &dyn Inertia<T, 3>, body: usize, p: &[T; 3]) -> [T; 3] {
        let [a, b, c] = self.turn(0.5 * h, body);
        turned(inertia, body, p, |[x, y, z]| [y * c - z * b, z * a - x * c, x * b - y * a])
    }

    /// What a momentum in the plane changes by in a time h.
    fn in_plane<T: Real>(&self, h: f64, inertia: &dyn Inertia<T, 2>, body: usize, p: &[T; 2]) -> [T; 2] {
        let [.., c] = self.turn(0.5 * h, body);
        turned(inertia, body, p, |[x, y]| [y * c, -(x * c)])
    }

    fn look(&self, bodies: usize) -> Result<(), EffectMistake> {
        EffectMistake::unless_for_each(self.charges.as_deref(), bodies)?;
        self.field.iter().try_for_each(|&b| EffectMistake::unless_finite("a component of the field", b))?;
        self.charges.iter().flatten().try_for_each(|&e| EffectMistake::unless_finite("a charge", e))
    }
}

impl Flow<3> for MagneticField {
    const WORKS: bool = false;

    fn flow<T: Real>(&self, during: &Interval<'_, T, 3>, changes: &mut [[T; 3]]) {
        for (body, (change, p)) in changes.iter_mut().zip(during.momenta).enumerate() {
            *change = self.in_space(during.h, during.inertia, body, p);
        }
    }

    fn linear(&self, h: f64, body: usize, inertia: &dyn Inertia<f64, 3>) -> Option<[[f64; 3]; 3]> {
        Some(matrix(|p| self.in_space(h, inertia, body, p)))
    }

    fn check(&self, bodies: usize) -> Result<(), EffectMistake> {
        self.look(bodies)
    }
}

impl Flow<2> for MagneticField {
    const WORKS: bool = false;

    fn flow<T: Real>(&self, during: &Interval<'_, T, 2>, changes: &mut [[T; 2]]) {
        for (body, (change, p)) in changes.iter_mut().zip(during.momenta).enumerate() {
            *change = self.in_plane(during.h, during.inertia, body, p);
        }
    }

    fn linear(&self, h: f64, body: usize, inertia: &dyn Inertia<f64, 2>) -> Option<[[f64; 2]; 2]> {
        Some(matrix(|p| self.in_plane(h, inertia, body, p)))
    }

    fn check(&self, bodies: usize) -> Result<(), EffectMistake> {
        self.look(bodies)
    }
}

/// The matrix of a linear map, row by row.
fn matrix<const D: usize>(map: impl Fn(&[f64; D]) -> [f64; D]) -> [[f64; D]; D] {
    let columns: [[f64; D]; D] = unit_vectors().map(|e| map(&e));
    from_fn(|i| from_fn(|k| columns[k][i]))
}

/// What a momentum changes by under ṗ = 2 A M⁻¹p in the unit of time, A antisymmetric, turned by arctan(ω): ±iω are the
/// eigenvalues of 2 A M⁻¹ that are not 0. By A. Cayley's transform, (1 − s A M⁻¹) (p′ − p) = 2 s A M⁻¹p: a turn by
/// 2 arctan(s ω/2), with s ω/2 = tan(arctan(ω)/2). Where M is not diagonal a pivot of that matrix may vanish, and
/// none of M − s A: (M − s A) M⁻¹(p′ − p) = 2 s A M⁻¹p.
fn turned<T: Real, const D: usize>(
    inertia: &dyn Inertia<T, D>,
    body: usize,
    p: &[T; D],
    a: impl Fn([T; D]) -> [T; D],
) -> [T; D] {
    let inverse = inverse_mass(inertia, body).map(&a);
    let share = share(&inverse);
    let a = |v: [T; D]| scaled(share, &a(v));
    let (one, twice) = (unit_vectors(), scaled(T::from_f64(2.0), &a(inertia.velocity(body, p))));
    if diagonal(inertia, body).is_some() {
        let columns = inverse.map(|column| scaled(share, &column));
        return solve_positive(from_fn(|i| from_fn(|k| one[i][k] - columns[k][i])), twice);
    }
    let columns = one.map(|e| inertia.root(body, &e)); // of L, with M = L Lᵀ
    let root: [[T; D]; D] = from_fn(|i| from_fn(|k| columns[k][i]));
    let mass: [[T; D]; D] = from_fn(|i| from_fn(|k| dot(&root[i], &root[k])));
    let columns = one.map(&a);
    let change = solve_positive(from_fn(|i| from_fn(|k| mass[i][k] - columns[k][i])), twice);
    mass.map(|row| dot(&row, &change))
}

/// s = tan(arctan(ω)/2) · 2/ω = 2/(1 + √(1 + ω²)), from the columns of A M⁻¹: ω² = −2 tr(A M⁻¹)². NaN where ω² is
/// infinite, since bodies would go straight on.
fn share<T: Real, const D: usize>(columns: &[[T; D]; D]) -> T {
    let mut square = T::from_f64(0.0);
    for i in 0..D {
        for k in 0..D {
            square = (T::from_f64(-2.0) * columns[k][i]).multiply_add(columns[i][k], square);
        }
    }
    let root = (T::from_f64(1.0) + square).sqrt();
    let share = T::from_f64(2.0) / (T::from_f64(1.0) + root);
    T::select(root.le(T::from_f64(f64::MAX)), share, T::from_f64(f64::NAN))
}

/// Vectors of length 1 along the axes.
fn unit_vectors<T: Real, const D: usize>() -> [[T; D]; D] {
    from_fn(|i| from_fn(|k| T::from_f64(f64::from(u8::from(i == k)))))
}
