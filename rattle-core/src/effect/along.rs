//! A potential between near bodies, as a function of their distance along the surface g = 0 on which they move.
//!
//! ```text
//! d² = |Δ|² − ⅓ (nᵢ·Δ)(nⱼ·Δ)        Δ = qⱼ − qᵢ,  n = ∇g/|∇g|
//! ```
//!
//! This is the square of the geodesic distance to the first order beyond |Δ|². On a sphere of radius R its error is
//! d⁶/(90 R⁴), and that of |Δ|² is d⁴/(12 R²). Forces are the exact gradient of U(d), so energy is conserved:
//!
//! ```text
//! ∂d²/∂qⱼ = 2Δ − ⅓ [(nᵢ·Δ) nⱼ + (nⱼ·Δ) nᵢ + (nᵢ·Δ) Dnⱼᵀ Δ]        Dnᵀ = ∇²g (1 − n nᵀ)/|∇g|
//! ```
//!
//! The last term is linear in Δ and is summed over partners first, so that each body needs one product with ∇²g.

use crate::effect::between_near::check_within;
use crate::effect::interval::Interval;
use crate::effect::moment::Moment;
use crate::effect::neighbours::Neighbours;
use crate::effect::one::{Acting, Effect};
use crate::error::{EffectMistake, Error, refuse_nan};
use crate::kernel::cut_off::CutOff;
use crate::kernel::functions::{Constraint, ConstraintKernel, PairKernel, PairPotential};
use crate::kernel::space::Space;
use crate::kernel::within::{Along, Within};
use crate::number::lanes::Lane;
use crate::number::real::{Mask, Real};
use crate::number::vector::{add_scaled, dot, largest, scaled};
use std::array::from_fn;

/// The kind of effect of every [`Along`]: a potential of distances along a surface.
#[derive(Debug, Clone, Copy)]
pub struct AlongSurface;

/// [`Along`] over a scalar: a potential of distances along a surface.
#[derive(Debug, Clone)]
pub struct ActsAlong<X, C, B> {
    law: X,
    surface: C,
    space: B,
    reach: f64,
    skin: f64,
}

/// |Δ|² ≤ 1.5 d², as |n·Δ| ≤ |Δ|: so much farther than along the surface bodies are looked for through space.
const FARTHER: f64 = 1.225;

impl<P: PairPotential, C: Constraint<D, 1>, B: Space<D>, const D: usize> Effect<D, AlongSurface>
    for Along<P, C, B>
{
    type Acting<T: Real> = ActsAlong<CutOff<P::Kernel<T>, T>, C::Kernel<T>, B>;
    fn acting<T: Real>(&self) -> Self::Acting<T> {
        let Within { reach, skin, space, .. } = self.within;
        ActsAlong { law: self.within.cut_off(), surface: self.surface.kernel(), space, reach, skin }
    }

    type Swept<S: Lane, const L: usize> = [Self::Acting<S>; L];
    fn swept<'a, S: Lane, const L: usize>(lane: impl Fn(usize) -> &'a Self) -> Self::Swept<S, L>
    where
        Self: 'a,
    {
        from_fn(|i| Effect::<D, AlongSurface>::acting(lane(i)))
    }

    fn check(&self, what: &'static str, bodies: usize) -> Result<(), Error> {
        refuse_nan(what, self.surface.nan_parameter())?;
        check_within(&self.within, FARTHER, what, bodies)
    }
}

/// How far two bodies may be off one level of g, as part of the largest coordinate or the reach: twice what each may be
/// off where it starts.
const NEAR: f64 = 2e-9;
/// The sine of the angle by which the normal of g may differ from that of the surface on which a body is.
const ALIKE: f64 = 1e-6;

/// Checks that distances along g = 0 are distances along the surface on which bodies are: bodies within reach of each
/// other are on one level of g, and where each is on a surface, the normals of the two are the same. Other levels than
/// 0 serve: nothing but derivatives of g is asked for.
///
/// # Errors
/// [`EffectMistake::NotAlong`].
pub(crate) fn along_its_surface<T: Real, B: Space<D>, const D: usize>(
    during: &Interval<'_, T, D>,
    space: &B,
    slope: impl Fn(usize) -> (f64, [f64; D]),
    near: impl Fn(&[f64; D], [[f64; D]; 2]) -> bool,
    reach: f64,
) -> Result<(), EffectMistake> {
    let Some(positions) = T::doubles(during.at.positions) else { return Ok(()) };
    let mut levels = Vec::with_capacity(positions.len());
    for body in 0..positions.len() {
        let (level, gradient) = slope(body);
        let steep = dot(&gradient, &gradient).sqrt();
        let normal = gradient.map(|x| x / steep);
        if let Some(surface) = during.surface {
            let of_body = surface.normal(body).map(number);
            let across = add_scaled(&normal, -dot(&normal, &of_body), &of_body);
            let sine = dot(&across, &across).sqrt();
            if sine > ALIKE {
                return Err(EffectMistake::NotAlong { body, other: None, off: sine });
            }
        }
        levels.push((level, steep, normal));
    }
    let apart = |i: usize, j: usize| (levels[i].0 - levels[j].0).abs() / levels[i].1.max(levels[j].1);
    let allowed = |i: usize, j: usize| NEAR * largest(&positions[i]).max(largest(&positions[j])).max(reach);
    let off = |i: usize, j: usize| {
        let way = || space.apart(&positions[j], &positions[i]);
        apart(i, j) > allowed(i, j) && near(&way(), [levels[i].2, levels[j].2])
    };
    for i in 1..positions.len() {
        // Most are on the level of the first one: pairs are tried for others alone.
        if apart(i, 0) > 0.1 * allowed(i, 0)
            && let Some(j) = (0..positions.len()).find(|&j| j != i && off(i, j))
        {
            return Err(EffectMistake::NotAlong { body: i, other: Some(j), off: apart(i, j) });
        }
    }
    Ok(())
}

/// A number of one lane.
fn number<T: Real>(x: T) -> f64 {
    x.lanes().next().unwrap_or(f64::NAN)
}

/// Memory for the list of near pairs, and for the normals and other quantities of each body.
#[derive(Debug, Clone)]
pub struct Upright<T, const D: usize> {
    list: Neighbours<D>,
    /// n and |∇g|.
    normals: Vec<([T; D], T)>,
    /// ⅓ Σ U′(s) (n·Δ) Δ, with the normal of the partner.
    turns: Vec<[T; D]>,
}

/// Two bodies within reach.
struct Pair<T, const D: usize> {
    i: usize,
    j: usize,
    /// Δ.
    way: [T; D],
    /// nᵢ·Δ and nⱼ·Δ.
    rises: [T; 2],
    /// d².
    square: T,
}

impl<X, C, B> ActsAlong<X, C, B> {
    /// Makes the room serve at these positions; says whether it does.
    fn look<T: Real, const D: usize>(&self, positions: &[[T; D]], skin: f64, room: &mut Upright<T, D>) -> bool
    where
        C: ConstraintKernel<T, D, 1>,
        B: Space<D>,
    {
        for (normal, q) in room.normals.iter_mut().zip(positions) {
            let [gradient] = self.surface.jacobian(q);
            let length = dot(&gradient, &gradient).sqrt();
            *normal = (gradient.map(|x| x / length), length);
        }
        match T::doubles(positions) {
            Some(positions) => room.list.renew(positions, &self.space, FARTHER * self.reach, skin),
            None => {
                room.list.take_all();
                true
            }
        }
    }

    /// Pairs within reach, in the order of their numbers.
    fn pairs<'a, T: Real, const D: usize>(
        &'a self,
        positions: &'a [[T; D]],
        list: &'a Neighbours<D>,
        normals: &'a [([T; D], T)],
    ) -> impl Iterator<Item = Pair<T, D>> + 'a
    where
        B: Space<D>,
    {
        let pair = move |i: usize, j: usize| {
            let way = self.space.apart(&positions[j], &positions[i]);
            let rises = [dot(&normals[i].0, &way), dot(&normals[j].0, &way)];
            let third = T::from_f64(1.0 / 3.0);
            Pair { i, j, way, rises, square: dot(&way, &way) - third * rises[0] * rises[1] }
        };
        let all = (1..positions.len()).flat_map(|i| list.row(i).iter().map(move |&j| (i, j as usize)));
        let beyond = T::from_f64(self.reach * self.reach);
        all.map(move |(i, j)| pair(i, j)).filter(move |pair| !beyond.le(pair.square).all())
    }
}

impl<T, X, C, B, const D: usize> Acting<T, D> for ActsAlong<X, C, B>
where
    T: Real,
    X: PairKernel<T>,
    C: ConstraintKernel<T, D, 1>,
    B: Space<D>,
{
    type Room = Upright<T, D>;
    const LOOKS: bool = true;
    fn room(&self, bodies: usize) -> Upright<T, D> {
        let zero = T::from_f64(0.0);
        Upright {
            list: Neighbours::new(bodies),
            normals: vec![([zero; D], zero); bodies],
            turns: vec![[zero; D]; bodies],
        }
    }

    fn fits(&self, during: &Interval<'_, T, D>) -> Result<(), EffectMistake> {
        let slope = |body: usize| {
            let ([value], [gradient]) = self.surface.value_and_jacobian(&during.at.positions[body]);
            (number(value), gradient.map(number))
        };
        let near = |way: &[f64; D], normals: [[f64; D]; 2]| {
            let rises = normals.map(|normal| dot(&normal, way));
            dot(way, way) - rises[0] * rises[1] / 3.0 < self.reach * self.reach
        };
        along_its_surface(during, &self.space, slope, near, self.reach)
    }

    fn add_forces(&self, at: Moment<'_, T, D>, room: &mut Upright<T, D>, forces: &mut [[T; D]]) {
        if !self.look(at.positions, self.skin, room) {
            if forces.len() > 1 {
                forces.fill([T::from_f64(f64::NAN); D]);
            }
            return;
        }
        let Upright { list, normals, turns } = room;
        turns.fill([T::from_f64(0.0); D]);
        for Pair { i, j, way, rises: [a, b], square } in self.pairs(at.positions, list, normals) {
            let (slope, third) = (self.law.slope(square), T::from_f64(1.0 / 3.0));
            let [along_i, along_j] = [b, a].map(|rise| -(third * rise));
            let gradient = add_scaled(&scaled(T::from_f64(2.0), &way), along_i, &normals[i].0);
            let gradient = add_scaled(&gradient, along_j, &normals[j].0);
            forces[i] = add_scaled(&forces[i], slope, &gradient);
            forces[j] = add_scaled(&forces[j], -slope, &gradient);
            turns[i] = add_scaled(&turns[i], third * slope * b, &way);
            turns[j] = add_scaled(&turns[j], third * slope * a, &way);
        }
        for (((q, force), (normal, length)), turn) in
            at.positions.iter().zip(forces).zip(&*normals).zip(turns)
        {
            let tangent = add_scaled(turn, -dot(normal, turn), normal);
            let [bent] = self.surface.hessian_vector(q, &tangent);
            *force = add_scaled(force, T::from_f64(1.0) / *length, &bent);
        }
    }

    fn energy(&self, at: Moment<'_, T, D>) -> T {
        let mut room = self.room(at.positions.len());
        if !self.look(at.positions, 0.0, &mut room) {
            return T::from_f64(f64::NAN);
        }
        let pairs = self.pairs(at.positions, &room.list, &room.normals);
        pairs.fold(T::from_f64(-0.0), |energy, pair| energy + self.law.value(pair.square))
    }
}
