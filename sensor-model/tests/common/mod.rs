//! What the tests of the renderers share: the two rigs, ducts to look at, a device to render with.
#![allow(dead_code, unreachable_pub)] // each binary that includes this uses its own part
#![allow(clippy::unwrap_used)] // only tests, benchmarks and examples include it

pub mod areas;
pub mod scenes;

use std::f64::consts::PI;
#[cfg(feature = "wgpu")]
use std::sync::OnceLock;

use ductloop_duct::cell::SurfaceId;
use ductloop_duct::fitting::{Fitting, Shape};
use ductloop_duct::network::{End, Network};
use ductloop_nav::rig::{Camera, Distortion, Laser, LineWidth, Mount, MountAngles, Rig};
use ductloop_sensor::Transform;
#[cfg(feature = "wgpu")]
use ductloop_sensor::gpu::Gpu;
use ductloop_sensor::optics::Optics;
#[cfg(feature = "wgpu")]
use ductloop_sensor::renderer::RenderError;
use ductloop_sensor::renderer::{MAX_LASERS, Motion, Renderer, View};
use ductloop_sensor::surface::Look;
use nalgebra::{Point3, Unit, UnitQuaternion, Vector3};

/// The device, opened once. `None` only where there is no adapter and the environment says that this is all right.
#[cfg(feature = "wgpu")]
pub fn gpu() -> Option<&'static Gpu> {
    static GPU: OnceLock<Option<Gpu>> = OnceLock::new();
    GPU.get_or_init(|| match Gpu::open() {
        Ok(gpu) => Some(gpu),
        Err(RenderError::NoAdapter(why)) if std::env::var_os("DUCTLOOP_ALLOW_NO_GPU").is_some() => {
            println!("skipped: no graphics adapter ({why})");
            None
        }
        Err(error) => panic!("{error}"),
    })
    .as_ref()
}

pub const LINE: LineWidth = LineWidth { width_m: 2e-3, growth_rad: 4e-3 };

fn deg(angle_deg: f64) -> f64 {
    angle_deg * PI / 180.0
}

/// The `wide` rig: two nearly level slits from above and below the lens.
pub fn wide() -> Rig {
    let mount = Mount { position_in_base_m: Point3::new(0.12, 0.0, 0.10), roll_rad: 0.0, rest: MountAngles::default() };
    let camera_from_base = mount.base_from_camera(mount.rest).inverse();
    let laser = |name: &str, source: [f64; 3], normal: [f64; 3]| {
        let normal_in_camera = Unit::new_normalize(Vector3::from(normal));
        let source_in_camera = camera_from_base * Point3::from(source);
        Laser {
            name: name.to_owned(),
            normal_in_camera,
            offset_m: normal_in_camera.dot(&source_in_camera.coords),
            source_in_camera,
            fan_rad: deg(100.0),
        }
    };
    Rig {
        camera: Camera {
            width_px: 640,
            height_px: 480,
            focal_px: [378.4; 2],
            centre_px: [319.5, 239.5],
            distortion: Distortion::NONE,
        },
        lasers: vec![
            laser("low", [0.12, 0.0, 0.04], [-0.029838, 0.994594, 0.099459]),
            laser("high", [0.12, 0.0, 0.16], [-0.029610, -0.987007, 0.157921]),
        ],
        mount,
        line: LINE,
    }
}

/// The wide rig's camera with one level slit from just below it that looks straight ahead, meeting a wall squarely.
pub fn square_on() -> Rig {
    let source_in_camera = Point3::new(0.0, 0.02, 0.0);
    let laser = Laser {
        name: "level".to_owned(),
        normal_in_camera: Unit::new_normalize(Vector3::y()),
        offset_m: 0.02,
        source_in_camera,
        fan_rad: 1.0,
    };
    Rig { lasers: vec![laser], ..wide() }
}

/// INCRA I's rig as recovered from the paper's tables, looking right. Fans of 60 degrees (assumption: the tables say nothing).
pub fn incra1() -> Rig {
    let laser = |name: &str, normal: [f64; 3], offset_m: f64| {
        let normal_in_camera = Unit::new_normalize(Vector3::from(normal));
        let source_in_camera = Point3::from(normal_in_camera.into_inner() * offset_m);
        Laser { name: name.to_owned(), normal_in_camera, offset_m, source_in_camera, fan_rad: deg(60.0) }
    };
    Rig {
        camera: Camera {
            width_px: 640,
            height_px: 480,
            focal_px: [1081.0; 2],
            centre_px: [320.0, 240.0],
            distortion: Distortion::NONE,
        },
        mount: Mount {
            position_in_base_m: Point3::new(0.12, 0.0, 0.10),
            roll_rad: deg(90.0),
            rest: MountAngles { pan_rad: deg(-50.0), tilt_rad: 0.0 },
        },
        lasers: vec![
            laser("right", [0.75130632, -0.61816050, 0.23111989], 0.06878742),
            laser("left", [0.74444940, -0.60260520, 0.28751011], 0.03728516),
        ],
        line: LINE,
    }
}

pub fn straight(length_m: f64, width_m: f64, height_m: f64) -> Fitting {
    Fitting { shape: Shape::Straight { length_m }, width_m, height_m, surface: SurfaceId(0) }
}

pub fn elbow(angle_deg: f64, throat_radius_m: f64, width_m: f64, height_m: f64) -> Fitting {
    let shape = Shape::RadiusElbow { angle_rad: deg(angle_deg), throat_radius_m };
    Fitting { shape, width_m, height_m, surface: SurfaceId(0) }
}

/// Fittings in a row, open behind, capped ahead.
pub fn duct(fittings: &[Fitting]) -> Network {
    Network::from_run(fittings, End::Open, End::Cap).unwrap()
}

/// A duct whose end cap is 0.3 m in front of the camera of a robot at x = 1.
pub fn facing_wall() -> Network {
    duct(&[straight(1.0 + 0.12 + 0.3, 0.5, 0.3)])
}

/// Sheet metal of albedo 1/2, and a second surface a little darker.
pub const LOOKS: [Look; 2] = [Look::matt(0.5), Look::matt(0.4)];

/// Light without anything random.
pub fn quiet() -> Optics {
    Optics { noise: false, ..Optics::default() }
}

/// The base on the floor at (x, y), heading in degrees.
pub fn base_at(x: f64, y: f64, heading_deg: f64) -> Transform {
    Transform::from_parts(Vector3::new(x, y, 0.0).into(), UnitQuaternion::from_axis_angle(&Vector3::z_axis(), deg(heading_deg)))
}

/// Frame 0 at nominal exposure and power, with the mount at rest.
pub fn view(rig: &Rig, world_from_base: &Transform) -> View {
    View {
        world_from_camera: world_from_base * rig.mount.base_from_camera(rig.mount.rest),
        frame: 0,
        motion: Motion::default(),
        exposure_s: 4e-3,
        laser_power: [1.0; MAX_LASERS],
        headlamp_power: 1.0,
    }
}

pub fn image(renderer: &mut dyn Renderer, rig: &Rig, view: &View) -> Vec<u8> {
    let mut pixels = vec![0; rig.camera.width_px * rig.camera.height_px];
    renderer.render(view, pixels.as_mut_slice().into()).unwrap();
    pixels
}
