//! How high a duct is.
//!
//! A slit that rises lights the ceiling far ahead (2.6 m for the `wide` rig in a duct of 0.3 m), or, before that, what stands across: the
//! wall behind an elbow, a cap. In one frame the two look alike, a level line above the camera. The robot's way tells them apart: the place
//! that is lit on a ceiling goes along with the robot, the one on a wall stays where it is, so that the height at which the wall is lit
//! falls as the robot comes nearer. (Frames that took such walls for ceilings made heights of 0.17 to 0.29 m out of 0.3 m.) So a piece of
//! the way counts where the lit place kept its distance from the robot all along it.
//!
//! What it does not do: a ceiling that slopes against the floor; ducts too short for the light to be on their ceiling over a piece of way,
//! which have no height.

use super::{COMMON_1_M, median};
use crate::ahead::DuctPlace;
use crate::perception::{RangePoint, Upon};

/// Lowest ceiling, in metres.
const LOWEST_M: f64 = 0.15;
/// Points nearer to the walls' lines are the walls', in metres.
const BESIDE_WALL_M: f64 = 0.05;
/// Fewest points of a frame.
const FEWEST_POINTS: usize = 6;
/// A piece of the way, in metres, its frames, and the largest gap between two of them, in metres.
const PIECE_M: f64 = 0.3;
const FEWEST_FRAMES: usize = 8;
const GAP_M: f64 = 0.1;
/// Pieces that must agree: where the floor's grade changes one may do so by chance.
const FEWEST_PIECES: usize = 2;
/// By which share of the way the lit place may come nearer or move off: 0 on a ceiling, 1 on a wall.
const COMES_NEARER: f64 = 0.1;
/// Standard deviation of its distance, in metres: more than that where the light goes from one thing to another.
const WANDERS_M: f64 = 0.02;
/// Headings beyond which the robot is turning, in radians.
const TURNING_RAD: f64 = 0.3;
/// Pieces whose heights differ by more are not of one duct's ceiling, or not of a ceiling, in metres.
const APART_M: f64 = 0.01;

/// A height with its standard deviation, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Height {
    /// Height of the duct.
    pub height_m: f64,
    /// Its standard deviation.
    pub sigma_m: f64,
}

/// What one frame shows above the camera: where the robot was along the duct, how far ahead of it the light was, how high.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sight {
    along_m: f64,
    ahead_m: f64,
    high_m: f64,
}

/// What the frames of each duct show above the camera.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ceilings {
    /// By the duct's number in the log.
    ducts: Vec<Vec<Sight>>,
}

impl Ceilings {
    /// Takes in a frame that was exposed at `place` of the duct with this number.
    pub fn take(&mut self, duct: usize, place: &DuctPlace, ranges: &[RangePoint]) {
        if place.heading_rad.abs() > TURNING_RAD {
            return;
        }
        let inside_m = place.width_m / 2.0 - BESIDE_WALL_M;
        let in_duct = |point: &RangePoint| place.duct_from_base(point.point_in_base.x, point.point_in_base.y);
        let is_above = |point: &&RangePoint| {
            point.upon == Upon::Upright && point.point_in_base.z > LOWEST_M && in_duct(point)[1].abs() < inside_m
        };
        let lasers = ranges.iter().map(|point| point.laser + 1).max().unwrap_or(0);
        for laser in 0..lasers {
            let above = || ranges.iter().filter(|point| point.laser == laser).filter(is_above);
            if above().count() < FEWEST_POINTS {
                continue;
            }
            let mut highs: Vec<f64> = above().map(|point| point.point_in_base.z).collect();
            let mut aheads: Vec<f64> = above().map(|point| in_duct(point)[0] - place.along_m).collect();
            if let (Some(high_m), Some(ahead_m)) = (median(&mut highs), median(&mut aheads)) {
                if self.ducts.len() <= duct {
                    self.ducts.resize(duct + 1, Vec::new());
                }
                self.ducts[duct].push(Sight { along_m: place.along_m, ahead_m, high_m });
            }
        }
    }

    /// The height of a duct; `None` where its ceiling was not seen.
    pub fn height(&self, duct: usize) -> Option<Height> {
        let sights = self.ducts.get(duct)?;
        let mut pieces: Vec<[f64; 2]> = Vec::new();
        let mut from = 0;
        while from < sights.len() {
            let piece = piece(&sights[from..]);
            pieces.extend(on_ceiling(piece));
            from += piece.len();
        }
        let mut heights: Vec<f64> = pieces.iter().map(|[high_m, _]| *high_m).collect();
        let height_m = median(&mut heights)?;
        let mut off: Vec<f64> = heights.iter().map(|high_m| (high_m - height_m).abs()).collect();
        let agree = off.iter().filter(|off_m| **off_m <= APART_M).count();
        if agree < FEWEST_PIECES || 2 * agree <= off.len() {
            return None;
        }
        let scatter_m = median(&mut off)? * 1.48;
        let ahead_m = pieces.iter().map(|[_, ahead_m]| *ahead_m).fold(0.0, f64::max);
        let common_m = COMMON_1_M * height_m * ahead_m;
        Some(Height { height_m, sigma_m: (common_m * common_m + scatter_m * scatter_m).sqrt() })
    }
}

/// The sights at the beginning of these that make one piece of the way.
fn piece(sights: &[Sight]) -> &[Sight] {
    let goes_on = |i: usize| {
        (sights[i].along_m - sights[i - 1].along_m).abs() < GAP_M && (sights[i - 1].along_m - sights[0].along_m).abs() < PIECE_M
    };
    let end = (1..sights.len()).find(|i| !goes_on(*i)).unwrap_or(sights.len());
    &sights[..end]
}

/// Height and distance ahead of the light in a piece of the way, if it is on a ceiling.
fn on_ceiling(piece: &[Sight]) -> Option<[f64; 2]> {
    let count = piece.len() as f64;
    let way_m = piece.last()?.along_m - piece.first()?.along_m;
    if piece.len() < FEWEST_FRAMES || way_m.abs() < 0.8 * PIECE_M {
        return None;
    }
    let mean = |of: fn(&Sight) -> f64| piece.iter().map(of).sum::<f64>() / count;
    let (along_m, ahead_m) = (mean(|sight| sight.along_m), mean(|sight| sight.ahead_m));
    let (mut squares, mut products, mut scatter) = (0.0, 0.0, 0.0);
    for sight in piece {
        scatter += (sight.ahead_m - ahead_m) * (sight.ahead_m - ahead_m);
        squares += (sight.along_m - along_m) * (sight.along_m - along_m);
        products += (sight.along_m - along_m) * (sight.ahead_m - ahead_m);
    }
    let is_kept = squares > 0.0 && (products / squares).abs() < COMES_NEARER && scatter < count * WANDERS_M * WANDERS_M;
    let mut highs: Vec<f64> = piece.iter().map(|sight| sight.high_m).collect();
    Some([median(&mut highs)?, ahead_m]).filter(|_| is_kept)
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;

    /// Drives 2 m towards a wall in a duct of 0.3 m, with a slit that rises from 0.04 m by 0.1.
    fn driven(wall_m: f64) -> Ceilings {
        let mut ceilings = Ceilings::default();
        for frame in 0..250 {
            let place = DuctPlace { along_m: 0.008 * f64::from(frame), lateral_m: 0.0, heading_rad: 0.0, width_m: 0.5 };
            let x = (wall_m - place.along_m).min(2.6);
            let point = |block: usize| RangePoint {
                point_in_base: Point3::new(x, 0.03 * block as f64 - 0.15, 0.04 + 0.1 * x),
                laser: 0,
                block,
                upon: Upon::Upright,
            };
            ceilings.take(0, &place, &(0..11).map(point).collect::<Vec<_>>());
        }
        ceilings
    }

    #[test]
    fn a_ceiling_goes_along_and_a_wall_stays() {
        let height = driven(10.0).height(0).expect("a height");
        assert!((height.height_m - 0.3).abs() < 1e-9 && (0.001..0.003).contains(&height.sigma_m), "{height:?}");
        assert_eq!(driven(2.4).height(0), None);
        // First on the ceiling for 1.4 m, then on the wall.
        assert!(driven(4.0).height(0).is_some_and(|height| (height.height_m - 0.3).abs() < 1e-9), "{:?}", driven(4.0).height(0));
    }

    #[test]
    fn without_a_piece_of_way_there_is_no_height() {
        assert_eq!(driven(2.9).height(0), None);
        assert_eq!(Ceilings::default().height(0), None);
    }
}
