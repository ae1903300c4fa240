//! Solves end where rounding hides what is left, not earlier: see `solve/stop.rs` of the core.

use crate::common::linked::*;
use crate::common::*;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use rattle::kernel::{Constraint, ConstraintKernel};
use rattle::prelude::*;

/// The furthest from the surface that a step ends, in ε of the largest coordinate: billiards in random directions,
/// steps with h·κ·|v| up to a half and beyond.
fn furthest<S: Method>(surface: impl Constraint<3, 1> + Copy, guess: [f64; 3], method: S) -> f64 {
    let mut rng = StdRng::seed_from_u64(11);
    let (scene, kernel) = (Scene::on(surface), surface.kernel::<f64>());
    let mut worst = 0.0_f64;
    for _ in 0..40 {
        let speed = rng.random_range(0.3..3.0);
        let along = random::<3>(&mut rng).map(|x| speed * x);
        let start = scene.project(&State::at(guess).moving(along)).unwrap();
        let Ok(mut simulation) = scene.simulate(start, method.clone()) else { continue };
        for _ in 0..1000 {
            if simulation.step().is_err() {
                break;
            }
            let q: [f64; 3] = simulation.position().into();
            let ([g], [gradient]) = kernel.value_and_jacobian(&q);
            let length = gradient.iter().map(|x| x * x).sum::<f64>().sqrt();
            let size = q.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
            worst = worst.max(g.abs() / length / (f64::EPSILON * size));
        }
    }
    worst
}

fn check<S: Method>(what: &str, method: impl Fn(f64) -> S) {
    for h in [0.003, 0.01, 0.03, 0.1] {
        let off = [
            furthest(SURFACE, [1.1, 0.4, 0.2], method(h)),
            furthest(Torus { major: 1.0, minor: 0.3 }, [1.3, 0.2, 0.3], method(h)),
            furthest(rattle::surfaces::Gyroid { k: 1.0, epsilon: 0.0 }, [3.0, 3.0, 3.0], method(h)),
        ];
        println!("{what}, h = {h}: {off:.2?} ε");
        assert!(off.iter().all(|&off| off > 0.0 && off < 12.0), "{what}, h = {h}: {off:?} ε");
    }
}

/// The rounding of g is 2 ε of the position on the lemniscate, 7 ε (once 10 ε) on the torus, as much where each solve
/// goes on to the floor. An estimate of what is left that leaves out third derivatives of g is off by 60 ε here, by 190
/// ε there.
#[test]
#[cfg(long)]
fn steps_on_surfaces_end_at_rounding() {
    check("Newton", Rattle::new);
    check("symmetric", |h| Rattle::new(h).solved_by(Symmetric));
    check("simplified", |h| Rattle::new(h).solved_by(Simplified));
    check("Broyden", |h| Rattle::new(h).solved_by(Broyden));
    check("from the last multiplier", |h| Rattle::new(h).guess(LastMultiplier));
    check("extrapolated", |h| Rattle::new(h).guess(Extrapolated));
}

/// The same for rods that hang one below the other, moving at random: what their lengths are off, in ε of the
/// coordinates.
fn furthest_rod<S: Method>(rods: usize, method: S) -> f64 {
    let mut rng = StdRng::seed_from_u64(5);
    let scene = Scene::points(rods + 1)
        .link(Rod { length: 1.0 }, chain(rods))
        .pin(0, [0.0, 0.0])
        .with(weights(&vec![1.0; rods + 1]));
    let mut worst = 0.0_f64;
    for _ in 0..100 {
        let mut places = vec![[0.0; 2]];
        for i in 0..rods {
            let (sin, cos) = rng.random_range(-1.2_f64..1.2).sin_cos();
            places.push([places[i][0] + cos, places[i][1] + sin]);
        }
        let momenta = (0..=rods).map(|i| if i == 0 { [0.0; 2] } else { random::<2>(&mut rng) });
        let start = scene.project(&State::of(places).with_momenta(momenta)).unwrap();
        let mut simulation = scene.simulate(start, method.clone()).unwrap();
        for _ in 0..100 {
            if simulation.step().is_err() {
                break;
            }
            let q: Vec<_> = simulation.positions().collect();
            for pair in q.windows(2) {
                let size = pair[0].amax().max(pair[1].amax());
                let off = ((pair[1] - pair[0]).norm_squared() - 1.0) / 8.0_f64.sqrt();
                worst = worst.max(off.abs() / (f64::EPSILON * size));
            }
        }
    }
    worst
}

#[test]
#[cfg(long)]
fn rods_end_at_rounding() {
    fn check<S: Method>(what: &str, method: impl Fn(f64) -> S) {
        for h in [0.003, 0.01, 0.03, 0.1] {
            let off = [2, 10].map(|rods| furthest_rod(rods, method(h)));
            println!("{what}, h = {h}: {off:.2?} ε");
            assert!(off.iter().all(|&off| off > 0.0 && off < 4.0), "{what}, h = {h}: {off:?} ε");
        }
    }
    check("Newton", Rattle::new);
    check("symmetric", |h| Rattle::new(h).solved_by(Symmetric));
    check("simplified", |h| Rattle::new(h).solved_by(Simplified));
    check("Broyden", |h| Rattle::new(h).solved_by(Broyden));
}
