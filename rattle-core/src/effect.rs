//! Effects: what acts on the bodies besides the constraint. What a scene does not name costs nothing.
//!
//! A scene's effects are a list in its type: `()` is none, [`With`] adds one. The list without
//! effects has a force of size zero, so the steppers' force phase vanishes when compiling.

mod swept;

pub use swept::{OnEachLane, Swept};

#[cfg(doc)]
use crate::ensemble::InstructionSet;
use crate::kernel::{PairKernel, PairPotential, Potential, PotentialKernel};
use crate::lanes::{Fused, Lane};
use crate::pairs;
use crate::real::Real;
use crate::series::{Order, blocks};
use crate::vector::{add_scaled, dot, sum};
use std::any::type_name;
use std::array::from_fn;
use std::fmt::Debug;
use std::marker::PhantomData;

/// The force on one body, or its absence.
pub trait Force<T: Real, const D: usize>: Copy + Debug + Send + Sync + 'static {
    /// Whether there can be one.
    const ACTS: bool = true;

    /// No force.
    fn zero() -> Self;
    /// a + c f; `a` itself where forces are absent.
    fn add_to(&self, a: [T; D], c: T) -> [T; D];
    /// c f·n; zero where forces are absent.
    fn dot(&self, n: &[T; D], c: T) -> T;
    /// |c f|²; zero where forces are absent.
    fn square(&self, c: T) -> T;
    /// The components; zeros where forces are absent.
    fn components(&self) -> [T; D];
}

/// The force in a scene without effects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Absent;

impl<T: Real, const D: usize> Force<T, D> for Absent {
    const ACTS: bool = false;

    #[inline(always)]
    fn zero() -> Self {
        Self
    }
    #[inline(always)]
    fn add_to(&self, a: [T; D], _: T) -> [T; D] {
        a
    }
    #[inline(always)]
    fn dot(&self, _: &[T; D], _: T) -> T {
        T::from_f64(-0.0) // x + (−0) is x, bit for bit, also for the compiler
    }
    #[inline(always)]
    fn square(&self, _: T) -> T {
        T::from_f64(-0.0)
    }
    #[inline(always)]
    fn components(&self) -> [T; D] {
        [T::from_f64(0.0); D]
    }
}

impl<T: Real, const D: usize> Force<T, D> for [T; D] {
    #[inline(always)]
    fn zero() -> Self {
        [T::from_f64(-0.0); D]
    }
    #[inline(always)]
    fn add_to(&self, a: [T; D], c: T) -> [T; D] {
        add_scaled(&a, c, self)
    }
    #[inline(always)]
    fn dot(&self, n: &[T; D], c: T) -> T {
        c * dot(self, n)
    }
    #[inline(always)]
    fn square(&self, c: T) -> T {
        c * c * dot(self, self)
    }
    #[inline(always)]
    fn components(&self) -> [T; D] {
        *self
    }
}

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

/// The name of a type without paths; of a potential over bodies, that of the potential.
pub(crate) fn short_name<P>() -> &'static str {
    let name = type_name::<P>();
    let name = name.split_once("effect::Over<").map_or(name, |(_, potential)| potential);
    let name = name.split(',').next().unwrap_or(name);
    name.split('<').next().and_then(|path| path.rsplit("::").next()).unwrap_or(name)
}

/// What a scene takes in `with`. The kind ([`OnEach`] or [`BetweenPairs`]) is found by inference:
/// every [`Potential`] acts on each body, every [`PairPotential`] between every two.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no effect on bodies with {D} coordinates",
    note = "an effect is made by `potential!` with {D} variables, by `pair_potential!`, or from a potential of several bodies by `.over(members)`"
)]
pub trait Effect<const D: usize, Kind> {
    /// The effect over the scalar `T`.
    type Acting<T: Real>: Acting<T, D>;
    /// The effect with this value's parameters.
    fn acting<T: Real>(&self) -> Self::Acting<T>;

    /// The effect in L lanes, each with parameters of its own.
    type Swept<S: Lane, const L: usize>: Swept<S, D, Lane = Self::Acting<S>>;
    /// Lane i with the parameters of `lane(i)`.
    fn swept<'a, S: Lane, const L: usize>(lane: impl Fn(usize) -> &'a Self) -> Self::Swept<S, L>
    where
        Self: 'a;

    /// The first member that names a body beyond the last one, and that body.
    fn stray(&self, _bodies: usize) -> Option<(usize, usize)> {
        None
    }
}

/// One effect over the scalar `T`.
pub trait Acting<T: Real, const D: usize>: Clone + Send + Sync + 'static {
    /// Adds −∇ᵢU to the force on every body i.
    fn add_forces(&self, positions: &[[T; D]], forces: &mut [[T; D]]);
    /// p − c ∇U, for a body that is the only one.
    #[inline(always)]
    fn kick(&self, q: &[T; D], c: T, p: [T; D]) -> [T; D] {
        let mut force = [Force::zero()];
        self.add_forces(&[*q], &mut force);
        add_scaled(&p, c, &force[0])
    }
    /// U.
    fn energy(&self, positions: &[[T; D]]) -> T;

    /// Blocks of products that a coefficient of the forces takes; none if they have no power series.
    fn series_blocks(&self, _bodies: usize) -> Option<usize> {
        None
    }
    /// Adds the next coefficient of −∇ᵢU along the motion, a power series in time, from that of the positions. Not called
    /// where there is none.
    fn add_series<const FIRST: bool>(
        &self,
        _positions: &[[T; D]],
        _forces: &mut [[T; D]],
        _order: &mut Order<'_, T, FIRST>,
    ) {
    }
}

/// A potential that acts on each body by itself.
#[derive(Debug, Clone, Copy)]
pub struct OnEach<K>(K);

impl<P: Potential<D>, const D: usize> Effect<D, OnEach<()>> for P {
    type Acting<T: Real> = OnEach<P::Kernel<T>>;
    fn acting<T: Real>(&self) -> Self::Acting<T> {
        OnEach(self.kernel())
    }

    type Swept<S: Lane, const L: usize> = OnEachLane<P, S, L, D>;
    fn swept<'a, S: Lane, const L: usize>(lane: impl Fn(usize) -> &'a Self) -> Self::Swept<S, L>
    where
        Self: 'a,
    {
        OnEachLane::new(lane)
    }
}

impl<T: Real, K: PotentialKernel<T, D>, const D: usize> Acting<T, D> for OnEach<K> {
    #[inline(always)]
    fn add_forces(&self, positions: &[[T; D]], forces: &mut [[T; D]]) {
        for (q, force) in positions.iter().zip(forces) {
            *force = add_scaled(force, T::from_f64(-1.0), &self.0.gradient(q));
        }
    }
    #[inline(always)]
    fn kick(&self, q: &[T; D], c: T, p: [T; D]) -> [T; D] {
        let gradient = self.0.gradient(q);
        let along = self.0.acts_along();
        from_fn(|d| if along[d] { (-c).multiply_add(gradient[d], p[d]) } else { p[d] })
    }
    fn energy(&self, positions: &[[T; D]]) -> T {
        positions.iter().fold(T::from_f64(-0.0), |energy, q| energy + self.0.value(q))
    }
    fn series_blocks(&self, bodies: usize) -> Option<usize> {
        Some(bodies * self.0.series()?)
    }
    #[inline(always)]
    fn add_series<const FIRST: bool>(
        &self,
        positions: &[[T; D]],
        forces: &mut [[T; D]],
        order: &mut Order<'_, T, FIRST>,
    ) {
        for (q, force) in positions.iter().zip(forces) {
            *force = add_scaled(force, T::from_f64(-1.0), &self.0.gradient_series(q, order));
        }
    }
}

/// A potential between every two bodies.
///
/// Doubles go [several pairs at a time](InstructionSet), with [functions](crate::lanes) of their own, where there are some bodies and
/// the processor has fused multiply-add. Forces then differ by rounding from those of few bodies, or of a processor without it.
#[derive(Debug, Clone, Copy)]
pub struct BetweenPairs<K, L = K> {
    kernel: K,
    in_lanes: L,
}

impl<P: PairPotential, const D: usize> Effect<D, BetweenPairs<()>> for P {
    type Acting<T: Real> = BetweenPairs<P::Kernel<T>, P::Kernel<Fused<f64>>>;
    fn acting<T: Real>(&self) -> Self::Acting<T> {
        BetweenPairs { kernel: self.kernel(), in_lanes: self.kernel() }
    }

    type Swept<S: Lane, const L: usize> = [Self::Acting<S>; L];
    fn swept<'a, S: Lane, const L: usize>(lane: impl Fn(usize) -> &'a Self) -> Self::Swept<S, L>
    where
        Self: 'a,
    {
        from_fn(|i| Effect::<D, BetweenPairs<()>>::acting(lane(i)))
    }
}

impl<T: Real, K: PairKernel<T>, L: PairKernel<Fused<f64>>, const D: usize> Acting<T, D>
    for BetweenPairs<K, L>
{
    #[inline(always)]
    fn add_forces(&self, positions: &[[T; D]], forces: &mut [[T; D]]) {
        if positions.len() >= pairs::MANY
            && let (Some(positions), Some(forces)) = (T::doubles(positions), T::doubles_mut(forces))
            && pairs::add_forces(&self.in_lanes, positions, forces)
        {
            return;
        }
        for i in 1..positions.len() {
            let mut on_i = forces[i];
            for j in 0..i {
                let apart = add_scaled(&positions[i], T::from_f64(-1.0), &positions[j]);
                let pull = T::from_f64(-2.0) * self.kernel.slope(dot(&apart, &apart)); // −U′(r)/r
                on_i = add_scaled(&on_i, pull, &apart);
                forces[j] = add_scaled(&forces[j], -pull, &apart);
            }
            forces[i] = on_i;
        }
    }
    fn energy(&self, positions: &[[T; D]]) -> T {
        let mut energy = T::from_f64(-0.0);
        for i in 1..positions.len() {
            for j in 0..i {
                let apart = add_scaled(&positions[i], T::from_f64(-1.0), &positions[j]);
                energy = energy + self.kernel.value(dot(&apart, &apart));
            }
        }
        energy
    }
    fn series_blocks(&self, bodies: usize) -> Option<usize> {
        Some(bodies * bodies.saturating_sub(1) / 2 * (blocks(2 * D) + self.kernel.series()?))
    }
    fn add_series<const FIRST: bool>(
        &self,
        positions: &[[T; D]],
        forces: &mut [[T; D]],
        order: &mut Order<'_, T, FIRST>,
    ) {
        for i in 1..positions.len() {
            for j in 0..i {
                let apart = add_scaled(&positions[i], T::from_f64(-1.0), &positions[j]);
                let mut own = order.take(blocks(2 * D));
                let squares = (0..D).map(|d| own.square(d, apart[d]));
                let s = squares.fold(T::from_f64(0.0), |sum, square| sum + square);
                let slope = self.kernel.slope_series(s, order);
                let pull: [T; D] = from_fn(|d| T::from_f64(-2.0) * own.product(D + d, apart[d], slope));
                forces[i] = sum(&forces[i], &pull);
                forces[j] = add_scaled(&forces[j], T::from_f64(-1.0), &pull);
            }
        }
    }
}

/// A potential on chosen bodies, A at a time: its variables are the coordinates of a member's bodies in turn. Made by
/// [`Potential::over`].
///
/// ```text
/// scene.with(Spring { stiffness: 9.0, length: 1.0 }.over([[0, 1], [1, 2]]))      // |a: [f64; 3], b: [f64; 3]| …
/// scene.with(Over::each(masses.iter().enumerate().map(|(i, m)| (Gravity { g: 9.81 * m }, [i]))))
/// ```
#[derive(Debug, Clone)]
pub struct Over<P, const A: usize> {
    /// One for all members, or one for each.
    potentials: Vec<P>,
    members: Vec<[usize; A]>,
}

impl<P, const A: usize> Over<P, A> {
    /// The same potential over these members.
    pub fn new(potential: P, members: impl IntoIterator<Item = [usize; A]>) -> Self {
        Self { potentials: vec![potential], members: members.into_iter().collect() }
    }

    /// Each member with a potential of its own.
    pub fn each(pairs: impl IntoIterator<Item = (P, [usize; A])>) -> Self {
        let (potentials, members) = pairs.into_iter().unzip();
        Self { potentials, members }
    }
}

/// A potential of K = A·D variables over members of A bodies.
#[derive(Debug, Clone)]
pub struct Among<X, const K: usize, const A: usize> {
    kernels: Vec<X>,
    members: Vec<[usize; A]>,
}

impl<P: Potential<K>, const D: usize, const K: usize, const A: usize> Effect<D, Among<(), K, A>>
    for Over<P, A>
{
    type Acting<T: Real> = Among<P::Kernel<T>, K, A>;

    fn acting<T: Real>(&self) -> Self::Acting<T> {
        const {
            assert!(
                K == A * D,
                "a potential over A bodies has A times as many variables as a body coordinates"
            )
        };
        Among { kernels: self.potentials.iter().map(P::kernel).collect(), members: self.members.clone() }
    }

    type Swept<S: Lane, const L: usize> = [Self::Acting<S>; L];
    fn swept<'a, S: Lane, const L: usize>(lane: impl Fn(usize) -> &'a Self) -> Self::Swept<S, L>
    where
        Self: 'a,
    {
        from_fn(|i| Effect::<D, Among<(), K, A>>::acting(lane(i)))
    }

    fn stray(&self, bodies: usize) -> Option<(usize, usize)> {
        let mut strays = self.members.iter().enumerate();
        strays.find_map(|(i, member)| member.iter().find(|&&body| body >= bodies).map(|&body| (i, body)))
    }
}

impl<X, const K: usize, const A: usize> Among<X, K, A> {
    #[inline(always)]
    fn kernel(&self, member: usize) -> &X {
        &self.kernels[if self.kernels.len() == 1 { 0 } else { member }]
    }

    /// Each member's kernel and bodies, and its variables.
    #[inline(always)]
    fn each<'a, T: Real, const D: usize>(
        &'a self,
        positions: &'a [[T; D]],
    ) -> impl Iterator<Item = (&'a X, &'a [usize; A], [T; K])> + 'a {
        self.members
            .iter()
            .enumerate()
            .map(|(i, member)| (self.kernel(i), member, from_fn(|k| positions[member[k / D]][k % D])))
    }
}

impl<T: Real, X: PotentialKernel<T, K>, const D: usize, const K: usize, const A: usize> Acting<T, D>
    for Among<X, K, A>
{
    fn add_forces(&self, positions: &[[T; D]], forces: &mut [[T; D]]) {
        for (kernel, member, variables) in self.each(positions) {
            let gradient = kernel.gradient(&variables);
            for (a, &body) in member.iter().enumerate() {
                forces[body] = from_fn(|d| forces[body][d] - gradient[a * D + d]);
            }
        }
    }
    fn energy(&self, positions: &[[T; D]]) -> T {
        let energies = self.each(positions).map(|(kernel, _, variables)| kernel.value(&variables));
        energies.fold(T::from_f64(-0.0), |sum, energy| sum + energy)
    }
    fn series_blocks(&self, _: usize) -> Option<usize> {
        (0..self.members.len()).map(|member| self.kernel(member).series()).sum()
    }
    fn add_series<const FIRST: bool>(
        &self,
        positions: &[[T; D]],
        forces: &mut [[T; D]],
        order: &mut Order<'_, T, FIRST>,
    ) {
        for (kernel, member, variables) in self.each(positions) {
            let gradient = kernel.gradient_series(&variables, order);
            for (a, &body) in member.iter().enumerate() {
                forces[body] = from_fn(|d| forces[body][d] - gradient[a * D + d]);
            }
        }
    }
}
