//! Logarithmic bins of whole numbers from 1 on: each octave [2ʲ, 2ʲ⁺¹) has four bins, and those of
//! 1 to 7 have one number each.

/// Number of bins of an octave.
const PER_OCTAVE: u64 = 4;

/// The bin of a number from 1 on.
pub(crate) fn bin_of(number: u64) -> usize {
    if number < PER_OCTAVE {
        return number as usize - 1;
    }
    let octave = number.ilog2() - 2;
    let quarter = (number >> octave) - PER_OCTAVE;
    (3 + PER_OCTAVE * u64::from(octave) + quarter) as usize
}

/// The smallest number of a bin.
pub(crate) fn smallest_of(bin: usize) -> u64 {
    let Some(beyond) = (bin as u64).checked_sub(3) else {
        return bin as u64 + 1;
    };
    (PER_OCTAVE + beyond % PER_OCTAVE) << (beyond / PER_OCTAVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_in_its_bin() {
        for number in (1..5000).chain([u64::from(u32::MAX), 1 << 40, 1 << 62]) {
            let bin = bin_of(number);
            assert!(
                smallest_of(bin) <= number && number < smallest_of(bin + 1),
                "{number} {bin}"
            );
        }
        let begins: Vec<u64> = (0..13).map(smallest_of).collect();
        assert_eq!(begins, [1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20]);
    }
}
