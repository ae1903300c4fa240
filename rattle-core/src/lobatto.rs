//! Lobatto IIIA–IIIB: symplectic, symmetric collocation of order 2s − 2 with s stages, for constrained motion.
//!
//! ```text
//! Qᵢ = q + h cᵢ M⁻¹p + h² Σⱼ aᵢⱼ M⁻¹(f(Qⱼ) + G(Qⱼ)ᵀλⱼ)      0 = g(Qᵢ),   i = 2 … s,   Q₁ = q
//! p′ = p + h Σⱼ bⱼ (f(Qⱼ) + G(Qⱼ)ᵀλⱼ)                        λₛ such that G(q′) M⁻¹p′ = 0,   q′ = Qₛ
//! ```
//!
//! aᵢⱼ is the product of the two matrices; two stages are RATTLE. From errors of 1e-4 on this costs several times less
//! than a composition of RATTLE, and takes steps a few times as long.
//!
//! Source: L. Jay, SIAM J. Numer. Anal. 33 (1996) 368; E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*,
//! VII.1.4.

mod tables;

use crate::bodies::Bodies;
use crate::real::Real;
use crate::stepper::{Failure, Stepper, Witness};
use crate::system::System;

/// Nodes c, weights b, and a, whose first row and last column are zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Table<const S: usize> {
    /// c₁ … cₛ.
    pub nodes: [f64; S],
    /// b₁ … bₛ.
    pub weights: [f64; S],
    /// aᵢⱼ, row by row.
    pub positions: [[f64; S]; S],
    /// The inverse of aᵢⱼ, i = 2 … s, j = 1 … s − 1, its row j and column i where a has column j and row i.
    pub(crate) inverse: [[f64; S]; S],
}

impl<const S: usize> Table<S> {
    /// The table with these coefficients, the inverse by Gauss and Jordan without exchanges: minors are positive.
    const fn new(nodes: [f64; S], weights: [f64; S], positions: [[f64; S]; S]) -> Self {
        let (mut a, mut inverse) = (positions, [[0.0; S]; S]);
        let mut k = 0;
        while k + 1 < S {
            inverse[k][k + 1] = 1.0;
            k += 1;
        }
        k = 0;
        while k + 1 < S {
            let (pivot, mut i) = (a[k + 1][k], 0);
            while i < S {
                a[k + 1][i] /= pivot;
                inverse[k][i] /= pivot;
                i += 1;
            }
            i = 0;
            while i + 1 < S {
                let (factor, mut j) = (if i == k { 0.0 } else { a[i + 1][k] }, 0);
                while j < S {
                    a[i + 1][j] -= factor * a[k + 1][j];
                    inverse[i][j] -= factor * inverse[k][j];
                    j += 1;
                }
                i += 1;
            }
            k += 1;
        }
        Self { nodes, weights, positions, inverse }
    }
}

/// Numbers of stages with a table.
#[diagnostic::on_unimplemented(
    message = "Lobatto methods have 2 to 9 stages",
    label = "no table for so many"
)]
pub trait Tabulated: Copy + PartialEq + std::fmt::Debug {
    /// The name of the method, with its order.
    const NAME: &'static str;
    /// The coefficients.
    const TABLE: Self;
}

/// Lobatto IIIA–IIIB of 2 to 9 stages with a constant step size. Five, order 8, serve most uses.
///
/// ```
/// # use rattle_core::{lobatto::Lobatto, stepper::Stepper};
/// assert_eq!(Lobatto::<5>::new(0.05).order(), 8);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lobatto<const S: usize> {
    h: f64,
}

impl<const S: usize> Lobatto<S>
where
    Table<S>: Tabulated,
{
    /// The method with step size `h`, in the unit of time.
    #[must_use]
    pub fn new(h: f64) -> Self {
        Self { h }
    }
}

impl<const S: usize> Stepper for Lobatto<S>
where
    Table<S>: Tabulated,
{
    type Memory<T: Real> = [T; 0];

    fn step_size(&self) -> f64 {
        self.h
    }
    fn order(&self) -> u32 {
        u32::try_from(2 * S - 2).unwrap_or(u32::MAX)
    }
    fn name(&self) -> &'static str {
        Table::<S>::NAME
    }
    fn with_step(&self, h: f64) -> Self {
        Self { h }
    }
    fn is_symmetric(&self) -> bool {
        true
    }
    fn stages(&self) -> usize {
        S
    }

    #[inline(always)]
    fn step<T: Real, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        system: &Y,
        bodies: &mut Bodies<Y::Count, T, Y::Kept, D>,
        _: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        system.collocate(&Table::<S>::TABLE, self.h, bodies, witness)
    }
}
