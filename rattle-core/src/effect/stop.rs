//! Walls, strings and joint limits: an inequality instead of an equation, with any function made by `constraint!`.

use crate::effect::contact::{Contacts, Gradient, check_members, check_restitution};
use crate::error::{Error, expect_variables, refuse_nan};
use crate::kernel::functions::{Constraint, ConstraintKernel};
use crate::kernel::over::short_name;
use std::array::from_fn;
use std::fmt;

/// A unilateral constraint, g ≥ 0 or g ≤ 0: a wall for each body, or a link of several bodies that holds on one side.
///
/// ```text
/// gap = g(q) or −g(q)                 in the unit of g
///
/// Stop::above(Plane { … })            every body stays where g ≥ 0: a floor
/// Stop::below(Sphere { r: 1.0 })      every body stays where g ≤ 0: a box
/// Stop::below(Rod { length: 1.0 }).over([[0, 1]])      a string, at most so long
/// ```
///
/// A step that leads all through a body that is not convex, as through both sides of a ring, may meet neither: steps
/// are to be shorter than what bodies pass through, see [`Contacts`].
///
/// ```
/// use rattle::{effect::Stop, potentials::planar::Gravity, prelude::*};
///
/// constraint! { struct Floor {} |_x, y| y }
///
/// let start = State::at([0.0, 0.5]).moving([0.3, 0.0]);
/// let falling = Scene::point().with(Gravity { g: 1.0 }).simulate(start, Rattle::new(0.01))?;
/// let mut ball = falling.collide(Stop::above(Floor {}).restitution(0.5))?;
/// ball.run(150)?; // down for t = 1, then up from y = 0 with v = 0.5 for t = 0.5
/// assert!((ball.position().y - 0.125).abs() < 1e-14 && ball.energy_error().abs() < 1e-14);
/// assert!((ball.work() + 0.375).abs() < 1e-14); // three quarters of the energy went into the floor
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "inequality")]
#[doc(alias = "unilateral")]
#[doc(alias = "string")]
#[doc(alias = "contact")]
#[doc(alias = "wall")]
#[doc(alias = "joint limit")]
#[derive(Clone)]
pub struct Stop<X, const K: usize, const A: usize> {
    name: &'static str,
    nan_parameter: Option<&'static str>,
    kernel: X,
    /// 1 where g stays above zero, −1 where below.
    side: f64,
    /// The bodies of each; of every body by itself, if none are named.
    members: Option<Vec<[usize; A]>>,
    restitution: f64,
}

impl Stop<(), 0, 0> {
    /// Motion stays where g ≥ 0, for every body; elastic.
    pub fn above<C: Constraint<K, 1>, const K: usize>(constraint: C) -> Stop<C::Kernel<f64>, K, 1> {
        of(&constraint, 1.0)
    }

    /// Motion stays where g ≤ 0, for every body; elastic.
    pub fn below<C: Constraint<K, 1>, const K: usize>(constraint: C) -> Stop<C::Kernel<f64>, K, 1> {
        of(&constraint, -1.0)
    }
}

fn of<C: Constraint<K, 1>, const K: usize>(constraint: &C, side: f64) -> Stop<C::Kernel<f64>, K, 1> {
    let (name, nan_parameter) = (short_name::<C>(), constraint.nan_parameter());
    Stop { name, nan_parameter, kernel: constraint.kernel(), side, members: None, restitution: 1.0 }
}

impl<X, const K: usize, const A: usize> Stop<X, K, A> {
    /// The same for these members: g is a function of the coordinates of a member's bodies, one after the other.
    pub fn over<const B: usize>(self, members: impl IntoIterator<Item = [usize; B]>) -> Stop<X, K, B> {
        let Self { name, nan_parameter, kernel, side, restitution, .. } = self;
        let members = Some(members.into_iter().collect());
        Stop { name, nan_parameter, kernel, side, members, restitution }
    }

    /// The same with this coefficient of restitution, 0 to 1.
    #[must_use]
    pub fn restitution(self, restitution: f64) -> Self {
        Self { restitution, ..self }
    }

    fn bodies(&self, contact: usize) -> [usize; A] {
        self.members.as_ref().map_or([contact; A], |members| members[contact])
    }
}

impl<X, const K: usize, const A: usize> fmt::Debug for Stop<X, K, A> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} 0", self.name, if self.side > 0.0 { '≥' } else { '≤' })
    }
}

impl<X: ConstraintKernel<f64, K, 1>, const D: usize, const K: usize, const A: usize> Contacts<D>
    for Stop<X, K, A>
{
    fn name(&self) -> &'static str {
        self.name
    }
    fn restitution(&self) -> f64 {
        self.restitution
    }
    fn parameters(&self) -> Vec<f64> {
        let place = |size: f64| from_fn(|k| size * ((k + 1) as f64 * 0.618_033_988_749_894_9).fract());
        let told = |size: f64| {
            let ([g], [row]) = self.kernel.value_and_jacobian(&place(size));
            [&[g], &row[..]].concat()
        };
        // Members are mixed into 32 bits, since there may be many.
        let mix =
            |sum: u64, &body: &usize| (sum ^ body as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29);
        let members = self.members.as_ref().map(|members| members.as_flattened().iter().fold(1, mix) >> 32);
        let number = self.members.as_ref().map_or(-1.0, |members| members.len() as f64);
        // At places of all sizes up to 1: among them is one that shows what a length of that size is. Farther away
        // waves would show the last bits of theirs.
        let places = (-10..=0).flat_map(|n| told(2.0_f64.powi(10 * n)));
        [self.side, number, members.unwrap_or(0) as f64].into_iter().chain(places).collect()
    }
    fn check(&self, bodies: usize) -> Result<(), Error> {
        const { expect_variables(K, A, D, false) };
        refuse_nan(self.name, self.nan_parameter)?;
        check_members(self.name, self.members.as_deref().unwrap_or_default(), bodies)?;
        check_restitution(self.restitution)
    }
    fn near(&self, q: &[[f64; D]], _: f64, _: &mut Vec<usize>, found: &mut Vec<usize>) {
        found.extend(0..self.members.as_ref().map_or(q.len(), Vec::len));
    }
    fn gap(&self, contact: usize, q: &[[f64; D]], gradient: &mut Gradient<D>) -> f64 {
        let bodies = self.bodies(contact);
        let variables = from_fn(|k| q[bodies[k / D]][k % D]);
        let ([g], [row]) = self.kernel.value_and_jacobian(&variables);
        for (a, &body) in bodies.iter().enumerate() {
            gradient.push((body, from_fn(|d| self.side * row[a * D + d])));
        }
        self.side * g
    }
}
