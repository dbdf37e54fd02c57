//! The terms of a stripe's model one at a time, on the oblique walls of a duct.

mod common;

use common::{LOOKS, base_at, duct, quiet, straight, view, wide};
use ductloop_sensor::exposure_parts::whole;
use ductloop_sensor::frame_geometry::FrameGeometry;
use ductloop_sensor::scenery::Scenery;
use ductloop_sensor::strip::{PixelRay, Strip};
use nalgebra::Vector3;

/// Motion adds a twelfth of the square of the way that the stripe's middle moves across itself, from the beginning of the exposure to
/// its end.
#[test]
fn motion_adds_the_variance_of_an_even_smear() {
    let (rig, optics) = (wide(), quiet());
    let mut view = view(&rig, &base_at(1.0, 0.05, 15.0));
    view.motion.linear_m_s = Vector3::new(0.8, 0.3, 0.0);
    view.motion.angular_rad_s = Vector3::new(0.0, 0.2, 0.9);
    let scenery = Scenery::new(&duct(&[straight(4.0, 0.5, 0.3)]), &LOOKS).expect("sound looks");
    let mut geometry = FrameGeometry::new(&rig, &optics).expect("a sound lens");
    geometry.build(&scenery, &whole(&view, &optics.lens), &view.laser_power).expect("the camera is in the duct");
    let mut compared = 0;
    for strip in &geometry.strips {
        let at = |ridge: Vector3<f64>, sweep: Vector3<f64>, pixel: &PixelRay| {
            Strip { ridge, sweep, ..strip.clone() }.at(pixel, geometry.blur())
        };
        for point in &geometry.band[strip.band.clone()] {
            let pixel = PixelRay::of(geometry.projection(), geometry.projection().ray(point.pixel.into()).into());
            let still = |ridge: Vector3<f64>| at(ridge, Vector3::zeros(), &pixel);
            let [first, middle, last] = [-0.5, 0.0, 0.5].map(|share| still(strip.ridge + strip.sweep * share));
            let moved_px = last.ridge.across_px - first.ridge.across_px;
            let blurred = at(strip.ridge, strip.sweep, &pixel);
            let added_px2 = blurred.spread_px * blurred.spread_px - middle.spread_px * middle.spread_px;
            if moved_px.abs() > 0.3 {
                compared += 1;
                // A stripe's steepness changes a little with its place: a share of `across_px` over its distance in pixels.
                let expected = moved_px * moved_px / 12.0;
                assert!((added_px2 / expected - 1.0).abs() < 0.02, "{added_px2} px^2 for {expected} at {:?}", point.pixel);
            }
        }
    }
    assert!(compared > 20, "only {compared} places move");
}
