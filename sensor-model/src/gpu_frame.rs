//! What the graphics device draws in a frame: the geometry of its exposure's parts, one after the other, in single precision.
//!
//! All geometry is done in double precision in the camera's frame ([`crate::frame_geometry`]) and only then rounded.

use std::ops::Range;

use crate::frame_geometry::{FrameGeometry, inverse_depth};
use crate::gpu_blocks::{Bases, RegionBlock, SeamBlock, StripBlock, four};
use crate::gpu_mesh::{Mesh, PointVertex};
use crate::gpu_tiles::Tiles;
use crate::renderer::MAX_LASERS;
use crate::soft_edges::SoftEdges;
use crate::surface::Look;

/// A frame's buffers before they are sent. Kept from frame to frame for their memory.
#[derive(Debug)]
pub(crate) struct FrameData {
    /// Regions of each part.
    pub(crate) sheets: Mesh,
    /// Strips of all parts.
    pub(crate) strips: Mesh,
    /// Strips of all parts that are seen by way of a mirror.
    pub(crate) ghosts: Mesh,
    pub(crate) region_blocks: Vec<RegionBlock>,
    pub(crate) strip_blocks: Vec<StripBlock>,
    /// Ridge and width.
    pub(crate) seams: Vec<SeamBlock>,
    pub(crate) glow: Vec<f32>,
    pub(crate) edges: Vec<[f32; 4]>,
    /// First edge and number of edges.
    pub(crate) holes: Vec<[u32; 2]>,
    /// Pixels that edges cross, of all parts.
    pub(crate) soft: Vec<PointVertex>,
    /// Which corners of `sheets` and which of `soft` are each part's.
    pub(crate) parts: Vec<[Range<u32>; 2]>,
    /// Where there are edges between regions.
    pub(crate) tiles: Tiles,
}

impl FrameData {
    pub(crate) fn new(tiles: Tiles) -> Self {
        Self {
            sheets: Mesh::default(),
            strips: Mesh::default(),
            ghosts: Mesh::default(),
            region_blocks: Vec::new(),
            strip_blocks: Vec::new(),
            seams: Vec::new(),
            glow: Vec::new(),
            edges: Vec::new(),
            holes: Vec::new(),
            soft: Vec::new(),
            parts: Vec::new(),
            tiles,
        }
    }

    pub(crate) fn clear(&mut self) {
        for mesh in [&mut self.sheets, &mut self.strips, &mut self.ghosts] {
            mesh.vertices.clear();
        }
        self.region_blocks.clear();
        self.strip_blocks.clear();
        self.seams.clear();
        self.glow.clear();
        self.edges.clear();
        self.holes.clear();
        self.soft.clear();
        self.parts.clear();
        self.tiles.clear();
    }

    /// Adds a part of the exposure; `looks` is indexed by surface, `strengths` are the lasers', in DN m^2, and are the part's share.
    pub(crate) fn add_part(&mut self, geometry: &FrameGeometry, soft: &SoftEdges, looks: &[Look], strengths: &[f64; MAX_LASERS]) {
        let bases = Bases { seams: self.seams.len(), glow: self.glow.len(), edges: self.edges.len(), holes: self.holes.len() };
        self.seams.extend(geometry.seams.iter().map(SeamBlock::of));
        self.glow.extend_from_slice(&geometry.glow);
        self.edges.extend(geometry.edges.iter().map(|edge| four(edge, 0.0)));
        self.holes.extend(geometry.holes.iter().map(|hole| [(hole.start + bases.edges) as u32, hole.len() as u32]));

        let projection = geometry.projection();
        let first = self.sheets.vertices.len() as u32;
        for region in &geometry.regions {
            let plane = region.plane.normal.into_inner() / region.plane.offset_m;
            let item = self.region_blocks.len() as u32;
            let (corners, look) = (&geometry.corners[region.outline.clone()], &looks[usize::from(region.surface.0)]);
            self.sheets.add_polygon(corners, &plane, projection, item);
            self.region_blocks.push(RegionBlock::of(region, look, &bases));
            self.tiles.mark(corners, projection);
            if look.specular > 0.0 {
                self.tiles.mark_highlight(&region.plane.normal, look.roughness, projection);
            }
        }
        for grille in &geometry.grilles {
            let corners = &geometry.corners[grille.clone()];
            if let Some(plane) = inverse_depth(corners) {
                self.sheets.add_polygon(corners, &plane, projection, self.region_blocks.len() as u32);
                self.region_blocks.push(RegionBlock::open_end());
                self.tiles.mark(corners, projection);
            }
        }
        let first_soft = self.soft.len() as u32;
        for (row, pixels) in soft.rows() {
            self.soft.extend(pixels.iter().map(|p| PointVertex { pixel: [p.column as f32, row as f32], light_dn: p.light_dn }));
        }
        self.parts.push([first..self.sheets.vertices.len() as u32, first_soft..self.soft.len() as u32]);

        for strip in &geometry.strips {
            let mesh = if strip.mirror.is_some() { &mut self.ghosts } else { &mut self.strips };
            mesh.add_band(&geometry.band[strip.band.clone()], self.strip_blocks.len() as u32);
            self.strip_blocks.push(StripBlock::of(strip, strengths[strip.laser], &bases));
        }
    }
}
