//! Coordinates moved to the middle of their points and scaled to the size of one (Hartley, PAMI 19(6), 1997).
//!
//! Equation 14 multiplies pixels of some hundreds with millimetres of some hundreds and sets the products beside ones: on the
//! paper's tables its condition is 5e5 and 9e5. Scaled, it is 10 and 12.

use nalgebra::{Matrix3, Matrix4, Matrix4x3, SVector};

use super::pairs::Pair;

/// Where the middle of a set of points is, and how far they lie from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale<const D: usize> {
    /// Their mean.
    pub middle: SVector<f64, D>,
    /// Root of the mean square of their coordinates about it.
    pub size: f64,
}

impl<const D: usize> Scale<D> {
    /// Of points of which two at least differ.
    pub fn of(points: impl Iterator<Item = [f64; D]> + Clone) -> Self {
        let count = points.clone().count().max(1) as f64;
        let middle = points.clone().map(SVector::from).sum::<SVector<f64, D>>() / count;
        let squares: f64 = points.map(|point| (SVector::from(point) - middle).norm_squared()).sum();
        Self { middle, size: (squares / (count * D as f64)).sqrt().max(f64::MIN_POSITIVE) }
    }

    /// A point in scaled coordinates.
    pub fn scaled(&self, point: [f64; D]) -> SVector<f64, D> {
        (SVector::from(point) - self.middle) / self.size
    }
}

/// The scales of pixels and of positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales {
    /// Of pixels.
    pub pixel: Scale<2>,
    /// Of positions, in millimetres.
    pub position: Scale<3>,
}

impl Scales {
    /// Of a set of pairs.
    pub fn of(pairs: &[Pair]) -> Self {
        Self {
            pixel: Scale::of(pairs.iter().map(|pair| pair.pixel_px)),
            position: Scale::of(pairs.iter().map(|pair| pair.position_mm)),
        }
    }

    /// T between pixels and millimetres, of T between scaled pixels and scaled positions.
    pub fn unscaled(&self, scaled: &Matrix4x3<f64>) -> Matrix4x3<f64> {
        let (pixel, position) = (self.pixel, self.position);
        let mut of_position = Matrix4::identity() * position.size;
        of_position[(3, 3)] = 1.0;
        of_position.fixed_view_mut::<3, 1>(0, 3).copy_from(&position.middle);
        let [u0, v0]: [f64; 2] = (pixel.middle / pixel.size).into();
        let to_pixel = Matrix3::new(1.0 / pixel.size, 0.0, -u0, 0.0, 1.0 / pixel.size, -v0, 0.0, 0.0, 1.0);
        of_position * scaled * to_pixel
    }
}
