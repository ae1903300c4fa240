//! Which methods can move a system: the one place that refuses a method.

use crate::error::{EffectMistake, Error};
use crate::methods::baoab::Baoab;
use crate::methods::bdf2::Bdf2;
use crate::methods::brownian::Brownian;
use crate::methods::dop853::Dop853;
use crate::methods::geodesic::Geodesic;
use crate::methods::leapfrog::Leapfrog;
use crate::methods::lobatto::Lobatto;
use crate::methods::nose_hoover::NoseHoover;
use crate::methods::position_verlet::PositionVerlet;
use crate::methods::rattle::Rattle;
use crate::methods::shake::Shake;
use crate::methods::symplectic_euler::SymplecticEuler;
use crate::methods::taylor::Taylor;
use crate::methods::variable::Variable;
use crate::motion::method::{Method, View};
use crate::motion::need::Need;
use crate::motion::stir::{FEELING_FLOW, FLOW, feels, random};
use crate::motion::system::System;

/// The system as a step of this method is handed it.
///
/// # Errors
/// [`Error::CannotMove`] where the system has not what the method needs, or flows of momenta by which its step cannot
/// be divided, or which feel forces and would act in its middle, before the forces that they feel; with the methods
/// that can move it.
#[inline(always)]
pub(crate) fn view<'a, S: Method, Y: System<f64, D>, const D: usize>(
    method: &S,
    system: &'a Y,
) -> Result<View<'a, S, f64, Y, D>, Error> {
    let divided = method.is_symmetric() && method.momentum_delay() == 0.0;
    if Y::FLOWS > 0 && ((!divided && !S::STIRS) || (S::FORGETS && !Y::PUSHES)) {
        return Err(refused(method.name(), FLOW, system));
    }
    if const { S::STIRS && Y::FLOWS > 0 } && feels(system) {
        return Err(refused(method.name(), FEELING_FLOW, system));
    }
    S::Need::of(system).map_err(|kind| refused(method.name(), kind, system))
}

#[cold]
#[inline(never)]
fn refused<Y: System<f64, D>, const D: usize>(method: &'static str, kind: &'static str, system: &Y) -> Error {
    let whole = Y::FLOWS == 0;
    let able = [
        ("Rattle", moves::<Rattle, Y, D>(system)),
        ("Baoab", moves::<Baoab, Y, D>(system) && !feels(system)),
        ("NoseHoover", moves::<NoseHoover, Y, D>(system) && whole),
        ("Brownian", moves::<Brownian, Y, D>(system) && Y::PUSHES && !feels(system)),
        ("Geodesic", moves::<Geodesic, Y, D>(system)),
        ("PositionVerlet", moves::<PositionVerlet, Y, D>(system)),
        ("Shake", moves::<Shake, Y, D>(system) && whole),
        ("SymplecticEuler", moves::<SymplecticEuler, Y, D>(system) && whole),
        ("Leapfrog", moves::<Leapfrog, Y, D>(system) && system.equations() == 0 && whole),
        ("Variable", moves::<Variable<Rattle>, Y, D>(system) && whole),
        ("Lobatto", moves::<Lobatto<2>, Y, D>(system)),
        ("Dop853", moves::<Dop853, Y, D>(system) && whole),
        ("Taylor", moves::<Taylor, Y, D>(system) && whole),
        ("Bdf2", moves::<Bdf2, Y, D>(system) && whole),
    ];
    cannot_move(method, kind, &able)
}

fn cannot_move(method: &'static str, kind: &'static str, able: &[(&'static str, bool)]) -> Error {
    let others = able.iter().filter_map(|&(name, able)| able.then_some(name)).collect();
    Error::CannotMove { method, system: kind, others }
}

fn moves<S: Method, Y: System<f64, D>, const D: usize>(system: &Y) -> bool {
    S::Need::of(system).is_ok()
}

/// Refuses flows that draw random numbers, for a motion that runs backwards.
pub(crate) fn no_way_back<Y: System<f64, D>, const D: usize>(system: &Y) -> Result<(), Error> {
    match random(system) {
        Some(effect) => Err(Error::Effect { effect, mistake: EffectMistake::NoWayBack }),
        None => Ok(()),
    }
}
