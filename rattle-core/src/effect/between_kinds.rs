//! Potentials between every two bodies, by their kinds.

use crate::effect::laws::ByKind;
use crate::effect::moment::Moment;
use crate::effect::near;
use crate::effect::one::{Acting, Effect};
use crate::error::{Error, PairMistake, refuse_nan};
use crate::kernel::functions::{PairKernel, PairPotential};
use crate::kernel::kinds::Kinds;
use crate::kernel::space::Open;
use crate::number::lanes::Lane;
use crate::number::real::Real;

/// The kind of effect of [`Kinds`] of a [`PairPotential`]: between every two bodies, by their kinds, at any distance.
#[derive(Debug, Clone, Copy)]
pub struct BetweenKinds;

/// Potentials between every two bodies by their kinds, over a scalar.
#[derive(Debug, Clone)]
pub struct ActsBetweenKinds<L>(L);

impl<P: PairPotential, const D: usize> Effect<D, BetweenKinds> for Kinds<P> {
    type Acting<T: Real> = ActsBetweenKinds<ByKind<T, P::Kernel<T>>>;
    fn acting<T: Real>(&self) -> Self::Acting<T> {
        ActsBetweenKinds(ByKind::new(&self.of, self.square(P::kernel)))
    }

    type Swept<S: Lane, const L: usize> = [Self::Acting<S>; L];

    fn check(&self, what: &'static str, bodies: usize) -> Result<(), Error> {
        self.check_kinds(what, bodies)?;
        refuse_nan(what, self.table.iter().find_map(P::nan_parameter))
    }
}

impl<P> Kinds<P> {
    /// Says what is wrong with the table or the kinds.
    pub(super) fn check_kinds(&self, what: &'static str, bodies: usize) -> Result<(), Error> {
        let size = self.table.len();
        let mistake = match self.kinds() {
            None | Some(0) => PairMistake::Table { what, size },
            Some(kinds) => match self.of.iter().position(|&kind| kind >= kinds) {
                _ if self.of.len() != bodies => PairMistake::KindCount { what, kinds: self.of.len(), bodies },
                Some(body) => PairMistake::NoSuchKind { what, body, kind: self.of[body], kinds },
                None => return Ok(()),
            },
        };
        Err(Error::Pairs(mistake))
    }
}

impl<T: Real, K: PairKernel<T>, const D: usize> Acting<T, D> for ActsBetweenKinds<ByKind<T, K>> {
    type Room = ();
    fn room(&self, _: usize) {}

    fn add_forces(&self, at: Moment<'_, T, D>, (): &mut (), forces: &mut [[T; D]]) {
        near::push_all(&self.0, &Open, at.positions, forces);
    }
    fn energy(&self, at: Moment<'_, T, D>) -> T {
        near::energy_of_all(&self.0, &Open, at.positions)
    }
}
