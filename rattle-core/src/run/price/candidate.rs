//! The methods whose cost is measured.

use crate::effect::list::Effects;
use crate::error::Error;
use crate::methods::composition::{
    Coefficients, Composition, KAHAN_LI_1997_ORDER_6, KAHAN_LI_1997_ORDER_8,
    SOFRONIOU_SPALETTA_2005_ORDER_10, SUZUKI_1990_ORDER_4,
};
use crate::methods::dop853::Dop853;
use crate::methods::lobatto::Lobatto;
use crate::methods::rattle::Rattle;
use crate::methods::taylor::Taylor;
use crate::motion::bodies::Count;
use crate::motion::guess::Extrapolated;
use crate::motion::hold::Hold;
use crate::motion::iteration::Broyden;
use crate::motion::state::State;
use crate::run::boxed::BoxedSimulation;
use crate::scene::Scene;
use std::fmt;

/// The order of Taylor's method where it is priced.
pub(super) const TAYLOR: u32 = 18;
/// A step of a method with a tolerance may lead too far to be trusted where the pilot did not show it: in the whole run
/// it is then made in parts, halved at most so often.
pub(super) const HALVINGS: u32 = 6;

/// A method whose cost is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Candidate {
    /// `Rattle::new(h)`.
    Rattle,
    /// `Rattle::new(h).guess(Extrapolated).solved_by(Broyden)`.
    RattleByBroyden,
    /// `Composition::new(coefficients, h)`.
    Composition(Coefficients),
    /// `Lobatto::<3>::new(h).guess(Extrapolated)`.
    Lobatto3,
    /// `Lobatto::<5>::new(h).guess(Extrapolated)`.
    Lobatto5,
    /// `Lobatto::<8>::new(h).guess(Extrapolated)`.
    Lobatto8,
    /// `Taylor::adaptive(18, h, tolerance)`; a planned run with `.retry(6)`.
    Taylor,
    /// `Dop853::adaptive(h, tolerance)`; a planned run with `.retry(6)`.
    Dop853,
    /// One of the others, trajectories side by side: `scene.ensemble_in(numbers, starts, …)`.
    /// See [`Pricing::side_by_side`](crate::run::price::Pricing::side_by_side).
    InLanes(&'static Candidate, Numbers),
}

/// The numbers that trajectories in lanes are computed with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Numbers {
    /// [`Single`](crate::run::ensemble::Single).
    Single,
    /// [`Double`](crate::run::ensemble::Double).
    Double,
    /// [`Compensated`](crate::run::ensemble::Compensated).
    Compensated,
}

impl Candidate {
    /// All that move one simulation: the cheapest step first.
    pub const ALL: [Self; 11] = [
        Self::Rattle,
        Self::RattleByBroyden,
        Self::Composition(SUZUKI_1990_ORDER_4),
        Self::Composition(KAHAN_LI_1997_ORDER_6),
        Self::Composition(KAHAN_LI_1997_ORDER_8),
        Self::Composition(SOFRONIOU_SPALETTA_2005_ORDER_10),
        Self::Lobatto3,
        Self::Lobatto5,
        Self::Lobatto8,
        Self::Dop853,
        Self::Taylor,
    ];

    /// Those that are priced side by side.
    pub const LANES: [Self; 12] = [
        Self::InLanes(&Self::Rattle, Numbers::Single),
        Self::InLanes(&Self::Rattle, Numbers::Double),
        Self::InLanes(&Self::Rattle, Numbers::Compensated),
        Self::InLanes(&Self::Composition(SUZUKI_1990_ORDER_4), Numbers::Double),
        Self::InLanes(&Self::Composition(KAHAN_LI_1997_ORDER_6), Numbers::Double),
        Self::InLanes(&Self::Composition(KAHAN_LI_1997_ORDER_8), Numbers::Double),
        Self::InLanes(&Self::Composition(SOFRONIOU_SPALETTA_2005_ORDER_10), Numbers::Double),
        Self::InLanes(&Self::Lobatto3, Numbers::Double),
        Self::InLanes(&Self::Lobatto5, Numbers::Double),
        Self::InLanes(&Self::Lobatto8, Numbers::Double),
        Self::InLanes(&Self::Dop853, Numbers::Double),
        Self::InLanes(&Self::Taylor, Numbers::Double),
    ];

    /// Whether trajectories go side by side.
    #[must_use]
    pub fn is_in_lanes(self) -> bool {
        matches!(self, Self::InLanes(..))
    }

    /// The order p: errors fall like hᵖ.
    #[must_use]
    pub fn order(self) -> u32 {
        match self {
            Self::Rattle | Self::RattleByBroyden => 2,
            Self::Composition(coefficients) => coefficients.order,
            Self::Lobatto3 => 4,
            Self::Lobatto5 | Self::Dop853 => 8,
            Self::Lobatto8 => 14,
            Self::Taylor => TAYLOR,
            Self::InLanes(of, _) => of.order(),
        }
    }

    /// Errors below this part of the size may be rounding.
    pub(super) fn fine(self) -> f64 {
        if let Self::InLanes(_, Numbers::Single) = self { 1e-3 } else { 1e-9 }
    }

    /// Whether its errors depend on a tolerance instead of the step size.
    #[must_use]
    pub fn is_adaptive(self) -> bool {
        match self {
            Self::InLanes(of, _) => of.is_adaptive(),
            _ => matches!(self, Self::Taylor | Self::Dop853),
        }
    }

    /// How many times as long as RATTLE's longest step the first one is that is tried.
    pub(super) fn reach(self) -> f64 {
        match self {
            Self::Rattle | Self::RattleByBroyden => 1.0,
            Self::Composition(_) | Self::Lobatto3 => 4.0,
            Self::Lobatto5 => 8.0,
            Self::Lobatto8 | Self::Taylor | Self::Dop853 => 16.0,
            Self::InLanes(of, _) => of.reach(),
        }
    }

    /// The simulation of a scene by this method with steps of `h`, and the tolerance if the method has one; one
    /// trajectory of those side by side.
    pub(super) fn simulation<C: Hold<D>, E: Effects<D>, N: Count, const D: usize>(
        self,
        scene: &Scene<C, E, N, D>,
        start: State<D>,
        h: f64,
        tolerance: f64,
        halvings: u32,
    ) -> Result<BoxedSimulation<D>, Error> {
        Ok(match self {
            Self::Rattle => scene.simulate(start, Rattle::new(h))?.boxed(),
            Self::RattleByBroyden => {
                scene.simulate(start, Rattle::new(h).guess(Extrapolated).solved_by(Broyden))?.boxed()
            }
            Self::Composition(coefficients) => {
                scene.simulate(start, Composition::new(coefficients, h))?.boxed()
            }
            Self::Lobatto3 => scene.simulate(start, Lobatto::<3>::new(h).guess(Extrapolated))?.boxed(),
            Self::Lobatto5 => scene.simulate(start, Lobatto::<5>::new(h).guess(Extrapolated))?.boxed(),
            Self::Lobatto8 => scene.simulate(start, Lobatto::<8>::new(h).guess(Extrapolated))?.boxed(),
            Self::Taylor => {
                scene.simulate(start, Taylor::adaptive(TAYLOR, h, tolerance))?.retry(halvings).boxed()
            }
            Self::Dop853 => scene.simulate(start, Dop853::adaptive(h, tolerance))?.retry(halvings).boxed(),
            Self::InLanes(of, _) => return of.simulation(scene, start, h, tolerance, halvings),
        })
    }
}

impl fmt::Display for Candidate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Rattle => "RATTLE",
            Self::RattleByBroyden => "RATTLE by Broyden's method",
            Self::Composition(coefficients) => coefficients.name,
            Self::Lobatto3 => "Lobatto, order 4",
            Self::Lobatto5 => "Lobatto, order 8",
            Self::Lobatto8 => "Lobatto, order 14",
            Self::Taylor => "Taylor, adaptive",
            Self::Dop853 => "DOP853, adaptive",
            Self::InLanes(of, numbers) => return f.pad(&format!("{of}, {numbers} in lanes")),
        })
    }
}

impl fmt::Display for Numbers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Single => "single",
            Self::Double => "double",
            Self::Compensated => "compensated",
        })
    }
}
