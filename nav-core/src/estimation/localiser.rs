//! What the navigator asks for: where the robot stands now, and where it will stand when a command takes effect.

use super::estimator::{Estimate, Estimator, Outcome};
use super::motion::{HEADING, LATERAL, PER_TRACK, Travel};
use crate::messages::Tick;
use crate::odometry::advance;
use crate::perception::Measurement;
use crate::perception::side_walls::SideWalls;

/// How the place is kept.
#[derive(Clone, Debug)]
pub enum Localiser {
    /// By the filter.
    Kalman(Box<Estimator>),
    /// By the last measurement, carried on by the wheels, as if it were exact: the paper's way.
    LastSeen {
        /// Offset of the base from the centreline, left positive, in metres.
        lateral_m: f64,
        /// Heading, anticlockwise positive, in radians.
        heading_rad: f64,
    },
}

/// The effective track that a robot is told is taken for right within this share of it.
const KNOWN_SHARE: f64 = 0.02;

/// What a frame was good for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sight {
    /// It said where the robot stood.
    Used,
    /// It said so, but not what could be believed.
    Refused,
    /// It said nothing.
    None,
}

impl Localiser {
    /// Without a filter, in the middle of the duct until a frame says otherwise.
    pub fn last_seen() -> Self {
        Self::LastSeen { lateral_m: 0.0, heading_rad: 0.0 }
    }

    /// Carries the place on by what the wheels turned; returns the way along the duct. `track_m` serves where no filter estimates one.
    pub fn advance(&mut self, travel: Travel, track_m: f64, tick: Tick) -> f64 {
        match self {
            Self::Kalman(filter) => filter.advance(travel, tick),
            Self::LastSeen { lateral_m, heading_rad } => {
                let along_m;
                (*lateral_m, *heading_rad, along_m) = on_an_arc(*lateral_m, *heading_rad, travel, track_m);
                along_m
            }
        }
    }

    /// Takes in what a frame exposed at `exposed` shows. Where a bend is near, the walls of which may well be taken for those of this duct, a
    /// filter is `steady`: only a long run of refusals makes it begin anew.
    pub fn look(&mut self, measurement: &Measurement, exposed: Tick, steady: bool) -> Sight {
        match self {
            Self::Kalman(filter) => {
                let walls = measurement.side_walls.or_else(|| unstated(measurement, filter));
                walls.map_or(Sight::None, |walls| self.look_at(&walls, exposed, steady))
            }
            Self::LastSeen { lateral_m, heading_rad } => match (measurement.lateral_m, measurement.heading_rad) {
                (Some(lateral), Some(heading)) => {
                    (*lateral_m, *heading_rad) = (lateral, heading);
                    Sight::Used
                }
                _ => Sight::None,
            },
        }
    }

    /// Takes in these walls, exposed at `exposed`; `steady` as for [`Self::look`].
    pub fn look_at(&mut self, walls: &SideWalls, exposed: Tick, steady: bool) -> Sight {
        match self {
            Self::Kalman(filter) => match filter.look(walls, exposed, steady) {
                Outcome::Taken { .. } | Outcome::Begun => Sight::Used,
                Outcome::Refused { .. } => Sight::Refused,
                Outcome::None | Outcome::Useless => Sight::None,
            },
            Self::LastSeen { lateral_m, heading_rad } => {
                *heading_rad = walls.heading_rad;
                if let (Some(left_m), Some(right_m)) = (walls.left_m, walls.right_m) {
                    *lateral_m = (right_m - left_m) / 2.0;
                }
                Sight::Used
            }
        }
    }

    /// It is in another duct from now on: see [`Estimator::enter`].
    pub fn enter(&mut self, lateral: [f64; 2], heading: [f64; 2], width: [f64; 2]) {
        match self {
            Self::Kalman(filter) => filter.enter(lateral, heading, width),
            Self::LastSeen { lateral_m, heading_rad } => (*lateral_m, *heading_rad) = (lateral[0], heading[0]),
        }
    }

    /// Lateral offset and heading as believed now.
    pub fn place(&self) -> (f64, f64) {
        match self {
            Self::Kalman(filter) => {
                let estimate = filter.estimate();
                (estimate.lateral_m, estimate.heading_rad)
            }
            Self::LastSeen { lateral_m, heading_rad } => (*lateral_m, *heading_rad),
        }
    }

    /// Lateral offset, heading and way along the duct after the wheels will have turned so far.
    pub fn foresee(&self, travel: Travel, track_m: f64) -> (f64, f64, f64) {
        match self {
            Self::Kalman(filter) => filter.foresee(travel),
            Self::LastSeen { lateral_m, heading_rad } => on_an_arc(*lateral_m, *heading_rad, travel, track_m),
        }
    }

    /// Effective track that the wheels are commanded by: the filter's, as far as it knows it. On straights it does not, and wanders.
    pub fn effective_track_m(&self, told_m: f64) -> f64 {
        match self {
            Self::Kalman(filter) => {
                let estimate = filter.estimate();
                let (known, sigma) = (KNOWN_SHARE * told_m, estimate.deviation(PER_TRACK));
                let trust = known * known / (known * known + sigma * sigma);
                told_m + trust * (estimate.effective_track_m.clamp(0.5 * told_m, 2.0 * told_m) - told_m)
            }
            Self::LastSeen { .. } => told_m,
        }
    }

    /// Whether the filter is less sure of its place than its parameters ask for.
    pub fn is_uncertain(&self) -> bool {
        match self {
            Self::Kalman(filter) => {
                let (estimate, params) = (filter.estimate(), filter.params());
                estimate.deviation(LATERAL) > params.uncertain_lateral_m
                    || estimate.deviation(HEADING) > params.uncertain_heading_rad
            }
            Self::LastSeen { .. } => false,
        }
    }

    /// What the filter believes, if there is one.
    pub fn estimate(&self) -> Option<Estimate> {
        match self {
            Self::Kalman(filter) => Some(filter.estimate()),
            Self::LastSeen { .. } => None,
        }
    }
}

fn on_an_arc(lateral_m: f64, heading_rad: f64, travel: Travel, track_m: f64) -> (f64, f64, f64) {
    let twist = crate::control::Twist {
        speed_m_s: (travel.left_m + travel.right_m) / 2.0,
        yaw_rate_rad_s: (travel.right_m - travel.left_m) / track_m,
    };
    advance(lateral_m, heading_rad, twist, 1.0)
}

/// The walls of a perception that states no deviations. One that tells the pose alone is taken to have seen both walls of a duct as wide
/// as it says, or as is told.
fn unstated(measurement: &Measurement, filter: &Estimator) -> Option<SideWalls> {
    let (lateral_m, heading_rad) = (measurement.lateral_m?, measurement.heading_rad?);
    let mut walls = [measurement.left, measurement.right].map(|wall| wall.map(|wall| wall.distance_m));
    if walls == [None, None] {
        let half = measurement.width_m.unwrap_or(filter.told_width_m()) / 2.0;
        walls = [Some(half - lateral_m), Some(half + lateral_m)];
    }
    let [left, right] = walls;
    let params = filter.params();
    Some(SideWalls::independent(heading_rad, left, right, params.unstated_heading_rad, params.unstated_distance_m))
}
