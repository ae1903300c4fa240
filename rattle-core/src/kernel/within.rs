//! Pair potentials with a cut-off: U is switched off smoothly, or shifted to zero.
//!
//! Sources: M. P. Allen, D. J. Tildesley, *Computer Simulation of Liquids*, 2nd ed. (2017), 1.6.3 and 5.3; S. Toxvaerd,
//! J. C. Dyre (2011) for shifted forces; L. Verlet (1967) for lists.

use crate::kernel::space::{Open, Periodic};

/// A pair potential U with the cut-off distance `reach`, zero beyond it: made by
/// [`PairPotential::within`](crate::kernel::PairPotential::within).
///
/// **The cut-off.** A symplectic method conserves energy without drift where forces are smooth. The table shows the
/// energy errors in ε of 120 Lennard-Jones atoms on a gyroid, with a kinetic energy of 120 ε, reach 2.5 σ and steps of
/// 0.005 σ √(m/ε), as means over the last 5 000 of the given number of steps
/// (`cargo long --test motion near_pairs:: -- --ignored --nocapture`):
///
/// | ending | 25 000 | 50 000 | 75 000 | 100 000 steps |
/// |---|---|---|---|---|
/// | [`shifted`](Self::shifted): the force jumps | −0.190 | −0.196 | −0.184 | −0.167 |
/// | [`force_shifted`](Self::force_shifted) | −0.171 | −0.171 | −0.170 | −0.170 |
/// | [`switched`](Self::switched) from 0.95 of the reach | −0.174 | −0.176 | −0.175 | −0.170 |
/// | from 0.9, which is the default | −0.171 | −0.171 | −0.172 | −0.172 |
/// | from 0.7 | −0.172 | −0.171 | −0.172 | −0.170 |
///
/// All have the second-order error of the method; with `shifted` the energy also wanders by a tenth of that error. The
/// switch is the default since it does not change U at distances below its beginning. A potential that ends by itself
/// at the reach or before, with its slope, as `Wca` does, gets no switch and is not changed.
///
/// **The cost of a step** is proportional to the number of near pairs. Their list is made before the first step, with
/// memory for a third as many more; steps do not allocate unless bodies crowd beyond that. Where more than a fourth of
/// all pairs are near, there is no list. Forces are summed over partners in the order of their numbers, so they are bit
/// for bit those of a loop over all pairs, whatever the skin. Positions that are not finite give forces of NaN.
/// Evaluating the energy makes a list of its own, and allocates. There are no power series, so `Taylor` is refused.
#[doc(alias = "cutoff")]
#[doc(alias = "cut-off")]
#[doc(alias = "neighbour list")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Within<P, B = Open> {
    pub(crate) potential: P,
    pub(crate) reach: f64,
    pub(crate) ending: Ending,
    pub(crate) skin: f64,
    pub(crate) space: B,
}

/// A pair potential of the distance between bodies along the surface g = 0 on which they move: made by
/// [`Within::along`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Along<P, C, B = Open> {
    pub(crate) within: Within<P, B>,
    pub(crate) surface: C,
}

/// A pair potential of the length of the geodesic between bodies on the surface g = 0: made by
/// [`Within::along_geodesics`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlongGeodesics<P, C, B = Open> {
    pub(crate) within: Within<P, B>,
    pub(crate) surface: C,
}

/// How a potential ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Ending {
    /// U(r) − U(reach).
    Shifted,
    /// U(r) − U(reach) − (r − reach) U′(reach).
    ForceShifted,
    /// U(r) S(r), where S falls from 1 at this distance to 0 at the reach.
    Switched { from: f64 },
}

/// The part of the reach from which a potential is switched off if nothing else is said.
const FROM: f64 = 0.9;
/// The skin as a part of the reach if nothing else is said.
const SKIN: f64 = 0.3;

/// A potential whose value and slope at the reach are this part of those from where a switch would begin ends there by
/// itself.
const ENDS: f64 = 1e-9;

impl<P> Within<P> {
    /// With what tells U and U′ at a distance.
    pub(crate) fn new(potential: P, reach: f64, tell: impl Fn(&P, f64) -> [f64; 2]) -> Self {
        let from = FROM * reach;
        let [at, before] = [reach, from].map(|r| tell(&potential, r));
        let ends = (0..2).all(|i| at[i].abs() <= ENDS * before[i].abs());
        let ending = if ends { Ending::Shifted } else { Ending::Switched { from } };
        Self { potential, reach, ending, skin: SKIN * reach, space: Open }
    }
}

impl<P, B> Within<P, B> {
    /// The potential switched off between `from` and the reach: U(r) S(r), with
    ///
    /// ```text
    /// S = 1 − 10x³ + 15x⁴ − 6x⁵        x = (r² − from²)/(reach² − from²), at least 0
    /// ```
    ///
    /// The force and its derivative are continuous. By default `from` is 0.9 of the reach, and a potential that ends by
    /// itself has no switch.
    #[must_use]
    pub fn switched(self, from: f64) -> Self {
        Self { ending: Ending::Switched { from }, ..self }
    }

    /// The potential minus its value at the reach, U(r) − U(reach). Forces within are those of U. The energy is
    /// continuous, the force jumps at the reach.
    #[must_use]
    pub fn shifted(self) -> Self {
        Self { ending: Ending::Shifted, ..self }
    }

    /// The potential minus its tangent at the reach, U(r) − U(reach) − (r − reach) U′(reach). Energy and force are
    /// continuous; the force at the reach is subtracted everywhere.
    #[must_use]
    pub fn force_shifted(self) -> Self {
        Self { ending: Ending::ForceShifted, ..self }
    }

    /// Sets the skin of the list of pairs, a length. The list holds all pairs nearer than reach + `skin`, and is made
    /// again once a body has moved by half of the skin: with a thick skin it is made seldom, with a thin one it holds
    /// few pairs. The skin changes only the time of a step, not a bit of the forces. By default it is 0.3 of the reach.
    #[doc(alias = "neighbour list")]
    #[must_use]
    pub fn skin(self, skin: f64) -> Self {
        Self { skin, ..self }
    }

    /// The same in a periodic box with these lengths; `f64::INFINITY` for a coordinate that is not periodic. Bodies act
    /// on the nearest images of others, so the reach may be at most half of a length. Positions are not wrapped: they
    /// may be any number of periods away.
    #[doc(alias = "periodic boundary conditions")]
    #[doc(alias = "minimum image")]
    #[must_use]
    pub fn periodic<const D: usize>(self, periods: [f64; D]) -> Within<P, Periodic<D>> {
        let Self { potential, reach, ending, skin, .. } = self;
        Within { potential, reach, ending, skin, space: Periodic::new(periods) }
    }

    /// The same with distances along the surface on which the bodies move, instead of straight ones. Distances are
    /// computed to the next order in the curvature, see [`effect::along`](crate::effect::along): use this for a reach
    /// below about a third of the radii of curvature. Bodies that are near through space but far along the surface
    /// still interact, so other parts of the surface must be farther away than the reach. A start is refused where
    /// bodies are not along the surface: on its g = 0, or on one other level of g that is the surface of the scene. In
    /// a scene with masses, pins or links, where bodies may be on several surfaces, it is asked for alone that near
    /// bodies are on one level. In a periodic box the surface repeats itself after each period, or the start is
    /// refused, too.
    ///
    /// ```
    /// use rattle::potentials::LennardJones;
    /// use rattle::prelude::*;
    /// use rattle::surfaces::Sphere;
    ///
    /// let sphere = Sphere { r: 10.0 };
    /// let gas = Scene::on(sphere).bodies(2).with(LennardJones { epsilon: 1.0, sigma: 1.0 }.within(2.5).along(sphere));
    /// let (a, d) = (0.15_f64, 1.5); // an angle of 0.15, a way of 1.5, a chord of 1.4986
    /// let start = State::of([[0.0, 0.0, 10.0], [10.0 * a.sin(), 0.0, 10.0 * a.cos()]]);
    /// let simulation = gas.simulate(start, Rattle::new(1e-3))?;
    /// assert!((simulation.energy() - LennardJones { epsilon: 1.0, sigma: 1.0 }.value(d)).abs() < 1e-5);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    #[must_use]
    pub fn along<C>(self, surface: C) -> Along<P, C, B> {
        Along { within: self, surface }
    }

    /// The same with the exact lengths of geodesics between bodies, to rounding, for any reach up to half the
    /// injectivity radius of the surface (on a sphere, 0.8 of it). Beyond that a longer geodesic may be found than the
    /// shortest, and the pair be taken for one out of reach (see `curvature::geodesic_distance`). Each pair within
    /// reach takes 30 µs. Where no geodesic is found, as between parts of the surface that are near only through space,
    /// the force is NaN, and the step or the start is refused; a start also where bodies are not along the surface, as
    /// for [`along`](Self::along).
    ///
    /// ```
    /// use rattle::potentials::LennardJones;
    /// use rattle::prelude::*;
    /// use rattle::surfaces::Sphere;
    ///
    /// let (sphere, lj) = (Sphere { r: 1.0 }, LennardJones { epsilon: 1.0, sigma: 1.0 });
    /// let gas = Scene::on(sphere).bodies(2).with(lj.within(2.5).shifted().along_geodesics(sphere));
    /// let d = 1.5_f64; // a way of 1.5, a chord of 1.36
    /// let start = State::of([[0.0, 0.0, 1.0], [d.sin(), 0.0, d.cos()]]);
    /// let simulation = gas.simulate(start, Rattle::new(1e-3))?;
    /// assert!((simulation.energy() - (lj.value(d) - lj.value(2.5))).abs() < 1e-13);
    /// # Ok::<(), rattle::Error>(())
    /// ```
    #[must_use]
    pub fn along_geodesics<C>(self, surface: C) -> AlongGeodesics<P, C, B> {
        AlongGeodesics { within: self, surface }
    }
}
