//! What `residual!` writes: derivatives and Schur complements against dual numbers over exact fractions, where the
//! bound is zero, and against differences.

use rattle::lanes::Lanes;
use rattle::real::Real;
use rattle_flow::law::{DarcyWeisbach, Manning};
use rattle_flow::residual;
use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

residual! {
    /// What the law of Darcy and Weisbach linearises, as a residual of its own, with sums written in other ways.
    struct Linearised { epsilon }

    |h: [f64; 3], p: [f64; 2]|
    given |grad: [[f64; 2]; 3], arm: [[f64; 2]; 3], rise: [f64; 2], c|
    {
        let s = sqrt(p[0]^2 + p[1]^2 + epsilon^2);
        let m = [h[0] * sqrt(h[0]), h[1] * sqrt(h[1]), h[2] * sqrt(h[2])];
        let z = [h[0], h[1] + rise[0], h[2] + rise[1]];
        let d = [-c * dot(p, arm[0]), -c * dot(p, arm[1]), -c * dot(p, arm[2])];
        // The third angle alone may be obtuse; the arm opposite to it then points backwards.
        let blunt = if dot(arm[0], grad[1] - grad[0]) < 0 { 1 } else { 0 };
        let least = if m[1] < m[0] { if m[2] < m[1] { m[2] } else { m[1] } } else {
            if m[2] < m[0] { m[2] } else { m[0] }
        };
        let f = [
            if blunt > 0 { d[0] * least } else { if d[0] >= 0 { d[0] * m[0] } else { d[0] * m[1] } },
            if d[1] >= 0 { d[1] * m[1] } else { d[1] * m[2] },
            if d[2] >= 0 { d[2] * m[2] } else { d[2] * m[0] },
        ];
        [
            f[0] - f[2], f[1] - f[0], f[2] - f[1],
            s * p[0] - sum(i in 0..3, z[i] * grad[i][0]),
            s * p[1] - sum(i in 0..3, z[i] * grad[i][1]),
        ]
    }
}

residual! {
    /// Three numbers eliminated, in another order, with a branch.
    struct Cubes { a }
    |x: [f64; 3], y: [f64; 2]|
    given |b: [f64; 2]|
    eliminate(x)
    [
        x[0]^3 + a * y[0] * x[1], x[1] * x[2] + y[1]^2 + b[0], x[2]^2 * y[0] + x[0],
        if y[0] < x[0] { y[0]^2 * x[2] } else { y[0] - x[1]^2 }, y[1] * y[0] + b[1] * x[0],
    ]
}

/// A fraction; running out of 128 bits is a panic of the test, not a rounding.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Exact(i128, i128);

fn gcd(a: i128, b: i128) -> i128 {
    if b == 0 { a.abs() } else { gcd(b, a % b) }
}

impl Exact {
    fn new(above: i128, below: i128) -> Exact {
        let divisor = gcd(above, below) * below.signum();
        assert!(divisor != 0, "division by zero");
        Exact(above / divisor, below / divisor)
    }
}
fn times(a: i128, b: i128) -> i128 {
    a.checked_mul(b).expect("the fraction fits into 128 bits")
}
impl Add for Exact {
    type Output = Exact;
    fn add(self, o: Exact) -> Exact {
        let common = gcd(self.1, o.1);
        let (a, b) = (times(self.0, o.1 / common), times(o.0, self.1 / common));
        Exact::new(a.checked_add(b).expect("the sum fits"), times(self.1, o.1 / common))
    }
}
impl Mul for Exact {
    type Output = Exact;
    fn mul(self, o: Exact) -> Exact {
        let (a, b) = (Exact::new(self.0, o.1), Exact::new(o.0, self.1));
        Exact::new(times(a.0, b.0), times(a.1, b.1))
    }
}
impl Div for Exact {
    type Output = Exact;
    #[allow(clippy::suspicious_arithmetic_impl, reason = "division is multiplication by the reciprocal")]
    fn div(self, o: Exact) -> Exact {
        self * Exact::new(o.1, o.0)
    }
}
impl Neg for Exact {
    type Output = Exact;
    fn neg(self) -> Exact {
        Exact(-self.0, self.1)
    }
}
impl Sub for Exact {
    type Output = Exact;
    fn sub(self, o: Exact) -> Exact {
        self + -o
    }
}

/// What fractions do not have.
macro_rules! none {
    ($($name:ident)*) => { $(fn $name(self) -> Self { unimplemented!() })* };
}

impl Real for Exact {
    type Mask = bool;
    fn from_f64(x: f64) -> Exact {
        let scaled = x * 1048576.0;
        assert_eq!(scaled, scaled.trunc(), "a short binary fraction");
        Exact::new(scaled as i128, 1048576)
    }
    fn lanes(self) -> impl Iterator<Item = f64> {
        std::iter::once(self.0 as f64 / self.1 as f64)
    }
    fn lt(self, o: Exact) -> bool {
        (self - o).0 < 0
    }
    fn le(self, o: Exact) -> bool {
        (self - o).0 <= 0
    }
    fn select(mask: bool, a: Exact, b: Exact) -> Exact {
        if mask { a } else { b }
    }
    fn sqrt(self) -> Exact {
        let (a, b) = (self.0.isqrt(), self.1.isqrt());
        assert!(a * a == self.0 && b * b == self.1, "the root of {self:?} is no fraction");
        Exact(a, b)
    }
    none!(abs sign floor cbrt exp ln log10 log2 sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh erf);
    fn sin_cos(self) -> (Self, Self) {
        unimplemented!()
    }
    fn powf(self, _: Self) -> Self {
        unimplemented!()
    }
    fn atan2(self, _: Self) -> Self {
        unimplemented!()
    }
    fn hypot(self, _: Self) -> Self {
        unimplemented!()
    }
}

/// a + b ε with ε² = 0.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Dual(Exact, Exact);

impl Add for Dual {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Dual(self.0 + o.0, self.1 + o.1)
    }
}
impl Sub for Dual {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Dual(self.0 - o.0, self.1 - o.1)
    }
}
impl Mul for Dual {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Dual(self.0 * o.0, self.0 * o.1 + self.1 * o.0)
    }
}
impl Div for Dual {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        Dual(self.0 / o.0, (self.1 * o.0 - self.0 * o.1) / (o.0 * o.0))
    }
}
impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        Dual(-self.0, -self.1)
    }
}
impl Real for Dual {
    type Mask = bool;
    fn from_f64(x: f64) -> Self {
        Dual(Exact::from_f64(x), Exact(0, 1))
    }
    fn lanes(self) -> impl Iterator<Item = f64> {
        self.0.lanes()
    }
    fn lt(self, o: Self) -> bool {
        self.0.lt(o.0)
    }
    fn le(self, o: Self) -> bool {
        self.0.le(o.0)
    }
    fn select(mask: bool, a: Self, b: Self) -> Self {
        if mask { a } else { b }
    }
    fn sqrt(self) -> Self {
        let root = self.0.sqrt();
        // h √h has the slope 0 at 0, whatever finite slope the root is given.
        let slope = if root.0 == 0 { Exact(0, 1) } else { self.1 / (root + root) };
        Dual(root, slope)
    }
    none!(abs sign floor cbrt exp ln log10 log2 sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh erf);
    fn sin_cos(self) -> (Self, Self) {
        unimplemented!()
    }
    fn powf(self, _: Self) -> Self {
        unimplemented!()
    }
    fn atan2(self, _: Self) -> Self {
        unimplemented!()
    }
    fn hypot(self, _: Self) -> Self {
        unimplemented!()
    }
}

/// ∇φ, arms, rises and c of a triangle, exact where its numbers are.
fn triangle<T: Real>(place: [[f64; 2]; 3], rise: [f64; 2], c: f64) -> [T; 15] {
    let t = T::from_f64;
    let place = place.map(|p| p.map(t));
    let side = |i: usize, j: usize| [place[j][0] - place[i][0], place[j][1] - place[i][1]];
    let (a, b) = (side(0, 1), side(0, 2));
    let twice = a[0] * b[1] - a[1] * b[0];
    let mut list = Vec::new();
    for i in 0..3 {
        let [x, y] = side((i + 1) % 3, (i + 2) % 3);
        list.extend([-y / twice, x / twice]);
    }
    for i in 0..3 {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let (a, b) = (side(k, i), side(k, j));
        let weight = (a[0] * b[0] + a[1] * b[1]) / (twice + twice);
        list.extend(side(i, j).map(|x| weight * x));
    }
    list.extend(rise.map(t));
    list.push(t(c));
    list.try_into().expect("fifteen numbers")
}

const ACUTE: [[f64; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]];
const TURNED: [[f64; 2]; 3] = [[0.0, 0.0], [2.0, 1.0], [-1.0, 3.0]];
const OBTUSE: [[f64; 2]; 3] = [[4.0, 0.0], [-1.0, 1.0], [0.0, 0.0]];

/// Depth and p, where the roots are fractions: |p| and √(p² + 144).
const PLACES: [[f64; 5]; 8] = [
    [4.0, 0.25, 2.25, -3.0, -4.0],
    [4.0, 0.25, 2.25, 3.0, 4.0],
    [0.25, 4.0, 1.0, -4.0, 3.0],
    [4.0, 2.25, 0.25, 3.0, -4.0],
    [0.0, 1.0, 0.0, 3.0, -4.0],
    [0.0, 0.0, 0.0, 5.0, 0.0],
    [1.0, 4.0, 0.0625, 0.0, 0.0],
    [0.0, 0.0, 0.0, 0.0, 0.0],
];

fn exact<const N: usize>(numbers: [f64; N]) -> [Exact; N] {
    numbers.map(Exact::from_f64)
}

/// a⁻¹ b by elimination.
fn solved(mut a: Vec<Vec<Exact>>, mut b: Vec<Exact>) -> Vec<Exact> {
    let n = b.len();
    for k in 0..n {
        let pivot = (k..n).find(|&i| a[i][k].0 != 0).expect("a regular block");
        a.swap(k, pivot);
        b.swap(k, pivot);
        for i in (0..n).filter(|&i| i != k) {
            let factor = a[i][k] / a[k][k];
            for j in 0..n {
                let own = a[k][j];
                a[i][j] = a[i][j] - factor * own;
            }
            let own = b[k];
            b[i] = b[i] - factor * own;
        }
    }
    (0..n).map(|k| b[k] / a[k][k]).collect()
}

#[test]
fn derivatives_are_those_of_dual_numbers_over_fractions() {
    let mut moved = [[false; 5]; 5];
    for (corners, place) in
        [ACUTE, TURNED, OBTUSE].into_iter().flat_map(|corners| PLACES.map(|place| (corners, place)))
    {
        let law = DarcyWeisbach { epsilon: 12.0 }.kernel::<Exact>();
        let dual = Linearised { epsilon: 12.0 }.kernel::<Dual>();
        let (values, jacobian) =
            law.residual_and_jacobian(&exact(place), &triangle(corners, [0.5, -0.25], 2.0));
        for k in 0..5 {
            let mut u = place.map(Dual::from_f64);
            u[k].1 = Exact(1, 1);
            let of_dual = dual.residual(&u, &triangle(corners, [0.5, -0.25], 2.0));
            for i in 0..5 {
                assert_eq!(jacobian[i][k], of_dual[i].1, "∂R{i}/∂u{k} at {place:?} in {corners:?}");
                assert!(i > 2 || values[i] == of_dual[i].0, "R{i} at {place:?}");
                moved[i][k] |= jacobian[i][k].0 != 0;
            }
        }
        // The residual itself has |p|, a quarter of √(p² + 144) or less, where the derivative has the root.
        let rest = |p: f64, size: f64| Exact::from_f64(size * p);
        let size = place[3].hypot(place[4]);
        let slope = rest(place[3], size) - values[3];
        let rounded = dual.residual(&place.map(Dual::from_f64), &triangle(corners, [0.5, -0.25], 2.0))[3].0;
        assert_eq!(rounded, rest(place[3], size.hypot(12.0)) - slope);
    }
    // What is compared is not zero: what is left out, or multiplied wrongly, is seen in each entry.
    assert_eq!(moved, [[true; 5]; 5]);
}

#[test]
fn what_is_eliminated_is_solved_for_exactly() {
    for (corners, place) in
        [ACUTE, TURNED, OBTUSE].into_iter().flat_map(|corners| PLACES.map(|place| (corners, place)))
    {
        let law = DarcyWeisbach { epsilon: 12.0 }.kernel::<Exact>();
        let given = triangle(corners, [0.5, -0.25], 2.0);
        let u = exact(place);
        let (r, j) = law.residual_and_jacobian(&u, &given);
        let (left, schur) = law.condensed(&u, &given);
        assert_eq!(left, law.condensed_residual(&u, &given));
        let block = || vec![vec![j[3][3], j[3][4]], vec![j[4][3], j[4][4]]];
        let of_rest = solved(block(), vec![r[3], r[4]]);
        for i in 0..3 {
            assert_eq!(left[i], r[i] - j[i][3] * of_rest[0] - j[i][4] * of_rest[1]);
            for k in 0..3 {
                let column = solved(block(), vec![j[3][k], j[4][k]]);
                assert_eq!(schur[i][k], j[i][k] - j[i][3] * column[0] - j[i][4] * column[1]);
            }
        }
        let step = exact([0.5, -1.0, 0.25]);
        let along = [3, 4].map(|e| (0..3).fold(r[e], |sum, k| sum + j[e][k] * step[k]));
        let found = law.recovered(&u, &given, &step);
        assert_eq!(found.map(Neg::neg).to_vec(), solved(block(), along.to_vec()));
        // What flows out of one vertex flows into another.
        assert_eq!(left[0] + left[1] + left[2], Exact(0, 1));
    }
}

#[test]
fn three_numbers_in_front_are_eliminated_too() {
    let law = Cubes { a: 2.0 }.kernel::<Exact>();
    for place in [[1.0, 2.0, -1.0, 0.5, 3.0], [0.5, -1.0, 2.0, 4.0, 1.0]] {
        let (u, given) = (exact(place), exact([3.0, -2.0]));
        let (r, j) = law.residual_and_jacobian(&u, &given);
        let (left, schur) = law.condensed(&u, &given);
        let block = || (0..3).map(|i| j[i][..3].to_vec()).collect::<Vec<_>>();
        let of_rest = solved(block(), r[..3].to_vec());
        for i in 0..2 {
            let row = &j[3 + i];
            assert_eq!(left[i], (0..3).fold(r[3 + i], |sum, e| sum - row[e] * of_rest[e]));
            for k in 0..2 {
                let column = solved(block(), (0..3).map(|e| j[e][3 + k]).collect());
                assert_eq!(schur[i][k], (0..3).fold(row[3 + k], |sum, e| sum - row[e] * column[e]));
            }
        }
    }
}

/// Central differences: h² ∂³R/6, where ∂³R is 300 at most (h^(−3/2) at h = 0.2), and ε R/h; with h = 10⁻⁵ that is
/// 10⁻⁸.
#[test]
fn derivatives_are_those_of_differences() {
    let h = 1e-5;
    for place in [[0.7, 0.2, 1.3, 0.4, -0.3], [0.2, 1.1, 0.5, -0.8, 0.1]] {
        let given = triangle(OBTUSE, [0.3, -0.7], 1.7);
        let (darcy, manning) =
            (DarcyWeisbach { epsilon: 1e-9 }.kernel::<f64>(), Manning { epsilon: 1e-9 }.kernel::<f64>());
        let check = |residual: &dyn Fn(&[f64; 5]) -> [f64; 5], jacobian: [[f64; 5]; 5]| {
            for k in 0..5 {
                let (mut up, mut down) = (place, place);
                up[k] += h;
                down[k] -= h;
                let (up, down) = (residual(&up), residual(&down));
                for i in 0..5 {
                    let difference = (up[i] - down[i]) / (2.0 * h);
                    assert!(
                        (difference - jacobian[i][k]).abs() < 3e-8,
                        "∂R{i}/∂u{k}: {difference} {}",
                        jacobian[i][k]
                    );
                }
            }
        };
        check(&|u| darcy.residual(u, &given), darcy.residual_and_jacobian(&place, &given).1);
        check(&|u| manning.residual(u, &given), manning.residual_and_jacobian(&place, &given).1);
    }
}

#[test]
fn lanes_have_the_bits_of_one_element() {
    let (wide, one) = (
        DarcyWeisbach { epsilon: 1e-6 }.kernel::<Lanes<f64, 4>>(),
        DarcyWeisbach { epsilon: 1e-6 }.kernel::<f64>(),
    );
    let places = [[1.0, 0.5, 0.0, 0.1, 0.2], [0.0; 5], [0.3, 0.3, 0.3, 0.0, 0.0], [2.0, 0.0, 1.0, -3.0, 1.0]];
    let given: [f64; 15] = triangle(ACUTE, [0.1, 0.2], 1.5);
    let u = std::array::from_fn(|k| Lanes(places.map(|place| place[k])));
    let (left, schur) = wide.condensed(&u, &given.map(Lanes::from_f64));
    for (lane, place) in places.iter().enumerate() {
        let (own, own_schur) = one.condensed(place, &given);
        for i in 0..3 {
            assert_eq!(left[i].0[lane].to_bits(), own[i].to_bits());
            assert!((0..3).all(|k| schur[i][k].0[lane].to_bits() == own_schur[i][k].to_bits()));
        }
    }
}
