//! Automatic exposure in the closed loop: on surfaces darker and brighter than the exposure was chosen for, stripes end up as bright
//! as they were asked to be.

use std::ops::ControlFlow;

use ductloop::closed_loop::{Pace, run_with};
use ductloop::{Engine, GreyImage, Pilot, Pixels, Scenario, Verdict};

/// Drives down a duct of this surface; returns the verdict, exposure and power of each frame, and the last image.
fn run(surface: &str, more: &str) -> (Verdict, Vec<(f64, f64)>, GreyImage, Scenario) {
    let text = format!(
        "format = 1\nkind = \"scenario\"\nname = \"t\"\n[sensor]\npreset = \"wide\"\nexposure = \"auto\"\n{more}\n[duct]\nwidth_m = 0.5\n\
         height_m = 0.3\nsurface = \"{surface}\"\nrun = [{{ straight_m = 6.0 }}]\n[finish]\nbefore_end_m = 4.0\n[pass]\ncompleted = true\n"
    );
    let scenario = Scenario::from_toml_str(&text).unwrap_or_else(|wrong| panic!("{}", wrong.render(false)));
    let mut renderer = Engine::Cpu.renderer(&scenario, 1).expect("a renderer");
    let mut last = None;
    let record = run_with(&scenario, Pilot::of(&scenario), renderer.as_mut(), Pace::Overlapped, |_, image| {
        last = Some(image.clone());
        ControlFlow::Continue(())
    })
    .expect("a run");
    let metrics = ductloop::Metrics::of(&scenario, &record, None);
    let (verdict, _) = ductloop::metrics::judge(&scenario, &record, &metrics);
    let light = record.frames.iter().map(|f| (f.view.exposure_s, f.laser_power)).collect();
    (verdict, light, last.expect("frames"), scenario)
}

/// How bright the stripes are by another way than the navigator's: the tenth brightest of a hundred columns' largest values, less
/// the column's median.
fn stripes_dn(image: &GreyImage) -> f64 {
    let [width, height] = image.size_px();
    let Pixels::Grey8(values) = image.pixels() else { panic!("8 bits") };
    let mut peaks: Vec<u8> = (0..width)
        .map(|x| {
            let mut column: Vec<u8> = (0..height).map(|y| values[y * width + x]).collect();
            column.sort_unstable();
            column[height - 2] - column[height / 2]
        })
        .filter(|peak| *peak >= 6)
        .collect();
    peaks.sort_unstable();
    f64::from(peaks[peaks.len() * 9 / 10])
}

#[test]
fn stripes_become_as_bright_as_asked_on_dark_and_on_bright_walls() {
    for surface in ["greasy", "painted"] {
        let (verdict, light, image, scenario) = run(surface, "");
        assert_eq!(verdict, Verdict::Pass, "{surface}");
        let (seen, target) = (stripes_dn(&image), scenario.auto_exposure.target_dn);
        assert!((seen / target - 1.0).abs() < 0.15, "{surface}: {seen} DN instead of {target}");
        // It has come to rest: what is left is speckle in the brightness that the navigator reads.
        let doses: Vec<f64> = light.iter().map(|(exposure_s, power)| exposure_s * power).collect();
        let last = doses[doses.len() - 1];
        assert!(doses[doses.len() - 30..].iter().all(|dose| (dose / last - 1.0).abs() < 0.1), "{surface}: {doses:?}");
        // The exposure goes first: power only where the exposure has reached its limit.
        let [_, longest_s] = scenario.auto_exposure.exposure_s;
        assert!(light.iter().all(|(exposure_s, power)| *power == 1.0 || *exposure_s == longest_s), "{surface}: {light:?}");
        assert_eq!(light[0], (scenario.optics.exposure_s, 1.0));
    }
}

/// Whatever the walls are made of, the robot finds its stripes and arrives: also on rubber and polished sheet, which show none at
/// first.
#[test]
fn every_preset_surface_is_driven_down() {
    let mut surfaces: Vec<String> = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/presets/surface"))
        .expect("presets")
        .map(|file| file.expect("a file").path().file_stem().expect("a name").to_str().expect("UTF-8").to_owned())
        .collect();
    surfaces.sort();
    for surface in surfaces {
        let (verdict, light, ..) = run(&surface, "");
        assert_eq!(verdict, Verdict::Pass, "{surface}: {light:?}");
        let searched = light[1..].iter().position(|now| *now != light[0]).is_some_and(|frames| frames >= 14);
        assert_eq!(searched, ["mirror", "rubber"].contains(&surface.as_str()), "{surface}: {light:?}");
    }
}

#[test]
fn a_range_that_is_too_narrow_is_kept_to() {
    let (_, light, ..) = run("greasy", "[sensor.auto_exposure]\nmin_ms = 3.0\nmax_ms = 5.0\nmax_power = 1.0\n");
    assert_eq!(light.last(), Some(&(0.005, 1.0)));
    let (_, light, ..) =
        run("painted", "[sensor.auto_exposure]\ntarget_dn = 12.0\nmin_ms = 3.9\nmax_ms = 5.0\nmin_power = 0.5\n");
    assert_eq!(light.last(), Some(&(0.0039, 0.5)));
}
