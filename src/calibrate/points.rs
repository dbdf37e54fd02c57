//! Pixel/position pairs of one laser, as tables 2 and 3 of the paper have them.

use std::path::Path;

use ductloop_nav::calibration::linear::LinearError;
use ductloop_nav::calibration::pairs::{Pair, PairsError};

use super::table::Table;
use crate::scenario::{Diagnostic, Diagnostics};

/// Columns of a table of points: u and v in pixels, x, y and z in millimetres in the gauge's frame.
pub const COLUMNS: [&str; 5] = ["u_px", "v_px", "x_mm", "y_mm", "z_mm"];

/// The pairs of a file.
#[derive(Clone, Debug)]
pub struct Points {
    /// Pair by pair, in the order of the file.
    pub pairs: Vec<Pair>,
    table: Table,
}

impl Points {
    /// Reads a file.
    ///
    /// # Errors
    /// Everything that is wrong with its form.
    pub fn read(path: &Path) -> Result<Self, Diagnostics> {
        Self::of(Table::read(path)?)
    }

    /// Reads a text; errors name it `file`.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn parse(file: &str, text: &str) -> Result<Self, Diagnostics> {
        Self::of(Table::parse(file, text)?)
    }

    fn of(table: Table) -> Result<Self, Diagnostics> {
        let rows = table.numbers(COLUMNS)?;
        let pairs = rows.iter().map(|&[u, v, x, y, z]| Pair { pixel_px: [u, v], position_mm: [x, y, z] }).collect();
        Ok(Self { pairs, table })
    }

    /// The line in which a point stands, from 1.
    pub fn line(&self, point: usize) -> usize {
        self.table.line(point)
    }

    /// The file, as errors name it.
    pub fn file(&self) -> &str {
        self.table.file()
    }

    /// Why these points determine nothing, with the lines that they stand in.
    pub fn why_not(&self, error: &LinearError) -> Diagnostics {
        Diagnostics(vec![match error {
            LinearError::Pairs(pairs) => self.why_no_set(pairs),
            LinearError::Rank { .. } => self.table.error_of_all(error.to_string(), Some(SPREAD.into())),
            LinearError::Contradictory { point } => {
                let message = "no T fits: the horizon of the laser's plane would lie between this point and the others";
                self.table.error(*point, message.into(), Some("pixel and position of some point do not belong together".into()))
            }
        }])
    }

    /// Why these points are no set to calibrate with.
    pub fn why_no_set(&self, error: &PairsError) -> Diagnostic {
        let line = |point: &usize| self.table.line(*point);
        match error {
            PairsError::TooFew(count) => {
                let points = if *count == 1 { "point is" } else { "points are" };
                self.table.error_of_all(format!("{count} {points} too few: four at least are needed"), Some(SPREAD.into()))
            }
            PairsError::NotFinite(point) => self.table.error(*point, "a coordinate is not finite, or beyond 1e9".into(), None),
            PairsError::Repeated(first, second) => {
                let message = format!("the pixel is that of line {} again", line(first));
                self.table.error(*second, message, Some("a pixel sees one position: keep one of the two".into()))
            }
            PairsError::Collinear { space, but } => {
                let place = if *space { "positions" } else { "pixels" };
                let all = but
                    .as_ref()
                    .map_or(String::from("all points"), |point| format!("all points but that of line {}", line(point)));
                let message = format!("the {place} of {all} lie on a line: they determine no T");
                self.table.error_of_all(message, Some(SPREAD.into()))
            }
        }
    }
}

const SPREAD: &str = "four points are needed of which no three lie on a line, in the image and on the gauge; more are better";
