//! Who is told the multipliers of a step.

/// Is told the multipliers as a step finds them; `()` does not listen, and then they are not formed.
pub trait Witness<T> {
    /// Whether multipliers are formed at all.
    const LISTENS: bool = true;

    /// λ of the position equation with this number: on surfaces, that of the body. A composition tells that of each
    /// of its steps, the last one last; a collocation method λ(t) at the start of the step, to its order.
    fn position_multiplier(&mut self, equation: usize, lambda: T);
    /// μ of the momentum equation; of a collocation method λ(t) at the end of the step.
    fn momentum_multiplier(&mut self, equation: usize, mu: T);
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
}

impl<T, W: Witness<T>> Hears<T> for W {
    fn position_multiplier(&mut self, equation: usize, lambda: T) {
        Witness::position_multiplier(self, equation, lambda);
    }
    fn momentum_multiplier(&mut self, equation: usize, mu: T) {
        Witness::momentum_multiplier(self, equation, mu);
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
