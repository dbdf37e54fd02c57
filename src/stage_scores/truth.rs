//! Where the stripes truly are in the image, and on which planes they lie.
//!
//! Each laser's fan is followed ray by ray to what it meets; what the camera sees of that is a chain of pixels. On one plane the
//! image of a stripe is a straight line, but for the lens' distortion, so between neighbouring rays, about a pixel apart, it is
//! interpolated (to 1e-4 px with the rigs' lenses). Of each piece the ends are left out, by a pixel at most.
//!
//! As in [`ductloop_sensor::truth`], which looks through every pixel and is fifty times as slow, the light is a plane without
//! thickness within the fan's nominal opening. Light that walls mirror or scatter is no stripe.

use std::ops::Range;

use ductloop_duct::Transform;
use ductloop_duct::cell::SurfaceId;
use ductloop_duct::network::Network;
use ductloop_nav::perception::Wall;
use ductloop_nav::rig::Rig;
use ductloop_sensor::lens::Projection;
use ductloop_sensor::optics::FanProfile;
use ductloop_sensor::renderer::RenderError;
use nalgebra::{Point3, Unit, Vector3};

use super::station::Station;
use crate::closed_loop::RunError;
use crate::scenario::Scenario;

/// Along which side of the image a stripe's middle is stated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Scan {
    /// In a column: its row.
    Column,
    /// In a row: its column.
    Row,
}

/// A plane that light falls on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruePlane {
    /// What it is to the robot; `None` for bodies, and for walls that are none of these.
    pub wall: Option<Wall>,
    /// Unit normal in the camera frame, pointing away from the camera.
    pub normal_in_camera: Unit<Vector3<f64>>,
    /// Distance from the camera along it, in metres.
    pub camera_distance_m: f64,
    /// The normal in the base frame.
    pub normal_in_base: Unit<Vector3<f64>>,
    /// Distance from the base's origin along it, in metres.
    pub distance_m: f64,
    /// What it is made of.
    pub surface: SurfaceId,
}

/// A stripe's true middle in a column or row of the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueCentre {
    /// Whether `line` is a column or a row.
    pub scan: Scan,
    /// Number of the column or row.
    pub line: usize,
    /// The row in that column, or the column in that row, in pixels.
    pub at_px: f64,
    /// Its change from a column (row) to the next.
    pub slope: f64,
    /// Index of the laser.
    pub laser: usize,
    /// Index into [`StageTruth::planes`].
    pub plane: usize,
}

/// What a camera truly sees of the stripes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StageTruth {
    /// The planes that they lie on.
    pub planes: Vec<TruePlane>,
    /// Their middles, in columns and in rows, in the order of (scan, line).
    pub centres: Vec<TrueCentre>,
}

/// A duct and a true rig, ready to be looked at.
#[derive(Clone, Debug)]
pub struct TruthScene {
    pub(super) network: Network,
    /// The network as the lasers' light passes through it.
    pub(super) lit: Network,
    pub(super) rig: Rig,
    pub(super) profile: FanProfile,
    pub(super) projection: Projection,
}

impl TruePlane {
    /// Heading of the base relative to it, anticlockwise positive, in radians: zero where a side wall runs along the robot, and where
    /// it faces a wall ahead squarely. `None` for what shows none.
    pub fn heading_rad(&self) -> Option<f64> {
        let n = self.normal_in_base;
        match self.wall? {
            Wall::Left => Some(libm::atan2(n.x, n.y)),
            Wall::Right => Some(libm::atan2(-n.x, -n.y)),
            Wall::Ahead => Some(libm::atan2(-n.y, n.x)),
            Wall::Floor | Wall::Ceiling => None,
        }
    }
}

impl TrueCentre {
    /// The pixel (u, v).
    pub fn pixel(&self) -> [f64; 2] {
        match self.scan {
            Scan::Column => [self.line as f64, self.at_px],
            Scan::Row => [self.at_px, self.line as f64],
        }
    }

    /// Whether the stripe runs nearer to the image's rows (columns) here, so that columns (rows) are what counts it once.
    pub fn counts(&self) -> bool {
        // A stripe at exactly 45 degrees is counted in columns.
        match self.scan {
            Scan::Column => self.slope.abs() <= 1.0,
            Scan::Row => self.slope.abs() < 1.0,
        }
    }
}

impl StageTruth {
    /// Which of [`Self::centres`] are in a column or row.
    pub fn in_line(&self, scan: Scan, line: usize) -> Range<usize> {
        let key = |centre: &TrueCentre| (centre.scan, centre.line);
        let from = self.centres.partition_point(|centre| key(centre) < (scan, line));
        from..from + self.centres[from..].partition_point(|centre| key(centre) <= (scan, line))
    }

    /// The one plane that is this wall to the robot; `None` where no light falls on such a wall, or on several.
    pub fn only_plane(&self, wall: Wall) -> Option<usize> {
        let mut found = (0..self.planes.len()).filter(|index| self.planes[*index].wall == Some(wall));
        found.next().filter(|_| found.next().is_none())
    }

    /// Columns (or rows) of stripe on a plane, of all lasers.
    pub fn columns(&self, plane: usize) -> usize {
        self.centres.iter().filter(|centre| centre.plane == plane && centre.counts()).count()
    }
}

impl TruthScene {
    /// For what a scenario's true rig sees of its duct.
    ///
    /// # Errors
    /// Where the duct cannot be assembled or the lens folds the image: never for a scenario that was read.
    pub fn new(scenario: &Scenario) -> Result<Self, RunError> {
        let network = scenario.duct.network()?;
        let rig = scenario.actual_rig();
        let projection = Projection::new(&rig.camera, 1.0).map_err(RunError::Render)?;
        let mut lit = network.clone();
        if !scenario.optics.shadows {
            lit.cells.iter_mut().for_each(|cell| cell.solids.clear());
        }
        Ok(Self { network, lit, rig, profile: scenario.optics.fan_profile, projection })
    }

    /// The true rig.
    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    /// Its lens.
    pub fn projection(&self) -> &Projection {
        &self.projection
    }

    /// What is seen by the camera of a base at its pose. Lasers whose power is 0 are dark. `near` is a cell near the base.
    ///
    /// # Errors
    /// [`RenderError::OutsideNetwork`].
    pub fn of(
        &self,
        world_from_base: &Transform,
        world_from_camera: &Transform,
        near: usize,
        laser_power: &[f64],
    ) -> Result<StageTruth, RenderError> {
        let camera = Point3::from(world_from_camera.translation.vector);
        let cell = self.network.cell_at(&camera, near).ok_or_else(|| RenderError::OutsideNetwork {
            position_m: world_from_camera.translation.vector.into(),
            direction: (world_from_camera.rotation * Vector3::z()).into(),
        })?;
        let station = Station { scene: self, world_from_base, world_from_camera, camera, cell };
        let mut truth = StageTruth::default();
        for laser in 0..self.rig.lasers.len() {
            if laser_power.get(laser).is_none_or(|power| *power > 0.0) {
                station.follow(laser, &mut truth);
            }
        }
        truth.centres.sort_by(|a, b| {
            (a.scan, a.line, a.laser, a.plane).cmp(&(b.scan, b.line, b.laser, b.plane)).then(a.at_px.total_cmp(&b.at_px))
        });
        Ok(truth)
    }
}
