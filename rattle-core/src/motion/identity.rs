//! The identity of a method or system: it decides whether the memory in a state belongs to the present one.

use crate::motion::parts::BodiesOf;
use crate::motion::system::System;
use std::any::type_name;

/// Numbers that differ by less than this part of the largest of their kind are the same.
const SAME: f64 = 1e-8;

/// Type, name, sizes and parameters of a method or system.
#[derive(Debug, Clone, PartialEq)]
pub struct Identity {
    kind: &'static str,
    name: &'static str,
    sizes: [usize; 2],
    /// Those of one kind, which have one unit, together.
    parameters: Vec<Vec<f64>>,
}

impl Identity {
    /// The identity with type `X`, this name and these parameters.
    #[must_use]
    pub fn of<X>(name: &'static str, parameters: Vec<f64>) -> Self {
        let parameters = parameters.into_iter().map(|parameter| vec![parameter]).collect();
        Self { kind: type_name::<X>(), name, sizes: [0; 2], parameters }
    }

    /// The system that gives bodies in this state these energies and accelerations.
    pub(crate) fn of_system<Y: System<f64, D>, const D: usize>(
        system: &Y,
        bodies: &BodiesOf<Y, f64, D>,
    ) -> Self {
        let n = bodies.q.as_ref().len();
        let mut accelerations = vec![[0.0; D]; n];
        let known = system.accelerations(bodies, &mut accelerations).is_ok();
        let energies = vec![system.kinetic_energy(bodies), system.potential_energy(bodies)];
        let mut accelerations = if known { accelerations.as_flattened().to_vec() } else { Vec::new() };
        if known {
            // Also those by forces alone: at an equilibrium what is left is rounding.
            let mut here = bodies.clone();
            system.evaluate_forces(&mut here);
            for body in 0..n {
                here.p.as_mut()[body] = system.force(&here, body);
                accelerations.extend(system.velocity(&here, body));
            }
        }
        Self {
            kind: type_name::<Y>(),
            name: system.kind(),
            sizes: [n, system.equations()],
            parameters: vec![energies, accelerations],
        }
    }

    /// Whether the other is of the same type, name and parameters, these but for rounding.
    pub(crate) fn is(&self, other: &Self) -> bool {
        let near = |(these, those): (&Vec<f64>, &Vec<f64>)| {
            let largest = these.iter().chain(those).fold(0.0_f64, |most, x| most.max(x.abs()));
            let near = |(a, b): (&f64, &f64)| a == b || (a - b).abs() <= SAME * largest;
            these.len() == those.len() && these.iter().zip(those).all(near)
        };
        (self.kind, self.name, self.sizes) == (other.kind, other.name, other.sizes)
            && self.parameters.len() == other.parameters.len()
            && self.parameters.iter().zip(&other.parameters).all(near)
    }
}
