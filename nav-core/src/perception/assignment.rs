//! Which line is which laser's stripe on which wall.
//!
//! A line in the image fixes a wall's plane up to one number: with the line's coefficients l (l . r = 0) and the laser's plane
//! n . p = o, every m = n / o - lambda l is a plane through the stripe (see [`super::wall_plane`]). A side wall stands upright on
//! the floor that the robot stands on; that fixes lambda. So each line, taken for each laser in turn, proposes one wall, and
//! most of these propose none that a duct could have: behind the camera, across the duct, too far. Two lines that propose the
//! same wall from two lasers are that wall's two stripes.

use nalgebra::Vector3;

use super::line_fit::ScanLine;
use super::scan::Across;
use super::{Wall, WallMeasurement, duct_error};
use crate::angle::wrap;
use crate::perception::wall_plane::WallPlane;
use crate::rig::{Camera, Rig, Transform};

/// Limits of what a wall can be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallLimits {
    /// Largest heading of the robot relative to a wall, in radians.
    pub max_heading_rad: f64,
    /// Least and greatest distance of a wall from the base, in metres.
    pub distance_m: [f64; 2],
    /// How far two stripes' proposals may differ in heading, in radians.
    pub pair_heading_rad: f64,
    /// How far they may differ in distance, as a share of it.
    pub pair_distance_ratio: f64,
}

/// A line taken for a laser's stripe on a side wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proposal {
    /// Index of the line.
    pub line: usize,
    /// Index of the laser.
    pub laser: usize,
    /// Which wall.
    pub wall: Wall,
    /// Where that wall would be.
    pub measured: WallMeasurement,
    /// lambda of m = n / o - lambda l: how much m . r - n . r / o changes for a step of one across the image line.
    pub lambda: f64,
}

/// Coefficients l of the image line l . r = 0, for rays r = (x/z, y/z, 1).
pub fn image_line(line: &ScanLine, across: Across, camera: &Camera) -> Vector3<f64> {
    // In pixels: slope x - y + intercept = 0, with u = u0 + fx r.x and v = v0 + fy r.y.
    let (a, b, c) = match across {
        Across::V => (line.slope, -1.0, line.intercept_px),
        Across::U => (-1.0, line.slope, line.intercept_px),
    };
    let ([fx, fy], [u0, v0]) = (camera.focal_px, camera.centre_px);
    Vector3::new(a * fx, b * fy, a * u0 + b * v0 + c).normalize()
}

/// The wall that `line` shows if it is the stripe of `laser` on an upright wall; `None` if no duct has such a wall.
pub fn propose(
    line_index: usize,
    line: &ScanLine,
    laser_index: usize,
    rig: &Rig,
    across: Across,
    base_from_camera: &Transform,
    limits: &WallLimits,
) -> Option<Proposal> {
    let laser = &rig.lasers[laser_index];
    let l = image_line(line, across, &rig.camera);
    let inverse_plane = laser.normal_in_camera.into_inner() / laser.offset_m;
    let up_in_camera = base_from_camera.rotation.inverse() * Vector3::z();
    let along_up = l.dot(&up_in_camera);
    if along_up.abs() < 1e-3 {
        return None;
    }
    let lambda = inverse_plane.dot(&up_in_camera) / along_up;
    let m = inverse_plane - l * lambda;
    // Both ends of the stripe must be lit in front of the camera.
    let lit = line.extent_px.iter().all(|x| {
        let [u, v] = across.pixel(*x, line.at(*x));
        let ray = super::triangulation::ray_from_pixel(&rig.camera) * Vector3::new(u, v, 1.0);
        m.dot(&ray) > 0.0
    });
    if !lit {
        return None;
    }
    let plane = WallPlane::from_inverse(&m)?;
    let (wall, measured) = duct_error::measure(&plane, base_from_camera, line.points, limits.max_heading_rad)?;
    let [nearest, farthest] = limits.distance_m;
    (nearest..=farthest).contains(&measured.distance_m).then_some(Proposal {
        line: line_index,
        laser: laser_index,
        wall,
        measured,
        lambda,
    })
}

/// The pair of proposals for `wall`, from two lasers, that agree and rest on most points.
pub fn best_pair(proposals: &[Proposal], wall: Wall, limits: &WallLimits) -> Option<(Proposal, Proposal)> {
    let mut best: Option<(usize, Proposal, Proposal)> = None;
    for (i, a) in proposals.iter().enumerate() {
        for b in &proposals[i + 1..] {
            let pairable = a.wall == wall && b.wall == wall && a.laser != b.laser && a.line != b.line;
            let agree = || {
                let heading = wrap(a.measured.heading_rad - b.measured.heading_rad).abs();
                let distance = (a.measured.distance_m - b.measured.distance_m).abs();
                heading <= limits.pair_heading_rad && distance <= limits.pair_distance_ratio * a.measured.distance_m
            };
            // A pair is as good as the weaker of its lines.
            let support = a.measured.points.min(b.measured.points);
            if pairable && agree() && best.is_none_or(|(most, ..)| support > most) {
                best = Some((support, *a, *b));
            }
        }
    }
    best.map(|(_, a, b)| (a, b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn proposal(line: usize, laser: usize, distance_m: f64, points: usize) -> Proposal {
        let measured = WallMeasurement { distance_m, heading_rad: 0.01, points, deviation: None };
        Proposal { line, laser, wall: Wall::Left, measured, lambda: 1.0 }
    }

    const LIMITS: WallLimits =
        WallLimits { max_heading_rad: 0.6, distance_m: [0.03, 3.0], pair_heading_rad: 0.1, pair_distance_ratio: 0.1 };

    #[test]
    fn the_pair_whose_weaker_line_has_most_points_is_the_wall() {
        let proposals = [
            proposal(0, 0, 0.25, 200),
            // Agrees, but rests on few points.
            proposal(1, 1, 0.25, 40),
            proposal(2, 1, 0.252, 150),
            // Many points, another wall.
            proposal(3, 1, 0.4, 500),
        ];
        let (a, b) = best_pair(&proposals, Wall::Left, &LIMITS).expect("a pair");
        assert_eq!((a.line, b.line), (0, 2));
        assert_eq!(best_pair(&proposals, Wall::Right, &LIMITS), None);
    }

    #[test]
    fn a_line_or_a_laser_does_not_pair_with_itself() {
        let one_line_for_both_lasers = [proposal(0, 0, 0.25, 200), proposal(0, 1, 0.25, 200)];
        assert_eq!(best_pair(&one_line_for_both_lasers, Wall::Left, &LIMITS), None);
        let two_lines_for_one_laser = [proposal(0, 0, 0.25, 200), proposal(1, 0, 0.25, 200)];
        assert_eq!(best_pair(&two_lines_for_one_laser, Wall::Left, &LIMITS), None);
    }
}
