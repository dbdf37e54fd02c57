//! Soft edges of strips in single precision, as [`crate::coverage`] defines them.

use super::ridges::{RUN, Run};
use super::tables::Rays;
use crate::coverage::SOFT_MIN_PX;
use crate::vector_math::{PHI_END, max, min, phi};

/// An edge in single precision.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    /// h: rays with h . r > 0 are inside.
    h: [f32; 3],
}

/// Shares that a convex piece keeps of a run's light.
#[derive(Debug)]
pub(super) struct Kept {
    /// The share, as far as edges were taken in.
    pub(super) share: [f32; RUN],
    narrowest: [[f32; RUN]; 2],
    softness: Softness,
}

/// What all edges of a run have in common.
#[derive(Debug)]
struct Softness {
    /// Standard deviation, in pixels.
    px: [f32; RUN],
    /// 1 - rho, times the distance from the ridge.
    shift: [f32; RUN],
    /// sqrt(rho).
    round: [f32; RUN],
}

/// How far the softness of edges reaches in a run.
#[derive(Clone, Copy, Debug)]
struct Reach {
    /// Farthest from an edge, in pixels, that the edge is felt.
    px: f32,
}

impl Line {
    pub(super) fn new(edge: &nalgebra::Vector3<f64>) -> Self {
        Self { h: super::surfaces::single(edge) }
    }

    /// The lowest and the highest distance from the edge in a run, in pixels; only for a pinhole, in whose image an edge is straight.
    #[inline(always)]
    fn distances(&self, rays: Rays<'_>, count: usize) -> [f32; 2] {
        let [hx, hy, hz] = self.h;
        let (u, v) = (hx * rays.slopes[0][0], hy * rays.slopes[3][0]);
        let flatness = 1.0 / max(u * u + v * v, 1e-30).sqrt();
        let at = |i: usize| (hx * rays.x[i] + hy * rays.y[0] + hz) * flatness;
        let (a, b) = (at(0), at(count - 1));
        [min(a, b), max(a, b)]
    }
}

impl Reach {
    /// Of a run whose edges have the softness `blur2`: no edge is felt farther from it than its shift and five and a quarter
    /// times its softness.
    #[inline(always)]
    fn of(run: &Run, blur2: &[f32; RUN], count: usize) -> Self {
        // Positive numbers compare as their bits do, and integers may be compared in any order.
        let (mut across, mut widest) = (0_u32, 0_u32);
        for (a, b) in run.across[..count].iter().zip(&blur2[..count]) {
            across = across.max(a.abs().to_bits());
            widest = widest.max(b.to_bits());
        }
        let soft = max(f32::from_bits(widest).sqrt(), SOFT_MIN_PX as f32);
        Self { px: f32::from_bits(across) + PHI_END * soft }
    }
}

impl Kept {
    pub(super) const fn new() -> Self {
        const NONE: [f32; RUN] = [0.0; RUN];
        Self { share: NONE, narrowest: [NONE; 2], softness: Softness { px: NONE, shift: NONE, round: NONE } }
    }

    /// What a piece with these edges, whose softness is `blur2`, keeps of a run.
    #[inline(always)]
    pub(super) fn of<const BENT: bool>(
        &mut self,
        edges: &[Line],
        rays: Rays<'_>,
        run: &Run,
        blur2: &[f32; RUN],
        count: usize,
    ) -> Keeps {
        if edges.is_empty() {
            return Keeps::All;
        }
        let reach = Reach::of(run, blur2, count);
        let mut keeps = Keeps::All;
        for edge in edges {
            if !BENT {
                let [low, high] = edge.distances(rays, count);
                if low > reach.px {
                    continue;
                }
                if high < -reach.px {
                    return Keeps::Nothing;
                }
            }
            if keeps == Keeps::All {
                self.share[..count].fill(1.0);
                self.narrowest[0][..count].fill(0.0);
                self.narrowest[1][..count].fill(0.0);
                self.softness.of(run, blur2, count);
                keeps = Keeps::Some;
            }
            self.take::<BENT>(edge, rays, run, count);
        }
        keeps
    }

    #[inline(always)]
    fn take<const BENT: bool>(&mut self, edge: &Line, rays: Rays<'_>, run: &Run, count: usize) {
        let count = if count < RUN { count } else { RUN };
        let xs = &rays.x[..count];
        let ys = if BENT { &rays.y[..count] } else { rays.y };
        let [j11, j12, j21, j22] = rays.slopes;
        let (j11, j12, j21, j22) =
            if BENT { (&j11[..count], &j12[..count], &j21[..count], &j22[..count]) } else { (j11, j12, j21, j22) };
        let [hx, hy, hz] = edge.h;
        let share = &mut self.share[..count];
        let [narrowest_u, narrowest_v] = &mut self.narrowest;
        let (narrowest_u, narrowest_v) = (&mut narrowest_u[..count], &mut narrowest_v[..count]);
        let Softness { px, shift, round } = &self.softness;
        let (px, shift, rounds) = (&px[..count], &shift[..count], &round[..count]);
        let (normal_u, normal_v) = (&run.normal[0][..count], &run.normal[1][..count]);
        for i in 0..count {
            let (x, y) = (xs[i], if BENT { ys[i] } else { ys[0] });
            let (slope_u, slope_v) =
                if BENT { (j11[i] * hx + j21[i] * hy, j12[i] * hx + j22[i] * hy) } else { (j11[0] * hx, j22[0] * hy) };
            let flatness = 1.0 / max(slope_u * slope_u + slope_v * slope_v, 1e-30).sqrt();
            let distance = (hx * x + hy * y + hz) * flatness;
            let (inward_u, inward_v) = (slope_u * flatness, slope_v * flatness);
            let facing = inward_u * normal_u[i] + inward_v * normal_v[i];
            let along = normal_u[i] * inward_v - normal_v[i] * inward_u;
            let round = facing * rounds[i];
            let length = max((along * along + round * round).sqrt(), 1e-9);
            let soft = max(px[i] * length, SOFT_MIN_PX as f32);
            // One division for two.
            let both = 1.0 / (soft * length);
            let alone = phi((distance - shift[i] * facing) * (both * length));
            let per_length = both * soft;
            let (direction_u, direction_v) = (along * per_length, round * per_length);
            let cosine = narrowest_u[i] * direction_u + narrowest_v[i] * direction_v;
            let before = share[i];
            let narrower = alone < before;
            narrowest_u[i] = if narrower { direction_u } else { narrowest_u[i] };
            narrowest_v[i] = if narrower { direction_v } else { narrowest_v[i] };
            share[i] = together(before, alone, cosine);
        }
    }
}

impl Softness {
    #[inline(always)]
    fn of(&mut self, run: &Run, blur2: &[f32; RUN], count: usize) {
        let count = if count < RUN { count } else { RUN };
        let (px, shift, round) = (&mut self.px[..count], &mut self.shift[..count], &mut self.round[..count]);
        let (across, all2, blur2) = (&run.across[..count], &run.all2[..count], &blur2[..count]);
        for i in 0..count {
            let left = blur2[i] / all2[i];
            px[i] = blur2[i].sqrt();
            shift[i] = left * across[i];
            round[i] = max(1.0 - left, 0.0).sqrt();
        }
    }
}

/// What a piece keeps of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Keeps {
    /// All.
    All,
    /// Nothing.
    Nothing,
    /// [`Kept::share`].
    Some,
}

#[inline(always)]
fn together(a: f32, b: f32, cosine: f32) -> f32 {
    let c2 = cosine * cosine;
    let c4 = c2 * c2;
    let weight = cosine.abs() * (0.64 + 0.36 * (c4 * c4));
    let parallel = if cosine < 0.0 { max(a + b - 1.0, 0.0) } else { min(a, b) };
    let both = a * b;
    both + weight * (parallel - both)
}
