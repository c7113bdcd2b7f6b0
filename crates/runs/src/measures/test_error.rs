//! The standard error of a mean that tests its prediction.
//!
//! [`Estimate::of_runs`] counts correlations of blocks, of either sign. From 30 to 63 independent
//! blocks it is sometimes much too small by chance, because it takes them for blocks that cancel
//! one another: chance then exceeds four such errors once in 400 means, and not once in 2500
//! (Student's t). A test therefore has at least the error of independent blocks, which chance
//! exceeds as rarely as Student's t. The error of blocks that do cancel is then too large: the test
//! finds less, and raises no false alarm.

use carom_tables::{Estimate, Figure};

/// The mean of these [x, w] of the blocks of each run, without the error of a test if fewer than 30
/// of the blocks have weight; a test has at least the error of independent blocks.
pub fn judged_by_blocks(figure: Figure, runs: &[Vec<[f64; 2]>]) -> Figure {
    let with_weight = runs.iter().flatten().filter(|block| block[1] > 0.0);
    let blocks: Vec<(f64, f64)> = with_weight.map(|&[x, w]| (x, w)).collect();
    let count = blocks.len();
    let independent = Estimate::of_ratio(blocks).map_or(0.0, |found| found.standard_error);
    // An error of 0 is that of a conserved quantity, whose blocks differ by rounding.
    let of_test = |error: f64| {
        if error > 0.0 {
            error.max(independent)
        } else {
            error
        }
    };
    let standard_error = if figure.is_test {
        figure.standard_error.map(of_test)
    } else {
        figure.standard_error
    };
    Figure {
        standard_error,
        ..figure
    }
    .judged_by(count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_tables::{MIN_BLOCKS, THRESHOLD};

    fn test(value: f64, error: f64) -> Figure {
        Figure::new("v", value, "1")
            .error(error)
            .predicted(0.0, "symmetry")
            .test()
    }

    /// Numbers of variance 1 and mean 0, each the sum of twelve uniform ones.
    fn noise(state: &mut u64) -> f64 {
        let mut uniform = || {
            *state ^= *state << 13;
            *state ^= *state >> 7;
            *state ^= *state << 17;
            (*state >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }

    #[test]
    fn tests_of_independent_blocks_give_no_more_false_alarms_than_student_s_t() {
        let mut state = 0x9E37_79B9_7F4A_7C15;
        let [mut alarms, mut of_correlated] = [0; 2];
        for _ in 0..20_000 {
            let run: Vec<[f64; 2]> = (0..MIN_BLOCKS).map(|_| [noise(&mut state), 1.0]).collect();
            let runs = [run];
            let found = Estimate::of_runs(&runs).unwrap();
            let figure = test(found.mean, found.standard_error);
            let is_alarm = |figure: &Figure| figure.deviation().unwrap() > THRESHOLD;
            of_correlated += u32::from(is_alarm(&figure));
            alarms += u32::from(is_alarm(&judged_by_blocks(figure, &runs)));
        }
        // Once in 2500 is 8 times; about 4 times are expected, and 56 times without this rule.
        assert!(alarms <= 15, "{alarms}");
        assert!(of_correlated > 25, "{of_correlated}");
    }

    #[test]
    fn blocks_without_weight_are_none_and_a_conserved_quantity_stays_without_error() {
        let block = |n: usize| [1.0 + 0.1 * (n % 3) as f64, 1.0];
        let mut run: Vec<[f64; 2]> = (0..MIN_BLOCKS).map(block).collect();
        let runs = [run.clone()];
        let error = |figure: Figure| judged_by_blocks(figure, &runs).standard_error;
        assert_eq!(error(test(1.0, 0.0)), Some(0.0));
        assert_eq!(error(test(1.0, 9.0)), Some(9.0));
        let independent = Estimate::of_ratio(run.iter().map(|&[x, w]| (x, w))).unwrap();
        let least = judged_by_blocks(test(1.0, 1e-9), &runs);
        assert_eq!(least.standard_error, Some(independent.standard_error));
        assert_eq!(least.clone().resolved(), least, "with its difference");
        // What is no test keeps its error.
        assert_eq!(error(Figure::new("v", 1.0, "1").error(1e-9)), Some(1e-9));
        // One block fewer, as in a run in which nothing happened for that long.
        run[3] = [0.0, 0.0];
        assert_eq!(
            judged_by_blocks(test(1.0, 0.1), &[run]).standard_error,
            None
        );
    }
}
