//! Whether other sheets are near bodies in tiles: see [`crate::solve::crowd`].

use crate::effect::force::Force;
use crate::kernel::functions::ConstraintKernel;
use crate::number::instructions::Work;
use crate::number::lanes::Fused;
use crate::number::real::{Real, Scalar};
use crate::number::vector::largest;
use crate::number::vectors::{LANES, at};
use crate::solve::crowd::{self, PATH, REACH, ROOT_3, rises, shares};
use crate::systems::surface::in_lanes::{Number, TileInLanes};
use crate::systems::surface::tile::Tile;

/// Asks at most [`LANES`] bodies, before a step of length h > 0.
pub(super) struct Around<'a, T, K, F, const D: usize> {
    pub(super) constraint: &'a K,
    pub(super) bodies: Tile<'a, T, F, D>,
    pub(super) h: f64,
    /// After so many steps of [`shares`].
    pub(super) turn: u64,
}

impl<T: Scalar, K: ConstraintKernel<Number, D, 1>, F: Force<T, D>, const D: usize> Work
    for Around<'_, T, K, F, D>
{
    /// A bit for each body in a crowd.
    type Done = u64;

    #[inline(always)]
    fn run(self) -> u64 {
        let Self { constraint, mut bodies, h, turn } = self;
        let constraint = constraint.clone(); // out of reach of what the loops write
        let number = bodies.q.len().min(LANES);
        let TileInLanes {
            q, p, normal, force, inverse_square, square, first: furthest, slope: least, ..
        } = bodies.spread();
        let [pushed, path] = [REACH * 0.5 * h * h, REACH * PATH * h].map(Fused);
        for l in 0..LANES {
            let p = at(p, l);
            let [bend] = constraint.jet(&at(q, l), &p).2;
            let over = Fused(ROOT_3) * largest(&at(normal, l)) * inverse_square[l];
            let along = over * path * largest(&p);
            let back = pushed * bend.abs() * inverse_square[l];
            let push = if F::ACTS { over * pushed * largest(&at(force, l)) } else { Fused(0.0) };
            furthest[l] = crowd::furthest(back, along, push);
            square[l] = Fused(1.0) / inverse_square[l];
            least[l] = square[l];
        }
        for share in shares(turn) {
            for l in 0..LANES {
                let shift = Fused(share) * furthest[l];
                let rises = rises(&constraint, &at(q, l), &at(normal, l), square[l], shift);
                least[l] = Real::select(rises.le(least[l]), rises, least[l]);
            }
        }
        (0..number).fold(0, |bits, l| bits | u64::from(!Fused(0.0).le(least[l])) << l)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::force::Absent;
    use crate::number::vectors::Chunks;
    use crate::systems::surface::normal::Normal;
    use std::f64::consts::FRAC_PI_3;

    /// g = scale·(sin(wave·y)/wave + bend·x²/2): sheets above each other, π/wave apart. At the origin g rises along its
    /// normal by half of what it does there, the least that is taken for one sheet, at a distance of π/3/wave.
    #[derive(Clone)]
    struct Sheets {
        scale: f64,
        wave: f64,
        bend: f64,
    }

    impl<T: Scalar> ConstraintKernel<T, 2, 1> for Sheets {
        fn value(&self, q: &[T; 2]) -> [T; 1] {
            self.value_and_jacobian(q).0
        }

        fn value_and_jacobian(&self, &[x, y]: &[T; 2]) -> ([T; 1], [[T; 2]; 1]) {
            let [scale, wave, bend] = [self.scale, self.wave, self.bend].map(T::from_f64);
            let (sine, cosine) = (wave * y).sin_cos();
            let g = sine / wave + T::from_f64(0.5) * bend * x * x;
            ([scale * g], [[scale * bend * x, scale * cosine]])
        }

        fn hessian_vector(&self, &[_, y]: &[T; 2], v: &[T; 2]) -> [[T; 2]; 1] {
            let [scale, wave, bend] = [self.scale, self.wave, self.bend].map(T::from_f64);
            [[scale * bend * v[0], -(scale * wave * (wave * y).sin() * v[1])]]
        }

        fn jet(&self, q: &[T; 2], v: &[T; 2]) -> ([T; 1], [T; 1], [T; 1]) {
            let product = |[x, y]: [T; 2]| x * v[0] + y * v[1];
            let ([g], [gradient]) = self.value_and_jacobian(q);
            let [curved] = self.hessian_vector(q, v);
            ([g], [product(gradient)], [product(curved)])
        }
    }

    /// Which of some bodies at the origin, with these momenta and forces, are in a crowd.
    fn crowded<F: Force<f64, 2>>(
        sheets: &Sheets,
        h: f64,
        turn: u64,
        momenta: &mut [[f64; 2]],
        force: &[F],
    ) -> u64 {
        let number = momenta.len();
        let zeros = || vec![[0.0; 2]; number];
        let mut lanes = TileInLanes::new();
        let bodies = Tile {
            q: &mut zeros(),
            q_low: &mut zeros(),
            p: momenta,
            p_low: &mut zeros(),
            normal: &mut vec![Normal::new([0.0, sheets.scale]); number],
            force,
            lanes: &mut lanes,
            chunks: Chunks::of(number),
        };
        Around { constraint: sheets, bodies, h, turn }.run()
    }

    /// How far is written out here, for h = 0.1 and a body that moves along x: bend, velocity and force, and the sum.
    #[test]
    fn sheets_are_seen_as_far_as_the_step_is_bent_and_no_farther() {
        let cases = [
            ([0.0, 2.0, 0.0], ROOT_3 * 0.02), // straight: the part of the path alone
            ([0.5, 2.0, 0.0], 0.02 + ROOT_3 * 0.02), // twice h²/2 · bend · v²
            ([-0.5, -2.0, 0.0], 0.02 + ROOT_3 * 0.02), // whatever the signs
            ([5.0, 2.0, 0.0], ROOT_3 * 0.04), // 0.2 is farther than that part of the path
            ([0.5, 2.0, -7.0], 0.02 + ROOT_3 * 0.09), // twice h²/2 · force
        ];
        for turn in [0, 64, 6400] {
            let share = shares(turn).fold(0.0, |most, share: f64| most.max(share.abs()));
            for ([bend, velocity, push], distance) in cases {
                for (scale, number) in [(1.0, 1), (-5.0, 8), (0.2, 64)] {
                    for (further, seen) in [(0.999, false), (1.001, true)] {
                        let wave = further * FRAC_PI_3 / (share * distance);
                        let sheets = Sheets { scale, wave, bend };
                        let momenta = &mut vec![[velocity, 0.0]; number];
                        let found = crowded(&sheets, 0.1, turn, momenta, &vec![[0.0, push]; number]);
                        let case =
                            format!("turn {turn}, {bend} {velocity} {push}, {number} times, {further}");
                        assert_eq!(found, if seen { u64::MAX >> (64 - number) } else { 0 }, "{case}");
                        if push == 0.0 {
                            assert_eq!(
                                crowded(&sheets, 0.1, turn, momenta, &vec![Absent; number]),
                                found,
                                "{case}"
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn a_body_is_told_by_its_bit() {
        let sheets = Sheets { scale: 1.0, wave: 10.0, bend: 0.0 };
        // Seen from π/30 on, and √3 · 0.1 · h · v is 0.1 or 0.14.
        let [slow, fast] = [0.5, 0.7].map(|v| [v / ROOT_3, 0.0]);
        let mut momenta = [slow, fast, slow, slow, slow, fast, slow, slow, fast];
        assert_eq!(crowded(&sheets, 2.0, 0, &mut momenta, &[Absent; 9]), 0b1_0010_0010);
    }
}
