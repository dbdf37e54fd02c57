//! What a point of the camera's frame sees or lights, kept: the answers of a beam's search.

use std::ops::Range;

use ductloop_duct::cell::{CellId, Plane, SurfaceId};
use nalgebra::{Point3, Translation3, Vector3};

use crate::Transform;
use crate::beam::Beam;
use crate::scenery::{Scenery, SheetId};

/// A part of a sheet that a point sees.
#[derive(Clone, Debug)]
pub(crate) struct Sighting {
    /// What sees or lights it, as its finder counts: a laser.
    pub(crate) by: usize,
    pub(crate) sheet: SheetId,
    pub(crate) cell: CellId,
    pub(crate) surface: SurfaceId,
    pub(crate) body: Option<usize>,
    /// [`crate::scenery::Sheet::breadth_m`].
    pub(crate) breadth_m: f64,
    /// The sheet's plane, in the camera's frame.
    pub(crate) plane: Plane,
    /// Outline of the part, in [`Sightings::corners`].
    pub(crate) outline: Range<usize>,
    /// Cells from the point's own to the sheet's, in [`Sightings::paths`].
    pub(crate) path: Range<usize>,
}

/// A list of sightings with what they refer to.
#[derive(Debug, Default)]
pub(crate) struct Sightings {
    pub(crate) list: Vec<Sighting>,
    /// In the camera's frame.
    pub(crate) corners: Vec<Point3<f64>>,
    pub(crate) paths: Vec<CellId>,
}

/// A point that looks.
#[derive(Debug)]
pub(crate) struct Apex<'a> {
    /// Where, in the camera's frame.
    pub(crate) point: Vector3<f64>,
    /// The cell that it looks from: its own, or that of the mirror that it is behind.
    pub(crate) cell: CellId,
    /// Outward normals of the planes through it that it looks within.
    pub(crate) bounds: &'a [Vector3<f64>],
    /// See [`Beam::trace`].
    pub(crate) range_m: f64,
    /// Only these sheets are of interest (by number, in order); all are where there is no list.
    pub(crate) wanted: Option<&'a [(SheetId, usize)]>,
}

impl Sightings {
    pub(crate) fn clear(&mut self) {
        self.list.clear();
        self.corners.clear();
        self.paths.clear();
    }

    /// The outline of a sighting.
    pub(crate) fn outline(&self, sighting: &Sighting) -> &[Point3<f64>] {
        &self.corners[sighting.outline.clone()]
    }

    /// The bodies that may stand between the point and what it sees.
    pub(crate) fn bodies<'a>(&'a self, sighting: &Sighting, scenery: &'a Scenery) -> impl Iterator<Item = usize> + 'a {
        let path = &self.paths[sighting.path.clone()];
        let of = |index: usize| path.get(index).map_or(&[][..], |cell| &scenery.rooms[*cell].bodies);
        // A body that reaches from one cell into the next is listed by both.
        (0..path.len()).flat_map(move |i| {
            let before = if i > 0 { of(i - 1) } else { &[] };
            of(i).iter().copied().filter(|body| !before.contains(body))
        })
    }

    /// Adds what `from` sees: see [`Beam::trace`].
    pub(crate) fn add(&mut self, beam: &mut Beam, scenery: &Scenery, camera_from_world: &Transform, from: &Apex, by: usize) {
        let apex = from.point;
        let apex_from_world = Translation3::from(-apex) * camera_from_world;
        beam.trace(scenery, &apex_from_world, from.cell, from.bounds, from.range_m, &mut |sight| {
            let id = sight.sheet.id;
            let is_wanted = |wanted: &[(SheetId, usize)]| wanted.binary_search_by_key(&id, |(sheet, _)| *sheet).is_ok();
            if !from.wanted.is_none_or(is_wanted) {
                return;
            }
            let first_corner = self.corners.len();
            self.corners.extend(sight.outline.iter().map(|p| p + apex));
            let first_cell = self.paths.len();
            self.paths.extend_from_slice(sight.path);
            self.list.push(Sighting {
                by,
                sheet: sight.sheet.id,
                cell: sight.sheet.cell,
                surface: sight.sheet.surface,
                body: sight.sheet.body,
                breadth_m: sight.sheet.breadth_m,
                plane: sight.sheet.plane.transformed(camera_from_world),
                outline: first_corner..self.corners.len(),
                path: first_cell..self.paths.len(),
            });
        });
    }
}
