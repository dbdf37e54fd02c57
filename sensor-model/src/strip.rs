//! The light of one laser on one flat piece of surface, as the camera sees it: position, width, brightness, edges.
//!
//! This is the model in double precision, one pixel at a time; both renderers do the same in single precision. With the pixel's
//! ray r = (x, y, 1), the surface n . X = o and the laser's plane l . X = L (camera frame, n . r and o positive), the pixel sees
//! the point X = r o / (n . r), which is off the laser's plane by
//!
//! ```text
//! d = l . X - L = (g . r) / (n . r),      g = o l - L n
//! ```
//!
//! g is a straight line in the image, the stripe's middle. The gradient of d in the image turns metres into pixels: the stripe's
//! Gaussian of standard deviation `sigma_w` (metres, across the laser's plane) is one of s = `sigma_w` / |grad d| pixels at a distance
//! a = d / |grad d| from its middle. Spread by the lens, blurred by motion and integrated over the pixel it becomes
//!
//! ```text
//! E sqrt(2 pi) s [Phi((a + b) / q) - Phi((a - b) / q)] / (2 b),    q^2 = s^2 + p^2 + motion^2 / 12 + c^2 / 12
//! ```
//!
//! where 2 b and c are the larger and the smaller of |n_u|, |n_v|, the extents across the stripe of the pixel's two sides: the larger
//! is integrated exactly, so that a column (or row) of pixels holds all the light wherever between two pixels a thin stripe
//! falls. E is the light on the middle of the stripe before the lens (see `light`), times the surface's reflectance B (see
//! `surface`) and the lens' cos^4.

use std::ops::Range;

use ductloop_duct::cell::Plane;
use ductloop_nav::rig::LineWidth;
use nalgebra::{Matrix2, Vector2, Vector3};

use crate::coverage::{Edge, Ridge, phi};
use crate::lens::Projection;
use crate::light::{FWHM_PER_SIGMA, Fan};
use crate::optics::Lens;
use crate::surface::Look;

/// The light of a laser on a piece of a sheet, all in the camera's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Strip {
    /// Which laser.
    pub laser: usize,
    /// The sheet's plane, or its mirror image.
    pub plane: Plane,
    /// g, in metres.
    pub ridge: Vector3<f64>,
    /// Change of g during the exposure.
    pub sweep: Vector3<f64>,
    /// Where the light comes from: the laser's source, or its mirror image.
    pub source: Vector3<f64>,
    /// How it is spread along the fan.
    pub fan: Fan,
    /// How it widens.
    pub line: LineWidth,
    /// What it falls on.
    pub look: Look,
    /// A mirror on its way.
    pub mirror: Option<Mirror>,
    /// The piece's edges near the stripe, in [`crate::frame_geometry::FrameGeometry::edges`].
    pub edges: Range<usize>,
    /// The edges of the part of the mirror through which the light comes, likewise; none without a mirror. Their softness is
    /// [`StripAt::window`]'s.
    pub window: Range<usize>,
    /// What is in the way of its light or in front of it, in [`crate::frame_geometry::FrameGeometry::holes`].
    pub holes: Range<usize>,
    /// Where in the image it is, in [`crate::frame_geometry::FrameGeometry::band`].
    pub band: Range<usize>,
}

/// A wall that mirrors the light: spread by its roughness, weakened by Fresnel's law.
///
/// A microfacet's slope has a variance of about roughness^2 / 2 along each axis (Beckmann's, near enough to GGX in the middle of
/// the lobe), and turns the mirrored ray by twice its own angle: the lobe's standard deviation is taken as sqrt(2) roughness in all
/// directions. Light that the wall shines on besides mirroring is in the strip of the wall itself.
///
/// The lobe's spread, in pixels at the strip, softens what is cut off on the far side of the mirror, and nothing on the near side: seen
/// mirrored (`View`), the piece's own edges are soft and the mirror's outline is sharp; lit by a mirror (`Light`), the piece's edges are
/// sharp and those of the mirror's light are soft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    /// Its plane; the normal points away from the camera.
    pub plane: Plane,
    /// What it looks like.
    pub look: Look,
    /// Which way is mirrored.
    pub way: MirroredWay,
}

impl Mirror {
    /// The lobe's standard deviation, in radians.
    pub fn lobe_rad(&self) -> f64 {
        std::f64::consts::SQRT_2 * self.look.roughness
    }
}

/// Which part of the light's way a wall mirrors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MirroredWay {
    /// From the laser: source, plane and fan are mirror images.
    Light,
    /// To the camera: the sheet, source, plane and fan are mirror images.
    View,
}

/// The lens as strips need it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blur {
    /// Variance of the point spread in focus, in px^2.
    pub psf_px2: f64,
    /// Standard deviation of the circle of confusion for each 1/m that the inverse distance is off the focus: a disc of diameter
    /// `aperture focal |1/z - 1/focus|` has a quarter of that along each axis.
    pub defocus_px_m: f64,
    /// Inverse of the distance in focus.
    pub focus_1_m: f64,
    /// Pixels a radian in the middle of the image.
    pub focal_px: f64,
    /// Whether the light falls off with cos^4.
    pub vignetting: bool,
}

/// A pixel as the model sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelRay {
    /// (x, y, 1).
    pub ray: Vector3<f64>,
    /// Derivative of (x, y) by the pixel.
    pub rays_per_pixel: Matrix2<f64>,
}

/// A strip at a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StripAt {
    /// Distance from the middle and what the edges, [`Strip::edges`], need; holes likewise.
    pub ridge: Ridge,
    /// The same for the edges of the mirror's window, [`Strip::window`].
    pub window: Ridge,
    /// Standard deviation before the lens, s, in pixels.
    pub sigma_px: f64,
    /// q, in pixels.
    pub spread_px: f64,
    /// Light on the stripe's middle before the lens for a laser of strength 1 DN m^2, times reflectance and cos^4.
    pub peak: f64,
}

impl PixelRay {
    /// Of the pixel that sees the ray (x, y, 1).
    pub fn of(projection: &Projection, xy: Vector2<f64>) -> Self {
        Self { ray: Vector3::new(xy.x, xy.y, 1.0), rays_per_pixel: projection.rays_per_pixel(xy.into()) }
    }
}

impl Blur {
    /// Of a lens with this focal length in pixels.
    pub fn new(lens: &Lens, focal_px: [f64; 2]) -> Self {
        let focal_px = (focal_px[0] * focal_px[1]).sqrt();
        Self {
            psf_px2: lens.psf_sigma_px * lens.psf_sigma_px,
            defocus_px_m: lens.aperture_m * focal_px / 4.0,
            focus_1_m: 1.0 / lens.focus_m,
            focal_px,
            vignetting: lens.vignetting,
        }
    }

    /// Variance of lens and defocus for what is seen at z = 1 / `inverse_z`, in px^2.
    pub fn variance_px2(&self, inverse_z: f64) -> f64 {
        let defocus = self.defocus_px_m * (inverse_z - self.focus_1_m);
        self.psf_px2 + defocus * defocus
    }

    /// Share of the light that the lens passes along a ray: cos^4 of its angle from the axis.
    pub fn falloff(&self, ray: &Vector3<f64>) -> f64 {
        let square = 1.0 / ray.norm_squared();
        if self.vignetting { square * square } else { 1.0 }
    }
}

/// Variance of a pixel's side of unit length.
pub const BOX_PX2: f64 = 1.0 / 12.0;

impl Strip {
    /// Light that arrives at a pixel, for a laser of strength 1 DN m^2 (see [`crate::light::laser_strength`]).
    pub fn light(&self, pixel: &PixelRay, blur: &Blur, edges: &[Edge], holes: &[Range<usize>]) -> f64 {
        let at = self.at(pixel, blur);
        let normal = at.ridge.normal.abs();
        let half = normal.max() / 2.0;
        let a = at.ridge.across_px;
        let integral = phi((a + half) / at.spread_px) - phi((a - half) / at.spread_px);
        let ridge = at.peak * SQRT_TAU * at.sigma_px * integral / (2.0 * half);
        let share =
            |ridge: &Ridge, range: &Range<usize>| ridge.coverage(&edges[range.clone()], &pixel.ray, &pixel.rays_per_pixel);
        let whole = ridge * share(&at.ridge, &self.edges) * share(&at.window, &self.window);
        holes[self.holes.clone()].iter().fold(whole, |light, hole| light * (1.0 - share(&at.ridge, hole)))
    }

    /// What the strip is like at a pixel, edges apart.
    pub fn at(&self, pixel: &PixelRay, blur: &Blur) -> StripAt {
        let PixelRay { ray, rays_per_pixel } = pixel;
        let normal = self.plane.normal.into_inner();
        let approach = normal.dot(ray);
        let off_m = self.ridge.dot(ray) / approach;
        let slope = rays_per_pixel.tr_mul(&((self.ridge.xy() - normal.xy() * off_m) / approach));
        let steepness = slope.norm();

        let point = ray * (self.plane.offset_m / approach);
        let way = point - self.source;
        let distance_m = way.norm();
        let sigma_m = self.line.at(distance_m) / FWHM_PER_SIGMA;
        // What the mirror's lobe adds: to the light's thickness in metres, or to the lens' blur in pixels.
        let (mut lobe_m, mut lobe_px) = (0.0, 0.0);
        let mut mirrored = 1.0;
        if let Some(mirror) = &self.mirror {
            let m = mirror.plane.normal.into_inner();
            let lobe = mirror.lobe_rad();
            // `before` is the share of the way up to the mirror; it is cut off where there is no light, beyond the mirror's window.
            match mirror.way {
                MirroredWay::Light => {
                    let before = ((mirror.plane.offset_m - m.dot(&self.source)) / m.dot(&way)).clamp(0.0, 1.0);
                    lobe_m = lobe * distance_m * (1.0 - before);
                    mirrored = mirror.look.fresnel(m.dot(&way).abs() / distance_m);
                }
                MirroredWay::View => {
                    let before = (mirror.plane.offset_m / m.dot(&point)).clamp(0.0, 1.0);
                    lobe_px = lobe * blur.focal_px * (1.0 - before);
                    mirrored = mirror.look.fresnel(m.dot(ray).abs() / ray.norm());
                }
            }
        }
        let wide_m = (sigma_m * sigma_m + lobe_m * lobe_m).sqrt();
        let sigma_px = wide_m / steepness;
        let moved_px = self.sweep.dot(ray) / (approach * steepness);
        let inward = slope / steepness;
        let narrow = inward.x.abs().min(inward.y.abs());
        let lens_px2 = blur.variance_px2(1.0 / point.z);
        let after_px2 = lens_px2 + lobe_px * lobe_px;
        let spread_px2 = sigma_px * sigma_px + after_px2 + (moved_px * moved_px + narrow * narrow) * BOX_PX2;
        // The edges' softness: what blurs the light after it has passed them.
        let all_px2 = sigma_px * sigma_px + after_px2 + BOX_PX2;
        let across_px = off_m / steepness;
        let softened =
            |blur_px2: f64| Ridge { across_px, normal: inward, share: 1.0 - blur_px2 / all_px2, blur_px: blur_px2.sqrt() };
        let before_lens_m = lobe_m / steepness;
        StripAt {
            ridge: softened(after_px2 + BOX_PX2),
            window: softened(lens_px2 + before_lens_m * before_lens_m + BOX_PX2),
            sigma_px,
            spread_px: spread_px2.sqrt(),
            peak: mirrored * self.reflected(&way, distance_m, ray) * blur.falloff(ray) / (distance_m * wide_m * FWHM_PER_SIGMA),
        }
    }

    /// Fan, incidence and reflectance.
    fn reflected(&self, way: &Vector3<f64>, distance_m: f64, ray: &Vector3<f64>) -> f64 {
        let normal = self.plane.normal.into_inner();
        let cos_light = normal.dot(way) / distance_m;
        if cos_light <= 0.0 {
            return 0.0;
        }
        let angle = libm::atan2(self.fan.across.dot(way), self.fan.along.dot(way));
        let inverse = 1.0 / ray.norm();
        let cos_view = normal.dot(ray) * inverse;
        // Both directions point away from the wall's visible side; halfway between them all signs cancel.
        let half = (way / distance_m + ray * inverse).normalize();
        let reflectance = self.look.reflectance(cos_light, cos_view, normal.dot(&half), half.dot(ray) * inverse);
        self.fan.profile(angle) * cos_light * reflectance
    }
}

/// sqrt(2 pi).
pub const SQRT_TAU: f64 = 2.506_628_274_631_000_2;
