//! Macros of `rattle`: mathematics in, native functions with their derivatives out.
//!
//! `rattle-symbolic` does the work; this crate only passes tokens to it.

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
/// makes `pub struct Torus { pub major: f64, pub minor: f64 }` with `value`, `jacobian`, `hessian_vector`, `jet`,
/// `hessian` and more, by the trait `Constraint`. Visibility, attributes and doc comments of the struct and its fields
/// are kept. The formula, its gradient and the number of operations per call are added to the documentation. The struct
/// derives `Clone`, `Copy`, `Debug` and `PartialEq`; further traits go into a `#[derive(…)]` of your own, which may
/// repeat these four. There are no generics: parameters are `f64` or arrays of `f64`.
///
/// A `#[cfg(…)]` before the struct holds for all generated code; parameters cannot have one. All functions together
/// have at most 80 000 operations, which take the compiler about 10 s.
///
/// The generated code refers to the crate as `::rattle`. If the dependency has another name in `Cargo.toml`, as with
/// `other = { package = "rattle-rs", … }`, add `extern crate other as rattle;` to the root of your crate.
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
/// Indices are constants or loop indices. A comparison of indices and numbers, by `+ - * / ^` alone, is decided at
/// compile time, in exact fractions, also inside a longer condition: in `if i > 0 && x[i - 1] > 0 { … }` nothing is
/// read at i = 0. A sum over an empty range is 0, to which an array can be added, and a product 1. An unused variable
/// is written `_z`.
///
/// # What is computed
///
/// `value` is, bit for bit, the expression as written in Rust. Powers are multiplications in a fixed order:
/// `x^n = x^(n-1) * x` for odd n and `x^(n/2) * x^(n/2)` for even n, `x^(n+1/2) = x^n * sqrt(x)`, `x^-n = 1 / x^n`, and
/// `x^(n/3)` is the n-th power of `cbrt(x)`; any other exponent is `powf`; an exponent that depends on variables needs
/// a positive base. An exponent of numbers and indices, by `+ - * / ^` alone, is computed as an exact fraction:
/// `x^(0.1 + 0.2)` is `x^(3/10)`, where the sum of the two in `f64` would be 0.30000000000000004. `norm` is the root of
/// the sum of squares; the root of an even power is an absolute value, `sqrt(x^4)` is `abs(x)^2`, also where the power
/// overflows. `min` and `max` take the first argument on a tie and where either is NaN; `mod(x, y)` is
/// `x - y * floor(x / y)`, for periodic functions. Derivatives may be rearranged, the same way in every build. Where a
/// function has no derivative, these values are taken:
///
/// ```text
/// abs'(0) = 1     sign' = floor' = 0     sqrt'(0) = cbrt'(0) = 0     norm, hypot and atan2 at the origin: 0
/// sqrt(x^2), and norm of one number, are abs(x)
/// x^y at x = 0, where 0 <= y < 1: 0     (second derivatives are what the formula of the first one makes them)
/// x^(3/2) and x^(4/3) at x = 0: second derivatives are 0 too, those of other powers from 1 to 2 infinite
/// ```
///
/// Powers that are smooth again have the derivatives of what they come to, if they are written just so: `sqrt(x)^2`
/// where x is not negative, `cbrt(x)^3`, `norm(a)^2`, `hypot(x, y)^2` of up to 64 sides. Where a part of an expression
/// overflows, a derivative may be 0 times infinity, which is an error when it is met: write `(1 - tanh(x / 2)) / 2` for
/// `1 / (1 + exp(x))`. Far out, where it is no more than a rounding of 1, that and its derivative lose their digits.
///
/// A branch is differentiated by choosing between the derivatives of its arms, so the arm not taken has
/// no influence, NaN or not. Where `max` or `min` hold a value, functions of it have no slope, also where theirs is
/// infinite: `acos(max(-1, min(1, c)))`.
///
/// Power series along a curve, for `Taylor`, are those of the branch taken at the start of the curve. Where the curve
/// starts just at a change of branches, or where a function is not smooth (`sqrt`, `ln`, `cbrt`, real powers at 0),
/// coefficients are NaN or infinite: a fixed step is an error then, and `Taylor::adaptive` goes a little way without.
/// A spring that pushes on one side only, as `max(x, 0)^2.5`, has none wherever it does not push: write
/// `if x > 0 { x^2.5 } else { 0 }`.
#[proc_macro]
pub fn constraint(input: TokenStream) -> TokenStream {
    expand(Macro::Constraint, input.into()).into()
}

/// A potential energy U(q): one expression of all coordinates, in the language of [`constraint!`].
///
/// Unlike in a constraint, variables may be unused: a force may act along one axis only.
///
/// A last variable named `t` is the time: `|x, y, z, t| -a * cos(w * t) * x` is a potential of three coordinates that
/// changes with time, and implements `DrivenPotential`. The simulation reports its work, ∫ ∂U/∂t dt.
#[proc_macro]
pub fn potential(input: TokenStream) -> TokenStream {
    expand(Macro::Potential, input.into()).into()
}

/// A force f(q, v, t) with as many components as coordinates, in the language of [`constraint!`].
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
/// The variables are all coordinates, then as many velocities, then the time, named `t`; velocities and time are left
/// out where nothing depends on them. Variables may be single numbers, `|x, y, vx, vy, t|`, and may be unused. A force
/// on several bodies, for `.over(members)`, takes the coordinates of all of them, then the velocities of all, and has D
/// components for each body. The force is added to ṗ. A rigid body has nine coordinates: there the first three of nine
/// components are the torque, and the first three of nine velocities the angular velocity, both in the frame of the
/// body; the other components of the force are 0, as the other velocities are. The macro also writes ∂f/∂v, for the
/// implicit steps of stiff friction.
#[doc(alias = "motor")]
#[proc_macro]
pub fn force(input: TokenStream) -> TokenStream {
    expand(Macro::Force, input.into()).into()
}

/// A potential energy U(r) of two bodies at distance r, of one variable: `|r| -k / r`.
///
/// U is evaluated as a function of s = r². Where the macro sees that U is even in r (through sums, products, quotients
/// and powers), that needs no root and has no 0/0 at r = 0. Other functions are evaluated at r = √s, with dU/ds =
/// U′(r)/(2r), and U″(0)/2 at r = 0. The language is that of [`constraint!`].
#[proc_macro]
pub fn pair_potential(input: TokenStream) -> TokenStream {
    expand(Macro::PairPotential, input.into()).into()
}

/// An energy H(q, p) of coordinates and momenta: `|q: [f64; 2], p: [f64; 2]| dot(p, p) / 2 + g * q[1]`, or by numbers
/// `|x, y, px, py| (px^2 + py^2) / 2 + g * y`. In more than two variables momenta have the names of their coordinates,
/// as `px` of `x`, `p_phi` of `phi`, `p1` of `q1`, and stand in the same order.
#[proc_macro]
pub fn hamiltonian(input: TokenStream) -> TokenStream {
    expand(Macro::Hamiltonian, input.into()).into()
}

/// Equations g(q, p) = 0 between coordinates and momenta: `|q: [f64; 2], p: [f64; 2]| dot(q, q) + dot(p, p) - 1`, in
/// variables as those of [`hamiltonian!`].
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
/// makes the struct, whose `kernel::<T>()` returns a `SlopeKernel<T>` over any scalar `T`. The functions of the kernel
/// take the unknowns u and the given numbers d as flat arrays, in the order in which they are written:
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
/// out. With SIMD lanes as `T`, several elements are evaluated at once. Branches are differentiated branch by branch.
/// There is no pivoting, so Jₑₑ must be regular for every value.
#[proc_macro]
pub fn residual(input: TokenStream) -> TokenStream {
    rattle_symbolic::residual(input.into()).into()
}
