//! Singular values of a small matrix by one-sided Jacobi rotations (Hestenes 1958; Demmel and Veselic 1992: small ones come out
//! with as many digits as large ones). Fixed size, so the same bits everywhere.

use nalgebra::SMatrix;

/// Singular values below this share of the largest count as none.
pub const NOTHING: f64 = 1e-9;
/// Sweeps over all pairs of columns; six or seven are needed.
const SWEEPS: usize = 40;

/// Rank and condition of a matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditioning {
    /// Singular values above [`NOTHING`] of the largest.
    pub rank: usize,
    /// Largest singular value over the least; infinite where that is zero.
    pub condition: f64,
}

/// Singular values, the largest first.
pub fn values<const R: usize, const N: usize>(mut a: SMatrix<f64, R, N>) -> [f64; N] {
    for _ in 0..SWEEPS {
        let mut settled = true;
        for i in 0..N {
            for j in i + 1..N {
                let (p, q, dot) = (a.column(i).norm_squared(), a.column(j).norm_squared(), a.column(i).dot(&a.column(j)));
                if dot * dot <= 1e-30 * p * q || dot == 0.0 {
                    continue;
                }
                settled = false;
                // The rotation after which the two columns are square to each other.
                let zeta = (q - p) / (2.0 * dot);
                let t = zeta.signum() / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
                let c = 1.0 / (1.0 + t * t).sqrt();
                let s = c * t;
                for k in 0..R {
                    let (x, y) = (a[(k, i)], a[(k, j)]);
                    a[(k, i)] = c * x - s * y;
                    a[(k, j)] = s * x + c * y;
                }
            }
        }
        if settled {
            break;
        }
    }
    let mut values: [f64; N] = std::array::from_fn(|i| a.column(i).norm());
    values.sort_by(|x, y| y.total_cmp(x));
    values
}

/// Rank and condition of a matrix.
pub fn conditioning<const R: usize, const N: usize>(a: SMatrix<f64, R, N>) -> Conditioning {
    let values = values(a);
    let (largest, least) = (values[0], values[N - 1]);
    let rank = values.iter().filter(|value| **value > NOTHING * largest).count();
    Conditioning { rank, condition: if least > 0.0 { largest / least } else { f64::INFINITY } }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Rotation3, Vector3};

    #[test]
    fn a_turned_diagonal_keeps_its_values() {
        let turn = |x, y, z| Rotation3::from_scaled_axis(Vector3::new(x, y, z)).into_inner();
        for least in [0.5, 1e-12] {
            let a = turn(0.3, -1.0, 0.2) * Matrix3::from_diagonal(&Vector3::new(7.0, 1e-3, least)) * turn(-0.4, 0.1, 2.0);
            let [largest, .., last] = values(a);
            assert!((largest - 7.0).abs() < 1e-14, "{largest}");
            // The product above has rounded its entries to 1e-16 of 7.
            assert!((last - least.min(1e-3)).abs() < 3e-15, "{last}");
        }
    }

    #[test]
    fn rank_counts_what_is_there() {
        let flat = Matrix3::new(1.0, 2.0, 3.0, 2.0, 4.0, 6.0, 1.0, 0.0, 1.0);
        assert_eq!(conditioning(flat).rank, 2);
        assert_eq!(conditioning(Matrix3::zeros()), Conditioning { rank: 0, condition: f64::INFINITY });
        assert_eq!(conditioning(Matrix3::identity()), Conditioning { rank: 3, condition: 1.0 });
    }
}
