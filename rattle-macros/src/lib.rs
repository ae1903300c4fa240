//! Macros of `rattle`: mathematics in, native functions with their derivatives out.
//!
//! The work is done by `rattle-symbolic`; this crate only hands tokens over.

use proc_macro::TokenStream;
use rattle_symbolic::{Macro, expand};

/// Equations g(q) = 0 that hold during the motion.
///
/// ```text
/// constraint! {
///     /// A torus.
///     pub struct Torus { major, minor }
///     |x, y, z| {
///         let distance = sqrt(x^2 + y^2) - major;
///         distance^2 + z^2 - minor^2
///     }
/// }
/// ```
///
/// makes `pub struct Torus { pub major: f64, pub minor: f64 }` with `value`, `jacobian`,
/// `hessian_vector`, `jet`, `hessian` and more, by the trait `Constraint`. Visibility, attributes and
/// doc comments pass through, those of fields too; the formula, its gradient and the operations per call
/// are added to the documentation. The struct derives `Clone`, `Copy`, `Debug` and `PartialEq`; others go into
/// a `#[derive(…)]` of your own, where these four do no harm. There are no generics: parameters are `f64` or
/// arrays of `f64`.
///
/// A `#[cfg(…)]` goes before the struct, and holds for all that is made for it; parameters have none. All functions
/// together have at most 80 000 operations, which take the compiler about 10 s.
///
/// What is written refers to the crate as `::rattle`, so a dependency under another name in `Cargo.toml` is not
/// found: with `other = { package = "rattle-rs", … }`, add `extern crate other as rattle;` to the root of the crate.
///
/// # The language
///
/// ```text
/// numbers      2  0.5  1e-3                  all real: 2 is the real two, 1/2 is 0.5
/// constants    pi  e
/// operators    + - * / ^                     ^ is power: from the right, before the sign: -x^2 = -(x^2)
/// functions    sqrt cbrt exp ln log10 log2 sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh
///              abs sign floor erf min max mod atan2 hypot pow norm dot      also as methods: x.sin()
/// blocks       { let f = x^2; f + y }
/// branches     if x < 1 && y >= 0 { x } else { y }
/// arrays       |a: [f64; 3], m: [[f64; 2]; 2]|   a[0]   m[i][k]   2 * a - b   struct S { n: [f64; 3] }
/// loops        sum(k in 0..3, a[k]^2)   product(k in 0..=3, …)   delta(i, j)
/// equations    [g1, g2]   for i in 0..3, j in i..3 { … }     one row of the Jacobian each, in order
/// ```
///
/// Indices are constants or the indices of loops. What compares indices alone is decided at compile time,
/// within a longer condition too: in `if i > 0 && x[i - 1] > 0 { … }` nothing is read at i = 0. A variable on which
/// nothing depends is written `_z`.
///
/// # What is computed
///
/// `value` is, bit for bit, the expression as written in Rust. Powers are multiplications in a fixed
/// order: `x^n = x^(n-1) * x` for odd n and `x^(n/2) * x^(n/2)` for even n, `x^(n+1/2) = x^n * sqrt(x)`,
/// `x^-n = 1 / x^n`, and `x^(n/3)` is the n-th power of `cbrt(x)`; any other exponent is `powf`, where an
/// exponent that moves needs a positive base. An exponent of numbers and indices alone is worked out as an exact
/// fraction: `x^(0.1 + 0.2)` is `x^(3/10)`, where the sum of the two in `f64` would be 0.30000000000000004. `norm` is
/// the root of the sum of squares, `min` and `max` take the first argument on a tie and where either is NaN;
/// `mod(x, y)` is `x - y * floor(x / y)`, for what repeats. Derivatives may be rearranged, always in
/// the same way. Where a function has no derivative, it is set:
///
/// ```text
/// abs'(0) = 1     sign' = floor' = 0     sqrt'(0) = cbrt'(0) = 0     norm, hypot and atan2 at the origin: 0
/// ```
///
/// A branch is differentiated by choosing between the derivatives of its arms, so the arm not taken has
/// no influence, NaN or not.
///
/// Power series of derivatives along a curve, for `Taylor`, are those of the branch at its start; where one turns just
/// there, or a function is not smooth (`sqrt`, `ln`, `cbrt`, real powers at 0), coefficients are NaN or infinite, and a
/// step is an error.
#[proc_macro]
pub fn constraint(input: TokenStream) -> TokenStream {
    expand(Macro::Constraint, input.into()).into()
}

/// A potential energy U(q): one expression of all coordinates, in the language of [`constraint!`].
///
/// Unlike in a constraint, a variable need not be used: a force may act along one axis only.
///
/// A last variable that is called `t` is the time: `|x, y, z, t| -a * cos(w * t) * x` is a potential of three
/// coordinates that changes with time, by the trait `DrivenPotential`. The work that it does, ∫ ∂U/∂t dt, is told by
/// the simulation.
#[proc_macro]
pub fn potential(input: TokenStream) -> TokenStream {
    expand(Macro::Potential, input.into()).into()
}

/// A force f(q, v, t): as many components as coordinates, in the language of [`constraint!`].
///
/// ```text
/// force! {
///     /// A motor that turns an arm about z, against friction.
///     pub struct Motor { torque, friction }
///     |q: [f64; 3], v: [f64; 3], t| {
///         let push = torque * sin(t) / (q[0]^2 + q[1]^2);
///         [-push * q[1] - friction * v[0], push * q[0] - friction * v[1], 0]
///     }
/// }
/// ```
///
/// First all coordinates, then as many velocities, then the time, which is called `t`; velocities and time are left out
/// where nothing depends on them. Variables may be numbers, `|x, y, vx, vy, t|`, and need not be used. The force of
/// several bodies, for `.over(members)`, has the coordinates of all of them, then the velocities of all, and D
/// components for each. It is what is added to ṗ; on a rigid body, of nine coordinates, the first three of nine
/// components are the torque in the frame of the body, and the first three of nine velocities the angular velocity
/// there. ∂f/∂v is differentiated, for the implicit steps of stiff friction.
#[doc(alias = "motor")]
#[proc_macro]
pub fn force(input: TokenStream) -> TokenStream {
    expand(Macro::Force, input.into()).into()
}

/// A potential energy U(r) of two bodies at distance r, of one variable: `|r| -k / r`.
///
/// It is evaluated as a function of s = r². Where U is even in r as it is written (sums, products,
/// quotients and powers are followed), that needs no root and has no 0/0 at contact. Other functions
/// are evaluated at r = √s, with dU/ds = U′(r)/(2r), and U″(0)/2 at contact. The language is that of
/// [`constraint!`].
#[proc_macro]
pub fn pair_potential(input: TokenStream) -> TokenStream {
    expand(Macro::PairPotential, input.into()).into()
}

/// An energy H(q, p) of coordinates and momenta: `|q: [f64; 2], p: [f64; 2]| dot(p, p) / 2 + g * q[1]`.
#[proc_macro]
pub fn hamiltonian(input: TokenStream) -> TokenStream {
    expand(Macro::Hamiltonian, input.into()).into()
}

/// Equations g(q, p) = 0 between coordinates and momenta: `|q: [f64; 2], p: [f64; 2]| dot(q, q) + dot(p, p) - 1`.
#[proc_macro]
pub fn phase_constraint(input: TokenStream) -> TokenStream {
    expand(Macro::PhaseConstraint, input.into()).into()
}

/// The residual of an element of a mesh: unknowns, given numbers, several components, in the language of
/// [`constraint!`].
///
/// ```text
/// residual! {
///     /// A slope vector p with |p| p = c, for each element with its own c.
///     pub struct Slope { epsilon }
///
///     |h: [f64; 3], p: [f64; 2]|                 // the unknowns, differentiated
///     given |c: [f64; 2], old: [f64; 3]|         // numbers of the element, not differentiated
///     eliminate(p)                               // local to the element: the Schur complement is written out
///     {
///         let size = norm(p);
///         let smooth = sqrt(dot(p, p) + epsilon^2);
///         [h - old, size * p - c]
///         linearise [h - old, smooth * p - c]    // differentiated in the stead of the residual
///     }
/// }
/// ```
///
/// makes the struct, with `kernel::<T>()` of the type `SlopeKernel<T>`, over any scalar. Its functions take the
/// unknowns and the given numbers in the order in which they are written, as flat arrays:
///
/// ```text
/// residual(u, d)                 R, as written
/// residual_and_jacobian(u, d)    R and Jᵢⱼ = ∂Lᵢ/∂uⱼ, L = R or what stands after `linearise`
/// condensed(u, d)                Rₖ − Jₖₑ Jₑₑ⁻¹ Rₑ and Jₖₖ − Jₖₑ Jₑₑ⁻¹ Jₑₖ      e: eliminated, k: the rest
/// condensed_residual(u, d)       the first of the two
/// recovered(u, d, δuₖ)           δuₑ = −Jₑₑ⁻¹ (Rₑ + Jₑₖ δuₖ)
/// ```
///
/// `given`, `eliminate` (of at most three numbers; component i then belongs to unknown i) and `linearise` may be left
/// out. Over lanes several elements go side by side. Branches are differentiated branch by branch; there is no
/// pivoting, so Jₑₑ must be regular for every value.
#[proc_macro]
pub fn residual(input: TokenStream) -> TokenStream {
    rattle_symbolic::residual(input.into()).into()
}
