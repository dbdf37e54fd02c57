//! What a renderer is given and what it gives, whichever engine it runs on.

use ductloop_duct::cell::SurfaceId;
use ductloop_nav::rig::{Rig, RigError};
use nalgebra::Vector3;

use crate::Transform;
use crate::frame_geometry::{CLEAR_M, Obstacle};
use crate::light::FAN_MAX_DEG;
use crate::optics::{Bits, Optics, OpticsError};

/// Laser slits that a rig may have.
pub const MAX_LASERS: usize = 4;

/// What changes from frame to frame.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Pose of the camera (frame: x along the rows, y down the columns, z along the view) in the world, in the middle of the
    /// exposure.
    pub world_from_camera: Transform,
    /// How the camera, and the lasers with it, move meanwhile.
    pub motion: Motion,
    /// Number of the frame: chooses its random numbers.
    pub frame: u64,
    /// Exposure, in seconds.
    pub exposure_s: f64,
    /// Power of each of the rig's lasers as a share of nominal; 0 is off. Entries past the rig's lasers are not read.
    pub laser_power: [f64; MAX_LASERS],
    /// Power of the headlamp as a share of nominal; 0 is off.
    pub headlamp_power: f64,
}

/// Velocity of a camera.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Of its centre, in the world, in m/s.
    pub linear_m_s: Vector3<f64>,
    /// Of its axes, in the world, in rad/s.
    pub angular_rad_s: Vector3<f64>,
}

/// Room for an image: `width * height` grey values, row by row from the top left.
#[derive(Debug)]
pub enum ImageMut<'a> {
    /// For a CCD of 8 bits.
    Grey8(&'a mut [u8]),
    /// For one of 10 or 12 bits.
    Grey16(&'a mut [u16]),
}

/// Makes camera images.
pub trait Renderer: Send {
    /// Renders one frame into `image`.
    ///
    /// # Errors
    /// When the image could not be made; `image` is then as it was.
    fn render(&mut self, view: &View, image: ImageMut<'_>) -> Result<(), RenderError>;
}

impl ImageMut<'_> {
    /// Checks that an image of this camera and depth fits.
    ///
    /// # Errors
    /// [`RenderError::BufferSize`] or [`RenderError::BufferBits`].
    pub fn check(&self, pixels: usize, bits: Bits) -> Result<(), RenderError> {
        let (given, deep) = match self {
            Self::Grey8(values) => (values.len(), false),
            Self::Grey16(values) => (values.len(), true),
        };
        if deep != (bits != Bits::Eight) {
            return Err(RenderError::BufferBits { bits: bits.count() });
        }
        if given == pixels { Ok(()) } else { Err(RenderError::BufferSize { expected: pixels, given }) }
    }
}

impl<'a> From<&'a mut [u8]> for ImageMut<'a> {
    fn from(values: &'a mut [u8]) -> Self {
        Self::Grey8(values)
    }
}

impl<'a> From<&'a mut [u16]> for ImageMut<'a> {
    fn from(values: &'a mut [u16]) -> Self {
        Self::Grey16(values)
    }
}

/// Why there is no image.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RenderError {
    /// No graphics adapter, not even a software one.
    #[error(
        "no graphics adapter was found ({0}); on Debian or Ubuntu `apt-get install mesa-vulkan-drivers` installs one that needs no \
         graphics card"
    )]
    NoAdapter(String),
    /// The adapter would not give a device, or the device refused a resource or a shader.
    #[error("the graphics device failed: {0}")]
    Device(String),
    /// The device is gone (driver reset, card removed).
    #[error("the graphics device was lost: {0}")]
    Lost(String),
    /// The device did not finish a frame in time.
    #[error("the graphics device did not finish a frame within {0} s")]
    Hung(f64),
    /// The camera is not inside the duct.
    #[error(
        "{} is outside the duct: it must stand inside, {} mm or more from the metal",
        camera_at(position_m, direction), CLEAR_M * 1e3
    )]
    OutsideNetwork {
        /// Where, in the world.
        position_m: [f64; 3],
        /// Line of sight, in the world.
        direction: [f64; 3],
    },
    /// The camera is inside the duct, but less than [`CLEAR_M`] from a wall or a body, or inside a body.
    #[error(
        "{} is in the duct but nearer than {} mm to the metal of a wall or a body: it must keep that distance",
        camera_at(position_m, direction), CLEAR_M * 1e3
    )]
    AgainstMetal {
        /// Where, in the world.
        position_m: [f64; 3],
        /// Line of sight, in the world.
        direction: [f64; 3],
    },
    /// The buffer for the image has values of another size than the CCD's.
    #[error("a CCD of {bits} bits fills {} values", if *bits == 8 { "8-bit" } else { "16-bit" })]
    BufferBits {
        /// Bits of the CCD.
        bits: u32,
    },
    /// The buffer for the image has the wrong size.
    #[error("the image buffer holds {given} pixels; the camera has {expected}")]
    BufferSize {
        /// Pixels of the camera.
        expected: usize,
        /// Pixels given.
        given: usize,
    },
    /// The image has more pixels than the device's buffers hold.
    #[error("an image of {width_px} x {height_px} pixels is more than this device can render ({limit_mpx} megapixels)")]
    TooManyPixels {
        /// Columns.
        width_px: usize,
        /// Rows.
        height_px: usize,
        /// Millions of pixels it can have.
        limit_mpx: u64,
    },
    /// The image is larger than the device's textures may be.
    #[error("an image of {width_px} x {height_px} pixels is larger than this device can render ({limit_px} a side)")]
    ImageTooLarge {
        /// Columns.
        width_px: usize,
        /// Rows.
        height_px: usize,
        /// Largest side.
        limit_px: usize,
    },
    /// The rig has more lasers than renderers provide for.
    #[error("the rig has {0} lasers; at most {MAX_LASERS} can be rendered")]
    TooManyLasers(usize),
    /// A laser's fan is too wide.
    #[error("the fan of laser `{laser}` opens by {fan_deg:.1} degrees; it must be above 0 and at most {FAN_MAX_DEG}")]
    Fan {
        /// The laser's name.
        laser: String,
        /// Its opening.
        fan_deg: f64,
    },
    /// A surface of the network has no entry in the table of looks.
    #[error("surface {} of the duct has no look: the table has {looks} entries", surface.0)]
    NoLook {
        /// The surface.
        surface: SurfaceId,
        /// Entries of the table.
        looks: usize,
    },
    /// A surface that cannot be.
    #[error("surface {index} of the duct: {field} is {value}; it must be {bound}")]
    Look {
        /// Its place in the table of looks.
        index: usize,
        /// The field's name.
        field: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        bound: &'static str,
    },
    /// The lens' distortion cannot be undone.
    #[error(
        "the lens' distortion folds the image: no single ray belongs to pixel ({u_px:.0}, {v_px:.0}); smaller coefficients are needed"
    )]
    Distortion {
        /// Where it was found, along u.
        u_px: f64,
        /// Along v.
        v_px: f64,
    },
    /// Exposure or a power is negative or not a number, or the motion is no number.
    #[error("{what} is {value}; it must be finite and not negative")]
    ViewValue {
        /// Which value.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The rig cannot work.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// The optics cannot work.
    #[error(transparent)]
    Optics(#[from] OpticsError),
}

impl View {
    /// Checks the values that are not part of the pose, which is checked by looking for its cell.
    ///
    /// # Errors
    /// [`RenderError::ViewValue`] for the first value that is negative or not finite.
    pub fn validate(&self) -> Result<(), RenderError> {
        let powers = self.laser_power.iter().map(|power| ("a laser's power", *power));
        let rest = [("the exposure, in seconds,", self.exposure_s), ("the headlamp's power", self.headlamp_power)];
        for (what, value) in rest.into_iter().chain(powers) {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(RenderError::ViewValue { what, value });
            }
        }
        let Motion { linear_m_s, angular_rad_s } = &self.motion;
        for (what, velocity) in [("the camera's speed, in m/s,", linear_m_s), ("its turning, in rad/s,", angular_rad_s)] {
            let value = velocity.norm();
            if !value.is_finite() {
                return Err(RenderError::ViewValue { what, value });
            }
        }
        Ok(())
    }
}

impl RenderError {
    /// The error that names the pose of a camera which cannot be there.
    pub fn standpoint(obstacle: Obstacle, world_from_camera: &Transform) -> Self {
        let position_m = world_from_camera.translation.vector.into();
        let direction = (world_from_camera.rotation * Vector3::z()).into();
        match obstacle {
            Obstacle::Outside => Self::OutsideNetwork { position_m, direction },
            Obstacle::Metal => Self::AgainstMetal { position_m, direction },
        }
    }
}

fn camera_at([x, y, z]: &[f64; 3], [along_x, along_y, along_z]: &[f64; 3]) -> String {
    let [x, y, z] = [x, y, z].map(|x| metres(*x));
    format!("the camera at ({x}, {y}, {z}) m, looking along ({along_x:.3}, {along_y:.3}, {along_z:.3}),")
}

/// Metres to the millimetre; what is farther than any duct is long, by its exponent.
fn metres(x: f64) -> String {
    if x.abs() < 1e6 { format!("{x:.3}") } else { format!("{x:.3e}") }
}

/// Checks what every renderer is made with.
///
/// # Errors
/// Whatever is wrong with rig and optics, more than [`MAX_LASERS`] lasers, a fan that opens too wide or not at all.
pub(crate) fn check_parameters(rig: &Rig, optics: &Optics) -> Result<(), RenderError> {
    rig.validate()?;
    optics.validate()?;
    if rig.lasers.len() > MAX_LASERS {
        return Err(RenderError::TooManyLasers(rig.lasers.len()));
    }
    for laser in &rig.lasers {
        let fan_deg = laser.fan_rad.to_degrees();
        if !(fan_deg > 0.0 && fan_deg <= FAN_MAX_DEG) {
            return Err(RenderError::Fan { laser: laser.name.clone(), fan_deg });
        }
    }
    Ok(())
}
