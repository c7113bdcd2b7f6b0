//! Numbers of 200 bits, from `dashu_float`.

use dashu_float::{FBig, round::mode::HalfEven};

use super::Number;

/// A number of 200 bits.
#[derive(Debug, Clone)]
pub struct BigFloat(FBig<HalfEven, 2>);

const PRECISION: usize = 200;

impl Number for BigFloat {
    const SKETCH_FIRST: bool = false;

    fn new(value: f64) -> Self {
        let exact = FBig::try_from(value).expect("the oracle works with finite numbers");
        Self(exact.with_precision(PRECISION).value())
    }

    fn value(&self) -> f64 {
        self.0.to_f64().value()
    }

    fn plus(&self, other: &Self) -> Self {
        Self(&self.0 + &other.0)
    }

    fn minus(&self, other: &Self) -> Self {
        Self(&self.0 - &other.0)
    }

    fn times(&self, other: &Self) -> Self {
        Self(&self.0 * &other.0)
    }

    fn over(&self, other: &Self) -> Self {
        Self(&self.0 / &other.0)
    }

    fn root(&self) -> Self {
        Self(self.0.sqrt())
    }

    fn cos_sin(turns: f64, spin: f64, time: &Self) -> [Self; 2] {
        let tau = Self(FBig::pi(PRECISION) * FBig::from(2));
        let angle = Self::new(turns)
            .times(&tau)
            .plus(&Self::new(spin).times(time));
        let (sin, cos) = angle.0.sin_cos();
        [Self(cos), Self(sin)]
    }
}
