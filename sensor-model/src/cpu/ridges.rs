//! The strips' light in single precision, as [`crate::strip`] defines it: a run of pixels of a row at a time.

use std::ops::Range;

use super::surfaces::single;
use super::tables::Rays;
use crate::light::{FAN_FADE_RAD, FWHM_PER_SIGMA};
use crate::strip::{BOX_PX2, Blur, MirroredWay, SQRT_TAU, Strip};
use crate::vector_math::{angle_of, angle_parts, clamp, exp, max, min, phi_between};

/// Pixels of the longest run.
pub(super) const RUN: usize = 64;

/// A strip in single precision.
#[derive(Clone, Debug)]
pub(super) struct Ridge {
    normal: [f32; 3],
    offset_m: f32,
    ridge: [f32; 3],
    sweep: [f32; 3],
    source: [f32; 3],
    along: [f32; 3],
    across: [f32; 3],
    fan_exponent: f32,
    fan_reach: f32,
    /// Standard deviation across the laser's plane at the source, and its growth with distance.
    sigma_m: [f32; 2],
    /// Cosine of incidence times distance: the same all over the sheet.
    height_m: f32,
    /// Strength, power and what is left of the constants.
    brightness: f32,
    albedo: f32,
    gloss: Gloss,
    mirror: Option<Mirrored>,
    /// Edges, in the geometry's.
    pub(super) edges: Range<usize>,
    /// Edges of a mirror's window.
    pub(super) window: Range<usize>,
    /// Holes, in the geometry's.
    pub(super) holes: Range<usize>,
}

/// The microfacets of a surface.
#[derive(Clone, Copy, Debug)]
struct Gloss {
    specular: f32,
    roughness2: f32,
}

/// A mirror on the light's way.
#[derive(Clone, Copy, Debug)]
struct Mirrored {
    way: MirroredWay,
    normal: [f32; 3],
    /// n . X = o of the mirror, less n . source where the light's way to the sheet is mirrored.
    reach_m: f32,
    lobe: f32,
    specular: f32,
}

/// The lens in single precision.
#[derive(Clone, Copy, Debug)]
pub(super) struct LensBlur {
    psf_px2: f32,
    defocus_px_m: f32,
    focus_1_m: f32,
    focal_px: f32,
    /// cos^4 as c0 + c4 cos^4.
    falloff: [f32; 2],
}

impl LensBlur {
    pub(super) fn new(blur: &Blur) -> Self {
        Self {
            psf_px2: blur.psf_px2 as f32,
            defocus_px_m: blur.defocus_px_m as f32,
            focus_1_m: blur.focus_1_m as f32,
            focal_px: blur.focal_px as f32,
            falloff: if blur.vignetting { [0.0, 1.0] } else { [1.0, 0.0] },
        }
    }

    /// As [`Blur::variance_px2`].
    #[inline(always)]
    pub(super) fn variance_px2(&self, inverse_z: f32) -> f32 {
        let defocus = self.defocus_px_m * (inverse_z - self.focus_1_m);
        self.psf_px2 + defocus * defocus
    }
}

/// A run of pixels on a strip, edges apart.
#[derive(Debug)]
pub(super) struct Run {
    /// Light, in DN.
    pub(super) light: [f32; RUN],
    /// Distance from the ridge, in pixels.
    pub(super) across: [f32; RUN],
    /// The ridge's unit normal.
    pub(super) normal: [[f32; RUN]; 2],
    /// Variance of all together, in px^2.
    pub(super) all2: [f32; RUN],
    /// Variance of what softens the piece's edges.
    pub(super) blur2: [f32; RUN],
    /// Variance of what softens those of a mirror's window; only of mirrored strips.
    pub(super) window2: [f32; RUN],
}

impl Run {
    pub(super) const fn new() -> Self {
        const NONE: [f32; RUN] = [0.0; RUN];
        Self { light: NONE, across: NONE, normal: [NONE; 2], all2: NONE, blur2: NONE, window2: NONE }
    }
}

impl Ridge {
    /// A strip in the light of a laser of this strength (nominal strength times power), in DN m^2; `None` where no light arrives.
    pub(super) fn new(strip: &Strip, strength: f64) -> Option<Self> {
        let normal = strip.plane.normal.into_inner();
        let height_m = strip.plane.offset_m - normal.dot(&strip.source);
        if height_m <= 0.0 || strength <= 0.0 {
            return None;
        }
        let mirror = strip.mirror.map(|mirror| {
            let m = mirror.plane.normal.into_inner();
            let lobe = std::f64::consts::SQRT_2 * mirror.look.roughness;
            let before = match mirror.way {
                MirroredWay::Light => m.dot(&strip.source),
                MirroredWay::View => 0.0,
            };
            Mirrored {
                way: mirror.way,
                normal: single(&m),
                reach_m: (mirror.plane.offset_m - before) as f32,
                lobe: lobe as f32,
                specular: mirror.look.specular as f32,
            }
        });
        Some(Self {
            normal: single(&normal),
            offset_m: strip.plane.offset_m as f32,
            ridge: single(&strip.ridge),
            sweep: single(&strip.sweep),
            source: single(&strip.source),
            along: single(&strip.fan.along),
            across: single(&strip.fan.across),
            fan_exponent: strip.fan.exponent as f32,
            fan_reach: strip.fan.reach_rad as f32,
            sigma_m: [strip.line.width_m, strip.line.growth_rad].map(|w| (w / FWHM_PER_SIGMA) as f32),
            height_m: height_m as f32,
            brightness: (strength * SQRT_TAU / FWHM_PER_SIGMA * height_m) as f32,
            albedo: strip.look.albedo as f32,
            gloss: Gloss {
                specular: strip.look.specular as f32,
                roughness2: (strip.look.roughness * strip.look.roughness) as f32,
            },
            mirror,
            edges: strip.edges.clone(),
            window: strip.window.clone(),
            holes: strip.holes.clone(),
        })
    }

    /// The light of `count` pixels (whole blocks, [`RUN`] at most).
    #[inline(always)]
    pub(super) fn run<const BENT: bool>(&self, lens: &LensBlur, rays: Rays<'_>, count: usize, run: &mut Run) {
        match (self.mirror.map(|mirror| mirror.way), self.gloss.specular > 0.0) {
            (None, false) => self.run_of::<BENT, false, 0>(lens, rays, count, run),
            (None, true) => self.run_of::<BENT, true, 0>(lens, rays, count, run),
            (Some(MirroredWay::Light), _) => self.run_of::<BENT, true, 1>(lens, rays, count, run),
            (Some(MirroredWay::View), _) => self.run_of::<BENT, true, 2>(lens, rays, count, run),
        }
    }

    /// MIRRORED: 0 without a mirror, 1 with one on the light's way to the sheet, 2 with one on the way to the camera.
    #[inline(always)]
    fn run_of<const BENT: bool, const GLOSS: bool, const MIRRORED: u8>(
        &self,
        lens: &LensBlur,
        rays: Rays<'_>,
        count: usize,
        run: &mut Run,
    ) {
        let count = if count < RUN { count } else { RUN };
        let (xs, cosines) = (&rays.x[..count], &rays.cosine[..count]);
        let ys = if BENT { &rays.y[..count] } else { rays.y };
        let [j11, j12, j21, j22] = rays.slopes;
        let (j11, j12, j21, j22) =
            if BENT { (&j11[..count], &j12[..count], &j21[..count], &j22[..count]) } else { (j11, j12, j21, j22) };
        let [nx, ny, nz] = self.normal;
        let [gx, gy, gz] = self.ridge;
        let [wx, wy, wz] = self.sweep;
        let [px, py, pz] = self.source;
        let [ax, ay, az] = self.along;
        let [bx, by, bz] = self.across;
        let [c0, c4] = lens.falloff;
        let mirror =
            self.mirror.unwrap_or(Mirrored { way: MirroredWay::Light, normal: [0.0; 3], reach_m: 1.0, lobe: 0.0, specular: 1.0 });
        let [mx, my, mz] = mirror.normal;
        let Gloss { specular, roughness2 } = self.gloss;
        let offset = self.offset_m;
        let per_offset = 1.0 / offset;
        // Pixels far off the strip may look along its plane or away from it: no light, and no number beyond single precision's.
        let grazing = offset * 1e-5;
        let Run { light, across, normal, all2, blur2, window2 } = run;
        let [normal_u, normal_v] = normal;
        let (light, across) = (&mut light[..count], &mut across[..count]);
        let (normal_u, normal_v) = (&mut normal_u[..count], &mut normal_v[..count]);
        let (all2, blur2, window2) = (&mut all2[..count], &mut blur2[..count], &mut window2[..count]);
        for i in 0..count {
            let (x, y) = (xs[i], if BENT { ys[i] } else { ys[0] });
            let cosine = cosines[i];
            let facing = nx * x + ny * y + nz;
            let approach = max(facing, grazing);
            let per_approach = 1.0 / approach;
            let off_m = (gx * x + gy * y + gz) * per_approach;
            let (dx, dy) = ((gx - nx * off_m) * per_approach, (gy - ny * off_m) * per_approach);
            let (slope_u, slope_v) =
                if BENT { (j11[i] * dx + j21[i] * dy, j12[i] * dx + j22[i] * dy) } else { (j11[0] * dx, j22[0] * dy) };
            let steepness = (slope_u * slope_u + slope_v * slope_v + 1e-30).sqrt();

            let z = offset * per_approach;
            let (way_x, way_y, way_z) = (x * z - px, y * z - py, z - pz);
            let distance2 = way_x * way_x + way_y * way_y + way_z * way_z;
            let distance = distance2.sqrt();
            // One division for two: it costs as much as ten multiplications.
            let both = 1.0 / (steepness * distance);
            let (flatness, per_distance) = (both * distance, both * steepness);
            let sigma_m = self.sigma_m[0] + self.sigma_m[1] * distance;
            let lens_px2 = lens.variance_px2(approach * per_offset);
            let (mut lobe_m, mut lobe_px) = (0.0, 0.0);
            let mut mirrored = 1.0;
            if MIRRORED == 1 {
                let along = mx * way_x + my * way_y + mz * way_z;
                lobe_m = mirror.lobe * distance * (1.0 - clamp(mirror.reach_m / along, 0.0, 1.0));
                mirrored = fresnel(mirror.specular, along.abs() * per_distance);
            }
            if MIRRORED == 2 {
                let along = mx * x + my * y + mz;
                lobe_px = mirror.lobe * lens.focal_px * (1.0 - clamp(mirror.reach_m / (along * z), 0.0, 1.0));
                mirrored = fresnel(mirror.specular, along.abs() * cosine);
            }
            let sigma_px2 = (sigma_m * sigma_m + lobe_m * lobe_m) * (flatness * flatness);
            let after_px2 = lens_px2 + lobe_px * lobe_px;
            let moved_px = (wx * x + wy * y + wz) * per_approach * flatness;
            let (inward_u, inward_v) = (slope_u * flatness, slope_v * flatness);
            let (extent_u, extent_v) = (inward_u.abs(), inward_v.abs());
            let (narrow, wide) = (min(extent_u, extent_v), max(extent_u, extent_v));
            let spread_px2 = sigma_px2 + after_px2 + (moved_px * moved_px + narrow * narrow) * BOX_PX2 as f32;
            let spread_px = spread_px2.sqrt();
            let a = off_m * flatness;
            let half = 0.5 * wide;

            let forward = ax * way_x + ay * way_y + az * way_z;
            let sideways = bx * way_x + by * way_y + bz * way_z;
            let (low, high, steep) = angle_parts(sideways, max(forward, 1e-6));
            let both = 1.0 / (spread_px * high);
            let per_spread = both * high;
            let turn = angle_of(sideways, steep, low * (both * spread_px));
            let integral = phi_between((a - half) * per_spread, (a + half) * per_spread, wide);
            let fade = clamp(1.0 - (turn.abs() - self.fan_reach) * (1.0 / FAN_FADE_RAD) as f32, 0.0, 1.0);
            let fan = exp(self.fan_exponent * (turn * turn)) * fade;

            let mut reflectance = self.albedo;
            if GLOSS {
                let (lx, ly, lz) = (way_x * per_distance, way_y * per_distance, way_z * per_distance);
                let (vx, vy, vz) = (x * cosine, y * cosine, cosine);
                let (hx, hy, hz) = (lx + vx, ly + vy, lz + vz);
                let length2 = max(hx * hx + hy * hy + hz * hz, 1e-12);
                let (cx, cy, cz) = (ny * hz - nz * hy, nz * hx - nx * hz, nx * hy - ny * hx);
                let facing = nx * hx + ny * hy + nz * hz;
                // Times the square of the length of h, as is its power of two below.
                let spread = (cx * cx + cy * cy + cz * cz) + facing * facing * roughness2;
                let cos_light = self.height_m * per_distance;
                let cos_view = approach * cosine;
                let shadowed = |c: f32| (c * c * (1.0 - roughness2) + roughness2).sqrt();
                // 2 V's inverse.
                let hidden = cos_light * shadowed(cos_view) + cos_view * shadowed(cos_light);
                let half_angle = (0.25 * length2).sqrt();
                let lobe = 0.5 * roughness2 * (length2 * length2) / (spread * spread * hidden);
                let gloss = lobe * fresnel(specular, half_angle);
                reflectance += if specular > 0.0 { gloss } else { 0.0 };
            }
            let square = cosine * cosine;
            let falloff = c0 + c4 * (square * square);
            let lit = if forward > 0.0 { facing > grazing } else { false };
            let strength = self.brightness * mirrored * fan * reflectance * falloff;
            let value = strength * (per_distance * per_distance) * flatness * integral;

            light[i] = if lit { value } else { 0.0 };
            across[i] = a;
            normal_u[i] = inward_u;
            normal_v[i] = inward_v;
            all2[i] = sigma_px2 + after_px2 + BOX_PX2 as f32;
            blur2[i] = after_px2 + BOX_PX2 as f32;
            if MIRRORED != 0 {
                window2[i] = lens_px2 + (lobe_m * lobe_m) * (flatness * flatness) + BOX_PX2 as f32;
            }
        }
    }
}

/// As [`crate::surface::Look::fresnel`].
#[inline(always)]
fn fresnel(specular: f32, cosine: f32) -> f32 {
    let miss = max(1.0 - cosine, 0.0);
    let square = miss * miss;
    specular + (1.0 - specular) * (square * square * miss)
}
