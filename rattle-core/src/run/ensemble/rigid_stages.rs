//! Inner steps of rigid bodies in lanes by the stages of [`Dop853`](crate::methods::dop853::Dop853).
//!
//! ```text
//! Q̇ = Q Ω̂,   ṁ = m × Ω + torque,   Ω = J⁻¹m     at each stage
//! ```

use crate::methods::dop853_table::STAGES;
use crate::number::instructions::Work;
use crate::number::lanes::Fused;
use crate::number::real::Real;
use crate::run::ensemble::dop853_row::Stages;
use crate::run::ensemble::rigid_stand::{Departs, Pulls, ROW, Stand};
use crate::systems::network::in_lanes::{Numbers, zeros};

impl Departs for Stages<ROW> {
    fn depart(&mut self, stand: &mut Stand<'_>, pulling: &mut Pulls<'_, '_>) {
        stand.set.run(Depart { stages: self, stand, pulling });
    }
}

struct Depart<'a, 'b, 'c, 'd> {
    stages: &'a mut Stages<ROW>,
    stand: &'a mut Stand<'b>,
    pulling: &'a mut Pulls<'c, 'd>,
}

impl Work for Depart<'_, '_, '_, '_> {
    type Done = ();

    #[inline(always)]
    fn run(self) {
        let Self { stages, stand, pulling } = self;
        evaluate(stages, stand, pulling);
        if stand.pace.tolerance().is_some() {
            note(stages, stand);
        }
        stages.judge(&mut stand.pace);
        arrive(stages, stand);
    }
}

/// The stages of an inner step.
#[inline(always)]
fn evaluate(stages: &mut Stages<ROW>, stand: &mut Stand<'_>, pulling: &mut Pulls<'_, '_>) {
    stages.begin(&mut stand.pace);
    for (of_stages, rates) in stages.of.iter_mut().zip(&stand.rates) {
        of_stages.note(0, rates);
    }
    for stage in 1..STAGES {
        for ((track, rates), trial) in stand.tracks.iter().zip(&stages.of).zip(&mut stand.trial) {
            rates.stage(stage, track, 0..trial.len(), &stand.pace.inner, trial);
        }
        stand.respond(pulling);
        for (of_stages, rates) in stages.of.iter_mut().zip(&stand.rates_there) {
            of_stages.note(stage, rates);
        }
    }
}

/// The errors of inner steps.
#[inline(always)]
fn note(stages: &mut Stages<ROW>, stand: &Stand<'_>) {
    for body in 0..stand.bodies() {
        let ([attitudes, momenta], mut rates) = (&stages.of, [zeros(); 2]);
        for i in 0..3 {
            let squares = momenta.squares(3 * body + i..3 * body + i + 1);
            as_matrices(&stand.inertia.over[i], &squares, &mut rates);
        }
        let places = attitudes.squares(9 * body..9 * body + 9);
        stages.note(&stand.pace, &places, &rates);
    }
}

/// Where inner steps lead.
#[inline(always)]
fn arrive(stages: &Stages<ROW>, stand: &mut Stand<'_>) {
    let [q, m, q_low, m_low] = &mut stand.trial;
    let tracks = stand.tracks.iter().zip(&stages.of);
    for ((track, rates), (high, low)) in tracks.zip([(q, q_low), (m, m_low)]) {
        for (c, (high, low)) in high.iter_mut().zip(low).enumerate() {
            rates.arrive(track, c, &stand.pace.inner, high, low);
        }
    }
}

/// Adds what squares of rates of a momentum are of those of an attitude: |Q v̂|² is 2 |v|².
#[inline(always)]
fn as_matrices<const W: usize>(over: &Numbers<W>, squares: &[Numbers<W>; 2], to: &mut [Numbers<W>; 2]) {
    for (square, to) in squares.iter().zip(to) {
        for l in 0..W {
            let rate = Fused(2.0) * over.0[l];
            to.0[l] = (Fused(2.0) * rate * rate).multiply_add(square.0[l], to.0[l]);
        }
    }
}
