//! Where in the image a strip is: a polyline along its middle, and how far to each side its light reaches.
//!
//! A stripe on a flat sheet is a straight line before the lens: it is walked from end to end, not searched for.

use nalgebra::{Point3, Vector2, Vector3};

use crate::lens::Projection;
use crate::strip::{Blur, PixelRay, Strip, StripAt};

/// A place on the middle of a strip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BandPoint {
    /// Its pixel.
    pub pixel: Vector2<f64>,
    /// Unit normal of the band there.
    pub normal: Vector2<f64>,
    /// Half its thickness, in pixels: beyond, the strip gives no light.
    pub half_px: f64,
}

impl BandPoint {
    /// The band's two borders here.
    pub fn borders(&self) -> [Vector2<f64>; 2] {
        [self.pixel + self.normal * self.half_px, self.pixel - self.normal * self.half_px]
    }
}

/// Longest step along the band, in pixels before distortion.
const STEP_PX: f64 = 16.0;
/// Most steps; a strip that is longer leaves the image.
const STEPS_MAX: usize = 128;
/// Nearest distance along the view that a strip's middle is followed to, in metres.
const NEAR_M: f64 = 1e-3;
/// Thickest half of a band, in pixels: more than any image.
const HALF_MAX_PX: f64 = 4096.0;

/// The part of a strip's middle that is lit and in front of the camera: a straight line of rays (x, y).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Middle {
    /// One end.
    pub first: Vector2<f64>,
    /// The other.
    pub last: Vector2<f64>,
}

impl Middle {
    /// Of a strip whose lit part, in the camera's frame, has the outline `piece`; `laser` is the normal of the laser's plane. None where
    /// there is nothing in front of the camera, or the laser's plane runs along the sheet.
    pub fn new(strip: &Strip, piece: &[Point3<f64>], laser: &Vector3<f64>) -> Option<Self> {
        let normal = strip.plane.normal.into_inner();
        // The stripe's middle in space, from where it is nearest to the camera's centre.
        let along = normal.cross(laser).try_normalize(1e-9)?;
        let (origin, along) = middle_line(strip, laser, &along)?;
        let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
        for point in piece {
            let at = (point.coords - origin).dot(&along);
            (from, to) = (from.min(at), to.max(at));
        }
        // Only what is in front of the camera.
        if along.z.abs() > 1e-12 {
            let near = (NEAR_M - origin.z) / along.z;
            if along.z > 0.0 { from = from.max(near) } else { to = to.min(near) }
        } else if origin.z < NEAR_M {
            return None;
        }
        let ray = |at: f64| {
            let point = origin + along * at;
            Vector2::new(point.x / point.z, point.y / point.z)
        };
        (from <= to).then(|| Self { first: ray(from), last: ray(to) })
    }

    /// The ray at a share of the way from the first end to the last.
    pub fn at(&self, share: f64) -> Vector2<f64> {
        self.first + (self.last - self.first) * share
    }

    /// Length in the image, in pixels before distortion.
    pub fn length_px(&self, projection: &Projection) -> f64 {
        let [fx, fy] = projection.camera.focal_px;
        let way = self.last - self.first;
        Vector2::new(way.x * fx, way.y * fy).norm()
    }

    /// Appends the band along it, with its light followed to so many standard deviations to each side as `reach` says. Returns whether any
    /// of it is in the image.
    pub fn lay(
        &self,
        strip: &Strip,
        reach: impl Fn(&StripAt) -> f64,
        projection: &Projection,
        blur: &Blur,
        band: &mut Vec<BandPoint>,
    ) -> bool {
        let steps = ((self.length_px(projection) / STEP_PX).ceil() as usize).clamp(1, STEPS_MAX);
        let start = band.len();
        let mut soft_px = [0.0; 2];
        for i in 0..=steps {
            let xy = self.at(i as f64 / steps as f64);
            let at = strip.at(&PixelRay::of(projection, xy), blur);
            let reach = reach(&at);
            // The gradient changes across the stripe, by a quarter at the very most within its light; and a pixel for the pixel's own size.
            let half_px = (1.25 * reach * at.spread_px + 1.0).min(HALF_MAX_PX);
            band.push(BandPoint { pixel: projection.pixel(xy.into()).into(), normal: at.ridge.normal, half_px });
            soft_px[usize::from(i > 0)] = (reach * at.ridge.blur_px.max(at.window.blur_px) + 2.0).min(HALF_MAX_PX);
        }
        stretch_ends(&mut band[start..], soft_px);
        square_up(&mut band[start..]);
        is_in_view(&band[start..], projection)
    }
}

/// A point of the line where the sheet and the laser's plane meet, the one nearest to the camera, and the line's unit direction.
fn middle_line(strip: &Strip, laser: &Vector3<f64>, along: &Vector3<f64>) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let normal = strip.plane.normal.into_inner();
    let offset_m = strip.plane.offset_m;
    // g = o l - L n gives the laser's offset L back along n.
    let laser_offset_m = (laser * offset_m - strip.ridge).dot(&normal);
    let cosine = normal.dot(laser);
    let determinant = 1.0 - cosine * cosine;
    if determinant < 1e-12 {
        return None;
    }
    let a = (offset_m - laser_offset_m * cosine) / determinant;
    let b = (laser_offset_m - offset_m * cosine) / determinant;
    Some((normal * a + laser * b, *along))
}

/// Moves the ends outward, by so much each, to where the lens (or a mirror) spreads light beyond them.
fn stretch_ends(band: &mut [BandPoint], reach_px: [f64; 2]) {
    let count = band.len();
    let Some(along) = (band[count - 1].pixel - band[0].pixel).try_normalize(1e-9) else {
        // A strip that is seen end on, or nearly: a square about it.
        let across = Vector2::new(-band[0].normal.y, band[0].normal.x);
        let half_px = band[0].half_px;
        band[0].pixel -= across * half_px;
        band[count - 1].pixel += across * half_px;
        return;
    };
    let forward = if count > 2 { (band[1].pixel - band[0].pixel).normalize() } else { along };
    let backward = if count > 2 { (band[count - 2].pixel - band[count - 1].pixel).normalize() } else { -along };
    band[0].pixel -= forward * reach_px[0];
    band[count - 1].pixel -= backward * reach_px[1];
}

/// Turns the normals square to the band's own direction, all to the same side.
fn square_up(band: &mut [BandPoint]) {
    for i in 0..band.len() {
        let (before, after) = (i.saturating_sub(1), (i + 1).min(band.len() - 1));
        if let Some(along) = (band[after].pixel - band[before].pixel).try_normalize(1e-12) {
            band[i].normal = Vector2::new(-along.y, along.x);
        }
    }
}

fn is_in_view(band: &[BandPoint], projection: &Projection) -> bool {
    let borders = || band.iter().flat_map(BandPoint::borders);
    let spans = |axis: usize, pixels: usize| {
        let low = borders().map(|p| p[axis]).fold(f64::INFINITY, f64::min);
        let high = borders().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max);
        high > -0.5 && low < pixels as f64 - 0.5
    };
    spans(0, projection.camera.width_px) && spans(1, projection.camera.height_px)
}
