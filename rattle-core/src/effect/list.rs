//! A scene's effects are a list in its type: `()` is none, [`With`] adds one. The list without effects has a force of size
//! zero, so the force phase of a step vanishes when compiling.

use crate::effect::force::{Absent, Force};
use crate::effect::one::{Acting, Effect};
use crate::effect::swept::Swept;
use crate::kernel::over::short_name;
use crate::kernel::series::Order;
use crate::number::lanes::Lane;
use crate::number::real::Real;
use std::marker::PhantomData;

/// A list of effects, as users name them.
pub trait Effects<const D: usize> {
    /// The list, ready for the scalar `T`.
    type Field<T: Real>: Field<T, D>;
    /// The field with these effects' parameters.
    fn field<T: Real>(&self) -> Self::Field<T>;

    /// The list in L lanes, each with parameters of its own.
    type Swept<S: Lane, const L: usize>: Swept<S, D, Lane = Self::Field<S>>;
    /// Lane i with the parameters of `lane(i)`.
    fn swept<'a, S: Lane, const L: usize>(lane: impl Fn(usize) -> &'a Self) -> Self::Swept<S, L>
    where
        Self: 'a;

    /// The first effect that names a body beyond the last one, by the name of its type, its member and the body.
    fn stray(&self, _bodies: usize) -> Option<(&'static str, usize, usize)> {
        None
    }
}

/// All effects of a scene together, over the scalar `T`.
pub trait Field<T: Real, const D: usize>: Clone + Send + Sync + 'static {
    /// What is stored per body: `[T; D]`, or [`Absent`].
    type Force: Force<T, D>;

    /// Sets the force −∇ᵢU on every body i.
    fn evaluate(&self, positions: &[[T; D]], forces: &mut [Self::Force]);
    /// Adds −∇ᵢU to the force on every body i.
    fn contribute(&self, positions: &[[T; D]], forces: &mut [[T; D]]);
    /// p + c f, with the force f on a body that is the only one.
    fn kick(&self, q: &[T; D], c: T, p: [T; D]) -> [T; D];
    /// U, summed over the effects.
    fn energy(&self, positions: &[[T; D]]) -> T;
    /// The first effect whose force on `body` is not finite, by the name of its type, and that force.
    fn culprit(&self, positions: &[[T; D]], body: usize) -> Option<(&'static str, [T; D])>;

    /// Blocks of products that a coefficient of all forces takes; none if one has no power series.
    fn series_blocks(&self, bodies: usize) -> Option<usize>;
    /// Adds the next coefficient of −∇ᵢU along the motion, a power series in time, from that of the positions.
    fn contribute_series<const FIRST: bool>(
        &self,
        positions: &[[T; D]],
        forces: &mut [[T; D]],
        order: &mut Order<'_, T, FIRST>,
    );
}

/// The effects `E` and one more, `P`.
#[derive(Debug, Clone, Copy)]
pub struct With<E, P, Kind> {
    pub(crate) others: E,
    pub(crate) effect: P,
    pub(crate) kind: PhantomData<Kind>,
}

impl<const D: usize> Effects<D> for () {
    type Field<T: Real> = ();
    fn field<T: Real>(&self) {}

    type Swept<S: Lane, const L: usize> = ();
    fn swept<'a, S: Lane, const L: usize>(_: impl Fn(usize) -> &'a Self) {}
}

impl<T: Real, const D: usize> Field<T, D> for () {
    type Force = Absent;

    #[inline(always)]
    fn evaluate(&self, _: &[[T; D]], _: &mut [Absent]) {}
    #[inline(always)]
    fn contribute(&self, _: &[[T; D]], _: &mut [[T; D]]) {}
    #[inline(always)]
    fn kick(&self, _: &[T; D], _: T, p: [T; D]) -> [T; D] {
        p
    }
    fn energy(&self, _: &[[T; D]]) -> T {
        T::from_f64(0.0)
    }
    fn culprit(&self, _: &[[T; D]], _: usize) -> Option<(&'static str, [T; D])> {
        None
    }
    fn series_blocks(&self, _: usize) -> Option<usize> {
        Some(0)
    }
    #[inline(always)]
    fn contribute_series<const FIRST: bool>(
        &self,
        _: &[[T; D]],
        _: &mut [[T; D]],
        _: &mut Order<'_, T, FIRST>,
    ) {
    }
}

impl<E: Effects<D>, P: Effect<D, Kind>, Kind, const D: usize> Effects<D> for With<E, P, Kind> {
    type Field<T: Real> = Superposed<<P as Effect<D, Kind>>::Acting<T>, E::Field<T>>;

    fn field<T: Real>(&self) -> Self::Field<T> {
        Superposed { effect: self.effect.acting(), name: short_name::<P>(), others: self.others.field() }
    }

    type Swept<S: Lane, const L: usize> = Superposed<<P as Effect<D, Kind>>::Swept<S, L>, E::Swept<S, L>>;

    fn swept<'a, S: Lane, const L: usize>(lane: impl Fn(usize) -> &'a Self) -> Self::Swept<S, L>
    where
        Self: 'a,
    {
        let (effect, others) = (P::swept(|i| &lane(i).effect), E::swept(|i| &lane(i).others));
        Superposed { effect, name: short_name::<P>(), others }
    }

    fn stray(&self, bodies: usize) -> Option<(&'static str, usize, usize)> {
        let own = self.effect.stray(bodies).map(|(member, body)| (short_name::<P>(), member, body));
        self.others.stray(bodies).or(own)
    }
}

/// One effect on top of others.
#[derive(Debug, Clone)]
pub struct Superposed<A, F> {
    effect: A,
    name: &'static str,
    others: F,
}

impl<T: Real, A: Acting<T, D>, F: Field<T, D>, const D: usize> Field<T, D> for Superposed<A, F> {
    type Force = [T; D];

    #[inline(always)]
    fn evaluate(&self, positions: &[[T; D]], forces: &mut [[T; D]]) {
        forces.fill(Force::zero());
        self.contribute(positions, forces);
    }
    #[inline(always)]
    fn contribute(&self, positions: &[[T; D]], forces: &mut [[T; D]]) {
        self.others.contribute(positions, forces);
        self.effect.add_forces(positions, forces);
    }
    #[inline(always)]
    fn kick(&self, q: &[T; D], c: T, p: [T; D]) -> [T; D] {
        self.effect.kick(q, c, self.others.kick(q, c, p))
    }
    fn energy(&self, positions: &[[T; D]]) -> T {
        self.others.energy(positions) + self.effect.energy(positions)
    }
    fn culprit(&self, positions: &[[T; D]], body: usize) -> Option<(&'static str, [T; D])> {
        self.others.culprit(positions, body).or_else(|| {
            let mut forces = vec![Force::zero(); positions.len()];
            self.effect.add_forces(positions, &mut forces);
            let force = forces[body];
            let finite = force.iter().all(|f| f.lanes().all(f64::is_finite));
            (!finite).then_some((self.name, force))
        })
    }
    fn series_blocks(&self, bodies: usize) -> Option<usize> {
        Some(self.others.series_blocks(bodies)? + self.effect.series_blocks(bodies)?)
    }
    #[inline(always)]
    fn contribute_series<const FIRST: bool>(
        &self,
        positions: &[[T; D]],
        forces: &mut [[T; D]],
        order: &mut Order<'_, T, FIRST>,
    ) {
        self.others.contribute_series(positions, forces, order);
        self.effect.add_series(positions, forces, order);
    }
}

impl<S: Lane, const D: usize> Swept<S, D> for () {
    type Lane = ();

    #[inline(always)]
    fn lane(&self, _: usize) {}
    #[inline(always)]
    fn kick(&self, _: usize, _: &[S; D], _: S, p: [S; D]) -> [S; D] {
        p
    }
    fn copy(&mut self, _: usize, _: usize) {}
}

impl<S: Lane, A: Swept<S, D>, F: Swept<S, D>, const D: usize> Swept<S, D> for Superposed<A, F> {
    type Lane = Superposed<A::Lane, F::Lane>;

    #[inline(always)]
    fn lane(&self, lane: usize) -> Self::Lane {
        Superposed { effect: self.effect.lane(lane), name: self.name, others: self.others.lane(lane) }
    }
    #[inline(always)]
    fn kick(&self, lane: usize, q: &[S; D], c: S, p: [S; D]) -> [S; D] {
        self.effect.kick(lane, q, c, self.others.kick(lane, q, c, p))
    }
    fn copy(&mut self, from: usize, to: usize) {
        self.effect.copy(from, to);
        self.others.copy(from, to);
    }
}
