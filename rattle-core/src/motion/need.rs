//! The capabilities that a method needs of a system, as a type: [`Method::Need`](crate::motion::method::Method::Need).
//!
//! Needs are checked before a run. A step gets the capabilities that its method needs, and no others. Needs are
//! combined in tuples.

use crate::motion::iteration::{Iteration, Kind, Newton};
use crate::motion::system::System;
use crate::number::real::Scalar;
use std::marker::PhantomData;

/// The capabilities that a method needs of a system.
pub trait Need: 'static {
    /// What a step gets: a reference to the system, or to a capability of it.
    type Of<'a, T: Scalar, Y: System<T, D>, const D: usize>: Copy;

    /// What a step gets of this system.
    ///
    /// # Errors
    /// Where the system lacks the capability: the kind of system, in words for the error message.
    fn of<T: Scalar, Y: System<T, D>, const D: usize>(
        system: &Y,
    ) -> Result<Self::Of<'_, T, Y, D>, &'static str>;
}

/// Steps of RATTLE, with the position equation solved by `X`. Every system has those with [`Newton`].
#[derive(Debug)]
pub struct Steps<X = Newton>(PhantomData<X>);

/// Separate kicks and drifts, in any order. Every system with [rates](System::rates) has them.
#[derive(Debug)]
pub struct Kicks;

/// Momenta that are mass times velocity, and constraints and forces that do not depend on time.
#[derive(Debug)]
pub struct Differences;

/// Separate kicks and drifts, with constraints and forces that do not depend on time.
#[derive(Debug)]
pub struct Still;

/// [`Rates`](crate::motion::capability::Rates).
#[derive(Debug)]
pub struct WithRates;

/// [`Collocation`](crate::motion::capability::Collocation).
#[derive(Debug)]
pub struct WithCollocation;

/// [`Series`](crate::motion::capability::Series).
#[derive(Debug)]
pub struct WithSeries;

macro_rules! need {
    ($need:ty $(, $X:ident)?: $of:ty, |$system:ident| $met:expr) => {
        impl$(<$X: Iteration>)? Need for $need {
            type Of<'a, T: Scalar, Y: System<T, D>, const D: usize> = &'a $of;

            #[inline(always)]
            fn of<T: Scalar, Y: System<T, D>, const D: usize>($system: &Y) -> Result<&$of, &'static str> {
                $met
            }
        }
    };
}

need!(Steps<X>, X: Y, |system| {
    if X::KIND == Kind::Newton || system.is_cartesian() { Ok(system) } else { Err(system.kind()) }
});
need!(Kicks: Y, |system| system.rates().map(|_| system));
need!(Still: Y, |system| {
    if system.moves_with_time() { Err("constraints or forces that change with time") } else { system.rates().map(|_| system) }
});
need!(Differences: Y, |system| {
    match (system.is_cartesian(), system.moves_with_time()) {
        (true, false) => Ok(system),
        (true, true) => Err("constraints or forces that change with time"),
        (false, _) => Err(system.kind()),
    }
});
need!(WithRates: Y::Rates, |system| system.rates());
need!(WithCollocation: Y::Collocation, |system| system.collocation());
need!(WithSeries: Y::Series, |system| system.series());

impl<A: Need, B: Need> Need for (A, B) {
    type Of<'a, T: Scalar, Y: System<T, D>, const D: usize> = (A::Of<'a, T, Y, D>, B::Of<'a, T, Y, D>);

    #[inline(always)]
    fn of<T: Scalar, Y: System<T, D>, const D: usize>(
        system: &Y,
    ) -> Result<Self::Of<'_, T, Y, D>, &'static str> {
        Ok((A::of(system)?, B::of(system)?))
    }
}

impl<A: Need, B: Need, C: Need> Need for (A, B, C) {
    type Of<'a, T: Scalar, Y: System<T, D>, const D: usize> =
        (A::Of<'a, T, Y, D>, B::Of<'a, T, Y, D>, C::Of<'a, T, Y, D>);

    #[inline(always)]
    fn of<T: Scalar, Y: System<T, D>, const D: usize>(
        system: &Y,
    ) -> Result<Self::Of<'_, T, Y, D>, &'static str> {
        Ok((A::of(system)?, B::of(system)?, C::of(system)?))
    }
}
