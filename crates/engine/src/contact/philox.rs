//! Random numbers without a state: a block of four numbers is a function of a key and a counter.
//!
//! Philox4x64 with ten rounds (J. K. Salmon, M. A. Moraes, R. O. Dror & D. E. Shaw, Proc. SC11
//! (2011), doi:10.1145/2063384.2063405). Each use has its own counter, so a resumed run needs no
//! position in a stream, and the numbers of one body do not depend on the other bodies.

const ROUNDS: usize = 10;

/// The multipliers and the increments of the key of Salmon et al., table 2.
const MULTIPLIERS: [u64; 2] = [0xD2E7_470E_E14C_6C93, 0xCA5A_8263_9512_1157];
const INCREMENTS: [u64; 2] = [0x9E37_79B9_7F4A_7C15, 0xBB67_AE85_84CA_A73B];

/// Four independent random numbers, uniform over all 64-bit numbers, for this counter.
pub(crate) fn philox(key: [u64; 2], counter: [u64; 4]) -> [u64; 4] {
    let (mut key, mut block) = (key, counter);
    for round in 0..ROUNDS {
        if round > 0 {
            key = [
                key[0].wrapping_add(INCREMENTS[0]),
                key[1].wrapping_add(INCREMENTS[1]),
            ];
        }
        let [(high_0, low_0), (high_1, low_1)] = [
            product(MULTIPLIERS[0], block[0]),
            product(MULTIPLIERS[1], block[2]),
        ];
        block = [
            high_1 ^ block[1] ^ key[0],
            low_1,
            high_0 ^ block[3] ^ key[1],
            low_0,
        ];
    }
    block
}

/// The upper and the lower half of a product.
fn product(first: u64, second: u64) -> (u64, u64) {
    let product = u128::from(first) * u128::from(second);
    ((product >> 64) as u64, product as u64)
}

/// A uniform number above 0 and below 1: an odd multiple of 2⁻⁵³.
pub(crate) fn open_unit(bits: u64) -> f64 {
    const HALF_STEP: f64 = 1.0 / (1u64 << 53) as f64;
    (2 * (bits >> 12) + 1) as f64 * HALF_STEP
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From the file `kat_vectors` of the library Random123 by the same authors.
    #[test]
    fn the_known_answers_of_the_authors_are_found() {
        assert_eq!(
            philox([0; 2], [0; 4]),
            [
                0x1655_4d9e_ca36_314c,
                0xdb20_fe9d_672d_0fdc,
                0xd7e7_72ce_e186_176b,
                0x7e68_b68a_ec7b_a23b
            ]
        );
        assert_eq!(
            philox([u64::MAX; 2], [u64::MAX; 4]),
            [
                0x87b0_92c3_013f_e90b,
                0x438c_3c67_be8d_0224,
                0x9cc7_d7c6_9cd7_77b6,
                0xa09c_aebf_594f_0ba0
            ]
        );
        let digits_of_pi = [
            0x243f_6a88_85a3_08d3,
            0x1319_8a2e_0370_7344,
            0xa409_3822_299f_31d0,
            0x082e_fa98_ec4e_6c89,
        ];
        assert_eq!(
            philox([0x4528_21e6_38d0_1377, 0xbe54_66cf_34e9_0c6c], digits_of_pi),
            [
                0xa528_f454_03e6_1d95,
                0x38c7_2dbd_566e_9788,
                0xa5a1_610e_72fd_18b5,
                0x57bd_43b5_e52b_7fe6
            ]
        );
    }

    #[test]
    fn units_are_open_at_both_ends() {
        assert_eq!(open_unit(0), 2f64.powi(-53));
        assert_eq!(open_unit(u64::MAX), 1.0 - 2f64.powi(-53));
    }
}
