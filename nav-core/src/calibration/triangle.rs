//! Linear least squares in fixed memory: rows are rotated one by one into an upper triangle (Givens; Golub and Van Loan, Matrix
//! Computations, 4th ed., 5.2.5), which never squares the condition as normal equations do.

use nalgebra::{SMatrix, SVector};

/// R of the QR decomposition of all rows so far, with the right-hand side rotated along.
#[derive(Clone, Debug, PartialEq)]
pub struct Triangle<const N: usize> {
    /// R, upper triangular.
    pub r: SMatrix<f64, N, N>,
    /// The first N rotated values of the right-hand side.
    pub right_side: SVector<f64, N>,
    /// Sum of the squares of the others: what the solution leaves.
    pub residual_squared: f64,
}

impl<const N: usize> Default for Triangle<N> {
    fn default() -> Self {
        Self { r: SMatrix::zeros(), right_side: SVector::zeros(), residual_squared: 0.0 }
    }
}

impl<const N: usize> Triangle<N> {
    /// Takes in the equation `row . x = value`.
    pub fn add(&mut self, mut row: SVector<f64, N>, mut value: f64) {
        for i in 0..N {
            if row[i] == 0.0 {
                continue;
            }
            let (a, b) = (self.r[(i, i)], row[i]);
            let length = (a * a + b * b).sqrt();
            let (c, s) = (a / length, b / length);
            for j in i..N {
                let (above, below) = (self.r[(i, j)], row[j]);
                self.r[(i, j)] = c * above + s * below;
                row[j] = c * below - s * above;
            }
            let above = self.right_side[i];
            self.right_side[i] = c * above + s * value;
            value = c * value - s * above;
        }
        self.residual_squared += value * value;
    }

    /// The x of least squares; `None` where R is singular.
    pub fn solve(&self) -> Option<SVector<f64, N>> {
        self.back(self.right_side)
    }

    /// x of R x = b.
    pub fn back(&self, mut b: SVector<f64, N>) -> Option<SVector<f64, N>> {
        for i in (0..N).rev() {
            for j in i + 1..N {
                b[i] -= self.r[(i, j)] * b[j];
            }
            b[i] /= self.r[(i, i)];
        }
        b.iter().all(|x| x.is_finite()).then_some(b)
    }

    /// x of R^T x = b.
    pub fn forward(&self, mut b: SVector<f64, N>) -> Option<SVector<f64, N>> {
        for i in 0..N {
            for j in 0..i {
                b[i] -= self.r[(j, i)] * b[j];
            }
            b[i] /= self.r[(i, i)];
        }
        b.iter().all(|x| x.is_finite()).then_some(b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line through four points, worked out by hand.
    #[test]
    fn a_line_through_points_is_least_squares() {
        let mut triangle = Triangle::<2>::default();
        for (x, y) in [(0.0, 1.0), (1.0, 1.0), (2.0, 2.0), (3.0, 2.0)] {
            triangle.add([1.0, x].into(), y);
        }
        let x = triangle.solve().expect("a line");
        // Means 1.5 and 1.5; slope = sum of dx dy / sum of dx^2 = 2 / 5.
        assert!((x - SVector::from([0.9, 0.4])).norm() < 1e-14, "{x}");
        // Residuals 0.1, -0.3, 0.3, -0.1.
        assert!((triangle.residual_squared - 0.2).abs() < 1e-14, "{}", triangle.residual_squared);
        let b = SVector::from([0.3, -2.0]);
        let there = triangle.r.transpose() * triangle.forward(b).expect("regular");
        assert!((there - b).norm() < 1e-14);
    }

    #[test]
    fn nothing_comes_of_too_few_rows() {
        let mut triangle = Triangle::<2>::default();
        triangle.add([1.0, 2.0].into(), 3.0);
        assert_eq!(triangle.solve(), None);
    }
}
