//! The rotation of a rigid body in a step, from its momentum, over any scalar.
//!
//! The vector x = e/e₀ of O. Rodrigues (1840) makes the equation of the step quadratic. With v = h/2 J⁻¹m, what the
//! equation bends x by, u = x − v, is of second order in the step. With aᵢ = (Jₗ − Jⱼ)/Jᵢ, i, j, l in cyclic order:
//!
//! ```text
//! rᵢ = uᵢ + aᵢ xⱼxₗ − |x|² vᵢ = 0      s = 2/(1 + |x|²)
//! Q′ = Q + Q s (x̂ + x̂²)               m′ᵢ = mᵢ − 2s/h (Jₗ − Jⱼ) xⱼxₗ
//! ```
//!
//! No |aᵢ| is above 1, so that needles are as well scaled as spheres. A free body keeps its energy because Σ Jᵢaᵢ = 0:
//! so what rounding takes from the numbers of the moments of inertia is kept beside them, and they belong to one body,
//! whose moments are the inverses of the rounded 1/(2J).

use crate::error::{Passing, RigidFailure, StepFailure};
use crate::number::real::Scalar;
use crate::number::vector::{add_scaled, dot, largest, scaled, sum, two_sum};
use nalgebra::Vector3;
use std::array::from_fn;

/// Newton steps after which the rotation of a step is given up; three suffice where there is one.
const MOST_CORRECTIONS: usize = 30;

/// Halvings of a failed step that are tried, to say which would pass.
const HALVINGS: i32 = 40;

/// The part of a rounding that may be left of x.
pub(crate) const LEFT: f64 = f64::EPSILON / 16.0;

/// QᵀQ off from 1 by more than this is brought back: well above the rounding of the product.
pub(crate) const CROOKED: f64 = 1e-14;

/// a × b.
#[inline(always)]
pub(crate) fn cross<T: Scalar>(a: &[T; 3], b: &[T; 3]) -> [T; 3] {
    let component = |i: usize, j: usize| a[i].multiply_add(b[j], -(a[j] * b[i]));
    [component(1, 2), component(2, 0), component(0, 1)]
}

/// Row i.
#[inline(always)]
fn row<T: Copy>(matrix: &[T; 9], i: usize) -> [T; 3] {
    from_fn(|j| matrix[3 * i + j])
}

/// The vector of QᵀX − XᵀQ, of matrices by rows: minus the sum of the cross products of their rows.
#[inline(always)]
pub(crate) fn turning<T: Scalar>(q: &[T; 9], x: &[T; 9]) -> [T; 3] {
    let [a, b, c] = from_fn(|i| cross(&row(x, i), &row(q, i)));
    from_fn(|i| a[i] + b[i] + c[i])
}

/// A product of matrices by rows.
#[inline(always)]
pub(crate) fn product<T: Scalar>(a: &[T; 9], b: &[T; 9]) -> [T; 9] {
    from_fn(|k| {
        let (i, j) = (k - k % 3, k % 3);
        a[i + 2].multiply_add(b[6 + j], a[i + 1].multiply_add(b[3 + j], a[i] * b[j]))
    })
}

/// What a step needs of the moments of inertia J: for each axis a number, some with what rounding took from them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moments<T> {
    /// 1/(2Jᵢ).
    pub(crate) over: [T; 3],
    /// aᵢ.
    pub(crate) bend: [[T; 3]; 2],
    /// 2 (Jₗ − Jⱼ).
    pub(crate) push: [[T; 3]; 2],
}

/// 1/h, and what rounding takes from it: as wrong in every step it would have the energy drift. By T. Dekker (1971), as
/// not all processors have fused products.
#[inline(always)]
pub(crate) fn one_over(h: f64) -> [f64; 2] {
    let halves = |x: f64| {
        let far = 134_217_729.0 * x;
        let high = far - (far - x);
        [high, x - high]
    };
    let over = 1.0 / h;
    let (one, [a, b], [c, d]) = (over * h, halves(over), halves(h));
    let low = (1.0 - one) - (((a * c - one) + a * d + b * c) + b * d);
    let low = low * over;
    [over, if low.is_finite() { low } else { 0.0 }]
}

/// 1 − QᵀQ, by rows.
#[inline(always)]
pub(crate) fn deviation<T: Scalar>(q: &[T; 9]) -> [T; 9] {
    let off = |i: usize, j: usize, of: T| {
        let product = |row: usize, rest: T| (-q[3 * row + i]).multiply_add(q[3 * row + j], rest);
        product(2, product(1, product(0, of)))
    };
    let [zero, one] = [0.0, 1.0].map(T::from_f64);
    let (xy, xz, yz) = (off(0, 1, zero), off(0, 2, zero), off(1, 2, zero));
    [off(0, 0, one), xy, xz, xy, off(1, 1, one), yz, xz, yz, off(2, 2, one)]
}

/// Whether Q ← Q(3 − QᵀQ)/2 leads from here to the nearest rotation: the determinant is positive, and so is 3 − QᵀQ, as
/// singular values beyond √3 change their signs.
#[inline(always)]
pub(crate) fn has_rotation<T: Scalar>(q: &[T; 9], deviation: &[T; 9]) -> bool {
    let [zero, two] = [0.0, 2.0].map(T::from_f64);
    let [a, ab, ac, _, b, bc, _, _, c] = *deviation;
    let (a, b, c) = (a + two, b + two, c + two);
    let second = a.multiply_add(b, -(ab * ab));
    let third = dot(&[a, ab, ac], &cross(&[ab, b, bc], &[ac, bc, c]));
    let determinant = dot(&row(q, 0), &cross(&row(q, 1), &row(q, 2)));
    zero.lt(a) & zero.lt(second) & zero.lt(third) & zero.lt(determinant)
}

/// What rounding takes from xy.
fn lost(x: f64, y: f64) -> f64 {
    x.mul_add(y, -(x * y))
}

impl Moments<f64> {
    pub(crate) fn new(inertia: [f64; 3]) -> Self {
        let over = inertia.map(|moment| 0.5 / moment);
        // 1/over, and what rounding takes from it.
        let moment = over.map(|over| {
            let high = 1.0 / over;
            [high, (-high).mul_add(over, 1.0) / over]
        });
        let push = from_fn(|i| {
            let ([a, a_low], [b, b_low]) = (moment[(i + 2) % 3], moment[(i + 1) % 3]);
            let ([high], [low]) = two_sum(&[a], &[-b]);
            let ([high], [low]) = two_sum(&[high], &[low + (a_low - b_low)]);
            [high, low]
        });
        let bend: [[f64; 2]; 3] = from_fn(|i| {
            let [high, low] = push[i];
            [high * over[i], lost(high, over[i]) + low * over[i]]
        });
        let turned = |of: [[f64; 2]; 3]| from_fn(|part| from_fn(|i| of[i][part]));
        Self { over, bend: turned(bend), push: turned(push) }
    }

    /// What x is beyond v and u of second order.
    pub(crate) fn rest(&self, v: &[f64; 3], x: &[f64; 3]) -> [f64; 3] {
        let second = self.next(v, v);
        from_fn(|i| (x[i] - v[i]) - second[i])
    }

    /// x for these v. None if the body turns too far.
    #[inline(always)]
    pub(crate) fn rotation(&self, v: &[f64; 3]) -> Option<[f64; 3]> {
        let mut u = self.next(v, &self.next(v, v));
        for _ in 0..MOST_CORRECTIONS {
            let x = sum(v, &u);
            let inverse = Inverse::at(self, v, &x);
            let correction = inverse.times(&self.residual(v, &u, &x));
            u = add_scaled(&u, -1.0, &correction);
            let (size, x) = (largest(&correction), sum(v, &u));
            // The next one is M⁻¹ times second derivatives, of up to 3/2, times half of its square.
            let next = 4.0 * inverse.over.abs() * size * size;
            if next <= LEFT * largest(&x) {
                return (inverse.over > 0.0).then_some(x);
            }
            if !next.is_finite() {
                return None;
            }
        }
        None
    }
}

impl<T: Copy> Moments<T> {
    /// The same of other numbers.
    pub(crate) fn map<U>(&self, number: impl Fn(T) -> U) -> Moments<U> {
        let Self { over, bend, push } = *self;
        let numbers = |of: [T; 3]| of.map(&number);
        Moments { over: numbers(over), bend: bend.map(numbers), push: push.map(numbers) }
    }
}

impl<T: Scalar> Moments<T> {
    /// v, from the momentum times h.
    #[inline(always)]
    pub(crate) fn ahead(&self, way: &[T; 3]) -> [T; 3] {
        from_fn(|i| self.over[i] * way[i])
    }

    /// xⱼxₗ.
    #[inline(always)]
    pub(crate) fn others(x: &[T; 3]) -> [T; 3] {
        [x[1] * x[2], x[2] * x[0], x[0] * x[1]]
    }

    /// What u were if x were that; for v in its place it is u but for third order.
    #[inline(always)]
    pub(crate) fn next(&self, v: &[T; 3], x: &[T; 3]) -> [T; 3] {
        let (square, others, [bend, _]) = (dot(x, x), Self::others(x), &self.bend);
        from_fn(|i| square.multiply_add(v[i], -(bend[i] * others[i])))
    }

    /// r.
    #[inline(always)]
    pub(crate) fn residual(&self, v: &[T; 3], u: &[T; 3], x: &[T; 3]) -> [T; 3] {
        let (square, others, [bend, low]) = (dot(x, x), Self::others(x), &self.bend);
        // What is small is added where the others have cancelled: it were lost elsewhere, in each step alike.
        from_fn(|i| {
            let r = bend[i].multiply_add(others[i], (-square).multiply_add(v[i], u[i]));
            low[i].multiply_add(others[i], r)
        })
    }

    /// Ω.
    #[inline(always)]
    pub(crate) fn rate(&self, m: &[T; 3]) -> [T; 3] {
        from_fn(|i| T::from_f64(2.0) * self.over[i] * m[i])
    }

    /// m × Ω from the other two of Ω multiplied, times Jⱼ − Jₗ: a body that is symmetric about an axis keeps the
    /// momentum about it.
    #[inline(always)]
    pub(crate) fn gyration(&self, others: &[T; 3]) -> [T; 3] {
        from_fn(|i| T::from_f64(-0.5) * self.push[0][i] * others[i])
    }

    /// s xⱼxₗ: times the push it is h times what the step takes from m.
    #[inline(always)]
    pub(crate) fn along(x: &[T; 3], s: T) -> [T; 3] {
        scaled(s, &Self::others(x))
    }
}

/// The inverse of M = ∂r/∂u.
pub(crate) struct Inverse<T> {
    adjugate: [[T; 3]; 3],
    /// 1/det M; M is the unit matrix where nothing turns.
    pub(crate) over: T,
}

impl<T: Scalar> Inverse<T> {
    #[inline(always)]
    pub(crate) fn at(Moments { bend: [bend, _], .. }: &Moments<T>, v: &[T; 3], x: &[T; 3]) -> Self {
        let (one, twice) = (T::from_f64(1.0), scaled(T::from_f64(-2.0), v));
        let column = |k: usize| -> [T; 3] {
            from_fn(|i| {
                let rest = if i == k { one } else { bend[i] * x[3 - i - k] };
                twice[i].multiply_add(x[k], rest)
            })
        };
        let [a, b, c] = [column(0), column(1), column(2)];
        let adjugate = [cross(&b, &c), cross(&c, &a), cross(&a, &b)];
        Self { over: one / dot(&a, &adjugate[0]), adjugate }
    }

    #[inline(always)]
    pub(crate) fn times(&self, r: &[T; 3]) -> [T; 3] {
        from_fn(|i| self.over * dot(&self.adjugate[i], r))
    }
}

/// s.
#[inline(always)]
pub(crate) fn share<T: Scalar>(x: &[T; 3]) -> T {
    T::from_f64(2.0) / (T::from_f64(1.0) + dot(x, x))
}

/// s (x̂ + x̂²), by rows.
#[inline(always)]
pub(crate) fn turn<T: Scalar>(x: &[T; 3], s: T) -> [T; 9] {
    let [a, b, c] = scaled(s, x);
    let [x, y, z] = *x;
    let (xx, yy, zz) = (a * x, b * y, c * z);
    let off = |share: T, of: T, rest: T| share.multiply_add(of, rest);
    [
        -(yy + zz),
        off(a, y, -c),
        off(a, z, b),
        off(a, y, c),
        -(xx + zz),
        off(b, z, -a),
        off(a, z, -b),
        off(b, z, a),
        -(xx + yy),
    ]
}

/// Why a body of this momentum cannot make this step.
#[cold]
pub(crate) fn too_fast(moments: &Moments<f64>, h: f64, m: &[f64; 3]) -> StepFailure {
    let ahead = |h: f64| moments.ahead(&scaled(h, m));
    let turn = 2.0 * Vector3::from(ahead(h)).norm();
    let passing = (1..HALVINGS).map(|k| h * 0.5_f64.powi(k)).find(|&h| moments.rotation(&ahead(h)).is_some());
    RigidFailure::TurnsTooFar { turn, h, passing: Passing(passing) }.into()
}
