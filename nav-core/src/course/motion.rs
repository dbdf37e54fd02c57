//! The motion: the path where the robot is, how fast it may be driven there, and what is no path: turning round, standing.

use std::f64::consts::PI;

use super::bend::OnPath;
use super::passage::Passage;
use super::route::Turn;
use super::{Course, CourseParams, Phase, detour};
use crate::control::Twist;

/// Slowest speed towards where it is to stand, in m/s.
const CREEP_M_S: f64 = 0.03;
/// How hard it brakes towards the end of turning round, in rad/s2.
const ROUND_BRAKING_RAD_S2: f64 = 0.5;
/// Slowest yaw rate meanwhile, in rad/s.
const LEAST_TURN_RAD_S: f64 = 0.1;
/// It is as slow as a bend asks for from this before it on, in metres.
const SLOW_BEFORE_M: f64 = 0.05;

/// The path at a place, as control laws take it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathHere {
    /// Against the path.
    pub on_path: OnPath,
    /// Way along the whole path since the start, in metres.
    pub travelled_m: f64,
    /// By which share to be slower than usual.
    pub slowing: f64,
    /// Whether it is to be driven backwards.
    pub is_backwards: bool,
}

impl Course {
    /// The path where the robot will be: `along_m` farther along its duct than now.
    pub fn path(&self, along_m: f64, lateral_m: f64, heading_rad: f64) -> PathHere {
        let pose = [self.along_m + along_m, lateral_m, heading_rad];
        let (on_path, origin_m) = match self.phase {
            Phase::Along | Phase::TurningRound | Phase::AtTheEnd(_) => {
                (OnPath { way_m: pose[0], lateral_m, heading_rad, curvature_1_m: 0.0 }, 0.0)
            }
            Phase::Entering(bend) => (bend.project(pose), bend.start_m()),
            Phase::Leaving(bend) => (bend.project(bend.entry_from_exit(pose)), -bend.length_m()),
            Phase::Passing(detour) => (detour.project(pose), 0.0),
            Phase::BackingOut | Phase::BackingInto(_) => self.path_back(pose),
        };
        let travelled_m = self.before_m + origin_m + on_path.way_m;
        PathHere { on_path, travelled_m, slowing: self.slowing(), is_backwards: self.is_backwards() }
    }

    /// The motion that turns the robot round on the spot, or holds it where its route ends; `None` where it is to follow its path.
    pub fn manoeuvre(&self, heading_rad: f64) -> Option<Twist> {
        match self.phase {
            // Anticlockwise, and more slowly toward the end.
            Phase::TurningRound => {
                let left_rad = (PI - heading_rad.abs()).max(0.0);
                let yaw_rate_rad_s =
                    self.params.turn_rate_rad_s.min((2.0 * ROUND_BRAKING_RAD_S2 * left_rad).sqrt().max(LEAST_TURN_RAD_S));
                Some(Twist { speed_m_s: 0.0, yaw_rate_rad_s })
            }
            Phase::AtTheEnd(_) => Some(Twist::default()),
            _ => None,
        }
    }

    /// Room to leave between the robot's origin and what it cannot pass, in metres.
    pub(super) fn room_m(&self) -> f64 {
        match self.turn(self.ahead.outlook().fitting) {
            Some(Turn::TurnBack) => self.params.turn_back_m,
            _ => self.params.stand_off_m,
        }
    }

    /// By which share to be slower than usual: as bends and ends ask for.
    fn slowing(&self) -> f64 {
        let CourseParams { speed_m_s, turn_rate_rad_s, braking_m_s2, stand_off_m, .. } = self.params;
        let in_bend = |bend: &Passage| (turn_rate_rad_s * bend.radius_m()).min(speed_m_s);
        // The speed from which it can brake to `then` over what is left.
        let before = |left_m: f64, then: f64| (then * then + 2.0 * braking_m_s2 * left_m.max(0.0)).sqrt();
        let mut most = speed_m_s;
        match (&self.phase, &self.planned) {
            (Phase::Entering(bend) | Phase::Leaving(bend), _) => most = most.min(in_bend(bend)),
            (Phase::Along, Some(bend)) => most = most.min(before(bend.start_m() - self.along_m - SLOW_BEFORE_M, in_bend(bend))),
            (Phase::TurningRound | Phase::AtTheEnd(_), _) => most = 0.0,
            (Phase::Passing(detour), _) => {
                most *= detour::SPEED_SHARE;
                if let Some(at_m) = detour.next_m {
                    most = most.min(before(at_m - stand_off_m - self.along_m, CREEP_M_S));
                }
            }
            (Phase::BackingOut | Phase::BackingInto(_), _) => {
                most = self.speed_back_m_s();
                if let Some((to_m, true)) = self.back_to_m() {
                    most = most.min(before(self.along_m - to_m, CREEP_M_S));
                }
            }
            (Phase::Along, None) => {
                if let Some(at_m) = self.stands_m() {
                    most = most.min(before(at_m - self.room_m() - self.along_m, CREEP_M_S));
                }
            }
        }
        (1.0 - most / speed_m_s).clamp(0.0, 1.0)
    }
}
