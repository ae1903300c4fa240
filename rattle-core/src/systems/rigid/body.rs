//! Free attitude of rigid bodies: RATTLE on QᵀQ = 1, reduced to three unknowns.
//!
//! A body with its centre of mass at rest has the attitude Q (body → space). In terms of the nine entries of Q its
//! kinetic energy is that of a point with masses d₁, d₂, d₃ for the columns, I₁ = d₂ + d₃ and so on. RATTLE under the
//! six equations QᵀQ = 1 is then the map of J. Moser and A. Veselov (Comm. Math. Phys. 139, 1991). In terms of the
//! angular momentum m in the body's frame:
//!
//! ```text
//! m½ = m + c τ(Q)              τ̂ = QᵀF − FᵀQ,  F = −∂U/∂Q       c = h/2
//! e₀ J e + e × J e = h/2 m½    e₀ = √(1 − |e|²),  J = diag(I₁, I₂, I₃)
//! m½′ = m½ − 4/h e × J e       Q′ = Q R(e₀, e),  the rotation of this unit quaternion
//! m′ = m½′ + c τ(Q′)
//! ```
//!
//! (R. McLachlan, A. Zanna, Found. Comput. Math. 5, 2005.) Energy and angular momentum of a free body are conserved to
//! rounding.

use crate::effect::interval::Inertia;
use crate::motion::state::State;
use crate::systems::rigid::rotation::Moments;

use nalgebra::{Matrix3, Vector3};

/// What messages call such a system.
pub(crate) const REDUCED: &str = "a rigid body reduced to three unknowns";

/// A rigid body with these moments of inertia that turns about its centre of mass; with
/// [`bodies`](crate::scene::Scene::bodies) several equal ones, with effects on each or
/// [over](crate::kernel::over::Over) several. Centres of mass do not move, and links are not possible: for these use a
/// body under QᵀQ = 1 in a network (`RotationMatrix`).
///
/// Coordinates are the nine entries of the attitude Q, row by row. Momenta are the angular momentum m in the body's
/// frame, in the first three of nine components; the others are 0.
///
/// ```
/// use rattle::nalgebra::{Matrix3, Vector3};
/// use rattle::{Rattle, Rigid, Scene};
///
/// let body = Rigid::new([0.6, 0.8, 1.0]);
/// let start = Rigid::start(&Matrix3::identity(), &Vector3::new(1.8, 0.4, -0.9));
/// let mut simulation = Scene::rigid(body).simulate(start, Rattle::new(0.05))?;
/// simulation.run(1000)?;
/// assert!(simulation.energy_error().abs() < 1e-13);
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "rotation")]
#[doc(alias = "top")]
#[doc(alias = "gyroscope")]
#[doc(alias = "attitude")]
#[doc(alias = "quaternion")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rigid {
    pub(crate) inertia: Vector3<f64>,
}

impl Rigid {
    /// A body with principal moments of inertia I₁, I₂, I₃ about its first, second and third axis.
    #[must_use]
    pub fn new(moments: [f64; 3]) -> Self {
        Self { inertia: moments.into() }
    }

    /// What a step needs of them.
    pub(crate) fn moments(&self) -> Moments<f64> {
        Moments::new(self.inertia.into())
    }

    /// d₁, d₂, d₃ with I₁ = d₂ + d₃, I₂ = d₃ + d₁, I₃ = d₁ + d₂: the masses of the columns of Q.
    #[must_use]
    pub fn column_masses(&self) -> [f64; 3] {
        let half_sum = 0.5 * self.inertia.sum();
        self.inertia.map(|moment| half_sum - moment).into()
    }

    /// The nine entries of an attitude, row by row.
    #[must_use]
    pub fn coordinates(attitude: &Matrix3<f64>) -> [f64; 9] {
        std::array::from_fn(|k| attitude[(k / 3, k % 3)])
    }

    /// The attitude with these nine entries.
    #[must_use]
    pub fn attitude(coordinates: &[f64; 9]) -> Matrix3<f64> {
        Matrix3::from_row_slice(coordinates)
    }

    /// A start with this attitude and angular momentum in the body's frame.
    #[must_use]
    pub fn start(attitude: &Matrix3<f64>, angular_momentum: &Vector3<f64>) -> State<9> {
        State::at(Self::coordinates(attitude)).moving(spread(angular_momentum))
    }

    /// The same of several bodies: the attitude of each, and its angular momentum in its own frame.
    ///
    /// ```
    /// # use rattle::nalgebra::{Matrix3, Vector3};
    /// # use rattle::{Rattle, Rigid, Scene};
    /// let spins = [0.5, 0.7].map(|spin| (Matrix3::identity(), Vector3::new(0.0, 0.0, spin)));
    /// let tops = Scene::rigid(Rigid::new([1.0, 1.0, 0.4])).bodies(2);
    /// tops.simulate(Rigid::starts(spins), Rattle::new(0.01))?.run(10)?;
    /// # Ok::<(), rattle::Error>(())
    /// ```
    #[must_use]
    pub fn starts(bodies: impl IntoIterator<Item = (Matrix3<f64>, Vector3<f64>)>) -> State<9> {
        let (places, momenta): (Vec<_>, Vec<_>) =
            bodies.into_iter().map(|(q, m)| (Self::coordinates(&q), spread(&m))).unzip();
        State::of(places).with_momenta(momenta)
    }

    /// The momenta P = Q Ω̂ D of a body under QᵀQ = 1 with masses D, in a network, with this attitude and angular
    /// momentum m = J Ω.
    #[must_use]
    pub fn matrix_momenta(&self, attitude: &Matrix3<f64>, angular_momentum: &Vector3<f64>) -> [f64; 9] {
        let rate = angular_momentum.component_div(&self.inertia).cross_matrix();
        Self::coordinates(&(attitude * rate * Matrix3::from_diagonal(&self.column_masses().into())))
    }

    /// The angular momentum m = (QᵀP − PᵀQ)ˇ in the body's frame, from attitude and [matrix
    /// momenta](Self::matrix_momenta) of a body under QᵀQ = 1. Of a body of `Scene::rigid` m are the first three
    /// entries of its momentum.
    #[must_use]
    pub fn angular_momentum_of_matrix(attitude: &Matrix3<f64>, momenta: &[f64; 9]) -> Vector3<f64> {
        turning_part(attitude, &Self::attitude(momenta))
    }
}

/// Moments of inertia, for the angular momentum in the first three of nine components.
impl Inertia<f64, 9> for Rigid {
    fn velocity(&self, _: usize, p: &[f64; 9]) -> [f64; 9] {
        spread(&Vector3::from_row_slice(&p[..3]).component_div(&self.inertia))
    }
    fn root(&self, _: usize, u: &[f64; 9]) -> [f64; 9] {
        spread(&Vector3::from_row_slice(&u[..3]).component_mul(&self.inertia.map(f64::sqrt)))
    }
    fn is_pinned(&self, _: usize) -> bool {
        false
    }
}

/// An angular momentum in the first of nine places.
pub(super) fn spread(m: &Vector3<f64>) -> [f64; 9] {
    std::array::from_fn(|k| if k < 3 { m[k] } else { 0.0 })
}

/// The vector of the antisymmetric matrix QᵀX − XᵀQ.
pub(super) fn turning_part(attitude: &Matrix3<f64>, x: &Matrix3<f64>) -> Vector3<f64> {
    let a = attitude.transpose() * x;
    Vector3::new(a[(2, 1)] - a[(1, 2)], a[(0, 2)] - a[(2, 0)], a[(1, 0)] - a[(0, 1)])
}
