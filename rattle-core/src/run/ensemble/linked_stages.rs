//! Inner steps of linked bodies in lanes by the stages of [`Dop853`](crate::methods::dop853::Dop853).
//!
//! ```text
//! v̇ = M⁻¹(f − Gᵀλ)     λ such that G v̇ + v·∇²g·v = 0            at each stage
//! ```

use crate::methods::dop853_table::STAGES;
use crate::number::instructions::Work;
use crate::run::ensemble::dop853_row::Stages;
use crate::run::ensemble::linked_plan::Places;
use crate::run::ensemble::linked_stand::{Departs, Pulls, Stand};
use crate::systems::network::in_lanes::zeros;

impl<const W: usize> Departs<W> for Stages<W> {
    fn depart(&mut self, stand: &mut Stand<'_, W>, pulling: &mut Pulls<'_, '_, W>) {
        stand.course.set.run(Depart { stages: self, stand, pulling });
    }
}

struct Depart<'a, 'b, 'c, 'd, const W: usize> {
    stages: &'a mut Stages<W>,
    stand: &'a mut Stand<'b, W>,
    pulling: &'a mut Pulls<'c, 'd, W>,
}

impl<const W: usize> Work for Depart<'_, '_, '_, '_, W> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { stages, stand, pulling } = self;
        evaluate(stages, stand, pulling);
        if stand.pace.tolerance().is_some() {
            for first in (0..stand.pull.len()).step_by(stand.dimension) {
                let own = first..first + stand.dimension;
                let [places, velocities] = &stages.of;
                let (places, velocities) = (places.squares(own.clone()), velocities.squares(own));
                stages.note(&stand.pace, &places, &velocities);
            }
        }
        stages.judge(&mut stand.pace);
        arrive(stages, stand);
    }
}

/// The stages of an inner step.
#[inline(always)]
fn evaluate<const W: usize>(
    stages: &mut Stages<W>,
    stand: &mut Stand<'_, W>,
    pulling: &mut Pulls<'_, '_, W>,
) {
    let plan = stand.course.plan;
    let (Places { q, way, change, .. }, n) = (plan.places, plan.coordinates);
    stages.begin(&mut stand.pace);
    let [places, velocities] = &mut stages.of;
    places.note(0, &stand.tracks[1].now);
    velocities.note(0, &stand.pull);
    for stage in 1..STAGES {
        for ((track, rates), from) in stand.tracks.iter().zip([&*places, &*velocities]).zip([q, way]) {
            let to = &mut stand.numbers[from..from + n];
            rates.stage(stage, track, plan.moving.iter().copied(), &stand.pace.inner, to);
        }
        places.note(stage, &stand.numbers[way..way + n]);
        stand.respond(true, pulling);
        velocities.note(stage, &stand.numbers[change..change + n]);
    }
}

/// Where inner steps lead regardless of the constraints.
#[inline(always)]
fn arrive<const W: usize>(stages: &Stages<W>, stand: &mut Stand<'_, W>) {
    let plan = stand.course.plan;
    let Places { q, q_low, way, way_low, .. } = plan.places;
    for &c in &plan.moving {
        let tracks = stand.tracks.iter().zip(&stages.of);
        for ((track, rates), [high, low]) in tracks.zip([[q, q_low], [way, way_low]]) {
            let (mut sum, mut rest) = (zeros(), zeros());
            rates.arrive(track, c, &stand.pace.inner, &mut sum, &mut rest);
            (stand.numbers[high + c], stand.numbers[low + c]) = (sum, rest);
        }
    }
}
