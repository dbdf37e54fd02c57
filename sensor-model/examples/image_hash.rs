//! Prints a hash of each of some images that between them use all that the CPU renderer can do. They are the same on every machine:
//! `tests/bits.rs` holds them against each other and against its own table. Arguments are the names of the images; without any,
//! all are made.

#[path = "../tests/common/mod.rs"]
mod common;

use common::{base_at, duct, elbow, incra1, straight, view, wide};
use ductloop_duct::cell::{Solid, SurfaceId};
use ductloop_duct::network::{End, Network};
use ductloop_nav::rig::{Distortion, Rig};
use ductloop_sensor::optics::{Bits, Ccd, FanProfile, Lens, Optics};
use ductloop_sensor::renderer::{ImageMut, Motion, Renderer, View};
use ductloop_sensor::surface::Look;
use ductloop_sensor::{CpuRenderer, Transform};
use nalgebra::Vector3;

const ZINC: Look = Look { albedo: 0.35, specular: 0.2, roughness: 0.45, ..Look::matt(0.35) };
const SPANGLED: Look = Look { spangle: 0.15, spangle_m: 0.012, seam_m: 2e-3, ..ZINC };
const MIRROR: Look = Look { albedo: 0.05, specular: 0.9, roughness: 0.02, ..Look::matt(0.05) };

/// An image to be made.
pub(crate) struct Picture {
    /// Its name.
    pub(crate) name: &'static str,
    rig: Rig,
    network: Network,
    optics: Optics,
    looks: [Look; 2],
    view: View,
}

/// The rig with a camera of half the resolution.
fn halved(rig: Rig) -> Rig {
    let mut camera = rig.camera.clone();
    (camera.width_px, camera.height_px) = (camera.width_px / 2, camera.height_px / 2);
    camera.focal_px = camera.focal_px.map(|f| f / 2.0);
    camera.centre_px = camera.centre_px.map(|c| c / 2.0);
    Rig { camera, ..rig }
}

/// The pictures.
pub(crate) fn pictures() -> Vec<Picture> {
    let plain = Optics::default();
    let of = |name, rig: Rig, network: Network, optics: &Optics, look: Look, base: Transform| {
        let view = View { frame: 11, ..view(&rig, &base) };
        Picture { name, rig, network, optics: optics.clone(), looks: [look, Look::matt(0.6)], view }
    };
    let long = || duct(&[straight(6.0, 0.5, 0.3)]);
    let bend = || duct(&[straight(2.5, 0.5, 0.3), elbow(80.0, 0.375, 0.5, 0.3), straight(2.0, 0.5, 0.3)]);
    let mut boxed = long();
    for (x, y, turned_deg) in [(2.0, 0.12, 20.0), (2.3, -0.1, 0.0)] {
        boxed.add_solid(&Solid::cuboid(&base_at(x, y, turned_deg), Vector3::new(0.08, 0.06, 0.12), SurfaceId(1)));
    }
    let joined = Network::from_run(&vec![straight(0.6, 0.5, 0.3); 8], End::Open, End::Open).expect("the fittings fit");
    let mut bent = halved(wide());
    bent.camera.distortion = Distortion { k1: -0.2, k2: 0.03, p1: 5e-4, p2: -5e-4, k3: 1e-3 };
    // Every feature at once, but for motion.
    let rich = Optics { ghosts: true, bounce: true, ambient_dn: 120.0, ..plain.clone() };
    let raw = Optics {
        speckle_grain_px: 2.5,
        ccd: Ccd {
            dsnu_e: 30.0,
            dark_current_e_s: 4e4,
            hot_pixels: 1e-3,
            hot_pixel_e_s: 2e6,
            blooming: 0.8,
            bits: Bits::Twelve,
            ..Ccd::default()
        },
        stripe_peak_dn: 800.0,
        ..plain.clone()
    };
    let unfocused = Optics {
        lens: Lens { aperture_m: 2e-3, ..Lens::default() },
        ccd: Ccd { bits: Bits::Ten, ..Ccd::default() },
        ..rich.clone()
    };
    let bare = Optics {
        noise: false,
        fan_profile: FanProfile::Cylinder,
        lens: Lens { psf_sigma_px: 0.0, vignetting: false, ..Lens::default() },
        ..plain.clone()
    };
    let mut moving = of("moving", halved(wide()), joined.clone(), &plain, SPANGLED, base_at(1.0, 0.05, 5.0));
    moving.view.motion = Motion { linear_m_s: Vector3::new(0.5, 0.0, 0.0), angular_rad_s: Vector3::new(0.0, 0.0, 2.0) };
    vec![
        of("plain", wide(), long(), &plain, Look::matt(0.5), base_at(1.5, 0.02, 3.0)),
        of("zinc", wide(), long(), &rich, ZINC, base_at(1.5, 0.02, 3.0)),
        of("portrait", halved(incra1()), bend(), &plain, ZINC, base_at(2.2, 0.0, 0.0)),
        of("boxes", halved(wide()), boxed.clone(), &plain, ZINC, base_at(1.5, 0.0, 0.0)),
        of("bent", bent.clone(), boxed, &rich, SPANGLED, base_at(1.5, 0.05, 3.0)),
        of("joints", halved(wide()), joined, &rich, SPANGLED, base_at(1.0, 0.05, 5.0)),
        moving,
        of("raw", halved(wide()), long(), &raw, Look::matt(0.5), base_at(1.5, 0.15, 0.0)),
        of("unfocused", bent, bend(), &unfocused, ZINC, base_at(1.8, 0.05, 3.0)),
        of("mirrors", halved(wide()), bend(), &rich, MIRROR, base_at(1.9, 0.0, 0.0)),
        of("bare", halved(wide()), bend(), &bare, ZINC, base_at(2.4, 0.0, 5.0)),
    ]
}

impl Picture {
    /// FNV-1a of the image's bytes, made on so many threads.
    pub(crate) fn hash(&self, threads: usize) -> u64 {
        let mut hash = 0;
        self.film(threads, |render| {
            render(0, &mut |image| {
                hash = match image {
                    Image::Grey8(values) => fnv1a(values.iter().copied()),
                    Image::Grey16(values) => fnv1a(values.iter().flat_map(|value| value.to_le_bytes())),
                }
            });
        });
        hash
    }

    /// Hands over what makes the frames after the picture's own: frame 0 is the picture, the robot moves on by 2 mm a frame.
    pub(crate) fn film(&self, threads: usize, shoot: impl FnOnce(Camera<'_>)) {
        let Self { rig, network, optics, looks, .. } = self;
        let mut renderer = CpuRenderer::new(network, rig, optics, looks, 3, threads).expect("the picture is sound");
        let pixels = rig.camera.width_px * rig.camera.height_px;
        let mut image =
            if optics.ccd.bits == Bits::Eight { Image::Grey8(vec![0_u8; pixels]) } else { Image::Grey16(vec![0_u16; pixels]) };
        shoot(&mut |frame, look| {
            let mut view = self.view.clone();
            view.frame += frame;
            view.world_from_camera.translation.vector.x += 0.002 * frame as f64;
            let room = match &mut image {
                Image::Grey8(values) => ImageMut::Grey8(values),
                Image::Grey16(values) => ImageMut::Grey16(values),
            };
            renderer.render(&view, room).expect("the camera is in the duct");
            look(&image);
        });
    }
}

/// An image of either depth.
pub(crate) enum Image {
    /// Of 8 bits.
    Grey8(Vec<u8>),
    /// Of more.
    Grey16(Vec<u16>),
}

/// Makes a frame and shows it.
pub(crate) type Camera<'a> = &'a mut dyn FnMut(u64, &mut dyn FnMut(&Image));

fn fnv1a(bytes: impl Iterator<Item = u8>) -> u64 {
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

#[allow(dead_code)] // the test includes this file
fn main() {
    let asked: Vec<String> = std::env::args().skip(1).collect();
    for picture in pictures().iter().filter(|picture| asked.is_empty() || asked.iter().any(|name| name == picture.name)) {
        println!("{} {:016x}", picture.name, picture.hash(1));
    }
}
