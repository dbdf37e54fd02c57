//! What is truly in view: depth, surface and normal of every pixel, and the middle of each laser's light, to rounding.
//!
//! By casting rays through the network, solids included, one at a time in double precision. It shares nothing with
//! [`crate::frame_geometry`] and the renderers but the lens' [`Projection`], so that it can judge them; it is slow (a tenth of a
//! second a frame) and is no part of a run.
//!
//! A laser's light is taken as a plane without thickness within its nominal opening (`Laser::fan_rad`): the fading ends of the fan,
//! a stripe's width, the lens and motion are left out. Two crossings of a stripe within a pixel of each other in one column, as at
//! the tip of a wedge, cancel and are missed, and so is one within a pixel of the edge of something nearer.

use ductloop_duct::cell::CellId;
use ductloop_duct::network::{Hit, Network};
use ductloop_nav::rig::{Laser, Rig};
use nalgebra::{Point3, Unit, Vector3};

use crate::Transform;
use crate::lens::Projection;
use crate::renderer::RenderError;

/// [`FrameTruth::surface`] of a pixel that looks out of an open end.
pub const OPEN: u16 = u16::MAX;

/// A duct network and a rig, ready to be looked at.
#[derive(Clone, Debug)]
pub struct SceneTruth {
    network: Network,
    /// The network as the lasers' light passes through it.
    lit: Network,
    lasers: Vec<Laser>,
    projection: Result<Projection, RenderError>,
}

/// What a camera truly sees from one place. Images run row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameTruth {
    /// Columns.
    pub width_px: usize,
    /// Rows.
    pub height_px: usize,
    /// Depth along the view (z of the camera frame), in metres, at each pixel's centre; infinite where the view is open.
    pub depth_m: Vec<f32>,
    /// Number of the surface; [`OPEN`] where the view is open.
    pub surface: Vec<u16>,
    /// Unit normal in the camera frame, toward the camera; zeros where the view is open.
    pub normal: Vec<[f32; 3]>,
    /// Middles of the lasers' light, laser by laser: first those in columns, then those in rows.
    pub centres: Vec<CentrePoint>,
}

/// A point on the middle of a laser's light that the laser reaches and the camera sees.
///
/// Where the stripe runs nearer to the image's rows it is in the middle of a column (`u_px` whole), elsewhere in the middle of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CentrePoint {
    /// Index of the laser.
    pub laser: usize,
    /// Its column, in pixels; 0 is the centre of the first.
    pub u_px: f64,
    /// Its row.
    pub v_px: f64,
    /// Where it is, in the camera frame, in metres.
    pub point_in_camera_m: [f64; 3],
    /// Number of the surface that it is on.
    pub surface: u16,
    /// Angle of the light from the middle of the laser's fan, in radians, positive toward normal x middle; at most half
    /// `Laser::fan_rad` either way.
    pub fan_rad: f64,
}

/// Along which side of the image a stripe is searched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scan {
    Column,
    Row,
}

/// A camera at its place.
struct Station<'a> {
    network: &'a Network,
    lit: &'a Network,
    projection: &'a Projection,
    world_from_camera: &'a Transform,
    cell: CellId,
}

/// A laser's plane and source.
struct Light<'a> {
    laser: &'a Laser,
    /// Middle of the fan and the direction of the plane square to it.
    along: Vector3<f64>,
    across: Vector3<f64>,
    /// `None` outside the network.
    cell: Option<CellId>,
}

impl SceneTruth {
    /// For what `rig` sees of `network`.
    pub fn new(network: &Network, rig: &Rig) -> Self {
        Self {
            network: network.clone(),
            lit: network.clone(),
            lasers: rig.lasers.clone(),
            projection: Projection::new(&rig.camera, 1.0),
        }
    }

    /// The same with bodies that cast no shadows: [`crate::optics::Optics::shadows`].
    #[must_use]
    pub fn without_shadows(mut self) -> Self {
        self.lit.cells.iter_mut().for_each(|cell| cell.solids.clear());
        self
    }

    /// What is seen by a camera at this pose (frame: x along the rows, y down the columns, z along the view).
    ///
    /// # Errors
    /// [`RenderError::OutsideNetwork`], and [`RenderError::Distortion`] where the lens folds the image.
    pub fn of(&self, world_from_camera: &Transform) -> Result<FrameTruth, RenderError> {
        let projection = self.projection.as_ref().map_err(Clone::clone)?;
        let position = Point3::from(world_from_camera.translation.vector);
        let cell = self.network.cell_at(&position, 0).ok_or_else(|| RenderError::OutsideNetwork {
            position_m: world_from_camera.translation.vector.into(),
            direction: (world_from_camera.rotation * Vector3::z()).into(),
        })?;
        let station = Station { network: &self.network, lit: &self.lit, projection, world_from_camera, cell };
        let (width_px, height_px) = (projection.camera.width_px, projection.camera.height_px);
        let hits: Vec<Option<Hit>> =
            (0..width_px * height_px).map(|i| station.hit([(i % width_px) as f64, (i / width_px) as f64])).collect();
        let camera_from_world = world_from_camera.inverse();
        let mut frame = FrameTruth {
            width_px,
            height_px,
            depth_m: vec![f32::INFINITY; hits.len()],
            surface: vec![OPEN; hits.len()],
            normal: vec![[0.0; 3]; hits.len()],
            centres: Vec::new(),
        };
        for (i, hit) in hits.iter().enumerate() {
            let Some(hit) = hit else { continue };
            frame.depth_m[i] = (camera_from_world * hit.point).z as f32;
            frame.surface[i] = hit.surface.0;
            frame.normal[i] = (camera_from_world.rotation * hit.normal.into_inner()).map(|n| n as f32).into();
        }
        let points: Vec<Option<Point3<f64>>> = hits.iter().map(|hit| hit.map(|hit| camera_from_world * hit.point)).collect();
        for (index, laser) in self.lasers.iter().enumerate() {
            let light = Light::new(laser, &station);
            for scan in [Scan::Column, Scan::Row] {
                station.scan(index, &light, scan, &points, &mut frame.centres);
            }
        }
        Ok(frame)
    }
}

impl<'a> Light<'a> {
    fn new(laser: &'a Laser, station: &Station) -> Self {
        let normal = laser.normal_in_camera.into_inner();
        let in_plane = |axis: Vector3<f64>| axis - normal * normal.dot(&axis);
        // The direction in the plane nearest to the line of sight; a plane square to that takes the camera's x.
        let along = in_plane(Vector3::z()).try_normalize(1e-6).unwrap_or_else(|| in_plane(Vector3::x()).normalize());
        let source_in_world = station.world_from_camera * laser.source_in_camera;
        let cell = station.network.cell_at(&source_in_world, station.cell);
        Self { laser, along, across: normal.cross(&along), cell }
    }

    /// Distance of a point of the camera frame from the plane, in metres.
    fn off_m(&self, point: &Point3<f64>) -> f64 {
        self.laser.normal_in_camera.dot(&point.coords) - self.laser.offset_m
    }

    /// Angle from the middle of the fan to a point of the plane, in radians.
    fn angle_rad(&self, point: &Point3<f64>) -> f64 {
        let way = point - self.laser.source_in_camera;
        libm::atan2(way.dot(&self.across), way.dot(&self.along))
    }
}

impl Station<'_> {
    /// What is seen at a pixel.
    fn hit(&self, pixel: [f64; 2]) -> Option<Hit> {
        let [x, y] = self.projection.ray(pixel);
        let direction = Unit::new_normalize(self.world_from_camera.rotation * Vector3::new(x, y, 1.0));
        let origin = Point3::from(self.world_from_camera.translation.vector);
        self.network.cast(self.cell, &origin, &direction, f64::INFINITY)
    }

    /// Appends the crossings of a laser's light with all columns (or rows) that it crosses more squarely than the rows (or columns).
    /// `points` is what the pixels see, in the camera frame.
    fn scan(&self, index: usize, light: &Light, scan: Scan, points: &[Option<Point3<f64>>], centres: &mut Vec<CentrePoint>) {
        let (width, height) = (self.projection.camera.width_px, self.projection.camera.height_px);
        let (lines, steps) = if scan == Scan::Column { (width, height) } else { (height, width) };
        let pixel = |line: usize, at: f64| if scan == Scan::Column { [line as f64, at] } else { [at, line as f64] };
        let off = |line: usize, at: f64| self.hit(pixel(line, at)).map(|hit| light.off_m(&self.in_camera(&hit)));
        for line in 0..lines {
            let known = |step: usize| {
                let index = if scan == Scan::Column { step * width + line } else { line * width + step };
                points[index].as_ref().map(|point| light.off_m(point))
            };
            // The border of the image, the pixels' centres, the other border.
            let mut before = (-0.5, off(line, -0.5));
            for step in 0..=steps {
                let here =
                    if step < steps { (step as f64, known(step)) } else { (step as f64 - 0.5, off(line, step as f64 - 0.5)) };
                if let (Some(a), Some(b)) = (before.1, here.1)
                    && (a < 0.0) != (b < 0.0)
                    && let Some(at) = bisect(before.0, here.0, a < 0.0, &|at| off(line, at))
                {
                    centres.extend(self.centre(index, light, scan, pixel(line, at)));
                }
                before = here;
            }
        }
    }

    fn in_camera(&self, hit: &Hit) -> Point3<f64> {
        self.world_from_camera.inverse_transform_point(&hit.point)
    }

    /// The point of light at a pixel, if it belongs to this scan, is within the fan, and the laser reaches it.
    fn centre(&self, index: usize, light: &Light, scan: Scan, pixel: [f64; 2]) -> Option<CentrePoint> {
        let hit = self.hit(pixel)?;
        let point = self.in_camera(&hit);
        let normal = self.world_from_camera.rotation.inverse() * hit.normal.into_inner();
        let [by_u, by_v] = self.slope(light, &point, &normal, pixel);
        let crosses_columns = by_v.abs() >= by_u.abs();
        let fan_rad = light.angle_rad(&point);
        let found = crosses_columns == (scan == Scan::Column)
            && fan_rad.abs() <= light.laser.fan_rad / 2.0
            && normal.dot(&(light.laser.source_in_camera - point)) > 0.0
            && self.is_lit(light, &hit.point);
        found.then(|| CentrePoint {
            laser: index,
            u_px: pixel[0],
            v_px: pixel[1],
            point_in_camera_m: point.coords.into(),
            surface: hit.surface.0,
            fan_rad,
        })
    }

    /// How the distance from the laser's plane changes along u and v over the surface met at a pixel, in metres a pixel.
    fn slope(&self, light: &Light, point: &Point3<f64>, normal: &Vector3<f64>, pixel: [f64; 2]) -> [f64; 2] {
        /// Short against any lens' bending, long against rounding.
        const STEP_PX: f64 = 1e-3;
        let off = |u_px: f64, v_px: f64| {
            let [x, y] = self.projection.ray([u_px, v_px]);
            let ray = Vector3::new(x, y, 1.0);
            light.off_m(&Point3::from(ray * (normal.dot(&point.coords) / normal.dot(&ray))))
        };
        let [u, v] = pixel;
        [off(u + STEP_PX, v) - off(u - STEP_PX, v), off(u, v + STEP_PX) - off(u, v - STEP_PX)].map(|d| d / (2.0 * STEP_PX))
    }

    /// Whether nothing is between the laser's source and a point.
    fn is_lit(&self, light: &Light, point_in_world: &Point3<f64>) -> bool {
        /// What the light meets this near to the point is the point, in metres.
        const SAME_M: f64 = 1e-7;
        let Some(cell) = light.cell else { return false };
        let source = self.world_from_camera * light.laser.source_in_camera;
        let way = point_in_world - source;
        let met = self.lit.cast(cell, &source, &Unit::new_normalize(way), f64::INFINITY);
        // Nothing met: the point is on the rim of an open end, where rounding decides.
        met.is_none_or(|met| met.distance_m > way.norm() - SAME_M)
    }
}

/// Where `off` crosses zero between `from` and `to`, below zero at `from` or not as `below` says. None where it jumps across.
fn bisect(mut from: f64, mut to: f64, below: bool, off: &dyn Fn(f64) -> Option<f64>) -> Option<f64> {
    /// A pixel halved so often is rounding.
    const HALVINGS: usize = 48;
    /// On a surface, the distance from the laser's plane is then below this, in metres: 1e-13 px of some metres a pixel.
    const ZERO_M: f64 = 1e-9;
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(from, to);
        if (off(middle)? < 0.0) == below { from = middle } else { to = middle }
    }
    let at = f64::midpoint(from, to);
    (off(at)?.abs() < ZERO_M).then_some(at)
}
