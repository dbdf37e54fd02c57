//! An exposure with a moving camera, divided into parts so short that what they blur is blurred right.
//!
//! Within a part, a stripe's middle moves by a fraction of its own width, which its closed form takes as variance; edges and shadows
//! stand still where they are in the part's middle. So the number of parts is the number of
//! pixels that anything of this kind moves in the image during the exposure, end to end. What moves along itself does not count: the
//! edges of a straight duct, and stripes, seen by a robot that drives along it. Nor do seams and spangles, whose closed forms hold for
//! any motion.
//!
//! The light of a frame is the mean of its parts' light. Left out: the parts' number is limited, so that what moves farther than
//! [`PARTS_MAX`] pixels is seen as so many pictures beside each other; and motion is at constant speed.

use nalgebra::{Point3, Translation3, UnitQuaternion, Vector2, Vector3};

use crate::Transform;
use crate::frame_geometry::{FrameGeometry, Region, Sweep};
use crate::optics::Lens;
use crate::renderer::View;
use crate::strip::Strip;

/// Most parts of an exposure.
pub const PARTS_MAX: usize = 32;

/// Motion during a part, in pixels: as a box it has a variance of 1/12 px^2, a quarter of the sharpest lens' and pixel's own.
const PART_PX: f64 = 1.0;

/// Turning during an exposure from which on end to end says nothing about the way between, in radians.
const TURN_MAX_RAD: f64 = 1.0;

/// The parts of an exposure, in order; all are equally long.
#[derive(Clone, Debug)]
pub struct Parts {
    view: View,
    exposure_s: f64,
    count: usize,
    next: usize,
}

/// The whole exposure as one sweep: what the geometry is built for that [`parts`] looks at.
pub fn whole(view: &View, lens: &Lens) -> Sweep {
    let exposure_s = blurred_s(view, lens);
    if exposure_s == 0.0 {
        return Sweep::still(view.world_from_camera);
    }
    sweep(view, -exposure_s / 2.0, exposure_s / 2.0)
}

/// The parts of an exposure, of which `geometry`, built for the [`whole`], shows what moves how far. A single part is the whole, and
/// needs no other geometry.
pub fn parts(view: &View, lens: &Lens, geometry: &FrameGeometry) -> Parts {
    let exposure_s = blurred_s(view, lens);
    let count = if exposure_s == 0.0 { 1 } else { count(view, exposure_s, geometry) };
    Parts { view: view.clone(), exposure_s, count, next: 0 }
}

impl Iterator for Parts {
    type Item = Sweep;

    fn next(&mut self) -> Option<Sweep> {
        if self.next == self.count {
            return None;
        }
        self.next += 1;
        if self.exposure_s == 0.0 {
            return Some(Sweep::still(self.view.world_from_camera));
        }
        let at = |part: usize| self.exposure_s * (part as f64 / self.count as f64 - 0.5);
        Some(sweep(&self.view, at(self.next - 1), at(self.next)))
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = self.count - self.next;
        (left, Some(left))
    }
}

impl ExactSizeIterator for Parts {}

/// Time during which motion blurs: none for a camera at rest.
fn blurred_s(view: &View, lens: &Lens) -> f64 {
    let moves = view.motion.linear_m_s != Vector3::zeros() || view.motion.angular_rad_s != Vector3::zeros();
    if lens.motion_blur && moves { view.exposure_s } else { 0.0 }
}

/// Poses between two times, in seconds from the middle of the exposure.
fn sweep(view: &View, from_s: f64, to_s: f64) -> Sweep {
    let at = |time_s: f64| {
        let Transform { rotation, translation } = view.world_from_camera;
        let turned = UnitQuaternion::from_scaled_axis(view.motion.angular_rad_s * time_s) * rotation;
        Transform::from_parts(Translation3::from(translation.vector + view.motion.linear_m_s * time_s), turned)
    };
    Sweep { world_from_first: at(from_s), world_from_camera: at((from_s + to_s) / 2.0), world_from_last: at(to_s) }
}

fn count(view: &View, exposure_s: f64, geometry: &FrameGeometry) -> usize {
    if view.motion.angular_rad_s.norm() * exposure_s > TURN_MAX_RAD {
        return PARTS_MAX;
    }
    let whole = sweep(view, -exposure_s / 2.0, exposure_s / 2.0);
    let way = Way {
        first_from_camera: whole.world_from_first.inverse() * whole.world_from_camera,
        last_from_camera: whole.world_from_last.inverse() * whole.world_from_camera,
        focal_px: geometry.projection().camera.focal_px.into(),
    };
    let mut most_px = 0.0_f64;
    for strip in &geometry.strips {
        for point in &geometry.band[strip.band.clone()] {
            let [x, y] = geometry.projection().ray(point.pixel.into());
            most_px = most_px.max(way.ridge_px(strip, &Vector3::new(x, y, 1.0)));
        }
    }
    let borders = Borders::of(&geometry.corners);
    for region in &geometry.regions {
        let corners = &geometry.corners[region.outline.clone()];
        for (i, a) in corners.iter().enumerate() {
            let b = &corners[(i + 1) % corners.len()];
            let moved_px = way.edge_px(a, b);
            // What cannot be more than is known already, or makes no second part, is not looked at closely.
            if moved_px > most_px.max(PART_PX) && !borders.hold(a, b) && !is_invisible(geometry, region, a, b) {
                most_px = moved_px;
            }
        }
        if most_px >= PART_PX * PARTS_MAX as f64 {
            return PARTS_MAX;
        }
    }
    ((most_px / PART_PX).ceil() as usize).clamp(1, PARTS_MAX)
}

/// The camera's way during the exposure.
struct Way {
    first_from_camera: Transform,
    last_from_camera: Transform,
    focal_px: Vector2<f64>,
}

impl Way {
    /// How a point moves in the image, in pixels before distortion; infinitely far where it passes the camera.
    fn point_px(&self, point: &Point3<f64>) -> Vector2<f64> {
        /// Nearest distance along the view at which points are seen, in metres.
        const NEAR_M: f64 = 1e-3;
        let (first, last) = (self.first_from_camera * point, self.last_from_camera * point);
        if first.z < NEAR_M || last.z < NEAR_M {
            return Vector2::repeat(f64::INFINITY);
        }
        (last.xy() / last.z - first.xy() / first.z).component_mul(&self.focal_px)
    }

    /// How far an edge moves across itself, on its faster end.
    fn edge_px(&self, a: &Point3<f64>, b: &Point3<f64>) -> f64 {
        let along = (b.xy() / b.z - a.xy() / a.z).component_mul(&self.focal_px);
        let Some(along) = along.try_normalize(1e-9) else { return 0.0 };
        let across = |p: &Point3<f64>| {
            let moved = self.point_px(p);
            if moved.x.is_finite() { (along.x * moved.y - along.y * moved.x).abs() } else { f64::INFINITY }
        };
        across(a).max(across(b))
    }

    /// How far a stripe's middle moves across itself, at a ray.
    fn ridge_px(&self, strip: &Strip, ray: &Vector3<f64>) -> f64 {
        let normal = strip.plane.normal.into_inner();
        let off_m = strip.ridge.dot(ray) / normal.dot(ray);
        let slope = (strip.ridge.xy() - normal.xy() * off_m).component_div(&self.focal_px);
        let moved_px = (strip.sweep.dot(ray) / slope.norm()).abs();
        // No slope: the whole stripe is seen end on.
        if moved_px.is_finite() { moved_px } else { 0.0 }
    }
}

/// The extreme rays of all that is seen: the edges that lie on them are cut there, and move with the camera.
struct Borders {
    low: Vector2<f64>,
    high: Vector2<f64>,
}

impl Borders {
    fn of(corners: &[Point3<f64>]) -> Self {
        let mut borders = Self { low: Vector2::repeat(f64::INFINITY), high: Vector2::repeat(f64::NEG_INFINITY) };
        for ray in corners.iter().map(|p| p.coords.xy() / p.z) {
            (borders.low, borders.high) = (borders.low.inf(&ray), borders.high.sup(&ray));
        }
        borders
    }

    fn hold(&self, a: &Point3<f64>, b: &Point3<f64>) -> bool {
        /// Rounding of a clipped corner, in the tangent of an angle: a millionth of a pixel.
        const ROUNDING: f64 = 1e-9;
        let (a, b) = (a.xy() / a.z, b.xy() / b.z);
        let both_at = |axis: usize, end: f64| (a[axis] - end).abs() < ROUNDING && (b[axis] - end).abs() < ROUNDING;
        (0..2).any(|axis| both_at(axis, self.low[axis]) || both_at(axis, self.high[axis]))
    }
}

/// Whether a region's edge shows nothing: beyond it the same surface goes on in the same plane. A seam that runs along it is blurred
/// on both sides alike.
fn is_invisible(geometry: &FrameGeometry, region: &Region, a: &Point3<f64>, b: &Point3<f64>) -> bool {
    /// Distance up to which a point is on an edge, in metres.
    const SAME_M: f64 = 1e-7;
    let middle = nalgebra::center(a, b);
    let goes_on = |other: &Region| std::ptr::from_ref(other) != std::ptr::from_ref(region) && other.goes_on_in(region);
    let touches = |other: &Region| {
        let corners = &geometry.corners[other.outline.clone()];
        corners.iter().enumerate().any(|(i, c)| {
            let d = &corners[(i + 1) % corners.len()];
            let along = d - c;
            let share = (middle - c).dot(&along) / along.norm_squared();
            (0.0..=1.0).contains(&share) && (middle - (c + along * share)).norm() < SAME_M
        })
    };
    geometry.regions.iter().any(|other| goes_on(other) && touches(other))
}
