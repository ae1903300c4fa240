//! What a [`Sight`] asks, answered by a system of bodies like those that it shows.

use crate::motion::bodies::{Bodies, Body};
use crate::motion::capability::Rates;
use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use crate::run::watch::sight::{Sight, Source};
use nalgebra::SVector;

/// Bodies of a system as a sight shows them.
pub(in crate::run) fn as_shown<Y: System<f64, D>, const D: usize>(
    system: &Y,
    sight: &Sight<'_, D>,
) -> BodiesOf<Y, f64, D> {
    system.bodies(&places(sight), sight.time)
}

/// Where a sight shows bodies.
#[inline(never)]
pub(in crate::run) fn places<const D: usize>(sight: &Sight<'_, D>) -> Vec<Body<f64, D>> {
    let low = [0.0; D];
    let all = sight.positions.iter().zip(sight.momenta);
    all.map(|(&q, &p)| Body { q: q.into(), q_low: low, p: p.into(), p_low: low }).collect()
}

/// Kinetic and potential energy, from positions and momenta alone.
pub(in crate::run) fn energies<Y: System<f64, D>, X, const D: usize>(
    system: &Y,
    bodies: &Bodies<Y::Count, f64, X, D>,
) -> [f64; 2] {
    [system.kinetic_energy(bodies), system.potential_energy(bodies)]
}

/// U of each effect that is no flow.
pub(in crate::run) fn effect_energies<Y: System<f64, D>, const D: usize>(
    system: &Y,
    bodies: &BodiesOf<Y, f64, D>,
) -> Vec<f64> {
    let mut energies = Vec::new();
    system.effect_energies(bodies, &mut energies);
    energies
}

/// A number of each equation, which `write` writes.
pub(in crate::run) fn of_equations<Y: System<f64, D>, const D: usize>(
    system: &Y,
    write: impl FnOnce(&mut [f64]),
) -> Vec<f64> {
    let mut numbers = vec![0.0; system.equations()];
    write(&mut numbers);
    numbers
}

/// g of each equation.
pub(in crate::run) fn residuals<Y: System<f64, D>, const D: usize>(
    system: &Y,
    bodies: &BodiesOf<Y, f64, D>,
) -> Vec<f64> {
    of_equations(system, |out| system.residuals(bodies, out))
}

/// What a question has for an answer where momenta, which are so much `later`, are brought to the time of positions: by
/// a kick back that makes them tangent, as in a step of h.
pub(in crate::run) fn at_one_time<Y: System<f64, D>, R, const D: usize>(
    system: &Y,
    bodies: &BodiesOf<Y, f64, D>,
    [later, h]: [f64; 2],
    question: impl FnOnce(&Y, &BodiesOf<Y, f64, D>) -> R,
) -> R {
    if later == 0.0 {
        return question(system, bodies);
    }
    let mut together = bodies.clone();
    match system.settle(-later, h, &mut together, &mut ()) {
        Ok(()) => question(system, &together),
        Err(_) => question(system, bodies),
    }
}

/// λ of each equation.
pub(in crate::run) fn multipliers<Y: System<f64, D>, const D: usize>(
    system: &Y,
    bodies: &BodiesOf<Y, f64, D>,
) -> Vec<f64> {
    of_equations(system, |out| system.multipliers(bodies, out))
}

/// Gᵀλ on each body.
pub(in crate::run) fn constraint_forces<Y: System<f64, D>, const D: usize>(
    system: &Y,
    bodies: &BodiesOf<Y, f64, D>,
) -> Vec<SVector<f64, D>> {
    let mut forces = vec![[0.0; D]; bodies.q.as_ref().len()];
    system.constraint_forces(bodies, &mut forces);
    vectors(&forces).collect()
}

/// λ of each equation, and Gᵀλ on each body.
pub(in crate::run) fn constraints<Y: System<f64, D>, const D: usize>(
    system: &Y,
    bodies: &BodiesOf<Y, f64, D>,
) -> (Vec<f64>, Vec<SVector<f64, D>>) {
    (multipliers(system, bodies), constraint_forces(system, bodies))
}

/// q̇ and ṗ of each body; ṗ is 0 where it is not known.
pub(in crate::run) fn rates<Y: System<f64, D>, const D: usize>(
    system: &Y,
    bodies: &BodiesOf<Y, f64, D>,
) -> [Vec<SVector<f64, D>>; 2] {
    let n = bodies.q.as_ref().len();
    let (mut velocities, mut pushes) = (vec![[0.0; D]; n], vec![[0.0; D]; n]);
    for (body, velocity) in velocities.iter_mut().enumerate() {
        *velocity = system.velocity(bodies, body);
    }
    if system.pushes(bodies, &mut pushes).is_err() {
        pushes.fill([0.0; D]);
    }
    [vectors(&velocities).collect(), vectors(&pushes).collect()]
}

/// Vectors, one by one, as users have them.
pub(in crate::run) fn vectors<const D: usize>(
    list: &[[f64; D]],
) -> impl ExactSizeIterator<Item = SVector<f64, D>> + '_ {
    list.iter().map(|&x| x.into())
}

/// kT: twice the kinetic energy, without that which moving constraints impose, by the number of independent momenta;
/// NaN where there are no masses, and where no momenta are independent.
pub(in crate::run) fn temperature<Y: System<f64, D>, const D: usize>(
    system: &Y,
    bodies: &BodiesOf<Y, f64, D>,
) -> f64 {
    if system.rates().is_err() {
        return f64::NAN;
    }
    let own = system.kinetic_energy(bodies) - imposed_energy(system, bodies);
    heat_of_each(own, system.freedom(bodies))
}

/// Twice this kinetic energy by so many independent momenta; NaN where there are none, since their energy is a
/// rounding.
pub(in crate::run) fn heat_of_each(kinetic: f64, freedom: usize) -> f64 {
    if freedom == 0 { f64::NAN } else { 2.0 * kinetic / freedom as f64 }
}

/// The part of the kinetic energy that constraints which move impose.
fn imposed_energy<Y: System<f64, D>, const D: usize>(system: &Y, bodies: &BodiesOf<Y, f64, D>) -> f64 {
    if !system.constraints_move() {
        return 0.0;
    }
    let (mut bodies, zero) = (bodies.clone(), [0.0; D]);
    bodies.p.as_mut().fill(zero);
    bodies.p_low.as_mut().fill(zero);
    let settled = system.settle(0.0, 1.0, &mut bodies, &mut ());
    settled.map_or(f64::NAN, |()| system.kinetic_energy(&bodies))
}

/// aᵀM b of changes of the position of a body; NaN where there are no masses.
pub(in crate::run) fn mass_product<Y: System<f64, D>, const D: usize>(
    system: &Y,
    body: usize,
    a: &[f64; D],
    b: &[f64; D],
) -> f64 {
    system.rates().map_or(f64::NAN, |masses| masses.mass_product(body, a, b))
}

/// The names of the types of all forces on such bodies.
pub(in crate::run) fn forces<Y: System<f64, D>, const D: usize>(
    system: &Y,
    places: &[Body<f64, D>],
) -> Vec<&'static str> {
    let (mut bodies, mut forces) = (system.bodies(places, 0.0), vec![[0.0; D]; places.len()]);
    let mut names = Vec::new();
    for number in 0..Y::EFFECTS {
        names.extend(system.add_force_alone(number, &mut bodies, &mut forces));
    }
    names
}

/// Trajectories whose steps are not a system's, but of which each obeys one.
pub(in crate::run) trait Obeying<const D: usize> {
    /// What they obey.
    type System: System<f64, D>;
    /// What this one obeys.
    fn system(&self, trajectory: usize) -> &Self::System;
    /// The step size of the method.
    fn step_size(&self) -> f64;
}

impl<X: Obeying<D>, const D: usize> Source<D> for X {
    fn energies(&self, trajectory: usize, sight: &Sight<'_, D>) -> [f64; 2] {
        let system = self.system(trajectory);
        energies(system, &as_shown(system, sight))
    }

    fn constraints(&self, trajectory: usize, sight: &Sight<'_, D>) -> (Vec<f64>, Vec<SVector<f64, D>>) {
        let system = self.system(trajectory);
        constraints(system, &as_shown(system, sight))
    }

    fn rates(&self, trajectory: usize, sight: &Sight<'_, D>) -> [Vec<SVector<f64, D>>; 2] {
        let system = self.system(trajectory);
        rates(system, &as_shown(system, sight))
    }

    fn effect_energies(&self, trajectory: usize, sight: &Sight<'_, D>) -> Vec<f64> {
        let system = self.system(trajectory);
        effect_energies(system, &as_shown(system, sight))
    }

    fn residuals(&self, trajectory: usize, sight: &Sight<'_, D>) -> Vec<f64> {
        let system = self.system(trajectory);
        residuals(system, &as_shown(system, sight))
    }

    fn temperature(&self, trajectory: usize, sight: &Sight<'_, D>) -> f64 {
        let system = self.system(trajectory);
        temperature(system, &as_shown(system, sight))
    }

    fn mass_product(&self, trajectory: usize, body: usize, a: &[f64; D], b: &[f64; D]) -> f64 {
        mass_product(self.system(trajectory), body, a, b)
    }

    fn step_size(&self) -> f64 {
        Obeying::step_size(self)
    }
}
