//! What a frame shows, before any light is computed: visible pieces of sheets, and strips where a laser's plane meets them.
//!
//! Everything is exact polygons in double precision, in the camera's frame, so that the image does not depend on how far from
//! the world's origin the robot is. Both renderers draw from it.

use std::ops::Range;

use ductloop_duct::cell::{CellId, Plane, SurfaceId};
use ductloop_nav::rig::{LineWidth, Rig};
use nalgebra::{Point3, Translation3, Vector3};

use crate::Transform;
use crate::band::{self, BandPoint};
use crate::beam::{Beam, Sight, clip_top, plane_of_edge};
use crate::coverage::Edge;
use crate::lens::Projection;
use crate::light::{CUT_SIGMAS, FAN_FADE_RAD, FWHM_PER_SIGMA, Fan, RANGE_M};
use crate::optics::Optics;
use crate::renderer::{MAX_LASERS, RenderError};
use crate::scenery::{Body, Scenery, Sheet, SheetId};
use crate::silhouette;
use crate::strip::{Blur, Strip};

/// Pixels about the image in which geometry is still made, so that what lies just outside spreads into it.
pub const MARGIN_PX: f64 = 8.0;

/// The same with a lens that may be out of focus.
pub const DEFOCUS_MARGIN_PX: f64 = 48.0;

/// A visible piece of a sheet, in the camera's frame. The regions of walls do not overlap in the image; those of bodies' faces
/// hide what is behind them.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// The sheet.
    pub sheet: SheetId,
    /// What it is made of.
    pub surface: SurfaceId,
    /// The body whose face it is.
    pub body: Option<usize>,
    /// The cell that it is in.
    pub cell: CellId,
    /// Its plane; the offset is positive.
    pub plane: Plane,
    /// Its outline, in [`FrameGeometry::corners`].
    pub outline: Range<usize>,
    /// The dark joints across its sheet, in [`FrameGeometry::seams`].
    pub seams: Range<usize>,
    /// The sheet's own coordinates (s, t), counted in spangles: at a ray r they are `texture[i] . r / (n . r)`. None without spangle.
    pub texture: Option<[Vector3<f64>; 2]>,
    /// Light that varies slowly over it; none where there is no such light.
    pub glow: Option<GlowPatch>,
}

/// A dark joint between two sheets: a gap of a certain width about a plane across the duct.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seam {
    /// As [`Strip::ridge`], of the joint's plane.
    pub ridge: Vector3<f64>,
    /// Width of the gap, in metres.
    pub width_m: f64,
}

/// Where the nodes of a region's glow are: a rectangle of nodes [`GLOW_SPACING_PX`] pixels apart, node (i, j) at pixel (16 i, 16 j), row by
/// row in [`FrameGeometry::glow`], large enough that every pixel of the region is between nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GlowPatch {
    /// Its first value.
    pub first: usize,
    /// Column i of its first node; may be negative.
    pub column: i32,
    /// Row j of its first node.
    pub row: i32,
    /// Nodes in a row.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
}

/// Distance of two nodes of the glow, in pixels; between them it is interpolated linearly in u and v.
pub const GLOW_SPACING_PX: usize = 16;

/// A laser's light before it meets anything.
#[derive(Clone, Debug)]
pub(crate) struct Slit {
    pub(crate) source: Vector3<f64>,
    pub(crate) normal: Vector3<f64>,
    pub(crate) offset_m: f64,
    pub(crate) fan: Fan,
    pub(crate) line: LineWidth,
    /// Outward normals of the fan's two edges.
    pub(crate) bounds: [Vector3<f64>; 2],
    /// The light is where `sides[i] . (p - source) <= half_m`: the cut Gaussian, which widens along the fan.
    sides: [Vector3<f64>; 2],
    half_m: f64,
}

/// One frame's geometry. Kept from frame to frame for its memory.
#[derive(Debug)]
pub struct FrameGeometry {
    /// Visible pieces of sheets.
    pub regions: Vec<Region>,
    /// Corners of the regions.
    pub corners: Vec<Point3<f64>>,
    /// Lit pieces of visible sheets.
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
    /// Light on the nodes of the regions' glow, in DN at nominal exposure, reflectance and the lens' cos^4 included: daylight, the bounce of
    /// the lasers' light, and ghosts too blurred to need every pixel.
    pub glow: Vec<f32>,
    /// Sheets by number, and where their regions are.
    by_sheet: Vec<(SheetId, usize)>,
    pub(crate) slits: Vec<Slit>,
    frustum: [Vector3<f64>; 4],
    projection: Projection,
    blur: Blur,
    pub(crate) beam: Beam,
    points: Vec<Point3<f64>>,
    spare: Vec<Point3<f64>>,
    cone: Vec<Vector3<f64>>,
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

impl Slit {
    fn new(rig: &Rig, index: usize, optics: &Optics) -> Self {
        let laser = &rig.lasers[index];
        let fan = Fan::of(laser, optics.fan_profile);
        let normal = laser.normal_in_camera.into_inner();
        let (s, c) = libm::sincos(fan.reach_rad + FAN_FADE_RAD);
        let per_width = CUT_SIGMAS / FWHM_PER_SIGMA;
        // Within the fan, distance from the source is at most the distance along its middle over the cosine of half its angle.
        let growth = fan.along * (per_width * rig.line.growth_rad / c);
        Self {
            source: laser.source_in_camera.coords,
            normal,
            offset_m: laser.offset_m,
            fan,
            line: rig.line,
            bounds: [fan.across * c - fan.along * s, -fan.across * c - fan.along * s],
            sides: [normal - growth, -normal - growth],
            half_m: per_width * rig.line.width_m,
        }
    }

    /// How far outside the slit's light a point of the camera frame is, on its worse side; not positive inside.
    fn outside(&self, point: &Point3<f64>) -> [f64; 2] {
        self.sides.map(|side| side.dot(&(point.coords - self.source)) - self.half_m)
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
            by_sheet: Vec::new(),
            slits: (0..rig.lasers.len()).map(|index| Slit::new(rig, index, optics)).collect(),
            frustum: frustum(&projection, margin_px),
            blur: Blur::new(&optics.lens, rig.camera.focal_px),
            projection,
            beam: Beam::default(),
            points: Vec::new(),
            spare: Vec::new(),
            cone: Vec::new(),
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

    /// Makes the frame's geometry, with the lasers at these powers (shares of nominal). Returns false when the camera is outside the
    /// network.
    pub fn build(&mut self, scenery: &Scenery, sweep: &Sweep, laser_power: &[f64; MAX_LASERS]) -> bool {
        let world_from_camera = &sweep.world_from_camera;
        let position = Point3::from(world_from_camera.translation.vector);
        let Some(cell) = scenery.cell_at(&position, self.camera_cell) else { return false };
        self.camera_cell = cell;
        let camera_from_world = world_from_camera.inverse();
        self.clear();
        let mut beam = std::mem::take(&mut self.beam);
        let (regions, corners) = (&mut self.regions, &mut self.corners);
        beam.trace(scenery, &camera_from_world, cell, &self.frustum, RANGE_M, &mut |sight| {
            let Sheet { id: sheet, surface, body, cell, plane, .. } = *sight.sheet;
            let outline = corners.len()..corners.len() + sight.outline.len();
            corners.extend_from_slice(sight.outline);
            let plane = plane.transformed(&camera_from_world);
            regions.push(Region { sheet, surface, body, cell, plane, outline, seams: 0..0, texture: None, glow: None });
        });
        self.by_sheet.extend(self.regions.iter().enumerate().map(|(index, region)| (region.sheet, index)));
        self.by_sheet.sort_unstable();

        for laser in 0..self.slits.len() {
            let source = self.slits[laser].source;
            let source_in_world = world_from_camera * Point3::from(source);
            // A source outside the duct lights nothing in it.
            if laser_power[laser] > 0.0
                && let Some(source_cell) = scenery.cell_at(&source_in_world, cell)
            {
                let source_from_world = Translation3::from(-source) * camera_from_world;
                let bounds = self.slits[laser].bounds;
                beam.trace(scenery, &source_from_world, source_cell, &bounds, RANGE_M, &mut |sight| {
                    self.add_strips(scenery, laser, &camera_from_world, sweep, sight);
                });
            }
        }
        self.beam = beam;
        true
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
        self.by_sheet.clear();
    }

    /// Adds the parts of a lit piece of a sheet that the camera sees; `sight` is in the camera's axes, seen from the source.
    fn add_strips(&mut self, scenery: &Scenery, laser: usize, camera_from_world: &Transform, sweep: &Sweep, sight: &Sight) {
        let first = self.by_sheet.partition_point(|(sheet, _)| *sheet < sight.sheet.id);
        let mut next = first;
        while let Some((_, region)) = self.by_sheet.get(next).filter(|(sheet, _)| *sheet == sight.sheet.id) {
            let region = *region;
            self.add_strip(scenery, laser, camera_from_world, sweep, sight, region);
            next += 1;
        }
    }

    fn add_strip(
        &mut self,
        scenery: &Scenery,
        laser: usize,
        camera_from_world: &Transform,
        sweep: &Sweep,
        sight: &Sight,
        region: usize,
    ) {
        let slit = &self.slits[laser];
        let Region { plane, outline, .. } = &self.regions[region];
        // The lit piece as far as the camera sees it.
        self.points.clear();
        self.points.extend(sight.outline.iter().map(|p| p + slit.source));
        let seen = &self.corners[outline.clone()];
        let middle: Vector3<f64> = seen.iter().map(|p| p.coords).sum();
        for (i, a) in seen.iter().enumerate() {
            let Some(normal) = plane_of_edge(a, &seen[(i + 1) % seen.len()]) else { continue };
            let outward = if normal.dot(&middle) > 0.0 { -normal } else { normal };
            clip_top(&mut self.points, 0, &mut self.spare, |p| outward.dot(&p.coords));
        }
        if self.points.len() < 3 {
            return;
        }
        let first_edge = self.edges.len();
        self.edges.extend(edges_near(&self.points, slit));
        for side in 0..2 {
            clip_top(&mut self.points, 0, &mut self.spare, |p| slit.outside(p)[side]);
        }
        let ridge = |plane: &Plane| plane.normal.into_inner() * -slit.offset_m + slit.normal * plane.offset_m;
        let then = |world_from_then: &Transform| ridge(&sight.sheet.plane.transformed(&world_from_then.inverse()));
        let still = sweep.world_from_first == sweep.world_from_last;
        let moved = if still { Vector3::zeros() } else { then(&sweep.world_from_last) - then(&sweep.world_from_first) };
        let mut strip = Strip {
            laser,
            plane: *plane,
            ridge: ridge(plane),
            sweep: moved,
            source: slit.source,
            fan: slit.fan,
            line: slit.line,
            look: *scenery.look(sight.sheet),
            mirror: None,
            edges: first_edge..self.edges.len(),
            holes: 0..0,
            band: 0..0,
        };
        let first_point = self.band.len();
        let in_view = self.points.len() >= 3
            && band::walk(&strip, &self.points, &self.projection, &self.blur, &slit.normal, &mut self.band);
        if !in_view {
            self.edges.truncate(first_edge);
            self.band.truncate(first_point);
            return;
        }
        strip.band = first_point..self.band.len();
        let first_hole = self.holes.len();
        let source = slit.source;
        for id in sight.path.iter().flat_map(|cell| &scenery.rooms[*cell].bodies) {
            self.add_shadow(&scenery.bodies[*id], camera_from_world, &source, &strip.plane);
        }
        // What stands between camera and sheet: bodies of the cells that the camera sees it through, its own body apart.
        for other in 0..self.regions.len() {
            let Region { body: Some(body), .. } = self.regions[other] else { continue };
            let seen_before = self.regions[..other].iter().any(|earlier| earlier.body == Some(body));
            if !seen_before && sight.sheet.body != Some(body) {
                self.add_shadow(&scenery.bodies[body], camera_from_world, &Vector3::zeros(), &strip.plane);
            }
        }
        strip.holes = first_hole..self.holes.len();
        self.strips.push(strip);
    }

    /// Adds the shadow that a body throws on a plane, in the light of (or seen from) `apex`, as a hole; `self.points` is the lit
    /// piece, and a body that cannot shadow it is passed over.
    fn add_shadow(&mut self, body: &Body, camera_from_world: &Transform, apex: &Vector3<f64>, plane: &Plane) {
        /// A body's own face is no nearer to the apex than itself: this much of it, in metres, is rounding.
        const ROUNDING_M: f64 = 1e-9;
        self.spare.clear();
        self.spare.extend(body.corners.iter().map(|c| camera_from_world * c));
        let beyond = |p: &Point3<f64>| plane.distance(p) >= -ROUNDING_M;
        if self.spare.iter().all(beyond) {
            return;
        }
        // Only what is on the near side of the plane throws a shadow on it.
        let corners = self.spare.len();
        for [a, b] in &body.edges {
            let (from, to) = (self.spare[*a], self.spare[*b]);
            let (d_from, d_to) = (plane.distance(&from), plane.distance(&to));
            if d_from * d_to < 0.0 {
                self.spare.push(from + (to - from) * (d_from / (d_from - d_to)));
            }
        }
        let mut index = 0;
        self.spare.retain(|p| {
            index += 1;
            index > corners || !beyond(p)
        });
        // Beside the pyramid from the apex to the lit piece?
        let middle: Vector3<f64> = self.points.iter().map(|p| p.coords - apex).sum();
        let beside = (0..self.points.len()).any(|i| {
            let (a, b) = (self.points[i].coords - apex, self.points[(i + 1) % self.points.len()].coords - apex);
            let normal = a.cross(&b);
            let outward = if normal.dot(&middle) > 0.0 { -normal } else { normal };
            self.spare.iter().all(|corner| outward.dot(&(corner.coords - apex)) > 0.0)
        });
        if beside {
            return;
        }
        self.cone.clear();
        silhouette::cone(apex, &self.spare, &mut self.cone);
        if self.cone.len() < 3 {
            return;
        }
        let first = self.edges.len();
        let normal = plane.normal.into_inner();
        // The trace on the plane of each plane through the apex, as a line in the image.
        self.edges.extend(self.cone.iter().filter_map(|q| (q * plane.offset_m - normal * q.dot(apex)).try_normalize(1e-14)));
        self.holes.push(first..self.edges.len());
    }
}

/// The edges of a piece that come into the slit's light, as lines in the image with the piece inside.
fn edges_near<'a>(piece: &'a [Point3<f64>], slit: &'a Slit) -> impl Iterator<Item = Edge> + 'a {
    let middle: Vector3<f64> = piece.iter().map(|p| p.coords).sum();
    (0..piece.len()).filter_map(move |i| {
        let (a, b) = (piece[i], piece[(i + 1) % piece.len()]);
        let (off_a, off_b) = (slit.outside(&a), slit.outside(&b));
        // The part of the edge, as shares of its length, that is within both sides.
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for (a, b) in off_a.into_iter().zip(off_b) {
            let crossing = a / (a - b);
            match (a > 0.0, b > 0.0) {
                (true, true) => return None,
                (true, false) => from = from.max(crossing),
                (false, true) => to = to.min(crossing),
                (false, false) => {}
            }
        }
        let line = plane_of_edge(&a, &b)?;
        (from <= to).then(|| if line.dot(&middle) > 0.0 { line } else { -line })
    })
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
