//! What lies ahead in the duct: read off the ranges of many frames, as the robot goes along.
//!
//! In data-flow order:
//!
//! - `strip`: rays counted in bins along the way: walls closed or open, the inside free or not;
//! - `change`: side walls that leave their lines without ending;
//! - `features`: openings in the walls, and what stands across;
//! - `flanks`: the side walls up to where they end;
//! - [`outlook`]: which fitting that is, and how sure;
//! - `outer_wall`, `outer_arc`: the wall that a bend turns along: its direction and place.

mod change;
mod features;
mod flanks;
mod outer_arc;
mod outer_wall;
pub mod outlook;
mod strip;

use std::collections::VecDeque;

pub use change::WallChange;
pub use features::{Features, Opening};
pub use flanks::Stretch;
pub use outer_arc::OuterArc;
pub use outer_wall::OuterWall;
pub use outlook::{Fitting, Outlook, Side};
pub use strip::DuctPlace;
use strip::{Ray, RayEnd, Strip};

use crate::perception::side_walls::SideWalls;
use crate::perception::{RangePoint, Upon};

/// Frames whose points are kept for fitting walls.
const FRAMES: usize = 12;
/// Points of a frame, about: two lasers in 160 blocks.
const MOST_POINTS: usize = 384;
/// Ranges beyond this are not trusted, in metres: a pixel's error is a decimetre there.
const FARTHEST_M: f64 = 2.3;

/// The side walls of the duct in which the robot is about at `place`, where they are straight, as one frame's ranges show them.
pub fn side_walls(ranges: &[RangePoint], place: &DuctPlace, stretch: &Stretch) -> Option<SideWalls> {
    let points =
        ranges.iter().filter(|range| range.upon == Upon::Upright).map(|range| [range.point_in_base.x, range.point_in_base.y]);
    flanks::find(points, place, stretch)
}

/// An inner wall that bends away is seen to end this far behind where it begins to bend, in metres, at most.
const INNER_LATE_M: f64 = 0.3;
/// An arc must explain this share of the points ...
const LEAST_SHARE: f64 = 0.6;
/// ... a straight wall this, ...
const LEAST_WALL_SHARE: f64 = 0.4;
/// ... and an arc this much more of them than a straight wall.
const ARC_BY: f64 = 0.1;

/// What a bend turns along.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outer {
    /// A straight wall: of a mitred elbow, of a branch.
    Wall(OuterWall),
    /// An arc: of a radius elbow.
    Arc(OuterArc),
}

/// The duct ahead, as it is known by now.
#[derive(Clone, Debug)]
pub struct Ahead {
    strip: Strip,
    /// Points of the last frames, in the duct: along and to the left.
    points: VecDeque<Vec<[f64; 2]>>,
    spare: Vec<Vec<[f64; 2]>>,
    watch: outlook::Watch,
    run: Vec<(i64, f64)>,
    outlook: Outlook,
    /// Where the camera is in the base frame, in metres.
    camera_m: [f64; 2],
}

impl Ahead {
    /// Nothing seen yet, by a camera at this place of the base frame.
    pub fn new(camera_m: [f64; 2]) -> Self {
        Self {
            strip: Strip::default(),
            points: VecDeque::with_capacity(FRAMES),
            spare: (0..FRAMES).map(|_| Vec::with_capacity(MOST_POINTS)).collect(),
            watch: outlook::Watch::default(),
            run: Vec::with_capacity(256),
            outlook: Outlook::default(),
            camera_m,
        }
    }

    /// Forgets all: the robot is in another duct.
    pub fn enter(&mut self) {
        self.strip.clear();
        self.spare.extend(self.points.drain(..));
        self.watch = outlook::Watch::default();
        self.outlook = Outlook::default();
    }

    /// Takes in the ranges of a frame that was exposed at `place`.
    pub fn look(&mut self, place: &DuctPlace, ranges: &[RangePoint]) -> &Outlook {
        self.strip.follow(place.along_m);
        let from = place.duct_from_base(self.camera_m[0], self.camera_m[1]);
        let mut kept = if self.points.len() == FRAMES { self.points.pop_front() } else { self.spare.pop() }.unwrap_or_default();
        kept.clear();
        let rays = ranges.iter().map(|range| {
            let point = range.point_in_base;
            let to = place.duct_from_base(point.x, point.y);
            let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
            let range_m = (dx * dx + dy * dy).sqrt();
            if range.upon == Upon::Nothing {
                return Ray { from, to, end: RayEnd::NoFloor };
            }
            if range.upon == Upon::Air {
                return Ray { from, to, end: RayEnd::Beyond };
            }
            if range_m > FARTHEST_M {
                let share = FARTHEST_M / range_m;
                return Ray { from, to: [from[0] + share * dx, from[1] + share * dy], end: RayEnd::Beyond };
            }
            let end = if range.upon == Upon::Floor { RayEnd::Floor } else { RayEnd::Surface };
            if end == RayEnd::Surface {
                kept.push(to);
            }
            Ray { from, to, end }
        });
        self.strip.take(place, rays);
        self.points.push_back(kept);
        self.outlook = self.watch.look(self.strip.features(place.along_m, place.width_m / 2.0, &mut self.run), place);
        &self.outlook
    }

    /// What it is taken for.
    pub fn outlook(&self) -> &Outlook {
        &self.outlook
    }

    /// The arc that a bend to this side turns along, whose inner wall ends at `ends_m`, as it is known by now.
    pub fn arc(&self, place: &DuctPlace, side: Side, ends_m: f64) -> Option<OuterArc> {
        let opening = Opening { from_m: ends_m, to_m: None, open_to_m: ends_m };
        let points = outer_wall::off_the_walls(self.points.iter().flatten().copied(), place, side, &opening);
        outer_arc::find(&points, place, side, ends_m).filter(|arc| arc.share >= LEAST_SHARE)
    }

    /// The wall that a bend to this side turns along, from the last frames' points: straight or an arc, whichever explains more of them.
    /// Only an elbow has an arc.
    pub fn outer(&self, place: &DuctPlace, fitting: Fitting, side: Side, opening: &Opening) -> Option<Outer> {
        let points = outer_wall::off_the_walls(self.points.iter().flatten().copied(), place, side, opening);
        let wall = outer_wall::find(&points, place, side, opening);
        let arc = outer_arc::find(&points, place, side, opening.from_m).filter(|arc| {
            fitting == Fitting::Elbow(side) && arc.share >= LEAST_SHARE && arc.start_m > opening.from_m - INNER_LATE_M
        });
        match (wall, arc) {
            (Some(wall), Some(arc)) if arc.share > wall.share + ARC_BY => Some(Outer::Arc(arc)),
            (Some(wall), _) if wall.share >= LEAST_WALL_SHARE => Some(Outer::Wall(wall)),
            (Some(_), None) => None,
            (_, arc) => arc.map(Outer::Arc),
        }
    }
}
