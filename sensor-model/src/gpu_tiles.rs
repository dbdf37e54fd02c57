//! Which tiles of the image hold an edge between regions, or a highlight: only there does the point spread change light without stripes.
//!
//! Elsewhere light varies so slowly that the point spread, which moves it by its own variance times half the light's curvature, leaves
//! it as it is: the headlamp's on a matt wall by less than a ten-thousandth.

use nalgebra::{Point3, Vector2, Vector3};

use crate::gpu_light::TILE_PX;
use crate::lens::Projection;

/// The tiles of an image.
#[derive(Debug)]
pub(crate) struct Tiles {
    columns: usize,
    rows: usize,
    edged: Vec<bool>,
    /// Numbers of the tiles, row by row: first those with an edge.
    pub(crate) order: Vec<u32>,
    /// How many have one.
    pub(crate) edged_count: usize,
    /// Numbers of the tiles with an edge and of those above and below them.
    pub(crate) columns_about: Vec<u32>,
    /// Pixels from which the point spread brings light.
    radius_px: f64,
}

/// Distance of the places on an edge at which tiles are looked for, in pixels.
const STEP_PX: f64 = 4.0;

/// Half a step to the next place, and a pixel for rounding and for the lens' bending.
const BETWEEN_PX: f64 = STEP_PX / 2.0 + 1.0;

/// Width of the headlamp's highlight (roughness times focal length) from which on the point spread changes it by less than one in two
/// thousand, 0.1 DN where it fills the pixels: 0.44 / 2 px^2 of variance times 8 / width^2 of curvature.
const HIGHLIGHT_MAX_PX: f64 = 60.0;

impl Tiles {
    /// For a point spread of this radius.
    pub(crate) fn new(width_px: usize, height_px: usize, radius_px: usize) -> Self {
        let [columns, rows] = [width_px, height_px].map(|n| n.div_ceil(TILE_PX));
        let count = columns * rows;
        Self {
            columns,
            rows,
            edged: vec![false; count],
            order: Vec::with_capacity(count),
            edged_count: 0,
            columns_about: Vec::with_capacity(count),
            radius_px: radius_px as f64,
        }
    }

    /// Forgets all edges.
    pub(crate) fn clear(&mut self) {
        self.edged.fill(false);
    }

    /// Marks the tiles into which the point spread brings light across the edges of a polygon of the camera's frame.
    pub(crate) fn mark(&mut self, corners: &[Point3<f64>], projection: &Projection) {
        let [fx, fy] = projection.camera.focal_px;
        for (i, from) in corners.iter().enumerate() {
            let to = &corners[(i + 1) % corners.len()];
            let (from, to) = (from.xy() / from.z, to.xy() / to.z);
            let along = to - from;
            let length_px = Vector2::new(along.x * fx, along.y * fy).norm();
            let steps = (length_px / STEP_PX).ceil().max(1.0);
            for step in 0..=steps as usize {
                let ray = from + along * (step as f64 / steps);
                self.mark_about(projection.pixel([ray.x, ray.y]), self.radius_px + BETWEEN_PX);
            }
        }
    }

    /// Marks the tiles of the headlamp's highlight on a surface of this roughness, where it is seen along its `normal`.
    pub(crate) fn mark_highlight(&mut self, normal: &Vector3<f64>, roughness: f64, projection: &Projection) {
        let width_px = roughness * projection.camera.focal_px[0];
        if normal.z > 0.1 && width_px < HIGHLIGHT_MAX_PX {
            self.mark_about(projection.pixel([normal.x / normal.z, normal.y / normal.z]), 3.0 * width_px + self.radius_px);
        }
    }

    fn mark_about(&mut self, pixel: [f64; 2], reach_px: f64) {
        let span = |at: f64, count: usize| {
            let tile = |at: f64| (at / TILE_PX as f64).floor().clamp(-1.0, count as f64);
            let first = tile(at - reach_px).max(0.0) as usize;
            let last = tile(at + reach_px).min(count as f64 - 1.0);
            first..if last < 0.0 { 0 } else { last as usize + 1 }
        };
        for row in span(pixel[1], self.rows) {
            for column in span(pixel[0], self.columns) {
                self.edged[row * self.columns + column] = true;
            }
        }
    }

    /// Puts the tiles in order.
    pub(crate) fn sort(&mut self) {
        self.order.clear();
        for edged in [true, false] {
            let chosen = self.edged.iter().zip(0..).filter(|(tile, _)| **tile == edged).map(|(_, number)| number);
            self.order.extend(chosen);
            if edged {
                self.edged_count = self.order.len();
            }
        }
        self.columns_about.clear();
        let edged = |row: usize, column: usize| self.edged[row * self.columns + column];
        for row in 0..self.rows {
            let rows = row.saturating_sub(1)..(row + 2).min(self.rows);
            let near = (0..self.columns).filter(|column| rows.clone().any(|row| edged(row, *column)));
            self.columns_about.extend(near.map(|column| (row * self.columns + column) as u32));
        }
    }
}

#[cfg(test)]
mod tests {
    use ductloop_nav::rig::{Camera, Distortion};

    use super::*;

    #[test]
    fn tiles_about_an_edge_are_marked_and_no_others() {
        let camera =
            Camera { width_px: 160, height_px: 96, focal_px: [100.0; 2], centre_px: [0.0; 2], distortion: Distortion::NONE };
        let projection = Projection::new(&camera, 4.0).expect("a pinhole");
        let mut tiles = Tiles::new(160, 96, 3);
        // A sliver along column 40 from row -50 to row 44: tiles of columns 32 to 47, down to row 47 (and the point spread 7 px on).
        let corner = |u: f64, v: f64| Point3::new(u / 100.0, v / 100.0, 1.0);
        tiles.mark(&[corner(40.0, -50.0), corner(40.0, 40.0), corner(40.2, 40.0)], &projection);
        tiles.sort();
        assert_eq!(tiles.edged_count, 3);
        assert_eq!(tiles.order[..3], [2, 12, 22]);
        assert_eq!(tiles.order.len(), 60);
        assert_eq!(tiles.columns_about, [2, 12, 22, 32]);
        tiles.clear();
        tiles.sort();
        assert_eq!(tiles.edged_count, 0);
    }
}
