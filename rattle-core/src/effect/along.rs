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
use crate::error::{EffectMistake, Error};
use crate::kernel::cut_off::CutOff;
use crate::kernel::functions::{Constraint, ConstraintKernel, PairKernel, PairPotential};
use crate::kernel::over::refuse_nan_in;
use crate::kernel::rounding::{allowed, sizes};
use crate::kernel::space::Space;
use crate::kernel::within::{Along, Within};
use crate::number::lanes::Lane;
use crate::number::real::{Mask, Real};
use crate::number::vector::{add_scaled, dot, largest, scaled};

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

    fn check(&self, what: &'static str, bodies: usize) -> Result<(), Error> {
        refuse_nan_in::<C>(self.surface.nan_parameter())?;
        check_within(&self.within, FARTHER, what, bodies)
    }
}

/// How far two bodies may be off one level of g, as part of the largest coordinate or the reach, or of the size of the
/// surface if that is smaller: twice what each may be off where it starts.
const NEAR: f64 = 2e-9;
/// The sine of the angle by which the normal of g may differ from that of the surface on which a body is.
const ALIKE: f64 = 1e-6;
/// Where a surface repeats itself, a rounding of places that is so small a part of the period turns normals by 1.
const OF_A_PERIOD: f64 = 1.0 / 64.0;

/// What a place is on: g, |∇g| and the normal, and how far another on the same level may be off it.
struct Level<const D: usize> {
    value: f64,
    steep: f64,
    normal: [f64; D],
    allowed: f64,
}

impl<const D: usize> Level<D> {
    /// From g, ∇g and ∇²g ∇g.
    fn of(q: &[f64; D], reach: f64, (value, gradient, bend): (f64, [f64; D], [f64; D])) -> Self {
        let steep = dot(&gradient, &gradient).sqrt();
        let (along, singular) = sizes(q, &gradient, &bend);
        let allowed = allowed(NEAR, [largest(q).max(reach), along], singular);
        Self { value, steep, normal: gradient.map(|x| x / steep), allowed }
    }

    /// How far the levels are apart.
    fn apart(&self, other: &Self) -> f64 {
        (self.value - other.value).abs() / self.steep.max(other.steep)
    }

    /// Whether the levels are not one.
    fn differs(&self, other: &Self) -> bool {
        self.apart(other) > self.allowed.max(other.allowed)
    }
}

/// The sine of the angle between two unit vectors.
fn sine<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    let across = add_scaled(a, -dot(a, b), b);
    dot(&across, &across).sqrt()
}

/// Checks that distances along g = 0 are distances along the surface on which bodies are: bodies within reach of each
/// other are on one level of g, where each is on a surface, the normals of the two are the same, and a period brings
/// each to the same level and normal. Other levels than 0 serve: nothing but derivatives of g is asked for. `at` tells
/// g, ∇g and ∇²g ∇g; the sign of normals counts for some.
///
/// # Errors
/// [`EffectMistake::NotAlong`], [`EffectMistake::NotRepeated`].
pub(crate) fn along_its_surface<T: Real, B: Space<D>, const D: usize>(
    during: &Interval<'_, T, D>,
    space: &B,
    at: impl Fn(&[f64; D]) -> (f64, [f64; D], [f64; D]),
    near: impl Fn(&[f64; D], [[f64; D]; 2]) -> bool,
    reach: f64,
    signed: bool,
) -> Result<(), EffectMistake> {
    let Some(positions) = T::doubles(during.at.positions) else { return Ok(()) };
    let mut levels = Vec::with_capacity(positions.len());
    for (body, q) in positions.iter().enumerate() {
        let level = Level::of(q, reach, at(q));
        if let Some(surface) = during.surface {
            let off = sine(&level.normal, &surface.normal(body).map(number));
            if off > ALIKE {
                return Err(EffectMistake::NotAlong { body, other: None, off });
            }
        }
        for (coordinate, period) in space.periods().into_iter().enumerate().filter(|(_, p)| p.is_finite()) {
            for shift in [period, -period] {
                let mut image = *q;
                image[coordinate] += shift;
                let image = Level::of(&image, reach, at(&image));
                let turned = if signed {
                    let turn = add_scaled(&image.normal, -1.0, &level.normal);
                    dot(&turn, &turn).sqrt()
                } else {
                    sine(&image.normal, &level.normal)
                };
                let rounded = f64::EPSILON * largest(q) / (OF_A_PERIOD * period);
                if level.differs(&image) || turned > ALIKE.max(rounded) {
                    let off = level.apart(&image).max(turned);
                    return Err(EffectMistake::NotRepeated { body, coordinate, period, off });
                }
            }
        }
        levels.push(level);
    }
    let off = |i: usize, j: usize| {
        let way = || space.apart(&positions[j], &positions[i]);
        levels[i].differs(&levels[j]) && near(&way(), [levels[i].normal, levels[j].normal])
    };
    for (i, level) in levels.iter().enumerate() {
        // Most are on the level of the first one: pairs are tried for others alone. Of two that differ one is off it
        // by half of what it may be.
        if (level.value - levels[0].value).abs() > 0.5 * level.steep * level.allowed
            && let Some(j) = (0..positions.len()).find(|&j| j != i && off(i, j))
        {
            return Err(EffectMistake::NotAlong { body: i, other: Some(j), off: level.apart(&levels[j]) });
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
        let at = |q: &[f64; D]| {
            let q = q.map(T::from_f64);
            let ([value], [gradient]) = self.surface.value_and_jacobian(&q);
            let [bend] = self.surface.hessian_vector(&q, &gradient);
            (number(value), gradient.map(number), bend.map(number))
        };
        let near = |way: &[f64; D], normals: [[f64; D]; 2]| {
            let rises = normals.map(|normal| dot(&normal, way));
            dot(way, way) - rises[0] * rises[1] / 3.0 < self.reach * self.reach
        };
        along_its_surface(during, &self.space, at, near, self.reach, true)
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
