//! Random numbers that are a function of a counter: Philox4x64-10.
//!
//! Ten rounds of multiplication and exchange turn a key and a counter into four words that pass every known test. No
//! state is kept, so numbers do not depend on threads, neighbours or restarts. The words equal those of NumPy's
//! `Philox`.
//!
//! Source: J. Salmon, M. Moraes, R. Dror, D. Shaw, *Parallel random numbers: as easy as 1, 2, 3*, SC11 (2011).

use std::f64::consts::TAU;

const MULTIPLIERS: [u64; 2] = [0xD2E7_470E_E14C_6C93, 0xCA5A_8263_9512_1157];
/// The golden ratio and √3 − 1, as fractions of 2⁶⁴.
const WEYL: [u64; 2] = [0x9E37_79B9_7F4A_7C15, 0xBB67_AE85_84CA_A73B];
const ROUNDS: usize = 10;

/// Four words of this key and this counter.
#[inline]
pub(crate) fn philox(key: [u64; 2], counter: [u64; 4]) -> [u64; 4] {
    let (mut key, mut words) = (key, counter);
    for _ in 0..ROUNDS {
        let [(low0, high0), (low1, high1)] =
            [(0, 0), (1, 2)].map(|(m, word)| wide(MULTIPLIERS[m], words[word]));
        words = [high1 ^ words[1] ^ key[0], low1, high0 ^ words[3] ^ key[1], low0];
        key = [key[0].wrapping_add(WEYL[0]), key[1].wrapping_add(WEYL[1])];
    }
    words
}

/// The lower and the upper half of a product.
#[allow(clippy::cast_possible_truncation, reason = "the halves")]
#[inline]
fn wide(a: u64, b: u64) -> (u64, u64) {
    let product = u128::from(a) * u128::from(b);
    (product as u64, (product >> 64) as u64)
}

/// In (0, 1], on a grid of 2⁻⁵³.
#[allow(clippy::cast_precision_loss, reason = "53 bits")]
#[inline(always)]
pub(crate) fn unit(word: u64) -> f64 {
    ((word >> 11) + 1) as f64 * (0.5 * f64::EPSILON)
}

/// Four normal numbers of four words (G. Box, M. Muller, Ann. Math. Stat. 29 (1958) 610). The functions are not those
/// of the system, so that bits do not depend on it.
pub(crate) fn normal(words: [u64; 4]) -> [f64; 4] {
    let [a, b, c, d] = words.map(unit);
    let pair = |a: f64, b: f64| {
        let (radius, (sin, cos)) = ((-2.0 * libm::log(a)).sqrt(), libm::sincos(TAU * b));
        [radius * cos, radius * sin]
    };
    let ([x, y], [z, w]) = (pair(a, b), pair(c, d));
    [x, y, z, w]
}

#[cfg(test)]
mod tests {
    use super::philox;

    /// The known answers of the authors' Random123 (`kat_vectors`), and of NumPy 2.4, which counts once before it
    /// draws: `numpy.random.Philox(key=[7, 0], counter=[4, 3, 2, 1]).random_raw(4)`.
    #[test]
    fn known_answers() {
        assert_eq!(
            philox([0; 2], [0; 4]),
            [0x1655_4d9e_ca36_314c, 0xdb20_fe9d_672d_0fdc, 0xd7e7_72ce_e186_176b, 0x7e68_b68a_ec7b_a23b]
        );
        assert_eq!(
            philox([u64::MAX; 2], [u64::MAX; 4]),
            [0x87b0_92c3_013f_e90b, 0x438c_3c67_be8d_0224, 0x9cc7_d7c6_9cd7_77b6, 0xa09c_aebf_594f_0ba0]
        );
        assert_eq!(
            philox([7, 0], [5, 3, 2, 1]),
            [0x0660_cebf_aa41_deb8, 0xc8ad_bb79_e32c_2574, 0xf771_3496_8321_c577, 0x28c5_7cae_cc41_4c5a]
        );
    }
}
