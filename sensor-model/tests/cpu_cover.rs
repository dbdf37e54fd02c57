//! In a closed duct every pixel of the CPU renderer's image sees a wall: none is lost between two of them.

mod common;

use common::{base_at, incra1, straight, view, wide};
use ductloop_duct::network::{End, Network};
use ductloop_nav::rig::{Distortion, Rig};
use ductloop_sensor::CpuRenderer;
use ductloop_sensor::optics::{Bits, Ccd, Lens, Optics};
use ductloop_sensor::renderer::{ImageMut, Renderer};
use ductloop_sensor::surface::Look;

/// A bright headlamp alone, unblurred, in twelve bits.
fn lamp() -> Optics {
    Optics {
        headlamp_peak_dn: 2000.0,
        noise: false,
        lens: Lens { psf_sigma_px: 0.0, ..Lens::default() },
        ccd: Ccd { bits: Bits::Twelve, black_level_dn: 0.0, ..Ccd::default() },
        ..Optics::default()
    }
}

/// Pixels darker than a quarter of the darkest of their four neighbours.
fn holes(image: &[u16], width: usize) -> usize {
    let beside = |at: usize| [at - 1, at + 1, at - width, at + width].map(|at| image[at]).into_iter().min().expect("four");
    let inside = |at: &usize| (1..width - 1).contains(&(at % width));
    (width..image.len() - width).filter(inside).filter(|at| 4 * image[*at] < beside(*at)).count()
}

#[test]
fn no_pixel_is_lost() {
    // Only walls that are seen at their full size: an elbow's are slivers of a pixel here and there, rightly darker than their neighbours.
    let fittings = [0.8, 0.8, 0.3, 0.7].map(|length_m| straight(length_m, 0.5, 0.3));
    let network = Network::from_run(&fittings, End::Cap, End::Cap).expect("the fittings fit");
    let bent = Distortion { k1: -0.2, k2: 0.03, p1: 5e-4, p2: -5e-4, k3: 0.0 };
    // An image whose rows are no whole number of blocks, nor its height one of bands, among them.
    for (rig, size, distortion) in [
        (wide(), [640, 480], Distortion::NONE),
        (wide(), [640, 480], bent),
        (wide(), [333, 217], bent),
        (wide(), [17, 33], Distortion::NONE),
        (incra1(), [640, 480], Distortion::NONE),
    ] {
        let mut camera = rig.camera.clone();
        let scale = size[0] as f64 / camera.width_px as f64;
        [camera.width_px, camera.height_px] = size;
        camera.focal_px = camera.focal_px.map(|f| f * scale);
        camera.centre_px = size.map(|n| (n as f64 - 1.0) / 2.0);
        camera.distortion = distortion;
        let rig = Rig { camera, ..rig };
        let mut renderer = CpuRenderer::new(&network, &rig, &lamp(), &[Look::matt(0.5)], 1, 1).expect("a renderer");
        let mut image = vec![0_u16; size[0] * size[1]];
        // Standing in the middle, edges run exactly through pixels' centres; elsewhere anyhow.
        let poses = (0..24).map(|i| (0.3 + 0.05 * f64::from(i), 0.004 * f64::from(i % 5), 1.7 * f64::from(i % 7)));
        for (x, y, heading_deg) in poses.chain([(0.5, 0.0, 0.0), (0.8, 0.0, 0.0), (0.68, 0.0, 0.0)]) {
            let mut view = view(&rig, &base_at(x, y, heading_deg));
            view.laser_power = [0.0; 4];
            renderer.render(&view, ImageMut::Grey16(&mut image)).expect("the camera is in the duct");
            let lost = image.iter().filter(|value| **value == 0).count();
            assert_eq!((lost, holes(&image, size[0])), (0, 0), "{size:?} {distortion:?} at ({x}, {y}), {heading_deg} degrees");
        }
    }
}
