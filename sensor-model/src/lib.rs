//! What the camera of a duct robot would see: light, surfaces, lens and CCD.
//!
//! In the order in which a frame comes about:
//!
//! - [`optics`]: the parameters of light, surface and CCD, and [`light`]: the constants derived from them;
//! - [`scenery`]: a duct network as sheets that light falls on, openings that it passes, and bodies that cast shadows;
//! - [`beam`]: which parts of which sheets a point (the camera, a laser's source) sees, by following openings;
//! - [`noise`]: the counter-based random numbers of the CCD and of speckle;
//! - [`renderer`]: what a renderer is given and gives, whichever engine it runs on;
//! - `gpu` and `WgpuRenderer`: the engine on wgpu (feature `wgpu`).
//!
//! What is not modelled: light that reaches the camera by more than one reflection, gloss, lens distortion, natural vignetting
//! (a wall square to a ray is as bright at the image's corner as in its middle), motion blur, and the extent of the source: the
//! edge of a shadow is sharp before the point spread.
#![forbid(unsafe_code)]

pub mod band;
pub mod beam;
mod bounce;
pub mod coverage;
mod cpu;
pub mod daylight;
pub mod exposure_parts;
pub mod frame_geometry;
pub mod glow;
mod glow_nodes;
pub mod lens;
pub mod light;
mod line_light;
pub mod noise;
pub mod optics;
mod passage;
pub mod renderer;
pub mod scenery;
pub mod silhouette;
pub mod strip;
pub mod surface;
pub mod truth;
pub mod vector_math;

#[cfg(feature = "wgpu")]
pub mod gpu;
#[cfg(feature = "wgpu")]
mod gpu_blocks;
#[cfg(feature = "wgpu")]
mod gpu_buffers;
#[cfg(feature = "wgpu")]
mod gpu_ccd;
#[cfg(feature = "wgpu")]
mod gpu_filter;
#[cfg(feature = "wgpu")]
mod gpu_frame;
#[cfg(feature = "wgpu")]
mod gpu_light;
#[cfg(feature = "wgpu")]
mod gpu_light_pipelines;
#[cfg(feature = "wgpu")]
mod gpu_mesh;
#[cfg(feature = "wgpu")]
mod gpu_tiles;
#[cfg(feature = "wgpu")]
mod wgpu_renderer;

pub use cpu::CpuRenderer;
#[cfg(feature = "wgpu")]
pub use wgpu_renderer::WgpuRenderer;

/// Rigid transform; named `to_from` wherever it occurs.
pub type Transform = nalgebra::Isometry3<f64>;
