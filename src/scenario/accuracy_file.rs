//! A file of kind `accuracy`: a scenario, a grid over its fields, and poses to draw in it.
//!
//! ```toml
//! format = 1
//! kind = "accuracy"
//! name = "rigs"
//! pipelines = ["robust", "paper"]         # default: both
//!
//! [poses]
//! count = 500                             # in each cell of the grid
//! wall_m = [0.15, 0.5]                    # distance of either wall from the camera: draws lateral offset and width
//! heading_deg = [-6.0, 6.0]
//!
//! [grid]                                  # any field of a scenario, with the values that it takes
//! sensor.preset = ["wide", "incra1"]
//!
//! [pass.robust]                           # maxima unless the name says min
//! wall_distance_rms_mm = 0.3
//!
//! [duct]                                  # from here on a scenario as ever
//! height_m = 0.3
//! run = [{ straight_m = 20.0 }]
//! ```
//!
//! What is not drawn is the scenario's own `[start]`; so `start.lateral_m` and `start.heading_deg` in the grid make a grid of poses.

use std::path::Path;

use super::diagnostic::{Diagnostics, Finding};
use super::overlay::{self, Overlays};
use super::resolve;
use super::source::Span;
use super::tree::{Node, Table, Value};
use super::typed::Typed;
use super::{Pipeline, Scenario, fields};

mod criteria;
mod drawn;
mod reader;
mod schema;

pub use criteria::{BOUNDS, Bound, PassBound};
use reader::Reader;
pub use schema::schema;

/// Most cells of a grid.
pub const MOST_CELLS: usize = 4096;
/// Most poses of a cell.
pub const MOST_POSES: i64 = 1_000_000;

/// An accuracy study as resolved.
#[derive(Clone, Debug, PartialEq)]
pub struct AccuracyFile {
    /// Its name, and its folder's.
    pub name: String,
    /// What it is for; may be empty.
    pub about: String,
    /// Feeds every random stream.
    pub seed: u64,
    /// What reads the frames, in the order of the file.
    pub pipelines: Vec<Pipeline>,
    /// What is drawn for each pose.
    pub poses: Poses,
    /// The cells of the grid; one without values where there is no grid.
    pub cells: Vec<Cell>,
    /// What the figures must be.
    pub pass: Vec<PassBound>,
}

/// What is drawn, evenly between two ends, for each pose; `None`: the scenario's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Poses {
    /// How many there are in each cell.
    pub count: u64,
    /// Distance of the left and the right wall from the camera, each drawn by itself, in metres: gives lateral offset and width.
    pub wall_m: Option<[f64; 2]>,
    /// Width of the duct, in metres.
    pub width_m: Option<[f64; 2]>,
    /// Lateral offset of the base, in metres.
    pub lateral_m: Option<[f64; 2]>,
    /// Heading, in radians.
    pub heading_rad: Option<[f64; 2]>,
    /// Distance along the centreline, in metres.
    pub distance_m: Option<[f64; 2]>,
}

impl Poses {
    /// What is drawn: the key of `[poses]`, and the scenario's field that it gives values; `wall_m` gives two.
    fn draws(&self) -> Vec<(&'static str, &'static str)> {
        let Self { wall_m, width_m, lateral_m, heading_rad, distance_m, .. } = self;
        let all = [
            (wall_m, "wall_m", "start.lateral_m"),
            (wall_m, "wall_m", "duct.width_m"),
            (width_m, "width_m", "duct.width_m"),
            (lateral_m, "lateral_m", "start.lateral_m"),
            (heading_rad, "heading_deg", "start.heading_deg"),
            (distance_m, "distance_m", "start.distance_m"),
        ];
        all.into_iter().filter(|(range, ..)| range.is_some()).map(|(_, key, path)| (key, path)).collect()
    }
}

/// A cell of the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// Path and value of each of the grid's fields, as the file has them.
    pub values: Vec<(String, String)>,
    /// The scenario.
    pub scenario: Scenario,
}

impl Cell {
    /// The values in one line; empty where there is no grid.
    pub fn label(&self) -> String {
        self.values.iter().map(|(path, value)| format!("{path} = {value}")).collect::<Vec<_>>().join(", ")
    }
}

/// A field of the grid with its values.
struct Factor {
    path: String,
    span: Span,
    levels: Vec<Node>,
}

impl AccuracyFile {
    /// Reads a file, lays the overlays over it, and resolves the scenario of every cell.
    ///
    /// # Errors
    /// Every error found.
    pub fn read(path: &Path, overlays: &Overlays) -> Result<Self, Diagnostics> {
        resolve(Typed::read(path, overlays))
    }

    /// The same from a text; errors name it `accuracy`.
    ///
    /// # Errors
    /// Every error found.
    pub fn from_toml_str(text: &str) -> Result<Self, Diagnostics> {
        resolve(Typed::from_text("accuracy", text))
    }

    /// The study with everything written out, for its folder: the file's own tables, and the scenario of each cell.
    pub fn to_toml(&self) -> String {
        let list = |items: &[String]| format!("[{}]", items.join(", "));
        let words: Vec<_> = self.pipelines.iter().map(|p| format!("\"{}\"", p.word())).collect();
        let mut text = format!(
            "# An accuracy study as it was carried out: what was drawn, then the resolved scenario of each cell of the grid.\n\
             format = 1\nkind = \"accuracy\"\nname = \"{}\"\nseed = {}\npipelines = {}\n\n[poses]\ncount = {}\n",
            self.name,
            self.seed,
            list(&words),
            self.poses.count
        );
        let degrees = self.poses.heading_rad.map(|range| range.map(f64::to_degrees));
        let Poses { wall_m, width_m, lateral_m, distance_m, .. } = self.poses;
        for (key, range) in [
            ("wall_m", wall_m),
            ("width_m", width_m),
            ("lateral_m", lateral_m),
            ("heading_deg", degrees),
            ("distance_m", distance_m),
        ] {
            if let Some([from, to]) = range {
                text += &format!("{key} = [{from:?}, {to:?}]\n");
            }
        }
        for (index, cell) in self.cells.iter().enumerate() {
            text += &format!("\n# Cell {index}: {}\n", cell.label());
            text.extend(cell.scenario.to_toml().lines().map(|line| format!("#   {line}\n")));
        }
        text
    }
}

fn resolve(mut typed: Typed) -> Result<AccuracyFile, Diagnostics> {
    let fail = |typed: &Typed, findings: Vec<Finding>| {
        let mut all = typed.unreadable.clone();
        all.extend(Diagnostics::from_findings(findings, &typed.sources).0);
        Err(Diagnostics(all))
    };
    if !typed.unreadable.is_empty() || !typed.findings.is_empty() {
        return fail(&typed, typed.findings.clone());
    }
    let mut root = std::mem::take(&mut typed.root);
    let mut reader = Reader::default();
    if !reader.kind(&mut root) {
        return fail(&typed, reader.findings);
    }
    let pipelines = reader.pipelines(root.take("pipelines"));
    let poses = reader.poses(root.take("poses"));
    let pass = reader.pass(root.take("pass"));
    let factors = reader.grid(root.take("grid"));
    reader.unknown(&root);
    reader.overruled(&root, &factors, &poses);
    if poses.wall_m.is_some()
        && root.at("duct.width_m").is_none()
        && matches!(root.get("duct"), Some(node) if node.as_table().is_some())
    {
        // Each pose has a width of its own.
        root.put("duct.width_m", Value::Number(1.0));
    }
    let count: usize = factors.iter().map(|factor| factor.levels.len()).product();
    if count > MOST_CELLS {
        let message = format!("the grid has {count} cells; {MOST_CELLS} are the most");
        let span = factors.first().map_or_else(Span::default, |factor| factor.span);
        reader.findings.push(Finding::new(span, message).help("give a field fewer values"));
    }
    if !reader.findings.is_empty() {
        return fail(&typed, reader.findings);
    }
    let mut cells = Vec::new();
    let mut wrong = Vec::new();
    for index in 0..count {
        match cell(&mut typed, &root, &factors, index) {
            Ok(cell) => cells.push(cell),
            // What is wrong with the scenario is wrong in every cell.
            Err(Diagnostics(found)) => wrong.extend(found.into_iter().filter(|one| !wrong.contains(one)).collect::<Vec<_>>()),
        }
        if wrong.len() > 20 {
            break;
        }
    }
    if !wrong.is_empty() {
        return Err(Diagnostics(wrong));
    }
    let Some(Scenario { name, about, seed, .. }) = cells.first().map(|cell| cell.scenario.clone()) else {
        let finding = Finding::new(Span::default(), "the grid has no cells").help("give each of its fields a value at least");
        return fail(&typed, vec![finding]);
    };
    Ok(AccuracyFile { name, about, seed, pipelines, poses, cells, pass })
}

/// The cell of this number: the last field of the grid varies fastest.
fn cell(typed: &mut Typed, root: &Table, factors: &[Factor], index: usize) -> Result<Cell, Diagnostics> {
    typed.root = root.clone();
    let mut rest = index;
    let mut values = Vec::new();
    for factor in factors.iter().rev() {
        let node = &factor.levels[rest % factor.levels.len()];
        rest /= factor.levels.len();
        if let Err(finding) = overlay::lay(&mut typed.root, &factor.path, factor.span, node.clone()) {
            return Err(Diagnostics::from_findings(vec![finding], &typed.sources));
        }
        let text = typed.sources.text(node.span.source).get(node.span.start..node.span.end).unwrap_or_default();
        values.push((factor.path.clone(), text.trim_matches('"').to_owned()));
    }
    values.reverse();
    Ok(Cell { values, scenario: resolve::resolve(typed)? })
}

impl Table {
    /// Takes an entry out.
    fn take(&mut self, key: &str) -> Option<super::tree::Entry> {
        let index = self.entries.iter().position(|entry| entry.key == key)?;
        Some(self.entries.remove(index))
    }
}

/// The word of [`fields::KIND`] for these files.
const KIND: &str = "accuracy";

#[cfg(test)]
mod tests;
