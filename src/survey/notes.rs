//! What a run notes for its survey.

use ductloop_nav::ahead::DuctPlace;
use ductloop_nav::course::DuctRecord;
use ductloop_nav::mapping::{Ceilings, Closure, Ends, Floors, Sureness, closure};
use ductloop_nav::navigator::Report;
use ductloop_nav::planar::{compose, inverse};

use super::cloud::{Cloud, Standing};

/// The log of ducts as the navigator had it at the last frame, what was seen of their ceilings and floors, and the cloud of lit points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Notes {
    /// The ducts that the robot was in, the present one last; empty for a navigator that keeps no log.
    pub ducts: Vec<DuctRecord>,
    /// How far along the present one the robot was, in metres.
    pub along_m: f64,
    /// What was seen of the ducts' ceilings.
    pub ceilings: Ceilings,
    /// What was seen of their floors.
    pub floors: Floors,
    /// What was seen of where they end.
    pub ends: Ends,
    /// The lit points; `None` where none are kept.
    pub cloud: Option<Cloud>,
}

impl Notes {
    /// Notes that keep a cloud, in a run that begins here.
    pub fn with_cloud(cloud: Cloud) -> Self {
        Self { cloud: Some(cloud), ..Self::default() }
    }

    /// Where the ducts are with all loops closed, and the loops.
    pub fn closure(&self) -> Closure {
        closure::close(&self.ducts, self.along_m)
    }

    /// A pose in the frame of the first duct, believed while the robot was in the duct with this number, as the closed loops move it.
    pub(super) fn moved(&self, closure: &Closure, duct: usize, pose: [f64; 3]) -> [f64; 3] {
        match (self.ducts.get(duct), closure.first_from_duct.get(duct)) {
            (Some(open), Some(closed)) => compose(*closed, compose(inverse(open.first_from_duct), pose)),
            _ => pose,
        }
    }

    /// Takes in what the navigator says of a frame.
    pub fn take(&mut self, report: &Report<'_>) {
        // A frame that did not arrive has nothing to say.
        let (Some(duct), Some(last)) = (report.ducts.len().checked_sub(1), report.ducts.last()) else { return };
        report.ducts.clone_into(&mut self.ducts);
        let Some(pose) = report.pose else { return };
        let [along_m, lateral_m, heading_rad] = compose(inverse(last.first_from_duct), pose);
        self.along_m = along_m;
        if let Some(estimate) = report.estimate {
            let place = DuctPlace { along_m, lateral_m, heading_rad, width_m: estimate.width_m };
            self.ceilings.take(duct, &place, report.stages.ranges);
            self.floors.take(duct, &place, report.stages.ranges);
            // States 1 and 4 of the filter are the heading and x_ICR.
            let sureness = Sureness { heading_rad: estimate.deviation(1), icr_m: estimate.deviation(4) };
            self.ends.take(report.ducts, &place, &sureness, report.stages.ranges);
        }
        if let Some(cloud) = &mut self.cloud {
            cloud.add(&Standing::of(report, pose), report.stages.ranges);
        }
    }
}
