//! Four numbers side by side as a scalar.

#![allow(unreachable_pub, reason = "a module of several tests")]

use rattle::real::{Mask, Real};
use std::array::from_fn;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Four numbers side by side.
#[derive(Debug, Clone, Copy)]
pub struct Four(pub [f64; 4]);

#[derive(Debug, Clone, Copy)]
pub struct FourBits(pub [bool; 4]);

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
    fn from_lanes(lane: impl Fn(usize) -> f64) -> Self {
        Self(from_fn(lane))
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
    lane_functions!(abs sign floor sqrt cbrt exp ln log10 log2 sin cos tan asin acos atan sinh cosh tanh asinh acosh
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
