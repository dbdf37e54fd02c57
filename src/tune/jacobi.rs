//! Eigenvalues of a symmetric matrix by cyclic Jacobi rotations (Golub and Van Loan, *Matrix Computations*, 4th edition, 8.5): the same to the
//! bit on every machine, which kernels that are picked by processor are not.

/// Sweeps over all pairs at most: convergence is quadratic, and ten are more than enough for the sizes here.
const SWEEPS: usize = 60;

/// Eigenvalues and eigenvectors (by columns) of a symmetric matrix of `n` rows.
pub fn eigen(matrix: &[f64], n: usize) -> (Vec<f64>, Vec<f64>) {
    let mut a = matrix.to_vec();
    let mut v: Vec<f64> = (0..n * n).map(|i| if i % (n + 1) == 0 { 1.0 } else { 0.0 }).collect();
    for _ in 0..SWEEPS {
        let mut changed = false;
        for p in 0..n {
            for q in p + 1..n {
                let (app, aqq, apq) = (a[p * n + p], a[q * n + q], a[p * n + q]);
                // Nothing that a rotation would change.
                if app.abs() + apq.abs() == app.abs() && aqq.abs() + apq.abs() == aqq.abs() {
                    continue;
                }
                changed = true;
                let tau = (aqq - app) / (2.0 * apq);
                let t = tau.signum() / (tau.abs() + (1.0 + tau * tau).sqrt());
                let c = 1.0 / (1.0 + t * t).sqrt();
                let s = t * c;
                for k in 0..n {
                    let (akp, akq) = (a[k * n + p], a[k * n + q]);
                    a[k * n + p] = c * akp - s * akq;
                    a[k * n + q] = s * akp + c * akq;
                }
                for k in 0..n {
                    let (apk, aqk) = (a[p * n + k], a[q * n + k]);
                    a[p * n + k] = c * apk - s * aqk;
                    a[q * n + k] = s * apk + c * aqk;
                }
                for k in 0..n {
                    let (vkp, vkq) = (v[k * n + p], v[k * n + q]);
                    v[k * n + p] = c * vkp - s * vkq;
                    v[k * n + q] = s * vkp + c * vkq;
                }
            }
        }
        if !changed {
            break;
        }
    }
    ((0..n).map(|i| a[i * n + i]).collect(), v)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix of known eigenvalues, mixed by a reflection: they come back, and the matrix out of them.
    #[test]
    fn eigenvalues_and_vectors_make_the_matrix() {
        let n = 7;
        let values: Vec<f64> = (0..n).map(|i| libm::pow(10.0, i as f64 - 2.0)).collect();
        let unit: Vec<f64> = (0..n).map(|i| (i as f64 + 1.0) / (140.0_f64).sqrt()).collect();
        let reflection = |i: usize, j: usize| f64::from(u8::from(i == j)) - 2.0 * unit[i] * unit[j];
        let entry = |i: usize, j: usize| (0..n).map(|k| reflection(i, k) * values[k] * reflection(j, k)).sum::<f64>();
        let matrix: Vec<f64> = (0..n * n).map(|at| entry((at / n).max(at % n), (at / n).min(at % n))).collect();
        let (found, basis) = eigen(&matrix, n);
        let mut sorted = found.clone();
        sorted.sort_by(f64::total_cmp);
        for (found, value) in sorted.iter().zip(&values) {
            assert!((found - value).abs() < 1e-10 * values[n - 1], "{found} {value}");
        }
        for i in 0..n {
            for j in 0..n {
                let made: f64 = (0..n).map(|k| basis[i * n + k] * found[k] * basis[j * n + k]).sum();
                assert!((made - matrix[i * n + j]).abs() < 1e-9 * values[n - 1]);
                let dot: f64 = (0..n).map(|k| basis[k * n + i] * basis[k * n + j]).sum();
                assert!((dot - f64::from(u8::from(i == j))).abs() < 1e-12);
            }
        }
    }
}
