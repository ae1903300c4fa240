//! Where a row of rigid bodies stands at the start of an inner step, and how a method tells where such a step leads
//! regardless of what makes attitudes rotations. What becomes of that is the same for all
//! ([`rigid_projected`](crate::run::ensemble::rigid_projected)).

use crate::motion::method::Method;
use crate::number::instructions::{Fusing, Work};
use crate::number::vector::sum;
use crate::run::ensemble::forces_in_lanes::Pulling;
use crate::run::ensemble::pace::Pace;
use crate::run::ensemble::rigid_row::{Inertia, Nine, RigidRow, Three};
use crate::run::ensemble::track::{State, Track};
use crate::systems::network::in_lanes::{Numbers, at, put, zeros};
use crate::systems::rigid::rotation::{Moments, cross};
use std::array::from_fn;

/// Trajectories in a row: as many as the nearer cache holds the stages of.
pub(super) const ROW: usize = 16;

/// Coordinates of a body: its attitude by rows, and its momentum.
pub(super) const COORDINATES: [usize; 2] = [9, 3];

/// Effects that turn bodies, if any do.
pub(super) type Pulls<'a, 'b> = Option<&'a mut (dyn Pulling<RigidRow<Nine<ROW>>, ROW> + 'b)>;

/// A method whose steps are projected, in rows of rigid bodies.
pub(super) trait Departs {
    /// Puts on trial where inner steps of all lanes lead regardless of what makes attitudes rotations. Says how long
    /// these steps are and whether they are taken.
    fn depart(&mut self, stand: &mut Stand<'_>, pulling: &mut Pulls<'_, '_>);

    /// Has lanes go by themselves in which rates of momenta on trial are not those that the method knows.
    fn compare(&mut self, _: &mut Stand<'_>) {}
}

/// Where the bodies of a row are.
pub(super) struct Stand<'a> {
    pub(super) inertia: &'a Inertia<ROW>,
    pub(super) set: Fusing,
    pub(super) pace: Pace<ROW>,
    /// Attitudes and momenta; and their rates there, once they have been evaluated.
    pub(super) tracks: [Track<ROW>; 2],
    pub(super) there: bool,
    pub(super) rates: [Vec<Numbers<ROW>>; 2],
    /// The same on trial, at a stage or at the end of an inner step; and what rounding takes from both at that end.
    pub(super) trial: State<ROW>,
    pub(super) rates_there: [Vec<Numbers<ROW>>; 2],
    torques: Vec<Three<ROW>>,
}

impl<'a> Stand<'a> {
    /// For so many bodies, and steps of this method.
    pub(super) fn new(inertia: &'a Inertia<ROW>, bodies: usize, method: &impl Method, set: Fusing) -> Self {
        let rows = |i: usize| vec![zeros::<ROW>(); COORDINATES[i] * bodies];
        Self {
            inertia,
            set,
            pace: Pace::new(method),
            tracks: COORDINATES.map(|own| Track::new(own * bodies)),
            there: false,
            rates: from_fn(rows),
            trial: from_fn(|i| rows(i % 2)),
            rates_there: from_fn(rows),
            torques: vec![[zeros(); 3]; bodies],
        }
    }

    /// How many bodies there are.
    pub(super) fn bodies(&self) -> usize {
        self.torques.len()
    }

    /// Rates where all bodies are.
    #[inline(always)]
    pub(super) fn be_there(&mut self, pulling: &mut Pulls<'_, '_>) {
        let Self { trial: [q, m, ..], tracks: [attitudes, momenta], .. } = self;
        q.copy_from_slice(&attitudes.now);
        m.copy_from_slice(&momenta.now);
        self.respond(pulling);
        self.there = true;
        self.rates.iter_mut().zip(&self.rates_there).for_each(|(to, from)| to.copy_from_slice(from));
    }

    /// Rates on trial.
    #[inline(always)]
    pub(super) fn respond(&mut self, pulling: &mut Pulls<'_, '_>) {
        self.set.run(Respond { stand: self, pulling });
    }
}

/// See [`Stand::respond`].
struct Respond<'a, 'b, 'c, 'd> {
    stand: &'a mut Stand<'b>,
    pulling: &'a mut Pulls<'c, 'd>,
}

impl Work for Respond<'_, '_, '_, '_> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { stand, pulling } = self;
        let Stand { inertia, set, trial: [q, m, ..], rates_there: [turned, pushed], torques, .. } = stand;
        let q = q.as_chunks::<9>().0;
        if let Some(pulling) = pulling {
            pulling.pull(*set, 1.0, (q, torques));
        }
        let rates = turned.as_chunks_mut().0.iter_mut().zip(pushed.as_chunks_mut().0);
        for ((q, m), (torque, (turned, pushed))) in
            q.iter().zip(m.as_chunks().0).zip(torques.iter().zip(rates))
        {
            rates_of(inertia, q, m, torque, turned, pushed);
        }
    }
}

/// Q̇ and ṁ of a body.
#[inline(always)]
fn rates_of<const W: usize>(
    inertia: &Inertia<W>,
    q: &Nine<W>,
    m: &Three<W>,
    torque: &Three<W>,
    turned: &mut Nine<W>,
    pushed: &mut Three<W>,
) {
    for l in 0..W {
        let (moments, q) = (inertia.lane(l), at(q, l));
        let rate = moments.rate(&at(m, l));
        put(pushed, l, sum(&moments.gyration(&Moments::others(&rate)), &at(torque, l)));
        let row = |i: usize| cross(&from_fn(|j| q[3 * i + j]), &rate);
        let rows = [row(0), row(1), row(2)];
        put(turned, l, from_fn(|k| rows[k / 3][k % 3]));
    }
}
