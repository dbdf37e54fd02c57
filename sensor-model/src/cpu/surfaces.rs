//! A frame's regions in single precision, as the loops over pixels use them.

use std::ops::Range;

use nalgebra::Vector3;

use super::raster::DARK;
use crate::frame_geometry::{FrameGeometry, GlowPatch, inverse_depth};
use crate::light::headlamp_strength;
use crate::noise::finalise;
use crate::optics::Optics;
use crate::renderer::View;
use crate::scenery::Scenery;

/// What every pixel of a region has in common.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    /// 1 / z = `inverse_depth` . r.
    pub(super) inverse_depth: [f32; 3],
    /// Two unit vectors in the plane, square to each other and to its normal.
    pub(super) in_plane: [[f32; 3]; 2],
    /// Offset of the plane, in metres.
    pub(super) offset_m: f32,
    /// The headlamp's light, see [`Lamp`].
    pub(super) lamp: Lamp,
    /// Its even light: that of an open end, in DN.
    pub(super) even_dn: f32,
    /// Squared roughness of its gloss.
    pub(super) roughness2: f32,
    /// Slow light.
    pub(super) glow: Option<GlowPatch>,
    /// Dark joints, in the geometry's seams.
    pub(super) seams: Range<usize>,
    /// Spangle.
    pub(super) spangle: Option<Spangle>,
    /// A number that regions of one plane and one surface share: no edge is seen between them.
    pub(super) class: u32,
    /// Whether its light changes within the point spread.
    pub(super) is_sharp: bool,
}

/// Factors of the headlamp's light: `matt (n.r / o)^3 cos^3` is what albedo gives, `gloss` is used likewise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Lamp {
    /// Strength times offset times albedo.
    pub(super) matt: f32,
    /// Strength times offset times the share that is mirrored, times roughness^2 / 4; 0 for a matt surface.
    pub(super) gloss: f32,
}

/// Spangle of a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spangle {
    /// See [`crate::frame_geometry::Texture`].
    pub(super) axes: [[f32; 3]; 2],
    pub(super) sweep: [[f32; 3]; 2],
    pub(super) turn: [f32; 3],
    pub(super) pairs: u32,
    /// The plane's normal.
    pub(super) normal: [f32; 3],
    /// Standard deviation over the mean.
    pub(super) strength: f32,
    /// Mixed number of the sheet.
    pub(super) sheet_bits: u32,
}

/// Below this roughness the lobe of the headlamp's reflection is narrower than some tens of pixels, and the point spread widens it by
/// more than 0.05 DN: curvature 4 peak / (0.2 * 380 px)^2 times half the variance 0.45 px^2, for a peak of 100 DN.
const SHARP_ROUGHNESS: f64 = 0.2;

/// Vector in single precision.
pub(super) fn single(v: &Vector3<f64>) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

/// Appends the surfaces of a frame: one a region, then one a grille.
pub(super) fn collect(geometry: &FrameGeometry, scenery: &Scenery, optics: &Optics, view: &View, surfaces: &mut Vec<Surface>) {
    surfaces.clear();
    let headlamp = headlamp_strength(optics) * view.headlamp_power;
    for (index, region) in geometry.regions.iter().enumerate() {
        let look = &scenery.looks[usize::from(region.surface.0)];
        let normal = region.plane.normal.into_inner();
        let offset_m = region.plane.offset_m;
        let square = |axis: Vector3<f64>| axis - normal * normal.dot(&axis);
        let axis = if normal.z.abs() < 0.8 { Vector3::z() } else { Vector3::x() };
        let first = square(axis).normalize();
        let roughness2 = look.roughness * look.roughness;
        let same = |other: &crate::frame_geometry::Region| other.goes_on_in(region);
        let class = geometry.regions[..index].iter().position(same).unwrap_or(index);
        surfaces.push(Surface {
            inverse_depth: single(&(normal / offset_m)),
            in_plane: [single(&first), single(&normal.cross(&first))],
            offset_m: offset_m as f32,
            lamp: Lamp {
                matt: (headlamp * offset_m * look.albedo) as f32,
                gloss: (headlamp * offset_m * look.specular * roughness2 / 4.0) as f32,
            },
            even_dn: 0.0,
            roughness2: roughness2 as f32,
            glow: region.glow,
            seams: region.seams.clone(),
            spangle: region.texture.filter(|_| look.spangle > 0.0).map(|texture| Spangle {
                axes: texture.axes.map(|axis| single(&axis)),
                sweep: texture.sweep.map(|axis| single(&axis)),
                turn: single(&texture.turn),
                pairs: texture.pairs,
                normal: single(&normal),
                strength: look.spangle as f32,
                sheet_bits: finalise(region.sheet as u32),
            }),
            class: class as u32,
            is_sharp: look.specular > 0.0 && look.roughness < SHARP_ROUGHNESS && headlamp > 0.0,
        });
    }
    for grille in &geometry.grilles {
        let inverse_depth = inverse_depth(&geometry.corners[grille.clone()]).map_or([0.0; 3], |plane| single(&plane));
        surfaces.push(Surface { inverse_depth, even_dn: optics.ambient_dn as f32, class: DARK - 1, ..Surface::nothing() });
    }
}

impl Surface {
    /// What pixels see that see nothing.
    pub(super) fn nothing() -> Self {
        Self {
            inverse_depth: [0.0; 3],
            in_plane: [[0.0; 3]; 2],
            offset_m: 0.0,
            lamp: Lamp::default(),
            even_dn: 0.0,
            roughness2: 1.0,
            glow: None,
            seams: 0..0,
            spangle: None,
            class: DARK,
            is_sharp: false,
        }
    }
}
