//! Daylight from open ends: each grille shines evenly in all directions, as a clear or clouded sky does.
//!
//! A polygon of even luminance gives a point x with normal m the irradiance of Lambert's formula (Photometria, 1760): of a white
//! surface lit by a whole hemisphere of it,
//!
//! ```text
//! E / ambient = 1 / (2 pi) * sum over edges of gamma m . (p x q) / |p x q|
//! ```
//!
//! with p and q the ways from x to an edge's ends, gamma the angle between them, and the polygon cut off at the point's horizon. It is
//! exact, and so is what openings on the way hide: the polygon is cut along their edges. Left out: what walls pass on, the shadows of
//! bodies, ends farther than 12 m.

use std::ops::Range;

use ductloop_duct::cell::CellId;
use nalgebra::{Point3, Vector3};

use crate::Transform;
use crate::beam::clip_top;
use crate::passage::{Passage, Passages, Rim};
use crate::scenery::Scenery;

/// Open ends are looked for through openings up to this far from the camera, in metres: one of 0.5 x 0.3 m lights a wall square to
/// it there by 1/3000 of its luminance, the walls along the duct by a hundredth of that.
pub(crate) const REACH_M: f64 = 12.0;

/// Open ends that can give no point of a piece of wall more than this are passed over for it, in DN before its own albedo.
const FAINT_DN: f64 = 2e-3;

/// The open ends near the camera. Kept from frame to frame for its memory.
#[derive(Debug)]
pub(crate) struct Daylight {
    ambient_dn: f64,
    grilles: Vec<(CellId, Range<usize>)>,
    corners: Vec<Point3<f64>>,
    open: Vec<Point3<f64>>,
    seen: Vec<Point3<f64>>,
    spare: Vec<Point3<f64>>,
}

/// A piece of wall in the light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wall<'a> {
    /// Its cell.
    pub(crate) cell: CellId,
    /// Unit normal, away from the side that is seen.
    pub(crate) away: Vector3<f64>,
    /// Of its plane.
    pub(crate) offset_m: f64,
    /// Its outline.
    pub(crate) outline: &'a [Point3<f64>],
}

impl Daylight {
    /// For grilles of this luminance: the grey value that a white surface has under a whole sky of it.
    pub(crate) fn new(ambient_dn: f64) -> Self {
        Self { ambient_dn, grilles: Vec::new(), corners: Vec::new(), open: Vec::new(), seen: Vec::new(), spare: Vec::new() }
    }

    /// Finds the open ends of the cells of the tree.
    pub(crate) fn find(&mut self, scenery: &Scenery, camera_from_world: &Transform, passages: &Passages) {
        self.grilles.clear();
        self.corners.clear();
        for cell in passages.cells() {
            for grille in &scenery.rooms[cell].grilles {
                let first = self.corners.len();
                self.corners.extend(grille.outline.iter().map(|p| camera_from_world * p));
                self.grilles.push((cell, first..self.corners.len()));
            }
        }
    }

    /// Adds to the points' light, in DN of a white surface. `hiding` is working memory.
    pub(crate) fn shine(
        &mut self,
        passages: &Passages,
        wall: &Wall,
        hiding: &mut Vec<Rim>,
        points: impl Iterator<Item = Vector3<f64>> + Clone,
        light: &mut [f32],
    ) {
        for (cell, corners) in &self.grilles {
            self.open.clear();
            self.open.extend_from_slice(&self.corners[corners.clone()]);
            clip_top(&mut self.open, 0, &mut self.spare, |p| wall.away.dot(&p.coords) - wall.offset_m);
            if self.open.len() < 3 || self.ambient_dn * brightest(wall, &self.open) < FAINT_DN {
                continue;
            }
            if passages.look((wall.cell, wall.outline), (*cell, &self.open), hiding) == Passage::Blocked {
                continue;
            }
            for (x, light) in points.clone().zip(&mut *light) {
                self.seen.clear();
                self.seen.extend_from_slice(&self.open);
                for [a, b] in &*hiding {
                    let inward = (a - x).cross(&(b - x));
                    clip_top(&mut self.seen, 0, &mut self.spare, |p| -inward.dot(&(p.coords - x)));
                }
                *light += (self.ambient_dn * sky_share(&x, &wall.away, &self.seen)) as f32;
            }
        }
    }
}

/// A bound of what a polygon gives any point of a wall: its area, and both as near and as high above one another as they come.
fn brightest(wall: &Wall, open: &[Point3<f64>]) -> f64 {
    let (low, high) = bounds(wall.outline);
    let (open_low, open_high) = bounds(open);
    let apart = (open_low - high).sup(&(low - open_high)).sup(&Vector3::zeros()).norm();
    if apart == 0.0 {
        return 1.0;
    }
    let first = &open[0];
    let area: Vector3<f64> = open.windows(2).map(|edge| (edge[0] - first).cross(&(edge[1] - first)) / 2.0).sum();
    let rise = open.iter().map(|p| wall.offset_m - wall.away.dot(&p.coords)).fold(0.0, f64::max);
    (area.norm() / (std::f64::consts::PI * apart * apart) * (rise / apart).min(1.0)).min(1.0)
}

/// The smallest box about points.
pub(crate) fn bounds(points: &[Point3<f64>]) -> (Vector3<f64>, Vector3<f64>) {
    points.iter().fold((Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY)), |(low, high), p| {
        (low.inf(&p.coords), high.sup(&p.coords))
    })
}

/// Share of the light of a whole sky that a convex polygon, nowhere below the point's horizon, gives a point on a surface whose
/// normal is `-away`. Edges in line with the point have no direction and count for nothing: keep points off the polygon's rim.
pub fn sky_share(x: &Vector3<f64>, away: &Vector3<f64>, polygon: &[Point3<f64>]) -> f64 {
    let mut sum = 0.0;
    for (i, p) in polygon.iter().enumerate() {
        let (p, q) = (p.coords - x, polygon[(i + 1) % polygon.len()].coords - x);
        let cross = p.cross(&q);
        let sine = cross.norm();
        if sine > 0.0 {
            sum += libm::atan2(sine, p.dot(&q)) * (away.dot(&cross) / sine);
        }
    }
    // Whichever way round the polygon runs.
    sum.abs() / (2.0 * std::f64::consts::PI)
}

#[cfg(test)]
mod tests {
    use ductloop_duct::cell::SurfaceId;
    use ductloop_duct::fitting::{Fitting, Shape};
    use ductloop_duct::network::{End, Network};

    use super::*;
    use crate::surface::Look;

    const WIDTH_M: f64 = 0.5;
    const HEIGHT_M: f64 = 0.3;

    /// A duct along x, open at x = 0.
    fn scenery() -> Scenery {
        let shape = Shape::Straight { length_m: 5.0 };
        let piece = Fitting { shape, width_m: WIDTH_M, height_m: HEIGHT_M, surface: SurfaceId(0) };
        Scenery::new(&Network::from_run(&[piece], End::Open, End::Cap).unwrap(), &[Look::matt(0.5)]).unwrap()
    }

    /// A square of 0.1 m about a point at x = `far_m`, that looks out of the open end for no turn, to the left for a quarter of one; and
    /// its normal, away from where it looks.
    fn square(far_m: f64, turn_rad: f64) -> (Vector3<f64>, Vec<Point3<f64>>) {
        let (sin, cos) = libm::sincos(turn_rad);
        let across = Vector3::new(sin, cos, 0.0) * 0.05;
        let up = Vector3::z() * 0.05;
        let middle = Point3::new(far_m, 0.0, HEIGHT_M / 2.0);
        (
            Vector3::new(cos, -sin, 0.0),
            vec![middle - across - up, middle + across - up, middle + across + up, middle - across + up],
        )
    }

    /// The open end's light at a point by adding up small pieces of it; those below the point's horizon give nothing.
    fn added_up(x: &Vector3<f64>, away: &Vector3<f64>) -> f64 {
        const STEPS: i32 = 400;
        let place = |i: i32| (f64::from(i) + 0.5) / f64::from(STEPS);
        let mut sum = 0.0;
        for i in 0..STEPS {
            for j in 0..STEPS {
                let way = Vector3::new(0.0, (place(i) - 0.5) * WIDTH_M, place(j) * HEIGHT_M) - x;
                let r2 = way.norm_squared();
                sum += (-away.dot(&way)).max(0.0) * -way.x / (r2 * r2);
            }
        }
        sum * WIDTH_M * HEIGHT_M / f64::from(STEPS * STEPS) / std::f64::consts::PI
    }

    /// As a body's face may be turned: the open end is partly below its horizon.
    #[test]
    fn what_is_below_a_points_horizon_gives_it_no_light() {
        let (scenery, camera_from_world) = (scenery(), Transform::identity());
        let mut passages = Passages::default();
        passages.explore(&scenery, &camera_from_world, 0, REACH_M);
        let mut daylight = Daylight::new(100.0);
        daylight.find(&scenery, &camera_from_world, &passages);
        for turn_rad in [0.0, 1.1, 1.25, 1.4, 1.6, 1.8] {
            let (away, outline) = square(0.5, turn_rad);
            let x = Vector3::new(0.5, 0.0, HEIGHT_M / 2.0);
            let wall = Wall { cell: 0, away, offset_m: away.dot(&x), outline: &outline };
            let mut light = [0.0];
            daylight.shine(&passages, &wall, &mut Vec::new(), std::iter::once(x), &mut light);
            let expected = 100.0 * added_up(&x, &away);
            assert!(expected > 0.05, "there is something to compare");
            // Pieces that the horizon cuts: one in 400 along it.
            let found = f64::from(light[0]);
            assert!((found - expected).abs() < 2e-3 * expected + 1e-3, "turned by {turn_rad}: {found} for {expected}");
        }
    }

    /// What is passed over as too faint is no brighter than it was taken for.
    #[test]
    fn no_point_gets_more_than_the_bound() {
        let scenery = scenery();
        for far_m in [0.1, 0.5, 1.5, 4.5] {
            for turn_rad in [0.0, 0.7, 1.2, 1.5, 1.57] {
                let (away, outline) = square(far_m, turn_rad);
                let wall = Wall { cell: 0, away, offset_m: away.dot(&outline[0].coords), outline: &outline };
                let (mut open, mut spare) = (scenery.rooms[0].grilles[0].outline.clone(), Vec::new());
                clip_top(&mut open, 0, &mut spare, |p| away.dot(&p.coords) - wall.offset_m);
                let most = outline.iter().map(|x| sky_share(&x.coords, &away, &open)).fold(0.0, f64::max);
                let bound = brightest(&wall, &open);
                assert!(most > 0.0 && most <= bound, "{most} beyond {bound}, {far_m} m away, turned by {turn_rad}");
            }
        }
    }
}
