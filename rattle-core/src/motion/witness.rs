//! Receivers of the multipliers of a step.

/// Receives the multipliers as a step computes them. With `()` they are not computed.
pub trait Witness<T> {
    /// Whether multipliers are computed at all.
    const LISTENS: bool = true;

    /// λ of position equation number `equation`; on surfaces, equation i belongs to body i. A composition reports λ of
    /// each of its inner steps in order; a collocation method of S stages reports λ(t) at the start of the step, to
    /// order S − 1. `Sight::multipliers` has λ(t) of each state to the order of the method.
    fn position_multiplier(&mut self, equation: usize, lambda: T);
    /// μ of the momentum equation; for a collocation method, λ(t) at the end of the step, to order S − 1.
    fn momentum_multiplier(&mut self, equation: usize, mu: T);

    /// Called where a simulation makes a step, or a part of it, once more: what was told since the last
    /// [`keep`](Self::keep), or since the step began, does not stand.
    #[inline(always)]
    fn forget(&mut self) {}
    /// What was told stands, whatever becomes of the rest of the step.
    #[inline(always)]
    fn keep(&mut self) {}
    /// The step is taken.
    #[inline(always)]
    fn taken(&mut self) {}
}

impl<T> Witness<T> for () {
    const LISTENS: bool = false;

    #[inline(always)]
    fn position_multiplier(&mut self, _: usize, _: T) {}
    #[inline(always)]
    fn momentum_multiplier(&mut self, _: usize, _: T) {}
}

/// Tells λ as that of the end of a step.
pub(crate) struct AtEnd<'a, W>(pub(crate) &'a mut W);

impl<T, W: Witness<T>> Witness<T> for AtEnd<'_, W> {
    const LISTENS: bool = W::LISTENS;

    fn position_multiplier(&mut self, equation: usize, lambda: T) {
        self.0.momentum_multiplier(equation, lambda);
    }
    fn momentum_multiplier(&mut self, _: usize, _: T) {}
}

/// What a witness is told, whichever it is.
pub(crate) trait Hears<T> {
    fn position_multiplier(&mut self, equation: usize, lambda: T);
    fn momentum_multiplier(&mut self, equation: usize, mu: T);
    fn forget(&mut self);
    fn keep(&mut self);
}

impl<T, W: Witness<T>> Hears<T> for W {
    fn position_multiplier(&mut self, equation: usize, lambda: T) {
        Witness::position_multiplier(self, equation, lambda);
    }
    fn momentum_multiplier(&mut self, equation: usize, mu: T) {
        Witness::momentum_multiplier(self, equation, mu);
    }
    fn forget(&mut self) {
        Witness::forget(self);
    }
    fn keep(&mut self) {
        Witness::keep(self);
    }
}

/// Any witness, for steps that are compiled once for all.
pub(crate) struct Whoever<'a, T>(pub(crate) &'a mut dyn Hears<T>);

impl<T> Witness<T> for Whoever<'_, T> {
    fn position_multiplier(&mut self, equation: usize, lambda: T) {
        self.0.position_multiplier(equation, lambda);
    }
    fn momentum_multiplier(&mut self, equation: usize, mu: T) {
        self.0.momentum_multiplier(equation, mu);
    }
}
