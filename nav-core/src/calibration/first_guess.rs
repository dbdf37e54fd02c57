//! Where the fit of a rig starts: the camera's pose out of equation 14's T, and planes through positions.

use nalgebra::{Matrix3, Matrix4x3, Rotation3, Vector3};

/// The pose of a pinhole in the gauge's frame out of T (equation 1).
///
/// With the ray r = K^-1 (u, v, 1), the point r / (m . r) of the camera frame lies at R^T (r / (m . r) - t) of the gauge's; so up to
/// a factor l, T's last row times K is l m^T, and the others, B, are l (R^T - R^T t m^T). Along directions square to m, B turns as R^T
/// does, which gives l and R; along m itself it then gives t.
pub(super) fn pose(t: &Matrix4x3<f64>, focal_px: f64, [u0, v0]: [f64; 2]) -> Option<(Rotation3<f64>, Vector3<f64>)> {
    let k = Matrix3::new(focal_px, 0.0, u0, 0.0, focal_px, v0, 0.0, 0.0, 1.0);
    let b = t.fixed_view::<3, 3>(0, 0) * k;
    let a = (t.row(3) * k).transpose();
    let along = a.try_normalize(1e-12)?;
    let aside = if along.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
    let first = along.cross(&aside).normalize();
    let second = along.cross(&first);
    let (of_first, of_second) = (b * first, b * second);
    let l = (of_first.norm() + of_second.norm()) / 2.0;
    let (of_first, of_second) = (of_first.try_normalize(1e-12)?, of_second.try_normalize(1e-12)?);
    // Noise has bent the right angle between them: both give way.
    let (sum, difference) = ((of_first + of_second).try_normalize(1e-9)?, (of_first - of_second).try_normalize(1e-9)?);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let (of_first, of_second) = ((sum + difference) * half, (sum - difference) * half);
    // Along, first, second are a right-handed set, and so must their images be.
    let images = Matrix3::from_columns(&[of_first.cross(&of_second), of_first, of_second]);
    let transposed = images * Matrix3::from_columns(&[along, first, second]).transpose();
    let rotation = Rotation3::from_matrix_eps(&transposed.transpose(), 1e-14, 100, Rotation3::identity());
    let q = (transposed * along * l - b * along) / a.norm();
    let translation = rotation * q;
    translation.iter().all(|x| x.is_finite()).then_some((rotation, translation))
}

/// m of the plane m . p = 1 through points; `None` where it passes through the origin.
pub(super) fn plane_through(points: &[Vector3<f64>]) -> Option<Vector3<f64>> {
    let middle = points.iter().sum::<Vector3<f64>>() / points.len().max(1) as f64;
    let scatter: Matrix3<f64> = points.iter().map(|point| (point - middle) * (point - middle).transpose()).sum();
    let eigen = scatter.symmetric_eigen();
    let least = (0..3).min_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]))?;
    let normal = eigen.eigenvectors.column(least).into_owned();
    let offset = normal.dot(&middle);
    (offset.abs() > 1e-3).then(|| normal / offset)
}
