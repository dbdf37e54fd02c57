//! What renderers refuse, and that they say why.
#![cfg(feature = "wgpu")]

mod common;

use common::{LOOKS, base_at, duct, quiet, straight, view, wide};
use ductloop_duct::cell::{Solid, SurfaceId};
use ductloop_duct::network::Network;
use ductloop_nav::rig::Rig;
use ductloop_sensor::frame_geometry::{Obstacle, clear_cell};
use ductloop_sensor::gpu::Gpu;
use ductloop_sensor::optics::{Lens, Optics};
use ductloop_sensor::renderer::{RenderError, Renderer, View};
use ductloop_sensor::scenery::Scenery;
use ductloop_sensor::surface::Look;
use ductloop_sensor::{CpuRenderer, Transform, WgpuRenderer};
use nalgebra::{Point3, Vector3};

fn made(rig: &Rig, optics: &Optics, looks: &[Look]) -> Option<Result<WgpuRenderer, RenderError>> {
    Some(WgpuRenderer::new(common::gpu()?, &duct(&[straight(6.0, 0.5, 0.3)]), rig, optics, looks, 1))
}

#[test]
fn parameters_out_of_bounds_are_refused_at_the_start() {
    let refused = |rig: &Rig, optics: &Optics, looks: &[Look], part: &str| {
        let Some(made) = made(rig, optics, looks) else { return };
        let message = made.expect_err(part).to_string();
        assert!(message.contains(part), "{message}");
    };
    let rig = wide();
    refused(&rig, &quiet(), &[], "surface 0 of the duct has no look: the table has 0 entries");
    refused(&rig, &quiet(), &[Look::matt(1.5)], "albedo is 1.5");
    refused(
        &rig,
        &Optics { lens: Lens { psf_sigma_px: 2.0, ..Lens::default() }, ..quiet() },
        &LOOKS,
        "psf_sigma_px is 2; it must be from 0 to 1.2",
    );
    let mut five = rig.clone();
    five.lasers = vec![rig.lasers[0].clone(); 5];
    refused(&five, &quiet(), &LOOKS, "5 lasers; at most 4");
    let mut broad = rig.clone();
    broad.lasers[1].fan_rad = 3.0;
    refused(&broad, &quiet(), &LOOKS, "the fan of laser `high` opens by 171.9 degrees");
    let mut none = rig;
    none.lasers.clear();
    refused(&none, &quiet(), &LOOKS, "the rig has no laser");
}

#[test]
fn a_frame_that_cannot_be_made_leaves_the_image_alone() {
    let rig = wide();
    let Some(Ok(mut renderer)) = made(&rig, &quiet(), &LOOKS) else {
        assert!(common::gpu().is_none());
        return;
    };
    let mut pixels = vec![77_u8; 640 * 480];
    let inside = view(&rig, &base_at(1.5, 0.0, 0.0));
    let outside = view(&rig, &base_at(1.5, 0.3, 0.0));
    let error = renderer.render(&outside, pixels.as_mut_slice().into()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the camera at (1.620, 0.300, 0.100) m, looking along (1.000, 0.000, 0.000), is outside the duct: it must stand inside, \
         2 mm or more from the metal"
    );
    let nowhere = view(&rig, &base_at(f64::NAN, 0.0, 0.0));
    assert!(matches!(renderer.render(&nowhere, pixels.as_mut_slice().into()), Err(RenderError::OutsideNetwork { .. })));
    let dark = View { exposure_s: f64::NAN, ..inside.clone() };
    assert!(matches!(renderer.render(&dark, pixels.as_mut_slice().into()), Err(RenderError::ViewValue { .. })));
    let short = renderer.render(&inside, (&mut pixels[1..]).into()).unwrap_err();
    assert_eq!(short, RenderError::BufferSize { expected: 640 * 480, given: 640 * 480 - 1 });
    assert!(pixels.iter().all(|dn| *dn == 77));
    // After all of which it still renders.
    renderer.render(&inside, pixels.as_mut_slice().into()).unwrap();
    assert!(pixels.iter().any(|dn| *dn > 20));
}

/// A block on the floor, from x = 2.95 to 3.05 m, y = -0.05 to 0.05 m and up to z = 0.1 m, in a duct in two pieces that join
/// within it.
fn blocked() -> Network {
    let mut network = duct(&[straight(3.0, 0.5, 0.3), straight(3.0, 0.5, 0.3)]);
    let world_from_block = Transform::translation(3.0, 0.0, 0.0);
    network.add_solid(&Solid::cuboid(&world_from_block, Vector3::new(0.1, 0.1, 0.1), SurfaceId(0)));
    network
}

#[test]
fn a_camera_against_metal_is_refused_by_both_renderers() {
    let rig = wide();
    let network = blocked();
    let cpu = CpuRenderer::new(&network, &rig, &quiet(), &LOOKS, 1, 1).expect("a sound scene");
    let mut renderers: Vec<Box<dyn Renderer>> = vec![Box::new(cpu)];
    if let Some(gpu) = common::gpu() {
        renderers.push(Box::new(WgpuRenderer::new(gpu, &network, &rig, &quiet(), &LOOKS, 1).expect("a sound scene")));
    }
    // Looking along the duct.
    let at = |x_m: f64, y_m: f64, z_m: f64| {
        let mut view = view(&rig, &base_at(0.0, 0.0, 0.0));
        view.world_from_camera.translation.vector = Vector3::new(x_m, y_m, z_m);
        view
    };
    let mut pixels = vec![77_u8; 640 * 480];
    for renderer in &mut renderers {
        pixels.fill(77);
        for (x_m, y_m, z_m) in [
            // In the wall's plane, a millimetre before it, at floor and ceiling.
            (1.0, 0.25, 0.1),
            (1.0, -0.249, 0.1),
            (1.0, 0.0, 0.0),
            (1.0, 0.0, 0.2985),
            // In the block's middle, just inside it, just above it.
            (3.0, 0.0, 0.05),
            (2.96, 0.0, 0.09),
            (3.0, 0.0, 0.1015),
        ] {
            let error = renderer.render(&at(x_m, y_m, z_m), pixels.as_mut_slice().into()).expect_err("metal");
            assert!(matches!(error, RenderError::AgainstMetal { position_m, .. } if position_m == [x_m, y_m, z_m]), "{error}");
            assert!(error.to_string().contains("in the duct but nearer than 2 mm to the metal"), "{error}");
        }
        assert!(pixels.iter().all(|dn| *dn == 77));
        // As near as it may be; and in the joint, which is no wall, above the block.
        for (x_m, y_m, z_m) in [(1.0, 0.248, 0.1), (1.0, 0.0, 0.002), (3.0, 0.0, 0.102), (2.9999, 0.1, 0.1)] {
            renderer.render(&at(x_m, y_m, z_m), pixels.as_mut_slice().into()).expect("a free camera");
            assert!(pixels.iter().any(|dn| *dn > 20), "({x_m}, {y_m}, {z_m})");
        }
    }
}

#[test]
fn metal_beyond_an_opening_is_metal() {
    // A block that begins half a millimetre past the joint at x = 3 m: only the second cell knows it.
    let mut network = duct(&[straight(3.0, 0.5, 0.3), straight(3.0, 0.5, 0.3)]);
    let world_from_block = Transform::translation(3.0505, 0.0, 0.0);
    network.add_solid(&Solid::cuboid(&world_from_block, Vector3::new(0.1, 0.1, 0.1), SurfaceId(0)));
    assert_eq!([0, 1].map(|cell| network.cells[cell].solids.len()), [0, 1]);
    let scenery = Scenery::new(&network, &LOOKS).expect("sound looks");
    let clear = |x_m: f64, y_m: f64| clear_cell(&scenery, &Point3::new(x_m, y_m, 0.05), 0);
    assert_eq!((clear(2.9995, 0.0), clear(2.9984, 0.0)), (Err(Obstacle::Metal), Ok(0)));
    // Beside it, in the joint.
    assert_eq!((clear(2.9995, 0.1), clear(3.0005, 0.1)), (Ok(0), Ok(1)));
    assert_eq!(clear(2.9995, 0.3), Err(Obstacle::Outside));
}

#[test]
fn a_width_that_is_no_multiple_of_four_is_packed_right() {
    // The same camera, three columns narrower on the right: the same pixels but for those.
    let rig = wide();
    let mut narrow = rig.clone();
    narrow.camera.width_px = 637;
    let view = view(&rig, &base_at(1.5, 0.06, 6.0));
    let (Some(Ok(mut a)), Some(Ok(mut b))) = (made(&rig, &quiet(), &LOOKS), made(&narrow, &quiet(), &LOOKS)) else {
        assert!(common::gpu().is_none());
        return;
    };
    let (wide_image, narrow_image) = (common::image(&mut a, &rig, &view), common::image(&mut b, &narrow, &view));
    for (row, (a, b)) in wide_image.chunks(640).zip(narrow_image.chunks(637)).enumerate() {
        assert!(a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) <= 1), "row {row}");
    }
}

#[test]
fn a_lost_device_is_an_error_and_no_frame() {
    // A device of its own: the other tests go on with theirs.
    if common::gpu().is_none() {
        return;
    }
    let gpu = Gpu::open().expect("a second device of an adapter that is there");
    let rig = wide();
    let network = duct(&[straight(6.0, 0.5, 0.3)]);
    let mut renderer = WgpuRenderer::new(&gpu, &network, &rig, &quiet(), &LOOKS, 1).expect("rig and optics are sound");
    let view = view(&rig, &base_at(1.5, 0.0, 0.0));
    let mut pixels = vec![77_u8; 640 * 480];
    renderer.render(&view, pixels.as_mut_slice().into()).unwrap();
    assert!(pixels.iter().any(|dn| *dn > 20));
    gpu.close();
    pixels.fill(77);
    for _ in 0..2 {
        let error = renderer.render(&view, pixels.as_mut_slice().into()).unwrap_err();
        assert!(matches!(error, RenderError::Lost(_)), "{error}");
    }
    assert!(pixels.iter().all(|dn| *dn == 77), "the image was touched");
    let another = WgpuRenderer::new(&gpu, &network, &rig, &quiet(), &LOOKS, 1).expect_err("its device is gone");
    assert!(matches!(another, RenderError::Lost(_)), "{another}");
}
