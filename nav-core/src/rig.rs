//! The structured-light rig: one camera on a pan-tilt mount, and the laser planes that turn with it.
//!
//! These are *parameters* only. The renderer projects with them and the navigator triangulates with them, each by its own
//! code, so that a sign wrong in one of the two shows up as an error instead of cancelling itself.

use nalgebra::{Matrix3, Point3, Rotation3, Translation3, Unit, Vector3};

use crate::angle::{rotation_about_x, rotation_about_y, rotation_about_z};

/// Rigid transform between two of the robot's frames.
pub type Transform = nalgebra::Isometry3<f64>;

/// A camera: a pinhole behind a lens that may distort.
///
/// Camera frame: x toward increasing column u, y toward increasing row v, z along the view. Pixel (0, 0) is the *centre* of
/// the first pixel, so the image covers u from -0.5 to `width_px - 0.5`.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Columns of the image.
    pub width_px: usize,
    /// Rows of the image.
    pub height_px: usize,
    /// Focal length along u and v, in pixels.
    pub focal_px: [f64; 2],
    /// Principal point (u, v), in pixels.
    pub centre_px: [f64; 2],
    /// How the lens bends straight lines.
    pub distortion: Distortion,
}

/// Distortion of a lens after Brown (Photogrammetric Engineering 37(8), 1971) and Conrady, in the form and order of `OpenCV`.
///
/// A point of the camera frame with x = X/Z, y = Y/Z and r^2 = x^2 + y^2 is seen at u = `fx` x' + `u0`, v = `fy` y' + `v0`, where
///
/// ```text
/// x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2)
/// y' = y (1 + k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 y^2) + 2 p2 x y
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distortion {
    /// Radial, of r^2.
    pub k1: f64,
    /// Radial, of r^4.
    pub k2: f64,
    /// Tangential, along v.
    pub p1: f64,
    /// Tangential, along u.
    pub p2: f64,
    /// Radial, of r^6.
    pub k3: f64,
}

impl Distortion {
    /// No distortion: a pinhole.
    pub const NONE: Self = Self { k1: 0.0, k2: 0.0, p1: 0.0, p2: 0.0, k3: 0.0 };
}

/// Where the camera stands on the robot, and where the mount points it.
///
/// `base_from_camera = T(position) Rz(pan) Ry(tilt) L Rz(roll)` with L = [[0, 0, 1], [-1, 0, 0], [0, -1, 0]]: negative pan
/// looks right, positive tilt looks down.
#[derive(Clone, Debug, PartialEq)]
pub struct Mount {
    /// The camera's centre, which is also where the pan and tilt axes meet, in the base frame, in metres.
    pub position_in_base_m: Point3<f64>,
    /// Rotation of the camera about its own line of sight, in radians. Part of how it is bolted on, not driven.
    pub roll_rad: f64,
    /// The pan and tilt at which the mount is held unless it is commanded otherwise.
    pub rest: MountAngles,
}

/// Pan and tilt of the mount.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MountAngles {
    /// Anticlockwise from above, in radians: negative looks right.
    pub pan_rad: f64,
    /// In radians: positive looks down.
    pub tilt_rad: f64,
}

/// A laser slit: a plane of light that leaves its source as a fan.
#[derive(Clone, Debug, PartialEq)]
pub struct Laser {
    /// The name by which scenarios speak of it: `low`, `high`, `left`, `right`.
    pub name: String,
    /// Unit normal n of the plane n . p = d, in the camera frame.
    pub normal_in_camera: Unit<Vector3<f64>>,
    /// Distance d of the plane from the camera's centre along the normal, in metres. Never zero: such a plane shows no depth.
    pub offset_m: f64,
    /// The fan's apex, a point of the plane, in the camera frame, in metres.
    pub source_in_camera: Point3<f64>,
    /// Full opening angle of the fan, in radians, centred on the direction in the plane nearest to the line of sight.
    pub fan_rad: f64,
}

/// How thick the slits' light is: full width at half maximum `width_m + growth_rad * distance`, distance from the source.
///
/// A Gaussian beam's width grows as w0 sqrt(1 + (z/zR)^2); over the metre or two that count here a straight line is near enough
/// to one focused at the source, and it is what the rigs' numbers were chosen with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineWidth {
    /// Full width at half maximum at the source, in metres.
    pub width_m: f64,
    /// Growth of the width with distance, in radians (metres a metre).
    pub growth_rad: f64,
}

/// Camera, mount and lasers together. A run has two of these: the true one, which renders, and the nominal one, which
/// navigates.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    /// The camera.
    pub camera: Camera,
    /// Where it stands and points.
    pub mount: Mount,
    /// The laser slits, in the order in which stripes are numbered.
    pub lasers: Vec<Laser>,
    /// The slits' thickness.
    pub line: LineWidth,
}

impl Mount {
    /// The pose of the camera in the base frame for given mount angles (the formula is the type's own).
    pub fn base_from_camera(&self, angles: MountAngles) -> Transform {
        let optical = Rotation3::from_matrix_unchecked(Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0));
        let rotation =
            rotation_about_z(angles.pan_rad) * rotation_about_y(angles.tilt_rad) * optical * rotation_about_z(self.roll_rad);
        Transform::from_parts(Translation3::from(self.position_in_base_m.coords), rotation.into())
    }
}

impl LineWidth {
    /// Full width at half maximum at `distance_m` from the source, in metres.
    pub fn at(&self, distance_m: f64) -> f64 {
        self.width_m + self.growth_rad * distance_m
    }
}

/// Why a rig cannot work.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RigError {
    /// The image is too small or too large to work with.
    #[error("the image is {width_px} x {height_px} pixels; it must be between 16 x 16 and 8192 x 8192")]
    ImageSize {
        /// Columns.
        width_px: usize,
        /// Rows.
        height_px: usize,
    },
    /// The focal length is not a positive number.
    #[error("the focal length is {0:?} px; both must be positive")]
    Focal([f64; 2]),
    /// There are no lasers.
    #[error("the rig has no laser")]
    NoLaser,
    /// The laser's plane passes through the camera's centre.
    #[error(
        "the plane of laser `{laser}` passes {offset_mm:.3} mm from the camera's centre: its stripe shows no depth; at least 1 mm is needed"
    )]
    PlaneThroughCamera {
        /// The laser's name.
        laser: String,
        /// The plane's distance from the camera.
        offset_mm: f64,
    },
    /// The fan's apex does not lie on the laser's plane.
    #[error("the source of laser `{laser}` lies {off_plane_mm:.3} mm off its plane")]
    SourceOffPlane {
        /// The laser's name.
        laser: String,
        /// How far off.
        off_plane_mm: f64,
    },
}

impl Rig {
    /// Checks what every user of a rig relies on.
    ///
    /// # Errors
    /// The first rule that does not hold.
    pub fn validate(&self) -> Result<(), RigError> {
        let Camera { width_px, height_px, focal_px, .. } = self.camera;
        if !(16..=8192).contains(&width_px) || !(16..=8192).contains(&height_px) {
            return Err(RigError::ImageSize { width_px, height_px });
        }
        if !focal_px.iter().all(|f| *f > 0.0 && f.is_finite()) {
            return Err(RigError::Focal(focal_px));
        }
        if self.lasers.is_empty() {
            return Err(RigError::NoLaser);
        }
        for laser in &self.lasers {
            if laser.offset_m.abs() < 1e-3 {
                return Err(RigError::PlaneThroughCamera { laser: laser.name.clone(), offset_mm: laser.offset_m * 1e3 });
            }
            let off_plane = laser.normal_in_camera.dot(&laser.source_in_camera.coords) - laser.offset_m;
            if off_plane.abs() > 1e-4 {
                return Err(RigError::SourceOffPlane { laser: laser.name.clone(), off_plane_mm: off_plane * 1e3 });
            }
        }
        Ok(())
    }

    /// This rig as it truly is when its mount points elsewhere than it reports, by these angles.
    pub fn with_mount_error(mut self, pan_rad: f64, tilt_rad: f64, roll_rad: f64) -> Self {
        self.mount.rest.pan_rad += pan_rad;
        self.mount.rest.tilt_rad += tilt_rad;
        self.mount.roll_rad += roll_rad;
        self
    }

    /// This rig with the plane of laser `index` turned by `angle_rad` about the camera's x axis through the laser's source.
    pub fn with_plane_turned(mut self, index: usize, angle_rad: f64) -> Self {
        let laser = &mut self.lasers[index];
        laser.normal_in_camera = Unit::new_normalize(rotation_about_x(angle_rad) * laser.normal_in_camera.into_inner());
        laser.offset_m = laser.normal_in_camera.dot(&laser.source_in_camera.coords);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axes(pan_deg: f64, tilt_deg: f64, roll_deg: f64) -> [Vector3<f64>; 3] {
        let mount = Mount {
            position_in_base_m: Point3::new(0.12, 0.0, 0.1),
            roll_rad: roll_deg.to_radians(),
            rest: MountAngles::default(),
        };
        let angles = MountAngles { pan_rad: pan_deg.to_radians(), tilt_rad: tilt_deg.to_radians() };
        let rotation = mount.base_from_camera(angles).rotation;
        [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| rotation * axis)
    }

    #[track_caller]
    fn assert_points(direction: Vector3<f64>, to: [f64; 3]) {
        assert!((direction - Vector3::from(to)).norm() < 1e-12, "{direction} instead of {to:?}");
    }

    /// Base: x forward, y left, z up. The words of the type's documentation, one by one.
    #[test]
    fn the_mount_turns_the_camera_as_it_says() {
        let [u, v, view] = axes(0.0, 0.0, 0.0);
        assert_points(view, [1.0, 0.0, 0.0]);
        assert_points(u, [0.0, -1.0, 0.0]);
        assert_points(v, [0.0, 0.0, -1.0]);
        // Negative pan looks right; positive tilt looks down.
        assert_points(axes(-90.0, 0.0, 0.0)[2], [0.0, -1.0, 0.0]);
        assert_points(axes(0.0, 90.0, 0.0)[2], [0.0, 0.0, -1.0]);
        // Pan is the outer axis: tilted down and panned right, the view stays tilted.
        let half = std::f64::consts::FRAC_1_SQRT_2;
        assert_points(axes(-90.0, 45.0, 0.0)[2], [0.0, -half, -half]);
        // INCRA I's portrait: increasing u points down, increasing v points left.
        let [u, v, _] = axes(0.0, 0.0, 90.0);
        assert_points(u, [0.0, 0.0, -1.0]);
        assert_points(v, [0.0, 1.0, 0.0]);
    }

    fn rig() -> Rig {
        let source = Point3::new(0.0, 0.06, 0.0);
        let normal = Unit::new_normalize(Vector3::new(0.0, 1.0, 0.1));
        Rig {
            camera: Camera {
                width_px: 640,
                height_px: 480,
                focal_px: [400.0; 2],
                centre_px: [319.5, 239.5],
                distortion: Distortion::NONE,
            },
            mount: Mount { position_in_base_m: Point3::origin(), roll_rad: 0.0, rest: MountAngles::default() },
            lasers: vec![Laser {
                name: "low".into(),
                normal_in_camera: normal,
                offset_m: normal.dot(&source.coords),
                source_in_camera: source,
                fan_rad: 1.0,
            }],
            line: LineWidth { width_m: 0.002, growth_rad: 0.004 },
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        assert_eq!(rig().validate(), Ok(()));
        let mut through_camera = rig();
        through_camera.lasers[0].offset_m = 5e-4;
        assert!(matches!(through_camera.validate(), Err(RigError::PlaneThroughCamera { .. })));
        let mut off_plane = rig();
        off_plane.lasers[0].source_in_camera.y += 0.01;
        assert!(matches!(off_plane.validate(), Err(RigError::SourceOffPlane { .. })));
        let mut blind = rig();
        blind.camera.focal_px[1] = f64::NAN;
        assert!(matches!(blind.validate(), Err(RigError::Focal(_))));
        let mut dark = rig();
        dark.lasers.clear();
        assert_eq!(dark.validate(), Err(RigError::NoLaser));
    }

    #[test]
    fn a_turned_plane_still_holds_its_source() {
        let turned = rig().with_plane_turned(0, 2.0_f64.to_radians());
        assert_eq!(turned.validate(), Ok(()));
        let cosine = turned.lasers[0].normal_in_camera.dot(&rig().lasers[0].normal_in_camera);
        assert!((libm::acos(cosine).to_degrees() - 2.0).abs() < 1e-9);
    }
}
