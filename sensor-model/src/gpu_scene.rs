//! What the graphics device draws in a frame, in the camera's frame: visible sheets, lit strips of them, bodies in the way.
//!
//! All geometry is done here in double precision, in the camera's frame, and only then rounded to single: the image does not
//! depend on how far from the world's origin the robot is.

use std::ops::Range;

use ductloop_duct::cell::{CellId, Plane};
use ductloop_nav::rig::{Camera, LineWidth, Rig};
use nalgebra::{Point3, Translation3, Vector3};

use crate::Transform;
use crate::beam::{Beam, Sight, clip_top};
use crate::light::{CUT_SIGMAS, FAN_FADE_RAD, FWHM_PER_SIGMA, Fan, PSF_RADIUS, RANGE_M};
use crate::optics::Optics;
use crate::scenery::{Body, Scenery};

/// A corner of a triangle. Everything but the position is the same at all corners.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Vertex {
    pub(crate) position_m: [f32; 3],
    pub(crate) albedo: f32,
    /// Normal and offset of the sheet's plane; the offset is positive, since the camera sees the sheet.
    pub(crate) plane: [f32; 4],
    /// First and number of the casters that may shadow the strip.
    pub(crate) casters: [u32; 2],
}

/// The part of space that a laser may light: bounds for the search, and for the strip about its plane.
#[derive(Clone, Debug)]
struct Slit {
    source: Vector3<f64>,
    /// Outward normals of the fan's two edges.
    edges: [Vector3<f64>; 2],
    /// The strip is where `sides[i] . (p - source) <= half_m`: the cut Gaussian, which widens along the fan.
    sides: [Vector3<f64>; 2],
    half_m: f64,
}

/// One frame's geometry. Kept from frame to frame for its memory.
#[derive(Debug, Default)]
pub(crate) struct Scene {
    /// First the visible sheets, then each laser's strips.
    pub(crate) vertices: Vec<Vertex>,
    /// Which of them are sheets.
    pub(crate) sheets: Range<u32>,
    /// Which of them are strips of each laser.
    pub(crate) strips: Vec<Range<u32>>,
    /// First plane and number of planes of each caster.
    pub(crate) casters: Vec<[u32; 2]>,
    /// Planes of bodies, normal and offset.
    pub(crate) planes: Vec<[f32; 4]>,
    slits: Vec<Slit>,
    frustum: [Vector3<f64>; 4],
    beam: Beam,
    points: Vec<Point3<f64>>,
    spare: Vec<Point3<f64>>,
    /// Of each body: the frame in which its planes were put last, and where.
    placed: Vec<(u64, u32)>,
    frame: u64,
    camera_cell: CellId,
}

impl Slit {
    fn new(line: &LineWidth, source: Vector3<f64>, normal: Vector3<f64>, fan: &Fan) -> Self {
        let (s, c) = libm::sincos(fan.reach_rad + FAN_FADE_RAD);
        let per_width = CUT_SIGMAS / FWHM_PER_SIGMA;
        // Within the fan, distance from the source is at most the distance along its middle over the cosine of half its angle.
        let growth = fan.along * (per_width * line.growth_rad / c);
        Self {
            source,
            edges: [fan.across * c - fan.along * s, -fan.across * c - fan.along * s],
            sides: [normal - growth, -normal - growth],
            half_m: per_width * line.width_m,
        }
    }
}

impl Scene {
    pub(crate) fn new(rig: &Rig, optics: &Optics, scenery: &Scenery) -> Self {
        let slits = rig
            .lasers
            .iter()
            .map(|laser| {
                Slit::new(
                    &rig.line,
                    laser.source_in_camera.coords,
                    laser.normal_in_camera.into_inner(),
                    &Fan::of(laser, optics.fan_profile),
                )
            })
            .collect();
        Self {
            slits,
            frustum: frustum(&rig.camera),
            placed: vec![(0, 0); scenery.bodies.len()],
            strips: vec![0..0; rig.lasers.len()],
            ..Self::default()
        }
    }

    /// Makes the frame's geometry; `lit` says which lasers are on. Returns false when the camera is outside the network.
    pub(crate) fn build(&mut self, scenery: &Scenery, world_from_camera: &Transform, lit: impl Fn(usize) -> bool) -> bool {
        let position = Point3::from(world_from_camera.translation.vector);
        let Some(cell) = scenery.cell_at(&position, self.camera_cell) else { return false };
        self.camera_cell = cell;
        self.frame += 1;
        let camera_from_world = world_from_camera.inverse();
        self.vertices.clear();
        self.casters.clear();
        self.planes.clear();

        // Sheets are drawn whole, so that neighbours share their corners to the bit and no pixel falls between them.
        let vertices = &mut self.vertices;
        self.beam.trace(scenery, &camera_from_world, cell, &self.frustum, RANGE_M, &mut |sight| {
            let plane = sight.sheet.plane.transformed(&camera_from_world);
            fan_out(
                vertices,
                sight.sheet.outline.iter().map(|p| camera_from_world * p),
                &plane,
                scenery.look(sight.sheet).albedo,
                [0, 0],
            );
        });
        self.sheets = 0..self.vertices.len() as u32;

        let mut beam = std::mem::take(&mut self.beam);
        for index in 0..self.slits.len() {
            let start = self.vertices.len() as u32;
            let slit = self.slits[index].clone();
            let source_in_world = world_from_camera * Point3::from(slit.source);
            // A source outside the duct lights nothing in it.
            if lit(index)
                && let Some(source_cell) = scenery.cell_at(&source_in_world, cell)
            {
                let source_from_world = Translation3::from(-slit.source) * camera_from_world;
                beam.trace(scenery, &source_from_world, source_cell, &slit.edges, RANGE_M, &mut |sight| {
                    self.add_strip(scenery, &slit, &camera_from_world, sight);
                });
            }
            self.strips[index] = start..self.vertices.len() as u32;
        }
        self.beam = beam;
        true
    }

    /// Adds the part of a lit sheet that is near the slit's plane; `sight` is in the camera's axes, seen from the source.
    fn add_strip(&mut self, scenery: &Scenery, slit: &Slit, camera_from_world: &Transform, sight: &Sight) {
        let plane = sight.sheet.plane.transformed(camera_from_world);
        if plane.offset_m <= 0.0 {
            return;
        }
        self.points.clear();
        self.points.extend_from_slice(sight.outline);
        for side in &slit.sides {
            clip_top(&mut self.points, 0, &mut self.spare, |p| side.dot(&p.coords) - slit.half_m);
        }
        if self.points.len() < 3 {
            return;
        }
        for point in &mut self.points {
            *point += slit.source;
        }
        let first_caster = self.casters.len() as u32;
        for id in sight.path.iter().flat_map(|cell| &scenery.rooms[*cell].bodies) {
            let body = &scenery.bodies[*id];
            if may_shadow(body, camera_from_world, &slit.source, &self.points, &plane) {
                let first_plane = self.place(*id, body, camera_from_world);
                self.casters.push([first_plane, body.planes.len() as u32]);
            }
        }
        let casters = [first_caster, self.casters.len() as u32 - first_caster];
        fan_out(&mut self.vertices, self.points.iter().copied(), &plane, scenery.look(sight.sheet).albedo, casters);
    }

    /// Where a body's planes are in `self.planes`; they are put there when it is asked for first in a frame.
    fn place(&mut self, id: usize, body: &Body, camera_from_world: &Transform) -> u32 {
        if self.placed[id].0 != self.frame {
            self.placed[id] = (self.frame, self.planes.len() as u32);
            self.planes.extend(body.planes.iter().map(|plane| packed(&plane.transformed(camera_from_world))));
        }
        self.placed[id].1
    }
}

/// Outward normals of the planes through the camera's centre and the image's borders, widened by the point spread.
fn frustum(camera: &Camera) -> [Vector3<f64>; 4] {
    let margin_px = PSF_RADIUS as f64 + 0.5;
    let slope = |pixel: f64, axis: usize| (pixel - camera.centre_px[axis]) / camera.focal_px[axis];
    let last = [camera.width_px, camera.height_px].map(|n| n as f64 - 1.0 + margin_px);
    [
        Vector3::new(-1.0, 0.0, slope(-margin_px, 0)),
        Vector3::new(1.0, 0.0, -slope(last[0], 0)),
        Vector3::new(0.0, -1.0, slope(-margin_px, 1)),
        Vector3::new(0.0, 1.0, -slope(last[1], 1)),
    ]
}

/// Whether a body can shadow any of a strip: not when it is wholly beyond the strip's plane, or wholly beside the pyramid from
/// the source to the strip.
fn may_shadow(
    body: &Body,
    camera_from_world: &Transform,
    source: &Vector3<f64>,
    strip: &[Point3<f64>],
    strip_plane: &Plane,
) -> bool {
    /// A body's own face is no nearer to the source than itself: this much of it, in metres, is rounding.
    const ROUNDING_M: f64 = 1e-9;
    let all = |outside: &dyn Fn(&Point3<f64>) -> bool| body.corners.iter().all(|c| outside(&(camera_from_world * c)));
    if all(&|corner| strip_plane.distance(corner) >= -ROUNDING_M) {
        return false;
    }
    let middle: Vector3<f64> = strip.iter().map(|p| p.coords - source).sum();
    let beside = |i: usize| {
        let (a, b) = (strip[i].coords - source, strip[(i + 1) % strip.len()].coords - source);
        let normal = a.cross(&b);
        let outward = if normal.dot(&middle) > 0.0 { -normal } else { normal };
        all(&|corner| outward.dot(&(corner.coords - source)) > 0.0)
    };
    !(0..strip.len()).any(beside)
}

fn packed(plane: &Plane) -> [f32; 4] {
    let n = plane.normal;
    [n.x as f32, n.y as f32, n.z as f32, plane.offset_m as f32]
}

/// Adds a convex polygon as triangles about its first corner.
fn fan_out(
    vertices: &mut Vec<Vertex>,
    mut outline: impl Iterator<Item = Point3<f64>>,
    plane: &Plane,
    albedo: f64,
    casters: [u32; 2],
) {
    let vertex = |point: Point3<f64>| Vertex {
        position_m: [point.x as f32, point.y as f32, point.z as f32],
        albedo: albedo as f32,
        plane: packed(plane),
        casters,
    };
    let (Some(first), Some(second)) = (outline.next().map(vertex), outline.next().map(vertex)) else { return };
    let mut last = second;
    for corner in outline.map(vertex) {
        vertices.extend([first, last, corner]);
        last = corner;
    }
}
