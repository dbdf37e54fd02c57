//! What pixels that an edge between regions crosses have in excess of what their centres see: a pixel collects the light of all that
//! falls on its square.
//!
//! Both renderers give each pixel the light of the one region that its centre sees. Here, for every edge that is seen, the pixels that it
//! crosses get the rest: for each, the part of its square beyond the edge times the difference between the two regions' light there.
//! The edge is taken as straight within a pixel, and one pixel's edges as independent; where three regions meet in a pixel, that is an
//! estimate. A body thinner than a pixel, seen by no pixel's centre, stays unseen.

use nalgebra::{Vector2, Vector3};

use crate::cpu::raster::{DARK, Raster, Span};
use crate::cpu::tables::RayTable;
use crate::frame_geometry::{FrameGeometry, GLOW_SPACING_PX, GlowPatch};
use crate::light::headlamp_strength;
use crate::optics::Optics;
use crate::renderer::View;
use crate::surface::Look;

/// A pixel's rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SoftPixel {
    pub(crate) column: i32,
    /// In DN at nominal exposure; may be negative.
    pub(crate) light_dn: f32,
}

/// A frame's pixels that edges cross, row by row. Kept from frame to frame for its memory.
#[derive(Debug, Default)]
pub(crate) struct SoftEdges {
    rows: Vec<Vec<SoftPixel>>,
    margin: usize,
    /// For each corner of the geometry the plane through the camera's centre and the edge to the next corner.
    lines: Vec<Line>,
    /// A number that regions of one plane and one surface share: there is no edge between them.
    classes: Vec<u32>,
}

/// An edge as a plane through the camera's centre, l . r = 0.
#[derive(Clone, Copy, Debug)]
struct Line {
    normal: Vector3<f64>,
    /// Planes square to it through its ends: an edge's points are on their positive sides.
    ends: [Vector3<f64>; 2],
}

/// Light without stripes, before the lens.
struct Smooth<'a> {
    geometry: &'a FrameGeometry,
    looks: &'a [Look],
    headlamp: f64,
    ambient_dn: f64,
    /// A rest smaller than this is left out: as much less as the lamp is weaker, so that twice the lamp is twice the light to the bit.
    least_dn: f64,
}

/// Two neighbouring pixels and what they see.
#[derive(Clone, Copy, Debug)]
struct Pair {
    pixels: [[i32; 2]; 2],
    regions: [u32; 2],
    /// 0 for neighbours in a row, 1 in a column.
    axis: usize,
}

/// A rest smaller than this is left out at nominal power, in DN.
const LEAST_DN: f64 = 0.004;

impl SoftEdges {
    /// The rests of a row of the image or its margin, by no particular order.
    pub(crate) fn row(&self, row: isize) -> &[SoftPixel] {
        &self.rows[(row + self.margin as isize) as usize]
    }

    /// All rows with their numbers.
    #[cfg(feature = "wgpu")]
    pub(crate) fn rows(&self) -> impl Iterator<Item = (i32, &[SoftPixel])> {
        self.rows.iter().zip(-(self.margin as i32)..).map(|(row, number)| (number, &row[..]))
    }

    /// Finds those of a frame whose pixels see what `raster` says.
    pub(crate) fn build(
        &mut self,
        geometry: &FrameGeometry,
        raster: &Raster,
        table: &RayTable,
        looks: &[Look],
        optics: &Optics,
        view: &View,
    ) {
        self.margin = table.margin;
        let rows = table.height + 2 * table.margin;
        self.rows.resize_with(rows, Vec::new);
        self.rows.iter_mut().for_each(Vec::clear);
        self.prepare(geometry);
        let headlamp = headlamp_strength(optics) * view.headlamp_power;
        let least_dn = LEAST_DN * view.headlamp_power;
        let smooth = Smooth { geometry, looks, headlamp, ambient_dn: optics.ambient_dn, least_dn };
        let first = -(table.margin as isize);
        let mut known = None;
        for row in first..first + rows as isize {
            let spans = raster.row(row);
            for two in spans.windows(2) {
                let column = two[1].from;
                let pixels = [[column - 1, row as i32], [column, row as i32]];
                self.add(&smooth, table, &Pair { pixels, regions: [two[0].region, two[1].region], axis: 0 }, &mut known);
            }
            if row + 1 < first + rows as isize {
                overlaps(spans, raster.row(row + 1), |columns, regions| {
                    for column in columns {
                        let pixels = [[column, row as i32], [column, row as i32 + 1]];
                        self.add(&smooth, table, &Pair { pixels, regions, axis: 1 }, &mut known);
                    }
                });
            }
        }
    }

    fn prepare(&mut self, geometry: &FrameGeometry) {
        self.lines.clear();
        let nothing = Line { normal: Vector3::zeros(), ends: [Vector3::zeros(); 2] };
        self.lines.resize(geometry.corners.len(), nothing);
        let outlines = geometry.regions.iter().map(|region| &region.outline).chain(&geometry.grilles);
        for outline in outlines {
            for i in outline.clone() {
                let next = if i + 1 == outline.end { outline.start } else { i + 1 };
                let (a, b) = (geometry.corners[i].coords, geometry.corners[next].coords);
                let normal = a.cross(&b);
                self.lines[i] = Line { normal, ends: [normal.cross(&a), b.cross(&normal)] };
            }
        }
        self.classes.clear();
        for (index, region) in geometry.regions.iter().enumerate() {
            let same = geometry.regions[..index].iter().position(|other| other.goes_on_in(region));
            self.classes.push(same.unwrap_or(index) as u32);
        }
    }

    fn class(&self, region: u32) -> u32 {
        self.classes.get(region as usize).copied().unwrap_or(region)
    }

    /// Adds what two neighbours lack, if the edge between them runs across the way from one to the other rather than along it: the
    /// neighbours along the other axis have the rest. `known` is the edge that was found last.
    fn add(&mut self, smooth: &Smooth<'_>, table: &RayTable, pair: &Pair, known: &mut Option<usize>) {
        if self.class(pair.regions[0]) == self.class(pair.regions[1]) {
            return;
        }
        let rays = pair.pixels.map(|[u, v]| {
            let [x, y] = table.ray(v as isize, u as isize);
            Vector3::new(f64::from(x), f64::from(y), 1.0)
        });
        let Some(edge) = self.edge(smooth.geometry, &pair.regions, &rays, *known) else { return };
        *known = Some(edge);
        let normal = self.lines[edge].normal;
        let per_pixel = smooth.geometry.projection().rays_per_pixel([rays[0].x, rays[0].y]).tr_mul(&normal.xy());
        let steep = per_pixel.x.abs() >= per_pixel.y.abs();
        if steep != (pair.axis == 0) {
            return;
        }
        let per_px = 1.0 / per_pixel.norm();
        let across = per_pixel.map(f64::abs) * per_px;
        for (i, ray) in rays.iter().enumerate() {
            let off_px = normal.dot(ray).abs() * per_px;
            let share = part_beyond(off_px, &across);
            if share < 1e-4 {
                continue;
            }
            let [u, v] = pair.pixels[i];
            let light = |region: u32| smooth.light(region, [u, v], ray);
            let rest = share * (light(pair.regions[1 - i]) - light(pair.regions[i]));
            if rest.abs() > smooth.least_dn {
                let row = (v + self.margin as i32) as usize;
                self.rows[row].push(SoftPixel { column: u, light_dn: rest as f32 });
            }
        }
    }

    /// The edge of either region, as an index of its first corner, that separates two rays: of the nearer region, if of both.
    fn edge(
        &self,
        geometry: &FrameGeometry,
        regions: &[u32; 2],
        rays: &[Vector3<f64>; 2],
        known: Option<usize>,
    ) -> Option<usize> {
        let separates = |edge: usize| {
            let line = &self.lines[edge];
            let [p, q] = rays.map(|ray| line.normal.dot(&ray));
            if (p > 0.0) == (q > 0.0) || p == q {
                return false;
            }
            let met = rays[0] + (rays[1] - rays[0]) * (p / (p - q));
            line.ends.iter().all(|end| end.dot(&met) >= -1e-9)
        };
        let outline = |region: u32| {
            let index = region as usize;
            let grille = || geometry.grilles.get(index - geometry.regions.len()).cloned();
            if region == DARK { None } else { geometry.regions.get(index).map(|r| r.outline.clone()).or_else(grille) }
        };
        let near =
            |region: u32| geometry.regions.get(region as usize).map_or(0.0, |r| r.plane.normal.dot(&rays[0]) / r.plane.offset_m);
        let [a, b] = *regions;
        let ordered = if near(a) >= near(b) { [a, b] } else { [b, a] };
        let outlines = ordered.map(outline);
        // Edges run over many pixels.
        if let Some(edge) = known.filter(|edge| outlines.iter().flatten().any(|outline| outline.contains(edge)))
            && separates(edge)
        {
            return Some(edge);
        }
        outlines.into_iter().flatten().flatten().find(|edge| separates(*edge))
    }
}

/// Visits the columns in which two rows, one below the other, see different regions.
fn overlaps(upper: &[Span], lower: &[Span], mut visit: impl FnMut(std::ops::Range<i32>, [u32; 2])) {
    let (mut i, mut j) = (0, 0);
    while let (Some(a), Some(b)) = (upper.get(i), lower.get(j)) {
        let (from, to) = (a.from.max(b.from), a.to.min(b.to));
        if from < to && a.region != b.region {
            visit(from..to, [a.region, b.region]);
        }
        if a.to <= b.to {
            i += 1;
        } else {
            j += 1;
        }
    }
}

/// The part of a pixel's square beyond an edge that runs past its middle at this distance; `across` is the edge's unit normal, its
/// signs dropped.
fn part_beyond(off_px: f64, across: &Vector2<f64>) -> f64 {
    let (long, short) = (across.x.max(across.y), across.x.min(across.y));
    let (reach, flat) = ((long + short) / 2.0, (long - short) / 2.0);
    if off_px >= reach {
        0.0
    } else if off_px >= flat {
        (reach - off_px) * (reach - off_px) / (2.0 * long * short)
    } else {
        0.5 - off_px / long
    }
}

impl Smooth<'_> {
    /// A region's light at a pixel, whether it is seen there or not.
    fn light(&self, region: u32, pixel: [i32; 2], ray: &Vector3<f64>) -> f64 {
        if region == DARK {
            return 0.0;
        }
        let falloff = self.geometry.blur().falloff(ray);
        let Some(region) = self.geometry.regions.get(region as usize) else { return self.ambient_dn * falloff };
        let look = &self.looks[usize::from(region.surface.0)];
        let length = ray.norm();
        let facing = (region.plane.normal.dot(ray) / length).max(1e-6);
        let near = facing / region.plane.offset_m;
        let lamp = self.headlamp * facing * near * near * look.reflectance(facing, facing, facing, 1.0);
        lamp * falloff + region.glow.map_or(0.0, |patch| self.glow(&patch, pixel))
    }

    fn glow(&self, patch: &GlowPatch, [u, v]: [i32; 2]) -> f64 {
        const SPACING: i32 = GLOW_SPACING_PX as i32;
        let node = |i: i32, j: i32| {
            let column = (i - patch.column).clamp(0, patch.columns as i32 - 1) as usize;
            let row = (j - patch.row).clamp(0, patch.rows as i32 - 1) as usize;
            f64::from(self.geometry.glow[patch.first + row * patch.columns + column])
        };
        let (i, j) = (u.div_euclid(SPACING), v.div_euclid(SPACING));
        let [p, q] = [u, v].map(|at| f64::from(at.rem_euclid(SPACING)) / f64::from(SPACING));
        let row = |j: i32| node(i, j) * (1.0 - p) + node(i + 1, j) * p;
        row(j) * (1.0 - q) + row(j + 1) * q
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against a count of points of the square.
    #[test]
    fn the_part_beyond_an_edge_is_its_area() {
        const SIDE: i32 = 400;
        for angle in [0.0, 0.1, 0.5, 0.785, 1.2, 1.55] {
            let (sin, cos) = libm::sincos(angle);
            for off in [0.0, 0.1, 0.33, 0.5, 0.6, 0.7] {
                let inside = |k: i32| (f64::from(k) + 0.5) / f64::from(SIDE) - 0.5;
                let beyond = (0..SIDE * SIDE).filter(|i| inside(i % SIDE) * cos + inside(i / SIDE) * sin > off).count();
                let expected = beyond as f64 / f64::from(SIDE * SIDE);
                let found = part_beyond(off, &Vector2::new(cos, sin));
                assert!((found - expected).abs() < 2.0 / f64::from(SIDE), "angle {angle}, {off} px: {found} for {expected}");
            }
        }
    }
}
