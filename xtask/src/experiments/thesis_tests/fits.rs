//! The fits of the thesis's figures 2.3 and 2.4, to the published times and to those measured here.

use std::array;

use carom_tables::Figure;

/// A function of one variable with two parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Form {
    /// p₂ x² + p₁ x, figures 2.3(a) and 2.4.
    Quadratic,
    /// exp(k₀ + k₁ x), figure 2.3(b).
    Exponential,
}

/// Two fitted parameters, and their standard errors from the scatter of the points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// The function.
    pub form: Form,
    /// p₁ and p₂, or k₀ and k₁.
    pub parameters: [f64; 2],
    /// `None` with two points.
    pub errors: Option<[f64; 2]>,
}

/// Largest number of iterations of the least-squares search, which starts close to the solution.
const MAX_STEPS: usize = 100;

impl Form {
    /// Names of the parameters in the thesis, and their units where times are in seconds.
    fn names(self) -> [(&'static str, &'static str); 2] {
        match self {
            Self::Quadratic => [("p₁", "s"), ("p₂", "s")],
            Self::Exponential => [("k₀", "1"), ("k₁", "1")],
        }
    }

    /// Value at x, and derivatives with respect to the parameters.
    fn at(self, [a, b]: [f64; 2], x: f64) -> (f64, [f64; 2]) {
        match self {
            Self::Quadratic => (b * x * x + a * x, [x, x * x]),
            Self::Exponential => {
                let value = (a + b * x).exp();
                (value, [value, value * x])
            }
        }
    }

    /// Least squares of the values themselves, as in the thesis, so that large values have the
    /// largest weight. `None` if the points do not determine the parameters.
    pub fn through(self, points: &[(f64, f64)]) -> Option<Fit> {
        let mut parameters = self.start(points)?;
        let (mut squares, mut step) = (self.squares(parameters, points), 1.0);
        for _ in 0..MAX_STEPS {
            let ([[aa, ab], [_, bb]], [ra, rb]) = self.normal_equations(parameters, points);
            let determinant = aa * bb - ab * ab;
            let change = [
                (bb * ra - ab * rb) / determinant,
                (aa * rb - ab * ra) / determinant,
            ];
            let next = array::from_fn(|n| parameters[n] + step * change[n]);
            let next_squares = self.squares(next, points);
            if next_squares < squares {
                (parameters, squares, step) = (next, next_squares, 1.0);
            } else if step < 1e-6 || next_squares.is_nan() {
                break;
            } else {
                step *= 0.25;
            }
        }
        let ([[aa, ab], [_, bb]], _) = self.normal_equations(parameters, points);
        let variance = squares / (points.len() as f64 - 2.0) / (aa * bb - ab * ab);
        let errors = (points.len() > 2).then(|| [(variance * bb).sqrt(), (variance * aa).sqrt()]);
        parameters.iter().all(|p| p.is_finite()).then_some(Fit {
            form: self,
            parameters,
            errors,
        })
    }

    /// Initial parameters: the curve through the two points with the largest x.
    fn start(self, points: &[(f64, f64)]) -> Option<[f64; 2]> {
        let mut points = points.to_vec();
        points.sort_by(|one, other| other.0.total_cmp(&one.0));
        points.dedup_by_key(|point| point.0);
        let [(x, y), (u, v)] = *points.first_chunk()?;
        Some(match self {
            Self::Quadratic => {
                let second = (y / x - v / u) / (x - u);
                [y / x - second * x, second]
            }
            Self::Exponential => {
                let rate = (y / v).ln() / (x - u);
                [y.ln() - rate * x, rate]
            }
        })
    }

    fn squares(self, parameters: [f64; 2], points: &[(f64, f64)]) -> f64 {
        points
            .iter()
            .map(|&(x, y)| (y - self.at(parameters, x).0).powi(2))
            .sum()
    }

    /// JᵀJ and Jᵀr of the residuals r = y − f(x).
    fn normal_equations(
        self,
        parameters: [f64; 2],
        points: &[(f64, f64)],
    ) -> ([[f64; 2]; 2], [f64; 2]) {
        let (mut matrix, mut right) = ([[0.0; 2]; 2], [0.0; 2]);
        for &(x, y) in points {
            let (value, slopes) = self.at(parameters, x);
            for row in 0..2 {
                right[row] += slopes[row] * (y - value);
                for column in 0..2 {
                    matrix[row][column] += slopes[row] * slopes[column];
                }
            }
        }
        (matrix, right)
    }
}

impl Fit {
    /// Value at x.
    pub fn value(&self, x: f64) -> f64 {
        self.form.at(self.parameters, x).0
    }

    /// The parameters as figures of a summary, with the published values if there are any.
    pub fn figures(&self, of: &str, thesis: Option<([f64; 2], &str)>) -> Vec<Figure> {
        let one = |n: usize| {
            let (symbol, unit) = self.form.names()[n];
            let name = format!("{of}: {symbol} of the thesis's fit");
            let error = self.errors.map(|errors| errors[n]);
            let figure = Figure::new(name, self.parameters[n], unit).error(error);
            match thesis {
                Some((values, source)) => figure.predicted(values[n], source),
                None => figure,
            }
        };
        vec![one(0), one(1)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_on_a_curve_give_its_parameters() {
        for (form, planted) in [
            (Form::Quadratic, [-0.8, 3.15e-3]),
            (Form::Exponential, [1.27, 2.23e-3]),
        ] {
            let points: Vec<(f64, f64)> = [50.0, 100.0, 500.0, 1000.0, 2000.0]
                .map(|x| (x, form.at(planted, x).0))
                .to_vec();
            let fit = form.through(&points).unwrap();
            for (found, planted) in fit.parameters.into_iter().zip(planted) {
                assert!((found / planted - 1.0).abs() < 1e-9, "{fit:?}");
            }
            assert!(fit.errors.unwrap().iter().all(|error| *error < 1e-6));
            assert_eq!(form.through(&points[..1]), None);
            assert_eq!(form.through(&points[3..]).unwrap().errors, None);
        }
    }

    /// For y = p₁ x + p₂ x² and the points (1, 1), (2, 3), (3, 7): JᵀJ = [14 36; 36 98], Jᵀy = [28,
    /// 76], hence p₁ = 8/76, p₂ = 56/76, and the residual sum of squares is 0.1053.
    #[test]
    fn errors_are_those_of_least_squares() {
        let fit = Form::Quadratic
            .through(&[(1.0, 1.0), (2.0, 3.0), (3.0, 7.0)])
            .unwrap();
        let [p1, p2] = fit.parameters;
        assert!(
            (p1 - 8.0 / 76.0).abs() < 1e-12 && (p2 - 56.0 / 76.0).abs() < 1e-12,
            "{fit:?}"
        );
        let squares = [
            1.0 - p1 - p2,
            3.0 - 2.0 * p1 - 4.0 * p2,
            7.0 - 3.0 * p1 - 9.0 * p2,
        ];
        let variance: f64 = squares.iter().map(|r| r * r).sum();
        let [e1, e2] = fit.errors.unwrap();
        assert!((e1 - (variance * 98.0 / 76.0).sqrt()).abs() < 1e-12);
        assert!((e2 - (variance * 14.0 / 76.0).sqrt()).abs() < 1e-12);
    }

    /// Table 2.1 with a grid. The figure's caption prints k₁ as 223·10⁻⁶, by which 2000 discs would
    /// take 5.6 s instead of 314 s: the exponent is misprinted, and the table gives 223·10⁻⁵.
    #[test]
    fn the_table_of_the_thesis_gives_its_parameters() {
        let points = [
            (50.0, 0.343),
            (100.0, 1.0),
            (500.0, 10.64),
            (1000.0, 35.437),
            (2000.0, 313.641),
        ];
        let fit = Form::Exponential.through(&points).unwrap();
        assert!((fit.parameters[0] - 1.27).abs() < 0.16, "{fit:?}");
        assert!((fit.parameters[1] - 223e-5).abs() < 8e-5, "{fit:?}");
    }
}
