//! The paper's calibration: the matrix T of one laser from pixels of known position (equation 14).
//!
//! Equation 1 with t43 = 1 (equation 13, where t21 stands twice) is, for a point at (x, y, z) seen at (u, v),
//!
//! ```text
//! t11 u + t12 v + t13 = x (t41 u + t42 v + 1)
//! t21 u + t22 v + t23 = y (t41 u + t42 v + 1)
//! t31 u + t32 v + t33 = z (t41 u + t42 v + 1)
//! ```
//!
//! linear in the eleven unknowns t11 ... t33, t41, t42. (Equation 14 prints rows of ten columns and leaves t32 and t33 out of
//! the vector of unknowns.) It is solved as it stands, in coordinates scaled by [`super::scaling`]; so the s that is held at one
//! is that of the pixels' middle, not that of pixel (0, 0), and T does not depend on where pixels are counted from. Only for the
//! printed form is T then divided by t43.
//!
//! The residual that is minimised is algebraic: s times the miss in millimetres. Minimising the miss itself (Gauss and Newton
//! from here) gains 0.1 mm at most on the paper's own points and may lose on those left out: 5.98 against 6.43 mm on the right laser's
//! thirteen points, but 6.03 against 2.78 mm on the left's six. So it is not offered.

use nalgebra::{Matrix3, Matrix4x3, Point3, SMatrix, SVector, Vector3};

use super::pairs::{self, Pair, PairsError};
use super::scaling::Scales;
use super::singular::{self, Conditioning};
use super::triangle::Triangle;

/// Unknowns of T.
const UNKNOWNS: usize = 11;
/// Up to so many points, T is solved anew without each of them; that takes as many solutions.
const SOLVED_ANEW: usize = 300;
type Unknowns = SVector<f64, UNKNOWNS>;
type Equations = SMatrix<f64, UNKNOWNS, 3>;

/// Why there is no T.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LinearError {
    /// The set determines none.
    #[error(transparent)]
    Pairs(#[from] PairsError),
    /// The equations depend on each other.
    #[error("the equations have rank {rank} instead of 11: the points determine no T")]
    Rank {
        /// Their rank.
        rank: usize,
    },
    /// Pixels and positions have nothing to do with each other.
    #[error(
        "no T fits: for point {point}, numbered from 0, the horizon of the laser's plane lies between it and the other points"
    )]
    Contradictory {
        /// The point, from zero.
        point: usize,
    },
}

/// A T, and how well it is known.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearCalibration {
    /// T, pixel (u, v, 1) to s (x, y, z, 1) in millimetres; s is one at the middle of the pixels, positive for all of them.
    pub t: Matrix4x3<f64>,
    /// Rank and condition of the scaled equations.
    pub conditioning: Conditioning,
    /// Condition of equation 14 as printed, in pixels and millimetres.
    pub condition_unscaled: f64,
    /// Each point's miss, estimated less actual position, in millimetres.
    pub residuals_mm: Vec<Vector3<f64>>,
    /// Each point's miss by the T of all other points; `None` where these determine none, as of four points.
    pub left_out_mm: Vec<Option<Vector3<f64>>>,
}

/// Equation 1: the position that `t` gives a pixel; `None` on the horizon, where s is zero.
///
/// Whatever the sign of s: T is determined up to a factor.
pub fn position_mm(t: &Matrix4x3<f64>, pixel_px: [f64; 2]) -> Option<Point3<f64>> {
    let h = t * Vector3::new(pixel_px[0], pixel_px[1], 1.0);
    let point = Point3::new(h.x / h.w, h.y / h.w, h.z / h.w);
    point.iter().all(|x| x.is_finite()).then_some(point)
}

/// Table 1's form: t43 = 1. `None` where s is zero at pixel (0, 0), to rounding.
pub fn with_last_one(t: &Matrix4x3<f64>) -> Option<Matrix4x3<f64>> {
    let last = t[(3, 2)];
    let largest = t.row(3).iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    (last.abs() > 1e-12 * largest && last.is_finite()).then(|| t / last)
}

/// Root of the mean square length of misses: "3D RMS". `None` of none.
pub fn rms_mm<'a>(misses: impl IntoIterator<Item = &'a Vector3<f64>>) -> Option<f64> {
    let (sum, count) = misses.into_iter().fold((0.0, 0_usize), |(sum, count), miss| (sum + miss.norm_squared(), count + 1));
    (count > 0).then(|| (sum / count as f64).sqrt())
}

impl LinearCalibration {
    /// Solves equation 14 for the pairs of one laser.
    ///
    /// # Errors
    /// A set that determines no T, and one that no T fits.
    pub fn of(pairs: &[Pair]) -> Result<Self, LinearError> {
        pairs::check(pairs)?;
        let solution = Solution::of(pairs)?;
        let t = solution.t();
        let in_front = |pair: &Pair| t[(3, 0)] * pair.pixel_px[0] + t[(3, 1)] * pair.pixel_px[1] + t[(3, 2)] > 1e-9;
        // The scale is one at the middle; whoever lies on the other side of the horizon is not in front of the camera with it.
        if let Some(point) = pairs.iter().position(|pair| !in_front(pair)) {
            return Err(LinearError::Contradictory { point });
        }
        Ok(Self {
            residuals_mm: pairs.iter().filter_map(|pair| miss(&t, pair)).collect(),
            left_out_mm: if pairs.len() <= SOLVED_ANEW { left_out(pairs) } else { solution.left_out(pairs) },
            condition_unscaled: singular::conditioning(as_printed(pairs).r).condition,
            conditioning: singular::conditioning(solution.triangle.r),
            t,
        })
    }

    /// 3D RMS over its own points, in millimetres.
    pub fn rms_mm(&self) -> f64 {
        rms_mm(&self.residuals_mm).unwrap_or(0.0)
    }

    /// 3D RMS over points left out one at a time; `None` where one of them cannot be spared.
    pub fn leave_one_out_rms_mm(&self) -> Option<f64> {
        let misses: Option<Vec<_>> = self.left_out_mm.iter().copied().collect();
        rms_mm(&misses?)
    }
}

/// Equation 14 in pixels and millimetres.
fn as_printed(pairs: &[Pair]) -> Triangle<UNKNOWNS> {
    triangle(pairs.iter().map(|pair| (pair.pixel_px, pair.position_mm)))
}

fn triangle(points: impl Iterator<Item = ([f64; 2], [f64; 3])>) -> Triangle<UNKNOWNS> {
    let mut triangle = Triangle::default();
    for (pixel, position) in points {
        let rows = equations(pixel, position);
        for (axis, value) in position.iter().enumerate() {
            triangle.add(rows.column(axis).into_owned(), *value);
        }
    }
    triangle
}

/// A point's three rows of equation 14, as columns.
fn equations([u, v]: [f64; 2], position: [f64; 3]) -> Equations {
    let mut rows = Equations::zeros();
    for (axis, value) in position.iter().enumerate() {
        for (column, entry) in [u, v, 1.0].into_iter().enumerate() {
            rows[(3 * axis + column, axis)] = entry;
        }
        rows[(9, axis)] = -u * value;
        rows[(10, axis)] = -v * value;
    }
    rows
}

fn matrix(unknowns: &Unknowns) -> Matrix4x3<f64> {
    Matrix4x3::from_fn(|row, column| if (row, column) == (3, 2) { 1.0 } else { unknowns[3 * row + column] })
}

/// Estimated less actual position; `None` on the horizon.
fn miss(t: &Matrix4x3<f64>, pair: &Pair) -> Option<Vector3<f64>> {
    position_mm(t, pair.pixel_px).map(|at| at - Point3::from(pair.position_mm))
}

/// Each point's miss by the solution of all others, solved anew.
fn left_out(pairs: &[Pair]) -> Vec<Option<Vector3<f64>>> {
    let mut others = Vec::with_capacity(pairs.len());
    let without = |index: usize| {
        others.clear();
        others.extend_from_slice(&pairs[..index]);
        others.extend_from_slice(&pairs[index + 1..]);
        pairs::check(&others).ok()?;
        miss(&Solution::of(&others).ok()?.t(), &pairs[index])
    };
    (0..pairs.len()).map(without).collect()
}

/// Equation 14, solved.
struct Solution {
    scales: Scales,
    triangle: Triangle<UNKNOWNS>,
    unknowns: Unknowns,
}

impl Solution {
    fn of(pairs: &[Pair]) -> Result<Self, LinearError> {
        let scales = Scales::of(pairs);
        let triangle = triangle(pairs.iter().map(|pair| scaled(&scales, pair)));
        let rank = singular::conditioning(triangle.r).rank;
        match triangle.solve().filter(|_| rank == UNKNOWNS) {
            Some(unknowns) => Ok(Self { scales, triangle, unknowns }),
            None => Err(LinearError::Rank { rank }),
        }
    }

    fn t(&self) -> Matrix4x3<f64> {
        self.scales.unscaled(&matrix(&self.unknowns))
    }

    /// Each point's miss by the solution of all others in this one's scales, which those of the others then hardly differ from.
    fn left_out(&self, pairs: &[Pair]) -> Vec<Option<Vector3<f64>>> {
        let without = |pair: &Pair| {
            let (pixel, position) = scaled(&self.scales, pair);
            let unknowns = self.without(&equations(pixel, position), &Vector3::from(position))?;
            miss(&self.scales.unscaled(&matrix(&unknowns)), pair)
        };
        pairs.iter().map(without).collect()
    }

    /// The unknowns without one point, whose equations are taken back out: with W = R^-T A^T and the point's residual r,
    /// x - R^-1 W (1 - W^T W)^-1 r. `None` where the others determine none.
    fn without(&self, rows: &Equations, value: &Vector3<f64>) -> Option<Unknowns> {
        let (triangle, x) = (&self.triangle, &self.unknowns);
        let mut w = Equations::zeros();
        for axis in 0..3 {
            w.set_column(axis, &triangle.forward(rows.column(axis).into_owned())?);
        }
        let rest = Matrix3::identity() - w.transpose() * w;
        // Its eigenvalues are shares, from 0 (this point alone says something) to 1.
        if rest.symmetric_eigenvalues().min() < 1e-9 {
            return None;
        }
        let residual = value - rows.transpose() * x;
        Some(x - triangle.back(w * rest.try_inverse()? * residual)?)
    }
}

fn scaled(scales: &Scales, pair: &Pair) -> ([f64; 2], [f64; 3]) {
    (scales.pixel.scaled(pair.pixel_px).into(), scales.position.scaled(pair.position_mm).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A T like table 1's, and a grid of pixels with a scatter that is no number's friend.
    fn scattered(columns: usize, rows: usize) -> Vec<Pair> {
        let t = Matrix4x3::new(-0.41, -0.003, 118.0, 0.51, -0.86, 248.0, -0.03, -0.05, 480.0, 0.0043, -0.0017, 1.0);
        let at = |index: usize| {
            let pixel = [37.0 * (index % columns) as f64, 41.0 * (index / columns) as f64];
            let there = position_mm(&t, pixel).expect("in front");
            let away = |factor: f64| libm::sin(index as f64 * factor) * 0.8;
            Pair { pixel_px: pixel, position_mm: [there.x + away(1.7), there.y + away(2.9), there.z + away(4.3)] }
        };
        (0..columns * rows).map(at).collect()
    }

    /// Both ways of leaving out agree where there are many points: what differs is the scales that T is solved in.
    #[test]
    fn taking_a_point_out_is_solving_without_it() {
        let pairs = scattered(14, 11);
        let anew = left_out(&pairs);
        let taken_out = Solution::of(&pairs).expect("solved").left_out(&pairs);
        let rms = rms_mm(anew.iter().flatten()).expect("points");
        for (a, b) in anew.iter().zip(&taken_out) {
            let apart = (a.expect("enough others") - b.expect("enough others")).norm();
            // A point of 154 moves the middle by a hundredth of the spread at most.
            assert!(apart < 0.02 * rms, "{a:?} {b:?}");
        }
    }

    #[test]
    fn of_four_points_none_can_be_spared() {
        let pairs: Vec<_> = scattered(14, 11).into_iter().step_by(37).take(4).collect();
        let solved = LinearCalibration::of(&pairs).expect("four points in general position");
        assert_eq!((solved.left_out_mm.as_slice(), solved.leave_one_out_rms_mm()), ([None; 4].as_slice(), None));
        assert_eq!(Solution::of(&pairs).expect("solved").left_out(&pairs), [None; 4]);
    }

    /// Pixels on both sides of the plane's horizon, with positions that T truly gives them: those beyond lie behind the camera.
    #[test]
    fn points_on_both_sides_of_the_horizon_are_told() {
        let t = Matrix4x3::new(-0.41, -0.003, 118.0, 0.51, -0.86, 248.0, -0.03, -0.05, 480.0, 0.0, -0.01, 1.0);
        let at = |index: usize| {
            let pixel_px = [50.0 * (index % 4) as f64, 70.0 * (index / 4) as f64];
            let there = position_mm(&t, pixel_px).expect("not on it");
            Pair { pixel_px, position_mm: there.coords.into() }
        };
        let pairs: Vec<_> = (0..12).map(at).collect();
        let refused = LinearCalibration::of(&pairs).expect_err("refused");
        // The middle is at v = 70, before the horizon at 100; the last row, v = 140, is beyond.
        assert_eq!(refused, LinearError::Contradictory { point: 8 });
    }
}
