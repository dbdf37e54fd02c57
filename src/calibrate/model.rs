//! The rig fitted to the points of several lasers: as text, as JSON, and as a file to lay over a scenario.

use std::fmt::Write;

use ductloop_nav::calibration::linear::rms_mm;
use ductloop_nav::calibration::model::{Free, ModelError, Rig, Scatter, position_mm};
use ductloop_nav::calibration::pairs::Pair;
use ductloop_nav::rig::Camera;
use nalgebra::{Point3, Vector3};
use serde_json::{Value, json};

use super::camera::camera_table;
use super::points::Points;
use crate::scenario::{Diagnostic, Diagnostics};

/// Up to so many points, the rig is fitted anew without each of them.
const LEFT_OUT: usize = 60;

/// A fitted rig, with what it makes of each laser's points.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The rig.
    pub rig: Rig,
    /// Names of the lasers.
    pub lasers: Vec<String>,
    /// 3D RMS over each laser's points, left out one at a time; `None` of more points than are tried.
    pub leave_one_out_rms_mm: Vec<Option<f64>>,
    free: Free,
    stated: Scatter,
}

impl Fitted {
    /// Fits a rig to tables of points, a laser each.
    ///
    /// # Errors
    /// Points that determine nothing, with their lines, and those that no camera fits.
    pub fn fit(tables: &[(String, Points)], camera: &Camera, free: Free, stated: Scatter) -> Result<Self, Diagnostics> {
        let pairs: Vec<Vec<Pair>> = tables.iter().map(|(_, points)| points.pairs.clone()).collect();
        let rig = Rig::fit(&pairs, camera, free, stated).map_err(|error| why_not(tables, &error))?;
        let count: usize = pairs.iter().map(Vec::len).sum();
        let left_out = |laser: usize| {
            let misses: Option<Vec<_>> =
                (0..pairs[laser].len()).map(|point| left_out(&pairs, laser, point, camera, free, stated)).collect();
            (count <= LEFT_OUT).then_some(()).and(misses).and_then(|misses| rms_mm(&misses))
        };
        let leave_one_out_rms_mm =
            if count <= LEFT_OUT { (0..pairs.len()).map(left_out).collect() } else { vec![None; pairs.len()] };
        Ok(Self { rig, lasers: tables.iter().map(|(name, _)| name.clone()).collect(), leave_one_out_rms_mm, free, stated })
    }

    /// 3D RMS over a laser's points.
    pub fn rms_mm(&self, laser: usize) -> Option<f64> {
        rms_mm(&self.rig.misses_mm[laser])
    }

    /// The rig as a file for `--with`: camera and lasers under `[sensor]`.
    pub fn to_toml(&self) -> String {
        let (turn, shift) = (self.rig.rotation.scaled_axis(), self.rig.translation_mm);
        let mut out = format!(
            "# A rig fitted by `ductloop calibrate --model`: lay it over a scenario by `--with`, or read pictures by `perceive --rig`.\n\
             # How the camera stands on a robot, points of a gauge do not tell: roll_deg, position_in_base_m.\n\
             # Gauge frame: p_camera_mm = Rot({turn}) p_gauge_mm + {shift}, the turn as axis times angle in rad.\n\
             {}",
            camera_table(&self.rig.camera),
            turn = list(&turn),
            shift = list(&shift),
        );
        for (laser, name) in self.lasers.iter().enumerate() {
            let (normal, offset_mm) = self.rig.plane(laser);
            out += &laser_table(name, &normal, offset_mm);
        }
        out
    }

    /// As JSON; what was not measured is null.
    pub fn to_json(&self, tables: &[(String, Points)]) -> Value {
        let (rig, camera) = (&self.rig, &self.rig.camera);
        let d = camera.distortion;
        let laser = |(laser, (name, points)): (usize, &(String, Points))| {
            let (normal, offset_mm) = rig.plane(laser);
            let (offset_sigma_mm, normal_sigma_rad) = rig.sigma.planes[laser];
            let point = |(index, miss): (usize, &Vector3<f64>)| {
                let pair = points.pairs[index];
                json!({"line": points.line(index), "u_px": pair.pixel_px[0], "v_px": pair.pixel_px[1], "residual_mm": miss.norm()})
            };
            json!({
                "name": name, "normal": normal.as_slice(), "offset_m": offset_mm / 1e3,
                "offset_sigma_m": offset_sigma_mm / 1e3, "normal_sigma_rad": normal_sigma_rad,
                "rms_mm": self.rms_mm(laser), "leave_one_out_rms_mm": self.leave_one_out_rms_mm[laser],
                "points": rig.misses_mm[laser].iter().enumerate().map(point).collect::<Vec<_>>(),
            })
        };
        let used = 11 + 3 * self.lasers.len();
        let covariance: Vec<Vec<f64>> = (0..used).map(|i| (0..used).map(|j| rig.covariance[(i, j)]).collect()).collect();
        json!({
            "camera": {
                "width_px": camera.width_px, "height_px": camera.height_px, "focal_px": camera.focal_px[0],
                "centre_px": camera.centre_px, "distortion": [d.k1, d.k2, d.p1, d.p2, d.k3],
            },
            "camera_from_gauge": {
                "rotation_vector_rad": rig.rotation.scaled_axis().as_slice(), "translation_mm": rig.translation_mm.as_slice(),
            },
            "lasers": tables.iter().enumerate().map(laser).collect::<Vec<_>>(),
            "scatter": rig.scatter,
            "sigma": {
                "focal_px": rig.sigma.focal_px, "centre_px": rig.sigma.centre_px, "k1": rig.sigma.k1, "k2": rig.sigma.k2,
            },
            "sigma_if_free": {
                "focal_px": rig.if_free.focal_px, "centre_px": rig.if_free.centre_px, "k1": rig.if_free.k1, "k2": rig.if_free.k2,
            },
            "covariance": covariance,
        })
    }

    /// As text.
    pub fn to_text(&self) -> String {
        let mut out = String::new();
        // Writing to a string cannot fail.
        let _ = self.write(&mut out);
        out.truncate(out.trim_end().len());
        out
    }

    fn write(&self, out: &mut String) -> std::fmt::Result {
        let (rig, camera) = (&self.rig, &self.rig.camera);
        let told = |free: bool, sigma: Option<f64>, if_free: Option<f64>, unit: &str| match (free, sigma, if_free) {
            (true, Some(sigma), _) => format!("+- {sigma:.3}{unit}"),
            (_, _, Some(sigma)) => format!("held; these points alone would tell it to +- {sigma:.2}{unit}"),
            _ => "held; these points do not tell it".into(),
        };
        let (sigma, if_free) = (&rig.sigma, &rig.if_free);
        let first = |pair: Option<[f64; 2]>| pair.map(|[u, v]| u.max(v));
        writeln!(
            out,
            "focal length {:.2} px, {}",
            camera.focal_px[0],
            told(self.free.focal, sigma.focal_px, if_free.focal_px, " px")
        )?;
        let centre = told(self.free.centre, first(sigma.centre_px), first(if_free.centre_px), " px");
        writeln!(out, "principal point ({:.2}, {:.2}) px, {centre}", camera.centre_px[0], camera.centre_px[1])?;
        let d = camera.distortion;
        writeln!(out, "distortion k1 {:.4}, {}", d.k1, told(self.free.k1, sigma.k1, if_free.k1, ""))?;
        writeln!(out, "           k2 {:.4}, {}", d.k2, told(self.free.k2, sigma.k2, if_free.k2, ""))?;
        writeln!(
            out,
            "gauge frame  p_camera = Rot({}) p_gauge + {} mm",
            list(&rig.rotation.scaled_axis()),
            list(&rig.translation_mm)
        )?;
        for (laser, name) in self.lasers.iter().enumerate() {
            let (normal, offset_mm) = rig.plane(laser);
            let (offset_sigma, turn) = rig.sigma.planes[laser];
            writeln!(
                out,
                "\nlaser `{name}`: normal {} +- {:.3} deg, offset {offset_mm:.3} +- {offset_sigma:.3} mm",
                list(&normal),
                turn.to_degrees()
            )?;
            let or_none = |value: Option<f64>| value.map_or("not tried".into(), |value| format!("{value:.3} mm"));
            let (own, left_out) = (or_none(self.rms_mm(laser)), or_none(self.leave_one_out_rms_mm[laser]));
            writeln!(out, "  3D RMS {own}, leaving one point out at a time {left_out}")?;
        }
        writeln!(
            out,
            "\nscatter {:.2} times what was stated ({} px, {} mm); deviations are scaled by it",
            rig.scatter, self.stated.pixel_px, self.stated.position_mm
        )
    }
}

/// A laser's plane as a table of a rig's file.
pub(super) fn laser_table(name: &str, normal: &Vector3<f64>, offset_mm: f64) -> String {
    let [x, y, z]: [f64; 3] = (*normal).into();
    let bare = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
    let key = if bare { name.to_owned() } else { toml::Value::from(name).to_string() };
    format!("\n[sensor.laser.{key}]\nnormal = [{x:?}, {y:?}, {z:?}]\noffset_m = {:?}\n", offset_mm / 1e3)
}

fn list(v: &Vector3<f64>) -> String {
    format!("[{:.6}, {:.6}, {:.6}]", v.x, v.y, v.z)
}

/// A point's miss by the rig of all others.
fn left_out(
    pairs: &[Vec<Pair>],
    laser: usize,
    point: usize,
    camera: &Camera,
    free: Free,
    stated: Scatter,
) -> Option<Vector3<f64>> {
    let mut others = pairs.to_vec();
    let pair = others[laser].remove(point);
    let rig = Rig::fit(&others, camera, free, stated).ok()?;
    Some(position_mm(&rig, laser, pair.pixel_px)? - Point3::from(pair.position_mm))
}

fn why_not(tables: &[(String, Points)], error: &ModelError) -> Diagnostics {
    match error {
        ModelError::Pairs { laser, error } => Diagnostics(vec![tables[*laser].1.why_no_set(error)]),
        ModelError::Start { laser, error } => tables[*laser].1.why_not(error),
        ModelError::Lasers(_) | ModelError::NoFit | ModelError::Undetermined => {
            let files: Vec<_> = tables.iter().map(|(_, points)| points.file()).collect();
            let help = match error {
                ModelError::NoFit => Some("the gauge's frame must be right-handed, and all tables in the same frame"),
                ModelError::Undetermined => Some("leave words out of --free"),
                _ => None,
            };
            let (file, message) = (files.join(", "), error.to_string());
            Diagnostics(vec![Diagnostic::new(file, None, message, help.map(str::to_owned))])
        }
    }
}
