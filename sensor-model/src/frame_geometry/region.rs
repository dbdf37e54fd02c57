//! Visible pieces of sheets, with what is painted on them: spangle and the dark joints between sheets.

use std::ops::Range;

use ductloop_duct::cell::{CellId, Plane, SurfaceId};
use nalgebra::{Point3, Vector3};

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
    /// The sheet's own coordinates (s, t), counted in spangles: at a ray r they are `texture[i] . r / (n . r)`. None without spangle.
    pub texture: Option<[Vector3<f64>; 2]>,
    /// Light that varies slowly over it; none where there is no such light.
    pub glow: Option<GlowPatch>,
}

/// A dark joint between two sheets: a gap of a certain width about a plane across the duct.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seam {
    /// As [`crate::strip::Strip::ridge`], of the joint's plane.
    pub ridge: Vector3<f64>,
    /// Width of the gap, in metres.
    pub width_m: f64,
}

/// The line g = o l - L n that the plane l . X = L draws on the sheet n . X = o: see [`crate::strip`].
pub(super) fn ridge(sheet: &Plane, across: &Plane) -> Vector3<f64> {
    across.normal.into_inner() * sheet.offset_m - sheet.normal.into_inner() * across.offset_m
}

/// Coordinates on a sheet that stay with it while the camera moves, counted in spangles from its first corner (so that they are small
/// wherever in the world it is): s runs level on walls and across the duct's x on floor and ceiling, t square to it.
pub(super) fn texture(sheet: &Sheet, look: &Look, plane: &Plane, camera_from_world: &Transform) -> Option<[Vector3<f64>; 2]> {
    if look.spangle == 0.0 {
        return None;
    }
    let normal = sheet.plane.normal.into_inner();
    // On a wall z x n is level; on a floor any axis does.
    let level = if normal.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() };
    let s = level.cross(&normal).normalize();
    let origin = camera_from_world * sheet.outline[0];
    Some([s, normal.cross(&s)].map(|axis| {
        let axis = camera_from_world.rotation * axis;
        // axis . (X - origin) with X = r o / (n . r).
        (axis * plane.offset_m - plane.normal.into_inner() * axis.dot(&origin.coords)) / look.spangle_m
    }))
}

/// Appends the seams of a piece of a wall with this outline. A joint is wherever one cell passes into the next; bodies have none.
pub(super) fn add_seams(
    room: &Room,
    look: &Look,
    plane: &Plane,
    outline: &[Point3<f64>],
    camera_from_world: &Transform,
    seams: &mut Vec<Seam>,
) {
    /// Cosine beyond which a sheet counts as lying in the joint's own plane: it is seen from the front, the joint is behind it.
    const IN_JOINT: f64 = 0.999;
    if look.seam_m == 0.0 {
        return;
    }
    for opening in &room.openings {
        let joint = opening.plane.transformed(camera_from_world);
        // A piece reaches the joint if it comes as near as the gap is wide; half the gap is on its side.
        let reaches = outline.iter().any(|corner| joint.distance(corner).abs() <= look.seam_m);
        if reaches && joint.normal.dot(&plane.normal).abs() < IN_JOINT {
            seams.push(Seam { ridge: ridge(plane, &joint), width_m: look.seam_m });
        }
    }
}
