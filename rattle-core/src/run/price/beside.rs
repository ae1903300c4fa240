//! Trajectories that go side by side in lanes, priced as one of them.

use crate::effect::list::Effects;
use crate::error::{Error, PriceMistake};
use crate::methods::composition::Composition;
use crate::methods::dop853::Dop853;
use crate::methods::lobatto::Lobatto;
use crate::methods::rattle::Rattle;
use crate::methods::taylor::Taylor;
use crate::motion::bodies::Count;
use crate::motion::guess::Extrapolated;
use crate::motion::hold::{Hold, Kind};
use crate::motion::state::State;
use crate::run::ensemble::precision::{Compensated, Double, Single};
use crate::run::ensemble::trajectories::Ensemble;
use crate::run::price::candidate::{Candidate, Numbers, TAYLOR};
use crate::run::price::moving::{Moving, Rung};
use crate::run::watch::seen::Seen;
use crate::scene::Scene;

/// The starts of all trajectories, the priced one first, and what makes an ensemble of them: only who asks for lanes
/// has it compiled.
pub(super) struct Beside<C, E, N, const D: usize> {
    pub(super) starts: Vec<State<D>>,
    pub(super) make: Make<C, E, N, D>,
}

type Make<C, E, N, const D: usize> =
    fn(&Scene<C, E, N, D>, &[State<D>], Rung, Numbers) -> Result<Ensemble<D>, Error>;

/// The ensemble of a method with steps of `h`, and the tolerance if the method has one.
///
/// Numbers are double where [`Candidate::LANES`] names no others, so that lanes of no others are compiled.
pub(super) fn ensemble<C: Hold<D> + 'static, E: Effects<D>, N: Count, const D: usize>(
    scene: &Scene<C, E, N, D>,
    starts: &[State<D>],
    Rung { candidate, h, tolerance }: Rung,
    numbers: Numbers,
) -> Result<Ensemble<D>, Error> {
    let starts = starts.iter().cloned();
    match (candidate, numbers) {
        (Candidate::Rattle, Numbers::Single) if const { on_surfaces::<C, D>() } => {
            scene.ensemble_in(Single, starts, Rattle::new(h))
        }
        (Candidate::Rattle, Numbers::Single | Numbers::Double) => {
            scene.ensemble_in(Double, starts, Rattle::new(h))
        }
        (Candidate::Rattle, Numbers::Compensated) => scene.ensemble_in(Compensated, starts, Rattle::new(h)),
        (Candidate::Composition(coefficients), _) => {
            scene.ensemble(starts, Composition::new(coefficients, h))
        }
        // What does not go side by side is not compiled.
        _ if const { matches!(C::KIND, Kind::Phase) } => Err(Error::Price(PriceMistake::OneByOne)),
        (Candidate::Dop853, _) => scene.ensemble(starts, Dop853::adaptive(h, tolerance)),
        (Candidate::Taylor, _) => scene.ensemble(starts, Taylor::adaptive(TAYLOR, h, tolerance)),
        _ if const { matches!(C::KIND, Kind::Rigid) } => Err(Error::Price(PriceMistake::OneByOne)),
        (Candidate::Lobatto3, _) => scene.ensemble(starts, Lobatto::<3>::new(h).guess(Extrapolated)),
        (Candidate::Lobatto5, _) => scene.ensemble(starts, Lobatto::<5>::new(h).guess(Extrapolated)),
        (Candidate::Lobatto8, _) => scene.ensemble(starts, Lobatto::<8>::new(h).guess(Extrapolated)),
        _ => Err(Error::Price(PriceMistake::OneByOne)),
    }
}

/// Whether these constraints are surfaces: others go by fewer methods, and in double precision.
const fn on_surfaces<C: Hold<D>, const D: usize>() -> bool {
    matches!(C::KIND, Kind::Other)
}

impl<C: Hold<D>, E: Effects<D>, N: Count, const D: usize> Beside<C, E, N, D> {
    /// Trajectories in lanes, from their starts; the energy of the first is `energy` before it is rounded.
    pub(super) fn begin<'a>(
        &'a self,
        scene: &'a Scene<C, E, N, D>,
        rung: Rung,
        numbers: Numbers,
        energy: f64,
    ) -> Result<Box<dyn Moving + 'a>, Error> {
        let ensemble = (self.make)(scene, &self.starts, rung, numbers)?;
        if ensemble.groups.iter().all(|group| group.len() == 1) {
            return Err(Error::Price(PriceMistake::OneByOne));
        }
        if numbers == Numbers::Single && !on_surfaces::<C, D>() {
            return Err(Error::Price(PriceMistake::AlwaysDouble));
        }
        let again = move || self.begin(scene, rung, numbers, energy);
        Ok(Box::new(FirstOfEnsemble { ensemble, energy, again: Box::new(again) }))
    }
}

/// An ensemble of which the first trajectory is looked at, and what makes it anew.
struct FirstOfEnsemble<'a, const D: usize> {
    ensemble: Ensemble<D>,
    energy: f64,
    again: Box<dyn Fn() -> Result<Box<dyn Moving + 'a>, Error> + 'a>,
}

impl<const D: usize> Moving for FirstOfEnsemble<'_, D> {
    fn again(&self) -> Result<Box<dyn Moving + '_>, Error> {
        (self.again)()
    }
    /// On one thread, since what one core takes is asked.
    fn run(&mut self, steps: u64) -> Result<(), Error> {
        self.ensemble.groups.iter_mut().for_each(|group| group.run(steps, None));
        self.ensemble.failures().next().map_or(Ok(()), |(_, error)| Err(error.clone()))
    }
    fn positions(&self) -> Vec<f64> {
        self.ensemble.state(0).positions().flat_map(<[f64; D]>::from).collect()
    }
    fn largest_momentum(&self) -> f64 {
        self.ensemble.state(0).momenta().map(|p| p.amax()).fold(0.0, f64::max)
    }
    fn energy(&self) -> f64 {
        let group = &self.ensemble.groups[0];
        let now = Seen::new(0, group.len(), group.bodies(), |page| group.look(page));
        now.sights(group.source(), 0).next().map_or(f64::NAN, |first| first.energy())
    }
    fn energy_error(&self) -> f64 {
        self.energy() - self.energy - self.ensemble.work(0)
    }
}
