//! Every method as one type, and the table of what is expected of each.

use rattle::bodies::Bodies;
use rattle::composition::*;
use rattle::method::{Failure, View, Witness};
use rattle::need::{Kicks, WithCollocation, WithRates, WithSeries};
use rattle::prelude::*;
use rattle::real::Scalar;
use rattle::system::System;

/// A method of the table, whichever it is.
#[derive(Debug, Clone, Copy)]
pub(crate) enum OneOf {
    Rattle(Rattle),
    Euler(SymplecticEuler),
    Shake(Shake),
    Geodesic(Geodesic),
    PositionVerlet(PositionVerlet),
    Composed(Composition),
    ComposedGeodesic(Composition<Geodesic>),
    ComposedVerlet(Composition<PositionVerlet>),
    Lobatto3(Lobatto<3>),
    Lobatto5(Lobatto<5>),
    Lobatto6(Lobatto<6>),
    Dop853(Dop853),
    Bdf2(Bdf2),
    Taylor(Taylor),
}

macro_rules! delegate {
    ($self:ident, $method:ident => $call:expr) => {
        match $self {
            Self::Rattle($method) => $call,
            Self::Euler($method) => $call,
            Self::Shake($method) => $call,
            Self::Geodesic($method) => $call,
            Self::PositionVerlet($method) => $call,
            Self::Composed($method) => $call,
            Self::ComposedGeodesic($method) => $call,
            Self::ComposedVerlet($method) => $call,
            Self::Lobatto3($method) => $call,
            Self::Lobatto5($method) => $call,
            Self::Lobatto6($method) => $call,
            Self::Dop853($method) => $call,
            Self::Bdf2($method) => $call,
            Self::Taylor($method) => $call,
        }
    };
}

impl rattle::Method for OneOf {
    type Memory<T: Scalar> = Vec<T>;
    type Need = (Kicks, WithRates, (WithCollocation, WithSeries));

    fn step_size(&self) -> f64 {
        delegate!(self, method => method.step_size())
    }
    fn order(&self) -> u32 {
        delegate!(self, method => method.order())
    }
    fn name(&self) -> &'static str {
        delegate!(self, method => method.name())
    }
    fn with_step(&self, h: f64) -> Self {
        match self {
            Self::Rattle(method) => Self::Rattle(method.with_step(h)),
            Self::Euler(method) => Self::Euler(method.with_step(h)),
            Self::Shake(method) => Self::Shake(method.with_step(h)),
            Self::Geodesic(method) => Self::Geodesic(method.with_step(h)),
            Self::PositionVerlet(method) => Self::PositionVerlet(method.with_step(h)),
            Self::Composed(method) => Self::Composed(method.with_step(h)),
            Self::ComposedGeodesic(method) => Self::ComposedGeodesic(method.with_step(h)),
            Self::ComposedVerlet(method) => Self::ComposedVerlet(method.with_step(h)),
            Self::Lobatto3(method) => Self::Lobatto3(method.with_step(h)),
            Self::Lobatto5(method) => Self::Lobatto5(method.with_step(h)),
            Self::Lobatto6(method) => Self::Lobatto6(method.with_step(h)),
            Self::Dop853(method) => Self::Dop853(method.with_step(h)),
            Self::Bdf2(method) => Self::Bdf2(method.with_step(h)),
            Self::Taylor(method) => Self::Taylor(method.with_step(h)),
        }
    }
    fn is_symmetric(&self) -> bool {
        delegate!(self, method => method.is_symmetric())
    }
    fn momentum_delay(&self) -> f64 {
        delegate!(self, method => method.momentum_delay())
    }
    fn prepare<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        (kicks, rates, (collocation, series)): View<'_, Self, T, Y, D>,
        bodies: &mut Bodies<Y::Count, T, Y::Kept, D>,
    ) {
        match self {
            Self::Lobatto3(method) => method.prepare((kicks, collocation), bodies),
            Self::Lobatto5(method) => method.prepare((kicks, collocation), bodies),
            Self::Lobatto6(method) => method.prepare((kicks, collocation), bodies),
            Self::Dop853(method) => method.prepare((kicks, rates), bodies),
            Self::Bdf2(method) => method.prepare((kicks, rates), bodies),
            Self::Taylor(method) => method.prepare((kicks, rates, series), bodies),
            _ => {}
        }
    }
    fn memory<T: Scalar, Y: System<T, D>, const D: usize>(
        &self,
        (kicks, rates, _): View<'_, Self, T, Y, D>,
        bodies: &Bodies<Y::Count, T, Y::Kept, D>,
    ) -> Vec<T> {
        match self {
            Self::Bdf2(method) => method.memory((kicks, rates), bodies),
            _ => Vec::new(),
        }
    }
    fn check(&self, equations: usize) -> Result<(), rattle::Error> {
        delegate!(self, method => method.check(equations))
    }
    fn step<T: Scalar, Y: System<T, D>, W: Witness<T>, const D: usize>(
        &self,
        (kicks, rates, (collocation, series)): View<'_, Self, T, Y, D>,
        bodies: &mut Bodies<Y::Count, T, Y::Kept, D>,
        memory: &mut [T],
        witness: &mut W,
    ) -> Result<(), Failure> {
        match self {
            Self::Rattle(method) => method.step(kicks, bodies, memory, witness),
            Self::Euler(method) => method.step(kicks, bodies, memory, witness),
            Self::Shake(method) => method.step(kicks, bodies, memory, witness),
            Self::Geodesic(method) => method.step(kicks, bodies, memory, witness),
            Self::PositionVerlet(method) => method.step(kicks, bodies, memory, witness),
            Self::Composed(method) => method.step(kicks, bodies, memory, witness),
            Self::ComposedGeodesic(method) => method.step(kicks, bodies, memory, witness),
            Self::ComposedVerlet(method) => method.step(kicks, bodies, memory, witness),
            Self::Lobatto3(method) => method.step((kicks, collocation), bodies, memory, witness),
            Self::Lobatto5(method) => method.step((kicks, collocation), bodies, memory, witness),
            Self::Lobatto6(method) => method.step((kicks, collocation), bodies, memory, witness),
            Self::Dop853(method) => method.step((kicks, rates), bodies, memory, witness),
            Self::Bdf2(method) => method.step((kicks, rates), bodies, memory, witness),
            Self::Taylor(method) => method.step((kicks, rates, series), bodies, memory, witness),
        }
    }
}

/// Numbers of steps between which errors show the order, and only it.
pub(crate) type Window = [u32; 2];

/// Where errors fall below rounding before they show any order; DOP853 on the double pendulum as h⁹, so small is the
/// term of its order there.
pub(crate) const NONE: Window = [0; 2];

/// A row of the table: a method, and windows for the lemniscate, the spherical and the double pendulum.
pub(crate) struct Row {
    pub(crate) name: &'static str,
    pub(crate) order: u32,
    pub(crate) method: OneOf,
    pub(crate) windows: [Window; 3],
    /// Steps on the lemniscate and of the double pendulum at which it shows that the method is not symplectic and does
    /// not go back; none if it is symplectic.
    pub(crate) unstructured: Option<[f64; 2]>,
}

/// The table. Methods with the largest |γ| need the shortest steps.
pub(crate) fn rows() -> Vec<Row> {
    let row = |name, order, method, windows| Row { name, order, method, windows, unstructured: None };
    let free = |name, order, method, windows, h| Row { name, order, method, windows, unstructured: Some(h) };
    let composed = |coefficients: Coefficients, windows| {
        let method = OneOf::Composed(Composition::new(coefficients, 1.0));
        row(coefficients.name, coefficients.order, method, windows)
    };
    let (geodesic, verlet) = (Geodesic::new(4, 1.0), PositionVerlet::new(1.0));
    let geodesic_6 = OneOf::ComposedGeodesic(Composition::of(KAHAN_LI_1997_ORDER_6, geodesic));
    let verlet_4 = OneOf::ComposedVerlet(Composition::of(SUZUKI_1990_ORDER_4, verlet));
    vec![
        row(
            "symplectic Euler",
            1,
            OneOf::Euler(SymplecticEuler::new(1.0)),
            [[16_000, 64_000], [100, 400], [100, 400]],
        ),
        row("RATTLE", 2, OneOf::Rattle(Rattle::new(1.0)), [[100, 800], [32, 256], [32, 256]]),
        row("SHAKE", 2, OneOf::Shake(Shake::new(1.0)), [[100, 800], [32, 256], [32, 256]]),
        row("geodesic RATTLE", 2, OneOf::Geodesic(geodesic), [[100, 800], [32, 256], [32, 256]]),
        row("position Verlet", 2, OneOf::PositionVerlet(verlet), [[100, 800], [32, 256], [32, 256]]),
        composed(YOSHIDA_1990_ORDER_4, [[181, 1024], [32, 256], [32, 256]]),
        composed(SUZUKI_1990_ORDER_4, [[91, 512], [16, 128], [23, 128]]),
        composed(MCLACHLAN_1995_ORDER_4, [[91, 512], [16, 128], [16, 128]]),
        composed(KAHAN_LI_1997_ORDER_4, [[91, 512], [16, 128], [16, 128]]),
        composed(YOSHIDA_1990_ORDER_6, [[128, 512], [16, 64], [23, 128]]),
        composed(KAHAN_LI_1997_ORDER_6, [[91, 362], [11, 64], [23, 90]]),
        composed(MCLACHLAN_1995_ORDER_6, [[91, 362], [11, 64], [11, 90]]),
        composed(SUZUKI_UMENO_1993_ORDER_8, [[91, 181], [8, 23], [11, 45]]),
        composed(KAHAN_LI_1997_ORDER_8, [[91, 181], [6, 20], [12, 40]]),
        composed(MCLACHLAN_1995_ORDER_8, [[91, 181], [6, 20], [12, 40]]),
        composed(KAHAN_LI_1997_ORDER_10, [[91, 160], [8, 16], [16, 32]]),
        composed(SOFRONIOU_SPALETTA_2005_ORDER_10, [NONE, [3, 8], [9, 16]]),
        row("geodesic RATTLE, Kahan–Li 1997, order 6", 6, geodesic_6, [[128, 300], [8, 64], [16, 90]]),
        row("position Verlet, Suzuki 1990, order 4", 4, verlet_4, [[64, 512], [8, 90], [16, 128]]),
        row("Lobatto, 3 stages", 4, OneOf::Lobatto3(Lobatto::new(1.0)), [[64, 256], [8, 64], [16, 128]]),
        row("Lobatto, 5 stages", 8, OneOf::Lobatto5(Lobatto::new(1.0)), [[64, 128], [3, 10], [12, 28]]),
        row("Lobatto, 6 stages", 10, OneOf::Lobatto6(Lobatto::new(1.0)), [NONE, [2, 5], [10, 18]]),
        free("DOP853", 8, OneOf::Dop853(Dop853::new(1.0)), [[128, 200], [3, 10], NONE], [0.1, 0.3]),
        free("BDF2", 2, OneOf::Bdf2(Bdf2::new(1.0)), [[400, 3200], [64, 512], [64, 512]], [0.01, 0.01]),
        free(
            "Taylor, order 6",
            6,
            OneOf::Taylor(Taylor::new(6, 1.0)),
            [[512, 1600], [32, 90], [64, 180]],
            [0.05; 2],
        ),
        free(
            "Taylor, order 10",
            10,
            OneOf::Taylor(Taylor::new(10, 1.0)),
            [NONE, [6, 14], [34, 56]],
            [0.06, 0.15],
        ),
    ]
}
