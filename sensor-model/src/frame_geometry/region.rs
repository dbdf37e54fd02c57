//! Visible pieces of sheets, with what is painted on them: spangle and the dark joints between sheets.

use std::ops::Range;

use ductloop_duct::cell::{CellId, Plane, SurfaceId};
use nalgebra::{Point3, Vector2, Vector3};

use super::Frame;
use super::glow_patch::GlowPatch;
use crate::Transform;
use crate::scenery::{Room, Sheet, SheetId};
use crate::surface::Look;

/// n / o of the plane of a polygon in the camera's frame: its product with a ray (x, y, 1) is the inverse depth there. None of one that
/// is seen edge on.
pub(crate) fn inverse_depth(corners: &[Point3<f64>]) -> Option<Vector3<f64>> {
    let next = |i: usize| corners[(i + 1) % corners.len()].coords;
    let normal: Vector3<f64> = corners.iter().enumerate().map(|(i, corner)| corner.coords.cross(&next(i))).sum();
    let plane = normal / normal.dot(&corners.first()?.coords);
    plane.iter().all(|v| v.is_finite()).then_some(plane)
}

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
    /// Its outline, in [`super::FrameGeometry::corners`].
    pub outline: Range<usize>,
    /// The dark joints across its sheet, in [`super::FrameGeometry::seams`].
    pub seams: Range<usize>,
    /// Where its spangles are; none without spangle.
    pub texture: Option<Texture>,
    /// Light that varies slowly over it; none where there is no such light.
    pub glow: Option<GlowPatch>,
}

impl Region {
    /// Whether another region shows the same surface in the same plane, so that no edge is seen between them.
    pub(crate) fn goes_on_in(&self, other: &Self) -> bool {
        /// Planes whose offsets and directions differ by less are one, in metres.
        const SAME_M: f64 = 1e-7;
        self.surface == other.surface
            && (self.plane.offset_m - other.plane.offset_m).abs() < SAME_M
            && (self.plane.normal.into_inner() - other.plane.normal.into_inner()).norm() < SAME_M
    }
}

/// A sheet's own coordinates (s, t), counted in spangles from its first corner (so that they are small wherever in the world it is): s runs
/// level on walls and across the duct's x on floor and ceiling, t square to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Texture {
    /// At a ray r, (s, t) are `axes[i] . r / (n . r)`.
    pub axes: [Vector3<f64>; 2],
    /// What is added to `axes` from the exposure's beginning to its end.
    pub sweep: [Vector3<f64>; 2],
    /// What is added to n.
    pub turn: Vector3<f64>,
    /// Pairs of places along a pixel's way over the sheet that stand for the whole of it, those of Gauss' rule in as many equal
    /// parts; 0 where the middle alone does.
    pub pairs: u32,
}

/// A dark joint between two sheets: a gap of a certain width about a plane across the duct.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seam {
    /// As [`crate::strip::Strip::ridge`], of the joint's plane.
    pub ridge: Vector3<f64>,
    /// As [`crate::strip::Strip::sweep`].
    pub sweep: Vector3<f64>,
    /// Width of the gap, in metres.
    pub width_m: f64,
}

/// The line g = o l - L n that the plane l . X = L draws on the sheet n . X = o: see [`crate::strip`].
pub(super) fn ridge(sheet: &Plane, across: &Plane) -> Vector3<f64> {
    across.normal.into_inner() * sheet.offset_m - sheet.normal.into_inner() * across.offset_m
}

impl Texture {
    /// Most pairs of places; a way of more than ten spangles is blurred less than it should be.
    pub const PAIRS_MAX: u32 = 4;

    /// Of a piece of a sheet with this plane and outline in the camera's frame.
    pub(super) fn of(sheet: &Sheet, look: &Look, plane: &Plane, outline: &[Point3<f64>], frame: &Frame) -> Option<Self> {
        /// A way, in spangles, that changes nothing: the noise's second derivative is some 10, and 10 * 0.1^2 / 24 of a contrast of
        /// 0.15 is 6e-4.
        const STILL: f64 = 0.1;
        if look.spangle == 0.0 {
            return None;
        }
        let normal = sheet.plane.normal.into_inner();
        // On a wall z x n is level; on a floor any axis does.
        let level = if normal.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() };
        let s = level.cross(&normal).normalize();
        let in_world = [s, normal.cross(&s)];
        // Of a camera's frame at some time: axis . (X - origin) with X = r o / (n . r).
        let axes = |from_world: &Transform| {
            let plane = sheet.plane.transformed(from_world);
            let origin = from_world * sheet.outline[0];
            in_world.map(|axis| {
                let axis = from_world.rotation * axis;
                (axis * plane.offset_m - plane.normal.into_inner() * axis.dot(&origin.coords)) / look.spangle_m
            })
        };
        let now = axes(&frame.camera_from_world);
        let Some(ends) = &frame.ends_from_camera else {
            return Some(Self { axes: now, sweep: [Vector3::zeros(); 2], turn: Vector3::zeros(), pairs: 0 });
        };
        let [first, last] = ends.map(|end| axes(&(end * frame.camera_from_world)));
        let [turned_first, turned_last] = ends.map(|end| end.rotation * plane.normal.into_inner());
        let mut texture =
            Self { axes: now, sweep: [0, 1].map(|i| last[i] - first[i]), turn: turned_last - turned_first, pairs: 0 };
        let farthest = outline.iter().map(|corner| texture.way(&corner.coords, plane).norm()).fold(0.0, f64::max);
        if farthest > STILL {
            texture.pairs = ((2.0 * farthest).ceil() as u32).min(Self::PAIRS_MAX);
        }
        Some(texture)
    }

    /// (s, t) at a ray.
    pub fn at(&self, ray: &Vector3<f64>, plane: &Plane) -> Vector2<f64> {
        Vector2::from(self.axes.map(|axis| axis.dot(ray))) / plane.normal.dot(ray)
    }

    /// The way over the sheet from the exposure's beginning to its end, in spangles, at a ray.
    pub fn way(&self, ray: &Vector3<f64>, plane: &Plane) -> Vector2<f64> {
        let swept = Vector2::from(self.sweep.map(|sweep| sweep.dot(ray)));
        (swept - self.at(ray, plane) * self.turn.dot(ray)) / plane.normal.dot(ray)
    }
}

/// Appends the seams of a piece of a wall with this outline. A joint is wherever one cell passes into the next, but not a hole in a floor,
/// which is cut; bodies have none.
pub(super) fn add_seams(room: &Room, look: &Look, plane: &Plane, outline: &[Point3<f64>], frame: &Frame, seams: &mut Vec<Seam>) {
    /// Cosine beyond which a sheet counts as lying in the joint's own plane: it is seen from the front, the joint is behind it.
    const IN_JOINT: f64 = 0.999;
    /// Joints stand upright; the normal of one that does is level but for rounding.
    const UPRIGHT: f64 = 0.5;
    if look.seam_m == 0.0 {
        return;
    }
    for opening in room.openings.iter().filter(|opening| opening.plane.normal.z.abs() < UPRIGHT) {
        let joint = opening.plane.transformed(&frame.camera_from_world);
        // A piece reaches the joint if it comes as near as the gap is wide; half the gap is on its side.
        let reaches = outline.iter().any(|corner| joint.distance(corner).abs() <= look.seam_m);
        if reaches && joint.normal.dot(&plane.normal).abs() < IN_JOINT {
            let (ridge, sweep) = frame.ridge_and_sweep(|now| ridge(&plane.transformed(now), &joint.transformed(now)));
            seams.push(Seam { ridge, sweep, width_m: look.seam_m });
        }
    }
}
