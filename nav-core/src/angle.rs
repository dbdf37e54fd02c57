//! Angles and rotations, from `libm` so that every processor gives the same bits.

use nalgebra::{Matrix3, Rotation3};

/// Right-handed rotation about x.
pub fn rotation_about_x(angle_rad: f64) -> Rotation3<f64> {
    let (s, c) = libm::sincos(angle_rad);
    Rotation3::from_matrix_unchecked(Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c))
}

/// Right-handed rotation about y.
pub fn rotation_about_y(angle_rad: f64) -> Rotation3<f64> {
    let (s, c) = libm::sincos(angle_rad);
    Rotation3::from_matrix_unchecked(Matrix3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c))
}

/// Right-handed rotation about z.
pub fn rotation_about_z(angle_rad: f64) -> Rotation3<f64> {
    let (s, c) = libm::sincos(angle_rad);
    Rotation3::from_matrix_unchecked(Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0))
}

/// The same angle in (-pi, pi].
pub fn wrap(angle_rad: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    let turned = angle_rad - TAU * (angle_rad / TAU).round();
    if turned <= -PI { turned + TAU } else { turned }
}
