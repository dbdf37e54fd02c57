//! The paper's experiment from image to millimetre: a block before the rendered camera, stripes found, equation 14 solved, and the
//! block measured where T was not calibrated.
//!
//! - [`mod@file`]: the experiment as it stands in a file; - [`schema()`]: that format, for editors;
//! - `scene`: the block at a depth, what the camera sees and what is the case;
//! - [`stripe`]: a stripe's centre in an image; - [`figure`]: the paper's figure 9.
//!
//! What is measured is the stripe's centre across itself. Where along the stripe a point lies, the block's marks say (the paper
//! does not tell how): the true place, give or take `mark_sigma_px`.

pub mod figure;
pub mod file;
mod scene;
mod schema;
pub mod stripe;

use ductloop_nav::calibration::linear::{LinearCalibration, position_mm, rms_mm, with_last_one};
use ductloop_nav::calibration::pairs::Pair;
use nalgebra::{Matrix4x3, Point3, Vector3};
use serde_json::{Value, json};

use crate::engine::Engine;
use crate::scenario::Diagnostics;
use file::GaugeFile;
use scene::Scene;
pub use schema::schema;

/// A point of the block that was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Its pixel, as found.
    pub pixel_px: [f64; 2],
    /// Where it truly is, in the gauge's frame, in millimetres.
    pub actual_mm: Point3<f64>,
    /// Where T has it.
    pub estimated_mm: Point3<f64>,
    /// The stripe's centre as found less as it is, across the stripe's lines of pixels.
    pub centre_error_px: f64,
}

impl Measured {
    /// Estimated less actual position, in millimetres.
    pub fn miss_mm(&self) -> Vector3<f64> {
        self.estimated_mm - self.actual_mm
    }
}

/// What came of one laser.
#[derive(Clone, Debug)]
pub struct LaserResult {
    /// Its name.
    pub name: String,
    /// T in table 1's form.
    pub t: Matrix4x3<f64>,
    /// Condition of the equations as solved.
    pub condition: f64,
    /// 3D RMS over the points of the calibration, left out one at a time.
    pub leave_one_out_rms_mm: Option<f64>,
    /// Misses of the paper's own estimates, point by point.
    pub paper_misses_mm: Vec<f64>,
    /// The points of the calibration.
    pub calibration: Vec<Measured>,
    /// The points of the test.
    pub test: Vec<Measured>,
    /// Heights and depths asked for that the camera does not see: of the calibration, of the test.
    pub unseen: [usize; 2],
}

/// What came of the experiment.
#[derive(Clone, Debug)]
pub struct GaugeResult {
    /// The experiment's name.
    pub name: String,
    /// A result a laser.
    pub lasers: Vec<LaserResult>,
}

/// Why an experiment came to no result.
#[derive(Debug, thiserror::Error)]
pub enum GaugeError {
    /// The points that were found determine no T.
    #[error("laser `{laser}`: {error}")]
    Calibration {
        /// The laser.
        laser: String,
        /// Why.
        error: ductloop_nav::calibration::linear::LinearError,
    },
    /// The renderer failed.
    #[error(transparent)]
    Render(#[from] crate::closed_loop::RunError),
    /// No point of the test is in view.
    #[error("laser `{0}`: no point of the test is in view")]
    NoTest(String),
    /// The file is wrong in a way that shows only when the scene is built.
    #[error(transparent)]
    Scene(#[from] Diagnostics),
}

/// Carries an experiment out.
///
/// # Errors
/// A scene that cannot be rendered, and points that determine no T.
pub fn run(file: &GaugeFile, engine: &Engine, threads: usize) -> Result<GaugeResult, GaugeError> {
    let mut scene = Scene::new(file, engine, threads);
    let lasers = (0..file.gauge.laser.len()).map(|laser| of_laser(file, &mut scene, laser)).collect::<Result<_, _>>()?;
    Ok(GaugeResult { name: file.scenario.name.clone(), lasers })
}

fn of_laser(file: &GaugeFile, scene: &mut Scene<'_>, laser: usize) -> Result<LaserResult, GaugeError> {
    let asked = &file.gauge.laser[laser];
    let (found, unseen) = scene.measure(&asked.name, &asked.points_mm)?;
    let pairs: Vec<_> =
        found.iter().map(|point| Pair { pixel_px: point.pixel_px, position_mm: point.actual_mm.coords.into() }).collect();
    let solved = LinearCalibration::of(&pairs).map_err(|error| GaugeError::Calibration { laser: asked.name.clone(), error })?;
    let t = with_last_one(&solved.t).unwrap_or(solved.t);
    let test = &file.gauge.test;
    let grid: Vec<_> = test.depths_mm.iter().flat_map(|z| test.heights_mm.iter().map(move |x| [*x, *z])).collect();
    let (tested, unseen_test) = scene.measure(&asked.name, &grid)?;
    if tested.is_empty() {
        return Err(GaugeError::NoTest(asked.name.clone()));
    }
    let estimated = |points: Vec<scene::Found>| {
        let one = |point: scene::Found| {
            let estimated_mm = position_mm(&t, point.pixel_px)?;
            Some(Measured {
                pixel_px: point.pixel_px,
                actual_mm: point.actual_mm,
                estimated_mm,
                centre_error_px: point.centre_error_px,
            })
        };
        points.into_iter().filter_map(one).collect()
    };
    Ok(LaserResult {
        name: asked.name.clone(),
        t,
        condition: solved.conditioning.condition,
        leave_one_out_rms_mm: solved.leave_one_out_rms_mm(),
        paper_misses_mm: asked.paper_misses_mm.clone(),
        calibration: estimated(found),
        test: estimated(tested),
        unseen: [unseen, unseen_test],
    })
}

/// 3D RMS of points; `None` of none.
pub fn rms(points: &[Measured]) -> Option<f64> {
    rms_mm(&points.iter().map(Measured::miss_mm).collect::<Vec<_>>())
}

impl LaserResult {
    /// RMS error of the stripe's centres, in pixels, over calibration and test.
    pub fn centre_rms_px(&self) -> f64 {
        let all = || self.calibration.iter().chain(&self.test).map(|point| point.centre_error_px);
        (all().map(|error| error * error).sum::<f64>() / all().count().max(1) as f64).sqrt()
    }

    /// 3D RMS of the paper's own estimates.
    pub fn paper_rms_mm(&self) -> Option<f64> {
        let squares: f64 = self.paper_misses_mm.iter().map(|miss| miss * miss).sum();
        let count = self.paper_misses_mm.len();
        (count > 0).then(|| (squares / count as f64).sqrt())
    }

    fn to_json(&self) -> Value {
        let rows: Vec<[f64; 3]> = self.t.row_iter().map(|row| [row[0], row[1], row[2]]).collect();
        let point = |point: &Measured| {
            let ([u, v], actual, estimated) = (point.pixel_px, point.actual_mm, point.estimated_mm);
            json!({
                "u_px": u, "v_px": v, "x_mm": actual.x, "y_mm": actual.y, "z_mm": actual.z,
                "x_est_mm": estimated.x, "y_est_mm": estimated.y, "z_est_mm": estimated.z,
                "residual_mm": point.miss_mm().norm(), "centre_error_px": point.centre_error_px,
            })
        };
        let points = |points: &[Measured]| points.iter().map(point).collect::<Vec<_>>();
        json!({
            "name": self.name, "t": rows, "condition": self.condition,
            "rms_mm": rms(&self.calibration), "leave_one_out_rms_mm": self.leave_one_out_rms_mm, "test_rms_mm": rms(&self.test),
            "paper_rms_mm": self.paper_rms_mm(), "centre_rms_px": self.centre_rms_px(),
            "unseen": {"calibration": self.unseen[0], "test": self.unseen[1]},
            "points": points(&self.calibration), "test": points(&self.test),
        })
    }
}

impl GaugeResult {
    /// As JSON.
    pub fn to_json(&self) -> Value {
        json!({"name": self.name, "lasers": self.lasers.iter().map(LaserResult::to_json).collect::<Vec<_>>()})
    }

    /// As text.
    pub fn to_text(&self) -> String {
        let mut out = format!(
            "{}\n{:<8} {:>12} {:>8} {:>12} {:>8} {:>8} {:>8} {:>12}\n",
            self.name, "laser", "calibration", "3D RMS", "one left out", "test", "3D RMS", "paper", "centres"
        );
        let mm = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.3}"));
        for laser in &self.lasers {
            let seen = |points: &[Measured], unseen: usize| format!("{} of {}", points.len(), points.len() + unseen);
            out += &format!(
                "{:<8} {:>12} {:>8} {:>12} {:>8} {:>8} {:>8} {:>9.3} px\n",
                laser.name,
                seen(&laser.calibration, laser.unseen[0]),
                mm(rms(&laser.calibration)),
                mm(laser.leave_one_out_rms_mm),
                seen(&laser.test, laser.unseen[1]),
                mm(rms(&laser.test)),
                mm(laser.paper_rms_mm()),
                laser.centre_rms_px(),
            );
        }
        out + "points as far as they are in view; RMS in mm; paper: the printed estimates against the actual positions"
    }
}
