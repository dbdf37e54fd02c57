//! A camera from a file of its own, or out of a rig's or a scenario's.

use std::path::Path;

use ductloop_nav::rig::{Camera, Distortion};
use serde::Deserialize;

use super::places;
use crate::bounded_file;
use crate::scenario::{Diagnostic, Diagnostics};

/// Largest file that is read, as of scenarios.
pub(super) const MOST_BYTES: u64 = 8 << 20;

/// INCRA I's camera, an 8 mm lens on 7.4 um pixels, as `presets/sensor/incra1.toml` has it.
pub fn incra1() -> Camera {
    Camera { width_px: 640, height_px: 480, focal_px: [1081.0; 2], centre_px: [320.0, 240.0], distortion: Distortion::NONE }
}

#[derive(Deserialize)]
struct File {
    sensor: Option<Sensor>,
    camera: Option<Typed>,
}

#[derive(Deserialize)]
struct Sensor {
    camera: Option<Typed>,
}

/// `[camera]` as typed. How it is mounted is read over; what it does not know is an error.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Typed {
    width_px: usize,
    height_px: usize,
    focal_px: Focal,
    centre_px: [f64; 2],
    #[serde(default)]
    distortion: [f64; 5],
    #[serde(rename = "roll_deg")]
    _roll_deg: Option<f64>,
    #[serde(rename = "position_in_base_m")]
    _position_in_base_m: Option<[f64; 3]>,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "a number, or two of them: [along u, along v]")]
enum Focal {
    One(f64),
    Two([f64; 2]),
}

/// Reads `[sensor.camera]` or `[camera]` of a TOML file: `width_px`, `height_px`, `focal_px`, `centre_px`, and `distortion` if any.
///
/// # Errors
/// What is wrong, with its place.
pub fn read(path: &Path) -> Result<Camera, Diagnostics> {
    let file = path.display().to_string();
    let text = bounded_file::read_text(path, MOST_BYTES).map_err(|error| whole(&file, format!("cannot be read: {error}")))?;
    parse(&file, &text)
}

/// The same of a text; errors name it `file`.
///
/// # Errors
/// As [`read`].
pub fn parse(file: &str, text: &str) -> Result<Camera, Diagnostics> {
    let read: File = toml::from_str(text).map_err(|error| {
        let place = error.span().map(|span| places::at(text, span.start));
        Diagnostics(vec![Diagnostic::new(file, place, error.message(), None)])
    })?;
    let Some(typed) = read.sensor.and_then(|sensor| sensor.camera).or(read.camera) else {
        return Err(whole(file, "holds no camera: neither `[sensor.camera]` nor `[camera]`".into()));
    };
    let focal_px = match typed.focal_px {
        Focal::One(focal) => [focal; 2],
        Focal::Two(both) => both,
    };
    let [k1, k2, p1, p2, k3] = typed.distortion;
    let camera = Camera {
        width_px: typed.width_px,
        height_px: typed.height_px,
        focal_px,
        centre_px: typed.centre_px,
        distortion: Distortion { k1, k2, p1, p2, k3 },
    };
    let size = 16..=8192;
    let wrong = if !size.contains(&camera.width_px) || !size.contains(&camera.height_px) {
        Some("width_px and height_px must be from 16 to 8192")
    } else if !focal_px.iter().all(|focal| (1.0..=1e5).contains(focal)) {
        Some("focal_px must be from 1 to 100000")
    } else if !camera.centre_px.iter().all(|centre| centre.abs() <= 1e4) {
        Some("centre_px must be from -10000 to 10000")
    } else if !typed.distortion.iter().all(|k| k.abs() <= 10.0) {
        Some("distortion must be from -10 to 10")
    } else {
        None
    };
    wrong.map_or(Ok(camera), |message| Err(whole(file, message.into())))
}

/// A camera as `[sensor.camera]`: how it is mounted is left out.
pub(super) fn camera_table(camera: &Camera) -> String {
    let Camera { width_px, height_px, focal_px: [along_u, along_v], centre_px: [u0, v0], distortion: d } = camera;
    let focal = if along_u == along_v { format!("{along_u:?}") } else { format!("[{along_u:?}, {along_v:?}]") };
    format!(
        "[sensor.camera]\nwidth_px = {width_px}\nheight_px = {height_px}\nfocal_px = {focal}\ncentre_px = [{u0:?}, {v0:?}]\n\
         distortion = [{:?}, {:?}, {:?}, {:?}, {:?}]\n",
        d.k1, d.k2, d.p1, d.p2, d.k3
    )
}

fn whole(file: &str, message: String) -> Diagnostics {
    Diagnostics(vec![Diagnostic::new(file, None, message, None)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_preset_holds_its_camera() {
        assert_eq!(parse("incra1.toml", include_str!("../../presets/sensor/incra1.toml")).expect("a camera"), incra1());
        let plain = "[camera]\nwidth_px = 640\nheight_px = 480\nfocal_px = [514.4, 685.9]\ncentre_px = [329.8, 237.7]\n";
        let lens = format!("{plain}distortion = [-0.35, 0.158, 7e-4, -2e-4, 0.0]\n");
        let camera = parse("c.toml", &lens).expect("a camera");
        assert_eq!(parse("c.toml", &camera_table(&camera)).as_ref(), Ok(&camera));
        assert_eq!((camera.focal_px, camera.distortion.k1, camera.distortion.p2), ([514.4, 685.9], -0.35, -2e-4));
    }

    #[test]
    fn what_is_wrong_has_its_line() {
        let text = "[camera]\nwidth_px = 640\nheight_px = 480\nfocal_px = 1081.0\ncentre_px = [320.0, 240.0]\n";
        for (from, to, line, word) in [
            ("height_px = 480\n", "", Some(1), "height_px"),
            ("height_px = 480", "height_px = \"x\"", Some(3), "invalid type"),
            ("focal_px = 1081.0", "focal = 1081.0", Some(4), "unknown field"),
            ("[camera]", "[camera", Some(1), ""),
            ("[camera]", "[lens]", None, "holds no camera"),
            ("1081.0", "nan", None, "focal_px must"),
            ("= 640", "= 1", None, "width_px"),
        ] {
            let wrong = parse("c.toml", &text.replace(from, to)).expect_err(to).0.remove(0);
            assert!(wrong.message.contains(word), "{to}: {wrong:?}");
            assert_eq!(wrong.place.map(|place| place.line), line, "{to}");
        }
    }
}
