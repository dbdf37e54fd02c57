//! Renders what the two rigs see in a few ducts, as PNGs into the folder given (or `gallery`).

#[path = "../tests/common/mod.rs"]
mod common;

use common::{LOOKS, base_at, duct, elbow, incra1, straight, view, wide};
use ductloop_duct::cell::{Solid, SurfaceId};
use ductloop_sensor::optics::Optics;
use ductloop_sensor::{Transform, WgpuRenderer};
use nalgebra::Vector3;

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
    let pictures = [
        ("wide", wide(), plain(0.5), base_at(1.5, 0.0, 0.0)),
        ("wide-offset", wide(), plain(0.5), base_at(1.5, 0.06, 6.0)),
        ("wide-narrow", wide(), plain(0.35), base_at(1.5, 0.0, 0.0)),
        ("wide-broad", wide(), plain(0.8), base_at(1.5, 0.0, 0.0)),
        ("wide-box", wide(), boxed, base_at(1.5, 0.0, 0.0)),
        ("wide-elbow", wide(), bend.clone(), base_at(1.5, 0.0, 0.0)),
        ("wide-elbow-near", wide(), bend, base_at(2.3, 0.0, 0.0)),
        ("incra1", incra1(), plain(0.5), base_at(1.5, 0.0, 0.0)),
    ];
    for (name, rig, network, base) in pictures {
        let mut renderer =
            WgpuRenderer::new(gpu, &network, &rig, &Optics::default(), &LOOKS, 1).expect("the rig and the optics are sound");
        let pixels = common::image(&mut renderer, &rig, &view(&rig, &base));
        let (width, height) = (rig.camera.width_px as u32, rig.camera.height_px as u32);
        image::GrayImage::from_raw(width, height, pixels)
            .expect("as many pixels as the image has")
            .save(format!("{folder}/{name}.png"))
            .expect("the picture can be written");
    }
}
