//! Renders what the two rigs see in a few ducts, as PNGs into the folder given (or `gallery`).

#[path = "../tests/common/mod.rs"]
mod common;

use common::{LOOKS, base_at, duct, elbow, incra1, straight, view, wide};
use ductloop_duct::cell::{Solid, SurfaceId};
use ductloop_duct::network::Network;
use ductloop_nav::rig::{Distortion, Rig};
use ductloop_sensor::optics::{Ccd, Lens, Optics};
use ductloop_sensor::renderer::{Motion, View};
use ductloop_sensor::surface::Look;
use ductloop_sensor::{Transform, WgpuRenderer};
use nalgebra::Vector3;

/// Galvanised steel, spangled, with seams.
const SPANGLED: [Look; 2] =
    [Look { specular: 0.2, roughness: 0.45, spangle: 0.15, spangle_m: 8e-3, seam_m: 1.5e-3, ..Look::matt(0.35) }; 2];

/// Polished sheet.
const MIRROR: [Look; 2] = [Look { specular: 0.8, roughness: 0.02, ..Look::matt(0.08) }; 2];

struct Picture {
    name: &'static str,
    rig: Rig,
    network: Network,
    base: Transform,
    optics: Optics,
    looks: [Look; 2],
    motion: Motion,
}

fn main() {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "gallery".to_owned());
    std::fs::create_dir_all(&folder).expect("the folder can be made");
    let gpu = common::gpu().expect("an adapter");
    println!("{:?}", gpu.adapter());
    let plain = |width| duct(&[straight(6.0, width, 0.3)]);
    let mut boxed = plain(0.5);
    let stand = Transform::translation(2.4, 0.12, 0.0);
    boxed.add_solid(&Solid::cuboid(&stand, Vector3::new(0.08, 0.06, 0.12), SurfaceId(1)));
    let bend = duct(&[straight(2.5, 0.5, 0.3), elbow(90.0, 0.375, 0.5, 0.3), straight(2.0, 0.5, 0.3)]);
    let cut = duct(&[straight(1.9, 0.5, 0.3), straight(0.7, 0.5, 0.3), straight(3.4, 0.5, 0.3)]);
    let plainly = |name, rig, network, base| Picture {
        name,
        rig,
        network,
        base,
        optics: Optics::default(),
        looks: LOOKS,
        motion: Motion::default(),
    };
    let mut bent = wide();
    bent.camera.distortion = Distortion { k1: -0.22, k2: 0.05, p1: 0.001, p2: -0.0007, k3: -0.003 };
    let reflections = Optics { ghosts: true, bounce: true, ..Optics::default() };
    let poor = Ccd { dsnu_e: 150.0, hot_pixels: 1e-3, hot_pixel_e_s: 2e6, full_well_e: 8000.0, blooming: 0.7, ..Ccd::default() };
    let turning = Motion { linear_m_s: Vector3::x() * 0.3, angular_rad_s: Vector3::z() * 3.0 };
    let ahead = base_at(1.5, 0.0, 0.0);
    let pictures = [
        plainly("wide", wide(), plain(0.5), ahead),
        plainly("wide-offset", wide(), plain(0.5), base_at(1.5, 0.06, 6.0)),
        plainly("wide-narrow", wide(), plain(0.35), ahead),
        plainly("wide-broad", wide(), plain(0.8), ahead),
        plainly("wide-box", wide(), boxed.clone(), ahead),
        plainly("wide-elbow", wide(), bend.clone(), ahead),
        plainly("wide-elbow-near", wide(), bend.clone(), base_at(2.3, 0.0, 0.0)),
        plainly("incra1", incra1(), plain(0.5), ahead),
        plainly("distorted", bent, boxed.clone(), ahead),
        Picture { looks: SPANGLED, ..plainly("spangle-and-seams", wide(), cut, ahead) },
        Picture {
            looks: SPANGLED,
            optics: reflections.clone(),
            ..plainly("reflections", wide(), bend.clone(), base_at(2.3, 0.0, 0.0))
        },
        Picture { looks: MIRROR, optics: reflections, ..plainly("mirror", wide(), boxed.clone(), ahead) },
        Picture {
            optics: Optics { ambient_dn: 120.0, ..Optics::default() },
            ..plainly("daylight", wide(), plain(0.5), base_at(1.0, 0.0, 180.0))
        },
        Picture { motion: turning, ..plainly("turning", wide(), boxed.clone(), ahead) },
        Picture {
            optics: Optics { lens: Lens { aperture_m: 4e-3, focus_m: 0.3, ..Lens::default() }, ..Optics::default() },
            ..plainly("defocus", wide(), boxed, ahead)
        },
        Picture {
            optics: Optics { ccd: poor, speckle_grain_px: 2.5, stripe_peak_dn: 900.0, ..Optics::default() },
            ..plainly("poor-ccd", wide(), bend, ahead)
        },
    ];
    for Picture { name, rig, network, base, optics, looks, motion } in pictures {
        let mut renderer = WgpuRenderer::new(gpu, &network, &rig, &optics, &looks, 1).expect("the rig and the optics are sound");
        // Three times the nominal exposure, so that the image's sides can be seen.
        let view = View { motion, exposure_s: 12e-3, ..view(&rig, &base) };
        let pixels = common::image(&mut renderer, &rig, &view);
        let (width, height) = (rig.camera.width_px as u32, rig.camera.height_px as u32);
        image::GrayImage::from_raw(width, height, pixels)
            .expect("as many pixels as the image has")
            .save(format!("{folder}/{name}.png"))
            .expect("the picture can be written");
    }
}
