//! What a run notes for its survey.

use ductloop_nav::course::DuctRecord;
use ductloop_nav::navigator::Report;

use super::cloud::{Cloud, Standing};

/// The log of ducts as the navigator had it at the last frame, and the cloud of lit points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Notes {
    /// The ducts that the robot was in, the present one last; empty for a navigator that keeps no log.
    pub ducts: Vec<DuctRecord>,
    /// The lit points; `None` where none are kept.
    pub cloud: Option<Cloud>,
}

impl Notes {
    /// Notes that keep a cloud, in a run that begins here.
    pub fn with_cloud(cloud: Cloud) -> Self {
        Self { ducts: Vec::new(), cloud: Some(cloud) }
    }

    /// Takes in what the navigator says of a frame.
    pub fn take(&mut self, report: &Report<'_>) {
        // A frame that did not arrive has nothing to say.
        if report.ducts.is_empty() {
            return;
        }
        report.ducts.clone_into(&mut self.ducts);
        if let (Some(cloud), Some(pose)) = (&mut self.cloud, report.pose) {
            let standing = Standing::of(report, pose);
            cloud.add(&standing, report.stages.ranges);
        }
    }
}
