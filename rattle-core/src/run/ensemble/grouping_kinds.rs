//! Which kind of rows the constraints of a scene go in.
//!
//! What types alone choose is a constant, the value of which is a function, here and where kinds of rows are chosen
//! further. For the compiler goes through all functions that a function mentions, also in branches on constants that
//! are never taken. With `if const` it spent most of its time on that.

use crate::effect::list::Effects;
use crate::motion::bodies::Count;
use crate::motion::hold::{Hold, Kind};
use crate::motion::method::Method;
use crate::motion::state::State;
use crate::run::ensemble::grouping::{Alike, Different, Groups, HowInLanes, InRows, goes_as};
use crate::run::ensemble::grouping_rows::{
    InNetworks, InOneNetwork, TurnedAlike, TurnedApart, linked, rigid,
};
use crate::run::ensemble::precision::Precision;
use crate::scene::Scene;
use crate::systems::network::Network;
use std::any::Any;
use std::marker::PhantomData;

/// Puts trajectories in lanes, no more than there are lanes, each of its own scene and from its own start.
pub(super) type InLanes<C, E, N, const D: usize> =
    fn(&[&Scene<C, E, N, D>], &[State<D>], &HowInLanes) -> Groups<D>;

/// Who puts trajectories of one scene in lanes; only the first scene of the list is read.
pub(super) const fn alike<P, S, C, E, N, const D: usize>() -> InLanes<C, E, N, D>
where
    P: Precision,
    S: Method,
    C: Hold<D> + 'static,
    E: Effects<D>,
    N: Count,
{
    if goes_as::<C, S, D>(Kind::Rigid) {
        return |scenes, starts, lanes| {
            let (scene, h) = (scenes[0], lanes.h);
            let body = (&scene.constraint as &dyn Any).downcast_ref()?;
            let system = scene.constraint.system(&scene.effects, scene.count, &starts[0], h, false).ok()?;
            rigid::<P, S, _, _, D>(&[body], &[system], &TurnedAlike(&scene.effects), starts, lanes)
        };
    }
    if goes_as::<C, S, D>(Kind::Network) {
        return |scenes, starts, lanes| {
            let network = (&scenes[0].constraint as &dyn Any).downcast_ref::<Network<D>>()?;
            linked::<P, S, _, D>(&InOneNetwork(network, &scenes[0].effects, starts), lanes)
        };
    }
    if goes_as::<C, S, D>(Kind::Phase) {
        return |scenes, starts, lanes| {
            C::phase_spaces(&[&scenes[0].constraint], InRows(scenes[0].count, starts, lanes))?
        };
    }
    |scenes, starts, lanes| {
        let alike = Alike(PhantomData::<(P, S)>, &scenes[0].effects, starts, lanes);
        C::surfaces(&[&scenes[0].constraint], alike)?
    }
}

/// The same of scenes of one type, each of a trajectory of its own.
pub(super) const fn apart<P, S, C, E, N, const D: usize>() -> InLanes<C, E, N, D>
where
    P: Precision,
    S: Method,
    C: Hold<D> + 'static,
    E: Effects<D> + 'static,
    N: Count,
{
    if goes_as::<C, S, D>(Kind::Rigid) {
        return |scenes, starts, lanes| {
            let (mut bodies, mut systems) =
                (Vec::with_capacity(scenes.len()), Vec::with_capacity(scenes.len()));
            for (scene, start) in scenes.iter().zip(starts) {
                bodies.push((&scene.constraint as &dyn Any).downcast_ref()?);
                let system = scene.constraint.system(&scene.effects, scene.count, start, lanes.h, false);
                systems.push(system.ok()?);
            }
            rigid::<P, S, _, _, D>(&bodies, &systems, &TurnedApart(&effects(scenes)), starts, lanes)
        };
    }
    if goes_as::<C, S, D>(Kind::Network) {
        return |scenes, starts, lanes| {
            let mut networks = Vec::with_capacity(scenes.len());
            for scene in scenes {
                networks.push((&scene.constraint as &dyn Any).downcast_ref::<Network<D>>()?);
            }
            linked::<P, S, _, D>(&InNetworks(&networks, &effects(scenes), starts), lanes)
        };
    }
    if goes_as::<C, S, D>(Kind::Phase) {
        return |scenes, starts, lanes| {
            C::phase_spaces(&constraints(scenes), InRows(scenes[0].count, starts, lanes))?
        };
    }
    |scenes, starts, lanes| {
        let effects = effects(scenes);
        let different = Different(PhantomData::<(P, S)>, &effects, starts, lanes);
        C::surfaces(&constraints(scenes), different)?
    }
}

fn effects<'a, C, E, N, const D: usize>(scenes: &[&'a Scene<C, E, N, D>]) -> Vec<&'a E> {
    scenes.iter().map(|scene| &scene.effects).collect()
}

fn constraints<'a, C, E, N, const D: usize>(scenes: &[&'a Scene<C, E, N, D>]) -> Vec<&'a C> {
    scenes.iter().map(|scene| &scene.constraint).collect()
}
