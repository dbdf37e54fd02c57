//! A laser's plane from its stripe on boards of known pose: from tables of boards and of stripe centres.

use std::fmt::Write;
use std::path::Path;

use ductloop_nav::calibration::boards::{Board, BoardCentre, BoardsError, BoardsPlane};
use ductloop_nav::perception::lens::Lens;
use ductloop_nav::rig::Camera;
use nalgebra::{Unit, Vector3};
use serde_json::{Value, json};

use super::camera::camera_table;
use super::model::laser_table;
use super::table::Table;
use crate::scenario::{Diagnostic, Diagnostics};

/// Columns of a table of boards: the picture's file, and the board's plane n . x = d in its camera's frame, d in millimetres.
const FILE: &str = "file";
const PLANE: [&str; 4] = ["n_x", "n_y", "n_z", "d_mm"];
/// The board's corners in the picture, one after the other round it, if the table has them.
const CORNERS: [&str; 8] = ["q0_u", "q0_v", "q1_u", "q1_v", "q2_u", "q2_v", "q3_u", "q3_v"];
const CENTRES: [&str; 2] = ["u_px", "v_px"];
const SIGMA: &str = "sigma_px";
/// Deviation of a centre whose table states none: its size does not matter, as all are alike.
const UNSTATED_PX: f64 = 0.1;
/// How far the length of a normal may be from one, as tables round it.
const UNIT: f64 = 1e-3;

/// Boards by the picture that shows each.
#[derive(Clone, Debug)]
pub struct Boards {
    /// Names of the pictures, without their folders.
    pub files: Vec<String>,
    /// Their planes.
    pub planes: Vec<Board>,
    /// Corners of each in its picture, in pixels, one after the other round it: the stripe counts within.
    pub corners_px: Option<Vec<[[f64; 2]; 4]>>,
}

/// Stripe centres on boards, and those that were read but lie beside their board.
#[derive(Clone, Debug)]
pub struct Centres {
    /// On their boards.
    pub on_boards: Vec<BoardCentre>,
    /// How many lie outside the corners.
    pub outside: usize,
    /// Where the former come from, for errors: table and row; pictures have none.
    places: Vec<Option<(usize, usize)>>,
    tables: Vec<Table>,
}

impl Boards {
    /// Reads a table of boards.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn read(path: &Path) -> Result<Self, Diagnostics> {
        Self::of(&Table::read(path)?)
    }

    /// Reads a text; errors name it `file`.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn parse(file: &str, text: &str) -> Result<Self, Diagnostics> {
        Self::of(&Table::parse(file, text)?)
    }

    fn of(table: &Table) -> Result<Self, Diagnostics> {
        let files: Vec<_> = table.texts(FILE)?.into_iter().map(base_name).collect();
        let rows = table.numbers(PLANE)?;
        let mut wrong = Vec::new();
        let mut planes = Vec::new();
        for (row, [x, y, z, distance_mm]) in rows.into_iter().enumerate() {
            let normal = Vector3::new(x, y, z);
            if (normal.norm() - 1.0).abs() > UNIT {
                let message = format!("(n_x, n_y, n_z) has length {:.4}: it must be a unit vector", normal.norm());
                wrong.push(table.error(row, message, None));
            } else if distance_mm.abs() < 1.0 {
                wrong.push(table.error(row, "the board passes the camera within a millimetre".into(), None));
            }
            if let Some(before) = files[..row].iter().position(|file| *file == files[row]) {
                let message = format!("`{}` is in line {} already", files[row], table.line(before));
                wrong.push(table.error(row, message, None));
            }
            planes.push(Board { normal: Unit::new_unchecked(normal / normal.norm().max(f64::MIN_POSITIVE)), distance_mm });
        }
        if planes.is_empty() {
            wrong.push(table.error_of_all("holds no board".into(), None));
        }
        if !wrong.is_empty() {
            return Err(Diagnostics(wrong));
        }
        let corners_px = if CORNERS.iter().all(|name| table.has(name)) {
            let quads = table.numbers(CORNERS)?;
            Some(quads.into_iter().map(|[a, b, c, d, e, f, g, h]| [[a, b], [c, d], [e, f], [g, h]]).collect())
        } else {
            None
        };
        Ok(Self { files, planes, corners_px })
    }

    /// Whether a pixel is on a board: within its corners, or anywhere if none are known.
    pub fn shows(&self, board: usize, pixel_px: [f64; 2]) -> bool {
        self.corners_px.as_ref().is_none_or(|corners| within(&corners[board], pixel_px))
    }
}

impl Centres {
    /// Reads tables of stripe centres: `file,u_px,v_px` and, if it is known, `sigma_px`.
    ///
    /// # Errors
    /// Everything that is wrong with them, and pictures that no board is known of.
    pub fn read(paths: &[impl AsRef<Path>], boards: &Boards) -> Result<Self, Diagnostics> {
        let mut tables = Vec::new();
        let mut wrong = Vec::new();
        for path in paths {
            match Table::read(path.as_ref()) {
                Ok(table) => tables.push(table),
                Err(errors) => wrong.extend(errors.0),
            }
        }
        if wrong.is_empty() { Self::of(tables, boards) } else { Err(Diagnostics(wrong)) }
    }

    /// Of tables already read.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn of(tables: Vec<Table>, boards: &Boards) -> Result<Self, Diagnostics> {
        let mut centres = Self { on_boards: Vec::new(), outside: 0, places: Vec::new(), tables: Vec::new() };
        for (number, table) in tables.iter().enumerate() {
            let (files, pixels) = (table.texts(FILE)?, table.numbers(CENTRES)?);
            let sigmas = if table.has(SIGMA) {
                table.numbers([SIGMA])?.into_iter().map(|[sigma]| sigma).collect()
            } else {
                vec![UNSTATED_PX; pixels.len()]
            };
            for (row, (file, pixel_px)) in files.into_iter().zip(pixels).enumerate() {
                let wrong = |message: String, help| Err(Diagnostics(vec![table.error(row, message, help)]));
                let Some(board) = boards.files.iter().position(|known| *known == base_name(file)) else {
                    return wrong(
                        format!("no board is known of `{file}`"),
                        Some(format!("boards of: {}", boards.files.join(", "))),
                    );
                };
                if sigmas[row] <= 0.0 {
                    return wrong("sigma_px must be positive".into(), None);
                }
                if boards.shows(board, pixel_px) {
                    centres.on_boards.push(BoardCentre { board, pixel_px, sigma_px: sigmas[row] });
                    centres.places.push(Some((number, row)));
                } else {
                    centres.outside += 1;
                }
            }
        }
        centres.tables = tables;
        Ok(centres)
    }

    /// Takes in centres found in a picture.
    pub fn extend(&mut self, found: Vec<BoardCentre>, boards: &Boards) {
        let (on_board, outside): (Vec<_>, Vec<_>) =
            found.into_iter().partition(|centre| boards.shows(centre.board, centre.pixel_px));
        self.outside += outside.len();
        self.places.extend(on_board.iter().map(|_| None));
        self.on_boards.extend(on_board);
    }

    fn why_not(&self, error: &BoardsError) -> Diagnostics {
        let at = |centre: usize, message: String| match self.places[centre] {
            Some((table, row)) => self.tables[table].error(row, message, None),
            None => Diagnostic::new("stripe centres", None, message, None),
        };
        Diagnostics(vec![match error {
            BoardsError::NotFinite(centre) => at(*centre, "the pixel is too far off to be one, or its deviation".into()),
            BoardsError::Misses { centre, .. } => {
                at(*centre, "the ray of this centre does not meet its board in front of the camera".into())
            }
            BoardsError::TooFew(_)
            | BoardsError::OneBoard
            | BoardsError::OneLine
            | BoardsError::Noise { .. }
            | BoardsError::ThroughCamera(_) => {
                let tables = self.tables.iter().map(Table::file).collect::<Vec<_>>().join(", ");
                let file = if tables.is_empty() { "stripe centres".into() } else { tables };
                let outside =
                    (self.outside > 0).then(|| format!("{} centres lie beside their boards and were left out", self.outside));
                Diagnostic::new(file, None, error.to_string(), outside)
            }
        }])
    }
}

/// A laser's plane with the boards that it was found by.
#[derive(Clone, Debug)]
pub struct Found {
    /// The plane.
    pub plane: BoardsPlane,
    /// The laser's name.
    pub laser: String,
    camera: Camera,
    files: Vec<String>,
    centres: Centres,
}

impl Found {
    /// Fits the plane.
    ///
    /// # Errors
    /// Centres that leave it open, or that cannot be.
    pub fn fit(camera: &Camera, boards: Boards, centres: Centres, laser: &str) -> Result<Self, Diagnostics> {
        let plane =
            BoardsPlane::of(&Lens::new(camera), &boards.planes, &centres.on_boards).map_err(|error| centres.why_not(&error))?;
        Ok(Self { plane, laser: laser.to_owned(), camera: camera.clone(), files: boards.files, centres })
    }

    /// RMS distance from the plane, in millimetres and in pixels, and how many: of the centres that count, on one board or on all.
    pub fn rms(&self, board: Option<usize>) -> (f64, f64, usize) {
        let plane = &self.plane;
        let (mut mm, mut px, mut count) = (0.0, 0.0, 0_usize);
        for (index, centre) in self.centres.on_boards.iter().enumerate() {
            if plane.used[index] && board.is_none_or(|board| board == centre.board) {
                mm += plane.residuals_mm[index] * plane.residuals_mm[index];
                px += plane.residuals_px[index] * plane.residuals_px[index];
                count += 1;
            }
        }
        let over = count.max(1) as f64;
        ((mm / over).sqrt(), (px / over).sqrt(), count)
    }

    /// Standard deviations of the offset, in millimetres, and of the normal, in radians: from boards where there are enough.
    pub fn sigma(&self) -> (f64, f64) {
        let covariance = self.plane.covariance_by_board.unwrap_or(self.plane.covariance).matrix;
        let turns = covariance.fixed_view::<2, 2>(0, 0).into_owned();
        (covariance[(2, 2)].max(0.0).sqrt(), turns.symmetric_eigenvalues().max().max(0.0).sqrt())
    }

    /// The plane as a file for `--with` and for `perceive --rig`, with the camera that it was found by: in another's frame it means
    /// nothing.
    pub fn to_toml(&self) -> String {
        let table = laser_table(&self.laser, &self.plane.normal, self.plane.offset_mm);
        format!(
            "# A laser's plane fitted by `ductloop calibrate --boards`, in the camera's frame: lay it over a scenario by\n\
             # `--with`, or read pictures by `perceive --rig`, behind an --rig each for the files of other lasers.\n\
             # How the camera stands on a robot, boards do not tell: roll_deg, position_in_base_m.\n{}{table}",
            camera_table(&self.camera)
        )
    }

    /// As JSON.
    pub fn to_json(&self) -> Value {
        let plane = &self.plane;
        let board = |(board, file): (usize, &String)| {
            let (rms_mm, rms_px, used) = self.rms(Some(board));
            let all = self.centres.on_boards.iter().filter(|centre| centre.board == board).count();
            // What no centre tells is not nought.
            let of_some = |rms: f64| (used > 0).then_some(rms);
            json!({"file": file, "centres": all, "used": used, "rms_mm": of_some(rms_mm), "rms_px": of_some(rms_px)})
        };
        let (rms_mm, rms_px, used) = self.rms(None);
        let (offset_mm, normal_rad) = self.sigma();
        let rows = |matrix: &nalgebra::Matrix3<f64>| -> Vec<Vec<f64>> {
            matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
        };
        json!({
            "laser": self.laser, "normal": plane.normal.as_slice(), "offset_m": plane.offset_mm / 1e3,
            "offset_sigma_m": offset_mm / 1e3, "normal_sigma_rad": normal_rad,
            "sigma_from": if plane.covariance_by_board.is_some() { "boards" } else { "points" },
            "covariance": {
                "turned_toward": plane.covariance.towards.map(<[f64; 3]>::from),
                "by_point": rows(&plane.covariance.matrix),
                "by_board": plane.covariance_by_board.as_ref().map(|covariance| rows(&covariance.matrix)),
            },
            "rms_mm": rms_mm, "rms_px": rms_px, "scatter": plane.scatter,
            "centres": self.centres.on_boards.len(), "used": used, "outside": self.centres.outside,
            "boards": self.files.iter().enumerate().map(board).collect::<Vec<_>>(),
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
        let (plane, (offset_sigma, turn)) = (&self.plane, self.sigma());
        let [x, y, z]: [f64; 3] = plane.normal.into_inner().into();
        writeln!(out, "laser `{}`: normal [{x:.6}, {y:.6}, {z:.6}] +- {:.4} deg", self.laser, turn.to_degrees())?;
        let from = if plane.covariance_by_board.is_some() { "boards" } else { "single points: too few boards to tell more" };
        writeln!(out, "  offset {:.4} +- {offset_sigma:.4} mm (from {from})", plane.offset_mm)?;
        writeln!(out, "\nboard            centres    used   RMS / mm   RMS / px")?;
        for (board, file) in self.files.iter().enumerate() {
            let all = self.centres.on_boards.iter().filter(|centre| centre.board == board).count();
            let (mm, px, used) = self.rms(Some(board));
            if used == 0 {
                writeln!(out, "{file:<16} {all:>7} {used:>7} {:>10} {:>10}", "-", "-")?;
            } else {
                writeln!(out, "{file:<16} {all:>7} {used:>7} {mm:>10.3} {px:>10.3}")?;
            }
        }
        let (mm, px, used) = self.rms(None);
        let all = self.centres.on_boards.len();
        writeln!(out, "{:<16} {all:>7} {used:>7} {mm:>10.3} {px:>10.3}", "all")?;
        if self.centres.outside > 0 {
            writeln!(out, "{} more centres lie beside their boards", self.centres.outside)?;
        }
        Ok(())
    }
}

pub(super) fn base_name(file: &str) -> String {
    file.rsplit(['/', '\\']).next().unwrap_or(file).to_owned()
}

/// Whether a point is within a quadrilateral whose corners go round it, either way; convex, as a board in a picture is.
fn within(corners: &[[f64; 2]; 4], [u, v]: [f64; 2]) -> bool {
    let turn = |i: usize| {
        let ([au, av], [bu, bv]) = (corners[i], corners[(i + 1) % 4]);
        (bu - au) * (v - av) - (bv - av) * (u - au)
    };
    (0..4).all(|i| turn(i) >= 0.0) || (0..4).all(|i| turn(i) <= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOARDS: &str = "file,n_x,n_y,n_z,d_mm,q0_u,q0_v,q1_u,q1_v,q2_u,q2_v,q3_u,q3_v\n\
        a.jpg,0,0,1,500,100,100,300,100,300,300,100,300\nb.jpg,0,0.6,0.8,500,100,100,300,100,300,300,100,300\n";

    #[test]
    fn what_lies_beside_its_board_is_left_out() {
        let boards = Boards::parse("boards.csv", BOARDS).expect("boards");
        let text = "file,u_px,v_px\nx/a.jpg,200,200\na.jpg,99,200\nb.jpg,150,299\n";
        let centres = Centres::of(vec![Table::parse("c.csv", text).expect("a table")], &boards).expect("centres");
        assert_eq!((centres.on_boards.len(), centres.outside), (2, 1));
        assert_eq!(centres.on_boards[1].board, 1);
    }

    #[test]
    fn what_is_wrong_has_its_line() {
        let line = |errors: Diagnostics| errors.0[0].place.as_ref().map(|place| place.line);
        let wrong = |from: &str, to: &str| line(Boards::parse("boards.csv", &BOARDS.replace(from, to)).expect_err(to));
        assert_eq!(wrong("0,0.6,0.8", "0,0.6,0.9"), Some(3));
        assert_eq!(wrong("b.jpg", "a.jpg"), Some(3));
        assert_eq!(wrong("0,0,1,500", "0,0,1,0.2"), Some(2));
        let boards = Boards::parse("boards.csv", BOARDS).expect("boards");
        let centres = |text: &str| Centres::of(vec![Table::parse("c.csv", text).expect("a table")], &boards).map(|_| ());
        assert_eq!(line(centres("file,u_px,v_px\nc.jpg,1,2\n").expect_err("no such board")), Some(2));
        assert_eq!(line(centres("file,u_px,v_px,sigma_px\na.jpg,1,2,0\n").expect_err("no deviation")), Some(2));
    }
}
