//! Regions of interest: of one for all pictures, or of a table with a row for each.
//!
//! A table is CSV: lines that start with `#` are comments, the first other line names the columns. `file` is the picture's name, without
//! its folders; each column whose name ends in `_u` is a corner's, with the one of the same name and `_v`. Other columns are left alone.

use std::collections::BTreeMap;
use std::path::Path;

use ductloop_nav::perception::ridge::Region;

use super::problem::Problem;

/// Where to look.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Regions {
    /// Everywhere.
    Whole,
    /// In the same region of every picture.
    One(Region),
    /// In a region of its own, by the picture's name.
    Each(BTreeMap<String, Region>),
}

impl Regions {
    /// The region of a picture.
    pub(crate) fn of(&self, image: &Path) -> Option<Region> {
        match self {
            Self::Whole => None,
            Self::One(region) => Some(region.clone()),
            Self::Each(rows) => rows.get(image.file_name()?.to_str()?).cloned(),
        }
    }
}

/// Reads what was typed behind `--roi`, or the table that `--rois` names.
///
/// # Errors
/// What is wrong with either, with its place.
pub(crate) fn read(roi: Option<&str>, rois: Option<&Path>) -> Result<Regions, Problem> {
    if let Some(text) = roi {
        let region = of_argument(text).map_err(|message| {
            let help = "a rectangle as in `--roi 100,50,500,400`, a polygon as in `--roi 100,50,500,60,480,400`";
            Problem::new(Problem::WRONG_INPUT, message).about(format!("--roi {text}")).help(help)
        })?;
        return Ok(Regions::One(region));
    }
    let Some(path) = rois else { return Ok(Regions::Whole) };
    let wrong = |line: Option<usize>, message: String| {
        let line = line.map_or(String::new(), |line| format!(":{line}"));
        Problem::new(Problem::WRONG_INPUT, message).about(format!("--rois {}{line}", path.display()))
    };
    let text = std::fs::read_to_string(path).map_err(|error| wrong(None, format!("cannot be read: {error}")))?;
    let rows = of_table(&text).map_err(|(line, message)| {
        wrong(line, message).help("columns `file`, and for each corner NAME_u and NAME_v, in the polygon's order")
    })?;
    Ok(Regions::Each(rows))
}

fn of_argument(text: &str) -> Result<Region, String> {
    let numbers = text.split(',').map(number).collect::<Result<Vec<_>, _>>()?;
    let corners: Vec<[f64; 2]> = numbers.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect();
    let region = match corners[..] {
        [a, b] if numbers.len() == 4 => Region::rectangle(a, b),
        _ if numbers.len().is_multiple_of(2) => Region::polygon(&corners),
        _ => None,
    };
    region.ok_or_else(|| format!("{} numbers are neither a rectangle (4) nor a polygon (6, 8, 10, …)", numbers.len()))
}

fn number(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|value| value.is_finite() && value.abs() <= 1e6);
    value.ok_or_else(|| format!("`{}` is not a number of pixels", text.trim()))
}

/// The regions of a table, or the line, if it is about one, and what is wrong.
fn of_table(text: &str) -> Result<BTreeMap<String, Region>, (Option<usize>, String)> {
    let mut lines =
        text.lines().enumerate().map(|(i, line)| (i + 1, line.trim())).filter(|(_, l)| !l.is_empty() && !l.starts_with('#'));
    let Some((heading, names)) = lines.next() else { return Err((None, "the table is empty".into())) };
    let names: Vec<&str> = names.split(',').map(str::trim).collect();
    let column = |name: &str| names.iter().position(|other| *other == name);
    let Some(file) = column("file") else { return Err((Some(heading), "there is no column `file`".into())) };
    let mut corners = Vec::new();
    for (u, name) in names.iter().enumerate() {
        let Some(corner) = name.strip_suffix("_u") else { continue };
        let Some(v) = column(&format!("{corner}_v")) else {
            return Err((Some(heading), format!("there is a column `{name}`, but no `{corner}_v`")));
        };
        corners.push([u, v]);
    }
    if corners.len() < 3 {
        return Err((Some(heading), format!("it has the columns of {} corners; a region has three or more", corners.len())));
    }
    let mut rows = BTreeMap::new();
    for (line, row) in lines {
        let cells: Vec<&str> = row.split(',').map(str::trim).collect();
        if cells.len() != names.len() {
            return Err((Some(line), format!("{} values for {} columns", cells.len(), names.len())));
        }
        let corner = |[u, v]: &[usize; 2]| Ok([number(cells[*u])?, number(cells[*v])?]);
        let outline = corners.iter().map(corner).collect::<Result<Vec<_>, _>>().map_err(|message| (Some(line), message))?;
        let Some(region) = Region::polygon(&outline) else { return Err((Some(line), "no polygon".into())) };
        if rows.insert(cells[file].to_owned(), region).is_some() {
            return Err((Some(line), format!("`{}` has a row already", cells[file])));
        }
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn rectangles_and_polygons_may_be_typed() {
        assert_eq!(of_argument("1,2, 30,40"), Ok(Region::rectangle([1.0, 2.0], [30.0, 40.0]).expect("finite")));
        let polygon = Region::polygon(&[[1.0, 2.0], [30.0, 2.5], [20.0, -40.0]]).expect("finite");
        assert_eq!(of_argument("1,2,30,2.5,20,-40"), Ok(polygon));
        for wrong in ["", "1", "1,2", "1,2,3", "1,2,3,4,5", "1,2,3,x", "1,2,3,inf", "1,2,3,1e300"] {
            assert!(of_argument(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn tables_have_a_row_a_picture_and_errors_a_line() {
        let table = "# comment\n\nfile,n_x,a_u,a_v,b_u,b_v,c_u,c_v\n0.jpg,0.5,1,2,3,4,5,7\n1.jpg,0.5,1,2,3,4,5,6.5\n";
        let rows = of_table(table).expect("a table");
        assert_eq!(rows.keys().collect::<Vec<_>>(), ["0.jpg", "1.jpg"]);
        assert_eq!(rows["1.jpg"], Region::polygon(&[[1.0, 2.0], [3.0, 4.0], [5.0, 6.5]]).expect("finite"));
        let of = |path: &str| Regions::Each(rows.clone()).of(path.as_ref());
        assert!(of("photos/0.jpg").is_some() && of("2.jpg").is_none());
        for (from, to, line) in [
            ("file", "name", Some(3)),
            ("a_v", "a_w", Some(3)),
            ("a_u,a_v", "k,l", Some(3)),
            ("1,2,3,4,5,7", "1,2,3,4,5", Some(4)),
            ("6.5", "nan", Some(5)),
            ("1.jpg", "0.jpg", Some(5)),
            (table, "# nothing\n", None),
        ] {
            assert_eq!(of_table(&table.replacen(from, to, 1)).expect_err(to).0, line, "{to}");
        }
    }

    proptest! {
        #[test]
        fn any_text_is_a_region_or_an_error(argument in "[-0-9.,e ]{0,40}", table in "(file|a_u|a_v|b_u|b_v|c_u|c_v|[0-9]|,|\n|.){0,60}") {
            let _ = of_argument(&argument);
            let _ = of_table(&table);
        }
    }
}
