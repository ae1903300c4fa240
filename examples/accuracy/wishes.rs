//! Wishes in the two scenes whose evaluations are not counted, against compositions of order 8 and 10, short steps.
//! steps.

use crate::clock;
use rattle::bodies::Count;
use rattle::composition::{Coefficients, KAHAN_LI_1997_ORDER_8, SOFRONIOU_SPALETTA_2005_ORDER_10};
use rattle::effect::Effects;
use rattle::prelude::*;
use rattle::price::Clock;
use rattle::scene::Hold;

const WISHES: [f64; 4] = [1e-4, 1e-6, 1e-8, 1e-11];
/// The two truths may differ by this.
const SURE: f64 = 2e-12;

/// Tells of each wish what it came to; an error if one is not met.
pub(crate) fn wishes<C: Hold<D>, E: Effects<D>, N: Count, const D: usize>(
    name: &str,
    scene: &Scene<C, E, N, D>,
    start: &State<D>,
    duration: f64,
    steps: u64,
) -> Result<(), Box<dyn std::error::Error>> {
    let truth = |coefficients: Coefficients, steps: u64| {
        let method = Composition::new(coefficients, duration / steps as f64);
        let mut simulation = scene.simulate(start.clone(), method)?;
        simulation.run(steps)?;
        Ok::<_, rattle::Error>(simulation.boxed())
    };
    let exact = truth(SOFRONIOU_SPALETTA_2005_ORDER_10, steps)?;
    let sure = off(&exact, &truth(KAHAN_LI_1997_ORDER_8, 2 * steps)?);
    println!("\n{name}: truths {sure:.1e} apart");
    if sure > SURE {
        return Err(format!("{name}: orders 8 and 10 differ by {sure:e}").into());
    }
    for wish in WISHES {
        let wished = scene.within(wish).budget(4.0).clock(Clock::of(clock::cpu_seconds));
        let mut planned = wished.simulate(start, duration)?;
        let spent = planned.run()?;
        let error = off(&exact, &planned.simulation);
        println!("{wish:.0e}: {error:.1e} off; {planned}; it took {spent}");
        if error > wish {
            return Err(format!("{name}: the wish {wish:e} is not met: {error:e}").into());
        }
    }
    Ok(())
}

/// The farthest that a body is from where it is in the other simulation.
fn off<const D: usize>(a: &BoxedSimulation<D>, b: &BoxedSimulation<D>) -> f64 {
    a.positions().zip(b.positions()).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}
