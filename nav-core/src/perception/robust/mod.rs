//! The robust pipeline.

use super::{Measurement, Perception, SeenPlane, Stages, StripeCentre, StripeLine};
use crate::messages::Frame;
use crate::rig::{MountAngles, Rig};

/// Parameters of the pipeline.
#[derive(Clone, Debug, PartialEq)]
pub struct RobustParams {
    /// Width of the duct, in metres: used where only one wall is seen.
    pub duct_width_m: f64,
}

impl Default for RobustParams {
    fn default() -> Self {
        Self { duct_width_m: 0.5 }
    }
}

/// The pipeline with its buffers: after the first frames it allocates nothing.
#[derive(Clone, Debug)]
pub struct RobustPerception {
    rig: Rig,
    params: RobustParams,
    centres: Vec<StripeCentre>,
    lines: Vec<StripeLine>,
    planes: Vec<SeenPlane>,
}

impl RobustPerception {
    /// A pipeline for the nominal rig.
    pub fn new(rig: Rig, params: RobustParams) -> Self {
        Self { rig, params, centres: Vec::new(), lines: Vec::new(), planes: Vec::new() }
    }
}

impl Perception for RobustPerception {
    fn perceive(&mut self, frame: &Frame<'_>, mount: MountAngles) -> Measurement {
        let _ = (frame, mount, &self.rig, &self.params);
        Measurement::default()
    }

    fn stages(&self) -> Stages<'_> {
        Stages { centres: &self.centres, lines: &self.lines, planes: &self.planes }
    }
}
