//! Which region each pixel sees: every row as spans of columns, from left to right without gap or overlap.
//!
//! A region's outline is projected, corner by corner (with a lens that bends lines, in short pieces), and each row takes the columns
//! between the outline's crossings. Regions of walls share their edges; so that no pixel is lost or taken twice where an edge
//! runs exactly through pixels' centres, rows and columns are met a little off their centres ([`OFF_CENTRE_PX`]). Faces of bodies
//! are laid over the walls where they are nearer.

use std::ops::Range;

use nalgebra::{Point3, Vector3};

use super::tables::RayTable;
use crate::frame_geometry::FrameGeometry;

/// A run of pixels in a row that see one region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Span {
    /// First column.
    pub(crate) from: i32,
    /// One past the last.
    pub(crate) to: i32,
    /// The region, or [`DARK`]; from the number of regions on, grilles.
    pub(crate) region: u32,
}

/// The region of pixels that see nothing: an open end in a dark room.
pub(crate) const DARK: u32 = u32::MAX;

/// How far beside a pixel's centre edges are compared with it, in pixels.
const OFF_CENTRE_PX: f64 = 1.7e-5;

/// Gaps up to this wide between two regions are not open ends but the polylines of a bent edge that differ by a hair; they are filled
/// from the side. A real gap that narrow is filled too.
const GAP_PX: i32 = 2;

/// Distance between two places of a line that a lens bends, in the tangent of an angle: about 8 pixels, between which the line
/// is a hundredth of a pixel from straight.
const PIECE: f64 = 0.02;

/// The rows' spans. Kept from frame to frame for its memory.
#[derive(Debug, Default)]
pub(crate) struct Raster {
    /// Spans of each row, from the first row of the margin on.
    rows: Vec<Vec<Span>>,
    margin: i32,
    crossings: Vec<Vec<f64>>,
    /// The rows that have crossings.
    crossed: Range<usize>,
    outline: Vec<[f64; 2]>,
    spare: Vec<Span>,
}

impl Raster {
    /// The spans of a row of the image or its margin, which they fill.
    pub(crate) fn row(&self, row: isize) -> &[Span] {
        &self.rows[(row + self.margin as isize) as usize]
    }

    /// Makes the spans of a frame.
    pub(crate) fn build(&mut self, geometry: &FrameGeometry, table: &RayTable) {
        self.margin = table.margin as i32;
        let rows = table.height + 2 * table.margin;
        self.rows.resize_with(rows, Vec::new);
        self.crossings.resize_with(rows, Vec::new);
        self.rows.iter_mut().for_each(Vec::clear);
        let walls = geometry.regions.iter().enumerate().filter(|(_, region)| region.body.is_none());
        let walls = walls.map(|(index, region)| (index, region.outline.clone()));
        let grilles = geometry.grilles.iter().enumerate().map(|(i, outline)| (geometry.regions.len() + i, outline.clone()));
        for (index, outline) in walls.chain(grilles) {
            self.cross(geometry, &geometry.corners[outline], table);
            self.take_crossings(table, |rows, row, span| rows[row].push(Span { region: index as u32, ..span }));
        }
        for row in &mut self.rows {
            row.sort_unstable_by_key(|span| (span.from, span.region));
            fill(row, &mut self.spare, -self.margin, table.width as i32 + self.margin);
        }
        for (index, region) in geometry.regions.iter().enumerate() {
            if region.body.is_some() {
                self.cross(geometry, &geometry.corners[region.outline.clone()], table);
                let mut spare = std::mem::take(&mut self.spare);
                self.take_crossings(table, |rows, row, span| {
                    let span = Span { region: index as u32, ..span };
                    lay_over(&mut rows[row], &mut spare, span, row as isize - table.margin as isize, geometry, table);
                });
                self.spare = spare;
            }
        }
    }

    /// Where the rows cross an outline.
    fn cross(&mut self, geometry: &FrameGeometry, corners: &[Point3<f64>], table: &RayTable) {
        self.outline.clear();
        let projection = geometry.projection();
        for (i, a) in corners.iter().enumerate() {
            let b = &corners[(i + 1) % corners.len()];
            self.outline.push(projection.pixel_of(a));
            if table.is_bent() {
                pieces(a, b, |ray| self.outline.push(projection.pixel(ray)));
            }
        }
        let rows = self.crossings.len() as f64;
        let (mut highest, mut lowest) = (rows, 0.0_f64);
        for (i, a) in self.outline.iter().enumerate() {
            let b = &self.outline[(i + 1) % self.outline.len()];
            // Always from the upper end, so that both regions beside an edge find the same crossing.
            let (a, b) = if (a[1], a[0]) <= (b[1], b[0]) { (a, b) } else { (b, a) };
            let off = f64::from(self.margin) + OFF_CENTRE_PX;
            let (top, bottom) = (a[1] + off, b[1] + off);
            let slope = (b[0] - a[0]) / (b[1] - a[1]);
            // Rows with top <= row < bottom.
            let (first, last) = (top.ceil().max(0.0), bottom.ceil().min(rows));
            (highest, lowest) = (highest.min(first), lowest.max(last));
            let mut row = first;
            while row < last {
                self.crossings[row as usize].push(a[0] + (row - top) * slope);
                row += 1.0;
            }
        }
        self.crossed = highest as usize..lowest as usize;
    }

    /// Turns crossings into spans.
    fn take_crossings(&mut self, table: &RayTable, mut add: impl FnMut(&mut [Vec<Span>], usize, Span)) {
        let (low, high) = (-self.margin, table.width as i32 + self.margin);
        let column = |x: f64| (x - OFF_CENTRE_PX).ceil().clamp(f64::from(low), f64::from(high)) as i32;
        for row in self.crossed.clone() {
            if self.crossings[row].is_empty() {
                continue;
            }
            self.crossings[row].sort_unstable_by(f64::total_cmp);
            for pair in 0..self.crossings[row].len() / 2 {
                let (from, to) = (column(self.crossings[row][2 * pair]), column(self.crossings[row][2 * pair + 1]));
                if from < to {
                    add(&mut self.rows, row, Span { from, to, region: DARK });
                }
            }
            self.crossings[row].clear();
        }
    }
}

/// Visits the places of the edge from a to b where one of the ray's coordinates is a multiple of [`PIECE`]: the same places for every
/// edge along that line, wherever it ends.
fn pieces(a: &Point3<f64>, b: &Point3<f64>, mut visit: impl FnMut([f64; 2])) {
    let (from, to) = ([a.x / a.z, a.y / a.z], [b.x / b.z, b.y / b.z]);
    let axis = usize::from((to[1] - from[1]).abs() > (to[0] - from[0]).abs());
    let length = to[axis] - from[axis];
    let (low, high) = if length > 0.0 { (from[axis], to[axis]) } else { (to[axis], from[axis]) };
    let (first, last) = ((low / PIECE).floor() as i64 + 1, (high / PIECE).ceil() as i64 - 1);
    let count = (last - first + 1).max(0);
    for i in 0..count {
        let at = PIECE * (if length > 0.0 { first + i } else { last - i }) as f64;
        let share = (at - from[axis]) / length;
        let mut ray = [from[0] + (to[0] - from[0]) * share, from[1] + (to[1] - from[1]) * share];
        ray[axis] = at;
        visit(ray);
    }
}

/// Makes sorted spans follow each other without gap or overlap from `low` to `high`.
fn fill(row: &mut Vec<Span>, spare: &mut Vec<Span>, low: i32, high: i32) {
    spare.clear();
    let mut at = low;
    for span in row.iter() {
        if span.to <= at {
            continue;
        }
        let mut from = span.from.max(at);
        if from > at {
            if from - at <= GAP_PX {
                match spare.last_mut() {
                    Some(before) => before.to = from,
                    None => from = at,
                }
            } else {
                spare.push(Span { from: at, to: from, region: DARK });
            }
        }
        spare.push(Span { from, ..*span });
        at = span.to;
    }
    if at < high {
        match spare.last_mut() {
            Some(before) if high - at <= GAP_PX => before.to = high,
            _ => spare.push(Span { from: at, to: high, region: DARK }),
        }
    }
    // Not swapped: each row keeps the memory that it has grown to.
    row.clear();
    row.extend_from_slice(spare);
}

/// Lays a body's span over a row where it is nearer than what is there.
fn lay_over(row: &mut Vec<Span>, spare: &mut Vec<Span>, new: Span, row_px: isize, geometry: &FrameGeometry, table: &RayTable) {
    // 1/z = a . r; nothing is behind an open end.
    let inverse_depth = |region: u32| match geometry.regions.get(region as usize) {
        Some(region) => region.plane.normal.into_inner() / region.plane.offset_m,
        None => Vector3::zeros(),
    };
    let own = inverse_depth(new.region);
    spare.clear();
    for old in row.iter() {
        let (from, to) = (old.from.max(new.from), old.to.min(new.to));
        if from >= to {
            spare.push(*old);
            continue;
        }
        let nearer = own - inverse_depth(old.region);
        let mut push = |from: i32, to: i32, region: u32| match spare.last_mut() {
            Some(last) if last.region == region => last.to = to,
            _ => spare.push(Span { from, to, region }),
        };
        if old.from < from {
            push(old.from, from, old.region);
        }
        for column in from..to {
            let [x, y] = table.ray(row_px, column as isize);
            let hides = nearer.x * f64::from(x) + nearer.y * f64::from(y) + nearer.z > 0.0;
            push(column, column + 1, if hides { new.region } else { old.region });
        }
        if to < old.to {
            push(to, old.to, old.region);
        }
    }
    row.clear();
    row.extend_from_slice(spare);
}
