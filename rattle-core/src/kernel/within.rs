//! A pair potential as far as a distance, and nothing beyond: U ends by a switch, or less what it is there.
//!
//! Sources: M. P. Allen, D. J. Tildesley, *Computer Simulation of Liquids*, 2nd ed. (2017), 1.6.3 and 5.3; S. Toxvaerd,
//! J. C. Dyre (2011) for the potential less its tangent; L. Verlet (1967) for lists.

use crate::kernel::space::{Open, Periodic};

/// A pair potential U between bodies nearer than `reach`, and nothing beyond: made by
/// [`PairPotential::within`](crate::kernel::PairPotential::within).
///
/// **How it ends.** A symplectic method keeps energy without drift where forces are smooth. 120 atoms of Lennard-Jones
/// on a gyroid, of a kinetic energy of 120 ε, reach 2.5 σ, steps of 0.005 σ √(m/ε); energy errors in ε, means over the
/// last 5 000 of so many steps (`cargo test --test motion near_pairs:: -- --ignored --nocapture`):
///
/// | ending | 25 000 | 50 000 | 75 000 | 100 000 steps |
/// |---|---|---|---|---|
/// | [`shifted`](Self::shifted): the force jumps | −0.190 | −0.196 | −0.184 | −0.167 |
/// | [`force_shifted`](Self::force_shifted) | −0.171 | −0.171 | −0.170 | −0.170 |
/// | [`switched`](Self::switched) from 0.95 of the reach | −0.174 | −0.176 | −0.175 | −0.170 |
/// | from 0.9, which is the default | −0.171 | −0.171 | −0.172 | −0.172 |
/// | from 0.7 | −0.172 | −0.171 | −0.172 | −0.170 |
///
/// All have the error of the method, of second order; the energy of the potential that is only shifted wanders by a
/// tenth of it besides. A switch leaves U as it is up to where it begins, which is why it is the default; a potential
/// that is zero at its reach by itself, such as `Wca`, wants `.shifted()`.
///
/// **What a step costs**: as many operations as there are near pairs. The list of them is made before the first step,
/// with room for half as many more; steps do not allocate until bodies crowd beyond that. Where more than a fourth of
/// all pairs are near there is no list. Forces are sums over partners in the order of their numbers: those of a loop
/// over all pairs to the bit, whatever the skin. Positions that are not finite give forces that are no numbers. An
/// energy that is asked for makes a list of its own, and allocates. There are no power series (`Taylor`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Within<P, B = Open> {
    pub(crate) potential: P,
    pub(crate) reach: f64,
    pub(crate) ending: Ending,
    pub(crate) skin: f64,
    pub(crate) space: B,
}

/// A pair potential by the distance between bodies along the surface g = 0 that they are on: made by [`Within::along`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Along<P, C, B = Open> {
    pub(crate) within: Within<P, B>,
    pub(crate) surface: C,
}

/// A pair potential by the length of the geodesic between bodies on the surface g = 0: made by
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

impl<P> Within<P> {
    pub(crate) fn new(potential: P, reach: f64) -> Self {
        let ending = Ending::Switched { from: FROM * reach };
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
    /// The force and its slope are continuous. If nothing is said, `from` is 0.9 of the reach.
    #[must_use]
    pub fn switched(self, from: f64) -> Self {
        Self { ending: Ending::Switched { from }, ..self }
    }

    /// The potential less what it is at the reach, U(r) − U(reach): forces within are those of U. The energy is
    /// continuous, the force jumps at the reach.
    #[must_use]
    pub fn shifted(self) -> Self {
        Self { ending: Ending::Shifted, ..self }
    }

    /// The potential less its tangent at the reach, U(r) − U(reach) − (r − reach) U′(reach): energy and force are
    /// continuous, and the force is everywhere less by that at the reach.
    #[must_use]
    pub fn force_shifted(self) -> Self {
        Self { ending: Ending::ForceShifted, ..self }
    }

    /// The list of pairs holds those nearer than reach + `skin`, a length, and is made anew once a body has moved by
    /// half of the skin: a thick one is made seldom, a thin one holds few pairs. It changes the time that a step takes,
    /// and not a bit of the forces. If nothing is said, 0.3 of the reach.
    #[must_use]
    pub fn skin(self, skin: f64) -> Self {
        Self { skin, ..self }
    }

    /// The same in a box that repeats itself after these lengths; `f64::INFINITY` where it does not. Bodies act on the
    /// nearest image of others, so that the reach is half of a length at most. Positions stay as they are, and may be
    /// any number of periods away.
    #[must_use]
    pub fn periodic<const D: usize>(self, periods: [f64; D]) -> Within<P, Periodic<D>> {
        let Self { potential, reach, ending, skin, .. } = self;
        Within { potential, reach, ending, skin, space: Periodic::new(periods) }
    }

    /// The same by distances along this surface of one equation, on which the bodies are, instead of straight ones: to
    /// the next order in the curvature, see [`effect::along`](crate::effect::along), which serves as long as the reach
    /// is less than about a third of the radii of curvature. Who is near through space and far along the surface still
    /// acts: other parts of the surface must be farther than the reach.
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

    /// The same by the exact length of the geodesic between bodies, to rounding, for any reach below the surface's
    /// injectivity radius (see `curvature::geodesic_distance`); each pair within reach takes
    /// 30 µs. Where no geodesic is found, as between parts of the surface that are near through space alone, the
    /// force is no number, and the step or the start is refused.
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
