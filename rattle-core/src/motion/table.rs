//! Coefficients of a collocation method.

/// Nodes c, weights b and matrix a, whose first row and last column are zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Table<const S: usize> {
    /// c₁ … cₛ.
    pub nodes: [f64; S],
    /// b₁ … bₛ.
    pub weights: [f64; S],
    /// aᵢⱼ, row by row.
    pub positions: [[f64; S]; S],
    /// What rounding took from nodes and weights, and from a: with rounded ones the method is no longer symplectic and
    /// energy drifts, by 4e-19 a step (E. Hairer, R. McLachlan, A. Razakarivony, BIT 48 (2008) 231).
    rests: [[f64; S]; 2],
    rests_of_positions: [[f64; S]; S],
    /// The inverse of aᵢⱼ, i = 2 … s, j = 1 … s − 1, its row j and column i where a has column j and row i.
    pub(crate) inverse: [[f64; S]; S],
    /// Row i, column j: the polynomial that is 1 at cⱼ and 0 at the other nodes, at 1 + cᵢ.
    pub(crate) ahead: [[f64; S]; S],
}

impl<const S: usize> Table<S> {
    /// The table with these coefficients, the inverse by Gauss and Jordan without exchanges: minors are positive.
    pub(super) const fn new(
        nodes: [f64; S],
        weights: [f64; S],
        positions: [[f64; S]; S],
        rests: [[f64; S]; 2],
        rests_of_positions: [[f64; S]; S],
    ) -> Self {
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
        let mut ahead = [[1.0; S]; S];
        let mut i = 0;
        while i < S {
            let mut j = 0;
            while j < S {
                k = 0;
                while k < S {
                    if k != j {
                        ahead[i][j] *= (1.0 + nodes[i] - nodes[k]) / (nodes[j] - nodes[k]);
                    }
                    k += 1;
                }
                j += 1;
            }
            i += 1;
        }
        Self { nodes, weights, positions, rests, rests_of_positions, inverse, ahead }
    }

    /// h cᵢ, and what rounding took from it.
    #[inline(always)]
    pub(crate) fn drift(&self, h: f64, stage: usize) -> (f64, f64) {
        product(h, self.nodes[stage], self.rests[0][stage])
    }

    /// h² aᵢⱼ, and what rounding took from it.
    #[inline(always)]
    pub(crate) fn push(&self, h: f64, stage: usize, j: usize) -> (f64, f64) {
        let (square, rest_of_square) = product(h, h, 0.0);
        let (a, rest) = (self.positions[stage][j], self.rests_of_positions[stage][j]);
        let (high, low) = product(square, a, rest);
        (high, low + rest_of_square * a)
    }

    /// h bᵢ, and what rounding took from it.
    #[inline(always)]
    pub(crate) fn kick(&self, h: f64, stage: usize) -> (f64, f64) {
        product(h, self.weights[stage], self.rests[1][stage])
    }
}

/// h x for x and its rest, and what rounding took from it.
#[inline(always)]
fn product(h: f64, x: f64, rest: f64) -> (f64, f64) {
    let high = h * x;
    (high, h.mul_add(x, -high) + h * rest)
}

/// The numbers of stages for which there is a table.
#[diagnostic::on_unimplemented(
    message = "Lobatto methods have 2 to 9 stages",
    label = "no table for this number of stages",
    note = "`Lobatto::<5>`, of order 8, serves most uses"
)]
pub trait Tabulated: Copy + PartialEq + std::fmt::Debug {
    /// The name of the method, with its order.
    const NAME: &'static str;
    /// The coefficients.
    const TABLE: Self;
}
