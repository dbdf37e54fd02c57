//! The nodes on which slowly varying light is computed: a lattice over the image, and each region's rectangle of it.

use nalgebra::{Matrix2, Point3, Vector2, Vector3};

use crate::lens::Projection;
use crate::strip::Blur;

/// Distance of two nodes of the glow, in pixels; between them it is interpolated linearly in u and v.
pub const GLOW_SPACING_PX: usize = 16;

/// Where the nodes of a region's glow are: a rectangle of nodes [`GLOW_SPACING_PX`] pixels apart, node (i, j) at pixel (16 i, 16 j), row by
/// row in [`super::FrameGeometry::glow`], large enough that every pixel of the region, up to 16 px outside the image, is between nodes.
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

impl GlowPatch {
    /// Its nodes' number.
    pub fn nodes(&self) -> usize {
        self.columns * self.rows
    }
}

/// What the glow needs to know of nodes, an entry a node.
#[derive(Debug, Default)]
pub struct NodeRays {
    /// x of the ray (x, y, 1).
    pub x: Vec<f32>,
    /// y of it.
    pub y: Vec<f32>,
    /// The lens' fall-off, [`Blur::falloff`].
    pub falloff: Vec<f32>,
    /// Derivative of (x, y) by (u, v): dx/du, dx/dv, dy/du, dy/dv.
    pub slope: [Vec<f32>; 4],
}

/// All nodes that a camera's image needs, from [`GLOW_SPACING_PX`] pixels outside it on.
#[derive(Debug)]
pub struct NodeLattice {
    column: i32,
    row: i32,
    columns: usize,
    rows: usize,
    rays: NodeRays,
}

impl NodeRays {
    fn arrays(&self) -> [&Vec<f32>; 7] {
        let [a, b, c, d] = &self.slope;
        [&self.x, &self.y, &self.falloff, a, b, c, d]
    }

    fn arrays_mut(&mut self) -> [&mut Vec<f32>; 7] {
        let [a, b, c, d] = &mut self.slope;
        [&mut self.x, &mut self.y, &mut self.falloff, a, b, c, d]
    }

    /// Repeats the last entry until there are whole chunks of `lanes`.
    pub(super) fn pad(&mut self, lanes: usize) {
        for values in self.arrays_mut() {
            let last = values.last().copied().unwrap_or_default();
            values.resize(values.len().next_multiple_of(lanes), last);
        }
    }
}

impl NodeLattice {
    /// The nodes of a camera. A lens need not be sound farther than `margin_px` outside the image: there, rays go on linearly.
    pub(super) fn new(projection: &Projection, blur: &Blur, margin_px: f64) -> Self {
        let spacing = GLOW_SPACING_PX as f64;
        let last = [projection.camera.width_px, projection.camera.height_px].map(|n| n as f64 - 1.0);
        // From one node outside to the first that is a node's distance past the last pixel.
        let [columns, rows] = last.map(|last| (last / spacing).ceil() as usize + 3);
        let mut rays = NodeRays::default();
        for j in 0..rows {
            for i in 0..columns {
                let pixel = [i, j].map(|n| (n as f64 - 1.0) * spacing);
                let near = [0, 1].map(|axis| pixel[axis].clamp(-margin_px, last[axis] + margin_px));
                let ray = projection.ray(near);
                let slope: Matrix2<f64> = projection.rays_per_pixel(ray);
                let ray = Vector2::from(ray) + slope * (Vector2::from(pixel) - Vector2::from(near));
                rays.x.push(ray.x as f32);
                rays.y.push(ray.y as f32);
                rays.falloff.push(blur.falloff(&Vector3::new(ray.x, ray.y, 1.0)) as f32);
                for (kept, value) in rays.slope.iter_mut().zip([slope.m11, slope.m12, slope.m21, slope.m22]) {
                    kept.push(value as f32);
                }
            }
        }
        Self { column: -1, row: -1, columns, rows, rays }
    }

    /// The rectangle of nodes about a region, with its values from `first` on; none where the region is not in the image.
    pub(super) fn patch(&self, outline: &[Point3<f64>], projection: &Projection, first: usize) -> Option<GlowPatch> {
        /// Parts in which an edge that the lens may bend is looked at.
        const PARTS: usize = 4;
        let parts = if projection.is_pinhole() { 1 } else { PARTS };
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for (i, from) in outline.iter().enumerate() {
            let to = outline[(i + 1) % outline.len()];
            for part in 0..parts {
                let pixel = projection.pixel_of(&(from + (to - from) * (part as f64 / parts as f64)));
                for axis in 0..2 {
                    low[axis] = low[axis].min(pixel[axis]);
                    high[axis] = high[axis].max(pixel[axis]);
                }
            }
        }
        let spacing = GLOW_SPACING_PX as f64;
        // A node more on each side: a bent edge bulges beyond the places looked at.
        let spans = [(0, self.column, self.columns), (1, self.row, self.rows)].map(|(axis, first, count)| {
            let last = first + count as i32 - 1;
            let from = ((low[axis] / spacing).floor().max(-2.0) as i32 - 1).max(first);
            let to = ((high[axis] / spacing).ceil().min(f64::from(last)) as i32 + 1).min(last);
            (from, to)
        });
        let [(column, last_column), (row, last_row)] = spans;
        (column < last_column && row < last_row).then(|| GlowPatch {
            first,
            column,
            row,
            columns: (last_column - column + 1) as usize,
            rows: (last_row - row + 1) as usize,
        })
    }

    /// Copies what there is of a patch's nodes, in their order, into `rays`.
    pub fn gather(&self, patch: &GlowPatch, rays: &mut NodeRays) {
        for (to, from) in rays.arrays_mut().into_iter().zip(self.rays.arrays()) {
            to.clear();
            for row in 0..patch.rows {
                let start = ((patch.row - self.row) as usize + row) * self.columns + (patch.column - self.column) as usize;
                to.extend_from_slice(&from[start..start + patch.columns]);
            }
        }
    }
}
