//! The curve through the two ends of a step, for what is asked inside of it.

use crate::number::real::Scalar;
use crate::number::vector::add_scaled;
use std::array::from_fn;

/// Hermite's cubic: the place after the share s of a step of length h, from the places and velocities at its two ends.
#[inline(always)]
pub(crate) fn cubic<T: Scalar, const D: usize>(
    h: f64,
    s: f64,
    [from, to]: [&[T; D]; 2],
    [v, w]: [&[T; D]; 2],
) -> [T; D] {
    let r = 1.0 - s;
    let [a, b, c, d] =
        [r * r * (1.0 + 2.0 * s), s * s * (1.0 + 2.0 * r), h * s * r * r, -h * r * s * s].map(T::from_f64);
    from_fn(|i| a * from[i] + b * to[i] + c * v[i] + d * w[i])
}

/// The quartic with the same ends, whose acceleration there differs from that of the cubic by 2/h² times `lift`.
#[inline(always)]
pub(crate) fn quartic<T: Scalar, const D: usize>(
    h: f64,
    s: f64,
    places: [&[T; D]; 2],
    velocities: [&[T; D]; 2],
    lift: &[T; D],
) -> [T; D] {
    let r = 1.0 - s;
    add_scaled(&cubic(h, s, places, velocities), T::from_f64(s * s * r * r), lift)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cubic is fixed by its places and slopes at two ends, a quartic by an acceleration besides. All numbers are
    /// binary fractions, so equality is exact.
    #[test]
    fn curves_are_the_way_where_that_is_a_cubic_or_a_quartic() {
        let way = |e: f64, t: f64| {
            ([1.0 + t * (2.0 + t * (3.0 + t * (5.0 + t * e)))], [2.0 + t * (6.0 + t * (15.0 + t * 4.0 * e))])
        };
        let (h, ends) = (0.5, [0.0, 0.5]);
        for s in [0.0, 0.25, 0.5, 0.75, 1.0] {
            let [(from, v), (to, w)] = ends.map(|t| way(0.0, t));
            assert_eq!(cubic(h, s, [&from, &to], [&v, &w]), way(0.0, h * s).0, "at {s} of the step");
            let [(from, v), (to, w)] = ends.map(|t| way(16.0, t));
            let lift = [16.0 * h.powi(4)]; // t⁴ is beyond its cubic by h⁴s²(1 − s)²
            assert_eq!(
                quartic(h, s, [&from, &to], [&v, &w], &lift),
                way(16.0, h * s).0,
                "at {s} of the step"
            );
        }
    }
}
