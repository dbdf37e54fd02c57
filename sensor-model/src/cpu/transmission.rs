//! What seams and spangle leave of a region's light, pixel by pixel.

use nalgebra::Vector3;

use super::ridges::{LensBlur, RUN};
use super::surfaces::{Spangle, Surface, single};
use super::tables::Rays;
use crate::frame_geometry::Seam;
use crate::noise::{SPANGLE_SLOPE2, SPANGLE_STEP, spangle_node};
use crate::strip::BOX_PX2;
use crate::vector_math::{clamp, exp, floor, max, phi};

/// A shorter way, in pixels, is taken as this one, so that nothing is divided by 0; what it adds to the variance, at most 0.02 px^2,
/// is taken from the pixel's own.
const WAY_MIN_PX: f32 = 0.5;

/// Distance of Gauss' two places from the middle of a part, 1 / (2 sqrt 3) of it.
const GAUSS: f32 = 0.288_675_13;

/// 1 / sqrt(2 pi).
const PHI_0: f32 = 0.398_942_3;

/// Multiplies `share` by what a seam leaves.
#[inline(always)]
pub(super) fn seam<const BENT: bool>(surface: &Surface, seam: &Seam, lens: &LensBlur, rays: Rays<'_>, share: &mut [f32]) {
    let count = if share.len() < RUN { share.len() } else { RUN };
    let share = &mut share[..count];
    let xs = &rays.x[..count];
    let ys = if BENT { &rays.y[..count] } else { rays.y };
    let [j11, j12, j21, j22] = rays.slopes;
    let (j11, j12, j21, j22) =
        if BENT { (&j11[..count], &j12[..count], &j21[..count], &j22[..count]) } else { (j11, j12, j21, j22) };
    let [ax, ay, az] = surface.inverse_depth;
    let per_offset = 1.0 / surface.offset_m;
    let [gx, gy, gz] = single(&seam.ridge).map(|g| g * per_offset);
    let [vx, vy, vz] = single(&seam.sweep).map(|v| v * per_offset);
    let moves = seam.sweep != Vector3::zeros();
    let half_m = (seam.width_m / 2.0) as f32;
    for i in 0..count {
        let (x, y) = (xs[i], if BENT { ys[i] } else { ys[0] });
        // With both over the offset, n . r becomes 1/z.
        let near = max(ax * x + ay * y + az, 1e-6);
        let z = 1.0 / near;
        let off_m = (gx * x + gy * y + gz) * z;
        let (dx, dy) = ((gx - ax * off_m) * z, (gy - ay * off_m) * z);
        let (slope_u, slope_v) =
            if BENT { (j11[i] * dx + j21[i] * dy, j12[i] * dx + j22[i] * dy) } else { (j11[0] * dx, j22[0] * dy) };
        let flatness = 1.0 / (slope_u * slope_u + slope_v * slope_v + 1e-30).sqrt();
        let blur2 = lens.variance_px2(near) + BOX_PX2 as f32;
        let (a, h) = (off_m * flatness, half_m * flatness);
        if moves {
            let moved = ((vx * x + vy * y + vz) * z * flatness).abs();
            let way = max(moved, WAY_MIN_PX);
            let blur2 = blur2 - (way * way - moved * moved) * BOX_PX2 as f32;
            share[i] *= 1.0 - smeared(a, h, way, blur2);
        } else {
            let per_blur = 1.0 / blur2.sqrt();
            share[i] *= 1.0 - (phi((a + h) * per_blur) - phi((a - h) * per_blur));
        }
    }
}

/// What a gap of half width `h` takes at the distance `a` from its middle, blurred with the variance `blur2` and along `way`: the
/// difference of Phi, averaged over the way. The integral of Phi is z Phi(z) + phi(z).
#[inline(always)]
fn smeared(a: f32, h: f32, way: f32, blur2: f32) -> f32 {
    let blur = blur2.sqrt();
    let per_blur = 1.0 / blur;
    let integral = |px: f32| {
        let z = px * per_blur;
        z * phi(z) + PHI_0 * exp(-0.5 * (z * z))
    };
    let half = 0.5 * way;
    let far = integral(a + h + half) - integral(a + h - half);
    let near = integral(a - h + half) - integral(a - h - half);
    (far - near) * blur / way
}

/// Multiplies `share` by a sheet's spangle.
#[inline(always)]
pub(super) fn spangle<const BENT: bool>(
    surface: &Surface,
    spangle: &Spangle,
    lens: &LensBlur,
    rays: Rays<'_>,
    share: &mut [f32],
) {
    let count = if share.len() < RUN { share.len() } else { RUN };
    let share = &mut share[..count];
    let xs = &rays.x[..count];
    let ys = if BENT { &rays.y[..count] } else { rays.y };
    let [j11, j12, j21, j22] = rays.slopes;
    let (j11, j12, j21, j22) =
        if BENT { (&j11[..count], &j12[..count], &j21[..count], &j22[..count]) } else { (j11, j12, j21, j22) };
    let [ax, ay, az] = surface.inverse_depth;
    let [nx, ny, nz] = spangle.normal;
    let [[sx, sy, sz], [tx, ty, tz]] = spangle.axes;
    let [[ux, uy, uz], [vx, vy, vz]] = spangle.sweep;
    let [wx, wy, wz] = spangle.turn;
    /// 2 E of the contrast that is left.
    const SLOPE2: f32 = (2.0 * SPANGLE_SLOPE2) as f32;
    /// Coordinates beyond are of pixels that do not see the region.
    const FARTHEST: f32 = 2e6;
    let places = if spangle.pairs > 0 { 2.0 * spangle.pairs as f32 } else { 1.0 };
    let strength = spangle.strength / (places * SPANGLE_STEP as f32);
    // One step after the other over the whole run, so that each is a loop without branches.
    let (mut at_s, mut at_t, mut contrast) = ([0.0; RUN], [0.0; RUN], [0.0; RUN]);
    let mut approach = [0.0; RUN];
    for i in 0..count {
        let (x, y) = (xs[i], if BENT { ys[i] } else { ys[0] });
        let per_approach = 1.0 / max(nx * x + ny * y + nz, 1e-9);
        let s = clamp((sx * x + sy * y + sz) * per_approach, -FARTHEST, FARTHEST);
        let t = clamp((tx * x + ty * y + tz) * per_approach, -FARTHEST, FARTHEST);
        let square = |dx: f32, dy: f32| {
            let (u, v) = if BENT { (j11[i] * dx + j21[i] * dy, j12[i] * dx + j22[i] * dy) } else { (j11[0] * dx, j22[0] * dy) };
            (u * u + v * v) * (per_approach * per_approach)
        };
        let blur2 = lens.variance_px2(ax * x + ay * y + az) + BOX_PX2 as f32;
        let lost = |slope2: f32| 1.0 + SLOPE2 * blur2 * slope2;
        let lost = lost(square(sx - nx * s, sy - ny * s)) * lost(square(tx - nx * t, ty - ny * t));
        (at_s[i], at_t[i], approach[i]) = (s, t, per_approach);
        contrast[i] = strength / lost.sqrt().sqrt();
    }
    let mut sum = [0.0; RUN];
    if spangle.pairs == 0 {
        for i in 0..count {
            sum[i] = spangle_at(at_s[i], at_t[i], spangle.sheet_bits);
        }
    } else {
        let per_pair = 1.0 / spangle.pairs as f32;
        let (mut part_s, mut part_t) = ([0.0; RUN], [0.0; RUN]);
        for i in 0..count {
            let (x, y) = (xs[i], if BENT { ys[i] } else { ys[0] });
            let turned = wx * x + wy * y + wz;
            let per_pair = approach[i] * per_pair;
            part_s[i] = clamp((ux * x + uy * y + uz - at_s[i] * turned) * per_pair, -FARTHEST, FARTHEST);
            part_t[i] = clamp((vx * x + vy * y + vz - at_t[i] * turned) * per_pair, -FARTHEST, FARTHEST);
        }
        for pair in 0..spangle.pairs {
            let middle = pair as f32 + 0.5 - 0.5 * spangle.pairs as f32;
            for at in [middle - GAUSS, middle + GAUSS] {
                for i in 0..count {
                    sum[i] += spangle_at(at_s[i] + at * part_s[i], at_t[i] + at * part_t[i], spangle.sheet_bits);
                }
            }
        }
    }
    for i in 0..count {
        share[i] *= max(1.0 + contrast[i] * sum[i], 0.0);
    }
}

/// The noise at a place of a sheet, times [`SPANGLE_STEP`].
#[inline(always)]
fn spangle_at(s: f32, t: f32, sheet_bits: u32) -> f32 {
    let ((s_low, i0), (t_low, j0)) = (floor(s), floor(t));
    let smooth = |share: f32| share * share * (3.0 - 2.0 * share);
    let (p, q) = (smooth(s - s_low), smooth(t - t_low));
    let node = |i: i32, j: i32| spangle_node(i0.wrapping_add(i), j0.wrapping_add(j), sheet_bits) as f32;
    let sum = (1.0 - q) * ((1.0 - p) * node(0, 0) + p * node(1, 0)) + q * ((1.0 - p) * node(0, 1) + p * node(1, 1));
    let squares = ((1.0 - p) * (1.0 - p) + p * p) * ((1.0 - q) * (1.0 - q) + q * q);
    sum / squares.sqrt()
}
