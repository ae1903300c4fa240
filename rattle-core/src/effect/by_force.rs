//! Forces of coordinates, velocities and time, as flows of momenta: on each body, or on chosen bodies.
//!
//! ```text
//! δ = h f(q, v + M⁻¹δ/2, t)        the change of p in a time h: the implicit midpoint rule for ṗ = f(q, M⁻¹p, t) at fixed q and t
//! ```
//!
//! The rule is symmetric, and stable for friction of any stiffness. Friction c with h c/m > 4 turns a velocity round in
//! each half instead of taking it away: steps need to be shorter, or the friction a
//! [`LinearDrag`](crate::effect::LinearDrag), which alone is exact. Where f jumps with v, as −sign(v) does, steps are
//! of first order, and what should stick creeps at a speed of some h/2 times c/m: see
//! [`DryFriction`](crate::effect::DryFriction). Newton's method solves the rule with ∂f/∂v from the macro; corrections
//! are halved until the residual falls. Where f does not depend on v, or v does no more than choose between forces, δ =
//! h f(q, v, t). Members that share a body act one after the other for h/2 each, in this order and then in the opposite
//! one.
//!
//! Source: E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, II.5.

use crate::effect::interval::Interval;
use crate::effect::moment::Moment;
use crate::effect::one::{Acting, Effect};
use crate::error::{Error, expect_variables, refuse_nan};
use crate::kernel::force_law::{ForceLaw, ForceLawKernel};
use crate::kernel::over::Over;
use crate::number::lanes::Lane;
use crate::number::linear::solve;
use crate::number::real::Real;
use crate::number::vector::{add_scaled, largest, scaled, sum};
use std::array::from_fn;

/// The kind of effect of every [`ForceLaw`]: a force on each body.
#[derive(Debug, Clone, Copy)]
pub struct ByForce;

/// The kind of effect of a [`ForceLaw`] [`Over`] chosen bodies, A at a time, of K = A·D components.
#[derive(Debug, Clone, Copy)]
pub struct ByForceAmong<const K: usize, const A: usize>;

/// A [`ForceLaw`] of K = A·D components on members of A bodies, or on each body: half of its flow before each step,
/// half after.
///
/// The halves use the times t and t + h of the positions. So a force f(q, t) gives kicks at both ends of the step,
/// which are of second order.
#[derive(Debug, Clone)]
pub struct ActsByForce<X, const K: usize, const A: usize> {
    kernels: Vec<X>,
    /// None where it acts on each body by itself.
    members: Option<Vec<[usize; A]>>,
    /// Whether no two members share a body.
    apart: bool,
}

impl<F: ForceLaw<D>, const D: usize> Effect<D, ByForce> for F {
    type Acting<T: Real> = ActsByForce<F::Kernel<f64>, D, 1>;
    fn acting<T: Real>(&self) -> Self::Acting<T> {
        ActsByForce { kernels: vec![self.kernel()], members: None, apart: true }
    }

    type Swept<S: Lane, const L: usize> = [Self::Acting<S>; L];

    fn check(&self, what: &'static str, _: usize) -> Result<(), Error> {
        refuse_nan(what, self.nan_parameter())
    }
}

impl<F: ForceLaw<K>, const D: usize, const K: usize, const A: usize> Effect<D, ByForceAmong<K, A>>
    for Over<F, A>
{
    type Acting<T: Real> = ActsByForce<F::Kernel<f64>, K, A>;
    fn acting<T: Real>(&self) -> Self::Acting<T> {
        const { expect_variables(K, A, D, false) };
        let mut bodies: Vec<usize> = self.members.iter().flatten().copied().collect();
        bodies.sort_unstable();
        let apart = bodies.windows(2).all(|pair| pair[0] != pair[1]);
        let kernels = self.potentials.iter().map(F::kernel).collect();
        ActsByForce { kernels, members: Some(self.members.clone()), apart }
    }

    type Swept<S: Lane, const L: usize> = [Self::Acting<S>; L];

    fn check(&self, what: &'static str, bodies: usize) -> Result<(), Error> {
        self.check_each(what, bodies, F::nan_parameter)
    }
}

impl<T: Real, X: ForceLawKernel<f64, K>, const D: usize, const K: usize, const A: usize> Acting<T, D>
    for ActsByForce<X, K, A>
{
    type Room = ();
    const FLOWS: bool = true;
    const PUSHES: bool = !X::ON_VELOCITY;
    fn room(&self, _: usize) {}

    #[inline(always)]
    fn changes_with_time(&self) -> bool {
        X::ON_TIME
    }
    fn flow(&self, during: &Interval<'_, T, D>, (): &mut (), changes: &mut [[T; D]]) {
        let &Interval { h, at, momenta, velocities, inertia, .. } = during;
        changes.fill([T::from_f64(0.0); D]);
        let members = self.members.as_ref().map_or(at.positions.len(), Vec::len);
        let mut push = |i: usize, h: f64| {
            let member = self.members.as_ref().map_or([i; A], |members| members[i]);
            let kernel = &self.kernels[if self.kernels.len() == 1 { 0 } else { i }];
            for lane in 0..momenta[0][0].lanes().count() {
                let number = |x: T| x.lanes().nth(lane).unwrap_or(f64::NAN);
                let part = |vectors: &[[T; D]]| from_fn(|k| number(vectors[member[k / D]][k % D]));
                let masses = |impulse: &[f64; K]| -> [f64; K] {
                    let of_body: [[T; D]; A] = from_fn(|a| {
                        inertia.velocity(member[a], &from_fn(|d| T::from_f64(impulse[a * D + d])))
                    });
                    from_fn(|k| number(of_body[k / D][k % D]))
                };
                let before: [f64; K] = part(changes);
                let v = part(velocities);
                let v = if X::SLOPED { sum(&v, &masses(&before)) } else { v };
                let p = part(momenta);
                let size = [p, masses(&p)].map(|x| largest(&x));
                let size = [size[0].max(largest(&before)), size[1].max(largest(&masses(&before)))];
                let change = midpoint(kernel, h, &part(at.positions), &v, at.time, size, masses);
                let after = sum(&before, &change.unwrap_or([f64::NAN; K]));
                for (k, &after) in after.iter().enumerate() {
                    let change = &mut changes[member[k / D]][k % D];
                    let others = *change;
                    *change = T::from_lanes(|l| {
                        if l == lane { after } else { others.lanes().nth(l).unwrap_or(f64::NAN) }
                    });
                }
            }
        };
        let (part, back) = if self.apart || !X::SLOPED { (h, 0) } else { (0.5 * h, members) };
        for i in (0..members).chain((0..back).rev()) {
            push(i, part);
        }
    }

    fn add_forces(&self, _: Moment<'_, T, D>, (): &mut (), _: &mut [[T; D]]) {}
    fn energy(&self, _: Moment<'_, T, D>) -> T {
        T::from_f64(0.0)
    }
}

const MAX_ITERATIONS: usize = 100;

/// Corrections are halved so often at most.
const HALVINGS: u32 = 40;

/// δ with δ = h f(q, v + M⁻¹δ/2, t) to the rounding of momenta and velocities of these sizes; none where none is found.
fn midpoint<X: ForceLawKernel<f64, K>, const K: usize>(
    kernel: &X,
    h: f64,
    q: &[f64; K],
    v: &[f64; K],
    t: f64,
    size: [f64; 2],
    masses: impl Fn(&[f64; K]) -> [f64; K],
) -> Option<[f64; K]> {
    if !X::SLOPED {
        return Some(scaled(h, &kernel.value(q, v, t)));
    }
    let halves: [[f64; K]; K] = from_fn(|j| scaled(0.5, &masses(&from_fn(|k| f64::from(u8::from(k == j))))));
    let at = |delta: &[f64; K]| -> [f64; K] {
        from_fn(|i| v[i] + (0..K).map(|j| halves[j][i] * delta[j]).sum::<f64>())
    };
    let rest = |delta: &[f64; K], f: &[f64; K]| add_scaled(delta, -h, f);
    let (mut delta, mut last) = ([0.0; K], f64::INFINITY);
    for _ in 0..MAX_ITERATIONS {
        let (f, slopes) = kernel.value_and_slopes(q, &at(&delta), t);
        let residual = rest(&delta, &f);
        let matrix: [[f64; K]; K] = from_fn(|i| {
            from_fn(|j| {
                let turn: f64 = (0..K).map(|k| slopes[i][k] * halves[j][k]).sum();
                f64::from(u8::from(i == j)) - h * turn
            })
        });
        let correction = solve(matrix, residual)?;
        // As part of the largest momentum or velocity, whichever is more; of what nothing moves, 0.
        let part = |way: &[f64; K], of: &[f64; K], size: f64| match largest(way) {
            0.0 => 0.0,
            moved => moved / size.max(largest(of)),
        };
        let moved =
            part(&correction, &delta, size[0]).max(part(&masses(&correction), &masses(&delta), size[1]));
        // The second: what is left is the rounding of the force.
        if moved <= 2.0 * f64::EPSILON || (moved <= STALLED && moved >= 0.5 * last) {
            return Some(add_scaled(&delta, -1.0, &correction));
        }
        let (mut step, left) = (1.0, largest(&residual));
        let next = (0..HALVINGS).find_map(|_| {
            let next = add_scaled(&delta, -step, &correction);
            let nearer = largest(&rest(&next, &kernel.value(q, &at(&next), t))) < left;
            step *= 0.5;
            nearer.then_some(next)
        });
        match next {
            Some(next) => (delta, last) = (next, moved),
            None if moved <= STALLED => return Some(delta),
            None => return None,
        }
    }
    None
}

/// Corrections of this part of the momentum that bring nothing are the rounding of the force.
const STALLED: f64 = 1e-9;
