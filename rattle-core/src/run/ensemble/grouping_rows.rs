//! Rows of linked bodies and of rigid ones: who moves them, and what they obey.

use crate::effect::list::{Effects, Forces};
use crate::methods::lobatto::Lobatto;
use crate::methods::taylor::Taylor;
use crate::motion::method::{Method, Projecting};
use crate::motion::state::State;
use crate::motion::system::System;
use crate::number::instructions::Fusing;
use crate::run::ensemble::engine::Engine;
use crate::run::ensemble::forces_in_lanes::{Pulls, of_all, of_each};
use crate::run::ensemble::grouping::{Groups, HowInLanes, in_rows};
use crate::run::ensemble::linked_going::{Wide, Width};
use crate::run::ensemble::linked_lanes::LinkedLanes;
use crate::run::ensemble::linked_law::LinkedLaws;
use crate::run::ensemble::linked_projected_lanes::{LinkedProjected, ProjectsLinks, TaylorOfLinks};
use crate::run::ensemble::linked_series_law::SeriesLaws;
use crate::run::ensemble::precision::Precision;
use crate::run::ensemble::rigid_lanes::RigidLanes;
use crate::run::ensemble::rigid_law::RigidLaws;
use crate::run::ensemble::rigid_projected_lanes::{RigidProjected, TaylorOfRigid};
use crate::run::ensemble::rigid_row::{Attitude, RigidRow};
use crate::run::ensemble::rigid_stand::ROW as ROW_OF_PROJECTED;
use crate::run::ensemble::series_in_lanes::{self, PullsInSeries};
use crate::run::ensemble::side_by_side::side_by_side;
use crate::run::ensemble::splits::Splits;
use crate::systems::network::Network;
use crate::systems::network::in_lanes::{FEW, ROW};
use crate::systems::rigid::Rigid;
use std::sync::Arc;

/// Who moves rows of linked bodies.
trait MovesLinks {
    /// No more coordinates go in rows of [`ROW`], where more than a few trajectories do.
    const IN_WIDE_ROWS: usize;

    /// A row, no lane of which is set, of a network under these effects, the same on all lanes, with steps of this
    /// length from these starts; none where they cannot go side by side.
    fn all<E: Effects<D>, const D: usize, const W: usize>(
        &self,
        network: &Network<D>,
        effects: &E,
        starts: (&[State<D>], f64),
    ) -> Option<Box<dyn Engine<D>>>
    where
        Width: Wide<W>;

    /// The same, each lane in a network and under effects of its own; lanes beyond them obey what the first does.
    fn each<E: Effects<D> + 'static, const D: usize>(
        &self,
        networks: &[&Network<D>],
        effects: &[&E],
        starts: (&[State<D>], f64),
    ) -> Option<Box<dyn Engine<D>>>;
}

impl MovesLinks for Splits {
    const IN_WIDE_ROWS: usize = usize::MAX;

    fn all<E: Effects<D>, const D: usize, const W: usize>(
        &self,
        network: &Network<D>,
        effects: &E,
        starts: (&[State<D>], f64),
    ) -> Option<Box<dyn Engine<D>>>
    where
        Width: Wide<W>,
    {
        let laws = LinkedLaws::<_, D, W>::by_all(network, effects, starts, self.sums)?;
        Some(Box::new(LinkedLanes::new(laws, self.clone())))
    }

    fn each<E: Effects<D> + 'static, const D: usize>(
        &self,
        networks: &[&Network<D>],
        effects: &[&E],
        starts: (&[State<D>], f64),
    ) -> Option<Box<dyn Engine<D>>> {
        let laws = LinkedLaws::by_each(networks, effects, starts, self.sums)?;
        Some(Box::new(LinkedLanes::new(laws, self.clone())))
    }
}

/// Stages of more leave the nearer cache: from chains of some 30 links on.
const OF_STAGES_IN_WIDE_ROWS: usize = 64;

impl<M: ProjectsLinks> MovesLinks for (M, Fusing) {
    const IN_WIDE_ROWS: usize = OF_STAGES_IN_WIDE_ROWS;

    fn all<E: Effects<D>, const D: usize, const W: usize>(
        &self,
        network: &Network<D>,
        effects: &E,
        starts: (&[State<D>], f64),
    ) -> Option<Box<dyn Engine<D>>>
    where
        Width: Wide<W>,
    {
        let laws = LinkedLaws::<_, D, W>::by_all(network, effects, starts, true)?;
        Some(Box::new(LinkedProjected::new(laws, self.0.clone(), self.1)))
    }

    fn each<E: Effects<D> + 'static, const D: usize>(
        &self,
        networks: &[&Network<D>],
        effects: &[&E],
        starts: (&[State<D>], f64),
    ) -> Option<Box<dyn Engine<D>>> {
        let laws = LinkedLaws::by_each(networks, effects, starts, true)?;
        Some(Box::new(LinkedProjected::new(laws, self.0.clone(), self.1)))
    }
}

impl MovesLinks for (Taylor, Fusing) {
    const IN_WIDE_ROWS: usize = OF_STAGES_IN_WIDE_ROWS;

    fn all<E: Effects<D>, const D: usize, const W: usize>(
        &self,
        network: &Network<D>,
        effects: &E,
        starts: (&[State<D>], f64),
    ) -> Option<Box<dyn Engine<D>>>
    where
        Width: Wide<W>,
    {
        let laws = LinkedLaws::<_, D, W>::by_all(network, effects, starts, true)?;
        let series = SeriesLaws::of(&laws.1, series_in_lanes::of_all(effects, starts.0.first()?.len())?)?;
        Some(Box::new(LinkedProjected::new(
            laws,
            TaylorOfLinks { method: self.0, laws: Arc::new(series) },
            self.1,
        )))
    }

    fn each<E: Effects<D> + 'static, const D: usize>(
        &self,
        networks: &[&Network<D>],
        effects: &[&E],
        starts: (&[State<D>], f64),
    ) -> Option<Box<dyn Engine<D>>> {
        let laws = LinkedLaws::by_each(networks, effects, starts, true)?;
        let of = |lane: usize| if lane < effects.len() { effects[lane] } else { effects[0] };
        let series =
            SeriesLaws::of(&laws.1, series_in_lanes::of_each::<_, D, ROW>(of, starts.0.first()?.len())?)?;
        Some(Box::new(LinkedProjected::new(
            laws,
            TaylorOfLinks { method: self.0, laws: Arc::new(series) },
            self.1,
        )))
    }
}

/// Trajectories of linked bodies that are to go in rows.
trait OfLinks<const D: usize> {
    /// Whether there are flows of momenta.
    const FLOWS: bool;
    /// The rows, moved by this method.
    fn by<M: MovesLinks>(&self, method: &M) -> Groups<D>;
}

/// Those of one scene.
struct InOneNetwork<'a, E, const D: usize> {
    network: &'a Network<D>,
    effects: &'a E,
    starts: &'a [State<D>],
    h: f64,
    first: usize,
}

impl<E: Effects<D>, const D: usize> OfLinks<D> for InOneNetwork<'_, E, D> {
    const FLOWS: bool = E::Forces::<f64>::FLOWS > 0;

    fn by<M: MovesLinks>(&self, method: &M) -> Groups<D> {
        let Self { network, effects, starts, h, first } = *self;
        let bodies = starts.first()?.len();
        // Three rows of a few take less time than a full one.
        let (row, width) = if starts.len() <= 3 * FEW || bodies * D > M::IN_WIDE_ROWS {
            (method.all::<_, D, FEW>(network, effects, (starts, h))?, FEW)
        } else {
            (method.all::<_, D, ROW>(network, effects, (starts, h))?, ROW)
        };
        in_rows(width, starts, &|from, starts| Some(side_by_side(row.boxed(), first + from, starts)))
    }
}

/// Those of scenes of one type, each of a trajectory of its own.
struct InNetworks<'a, E, const D: usize> {
    networks: &'a [&'a Network<D>],
    effects: &'a [&'a E],
    starts: &'a [State<D>],
    h: f64,
    first: usize,
}

impl<E: Effects<D> + 'static, const D: usize> OfLinks<D> for InNetworks<'_, E, D> {
    const FLOWS: bool = E::Forces::<f64>::FLOWS > 0;

    fn by<M: MovesLinks>(&self, method: &M) -> Groups<D> {
        let Self { networks, effects, starts, h, first } = *self;
        let bodies = starts.first()?.len();
        if starts.iter().any(|start| start.len() != bodies) {
            return None;
        }
        in_rows(ROW, starts, &|from, starts| {
            let own = from..from + starts.len();
            let row = method.each(&networks[own.clone()], &effects[own], (starts, h))?;
            Some(side_by_side(row, first + from, starts))
        })
    }
}

/// The rows, moved as this method moves them.
fn moved<P: Precision, S: Method, X: OfLinks<D>, const D: usize>(rows: &X, lanes: &HowInLanes) -> Groups<D> {
    let mover = const { mover::<P, S, X, D>() };
    mover(rows, lanes)
}

/// Who moves the rows as the method does; to be a constant, see
/// [`grouping_kinds`](crate::run::ensemble::grouping_kinds).
const fn mover<P: Precision, S: Method, X: OfLinks<D>, const D: usize>() -> fn(&X, &HowInLanes) -> Groups<D> {
    macro_rules! by_stages {
        ($($stages:literal)*) => {$(
            if S::COLLOCATES == $stages {
                return |rows, lanes| rows.by(&(Lobatto::<$stages>::new(lanes.h), lanes.set));
            }
        )*};
    }
    by_stages!(2 3 4 5 6 7 8 9);
    match S::PROJECTS {
        Projecting::Dop853 => |rows, lanes| rows.by(&(lanes.dop853(), lanes.set)),
        Projecting::Taylor => |rows, lanes| rows.by(&(lanes.taylor(), lanes.set)),
        Projecting::Not => |rows, lanes| rows.by(&lanes.splits::<P, S>(X::FLOWS)),
    }
}

/// Trajectories of linked bodies, no more than there are lanes, in rows.
pub(super) fn linked<P: Precision, S: Method, E: Effects<D>, const D: usize>(
    network: &Network<D>,
    effects: &E,
    starts: &[State<D>],
    lanes: &HowInLanes,
) -> Groups<D> {
    moved::<P, S, _, D>(&InOneNetwork { network, effects, starts, h: lanes.h, first: lanes.first }, lanes)
}

/// The same, each in a network and under effects of its own.
pub(super) fn linked_apart<P: Precision, S: Method, E: Effects<D> + 'static, const D: usize>(
    networks: &[&Network<D>],
    effects: &[&E],
    starts: &[State<D>],
    lanes: &HowInLanes,
) -> Groups<D> {
    moved::<P, S, _, D>(&InNetworks { networks, effects, starts, h: lanes.h, first: lanes.first }, lanes)
}

/// Trajectories of rigid bodies, no more than there are lanes, in rows, in systems of one scene, or in scenes of their
/// own.
pub(super) fn rigid<P: Precision, S: Method, X: Turned, Y: System<f64, D>, const D: usize>(
    bodies: &[&Rigid],
    systems: &[Y],
    effects: &X,
    starts: &[State<D>],
    lanes: &HowInLanes,
) -> Groups<D> {
    let number = starts.first()?.len();
    if starts.iter().any(|start| start.len() != number) {
        return None;
    }
    let rows = Rigids { bodies, systems, effects, starts, first: lanes.first };
    let turner = const { turner::<P, S, X, Y, D>() };
    turner(&rows, lanes)
}

/// Who moves rows of rigid bodies as the method does; to be a constant, as `mover` is.
const fn turner<P: Precision, S: Method, X: Turned, Y: System<f64, D>, const D: usize>()
-> fn(&Rigids<'_, X, Y, D>, &HowInLanes) -> Groups<D> {
    match S::PROJECTS {
        Projecting::Dop853 => |rows, lanes| {
            let (method, set) = (lanes.dop853(), lanes.set);
            rows.of(&|_, laws, n| Some(Box::new(RigidProjected::<_, Y, D>::new(laws, n, method, set))))
        },
        Projecting::Taylor => |rows, lanes| {
            let (method, set) = (lanes.taylor(), lanes.set);
            rows.of(&|from, laws, n| {
                let pulls = rows.effects.series::<ROW_OF_PROJECTED>(from, n)?;
                let method = TaylorOfRigid { method, pulls };
                Some(Box::new(RigidProjected::<_, Y, D>::new(laws, n, method, set)))
            })
        },
        Projecting::Not => |rows, lanes| {
            let method = Arc::new(lanes.splits::<P, S>(const { Y::FLOWS > 0 }));
            if rows.starts.len() <= 3 * FEW {
                rows.of(&|_, laws, n| Some(Box::new(RigidLanes::<Y, D, FEW>::new(laws, n, method.clone()))))
            } else {
                rows.of(&|_, laws, n| Some(Box::new(RigidLanes::<Y, D, ROW>::new(laws, n, method.clone()))))
            }
        },
    }
}

/// What turns rigid bodies.
pub(super) trait Turned {
    /// The effects on W trajectories of so many bodies from this one on.
    fn pulls<B: Attitude<W>, const W: usize>(
        &self,
        from: usize,
        bodies: usize,
    ) -> Option<Box<dyn Pulls<RigidRow<B>, W>>>;

    /// The same as power series; none where one has none.
    #[allow(clippy::option_option, reason = "there are none, or none that have a series")]
    fn series<const W: usize>(&self, from: usize, bodies: usize) -> Option<Option<Box<dyn PullsInSeries>>>;
}

/// Those of one scene of bodies of D coordinates.
pub(super) struct TurnedAlike<'a, E, const D: usize>(pub(super) &'a E);

impl<E: Effects<D>, const D: usize> Turned for TurnedAlike<'_, E, D> {
    fn pulls<B: Attitude<W>, const W: usize>(
        &self,
        _: usize,
        bodies: usize,
    ) -> Option<Box<dyn Pulls<RigidRow<B>, W>>> {
        of_all(self.0, bodies)
    }

    fn series<const W: usize>(&self, _: usize, bodies: usize) -> Option<Option<Box<dyn PullsInSeries>>> {
        series_in_lanes::of_all(self.0, bodies)
    }
}

/// Those of scenes of one type, each of a trajectory of its own.
pub(super) struct TurnedApart<'a, E, const D: usize>(pub(super) &'a [&'a E]);

impl<E: Effects<D> + 'static, const D: usize> Turned for TurnedApart<'_, E, D> {
    fn pulls<B: Attitude<W>, const W: usize>(
        &self,
        from: usize,
        bodies: usize,
    ) -> Option<Box<dyn Pulls<RigidRow<B>, W>>> {
        of_each(|lane| self.of(from, lane), bodies)
    }

    fn series<const W: usize>(&self, from: usize, bodies: usize) -> Option<Option<Box<dyn PullsInSeries>>> {
        series_in_lanes::of_each::<_, D, W>(|lane| self.of(from, lane), bodies)
    }
}

impl<E, const D: usize> TurnedApart<'_, E, D> {
    /// What a lane of a row that begins there obeys; those beyond all obey what the first does.
    fn of(&self, from: usize, lane: usize) -> &E {
        self.0.get(from + lane).unwrap_or(&self.0[from])
    }
}

/// Trajectories of rigid bodies, and what they obey: all the same, or each its own.
struct Rigids<'a, X, Y, const D: usize> {
    bodies: &'a [&'a Rigid],
    systems: &'a [Y],
    effects: &'a X,
    starts: &'a [State<D>],
    first: usize,
}

impl<X: Turned, Y: System<f64, D>, const D: usize> Rigids<'_, X, Y, D> {
    /// Rows, each made from the number of its first trajectory, counted from these, and what is obeyed there by so many
    /// bodies in each lane.
    fn of<B: Attitude<W>, const W: usize>(
        &self,
        row: &dyn Fn(usize, RigidLaws<Y, B, W>, usize) -> Option<Box<dyn Engine<D>>>,
    ) -> Groups<D> {
        let Self { bodies, systems, effects, starts, first } = *self;
        in_rows(W, starts, &|from, starts| {
            let own = if systems.len() == 1 { 0..1 } else { from..from + starts.len() };
            let (systems, bodies) = (systems[own.clone()].into(), &bodies[own]);
            let number = starts[0].len();
            let laws = RigidLaws::new(systems, bodies, effects.pulls(from, number));
            Some(side_by_side(row(from, laws, number)?, first + from, starts))
        })
    }
}
