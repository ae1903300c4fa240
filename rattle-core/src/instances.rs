//! Instances of generic functions that are compiled in this crate, once, and not in every crate that uses them.
//!
//! Where a function is `#[inline(never)]`, rustc (since 1.85) takes an instance of it from the crate that has it, and
//! with it all that the function calls. So what is long, and generic in numbers and dimensions but in no type of a
//! user's, is marked so, and each folder names its own here. A use of `Scene::ensemble` takes half as long to compile.

use crate::number::lanes::Fused;
use crate::run::{self, ensemble};
use crate::systems::{linked, network, surface};
use crate::{motion, solve};
use std::hint::black_box;

/// In the plane and in space. Unit tests have no users: with this constant they take twice as long to compile.
#[cfg(not(test))]
#[used]
static INSTANCES: [fn(); 2] = [instances::<2>, instances::<3>];

#[cfg_attr(test, allow(dead_code, reason = "unit tests have no users"))]
fn instances<const D: usize>() {
    black_box((motion::instances::<f64, D>(), motion::instances::<Fused<f64>, D>()));
    black_box((surface::instances::<f64, D>(), surface::instances::<Fused<f64>, D>()));
    black_box((solve::instances::<f64>(), solve::instances::<Fused<f64>>()));
    black_box((network::instances::<D>(), linked::instances::<D>()));
    black_box((run::instances::<D>(), ensemble::instances::<D>()));
}
