//! What trajectories of linked bodies obey, as power series for a few lanes at a time.

use crate::run::ensemble::linked_law::LinkedLaws;
use crate::run::ensemble::linked_plan::runs;
use crate::run::ensemble::series_in_lanes::PullsInSeries;
use crate::systems::network::group::LinkGroup;
use crate::systems::network::in_lanes::FEW;
use crate::systems::network::series_in_lanes::{LinkSeries, Run};
use std::sync::Arc;

/// Links and effects.
#[derive(Clone)]
pub(super) struct SeriesLaws {
    /// Links of all kinds: of all lanes, or of each few.
    links: Vec<Vec<Arc<dyn LinkSeries>>>,
    /// For each kind its runs, and the blocks of products that they take.
    pub(super) kinds: Vec<(Vec<Run>, usize)>,
    pub(super) pulls: Option<Box<dyn PullsInSeries>>,
}

impl SeriesLaws {
    /// What these lanes obey, under these effects; none where a function has no series.
    pub(super) fn of<F, const D: usize, const W: usize>(
        laws: &LinkedLaws<F, D, W>,
        pulls: Option<Box<dyn PullsInSeries>>,
    ) -> Option<Self> {
        let shape = &laws.laws[0].system.shape;
        let fews = if laws.laws.len() == 1 { 1 } else { W / FEW };
        let links = (0..fews).map(|few| links_of(laws, few)).collect::<Option<Vec<_>>>()?;
        let kind = |(number, links): (usize, &Arc<dyn LinkSeries>)| {
            let runs = runs(shape, number);
            let runs: Vec<Run> = runs.into_iter().map(|(members, _, entry)| (members, entry)).collect();
            let blocks = links.blocks(&runs)?;
            Some((runs, blocks))
        };
        let kinds = links[0].iter().enumerate().map(kind).collect::<Option<Vec<_>>>()?;
        Some(Self { links, kinds, pulls })
    }

    /// The links of these few lanes, kind by kind.
    pub(super) fn links(&self, few: usize) -> &[Arc<dyn LinkSeries>] {
        &self.links[few.min(self.links.len() - 1)]
    }

    /// Has lane `to` obey what lane `from` does, where these laws have it so already.
    pub(super) fn copy<F, const D: usize, const W: usize>(
        &mut self,
        laws: &LinkedLaws<F, D, W>,
        from: usize,
        to: usize,
    ) {
        if let Some(links) = links_of(laws, to / FEW) {
            self.links[to / FEW] = links;
        }
        if let Some(pulls) = &mut self.pulls {
            pulls.copy(from, to);
        }
    }
}

/// The links that these few lanes obey, kind by kind.
fn links_of<F, const D: usize, const W: usize>(
    laws: &LinkedLaws<F, D, W>,
    few: usize,
) -> Option<Vec<Arc<dyn LinkSeries>>> {
    let own = if laws.laws.len() == 1 { &laws.laws[..] } else { &laws.laws[few * FEW..(few + 1) * FEW] };
    let kinds = 0..own[0].system.shape.groups.len();
    kinds
        .map(|number| {
            let groups: Vec<&dyn LinkGroup<D>> =
                own.iter().map(|law| &*law.system.shape.groups[number]).collect();
            groups[0].in_series(&groups)
        })
        .collect()
}
