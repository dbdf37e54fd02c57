//! What a table of points and a matrix T say of each other, for people and for programs.

use std::fmt::Write;

use ductloop_nav::calibration::linear::{LinearCalibration, position_mm, rms_mm, with_last_one};
use nalgebra::{Matrix4x3, Point3, Vector3};
use serde_json::{Value, json};

use super::points::Points;
use crate::scenario::Diagnostics;

/// T with what it makes of each point.
#[derive(Clone, Debug)]
pub struct Applied {
    /// T with t43 = 1.
    pub t: Matrix4x3<f64>,
    /// Positions that T gives the pixels, in millimetres; `None` on the horizon.
    pub estimates_mm: Vec<Option<Point3<f64>>>,
    /// Misses of points left out, if T is their own calibration.
    pub left_out_mm: Option<Vec<Option<Vector3<f64>>>>,
    /// 3D RMS over all points; `None` if one is on the horizon.
    pub rms_mm: Option<f64>,
    /// 3D RMS over points left out one at a time.
    pub leave_one_out_rms_mm: Option<f64>,
    /// Condition of the equations as solved, and as the paper prints them.
    pub condition: Option<[f64; 2]>,
}

impl Applied {
    /// Solves equation 14 for the points.
    ///
    /// # Errors
    /// Points that determine no T, with their lines.
    pub fn solve(points: &Points) -> Result<Self, Diagnostics> {
        let solved = LinearCalibration::of(&points.pairs).map_err(|error| points.why_not(&error))?;
        // s is zero at pixel (0, 0): then the printed form does not exist, and T stays as it was solved.
        let t = with_last_one(&solved.t).unwrap_or(solved.t);
        Ok(Self {
            leave_one_out_rms_mm: solved.leave_one_out_rms_mm(),
            condition: Some([solved.conditioning.condition, solved.condition_unscaled]),
            left_out_mm: Some(solved.left_out_mm),
            ..Self::apply(t, points)
        })
    }

    /// Triangulates the points' pixels by a given T (equation 1).
    pub fn apply(t: Matrix4x3<f64>, points: &Points) -> Self {
        let estimates_mm: Vec<_> = points.pairs.iter().map(|pair| position_mm(&t, pair.pixel_px)).collect();
        let mut applied = Self { t, estimates_mm, left_out_mm: None, rms_mm: None, leave_one_out_rms_mm: None, condition: None };
        let misses: Option<Vec<_>> = applied.misses_mm(points).collect();
        applied.rms_mm = misses.and_then(|misses| rms_mm(&misses));
        applied
    }

    /// Estimated less actual position of each point.
    pub fn misses_mm<'a>(&'a self, points: &'a Points) -> impl Iterator<Item = Option<Vector3<f64>>> + 'a {
        let actual = points.pairs.iter().map(|pair| Point3::from(pair.position_mm));
        self.estimates_mm.iter().zip(actual).map(|(estimate, actual)| estimate.map(|estimate| estimate - actual))
    }

    fn left_out(&self, point: usize) -> Option<Vector3<f64>> {
        self.left_out_mm.as_ref().and_then(|misses| misses[point])
    }

    /// `{"t", "rms_mm", "leave_one_out_rms_mm", "condition", …, "points"}`; what was not measured is null.
    pub fn to_json(&self, points: &Points) -> Value {
        let rows: Vec<[f64; 3]> = self.t.row_iter().map(|row| [row[0], row[1], row[2]]).collect();
        let point = |(index, miss): (usize, Option<Vector3<f64>>)| {
            let ([u, v], [x, y, z]) = (points.pairs[index].pixel_px, points.pairs[index].position_mm);
            let at = |axis: usize| self.estimates_mm[index].map(|estimate| estimate[axis]);
            json!({
                "line": points.line(index), "u_px": u, "v_px": v, "x_mm": x, "y_mm": y, "z_mm": z,
                "x_est_mm": at(0), "y_est_mm": at(1), "z_est_mm": at(2),
                "residual_mm": miss.map(|miss| miss.norm()),
                "left_out_residual_mm": self.left_out(index).map(|miss| miss.norm()),
            })
        };
        json!({
            "t": rows,
            "rms_mm": self.rms_mm,
            "leave_one_out_rms_mm": self.leave_one_out_rms_mm,
            "condition": self.condition.map(|[solved, _]| solved),
            "condition_unscaled": self.condition.map(|[_, printed]| printed),
            "points": self.misses_mm(points).enumerate().map(point).collect::<Vec<_>>(),
        })
    }

    /// The same as text: T, then a line a point, then the figures.
    pub fn to_text(&self, points: &Points) -> String {
        let mut out = String::new();
        // Writing to a string cannot fail.
        let _ = self.write(points, &mut out);
        out.truncate(out.trim_end().len());
        out
    }

    fn write(&self, points: &Points, out: &mut String) -> std::fmt::Result {
        for row in 0..4 {
            for column in 0..3 {
                write!(out, "  t{}{} {:>14.6}", row + 1, column + 1, self.t[(row, column)])?;
            }
            writeln!(out)?;
        }
        let left_out = if self.left_out_mm.is_some() { "  left out" } else { "" };
        writeln!(
            out,
            "\nline      u       v         x        y        z  |     dx      dy      dz    miss{left_out}   (px, mm)"
        )?;
        for (index, miss) in self.misses_mm(points).enumerate() {
            let ([u, v], [x, y, z]) = (points.pairs[index].pixel_px, points.pairs[index].position_mm);
            write!(out, "{:>4} {u:>7.2} {v:>7.2}  {x:>8.2} {y:>8.2} {z:>8.2}  |", points.line(index))?;
            match miss {
                Some(miss) => write!(out, " {:>7.2} {:>7.2} {:>7.2} {:>7.2}", miss.x, miss.y, miss.z, miss.norm())?,
                None => write!(out, " on the horizon: no position     ")?,
            }
            if self.left_out_mm.is_some() {
                match self.left_out(index) {
                    Some(miss) => write!(out, "  {:>8.2}", miss.norm())?,
                    None => write!(out, "  {:>8}", "-")?,
                }
            }
            writeln!(out)?;
        }
        let or_none = |value: Option<f64>| value.map_or("none".into(), |value| format!("{value:.3} mm"));
        write!(out, "\n3D RMS {}", or_none(self.rms_mm))?;
        if let Some([solved, printed]) = self.condition {
            write!(out, ", leaving one point out at a time {}", or_none(self.leave_one_out_rms_mm))?;
            write!(out, "\nequation 14 has rank 11 of 11 and condition {solved:.1}; unscaled it would be {printed:.1e}")?;
        }
        writeln!(out)
    }
}
