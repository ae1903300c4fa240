//! Steps in lanes with flows of momenta, and when it is asked whether other sheets are near.

use crate::effect::list::Forces;
use crate::kernel::functions::ConstraintKernel;
use crate::number::instructions::{Fusing, Work};
use crate::number::lanes::Lane;
use crate::number::vector::{add_scaled, dot, sum, two_sum};
use crate::number::vectors::{at, put};
use crate::run::ensemble::around::LookingAround;
use crate::run::ensemble::block::{Block, Part, Scratch};
use crate::run::ensemble::engine::Stuck;
use crate::run::ensemble::laws::Laws;
use crate::run::ensemble::loops::step;
use crate::run::ensemble::rhythm::{InRhythm, When};
use crate::run::ensemble::stirring::{Asking, Stirred, Stirring};
use std::array::from_fn;
use std::borrow::Borrow;

/// What stirs lanes, the kick before a step where flows act before that, the instructions, and the account of each
/// lane.
pub(super) struct Stirs<'a, S, const L: usize, const D: usize> {
    pub(super) stirring: &'a Stirring<S, L, D>,
    pub(super) kick: f64,
    pub(super) set: Fusing,
    pub(super) work: &'a mut [f64; L],
    pub(super) limits: &'a mut [f64; L],
}

/// It is asked at once whether other sheets are near where flows have made a momentum so many times as large as that
/// for which it was asked: it was asked as far ahead as twice that leads.
pub(super) const LARGER: f64 = 1.5;

/// The work of flows after which it is asked at once, where the work is this and the momentum that, or to be expected
/// to be no less.
#[inline(always)]
pub(super) fn limit<S: Lane, const D: usize>(work: f64, p: &[S; D], least: f64) -> f64 {
    work + 0.5 * (LARGER * LARGER - 1.0) * dot(p, p).to_f64().max(least * least)
}

/// Asks whether other sheets are near all lanes, after so many steps, and sets their [limits](limit).
#[inline(always)]
pub(super) fn look_around<S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>(
    block: &Block<S, L, D, SUMS, EQUAL>,
    laws: &X,
    parts: &[Part],
    stirs: Option<&mut Stirs<'_, S, L, D>>,
    steps: u64,
) -> Result<(), Stuck>
where
    S: Lane,
    X: Laws<S, D>,
{
    let lanes = &[true; L];
    if const { X::Forces::FLOWS > 0 }
        && let Some(stirs) = stirs
    {
        let least = &|lane| stirs.stirring.momentum(lane);
        LookingAround { block, laws, parts, steps, lanes, least }.run()?;
        stirs.set_limits(block, lanes);
        return Ok(());
    }
    LookingAround { block, laws, parts, steps, lanes, least: &|_| 0.0 }.run()
}

impl<S: Lane, const L: usize, const D: usize> Stirs<'_, S, L, D> {
    /// Sets the limits of these lanes.
    #[inline(always)]
    fn set_limits<const SUMS: usize, const EQUAL: bool>(
        &mut self,
        block: &Block<S, L, D, SUMS, EQUAL>,
        lanes: &[bool; L],
    ) {
        for l in (0..L).filter(|&l| lanes[l]) {
            self.limits[l] = limit(self.work[l], &at(&block.way, l), self.stirring.momentum(l));
        }
    }
}

/// Asks whether other sheets are near these lanes, at as many places as at first: work of its own, for what is seldom
/// asked. It works on copies: what others can reach is read from memory again in each step.
#[inline(always)]
pub(super) fn look_apart<S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>(
    set: Fusing,
    block: &Block<S, L, D, SUMS, EQUAL>,
    laws: &X,
    parts: &[Part],
    lanes: &[bool; L],
    least: &dyn Fn(usize) -> f64,
) -> Result<(), Stuck>
where
    S: Lane,
    X: Laws<S, D>,
{
    let (block, laws) = (&block.clone(), &laws.clone());
    set.run_lanes::<L, _>(LookingAround { block, laws, parts, steps: 0, lanes, least })
}

/// A step of a block with flows.
pub(super) struct Stepping<'a, 'b, S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>
{
    pub(super) block: &'a mut Block<S, L, D, SUMS, EQUAL>,
    pub(super) scratch: &'a mut Scratch<S, L, D>,
    pub(super) laws: &'a X,
    pub(super) parts: &'a [Part],
    pub(super) stirs: &'a mut Stirs<'b, S, L, D>,
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>
    Stepping<'_, '_, S, X, L, D, SUMS, EQUAL>
where
    S: Lane,
    X: Laws<S, D>,
{
    /// Asks at once whether other sheets are near, at as many places as at first, for lanes where the work of flows is
    /// beyond its limit; for no others, so that what becomes of a lane depends on that lane alone.
    #[inline(always)]
    fn heed(&mut self) -> Result<(), Stuck> {
        let Self { block, laws, parts, stirs, .. } = self;
        let within = |l: usize| stirs.work[l] <= stirs.limits[l]; // not where it is no number
        let mut all = true;
        for l in 0..L {
            all &= within(l);
        }
        if all {
            return Ok(());
        }
        let beyond = from_fn(|l| !within(l));
        let least = |lane| stirs.stirring.momentum(lane);
        look_apart(stirs.set, block, *laws, parts, &beyond, &least)?;
        stirs.set_limits(block, &beyond);
        Ok(())
    }
}

impl<S, X, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool> InRhythm
    for Stepping<'_, '_, S, X, L, D, SUMS, EQUAL>
where
    S: Lane,
    X: Laws<S, D>,
{
    #[inline(always)]
    fn act(&mut self, when: When) -> Result<(), Stuck> {
        let (Block { q, normal, square, way: p, way_low, .. }, laws) = (&mut *self.block, self.laws);
        let Stirs { stirring, set, ref mut work, .. } = *self.stirs;
        let mut lost = [[S::default(); L]; D];
        let low = way_low.first_mut().unwrap_or(&mut lost);
        let stirred = Stirred { q, normal, square, p, low, work };
        let acted = stirring.act(set, when, stirred, &mut |question, changes| {
            set.run_lanes::<L, _>(Asking { laws, stirring, question, changes });
        });
        acted.map_err(|lane| Stuck { lane, failure: None })
    }

    #[inline(always)]
    fn lead(&mut self) -> Result<(), Stuck> {
        lead(self.block, self.laws, &self.parts[0], self.stirs.kick);
        self.heed()
    }

    #[inline(always)]
    fn advance(&mut self, _: usize, _: u64) -> Result<(), Stuck> {
        step(self.block, self.laws, self.parts, self.scratch)
    }

    #[inline(always)]
    fn guess(&mut self, part: usize) -> Result<(), Stuck> {
        lead(self.block, self.laws, &self.parts[part], 0.0);
        self.heed()
    }
}

/// Kicks all lanes for so long before the part of a step that is to come, and makes a first guess for that from g̈ = 0:
/// what flows have changed is not extrapolated.
#[inline(always)]
pub(super) fn lead<S, const L: usize, const D: usize, const SUMS: usize, const EQUAL: bool>(
    block: &mut Block<S, L, D, SUMS, EQUAL>,
    laws: &impl Laws<S, D>,
    part: &Part,
    kick: f64,
) where
    S: Lane,
{
    let Block { q, way, normal, square, guess, past: [last, earlier], way_low, .. } = block;
    let [bends, before] = [-0.5 * (part.h / part.unit).powi(2), part.before].map(S::from_f64);
    let kicks = kick != 0.0;
    for l in 0..L {
        let (q, n, old) = (at(q, l), at(normal, l), at(way, l));
        let mut new = old;
        if kicks {
            let low = if const { SUMS == 1 } { at(&way_low[0], l) } else { [S::default(); D] };
            let change = laws.kick(l, &q, S::from_f64(kick), low);
            let change = add_scaled(&change, -dot(&n, &sum(&old, &change)) / square[l], &n);
            let (high, low) = two_sum(&old, &change);
            new = high;
            if const { SUMS == 1 } {
                put(&mut way_low[0], l, low);
            }
            put(way, l, new);
        }
        let [bend] = laws.constraint(l).borrow().jet(&q, &new).2;
        guess[l] = bends * bend / square[l];
        (last[l], earlier[l]) = (before * guess[l], before * guess[l]);
    }
}
