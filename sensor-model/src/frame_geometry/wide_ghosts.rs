//! Ghosts spread so wide that their light is computed on the glow's nodes only.
//!
//! The formulas are those of [`crate::strip`] in single precision, with two simplifications where the spread is many pixels: a pixel's
//! own extent across the ghost is left out, and only soft edges count, since the sharp ones are those of the region itself.
//! Loops run over a region's nodes, so that they vectorise; the results are the same whatever vector path is picked.

use std::ops::Range;

use nalgebra::Vector3;

use super::glow_patch::{GLOW_SPACING_PX, NodeLattice, NodeRays};
use super::region::Region;
use crate::coverage::{Edge, SOFT_MIN_PX};
use crate::light::{FAN_FADE_RAD, FWHM_PER_SIGMA};
use crate::strip::{BOX_PX2, Blur, MirroredWay, Strip};
use crate::vector_math::{angle, clamp, exp, max, min, phi};

/// A ghost and where it is seen.
#[derive(Clone, Debug)]
pub(super) struct WideGhost {
    strip: Strip,
    region: usize,
    /// Strength times power, in DN m^2.
    strength: f64,
    /// Whether it is blurred so that nodes can show it.
    coarse: bool,
    edges: Range<usize>,
}

/// A frame's wide ghosts. Kept from frame to frame for its memory.
#[derive(Debug, Default)]
pub(super) struct WideGhosts {
    list: Vec<WideGhost>,
    edges: Vec<Edge>,
    rays: NodeRays,
    light: Vec<f32>,
}

/// Nodes that are computed together.
const LANES: usize = 16;

type Lanes = [f32; LANES];

/// What is computed at nodes for one ghost.
struct Shone {
    light: Lanes,
    /// For the edges, as in [`crate::coverage::Ridge`].
    across_px: Lanes,
    normal: [Lanes; 2],
    share: Lanes,
    blur_px: Lanes,
    /// Share of the light kept so far, and the direction of the narrowest edge.
    kept: Lanes,
    narrowest: [Lanes; 2],
}

impl WideGhost {
    pub(super) fn new(strip: &Strip, region: usize, strength: f64, coarse: bool) -> Self {
        Self { strip: strip.clone(), region, strength, coarse, edges: 0..0 }
    }
}

impl WideGhosts {
    pub(super) fn clear(&mut self) {
        self.list.clear();
        self.edges.clear();
    }

    /// Whether a region has any.
    pub(super) fn light(&self, region: usize) -> bool {
        self.list.iter().any(|ghost| ghost.region == region)
    }

    /// Takes in a ghost with its soft edges.
    pub(super) fn add(&mut self, mut ghost: WideGhost, soft: &[Edge], cut: Option<Edge>) {
        let first = self.edges.len();
        self.edges.extend(soft.iter().copied().chain(cut));
        ghost.edges = first..self.edges.len();
        self.list.push(ghost);
    }

    /// Adds the light to the regions' nodes.
    pub(super) fn add_to(&mut self, regions: &[Region], lattice: &NodeLattice, blur: &Blur, glow: &mut [f32]) {
        let arch = pulp::Arch::new();
        for (index, region) in regions.iter().enumerate() {
            let Some(patch) = &region.glow else { continue };
            if !self.light(index) {
                continue;
            }
            lattice.gather(patch, &mut self.rays);
            self.rays.pad(LANES);
            self.light.clear();
            self.light.resize(self.rays.x.len(), 0.0);
            let (rays, light) = (&self.rays, &mut self.light[..]);
            for ghost in self.list.iter().filter(|ghost| ghost.region == index) {
                let terms = Terms::new(ghost, blur);
                let edges = &self.edges[ghost.edges.clone()];
                if terms.view {
                    arch.dispatch(OnNodes::<true> { terms: &terms, edges, rays, light: &mut *light });
                } else {
                    arch.dispatch(OnNodes::<false> { terms: &terms, edges, rays, light: &mut *light });
                }
            }
            for (out, light) in glow[patch.first..patch.first + patch.nodes()].iter_mut().zip(&self.light) {
                *out += light;
            }
        }
    }
}

/// The light of one ghost on nodes, to be made with the processor's own vectors. VIEW: the camera's sight is mirrored, not the laser's.
struct OnNodes<'a, const VIEW: bool> {
    terms: &'a Terms,
    edges: &'a [Edge],
    rays: &'a NodeRays,
    light: &'a mut [f32],
}

impl<const VIEW: bool> pulp::WithSimd for OnNodes<'_, VIEW> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        for (chunk, light) in self.light.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
            add_chunk::<VIEW>(self.terms, self.edges, self.rays, chunk, light);
        }
    }
}

/// Adds a ghost's light at one chunk of nodes.
#[inline(always)]
fn add_chunk<const VIEW: bool>(terms: &Terms, edges: &[Edge], rays: &NodeRays, chunk: usize, light: &mut Lanes) {
    let lanes = |values: &[f32]| values.as_chunks::<LANES>().0[chunk];
    let nodes = Chunk {
        x: lanes(&rays.x),
        y: lanes(&rays.y),
        falloff: lanes(&rays.falloff),
        slope: [lanes(&rays.slope[0]), lanes(&rays.slope[1]), lanes(&rays.slope[2]), lanes(&rays.slope[3])],
    };
    let mut shone = shine::<VIEW>(terms, &nodes);
    for edge in edges {
        cut(&edge.map(|v| v as f32), &nodes, &mut shone);
    }
    for ((light, shone), kept) in light.iter_mut().zip(shone.light).zip(shone.kept) {
        *light += shone * kept;
    }
}

/// [`NodeRays`] of one chunk.
struct Chunk {
    x: Lanes,
    y: Lanes,
    falloff: Lanes,
    slope: [Lanes; 4],
}

/// A ghost's constants in single precision; vectors in the camera's frame.
struct Terms {
    view: bool,
    normal: Vector3<f32>,
    offset_m: f32,
    ridge: Vector3<f32>,
    source: Vector3<f32>,
    along: Vector3<f32>,
    across: Vector3<f32>,
    exponent: f32,
    reach_rad: f32,
    sigma_m: f32,
    sigma_growth: f32,
    mirror: Vector3<f32>,
    mirror_m: f32,
    lobe: f32,
    lobe_px: f32,
    mirror_specular: f32,
    albedo: f32,
    psf_px2: f32,
    defocus_px_m: f32,
    focus_1_m: f32,
    strength: f32,
}

impl Terms {
    fn new(ghost: &WideGhost, blur: &Blur) -> Self {
        let strip = &ghost.strip;
        let single = |v: &Vector3<f64>| v.map(|v| v as f32);
        let (view, mirror, mirror_m, mirror_look) = match &strip.mirror {
            Some(mirror) => (mirror.way == MirroredWay::View, *mirror.plane.normal, mirror.plane.offset_m, mirror.look),
            None => (false, Vector3::zeros(), 0.0, crate::surface::Look::matt(0.0)),
        };
        let lobe = std::f64::consts::SQRT_2 * mirror_look.roughness;
        Self {
            view,
            normal: single(&strip.plane.normal),
            offset_m: strip.plane.offset_m as f32,
            ridge: single(&strip.ridge),
            source: single(&strip.source),
            along: single(&strip.fan.along),
            across: single(&strip.fan.across),
            exponent: strip.fan.exponent as f32,
            reach_rad: strip.fan.reach_rad as f32,
            sigma_m: (strip.line.width_m / FWHM_PER_SIGMA) as f32,
            sigma_growth: (strip.line.growth_rad / FWHM_PER_SIGMA) as f32,
            mirror: single(&mirror),
            mirror_m: mirror_m as f32,
            lobe: lobe as f32,
            lobe_px: (lobe * blur.focal_px) as f32,
            mirror_specular: mirror_look.specular as f32,
            albedo: strip.look.albedo as f32,
            psf_px2: (blur.psf_px2 + if ghost.coarse { COARSE_PX2 } else { 0.0 }) as f32,
            defocus_px_m: blur.defocus_px_m as f32,
            focus_1_m: blur.focus_1_m as f32,
            strength: (ghost.strength / FWHM_PER_SIGMA) as f32,
        }
    }
}

/// Variance of the blur that makes up for nodes being far apart: half their distance, squared, from which on a Gaussian between nodes is
/// right to half of its height wherever its middle lies.
const COARSE_PX2: f64 = (GLOW_SPACING_PX * GLOW_SPACING_PX) as f64 / 4.0;

/// Numbers below this count as this where they divide: what they belong to is behind the camera or the sheet, and gets no light.
const TINY: f32 = 1e-6;

/// Schlick's approximation, as [`crate::surface::Look::fresnel`].
#[inline(always)]
fn fresnel(specular: f32, cosine: f32) -> f32 {
    let miss = max(1.0 - cosine, 0.0);
    let square = miss * miss;
    specular + (1.0 - specular) * square * square * miss
}

/// A ghost's light at all nodes, edges apart, and what its edges need: [`Strip::at`] and the first part of [`Strip::light`].
#[inline(always)]
fn shine<const VIEW: bool>(terms: &Terms, nodes: &Chunk) -> Shone {
    let [sxu, sxv, syu, syv] = &nodes.slope;
    let mut shone = Shone {
        light: [0.0; LANES],
        across_px: [0.0; LANES],
        normal: [[0.0; LANES]; 2],
        share: [0.0; LANES],
        blur_px: [0.0; LANES],
        kept: [1.0; LANES],
        narrowest: [[0.0; LANES]; 2],
    };
    let Terms { normal: n, ridge: g, mirror: m, source, .. } = terms;
    let box_px2 = BOX_PX2 as f32;
    for i in 0..LANES {
        let (x, y) = (nodes.x[i], nodes.y[i]);
        let facing = n.x * x + n.y * y + n.z;
        let approach = max(facing, TINY);
        let off_m = (g.x * x + g.y * y + g.z) / approach;
        let (gx, gy) = ((g.x - n.x * off_m) / approach, (g.y - n.y * off_m) / approach);
        let (slope_u, slope_v) = (gx * sxu[i] + gy * syu[i], gx * sxv[i] + gy * syv[i]);
        let steepness = max((slope_u * slope_u + slope_v * slope_v).sqrt(), TINY);

        let z = terms.offset_m / approach;
        let (wx, wy, wz) = (x * z - source.x, y * z - source.y, z - source.z);
        let distance_m = max((wx * wx + wy * wy + wz * wz).sqrt(), TINY);
        let ray = (x * x + y * y + 1.0).sqrt();
        let sigma_m = terms.sigma_m + terms.sigma_growth * distance_m;

        let m_way = m.x * wx + m.y * wy + m.z * wz;
        let m_ray = m.x * x + m.y * y + m.z;
        let m_source = m.x * source.x + m.y * source.y + m.z * source.z;
        // The share of the way up to the mirror: from the laser, or from the camera.
        let (near, far) = if VIEW { (terms.mirror_m, m_ray * z) } else { (terms.mirror_m - m_source, m_way) };
        let far = if far.abs() < TINY { TINY } else { far };
        let after = 1.0 - clamp(near / far, 0.0, 1.0);
        let lobe_m = if VIEW { 0.0 } else { terms.lobe * distance_m * after };
        let lobe_px = if VIEW { terms.lobe_px * after } else { 0.0 };
        let cos_mirror = if VIEW { m_ray.abs() / ray } else { m_way.abs() / distance_m };

        let wide_m2 = sigma_m * sigma_m + lobe_m * lobe_m;
        let wide_px2 = wide_m2 / (steepness * steepness);
        let before_lens = lobe_m / steepness;
        let defocus = terms.defocus_px_m * (1.0 / z - terms.focus_1_m);
        let lens_px2 = terms.psf_px2 + defocus * defocus + box_px2;
        let all_px2 = wide_px2 + lens_px2 + lobe_px * lobe_px;
        // The mirror's roughness softens the edges of what is seen in it, or of the light that leaves it.
        let soft_px2 = lens_px2 + lobe_px * lobe_px + before_lens * before_lens;
        let a = off_m / steepness;

        // Fan and incidence.
        let away = wx * terms.along.x + wy * terms.along.y + wz * terms.along.z;
        let aside = wx * terms.across.x + wy * terms.across.y + wz * terms.across.z;
        let turn = angle(aside, max(away, TINY));
        let fade = clamp(1.0 - (turn.abs() - terms.reach_rad) / FAN_FADE_RAD as f32, 0.0, 1.0);
        let cos_light = (n.x * wx + n.y * wy + n.z * wz) / distance_m;
        let cos_light = max(cos_light, 0.0);
        // peak sqrt(2 pi) sigma / (sqrt(2 pi) q) exp(-a^2 / 2 q^2), where the peak has 1 / (r sigma_m) and sigma = sigma_m / steepness.
        let found = terms.strength
            * fresnel(terms.mirror_specular, cos_mirror)
            * terms.albedo
            * cos_light
            * fade
            * exp(terms.exponent * turn * turn - 0.5 * a * a / all_px2)
            * nodes.falloff[i]
            / (distance_m * steepness * all_px2.sqrt());
        shone.light[i] = if facing > TINY && away > TINY { found } else { 0.0 };
        shone.across_px[i] = a;
        shone.normal[0][i] = slope_u / steepness;
        shone.normal[1][i] = slope_v / steepness;
        shone.share[i] = 1.0 - soft_px2 / all_px2;
        shone.blur_px[i] = soft_px2.sqrt();
    }
    shone
}

/// Takes an edge into the kept shares: [`crate::coverage::Ridge::coverage`].
#[inline(always)]
fn cut(edge: &Vector3<f32>, nodes: &Chunk, shone: &mut Shone) {
    let [sxu, sxv, syu, syv] = &nodes.slope;
    for i in 0..LANES {
        let (u, v) = (edge.x * sxu[i] + edge.y * syu[i], edge.x * sxv[i] + edge.y * syv[i]);
        let steepness = max((u * u + v * v).sqrt(), f32::MIN_POSITIVE);
        let distance = (edge.x * nodes.x[i] + edge.y * nodes.y[i] + edge.z) / steepness;
        let (u, v) = (u / steepness, v / steepness);
        let facing = u * shone.normal[0][i] + v * shone.normal[1][i];
        let along = shone.normal[0][i] * v - shone.normal[1][i] * u;
        // The share may be rounded to below 0.
        let (ru, rv) = (along, facing * max(shone.share[i], 0.0).sqrt());
        let length = (ru * ru + rv * rv).sqrt();
        let softness = max(shone.blur_px[i] * length, SOFT_MIN_PX as f32);
        let b = phi((distance - (1.0 - shone.share[i]) * shone.across_px[i] * facing) / softness);
        let inverse = 1.0 / max(length, 1e-9);
        let (ru, rv) = (ru * inverse, rv * inverse);
        let a = shone.kept[i];
        let cosine = shone.narrowest[0][i] * ru + shone.narrowest[1][i] * rv;
        let c2 = cosine * cosine;
        let weight = cosine.abs() * (0.64 + 0.36 * (c2 * c2) * (c2 * c2));
        let parallel = if cosine < 0.0 { max(a + b - 1.0, 0.0) } else { min(a, b) };
        shone.narrowest[0][i] = if b < a { ru } else { shone.narrowest[0][i] };
        shone.narrowest[1][i] = if b < a { rv } else { shone.narrowest[1][i] };
        shone.kept[i] = a * b + weight * (parallel - a * b);
    }
}
