//! What a frame shows, before any light is computed: visible pieces of sheets, and strips where a laser's plane meets them.
//!
//! Everything is exact polygons in double precision, in the camera's frame, so that the image does not depend on how far from
//! the world's origin the robot is. Both renderers draw from it. In the order in which it is made:
//!
//! - `standpoint`: whether a camera can be where it is;
//! - [`region`]: pieces of sheets that the camera sees, their spangle and seams; open ends;
//! - `sightings`: pieces of sheets that the lasers light, seen or not;
//! - `strips`: where the two meet, and `shadow` and `gaps`: what bodies take away from that;
//! - `ghosts`: stripes by way of a mirror;
//! - [`glow_patch`]: light that varies slowly, on nodes; of ghosts it is `wide_ghosts`.

use std::ops::Range;

use ductloop_duct::cell::CellId;
use ductloop_nav::rig::Rig;
use nalgebra::{Point3, Vector3};

use crate::Transform;
use crate::band::BandPoint;
use crate::beam::{Beam, Met};
use crate::coverage::Edge;
use crate::glow::{Glow, GlowScene};
use crate::lens::Projection;
use crate::light::{RANGE_M, laser_strength};
use crate::optics::Optics;
use crate::renderer::{MAX_LASERS, RenderError};
use crate::scenery::{Scenery, Sheet, SheetId};
use crate::strip::{Blur, Strip};

mod gaps;
mod ghost_parts;
mod ghosts;
pub mod glow_patch;
pub mod region;
mod shadow;
pub(crate) mod sightings;
pub(crate) mod slit;
mod standpoint;
mod strips;
mod wide_ghosts;

pub use glow_patch::{GLOW_SPACING_PX, GlowPatch};
pub(crate) use region::inverse_depth;
pub use region::{Region, Seam, Texture};
pub use standpoint::{CLEAR_M, Obstacle, clear_cell};

use gaps::Gaps;
use ghosts::Ghosts;
use glow_patch::NodeLattice;
use shadow::Shadows;
use sightings::{Apex, Sightings};
use slit::Slit;
use wide_ghosts::WideGhosts;

/// Pixels about the image in which geometry is still made, so that what lies just outside spreads into it.
pub const MARGIN_PX: f64 = 8.0;

/// The same with a lens that may be out of focus.
pub const DEFOCUS_MARGIN_PX: f64 = 48.0;

/// One frame's geometry. Kept from frame to frame for its memory.
#[derive(Debug)]
pub struct FrameGeometry {
    /// Visible pieces of sheets.
    pub regions: Vec<Region>,
    /// Corners of the regions.
    pub corners: Vec<Point3<f64>>,
    /// Lit pieces of visible sheets, and ghosts of such.
    pub strips: Vec<Strip>,
    /// Edges of strips and holes.
    pub edges: Vec<Edge>,
    /// Convex shadows and silhouettes, each as edges.
    pub holes: Vec<Range<usize>>,
    /// Where the strips are in the image.
    pub band: Vec<BandPoint>,
    /// Seams of regions.
    pub seams: Vec<Seam>,
    /// Open ends that the camera sees lit by daylight, as outlines in `corners`; none in a dark room.
    pub grilles: Vec<Range<usize>>,
    /// Light on the nodes of the regions' glow, in DN at nominal exposure, reflectance and the lens' cos^4 included: daylight,
    /// the bounce of the lasers' light, and ghosts too blurred to need every pixel.
    pub glow: Vec<f32>,
    /// What the lasers light, `by` the laser; with those of no power left out.
    pub(crate) lit: Sightings,
    pub(crate) slits: Vec<Slit>,
    /// P of the slits' formula, in DN m^2: see [`crate::light`].
    pub(crate) strength: f64,
    pub(crate) nodes: NodeLattice,
    shadows_on: bool,
    ghosts_on: bool,
    daylight_on: bool,
    /// Sheets by number, and where their regions are.
    by_sheet: Vec<(SheetId, usize)>,
    /// The same of what is lit; filled only for ghosts.
    lit_by_sheet: Vec<(SheetId, usize)>,
    /// Bodies of which the camera sees a face.
    seen_bodies: Vec<usize>,
    frustum: [Vector3<f64>; 4],
    projection: Projection,
    blur: Blur,
    pub(crate) beam: Beam,
    shadows: Shadows,
    gaps: Gaps,
    ghosts: Ghosts,
    wide_ghosts: WideGhosts,
    slow_light: Option<Glow>,
    points: Vec<Point3<f64>>,
    spare: Vec<Point3<f64>>,
    camera_cell: CellId,
}

/// Poses of the camera at the beginning, in the middle and at the end of an exposure, or of a part of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    /// Beginning.
    pub world_from_first: Transform,
    /// Middle.
    pub world_from_camera: Transform,
    /// End.
    pub world_from_last: Transform,
}

impl Sweep {
    /// A camera that does not move.
    pub fn still(world_from_camera: Transform) -> Self {
        Self { world_from_first: world_from_camera, world_from_camera, world_from_last: world_from_camera }
    }
}

/// What all parts of a frame's geometry are made from.
struct Frame<'a> {
    scenery: &'a Scenery,
    camera_from_world: Transform,
    /// From the camera's frame in the middle of the exposure to those of its beginning and its end; none where it stands still.
    ends_from_camera: Option<[Transform; 2]>,
    laser_power: &'a [f64; MAX_LASERS],
}

impl<'a> Frame<'a> {
    fn new(scenery: &'a Scenery, sweep: &Sweep, laser_power: &'a [f64; MAX_LASERS]) -> Self {
        let then = |world_from_then: &Transform| world_from_then.inverse() * sweep.world_from_camera;
        let moves = sweep.world_from_first != sweep.world_from_last;
        Self {
            scenery,
            camera_from_world: sweep.world_from_camera.inverse(),
            ends_from_camera: moves.then(|| [then(&sweep.world_from_first), then(&sweep.world_from_last)]),
            laser_power,
        }
    }
}

impl FrameGeometry {
    /// For what `rig` sees of `scenery`.
    ///
    /// # Errors
    /// [`RenderError::Distortion`] where the lens folds the image.
    pub fn new(rig: &Rig, optics: &Optics) -> Result<Self, RenderError> {
        let margin_px = if optics.lens.aperture_m > 0.0 { DEFOCUS_MARGIN_PX } else { MARGIN_PX };
        let projection = Projection::new(&rig.camera, margin_px)?;
        let blur = Blur::new(&optics.lens, rig.camera.focal_px);
        Ok(Self {
            regions: Vec::new(),
            corners: Vec::new(),
            strips: Vec::new(),
            edges: Vec::new(),
            holes: Vec::new(),
            band: Vec::new(),
            seams: Vec::new(),
            grilles: Vec::new(),
            glow: Vec::new(),
            lit: Sightings::default(),
            slits: (0..rig.lasers.len()).map(|index| Slit::new(rig, index, optics)).collect(),
            strength: laser_strength(optics, &rig.line),
            nodes: NodeLattice::new(&projection, &blur, margin_px),
            shadows_on: optics.shadows,
            ghosts_on: optics.ghosts,
            daylight_on: optics.ambient_dn > 0.0,
            by_sheet: Vec::new(),
            lit_by_sheet: Vec::new(),
            seen_bodies: Vec::new(),
            frustum: frustum(&projection, margin_px),
            slow_light: Glow::new(rig, optics, &projection, &blur),
            projection,
            blur,
            beam: Beam::default(),
            shadows: Shadows::default(),
            gaps: Gaps::default(),
            ghosts: Ghosts::default(),
            wide_ghosts: WideGhosts::default(),
            points: Vec::new(),
            spare: Vec::new(),
            camera_cell: 0,
        })
    }

    /// The lens.
    pub fn blur(&self) -> &Blur {
        &self.blur
    }

    /// Pixels and rays.
    pub fn projection(&self) -> &Projection {
        &self.projection
    }

    /// Makes the frame's geometry, with the lasers at these powers (shares of nominal).
    ///
    /// # Errors
    /// [`RenderError::OutsideNetwork`] and [`RenderError::AgainstMetal`], where [`clear_cell`] finds no place for the camera.
    pub fn build(&mut self, scenery: &Scenery, sweep: &Sweep, laser_power: &[f64; MAX_LASERS]) -> Result<(), RenderError> {
        let pose = &sweep.world_from_camera;
        let position = Point3::from(pose.translation.vector);
        self.camera_cell =
            clear_cell(scenery, &position, self.camera_cell).map_err(|obstacle| RenderError::standpoint(obstacle, pose))?;
        let frame = Frame::new(scenery, sweep, laser_power);
        self.clear();
        self.look(&frame);
        self.light(&frame, &sweep.world_from_camera);
        for lit in 0..self.lit.list.len() {
            self.add_strips(&frame, lit);
        }
        if self.ghosts_on {
            self.add_ghosts(&frame);
        }
        self.add_glow(&frame);
        Ok(())
    }

    fn clear(&mut self) {
        self.regions.clear();
        self.corners.clear();
        self.strips.clear();
        self.edges.clear();
        self.holes.clear();
        self.band.clear();
        self.seams.clear();
        self.grilles.clear();
        self.glow.clear();
        self.lit.clear();
        self.by_sheet.clear();
        self.seen_bodies.clear();
        self.wide_ghosts.clear();
    }

    /// Finds what the camera sees.
    fn look(&mut self, frame: &Frame) {
        let Frame { scenery, camera_from_world, .. } = frame;
        let (regions, corners, seams) = (&mut self.regions, &mut self.corners, &mut self.seams);
        let (seen_bodies, grilles, daylight) = (&mut self.seen_bodies, &mut self.grilles, self.daylight_on);
        self.beam.trace_to_ends(scenery, camera_from_world, self.camera_cell, &self.frustum, RANGE_M, &mut |met| {
            let first_corner = corners.len();
            let sight = match met {
                Met::Sheet(sight) => sight,
                Met::End(outline) => {
                    if daylight {
                        corners.extend_from_slice(outline);
                        grilles.push(first_corner..corners.len());
                    }
                    return;
                }
            };
            corners.extend_from_slice(sight.outline);
            let Sheet { id: sheet, surface, body, cell, plane, .. } = *sight.sheet;
            let (plane, look) = (plane.transformed(camera_from_world), scenery.look(sight.sheet));
            let first_seam = seams.len();
            match body {
                // All faces of a body follow one another.
                Some(body) if seen_bodies.last() != Some(&body) => seen_bodies.push(body),
                Some(_) => {}
                None => region::add_seams(&scenery.rooms[cell], look, &plane, sight.outline, frame, seams),
            }
            regions.push(Region {
                sheet,
                surface,
                body,
                cell,
                plane,
                outline: first_corner..corners.len(),
                seams: first_seam..seams.len(),
                texture: Texture::of(sight.sheet, look, &plane, sight.outline, frame),
                glow: None,
            });
        });
        self.by_sheet.extend(self.regions.iter().enumerate().map(|(index, region)| (region.sheet, index)));
        self.by_sheet.sort_unstable();
        // A cell may have been seen along two ways.
        self.seen_bodies.sort_unstable();
        self.seen_bodies.dedup();
    }

    /// Finds what the lasers light.
    fn light(&mut self, frame: &Frame, world_from_camera: &Transform) {
        for (laser, slit) in self.slits.iter().enumerate() {
            let source_in_world = world_from_camera * Point3::from(slit.source);
            // A source outside the duct lights nothing in it.
            if frame.laser_power[laser] > 0.0
                && let Some(cell) = frame.scenery.cell_at(&source_in_world, self.camera_cell)
            {
                let from = Apex { point: slit.source, cell, bounds: &slit.bounds, range_m: RANGE_M, wanted: None };
                self.lit.add(&mut self.beam, frame.scenery, &frame.camera_from_world, &from, laser);
            }
        }
    }

    /// Gives the regions that have slow light their nodes, and fills these.
    fn add_glow(&mut self, frame: &Frame) {
        for (index, region) in self.regions.iter_mut().enumerate() {
            if self.slow_light.is_some() || self.wide_ghosts.light(index) {
                let outline = &self.corners[region.outline.clone()];
                region.glow = self.nodes.patch(outline, &self.projection, self.glow.len());
                self.glow.resize(self.glow.len() + region.glow.map_or(0, |patch| patch.nodes()), 0.0);
            }
        }
        if let Some(slow_light) = &mut self.slow_light {
            let scene = GlowScene {
                scenery: frame.scenery,
                camera_from_world: &frame.camera_from_world,
                cell: self.camera_cell,
                regions: &self.regions,
                corners: &self.corners,
                laser_power: frame.laser_power,
            };
            slow_light.gather(&scene, &mut self.glow);
        }
        self.wide_ghosts.add_to(&self.regions, &self.nodes, &self.blur, &mut self.glow);
    }
}

/// Outward normals of four planes through the camera's centre that hold everything seen within a margin of the image.
fn frustum(projection: &Projection, margin_px: f64) -> [Vector3<f64>; 4] {
    let camera = &projection.camera;
    let last = [camera.width_px, camera.height_px].map(|n| n as f64 - 1.0 + margin_px);
    // A distorting lens bends the image's border: the extreme rays along it count.
    const STEPS: usize = 64;
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    for i in 0..=STEPS {
        let along = |axis: usize| -margin_px + (last[axis] + margin_px) * i as f64 / STEPS as f64;
        for pixel in [[along(0), -margin_px], [along(0), last[1]], [-margin_px, along(1)], [last[0], along(1)]] {
            let ray = projection.ray(pixel);
            for axis in 0..2 {
                low[axis] = low[axis].min(ray[axis]);
                high[axis] = high[axis].max(ray[axis]);
            }
        }
    }
    [
        Vector3::new(-1.0, 0.0, low[0]),
        Vector3::new(1.0, 0.0, -high[0]),
        Vector3::new(0.0, -1.0, low[1]),
        Vector3::new(0.0, 1.0, -high[1]),
    ]
}
