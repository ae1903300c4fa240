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
use crate::run::ensemble::linked_plan::LinkedPlan;
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

/// Effects as power series, if there are any; none where one has no series.
#[allow(clippy::option_option, reason = "there are none, or none that have a series")]
type MaybeSeries = Option<Option<Box<dyn PullsInSeries>>>;

/// Who moves rows of linked bodies.
pub(super) trait MovesLinks {
    /// No more coordinates go in rows of [`ROW`], where more than a few trajectories do.
    const IN_WIDE_ROWS: usize = OF_STAGES_IN_WIDE_ROWS;

    /// Whether sums are compensated.
    fn sums(&self) -> bool {
        true
    }

    /// A row of what obeys these laws, no lane of which is set; with the same effects as power series, if it asks for
    /// them: none where one has none.
    fn row<F: Forces<f64, D>, const D: usize, const W: usize>(
        &self,
        laws: (LinkedPlan, LinkedLaws<F, D, W>),
        series: impl FnOnce() -> MaybeSeries,
    ) -> Option<Box<dyn Engine<D>>>
    where
        Width: Wide<W>;
}

impl MovesLinks for Splits {
    const IN_WIDE_ROWS: usize = usize::MAX;

    fn sums(&self) -> bool {
        self.sums
    }

    fn row<F: Forces<f64, D>, const D: usize, const W: usize>(
        &self,
        laws: (LinkedPlan, LinkedLaws<F, D, W>),
        _: impl FnOnce() -> MaybeSeries,
    ) -> Option<Box<dyn Engine<D>>>
    where
        Width: Wide<W>,
    {
        Some(Box::new(LinkedLanes::new(laws, self.clone())))
    }
}

/// Stages of more leave the nearer cache: from chains of some 30 links on.
const OF_STAGES_IN_WIDE_ROWS: usize = 64;

impl<M: ProjectsLinks> MovesLinks for (M, Fusing) {
    fn row<F: Forces<f64, D>, const D: usize, const W: usize>(
        &self,
        laws: (LinkedPlan, LinkedLaws<F, D, W>),
        _: impl FnOnce() -> MaybeSeries,
    ) -> Option<Box<dyn Engine<D>>>
    where
        Width: Wide<W>,
    {
        Some(Box::new(LinkedProjected::new(laws, self.0.clone(), self.1)))
    }
}

impl MovesLinks for (Taylor, Fusing) {
    fn row<F: Forces<f64, D>, const D: usize, const W: usize>(
        &self,
        laws: (LinkedPlan, LinkedLaws<F, D, W>),
        series: impl FnOnce() -> MaybeSeries,
    ) -> Option<Box<dyn Engine<D>>>
    where
        Width: Wide<W>,
    {
        let method = TaylorOfLinks { method: self.0, laws: Arc::new(SeriesLaws::of(&laws.1, series()?)?) };
        Some(Box::new(LinkedProjected::new(laws, method, self.1)))
    }
}

/// Trajectories of linked bodies that are to go in rows.
pub(super) trait OfLinks<const D: usize> {
    /// Whether there are flows of momenta.
    const FLOWS: bool;
    /// The rows, moved by this method.
    fn by<M: MovesLinks>(&self, method: &M, lanes: &HowInLanes) -> Groups<D>;
}

/// Those of one scene: network, effects and starts.
pub(super) struct InOneNetwork<'a, E, const D: usize>(
    pub(super) &'a Network<D>,
    pub(super) &'a E,
    pub(super) &'a [State<D>],
);

impl<E: Effects<D>, const D: usize> InOneNetwork<'_, E, D> {
    fn row<M: MovesLinks, const W: usize>(&self, method: &M, h: f64) -> Option<Box<dyn Engine<D>>>
    where
        Width: Wide<W>,
    {
        let Self(network, effects, starts) = *self;
        let laws = LinkedLaws::<_, D, W>::by_all(network, effects, (starts, h), method.sums())?;
        method.row(laws, || series_in_lanes::of_all(effects, starts.first()?.len()))
    }
}

impl<E: Effects<D>, const D: usize> OfLinks<D> for InOneNetwork<'_, E, D> {
    const FLOWS: bool = E::Forces::<f64>::FLOWS > 0;

    fn by<M: MovesLinks>(&self, method: &M, &HowInLanes { h, first, .. }: &HowInLanes) -> Groups<D> {
        let starts = self.2;
        // Three rows of a few take less time than a full one.
        let (row, width) = if starts.len() <= 3 * FEW || starts.first()?.len() * D > M::IN_WIDE_ROWS {
            (self.row::<M, FEW>(method, h)?, FEW)
        } else {
            (self.row::<M, ROW>(method, h)?, ROW)
        };
        in_rows(width, starts, &|from, starts| Some(side_by_side(row.clone(), first + from, starts)))
    }
}

/// Those of scenes of one type, each of a trajectory of its own.
pub(super) struct InNetworks<'a, E, const D: usize>(
    pub(super) &'a [&'a Network<D>],
    pub(super) &'a [&'a E],
    pub(super) &'a [State<D>],
);

impl<E: Effects<D> + 'static, const D: usize> OfLinks<D> for InNetworks<'_, E, D> {
    const FLOWS: bool = E::Forces::<f64>::FLOWS > 0;

    fn by<M: MovesLinks>(&self, method: &M, &HowInLanes { h, first, .. }: &HowInLanes) -> Groups<D> {
        let Self(networks, effects, starts) = *self;
        let bodies = starts.first()?.len();
        if starts.iter().any(|start| start.len() != bodies) {
            return None;
        }
        in_rows(ROW, starts, &|from, starts| {
            let own = from..from + starts.len();
            let (networks, effects) = (&networks[own.clone()], &effects[own]);
            let laws = LinkedLaws::by_each(networks, effects, (starts, h), method.sums())?;
            let of = |lane: usize| if lane < effects.len() { effects[lane] } else { effects[0] };
            let row = method.row(laws, || series_in_lanes::of_each::<_, D, ROW>(of, bodies))?;
            Some(side_by_side(row, first + from, starts))
        })
    }
}

/// The rows, moved as the method moves them.
pub(super) fn linked<P: Precision, S: Method, X: OfLinks<D>, const D: usize>(
    rows: &X,
    lanes: &HowInLanes,
) -> Groups<D> {
    let mover = const { mover::<P, S, X, D>() };
    mover(rows, lanes)
}

/// Who moves the rows as the method does; to be a constant, see
/// [`grouping_kinds`](crate::run::ensemble::grouping_kinds).
const fn mover<P: Precision, S: Method, X: OfLinks<D>, const D: usize>() -> fn(&X, &HowInLanes) -> Groups<D> {
    macro_rules! by_stages {
        ($($stages:literal)*) => {$(
            if S::COLLOCATES == $stages {
                return |rows, lanes| rows.by(&(Lobatto::<$stages>::new(lanes.h), lanes.set), lanes);
            }
        )*};
    }
    by_stages!(2 3 4 5 6 7 8 9);
    match S::PROJECTS {
        Projecting::Dop853 => |rows, lanes| rows.by(&(lanes.dop853(), lanes.set), lanes),
        Projecting::Taylor => |rows, lanes| rows.by(&(lanes.taylor(), lanes.set), lanes),
        Projecting::Not => |rows, lanes| rows.by(&lanes.splits::<P, S>(X::FLOWS), lanes),
    }
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
    fn series<const W: usize>(&self, from: usize, bodies: usize) -> MaybeSeries;
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

    fn series<const W: usize>(&self, _: usize, bodies: usize) -> MaybeSeries {
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

    fn series<const W: usize>(&self, from: usize, bodies: usize) -> MaybeSeries {
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
