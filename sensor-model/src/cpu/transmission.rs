//! What seams and spangle leave of a region's light, pixel by pixel.

use super::ridges::{LensBlur, RUN};
use super::surfaces::{Spangle, Surface, single};
use super::tables::Rays;
use crate::frame_geometry::Seam;
use crate::noise::{SPANGLE_STEP, spangle_node};
use crate::strip::BOX_PX2;
use crate::vector_math::{clamp, exp, floor, max, phi};

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
        let per_blur = 1.0 / (lens.variance_px2(near) + BOX_PX2 as f32).sqrt();
        let (a, h) = (off_m * flatness * per_blur, half_m * flatness * per_blur);
        share[i] *= 1.0 - (phi(a + h) - phi(a - h));
    }
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
    let [[sx, sy, sz], [tx, ty, tz]] = spangle.texture;
    let strength = spangle.strength / SPANGLE_STEP as f32;
    let bits = spangle.sheet_bits;
    /// -2 pi^2.
    const CONTRAST: f32 = -19.739_209;
    /// Coordinates beyond are of pixels that do not see the region.
    const FARTHEST: f32 = 2e6;
    for i in 0..count {
        let (x, y) = (xs[i], if BENT { ys[i] } else { ys[0] });
        let per_approach = 1.0 / max(nx * x + ny * y + nz, 1e-9);
        let s = clamp((sx * x + sy * y + sz) * per_approach, -FARTHEST, FARTHEST);
        let t = clamp((tx * x + ty * y + tz) * per_approach, -FARTHEST, FARTHEST);
        let length = |dx: f32, dy: f32| {
            let (u, v) = if BENT { (j11[i] * dx + j21[i] * dy, j12[i] * dx + j22[i] * dy) } else { (j11[0] * dx, j22[0] * dy) };
            (u * u + v * v).sqrt() * per_approach
        };
        let cycles = 0.25 * (length(sx - nx * s, sy - ny * s) + length(tx - nx * t, ty - ny * t));
        let blur2 = lens.variance_px2(ax * x + ay * y + az) + BOX_PX2 as f32;
        let kept = exp(CONTRAST * blur2 * (cycles * cycles));

        let ((s_low, i0), (t_low, j0)) = (floor(s), floor(t));
        let smooth = |share: f32| share * share * (3.0 - 2.0 * share);
        let (p, q) = (smooth(s - s_low), smooth(t - t_low));
        let node = |i: i32, j: i32| spangle_node(i0.wrapping_add(i), j0.wrapping_add(j), bits) as f32;
        let sum = (1.0 - q) * ((1.0 - p) * node(0, 0) + p * node(1, 0)) + q * ((1.0 - p) * node(0, 1) + p * node(1, 1));
        let squares = ((1.0 - p) * (1.0 - p) + p * p) * ((1.0 - q) * (1.0 - q) + q * q);
        share[i] *= max(1.0 + strength * kept * sum / squares.sqrt(), 0.0);
    }
}
