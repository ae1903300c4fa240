//! Where steps of Lobatto IIIA–IIIB end: on the surface, to a few roundings, however long the way was on which their
//! stages were found.

use rattle::Error;
use rattle::ensemble::Ensemble;
use rattle::error::StepFailure;
use rattle::potentials::Gravity;
use rattle::prelude::*;
use rattle::surfaces::Torus;
use rattle::table::{Table, Tabulated};
use std::f64::consts::TAU;

const TORUS: Torus = Torus { major: 1.0, minor: 0.4 };

/// Sixteen roundings of the largest place: g is rounded to less than nine of them.
const FEW: f64 = 16.0 * 1.4 * f64::EPSILON;

/// The distance from the surface.
fn off(q: [f64; 3]) -> f64 {
    let [x, y, z] = q;
    ((x.hypot(y) - TORUS.major).hypot(z) - TORUS.minor).abs()
}

/// How far a trajectory of an ensemble is from the surface.
fn off_in(ensemble: &Ensemble<3>, i: usize) -> f64 {
    off(ensemble.state(i).positions().next().unwrap().into())
}

/// Starts all over the torus, in all directions.
fn starts(number: u32, speed: f64) -> impl Iterator<Item = State<3>> + Clone {
    (0..number).map(move |i| {
        // Multiples of roots are spread evenly.
        let [(s, c), (t, d), (v, u)] = [2.0_f64, 3.0, 5.0].map(|x| (TAU * f64::from(i) * x.sqrt()).sin_cos());
        let from_axis = TORUS.major + TORUS.minor * d;
        let [round, across] = [[-s, c, 0.0], [-t * c, -t * s, d]];
        State::at([from_axis * c, from_axis * s, TORUS.minor * t])
            .moving([0, 1, 2].map(|k| speed * (u * round[k] + v * across[k])))
    })
}

/// Takes five steps from each start, as long as they can be taken, in lanes and by simulations. Returns how many of
/// each were taken.
fn sweep<const S: usize>(h: f64, speed: f64) -> [usize; 2]
where
    Table<S>: Tabulated,
{
    let scene = Scene::on(TORUS).with(Gravity { g: 1.0 });
    let all = starts(300, speed);
    let mut taken = [0; 2];
    for (i, start) in all.clone().enumerate() {
        let mut simulation = scene.simulate(start, Lobatto::<S>::new(h)).unwrap();
        for _ in 0..5 {
            match simulation.step() {
                Ok(()) => {
                    let off = off(simulation.position().into());
                    assert!(off <= FEW, "simulation {i}, {S} stages, h = {h}: {off:e} off");
                    taken[0] += 1;
                }
                // On this torus there is one sheet.
                Err(Error::Step { cause: StepFailure::OtherSheet { off, .. }, .. }) => {
                    panic!("simulation {i}, {S} stages, h = {h}: {off:e} beside its own sheet")
                }
                Err(_) => break,
            }
        }
    }
    let mut lanes = scene.ensemble(all, Lobatto::<S>::new(h)).unwrap();
    for _ in 0..5 {
        lanes.run(1);
        for i in (0..lanes.len()).filter(|&i| lanes.failure(i).is_none()) {
            let off = off_in(&lanes, i);
            assert!(off <= FEW, "lane {i}, {S} stages, h = {h}: {off:e} off");
            taken[1] += 1;
        }
    }
    taken
}

/// Of longer steps some have no stages. Where neither way ends too soon, both take as many as the other; stages that
/// hardly converge depend on roundings.
#[test]
fn long_steps_end_on_the_surface() {
    for (h, speed) in [(0.3, 1.0), (0.5, 1.0), (0.7, 1.0), (0.9, 1.0), (1.1, 1.0), (0.03, 34.0)] {
        for [simulations, lanes] in [sweep::<3>(h, speed), sweep::<5>(h, speed)] {
            println!("h = {h}: {simulations} steps by simulations, {lanes} in lanes");
            assert!(simulations.abs_diff(lanes) <= 10, "h = {h}: {simulations} and {lanes}");
        }
    }
}

/// Starts whose stages run far off, by 10⁵ and more, before they converge: what they were moved by was added up, and
/// places that held g = 0 were not those at which steps ended.
#[test]
fn stages_that_ran_off_lead_back() {
    let scene = Scene::on(TORUS).with(Gravity { g: 1.0 });
    for (h, q, p) in [
        (
            0.9,
            [-1.2630973156950123, 0.14818454109673931, 0.2935072480127778],
            [0.5177729342764757, 0.7592727058366145, 0.3942285462802946],
        ),
        (
            0.7,
            [-0.6074415624990314, -1.1286564219973245, 0.28394379654920004],
            [-0.8591769384359609, -0.10962298345445022, -0.49979774905290897],
        ),
        (
            0.03,
            [-1.2177877431320039, 0.3873578778361978, 0.2876911849437133],
            [24.184025330956196, -5.489400979253843, 23.870028055721644],
        ),
    ] {
        let start = State::at(q).moving(p);
        let mut simulation = scene.simulate(start.clone(), Lobatto::<5>::new(h)).unwrap();
        let mut lane = scene.ensemble([start], Lobatto::<5>::new(h)).unwrap();
        for step in 1..=3 {
            simulation.step().unwrap();
            lane.run(1);
            assert!(lane.failure(0).is_none(), "h = {h}, step {step}: {:?}", lane.failure(0));
            let offs = [off(simulation.position().into()), off_in(&lane, 0)];
            assert!(offs.iter().all(|&off| off <= FEW), "h = {h}, step {step}: {offs:?} off");
        }
    }
}
