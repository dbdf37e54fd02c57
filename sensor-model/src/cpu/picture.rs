//! What a frame, or a part of its exposure, shows: geometry, and from it what the loops over pixels need.

use super::edges::Line;
use super::intervals::Intervals;
use super::raster::{DARK, Raster};
use super::ridges::Ridge;
use super::surfaces::{self, Surface};
use super::tables::RayTable;
use crate::frame_geometry::FrameGeometry;
use crate::light::laser_strength;
use crate::optics::Optics;
use crate::renderer::View;
use crate::scenery::Scenery;
use crate::soft_edges::SoftEdges;

/// A part of an exposure. Kept from frame to frame for its memory.
#[derive(Debug)]
pub(super) struct Picture {
    pub(super) geometry: FrameGeometry,
    pub(super) raster: Raster,
    pub(super) ridges: Vec<Ridge>,
    /// The columns of each ridge.
    pub(super) intervals: Intervals,
    /// The geometry's edges.
    pub(super) edges: Vec<Line>,
    /// Pixels that edges between regions cross.
    pub(super) soft: SoftEdges,
    surfaces: Vec<Surface>,
    nothing: Surface,
}

impl Picture {
    pub(super) fn new(geometry: FrameGeometry) -> Self {
        Self {
            geometry,
            raster: Raster::default(),
            ridges: Vec::new(),
            intervals: Intervals::default(),
            edges: Vec::new(),
            soft: SoftEdges::default(),
            surfaces: Vec::new(),
            nothing: Surface::nothing(),
        }
    }

    /// Takes over what the geometry has become.
    pub(super) fn prepare(&mut self, scenery: &Scenery, optics: &Optics, view: &View, table: &RayTable) {
        let geometry = &self.geometry;
        self.raster.build(geometry, table);
        self.soft.build(geometry, &self.raster, table, &scenery.looks, optics, view);
        surfaces::collect(geometry, scenery, optics, view, &mut self.surfaces);
        self.edges.clear();
        self.edges.extend(geometry.edges.iter().map(Line::new));
        self.ridges.clear();
        self.intervals.clear();
        for strip in &geometry.strips {
            let strength = laser_strength(optics, &strip.line) * view.laser_power[strip.laser];
            if let Some(ridge) = Ridge::new(strip, strength) {
                self.ridges.push(ridge);
                self.intervals.push(&geometry.band[strip.band.clone()], table.width, table.height);
            }
        }
    }

    /// What a span's region looks like.
    pub(super) fn surface(&self, region: u32) -> &Surface {
        if region == DARK { &self.nothing } else { &self.surfaces[region as usize] }
    }
}
