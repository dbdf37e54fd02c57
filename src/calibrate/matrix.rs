//! Matrices T in files, in table 1's form: a row a laser, `laser,t11,t12, … ,t43`.

use std::path::Path;

use nalgebra::Matrix4x3;

use super::table::Table;
use crate::scenario::Diagnostics;

/// Columns of T, row by row.
pub const COLUMNS: [&str; 12] = ["t11", "t12", "t13", "t21", "t22", "t23", "t31", "t32", "t33", "t41", "t42", "t43"];
const LASER: &str = "laser";

/// Reads T from a file; where it holds several, that of `laser`.
///
/// # Errors
/// Everything that is wrong with the file's form, a choice that it does not leave or that names none, and a T without depth.
pub fn read(path: &Path, laser: Option<&str>) -> Result<Matrix4x3<f64>, Diagnostics> {
    of(&Table::read(path)?, laser)
}

/// Reads T from a text; errors name it `file`.
///
/// # Errors
/// As [`read`].
pub fn parse(file: &str, text: &str, laser: Option<&str>) -> Result<Matrix4x3<f64>, Diagnostics> {
    of(&Table::parse(file, text)?, laser)
}

/// T as such a file, with all digits.
pub fn to_csv(laser: &str, t: &Matrix4x3<f64>) -> String {
    let values: Vec<String> = t.transpose().iter().map(|value| format!("{value:?}")).collect();
    let quoted = if laser.contains([',', '"', '#']) { format!("\"{}\"", laser.replace('"', "\"\"")) } else { laser.to_owned() };
    format!(
        "# T from pixel (u, v, 1) to s (x, y, z, 1) in millimetres, row by row, with t43 = 1\n{LASER},{}\n{quoted},{}\n",
        COLUMNS.join(","),
        values.join(",")
    )
}

fn of(table: &Table, laser: Option<&str>) -> Result<Matrix4x3<f64>, Diagnostics> {
    let rows = table.numbers(COLUMNS)?;
    let names = if table.has(LASER) { table.texts(LASER)? } else { vec![""; rows.len()] };
    let known = || Some(format!("lasers here: {}", names.join(", ")));
    let wrong = |message: String, help| Err(Diagnostics(vec![table.error_of_all(message, help)]));
    let row = match (laser, rows.len()) {
        (_, 0) => return wrong("holds no T".into(), Some("a row a laser below the line of names".into())),
        (None, 1) => 0,
        (None, count) => return wrong(format!("holds {count} matrices: choose one by --laser"), known()),
        (Some(laser), _) => match names.iter().position(|name| *name == laser) {
            Some(row) => row,
            None => return wrong(format!("holds no T of laser `{laser}`"), known()),
        },
    };
    let t = Matrix4x3::from_row_slice(&rows[row]);
    if t.row(3).iter().all(|value| *value == 0.0) {
        let message = "t41, t42 and t43 are all zero: such a T gives no position".into();
        return Err(Diagnostics(vec![table.error(row, message, None)]));
    }
    Ok(t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_is_read_as_it_was_written() {
        let t = Matrix4x3::from_fn(|i, j| 0.1 + (i * 3 + j) as f64 / 7.0);
        for laser in ["right", "a, \"b\""] {
            assert_eq!(parse("t.csv", &to_csv(laser, &t), Some(laser)).expect("T"), t);
            assert_eq!(parse("t.csv", &to_csv(laser, &t), None).expect("T"), t);
        }
    }

    #[test]
    fn a_choice_is_asked_for_and_must_be_there() {
        let line = |name: &str| format!("{name},1,2,3,4,5,6,7,8,9,10,11,1\n");
        let text = format!("laser,{}\n{}{}", COLUMNS.join(","), line("right"), line("left"));
        assert!(parse("t.csv", &text, Some("left")).is_ok());
        for (laser, words) in [(None, "choose one by --laser"), (Some("up"), "no T of laser `up`")] {
            let error = parse("t.csv", &text, laser).expect_err("refused").0.remove(0);
            assert!(error.message.contains(words), "{error:?}");
            assert_eq!(error.help.as_deref(), Some("lasers here: right, left"));
        }
        let flat = format!("{}\n1,2,3,4,5,6,7,8,9,0,0,0\n", COLUMNS.join(","));
        let error = parse("t.csv", &flat, None).expect_err("refused").0.remove(0);
        assert_eq!(error.place.map(|place| place.line), Some(2));
    }
}
