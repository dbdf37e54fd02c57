//! Light that varies slowly over the image: headlamp, daylight at open ends, and the glow between its nodes.

use super::surfaces::Surface;
use super::tables::{BLOCK, LEFT, Rays};
use crate::frame_geometry::{GLOW_SPACING_PX, GlowPatch};

const _: () = assert!(BLOCK == GLOW_SPACING_PX);

/// The headlamp's light on a surface, and an open end's, at each pixel; `out` has as many values as there are rays, whole blocks.
#[inline(always)]
pub(super) fn shine<const BENT: bool>(surface: &Surface, rays: Rays<'_>, vignetting: bool, out: &mut [f32]) {
    let count = out.len();
    let (x, cosine) = (&rays.x[..count], &rays.cosine[..count]);
    let y = if BENT { &rays.y[..count] } else { rays.y };
    let [ax, ay, az] = surface.inverse_depth;
    let matt = surface.lamp.matt;
    let (c0, c4) = if vignetting { (0.0, 1.0) } else { (1.0, 0.0) };
    if surface.lamp.gloss == 0.0 {
        let even = surface.even_dn;
        for i in 0..count {
            let y = if BENT { y[i] } else { y[0] };
            let c = cosine[i];
            let square = c * c;
            let near = ax * x[i] + ay * y + az;
            let falloff = c0 + c4 * (square * square);
            out[i] = (matt * (near * near * near) * (square * c) + even) * falloff;
        }
        return;
    }
    let gloss = surface.lamp.gloss;
    let roughness2 = surface.roughness2;
    let offset = surface.offset_m;
    let [[sx, sy, sz], [tx, ty, tz]] = surface.in_plane;
    for i in 0..count {
        let (x, y) = (x[i], if BENT { y[i] } else { y[0] });
        let c = cosine[i];
        let square = c * c;
        let near = ax * x + ay * y + az;
        let falloff = c0 + c4 * (square * square);
        // Cosine of the angle between ray and normal, and the square of its sine, which a difference from 1 would not give.
        let facing = offset * near * c;
        let (s, t) = (sx * x + sy * y + sz, tx * x + ty * y + tz);
        let sine2 = (s * s + t * t) * square;
        let cosine2 = facing * facing;
        let spread = sine2 + roughness2 * cosine2;
        let masked = (cosine2 + roughness2 * sine2).sqrt();
        let lobe = gloss / (spread * spread * (facing * masked) + 1e-30);
        let light = near * near * near * (square * c);
        out[i] = light * (matt + lobe) * falloff;
    }
}

/// Adds a patch of glow to a row; `out[LEFT + u]` is column u.
#[inline(always)]
pub(super) fn glow(patch: &GlowPatch, nodes: &[f32], row: isize, from: i32, to: i32, out: &mut [f32]) {
    const SPACING: i32 = GLOW_SPACING_PX as i32;
    /// Share of the way to the next node of each pixel.
    const SHARES: [f32; GLOW_SPACING_PX] = {
        let mut shares = [0.0; GLOW_SPACING_PX];
        let mut i = 0;
        while i < GLOW_SPACING_PX {
            shares[i] = i as f32 / GLOW_SPACING_PX as f32;
            i += 1;
        }
        shares
    };
    let row = row as i32;
    let above = row.div_euclid(SPACING);
    let down = SHARES[row.rem_euclid(SPACING) as usize];
    let (last_row, last_column) = (patch.rows as i32 - 1, patch.columns as i32 - 1);
    let line = |j: i32| {
        let first = patch.first + (j - patch.row).clamp(0, last_row) as usize * patch.columns;
        &nodes[first..first + patch.columns]
    };
    let (upper, lower) = (line(above), line(above + 1));
    let node = |i: i32| {
        let i = (i - patch.column).clamp(0, last_column) as usize;
        upper[i] + (lower[i] - upper[i]) * down
    };
    let mut cell = from.div_euclid(SPACING);
    let mut before = node(cell);
    while cell * SPACING < to {
        let after = node(cell + 1);
        let slope = after - before;
        let mut values = [0.0; GLOW_SPACING_PX];
        for i in 0..GLOW_SPACING_PX {
            values[i] = before + slope * SHARES[i];
        }
        let (first, last) = ((cell * SPACING).max(from), (cell * SPACING + SPACING).min(to));
        let start = (LEFT as i32 + cell * SPACING) as isize;
        if last - first == SPACING {
            let out = &mut out[start as usize..start as usize + GLOW_SPACING_PX];
            for i in 0..GLOW_SPACING_PX {
                out[i] += values[i];
            }
        } else {
            for column in first..last {
                out[(LEFT as i32 + column) as usize] += values[(column - cell * SPACING) as usize];
            }
        }
        before = after;
        cell += 1;
    }
}
