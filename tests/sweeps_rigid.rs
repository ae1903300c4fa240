//! Sweeps over rigid bodies in lanes: each trajectory as a simulation of its own scene but for rounding.

use crate::lanes_linked::Told;
use crate::lanes_rigid::{Alike, Field, check, off, start, start_of_three};
use crate::sweeps_linked::the_same_bits;
use rattle::bodies::Many;
use rattle::composition::SUZUKI_1990_ORDER_4;
use rattle::effect::Effects;
use rattle::ensemble::InstructionSet;
use rattle::prelude::*;

fn moments(i: usize) -> [f64; 3] {
    let i = i as f64;
    [0.6 + 0.01 * i, 0.8, 1.0 + 0.005 * i]
}

/// Each trajectory with moments of inertia and a weight of its own.
#[test]
fn single_bodies() {
    let (method, number) = (Rattle::new(0.05), 67_u32);
    let scene = |i: usize| {
        let weight = 0.2 + 0.01 * i as f64;
        Scene::rigid(Rigid::new(moments(i))).with(Field { weight, pull: 0.3 })
    };
    let scenes: Vec<_> = (0..number as usize).map(scene).collect();
    let starts: Vec<_> = (0..number).map(|i| start(i, moments(i as usize), 1.0)).collect();
    let mut ensemble = Ensemble::sweep(Double, scenes.iter().zip(starts.iter().cloned()), method).unwrap();
    check(&[off(&mut ensemble, scene, &starts, &method, 40, [1.0; 3])], [1.0; 3]);
}

/// Three bodies that feel each other: moments, weight, and what two of them feel are those of the trajectory.
fn coupled(i: usize) -> Scene<Rigid, impl Effects<9> + 'static, Many, 9> {
    let [weight, strength] = [0.2 + 0.01 * i as f64, 0.9 - 0.01 * i as f64];
    let bodies = Scene::rigid(Rigid::new(moments(i))).with(Field { weight, pull: 0.3 }).bodies(3);
    bodies.with(Alike { strength }.over([[0, 1], [1, 2]]))
}

/// In a full row and another, in a row of a few, and by a method of several stages.
#[test]
fn bodies_that_feel_each_other() {
    let scenes: Vec<_> = (0..70).map(coupled).collect();
    let starts: Vec<_> = (0..70).map(|i| start_of_three(i, moments(i as usize), 1.0)).collect();
    let trajectories = |number: usize| scenes.iter().zip(starts.iter().cloned()).take(number);
    let (rattle, suzuki) = (Rattle::new(0.05), Composition::new(SUZUKI_1990_ORDER_4, 0.1));
    let mut full = Ensemble::sweep(Double, trajectories(70), rattle).unwrap();
    let mut few = Ensemble::sweep(Compensated, trajectories(9), rattle).unwrap();
    let mut stages = Ensemble::sweep(Compensated, trajectories(70), suzuki).unwrap();
    check(
        &[
            off(&mut full, coupled, &starts, &rattle, 40, [1.0; 3]),
            off(&mut few, coupled, &starts[..9], &rattle, 40, [1.0; 3]),
            off(&mut stages, coupled, &starts, &suzuki, 10, [1.0; 3]),
        ],
        [1.0; 3],
    );
    let fuses = InstructionSet::widest().fuses();
    for ensemble in [full, few, stages] {
        assert_eq!(ensemble.plan().in_lanes, if fuses { ensemble.len() } else { 0 });
    }
}

/// A sweep over equal scenes is an ensemble.
#[test]
fn equal_scenes_are_an_ensemble() {
    let (scene, method) = (coupled(0), Rattle::new(0.05));
    let starts: Vec<_> = (0..70).map(|i| start_of_three(i, moments(0), 1.0)).collect();
    let trajectories = starts.iter().map(|start| (&scene, start.clone()));
    let mut sweep = Ensemble::sweep(Double, trajectories, method).unwrap();
    let mut ensemble = scene.ensemble(starts, method).unwrap();
    sweep.run(200);
    ensemble.run(200);
    (0..70).for_each(|i| assert_eq!(sweep.state(i), ensemble.state(i), "{i}"));
}

/// Also where some bodies turn too fast for a step, and the trajectory ends, or its steps are divided.
#[test]
fn neighbours_are_not_disturbed() {
    let scenes: Vec<_> = (0..70).map(coupled).collect();
    let speed = |i: usize| if i.is_multiple_of(40) { 8.0 } else { 1.0 };
    let start = |i: usize| start_of_three(i as u32, moments(i), speed(i));
    for &halvings in if cfg!(long) { &[0, 3][..] } else { &[0] } {
        let of = |which: &[usize]| {
            let trajectories = which.iter().map(|&i| (&scenes[i], start(i)));
            Ensemble::sweep(Double, trajectories, Rattle::new(0.2)).unwrap().retry(halvings)
        };
        the_same_bits(70, of, halvings == 0);
    }
}

/// Energies and the names of forces are those of the scene of each trajectory.
#[test]
fn sights_know_their_scenes() {
    let (scenes, method) = ((0..3).map(coupled).collect::<Vec<_>>(), Rattle::new(0.05));
    let starts: Vec<_> = (0..3).map(|i| start_of_three(i, moments(i as usize), 1.0)).collect();
    let mut sweep = Ensemble::sweep(Double, scenes.iter().zip(starts.iter().cloned()), method).unwrap();
    let seen = sweep.observe(30, 10, || Each::of(Told::default));
    for (i, (scene, start)) in scenes.iter().zip(&starts).enumerate() {
        let off = seen.get(i).unwrap().off_alone(scene, start, &method);
        assert!(off < 1e-13, "{i}: {off:e}");
    }
}
