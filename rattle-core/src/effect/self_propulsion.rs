//! Active particles: bodies that propel themselves along a heading.

use crate::effect::interval::{Interval, Manner, Rule};
use crate::effect::moment::Moment;
use crate::effect::noise::{Noise, halves};
use crate::effect::one::{Acting, Effect};
use crate::error::{EffectMistake, Error};
use crate::number::lanes::Lane;
use crate::number::real::{Mask, Real};
use crate::number::vector::{add_scaled, dot, scaled, sum};
use nalgebra::SVector;
use std::array::from_fn;

/// Self-propulsion: a force of constant size along a heading u, a unit tangent vector that rotational noise turns.
///
/// ```text
/// ṗ = F u
/// du = √(2D_r) (n × u) dW along the path, between turns parallel to the surface      ⟨u(t)·u(0)⟩ = exp(−D_r t) in the plane
/// ```
///
/// With [`Brownian`](crate::methods::brownian::Brownian) and the friction γ bodies are active Brownian particles of the
/// speed v = F/(γm); with [`Langevin`](crate::effect::Langevin) or [`LinearDrag`](crate::effect::LinearDrag) they have
/// inertia too. For bodies on surfaces in space, and for free bodies in the plane.
///
/// Headings move with the bodies by parallel transport (T. Levi-Civita 1917): in each step by the smallest rotation
/// that takes the old normal to the new one. This is exact where normals move along a great circle, and of second order
/// elsewhere. Half of the noise of a step turns a heading before the step and half after it. The force is of second
/// order like all flows, but of first order where bodies meet others or walls, since it acts before and after the whole
/// step; bodies that press against a wall stay at it. Its work counts as
/// [work](crate::run::simulation::Simulation::work). Headings are part of the
/// [marks](crate::run::simulation::Simulation::marks) and the [state](crate::run::simulation::Simulation::state) of a
/// simulation. At the start they are random, or as given.
///
/// Source: C. Bechinger, R. Di Leonardo, H. Löwen, C. Reichhardt, G. Volpe, G. Volpe, Rev. Mod. Phys. 88 (2016) 045006,
/// section II; on surfaces: R. Sknepnek, S. Henkes, Phys. Rev. E 91 (2015) 022306.
///
/// ```
/// use rattle::effect::SelfPropulsion;
/// use rattle::prelude::*;
///
/// // In the plane ⟨(q − q₀)²⟩ = 4Dt + 2(v/D_r)² (D_r t − 1 + exp(−D_r t)), here with D = 0.
/// let active = Scene::points::<2>(2000).with(SelfPropulsion::new(1.0, 0.5, 7));
/// let method = Brownian::new(1.0, 0.0, 1, 0.05);
/// let mut simulation = active.simulate(State::of([[0.0, 0.0]; 2000]), method)?;
/// simulation.run(40)?;
/// let mean = simulation.positions().map(|q| q.norm_squared()).sum::<f64>() / 2000.0;
/// let x: f64 = 0.5 * 2.0;
/// assert!((mean - 2.0 / 0.25 * (x - 1.0 + (-x).exp())).abs() < 0.1);
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "active matter")]
#[doc(alias = "active Brownian particle")]
#[doc(alias = "motor")]
#[derive(Debug, Clone, PartialEq)]
pub struct SelfPropulsion<const D: usize> {
    force: f64,
    turning: f64,
    seed: u64,
    /// Of each body; without, they are drawn.
    headings: Option<Vec<[f64; D]>>,
}

impl<const D: usize> SelfPropulsion<D> {
    /// The force F, at least 0, in the unit of force; the rotational diffusion D_r, a rate in the unit of 1/time; and
    /// the seed of the random numbers.
    #[must_use]
    pub fn new(force: f64, turning: f64, seed: u64) -> Self {
        Self { force, turning, seed, headings: None }
    }

    /// The same with these headings at the start, one for each body; a state that is read from a simulation has its
    /// own. Each is projected onto the tangent plane and scaled to length 1.
    #[must_use]
    pub fn headed(mut self, headings: impl IntoIterator<Item = [f64; D]>) -> Self {
        self.headings = Some(headings.into_iter().collect());
        self
    }

    /// The headings in the [marks](crate::run::simulation::Simulation::marks) of this effect.
    pub fn headings(marks: &[f64]) -> impl ExactSizeIterator<Item = SVector<f64, D>> + '_ {
        marks.chunks_exact(2 * D).map(|mark| SVector::from_fn(|d, _| mark[d]))
    }

    fn look(&self, bodies: usize) -> Result<(), EffectMistake> {
        EffectMistake::unless_positive_or_zero("force", self.force)?;
        EffectMistake::unless_positive_or_zero("rotational diffusion", self.turning)?;
        EffectMistake::unless_for_each(self.headings.as_deref(), bodies)?;
        let mut numbers = self.headings.iter().flatten().flatten();
        numbers.try_for_each(|&x| EffectMistake::unless_finite("a component of a heading", x))
    }
}

/// The kind of effect of [`SelfPropulsion`].
#[derive(Debug, Clone, Copy)]
pub struct Propelled;

/// Self-propulsion, over a scalar.
#[derive(Debug, Clone)]
pub struct ActsBySelf<const D: usize>(SelfPropulsion<D>);

/// First headings are drawn at this place, beyond those of turns.
const FIRST: u64 = (1 << 24) - 1;

/// A heading as given has a part along the surface if that is more than this part of it.
const ALONG: f64 = 1e-8;

impl<const D: usize> Effect<D, Propelled> for SelfPropulsion<D> {
    type Acting<T: Real> = ActsBySelf<D>;
    fn acting<T: Real>(&self) -> ActsBySelf<D> {
        const { assert!(D == 2 || D == 3, "self-propulsion is for bodies in the plane or in space") };
        ActsBySelf(self.clone())
    }

    type Swept<S: Lane, const L: usize> = [ActsBySelf<D>; L];

    fn check(&self, what: &'static str, bodies: usize) -> Result<(), Error> {
        self.look(bodies).map_err(|mistake| Error::Effect { effect: what, mistake })
    }
}

impl<T: Real, const D: usize> Acting<T, D> for ActsBySelf<D> {
    type Room = ();
    const FLOWS: bool = true;
    const REMEMBERS: bool = true;
    const PUSHES: bool = true;
    fn room(&self, _: usize) {}

    fn marks(&self, bodies: usize) -> usize {
        2 * D * bodies
    }
    fn first_marks(&self, during: &Interval<'_, T, D>, marks: &mut [T]) -> Result<(), EffectMistake> {
        if during.surface.is_some() != (D == 3) {
            return Err(EffectMistake::NoSurface);
        }
        for (body, mark) in marks.chunks_exact_mut(2 * D).enumerate() {
            let normal = normal(during, body);
            let given = match &self.0.headings {
                Some(headings) => headings[body],
                None => Noise { place: FIRST, ..during.noise }.normal(self.0.seed, body),
            };
            let heading = given.map(|x| T::from_f64(x));
            let along = add_scaled(&heading, -dot(&normal, &heading), &normal);
            let length = dot(&along, &along).sqrt();
            if !(T::from_f64(ALONG) * dot(&heading, &heading).sqrt()).lt(length).all() {
                return Err(EffectMistake::NoHeading { body, heading: given.to_vec() });
            }
            write(mark, &scaled(T::from_f64(1.0) / length, &along), &normal);
        }
        Ok(())
    }
    fn take_note(&self, during: &Interval<'_, T, D>, marks: &mut [T]) {
        let angle = (2.0 * self.0.turning * during.h).sqrt();
        for (body, mark) in marks.chunks_exact_mut(2 * D).enumerate() {
            let normal = normal(during, body);
            let heading = carried(mark, &normal);
            let [noise, ..] = during.noise.normal::<1>(self.0.seed, body);
            let (sin, cos) = libm::sincos(angle * noise);
            let turned = sum(
                &scaled(T::from_f64(cos), &heading),
                &scaled(T::from_f64(sin), &aside(&normal, &heading)),
            );
            let along = add_scaled(&turned, -dot(&normal, &turned), &normal);
            write(mark, &scaled(T::from_f64(1.0) / dot(&along, &along).sqrt(), &along), &normal);
        }
    }

    fn parameters(&self) -> Vec<f64> {
        let [high, low] = halves(self.0.seed);
        vec![self.0.force, self.0.turning, high, low]
    }
    fn manner(&self) -> Manner {
        Manner { rule: Rule::Random, feels: false, pushes: true }
    }
    fn flow(&self, during: &Interval<'_, T, D>, (): &mut (), changes: &mut [[T; D]]) {
        let impulse = T::from_f64(self.0.force * during.h);
        let marks = during.marks.chunks_exact(2 * D);
        for (body, (change, mark)) in changes.iter_mut().zip(marks).enumerate() {
            *change = scaled(impulse, &carried(mark, &normal(during, body)));
        }
    }

    fn add_forces(&self, _: Moment<'_, T, D>, (): &mut (), _: &mut [[T; D]]) {}
    fn energy(&self, _: Moment<'_, T, D>) -> T {
        T::from_f64(0.0)
    }
}

/// The normal at the place of a body; zero where there is none.
fn normal<T: Real, const D: usize>(during: &Interval<'_, T, D>, body: usize) -> [T; D] {
    during.surface.map_or([T::from_f64(0.0); D], |surface| surface.normal(body))
}

/// What is remembered of a body: its heading, and the normal where it has been.
fn write<T: Real, const D: usize>(mark: &mut [T], heading: &[T; D], normal: &[T; D]) {
    let (first, second) = mark.split_at_mut(D);
    first.copy_from_slice(heading);
    second.copy_from_slice(normal);
}

/// The heading turned by the smallest rotation that takes the normal n where it has been to the normal n′ of now: u −
/// (n′·u)/(1 + n·n′) (n + n′).
fn carried<T: Real, const D: usize>(mark: &[T], normal: &[T; D]) -> [T; D] {
    let (heading, before): ([T; D], [T; D]) = (from_fn(|d| mark[d]), from_fn(|d| mark[D + d]));
    let part = dot(normal, &heading) / (T::from_f64(1.0) + dot(&before, normal));
    add_scaled(&heading, -part, &sum(&before, normal))
}

/// The heading turned by a right angle: n × u, or in the plane counterclockwise.
fn aside<T: Real, const D: usize>(n: &[T; D], u: &[T; D]) -> [T; D] {
    from_fn(|d| match D {
        2 => [-u[1], u[0]][d],
        _ => n[(d + 1) % 3] * u[(d + 2) % 3] - n[(d + 2) % 3] * u[(d + 1) % 3],
    })
}
