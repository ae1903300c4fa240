//! Pair potentials by the kinds of the two bodies.

use crate::kernel::space::{Open, Periodic};
use crate::kernel::within::Within;

/// Bodies of several kinds (species), and a potential for every two kinds. The potentials have one type, each with its
/// own parameters.
///
/// ```
/// use rattle::potentials::LennardJones;
/// use rattle::prelude::*;
///
/// let (sigma, kinds) = ([1.0, 0.8], [0, 0, 1]); // two large bodies and a small one
/// let mixed = |a: usize, b: usize| LennardJones { epsilon: 1.0, sigma: (sigma[a] + sigma[b]) / 2.0 };
///
/// let mixture = Kinds::mixed(kinds, |a, b| mixed(a, b).within(2.5 * mixed(a, b).sigma));
/// let scene = Scene::points(3).with(mixture);
/// let start = State::of([[0.0, 0.0], [1.2, 0.0], [0.5, 1.0]]);
/// let mut simulation = scene.simulate(start, Rattle::new(1e-3))?;
/// simulation.run(100)?;
/// assert!(simulation.energy_error().abs() < 1e-4);
/// # Ok::<(), rattle::Error>(())
/// ```
#[doc(alias = "species")]
#[doc(alias = "atom types")]
#[doc(alias = "mixing rule")]
#[derive(Debug, Clone, PartialEq)]
pub struct Kinds<P> {
    pub(crate) of: Vec<usize>,
    /// Of kinds (0, 0), (1, 0), (1, 1), (2, 0), …
    pub(crate) table: Vec<P>,
}

/// A number of kinds that is larger is taken for a mistake, such as −1 as a `usize`: the table grows with its square.
const MOST_KINDS: usize = 1024;

impl<P> Kinds<P> {
    /// Bodies of these kinds, counted from 0, and the potentials between kinds (0, 0), (1, 0), (1, 1), (2, 0), (2, 1),
    /// (2, 2), … in one list: k (k + 1)/2 of them for k kinds. [`mixed`](Self::mixed) makes them by a rule.
    ///
    /// A table of another size, a kind that is not in it, and a number of kinds that is not the number of bodies are
    /// errors when a run is set up.
    pub fn new(kind_of_each: impl IntoIterator<Item = usize>, table: impl IntoIterator<Item = P>) -> Self {
        Self { of: kind_of_each.into_iter().collect(), table: table.into_iter().collect() }
    }

    /// Bodies of these kinds, counted from 0, and the potential `between(a, b)` for every two kinds b ≤ a, such as a
    /// mixing rule. There are at most 1024 kinds: a larger number is an error when a run is set up.
    pub fn mixed(
        kind_of_each: impl IntoIterator<Item = usize>,
        mut between: impl FnMut(usize, usize) -> P,
    ) -> Self {
        let of: Vec<usize> = kind_of_each.into_iter().collect();
        let kinds = of.iter().max().map_or(0, |&last| last.min(MOST_KINDS - 1) + 1);
        let table = (0..kinds).flat_map(|a| (0..=a).map(move |b| (a, b))).map(|(a, b)| between(a, b));
        Self { table: table.collect(), of }
    }

    /// How many kinds a table of this size is for, if for any.
    pub(crate) fn kinds(&self) -> Option<usize> {
        let size = self.table.len();
        let kinds = (2.0 * size as f64).sqrt() as usize;
        (kinds * (kinds + 1) / 2 == size).then_some(kinds)
    }

    /// The potentials of all ordered pairs of kinds, row by row.
    pub(crate) fn square<X>(&self, made: impl Fn(&P) -> X) -> Vec<X> {
        let kinds = self.kinds().unwrap_or(0);
        let place = |a: usize, b: usize| a.max(b) * (a.max(b) + 1) / 2 + a.min(b);
        (0..kinds)
            .flat_map(|a| (0..kinds).map(move |b| place(a, b)))
            .map(|at| made(&self.table[at]))
            .collect()
    }
}

impl<P, B> Kinds<Within<P, B>> {
    /// The same with this [skin](Within::skin) for all.
    #[must_use]
    pub fn skin(self, skin: f64) -> Self {
        Self { of: self.of, table: self.table.into_iter().map(|within| within.skin(skin)).collect() }
    }
}

impl<P> Kinds<Within<P, Open>> {
    /// The same in a periodic box with these lengths: see [`Within::periodic`].
    #[must_use]
    pub fn periodic<const D: usize>(self, periods: [f64; D]) -> Kinds<Within<P, Periodic<D>>> {
        Kinds { of: self.of, table: self.table.into_iter().map(|within| within.periodic(periods)).collect() }
    }
}
