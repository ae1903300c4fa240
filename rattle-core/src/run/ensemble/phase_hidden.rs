//! The hidden constraint {g, H} in lanes, as in [`point`](crate::systems::phase::point).

use crate::kernel::functions::{HamiltonianKernel, PhaseConstraintKernel};
use crate::number::real::Real;
use crate::number::vector::{dot, largest, sum};
use crate::number::vectors::{at, put};
use crate::run::ensemble::phase_row::{Each, Laws, Matrix, Number, Points, ROW};
use std::array::from_fn;

/// Gradients of g and H.
#[inline(always)]
pub(super) fn evaluate<const D: usize, const M: usize>(
    laws: &impl Laws<D, M>,
    place: &Points<D>,
    gradients: &mut [Points<D>; M],
    energy: &mut Points<D>,
) {
    for l in 0..ROW {
        let (by_q, by_p) = laws.constraint(l).jacobians(&at(&place.q, l), &at(&place.p, l));
        for m in 0..M {
            put(&mut gradients[m].q, l, by_q[m]);
            put(&mut gradients[m].p, l, by_p[m]);
        }
    }
    for l in 0..ROW {
        let (by_q, by_p) = laws.energy(l).gradients(&at(&place.q, l), &at(&place.p, l));
        put(&mut energy.q, l, by_q);
        put(&mut energy.p, l, by_p);
    }
}

/// ∇{gᵢ, H} in a lane.
#[inline(always)]
fn steepest<const D: usize, const M: usize>(
    laws: &impl Laws<D, M>,
    l: usize,
    place: &Points<D>,
    gradients: &[Points<D>; M],
    energy: &Points<D>,
) -> [[[Number; D]; 2]; M] {
    let (q, p) = (at(&place.q, l), at(&place.p, l));
    let (free_q, free_p) = (at(&energy.p, l), at(&energy.q, l).map(|x| -x));
    let (g_q, g_p) = laws.constraint(l).hessian_vector(&q, &p, &free_q, &free_p);
    from_fn(|i| {
        let (fibre_q, fibre_p) = (at(&gradients[i].p, l).map(|x| -x), at(&gradients[i].q, l));
        let (h_q, h_p) = laws.energy(l).hessian_vector(&q, &p, &fibre_q, &fibre_p);
        [sum(&g_q[i], &h_q), sum(&g_p[i], &h_p)]
    })
}

/// By how much {gᵢ, H} change in a lane by the motion without constraint.
#[inline(always)]
pub(super) fn rates<const D: usize, const M: usize>(
    laws: &impl Laws<D, M>,
    l: usize,
    place: &Points<D>,
    gradients: &[Points<D>; M],
    energy: &Points<D>,
) -> [Number; M] {
    let [energy_q, energy_p] = [at(&energy.q, l), at(&energy.p, l)];
    steepest(laws, l, place, gradients, energy).map(|[q, p]| dot(&q, &energy_p) - dot(&p, &energy_q))
}

/// {gᵢ, H}, its size and extent, and N.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "what it is made of, and what is found")]
pub(super) fn hidden<const D: usize, const M: usize>(
    laws: &impl Laws<D, M>,
    place: &Points<D>,
    gradients: &[Points<D>; M],
    energy: &Points<D>,
    reach: &Points<D>,
    slopes: &mut Matrix<M>,
    value: &mut [Each; M],
    [size, extent]: [&mut [Each; M]; 2],
) {
    let zero = Number::from_f64(0.0);
    for l in 0..ROW {
        let (reach_q, reach_p) = (at(&reach.q, l), at(&reach.p, l));
        let (most_q, most_p) = (largest(&reach_q), largest(&reach_p));
        let [energy_q, energy_p] = [at(&energy.q, l), at(&energy.p, l)];
        let steepest = steepest(laws, l, place, gradients, energy);
        let gradients: [_; M] = from_fn(|i| [at(&gradients[i].q, l), at(&gradients[i].p, l)]);
        for i in 0..M {
            let [q, p] = &steepest[i];
            for j in 0..M {
                let [by_q, by_p] = &gradients[j];
                slopes[i][j][l] = dot(p, by_q) - dot(q, by_p);
            }
            let (mut known, mut terms) = ([zero; 2], [zero; 2]);
            for d in 0..D {
                for (k, (x, reach)) in [(q[d], reach_q[d]), (p[d], reach_p[d])].into_iter().enumerate() {
                    known[k] = known[k].max(Number::select(x == zero, zero, reach));
                    terms[k] = terms[k] + x.abs();
                }
            }
            size[i][l] = terms[0].multiply_add(known[0], terms[1] * known[1]);
            extent[i][l] = terms[0].multiply_add(most_q, terms[1] * most_p);
            value[i][l] = dot(&gradients[i][0], &energy_p) - dot(&gradients[i][1], &energy_q);
        }
    }
}

/// The directions of fibres, (−∂gᵢ/∂p, ∂gᵢ/∂q).
#[inline(always)]
pub(super) fn directions<const D: usize, const M: usize>(
    gradients: &[Points<D>; M],
    to: &mut [Points<D>; M],
) {
    for m in 0..M {
        for d in 0..D {
            for l in 0..ROW {
                (to[m].q[d][l], to[m].p[d][l]) = (-gradients[m].p[d][l], gradients[m].q[d][l]);
            }
        }
    }
}
