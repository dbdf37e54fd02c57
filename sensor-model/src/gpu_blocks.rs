//! Layout of what the drawing shaders read: the camera, regions and strips, in single precision.

use nalgebra::Vector3;

use crate::frame_geometry::{Region, Seam};
use crate::lens::Projection;
use crate::light::FAN_FADE_RAD;
use crate::noise;
use crate::strip::{Blur, MirroredWay, Strip};
use crate::surface::Look;

/// `Camera` of `camera.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct CameraBlock {
    ray_scale: [f32; 2],
    ray_start: [f32; 2],
    clip_scale: [f32; 2],
    clip_start: [f32; 2],
    focal_px: [f32; 2],
    focal_mean_px: f32,
    margin_px: f32,
    distortion: [f32; 4],
    k3: f32,
    psf_px2: f32,
    defocus_px_m: f32,
    focus_1_m: f32,
    /// In DN m^2.
    headlamp: f32,
    /// In DN.
    daylight: f32,
    glow: f32,
    share: f32,
}

/// `Region` of `sheet.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct RegionBlock {
    plane: [f32; 4],
    look: [f32; 4],
    texture_s: [f32; 4],
    texture_t: [f32; 4],
    sweep_s: [f32; 4],
    sweep_t: [f32; 4],
    turn: [f32; 4],
    marks: [u32; 4],
    nodes: [i32; 4],
}

/// `Seam` of `sheet.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct SeamBlock {
    ridge: [f32; 4],
    sweep: [f32; 4],
}

/// `Strip` of `strip.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct StripBlock {
    plane: [f32; 4],
    ridge: [f32; 4],
    sweep: [f32; 4],
    source: [f32; 4],
    along: [f32; 4],
    across: [f32; 4],
    look: [f32; 4],
    mirror: [f32; 4],
    gloss: [f32; 4],
    cuts: [u32; 4],
    window: [u32; 4],
}

/// A frame's light, in DN m^2 and DN, the exposure and a part's share included.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lamps {
    pub(crate) headlamp: f64,
    pub(crate) daylight: f64,
    pub(crate) glow: f64,
    pub(crate) share: f64,
}

/// Where a part's seams, nodes, edges and holes begin in the frame's.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bases {
    pub(crate) seams: usize,
    pub(crate) glow: usize,
    pub(crate) edges: usize,
    pub(crate) holes: usize,
}

impl CameraBlock {
    /// The block without a frame's light, for an image of the light of this size, `margin_px` larger than the camera's on every side.
    pub(crate) fn new(projection: &Projection, blur: &Blur, size_px: [usize; 2], margin_px: usize) -> Self {
        let camera = &projection.camera;
        let margin = margin_px as f64;
        // The middle of pixel (0, 0) is half a pixel and the margin from the corner of the light's image.
        let start = margin + 0.5;
        let size = size_px.map(|n| n as f64);
        let (focal, centre) = (camera.focal_px, camera.centre_px);
        let single = |pair: [f64; 2]| pair.map(|v| v as f32);
        let distortion = camera.distortion;
        Self {
            ray_scale: single([1.0 / focal[0], 1.0 / focal[1]]),
            ray_start: single([-(centre[0] + start) / focal[0], -(centre[1] + start) / focal[1]]),
            clip_scale: single([2.0 / size[0], -2.0 / size[1]]),
            clip_start: single([2.0 * start / size[0] - 1.0, 1.0 - 2.0 * start / size[1]]),
            focal_px: single(focal),
            focal_mean_px: blur.focal_px as f32,
            margin_px: margin as f32,
            distortion: [distortion.k1, distortion.k2, distortion.p1, distortion.p2].map(|v| v as f32),
            k3: distortion.k3 as f32,
            psf_px2: blur.psf_px2 as f32,
            defocus_px_m: blur.defocus_px_m as f32,
            focus_1_m: blur.focus_1_m as f32,
            headlamp: 0.0,
            daylight: 0.0,
            glow: 0.0,
            share: 1.0,
        }
    }

    /// The block with a frame's light.
    pub(crate) fn lit(self, lamps: &Lamps) -> Self {
        let [headlamp, daylight, glow, share] = [lamps.headlamp, lamps.daylight, lamps.glow, lamps.share].map(|v| v as f32);
        Self { headlamp, daylight, glow, share, ..self }
    }
}

impl RegionBlock {
    pub(crate) fn of(region: &Region, look: &Look, bases: &Bases) -> Self {
        let texture = region.texture.unwrap_or_default();
        let spangle = if region.texture.is_some() { look.spangle } else { 0.0 };
        let (first, nodes) = region.glow.as_ref().map_or((0, [0; 4]), |patch| {
            (patch.first + bases.glow, [patch.column, patch.row, patch.columns as i32, patch.rows as i32])
        });
        Self {
            plane: four(&region.plane.normal, region.plane.offset_m),
            look: [look.albedo, look.specular, look.roughness, spangle].map(|v| v as f32),
            texture_s: four(&texture.axes[0], 0.0),
            texture_t: four(&texture.axes[1], f64::from(texture.pairs)),
            sweep_s: four(&texture.sweep[0], 0.0),
            sweep_t: four(&texture.sweep[1], 0.0),
            turn: four(&texture.turn, 0.0),
            marks: [
                (region.seams.start + bases.seams) as u32,
                region.seams.len() as u32,
                noise::finalise(region.sheet as u32),
                first as u32,
            ],
            nodes,
        }
    }

    /// An open end, as bright as daylight all over; no lamp reaches it.
    pub(crate) fn open_end() -> Self {
        /// So far away that the headlamp shows nothing.
        const FAR_M: f32 = 1e6;
        Self {
            plane: [0.0, 0.0, 1.0, FAR_M],
            look: [0.0, 0.0, 1.0, 0.0],
            texture_s: [0.0, 0.0, 0.0, 1.0],
            texture_t: [0.0; 4],
            sweep_s: [0.0; 4],
            sweep_t: [0.0; 4],
            turn: [0.0; 4],
            marks: [0; 4],
            nodes: [0; 4],
        }
    }
}

impl SeamBlock {
    pub(crate) fn of(seam: &Seam) -> Self {
        Self { ridge: four(&seam.ridge, seam.width_m), sweep: four(&seam.sweep, 0.0) }
    }
}

impl StripBlock {
    /// A strip of a laser of this strength, in DN m^2.
    pub(crate) fn of(strip: &Strip, strength: f64, bases: &Bases) -> Self {
        let Strip { fan, line, look, .. } = strip;
        let range = |range: &std::ops::Range<usize>, base: usize| [(range.start + base) as u32, range.len() as u32];
        let [edge, edges] = range(&strip.edges, bases.edges);
        let [hole, holes] = range(&strip.holes, bases.holes);
        let [pane, panes] = range(&strip.window, bases.edges);
        let (mirror, gloss) = strip.mirror.as_ref().map_or(([0.0; 4], [0.0; 4]), |mirror| {
            let lobe = std::f64::consts::SQRT_2 * mirror.look.roughness;
            let view = f32::from(u8::from(mirror.way == MirroredWay::View));
            (four(&mirror.plane.normal, mirror.plane.offset_m), [mirror.look.specular as f32, lobe as f32, view, 0.0])
        });
        Self {
            plane: four(&strip.plane.normal, strip.plane.offset_m),
            ridge: four(&strip.ridge, strength),
            sweep: four(&strip.sweep, fan.reach_rad),
            source: four(&strip.source, line.width_m),
            along: four(&fan.along, line.growth_rad),
            across: four(&fan.across, fan.exponent),
            look: [look.albedo, look.specular, look.roughness, 1.0 / FAN_FADE_RAD].map(|v| v as f32),
            mirror,
            gloss,
            cuts: [edge, edges, hole, holes],
            window: [pane, panes, 0, 0],
        }
    }
}

/// A vector and a number.
pub(crate) fn four(vector: &Vector3<f64>, last: f64) -> [f32; 4] {
    [vector.x as f32, vector.y as f32, vector.z as f32, last as f32]
}
