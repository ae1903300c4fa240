//! Readings of a lane outside of its steps: energies, forces, constraints, and the values that identify its scene in a
//! checkpoint.

use crate::effect::force::Force;
use crate::effect::list::Forces;
use crate::effect::moment::Moment;
use crate::kernel::functions::ConstraintKernel;
use crate::motion::record::Hallmark;
use crate::number::instructions::Work;
use crate::number::lanes::Lane;
use crate::number::vector::{dot, scaled, sum};
use crate::number::vectors::{Vectors, at, put};
use crate::run::ensemble::laws::Laws;
use crate::run::fingerprint::{AT_ITS_PLACES, BESIDE, Looks, of_effect, tell};
use crate::run::watch::sight::Sight;
use crate::systems::surface::normal::{Normal, multiplier_from_curvature};
use nalgebra::SVector;
use std::borrow::Borrow;
use std::hint::black_box;

/// A vector as lanes have it.
fn own<S: Lane, const D: usize>(x: SVector<f64, D>) -> [S; D] {
    <[f64; D]>::from(x).map(S::from_f64)
}

/// Numbers of lanes as others have them.
#[inline(never)]
pub(super) fn numbers<S: Lane>(x: &[S]) -> Vec<f64> {
    x.iter().map(|x| x.to_f64()).collect()
}

/// The names of the types of all forces.
pub(super) fn forces<S: Lane, X: Laws<S, D>, const D: usize>(laws: &X) -> Vec<&'static str> {
    let (effects, mut force) = (laws.effects(0), [[S::from_f64(0.0); D]]);
    let (effects, q) = (effects.borrow(), [[S::from_f64(0.0); D]]);
    let at = Moment { time: 0.0, positions: &q };
    let mut names = Vec::new();
    for number in 0..X::Forces::EFFECTS {
        names.extend(effects.contribute_alone(number, at, &mut effects.room(1), &mut force));
    }
    names
}

/// What tells what a lane obeys from other laws, asked there and beside the time 0; momenta are what laws make of them.
pub(super) fn hallmarks<S: Lane, X: Laws<S, D>, const D: usize, const SUMS: usize>(
    laws: &X,
    lane: usize,
    looks: &Looks<D>,
) -> Vec<Hallmark> {
    let (constraint, effects) = (laws.constraint(lane), laws.effects(lane));
    let effects = effects.borrow();
    let mut marks = vec![of_precision::<S, SUMS>()];
    let mut places = [Vec::new(), Vec::new()];
    for (there, q) in places.iter_mut().zip(looks.first()) {
        let q = [q.map(S::from_f64)];
        let ([g], [gradient]) = constraint.borrow().value_and_jacobian(&q[0]);
        let constraints = [&numbers(&[g])[..], &numbers(&gradient)];
        there.push(Hallmark::of_vectors("constraints", "a surface", &constraints));
        let (at, mut room) = (Moment { time: BESIDE, positions: &q }, effects.room(1));
        for number in 0..X::Forces::EFFECTS {
            let mut force = [[S::default(); D]];
            let name = effects.contribute_alone(number, at, &mut room, &mut force);
            there.push(of_effect(number, name, numbers(force.as_flattened()).as_chunks::<D>().0));
        }
        there.push(Hallmark::new("potential energy", "a function", numbers(&[effects.energy(at)])));
    }
    let [near, at] = places;
    marks.extend(near);
    tell(at, AT_ITS_PLACES, &mut marks);
    marks
}

/// In which numbers lanes are computed.
fn of_precision<S: Lane, const SUMS: usize>() -> Hallmark {
    let precision = match (S::from_f64(1.0 + f64::EPSILON).to_f64() == 1.0, SUMS) {
        (true, _) => "single precision",
        (false, 0) => "double precision",
        (false, _) => "compensated sums",
    };
    Hallmark::of_parameters("precision", precision, Vec::new()).later()
}

/// What a sight asks of a body that obeys what a lane does: where, when and as it is shown.
pub(super) trait Answers<S: Lane, const D: usize>: Laws<S, D> {
    /// Potential energy.
    fn potential(&self, lane: usize, sight: &Sight<'_, D>) -> f64 {
        let at = Moment { time: sight.time, positions: &[own(sight.position())] };
        self.effects(lane).borrow().energy(at).to_f64()
    }

    /// U of each effect.
    fn effect_energies(&self, lane: usize, sight: &Sight<'_, D>) -> Vec<f64> {
        let mut energies = Vec::new();
        let at = Moment { time: sight.time, positions: &[own(sight.position())] };
        self.effects(lane).borrow().energies(at, &mut energies);
        numbers(&energies)
    }

    /// g.
    fn residual(&self, lane: usize, sight: &Sight<'_, D>) -> f64 {
        let [g] = self.constraint(lane).borrow().value(&own(sight.position()));
        g.to_f64()
    }

    /// The multiplier and the force of the constraint.
    fn constraints(&self, lane: usize, sight: &Sight<'_, D>) -> (Vec<f64>, Vec<SVector<f64, D>>) {
        let (lambda, [constraint, _]) = forces_there(self, lane, sight);
        (vec![lambda.to_f64()], vec![constraint.map(|x| x.to_f64()).into()])
    }

    /// q̇ and ṗ.
    fn rates(&self, lane: usize, sight: &Sight<'_, D>) -> [Vec<SVector<f64, D>>; 2] {
        let (_, [constraint, force]) = forces_there(self, lane, sight);
        [vec![sight.momentum()], vec![sum(&constraint, &force).map(|x| x.to_f64()).into()]]
    }
}

impl<S: Lane, X: Laws<S, D>, const D: usize> Answers<S, D> for X {}

/// The multiplier, the force of the constraint, and that of effects.
fn forces_there<S: Lane, const D: usize>(
    laws: &impl Laws<S, D>,
    lane: usize,
    sight: &Sight<'_, D>,
) -> (S, [[S; D]; 2]) {
    let (constraint, effects) = (laws.constraint(lane), laws.effects(lane));
    let (q, p): ([S; D], [S; D]) = (own(sight.position()), own(sight.momentum()));
    let ([gradient], [bend]) = (constraint.borrow().jacobian(&q), constraint.borrow().jet(&q, &p).2);
    let (normal, mut force) = (Normal::new(gradient), [Force::zero()]);
    let (at, effects) = (Moment { time: sight.time, positions: &[q] }, effects.borrow());
    effects.evaluate(at, &mut effects.room(1), &mut force);
    let lambda = multiplier_from_curvature(bend, force[0].dot(&gradient, S::from_f64(1.0)), &normal);
    (lambda, [scaled(lambda, &gradient), force[0].components()])
}

/// |p|².
#[inline(never)]
pub(super) fn square<const D: usize>(sight: &Sight<'_, D>) -> f64 {
    let p: [f64; D] = sight.momentum().into();
    dot(&p, &p)
}

/// Has an engine answer what a sight asks by its laws, those of one body on a surface; beside the number of lanes, of
/// coordinates and of sums, this constant is the last parameter of its type, or this type is.
macro_rules! answered_by_laws {
    ($engine:ident) => {
        answered_by_laws!(@$engine, [],);
    };
    ($engine:ident, $last:ident: $kind:ty) => {
        answered_by_laws!(@$engine, [const $last: $kind], $last);
    };
    ($engine:ident, type $last:ident) => {
        answered_by_laws!(@$engine, [$last], $last);
    };
    (@$engine:ident, [$($parameter:tt)*], $($last:ident)?) => {
        use $crate::run::ensemble::asked::Answers as _;

        impl<S, X, const L: usize, const D: usize, const SUMS: usize, $($parameter)*>
            $crate::run::watch::sight::Source<D> for $engine<S, X, L, D, SUMS, $($last)?>
        where
            S: $crate::number::lanes::Lane,
            X: $crate::run::ensemble::laws::Laws<S, D>,
        {
            fn energies(&self, lane: usize, sight: &$crate::run::watch::Sight<'_, D>) -> [f64; 2] {
                let kinetic = 0.5 * $crate::run::ensemble::asked::square(sight);
                [kinetic, self.laws.potential(lane, sight)]
            }

            fn constraints(
                &self,
                lane: usize,
                sight: &$crate::run::watch::Sight<'_, D>,
            ) -> (Vec<f64>, Vec<nalgebra::SVector<f64, D>>) {
                self.laws.constraints(lane, sight)
            }

            fn rates(
                &self,
                lane: usize,
                sight: &$crate::run::watch::Sight<'_, D>,
            ) -> [Vec<nalgebra::SVector<f64, D>>; 2] {
                self.laws.rates(lane, sight)
            }

            fn effect_energies(&self, lane: usize, sight: &$crate::run::watch::Sight<'_, D>) -> Vec<f64> {
                self.laws.effect_energies(lane, sight)
            }

            fn residuals(&self, lane: usize, sight: &$crate::run::watch::Sight<'_, D>) -> Vec<f64> {
                vec![self.laws.residual(lane, sight)]
            }

            fn temperature(&self, _: usize, sight: &$crate::run::watch::Sight<'_, D>) -> f64 {
                $crate::run::answers::heat_of_each(0.5 * $crate::run::ensemble::asked::square(sight), D - 1)
            }

            fn mass_product(&self, _: usize, _: usize, a: &[f64; D], b: &[f64; D]) -> f64 {
                a.iter().zip(b).map(|(a, b)| a * b).sum()
            }

            fn step_size(&self) -> f64 {
                self.h
            }
        }
    };
}
pub(super) use answered_by_laws;

/// Kicks of all lanes where they are: what forces cost.
pub(super) struct Kicking<'a, S, X, const L: usize, const D: usize> {
    pub(super) q: &'a Vectors<S, L, D>,
    pub(super) way: Vectors<S, L, D>,
    pub(super) laws: &'a X,
    pub(super) kicks: u32,
}

impl<S: Lane, X: Laws<S, D>, const L: usize, const D: usize> Work for Kicking<'_, S, X, L, D> {
    type Done = Vectors<S, L, D>;

    #[inline(always)]
    fn run(self) -> Vectors<S, L, D> {
        let Self { q, mut way, laws, kicks } = self;
        let laws = laws.clone();
        for _ in 0..kicks {
            let q = *black_box(q);
            for lane in 0..L {
                let kicked = laws.kick(lane, &at(&q, lane), S::from_f64(1e-9), at(&way, lane));
                put(&mut way, lane, kicked);
            }
        }
        way
    }
}
