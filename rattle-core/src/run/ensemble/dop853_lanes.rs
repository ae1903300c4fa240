//! The stages of [`Dop853`] for trajectories in lanes.

use crate::effect::list::Forces;
use crate::kernel::functions::ConstraintKernel;
use crate::methods::dop853::Dop853;
use crate::methods::dop853_table::{ERROR_3, ERROR_5, STAGES, STEPS, WEIGHTS};
use crate::motion::bodies::One;
use crate::motion::failure::Failure;
use crate::motion::method::Method;
use crate::number::lanes::Lane;
use crate::number::vectors::{Vectors, at, put};
use crate::run::ensemble::dop853_row::{add_square, combine, error, fit, length, reach};
use crate::run::ensemble::laws::Laws;
use crate::run::ensemble::projected::{Projects, least_tolerance, look_for_kinks};
use crate::run::ensemble::projected_row::Place;
use crate::run::ensemble::row::pull;
use crate::systems::surface::kept::{BodiesOf, OnSurface, OneByOne};
use std::borrow::Borrow;

/// Rates of places and momenta at the stages, and where a stage is.
pub(crate) struct Stages<S, const L: usize, const D: usize> {
    v: [Vectors<S, L, D>; STAGES],
    f: [Vectors<S, L, D>; STAGES],
    q: Vectors<S, L, D>,
}

impl<S: Lane, const L: usize, const D: usize> Projects<S, L, D> for Dop853 {
    type Method = Self;
    type Room = Stages<S, L, D>;

    fn method(&self) -> &Self {
        self
    }

    fn room(&self) -> Stages<S, L, D> {
        let zero = [[S::default(); L]; D];
        Stages { v: [zero; STAGES], f: [zero; STAGES], q: zero }
    }

    fn evaluations(&self) -> u32 {
        STAGES as u32
    }

    #[inline(always)]
    fn sum<const SUMS: usize>(
        &self,
        laws: &impl Laws<S, D>,
        now: &Place<S, L, D>,
        left: &[S; L],
        inner: &mut [S; L],
        next: &mut [S; L],
        taken: &mut [bool; L],
        [way, change]: [&mut Vectors<S, L, D>; 2],
        room: &mut Stages<S, L, D>,
    ) {
        let Stages { v, f, q } = room;
        for l in 0..L {
            inner[l] = S::select(left[l].abs().le(inner[l].abs()), left[l], inner[l]);
        }
        (v[0], f[0]) = (now.p, now.pull);
        let mut beyond = [false; L];
        for stage in 1..STAGES {
            for d in 0..D {
                let low = [&now.q_low[d], &now.p_low[d]];
                let (mut x, mut y) = ([S::default(); L], [S::default(); L]);
                combine(STEPS[stage], |stage| &v[stage][d], &mut x);
                combine(STEPS[stage], |stage| &f[stage][d], &mut y);
                reach::<S, L, SUMS>(inner, &x, [&now.q[d], low[0]], &mut q[d]);
                reach::<S, L, SUMS>(inner, &y, [&now.p[d], low[1]], &mut v[stage][d]);
            }
            rates(laws, q, &v[stage], &mut f[stage]);
            look_for_kinks(laws, [&now.q, q], &mut beyond);
        }
        match self.tolerance() {
            None => {
                (*next, *taken) = (*inner, [true; L]);
                if beyond.contains(&true) {
                    leave(&beyond, next, taken);
                }
            }
            Some(tolerance) => {
                let (mut fifth, mut third) = ([S::default(); L], [S::default(); L]);
                let whole = S::from_f64(self.step_size().abs());
                of_rates(ERROR_5, whole, v, f, &mut fifth);
                of_rates(ERROR_3, whole, v, f, &mut third);
                let mut within = [S::from_f64(tolerance); L];
                for l in 0..L {
                    within[l] = within[l].max(least_tolerance(&at(&now.q, l)));
                }
                fit(&within, &error(&fifth, &third, inner), inner, next, taken);
            }
        }
        for d in 0..D {
            let (mut x, mut y) = ([S::default(); L], [S::default(); L]);
            combine(WEIGHTS, |stage| &v[stage][d], &mut x);
            combine(WEIGHTS, |stage| &f[stage][d], &mut y);
            for l in 0..L {
                (way[d][l], change[d][l]) = (inner[l] * x[l], inner[l] * y[l]);
            }
        }
    }

    fn by_itself<K: ConstraintKernel<S, D, 1>, F: Forces<S, D>>(
        &self,
        system: &OnSurface<K, F, One, OneByOne>,
        parts: u32,
        bodies: &mut BodiesOf<One, S, F, D>,
    ) -> Result<(), Failure> {
        let mut part = self.with_step(self.step_size() / f64::from(parts));
        if let Some(tolerance) = self.tolerance() {
            let tolerance = tolerance.max(least_tolerance(&bodies.q[0]).to_f64());
            part = Self::adaptive(part.step_size(), tolerance);
        }
        (0..parts).try_for_each(|_| {
            part.step::<S, OnSurface<K, F, One, OneByOne>, _, D>((system, system), bodies, &mut [], &mut ())
        })
    }
}

/// Has lanes go by themselves that have a stage beyond a kink: their inner step is not taken, and the next one none.
#[cold]
fn leave<S: Lane, const L: usize>(beyond: &[bool; L], next: &mut [S; L], taken: &mut [bool; L]) {
    for l in 0..L {
        taken[l] = !beyond[l];
        next[l] = S::select(beyond[l], S::default(), next[l]);
    }
}

/// f + ∇g λ at these places and momenta, with λ from g̈ = 0.
#[inline(always)]
fn rates<S: Lane, const L: usize, const D: usize>(
    laws: &impl Laws<S, D>,
    q: &Vectors<S, L, D>,
    p: &Vectors<S, L, D>,
    to: &mut Vectors<S, L, D>,
) {
    for l in 0..L {
        let (q, p) = (at(q, l), at(p, l));
        let [gradient] = laws.constraint(l).borrow().jacobian(&q);
        put(to, l, pull(laws, l, &q, &p, &gradient).1);
    }
}

/// The [`length`] of all lanes with these weights.
#[inline(always)]
fn of_rates<S: Lane, const L: usize, const D: usize>(
    weights: &[(usize, f64)],
    whole: S,
    v: &[Vectors<S, L, D>; STAGES],
    f: &[Vectors<S, L, D>; STAGES],
    to: &mut [S; L],
) {
    let (mut places, mut momenta) = ([S::default(); L], [S::default(); L]);
    for d in 0..D {
        let (mut x, mut y) = ([S::default(); L], [S::default(); L]);
        combine(weights, |stage| &v[stage][d], &mut x);
        combine(weights, |stage| &f[stage][d], &mut y);
        add_square(&x, &mut places);
        add_square(&y, &mut momenta);
    }
    length(whole, &places, &momenta, to);
}
