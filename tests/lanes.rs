//! The stepper over several lanes: the same step source, every lane bit for bit its own scalar run.

mod common;
use common::*;
use rattle::bodies::{Body, One};
use rattle::prelude::*;
use rattle::real::{Mask, Real};
use std::array::from_fn;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Four numbers side by side.
#[derive(Debug, Clone, Copy)]
struct Four([f64; 4]);

#[derive(Debug, Clone, Copy)]
struct FourBits([bool; 4]);

impl Mask for FourBits {
    fn all(self) -> bool {
        self.0 == [true; 4]
    }
    fn and(self, other: Self) -> Self {
        Self(from_fn(|i| self.0[i] & other.0[i]))
    }
    fn or(self, other: Self) -> Self {
        Self(from_fn(|i| self.0[i] | other.0[i]))
    }
    fn not(self) -> Self {
        Self(self.0.map(|bit| !bit))
    }
    fn lanes(self) -> impl Iterator<Item = bool> {
        self.0.into_iter()
    }
}

macro_rules! lane_operators {
    ($($operator:ident $method:ident)*) => {
        $(impl $operator for Four {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                Self(from_fn(|i| self.0[i].$method(other.0[i])))
            }
        })*
    };
}
lane_operators!(Add add Sub sub Mul mul Div div);

impl Neg for Four {
    type Output = Self;
    fn neg(self) -> Self {
        Self(self.0.map(Neg::neg))
    }
}

macro_rules! lane_functions {
    ($($name:ident)*) => {
        $(fn $name(self) -> Self {
            Self(self.0.map(Real::$name))
        })*
    };
}

impl Real for Four {
    type Mask = FourBits;
    fn from_f64(x: f64) -> Self {
        Self([x; 4])
    }
    fn lanes(self) -> impl Iterator<Item = f64> {
        self.0.into_iter()
    }
    fn lt(self, other: Self) -> FourBits {
        FourBits(from_fn(|i| self.0[i] < other.0[i]))
    }
    fn le(self, other: Self) -> FourBits {
        FourBits(from_fn(|i| self.0[i] <= other.0[i]))
    }
    fn select(mask: FourBits, a: Self, b: Self) -> Self {
        Self(from_fn(|i| if mask.0[i] { a.0[i] } else { b.0[i] }))
    }
    lane_functions!(abs sign sqrt cbrt exp ln log10 log2 sin cos tan asin acos atan sinh cosh tanh asinh acosh
        atanh erf);
    fn sin_cos(self) -> (Self, Self) {
        (self.sin(), self.cos())
    }
    fn powf(self, exponent: Self) -> Self {
        Self(from_fn(|i| self.0[i].powf(exponent.0[i])))
    }
    fn atan2(self, x: Self) -> Self {
        Self(from_fn(|i| self.0[i].atan2(x.0[i])))
    }
    fn hypot(self, y: Self) -> Self {
        Self(from_fn(|i| self.0[i].hypot(y.0[i])))
    }
}

#[test]
fn four_trajectories_in_lanes_are_the_four_alone() {
    let scene = Scene::on(SURFACE).with(Gravity { g: 1.0 });
    let directions = [0.1, 0.7, 2.0, 4.4];
    let alone = directions.map(|theta| scene.simulate(billiard(theta), Rattle::new(0.01)).unwrap());
    let system = scene.system::<Four>();
    let lanes = |component: &dyn Fn(usize) -> [f64; 3]| from_fn(|d| Four(from_fn(|lane| component(lane)[d])));
    let zero = [Four([0.0; 4]); 3];
    let mut together = system.bodies(One, |_| Body {
        q: lanes(&|lane| alone[lane].position().into()),
        q_low: zero,
        p: lanes(&|lane| alone[lane].momentum().into()),
        p_low: zero,
    });
    let mut alone = alone;
    for step in 0..1000 {
        Rattle::new(0.01).step(&system, &mut together, &mut ()).unwrap();
        for (lane, simulation) in alone.iter_mut().enumerate() {
            simulation.step().unwrap();
            let q = together.q[0].map(|q| q.0[lane]);
            assert_eq!(q, <[f64; 3]>::from(simulation.position()), "lane {lane}, step {step}");
        }
    }
}

#[test]
fn a_lane_that_fails_is_told() {
    let scene = Scene::on(Sphere { radius: 1.0 });
    let system = scene.system::<Four>();
    let (zero, one) = (Four([0.0; 4]), Four([1.0; 4]));
    let mut bodies = system.bodies(One, |_| Body {
        q: [one, zero, zero],
        q_low: [zero; 3],
        p: [zero, Four([0.1, 0.2, 30.0, 0.4]), zero],
        p_low: [zero; 3],
    });
    let failure = Rattle::new(0.1).step(&system, &mut bodies, &mut ()).unwrap_err();
    let rattle::error::StepFailure::StepTooLong { speed, .. } = failure.cause else { panic!("{failure:?}") };
    assert_eq!(speed, 30.0);
}
