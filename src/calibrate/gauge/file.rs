//! A gauge experiment as it stands in a file: a scene such as scenarios have, then `[gauge]`.

use std::path::Path;

use serde::Deserialize;

use super::schema::{BEYOND, SIZE_MM, WINDOW_PX};
use crate::bounded_file;
use crate::calibrate::camera::MOST_BYTES;
use crate::calibrate::places;
use crate::scenario::{Diagnostic, Diagnostics, Scenario};

/// A file of `kind = "gauge"`.
#[derive(Clone, Debug)]
pub struct GaugeFile {
    /// Sensor, surfaces, the room around.
    pub scenario: Scenario,
    /// The experiment.
    pub gauge: Gauge,
}

/// `[gauge]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gauge {
    /// The block's surface, by its name.
    pub surface: String,
    /// Size of its face, across and upright, in millimetres.
    pub size_mm: [f64; 2],
    /// Where the gauge's origin is in the duct, in metres. Its x is up, its y right, its z along the duct.
    pub origin_m: [f64; 3],
    /// The camera in the gauge's frame, p_camera = Rot(turn) p_gauge + shift: axis times angle, in radians.
    pub turn_rad: [f64; 3],
    /// In millimetres.
    pub shift_mm: [f64; 3],
    /// Standard deviation of a point's place along the stripe, in pixels.
    pub mark_sigma_px: f64,
    /// Lines of the image on either side of a point that its centre is taken from.
    pub window_px: usize,
    /// The lasers, one after the other alight.
    pub laser: Vec<GaugeLaser>,
    /// Where T is tested.
    pub test: GaugeTest,
}

/// `[[gauge.laser]]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GaugeLaser {
    /// Its name in the sensor.
    pub name: String,
    /// Misses of the paper's own estimates of these points, in millimetres, if there are such.
    #[serde(default)]
    pub paper_misses_mm: Vec<f64>,
    /// Height x and depth z of the points of the calibration, in millimetres.
    pub points_mm: Vec<[f64; 2]>,
}

/// `[gauge.test]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GaugeTest {
    /// Heights x.
    pub heights_mm: Vec<f64>,
    /// At each of these depths z.
    pub depths_mm: Vec<f64>,
}

#[derive(Deserialize)]
struct File {
    gauge: Gauge,
}

const KIND: &str = "kind = \"gauge\"";
const SECTION: &str = "\n[gauge]";

impl GaugeFile {
    /// Reads a file.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn read(path: &Path) -> Result<Self, Diagnostics> {
        let file = path.display().to_string();
        let text =
            bounded_file::read_text(path, MOST_BYTES).map_err(|error| whole(&file, format!("cannot be read: {error}"), None))?;
        Self::parse(&file, &text)
    }

    /// Reads a text; errors name it `file`.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn parse(file: &str, text: &str) -> Result<Self, Diagnostics> {
        let text = text.replace("\r\n", "\n");
        let Some((scene, _)) = text.split_once(SECTION).filter(|(scene, _)| scene.contains(KIND)) else {
            let help = "it holds `kind = \"gauge\"`, a scene such as scenarios have, and `[gauge]` after it";
            return Err(whole(file, "is no gauge experiment".into(), Some(help.into())));
        };
        // The scene is read as a scenario's: its lines stay where they are.
        let mut wrong = Vec::new();
        let scenario = Scenario::from_toml_str(&scene.replacen(KIND, "kind = \"scenario\"", 1)).map_err(|mut errors| {
            errors.0.iter_mut().filter(|error| error.file == "scenario").for_each(|error| error.file = file.to_owned());
            wrong = errors.0;
        });
        let gauge = toml::from_str::<File>(&text).map_err(|error| {
            let place = error.span().map(|span| places::at(&text, span.start));
            wrong.push(Diagnostic::new(file, place, error.message(), None));
        });
        let (Ok(scenario), Ok(File { gauge })) = (scenario, gauge) else { return Err(Diagnostics(wrong)) };
        let read = Self { scenario, gauge };
        match read.problem() {
            Some(message) => Err(whole(file, message, None)),
            None => Ok(read),
        }
    }

    /// What cannot be, if anything.
    fn problem(&self) -> Option<String> {
        let Gauge { surface, size_mm, origin_m, turn_rad, shift_mm, mark_sigma_px, window_px, laser, test } = &self.gauge;
        let numbers = size_mm.iter().chain(origin_m).chain(turn_rad).chain(shift_mm).chain([mark_sigma_px]);
        let points = laser.iter().flat_map(|laser| laser.points_mm.iter().flatten());
        let paper = laser.iter().flat_map(|laser| &laser.paper_misses_mm);
        let all = numbers.chain(points).chain(paper).chain(&test.heights_mm).chain(&test.depths_mm);
        if !all.copied().all(|x| x.abs() < BEYOND) {
            return Some("[gauge] holds a number that is not finite, or beyond 100 m".into());
        }
        let [least, most] = SIZE_MM;
        if !size_mm.iter().all(|size| (least..=most).contains(size)) {
            return Some(format!("gauge.size_mm must be from {least} to {most}"));
        }
        let [least, most] = WINDOW_PX;
        if *mark_sigma_px < 0.0 || !(least..=most).contains(window_px) {
            return Some(format!("gauge.mark_sigma_px must not be negative, and gauge.window_px must be from {least} to {most}"));
        }
        let mut depths = laser.iter().flat_map(|laser| laser.points_mm.iter().map(|[_, z]| z)).chain(&test.depths_mm);
        if let Some(z) = depths.find(|z| **z < 20.0) {
            return Some(format!("a depth of {z} mm: the block must stand at least 20 mm before the gauge's origin"));
        }
        if !self.scenario.surfaces.iter().any(|known| known.name == *surface) {
            return Some(format!("gauge.surface names no surface: `{surface}`"));
        }
        let known = |name: &String| self.scenario.rig.lasers.iter().any(|laser| laser.name == *name);
        if let Some(unknown) = laser.iter().find(|laser| !known(&laser.name)) {
            return Some(format!("gauge.laser: the sensor has no laser `{}`", unknown.name));
        }
        laser.is_empty().then(|| "holds no [[gauge.laser]]".into())
    }
}

fn whole(file: &str, message: String, help: Option<String>) -> Diagnostics {
    Diagnostics(vec![Diagnostic::new(file, None, message, help)])
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = include_str!("../../../scenarios/gauge/incra1.toml");

    #[test]
    fn errors_have_their_lines() {
        GaugeFile::parse("g.toml", FILE).expect("the file in the library");
        let line_of = |text: &str| FILE.lines().position(|line| line.starts_with(text)).map(|index| index + 1);
        for (from, to, line, word) in [
            ("albedo = 0.5", "albedo = 5.0", line_of("albedo"), "albedo"),
            ("window_px = 20 ", "windows_px = 20 ", line_of("window_px"), "unknown field"),
            ("turn_rad = [0.073043", "turn_rad = [\"x\"", line_of("turn_rad"), "invalid type"),
            ("surface = \"block\"", "surface = \"blok\"", None, "names no surface"),
            ("name = \"left\"", "name = \"up\"", None, "no laser `up`"),
            ("kind = \"gauge\"", "kind = \"scenario\"", None, "no gauge experiment"),
            ("depths_mm = [275.0", "depths_mm = [5.0", None, "20 mm"),
            ("origin_m = [0.8", "origin_m = [nan", None, "not finite"),
        ] {
            assert!(FILE.contains(from), "{from}");
            let errors = GaugeFile::parse("g.toml", &FILE.replace(from, to)).expect_err(to).0;
            assert!(errors[0].message.contains(word), "{to}: {errors:?}");
            assert_eq!((errors[0].file.as_str(), errors[0].place.as_ref().map(|place| place.line)), ("g.toml", line), "{to}");
        }
    }
}
