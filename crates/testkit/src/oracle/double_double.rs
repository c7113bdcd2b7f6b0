//! Numbers of 106 bits as the unevaluated sum of two doubles (Dekker 1971; Hida, Li and Bailey
//! 2001).

use std::sync::LazyLock;

use super::Number;

/// hi + lo, |lo| ≤ ulp(hi)/2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DoubleDouble {
    hi: f64,
    lo: f64,
}

const TAU: DoubleDouble = DoubleDouble {
    hi: std::f64::consts::TAU,
    lo: 2.449_293_598_294_706_4e-16,
};

/// 1/n! for n = 0, 1, …, 29: sufficient for sine and cosine up to π/4 to 106 bits.
static INVERSE_FACTORIALS: LazyLock<Vec<DoubleDouble>> = LazyLock::new(|| {
    let mut factorial = DoubleDouble::new(1.0);
    (0..30u8)
        .map(|n| {
            factorial = factorial.times(&DoubleDouble::new(f64::from(n.max(1))));
            DoubleDouble::new(1.0).over(&factorial)
        })
        .collect()
});

/// Exact sum after Knuth.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

/// Exact product.
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    (product, a.mul_add(b, -product))
}

impl DoubleDouble {
    fn normalised(hi: f64, lo: f64) -> Self {
        let sum = hi + lo;
        Self {
            hi: sum,
            lo: lo - (sum - hi),
        }
    }

    fn negated(self) -> Self {
        Self {
            hi: -self.hi,
            lo: -self.lo,
        }
    }

    /// Fractional part; exact.
    fn fraction(self) -> Self {
        let once = self.minus(&Self::new(self.hi.round()));
        once.minus(&Self::new(once.hi.round()))
    }

    /// Σ x^(n+2k) (−1)^k / (n+2k)! for n = 0 or 1.
    fn alternating_series(self, first: usize) -> Self {
        let minus_square = self.times(&self).negated();
        let terms = INVERSE_FACTORIALS.iter().skip(first).step_by(2).rev();
        let sum = terms.fold(Self::new(0.0), |sum, term| {
            sum.times(&minus_square).plus(term)
        });
        if first == 1 { sum.times(&self) } else { sum }
    }
}

impl Number for DoubleDouble {
    const SKETCH_FIRST: bool = true;

    fn new(value: f64) -> Self {
        Self { hi: value, lo: 0.0 }
    }

    fn value(&self) -> f64 {
        self.hi
    }

    fn plus(&self, other: &Self) -> Self {
        let (high, error) = two_sum(self.hi, other.hi);
        let (low, low_error) = two_sum(self.lo, other.lo);
        let once = Self::normalised(high, error + low);
        Self::normalised(once.hi, once.lo + low_error)
    }

    fn minus(&self, other: &Self) -> Self {
        self.plus(&other.negated())
    }

    fn times(&self, other: &Self) -> Self {
        let (high, error) = two_product(self.hi, other.hi);
        Self::normalised(high, error + (self.hi * other.lo + self.lo * other.hi))
    }

    fn over(&self, other: &Self) -> Self {
        let first = self.hi / other.hi;
        let rest = self.minus(&other.times(&Self::new(first)));
        let second = rest.hi / other.hi;
        let rest = rest.minus(&other.times(&Self::new(second)));
        Self::normalised(first, second).plus(&Self::new(rest.hi / other.hi))
    }

    fn root(&self) -> Self {
        if self.hi <= 0.0 {
            return Self::new(0.0);
        }
        // One Newton step from a double doubles the number of digits.
        let guess = Self::new(self.hi.sqrt());
        let rest = self.minus(&guess.times(&guess));
        guess.plus(&Self::new(rest.hi / (2.0 * guess.hi)))
    }

    fn cos_sin(turns: f64, spin: f64, time: &Self) -> [Self; 2] {
        static INVERSE_TAU: LazyLock<DoubleDouble> =
            LazyLock::new(|| DoubleDouble::new(1.0).over(&TAU));
        let turned = time.times(&Self::new(spin)).times(&INVERSE_TAU).fraction();
        let turns = turned.plus(&Self::new(turns)).fraction();
        let quarter = (4.0 * turns.hi).round();
        let angle = turns.minus(&Self::new(0.25 * quarter)).times(&TAU);
        let (cos, sin) = (angle.alternating_series(0), angle.alternating_series(1));
        match quarter as i64 & 3 {
            0 => [cos, sin],
            1 => [sin.negated(), cos],
            2 => [cos.negated(), sin.negated()],
            _ => [sin, cos.negated()],
        }
    }
}
