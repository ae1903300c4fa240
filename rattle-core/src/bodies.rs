//! The bodies of a running simulation, stored side by side.

use crate::real::Real;
use std::fmt::Debug;

/// How many bodies a scene has: exactly one, known when compiling, or many.
pub trait Count: Copy + Debug {
    /// Storage for one `X` per body.
    type Of<X: Copy + Debug>: AsRef<[X]> + AsMut<[X]> + Clone + Debug;

    /// The number of bodies.
    fn number(self) -> usize;
    /// The same `x` for each body.
    fn each<X: Copy + Debug>(self, x: X) -> Self::Of<X>;
}

/// One body: its state lives in arrays of length one, and loops over bodies vanish.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct One;

impl Count for One {
    type Of<X: Copy + Debug> = [X; 1];

    #[inline(always)]
    fn number(self) -> usize {
        1
    }
    fn each<X: Copy + Debug>(self, x: X) -> [X; 1] {
        [x]
    }
}

/// This many bodies, allocated once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Many(pub usize);

impl Count for Many {
    type Of<X: Copy + Debug> = Vec<X>;

    #[inline(always)]
    fn number(self) -> usize {
        self.0
    }
    fn each<X: Copy + Debug>(self, x: X) -> Vec<X> {
        vec![x; self.0]
    }
}

/// Position and momentum of one body, each a sum of two numbers: `q + q_low` and `p + p_low`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body<T, const D: usize> {
    /// Position, rounded.
    pub q: [T; D],
    /// What rounding took from the position.
    pub q_low: [T; D],
    /// Momentum, rounded.
    pub p: [T; D],
    /// What rounding took from the momentum.
    pub p_low: [T; D],
}

/// ∇g and 1/|∇g|² at a body's position.
#[derive(Debug, Clone, Copy)]
pub struct Normal<T, const D: usize> {
    /// ∇g(q).
    pub gradient: [T; D],
    /// 1/(∇g·∇g).
    pub inverse_square: T,
}

/// Positions, momenta and what was evaluated at the positions.
///
/// Positions and momenta are compensated sums: the value is `q + q_low`, where `q_low` holds what
/// rounding took from `q`. `normal` and `force` are functions of `q` alone, kept from the last step.
#[derive(Debug, Clone)]
pub struct Bodies<N: Count, T: Real, F: Copy + Debug, const D: usize> {
    /// Positions, rounded.
    pub q: N::Of<[T; D]>,
    /// What rounding took from the positions.
    pub q_low: N::Of<[T; D]>,
    /// Momenta, rounded.
    pub p: N::Of<[T; D]>,
    /// What rounding took from the momenta.
    pub p_low: N::Of<[T; D]>,
    /// Normals at the positions.
    pub normal: N::Of<Normal<T, D>>,
    /// Forces −∇U at the positions; of size zero where no effect acts.
    pub force: N::Of<F>,
}

impl<N: Count, T: Real, F: Copy + Debug, const D: usize> Bodies<N, T, F, D> {
    /// The body of this number.
    pub fn body(&self, i: usize) -> Body<T, D> {
        Body {
            q: self.q.as_ref()[i],
            q_low: self.q_low.as_ref()[i],
            p: self.p.as_ref()[i],
            p_low: self.p_low.as_ref()[i],
        }
    }

    /// Takes over the state of `other`, which has as many bodies, without allocating.
    #[inline(always)]
    pub fn copy_from(&mut self, other: &Self) {
        self.q.as_mut().copy_from_slice(other.q.as_ref());
        self.q_low.as_mut().copy_from_slice(other.q_low.as_ref());
        self.p.as_mut().copy_from_slice(other.p.as_ref());
        self.p_low.as_mut().copy_from_slice(other.p_low.as_ref());
        self.normal.as_mut().copy_from_slice(other.normal.as_ref());
        self.force.as_mut().copy_from_slice(other.force.as_ref());
    }
}
