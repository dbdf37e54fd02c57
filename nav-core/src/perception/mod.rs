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
//! [`paper`] runs them in order. [`ridge`] finds stripe centres where nothing is known of a rig.

pub mod assignment;
pub mod bit_image;
pub mod duct_error;
pub mod hough;
pub mod lens;
pub mod line_fit;
pub mod morphology;
pub mod paper;
pub mod ridge;
pub mod robust;
pub mod scan;
pub mod side_walls;
pub mod thinning;
pub mod threshold;
pub mod triangulation;
pub mod wall_plane;

use nalgebra::{Matrix3, Point3};

use crate::messages::Frame;
use crate::rig::MountAngles;
use side_walls::SideWalls;
use wall_plane::WallPlane;

/// A face of the duct, as the robot meets it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Wall {
    /// The wall on the robot's left.
    Left,
    /// The wall on the robot's right.
    Right,
    /// The floor that the robot stands on.
    Floor,
    /// The ceiling.
    Ceiling,
    /// A wall across the duct, ahead.
    Ahead,
}

impl Wall {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Left, Self::Right, Self::Floor, Self::Ceiling, Self::Ahead];

    /// The word for it in files.
    pub fn word(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
            Self::Floor => "floor",
            Self::Ceiling => "ceiling",
            Self::Ahead => "ahead",
        }
    }
}

/// A wall as the camera saw it, in the base frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallMeasurement {
    /// Distance of the wall's plane from the base's origin, in metres.
    pub distance_m: f64,
    /// Heading of the robot relative to this wall, anticlockwise positive, in radians: zero where a side wall runs along the
    /// robot, and where it faces a wall ahead squarely. Floor and ceiling show no heading: zero.
    pub heading_rad: f64,
    /// Stripe points that the plane rests on.
    pub points: usize,
    /// Standard deviations of both; `None` from a perception that states none.
    pub deviation: Option<WallDeviation>,
}

/// Standard deviations of a wall's distance and heading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallDeviation {
    /// Of the distance, in metres.
    pub distance_m: f64,
    /// Of the heading, in radians.
    pub heading_rad: f64,
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
    /// Height of the duct, where the ceiling was seen, in metres.
    pub height_m: Option<f64>,
    /// Standard deviations of these four, where they were seen; `None` from a perception that states none.
    pub deviation: Deviation,
    /// The side walls with the covariance of all they say; `None` where no side wall was seen, and from a perception that states
    /// none.
    pub side_walls: Option<SideWalls>,
    /// The left wall.
    pub left: Option<WallMeasurement>,
    /// The right wall.
    pub right: Option<WallMeasurement>,
    /// The floor.
    pub floor: Option<WallMeasurement>,
    /// The ceiling.
    pub ceiling: Option<WallMeasurement>,
    /// A wall across the duct, ahead.
    pub ahead: Option<WallMeasurement>,
}

/// Standard deviations of a [`Measurement`], in its units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Of the lateral offset, in metres.
    pub lateral_m: Option<f64>,
    /// Of the heading, in radians.
    pub heading_rad: Option<f64>,
    /// Of the width, in metres.
    pub width_m: Option<f64>,
    /// Of the height, in metres.
    pub height_m: Option<f64>,
}

impl Measurement {
    /// What was measured of a wall.
    pub fn wall(&self, wall: Wall) -> Option<&WallMeasurement> {
        match wall {
            Wall::Left => self.left.as_ref(),
            Wall::Right => self.right.as_ref(),
            Wall::Floor => self.floor.as_ref(),
            Wall::Ceiling => self.ceiling.as_ref(),
            Wall::Ahead => self.ahead.as_ref(),
        }
    }
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

/// The middle of a stripe in one column of the image, or in one row where stripes run down the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StripeCentre {
    /// Column, in pixels, as the camera shows it: lens distortion is not taken out.
    pub u_px: f64,
    /// Row, in pixels.
    pub v_px: f64,
    /// Standard deviation across the column (or row), in pixels.
    pub sigma_px: f64,
    /// Which laser and wall it was taken for; `None` for one that was found and left.
    pub assigned: Option<(usize, Wall)>,
}

/// What a stripe is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Upon {
    /// The floor that the robot stands on.
    Floor,
    /// Whatever is not the floor: walls, mostly.
    Upright,
    /// A floor that falls away ahead: lower than the one that the robot stands on, by no more than floors slope.
    Below,
    /// Nothing up to here: another laser is seen on the floor in the same direction, and this one would be seen on anything nearer.
    Air,
    /// Nothing: here the floor should be lit, in sight of the camera, and is not.
    Nothing,
}

/// A point that a laser lights, whatever it is on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangePoint {
    /// Where it is, in the base frame, in metres.
    pub point_in_base: Point3<f64>,
    /// Which laser's light it is.
    pub laser: usize,
    /// Its place across the image: blocks of columns of equal width, from the left.
    pub block: usize,
    /// What it is on.
    pub upon: Upon,
}

/// A wall's plane in the camera frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenPlane {
    /// Which wall it is.
    pub wall: Wall,
    /// The plane k . x = d.
    pub plane: WallPlane,
    /// Covariance of m = k / d, in 1/m^2; `None` from a perception that states none.
    pub covariance: Option<Matrix3<f64>>,
    /// Stripe points that it rests on.
    pub points: usize,
}

impl SeenPlane {
    /// Standard deviation of the distance d from the camera, in metres: d = 1 / |m|, so its gradient by m is -d^2 k.
    pub fn distance_sigma_m(&self) -> Option<f64> {
        let (k, d) = (self.plane.normal.into_inner(), self.plane.distance_m);
        self.covariance.map(|covariance| d * d * k.dot(&(covariance * k)).max(0.0).sqrt())
    }
}

/// What the stages of a perception made of the last frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stages<'a> {
    /// Stripe centres.
    pub centres: &'a [StripeCentre],
    /// Lines.
    pub lines: &'a [StripeLine],
    /// Walls.
    pub planes: &'a [SeenPlane],
    /// All that the lasers light, by laser and then across the image; empty from a perception that gives no ranges.
    pub ranges: &'a [RangePoint],
}

/// Reads frames. The robust pipeline and the paper's chain are two; a user's own may take their place.
pub trait Perception: Send {
    /// What this frame says. `mount` is where the mount pointed at the exposure.
    fn perceive(&mut self, frame: &Frame<'_>, mount: MountAngles) -> Measurement;

    /// What its stages made of the last frame; a perception that tells nothing still perceives.
    fn stages(&self) -> Stages<'_> {
        Stages::default()
    }
}

impl<P: Perception + ?Sized> Perception for Box<P> {
    fn perceive(&mut self, frame: &Frame<'_>, mount: MountAngles) -> Measurement {
        (**self).perceive(frame, mount)
    }

    fn stages(&self) -> Stages<'_> {
        (**self).stages()
    }
}
