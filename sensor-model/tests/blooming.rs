//! Charge beyond the full well: what is not drained is found again along the column.

mod common;

use common::{base_at, facing_wall, square_on, view};
use ductloop_sensor::CpuRenderer;
use ductloop_sensor::optics::{Bits, Ccd, Optics};
use ductloop_sensor::renderer::Renderer;
use ductloop_sensor::surface::Look;

/// Charge of a column in full wells, and how many of its pixels are full, for a level stripe `power` times as bright as a full
/// well's hundredth.
fn column(blooming: f64, power: f64) -> (f64, usize) {
    let ccd = Ccd { blooming, black_level_dn: 0.0, bits: Bits::Twelve, ..Ccd::default() };
    let optics = Optics { noise: false, headlamp_peak_dn: 0.0, stripe_peak_dn: 2.5, ccd, ..Optics::default() };
    let rig = square_on();
    let mut renderer = CpuRenderer::new(&facing_wall(), &rig, &optics, &[Look::matt(0.5)], 1, 1).expect("a sound scene");
    let mut view = view(&rig, &base_at(1.0, 0.0, 0.0));
    view.laser_power = [power; 4];
    let mut image = vec![0_u16; 640 * 480];
    renderer.render(&view, image.as_mut_slice().into()).expect("a frame");
    let column = || (0..480).map(|row| image[row * 640 + 320]);
    (column().map(|v| f64::from(v) / 4095.0).sum(), column().filter(|v| *v == 4095).count())
}

#[test]
fn spilled_charge_is_neither_lost_nor_made() {
    let (faint, full) = column(0.0, 50.0);
    assert_eq!(full, 0, "half a full well does not spill");
    let bright = 20.0;
    let (clipped, _) = column(0.0, 50.0 * bright);
    let (all, full) = column(1.0, 50.0 * bright);
    assert!(clipped < 0.5 * faint * bright, "most of the light is beyond the full well");
    // 1 DN of 12 bits in each of 480 pixels is 0.12 full wells.
    assert!((all - faint * bright).abs() < 0.3, "{all} full wells of {}", faint * bright);
    assert!(full as f64 > 0.9 * all - 12.0, "the column is full over {full} pixels");
    let (half, _) = column(0.5, 50.0 * bright);
    let spilled = half - clipped;
    assert!((spilled - 0.5 * (faint * bright - clipped)).abs() < 0.3, "half of what is beyond: {spilled}");
}
