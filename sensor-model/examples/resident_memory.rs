//! Resident memory of a process that renders many frames: nothing may grow from frame to frame. Linux only (`/proc`).
//!
//! The `wide` rig drives to and fro before an elbow of a spangled duct, with ghosts, bounce, daylight, defocus and every noise. A line
//! each for the CPU renderer (10 000 frames, or as many as an argument says) and wgpu (three tenths of that), with what is resident after
//! the first time to and fro, and after the last frame.

#[path = "../tests/common/mod.rs"]
mod common;

use std::fs;

use common::{base_at, duct, elbow, straight, view, wide};
use ductloop_nav::rig::Rig;
use ductloop_sensor::optics::{Ccd, Lens, Optics};
use ductloop_sensor::renderer::{Motion, Renderer, View};
use ductloop_sensor::surface::Look;
use ductloop_sensor::{CpuRenderer, WgpuRenderer};
use nalgebra::Vector3;

/// Frames of the way to and fro: 1.5 m at 10 mm a frame, twice.
const ROUND: u64 = 300;

fn main() {
    let frames: u64 = std::env::args().nth(1).map_or(10_000, |text| text.parse().expect("a number of frames"));
    let network = duct(&[straight(2.5, 0.5, 0.3), elbow(90.0, 0.375, 0.5, 0.3), straight(2.0, 0.5, 0.3)]);
    let rig = wide();
    let looks = [Look { specular: 0.2, roughness: 0.45, spangle: 0.15, spangle_m: 8e-3, seam_m: 1.5e-3, ..Look::matt(0.35) }; 2];
    let optics = Optics {
        ghosts: true,
        bounce: true,
        ambient_dn: 20.0,
        lens: Lens { aperture_m: 1e-3, ..Lens::default() },
        ccd: Ccd { dsnu_e: 20.0, dark_current_e_s: 50.0, hot_pixels: 1e-4, hot_pixel_e_s: 1e4, blooming: 0.5, ..Ccd::default() },
        ..Optics::default()
    };
    let mut cpu = CpuRenderer::new(&network, &rig, &optics, &looks, 1, 1).expect("rig and optics are sound");
    measure("cpu", frames.max(2 * ROUND), &mut cpu, &rig);
    drop(cpu);
    if let Some(gpu) = common::gpu() {
        let mut wgpu = WgpuRenderer::new(gpu, &network, &rig, &optics, &looks, 1).expect("rig and optics are sound");
        measure("wgpu", (frames * 3 / 10).max(2 * ROUND), &mut wgpu, &rig);
    }
}

/// Renders so many frames and prints what is resident on the way.
fn measure(name: &str, frames: u64, renderer: &mut dyn Renderer, rig: &Rig) {
    let mut image = vec![0_u8; rig.camera.width_px * rig.camera.height_px];
    let mut after_round_mib = 0.0;
    for frame in 0..frames {
        if frame == ROUND {
            after_round_mib = resident_mib();
        }
        let step = (frame % ROUND).min(ROUND - frame % ROUND);
        let base = base_at(1.0 + 0.01 * step as f64, 0.03, 2.0);
        let motion = Motion { linear_m_s: Vector3::x() * 0.3, ..Motion::default() };
        let seen = View { frame, motion, ..view(rig, &base) };
        renderer.render(&seen, image.as_mut_slice().into()).expect("the camera is in the duct");
    }
    println!("{name}: resident after {ROUND} frames {after_round_mib:.1} MiB, after {frames} {:.1} MiB", resident_mib());
}

/// What of this process is in memory, in MiB.
fn resident_mib() -> f64 {
    let status = fs::read_to_string("/proc/self/status").expect("Linux");
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("a process is resident");
    let kib: f64 = line.trim().trim_end_matches(" kB").parse().expect("a number of KiB");
    kib / 1024.0
}
