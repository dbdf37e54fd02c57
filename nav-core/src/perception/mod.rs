//! From one camera frame to where the robot stands between the walls.
//!
//! The paper's chain (section 4), in data-flow order, each stage a function that can be called alone:
//!
//! 1. [`scan`]: the frame turned so that stripes run along its rows;
//! 2. [`threshold`]: grey values to a binary image;
//! 3. [`morphology`]: opening and closing of the binary image;
//! 4. [`thinning`]: runs across the stripe to one point each, guided by the thickness that the stripe must have;
//! 5. [`hough`]: points to lines (r, theta);
//! 6. [`line_fit`]: each line refitted to the sub-pixel centres of its points;
//! 7. [`triangulation`]: pixels to points in the camera frame (equation 1);
//! 8. [`assignment`]: which line is which laser on which wall;
//! 9. [`wall_plane`]: two 3D lines, or all their points, to a plane (equations 15 to 18);
//! 10. [`duct_error`]: the plane to lateral and heading error (equations 19, 20).
//!
//! [`paper`] runs them in order.

pub mod assignment;
pub mod bit_image;
pub mod duct_error;
pub mod hough;
pub mod line_fit;
pub mod morphology;
pub mod paper;
pub mod scan;
pub mod thinning;
pub mod threshold;
pub mod triangulation;
pub mod wall_plane;

use crate::messages::Frame;
use crate::rig::MountAngles;

/// A side wall of the duct.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Wall {
    /// The wall on the robot's left.
    Left,
    /// The wall on the robot's right.
    Right,
}

/// A side wall as the camera saw it, in the base frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallMeasurement {
    /// Distance of the wall's plane from the base's origin, in metres.
    pub distance_m: f64,
    /// Heading of the robot relative to this wall, anticlockwise positive, in radians.
    pub heading_rad: f64,
    /// Stripe points that the plane rests on.
    pub points: usize,
}

/// What one frame says about where the robot stood at its exposure. What was not seen is `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measurement {
    /// Offset of the base from the duct's centreline, left positive, in metres.
    pub lateral_m: Option<f64>,
    /// Heading relative to the duct, anticlockwise positive, in radians.
    pub heading_rad: Option<f64>,
    /// Width of the duct, where both walls were seen, in metres.
    pub width_m: Option<f64>,
    /// The left wall.
    pub left: Option<WallMeasurement>,
    /// The right wall.
    pub right: Option<WallMeasurement>,
}

/// A line found in the image, for those who want to look over the robot's shoulder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StripeLine {
    /// Ends (u, v) of the part that its points cover, in pixels.
    pub ends_px: [[f64; 2]; 2],
    /// Which laser and wall it was taken for; `None` for a line that was found and left.
    pub assigned: Option<(usize, Wall)>,
    /// How many points it rests on.
    pub points: usize,
    /// RMS distance of its points across the stripe, in pixels.
    pub residual_px: f64,
}

/// Reads frames. The paper's chain is one; a user's own may take its place.
pub trait Perception: Send {
    /// What this frame says. `mount` is where the mount pointed at the exposure.
    fn perceive(&mut self, frame: &Frame<'_>, mount: MountAngles) -> Measurement;

    /// The lines found in the last frame.
    fn lines(&self) -> &[StripeLine] {
        &[]
    }
}
