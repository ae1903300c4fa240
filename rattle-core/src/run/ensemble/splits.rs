//! Splittings into kicks and drifts, as lanes carry them out.

use crate::motion::method::{Renewal, Stage};
use crate::motion::record::Hallmark;
use crate::number::instructions::Fusing;
use crate::run::ensemble::block::Part;

/// A splitting, as it moves rows of linked and of rigid bodies.
#[derive(Clone)]
pub(super) struct Splits {
    pub(super) stages: Vec<Stage>,
    pub(super) parts: Vec<Part>,
    pub(super) h: f64,
    /// Whether all steps are equal: a step of the method is one stage.
    pub(super) equal: bool,
    /// Whether sums are compensated.
    pub(super) sums: bool,
    pub(super) set: Fusing,
    /// After how many parts flows act, if there are any; after none half before each step and half after it. And the
    /// kick that follows the half before.
    pub(super) stirs_after: usize,
    pub(super) stirred_kick: f64,
    /// The momenta that each step draws instead, if it does.
    pub(super) renewal: Option<Renewal>,
}

impl Splits {
    pub(super) fn new(stages: &[Stage], h: f64, equal: bool, sums: bool, set: Fusing) -> Self {
        let parts = if equal { Part::of::<true>(stages) } else { Part::of::<false>(stages) };
        let stages = stages.to_vec();
        Self { stages, parts, h, equal, sums, set, stirs_after: 0, stirred_kick: 0.0, renewal: None }
    }

    /// A step that draws momenta anew.
    pub(super) fn renewed(renewal: Renewal, h: f64, sums: bool, set: Fusing) -> Self {
        let stage = Stage { before: renewal.kick, h, after: 0.0 };
        Self { renewal: Some(renewal), ..Self::new(&[stage], h, false, sums, set).stirred(0) }
    }

    /// The same where flows act after so many stages. Where half of them act before each step, momenta are ahead by no
    /// kick.
    pub(super) fn stirred(self, stirs_after: usize) -> Self {
        if stirs_after > 0 {
            return Self { stirs_after, ..self };
        }
        let parts = Part::of::<false>(&without_first_kick(&self.stages));
        Self { parts, stirred_kick: self.stages[0].before, ..self }
    }

    pub(super) fn hallmark(&self) -> Hallmark {
        self.renewal
            .map_or_else(|| hallmark(&self.stages, self.stirs_after), |renewal| of_renewal(renewal, self.h))
    }
}

/// These stages, each of them backwards: those of a step of −h, of a symmetric method.
pub(super) fn backwards(stages: &[Stage]) -> Vec<Stage> {
    let back = |&Stage { before, h, after }: &Stage| Stage { before: -before, h: -h, after: -after };
    stages.iter().map(back).collect()
}

/// What tells a splitting from others: its stages, and after how many of them flows act, if not around them all.
pub(super) fn hallmark(stages: &[Stage], stirs_after: usize) -> Hallmark {
    let mut numbers = Stage::numbers(stages);
    numbers.extend((stirs_after > 0).then_some(stirs_after as f64));
    Hallmark::of_parameters("method", "a splitting", numbers)
}

/// What tells a method that draws these momenta anew from others.
pub(super) fn of_renewal(renewal: Renewal, h: f64) -> Hallmark {
    let numbers = [&[h], &renewal.numbers()[..]].concat();
    Hallmark::of_parameters("method", "momenta drawn anew", numbers)
}

/// These stages, of which the first has no kick before it.
pub(super) fn without_first_kick(stages: &[Stage]) -> Vec<Stage> {
    let mut stages = stages.to_vec();
    stages[0].before = 0.0;
    stages
}
