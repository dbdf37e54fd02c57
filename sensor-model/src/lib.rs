//! What the camera of a duct robot would see: light, surfaces, lens and CCD.
//!
//! In the order in which a frame comes about:
//!
//! - [`optics`]: the parameters of light, surface and CCD, and [`light`]: the constants derived from them;
//! - [`scenery`]: a duct network as sheets that light falls on, openings that it passes, and bodies that cast shadows;
//! - [`beam`]: which parts of which sheets a point (the camera, a laser's source) sees, by following openings;
//! - [`frame_geometry`]: what a frame shows, as polygons: regions of sheets, and [`strip`]s of light on them, for each of the
//!   [`exposure_parts`];
//! - `soft_edges`: pixels that an edge between regions crosses, by area;
//! - [`noise`]: the counter-based random numbers of the CCD and of speckle;
//! - [`renderer`]: what a renderer is given and gives, whichever engine it runs on;
//! - [`CpuRenderer`]: the engine in plain Rust, the same to the bit on every x86-64 machine; [`vector_math`]: its elementary functions;
//! - `gpu` and `WgpuRenderer`: the engine on wgpu (feature `wgpu`).
//!
//! The equations, and what they leave out, are in `docs/sensor-model.md`.
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
mod soft_edges;
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
