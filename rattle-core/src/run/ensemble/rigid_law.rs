//! What trajectories of rigid bodies obey.

use crate::number::lanes::{Fused, Lanes};
use crate::run::ensemble::forces_in_lanes::Pulls;
use crate::run::ensemble::rigid_row::{Attitude, Inertia, RigidRow};
use crate::systems::rigid::Rigid;
use std::array::from_fn;
use std::sync::Arc;

/// Systems of rigid bodies, and the same of their lanes: moments of inertia, and effects on rows of B.
#[derive(Clone)]
pub(super) struct RigidLaws<Y, B: Attitude<W>, const W: usize> {
    /// One for all lanes, or one for each.
    systems: Arc<[Y]>,
    /// Which of them each lane obeys.
    system: [usize; W],
    pub(super) inertia: Inertia<W>,
    pub(super) pulls: Option<Box<dyn Pulls<RigidRow<B>, W>>>,
}

impl<Y, B: Attitude<W>, const W: usize> RigidLaws<Y, B, W> {
    /// One system and its body for all lanes, or one for each; lanes beyond them obey the first.
    pub(super) fn new(
        systems: Arc<[Y]>,
        rigid: &[&Rigid],
        pulls: Option<Box<dyn Pulls<RigidRow<B>, W>>>,
    ) -> Self {
        let of = |lane: usize| if lane < rigid.len() { lane } else { 0 };
        let mut inertia = rigid[0].moments().map(|x| Lanes([Fused(x); W]));
        for lane in 0..W {
            inertia.put(lane, &rigid[of(lane)].moments().map(Fused));
        }
        let system = from_fn(|lane| if lane < systems.len() { lane } else { 0 });
        Self { systems, system, inertia, pulls }
    }

    /// The system that a lane obeys.
    pub(super) fn system(&self, lane: usize) -> &Y {
        &self.systems[self.system[lane]]
    }

    /// How many systems there are, and which of them a lane obeys.
    pub(super) fn number_of_system(&self, lane: usize) -> [usize; 2] {
        [self.systems.len(), self.system[lane]]
    }

    /// Has lane `to` obey what lane `from` does.
    pub(super) fn copy(&mut self, from: usize, to: usize) {
        self.system[to] = self.system[from];
        let moments = self.inertia.lane(from);
        self.inertia.put(to, &moments);
        if let Some(pulls) = &mut self.pulls {
            pulls.copy(from, to);
        }
    }
}
