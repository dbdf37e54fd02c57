//! The side walls of a duct as one measurement, for an estimator that weighs it.

use nalgebra::Matrix3;

/// What one frame says of the side walls, with the covariance of all of it.
///
/// Distances are measured at the base's origin, the stripes lie ahead of it, and the heading carries the one to the other: so both
/// distances err together with the heading, and a weight that knew only the three deviations would be wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SideWalls {
    /// Heading of the robot against the walls, anticlockwise positive, in radians.
    pub heading_rad: f64,
    /// Distance of the left wall from the base's origin, in metres; `None` if it was not seen.
    pub left_m: Option<f64>,
    /// Distance of the right wall from the base's origin, in metres; `None` if it was not seen.
    pub right_m: Option<f64>,
    /// Covariance of (heading, left, right), in rad^2, rad m and m^2. Rows and columns of a wall that was not seen do not count.
    pub covariance: Matrix3<f64>,
}

impl SideWalls {
    /// Walls whose distances and heading err independently of each other.
    pub fn independent(
        heading_rad: f64,
        left_m: Option<f64>,
        right_m: Option<f64>,
        heading_sigma_rad: f64,
        distance_sigma_m: f64,
    ) -> Self {
        let (h, d) = (heading_sigma_rad * heading_sigma_rad, distance_sigma_m * distance_sigma_m);
        Self { heading_rad, left_m, right_m, covariance: Matrix3::new(h, 0.0, 0.0, 0.0, d, 0.0, 0.0, 0.0, d) }
    }

    /// How many of heading and distances there are.
    pub fn freedom(&self) -> usize {
        1 + usize::from(self.left_m.is_some()) + usize::from(self.right_m.is_some())
    }
}
