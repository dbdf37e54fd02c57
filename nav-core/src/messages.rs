//! What passes between the robot's body and its navigator: frames, encoder counts, mount angles and time one way, commands
//! the other. Nothing else does.

use crate::rig::MountAngles;

/// Physics ticks since the start of the run. There is no other clock.
pub type Tick = u64;

/// The grey values of a frame, row by row from the top left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pixels<'a> {
    /// 8 bits a pixel.
    Grey8(&'a [u8]),
    /// Up to 16 bits a pixel.
    Grey16(&'a [u16]),
}

/// One camera frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame<'a> {
    /// Columns.
    pub width_px: usize,
    /// Rows.
    pub height_px: usize,
    /// `width_px * height_px` values.
    pub pixels: Pixels<'a>,
    /// The largest grey value that the camera gives, at which a pixel is full: 255, 1023 or 4095.
    pub max_dn: u16,
}

impl<'a> Frame<'a> {
    /// A frame of 8 bits.
    pub fn grey8(width_px: usize, height_px: usize, pixels: &'a [u8]) -> Self {
        Self { width_px, height_px, pixels: Pixels::Grey8(pixels), max_dn: 255 }
    }

    /// A frame of more than 8 bits, whose largest grey value is `max_dn`.
    pub fn grey16(width_px: usize, height_px: usize, pixels: &'a [u16], max_dn: u16) -> Self {
        Self { width_px, height_px, pixels: Pixels::Grey16(pixels), max_dn }
    }

    /// What a grey value of 8 bits (parameters in DN are stated so) is in this frame: 1 with 8 bits, 1023/255 with 10.
    pub fn dn_per_dn8(&self) -> f64 {
        f64::from(self.max_dn) / 255.0
    }
}

/// Encoder counts since power-on, of each side's motor. Forward is positive on both sides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Left motor.
    pub left: i64,
    /// Right motor.
    pub right: i64,
}

/// A value for each side of the robot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sides {
    /// Left.
    pub left: f64,
    /// Right.
    pub right: f64,
}

/// A swing of the mount: pan and tilt each follow amplitude times sin(2 pi t / period), t from the command that began it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MountSweep {
    /// Amplitude of pan and tilt.
    pub amplitude: MountAngles,
    /// Time from one swing to the next, in seconds.
    pub period_s: f64,
}

/// What the command controller asks of the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command {
    /// Wheel speeds to hold, in rad/s at the wheel.
    pub wheel_speed_rad_s: Sides,
    /// Mount angles to go to, and to hold or swing about.
    pub mount: MountAngles,
    /// How to swing about them; `None` holds them. The same swing again goes on where it is.
    pub sweep: Option<MountSweep>,
    /// Exposure of the next frame, in seconds; `None` leaves it as it is.
    pub exposure_s: Option<f64>,
    /// Laser power from the next frame on, as a share of the nominal power; `None` leaves it as it is.
    pub laser_power: Option<f64>,
}

impl Command {
    /// Stand still, with the mount at `mount`.
    pub fn stop(mount: MountAngles) -> Self {
        Self { wheel_speed_rad_s: Sides::default(), mount, sweep: None, exposure_s: None, laser_power: None }
    }
}
