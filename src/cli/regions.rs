//! Regions of interest: of one for all pictures, or of a table with a row for each.
//!
//! A table is CSV as all of this project's are ([`ductloop::calibrate::table`]). `file` is the picture's name, without its
//! folders; each column whose name ends in `_u` is a corner's, with the one of the same name and `_v`. Other columns are left alone.

use std::collections::BTreeMap;
use std::path::Path;

use ductloop::calibrate::table::Table;
use ductloop::scenario::{Diagnostics, shown};
use ductloop_nav::perception::ridge::Region;

use super::problem::Problem;

/// Farthest that a corner may lie from a picture, in pixels.
const FARTHEST_PX: f64 = 1e6;

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
    let rows = Table::read(path).and_then(|table| of_table(&table)).map_err(|wrong| Problem::in_files(vec![wrong]))?;
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
    let value = text.trim().parse::<f64>().ok().filter(|value| value.is_finite() && value.abs() <= FARTHEST_PX);
    value.ok_or_else(|| format!("`{}` is not a number of pixels", text.trim()))
}

/// The regions of a table, by the pictures' names.
fn of_table(table: &Table) -> Result<BTreeMap<String, Region>, Diagnostics> {
    const HELP: &str = "columns `file`, and for each corner NAME_u and NAME_v, in the polygon's order";
    let of_names = |message: String| Diagnostics(vec![table.error_of_names(message, Some(HELP.into()))]);
    let files = table.texts("file")?;
    let names: Vec<&str> = table.names().filter_map(|name| name.strip_suffix("_u")).collect();
    if names.len() < 3 {
        let message = format!("it has the columns of {} corners; a region has three or more", names.len());
        return Err(of_names(message));
    }
    let mut corners = Vec::new();
    for name in &names {
        let (u, v) = (format!("{name}_u"), format!("{name}_v"));
        if !table.has(&v) {
            return Err(of_names(format!("there is a column `{u}`, but no `{v}`")));
        }
        corners.push(table.numbers([&u, &v])?);
    }
    let mut rows = BTreeMap::new();
    for (row, file) in files.into_iter().enumerate() {
        let wrong = |message: String, help: &str| Diagnostics(vec![table.error(row, message, Some(help.into()))]);
        let outline: Vec<[f64; 2]> = corners.iter().map(|corner| corner[row]).collect();
        let far = outline.iter().flatten().find(|value| value.abs() > FARTHEST_PX);
        if let Some(far) = far {
            return Err(wrong(format!("{} is not a number of pixels", shown(*far)), HELP));
        }
        let Some(region) = Region::polygon(&outline) else { return Err(wrong("no polygon".into(), HELP)) };
        if rows.insert(file.to_owned(), region).is_some() {
            return Err(wrong(format!("`{file}` has a row already"), "a picture has one region"));
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
        let text =
            "\u{feff}# comment\n\nfile,n_x,a_u,a_v,b_u,b_v,c_u,c_v\n0.jpg,0.5,1,2,3,4,5,7\n\"1,a.jpg\",0.5,1,2,3,4,5,6.5\n";
        let of_text = |text: &str| Table::parse("rois.csv", text).and_then(|table| of_table(&table));
        let rows = of_text(text).expect("a table");
        assert_eq!(rows.keys().collect::<Vec<_>>(), ["0.jpg", "1,a.jpg"]);
        assert_eq!(rows["1,a.jpg"], Region::polygon(&[[1.0, 2.0], [3.0, 4.0], [5.0, 6.5]]).expect("finite"));
        let of = |path: &str| Regions::Each(rows.clone()).of(path.as_ref());
        assert!(of("photos/0.jpg").is_some() && of("2.jpg").is_none());
        for (from, to, line) in [
            ("file", "name", Some(3)),
            ("a_v", "a_w", Some(3)),
            ("a_u,a_v", "k,l", Some(3)),
            ("1,2,3,4,5,7", "1,2,3,4,5", Some(4)),
            ("6.5", "nan", Some(5)),
            ("6.5", "2e6", Some(5)),
            ("\"1,a.jpg\"", "0.jpg", Some(5)),
            (text, "# nothing\n", None),
        ] {
            let wrong = of_text(&text.replacen(from, to, 1)).expect_err(to).0.remove(0);
            assert_eq!((wrong.file.as_str(), wrong.place.map(|place| place.line)), ("rois.csv", line), "{to}");
        }
    }

    proptest! {
        #[test]
        fn any_text_is_a_region_or_an_error(argument in "[-0-9.,e ]{0,40}", table in "(file|a_u|a_v|b_u|b_v|c_u|c_v|[0-9]|,|\n|.){0,60}") {
            let _ = of_argument(&argument);
            let _ = Table::parse("any.csv", &table).and_then(|table| of_table(&table));
        }
    }
}
