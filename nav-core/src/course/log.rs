//! What the robot has driven through, as it found it: the frame of each duct in the frame of the first, and the ducts in order.

use super::passage::Passage;
use crate::ahead::Fitting;
use crate::planar::compose;

/// Something that the robot came by, or up to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Met {
    /// A branch or cross that it went straight past; a dead end, a drop or an obstacle before which it turned back or stopped.
    pub fitting: Fitting,
    /// Where it begins, in metres along the duct.
    pub at_m: f64,
}

/// A duct that was driven through, from where it was entered to where it was left.
#[derive(Clone, Debug, PartialEq)]
pub struct DuctRecord {
    /// Pose of the duct's zero (along, left, heading) in the frame of the first duct, as dead reckoning and walls have it.
    pub first_from_duct: [f64; 3],
    /// Its width as it was measured last, in metres.
    pub width_m: f64,
    /// Standard deviation of that, in metres; `None` where nothing states one.
    pub width_deviation_m: Option<f64>,
    /// Where the duct itself begins and ends, in metres along it: where passages end and begin, or the wall of a dead end stands. The first
    /// one begins where the robot did. `None` where that has not been seen, as beyond an obstacle.
    pub begin_m: Option<f64>,
    /// See `begin_m`.
    pub end_m: Option<f64>,
    /// From where to where it was driven, in metres along it; `None` while it goes on.
    pub from_m: f64,
    /// See `from_m`.
    pub to_m: Option<f64>,
    /// How it was left: by which fitting.
    pub by: Option<Fitting>,
    /// By which turn, positive to the left, in radians.
    pub turn_rad: f64,
    /// Radius of that turn's arc, in metres; infinite where it was left through a transition.
    pub radius_m: f64,
    /// What was met in it, in the order of the way.
    pub met: Vec<Met>,
}

/// All of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    ducts: Vec<DuctRecord>,
}

impl Default for Log {
    fn default() -> Self {
        Self { ducts: vec![DuctRecord::entered([0.0; 3], Some(0.0), 0.0, 0.0)] }
    }
}

impl DuctRecord {
    fn entered(first_from_duct: [f64; 3], begin_m: Option<f64>, from_m: f64, width_m: f64) -> Self {
        Self {
            first_from_duct,
            width_m,
            width_deviation_m: None,
            begin_m,
            end_m: None,
            from_m,
            to_m: None,
            by: None,
            turn_rad: 0.0,
            radius_m: 0.0,
            met: Vec::new(),
        }
    }
}

impl Log {
    /// The ducts, the one that the robot is in last.
    pub fn ducts(&self) -> &[DuctRecord] {
        &self.ducts
    }

    /// A pose of the present duct (along, left, heading) in the frame of the first.
    pub fn first_from(&self, pose: [f64; 3]) -> [f64; 3] {
        self.ducts.last().map_or(pose, |duct| compose(duct.first_from_duct, pose))
    }

    /// The present duct is as wide as this, in metres, with this deviation.
    pub(super) fn measured(&mut self, width_m: f64, deviation_m: Option<f64>) {
        if let Some(duct) = self.ducts.last_mut() {
            (duct.width_m, duct.width_deviation_m) = (width_m, deviation_m);
        }
    }

    /// A branch or cross is gone past.
    pub(super) fn passed(&mut self, fitting: Fitting, at_m: f64) {
        if let Some(duct) = self.ducts.last_mut() {
            duct.met.push(Met { fitting, at_m });
        }
    }

    /// The robot turns back or stops before this, in the present duct.
    pub(super) fn blocked(&mut self, fitting: Fitting, at_m: f64) {
        if let Some(duct) = self.ducts.last_mut() {
            duct.met.push(Met { fitting, at_m });
            duct.end_m = (fitting == Fitting::DeadEnd).then_some(at_m);
        }
    }

    /// What the robot stands before in the present duct was not where it was thought to be. Says whether it stood before anything.
    pub(super) fn unblocked(&mut self) -> bool {
        let Some(duct) = self.ducts.last_mut() else { return false };
        duct.end_m = None;
        duct.met
            .pop_if(|met| matches!(met.fitting, Fitting::DeadEnd | Fitting::Drop | Fitting::Obstacle | Fitting::Unknown))
            .is_some()
    }

    /// The present duct was left through a passage.
    pub(super) fn left_by(&mut self, fitting: Fitting, passage: &Passage, along_m: f64) {
        let zero = self.first_from(passage.entry_from_exit([0.0; 3]));
        if let Some(duct) = self.ducts.last_mut() {
            (duct.to_m, duct.by, duct.end_m) = (Some(passage.start_m()), Some(fitting), Some(passage.start_m()));
            (duct.turn_rad, duct.radius_m) = (passage.turn_rad(), passage.radius_m());
        }
        self.ducts.push(DuctRecord::entered(zero, Some(0.0), along_m, passage.exit_width_m()));
    }

    /// The robot drove backwards out of the present duct, at this place of it, into the one before, which has this frame.
    pub(super) fn backed_into(&mut self, first_from_duct: [f64; 3], along_m: f64, from_m: f64, width_m: f64) {
        if let Some(duct) = self.ducts.last_mut() {
            duct.to_m = Some(along_m);
        }
        self.ducts.push(DuctRecord::entered(first_from_duct, None, from_m, width_m));
    }

    /// The robot turned round at this place of its duct.
    pub(super) fn turned_round(&mut self, along_m: f64, width_m: f64) {
        let zero = self.first_from([along_m, 0.0, std::f64::consts::PI]);
        let mut begin_m = None;
        if let Some(duct) = self.ducts.last_mut() {
            let before = duct.met.last().map_or(Fitting::DeadEnd, |met| met.fitting);
            (duct.to_m, duct.by, duct.turn_rad) = (Some(along_m), Some(before), std::f64::consts::PI);
            // What it turned back before is behind it now.
            begin_m = duct.end_m.map(|end_m| along_m - end_m);
        }
        self.ducts.push(DuctRecord::entered(zero, begin_m, 0.0, width_m));
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;
    use crate::course::bend::Bend;

    /// Through a square elbow to the left and back from its end: the same place, the other way round.
    #[test]
    fn frames_are_chained() {
        let bend = Bend { start_m: 2.0, radius_m: 0.25, turn_rad: FRAC_PI_2, exit_width_m: 0.5, outer_end_m: 2.5 };
        let bend = Passage::Bend(bend);
        let mut log = Log::default();
        log.left_by(Fitting::Elbow(crate::ahead::Side::Left), &bend, -0.2);
        let at = log.first_from([1.0, 0.1, 0.0]);
        assert!((at[0] - 2.15).abs() < 1e-12 && (at[1] - 1.25).abs() < 1e-12 && (at[2] - FRAC_PI_2).abs() < 1e-12, "{at:?}");
        log.blocked(Fitting::Drop, 0.9);
        assert!(log.unblocked() && !log.unblocked(), "it stood before one thing");
        log.blocked(Fitting::DeadEnd, 1.3);
        log.turned_round(1.0, 0.5);
        let back = log.first_from([0.0, -0.1, 0.0]);
        assert!(
            (back[0] - 2.15).abs() < 1e-12 && (back[1] - 1.25).abs() < 1e-12 && (back[2] + FRAC_PI_2).abs() < 1e-12,
            "{back:?}"
        );
        assert_eq!(log.ducts().len(), 3);
        assert_eq!((log.ducts()[0].to_m, log.ducts()[1].to_m), (Some(2.0), Some(1.0)));
        // The wall before which it turned is where the duct ends, and where it begins on the way back.
        assert_eq!((log.ducts()[1].end_m, log.ducts()[1].by), (Some(1.3), Some(Fitting::DeadEnd)));
        assert!(log.ducts()[2].begin_m.is_some_and(|begin_m| (begin_m + 0.3).abs() < 1e-12), "{:?}", log.ducts()[2]);
    }
}
