//! Progress bars of ensembles: all groups of trajectories move one bar, which is full when all has been seen.

use crate::common::*;
use rattle::prelude::*;
use rattle::progress::Bar;
use rattle::surfaces::Torus;

#[test]
fn a_bar_is_full_once_all_trajectories_have_been_seen() {
    for number in [1, 100, 1003] {
        let start = |i: u32| State::at([1.25, 0.0, 0.0]).moving([0.0, 1.0 + 0.001 * f64::from(i), 0.5]);
        let scene = Scene::on(Torus { major: 1.0, minor: 0.25 });
        let mut ensemble = scene.ensemble((0..number).map(start), Rattle::new(0.01)).unwrap();
        let sights = 20 * u64::from(number);
        let bar = Bar::of(sights);
        let seen = ensemble.observe(40, 2, || (bar.observer(), Mean::of(|now: &Sight<'_, 3>| now.time)));
        assert_eq!((bar.sights(), seen.1.number()), (sights, sights));
        assert_eq!(ensemble.failures().count(), 0);
    }
}
