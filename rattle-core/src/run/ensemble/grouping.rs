//! Which trajectories are computed together, and in which kind of lanes. This follows from the types of scene, method
//! and precision, so that only the necessary kind is compiled, or gone through by the compiler.

use crate::effect::list::{Effects, Forces};
use crate::kernel::functions::{Constraint, Hamiltonian, PhaseConstraint, PhaseConstraintKernel};
use crate::methods::dop853::Dop853;
use crate::methods::taylor::Taylor;
use crate::motion::bodies::Count;
use crate::motion::hold::{Hold, Kind, PhaseSpaces, Surfaces};
use crate::motion::method::{Method, Projecting, Renewal, Splitting, Stage};
use crate::motion::state::State;
use crate::motion::table::{Table, Tabulated};
use crate::number::instructions::{Fusing, InstructionSet};
use crate::number::lanes::{Lane, Lanes};
use crate::number::vectors::{LANES, MOST_COORDINATES};
use crate::run::ensemble::apart::NotInLanes;
use crate::run::ensemble::collocation_lanes::CollocationLanes;
use crate::run::ensemble::group::Group;
use crate::run::ensemble::laws::{Each, Laws, Same};
use crate::run::ensemble::phase_lanes::{PhaseLanes, fits_lanes};
use crate::run::ensemble::phase_row::ROW as IN_PHASE_SPACE;
use crate::run::ensemble::precision::{InNumbers, Precision};
use crate::run::ensemble::projected_lanes::ProjectedLanes;
use crate::run::ensemble::renewed_lanes::RenewedLanes;
use crate::run::ensemble::side_by_side::side_by_side;
use crate::run::ensemble::splits::Splits;
use crate::run::ensemble::splitting_lanes::SplittingLanes;
use crate::run::ensemble::taylor_lanes::{InSeries, TaylorInLanes};
use std::marker::PhantomData;

/// Groups of trajectories in lanes, if they go in lanes.
pub(super) type Groups<const D: usize> = Option<Vec<Box<dyn Group<D>>>>;

/// How trajectories go in lanes.
#[derive(Debug)]
pub(super) struct HowInLanes {
    /// The stages of a step, of a splitting.
    pub(super) stages: Vec<Stage>,
    /// The step.
    pub(super) h: f64,
    /// After how many of them flows act; 0 where half of them act before a step and half after it.
    pub(super) stirs_after: usize,
    /// The instructions.
    pub(super) set: Fusing,
    /// The number of the first trajectory.
    pub(super) first: usize,
    /// The order of the method, and the tolerance of inner steps.
    pub(super) order: u32,
    pub(super) tolerance: Option<f64>,
    /// The momenta that each step draws.
    pub(super) renewal: Option<Renewal>,
}

impl HowInLanes {
    /// By this method, of which no step or stage may be shorter than this, with this instruction set.
    ///
    /// # Errors
    /// Where the instructions do not fuse, steps are too short, or the method is neither a splitting nor a collocation,
    /// nor one of those whose steps are projected.
    pub(super) fn of<S: Method>(method: &S, shortest: f64, set: InstructionSet) -> Result<Self, NotInLanes> {
        let fusing = Fusing::of(set).ok_or(NotInLanes::Instructions(set))?;
        let (stages, h, set) = (method.stages(), method.step_size(), fusing);
        let goes = match S::SPLITTING {
            Splitting::Not => S::COLLOCATES > 0 || S::PROJECTS != Projecting::Not || S::RENEWS,
            Splitting::OneStage => stages.len() == 1,
            Splitting::Stages => !stages.is_empty(),
        };
        if !goes {
            return Err(NotInLanes::Method(method.name()));
        }
        let is_long = |h: f64| h.abs() >= shortest;
        if !(is_long(h) && stages.iter().all(|stage| is_long(stage.h))) {
            return Err(NotInLanes::ShortSteps(h));
        }
        let (order, tolerance, stirs_after) = (method.order(), method.tolerance(), method.stirs_after());
        let renewal = method.renewal();
        Ok(Self { stages, h, stirs_after, set, first: 0, order, tolerance, renewal })
    }

    /// The method that these are, a splitting, as it moves rows, where flows act or do not.
    pub(super) fn splits<P: Precision, S: Method>(&self, flows: bool) -> Splits {
        if let Some(renewal) = self.renewal {
            return Splits::renewed(renewal, self.h, P::compute(Sums), self.set);
        }
        let equal = const { S::SPLITTING as u8 == Splitting::OneStage as u8 };
        let splits = Splits::new(&self.stages, self.h, equal && !flows, P::compute(Sums), self.set);
        if flows { splits.stirred(self.stirs_after) } else { splits }
    }

    /// The method that these are, where it is [`Dop853`].
    pub(super) fn dop853(&self) -> Dop853 {
        self.tolerance.map_or(Dop853::new(self.h), |tolerance| Dop853::adaptive(self.h, tolerance))
    }

    /// The same where it is [`Taylor`].
    pub(super) fn taylor(&self) -> Taylor {
        let Self { order, h, tolerance, .. } = *self;
        tolerance.map_or(Taylor::new(order, h), |tolerance| Taylor::adaptive(order, h, tolerance))
    }
}

/// Whether constraints are of a kind that the method moves in rows: a splitting, one that draws momenta anew, or, of
/// linked and rigid bodies, [`Dop853`](crate::methods::dop853::Dop853) and [`Taylor`](crate::methods::taylor::Taylor),
/// and of linked ones collocation.
pub(super) const fn goes_as<C: Hold<D>, S: Method, const D: usize>(kind: Kind) -> bool {
    let projects =
        matches!((kind, S::PROJECTS), (Kind::Network | Kind::Rigid, Projecting::Dop853 | Projecting::Taylor));
    let collocates = matches!(kind, Kind::Network) && S::COLLOCATES > 0;
    C::KIND as u8 == kind as u8
        && (!matches!(S::SPLITTING, Splitting::Not) || S::RENEWS || projects || collocates)
}

/// Shown the surface, puts trajectories of one scene in lanes of the kind that a method wants, if it wants one.
pub(super) struct Alike<'a, W, E, const D: usize>(
    pub(super) PhantomData<W>,
    pub(super) &'a E,
    pub(super) &'a [State<D>],
    pub(super) &'a HowInLanes,
);

impl<P: Precision, S: Method, E: Effects<D>, const D: usize> Surfaces<D> for Alike<'_, (P, S), E, D> {
    type Found = Groups<D>;

    fn found<C: Constraint<D, 1> + 'static>(self, surfaces: &[&C]) -> Self::Found {
        let Self(_, effects, starts, lanes) = self;
        grouped::<P, S, _, D>(&OneScene(surfaces[0], effects), starts, lanes)
    }
}

/// The same, each in a scene of its own.
pub(super) struct Different<'a, W, E, const D: usize>(
    pub(super) PhantomData<W>,
    pub(super) &'a [&'a E],
    pub(super) &'a [State<D>],
    pub(super) &'a HowInLanes,
);

impl<P: Precision, S: Method, E: Effects<D> + 'static, const D: usize> Surfaces<D>
    for Different<'_, (P, S), E, D>
{
    type Found = Groups<D>;

    fn found<C: Constraint<D, 1> + 'static>(self, surfaces: &[&C]) -> Self::Found {
        let Self(_, effects, starts, lanes) = self;
        grouped::<P, S, _, D>(&ManyScenes(surfaces, effects), starts, lanes)
    }
}

/// What trajectories obey.
trait Obeyed<const D: usize> {
    /// Whether a single trajectory has lanes made for one. In a sweep they would have to be compiled for the last row
    /// alone.
    const ALIKE: bool;
    /// Whether there are flows of momenta.
    const FLOWS: bool;
    /// Laws of L lanes.
    type Laws<S: Lane, const L: usize>: Laws<S, D> + 'static;

    /// Those of the trajectories from this one on.
    fn laws<S: Lane, const L: usize>(&self, from: usize) -> Self::Laws<S, L>;

    /// The same as functions of L numbers at once.
    type Series<S: Lane, const L: usize>: InSeries<S, L, D>;
    /// Those of the trajectories from this one on.
    fn series<S: Lane, const L: usize>(&self, from: usize) -> Self::Series<S, L>;
}

/// One scene.
struct OneScene<'a, C, E>(&'a C, &'a E);

impl<C: Constraint<D, 1>, E: Effects<D>, const D: usize> Obeyed<D> for OneScene<'_, C, E> {
    const ALIKE: bool = true;
    const FLOWS: bool = E::Forces::<f64>::FLOWS > 0;
    type Laws<S: Lane, const L: usize> = Same<C::Kernel<S>, E::Forces<S>>;

    fn laws<S: Lane, const L: usize>(&self, _: usize) -> Self::Laws<S, L> {
        Same(self.0.kernel(), self.1.forces())
    }

    type Series<S: Lane, const L: usize> = Same<C::Kernel<Lanes<S, L>>, E::Forces<Lanes<S, L>>>;

    fn series<S: Lane, const L: usize>(&self, _: usize) -> Self::Series<S, L> {
        Same(self.0.kernel(), self.1.forces())
    }
}

/// Scenes of one type, each of a trajectory of its own.
struct ManyScenes<'a, C, E>(&'a [&'a C], &'a [&'a E]);

impl<C: Constraint<D, 1> + 'static, E: Effects<D> + 'static, const D: usize> Obeyed<D>
    for ManyScenes<'_, C, E>
{
    const ALIKE: bool = false;
    const FLOWS: bool = E::Forces::<f64>::FLOWS > 0;
    type Laws<S: Lane, const L: usize> = Each<C, E, S, L, D>;

    fn laws<S: Lane, const L: usize>(&self, from: usize) -> Self::Laws<S, L> {
        let number = |lane: usize| if from + lane < self.0.len() { from + lane } else { from }; // the rest copies the first
        Each::new(|lane| (self.0[number(lane)], self.1[number(lane)]))
    }

    type Series<S: Lane, const L: usize> = Each<C, E, S, L, D>;

    fn series<S: Lane, const L: usize>(&self, from: usize) -> Self::Series<S, L> {
        Obeyed::<D>::laws::<S, L>(self, from)
    }
}

/// Puts trajectories, no more than there are lanes, in lanes of the kind that the method wants.
fn grouped<P: Precision, S: Method, O: Obeyed<D>, const D: usize>(
    obeyed: &O,
    starts: &[State<D>],
    lanes: &HowInLanes,
) -> Groups<D> {
    let wanted = const { wanted::<P, S, O, D>() };
    wanted(obeyed, starts, lanes)
}

/// Who puts trajectories in the lanes that the method wants; to be a constant, see
/// [`grouping_kinds`](crate::run::ensemble::grouping_kinds).
const fn wanted<P: Precision, S: Method, O: Obeyed<D>, const D: usize>()
-> fn(&O, &[State<D>], &HowInLanes) -> Groups<D> {
    macro_rules! by_stages {
        ($($stages:literal)*) => {$(
            if S::COLLOCATES == $stages && D <= MOST_COORDINATES && !O::FLOWS {
                return |obeyed, starts, lanes| {
                    P::compute(Collocations::<O, $stages, D>(obeyed, starts, lanes))
                };
            }
        )*};
    }
    // Between steps with flows the kicks are not merged, also where a step is one stage.
    if go_in_lanes::<S>(Splitting::OneStage, D) && !O::FLOWS {
        return |obeyed, starts, lanes| Some(P::compute(Splittings::<O, true, D>(obeyed, starts, lanes)));
    }
    if go_in_lanes::<S>(Splitting::OneStage, D) || go_in_lanes::<S>(Splitting::Stages, D) {
        return |obeyed, starts, lanes| Some(P::compute(Splittings::<O, false, D>(obeyed, starts, lanes)));
    }
    by_stages!(2 3 4 5 6 7 8 9);
    if D > MOST_COORDINATES || O::FLOWS {
        return |_, _, _| None;
    }
    if S::RENEWS {
        return |obeyed, starts, lanes| P::compute(Renewals::<O, D>(obeyed, starts, lanes));
    }
    match S::PROJECTS {
        Projecting::Dop853 => |obeyed, starts, lanes| P::compute(Projections::<O, D>(obeyed, starts, lanes)),
        Projecting::Taylor => |obeyed, starts, lanes| P::compute(Expansions::<O, D>(obeyed, starts, lanes)),
        Projecting::Not => |_, _, _| None,
    }
}

/// Whether a method goes in lanes made for splittings of this kind.
const fn go_in_lanes<S: Method>(kind: Splitting, coordinates: usize) -> bool {
    coordinates <= MOST_COORDINATES && S::SPLITTING as u8 == kind as u8
}

/// Shown constraints and Hamiltonians, puts so many bodies of each trajectory in rows: those of one scene, or each in a
/// scene of its own.
pub(super) struct InRows<'a, N, const D: usize>(
    pub(super) N,
    pub(super) &'a [State<D>],
    pub(super) &'a HowInLanes,
);

impl<N: Count, const D: usize> PhaseSpaces<D> for InRows<'_, N, D> {
    type Found = Groups<D>;

    fn found<G, H, const M: usize>(self, spaces: &[(&G, &H)]) -> Groups<D>
    where
        G: PhaseConstraint<D, M> + 'static,
        H: Hamiltonian<D> + 'static,
    {
        let Self(count, starts, HowInLanes { stages, h, set, first, .. }) = self;
        // Rows are not looked at for kinks.
        let goes = const { fits_lanes::<D, M>() && G::Kernel::<f64>::KINKS.is_empty() };
        if !goes || starts.iter().any(|start| start.len() != count.number()) {
            return None;
        }
        in_rows(IN_PHASE_SPACE, starts, &|from, starts| {
            let own = if spaces.len() == 1 { 0..1 } else { from..from + starts.len() };
            let engine = PhaseLanes::new(&spaces[own], count, stages, *h, *set);
            Some(side_by_side(Box::new(engine), first + from, starts))
        })
    }
}

/// Whether sums are compensated.
struct Sums;

impl InNumbers for Sums {
    type Done = bool;

    fn compute<S: Lane, const SUMS: usize>(self) -> bool {
        SUMS > 0
    }
}

/// Makes a row of the trajectories from this number on that start so.
type RowOf<'a, const D: usize> = dyn Fn(usize, &[State<D>]) -> Option<Box<dyn Group<D>>> + 'a;

/// Trajectories in rows of so many, each made from the number of its first, counted from these, and its starts.
#[inline(never)]
pub(super) fn in_rows<const D: usize>(width: usize, starts: &[State<D>], row: &RowOf<'_, D>) -> Groups<D> {
    (0..).step_by(width).zip(starts.chunks(width)).map(|(from, starts)| row(from, starts)).collect()
}

/// Trajectories by splittings; `EQUAL` says that a step is one stage, and has no flows before or after it.
struct Splittings<'a, O, const EQUAL: bool, const D: usize>(&'a O, &'a [State<D>], &'a HowInLanes);

impl<O: Obeyed<D>, const EQUAL: bool, const D: usize> InNumbers for Splittings<'_, O, EQUAL, D> {
    type Done = Vec<Box<dyn Group<D>>>;

    fn compute<S: Lane, const SUMS: usize>(self) -> Self::Done {
        let Self(obeyed, starts, HowInLanes { stages, h, stirs_after, set, first, .. }) = self;
        if const { O::ALIKE } && starts.len() == 1 {
            let laws = obeyed.laws::<S, 1>(0);
            let engine = SplittingLanes::<S, _, 1, D, SUMS, EQUAL>::new(laws, stages, *stirs_after, *h, *set);
            return vec![side_by_side(Box::new(engine), *first, starts)];
        }
        let laws = obeyed.laws::<S, LANES>(0);
        let engine = SplittingLanes::<S, _, LANES, D, SUMS, EQUAL>::new(laws, stages, *stirs_after, *h, *set);
        vec![side_by_side(Box::new(engine), *first, starts)]
    }
}

/// Trajectories by steps that draw momenta anew.
struct Renewals<'a, O, const D: usize>(&'a O, &'a [State<D>], &'a HowInLanes);

impl<O: Obeyed<D>, const D: usize> InNumbers for Renewals<'_, O, D> {
    type Done = Groups<D>;

    fn compute<S: Lane, const SUMS: usize>(self) -> Self::Done {
        let Self(obeyed, starts, &HowInLanes { h, set, first, renewal, .. }) = self;
        if const { O::ALIKE } && starts.len() == 1 {
            let engine = RenewedLanes::<S, _, 1, D, SUMS>::new(obeyed.laws::<S, 1>(0), renewal?, h, set);
            return Some(vec![side_by_side(Box::new(engine), first, starts)]);
        }
        let laws = obeyed.laws::<S, LANES>(0);
        let engine = RenewedLanes::<S, _, LANES, D, SUMS>::new(laws, renewal?, h, set);
        Some(vec![side_by_side(Box::new(engine), first, starts)])
    }
}

/// Trajectories in a row of those that are moved by collocation.
const OF_STAGES: usize = 16;

/// Trajectories by collocation of N stages.
struct Collocations<'a, O, const N: usize, const D: usize>(&'a O, &'a [State<D>], &'a HowInLanes);

impl<O: Obeyed<D>, const N: usize, const D: usize> InNumbers for Collocations<'_, O, N, D>
where
    Table<N>: Tabulated,
{
    type Done = Groups<D>;

    fn compute<S: Lane, const SUMS: usize>(self) -> Self::Done {
        let Self(obeyed, starts, HowInLanes { h, set, first, .. }) = self;
        in_rows(OF_STAGES, starts, &|from, starts| {
            let table = const { &Table::<N>::TABLE };
            if const { O::ALIKE } && starts.len() == 1 {
                let laws = obeyed.laws::<S, 1>(from);
                let engine = CollocationLanes::<S, _, 1, D, SUMS, N>::new(laws, table, *h, *set);
                return Some(side_by_side(Box::new(engine), first + from, starts));
            }
            let laws = obeyed.laws::<S, OF_STAGES>(from);
            let engine = CollocationLanes::<S, _, OF_STAGES, D, SUMS, N>::new(laws, table, *h, *set);
            Some(side_by_side(Box::new(engine), first + from, starts))
        })
    }
}

/// Trajectories by steps that are projected onto the constraint. A single one too has a row of that width: lanes made
/// for one would have to be compiled beside it.
struct Projections<'a, O, const D: usize>(&'a O, &'a [State<D>], &'a HowInLanes);

impl<O: Obeyed<D>, const D: usize> InNumbers for Projections<'_, O, D> {
    type Done = Groups<D>;

    fn compute<S: Lane, const SUMS: usize>(self) -> Self::Done {
        let Self(obeyed, starts, lanes) = self;
        let (HowInLanes { set, first, .. }, method) = (lanes, lanes.dop853());
        in_rows(OF_STAGES, starts, &|from, starts| {
            let laws = obeyed.laws::<S, OF_STAGES>(from);
            let engine = ProjectedLanes::<S, _, OF_STAGES, D, SUMS, _>::new(laws, method, *set);
            Some(side_by_side(Box::new(engine), first + from, starts))
        })
    }
}

/// Trajectories in a row of those that are moved by power series: as many as the widest registers hold.
const OF_SERIES: usize = 8;

/// Trajectories by power series, whose sums are projected onto the constraint.
struct Expansions<'a, O, const D: usize>(&'a O, &'a [State<D>], &'a HowInLanes);

impl<O: Obeyed<D>, const D: usize> InNumbers for Expansions<'_, O, D> {
    type Done = Groups<D>;

    fn compute<S: Lane, const SUMS: usize>(self) -> Self::Done {
        let Self(obeyed, starts, lanes) = self;
        let (HowInLanes { set, first, .. }, method) = (lanes, lanes.taylor());
        in_rows(OF_SERIES, starts, &|from, starts| {
            let laws = obeyed.laws::<S, OF_SERIES>(from);
            let method = TaylorInLanes::new(method, obeyed.series::<S, OF_SERIES>(from))?;
            let engine = ProjectedLanes::<S, _, OF_SERIES, D, SUMS, _>::new(laws, method, *set);
            Some(side_by_side(Box::new(engine), first + from, starts))
        })
    }
}
