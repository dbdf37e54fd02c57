//! Where the nodes of a region's slow light are.

use nalgebra::{Vector2, Vector3};

use crate::daylight::Wall;
use crate::frame_geometry::{GLOW_SPACING_PX, GlowPatch, MARGIN_PX};
use crate::lens::Projection;
use crate::line_light::LANES;
use crate::strip::Blur;

/// Nodes nearer to a stripe's line than this are lit as if they were so far from it, in pixels: what a node holds is seen as far as
/// the next node, and a node that happens to be on a line would be a flare.
const NEAR_PX: f64 = 4.0;

/// Rays of the nodes in and about the image.
#[derive(Debug)]
pub(crate) struct NodeRays {
    /// [`NEAR_PX`] as an angle.
    near_rad: f64,
    /// Nodes before pixel 0, along both axes.
    before: i32,
    columns: i32,
    rows: i32,
    rays: Vec<NodeRay>,
}

#[derive(Clone, Copy, Debug)]
struct NodeRay {
    ray: Vector2<f64>,
    /// cos^4.
    falloff: f32,
}

/// The nodes of one region, padded to whole chunks. Kept from region to region for its memory.
#[derive(Debug, Default)]
pub(crate) struct Nodes {
    /// Places, in the camera's frame, in metres.
    pub(crate) x: Vec<f32>,
    pub(crate) y: Vec<f32>,
    pub(crate) z: Vec<f32>,
    /// Square of the distance from a line below which it is taken for that distance, in square metres.
    pub(crate) near_m2: Vec<f32>,
    /// In DN of a white surface.
    pub(crate) light: Vec<f32>,
    /// From light to grey values; as many as there are nodes.
    pub(crate) factor: Vec<f32>,
    outline: Vec<Vector2<f64>>,
}

impl NodeRays {
    /// For a camera with this lens.
    pub(crate) fn new(projection: &Projection, blur: &Blur) -> Self {
        const BEFORE: i32 = 2;
        let size = [projection.camera.width_px, projection.camera.height_px];
        let [columns, rows] = size.map(|pixels| pixels.div_ceil(GLOW_SPACING_PX) as i32 + 1 + 2 * BEFORE);
        let place = |node: i32, pixels: usize| {
            let pixel = f64::from(node - BEFORE) * GLOW_SPACING_PX as f64;
            // Farther out the lens may have no ray; no pixel is beyond.
            pixel.clamp(-MARGIN_PX, pixels as f64 - 1.0 + MARGIN_PX)
        };
        let node = |row: i32, column: i32| {
            let ray = projection.ray([place(column, size[0]), place(row, size[1])]);
            let ray = Vector2::from(ray);
            NodeRay { ray, falloff: blur.falloff(&ray.push(1.0)) as f32 }
        };
        let rays = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))).map(|(r, c)| node(r, c)).collect();
        Self { near_rad: NEAR_PX / blur.focal_px, before: BEFORE, columns, rows, rays }
    }

    /// The ray of a node; those far outside the image are taken from nearer by.
    fn at(&self, column: i32, row: i32) -> NodeRay {
        let column = (column + self.before).clamp(0, self.columns - 1);
        let row = (row + self.before).clamp(0, self.rows - 1);
        self.rays[(row * self.columns + column) as usize]
    }
}

impl Nodes {
    /// The nodes of a patch on their wall, in the dark.
    pub(crate) fn lay(&mut self, rays: &NodeRays, patch: &GlowPatch, wall: &Wall, albedo: f64) {
        /// How far inside its wall's border a node takes its light, as a share of how far outside it is: between a node and
        /// one taken from the very border, stripes that meet the border would find no light to interpolate.
        const MIRRORED: f64 = 0.5;
        /// Share of the way to the middle of its wall that a node at the wall's border is moved: on the border itself the line
        /// of a stripe, or a grille's edge, would be seen from within.
        const INWARD: f64 = 1e-4;
        self.clear();
        self.outline.clear();
        self.outline.extend(wall.outline.iter().map(|p| p.xy().coords / p.z));
        let middle = wall.outline.iter().map(|p| p.coords).sum::<Vector3<f64>>() / wall.outline.len() as f64;
        for row in 0..patch.rows {
            for column in 0..patch.columns {
                let NodeRay { ray, falloff } = rays.at(patch.column + column as i32, patch.row + row as i32);
                let border = nearest_outside(&self.outline, &ray);
                let ray = match border {
                    Some(border) => {
                        let inside = border + (border - ray) * MIRRORED;
                        nearest_outside(&self.outline, &inside).unwrap_or(inside)
                    }
                    None => ray,
                };
                let ray = ray.push(1.0);
                let mut point = ray * (wall.offset_m / wall.away.dot(&ray));
                if border.is_some() {
                    point += (middle - point) * INWARD;
                }
                self.push(&point, rays.near_rad * point.norm());
                self.factor.push(albedo as f32 * falloff);
            }
        }
        self.pad();
    }

    fn clear(&mut self) {
        for values in [&mut self.x, &mut self.y, &mut self.z, &mut self.near_m2, &mut self.light, &mut self.factor] {
            values.clear();
        }
    }

    fn push(&mut self, point: &Vector3<f64>, near_m: f64) {
        self.x.push(point.x as f32);
        self.y.push(point.y as f32);
        self.z.push(point.z as f32);
        self.near_m2.push((near_m * near_m) as f32);
    }

    /// Repeats the last node up to a whole chunk, and takes all light away.
    fn pad(&mut self) {
        let padded = self.factor.len().next_multiple_of(LANES);
        for values in [&mut self.x, &mut self.y, &mut self.z, &mut self.near_m2] {
            let last = values.last().copied().unwrap_or_default();
            values.resize(padded, last);
        }
        self.light.resize(padded, 0.0);
    }
}

/// The point of a convex polygon nearest to a point outside it; `None` inside.
fn nearest_outside(polygon: &[Vector2<f64>], point: &Vector2<f64>) -> Option<Vector2<f64>> {
    let edges = || {
        let mut a = polygon[polygon.len() - 1];
        polygon.iter().map(move |b| (std::mem::replace(&mut a, *b), *b))
    };
    // On the same side of all edges, whichever way round they run?
    let mut sides = [false; 2];
    for (a, b) in edges() {
        let side = (b.x - a.x) * (point.y - a.y) - (b.y - a.y) * (point.x - a.x);
        sides[0] |= side > 0.0;
        sides[1] |= side < 0.0;
    }
    if sides != [true, true] {
        return None;
    }
    let on_edge = |(a, b): (Vector2<f64>, Vector2<f64>)| {
        let (edge, way) = (b - a, point - a);
        let length2 = edge.norm_squared();
        a + edge * if length2 > 0.0 { (way.dot(&edge) / length2).clamp(0.0, 1.0) } else { 0.0 }
    };
    let off2 = |p: &Vector2<f64>| (p - point).norm_squared();
    edges().map(on_edge).min_by(|a, b| off2(a).total_cmp(&off2(b)))
}
